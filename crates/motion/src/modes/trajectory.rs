//! A list of joint positions at even times, followed in time from where the arm is, at rest or not.
//!
//! The time of the list passes as fast as the speed fraction says; it slows down and speeds up with an acceleration
//! that the joints can bear on their way, so that a pause, a stop and a new speed keep to the list. Where the arm is
//! not where the list begins, or another list was under way, what is between them is laid over the list and fades out
//! with its speed and acceleration: nothing jumps.
//!
//! What the list asks for is followed exactly as long as the joints can; where they cannot, they come back to it by the
//! law that streams of points are followed with.

use crate::path::PointValues;
use kinematics::JointPositions;
use kinematics::bounds::within;

use super::OnlineContext;
use super::follower::TrackingLaw;
use crate::constants::SERVO_SETTLED;
use crate::scalar::ScalarState;

/// Bandwidth of the law that the list is followed with, rad/s: that of a servoj with the highest gain.
const BANDWIDTH: f64 = 90.0;
/// Share of a joint's acceleration that slowing down and speeding up take.
const RATE_SHARE: f64 = 0.6;
/// Fastest change of the rate of time, 1/s, for joints that hardly move.
const RATE_ACCELERATION_MAX: f64 = 20.0;
/// The change of the rate takes so long to set in, s.
const RATE_RISE: f64 = 0.02;
/// The rate has come to its goal within this.
const RATE_SETTLED: f64 = 1e-9;
/// Shortest fading, s.
const FADING_MIN: f64 = 0.1;
/// Share of a joint's acceleration that fading takes.
const FADING_SHARE: f64 = 0.3;
/// Largest speed that counts as standing, rad/s.
const STANDING: f64 = 1e-6;

/// Where a list is at a time: positions, speeds and accelerations of the list's own time.
type ListState = [ScalarState; 6];

/// A list under way.
#[derive(Clone, Copy, Debug)]
pub struct TrajectoryMode {
    interval: f64,
    goal: JointPositions,
    /// Time in the list, s.
    time: f64,
    end: f64,
    /// Seconds of the list a second, and its change.
    rate: f64,
    rate_change: f64,
    /// What is laid over the list: polynomials of the fading's own time.
    fading: [[f64; 6]; 6],
    fading_time: f64,
    fading_end: f64,
    law: TrackingLaw,
}

impl TrajectoryMode {
    /// A list of samples `interval` seconds apart, from the state `now` on. `before` is the list under way, if one is.
    pub(crate) fn new(
        samples: &[PointValues],
        interval: f64,
        now: &[ScalarState; 6],
        arm: &OnlineContext,
        before: Option<&Self>,
    ) -> Self {
        let last = samples.last().copied().unwrap_or_default();
        let [a, b, c, d, e, f, _] = last;
        let mut mode = Self {
            interval,
            goal: JointPositions([a, b, c, d, e, f]),
            time: 0.0,
            end: samples.len().saturating_sub(1) as f64 * interval,
            rate: before.map_or(arm.fraction, |before| before.rate),
            rate_change: 0.0,
            fading: [[0.0; 6]; 6],
            fading_time: 0.0,
            fading_end: 0.0,
            law: TrackingLaw::new(BANDWIDTH, arm.step),
        };
        mode.fade_from(samples, now, arm);
        mode
    }

    /// Where the list leads to.
    pub fn goal(&self) -> &JointPositions {
        &self.goal
    }

    /// The joint positions at the beginning of a list.
    pub(crate) fn start(samples: &[PointValues]) -> JointPositions {
        let [a, b, c, d, e, f, _] = samples.first().copied().unwrap_or_default();
        JointPositions([a, b, c, d, e, f])
    }

    /// What lies between `now` and the list is laid over it from here on.
    pub(crate) fn fade_from(
        &mut self,
        samples: &[PointValues],
        now: &[ScalarState; 6],
        arm: &OnlineContext,
    ) {
        let list = self.wanted(samples);
        let is_standing = now.iter().all(|state| state.speed.abs() < STANDING);
        let mut duration = FADING_MIN;
        let mut begin = [[0.0; 3]; 6];
        for joint in 0..6 {
            let (now, list) = (&now[joint], &list[joint]);
            let position = now.position - list.position;
            // From rest the joints take up the speed of the list as fast as they can instead.
            let (speed, acceleration) = match is_standing {
                true => (0.0, 0.0),
                false => (now.speed - list.speed, now.acceleration - list.acceleration),
            };
            begin[joint] = [position, speed, acceleration];
            let able = FADING_SHARE * arm.axes[joint].acceleration.max(1e-3);
            // The largest accelerations of the polynomial from a distance and from a speed (6 and 4, rounded up).
            duration = duration
                .max((6.0 * position.abs() / able).sqrt())
                .max(4.0 * speed.abs() / able);
        }
        self.fading = core::array::from_fn(|joint| fading(begin[joint], duration));
        self.fading_time = 0.0;
        let is_needed = begin.iter().flatten().any(|x| *x != 0.0);
        self.fading_end = if is_needed { duration } else { 0.0 };
    }

