//! The safety planes in the cycle: which targets they allow, and where a motion must stop for them.
//!
//! Owns when they are asked; what they hold back is in `kinematics::safety`, which `is_within_safety_limits` asks as
//! well.
//!
//! A setpoint passes while there is a way to rest before the planes: the joints brake one by one, which leaves the path
//! a little, or a planned motion halts on its path. So a motion whose whole path is allowed is never stopped, however
//! near to a plane it passes, and one that is stopped does not cross it.

use kinematics::safety::{PlaneSwitches, SafetyViolation};
use kinematics::{JointPositions, Pose, RpyPose};
use motion_api::{Refusal, StopReason};

use crate::brake::JointStopMotion;
use crate::cycle::{ControlLoop, Generator};
use crate::queue::PathMotion;
use crate::setpoint::Setpoint;

/// Places on the way of braking joints to rest that are looked at.
const BRAKE_PLACES: u32 = 8;
/// An arm behind a plane already may be as deep as it is, up to rounding, m.
const DEPTH_SLACK: f64 = 1e-9;

impl ControlLoop {
    /// The safety planes that count now: by mode, and by pairs of configurable inputs (bits 16 to 23) that are both
    /// high.
    pub(crate) fn plane_switches(&self) -> PlaneSwitches {
        PlaneSwitches {
            reduced: self.machine.is_reduced(),
            ci_pairs: core::array::from_fn(|pair| {
                self.io.image.digital_in >> (16 + 2 * pair) & 3 == 3
            }),
        }
    }

    /// A target must lie inside the joint ranges and before the safety planes.
    pub(crate) fn check_target(&self, q: &JointPositions) -> Result<(), Refusal> {
        self.check_reduced_range(q)?;
        let switches = self.plane_switches();
        let violation =
            self.safety
                .violation_at(&self.model, q, self.tool.flange_from_tcp(), &switches);
        match violation {
            Some(SafetyViolation::JointPosition {
                joint,
                value_rad,
                min_rad,
                max_rad,
            }) => Err(Refusal::JointLimit {
                joint: joint as u8,
                value: value_rad,
                min: min_rad,
                max: max_rad,
            }),
            Some(SafetyViolation::Plane { plane, depth_m, .. }) => Err(Refusal::SafetyPlane {
                plane: plane as u8,
                depth: depth_m,
            }),
            _ => Ok(()),
        }
    }

    /// Checks that a TCP pose violates no plane and no bound of links; whether it can be reached is found by the
    /// planner.
    pub(crate) fn check_target_pose(&self, pose: &RpyPose) -> Result<(), Refusal> {
        if self.has_no_target_bounds() || !pose.is_finite() {
            return Ok(());
        }
        let base_from_tcp = Pose::from_rpy(pose);
        let near = self.next_start();
        match self
            .model
            .inverse_nearest(&base_from_tcp, self.tool.flange_from_tcp(), &near)
        {
            Some(q) => self.check_target(&q),
            None => Ok(()),
        }
    }

    /// A setpoint that is made cycle by cycle: the joints must be able to brake before the planes.
    pub(crate) fn check_planes(&self, wanted: &Setpoint) -> Result<(), StopReason> {
        // A planned motion by itself has been looked at before, and so has what brakes already.
        let is_looked_at = match &self.generator {
            Generator::Path(_) => self.has_no_overlay(),
            Generator::Stop(_) => true,
            Generator::Hold | Generator::Online(_) => false,
        };
        if is_looked_at || self.has_no_planes() {
            return Ok(());
        }
        self.plane_crossed_while_braking(wanted).map_or(Ok(()), Err)
    }

    /// A motion that would go on to `wanted`: it, or the joints, must be able to come to rest before the planes.
    pub(crate) fn check_planes_on_path(
        &self,
        motion: &PathMotion,
        wanted: &Setpoint,
    ) -> Result<(), StopReason> {
        if self.has_no_planes() || !self.has_no_overlay() {
            return Ok(());
        }
        let Some(crossed) = self.plane_crossed_while_braking(wanted) else {
            return Ok(());
        };
        let allowed = |q: &JointPositions| self.plane_crossed_at(q).is_none();
        let ground = self.path_context();
        let halts = |queue: &crate::queue::MotionQueue| {
            queue.stopping_path_satisfies(motion, self.step, &ground, &wanted.q, allowed)
        };
        if allowed(&wanted.q) && halts(&self.queue) {
            return Ok(());
        }
        Err(crossed)
    }

    /// Whether a planned motion must halt on its path because its joints, braking one by one, would cross a plane.
    pub(crate) fn must_halt_on_path(&self) -> bool {
        self.has_no_overlay()
            && self
                .plane_crossed_while_braking(self.commanded.setpoint())
                .is_some()
    }

    /// The first plane crossed while the joints brake one by one from a setpoint.
    pub(crate) fn plane_crossed_while_braking(&self, from: &Setpoint) -> Option<StopReason> {
        let brake = JointStopMotion::new(from, self.limits.able());
        (0..=BRAKE_PLACES).find_map(|place| {
            let share = f64::from(place) / f64::from(BRAKE_PLACES);
            self.plane_crossed_at(&brake.position_at(share))
        })
    }

    /// The plane that the arm at `q` is behind, and deeper than it is now: one that stands behind a plane must be able
    /// to come back.
    fn plane_crossed_at(&self, q: &JointPositions) -> Option<StopReason> {
        let switches = self.plane_switches();
        let violation = |q| {
            let frames = self.model.forward(q);
            self.safety
                .plane_violation(&frames, self.tool.flange_from_tcp(), &switches)
        };
        let Some(SafetyViolation::Plane { plane, depth_m, .. }) = violation(q) else {
            return None;
        };
        if let Some(SafetyViolation::Plane { depth_m: now, .. }) =
            violation(&self.commanded.setpoint().q)
            && depth_m <= now + DEPTH_SLACK
        {
            return None;
        }
        Some(StopReason::SafetyPlane {
            plane: plane as u8,
            depth: depth_m,
        })
    }

    /// The path is all that moves the arm: neither a belt nor an offset nor force mode nor a lag is added to it.
    pub(crate) fn has_no_overlay(&self) -> bool {
        self.tracking.is_none()
            && self.lag.is_none()
            && !self.path_offset.is_on()
            && !self.force.is_active()
    }

    /// Nothing but the arm's own ranges bounds where targets may be.
    pub(crate) fn has_no_target_bounds(&self) -> bool {
        self.has_no_planes() && !self.limits.is_reduced()
    }

    /// Nothing but the ranges of the joints bounds where the arm may be.
    pub(crate) fn has_no_planes(&self) -> bool {
        self.safety.planes().next().is_none()
    }
}
