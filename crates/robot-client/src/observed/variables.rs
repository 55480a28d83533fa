//! The variables that controllers offer, as far as they are known, and where each belongs.
//!
//! Names and types: the vendor's SDK and public clients. Nothing is known of further ones, so they cannot be asked for.

use std::sync::LazyLock;

use kinematics::{JointPositions, JointSpeeds, JointTorques, RpyPose};
use motion_api::registers::{BOOLEAN_REGISTERS, FLOAT_REGISTERS, INTEGER_REGISTERS};
use motion_api::{RegisterBank, Registers, RobotMode, RobotState, SafetyMode};
use wire::rtsi::RtsiValue;

/// Takes a value over.
pub(super) type StateSetter = fn(&mut RobotState, RtsiValue);

/// The field of a state that a variable belongs to.
#[derive(Clone, Copy, Debug)]
pub(super) enum VariableTarget {
    /// Into the state, which holds all of it.
    State(StateSetter),
    /// Into the state, which holds a part of it.
    StateAndMessage(StateSetter),
    /// The robot's clock.
    Timestamp,
    /// Into the registers.
    Register(Register),
    /// Into a message of its own.
    Message,
}

/// One register, or a word of boolean ones.
#[derive(Clone, Copy, Debug)]
pub(super) struct Register {
    is_output: bool,
    kind: RegisterKind,
    number: u8,
}

#[derive(Clone, Copy, Debug)]
enum RegisterKind {
    /// 32 boolean registers from this one on.
    Word,
    Boolean,
    Integer,
    Float,
}

impl Register {
    /// Takes a value over; one of another type is not known.
    pub(super) fn set(self, registers: &Registers, value: RtsiValue) {
        let Self {
            is_output,
            kind,
            number,
        } = self;
        let bank: &RegisterBank = match is_output {
            true => &registers.output,
            false => &registers.input,
        };
        match (kind, value) {
            (RegisterKind::Word, RtsiValue::U32(word)) => {
                for bit in 0..32 {
                    bank.set_boolean(number + bit, word >> bit & 1 == 1);
                }
            }
            (RegisterKind::Boolean, RtsiValue::Bool(level)) => bank.set_boolean(number, level),
            (RegisterKind::Integer, RtsiValue::I32(x)) => bank.set_integer(number, x),
            (RegisterKind::Float, RtsiValue::F64(x)) => bank.set_float(number, x),
            _ => {}
        }
    }
}

/// Groups of registers: the name before the number, what they are, and their numbers.
const GROUPS: [(&str, bool, RegisterKind, std::ops::Range<u8>); 6] = [
    (
        "output_bit_register",
        true,
        RegisterKind::Boolean,
        64..BOOLEAN_REGISTERS,
    ),
    (
        "output_int_register",
        true,
        RegisterKind::Integer,
        0..INTEGER_REGISTERS,
    ),
    (
        "output_double_register",
        true,
        RegisterKind::Float,
        0..FLOAT_REGISTERS,
    ),
    (
        "input_bit_register",
        false,
        RegisterKind::Boolean,
        64..BOOLEAN_REGISTERS,
    ),
    (
        "input_int_register",
        false,
        RegisterKind::Integer,
        0..INTEGER_REGISTERS,
    ),
    (
        "input_double_register",
        false,
        RegisterKind::Float,
        0..FLOAT_REGISTERS,
    ),
];

/// The first 64 boolean registers come in words.
const WORDS: [(&str, bool, u8); 4] = [
    ("output_bit_registers0_to_31", true, 0),
    ("output_bit_registers32_to_63", true, 32),
    ("input_bit_registers0_to_31", false, 0),
    ("input_bit_registers32_to_63", false, 32),
];

/// Known, and nothing of the state.
const MESSAGE_ONLY_VARIABLES: &[&str] = &[
    "script_control_line",
    "runtime_state",
    "actual_joint_current",
    "actual_current",
    "actual_joint_voltage",
    "joint_mode",
    "safety_mode",
    "actual_robot_voltage",
    "actual_robot_current",
    "elbow_velocity",
    "robot_status_bits",
    "safety_status_bits",
    "io_current",
    "tool_mode",
    "tool_analog_input_types",
    "tool_analog_output_types",
    "tool_output_current",
    "tool_temperature",
    "tool_digital_mode",
    "tool_digital0_mode",
    "tool_digital1_mode",
    "tool_digital2_mode",
    "tool_digital3_mode",
    "analog_io_types",
];

