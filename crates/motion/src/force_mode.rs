//! Commands of force mode, and its share of a setpoint.
//!
//! Owns when force mode begins and how it is left, and what is kept between two times: gain and damping. How it moves
//! the arm is in `modes::force`. While it is on, `target` is what the motion underneath asks for and `commanded` what
//! the arm gets; at rest the motion underneath starts from wherever the arm is.

use force::admittance::{DAMPING_RANGE, GAIN_RANGE};
use force::{FrameMode, TaskFrame, Tuning, TwistLimiter};
use kinematics::{JointSpeeds, Pose, RpyPose};
use motion_api::{CommandId, MotionMode, Origin, StopReason, phrase};

use crate::config::ConfigError;
use crate::constants::{STOP_ACCELERATION, fault};
use crate::cycle::{ControlLoop, Generator};
use crate::intake::{CommandResult, Completion, bad_value};
use crate::modes::force::{ActiveForceMode, ForceGoal, ForceModeInput, ForceModePhase};
use crate::modes::joint_speed::JointSpeedMode;
use crate::modes::lag::JointLag;
use crate::modes::{
    ActiveOnlineMode, CallCompletion, OnlineContext, OnlineMode, is_setpoint_at_rest, states,
};
use crate::setpoint::Setpoint;
use crate::waiting::RestCommand;

/// Force mode of a controller.
pub(crate) struct ForceMode {
    pub(crate) active: Option<ActiveForceMode>,
    tuning: Tuning,
    limiter: TwistLimiter,
}

impl ForceMode {
    /// Off, with the gain and the damping of the manual.
    pub(crate) fn new() -> Result<Self, ConfigError> {
        Ok(Self {
            active: None,
            tuning: Tuning::default(),
            limiter: TwistLimiter::new()?,
        })
    }

    /// On, and not being left.
    pub(crate) fn is_on(&self) -> bool {
        matches!(&self.active, Some(pressing) if pressing.stage == ForceModePhase::On)
    }

    /// True while force mode changes setpoints: when it is on, or being left.
    pub(crate) const fn is_active(&self) -> bool {
        self.active.is_some()
    }
}

impl ControlLoop {
    pub(crate) fn force_mode(
        &mut self,
        frame: &RpyPose,
        selection: [bool; 6],
        wrench: [f64; 6],
        mode: u8,
        speed_limits: [f64; 6],
    ) -> CommandResult {
        let Some(mode_kind) = FrameMode::from_number(mode.into()) else {
            return Err(bad_value(
                phrase!("mode"),
                f64::from(mode),
                phrase!("0 to 3", "0 到 3"),
            ));
        };
        let goal = ForceGoal {
            frame: TaskFrame::new(mode_kind, Pose::from_rpy(frame)),
            selection,
            wrench,
            speed_limits,
        };
        self.lag = None;
        match &mut self.force.active {
            Some(pressing) => pressing.retarget(goal),
            none => *none = Some(ActiveForceMode::new(goal)),
        }
        Ok(Completion::Immediate)
    }

    pub(crate) fn set_force_gain(&mut self, gain: f64) -> CommandResult {
        if !(GAIN_RANGE.0..=GAIN_RANGE.1).contains(&gain) {
            return Err(bad_value(
                phrase!("scaling"),
                gain,
                phrase!("0 to 2", "0 到 2"),
            ));
        }
        self.force.tuning.gain = gain;
        Ok(Completion::Immediate)
    }

    pub(crate) fn set_force_damping(&mut self, damping: f64) -> CommandResult {
        if !(DAMPING_RANGE.0..=DAMPING_RANGE.1).contains(&damping) {
            return Err(bad_value(
                phrase!("damping"),
                damping,
                phrase!("0 to 1", "0 到 1"),
            ));
        }
        self.force.tuning.damping = damping;
        Ok(Completion::Immediate)
    }

