//! Warnings about programs that compile: what is never used or never reached, loops that never wait, calls that
//! look wrong to the embedder. Only `check` asks for them; running a program does not.

mod calls;
mod flow;
pub mod visit;

use crate::ast::Module;
use crate::diagnostic::Diagnostic;
use crate::resolve::{KnownNames, unused_names};
use crate::source::SourceFile;

pub use calls::{CallArgument, CallHint, CallHook, CallSite, Literal};

/// All warnings, in no particular order.
pub fn lint(module: &Module, file: &SourceFile, known: &KnownNames) -> Vec<Diagnostic> {
    let mut found = unused_names(module);
    flow::check(&module.body, file, known, &mut found);
    calls::check(&module.body, known, &mut found);
    found
}
