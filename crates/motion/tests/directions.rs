//! Targets that no arm reaches: the arm goes along the line to them until something stops it, or as far as it can.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::draw::Draw;
use common::{Bench, MODELS, ideal, moved, movel, tcp_speed};
use kinematics::safety::{PlaneMode, SafetyPlane};
use kinematics::{JointPositions, Pose, SafetyBounds};
use motion::CycleConfig;
use motion_api::{
    CommandId, CommandKind, MachineCommand, MotionCommand, OnlineCommand, Outcome, PathFault,
    Refusal, Warning,
};
use nalgebra::Vector3;

/// A target so far away in a direction, m.
const FAR: f64 = 1000.0;

fn towards(bench: &Bench, along: &Vector3<f64>, speed: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveL {
        target: moved(&bench.now().target_tcp_pose, (along * FAR).into()),
        acceleration: 0.6,
        speed,
        duration: 0.0,
        radius: 0.0,
    })
}

/// Every state lies on the line from the first one, and nothing was stopped.
fn check_line(bench: &Bench, along: &Vector3<f64>, from: usize) {
    let start = Vector3::from(bench.states[from].target_tcp_pose.xyz);
    for state in &bench.states[from..] {
        let way = Vector3::from(state.target_tcp_pose.xyz) - start;
        assert!(
            way.cross(along).norm() < 1e-6,
            "{way:?} in cycle {}",
            state.cycle
        );
    }
    assert!(bench.stops.is_empty(), "{:?}", bench.stops);
    bench.check_limits();
}

#[test]
fn in_any_direction_the_arm_goes_on_its_line_as_far_as_it_can_and_says_why_no_further() {
    let (mut refused, mut ends, mut slowest) = (0, [0; 4], 0.0_f64);
    for seed in 0..150 {
        let mut draw = Draw::new(seed);
        let model = *draw.pick(&MODELS);
        let q = JointPositions([
            draw.between(-3.0, 3.0),
            draw.between(-2.2, -0.8),
            draw.between(0.6, 2.2),
            draw.between(-2.4, -0.8),
            draw.between(-2.4, -0.7),
            draw.between(-3.0, 3.0),
        ]);
        let config = CycleConfig {
            home: q,
            step_time: *draw.pick(&[0.002, 0.004, 0.008]),
            ..ideal(model)
        };
        let mut bench = Bench::new(config);
        let along = Vector3::new(
            draw.between(-1.0, 1.0),
            draw.between(-1.0, 1.0),
            draw.between(-1.0, 1.0),
        )
        .normalize();
        let kind = towards(&bench, &along, draw.spread(0.05, 1.0));
        let id = bench.send(kind);
        let outcome = bench.finish(id);
        let Outcome::Refused(Refusal::DirectionEnds { way, fault }) = outcome else {
            panic!("{seed} {model}: {outcome:?}");
        };
        let is_told = bench.warnings.iter().any(|(of, warning)| {
            *of == id
                && matches!(warning, Warning::Direction { distance } if (distance - FAR).abs() < 1.0)
        });
        let start = Vector3::from(bench.states[0].target_tcp_pose.xyz);
        let gone = Vector3::from(bench.now().target_tcp_pose.xyz) - start;
        assert!(
            (gone.dot(&along) - way).abs() < 1e-6,
            "{seed}: {gone} {way}"
        );
        assert_eq!(is_told, way > 0.0, "{seed}");
        refused += usize::from(way == 0.0);
        ends[match fault {
            PathFault::OutOfReach => 0,
            PathFault::JointLimit { .. } => 1,
            PathFault::Singular { .. } => 2,
            _ => 3,
        }] += 1;
        bench.run(5);
        assert_eq!(bench.now().target_qd.max_abs(), 0.0);
        check_line(&bench, &along, 0);
        // Not long before the place where a line of that length is refused.
        // No crawling to where it can go no further.
        let slow = bench.states.iter().filter(|state| {
            let left = way - (Vector3::from(state.target_tcp_pose.xyz) - start).dot(&along);
            left < 0.01
        });
        let slow = slow.count() as f64 * bench.cycle.step_time();
        slowest = slowest.max(slow);
        if way > 0.0 && matches!(fault, PathFault::OutOfReach) {
            let mut other = Bench::new(CycleConfig {
                home: q,
                ..ideal(model)
            });
            let target = moved(&other.now().target_tcp_pose, (along * (way + 0.05)).into());
            let beyond = other.do_it(movel(target));
            assert!(
                matches!(beyond, Outcome::Refused(_)),
                "{seed}: {way} {fault}"
            );
        }
    }
    println!("the last centimetre takes {slowest:.2} s at most");
    assert!(slowest < 3.0, "{slowest}");
    println!("{refused} could go nowhere; out of reach, range, singular, links: {ends:?}");
    assert!(
        refused < 30 && [0, 2, 3].iter().all(|k| ends[*k] > 3),
        "{refused} {ends:?}"
    );
}

