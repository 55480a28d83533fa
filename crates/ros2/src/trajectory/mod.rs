//! Trajectories of ROS: whether one can be run, and the joint positions it asks for at every moment.
//!
//! Positions alone are joined by lines, positions with speeds by cubics, with accelerations by quintics, and the first
//! piece begins where the arm is, all as in ros2_control. Knows no clock and no robot: the arm's limits and state are
//! arguments.

mod check;
mod interpolation;
mod tolerances;

pub use check::{CheckedTrajectory, TrajectoryError, TrajectoryLimits, Waypoint, check};
pub use interpolation::{ArmStart, PositionSeries, sample};
pub use tolerances::{Tolerances, Violation};

/// Codes of control_msgs/FollowJointTrajectory.
pub mod code {
    /// The goal was reached.
    pub const SUCCESSFUL: i32 = 0;
    /// The trajectory cannot be run.
    pub const INVALID_GOAL: i32 = -1;
    /// The joints are not the arm's.
    pub const INVALID_JOINTS: i32 = -2;
    /// The trajectory was to begin earlier.
    pub const OLD_HEADER_TIMESTAMP: i32 = -3;
    /// The arm was too far from its way.
    pub const PATH_TOLERANCE_VIOLATED: i32 = -4;
    /// The arm did not come near enough to the goal in time.
    pub const GOAL_TOLERANCE_VIOLATED: i32 = -5;
}
