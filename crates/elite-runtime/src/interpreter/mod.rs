//! Statements from port 30020 on their way to the running task (manual chapter 2).
//!
//! Owns the queue that ports and task share, and decides which statements get into it. Statements are compiled on the
//! threads for that, so that the answer waits neither for the task nor for other ports; `interpreter_mode()` takes them
//! out and executes them.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use elite_syntax::{Diagnostic, KnownNames, Program, SourceFile};
use tokio::sync::{Notify, watch};

use crate::compile_pool::{CompilePool, CompilePoolError};
use crate::interpreter_queue::{PushError, QueueEffect, StatementId, StatementQueue};

/// A statement with the way to tell its sender that it is thrown away after all.
pub struct SubmittedStatement {
    /// The text.
    pub text: String,
    /// Called once when the statement is thrown away unexecuted; must not wait.
    pub on_discard: Box<dyn FnOnce(DiscardReason) + Send>,
}

/// The reason for which an accepted statement is not executed after all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DiscardReason {
    /// `interpreter_mode(clearQueueOnEnter=True)` was called.
    OnEntry,
    /// Interpreter mode has ended, and clears what is left.
    OnEnd,
    /// `clear_interpreter()` was called elsewhere than at the interpreter port.
    Cleared,
    /// The task has ended.
    TaskEnded,
}

/// What became of a statement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SubmitResult {
    /// The statement waits under this number.
    Accepted(StatementId),
    /// The statement does not compile, for the reason in the text.
    NotCompiled(String),
    /// No task runs.
    NoTask,
    /// The queue is full.
    Full,
}

/// What `interpreter_mode()` does next.
pub(crate) enum NextAction {
    /// Execute this, then say [`InterpreterMode::finish`].
    Statement(StatementId, elite_syntax::Statement),
    /// Wait.
    Nothing,
    /// Return.
    End,
}

/// Text of all statements that wait, bytes; one more counts as one too many. The 8500 statements of the manual have 7
/// KiB each with this; compiled they take about ten times as much.
pub const QUEUED_BYTES_MAX: usize = 64 * 1024 * 1024;
/// What the text of a statement is called.
const STATEMENT: &str = "statement";

/// A statement that waits.
struct QueuedStatement {
    compiled: elite_syntax::Statement,
    thrown_away: Box<dyn FnOnce(DiscardReason) + Send>,
    _share: QuotaGuard,
}

/// What a statement takes of [`QUEUED_BYTES_MAX`]; given back when it is dropped.
struct QuotaGuard {
    bytes: usize,
    total: Arc<AtomicUsize>,
}

impl QuotaGuard {
    /// `None` when there is no room.
    fn take(bytes: usize, total: &Arc<AtomicUsize>) -> Option<Self> {
        let share = Self {
            bytes,
            total: Arc::clone(total),
        };
        // Added first, so that many clients at once cannot pass together; a refused share gives itself back.
        let before = total.fetch_add(bytes, Ordering::Relaxed);
        (before + bytes <= QUEUED_BYTES_MAX).then_some(share)
    }
}

impl Drop for QuotaGuard {
    fn drop(&mut self) {
        self.total.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

/// The queue, shared by the ports and the task.
pub struct InterpreterMode {
    known: Arc<KnownNames>,
    pool: Arc<CompilePool>,
    shared: Mutex<StatementAdmission>,
    /// Wakes the task's thread: a statement or the end of the mode.
    news: Arc<Notify>,
    /// Counts changes that can let a held statement in: a clear executed, a task begun or ended.
    changes: watch::Sender<u64>,
    /// Bytes of text that wait or are being offered.
    bytes: Arc<AtomicUsize>,
}

#[derive(Default)]
struct StatementAdmission {
    queue: StatementQueue<QueuedStatement>,
    phase: TaskPhase,
    /// Global variables of the task that statements may declare `global`.
    globals: BTreeSet<String>,
    program: Option<Program>,
    in_mode: bool,
    end_requested: bool,
}

/// What the task is doing, as far as statements care.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum TaskPhase {
    #[default]
    None,
    /// The program and with it its globals are not known yet, so statements wait.
    Starting,
    Running,
}

/// The numbers that ports report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counters {
    /// Executed last or being executed.
    pub last_executed: StatementId,
    /// Accepted last.
    pub last_accepted: StatementId,
    /// Cleared last.
    pub last_cleared: StatementId,
    /// How many wait.
    pub unexecuted: usize,
}

impl InterpreterMode {
    /// An empty queue. `news` is notified when the task has something to look at.
    pub(crate) fn new(news: Arc<Notify>, pool: Arc<CompilePool>) -> Self {
        Self {
            known: Arc::new(KnownNames::new(crate::builtins::names())),
            pool,
            shared: Mutex::default(),
            news,
            changes: watch::Sender::default(),
            bytes: Arc::default(),
        }
    }

