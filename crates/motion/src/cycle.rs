//! One control period of the arm: commands in, one setpoint, one state and one cycle record out.
//!
//! Owns the order of the steps and the state they share. Knows no script, no socket and no clock: whoever calls
//! [`Cycle::tick`] decides what time is. Allocates nothing, locks nothing, waits for nothing, logs nothing.

use kinematics::chain::Frames;
use kinematics::safety::{PlaneSwitches, SafetyBounds, SafetyViolation};
use kinematics::{Dynamics, JointPositions, Payload, Pose, RobotModel, RpyPose, Wrench};
use motion_api::{Command, CommandId, MotionEnd, Outcome, RobotMode, SafetyMode, StopReason};
use nalgebra::Vector3;
use rtrb::Consumer;

use crate::brake::JointBrake;
use crate::collision::{CollisionDetection, torques_of};
use crate::config::{ConfigError, CycleConfig, MotionLimits};
use crate::constants::{RESTING_SPEED, SHARE_ON_BELT, SLOWEST_FRACTION, TRACKING_LIMIT, fault};
use crate::contact::Contacts;
use crate::external::External;
use crate::force_mode::ForceMode;
use crate::io::Io;
use crate::machine::Machine;
use crate::micro_points::MicroPoints;
use crate::modes::conveyor::Tracking;
use crate::modes::encoder::Encoder;
use crate::modes::{Kind, Online, stands};
use crate::motion::Motion;
use crate::outbox::Outbox;
use crate::path::Ground;
use crate::plant::{ArmState, Plant, Push};
use crate::report::report;
use crate::safety_inputs::SafetyInputs;
use crate::sensor::Sensor;
use crate::setpoint::{LimitedSetpoint, Setpoint, limit};
use crate::thermal::Thermal;
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
    /// An online mode makes each setpoint from the one before.
    Online(Online),
    /// A protective stop brakes the joints.
    Brake(JointBrake),
}

/// The controller of one arm.
pub struct Cycle {
    pub(crate) model: RobotModel,
    pub(crate) limits: MotionLimits,
    /// What planned motions may use while a belt uses the rest.
    pub(crate) limits_on_belt: MotionLimits,
    pub(crate) step: f64,
    pub(crate) gravity: Vector3<f64>,

    pub(crate) commands: Consumer<Command>,
    pub(crate) out: Outbox,

    pub(crate) machine: Machine,
    pub(crate) generator: Generator,
    safety_inputs: SafetyInputs,
    /// The next motion, until it begins.
    pub(crate) upcoming: Option<Upcoming>,
    pub(crate) waiting: Waiting,
    pub(crate) is_paused: bool,
    pub(crate) speed_fraction: f64,
    pub(crate) io: Io,

    pub(crate) tcp: RpyPose,
    pub(crate) flange_from_tcp: Pose,
    pub(crate) payload: Payload,
    pub(crate) dynamics: Dynamics,

    /// What the generator asks for; the same as `commanded` unless a conveyor is tracked or force mode is on.
    pub(crate) target: Setpoint,
    /// What the arm gets.
    pub(crate) commanded: Setpoint,
    pub(crate) target_frames: Frames,
    pub(crate) plant: Plant,
    pub(crate) contacts: Contacts,
    pub(crate) actual: ArmState,

    /// The points of the next moveml, or of the one under way.
    pub(crate) micro_points: MicroPoints,
    /// A planned motion that waits for an online mode to come to rest.
    pub(crate) deferred: Option<Command>,
    pub(crate) tracking: Option<Tracking>,
    pub(crate) encoders: [Encoder; 2],
    pub(crate) external: External,
    /// What acts on the tool in this cycle: base axes, about the TCP.
    pub(crate) hand: Wrench,
    pub(crate) force: ForceMode,
    pub(crate) sensor: Sensor,
    pub(crate) collision: CollisionDetection,
    pub(crate) safety: SafetyBounds,
    pub(crate) thermal: Thermal,
}

