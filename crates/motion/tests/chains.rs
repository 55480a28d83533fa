//! Chains of motions whose sender does something between them: each is sent only when it is due, or when the arm has entered the
//! zone of the one before. The arm goes on as if all of them had been known from the beginning.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::draw::Draw;
use common::{Bench, MODELS, ideal, moved, movej, tcp_speed};
use kinematics::{JointPositions, RpyPose};
use motion_api::{CommandId, CommandKind, Outcome};
use nalgebra::Vector3;

const STEP: f64 = 0.004;
/// Cycles from sending a command to the first of its motion, and to see that an arm stands.
const PLANNING: f64 = 4.0 * STEP;
/// Random chains of each kind.
const CASES: u64 = 24;

/// When the next motion is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sent {
    /// When it may be, as a program does that only computes.
    Early,
    /// When it is due, as a program does that reads an input before it.
    WhenDue,
}

fn line(
    target: RpyPose,
    (acceleration, speed): (f64, f64),
    duration: f64,
    radius: f64,
) -> CommandKind {
    CommandKind::MoveL {
        target,
        acceleration,
        speed,
        duration,
        radius,
    }
}

fn stretched() -> (Bench, RpyPose) {
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(movej(JointPositions([0.0, -1.57, 1.57, -1.57, -1.57, 0.0])));
    let start = bench.now().target_tcp_pose;
    (bench, start)
}

/// Runs the motions one after the other; how long until the arm stands, s, and the speeds of the TCP.
fn run(bench: &mut Bench, kinds: &[CommandKind], sent: Sent) -> (f64, Vec<f64>) {
    let begun = bench.states.len();
    let mut last = CommandId::NONE;
    for kind in kinds {
        last = bench.send(*kind);
        loop {
            let told = match sent {
                Sent::Early => &bench.queued,
                Sent::WhenDue => &bench.due,
            };
            if told.contains(&last) || bench.outcome(last).is_some() {
                break;
            }
            bench.tick();
        }
    }
    assert_eq!(bench.finish(last), Outcome::Done, "{:?}", bench.stops);
    while !bench.cycle.is_standing() {
        bench.tick();
    }
    bench.check_limits();
    let speeds = bench.states[begun..].iter().map(tcp_speed).collect();
    ((bench.states.len() - begun) as f64 * STEP, speeds)
}

/// The least speed between the first and the last time that it is as much as `speed`.
fn slowest_at_speed(speeds: &[f64], speed: f64) -> f64 {
    let is_fast = |v: &f64| *v >= speed;
    let first = speeds.iter().position(is_fast).unwrap();
    let last = speeds.iter().rposition(is_fast).unwrap();
    speeds[first..=last]
        .iter()
        .copied()
        .fold(f64::INFINITY, f64::min)
}

#[test]
fn straight_pieces_of_any_length_and_radius_are_one_line_whatever_stands_between() {
    for seed in 0..CASES {
        let mut draw = Draw::new(seed);
        let speed = draw.spread(0.02, 0.3);
        let how = (draw.spread(0.5, 3.0), speed);
        let sent = *draw.pick(&[Sent::Early, Sent::WhenDue]);
        let (mut bench, start) = stretched();
        let (mut way, mut kinds) = (0.0, Vec::new());
        while way < 0.3 {
            let length = draw.spread(0.002, 0.04);
            way += length;
            let radius = if way < 0.3 {
                draw.spread(0.0003, 0.4 * length)
            } else {
                0.0
            };
            kinds.push(line(moved(&start, [0.0, way, 0.0]), how, 0.0, radius));
        }
        let (took, speeds) = run(&mut bench, &kinds, sent);
        assert!(bench.warnings.is_empty(), "{seed} {:?}", bench.warnings);
        let (mut alone, start) = stretched();
        let whole = [line(moved(&start, [0.0, way, 0.0]), how, 0.0, 0.0)];
        let (wanted, _) = run(&mut alone, &whole, sent);
        assert!(
            took <= 1.01 * wanted + STEP,
            "{seed} {sent:?}: {took} s, one line takes {wanted} s"
        );
        let slowest = slowest_at_speed(&speeds, 0.999 * speed);
        assert!(
            slowest > 0.99 * speed,
            "{seed} {sent:?}: {slowest} of {speed} m/s"
        );
    }
}

#[test]
fn what_stands_between_acts_when_the_zone_is_entered_where_the_arm_can_still_stop_in_it() {
    for (speed, radius) in [(0.1, 0.02), (0.25, 0.02), (0.25, 0.04), (0.05, 0.005)] {
        let (mut bench, start) = stretched();
        let corner = moved(&start, [0.0, 0.15, 0.0]);
        let id = bench.send(line(corner, (1.2, speed), 0.0, radius));
        bench.until_due(id);
        let there = Vector3::from(bench.now().target_tcp_pose.xyz);
        let away = (there - Vector3::from(corner.xyz)).norm();
        let early = away - radius;
        assert!(
            early.abs() <= 2.0 * STEP * speed,
            "{speed} m/s, {radius} m: {early} m early"
        );
    }
}

