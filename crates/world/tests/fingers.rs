//! Two fingers: moving, stalling, holding by friction, slipping, and what they tell.

use crate::cells::*;
use crate::hand::{Hand, ON};
use motion_api::IoPoint;
use world::description::*;
use world::{FingerState, WorldDescription};

const G: f64 = 9.81;
const OPENED: IoPoint = IoPoint::Digital(10);
const CLOSED: IoPoint = IoPoint::Digital(11);
const GRIPPING: IoPoint = IoPoint::Digital(12);

/// A cube of 50 mm and 1 kg on the floor, between fingers that open to 80 mm.
fn cell(force: f64, at: [f64; 6]) -> WorldDescription {
    let mut cell = empty();
    cell.parts.push(PartDescription {
        mass: Mass::Total(1.0),
        ..cube("box", at)
    });
    cell.grippers.push(Gripper {
        name: "fingers".into(),
        kind: GripperKind::Fingers(Fingers {
            stroke: 0.08,
            axis: [0.0, 1.0, 0.0],
            finger: (
                BodyShape::Box {
                    size: [0.02, 0.01, 0.04],
                },
                pose([0.0, 0.005, 0.1, 0.0, 0.0, 0.0]),
            ),
            force,
            speed: 0.05,
            friction: 0.5,
            control: FingerControl::Points {
                close: Some(ON),
                open: None,
            },
            opened: Some(OPENED),
            closed: Some(CLOSED),
            gripping: Some(GRIPPING),
        }),
    });
    cell
}

fn hand(force: f64, at: [f64; 6]) -> Hand {
    Hand::above(&cell(force, at), 0.0, 0.0, 0.13)
}

fn levels(hand: &Hand) -> [bool; 3] {
    [OPENED, CLOSED, GRIPPING].map(|point| hand.world.output().inputs.level(point))
}

#[test]
fn fingers_stop_at_the_part_and_tell_its_width() {
    let mut hand = hand(20.0, [0.0, 0.0, 0.025, 0.0, 0.0, 0.0]);
    assert_eq!(levels(&hand), [true, false, false]);
    hand.set(ON, true);
    hand.wait(0.1);
    assert_eq!(levels(&hand), [false, false, false]);
    // 15 mm a finger at 50 mm/s take 0.3 s.
    hand.wait(0.18);
    assert_eq!(hand.holding(), None);
    hand.wait(0.04);
    assert_eq!(hand.holding().as_deref(), Some("box"));
    assert_eq!(levels(&hand), [false, false, true]);
    assert!((hand.world.state().grippers[0].width - 0.05).abs() < 2e-4);
    assert_eq!(
        hand.world.state().grippers[0].fingers,
        FingerState::GrippingInside
    );
}

#[test]
fn fingers_with_nothing_between_them_close_and_open_in_their_time() {
    let mut hand = hand(20.0, [0.5, 0.0, 0.025, 0.0, 0.0, 0.0]);
    hand.set(ON, true);
    hand.wait(0.79);
    assert_eq!(levels(&hand), [false, false, false]);
    hand.wait(0.02);
    assert_eq!(levels(&hand), [false, true, false]);
    hand.set(ON, false);
    hand.wait(0.82);
    assert_eq!(levels(&hand), [true, false, false]);
}

#[test]
fn a_part_off_the_middle_is_pushed_there() {
    let mut hand = hand(20.0, [0.0, 0.01, 0.025, 0.0, 0.0, 0.0]);
    hand.set(ON, true);
    hand.wait(0.6);
    assert_eq!(hand.holding().as_deref(), Some("box"));
    assert!(hand.part(0).y.abs() < 3e-4, "{}", hand.part(0));
}

#[test]
fn friction_holds_five_percent_below_its_limit_and_lets_slip_five_percent_above() {
    for (margin, holds) in [(1.05, true), (0.95, false)] {
        let mut hand = hand(margin * G / (2.0 * 0.5), [0.0, 0.0, 0.025, 0.0, 0.0, 0.0]);
        hand.set(ON, true);
        hand.wait(0.6);
        assert_eq!(hand.holding().as_deref(), Some("box"));
        hand.shift([0.0, 0.0, 0.1], 4.0);
        hand.wait(3.0);
        assert_eq!(hand.holding().is_some(), holds, "{margin}");
        let fingers = hand.world.state().grippers[0].fingers;
        assert_eq!(fingers == FingerState::Lost, !holds, "{fingers:?}");
        assert_eq!(hand.part(0).z > 0.1, holds);
    }
}

#[test]
fn a_part_slips_with_the_acceleration_that_friction_leaves() {
    let mut hand = hand(5.0 * G, [0.0, 0.0, 0.025, 0.0, 0.0, 0.0]);
    hand.set(ON, true);
    hand.wait(0.6);
    hand.shift([0.0, 0.0, 0.2], 1.0);
    hand.wait(0.1);
    let before = hand.part(0).z;
    // A tenth of the force bears half of the weight.
    hand.world
        .fail(FaultKind::Leak("fingers".into()), None)
        .unwrap_or_else(|e| panic!("{e}"));
    hand.wait(0.1);
    let slip = before - hand.part(0).z;
    assert!((slip / (0.5 * G / 2.0 * 0.01) - 1.0).abs() < 0.05, "{slip}");
    assert!(hand.holding().is_some());
    hand.wait(0.1);
    assert!(hand.holding().is_none() && hand.world.state().parts[0].velocity.linear.z < -0.5);
}

#[test]
fn opening_lets_go_of_the_part() {
    let mut hand = hand(20.0, [0.0, 0.0, 0.025, 0.0, 0.0, 0.0]);
    hand.set(ON, true);
    hand.wait(0.6);
    hand.shift([0.0, 0.0, 0.1], 1.0);
    assert!((hand.part(0).z - 0.125).abs() < 1e-3);
    hand.set(ON, false);
    hand.wait(1.0);
    assert_eq!(hand.holding(), None);
    assert!((hand.part(0).z - 0.025).abs() < 2e-4);
    assert_eq!(levels(&hand), [true, false, false]);
}

#[test]
fn fingers_stall_on_what_they_cannot_push() {
    let mut cell = cell(20.0, [0.0, 0.02, 0.025, 0.0, 0.0, 0.0]);
    // A wall keeps the box from moving to the middle.
    cell.parts[0].pose.translation.y = 0.014;
    cell.obstacles.push(obstacle(
        "wall",
        [0.2, 0.02, 0.06],
        [0.0, -0.0215, 0.03, 0.0, 0.0, 0.0],
    ));
    let mut hand = Hand::above(&cell, 0.0, 0.0, 0.13);
    hand.set(ON, true);
    hand.wait(1.5);
    assert_eq!(hand.holding(), None);
    assert_eq!(levels(&hand), [false, false, true]);
    assert!(hand.world.state().grippers[0].width > 0.05);
}
