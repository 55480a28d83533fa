//! The life of programs: starts tasks, replaces one by the next, passes on stop, pause and secondary programs.
//!
//! Owns the life cycle of tasks (each on an OS thread of its own) and the status that ports show. What happens inside a
//! task is `task`'s. There is one main program at a time: a second one that compiles ends the first by force and begins
//! as soon as that has unwound, while the arm may still brake (`task::HandoverStop`).

mod ask;

use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};
use std::time::Duration;

use elite_syntax::{Diagnostic, KnownNames, SourceFile};
use messages::{Localized, Text, text};
use motion_api::{CommandId, CommandKind, MachineCommand, Origin, ProgramId};
use supervision::{CaughtPanic, Fault, ThreadRole, catch};
use thiserror::Error;
use tokio::sync::{Mutex as Turns, watch};

pub use ask::NoAnswer;

use crate::compile_pool::CompilePool;
use crate::external::InputMode;
use crate::interpreter::InterpreterMode;
use crate::message::{Message, Observer, Severity};
use crate::panel::{Panel, Watchdogs};
use crate::preset::Preset;
use crate::task::{
    ControlReceiver, ControlSender, FinishedTask, HandoverStop, Instrumentation, ProgramSource,
    ProgramText, Task, TaskEnd, TaskSettings, control_channel, message_of,
};
use crate::test_task::TestTaskConfig;

/// How long a new main program waits for one that it replaces: far longer than `finally` blocks may take. A secondary
/// program that runs alone is waited for as long before it is replaced: it is short and has something to set up.
pub const REPLACE_TIMEOUT: Duration = Duration::from_secs(2);

/// Numbers of programs that attend others come after this, so that the two never meet.
const FIRST_TEST_PROGRAM: u32 = 1 << 20;

/// How long a secondary program waits for room beside a task that is flooded with such (the refusal must come soon),
/// and a sender for its program to begin.
const SECONDARY_TIMEOUT: Duration = Duration::from_millis(500);
/// How often a secondary program is offered to a task: each time that one ends and another begins.
const ATTEMPTS_TO_JOIN: u32 = 2;

/// What the task is doing, as ports show it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum TaskState {
    /// Nothing runs.
    #[default]
    Stopped,
    /// A program runs.
    Running,
    /// A program is held.
    Paused,
}

/// What ports and `run` see of the current task.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct TaskStatus {
    /// What the task is doing.
    pub state: TaskState,
    /// The newest program; 0 before the first.
    pub program: ProgramId,
    /// The main program has had its first turn, so that what it does first is done.
    pub has_begun: bool,
    /// True when it was told to stop and has not ended yet.
    pub ending: bool,
    /// How the newest program ended, once it has.
    pub end: Option<TaskEnd>,
}

/// The reason for which a program was not started.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
#[non_exhaustive]
pub enum SubmitError {
    /// Another one runs and does not end, or takes no further secondary program.
    #[error("program \"{refused}\" was refused: program \"{running}\" runs and does not make way")]
    #[zh("程序 \"{refused}\" 被拒绝：程序 \"{running}\" 正在运行且不让位")]
    Running {
        /// The new one.
        refused: String,
        /// The one that runs.
        running: String,
    },
    /// The new program does not compile, so the one that runs goes on; the findings were reported.
    #[error("program \"{refused}\" was refused: it does not compile")]
    #[zh("程序 \"{refused}\" 被拒绝：无法编译")]
    NotCompiled {
        /// The new one.
        refused: String,
    },
    /// The compiler has too much to do, or has failed.
    #[error("program \"{refused}\" was refused: {reason}")]
    #[zh("程序 \"{refused}\" 被拒绝：{reason}")]
    NoCompiler {
        /// The new one.
        refused: String,
        /// What is wrong.
        reason: Text,
    },
    /// The operating system gave no thread.
    #[error("program \"{refused}\" was refused: no thread for it ({reason})")]
    #[zh("程序 \"{refused}\" 被拒绝：没有线程可用（{reason}）")]
    NoThread {
        /// The new one.
        refused: String,
        /// What the system said.
        reason: Text,
    },
}

