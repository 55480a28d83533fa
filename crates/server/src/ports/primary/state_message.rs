//! The state message of the primary port: nine parts, 1157 bytes, the same order and sizes every time.
//!
//! Pure: a snapshot in, bytes out. Field clients unpack the whole message with one format string, so order, presence
//! and size of the parts all matter (SDK include/Primary; public clients).

use motion_api::{RobotState, SafetyMode};

use super::codec::{ROBOT_STATE, Writer};
use crate::ports::derived::{
    io_current, is_powered, joint_current, joint_mode, robot_current, supply_voltage, tool_current,
    tool_mode, tool_temperature,
};
use crate::ports::description::{AnalogDomain, Peripherals, RobotDescription, TaskStatus};
use crate::ports::sample::Sample;

/// Length of the whole message.
pub const STATE_MESSAGE_BYTES: usize = 1157;

/// Defaults of movej and movel (manual 3.1.1, 3.1.3): rad/s, rad/s², m/s, m/s², then a radius that is internal to the
/// vendor's planner.
#[allow(
    clippy::approx_constant,
    reason = "the figures of the manual, not the constant"
)]
const MOTION_DEFAULTS: [f64; 5] = [1.047197, 1.396263, 0.25, 1.2, 0.0];

struct Inputs<'a> {
    state: &'a RobotState,
    task: TaskStatus,
    robot: &'a RobotDescription,
    peripherals: &'a Peripherals,
}

/// The whole message.
pub fn encode_state(sample: &Sample, robot: &RobotDescription) -> Vec<u8> {
    let inputs = &Inputs {
        state: &sample.state,
        task: sample.task,
        robot,
        peripherals: &sample.peripherals,
    };
    let mut out = Writer::message(ROBOT_STATE);
    out.part(0, |out| robot_mode_data(out, inputs));
    out.part(1, |out| joint_data(out, inputs));
    out.part(4, |out| cartesian_info(out, inputs));
    out.part(6, |out| configuration_data(out, inputs.robot));
    out.part(3, |out| masterboard_data(out, inputs));
    out.part(8, |out| additional_info(out, inputs));
    out.part(2, |out| tool_data(out, inputs));
    out.part(10, |out| safety_state(out, inputs));
    out.part(11, |out| tool_communication(out, inputs));
    out.finish()
}

fn robot_mode_data(out: &mut Writer, inputs: &Inputs<'_>) {
    let state = inputs.state;
    // Simulated time since the controller started, µs.
    out.u64((state.time * 1e6).round() as u64);
    out.flag(true); // older name: real robot connected
    out.flag(true); // older name: real robot enabled
    out.flag(is_powered(state.robot_mode));
    out.flag(matches!(
        state.safety_mode,
        SafetyMode::SystemEmergencyStop | SafetyMode::RobotEmergencyStop
    ));
    out.flag(state.safety_mode == SafetyMode::ProtectiveStop);
    // "Runs" stays true while paused: clients test "paused" first.
    out.flag(inputs.task != TaskStatus::Stopped);
    out.flag(inputs.task == TaskStatus::Paused);
    out.u8(state.robot_mode.number().cast_unsigned() as u8); // -1 travels as 255
    out.u8(0); // control mode: position
    out.f64(state.target_speed_fraction);
    out.f64(state.speed_scaling);
    out.f64(1.0); // limit of the target speed fraction
    out.u8(0); // speed mode
    out.flag(false); // older name: system in alarm
    out.flag(false); // in package mode
    out.u32(0);
}

fn joint_data(out: &mut Writer, inputs: &Inputs<'_>) {
    let state = inputs.state;
    for joint in 0..6 {
        let torque = state.actual_torque[joint];
        out.f64(state.actual_q[joint]);
        out.f64(state.target_q[joint]);
        out.f64(state.actual_qd[joint]);
        out.u32(0); // older names: target, actual and zero pulse
        out.u32(0);
        out.u32(0);
        out.f32(joint_current(inputs.state, inputs.robot, joint));
        out.f32(supply_voltage(state.robot_mode));
        out.f32(state.joint_temperatures[joint]);
        out.f32(torque);
        out.u8(joint_mode(state.robot_mode));
        out.u32(0);
    }
}

