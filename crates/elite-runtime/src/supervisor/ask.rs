//! Questions of one line whose value is wanted: run as secondary programs, beside the program that runs or, where none
//! does, on a task that does not count as the robot's program.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use elite_syntax::{KnownNames, Program, SourceFile};
use messages::{Localized, Text};
use motion_api::{CycleFrame, ProgramId};
use thiserror::Error;
use tokio::time::timeout;

use super::{Supervisor, TaskState};
use crate::message::{Message, Observer};
use crate::task::ProgramSource;
use crate::test_task::TestTaskConfig;

/// Longest time until an answer, in wall time: a secondary program may compute for about a second.
const ANSWERED_WITHIN: Duration = Duration::from_millis(1500);

/// The reason for which a question has no answer.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
pub enum NoAnswer {
    /// The question does not compile.
    #[error("{0}")]
    Parse(Text),
    /// The question failed, or does what a secondary program may not.
    #[error("{0}")]
    Execute(String),
}

impl Supervisor {
    /// The value of an expression of one line, as text, floats with six decimals; any other statement runs and gives
    /// `None`. A question sees what a secondary program sees that is sent now, and may do as little: neither move nor
    /// wait.
    ///
    /// # Errors
    /// [`NoAnswer`]
    pub async fn ask(&self, statement: &str) -> Result<String, NoAnswer> {
        static QUESTIONS: AtomicU64 = AtomicU64::new(1);
        // No program that is sent has such a name.
        let name = format!("question {}", QUESTIONS.fetch_add(1, Ordering::Relaxed));
        let program = self.compiled_question(&name, statement).await?;
        // What runs aside for this question.
        let own = OnceLock::new();
        let asking = async {
            if self.is_running() {
                let answer = self.panel().expect_answer(&name);
                let mut source = ProgramSource::Compiled(program.clone());
                if self.join_secondary(&mut source).await.is_some() {
                    return answer.await.ok();
                }
            }
            let aside = self.aside();
            let answer = aside.panel().expect_answer(&name);
            let started = aside.run_aside(name.clone(), ProgramSource::Compiled(program));
            let id = started.await?;
            own.get_or_init(|| id);
            answer.await.ok()
        };
        let answered = timeout(ANSWERED_WITHIN, asking).await;
        self.panel().forget_answer(&name);
        if let Some(aside) = self.shared.aside.get() {
            aside.panel().forget_answer(&name);
        }
        match answered {
            Ok(Some(answer)) => answer.map_err(NoAnswer::Execute),
            Ok(None) => Err(NoAnswer::Execute("it was not carried out".to_owned())),
            Err(_elapsed) => {
                if let Some(aside) = self.shared.aside.get()
                    && own.get() == Some(&aside.status().program)
                {
                    // The next question must not wait for it.
                    aside.stop();
                }
                let seconds = ANSWERED_WITHIN.as_secs_f64();
                Err(NoAnswer::Execute(format!(
                    "it took longer than {seconds} s"
                )))
            }
        }
    }

    /// An expression gives its value; what is none runs as it stands.
    async fn compiled_question(&self, name: &str, statement: &str) -> Result<Program, NoAnswer> {
        let known = KnownNames::new(crate::builtins::names());
        let (name, statement) = (name.to_owned(), statement.to_owned());
        let compiling = self.shared.pool.run(statement.len(), move || {
            let compiled = |body: &str| {
                let text = format!("sec _question():\n  {body}\nend\n");
                elite_syntax::compile(SourceFile::new(name.clone(), text), &known)
            };
            // What stands behind a `;` would not be reached.
            let value =
                (!statement.contains(';')).then(|| compiled(&format!("return {statement}")));
            match value {
                Some(Ok(program)) => Ok(program),
                _ => compiled(&statement),
            }
        });
        match compiling.await {
            Ok(Ok(program)) => Ok(program),
            Ok(Err(findings)) => {
                let first = findings.first().map(|finding| finding.message.clone());
                Err(NoAnswer::Parse(first.unwrap_or(Text::verbatim(""))))
            }
            Err(trouble) => Err(NoAnswer::Execute(trouble.to_string())),
        }
    }

    /// Where questions run while no program does.
    fn aside(&self) -> &Self {
        self.shared.aside.get_or_init(|| {
            let attendant = TestTaskConfig {
                object: None,
                methods: Arc::new(|_| Vec::new()),
                has_company: Arc::default(),
            };
            let observer = self.shared.settings.observer.clone();
            self.test_supervisor(Arc::new(LogOnlyObserver(observer)), attendant)
        })
    }

    /// Runs a question; the one before makes room for it, and is short.
    async fn run_aside(&self, name: String, source: ProgramSource) -> Option<ProgramId> {
        let _turn = self.shared.turns.lock().await;
        let mut status = self.watch();
        let stopped = status.wait_for(|s| s.state == TaskState::Stopped);
        stopped.await.ok()?;
        let none = Arc::default();
        self.start(name, true, source, none).ok()
    }
}

/// Passes only log lines of a program that runs aside: it is no program of the robot.
struct LogOnlyObserver(Arc<dyn Observer>);

impl Observer for LogOnlyObserver {
    fn message(&self, message: &Message) {
        if matches!(message, Message::Log { .. } | Message::Print { .. }) {
            self.0.message(message);
        }
    }

    /// Cycles that the program lets pass are cycles of the robot.
    fn cycle_ended(&self, frame: &CycleFrame) {
        self.0.cycle_ended(frame);
    }
}
