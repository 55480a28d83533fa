//! What no gripper holds: falls, slopes, pushes, stacks, against closed forms.

use crate::cells::*;
use kinematics::{Pose, Twist};
use motion_api::WorldInput;
use world::description::*;
use world::{World, WorldDescription};

const G: f64 = 9.81;

fn first(world: &World) -> (Pose, Twist) {
    let part = &world.state().parts[0];
    (part.pose, part.velocity)
}

#[test]
fn a_falling_box_follows_the_parabola_within_one_percent() {
    let mut cell = empty();
    cell.parts.push(cube("box", [0.0, 0.0, 2.0, 0.0, 0.0, 0.0]));
    let mut world = build(&cell);
    for cycle in 1..=140 {
        idle(&mut world, 1);
        let t = f64::from(cycle) * 0.004;
        let (at, velocity) = first(&world);
        let fallen = 2.0 - at.translation.z;
        if t > 0.1 {
            assert!(
                (fallen / (0.5 * G * t * t) - 1.0).abs() < 0.01,
                "{t}: {fallen}"
            );
        }
        assert!((velocity.linear.z + G * t).abs() < 1e-6);
    }
    idle(&mut world, 250);
    assert!((first(&world).0.translation.z - 0.025).abs() < 1e-4);
}

/// Way along a slope of this angle after `seconds`, m, of a box with friction 0.5 that lies on it.
fn way_on_slope(angle: f64, seconds: f64) -> f64 {
    let mut cell = empty();
    cell.settings.floor = None;
    let slope = pose([0.0, 0.0, 0.0, 0.0, angle, 0.0]);
    cell.obstacles.push(ObstacleDescription {
        pose: slope * Pose::from_translation(0.0, 0.0, -0.5),
        ..obstacle("slope", [40.0, 4.0, 1.0], [0.0; 6])
    });
    cell.parts.push(PartDescription {
        pose: slope * Pose::from_translation(0.0, 0.0, 0.025),
        ..cube("box", [0.0; 6])
    });
    let mut world = build(&cell);
    let start = first(&world).0.translation;
    idle(&mut world, (seconds / 0.004) as usize);
    slope.rotate_back(first(&world).0.translation - start).x
}

#[test]
fn a_box_on_a_slope_holds_and_slides_where_friction_says() {
    let limit = 0.5_f64.atan();
    let half_degree = 0.5_f64.to_radians();
    assert!(way_on_slope(limit - half_degree, 10.0).abs() < 2e-4);
    assert!(way_on_slope(limit + half_degree, 2.0) > 0.1);
    for degrees in [3.0_f64, 10.0, 20.0] {
        let angle = limit + degrees.to_radians();
        let acceleration = G * (angle.sin() - 0.5 * angle.cos());
        let way = way_on_slope(angle, 2.0);
        assert!(
            (way / (0.5 * acceleration * 4.0) - 1.0).abs() < 0.01,
            "{degrees}: {way}"
        );
    }
}

#[test]
fn a_box_that_slides_into_another_keeps_the_momentum_of_both() {
    let mut cell = empty();
    cell.settings.gravity = [0.0; 3];
    cell.parts.push(cube("one", [0.0, 0.0, 1.0, 0.0, 0.0, 0.0]));
    cell.parts.push(PartDescription {
        mass: Mass::Total(0.4),
        ..cube("two", [0.2, 0.001, 1.0, 0.0, 0.0, 0.0])
    });
    // The tool gives the first one its speed, and stops.
    cell.arm.tool = Some((BodyShape::Box { size: [0.02; 3] }, Pose::IDENTITY));
    let mut world = build(&cell);
    let mut x: f64 = -0.06;
    for cycle in 0..700 {
        x += if cycle < 25 { 0.002 } else { 0.0 };
        let input = WorldInput {
            base_from_flange: Pose::from_translation(x, 0.0, 1.0),
            ..far_away()
        };
        world.step(&input);
        if cycle == 40 {
            assert!(
                (first(&world).1.linear.x - 0.5).abs() < 0.005,
                "{:?}",
                first(&world).1
            );
        }
    }
    let momentum: f64 = world
        .state()
        .parts
        .iter()
        .zip([0.125, 0.4])
        .map(|(p, m)| m * p.velocity.linear.x)
        .sum();
    assert!((momentum / (0.125 * 0.5) - 1.0).abs() < 0.01, "{momentum}");
    assert!(world.state().parts[1].velocity.linear.x > 0.05);
}

fn tower(belt: bool) -> WorldDescription {
    let mut cell = empty();
    cell.settings.sleeping = false;
    for i in 0..8 {
        let shift = 0.002 * f64::from(i % 2);
        cell.parts.push(cube(
            &format!("box{i}"),
            [shift, 0.0, 0.025 + 0.05 * f64::from(i), 0.0, 0.0, 0.0],
        ));
    }
    if belt {
        for part in &mut cell.parts {
            part.pose.translation.z += 0.1;
        }
        cell.conveyors.push(ConveyorDescription {
            name: "belt".into(),
            surface: Surface::Belt {
                pose: pose([5.0, 0.0, 0.05, 0.0, 0.0, 0.0]),
                size: [12.0, 0.5, 0.1],
                direction: [1.0, 0.0, 0.0],
            },
            speed: 0.1,
            friction: 0.6,
            run: None,
            speed_from: None,
            acceleration: 2.0,
            start_at: 1.0,
            encoder: None,
        });
    }
    cell
}

/// Sinking of the top box and the largest creep of one box against the lowest in `seconds`, m.
fn sinking_and_creep(cell: &WorldDescription, seconds: f64) -> (f64, f64) {
    let mut world = build(cell);
    let at = |world: &World| {
        world
            .state()
            .parts
            .iter()
            .map(|p| p.pose.translation)
            .collect::<Vec<_>>()
    };
    let before = at(&world);
    idle(&mut world, (seconds / 0.004) as usize);
    let after = at(&world);
    let moved: Vec<_> = before
        .iter()
        .zip(&after)
        .map(|(a, b)| (b - a) - (after[0] - before[0]))
        .collect();
    let creep = moved.iter().map(|d| d.xy().norm()).fold(0.0, f64::max);
    (before[7].z - after[7].z, creep)
}

#[test]
fn eight_boxes_stand_for_a_minute_without_sleeping() {
    let (sinking, creep) = sinking_and_creep(&tower(false), 60.0);
    assert!(sinking.abs() < 1e-3 && creep < 1e-4, "{sinking} {creep}");
}
