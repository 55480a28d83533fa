//! `assert`. One that compares two values tells them when it fails, as advice before the last line of the report.

use elite_syntax::Span;
use elite_syntax::ast::CompareOp;
use messages::{Text, text};

use crate::errors::ExceptionKind;
use crate::eval::{BoxExpr, Evaluator, Flow, Frame, StmtNode, TraceExt, attempt};
use crate::value::{R, Unwind, Value};

/// Characters of each side that are told.
const SIDE_CHARS_MAX: usize = 300;
/// Items up to which a container is told whole, and those of a longer one that are told.
const ITEMS_MAX: usize = 100;
const ITEMS_SHOWN: usize = 10;
/// Items of a side that are looked through for the first difference.
const ITEMS_COMPARED: usize = 100_000;

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
    if let (Some((left, right)), Unwind::Exception(exception)) = (sides, &error)
        && let Some(state) = exception.exception()
    {
        let (left_shown, left_is_whole) = attempt!(short_repr(ev, &left));
        let (right_shown, right_is_whole) = attempt!(short_repr(ev, &right));
        let mut parts = vec![
            text!("the left side is {left_shown}", "左边为 {left_shown}"),
            text!("the right side is {right_shown}", "右边为 {right_shown}"),
        ];
        let is_cut = !(left_is_whole && right_is_whole);
        if is_cut && let Some(place) = attempt!(first_difference(ev, &left, &right)) {
            parts.push(place);
        }
        *state.help.borrow_mut() = Some(Box::new(Text::joined(&parts, ", ", "，")));
    }
    Flow::Raise(ev.trace(f, span, error))
}

/// A value in a few words, and whether that is all of it; a `__repr__` that fails is not this statement's error.
fn short_repr(ev: &Evaluator<'_>, value: &Value) -> R<(Text, bool)> {
    let name = ev.core.types.name_of(value);
    let length = ev.len(value).ok().filter(|items| *items > ITEMS_MAX);
    if let (Some(length), false) = (length, matches!(value, Value::Str(_))) {
        let items = value.as_items().unwrap_or_default();
        let mut shown = Vec::new();
        for item in items.iter().take(ITEMS_SHOWN) {
            shown.push(cut_repr(ev, item)?.0);
        }
        let text = match shown.is_empty() {
            true => text!("a {name} of {length} items", "{length} 项的 {name}"),
            false => text!(
                "a {name} of {length} items: {}, …",
                "{length} 项的 {name}：{}, …",
                shown.join(", ")
            ),
        };
        return Ok((text, false));
    }
    let (text, is_whole) = cut_repr(ev, value)?;
    match (value, is_whole) {
        (Value::Str(string), false) => {
            let length = string.as_str().chars().count();
            Ok((
                text!(
                    "a text of {length} characters: {text}",
                    "{length} 个字符的字符串：{text}"
                ),
                false,
            ))
        }
        _ => Ok((Text::verbatim(text), is_whole)),
    }
}

fn cut_repr(ev: &Evaluator<'_>, value: &Value) -> R<(String, bool)> {
    match ev.repr(value) {
        Ok(text) => Ok(match text.char_indices().nth(SIDE_CHARS_MAX) {
            Some((end, _)) => (format!("{}…", &text[..end]), false),
            None => (text, true),
        }),
        Err(Unwind::Stop) => Err(Unwind::Stop),
        Err(_) => Ok((format!("a {}", ev.core.types.name_of(value)), true)),
    }
}

/// Where two lists or texts differ first. A comparison that fails is not this statement's error.
fn first_difference(ev: &Evaluator<'_>, left: &Value, right: &Value) -> R<Option<Text>> {
    if let (Value::Str(a), Value::Str(b)) = (left, right) {
        let (a, b) = (a.as_str().chars(), b.as_str().chars());
        let index = a.zip(b).position(|(a, b)| a != b);
        return Ok(index.map(|index| {
            text!(
                "they differ first at character {index}",
                "首个不同在下标 {index} 处"
            )
        }));
    }
    let (Some(a), Some(b)) = (left.as_items(), right.as_items()) else {
        return Ok(None);
    };
    for (index, (a, b)) in a.iter().zip(&b).enumerate().take(ITEMS_COMPARED) {
        match ev.compare_truth(CompareOp::Eq, a, b) {
            Ok(true) => {}
            Ok(false) => {
                let (a, b) = (cut_repr(ev, a)?.0, cut_repr(ev, b)?.0);
                return Ok(Some(text!(
                    "they differ first at item {index}: {a} and {b}",
                    "首个不同在下标 {index} 处：{a} 与 {b}"
                )));
            }
            Err(Unwind::Stop) => return Err(Unwind::Stop),
            Err(_) => return Ok(None),
        }
    }
    let longer = a.len() != b.len();
    Ok(longer.then(|| {
        text!(
            "one ends after item {}",
            "其一在下标 {} 之后结束",
            a.len().min(b.len()).saturating_sub(1)
        )
    }))
}
