//! Arms as they were built: the lengths and twists that the maker measured, from a file or from a controller.
//!
//! Owns the calibration file (TOML), the sentences about what is wrong in it, and the chain that follows from its
//! numbers. How such a chain is inverted is the business of [`crate::ik`].

mod file;

use crate::elementary;
use messages::{Localized, Text, text};
use std::path::{Path, PathBuf};

use nalgebra::{Matrix3, Rotation3, Vector3};

use crate::chain::Chain;
use crate::dh::DhTable;
use crate::ik::IkMethod;
use crate::joint::DOF;
use crate::model::RobotModel;
use crate::pose::Pose;
use crate::trig;
use crate::urdf::ModelError;

/// How far a measured length may be from the model's own, m. The arm that is farthest known has a flange 20 mm longer;
/// between two models it is 60 mm at least.
pub const LENGTH_TOLERANCE: f64 = 0.05;

/// How far a measured angle may be from the model's own, rad.
pub const ANGLE_TOLERANCE: f64 = 0.1;

/// Name of the table in the file.
const TABLE: &str = "modified_dh";

/// The measured geometry of one arm, as a calibration file or the configuration message of port 30001 has it.
///
/// Joint i follows joint i-1 by T_i = Rx(alpha_i) Tx(a_i) Rz(q_i + theta_i) Tz(d_i): the modified layout of Craig,
/// *Introduction to Robotics*, with a and alpha of the link before.
#[derive(Clone, Debug, PartialEq)]
pub struct Calibration {
    model: String,
    modified_dh: DhTable,
    theta: [f64; DOF],
    /// What errors call it.
    path: PathBuf,
}

/// The part of a calibration file that an error is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error, Localized)]
pub enum CalibrationPart {
    /// The file outside of the table.
    #[error("the file")]
    #[zh("文件")]
    File,
    /// The table of numbers.
    #[error("[{TABLE}]")]
    Table,
}

/// A reason why there is no calibrated arm, told in one sentence.
#[derive(Debug, thiserror::Error, Localized)]
#[non_exhaustive]
pub enum CalibrationError {
    /// The file cannot be read.
    #[error("cannot read the calibration file {}: {source}", path.display())]
    #[zh("无法读取标定文件 {}：{source}", path.display())]
    Unreadable {
        /// The file as it was given.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The file is not TOML.
    #[error("{} line {line} is not TOML: {message}", path.display())]
    #[zh("{} 第 {line} 行不是 TOML：{message}", path.display())]
    Syntax {
        /// The calibration file.
        path: PathBuf,
        /// Line from 1.
        line: usize,
        /// What the parser says.
        message: Text,
    },
    /// A key or a table that does not exist.
    #[error("{}: {place} has an unknown key `{key}`; the keys are {allowed}", path.display())]
    #[zh("{}：{place}中有未知的键 `{key}`；可用的键为 {allowed}", path.display())]
    UnknownKey {
        /// The calibration file.
        path: PathBuf,
        /// The table, or the file.
        place: CalibrationPart,
        /// The key.
        key: String,
        /// What is allowed.
        allowed: Text,
    },
    /// A key or a table that must be there.
    #[error("{}: {place} has no `{key}`; {allowed}", path.display())]
    #[zh("{}：{place}中没有 `{key}`；{allowed}", path.display())]
    Missing {
        /// The calibration file.
        path: PathBuf,
        /// The table, or the file.
        place: CalibrationPart,
        /// The key.
        key: &'static str,
        /// What it is.
        allowed: Text,
    },
    /// A value that a key does not take.
    #[error("{}: {place} has {key} = {given}; {allowed}", path.display())]
    #[zh("{}：{place} 的 {key} = {given}；{allowed}", path.display())]
    Value {
        /// The calibration file.
        path: PathBuf,
        /// The table, or the file.
        place: CalibrationPart,
        /// The key; in an array, with the number of the element.
        key: String,
        /// The value.
        given: String,
        /// What is allowed.
        allowed: Text,
    },
    /// Another model than the one asked for.
    #[error(
        "the calibration file {} is for the model {calibrated}, but the model {asked} is asked for; \
         leave the model out, or give {calibrated}",
        path.display()
    )]
    #[zh("标定文件 {} 用于型号 {calibrated}，而要求的型号是 {asked}；请不给出型号，或给出 {calibrated}", path.display())]
    ModelMismatch {
        /// The calibration file.
        path: PathBuf,
        /// The model that was asked for.
        asked: String,
        /// The model of the file.
        calibrated: String,
    },
    /// The model cannot be had.
    #[error("{}: model = {given:?}: {source}", path.display())]
    #[zh("{}：model = {given:?}：{source}", path.display())]
    Model {
        /// The calibration file.
        path: PathBuf,
        /// The model's name as the file has it.
        given: String,
        /// What is wrong with that name.
        source: Box<ModelError>,
    },
    /// An arm of another shape.
    #[error(
        "{}: the model {model} cannot be calibrated, it is not of the shape of the CS arms \
         (axes 2, 3, 4 parallel, axes 4-5 and 5-6 crossing at right angles, flange in the frame of joint 6)",
        path.display()
    )]
    #[zh("{}：型号 {model} 不能标定，它不具有 CS 机械臂的结构（轴 2、3、4 平行，轴 4-5 和 5-6 垂直相交，法兰在关节 6 的坐标系中）", path.display())]
    UnsupportedGeometry {
        /// The calibration file.
        path: PathBuf,
        /// The model.
        model: String,
    },
}

