//! A text that is read again and again while it is written: what a change leaves alone is not read anew.
//!
//! Owns which parts of tree and findings are kept. They are those of one fresh reading: whatever a change could reach
//! is made anew (`parser::units`, `resolve::parts`).

use std::ops::Range;
use std::sync::Arc;

use crate::ast::Module;
use crate::deep_stack::with_deep_stack;
use crate::diagnostic::{Diagnostic, Severity};
use crate::diagnostic_list::{DiagnosticList, attach_task_nodes, sort_and_cap};
use crate::lexer::{Token, lex};
use crate::parser::{ParsedUnits, TREE_MAX, TextEdit, TopLevelUnit, reparse};
use crate::program::{SOURCE_BYTES_MAX, classify, too_long};
use crate::resolve::{KnownNames, PlacedUnit, UnitAnalysis, merge_units};
use crate::source::SourceFile;
use crate::work_budget::WorkBudget;

/// Longest text of which parts are kept, in bytes: what a tree may take is counted for whole readings.
const KEPT_MAX: usize = 512 << 10;

/// A text with its tree, its tokens and what [`check`](crate::check) finds in it.
#[derive(Debug)]
pub struct ParsedDocument {
    file: Arc<SourceFile>,
    read: ParsedUnits,
    /// What is known of each unit; none where nobody has needed it.
    parts: Vec<Option<UnitAnalysis>>,
    findings: Vec<Diagnostic>,
}

impl ParsedDocument {
    /// Reads a text, whatever is in it. `known` are the names that the embedder provides to scripts.
    pub fn of(file: Arc<SourceFile>, known: &KnownNames) -> Self {
        with_deep_stack(|| read(file, known, None))
    }

    /// Reads what has become of the text.
    pub fn reparse(self, file: Arc<SourceFile>, known: &KnownNames) -> Self {
        with_deep_stack(|| read(file, known, Some(self)))
    }

    /// The text.
    pub fn file(&self) -> &Arc<SourceFile> {
        &self.file
    }

    /// The tree; statements that do not parse are left out of it, or are in it as far as they can be told.
    pub fn module(&self) -> &Module {
        &self.read.module
    }

    /// The tokens, always ended by `EndOfFile`; none of a text that is too large.
    pub fn tokens(&self) -> &[Token] {
        &self.read.tokens
    }

    /// What `check` finds.
    pub fn findings(&self) -> &[Diagnostic] {
        &self.findings
    }

    /// The pieces that the text was read in: their statements, by their numbers in the body of the module, and the
    /// number of the piece in the reading before that had the same text, tree and neighbours and was taken over.
    pub fn pieces(&self) -> impl ExactSizeIterator<Item = DocumentUnit> {
        self.read.units.iter().map(|unit| DocumentUnit {
            statements: unit.body.clone(),
            start: unit.start,
            origin: unit.origin,
        })
    }
}

/// A piece of a text that is kept, or read anew, as a whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DocumentUnit {
    /// The statements of the piece, by their numbers in the body of the module.
    pub statements: Range<usize>,
    /// The first byte of the piece.
    pub start: u32,
    /// The number of the piece in the reading before; None if it was read anew.
    pub origin: Option<usize>,
}

fn read(
    file: Arc<SourceFile>,
    known: &KnownNames,
    before: Option<ParsedDocument>,
) -> ParsedDocument {
    let budget = WorkBudget::with_limit(TREE_MAX);
    let length = file.text().len();
    if length > SOURCE_BYTES_MAX {
        let lexed = lex(&file, &budget);
        return ParsedDocument {
            file,
            read: ParsedUnits::empty(lexed.tokens),
            parts: Vec::new(),
            findings: vec![too_long(length)],
        };
    }
    let before = before.filter(|before| length.max(before.file.text().len()) <= KEPT_MAX);
    let (old, mut old_parts) = match before {
        Some(before) => {
            let difference = TextEdit::diff(before.file.text(), file.text());
            (Some((before.read, difference)), before.parts)
        }
        None => (None, Vec::new()),
    };
    let lexed = lex(&file, &budget);
    let read = reparse(&file, lexed, &budget, old);
    let part = |unit: &TopLevelUnit| old_parts.get_mut(unit.origin?)?.take();
    let mut parts: Vec<Option<UnitAnalysis>> = read.units.iter().map(part).collect();
    let findings = findings(&file, &read, &mut parts, known);
    ParsedDocument {
        file,
        read,
        parts,
        findings,
    }
}

/// The findings of a text, as `check` puts them together.
fn findings(
    file: &SourceFile,
    read: &ParsedUnits,
    parts: &mut [Option<UnitAnalysis>],
    known: &KnownNames,
) -> Vec<Diagnostic> {
    let module = &read.module;
    let mut found = read.diagnostics.clone();
    classify(module, &mut found);
    let is_error = |finding: &Diagnostic| finding.severity == Severity::Error;
    if found.iter().any(is_error) {
        // Names are looked up in trees without gaps only: a gap would make half of the names look undefined.
        found.retain(is_error);
        return attach_task_nodes(found, &module.nodes);
    }
    for (unit, part) in read.units.iter().zip(&mut *parts) {
        part.get_or_insert_with(|| {
            let body = &module.body[unit.body.clone()];
            UnitAnalysis::analyze(body, unit.scopes.clone(), unit.start, file, known)
        });
    }
    let placed = read.units.iter().zip(&*parts).filter_map(|(unit, part)| {
        Some(PlacedUnit {
            part: part.as_ref()?,
            start: unit.start,
            body: &module.body[unit.body.clone()],
            scopes: unit.scopes.clone(),
        })
    });
    let placed: Vec<PlacedUnit<'_>> = placed.collect();
    let together = merge_units(&placed, known);
    found.extend(together.resolved.into_vec());
    if found.iter().any(is_error) {
        found.retain(is_error);
    } else {
        found = sort_and_cap(found);
        let mut flow = DiagnosticList::default();
        crate::lint::unreachable(&module.body, file, &mut flow);
        together
            .flow
            .into_vec()
            .into_iter()
            .for_each(|finding| flow.push(finding));
        let mut calls = together.calls;
        crate::lint::check_whole_program(module, known, &mut calls);
        for own in [together.unused, flow, calls] {
            found.extend(own.into_vec());
        }
        crate::lint::drop_followers(&mut found);
    }
    attach_task_nodes(sort_and_cap(found), &module.nodes)
}
