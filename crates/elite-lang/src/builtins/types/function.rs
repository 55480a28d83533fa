//! `property`, and methods of functions.

use std::rc::Rc;

use super::{constructor, methods, wrappers, wrong_receiver};
use crate::errors::ExceptionKind;
use crate::eval::{Evaluator, InterpreterState};
use crate::value::function::Property;
use crate::value::instance::InstancePayload;
use crate::value::symbol::known;
use crate::value::{R, ScriptCell, Unwind, Value};

pub(super) fn install(core: &Rc<InterpreterState>) {
    let types = &core.types;
    constructor(
        core,
        &types.property,
        "fget? fset? fdel? doc?",
        |ev, args| new_property(ev, args).map(|property| Value::Property(Rc::new(property))),
    );
    methods(
        core,
        &types.property,
        &[
            ("__init__", "fget? fset? fdel? doc?", |ev, args| {
                let property = new_property(ev, &args[1..])?;
                let Value::Instance(instance) = &args[0] else {
                    return Err(wrong_receiver(ev, "property", &args[0]));
                };
                // In classes derived from it the documentation is an attribute like others.
                let doc = property.doc.get();
                if let InstancePayload::Value(held) = &instance.payload {
                    ev.core.note_instance(instance);
                    held.put(Value::Property(Rc::new(property)));
                }
                instance.set(known::DOC, doc, &ev.core.symbols);
                Ok(Value::None)
            }),
            ("getter", "function /", |ev, args| {
                with_part(ev, args, |parts, function| parts[0] = function)
            }),
            ("setter", "function /", |ev, args| {
                with_part(ev, args, |parts, function| parts[1] = function)
            }),
            ("deleter", "function /", |ev, args| {
                with_part(ev, args, |parts, function| parts[2] = function)
            }),
            ("__get__", "instance owner? /", |ev, args| {
                let property = property(ev, &args[0])?;
                match &args[1] {
                    Value::None if names_nothing(&args[2]) => Err(got_nothing(ev)),
                    Value::None => Ok(args[0].clone()),
                    _ if property.get.is_none() => {
                        Err(missing_accessor_error(ev, &property, &args[1], "getter"))
                    }
                    instance => ev.call1(&property.get, instance.clone()),
                }
            }),
            ("__set__", "instance value /", |ev, args| {
                let property = property(ev, &args[0])?;
                if property.set.is_none() {
                    return Err(missing_accessor_error(ev, &property, &args[1], "setter"));
                }
                let mut given = [args[1].clone(), args[2].clone()];
                ev.call(&property.set, &mut given, &[])?;
                Ok(Value::None)
            }),
            ("__delete__", "instance /", |ev, args| {
                let property = property(ev, &args[0])?;
                if property.delete.is_none() {
                    return Err(missing_accessor_error(ev, &property, &args[1], "deleter"));
                }
                ev.call1(&property.delete, args[1].clone())?;
                Ok(Value::None)
            }),
            ("__set_name__", "owner name /", |ev, args| {
                property(ev, &args[0])?.name.put(args[2].clone());
                Ok(Value::None)
            }),
        ],
    );
    methods(
        core,
        &types.function,
        &[("__get__", "instance owner? /", |ev, args| {
            if args[1].is_none() {
                if names_nothing(&args[2]) {
                    return Err(got_nothing(ev));
                }
                return Ok(args[0].clone());
            }
            let (function, receiver) = (args[0].clone(), args[1].clone());
            let method = crate::value::BoundMethod { receiver, function };
            Ok(Value::BoundMethod(Rc::new(method)))
        })],
    );
    for class in [&types.method_descriptor, &types.wrapper_descriptor] {
        methods(
            core,
            class,
            &[("__get__", "instance owner? /", |ev, args| {
                let Value::Builtin(builtin) = &args[0] else {
                    return Err(wrong_receiver(ev, "method_descriptor", &args[0]));
                };
                if args[1].is_none() {
                    return match names_nothing(&args[2]) {
                        true => Err(got_nothing(ev)),
                        false => Ok(args[0].clone()),
                    };
                }
                ev.check_descriptor_receiver(builtin, &args[1])?;
                let (function, receiver) = (args[0].clone(), args[1].clone());
                let method = crate::value::BoundMethod { receiver, function };
                Ok(Value::BoundMethod(Rc::new(method)))
            })],
        );
    }
    constructor(
        core,
        &types.function,
        "code globals name? argdefs? closure?",
        crate::builtins::compile::function,
    );
    for class in [
        &types.function,
        &types.method,
        &types.builtin,
        &types.method_descriptor,
        &types.wrapper_descriptor,
        &types.method_wrapper,
    ] {
        super::raw_method(core, class, "__call__", |ev, args| {
            let (keywords, mut caller) = (args.keywords, args.caller.take());
            match args.positional.split_first_mut() {
                Some((function, rest)) => ev.call_from(function, rest, keywords, caller.as_mut()),
                None => Err(ev.type_error("__call__() needs an argument")),
            }
        });
    }
    wrappers::install(core);
}

