//! What there is in a cell, as plain data in SI units.
//!
//! Each struct is one table of the cell file with its keys. Lengths are metres, angles radians, times seconds, poses
//! are in the base frame of the arm unless the field says otherwise. Nothing here is checked:
//! [`World::new`](crate::World::new) does that.

use std::sync::Arc;

use kinematics::{Capsule, Pose};
use mesh::MeshBody;
use motion_api::IoPoint;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// The whole cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WorldDescription {
    /// Time, gravity, floor, seed.
    pub settings: Settings,
    /// What the arm and its tool look like.
    pub arm: ArmShape,
    /// Things that stand still, or that an actuator moves.
    pub obstacles: Vec<ObstacleDescription>,
    /// Free rigid bodies.
    pub parts: Vec<PartDescription>,
    /// Coefficients of friction that differ from the smaller one of the two.
    pub frictions: Vec<PairFriction>,
    /// Grippers on the flange.
    pub grippers: Vec<Gripper>,
    /// Surfaces that carry.
    pub conveyors: Vec<ConveyorDescription>,
    /// Where parts are made.
    pub sources: Vec<SourceDescription>,
    /// Where parts are removed.
    pub sinks: Vec<Sink>,
    /// What sees.
    pub detectors: Vec<Detector>,
    /// What moves obstacles.
    pub actuators: Vec<Actuator>,
    /// What goes wrong.
    pub faults: Vec<FaultDescription>,
}

/// What holds for the whole world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Length of one step of the world, s: that of the control cycle.
    pub period: f64,
    /// Longest step of the contact solver, s.
    pub substep: f64,
    /// Free-fall acceleration in the base frame, m/s².
    pub gravity: [f64; 3],
    /// Height of the floor, m; without it parts fall until 10 m below the base and are removed there.
    pub floor: Option<f64>,
    /// Seed of all scatter.
    pub seed: u64,
    /// Whether parts that lie still are left out of the engine's step until something touches them.
    pub sleeping: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            period: 0.004,
            substep: 0.001,
            gravity: [0.0, 0.0, -9.81],
            floor: None,
            seed: 0,
            sleeping: true,
        }
    }
}

/// The outside of the arm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ArmShape {
    /// Capsules of the links: the joint (0 to 5) whose frame they are given in, and the capsule.
    pub links: Vec<(usize, Capsule)>,
    /// The tool in the flange frame.
    pub tool: Option<(BodyShape, Pose)>,
}

/// A solid; all but a mesh are centred on their own frame.
#[derive(Clone, Debug, PartialEq)]
pub enum BodyShape {
    /// Edges along the axes.
    Box {
        /// Length of each edge, m.
        size: [f64; 3],
    },
    /// A cylinder about the z axis.
    Cylinder {
        /// Radius, m.
        radius: f64,
        /// Length, m.
        length: f64,
    },
    /// A ball.
    Sphere {
        /// Radius, m.
        radius: f64,
    },
    /// The half space below z = 0; for obstacles only.
    Plane,
    /// A mesh, in the frame of its file. Its convex pieces touch.
    Mesh(Arc<MeshBody>),
}

impl BodyShape {
    /// The shape in a point mirror at the origin of its frame. Only a mesh differs from its image.
    #[must_use]
    pub fn point_mirrored(&self) -> Self {
        match self {
            Self::Mesh(body) => Self::Mesh(Arc::new(body.point_mirrored())),
            symmetric => symmetric.clone(),
        }
    }
}

/// An obstacle. Its pose is the retracted place where an actuator moves it.
#[derive(Clone, Debug, PartialEq)]
pub struct ObstacleDescription {
    /// Name.
    pub name: String,
    /// Shape.
    pub shape: BodyShape,
    /// Where it is.
    pub pose: Pose,
    /// Coefficient of friction towards parts.
    pub friction: f64,
}

/// Mass of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mass {
    /// kg.
    Total(f64),
    /// kg/m³.
    Density(f64),
}

/// A free rigid body, or a grid of them. A part that a source names is its template and not there by itself.
#[derive(Clone, Debug, PartialEq)]
pub struct PartDescription {
    /// Name; copies are called `name[0]`, `name[1]`, …
    pub name: String,
    /// Shape.
    pub shape: BodyShape,
    /// Mass.
    pub mass: Mass,
    /// Where it, or its first copy, is at the start.
    pub pose: Pose,
    /// Coefficient of friction.
    pub friction: f64,
    /// Coefficient of restitution.
    pub restitution: f64,
    /// Copies along the axes of the pose, x runs fastest; `None` for a single part of this name.
    pub copies: Option<Copies>,
}

/// A grid of parts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Copies {
    /// How many along each axis of the pose.
    pub count: [usize; 3],
    /// Distance along each axis, m.
    pub pitch: [f64; 3],
}

