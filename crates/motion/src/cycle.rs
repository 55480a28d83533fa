//! One control period of the arm: commands in, one setpoint, one state and one cycle record out.
//!
//! Owns the order of the steps and the state they share. Knows no script, no socket and no clock: whoever calls
//! [`Cycle::tick`] decides what time is. Allocates nothing, locks nothing, waits for nothing, logs nothing.

use kinematics::chain::Frames;
use kinematics::{Dynamics, JointPositions, Payload, Pose, RobotModel, RpyPose};
use motion_api::{Command, CommandId, MotionEnd, Outcome, RobotMode, SafetyMode, StopReason};
use nalgebra::Vector3;
use rtrb::Consumer;

use crate::brake::JointBrake;
use crate::config::{ConfigError, CycleConfig, MotionLimits};
use crate::constants::{RESTING_SPEED, SLOWEST_FRACTION, TRACKING_LIMIT, fault};
use crate::machine::Machine;
use crate::motion::Motion;
use crate::outbox::Outbox;
use crate::plant::{ArmState, Plant};
use crate::report::report;
use crate::setpoint::{LimitedSetpoint, Setpoint, limit};
use crate::upcoming::Upcoming;
use crate::waiting::{Waiting, WaitingFor};

/// What the caller measured about the cycles; zeros under the virtual clock.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Timing {
    /// How long the previous tick took, µs.
    pub step_duration_us: f64,
    /// How late this tick began, µs.
    pub wakeup_latency_us: f64,
}

/// Where setpoints come from.
#[allow(
    clippy::large_enum_variant,
    reason = "lives in place for the life of the controller; the cycle must not allocate"
)]
pub(crate) enum Generator {
    /// The arm stands at the target.
    Hold,
    /// A motion is under way, or held on its path.
    Path(Motion),
    /// A protective stop brakes the joints.
    Brake(JointBrake),
}

/// The controller of one arm.
pub struct Cycle {
    pub(crate) model: RobotModel,
    pub(crate) limits: MotionLimits,
    pub(crate) step: f64,
    pub(crate) gravity: Vector3<f64>,

    pub(crate) commands: Consumer<Command>,
    pub(crate) out: Outbox,

    pub(crate) machine: Machine,
    pub(crate) generator: Generator,
    /// The next motion, until it begins.
    pub(crate) upcoming: Option<Upcoming>,
    pub(crate) waiting: Waiting,
    pub(crate) is_paused: bool,
    pub(crate) speed_fraction: f64,
    pub(crate) digital_out: u64,

    pub(crate) tcp: RpyPose,
    pub(crate) flange_from_tcp: Pose,
    pub(crate) payload: Payload,
    pub(crate) dynamics: Dynamics,

    pub(crate) target: Setpoint,
    pub(crate) target_frames: Frames,
    pub(crate) plant: Plant,
    pub(crate) actual: ArmState,
}

impl Cycle {
    /// A controller whose arm stands at home, and its snapshot published as cycle 0.
    ///
    /// # Errors
    /// [`ConfigError`] names what is wrong with the configuration or the border.
    pub fn new(config: CycleConfig, border: MotionEnd) -> Result<Self, ConfigError> {
        let limits = config.resolve()?;
        let (commands, out) = Outbox::new(border)?;
        let machine = Machine::new(config.robot_mode());
        let model = config
            .model
            .clone()
            .with_limits(limits.narrowed(config.model.limits()));
        let dynamics = model.dynamics(&config.payload, config.gravity);
        let mut plant = Plant::new(
            config.plant,
            &model,
            &dynamics,
            &config.gravity,
            &config.home,
        )?;
        let actual = plant.stand(&dynamics);
        let mut cycle = Self {
            limits,
            step: config.step_time,
            gravity: config.gravity,
            commands,
            out,
            machine,
            generator: Generator::Hold,
            upcoming: None,
            waiting: Waiting::default(),
            is_paused: false,
            speed_fraction: 1.0,
            digital_out: 0,
            tcp: config.tcp,
            flange_from_tcp: Pose::from_rpy(&config.tcp),
            payload: config.payload,
            dynamics,
            target: Setpoint::standing(config.home),
            target_frames: model.forward(&config.home),
            plant,
            actual,
            model,
        };
        let first = report(&cycle, Timing::default());
        cycle.out.publish_first(&first);
        Ok(cycle)
    }

