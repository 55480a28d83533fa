//! Process moves and offsets of the path as recordings show them: the TCP's speed over many short moves, and an offset
//! that is moved in and out within the limits of the arm.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "helpers fail by panicking"
)]

use crate::common::{Recording, eliteserver, read_recording};
use kinematics::RobotModel;

/// Runs a program and reads its recording.
fn recorded(program: &str) -> Recording {
    let temporary = tempfile::tempdir().unwrap();
    let script = temporary.path().join("process.script");
    let recording = temporary.path().join("process.mcap");
    std::fs::write(&script, program).unwrap();
    let ran = eliteserver()
        .arg("run")
        .arg(&script)
        .arg("--record")
        .arg(&recording)
        .output()
        .unwrap();
    let err = String::from_utf8_lossy(&ran.stderr);
    assert_eq!(ran.status.code(), Some(0), "{err}");
    read_recording(&recording)
}

/// Commanded TCP speeds of the process moves, m/s.
fn speeds(recording: &Recording) -> Vec<f64> {
    let cycles = recording.cycles.iter().filter(|c| c.mode == "movep");
    cycles
        .map(|cycle| {
            let [x, y, z] = [0, 1, 2].map(|axis| cycle.target_tcp_speed[axis]);
            (x * x + y * y + z * z).sqrt()
        })
        .collect()
}

/// No commanded joint is faster than it may be, and none changes its speed faster.
fn assert_within_limits(recording: &Recording) {
    let model = RobotModel::built_in("cs66").unwrap();
    let limits = model.limits();
    let step = recording.cycles[1].time - recording.cycles[0].time;
    for pair in recording.cycles.windows(2) {
        for joint in 0..6 {
            let (before, after) = (pair[0].target_qd[joint], pair[1].target_qd[joint]);
            let place = format!("joint {joint}, {} s", pair[1].time);
            assert!(after.abs() <= limits.speed.0[joint] + 1e-9, "{place}");
            let rate = (after - before).abs() / step;
            assert!(
                rate <= limits.acceleration.0[joint] * 1.01,
                "{place}: {rate}"
            );
        }
    }
}

#[test]
fn three_hundred_short_moves_keep_the_speed_that_was_asked_for() {
    for speed in [0.02, 0.2] {
        let program = format!(
            "def weld():
  movej([0, -1.57, 1.57, -1.57, -1.57, 0])
  start = get_target_tcp_pose()
  p = list(start)
  i = 0
  while i < 300:
    i = i + 1
    turn = 0.0015 * i / 0.4
    p[0] = start[0] - 0.4 * (1 - cos(turn))
    p[1] = start[1] + 0.4 * sin(turn)
    movep(p, {speed} * 18, {speed}, 0.0005)
  movep(p, {speed} * 18, {speed}, 0)
end
"
        );
        let recording = recorded(&program);
        let speeds = speeds(&recording);
        let is_kept = |v: &f64| (v / speed - 1.0).abs() <= 0.02;
        // Between reaching the speed and leaving it for the end.
        let first = speeds.iter().position(is_kept).unwrap();
        let last = speeds.iter().rposition(is_kept).unwrap();
        let off: Vec<_> = speeds[first..=last]
            .iter()
            .filter(|v| !is_kept(v))
            .collect();
        assert!(off.is_empty(), "{speed}: {off:?}");
        let way = (last - first) as f64 * 0.004 * speed;
        assert!(way > 0.42, "{speed}: only {way} m at the speed");
        assert_within_limits(&recording);
    }
}

#[test]
fn an_offset_moves_in_and_out_beside_a_process_move() {
    let recording = recorded(
        "def weave():
  movej([0, -1.57, 1.57, -1.57, -1.57, 0])
  start = get_target_tcp_pose()
  end_ = list(start)
  end_[1] = start[1] + 0.2
  path_offset_enable()
  def shift():
    i = 0
    while i < 400:
      i = i + 1
      path_offset_set([0.005 * (1 - cos(i / 200 * 3.14159265358979)) / 2, 0, 0, 0, 0, 0], 1)
      sync()
  t = start_thread(shift, ())
  movep(end_, 1.0, 0.1, 0)
  join_thread(t)
  path_offset_disable()
end
",
    );
    let moving = recording.cycles.iter().filter(|c| c.mode == "movep");
    let beside: Vec<f64> = moving.map(|c| c.target_tcp_pose[0]).collect();
    let start = beside[0];
    let farthest = beside.iter().map(|x| x - start).fold(0.0, f64::max);
    assert!((farthest - 0.005).abs() < 2e-5, "{farthest}");
    assert!((beside.last().unwrap() - start).abs() < 2e-5, "{beside:?}");
    assert_within_limits(&recording);
}
