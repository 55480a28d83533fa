//! `__reduce__`, `__reduce_ex__` and `__getnewargs__`: from what an object is made anew.
//!
//! The first two are methods of `object`, as in CPython; what they give is a function, its arguments and what is to be
//! put into the new object then. Nothing here packs objects into bytes: scripts ask for it, and `copy` where a class
//! says something of its own.

use std::rc::Rc;

use super::{methods, raw_method};
use crate::builtins::{Args, BoundFn, Builtin};
use crate::errors::ExceptionKind;
use crate::eval::{Evaluator, InterpreterState};
use crate::value::bytes::BytesRef;
use crate::value::symbol::known;
use crate::value::{Bytes, Class, R, Unwind, Value, ValueVec};

const REDUCE: &str = "__reduce__";

pub(super) fn install(core: &Rc<InterpreterState>) {
    let types = &core.types;
    methods(
        core,
        &types.natural,
        &[
            (REDUCE, "", |ev, args| from_builtin(ev, &args[0])),
            ("__reduce_ex__", "protocol /", |ev, args| {
                let protocol = ev.clamped_index(&args[1])?;
                let own = ev.core.types.of(&args[0]);
                match own.lookup(ev.core.symbols.intern(REDUCE)) {
                    Some(method) => ev.call_method_value(&method, &args[0], &mut []),
                    None if protocol < 2 => from_builtin(ev, &args[0]),
                    None => from_class(ev, &args[0]),
                }
            }),
        ],
    );
    let arguments: BoundFn = |ev, args| {
        Ok(Value::tuple(match ev.unwrap_builtin(&args[0]) {
            Value::Complex(complex) => vec![Value::Float(complex.0), Value::Float(complex.1)],
            Value::Bool(flag) => vec![Value::Int(i64::from(flag))],
            plain => vec![plain],
        }))
    };
    for class in [
        &types.int,
        &types.float,
        &types.complex,
        &types.str,
        &types.bytes,
        &types.tuple,
    ] {
        methods(core, class, &[("__getnewargs__", "", arguments)]);
    }
    let items: BoundFn = |ev, args| {
        // A class derived from it may have an iterator of its own.
        let iterator = ev.iter(&args[0])?;
        ev.ask_length(&args[0])?;
        let items = ev.drain(&iterator)?.into_list();
        with_state(ev, &args[0], vec![items])
    };
    methods(core, &types.set, &[(REDUCE, "", items)]);
    methods(core, &types.frozenset, &[(REDUCE, "", items)]);
    methods(
        core,
        &types.bytearray,
        &[
            (REDUCE, "", |ev, args| {
                let text = text_of_bytes(ev, &args[0])?;
                with_state(ev, &args[0], text)
            }),
            ("__reduce_ex__", "protocol? /", |ev, args| {
                let protocol = args[1]
                    .if_given()
                    .map_or(Ok(0), |given| ev.clamped_index(given))?;
                if protocol < 3 || content(ev, &args[0])?.is_empty() {
                    let text = text_of_bytes(ev, &args[0])?;
                    return with_state(ev, &args[0], text);
                }
                let data = ev.copy_bytes(&content(ev, &args[0])?)?;
                let data = Value::Bytes(Rc::new(Bytes::new(data)));
                with_state(ev, &args[0], vec![data])
            }),
        ],
    );
    let parts: BoundFn = |ev, args| {
        let part = |name: &str| ev.attribute(&args[0], ev.core.symbols.intern(name));
        let parts = vec![part("start")?, part("stop")?, part("step")?];
        let class = Value::Class(ev.core.types.of(&args[0]).clone());
        Ok(Value::pair(class, Value::tuple(parts)))
    };
    methods(core, &types.range, &[(REDUCE, "", parts)]);
    methods(core, &types.slice, &[(REDUCE, "", parts)]);
    let base = types.exception(ExceptionKind::BaseException);
    raw_method(core, base, "__setstate__", set_state);
}

/// `__setstate__` of exceptions: attributes by name.
fn set_state(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let [exception, state] = &*args.positional else {
        let given = args.positional.len().saturating_sub(1);
        return Err(ev.type_error(format!(
            "BaseException.__setstate__() takes exactly one argument ({given} given)"
        )));
    };
    match ev.unwrap_builtin(state) {
        Value::None => {}
        Value::Dict(dict) => {
            for (_, key, value) in ev.collect_entries(&dict)? {
                let Value::Str(name) = ev.unwrap_builtin(&key) else {
                    let name = ev.core.types.name_of(&key);
                    let text = format!("attribute name must be string, not '{name}'");
                    return Err(ev.type_error(text));
                };
                ev.set_attribute(exception, ev.intern_name(name.as_str())?, value)?;
            }
        }
        _ => return Err(ev.type_error("state is not a dictionary")),
    }
    Ok(Value::None)
}

fn content(ev: &Evaluator<'_>, value: &Value) -> R<BytesRef> {
    ev.bytes_like(value)
        .ok_or_else(|| super::wrong_receiver(ev, "bytearray", value))
}

/// The arguments that a `bytearray` is made anew from by the protocols that know no bytes.
fn text_of_bytes(ev: &Evaluator<'_>, value: &Value) -> R<Vec<Value>> {
    let data = content(ev, value)?;
    if data.is_empty() {
        return Ok(Vec::new());
    }
    let text = ev.new_str(ev.decode_latin1(&data)?)?;
    Ok(vec![text, Value::str("latin-1")])
}