    /// The list at its time, with what the rate makes of it, without what is laid over it.
    fn wanted(&self, samples: &[PointValues]) -> ListState {
        let at = list_state(samples, self.time / self.interval, self.interval);
        at.map(|state| ScalarState {
            position: state.position,
            speed: state.speed * self.rate,
            acceleration: state.acceleration * self.rate * self.rate
                + state.speed * self.rate_change,
        })
    }

    /// The reference: the list and what is laid over it.
    fn reference(&self, samples: &[PointValues]) -> ListState {
        let mut wanted = self.wanted(samples);
        if self.fading_time < self.fading_end {
            for (state, polynomial) in wanted.iter_mut().zip(&self.fading) {
                let over = value(polynomial, self.fading_time);
                state.position += over.position;
                state.speed += over.speed;
                state.acceleration += over.acceleration;
            }
        }
        wanted
    }

    /// Nothing moves the reference any more.
    fn is_standing(&self) -> bool {
        self.fading_time >= self.fading_end
            && (self.time >= self.end || self.rate == 0.0 && self.rate_change == 0.0)
    }

    /// The states one step later; time passes towards `fraction` seconds of the list a second.
    pub(crate) fn next(
        &mut self,
        now: &[ScalarState; 6],
        arm: &OnlineContext,
        fraction: f64,
    ) -> [ScalarState; 6] {
        let samples = arm.samples;
        let reference = self.reference(samples);
        let is_standing = self.is_standing();
        let next = core::array::from_fn(|joint| {
            let (now, wanted) = (&now[joint], &reference[joint]);
            let (able, axis) = (&arm.available_axes[joint], &arm.axes[joint]);
            if is_standing
                && (wanted.position - now.position).abs() < SERVO_SETTLED
                && now.speed.abs() * arm.step < SERVO_SETTLED
                && now.acceleration.abs() * arm.step * arm.step < SERVO_SETTLED
            {
                return ScalarState::at_rest(wanted.position);
            }
            let wanted = match is_standing {
                true => ScalarState::at_rest(wanted.position),
                false => *wanted,
            };
            let acceleration = self.law.acceleration_with(now, &wanted, able);
            axis.nearest_safe(now, acceleration, arm.step)
        });
        self.pass(samples, arm, fraction);
        next
    }

    /// Time passes by one step.
    fn pass(&mut self, samples: &[PointValues], arm: &OnlineContext, fraction: f64) {
        let step = arm.step;
        let before = self.rate;
        let missing = fraction - self.rate;
        if missing.abs() < RATE_SETTLED && self.rate_change.abs() < RATE_SETTLED / step {
            (self.rate, self.rate_change) = (fraction, 0.0);
        } else {
            let at = list_state(samples, self.time / self.interval, self.interval);
            let most = (0..6).fold(RATE_ACCELERATION_MAX, |most, joint| {
                let able = RATE_SHARE * arm.available_axes[joint].acceleration;
                most.min(able / at[joint].speed.abs().max(1e-6))
            });
            // Critically damped towards the goal, with bounded change and change of the change.
            let rise = most / RATE_RISE;
            let frequency = 1.0 / RATE_RISE;
            let wanted = within(missing * frequency * 0.25, -most, most);
            let change = within(wanted - self.rate_change, -rise * step, rise * step);
            self.rate_change += change;
            self.rate = within(self.rate + step * self.rate_change, 0.0, 1.0);
            if self.rate == 0.0 && fraction == 0.0 {
                self.rate_change = 0.0;
            }
        }
        self.time = (self.time + 0.5 * step * (before + self.rate)).min(self.end);
        self.fading_time = (self.fading_time + step).min(self.fading_end);
    }

