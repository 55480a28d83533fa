//! One program, sent over a real socket, moves the arm, and every cycle is on disk.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::needless_range_loop,
    clippy::approx_constant,
    reason = "helpers fail by panicking; joints are counted; the numbers are those of the example program"
)]

use crate::common::{Recording, Server, alone, first_light, read_recording, run_script};
use kinematics::{JointPositions, Pose, RobotModel, RpyPose};
use recorder::cycle::CycleMessage;

/// End of the last movej of the example.
const LAST_TARGET: [f64; 6] = [-0.3, -1.3708, 1.5708, -1.7708, -1.5708, 0.2];
/// What the example adds to the pose for its movel: x, y, z and yaw.
const LINE: [f64; 3] = [-0.10, 0.25, -0.08];
const STEP: f64 = 0.004;

#[test]
fn a_program_sent_to_30001_moves_the_arm_and_every_cycle_is_recorded() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &["--record", "out.mcap"]);
    let mut client = server.primary();
    let before = client.state();
    assert_eq!(before.robot_mode, 7);
    assert_eq!(before.digital_out, 0);
    assert!(!before.task_running);

    client.send(&first_light());
    client.wait_for("the program starts", |s| s.task_running);
    let after = client.wait_for("the program ends", |s| !s.task_running);
    assert_eq!(after.digital_out & 0b10, 0b10, "output 1 is on");
    assert_eq!(
        after.digital_out & 0b01,
        0,
        "output 0 was switched off last"
    );
    for joint in 0..6 {
        assert!((after.target_q[joint] - LAST_TARGET[joint]).abs() < 1e-9);
        assert!(
            (after.actual_q[joint] - LAST_TARGET[joint]).abs() < 1e-3,
            "{after:?}"
        );
    }
    assert_eq!(server.terminate().code(), Some(0));

    let recording = read_recording(&folder.path().join("out.mcap"));
    assert_cycles_have_no_gaps(&recording.cycles);
    assert_limits_are_kept(&recording.cycles);
    assert_targets_are_reached(&recording);
    assert_line_is_straight(&recording.cycles);
    assert!(recording.cycles.last().unwrap().digital_out & 0b10 != 0);
    assert!(
        recording.log.iter().any(|text| text.contains("blinked 4")),
        "{:?}",
        recording.log
    );
    for topic in [
        "/joint_states",
        "/tf",
        "/tcp",
        "/scene",
        "/script",
        "/command",
    ] {
        assert!(
            recording.counts.contains_key(topic),
            "{topic} is missing: {:?}",
            recording.counts
        );
    }
}

#[test]
fn the_virtual_clock_gives_identical_recordings() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    let record = |name: &str| {
        let output = run_script(folder.path(), &first_light(), &["--record", name]);
        assert_eq!(
            output.status.code(),
            Some(0),
            "{}",
            String::from_utf8_lossy(&output.stderr)
        );
        read_recording(&folder.path().join(name))
    };
    let (first, second) = (record("first.mcap"), record("second.mcap"));
    assert!(first.cycles.len() > 800, "{} cycles", first.cycles.len());
    assert_eq!(first.cycles, second.cycles);
    assert_eq!(first.json, second.json);
    assert_cycles_have_no_gaps(&first.cycles);
    assert_limits_are_kept(&first.cycles);
    assert_targets_are_reached(&first);
    assert_line_is_straight(&first.cycles);
    assert!(
        first
            .cycles
            .iter()
            .all(|c| c.step_duration_us == 0.0 && c.wakeup_latency_us == 0.0)
    );
}

fn assert_cycles_have_no_gaps(cycles: &[CycleMessage]) {
    assert_eq!(cycles[0].cycle, 1);
    for pair in cycles.windows(2) {
        assert_eq!(pair[1].cycle, pair[0].cycle + 1);
        assert!((pair[1].time - pair[0].time - STEP).abs() < 1e-9);
    }
}

