//! `eval` and `exec`: program text made at run time.
//!
//! A text sees the variables of its caller. At the top level these are the globals themselves; in a function they are
//! a copy, as in Python: what the text assigns there is lost when it ends. A dictionary given as globals becomes the
//! namespace of the text, and stays it (`Dict::hold_variables`); names at the top level of the text go through any
//! mapping that is given as locals.

use std::collections::HashMap;
use std::rc::Rc;
use std::sync::Arc;

use elite_syntax::ast::{Stmt, StmtKind};
use elite_syntax::parser::parse_expression;
use elite_syntax::{Severity, SourceFile};

use super::Args;
use super::compile::code_text;
use super::reading::{
    ResolvedTree, TEXT_NAME, parse_and_resolve, release, source_file, source_text,
    with_parse_budget,
};
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::eval::code::Code;
use crate::value::module::Namespace;
use crate::value::symbol::known;
use crate::value::{CellVar, Dict, Function, R, Symbol, Value};

/// Work for a variable that is handed in or back.
pub(super) const VARIABLE: usize = 128;

pub(super) fn eval(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let EvalPlan { source, scope } = prepare(ev, args, true)?;
    match source {
        EvalSource::Code(code) => run_code(ev, &code, Box::default()),
        EvalSource::Text(file, true) => run_expression(ev, &file, &scope),
        EvalSource::Text(file, false) => run_statements(ev, &file, &scope).map(|()| Value::None),
    }
}

fn run_expression(ev: &Evaluator<'_>, file: &Arc<SourceFile>, scope: &EvalScope) -> R {
    let code = with_parse_budget(ev, |budget| {
        let ResolvedTree { module, resolution } = parse_and_resolve(ev, file, true, budget)?;
        let [
            Stmt {
                kind: StmtKind::Expr(expr),
                ..
            },
        ] = &module.body[..]
        else {
            release(module, resolution, budget);
            return Err(ev.raise(ExceptionKind::SyntaxError, "invalid syntax"));
        };
        let (core, namespace) = (&ev.core, &scope.namespace);
        let code = crate::lower::expression(core, namespace, file, expr, &resolution, budget);
        release(module, resolution, budget);
        Ok(code)
    })?;
    scope.check(ev, &code)?;
    scope.run(ev, code)
}

pub(super) fn exec(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let closure = exec_closure(ev, args)?;
    let EvalPlan { source, scope } = prepare(ev, args, false)?;
    match (source, closure) {
        (EvalSource::Code(code), closure) => {
            let cells = cells_for_exec(ev, &code, closure)?;
            run_code(ev, &code, cells)?;
        }
        (EvalSource::Text(..), Some(_)) if code_text(&args.positional[0]).is_some() => {
            return Err(ev.type_error(NO_CLOSURE));
        }
        (EvalSource::Text(..), Some(_)) => {
            let text = "closure can only be used when source is a code object";
            return Err(ev.type_error(text));
        }
        (EvalSource::Text(file, true), None) => drop(run_expression(ev, &file, &scope)?),
        (EvalSource::Text(file, false), None) => run_statements(ev, &file, &scope)?,
    }
    Ok(Value::None)
}

const NO_CLOSURE: &str = "cannot use a closure with this code object";

/// The only keyword argument of `exec`, if there is one and it is not None.
fn exec_closure(ev: &Evaluator<'_>, args: &Args<'_>) -> R<Option<Value>> {
    let mut closure = None;
    for (name, value) in args.keywords {
        let text = ev.core.symbols.name(*name);
        if &*text != "closure" {
            let text = format!("'{text}' is an invalid keyword argument for exec()");
            return Err(ev.type_error(text));
        }
        closure = Some(value.clone()).filter(|value| !value.is_none());
    }
    Ok(closure)
}

/// The variables of outer functions for code that is executed.
fn cells_for_exec(
    ev: &Evaluator<'_>,
    code: &Code,
    closure: Option<Value>,
) -> R<Box<[Rc<CellVar>]>> {
    let wanted = code.free_names.len();
    if wanted == 0 {
        return match closure {
            Some(_) => Err(ev.type_error(NO_CLOSURE)),
            None => Ok(Box::default()),
        };
    }
    let cell = |value: &Value| match value {
        Value::Cell(cell) => Some(cell.clone()),
        _ => None,
    };
    let cells = match &closure {
        Some(Value::Tuple(cells)) if cells.items().len() == wanted => {
            cells.items().iter().map(cell).collect()
        }
        _ => None,
    };
    cells.ok_or_else(|| {
        let text = format!("code object requires a closure of exactly length {wanted}");
        ev.type_error(text)
    })
}

