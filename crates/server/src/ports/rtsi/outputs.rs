//! The variables that clients can read: name, type and where the value comes from.
//!
//! The types matter to the bit: the SDK throws when one differs (SDK recipe file and getters; public clients).

use core::ops::Range;

use motion_api::{RegisterImage, RegisterImages, RobotMode, RobotState, SafetyMode};

use crate::ports::derived::{
    io_current, is_powered, joint_current, joint_mode, robot_current, supply_voltage, tool_current,
    tool_mode, tool_temperature,
};
use crate::ports::description::{AnalogDomain, RobotDescription, TaskStatus};
use crate::ports::sample::Sample;
use wire::rtsi::{RtsiType, RtsiValue};

/// One variable.
#[derive(Clone, Copy, Debug)]
pub enum OutputVariable {
    /// A variable with a name of its own.
    Named(&'static NamedVariable),
    /// `input_bit_register64` to `…127`
    InputBit(u8),
    /// `output_bit_register64` to `…127`
    OutputBit(u8),
    /// `input_int_register0` to `…47`
    InputInt(u8),
    /// `output_int_register0` to `…47`
    OutputInt(u8),
    /// `input_double_register0` to `…47`
    InputDouble(u8),
    /// `output_double_register0` to `…47`
    OutputDouble(u8),
}

/// A variable with a name of its own.
#[derive(Debug)]
pub struct NamedVariable {
    name: &'static str,
    kind: RtsiType,
    value: fn(&OutputSource<'_>) -> RtsiValue,
}

/// What values are made from.
struct OutputSource<'a> {
    sample: &'a Sample,
    state: &'a RobotState,
    robot: &'a RobotDescription,
}

impl OutputVariable {
    /// The variable of this name.
    pub fn by_name(name: &str) -> Option<Self> {
        if let Some(named) = NAMED.iter().find(|named| named.name == name) {
            return Some(Self::Named(named));
        }
        let (group, number) = split_register(name)?;
        let mut groups = NUMBERED.iter();
        let (.., variable) =
            groups.find(|(g, numbers, _)| *g == group && numbers.contains(&number))?;
        Some(variable(number))
    }

    /// Every variable that stands alone, with its name.
    pub fn named() -> impl Iterator<Item = (&'static str, Self)> {
        NAMED.iter().map(|named| (named.name, Self::Named(named)))
    }

    /// Every group of registers: the name without its number, the numbers, and the first variable.
    pub fn numbered() -> impl Iterator<Item = (&'static str, Range<u8>, Self)> {
        NUMBERED
            .iter()
            .map(|(group, numbers, variable)| (*group, numbers.clone(), variable(numbers.start)))
    }

    /// Type of the variable.
    pub const fn kind(&self) -> RtsiType {
        match self {
            Self::Named(named) => named.kind,
            Self::InputBit(_) | Self::OutputBit(_) => RtsiType::Bool,
            Self::InputInt(_) | Self::OutputInt(_) => RtsiType::I32,
            Self::InputDouble(_) | Self::OutputDouble(_) => RtsiType::F64,
        }
    }

