//! What a piece of a path bears: the limits of s under which no joint exceeds its own, and no drive its torque.
//!
//! With q' q'' q''' the derivatives of a joint with respect to s and V, A, J the limits of s
//!     |q'| V <= speed,  |q''| V² + |q'| A <= acceleration,  |q'''| V³ + 3 |q''| V A + |q'| J <= jerk.
//! TCP and elbow stay within their speeds too. Torques: see `torque`.

use super::torque::TorqueBounds;
use super::{Arm, Wish};
use crate::config::MotionLimits;
use crate::constants::{
    ACCELERATION_RISE, BEND_SHARES, HARDEST_SHARE, POINT_SPEED_MARGIN, TORQUE_SHARE_OF_SPEED,
};
use crate::path::PathPoint;
use crate::scalar::CellLimits;
use kinematics::elementary::cbrt;

/// Share of a joint's jerk that is planned with.
const PLACES_SHARE: f64 = 0.95;
/// How often the acceleration is halved that a jerk allows.
const JERK_BISECTIONS: usize = 8;
/// Limits of s on a way on which nothing limits them.
const FASTEST: f64 = 1e4;

/// Largest absolute derivatives of each joint with respect to s in one piece of a path.
#[derive(Clone, Copy, Debug)]
pub struct Bounds {
    /// rad per s.
    pub first: [f64; 6],
    /// rad per s².
    pub second: [f64; 6],
    /// rad per s³.
    pub third: [f64; 6],
    /// Distance the TCP goes per s.
    pub tcp: f64,
    /// Distance the elbow goes per s.
    pub elbow: f64,
    /// What is asked of the drives.
    pub torque: TorqueBounds,
    /// What the bend does to each joint everywhere: it turns faster along the way (1), so that slowing down takes from what
    /// the bend asks of it, or slower (-1); 0 where that changes, or is not known.
    pub turning: [f64; 6],
    /// The same for the bend itself: it grows along the way (1), so that slowing down takes from the jerk that this asks of the
    /// joint, or falls (-1).
    pub curling: [f64; 6],
}

/// How a joint's second derivative goes from one place to the next: on the parabola through both whose mean takes the first
/// derivative from one to the other, a + change t + 6 excess t (1 - t) with t from 0 to 1.
#[derive(Clone, Copy)]
struct Bend {
    a: f64,
    change: f64,
    excess: f64,
}

impl Bend {
    fn between(left: &PathPoint, right: &PathPoint, joint: usize) -> Self {
        let (a, b) = (left.second[joint], right.second[joint]);
        let mean = (right.first[joint] - left.first[joint]) / (right.s - left.s);
        Self {
            a,
            change: b - a,
            excess: mean - (a + b) / 2.0,
        }
    }
}

