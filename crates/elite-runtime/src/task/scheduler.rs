//! Runs the script threads of one task on one OS thread, in a fixed order.
//!
//! Script threads are coroutines (see elite-lang); a slice ends when fuel runs out, at a wait, or at the end. Ready
//! threads run round robin; threads whose wait ends in the same cycle go on in the order of their numbers. So a run is
//! the same every time under the virtual clock. The scheduler is a future on the task's own single-threaded tokio
//! runtime. A program gets there by `startup`; `pause` suspends it, `time` makes time pass, `report` informs people.

use std::collections::VecDeque;

use std::rc::Rc;
use std::sync::Arc;

use elite_lang::{FreeListPurge, Interpreter, Limits, Resume, ResumeOutcome, ScriptThread};
use elite_syntax::{KnownNames, Program, ProgramKind};
use io_bus::{Fieldbus, ProgramState};
use messages::{Text, text};
use motion_api::{CommandKind, Origin, ProgramId, StopReason, ThreadNumber};
use supervision::{CatchPanic, CaughtPanic, Fault, ThreadRole, ThreadSupervisor, catch, injection};
use tokio::sync::watch;

use super::context::{TaskContext, TaskRequest};
use super::controls::{Control, ControlReceiver};
use super::handover::HandoverStop;
use super::host::{Permissions, TaskHost};
use super::inputs::{TurnCause, TurnPosition};
use super::instrumentation::Instrumentation;
use super::pause::Suspension;
use super::report::{PositionReports, ReportedPosition, VariableMonitor};
use super::threads::{BlockReason, SecondaryBudget, ThreadEntry, ThreadTable};
use super::time::WallPacing;
use crate::builtins;
use crate::debug::{DebuggedTask, SuspendState, TaskDebugger};
use crate::external::{ExternalInputKind, InputMode};
use crate::interpreter::InterpreterMode as StatementPort;
use crate::message::{Message, Observer, UnmeteredObserver};
use crate::panel::{Panel, Variables};
use crate::preset::Preset;
use crate::robot::Robot;
use crate::supervisor::TaskStatus;
use crate::task_folder::TaskFolder;
use crate::test_task::TestTaskHandle;
use crate::value_text::fixed_text;

/// Most names of the top level that are watched: each costs time in every period.
const TOP_LEVEL_NAMES_MAX: usize = 200;

/// What the language may use. How long a stopped program cleans up is decided here (`TaskContext::may_clean_up`).
fn limits() -> Limits {
    Limits {
        stop_fuel: u32::MAX,
        ..Limits::default()
    }
}

/// Safepoints a script thread may pass before the next one has its turn: well under a millisecond of work.
pub(super) const FUEL_PER_SLICE: u32 = 20_000;

/// Slices a secondary program may take: about a second of work (language.md 7). Counted, not timed, so that a run under
/// the virtual clock ends the same way on every machine.
const SLICES_OF_SECONDARY: u32 = 1000;
/// Longest a secondary program may wait for a lock of the main program, simulated seconds.
const WAIT_OF_SECONDARY: f64 = 1.0;
/// Most secondary programs at once; they are short, so more than a few mean that a client floods the task.
const SECONDARIES_MAX: usize = 16;

/// A program as text.
#[derive(Clone, Debug)]
pub struct ProgramText {
    /// The name in messages: a file name, or where it came from.
    pub name: String,
    /// The source.
    pub text: String,
}

/// The main program of a task.
pub(crate) enum ProgramSource {
    /// Compiled by the task.
    Text(ProgramText),
    /// Compiled before, so that it could take the place of another.
    Compiled(Program),
}

impl ProgramSource {
    /// The text.
    pub fn text(&self) -> &str {
        match self {
            Self::Text(program) => &program.text,
            Self::Compiled(program) => program.file().text(),
        }
    }
}

