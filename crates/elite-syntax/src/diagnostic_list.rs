//! The findings of one pass over a text: only the first ones are kept, so that a text full of slips costs no more than
//! one with a few. Owns their number and how much of the text their messages quote; what they say is up to the passes.

use std::borrow::Cow;

use crate::ast::NodeDirective;
use crate::diagnostic::Diagnostic;
use crate::task_node::TaskNode;

/// Most findings that are made of one text; further ones add nothing.
pub const DIAGNOSTICS_MAX: usize = 50;
/// Most characters of a name or a token that a message quotes.
const QUOTE_MAX: usize = 80;

/// A list of findings that stops growing.
#[derive(Debug, Default)]
pub struct DiagnosticList {
    kept: Vec<Diagnostic>,
}

impl DiagnosticList {
    /// Adds a finding, unless there are enough.
    pub fn push(&mut self, finding: Diagnostic) {
        if !self.is_full() {
            self.kept.push(finding);
        }
    }

    /// Whether nothing more will be kept: the pass may stop looking.
    pub fn is_full(&self) -> bool {
        self.kept.len() >= DIAGNOSTICS_MAX
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// The findings, to look at.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.kept.iter()
    }

    /// Gives up those from number `length` on.
    pub fn truncate(&mut self, length: usize) {
        self.kept.truncate(length);
    }

    /// Changes those from number `length` on.
    pub fn change_from(&mut self, length: usize, change: impl FnMut(&mut Diagnostic)) {
        self.kept.iter_mut().skip(length).for_each(change);
    }

    /// Gives up those that `keep` does not want.
    pub fn retain(&mut self, keep: impl FnMut(&Diagnostic) -> bool) {
        self.kept.retain(keep);
    }

    /// The findings, to keep.
    pub fn into_vec(self) -> Vec<Diagnostic> {
        self.kept
    }
}

/// Puts findings into the order of the text and keeps the first ones.
pub fn sort_and_cap(mut findings: Vec<Diagnostic>) -> Vec<Diagnostic> {
    findings.sort_by_key(|finding| finding.span.start);
    findings.truncate(DIAGNOSTICS_MAX);
    findings
}

/// Tells findings which node of the pendant's task they are in; `marks` are in the order of the text. One about a
/// directive is in none.
pub fn attach_task_nodes(
    mut findings: Vec<Diagnostic>,
    marks: &[NodeDirective],
) -> Vec<Diagnostic> {
    for finding in findings
        .iter_mut()
        .filter(|finding| finding.code != "directive")
    {
        let before = marks.partition_point(|mark| mark.start <= finding.span.start);
        let mark = before.checked_sub(1).and_then(|last| marks.get(last));
        finding.node = mark.map(|mark| TaskNode {
            number: mark.number,
            label: (*mark.label).into(),
        });
    }
    findings
}

/// A piece of the text as a message quotes it: cut if it is long.
pub fn quoted(text: &str) -> Cow<'_, str> {
    match text.char_indices().nth(QUOTE_MAX) {
        Some((cut, _)) => format!("{}…", &text[..cut]).into(),
        None => text.into(),
    }
}
