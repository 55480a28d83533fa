//! Commands of planned motions: their whole path is known before the arm begins.

use kinematics::{JointPositions, RpyPose};

/// A planned motion (manual 3.1.1 to 3.1.3 and 3.1.40). Motions exclude one another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MotionCommand {
    /// A straight line in joint space (manual 3.1.1). All joints start and end together.
    MoveJ {
        /// Where to, rad.
        target: JointPositions,
        /// Acceleration of the leading joint, rad/s².
        acceleration: f64,
        /// Speed of the leading joint, rad/s.
        speed: f64,
        /// Duration in seconds; 0 plans from speed and acceleration instead.
        duration: f64,
        /// Blend radius, m: the command ends when the TCP comes this near to the target, and the next motion may follow
        /// without a stop. 0 stops at the target.
        radius: f64,
    },
    /// A straight line of the TCP with rotation about one fixed axis (manual 3.1.3).
    MoveL {
        /// Where to: TCP pose in the base frame.
        target: RpyPose,
        /// TCP acceleration, m/s².
        acceleration: f64,
        /// TCP speed, m/s.
        speed: f64,
        /// Duration in seconds; 0 plans from speed and acceleration instead.
        duration: f64,
        /// Blend radius, m: the command ends when the TCP comes this near to the target, and the next motion may follow
        /// without a stop. 0 stops at the target.
        radius: f64,
    },
    /// A circular arc of the TCP (manual 3.1.2).
    MoveC {
        /// A pose whose position lies on the arc; its orientation is not used.
        via: RpyPose,
        /// Where to: TCP pose in the base frame.
        target: RpyPose,
        /// TCP acceleration, m/s².
        acceleration: f64,
        /// TCP speed, m/s.
        speed: f64,
        /// Blend radius, m, as of `MoveL`.
        radius: f64,
        /// The tool keeps its angle to the arc, and the target's orientation is not used; otherwise it turns to the
        /// target's about one axis.
        fixed: bool,
    },
    /// A line of the TCP as of `MoveL` whose blends are arcs that touch both lines and are driven at the speed of the
    /// lines (from controller output, not from the manual).
    MoveP {
        /// Where to: TCP pose in the base frame.
        target: RpyPose,
        /// TCP acceleration, m/s².
        acceleration: f64,
        /// TCP speed, m/s.
        speed: f64,
        /// Distance from the target at which the arc touches, m; 0 stops at the target.
        radius: f64,
    },
    /// Through the points that were handed over with it, at even times, from the first on, where the arm stands (manual
    /// 3.1.40): see [`CommandSender::send_points`](crate::CommandSender::send_points).
    MoveMl {
        /// The number of points.
        count: u32,
        /// Time from point to point, s.
        interval: f64,
    },
}

impl MotionCommand {
    /// The script function, which is also the name in recordings and messages.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::MoveJ { .. } => "movej",
            Self::MoveL { .. } => "movel",
            Self::MoveC { .. } => "movec",
            Self::MoveP { .. } => "movep",
            Self::MoveMl { .. } => "moveml",
        }
    }
}