/// What is left of a task.
pub(crate) struct FinishedTask {
    /// How the task ended.
    pub end: TaskEnd,
    /// The arm may still be on its way to rest; only where another program takes the task's place.
    pub braking: Option<HandoverStop>,
    /// The memory of the task, which goes back to the system when the others know that the task has ended.
    pub leftovers: Option<Rc<FreeListPurge>>,
}

/// What a task needs from its surroundings.
#[derive(Clone)]
pub struct TaskSettings {
    /// The robot.
    pub robot: Arc<Robot>,
    /// The observer that messages go to.
    pub observer: Arc<dyn Observer>,
    /// Seed of the task's random numbers.
    pub seed: u64,
    /// Modbus devices, serial ports and the controller's own Modbus values; they outlive tasks.
    pub fieldbus: Arc<Fieldbus>,
    /// Flags, popups and what else outlives a task.
    pub panel: Arc<Panel>,
    /// What programs may reach beyond the robot.
    pub permissions: Permissions,
    /// Where tasks are kept.
    pub task_folder: TaskFolder,
    /// The supervisor that hears of faults in tasks.
    pub faults: ThreadSupervisor,
    /// What only tests of programs ask for.
    pub extras: Instrumentation,
    /// Whether what comes from outside is noted, or comes from a recording.
    pub course: InputMode,
}

/// How a task ended.
#[derive(Clone, Debug, PartialEq)]
pub enum TaskEnd {
    /// The main program ran to its end.
    Finished,
    /// The program did not compile; the findings were reported.
    NotCompiled,
    /// An exception was not caught; it was reported.
    Failed,
    /// Somebody stopped the task.
    Stopped,
    /// Another main program took the place of this one, as its log says.
    Replaced,
    /// The arm went into a protective stop.
    ProtectiveStop(StopReason),
}

/// A task on its own thread.
pub(crate) struct Task {
    pub(super) settings: TaskSettings,
    pub(super) context: Rc<TaskContext>,
    pub(super) host: Rc<TaskHost>,
    pub(super) interpreter: Interpreter,
    pub(super) known: KnownNames,
    pub(super) presets: Arc<[Preset]>,
    pub(super) threads: ThreadTable,
    pub(super) controls: ControlReceiver,
    pub(super) status: watch::Sender<TaskStatus>,
    pub(super) progress: TaskProgress,
    pub(super) suspension: Suspension,
    pub(super) turn: TurnPosition,
    pub(super) pacing: WallPacing,
    pub(super) monitor: VariableMonitor,
    pub(super) positions: PositionReports,
    /// The debugger of the task.
    pub(super) debugger: Option<Rc<dyn TaskDebugger>>,
    /// Commands for the robot that wait for room in the ring.
    pub(super) pending_commands: VecDeque<CommandKind>,
}

/// How far a task has come, and why it is to end.
pub(super) struct TaskProgress {
    /// The main program has had its first turn.
    pub has_begun: bool,
    /// The reason for which the task ends, once there is one.
    pub end: Option<TaskEnd>,
    /// The program that takes the place of the task once it has begun.
    pub successor: Option<Arc<str>>,
    /// A fault of the interpreter has left the language as it was: no script runs any more.
    pub is_broken: bool,
    /// Protective stops of the robot before the task: one more ends it.
    stops_at_start: u64,
}

impl TaskProgress {
    const fn new(stops_at_start: u64) -> Self {
        Self {
            has_begun: false,
            end: None,
            successor: None,
            is_broken: false,
            stops_at_start,
        }
    }
}

/// The task makes time pass, until this is dropped.
struct DriveGuard(Arc<Robot>);

impl DriveGuard {
    fn begin(robot: Arc<Robot>) -> Self {
        robot.timeline().set_driven(true);
        Self(robot)
    }
}

impl Drop for DriveGuard {
    fn drop(&mut self) {
        self.0.timeline().set_driven(false);
    }
}

