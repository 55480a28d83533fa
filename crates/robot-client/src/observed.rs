//! The state of a robot somewhere else, put together from what its controller sends over RTSI.
//!
//! Numbers that it does not send are not numbers here (NaN): a recording of it says what is known and no more.

use kinematics::{JointAccelerations, JointPositions, JointSpeeds, JointTorques, RpyPose};
use motion_api::{MotionMode, RobotMode, RobotState, SafetyMode};
use wire::rtsi::{Kind, Value};

/// What is asked for, in the order in which it is asked for.
pub const WANTED: &[&str] = &[
    "timestamp",
    "target_joint_positions",
    "target_joint_speeds",
    "actual_joint_positions",
    "actual_joint_speeds",
    "actual_joint_torques",
    "target_TCP_pose",
    "target_TCP_speed",
    "actual_TCP_pose",
    "actual_TCP_speed",
    "actual_TCP_force",
    "ft_raw_wrench",
    "actual_digital_input_bits",
    "actual_digital_output_bits",
    "standard_analog_input0",
    "standard_analog_input1",
    "tool_analog_input",
    "standard_analog_output0",
    "standard_analog_output1",
    "tool_analog_output",
    "joint_temperatures",
    "robot_mode",
    "safety_status",
    "speed_scaling",
    "target_speed_fraction",
    "elbow_position",
    "payload_mass",
    "payload_cog",
    "script_control_line",
    "runtime_state",
];

/// What comes beside the state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Beside {
    /// Time since the controller started, s.
    pub timestamp: Option<f64>,
    /// Line of the program that runs.
    pub line: Option<u32>,
    /// 1 playing, 2 paused, 3 stopped.
    pub runtime_state: Option<u32>,
}

/// A state of which nothing is known.
pub fn unknown_state(step_time: f64) -> RobotState {
    let six = [f64::NAN; 6];
    let pose = RpyPose::from_array(six);
    RobotState {
        target_q: JointPositions(six),
        target_qd: JointSpeeds(six),
        target_qdd: JointAccelerations(six),
        actual_q: JointPositions(six),
        actual_qd: JointSpeeds(six),
        target_torque: JointTorques(six),
        actual_torque: JointTorques(six),
        target_tcp_pose: pose,
        actual_tcp_pose: pose,
        target_tcp_speed: six,
        actual_tcp_speed: six,
        tcp_force: six,
        raw_wrench: six,
        elbow_position: [f64::NAN; 3],
        motion_mode: MotionMode::Unknown,
        target_speed_fraction: f64::NAN,
        speed_scaling: f64::NAN,
        robot_mode: RobotMode::NoController,
        safety_mode: SafetyMode::Undefined,
        analog_in: [f64::NAN; 3],
        analog_out: [f64::NAN; 3],
        external_torque: JointTorques(six),
        joint_temperatures: six,
        controller_temperature: f64::NAN,
        target_waypoint: pose,
        path_pose: pose,
        gravity: [f64::NAN; 3],
        encoder_counts: [f64::NAN; 2],
        collision_detection: false,
        path_offsets: [six; 3],
        ..RobotState::at_start(JointPositions(six), step_time)
    }
}

/// Takes values over into a state; what came beside it.
pub fn observe(
    state: &mut RobotState,
    offered: &[(&'static str, Kind)],
    values: &[Value],
) -> Beside {
    let mut beside = Beside::default();
    for ((name, _), value) in offered.iter().zip(values) {
        match (*name, *value) {
            ("timestamp", Value::F64(x)) => beside.timestamp = Some(x),
            ("script_control_line", Value::U32(x)) => beside.line = Some(x),
            ("runtime_state", Value::U32(x)) => beside.runtime_state = Some(x),
            ("target_joint_positions", Value::Vector6(x)) => state.target_q = JointPositions(x),
            ("target_joint_speeds", Value::Vector6(x)) => state.target_qd = JointSpeeds(x),
            ("actual_joint_positions", Value::Vector6(x)) => state.actual_q = JointPositions(x),
            ("actual_joint_speeds", Value::Vector6(x)) => state.actual_qd = JointSpeeds(x),
            ("actual_joint_torques", Value::Vector6(x)) => state.actual_torque = JointTorques(x),
            ("target_TCP_pose", Value::Vector6(x)) => {
                state.target_tcp_pose = RpyPose::from_array(x);
            }
            ("target_TCP_speed", Value::Vector6(x)) => state.target_tcp_speed = x,
            ("actual_TCP_pose", Value::Vector6(x)) => {
                state.actual_tcp_pose = RpyPose::from_array(x);
            }
            ("actual_TCP_speed", Value::Vector6(x)) => state.actual_tcp_speed = x,
            ("actual_TCP_force", Value::Vector6(x)) => state.tcp_force = x,
            ("ft_raw_wrench", Value::Vector6(x)) => state.raw_wrench = x,
            ("actual_digital_input_bits", Value::U32(x)) => state.digital_in = u64::from(x),
            ("actual_digital_output_bits", Value::U32(x)) => state.digital_out = u64::from(x),
            ("standard_analog_input0", Value::F64(x)) => state.analog_in[0] = x,
            ("standard_analog_input1", Value::F64(x)) => state.analog_in[1] = x,
            ("tool_analog_input", Value::F64(x)) => state.analog_in[2] = x,
            ("standard_analog_output0", Value::F64(x)) => state.analog_out[0] = x,
            ("standard_analog_output1", Value::F64(x)) => state.analog_out[1] = x,
            ("tool_analog_output", Value::F64(x)) => state.analog_out[2] = x,
            ("joint_temperatures", Value::Vector6(x)) => state.joint_temperatures = x,
            ("robot_mode", Value::I32(x)) => state.robot_mode = RobotMode::from_number(x),
            ("safety_status", Value::I32(x)) => state.safety_mode = SafetyMode::from_number(x),
            ("speed_scaling", Value::F64(x)) => state.speed_scaling = x,
            ("target_speed_fraction", Value::F64(x)) => state.target_speed_fraction = x,
            ("elbow_position", Value::Vector3(x)) => state.elbow_position = x,
            ("payload_mass", Value::F64(x)) => state.payload.mass = x,
            ("payload_cog", Value::Vector3(x)) => state.payload.cog = x.into(),
            // A type that is not the one of the protocol: the value is not known.
            _ => {}
        }
    }
    beside
}