/// Starts and stops programs on one robot. Clones share everything.
#[derive(Clone)]
pub struct Supervisor {
    shared: Arc<ProgramSlot>,
}

struct ProgramSlot {
    settings: TaskSettings,
    pool: Arc<CompilePool>,
    known: Arc<KnownNames>,
    interpreter: Arc<InterpreterMode>,
    current: Mutex<CurrentTask>,
    /// What main programs find set.
    presets: Mutex<Arc<[Preset]>>,
    /// Main programs take the place of one another in the order in which they came.
    turns: Turns<()>,
    status: watch::Sender<TaskStatus>,
    /// Where questions run while no program does.
    aside: OnceLock<Supervisor>,
}

#[derive(Default)]
struct CurrentTask {
    last_program: u32,
    running: Option<RunningTask>,
    /// What the program before has left moving.
    braking: Option<HandoverStop>,
}

impl CurrentTask {
    /// A number for a program.
    fn next_program(&mut self) -> ProgramId {
        self.last_program += 1;
        ProgramId(self.last_program)
    }
}

struct RunningTask {
    name: String,
    is_secondary: bool,
    controller: ControlSender,
}

impl Supervisor {
    /// A supervisor without a program.
    pub fn new(settings: TaskSettings) -> Self {
        let (status, _) = watch::channel(TaskStatus::default());
        let pool = Arc::new(CompilePool::new(settings.faults.clone()));
        let news = settings.panel.news().clone();
        let attendant = settings.extras.attendant.as_ref();
        let current = CurrentTask {
            last_program: attendant.map_or(0, |_| FIRST_TEST_PROGRAM),
            ..CurrentTask::default()
        };
        let known = crate::builtins::all().map(|builtin| builtin.name);
        let known = KnownNames::new(known.chain(attendant.and_then(|attendant| attendant.object)));
        let shared = ProgramSlot {
            interpreter: Arc::new(InterpreterMode::new(news, pool.clone())),
            settings,
            pool,
            known: Arc::new(known),
            current: Mutex::new(current),
            presets: Mutex::default(),
            turns: Turns::default(),
            status,
            aside: OnceLock::new(),
        };
        Self {
            shared: Arc::new(shared),
        }
    }

    /// Starts and stops programs beside those of this one, on the same arm: see [`TestTaskConfig`].
    pub fn test_supervisor(&self, observer: Arc<dyn Observer>, attendant: TestTaskConfig) -> Self {
        let settings = &self.shared.settings;
        let extras = Instrumentation {
            attendant: Some(attendant),
            stand_ins: settings.extras.stand_ins.clone(),
            line_counts: None,
            debug: None,
        };
        Self::new(TaskSettings {
            observer,
            // The panel of a program that attends others is its own: what it shows and asks stays there.
            panel: Arc::new(Panel::new(settings.panel.operator())),
            extras,
            // Only the program it looks at is told in a recording.
            course: InputMode::Live,
            ..settings.clone()
        })
    }

    /// The statements of interpreter mode.
    pub fn interpreter(&self) -> &InterpreterMode {
        &self.shared.interpreter
    }

    /// Where texts from outside are compiled.
    pub fn compile_pool(&self) -> &CompilePool {
        &self.shared.pool
    }

    /// Globals that every main program from now on finds set. They replace those of before.
    pub fn set_presets(&self, presets: &[Preset]) {
        *self.presets() = presets.into();
    }

