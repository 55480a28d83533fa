//! Methods of exceptions.

use std::rc::Rc;

use super::methods;
use crate::builtins::BoundFn;
use crate::errors::ExceptionKind;
use crate::eval::{Evaluator, InterpreterState};
use crate::value::symbol::known;
use crate::value::{R, Value};

pub(super) fn install(core: &Rc<InterpreterState>) {
    let base = core.types.exception(ExceptionKind::BaseException);
    methods(
        core,
        base,
        &[
            ("with_traceback", "tb /", |ev, args| {
                let is_traceback = match &args[1] {
                    Value::None => true,
                    other => Rc::ptr_eq(ev.core.types.of(other), &ev.core.types.traceback),
                };
                if !is_traceback {
                    return Err(ev.type_error("__traceback__ must be a traceback or None"));
                }
                Ok(args[0].clone())
            }),
            ("__reduce__", "", |ev, args| {
                let class = Value::Class(ev.core.types.of(&args[0]).clone());
                let given = ev.attribute(&args[0], known::ARGS)?;
                match ev.attribute_or_none(&args[0], known::DICT)? {
                    Some(Value::Dict(dict)) if !dict.is_empty() => {
                        Ok(Value::triple([class, given, Value::Dict(dict)]))
                    }
                    _ => Ok(Value::pair(class, given)),
                }
            }),
            ("add_note", "note /", add_note),
            ("__repr__", "", |ev, args| {
                ev.new_str(ev.natural_repr(&args[0])?)
            }),
            ("__str__", "", |ev, args| {
                let Some(state) = exception(&args[0]) else {
                    return Err(super::wrong_receiver(ev, "BaseException", &args[0]));
                };
                match &state.args() {
                    Value::Tuple(items) => match items.items() {
                        [] => ev.new_str(String::new()),
                        [single] => ev.str_value(single),
                        _ => ev.str_value(&state.args()),
                    },
                    other => ev.str_value(other),
                }
            }),
        ],
    );
    let init: BoundFn = |ev, args| {
        if let Some(state) = exception(&args[0]) {
            state.set_args(args[1].clone());
            return Ok(Value::None);
        }
        Err(super::wrong_receiver(ev, "BaseException", &args[0]))
    };
    // CPython gives each class an `__init__` of its own, but for the one that is made of two others.
    for kind in ExceptionKind::ALL {
        if *kind != ExceptionKind::ExceptionGroup {
            methods(
                core,
                core.types.exception(*kind),
                &[("__init__", "*args", init)],
            );
        }
    }
    // The exceptions of the list say more than their arguments, or have at least a method of their own for it.
    for kind in [
        ExceptionKind::AttributeError,
        ExceptionKind::BaseExceptionGroup,
        ExceptionKind::ImportError,
        ExceptionKind::KeyError,
        ExceptionKind::NameError,
        ExceptionKind::OSError,
        ExceptionKind::SyntaxError,
        ExceptionKind::UnicodeDecodeError,
        ExceptionKind::UnicodeEncodeError,
        ExceptionKind::UnicodeTranslateError,
    ] {
        let text: BoundFn = |ev, args| ev.new_str(ev.natural_str(&args[0])?);
        methods(core, core.types.exception(kind), &[("__str__", "", text)]);
    }
}

fn exception(value: &Value) -> Option<&crate::value::exception::ExceptionState> {
    match value {
        Value::Instance(instance) => instance.exception(),
        _ => None,
    }
}

fn add_note(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    if !matches!(args[1], Value::Str(_)) {
        let name = ev.core.types.name_of(&args[1]);
        return Err(ev.type_error(format!("note must be a str, not '{name}'")));
    }
    let notes = match ev.attribute_or_none(&args[0], known::NOTES)? {
        Some(notes) => notes,
        None => {
            let notes = Value::list(Vec::new());
            ev.set_attribute(&args[0], known::NOTES, notes.clone())?;
            notes
        }
    };
    if let Value::List(list) = notes {
        list.push(args[1].clone());
    }
    Ok(Value::None)
}