impl Task {
    pub fn new(
        mut settings: TaskSettings,
        statements: Arc<StatementPort>,
        program: ProgramId,
        controls: ControlReceiver,
        status: watch::Sender<TaskStatus>,
        braking: Option<HandoverStop>,
    ) -> Self {
        settings.observer = Arc::new(UnmeteredObserver(settings.observer));
        let context = TaskContext::new(&settings, statements, program, braking);
        let host = Rc::new(TaskHost::new(
            context.clone(),
            settings.seed,
            settings.permissions.clone(),
        ));
        let natives = builtins::natives(&context);
        let known = KnownNames::new(builtins::names());
        let interpreter = Interpreter::new(host.clone(), natives, limits());
        let extras = &settings.extras;
        if let Some(attendant) = &extras.attendant {
            let methods = (attendant.methods)(&TestTaskHandle(context.clone()));
            if let Some(object) = attendant.object {
                interpreter.provide_object(object, methods);
            }
        }
        if extras.line_counts.is_some() {
            interpreter.count_lines();
        }
        let debug = settings.extras.debug.as_ref();
        let attached = debug.and_then(|link| link.attach(DebuggedTask(context.clone())));
        let stops_at_start = context.robot().protective_stops().0;
        task_memory::uncounted(|| settings.panel.with_variables(Variables::clear));
        Self {
            settings,
            context,
            host,
            interpreter,
            known,
            presets: Arc::default(),
            threads: ThreadTable::default(),
            controls,
            status,
            progress: TaskProgress::new(stops_at_start),
            suspension: Suspension::default(),
            turn: TurnPosition::default(),
            pacing: WallPacing::default(),
            monitor: VariableMonitor::default(),
            positions: PositionReports::default(),
            debugger: attached,
            pending_commands: VecDeque::new(),
        }
    }

    /// Sets the globals that the main program finds defined when it starts.
    pub fn with_presets(self, presets: Arc<[Preset]>) -> Self {
        Self { presets, ..self }
    }

    /// Runs the program to its end; the arm stands when this returns, unless another program takes its place. A fault
    /// of ours ends the program, not more: the arm comes to rest as after any other end.
    pub async fn run(mut self, program: ProgramSource) -> FinishedTask {
        let _driving = DriveGuard::begin(self.settings.robot.clone());
        self.context.robot().look();
        let ran = CatchPanic::new(self.run_program(program)).await;
        let mut end = ran.unwrap_or_else(|panicked| self.handle_panic(panicked));
        if let Some(attached) = self.debugger.clone().filter(|_| !self.progress.is_broken) {
            self.interpreter
                .halted(|halt| attached.before_end(halt, &end));
        }
        if !self.progress.is_broken {
            let ended = catch(|| {
                self.publish_variables(true);
                self.stop_all_threads();
            });
            if let Err(panicked) = ended {
                end = self.handle_panic(panicked);
            }
        }
        if self.progress.is_broken {
            self.give_up_threads();
        } else if self.settings.extras.line_counts.is_some() {
            let counted = self.interpreter.line_counts();
            task_memory::uncounted(|| self.settings.extras.add_counts(counted.clone()));
        }
        self.program_is(ProgramState::Stopped);
        let braking = self.settle(&end).await;
        if end == TaskEnd::Finished {
            self.context.show_effects_if(|_| true);
        }
        if let Some(repeat) = self.context.repeat() {
            repeat.ended(self.context.program(), self.context.robot().moment().cycle);
        }
        FinishedTask {
            end,
            braking,
            leftovers: Some(self.interpreter.free_list_purge()),
        }
    }

    /// Tells a fault as the error of the program. No script runs after it: what the language holds may be half changed.
    fn handle_panic(&mut self, panicked: CaughtPanic) -> TaskEnd {
        self.progress.is_broken = true;
        let program = self.context.program();
        let fault = Fault::new(ThreadRole::Task, format!("program {}", program.0), panicked);
        self.settings.faults.tell(&fault);
        let number = self.context.origin(0).thread;
        let line = catch(|| Some(self.threads.entries.get(&number)?.script.current_line()));
        let line = line.ok().flatten().unwrap_or(1).max(1);
        let message = Message::internal_error(program, line, &Text::verbatim(fault.describe()));
        self.settings.observer.message(&message);
        TaskEnd::Failed
    }

