//! How much nearer two things can come by a motion: what proves a stretch of a path clear that nobody looked at.

use kinematics::{JointPositions, Pose};

use super::pair::PairPartner;
use super::{CollisionScene, Pair};

impl CollisionScene {
    /// How much the distance of a pair changes at most while each joint goes straight from one position to the other,
    /// m. Obstacles stand still meanwhile.
    pub fn motion_bound(&self, pair: Pair, from: &JointPositions, to: &JointPositions) -> f64 {
        let levers = &self.bodies[pair.body].levers;
        let joints = self.joints_between(pair);
        joints
            .map(|joint| levers[joint] * (to[joint] - from[joint]).abs())
            .sum()
    }

    /// The way, m, that the points of the obstacle of a pair have moved at most since the scene was made; 0 for a pair
    /// within the arm.
    pub fn obstacle_travel(&self, pair: Pair) -> f64 {
        match pair.partner {
            PairPartner::Obstacle(id) => self.obstacles[id.0].travel,
            PairPartner::Body(_) => 0.0,
        }
    }
}

/// How far points up to `reach` from the origin of a frame move at most when the frame goes from one pose to another,
/// m.
pub(super) fn of_poses(from: &Pose, to: &Pose, reach: f64) -> f64 {
    let shift = (to.translation - from.translation).norm();
    // The norm of the difference of the two matrices is at least how far any unit vector moves.
    let turn = (to.rotation.matrix() - from.rotation.matrix()).norm();
    match turn > 0.0 {
        true => shift + turn * reach,
        false => shift,
    }
}
