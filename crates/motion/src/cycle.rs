//! One control period of the arm: commands in, one setpoint, one state and one cycle record out.
//!
//! Owns the order of the steps and the state they share. Knows no script, no socket and no clock: whoever calls
//! [`Cycle::tick`] decides what time is. Allocates nothing, locks nothing, waits for nothing, logs nothing.

use kinematics::chain::Frames;
use kinematics::safety::SafetyBounds;
use kinematics::{Dynamics, JointPositions, Payload, Pose, RobotModel, RpyPose, Wrench};
use motion_api::{Command, CommandId, MotionEnd, RobotMode, StopReason};
use nalgebra::Vector3;
use rtrb::Consumer;

use crate::brake::Brake;
use crate::collision::CollisionDetection;
use crate::config::{ConfigError, CycleConfig, MotionLimits};
use crate::constants::{SHARE_ON_BELT, fault};
use crate::contact::Contacts;
use crate::external::External;
use crate::force_mode::ForceMode;
use crate::hold::{Holding, Permit};
use crate::io::Io;
use crate::laid_over::Yields;
use crate::limits_in_force::LimitSets;
use crate::machine::Machine;
use crate::micro_points::MicroPoints;
use crate::modes::Online;
use crate::modes::conveyor::Tracking;
use crate::modes::encoder::Encoder;
use crate::modes::lag::Lag;
use crate::modes::path_offset::PathOffset;
use crate::outbox::Outbox;
use crate::path::Ground;
use crate::plan::Cells;
use crate::plant::{ArmState, Plant, Push};
use crate::queue::{Motion, Queue};
use crate::report::{Waypoint, report};
use crate::safety_inputs::SafetyInputs;
use crate::scalar::Drive;
use crate::self_collision::LinkWatch;
use crate::sensor::Sensor;
use crate::setpoint::{Expected, LimitedSetpoint, Placed, Setpoint, limit};
use crate::thermal::Thermal;
use crate::upcoming::Upcoming;
use crate::waiting::Waiting;
use crate::zone_changes::ZoneChanges;

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
    Brake(Brake),
}

/// The controller of one arm.
pub struct Cycle {
    pub(crate) model: RobotModel,
    /// The limits in force.
    pub(crate) limits: MotionLimits,
    pub(crate) limit_sets: LimitSets,
    /// What planned motions may use while a belt uses the rest.
    pub(crate) limits_on_belt: MotionLimits,
    /// The speeds of TCP and elbow, m/s, that the way ahead is kept within because it was planned with others.
    pub(crate) keeps_way: Option<[f64; 2]>,
    pub(crate) yields: Yields,
    pub(crate) step: f64,
    pub(crate) gravity: Vector3<f64>,

    pub(crate) commands: Consumer<Command>,
    pub(crate) out: Outbox,

    pub(crate) machine: Machine,
    pub(crate) generator: Generator,
    pub(crate) safety_inputs: SafetyInputs,
    /// The way of the motions that the arm has taken.
    pub(crate) queue: Queue,
    /// The next motion, until it begins.
    pub(crate) upcoming: Option<Upcoming>,
    /// What the leg of the next motion bears.
    pub(crate) cells: Cells,
    pub(crate) waiting: Waiting,
    pub(crate) zone_changes: ZoneChanges,
    pub(crate) is_paused: bool,
    /// The joints are braked, or stand after that, whatever modes want.
    pub(crate) holding: Option<Holding>,
    /// What the joints have to make good afterwards.
    pub(crate) lag: Option<Lag>,
    pub(crate) speed_fraction: f64,
    pub(crate) io: Io,

    pub(crate) tcp: RpyPose,
    pub(crate) flange_from_tcp: Pose,
    pub(crate) payload: Payload,
    pub(crate) dynamics: Dynamics,

    /// What the generator asks for; the same as `commanded` unless a conveyor is tracked, path offsets count or force mode is
    /// on.
    pub(crate) target: Setpoint,
    /// What the arm gets.
    pub(crate) commanded: Setpoint,
    pub(crate) target_frames: Frames,
    pub(crate) plant: Plant,
    pub(crate) contacts: Contacts,
    pub(crate) actual: ArmState,
    /// What the latest setpoint takes.
    pub(crate) expected: Expected,
    pub(crate) placed: Placed,
    pub(crate) waypoint: Option<Waypoint>,
    /// Where the joints are at `actual`; changed with it by [`Cycle::arm_is`].
    pub(crate) actual_frames: Frames,