    /// One control period. Takes what waits in the command ring, moves the arm by one step, and puts out exactly one
    /// cycle record, one snapshot and the events.
    pub fn tick(&mut self, timing: Timing) {
        self.out.cycle += 1;
        self.take_commands();
        let wanted = self.generate();
        let limited = self.limit(wanted);
        self.move_arm(&limited);
        self.check_arm();
        self.settle();
        let state = report(self, timing);
        self.out.publish(&state);
    }

    /// The generator's setpoint, or why there is none.
    fn generate(&mut self) -> Result<Setpoint, StopReason> {
        let fraction = if self.is_paused || self.speed_fraction < SLOWEST_FRACTION {
            0.0
        } else {
            self.speed_fraction
        };
        self.plan_on();
        match &mut self.generator {
            Generator::Hold => Ok(Setpoint::standing(self.target.q)),
            Generator::Brake(brake) => Ok(brake.next(self.step)),
            Generator::Path(motion) => motion
                .next(self.step, fraction, &self.model, &self.target.q)
                .ok_or(StopReason::Internal {
                    code: fault::PATH_LOST,
                }),
        }
    }

    /// The setpoint that the arm gets: the wanted one, or the first of a protective stop.
    fn limit(&mut self, wanted: Result<Setpoint, StopReason>) -> LimitedSetpoint {
        let checked = wanted.and_then(|wanted| {
            if matches!(self.generator, Generator::Brake(_)) {
                let braking = LimitedSetpoint::while_braking(wanted, &self.target, &self.limits);
                self.target_frames = self.model.forward(&braking.get().q);
                return Ok(braking);
            }
            let frames = self.model.forward(&wanted.q);
            let tcp = (frames.base_from_flange * self.flange_from_tcp).translation;
            let passed = limit(wanted, &self.target, &frames, tcp, self.step, &self.limits)?;
            self.target_frames = frames;
            Ok(passed)
        });
        checked.unwrap_or_else(|reason| {
            let mut brake = self.protective_stop(reason);
            let first = brake.next(self.step);
            self.generator = Generator::Brake(brake);
            let braking = LimitedSetpoint::while_braking(first, &self.target, &self.limits);
            self.target_frames = self.model.forward(&braking.get().q);
            braking
        })
    }

    /// Moves the plant by one step.
    fn move_arm(&mut self, limited: &LimitedSetpoint) {
        if self.is_under_servo() {
            self.actual = self.plant.follow(limited, &self.dynamics, self.step);
            self.target = *limited.get();
        } else {
            self.actual = self.plant.stand(&self.dynamics);
            self.stand_at_actual();
        }
    }

    /// Does the arm follow?
    fn check_arm(&mut self) {
        if !self.actual.is_finite() {
            self.plant.reset(&self.target.q);
            self.actual = self.plant.stand(&self.dynamics);
            self.brake(StopReason::Internal {
                code: fault::PLANT_DIVERGED,
            });
        }
        if !self.machine.safety_mode().allows_motion() {
            return;
        }
        for (joint, number) in (0u8..6).enumerate() {
            let error = (self.actual.q[joint] - self.target.q[joint]).abs();
            if error > TRACKING_LIMIT {
                self.brake(StopReason::TrackingError {
                    joint: number,
                    error,
                    limit: TRACKING_LIMIT,
                });
                return;
            }
        }
    }

