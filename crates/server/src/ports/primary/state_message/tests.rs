//! The state message against two independent readings: the protocol page's offsets, and the one format string with
//! which field clients unpack the whole message.

#![allow(clippy::approx_constant, reason = "figures of the manual")]

use kinematics::{JointPositions, JointSpeeds, JointTorques, RpyPose};

use super::*;
use crate::ports::description::AnalogDomain;
use crate::ports::description::ToolSerial;
use motion_api::{RegisterImages, RobotMode};

/// A state in which no two fields are alike.
fn state() -> RobotState {
    let mut state = RobotState::at_start(JointPositions([0.1, -1.2, 1.3, -1.4, -1.5, 0.6]), 0.004);
    state.time = 12.5;
    state.target_q = JointPositions([0.11, -1.21, 1.31, -1.41, -1.51, 0.61]);
    state.actual_qd = JointSpeeds([0.01, 0.02, 0.03, 0.04, 0.05, 0.06]);
    state.actual_torque = JointTorques([6.0, 12.0, -24.0, 4.0, 2.0, 1.0]);
    state.actual_tcp_pose = RpyPose::from_array([0.41, 0.42, 0.43, 1.1, 1.2, 1.3]);
    state.tcp_offset = RpyPose::from_array([0.01, 0.02, 0.13, 0.3, 0.2, 0.1]);
    state.elbow_position = [0.31, 0.32, 0.33];
    state.target_speed_fraction = 0.75;
    state.speed_scaling = 0.5;
    state.safety_mode = SafetyMode::Reduced;
    state.digital_in = 0x0A0B_0C0D;
    state.digital_out = 0x0102_0304;
    state.analog_in = [1.25, 2.25, 3.25];
    state.analog_out = [4.25, 5.25, 6.25];
    state.io_config.analog_out[1] = AnalogDomain::Current;
    state.io_config.analog_out[2] = AnalogDomain::Current;
    state.io_config.tool_voltage = 24;
    state.joint_temperatures = [31.0, 32.0, 33.0, 34.0, 35.0, 36.0];
    state
}

fn peripherals() -> Peripherals {
    Peripherals {
        analog_in_domains: [
            AnalogDomain::Current,
            AnalogDomain::Voltage,
            AnalogDomain::Current,
        ],
        analog_out_domains: [
            AnalogDomain::Voltage,
            AnalogDomain::Current,
            AnalogDomain::Voltage,
        ],
        tool_voltage: 24,
        tool_pin_modes: [0; 4],
        tool_serial: Some(ToolSerial {
            baud_rate: 115_200,
            parity: 2,
            stop_bits: 1,
            modbus_rtu: true,
            for_daemon: true,
        }),
        freedrive: true,
        freedrive_by_input: true,
        collision_detection: true,
    }
}

fn message(state: &RobotState, task: TaskStatus) -> Vec<u8> {
    let sample = Sample {
        state: *state,
        task,
        script_line: 0,
        elbow_velocity: [0.0; 3],
        registers: RegisterImages::default(),
        peripherals: peripherals(),
    };
    encode_state(&sample, &RobotDescription::cs66())
}

/// Python's `struct.unpack(">…", bytes)`: counts before letters, every value as f64, and the rest of the bytes.
fn unpack<'a>(format: &str, mut bytes: &'a [u8]) -> (Vec<f64>, &'a [u8]) {
    let mut values = Vec::new();
    let mut count = String::new();
    for letter in format.chars().filter(|c| !c.is_whitespace()) {
        if letter.is_ascii_digit() {
            count.push(letter);
            continue;
        }
        for _ in 0..count.parse().unwrap_or(1) {
            let size = match letter {
                'B' | 'b' | '?' => 1,
                'I' | 'i' | 'f' => 4,
                'Q' | 'd' => 8,
                other => panic!("no such letter: {other}"),
            };
            let (field, rest) = bytes.split_at(size);
            bytes = rest;
            values.push(match letter {
                'B' | '?' => f64::from(field[0]),
                'b' => f64::from(field[0].cast_signed()),
                'I' => f64::from(u32::from_be_bytes(field.try_into().unwrap())),
                'i' => f64::from(i32::from_be_bytes(field.try_into().unwrap())),
                'f' => f64::from(f32::from_be_bytes(field.try_into().unwrap())),
                'Q' => u64::from_be_bytes(field.try_into().unwrap()) as f64,
                _ => f64::from_be_bytes(field.try_into().unwrap()),
            });
        }
        count.clear();
    }
    (values, bytes)
}

/// The parts by type, found by walking the chain of lengths as the SDK does.
fn parts(message: &[u8]) -> Vec<(u8, &[u8])> {
    let mut parts = Vec::new();
    let mut rest = &message[5..];
    while !rest.is_empty() {
        let length = u32::from_be_bytes(rest[..4].try_into().unwrap()) as usize;
        let (part, after) = rest.split_at(length);
        parts.push((part[4], part));
        rest = after;
    }
    parts
}

