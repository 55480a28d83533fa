//! One control period of the arm: commands in, one setpoint, one state and one cycle record out.
//!
//! Owns the order of the steps. What of the state must change together is in parts that own it: `tool`, `load_model`,
//! `limits_in_force`, `commanded`, `plant::actual`. Knows no script, no socket and no clock: whoever calls
//! [`ControlLoop::tick`] decides what time is. Allocates nothing, locks nothing, waits for nothing, logs nothing.

use kinematics::safety::SafetyBounds;
use kinematics::{JointPositions, RobotModel, Wrench};
use motion_api::{Command, CommandId, MotionEndpoint, RobotMode, StopReason};
use rtrb::Consumer;

use crate::brake::StopMotion;
use crate::collision::CollisionDetector;
use crate::commanded::{CommandedSetpoint, PlacedSetpoint};
use crate::config::{ConfigError, CycleConfig};
use crate::constants::fault;
use crate::contact::ContactModel;
use crate::external::ExternalWrenches;
use crate::force_mode::ForceMode;
use crate::hold::{JointHold, MotionPermission};
use crate::io::IoSystem;
use crate::laid_over::Yields;
use crate::limits_in_force::LimitSets;
use crate::load_model::LoadModel;
use crate::machine::RobotStateMachine;
use crate::micro_points::MicroPoints;
use crate::modes::ActiveOnlineMode;
use crate::modes::conveyor::ConveyorTracking;
use crate::modes::encoder::Encoder;
use crate::modes::lag::JointLag;
use crate::modes::path_offset::PathOffset;
use crate::outbox::Outbox;
use crate::path::PathContext;
use crate::plan::SegmentLimits;
use crate::plant::{ActualArm, Plant, ToolWrench};
use crate::queue::{MotionQueue, PathMotion};
use crate::report::{Waypoint, robot_state};
use crate::safety_inputs::SafetyInputs;
use crate::scalar::ProgressGoal;
use crate::self_collision::SelfCollisionMonitor;
use crate::sensor::ForceTorqueSensor;
use crate::setpoint::{
    KinematicsCache, LimitedSetpoint, Setpoint, SetpointDynamics, check_setpoint,
};
use crate::surroundings::Surroundings;
use crate::thermal::Thermal;
use crate::tool::Tool;
use crate::upcoming::PendingMotion;
use crate::waiting::RestCommands;
use crate::zone_changes::ZoneChanges;

/// What the caller measured about the cycles; zeros under the virtual clock.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CycleTiming {
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
    Path(PathMotion),
    /// An online mode makes each setpoint from the one before.
    Online(ActiveOnlineMode),
    /// A protective stop brakes the joints.
    Stop(StopMotion),
}

/// The controller of one arm.
pub struct ControlLoop {
    pub(crate) model: RobotModel,
    pub(crate) limits: LimitSets,
    pub(crate) yields: Yields,
    pub(crate) step: f64,

    pub(crate) commands: Consumer<Command>,
    pub(crate) out: Outbox,

    pub(crate) machine: RobotStateMachine,
    pub(crate) generator: Generator,
    pub(crate) safety_inputs: SafetyInputs,
    /// The way of the motions that the arm has taken.
    pub(crate) queue: MotionQueue,
    /// The next motion, until it begins.
    pub(crate) pending_motion: Option<PendingMotion>,
    /// What the leg of the next motion bears.
    pub(crate) pending_limits: SegmentLimits,
    pub(crate) rest_commands: RestCommands,
    pub(crate) zone_changes: ZoneChanges,
    pub(crate) is_paused: bool,
    /// The joints are braked, or stand after that, whatever modes want.
    pub(crate) joint_hold: Option<JointHold>,
    /// What the joints have to make good afterwards.
    pub(crate) lag: Option<JointLag>,
    pub(crate) speed_fraction: f64,
    pub(crate) io: IoSystem,

    pub(crate) tool: Tool,
    pub(crate) load: LoadModel,

    /// What the generator asks for; the same as `commanded` unless a conveyor is tracked, path offsets count or force
    /// mode is on.
    pub(crate) target: Setpoint,
    /// What the arm gets.
    pub(crate) commanded: CommandedSetpoint,
    pub(crate) actual: ActualArm,
    /// What the latest setpoint takes.
    pub(crate) setpoint_dynamics: SetpointDynamics,
    pub(crate) kinematics_cache: KinematicsCache,
    pub(crate) waypoint: Option<Waypoint>,