impl Cycle {
    /// A controller whose arm stands at home, and its snapshot published as cycle 0.
    ///
    /// # Errors
    /// [`ConfigError`] names what is wrong with the configuration or the border.
    pub fn new(config: CycleConfig, border: MotionEnd) -> Result<Self, ConfigError> {
        let limits = config.resolve()?;
        let io = Io::new(&config.io, config.step_time, border.registers.clone());
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
        let contacts = Contacts::new(config.surroundings, &model, &config.home);
        let flange_from_tcp = Pose::from_rpy(&config.tcp);
        plant.push(&Push {
            flange_from_tcp,
            ..Push::default()
        });
        let actual = plant.stand(&dynamics, &contacts);
        let is_powered = machine.robot_mode() != RobotMode::PowerOff;
        let mut cycle = Self {
            limits_on_belt: limits.shared(SHARE_ON_BELT),
            micro_points: MicroPoints::new(),
            deferred: None,
            tracking: None,
            encoders: config.belts.map(Encoder::new),
            external: External::new(config.loads),
            hand: Wrench::default(),
            force: ForceMode::new()?,
            sensor: Sensor::new(config.sensor_noise),
            collision: CollisionDetection::default(),
            safety: config.safety,
            thermal: Thermal::new(is_powered),
            commanded: Setpoint::standing(config.home),
            limits,
            step: config.step_time,
            gravity: config.gravity,
            commands,
            out,
            machine,
            generator: Generator::Hold,
            safety_inputs: config.safety_inputs,
            upcoming: None,
            waiting: Waiting::default(),
            is_paused: false,
            speed_fraction: 1.0,
            io,
            tcp: config.tcp,
            flange_from_tcp,
            payload: config.payload,
            dynamics,
            target: Setpoint::standing(config.home),
            target_frames: model.forward(&config.home),
            plant,
            contacts,
            actual,
            model,
        };
        cycle.measure_force();
        let first = report(&cycle, Timing::default());
        cycle.out.publish_first(&first);
        Ok(cycle)
    }

    /// One control period. Takes what waits in the command ring, moves the arm by one step, and puts out exactly one
    /// cycle record, one snapshot and the events.
    pub fn tick(&mut self, timing: Timing) {
        self.out.cycle += 1;
        self.take_commands();
        // After the commands: a register written before a command was sent is seen no later than the command.
        self.out.registers(self.io.sample_registers());
        self.io.advance(self.out.cycle as f64 * self.step);
        self.follow_input_actions();
        self.advance_machine();
        self.feel_hand();
        let wanted = self.generate();
        let limited = self.limit(wanted);
        self.move_arm(&limited);
        self.measure();
        self.check_arm();
        self.settle();
        let state = report(self, timing);
        let registers = || self.io.registers();
        self.out.publish(&state, registers);
    }

    /// The generator's setpoint, or why there is none.
    fn generate(&mut self) -> Result<Setpoint, StopReason> {
        let fraction = self.fraction();
        if matches!(self.generator, Generator::Online(_)) {
            return Ok(self.generate_online());
        }
        self.plan_on();
        let ground = Ground {
            model: &self.model,
            points: self.micro_points.points(),
        };
        match &mut self.generator {
            Generator::Hold | Generator::Online(_) => Ok(Setpoint::standing(self.target.q)),
            Generator::Brake(brake) => Ok(brake.next(self.step)),
            Generator::Path(motion) => motion
                .next(self.step, fraction, &ground, &self.target.q)
                .ok_or(StopReason::Internal {
                    code: fault::PATH_LOST,
                }),
        }
    }

