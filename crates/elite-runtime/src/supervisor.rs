//! Which program runs: starts tasks, refuses a second main program, passes on stop, pause and secondary programs.
//!
//! Owns the life cycle of tasks (each on an OS thread of its own) and the status that ports show. What happens inside a
//! task is `task`'s.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use motion_api::{CommandId, CommandKind, Origin, ProgramId};
use supervision::{Fault, Kind, Panicked, catch};
use thiserror::Error;
use tokio::sync::{oneshot, watch};

use crate::interpreter::Interpreter;
use crate::message::{Message, Severity};
use crate::panel::{Panel, Watchdogs};
use crate::task::{Controller, Controls, ProgramText, Task, TaskEnd, TaskSettings, controls};

/// How long a new main program waits for one that is ending.
pub const GRACE: Duration = Duration::from_secs(2);

/// How long a new main program waits for one that has not been told to end: programs of one line follow each other
/// within milliseconds. A refusal must come within a second.
const PATIENCE: Duration = Duration::from_millis(500);

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
    /// What it is doing.
    pub state: TaskState,
    /// The newest program; 0 before the first.
    pub program: ProgramId,
    /// True when it was told to stop and has not ended yet.
    pub ending: bool,
    /// How the newest program ended, once it has.
    pub end: Option<TaskEnd>,
}

/// Why a program was not started.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum SubmitError {
    /// Another one runs.
    #[error("program \"{refused}\" was refused: program \"{running}\" is running; stop it first")]
    Running {
        /// The new one.
        refused: String,
        /// The one that runs.
        running: String,
    },
    /// The operating system gave no thread.
    #[error("program \"{refused}\" was refused: no thread for it ({reason})")]
    NoThread {
        /// The new one.
        refused: String,
        /// What the system said.
        reason: String,
    },
}

/// Starts and stops programs on one robot. Clones share everything.
#[derive(Clone)]
pub struct Supervisor {
    shared: Arc<Shared>,
}

struct Shared {
    settings: TaskSettings,
    interpreter: Arc<Interpreter>,
    current: Mutex<Current>,
    status: watch::Sender<TaskStatus>,
}

#[derive(Default)]
struct Current {
    last_program: u32,
    running: Option<Running>,
}

struct Running {
    name: String,
    controller: Controller,
}

impl Supervisor {
    /// A supervisor without a program.
    pub fn new(settings: TaskSettings) -> Self {
        let (status, _) = watch::channel(TaskStatus::default());
        let shared = Shared {
            interpreter: Arc::new(Interpreter::new(settings.panel.news().clone())),
            settings,
            current: Mutex::default(),
            status,
        };
        Self {
            shared: Arc::new(shared),
        }
    }

    /// The statements of interpreter mode.
    pub fn interpreter(&self) -> &Interpreter {
        &self.shared.interpreter
    }

    /// What runs right now.
    pub fn status(&self) -> TaskStatus {
        self.shared.status.borrow().clone()
    }

    /// Follows the status.
    pub fn watch(&self) -> watch::Receiver<TaskStatus> {
        self.shared.status.subscribe()
    }

