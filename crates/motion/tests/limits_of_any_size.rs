//! Limits of any size: every mode works within them, or they are refused at the start with a sentence. Nothing panics.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::draw::Draw;
use common::{Bench, MODELS, ideal, moved, movej, movel};
use kinematics::{JointAccelerations, JointJerks, JointPositions, JointSpeeds};
use motion::constants::MIN_LIMITS;
use motion::{CycleConfig, LimitOverrides, PlantKind};
use motion_api::{
    CommandId, CommandKind, FreedriveFrame, MachineCommand, MotionMode, OnlineCommand,
    OverlayCommand, SafetyMode, SensingCommand,
};

/// Six numbers from `least` to the arm's own, some of them at either end.
fn six(draw: &mut Draw, least: f64, own: [f64; 6]) -> [f64; 6] {
    own.map(|own| match draw.whole(0, 5) {
        0 => own,
        1 => least,
        _ => draw.spread(least, own),
    })
}

fn limits(draw: &mut Draw, config: &CycleConfig) -> LimitOverrides {
    let own = config.resolve().unwrap();
    let mut limits = LimitOverrides {
        self_collision: Some(false),
        ..LimitOverrides::default()
    };
    if draw.chance(0.7) {
        limits.joint_speed = Some(JointSpeeds(six(draw, MIN_LIMITS.joint_speed, own.speed.0)));
    }
    let mut able = own.acceleration.0;
    if draw.chance(0.7) {
        able = six(draw, MIN_LIMITS.joint_acceleration, able);
        limits.joint_acceleration = Some(JointAccelerations(able));
    }
    if draw.chance(0.5) {
        let most = able.map(|a| a / motion::constants::FASTEST_RISE);
        limits.joint_jerk = Some(JointJerks(six(draw, MIN_LIMITS.joint_jerk, most)));
    }
    if draw.chance(0.3) {
        // A range of a fraction of a degree, or less.
        let width = draw.spread(1e-6, 1.0);
        limits.joint_position_min = Some(config.home.map(|q| q - width * 0.3));
        limits.joint_position_max = Some(config.home.map(|q| q + width));
    }
    if draw.chance(0.3) {
        limits.tcp_speed = Some(draw.spread(MIN_LIMITS.point_speed, 2.0));
    }
    if draw.chance(0.3) {
        limits.elbow_speed = Some(draw.spread(MIN_LIMITS.point_speed, 2.0));
    }
    limits
}

/// Every mode for a while, one after the other.
fn try_everything(bench: &mut Bench, draw: &mut Draw) {
    let home = bench.now().target_q;
    let aside = JointPositions(home.0.map(|q| q + draw.between(-0.3, 0.3)));
    let pose = moved(&bench.now().target_tcp_pose, [0.01, 0.05, -0.02]);
    let speeds = JointSpeeds(core::array::from_fn(|_| draw.between(-2.0, 2.0)));
    let stop = CommandKind::Machine(MachineCommand::Stop {
        only: CommandId::NONE,
    });
    let modes: [CommandKind; 8] = [
        CommandKind::Online(OnlineCommand::SpeedJ {
            speeds,
            acceleration: draw.spread(1e-3, 100.0),
            duration: Some(0.4),
        }),
        CommandKind::Online(OnlineCommand::ServoJ {
            target: aside,
            duration: 0.2,
            lookahead: draw.between(0.03, 0.2),
            gain: draw.between(100.0, 2000.0),
        }),
        CommandKind::Online(OnlineCommand::SpeedL {
            speed: [0.2, -0.1, 0.1, 0.3, 0.0, -0.5],
            acceleration: draw.spread(1e-3, 100.0),
            rotation_acceleration: 1.0,
            duration: Some(0.4),
        }),
        movej(aside),
        movel(pose),
        CommandKind::Online(OnlineCommand::Freedrive {
            free_axes: [true; 6],
            frame: FreedriveFrame::Base,
        }),
        CommandKind::Overlay(OverlayCommand::ForceMode {
            frame: kinematics::RpyPose::default(),
            selection: [true, true, true, false, false, true],
            wrench: [0.0, 5.0, -10.0, 0.0, 0.0, 0.3],
            mode: 0,
            speed_limits: [0.2; 6],
        }),
        CommandKind::Overlay(OverlayCommand::TrackConveyorLinear {
            direction: [0.0, 1.0, 0.0],
            ticks_per_meter: 1000.0,
            encoder: 0,
        }),
    ];
    for kind in modes {
        bench.send(kind);
        bench.run(60);
        bench.send(SensingCommand::SetExternalWrench([
            20.0, -30.0, 15.0, 1.0, 0.0, 1.0,
        ]));
        bench.run(60);
        bench.send(SensingCommand::SetExternalWrench([0.0; 6]));
        for end in [
            CommandKind::Overlay(OverlayCommand::EndForceMode),
            CommandKind::Online(OnlineCommand::EndFreedrive),
            CommandKind::Overlay(OverlayCommand::StopConveyorTracking),
            stop,
        ] {
            bench.send(end);
        }
        bench.run(150);
        if bench.now().safety_mode == SafetyMode::ProtectiveStop {
            bench.run(200);
            bench.send(MachineCommand::UnlockProtectiveStop);
            bench.run(5);
        }
        assert!(bench.now().target_q.is_finite() && bench.now().actual_q.is_finite());
        assert_ne!(bench.now().motion_mode, MotionMode::PoweredOff);
    }
}

