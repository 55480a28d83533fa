//! The arm does not run into itself: refused when planned, a protective stop where setpoints are made cycle by cycle.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]
#![allow(
    clippy::approx_constant,
    reason = "joint angles and speeds as people type them"
)]

use crate::common;

use common::draw::Draw;
use common::{Bench, MODELS, ideal, movej};
use kinematics::{JointPositions, JointSpeeds, RobotModel};
use motion::CycleConfig;
use motion::constants::LINK_OVERLAP;
use motion_api::{
    CommandKind, FreedriveFrame, MachineCommand, OnlineCommand, Outcome, OverlayCommand, PathFault,
    Refusal, RobotState, SensingCommand, StopReason,
};

/// The forearm lies on the upper arm and goes through the shoulder.
const FOLDED: JointPositions = JointPositions([0.0, -1.5708, 3.1, 0.0, 0.0, 0.0]);
/// On the way there, still free.
const NEARLY: JointPositions = JointPositions([0.0, -1.5708, 2.3, 0.0, 0.0, 0.0]);

fn overlap(model: &RobotModel, q: &JointPositions) -> f64 {
    let found = model.collision().self_distance(&model.forward(q));
    found.map_or(0.0, |found| -found.distance)
}

fn deepest(states: &[RobotState], model: &str) -> f64 {
    let model = RobotModel::built_in(model).unwrap();
    let depth = states.iter().map(|s| overlap(&model, &s.target_q));
    depth.fold(f64::NEG_INFINITY, f64::max)
}

fn nearly(model: &str) -> CycleConfig {
    CycleConfig {
        home: NEARLY,
        ..ideal(model)
    }
}

#[test]
fn a_movej_into_itself_is_refused_with_both_links_and_the_place() {
    for model in MODELS {
        let mut bench = Bench::new(ideal(model));
        let home = bench.now().target_q;
        let outcome = bench.do_it(movej(FOLDED));
        let Outcome::Refused(refusal @ Refusal::Path { fraction, fault }) = outcome else {
            panic!("{model}: {outcome:?}");
        };
        let PathFault::SelfCollision { links, overlap } = fault else {
            panic!("{model}: {fault:?}");
        };
        assert!(
            links[0] < links[1] && (0.2..1.0).contains(&fraction),
            "{model}"
        );
        assert!((LINK_OVERLAP..0.03).contains(&overlap), "{model} {overlap}");
        let text = refusal.to_string();
        assert!(text.contains(" % of the way along: "), "{text}");
        assert!(text.contains("wrist") || text.contains("arm"), "{text}");
        println!("{model}: {text}");
        bench.run(10);
        assert_eq!(bench.now().target_q, home, "the arm has not moved");
        // As far as it goes it may.
        assert_eq!(bench.do_it(movej(NEARLY)), Outcome::Done, "{model}");
    }
}

#[test]
fn a_way_through_itself_between_two_free_places_is_refused() {
    // The elbow stays bent; on the way the wrist comes by the upper arm.
    let mut seen = 0;
    let mut draw = Draw::new(11);
    let model = RobotModel::built_in("cs66").unwrap();
    for _ in 0..400 {
        let bent = draw.between(2.0, 2.7);
        let mut any = || {
            let mut q = core::array::from_fn(|_| draw.between(-3.0, 3.0));
            q[2] = bent;
            JointPositions(q)
        };
        let (from, to) = (any(), any());
        if overlap(&model, &from) > 0.0 || overlap(&model, &to) > 0.0 {
            continue;
        }
        let most = (0..=1000)
            .map(|k| {
                let share = f64::from(k) / 1000.0;
                let q = core::array::from_fn(|j| from[j] + share * (to[j] - from[j]));
                overlap(&model, &JointPositions(q))
            })
            .fold(f64::NEG_INFINITY, f64::max);
        let mut bench = Bench::new(CycleConfig {
            home: from,
            ..ideal("cs66")
        });
        let id = bench.send(movej(to));
        bench.run(5);
        let outcome = bench.outcome(id);
        let is_refused = matches!(
            outcome,
            Some(Outcome::Refused(Refusal::Path {
                fault: PathFault::SelfCollision { .. },
                ..
            }))
        );
        if (most - LINK_OVERLAP).abs() > 1e-3 {
            assert_eq!(
                is_refused,
                most > LINK_OVERLAP,
                "{from:?} {to:?} {most} {outcome:?}"
            );
        }
        assert!(is_refused || outcome.is_none(), "{outcome:?}");
        seen += u32::from(is_refused);
    }
    assert!(seen > 20, "{seen}");
}

