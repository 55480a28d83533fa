//! Commands of the online modes: who may begin one, what replaces what, and what each of them sets.
//!
//! The rule, which `allowed` has as a table: only one motion at a time moves the arm. A servo or speed command takes
//! over from the one before of the same thread without a stop, or from one whose call has returned; a planned motion
//! that follows an online mode waits for the arm to come to rest, and so does an online mode that follows a motion with
//! a blend radius; everything else is refused. The modes themselves are in `modes`.

use kinematics::{JointPositions, JointSpeeds, Wrench};
use motion_api::{
    Command, CommandId, CommandKind, FreedriveFrame, IoChange, MotionMode, OnlineCommand, Origin,
    Outcome, Refusal, Warning, phrase,
};

use crate::allowed::Admission;
use crate::constants::{MAX_DURATION, MIN_REQUESTED_RATE, ROTATION_LENGTH};
use crate::cycle::{ControlLoop, Generator};
use crate::external::{PUSHES_MAX, PortSensor, TimedWrench, WrenchFrame};
use crate::intake::{CommandResult, Completion, bad_value};
use crate::load_model::LoadModel;
use crate::modes::freedrive::FreedriveMode;
use crate::modes::joint_speed::JointSpeedMode;
use crate::modes::servo::{GAIN_RANGE, LOOKAHEAD_RANGE, ServoMode};
use crate::modes::tcp_speed::{TcpSpeedMode, TwistFrame};
use crate::modes::{
    ActiveOnlineMode, CallCompletion, OnlineContext, OnlineMode, is_setpoint_at_rest, states,
};
use crate::setpoint::Setpoint;
use crate::waiting::RestCommand;

impl ControlLoop {
    /// The next command to obey: one that waited for the arm to come to rest, or the next of the ring.
    pub(crate) fn next_command(&mut self) -> Option<Command> {
        if let Some(deferred) = self.deferred.take() {
            if self.admission(&deferred) != Admission::WaitForRest {
                return Some(deferred);
            }
            self.deferred = Some(deferred);
        }
        let command = self.commands.pop().ok()?;
        self.take_points(&command);
        self.out.record_command(&command);
        if self.admission(&command) != Admission::WaitForRest {
            return Some(command);
        }
        if let Generator::Online(online) = &mut self.generator {
            online.make_way(&self.target);
        }
        self.deferred = Some(command);
        self.next_command()
    }

    /// The next setpoint of the online mode, with what there is to say about it.
    pub(crate) fn generate_online(&mut self) -> Setpoint {
        let from = self.target;
        let arm = self.online_arm();
        let Generator::Online(mut online) = self.generator else {
            return from;
        };
        let step = online.next(&arm, &from);
        if let Some(joint) = step.limiting_joint {
            self.out
                .report_warning(online.id, Warning::LimitedByJoint { joint });
        }
        if step.has_ended {
            self.out.report_end(online.id, Outcome::Done);
        }
        self.generator = Generator::Online(online);
        step.setpoint
    }

