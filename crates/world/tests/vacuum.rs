//! Suction cups against the closed forms of their law: hold 2 % below, lose 2 % above.

use crate::cells::*;
use crate::hand::{Hand, ON};
use core::f64::consts::PI;
use motion_api::IoPoint;
use world::WorldDescription;
use world::description::*;

const G: f64 = 9.81;
const RADIUS: f64 = 0.015;
const AREA: f64 = PI * RADIUS * RADIUS;
/// What is added to a load that a gripper has to bear, and what is taken away.
const MARGINS: [(f64, bool); 2] = [(0.98, false), (1.02, true)];

fn gripper(cups: &[[f64; 3]], pressure: f64) -> Gripper {
    Gripper {
        name: "cups".into(),
        kind: GripperKind::Vacuum(Vacuum {
            cups: cups.to_vec(),
            direction: [0.0, 0.0, 1.0],
            radius: RADIUS,
            pressure,
            reach: 0.003,
            build_up: 0.1,
            decay: 0.05,
            on: ON,
            blow_off: Some(IoPoint::Digital(1)),
            switch: Some(IoPoint::Digital(5)),
            threshold: 0.7,
            gauge: Some(IoPoint::Analog(0)),
        }),
    }
}

/// A box of 2 kg on the floor at the origin and a gripper whose rims are 0.1 m below the flange.
fn cell(size: [f64; 3], cups: &[[f64; 3]], pressure: f64) -> WorldDescription {
    let mut cell = empty();
    cell.parts.push(PartDescription {
        shape: BodyShape::Box { size },
        mass: Mass::Total(2.0),
        ..cube("box", [0.0, 0.0, size[2] / 2.0, 0.0, 0.0, 0.0])
    });
    cell.grippers.push(gripper(cups, pressure));
    cell
}

/// A hand whose rims touch the top of the box at (x, y), with full pressure.
fn hand_on_box(cell: &WorldDescription, x: f64) -> Hand {
    let BodyShape::Box { size } = cell.parts[0].shape else {
        panic!("a box")
    };
    let mut hand = Hand::above(cell, x, 0.0, size[2] + 0.1005);
    hand.set(ON, true);
    hand.wait(2.0);
    assert_eq!(hand.holding().as_deref(), Some("box"));
    hand
}

const FOUR: [[f64; 3]; 4] = [
    [0.06, 0.06, 0.1],
    [-0.06, 0.06, 0.1],
    [0.06, -0.06, 0.1],
    [-0.06, -0.06, 0.1],
];

#[test]
fn a_pull_is_borne_up_to_the_force_of_all_cups() {
    for (margin, holds) in MARGINS {
        let mut hand = hand_on_box(
            &cell([0.2, 0.2, 0.05], &FOUR, margin * 2.0 * G / (4.0 * AREA)),
            0.0,
        );
        hand.shift([0.0, 0.0, 0.1], 6.0);
        assert_eq!(hand.holding().is_some(), holds, "{margin}");
        assert_eq!(hand.part(0).z > 0.12, holds);
        assert_eq!(hand.world.state().grippers[0].lost_in_cycle > 0, !holds);
    }
}

#[test]
fn two_of_four_cups_bear_half_when_the_others_are_not_covered() {
    for (margin, holds) in MARGINS {
        // The box is only under the two cups at +x, centred between them.
        let mut hand = hand_on_box(
            &cell([0.05, 0.2, 0.05], &FOUR, margin * 2.0 * G / (2.0 * AREA)),
            -0.06,
        );
        assert_eq!(
            hand.world.state().grippers[0].sealed,
            [true, false, true, false]
        );
        hand.shift([0.0, 0.0, 0.1], 6.0);
        assert_eq!(hand.holding().is_some(), holds, "{margin}");
    }
}

#[test]
fn a_shear_is_borne_up_to_friction_times_that() {
    for (margin, holds) in MARGINS {
        let mut hand = hand_on_box(
            &cell(
                [0.2, 0.2, 0.05],
                &FOUR,
                margin * 2.0 * G / (0.5 * 4.0 * AREA),
            ),
            0.0,
        );
        hand.shift([0.0, 0.0, 0.4], 4.0);
        hand.turn([0.0, 1.0, 0.0], PI / 2.0, 8.0);
        assert_eq!(hand.holding().is_some(), holds, "{margin}");
    }
}

#[test]
fn a_part_that_hangs_beyond_the_cups_peels_off_at_the_moment_of_the_closed_form() {
    let (a, c) = (0.06, 0.2);
    let cups = [[a, 0.0, 0.1], [-a, 0.0, 0.1]];
    for (margin, holds) in MARGINS {
        let force = 2.0 * G * (a + c) / (2.0 * (a + RADIUS));
        let mut hand = hand_on_box(&cell([0.6, 0.1, 0.05], &cups, margin * force / AREA), c);
        hand.shift([0.0, 0.0, 0.1], 6.0);
        assert_eq!(hand.holding().is_some(), holds, "{margin}");
    }
}

