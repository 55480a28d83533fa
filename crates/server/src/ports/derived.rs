//! What ports send beside the snapshot: values that follow from it.
//!
//! One place for all ports, so that they agree.

use motion_api::{AnalogDomain, RobotMode, RobotState};

use crate::ports::description::RobotDescription;

const SUPPLY_VOLTS: f64 = 48.0;
/// What the control box draws when the arm stands, A.
const IDLE_AMPERES: f64 = 0.6;

/// Power is on the joints from IDLE on; the two higher numbers are modes of a robot in maintenance.
pub const fn is_powered(mode: RobotMode) -> bool {
    matches!(
        mode,
        RobotMode::Idle | RobotMode::Backdrive | RobotMode::Running
    )
}

/// The mode of the tool: numbers as those of a joint, but it has neither motor nor brake, so the SDK knows no "motor
/// initialisation" and no "backdrive" for it.
pub const fn tool_mode(mode: RobotMode) -> u8 {
    match mode {
        RobotMode::PowerOn => joint_mode(RobotMode::Booting),
        RobotMode::Backdrive => joint_mode(RobotMode::Running),
        other => joint_mode(other),
    }
}

/// The mode of every joint follows the robot's (SDK include/Elite/DataType.hpp).
pub const fn joint_mode(mode: RobotMode) -> u8 {
    match mode {
        RobotMode::Running => 253,
        RobotMode::Idle => 255,
        RobotMode::Backdrive => 238,
        RobotMode::PowerOn => 246,
        RobotMode::Booting => 247,
        RobotMode::UpdatingFirmware => 249,
        RobotMode::NoController => 245,
        RobotMode::Disconnected
        | RobotMode::ConfirmSafety
        | RobotMode::PowerOff
        | RobotMode::WaitingCalibration => 239,
    }
}

/// Voltage of the robot and its joints, V.
pub const fn supply_voltage(mode: RobotMode) -> f64 {
    if is_powered(mode) { SUPPLY_VOLTS } else { 0.0 }
}

/// Motor current of a joint, A.
pub fn joint_current(state: &RobotState, robot: &RobotDescription, joint: usize) -> f64 {
    if is_powered(state.robot_mode) {
        state.actual_torque[joint] / robot.torque_per_ampere[joint]
    } else {
        0.0
    }
}

/// Temperature of the tool connector, °C: its board sits in the housing of joint 6.
pub const fn tool_temperature(state: &RobotState) -> f64 {
    state.joint_temperatures[5]
}

/// What leaves the box through its outputs, A: analog outputs that carry a current. Digital outputs lead to inputs,
/// whose current nobody has described.
pub fn io_current(state: &RobotState) -> f64 {
    output_current(state, 0) + output_current(state, 1)
}

/// What leaves the tool connector, A; nothing without its supply.
pub fn tool_current(state: &RobotState) -> f64 {
    match state.io_config.tool_voltage {
        0 => 0.0,
        _ => output_current(state, 2),
    }
}

fn output_current(state: &RobotState, port: usize) -> f64 {
    match state.io_config.analog_out[port] {
        AnalogDomain::Current => state.analog_out[port],
        AnalogDomain::Voltage => 0.0,
    }
}

/// Current of the whole robot, A.
pub fn robot_current(state: &RobotState, robot: &RobotDescription) -> f64 {
    let motors = (0..6).map(|joint| joint_current(state, robot, joint).abs());
    if is_powered(state.robot_mode) {
        IDLE_AMPERES + motors.sum::<f64>()
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joints_and_tool_have_only_modes_that_the_sdk_knows() {
        let joint = [
            235, 236, 238, 239, 240, 245, 246, 247, 249, 251, 252, 253, 255,
        ];
        for mode in (-1..=9).map(RobotMode::from_number) {
            assert!(joint.contains(&joint_mode(mode)), "{mode:?}");
            let no_mode_of_a_tool = [238, 240, 246, 251].contains(&tool_mode(mode));
            assert!(
                joint.contains(&tool_mode(mode)) && !no_mode_of_a_tool,
                "{mode:?}"
            );
        }
    }
}