    /// The setpoint that the arm gets: the wanted one, or the first of a protective stop.
    fn limit(&mut self, wanted: Result<Setpoint, StopReason>) -> LimitedSetpoint {
        let checked = wanted.and_then(|wanted| {
            if matches!(self.generator, Generator::Brake(_)) {
                let braking = LimitedSetpoint::while_braking(wanted, &self.commanded, &self.limits);
                self.target_frames = self.model.forward(&braking.get().q);
                return Ok(braking);
            }
            let nominal = wanted;
            let wanted = self.carried(&nominal)?;
            let wanted = self.pressed(&wanted)?;
            let frames = self.model.forward(&wanted.q);
            let tcp = (frames.base_from_flange * self.flange_from_tcp).translation;
            let before = &self.commanded;
            let passed = limit(wanted, before, &frames, tcp, self.step, &self.limits)?;
            self.check_planes(&wanted)?;
            self.target_frames = frames;
            self.target = nominal;
            Ok(passed)
        });
        checked.unwrap_or_else(|reason| {
            let mut brake = self.protective_stop(reason);
            let first = brake.next(self.step);
            self.generator = Generator::Brake(brake);
            let braking = LimitedSetpoint::while_braking(first, &self.commanded, &self.limits);
            self.target_frames = self.model.forward(&braking.get().q);
            braking
        })
    }

    /// Moves the plant by one step.
    fn move_arm(&mut self, limited: &LimitedSetpoint) {
        if self.is_under_servo() {
            self.actual = self
                .plant
                .follow(limited, &self.dynamics, &self.contacts, self.step);
            self.commanded = *limited.get();
            if self.tracking.is_none() && !self.force.is_at_work() {
                self.target = self.commanded;
            }
        } else {
            self.actual = self.plant.stand(&self.dynamics, &self.contacts);
            self.stand_at_actual();
        }
    }

    /// Does the arm follow?
    fn check_arm(&mut self) {
        if !self.actual.is_finite() {
            self.plant.reset(&self.commanded.q);
            self.sensor.restart();
            self.actual = self.plant.stand(&self.dynamics, &self.contacts);
            self.brake(StopReason::Internal {
                code: fault::PLANT_DIVERGED,
            });
        }
        if self.machine.stop_reason().is_some() {
            return;
        }
        for (joint, number) in (0u8..6).enumerate() {
            let error = (self.actual.q[joint] - self.commanded.q[joint]).abs();
            if error > TRACKING_LIMIT {
                self.brake(StopReason::TrackingError {
                    joint: number,
                    error,
                    limit: TRACKING_LIMIT,
                });
                return;
            }
        }
        let limit = self.limits.tcp_force;
        if let Some(force) = self.sensor.exceeds(limit)
            && self.is_under_servo()
            && !self.is_led()
        {
            self.brake(StopReason::TcpForce { force, limit });
            return;
        }
        if let Some(reason) = self.collision_found() {
            self.brake(reason);
        }
    }

    /// Somebody leads the arm by hand.
    fn is_led(&self) -> bool {
        matches!(
            &self.generator,
            Generator::Online(online) if matches!(online.kind, Kind::Freedrive(_))
        )
    }

    /// A collision, unless the hand that leads the arm is what is felt.
    fn collision_found(&self) -> Option<StopReason> {
        if self.is_led() || !self.is_under_servo() {
            return None;
        }
        let frames = self.model.forward(&self.actual.q);
        let tcp = frames.base_from_flange * self.flange_from_tcp;
        let effort = &self.model.limits().effort;
        let is_pressing = self.force.is_at_work();
        self.collision.collision(effort, is_pressing, &frames, &tcp)
    }

    /// The wrench on the tool in this cycle, and the plant's share of it.
    fn feel_hand(&mut self) {
        let frames = self.model.forward(&self.actual.q);
        let tcp = frames.base_from_flange * self.flange_from_tcp;
        let time = self.out.cycle as f64 * self.step;
        self.hand = self
            .external
            .at(time, &frames.base_from_flange, &tcp, &self.gravity);
        self.plant.push(&Push {
            wrench: self.hand,
            flange_from_tcp: self.flange_from_tcp,
        });
    }

    /// What the force sensor said at the end of the last cycle, compensated: what the environment applies to the tool, base
    /// axes, about the TCP.
    /// Freedrive and force mode follow this reading.
    pub(crate) const fn felt(&self) -> Wrench {
        self.sensor.felt
    }

