//! Braking: what a protective stop does.
//!
//! Each joint comes to rest as fast as its own acceleration and jerk limits allow; the path is left. Where that would
//! lead behind a safety plane a planned motion halts on its path instead.

use kinematics::{JointAccelerations, JointPositions, JointSpeeds};

use crate::config::MotionLimits;
use crate::constants::SETTLING_TIME;
use crate::path::PathContext;
use crate::queue::{MotionQueue, PathMotion};
use crate::scalar::ramp::natural_speed;
use crate::scalar::{Profile, ProgressGoal, ScalarState};
use crate::setpoint::Setpoint;

/// Share of a joint's jerk that braking uses: within the cycle before, a path may have moved a little otherwise than
/// its setpoints say.
const JERK_SHARE: f64 = 0.95;

/// A stop under way.
#[derive(Clone, Copy, Debug)]
#[allow(
    clippy::large_enum_variant,
    reason = "lives in place for the life of the controller; the cycle must not allocate"
)]
pub(crate) enum StopMotion {
    /// The joints brake one by one.
    JointWise(JointStopMotion),
    /// A motion halts on its path; how long its target has stood, s.
    OnPath(PathMotion, f64),
}

impl StopMotion {
    /// Halts `motion` on its path.
    pub(crate) fn on_path(mut motion: PathMotion) -> Self {
        motion.is_stopping = true;
        Self::OnPath(motion, 0.0)
    }

    /// The setpoint `step` seconds later; `None` when the path is lost.
    pub(crate) fn next_setpoint(
        &mut self,
        step: f64,
        queue: &MotionQueue,
        ground: &PathContext,
        near: &JointPositions,
    ) -> Option<Setpoint> {
        match self {
            Self::JointWise(brake) => Some(brake.next(step)),
            Self::OnPath(motion, stood) => {
                if queue.is_standing(motion) {
                    *stood += step;
                }
                queue.next_setpoint(motion, step, ProgressGoal::StopHard, ground, near)
            }
        }
    }

    /// True when the target stands and the arm has come to rest as well, or has had its time to.
    pub(crate) fn has_settled(&self, queue: &MotionQueue, arm_rests: bool) -> bool {
        match self {
            Self::JointWise(brake) => brake.has_settled(arm_rests),
            Self::OnPath(motion, stood) => {
                queue.is_standing(motion) && (arm_rests || *stood >= SETTLING_TIME)
            }
        }
    }
}

/// Six joints on their way to rest.
#[derive(Clone, Copy, Debug)]
pub struct JointStopMotion {
    profiles: [Profile; 6],
    time: f64,
}

impl JointStopMotion {
    /// From the motion at `from`.
    pub fn new(from: &Setpoint, limits: &MotionLimits) -> Self {
        Self::to_speed_share(from, 0.0, limits)
    }

    /// A brake at rest where the joints of `at` are.
    pub fn standing(at: &Setpoint) -> Self {
        let profiles =
            at.q.0
                .map(|position| Profile::to_speed(ScalarState::at_rest(position), 0.0, 1.0, 1.0));
        Self {
            profiles,
            time: 0.0,
        }
    }

    /// From the motion at `from` to this share of its speeds.
    pub fn to_speed_share(from: &Setpoint, share: f64, limits: &MotionLimits) -> Self {
        let profiles = core::array::from_fn(|joint| {
            let start = ScalarState {
                position: from.q[joint],
                speed: from.qd[joint],
                acceleration: from.qdd[joint],
            };
            // What it accelerates at already may be more than it is to brake with.
            let most = limits.acceleration[joint].max(start.acceleration.abs());
            let goal = share * from.qd[joint];
            let jerk = limits.jerk[joint];
            let braking = Profile::to_speed(start, goal, most, JERK_SHARE * jerk);
            // Close to the end of its range, or speeding up to its largest speed, a joint needs all of it.
            let range = limits.position_min[joint]..=limits.position_max[joint];
            let fastest = natural_speed(start.speed, start.acceleration, JERK_SHARE * jerk);
            let is_enough = range.contains(&braking.at(braking.duration()).position)
                && fastest.abs() <= limits.speed[joint];
            if is_enough {
                braking
            } else {
                Profile::to_speed(start, goal, most, jerk)
            }
        });
        Self {
            profiles,
            time: 0.0,
        }
    }

    /// Every joint stays within its range.
    pub(crate) fn stays_within(&self, limits: &MotionLimits) -> bool {
        let end = self.position_at(1.0);
        (0..6).all(|joint| {
            let range = limits.position_min[joint]..=limits.position_max[joint];
            range.contains(&end[joint])
        })
    }

    /// Every joint has the speed it is to have.
    pub fn is_over(&self) -> bool {
        self.time >= self.longest()
    }

    /// The setpoint `step` seconds later.
    pub fn next(&mut self, step: f64) -> Setpoint {
        self.time += step;
        let states = self.profiles.map(|profile| profile.at(self.time));
        Setpoint {
            q: JointPositions(states.map(|s| s.position)),
            qd: JointSpeeds(states.map(|s| s.speed)),
            qdd: JointAccelerations(states.map(|s| s.acceleration)),
        }
    }

    /// Where the joints are after this share of the time until the last of them rests, rad.
    pub fn position_at(&self, share: f64) -> JointPositions {
        let time = share * self.longest();
        JointPositions(self.profiles.map(|profile| profile.at(time).position))
    }

    /// Time until every joint rests, s.
    pub fn longest(&self) -> f64 {
        let durations = self.profiles.iter().map(Profile::duration);
        durations.fold(0.0, f64::max)
    }

    /// True when every joint's target stands and the arm has come to rest as well, or has had its time to.
    pub fn has_settled(&self, arm_rests: bool) -> bool {
        self.time >= self.longest() + if arm_rests { 0.0 } else { SETTLING_TIME }
    }
}
