//! Reading a text that a program makes at run time: with pauses, within bounds, and what it is refused for.

use std::cell::RefCell;
use std::sync::Arc;

use elite_syntax::ast::{Module, Stmt, StmtKind};
use elite_syntax::parser::{TREE_MAX, parse_expression, parse_within};
use elite_syntax::resolve::{KnownNames, Resolution, resolve_within};
use elite_syntax::{Diagnostic, Severity, SourceFile, WorkBudget};

use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::value::{R, Unwind, Value};

/// Longest text that is evaluated, in bytes.
const EVAL_SOURCE_BYTES_MAX: usize = 1 << 20;

/// Runs `work`, which reads a text of any length: on a deep stack, with pauses in which others have their turn.
pub(crate) fn with_parse_budget<T>(
    ev: &Evaluator<'_>,
    work: impl FnOnce(&WorkBudget<'_>) -> R<T>,
) -> R<T> {
    let ended = RefCell::new(None);
    let pause = |units: usize| match ev.charge(units) {
        Ok(()) => true,
        Err(raised) => {
            *ended.borrow_mut() = Some(raised);
            false
        }
    };
    let budget = WorkBudget::with_pauses(ev.core.memory_left().min(TREE_MAX), &pause);
    let result = ev.with_deep_stack(|| work(&budget));
    match ended.take() {
        // What was made of a text that was given up means nothing.
        Some(raised) => Err(raised),
        None => result,
    }
}

/// A text that is right, and its names.
pub(crate) struct ResolvedTree {
    pub module: Module,
    pub resolution: Resolution,
}

/// Reads a text; that of an expression becomes the only statement of a module.
pub(crate) fn parse_and_resolve(
    ev: &Evaluator<'_>,
    file: &Arc<SourceFile>,
    is_expression: bool,
    budget: &WorkBudget<'_>,
) -> R<ResolvedTree> {
    let parsed = match is_expression {
        true => {
            let (expr, mut parsed) = parse_expression(file, budget);
            let statement = expr.map(|expr| Stmt {
                span: expr.span,
                kind: StmtKind::Expr(expr),
            });
            parsed.module.body = statement.into_iter().collect();
            parsed
        }
        false => parse_within(file, budget),
    };
    if let Some(raised) = syntax_error(ev, file, &parsed.diagnostics) {
        parsed.module.release(budget);
        return Err(raised);
    }
    let resolution = resolve_within(&parsed.module, &KnownNames::default(), budget);
    let refused = syntax_error(ev, file, &resolution.diagnostics);
    let refused = match refused {
        Some(raised) => Err(raised),
        None => ev.check_allocation(parsed.bytes),
    };
    if let Err(raised) = refused {
        release(parsed.module, resolution, budget);
        return Err(raised);
    }
    Ok(ResolvedTree {
        module: parsed.module,
        resolution,
    })
}

/// Drops what is no longer needed of a text, with pauses.
pub(crate) fn release(module: Module, resolution: Resolution, budget: &WorkBudget<'_>) {
    module.release(budget);
    resolution.release(budget);
}

/// The text that is to be read; `wanted` is what may be given.
pub(super) fn source_text(
    ev: &Evaluator<'_>,
    source: &Value,
    function: &str,
    wanted: &str,
) -> R<String> {
    let check = |bytes: usize| match bytes > EVAL_SOURCE_BYTES_MAX {
        true => Err(ev.value_error(format!(
            "{function}() text of {bytes} bytes, {EVAL_SOURCE_BYTES_MAX} are allowed"
        ))),
        // The text is kept beside the file that is made of it.
        false => ev.check_allocation(2 * bytes),
    };
    let text = match ev.unwrap_builtin(source) {
        Value::Str(text) => {
            check(text.as_str().len())?;
            let mut copy = String::new();
            ev.push_text(&mut copy, text.as_str())?;
            copy
        }
        other => match ev.bytes_like(&other) {
            Some(data) => {
                check(data.len())?;
                ev.decode_utf8_lossy(&data)?
            }
            None => {
                let text = format!("{function}() arg 1 must be a string, bytes or {wanted} object");
                return Err(ev.type_error(text));
            }
        },
    };
    match text.as_bytes().contains(&0) {
        true => {
            let text = "source code string cannot contain null bytes";
            Err(ev.raise(ExceptionKind::SyntaxError, text))
        }
        false => Ok(text),
    }
}

/// How a text is called that was given no name.
pub(super) const TEXT_NAME: &str = "<string>";

pub(super) fn source_file(ev: &Evaluator<'_>, name: &str, text: String) -> R<Arc<SourceFile>> {
    SourceFile::by_pieces(name.into(), text, |bytes| ev.charge(bytes * 2))
}

/// The first error of a text as a `SyntaxError`.
fn syntax_error(
    ev: &Evaluator<'_>,
    file: &SourceFile,
    diagnostics: &[Diagnostic],
) -> Option<Unwind> {
    let error = diagnostics
        .iter()
        .find(|diagnostic| diagnostic.severity == Severity::Error)?;
    if error.code == "too-large" {
        return Some(ev.memory_error(error.message.to_string()));
    }
    let line = file.position(error.span.start).line;
    let kind = if error.code == "indentation" {
        ExceptionKind::IndentationError
    } else {
        ExceptionKind::SyntaxError
    };
    let text = format!("{} ({}, line {line})", error.message, file.name());
    let raised = ev.raise(kind, text);
    if let Unwind::Exception(exception) = &raised {
        let symbols = &ev.core.symbols;
        let set = |name: &str, value: Value| exception.set(symbols.intern(name), value, symbols);
        set("msg", Value::str(error.message.english()));
        set("filename", Value::str(file.name()));
        set("lineno", Value::Int(i64::from(line)));
        let column = file.position(error.span.start).column;
        set("offset", Value::Int(i64::from(column)));
    }
    Some(raised)
}