    /// Ends force mode. At rest the arm stops where it is; under a motion that goes on, the tool goes back to it.
    pub(crate) fn end_force_mode(&mut self, id: CommandId) -> Completion {
        if self.force.active.is_none() {
            return Completion::Immediate;
        }
        if self.is_holding() {
            self.finish_force_mode();
            if self.is_standing() {
                return Completion::Immediate;
            }
            self.rest_commands.add(id, RestCommand::Stop);
            return Completion::Deferred;
        }
        let nominal = self
            .model
            .tcp_pose(&self.target.q, self.tool.flange_from_tcp());
        let commanded = self.tool.base_from_tcp(self.commanded.frames());
        if let Some(pressing) = &mut self.force.active {
            pressing.begin_return(&nominal, &commanded);
        }
        Completion::Immediate
    }

    /// From here on the joints come to rest from what they do now.
    fn finish_force_mode(&mut self) {
        self.force.active = None;
        self.lag = None;
        self.target = *self.commanded.setpoint();
        if is_setpoint_at_rest(&self.target) {
            return;
        }
        let now = states(&self.target);
        let brake = JointSpeedMode::new(&now, &JointSpeeds::ZERO, STOP_ACCELERATION);
        self.generator = Generator::Online(ActiveOnlineMode {
            id: CommandId::NONE,
            origin: Origin::default(),
            mode: MotionMode::Stopping,
            call_completion: CallCompletion::Returned,
            kind: OnlineMode::JointSpeed(brake),
            is_stopping: true,
            is_warned: true,
        });
    }

    /// Nothing moves underneath, and nothing is about to.
    pub(crate) fn is_holding(&self) -> bool {
        matches!(self.generator, Generator::Hold)
            && self.pending_motion.is_none()
            && self.deferred.is_none()
    }

    /// The setpoint of the motion underneath with the corrections of force mode.
    pub(crate) fn apply_force_mode(&mut self, nominal: &Setpoint) -> Result<Setpoint, StopReason> {
        let Some(mut pressing) = self.force.active else {
            return Ok(*nominal);
        };
        let felt = self.sensed_wrench();
        let is_holding = matches!(self.generator, Generator::Hold);
        let arm = OnlineContext::new(
            &self.model,
            self.tool.flange_from_tcp(),
            [self.limits.enforced(); 2],
            self.load.dynamics(),
            self.commanded.setpoint(),
            felt,
            self.step,
            (self.speed_fraction_in_effect(), self.is_held()),
            self.micro_points.points(),
        );
        let view = ForceModeInput {
            arm: &arm,
            commanded: self.commanded.setpoint(),
            commanded_frames: self.commanded.frames(),
            history: self.commanded.history(),
            nominal_before: &self.target,
            nominal,
            actual: &self.actual.state().q,
            sensed_wrench: felt,
            tuning: self.force.tuning,
            tcp_speed: self.limits.in_force().tcp_speed,
            is_frozen: self.speed_fraction_in_effect() == 0.0,
            is_holding,
        };
        let next = pressing.next(&view, &mut self.force.limiter);
        self.force.active = Some(pressing);
        next.map_err(|_| StopReason::Internal {
            code: fault::NOT_FINITE,
        })
    }

    /// Ends force mode once the tool is back or the motion is over. At rest the motion underneath begins at the arm.
    pub(crate) fn settle_force_mode(&mut self) {
        if self.joint_hold.is_some() && !is_setpoint_at_rest(self.commanded.setpoint()) {
            return;
        }
        let Some(pressing) = &self.force.active else {
            return;
        };
        if pressing.has_returned() {
            self.force.active = None;
            self.lag = JointLag::between(self.commanded.setpoint(), &self.target, self.step, false);
        } else if self.is_holding() {
            if pressing.stage == ForceModePhase::On {
                self.target = Setpoint::standing(self.commanded.setpoint().q);
            } else {
                self.finish_force_mode();
            }
        }
    }
}
