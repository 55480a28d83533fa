//! What a piece of a path bears: the limits of s under which no joint exceeds its own, and no drive its torque.
//!
//! With q' q'' q''' the derivatives of a joint with respect to s and V, A, J the limits of s
//!     |q'| V <= speed,  |q''| V² + |q'| A <= acceleration,  |q'''| V³ + 3 |q''| V A + |q'| J <= jerk.
//! TCP and elbow stay within their speeds too. Torques: see `torque`.

use super::torque::TorqueBounds;
use super::{MotionRequest, PlanningContext};
use crate::config::MotionLimits;
use crate::constants::{
    ACCELERATION_RISE, CURVATURE_SHARES, HARD_STOP_SHARE, POINT_SPEED_MARGIN, TORQUE_SHARE_OF_SPEED,
};
use crate::path::PathPoint;
use crate::scalar::IntervalLimits;
use kinematics::elementary::cbrt;

/// Share of a joint's jerk that is planned with.
const SAMPLING_MARGIN: f64 = 0.95;
/// How often the acceleration is halved that a jerk allows.
const JERK_BISECTIONS: usize = 8;
/// Limits of s on a way on which nothing limits them.
const UNLIMITED: f64 = 1e4;

/// Largest absolute derivatives of each joint with respect to s in one piece of a path.
#[derive(Clone, Copy, Debug)]
pub struct DerivativeBounds {
    /// rad per s.
    pub dq_ds: [f64; 6],
    /// rad per s².
    pub d2q_ds2: [f64; 6],
    /// rad per s³.
    pub d3q_ds3: [f64; 6],
    /// Distance the TCP goes per s.
    pub tcp: f64,
    /// Distance the elbow goes per s.
    pub elbow: f64,
    /// What is asked of the drives.
    pub torque: TorqueBounds,
    /// What the bend does to each joint everywhere: it turns faster along the way (1), so that slowing down takes from
    /// what the bend asks of it, or slower (-1); 0 where that changes, or is not known.
    pub first_derivative_trend: [f64; 6],
    /// What the way does to the bend of each joint everywhere: the bend grows along the way (1), so that slowing down
    /// takes from the jerk that this asks of the joint, or falls (-1); 0 where that changes, or is not known.
    pub second_derivative_trend: [f64; 6],
}

/// How a joint's second derivative goes from one place to the next: on the parabola through both whose mean takes the
/// first derivative from one to the other, a + change t + 6 excess t (1 - t) with t from 0 to 1.
#[derive(Clone, Copy)]
struct SecondDerivativeParabola {
    a: f64,
    change: f64,
    excess: f64,
}

impl SecondDerivativeParabola {
    fn between(left: &PathPoint, right: &PathPoint, joint: usize) -> Self {
        let (a, b) = (left.d2q_ds2[joint], right.d2q_ds2[joint]);
        let mean = (right.dq_ds[joint] - left.dq_ds[joint]) / (right.s - left.s);
        Self {
            a,
            change: b - a,
            excess: mean - (a + b) / 2.0,
        }
    }
}

/// The largest absolute second derivative of a joint between two places, which may lie between them.
pub(super) fn max_second_derivative(left: &PathPoint, right: &PathPoint, joint: usize) -> f64 {
    let SecondDerivativeParabola { a, change, excess } =
        SecondDerivativeParabola::between(left, right, joint);
    let ends = a.abs().max((a + change).abs());
    let vertex = 0.5 + change / (12.0 * excess);
    if vertex > 0.0 && vertex < 1.0 {
        let there = a + 6.0 * excess * vertex * vertex;
        ends.max(there.abs())
    } else {
        ends
    }
}

/// Whether the bend of a joint grows (1) or falls (-1) along the way, at both places.
fn second_derivative_trends(left: &PathPoint, right: &PathPoint, joint: usize) -> [f64; 2] {
    let SecondDerivativeParabola { a, change, excess } =
        SecondDerivativeParabola::between(left, right, joint);
    [
        a * (change + 6.0 * excess),
        (a + change) * (change - 6.0 * excess),
    ]
    .map(f64::signum)
}