    /// The points of the next moveml, or of the one under way.
    pub(crate) micro_points: MicroPoints,
    /// A planned motion that waits for an online mode to come to rest.
    pub(crate) deferred: Option<Command>,
    pub(crate) tracking: Option<ConveyorTracking>,
    pub(crate) encoders: [Encoder; 2],
    pub(crate) path_offset: PathOffset,
    pub(crate) external: ExternalWrenches,
    /// What acts on the tool in this cycle: base axes, about the TCP.
    pub(crate) external_wrench: Wrench,
    pub(crate) force: ForceMode,
    pub(crate) sensor: ForceTorqueSensor,
    pub(crate) collision: CollisionDetector,
    /// Contact stops the arm.
    pub(crate) contact_stops: bool,
    pub(crate) safety: SafetyBounds,
    pub(crate) links: SelfCollisionMonitor,
    pub(crate) thermal: Thermal,
    /// What stands and moves around the arm, where that is simulated.
    pub(crate) surroundings: Option<Surroundings>,
}

impl ControlLoop {
    /// A controller whose arm stands at home, and its snapshot published as cycle 0.
    ///
    /// # Errors
    /// [`ConfigError`] names what is wrong with the configuration or the border.
    pub fn new(config: CycleConfig, border: MotionEndpoint) -> Result<Self, ConfigError> {
        let limits = config.resolve()?;
        let reduced_limits = config.resolve_reduced()?;
        let io = IoSystem::new(&config.io, config.step_time, border.registers.clone());
        let ((commands, points), out) = Outbox::new(border)?;
        let machine = RobotStateMachine::new(config.robot_mode());
        let model = config
            .model
            .clone()
            .with_limits(limits.applied_to(config.model.limits()));
        let load = LoadModel::new(&model, config.payload, config.gravity);
        let mut plant = Plant::new(
            config.plant,
            &model,
            (load.dynamics(), config.truth),
            load.gravity(),
            &config.home,
        )?;
        let contacts = ContactModel::new(config.surroundings, &model, &config.home);
        let tool = Tool::new(config.tcp);
        plant.set_tool_wrench(&ToolWrench {
            flange_from_tcp: *tool.flange_from_tcp(),
            ..ToolWrench::default()
        });
        let actual = ActualArm::new(plant, contacts, load.dynamics(), &model);
        let expected = load.dynamics().gravity_torques(&config.home);
        let is_powered = machine.robot_mode() != RobotMode::PowerOff;
        let mut cycle = Self {
            yields: Yields::default(),
            micro_points: MicroPoints::new(points),
            deferred: None,
            tracking: None,
            encoders: config.belts.map(Encoder::new),
            path_offset: PathOffset::new(config.step_time),
            external: ExternalWrenches::new(config.loads),
            external_wrench: Wrench::default(),
            force: ForceMode::new()?,
            sensor: ForceTorqueSensor::new(config.sensor_noise, config.truth.payload),
            collision: CollisionDetector::default(),
            contact_stops: config.contact_stops,
            safety: config.safety,
            links: SelfCollisionMonitor::new(&model, limits.link_overlap),
            thermal: Thermal::new(is_powered),
            surroundings: None,
            commanded: CommandedSetpoint::standing(config.home, model.forward(&config.home)),
            limits: LimitSets::new(limits, reduced_limits),
            step: config.step_time,
            commands,
            out,
            machine,
            generator: Generator::Hold,
            safety_inputs: config.safety_inputs,
            queue: MotionQueue::new(),
            pending_motion: None,
            pending_limits: SegmentLimits::new(),
            rest_commands: RestCommands::default(),
            zone_changes: ZoneChanges::new(),
            is_paused: false,
            joint_hold: None,
            lag: None,
            speed_fraction: 1.0,
            io,
            tool,
            load,
            target: Setpoint::standing(config.home),
            actual,
            setpoint_dynamics: SetpointDynamics {
                of: Setpoint::standing(config.home),
                torques: expected,
                bias: None,
            },
            kinematics_cache: KinematicsCache::new(&model, &config.home),
            waypoint: None,
            model,
        };
        cycle.measure_force();
        let first = robot_state(&mut cycle, CycleTiming::default());
        cycle.out.publish_first(&first);
        Ok(cycle)
    }

