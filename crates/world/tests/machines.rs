//! Conveyors, sources, sinks, detectors, actuators.

use crate::cells::*;
use motion_api::IoPoint;
use motion_api::WorldInput;
use world::description::*;
use world::{World, WorldDescription};

const RUN: IoPoint = IoPoint::Digital(3);
const SIGNAL: IoPoint = IoPoint::Digital(7);

/// A belt along x whose top is at z = 0.1.
fn belt(speed: f64) -> ConveyorDescription {
    ConveyorDescription {
        name: "belt".into(),
        surface: Surface::Belt {
            pose: pose([0.0, 0.0, 0.05, 0.0, 0.0, 0.0]),
            size: [6.0, 0.5, 0.1],
            direction: [1.0, 0.0, 0.0],
        },
        speed,
        friction: 0.6,
        run: Some(RUN),
        speed_from: None,
        acceleration: 2.0,
        start_at: 0.0,
        encoder: Some(0),
    }
}

fn detector(kind: DetectorKind, to: IoPoint) -> Detector {
    Detector {
        name: "eye".into(),
        to,
        delay: 0.0,
        inverted: false,
        kind,
    }
}

/// Steps with one output set.
fn run(world: &mut World, point: IoPoint, level: bool, seconds: f64) {
    let mut input = far_away();
    input.outputs.set_level(point, level);
    for _ in 0..(seconds / 0.004).round() as usize {
        world.step(&input);
    }
}

#[test]
fn a_belt_carries_by_friction_and_turns_its_encoder() {
    let mut cell = empty();
    cell.conveyors.push(belt(0.3));
    cell.parts
        .push(cube("box", [-2.0, 0.0, 0.125, 0.0, 0.0, 0.0]));
    let mut world = build(&cell);
    run(&mut world, RUN, false, 0.5);
    assert!(world.state().parts[0].velocity.linear.norm() < 1e-3);
    run(&mut world, RUN, true, 2.0);
    let part = &world.state().parts[0];
    assert!(
        (part.velocity.linear.x - 0.3).abs() < 1e-3,
        "{:?}",
        part.velocity
    );
    // The belt gets to its speed in 0.15 s, the part at the same time: its friction allows 4.9 m/s².
    let travel = world.output().encoder_travel[0];
    assert!(
        (travel - (0.3 * 2.0 - 0.3 * 0.15 / 2.0)).abs() < 2e-3,
        "{travel}"
    );
    assert!(
        (part.pose.translation.x + 2.0 - travel).abs() < 3e-3,
        "{}",
        part.pose.translation
    );
    run(&mut world, RUN, false, 1.0);
    assert!(world.state().parts[0].velocity.linear.norm() < 1e-3);
    assert_eq!(world.state().conveyors[0].speed, 0.0);
}

#[test]
fn a_sleeping_part_wakes_when_its_belt_starts() {
    let mut cell = empty();
    cell.conveyors.push(belt(0.3));
    cell.parts
        .push(cube("box", [-2.0, 0.0, 0.125, 0.0, 0.0, 0.0]));
    let mut world = build(&cell);
    run(&mut world, RUN, false, 5.0);
    run(&mut world, RUN, true, 1.0);
    assert!(world.state().parts[0].velocity.linear.x > 0.29);
}

#[test]
fn a_turntable_carries_along_circles() {
    let mut cell = empty();
    cell.conveyors.push(ConveyorDescription {
        surface: Surface::Turntable {
            center: pose([0.0, 0.0, 0.1, 0.0, 0.0, 0.0]),
            radius: 0.5,
        },
        ..belt(1.0)
    });
    cell.parts
        .push(cube("box", [0.3, 0.0, 0.125, 0.0, 0.0, 0.0]));
    let mut world = build(&cell);
    run(&mut world, RUN, true, 6.0);
    let (part, travel) = (&world.state().parts[0], world.output().encoder_travel[0]);
    let at = part.pose.translation;
    assert!((at.xy().norm() - 0.3).abs() < 2e-3, "{at}");
    let angle = at.y.atan2(at.x).rem_euclid(core::f64::consts::TAU);
    assert!((angle - travel).abs() < 0.02, "{angle} {travel}");
    assert!((part.velocity.angular.z - 1.0).abs() < 0.02);
}

