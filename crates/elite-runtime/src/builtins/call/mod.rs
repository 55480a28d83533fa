//! One call of a builtin: its arguments, checked against the declaration, and the ways to wait.
//!
//! Every message names the function, the argument, what was given and what is allowed.

mod arguments;

use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use elite_lang::{ExceptionKind, NativeCall, Unwind, Value};
use messages::{Localized, Text, text};
use motion_api::{
    CommandId, CommandKind, IoChange, MotionCommand, Origin, Outcome, PointList, Refusal,
    RobotState, SettingCommand,
};

use super::declare::{Body, Builtin, Parameter};
use crate::message::{Message, SCRIPT_ALARM_CODE, Severity};
use crate::task::{CallRestriction, Effect, JobId, NetworkAccess, TaskContext, TaskEnd, Wait};

/// Suspends the script thread that `native` belongs to until `future` has its result; other threads go on meanwhile.
pub(super) fn wait_for_future<T: 'static>(
    context: &TaskContext,
    native: &mut NativeCall<'_>,
    function: &str,
    future: impl Future<Output = T> + 'static,
) -> Result<T, Unwind> {
    let outside = context.outside();
    let job = outside.start(future);
    if let Err(stopping) = wait_for_job(context, native, job) {
        outside.cancel(job);
        return Err(stopping);
    }
    outside.take(job).ok_or_else(|| {
        let text = text!(
            "{function}(): the wait ended without a result",
            "{function}()：等待结束但没有结果"
        );
        native.raise(ExceptionKind::RuntimeError, text)
    })
}

/// Waits for a job; a program that plays others answers them meanwhile, since it may be one of them that it asks.
fn wait_for_job(
    context: &TaskContext,
    native: &mut NativeCall<'_>,
    job: JobId,
) -> Result<(), Unwind> {
    while !context.outside().is_done(job) {
        let wait = match context.run_wait_hook(native)? {
            true => Wait::Cycle(context.robot().moment().cycle + 1),
            false => Wait::Job(job),
        };
        native.wait(context.register_wait(wait))?;
    }
    Ok(())
}

/// Changes of points that a thread sends ahead of the arm behind one motion; for the next one it waits until the arm
/// has caught up.
const CHANGES_AHEAD: usize = 16;

/// A call in progress.
pub struct Call<'a, 'n> {
    builtin: &'static Builtin,
    context: &'a Rc<TaskContext>,
    native: &'a mut NativeCall<'n>,
}

impl<'a, 'n> Call<'a, 'n> {
    pub(super) fn new(
        builtin: &'static Builtin,
        context: &'a Rc<TaskContext>,
        native: &'a mut NativeCall<'n>,
    ) -> Result<Self, Unwind> {
        let mut call = Self {
            builtin,
            context,
            native,
        };
        if !context.count_call() {
            // Whoever unwinds may not wait, so this ends it.
            call.wait(Wait::Never)?;
        }
        if builtin.waits && context.is_secondary() {
            let name = builtin.name;
            let text = match context.bounds() {
                CallRestriction::Inspection => {
                    text!(
                        "{name}() waits; only the debug console of a program that runs here may wait",
                        "{name}() 会等待；只有在此处运行的程序的调试控制台才可以等待"
                    )
                }
                _ => text!(
                    "{name}() waits and cannot be used in a secondary program (sec)",
                    "{name}() 会等待，不能用在次要程序（sec）中"
                ),
            };
            return Err(call.error(ExceptionKind::RuntimeError, text));
        }
        Ok(call)
    }

    /// Runs a builtin whose answer comes from elsewhere: it is noted, or the recording gives it.
    pub(super) fn run_external(&mut self, run: Body) -> Result<Value, Unwind> {
        let (builtin, context) = (self.builtin, self.context);
        let arguments = self.native.args().to_vec();
        crate::external::call_external(context, self.native, builtin.name, &arguments, |native| {
            run(&mut Call {
                builtin,
                context,
                native,
            })
        })
    }

