//! The fastest change to a speed as a sequence of phases of constant jerk, and its exact evaluation.

use super::ramp::{Ramp, ramp};
use super::{Phase, ScalarState};

/// Phases of a profile: those of a ramp.
const MAX_PHASES: usize = 3;

/// Phases of constant jerk from a start state to an end state that is met exactly.
#[derive(Clone, Copy, Debug)]
pub struct Profile {
    start: ScalarState,
    phases: [Phase; MAX_PHASES],
    count: usize,
    end: ScalarState,
    duration: f64,
}

impl Profile {
    /// The fastest change to the speed `goal` with no acceleration; ends wherever that leads.
    pub fn to_speed(start: ScalarState, goal: f64, acceleration: f64, jerk: f64) -> Self {
        let ramp = ramp(start.speed, start.acceleration, goal, acceleration, jerk);
        let mut profile = Self::empty(start);
        profile.push_ramp(&ramp);
        profile.end = ScalarState {
            position: start.position + ramp.distance,
            speed: goal,
            acceleration: 0.0,
        };
        profile
    }

    fn empty(start: ScalarState) -> Self {
        Self {
            start,
            phases: [Phase::default(); MAX_PHASES],
            count: 0,
            end: start,
            duration: 0.0,
        }
    }

    fn push(&mut self, phase: Phase) {
        if let Some(slot) = self.phases.get_mut(self.count)
            && phase.duration > 0.0
        {
            *slot = phase;
            self.count += 1;
            self.duration += phase.duration;
        }
    }

    fn push_ramp(&mut self, ramp: &Ramp) {
        ramp.phases.iter().for_each(|phase| self.push(*phase));
    }

    /// The state at `time` seconds after the start; from the end on it goes on evenly with the speed of the end.
    pub fn at(&self, time: f64) -> ScalarState {
        if time >= self.duration {
            let way = self.end.speed * (time - self.duration);
            return ScalarState {
                position: self.end.position + way,
                ..self.end
            };
        }
        let mut state = self.start;
        let mut left = time.max(0.0);
        for phase in self.phases.iter().take(self.count) {
            if left <= phase.duration {
                return state.after(left, phase.jerk);
            }
            state = state.after(phase.duration, phase.jerk);
            left -= phase.duration;
        }
        self.end
    }

    /// Duration of the profile, s.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// The state at the end.
    pub fn end(&self) -> ScalarState {
        self.end
    }
}