    /// Drops what is left of the program after a fault, which may meet others: they are its consequences.
    fn give_up_threads(&mut self) {
        self.threads.ready.clear();
        let threads = std::mem::take(&mut self.threads.entries);
        for entry in threads.into_values() {
            let _ = catch(move || drop(entry));
        }
        let _ = catch(|| self.host.close());
    }

    /// Readies a program.
    pub(super) fn start_program(&mut self, number: ThreadNumber, program: &Program) {
        self.remember_globals(program);
        let bounds = (program.kind() == ProgramKind::Secondary).then(|| SecondaryBudget {
            slices: SLICES_OF_SECONDARY,
            until: self.context.robot().moment().time + WAIT_OF_SECONDARY,
        });
        let script = self.interpreter.spawn_program(program);
        self.add_thread(number, script, bounds);
        if bounds.is_some()
            && let Some(entry) = self.threads.entries.get_mut(&number)
        {
            entry.answer = self.settings.panel.take_answer(program.file().name());
        }
    }

    fn remember_globals(&mut self, program: &Program) {
        self.context
            .interpreter()
            .add_globals(program.declared_globals());
        for name in program.declared_globals() {
            if !self.monitor.global_names.iter().any(|known| known == name) {
                self.monitor.global_names.push(name.to_owned());
            }
        }
        for name in program.global_names().take(TOP_LEVEL_NAMES_MAX) {
            let mut known = self
                .monitor
                .global_names
                .iter()
                .chain(&self.monitor.top_level_names);
            if !known.any(|known| known == name) {
                self.monitor.top_level_names.push(name.to_owned());
            }
        }
    }

    pub(super) fn add_thread(
        &mut self,
        number: ThreadNumber,
        script: ScriptThread,
        bounds: Option<SecondaryBudget>,
    ) {
        self.threads.entries.insert(
            number,
            ThreadEntry {
                script,
                waiting: None,
                secondary: bounds,
                answer: None,
                reported: ReportedPosition::default(),
            },
        );
        self.threads.ready.push_back(number);
    }

    /// Time passes by itself, or did when the run was recorded that is repeated.
    fn is_real(&self) -> bool {
        match self.context.repeat() {
            Some(repeat) => repeat.is_real(),
            None => !self.settings.robot.timeline().is_virtual(),
        }
    }

    /// The first turn: here what comes from outside begins to count.
    pub(super) fn begin_turns(&mut self) {
        if let Some(repeat) = self.context.repeat() {
            repeat.begins(self.context.program());
        }
        self.context.robot().look();
        self.turn.cycle = self.context.robot().moment().cycle;
        if self.context.witness().is_some() {
            let presets = self.presets.iter().map(Preset::statement).collect();
            self.context.note(ExternalInputKind::Started { presets });
        }
    }

    pub(super) async fn run_threads(&mut self) -> TaskEnd {
        let mut slices = 0_u32;
        loop {
            if self.settings.robot.timeline().has_ended() {
                return self.lost_clock();
            }
            if let Some(panicked) = self.context.outside().take_panic() {
                return self.handle_panic(panicked);
            }
            self.take_orders();
            if let Some(end) = self.follow_debugger().or_else(|| self.end_of_recording()) {
                return end;
            }
            self.apply_suspend_state();
            self.run_cycle_checks();
            self.end_for_successor();
            if let Some(end) = self.progress.end.clone() {
                // A main program that ran to its end does not take the secondary ones with it: they are short.
                match self.next_ready_secondary() {
                    Some(number) if end == TaskEnd::Finished => self.run_slice(number),
                    _ => return end,
                }
                continue;
            }
            if let Some(number) = self.next_ready() {
                self.run_slice(number);
                slices = slices.wrapping_add(1);
                // While somebody waits on the outside world it must be looked at, even if another thread computes.
                let outside = self.has_waits_outside();
                if outside || slices.is_multiple_of(64) {
                    tokio::task::yield_now().await;
                }
                self.look(TurnCause::Work);
                // Under the real clock the world goes on while scripts compute.
                if !self.suspension.is_active && (outside || self.is_real()) {
                    self.end_waits();
                }
                continue;
            }
            self.report_lines();
            if self.suspension.is_active {
                self.wait_while_paused().await;
                self.look(TurnCause::Wait);
                // A secondary program may wait for a command of its own; the others are ready when the task goes on.
                self.end_waits();
            } else {
                self.look(TurnCause::Work);
                if !self.end_outside_waits() {
                    self.let_time_pass().await;
                    self.look(TurnCause::Wait);
                    self.end_waits();
                }
            }
            self.ready_woken_threads();
        }
    }

