//! Statements from port 30020 on their way to the running task (manual chapter 2).
//!
//! Owns the queue that ports and task share, and decides which statements get into it. Entering interpreter mode, which
//! executes them, is not available yet: until then accepted statements wait, and are thrown away when the task ends.

use std::sync::{Mutex, MutexGuard, PoisonError};

use elite_lang::{KnownNames, SourceFile};

use crate::interpreter_queue::{Effect, Refused, StatementId, StatementQueue};

/// A statement with the way to tell its sender that it is thrown away after all.
pub struct Statement {
    /// The text.
    pub text: String,
    /// Called once when the statement is thrown away unexecuted; must not wait.
    pub thrown_away: Box<dyn FnOnce() + Send>,
}

/// What became of a statement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Submitted {
    /// It waits under this number.
    Accepted(StatementId),
    /// It does not compile; what is wrong with it.
    NotCompiled(String),
    /// No task runs.
    NoTask,
    /// The queue is full.
    Full,
}

/// The queue, shared by the ports and the task.
pub struct Interpreter {
    known: KnownNames,
    shared: Mutex<Shared>,
}

#[derive(Default)]
struct Shared {
    queue: StatementQueue<Statement>,
    task_runs: bool,
}

impl Default for Interpreter {
    fn default() -> Self {
        let known = KnownNames::new(crate::builtins::all().map(|b| b.name));
        Self { known, shared: Mutex::default() }
    }
}

impl Interpreter {
    /// Compiles a statement and queues it.
    pub fn submit(&self, statement: Statement) -> Submitted {
        let file = SourceFile::new("statement", statement.text.as_str());
        if let Err(findings) = elite_lang::compile(file.clone(), &self.known) {
            let reason = findings.first().map_or_else(String::new, |finding| {
                format!("{} (column {})", finding.message, finding.fields(&file).column)
            });
            return Submitted::NotCompiled(reason);
        }
        let mut shared = self.shared();
        if !shared.task_runs {
            return Submitted::NoTask;
        }
        match shared.queue.push(statement, Effect::None) {
            Ok(id) => Submitted::Accepted(id),
            Err(Refused::Full(_) | Refused::Held(_)) => Submitted::Full,
        }
    }

    /// Reads or changes the queue.
    pub fn with_queue<T>(&self, act: impl FnOnce(&mut StatementQueue<Statement>) -> T) -> T {
        act(&mut self.shared().queue)
    }

    /// A task begins: statements are accepted.
    pub(crate) fn task_started(&self) {
        self.shared().task_runs = true;
    }

    /// The task has ended: what waits is thrown away.
    pub(crate) fn task_ended(&self) {
        let thrown_away = {
            let mut shared = self.shared();
            shared.task_runs = false;
            shared.queue.throw_away()
        };
        for (_, statement) in thrown_away {
            (statement.thrown_away)();
        }
    }

    fn shared(&self) -> MutexGuard<'_, Shared> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
