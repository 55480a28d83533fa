//! What the motion thread reports: how commands ended, warnings, stops. Numbers only; sentences are made on the other
//! side of the border by the `Display` implementations here.

use core::fmt;

use crate::{CommandId, RobotMode, SafetyMode};
use kinematics::collision::link_name;
use thiserror::Error;

/// One thing that happened in the cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Event {
    /// A command has ended (every command ends exactly once).
    Ended {
        /// The command that has ended.
        id: CommandId,
        /// How the command ended.
        outcome: Outcome,
        /// The cycle in which the command ended.
        cycle: u64,
    },
    /// A motion with a blend radius is planned and the arm comes so near to its blend that the next motion should
    /// follow: its sender may send that now, although the command has not ended.
    ReadyForNext {
        /// The motion that is planned.
        id: CommandId,
        /// The cycle in which that is so.
        cycle: u64,
    },
    /// The arm has come so near to the blend of a motion, or to its end, that it slows down unless the next motion
    /// comes at once: what its sender does before that he does now, although the command may not have ended.
    Due {
        /// The motion whose blend or end is near.
        id: CommandId,
        /// The cycle in which that is so.
        cycle: u64,
    },
    /// Something a person should read, concerning a command.
    Warned {
        /// The command that the warning concerns.
        id: CommandId,
        /// What there is to say.
        warning: Warning,
        /// The cycle in which the warning was found.
        cycle: u64,
    },
    /// The arm entered a protective stop.
    Stopped {
        /// The reason for the protective stop.
        reason: StopReason,
        /// The cycle in which the reason was found.
        cycle: u64,
    },
}

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Outcome {
    /// Carried out as asked.
    Done,
    /// Not begun: the arm has not moved.
    Refused(Refusal),
    /// Begun and ended by a stop.
    Aborted,
    /// Begun and ended by a protective stop.
    ProtectiveStop(StopReason),
}

/// The reason for which a command was not begun. Joints count from 1 in messages, as printed on the arm's label.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Refusal {
    /// Another motion is running.
    #[error("another motion (command {}) is still running; only one motion at a time can move the arm", running.0)]
    Busy {
        /// The one that runs.
        running: CommandId,
    },
    /// The arm is not ready to move.
    #[error(
        "the robot mode is {robot_mode} and the safety mode {safety_mode}; \
         the arm moves only when they are RUNNING and NORMAL or REDUCED"
    )]
    NotReady {
        /// Robot mode found.
        robot_mode: RobotMode,
        /// Safety mode found.
        safety_mode: SafetyMode,
    },
    /// The request does not fit the robot's state, for example releasing brakes without power.
    #[error("the robot mode is {robot_mode}, this needs {needed}")]
    WrongMode {
        /// Robot mode found.
        robot_mode: RobotMode,
        /// Robot mode needed.
        needed: RobotMode,
    },
    /// A target lies outside a joint's range.
    #[error("joint {} would go to {} rad, allowed is {min:.4} to {max:.4} rad", joint + 1, ReadableNumber(*value))]
    JointLimit {
        /// Joint index from 0.
        joint: u8,
        /// Where the joint would go, rad.
        value: f64,
        /// Lower limit, rad.
        min: f64,
        /// Upper limit, rad.
        max: f64,
    },
    /// The line or arc cannot be followed.
    #[error("the path cannot be followed {:.1} % of the way along: {fault}", fraction * 100.0)]
    Path {
        /// Where along the path, 0 to 1.
        fraction: f64,
        /// What is wrong there.
        fault: PathFault,
    },
    /// The arm went in a direction as far as it can, and stands there.
    #[error("the arm can go no further in this direction than {way:.3} m: {fault}")]
    DirectionEnds {
        /// How far the TCP can go, m.
        way: f64,
        /// What is wrong behind that.
        fault: PathFault,
    },
    /// Three points that make no circular arc.
    #[error(
        "start, via point and target make no circular arc: two of them coincide, or they lie on a straight line"
    )]
    NoArc,
    /// A number of the command cannot be used.
    #[error("{name} is {value}; it must be {needed}")]
    BadValue {
        /// The name of the number.
        name: &'static str,
        /// The number as it was given.
        value: f64,
        /// What is allowed.
        needed: &'static str,
    },
    /// The arm has not come to rest yet.
    #[error("the arm still decelerates; this is possible once it stands")]
    StillMoving,
    /// The target lies behind a safety plane.
    #[error("the target lies {depth:.4} m behind safety plane {} of the cell", plane + 1)]
    SafetyPlane {
        /// Index of the plane in the cell, from 0.
        plane: u8,
        /// How far the target lies behind the plane, m.
        depth: f64,
    },
    /// A conveyor is tracked already.
    #[error("a conveyor is tracked already; end that first with stop_conveyor_tracking()")]
    ConveyorTracking,
    /// Force mode is on.
    #[error("force mode is on; end it first with end_force_mode()")]
    InForceMode,
    /// Path offsets are enabled.
    #[error("path offsets are enabled; end them first with path_offset_disable()")]
    PathOffset,
    /// The arm is led by hand.
    #[error(
        "the arm is led by hand; this is possible once the input with the action freedrive is low again"
    )]
    HandGuided,
    /// The TCP cannot be changed on a turntable that does not turn it: the arm would have to jump.
    #[error(
        "a turntable is tracked that does not turn the tool; end that first with stop_conveyor_tracking()"
    )]
    NonRotatingTurntable,
    /// The planner found nothing.
    #[error("no trajectory found for this target (planner error {code})")]
    Planner {
        /// Number of the planner's error.
        code: u32,
    },
}

