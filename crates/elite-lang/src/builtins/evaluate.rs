//! `eval` and `exec`: program text made at run time.
//!
//! A text sees the variables of its caller. At the top level these are the globals themselves; in a function they are
//! a copy, as in Python: what the text assigns there is lost when it ends.

use std::rc::Rc;
use std::sync::Arc;

use super::Args;
use crate::diagnostic::{Diagnostic, Severity};
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::eval::code::Code;
use crate::parser::{parse, parse_expression};
use crate::resolve::{KnownNames, resolve};
use crate::source::SourceFile;
use crate::stack::with_deep_stack;
use crate::value::module::Namespace;
use crate::value::{Dict, Function, R, Raised, Value};

/// Longest text that is evaluated, in bytes.
const TEXT_MAX: usize = 8 << 20;

pub(super) fn eval(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let (file, scope) = prepare(ev, args, "eval")?;
    let code = with_deep_stack(|| eval_code(ev, &file, &scope))?;
    scope.run(ev, code)
}

fn eval_code(ev: &Evaluator<'_>, file: &Arc<SourceFile>, scope: &TextScope) -> R<Rc<Code>> {
    let (expr, parsed) = parse_expression(file);
    let expr = match (expr, refusal(ev, file, &parsed.diagnostics)) {
        (Some(expr), None) => expr,
        (_, Some(raised)) => return Err(raised),
        (None, None) => return Err(ev.raise(ExceptionKind::SyntaxError, "invalid syntax")),
    };
    // The expression is resolved as the only statement of a module.
    let statement = crate::ast::Stmt {
        span: expr.span,
        kind: crate::ast::StmtKind::Expr(expr.clone()),
    };
    let module = crate::ast::Module {
        body: vec![statement],
        ..parsed.module
    };
    let resolution = resolve(&module, &KnownNames::default());
    if let Some(raised) = refusal(ev, file, &resolution.diagnostics) {
        return Err(raised);
    }
    Ok(crate::lower::expression(
        &ev.core,
        &scope.namespace,
        file,
        &expr,
        &resolution,
    ))
}

pub(super) fn exec(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let (file, scope) = prepare(ev, args, "exec")?;
    let code = with_deep_stack(|| exec_code(ev, &file, &scope))?;
    scope.run(ev, code).map(|_| Value::None)
}

fn exec_code(ev: &Evaluator<'_>, file: &Arc<SourceFile>, scope: &TextScope) -> R<Rc<Code>> {
    let parsed = parse(file);
    if let Some(raised) = refusal(ev, file, &parsed.diagnostics) {
        return Err(raised);
    }
    let resolution = resolve(&parsed.module, &KnownNames::default());
    if let Some(raised) = refusal(ev, file, &resolution.diagnostics) {
        return Err(raised);
    }
    for name in &resolution.bindings {
        if scope.is_separate {
            scope.namespace.own_cell(ev.core.symbols.intern(name));
        }
    }
    let module = &parsed.module;
    Ok(crate::lower::module(
        &ev.core,
        &scope.namespace,
        file,
        module,
        &resolution,
    ))
}

pub(super) fn compile(ev: &Evaluator<'_>, _: &mut Args<'_>) -> R {
    let text = "compile() is not supported: give the text to eval() or exec()";
    Err(ev.raise(ExceptionKind::NotImplementedError, text))
}

/// Where a text runs.
struct TextScope {
    namespace: Rc<Namespace>,
    /// The namespace is not that of the globals.
    is_separate: bool,
    /// Dictionaries that get the variables afterwards, with the namespace they stand for.
    written_back: Vec<(Rc<Dict>, Rc<Namespace>)>,
}

impl TextScope {
    fn run(&self, ev: &Evaluator<'_>, code: Rc<Code>) -> R {
        let result = if self.is_separate {
            ev.run_text(&code, &self.namespace)
        } else {
            ev.call_function(&Function::plain(code, Box::default()), &mut [], &[])
        };
        for (dict, namespace) in &self.written_back {
            for (name, value) in namespace.entries() {
                dict.set_interned(ev.core.symbols.value(name), value);
            }
        }
        result
    }
}