    /// The points of the next moveml, or of the one under way.
    pub(crate) micro_points: MicroPoints,
    /// A planned motion that waits for an online mode to come to rest.
    pub(crate) deferred: Option<Command>,
    pub(crate) tracking: Option<Tracking>,
    pub(crate) encoders: [Encoder; 2],
    pub(crate) path_offset: PathOffset,
    pub(crate) external: External,
    /// What acts on the tool in this cycle: base axes, about the TCP.
    pub(crate) hand: Wrench,
    pub(crate) force: ForceMode,
    pub(crate) sensor: Sensor,
    pub(crate) collision: CollisionDetection,
    pub(crate) safety: SafetyBounds,
    pub(crate) links: LinkWatch,
    pub(crate) thermal: Thermal,
}

impl Cycle {
    /// A controller whose arm stands at home, and its snapshot published as cycle 0.
    ///
    /// # Errors
    /// [`ConfigError`] names what is wrong with the configuration or the border.
    pub fn new(config: CycleConfig, border: MotionEnd) -> Result<Self, ConfigError> {
        let limits = config.resolve()?;
        let limit_sets = LimitSets::new(limits, config.resolve_reduced()?);
        let io = Io::new(&config.io, config.step_time, border.registers.clone());
        let ((commands, points), out) = Outbox::new(border)?;
        let machine = Machine::new(config.robot_mode());
        let model = config
            .model
            .clone()
            .with_limits(limits.narrowed(config.model.limits()));
        let dynamics = model.dynamics(&config.payload, config.gravity);
        let mut plant = Plant::new(
            config.plant,
            &model,
            (&dynamics, config.truth),
            &config.gravity,
            &config.home,
        )?;
        let mut contacts = Contacts::new(config.surroundings, &model, &config.home);
        let flange_from_tcp = Pose::from_rpy(&config.tcp);
        plant.push(&Push {
            flange_from_tcp,
            ..Push::default()
        });
        let actual = plant.stand(&dynamics, &mut contacts);
        let actual_frames = model.forward(&actual.q);
        let expected = dynamics.gravity_torques(&config.home);
        let is_powered = machine.robot_mode() != RobotMode::PowerOff;
        let mut cycle = Self {
            limits_on_belt: limits.shared(SHARE_ON_BELT),
            keeps_way: None,
            yields: Yields::default(),
            micro_points: MicroPoints::new(points),
            deferred: None,
            tracking: None,
            encoders: config.belts.map(Encoder::new),
            path_offset: PathOffset::new(config.step_time),
            external: External::new(config.loads),
            hand: Wrench::default(),
            force: ForceMode::new()?,
            sensor: Sensor::new(config.sensor_noise, config.truth.payload),
            collision: CollisionDetection::default(),
            safety: config.safety,
            links: LinkWatch::new(&model, limits.link_overlap),
            thermal: Thermal::new(is_powered),
            commanded: Setpoint::standing(config.home),
            limits,
            limit_sets,
            step: config.step_time,
            gravity: config.gravity,
            commands,
            out,
            machine,
            generator: Generator::Hold,
            safety_inputs: config.safety_inputs,
            queue: Queue::new(),
            upcoming: None,
            cells: Cells::new(),
            waiting: Waiting::default(),
            zone_changes: ZoneChanges::new(),
            is_paused: false,
            holding: None,
            lag: None,
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
            actual_frames,
            expected: Expected {
                of: Setpoint::standing(config.home),
                torques: expected,
                bias: None,
            },
            placed: Placed::new(&model, &config.home),
            waypoint: None,
            model,
        };
        cycle.measure_force();
        let first = report(&mut cycle, Timing::default());
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
        self.follow_reduced_mode();
        self.yields.advance(self.step);
        self.feel_hand();
        let wanted = self.generate();
        let limited = self.limit(wanted);
        self.move_arm(&limited);
        self.measure();
        self.check_arm();
        self.settle();
        self.make_zone_changes();
        let state = report(self, timing);
        self.out.publish(&state, &mut self.io);
    }

