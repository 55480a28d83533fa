//! What holds for any cell: energy, walls, grips, repetition.

use crate::cells::*;
use crate::hand::{Hand, ON};
use kinematics::Pose;
use motion_api::WorldInput;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use world::description::*;
use world::{World, WorldDescription, WorldState};

const G: f64 = 9.81;

/// Kinetic and potential energy of all parts, J.
fn energy(world: &World) -> f64 {
    let of = |part: &world::PartState| {
        let mass = world.part_mass(part.template).unwrap_or_default();
        let r = part.pose.rotation.matrix();
        let inertia = r * mass.inertia * r.transpose();
        let turning = part
            .velocity
            .angular
            .dot(&(inertia * part.velocity.angular));
        mass.mass * (part.velocity.linear.norm_squared() / 2.0 + G * part.pose.translation.z)
            + turning / 2.0
    };
    world.state().parts.iter().map(of).sum()
}

fn shape() -> impl Strategy<Value = BodyShape> {
    prop_oneof![
        [0.02..0.1_f64, 0.02..0.1_f64, 0.02..0.1_f64].prop_map(|size| BodyShape::Box { size }),
        (0.01..0.05_f64, 0.02..0.1_f64)
            .prop_map(|(radius, length)| BodyShape::Cylinder { radius, length }),
        (0.01..0.05_f64).prop_map(|radius| BodyShape::Sphere { radius }),
    ]
}

/// Parts of any shape above one another, a little aside, so that they fall in a heap.
fn heap() -> impl Strategy<Value = WorldDescription> {
    let part = (
        shape(),
        -0.03..0.03_f64,
        -0.03..0.03_f64,
        [-3.0..3.0_f64, -1.5..1.5_f64, -3.0..3.0_f64],
        0.0..0.9_f64,
        0.0..0.9_f64,
    );
    prop::collection::vec(part, 1..8).prop_map(|parts| {
        let mut cell = empty();
        for (i, (shape, x, y, rpy, friction, restitution)) in parts.into_iter().enumerate() {
            let height = 0.2 + 0.2 * i as f64;
            let at = [x, y, height, rpy[0], rpy[1], rpy[2]];
            cell.parts.push(PartDescription {
                shape,
                friction,
                restitution,
                ..cube(&format!("part{i}"), at)
            });
        }
        cell
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, rng_seed: RngSeed::Fixed(46), ..ProptestConfig::default() })]

    // A heap that lands may gain energy within a cycle, when contacts that happen together push bodies apart (up to 16
    // % of the start has been seen with restitution, 10 % without); what holds is that it never has more than at its
    // start.
    #[test]
    fn a_heap_never_has_more_energy_than_at_its_start_and_nothing_sinks_into_the_floor(cell in heap()) {
        let mut world = build(&cell);
        let start = energy(&world);
        for cycle in 0..750 {
            idle(&mut world, 1);
            let now = energy(&world);
            prop_assert!(now < 1.001 * start, "cycle {cycle}: {now} J of {start} J");
            for part in &world.state().parts {
                prop_assert!(part.pose.translation.z > 0.0, "{part:?}");
            }
        }
    }

    #[test]
    fn a_world_and_its_copy_go_the_same_way(cell in heap(), cycles in 1_usize..300) {
        let mut world = build(&cell);
        let mut again = build(&cell);
        idle(&mut world, cycles);
        let mut copy = world.clone();
        idle(&mut again, cycles);
        prop_assert_eq!(bits(world.state()), bits(again.state()));
        idle(&mut world, 200);
        idle(&mut copy, 200);
        prop_assert_eq!(bits(world.state()), bits(copy.state()));
        prop_assert_eq!(world.output(), copy.output());
    }

    #[test]
    fn a_part_that_the_cups_can_bear_never_leaves(
        ways in prop::collection::vec([-0.3..0.3_f64, -0.3..0.3_f64, -0.1..0.3_f64], 1..6),
    ) {
        let mut cell = empty();
        cell.parts.push(cube("box", [0.0, 0.0, 0.025, 0.0, 0.0, 0.0]));
        cell.grippers.push(Gripper { name: "cups".into(), kind: GripperKind::Vacuum(Vacuum {
            cups: vec![[0.0, 0.0, 0.1]],
            direction: [0.0, 0.0, 1.0],
            radius: 0.015,
            pressure: 60000.0,
            reach: 0.003,
            build_up: 0.1,
            decay: 0.05,
            on: ON,
            blow_off: None,
            switch: None,
            threshold: 0.7,
            gauge: None,
        }) });
        let mut hand = Hand::above(&cell, 0.0, 0.0, 0.151);
        hand.set(ON, true);
        hand.wait(1.0);
        hand.shift([0.0, 0.0, 0.5], 1.0);
        // 42 N bear 125 g at 30 m/s² with ease: the ways above take up to 0.52 m in 0.4 s, 19 m/s².
        for way in ways {
            hand.shift(way, 0.4);
            prop_assert_eq!(hand.holding(), Some("box".to_owned()));
        }
        let part = hand.world.state().parts[0].pose;
        let expected = hand.flange.transform_point(nalgebra::Vector3::new(0.0, 0.0, 0.126));
        prop_assert!((part.translation - expected).norm() < 1e-4);
    }
}

/// All numbers of the parts, as bits.
fn bits(state: &WorldState) -> Vec<u64> {
    let of = |part: &world::PartState| {
        let pose = part.pose.to_rpy().to_array();
        let velocity = part.velocity.to_array();
        pose.into_iter()
            .chain(velocity)
            .map(f64::to_bits)
            .collect::<Vec<_>>()
    };
    state.parts.iter().flat_map(of).collect()
}

#[test]
fn nothing_passes_through_anything_at_two_metres_a_second() {
    for thickness in [0.05, 0.01, 0.004] {
        // A plate stands in the way of the tool.
        let mut cell = empty();
        cell.settings.gravity = [0.0; 3];
        cell.parts.push(PartDescription {
            shape: BodyShape::Box {
                size: [thickness, 0.1, 0.1],
            },
            ..cube("plate", [0.0, 0.0, 1.0, 0.0, 0.0, 0.0])
        });
        cell.arm.tool = Some((
            BodyShape::Box {
                size: [0.02, 0.05, 0.05],
            },
            Pose::IDENTITY,
        ));
        let mut world = build(&cell);
        for cycle in 0..150 {
            let x = -0.3 + 0.008 * f64::from(cycle);
            world.step(&WorldInput {
                base_from_flange: pose([x, 0.0, 1.0, 0.0, 0.0, 0.0]),
                ..far_away()
            });
            let front = x + 0.01;
            let back = world.state().parts[0].pose.translation.x - thickness / 2.0;
            assert!(
                back > front - 0.5 * thickness,
                "{thickness}: tool at {front}, plate at {back}"
            );
        }
        // A plate falls on a shelf as thin as itself, as fast as that.
        let mut cell = empty();
        cell.settings.floor = None;
        cell.obstacles
            .push(obstacle("shelf", [0.3, 0.3, thickness], [0.0; 6]));
        let fall = 2.0 * 2.0 / (2.0 * G) + thickness;
        cell.parts.push(PartDescription {
            shape: BodyShape::Box {
                size: [0.1, 0.1, thickness],
            },
            ..cube("plate", [0.0, 0.0, fall, 0.0, 0.0, 0.0])
        });
        let mut world = build(&cell);
        idle(&mut world, 500);
        let z = world.state().parts[0].pose.translation.z;
        assert!((z - thickness).abs() < 1e-3, "{thickness}: {z}");
    }
}
