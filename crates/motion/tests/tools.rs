//! Tools that are set at any moment, and limits of the TCP's speed that only count with them, or that are very small:
//! the arm slows down for them and is never stopped. And what is said of limited accelerations is what the arm does.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::draw::Draw;
use common::{Bench, MODELS, ideal, moved, tcp_speed};
use kinematics::{JointPositions, JointSpeeds, RpyPose};
use motion::CycleConfig;
use motion_api::{
    CommandId, CommandKind, MachineCommand, MotionCommand, OnlineCommand, Outcome, SettingCommand,
    Warning,
};
use nalgebra::Vector3;

/// A motion of any kind from where the arm stands.
fn motion(draw: &mut Draw, bench: &Bench, radius: f64) -> CommandKind {
    let at = bench.now().target_tcp_pose;
    let by = [0, 1, 2].map(|_| draw.between(-0.15, 0.15));
    let mut q = bench.states[0].target_q;
    (0..6).for_each(|joint| q[joint] += draw.between(-0.5, 0.5));
    let (acceleration, speed) = (draw.spread(0.5, 10.0), draw.spread(0.1, 2.0));
    match draw.whole(0, 4) {
        0 => CommandKind::Motion(MotionCommand::MoveL {
            target: moved(&at, by),
            acceleration,
            speed,
            duration: 0.0,
            radius,
        }),
        1 => CommandKind::Online(OnlineCommand::SpeedJ {
            speeds: JointSpeeds([0; 6].map(|_: i32| draw.between(-0.6, 0.6))),
            acceleration,
            duration: Some(1.0),
        }),
        2 => CommandKind::Online(OnlineCommand::SpeedL {
            speed: [0, 1, 2, 3, 4, 5].map(|_: i32| draw.between(-0.2, 0.2)),
            acceleration,
            rotation_acceleration: acceleration,
            duration: Some(1.0),
        }),
        _ => CommandKind::Motion(MotionCommand::MoveJ {
            target: q,
            acceleration,
            speed,
            duration: 0.0,
            radius,
        }),
    }
}

#[test]
fn a_tool_set_at_any_moment_slows_the_arm_down_and_stops_it_never() {
    let (mut done, mut too_fast) = (0, 0);
    for seed in 0..150 {
        let mut draw = Draw::new(seed);
        let mut config = CycleConfig {
            step_time: *draw.pick(&[0.002, 0.004, 0.008]),
            ..ideal(draw.pick::<&str>(&MODELS))
        };
        let limit = draw.spread(0.05, 0.6);
        config.limits.tcp_speed = Some(limit);
        config.limits.self_collision = Some(false);
        let mut bench = Bench::new(config);
        let h = bench.cycle.step_time();
        let mut fast_for = 0.0;
        for _ in 0..3 {
            let radius = *draw.pick(&[0.0, 0.05]);
            let id = bench.send(motion(&mut draw, &bench, radius));
            let mut next = (draw.between(0.02, 0.8) / h) as usize;
            for cycle in 0..(8.0 / h) as usize {
                if cycle == next {
                    let size = draw.spread(0.02, 0.5);
                    let tool = [0, 1, 2].map(|_| draw.between(-size, size));
                    bench.send(SettingCommand::SetTcp(RpyPose {
                        xyz: tool,
                        rpy: [0.0, 0.3, 0.0],
                    }));
                    next = cycle + (draw.between(0.05, 1.0) / h) as usize;
                    fast_for = 0.0;
                }
                let state = bench.tick();
                // It slows down as hard as it can.
                if tcp_speed(&state) > limit * (1.0 + 1e-6) {
                    fast_for += h;
                    too_fast += 1;
                    assert!(fast_for < 0.6, "{seed}: {} {limit}", tcp_speed(&state));
                }
                assert!(bench.stops.is_empty(), "{seed}: {:?}", bench.stops);
                if bench.outcome(id).is_some() || bench.queued.contains(&id) {
                    break;
                }
            }
            done += usize::from(bench.outcome(id) == Some(Outcome::Done));
            let stop = CommandKind::Machine(MachineCommand::Stop {
                only: CommandId::NONE,
            });
            assert_eq!(bench.do_it(stop), Outcome::Done);
        }
        let faults = bench.limit_faults();
        assert!(faults.is_empty(), "{seed}: {}", faults[0]);
    }
    println!("{done} motions done, {too_fast} cycles with a tool that was too fast");
    assert!(done > 200 && too_fast > 50);
}

