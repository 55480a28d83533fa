//! `assert`. One that compares two values tells them when it fails, as advice before the last line of the report.

use elite_syntax::Span;
use elite_syntax::ast::CompareOp;

use crate::errors::ExceptionKind;
use crate::eval::{BoxExpr, Evaluator, Flow, Frame, StmtNode, TraceExt, attempt};
use crate::value::{R, Raised, Value};

/// Characters of each side that are told, and items of a container up to which it is told at all.
const SIDE_CHARS_MAX: usize = 300;
const ITEMS_MAX: usize = 100;

/// `assert test, message`
pub struct Assert {
    /// What must hold.
    pub test: BoxExpr,
    /// What the error says.
    pub message: Option<BoxExpr>,
    /// Where the test is written.
    pub span: Span,
}

impl StmtNode for Assert {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        if attempt!(self.test.truth(ev, f)) {
            return Flow::Next;
        }
        fail(ev, f, self.message.as_ref(), self.span, None)
    }
}

/// `assert left op right, message`
pub struct AssertComparison {
    /// The side before the operator.
    pub left: BoxExpr,
    /// How the two sides must compare.
    pub op: CompareOp,
    /// The side behind the operator.
    pub right: BoxExpr,
    /// What the error says.
    pub message: Option<BoxExpr>,
    /// Where the test is written.
    pub span: Span,
}

impl StmtNode for AssertComparison {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let left = attempt!(self.left.eval(ev, f));
        let right = attempt!(self.right.eval(ev, f));
        let compared = ev.compare_truth(self.op, &left, &right);
        if attempt!(compared.trace_at(ev, f, self.span)) {
            return Flow::Next;
        }
        fail(ev, f, self.message.as_ref(), self.span, Some((left, right)))
    }
}

#[cold]
fn fail(
    ev: &Evaluator<'_>,
    f: &mut Frame<'_>,
    message: Option<&BoxExpr>,
    span: Span,
    sides: Option<(Value, Value)>,
) -> Flow {
    let args = match message {
        Some(message) => vec![attempt!(message.eval(ev, f))],
        None => Vec::new(),
    };
    let error = ev.raise_args(ExceptionKind::AssertionError, args);
    if let (Some((left, right)), Raised::Exception(exception)) = (sides, &error)
        && let Some(state) = exception.exception()
    {
        let sides = [("left", left), ("right", right)];
        let mut lines = Vec::new();
        for (name, value) in sides {
            lines.push(format!(
                "the {name} side is {}",
                attempt!(short_repr(ev, &value))
            ));
        }
        *state.help.borrow_mut() = Some(lines.join(", ").into());
    }
    Flow::Raise(ev.trace(f, span, error))
}

/// A value in a few words; a `__repr__` that fails is not this statement's error.
fn short_repr(ev: &Evaluator<'_>, value: &Value) -> R<String> {
    let is_long = ev.len(value).is_ok_and(|items| items > ITEMS_MAX);
    let name = ev.core.types.name_of(value);
    if is_long && !matches!(value, Value::Str(_)) {
        return Ok(format!("a {name} of more than {ITEMS_MAX} items"));
    }
    match ev.repr(value) {
        Ok(text) => Ok(match text.char_indices().nth(SIDE_CHARS_MAX) {
            Some((end, _)) => format!("{}…", &text[..end]),
            None => text,
        }),
        Err(Raised::Stop) => Err(Raised::Stop),
        Err(_) => Ok(format!("a {name}")),
    }
}