impl Calibration {
    /// The model that was measured, as `--model` takes it.
    pub fn model(&self) -> &str {
        &self.model
    }

    /// Lengths in m and twists in rad in the modified layout.
    pub fn modified_dh(&self) -> &DhTable {
        &self.modified_dh
    }

    /// What each joint's angle is when the joint reads zero, rad.
    pub fn theta(&self) -> &[f64; DOF] {
        &self.theta
    }

    /// The file it was read from, or what else errors call it.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The model that counts: the file's.
    ///
    /// # Errors
    /// [`CalibrationError::ModelMismatch`] when another one is asked for.
    pub fn model_for(&self, asked: Option<&str>) -> Result<&str, CalibrationError> {
        match asked {
            Some(asked) if !asked.eq_ignore_ascii_case(&self.model) => {
                Err(CalibrationError::ModelMismatch {
                    path: self.path.clone(),
                    asked: asked.to_owned(),
                    calibrated: self.model.clone(),
                })
            }
            _ => Ok(&self.model),
        }
    }

    /// The calibrated arm: the file's model, opened and measured.
    ///
    /// # Errors
    /// The model cannot be had, or its numbers are far from those of the file.
    pub fn open(&self) -> Result<RobotModel, CalibrationError> {
        let nominal = RobotModel::open(&self.model).map_err(|source| CalibrationError::Model {
            path: self.path.clone(),
            given: self.model.clone(),
            source: Box::new(source),
        })?;
        nominal.calibrated(self)
    }

    fn value_error(&self, key: String, given: f64, allowed: Text) -> CalibrationError {
        CalibrationError::Value {
            path: self.path.clone(),
            place: CalibrationPart::Table,
            key,
            given: given.to_string(),
            allowed,
        }
    }

    /// Every number must be near the model's own. Joints 2, 3 and 4 turn about nearly parallel axes, so where along
    /// them the offset lies says little: their d count together.
    fn check_against(&self, model: &str, nominal: &DhTable) -> Result<(), CalibrationError> {
        let given = &self.modified_dh;
        let (lengths, angles) = ("m", "rad");
        for joint in 0..DOF {
            let alone = !(1..=3).contains(&joint);
            let rows = [
                ("a", given.a[joint], nominal.a[joint], lengths),
                ("alpha", given.alpha[joint], nominal.alpha[joint], angles),
                ("theta", self.theta[joint], 0.0, angles),
                ("d", given.d[joint], nominal.d[joint], lengths),
            ];
            for (key, value, own, unit) in rows.into_iter().take(if alone { 4 } else { 3 }) {
                let tolerance = if unit == lengths {
                    LENGTH_TOLERANCE
                } else {
                    ANGLE_TOLERANCE
                };
                if (value - own).abs() > tolerance {
                    let hint = hint(given, nominal, key, value, own, tolerance);
                    return Err(self.value_error(
                        format!("{key}[{joint}]"),
                        value,
                        text!(
"the {model} has {own} {unit} there, \
                             and a measured arm is within {tolerance} {unit} of it{hint}",
"{model} 在那里为 {own} {unit}，实测的机械臂与它相差不超过 {tolerance} {unit}{hint}"
                        ),
                    ));
                }
            }
        }
        let sum = |table: &DhTable| table.d[1] + table.d[2] + table.d[3];
        if (sum(given) - sum(nominal)).abs() > LENGTH_TOLERANCE {
            let own = sum(nominal);
            let hint = hint(given, nominal, "d", sum(given), own, LENGTH_TOLERANCE);
            return Err(self.value_error(
                "d[1] + d[2] + d[3]".to_owned(),
                sum(given),
                text!(
"the {model} has {own} m there, and a measured arm is within {LENGTH_TOLERANCE} m of it{hint}",
"{model} 在那里为 {own} m，实测的机械臂与它相差不超过 {LENGTH_TOLERANCE} m{hint}"
                ),
            ));
        }
        // What is shifted along one of these axes and back along a tilted one ends beside where it should.
        let mut along = 0.0;
        for joint in 1..=2 {
            along += given.d[joint] - nominal.d[joint];
            let beside = along * elementary::sin(given.alpha[joint + 1]);
            if along.abs() > 10.0 || beside.abs() > LENGTH_TOLERANCE {
                return Err(self.value_error(
                    format!("d[{joint}]"),
                    given.d[joint],
                    text!(
"with alpha[{}] = {} it puts the axis of joint {} {beside} m aside, \
                         and a measured arm is within {LENGTH_TOLERANCE} m",
"与 alpha[{}] = {} 一起使关节 {} 的轴线偏离 {beside} m，实测的机械臂不超过 {LENGTH_TOLERANCE} m",
                        joint + 1,
                        given.alpha[joint + 1],
                        joint + 2,
                    ),
                ));
            }
        }
        Ok(())
    }