macro_rules! taken {
    ($($name:literal $place:ident $kind:ident($state:ident, $x:pat) => $take:expr;)+) => {
        /// What is asked for of a controller that takes no long list: all of this has a place in a cycle.
        pub const IN_A_CYCLE: &[&str] = &["timestamp", $($name),+];

        const TAKEN: &[(&str, VariableTarget)] = &[
            ("timestamp", VariableTarget::Timestamp),
            $(($name, VariableTarget::$place(|$state, value| {
                if let RtsiValue::$kind($x) = value {
                    $take
                }
            })),)+
        ];
    };
}

taken! {
    "target_joint_positions" State Vector6(s, x) => s.target_q = JointPositions(x);
    "target_joint_speeds" State Vector6(s, x) => s.target_qd = JointSpeeds(x);
    "actual_joint_positions" State Vector6(s, x) => s.actual_q = JointPositions(x);
    "actual_joint_speeds" State Vector6(s, x) => s.actual_qd = JointSpeeds(x);
    "actual_joint_torques" State Vector6(s, x) => s.actual_torque = JointTorques(x);
    "target_TCP_pose" State Vector6(s, x) => s.target_tcp_pose = RpyPose::from_array(x);
    "target_TCP_speed" State Vector6(s, x) => s.target_tcp_speed = x;
    "actual_TCP_pose" State Vector6(s, x) => s.actual_tcp_pose = RpyPose::from_array(x);
    "actual_TCP_speed" State Vector6(s, x) => s.actual_tcp_speed = x;
    "actual_TCP_force" State Vector6(s, x) => s.tcp_force = x;
    "ft_raw_wrench" State Vector6(s, x) => s.raw_wrench = x;
    "actual_digital_input_bits" State U32(s, x) => s.digital_in = u64::from(x);
    "actual_digital_output_bits" State U32(s, x) => s.digital_out = u64::from(x);
    "standard_analog_input0" State F64(s, x) => s.analog_in[0] = x;
    "standard_analog_input1" State F64(s, x) => s.analog_in[1] = x;
    "tool_analog_input" State F64(s, x) => s.analog_in[2] = x;
    "standard_analog_output0" State F64(s, x) => s.analog_out[0] = x;
    "standard_analog_output1" State F64(s, x) => s.analog_out[1] = x;
    "tool_analog_output" State F64(s, x) => s.analog_out[2] = x;
    "joint_temperatures" State Vector6(s, x) => s.joint_temperatures = x;
    "robot_mode" State I32(s, x) => s.robot_mode = RobotMode::from_number(x);
    "safety_status" State I32(s, x) => s.safety_mode = SafetyMode::from_number(x);
    "speed_scaling" State F64(s, x) => s.speed_scaling = x;
    "target_speed_fraction" State F64(s, x) => s.target_speed_fraction = x;
    "elbow_position" State Vector3(s, x) => s.elbow_position = x;
    "payload_mass" State F64(s, x) => s.payload.mass = x;
    "payload_cog" State Vector3(s, x) => s.payload.cog = x.into();
    // The state knows whole volts.
    "tool_output_voltage" StateAndMessage F64(s, x) => s.io_config.tool_voltage = x.round() as u8;
}

/// Every variable that is known, those of a cycle first.
pub static KNOWN_VARIABLES: LazyLock<Vec<String>> = LazyLock::new(|| {
    let alone = IN_A_CYCLE.iter().chain(MESSAGE_ONLY_VARIABLES).copied();
    let words = WORDS.iter().map(|(name, ..)| *name);
    let mut names: Vec<String> = alone.chain(words).map(str::to_owned).collect();
    for (group, _, _, numbers) in GROUPS {
        names.extend(numbers.map(|number| format!("{group}{number}")));
    }
    names
});

/// The field of a state that the variable of this name belongs to.
pub(super) fn target_of(name: &str) -> VariableTarget {
    if let Some((_, place)) = TAKEN.iter().find(|(taken, _)| *taken == name) {
        return *place;
    }
    if let Some((_, is_output, number)) = WORDS.iter().find(|(word, ..)| *word == name) {
        return VariableTarget::Register(Register {
            is_output: *is_output,
            kind: RegisterKind::Word,
            number: *number,
        });
    }
    let register = GROUPS
        .into_iter()
        .find_map(|(group, is_output, kind, numbers)| {
            let number = name.strip_prefix(group)?.parse().ok()?;
            numbers.contains(&number).then_some(Register {
                is_output,
                kind,
                number,
            })
        });
    register.map_or(VariableTarget::Message, VariableTarget::Register)
}
