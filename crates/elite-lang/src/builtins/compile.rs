//! `compile`, and functions that are made from code: `FunctionType(code, globals, name, defaults, closure)`.
//!
//! A node refers to its global variables directly, so code for other globals is made anew: the text is read again, and
//! the code that stands at the same place is taken.

use std::collections::HashMap;
use std::rc::Rc;

use elite_syntax::ast::{Stmt, StmtKind};

use super::evaluate::{VARIABLE, dictionary_namespace};
use super::reading::{
    ResolvedTree, parse_and_resolve, release, source_file, source_text, with_parse_budget,
};
use crate::eval::Evaluator;
use crate::eval::code::Code;
use crate::value::data::NativeData;
use crate::value::data::no_values;
use crate::value::instance::InstancePayload;
use crate::value::symbol::known;
use crate::value::{CellVar, Dict, Function, Instance, R, ScriptCell, Value};

/// Flags that say how CPython's compiler reads a text: those of `__future__`, and its own.
const FLAGS: i32 = 0x01fe_7600 | 0x10;
/// The one that asks for a tree instead of code.
const ONLY_TREE: i32 = 0x400;

/// What `compile` makes: a text that is known to be right, for `eval` and `exec`.
pub(super) struct CompiledSource {
    pub text: String,
    pub file_name: String,
    pub is_expression: bool,
}

no_values!(CompiledSource);

/// What `compile` has made, if the value is that.
pub(super) fn code_text(value: &Value) -> Option<&CompiledSource> {
    match value {
        Value::Instance(instance) => instance.object(),
        _ => None,
    }
}

/// `compile(source, filename, mode, flags, dont_inherit, optimize)`. The text is checked now and read again when it is
/// evaluated.
pub(super) fn compile(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let file_name = file_name(ev, &args[1])?;
    let Value::Str(mode) = ev.unwrap_builtin(&args[2]) else {
        let found = ev.core.types.name_of_argument(&args[2]);
        let text = format!("compile() argument 'mode' must be str, not {found}");
        return Err(ev.type_error(text));
    };
    if mode.as_str().contains('\0') {
        return Err(ev.value_error("embedded null character"));
    }
    let number = |value: &Value, default: i32| match value.if_given() {
        None => Ok(default),
        Some(value) => ev.c_int(value),
    };
    let flags = number(&args[3], 0)?;
    number(&args[4], 0)?;
    let optimize = number(&args[5], -1)?;
    number(&args[6], -1)?;
    if flags & !FLAGS != 0 {
        return Err(ev.value_error("compile(): unrecognised flags"));
    }
    if !(-1..=2).contains(&optimize) {
        return Err(ev.value_error("compile(): invalid optimize value"));
    }
    let is_expression = match mode.as_str() {
        "eval" => true,
        "exec" | "single" => false,
        "func_type" if flags & ONLY_TREE == 0 => {
            return Err(ev.value_error("compile() mode 'func_type' requires flag PyCF_ONLY_AST"));
        }
        _ => return Err(ev.value_error("compile() mode must be 'exec', 'eval' or 'single'")),
    };
    if flags & ONLY_TREE != 0 {
        return Err(ev.value_error("compile(): there are no syntax trees here"));
    }
    let text = source_text(ev, &args[0], "compile", "AST")?;
    let mut copy = String::new();
    ev.push_text(&mut copy, &text)?;
    let file = source_file(ev, &file_name, copy)?;
    with_parse_budget(ev, |budget| {
        let ResolvedTree { module, resolution } =
            parse_and_resolve(ev, &file, is_expression, budget)?;
        release(module, resolution, budget);
        Ok(())
    })?;
    let shown = [
        ("co_name", Value::str("<module>")),
        ("co_qualname", Value::str("<module>")),
        ("co_filename", Value::str(file_name.as_str())),
        ("co_firstlineno", Value::Int(1)),
        ("co_argcount", Value::Int(0)),
        ("co_posonlyargcount", Value::Int(0)),
        ("co_kwonlyargcount", Value::Int(0)),
        ("co_nlocals", Value::Int(0)),
        ("co_flags", Value::Int(0)),
        ("co_varnames", Value::tuple(Vec::new())),
        ("co_cellvars", Value::tuple(Vec::new())),
        ("co_freevars", Value::tuple(Vec::new())),
    ];
    let code = CompiledSource {
        text,
        file_name,
        is_expression,
    };
    let class = ev.core.types.code.clone();
    let made = Instance::new(class, InstancePayload::Object(NativeData::new(code)));
    let symbols = &ev.core.symbols;
    for (name, value) in shown {
        made.set(symbols.intern(name), value, symbols);
    }
    Ok(Value::Instance(made))
}

