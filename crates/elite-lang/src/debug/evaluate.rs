//! Texts that are evaluated in a call of a program that stands still, each on a script thread of its own.

use std::cell::RefCell;
use std::rc::Rc;

use messages::{Text, text};

use super::{PausedProgram, SetVariableError};
use crate::builtins::evaluate::run_in;
use crate::errors::render_script_error;
use crate::eval::coroutine::Resume;
use crate::host::ThreadId;
use crate::interpreter::{ResumeOutcome, ScriptThread};
use crate::native::WaitToken;
use crate::value::{R, Symbol, Unwind, Value};

/// Safepoints of one slice.
const FUEL: u32 = 20_000;

/// What an evaluation came to.
pub enum EvalOutcome {
    /// A value; None for statements.
    Done(Option<Value>),
    /// An exception, as people read it.
    Failed(Text),
    /// The text computed for too long and was given up.
    TooLong,
    /// The text waits: who drives the program has to drive this as well.
    Waits(PendingEval),
}

/// An evaluation that waits for something.
pub struct PendingEval {
    /// The thread of the evaluation, to be resumed when the wait is over. Its end is no error of the program.
    pub thread: ScriptThread,
    /// What the evaluation waits for; None: another thread, or time.
    pub token: Option<WaitToken>,
    /// The simulated time, s, at which the evaluation goes on at the latest, if it waits for time.
    pub until: Option<f64>,
    outcome: Rc<RefCell<Option<EvaluationOutcome>>>,
}

/// How an evaluation ended: the value, and the variables as they were left.
type EvaluationOutcome = Result<(Option<Value>, Vec<(Symbol, Value)>), Text>;

impl PendingEval {
    /// A look at how it ended, once it has, however it is driven.
    pub fn outcome(&self) -> EvalHandle {
        EvalHandle(self.outcome.clone())
    }
}

/// The end of an evaluation that waits.
pub struct EvalHandle(Rc<RefCell<Option<EvaluationOutcome>>>);

impl EvalHandle {
    /// A handle of an evaluation that has ended already.
    pub fn ready(result: Result<Option<Value>, Text>) -> Self {
        let outcome = result.map(|value| (value, Vec::new()));
        Self(Rc::new(RefCell::new(Some(outcome))))
    }

    /// How the evaluation ended; None while it has not.
    pub fn take(&self) -> Option<Result<Option<Value>, Text>> {
        let outcome = self.0.borrow_mut().take()?;
        Some(outcome.map(|(value, _)| value))
    }
}

impl PausedProgram<'_> {
    /// Evaluates an expression, or executes statements, in a call: `index` counts from the innermost one. At most
    /// `slices` slices of work are done. What statements assign to local variables is written back as far as that is
    /// possible.
    pub fn evaluate(&self, thread: ThreadId, index: usize, text: &str, slices: u32) -> EvalOutcome {
        let variables = match self.frame(thread, index) {
            Some((function, mut slots)) if !Self::is_module(&function) => {
                Some(self.variables(&function, &mut slots))
            }
            _ => None,
        };
        let before = variables.clone();
        let text = text.to_owned();
        let outcome: Rc<RefCell<Option<EvaluationOutcome>>> = Rc::default();
        let result = outcome.clone();
        let newest = self.core.newest_thread();
        let mut script = ScriptThread::new(self.core, move |ev| {
            let given = match run_in(ev, text, variables) {
                Ok(given) => Ok((given.value, given.variables)),
                Err(Unwind::Stop) => return Err(Unwind::Stop),
                Err(Unwind::Exception(exception)) => {
                    Err(render_script_error(&ev.report(&exception)))
                }
            };
            *result.borrow_mut() = Some(given);
            Ok(Value::None)
        });
        let step = self.run_aside(&mut script, slices);
        let (token, until) = match step {
            Some(ResumeOutcome::Waiting(token)) => (Some(token), None),
            Some(ResumeOutcome::Parked { until }) => (None, until),
            Some(_) => {
                drop(script);
                if self.core.newest_thread() == newest + 1 {
                    self.core.reset_thread_counter(newest);
                }
                let ended = outcome.borrow_mut().take();
                return match ended {
                    Some(Ok((value, variables))) => {
                        match self.write_back(thread, index, before, variables) {
                            Ok(()) => EvalOutcome::Done(value),
                            Err(error) => EvalOutcome::Failed(Text::of(&error)),
                        }
                    }
                    Some(Err(report)) => EvalOutcome::Failed(report),
                    None => EvalOutcome::Failed(text!("it was stopped", "已被停止")),
                };
            }
            None => return EvalOutcome::TooLong,
        };
        EvalOutcome::Waits(PendingEval {
            thread: script,
            token,
            until,
            outcome,
        })
    }

    /// The text that a program's own `__repr__` gives.
    pub(super) fn repr_of(&self, value: &Value, slices: u32) -> Option<String> {
        self.run_detached(slices, {
            let value = value.clone();
            move |ev| ev.repr(&value).map(|text| text.to_string())
        })
    }

    /// Runs `work_since_yield` on a script thread of its own; None if it fails, waits or takes too long.
    fn run_detached<T: 'static>(
        &self,
        slices: u32,
        work: impl FnOnce(&crate::eval::Evaluator<'_>) -> R<T> + 'static,
    ) -> Option<T> {
        let outcome: Rc<RefCell<Option<T>>> = Rc::default();
        let result = outcome.clone();
        let newest = self.core.newest_thread();
        let mut script = ScriptThread::new(self.core, move |ev| {
            let value = work(ev)?;
            *result.borrow_mut() = Some(value);
            Ok(Value::None)
        });
        self.run_aside(&mut script, slices);
        drop(script);
        if self.core.newest_thread() == newest + 1 {
            self.core.reset_thread_counter(newest);
        }
        outcome.take()
    }

    /// Runs a thread until it ends or waits, in the midst of another one; None if it takes too long.
    fn run_aside(&self, script: &mut ScriptThread, slices: u32) -> Option<ResumeOutcome> {
        let (core, debugger) = (self.core, self.debugger);
        let outer = debugger.is_silent.replace(true);
        let (fuel, work) = (core.remaining_fuel(), core.work_since_yield.get());
        let mut ended = None;
        for _ in 0..slices {
            match script.resume(Resume::Continue, FUEL) {
                ResumeOutcome::OutOfFuel => {}
                step => {
                    ended = Some(step);
                    break;
                }
            }
        }
        core.work_since_yield.set(work);
        core.set_fuel(fuel);
        if self.top.is_some() {
            core.arm_memory_alarm();
        }
        debugger.is_silent.set(outer);
        ended
    }

    /// Local variables that an evaluated text has changed.
    fn write_back(
        &self,
        thread: ThreadId,
        index: usize,
        before: Option<Vec<(Symbol, Value)>>,
        after: Vec<(Symbol, Value)>,
    ) -> Result<(), SetVariableError> {
        let Some(before) = before else {
            return Ok(());
        };
        for (name, value) in after {
            let old = before.iter().find(|(own, _)| *own == name);
            let text = self.core.symbols.name(name).to_string();
            match old {
                Some((_, old)) if old.is(&value) => {}
                Some(_) => self.set_local(thread, index, &text, value)?,
                // Named in the text only, or a slot that had no value yet.
                None if value.is_unbound() => {}
                None => match self.set_local(thread, index, &text, value) {
                    Ok(()) => {}
                    Err(error @ SetVariableError::OfCaller(_)) => return Err(error),
                    // A variable of the text itself.
                    Err(SetVariableError::Unknown(_)) => {}
                },
            }
        }
        Ok(())
    }
}