    /// Ends the task for its successor, once the main program has had its first turn: whatever comes in is begun,
    /// however soon something else follows.
    fn end_for_successor(&mut self) {
        let may_end =
            self.progress.end.is_none() && (self.progress.has_begun || self.suspension.is_active);
        if let Some(successor) = self.progress.successor.as_ref().filter(|_| may_end) {
            self.report_replacement(successor);
            self.progress.end = Some(TaskEnd::Replaced);
        }
    }

    /// Nothing can move or pass any more, so nothing may wait.
    fn lost_clock(&self) -> TaskEnd {
        let program = self.context.program();
        let what = text!(
            "the control cycle has ended, nothing moves any more",
            "控制周期已结束，不再有任何运动"
        );
        let message = Message::internal_error(program, 1, &what);
        self.settings.observer.message(&message);
        TaskEnd::Failed
    }

    /// The thread whose turn it is. While the task is held, secondary programs still run.
    fn next_ready(&mut self) -> Option<ThreadNumber> {
        if self.suspension.is_active {
            let held = match self.holds() {
                SuspendState::At(held) => {
                    self.threads.ready.iter().position(|number| *number == held)
                }
                SuspendState::Nothing | SuspendState::Program => None,
            };
            match held {
                Some(position) => self.threads.ready.remove(position),
                None => self.next_ready_secondary(),
            }
        } else {
            self.threads.ready.pop_front()
        }
    }

    fn next_ready_secondary(&mut self) -> Option<ThreadNumber> {
        let threads = &self.threads.entries;
        let is_secondary = |n: &ThreadNumber| threads.get(n).is_some_and(|e| e.secondary.is_some());
        let position = self.threads.ready.iter().position(is_secondary)?;
        self.threads.ready.remove(position)
    }

    /// What is looked at once a cycle, however often the loop comes round.
    fn run_cycle_checks(&mut self) {
        self.look_for_protective_stop();
        let cycle = self.context.robot().moment().cycle;
        if cycle != self.turn.checked_cycle {
            self.turn.checked_cycle = cycle;
            self.context.show_due_effects();
            self.flush_commands();
            self.check_watchdogs();
            self.publish_variables(false);
            self.end_late_secondaries();
        }
    }

    pub(super) fn apply_control(&mut self, control: Control) {
        match control {
            Control::Stop => self.progress.end = Some(TaskEnd::Stopped),
            Control::Replace(successor) => self.progress.successor = Some(successor),
            Control::Pause => self.pause(),
            Control::Resume => {
                self.suspension.is_ordered = false;
                if self.holds() == SuspendState::Nothing {
                    self.go_on();
                }
            }
            // Dropping the sender says that this task has ended.
            Control::Secondary(..) if self.progress.end.is_some() => {}
            Control::Secondary(program, taken) => {
                // Whoever asked may have lost interest.
                let _ = taken.send(());
                self.start_secondary(&program);
                // The program was compiled on another thread, so its memory was never counted as this task's.
                task_memory::uncounted(|| drop(program));
            }
        }
    }

