//! Where in a text breakpoints can be: the beginnings of statements, before anything runs.

use std::sync::Arc;

use crate::ast::visit;
use crate::ast::{ExprKind, Stmt, StmtKind};
use crate::deep_stack::with_deep_stack;
use crate::parser::parse;
use crate::source::SourceFile;

/// The beginning of a statement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct BreakpointLocation {
    /// Line, from 1.
    pub line: u32,
    /// Column, from 1.
    pub column: u32,
}

/// All places of a text at which a program can stop, in the order of the text. A text that cannot be read has none.
pub fn breakpoint_locations(file: &Arc<SourceFile>) -> Vec<BreakpointLocation> {
    with_deep_stack(|| {
        let parsed = parse(file);
        let mut places = Vec::new();
        collect(file, &parsed.module.body, &mut places);
        places.sort_unstable();
        places.dedup();
        places
    })
}

/// Whether a statement is something that is executed, so that a program can stand before it.
pub fn is_executable(statement: &Stmt) -> bool {
    match &statement.kind {
        StmtKind::Global(_) | StmtKind::Nonlocal(_) => false,
        StmtKind::Expr(expr) => !matches!(expr.kind, ExprKind::Constant(_)),
        _ => true,
    }
}

fn collect(file: &SourceFile, body: &[Stmt], places: &mut Vec<BreakpointLocation>) {
    for statement in body {
        let mut add = |offset: u32| {
            let position = file.position(offset);
            places.push(BreakpointLocation {
                line: position.line,
                column: position.column,
            });
        };
        if is_executable(statement) {
            add(statement.span.start);
        }
        if let StmtKind::If { branches, .. } = &statement.kind {
            branches
                .iter()
                .skip(1)
                .for_each(|(test, _)| add(test.span.start));
        }
        for block in visit::blocks(statement) {
            collect(file, block, places);
        }
    }
}
