//! The obstacles that are near enough to a part of the arm to be looked at: most need that only now and then.
//!
//! A gap that was found once lasts until the part has gone as far. So each part counts the way of its farthest point,
//! each pair of part and obstacle knows the count at which it is due again, and each part the earliest of those.

use kinematics::{DOF, Frames, Pose};
use motion_api::MAX_GRIPPERS;

/// The links, the tool, and the parts in the grippers.
pub(super) const PARTS: usize = DOF + 1 + MAX_GRIPPERS;

/// The distances that parts of the arm still have to go before a pair of part and obstacle is looked at again.
#[derive(Clone, Debug)]
pub(super) struct BroadPhase {
    /// For each pair of part and obstacle: the way of the part, m, at which the pair is looked at again.
    next_check: Vec<f64>,
    obstacles: usize,
    earliest: [f64; PARTS],
    travelled: [f64; PARTS],
    previous_poses: [Pose; PARTS],
    flange_from_tcp: Pose,
    /// How far the farthest point of a part is from its origin, m.
    extents: [f64; PARTS],
    /// How many of the parts there are.
    parts: usize,
}

impl BroadPhase {
    /// `extents` are those of the links and of the tool, beside what its TCP adds.
    pub(super) fn new(obstacles: usize, extents: [f64; PARTS]) -> Self {
        Self {
            next_check: vec![f64::NEG_INFINITY; PARTS * obstacles],
            obstacles,
            earliest: [f64::NEG_INFINITY; PARTS],
            travelled: [0.0; PARTS],
            previous_poses: [Pose::IDENTITY; PARTS],
            flange_from_tcp: Pose::IDENTITY,
            extents,
            parts: DOF + 1,
        }
    }

    /// Another body, with a point that is this far from the origin of the flange, m, is part number `part` now.
    pub(super) fn replace(&mut self, part: usize, extent: f64) {
        self.parts = self.parts.max(part + 1);
        self.extents[part] = extent;
        self.earliest[part] = f64::NEG_INFINITY;
        let pairs = part * self.obstacles..(part + 1) * self.obstacles;
        self.next_check[pairs].fill(f64::NEG_INFINITY);
    }

    /// The arm has moved on to `frames`.
    pub(super) fn update(&mut self, frames: &Frames, flange_from_tcp: &Pose) {
        if self.flange_from_tcp != *flange_from_tcp {
            self.flange_from_tcp = *flange_from_tcp;
            self.earliest[DOF] = f64::NEG_INFINITY;
            let tool = DOF * self.obstacles..;
            self.next_check[tool].fill(f64::NEG_INFINITY);
        }
        let tcp_away = flange_from_tcp.translation.norm();
        for part in 0..self.parts {
            let now = frames.base_from_joint.get(part);
            let now = now.unwrap_or(&frames.base_from_flange);
            let before = &self.previous_poses[part];
            let turned = (now.rotation.matrix() - before.rotation.matrix()).norm();
            let extent = match part {
                DOF => self.extents[part].max(tcp_away),
                _ => self.extents[part],
            };
            self.travelled[part] += (now.translation - before.translation).norm() + extent * turned;
            self.previous_poses[part] = *now;
        }
    }

    /// Calls `check_due_pairs` for every obstacle that is due for a part. It says how wide the gap is at least, m,
    /// within which nothing needs to be done.
    pub(super) fn check_due_pairs(&mut self, part: usize, mut look: impl FnMut(usize) -> f64) {
        let gone = self.travelled[part];
        if gone < self.earliest[part] {
            return;
        }
        let mut earliest = f64::INFINITY;
        let range = part * self.obstacles..(part + 1) * self.obstacles;
        for (number, due) in self.next_check[range].iter_mut().enumerate() {
            if gone >= *due {
                let gap = look(number);
                *due = if gap > 0.0 { gone + gap } else { gone };
            }
            earliest = earliest.min(*due);
        }
        self.earliest[part] = earliest;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinematics::{JointPositions, RobotModel};

    #[test]
    fn a_pair_is_due_before_the_gap_can_be_gone() {
        let model = RobotModel::built_in("cs66").unwrap();
        let mut near = BroadPhase::new(1, [0.2; PARTS]);
        let mut looks = 0;
        let (mut seen, mut way) = (Pose::IDENTITY.translation, 0.0);
        for k in 0..2000 {
            let mut q = JointPositions([0.0, -1.5, 1.5, -1.5, -1.5, 0.0]);
            q[0] = f64::from(k) * 1e-3;
            q[1] += f64::from(k) * 4e-4;
            let frames = model.forward(&q);
            near.update(&frames, &Pose::IDENTITY);
            // A point 0.2 m before the flange, in any direction.
            let point = frames
                .base_from_flange
                .transform_point([0.0, 0.2, 0.0].into());
            if k > 0 {
                way += (point - seen).norm();
            }
            seen = point;
            near.check_due_pairs(DOF, |_| {
                looks += 1;
                way = 0.0;
                0.05
            });
            assert!(way <= 0.05, "{way}");
        }
        assert!((10..400).contains(&looks), "{looks}");
    }
}