/// Runs the code of a function as `exec` and `eval` do, without arguments.
fn run_code(ev: &Evaluator<'_>, code: &Rc<Code>, closure: Box<[Rc<CellVar>]>) -> R {
    ev.call_function(
        &Function::without_defaults(code.clone(), closure),
        &mut [],
        &[],
    )
}

fn run_statements(ev: &Evaluator<'_>, file: &Arc<SourceFile>, scope: &EvalScope) -> R<()> {
    let code = with_parse_budget(ev, |budget| {
        let ResolvedTree { module, resolution } = parse_and_resolve(ev, file, false, budget)?;
        for name in &resolution.bindings {
            if scope.is_separate && scope.mapping.is_none() {
                budget.charge(VARIABLE);
                scope.namespace.own_cell(ev.core.symbols.intern_used(name));
            }
        }
        let (core, namespace) = (&ev.core, &scope.namespace);
        let code = crate::lower::module(core, namespace, file, &module, &resolution, budget);
        release(module, resolution, budget);
        Ok(code)
    })?;
    scope.check(ev, &code)?;
    scope.run(ev, code).map(drop)
}

/// What a text gave that was run for a debugger.
pub(crate) struct EvalResult {
    /// The value of the text; None if it is no expression.
    pub value: Option<Value>,
    /// The variables that the text was given, in the state that it left them in, and those that it made.
    pub variables: Vec<(Symbol, Value)>,
}

/// Runs a text, an expression or statements, that sees these variables in front of the globals; without any it sees and
/// changes the globals themselves.
pub(crate) fn run_in(
    ev: &Evaluator<'_>,
    text: String,
    variables: Option<Vec<(Symbol, Value)>>,
) -> R<EvalResult> {
    let file = source_file(ev, TEXT_NAME, text)?;
    let namespace = match variables {
        None => ev.core.globals.clone(),
        Some(variables) => {
            let namespace = ev.core.new_namespace(Some(ev.core.globals.clone()));
            for (name, value) in variables {
                drop(namespace.own_cell(name).replace(value));
            }
            namespace.set_of_text();
            namespace
        }
    };
    let is_separate = namespace.is_of_text();
    let is_expression = with_parse_budget(ev, |budget| {
        let (_, parsed) = parse_expression(&file, budget);
        let is_right = parsed
            .diagnostics
            .iter()
            .all(|finding| finding.severity != Severity::Error);
        parsed.module.release(budget);
        Ok(is_right)
    })?;
    let code = with_parse_budget(ev, |budget| {
        let ResolvedTree { module, resolution } =
            parse_and_resolve(ev, &file, is_expression, budget)?;
        if is_separate {
            for name in &resolution.bindings {
                namespace.own_cell(ev.core.symbols.intern_used(name));
            }
        }
        let core = &ev.core;
        let code = match &module.body[..] {
            [
                Stmt {
                    kind: StmtKind::Expr(expr),
                    ..
                },
            ] if is_expression => {
                crate::lower::expression(core, &namespace, &file, expr, &resolution, budget)
            }
            _ => crate::lower::module(core, &namespace, &file, &module, &resolution, budget),
        };
        release(module, resolution, budget);
        Ok(code)
    })?;
    let scope = EvalScope {
        namespace,
        is_separate,
        mapping: None,
        home: None,
        before: HashMap::new(),
    };
    scope.check(ev, &code)?;
    let value = scope.run(ev, code)?;
    let variables = match is_separate {
        true => scope.namespace.entries(),
        false => Vec::new(),
    };
    Ok(EvalResult {
        value: is_expression.then_some(value),
        variables,
    })
}

/// Where a text runs.
struct EvalScope {
    namespace: Rc<Namespace>,
    /// The namespace is not that of the globals.
    is_separate: bool,
    /// The mapping that names at the top level go through.
    mapping: Option<Value>,
    /// The dictionary that the global variables are in.
    home: Option<Rc<Dict>>,
    /// How many references there were to each of its variables before the text was read.
    before: CellRefCounts,
}

