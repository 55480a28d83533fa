//! EliteScript: Python 3.11 as robot controllers speak it, with `end`, `sec` and one-line programs.
//!
//! Text becomes a [`Program`] (`lexer` → `parser` → `resolve`), a program becomes executable nodes (`lower`) that
//! evaluate themselves (`eval`, `ops`, `builtins`) on coroutines that the embedder drives ([`Interpreter`],
//! [`ScriptThread`]). The crate knows nothing of robots, sockets, clocks or async: what a program can reach beyond
//! itself goes through [`Host`] and [`NativeFunction`].

mod advice;
mod ast;
mod builtins;
pub mod chinese;
pub mod debug;
mod diagnostic;
mod embedded;
mod errors;
mod eval;
mod excerpt;
mod findings;
mod format;
mod host;
mod interpreter;
mod lexer;
mod limits;
mod lint;
mod lower;
mod native;
mod ops;
mod parser;
mod program;
mod reading;
mod remote;
mod resolve;
mod source;
mod spelling;
mod stack;
mod statement;
mod stdlib;
pub mod syntax;
#[cfg(test)]
mod trials;
mod value;

pub use builtins::builtin_names;
pub use diagnostic::{Diagnostic, DiagnosticFields, Fix, Label, Severity, render_human};
pub use errors::{ExceptionKind, Link, ScriptError, TraceFrame, render_script_error};
pub use eval::coroutine::Resume;
pub use eval::count::LineCounts;
pub use eval::node::{NodeChange, NodeCursor, TaskNode};
pub use findings::DIAGNOSTICS_MAX;
pub use host::files::{FileStat, HostFile, HostFiles, OpenMode};
pub use host::process::{
    HostProcess, HostProcesses, OutputStream as ProcessOutput, ProcessCommand as HostCommand,
    StdioTarget as ProcessStream,
};
pub use host::{Capability, CleanupLimit, Host, HostSocket, Interest, ThreadId};
pub use interpreter::{FreeListPurge, Interpreter, ResumeOutcome, ScriptThread};
pub use limits::Limits;
pub use lint::{ArgumentLiteral, CallArgument, CallHint, CallHook, CallSite};
pub use native::{
    Letters, NativeBody, NativeCall, NativeContext, NativeFunction, Param, ParamKind, WaitToken,
};
pub use program::{Program, ProgramKind, check, compile};
pub use remote::MethodHandler;
pub use resolve::KnownNames;
pub use source::{Position, SourceFile, Span};
pub use statement::{Statement, compile_statement};
pub use stdlib::module_names;
pub use value::{Raised, Value};

/// What most operations on values return.
pub type ScriptResult<T = Value> = Result<T, Raised>;
