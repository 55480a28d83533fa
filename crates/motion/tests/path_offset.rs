//! Path offsets: laid over the path in the axes asked for, moved to within the limits, ended without a jump.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::draw::Draw;
use common::{Bench, MODELS, ideal, moved};
use kinematics::{JointAccelerations, Pose, RpyPose};
use motion::CycleConfig;
use motion_api::{
    CommandId, CommandKind, IoChange, MachineCommand, MotionCommand, OffsetAxes, Outcome,
    OverlayCommand, Refusal, SettingCommand, StopReason,
};
use nalgebra::Vector3;

fn set(offset: [f64; 6], axes: OffsetAxes) -> CommandKind {
    CommandKind::Overlay(OverlayCommand::PathOffsetSet {
        offset: RpyPose::from_array(offset),
        axes,
    })
}

fn movep(target: RpyPose, speed: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveP {
        target,
        acceleration: 1.2,
        speed,
        radius: 0.0,
    })
}

const DISABLE: CommandKind =
    CommandKind::Overlay(OverlayCommand::PathOffsetDisable { acceleration: 20.0 });

/// Translation from the path to the arm, base axes.
fn away(bench: &Bench) -> Vector3<f64> {
    let (at, path) = (bench.now().target_tcp_pose, bench.now().path_pose);
    Vector3::from(at.xyz) - Vector3::from(path.xyz)
}

#[test]
fn an_offset_is_moved_in_and_out_on_the_way_within_all_limits() {
    for axes in [OffsetAxes::Base, OffsetAxes::Tool, OffsetAxes::Motion] {
        let mut bench = Bench::new(ideal("cs66"));
        let start = bench.now().target_tcp_pose;
        assert_eq!(bench.do_it(OverlayCommand::PathOffsetEnable), Outcome::Done);
        let id = bench.send(movep(moved(&start, [0.02, 0.2, -0.05]), 0.05));
        bench.run(200);
        bench.do_it(set([0.0, 0.0, 0.005, 0.0, 0.0, 0.1], axes));
        bench.run(400);
        let state = bench.now();
        assert!(
            (away(&bench).norm() - 0.005).abs() < 1e-6,
            "{}",
            away(&bench)
        );
        let in_force = state.path_offsets[axes as usize];
        let asked = [0.0, 0.0, 0.005, 0.0, 0.0, 0.1];
        for k in 0..6 {
            assert!(
                (in_force[k] - asked[k]).abs() < 1e-6,
                "{axes:?} {in_force:?}"
            );
        }
        // The path itself is where it would be without an offset.
        let line = Vector3::new(0.02, 0.2, -0.05);
        let along = Vector3::from(state.path_pose.xyz) - Vector3::from(start.xyz);
        assert!(along.cross(&line.normalize()).norm() < 1e-9);
        bench.do_it(set([0.0; 6], axes));
        assert_eq!(bench.finish(id), Outcome::Done);
        assert!(away(&bench).norm() < 1e-9);
        assert!(bench.stops.is_empty(), "{:?}", bench.stops);
        bench.check_limits();
    }
}

#[test]
fn tool_axes_turn_with_the_tool() {
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(OverlayCommand::PathOffsetEnable);
    bench.do_it(set([0.01, 0.0, 0.0, 0.0, 0.0, 0.0], OffsetAxes::Tool));
    bench.run(300);
    let tool = Pose::from_rpy(&bench.now().path_pose).rotation;
    assert!((away(&bench) - tool * Vector3::new(0.01, 0.0, 0.0)).norm() < 1e-9);
}

#[test]
fn an_offset_set_before_counts_from_enable_on() {
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(set([0.0, 0.004, 0.0, 0.0, 0.0, 0.0], OffsetAxes::Base));
    bench.run(100);
    assert_eq!(away(&bench).norm(), 0.0);
    bench.do_it(OverlayCommand::PathOffsetEnable);
    bench.run(200);
    assert!((away(&bench).y - 0.004).abs() < 1e-9);
    assert_eq!(bench.now().target_qd.max_abs(), 0.0, "it has come to rest");
}