fn part(message: &[u8], kind: u8) -> Vec<u8> {
    let found = parts(message).into_iter().find(|(k, _)| *k == kind);
    found.unwrap().1.to_vec()
}

/// The values that `format` reads at `offset` of a part.
fn at(part: &[u8], offset: usize, format: &str) -> Vec<f64> {
    unpack(format, &part[offset..]).0
}

#[test]
fn order_and_sizes_are_those_that_fixed_format_clients_expect() {
    let message = message(&state(), TaskStatus::Running);
    assert_eq!(message.len(), STATE_MESSAGE_BYTES);
    assert_eq!(message[..10], [0, 0, 0x04, 0x85, 16, 0, 0, 0, 0x35, 0]);
    let sizes: Vec<_> = parts(&message)
        .iter()
        .map(|(kind, part)| (*kind, part.len()))
        .collect();
    assert_eq!(
        sizes,
        [
            (0, 53),
            (1, 347),
            (4, 101),
            (6, 445),
            (3, 88),
            (8, 10),
            (2, 37),
            (10, 43),
            (11, 28)
        ]
    );
}

#[test]
fn one_format_string_reads_the_whole_message() {
    let format = "IB
        IB Q 7? 2B 3d B 2? I
        IB 3d3I4fBI 3d3I4fBI 3d3I4fBI 3d3I4fBI 3d3I4fBI 3d3I4fBI
        IB 12d
        IB 53d 3I 4B
        IB 2I 3B3d 3B3d 4f B3?B
        IB 4?B
        IB 2B2dfB2fB
        IB Ib B 4d
        IB ?3I?B2f";
    let message = message(&state(), TaskStatus::Running);
    let (values, rest) = unpack(format, &message);
    assert!(rest.is_empty());
    // Head, robot mode data, then the first joint.
    assert_eq!(values[..5], [1157.0, 16.0, 53.0, 0.0, 12_500_000.0]);
    assert_eq!(values[21..26], [347.0, 1.0, 0.1, 0.11, 0.01]);
    assert_eq!(values[95..98], [101.0, 4.0, 0.41]);
    assert_eq!(values[166], 6206.0);
    assert_eq!(values[219..223], [0.31, 0.32, 0.33, 0.0625]);
    assert_eq!(values.len(), 233);
}

#[test]
fn robot_mode_data_stands_at_the_offsets_of_the_page() {
    let part = part(&message(&state(), TaskStatus::Paused), 0);
    assert_eq!(at(&part, 5, "Q"), [12_500_000.0]);
    assert_eq!(at(&part, 13, "7?"), [1.0, 1.0, 1.0, 0.0, 0.0, 1.0, 1.0]);
    assert_eq!(at(&part, 20, "2B"), [7.0, 0.0]);
    assert_eq!(at(&part, 22, "d"), [0.75]);
    assert_eq!(at(&part, 30, "d"), [0.5]);
    assert_eq!(at(&part, 38, "d"), [1.0]);
    assert_eq!(at(&part, 46, "B2?I"), [0.0; 4]);
}

#[test]
fn joint_data_stands_at_57_bytes_a_joint() {
    let state = state();
    let part = part(&message(&state, TaskStatus::Stopped), 1);
    for joint in 0..6 {
        let base = 5 + 57 * joint;
        assert_eq!(at(&part, base, "d"), [state.actual_q[joint]]);
        assert_eq!(at(&part, base + 8, "d"), [state.target_q[joint]]);
        assert_eq!(at(&part, base + 16, "d"), [state.actual_qd[joint]]);
        assert_eq!(at(&part, base + 24, "3i"), [0.0; 3]);
        let current = state.actual_torque[joint] / if joint < 3 { 12.0 } else { 8.0 };
        assert_eq!(at(&part, base + 36, "f"), [current]);
        assert_eq!(
            at(&part, base + 40, "2f"),
            [48.0, state.joint_temperatures[joint]]
        );
        assert_eq!(at(&part, base + 48, "f"), [state.actual_torque[joint]]);
        assert_eq!(at(&part, base + 52, "BI"), [253.0, 0.0]);
    }
}

