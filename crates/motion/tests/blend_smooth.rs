//! Blends without ripples: the speed of the TCP goes down and up again, not in steps.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::{Bench, MODELS, ideal, moved, movej, tcp_speed, turning_points};
use kinematics::JointPositions;
use motion_api::{CommandKind, MotionCommand, Outcome, RobotState, Warning};
use nalgebra::Vector3;

const STEP: f64 = 0.004;

#[test]
fn in_a_blend_the_tcp_slows_down_once_and_speeds_up_once() {
    for model in MODELS {
        for (name, angle, arc) in [
            ("line to line", 1.6_f64, false),
            ("line to line, sharp", 2.8, false),
            ("line to line, gentle", 0.4, false),
            ("line to arc", 0.8, true),
            ("line to arc, sharp", 2.0, true),
        ] {
            for (speed, radius) in [(0.25, 0.05), (0.6, 0.05), (0.25, 0.01)] {
                let mut bench = Bench::new(ideal(model));
                bench.do_it(movej(JointPositions([0.3, -1.4, 1.7, -1.8, -1.5, 0.2])));
                let start = bench.now().target_tcp_pose;
                let corner = moved(&start, [0.0, 0.15, 0.0]);
                let along =
                    |way: f64, up: f64| moved(&corner, [-way * angle.sin(), way * angle.cos(), up]);
                let first = CommandKind::Motion(MotionCommand::MoveL {
                    target: corner,
                    acceleration: 1.2,
                    speed,
                    duration: 0.0,
                    radius,
                });
                let second = if arc {
                    CommandKind::Motion(MotionCommand::MoveC {
                        via: along(0.08, 0.02),
                        target: along(0.15, 0.06),
                        acceleration: 1.2,
                        speed,
                        radius: 0.0,
                        fixed: false,
                    })
                } else {
                    CommandKind::Motion(MotionCommand::MoveL {
                        target: along(0.15, 0.03),
                        acceleration: 1.2,
                        speed,
                        duration: 0.0,
                        radius: 0.0,
                    })
                };
                let id = bench.send(first);
                bench.until_due(id);
                let next = bench.send(second);
                assert_eq!(bench.finish(id), Outcome::Done);
                let entered = bench.states.len();
                let id = next;
                assert_eq!(bench.finish(id), Outcome::Done, "{model} {name}");
                let stops = bench
                    .warnings
                    .iter()
                    .any(|(_, w)| *w == Warning::NotBlended);
                assert!(!stops, "{model} {name} {:?}", bench.warnings);
                bench.check_limits();
                let away = |s: &&RobotState| {
                    (Vector3::from(s.target_tcp_pose.xyz) - Vector3::from(corner.xyz)).norm()
                };
                let inside = bench.states[entered..]
                    .iter()
                    .take_while(|s| away(s) <= radius);
                let mut speeds: Vec<f64> = bench.states[entered - 10..entered]
                    .iter()
                    .chain(inside)
                    .map(tcp_speed)
                    .collect();
                let n = speeds.len();
                let after = bench.states[entered + n - 10..]
                    .iter()
                    .take(12)
                    .map(tcp_speed);
                speeds.extend(after);
                let accelerations: Vec<f64> =
                    speeds.windows(2).map(|v| (v[1] - v[0]) / STEP).collect();
                let turns = turning_points(&accelerations, 0.1 * 1.2);
                let jerk = accelerations
                    .windows(2)
                    .map(|a| ((a[1] - a[0]) / STEP).abs())
                    .fold(0.0, f64::max);
                // Braking into the zone, the curve's own dip, and the way out: five. A course in many parts has 13 to
                // 17.
                assert!(turns <= 7, "{model} {name} {speed} {radius}: {turns} turns");
                // An arm that did not know what follows brakes late and hard. Turning back sharply shortens and
                // lengthens the way of the TCP fast.
                let most = if angle < 2.5 { 300.0 } else { 900.0 };
                assert!(jerk < most, "{model} {name} {speed} {radius}: {jerk} m/s³");
            }
        }
    }
}
