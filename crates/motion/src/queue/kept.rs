//! The way ahead kept within other limits than it was planned with: those of reduced mode, the largest speeds on a
//! belt.
//!
//! Owns how far that is done, some cells a cycle; what it means for the speed is the track's.

use kinematics::{JointPositions, Pose};

use super::{MotionQueue, PathMotion};
use crate::config::MotionLimits;
use crate::path::PathContext;
use crate::scalar::ScalarState;
use crate::setpoint::elbow_speed;

/// How far the way ahead of a motion has been brought within the limits ([`MotionQueue::cap_speeds_ahead`]).
#[derive(Clone, Copy, Debug)]
pub(super) struct SpeedCapProgress {
    pub(super) place: f64,
    q: JointPositions,
    /// The largest speed of s there.
    pub(super) cap: f64,
    /// The largest share of its speed at which the motion keeps the joints' accelerations as well, so far.
    pace: f64,
}

/// Cells that are looked at in one cycle.
const INTERVALS_CAPPED_PER_CYCLE: usize = 64;
/// Share of the limits that places leave for what lies between them.
const KEPT_SHARE: f64 = 0.98;
/// Speeds that differ by less than this part are the same.
const SAME: f64 = 1e-6;
/// Nothing is kept.
pub(super) const NO_SPEED_CAPS: SpeedCapProgress = SpeedCapProgress {
    place: f64::NEG_INFINITY,
    q: JointPositions([0.0; 6]),
    cap: f64::INFINITY,
    pace: 1.0,
};

impl MotionQueue {
    /// Keeps the way ahead of the motion within `limits` of joints, TCP and elbow, whatever it was planned with; some
    /// cells a cycle, the nearest first. `near` is where the joints are.
    pub(crate) fn cap_speeds_ahead(
        &mut self,
        motion: &PathMotion,
        limits: &MotionLimits,
        tool: &Pose,
        ground: &PathContext,
        near: &JointPositions,
    ) {
        let oldest = motion.progress.oldest();
        if self.speed_caps.place < oldest {
            self.speed_caps = SpeedCapProgress {
                place: oldest,
                q: *near,
                cap: f64::INFINITY,
                ..self.speed_caps
            };
        }
        let before = self.speed_caps.place;
        for _ in 0..INTERVALS_CAPPED_PER_CYCLE {
            let Some((cell, until)) = self.track.cell_after(self.speed_caps.place) else {
                break;
            };
            let evenly = ScalarState {
                position: until,
                speed: 1.0,
                acceleration: 0.0,
            };
            let Some(there) = self.route.at(ground, &evenly, &self.speed_caps.q) else {
                break;
            };
            let frames = ground.model.forward(&there.q);
            let tcp = (frames.base_from_flange * *tool).translation;
            let tcp = frames.twist(&there.qd, tcp).linear.norm();
            let by_points =
                (limits.tcp_speed / tcp).min(limits.elbow_speed / elbow_speed(&frames, &there.qd));
            let cap = (0..6).fold(by_points, |least, joint| {
                least.min(limits.speed[joint] / there.qd[joint].abs())
            });
            let planned = self.track.limits(cell);
            let accelerations = [0, 1].map(|k| planned.asked[k].max(planned.braking[k]));
            let square = planned.speed * planned.speed;
            let pace = (0..6).fold(1.0_f64, |least, joint| {
                let (first, second) = (there.qd[joint].abs(), there.qdd[joint].abs());
                let fast = first * accelerations[1] + second * square;
                let most = fast.max(first * accelerations[0]);
                least.min((limits.acceleration[joint] / most).sqrt())
            });
            // What was planned within the limits stays as it is.
            let bears = cap.min(self.speed_caps.cap);
            if planned.speed > bears * (1.0 + SAME) {
                self.track.set_cap(cell, KEPT_SHARE * bears);
            }
            self.speed_caps = SpeedCapProgress {
                place: until,
                q: there.q,
                cap,
                pace: pace.min(self.speed_caps.pace),
            };
        }
        if self.speed_caps.place > before {
            self.track.recompute();
        }
    }

    /// The share of its speed at which a motion whose way is kept keeps the joints' accelerations too; `None` until its
    /// whole way has been looked at.
    pub(crate) fn kept_pace(&self) -> Option<f64> {
        (self.speed_caps.place >= self.track.end()).then_some(self.speed_caps.pace)
    }

    /// The way is as fast as it was planned.
    pub(crate) fn clear_speed_caps(&mut self) {
        self.speed_caps = NO_SPEED_CAPS;
        self.track.clear_caps();
        self.track.recompute();
    }
}
