//! What the state message of the primary port tells of our robot; `wire` knows how it is written.

use motion_api::{RobotState, SafetyMode};
use wire::primary::State;
use wire::primary::state::{
    AdditionalInfo, Cartesian, Configuration, Joint, Joints, Masterboard, ModeData, Safety, Tool,
    ToolCommunication,
};

use crate::ports::derived::{
    io_current, is_powered, joint_current, joint_mode, robot_current, supply_voltage, tool_current,
    tool_mode, tool_temperature,
};
use crate::ports::description::{Peripherals, RobotDescription, TaskStatus};
use crate::ports::sample::Sample;

pub use wire::primary::state::STATE_MESSAGE_BYTES;

/// Defaults of movej and movel (manual 3.1.1, 3.1.3): rad/s, rad/s², m/s, m/s², then a radius that is internal to the
/// vendor's planner.
#[allow(
    clippy::approx_constant,
    reason = "the figures of the manual, not the constant"
)]
const MOTION_DEFAULTS: [f64; 5] = [1.047197, 1.396263, 0.25, 1.2, 0.0];

/// The whole message.
pub fn encode_state(sample: &Sample, robot: &RobotDescription) -> Vec<u8> {
    let (state, peripherals) = (&sample.state, &sample.peripherals);
    State {
        mode: Some(modes(state, sample.task)),
        joints: Some(Joints(core::array::from_fn(|i| joint(state, robot, i)))),
        cartesian: Some(Cartesian {
            tcp_pose: state.actual_tcp_pose.to_array(),
            tcp_offset: state.tcp_offset.to_array(),
        }),
        configuration: Some(configuration(robot)),
        masterboard: Some(masterboard(state, robot, peripherals)),
        additional: Some(AdditionalInfo {
            freedrive: peripherals.freedrive,
            freedrive_by_input: peripherals.freedrive_by_input,
            collision_detection: peripherals.collision_detection,
            ..AdditionalInfo::default()
        }),
        tool: Some(tool(state, peripherals)),
        safety: Some(Safety {
            checksum: robot.safety_checksum,
            elbow_position: state.elbow_position,
            elbow_radius: robot.elbow_radius,
            ..Safety::default()
        }),
        tool_communication: Some(tool_communication(peripherals)),
        unknown: Vec::new(),
    }
    .encode()
}

fn modes(state: &RobotState, task: TaskStatus) -> ModeData {
    ModeData {
        // Simulated time since the controller started.
        timestamp: (state.time * 1e6).round() as u64,
        real_robot_connected: true,
        real_robot_enabled: true,
        is_powered: is_powered(state.robot_mode),
        is_emergency_stopped: matches!(
            state.safety_mode,
            SafetyMode::SystemEmergencyStop | SafetyMode::RobotEmergencyStop
        ),
        is_protective_stopped: state.safety_mode == SafetyMode::ProtectiveStop,
        // "Runs" stays true while paused: clients test "paused" first.
        is_task_running: task != TaskStatus::Stopped,
        is_task_paused: task == TaskStatus::Paused,
        robot_mode: state.robot_mode.number().cast_unsigned() as u8, // -1 travels as 255
        target_speed_fraction: state.target_speed_fraction,
        speed_scaling: state.speed_scaling,
        target_speed_fraction_limit: 1.0,
        ..ModeData::default()
    }
}

fn joint(state: &RobotState, robot: &RobotDescription, joint: usize) -> Joint {
    Joint {
        actual_q: state.actual_q[joint],
        target_q: state.target_q[joint],
        actual_qd: state.actual_qd[joint],
        current: joint_current(state, robot, joint) as f32,
        voltage: supply_voltage(state.robot_mode) as f32,
        temperature: state.joint_temperatures[joint] as f32,
        torque: state.actual_torque[joint] as f32,
        mode: joint_mode(state.robot_mode),
        ..Joint::default()
    }
}

/// Neither versions nor types of boards, which there are none of, are told.
fn configuration(robot: &RobotDescription) -> Configuration {
    let pairs = |pair: [(f64, f64); 6]| {
        core::array::from_fn(|i| match i % 2 {
            0 => pair[i / 2].0,
            _ => pair[i / 2].1,
        })
    };
    let top = core::array::from_fn(|i| (robot.speed_limits[i], robot.acceleration_limits[i]));
    Configuration {
        position_limits: pairs(robot.position_limits),
        speed_acceleration_limits: pairs(top),
        move_defaults: MOTION_DEFAULTS,
        dh_a: robot.dh_a,
        dh_d: robot.dh_d,
        dh_alpha: robot.dh_alpha,
        robot_type: robot.robot_type,
        ..Configuration::default()
    }
}

/// There is neither a selector of modes nor an enabling device.
fn masterboard(
    state: &RobotState,
    robot: &RobotDescription,
    peripherals: &Peripherals,
) -> Masterboard {
    Masterboard {
        digital_in: state.digital_in as u32,
        digital_out: state.digital_out as u32,
        analog_in_domains: peripherals.analog_in_domains.map(|domain| domain as u8),
        analog_in: state.analog_in,
        analog_out_domains: peripherals.analog_out_domains.map(|domain| domain as u8),
        analog_out: state.analog_out,
        temperature: state.controller_temperature as f32,
        robot_voltage: supply_voltage(state.robot_mode) as f32,
        robot_current: robot_current(state, robot) as f32,
        io_current: io_current(state) as f32,
        safety_mode: state.safety_mode.number().cast_unsigned() as u8,
        is_reduced: state.safety_mode == SafetyMode::Reduced,
        ..Masterboard::default()
    }
}

fn tool(state: &RobotState, peripherals: &Peripherals) -> Tool {
    Tool {
        analog_out_domain: peripherals.analog_out_domains[2] as u8,
        analog_in_domain: peripherals.analog_in_domains[2] as u8,
        analog_out: state.analog_out[2],
        analog_in: state.analog_in[2],
        voltage: f32::from(peripherals.tool_voltage),
        output_voltage: peripherals.tool_voltage,
        current: tool_current(state) as f32,
        temperature: tool_temperature(state) as f32,
        mode: tool_mode(state.robot_mode),
    }
}

fn tool_communication(peripherals: &Peripherals) -> ToolCommunication {
    let Some(serial) = peripherals.tool_serial else {
        return ToolCommunication::default();
    };
    ToolCommunication {
        is_enabled: true,
        baud_rate: serial.baud_rate,
        parity: serial.parity,
        stop_bits: serial.stop_bits,
        modbus_rtu: serial.modbus_rtu,
        usage: u8::from(serial.for_daemon),
        ..ToolCommunication::default()
    }
}

#[cfg(test)]
mod tests;