#[test]
fn parts_jam_at_a_stopper_while_the_belt_runs_on() {
    let mut cell = empty();
    cell.conveyors.push(belt(0.3));
    cell.obstacles.push(obstacle(
        "stopper",
        [0.02, 0.5, 0.1],
        [1.01, 0.0, 0.15, 0.0, 0.0, 0.0],
    ));
    for i in 0..3 {
        cell.parts.push(cube(
            &format!("box{i}"),
            [0.5 - 0.2 * f64::from(i), 0.0, 0.125, 0.0, 0.0, 0.0],
        ));
    }
    let mut world = build(&cell);
    run(&mut world, RUN, true, 8.0);
    for (i, part) in world.state().parts.iter().enumerate() {
        assert!(
            (part.pose.translation.x - (0.975 - 0.05 * i as f64)).abs() < 2e-3,
            "{i}: {}",
            part.pose.translation
        );
        assert!((part.pose.translation.z - 0.125).abs() < 1e-3);
    }
}

#[test]
fn eight_boxes_stand_for_a_minute_on_a_running_belt() {
    let mut cell = empty();
    cell.settings.sleeping = false;
    cell.conveyors.push(ConveyorDescription {
        surface: Surface::Belt {
            pose: pose([4.0, 0.0, 0.05, 0.0, 0.0, 0.0]),
            size: [12.0, 0.5, 0.1],
            direction: [1.0, 0.0, 0.0],
        },
        ..belt(0.1)
    });
    for i in 0..8 {
        cell.parts.push(cube(
            &format!("box{i}"),
            [
                0.002 * f64::from(i % 2),
                0.0,
                0.125 + 0.05 * f64::from(i),
                0.0,
                0.0,
                0.0,
            ],
        ));
    }
    let mut world = build(&cell);
    let at = |world: &World| {
        world
            .state()
            .parts
            .iter()
            .map(|p| p.pose.translation)
            .collect::<Vec<_>>()
    };
    // The belt's start shifts and presses the boxes a little; from then on they stand.
    run(&mut world, RUN, true, 1.0);
    let before = at(&world);
    assert!(before[7].z > 0.475 - 1e-3);
    run(&mut world, RUN, true, 60.0);
    let after = at(&world);
    assert!(
        (after[0].x - before[0].x - 6.0).abs() < 0.01,
        "{}",
        after[0]
    );
    for (a, b) in before.iter().zip(&after) {
        let moved = (b - a) - (after[0] - before[0]);
        assert!(moved.xy().norm() < 1e-4 && moved.z.abs() < 1e-4, "{moved}");
    }
}

#[test]
fn the_edge_of_a_beam_falls_into_the_cycle_that_geometry_gives() {
    let mut cell = empty();
    cell.conveyors.push(belt(0.3));
    cell.parts
        .push(cube("box", [-0.5, 0.0, 0.125, 0.0, 0.0, 0.0]));
    cell.detectors.push(detector(
        DetectorKind::Beam {
            from: [0.0, -0.3, 0.12],
            until: [0.0, 0.3, 0.12],
        },
        SIGNAL,
    ));
    let mut late = detector(
        DetectorKind::Beam {
            from: [0.0, -0.3, 0.12],
            until: [0.0, 0.3, 0.12],
        },
        IoPoint::Digital(8),
    );
    (late.name, late.delay, late.inverted) = ("late".into(), 0.02, true);
    cell.detectors.push(late);
    let mut world = build(&cell);
    let (mut edges, mut history) = (0, Vec::new());
    for _ in 0..600 {
        run(&mut world, RUN, true, 0.004);
        let middle = world.state().parts[0].pose.translation.x;
        let inputs = world.output().inputs;
        let cut = middle.abs() < 0.025;
        if (middle.abs() - 0.025).abs() > 2e-6 {
            assert_eq!(inputs.level(SIGNAL), cut, "{middle}");
        }
        history.push(inputs.level(SIGNAL));
        edges +=
            usize::from(history.len() > 1 && history[history.len() - 2] != inputs.level(SIGNAL));
        if history.len() > 5 {
            assert_eq!(
                inputs.level(IoPoint::Digital(8)),
                !history[history.len() - 6]
            );
        }
    }
    assert_eq!(edges, 2);
}