    /// Whether the list has come to its end and the arm at `q` with it.
    pub fn has_arrived(&self, q: &JointPositions) -> bool {
        self.time >= self.end && self.fading_time >= self.fading_end && self.goal == *q
    }
}

/// The list at a place between its samples: cubics through them (Catmull and Rom, 1974), their differences as speeds.
fn list_state(samples: &[PointValues], place: f64, interval: f64) -> ListState {
    let last = samples.len().saturating_sub(1);
    let begin = (place.max(0.0) as usize).min(last.saturating_sub(1));
    let share = within(place - begin as f64, 0.0, 1.0);
    let at = |index: usize| samples.get(index.min(last)).copied().unwrap_or_default();
    let [p0, p1, p2, p3] = [
        at(begin.saturating_sub(1)),
        at(begin),
        at(begin + 1),
        at(begin + 2),
    ];
    core::array::from_fn(|joint| {
        let (a, b, c, d) = (p0[joint], p1[joint], p2[joint], p3[joint]);
        let (first, second) = (0.5 * (c - a), 0.5 * (d - b));
        // Hermite: position, speed and acceleration of the cubic from b to c.
        let t = share;
        let k2 = 3.0 * (c - b) - 2.0 * first - second;
        let k3 = 2.0 * (b - c) + first + second;
        // The second differences at both ends, joined by a line: the cubics' own jump at the samples.
        let curvature = (1.0 - t) * (c - 2.0 * b + a) + t * (d - 2.0 * c + b);
        ScalarState {
            // The last sample is met to the bit: there the arm comes to rest.
            position: if t == 1.0 {
                c
            } else {
                b + t * (first + t * (k2 + t * k3))
            },
            speed: (first + t * (2.0 * k2 + 3.0 * t * k3)) / interval,
            acceleration: curvature / (interval * interval),
        }
    })
}

/// The polynomial of fifth order that leads from a distance, a speed and an acceleration to none of them.
fn fading([p, v, a]: [f64; 3], duration: f64) -> [f64; 6] {
    let t = duration;
    let (t2, t3) = (t * t, t * t * t);
    [
        p,
        v,
        a / 2.0,
        (-20.0 * p - 12.0 * v * t - 3.0 * a * t2) / (2.0 * t3),
        (30.0 * p + 16.0 * v * t + 3.0 * a * t2) / (2.0 * t3 * t),
        (-12.0 * p - 6.0 * v * t - a * t2) / (2.0 * t3 * t2),
    ]
}

fn value(k: &[f64; 6], t: f64) -> ScalarState {
    ScalarState {
        position: k[0] + t * (k[1] + t * (k[2] + t * (k[3] + t * (k[4] + t * k[5])))),
        speed: k[1] + t * (2.0 * k[2] + t * (3.0 * k[3] + t * (4.0 * k[4] + t * 5.0 * k[5]))),
        acceleration: 2.0 * k[2] + t * (6.0 * k[3] + t * (12.0 * k[4] + t * 20.0 * k[5])),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fading_begins_as_it_is_told_and_ends_in_nothing() {
        let polynomial = fading([0.1, -0.4, 2.0], 0.5);
        let begin = value(&polynomial, 0.0);
        assert_eq!(
            (begin.position, begin.speed, begin.acceleration),
            (0.1, -0.4, 2.0)
        );
        let end = value(&polynomial, 0.5);
        for left in [end.position, end.speed, end.acceleration] {
            assert!(left.abs() < 1e-12, "{end:?}");
        }
    }

    #[test]
    fn between_samples_of_a_parabola_lies_the_parabola() {
        let point = |k: usize| {
            let t = k as f64 * 0.004;
            let mut point = [0.0; 7];
            point[2] = 1.0 + 0.5 * t - 2.0 * t * t;
            point
        };
        let samples: Vec<PointValues> = (0..20).map(point).collect();
        for place in [3.0, 3.25, 3.5, 7.9] {
            let state = list_state(&samples, place, 0.004)[2];
            let t = place * 0.004;
            assert!((state.position - (1.0 + 0.5 * t - 2.0 * t * t)).abs() < 1e-12);
            assert!((state.speed - (0.5 - 4.0 * t)).abs() < 1e-9, "{state:?}");
            assert!((state.acceleration + 4.0).abs() < 1e-6, "{state:?}");
        }
        let end = list_state(&samples, 500.0, 0.004)[2];
        assert_eq!(end.position, samples[19][2]);
    }
}