/// Friction of two things by name. Names of parts stand for all their copies.
#[derive(Clone, Debug, PartialEq)]
pub struct PairFriction {
    /// Name of the first thing; `floor` is a name.
    pub a: String,
    /// Name of the second thing.
    pub b: String,
    /// Coefficient.
    pub value: f64,
}

/// A gripper on the flange.
#[derive(Clone, Debug, PartialEq)]
pub struct Gripper {
    /// Name.
    pub name: String,
    /// What it is.
    pub kind: GripperKind,
}

/// The kinds of grippers.
#[derive(Clone, Debug, PartialEq)]
pub enum GripperKind {
    /// Suction cups.
    Vacuum(Vacuum),
    /// Two parallel fingers.
    Fingers(Fingers),
}

/// Suction cups on one line of vacuum.
#[derive(Clone, Debug, PartialEq)]
pub struct Vacuum {
    /// Middles of the rims, flange frame.
    pub cups: Vec<[f64; 3]>,
    /// Where the cups look, flange frame; of any length.
    pub direction: [f64; 3],
    /// Radius of a rim, m.
    pub radius: f64,
    /// What the pump reaches, Pa below ambient.
    pub pressure: f64,
    /// Largest gap between a rim and a face that it seals, m.
    pub reach: f64,
    /// Time constant of the pressure's rise, s.
    pub build_up: f64,
    /// Time constant of its fall, s.
    pub decay: f64,
    /// Output that opens the valve.
    pub on: IoPoint,
    /// Output that blows parts off.
    pub blow_off: Option<IoPoint>,
    /// Input that says whether a sealed cup has `threshold` of `pressure`.
    pub switch: Option<IoPoint>,
    /// Share of `pressure` at which the switch closes, 0 to 1.
    pub threshold: f64,
    /// Analog input; its largest value is `pressure`.
    pub gauge: Option<IoPoint>,
}

/// Two fingers that move towards each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Fingers {
    /// The opening between the fingers when open, m; closed is 0.
    pub stroke: f64,
    /// Direction that the finger on the positive side opens to, flange frame; of any length.
    pub axis: [f64; 3],
    /// Shape of a finger, and its pose in the flange frame when closed. The other finger is its mirror image.
    pub finger: (BodyShape, Pose),
    /// Force of each finger, N.
    pub force: f64,
    /// Speed of each finger, m/s.
    pub speed: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// What tells the fingers where to go.
    pub control: FingerControl,
    /// Input: the fingers are open.
    pub opened: Option<IoPoint>,
    /// Input: the fingers are closed with nothing between them.
    pub closed: Option<IoPoint>,
    /// Input: the fingers press something.
    pub gripping: Option<IoPoint>,
}

impl Fingers {
    /// Unit vector to the positive side, flange frame.
    pub fn opening_direction(&self) -> Vector3<f64> {
        Vector3::from(self.axis).normalize()
    }

    /// The shapes of the two fingers, that of the positive side first.
    pub fn shapes(&self) -> [BodyShape; 2] {
        [self.finger.0.clone(), self.finger.0.point_mirrored()]
    }

    /// Where the two fingers are at an opening (m), flange frame.
    pub fn poses(&self, width: f64) -> [Pose; 2] {
        let axis = self.opening_direction();
        let closed = self.finger.1;
        let mirror = Matrix3::identity() - axis * axis.transpose() * 2.0;
        // A mirrored frame is left-handed. Turned through its origin it is right-handed again, as the mirrored shape
        // is.
        let rotation = Rotation3::from_matrix_unchecked(-(mirror * closed.rotation.matrix()));
        let other = Pose::new(rotation, mirror * closed.translation);
        let apart = axis * (width / 2.0);
        [
            Pose::new(closed.rotation, closed.translation + apart),
            Pose::new(other.rotation, other.translation - apart),
        ]
    }
}

/// What tells fingers where to go.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FingerControl {
    /// Output points. With one of them alone, false is the other way.
    Points {
        /// Closes.
        close: Option<IoPoint>,
        /// Opens.
        open: Option<IoPoint>,
    },
    /// Orders of a bus: [`World::order_fingers`](crate::World::order_fingers).
    Orders,
}

/// A surface that carries parts by friction.
#[derive(Clone, Debug, PartialEq)]
pub struct ConveyorDescription {
    /// Name.
    pub name: String,
    /// What moves.
    pub surface: Surface,
    /// Speed, m/s or rad/s about z of the turntable.
    pub speed: f64,
    /// Coefficient of friction.
    pub friction: f64,
    /// Output: moves while true. Without it the surface moves from `start_at` on.
    pub run: Option<IoPoint>,
    /// Analog output: the speed in proportion to `speed`.
    pub speed_from: Option<IoPoint>,
    /// Rate of change of the speed, m/s² or rad/s².
    pub acceleration: f64,
    /// When it begins to move, s.
    pub start_at: f64,
    /// Encoder 0 or 1 that turns with it.
    pub encoder: Option<u8>,
}