    /// Value of the variable in a sample.
    pub fn value(&self, sample: &Sample, robot: &RobotDescription) -> RtsiValue {
        let RegisterImages {
            input: inputs,
            output: outputs,
        } = &sample.registers;
        match *self {
            Self::Named(named) => (named.value)(&OutputSource {
                sample,
                state: &sample.state,
                robot,
            }),
            Self::InputBit(n) => RtsiValue::Bool(inputs.boolean(n)),
            Self::OutputBit(n) => RtsiValue::Bool(outputs.boolean(n)),
            Self::InputInt(n) => RtsiValue::I32(inputs.integer(n)),
            Self::OutputInt(n) => RtsiValue::I32(outputs.integer(n)),
            Self::InputDouble(n) => RtsiValue::F64(inputs.float(n)),
            Self::OutputDouble(n) => RtsiValue::F64(outputs.float(n)),
        }
    }
}

/// Name without the number, numbers, variable of a number.
type OutputGroup = (&'static str, Range<u8>, fn(u8) -> OutputVariable);

/// Registers have one variable each; the first 64 boolean ones come in words.
const NUMBERED: [OutputGroup; 6] = [
    ("input_bit_register", 64..128, OutputVariable::InputBit),
    ("output_bit_register", 64..128, OutputVariable::OutputBit),
    ("input_int_register", 0..48, OutputVariable::InputInt),
    ("output_int_register", 0..48, OutputVariable::OutputInt),
    ("input_double_register", 0..48, OutputVariable::InputDouble),
    (
        "output_double_register",
        0..48,
        OutputVariable::OutputDouble,
    ),
];

/// The name of a register without its number, and the number; `07` is not the number of register 7.
pub(super) fn split_register(name: &str) -> Option<(&str, u8)> {
    let group = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let digits = &name[group.len()..];
    let number: u8 = digits.parse().ok()?;
    (number.to_string() == digits).then_some((group, number))
}

macro_rules! named {
    ($($name:ident: $kind:ident = $value:expr;)+) => {
        &[$(NamedVariable { name: stringify!($name), kind: RtsiType::$kind, value: |s| RtsiValue::$kind($value(s)) },)+]
    };
}

static NAMED: &[NamedVariable] = named! {
    timestamp: F64 = |s: &OutputSource<'_>| s.state.time;
    payload_mass: F64 = |s: &OutputSource<'_>| s.state.payload.mass;
    payload_cog: Vector3 = |s: &OutputSource<'_>| s.state.payload.cog.into();
    script_control_line: U32 = |s: &OutputSource<'_>| s.sample.script_line;
    target_joint_positions: Vector6 = |s: &OutputSource<'_>| s.state.target_q.0;
    target_joint_speeds: Vector6 = |s: &OutputSource<'_>| s.state.target_qd.0;
    actual_joint_torques: Vector6 = |s: &OutputSource<'_>| s.state.actual_torque.0;
    actual_joint_positions: Vector6 = |s: &OutputSource<'_>| s.state.actual_q.0;
    actual_joint_speeds: Vector6 = |s: &OutputSource<'_>| s.state.actual_qd.0;
    actual_joint_current: Vector6 = currents;
    actual_current: Vector6 = currents;
    actual_joint_voltage: Vector6 = |s: &OutputSource<'_>| [supply_voltage(s.state.robot_mode); 6];
    actual_TCP_pose: Vector6 = |s: &OutputSource<'_>| s.state.actual_tcp_pose.to_array();
    actual_TCP_speed: Vector6 = |s: &OutputSource<'_>| s.state.actual_tcp_speed;
    actual_TCP_force: Vector6 = |s: &OutputSource<'_>| s.state.tcp_force;
    target_TCP_pose: Vector6 = |s: &OutputSource<'_>| s.state.target_tcp_pose.to_array();
    target_TCP_speed: Vector6 = |s: &OutputSource<'_>| s.state.target_tcp_speed;
    ft_raw_wrench: Vector6 = |s: &OutputSource<'_>| s.state.raw_wrench;
    actual_digital_input_bits: U32 = |s: &OutputSource<'_>| s.state.digital_in as u32;
    actual_digital_output_bits: U32 = |s: &OutputSource<'_>| s.state.digital_out as u32;
    joint_temperatures: Vector6 = |s: &OutputSource<'_>| s.state.joint_temperatures;
    robot_mode: I32 = |s: &OutputSource<'_>| s.state.robot_mode.number();
    joint_mode: Vector6I32 = |s: &OutputSource<'_>| [i32::from(joint_mode(s.state.robot_mode)); 6];
    safety_status: I32 = |s: &OutputSource<'_>| s.state.safety_mode.number();
    safety_mode: I32 = |s: &OutputSource<'_>| s.state.safety_mode.number();
    speed_scaling: F64 = |s: &OutputSource<'_>| s.state.speed_scaling;
    target_speed_fraction: F64 = |s: &OutputSource<'_>| s.state.target_speed_fraction;
    actual_robot_voltage: F64 = |s: &OutputSource<'_>| supply_voltage(s.state.robot_mode);
    actual_robot_current: F64 = |s: &OutputSource<'_>| robot_current(s.state, s.robot);
    runtime_state: U32 = |s: &OutputSource<'_>| runtime_state(s.sample.task);
    elbow_position: Vector3 = |s: &OutputSource<'_>| s.state.elbow_position;
    elbow_velocity: Vector3 = |s: &OutputSource<'_>| s.sample.elbow_velocity;
    robot_status_bits: U32 = robot_status_bits;
    safety_status_bits: U32 = |s: &OutputSource<'_>| safety_status_bits(s.state.safety_mode);
    analog_io_types: U32 = analog_io_types;
    standard_analog_input0: F64 = |s: &OutputSource<'_>| s.state.analog_in[0];
    standard_analog_input1: F64 = |s: &OutputSource<'_>| s.state.analog_in[1];
    standard_analog_output0: F64 = |s: &OutputSource<'_>| s.state.analog_out[0];
    standard_analog_output1: F64 = |s: &OutputSource<'_>| s.state.analog_out[1];
    io_current: F64 = |s: &OutputSource<'_>| io_current(s.state);
    tool_mode: U32 = |s: &OutputSource<'_>| u32::from(tool_mode(s.state.robot_mode));
    tool_analog_input_types: U32 = |s: &OutputSource<'_>| s.sample.peripherals.analog_in_domains[2] as u32;
    tool_analog_output_types: U32 = |s: &OutputSource<'_>| s.sample.peripherals.analog_out_domains[2] as u32;
    tool_analog_input: F64 = |s: &OutputSource<'_>| s.state.analog_in[2];
    tool_analog_output: F64 = |s: &OutputSource<'_>| s.state.analog_out[2];
    tool_output_voltage: F64 = |s: &OutputSource<'_>| f64::from(s.sample.peripherals.tool_voltage);
    tool_output_current: F64 = |s: &OutputSource<'_>| tool_current(s.state);
    tool_temperature: F64 = |s: &OutputSource<'_>| tool_temperature(s.state);
    tool_digital_mode: U8 = |_: &OutputSource<'_>| SINGLE_NEEDLE;
    tool_digital0_mode: U8 = |s: &OutputSource<'_>| s.sample.peripherals.tool_pin_modes[0];
    tool_digital1_mode: U8 = |s: &OutputSource<'_>| s.sample.peripherals.tool_pin_modes[1];
    tool_digital2_mode: U8 = |s: &OutputSource<'_>| s.sample.peripherals.tool_pin_modes[2];
    tool_digital3_mode: U8 = |s: &OutputSource<'_>| s.sample.peripherals.tool_pin_modes[3];
    output_bit_registers0_to_31: U32 = |s: &OutputSource<'_>| word(&s.sample.registers.output, 0);
    output_bit_registers32_to_63: U32 = |s: &OutputSource<'_>| word(&s.sample.registers.output, 32);
    input_bit_registers0_to_31: U32 = |s: &OutputSource<'_>| word(&s.sample.registers.input, 0);
    input_bit_registers32_to_63: U32 = |s: &OutputSource<'_>| word(&s.sample.registers.input, 32);
};

/// The pins of the tool work one by one. No function of the manual joins two or three of them to carry more current, so
/// this never changes.
const SINGLE_NEEDLE: u8 = 0;

/// 32 of the first 64 boolean registers.
const fn word(bank: &RegisterImage, first: u32) -> u32 {
    (bank.booleans()[0] >> first) as u32
}

fn currents(s: &OutputSource<'_>) -> [f64; 6] {
    core::array::from_fn(|joint| joint_current(s.state, s.robot, joint))
}

/// The SDK casts this number straight to its own enum.
const fn runtime_state(task: TaskStatus) -> u32 {
    match task {
        TaskStatus::Running => 1,
        TaskStatus::Paused => 2,
        TaskStatus::Stopped => 3,
    }
}

fn robot_status_bits(s: &OutputSource<'_>) -> u32 {
    let power_on = is_powered(s.state.robot_mode);
    let program_running = s.sample.task != TaskStatus::Stopped;
    let freedrive = s.sample.peripherals.freedrive || s.state.robot_mode == RobotMode::Backdrive;
    u32::from(power_on) | u32::from(program_running) << 1 | u32::from(freedrive) << 2
}

const fn safety_status_bits(mode: SafetyMode) -> u32 {
    const EMERGENCY_STOP: u32 = 1 << 7;
    const STOPPED: u32 = 1 << 10;
    match mode {
        SafetyMode::Normal => 1,
        SafetyMode::Reduced => 1 << 1,
        SafetyMode::ProtectiveStop => 1 << 2 | STOPPED,
        SafetyMode::Recovery => 1 << 3,
        SafetyMode::SafeguardStop => 1 << 4 | STOPPED,
        SafetyMode::SystemEmergencyStop => 1 << 5 | EMERGENCY_STOP | STOPPED,
        SafetyMode::RobotEmergencyStop => 1 << 6 | EMERGENCY_STOP | STOPPED,
        SafetyMode::Violation => 1 << 8 | STOPPED,
        SafetyMode::Fault => 1 << 9 | STOPPED,
        SafetyMode::ValidateJointId | SafetyMode::Undefined => 0,
    }
}

fn analog_io_types(s: &OutputSource<'_>) -> u32 {
    let p = &s.sample.peripherals;
    let [in0, in1, _] = p.analog_in_domains;
    let [out0, out1, _] = p.analog_out_domains;
    [in0, in1, out0, out1]
        .iter()
        .enumerate()
        .map(|(bit, domain)| u32::from(*domain == AnalogDomain::Voltage) << bit)
        .sum()
}

#[cfg(test)]
pub(in crate::ports) mod tests {
    use super::*;
    use crate::ports::description::Peripherals;
    use kinematics::JointPositions;

    pub(in crate::ports) fn sample() -> Sample {
        let state = RobotState::at_start(JointPositions([0.1, 0.2, 0.3, 0.4, 0.5, 0.6]), 0.004);
        Sample {
            state,
            task: TaskStatus::Stopped,
            script_line: 0,
            elbow_velocity: [0.0; 3],
            registers: RegisterImages::default(),
            peripherals: Peripherals::default(),
        }
    }

    /// The recipe of the SDK's examples with the types its getters want.
    const SDK_RECIPE: &str = "timestamp DOUBLE, payload_mass DOUBLE, payload_cog VECTOR3D, script_control_line UINT32, \
        target_joint_positions VECTOR6D, target_joint_speeds VECTOR6D, actual_joint_torques VECTOR6D, \
        actual_joint_positions VECTOR6D, actual_joint_speeds VECTOR6D, actual_joint_current VECTOR6D, \
        actual_TCP_pose VECTOR6D, actual_TCP_speed VECTOR6D, actual_TCP_force VECTOR6D, target_TCP_pose VECTOR6D, \
        target_TCP_speed VECTOR6D, actual_digital_input_bits UINT32, actual_digital_output_bits UINT32, \
        joint_temperatures VECTOR6D, robot_mode INT32, joint_mode VECTOR6INT32, safety_status INT32, \
        speed_scaling DOUBLE, target_speed_fraction DOUBLE, actual_robot_voltage DOUBLE, actual_robot_current DOUBLE, \
        runtime_state UINT32, elbow_position VECTOR3D, robot_status_bits UINT32, safety_status_bits UINT32, \
        analog_io_types UINT32, standard_analog_input0 DOUBLE, standard_analog_input1 DOUBLE, \
        standard_analog_output0 DOUBLE, standard_analog_output1 DOUBLE, io_current DOUBLE, tool_mode UINT32, \
        tool_analog_input_types UINT32, tool_analog_output_types UINT32, tool_analog_input DOUBLE, \
        tool_analog_output DOUBLE, tool_output_voltage DOUBLE, tool_output_current DOUBLE, tool_temperature DOUBLE, \
        tool_digital_mode UINT8, tool_digital0_mode UINT8, tool_digital1_mode UINT8, tool_digital2_mode UINT8, \
        tool_digital3_mode UINT8, output_bit_registers0_to_31 UINT32, output_bit_registers32_to_63 UINT32, \
        input_bit_registers0_to_31 UINT32, input_bit_registers32_to_63 UINT32";

    #[test]
    fn the_sdks_recipe_has_the_types_that_its_getters_want() {
        let mut count = 0;
        for entry in SDK_RECIPE.split(", ") {
            let (name, kind) = entry.split_once(' ').unwrap();
            let output = OutputVariable::by_name(name).unwrap_or_else(|| panic!("{name}"));
            assert_eq!(output.kind().name(), kind, "{name}");
            count += 1;
        }
        assert_eq!(count, 52);
    }

    #[test]
    fn every_value_has_the_type_that_was_announced() {
        let robot = RobotDescription::cs66();
        for named in NAMED {
            let value = OutputVariable::Named(named).value(&sample(), &robot);
            assert_eq!(value.kind(), named.kind, "{}", named.name);
        }
    }

    #[test]
    fn registers_are_found_by_number_and_nothing_else() {
        let robot = RobotDescription::cs66();
        let mut sample = sample();
        let registers = motion_api::Registers::default();
        for n in [127, 33, 0] {
            registers.output.set_boolean(n, true);
        }
        registers.input.set_integer(47, -5);
        registers.output.set_float(0, 2.5);
        sample.registers = registers.images();
        let value =
            |name: &str| OutputVariable::by_name(name).map(|output| output.value(&sample, &robot));
        assert_eq!(value("output_bit_register127"), Some(RtsiValue::Bool(true)));
        assert_eq!(value("output_bit_register64"), Some(RtsiValue::Bool(false)));
        assert_eq!(
            value("output_bit_registers0_to_31"),
            Some(RtsiValue::U32(1))
        );
        assert_eq!(
            value("output_bit_registers32_to_63"),
            Some(RtsiValue::U32(2))
        );
        assert_eq!(value("input_int_register47"), Some(RtsiValue::I32(-5)));
        assert_eq!(value("output_double_register0"), Some(RtsiValue::F64(2.5)));
        for name in [
            "output_bit_register63",
            "output_bit_register128",
            "input_int_register48",
            "input_int_register07",
            "input_int_register",
            "output_double_register_0",
            "speed_slider_mask",
            "",
            "300",
        ] {
            assert!(OutputVariable::by_name(name).is_none(), "{name}");
        }
    }

    #[test]
    fn bits_and_states_are_numbered_as_the_page_says() {
        let robot = RobotDescription::cs66();
        let mut sample = sample();
        let value = |sample: &Sample, name: &str| {
            OutputVariable::by_name(name).unwrap().value(sample, &robot)
        };
        assert_eq!(value(&sample, "runtime_state"), RtsiValue::U32(3));
        assert_eq!(value(&sample, "robot_status_bits"), RtsiValue::U32(1));
        assert_eq!(value(&sample, "safety_status_bits"), RtsiValue::U32(1));
        sample.task = TaskStatus::Paused;
        sample.peripherals.freedrive = true;
        sample.state.safety_mode = SafetyMode::ProtectiveStop;
        sample.peripherals.analog_in_domains[1] = AnalogDomain::Current;
        assert_eq!(value(&sample, "runtime_state"), RtsiValue::U32(2));
        assert_eq!(value(&sample, "robot_status_bits"), RtsiValue::U32(0b111));
        assert_eq!(
            value(&sample, "safety_status_bits"),
            RtsiValue::U32(1 << 2 | 1 << 10)
        );
        assert_eq!(value(&sample, "analog_io_types"), RtsiValue::U32(0b1101));
        assert_eq!(
            value(&sample, "joint_mode"),
            RtsiValue::Vector6I32([253; 6])
        );
    }
}
