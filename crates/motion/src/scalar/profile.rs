//! A motion over a given distance as a sequence of phases of constant jerk, and its exact evaluation.

use super::ramp::{Ramp, natural_speed, ramp};
use super::{Phase, ScalarLimits, ScalarState};

/// Most phases of a profile: a ramp to a lower speed, a ramp to the cruising speed, cruising, a ramp to the end.
const MAX_PHASES: usize = 10;

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
    /// Standing at `position` for `duration` seconds.
    pub fn standing(position: f64, duration: f64) -> Self {
        let mut profile = Self::empty(ScalarState::at_rest(position));
        profile.push(Phase {
            duration,
            jerk: 0.0,
        });
        profile
    }

    /// The fastest motion from `start` to the position `to`, passed at the speed `exit` with no acceleration, within the
    /// limits. The end state is met exactly.
    ///
    /// `None` when there is no such motion without first slowing down: the start is too fast for the way or for the
    /// limits, `exit` cannot be reached on so short a way, or the
    /// speed would have to change its sign.
    pub fn to_position(
        start: ScalarState,
        to: f64,
        exit: f64,
        limits: &ScalarLimits,
    ) -> Option<Self> {
        let distance = to - start.position;
        let (v0, a0) = (start.speed, start.acceleration);
        let up = |peak| ramp(v0, a0, peak, limits.acceleration, limits.jerk);
        let down = |peak| ramp(peak, 0.0, exit, limits.acceleration, limits.jerk);
        let covered = |peak| up(peak).distance + down(peak).distance;

        let natural = natural_speed(v0, a0, limits.jerk);
        let lowest_peak = natural.max(exit);
        // A negative natural speed would mean to go back a little.
        let in_limits = natural >= -1e-12
            && lowest_peak <= limits.speed * (1.0 + 1e-12)
            && a0.abs() <= limits.acceleration * (1.0 + 1e-9);
        // The distance of stretches is a difference of positions: allow for its rounding.
        let slack = 1e-12 * (1.0 + distance.abs());
        if !in_limits || covered(lowest_peak) > distance + slack {
            return None;
        }
        let highest_peak = limits.speed.max(lowest_peak);
        let peak = if covered(highest_peak) <= distance {
            highest_peak
        } else {
            // Above the lowest peak the distance grows with the peak: bisection.
            let (mut low, mut high) = (lowest_peak, highest_peak);
            for _ in 0..64 {
                let middle = 0.5 * (low + high);
                if covered(middle) <= distance {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            low
        };
        let mut profile = Self::empty(start);
        let (first, last) = (up(peak), down(peak));
        let rest = (distance - first.distance - last.distance).max(0.0);
        profile.push_ramp(&first);
        if peak > 0.0 {
            profile.push(Phase {
                duration: rest / peak,
                jerk: 0.0,
            });
        }
        profile.push_ramp(&last);
        profile.end = ScalarState {
            position: to,
            speed: exit,
            acceleration: 0.0,
        };
        Some(profile)
    }

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

    /// `self` followed by `next`, which must begin where `self` ends. `None` when that is too many phases.
    pub fn followed_by(mut self, next: &Self) -> Option<Self> {
        if self.count + next.count > MAX_PHASES {
            return None;
        }
        for phase in next.phases.iter().take(next.count) {
            self.push(*phase);
        }
        self.end = next.end;
        Some(self)
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

    /// The state at `time` seconds after the start; exactly the end state from the end on.
    pub fn at(&self, time: f64) -> ScalarState {
        if time >= self.duration {
            return self.end;
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

    /// How long it takes, s.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// The state at the end.
    pub fn end(&self) -> ScalarState {
        self.end
    }
}