/// Whether an owner that may be left out is none.
pub(super) fn names_nothing(owner: &Value) -> bool {
    owner.if_given().is_none_or(Value::is_none)
}

/// `__get__` of neither an object nor a class.
#[cold]
pub(super) fn got_nothing(ev: &Evaluator<'_>) -> crate::value::Unwind {
    ev.type_error("__get__(None, None) is invalid")
}

/// A property of the arguments `fget`, `fset`, `fdel`, `doc`.
fn new_property(ev: &Evaluator<'_>, args: &[Value]) -> R<Property> {
    let part = |value: &Value| value.if_given().cloned().unwrap_or(Value::None);
    let (get, set, delete) = (part(&args[0]), part(&args[1]), part(&args[2]));
    let given = args[3].if_given().filter(|doc| !doc.is_none());
    let doc = match given {
        Some(doc) => doc.clone(),
        None if get.is_none() => Value::None,
        None => ev
            .attribute_or_none(&get, known::DOC)?
            .unwrap_or(Value::None),
    };
    Ok(Property {
        get,
        set,
        delete,
        is_getters_doc: given.is_none() && !doc.is_none(),
        doc: ScriptCell::new(doc),
        name: ScriptCell::default(),
    })
}

fn property(ev: &Evaluator<'_>, value: &Value) -> R<Rc<Property>> {
    match ev.unwrap_builtin(value) {
        Value::Property(property) => Ok(property),
        _ => Err(wrong_receiver(ev, "property", value)),
    }
}

/// The error for a property that has no getter, setter or deleter.
#[cold]
fn missing_accessor_error(
    ev: &Evaluator<'_>,
    property: &Property,
    instance: &Value,
    part: &str,
) -> Unwind {
    let class = ev.qualname_of(ev.core.types.of(instance));
    let message = match &*property.name.borrow() {
        Value::Str(name) => {
            format!(
                "property '{}' of '{class}' object has no {part}",
                name.as_str()
            )
        }
        _ => format!("property of '{class}' object has no {part}"),
    };
    ev.raise(ExceptionKind::AttributeError, message)
}

/// A property like this one with one part replaced, of the same class. Documentation that is the getter's goes with it.
fn with_part(
    ev: &Evaluator<'_>,
    args: &mut [Value],
    change: impl FnOnce(&mut [Value; 4], Value),
) -> R {
    let old = property(ev, &args[0])?;
    let doc = match old.is_getters_doc && !old.get.is_none() {
        true => Value::None,
        false => old.doc.get(),
    };
    let mut parts = [old.get.clone(), old.set.clone(), old.delete.clone(), doc];
    change(&mut parts, args[1].clone());
    let class = Value::Class(ev.core.types.of(&args[0]).clone());
    let new = ev.call(&class, &mut parts, &[])?;
    if let Ok(new) = property(ev, &new) {
        new.name.put(old.name.get());
    }
    Ok(new)
}
