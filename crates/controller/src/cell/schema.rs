//! The tables of the cell file as types: what serde reads, keys and names included.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::point::IoPointName;
use super::world_schema::{
    ActuatorTable, DetectorTable, FaultTable, FrictionTable, GripperTable, PartTable, SinkTable,
    SourceTable, WorldTable,
};

/// Six numbers: a pose, a wrench, or one value a joint.
pub type SixNumbers = [f64; 6];

/// The whole file.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tables {
    /// What the arm can hit.
    pub obstacle: Vec<Obstacle>,
    /// What touches obstacles; without it the TCP does.
    pub tool: Option<Tool>,
    /// What may touch each other.
    pub touch: Vec<Touch>,
    /// Planes the arm may not cross.
    pub safety_plane: Vec<SafetyPlane>,
    /// Limits below the model's own.
    pub limits: Limits,
    /// Noise of the force sensor.
    pub sensor: Sensor,
    /// What really hangs on the flange.
    pub payload: Option<PayloadTable>,
    /// What the drives have to overcome.
    pub arm: Arm,
    /// Loads from outside.
    pub wrench: Vec<ExternalWrench>,
    /// Belts and turntables.
    pub conveyor: Vec<Conveyor>,
    /// Outputs connected to inputs.
    pub wire: Vec<Wire>,
    /// Inputs that change by themselves.
    pub input: Vec<ScheduledInput>,
    /// Inputs that mean something to the safety system.
    pub safety_input: Vec<SafetyInput>,
    /// Devices on the serial ports.
    pub serial: Vec<Serial>,
    /// Modbus signals to add at start.
    pub modbus: Vec<ModbusSignal>,
    /// What people call inputs and outputs, by point.
    pub names: BTreeMap<IoPointName, String>,
    /// Floor, gravity and steps of the world of parts.
    pub world: Option<WorldTable>,
    /// Free bodies.
    pub part: Vec<PartTable>,
    /// Grippers on the flange.
    pub gripper: Vec<GripperTable>,
    /// Places where parts appear.
    pub source: Vec<SourceTable>,
    /// Places where parts leave.
    pub sink: Vec<SinkTable>,
    /// Sensors that see parts.
    pub detector: Vec<DetectorTable>,
    /// Cylinders and the like, which move obstacles.
    pub actuator: Vec<ActuatorTable>,
    /// Friction between two things.
    pub friction: Vec<FrictionTable>,
    /// Things that go wrong.
    pub fault: Vec<FaultTable>,
}

/// The shape of an obstacle, a tool, a part or a finger.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ShapeName {
    /// `size` is x, y, z.
    #[default]
    Box,
    /// `size` is radius, length.
    Cylinder,
    /// `size` is the radius.
    Sphere,
    /// No size; the z axis of the pose is the normal.
    Plane,
    /// No size; `file` has it.
    Mesh,
}

impl ShapeName {
    /// Number of elements that `size` has for this shape.
    pub const fn numbers_of_size(self) -> usize {
        match self {
            Self::Box => 3,
            Self::Cylinder => 2,
            Self::Sphere => 1,
            Self::Plane | Self::Mesh => 0,
        }
    }
}

/// `size`, a number or a list of them, m.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(untagged, expecting = "`size` is a length in m or a list of lengths")]
pub enum Size {
    /// The size is not given.
    #[default]
    None,
    /// A radius.
    One(f64),
    /// Several lengths.
    Many(Vec<f64>),
}

impl Size {
    /// The numbers, in the order of [`ShapeName`].
    pub fn numbers(&self) -> &[f64] {
        match self {
            Self::None => &[],
            Self::One(number) => core::slice::from_ref(number),
            Self::Many(numbers) => numbers,
        }
    }
}

/// `[[obstacle]]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Obstacle {
    /// Name of the obstacle, for messages.
    pub name: String,
    /// Shape of the obstacle.
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
    /// Pose of the obstacle in the base frame.
    pub pose: SixNumbers,
    /// N/m; hard without it.
    pub stiffness: Option<f64>,
    /// N s/m.
    pub damping: Option<f64>,
    /// Coulomb's coefficient.
    pub friction: Option<f64>,
}

/// `[tool]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tool {
    /// Shape of the tool.
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
    /// Pose of the shape in the flange frame.
    pub pose: SixNumbers,
}

/// `[[touch]]`: a pair that may touch. Counts for clearances and paths, not for the simulation.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Touch {
    /// Name of one of the two, a `*` in it stands for any letters.
    pub a: String,
    /// Name of the other one.
    pub b: String,
}

