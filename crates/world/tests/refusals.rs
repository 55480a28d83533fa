//! Descriptions that are refused, with the text that says why.

use crate::cells::*;
use motion_api::IoPoint;
use world::description::*;
use world::{World, WorldDescription};

fn refused(change: impl FnOnce(&mut WorldDescription)) -> String {
    let mut cell = empty();
    cell.parts.push(cube("box", [0.0, 0.0, 0.5, 0.0, 0.0, 0.0]));
    cell.detectors.push(Detector {
        name: "eye".into(),
        to: IoPoint::Digital(7),
        delay: 0.0,
        inverted: false,
        kind: DetectorKind::Beam {
            from: [0.0; 3],
            until: [1.0, 0.0, 0.0],
        },
    });
    assert!(World::new(&cell).is_ok());
    change(&mut cell);
    World::new(&cell)
        .err()
        .map(|e| e.to_string())
        .unwrap_or_default()
}

#[test]
fn a_refusal_names_table_entry_key_value_and_what_is_allowed() {
    assert_eq!(
        refused(|cell| cell.parts[0].mass = Mass::Total(-1.0)),
        "[[part]] \"box\": mass is -1, allowed: 0.0001 kg to 10000 kg"
    );
    assert_eq!(
        refused(|cell| cell.parts[0].restitution = 1.5),
        "[[part]] \"box\": restitution is 1.5, allowed: 0 to 1"
    );
    assert_eq!(
        refused(|cell| cell.parts[0].name = "a[0]".into()),
        "[[part]] \"a[0]\": name is \"a[0]\", allowed: a name without '#', '[' and ']', not empty"
    );
    assert_eq!(
        refused(|cell| cell.obstacles.push(obstacle("box", [1.0; 3], [0.0; 6]))),
        "[[obstacle]]: name is \"box\", allowed: names that nothing else has ([[part]] has it)"
    );
    assert_eq!(
        refused(|cell| {
            let mut other = cell.detectors[0].clone();
            other.name = "other".into();
            cell.detectors.push(other);
        }),
        "[[detector]] \"other\": to is standard_digital_in[7], allowed: an input that nothing else drives (\"eye\" \
         drives it)"
    );
    assert_eq!(
        refused(|cell| cell.parts[0].copies = Some(Copies {
            count: [10, 10, 3],
            pitch: [0.1; 3]
        })),
        "[[part]]: 300 entries, allowed: up to 200"
    );
    assert_eq!(
        refused(|cell| cell
            .parts
            .push(cube("other", [0.0, 0.04, 0.5, 0.0, 0.0, 0.0]))),
        "[[part]] \"box\": pose overlaps \"other\" by 0.0100 m, allowed: poses in which parts do not overlap"
    );
    assert_eq!(
        refused(|cell| cell.faults.push(FaultDescription {
            when: Trigger::Time(1.0),
            what: FaultKind::Missing("bax".into()),
            duration: None
        })),
        "[[fault]] \"bax\": name names \"bax\", allowed: the name of a [[part]]"
    );
    assert_eq!(
        refused(|cell| cell.faults.push(FaultDescription {
            when: Trigger::Time(1.0),
            what: FaultKind::Missing("box".into()),
            duration: Some(0.0)
        })),
        "[[fault]] \"box\": duration is 0, allowed: more than 0, up to 1e6"
    );
}

#[test]
fn numbers_that_are_none_are_refused_wherever_they_stand() {
    let nan = f64::NAN;
    let refusals = [
        refused(|cell| cell.settings.gravity[1] = nan),
        refused(|cell| cell.settings.substep = nan),
        refused(|cell| cell.settings.floor = Some(f64::INFINITY)),
        refused(|cell| cell.parts[0].pose.translation.x = nan),
        refused(|cell| cell.parts[0].friction = nan),
        refused(|cell| cell.parts[0].mass = Mass::Density(nan)),
        refused(|cell| cell.parts[0].shape = BodyShape::Box { size: [nan; 3] }),
        refused(|cell| cell.parts[0].shape = BodyShape::Plane),
        refused(|cell| cell.detectors[0].delay = nan),
        refused(|cell| cell.detectors[0].to = IoPoint::FloatRegister(3)),
    ];
    assert!(
        refusals.iter().all(|text| text.contains("allowed")),
        "{refusals:#?}"
    );
}

#[test]
fn copies_stand_in_a_grid_with_x_running_fastest() {
    let mut cell = empty();
    cell.parts.push(PartDescription {
        copies: Some(Copies {
            count: [2, 1, 2],
            pitch: [0.1, 0.1, 0.06],
        }),
        ..cube("box", [0.0, 0.0, 0.025, 0.0, 0.0, 0.0])
    });
    let world = build(&cell);
    let at = |name: &str| {
        world
            .part(name)
            .ok()
            .flatten()
            .map(|p| <[f64; 3]>::from(p.pose.translation).map(|x| (x * 1e9).round() / 1e9))
    };
    assert_eq!(at("box[0]"), Some([0.0, 0.0, 0.025]));
    assert_eq!(at("box[1]"), Some([0.1, 0.0, 0.025]));
    assert_eq!(at("box[2]"), Some([0.0, 0.0, 0.085]));
    assert!(world.part("box[4]").is_err());
}
