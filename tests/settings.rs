//! What takes no time: settings of a program are in the cycle that follows, in the program's order, and the program
//! goes on.
//!
//! `crates/elite-runtime/tests/zero_time.rs` calls every such builtin; here the real cycle carries them out.

#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

use crate::common::{self, read_recording, run_script};

/// Runs a program that must end well; its recording.
fn recorded(text: &str, cell: &str) -> common::Recording {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cell.toml"), cell).unwrap();
    let output = run_script(
        folder.path(),
        text,
        &["--record", "out.mcap", "--cell", "cell.toml"],
    );
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{error}");
    read_recording(&folder.path().join("out.mcap"))
}

#[test]
fn hundreds_of_settings_are_all_there_in_the_next_cycle() {
    let text = "def main():
  encoder_enable_set_tick_count(0, 2)
  sync()
  set_standard_digital_out(0, True)
  for k in range(200):
    set_tcp([0, 0, 0.001 * k, 0, 0, 0])
    encoder_set_tick_count(0, k)
  end
  set_payload(1.5, [0, 0, 0.05])
  set_gravity([0, 0, 9.5])
  set_collision_detect_enabled(False)
  set_dyn_collision_force_min_ratio(77)
  force_mode([0] * 6, [0] * 6, [0] * 6, 0, [0] * 6)
  set_standard_digital_out(1, True)
  sync()
  set_standard_digital_out(2, True)
  sync()
end
";
    let recording = recorded(text, "");
    let cycles = &recording.cycles;
    let first_with = |bit: u64| {
        let is_set = |c: &recorder::cycle::CycleMessage| c.digital_out >> bit & 1 == 1;
        cycles.iter().position(is_set).unwrap()
    };
    let at = first_with(0);
    // The first and the last of four hundred commands are taken by one cycle, which shows what they have set.
    assert_eq!(first_with(1), at);
    assert_eq!(first_with(2), at + 1);
    let state = cycles[at].to_state().unwrap();
    assert_eq!(state.tcp_offset.xyz, [0.0, 0.0, 0.199]);
    assert_eq!(state.encoder_counts[0], 199.0);
    assert_eq!(state.payload.mass, 1.5);
    assert_eq!(state.gravity, [0.0, 0.0, -9.5]);
    assert!(!state.collision_detection && state.collision_sensitivity == 77);
    assert!(state.force_mode);
    let before = cycles[at - 1].to_state().unwrap();
    assert!(before.tcp_offset.xyz == [0.0; 3] && !before.force_mode);
}

#[test]
fn a_motion_behind_the_end_of_a_mode_waits_until_the_arm_has_come_to_rest() {
    // A hand that pushes: in both modes the arm moves when they are ended.
    let cell = "[[wrench]]\nat = 0.1\nduration = 100\nwrench = [0, 0, -20, 0, 0, 0]\n";
    for begin in [
        "freedrive_mode()",
        "force_mode([0] * 6, [0, 0, 1, 0, 0, 0], [0] * 6, 0, [0.2] * 6)",
    ] {
        let end = if begin.starts_with("free") {
            "end_freedrive_mode()"
        } else {
            "end_force_mode()"
        };
        for motion in [
            "movej([0.2, -1.5, 1.5, -1.5, -1.5, 0])",
            "movel(pose_add(get_target_tcp_pose(), [0, 0, 0.05, 0, 0, 0]))",
        ] {
            let text = format!(
                "def main():
  import time
  force_mode_set_gain_scaling(1)
  {begin}
  sleep(0.5)
  begin = time.time()
  set_standard_digital_out(0, True)
  {end}
  {end}
  assert time.time() == begin
  {motion}
end
"
            );
            let recording = recorded(&text, cell);
            let cycles = &recording.cycles;
            let at = cycles.iter().position(|c| c.digital_out & 1 == 1).unwrap();
            let speed = |k: usize| {
                cycles[k]
                    .target_qd
                    .iter()
                    .fold(0.0_f64, |m, x| m.max(x.abs()))
            };
            assert!(speed(at - 1) > 0.005, "{begin} {motion}: {}", speed(at - 1));
            // At rest in between, then it moves to its end.
            let rest = (at..cycles.len()).find(|k| speed(*k) == 0.0).unwrap();
            let most = (rest..cycles.len()).map(speed).fold(0.0, f64::max);
            assert!(most > 0.02, "{begin} {motion}: it moves {most}");
        }
    }
}

#[test]
fn modes_begun_and_ended_hundreds_of_times_in_a_cycle_end_as_the_last_call_says() {
    let text = "def main():
  import time
  begin = time.time()
  for k in range(100):
    freedrive_mode()
    end_freedrive_mode()
    force_mode([0] * 6, [0, 0, 1, 0, 0, 0], [0] * 6, 0, [0.1] * 6)
    end_force_mode()
  end
  assert time.time() == begin
  sync()
  movej([0.1, -1.5, 1.5, -1.5, -1.5, 0])
  force_mode([0] * 6, [0] * 6, [0] * 6, 0, [0] * 6)
  end_force_mode()
  track_conveyor_linear([1, 0, 0, 0, 0, 0], 1000)
  stop_conveyor_tracking()
  movej([0, -1.5, 1.5, -1.5, -1.5, 0])
end
";
    let recording = recorded(text, "");
    let last = recording.cycles.last().unwrap().to_state().unwrap();
    assert!(!last.force_mode && last.target_q[0].abs() < 1e-9);
    assert!(
        !recording.log.iter().any(|line| line.contains("refused")),
        "{:?}",
        recording.log
    );
}

#[test]
fn a_caller_sees_what_it_has_set_before_any_cycle_has_taken_it() {
    let text = "def main():
  import time
  begin = time.time()
  flange = get_actual_tool_flange_pose()
  joints = get_target_joint_positions()
  for k in range(200):
    tcp = [0.001 * k, 0, 0.1, 0, 0, 0.01 * k]
    set_tcp(tcp)
    pose = get_target_tcp_pose()
    assert get_tcp_offset() == tcp
    assert pose_dist(pose, pose_trans(flange, tcp)) < 1e-9
    assert pose_dist(get_forward_kin(), pose) < 1e-9
    q = get_inverse_kin(pose)
    assert max([abs(a - b) for a, b in zip(q, joints)]) < 1e-6
    set_payload(0.01 * k, [0, 0, 0.001 * k])
    assert get_target_payload_mass() == 0.01 * k
    assert get_target_payload_cog() == [0, 0, 0.001 * k]
  end
  encoder_enable_set_tick_count(0, 2)
  assert encoder_get_tick_count(0) == 0
  encoder_set_tick_count(0, 65000)
  assert encoder_get_tick_count(0) == 65000
  assert encoder_unwind_delta_tick_count(0, 65000) == -536
  encoder_enable_pulse_decode(0, 1, 16, 17)
  assert encoder_get_tick_count(0) == 0
  set_collision_detect_enabled(False)
  assert not is_collision_detect_enabled()
  set_dyn_collision_force_min_ratio(33)
  assert get_dyn_collision_force_min_ratio() == 33
  zero_ftsensor()
  assert force() == 0 and get_tcp_force(True) == [0] * 6
  assert time.time() == begin
  sync()
  # The cycle says the same.
  assert pose_dist(get_target_tcp_pose(), pose) < 1e-9
  assert get_tcp_offset() == tcp and get_target_payload_mass() == 0.01 * 199
  assert get_dyn_collision_force_min_ratio() == 33 and not is_collision_detect_enabled()
end
";
    recorded(text, "");
}
