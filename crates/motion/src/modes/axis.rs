//! One joint under online control: which next states leave a way to rest inside all limits.
//!
//! A state is *safe* when braking from it as fast as acceleration and jerk allow exceeds neither the joint's speed nor
//! its range. [`AxisLimits::clamp_to_safe`] lets only safe states pass, so by induction every online mode can always
//! stop in time: when nothing else is safe, the braking that made the state before safe still is.

use crate::scalar::ScalarState;
use crate::scalar::ramp::{natural_speed, ramp};
use kinematics::bounds::within;

/// What a joint may do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisLimits {
    /// Smallest position.
    pub min: f64,
    /// Largest position.
    pub max: f64,
    /// Largest speed either way.
    pub speed: f64,
    /// Largest acceleration either way.
    pub acceleration: f64,
    /// Largest jerk either way.
    pub jerk: f64,
}

/// Speed over distance on the last approach to the end of a range, 1/s.
const END_SLOPE: f64 = 8.0;
/// Share of the acceleration with which a joint brakes before the last approach to the end of its range.
const END_SHARE: f64 = 0.5;

/// The speed of approach over a distance: proportional near the goal, then what `braking` can still take away.
pub fn braking_speed(distance: f64, slope: f64, braking: f64) -> f64 {
    let linear = braking / (slope * slope);
    let way = distance.abs();
    if way <= linear {
        slope * distance
    } else {
        (2.0 * braking * (way - linear / 2.0))
            .sqrt()
            .copysign(distance)
    }
}

/// Room for rounding, relative to a limit.
const SLACK: f64 = 1e-9;

impl AxisLimits {
    /// Whether braking from `state` keeps every limit.
    pub fn can_brake_within_limits(&self, state: &ScalarState) -> bool {
        let (v, a) = (state.speed, state.acceleration);
        if !(state.position.is_finite() && v.is_finite() && a.is_finite()) {
            return false;
        }
        let fastest = v.abs().max(natural_speed(v, a, self.jerk).abs());
        if a.abs() > self.acceleration * (1.0 + SLACK) || fastest > self.speed * (1.0 + SLACK) {
            return false;
        }
        let (low, high) = self.braking_extent(state);
        low >= self.min - SLACK && high <= self.max + SLACK
    }

    /// Whether braking from `state` stays inside the range.
    pub fn brakes_inside(&self, state: &ScalarState) -> bool {
        let (low, high) = self.braking_extent(state);
        low >= self.min && high <= self.max
    }

    /// How far the joint goes while it brakes from a speed.
    pub fn braking_distance(&self, speed: f64) -> f64 {
        ramp(speed, 0.0, 0.0, self.acceleration, self.jerk).distance
    }

    /// Smallest and largest position on the way to rest.
    fn braking_extent(&self, state: &ScalarState) -> (f64, f64) {
        let braking = ramp(
            state.speed,
            state.acceleration,
            0.0,
            self.acceleration,
            self.jerk,
        );
        let mut now = *state;
        let (mut low, mut high) = (now.position, now.position);
        for phase in &braking.phases {
            // The position turns where the speed is zero.
            for time in zeros_of_speed(&now, phase.jerk) {
                if time > 0.0 && time < phase.duration {
                    let turned = now.after(time, phase.jerk).position;
                    (low, high) = (low.min(turned), high.max(turned));
                }
            }
            now = now.after(phase.duration, phase.jerk);
            (low, high) = (low.min(now.position), high.max(now.position));
        }
        (low, high)
    }

    /// `wanted` if it is safe, otherwise the safe state nearest to it that constant jerk leads to in `step` seconds,
    /// otherwise the first step of braking. `now` must be safe.
    pub fn clamp_to_safe(
        &self,
        now: &ScalarState,
        wanted: &ScalarState,
        step: f64,
    ) -> (ScalarState, bool) {
        if self.can_brake_within_limits(wanted) && self.is_slow_between(now, wanted, step) {
            return (*wanted, false);
        }
        (self.nearest_safe(now, wanted.acceleration, step), true)
    }