    /// One control period. Takes what waits in the command ring, moves the arm by one step, and puts out exactly one
    /// cycle record, one snapshot and the events.
    pub fn tick(&mut self, timing: CycleTiming) {
        self.out.cycle += 1;
        self.take_commands();
        // After the commands: a register written before a command was sent is seen no later than the command.
        self.out.record_registers(self.io.sample_registers());
        self.io.advance(self.out.cycle as f64 * self.step);
        self.take_world();
        self.follow_input_actions();
        self.advance_machine();
        self.update_reduced_mode();
        self.yields.advance(self.step);
        self.update_external_wrench();
        let wanted = self.generate();
        let next = self.check_or_brake(wanted);
        self.move_arm(&next);
        self.update_sensors();
        self.check_tracking();
        self.complete_finished_commands();
        self.make_zone_changes();
        let state = robot_state(self, timing);
        self.out.publish(&state, &mut self.io);
        self.give_to_world();
    }

    /// After a fault of ours, when nothing of the cycle can be relied on any more: the plant is held where it is (no
    /// tick will move it) and the ports are shown an arm that stands, with the safety mode that says why.
    pub(crate) fn hold_after_fault(&mut self) {
        self.out.publish_fault();
    }

    /// The generator's setpoint, or why there is none.
    fn generate(&mut self) -> Result<Setpoint, StopReason> {
        self.update_hold()?;
        if matches!(self.generator, Generator::Online(_)) {
            return match self.joint_hold {
                Some(_) => Ok(Setpoint::standing(self.target.q)),
                None => Ok(self.generate_online()),
            };
        }
        self.continue_planning();
        if matches!(self.generator, Generator::Hold) {
            self.queue.pass(self.step);
        }
        self.cap_path_speed();
        let is_hard = self.needs_hard_transition();
        let ground = PathContext {
            model: &self.model,
            points: self.micro_points.points(),
        };
        let near = &self.target.q;
        let is_free = self.has_no_planes();
        let holding = self.joint_hold.as_ref();
        let drive = match self.motion_permission() {
            _ if let Some(holding) = holding => {
                ProgressGoal::HaltBeside(holding.deceleration_on_path())
            }
            MotionPermission::StopHard => ProgressGoal::StopHard,
            MotionPermission::Run(fraction) if fraction > 0.0 => ProgressGoal::Run(fraction),
            MotionPermission::Run(_) | MotionPermission::Stop => ProgressGoal::Stop,
        };
        let lost = StopReason::Internal {
            code: fault::PATH_LOST,
        };
        let queue = &self.queue;
        let pace = self.tracking.as_ref().map_or(1.0, ConveyorTracking::pace);
        if let Generator::Path(motion) = &mut self.generator {
            motion.set_hard_braking(is_hard);
            motion.slow_to(pace);
        }
        match &mut self.generator {
            Generator::Hold | Generator::Online(_) => Ok(Setpoint::standing(self.target.q)),
            Generator::Stop(brake) => {
                let next = brake.next_setpoint(self.step, queue, &ground, near);
                next.ok_or(lost)
            }
            Generator::Path(motion) if is_free || self.joint_hold.is_some() => {
                let next = queue.next_setpoint(motion, self.step, drive, &ground, near);
                next.ok_or(lost)
            }
            Generator::Path(motion) => {
                // Where it must stop for a safety plane it stays in the state before.
                let mut moved = *motion;
                let next = queue.next_setpoint(&mut moved, self.step, drive, &ground, near);
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
    pub(crate) fn path_context(&self) -> PathContext<'_> {
        PathContext {
            model: &self.model,
            points: self.micro_points.points(),
        }
    }

    /// The setpoint that the arm gets: the wanted one, or the first of a protective stop.
    fn check_or_brake(&mut self, wanted: Result<Setpoint, StopReason>) -> PlacedSetpoint {
        let checked = wanted.and_then(|wanted| {
            if matches!(self.generator, Generator::Stop(_)) {
                return Ok(self.while_braking(wanted));
            }
            let nominal = wanted;
            if let Some(held) = self.next_hold_setpoint() {
                self.target = nominal;
                return Ok(held);
            }
            if self.brakes_joint_by_joint() {
                return Ok(self.braked_joints(nominal));
            }
            let wanted = self.apply_conveyor(&nominal)?;
            let wanted = self.apply_path_offset(&wanted)?;
            let wanted = self.apply_force_mode(&wanted)?;
            let wanted = self.apply_lag(&wanted);
            if let Err(reason) = self.check_overlays(&wanted) {
                return self.yield_to_limits(&nominal, reason);
            }
            let before = self.commanded.setpoint();
            let frames = if wanted.q.has_bits_of(&before.q) {
                *self.commanded.frames()
            } else {
                self.kinematics_cache.at(&self.model, &wanted.q).frames
            };
            let tcp = self.tool.position(&frames);
            let checked = self.limits.enforced();
            let passed = check_setpoint(wanted, before, &frames, tcp, self.step, checked)?;
            self.check_planes(&wanted)?;
            self.check_links(&wanted)?;
            self.target = nominal;
            Ok(PlacedSetpoint::new(passed, frames))
        });
        checked.unwrap_or_else(|reason| {
            let mut brake = self.protective_stop(reason);
            let at = self.commanded.setpoint().q;
            let first = brake.next_setpoint(self.step, &self.queue, &self.path_context(), &at);
            self.generator = Generator::Stop(brake);
            // A path that is lost is left where it is.
            self.while_braking(first.unwrap_or(Setpoint::standing(at)))
        })
    }

    /// A setpoint of joints that come to rest whatever the limits.
    pub(crate) fn while_braking(&mut self, wanted: Setpoint) -> PlacedSetpoint {
        let (before, able) = (self.commanded.setpoint(), self.limits.able());
        let braking = LimitedSetpoint::while_braking(wanted, before, able);
        PlacedSetpoint::find(braking, &self.model, &mut self.kinematics_cache)
    }

    /// Moves the plant by one step.
    fn move_arm(&mut self, next: &PlacedSetpoint) {
        if self.is_under_servo() {
            self.update_setpoint_dynamics(next.as_setpoint());
            let believed = (self.load.dynamics(), &self.setpoint_dynamics.torques);
            let links = (&self.model, &mut self.kinematics_cache);
            self.actual.step_to_target(next, believed, self.step, links);
            self.commanded.advance(next);
            // Joints that are braked beside a path come back to it afterwards.
            let is_beside_path =
                self.joint_hold.is_some() && matches!(self.generator, Generator::Path(_));
            if self.has_no_overlay() && !is_beside_path {
                self.target = *self.commanded.setpoint();
            }
        } else {
            let links = (&self.model, &mut self.kinematics_cache);
            self.actual.step_with_brakes(self.load.dynamics(), links);
            self.reset_target_to_actual();
            let standing = *self.commanded.setpoint();
            self.update_setpoint_dynamics(&standing);
        }
    }

    /// Works out what a setpoint takes.
    fn update_setpoint_dynamics(&mut self, setpoint: &Setpoint) {
        let Setpoint { q, qd, qdd } = setpoint;
        let posture = &self.kinematics_cache.at(&self.model, q).posture;
        // The ideal arm will be just there, and the collision observer asks.
        let (torques, bias) = if self.actual.plant.is_ideal() {
            let [torques, bias] = self
                .load
                .dynamics()
                .inverse_dynamics_and_bias(posture, qd, qdd);
            (torques, Some(bias))
        } else {
            (
                self.load.dynamics().inverse_dynamics_at(posture, qd, qdd),
                None,
            )
        };
        self.setpoint_dynamics = SetpointDynamics {
            of: *setpoint,
            torques,
            bias,
        };
    }

    /// The speed fraction in effect: 0 while held.
    pub(crate) fn speed_fraction_in_effect(&self) -> f64 {
        self.motion_permission().fraction()
    }

    /// The servos hold the arm, not the brakes: those do without power, and at the end of a protective stop.
    pub(crate) fn is_under_servo(&self) -> bool {
        self.machine.is_under_servo()
            && (self.machine.stop_reason().is_none()
                || matches!(self.generator, Generator::Stop(_)))
    }

    /// The target becomes the place where the arm is.
    pub(crate) fn reset_target_to_actual(&mut self) {
        let q = self.actual.state().q;
        self.target = Setpoint::standing(q);
        self.commanded = CommandedSetpoint::standing(q, *self.actual.frames());
        self.tracking = None;
        self.joint_hold = None;
        self.lag = None;
        self.path_offset.end();
        self.force.active = None;
        self.actual.plant.retarget(&self.target.q);
    }

    /// The motion command under way, or the next one. One that ended by entering its blend zone is none, though the arm
    /// moves.
    pub(crate) fn running_command(&self) -> CommandId {
        let upcoming = self
            .pending_motion
            .as_ref()
            .map_or(CommandId::NONE, |u| u.id);
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
