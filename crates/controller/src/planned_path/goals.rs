//! The joint positions at which a path may end, and those at which the line to the target may begin.

use core::f64::consts::TAU;

use kinematics::{JointPositions, Pose, RobotModel};
use messages::Text;
use path_planning::CollisionScene;

/// Places of the approach that are computed: so many a metre, and at least so many.
const PLACES_PER_METRE: f64 = 500.0;
const PLACES_MIN: f64 = 4.0;
/// A joint that turns farther between two places of the approach does not follow the line, rad.
const JUMP: f64 = 0.2;

/// Joint positions that reach the target, and where the path to them ends and the line begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Goal {
    /// The end of the line.
    pub(super) target: JointPositions,
    /// The beginning of the line; equal to `target` where there is no line.
    pub(super) before_line: JointPositions,
}

/// Every joint position that reaches a pose within the ranges of the joints, nearest to `near` first; joint 1 and the
/// wrist also with whole turns, since something may be in the way on one side.
pub(super) fn joint_positions_of(
    model: &RobotModel,
    pose: &Pose,
    flange_from_tcp: &Pose,
    near: &JointPositions,
) -> Vec<JointPositions> {
    let limits = model.limits();
    let mut all: Vec<JointPositions> = Vec::new();
    for q in &model.inverse_all(pose, flange_from_tcp) {
        let Some(q) = kinematics::ik::unwrap_towards(q, near, limits) else {
            continue;
        };
        for joint in [None, Some(0), Some(3), Some(4), Some(5)] {
            let turns: &[f64] = match joint {
                None => &[0.0],
                Some(_) => &[TAU, -TAU],
            };
            for turn in turns {
                let mut turned = q;
                if let Some(joint) = joint {
                    turned[joint] += turn;
                }
                if limits.contains(&turned) {
                    all.push(turned);
                }
            }
        }
    }
    all.sort_by(|a, b| {
        a.distance_squared(near)
            .total_cmp(&b.distance_squared(near))
    });
    all
}

/// Follows the line back from the target: the joint positions at its beginning, `None` where the arm cannot follow it.
pub(super) fn before_line(
    model: &RobotModel,
    flange_from_tcp: &Pose,
    target: &JointPositions,
    length: f64,
) -> Option<Vec<JointPositions>> {
    let end = model.tcp_pose(target, flange_from_tcp);
    let count = (length * PLACES_PER_METRE).max(PLACES_MIN).ceil();
    let mut places = vec![*target];
    let mut q = *target;
    for place in 1..=count as u32 {
        let back = -length * f64::from(place) / count;
        let pose = end * Pose::from_translation(0.0, 0.0, back);
        let next = model.inverse_continuous(&pose, flange_from_tcp, &q)?;
        let apart = JointPositions(core::array::from_fn(|joint| next[joint] - q[joint]));
        if apart.max_abs() > JUMP {
            return None;
        }
        q = next;
        places.push(q);
    }
    Some(places)
}

/// Whether nothing touches on the way along these places.
pub(super) fn touches_on_line(
    scene: &CollisionScene,
    places: &[JointPositions],
) -> Option<(Text, Text)> {
    let mut tracker = path_planning::ClearanceTracker::default();
    for q in places {
        if let Some(found) = tracker.advance(scene, q, 0.0) {
            return Some(scene.texts(found.nearest.pair));
        }
    }
    None
}
