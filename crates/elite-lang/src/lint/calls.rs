//! Calls of the embedder's functions, shown to the embedder as far as they can be read from the text: it knows what
//! an argument means and says what looks wrong. The language itself does not know what a joint is.

use super::visit::{blocks, own_expressions, parts};
use crate::ast::{Arg, Constant, Expr, ExprKind, Stmt, UnaryOp};
use crate::diagnostic::Diagnostic;
use crate::findings::Findings;
use crate::resolve::KnownNames;
use crate::source::Span;

/// A call of one of the embedder's functions, as it is written.
#[derive(Clone, Debug, PartialEq)]
pub struct CallSite<'t> {
    /// The function.
    pub function: &'t str,
    /// The arguments up to the first starred one.
    pub args: Vec<CallArgument<'t>>,
}

/// An argument of a call.
#[derive(Clone, Debug, PartialEq)]
pub struct CallArgument<'t> {
    /// The keyword it is given by.
    pub name: Option<&'t str>,
    /// What can be read of it.
    pub value: Literal<'t>,
    span: Span,
}

/// A value as far as the text tells it.
#[derive(Clone, Debug, PartialEq)]
pub enum Literal<'t> {
    /// A number, with its sign.
    Number(f64),
    /// A string.
    Text(&'t str),
    /// A list or tuple.
    List(Vec<Literal<'t>>),
    /// The result of a function called by its plain name.
    CallOf(&'t str),
    /// Anything else.
    Other,
}

/// What the embedder has to say about an argument.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CallHint {
    /// Index of the argument in `CallSite::args`.
    pub argument: usize,
    /// Stable short name, for example `degrees`.
    pub code: &'static str,
    /// A sentence for people.
    pub message: String,
    /// What to do about it.
    pub help: Option<String>,
}

/// The embedder's view on a call.
pub type CallHook = fn(&CallSite<'_>) -> Vec<CallHint>;

pub(super) fn check(body: &[Stmt], known: &KnownNames, found: &mut Findings) {
    let Some(hook) = known.call_hook() else {
        return;
    };
    for statement in body {
        if found.is_full() {
            return;
        }
        own_expressions(statement, &mut |expr| expression(expr, known, hook, found));
        for block in blocks(statement) {
            check(block, known, found);
        }
    }
}

fn expression(expr: &Expr, known: &KnownNames, hook: CallHook, found: &mut Findings) {
    if let ExprKind::Attribute { value, name } = &expr.kind
        && let ExprKind::Name(object) = &value.kind
        && let Some(members) = known.members(object)
        && !members.contains(&*name.name)
    {
        let wrong = &name.name;
        let text = format!("`{object}` has no function `{wrong}`");
        let mut diagnostic = Diagnostic::warning("unknown-attribute", name.span, text);
        let members: Vec<&str> = members.iter().map(String::as_str).collect();
        diagnostic.help = Some(format!("it has {}", members.join(", ")));
        found.push(diagnostic);
    }
    if let Some(site) = call_site(expr)
        && known.contains(site.function)
    {
        for hint in hook(&site) {
            let span = site
                .args
                .get(hint.argument)
                .map_or(expr.span, |arg| arg.span);
            let mut diagnostic = Diagnostic::warning(hint.code, span, hint.message);
            diagnostic.help = hint.help;
            found.push(diagnostic);
        }
    }
    parts(expr, &mut |part| expression(part, known, hook, found));
}

fn call_site(expr: &Expr) -> Option<CallSite<'_>> {
    let ExprKind::Call { function, args } = &expr.kind else {
        return None;
    };
    let ExprKind::Name(name) = &function.kind else {
        return None;
    };
    let mut read = Vec::new();
    for arg in args {
        let (name, value) = match arg {
            Arg::Positional(value) => (None, value),
            Arg::Keyword(name, value) => (Some(&*name.name), value),
            Arg::Star(_) | Arg::DoubleStar(_) => break,
        };
        read.push(CallArgument {
            name,
            value: literal(value),
            span: value.span,
        });
    }
    Some(CallSite {
        function: name,
        args: read,
    })
}

fn literal(expr: &Expr) -> Literal<'_> {
    match &expr.kind {
        ExprKind::Constant(Constant::Int(int)) => Literal::Number(*int as f64),
        ExprKind::Constant(Constant::Float(float)) => Literal::Number(*float),
        ExprKind::Constant(Constant::Str(text)) => Literal::Text(text),
        ExprKind::Unary { op, operand } => match (op, literal(operand)) {
            (UnaryOp::Neg, Literal::Number(number)) => Literal::Number(-number),
            (UnaryOp::Pos, Literal::Number(number)) => Literal::Number(number),
            _ => Literal::Other,
        },
        ExprKind::List(items) | ExprKind::Tuple(items) => {
            Literal::List(items.iter().map(literal).collect())
        }
        ExprKind::Call { function, .. } => match &function.kind {
            ExprKind::Name(name) => Literal::CallOf(name),
            _ => Literal::Other,
        },
        _ => Literal::Other,
    }
}