    /// The safe state whose acceleration is nearest to `acceleration` after `step` seconds of constant jerk.
    pub fn nearest_safe(&self, now: &ScalarState, acceleration: f64, step: f64) -> ScalarState {
        let jerk = within(
            (acceleration - now.acceleration) / step,
            -self.jerk,
            self.jerk,
        );
        let after = |jerk: f64| now.after(step, jerk);
        let is_good = |jerk: f64| {
            let next = after(jerk);
            self.can_brake_within_limits(&next) && self.is_slow_between(now, &next, step)
        };
        if is_good(jerk) {
            return after(jerk);
        }
        let braked = self.brake_step(now, step);
        let towards = within(
            (braked.acceleration - now.acceleration) / step,
            -self.jerk,
            self.jerk,
        );
        if !is_good(towards) {
            return braked;
        }
        // Between a jerk that is not safe and one that is: bisection.
        let (mut bad, mut good) = (jerk, towards);
        for _ in 0..30 {
            let middle = 0.5 * (bad + good);
            if is_good(middle) {
                good = middle;
            } else {
                bad = middle;
            }
        }
        after(good)
    }

    /// The lowest and the highest speed after `step` seconds from which a way to rest is left, when the mean
    /// acceleration of a step changes no faster than the jerk allows; `now` has the mean of the step before. Where
    /// nothing is safe both are the speed of braking.
    pub fn reachable_speeds(&self, now: &ScalarState, step: f64) -> (f64, f64) {
        let most = self.jerk * step;
        let able = |a: f64| within(a, -self.acceleration, self.acceleration);
        let (low, high) = (able(now.acceleration - most), able(now.acceleration + most));
        let after = |acceleration: f64| {
            let even = ScalarState {
                acceleration,
                ..*now
            };
            even.after(step, 0.0)
        };
        let is_good = |acceleration: f64| self.can_brake_within_limits(&after(acceleration));
        let braking = within(
            (self.brake_step(now, step).speed - now.speed) / step,
            low,
            high,
        );
        // The mean acceleration of a step may change by twice as much as braking within the step changes it.
        let kept = [braking, low, high].into_iter().find(|a| is_good(*a));
        let Some(kept) = kept else {
            let coming = natural_speed(now.speed, now.acceleration, self.jerk);
            let speed = after(if coming > 0.0 { low } else { high }).speed;
            return (speed, speed);
        };
        let reach = |wanted: f64| {
            if is_good(wanted) {
                return after(wanted).speed;
            }
            let (mut bad, mut good) = (wanted, kept);
            for _ in 0..20 {
                let middle = 0.5 * (bad + good);
                if is_good(middle) {
                    good = middle;
                } else {
                    bad = middle;
                }
            }
            after(good).speed
        };
        let (low, high) = (reach(low), reach(high));
        (low.min(high), high.max(low))
    }

    /// Where the acceleration changes its sign within the step the speed has its peak in between.
    fn is_slow_between(&self, now: &ScalarState, next: &ScalarState, step: f64) -> bool {
        let (a0, a1) = (now.acceleration, next.acceleration);
        if a0 * a1 >= 0.0 {
            return true;
        }
        let peak = now.speed + a0 * a0 * step / (2.0 * (a0 - a1));
        peak.abs() <= self.speed * (1.0 + SLACK)
    }

    /// A speed no faster than what leaves a gentle way to rest before the ends of the range.
    pub fn slowed_before_ends(&self, position: f64, speed: f64) -> f64 {
        let braking = END_SHARE * self.acceleration;
        let fastest = |way: f64| braking_speed(way.max(0.0), END_SLOPE, braking);
        within(
            speed,
            -fastest(position - self.min),
            fastest(self.max - position),
        )
    }

    /// The state after `step` seconds of braking.
    pub fn brake_step(&self, now: &ScalarState, step: f64) -> ScalarState {
        self.step_towards_speed(now, 0.0, step)
    }