impl DerivativeBounds {
    /// No place looked at yet.
    pub const NONE: Self = Self {
        dq_ds: [0.0; 6],
        d2q_ds2: [0.0; 6],
        d3q_ds3: [0.0; 6],
        tcp: 0.0,
        elbow: 0.0,
        torque: TorqueBounds::NONE,
        first_derivative_trend: [f64::NAN; 6],
        second_derivative_trend: [f64::NAN; 6],
    };

    /// Takes in what happens between two places.
    pub fn include_interval(
        &mut self,
        left: &PathPoint,
        right: &PathPoint,
        elbow: f64,
        arm: &PlanningContext,
    ) {
        let way = right.s - left.s;
        for joint in 0..6 {
            let third = (right.d2q_ds2[joint] - left.d2q_ds2[joint]).abs() / way;
            let second = max_second_derivative(left, right, joint);
            // In between, the first derivative can exceed both ends by a parabola's height.
            let first =
                left.dq_ds[joint].abs().max(right.dq_ds[joint].abs()) + third * way * way / 8.0;
            self.dq_ds[joint] = self.dq_ds[joint].max(first);
            self.d2q_ds2[joint] = self.d2q_ds2[joint].max(second);
            self.d3q_ds3[joint] = self.d3q_ds3[joint].max(third);
            let signs = [left, right].map(|at| (at.dq_ds[joint] * at.d2q_ds2[joint]).signum());
            merge_sign(&mut self.first_derivative_trend[joint], common_sign(signs));
            merge_sign(
                &mut self.second_derivative_trend[joint],
                common_sign(second_derivative_trends(left, right, joint)),
            );
        }
        self.elbow = self.elbow.max(elbow);
        self.torque
            .cover(&right.q, &right.dq_ds, &right.d2q_ds2, arm);
    }

    /// Takes in another piece.
    pub fn merge(&mut self, other: &Self) {
        let most = |a: &mut [f64; 6], b: &[f64; 6]| (0..6).for_each(|k| a[k] = a[k].max(b[k]));
        most(&mut self.dq_ds, &other.dq_ds);
        most(&mut self.d2q_ds2, &other.d2q_ds2);
        most(&mut self.d3q_ds3, &other.d3q_ds3);
        self.tcp = self.tcp.max(other.tcp);
        self.elbow = self.elbow.max(other.elbow);
        self.torque.join(&other.torque);
        for joint in 0..6 {
            merge_sign(
                &mut self.first_derivative_trend[joint],
                other.first_derivative_trend[joint],
            );
            merge_sign(
                &mut self.second_derivative_trend[joint],
                other.second_derivative_trend[joint],
            );
        }
    }

    /// What the piece bears, and no more than is wished for.
    pub fn interval_limits(&self, wish: &MotionRequest, limits: &MotionLimits) -> IntervalLimits {
        let speed = self.max_speed(wish, limits);
        let able = self.accelerations(speed, limits);
        let wanted = if wish.duration > 0.0 {
            f64::INFINITY
        } else {
            wish.acceleration
        };
        let in_time_by = |way: SpeedChange, wanted: f64| {
            let able = able[way as usize];
            let most = self.max_acceleration_in_rise_time(way, able, wanted, speed, limits);
            able.map(|a| a.min(most))
        };
        let in_time = |way| in_time_by(way, wanted);
        let (asked, braking) = (
            in_time(SpeedChange::Accelerate),
            in_time(SpeedChange::Brake),
        );
        let left = self
            .available_jerk(SpeedChange::Accelerate, asked, speed, limits)
            .min(self.available_jerk(SpeedChange::Brake, braking, speed, limits));
        // What is asked for is reached in time, either way.
        let most = [asked, braking]
            .as_flattened()
            .iter()
            .copied()
            .fold(0.0, f64::max);
        let hardest = self.hardest(speed, limits);
        let late = in_time_by(SpeedChange::Brake, f64::INFINITY);
        IntervalLimits {
            speed,
            asked,
            braking,
            planned: core::array::from_fn(|k| late[k].min(hardest[k])),
            max_braking: hardest,
            jerk: left.max(most / ACCELERATION_RISE),
        }
    }