/// The name of a text: a path, as text or bytes.
fn file_name(ev: &Evaluator<'_>, value: &Value) -> R<String> {
    let plain = ev.unwrap_builtin(value);
    let name = match &plain {
        Value::Str(text) => ev.copy_text(text.as_str())?,
        other => match ev.bytes_like(other) {
            Some(data) => ev.decode_utf8_lossy(&data)?,
            None => match ev.special(value, ev.core.symbols.intern("__fspath__"), &mut [])? {
                Some(Value::Str(text)) => ev.copy_text(text.as_str())?,
                _ => {
                    let found = ev.core.types.name_of(value);
                    let text = format!("expected str, bytes or os.PathLike object, not {found}");
                    return Err(ev.type_error(text));
                }
            },
        },
    };
    match name.contains('\0') {
        true => Err(ev.value_error("embedded null character")),
        false => Ok(name),
    }
}

/// `FunctionType(code, globals, name, argdefs, closure)`
pub(super) fn function(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let wrong = |name: &str, wanted: &str, value: &Value| {
        let found = ev.core.types.name_of_argument(value);
        let text = format!("function() argument '{name}' must be {wanted}, not {found}");
        Err(ev.type_error(text))
    };
    let of_text = code_text(&args[0]);
    if of_text.is_none() && !matches!(args[0], Value::Code(_)) {
        return wrong("code", "code", &args[0]);
    }
    let Value::Dict(globals) = ev.unwrap_builtin(&args[1]) else {
        return wrong("globals", "dict", &args[1]);
    };
    let is_none = |value: &Value| value.if_given().is_none_or(Value::is_none);
    let name = match ev.unwrap_builtin(&args[2]) {
        Value::Str(name) => Some(name),
        _ if is_none(&args[2]) => None,
        _ => return Err(ev.type_error("arg 3 (name) must be None or string")),
    };
    let defaults = match ev.unwrap_builtin(&args[3]) {
        Value::Tuple(defaults) => Value::Tuple(defaults),
        _ if is_none(&args[3]) => Value::None,
        _ => return Err(ev.type_error("arg 4 (defaults) must be None or tuple")),
    };
    let free = match &args[0] {
        Value::Code(code) => code.free_names.len(),
        _ => 0,
    };
    let cells = match ev.unwrap_builtin(&args[4]) {
        Value::Tuple(cells) => Some(cells),
        _ if !is_none(&args[4]) => {
            return Err(ev.type_error("arg 5 (closure) must be None or tuple"));
        }
        _ if free > 0 => return Err(ev.type_error("arg 5 (closure) must be tuple")),
        _ => None,
    };
    let given = cells.as_ref().map_or(0, |cells| cells.items().len());
    if given != free {
        let name = match &args[0] {
            Value::Code(code) => code.name.clone(),
            _ => "<module>".into(),
        };
        let text = format!("{name} requires closure of length {free}, not {given}");
        return Err(ev.value_error(text));
    }
    let mut closure: Vec<Rc<CellVar>> = Vec::with_capacity(free);
    for cell in cells.iter().flat_map(|cells| cells.items()) {
        let Value::Cell(cell) = cell else {
            let found = ev.core.types.name_of(cell);
            let text = format!("arg 5 (closure) expected cell, found {found}");
            return Err(ev.type_error(text));
        };
        closure.push(cell.clone());
    }
    let code = match (&args[0], of_text) {
        (Value::Code(code), _) => ev.code_in(code, &globals)?,
        (_, Some(text)) => ev.code_of_text(text, &globals)?,
        // Only code and text got past the checks above.
        _ => return wrong("code", "code", &args[0]),
    };
    let by_name = code.params.names.len() - code.params.positional;
    let function = Rc::new(Function {
        code,
        defaults: ScriptCell::new(Rc::from([])),
        keyword_defaults: vec![Value::Unbound; by_name].into(),
        keyword_defaults_dict: ScriptCell::default(),
        annotations: ScriptCell::default(),
        closure: closure.into(),
        attrs: ScriptCell::default(),
        noted: std::cell::Cell::new(false),
        old: std::cell::Cell::new(false),
    });
    ev.core.note_function(&function);
    ev.set_function_attribute(&function, known::DEFAULTS, defaults)?;
    if let Some(name) = name {
        ev.set_function_attribute(&function, known::NAME, Value::Str(name))?;
    }
    Ok(Value::Function(function))
}