#[test]
fn acceleration_counts_as_weight_does() {
    let seconds = 0.5;
    let acceleration = 5.7735 * 0.2 / (seconds * seconds);
    for (margin, holds) in MARGINS {
        let pressure = margin * 2.0 * (G + acceleration) / (4.0 * AREA);
        let mut hand = hand_on_box(&cell([0.2, 0.2, 0.05], &FOUR, pressure), 0.0);
        hand.shift([0.0, 0.0, 0.2], seconds);
        assert_eq!(hand.holding().is_some(), holds, "{margin}");
    }
}

#[test]
fn pressure_builds_up_and_decays_as_configured_and_is_told() {
    let cell = cell([0.2, 0.2, 0.05], &FOUR, 60000.0);
    let mut hand = Hand::above(&cell, 0.0, 0.0, 0.1505);
    hand.set(ON, true);
    hand.wait(0.1 + 0.004);
    let inputs = hand.world.output().inputs;
    let share = 1.0 - (-1.0_f64).exp();
    assert!(
        (inputs.analog[0] - share).abs() < 1e-9,
        "{}",
        inputs.analog[0]
    );
    assert!(!inputs.level(IoPoint::Digital(5)));
    hand.wait(0.024);
    assert!(hand.world.output().inputs.level(IoPoint::Digital(5)));
    hand.wait(2.0);
    hand.shift([0.0, 0.0, 0.1], 1.0);
    hand.set(ON, false);
    hand.wait(0.048);
    let pressure = hand.world.state().grippers[0].pressure;
    assert!((pressure / (60000.0 * (-0.048_f64 / 0.05).exp()) - 1.0).abs() < 1e-6);
    hand.wait(0.3);
    assert_eq!(hand.holding(), None);
    hand.wait(1.0);
    assert!((hand.part(0).z - 0.025).abs() < 1e-4);
}

#[test]
fn blowing_off_lets_go_within_thirty_milliseconds_and_without_a_push() {
    let mut hand = hand_on_box(&cell([0.2, 0.2, 0.05], &FOUR, 60000.0), 0.0);
    hand.shift([0.0, 0.0, 0.2], 1.0);
    hand.wait(0.2);
    hand.set(IoPoint::Digital(1), true);
    hand.wait(0.028);
    assert_eq!(hand.holding(), None);
    assert!(hand.world.state().parts[0].velocity.linear.z.abs() < 0.028 * G + 1e-6);
}

#[test]
fn a_part_that_stands_loads_the_arm_only_when_it_is_lifted() {
    let mut hand = hand_on_box(&cell([0.2, 0.2, 0.05], &FOUR, 60000.0), 0.0);
    let output = *hand.world.output();
    assert!((output.held_body.mass - 2.0).abs() < 1e-12);
    assert!(
        (output.held_body.com.z - 0.1255).abs() < 1e-3,
        "{:?}",
        output.held_body.com
    );
    // The payload pulls with its weight, and what bears the part takes that off.
    assert!((output.tool_wrench.force.z - 2.0 * G).abs() < 1e-6);
    hand.shift([0.0, 0.0, 0.1], 1.0);
    assert_eq!(hand.world.output().tool_wrench.force.norm(), 0.0);
}

#[test]
fn a_part_leaves_with_the_speed_it_has() {
    let mut hand = hand_on_box(&cell([0.2, 0.2, 0.05], &FOUR, 60000.0), 0.0);
    hand.shift([0.0, 0.0, 0.5], 1.0);
    for cycle in 1..=200 {
        hand.flange.translation.x += 0.5 * 0.004 * (f64::from(cycle) / 50.0).min(1.0);
        hand.set(ON, cycle < 100);
        hand.set(IoPoint::Digital(1), cycle >= 100);
        hand.wait(0.004);
        if hand.holding().is_none() {
            break;
        }
    }
    assert_eq!(hand.holding(), None);
    let velocity = hand.world.state().parts[0].velocity.linear;
    assert!((velocity.x - 0.5).abs() < 1e-9, "{velocity}");
}

#[test]
fn a_cup_does_not_seal_over_an_edge_nor_out_of_reach() {
    let cups = [[0.0, 0.0, 0.1]];
    for (x, height, seals) in [
        (0.0, 0.0, true),
        (0.09, 0.0, false),
        (0.0, 0.0025, true),
        (0.0, 0.004, false),
    ] {
        let cell = cell([0.2, 0.2, 0.05], &cups, 60000.0);
        let mut hand = Hand::above(&cell, x, 0.0, 0.15 + height);
        hand.set(ON, true);
        hand.wait(0.1);
        assert_eq!(hand.holding().is_some(), seals, "{x} {height}");
    }
}
