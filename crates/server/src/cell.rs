//! The cell file: what stands around the arm and what its limits are (TOML).
//!
//! Owns the schema and the sentences about what is wrong in a file. Everything of the schema is read and checked; what
//! the controller cannot act on yet is refused by name instead of being ignored.

use std::io;
use std::path::{Path, PathBuf};

use kinematics::{JointAccelerations, JointJerks, JointPositions, JointSpeeds};
use motion::LimitOverrides;
use serde::Deserialize;
use thiserror::Error;

mod point;

pub use point::PointName;

/// What is wrong with a cell file.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum CellError {
    /// It cannot be read.
    #[error("cannot read the cell file {}: {source}", path.display())]
    Unreadable {
        /// Which.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// A key, a name or a value is wrong.
    #[error("{} line {line}: {message}", path.display())]
    Wrong {
        /// Which file.
        path: PathBuf,
        /// Line from 1.
        line: usize,
        /// What the parser says: the key, what was given, what is allowed.
        message: String,
    },
    /// Something the controller cannot act on yet.
    #[error("{}: {what} is not available in this version; remove it to start without it", path.display())]
    NotAvailable {
        /// Which file.
        path: PathBuf,
        /// The table or key.
        what: &'static str,
    },
}

/// A cell file as read.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Tables {
    #[serde(default)]
    obstacle: Vec<Obstacle>,
    tool: Option<Tool>,
    #[serde(default)]
    safety_plane: Vec<SafetyPlane>,
    #[serde(default)]
    limits: Limits,
    sensor: Option<Sensor>,
    #[serde(default)]
    wrench: Vec<ExternalWrench>,
    #[serde(default)]
    conveyor: Vec<Conveyor>,
    #[serde(default)]
    wire: Vec<Wire>,
    #[serde(default)]
    input: Vec<Input>,
    #[serde(default)]
    serial: Vec<Serial>,
    #[serde(default)]
    modbus: Vec<toml::Table>,
}

/// `[limits]`: all optional, never above the model's own.
#[derive(Clone, Copy, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct Limits {
    joint_speed: Option<[f64; 6]>,
    joint_acceleration: Option<[f64; 6]>,
    joint_jerk: Option<[f64; 6]>,
    joint_position_min: Option<[f64; 6]>,
    joint_position_max: Option<[f64; 6]>,
    tcp_speed: Option<f64>,
    elbow_speed: Option<f64>,
    tcp_force: Option<f64>,
}

// The tables below are read so that a misspelled key is found today and not when the feature comes.

#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Shape {
    Box,
    Cylinder,
    Sphere,
    Plane,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "checked for form; acted on by the contact model")]
struct Obstacle {
    name: String,
    shape: Shape,
    #[serde(default)]
    size: Vec<f64>,
    pose: [f64; 6],
    stiffness: Option<f64>,
    damping: Option<f64>,
    friction: Option<f64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "checked for form; acted on by the contact model")]
struct Tool {
    shape: Shape,
    #[serde(default)]
    size: Vec<f64>,
    pose: [f64; 6],
}

#[derive(Debug, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum PlaneMode {
    #[default]
    Normal,
    Reduced,
    Both,
    Off,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "checked for form; acted on by the safety planes")]
struct SafetyPlane {
    name: String,
    point: [f64; 3],
    normal: [f64; 3],
    #[serde(default)]
    mode: PlaneMode,
    ci_pair: Option<u8>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "checked for form; acted on by the force sensor")]
struct Sensor {
    #[serde(default)]
    force_noise: f64,
    #[serde(default)]
    torque_noise: f64,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Frame {
    Base,
    Tool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "checked for form; acted on by the plant")]
struct ExternalWrench {
    at: f64,
    duration: f64,
    wrench: [f64; 6],
    frame: Option<Frame>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "checked for form; acted on by conveyor tracking")]
struct Conveyor {
    encoder: u8,
    direction: Option<[f64; 3]>,
    center: Option<[f64; 6]>,
    speed: f64,
    ticks_per_meter: Option<f64>,
    ticks_per_revolution: Option<f64>,
    #[serde(default)]
    start_at: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "checked for form; acted on by the I/O image")]
struct Wire {
    from: PointName,
    to: PointName,
    #[serde(default)]
    delay: f64,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "checked for form; acted on by the I/O image")]