#[test]
fn every_mode_works_within_limits_of_any_size() {
    let programs: u64 = std::env::var("ELITE_CASES").map_or(60, |n| n.parse().unwrap());
    let mut stops = 0;
    for seed in 0..programs {
        let mut draw = Draw::new(seed);
        let model: &str = MODELS[draw.whole(0, MODELS.len() - 1)];
        let mut config = ideal(model);
        config.step_time = draw.whole(1, 8) as f64 * 1e-3;
        if draw.chance(0.15) {
            config.plant = PlantKind::Rigid;
        }
        config.limits = limits(&mut draw, &config);
        let shown = format!("seed {seed}: {:?}", config.limits);
        let mut bench = Bench::new(config);
        bench.send(SensingCommand::SetCollisionDetection(false));
        bench.send(SensingCommand::FtRtsiInput {
            enabled: true,
            mass: 0.0,
            measuring_offset: [0.0; 3],
            cog: [0.0; 3],
        });
        try_everything(&mut bench, &mut draw);
        stops += bench.stops.len();
        for state in &bench.states {
            for joint in 0..6 {
                let (qd, most) = (state.target_qd[joint].abs(), bench.limits.speed[joint]);
                assert!(qd <= most + 1e-6, "{shown}: {qd} of {most}");
            }
        }
        let internal = |stop: &&motion_api::StopReason| {
            matches!(stop, motion_api::StopReason::Internal { .. })
        };
        assert_eq!(bench.stops.iter().find(internal), None, "{shown}");
    }
    println!("{stops} protective stops in {programs} programs");
}

#[test]
fn a_locked_joint_lets_the_others_move() {
    let mut config = ideal("cs66");
    config.limits.joint_speed = Some(JointSpeeds([3.0, 3.0, 3.0, 3.0, 3.0, 0.0005]));
    for step in [0.001, 0.004, 0.008] {
        config.step_time = step;
        let mut bench = Bench::new(config.clone());
        let q = bench.now().target_q;
        bench.send(OnlineCommand::SpeedJ {
            speeds: JointSpeeds([0.2, 0.0, 0.0, 0.0, 0.0, 0.2]),
            acceleration: 1.0,
            duration: Some(0.5),
        });
        bench.run((0.6 / step) as usize);
        assert!(bench.stops.is_empty(), "{:?}", bench.stops);
        let now = bench.now().target_q;
        assert!((now[0] - q[0]) > 0.03, "{now:?}");
        let crept = now[5] - q[5];
        assert!(crept > 1e-5 && crept <= 0.0005 * 0.6 + 1e-9, "{crept}");
        bench.check_limits();
    }
}

#[test]
fn what_is_too_small_too_large_or_crossed_is_refused_with_a_sentence() {
    let refused = |change: &dyn Fn(&mut LimitOverrides)| {
        let mut config = ideal("cs66");
        change(&mut config.limits);
        config.resolve().unwrap_err().to_string()
    };
    let all = |x: f64| [x; 6];
    for x in [
        0.0,
        -1.0,
        1e-9,
        1e9,
        f64::NAN,
        f64::INFINITY,
        f64::MIN_POSITIVE,
    ] {
        for text in [
            refused(&|l| l.joint_speed = Some(JointSpeeds(all(x)))),
            refused(&|l| l.joint_acceleration = Some(JointAccelerations(all(x)))),
            refused(&|l| l.joint_jerk = Some(JointJerks(all(x)))),
        ] {
            assert!(
                text.starts_with("limit joint_") && text.contains("allowed is"),
                "{text}"
            );
        }
    }
    for x in [0.0, -1.0, 1e-9, f64::NAN, f64::INFINITY] {
        let text = refused(&|l| l.tcp_speed = Some(x));
        assert!(
            text.contains("tcp_speed") && text.contains("at least 0.0001"),
            "{text}"
        );
    }
    let text = refused(&|l| {
        l.joint_position_min = Some(JointPositions(all(1.0)));
        l.joint_position_max = Some(JointPositions(all(-1.0)));
    });
    assert!(text.contains("must not be empty"), "{text}");
}
