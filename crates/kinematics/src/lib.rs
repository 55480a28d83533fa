//! Poses, robot models, kinematics and dynamics of the CS six-axis arms.
//!
//! Owns the mathematics of one arm: transforms, URDF models, forward and inverse kinematics, Jacobians, rigid-body
//! dynamics. Knows no script, no socket, no clock, and no file other than the URDF and the calibration it is
//! handed. How much of such a file is read is one rule for all crates above ([`text_file`]).
//!
//! Units are SI throughout: metres, radians, seconds, kilograms, newtons. Six-vectors are linear before angular.
//!
//! ```
//! use kinematics::{JointPositions, Pose, RobotModel};
//!
//! let arm = RobotModel::built_in("cs66")?;
//! let q = JointPositions([0.3, -1.2, 1.9, -0.7, 1.5, 0.2]);
//! let tcp = Pose::from_translation(0.0, 0.0, 0.1);
//! let pose = arm.tcp_pose(&q, &tcp);
//! let back = arm.inverse_nearest(&pose, &tcp, &q).expect("a pose that was just reached has a solution");
//! assert!(q.distance_squared(&back) < 1e-18);
//! # Ok::<(), kinematics::ModelError>(())
//! ```

// Results are the same on every machine (see `elementary`).
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod batch;
pub mod bounds;
pub mod calibration;
pub mod catalogue;
pub mod chain;
pub mod collision;
mod composite;
pub mod dh;
pub mod dynamics;
pub mod elementary;
pub mod identification;
pub mod ik;
pub mod joint;
mod matrix3;
pub mod model;
pub mod payload;
pub mod polytope;
pub mod pose;
pub mod random;
pub mod rotation;
pub mod safety;
pub mod script_math;
pub mod text_file;
pub mod trig;
pub mod urdf;
pub mod wrench;

pub use calibration::{Calibration, CalibrationError};
pub use chain::{Chain, Frames, Posture};
pub use collision::{Capsule, CollisionModel, LinkDistance};
pub use dh::DhTable;
pub use dynamics::{Dynamics, GRAVITY_UPRIGHT};
pub use ik::{IkMethod, IkSolutions, MAX_CLOSED_FORM_SOLUTIONS, MAX_SOLUTIONS};
pub use joint::{DOF, JointAccelerations, JointJerks, JointPositions, JointSpeeds, JointTorques};
pub use model::{JointLimits, RobotModel};
pub use payload::{Payload, PayloadError, RigidBody};
pub use pose::{Pose, RpyPose};
pub use safety::{
    PlaneMode, PlaneSwitches, SafetyBounds, SafetyPlane, SafetyTool, SafetyViolation,
};
pub use urdf::ModelError;
pub use wrench::{Twist, Wrench};