    /// How hard the joints can slow down on the piece, at rest and at `speed`.
    pub(super) fn hardest(&self, speed: f64, limits: &MotionLimits) -> [f64; 2] {
        let hard = HARD_STOP_SHARE * self.curvature_limited_acceleration(speed, limits);
        let [_, able] = self.accelerations(speed, limits);
        able.map(|a| hard.min(HARD_STOP_SHARE * a))
    }

    /// The speed of s that points, drives and joints bear, and that is wished for.
    fn max_speed(&self, wish: &MotionRequest, limits: &MotionLimits) -> f64 {
        let mut speed = (limits.tcp_speed / self.tcp)
            .min(POINT_SPEED_MARGIN * limits.elbow_speed / self.elbow)
            .min(self.torque.speed_limit(TORQUE_SHARE_OF_SPEED))
            .min(UNLIMITED);
        for joint in 0..6 {
            let (d1, d2, d3) = (self.dq_ds[joint], self.d2q_ds2[joint], self.d3q_ds3[joint]);
            speed = speed
                .min(limits.speed[joint] / d1)
                .min((CURVATURE_SHARES.acceleration * limits.acceleration[joint] / d2).sqrt())
                .min(cbrt(CURVATURE_SHARES.jerk * limits.jerk[joint] / d3));
        }
        if wish.duration <= 0.0 {
            speed = speed.min(wish.speed);
        }
        speed
    }

    /// The accelerations of s that joints and drives bear at rest and at `speed`: speeding up, slowing down.
    fn accelerations(&self, speed: f64, limits: &MotionLimits) -> [[f64; 2]; 2] {
        let mut able = [[
            self.torque.acceleration_limit(0.0).min(UNLIMITED),
            self.torque.acceleration_limit(speed).min(UNLIMITED),
        ]; 2];
        for joint in 0..6 {
            let (d1, d2) = (self.dq_ds[joint], self.d2q_ds2[joint]);
            let most = limits.acceleration[joint];
            for (able, way) in able
                .iter_mut()
                .zip([SpeedChange::Accelerate, SpeedChange::Brake])
            {
                able[0] = able[0].min(most / d1);
                // Against the bend it has all of the joint's acceleration, and more, which is not used.
                let left = if self.first_derivative_trend[joint] == way.relieving_trend() {
                    most
                } else {
                    most - d2 * speed * speed
                };
                able[1] = able[1].min(left / d1);
            }
        }
        able
    }

    /// The acceleration of s for which bends take no more than a share of any joint's jerk.
    fn curvature_limited_acceleration(&self, speed: f64, limits: &MotionLimits) -> f64 {
        (0..6).fold(UNLIMITED, |least, joint| {
            let left = CURVATURE_SHARES.jerk_of_acceleration * limits.jerk[joint];
            least.min(left / (3.0 * self.d2q_ds2[joint] * speed))
        })
    }