    /// The state after `step` seconds on the fastest way to a speed.
    pub fn step_towards_speed(&self, now: &ScalarState, goal: f64, step: f64) -> ScalarState {
        let way = ramp(
            now.speed,
            now.acceleration,
            goal,
            self.acceleration,
            self.jerk,
        );
        let mut state = *now;
        let mut left = step;
        for phase in &way.phases {
            let time = phase.duration.min(left);
            state = state.after(time, phase.jerk);
            left -= time;
        }
        if left > 0.0 {
            // The ramp is over: from here on exactly the goal.
            state.speed = goal;
            state.acceleration = 0.0;
            state.position += goal * left;
        }
        state
    }
}

/// Times at which the speed is zero under constant jerk.
fn zeros_of_speed(state: &ScalarState, jerk: f64) -> [f64; 2] {
    let (v, a) = (state.speed, state.acceleration);
    if jerk == 0.0 {
        return [-v / a, f64::NAN];
    }
    let root = (a * a - 2.0 * jerk * v).sqrt();
    [(-a - root) / jerk, (-a + root) / jerk]
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use proptest::test_runner::RngSeed;

    const AXIS: AxisLimits = AxisLimits {
        min: -1.0,
        max: 1.5,
        speed: 3.0,
        acceleration: 10.0,
        jerk: 500.0,
    };

    #[test]
    fn a_state_that_can_only_stop_outside_is_not_safe() {
        let at = |position, speed| ScalarState {
            position,
            speed,
            acceleration: 0.0,
        };
        assert!(AXIS.can_brake_within_limits(&at(1.5, 0.0)));
        assert!(AXIS.can_brake_within_limits(&at(1.5, -1.0)));
        assert!(!AXIS.can_brake_within_limits(&at(1.5, 1e-3)));
        assert!(!AXIS.can_brake_within_limits(&at(1.3, 2.5)));
        assert!(!AXIS.can_brake_within_limits(&at(0.0, 3.1)));
        assert!(!AXIS.can_brake_within_limits(&at(f64::NAN, 0.0)));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 64, rng_seed: RngSeed::Fixed(1), failure_persistence: None,
            ..ProptestConfig::default() })]
        #[test]
        fn whatever_is_wanted_the_joint_stays_inside_all_limits(
            wishes in proptest::collection::vec((-30.0..30.0_f64, 1..60_usize), 1..40),
            step in prop::sample::select(vec![0.001, 0.002, 0.004, 0.008]),
        ) {
            // Braking from the very edge of what is safe is safe up to rounding.
            let wider = AxisLimits {
                min: AXIS.min - 1e-7,
                max: AXIS.max + 1e-7,
                speed: AXIS.speed + 1e-7,
                acceleration: AXIS.acceleration + 1e-7,
                ..AXIS
            };
            let mut state = ScalarState::at_rest(0.0);
            for (acceleration, cycles) in wishes {
                for _ in 0..cycles {
                    let next = AXIS.nearest_safe(&state, acceleration, step);
                    prop_assert!(wider.can_brake_within_limits(&next), "{state:?} {next:?}");
                    prop_assert!((next.acceleration - state.acceleration).abs() <= AXIS.jerk * step * (1.0 + 1e-9));
                    state = next;
                }
            }
        }

        #[test]
        fn whatever_speed_within_reach_is_taken_the_joint_stays_inside_all_limits(
            wishes in proptest::collection::vec((-6.0..6.0_f64, 1..60_usize), 1..40),
            step in prop::sample::select(vec![0.001, 0.002, 0.004, 0.008]),
        ) {
            let mut state = ScalarState::at_rest(0.0);
            for (speed, cycles) in wishes {
                for _ in 0..cycles {
                    let (low, high) = AXIS.reachable_speeds(&state, step);
                    prop_assert!(low <= high);
                    let speed = speed.clamp(low, high);
                    let acceleration = (speed - state.speed) / step;
                    prop_assert!((acceleration - state.acceleration).abs() <= AXIS.jerk * step * (1.0 + 1e-6) + 1e-9);
                    state = ScalarState { acceleration, ..state }.after(step, 0.0);
                    prop_assert!(state.speed.abs() <= AXIS.speed + 1e-6);
                    prop_assert!(acceleration.abs() <= AXIS.acceleration + 1e-6);
                    prop_assert!((AXIS.min - 1e-4..=AXIS.max + 1e-4).contains(&state.position), "{state:?}");
                }
            }
        }
    }
}
