//! Targets that are too far away to be meant: the arm goes along the line to them as far as it can.
//!
//! A pendant writes a target 1000 m away for "move in this direction until something happens" (our reading, and what
//! its programs are made for). Owns where that begins, how much of the line is looked at, and what ends it besides what
//! ends any line: places that targets must not have, before which the arm then brakes on its line.

use kinematics::rotation::{rotation_from_rotvec, rotvec_from_rotation};
use kinematics::safety::SafetyViolation;
use kinematics::{JointPositions, Pose};
use motion_api::{PathFault, Refusal, Warning, phrase};
use nalgebra::Vector3;

use super::{MotionRequest, PlanningContext, Warnings};

/// A target farther away than this is a direction, m.
const FARTHEST_TARGET: f64 = 10.0;
/// Numbers beyond this are no direction that anybody means, m; such a target is out of reach.
const FARTHEST_DIRECTION: f64 = 1e6;
/// The slowest that the arm goes at the end of a direction, m/s.
const SLOWEST_END: f64 = 0.02;
/// The slowest that the arm goes at the end of a direction, as share of the speed that is wanted.
const SLOWEST_SHARE: f64 = 0.1;
/// An arm behind a plane already may be as deep as it is, up to rounding, m.
const DEPTH_SLACK: f64 = 1e-9;
/// A way shorter than this is none, m.
const NO_WAY: f64 = 1e-4;

/// Where the arm is to go, however far.
#[derive(Clone, Copy, Debug)]
pub(super) struct Direction {
    /// Distance of the target, m.
    distance: f64,
    /// The blend radius that was asked for, m.
    radius: f64,
    /// How deep the arm is behind a safety plane at the beginning, m.
    depth: f64,
}

impl Direction {
    /// The direction that a line from `start` to `target` is, with the end of what the arm can reach of it; `None`
    /// where the target is a place.
    ///
    /// # Errors
    /// A time for something without an end.
    pub(super) fn of(
        start: &Pose,
        target: &Pose,
        q: &JointPositions,
        wish: &mut MotionRequest,
        arm: &PlanningContext,
    ) -> Result<Option<(Self, Pose)>, Refusal> {
        let way = target.translation - start.translation;
        let distance = way.norm();
        if distance <= FARTHEST_TARGET || distance > FARTHEST_DIRECTION {
            return Ok(None);
        }
        if wish.duration > 0.0 {
            return Err(Refusal::BadValue {
                name: phrase!("t"),
                value: wish.duration,
                needed: phrase!(
                    "0 for a target more than 10 m away, which is a direction without an end",
                    "0，因为目标在 10 m 之外，是没有终点的方向"
                ),
            });
        }
        let along = way / distance;
        let share = length_in_reach(&start.translation, &along, q, arm) / distance;
        let turn = rotvec_from_rotation(&(target.rotation * start.rotation.inverse()));
        let end = Pose::new(
            rotation_from_rotvec(turn * share) * start.rotation,
            start.translation + way * share,
        );
        let direction = Self {
            distance,
            radius: wish.radius,
            depth: crossed(q, arm).map_or(0.0, |(_, depth)| depth),
        };
        wish.radius = 0.0;
        Ok(Some((direction, end)))
    }

    /// The joint range or safety plane because of which the arm must not be at `q`; `None` when it may.
    pub(super) fn forbids(&self, q: &JointPositions, arm: &PlanningContext) -> Option<PathFault> {
        let limits = arm.limits;
        let outside = (0_u8..6).zip(0_usize..).find_map(|(number, joint)| {
            let (value, min, max) = (
                q[joint],
                limits.position_min[joint],
                limits.position_max[joint],
            );
            let is_outside = !(min..=max).contains(&value);
            is_outside.then_some(PathFault::JointLimit {
                joint: number,
                value,
                min,
                max,
            })
        });
        outside.or_else(|| {
            let (plane, depth) = crossed(q, arm)?;
            (depth > self.depth + DEPTH_SLACK).then_some(PathFault::SafetyPlane { plane })
        })
    }

    /// The way ends where it bears less speed than this to its end, m/s: next to a singular position the arm would
    /// crawl to a place that nobody asked for.
    pub(super) fn slowest(&self, wish: &MotionRequest) -> f64 {
        SLOWEST_END.min(SLOWEST_SHARE * wish.speed)
    }

    /// How the command ends where the arm can go no further than `way`, m, because of `refusal`.
    ///
    /// # Errors
    /// `refusal`, where it can go nowhere.
    pub(super) fn end(&self, way: f64, refusal: Refusal) -> Result<Refusal, Refusal> {
        match refusal {
            Refusal::Path { fault, .. } if way > NO_WAY => {
                Ok(Refusal::DirectionEnds { way, fault })
            }
            Refusal::Path { fault, .. } => Err(Refusal::DirectionEnds { way: 0.0, fault }),
            other => Err(other),
        }
    }

    /// Adds the warnings that a direction gives rise to.
    pub(super) fn warn(&self, warnings: &mut Warnings) {
        let distance = self.distance;
        warnings.add(Warning::Direction { distance });
        if self.radius > 0.0 {
            let radius = self.radius;
            warnings.add(Warning::DirectionNotBlended { radius });
        }
    }
}

/// The plane that the arm at `q` is behind, and how deep, m.
fn crossed(q: &JointPositions, arm: &PlanningContext) -> Option<(u8, f64)> {
    let (bounds, switches) = arm.planes.as_ref()?;
    let frames = arm.model.forward(q);
    match bounds.plane_violation(&frames, arm.flange_from_tcp, switches)? {
        SafetyViolation::Plane { plane, depth_m, .. } => Some((plane as u8, depth_m)),
        _ => None,
    }
}

/// How far a line leads from `start` until no posture of the arm reaches it, m.
fn length_in_reach(
    start: &Vector3<f64>,
    along: &Vector3<f64>,
    q: &JointPositions,
    arm: &PlanningContext,
) -> f64 {
    let frames = arm.model.forward(q);
    let shoulder = frames.base_from_joint[0].translation;
    let tcp = (frames.base_from_flange * *arm.flange_from_tcp).translation;
    // Neighbouring joints are as far from one another as they are in any posture.
    let ends = [frames.base_from_flange.translation, tcp];
    let origins = frames.base_from_joint.iter().map(|joint| joint.translation);
    let (_, reach) = origins
        .chain(ends)
        .fold((shoulder, 0.0), |(before, sum), origin| {
            (origin, sum + (origin - before).norm())
        });
    let from = start - shoulder;
    let middle = from.dot(along);
    let under = middle * middle + reach * reach - from.norm_squared();
    (under.max(0.0).sqrt() - middle).max(NO_WAY)
}
