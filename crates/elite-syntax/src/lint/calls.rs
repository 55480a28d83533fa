//! Calls of the embedder's functions, shown to the embedder as far as they can be read from the text: it knows what
//! an argument means and says what looks wrong. The language itself does not know what a joint is.
//!
//! A name that the program binds itself, anywhere, may stand for something else: nothing is said of its calls then.

use core::fmt;
use std::collections::HashMap;
use std::sync::Arc;

use messages::{Text, text};

use crate::ast::visit::{blocks, own_expressions, parts};
use crate::ast::{Arg, Constant, Expr, ExprKind, Stmt, StmtKind, UnaryOp};
use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::DIAGNOSTICS_MAX;
use crate::resolve::KnownNames;
use crate::source::Span;

/// A call of one of the embedder's functions, as it is written.
#[derive(Clone, Debug, PartialEq)]
pub struct CallSite<'t> {
    /// The function.
    pub function: &'t str,
    /// The arguments up to the first starred one.
    pub args: Vec<CallArgument<'t>>,
    /// Whether these are all arguments: none is starred.
    pub is_whole: bool,
}

/// An argument of a call.
#[derive(Clone, Debug, PartialEq)]
pub struct CallArgument<'t> {
    /// The keyword it is given by.
    pub name: Option<&'t str>,
    /// What can be read of it.
    pub value: ArgumentLiteral<'t>,
    pub(super) span: Span,
}

/// A value as far as the text tells it.
#[derive(Clone, Debug, PartialEq)]
pub enum ArgumentLiteral<'t> {
    /// A whole number, with its sign.
    Integer(i64),
    /// Another number, with its sign.
    Number(f64),
    /// `True` or `False`.
    Boolean(bool),
    /// A string.
    Text(&'t str),
    /// A list or tuple.
    List(Vec<ArgumentLiteral<'t>>),
    /// The result of a function called by its plain name.
    CallOf(&'t str),
    /// Anything else.
    Other,
}

/// What the embedder has to say about a call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CallHint {
    /// Index of the argument in `CallSite::args` that it is about; none: about the call.
    pub argument: Option<usize>,
    /// Stable short name, for example `degrees`.
    pub code: &'static str,
    /// A sentence for people.
    pub message: Text,
    /// What to do about it.
    pub help: Option<Text>,
}

/// The embedder's view on a call.
#[derive(Clone)]
pub struct CallHook(Arc<HintFunction>);

type HintFunction = dyn Fn(&CallSite<'_>) -> Vec<CallHint> + Send + Sync;

impl CallHook {
    pub(crate) fn new(
        hints: impl Fn(&CallSite<'_>) -> Vec<CallHint> + Send + Sync + 'static,
    ) -> Self {
        Self(Arc::new(hints))
    }

    /// What the embedder has to say about a call.
    pub(crate) fn hints(&self, site: &CallSite<'_>) -> Vec<CallHint> {
        (self.0)(site)
    }
}

impl fmt::Debug for CallHook {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("CallHook")
    }
}

/// What was found about calls, with the name that each finding stands or falls with. Of each name the first ones are
/// kept.
#[derive(Debug, Default)]
pub(crate) struct CallDiagnostics {
    kept: Vec<(Box<str>, Diagnostic)>,
    counts: HashMap<Box<str>, usize>,
}

impl CallDiagnostics {
    fn push(&mut self, name: &str, finding: Diagnostic) {
        let count = self.counts.entry(name.into()).or_default();
        if *count < DIAGNOSTICS_MAX {
            *count += 1;
            self.kept.push((name.into(), finding));
        }
    }

    /// The findings about names that the program does not bind.
    pub(crate) fn retained<'s>(
        &'s self,
        is_bound: impl Fn(&str) -> bool + 's,
    ) -> impl Iterator<Item = &'s Diagnostic> {
        let kept = self.kept.iter();
        kept.filter(move |(name, _)| !is_bound(name))
            .map(|(_, finding)| finding)
    }
}

pub(super) fn check(body: &[Stmt], known: &KnownNames, found: &mut CallDiagnostics) {
    let Some(hook) = known.call_hook() else {
        return;
    };
    for statement in body {
        if let StmtKind::Expr(expr) = &statement.kind
            && let ExprKind::Name(function) = &expr.kind
            && known.contains(function)
            && known.members(function).is_none()
        {
            let text = text!(
                "`{function}` alone calls nothing",
                "单独的 `{function}` 没有调用任何函数"
            );
            let finding = Diagnostic::warning("not-called", expr.span, text);
            let call = format!("{function}()");
            let finding = finding.with_help(text!("a call has parentheses", "调用要带圆括号"));
            found.push(function, finding.with_fix(expr.span, call));
        }
        own_expressions(statement, &mut |expr| expression(expr, known, hook, found));
        for block in blocks(statement) {
            check(block, known, found);
        }
    }
}

