//! Runs the script threads of one task on one OS thread, in a fixed order, and lets time pass when all of them wait.
//!
//! Script threads are coroutines (see elite-lang); a slice ends when fuel runs out, at a wait, or at the end. Ready
//! threads run round robin; threads whose wait ends in the same cycle go on in the order of their numbers. So a run is
//! the same every time under the virtual clock. The scheduler is a future on the task's own single-threaded tokio runtime.

use std::collections::{BTreeMap, VecDeque};
use std::rc::Rc;
use std::sync::Arc;
use std::time::Duration;

use elite_lang::{
    Diagnostic, Interpreter, KnownNames, Limits, ProgramKind, Resume, ScriptError, ScriptThread,
    SourceFile, Step, WaitToken,
};
use io_bus::Fieldbus;
use motion_api::{
    CommandId, CommandKind, IoChange, MotionMode, Origin, ProgramId, RobotMode, StopReason, ThreadNumber,
};
use tokio::sync::mpsc;
use tokio::time::Instant;

use super::context::TaskContext;
use super::host::TaskHost;
use super::wait::Wait;
use crate::builtins;
use crate::message::{Message, Observer, Severity};
use crate::permissions::Permissions;
use crate::robot::Robot;

/// Safepoints a script thread may pass before the next one has its turn: well under a millisecond of work.
const FUEL_PER_SLICE: u32 = 20_000;
/// Safepoints for the `finally` and `with` blocks of a thread that is being stopped.
const FUEL_FOR_UNWINDING: u32 = 200_000;
/// How often a thread is told to stop before it is dropped as it is.
const STOPS_MAX: u32 = 3;
/// Longest time to wait for the arm to stand after the end of a program, in simulated seconds.
const SETTLE_TIME_MAX: f64 = 5.0;

/// How far virtual time at wall pace may be behind before it no longer catches up.
const PACE_BACKLOG_MAX: Duration = Duration::from_millis(50);

/// A program as text.
#[derive(Clone, Debug)]
pub struct ProgramText {
    /// The name in messages: a file name, or where it came from.
    pub name: String,
    /// The source.
    pub text: String,
}

/// What a task needs from its surroundings.
#[derive(Clone)]
pub struct TaskSettings {
    /// The robot.
    pub robot: Arc<Robot>,
    /// Who is told.
    pub observer: Arc<dyn Observer>,
    /// Seed of the task's random numbers.
    pub seed: u64,
    /// Modbus devices, serial ports and the controller's own Modbus values; they outlive tasks.
    pub fieldbus: Arc<Fieldbus>,
    /// What scripts may reach.
    pub permissions: Permissions,
}

/// What others ask of a running task.
#[derive(Debug)]
pub enum Control {
    /// End it.
    Stop,
    /// Hold it.
    Pause,
    /// Let it go on.
    Resume,
    /// Run a secondary program beside it.
    Secondary(ProgramText),
}

/// How a task ended.
#[derive(Clone, Debug, PartialEq)]
pub enum TaskEnd {
    /// Its main program ran to the end.
    Finished,
    /// It did not compile; the findings were reported.
    NotCompiled,
    /// An exception was not caught; it was reported.
    Failed,
    /// Somebody stopped it.
    Stopped,
    /// The arm went into a protective stop.
    ProtectiveStop(StopReason),
}

/// A task on its own thread.
pub(crate) struct Task {
    settings: TaskSettings,
    context: Rc<TaskContext>,
    host: Rc<TaskHost>,
    interpreter: Interpreter,
    known: KnownNames,
    threads: BTreeMap<ThreadNumber, Entry>,
    ready: VecDeque<ThreadNumber>,
    controls: mpsc::Receiver<Control>,
    paused: bool,
    stops_at_start: u64,
    end: Option<TaskEnd>,
    /// When the next virtual cycle is due while a thread waits on the outside world.
    next_paced_cycle: Option<Instant>,
    secondaries: u32,
}

