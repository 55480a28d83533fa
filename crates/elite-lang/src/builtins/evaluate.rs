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
use crate::parser::{parse_expression, parse_within};
use crate::resolve::{KnownNames, resolve};
use crate::source::SourceFile;
use crate::stack::with_deep_stack;
use crate::value::instance::Payload;
use crate::value::module::Namespace;
use crate::value::{Dict, Function, Instance, R, Raised, Value};

/// Longest text that is evaluated, in bytes.
const TEXT_MAX: usize = 8 << 20;

fn code_object(value: &Value) -> Option<&CodeObject> {
    match value {
        Value::Instance(instance) => instance.object(),
        _ => None,
    }
}

pub(super) fn eval(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    if args
        .positional
        .first()
        .and_then(code_object)
        .is_some_and(|code| !code.is_expression)
    {
        return exec(ev, args);
    }
    let (file, scope) = prepare(ev, args, "eval")?;
    let code = with_deep_stack(|| eval_code(ev, &file, &scope))?;
    scope.run(ev, code)
}

fn eval_code(ev: &Evaluator<'_>, file: &Arc<SourceFile>, scope: &TextScope) -> R<Rc<Code>> {
    let (expr, parsed) = parse_expression(file, ev.core.memory_left());
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
    ev.check_allocation(parsed.bytes)?;
    let code = crate::lower::expression(&ev.core, &scope.namespace, file, &expr, &resolution);
    scope.check(&code);
    Ok(code)
}

pub(super) fn exec(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let (file, scope) = prepare(ev, args, "exec")?;
    let code = with_deep_stack(|| exec_code(ev, &file, &scope))?;
    scope.run(ev, code).map(|_| Value::None)
}

fn exec_code(ev: &Evaluator<'_>, file: &Arc<SourceFile>, scope: &TextScope) -> R<Rc<Code>> {
    let parsed = parse_within(file, ev.core.memory_left());
    if let Some(raised) = refusal(ev, file, &parsed.diagnostics) {
        return Err(raised);
    }
    let resolution = resolve(&parsed.module, &KnownNames::default());
    if let Some(raised) = refusal(ev, file, &resolution.diagnostics) {
        return Err(raised);
    }
    for name in &resolution.bindings {
        if scope.is_separate {
            scope.namespace.own_cell(ev.core.symbols.take(name));
        }
    }
    ev.check_allocation(parsed.bytes)?;
    let module = &parsed.module;
    let code = crate::lower::module(&ev.core, &scope.namespace, file, module, &resolution);
    scope.check(&code);
    Ok(code)
}

/// What `compile` makes: a text that is known to be right, for `eval` and `exec`.
struct CodeObject {
    text: String,
    is_expression: bool,
}

/// `compile(source, filename, mode)`. The text is checked now and read again when it is evaluated.
pub(super) fn compile(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let (source, mode) = match (&*args.positional, args.keywords) {
        ([source, _, mode, ..], []) => (source, mode),
        (given, _) => {
            let text = format!(
                "compile() takes source, filename and mode by position ({} given)",
                given.len()
            );
            return Err(ev.type_error(text));
        }
    };
    let is_expression = match mode {
        Value::Str(mode) if mode.as_str() == "eval" => true,
        Value::Str(mode) if matches!(mode.as_str(), "exec" | "single") => false,
        _ => return Err(ev.value_error("compile() mode must be 'exec', 'eval' or 'single'")),
    };
    let text = source_text(ev, source, "compile")?;
    let file = SourceFile::new("<string>", text.clone());
    with_deep_stack(|| {
        let (module, diagnostics) = if is_expression {
            let (expr, parsed) = parse_expression(&file, ev.core.memory_left());
            let statement = expr.map(|expr| crate::ast::Stmt {
                span: expr.span,
                kind: crate::ast::StmtKind::Expr(expr),
            });
            let body = statement.into_iter().collect();
            (
                crate::ast::Module {
                    body,
                    ..parsed.module
                },
                parsed.diagnostics,
            )
        } else {
            let parsed = parse_within(&file, ev.core.memory_left());
            (parsed.module, parsed.diagnostics)
        };
        if let Some(raised) = refusal(ev, &file, &diagnostics) {
            return Err(raised);
        }
        let resolution = resolve(&module, &KnownNames::default());
        refusal(ev, &file, &resolution.diagnostics).map_or(Ok(()), Err)
    })?;
    let code = CodeObject {
        text,
        is_expression,
    };
    let class = ev.core.types.code.clone();
    let payload = Payload::Object(Box::new(code));
    Ok(Value::Instance(Instance::new(class, payload)))
}