impl EvalScope {
    /// What the code refers to is listed exactly, or not at all.
    fn check(&self, ev: &Evaluator<'_>, code: &Code) -> R<()> {
        let mut worked = || ev.charge(VARIABLE);
        match self.is_separate {
            true => code.refs.check(
                self.namespace.own_cells(),
                &self.before,
                self.namespace.shown().is_some(),
                &mut worked,
            )?,
            // The variables are those of the text around.
            false => code.refs.forget(&mut worked)?,
        }
        if let Some(home) = &self.home {
            code.refs.set_home(home, &mut worked)?;
        }
        Ok(())
    }

    fn run(&self, ev: &Evaluator<'_>, code: Rc<Code>) -> R {
        let result = if self.is_separate {
            ev.run_text(&code, &self.namespace, self.mapping.as_ref())
        } else {
            ev.call_function(
                &Function::without_defaults(code, Box::default()),
                &mut [],
                &[],
            )
        };
        if self.is_separate {
            // Functions of the text refer to its variables, which may refer to them.
            ev.core.note_namespace(&self.namespace);
        }
        if let Some(home) = &self.home {
            ev.core.gc_track(&Value::Dict(home.clone()));
        }
        result
    }
}

/// What is evaluated.
enum EvalSource {
    /// A text, and whether it is an expression.
    Text(Arc<SourceFile>, bool),
    /// The code of a function, for the globals that are given.
    Code(Rc<Code>),
}

/// What is evaluated, and where.
struct EvalPlan {
    source: EvalSource,
    scope: EvalScope,
}

/// What `eval` or `exec` has to do, from the arguments `source, globals, locals`.
fn prepare(ev: &Evaluator<'_>, args: &Args<'_>, is_eval: bool) -> R<EvalPlan> {
    let function = if is_eval { "eval" } else { "exec" };
    if is_eval && !args.keywords.is_empty() {
        return Err(ev.type_error("eval() takes no keyword arguments"));
    }
    let given = args.positional.len();
    let Some(source) = args.positional.first().filter(|_| given <= 3) else {
        return Err(ev.type_error(match (is_eval, given) {
            (true, 0) => "eval expected at least 1 argument, got 0".to_owned(),
            (true, _) => format!("eval expected at most 3 arguments, got {given}"),
            (false, 0) => "exec() takes at least 1 positional argument (0 given)".to_owned(),
            (false, _) => format!("exec() takes at most 3 positional arguments ({given} given)"),
        }));
    };
    ev.sweep_names_if_due()?;
    let given = |index: usize| {
        let value = args.positional.get(index);
        value.filter(|value| !value.is_none())
    };
    let locals = given(2).cloned();
    let check_locals = || match &locals {
        Some(value) if !is_mapping(ev, value) => {
            let name = ev.core.types.name_of(value);
            Err(ev.type_error(match is_eval {
                true => "locals must be a mapping".to_owned(),
                false => format!("locals must be a mapping or None, not {name}"),
            }))
        }
        _ => Ok(()),
    };
    if is_eval {
        check_locals()?;
    }
    let globals = match given(1).map(|value| (ev.unwrap_builtin(value), value)) {
        None => None,
        Some((Value::Dict(dict), _)) => Some(dict),
        Some((_, value)) => {
            let name = ev.core.types.name_of(value);
            return Err(ev.type_error(match is_eval {
                true if is_mapping(ev, value) => {
                    "globals must be a real dict; try eval(expr, {}, mapping)".to_owned()
                }
                true => "globals must be a dict".to_owned(),
                false => format!("exec() globals must be a dict, not {name}"),
            }));
        }
    };
    check_locals()?;
    if let Value::Code(code) = source {
        if is_eval && !code.free_names.is_empty() {
            let text = "code object passed to eval() may not contain free variables";
            return Err(ev.type_error(text));
        }
        let scope = text_scope(ev, args, globals.clone(), None)?;
        let dict = match (globals, &args.caller) {
            (Some(dict), _) => dict,
            (None, Some(frame)) => ev.globals_of(&frame.function.code),
            (None, None) => ev.globals_dict(),
        };
        let source = EvalSource::Code(ev.code_in(code, &dict)?);
        return Ok(EvalPlan { source, scope });
    }
    let scope = text_scope(ev, args, globals, locals)?;
    let source = match code_text(source) {
        Some(code) => {
            let mut copy = String::new();
            ev.push_text(&mut copy, &code.text)?;
            EvalSource::Text(source_file(ev, &code.file_name, copy)?, code.is_expression)
        }
        None => {
            let text = source_text(ev, source, function, "code")?;
            EvalSource::Text(source_file(ev, TEXT_NAME, text)?, is_eval)
        }
    };
    Ok(EvalPlan { source, scope })
}

