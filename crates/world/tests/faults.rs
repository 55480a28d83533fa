//! Faults by table and by order.

use crate::cells::*;
use motion_api::IoPoint;
use world::description::*;
use world::{OrderError, WorldDescription};

const SIGNAL: IoPoint = IoPoint::Digital(7);

fn cell() -> WorldDescription {
    let mut cell = empty();
    cell.parts
        .push(cube("box", [0.0, 0.0, 0.025, 0.0, 0.0, 0.0]));
    cell.detectors.push(Detector {
        name: "eye".into(),
        to: SIGNAL,
        delay: 0.0,
        inverted: false,
        kind: DetectorKind::Presence {
            pose: pose([0.0, 0.0, 0.025, 0.0, 0.0, 0.0]),
            size: [0.1; 3],
        },
    });
    cell
}

fn with(what: FaultKind, duration: Option<f64>) -> WorldDescription {
    let mut cell = cell();
    cell.faults.push(FaultDescription {
        when: Trigger::Time(1.0),
        what,
        duration,
    });
    cell
}

#[test]
fn a_missing_part_is_not_there_while_the_fault_lasts() {
    let mut world = build(&with(FaultKind::Missing("box".into()), Some(1.0)));
    idle(&mut world, 250);
    assert_eq!(world.state().parts.len(), 1);
    idle(&mut world, 1);
    assert!(world.state().parts.is_empty() && !world.output().inputs.level(SIGNAL));
    idle(&mut world, 250);
    assert_eq!(&*world.state().parts[0].name, "box");
    assert!(world.output().inputs.level(SIGNAL));
}

#[test]
fn a_turned_part_is_turned_about_its_vertical() {
    let mut world = build(&with(FaultKind::Turned("box".into()), None));
    idle(&mut world, 300);
    let rpy = world.state().parts[0].pose.to_rpy().rpy;
    assert!(
        (0.5..2.5).contains(&rpy[2]) && rpy[0].abs() < 1e-3 && rpy[1].abs() < 1e-3,
        "{rpy:?}"
    );
}

#[test]
fn inputs_are_stuck_or_open() {
    let level = |what| {
        let mut world = build(&with(what, Some(1.0)));
        idle(&mut world, 251);
        let _ = world.place("box", &pose([1.0, 0.0, 0.025, 0.0, 0.0, 0.0]));
        idle(&mut world, 1);
        let during = world.output().inputs.level(SIGNAL);
        let _ = world.place("box", &pose([0.0, 0.0, 0.025, 0.0, 0.0, 0.0]));
        idle(&mut world, 1);
        let again = world.output().inputs.level(SIGNAL);
        idle(&mut world, 250);
        (during, again, world.output().inputs.level(SIGNAL))
    };
    assert_eq!(level(FaultKind::Stuck(SIGNAL)), (true, true, true));
    assert_eq!(level(FaultKind::Open(SIGNAL)), (false, false, true));
}

#[test]
fn a_fault_begins_with_the_edge_of_a_point() {
    let mut cell = with(FaultKind::Missing("box".into()), None);
    cell.faults[0].when = Trigger::Output(IoPoint::Digital(2));
    let mut world = build(&cell);
    idle(&mut world, 500);
    assert_eq!(world.state().parts.len(), 1);
    let mut input = far_away();
    input.outputs.set_level(IoPoint::Digital(2), true);
    world.step(&input);
    assert!(world.state().parts.is_empty());
}

#[test]
fn orders_with_unknown_names_are_refused_with_the_name() {
    let mut world = build(&cell());
    let refused = |name: &str, what: &str| Err(format!("there is no {what} \"{name}\""));
    let said = |result: Result<(), OrderError>| result.map_err(|error| error.to_string());
    assert_eq!(
        said(world.fail(FaultKind::Drop("bax".into()), None)),
        refused("bax", "part")
    );
    assert_eq!(
        said(world.fail(FaultKind::Leak("cup".into()), None)),
        refused("cup", "gripper")
    );
    assert_eq!(
        said(world.fail(FaultKind::Slow("belt".into()), None)),
        refused("belt", "actuator or conveyor")
    );
    assert!(
        world
            .fail(FaultKind::Missing("box".into()), Some(f64::NAN))
            .is_err()
    );
    assert_eq!(
        said(world.place("bax", &pose([0.0; 6]))),
        refused("bax", "part")
    );
    assert!(
        world
            .place("box", &pose([f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0]))
            .is_err()
    );
    assert_eq!(
        world
            .add("box", &pose([0.5, 0.0, 0.025, 0.0, 0.0, 0.0]))
            .as_deref(),
        Ok("box#1")
    );
    idle(&mut world, 100);
    assert_eq!(world.touching("box#1"), Ok(vec!["floor".to_owned()]));
}