fn source_text(ev: &Evaluator<'_>, source: &Value, function: &str) -> R<String> {
    let check = |bytes: usize| match bytes > TEXT_MAX {
        true => Err(ev.value_error(format!(
            "{function}() text of {bytes} bytes, {TEXT_MAX} are allowed"
        ))),
        // The text is kept beside the file that is made of it.
        false => ev.check_allocation(2 * bytes),
    };
    match ev.plain(source) {
        Value::Str(text) => {
            check(text.as_str().len())?;
            Ok(text.as_str().to_owned())
        }
        other => match ev.bytes_like(&other) {
            Some(data) => {
                check(data.len())?;
                Ok(String::from_utf8_lossy(&data).into_owned())
            }
            None => Err(ev.type_error(format!(
                "{function}() arg 1 must be a string, bytes or code object"
            ))),
        },
    }
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
    /// What the code refers to is listed exactly, or not at all.
    fn check(&self, code: &Code) {
        match self.is_separate {
            true => code.refers.check(self.namespace.own_cells()),
            // The variables are those of the text around.
            false => code.refers.forget(),
        }
    }

    fn run(&self, ev: &Evaluator<'_>, code: Rc<Code>) -> R {
        let result = if self.is_separate {
            ev.run_text(&code, &self.namespace)
        } else {
            ev.call_function(&Function::plain(code, Box::default()), &mut [], &[])
        };
        if self.is_separate {
            // Functions of the text refer to its variables, which may refer to them.
            ev.core.note_namespace(&self.namespace);
        }
        for (dict, namespace) in &self.written_back {
            ev.core.note_namespace(namespace);
            ev.core.note(&Value::Dict(dict.clone()));
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
    ev.core.sweep_names_if_due();
    let text = match code_object(source) {
        Some(code) => code.text.clone(),
        None => source_text(ev, source, function)?,
    };
    let dict = |index: usize, what: &str| match args.positional.get(index) {
        None | Some(Value::None) => Ok(None),
        Some(value) => match ev.plain(value) {
            Value::Dict(dict) => Ok(Some(dict)),
            other => {
                let name = ev.core.types.name_of(&other);
                Err(ev.type_error(match (function, what) {
                    ("eval", "locals") => "locals must be a mapping".to_owned(),
                    ("eval", _) => "globals must be a dict".to_owned(),
                    ("exec", "locals") => {
                        format!("locals must be a mapping or None, not {name}")
                    }
                    _ => format!("exec() globals must be a dict, not {name}"),
                }))
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
    if is_separate {
        namespace.set_of_text();
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
            let name = ev.core.symbols.take(name.as_str());
            drop(namespace.own_cell(name).value.replace(value));
        }
    }
}

/// The first error of a text as a `SyntaxError`.
fn refusal(ev: &Evaluator<'_>, file: &SourceFile, diagnostics: &[Diagnostic]) -> Option<Raised> {
    let error = diagnostics
        .iter()
        .find(|diagnostic| diagnostic.severity == Severity::Error)?;
    if error.code == "too-large" {
        return Some(ev.memory_error(error.message.clone()));
    }
    let line = file.position(error.span.start).line;
    let kind = if error.code == "indentation" {
        ExceptionKind::IndentationError
    } else {
        ExceptionKind::SyntaxError
    };
    let raised = ev.raise(kind, format!("{} (<string>, line {line})", error.message));
    if let Raised::Exception(exception) = &raised {
        let symbols = &ev.core.symbols;
        let set = |name: &str, value: Value| exception.set(symbols.intern(name), value, symbols);
        set("msg", Value::str(error.message.as_str()));
        set("filename", Value::str("<string>"));
        set("lineno", Value::Int(i64::from(line)));
        let column = file.position(error.span.start).column;
        set("offset", Value::Int(i64::from(column)));
    }
    Some(raised)
}