impl Evaluator<'_> {
    /// Code like this one whose global variables are those in a dictionary.
    pub fn code_in(&self, code: &Rc<Code>, globals: &Rc<Dict>) -> R<Rc<Code>> {
        if Rc::ptr_eq(&self.globals_of(code), globals) {
            return Ok(code.clone());
        }
        // What is a text's only expression may not be right as a statement, with blanks before it.
        let file = &code.file;
        let is_expression = with_parse_budget(self, |budget| {
            let parsed = elite_syntax::parser::parse_within(file, budget);
            let is_error = |finding: &elite_syntax::Diagnostic| {
                finding.severity == elite_syntax::Severity::Error
            };
            let is_wrong = parsed.diagnostics.iter().any(is_error);
            parsed.module.release(budget);
            Ok(is_wrong)
        })?;
        let whole = self.code_anew(file, is_expression, globals)?;
        match self.code_at(&whole, code)? {
            Some(found) => Ok(found),
            None => Err(self.type_error("the text of the code cannot be read again")),
        }
    }

    /// The code of a whole text for these globals.
    fn code_of_text(&self, text: &CompiledSource, globals: &Rc<Dict>) -> R<Rc<Code>> {
        let mut copy = String::new();
        self.push_text(&mut copy, &text.text)?;
        let file = source_file(self, &text.file_name, copy)?;
        self.code_anew(&file, text.is_expression, globals)
    }

    fn code_anew(
        &self,
        file: &std::sync::Arc<elite_syntax::SourceFile>,
        is_expression: bool,
        globals: &Rc<Dict>,
    ) -> R<Rc<Code>> {
        self.sweep_names_if_due()?;
        let core = &self.core;
        let mut before = HashMap::new();
        let is_main = Rc::ptr_eq(globals, &self.globals_dict());
        let namespace = match is_main {
            true => core.globals.clone(),
            false => {
                let namespace = dictionary_namespace(self, globals, &mut before)?;
                namespace.set_of_text();
                namespace
            }
        };
        let code = with_parse_budget(self, |budget| {
            let ResolvedTree { module, resolution } =
                parse_and_resolve(self, file, is_expression, budget)?;
            let code = match &module.body[..] {
                [
                    Stmt {
                        kind: StmtKind::Expr(expr),
                        ..
                    },
                ] if is_expression => {
                    crate::lower::expression(core, &namespace, file, expr, &resolution, budget)
                }
                _ => crate::lower::module(core, &namespace, file, &module, &resolution, budget),
            };
            release(module, resolution, budget);
            Ok(code)
        })?;
        let mut worked = || self.charge(VARIABLE);
        match is_main {
            true => code.refs.forget(&mut worked)?,
            false => {
                let own = namespace.own_cells();
                code.refs.check(own, &before, true, &mut worked)?;
                code.refs.set_home(globals, &mut worked)?;
                core.note_namespace(&namespace);
                core.gc_track(&Value::Dict(globals.clone()));
            }
        }
        Ok(code)
    }

    /// The code within `whole` that stands where `wanted` stands in the same text.
    fn code_at(&self, whole: &Rc<Code>, wanted: &Code) -> R<Option<Rc<Code>>> {
        let mut left = vec![whole.clone()];
        while let Some(code) = left.pop() {
            self.charge(VARIABLE)?;
            let is_it = code.span == wanted.span
                && code.qualname == wanted.qualname
                && code.free_names.len() == wanted.free_names.len();
            if is_it {
                return Ok(Some(code));
            }
            left.extend(code.refs.codes.iter().cloned());
        }
        Ok(None)
    }
}
