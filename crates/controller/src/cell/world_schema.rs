//! The tables of the cell file about parts and what handles them, as serde reads them.
//!
//! Keys that belong to one kind of an entry are optional here; which kind takes which is settled where they are
//! converted.

use serde::Deserialize;

use super::point::IoPointName;
use super::schema::{SerialPort, ShapeName, SixNumbers, Size};

/// `[world]`
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct WorldTable {
    /// Height of the floor, m.
    pub floor: Option<f64>,
    /// Longest step of the contact solver, s.
    pub substep: Option<f64>,
    /// Free-fall acceleration in the base frame, m/s².
    pub gravity: Option<[f64; 3]>,
}

/// `[[part]]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PartTable {
    /// Name of the part, or of its copies without their numbers.
    pub name: String,
    /// Shape of the part.
    pub shape: ShapeName,
    /// Lengths of the shape, m.
    #[serde(default)]
    pub size: Size,
    /// File of a mesh, relative to the folder of the cell file.
    pub file: Option<String>,
    /// Metres for a unit of that file.
    pub scale: Option<f64>,
    /// Most convex pieces of the mesh.
    pub pieces: Option<i64>,
    /// Mass, kg.
    pub mass: Option<f64>,
    /// Density, kg/m³.
    pub density: Option<f64>,
    /// Pose at the start; not needed for the template of a source.
    #[serde(default)]
    pub pose: SixNumbers,
    /// Coefficient of friction.
    pub friction: Option<f64>,
    /// Coefficient of restitution.
    pub restitution: Option<f64>,
    /// How many copies along each axis of the pose.
    pub copies: Option<[usize; 3]>,
    /// Distance of the copies, m.
    pub pitch: Option<[f64; 3]>,
    /// Colour in pictures, `#rrggbb`.
    pub color: Option<String>,
}

/// Kind of a gripper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum GripperKindName {
    /// Suction cups.
    Vacuum,
    /// Two parallel fingers.
    Fingers,
}

/// Where a gripper with a Modbus map is reached.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum GripperBus {
    /// A serial line of the controller.
    Serial(SerialPort),
    /// A Modbus TCP port on loopback.
    Tcp(u16),
}

/// A maker's Modbus map of a gripper.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum GripperProtocol {
    /// Robotiq 2F-85 and 2F-140.
    #[serde(rename = "robotiq-2f")]
    Robotiq2F,
    /// DH-Robotics AG.
    #[serde(rename = "dh-ag")]
    DhAg,
}

impl GripperProtocol {
    /// The word in the file.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Robotiq2F => "robotiq-2f",
            Self::DhAg => "dh-ag",
        }
    }
}

/// The shape of a finger.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FingerTable {
    /// Shape of the finger, a box where it is not given.
    #[serde(default)]
    pub shape: ShapeName,
    /// Lengths of the shape, m.
    #[serde(default)]
    pub size: Size,
    /// File of a mesh, relative to the folder of the cell file.
    pub file: Option<String>,
    /// Metres for a unit of that file.
    pub scale: Option<f64>,
    /// Most convex pieces of the mesh.
    pub pieces: Option<i64>,
    /// Pose in the flange frame when closed.
    pub pose: SixNumbers,
}

/// `[[gripper]]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GripperTable {
    /// Name of the gripper.
    pub name: String,
    /// Kind of the gripper.
    pub kind: GripperKindName,
    /// Middles of the rims of cups, flange frame, m.
    pub cups: Option<Vec<[f64; 3]>>,
    /// Direction of cups, flange frame.
    pub direction: Option<[f64; 3]>,
    /// Radius of a rim, m.
    pub radius: Option<f64>,
    /// Vacuum of the pump, Pa below ambient.
    pub pressure: Option<f64>,
    /// Largest gap that a rim seals over, m.
    pub reach: Option<f64>,
    /// Time constant of the pressure's rise, s.
    pub build_up: Option<f64>,
    /// Time constant of the pressure's fall, s.
    pub decay: Option<f64>,
    /// Output of the valve.
    pub on: Option<IoPointName>,
    /// Output that blows parts off.
    pub blow_off: Option<IoPointName>,
    /// Input of the vacuum switch.
    pub switch: Option<IoPointName>,
    /// Share of `pressure` at which the switch closes.
    pub threshold: Option<f64>,
    /// Analog input of the pressure.
    pub gauge: Option<IoPointName>,
    /// Opening between open fingers, m.
    pub stroke: Option<f64>,
    /// Direction of opening, flange frame.
    pub axis: Option<[f64; 3]>,
    /// The finger on the positive side.
    pub finger: Option<FingerTable>,
    /// Force of a finger, N.
    pub force: Option<f64>,
    /// Speed of a finger, m/s.
    pub speed: Option<f64>,
    /// Coefficient of friction of the fingers.
    pub friction: Option<f64>,
    /// Output that closes.
    pub close: Option<IoPointName>,
    /// Output that opens.
    pub open: Option<IoPointName>,
    /// Input: open.
    pub opened: Option<IoPointName>,
    /// Input: closed with nothing between.
    pub closed: Option<IoPointName>,
    /// Input: something is pressed.
    pub gripping: Option<IoPointName>,
    /// Modbus map instead of points.
    pub protocol: Option<GripperProtocol>,
    /// Line of the Modbus map: `tool`, `masterboard` or `tcp:PORT`.
    pub bus: Option<String>,
    /// Number of the slave.
    pub slave: Option<u8>,
}