    /// The chain, given the model's d: frames 2 and 3 stay where the model has them along their axes, so that masses
    /// and capsules are where the metal is, however the offset is shared among the three axes.
    fn chain(&self, nominal: &DhTable) -> Chain {
        let DhTable { a, d, alpha } = &self.modified_dh;
        let (sines, cosines) = trig::sin_cos(alpha);
        let (turn_sines, turn_cosines) = trig::sin_cos(&self.theta);
        // How far frame i is drawn back along its axis.
        let mut back = [0.0; DOF + 1];
        back[2] = d[1] - nominal.d[1];
        back[3] = back[2] + (d[2] - nominal.d[2]);
        let parent_from_joint = core::array::from_fn(|joint| {
            let (s, c) = (sines[joint], cosines[joint]);
            let twist = Matrix3::new(1.0, 0.0, 0.0, 0.0, c, -s, 0.0, s, c);
            let (s, c) = (turn_sines[joint], turn_cosines[joint]);
            let offset = Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
            let along = d[joint] - back[joint + 1];
            let before = Vector3::new(0.0, 0.0, back[joint]);
            let translation = before + twist * Vector3::new(a[joint], 0.0, along);
            Pose::new(
                Rotation3::from_matrix_unchecked(twist * offset),
                translation,
            )
        });
        Chain {
            parent_from_joint,
            joint6_from_flange: Pose::IDENTITY,
        }
    }
}

/// What probably went wrong, for the mistakes that are made.
fn hint(
    given: &DhTable,
    nominal: &DhTable,
    key: &str,
    value: f64,
    own: f64,
    tolerance: f64,
) -> Text {
    let near = |value: f64, own: f64| own != 0.0 && (value - own).abs() <= tolerance;
    match key {
        "a" | "d" if near(value / 1000.0, own) => {
            text!("; this looks like mm, m are needed", "；看来是 mm，需要 m")
        }
        "alpha" | "theta" if near(value.to_radians(), own) => {
            text!(
                "; this looks like degrees, rad are needed",
                "；看来是度，需要 rad"
            )
        }
        "a" if near(given.a[1], nominal.a[2]) => {
            text!(
                "; a looks like the standard layout, in the modified one it stands one place later",
                "；a 看来是标准 DH 的排列，在改进 DH 中要后移一位"
            )
        }
        "alpha" if near(given.alpha[0], nominal.alpha[1]) => {
            text!(
                "; alpha looks like the standard layout, in the modified one it stands one place later",
                "；alpha 看来是标准 DH 的排列，在改进 DH 中要后移一位"
            )
        }
        _ => Text::verbatim(""),
    }
}

impl RobotModel {
    /// This arm with measured lengths and twists instead of nominal ones; everything computed with it follows them.
    /// Whether the calibration belongs to this model is not checked here but in [`Calibration::model_for`].
    ///
    /// # Errors
    /// [`CalibrationError::UnsupportedGeometry`] for a URDF of another shape, [`CalibrationError::Value`] for numbers
    /// that are far from the model's own.
    pub fn calibrated(self, calibration: &Calibration) -> Result<Self, CalibrationError> {
        let Some(nominal) = self.dh().map(|table| table.modified()) else {
            return Err(CalibrationError::UnsupportedGeometry {
                path: calibration.path.clone(),
                model: self.name,
            });
        };
        calibration.check_against(&self.name, &nominal)?;
        let chain = calibration.chain(&nominal);
        Ok(Self {
            ik: IkMethod::of_calibrated(&chain, &calibration.theta),
            chain,
            calibration: Some(Box::new(calibration.clone())),
            ..self
        })
    }
}