    /// After a fault of ours, when nothing of the cycle can be relied on any more: the plant is held where it is (no tick
    /// will move it) and the ports are shown an arm that stands, with the safety mode that says why.
    pub(crate) fn hold_after_fault(&mut self) {
        self.out.publish_fault();
    }

    /// The generator's setpoint, or why there is none.
    fn generate(&mut self) -> Result<Setpoint, StopReason> {
        self.hold_or_let_go()?;
        if matches!(self.generator, Generator::Online(_)) {
            return match self.holding {
                Some(_) => Ok(Setpoint::standing(self.target.q)),
                None => Ok(self.generate_online()),
            };
        }
        self.plan_on();
        if matches!(self.generator, Generator::Hold) {
            self.queue.pass(self.step);
        }
        self.slow_the_way_down();
        let is_hard = self.slows_hard();
        let ground = Ground {
            model: &self.model,
            points: self.micro_points.points(),
        };
        let near = &self.target.q;
        let is_free = self.has_no_planes();
        let holding = self.holding.as_ref();
        let drive = match self.permit() {
            _ if let Some(holding) = holding => Drive::HaltBeside(holding.deceleration_on_path()),
            Permit::RestHard => Drive::HaltHard,
            Permit::Go(fraction) if fraction > 0.0 => Drive::Go(fraction),
            Permit::Go(_) | Permit::Rest => Drive::Halt,
        };
        let lost = StopReason::Internal {
            code: fault::PATH_LOST,
        };
        let queue = &self.queue;
        let pace = self.tracking.as_ref().map_or(1.0, Tracking::pace);
        if let Generator::Path(motion) = &mut self.generator {
            motion.brake_hard(is_hard);
            motion.slow_to(pace);
        }
        match &mut self.generator {
            Generator::Hold | Generator::Online(_) => Ok(Setpoint::standing(self.target.q)),
            Generator::Brake(brake) => {
                let next = brake.next(self.step, queue, &ground, near);
                next.ok_or(lost)
            }
            Generator::Path(motion) if is_free || self.holding.is_some() => {
                let next = queue.next(motion, self.step, drive, &ground, near);
                next.ok_or(lost)
            }
            Generator::Path(motion) => {
                // Where it must stop for a safety plane it stays in the state before.
                let mut moved = *motion;
                let next = queue.next(&mut moved, self.step, drive, &ground, near);
                let wanted = next.ok_or(lost)?;
                self.check_planes_on_path(&moved, &wanted)?;
                if let Generator::Path(motion) = &mut self.generator {
                    *motion = moved;
                }
                Ok(wanted)
            }
        }
    }