#[test]
fn the_filter_takes_over_its_share_a_cycle() {
    let rise = |share: Option<f64>| {
        let mut bench = Bench::new(ideal("cs66"));
        if let Some(share) = share {
            bench.do_it(OverlayCommand::PathOffsetFilter(share));
        }
        bench.do_it(OverlayCommand::PathOffsetEnable);
        bench.do_it(set([0.0, 0.004, 0.0, 0.0, 0.0, 0.0], OffsetAxes::Base));
        (0..2000)
            .take_while(|_| {
                bench.tick();
                away(&bench).y < 0.0036
            })
            .count()
    };
    let (at_once, slow) = (rise(None), rise(Some(0.01)));
    // A share of 1 % a cycle takes 229 cycles to 90 %.
    assert!(slow > 229 && slow < 229 + 2 * at_once, "{at_once} {slow}");
}

#[test]
fn disable_brakes_and_the_next_motion_starts_there() {
    let mut bench = Bench::new(ideal("cs66"));
    let start = bench.now().target_tcp_pose;
    bench.do_it(OverlayCommand::PathOffsetEnable);
    bench.do_it(set([0.0, 0.0, 0.02, 0.0, 0.0, 0.0], OffsetAxes::Base));
    let move_id = bench.send(movep(moved(&start, [0.0, 0.2, 0.0]), 0.1));
    bench.run(150);
    assert_eq!(bench.do_it(DISABLE), Outcome::Done);
    assert_eq!(bench.outcome(move_id), Some(Outcome::Aborted));
    let stood = bench.now();
    assert_eq!(stood.target_qd.max_abs(), 0.0);
    assert!((stood.target_tcp_pose.xyz[2] - start.xyz[2] - 0.02).abs() < 2e-3);
    assert_eq!(stood.path_offsets, [[0.0; 6]; 3]);
    let to = moved(&stood.target_tcp_pose, [0.0, -0.05, 0.0]);
    assert_eq!(bench.do_it(movep(to, 0.1)), Outcome::Done);
    bench.check_limits();
}

#[test]
fn too_large_an_offset_is_a_protective_stop() {
    for (offset, is_rotation) in [
        ([0.0, 0.06, 0.09, 0.0, 0.0, 0.0], false),
        ([0.0, 0.0, 0.0, 0.6, 0.0, 0.0], true),
    ] {
        let mut bench = Bench::new(ideal("cs66"));
        bench.do_it(OverlayCommand::PathOffsetEnable);
        bench.do_it(set(offset, OffsetAxes::Base));
        bench.run(100);
        let StopReason::PathOffset {
            translation,
            rotation,
            ..
        } = bench.stops[0]
        else {
            panic!("{:?}", bench.stops);
        };
        assert_eq!(
            (translation > 0.1, rotation > 0.5),
            (!is_rotation, is_rotation)
        );
        bench.check_limits();
    }
}

#[test]
fn a_stop_of_the_task_ends_offsets_at_rest() {
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(OverlayCommand::PathOffsetEnable);
    bench.do_it(set([0.0, 0.05, 0.0, 0.0, 0.0, 0.0], OffsetAxes::Base));
    bench.run(20);
    let stop = CommandKind::Machine(MachineCommand::Stop {
        only: CommandId::NONE,
    });
    assert_eq!(bench.do_it(stop), Outcome::Done);
    bench.tick();
    let state = bench.now();
    assert_eq!(state.target_qd.max_abs(), 0.0);
    assert_eq!(state.path_pose, state.target_tcp_pose);
    let away = state.target_tcp_pose.xyz[1] - bench.states[0].target_tcp_pose.xyz[1];
    assert!(away > 0.0005 && away < 0.05, "{away}");
    bench.check_limits();
}

#[test]
fn belts_and_force_mode_and_offsets_exclude_one_another() {
    let mut bench = Bench::new(ideal("cs66"));
    bench.do_it(OverlayCommand::PathOffsetEnable);
    let track = CommandKind::Overlay(OverlayCommand::TrackConveyorLinear {
        direction: [1.0, 0.0, 0.0],
        ticks_per_meter: 1000.0,
        encoder: 0,
    });
    assert_eq!(bench.do_it(track), Outcome::Refused(Refusal::PathOffset));
    bench.do_it(DISABLE);
    assert_eq!(bench.do_it(track), Outcome::Done);
    assert_eq!(
        bench.do_it(OverlayCommand::PathOffsetEnable),
        Outcome::Refused(Refusal::ConveyorTracking)
    );
}