    fn presets(&self) -> MutexGuard<'_, Arc<[Preset]>> {
        let presets = self.shared.presets.lock();
        presets.unwrap_or_else(PoisonError::into_inner)
    }

    /// What runs right now.
    pub fn status(&self) -> TaskStatus {
        self.shared.status.borrow().clone()
    }

    /// Follows the status.
    pub fn watch(&self) -> watch::Receiver<TaskStatus> {
        self.shared.status.subscribe()
    }

    /// Starts a program that `sender` wants to run. A secondary one (`sec`) joins the running task. A main one takes
    /// the place of the one that runs, which is ended by force; one that does not compile changes nothing. A program
    /// that ran to its end may still have the arm on its way: it is replaced like any other.
    ///
    /// # Errors
    /// [`SubmitError`]; it was also reported to the observer, as a script error of the refused program.
    pub async fn submit(
        &self,
        program: ProgramText,
        sender: &str,
    ) -> Result<ProgramId, SubmitError> {
        let presets = self.presets().clone();
        self.submit_with(program, sender, presets).await
    }

    /// [`submit`](Self::submit) with globals that this program finds set, and no other.
    ///
    /// # Errors
    /// [`SubmitError`]
    pub async fn submit_with(
        &self,
        program: ProgramText,
        sender: &str,
        presets: Arc<[Preset]>,
    ) -> Result<ProgramId, SubmitError> {
        let secondary = is_secondary(&program.text);
        let started = if secondary {
            self.submit_secondary(program).await
        } else {
            self.submit_main(program, sender, presets).await
        };
        if let Err(error) = &started
            && !matches!(error, SubmitError::NotCompiled { .. })
        {
            let summary = text!("RuntimeError: {error}", "RuntimeError: {error}");
            let message = if secondary {
                Message::secondary_exception(Origin::default(), &summary)
            } else {
                Message::ScriptError {
                    program: ProgramId::default(),
                    line: 1,
                    column: 1,
                    report: summary.clone(),
                    summary,
                }
            };
            self.shared.settings.observer.message(&message);
        }
        started
    }

    async fn submit_secondary(&self, program: ProgramText) -> Result<ProgramId, SubmitError> {
        let name = program.name.clone();
        let mut source = ProgramSource::Text(program);
        // A task that ends right now does not take it any more; its successor does, or it runs on its own.
        for _ in 0..ATTEMPTS_TO_JOIN {
            if let Some(id) = self.join_secondary(&mut source).await {
                return Ok(id);
            }
            let turn = self.shared.turns.lock().await;
            if let Some(id) = self.join_secondary(&mut source).await {
                return Ok(id);
            }
            if !self.is_running() {
                return self.start(name, true, source, self.presets().clone());
            }
            drop(turn);
            let is_ending = self.status().ending;
            self.wait_until_stopped(if is_ending {
                REPLACE_TIMEOUT
            } else {
                SECONDARY_TIMEOUT
            })
            .await;
        }
        let _turn = self.shared.turns.lock().await;
        self.start(name, true, source, self.presets().clone())
    }

    /// Hands a secondary program to the running task, compiled, so that a long text does not hold that up; `None` when
    /// no task took it. One that does not compile is told and done with.
    async fn join_secondary(&self, source: &mut ProgramSource) -> Option<ProgramId> {
        if !self.is_running() {
            return None;
        }
        if let ProgramSource::Text(program) = source {
            let text = core::mem::take(&mut program.text);
            let file = SourceFile::new(program.name.clone(), text);
            let compiling = self.shared.interpreter.compile(Arc::clone(&file));
            let told = match compiling.await {
                Ok(Ok(program)) => {
                    *source = ProgramSource::Compiled(program);
                    Vec::new()
                }
                Ok(Err(findings)) => findings
                    .iter()
                    .map(|finding| {
                        let summary = text!("SyntaxError: {}", "SyntaxError: {}", finding.message);
                        (finding.fields(&file).line, summary)
                    })
                    .collect(),
                Err(trouble) => vec![(
                    1,
                    text!("RuntimeError: {trouble}", "RuntimeError: {trouble}"),
                )],
            };
            if !told.is_empty() {
                return Some(self.report_secondary(told));
            }
        }
        let joined = {
            let current = self.current();
            let running = current.running.as_ref()?;
            match &*source {
                ProgramSource::Compiled(program) => running.controller.join(program)?,
                ProgramSource::Text(_) => return None,
            }
        };
        joined.await.ok()?;
        Some(self.status().program)
    }

    /// What keeps a secondary program from running, by line, as of one that runs beside the program that does.
    fn report_secondary(&self, told: Vec<(u32, Text)>) -> ProgramId {
        let program = self.status().program;
        for (line, summary) in told {
            let origin = Origin {
                program,
                line,
                ..Origin::default()
            };
            let message = Message::secondary_exception(origin, &summary);
            self.shared.settings.observer.message(&message);
        }
        program
    }

    async fn submit_main(
        &self,
        program: ProgramText,
        sender: &str,
        presets: Arc<[Preset]>,
    ) -> Result<ProgramId, SubmitError> {
        let name = program.name.clone();
        let mut source = ProgramSource::Text(program);
        // Before its turn, so that a long text holds nobody up.
        if self.is_running() {
            source = self.compiled(source).await?;
        }
        let _turn = self.shared.turns.lock().await;
        if self.is_running() {
            source = self.compiled(source).await?;
            let successor = format!("program \"{name}\" from {sender}");
            self.end_current(successor).await;
        }
        let id = self.start(name, false, source, presets)?;
        self.wait_until_begun(id).await;
        Ok(id)
    }

    /// Returns when a program has had its first turn, so that a sender's programs begin in their order. One that is
    /// held, or takes long to compile, is not waited for.
    async fn wait_until_begun(&self, id: ProgramId) {
        let mut status = self.watch();
        let is_past = |s: &TaskStatus| {
            s.program != id || s.has_begun || s.ending || s.state != TaskState::Running
        };
        let _ = tokio::time::timeout(SECONDARY_TIMEOUT, status.wait_for(is_past)).await;
    }

    /// Compiles a text where texts are compiled; what is compiled stays as it is.
    async fn compiled(&self, source: ProgramSource) -> Result<ProgramSource, SubmitError> {
        let ProgramSource::Text(program) = source else {
            return Ok(source);
        };
        let ProgramText { name, text } = program;
        let (bytes, known) = (text.len(), Arc::clone(&self.shared.known));
        let file = SourceFile::new(name.clone(), text);
        let copy = Arc::clone(&file);
        let compiling = self
            .shared
            .pool
            .run(bytes, move || elite_syntax::compile(copy, &known));
        match compiling.await {
            Ok(Ok(program)) => Ok(ProgramSource::Compiled(program)),
            Ok(Err(findings)) => {
                self.report(&findings, &file);
                Err(SubmitError::NotCompiled { refused: name })
            }
            Err(trouble) => Err(SubmitError::NoCompiler {
                refused: name,
                reason: Text::of(&trouble),
            }),
        }
    }

    /// Tells what is wrong with a program that was not started, as of one that was.
    fn report(&self, findings: &[Diagnostic], file: &SourceFile) {
        let id = self.current().next_program();
        let observer = &self.shared.settings.observer;
        observer.program_started(id, file.name(), file.text());
        for finding in findings {
            observer.message(&message_of(finding, file, id));
        }
        observer.program_ended(id);
    }

    /// Ends what runs for `successor`; returns when it has ended, or when it should have long ago.
    async fn end_current(&self, successor: String) {
        if self.runs_secondary_alone() {
            self.wait_until_stopped(REPLACE_TIMEOUT).await;
        }
        {
            let current = self.current();
            let Some(running) = &current.running else {
                return;
            };
            running.controller.replace(successor.into());
            self.shared.settings.observer.release_backpressure();
            let status = &self.shared.status;
            status.send_modify(|status| status.ending = true);
        }
        self.wait_until_stopped(REPLACE_TIMEOUT).await;
    }

    /// Returns when no program runs, after `patience` in any case.
    async fn wait_until_stopped(&self, patience: Duration) {
        let mut status = self.watch();
        let stopped = status.wait_for(|s| s.state == TaskState::Stopped);
        // Whether it ended in time is decided by `start`.
        let _ = tokio::time::timeout(patience, stopped).await;
    }

    fn is_running(&self) -> bool {
        self.current().running.is_some()
    }

    fn runs_secondary_alone(&self) -> bool {
        let current = self.current();
        current.running.as_ref().is_some_and(|r| r.is_secondary)
    }

    /// What people see and answer.
    pub fn panel(&self) -> &Panel {
        &self.shared.settings.panel
    }

    fn start(
        &self,
        name: String,
        is_secondary: bool,
        source: ProgramSource,
        presets: Arc<[Preset]>,
    ) -> Result<ProgramId, SubmitError> {
        let mut current = self.current();
        if let Some(running) = &current.running {
            return Err(SubmitError::Running {
                refused: name,
                running: running.name.clone(),
            });
        }
        let id = current.next_program();
        let (controller, controls) = control_channel();
        let (called_program, braking) = (name.clone(), current.braking.take());
        let shared = Arc::clone(&self.shared);
        self.shared.interpreter.task_starts();
        self.shared.status.send_replace(TaskStatus {
            state: TaskState::Running,
            program: id,
            has_begun: false,
            ending: false,
            end: None,
        });
        let called = format!("task-{}", id.0);
        let faults = self.shared.settings.faults.clone();
        faults
            .start(ThreadRole::Task, called, move || {
                shared.run_task(id, &called_program, source, presets, controls, braking)
            })
            .map_err(|error| {
                self.shared.interpreter.task_ended();
                self.shared.status.send_replace(TaskStatus::default());
                SubmitError::NoThread {
                    refused: name.clone(),
                    reason: Text::of(&error),
                }
            })?;
        current.running = Some(RunningTask {
            name,
            is_secondary,
            controller,
        });
        Ok(id)
    }

    /// Begins a program of a recorded run again, under the number that it had, with these globals set.
    ///
    /// # Errors
    /// [`SubmitError`]: another one runs, or there is no thread.
    pub fn rerun_program(
        &self,
        id: ProgramId,
        program: ProgramText,
        presets: &[Preset],
    ) -> Result<(), SubmitError> {
        self.set_presets(presets);
        self.current().last_program = id.0.saturating_sub(1);
        let is_secondary = is_secondary(&program.text);
        let name = program.name.clone();
        self.start(
            name,
            is_secondary,
            ProgramSource::Text(program),
            presets.into(),
        )?;
        Ok(())
    }

    /// Ends the running program, if one runs.
    pub fn stop(&self) {
        let current = self.current();
        if let Some(running) = &current.running {
            running.controller.stop();
            self.shared.settings.observer.release_backpressure();
            self.shared
                .status
                .send_modify(|status| status.ending = true);
        }
    }

    /// Holds the running program and the arm on its path. The status says so once the program is held.
    pub fn pause(&self) {
        if let Some(running) = &self.current().running {
            running.controller.pause();
            self.shared.settings.observer.release_backpressure();
        }
    }

    /// Lets a held program go on.
    pub fn resume(&self) {
        if let Some(running) = &self.current().running {
            running.controller.resume();
        }
    }

    /// Gives the robot a command that no program asked for. A full ring is reported to the observer.
    pub fn command(&self, kind: CommandKind) {
        if let Err(full) = self.shared.settings.robot.send(Origin::default(), kind) {
            let text = text!(
                "{} was not carried out: {full}",
                "{} 没有执行：{full}",
                kind.name()
            );
            self.shared.settings.observer.message(&Message::log(
                Severity::Error,
                Origin::default(),
                text,
            ));
        }
    }

    /// Waits until no program runs; the last end, `None` when there was none.
    pub async fn ended(&self) -> Option<TaskEnd> {
        let mut status = self.watch();
        // The sender lives as long as this supervisor, so waiting cannot fail.
        status
            .wait_for(|s| s.state == TaskState::Stopped)
            .await
            .ok()
            .and_then(|s| s.end.clone())
    }

    fn current(&self) -> MutexGuard<'_, CurrentTask> {
        self.shared
            .current
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

