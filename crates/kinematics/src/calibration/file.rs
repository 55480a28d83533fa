//! The calibration file: reading, strictly, and writing, so that the same bits come back.

use std::fmt::Write as _;
use std::path::Path;

use super::{Calibration, CalibrationError, TABLE};
use crate::dh::DhTable;
use crate::joint::DOF;

/// A calibration file larger than this is refused, bytes.
const SIZE_MAX: usize = 1 << 20;

const FILE_SCOPE: &str = "the file";
const TABLE_SCOPE: &str = "[modified_dh]";

impl Calibration {
    /// From numbers, for a model as `--model` takes it; what errors call it is `path`.
    ///
    /// # Errors
    /// [`CalibrationError::Value`] for a number that is not finite.
    pub fn new(
        model: &str,
        modified_dh: DhTable,
        theta: [f64; DOF],
        path: &Path,
    ) -> Result<Self, CalibrationError> {
        let rows = [
            ("a", &modified_dh.a),
            ("d", &modified_dh.d),
            ("alpha", &modified_dh.alpha),
            ("theta", &theta),
        ];
        for (key, values) in rows {
            if let Some(element) = values.iter().position(|value| !value.is_finite()) {
                return Err(CalibrationError::Value {
                    path: path.to_owned(),
                    place: TABLE_SCOPE,
                    key: format!("{key}[{element}]"),
                    given: values[element].to_string(),
                    allowed: "finite numbers are needed".to_owned(),
                });
            }
        }
        Ok(Self {
            model: model.to_owned(),
            modified_dh,
            theta,
            path: path.to_owned(),
        })
    }

    /// Reads and checks a file.
    ///
    /// # Errors
    /// [`CalibrationError`] names the file, the table, the key and what is allowed.
    pub fn load(path: &Path) -> Result<Self, CalibrationError> {
        let text = crate::text_file::read_text_file(path).map_err(|source| {
            CalibrationError::Unreadable {
                path: path.to_owned(),
                source,
            }
        })?;
        Self::from_text(&text, path)
    }

    /// Checks the text of a file; `path` is what errors call it.
    ///
    /// # Errors
    /// The errors of [`Self::load`].
    pub fn from_text(text: &str, path: &Path) -> Result<Self, CalibrationError> {
        let syntax = |line: usize, message: String| CalibrationError::Syntax {
            path: path.to_owned(),
            line,
            message,
        };
        if text.len() > SIZE_MAX {
            let message = format!("{} bytes, {SIZE_MAX} are allowed", text.len());
            return Err(syntax(1, message));
        }
        let whole: toml::Table = text.parse().map_err(|error: toml::de::Error| {
            let upto = error.span().map_or(0, |span| span.start);
            let line = 1 + text.bytes().take(upto).filter(|b| *b == b'\n').count();
            syntax(line, error.message().replace('\n', ", "))
        })?;
        let reader = ErrorContext { path };
        reader.known(
            &whole,
            FILE_SCOPE,
            &["model", TABLE],
            "model and [modified_dh]",
        )?;
        let model = match whole.get("model") {
            Some(toml::Value::String(model)) if !model.trim().is_empty() => model.as_str(),
            Some(other) => {
                return Err(reader.value(
                    FILE_SCOPE,
                    "model",
                    other,
                    "a name as \"cs66\" is needed",
                ));
            }
            None => {
                return Err(reader.missing(
                    FILE_SCOPE,
                    "model",
                    "it says which arm was measured, as model = \"cs66\"",
                ));
            }
        };
        let table = match whole.get(TABLE) {
            Some(toml::Value::Table(table)) => table,
            Some(other) => {
                let allowed = "a table with a, d, alpha and optionally theta is needed";
                return Err(reader.value(FILE_SCOPE, TABLE, other, allowed));
            }
            None => {
                return Err(reader.missing(
                    FILE_SCOPE,
                    TABLE,
                    "the table with a, d, alpha and optionally theta is needed",
                ));
            }
        };
        let keys = ["a", "d", "alpha", "theta"];
        reader.known(
            table,
            TABLE_SCOPE,
            &keys,
            "a, d, alpha and optionally theta",
        )?;
        let modified_dh = DhTable {
            a: reader.six(table, "a", "six lengths in m")?,
            d: reader.six(table, "d", "six lengths in m")?,
            alpha: reader.six(table, "alpha", "six angles in rad")?,
        };
        let theta = match table.contains_key("theta") {
            true => reader.six(table, "theta", "six angles in rad")?,
            false => [0.0; DOF],
        };
        Self::new(model, modified_dh, theta, path)
    }

    /// The text of a file that reads back to the same numbers, bit for bit.
    pub fn to_toml(&self) -> String {
        let model = toml::Value::String(self.model.clone());
        let mut text = format!("model = {model}\n\n[{TABLE}]\n");
        let rows = [
            ("a", &self.modified_dh.a),
            ("d", &self.modified_dh.d),
            ("alpha", &self.modified_dh.alpha),
            ("theta", &self.theta),
        ];
        for (key, values) in rows {
            // `{:?}` writes the shortest form with a point or an exponent, which TOML needs of a float. Writing to a
            // String cannot fail.
            let _ = writeln!(text, "{key} = {values:?}");
        }
        text
    }
}

/// Makes errors of a file.
struct ErrorContext<'a> {
    path: &'a Path,
}

impl ErrorContext<'_> {
    fn known(
        &self,
        table: &toml::Table,
        place: &'static str,
        keys: &[&str],
        allowed: &'static str,
    ) -> Result<(), CalibrationError> {
        match table.keys().find(|key| !keys.contains(&key.as_str())) {
            Some(key) => Err(CalibrationError::UnknownKey {
                path: self.path.to_owned(),
                place,
                key: key.clone(),
                allowed,
            }),
            None => Ok(()),
        }
    }

    fn value(
        &self,
        place: &'static str,
        key: impl Into<String>,
        given: &toml::Value,
        allowed: impl Into<String>,
    ) -> CalibrationError {
        CalibrationError::Value {
            path: self.path.to_owned(),
            place,
            key: key.into(),
            given: given.to_string().replace('\n', " "),
            allowed: allowed.into(),
        }
    }

    fn missing(
        &self,
        place: &'static str,
        key: &'static str,
        allowed: impl Into<String>,
    ) -> CalibrationError {
        CalibrationError::Missing {
            path: self.path.to_owned(),
            place,
            key,
            allowed: allowed.into(),
        }
    }

    fn six(
        &self,
        table: &toml::Table,
        key: &'static str,
        what: &str,
    ) -> Result<[f64; DOF], CalibrationError> {
        let Some(given) = table.get(key) else {
            return Err(self.missing(TABLE_SCOPE, key, format!("{what} are needed")));
        };
        let toml::Value::Array(items) = given else {
            return Err(self.value(
                TABLE_SCOPE,
                key,
                given,
                format!("a list of {what} is needed"),
            ));
        };
        if items.len() != DOF {
            let allowed = format!("{what} are needed, these are {}", items.len());
            return Err(self.value(TABLE_SCOPE, key, given, allowed));
        }
        let mut numbers = [0.0; DOF];
        for (element, (number, item)) in numbers.iter_mut().zip(items).enumerate() {
            *number = match item {
                toml::Value::Float(number) => *number,
                #[expect(clippy::cast_precision_loss, reason = "a whole number of metres")]
                toml::Value::Integer(number) => *number as f64,
                other => {
                    let key = format!("{key}[{element}]");
                    return Err(self.value(TABLE_SCOPE, key, other, "a number is needed"));
                }
            };
        }
        Ok(numbers)
    }
}