    pub(crate) fn online_arm(&self) -> OnlineContext<'_> {
        OnlineContext::new(
            &self.model,
            self.tool.flange_from_tcp(),
            [self.online_limits(), self.limits.enforced()],
            self.load.dynamics(),
            &self.target,
            self.sensed_wrench(),
            self.step,
            (
                self.speed_fraction_in_effect() * self.stretch_to_duration(),
                self.is_held(),
            ),
            self.micro_points.points(),
        )
    }

    pub(crate) fn begin_online(
        &mut self,
        command: &Command,
        mode: MotionMode,
        call: CallCompletion,
        kind: OnlineMode,
    ) {
        if let Generator::Online(before) = &self.generator
            && !before.has_ended()
        {
            self.out.report_end(before.id, Outcome::Aborted);
        }
        self.generator = Generator::Online(ActiveOnlineMode {
            id: command.id,
            origin: command.origin,
            mode,
            call_completion: call,
            kind,
            is_stopping: false,
            is_warned: false,
        });
    }

    pub(crate) fn servoj(
        &mut self,
        command: &Command,
        target: &JointPositions,
        duration: f64,
        lookahead: f64,
        gain: f64,
    ) -> CommandResult {
        self.check_target(target)?;
        check_duration(duration)?;
        let within = |x: f64, (min, max): (f64, f64)| (min..=max).contains(&x);
        if !within(lookahead, LOOKAHEAD_RANGE) {
            return Err(bad_value(
                phrase!("lookahead_time"),
                lookahead,
                phrase!("0.03 to 0.2 s", "0.03 到 0.2 s"),
            ));
        }
        if !within(gain, GAIN_RANGE) {
            return Err(bad_value(
                phrase!("gain"),
                gain,
                phrase!("100 to 2000", "100 到 2000"),
            ));
        }
        let mut servo = match &self.generator {
            Generator::Online(ActiveOnlineMode {
                kind: OnlineMode::Servo(servo),
                ..
            }) => *servo,
            _ => ServoMode::new(&self.target.q, self.step),
        };
        // Up to rounding a target may lie outside of its range.
        let inside = JointPositions(core::array::from_fn(|joint| {
            let (min, max) = (
                self.limits.in_force().position_min[joint],
                self.limits.in_force().position_max[joint],
            );
            kinematics::bounds::within(target[joint], min, max)
        }));
        servo.set_next_point(&inside, duration, lookahead, gain, self.step);
        let call = CallCompletion::AfterTime(duration);
        self.begin_online(command, MotionMode::ServoJ, call, OnlineMode::Servo(servo));
        Ok(Completion::Deferred)
    }

    pub(crate) fn speedj(
        &mut self,
        command: &Command,
        speeds: &JointSpeeds,
        acceleration: f64,
        duration: Option<f64>,
    ) -> CommandResult {
        check_speeds(&speeds.0)?;
        check_acceleration(acceleration)?;
        let call = call_end(duration)?;
        let kind = OnlineMode::JointSpeed(JointSpeedMode::new(
            &states(&self.target),
            speeds,
            acceleration,
        ));
        self.begin_online(command, MotionMode::SpeedJ, call, kind);
        Ok(Completion::Deferred)
    }

    pub(crate) fn speedl(
        &mut self,
        command: &Command,
        speed: [f64; 6],
        [acceleration, rotation_acceleration]: [f64; 2],
        duration: Option<f64>,
    ) -> CommandResult {
        check_speeds(&speed)?;
        check_acceleration(acceleration)?;
        check_acceleration(rotation_acceleration)?;
        let call = call_end(duration)?;
        let mut tcp = self.tcp_mode();
        tcp.set_goal(speed, acceleration, rotation_acceleration);
        self.begin_online(command, MotionMode::SpeedL, call, OnlineMode::TcpSpeed(tcp));
        Ok(Completion::Deferred)
    }

    /// The TCP mode that runs, with axes of the base, or one from the present motion.
    fn tcp_mode(&self) -> TcpSpeedMode {
        let axes = TwistFrame::Fixed(nalgebra::Rotation3::identity());
        match &self.generator {
            Generator::Online(ActiveOnlineMode {
                kind: OnlineMode::TcpSpeed(tcp),
                ..
            }) => *tcp,
            _ => TcpSpeedMode::new(&self.online_arm().tcp(), &self.target, axes),
        }
    }

    pub(crate) fn stopj(&mut self, command: &Command, acceleration: f64) -> CommandResult {
        check_acceleration(acceleration)?;
        let kind = |cycle: &Self| {
            let now = states(&cycle.target);
            OnlineMode::JointSpeed(JointSpeedMode::new(&now, &JointSpeeds::ZERO, acceleration))
        };
        Ok(self.come_to_rest(command, kind))
    }

    pub(crate) fn stopl(&mut self, command: &Command, acceleration: f64) -> CommandResult {
        check_acceleration(acceleration)?;
        let kind = |cycle: &Self| {
            let mut tcp = cycle.tcp_mode();
            // A tool that turns on the spot has no speed of its TCP: turning counts as way as it does for lines.
            tcp.set_goal([0.0; 6], acceleration, acceleration / ROTATION_LENGTH);
            OnlineMode::TcpSpeed(tcp)
        };
        Ok(self.come_to_rest(command, kind))
    }

    /// Ends what moves the arm by `kind`, which begins with what it does now, planned motions as well as online modes.
    fn come_to_rest(
        &mut self,
        command: &Command,
        kind: impl Fn(&Self) -> OnlineMode,
    ) -> Completion {
        self.drop_motions_to_come();
        if matches!(self.generator, Generator::Hold) {
            // A motion whose plan is not finished has not moved the arm yet.
            return Completion::Immediate;
        }
        self.is_paused = false;
        if matches!(self.generator, Generator::Stop(_)) {
            self.rest_commands.add(command.id, RestCommand::Stop);
            return Completion::Deferred;
        }
        let kind = kind(self);
        self.end_legs(Outcome::Aborted);
        self.begin_online(command, MotionMode::Stopping, CallCompletion::OnGoal, kind);
        // Marked as stopping, the mode brings the arm to rest even at a speed fraction of 0.
        if let Generator::Online(online) = &mut self.generator {
            online.is_stopping = true;
        }
        Completion::Deferred
    }

    pub(crate) fn freedrive(
        &mut self,
        command: &Command,
        free_axes: [bool; 6],
        frame: FreedriveFrame,
    ) -> CommandResult {
        if let FreedriveFrame::Pose(pose) = frame
            && !pose.is_finite()
        {
            return Err(bad_value(
                phrase!("frame"),
                f64::NAN,
                phrase!("a pose of finite numbers", "由有限的数组成的位姿"),
            ));
        }
        let freedrive = FreedriveMode::new(&self.online_arm(), &self.target, free_axes, frame);
        let kind = OnlineMode::Freedrive(freedrive);
        self.begin_online(
            command,
            MotionMode::Freedrive,
            CallCompletion::Returned,
            kind,
        );
        Ok(Completion::Immediate)
    }

    /// Freedrive begins while an input with that action is high and the arm stands, and ends when no such input is high
    /// any more (manual 5.27). No command stands behind it.
    pub(crate) fn follow_input_actions(&mut self) {
        let is_led =
            matches!(&self.generator, Generator::Online(online) if online.is_led_by_hand());
        self.io.is_freedrive_by_input &= is_led;
        match (
            self.io.is_freedrive_requested(),
            self.io.is_freedrive_by_input,
        ) {
            // A program that leads by hand already goes on doing so.
            (true, false) if !is_led => {
                let (free_axes, frame) = ([true; 6], FreedriveFrame::Base);
                let command = Command {
                    id: CommandId::NONE,
                    origin: Origin::default(),
                    kind: CommandKind::Online(OnlineCommand::Freedrive { free_axes, frame }),
                };
                // While the arm is busy or not ready it is asked again in the next cycle.
                let begins = self.admission(&command) == Admission::Accept;
                self.io.is_freedrive_by_input =
                    begins && self.freedrive(&command, free_axes, frame).is_ok();
            }
            (false, true) => {
                if let Generator::Online(online) = &mut self.generator {
                    online.make_way(&self.target);
                }
                self.io.is_freedrive_by_input = false;
            }
            _ => {}
        }
    }

    pub(crate) fn end_freedrive(&mut self, id: CommandId) -> Completion {
        let is_freedrive = |c: &mut Command| {
            matches!(c.kind, CommandKind::Online(OnlineCommand::Freedrive { .. }))
        };
        if let Some(deferred) = self.deferred.take_if(is_freedrive) {
            self.out.report_end(deferred.id, Outcome::Aborted);
        }
        match &mut self.generator {
            Generator::Online(online) if online.is_led_by_hand() => {
                if is_setpoint_at_rest(&self.target) {
                    self.generator = Generator::Hold;
                    return Completion::Immediate;
                }
                online.make_way(&self.target);
                self.rest_commands.add(id, RestCommand::Stop);
                Completion::Deferred
            }
            _ => Completion::Immediate,
        }
    }

    pub(crate) fn set_gravity(&mut self, gravity: [f64; 3]) -> CommandResult {
        let payload = *self.load.payload();
        self.set_load(LoadModel::new(&self.model, payload, gravity.into()));
        Ok(Completion::Immediate)
    }

    pub(crate) fn set_external_wrench(&mut self, wrench: [f64; 6]) -> CommandResult {
        self.external.port_wrench = Wrench::from_array(wrench);
        Ok(Completion::Immediate)
    }

    /// A load on the tool for some time.
    pub(crate) fn push(
        &mut self,
        wrench: [f64; 6],
        in_tool_axes: bool,
        duration: f64,
        replaces: bool,
    ) -> CommandResult {
        let now = self.out.cycle as f64 * self.step;
        let load = TimedWrench {
            at: now,
            duration,
            wrench: Wrench::from_array(wrench),
            frame: match in_tool_axes {
                true => WrenchFrame::Tool,
                false => WrenchFrame::Base,
            },
        };
        match self.external.push(load, now, replaces) {
            true => Ok(Completion::Immediate),
            false => Err(bad_value(
                phrase!("the number of pushes at once", "同时的推力数目"),
                (PUSHES_MAX + 1) as f64,
                phrase!("at most 32", "不超过 32"),
            )),
        }
    }

    /// Whether readings of a port count, and what sensor makes them.
    pub(crate) fn ft_rtsi_input(
        &mut self,
        enabled: bool,
        mass: f64,
        measuring_offset: [f64; 3],
        cog: [f64; 3],
    ) -> CommandResult {
        self.external.port_sensor = enabled.then(|| PortSensor {
            mass,
            measuring_offset: measuring_offset.into(),
            cog: cog.into(),
        });
        Ok(Completion::Immediate)
    }

    pub(crate) fn set_input(&mut self, index: u8, level: bool) -> CommandResult {
        if index > 27 {
            return Err(bad_value(
                phrase!("the index of the input", "输入的序号"),
                f64::from(index),
                phrase!("0 to 27", "0 到 27"),
            ));
        }
        let mask = 1 << index;
        let levels = if level { mask } else { 0 };
        self.io.apply(&IoChange::DigitalIn { mask, levels });
        Ok(Completion::Immediate)
    }
}