#[test]
fn a_target_is_judged_as_is_within_safety_limits_judges_it() {
    let (mut refused, mut allowed) = (0, 0);
    for name in MODELS {
        let mut draw = Draw::new(29);
        let model = RobotModel::built_in(name).unwrap();
        let bounds = ideal(name).target_safety_bounds().unwrap();
        for _ in 0..60 {
            let mut any = |bend: f64| {
                let mut q = core::array::from_fn(|_| draw.between(-2.0, 2.0));
                q[2] = bend;
                JointPositions(q)
            };
            let (from, to) = (any(1.6), any(2.6));
            let config = CycleConfig {
                home: from,
                ..ideal(name)
            };
            let mut bench = Bench::new(config);
            let id = bench.send(movej(to));
            bench.run(3);
            let fault = match bench.outcome(id) {
                Some(Outcome::Refused(Refusal::Path { fraction, fault })) => {
                    matches!(fault, PathFault::SelfCollision { .. }).then_some(fraction)
                }
                _ => None,
            };
            // On the way there it may be too near as well, which the target does not tell.
            let is_forbidden = bounds.link_violation(&model, &to, &from).is_some();
            assert!(!is_forbidden || fault.is_some(), "{name} {from:?} {to:?}");
            let at_the_end = fault.is_some_and(|fraction| fraction >= 1.0);
            assert!(!at_the_end || is_forbidden, "{name} {from:?} {to:?}");
            refused += u32::from(is_forbidden);
            allowed += u32::from(fault.is_none());
        }
    }
    assert!(refused > 20 && allowed > 20, "{refused} {allowed}");
}

#[test]
fn a_line_into_itself_is_refused() {
    let mut bench = Bench::new(ideal("cs66"));
    let mut refused = 0;
    let start = bench.now().target_tcp_pose;
    for (dx, dz) in [
        (0.35, 0.0),
        (0.4, -0.1),
        (0.45, -0.2),
        (0.4, -0.3),
        (0.5, -0.3),
    ] {
        let mut target = start;
        target.xyz[0] += dx;
        target.xyz[2] += dz;
        let outcome = bench.do_it(common::movel(target));
        println!("{dx} {dz}: {outcome:?}");
        if let Outcome::Refused(Refusal::Path {
            fault: PathFault::SelfCollision { .. },
            fraction,
        }) = outcome
        {
            assert!((0.05..=1.0).contains(&fraction));
            refused += 1;
        }
        bench.do_it(movej(ideal("cs66").home));
    }
    assert!(refused > 0);
}

#[test]
fn online_modes_stop_before_links_meet() {
    let into = JointSpeeds([0.0, 0.0, 3.0, 0.0, 0.0, 0.0]);
    let modes: [&[CommandKind]; 2] = [
        &[CommandKind::Online(OnlineCommand::SpeedJ {
            speeds: into,
            acceleration: 20.0,
            duration: Some(3.0),
        })],
        &[CommandKind::Online(OnlineCommand::ServoJ {
            target: FOLDED,
            duration: 3.0,
            lookahead: 0.03,
            gain: 2000.0,
        })],
    ];
    for model in MODELS {
        for commands in modes {
            let mut bench = Bench::new(nearly(model));
            commands.iter().for_each(|kind| {
                bench.send(*kind);
            });
            bench.run(750);
            let [StopReason::SelfCollision { .. }] = bench.stops[..] else {
                panic!("{model} {commands:?} {:?}", bench.stops);
            };
            let deep = deepest(&bench.states, model);
            assert!(deep < LINK_OVERLAP + 1e-6, "{model} {deep}");
            assert!(deep > -0.05, "{model} stops for nothing: {deep}");
            bench.check_limits();
            // It can be led away, and not further in.
            assert_eq!(
                bench.do_it(MachineCommand::UnlockProtectiveStop),
                Outcome::Done
            );
            let back = JointPositions(NEARLY.0.map(|q| q * 0.9));
            assert_eq!(
                bench.do_it(movej(back)),
                Outcome::Done,
                "{model} {:?}",
                bench.stops
            );
        }
    }
}