    pub(super) fn start_secondary(&mut self, program: &Program) {
        let running = self
            .threads
            .entries
            .values()
            .filter(|e| e.secondary.is_some());
        if running.count() >= SECONDARIES_MAX {
            let text = text!(
                "RuntimeError: \"{}\" was refused: {SECONDARIES_MAX} secondary programs run already",
                "RuntimeError: \"{}\" 被拒绝：已有 {SECONDARIES_MAX} 个次要程序在运行",
                program.file().name()
            );
            return self.warn_of_secondary(Origin::default(), &text);
        }
        let number = self.threads.next_secondary();
        self.start_program(number, program);
    }

    fn look_for_protective_stop(&mut self) {
        if self.settings.extras.attendant.is_some() {
            return;
        }
        let (stops, reason) = self.context.robot().protective_stops();
        if stops != self.progress.stops_at_start
            && let Some(reason) = reason
        {
            if self.progress.end.is_none() {
                self.report_protective_stop();
            }
            self.progress.end = Some(TaskEnd::ProtectiveStop(reason));
        }
    }

    /// One slice of one thread, and what it asked for.
    fn run_slice(&mut self, number: ThreadNumber) {
        let Some(entry) = self.threads.entries.get_mut(&number) else {
            return;
        };
        self.context
            .set_current_thread(number, entry.secondary.is_some());
        self.host.sockets().outside().forget(entry.script.id());
        injection::point("task");
        let step = entry.script.resume(Resume::Continue, FUEL_PER_SLICE);
        self.note_first_turn(number);
        self.report_nodes(number);
        match step {
            ResumeOutcome::OutOfFuel => self.out_of_fuel(number),
            ResumeOutcome::Waiting(token) => self.suspend(number, BlockReason::Token(token)),
            ResumeOutcome::Parked { until } => self.suspend(number, BlockReason::Parked { until }),
            ResumeOutcome::Done(value) => {
                self.answer(number, || fixed_text(&value));
                self.thread_ended(number);
            }
            ResumeOutcome::Stopped => self.thread_ended(number),
            ResumeOutcome::Failed(error) => self.thread_failed(number, &error),
        }
        if let Some(end) = self.context.take_end() {
            self.progress.end.get_or_insert(end);
        }
        self.start_requested_threads();
        self.ready_woken_threads();
        for stop in self.context.take_stops() {
            self.stop_thread(stop);
        }
        for request in self.context.take_requests() {
            match request {
                TaskRequest::Pause => self.pause(),
                TaskRequest::Halt => drop(self.progress.end.get_or_insert(TaskEnd::Finished)),
            }
        }
    }

    /// Says once that the main program has had its first turn.
    fn note_first_turn(&mut self, number: ThreadNumber) {
        if !self.progress.has_begun && number == ThreadNumber(0) {
            self.progress.has_begun = true;
            self.status.send_modify(|status| status.has_begun = true);
        }
    }

    fn out_of_fuel(&mut self, number: ThreadNumber) {
        if self.interpreter.is_gc_running() {
            // The thread has its next turn as soon as the garbage collector's search is over.
            return self.threads.ready.push_front(number);
        }
        let entry = self.threads.entries.get_mut(&number);
        if let Some(entry) = &entry {
            self.settings
                .panel
                .set_computing_line(entry.script.current_line());
        }
        if let Some(bounds) = entry.and_then(|entry| entry.secondary.as_mut()) {
            bounds.slices -= 1;
            if bounds.slices == 0 {
                let text = text!(
                    "TimeoutError: a secondary program has to be short, this one was ended after about a \
                     second of work",
                    "TimeoutError: 次要程序必须简短，这个程序运行约一秒后被结束"
                );
                return self.end_secondary(number, &text);
            }
        }
        self.threads.ready.push_back(number);
    }

    /// Ends a secondary program that does not keep to its bounds.
    pub(super) fn end_secondary(&mut self, number: ThreadNumber, reason: &Text) {
        let line = self
            .threads
            .entries
            .get(&number)
            .map_or(0, |e| e.script.current_line());
        let origin = Origin {
            program: self.context.program(),
            thread: number,
            line,
        };
        if !self.answer(number, || Err(reason.english().to_owned())) {
            self.warn_of_secondary(origin, reason);
        }
        self.stop_thread(number);
    }
}
