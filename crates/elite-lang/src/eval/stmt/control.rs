//! `if`, `break`, `continue`, `return`, `pass`.

use crate::eval::code::Block;
use crate::eval::expr::operand::{Operand, by_operand};
use crate::eval::{BoxExpr, DynStmt, Evaluator, ExprNode, Flow, Frame, StmtNode, attempt};
use crate::limits::deferred_drop::NodeList;
use crate::value::Value;

/// `if test: … elif test: … else: …`
pub struct If {
    /// Each condition with its line and its block.
    pub branches: NodeList<(u32, BoxExpr, Block)>,
    /// What runs if none holds.
    pub orelse: Block,
}

impl StmtNode for If {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        for (line, test, block) in &self.branches {
            ev.core.line.set(*line);
            if attempt!(test.truth(ev, f)) {
                return block.exec(ev, f);
            }
        }
        self.orelse.exec(ev, f)
    }
}

/// `return value`, by what the value is.
struct Return<V>(V);

impl<V: ExprNode> StmtNode for Return<V> {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        match self.0.eval(ev, f) {
            Ok(value) => Flow::Return(value),
            Err(raised) => Flow::Raise(raised),
        }
    }
}

/// The statement `return value`.
pub fn return_value(value: Operand) -> Box<dyn DynStmt> {
    by_operand!(value, value => Box::new(Return(value)))
}

/// `return`
pub struct BareReturn;

impl StmtNode for BareReturn {
    #[inline(always)]
    fn exec(&self, _: &Evaluator<'_>, _: &mut Frame<'_>) -> Flow {
        Flow::Return(Value::None)
    }
}

/// `break`
pub struct Break;

impl StmtNode for Break {
    #[inline(always)]
    fn exec(&self, _: &Evaluator<'_>, _: &mut Frame<'_>) -> Flow {
        Flow::Break
    }
}

/// `continue`
pub struct Continue;

impl StmtNode for Continue {
    #[inline(always)]
    fn exec(&self, _: &Evaluator<'_>, _: &mut Frame<'_>) -> Flow {
        Flow::Continue
    }
}

/// `pass`, and declarations that need no action.
pub struct Pass;

impl StmtNode for Pass {
    #[inline(always)]
    fn exec(&self, _: &Evaluator<'_>, _: &mut Frame<'_>) -> Flow {
        Flow::Next
    }
}