/// A number as people read it: four decimals, and not three hundred digits before them.
struct ReadableNumber(f64);

impl fmt::Display for ReadableNumber {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.abs() < 1e6 {
            write!(f, "{:.4}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

/// The reason for which a path cannot be followed at some place.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum PathFault {
    /// No joint positions reach the pose.
    #[error("the pose is out of reach")]
    OutOfReach,
    /// A joint would leave its range.
    #[error("joint {} would go to {} rad, allowed is {min:.4} to {max:.4} rad", joint + 1, ReadableNumber(*value))]
    JointLimit {
        /// Joint index from 0.
        joint: u8,
        /// Where the joint would go, rad.
        value: f64,
        /// Lower limit, rad.
        min: f64,
        /// Upper limit, rad.
        max: f64,
    },
    /// The arm passes a singular position, where a joint would have to jump.
    #[error("the arm passes a singular position there, joint {} would have to turn {jump:.3} rad at once", joint + 1)]
    Singular {
        /// Joint index from 0.
        joint: u8,
        /// Size of the jump, rad.
        jump: f64,
    },
    /// Two links of the arm meet.
    #[error(
        "{} and {} would run into each other there, by {:.1} mm",
        link_name((*links)[0].into()),
        link_name((*links)[1].into()),
        overlap * 1e3
    )]
    SelfCollision {
        /// The two links, 0 for the base.
        links: [u8; 2],
        /// How far the capsules of the links overlap, m.
        overlap: f64,
    },
    /// A safety plane would be crossed.
    #[error("safety plane {} of the cell would be crossed there", plane + 1)]
    SafetyPlane {
        /// Index of the plane in the cell, from 0.
        plane: u8,
    },
}

