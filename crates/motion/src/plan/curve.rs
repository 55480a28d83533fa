//! What the curve of a blend asks of the arm, part by part.
//!
//! The curve is looked at in equal intervals; what lies between two places is bounded by what is known at both. Knows nothing
//! of the course over the curve: how its parts are put together is in `blend`.

use core::ops::Range;

use kinematics::{JointPositions, JointSpeeds};

use super::able::{Able, PartBounds, Shares};
use super::leg::Leg;
use super::{Arm, Wish};
use crate::constants::{BLEND_INTERVALS_PER_PART, BLEND_PARTS, POINT_SPEED_MARGIN};
use crate::path::{JointQuintic, QuinticPoint};
use crate::scalar::ScalarLimits;
use crate::setpoint::elbow_speed;

const INTERVALS: usize = BLEND_PARTS * BLEND_INTERVALS_PER_PART;

/// The curve's parts, and how far the TCP goes per s at its two ends.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurveParts {
    parts: [Part; BLEND_PARTS],
    tcp_at_ends: (f64, f64),
}

#[derive(Clone, Copy, Debug)]
struct Part {
    bounds: PartBounds,
    /// Distance of the TCP per s.
    tcp: f64,
    /// rad of the joint that turns fastest per s.
    turn: f64,
}

/// How fast the curve is wanted.
#[derive(Clone, Copy, Debug)]
pub(super) struct CurveWish {
    /// Speed of s.
    pub(super) speed: f64,
    /// Speed of the TCP, m/s; infinite where nobody asked for one.
    pub(super) tcp: f64,
    /// Speed of the leading joint, rad/s; infinite where nobody asked for one.
    pub(super) turn: f64,
    /// Acceleration of s.
    pub(super) acceleration: f64,
}

impl CurveParts {
    /// Looks at the curve after `leg`; `None` when it leaves the radius or a joint's range.
    pub(super) fn look(curve: &JointQuintic, leg: &Leg, arm: &Arm) -> Option<Self> {
        let step = curve.length() / INTERVALS as f64;
        let tcp = &leg.flange_from_tcp;
        let corner = arm.model.tcp_pose(&leg.path.end().q, tcp).translation;
        let mut parts = [Part::NONE; BLEND_PARTS];
        let (mut tcp_speeds, mut elbow_speeds) = (Peak::default(), Peak::default());
        let mut ends = (0.0, 0.0);
        for place in 0..=INTERVALS {
            let point = curve.point(step * place as f64);
            if !is_in_range(&point, arm) {
                return None;
            }
            let (q, rates) = (JointPositions(point.q), JointSpeeds(point.first));
            let frames = arm.model.forward(&q);
            let position = (frames.base_from_flange * *tcp).translation;
            if (position - corner).norm() > leg.radius {
                return None;
            }
            let tcp_per_s = frames.twist(&rates, position).linear.norm();
            let elbow_per_s = if arm.limits.elbow_speed.is_finite() {
                elbow_speed(&frames, &rates)
            } else {
                0.0
            };
            if place == 0 {
                ends.0 = tcp_per_s;
            }
            ends.1 = tcp_per_s;
            // A place between two parts belongs to both.
            let number = place / BLEND_INTERVALS_PER_PART;
            let is_shared = place.is_multiple_of(BLEND_INTERVALS_PER_PART);
            let first = if is_shared {
                number.saturating_sub(1)
            } else {
                number
            };
            let mut torque = PartBounds::NONE.torque;
            torque.cover(&q, &point.first, &point.second, arm);
            for part in parts.iter_mut().take(number + 1).skip(first) {
                part.cover(&point, step);
                part.bounds.torque.join(&torque);
            }
            // The interval that ends here, with what the one before it says of the curvature.
            if let Some(interval) = place.checked_sub(1)
                && let Some(part) = parts.get_mut(interval / BLEND_INTERVALS_PER_PART)
            {
                part.tcp = part.tcp.max(tcp_speeds.up_to(tcp_per_s));
                let elbow = elbow_speeds.up_to(elbow_per_s);
                part.bounds.elbow = part.bounds.elbow.max(elbow);
            } else {
                tcp_speeds.up_to(tcp_per_s);
                elbow_speeds.up_to(elbow_per_s);
            }
        }
        for part in &mut parts {
            part.bounds.tcp = part.tcp / POINT_SPEED_MARGIN;
        }
        Some(Self {
            parts,
            tcp_at_ends: ends,
        })
    }

    /// How far the TCP goes per s where the curve begins and where it ends.
    pub(super) fn tcp_at_ends(&self) -> (f64, f64) {
        self.tcp_at_ends
    }

    /// One set of limits for some parts; `None` when there is none that can be used.
    pub(super) fn limits(
        &self,
        parts: Range<usize>,
        wish: &CurveWish,
        shares: Shares,
        arm: &Arm,
    ) -> Option<ScalarLimits> {
        let mut all = Part::NONE;
        for part in self.parts.get(parts)? {
            all.bounds.join(&part.bounds);
            all.tcp = all.tcp.max(part.tcp);
            all.turn = all.turn.max(part.turn);
        }
        let speed = (wish.tcp / all.tcp).min(wish.turn / all.turn);
        let wish = Wish {
            speed: speed.min(wish.speed),
            acceleration: wish.acceleration,
            duration: 0.0,
            radius: 0.0,
        };
        let limits = Able::sharing(&all.bounds, arm.limits, shares).at(&wish);
        limits.are_usable().then_some(limits)
    }
}

impl Part {
    const NONE: Self = Self {
        bounds: PartBounds::NONE,
        tcp: 0.0,
        turn: 0.0,
    };

    /// Takes in a place and what lies up to `step` beside it.
    fn cover(&mut self, point: &QuinticPoint, step: f64) {
        // Between two places a value exceeds both by no more than a parabola's height.
        let rise = step * step / 8.0;
        let bounds = &mut self.bounds;
        for joint in 0..6 {
            let (d1, d2, d3, d4) = (
                point.first[joint].abs(),
                point.second[joint].abs(),
                point.third[joint].abs(),
                point.fourth[joint].abs(),
            );
            bounds.first[joint] = bounds.first[joint].max(d1 + rise * d3);
            bounds.second[joint] = bounds.second[joint].max(d2 + rise * d4);
            bounds.third[joint] = bounds.third[joint].max(d3 + 0.5 * step * d4);
            self.turn = self.turn.max(d1 + rise * d3);
        }
    }
}

/// The largest value of a smooth function between places at equal distances.
#[derive(Clone, Copy, Debug, Default)]
struct Peak {
    before: [f64; 2],
    count: usize,
}

impl Peak {
    /// The function's value at the next place; the largest since the place before.
    ///
    /// A parabola through three places rises over its ends by an eighth of their second difference; as much again is for
    /// what it does not know.
    fn up_to(&mut self, value: f64) -> f64 {
        let [one, two] = self.before;
        self.before = [two, value];
        self.count += 1;
        match self.count {
            1 => value,
            2 => value.max(two),
            _ => value.max(two) + (one - 2.0 * two + value).abs() / 4.0,
        }
    }
}

fn is_in_range(point: &QuinticPoint, arm: &Arm) -> bool {
    (0..6).all(|joint| {
        let range = arm.limits.position_min[joint]..=arm.limits.position_max[joint];
        range.contains(&point.q[joint])
    })
}
