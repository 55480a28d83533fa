//! What ports send beside the snapshot: values that follow from it, and those a simulated arm has no physics for.
//!
//! One place for all ports, so that they agree.

use motion_api::{RobotMode, RobotState};

use crate::ports::description::RobotDescription;

/// Temperature of the tool, °C.
pub const TOOL_CELSIUS: f64 = 30.0;

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

/// The mode of every joint and of the tool follows the robot's (SDK include/Elite/DataType.hpp).
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

/// Current of the whole robot, A.
pub fn robot_current(state: &RobotState, robot: &RobotDescription) -> f64 {
    let motors = (0..6).map(|joint| joint_current(state, robot, joint).abs());
    if is_powered(state.robot_mode) {
        IDLE_AMPERES + motors.sum::<f64>()
    } else {
        0.0
    }
}