    /// Starts a program. A secondary one (`sec`) joins the running task. A main one is refused while another runs: after
    /// half a second, or after [`GRACE`] when the running one has been told to end.
    ///
    /// # Errors
    /// [`SubmitError`]; it was also reported to the observer as a script error of the refused program.
    pub async fn submit(&self, program: ProgramText) -> Result<ProgramId, SubmitError> {
        let secondary = is_secondary(&program.text);
        if secondary && let Some(taken) = self.join_running(&program) {
            // A task that ends right now does not take it any more; then it runs on its own.
            if taken.await.is_ok() {
                return Ok(self.status().program);
            }
        }
        let mut status = self.watch();
        let patience = if status.borrow_and_update().ending {
            GRACE
        } else {
            PATIENCE
        };
        // Whether it ended in time is decided by `start`.
        let _ = tokio::time::timeout(patience, status.wait_for(|s| s.state == TaskState::Stopped))
            .await;
        let started = self.start(program);
        if let Err(error) = &started {
            let summary = format!("RuntimeError: {error}");
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

    /// What people see and answer.
    pub fn panel(&self) -> &Panel {
        &self.shared.settings.panel
    }

    /// Hands a secondary program to the running task; the receiver hears whether it was taken.
    fn join_running(&self, program: &ProgramText) -> Option<oneshot::Receiver<()>> {
        let current = self.current();
        let running = current.running.as_ref()?;
        running.controller.join(program.clone())
    }

    fn start(&self, program: ProgramText) -> Result<ProgramId, SubmitError> {
        let mut current = self.current();
        if let Some(running) = &current.running {
            return Err(SubmitError::Running {
                refused: program.name,
                running: running.name.clone(),
            });
        }
        let id = ProgramId(current.last_program + 1);
        let (controller, controls) = controls();
        let name = program.name.clone();
        let shared = Arc::clone(&self.shared);
        self.shared.interpreter.task_starts();
        self.shared.status.send_replace(TaskStatus {
            state: TaskState::Running,
            program: id,
            ending: false,
            end: None,
        });
        let called = format!("task-{}", id.0);
        let faults = self.shared.settings.faults.clone();
        faults
            .start(Kind::Task, called, move || {
                shared.run_task(id, program, controls)
            })
            .map_err(|error| {
                self.shared.interpreter.task_ended();
                self.shared.status.send_replace(TaskStatus::default());
                SubmitError::NoThread {
                    refused: name.clone(),
                    reason: error.to_string(),
                }
            })?;
        current.last_program = id.0;
        current.running = Some(Running { name, controller });
        Ok(id)
    }

    /// Ends the running program, if one runs.
    pub fn stop(&self) {
        let current = self.current();
        if let Some(running) = &current.running {
            running.controller.stop();
            self.shared
                .status
                .send_modify(|status| status.ending = true);
        }
    }

    /// Holds the running program and the arm on its path. The status says so once the program is held.
    pub fn pause(&self) {
        if let Some(running) = &self.current().running {
            running.controller.pause();
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
            let text = format!("{} was not carried out: {full}", kind.name());
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

    fn current(&self) -> MutexGuard<'_, Current> {
        self.shared
            .current
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }
}

impl Shared {
    fn run_task(&self, id: ProgramId, program: ProgramText, controls: Controls) {
        let mut ending = Ending {
            shared: self,
            id,
            end: TaskEnd::Failed,
        };
        let observer = self.settings.observer.clone();
        observer.program_started(id, &program.name, &program.text);
        match tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
        {
            Ok(runtime) => {
                let (interpreter, status) = (self.interpreter.clone(), self.status.clone());
                let settings = self.settings.clone();
                let ran = catch(|| {
                    let task = Task::new(settings, interpreter, id, controls, status);
                    tokio::task::LocalSet::new().block_on(&runtime, task.run(program))
                });
                // Whatever the program left on it is not waited for.
                runtime.shutdown_background();
                ending.end = ran.unwrap_or_else(|panicked| self.met_fault(id, panicked));
            }
            Err(error) => {
                let text = format!("the program could not be started: {error}");
                observer.message(&Message::log(Severity::Error, Origin::default(), text));
            }
        }
    }

    /// A fault outside the program itself, which the task could not contain: nobody else will stop the arm.
    fn met_fault(&self, id: ProgramId, panicked: Panicked) -> TaskEnd {
        let fault = Fault::new(Kind::Task, format!("program {}", id.0), panicked);
        self.settings.faults.tell(&fault);
        let only = CommandId::NONE;
        for command in [CommandKind::Stop { only }, CommandKind::Resume] {
            // A full ring belongs to a cycle that takes nothing, which moves nothing either.
            let _ = self.settings.robot.send(Origin::default(), command);
        }
        let message = Message::internal_error(id, 1, &fault.what());
        self.settings.observer.message(&message);
        TaskEnd::Failed
    }
}

/// The end of a task for everybody who waits for it, whatever ended it.
struct Ending<'a> {
    shared: &'a Shared,
    id: ProgramId,
    end: TaskEnd,
}

impl Drop for Ending<'_> {
    fn drop(&mut self) {
        let (shared, id) = (self.shared, self.id);
        // Each of these must happen, also when another meets a fault.
        let _ = catch(|| shared.interpreter.task_ended());
        let _ = catch(|| shared.settings.panel.with_watchdogs(Watchdogs::clear));
        let _ = catch(|| shared.settings.observer.program_ended(id));
        // Under one lock: a program that starts right now must not have its status overwritten.
        let current = shared.current.lock();
        let mut current = current.unwrap_or_else(PoisonError::into_inner);
        current.running = None;
        shared.status.send_replace(TaskStatus {
            state: TaskState::Stopped,
            program: id,
            ending: false,
            end: Some(self.end.clone()),
        });
    }
}

/// True when the first statement of the text heads a secondary program.
pub(crate) fn is_secondary(text: &str) -> bool {
    text.lines()
        .map(|line| line.split('#').next().unwrap_or_default().trim_end())
        .find(|line| !line.is_empty())
        .is_some_and(|line| {
            line.strip_prefix("sec")
                .is_some_and(|rest| rest.starts_with([' ', '\t']))
        })
}
