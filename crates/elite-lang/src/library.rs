//! What Python's own types, functions and modules have, asked of an interpreter: so it is what programs find.

use std::cell::RefCell;
use std::rc::Rc;

use crate::builtins::Builtin;
use crate::eval::Evaluator;
use crate::eval::coroutine::Resume;
use crate::host::{Host, ThreadId};
use crate::interpreter::{Interpreter, ResumeOutcome, ScriptThread};
use crate::limits::Limits;
use crate::native::NativeFunction;
use crate::value::{Class, Function, Value};

/// What a name of a type or a module stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum MemberKind {
    /// A function or a method.
    Function,
    /// A class.
    Class,
    /// A module.
    Module,
    /// Any other value.
    Value,
}

/// A name that a type or a module has.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct LibraryMember {
    /// The name.
    pub name: String,
    /// What the name stands for.
    pub kind: MemberKind,
    /// How it is called, where that is known: `split(sep=…, maxsplit=…)`.
    pub signature: Option<String>,
    /// What it is, where it is a number, a truth value or a short text: `3.141592653589793`.
    pub value: Option<String>,
}

/// Nothing is printed, reached or waited for.
struct NullHost;

impl Host for NullHost {
    fn print(&self, _thread: ThreadId, _text: &str) {}

    fn unix_time(&self) -> f64 {
        0.0
    }

    fn monotonic(&self) -> f64 {
        0.0
    }

    fn random_u64(&self) -> u64 {
        0
    }

    fn wake(&self, _thread: ThreadId) {}
}

/// Safepoints that loading a module may pass: the largest takes a small part of it.
const FUEL: u32 = 2_000_000;

/// The functions, types and exceptions that every program finds, in the order of their names.
pub fn builtins() -> Vec<LibraryMember> {
    let interpreter = Interpreter::new(
        Rc::new(NullHost),
        Vec::<NativeFunction>::new(),
        Limits::default(),
    );
    let names = elite_syntax::python_names::builtin_names();
    let core = interpreter.core();
    let found = names.filter_map(|name| {
        let value = core.builtins.get(core.symbols.find(name)?)?;
        Some((name.to_owned(), value))
    });
    let found: Vec<_> = found.collect();
    run_query(&interpreter, move |ev| members(ev, &found))
}

/// What values of each builtin type have, by the name of the type.
pub fn type_members() -> Vec<(String, Vec<LibraryMember>)> {
    let interpreter = Interpreter::new(
        Rc::new(NullHost),
        Vec::<NativeFunction>::new(),
        Limits::default(),
    );
    run_query(&interpreter, |ev| {
        let types = &ev.core.types;
        let exception = types.exception(crate::errors::ExceptionKind::Exception);
        let all = types.all().into_iter().chain([exception]);
        all.map(|class| (class.name().to_string(), of_class(ev, class)))
            .collect()
    })
}

/// What a module has that programs can import; None if there is none of this name.
pub fn module_members(name: &str) -> Option<Vec<LibraryMember>> {
    elite_syntax::python_names::module_names().find(|known| *known == name)?;
    let interpreter = Interpreter::new(
        Rc::new(NullHost),
        Vec::<NativeFunction>::new(),
        Limits::default(),
    );
    let name = name.to_owned();
    run_query(&interpreter, move |ev| {
        // For a dotted name the last module is asked.
        ev.import(&name).ok()?;
        let modules = ev.core.modules.borrow();
        let module = modules.iter().find(|module| *module.name == *name)?.clone();
        drop(modules);
        let entries = module.namespace.entries().into_iter();
        let entries: Vec<(String, Value)> = entries
            .map(|(symbol, value)| (ev.core.symbols.name(symbol).to_string(), value))
            .filter(|(name, _)| !name.starts_with('_'))
            .collect();
        Some(members(ev, &entries))
    })
}