    /// What sensors say at the end of the cycle: force, encoders, collision observer, temperatures.
    fn measure(&mut self) {
        self.measure_force();
        let time = self.out.cycle as f64 * self.step;
        for encoder in &mut self.encoders {
            encoder.sample(time, self.io.image.digital_in.into());
        }
        if self.is_under_servo() && self.actual.is_finite() {
            let frames = self.model.forward(&self.actual.q);
            let tcp = frames.base_from_flange * self.flange_from_tcp;
            let at_tool = torques_of(&self.environment(), &frames, &tcp);
            self.collision
                .observe(&self.actual, &at_tool, &self.dynamics, self.step);
            if self.force.is_at_work() {
                self.collision.press_on_purpose();
            }
        } else {
            self.collision.stand();
            self.sensor.stand();
        }
        let is_powered = self.machine.robot_mode() != RobotMode::PowerOff;
        let torque = if self.is_under_servo() {
            self.actual.torque
        } else {
            kinematics::JointTorques::ZERO
        };
        let effort = &self.model.limits().effort;
        self.thermal.pass(&torque, effort, is_powered, self.step);
    }

    /// What hand, loads and obstacles did to the tool: base axes, about the TCP.
    fn environment(&self) -> Wrench {
        let contact = &self.actual.contact;
        Wrench {
            force: self.hand.force + contact.force,
            moment: self.hand.moment + contact.moment,
        }
    }

    fn measure_force(&mut self) {
        if !self.actual.is_finite() {
            return;
        }
        let environment = self.environment();
        let frames = self.model.forward(&self.actual.q);
        self.sensor.measure(
            &environment,
            &self.payload,
            (&frames, &self.actual.qd),
            &self.flange_from_tcp,
            &self.gravity,
            self.step,
        );
    }

    /// Which safety planes count now: by mode, and by pairs of configurable inputs (bits 16 to 23) that are both high.
    pub(crate) fn plane_switches(&self) -> PlaneSwitches {
        PlaneSwitches {
            reduced: self.machine.safety_mode() == SafetyMode::Reduced,
            ci_pairs: core::array::from_fn(|pair| {
                self.io.image.digital_in >> (16 + 2 * pair) & 3 == 3
            }),
        }
    }

    /// Would the arm, braking from `wanted`, come to rest behind a safety plane, and deeper than it is now?
    fn check_planes(&self, wanted: &Setpoint) -> Result<(), StopReason> {
        if self.safety.planes().next().is_none() {
            return Ok(());
        }
        let switches = self.plane_switches();
        let violation = |q| {
            let frames = self.model.forward(q);
            self.safety
                .plane_violation(&frames, &self.flange_from_tcp, &switches)
        };
        let end = JointBrake::new(wanted, &self.limits).end();
        let Some(SafetyViolation::Plane { plane, depth_m, .. }) = violation(&end) else {
            return Ok(());
        };
        // An arm that stands behind a plane already must be able to come back.
        if let Some(SafetyViolation::Plane { depth_m: now, .. }) = violation(&self.commanded.q)
            && depth_m <= now + 1e-9
        {
            return Ok(());
        }
        Err(StopReason::SafetyPlane {
            plane: plane as u8,
            depth: depth_m,
        })
    }

    /// The limits that motions are planned with now.
    pub(crate) fn planning_limits(&self) -> &MotionLimits {
        if self.tracking.is_some() {
            &self.limits_on_belt
        } else {
            &self.limits
        }
    }

    /// A pause or a safeguard stop holds the arm on its path.
    pub(crate) fn is_held(&self) -> bool {
        self.is_paused || self.machine.is_safeguarded()
    }

    /// The speed fraction in effect: 0 while held.
    pub(crate) fn fraction(&self) -> f64 {
        if self.is_held() || self.speed_fraction < SLOWEST_FRACTION {
            0.0
        } else {
            self.speed_fraction
        }
    }

