//! The nodes that tell the debugger of statements. Made only for programs that are watched; see [`crate::debug`].

use std::rc::Rc;

use super::{BoxExpr, DynStmt, Evaluator, ExprNode, Flow, Frame, StmtNode};
use crate::debug::{Debugger, StatementSite};
use crate::eval::stmt::target::Target;
use crate::value::{R, Unwind, Value};

/// A statement that is watched.
pub struct DebugStatement {
    /// The debugger that is told.
    pub debugger: Rc<Debugger>,
    /// The place of the statement in the text.
    pub site: Rc<StatementSite>,
    /// The statement; None for one that does nothing.
    pub inner: Option<Box<dyn DynStmt>>,
    /// No other statements are within the statement.
    pub is_simple: bool,
    /// Something in the statement may call, so that its variables may be looked at meanwhile.
    pub records_locals: bool,
}

impl StmtNode for DebugStatement {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let debugger = &self.debugger;
        if let Err(raised) = debugger.enter_statement(ev, f, &self.site, self.records_locals) {
            return Flow::Raise(raised);
        }
        let Some(inner) = &self.inner else {
            return Flow::Next;
        };
        let flow = inner.exec(ev, f);
        if let Flow::Raise(Unwind::Exception(exception)) = &flow
            && let Err(raised) = debugger.report_exception(ev, f, &self.site, exception)
        {
            return Flow::Raise(raised);
        }
        if self.is_simple && self.records_locals {
            debugger.end_statement(ev);
        }
        flow
    }
}

/// The condition of an `elif`, or that of a `while` when it is met again: a place to stop at.
pub struct DebugCondition {
    /// The debugger that is told.
    pub debugger: Rc<Debugger>,
    /// The place of the statement in the text.
    pub site: Rc<StatementSite>,
    /// The statement whose condition it is, if its beginning counts for the first time.
    pub begun_at: Option<Rc<StatementSite>>,
    /// The condition.
    pub then: BoxExpr,
}

impl ExprNode for DebugCondition {
    #[inline(always)]
    fn eval(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        let debugger = &self.debugger;
        let is_told = match &self.begun_at {
            Some(site) => debugger.is_at(ev, site),
            None => false,
        };
        if !is_told {
            debugger.enter_statement(ev, f, &self.site, true)?;
        }
        let result = self.then.eval(ev, f);
        if let Err(Unwind::Exception(exception)) = &result {
            debugger.report_exception(ev, f, &self.site, exception)?;
        }
        result
    }
}

/// What a `for` binds in each round: the header of the loop is a place to stop at whenever it is met again.
pub struct WatchedTarget {
    /// The debugger that is told.
    pub debugger: Rc<Debugger>,
    /// The place of the statement in the text.
    pub site: Rc<StatementSite>,
    /// The statement, whose beginning counts for the first round.
    pub begun_at: Rc<StatementSite>,
    /// What is bound.
    pub target: Box<dyn Target>,
}

impl Target for WatchedTarget {
    fn assign(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>, value: Value) -> R<()> {
        if !self.debugger.is_at(ev, &self.begun_at) {
            self.debugger.enter_statement(ev, f, &self.site, true)?;
        }
        self.target.assign(ev, f, value)
    }

    fn delete(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R<()> {
        self.target.delete(ev, f)
    }
}
