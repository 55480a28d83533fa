//! The best base pose is at least as good as any of a fine grid.

use kinematics::{Pose, RobotModel, RpyPose};
use path_planning::placement::{BasePose, PlacementCheck, PlacementRequest, place};
use path_planning::{CollisionScene, ObstaclePlace, PlacedShape, Shape};

fn request(has_yaw: bool) -> PlacementRequest {
    let arm = RobotModel::built_in("cs66").unwrap();
    let mut scene = CollisionScene::new(arm, None, Pose::from_translation(0.0, 0.0, 0.1));
    let post = Shape::Cylinder {
        radius: 0.05,
        half_length: 0.5,
    };
    let place = ObstaclePlace::Standing(Pose::from_translation(0.2, 0.1, 0.5));
    scene.add_obstacle("post", vec![PlacedShape::centred(post)], place);
    let down = |x: f64, y: f64, z: f64, turn: f64| {
        Pose::from_rpy(&RpyPose {
            xyz: [x, y, z],
            rpy: [core::f64::consts::PI, 0.0, turn],
        })
    };
    PlacementRequest {
        scene,
        points: vec![
            down(0.5, 0.3, 0.3, 0.0),
            down(0.5, -0.3, 0.2, 0.5),
            down(0.6, 0.0, 0.4, -0.5),
        ],
        margin: 0.01,
        area: [-0.5, 0.5, -0.5, 0.5],
        has_yaw,
    }
}

#[test]
fn no_place_of_a_grid_is_better() {
    let request = request(false);
    let best = place(&request, &mut || false).unwrap();
    assert!(best.distance >= request.margin && best.joints.len() == 3);
    let mut check = PlacementCheck::new(&request);
    let mut largest = 0.0_f64;
    for i in 0..60 {
        for j in 0..60 {
            let side = |k: i32| -0.5 + f64::from(k) / 59.0;
            let base = BasePose {
                x: side(i),
                y: side(j),
                yaw: 0.0,
            };
            if let Ok(placement) = check.judge(&base, 1) {
                largest = largest.max(placement.joint_margin);
            }
        }
    }
    assert!(best.joint_margin >= largest - 1e-3, "{best:?} {largest}");
    let again = place(&request, &mut || false).unwrap();
    assert_eq!(again, best);
}

#[test]
fn points_that_are_out_of_reach_are_told() {
    let mut request = request(false);
    request.points.push(Pose::from_translation(3.0, 0.0, 0.3));
    assert_eq!(place(&request, &mut || false), Err(vec![3]));
}

#[test]
fn no_more_points_are_judged_than_are_asked_for() {
    let mut request = request(false);
    let base = place(&request, &mut || false).unwrap().base;
    let far = Pose::from_translation(3.0, 0.0, 0.3);
    request.points.insert(1, far);
    request.points.extend([far; 2]);
    let mut check = PlacementCheck::new(&request);
    assert_eq!(check.judge(&base, usize::MAX), Err(vec![1, 4, 5]));
    assert_eq!(check.judge(&base, 2), Err(vec![1, 4]));
    // The one that failed last is judged first.
    assert_eq!(check.judge(&base, 1), Err(vec![4]));
    assert_eq!(place(&request, &mut || false), Err(vec![1, 4, 5]));
}

/// Points that are judged in another order are the same placement.
#[test]
fn what_failed_before_changes_no_placement() {
    let request = request(false);
    let elsewhere = BasePose {
        x: -0.5,
        y: 0.5,
        yaw: 0.0,
    };
    let here = place(&request, &mut || false).unwrap().base;
    let fresh = PlacementCheck::new(&request).judge(&here, usize::MAX);
    assert!(fresh.is_ok());
    let mut check = PlacementCheck::new(&request);
    assert!(check.judge(&elsewhere, usize::MAX).is_err());
    assert_eq!(check.judge(&here, 1), fresh);
}

#[test]
fn a_ridge_between_two_joints_is_climbed() {
    // At the best places two joints are as near to their ends as each other: from beside them only directions within
    // some 30 degrees lead up.
    let arm = RobotModel::built_in("cs66").unwrap();
    let scene = CollisionScene::new(arm, None, Pose::from_translation(0.0, 0.0, 0.12));
    let pose = |xyz, rpy| Pose::from_rpy(&RpyPose { xyz, rpy });
    let request = PlacementRequest {
        scene,
        points: vec![
            pose([0.6207, 0.1849, 0.3070], [3.1390, -0.2144, 0.5877]),
            pose([0.5399, 0.0369, 0.4483], [3.5306, -0.2177, -2.8100]),
            pose([0.2363, -0.2389, 0.3493], [3.4815, 0.1129, -1.7846]),
            pose([0.3890, 0.3992, 0.4030], [3.3638, 0.3876, 0.3446]),
            pose([0.2466, 0.0861, 0.1995], [3.4643, 0.0502, 1.5988]),
        ],
        margin: 0.01,
        area: [-0.5, 0.5, -0.5, 0.5],
        has_yaw: false,
    };
    let best = place(&request, &mut || false).unwrap();
    let known = BasePose {
        x: -0.13636364,
        y: 0.5,
        yaw: 0.0,
    };
    let known = PlacementCheck::new(&request).judge(&known, 1).unwrap();
    assert!(
        best.joint_margin >= known.joint_margin,
        "{best:?} {known:?}"
    );
}