fn call_end(duration: Option<f64>) -> Result<CallCompletion, Refusal> {
    match duration {
        None => Ok(CallCompletion::OnGoal),
        Some(duration) => check_duration(duration).map(|()| CallCompletion::AfterTime(duration)),
    }
}

fn check_duration(duration: f64) -> Result<(), Refusal> {
    if duration > 0.0 && duration <= MAX_DURATION {
        return Ok(());
    }
    Err(bad_value(
        phrase!("t"),
        duration,
        phrase!(
            "more than 0 and at most 1000000 s",
            "大于 0 且不超过 1000000 s"
        ),
    ))
}

fn check_acceleration(acceleration: f64) -> Result<(), Refusal> {
    if acceleration >= MIN_REQUESTED_RATE && acceleration.is_finite() {
        return Ok(());
    }
    Err(bad_value(
        phrase!("a"),
        acceleration,
        phrase!("a number of at least 0.000001", "不小于 0.000001 的数"),
    ))
}

fn check_speeds(speeds: &[f64; 6]) -> Result<(), Refusal> {
    match speeds.iter().find(|x| !(-1000.0..=1000.0).contains(*x)) {
        None => Ok(()),
        Some(&bad) => Err(bad_value(
            phrase!("a speed", "速度"),
            bad,
            phrase!("at most 1000", "不超过 1000"),
        )),
    }
}
