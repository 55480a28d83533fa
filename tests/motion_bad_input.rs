//! Everything that motion commands must not take, as scripts type it: what each answers, and that the arm never moves.
//!
//! The answers are golden texts (`tests/snapshots`); `INSTA_UPDATE=always` writes them, the difference is what has to
//! be reviewed.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "helpers fail by panicking"
)]

use std::fmt::Write as _;

use crate::common::{read_recording, run_script};

/// A table to keep off.
const CELL: &str = "[[safety_plane]]\nname = \"table\"\npoint = [0, 0, 0.2]\nnormal = [0, 0, 1]\n";

/// What programs below begin with: where the arm stands.
const HEAD: &str = "q = get_target_joint_positions()\n\
                    p = get_target_tcp_pose()\n\
                    def moved(dx, dy, dz):\n    return [p[0] + dx, p[1] + dy, p[2] + dz, p[3], p[4], p[5]]\nend\n";

/// The answer to each call, and the states of the whole run.
fn answers(calls: &[&str]) -> String {
    let mut script = HEAD.to_owned();
    for call in calls {
        writeln!(
            script,
            "try:\n    {call}\nexcept Exception as e:\n    print(type(e).__name__ + \":\", e)\nelse:\n\
             \x20   print(\"taken\")\nend"
        )
        .unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("cell.toml"), CELL).unwrap();
    let options = [
        "--plant",
        "ideal",
        "--cell",
        "cell.toml",
        "--record",
        "out.mcap",
    ];
    let output = run_script(folder.path(), &script, &options);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    let printed = String::from_utf8(output.stdout).unwrap();
    let answers: Vec<&str> = printed.lines().collect();
    assert_eq!(answers.len(), calls.len(), "{printed}");
    let recording = read_recording(&folder.path().join("out.mcap"));
    let first = &recording.cycles[0];
    for cycle in &recording.cycles {
        assert_eq!(cycle.target_q, first.target_q, "the arm moved\n{printed}");
        assert_eq!(cycle.safety_mode, first.safety_mode);
    }
    let lines = calls.iter().zip(answers);
    lines.fold(String::new(), |text, (call, answer)| {
        text + call + "\n    " + answer + "\n"
    })
}

#[test]
fn wrong_lengths_and_types_are_told() {
    insta::assert_snapshot!(answers(&[
        "movej([0, 0, 0])",
        "movej([0, 0, 0, 0, 0, 0, 0])",
        "movej([])",
        "movej(0.5)",
        "movej(None)",
        "movej('home')",
        "movej([0, 0, 0, 0, 0, 'x'])",
        "movej([0, 0, 0, 0, 0, [0]])",
        "movej(q, a='fast')",
        "movej(q, speed=1)",
        "movej()",
        "movel([0.3, 0.2])",
        "movel(p, r=None)",
        "movec(p)",
        "movec([0, 0, 0], p)",
        "movec(p, [0, 0, 0])",
        "servoj([0, 0, 0, 0, 0])",
        "speedj([0, 0, 0], 1, 1)",
        "speedl([0, 0, 0], 1, 1)",
        "speedl(0.1, 1, 1)",
        "set_tcp([0, 0, 0])",
        "set_payload('heavy', [0, 0, 0])",
        "freedrive_mode([1, 1, 1])",
        "track_conveyor_linear([1, 0, 0], 1000)",
    ]));
}

#[test]
fn numbers_that_are_none_or_too_large_are_told() {
    insta::assert_snapshot!(answers(&[
        "movej([0, 0, 0, 0, 0, float('nan')])",
        "movej([0, 0, float('inf'), 0, 0, 0])",
        "movej(q, a=float('nan'))",
        "movej(q, v=float('inf'))",
        "movej(q, t=float('nan'))",
        "movej(q, r=float('nan'))",
        "movej(q, v=1e308)",
        "movej([0, 0, 0, 0, 0, 1e300])",
        "movel([float('nan'), 0, 0, 0, 0, 0])",
        "movel(moved(1e300, 0, 0))",
        "movel(moved(0.1, 0, 0), v=float('nan'))",
        "movec(moved(float('nan'), 0, 0), moved(0.1, 0.1, 0))",
        "servoj([float('nan'), 0, 0, 0, 0, 0])",
        "servoj(q, t=float('inf'))",
        "servoj(q, lookahead_time=float('nan'))",
        "speedj([float('nan'), 0, 0, 0, 0, 0], 1, 1)",
        "speedl([0, 0, float('inf'), 0, 0, 0], 1, 1)",
        "stopj(float('nan'))",
        "stopl(float('inf'))",
        "set_tcp([0, 0, float('nan'), 0, 0, 0])",
        "set_gravity([0, 0, float('nan')])",
        "track_conveyor_linear([float('nan'), 0, 0, 0, 0, 0], 1000)",
    ]));
}

