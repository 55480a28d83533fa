//! What ports tell about the robot beside its state: constants of the arm and settings that rarely change.
//!
//! Plain data, filled by the wiring from the model and the controller; ports import neither.

use core::f64::consts::{FRAC_PI_2, TAU};

use motion_api::{MotionMode, RobotState};

/// Figures of the arm, constant while the server runs. Joints base first.
#[derive(Clone, Debug, PartialEq)]
pub struct RobotDescription {
    /// The name people know, as `CS66`.
    pub name: String,
    /// The vendor's number of the type, as 6206; 0 for an arm that is not one of theirs.
    pub robot_type: u32,
    /// Lowest and highest position of every joint, rad.
    pub position_limits: [(f64, f64); 6],
    /// Highest speed of every joint, rad/s.
    pub speed_limits: [f64; 6],
    /// Highest acceleration of every joint, rad/s².
    pub acceleration_limits: [f64; 6],
    /// Link lengths, m. The vendor's calibration program reads the configuration data with the index layout of the
    /// modified convention, T_i = Rx(alpha_{i-1}) Tx(a_{i-1}) Rz(q_i) Tz(d_i): entry i holds a_{i-1}.
    pub dh_a: [f64; 6],
    /// Link offsets, m.
    pub dh_d: [f64; 6],
    /// Link twists, rad, with the index layout of `dh_a`: entry i holds alpha_{i-1}.
    pub dh_alpha: [f64; 6],
    /// Joint torque a motor current of 1 A makes, Nm/A. No public figure exists: the simulator's own choice.
    pub torque_per_ampere: [f64; 6],
    /// Radius of the ball around the elbow that holds the joint's housing, m; 0 for an arm without collision geometry.
    pub elbow_radius: f64,
    /// Changes with every setting of the safety system.
    pub safety_checksum: u32,
}

impl RobotDescription {
    /// A CS66 with nominal figures: what tests and examples describe.
    pub fn cs66() -> Self {
        Self {
            name: "CS66".to_owned(),
            robot_type: 6206,
            position_limits: [
                (-TAU, TAU),
                (-TAU, TAU),
                (-TAU / 2.0, TAU / 2.0),
                (-TAU, TAU),
                (-TAU, TAU),
                (-TAU, TAU),
            ],
            speed_limits: [TAU / 2.0; 6],
            acceleration_limits: [20.0; 6],
            dh_a: [0.0, 0.0, -0.427, -0.3905, 0.0, 0.0],
            dh_d: [0.1625, 0.0, 0.0, 0.1475, 0.0965, 0.092],
            dh_alpha: [0.0, FRAC_PI_2, 0.0, 0.0, FRAC_PI_2, -FRAC_PI_2],
            torque_per_ampere: [12.0, 12.0, 12.0, 8.0, 8.0, 8.0],
            elbow_radius: 0.0625,
            safety_checksum: 0x5AFE_C0DE,
        }
    }
}

pub use motion_api::AnalogDomain;

/// Settings of the controller beside the motion state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Peripherals {
    /// Domains of standard analog input 0, 1 and the tool's.
    pub analog_in_domains: [AnalogDomain; 3],
    /// Domains of standard analog output 0, 1 and the tool's.
    pub analog_out_domains: [AnalogDomain; 3],
    /// Supply voltage of the tool connector: 0, 12 or 24 V.
    pub tool_voltage: u8,
    /// How the digital pins of the tool drive their lines: 0 push/pull, 1 PNP, 2 NPN.
    pub tool_pin_modes: [u8; 4],
    /// The serial port of the tool, if it is configured.
    pub tool_serial: Option<ToolSerial>,
    /// The arm can be led by hand.
    pub freedrive: bool,
    /// An input can ask for it.
    pub freedrive_by_input: bool,
    /// Collisions with obstacles are watched for.
    pub collision_detection: bool,
}

impl Peripherals {
    /// What the snapshot knows of them; the rest is as at start.
    pub fn of(state: &RobotState) -> Self {
        let io = &state.io_config;
        Self {
            analog_in_domains: io.analog_in,
            analog_out_domains: io.analog_out,
            tool_voltage: io.tool_voltage,
            tool_pin_modes: io.tool_pins.map(|pin| pin.mode),
            freedrive: state.motion_mode == MotionMode::Freedrive,
            freedrive_by_input: io.freedrive_by_input,
            collision_detection: state.collision_detection,
            ..Self::default()
        }
    }
}

/// How the serial port of the tool is configured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ToolSerial {
    /// Bits a second.
    pub baud_rate: u32,
    /// 0 none, 1 odd, 2 even.
    pub parity: u32,
    /// 1 or 2.
    pub stop_bits: u32,
    /// Modbus RTU instead of bytes.
    pub modbus_rtu: bool,
    /// A plug-in and not scripts use the port.
    pub for_daemon: bool,
}

/// What the main task is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TaskStatus {
    /// Nothing runs.
    #[default]
    Stopped,
    /// A program runs.
    Running,
    /// A program is held.
    Paused,
}

impl TaskStatus {
    /// The word for it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stopped => "stopped",
            Self::Running => "running",
            Self::Paused => "paused",
        }
    }
}

/// The version of the vendor's controller software whose script manual this server follows: major, minor, bug fix,
/// build.
pub const CONTROLLER_VERSION: [u32; 4] = [2, 15, 0, 0];
