//! What belts and offsets make of a setpoint, held against what the joints can do.
//!
//! A motion is planned where it begins, not where it is carried: together with what is laid over it, it can ask for
//! more than the joints can do. Belts and offsets keep shares for that (`belt`, `path_offsets`); where these are not
//! enough the joints brake while they still can within their limits, and everything goes on from rest, more slowly.
//! Only what does so again and again, or by the belt alone, is a protective stop.

use kinematics::elementary::{cube, square};
use motion_api::StopReason;

use crate::commanded::PlacedSetpoint;
use crate::config::MotionLimits;
use crate::constants::LIMIT_SLACK;
use crate::cycle::ControlLoop;
use crate::modes::axis::AxisLimits;
use crate::modes::conveyor::ConveyorTracking;
use crate::modes::{is_setpoint_at_rest, states};
use crate::setpoint::Setpoint;

/// Most times in a row that the joints are braked because what is laid over a motion asks for too much.
const YIELDS_MAX: u8 = 8;
/// Time without braking after which such a row is over, s.
const YIELDS_APART: f64 = 3.0;

/// How often the joints had to be braked lately, because what was laid over a motion asked for too much.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Yields {
    count: u8,
    /// Time since the joints were braked last, s.
    since: f64,
}

impl Yields {
    /// Time passes.
    pub(crate) fn advance(&mut self, step: f64) {
        self.since += step;
        if self.since > YIELDS_APART {
            self.count = 0;
        }
    }

    /// Once more; false when that was too often.
    fn add(&mut self) -> bool {
        if self.count >= YIELDS_MAX {
            return false;
        }
        *self = Self {
            count: self.count + 1,
            since: 0.0,
        };
        true
    }

    /// The share of what the joints leave that may be used after that.
    pub(crate) fn share(&self) -> f64 {
        1.0 / f64::from(1_u32 << self.count)
    }
}

impl ControlLoop {
    /// What was laid over the motion underneath must not ask more of the joints than they can do: a motion is planned
    /// where it begins, not where it is carried. It is stopped while the joints can still come to rest within their
    /// limits.
    pub(crate) fn check_overlays(&mut self, wanted: &Setpoint) -> Result<(), StopReason> {
        if self.tracking.is_none() && !self.path_offset.is_on() {
            return Ok(());
        }
        let (able, checked) = (self.limits.able(), self.limits.enforced());
        let is_within = is_within_rates(wanted, self.commanded.setpoint(), self.step, able);
        if self.tracking.is_some() {
            if !(is_within && can_brake_within_limits(wanted, checked)) {
                return Err(StopReason::ConveyorLost);
            }
            return self.slow_for_belt(wanted);
        }
        if is_within && can_brake_within_limits(wanted, checked) {
            Ok(())
        } else {
            Err(StopReason::PathOffsetLost)
        }
    }

    /// What is laid over a motion asks more of the joints than they can do: they brake, and it goes on from rest, more
    /// slowly.
    ///
    /// # Errors
    /// `reason`, where nothing moves but a belt, or that happened again and again.
    pub(crate) fn yield_to_limits(
        &mut self,
        nominal: &Setpoint,
        reason: StopReason,
    ) -> Result<PlacedSetpoint, StopReason> {
        let moves = !is_setpoint_at_rest(nominal) || !self.path_offset.is_standing();
        let is_leaving = self
            .tracking
            .as_ref()
            .is_some_and(ConveyorTracking::is_stopping);
        if !moves || is_leaving || !self.yields.add() {
            return Err(reason);
        }
        if let Some(tracking) = &mut self.tracking {
            tracking.slow_motion_down();
        }
        self.target = *nominal;
        self.hold(false);
        self.next_hold_setpoint().ok_or(reason)
    }
}

/// No joint exceeds its acceleration, or its jerk between two setpoints that are `step` seconds apart.
pub(crate) fn is_within_rates(
    next: &Setpoint,
    before: &Setpoint,
    step: f64,
    limits: &MotionLimits,
) -> bool {
    (0..6).all(|joint| {
        let most = limits.jerk[joint];
        let jerk = (next.qdd[joint] - before.qdd[joint]) / step;
        // Near singular positions inverse kinematics may go over into another branch: then position, speed and
        // acceleration do not belong to one motion, although each is within its limit.
        let evenly = 0.5 * step * (before.qd[joint] + next.qd[joint]);
        let off = next.q[joint] - before.q[joint] - evenly;
        let evenly = 0.5 * step * (before.qdd[joint] + next.qdd[joint]);
        let speed_off = next.qd[joint] - before.qd[joint] - evenly;
        next.qdd[joint].abs() <= limits.acceleration[joint] * (1.0 + RATE_SLACK)
            && jerk.abs() <= most * (1.0 + RATE_SLACK)
            && off.abs() <= most * cube(step) / 6.0 + CONTINUITY_TOLERANCE * step
            && speed_off.abs() <= most * square(step) / 4.0 + CONTINUITY_TOLERANCE
    })
}

/// No joint exceeds its speed or leaves its range when all of them brake from here.
fn can_brake_within_limits(from: &Setpoint, limits: &MotionLimits) -> bool {
    states(from).iter().enumerate().all(|(joint, state)| {
        let axis = AxisLimits {
            min: limits.position_min[joint] - LIMIT_SLACK,
            max: limits.position_max[joint] + LIMIT_SLACK,
            speed: limits.speed[joint] + LIMIT_SLACK / 2.0,
            acceleration: limits.acceleration[joint] * (1.0 + RATE_SLACK),
            jerk: limits.jerk[joint],
        };
        axis.can_brake_within_limits(state)
    })
}

/// Positions and speeds may differ by this, rad/s, from what goes on from the ones before.
const CONTINUITY_TOLERANCE: f64 = 1e-6;
/// Accelerations and jerks may exceed their limits by this part through rounding.
const RATE_SLACK: f64 = 1e-6;
