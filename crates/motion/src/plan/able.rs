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
}

/// The largest absolute second derivative of a joint between two places. It may lie between them: the parabola through both
/// whose mean takes the first derivative from one to the other has its vertex there.
pub(super) fn largest_bend(left: &PathPoint, right: &PathPoint, joint: usize) -> f64 {
    let (a, b) = (left.second[joint], right.second[joint]);
    let ends = a.abs().max(b.abs());
    let mean = (right.first[joint] - left.first[joint]) / (right.s - left.s);
    // a + change t + 6 excess t (1 - t), t from 0 to 1.
    let (change, excess) = (b - a, mean - (a + b) / 2.0);
    let vertex = 0.5 + change / (12.0 * excess);
    if vertex > 0.0 && vertex < 1.0 {
        let there = a + 6.0 * excess * vertex * vertex;
        ends.max(there.abs())
    } else {
        ends
    }
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
            self.turns(joint, if signs[0] == signs[1] { signs[0] } else { 0.0 });
        }
        self.elbow = self.elbow.max(elbow);
        self.torque
            .cover(&right.q, &right.first, &right.second, arm);
    }

    fn turns(&mut self, joint: usize, turning: f64) {
        let known = &mut self.turning[joint];
        if known.is_nan() {
            *known = turning;
        } else if *known != turning {
            *known = 0.0;
        }
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
        (0..6).for_each(|joint| self.turns(joint, other.turning[joint]));
    }

    /// What the piece bears, and no more than is wished for.
    pub fn limits(&self, wish: &Wish, limits: &MotionLimits) -> CellLimits {
        let speed = self.fastest(wish, limits);
        let able = self.accelerations(speed, limits);
        let most = able.as_flattened().iter().copied().fold(0.0, f64::max);
        let jerk = self.jerk_left(speed, most, limits);
        // One that takes longer to be reached than others would have the whole way smoothed over a longer time.
        let in_time = jerk * ACCELERATION_RISE;
        let wanted = if wish.duration > 0.0 {
            in_time
        } else {
            wish.acceleration.min(in_time)
        };
        let [asked, braking] = able.map(|able| able.map(|a| a.min(wanted)));
        CellLimits {
            speed,
            asked,
            braking,
            hardest: able[1].map(|a| HARDEST_SHARE * a),
            jerk,
        }
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
        let mut by_jerk = FASTEST;
        for joint in 0..6 {
            let (d1, d2) = (self.first[joint], self.second[joint]);
            let most = limits.acceleration[joint];
            for (able, eased) in able.iter_mut().zip([-1.0, 1.0]) {
                able[0] = able[0].min(most / d1);
                // Against the bend it has all of the joint's acceleration, and more, which is not used.
                let left = if self.turning[joint] == eased {
                    most
                } else {
                    most - d2 * speed * speed
                };
                able[1] = able[1].min(left / d1);
            }
            let left = BEND_SHARES.jerk_of_acceleration * limits.jerk[joint];
            by_jerk = by_jerk.min(left / (3.0 * d2 * speed));
        }
        able.map(|able| able.map(|a| a.min(by_jerk)))
    }

    /// The jerk of s that is left at a speed and with accelerations of at most `most`.
    fn jerk_left(&self, speed: f64, most: f64, limits: &MotionLimits) -> f64 {
        (0..6).fold(FASTEST / ACCELERATION_RISE, |jerk, joint| {
            let (d1, d2, d3) = (self.first[joint], self.second[joint], self.third[joint]);
            // A little is kept for what lies between the places that were looked at.
            let left = PLACES_SHARE * limits.jerk[joint]
                - d3 * speed * speed * speed
                - 3.0 * d2 * speed * most;
            jerk.min(left / d1)
        })
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
