//! Commands of force mode, and its share of a setpoint.
//!
//! Owns when force mode begins and how it is left, and what is kept between two times: gain and damping. How it moves the
//! arm is in `modes::force`. While it is on, `target` is what the motion underneath asks for and `commanded` what the arm
//! gets; at rest the motion underneath starts from wherever the arm is.

use force::admittance::{DAMPING_RANGE, GAIN_RANGE};
use force::{FrameMode, TaskFrame, Tuning, TwistLimiter};
use kinematics::{JointSpeeds, Pose, RpyPose};
use motion_api::{CommandId, MotionMode, Origin, StopReason};

use crate::config::ConfigError;
use crate::constants::{STOP_ACCELERATION, fault};
use crate::cycle::{Cycle, Generator};
use crate::intake::{Answer, Ending, bad_value};
use crate::modes::force::{ForceGoal, Pressing, Stage, View};
use crate::modes::joint_speed::JointSpeed;
use crate::modes::lag::Lag;
use crate::modes::{CallEnd, Kind, Online, OnlineArm, stands, states};
use crate::setpoint::Setpoint;
use crate::waiting::WaitingFor;

/// Force mode of a controller.
pub(crate) struct ForceMode {
    pub(crate) pressing: Option<Pressing>,
    tuning: Tuning,
    limiter: TwistLimiter,
}

impl ForceMode {
    /// Off, with the gain and the damping of the manual.
    pub(crate) fn new() -> Result<Self, ConfigError> {
        Ok(Self {
            pressing: None,
            tuning: Tuning::default(),
            limiter: TwistLimiter::new()?,
        })
    }

    /// On, and not being left.
    pub(crate) fn is_on(&self) -> bool {
        matches!(&self.pressing, Some(pressing) if pressing.stage == Stage::On)
    }

    /// It changes setpoints: on, or being left.
    pub(crate) const fn is_at_work(&self) -> bool {
        self.pressing.is_some()
    }
}

impl Cycle {
    pub(crate) fn force_mode(
        &mut self,
        frame: &RpyPose,
        selection: [bool; 6],
        wrench: [f64; 6],
        mode: u8,
        speed_limits: [f64; 6],
    ) -> Answer {
        let Some(mode_kind) = FrameMode::from_number(mode.into()) else {
            return Err(bad_value("mode", f64::from(mode), "0 to 3"));
        };
        let goal = ForceGoal {
            frame: TaskFrame::new(mode_kind, Pose::from_rpy(frame)),
            selection,
            wrench,
            speed_limits,
        };
        self.lag = None;
        match &mut self.force.pressing {
            Some(pressing) => pressing.retarget(goal),
            none => *none = Some(Pressing::new(goal)),
        }
        Ok(Ending::Now)
    }

    pub(crate) fn set_force_gain(&mut self, gain: f64) -> Answer {
        if !(GAIN_RANGE.0..=GAIN_RANGE.1).contains(&gain) {
            return Err(bad_value("scaling", gain, "0 to 2"));
        }
        self.force.tuning.gain = gain;
        Ok(Ending::Now)
    }

    pub(crate) fn set_force_damping(&mut self, damping: f64) -> Answer {
        if !(DAMPING_RANGE.0..=DAMPING_RANGE.1).contains(&damping) {
            return Err(bad_value("damping", damping, "0 to 1"));
        }
        self.force.tuning.damping = damping;
        Ok(Ending::Now)
    }

    /// Ends force mode. At rest the arm stops where it is; under a motion that goes on, the tool goes back to it.
    pub(crate) fn end_force_mode(&mut self, id: CommandId) -> Ending {
        if self.force.pressing.is_none() {
            return Ending::Now;
        }
        if self.is_holding() {
            self.finish_force_mode();
            if self.is_standing() {
                return Ending::Now;
            }
            self.waiting.add(id, WaitingFor::Stop);
            return Ending::Later;
        }
        let nominal = self.model.tcp_pose(&self.target.q, &self.flange_from_tcp);
        let commanded = self.target_frames.base_from_flange * self.flange_from_tcp;
        if let Some(pressing) = &mut self.force.pressing {
            pressing.give_back(&nominal, &commanded);
        }
        Ending::Now
    }

    /// From here on the joints come to rest from what they do now.
    fn finish_force_mode(&mut self) {
        self.force.pressing = None;
        self.lag = None;
        self.target = self.commanded;
        if stands(&self.target) {
            return;
        }
        let now = states(&self.target);
        let brake = JointSpeed::new(&now, &JointSpeeds::ZERO, STOP_ACCELERATION);
        self.generator = Generator::Online(Online {
            id: CommandId::NONE,
            origin: Origin::default(),
            mode: MotionMode::Stopping,
            call: CallEnd::Over,
            kind: Kind::JointSpeed(brake),
            is_stopping: true,
            is_warned: true,
        });
    }

    /// Nothing moves underneath, and nothing is about to.
    pub(crate) fn is_holding(&self) -> bool {
        matches!(self.generator, Generator::Hold)
            && self.upcoming.is_none()
            && self.deferred.is_none()
    }

    /// The setpoint of the motion underneath with the corrections of force mode.
    pub(crate) fn pressed(&mut self, nominal: &Setpoint) -> Result<Setpoint, StopReason> {
        let Some(mut pressing) = self.force.pressing else {
            return Ok(*nominal);
        };
        let felt = self.felt();
        let is_holding = matches!(self.generator, Generator::Hold);
        let arm = OnlineArm::new(
            &self.model,
            &self.flange_from_tcp,
            [self.limit_sets.checked(); 2],
            &self.dynamics,
            &self.commanded,
            felt,
            self.step,
            (self.fraction(), self.is_held()),
        );
        let view = View {
            arm: &arm,
            commanded: &self.commanded,
            commanded_frames: &self.target_frames,
            nominal_before: &self.target,
            nominal,
            actual: &self.actual.q,
            felt,
            tuning: self.force.tuning,
            tcp_speed: self.limits.tcp_speed,
            is_frozen: self.fraction() == 0.0,
            is_holding,
        };
        let next = pressing.next(&view, &mut self.force.limiter);
        self.force.pressing = Some(pressing);
        next.map_err(|_| StopReason::Internal {
            code: fault::NOT_FINITE,
        })
    }

    /// Ends force mode once the tool is back or the motion is over. At rest the motion underneath begins at the arm.
    pub(crate) fn settle_force_mode(&mut self) {
        if self.holding.is_some() && !stands(&self.commanded) {
            return;
        }
        let Some(pressing) = &self.force.pressing else {
            return;
        };
        if pressing.is_back() {
            self.force.pressing = None;
            self.lag = Lag::between(&self.commanded, &self.target, self.step, false);
        } else if self.is_holding() {
            if pressing.stage == Stage::On {
                self.target = Setpoint::standing(self.commanded.q);
            } else {
                self.finish_force_mode();
            }
        }
    }
}