/// Safety modes in which a plane counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PlaneMode {
    /// In normal mode.
    #[default]
    Normal,
    /// In reduced mode.
    Reduced,
    /// In normal and in reduced mode.
    Both,
    /// Never.
    Off,
}

impl PlaneMode {
    /// The word of the cell file.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Normal => "normal",
            Self::Reduced => "reduced",
            Self::Both => "both",
            Self::Off => "off",
        }
    }
}

/// `[[safety_plane]]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SafetyPlane {
    /// Name of the plane, for messages.
    pub name: String,
    /// A point on it, m.
    pub point: [f64; 3],
    /// Points to the allowed side.
    pub normal: [f64; 3],
    /// Safety modes in which the plane counts.
    #[serde(default)]
    pub mode: PlaneMode,
    /// The pair of configurable inputs that switches it.
    pub ci_pair: Option<u8>,
}

/// A table of limits: the quantities that `[limits]` and `[limits.reduced]` share, and what only one of them has.
macro_rules! limits {
    ($(#[$about:meta])* $table:ident { $($(#[$doc:meta])* $key:ident: $kind:ty,)* }) => {
        $(#[$about])*
        #[derive(Clone, Debug, Default, PartialEq, Deserialize)]
        #[serde(deny_unknown_fields, default)]
        pub struct $table {
            /// Largest speed of each joint, rad/s.
            pub joint_speed: Option<SixNumbers>,
            /// Largest acceleration of each joint, rad/s².
            pub joint_acceleration: Option<SixNumbers>,
            /// Largest jerk of each joint, rad/s³.
            pub joint_jerk: Option<SixNumbers>,
            /// Lowest position of each joint, rad.
            pub joint_position_min: Option<SixNumbers>,
            /// Highest position of each joint, rad.
            pub joint_position_max: Option<SixNumbers>,
            /// Largest speed of the TCP, m/s.
            pub tcp_speed: Option<f64>,
            /// Largest speed of the elbow, m/s.
            pub elbow_speed: Option<f64>,
            /// Largest force at the TCP, N.
            pub tcp_force: Option<f64>,
            $($(#[$doc])* pub $key: $kind,)*
        }
    };
}

limits! {
    /// `[limits]`
    Limits {
        /// Whether the arm is kept from running into itself.
        self_collision: Option<bool>,
        /// Limits that hold in reduced mode.
        reduced: ReducedLimits,
    }
}

limits! {
    /// `[limits.reduced]`
    ReducedLimits {}
}

/// `[sensor]`: standard deviations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sensor {
    /// Standard deviation of the force noise, N.
    pub force_noise: f64,
    /// Standard deviation of the torque noise, Nm.
    pub torque_noise: f64,
}

/// `[payload]`: what really hangs on the flange, whatever the controller is told.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PayloadTable {
    /// Mass, kg.
    pub mass: f64,
    /// Centre of gravity in the flange frame, m.
    #[serde(default)]
    pub cog: [f64; 3],
    /// Ixx, Iyy, Izz, Ixy, Ixz, Iyz about it, kg m².
    #[serde(default)]
    pub inertia: SixNumbers,
}

/// `[arm]`: what the drives have to overcome; the controller does not know it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Arm {
    /// Dry friction, Nm.
    pub coulomb: SixNumbers,
    /// Nm s/rad.
    pub viscous: SixNumbers,
    /// Inertia of the rotors about the joint axes, kg m².
    pub rotor_inertia: SixNumbers,
}

/// Frame in which a load is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum LoadFrame {
    /// The base's.
    #[default]
    Base,
    /// The tool's.
    Tool,
}

/// `[[wrench]]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ExternalWrench {
    /// Time when the wrench begins, s.
    pub at: f64,
    /// Time that the wrench acts, s.
    pub duration: f64,
    /// N and Nm.
    pub wrench: SixNumbers,
    /// Frame of the wrench.
    #[serde(default)]
    pub frame: LoadFrame,
}