#[test]
fn presence_sees_centres_and_distance_sees_the_first_thing() {
    let mut cell = empty();
    cell.parts
        .push(cube("box", [0.0, 0.0, 0.025, 0.0, 0.0, 0.0]));
    cell.detectors.push(detector(
        DetectorKind::Presence {
            pose: pose([0.04, 0.0, 0.025, 0.0, 0.0, 0.0]),
            size: [0.06, 0.1, 0.1],
        },
        SIGNAL,
    ));
    let down = pose([0.0, 0.0, 0.25, core::f64::consts::PI, 0.0, 0.0]);
    let mut distance = detector(
        DetectorKind::Distance {
            pose: down,
            range: 0.5,
        },
        IoPoint::Analog(1),
    );
    distance.name = "laser".into();
    cell.detectors.push(distance);
    let mut world = build(&cell);
    idle(&mut world, 100);
    assert!(!world.output().inputs.level(SIGNAL));
    assert!((world.output().inputs.analog[1] - 0.2 / 0.5).abs() < 1e-3);
    world
        .place("box", &pose([0.02, 0.0, 0.025, 0.0, 0.0, 0.0]))
        .unwrap_or_else(|e| panic!("{e}"));
    idle(&mut world, 1);
    assert!(world.output().inputs.level(SIGNAL));
    world.remove("box").unwrap_or_else(|e| panic!("{e}"));
    idle(&mut world, 1);
    assert!(!world.output().inputs.level(SIGNAL));
    // The floor is a thing as well.
    assert!((world.output().inputs.analog[1] - 0.5).abs() < 1e-3);
}

/// A source every half second at the head of a belt and a sink at its end.
fn line(scatter: f64) -> WorldDescription {
    let mut cell = empty();
    cell.conveyors.push(belt(0.3));
    cell.parts.push(cube("can", [0.0; 6]));
    cell.sources.push(SourceDescription {
        name: "feed".into(),
        part: "can".into(),
        pose: pose([-1.0, 0.0, 0.126, 0.0, 0.0, 0.0]),
        when: Trigger::Time(0.5),
        start_at: 1.0,
        limit: Some(6),
        scatter: [0.0, scatter, 0.0, 0.0, 0.0, scatter],
    });
    cell.sinks.push(Sink {
        name: "out".into(),
        pose: pose([1.0, 0.0, 0.1, 0.0, 0.0, 0.0]),
        size: [0.2, 0.5, 0.3],
    });
    cell
}

#[test]
fn sources_make_numbered_parts_and_sinks_count_them() {
    let mut world = build(&line(0.0));
    run(&mut world, RUN, true, 0.996);
    assert!(world.state().parts.is_empty());
    run(&mut world, RUN, true, 0.012);
    assert_eq!(&*world.state().parts[0].name, "can#1");
    run(&mut world, RUN, true, 20.0);
    assert_eq!(world.state().sources[0].made, 6);
    assert_eq!(world.state().sinks, [6]);
    assert!(world.state().parts.is_empty());
    assert_eq!(world.part("can#3"), Ok(None));
    assert!(world.part("can#7").is_err() && world.part("can").is_err());
}

#[test]
fn no_part_is_made_where_one_is() {
    let mut world = build(&line(0.0));
    run(&mut world, RUN, false, 3.9);
    assert_eq!(world.state().sources[0].made, 1);
    assert_eq!(world.state().sources[0].skipped, 5);
}

#[test]
fn scatter_is_one_of_the_seed() {
    let places = |seed| {
        let mut cell = line(0.01);
        cell.settings.seed = seed;
        let mut world = build(&cell);
        run(&mut world, RUN, true, 3.6);
        world
            .state()
            .parts
            .iter()
            .map(|p| p.pose.translation.y)
            .collect::<Vec<_>>()
    };
    assert_eq!(places(1), places(1));
    assert_ne!(places(1), places(2));
    assert!(places(1).iter().any(|y| y.abs() > 1e-3));
}

const EXTEND: IoPoint = IoPoint::Digital(4);
const EXTENDED: IoPoint = IoPoint::Digital(14);
const RETRACTED: IoPoint = IoPoint::Digital(15);

fn pusher() -> WorldDescription {
    let mut cell = empty();
    cell.obstacles.push(obstacle(
        "plate",
        [0.02, 0.1, 0.06],
        [-0.05, 0.0, 0.04, 0.0, 0.0, 0.0],
    ));
    cell.actuators.push(Actuator {
        name: "pusher".into(),
        travel: Travel::Linear {
            axis: [1.0, 0.0, 0.0],
            stroke: 0.1,
        },
        moves: vec!["plate".into()],
        time: 0.5,
        force: 200.0,
        extend: EXTEND,
        retract: None,
        extended: Some(EXTENDED),
        retracted: Some(RETRACTED),
        starts_extended: false,
    });
    cell
}

