//! Statements of programs that somebody watches: each gets a node around it that tells of it.

use std::rc::Rc;

use elite_syntax::Span;
use elite_syntax::ast::{self, ExprKind, Stmt, StmtKind, visit};

use super::Lower;
use crate::debug::StatementSite;
use crate::eval::stmt::loops::LoopTarget;
use crate::eval::watch::{DebugCondition, DebugStatement, WatchedTarget};
use crate::eval::{BoxExpr, DynStmt};

impl Lower<'_> {
    /// The node of a statement, watched where the program is.
    pub(super) fn debug_statement(&mut self, statement: &Stmt) -> Option<Box<dyn DynStmt>> {
        let Some(debugger) = self
            .debugger
            .clone()
            .filter(|_| elite_syntax::is_executable(statement))
        else {
            return self.statement(statement);
        };
        let site = self.site(statement.span);
        let inner = self.deeper(|lower| lower.statement_at(statement, &site));
        Some(Box::new(DebugStatement {
            debugger,
            site,
            inner,
            is_simple: visit::blocks(statement).is_empty(),
            records_locals: may_call(statement),
        }))
    }

    fn statement_at(
        &mut self,
        statement: &Stmt,
        site: &Rc<StatementSite>,
    ) -> Option<Box<dyn DynStmt>> {
        let outer = self.loop_site.replace(site.clone());
        let node = self.statement(statement);
        self.loop_site = outer;
        node
    }

    /// The condition of a `while`. It is told of from the second time on: the first one belongs to the statement.
    pub(super) fn loop_test(&mut self, test: &ast::Expr) -> BoxExpr {
        let begun_at = self.loop_site.clone();
        self.watched_test(test, begun_at)
    }

    /// What a `for` binds. It is told of from the second time on, as the condition of a `while` is.
    pub(super) fn watched_target(&mut self, target: &ast::Expr) -> LoopTarget {
        let (Some(debugger), Some(begun_at)) = (self.debugger.clone(), self.loop_site.clone())
        else {
            return self.loop_target(target);
        };
        LoopTarget::Other(Box::new(WatchedTarget {
            debugger,
            site: met_again(&begun_at),
            begun_at,
            target: self.target(target),
        }))
    }

    /// A condition that is a place to stop at.
    pub(super) fn watched_test(
        &mut self,
        test: &ast::Expr,
        begun_at: Option<Rc<StatementSite>>,
    ) -> BoxExpr {
        let Some(debugger) = self.debugger.clone() else {
            return self.expr(test);
        };
        let site = match &begun_at {
            Some(begun) => met_again(begun),
            None => self.site(test.span),
        };
        let then = self.deeper(|lower| lower.expr(test));
        Box::new(DebugCondition {
            debugger,
            site,
            begun_at,
            then,
        })
    }

    fn site(&mut self, span: Span) -> Rc<StatementSite> {
        let position = self.file.position(span.start);
        Rc::new(StatementSite {
            file: self.file.clone(),
            span,
            line: position.line,
            column: position.column,
            is_first: std::mem::take(&mut self.is_first),
        })
    }
}

/// Where a loop is met again: breakpoints of the statement hold there, too.
fn met_again(begun: &StatementSite) -> Rc<StatementSite> {
    Rc::new(StatementSite {
        file: begun.file.clone(),
        is_first: false,
        ..*begun
    })
}

/// Whether something in the statement itself may call a function. What only adds to a variable is taken not to: its
/// variable would be copied each time.
fn may_call(statement: &Stmt) -> bool {
    if !matches!(statement.kind, StmtKind::AugAssign { .. }) {
        return true;
    }
    let mut calls = false;
    visit::own_expressions(statement, &mut |expr| calls = calls || has_call(expr));
    calls
}

fn has_call(expr: &ast::Expr) -> bool {
    let mut calls = matches!(
        expr.kind,
        ExprKind::Call { .. } | ExprKind::Yield(_) | ExprKind::YieldFrom(_)
    );
    visit::parts(expr, &mut |part| calls = calls || has_call(part));
    calls
}
