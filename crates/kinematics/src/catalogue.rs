//! The CS arms that are built in, by name.
//!
//! Owns the list of names, those with public figures and those without. The figures themselves are in `robots/`.

use crate::model::RobotModel;
use crate::urdf::ModelError;
use std::path::Path;

/// Name and URDF of every arm with complete public figures.
const ARMS: [(&str, &str); 6] = [
    ("cs63", include_str!("../../../robots/cs63/cs63.urdf")),
    ("cs66", include_str!("../../../robots/cs66/cs66.urdf")),
    ("cs612", include_str!("../../../robots/cs612/cs612.urdf")),
    ("cs616", include_str!("../../../robots/cs616/cs616.urdf")),
    ("cs620", include_str!("../../../robots/cs620/cs620.urdf")),
    ("cs625", include_str!("../../../robots/cs625/cs625.urdf")),
];

/// CS and ES names for which a robot type number is public but no lengths, limits or masses.
const UNSUPPORTED_MODELS: [&str; 13] = [
    "cs68", "cs618", "cs630", "cs616-9", "cs66a", "cs610a", "cs612a", "cs66az", "cs612az", "cs56h",
    "cs520h", "cs525h", "cs530h",
];

impl RobotModel {
    /// Names of the built-in arms, smallest first.
    pub fn names() -> impl Iterator<Item = &'static str> {
        ARMS.iter().map(|(name, _)| *name)
    }

    /// A built-in arm by name; upper and lower case are the same.
    ///
    /// # Errors
    /// [`ModelError::UnknownName`] lists the names there are; [`ModelError::UnsupportedModel`] is for arms that exist
    /// but whose dimensions are not public.
    ///
    /// ```
    /// let arm = kinematics::RobotModel::built_in("cs66")?;
    /// assert_eq!(arm.type_number(), Some(6206));
    /// # Ok::<(), kinematics::ModelError>(())
    /// ```
    pub fn built_in(name: &str) -> Result<Self, ModelError> {
        let lower = name.to_ascii_lowercase();
        if let Some(urdf) = Self::built_in_urdf(name) {
            return Self::from_urdf(urdf);
        }
        let known = Self::names().collect::<Vec<_>>().join(", ");
        if UNSUPPORTED_MODELS.contains(&lower.as_str()) {
            return Err(ModelError::UnsupportedModel {
                name: name.to_owned(),
                known,
            });
        }
        Err(ModelError::UnknownName {
            name: name.to_owned(),
            known,
        })
    }

    /// The URDF of a built-in arm.
    pub fn built_in_urdf(name: &str) -> Option<&'static str> {
        let lower = name.to_ascii_lowercase();
        let found = ARMS.iter().find(|(known, _)| *known == lower);
        found.map(|(_, urdf)| *urdf)
    }

    /// What `--model` takes: the name of a built-in arm, or the path of a URDF file.
    ///
    /// Anything with a path separator or the extension `.urdf` or `.xml` is a path.
    ///
    /// # Errors
    /// The errors of [`Self::built_in`] or [`Self::from_urdf`], and [`ModelError::Unreadable`] for the file.
    pub fn open(name_or_path: &str) -> Result<Self, ModelError> {
        let path = Path::new(name_or_path);
        let is_path = name_or_path.contains(['/', '\\'])
            || path
                .extension()
                .is_some_and(|e| e.eq_ignore_ascii_case("urdf") || e.eq_ignore_ascii_case("xml"));
        if !is_path {
            return Self::built_in(name_or_path);
        }
        let text =
            crate::text_file::read_text_file(path).map_err(|source| ModelError::Unreadable {
                path: name_or_path.to_owned(),
                source,
            })?;
        Self::from_urdf(&text)
    }
}