struct Entry {
    script: ScriptThread,
    waiting: Option<Waiting>,
    secondary: bool,
    line_reported: (u64, u32),
}

/// Why a thread is not ready.
#[derive(Clone, Copy)]
enum Waiting {
    /// A builtin waits for something in the wait table.
    Token(WaitToken),
    /// The language waits (a lock, a queue) until it is woken or this simulated time, s, has come.
    Parked { until: Option<f64> },
}

/// Secondary programs have numbers from here on, so that they never meet those of `start_thread`.
const FIRST_SECONDARY: u32 = 1 << 31;

impl Task {
    pub fn new(
        settings: TaskSettings,
        program: ProgramId,
        controls: mpsc::Receiver<Control>,
    ) -> Self {
        let context = TaskContext::new(&settings, program);
        let host = Rc::new(TaskHost::new(context.clone(), settings.seed));
        let natives = builtins::natives(&context);
        let known = KnownNames::new(builtins::all().map(|b| b.name));
        let interpreter = Interpreter::new(host.clone(), natives, Limits::default());
        let stops_at_start = settings.robot.protective_stops().0;
        Self {
            settings,
            context,
            host,
            interpreter,
            known,
            threads: BTreeMap::new(),
            ready: VecDeque::new(),
            controls,
            paused: false,
            stops_at_start,
            end: None,
            next_paced_cycle: None,
            secondaries: 0,
        }
    }

    /// Runs the program to its end; the arm stands when this returns.
    pub async fn run(mut self, program: ProgramText) -> TaskEnd {
        self.settings.robot.timeline().drive(true);
        let end = match self.start_program(ThreadNumber(0), program) {
            Ok(()) => {
                self.program_runs(true);
                self.run_threads().await
            }
            Err(()) => TaskEnd::NotCompiled,
        };
        self.stop_all_threads();
        self.program_runs(false);
        self.settle().await;
        self.settings.robot.timeline().drive(false);
        end
    }

    /// Compiles and readies a program. Findings are reported.
    fn start_program(&mut self, number: ThreadNumber, text: ProgramText) -> Result<(), ()> {
        let file = SourceFile::new(text.name, text.text);
        let program = match elite_lang::compile(file.clone(), &self.known) {
            Ok(program) => program,
            Err(findings) => {
                for finding in &findings {
                    self.report_finding(finding, &file);
                }
                return Err(());
            }
        };
        let secondary = program.kind() == ProgramKind::Secondary;
        let script = self.interpreter.spawn_program(&program);
        self.add_thread(number, script, secondary);
        Ok(())
    }

    fn report_finding(&self, finding: &Diagnostic, file: &SourceFile) {
        let place = finding.fields(file);
        let summary = format!("SyntaxError: {}", finding.message);
        let picture = elite_lang::render_human(finding, file, false);
        self.settings.observer.message(&Message::ScriptError {
            program: self.context.program(),
            line: place.line,
            column: place.column,
            report: format!("{}\n{summary}", picture.trim_end()),
            summary,
        });
    }

    fn add_thread(&mut self, number: ThreadNumber, script: ScriptThread, secondary: bool) {
        self.threads.insert(
            number,
            Entry {
                script,
                waiting: None,
                secondary,
                line_reported: (u64::MAX, 0),
            },
        );
        self.ready.push_back(number);
    }

    async fn run_threads(&mut self) -> TaskEnd {
        let mut slices = 0_u32;
        loop {
            while let Ok(control) = self.controls.try_recv() {
                self.take(control);
            }
            self.look_for_protective_stop();
            if let Some(end) = self.end.take() {
                return end;
            }
            if self.paused {
                self.hold().await;
                continue;
            }
            if let Some(number) = self.ready.pop_front() {
                self.run_slice(number);
                slices = slices.wrapping_add(1);
                // While somebody waits on the outside world it must be looked at, even if another thread computes.
                let outside = self.context.outside().is_open();
                if outside || slices.is_multiple_of(64) {
                    tokio::task::yield_now().await;
                }
                // Under the real clock the world goes on while scripts compute.
                if outside || !self.settings.robot.timeline().is_virtual() {
                    self.end_waits();
                }
                continue;
            }
            self.let_time_pass().await;
            self.end_waits();
        }
    }