#[test]
fn poses_limits_and_dh_stand_at_the_offsets_of_the_page() {
    let (state, robot) = (state(), RobotDescription::cs66());
    let message = message(&state, TaskStatus::Stopped);
    let cartesian = part(&message, 4);
    assert_eq!(at(&cartesian, 5, "6d"), state.actual_tcp_pose.to_array());
    assert_eq!(at(&cartesian, 53, "6d"), state.tcp_offset.to_array());

    let configuration = part(&message, 6);
    let tau = core::f64::consts::TAU;
    assert_eq!(
        at(&configuration, 5, "6d"),
        [-tau, tau, -tau, tau, -tau / 2.0, tau / 2.0]
    );
    assert_eq!(at(&configuration, 101, "2d"), [tau / 2.0, 20.0]);
    assert_eq!(
        at(&configuration, 197, "5d"),
        [1.047197, 1.396263, 0.25, 1.2, 0.0]
    );
    assert_eq!(at(&configuration, 237, "6d"), robot.dh_a);
    assert_eq!(at(&configuration, 285, "6d"), robot.dh_d);
    assert_eq!(at(&configuration, 333, "6d"), robot.dh_alpha);
    assert_eq!(at(&configuration, 381, "6d"), [0.0; 6]);
    assert_eq!(
        at(&configuration, 429, "3I4B"),
        [0.0, 0.0, 6206.0, 0.0, 0.0, 0.0, 0.0]
    );
}

#[test]
fn masterboard_data_stands_at_the_offsets_of_the_page() {
    let part = part(&message(&state(), TaskStatus::Stopped), 3);
    assert_eq!(at(&part, 5, "I"), [f64::from(0x0A0B_0C0D_u32)]);
    assert_eq!(at(&part, 9, "I"), [f64::from(0x0102_0304_u32)]);
    assert_eq!(at(&part, 13, "3B"), [0.0, 1.0, 0.0]);
    assert_eq!(at(&part, 16, "3d"), [1.25, 2.25, 3.25]);
    assert_eq!(at(&part, 40, "3B"), [1.0, 0.0, 1.0]);
    assert_eq!(at(&part, 43, "3d"), [4.25, 5.25, 6.25]);
    assert_eq!(at(&part, 67, "2f"), [35.0, 48.0]);
    // 0.5 + 1 + 2 + 0.5 + 0.25 + 0.125 A of the motors and 0.6 A of the box
    assert!((at(&part, 75, "f")[0] - 4.975).abs() < 1e-6);
    assert_eq!(
        at(&part, 79, "f"),
        [5.25],
        "of the output that is a current"
    );
    assert_eq!(at(&part, 83, "B3?B"), [2.0, 1.0, 0.0, 0.0, 0.0]);
}

#[test]
fn the_small_parts_stand_at_the_offsets_of_the_page() {
    let message = message(&state(), TaskStatus::Stopped);
    assert_eq!(at(&part(&message, 8), 5, "4?B"), [1.0, 0.0, 1.0, 1.0, 0.0]);
    assert_eq!(
        at(&part(&message, 2), 5, "2B2dfB2fB"),
        [1.0, 0.0, 6.25, 3.25, 24.0, 24.0, 6.25, 36.0, 253.0]
    );
    assert_eq!(
        at(&part(&message, 10), 5, "IbB4d"),
        [
            f64::from(0x5AFE_C0DE_u32),
            0.0,
            0.0,
            0.31,
            0.32,
            0.33,
            0.0625
        ]
    );
    assert_eq!(
        at(&part(&message, 11), 5, "?3I?B2f"),
        [1.0, 115_200.0, 2.0, 1.0, 1.0, 1.0, 0.0, 0.0]
    );
}

#[test]
fn modes_show_in_flags_and_joint_modes() {
    let mode = |mode: RobotMode, safety: SafetyMode| {
        let mut state = state();
        (state.robot_mode, state.safety_mode) = (mode, safety);
        let message = message(&state, TaskStatus::Running);
        let robot = part(&message, 0);
        (
            at(&robot, 15, "3?"),
            robot[20],
            part(&message, 1)[57],
            at(&part(&message, 1), 41, "2f"),
            part(&message, 3)[83],
        )
    };
    use RobotMode::*;
    assert_eq!(
        mode(PowerOff, SafetyMode::Normal),
        (vec![0.0; 3], 3, 239, vec![0.0, 0.0], 1)
    );
    assert_eq!(
        mode(Idle, SafetyMode::ProtectiveStop),
        (vec![1.0, 0.0, 1.0], 5, 255, vec![0.5, 48.0], 3)
    );
    assert_eq!(
        mode(Running, SafetyMode::RobotEmergencyStop),
        (vec![1.0, 1.0, 0.0], 7, 253, vec![0.5, 48.0], 7)
    );
    assert_eq!(
        mode(WaitingCalibration, SafetyMode::Fault),
        (vec![0.0; 3], 9, 239, vec![0.0, 0.0], 9)
    );
    assert_eq!(mode(NoController, SafetyMode::Normal).1, 255);
}

/// Guards against changes nobody meant; the bytes were checked with Python's struct module when they were made.
#[test]
fn the_bytes_are_golden() {
    let message = message(&state(), TaskStatus::Running);
    let lines: Vec<String> = message
        .chunks(32)
        .map(|chunk| chunk.iter().map(|b| format!("{b:02x}")).collect())
        .collect();
    insta::assert_snapshot!(lines.join("\n"));
}