struct Input {
    at: f64,
    set: PointName,
    value: toml::Value,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
enum SerialPort {
    Tool,
    Masterboard,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
#[allow(dead_code, reason = "checked for form; acted on by the serial builtins")]
struct Serial {
    port: SerialPort,
    device: String,
}

/// A cell file that was read and checked.
#[derive(Debug)]
pub struct Cell {
    text: String,
    limits: LimitOverrides,
}

impl Cell {
    /// Reads and checks a cell file.
    ///
    /// # Errors
    /// [`CellError`] names the file, the line and the key, or what is not available yet.
    pub fn load(path: &Path) -> Result<Self, CellError> {
        let text = std::fs::read_to_string(path)
            .map_err(|source| CellError::Unreadable { path: path.to_owned(), source })?;
        Self::parse(path, text)
    }

    fn parse(path: &Path, text: String) -> Result<Self, CellError> {
        let tables: Tables = toml::from_str(&text).map_err(|error| CellError::Wrong {
            path: path.to_owned(),
            line: error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count()),
            message: error.message().replace('\n', ", "),
        })?;
        if let Some(what) = not_available(&tables) {
            return Err(CellError::NotAvailable { path: path.to_owned(), what });
        }
        Ok(Self { limits: overrides(&tables.limits), text })
    }

    /// `[limits]`; whether they suit the arm is checked with the arm.
    pub fn limits(&self) -> LimitOverrides {
        self.limits
    }

    /// The file as written, for the recording.
    pub fn text(&self) -> &str {
        &self.text
    }
}

/// The first thing in the file that would have to be ignored.
fn not_available(tables: &Tables) -> Option<&'static str> {
    let used = [
        ("[[obstacle]]", !tables.obstacle.is_empty()),
        ("[tool]", tables.tool.is_some()),
        ("[[safety_plane]]", !tables.safety_plane.is_empty()),
        ("[sensor]", tables.sensor.is_some()),
        ("[[wrench]]", !tables.wrench.is_empty()),
        ("[[conveyor]]", !tables.conveyor.is_empty()),
        ("[[wire]]", !tables.wire.is_empty()),
        ("[[input]]", !tables.input.is_empty()),
        ("[[serial]]", !tables.serial.is_empty()),
        ("[[modbus]]", !tables.modbus.is_empty()),
        ("tcp_force in [limits]", tables.limits.tcp_force.is_some()),
    ];
    used.into_iter().find_map(|(name, is_used)| is_used.then_some(name))
}

fn overrides(limits: &Limits) -> LimitOverrides {
    LimitOverrides {
        joint_speed: limits.joint_speed.map(JointSpeeds),
        joint_acceleration: limits.joint_acceleration.map(JointAccelerations),
        joint_jerk: limits.joint_jerk.map(JointJerks),
        joint_position_min: limits.joint_position_min.map(JointPositions),
        joint_position_max: limits.joint_position_max.map(JointPositions),
        tcp_speed: limits.tcp_speed,
        elbow_speed: limits.elbow_speed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<Cell, CellError> {
        Cell::parse(Path::new("cell.toml"), text.to_owned())
    }

    #[test]
    fn limits_are_read() {
        let cell = parse("[limits]\ntcp_speed = 0.5\njoint_speed = [1, 1, 1, 2, 2, 2]\n").unwrap();
        assert_eq!(cell.limits().tcp_speed, Some(0.5));
        assert_eq!(cell.limits().joint_speed.unwrap().0, [1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    }

    #[test]
    fn a_misspelled_key_is_named_with_its_line_and_what_is_allowed() {
        let error = parse("[limits]\n\ntcp_sped = 0.5\n").unwrap_err().to_string();
        assert!(error.starts_with("cell.toml line 3: "), "{error}");
        assert!(error.contains("tcp_sped") && error.contains("tcp_speed"), "{error}");
        let error = parse("[[obstacles]]\nname = 'x'\n").unwrap_err().to_string();
        assert!(error.contains("obstacles") && error.contains("obstacle"), "{error}");
    }

    #[test]
    fn a_table_that_would_be_ignored_is_refused_by_name() {
        let wire = "[[wire]]\nfrom = 'standard_digital_out[3]'\nto = 'configurable_digital_in[2]'\n";
        let error = parse(wire).unwrap_err().to_string();
        assert!(error.contains("[[wire]] is not available"), "{error}");
    }

    #[test]
    fn a_bad_point_name_says_what_is_allowed() {
        let wire = "[[wire]]\nfrom = 'standard_digital_out[16]'\nto = 'standard_digital_in[0]'\n";
        let error = parse(wire).unwrap_err().to_string();
        assert!(error.contains("standard_digital_out[16]") && error.contains("0 to 15"), "{error}");
    }
}