/// `[[conveyor]]`: linear or circular.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Conveyor {
    /// Name, which one with a surface needs.
    pub name: Option<String>,
    /// Number of the encoder, 0 or 1; one with a surface may be without.
    pub encoder: Option<u8>,
    /// Direction of a belt.
    pub direction: Option<[f64; 3]>,
    /// Pose of a turntable, which turns about its z.
    pub center: Option<SixNumbers>,
    /// Speed of a belt, m/s, or of a turntable, rad/s.
    pub speed: f64,
    /// Ticks of a belt's encoder for a metre.
    pub ticks_per_meter: Option<f64>,
    /// Ticks of a turntable's encoder for a revolution.
    pub ticks_per_revolution: Option<f64>,
    /// Time when the conveyor starts, s.
    #[serde(default)]
    pub start_at: f64,
    /// Pose of the box whose top carries.
    pub pose: Option<SixNumbers>,
    /// Edges of that box, m.
    pub size: Option<[f64; 3]>,
    /// Radius of the disc that carries, m.
    pub radius: Option<f64>,
    /// Coefficient of friction of the surface.
    pub friction: Option<f64>,
    /// Output: the conveyor moves while it is true.
    pub run: Option<IoPointName>,
    /// Analog output: the speed in proportion to `speed`.
    pub speed_from: Option<IoPointName>,
    /// Rate of change of the speed, m/s² or rad/s².
    pub acceleration: Option<f64>,
}

impl Conveyor {
    /// Whether it carries parts.
    pub const fn has_surface(&self) -> bool {
        self.size.is_some() || self.radius.is_some()
    }
}

/// `[[wire]]`: a pure delay; a pulse keeps its length.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wire {
    /// An output.
    pub from: IoPointName,
    /// An input.
    pub to: IoPointName,
    /// Time until a change of the output reaches the input, s.
    #[serde(default)]
    pub delay: f64,
}

/// A level, or an analog or register value.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(untagged, expecting = "`value` is true, false or a number")]
pub enum InputValue {
    /// Level of a digital point or a boolean register.
    Level(bool),
    /// Everything else.
    Number(f64),
}

/// `[[input]]`
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScheduledInput {
    /// Time of the change, s.
    pub at: f64,
    /// Input that changes.
    pub set: IoPointName,
    /// New value of the input.
    pub value: InputValue,
}

/// What a pair of configurable inputs asks the safety system for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SafetyFunction {
    /// Brake, then power off.
    EmergencyStop,
    /// Stop on the path and wait there.
    SafeguardStop,
    /// The edge that ends a safeguard stop; without such a pair it ends by itself.
    SafeguardReset,
    /// Reduced limits.
    ReducedMode,
}

impl SafetyFunction {
    /// The word in the file.
    pub const fn name(self) -> &'static str {
        match self {
            Self::EmergencyStop => "emergency_stop",
            Self::SafeguardStop => "safeguard_stop",
            Self::SafeguardReset => "safeguard_reset",
            Self::ReducedMode => "reduced_mode",
        }
    }
}

/// The level that asks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ActiveLevel {
    /// Either input of the pair low: a broken wire asks too.
    #[default]
    Low,
    /// Either input of the pair high.
    High,
}

/// `[[safety_input]]`
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SafetyInput {
    /// What it asks for.
    pub function: SafetyFunction,
    /// Number of the pair of configurable inputs, 0 to 3: pair n is inputs 2n and 2n + 1.
    pub pair: u8,
    /// The level that asks.
    #[serde(default)]
    pub active: ActiveLevel,
}

/// A serial port of the robot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum SerialPort {
    /// The port at the tool connector.
    Tool,
    /// The port in the control cabinet.
    Masterboard,
}

/// `[[serial]]`
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Serial {
    /// Port of the robot that the device is behind.
    pub port: SerialPort,
    /// A device or pty path, or `tcp:host:port`.
    pub device: String,
}

/// `[[modbus]]`: the arguments of `modbus_add_signal` (manual 6.1.1).
#[derive(Clone, Debug, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModbusSignal {
    /// Address of the device.
    #[serde(rename = "IP")]
    pub ip: String,
    /// Number of the unit behind the device's address.
    pub slave_number: u8,
    /// Coil or register.
    pub signal_address: u16,
    /// 0 digital input, 1 digital output, 2 register input, 3 register output.
    pub signal_type: u8,
    /// Name of the signal, which no other signal has.
    pub signal_name: String,
    /// The signal is updated in the order in which signals were added.
    #[serde(default)]
    pub is_sequential: bool,
    /// Number of coils or registers in a row.
    #[serde(default = "one")]
    pub registers_count: u8,
    /// TCP port of the device.
    #[serde(default = "modbus_port")]
    pub port: u16,
}

const fn one() -> u8 {
    1
}

const fn modbus_port() -> u16 {
    502
}