#[test]
fn before_a_safety_plane_a_direction_ends_on_its_line() {
    for seed in 0..20 {
        let mut draw = Draw::new(seed);
        let y = ideal("cs66").first_state().target_tcp_pose.xyz[1];
        let wall = y + draw.between(0.05, 0.3);
        let plane = SafetyPlane::new([0.0, wall, 0.0], [0.0, -1.0, 0.0], PlaneMode::Normal, None);
        let mut bench = Bench::new(CycleConfig {
            safety: SafetyBounds::default().with_plane(plane.unwrap()).unwrap(),
            ..ideal("cs66")
        });
        let along = Vector3::new(draw.between(-0.5, 0.5), 1.0, draw.between(-0.2, 0.4)).normalize();
        let outcome = bench.do_it(towards(&bench, &along, draw.spread(0.05, 1.0)));
        let Outcome::Refused(Refusal::DirectionEnds { fault, .. }) = outcome else {
            panic!("{seed}: {outcome:?}");
        };
        assert_eq!(fault, PathFault::SafetyPlane { plane: 0 });
        let at = bench.now().target_tcp_pose.xyz[1];
        assert!(at <= wall && at > wall - 1e-3, "{at} {wall}");
        check_line(&bench, &along, 0);
    }
}

#[test]
fn what_stops_a_motion_stops_one_in_a_direction_and_the_arm_obeys_afterwards() {
    let up = Vector3::z();
    let stops = [
        CommandKind::Online(OnlineCommand::StopL { acceleration: 0.6 }),
        CommandKind::Online(OnlineCommand::StopJ { acceleration: 2.0 }),
        CommandKind::Machine(MachineCommand::Stop {
            only: CommandId::NONE,
        }),
    ];
    for stop in stops {
        let mut bench = Bench::new(ideal("cs66"));
        let home = bench.now().target_tcp_pose;
        let id = bench.send(towards(&bench, &up, 0.15));
        bench.run(300);
        assert!((tcp_speed(&bench.now()) - 0.15).abs() < 1e-9);
        assert_eq!(bench.do_it(stop), Outcome::Done);
        assert_eq!(bench.outcome(id), Some(Outcome::Aborted));
        // Joints that brake in proportion leave the line.
        if !matches!(stop, CommandKind::Online(OnlineCommand::StopJ { .. })) {
            check_line(&bench, &up, 0);
        }
        assert_eq!(bench.do_it(movel(home)), Outcome::Done);
        bench.check_limits();
    }
}

#[test]
fn a_direction_turns_no_tool_takes_no_time_and_has_no_end_to_blend() {
    let mut bench = Bench::new(ideal("cs66"));
    let start = Pose::from_rpy(&bench.now().target_tcp_pose);
    let target = moved(&bench.now().target_tcp_pose, [0.0, 0.0, FAR]);
    let with = |duration, radius| {
        CommandKind::Motion(MotionCommand::MoveL {
            target,
            acceleration: 0.6,
            speed: 0.5,
            duration,
            radius,
        })
    };
    let outcome = bench.do_it(with(3.0, 0.0));
    assert!(
        matches!(
            outcome,
            Outcome::Refused(Refusal::BadValue { name, .. }) if *name == "t"
        ),
        "{outcome:?}"
    );
    let outcome = bench.do_it(with(0.0, 0.05));
    assert!(
        matches!(outcome, Outcome::Refused(Refusal::DirectionEnds { .. })),
        "{outcome:?}"
    );
    let radius = bench
        .warnings
        .iter()
        .find_map(|(_, warning)| match warning {
            Warning::DirectionNotBlended { radius } => Some(*radius),
            _ => None,
        });
    assert_eq!(radius, Some(0.05));
    let end = Pose::from_rpy(&bench.now().target_tcp_pose);
    assert!(end.rotation.angle_to(&start.rotation) < 1e-6);
}

#[test]
fn a_line_blends_into_a_direction_and_a_near_target_is_refused_beforehand() {
    let mut bench = Bench::new(ideal("cs66"));
    let at = bench.now().target_tcp_pose;
    let corner = moved(&at, [0.0, 0.1, 0.0]);
    let first = bench.send(MotionCommand::MoveL {
        target: corner,
        acceleration: 1.2,
        speed: 0.2,
        duration: 0.0,
        radius: 0.03,
    });
    while !bench.queued.contains(&first) {
        bench.tick();
    }
    let id = bench.send(MotionCommand::MoveP {
        target: moved(&corner, [0.0, 0.0, FAR]),
        acceleration: 1.2,
        speed: 0.2,
        radius: 0.0,
    });
    let outcome = bench.finish(id);
    assert!(
        matches!(outcome, Outcome::Refused(Refusal::DirectionEnds { .. })),
        "{outcome:?}"
    );
    // Through the corner without a stop.
    let slowest = bench.states.iter().filter(|state| {
        let xyz = state.target_tcp_pose.xyz;
        (xyz[1] - corner.xyz[1]).hypot(xyz[2] - corner.xyz[2]) < 0.03
    });
    let slowest = slowest.map(tcp_speed).fold(f64::INFINITY, f64::min);
    assert!(slowest > 0.1, "{slowest}");
    bench.check_limits();
    let far = moved(&at, [0.0, 0.0, 9.0]);
    let before = bench.now().target_q;
    let outcome = bench.do_it(movel(far));
    assert!(
        matches!(outcome, Outcome::Refused(Refusal::Path { .. })),
        "{outcome:?}"
    );
    assert_eq!(bench.now().target_q, before);
}