fn expression(expr: &Expr, known: &KnownNames, hook: &CallHook, found: &mut CallDiagnostics) {
    // A function without a name that calls with wrong arguments is there for somebody who expects the error.
    if is_meant_to_fail(expr, known) || matches!(expr.kind, ExprKind::Lambda(_)) {
        return;
    }
    if let ExprKind::Attribute { value, name } = &expr.kind
        && let ExprKind::Name(object) = &value.kind
        && let Some(members) = known.members(object)
        && !members.contains(&*name.name)
    {
        let wrong = &name.name;
        let text = text!(
            "`{object}` has no function `{wrong}`",
            "`{object}` 没有函数 `{wrong}`"
        );
        let mut diagnostic = Diagnostic::warning("unknown-attribute", name.span, text);
        let members: Vec<&str> = members.iter().map(String::as_str).collect();
        diagnostic.help = Some(text!("it has {}", "它有 {}", members.join(", ")));
        found.push(object, diagnostic);
    }
    if let ExprKind::Subscript { value, .. } = &expr.kind
        && let ExprKind::Name(function) = &value.kind
        && known.contains(function)
        && known.members(function).is_none()
    {
        let text = text!(
            "`{function}` is a function: its arguments are in parentheses",
            "`{function}` 是函数：参数写在圆括号中"
        );
        let finding = Diagnostic::warning("subscripted-function", value.span, text);
        let finding = finding.with_help(text!(
            "write {function}(…) in place of {function}[…]",
            "把 {function}[…] 改写为 {function}(…)"
        ));
        found.push(function, finding);
    }
    if let Some(site) = call_site(expr)
        && known.contains(site.function)
    {
        for hint in hook.hints(&site) {
            let argument = hint.argument.and_then(|index| site.args.get(index));
            let span = argument.map_or(expr.span, |arg| arg.span);
            let mut diagnostic = Diagnostic::warning(hint.code, span, hint.message);
            diagnostic.help = hint.help;
            found.push(site.function, diagnostic);
        }
    }
    parts(expr, &mut |part| expression(part, known, hook, found));
}

/// `test.raises(…)`: what is called in it is wrong on purpose.
pub(super) fn is_meant_to_fail(expr: &Expr, known: &KnownNames) -> bool {
    let ExprKind::Call { function, .. } = &expr.kind else {
        return false;
    };
    let ExprKind::Attribute { value, name } = &function.kind else {
        return false;
    };
    let ExprKind::Name(object) = &value.kind else {
        return false;
    };
    &*name.name == "raises"
        && known
            .members(object)
            .is_some_and(|members| members.contains("raises"))
}

fn call_site(expr: &Expr) -> Option<CallSite<'_>> {
    call_site_with(expr, &|_| None)
}

/// A call, with what `value_of` knows of variables in place of their names.
pub(super) fn call_site_with<'t>(
    expr: &'t Expr,
    value_of: &dyn Fn(&'t str) -> Option<&'t Expr>,
) -> Option<CallSite<'t>> {
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
            value: match &value.kind {
                ExprKind::Name(name) => value_of(name).map_or(ArgumentLiteral::Other, literal),
                _ => literal(value),
            },
            span: value.span,
        });
    }
    Some(CallSite {
        function: name,
        is_whole: read.len() == args.len(),
        args: read,
    })
}

fn literal(expr: &Expr) -> ArgumentLiteral<'_> {
    match &expr.kind {
        ExprKind::Constant(Constant::Int(int)) => ArgumentLiteral::Integer(*int),
        ExprKind::Constant(Constant::Bool(level)) => ArgumentLiteral::Boolean(*level),
        ExprKind::Constant(Constant::Float(float)) => ArgumentLiteral::Number(*float),
        ExprKind::Constant(Constant::Str(text)) => ArgumentLiteral::Text(text),
        ExprKind::Unary { op, operand } => match (op, literal(operand)) {
            (UnaryOp::Neg, ArgumentLiteral::Integer(int)) => int
                .checked_neg()
                .map_or(ArgumentLiteral::Other, ArgumentLiteral::Integer),
            (UnaryOp::Neg, ArgumentLiteral::Number(number)) => ArgumentLiteral::Number(-number),
            (UnaryOp::Pos, number @ (ArgumentLiteral::Integer(_) | ArgumentLiteral::Number(_))) => {
                number
            }
            _ => ArgumentLiteral::Other,
        },
        ExprKind::List(items) | ExprKind::Tuple(items)
            if !items
                .iter()
                .any(|item| matches!(item.kind, ExprKind::Starred(_))) =>
        {
            ArgumentLiteral::List(items.iter().map(literal).collect())
        }
        ExprKind::Call { function, .. } => match &function.kind {
            ExprKind::Name(name) => ArgumentLiteral::CallOf(name),
            _ => ArgumentLiteral::Other,
        },
        _ => ArgumentLiteral::Other,
    }
}