    /// Compiles a statement and queues it. Waits while a task is starting, and while an accepted `clear_interpreter()`
    /// has not been executed (manual 2.5).
    pub async fn submit(&self, statement: SubmittedStatement) -> SubmitResult {
        // Before the first look, so that no change between a look and the wait is missed.
        let mut changes = self.changes.subscribe();
        let SubmittedStatement {
            text,
            on_discard: thrown_away,
        } = statement;
        let Some(share) = QuotaGuard::take(text.len(), &self.bytes) else {
            return SubmitResult::Full;
        };
        let known = self.known.clone();
        let compiling = self
            .pool
            .run(text.len(), move || compile(text, &known))
            .await;
        let mut queued = match compiling.unwrap_or_else(|trouble| Err(trouble.to_string())) {
            Ok(compiled) => QueuedStatement {
                compiled,
                thrown_away,
                _share: share,
            },
            Err(reason) => return SubmitResult::NotCompiled(reason),
        };
        loop {
            changes.mark_unchanged();
            match self.offer(queued) {
                Ok(submitted) => return submitted,
                Err(back) => queued = back,
            }
            // The sender lives as long as this queue.
            let _ = changes.changed().await;
        }
    }

    /// Compiles a program, on the threads for that. The error are its findings.
    ///
    /// # Errors
    /// [`CompilePoolError`]
    pub(crate) async fn compile(
        &self,
        file: Arc<SourceFile>,
    ) -> Result<Result<Program, Vec<Diagnostic>>, CompilePoolError> {
        let known = self.known.clone();
        let bytes = file.text().len();
        let compile = move || elite_syntax::compile(file, &known);
        self.pool.run(bytes, compile).await
    }

    /// Queues the statement or refuses it; gives it back when it has to wait.
    fn offer(&self, queued: QueuedStatement) -> Result<SubmitResult, QueuedStatement> {
        let mut shared = self.shared();
        match shared.phase {
            TaskPhase::None => return Ok(SubmitResult::NoTask),
            TaskPhase::Starting => return Err(queued),
            TaskPhase::Running => {}
        }
        if let Some(reason) = shared.refusal(&queued.compiled) {
            return Ok(SubmitResult::NotCompiled(reason));
        }
        let effect = if queued.compiled.mentions("clear_interpreter") {
            QueueEffect::Clears
        } else {
            QueueEffect::None
        };
        match shared.queue.push(queued, effect) {
            Ok(id) => {
                // Only a task in the mode can do something about it.
                if shared.in_mode {
                    self.news.notify_one();
                }
                Ok(SubmitResult::Accepted(id))
            }
            Err(PushError::Full(_)) => Ok(SubmitResult::Full),
            Err(PushError::Held(back)) => Err(back),
        }
    }

    /// `skipbuffer`: nothing that waits now is executed.
    pub fn skip(&self) {
        self.shared().queue.skip();
        self.changed();
    }

    /// The numbers that ports report.
    pub fn counters(&self) -> Counters {
        let shared = self.shared();
        Counters {
            last_executed: shared.queue.last_executed(),
            last_accepted: shared.queue.last_accepted(),
            last_cleared: shared.queue.last_cleared(),
            unexecuted: shared.queue.unexecuted(),
        }
    }

    /// True while a program is in interpreter mode.
    pub fn is_active(&self) -> bool {
        self.shared().in_mode
    }

    /// True while a statement is being executed.
    pub fn is_executing(&self) -> bool {
        self.shared().queue.running().is_some()
    }

    /// Enters the mode; false when it is active already.
    pub(crate) fn enter(&self, clear_queue: bool) -> bool {
        let mut shared = self.shared();
        if shared.in_mode {
            return false;
        }
        shared.in_mode = true;
        shared.end_requested = false;
        let thrown_away = if clear_queue {
            shared.queue.throw_away()
        } else {
            Vec::new()
        };
        drop(shared);
        notify_discarded(thrown_away, DiscardReason::OnEntry);
        self.changed();
        true
    }

    /// Leaves the mode. What waits is thrown away, or goes on waiting: for the next time, or for the end of the task.
    pub(crate) fn leave(&self, clear_queue: bool) {
        let mut shared = self.shared();
        shared.in_mode = false;
        shared.end_requested = false;
        shared.queue.finish();
        let thrown_away = match clear_queue {
            true => shared.queue.throw_away(),
            false => Vec::new(),
        };
        drop(shared);
        notify_discarded(thrown_away, DiscardReason::OnEnd);
        self.changed();
    }