    /// The task the call belongs to.
    pub(crate) fn context(&self) -> &'a TaskContext {
        self.context
    }

    /// The task, for what outlives the call.
    pub(crate) fn shared_context(&self) -> Rc<TaskContext> {
        Rc::clone(self.context)
    }

    /// The call of the language, for what goes beyond robot builtins.
    pub fn native(&mut self) -> &mut NativeCall<'n> {
        self.native
    }

    /// The program, thread and line of the statement that made this call.
    pub fn origin(&self) -> Origin {
        self.context.origin(self.native.line())
    }

    /// The function's name.
    pub fn name(&self) -> &'static str {
        self.builtin.name
    }

    /// An exception with `text`, which should name the argument.
    pub fn error(&mut self, kind: ExceptionKind, text: impl Into<Text>) -> Unwind {
        self.native.raise(kind, text.into())
    }

    /// The argument as given, `None` when omitted.
    pub fn given(&self, index: usize) -> Option<&Value> {
        self.native.arg(index)
    }

    fn parameter(&self, index: usize) -> &'static Parameter {
        &self.builtin.params[index]
    }

    /// `movej(): a`, the beginning of every message about an argument.
    fn place(&self, index: usize) -> Text {
        text!(
            "{}(): {}",
            "{}()：{}",
            self.builtin.name,
            self.parameter(index).name
        )
    }

    fn wrong_type(&mut self, index: usize, wanted: &Text, got: &Value) -> Unwind {
        match self.show(got) {
            Ok(shown) => {
                let (place, name) = (self.place(index), got.type_name());
                self.error(
                    ExceptionKind::TypeError,
                    text!(
                        "{place} must be {wanted}, not {name} ({shown})",
                        "{place} 必须是{wanted}，不能是 {name}（{shown}）"
                    ),
                )
            }
            Err(raised) => raised,
        }
    }

    /// A value as Python writes it, shortened so that one long list does not fill the log.
    fn show(&mut self, value: &Value) -> Result<String, Unwind> {
        let text = self.native.repr(value)?;
        if text.chars().count() <= 60 {
            return Ok(text);
        }
        Ok(text.chars().take(57).chain("...".chars()).collect())
    }

    /// Ends the program with an alarm that everybody sees and no script catches. In a secondary program it is an
    /// exception.
    pub fn alarm(&mut self, sub_code: i32, text: &Text) -> Unwind {
        let text = text!("{}(): {text}", "{}()：{text}", self.builtin.name);
        if self.context.is_secondary() {
            return self.error(ExceptionKind::RuntimeError, text);
        }
        self.context.observer().message(&Message::Robot {
            origin: self.origin(),
            code: SCRIPT_ALARM_CODE,
            sub_code,
            severity: Severity::Error,
            text: text.clone(),
        });
        self.context.end_task(TaskEnd::Failed);
        // The task is ending; this thread only has to wait until it is unwound.
        match self.wait(Wait::Never) {
            Err(stopping) => stopping,
            Ok(()) => self.error(ExceptionKind::RuntimeError, text),
        }
    }

    /// Suspends the script thread until `wait` is over.
    pub(crate) fn wait(&mut self, wait: Wait) -> Result<(), Unwind> {
        if let Wait::Cycle(wanted) = wait {
            let now = || self.context.robot().moment().cycle;
            while now() + 1 < wanted && self.context.run_wait_hook(self.native)? {
                let token = self.context.register_wait(Wait::Cycle(now() + 1));
                self.native.wait(token)?;
            }
        }
        let token = self.context.register_wait(wait);
        self.native.wait(token)
    }

    /// Suspends the script thread until `future` has its result; other threads go on meanwhile.
    pub(crate) fn wait_for_future<T: 'static>(
        &mut self,
        future: impl Future<Output = T> + 'static,
    ) -> Result<T, Unwind> {
        wait_for_future(self.context, self.native, self.builtin.name, future)
    }

    /// Refuses what needs the network when scripts may not use it.
    pub(crate) fn check_net(&mut self) -> Result<(), Unwind> {
        if self.context.permissions().network != NetworkAccess::Nothing {
            return Ok(());
        }
        let text = text!(
            "{}(): scripts may not use the network; start the server with --allow net",
            "{}()：脚本不允许使用网络；请以 --allow net 启动服务器",
            self.builtin.name
        );
        Err(self.error(ExceptionKind::PermissionError, text))
    }

    /// Refuses a machine that nobody plays where scripts may use no other.
    pub(crate) fn check_simulated(&mut self, host: &str, port: u16) -> Result<(), Unwind> {
        let may_meet_others = self.context.permissions().network == NetworkAccess::Everything;
        if may_meet_others || self.context.has_responder(host, port) {
            return Ok(());
        }
        let text = text!(
            "{}(): nobody plays {host}:{port}, and scripts may use no other machine (--allow net=played)",
            "{}()：没有测试扮演 {host}:{port}，脚本不允许使用其他机器（--allow net=played）",
            self.builtin.name
        );
        Err(self.error(ExceptionKind::PermissionError, text))
    }

    /// A waiting time in seconds: `None`, for ever, when it is 0 or less.
    pub(crate) fn patience(&mut self, index: usize) -> Result<Option<Duration>, Unwind> {
        let seconds = self.number(index)?;
        Ok(if seconds > 0.0 {
            Duration::try_from_secs_f64(seconds).ok()
        } else {
            None
        })
    }

    /// A line of the log that names the builtin.
    pub(crate) fn warn(&mut self, text: &impl Localized) {
        let (name, origin) = (self.builtin.name, self.origin());
        let message = Message::log(
            Severity::Warning,
            origin,
            text!("{name}(): {text}", "{name}()：{text}"),
        );
        self.context.observer().message(&message);
    }

    /// Sends a command without waiting for its end; waits for room when the ring is full.
    pub fn send(&mut self, kind: impl Into<CommandKind>) -> Result<CommandId, Unwind> {
        self.enter(kind.into(), false)
    }

    fn enter(&mut self, kind: CommandKind, keep_outcome: bool) -> Result<CommandId, Unwind> {
        let origin = self.origin();
        let robot = self.context.robot();
        loop {
            let sent = if keep_outcome {
                robot.request(origin, kind)
            } else {
                robot.send(origin, kind)
            };
            match sent {
                Ok(id) => return Ok(id),
                Err(_) => self.wait(Wait::Cycle(robot.moment().cycle + 1))?,
            }
        }
    }

    /// The robot's state with what this program has set in this cycle.
    pub fn state(&self) -> RobotState {
        self.context.robot().foreseen().state
    }

    /// Gives a command that takes no simulated time: it is done in the next cycle, in the order of the program, and
    /// what the program asks from now on is answered as if it were done. Waits only for room in the ring.
    ///
    /// A refusal is an exception at the call.
    pub fn set(&mut self, kind: impl Into<CommandKind>) -> Result<(), Unwind> {
        let kind = kind.into();
        // Planned motions and streams wait and have been refused already; these return at once and the arm moves later.
        if kind.starts_motion() && self.context.is_secondary() {
            let name = self.builtin.name;
            let text = match self.context.bounds() {
                CallRestriction::Inspection => {
                    text!(
                        "{name}() moves the arm; only the debug console of a program that runs here may move it",
                        "{name}() 会使手臂运动；只有在此处运行的程序的调试控制台才可以使它运动"
                    )
                }
                _ => text!(
                    "{name}() moves the arm and cannot be used in a secondary program (sec)",
                    "{name}() 会使手臂运动，不能用在次要程序（sec）中"
                ),
            };
            return Err(self.error(ExceptionKind::RuntimeError, text));
        }
        self.wait_for_rest(&kind)?;
        if let Err(refusal) = self.context.robot().foreseen().check(&kind) {
            return Err(self.refusal_error(&refusal));
        }
        self.send(kind).map(drop)
    }

    /// The first motion of a program that has replaced another begins when the arm has come to rest.
    fn wait_for_rest(&mut self, kind: &CommandKind) -> Result<(), Unwind> {
        if kind.starts_motion()
            && let Some(stop) = self.context.braking()
        {
            self.wait(Wait::Command(stop))?;
        }
        if kind.starts_motion() {
            while let Some(motion) = self.context.first_left_behind() {
                self.wait(Wait::Command(motion))?;
            }
        }
        Ok(())
    }

    /// What a refusal is for a script: an exception that it can catch.
    pub(super) fn refusal_error(&mut self, refusal: &Refusal) -> Unwind {
        let kind = match refusal {
            Refusal::BadValue { .. } => ExceptionKind::ValueError,
            _ => ExceptionKind::RuntimeError,
        };
        let refusal = self.context.robot().sentence(refusal);
        let text = text!("{}(): {refusal}", "{}()：{refusal}", self.builtin.name);
        self.error(kind, text)
    }

    /// Sends a command and waits for its end, or, for a motion with a blend, until the next may follow.
    ///
    /// A refusal is a `RuntimeError` that the script can catch. A protective stop ends the task and cannot be caught.
    pub fn run_command(&mut self, kind: impl Into<CommandKind>) -> Result<(), Unwind> {
        let kind = kind.into();
        self.wait_for_rest(&kind)?;
        let id = self.enter(kind, true)?;
        self.wait_for_command(&kind, id)
    }

    /// Sends a moveml through points and waits for its end, as [`run_command`](Self::run_command) does.
    pub fn run_points(&mut self, points: &Arc<PointList>, interval: f64) -> Result<(), Unwind> {
        let count = points.count();
        let kind = CommandKind::Motion(MotionCommand::MoveMl { count, interval });
        self.wait_for_rest(&kind)?;
        let (origin, robot) = (self.origin(), self.context.robot());
        let id = loop {
            match robot.request_points(origin, points, interval) {
                Ok(id) => break id,
                Err(_) => self.wait(Wait::Cycle(robot.moment().cycle + 1))?,
            }
        };
        self.wait_for_command(&kind, id)
    }

    /// Waits for the end of a command that was sent, or until the next motion may follow.
    fn wait_for_command(&mut self, kind: &CommandKind, id: CommandId) -> Result<(), Unwind> {
        if kind.is_motion() {
            self.wait(Wait::Motion(id))?;
            if !self.context.robot().has_ended(id) {
                self.context.add_queued_motion(id);
                return Ok(());
            }
        } else {
            self.context.note_steering(kind, id);
            self.wait(Wait::Command(id))?;
        }
        self.check_outcome(id)
    }

    /// Waits until the arm has caught up with the motions of this thread whose calls have returned already: what a
    /// builtin reads and changes is that of the moment when the last of them has entered its blend. Where the arm would
    /// have to slow down for that, who `may_hurry` does not wait so long: only until the next motion is due.
    pub(super) fn wait_for_queued_motions(&mut self, may_hurry: bool) -> Result<(), Unwind> {
        if let Some(last) = self.context.last_ahead() {
            self.wait(match may_hurry {
                true => Wait::Due(last),
                false => Wait::Command(last),
            })?;
        }
        while let Some(id) = self.context.take_ended_ahead() {
            self.check_outcome(id)?;
        }
        Ok(())
    }

    /// Changes an output, a register or how a point is configured: now, or, where the program is ahead of the arm, when
    /// that enters the blend zone of this thread's last motion.
    pub fn change(&mut self, change: IoChange) -> Result<CommandId, Unwind> {
        if let Some(motion) = self.context.last_ahead() {
            if self.context.count_change_ahead(motion) <= CHANGES_AHEAD {
                return self.send(SettingCommand::SetIoAtZone { motion, change });
            }
            self.wait_for_queued_motions(false)?;
        }
        self.send(match change.standard_digital_out() {
            Some((index, level)) => {
                CommandKind::Setting(SettingCommand::SetStandardDigitalOut { index, level })
            }
            None => CommandKind::Setting(SettingCommand::SetIo(change)),
        })
    }

    /// Shows a message or sets a flag: now, or when the arm has caught up with this thread.
    pub(super) fn show_effect(&mut self, effect: &Effect) -> Result<(), Unwind> {
        while !self.context.show(effect) {
            self.wait_for_queued_motions(false)?;
        }
        Ok(())
    }

    /// Changes an output register; the next read of this thread sees it.
    pub fn change_register(&mut self, change: IoChange) -> Result<(), Unwind> {
        if self.context.last_ahead().is_some() {
            let id = self.change(change)?;
            self.context.note_register_change(id);
            return Ok(());
        }
        self.await_register_changes()?;
        self.context.robot().registers().change(&change);
        Ok(())
    }

    /// Waits until the output registers hold what this thread has written.
    pub fn await_register_changes(&mut self) -> Result<(), Unwind> {
        match self.context.take_register_change() {
            Some(id) if !self.context.robot().has_ended(id) => self.wait(Wait::Command(id)),
            _ => Ok(()),
        }
    }

    /// What the end of a command means for its caller.
    fn check_outcome(&mut self, id: CommandId) -> Result<(), Unwind> {
        match self.context.robot().take_outcome(id) {
            Some(Outcome::Done) | None => Ok(()),
            // The motion was ended by somebody else's stop; the program goes on after the call.
            Some(Outcome::Aborted) => Ok(()),
            Some(Outcome::Refused(refusal)) => Err(self.refusal_error(&refusal)),
            Some(Outcome::ProtectiveStop(reason)) if self.context.extras().attendant.is_some() => {
                let text = text!(
                    "{}(): the motion ended with a stop: {reason}",
                    "{}()：运动因停止而结束：{reason}",
                    self.name()
                );
                Err(self.error(ExceptionKind::RuntimeError, text))
            }
            Some(Outcome::ProtectiveStop(_)) => {
                // The task is ending because of the stop; this thread only has to wait until it is unwound.
                self.wait(Wait::Never)?;
                Ok(())
            }
        }
    }
}