/// The largest absolute second derivative of a joint between two places, which may lie between them.
pub(super) fn largest_bend(left: &PathPoint, right: &PathPoint, joint: usize) -> f64 {
    let Bend { a, change, excess } = Bend::between(left, right, joint);
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
fn curls(left: &PathPoint, right: &PathPoint, joint: usize) -> [f64; 2] {
    let Bend { a, change, excess } = Bend::between(left, right, joint);
    [
        a * (change + 6.0 * excess),
        (a + change) * (change - 6.0 * excess),
    ]
    .map(f64::signum)
}

impl Bounds {
    /// No place looked at yet.
    pub const NONE: Self = Self {
        first: [0.0; 6],
        second: [0.0; 6],
        third: [0.0; 6],
        tcp: 0.0,
        elbow: 0.0,
        torque: TorqueBounds::NONE,
        turning: [f64::NAN; 6],
        curling: [f64::NAN; 6],
    };

    /// Takes in what happens between two places.
    pub fn cover(&mut self, left: &PathPoint, right: &PathPoint, elbow: f64, arm: &Arm) {
        let way = right.s - left.s;
        for joint in 0..6 {
            let third = (right.second[joint] - left.second[joint]).abs() / way;
            let second = largest_bend(left, right, joint);
            // In between, the first derivative can exceed both ends by a parabola's height.
            let first =
                left.first[joint].abs().max(right.first[joint].abs()) + third * way * way / 8.0;
            self.first[joint] = self.first[joint].max(first);
            self.second[joint] = self.second[joint].max(second);
            self.third[joint] = self.third[joint].max(third);
            let signs = [left, right].map(|at| (at.first[joint] * at.second[joint]).signum());
            note(&mut self.turning[joint], same(signs));
            note(&mut self.curling[joint], same(curls(left, right, joint)));
        }
        self.elbow = self.elbow.max(elbow);
        self.torque
            .cover(&right.q, &right.first, &right.second, arm);
    }

    /// Takes in another piece.
    pub fn join(&mut self, other: &Self) {
        let most = |a: &mut [f64; 6], b: &[f64; 6]| (0..6).for_each(|k| a[k] = a[k].max(b[k]));
        most(&mut self.first, &other.first);
        most(&mut self.second, &other.second);
        most(&mut self.third, &other.third);
        self.tcp = self.tcp.max(other.tcp);
        self.elbow = self.elbow.max(other.elbow);
        self.torque.join(&other.torque);
        for joint in 0..6 {
            note(&mut self.turning[joint], other.turning[joint]);
            note(&mut self.curling[joint], other.curling[joint]);
        }
    }

    /// What the piece bears, and no more than is wished for.
    pub fn limits(&self, wish: &Wish, limits: &MotionLimits) -> CellLimits {
        let speed = self.fastest(wish, limits);
        let able = self.accelerations(speed, limits);
        let wanted = if wish.duration > 0.0 {
            f64::INFINITY
        } else {
            wish.acceleration
        };
        let in_time_by = |way: Way, wanted: f64| {
            let able = able[way as usize];
            let most = self.in_time(way, able, wanted, speed, limits);
            able.map(|a| a.min(most))
        };
        let in_time = |way| in_time_by(way, wanted);
        let (asked, braking) = (in_time(Way::Faster), in_time(Way::Slower));
        let left = self
            .jerk_left(Way::Faster, asked, speed, limits)
            .min(self.jerk_left(Way::Slower, braking, speed, limits));
        // What is asked for is reached in time, either way.
        let most = [asked, braking]
            .as_flattened()
            .iter()
            .copied()
            .fold(0.0, f64::max);
        let hardest = self.hardest(speed, limits);
        let late = in_time_by(Way::Slower, f64::INFINITY);
        CellLimits {
            speed,
            asked,
            braking,
            planned: core::array::from_fn(|k| late[k].min(hardest[k])),
            hardest,
            jerk: left.max(most / ACCELERATION_RISE),
        }
    }

    /// How hard the joints can slow down on the piece, at rest and at `speed`.
    pub(super) fn hardest(&self, speed: f64, limits: &MotionLimits) -> [f64; 2] {
        let hard = HARDEST_SHARE * self.share_of_jerk(speed, limits);
        let [_, able] = self.accelerations(speed, limits);
        able.map(|a| hard.min(HARDEST_SHARE * a))
    }

    /// The speed of s that points, drives and joints bear, and that is wished for.
    fn fastest(&self, wish: &Wish, limits: &MotionLimits) -> f64 {
        let mut speed = (limits.tcp_speed / self.tcp)
            .min(POINT_SPEED_MARGIN * limits.elbow_speed / self.elbow)
            .min(self.torque.speed_limit(TORQUE_SHARE_OF_SPEED))
            .min(FASTEST);
        for joint in 0..6 {
            let (d1, d2, d3) = (self.first[joint], self.second[joint], self.third[joint]);
            speed = speed
                .min(limits.speed[joint] / d1)
                .min((BEND_SHARES.acceleration * limits.acceleration[joint] / d2).sqrt())
                .min(cbrt(BEND_SHARES.jerk * limits.jerk[joint] / d3));
        }
        if wish.duration <= 0.0 {
            speed = speed.min(wish.speed);
        }
        speed
    }

    /// The accelerations of s that joints and drives bear at rest and at `speed`: speeding up, slowing down.
    fn accelerations(&self, speed: f64, limits: &MotionLimits) -> [[f64; 2]; 2] {
        let mut able = [[
            self.torque.acceleration_limit(0.0).min(FASTEST),
            self.torque.acceleration_limit(speed).min(FASTEST),
        ]; 2];
        for joint in 0..6 {
            let (d1, d2) = (self.first[joint], self.second[joint]);
            let most = limits.acceleration[joint];
            for (able, way) in able.iter_mut().zip([Way::Faster, Way::Slower]) {
                able[0] = able[0].min(most / d1);
                // Against the bend it has all of the joint's acceleration, and more, which is not used.
                let left = if self.turning[joint] == way.eased_by() {
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
    fn share_of_jerk(&self, speed: f64, limits: &MotionLimits) -> f64 {
        (0..6).fold(FASTEST, |least, joint| {
            let left = BEND_SHARES.jerk_of_acceleration * limits.jerk[joint];
            least.min(left / (3.0 * self.second[joint] * speed))
        })
    }

    /// The largest acceleration, no more than `wanted`, that the joints' jerks let be reached in time. One that takes longer
    /// than others would have the whole way smoothed over a longer time.
    fn in_time(
        &self,
        way: Way,
        able: [f64; 2],
        wanted: f64,
        speed: f64,
        limits: &MotionLimits,
    ) -> f64 {
        let fits = |a: f64| {
            let able = able.map(|able| able.min(a));
            let most = able[0].max(able[1]);
            self.jerk_left(way, able, speed, limits) * ACCELERATION_RISE >= most
        };
        let most = able[0].max(able[1]).min(wanted);
        if fits(most) {
            return most;
        }
        // With everything taken at once it fits in any case.
        let (mut low, mut high) = (self.surely_in_time(speed, limits).min(most), most);
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

    /// The acceleration that is reached in time though bends and their changes took from every jerk what they can at most.
    fn surely_in_time(&self, speed: f64, limits: &MotionLimits) -> f64 {
        (0..6).fold(FASTEST, |least, joint| {
            let (d1, d2, d3) = (self.first[joint], self.second[joint], self.third[joint]);
            let left = PLACES_SHARE * limits.jerk[joint] - d3 * speed * speed * speed;
            least.min(left / (d1 / ACCELERATION_RISE + 3.0 * d2 * speed))
        })
    }

    /// The jerk of s that is left up to a speed, with accelerations at rest and at that speed.
    fn jerk_left(
        &self,
        way: Way,
        [rest, fast]: [f64; 2],
        speed: f64,
        limits: &MotionLimits,
    ) -> f64 {
        (0..6).fold(FASTEST / ACCELERATION_RISE, |jerk, joint| {
            let (d1, d2, d3) = (self.first[joint], self.second[joint], self.third[joint]);
            let (bend, curl) = (3.0 * d2 * speed, d3 * speed * speed * speed);
            let (even, change) = (bend * rest, bend * (fast - rest));
            let taken = if self.curling[joint] == way.eased_by() {
                // One takes from the other.
                curl.max(highest(even, change))
            } else {
                highest(even, change + curl)
            };
            // A little is kept for what lies between the places that were looked at.
            jerk.min((PLACES_SHARE * limits.jerk[joint] - taken) / d1)
        })
    }
}

/// Which way the speed changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    Faster,
    Slower,
}

impl Way {
    /// How joints must turn, or bends grow, so that this takes from what they ask for.
    const fn eased_by(self) -> f64 {
        match self {
            Self::Faster => -1.0,
            Self::Slower => 1.0,
        }
    }
}

/// The largest value of `a x + b x³` for x from 0 to 1; `a` is not negative.
fn highest(a: f64, b: f64) -> f64 {
    if a < -3.0 * b {
        a * (a / (-3.0 * b)).sqrt() * 2.0 / 3.0
    } else {
        a + b
    }
}

/// A sign that two places have in common; 0 where they do not.
fn same([a, b]: [f64; 2]) -> f64 {
    if a == b { a } else { 0.0 }
}

/// Takes in the sign of another piece: it is known while all have the same.
fn note(known: &mut f64, sign: f64) {
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
            first: [s.atan(); 6],
            second: [1.0 / (1.0 + s * s); 6],
            branch: 0.0,
        }
    }

    #[test]
    fn a_bend_that_is_largest_between_two_places_is_seen() {
        for (from, to) in [(-0.3, 0.3), (-0.5, 0.2), (-0.1, 0.6), (-0.4, 0.4)] {
            let (left, right) = (hill(from), hill(to));
            let seen = largest_bend(&left, &right, 0);
            assert!((0.98..1.02).contains(&seen), "{seen} from {from} to {to}");
        }
        // Where it only grows it is that of the end.
        assert_eq!(
            largest_bend(&hill(-1.0), &hill(-0.6), 0),
            hill(-0.6).second[0]
        );
    }
}