#[test]
fn hands_and_forces_do_not_fold_the_arm_either() {
    let force = CommandKind::Overlay(OverlayCommand::ForceMode {
        frame: kinematics::RpyPose::default(),
        selection: [true, true, true, false, false, false],
        wrench: [0.0, 0.0, -60.0, 0.0, 0.0, 0.0],
        mode: 0,
        speed_limits: [0.3, 0.3, 0.3, 0.5, 0.5, 0.5],
    });
    let free = CommandKind::Online(OnlineCommand::Freedrive {
        free_axes: [true, true, true, false, false, false],
        frame: FreedriveFrame::Base,
    });
    let speedl = CommandKind::Online(OnlineCommand::SpeedL {
        speed: [0.25, 0.0, -0.2, 0.0, 0.0, 0.0],
        acceleration: 2.0,
        rotation_acceleration: 2.0,
        duration: Some(5.0),
    });
    for (name, kind) in [("force", force), ("freedrive", free), ("speedl", speedl)] {
        let mut bench = Bench::new(ideal("cs66"));
        bench.do_it(SensingCommand::SetCollisionDetection(false));
        bench.send(kind);
        if name != "speedl" {
            // Towards the foot of the arm, and down.
            bench.push([35.0, 0.0, -30.0, 0.0, 0.0, 0.0]);
        }
        bench.run(1500);
        let deep = deepest(&bench.states, "cs66");
        println!("{name}: {deep} {:?}", bench.stops);
        assert!(deep < LINK_OVERLAP + 1e-6, "{name} {deep}");
        assert!(
            matches!(bench.stops[..], [StopReason::SelfCollision { .. }]),
            "{name} {:?}",
            bench.stops
        );
    }
}

#[test]
fn it_can_be_switched_off() {
    let mut config = ideal("cs66");
    config.limits.self_collision = Some(false);
    let mut bench = Bench::new(config);
    assert_eq!(bench.do_it(movej(FOLDED)), Outcome::Done);
    assert!(deepest(&bench.states, "cs66") > 0.05);
}

#[test]
fn an_arm_that_stands_in_itself_may_leave_but_not_go_deeper() {
    let config = || CycleConfig {
        home: JointPositions([0.0, -1.5708, 2.9, 0.0, 0.0, 0.0]),
        ..ideal("cs66")
    };
    assert!(overlap(&config().model, &config().home) > 0.03);
    let mut bench = Bench::new(config());
    bench.run(100);
    assert!(bench.stops.is_empty());
    assert!(matches!(bench.do_it(movej(FOLDED)), Outcome::Refused(_)));
    assert_eq!(
        bench.do_it(movej(NEARLY)),
        Outcome::Done,
        "{:?}",
        bench.stops
    );
    let mut bench = Bench::new(config());
    bench.send(OnlineCommand::SpeedJ {
        speeds: JointSpeeds([0.0, 0.0, -0.3, 0.0, 0.0, 0.0]),
        acceleration: 1.0,
        duration: Some(2.0),
    });
    bench.run(600);
    assert!(bench.stops.is_empty(), "{:?}", bench.stops);
    assert!(bench.now().target_q[2] < 2.4);
}

/// A pose as programs have them: the elbow on one side, the tool looking down within some twenty degrees, before,
/// beside or behind the arm, or a little off that.
fn ordinary(draw: &mut Draw) -> JointPositions {
    let side = if draw.between(0.0, 1.0) < 0.5 {
        1.0
    } else {
        -1.0
    };
    let shoulder = draw.between(0.5, 2.4);
    let elbow = draw.between(0.3, 2.2);
    let tilt = draw.between(-0.35, 0.35);
    let wrist = core::f64::consts::FRAC_PI_2 + draw.between(-0.35, 0.35);
    let q3 = elbow * side;
    let q2 = if side > 0.0 {
        -shoulder
    } else {
        shoulder - core::f64::consts::PI
    };
    JointPositions([
        draw.between(-3.1, 3.1),
        q2,
        q3,
        -core::f64::consts::FRAC_PI_2 - (q2 + q3) + tilt,
        -wrist,
        draw.between(-3.1, 3.1),
    ])
}

#[test]
fn no_ordinary_pose_of_any_model_is_taken_for_a_collision() {
    for model in MODELS {
        let mut draw = Draw::new(5);
        let arm = RobotModel::built_in(model).unwrap();
        let mut most = (f64::NEG_INFINITY, JointPositions::ZERO);
        for _ in 0..100_000 {
            let q = ordinary(&mut draw);
            let depth = overlap(&arm, &q);
            if depth > most.0 {
                most = (depth, q);
            }
        }
        let found = arm.collision().self_distance(&arm.forward(&most.1));
        println!("{model}: {most:?} {found:?}");
        assert!(most.0 < LINK_OVERLAP, "{model} {most:?} {found:?}");
    }
}
