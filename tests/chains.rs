//! Chains of moves with statements between them, as scripts of the real binary under the virtual clock.

#![allow(clippy::unwrap_used, reason = "helpers fail by panicking")]

use crate::common::run_in_cell;

/// The numbers that the script printed.
fn numbers(text: &str) -> Vec<f64> {
    let (printed, said, status) = run_in_cell(text, "", &[]);
    assert_eq!(status, Some(0), "{said}");
    assert!(!said.contains("warning"), "{said}");
    let words = printed.split_whitespace();
    words.map(|word| word.parse().unwrap()).collect()
}

/// What a program may do between two moves.
const BETWEEN: &[&str] = &[
    "pass",
    "set_standard_digital_out(1, i % 2 == 0)",
    "get_standard_digital_in(0)",
    "set_flag(3, i % 2 == 0)",
    "textmsg('piece', i)",
    "write_output_integer_register(2, i)",
    "get_actual_tcp_pose()",
    "get_actual_joint_positions()",
];

#[test]
fn a_straight_chain_takes_as_long_whatever_stands_between() {
    for (count, radius, how) in [
        (100, 0.0005, "a=1, v=0.1"),
        (40, 0.001, "a=1, v=0.1"),
        (10, 0.005, "a=1.2, v=0.25"),
        (100, 0.0005, "t=0.02"),
        (40, 0.001, "t=0.05"),
    ] {
        let mut times = Vec::new();
        for between in BETWEEN {
            let text = format!(
                "
import time
movej([0, -1.57, 1.57, -1.57, -1.57, 0])
p = get_actual_tcp_pose()
t0 = time.time()
for i in range({count}):
  {between}
  movel([p[0], p[1] + 0.2 * (i + 1) / {count}, p[2], p[3], p[4], p[5]], r={radius} if i < {count} - 1 else 0, {how})
end
print(time.time() - t0)
"
            );
            times.push(numbers(&text)[0]);
        }
        for (between, took) in BETWEEN.iter().zip(&times) {
            let without = times[0];
            assert!(
                (took - without).abs() <= 0.01 * without + 0.008,
                "{count} pieces, {how}, with {between}: {took} s, {without} s without"
            );
        }
        if how.starts_with('t') {
            assert!((times[0] - 2.0).abs() < 0.02, "{how}: {} s", times[0]);
        }
    }
}

#[test]
fn what_a_program_reads_between_two_moves_is_that_of_the_zone() {
    let text = "
movej([0, -1.57, 1.57, -1.57, -1.57, 0])
p = get_target_tcp_pose()
movel(pose_trans(p, [0, 0.1, 0, 0, 0, 0]), a=1.2, v=0.1, r=0.02)
a = get_target_tcp_pose()
movel(pose_trans(p, [0, 0.2, 0, 0, 0, 0]), a=1.2, v=0.1)
print(norm([a[0] - p[0], a[1] - p[1], a[2] - p[2]]))
";
    let way = numbers(text)[0];
    assert!((0.0775..=0.0815).contains(&way), "{way} m of 0.08 m");
}

#[test]
fn process_moves_with_radii_that_meet_keep_their_speed_whatever_stands_between() {
    let chain = |between: &str| {
        let text = format!(
            "
import time
import math
p = get_target_tcp_pose()
x, y, a = 0, 0, 0
t0 = time.time()
for k in range(60):
  a += 0.0025 * math.pi
  x += 0.0015 * math.cos(a)
  y += 0.0015 * math.sin(a)
  {between}
  movep(pose_trans(p, [x, y, 0, 0, 0, 0]), 0.64, 0.0214, 0.0007 if k < 59 else 0)
end
print(time.time() - t0)
"
        );
        numbers(&text)[0]
    };
    let without = chain("pass");
    for between in [
        "set_standard_digital_out(k % 8, True)",
        "get_target_tcp_pose()",
    ] {
        let took = chain(between);
        assert!(
            (took - without).abs() < 0.02,
            "{between}: {took} s, {without} s without"
        );
    }
}