/// Runs a question on a thread of the interpreter and gives back its answer.
fn run_query<T: Default + 'static>(
    interpreter: &Interpreter,
    question: impl FnOnce(&Evaluator<'_>) -> T + 'static,
) -> T {
    let answer = Rc::new(RefCell::new(T::default()));
    let put = answer.clone();
    let mut thread = ScriptThread::new(interpreter.core(), move |ev| {
        let found = question(ev);
        *put.borrow_mut() = found;
        Ok(Value::None)
    });
    let mut fuel = FUEL;
    while let ResumeOutcome::OutOfFuel = thread.resume(Resume::Continue, FUEL / 100) {
        // Reading a text gives way before its fuel is used up.
        fuel = fuel.saturating_sub(FUEL / 1000);
        if fuel == 0 {
            break;
        }
    }
    drop(thread);
    answer.take()
}

fn of_class(ev: &Evaluator<'_>, class: &Rc<Class>) -> Vec<LibraryMember> {
    let mut found: Vec<(String, Value)> = Vec::new();
    for ancestor in class.mro() {
        let attrs = ancestor.own_attrs();
        for (name, value) in attrs.iter() {
            let name = ev.core.symbols.name(name).to_string();
            if !name.starts_with('_') && !found.iter().any(|(known, _)| *known == name) {
                found.push((name, value.clone()));
            }
        }
    }
    members(ev, &found)
}

fn members(ev: &Evaluator<'_>, entries: &[(String, Value)]) -> Vec<LibraryMember> {
    let mut all: Vec<LibraryMember> = entries
        .iter()
        .map(|(name, value)| member(ev, name, value))
        .collect();
    all.sort();
    all
}

fn member(ev: &Evaluator<'_>, name: &str, value: &Value) -> LibraryMember {
    let (kind, signature) = match value {
        Value::Builtin(builtin) => (MemberKind::Function, of_builtin(ev, name, builtin)),
        Value::Function(function) => (MemberKind::Function, Some(of_function(ev, name, function))),
        Value::BoundMethod(_) => (MemberKind::Function, None),
        Value::Class(_) => (MemberKind::Class, None),
        Value::Module(_) => (MemberKind::Module, None),
        _ => (MemberKind::Value, None),
    };
    LibraryMember {
        name: name.to_owned(),
        kind,
        signature,
        value: value_text(ev, value),
    }
}

/// Most characters of a value that is shown.
const SHOWN_MAX: usize = 60;

fn value_text(ev: &Evaluator<'_>, value: &Value) -> Option<String> {
    let is_plain = matches!(value, Value::Int(_) | Value::Float(_) | Value::Bool(_));
    if !is_plain && value.as_str().is_none() {
        return None;
    }
    let text = ev.repr(value).ok()?.to_string();
    (text.chars().count() <= SHOWN_MAX).then_some(text)
}

/// Functions that look at their arguments themselves have no signature.
fn of_builtin(ev: &Evaluator<'_>, name: &str, builtin: &Builtin) -> Option<String> {
    if matches!(
        builtin.body,
        crate::builtins::BuiltinBody::Raw(_) | crate::builtins::BuiltinBody::Closure { .. }
    ) {
        return None;
    }
    let shown = builtin.signature.to_call_text(name, &ev.core.symbols);
    Some(without_receiver(&shown))
}

fn of_function(ev: &Evaluator<'_>, name: &str, function: &Function) -> String {
    let (code, params) = (&function.code, &function.code.params);
    let symbol = |index: usize| ev.core.symbols.name(params.names[index]);
    let defaults = function.defaults.get().len().min(params.positional);
    let mut parts: Vec<String> = Vec::new();
    for index in 0..params.positional {
        let is_optional = index + defaults >= params.positional;
        parts.push(format!(
            "{}{}",
            symbol(index),
            if is_optional { "=…" } else { "" }
        ));
    }
    if let Some(slot) = params.star {
        parts.push(format!("*{}", ev.core.symbols.name(code.slot_names[slot])));
    }
    for index in params.positional..params.names.len() {
        parts.push(format!("{}=…", symbol(index)));
    }
    if let Some(slot) = params.double_star {
        parts.push(format!("**{}", ev.core.symbols.name(code.slot_names[slot])));
    }
    without_receiver(&format!("{name}({})", parts.join(", ")))
}

/// What callers write: without the `self` that they do not.
fn without_receiver(shown: &str) -> String {
    shown
        .replacen("(self, ", "(", 1)
        .replacen("(self)", "()", 1)
}
