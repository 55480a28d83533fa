//! What a part of a path bears: the limits of s under which no joint exceeds its own, and no drive its torque.
//!
//! With q' q'' q''' the derivatives of a joint with respect to s and V, A, J the limits of s
//!     |q'| V <= speed,  |q''| V² + |q'| A <= acceleration,  |q'''| V³ + 3 |q''| V A + |q'| J <= jerk.
//! TCP and elbow stay within their speeds too. Torques: see `torque`.

use super::torque::TorqueBounds;
use super::{Arm, Wish};
use crate::config::MotionLimits;
use crate::constants::{POINT_SPEED_MARGIN, TORQUE_SHARE_OF_SPEED};
use crate::path::PathPoint;
use crate::scalar::ScalarLimits;

/// Parts of the joints' limits kept for each term of the sums above, so that none uses up the others' share.
#[derive(Clone, Copy, Debug)]
pub struct Shares {
    /// Of the acceleration, for |q''| V².
    acceleration: f64,
    /// Of the jerk, for |q'''| V³.
    jerk: f64,
    /// Of the jerk, for 3 |q''| V A.
    jerk_of_acceleration: f64,
}

impl Shares {
    /// On a way walked evenly.
    pub const EVEN: Self = Self {
        acceleration: 0.5,
        jerk: 0.25,
        jerk_of_acceleration: 0.4,
    };
    /// On a way walked at a pace, whose own changes of speed belong to V; A is for starting and stopping alone.
    pub const PACED: Self = Self {
        acceleration: 0.8,
        jerk: 0.6,
        jerk_of_acceleration: 0.2,
    };
}

/// Largest absolute derivatives of each joint with respect to s in one part of a path.
#[derive(Clone, Copy, Debug)]
pub struct PartBounds {
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

impl PartBounds {
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

    /// Takes in another part.
    pub fn join(&mut self, other: &Self) {
        let most = |a: &mut [f64; 6], b: &[f64; 6]| (0..6).for_each(|k| a[k] = a[k].max(b[k]));
        most(&mut self.first, &other.first);
        most(&mut self.second, &other.second);
        most(&mut self.third, &other.third);
        self.tcp = self.tcp.max(other.tcp);
        self.elbow = self.elbow.max(other.elbow);
        self.torque.join(&other.torque);
    }

    /// The same with respect to a parameter of which s is a function with derivatives of at most these (chain rule).
    #[must_use]
    pub fn walked_at(&self, first: f64, second: f64, third: f64) -> Self {
        let by_joint = |f: &dyn Fn(f64, f64, f64) -> f64| {
            core::array::from_fn(|k| f(self.first[k], self.second[k], self.third[k]))
        };
        Self {
            first: by_joint(&|d1, _, _| d1 * first),
            second: by_joint(&|d1, d2, _| d2 * first * first + d1 * second),
            third: by_joint(&|d1, d2, d3| {
                d3 * first * first * first + 3.0 * d2 * first * second + d1 * third
            }),
            tcp: self.tcp * first,
            elbow: self.elbow * first,
            torque: self.torque.walked_at(first, second),
        }
    }
}

/// The speed of s at which a joint's second and third derivatives with respect to s take up their shares of its limits.
pub fn speed_for_bend(
    (second, third): (f64, f64),
    joint: usize,
    limits: &MotionLimits,
    shares: &Shares,
) -> f64 {
    (shares.acceleration * limits.acceleration[joint] / second)
        .sqrt()
        .min((shares.jerk * limits.jerk[joint] / third).cbrt())
}

/// A part with the limits of the arm: what it bears at most, per wanted speed, see [`Able::at`].
#[derive(Clone, Copy, Debug)]
pub struct Able {
    bounds: PartBounds,
    limits: MotionLimits,
    shares: Shares,
    /// Largest speed of s.
    speed: f64,
}

impl Able {
    /// Of a part.
    pub fn of(part: &PartBounds, limits: &MotionLimits) -> Self {
        Self::sharing(part, limits, Shares::EVEN)
    }

    /// The same with other shares.
    pub fn sharing(part: &PartBounds, limits: &MotionLimits, shares: Shares) -> Self {
        let mut speed = (limits.tcp_speed / part.tcp)
            .min(POINT_SPEED_MARGIN * limits.elbow_speed / part.elbow)
            .min(part.torque.speed_limit(TORQUE_SHARE_OF_SPEED));
        for joint in 0..6 {
            let (d1, d2, d3) = (part.first[joint], part.second[joint], part.third[joint]);
            speed = speed.min(limits.speed[joint] / d1).min(speed_for_bend(
                (d2, d3),
                joint,
                limits,
                &shares,
            ));
        }
        Self {
            bounds: *part,
            limits: *limits,
            shares,
            speed,
        }
    }

    /// The largest speed of s.
    pub fn speed(&self) -> f64 {
        self.speed
    }

    /// The limits of s for a wish.
    pub fn at(&self, wish: &Wish) -> ScalarLimits {
        let speed = if wish.duration > 0.0 {
            self.speed
        } else {
            self.speed.min(wish.speed)
        };
        let mut acceleration = self.bounds.torque.acceleration_limit(speed);
        for joint in 0..6 {
            let (d1, d2) = (self.bounds.first[joint], self.bounds.second[joint]);
            let left = self.limits.acceleration[joint] - d2 * speed * speed;
            acceleration = acceleration.min(left / d1).min(
                self.shares.jerk_of_acceleration * self.limits.jerk[joint] / (3.0 * d2 * speed),
            );
        }
        let wanted = wish.within(&ScalarLimits {
            speed,
            acceleration,
            jerk: f64::INFINITY,
        });
        let mut jerk = wanted.jerk;
        for joint in 0..6 {
            let (d1, d2, d3) = (
                self.bounds.first[joint],
                self.bounds.second[joint],
                self.bounds.third[joint],
            );
            let left = self.limits.jerk[joint]
                - d3 * speed * speed * speed
                - 3.0 * d2 * speed * wanted.acceleration;
            jerk = jerk.min(left / d1);
        }
        ScalarLimits { jerk, ..wanted }
    }
}
