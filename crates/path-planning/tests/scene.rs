//! Names, pairs and distances of a scene.

use kinematics::{JointPositions, Pose, RobotModel};
use path_planning::{
    CollisionScene, LINK_NAMES, ObstaclePlace, PlacedArm, PlacedShape, Shape, TouchRule,
};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::scenes;

const HOME: JointPositions = JointPositions([0.0, -1.57, 1.57, -1.57, -1.57, 0.0]);

fn cube(half: f64) -> Vec<PlacedShape> {
    vec![PlacedShape::centred(Shape::Box { half: [half; 3] })]
}

fn standing(x: f64, y: f64, z: f64) -> ObstaclePlace {
    ObstaclePlace::Standing(Pose::from_translation(x, y, z))
}

#[test]
fn the_tool_above_a_cube_is_as_far_as_the_gap() {
    let arm = RobotModel::built_in("cs66").unwrap();
    let flange = arm.flange_pose(&HOME).translation;
    let tool = PlacedShape {
        pose: Pose::from_translation(0.0, 0.0, 0.05),
        shape: Shape::Cylinder {
            radius: 0.03,
            half_length: 0.05,
        },
    };
    let mut scene = CollisionScene::new(arm, Some(tool), Pose::IDENTITY);
    let place = standing(flange.x, flange.y, flange.z - 0.1 - 0.02 - 0.05);
    let cube_id = scene.add_obstacle("cube", cube(0.05), place);
    let nearest = scene.nearest(&HOME).unwrap();
    assert_eq!(scene.names(nearest.pair), ("tool", "cube"));
    assert!((nearest.distance - 0.02).abs() < 1e-3, "{nearest:?}");
    // Pushed up by 30 mm it is 10 mm deep.
    scene.set_place(cube_id, standing(flange.x, flange.y, flange.z - 0.14));
    let nearest = scene.nearest(&HOME).unwrap();
    assert!((nearest.distance + 0.01).abs() < 1e-3, "{nearest:?}");
    // Where the two may touch, something else is nearest.
    scene.allow_touches([TouchRule {
        a: "tool".to_owned(),
        b: "cu*".to_owned(),
    }]);
    let nearest = scene.nearest(&HOME).unwrap();
    assert_ne!(scene.names(nearest.pair), ("tool", "cube"));
}

#[test]
fn what_is_held_moves_with_the_arm_and_counts_against_the_rest() {
    let arm = RobotModel::built_in("cs66").unwrap();
    let flange = arm.flange_pose(&HOME);
    let mut scene = CollisionScene::new(arm, None, Pose::IDENTITY);
    let below = Pose::from_translation(
        flange.translation.x,
        flange.translation.y,
        flange.translation.z - 0.08,
    );
    let part = scene.add_obstacle("part", cube(0.05), ObstaclePlace::Standing(below));
    scene.set_place(part, ObstaclePlace::Held(flange.inverse() * below));
    let wall = standing(
        flange.translation.x - 0.2,
        flange.translation.y,
        below.translation.z,
    );
    let wall = scene.add_obstacle("wall", cube(0.1), wall);
    let of_pair = |scene: &CollisionScene| {
        let mut arm = PlacedArm::default();
        scene.place_arm(&HOME, &mut arm);
        let mut pairs = scene.pairs().iter();
        let pair = pairs.find(|pair| scene.names(**pair) == ("part", "wall"));
        pair.map(|pair| scene.distance(*pair, &arm))
    };
    let distance = of_pair(&scene).unwrap();
    assert!((distance - 0.05).abs() < 1e-3, "{distance}");
    scene.set_place(wall, ObstaclePlace::Absent);
    assert_eq!(of_pair(&scene), None);
    assert_eq!(
        scene.place(part),
        Some(ObstaclePlace::Held(flange.inverse() * below))
    );
}

#[test]
fn neighbours_and_the_base_against_obstacles_do_not_count() {
    let arm = RobotModel::built_in("cs66").unwrap();
    let mut scene = CollisionScene::new(arm.clone(), None, Pose::IDENTITY);
    scene.add_obstacle("cube", cube(0.05), standing(0.0, 0.0, 0.0));
    let names: Vec<(String, String)> = scene
        .pairs()
        .iter()
        .map(|pair| scene.names(*pair))
        .map(|(a, b)| (a.to_owned(), b.to_owned()))
        .collect();
    let has = |a: &str, b: &str| names.contains(&(a.to_owned(), b.to_owned()));
    assert!(!has("base", "cube") && has("shoulder", "cube") && has("tool", "cube"));
    assert!(has("tool", "forearm") && has("tool", "base") && !has("tool", "wrist_1"));
    for (outer, a) in LINK_NAMES.iter().enumerate() {
        for (inner, b) in LINK_NAMES.iter().enumerate() {
            let is_tested = arm.collision().tested_pairs().contains(&(inner, outer));
            assert_eq!(has(a, b), is_tested, "{a} {b}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, rng_seed: RngSeed::Fixed(47), ..ProptestConfig::default() })]

    /// What proves lines clear: no pair comes nearer than the bound says, and the quick distance is never above the
    /// right one.
    #[test]
    fn distances_change_by_no_more_than_the_bound(
        scene in scenes::scene(),
        from in scenes::joints(),
        turn in prop::array::uniform6(-0.3..0.3_f64),
    ) {
        let to = JointPositions(core::array::from_fn(|j| from[j] + turn[j]));
        let (mut before, mut after) = (PlacedArm::default(), PlacedArm::default());
        scene.place_arm(&from, &mut before);
        scene.place_arm(&to, &mut after);
        for &pair in scene.pairs() {
            let (first, second) = (scene.distance(pair, &before), scene.distance(pair, &after));
            let bound = scene.motion_bound(pair, &from, &to);
            prop_assert!((first - second).abs() <= bound + 4e-5, "{:?} {first} {second} {bound}", scene.names(pair));
            prop_assert!(scene.least_distance(pair, &before) <= first + 2e-5);
        }
    }
}
