//! The fastest change from one speed and acceleration to another speed with acceleration zero.
//!
//! Three phases: jerk towards the goal, constant acceleration, jerk back to zero acceleration (Biagiotti and
//! Melchiorri, *Trajectory Planning for Automatic Machines and Robots*, 2008, 3.4). Speeds may have any sign.

use super::{Phase, ScalarState};

/// A ramp and what it covers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ramp {
    /// The three phases; any of them may last no time.
    pub phases: [Phase; 3],
    /// Distance covered.
    pub distance: f64,
    /// Time taken, s.
    pub duration: f64,
}

/// The speed at which the acceleration reaches zero if it is reduced as fast as the jerk allows.
pub fn natural_speed(speed: f64, acceleration: f64, jerk: f64) -> f64 {
    speed + acceleration * acceleration.abs() / (2.0 * jerk)
}

/// The ramp from `speed` and `acceleration` to `goal` and zero acceleration, with |acceleration| and |jerk| limited.
///
/// An initial acceleration above the limit is first reduced to it.
pub fn ramp(
    speed: f64,
    acceleration: f64,
    goal: f64,
    acceleration_limit: f64,
    jerk_limit: f64,
) -> Ramp {
    let sign = if goal >= natural_speed(speed, acceleration, jerk_limit) {
        1.0
    } else {
        -1.0
    };
    // Mirrored so that the acceleration in between points upwards: a0 -> peak -> 0 gains `gain`.
    let (a0, gain) = (sign * acceleration, sign * (goal - speed));
    let peak = (jerk_limit * gain + a0 * a0 / 2.0)
        .max(0.0)
        .sqrt()
        .min(acceleration_limit);
    let first = Phase {
        duration: (peak - a0).abs() / jerk_limit,
        jerk: sign * jerk_limit.copysign(peak - a0),
    };
    let last = Phase {
        duration: peak / jerk_limit,
        jerk: -sign * jerk_limit,
    };
    let gained = first.duration * (peak + a0) / 2.0 + last.duration * peak / 2.0;
    let middle = Phase {
        // Below the limit the two outer phases gain everything, whatever the rounding leaves.
        duration: if peak >= acceleration_limit {
            ((gain - gained) / peak).max(0.0)
        } else {
            0.0
        },
        jerk: 0.0,
    };
    let phases = [first, middle, last];
    let mut end = ScalarState {
        position: 0.0,
        speed,
        acceleration,
    };
    for phase in &phases {
        end = end.after(phase.duration, phase.jerk);
    }
    Ramp {
        phases,
        distance: end.position,
        duration: first.duration + middle.duration + last.duration,
    }
}
