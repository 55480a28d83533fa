//! What a piece of a path bears: the limits of s under which no joint exceeds its own, and no drive its torque.
//!
//! With q' q'' q''' the derivatives of a joint with respect to s and V, A, J the limits of s
//!     |q'| V <= speed,  |q''| V² + |q'| A <= acceleration,  |q'''| V³ + 3 |q''| V A + |q'| J <= jerk.
//! TCP and elbow stay within their speeds too. Torques: see `torque`.

use super::torque::TorqueBounds;
use super::{Arm, Wish};
use crate::config::MotionLimits;
use crate::constants::{BEND_SHARES, HARDEST_SHARE, POINT_SPEED_MARGIN, TORQUE_SHARE_OF_SPEED};
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
    };

    /// Takes in what happens between two places.
    pub fn cover(&mut self, left: &PathPoint, right: &PathPoint, elbow: f64, arm: &Arm) {
        let way = right.s - left.s;
        for joint in 0..6 {
            let third = (right.second[joint] - left.second[joint]).abs() / way;
            let second = left.second[joint].abs().max(right.second[joint].abs());
            // In between, the first derivative can exceed both ends by a parabola's height.
            let first =
                left.first[joint].abs().max(right.first[joint].abs()) + third * way * way / 8.0;
            self.first[joint] = self.first[joint].max(first);
            self.second[joint] = self.second[joint].max(second);
            self.third[joint] = self.third[joint].max(third);
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
    }

    /// What the piece bears, and no more than is wished for.
    pub fn limits(&self, wish: &Wish, limits: &MotionLimits) -> CellLimits {
        let mut speed = (limits.tcp_speed / self.tcp)
            .min(POINT_SPEED_MARGIN * limits.elbow_speed / self.elbow)
            .min(self.torque.speed_limit(TORQUE_SHARE_OF_SPEED))
            .min(FASTEST);
        let mut by_jerk = FASTEST;
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
        let square = speed * speed;
        let mut able = [
            self.torque.acceleration_limit(0.0).min(FASTEST),
            self.torque.acceleration_limit(speed).min(FASTEST),
        ];
        for joint in 0..6 {
            let (d1, d2) = (self.first[joint], self.second[joint]);
            let most = limits.acceleration[joint];
            able[0] = able[0].min(most / d1);
            able[1] = able[1].min((most - d2 * square) / d1);
            let left = BEND_SHARES.jerk_of_acceleration * limits.jerk[joint];
            by_jerk = by_jerk.min(left / (3.0 * d2 * speed));
        }
        let able = able.map(|a| a.min(by_jerk));
        let most = able[0].max(able[1]);
        let mut jerk = FASTEST / crate::constants::ACCELERATION_RISE;
        for joint in 0..6 {
            let (d1, d2, d3) = (self.first[joint], self.second[joint], self.third[joint]);
            // A little is kept for what lies between the places that were looked at.
            let left =
                PLACES_SHARE * limits.jerk[joint] - d3 * speed * square - 3.0 * d2 * speed * most;
            jerk = jerk.min(left / d1);
        }
        let asked = able.map(|a| {
            if wish.duration > 0.0 {
                a
            } else {
                a.min(wish.acceleration)
            }
        });
        CellLimits {
            speed,
            asked,
            hardest: able.map(|a| HARDEST_SHARE * a),
            jerk,
        }
    }
}