    /// Ends the mode after the running statement; false when it is not active.
    pub(crate) fn request_end(&self) -> bool {
        let mut shared = self.shared();
        shared.end_requested = shared.in_mode;
        self.news.notify_one();
        shared.in_mode
    }

    /// True when [`next`](Self::next) would not say [`NextAction::Nothing`].
    pub(crate) fn has_next(&self) -> bool {
        let shared = self.shared();
        shared.end_requested || shared.queue.unexecuted() > 0
    }

    pub(crate) fn next(&self) -> NextAction {
        let mut shared = self.shared();
        if shared.end_requested {
            return NextAction::End;
        }
        match shared.queue.begin() {
            Some((id, queued)) => NextAction::Statement(id, queued.compiled),
            None => NextAction::Nothing,
        }
    }

    /// The running statement has ended.
    pub(crate) fn finish(&self) {
        let mut shared = self.shared();
        let was_held = shared.queue.is_held();
        shared.queue.finish();
        let let_in = was_held && !shared.queue.is_held();
        drop(shared);
        if let_in {
            self.changed();
        }
    }

    /// The injected functions were removed; the last statement that they can come from. With the queue, what waits is
    /// thrown away: it was sent before, for of what came behind a `clear_interpreter()` at the port nothing has been
    /// accepted.
    pub(crate) fn finish_clear(&self, queue: bool) -> StatementId {
        let mut shared = self.shared();
        shared.queue.finish_clear();
        let thrown_away = match queue {
            true => shared.queue.throw_away(),
            false => Vec::new(),
        };
        let last = shared.queue.last_cleared();
        drop(shared);
        notify_discarded(thrown_away, DiscardReason::Cleared);
        last
    }

    /// A task begins; until its program is known, statements wait.
    pub(crate) fn task_starts(&self) {
        let mut shared = self.shared();
        shared.phase = TaskPhase::Starting;
        shared.globals.clear();
        shared.program = None;
    }

    /// The task runs this program: statements are accepted.
    pub(crate) fn task_runs(&self, program: &Program) {
        let mut shared = self.shared();
        shared.phase = TaskPhase::Running;
        shared.program = Some(program.clone());
        drop(shared);
        self.changed();
    }

    /// A secondary program may have made these global.
    pub(crate) fn add_globals<'a>(&self, names: impl Iterator<Item = &'a str>) {
        /// More than anybody would declare; beyond, statements cannot declare the name.
        const GLOBALS_MAX: usize = 10_000;
        let mut shared = self.shared();
        for name in names {
            if shared.globals.len() < GLOBALS_MAX {
                shared.globals.insert(name.to_owned());
            }
        }
    }

    /// The task has ended: what waits is thrown away.
    pub(crate) fn task_ended(&self) {
        let mut shared = self.shared();
        shared.phase = TaskPhase::None;
        shared.program = None;
        shared.in_mode = false;
        shared.end_requested = false;
        shared.queue.finish();
        let thrown_away = shared.queue.throw_away();
        drop(shared);
        notify_discarded(thrown_away, DiscardReason::TaskEnded);
        self.changed();
    }

    fn changed(&self) {
        self.changes
            .send_modify(|count| *count = count.wrapping_add(1));
    }

    fn shared(&self) -> MutexGuard<'_, StatementAdmission> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl StatementAdmission {
    /// The reason for which the running program cannot take the statement; `None` when it can.
    fn refusal(&self, statement: &elite_syntax::Statement) -> Option<String> {
        let exists = |name: &str| {
            self.globals.contains(name)
                || self
                    .program
                    .as_ref()
                    .is_some_and(|p| p.defines_global(name))
        };
        let new = statement.declared_globals().find(|name| !exists(name))?;
        Some(format!(
            "global {new}: new global variables cannot be defined in interpreter mode"
        ))
    }
}

fn notify_discarded(thrown_away: Vec<(StatementId, QueuedStatement)>, reason: DiscardReason) {
    for (_, statement) in thrown_away {
        (statement.thrown_away)(reason);
    }
}

/// Whether a text is a statement of interpreter mode.
pub(crate) fn is_statement(text: &SourceFile) -> bool {
    text.name() == STATEMENT
}

/// Compiles a statement; the error says what is wrong with it.
fn compile(text: String, known: &KnownNames) -> Result<elite_syntax::Statement, String> {
    let file = SourceFile::new(STATEMENT, text);
    let compiled = elite_syntax::compile_statement(file.clone(), known);
    let compiled = compiled.map_err(|findings| {
        findings.first().map_or_else(String::new, |finding| {
            let column = finding.fields(&file).column;
            format!("{} (column {column})", finding.message)
        })
    })?;
    if compiled.mentions("start_thread") {
        return Err("start_thread is not supported in interpreter mode".to_owned());
    }
    Ok(compiled)
}

#[cfg(test)]
mod tests;
