//! The picture of the world for recording, page, tests and conditions.

use kinematics::{Pose, Twist};
use std::sync::Arc;

/// Everything that can be seen after a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorldState {
    /// Steps so far.
    pub cycle: u64,
    /// Parts that are there, in the order of making.
    pub parts: Vec<PartState>,
    /// Grippers in the order of the description, as are all that follow.
    pub grippers: Vec<GripperState>,
    /// Conveyors.
    pub conveyors: Vec<ConveyorState>,
    /// Parts that each source made, and how often its place was taken.
    pub sources: Vec<SourceState>,
    /// Parts that each sink removed.
    pub sinks: Vec<u64>,
    /// What each detector says now, before its delay.
    pub detectors: Vec<DetectorState>,
    /// Actuators.
    pub actuators: Vec<ActuatorState>,
    /// Poses of all obstacles.
    pub obstacles: Vec<Pose>,
    /// Parts that were removed far below, by name.
    pub lost_below: Vec<Arc<str>>,
}

/// A part.
#[derive(Clone, Debug, PartialEq)]
pub struct PartState {
    /// Name.
    pub name: Arc<str>,
    /// Number of its template in the description.
    pub template: usize,
    /// Where it is.
    pub pose: Pose,
    /// Velocity of its centre and its rotation, base frame.
    pub velocity: Twist,
    /// Number of the gripper that holds it.
    pub held_by: Option<usize>,
    /// Whether it touches the floor.
    pub touches_floor: bool,
}

/// A gripper.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GripperState {
    /// Name of the part that it holds.
    pub holding: Option<Arc<str>>,
    /// Largest pressure of the sealed cups, Pa below ambient; 0 for fingers.
    pub pressure: f64,
    /// By cup: it seals.
    pub sealed: Vec<bool>,
    /// Opening between the fingers, m; 0 for cups.
    pub width: f64,
    /// What fingers do.
    pub fingers: FingerState,
    /// Cycle in which it last lost a part without being told to; 0 for never.
    pub lost_in_cycle: u64,
}

/// What fingers do.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FingerState {
    /// The fingers move.
    #[default]
    Moving,
    /// The fingers are where they were told to go, with nothing between them.
    Arrived,
    /// The fingers press something while closing.
    GrippingInside,
    /// The fingers are stopped by something while opening.
    BlockedOpening,
    /// The fingers have lost the part they had.
    Lost,
}

/// A conveyor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ConveyorState {
    /// Speed, m/s or rad/s.
    pub speed: f64,
    /// Way since the start, m or rad.
    pub travel: f64,
}

/// A source.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SourceState {
    /// Parts made.
    pub made: u32,
    /// Parts not made because their place was taken.
    pub skipped: u32,
}

/// A detector.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DetectorState {
    /// Whether something is there.
    pub sees: bool,
    /// Distance of what is there, m; of a beam from its first end.
    pub distance: f64,
}

/// An actuator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ActuatorState {
    /// Way from the retracted end, m or rad.
    pub position: f64,
    /// Whether it is at one of its ends.
    pub is_at_end: bool,
}