    fn take(&mut self, control: Control) {
        match control {
            Control::Stop => self.end = Some(TaskEnd::Stopped),
            Control::Pause if !self.paused => {
                self.paused = true;
                self.tell_robot(CommandKind::Pause);
                self.program_runs(false);
            }
            Control::Resume if self.paused => {
                self.paused = false;
                self.tell_robot(CommandKind::Resume);
                self.program_runs(true);
            }
            Control::Pause | Control::Resume => {}
            Control::Secondary(program) => {
                let number = ThreadNumber(FIRST_SECONDARY + self.secondaries);
                self.secondaries = (self.secondaries + 1) % FIRST_SECONDARY;
                // Findings were reported; a secondary program never ends the task.
                let _ = self.start_program(number, program);
            }
        }
    }

    fn tell_robot(&self, kind: CommandKind) {
        let origin = Origin {
            program: self.context.program(),
            ..Origin::default()
        };
        if let Err(full) = self.settings.robot.send(origin, kind) {
            let text = format!("{} was not carried out: {full}", kind.name());
            self.settings
                .observer
                .message(&Message::log(Severity::Error, origin, text));
        }
    }

    /// For outputs that follow the run state (manual 5.20 to 5.25). A held program does not run.
    fn program_runs(&self, runs: bool) {
        self.tell_robot(CommandKind::SetIo(IoChange::ProgramRunning(runs)));
        self.settings.fieldbus.program_running(runs);
    }

    fn look_for_protective_stop(&mut self) {
        let (stops, reason) = self.settings.robot.protective_stops();
        if stops != self.stops_at_start
            && let Some(reason) = reason
        {
            self.end = Some(TaskEnd::ProtectiveStop(reason));
        }
    }

    /// One slice of one thread, and what it asked for.
    fn run_slice(&mut self, number: ThreadNumber) {
        let Some(entry) = self.threads.get_mut(&number) else {
            return;
        };
        self.context.enter(number, entry.secondary);
        let step = entry.script.resume(Resume::Continue, FUEL_PER_SLICE);
        self.report_line(number);
        match step {
            Step::OutOfFuel => self.ready.push_back(number),
            Step::Waiting(token) => self.suspend(number, Waiting::Token(token)),
            Step::Parked { until } => self.suspend(number, Waiting::Parked { until }),
            Step::Done(_) | Step::Stopped => self.thread_ended(number),
            Step::Failed(error) => self.thread_failed(number, &error),
        }
        if let Some(end) = self.context.take_end() {
            self.end.get_or_insert(end);
        }
        self.start_requested_threads();
        self.ready_woken_threads();
        for stop in self.context.take_stops() {
            self.stop_thread(stop);
        }
    }

    fn suspend(&mut self, number: ThreadNumber, waiting: Waiting) {
        if let Some(entry) = self.threads.get_mut(&number) {
            entry.waiting = Some(waiting);
        }
    }

    /// Threads that the slice woke by what it did in the language (released a lock, put into a queue).
    fn ready_woken_threads(&mut self) {
        for id in self.host.take_woken() {
            let woken = self
                .threads
                .iter_mut()
                .find(|(_, entry)| entry.script.id() == id);
            if let Some((number, entry)) = woken
                && matches!(entry.waiting, Some(Waiting::Parked { .. }))
            {
                entry.waiting = None;
                self.ready.push_back(*number);
            }
        }
    }

    fn start_requested_threads(&mut self) {
        for (number, script) in self.host.take_started() {
            self.add_thread(number, script, false);
        }
        for (number, function, args) in self.context.take_starts() {
            match self.interpreter.spawn_call(function, args) {
                Ok(script) => self.add_thread(number, script, false),
                Err(error) => {
                    self.context.thread_ended(number);
                    self.report_script_error(&error);
                    self.end = Some(TaskEnd::Failed);
                }
            }
        }
    }

