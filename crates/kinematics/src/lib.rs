//! Poses, robot models, kinematics and dynamics of the CS six-axis arms.
//!
//! Owns the mathematics of one arm: transforms, URDF models, forward and inverse kinematics, Jacobians, rigid-body
//! dynamics. Knows no script, no socket, no clock, and no file other than the URDF it is handed.
//!
//! Units are SI throughout: metres, radians, seconds, kilograms, newtons. Six-vectors are linear before angular.

pub mod joint;
pub mod pose;
pub mod wrench;

pub use joint::{DOF, JointAccelerations, JointJerks, JointPositions, JointSpeeds, JointTorques};
pub use pose::{Pose, RpyPose};
pub use wrench::{Twist, Wrench};