fn ends(world: &World) -> [bool; 2] {
    [EXTENDED, RETRACTED].map(|point| world.output().inputs.level(point))
}

#[test]
fn an_actuator_goes_from_end_to_end_in_its_time() {
    let mut world = build(&pusher());
    run(&mut world, EXTEND, false, 0.1);
    assert_eq!(ends(&world), [false, true]);
    run(&mut world, EXTEND, true, 0.25);
    let x = world.state().obstacles[0].translation.x;
    assert!((x - 0.0).abs() < 2e-3, "{x}");
    assert_eq!(ends(&world), [false, false]);
    run(&mut world, EXTEND, true, 0.24);
    assert_eq!(ends(&world), [false, false]);
    run(&mut world, EXTEND, true, 0.03);
    assert_eq!(ends(&world), [true, false]);
    run(&mut world, EXTEND, false, 0.6);
    assert_eq!(ends(&world), [false, true]);
    assert!((world.state().obstacles[0].translation.x + 0.05).abs() < 1e-4);
}

#[test]
fn an_actuator_pushes_parts() {
    let mut cell = pusher();
    cell.parts
        .push(cube("box", [0.0, 0.0, 0.025, 0.0, 0.0, 0.0]));
    let mut world = build(&cell);
    run(&mut world, EXTEND, true, 0.6);
    assert_eq!(ends(&world), [true, false]);
    let x = world.state().parts[0].pose.translation.x;
    assert!(x > 0.084 && x < 0.1, "{x}");
}

#[test]
fn a_blocked_actuator_presses_with_its_force_and_reaches_no_end() {
    let mut cell = pusher();
    cell.parts
        .push(cube("box", [0.0, 0.0, 0.025, 0.0, 0.0, 0.0]));
    cell.obstacles.push(obstacle(
        "wall",
        [0.1, 0.2, 0.2],
        [0.1, 0.0, 0.1, 0.0, 0.0, 0.0],
    ));
    let mut world = build(&cell);
    run(&mut world, EXTEND, true, 3.0);
    assert_eq!(ends(&world), [false, false]);
    let x = world.state().parts[0].pose.translation.x;
    assert!((x - 0.025).abs() < 1e-3, "{x}");
    let plate = world.state().obstacles[0].translation.x;
    assert!((plate + 0.01).abs() < 2e-3, "{plate}");
    run(&mut world, EXTEND, false, 1.0);
    assert_eq!(ends(&world), [false, true]);
}

#[test]
fn the_arm_stops_an_actuator_and_feels_its_force() {
    let mut cell = pusher();
    cell.arm.tool = Some((BodyShape::Box { size: [0.04; 3] }, pose([0.0; 6])));
    let mut world = build(&cell);
    let mut input = WorldInput {
        base_from_flange: pose([0.04, 0.0, 0.04, 0.0, 0.0, 0.0]),
        ..far_away()
    };
    world.step(&input);
    input.outputs.set_level(EXTEND, true);
    for _ in 0..500 {
        world.step(&input);
    }
    let force = world.output().tool_wrench.force;
    assert!((force.x - 200.0).abs() < 10.0, "{force}");
    assert_eq!(ends(&world), [false, false]);
}

#[test]
fn a_rotary_actuator_turns_a_door() {
    let mut cell = pusher();
    let quarter = core::f64::consts::FRAC_PI_2;
    cell.actuators[0].travel = Travel::Rotary {
        axis: [0.0, 0.0, 1.0],
        point: [-0.05, -0.05, 0.0],
        angle: quarter,
    };
    let mut world = build(&cell);
    run(&mut world, EXTEND, true, 0.6);
    assert_eq!(ends(&world), [true, false]);
    // The middle of the door was 50 mm along y from the hinge, and is 50 mm along -x now.
    let at = world.state().obstacles[0].translation;
    assert!(
        (at - nalgebra::Vector3::new(-0.1, -0.05, 0.04)).norm() < 1e-3,
        "{at}"
    );
}

#[test]
fn a_valve_with_two_coils_keeps_its_place() {
    let mut cell = pusher();
    cell.actuators[0].retract = Some(IoPoint::Digital(6));
    let mut world = build(&cell);
    run(&mut world, EXTEND, true, 0.2);
    run(&mut world, EXTEND, false, 0.6);
    assert_eq!(ends(&world), [true, false]);
    run(&mut world, IoPoint::Digital(6), true, 0.6);
    assert_eq!(ends(&world), [false, true]);
}
