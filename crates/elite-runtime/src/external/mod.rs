//! What comes to programs from outside, and when: what makes a recorded run one that can be repeated, program and all.
//!
//! A program is a pure function of its text, of what the robot shows it, and of what comes from elsewhere: answers of
//! machines, orders, the time of day. The robot is repeated by its commands. The rest is noted here where it enters, by
//! *turns*: a task looks round at certain points only (after each slice of a thread, and after each wait), counts them,
//! and sees between two of them nothing new. So the number of the turn says exactly when something was seen, whatever
//! the machine did meanwhile.
//!
//! - `calls`: what builtins that ask somebody else have answered.
//! - `rerun`: a recorded run, for tasks that repeat it.
//!
//! Owns the words for it and the comparison with the program's own commands. Files, and what is given by `controller`,
//! are not here.

mod calls;
mod rerun;

use std::sync::Arc;

use io_bus::xmlrpc::RpcValue;
use messages::Text;
use motion_api::ProgramId;

pub(crate) use calls::{AnswerCache, call_external};
pub use rerun::{Divergence, Rerun};

/// Longest answer of a machine that is noted, bytes; a program that was given a longer one cannot be repeated.
pub const ANSWER_BYTES_MAX: usize = 64 * 1024;

/// Something that came to a program from outside.
#[derive(Clone, Debug, PartialEq)]
pub struct ExternalInput {
    /// The program.
    pub program: ProgramId,
    /// The turn of the task in which the input was seen.
    pub turn: u64,
    /// The cycle that the task saw then.
    pub cycle: u64,
    /// What.
    pub what: ExternalInputKind,
}

/// What came to a program from outside.
#[derive(Clone, Debug, PartialEq)]
pub enum ExternalInputKind {
    /// The program begins, with these globals set (`NAME = VALUE`).
    Started {
        /// The globals that are set, each written as `NAME = VALUE`.
        presets: Vec<String>,
    },
    /// The program ends, and this is its last turn.
    Ends,
    /// The task sees another cycle than the one that follows from what it did (the next cycle after a wait, otherwise
    /// the one that it saw before).
    CycleObserved,
    /// An order.
    Order(TaskOrder),
    /// A builtin has answered that asks somebody else.
    Call(RecordedCall),
    /// A thread that waited for a socket goes on.
    Woken {
        /// The number that the language gives the thread.
        thread: u64,
    },
    /// The time of day, s since 1970.
    TimeOfDay(f64),
    /// Something that is not noted, in words: from here on it cannot be repeated.
    Unrecorded(Text),
}

/// An order to a running program.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum TaskOrder {
    /// The program was ended.
    Stop,
    /// Another program took the place of this one.
    Replace(String),
    /// The program was paused.
    Pause,
    /// The program was resumed after a pause.
    Resume,
    /// A secondary program began beside the main program.
    Secondary {
        /// The name of the secondary program.
        name: String,
        /// The text of the secondary program.
        text: String,
    },
}

/// A call of a builtin whose answer comes from elsewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedCall {
    /// The number of the call among the program's calls of this kind, from 1. Numbers that are missing belong to calls
    /// that were answered like an earlier call with the same arguments.
    pub number: u64,
    /// The function.
    pub function: String,
    /// The turns in which the waits of the call were over.
    pub waits: Vec<u64>,
    /// How the call ended.
    pub answer: CallOutcome,
}

/// How a call ended.
#[derive(Clone, Debug, PartialEq)]
pub enum CallOutcome {
    /// The call returned a value.
    Value(RpcValue),
    /// The call raised an exception.
    Raised {
        /// The name of the exception's type.
        kind: String,
        /// The message of the exception.
        text: String,
    },
    /// Not at all: its thread was stopped.
    Stopped,
}

/// Who notes what comes from outside. Called on the thread of the task; must not wait but for room under the virtual
/// clock.
pub trait ExternalInputSink: Send + Sync {
    /// Something has come.
    fn record(&self, external: &ExternalInput);
}

/// Whether what comes from outside is noted, or comes from a recording.
#[derive(Clone, Default)]
pub enum InputMode {
    /// Input comes from the outside world, and nobody records it.
    #[default]
    Live,
    /// Input comes from the outside world and goes to a recorder.
    Recorded(Arc<dyn ExternalInputSink>),
    /// Input comes from a recording.
    Repeated(Arc<Rerun>),
}
