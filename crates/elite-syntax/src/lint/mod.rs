//! Warnings about programs that compile: what is never used or never reached, modules that are not there, loops that
//! never wait, calls that look wrong to the embedder. Only `check` asks for them; running a program does not.

mod calls;
mod comparisons;
mod flow;
mod imports;
mod whole_program;

use crate::ast::{Module, Stmt};
use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::DiagnosticList;
use crate::resolve::{KnownNames, bound_natives, unused_names};
use crate::source::SourceFile;
use crate::work_budget::WorkBudget;

pub(crate) use calls::CallDiagnostics;
pub use calls::{ArgumentLiteral, CallArgument, CallHint, CallHook, CallSite};
pub(crate) use flow::unreachable;
pub(crate) use whole_program::check as check_whole_program;

/// All warnings, in no particular order.
pub fn lint(module: &Module, file: &SourceFile, known: &KnownNames) -> Vec<Diagnostic> {
    let [mut unused, mut flow, mut calls]: [DiagnosticList; 3] = Default::default();
    unused_names(module, &mut unused);
    flow::check(&module.body, file, known, &mut flow);
    let mut made = CallDiagnostics::default();
    calls::check(&module.body, known, &mut made);
    let bound = bound_natives(module, known, &WorkBudget::with_limit(usize::MAX));
    if let Some(bound) = bound {
        for finding in made.retained(|name| bound.contains(name)) {
            calls.push(finding.clone());
        }
    }
    whole_program::check(module, known, &mut calls);
    let mut found: Vec<Diagnostic> = [unused, flow, calls]
        .into_iter()
        .flat_map(DiagnosticList::into_vec)
        .collect();
    drop_followers(&mut found);
    found
}

/// Of an import that finds nothing it is not also said that nothing uses it.
pub(crate) fn drop_followers(found: &mut Vec<Diagnostic>) {
    let missing: Vec<u32> = found
        .iter()
        .filter(|finding| finding.code == "missing-module")
        .map(|finding| finding.span.start)
        .collect();
    found.retain(|finding| {
        finding.code != "unused-import" || !missing.contains(&finding.span.start)
    });
}

/// What `lint` finds in some statements of the top level, but for what depends on others.
pub(crate) fn lint_part(
    body: &[Stmt],
    file: &SourceFile,
    known: &KnownNames,
    flow: &mut DiagnosticList,
    calls: &mut CallDiagnostics,
) {
    flow::check_each(body, file, known, flow);
    calls::check(body, known, calls);
}
