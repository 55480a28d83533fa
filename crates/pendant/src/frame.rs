//! The binary frame: one moment of the robot in a fixed layout, little-endian, as pages and recordings' time lines get
//! it.
//!
//! Owns the layout, which `docs/api.md` describes and `web/src/frame.ts` reads. A new field goes to the end and makes
//! frames longer; a change of what is there is a new version.

use motion_api::RobotState;

/// Version of the layout.
pub const FRAME_VERSION: u16 = 1;

/// Length of a frame.
pub const FRAME_BYTES: usize = 392;

/// Offset of the simulated time.
const TIME_AT: usize = 8;
/// Offset of the first group of six.
const SIXES_AT: usize = 96;

/// What a frame says beside the state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FrameContext {
    /// Number of the frame in the stream that it is in.
    pub sequence: u32,
    /// The server's clock, ms since 1970: what a page measures its delay with.
    pub wall_ms: f64,
    /// The main task: 0 stopped, 1 running, 2 paused.
    pub task: u8,
    /// Line of its main thread, 0 for none.
    pub line: u32,
    /// Node of the pendant's task in which it is, 0 for none.
    pub node: u32,
    /// Number of the newest program.
    pub program: u32,
}

/// The frame of a state.
pub fn encode(state: &RobotState, beside: &FrameContext) -> [u8; FRAME_BYTES] {
    let mut frame = [0; FRAME_BYTES];
    let mut at = 0;
    let mut put = |bytes: &[u8]| {
        // The layout is shorter than the frame, as a test says; what would not fit is left out.
        if let Some(place) = frame.get_mut(at..at + bytes.len()) {
            place.copy_from_slice(bytes);
        }
        at += bytes.len();
    };
    put(&FRAME_VERSION.to_le_bytes());
    put(&(FRAME_BYTES as u16).to_le_bytes());
    put(&beside.sequence.to_le_bytes());
    put(&state.time.to_le_bytes());
    put(&state.cycle.to_le_bytes());
    put(&beside.wall_ms.to_le_bytes());
    put(&[
        byte(state.robot_mode.number()),
        byte(state.safety_mode.number()),
        byte(state.motion_mode.number()),
        beside.task,
    ]);
    put(&beside.line.to_le_bytes());
    put(&beside.node.to_le_bytes());
    put(&beside.program.to_le_bytes());
    let flags = u32::from(state.force_mode) | u32::from(state.collision_detection) << 1;
    put(&flags.to_le_bytes());
    put(&u32::try_from(state.stop_code)
        .unwrap_or(u32::MAX)
        .to_le_bytes());
    for number in [state.target_speed_fraction, state.speed_scaling] {
        put(&(number as f32).to_le_bytes());
    }
    // Bits 28 and up are none.
    put(&(state.digital_in as u32).to_le_bytes());
    put(&(state.digital_out as u32).to_le_bytes());
    for number in state.analog_in.iter().chain(&state.analog_out) {
        put(&(*number as f32).to_le_bytes());
    }
    let sixes = [
        &state.target_q.0,
        &state.actual_q.0,
        &state.target_qd.0,
        &state.actual_qd.0,
        &state.target_torque.0,
        &state.actual_torque.0,
        &state.target_tcp_pose.to_array(),
        &state.actual_tcp_pose.to_array(),
        &state.actual_tcp_speed,
        &state.tcp_force,
        &state.tcp_offset.to_array(),
        &state.joint_temperatures,
    ];
    for number in sixes.into_iter().flatten() {
        put(&(*number as f32).to_le_bytes());
    }
    put(&(state.controller_temperature as f32).to_le_bytes());
    put(&(state.step_duration_us as f32).to_le_bytes());
    frame
}

/// A mode as a byte; all of them are small, and -1 is 255.
fn byte(number: i32) -> u8 {
    number.rem_euclid(256) as u8
}

/// The simulated time of a frame, s.
pub fn time_of(frame: &[u8]) -> f64 {
    let bytes = frame.get(TIME_AT..TIME_AT + 8);
    let bytes: [u8; 8] = bytes
        .and_then(|bytes| bytes.try_into().ok())
        .unwrap_or_default();
    f64::from_le_bytes(bytes)
}

/// True when two frames of one stream show the same but for number, time and cycle: nothing has moved between them.
pub fn shows_the_same(a: &[u8], b: &[u8]) -> bool {
    a.get(32..SIXES_AT + 12 * 24) == b.get(32..SIXES_AT + 12 * 24)
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinematics::JointPositions;
    use motion_api::{MotionMode, RobotMode, SafetyMode};

    fn number(frame: &[u8], at: usize) -> f32 {
        f32::from_le_bytes(frame[at..at + 4].try_into().unwrap())
    }

    #[test]
    fn every_field_stands_where_the_document_says() {
        let mut state = RobotState::at_start(JointPositions([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), 0.004);
        state.time = 12.5;
        state.cycle = 3125;
        state.robot_mode = RobotMode::NoController;
        state.safety_mode = SafetyMode::ProtectiveStop;
        state.motion_mode = MotionMode::Unknown;
        state.stop_code = 7;
        state.force_mode = true;
        state.target_speed_fraction = 0.5;
        state.digital_out = 1 << 27;
        state.analog_out[2] = 9.5;
        state.tcp_force[5] = -3.5;
        state.joint_temperatures[5] = 41.0;
        state.step_duration_us = 12.0;
        let beside = FrameContext {
            sequence: 9,
            wall_ms: 1e12,
            task: 2,
            line: 17,
            node: 3,
            program: 4,
        };
        let frame = encode(&state, &beside);
        assert_eq!(&frame[..8], &[1, 0, 0x88, 1, 9, 0, 0, 0]);
        assert_eq!(time_of(&frame), 12.5);
        assert_eq!(frame[16..24], 3125_u64.to_le_bytes());
        assert_eq!(frame[24..32], 1e12_f64.to_le_bytes());
        assert_eq!(frame[32..36], [255, 3, 99, 2]);
        assert_eq!(frame[36..40], 17_u32.to_le_bytes());
        assert_eq!(frame[40..44], 3_u32.to_le_bytes());
        assert_eq!(frame[44..48], 4_u32.to_le_bytes());
        assert_eq!(frame[48..52], 3_u32.to_le_bytes());
        assert_eq!(frame[52..56], 7_u32.to_le_bytes());
        assert_eq!((number(&frame, 56), number(&frame, 60)), (0.5, 1.0));
        assert_eq!(frame[68..72], (1_u32 << 27).to_le_bytes());
        assert_eq!(number(&frame, 92), 9.5);
        assert_eq!(
            (number(&frame, SIXES_AT), number(&frame, SIXES_AT + 44)),
            (1.0, 6.0)
        );
        assert_eq!(number(&frame, SIXES_AT + 9 * 24 + 20), -3.5);
        assert_eq!(number(&frame, SIXES_AT + 11 * 24 + 20), 41.0);
        assert_eq!(number(&frame, 388), 12.0);
    }

    #[test]
    fn only_what_is_shown_counts_as_a_change() {
        let state = RobotState::at_start(JointPositions::ZERO, 0.004);
        let a = encode(&state, &FrameContext::default());
        let mut later = state;
        later.time = 1.0;
        later.cycle = 250;
        assert!(shows_the_same(
            &a,
            &encode(&later, &FrameContext::default())
        ));
        later.actual_q[3] = 1e-3;
        assert!(!shows_the_same(
            &a,
            &encode(&later, &FrameContext::default())
        ));
        assert_eq!(time_of(&a[..10]), 0.0);
    }
}
