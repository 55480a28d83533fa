//! The end of a tree: taken apart with pauses, because dropping one of millions of parts takes long.
//!
//! Owns nothing. Follows the lists that a text can make long; what is small by the grammar is dropped as it is.

use super::{Arg, DictItem, Expr, ExprKind, Module, Stmt, StmtKind};
use crate::limits::memory::Budget;

/// Work for one part.
const PART: usize = 96;

impl Module {
    /// Drops the tree, with pauses.
    pub(crate) fn release(self, budget: &Budget<'_>) {
        statements(self.body, budget);
    }
}

fn statements(body: Vec<Stmt>, budget: &Budget<'_>) {
    for statement in body {
        budget.worked(PART);
        match statement.kind {
            StmtKind::Expr(value) => expression(value, budget),
            StmtKind::Print { values, .. } => expressions(values, budget),
            StmtKind::Assign { targets, value } => {
                expressions(targets, budget);
                expression(value, budget);
            }
            StmtKind::Delete(targets) => expressions(targets, budget),
            StmtKind::Return(Some(value)) => expression(value, budget),
            StmtKind::If { branches, orelse } => {
                for (test, body) in branches {
                    expression(test, budget);
                    statements(body, budget);
                }
                statements(orelse, budget);
            }
            StmtKind::While { body, orelse, .. } | StmtKind::For { body, orelse, .. } => {
                statements(body, budget);
                statements(orelse, budget);
            }
            StmtKind::With { body, .. } => statements(body, budget),
            StmtKind::Try {
                body,
                handlers,
                orelse,
                finally,
            } => {
                for handler in handlers {
                    statements(handler.body, budget);
                }
                for body in [body, orelse, finally] {
                    statements(body, budget);
                }
            }
            StmtKind::Function(def) => statements(def.body, budget),
            StmtKind::Class(def) => statements(def.body, budget),
            _ => {}
        }
    }
}

fn expressions(all: Vec<Expr>, budget: &Budget<'_>) {
    all.into_iter().for_each(|expr| expression(expr, budget));
}

fn expression(expr: Expr, budget: &Budget<'_>) {
    budget.worked(PART);
    match expr.kind {
        ExprKind::And(items)
        | ExprKind::Or(items)
        | ExprKind::List(items)
        | ExprKind::Tuple(items)
        | ExprKind::Set(items) => expressions(items, budget),
        ExprKind::Dict(items) => {
            for item in items {
                match item {
                    DictItem::Pair(key, value) => {
                        expression(key, budget);
                        expression(value, budget);
                    }
                    DictItem::Unpack(mapping) => expression(mapping, budget),
                }
            }
        }
        ExprKind::Call { function, args } => {
            expression(*function, budget);
            for arg in args {
                match arg {
                    Arg::Positional(value)
                    | Arg::Star(value)
                    | Arg::Keyword(_, value)
                    | Arg::DoubleStar(value) => expression(value, budget),
                }
            }
        }
        ExprKind::Binary { left, right, .. } => {
            expression(*left, budget);
            expression(*right, budget);
        }
        ExprKind::Compare { left, rest } => {
            expression(*left, budget);
            rest.into_iter()
                .for_each(|(_, right)| expression(right, budget));
        }
        ExprKind::FString(parts) => {
            for part in parts {
                budget.worked(PART);
                drop(part);
            }
        }
        _ => {}
    }
}