    fn thread_ended(&mut self, number: ThreadNumber) {
        self.threads.remove(&number);
        self.context.thread_ended(number);
        if number == ThreadNumber(0) {
            self.end.get_or_insert(TaskEnd::Finished);
        }
    }

    fn thread_failed(&mut self, number: ThreadNumber, error: &ScriptError) {
        let secondary = self
            .threads
            .get(&number)
            .is_some_and(|entry| entry.secondary);
        if secondary {
            let origin = Origin {
                program: self.context.program(),
                thread: number,
                line: line_of(error),
            };
            let text = format!("[SEC] Exception: {}", error.headline());
            self.settings
                .observer
                .message(&Message::log(Severity::Warning, origin, text));
        } else {
            self.report_script_error(error);
            self.end = Some(TaskEnd::Failed);
        }
        self.thread_ended(number);
    }

    fn report_script_error(&self, error: &ScriptError) {
        self.settings.observer.message(&Message::ScriptError {
            program: self.context.program(),
            line: line_of(error),
            column: error.place().map_or(1, |frame| frame.column),
            summary: error.headline(),
            report: elite_lang::render_script_error(error),
        });
    }

    /// Tells the observer where a thread stands, at most once a cycle.
    fn report_line(&mut self, number: ThreadNumber) {
        let cycle = self.settings.robot.state().cycle;
        let Some(entry) = self.threads.get_mut(&number) else {
            return;
        };
        let line = entry.script.current_line();
        let (reported_cycle, reported_line) = entry.line_reported;
        if line != reported_line && cycle != reported_cycle {
            entry.line_reported = (cycle, line);
            self.settings
                .observer
                .line_changed(self.context.program(), number, line);
        }
    }

    /// Readies every thread whose wait is over, in the order of their numbers.
    fn end_waits(&mut self) {
        let robot = &self.settings.robot;
        let state = robot.state();
        let is_over = |waiting: Waiting| match waiting {
            Waiting::Parked { until } => until.is_some_and(|time| state.time >= time),
            Waiting::Token(token) => match self.context.wait_of(token) {
                Wait::Command(id) => robot.has_ended(id),
                Wait::Cycle(wanted) => state.cycle >= wanted,
                Wait::Outside(job) => self.context.outside().is_done(job),
                Wait::Thread(other) => !self.threads.contains_key(&other),
                Wait::Never => false,
            },
        };
        let over: Vec<ThreadNumber> = self
            .threads
            .iter()
            .filter(|(_, entry)| entry.waiting.is_some_and(is_over))
            .map(|(number, _)| *number)
            .collect();
        for number in over {
            self.end_wait(number);
            self.ready.push_back(number);
        }
    }

    /// Forgets what a thread waits for; gives back the wait's entry in the table.
    fn end_wait(&mut self, number: ThreadNumber) -> Option<Wait> {
        let waiting = self.threads.get_mut(&number)?.waiting.take()?;
        let Waiting::Token(token) = waiting else {
            return None;
        };
        let wait = self.context.wait_of(token);
        self.context.end_wait(token);
        Some(wait)
    }

    /// One virtual cycle, or whatever comes first under the real clock: a cycle or a control.
    async fn let_time_pass(&mut self) {
        if self.context.outside().is_open() && self.settings.robot.timeline().is_virtual() {
            return self.let_time_pass_at_wall_pace().await;
        }
        self.next_paced_cycle = None;
        let robot = &self.settings.robot;
        if robot.timeline().advance() {
            robot.pump();
            return;
        }
        tokio::select! {
            () = robot.progress() => {}
            () = self.context.outside().news() => {}
            control = self.controls.recv() => match control {
                Some(control) => self.take(control),
                // The supervisor is gone: nobody could stop this task any more.
                None => self.end = Some(TaskEnd::Stopped),
            }
        }
    }