/// The reason for which the arm went into a protective stop. The number of each reason is stable: it is the sub code on
/// port 30001.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum StopReason {
    /// The commanded state would leave a joint's range.
    #[error("joint {} was about to leave its range at {value:.4} rad (allowed {min:.4} to {max:.4} rad)", joint + 1)]
    JointPosition {
        /// Joint index from 0.
        joint: u8,
        /// Commanded, rad.
        value: f64,
        /// Lower limit, rad.
        min: f64,
        /// Upper limit, rad.
        max: f64,
    },
    /// The commanded state would exceed a joint's speed.
    #[error("joint {} was about to exceed its speed limit: {value:.4} rad/s, allowed {limit:.4} rad/s", joint + 1)]
    JointSpeed {
        /// Joint index from 0.
        joint: u8,
        /// Commanded, rad/s.
        value: f64,
        /// Limit, rad/s.
        limit: f64,
    },
    /// The arm does not follow: actual and target positions differ too much (a collision, an overload).
    #[error(
        "joint {} does not follow: actual and target differ by {error:.4} rad (allowed {limit:.4} rad); \
         a collision or an overload",
        joint + 1
    )]
    TrackingError {
        /// Joint index from 0.
        joint: u8,
        /// Difference, rad.
        error: f64,
        /// Limit, rad.
        limit: f64,
    },
    /// The commanded state would exceed the speed limit of the TCP.
    #[error("the TCP was about to exceed its speed limit: {value:.4} m/s, allowed {limit:.4} m/s")]
    TcpSpeed {
        /// Commanded, m/s.
        value: f64,
        /// Limit, m/s.
        limit: f64,
    },
    /// The commanded state would exceed the speed limit of the elbow.
    #[error(
        "the elbow was about to exceed its speed limit: {value:.4} m/s, allowed {limit:.4} m/s"
    )]
    ElbowSpeed {
        /// Commanded, m/s.
        value: f64,
        /// Limit, m/s.
        limit: f64,
    },
    /// Somebody pressed an emergency stop, or an input that means it asked for one.
    #[error("an emergency stop was asked for; release it, then power on and release the brakes")]
    EmergencyStop,
    /// A joint carries more than the motion explains.
    #[error(
        "collision at joint {}: {torque:.1} Nm from outside (allowed {limit:.1} Nm), \
         as a push of {force:.0} N at the TCP makes; the sensor at the tool may read another force",
        joint + 1
    )]
    Collision {
        /// Joint index from 0.
        joint: u8,
        /// Torque from outside, Nm.
        torque: f64,
        /// Threshold, Nm.
        limit: f64,
        /// The force at the TCP that explains the torques of all joints best, N.
        force: f64,
    },
    /// The tool presses harder than the cell allows.
    #[error("the force at the TCP is {force:.1} N (allowed {limit:.1} N)")]
    TcpForce {
        /// What the sensor reads, N.
        force: f64,
        /// Limit, N.
        limit: f64,
    },
    /// A conveyor carried the TCP out of reach, or to where the joints would have to change their speeds faster than
    /// they can.
    #[error("the conveyor carries the TCP to where the arm cannot follow")]
    ConveyorLost,
    /// The offset of the path is larger than the program allows.
    #[error(
        "the path offset is {translation:.4} m and {rotation:.4} rad; \
         path_offset_set_max_offset() allows {most_translation:.4} m and {most_rotation:.4} rad"
    )]
    PathOffset {
        /// The translation that was asked for, m.
        translation: f64,
        /// The rotation that was asked for, rad.
        rotation: f64,
        /// Limit, m.
        most_translation: f64,
        /// Limit, rad.
        most_rotation: f64,
    },
    /// The offset of the path led out of reach, or to where the joints would have to change their speeds faster than
    /// they can.
    #[error("the path offset leads the TCP to where the arm cannot follow")]
    PathOffsetLost,
    /// TCP or tool were about to cross a safety plane.
    #[error(
        "the tool was about to cross safety plane {} of the cell: it would come to rest {depth:.4} m behind it",
        plane + 1
    )]
    SafetyPlane {
        /// Index of the plane in the cell, from 0.
        plane: u8,
        /// How far behind the plane the tool would come to rest, m.
        depth: f64,
    },
    /// Two links of the arm were about to meet.
    #[error(
        "{} and {} were about to run into each other, by {:.1} mm where the arm would come to rest",
        link_name((*links)[0].into()),
        link_name((*links)[1].into()),
        overlap * 1e3
    )]
    SelfCollision {
        /// The two links, 0 for the base.
        links: [u8; 2],
        /// How far the capsules of the links would overlap, m.
        overlap: f64,
    },
    /// Somebody asked for it: a test, a simulation.
    #[error("a protective stop was asked for")]
    Requested,
    /// The controller met a condition it has no rule for; the arm stops. A bug of ours.
    #[error("internal fault {code} in the motion thread; please report it with the recording")]
    Internal {
        /// Number of the place.
        code: u32,
    },
}