/// The moving surface of a conveyor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Surface {
    /// Top (+z) of a box.
    Belt {
        /// Pose of the middle of the box.
        pose: Pose,
        /// Edges, m.
        size: [f64; 3],
        /// Direction of travel in the base frame; of any length.
        direction: [f64; 3],
    },
    /// A disc that turns about z of its pose.
    Turntable {
        /// Middle of the top, z upwards.
        center: Pose,
        /// Radius, m.
        radius: f64,
    },
}

/// When something happens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Trigger {
    /// At this time, s; sources repeat it with this period.
    Time(f64),
    /// At the rising edge of an output or of an input that the world drives.
    Output(IoPoint),
    /// At the rising edge of an input that the world drives.
    Input(IoPoint),
}

/// Makes parts.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceDescription {
    /// Name.
    pub name: String,
    /// Name of the template.
    pub part: String,
    /// Where parts appear.
    pub pose: Pose,
    /// The period, or what makes one.
    pub when: Trigger,
    /// When the first may appear, s.
    pub start_at: f64,
    /// How many at most.
    pub limit: Option<u32>,
    /// Standard deviations of x, y, z (m) and of the rotations about the base axes X, Y, Z (rad).
    pub scatter: [f64; 6],
}

/// Removes parts.
#[derive(Clone, Debug, PartialEq)]
pub struct Sink {
    /// Name.
    pub name: String,
    /// Middle of its box.
    pub pose: Pose,
    /// Edges, m.
    pub size: [f64; 3],
}

/// Sees something and tells an input.
#[derive(Clone, Debug, PartialEq)]
pub struct Detector {
    /// Name.
    pub name: String,
    /// The input; analog for a distance.
    pub to: IoPoint,
    /// How long the signal takes, s.
    pub delay: f64,
    /// Whether false means that something is there. A distance is counted down from its largest value then.
    pub inverted: bool,
    /// What it is.
    pub kind: DetectorKind,
}

/// The kinds of detectors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DetectorKind {
    /// True while something cuts the line.
    Beam {
        /// First end of the line, m.
        from: [f64; 3],
        /// Second end of the line, m.
        until: [f64; 3],
    },
    /// True while the centre of a part is inside the box.
    Presence {
        /// Middle of the box.
        pose: Pose,
        /// Edges, m.
        size: [f64; 3],
    },
    /// Distance along z of the pose to the first thing.
    Distance {
        /// Where it looks from.
        pose: Pose,
        /// Distance of the largest value, m.
        range: f64,
    },
}

/// Moves obstacles between two ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Actuator {
    /// Name.
    pub name: String,
    /// What moves, and how far.
    pub travel: Travel,
    /// Names of obstacles that move with it.
    pub moves: Vec<String>,
    /// From end to end, s.
    pub time: f64,
    /// Largest force (N) or torque (Nm).
    pub force: f64,
    /// Output that extends it.
    pub extend: IoPoint,
    /// Output that retracts it (a valve with two coils, which keeps its place without a signal).
    pub retract: Option<IoPoint>,
    /// Input: it is at its far end.
    pub extended: Option<IoPoint>,
    /// Input: it is at its near end.
    pub retracted: Option<IoPoint>,
    /// Whether it starts at its far end.
    pub starts_extended: bool,
}

/// The way of an actuator.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Travel {
    /// Along a line.
    Linear {
        /// Direction of extending, base frame; of any length.
        axis: [f64; 3],
        /// From end to end, m.
        stroke: f64,
    },
    /// About an axis.
    Rotary {
        /// Direction of the axis, base frame; of any length.
        axis: [f64; 3],
        /// A point on it.
        point: [f64; 3],
        /// From end to end, rad, less than π.
        angle: f64,
    },
}

/// Something that goes wrong.
#[derive(Clone, Debug, PartialEq)]
pub struct FaultDescription {
    /// When.
    pub when: Trigger,
    /// What.
    pub what: FaultKind,
    /// How long, s; for ever without it.
    pub duration: Option<f64>,
}

/// What can go wrong.
#[derive(Clone, Debug, PartialEq)]
pub enum FaultKind {
    /// A part is not there.
    Missing(String),
    /// A part is turned about its vertical by 0.5 to 2.5 rad.
    Turned(String),
    /// A part falls out of its gripper.
    Drop(String),
    /// A gripper loses nine tenths of its pressure or force.
    Leak(String),
    /// An input keeps its value.
    Stuck(IoPoint),
    /// An input is false or 0.
    Open(IoPoint),
    /// An actuator or conveyor does not move.
    Blocked(String),
    /// An actuator or conveyor has half of its speed.
    Slow(String),
}