    /// Ends what has come to its end in this cycle.
    fn settle(&mut self) {
        match &self.generator {
            Generator::Path(motion) if motion.is_stopping && motion.is_standing() => {
                if !motion.is_handed_over {
                    self.out.ended(motion.id, Outcome::Aborted);
                }
                self.generator = Generator::Hold;
            }
            Generator::Path(motion) if motion.is_finished() => {
                if !motion.is_handed_over {
                    self.out.ended(motion.id, Outcome::Done);
                }
                self.generator = Generator::Hold;
            }
            Generator::Path(motion)
                if motion.is_in_zone() && !motion.is_stopping && !motion.is_handed_over =>
            {
                self.out.ended(motion.id, Outcome::Done);
                if let Generator::Path(motion) = &mut self.generator {
                    motion.is_handed_over = true;
                }
            }
            Generator::Brake(brake)
                if brake.has_settled(self.actual.qd.max_abs() < RESTING_SPEED) =>
            {
                // The arm may have been held up: from now on it is wanted where it stands, and the brakes hold it there.
                self.generator = Generator::Hold;
                self.stand_at_actual();
            }
            _ => {}
        }
        if !self.is_standing() {
            return;
        }
        if self.waiting.includes(WaitingFor::PowerOff) {
            self.machine.power_off();
        }
        while let Some(id) = self.waiting.take(|_| true) {
            self.out.ended(id, Outcome::Done);
        }
    }

    /// Enters a protective stop that begins with the next setpoint.
    fn brake(&mut self, reason: StopReason) {
        let brake = self.protective_stop(reason);
        self.generator = Generator::Brake(brake);
    }

    /// Reports a protective stop, ends the motion with it, and gives the braking from the present target.
    fn protective_stop(&mut self, reason: StopReason) -> JointBrake {
        if self.machine.protective_stop(reason) {
            self.out.stopped(reason);
        }
        let running = self.running();
        if running != CommandId::NONE {
            self.out.ended(running, Outcome::ProtectiveStop(reason));
        }
        self.is_paused = false;
        self.upcoming = None;
        JointBrake::new(&self.target, &self.limits)
    }

    /// The servos hold the arm, not the brakes: those do without power, and at the end of a protective stop.
    pub(crate) fn is_under_servo(&self) -> bool {
        self.machine.is_under_servo()
            && (self.machine.safety_mode() != SafetyMode::ProtectiveStop
                || matches!(self.generator, Generator::Brake(_)))
    }

    /// The target becomes the place where the arm is.
    pub(crate) fn stand_at_actual(&mut self) {
        self.target = Setpoint::standing(self.actual.q);
        self.plant.retarget(&self.target.q);
        self.target_frames = self.model.forward(&self.target.q);
    }

    /// True when no setpoint moves: nothing to do, or held on the path.
    pub fn is_standing(&self) -> bool {
        match &self.generator {
            Generator::Hold => self.upcoming.is_none(),
            Generator::Path(motion) => motion.is_standing(),
            Generator::Brake(_) => false,
        }
    }

    /// The motion command that has not ended yet. One that ended by entering its blend zone is none, though the arm moves.
    pub(crate) fn running(&self) -> CommandId {
        match (&self.upcoming, &self.generator) {
            (Some(upcoming), _) => upcoming.id,
            (None, Generator::Path(motion)) if !motion.is_handed_over => motion.id,
            _ => CommandId::NONE,
        }
    }

    /// Where the next motion begins: where the arm stands, or the waypoint in whose blend zone it is.
    pub(crate) fn next_start(&self) -> JointPositions {
        match &self.generator {
            Generator::Path(motion) => motion.end(),
            _ => self.target.q,
        }
    }

    /// Brings a moving arm to rest on its path, as a stop command would; for the end of the controller.
    pub fn stop_moving(&mut self) {
        if let Some(upcoming) = self.upcoming.take() {
            self.out.ended(upcoming.id, Outcome::Aborted);
        }
        if let Generator::Path(motion) = &mut self.generator {
            motion.is_stopping = true;
        }
    }

    /// Length of a cycle, s.
    pub fn step_time(&self) -> f64 {
        self.step
    }

    /// Places free for records: `None` when nobody takes any.
    pub fn record_room(&self) -> Option<usize> {
        self.out.record_room()
    }

    /// Size of the record ring, if there is one.
    pub fn record_capacity(&self) -> Option<usize> {
        self.out.record_capacity()
    }

    /// True when the brakes hold the arm.
    pub(crate) fn has_brakes_engaged(&self) -> bool {
        self.machine.robot_mode() != RobotMode::Running
    }
}