    /// Whatever comes first: news from outside, a control, or the wall time of one virtual cycle.
    async fn let_time_pass_at_wall_pace(&mut self) {
        let robot = self.settings.robot.clone();
        let step = Duration::from_secs_f64(robot.state().step_time);
        let now = Instant::now();
        // After a long computation time does not race to catch up.
        let due = match self.next_paced_cycle {
            Some(due) if due + PACE_BACKLOG_MAX > now => due,
            _ => now + step,
        };
        self.next_paced_cycle = Some(due);
        tokio::select! {
            biased;
            () = self.context.outside().news() => {}
            control = self.controls.recv() => match control {
                Some(control) => self.take(control),
                None => self.end = Some(TaskEnd::Stopped),
            },
            () = tokio::time::sleep_until(due) => {
                self.next_paced_cycle = Some(due + step);
                robot.timeline().advance();
                robot.pump();
            }
        }
    }

    /// While paused: the arm decelerates, then simulated time stands until somebody asks for something.
    async fn hold(&mut self) {
        let robot = &self.settings.robot;
        let stands = robot.state().target_qd.max_abs() == 0.0;
        if robot.timeline().is_virtual() && stands {
            match self.controls.recv().await {
                Some(control) => self.take(control),
                None => self.end = Some(TaskEnd::Stopped),
            }
        } else {
            self.let_time_pass().await;
        }
    }

    /// Stops a thread and what it was waiting for. Its `finally` and `with` blocks run first, within the language's bound.
    fn stop_thread(&mut self, number: ThreadNumber) {
        match self.end_wait(number) {
            Some(Wait::Command(id)) => {
                self.settings.robot.forget(id);
                self.tell_robot(CommandKind::Stop { only: id });
            }
            Some(Wait::Outside(job)) => self.context.outside().cancel(job),
            _ => {}
        }
        let Some(entry) = self.threads.get_mut(&number) else {
            return;
        };
        self.context.enter(number, entry.secondary);
        for _ in 0..STOPS_MAX {
            // Out of fuel in its clean-up: the next stop unwinds without running more of it.
            match entry.script.resume(Resume::Stop, FUEL_FOR_UNWINDING) {
                Step::OutOfFuel | Step::Waiting(_) | Step::Parked { .. } => {}
                Step::Done(_) | Step::Failed(_) | Step::Stopped => break,
            }
        }
        self.ready.retain(|n| *n != number);
        self.thread_ended(number);
    }

    fn stop_all_threads(&mut self) {
        while let Some(number) = self.threads.keys().next_back().copied() {
            self.stop_thread(number);
        }
        // Started while the others unwound: they never run.
        drop(self.host.take_started());
    }

    /// Ends what still moves and waits, within a bound, until the arm stands.
    async fn settle(&mut self) {
        let robot = self.settings.robot.clone();
        let started = robot.state();
        if started.command_id != CommandId::NONE || started.motion_mode == MotionMode::Conveyor {
            self.tell_robot(CommandKind::Stop {
                only: CommandId::NONE,
            });
        }
        if self.paused {
            self.tell_robot(CommandKind::Resume);
        }
        let deadline = started.time + SETTLE_TIME_MAX;
        // One cycle at least, so that commands the program sent last are taken and recorded.
        let first = started.cycle + 1;
        loop {
            let state = robot.state();
            let stands =
                state.target_qd.max_abs() == 0.0 && state.actual_qd.max_abs() < STANDSTILL_SPEED;
            let powered = state.robot_mode == RobotMode::Running;
            if state.cycle > first && (!powered || stands) || state.time > deadline {
                return;
            }
            if robot.timeline().advance() {
                robot.pump();
            } else {
                robot.progress().await;
            }
        }
    }
}

/// Where the error was raised; line 1 for an error without a place.
fn line_of(error: &ScriptError) -> u32 {
    error.place().map_or(1, |frame| frame.line)
}

/// Below this joint speed (rad/s) the arm counts as standing.
const STANDSTILL_SPEED: f64 = 1e-3;