/// The text and its scope, from the arguments `source, globals, locals`.
fn prepare(ev: &Evaluator<'_>, args: &Args<'_>, function: &str) -> R<(Arc<SourceFile>, TextScope)> {
    if !args.keywords.is_empty() {
        return Err(ev.type_error(format!("{function}() takes no keyword arguments")));
    }
    let Some(source) = args.positional.first() else {
        return Err(ev.type_error(format!("{function} expected at least 1 argument, got 0")));
    };
    let text = match ev.plain(source) {
        Value::Str(text) => text.as_str().to_owned(),
        other => match ev.bytes_like(&other) {
            Some(data) => String::from_utf8_lossy(&data).into_owned(),
            None => {
                return Err(ev.type_error(format!(
                    "{function}() arg 1 must be a string, bytes or code object"
                )));
            }
        },
    };
    if text.len() > TEXT_MAX {
        return Err(ev.value_error(format!(
            "{function}() text of {} bytes, {TEXT_MAX} are allowed",
            text.len()
        )));
    }
    let dict = |index: usize, what: &str| match args.positional.get(index) {
        None | Some(Value::None) => Ok(None),
        Some(value) => match ev.plain(value) {
            Value::Dict(dict) => Ok(Some(dict)),
            other => {
                let name = ev.core.types.name_of(&other);
                Err(ev.type_error(format!("{function}() {what} must be a dict, not {name}")))
            }
        },
    };
    let (globals, locals) = (dict(1, "globals")?, dict(2, "locals")?);
    Ok((
        SourceFile::new("<string>", text),
        text_scope(ev, args, globals, locals),
    ))
}

fn text_scope(
    ev: &Evaluator<'_>,
    args: &Args<'_>,
    globals: Option<Rc<Dict>>,
    locals: Option<Rc<Dict>>,
) -> TextScope {
    let core = &ev.core;
    let mut written_back = Vec::new();
    let given_globals = globals.is_some();
    let mut namespace = match globals {
        None => args
            .caller
            .as_ref()
            .and_then(|frame| ev.text_namespace(frame))
            .unwrap_or_else(|| core.globals.clone()),
        Some(dict) => {
            let namespace = core.new_namespace(None);
            fill(ev, &namespace, &dict);
            written_back.push((dict, namespace.clone()));
            namespace
        }
    };
    let mut is_separate = given_globals;
    if let Some(dict) = locals {
        namespace = core.new_namespace(Some(namespace));
        fill(ev, &namespace, &dict);
        written_back.push((dict, namespace.clone()));
        is_separate = true;
    } else if let (false, Some(frame)) = (given_globals, &args.caller)
        && !ev.is_module(frame)
    {
        namespace = core.new_namespace(Some(namespace));
        for (name, value) in ev.frame_variables(frame) {
            drop(namespace.own_cell(name).value.replace(value));
        }
        is_separate = true;
    }
    TextScope {
        namespace,
        is_separate,
        written_back,
    }
}

fn fill(ev: &Evaluator<'_>, namespace: &Namespace, dict: &Dict) {
    for (_, key, value) in dict.entries() {
        if let Value::Str(name) = key {
            let name = ev.core.symbols.intern(name.as_str());
            drop(namespace.own_cell(name).value.replace(value));
        }
    }
}

/// The first error of a text as a `SyntaxError`.
fn refusal(ev: &Evaluator<'_>, file: &SourceFile, diagnostics: &[Diagnostic]) -> Option<Raised> {
    let error = diagnostics
        .iter()
        .find(|diagnostic| diagnostic.severity == Severity::Error)?;
    let line = file.position(error.span.start).line;
    let kind = if error.code == "indentation" {
        ExceptionKind::IndentationError
    } else {
        ExceptionKind::SyntaxError
    };
    Some(ev.raise(kind, format!("{} (<string>, line {line})", error.message)))
}