    /// Ends what has come to its end in this cycle.
    fn settle(&mut self) {
        self.settle_tracking();
        match &self.generator {
            Generator::Online(online) if online.is_over(&self.target) => {
                if !online.has_ended() {
                    self.out.ended(online.id, Outcome::Aborted);
                }
                self.generator = Generator::Hold;
            }
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
        self.settle_force_mode();
        if !self.is_standing() {
            return;
        }
        if self.waiting.includes(WaitingFor::PowerOff) || self.machine.is_emergency() {
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

    /// Power and brakes take time; safety inputs are looked at.
    fn advance_machine(&mut self) {
        if self.machine.advance(self.step) {
            self.stand_at_actual();
        }
        let lines = self.safety_inputs.lines(self.io.image.digital_in);
        self.look_for_emergency(|machine| machine.observe(lines));
    }

    /// Where `begins` says that an emergency stop begins, the joints brake; once they stand the power goes off.
    pub(crate) fn look_for_emergency(&mut self, begins: impl FnOnce(&mut Machine) -> bool) {
        let is_held_by_servos = self.is_under_servo();
        if !begins(&mut self.machine) {
            return;
        }
        let reason = StopReason::EmergencyStop;
        self.out.stopped(reason);
        if is_held_by_servos && !matches!(self.generator, Generator::Brake(_)) {
            let brake = self.brake_from_target(reason);
            self.generator = Generator::Brake(brake);
        }
    }

    /// Reports a protective stop, ends the motion with it, and gives the braking from the present target.
    fn protective_stop(&mut self, reason: StopReason) -> JointBrake {
        if self.machine.protective_stop(reason) {
            self.out.stopped(reason);
        }
        self.brake_from_target(reason)
    }

    /// Ends the motion with `reason` and gives the braking from the present target.
    fn brake_from_target(&mut self, reason: StopReason) -> JointBrake {
        let running = self.running();
        if running != CommandId::NONE && !self.has_call_ended() {
            self.out.ended(running, Outcome::ProtectiveStop(reason));
        }
        if let Some(deferred) = self.deferred.take() {
            self.out.ended(deferred.id, Outcome::ProtectiveStop(reason));
        }
        self.is_paused = false;
        self.upcoming = None;
        self.tracking = None;
        self.force.pressing = None;
        self.target = self.commanded;
        JointBrake::new(&self.commanded, &self.limits)
    }

    /// The servos hold the arm, not the brakes: those do without power, and at the end of a protective stop.
    pub(crate) fn is_under_servo(&self) -> bool {
        self.machine.is_under_servo()
            && (self.machine.stop_reason().is_none()
                || matches!(self.generator, Generator::Brake(_)))
    }

    /// The target becomes the place where the arm is.
    pub(crate) fn stand_at_actual(&mut self) {
        self.target = Setpoint::standing(self.actual.q);
        self.commanded = self.target;
        self.tracking = None;
        self.force.pressing = None;
        self.plant.retarget(&self.target.q);
        self.target_frames = self.model.forward(&self.target.q);
    }

    /// True when no setpoint moves: nothing to do, or held on the path.
    pub fn is_standing(&self) -> bool {
        if self.tracking.as_ref().is_some_and(Tracking::is_stopping) {
            return false;
        }
        // While it is held force mode comes to rest as well; otherwise it moves the arm all the time.
        if self.force.is_at_work() && self.is_held() && !stands(&self.commanded) {
            return false;
        }
        match &self.generator {
            Generator::Hold => self.upcoming.is_none() && self.deferred.is_none(),
            Generator::Path(motion) => motion.is_standing(),
            Generator::Online(_) => self.is_paused && stands(&self.target),
            Generator::Brake(_) => false,
        }
    }

    /// The motion command that has not ended yet. One that ended by entering its blend zone is none, though the arm moves.
    pub(crate) fn running(&self) -> CommandId {
        match (&self.upcoming, &self.generator) {
            (Some(upcoming), _) => upcoming.id,
            (None, Generator::Path(motion)) if !motion.is_handed_over => motion.id,
            (None, Generator::Online(online)) => online.id,
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
        if let Some(deferred) = self.deferred.take() {
            self.out.ended(deferred.id, Outcome::Aborted);
        }
        if let Some(upcoming) = self.upcoming.take() {
            self.out.ended(upcoming.id, Outcome::Aborted);
        }
        match &mut self.generator {
            Generator::Online(online) => online.stop(&self.target),
            Generator::Path(motion) => motion.is_stopping = true,
            Generator::Hold | Generator::Brake(_) => {}
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