/// Commanded speed, acceleration and jerk, taken from the commanded positions alone by differences.
fn assert_limits_are_kept(cycles: &[CycleMessage]) {
    let limits = *RobotModel::built_in("cs66").unwrap().limits();
    // The example's movej calls ask for at most 1.5 rad/s and 2 rad/s²; its line may use the arm's own limits.
    for joint in 0..6 {
        let q: Vec<f64> = cycles.iter().map(|c| c.target_q[joint]).collect();
        let qd: Vec<f64> = q.windows(2).map(|w| (w[1] - w[0]) / STEP).collect();
        let qdd: Vec<f64> = qd.windows(2).map(|w| (w[1] - w[0]) / STEP).collect();
        let qddd: Vec<f64> = qdd.windows(2).map(|w| (w[1] - w[0]) / STEP).collect();
        for (k, cycle) in cycles.iter().enumerate().skip(3) {
            let (speed, acceleration) = match cycle.mode.as_str() {
                "movej" => (1.5, 2.0),
                _ => (limits.speed[joint], limits.acceleration[joint]),
            };
            // Reached in 20 ms at the earliest.
            let jerk = limits.acceleration[joint] / 0.020;
            let place = format!("joint {joint}, cycle {}, {}", cycle.cycle, cycle.mode);
            assert!(
                qd[k - 1].abs() <= speed * (1.0 + 1e-6) + 1e-9,
                "{place}: speed {}",
                qd[k - 1]
            );
            assert!(
                qdd[k - 2].abs() <= acceleration * (1.0 + 1e-6) + 1e-6,
                "{place}: acc {}",
                qdd[k - 2]
            );
            assert!(
                qddd[k - 3].abs() <= jerk * (1.0 + 1e-6) + 1e-3,
                "{place}: jerk {}",
                qddd[k - 3]
            );
        }
    }
}

/// The last cycle of each motion, in order.
fn ends_of_motions(recording: &Recording) -> Vec<&CycleMessage> {
    let moves: Vec<u64> = recording.json["/command"]
        .iter()
        .filter(|c| matches!(c["name"].as_str(), Some("movej" | "movel")))
        .map(|c| c["id"].as_u64().unwrap())
        .collect();
    moves
        .iter()
        .map(|id| {
            recording
                .cycles
                .iter()
                .rfind(|c| c.command_id == *id)
                .expect("the motion has cycles")
        })
        .collect()
}

fn assert_targets_are_reached(recording: &Recording) {
    let ends = ends_of_motions(recording);
    assert_eq!(
        ends.iter().map(|c| c.mode.as_str()).collect::<Vec<_>>(),
        ["movej", "movel", "movej"]
    );
    let wanted = [
        Some([0.35, -1.45, 1.75, -1.87, -1.57, 0.35]),
        None,
        Some(LAST_TARGET),
    ];
    for (end, wanted) in ends.iter().zip(wanted) {
        // The command has ended, so the target of its last cycle or of the next one is the goal.
        let after = recording
            .cycles
            .iter()
            .find(|c| c.cycle == end.cycle + 1)
            .unwrap_or(end);
        if let Some(wanted) = wanted {
            for joint in 0..6 {
                assert!(
                    (after.target_q[joint] - wanted[joint]).abs() < 1e-9,
                    "{after:?}"
                );
                assert!(
                    (after.actual_q[joint] - wanted[joint]).abs() < 1e-3,
                    "{after:?}"
                );
            }
        }
    }
    let last = recording.cycles.last().unwrap();
    for joint in 0..6 {
        assert!((last.actual_q[joint] - LAST_TARGET[joint]).abs() < 1e-3);
    }
}

/// The commanded TCP stays on the line from where it was to where the program sent it, and arrives there.
fn assert_line_is_straight(cycles: &[CycleMessage]) {
    let model = RobotModel::built_in("cs66").unwrap();
    let first = cycles
        .iter()
        .position(|c| c.mode == "movel")
        .expect("the program has a movel");
    let tcp = |c: &CycleMessage| {
        let q: [f64; 6] = c.target_q.clone().try_into().unwrap();
        model.tcp_pose(&JointPositions(q), &Pose::IDENTITY)
    };
    let line: Vec<Pose> = cycles[first - 1..]
        .iter()
        .take_while(|c| c.mode != "movej")
        .map(tcp)
        .collect();
    let start = line[0];
    let asked_from = {
        // The program reads the actual pose, so the line ends relative to that.
        let q: [f64; 6] = cycles[first - 1].actual_q.clone().try_into().unwrap();
        model.tcp_pose(&JointPositions(q), &Pose::IDENTITY).to_rpy()
    };
    let end = line.last().unwrap();
    let direction = (end.translation - start.translation).normalize();
    let mut last_along = -1e-12;
    for pose in &line {
        let offset = pose.translation - start.translation;
        let along = offset.dot(&direction);
        assert!(
            (offset - direction * along).norm() < 1e-6,
            "off the line by {:?}",
            offset - direction * along
        );
        assert!(along >= last_along - 1e-9, "goes back");
        last_along = along;
    }
    for axis in 0..3 {
        let wanted = asked_from.xyz[axis] + LINE[axis];
        assert!((end.translation[axis] - wanted).abs() < 1e-3, "axis {axis}");
    }
    let turned = RpyPose {
        rpy: [
            asked_from.rpy[0],
            asked_from.rpy[1],
            asked_from.rpy[2] + 0.5,
        ],
        ..asked_from
    };
    let error = Pose::from_rpy(&turned)
        .rotation
        .rotation_to(&end.rotation)
        .angle();
    assert!(error < 1e-3, "orientation off by {error} rad");
}