#[test]
fn offsets_that_change_all_the_time_keep_the_limits() {
    let mut bench = Bench::new(ideal("cs66"));
    let start = bench.now().target_tcp_pose;
    bench.do_it(OverlayCommand::PathOffsetEnable);
    let id = bench.send(movep(moved(&start, [0.1, 0.2, -0.1]), 0.1));
    let mut k = 0;
    while bench.outcome(id).is_none() {
        let phase = 0.05 * f64::from(k);
        let size = if k % 50 < 25 { 0.01 } else { -0.02 };
        let axes = [OffsetAxes::Base, OffsetAxes::Tool, OffsetAxes::Motion][(k / 200) as usize % 3];
        bench.send(set(
            [
                size * phase.sin(),
                0.003 * phase.cos(),
                size,
                0.0,
                0.1 * phase.sin(),
                0.0,
            ],
            axes,
        ));
        bench.tick();
        k += 1;
        assert!(k < 5000);
    }
    assert!(bench.stops.is_empty(), "{:?}", bench.stops);
    bench.check_limits();
}

#[test]
fn offsets_that_jump_about_are_not_followed_beyond_them_and_stand_when_they_stand() {
    let most = [0.02, 0.02, 0.02, 0.1, 0.1, 0.1];
    for (seed, cycles, share) in [
        (1, 1, 1.0),
        (2, 1, 0.2),
        (3, 5, 1.0),
        (4, 12, 0.7),
        (5, 25, 1.0),
        (6, 60, 1.0),
    ] {
        let mut draw = Draw::new(seed);
        let mut bench = Bench::new(ideal("cs66"));
        bench.do_it(OverlayCommand::PathOffsetEnable);
        bench.do_it(OverlayCommand::PathOffsetFilter(share));
        let mut asked = [0.0; 6];
        for k in 0..1500 {
            if k % cycles == 0 {
                // From end to end, or anywhere between.
                asked = most.map(|x| match draw.whole(0, 2) {
                    0 => -x,
                    1 => x,
                    _ => draw.between(-x, x),
                });
            }
            bench.send(set(asked, OffsetAxes::Base));
            let state = bench.tick();
            for (part, largest) in most.into_iter().enumerate() {
                // Rotations are composed: three of 0.1 rad turn a little about one another. What the joints leave for
                // the offset changes while it brakes.
                let slack = if part < 3 { 0.002 * largest } else { 0.012 };
                let now = state.path_offsets[OffsetAxes::Base as usize][part];
                assert!(now.abs() < largest + slack, "{seed}, part {part}: {now}");
            }
        }
        bench.run(500);
        let state = bench.now();
        for (part, asked) in asked.into_iter().enumerate() {
            let now = state.path_offsets[OffsetAxes::Base as usize][part];
            assert!((now - asked).abs() < 1e-6, "{seed}, part {part}: {now}");
        }
        assert_eq!(state.target_qd.max_abs(), 0.0);
        assert!(bench.stops.is_empty(), "{:?}", bench.stops);
        bench.check_limits();
    }
}

/// The largest parts of the offset along the path, across it and across both, m, of a weave across a line.
fn weave(model: &str, frequency: f64, amplitude: f64, step_time: f64) -> [f64; 3] {
    let mut bench = Bench::new(CycleConfig {
        step_time,
        ..ideal(model)
    });
    let start = bench.now().target_tcp_pose;
    bench.do_it(OverlayCommand::PathOffsetEnable);
    let way = Vector3::new(0.03, 0.11, -0.02);
    let id = bench.send(movep(moved(&start, way.into()), 0.04));
    let tool = Pose::from_rpy(&start).rotation * Vector3::z();
    let x = way.normalize();
    let y = x.cross(&tool).normalize();
    let mut most = [0.0_f64; 3];
    let mut cycle = 0;
    while bench.outcome(id).is_none() {
        let time = f64::from(cycle) * step_time;
        let across = amplitude * (core::f64::consts::TAU * frequency * time).sin();
        bench.send(set([0.0, across, 0.0, 0.0, 0.0, 0.0], OffsetAxes::Motion));
        bench.tick();
        if (0.8..2.0).contains(&time) {
            let off = away(&bench);
            for (most, axis) in most.iter_mut().zip([x, y, x.cross(&y)]) {
                *most = most.max(off.dot(&axis).abs());
            }
        }
        cycle += 1;
    }
    bench.do_it(DISABLE);
    bench.run(20);
    assert!(
        bench.stops.is_empty(),
        "{frequency} {amplitude}: {:?}",
        bench.stops
    );
    bench.check_limits();
    most
}

