//! Motion of one number, the path parameter s, under limits of speed, acceleration and jerk.
//!
//! - [`ramp`]: the fastest change from one speed to another (three phases of constant jerk).
//! - [`profile`]: such a change, sampled exactly.
//! - [`cell_limits`]: what a piece of a way bears.
//! - [`track`]: how fast one may be at each place of a way.
//! - `extreme`: the hardest changes of speed in a window, kept from step to step.
//! - [`travel`]: moving along a track cycle by cycle: speed fraction, pause, stop.
//!
//! Knows no joints and no poses. The unit of s is the caller's (rad of the leading joint, m along a line); time is in
//! seconds. Everything is closed form or bisection with a fixed number of steps: no allocation, bounded time.

pub mod cell_limits;
mod extreme;
pub mod profile;
pub mod ramp;
pub mod track;
pub mod travel;

pub use cell_limits::{IntervalLimits, Pace};
pub use profile::Profile;
pub use track::{VelocityLimitCurve, Zone};
pub use travel::{PathProgress, ProgressGoal, smoothing_window};

/// Limits of a scalar motion, all positive and finite; unit of s over powers of seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScalarLimits {
    /// Largest speed.
    pub speed: f64,
    /// Largest acceleration, either way.
    pub acceleration: f64,
    /// Largest jerk, either way.
    pub jerk: f64,
}

impl ScalarLimits {
    /// Limits under which every motion is the same in space and takes 1/`fraction` of the time.
    pub fn slowed(self, fraction: f64) -> Self {
        Self {
            speed: self.speed * fraction,
            acceleration: self.acceleration * fraction * fraction,
            jerk: self.jerk * fraction * fraction * fraction,
        }
    }

    /// True when all three are positive and finite.
    pub fn are_usable(&self) -> bool {
        [self.speed, self.acceleration, self.jerk]
            .iter()
            .all(|x| x.is_finite() && *x > 0.0)
    }
}

/// Position, speed and acceleration of a scalar motion at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ScalarState {
    /// s.
    pub position: f64,
    /// ds/dt.
    pub speed: f64,
    /// d²s/dt².
    pub acceleration: f64,
}

impl ScalarState {
    /// A state at rest at `position`.
    pub const fn at_rest(position: f64) -> Self {
        Self {
            position,
            speed: 0.0,
            acceleration: 0.0,
        }
    }

    /// The state after `time` at constant `jerk`.
    #[must_use]
    pub fn after(&self, time: f64, jerk: f64) -> Self {
        let (v, a) = (self.speed, self.acceleration);
        Self {
            position: self.position + time * (v + time * (a / 2.0 + time * jerk / 6.0)),
            speed: v + time * (a + time * jerk / 2.0),
            acceleration: a + time * jerk,
        }
    }
}

/// A stretch of time with constant jerk.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Phase {
    /// How long, s.
    pub duration: f64,
    /// d³s/dt³.
    pub jerk: f64,
}