fn with_state(ev: &Evaluator<'_>, value: &Value, args: Vec<Value>) -> R {
    let class = Value::Class(ev.core.types.of(value).clone());
    let state = state(ev, value)?;
    Ok(Value::triple([class, Value::tuple(args), state]))
}

fn state(ev: &Evaluator<'_>, value: &Value) -> R {
    let get = ev.attribute(value, ev.core.symbols.intern("__getstate__"))?;
    ev.call(&get, &mut [], &[])
}

/// The nearest class that no script has made.
fn builtin_base(class: &Rc<Class>) -> Option<Rc<Class>> {
    class.mro().into_iter().find(|class| !class.is_script)
}

#[cold]
fn refusal(ev: &Evaluator<'_>, class: &Class) -> Unwind {
    ev.type_error(format!("cannot pickle '{}' object", class.type_name()))
}

/// The first two protocols: from what the builtin type that it extends makes of it.
fn from_builtin(ev: &Evaluator<'_>, value: &Value) -> R {
    let class = ev.core.types.of(value).clone();
    let Some(base) = builtin_base(&class) else {
        return Err(refusal(ev, &class));
    };
    let extended = if Rc::ptr_eq(&base, &ev.core.types.object) {
        Value::None
    } else if Rc::ptr_eq(&base, &class) {
        return Err(refusal(ev, &class));
    } else {
        ev.call1(&Value::Class(base.clone()), value.clone())?
    };
    if class.has_own_slots() && !class.has_dict() {
        let text = "a class that defines __slots__ without defining __getstate__ cannot be pickled";
        return Err(ev.type_error(text));
    }
    let function = Builtin::raw("_reconstructor", reconstruct);
    let args = Value::triple([Value::Class(class), Value::Class(base), extended]);
    Ok(match state(ev, value)? {
        state if ev.truth(&state)? => Value::triple([function, args, state]),
        _ => Value::pair(function, args),
    })
}

/// The later protocols: from `__new__` of the class, with what the object says are its arguments.
fn from_class(ev: &Evaluator<'_>, value: &Value) -> R {
    let class = ev.core.types.of(value).clone();
    let is_made_anew = match ev.unwrap_builtin(value) {
        Value::Instance(_) => {
            builtin_base(&class).is_some_and(|base| Rc::ptr_eq(&base, &ev.core.types.object))
        }
        Value::Int(_)
        | Value::BigInt(_)
        | Value::Bool(_)
        | Value::Float(_)
        | Value::Complex(_)
        | Value::Str(_)
        | Value::Bytes(_)
        | Value::Tuple(_)
        | Value::List(_)
        | Value::Dict(_)
        | Value::None => true,
        _ => false,
    };
    if !is_made_anew {
        return Err(refusal(ev, &class));
    }
    let mut args = ValueVec::from(vec![Value::Class(class.clone())]);
    if let Some(method) = class.lookup(ev.core.symbols.intern("__getnewargs__")) {
        let given = ev.call_method_value(&method, value, &mut [])?;
        let Value::Tuple(given) = ev.unwrap_builtin(&given) else {
            let name = ev.core.types.name_of(&given);
            let text = format!("__getnewargs__ should return a tuple, not '{name}'");
            return Err(ev.type_error(text));
        };
        args = ValueVec::from(ev.try_with_capacity(given.items().len() + 1)?);
        args.push(Value::Class(class));
        ev.copy_values(given.items(), &mut args)?;
    }
    let (mut items, mut pairs) = (Value::None, Value::None);
    match ev.unwrap_builtin(value) {
        Value::List(_) => items = ev.iter(value)?,
        Value::Dict(_) => {
            let all = ev.attribute(value, ev.core.symbols.intern("items"))?;
            pairs = ev.iter(&ev.call(&all, &mut [], &[])?)?;
        }
        _ => {}
    }
    Ok(Value::tuple(vec![
        Builtin::raw("__newobj__", new_object),
        args.into_tuple(),
        state(ev, value)?,
        items,
        pairs,
    ]))
}

/// `cls.__new__(cls, *args)`
fn new_object(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let Some(class) = args.positional.first().cloned() else {
        return Err(ev.type_error("__newobj__() missing 1 required positional argument: 'cls'"));
    };
    let new = ev.attribute(&class, known::NEW)?;
    ev.call(&new, args.positional, args.keywords)
}

/// An object of a class from the builtin value that it extends.
fn reconstruct(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let [class, base, extended] = &*args.positional else {
        return Err(ev.type_error("_reconstructor() takes a class, its builtin base and a value"));
    };
    let new = ev.attribute(base, known::NEW)?;
    let plain = Value::Class(ev.core.types.object.clone());
    if base.is(&plain) {
        return ev.call(&new, &mut [class.clone()], &[]);
    }
    let made = ev.call(&new, &mut [class.clone(), extended.clone()], &[])?;
    if let Value::Class(base) = base
        && let Some(init) = base.lookup(known::INIT)
    {
        ev.call_method_value(&init, &made, &mut [extended.clone()])?;
    }
    Ok(made)
}
