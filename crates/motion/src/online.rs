//! Commands of the online modes: who may begin one, what replaces what, and what each of them sets.
//!
//! The rule, which `allowed` has as a table: only one motion at a time moves the arm. A servo or speed command takes over from the one before of the same
//! thread without a stop, or from one whose call has returned; a planned motion that follows an online mode waits for the
//! arm to come to rest, and so does an online mode that follows a motion with a blend radius; everything else is refused. The modes themselves are in `modes`.

use kinematics::{JointPositions, JointSpeeds, Wrench};
use motion_api::{
    Command, CommandId, CommandKind, FreedriveFrame, IoChange, MotionMode, Origin, Outcome,
    Refusal, Warning,
};

use crate::allowed::Rule;
use crate::constants::{LONGEST, ROTATION_LENGTH, SLOWEST};
use crate::cycle::{Cycle, Generator};
use crate::external::{Load, LoadFrame, PUSHES_MAX, PortSensor};
use crate::intake::{Answer, Ending, bad_value};
use crate::modes::freedrive::Freedrive;
use crate::modes::joint_speed::JointSpeed;
use crate::modes::servo::{GAIN_RANGE, LOOKAHEAD_RANGE, Servo};
use crate::modes::tcp_speed::{Axes, TcpSpeed};
use crate::modes::{CallEnd, Kind, Online, OnlineArm, stands, states};
use crate::setpoint::Setpoint;
use crate::waiting::WaitingFor;

impl Cycle {
    /// The next command to obey: one that waited for the arm to come to rest, or the next of the ring.
    pub(crate) fn next_command(&mut self) -> Option<Command> {
        if let Some(deferred) = self.deferred.take() {
            if self.rule(&deferred) != Rule::Queue {
                return Some(deferred);
            }
            self.deferred = Some(deferred);
        }
        let command = self.commands.pop().ok()?;
        self.take_points(&command);
        self.out.taken(&command);
        if self.rule(&command) != Rule::Queue {
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
        if let Some(joint) = step.held {
            self.out.warned(online.id, Warning::HeldBack { joint });
        }
        if step.has_ended {
            self.out.ended(online.id, Outcome::Done);
        }
        self.generator = Generator::Online(online);
        step.setpoint
    }

    pub(crate) fn online_arm(&self) -> OnlineArm<'_> {
        OnlineArm::new(
            &self.model,
            &self.flange_from_tcp,
            [self.online_limits(), self.limit_sets.checked()],
            &self.dynamics,
            &self.target,
            self.felt(),
            self.step,
            (self.fraction() * self.pace(), self.is_held()),
        )
    }

