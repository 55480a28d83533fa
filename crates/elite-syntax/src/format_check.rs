//! Whether a formatter has kept the meaning of a text: its tree is the same, wherever in the text its nodes stand.

use crate::deep_stack::with_deep_stack;
use crate::diagnostic::Diagnostic;
use crate::source::SourceFile;

/// Whether two texts have the same tree, wherever in them its parts are written. None if one of them has errors.
pub fn same_tree(one: &SourceFile, other: &SourceFile) -> Option<bool> {
    with_deep_stack(|| {
        let (one, other) = (tree_without_spans(one)?, tree_without_spans(other)?);
        Some(one == other)
    })
}

/// The tree as text without places.
fn tree_without_spans(file: &SourceFile) -> Option<String> {
    let parsed = crate::parser::parse(file);
    let is_error = |found: &Diagnostic| found.severity == crate::diagnostic::Severity::Error;
    if parsed.diagnostics.iter().any(is_error) {
        return None;
    }
    Some(without_places(&format!("{:?}", parsed.module.body)))
}

/// Leaves out `Span { start: …, end: … }`. A literal with these very words loses as much in both texts.
fn without_places(text: &str) -> String {
    let mut kept = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("Span { start: ") {
        kept.push_str(&rest[..at]);
        rest = rest[at..].find('}').map_or("", |end| &rest[at + end + 1..]);
    }
    kept.push_str(rest);
    kept
}
