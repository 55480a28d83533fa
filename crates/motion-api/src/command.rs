//! What scripts and ports ask of the motion thread.
//!
//! A command is checked for form (numbers finite, ranges of the manual) before it enters the ring; whether the arm can
//! do it is decided on the other side and comes back as an [`Outcome`](crate::Outcome).

use kinematics::{JointPositions, Payload, RpyPose};

/// Number of a command, in the order in which commands entered the ring, from 1. 0 means "none".
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CommandId(pub u64);

impl CommandId {
    /// No command.
    pub const NONE: Self = Self(0);
}

/// Number of a program, in the order in which programs were started, from 1. 0 means "no program" (a port).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ProgramId(pub u32);

/// Number of a script thread inside its task; the main thread is 0.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ThreadNumber(pub u32);

/// Which statement of which program a command came from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Origin {
    /// The program, 0 when a port and not a program asked.
    pub program: ProgramId,
    /// The script thread that called.
    pub thread: ThreadNumber,
    /// Line of the call, from 1; 0 when there is none.
    pub line: u32,
}

/// A numbered request with its origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Command {
    /// Number in the ring's order.
    pub id: CommandId,
    /// Where it came from.
    pub origin: Origin,
    /// What is asked.
    pub kind: CommandKind,
}

/// The requests.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CommandKind {
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
    /// Decelerates on the path and ends the running motion as aborted. A robot at rest stays at rest.
    Stop {
        /// Only if this command is the one running; [`CommandId::NONE`] stops whatever runs.
        only: CommandId,
    },
    /// Decelerates on the path and holds there until `Resume`.
    Pause,
    /// Goes on after `Pause`.
    Resume,
    /// TCP relative to the flange (manual 3.1.20).
    SetTcp(RpyPose),
    /// What hangs on the flange (manual 3.1.17).
    SetPayload(Payload),
    /// One standard digital output (manual 5.13).
    SetStandardDigitalOut {
        /// 0 to 15.
        index: u8,
        /// High or low.
        level: bool,
    },
    /// The speed slider, 0 to 1.
    SetSpeedFraction(f64),
    /// Arm power on: power off → idle.
    PowerOn,
    /// Arm power off; the arm decelerates first.
    PowerOff,
    /// Brakes released: idle → running.
    ReleaseBrakes,
    /// Leaves a protective stop.
    UnlockProtectiveStop,
    /// Clears a safety fault.
    RestartSafetyBoard,
}

impl CommandKind {
    /// The name used in the recording and in messages: the script function's where there is one.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::MoveJ { .. } => "movej",
            Self::MoveL { .. } => "movel",
            Self::MoveC { .. } => "movec",
            Self::Stop { .. } => "stop",
            Self::Pause => "pause",
            Self::Resume => "resume",
            Self::SetTcp(_) => "set_tcp",
            Self::SetPayload(_) => "set_payload",
            Self::SetStandardDigitalOut { .. } => "set_standard_digital_out",
            Self::SetSpeedFraction(_) => "set_speed_fraction",
            Self::PowerOn => "power_on",
            Self::PowerOff => "power_off",
            Self::ReleaseBrakes => "release_brakes",
            Self::UnlockProtectiveStop => "unlock_protective_stop",
            Self::RestartSafetyBoard => "restart_safety_board",
        }
    }

    /// True for commands that move the arm and so exclude one another.
    pub const fn is_motion(&self) -> bool {
        matches!(
            self,
            Self::MoveJ { .. } | Self::MoveL { .. } | Self::MoveC { .. }
        )
    }
}