#[test]
fn limits_of_a_few_millimetres_a_second_hold_in_online_modes() {
    for seed in 0..60 {
        let mut draw = Draw::new(seed);
        let mut config = CycleConfig {
            step_time: *draw.pick(&[0.002, 0.004, 0.008]),
            ..ideal(draw.pick::<&str>(&MODELS))
        };
        let limit = draw.spread(0.001, 0.01);
        config.limits.tcp_speed = Some(limit);
        let mut bench = Bench::new(config);
        bench.do_it(SettingCommand::SetTcp(RpyPose {
            xyz: [0.0, 0.05, 0.1],
            rpy: [0.0; 3],
        }));
        let h = bench.cycle.step_time();
        let start = bench.now().target_q;
        let before = bench.now().target_tcp_pose.xyz;
        let kind = draw.whole(0, 2);
        let speeds = [0; 6].map(|_: i32| draw.between(-1.0, 1.0));
        let velocity = [0; 6].map(|_: i32| draw.between(-0.5, 0.5));
        for cycle in 0..(1.5 / h) as u32 {
            let time = f64::from(cycle) * h;
            let command = match kind {
                0 => {
                    let mut target = start;
                    target[0] += 0.4 * (1.0 - (3.0 * time).cos());
                    target[3] += 0.4 * (2.0 * time).sin();
                    CommandKind::Online(OnlineCommand::ServoJ {
                        target,
                        duration: h,
                        lookahead: 0.05,
                        gain: 1000.0,
                    })
                }
                1 => CommandKind::Online(OnlineCommand::SpeedJ {
                    speeds: JointSpeeds(speeds.map(|v| v * (4.0 * time).sin())),
                    acceleration: 40.0,
                    duration: Some(h),
                }),
                _ => CommandKind::Online(OnlineCommand::SpeedL {
                    speed: velocity.map(|v| v * (4.0 * time).cos()),
                    acceleration: 5.0,
                    rotation_acceleration: 5.0,
                    duration: Some(h),
                }),
            };
            bench.send(command);
            let state = bench.tick();
            assert!(
                tcp_speed(&state) <= limit + 1e-6,
                "{seed} {kind}: {} of {limit}",
                tcp_speed(&state)
            );
        }
        assert!(bench.stops.is_empty(), "{seed}: {:?}", bench.stops);
        let way = bench.states.windows(2).map(|pair| {
            let [a, b] = [&pair[0], &pair[1]].map(|s| Vector3::from(s.target_tcp_pose.xyz));
            (b - a).norm()
        });
        let way: f64 = way.skip(5).sum();
        assert!(
            way > 0.2 * limit,
            "{seed} {kind}: {way} of {limit}, {before:?}"
        );
        bench.check_limits();
    }
}

#[test]
fn a_warning_of_a_limited_acceleration_tells_the_one_that_is_recorded() {
    let (mut told, mut silent) = (0, 0);
    for seed in 0..150 {
        let mut draw = Draw::new(seed);
        let q = JointPositions([
            draw.between(-3.0, 3.0),
            draw.between(-2.0, -1.0),
            draw.between(0.8, 2.0),
            draw.between(-2.2, -1.0),
            *draw.pick(&[-1.57, -1.2, -0.5, -0.2]),
            0.0,
        ]);
        let mut bench = Bench::new(CycleConfig {
            home: q,
            ..ideal(draw.pick::<&str>(&MODELS))
        });
        let wanted = draw.spread(1.0, 20.0);
        let by = [0, 1, 2].map(|_| draw.between(-0.3, 0.3));
        let target = moved(&bench.now().target_tcp_pose, by);
        let id = bench.send(MotionCommand::MoveL {
            target,
            acceleration: wanted,
            speed: draw.spread(0.1, 1.5),
            duration: 0.0,
            radius: 0.0,
        });
        if bench.finish(id) != Outcome::Done {
            continue;
        }
        let h = bench.cycle.step_time();
        let speeds: Vec<f64> = bench.states.iter().map(tcp_speed).collect();
        let changes = speeds.windows(2).map(|pair| (pair[1] - pair[0]).abs() / h);
        let done = changes.fold(0.0, f64::max);
        let warned = bench
            .warnings
            .iter()
            .find_map(|(_, warning)| match warning {
                Warning::AccelerationLimited { planned, .. } => {
                    Some((*planned, warning.to_string()))
                }
                _ => None,
            });
        match warned {
            Some((planned, text)) => {
                told += 1;
                assert!(
                    (done / planned - 1.0).abs() < 0.04,
                    "{seed}: {done} recorded, {planned} told"
                );
                assert!(text.contains(" m/s² is more"), "{text}");
            }
            None => silent += usize::from(done > 0.97 * wanted),
        }
        assert!(done < wanted * 1.01, "{seed}: {done} {wanted}");
    }
    println!("{told} told, {silent} as asked for");
    assert!(told > 20 && silent > 20);
}