/// Whether a value can be asked for the values of names.
fn is_mapping(ev: &Evaluator<'_>, value: &Value) -> bool {
    matches!(
        ev.unwrap_builtin(value),
        Value::Dict(_) | Value::List(_) | Value::Tuple(_) | Value::Str(_)
    ) || ev.core.types.of(value).lookup(known::GETITEM).is_some()
}

fn text_scope(
    ev: &Evaluator<'_>,
    args: &Args<'_>,
    globals: Option<Rc<Dict>>,
    locals: Option<Value>,
) -> R<EvalScope> {
    let core = &ev.core;
    let given_globals = globals.is_some();
    let caller = args.caller.as_ref();
    let running = caller.and_then(|frame| ev.text_namespace(frame));
    // A text sees what the code that evaluates it sees: in a text or a function of one its variables.
    let home = globals.or_else(|| caller.and_then(|frame| frame.function.code.refs.home()));
    let mut before = HashMap::new();
    let mut namespace = match (&home, running) {
        (Some(dict), _) => {
            enter_builtins(ev, dict);
            dictionary_namespace(ev, dict, &mut before)?
        }
        (None, Some(running)) => running,
        (None, None) => {
            match caller.and_then(|frame| frame.function.code.module.as_ref()?.upgrade()) {
                Some(module) => module,
                None => core.globals.clone(),
            }
        }
    };
    let mut is_separate = home.is_some();
    // At the top level of a text in a mapping, a text within goes through the same one.
    let mapping = locals.or_else(|| match given_globals {
        true => None,
        false => ev.mapping_of(caller?),
    });
    let mapping = mapping.filter(|mapping| match (mapping, &home) {
        (Value::Dict(dict), Some(home)) => !Rc::ptr_eq(dict, home),
        _ => true,
    });
    if mapping.is_some() {
        namespace = core.new_namespace(Some(namespace));
        namespace.set_by_mapping();
        is_separate = true;
    } else if let (false, Some(frame)) = (given_globals, &args.caller)
        && !ev.is_module(frame)
    {
        namespace = core.new_namespace(Some(namespace));
        for (name, value) in ev.frame_variables(frame) {
            drop(namespace.own_cell(name).replace(value));
        }
        is_separate = true;
    }
    if is_separate {
        namespace.set_of_text();
    }
    Ok(EvalScope {
        namespace,
        is_separate,
        mapping,
        home,
        before,
    })
}

/// How many references there are to each variable of a dictionary.
type CellRefCounts = HashMap<*const CellVar, usize>;

/// A namespace of the variables in a dictionary, whose references it counts.
pub(super) fn dictionary_namespace(
    ev: &Evaluator<'_>,
    dict: &Rc<Dict>,
    before: &mut CellRefCounts,
) -> R<Rc<Namespace>> {
    let namespace = ev.core.new_namespace(None);
    namespace.set_in_dictionary();
    namespace.attach_dict(dict.clone(), &ev.core.symbols);
    if let Some(own) = ev.builtins_in(dict)
        && !Rc::ptr_eq(&own, &ev.builtins_dict())
    {
        let builtins = ev.core.new_namespace(None);
        builtins.attach_dict(own, &ev.core.symbols);
        namespace.set_builtins(builtins);
    }
    for variable in dict.variables() {
        ev.charge(VARIABLE)?;
        before.insert(Rc::as_ptr(&variable), Rc::strong_count(&variable) - 1);
    }
    Ok(namespace)
}

/// A dictionary that a text runs in has `__builtins__` from then on.
fn enter_builtins(ev: &Evaluator<'_>, globals: &Rc<Dict>) {
    if globals.get_str("__builtins__").is_none() {
        let own = Value::Dict(ev.builtins_dict());
        globals.set_str("__builtins__", own);
    }
}

impl Evaluator<'_> {
    /// What unbound names mean in a text with these globals: what `__builtins__` there has, a dictionary or a module.
    pub fn builtins_in(&self, globals: &Dict) -> Option<Rc<Dict>> {
        match globals.get_str("__builtins__")? {
            Value::Module(module) => Some(self.namespace_dict(&module.namespace)),
            other => match self.unwrap_builtin(&other) {
                Value::Dict(dict) => Some(dict),
                _ => None,
            },
        }
    }
}
