//! EliteScript at work: Python 3.11 as robot controllers speak it, with `end`, `sec` and one-line programs.
//!
//! A program that `elite-syntax` has compiled becomes executable nodes (`lower`) that evaluate themselves (`eval`,
//! `ops`, `builtins`) on coroutines that the embedder drives. The crate knows nothing of robots, sockets, clocks or
//! async: what a program can reach beyond itself goes through [`Host`] and [`NativeFunction`].
//!
//! # Running a program
//!
//! A [`Host`] is what a program sees of the world: where `print` goes, what time it is. An [`Interpreter`] has the
//! globals of one task. Its script threads are [resumed](ScriptThread::resume) with an amount of fuel, and say why they
//! stop.
//!
//! ```
//! use std::cell::RefCell;
//! use std::rc::Rc;
//!
//! use elite_lang::{Host, Interpreter, Limits, Resume, ResumeOutcome, ThreadId};
//! use elite_syntax::{KnownNames, SourceFile, compile};
//!
//! #[derive(Default)]
//! struct Console(RefCell<String>);
//!
//! impl Host for Console {
//!     fn print(&self, _thread: ThreadId, text: &str) {
//!         self.0.borrow_mut().push_str(text);
//!     }
//!     fn unix_time(&self) -> f64 {
//!         0.0
//!     }
//!     fn monotonic(&self) -> f64 {
//!         0.0
//!     }
//!     fn random_u64(&self) -> u64 {
//!         4
//!     }
//!     fn wake(&self, _thread: ThreadId) {}
//! }
//!
//! let text = "total = 0\nfor n in range(5):\n    total += n\nprint(total)\n";
//! let program = compile(SourceFile::new("sum.script", text), &KnownNames::default()).unwrap();
//!
//! let host = Rc::new(Console::default());
//! let interpreter = Interpreter::new(host.clone(), Vec::new(), Limits::default());
//! let mut thread = interpreter.spawn_program(&program);
//! loop {
//!     match thread.resume(Resume::Continue, 1000) {
//!         // Other threads could run now.
//!         ResumeOutcome::OutOfFuel | ResumeOutcome::Parked { .. } => {}
//!         ResumeOutcome::Done(_) => break,
//!         ResumeOutcome::Failed(error) => panic!("{error:?}"),
//!         ResumeOutcome::Waiting(_) | ResumeOutcome::Stopped => unreachable!(),
//!     }
//! }
//! assert_eq!(*host.0.borrow(), "10\n");
//! ```
//!
//! # Giving a program functions
//!
//! A [`NativeFunction`] has a name, parameters and a body. Arguments are bound before the body runs, and wrong ones are
//! Python's errors. The body returns a value, raises, or waits: then the thread stops with
//! [`ResumeOutcome::Waiting`] until the embedder resumes it.
//!
//! ```
//! # use std::rc::Rc;
//! # use elite_lang::{Host, ThreadId};
//! # struct NoHost;
//! # impl Host for NoHost {
//! #     fn print(&self, _: ThreadId, _: &str) {}
//! #     fn unix_time(&self) -> f64 { 0.0 }
//! #     fn monotonic(&self) -> f64 { 0.0 }
//! #     fn random_u64(&self) -> u64 { 0 }
//! #     fn wake(&self, _: ThreadId) {}
//! # }
//! use elite_lang::{
//!     Interpreter, Limits, NativeBody, NativeFunction, Param, Resume, ResumeOutcome, Value, WaitToken,
//! };
//! use elite_syntax::{KnownNames, SourceFile, compile};
//!
//! let move_joint = NativeFunction {
//!     name: "move_joint",
//!     params: vec![Param::required("number"), Param::optional("speed")],
//!     call: NativeBody::new(|call| {
//!         let number = call.arg(0).and_then(Value::as_f64).unwrap_or_default();
//!         call.wait(WaitToken(number as u64))?;
//!         Ok(Value::Bool(true))
//!     }),
//! };
//! let known = KnownNames::new(["move_joint"]);
//! let file = SourceFile::new("move.script", "def move():\n    return move_joint(3)\n");
//! let program = compile(file, &known).unwrap();
//! let interpreter = Interpreter::new(Rc::new(NoHost), vec![move_joint], Limits::default());
//! let mut thread = interpreter.spawn_program(&program);
//!
//! let outcome = thread.resume(Resume::Continue, 1000);
//! assert!(matches!(outcome, ResumeOutcome::Waiting(WaitToken(3))));
//! // The joint has arrived.
//! let outcome = thread.resume(Resume::Continue, 1000);
//! assert!(matches!(outcome, ResumeOutcome::Done(Value::Bool(true))));
//! ```
//!
//! # What a native may hold
//!
//! Values that a native holds must be where deferred drop and cycle collector find them. A closure that has captured
//! one is found by neither, so it does not compile:
//!
//! ```compile_fail,E0277
//! use elite_lang::{NativeBody, Value};
//!
//! let held = Value::str("a value of a script");
//! let body = NativeBody::new(move |_| Ok(held.clone()));
//! ```
//!
//! # Stopping a program
//!
//! [`Resume::Stop`] makes a thread run its `finally` and `with` blocks, with as much fuel as [`Limits`] allow, and
//! nothing else. What bounds memory, pauses and depth of programs is explained in the module `limits`.

mod advice;
mod builtins;
pub mod debug;
mod embedded;
mod errors;
mod eval;
mod format;
mod host;
mod interpreter;
mod interpreter_mode;
pub mod library;
mod limits;
mod lower;
mod native;
mod ops;
mod remote;
mod stdlib;
#[cfg(test)]
mod trials;
mod value;

pub use errors::{
    ExceptionKind, ExceptionText, Link, ScriptError, TraceFrame, render_script_error,
};
pub use eval::coroutine::Resume;
pub use eval::count::LineCounts;
pub use eval::node::{NodeChange, NodeCursor};
pub use host::files::{FileStat, HostFile, HostFiles, OpenMode};
pub use host::process::{
    HostProcess, HostProcesses, OutputStream as ProcessOutput, ProcessCommand as HostCommand,
    StdioTarget as ProcessStream,
};
pub use host::{Capability, CleanupLimit, Host, HostSocket, Interest, ThreadId};
pub use interpreter::{FreeListPurge, Interpreter, ResumeOutcome, ScriptThread};
pub use limits::Limits;
pub use native::{
    Letters, NativeBody, NativeCall, NativeContext, NativeFunction, Param, ParamKind, WaitToken,
};
pub use remote::MethodHandler;
pub use value::{Unwind, Value};

/// What most operations on values return.
pub type ScriptResult<T = Value> = Result<T, Unwind>;
