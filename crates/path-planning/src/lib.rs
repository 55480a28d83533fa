//! Distances between an arm and its cell, and joint paths that keep them.
//!
//! Owns the collision scene (links, tool and held parts against obstacles and against each other, with names), the
//! least distance along a driven path, and the planner. Knows no program, no time, no physics and no file: who runs
//! programs verifies what comes out of here by running it. The same input and seed give the same bits on every machine.
//!
//! ```
//! use kinematics::{JointPositions, Pose, RobotModel};
//! use path_planning::{CollisionScene, ObstaclePlace, PathRequest, PlacedShape, Shape};
//!
//! // A post 0.35 m in front of the arm.
//! let arm = RobotModel::built_in("cs66")?;
//! let mut scene = CollisionScene::new(arm.clone(), None, Pose::IDENTITY);
//! let post = Shape::Cylinder { radius: 0.04, half_length: 0.5 };
//! let place = ObstaclePlace::Standing(Pose::from_translation(-0.45, 0.0, 0.5));
//! scene.add_obstacle("post", vec![PlacedShape::centred(post)], place);
//!
//! // From one side of it to the other: straight the arm would go through.
//! let from = JointPositions([0.8, -1.57, 1.57, -1.57, -1.57, 0.0]);
//! let to = JointPositions([-0.8, -1.57, 1.57, -1.57, -1.57, 0.0]);
//! let middle = JointPositions([0.0, -1.57, 1.57, -1.57, -1.57, 0.0]);
//! let nearest = scene.nearest(&middle).expect("there are obstacles");
//! assert!(nearest.distance < 0.0);
//! assert_eq!(scene.names(nearest.pair).1, "post");
//!
//! let request = PathRequest {
//!     scene: &scene,
//!     limits: arm.limits(),
//!     start: from,
//!     via: &[],
//!     goals: &[to],
//!     margin: 0.01,
//!     seed: 0,
//! };
//! let path = path_planning::plan(&request, &mut || false)?;
//! assert!(path.corners.len() > 2);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

// Results are the same on every machine (see `kinematics::elementary`).
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod placement;
mod planner;
pub mod scene;
pub mod shape;
mod solid;
pub mod tracker;

pub use planner::{JointPath, PathError, PathRequest, length, plan};
pub use scene::{
    CollisionScene, LINK_NAMES, ObstacleId, ObstaclePlace, Pair, PairDistance, PlacedArm, TouchRule,
};
pub use shape::{PlacedShape, Shape};
pub use tracker::{ClearanceTracker, NearestPlace};