#[test]
fn speeds_times_and_radii_that_cannot_be_are_told() {
    insta::assert_snapshot!(answers(&[
        "movej(q, a=0)",
        "movej(q, a=-1)",
        "movej(q, v=0)",
        "movej(q, v=-0.5)",
        "movej(q, t=-1)",
        "movej(q, r=-0.05)",
        "movel(moved(0.1, 0, 0), a=0)",
        "movel(moved(0.1, 0, 0), v=0)",
        "movel(moved(0.1, 0, 0), v=-0.25)",
        "movel(moved(0.1, 0, 0), t=-1)",
        "movel(moved(0.1, 0, 0), r=-1)",
        "movec(moved(0.05, 0.05, 0), moved(0.1, 0, 0), a=0)",
        "movec(moved(0.05, 0.05, 0), moved(0.1, 0, 0), v=0)",
        "movec(moved(0.05, 0.05, 0), moved(0.1, 0, 0), r=-1)",
        "servoj(q, t=0)",
        "servoj(q, t=-0.004)",
        "servoj(q, lookahead_time=0.01)",
        "servoj(q, lookahead_time=1)",
        "servoj(q, gain=99)",
        "servoj(q, gain=2001)",
        "speedj([0.1, 0, 0, 0, 0, 0], 0, 1)",
        "speedj([0.1, 0, 0, 0, 0, 0], 1, -1)",
        "speedl([0, 0, 0.1, 0, 0, 0], -1, 1)",
        "speedl([0, 0, 0.1, 0, 0, 0], 1, 1, aRot=-1)",
        "stopj(0)",
        "stopl(-2)",
        "set_payload(-1, [0, 0, 0])",
        "set_payload(1000, [0, 0, 0])",
    ]));
}

#[test]
fn targets_that_the_arm_must_not_or_cannot_reach_are_refused_before_it_moves() {
    insta::assert_snapshot!(answers(&[
        "movej([0, 0, 4, 0, 0, 0])",
        "movej([7, 0, 0, 0, 0, 0])",
        "servoj([0, 0, 4, 0, 0, 0])",
        "movel([3, 0, 0.5, 0, 0, 0])",
        "movel(moved(-2, 0, 0))",
        "movec(moved(-1, 0.1, 0), moved(-2, 0, 0))",
        "movec(moved(0, 0.1, 0), moved(0, 0.2, 0))",
        "movec(p, moved(0, 0.2, 0))",
        "movec(moved(0, 0.1, 0), p)",
        "movel(moved(0, 0, 0.15 - p[2]))",
        "movel(moved(0, 0, 0.15 - p[2]), r=0.05)",
        "movec(moved(0.05, 0.1, 0), moved(0, 0.1, 0.15 - p[2]))",
        "movej(get_inverse_kin(moved(0, 0, 0.15 - p[2])))",
        "movej([0, -1.5708, 1.5708, -1.5708, -1.5708, 0], r=10)",
    ]));
}

#[test]
fn a_second_thread_cannot_move_the_arm_and_does_not_disturb_it() {
    let script = "def other():\n\
                  \x20   for move in [lambda: movej([0]*6), lambda: movel(p), lambda: movec(p, p), lambda: servoj(q), \
                  lambda: speedj([0.1]*6, 1, 0.1), lambda: speedl([0.1]*6, 1, 0.1), lambda: freedrive_mode()]:\n\
                  \x20       try:\n            move()\n            print(\"taken\")\n\
                  \x20       except Exception as e:\n            print(type(e).__name__ + \":\", e)\n        end\n\
                  \x20   end\nend\n\
                  t = start_thread(other, ())\n\
                  movej([q[0] + 1, q[1], q[2], q[3], q[4], q[5]])\n\
                  join_thread(t)\n\
                  print(get_target_joint_positions()[0] == q[0] + 1)\n";
    let folder = tempfile::tempdir().unwrap();
    let options = ["--plant", "ideal", "--record", "out.mcap"];
    let output = run_script(folder.path(), &(HEAD.to_owned() + script), &options);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(0), "{said}");
    insta::assert_snapshot!(String::from_utf8(output.stdout).unwrap());
    // The one motion is what it is alone: smooth, and of one joint.
    let recording = read_recording(&folder.path().join("out.mcap"));
    for pair in recording.cycles.windows(2) {
        let step = pair[1].target_q[0] - pair[0].target_q[0];
        assert!((0.0..0.0045).contains(&step), "{step}");
        assert_eq!(pair[1].target_q[1..], pair[0].target_q[1..]);
    }
}

#[test]
fn gain_and_damping_outside_their_ranges_are_clamped_with_a_warning() {
    let folder = tempfile::tempdir().unwrap();
    let script = "def p():\n    force_mode_set_gain_scaling(scoring=3)\n    force_mode_set_damping(-1)\n\
                  \x20   print('on')\nend\n";
    let output = run_script(folder.path(), script, &[]);
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(
        (&output.stdout[..], output.status.code()),
        (&b"on\n"[..], Some(0)),
        "{said}"
    );
    assert!(said.contains("allowed are 0 to 2; 2 is used"), "{said}");
    assert!(said.contains("allowed are 0 to 1; 0 is used"), "{said}");
}