impl ProgramSlot {
    fn run_task(
        &self,
        id: ProgramId,
        name: &str,
        source: ProgramSource,
        presets: Arc<[Preset]>,
        controls: ControlReceiver,
        braking: Option<HandoverStop>,
    ) {
        // Dropped after `ending`, which tells everybody that the task has ended.
        let leftovers;
        let mut ending = TaskEndGuard {
            shared: self,
            id,
            end: TaskEnd::Failed,
            braking: None,
        };
        let observer = self.settings.observer.clone();
        observer.program_started(id, name, source.text());
        let debug = self.settings.extras.debug.clone();
        if let Some(debug) = &debug {
            debug.begins(id, name, source.text());
        }
        match tokio::runtime::Builder::new_current_thread()
            .enable_all()
            // Where nobody is out there, time-outs are simulated time: the clock of the runtime follows its waits.
            .start_paused(self.settings.extras.stand_ins.is_some())
            .build()
        {
            Ok(runtime) => {
                let (interpreter, status) = (self.interpreter.clone(), self.status.clone());
                let settings = self.settings.clone();
                let ran = catch(|| {
                    let task = Task::new(settings, interpreter, id, controls, status, braking);
                    let task = task.with_presets(presets);
                    tokio::task::LocalSet::new().block_on(&runtime, task.run(source))
                });
                // Whatever the program left on it is not waited for.
                runtime.shutdown_background();
                let ended = ran.unwrap_or_else(|panicked| FinishedTask {
                    end: self.handle_task_panic(id, panicked),
                    braking: None,
                    leftovers: None,
                });
                leftovers = ended.leftovers;
                (ending.end, ending.braking) = (ended.end, ended.braking);
            }
            Err(error) => {
                let text = text!(
                    "the program could not be started: {error}",
                    "无法启动程序：{error}"
                );
                observer.message(&Message::log(Severity::Error, Origin::default(), text));
                leftovers = None;
            }
        }
        drop(ending);
        drop(leftovers);
    }

