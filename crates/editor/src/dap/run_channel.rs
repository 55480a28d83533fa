//! What passes between a session and the run it holds: orders to the thread of the program, events back.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64};
use std::sync::mpsc::Receiver;
use std::sync::{Arc, OnceLock};

use controller::CellWorld;
use elite_runtime::TaskEnd;
use messages::{Language, Text};
use motion_api::ProgramId;
use parking_lot::Mutex;
use serde_json::Value as Json;

use super::breakpoints::Breakpoints;
use super::hub::ProgramStarted;
use super::run_position::{Intervention, Position, SeekTarget};
use super::stream::DapInput;

/// How a held program goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ResumeMode {
    /// The program goes on to the next breakpoint.
    Free,
    /// The program goes on to the next statement of a thread.
    StepIn(u32),
    /// To the next one of the same call, or of the one it returns to.
    Next(u32),
    /// Out of the call.
    Out(u32),
    /// The program goes on to the next node of the pendant's task.
    Node(u32),
    /// The program goes on until this many cycles have passed.
    ToCycle(u64),
}

/// An order to the thread of a held program.
pub(crate) enum RunCommand {
    /// A request of the client that is about the program.
    Ask {
        /// Request to answer.
        request: RequestId,
        /// What is asked.
        command: String,
        /// Arguments of the request.
        arguments: Json,
        /// Language of the client.
        language: Language,
    },
    /// Go on.
    Go(ResumeMode),
    /// Stop; `is_stopping` is set.
    Stop,
}

/// Number and name of the request that an answer is for.
pub(crate) type RequestId = (i64, String);

/// A reason why a program is held.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SuspendReason {
    /// The protocol's word for the reason.
    pub reason: &'static str,
    /// The reason in words, for people.
    pub description: Option<Text>,
    /// More about the reason, for instance the message of an exception.
    pub text: Option<Text>,
    /// Numbers of the breakpoints that hold it.
    pub ids: Vec<u64>,
}

impl SuspendReason {
    /// Only the protocol's word.
    pub(crate) fn only(reason: &'static str) -> Self {
        Self {
            reason,
            ..Self::default()
        }
    }
}

/// What a run is started for.
#[derive(Clone, Debug)]
pub(crate) enum Purpose {
    /// To run; with `stop_on_entry`, held at the first statement.
    Run {
        /// Held at the first statement.
        stop_on_entry: bool,
    },
    /// To be held at a place; nothing is told on the way.
    Seek(SeekTarget, SuspendReason),
    /// To find the last place before a moment at which a breakpoint holds; nothing is told.
    Scan {
        /// Moment of the run, counted like [`Position::moment`].
        before: u64,
    },
}

/// What the run tells.
#[derive(Clone)]
pub(crate) enum RunEvent {
    /// The program is held.
    Stopped {
        /// Number of the thread that stands.
        thread: u32,
        /// Numbers of all threads.
        threads: Vec<u32>,
        /// Reason of the stop.
        why: SuspendReason,
        /// Place of the stop in the run.
        position: Position,
        /// Where a breakpoint held last before, as far as that is known: not where breakpoints were changed on the way.
        last: Option<Option<(Position, SuspendReason)>>,
    },
    /// Another client has let it go on.
    Continued,
    /// An answer.
    Answer {
        /// Request that is answered.
        request: RequestId,
        /// The body, or a sentence.
        result: Result<Json, Text>,
    },
    /// Something was changed while the program is held.
    Changed(Intervention),
    /// Text for people.
    Output {
        /// The protocol's word for what it is.
        category: &'static str,
        /// The text.
        text: Text,
        /// The line it comes from, 0 unknown.
        line: u32,
    },
    /// What the program itself has said; its number counts in the run.
    Said(u64, &'static str, Text, u32),
    /// A script thread is there, or is gone.
    Thread {
        /// Number of the thread.
        number: u32,
        /// True for a new thread, false for one that is gone.
        is_there: bool,
    },
    /// What a scan has found.
    Scanned(Option<(Position, SuspendReason)>),
    /// An exception has ended the program: this is where it was raised.
    Raised {
        /// Moment of the run, counted like [`Position::moment`].
        moment: u64,
        /// Reason that the client is told when it is held there.
        why: SuspendReason,
    },
    /// The program has ended, and nothing is left of it.
    Ended(Option<TaskEnd>),
}

/// What a session hears.
#[derive(Clone)]
pub(crate) enum SessionEvent {
    /// A message of the client.
    Client(DapInput),
    /// The client has gone, with the reason if it is one worth telling.
    Gone(Option<String>),
    /// A program begins on the controller that the client has attached to, or the one that ran has ended.
    Begun(Option<Box<ProgramStarted>>),
    /// A message from a controller elsewhere.
    Remote(Json),
    /// Something for people, and what it is.
    Said(&'static str, Text),
    /// An event of the run with this number.
    Run(u64, Box<RunEvent>),
}

/// Between a session and one run.
pub(crate) struct RunChannel {
    /// Number of this run in its session.
    pub generation: u64,
    /// The program belongs to a controller that serves: it is held without the task standing still, and goes on without
    /// us.
    pub is_attached: bool,
    /// Somebody is there who can let it go on.
    pub is_driven: AtomicBool,
    /// The program that is debugged, where others run as well.
    pub program: Option<ProgramId>,
    /// What it is for.
    pub purpose: Purpose,
    /// What is done again on the way.
    pub interventions: Vec<Intervention>,
    /// Held at the end, however the program ends.
    pub stop_at_end: bool,
    /// What the client wants the program held for.
    pub breakpoints: Mutex<Arc<Breakpoints>>,
    /// Number of changes of `breakpoints` so far.
    pub changes: AtomicU64,
    /// The client wants the program held.
    pub pause: AtomicBool,
    /// Nobody wants it any more.
    pub is_over: AtomicBool,
    /// The client has it stopped: what it does on its way out is told, and so is its end.
    pub is_stopping: AtomicBool,
    /// Events of this run are kept from the client, because an earlier run has told them.
    pub is_muted: AtomicBool,
    /// Number of outputs of the program so far.
    pub said: AtomicU64,
    /// Number of outputs that the client has seen in earlier runs.
    pub seen: AtomicU64,
    /// The line of the latest statement.
    pub line: AtomicU32,
    /// The column of the latest statement.
    pub column: AtomicU32,
    /// The parts of the cell, once the controller runs.
    pub world: OnceLock<CellWorld>,
    /// Hands an event to the session; false when the session is gone.
    pub events: Box<dyn Fn(SessionEvent) -> bool + Send + Sync>,
    /// Commands from the session; taken by the program's thread.
    pub orders: Mutex<Option<Receiver<RunCommand>>>,
}

impl RunChannel {
    /// Tells the session; a session that is gone wants nothing of the run any more.
    pub(crate) fn tell(&self, event: RunEvent) {
        if !(self.events)(SessionEvent::Run(self.generation, Box::new(event))) {
            self.is_over
                .store(true, std::sync::atomic::Ordering::Release);
        }
    }

    /// What the client wants it held for.
    pub(crate) fn breakpoints(&self) -> Arc<Breakpoints> {
        self.breakpoints.lock().clone()
    }
}