#[test]
fn a_motion_that_nothing_follows_is_as_fast_as_one_that_was_to_stop() {
    let mut slower = Vec::new();
    for seed in 0..CASES {
        let mut draw = Draw::new(seed);
        let how = (draw.spread(0.3, 3.0), draw.spread(0.03, 0.5));
        let way = draw.spread(0.02, 0.3);
        let radius = draw.spread(0.0005, 0.4 * way);
        let [(with, end), (without, _)] = [radius, 0.0].map(|radius| {
            let (mut bench, start) = stretched();
            let target = moved(&start, [0.0, way, 0.0]);
            let (took, _) = run(&mut bench, &[line(target, how, 0.0, radius)], Sent::WhenDue);
            let off = Vector3::from(bench.now().target_tcp_pose.xyz) - Vector3::from(target.xyz);
            (took, off.norm())
        });
        assert!(end < 1e-9, "{seed}: stands {end} m beside its target");
        if with > 1.02 * without + STEP {
            slower.push((seed, how, way, radius, with, without));
        }
    }
    assert!(slower.is_empty(), "{slower:?}");
}

#[test]
fn timed_pieces_take_the_sum_of_their_times_at_an_even_speed() {
    for seed in 0..CASES {
        let mut draw = Draw::new(seed);
        let time = draw.spread(0.04, 0.3);
        let count = draw.whole(10, 80);
        let speed = draw.spread(0.02, 0.1).min(0.35 / (time * count as f64));
        let radius = draw.spread(0.05, 0.4) * speed * time;
        let is_joint = draw.chance(0.5);
        let sent = *draw.pick(&[Sent::Early, Sent::WhenDue]);
        let (mut bench, start) = stretched();
        let q = bench.now().target_q;
        let kinds: Vec<CommandKind> = (1..=count)
            .map(|k| {
                let radius = if k < count { radius } else { 0.0 };
                let way = speed * time * k as f64;
                if is_joint {
                    let mut target = q;
                    target[0] += way / 0.6;
                    CommandKind::MoveJ {
                        target,
                        acceleration: 1.4,
                        speed: 1.05,
                        duration: time,
                        radius,
                    }
                } else {
                    line(moved(&start, [0.0, way, 0.0]), (1.2, 0.25), time, radius)
                }
            })
            .collect();
        let (took, speeds) = run(&mut bench, &kinds, sent);
        let asked = time * count as f64;
        let at = format!("{seed} {sent:?} joint {is_joint} {count} of {time} s at {speed} m/s");
        assert!(
            (asked - STEP..=1.01 * asked + PLANNING).contains(&took),
            "{at}: {took} s of {asked} s"
        );
        let even = speeds.iter().copied().fold(0.0, f64::max).min(speed);
        let slowest = slowest_at_speed(&speeds, 0.97 * even);
        assert!(slowest > 0.93 * even, "{at}: {slowest} of {even} m/s");
    }
}

#[test]
fn a_timed_trajectory_with_changing_speeds_takes_its_time() {
    // As a driver samples a trajectory of the joints: points every 50 ms along a smooth swing of two joints.
    for model in MODELS {
        for (radius, sent) in [
            (0.0005, Sent::Early),
            (0.0005, Sent::WhenDue),
            (0.003, Sent::Early),
            (0.01, Sent::WhenDue),
        ] {
            let mut bench = Bench::new(ideal(model));
            bench.do_it(movej(JointPositions([0.0, -1.4, 1.6, -1.7, -1.5, 0.0])));
            let q = bench.now().target_q;
            let (count, time) = (80, 0.05);
            let kinds: Vec<CommandKind> = (1..=count)
                .map(|k| {
                    let share = f64::from(k) / f64::from(count);
                    let swing =
                        share - (std::f64::consts::TAU * share).sin() / std::f64::consts::TAU;
                    let mut target = q;
                    target[0] += 0.8 * swing;
                    target[2] -= 0.4 * swing;
                    CommandKind::MoveJ {
                        target,
                        acceleration: 1.4,
                        speed: 1.05,
                        duration: time,
                        radius: if k < count { radius } else { 0.0 },
                    }
                })
                .collect();
            let (took, _) = run(&mut bench, &kinds, sent);
            let asked = time * f64::from(count);
            assert!(
                (asked - STEP..=1.02 * asked + PLANNING).contains(&took),
                "{model} {radius} {sent:?}: {took} s of {asked} s"
            );
        }
    }
}