    /// What paths are followed with.
    pub(crate) fn ground(&self) -> Ground<'_> {
        Ground {
            model: &self.model,
            points: self.micro_points.points(),
        }
    }

    /// The setpoint that the arm gets: the wanted one, or the first of a protective stop.
    fn limit(&mut self, wanted: Result<Setpoint, StopReason>) -> LimitedSetpoint {
        let checked = wanted.and_then(|wanted| {
            if matches!(self.generator, Generator::Brake(_)) {
                let braking =
                    LimitedSetpoint::while_braking(wanted, &self.commanded, self.limit_sets.able());
                self.target_frames = self.placed.at(&self.model, &braking.get().q).frames;
                return Ok(braking);
            }
            let nominal = wanted;
            if let Some(held) = self.held() {
                self.target = nominal;
                return Ok(held);
            }
            if self.brakes_joint_by_joint() {
                return Ok(self.braked_joints(nominal));
            }
            let wanted = self.carried(&nominal)?;
            let wanted = self.offset(&wanted)?;
            let wanted = self.pressed(&wanted)?;
            let wanted = self.with_lag(&wanted);
            if let Err(reason) = self.check_laid_over(&wanted) {
                return self.yield_to_limits(&nominal, reason);
            }
            let frames = if wanted.q.has_bits_of(&self.commanded.q) {
                self.target_frames
            } else {
                self.placed.at(&self.model, &wanted.q).frames
            };
            let tcp = (frames.base_from_flange * self.flange_from_tcp).translation;
            let before = &self.commanded;
            let checked = self.limit_sets.checked();
            let passed = limit(wanted, before, &frames, tcp, self.step, checked)?;
            self.check_planes(&wanted)?;
            self.check_links(&wanted)?;
            self.target_frames = frames;
            self.target = nominal;
            Ok(passed)
        });
        checked.unwrap_or_else(|reason| {
            let mut brake = self.protective_stop(reason);
            let at = self.commanded.q;
            let first = brake.next(self.step, &self.queue, &self.ground(), &at);
            self.generator = Generator::Brake(brake);
            // A path that is lost is left where it is.
            let first = first.unwrap_or(Setpoint::standing(at));
            let braking =
                LimitedSetpoint::while_braking(first, &self.commanded, self.limit_sets.able());
            self.target_frames = self.placed.at(&self.model, &braking.get().q).frames;
            braking
        })
    }

    /// Moves the plant by one step.
    fn move_arm(&mut self, limited: &LimitedSetpoint) {
        if self.is_under_servo() {
            self.expect(limited.get());
            let believed = (&self.dynamics, &self.expected.torques);
            let actual = self
                .plant
                .follow(limited, believed, &mut self.contacts, self.step);
            self.commanded = *limited.get();
            if actual.q.has_bits_of(&self.commanded.q) {
                // The limiter has looked where that is.
                (self.actual, self.actual_frames) = (actual, self.target_frames);
            } else {
                self.arm_is(actual);
            }
            // Joints that are braked beside a path come back to it afterwards.
            let is_beside_path =
                self.holding.is_some() && matches!(self.generator, Generator::Path(_));
            if self.is_path_all() && !is_beside_path {
                self.target = self.commanded;
            }
        } else {
            let actual = self.plant.stand(&self.dynamics, &mut self.contacts);
            self.arm_is(actual);
            self.stand_at_actual();
            let standing = self.commanded;
            self.expect(&standing);
        }
    }

    /// Works out what a setpoint takes.
    fn expect(&mut self, setpoint: &Setpoint) {
        let Setpoint { q, qd, qdd } = setpoint;
        let posture = &self.placed.at(&self.model, q).posture;
        // The ideal arm will be just there, and the collision observer asks.
        let (torques, bias) = if self.plant.is_ideal() {
            let [torques, bias] = self.dynamics.inverse_dynamics_and_bias(posture, qd, qdd);
            (torques, Some(bias))
        } else {
            (self.dynamics.inverse_dynamics_at(posture, qd, qdd), None)
        };
        self.expected = Expected {
            of: *setpoint,
            torques,
            bias,
        };
    }

    /// Takes over where the arm is.
    pub(crate) fn arm_is(&mut self, actual: ArmState) {
        if !actual.q.has_bits_of(&self.actual.q) {
            self.actual_frames = self.placed.at(&self.model, &actual.q).frames;
        }
        self.actual = actual;
    }

    /// The limits that motions are planned with now.
    pub(crate) fn planning_limits(&self) -> &MotionLimits {
        if self.tracking.is_some() || self.path_offset.is_on() {
            &self.limits_on_belt
        } else {
            &self.limits
        }
    }

    /// The speed fraction in effect: 0 while held.
    pub(crate) fn fraction(&self) -> f64 {
        self.permit().fraction()
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
        self.holding = None;
        self.lag = None;
        self.path_offset.end();
        self.force.pressing = None;
        self.plant.retarget(&self.target.q);
        self.target_frames = self.actual_frames;
    }

    /// The motion command under way, or the next one. One that ended by entering its blend zone is none, though the arm moves.
    pub(crate) fn running(&self) -> CommandId {
        let upcoming = self.upcoming.as_ref().map_or(CommandId::NONE, |u| u.id);
        match &self.generator {
            Generator::Path(_) => match self.queue.current() {
                Some(leg) if !leg.has_ended => leg.id,
                _ => upcoming,
            },
            Generator::Online(online) if upcoming == CommandId::NONE => online.id,
            _ => upcoming,
        }
    }

    /// Where the next motion begins: where the arm stands, or the last waypoint of the queue.
    pub(crate) fn next_start(&self) -> JointPositions {
        match &self.generator {
            Generator::Path(_) => self.queue.end().unwrap_or(self.target.q),
            _ => self.target.q,
        }
    }

    /// Length of a cycle, s.
    pub fn step_time(&self) -> f64 {
        self.step
    }

    /// Whether there are places for so many records, or nobody who takes any.
    pub fn has_record_room(&self, needed: usize) -> bool {
        self.out.has_record_room(needed)
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