    /// A fault outside the program itself, which the task could not contain: nobody else will stop the arm.
    fn handle_task_panic(&self, id: ProgramId, panicked: CaughtPanic) -> TaskEnd {
        let fault = Fault::new(ThreadRole::Task, format!("program {}", id.0), panicked);
        self.settings.faults.tell(&fault);
        let only = CommandId::NONE;
        for command in [
            CommandKind::Machine(MachineCommand::Stop { only }),
            CommandKind::Machine(MachineCommand::Resume),
        ] {
            // A full ring belongs to a cycle that takes nothing, which moves nothing either.
            let _ = self.settings.robot.send(Origin::default(), command);
        }
        let message = Message::internal_error(id, 1, &Text::verbatim(fault.describe()));
        self.settings.observer.message(&message);
        TaskEnd::Failed
    }
}

/// The end of a task for everybody who waits for it, whatever ended it.
struct TaskEndGuard<'a> {
    shared: &'a ProgramSlot,
    id: ProgramId,
    end: TaskEnd,
    braking: Option<HandoverStop>,
}

impl Drop for TaskEndGuard<'_> {
    fn drop(&mut self) {
        let (shared, id) = (self.shared, self.id);
        // Each of these must happen, also when another meets a fault.
        let _ = catch(|| shared.interpreter.task_ended());
        let _ = catch(|| shared.settings.panel.with_watchdogs(Watchdogs::clear));
        let _ = catch(|| shared.settings.observer.program_ended(id));
        if let Some(debug) = &shared.settings.extras.debug {
            let _ = catch(|| debug.ended(id));
        }
        // Under one lock: a program that starts right now must not have its status overwritten.
        let current = shared.current.lock();
        let mut current = current.unwrap_or_else(PoisonError::into_inner);
        current.running = None;
        current.braking = self.braking.take();
        shared.status.send_replace(TaskStatus {
            state: TaskState::Stopped,
            program: id,
            has_begun: true,
            ending: false,
            end: Some(self.end.clone()),
        });
    }
}

/// True when the first statement of the text heads a secondary program.
pub(crate) fn is_secondary(text: &str) -> bool {
    text.lines()
        .map(|line| line.split('#').next().unwrap_or_default().trim_end())
        // Directives may stand before a program as comments may.
        .find(|line| !line.is_empty() && !line.trim_start().starts_with('$'))
        .is_some_and(|line| {
            line.strip_prefix("sec")
                .is_some_and(|rest| rest.starts_with([' ', '\t']))
        })
}
