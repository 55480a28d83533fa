//! Programs for those who read them rather than run them: the tree with all its places, the tokens, the findings, and
//! what Python's own types and modules have. Editors build on it; nothing here runs a program.

mod library;

pub use crate::ast::{
    Arg, BinaryOp, ClassDef, Comprehension, ComprehensionClause, ComprehensionKind, Constant,
    DictItem, Expr, ExprKind, FStringPart, FunctionDef, Handler, Ident, ImportAlias, Lambda,
    Module, Parameter, Parameters, Stmt, StmtKind, UnaryOp, WithItem,
};
pub use crate::lexer::names::is_name;
pub use crate::lexer::{Token, TokenKind};
pub use crate::lint::visit::{blocks, own_expressions, parts};
pub use crate::reading::{DocumentUnit, ParsedDocument};
pub use library::{LibraryMember, MemberKind, builtins, module_members, type_members};

use crate::diagnostic::Diagnostic;
use crate::limits::work_budget::WorkBudget;
use crate::source::SourceFile;
pub use crate::stack::with_deep_stack;

/// The tokens of a text.
pub fn tokens(file: &SourceFile) -> Vec<Token> {
    crate::lexer::lex(file, &WorkBudget::with_limit(crate::parser::TREE_MAX)).tokens
}

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