    /// The largest acceleration, no more than `wanted`, that the joints' jerks let be reached in time. One that takes
    /// longer than others would have the whole way smoothed over a longer time.
    fn max_acceleration_in_rise_time(
        &self,
        way: SpeedChange,
        able: [f64; 2],
        wanted: f64,
        speed: f64,
        limits: &MotionLimits,
    ) -> f64 {
        let fits = |a: f64| {
            let able = able.map(|able| able.min(a));
            let most = able[0].max(able[1]);
            self.available_jerk(way, able, speed, limits) * ACCELERATION_RISE >= most
        };
        let most = able[0].max(able[1]).min(wanted);
        if fits(most) {
            return most;
        }
        // With everything taken at once it fits in any case.
        let (mut low, mut high) = (self.guaranteed_acceleration(speed, limits).min(most), most);
        for _ in 0..JERK_BISECTIONS {
            let middle = 0.5 * (low + high);
            if fits(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        low
    }

    /// The acceleration that is reached in time though bends and their changes took from every jerk what they can at
    /// most.
    fn guaranteed_acceleration(&self, speed: f64, limits: &MotionLimits) -> f64 {
        (0..6).fold(UNLIMITED, |least, joint| {
            let (d1, d2, d3) = (self.dq_ds[joint], self.d2q_ds2[joint], self.d3q_ds3[joint]);
            let left = SAMPLING_MARGIN * limits.jerk[joint] - d3 * speed * speed * speed;
            least.min(left / (d1 / ACCELERATION_RISE + 3.0 * d2 * speed))
        })
    }

    /// The jerk of s that is left up to a speed, with accelerations at rest and at that speed.
    fn available_jerk(
        &self,
        way: SpeedChange,
        [rest, fast]: [f64; 2],
        speed: f64,
        limits: &MotionLimits,
    ) -> f64 {
        (0..6).fold(UNLIMITED / ACCELERATION_RISE, |jerk, joint| {
            let (d1, d2, d3) = (self.dq_ds[joint], self.d2q_ds2[joint], self.d3q_ds3[joint]);
            let (bend, curl) = (3.0 * d2 * speed, d3 * speed * speed * speed);
            let (even, change) = (bend * rest, bend * (fast - rest));
            let taken = if self.second_derivative_trend[joint] == way.relieving_trend() {
                // One takes from the other.
                curl.max(max_cubic_on_unit_interval(even, change))
            } else {
                max_cubic_on_unit_interval(even, change + curl)
            };
            // A little is kept for what lies between the places that were looked at.
            jerk.min((SAMPLING_MARGIN * limits.jerk[joint] - taken) / d1)
        })
    }
}

/// The direction in which the speed changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum SpeedChange {
    Accelerate,
    Brake,
}

impl SpeedChange {
    /// How joints must turn, or bends grow, so that this takes from what they ask for.
    const fn relieving_trend(self) -> f64 {
        match self {
            Self::Accelerate => -1.0,
            Self::Brake => 1.0,
        }
    }
}

/// The largest value of `a x + b x³` for x from 0 to 1; `a` is not negative.
fn max_cubic_on_unit_interval(a: f64, b: f64) -> f64 {
    if a < -3.0 * b {
        a * (a / (-3.0 * b)).sqrt() * 2.0 / 3.0
    } else {
        a + b
    }
}

/// A sign that two places have in common; 0 where they do not.
fn common_sign([a, b]: [f64; 2]) -> f64 {
    if a == b { a } else { 0.0 }
}

/// Takes in the sign of another piece: it is known while all have the same.
fn merge_sign(known: &mut f64, sign: f64) {
    if known.is_nan() {
        *known = sign;
    } else if *known != sign {
        *known = 0.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use kinematics::JointPositions;

    /// A joint whose way bends like a hill, 1 / (1 + s²) high.
    fn hill(s: f64) -> PathPoint {
        PathPoint {
            s,
            q: JointPositions([s * s.atan() - 0.5 * (1.0 + s * s).ln(); 6]),
            dq_ds: [s.atan(); 6],
            d2q_ds2: [1.0 / (1.0 + s * s); 6],
            branch: 0.0,
        }
    }

    #[test]
    fn a_bend_that_is_largest_between_two_places_is_seen() {
        for (from, to) in [(-0.3, 0.3), (-0.5, 0.2), (-0.1, 0.6), (-0.4, 0.4)] {
            let (left, right) = (hill(from), hill(to));
            let seen = max_second_derivative(&left, &right, 0);
            assert!((0.98..1.02).contains(&seen), "{seen} from {from} to {to}");
        }
        // Where it only grows it is that of the end.
        assert_eq!(
            max_second_derivative(&hill(-1.0), &hill(-0.6), 0),
            hill(-0.6).d2q_ds2[0]
        );
    }
}
