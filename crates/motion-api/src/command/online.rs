//! Commands of the online modes: streams of points and speeds, leading by hand, and coming to rest from them.

use kinematics::{JointPositions, JointSpeeds};

use crate::FreedriveFrame;

/// An online mode, or the way out of one. Each setpoint is computed from the one before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum OnlineCommand {
    /// One point of a stream of joint positions (manual 3.1.6). The call ends after `duration`.
    ServoJ {
        /// Where to, rad.
        target: JointPositions,
        /// How long this point leads the arm, s.
        duration: f64,
        /// Length of the mean filter, s.
        lookahead: f64,
        /// Tracking gain, 100 to 2000.
        gain: f64,
    },
    /// Joint positions that were handed over with it, at even times, from where the arm is, at rest or not; the list
    /// under way is left for it. The call ends where the list does: see
    /// [`CommandSender::send_trajectory`](crate::CommandSender::send_trajectory).
    FollowPoints {
        /// The number of points.
        count: u32,
        /// Time from point to point, s.
        interval: f64,
    },
    /// Joint speeds, held until the next motion command (manual 3.1.25).
    SpeedJ {
        /// rad/s.
        speeds: JointSpeeds,
        /// Acceleration of the joint that changes most, rad/s².
        acceleration: f64,
        /// When the call ends, s; `None` when the speeds are reached.
        duration: Option<f64>,
    },
    /// A TCP velocity, held until the next motion command (manual 3.1.27).
    SpeedL {
        /// Linear m/s, then angular rad/s, base frame.
        speed: [f64; 6],
        /// m/s².
        acceleration: f64,
        /// rad/s².
        rotation_acceleration: f64,
        /// When the call ends, s; `None` when the velocity is reached.
        duration: Option<f64>,
    },
    /// All joints to rest (manual 3.1.26); a planned motion brakes on its path.
    StopJ {
        /// rad/s².
        acceleration: f64,
    },
    /// The TCP to rest on its line (manual 3.1.28); a planned motion brakes on its path.
    StopL {
        /// m/s².
        acceleration: f64,
    },
    /// The arm follows the hand (manual 3.1.41). Ends with [`EndFreedrive`](Self::EndFreedrive) or a stop.
    Freedrive {
        /// The axes x, y, z, rx, ry, rz in which the arm may move.
        free_axes: [bool; 6],
        /// The frame whose axes are meant.
        frame: FreedriveFrame,
    },
    /// Back to position control (manual 3.1.42); nothing to do when freedrive is off.
    EndFreedrive,
}

impl OnlineCommand {
    /// The name used in the recording and in messages: the script function's where there is one.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::ServoJ { .. } => "servoj",
            Self::FollowPoints { .. } => "follow_points",
            Self::SpeedJ { .. } => "speedj",
            Self::SpeedL { .. } => "speedl",
            Self::StopJ { .. } => "stopj",
            Self::StopL { .. } => "stopl",
            Self::Freedrive { .. } => "freedrive_mode",
            Self::EndFreedrive => "end_freedrive_mode",
        }
    }

    /// True for what begins to move the arm.
    pub const fn starts_motion(&self) -> bool {
        matches!(
            self,
            Self::ServoJ { .. }
                | Self::FollowPoints { .. }
                | Self::SpeedJ { .. }
                | Self::SpeedL { .. }
                | Self::Freedrive { .. }
        )
    }

    /// True for what brings the arm to rest: a [reserved slot](crate::CommandKind::uses_reserved_slot) is kept for it.
    pub const fn ends_motion(&self) -> bool {
        matches!(
            self,
            Self::StopJ { .. } | Self::StopL { .. } | Self::EndFreedrive
        )
    }
}
