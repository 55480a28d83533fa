//! The state message: nine parts. Field clients unpack the whole message with one format string, so the controller
//! sends all of them in this order and size every time; a reader takes those it finds, whatever their order.
//!
//! Layout: official SDK, include/Primary; public clients agree.

use serde::Serialize;

use super::fields::{FieldCodec, FieldReader, FieldWriter, append_length_prefixed};
use super::{DecodeError, ROBOT_STATE};

/// Length of the whole message with all parts.
pub const STATE_MESSAGE_BYTES: usize = 1157;

/// Defines a part: its fields in the order of the wire, and a visit of all of them.
macro_rules! part {
    (
        $(#[$about:meta])*
        $name:ident { $( $(#[$doc:meta])* $field:ident: $type:ty => $visit:ident, )* }
    ) => {
        $(#[$about])*
        #[derive(Clone, Debug, Default, PartialEq, Serialize)]
        pub struct $name {
            $( $(#[$doc])* pub $field: $type, )*
        }

        impl $name {
            fn visit(&mut self, fields: &mut impl FieldCodec) -> Result<(), DecodeError> {
                $( fields.$visit(&mut self.$field)?; )*
                Ok(())
            }
        }
    };
}

part! {
    /// Part 0: what the robot and its program are doing.
    ModeData {
        /// Time since the controller started, µs.
        timestamp: u64 => u64,
        /// An older name; true.
        real_robot_connected: bool => flag,
        /// An older name; true.
        real_robot_enabled: bool => flag,
        /// The arm has power.
        is_powered: bool => flag,
        /// An emergency stop is on.
        is_emergency_stopped: bool => flag,
        /// A protective stop is on.
        is_protective_stopped: bool => flag,
        /// A main program runs; true while it is paused, too.
        is_task_running: bool => flag,
        /// The main program is paused.
        is_task_paused: bool => flag,
        /// Number of the robot's mode; 255 is -1.
        robot_mode: u8 => u8,
        /// Number of the control mode.
        control_mode: u8 => u8,
        /// The speed slider, 0 to 1.
        target_speed_fraction: f64 => f64,
        /// What is in force of the speed, 0 to 1.
        speed_scaling: f64 => f64,
        /// The most that the slider may say.
        target_speed_fraction_limit: f64 => f64,
        /// Number of the speed mode.
        speed_mode: u8 => u8,
        /// An older name; false.
        is_in_alarm: bool => flag,
        /// The arm is folded for transport.
        is_in_package_mode: bool => flag,
        /// Reserved.
        reserved: u32 => u32,
    }
}

part! {
    /// One joint of part 1.
    Joint {
        /// Position, rad.
        actual_q: f64 => f64,
        /// Commanded position, rad.
        target_q: f64 => f64,
        /// Speed, rad/s.
        actual_qd: f64 => f64,
        /// An older name.
        target_pulse: u32 => u32,
        /// An older name.
        actual_pulse: u32 => u32,
        /// An older name.
        zero_pulse: u32 => u32,
        /// Current of the motor, A.
        current: f32 => f32,
        /// Voltage, V.
        voltage: f32 => f32,
        /// Temperature, °C.
        temperature: f32 => f32,
        /// Torque, Nm.
        torque: f32 => f32,
        /// Number of its mode.
        mode: u8 => u8,
        /// Reserved.
        reserved: u32 => u32,
    }
}

part! {
    /// Part 4: where the tool is.
    Cartesian {
        /// TCP in the base frame: x, y, z in m and roll, pitch, yaw in rad.
        tcp_pose: [f64; 6] => f64s,
        /// TCP in the flange frame, likewise.
        tcp_offset: [f64; 6] => f64s,
    }
}

part! {
    /// Part 6: the arm.
    Configuration {
        /// Lowest and highest position of every joint, rad, joint after joint.
        position_limits: [f64; 12] => f64s,
        /// Highest speed, rad/s, and acceleration, rad/s², of every joint, joint after joint.
        speed_acceleration_limits: [f64; 12] => f64s,
        /// Defaults of moves: joint speed and acceleration, TCP speed and acceleration, and a radius.
        move_defaults: [f64; 5] => f64s,
        /// Link lengths of the modified convention, m: entry i holds a of link i - 1.
        dh_a: [f64; 6] => f64s,
        /// Link offsets, m.
        dh_d: [f64; 6] => f64s,
        /// Link twists, rad, numbered as `dh_a`.
        dh_alpha: [f64; 6] => f64s,
        /// Reserved; whether real arms send offsets of the joints here is not established.
        dh_reserved: [f64; 6] => f64s,
        /// Version of the masterboard.
        masterboard_version: u32 => u32,
        /// Type of the control box.
        control_box_type: u32 => u32,
        /// The vendor's number of the arm, as 6206 for a CS66.
        robot_type: u32 => u32,
        /// Structure of the arm, type of the tool's I/O, two reserved bytes.
        structure: [u8; 4] => bytes,
    }
}

part! {
    /// Part 3: inputs, outputs, power, safety.
    Masterboard {
        /// Bit mask: 0 to 15 standard, 16 to 23 configurable, 24 to 27 tool.
        digital_in: u32 => u32,
        /// Bit mask of the outputs: 0 to 15 standard, 16 to 23 configurable, 24 to 27 tool.
        digital_out: u32 => u32,
        /// Inputs 0, 1 and the tool's: 0 current, 1 voltage.
        analog_in_domains: [u8; 3] => bytes,
        /// A or V.
        analog_in: [f64; 3] => f64s,
        /// Outputs 0, 1 and the tool's: 0 current, 1 voltage.
        analog_out_domains: [u8; 3] => bytes,
        /// A or V.
        analog_out: [f64; 3] => f64s,
        /// Temperature of the master board, °C.
        temperature: f32 => f32,
        /// Voltage of the robot, V.
        robot_voltage: f32 => f32,
        /// Current of the robot, A.
        robot_current: f32 => f32,
        /// Current of the inputs and outputs, A.
        io_current: f32 => f32,
        /// Number of the safety mode.
        safety_mode: u8 => u8,
        /// The limits of reduced mode are in force.
        is_reduced: bool => flag,
        /// The selector of the operational mode.
        operational_mode_selector: bool => flag,
        /// The enabling device.
        enabling_device: bool => flag,
        /// Internal.
        internal: u8 => u8,
    }
}

part! {
    /// Part 8: freedrive and collisions.
    AdditionalInfo {
        /// The arm is led by hand.
        freedrive: bool => flag,
        /// Reserved.
        reserved_flag: bool => flag,
        /// An input may ask for freedrive.
        freedrive_by_input: bool => flag,
        /// Collisions are watched for.
        collision_detection: bool => flag,
        /// Reserved.
        reserved: u8 => u8,
    }
}

part! {
    /// Part 2: the tool's connector.
    Tool {
        /// 0 current, 1 voltage.
        analog_out_domain: u8 => u8,
        /// 0 current, 1 voltage.
        analog_in_domain: u8 => u8,
        /// A or V.
        analog_out: f64 => f64,
        /// A or V.
        analog_in: f64 => f64,
        /// Measured, V.
        voltage: f32 => f32,
        /// Asked for: 0, 12 or 24 V.
        output_voltage: u8 => u8,
        /// Current of the tool, A.
        current: f32 => f32,
        /// Temperature of the tool, °C.
        temperature: f32 => f32,
        /// Number of its mode.
        mode: u8 => u8,
    }
}

part! {
    /// Part 10: the safety system.
    Safety {
        /// Changes with every setting.
        checksum: u32 => u32,
        /// Number of the operational mode.
        operational_mode: u8 => u8,
        /// Reserved.
        reserved: u8 => u8,
        /// Position in the base frame, m.
        elbow_position: [f64; 3] => f64s,
        /// Radius of the ball around it, m.
        elbow_radius: f64 => f64,
    }
}

part! {
    /// Part 11: the tool's serial port.
    ToolCommunication {
        /// The port is configured.
        is_enabled: bool => flag,
        /// Bits a second.
        baud_rate: u32 => u32,
        /// 0 none, 1 odd, 2 even.
        parity: u32 => u32,
        /// 1 or 2.
        stop_bits: u32 => u32,
        /// Modbus RTU instead of bytes.
        modbus_rtu: bool => flag,
        /// Who uses it.
        usage: u8 => u8,
        /// Reserved.
        reserved_0: f32 => f32,
        /// Reserved.
        reserved_1: f32 => f32,
    }
}

/// Part 1: every joint, base first.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Joints(pub [Joint; 6]);

impl Joints {
    fn visit(&mut self, fields: &mut impl FieldCodec) -> Result<(), DecodeError> {
        self.0.iter_mut().try_for_each(|joint| joint.visit(fields))
    }
}

/// Defines the message: its parts in the order of the wire, with their types.
macro_rules! parts {
    ($( $(#[$doc:meta])* $kind:literal $field:ident: $part:ident; )*) => {
        /// A state message. What a controller leaves out is absent.
        #[derive(Clone, Debug, Default, PartialEq, Serialize)]
        pub struct State {
            $( $(#[$doc])* #[serde(skip_serializing_if = "Option::is_none")] pub $field: Option<$part>, )*
            /// Types of parts that are not known here, or shorter than known.
            #[serde(skip_serializing_if = "Vec::is_empty")]
            pub unknown: Vec<u8>,
        }

        impl State {
            fn take(&mut self, kind: u8, body: &[u8]) {
                match kind {
                    $( $kind => {
                        // A longer part is a newer one: what is known of it stands in front. A shorter one is of a
                        // version that is not known here.
                        let mut part = $part::default();
                        match part.visit(&mut FieldReader::new(body)) {
                            Ok(()) => self.$field = Some(part),
                            Err(_) => self.unknown.push(kind),
                        }
                    } )*
                    other => self.unknown.push(other),
                }
            }

            /// The whole message, with those parts that are there.
            pub fn encode(mut self) -> Vec<u8> {
                let mut out = Vec::with_capacity(STATE_MESSAGE_BYTES);
                append_length_prefixed(&mut out, ROBOT_STATE, |out| {
                    $( if let Some(part) = &mut self.$field {
                        append_length_prefixed(out, $kind, |out| {
                            // Writing cannot fail.
                            let _ = part.visit(&mut FieldWriter(out));
                        });
                    } )*
                });
                out
            }
        }
    };
}

parts! {
    /// What the robot and its program are doing.
    0 mode: ModeData;
    /// Every joint.
    1 joints: Joints;
    /// Pose of the tool.
    4 cartesian: Cartesian;
    /// The arm.
    6 configuration: Configuration;
    /// Inputs, outputs, power, safety.
    3 masterboard: Masterboard;
    /// Freedrive and collisions.
    8 additional: AdditionalInfo;
    /// The tool's connector.
    2 tool: Tool;
    /// The safety system.
    10 safety: Safety;
    /// The tool's serial port.
    11 tool_communication: ToolCommunication;
}

impl State {
    /// Reads the body of a state message.
    ///
    /// # Errors
    /// [`DecodeError`], when lengths and bytes do not fit together.
    pub fn decode(body: &[u8]) -> Result<Self, DecodeError> {
        let mut state = Self::default();
        let mut rest = body;
        while let Some(&[a, b, c, d, kind]) = rest.first_chunk::<5>() {
            let length = u32::from_be_bytes([a, b, c, d]);
            let part = usize::try_from(length)
                .ok()
                .and_then(|length| rest.get(5..length));
            let Some(part) = part else {
                let left = rest.len();
                return Err(DecodeError::PartLength { kind, length, left });
            };
            state.take(kind, part);
            rest = &rest[5 + part.len()..];
        }
        match rest.len() {
            0 => Ok(state),
            left => Err(DecodeError::TrailingBytes(left)),
        }
    }
}
