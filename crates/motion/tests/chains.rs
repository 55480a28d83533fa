//! Chains of motions whose sender does something between them: each is sent only when it is due, or when the arm has
//! entered the zone of the one before. The arm goes on as if all of them had been known from the beginning.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::draw::Draw;
use common::{Bench, MODELS, ideal, moved, movej, tcp_speed};
use kinematics::{JointPositions, RpyPose};
use motion_api::{
    CommandId, CommandKind, DigitalBank, IoChange, MachineCommand, MotionCommand, Outcome,
    RobotState, SettingCommand,
};
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
    CommandKind::Motion(MotionCommand::MoveL {
        target,
        acceleration,
        speed,
        duration,
        radius,
    })
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
    for (speed, radius) in [
        (0.05, 0.005),
        (0.1, 0.01),
        (0.1, 0.05),
        (0.25, 0.02),
        (0.25, 0.04),
        (0.25, 0.05),
        (0.5, 0.1),
    ] {
        let (mut bench, start) = stretched();
        let corner = moved(&start, [0.0, 0.3, 0.0]);
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
fn before_a_zone_that_is_too_short_to_stop_in_what_stands_between_acts_early_and_nothing_slows_down()
 {
    // Speed, m/s; acceleration, m/s²; radius, m; earlier than the zone, s, at most.
    for (speed, acceleration, radius, early) in [
        (0.1, 1.2, 0.002, 0.06),
        (0.25, 1.2, 0.002, 0.085),
        (0.25, 1.2, 0.01, 0.07),
        (0.5, 1.2, 0.02, 0.09),
        (1.0, 3.0, 0.02, 0.175),
    ] {
        let (mut bench, start) = stretched();
        let corner = moved(&start, [0.0, 0.4, 0.0]);
        let id = bench.send(line(corner, (acceleration, speed), 0.0, radius));
        bench.until_due(id);
        let there = Vector3::from(bench.now().target_tcp_pose.xyz);
        let away = (there - Vector3::from(corner.xyz)).norm();
        let before = (away - radius) / speed;
        println!("{speed} m/s, {radius} m: {before:.3} s before the zone");
        assert!(before <= early, "{speed} m/s, {radius} m: {before} s");
        assert!(tcp_speed(&bench.now()) > 0.999 * speed, "{speed} m/s");
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
                    CommandKind::Motion(MotionCommand::MoveJ {
                        target,
                        acceleration: 1.4,
                        speed: 1.05,
                        duration: time,
                        radius,
                    })
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
fn timed_pieces_that_stop_take_the_sum_of_their_times() {
    for seed in 0..CASES {
        let mut draw = Draw::new(seed);
        let time = draw.spread(0.04, 0.3);
        let count = draw.whole(30, 60);
        // A rest to rest motion of this way needs some 1.2 m/s² and 160 m/s³.
        let longest = (0.2 * time * time).min(5.0 * time.powi(3));
        let piece = draw.spread(0.1, 1.0) * longest.min(0.35 / count as f64);
        let is_joint = draw.chance(0.5);
        let [stopping, blending] = [0.0, 0.2 * piece].map(|radius| {
            let (mut bench, start) = stretched();
            let q = bench.now().target_q;
            let kinds: Vec<CommandKind> = (1..=count)
                .map(|k| {
                    let radius = if k < count { radius } else { 0.0 };
                    let way = piece * k as f64;
                    if is_joint {
                        let mut target = q;
                        target[0] += way / 0.6;
                        CommandKind::Motion(MotionCommand::MoveJ {
                            target,
                            acceleration: 1.4,
                            speed: 1.05,
                            duration: time,
                            radius,
                        })
                    } else {
                        line(moved(&start, [0.0, way, 0.0]), (1.2, 0.25), time, radius)
                    }
                })
                .collect();
            run(&mut bench, &kinds, Sent::Early).0
        });
        let asked = time * count as f64;
        let at = format!("{seed} joint {is_joint} {count} of {time} s and {piece} m");
        assert!(
            (asked - STEP..=1.005 * asked + PLANNING).contains(&stopping),
            "{at}: {stopping} s of {asked} s"
        );
        assert!(
            blending <= stopping + STEP,
            "{at}: {blending} s blended, {stopping} s not"
        );
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
                    CommandKind::Motion(MotionCommand::MoveJ {
                        target,
                        acceleration: 1.4,
                        speed: 1.05,
                        duration: time,
                        radius: if k < count { radius } else { 0.0 },
                    })
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

/// Speeds along a line, m/s, and radii of a blend behind it, m; from zones of a second to ones that are passed in four
/// milliseconds.
const ZONES: [(f64, f64); 11] = [
    (0.05, 0.05),
    (0.1, 0.001),
    (0.1, 0.005),
    (0.1, 0.02),
    (0.25, 0.001),
    (0.25, 0.005),
    (0.25, 0.02),
    (0.5, 0.01),
    (0.5, 0.05),
    (1.0, 0.02),
    (1.0, 0.1),
];

#[test]
fn an_output_between_two_motions_switches_at_the_blend_radius_however_short_that_is() {
    for acceleration in [0.5, 1.2, 5.0] {
        for (speed, radius) in ZONES {
            for turn in [[0.0, 0.2, 0.0], [0.0, 0.0, -0.2], [0.1, -0.1, 0.0]] {
                let (mut bench, start) = stretched();
                let corner = moved(&start, [0.0, 0.4, 0.0]);
                let [x, y, z] = turn;
                let after = moved(&corner, [x, y, z]);
                let how = (acceleration, speed);
                let first = bench.send(line(corner, how, 0.0, radius));
                let change = IoChange::digital_out(DigitalBank::Standard, 3, true);
                let set = bench.send(SettingCommand::SetIoAtZone {
                    motion: first,
                    change,
                });
                while !bench.queued.contains(&first) && bench.outcome(first).is_none() {
                    bench.tick();
                }
                let second = bench.send(line(after, how, 0.0, 0.0));
                assert_eq!(bench.finish(second), Outcome::Done);
                bench.check_limits();
                let away = |state: &RobotState| {
                    let there = Vector3::from(state.target_tcp_pose.xyz);
                    (there - Vector3::from(corner.xyz)).norm()
                };
                let is_high = |state: &&RobotState| state.io().digital_out >> 3 & 1 == 1;
                let found = bench.states.iter().find(is_high).unwrap();
                let error = away(found) - radius;
                // It is made in the first cycle in the zone.
                let step = tcp_speed(found).max(0.3 * speed) * STEP;
                assert!(
                    error <= 1e-9 && error > -1.5 * step,
                    "{acceleration} m/s², {speed} m/s, {radius} m, {turn:?}: {error} m from the radius"
                );
                assert_eq!(bench.outcome(set), Some(Outcome::Done));
            }
        }
    }
}

#[test]
fn changes_at_a_zone_are_made_in_order_and_never_behind_a_stop() {
    let (mut bench, start) = stretched();
    let corner = moved(&start, [0.0, 0.2, 0.0]);
    let at_zone =
        |motion, change| CommandKind::Setting(SettingCommand::SetIoAtZone { motion, change });
    let float = |value| IoChange::FloatRegister { index: 2, value };
    let first = bench.send(line(corner, (1.2, 0.1), 0.0, 0.01));
    let ids = [1.0, 2.0, 3.0].map(|value| bench.send(at_zone(first, float(value))));
    bench.run(50);
    assert!(ids.iter().all(|id| bench.outcome(*id).is_none()));
    assert_eq!(bench.script.registers.output.float(2), 0.0);
    assert_eq!(bench.finish(first), Outcome::Done);
    assert_eq!(bench.script.registers.output.float(2), 3.0);
    assert!(
        ids.iter()
            .all(|id| bench.outcome(*id) == Some(Outcome::Done))
    );
    // A motion that has ended has no zone to wait for.
    assert_eq!(bench.do_it(at_zone(first, float(4.0))), Outcome::Done);
    assert_eq!(bench.script.registers.output.float(2), 4.0);
    // The program never comes to what stands behind a motion that is stopped.
    let back = bench.send(line(start, (1.2, 0.1), 0.0, 0.01));
    let never = bench.send(at_zone(back, float(5.0)));
    bench.run(100);
    bench.do_it(MachineCommand::Stop {
        only: CommandId::NONE,
    });
    bench.run(100);
    assert_eq!(bench.outcome(never), Some(Outcome::Aborted));
    assert_eq!(bench.script.registers.output.float(2), 4.0);
}

#[test]
fn no_more_changes_wait_for_zones_than_there_is_room_for() {
    let (mut bench, start) = stretched();
    let corner = moved(&start, [0.0, 0.2, 0.0]);
    let motion = bench.send(line(corner, (1.2, 0.1), 0.0, 0.01));
    let change = IoChange::IntegerRegister { index: 0, value: 1 };
    let mut refused = 0;
    for _ in 0..80 {
        let id = bench.send(SettingCommand::SetIoAtZone { motion, change });
        bench.tick();
        refused += usize::from(matches!(bench.outcome(id), Some(Outcome::Refused(_))));
    }
    assert_eq!(refused, 80 - motion::constants::ZONE_CHANGES);
    assert_eq!(bench.finish(motion), Outcome::Done);
}