impl GripperTable {
    /// The bus of a gripper with a Modbus map.
    pub fn modbus_bus(&self) -> Option<GripperBus> {
        self.protocol?;
        match self.bus.as_deref()? {
            "tool" => Some(GripperBus::Serial(SerialPort::Tool)),
            "masterboard" => Some(GripperBus::Serial(SerialPort::Masterboard)),
            other => {
                let port = other.strip_prefix("tcp:")?.parse().ok()?;
                (port > 0).then_some(GripperBus::Tcp(port))
            }
        }
    }

    /// Number of the slave: the makers' own where none is given.
    pub fn slave_number(&self) -> u8 {
        self.slave.unwrap_or(match self.protocol {
            Some(GripperProtocol::Robotiq2F) => 9,
            _ => 1,
        })
    }
}

/// `[[source]]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SourceTable {
    /// Name of the source.
    pub name: String,
    /// Name of the part that is the template.
    pub part: String,
    /// Place where parts appear.
    pub pose: SixNumbers,
    /// Period, s.
    pub every: Option<f64>,
    /// Point whose rising edge makes a part.
    pub when: Option<IoPointName>,
    /// Time of the first part at the earliest, s.
    #[serde(default)]
    pub start_at: f64,
    /// Largest number of parts.
    pub limit: Option<u32>,
    /// Standard deviations of the place, m and rad.
    #[serde(default)]
    pub scatter: SixNumbers,
}

/// `[[sink]]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SinkTable {
    /// Name of the sink.
    pub name: String,
    /// Middle of the box.
    pub pose: SixNumbers,
    /// Edges of the box, m.
    pub size: [f64; 3],
}

/// Kind of a detector.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum DetectorKindName {
    /// A light barrier.
    Beam,
    /// A region.
    Presence,
    /// A distance sensor.
    Distance,
}

/// `[[detector]]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DetectorTable {
    /// Name of the detector.
    pub name: String,
    /// Kind of the detector.
    pub kind: DetectorKindName,
    /// Input that the detector drives.
    pub to: IoPointName,
    /// Delay of the signal, s.
    #[serde(default)]
    pub delay: f64,
    /// Whether false means that something is there.
    #[serde(default)]
    pub inverted: bool,
    /// First end of a beam, m.
    pub from: Option<[f64; 3]>,
    /// Second end of a beam, m.
    pub until: Option<[f64; 3]>,
    /// Middle of a region, or where a distance is measured from.
    pub pose: Option<SixNumbers>,
    /// Edges of a region, m.
    pub size: Option<[f64; 3]>,
    /// Largest distance, m.
    pub range: Option<f64>,
}

/// Kind of an actuator.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ActuatorKindName {
    /// Along a line.
    Linear,
    /// About an axis.
    Rotary,
}

/// End of an actuator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ActuatorEnd {
    /// The near end.
    #[default]
    Retracted,
    /// The far end.
    Extended,
}

/// `[[actuator]]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActuatorTable {
    /// Name of the actuator.
    pub name: String,
    /// Kind of the actuator.
    pub kind: ActuatorKindName,
    /// Direction of extending, or of the axis, base frame.
    pub axis: [f64; 3],
    /// Way from end to end, m.
    pub stroke: Option<f64>,
    /// A point on the axis, m.
    pub point: Option<[f64; 3]>,
    /// Angle from end to end, rad.
    pub angle: Option<f64>,
    /// Names of obstacles that move with it.
    pub moves: Vec<String>,
    /// Time from end to end, s.
    pub time: Option<f64>,
    /// Largest force, N, or torque, Nm.
    pub force: Option<f64>,
    /// Output that extends.
    pub extend: IoPointName,
    /// Output that retracts.
    pub retract: Option<IoPointName>,
    /// Input: at the far end.
    pub extended: Option<IoPointName>,
    /// Input: at the near end.
    pub retracted: Option<IoPointName>,
    /// End at the start.
    #[serde(default)]
    pub at_start: ActuatorEnd,
}

/// `[[friction]]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionTable {
    /// Name of the first thing.
    pub a: String,
    /// Name of the second thing.
    pub b: String,
    /// Coefficient.
    pub value: f64,
}

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum FaultName {
    /// A part is not there.
    Missing,
    /// A part lies turned.
    Turned,
    /// A part falls out of its gripper.
    Drop,
    /// A gripper loses pressure or force.
    Leak,
    /// An input keeps its value.
    Stuck,
    /// An input is false or 0.
    Open,
    /// An actuator or conveyor does not move.
    Blocked,
    /// An actuator or conveyor has half of its speed.
    Slow,
}

impl FaultName {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Missing,
        Self::Turned,
        Self::Drop,
        Self::Leak,
        Self::Stuck,
        Self::Open,
        Self::Blocked,
        Self::Slow,
    ];

    /// The word in the file.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Missing => "missing",
            Self::Turned => "turned",
            Self::Drop => "drop",
            Self::Leak => "leak",
            Self::Stuck => "stuck",
            Self::Open => "open",
            Self::Blocked => "blocked",
            Self::Slow => "slow",
        }
    }

    /// Whether the name is that of an input.
    pub const fn is_of_input(self) -> bool {
        matches!(self, Self::Stuck | Self::Open)
    }
}

/// `[[fault]]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultTable {
    /// Time, s.
    pub at: Option<f64>,
    /// Point whose rising edge begins it.
    pub when: Option<IoPointName>,
    /// What goes wrong.
    pub what: FaultName,
    /// Name of the thing or of the input.
    pub name: String,
    /// Duration, s; for ever without it.
    pub duration: Option<f64>,
}
