//! Following a moving reference with a third-order tracking law.
//!
//! The error obeys (d/dt + ω)³ e = 0 as long as nothing saturates: gains from placing three poles of the sampled triple
//! integrator at exp(-ω h) (Ackermann's formula; Åström and Wittenmark, *Computer-Controlled Systems*, 1997, 4.4). The
//! law is nested so that speed and acceleration saturate in between and a far reference is approached with a braking
//! that the limits allow: the wanted speed follows the square root of the distance left.

use super::axis::{AxisLimits, braking_speed};
use crate::scalar::ScalarState;
use kinematics::bounds::within;
use kinematics::elementary::{cube, exp};

/// Share of the acceleration that approaches are planned with; the rest is for the law's own lag.
const BRAKING_SHARE: f64 = 0.5;

/// The tracking law for one step length and bandwidth.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TrackingLaw {
    step: f64,
    position_gain: f64,
    speed_gain: f64,
    acceleration_gain: f64,
}

impl TrackingLaw {
    /// A law of `bandwidth` rad/s for steps of `step` seconds.
    pub fn new(bandwidth: f64, step: f64) -> Self {
        let h = step;
        let m = 1.0 - exp(-bandwidth * h);
        Self {
            step,
            position_gain: cube(m) / cube(h),
            speed_gain: (3.0 * m * m - cube(m)) / (h * h),
            acceleration_gain: (cube(m) / 3.0 - 1.5 * m * m + 3.0 * m) / h,
        }
    }

    /// The acceleration at the end of the step for a reference that now has `position` and `speed`.
    pub fn acceleration(
        &self,
        now: &ScalarState,
        position: f64,
        speed: f64,
        axis: &AxisLimits,
    ) -> f64 {
        let error = position - now.position;
        let slope = self.position_gain / self.speed_gain;
        let approach = braking_speed(error, slope, BRAKING_SHARE * axis.acceleration);
        self.acceleration_towards_speed(now, speed + approach, 0.0, axis)
    }

    /// The acceleration at the end of the step for a reference with an acceleration of its own.
    pub fn acceleration_with(
        &self,
        now: &ScalarState,
        reference: &ScalarState,
        axis: &AxisLimits,
    ) -> f64 {
        let error = reference.position - now.position;
        let slope = self.position_gain / self.speed_gain;
        let approach = braking_speed(error, slope, BRAKING_SHARE * axis.acceleration);
        self.acceleration_towards_speed(
            now,
            reference.speed + approach,
            reference.acceleration,
            axis,
        )
    }

    /// The acceleration on the way to a speed that itself changes by `acceleration`.
    fn acceleration_towards_speed(
        &self,
        now: &ScalarState,
        speed: f64,
        acceleration: f64,
        axis: &AxisLimits,
    ) -> f64 {
        let wanted_speed = within(speed, -axis.speed, axis.speed);
        let wanted_acceleration =
            acceleration + (self.speed_gain / self.acceleration_gain) * (wanted_speed - now.speed);
        let jerk = self.acceleration_gain
            * (within(wanted_acceleration, -axis.acceleration, axis.acceleration)
                - now.acceleration);
        let next = now.acceleration + self.step * within(jerk, -axis.jerk, axis.jerk);
        within(next, -axis.acceleration, axis.acceleration)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXIS: AxisLimits = AxisLimits {
        min: -10.0,
        max: 10.0,
        speed: 3.0,
        acceleration: 10.0,
        jerk: 500.0,
    };

    fn follow(
        bandwidth: f64,
        step: f64,
        seconds: f64,
        reference: impl Fn(f64) -> (f64, f64),
    ) -> (ScalarState, f64) {
        let law = TrackingLaw::new(bandwidth, step);
        let mut state = ScalarState::at_rest(0.0);
        let mut highest = f64::MIN;
        for k in 0..(seconds / step) as u32 {
            let (position, speed) = reference(f64::from(k) * step);
            let wanted = law.acceleration(&state, position, speed, &AXIS);
            state = AXIS.nearest_safe(&state, wanted, step);
            highest = highest.max(state.position);
        }
        (state, highest)
    }

    #[test]
    fn a_reference_at_constant_speed_is_followed_without_an_error() {
        for (bandwidth, step) in [(20.0, 0.004), (90.0, 0.008), (40.0, 0.001)] {
            let (state, _) = follow(bandwidth, step, 3.0, |t| (0.5 * t, 0.5));
            let end = 0.5 * ((3.0 / step).floor() * step);
            assert!(
                (state.position - end).abs() < 1e-9,
                "{bandwidth} {step} {state:?}"
            );
            assert!((state.speed - 0.5).abs() < 1e-9);
        }
    }

    #[test]
    fn a_far_goal_is_reached_without_overshoot() {
        for bandwidth in [20.0, 35.0, 63.0, 90.0] {
            let (state, highest) = follow(bandwidth, 0.004, 4.0, |_| (4.0, 0.0));
            assert!((state.position - 4.0).abs() < 1e-6, "{state:?}");
            assert!(highest < 4.0 + 1e-3, "{bandwidth}: {highest}");
        }
    }
}