#[test]
fn a_weave_goes_across_the_path_alone_and_as_far_as_it_is_asked_to() {
    for model in MODELS {
        for amplitude in [0.003, 0.006] {
            for frequency in [0.5, 1.0, 2.0, 3.0, 4.0, 6.0, 10.0] {
                let step_time = if amplitude < 0.005 { 0.004 } else { 0.002 };
                let [along, across, up] = weave(model, frequency, amplitude, step_time);
                let share = across / amplitude;
                println!(
                    "{model} {:.0} mm at {frequency} Hz: {:.1} % across, {:.1e} m along",
                    1e3 * amplitude,
                    100.0 * share,
                    along
                );
                assert!(
                    along < 1e-6 && up < 1e-6,
                    "{model} {frequency}: {along} {up}"
                );
                assert!(share < 1.02, "{model} {frequency}: {share}");
                if frequency <= 3.0 {
                    assert!(share > 0.95, "{model} {frequency}: {share}");
                }
            }
        }
    }
}

#[test]
fn whatever_ends_offsets_their_targets_do_not_jump() {
    let ends: [&[CommandKind]; 4] = [
        &[CommandKind::Machine(MachineCommand::Stop {
            only: CommandId::NONE,
        })],
        &[CommandKind::Setting(SettingCommand::SetIo(
            IoChange::ProgramRunning(false),
        ))],
        &[
            CommandKind::Machine(MachineCommand::Stop {
                only: CommandId::NONE,
            }),
            CommandKind::Setting(SettingCommand::SetIo(IoChange::ProgramRunning(false))),
        ],
        &[CommandKind::Overlay(OverlayCommand::PathOffsetDisable {
            acceleration: 3.0,
        })],
    ];
    for seed in 0..120 {
        let mut draw = Draw::new(seed);
        let mut config = CycleConfig {
            step_time: *draw.pick(&[0.002, 0.004, 0.008]),
            ..ideal(draw.pick::<&str>(&MODELS))
        };
        config.limits.joint_acceleration = draw.chance(0.5).then_some(JointAccelerations([5.0; 6]));
        let mut bench = Bench::new(config);
        let h = bench.cycle.step_time();
        let start = bench.now().target_tcp_pose;
        bench.do_it(OverlayCommand::PathOffsetEnable);
        bench.send(movep(
            moved(&start, [0.03, 0.11, -0.02]),
            draw.spread(0.03, 0.3),
        ));
        let axes = *draw.pick(&[OffsetAxes::Base, OffsetAxes::Tool, OffsetAxes::Motion]);
        let size = [0.01, 0.01, 0.01, 0.1, 0.1, 0.1].map(|x| draw.between(0.0, x));
        let rate = draw.between(3.0, 40.0);
        let jumps = draw.chance(0.3);
        for cycle in 0..(draw.between(0.3, 3.5) / h) as u32 {
            let swing = (rate * h * f64::from(cycle)).sin();
            let swing = if jumps { swing.signum() } else { swing };
            bench.send(set(size.map(|x| x * swing), axes));
            bench.tick();
        }
        let end = *draw.pick(&ends);
        for kind in end {
            let _ = bench.send(*kind);
        }
        bench.run((1.0 / h) as usize);
        assert_eq!(bench.now().target_qd.max_abs(), 0.0, "{seed}");
        assert!(bench.stops.is_empty(), "{seed}: {:?}", bench.stops);
        // What is told and what the positions do belong together.
        for three in bench.states.windows(3) {
            for joint in 0..6 {
                let [a, b, c] = [0, 1, 2].map(|k| three[k].target_q[joint]);
                let told = [0, 1, 2].map(|k| three[k].target_qdd[joint]);
                let done = (c - 2.0 * b + a) / (h * h);
                let (low, high) = told
                    .iter()
                    .fold((f64::MAX, f64::MIN), |(l, h), x| (l.min(*x), h.max(*x)));
                // Within a cycle an acceleration may rise and fall again.
                let slack =
                    0.02 * bench.limits.acceleration[joint] + 0.15 * h * bench.limits.jerk[joint];
                assert!(
                    (low - slack..=high + slack).contains(&done),
                    "{seed}: joint {joint} {done} of {told:?} in cycle {} of {}, {end:?}",
                    three[2].cycle,
                    bench.now().cycle
                );
            }
        }
        let faults = bench.limit_faults();
        assert!(faults.is_empty(), "{seed}: {}", faults[0]);
    }
}