    fn begin_online(&mut self, command: &Command, mode: MotionMode, call: CallEnd, kind: Kind) {
        if let Generator::Online(before) = &self.generator
            && !before.has_ended()
        {
            self.out.ended(before.id, Outcome::Aborted);
        }
        self.generator = Generator::Online(Online {
            id: command.id,
            origin: command.origin,
            mode,
            call,
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
    ) -> Answer {
        self.check_target(target)?;
        check_duration(duration)?;
        let within = |x: f64, (min, max): (f64, f64)| (min..=max).contains(&x);
        if !within(lookahead, LOOKAHEAD_RANGE) {
            return Err(bad_value("lookahead_time", lookahead, "0.03 to 0.2 s"));
        }
        if !within(gain, GAIN_RANGE) {
            return Err(bad_value("gain", gain, "100 to 2000"));
        }
        let mut servo = match &self.generator {
            Generator::Online(Online {
                kind: Kind::Servo(servo),
                ..
            }) => *servo,
            _ => Servo::new(&self.target.q, self.step),
        };
        // Up to rounding a target may lie outside of its range.
        let inside = JointPositions(core::array::from_fn(|joint| {
            let (min, max) = (
                self.limits.position_min[joint],
                self.limits.position_max[joint],
            );
            kinematics::bounds::within(target[joint], min, max)
        }));
        servo.lead(&inside, duration, lookahead, gain, self.step);
        let call = CallEnd::After(duration);
        self.begin_online(command, MotionMode::ServoJ, call, Kind::Servo(servo));
        Ok(Ending::Later)
    }

    pub(crate) fn speedj(
        &mut self,
        command: &Command,
        speeds: &JointSpeeds,
        acceleration: f64,
        duration: Option<f64>,
    ) -> Answer {
        check_speeds(&speeds.0)?;
        check_acceleration(acceleration)?;
        let call = call_end(duration)?;
        let kind = Kind::JointSpeed(JointSpeed::new(&states(&self.target), speeds, acceleration));
        self.begin_online(command, MotionMode::SpeedJ, call, kind);
        Ok(Ending::Later)
    }

    pub(crate) fn speedl(
        &mut self,
        command: &Command,
        speed: [f64; 6],
        [acceleration, rotation_acceleration]: [f64; 2],
        duration: Option<f64>,
    ) -> Answer {
        check_speeds(&speed)?;
        check_acceleration(acceleration)?;
        check_acceleration(rotation_acceleration)?;
        let call = call_end(duration)?;
        let mut tcp = self.tcp_mode();
        tcp.aim(speed, acceleration, rotation_acceleration);
        self.begin_online(command, MotionMode::SpeedL, call, Kind::TcpSpeed(tcp));
        Ok(Ending::Later)
    }

    /// The TCP mode that runs, with axes of the base, or one from the present motion.
    fn tcp_mode(&self) -> TcpSpeed {
        let axes = Axes::Fixed(nalgebra::Rotation3::identity());
        match &self.generator {
            Generator::Online(Online {
                kind: Kind::TcpSpeed(tcp),
                ..
            }) => *tcp,
            _ => TcpSpeed::new(&self.online_arm().tcp(), &self.target, axes),
        }
    }

    pub(crate) fn stopj(&mut self, command: &Command, acceleration: f64) -> Answer {
        check_acceleration(acceleration)?;
        let kind = |cycle: &Self| {
            let now = states(&cycle.target);
            Kind::JointSpeed(JointSpeed::new(&now, &JointSpeeds::ZERO, acceleration))
        };
        Ok(self.come_to_rest(command, kind))
    }

    pub(crate) fn stopl(&mut self, command: &Command, acceleration: f64) -> Answer {
        check_acceleration(acceleration)?;
        let kind = |cycle: &Self| {
            let mut tcp = cycle.tcp_mode();
            // A tool that turns on the spot has no speed of its TCP: turning counts as way as it does for lines.
            tcp.aim([0.0; 6], acceleration, acceleration / ROTATION_LENGTH);
            Kind::TcpSpeed(tcp)
        };
        Ok(self.come_to_rest(command, kind))
    }

    /// Ends what moves the arm by `kind`, which begins with what it does now, planned motions as well as online modes.
    fn come_to_rest(&mut self, command: &Command, kind: impl Fn(&Self) -> Kind) -> Ending {
        self.drop_motions_to_come();
        if matches!(self.generator, Generator::Hold) {
            // A motion whose plan is not finished has not moved the arm yet.
            return Ending::Now;
        }
        self.is_paused = false;
        if matches!(self.generator, Generator::Brake(_)) {
            self.waiting.add(command.id, WaitingFor::Stop);
            return Ending::Later;
        }
        let kind = kind(self);
        self.end_legs(Outcome::Aborted);
        self.begin_online(command, MotionMode::Stopping, CallEnd::Reached, kind);
        // Also at a speed fraction of 0 the arm must come to rest.
        if let Generator::Online(online) = &mut self.generator {
            online.is_stopping = true;
        }
        Ending::Later
    }

    pub(crate) fn freedrive(
        &mut self,
        command: &Command,
        free_axes: [bool; 6],
        frame: FreedriveFrame,
    ) -> Answer {
        if let FreedriveFrame::Pose(pose) = frame
            && !pose.is_finite()
        {
            return Err(bad_value("frame", f64::NAN, "a pose of finite numbers"));
        }
        let freedrive = Freedrive::new(&self.online_arm(), &self.target, free_axes, frame);
        let kind = Kind::Freedrive(freedrive);
        self.begin_online(command, MotionMode::Freedrive, CallEnd::Over, kind);
        Ok(Ending::Now)
    }

    /// Freedrive begins while an input with that action is high and the arm stands, and ends when no such input is high
    /// any more (manual 5.27). No command stands behind it.
    pub(crate) fn follow_input_actions(&mut self) {
        let is_led =
            matches!(&self.generator, Generator::Online(online) if online.is_led_by_hand());
        self.io.leads_by_hand &= is_led;
        match (self.io.wants_freedrive(), self.io.leads_by_hand) {
            // A program that leads by hand already goes on doing so.
            (true, false) if !is_led => {
                let (free_axes, frame) = ([true; 6], FreedriveFrame::Base);
                let command = Command {
                    id: CommandId::NONE,
                    origin: Origin::default(),
                    kind: CommandKind::Freedrive { free_axes, frame },
                };
                // While the arm is busy or not ready it is asked again in the next cycle.
                let begins = self.rule(&command) == Rule::Act;
                self.io.leads_by_hand =
                    begins && self.freedrive(&command, free_axes, frame).is_ok();
            }
            (false, true) => {
                if let Generator::Online(online) = &mut self.generator {
                    online.make_way(&self.target);
                }
                self.io.leads_by_hand = false;
            }
            _ => {}
        }
    }

    pub(crate) fn end_freedrive(&mut self, id: CommandId) -> Ending {
        let is_freedrive = |c: &mut Command| matches!(c.kind, CommandKind::Freedrive { .. });
        if let Some(deferred) = self.deferred.take_if(is_freedrive) {
            self.out.ended(deferred.id, Outcome::Aborted);
        }
        match &mut self.generator {
            Generator::Online(online) if online.is_led_by_hand() => {
                if stands(&self.target) {
                    self.generator = Generator::Hold;
                    return Ending::Now;
                }
                online.make_way(&self.target);
                self.waiting.add(id, WaitingFor::Stop);
                Ending::Later
            }
            _ => Ending::Now,
        }
    }

    pub(crate) fn set_gravity(&mut self, gravity: [f64; 3]) -> Answer {
        self.gravity = gravity.into();
        self.dynamics = self.model.dynamics(&self.payload, self.gravity);
        self.plant.believe(&self.dynamics, &self.gravity);
        self.collision.restart();
        Ok(Ending::Now)
    }

    pub(crate) fn set_external_wrench(&mut self, wrench: [f64; 6]) -> Answer {
        self.external.set = Wrench::from_array(wrench);
        Ok(Ending::Now)
    }

    /// A load on the tool for some time.
    pub(crate) fn push(
        &mut self,
        wrench: [f64; 6],
        in_tool_axes: bool,
        duration: f64,
        replaces: bool,
    ) -> Answer {
        let now = self.out.cycle as f64 * self.step;
        let load = Load {
            at: now,
            duration,
            wrench: Wrench::from_array(wrench),
            frame: match in_tool_axes {
                true => LoadFrame::Tool,
                false => LoadFrame::Base,
            },
        };
        match self.external.push(load, now, replaces) {
            true => Ok(Ending::Now),
            false => Err(bad_value(
                "the number of pushes at once",
                (PUSHES_MAX + 1) as f64,
                "at most 32",
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
    ) -> Answer {
        self.external.port_sensor = enabled.then(|| PortSensor {
            mass,
            measuring_offset: measuring_offset.into(),
            cog: cog.into(),
        });
        Ok(Ending::Now)
    }

    pub(crate) fn set_input(&mut self, index: u8, level: bool) -> Answer {
        if index > 27 {
            return Err(bad_value(
                "the index of the input",
                f64::from(index),
                "0 to 27",
            ));
        }
        let mask = 1 << index;
        let levels = if level { mask } else { 0 };
        self.io.apply(&IoChange::DigitalIn { mask, levels });
        Ok(Ending::Now)
    }
}

fn call_end(duration: Option<f64>) -> Result<CallEnd, Refusal> {
    match duration {
        None => Ok(CallEnd::Reached),
        Some(duration) => check_duration(duration).map(|()| CallEnd::After(duration)),
    }
}

fn check_duration(duration: f64) -> Result<(), Refusal> {
    if duration > 0.0 && duration <= LONGEST {
        return Ok(());
    }
    Err(bad_value(
        "t",
        duration,
        "more than 0 and at most 1000000 s",
    ))
}

fn check_acceleration(acceleration: f64) -> Result<(), Refusal> {
    if acceleration >= SLOWEST && acceleration.is_finite() {
        return Ok(());
    }
    Err(bad_value(
        "a",
        acceleration,
        "a number of at least 0.000001",
    ))
}

fn check_speeds(speeds: &[f64; 6]) -> Result<(), Refusal> {
    match speeds.iter().find(|x| !(-1000.0..=1000.0).contains(*x)) {
        None => Ok(()),
        Some(&bad) => Err(bad_value("a speed", bad, "at most 1000")),
    }
}