fn cartesian_info(out: &mut Writer, inputs: &Inputs<'_>) {
    out.f64s(&inputs.state.actual_tcp_pose.to_array());
    out.f64s(&inputs.state.tcp_offset.to_array());
}

fn configuration_data(out: &mut Writer, robot: &RobotDescription) {
    for (min, max) in robot.position_limits {
        out.f64s(&[min, max]);
    }
    for joint in 0..6 {
        out.f64s(&[robot.speed_limits[joint], robot.acceleration_limits[joint]]);
    }
    out.f64s(&MOTION_DEFAULTS);
    out.f64s(&robot.dh_a);
    out.f64s(&robot.dh_d);
    out.f64s(&robot.dh_alpha);
    out.f64s(&[0.0; 6]);
    out.u32(0); // masterboard version
    out.u32(0); // control box type
    out.u32(robot.robot_type);
    out.u32(0); // robot structure, tool I/O type, two reserved
}

fn masterboard_data(out: &mut Writer, inputs: &Inputs<'_>) {
    let (state, peripherals) = (inputs.state, inputs.peripherals);
    out.u32(state.digital_in as u32);
    out.u32(state.digital_out as u32);
    domains(out, peripherals.analog_in_domains);
    out.f64s(&state.analog_in);
    domains(out, peripherals.analog_out_domains);
    out.f64s(&state.analog_out);
    out.f32(state.controller_temperature);
    out.f32(supply_voltage(state.robot_mode));
    out.f32(robot_current(state, inputs.robot));
    out.f32(io_current(state));
    out.u8(state.safety_mode.number().cast_unsigned() as u8);
    out.flag(state.safety_mode == SafetyMode::Reduced);
    out.flag(false); // operational mode selector input
    out.flag(false); // three-position enabling device input
    out.u8(0);
}

fn additional_info(out: &mut Writer, inputs: &Inputs<'_>) {
    out.flag(inputs.peripherals.freedrive);
    out.flag(false);
    out.flag(inputs.peripherals.freedrive_by_input);
    out.flag(inputs.peripherals.collision_detection);
    out.u8(0);
}

fn tool_data(out: &mut Writer, inputs: &Inputs<'_>) {
    let (state, peripherals) = (inputs.state, inputs.peripherals);
    out.u8(peripherals.analog_out_domains[2] as u8);
    out.u8(peripherals.analog_in_domains[2] as u8);
    out.f64(state.analog_out[2]);
    out.f64(state.analog_in[2]);
    out.f32(f64::from(peripherals.tool_voltage));
    out.u8(peripherals.tool_voltage);
    out.f32(tool_current(state));
    out.f32(tool_temperature(state));
    out.u8(tool_mode(state.robot_mode));
}

fn safety_state(out: &mut Writer, inputs: &Inputs<'_>) {
    out.u32(inputs.robot.safety_checksum);
    out.u8(0); // operational mode: there is no selector
    out.u8(0);
    out.f64s(&inputs.state.elbow_position);
    out.f64(inputs.robot.elbow_radius);
}

fn tool_communication(out: &mut Writer, inputs: &Inputs<'_>) {
    let serial = inputs.peripherals.tool_serial;
    out.flag(serial.is_some());
    out.u32(serial.map_or(0, |s| s.baud_rate));
    out.u32(serial.map_or(0, |s| s.parity));
    out.u32(serial.map_or(0, |s| s.stop_bits));
    out.flag(serial.is_some_and(|s| s.modbus_rtu));
    out.u8(serial.map_or(0, |s| u8::from(s.for_daemon)));
    out.f32(0.0);
    out.f32(0.0);
}

fn domains(out: &mut Writer, domains: [AnalogDomain; 3]) {
    for domain in domains {
        out.u8(domain as u8);
    }
}

#[cfg(test)]
mod tests;