impl StopReason {
    /// The stable number of the reason.
    pub const fn code(&self) -> u32 {
        match self {
            Self::JointPosition { .. } => 1,
            Self::JointSpeed { .. } => 2,
            Self::TrackingError { .. } => 3,
            Self::TcpSpeed { .. } => 4,
            Self::ElbowSpeed { .. } => 5,
            Self::EmergencyStop => 20,
            Self::Collision { .. } => 11,
            Self::SafetyPlane { .. } => 12,
            Self::ConveyorLost => 13,
            Self::TcpForce { .. } => 14,
            Self::PathOffset { .. } => 15,
            Self::PathOffsetLost => 16,
            Self::SelfCollision { .. } => 17,
            Self::Requested => 18,
            Self::Internal { .. } => 99,
        }
    }
}

/// What the way of a motion is counted in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WayUnit {
    /// Angle of the joint with the longest way.
    Radian,
    /// Way of the TCP.
    Metre,
}

impl fmt::Display for WayUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Radian => "rad",
            Self::Metre => "m",
        })
    }
}

/// What was changed about a motion, so that it could be done.
#[derive(Clone, Copy, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum Warning {
    /// The wanted duration is too short.
    #[error("a duration of {wanted:.3} s is too short, the motion takes {planned:.3} s")]
    DurationStretched {
        /// Asked for, s.
        wanted: f64,
        /// Planned, s.
        planned: f64,
    },
    /// The wanted speed is more than the arm can do here.
    #[error(
        "a speed of {wanted:.4} {unit}/s is more than the joints can do here, it is limited to {planned:.4} {unit}/s"
    )]
    SpeedLimited {
        /// Asked for, rad/s or m/s.
        wanted: f64,
        /// What the motion slows down to, rad/s or m/s.
        planned: f64,
        /// The unit of the way.
        unit: WayUnit,
    },
    /// An online mode cannot go on as asked.
    #[error(
        "the arm slows down: joint {} is near the end of its range or turns too fast for the wanted motion",
        joint + 1
    )]
    LimitedByJoint {
        /// Joint index from 0.
        joint: u8,
    },
    /// The blend radius is more than the legs have room for.
    #[error(
        "a blend radius of {wanted:.4} m is more than there is room for here, it is shortened to {planned:.4} m"
    )]
    RadiusShortened {
        /// Asked for, m.
        wanted: f64,
        /// Planned, m.
        planned: f64,
    },
    /// The motion could not go over into the next one without a stop.
    #[error(
        "the motion stopped at its end instead of blending: \
         the next one came too late or turns too sharply for the speed"
    )]
    NotBlended,
    /// The target is so far away that it only says where to go.
    #[error(
        "the target is {distance:.1} m away, no arm reaches that far: \
         it is taken as a direction, and the arm goes there until something stops it"
    )]
    Direction {
        /// Distance of the target from where the motion begins, m.
        distance: f64,
    },
    /// A blend radius at the end of a direction.
    #[error(
        "a direction has no end that could be blended: the blend radius of {radius:.4} m is not used"
    )]
    DirectionNotBlended {
        /// Asked for, m.
        radius: f64,
    },
    /// The wanted acceleration is more than the arm can do here.
    #[error(
        "an acceleration of {wanted:.4} {unit}/s² is more than the joints can do here, \
         it is limited to {planned:.4} {unit}/s²"
    )]
    AccelerationLimited {
        /// Asked for, rad/s² or m/s².
        wanted: f64,
        /// The most that the motion does, rad/s² or m/s².
        planned: f64,
        /// The unit of the way.
        unit: WayUnit,
    },
}
