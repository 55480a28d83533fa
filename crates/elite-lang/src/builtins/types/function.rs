//! `property`, `staticmethod`, `classmethod`, `super`.

use std::rc::Rc;

use super::{constructor, methods, wrong_receiver};
use crate::eval::{Core, Evaluator};
use crate::value::function::Property;
use crate::value::symbol::known;
use crate::value::{R, Value};

pub(super) fn install(core: &Rc<Core>) {
    let types = &core.types;
    constructor(
        core,
        &types.property,
        "fget? fset? fdel? doc?",
        |ev, args| {
            let part = |value: &Value| value.given().cloned().unwrap_or(Value::None);
            let (get, set, delete) = (part(&args[0]), part(&args[1]), part(&args[2]));
            let doc = match args[3].given() {
                Some(doc) => doc.clone(),
                None if get.is_none() => Value::None,
                None => ev
                    .attribute_or_none(&get, known::DOC)?
                    .unwrap_or(Value::None),
            };
            Ok(Value::Property(Rc::new(Property {
                get,
                set,
                delete,
                doc,
            })))
        },
    );
    methods(
        core,
        &types.property,
        &[
            ("getter", "function /", |ev, args| {
                changed(ev, args, |property, function| property.get = function)
            }),
            ("setter", "function /", |ev, args| {
                changed(ev, args, |property, function| property.set = function)
            }),
            ("deleter", "function /", |ev, args| {
                changed(ev, args, |property, function| property.delete = function)
            }),
        ],
    );
    methods(
        core,
        &types.function,
        &[("__get__", "instance owner? /", |_, args| {
            if args[0].is_none() || args[1].is_none() {
                return Ok(args[0].clone());
            }
            let (function, receiver) = (args[0].clone(), args[1].clone());
            let method = crate::value::BoundMethod { receiver, function };
            Ok(Value::BoundMethod(Rc::new(method)))
        })],
    );
    for class in [&types.function, &types.method, &types.builtin] {
        super::raw_method(core, class, "__call__", |ev, args| {
            let (keywords, mut caller) = (args.keywords, args.caller.take());
            match args.positional.split_first_mut() {
                Some((function, rest)) => ev.call_from(function, rest, keywords, caller.as_mut()),
                None => Err(ev.type_error("__call__() needs an argument")),
            }
        });
    }
    constructor(core, &types.staticmethod, "function /", |_, args| {
        Ok(Value::StaticMethod(unwrapped(&args[0])))
    });
    constructor(core, &types.classmethod, "function /", |_, args| {
        Ok(Value::ClassMethod(unwrapped(&args[0])))
    });
    constructor(
        core,
        &types.super_,
        "type? object_or_type? /",
        |ev, args| match (args[0].given(), args[1].given()) {
            (Some(class), Some(receiver)) => ev.make_super(class, receiver),
            (Some(other), None) if !matches!(other, Value::Class(_)) => {
                ev.make_super(other, &Value::None)
            }
            _ => Err(ev.raise(
                crate::errors::ExceptionKind::RuntimeError,
                "super(): no arguments",
            )),
        },
    );
}

/// The function behind a static or class method: wrapped twice it is wrapped once, so these never nest.
fn unwrapped(function: &Value) -> Rc<Value> {
    match function {
        Value::StaticMethod(inner) | Value::ClassMethod(inner) => inner.clone(),
        plain => Rc::new(plain.clone()),
    }
}

/// A copy of a property with one part replaced.
fn changed(ev: &Evaluator<'_>, args: &mut [Value], change: impl FnOnce(&mut Property, Value)) -> R {
    let Value::Property(property) = &args[0] else {
        return Err(wrong_receiver(ev, "property", &args[0]));
    };
    let mut property = (**property).clone();
    change(&mut property, args[1].clone());
    Ok(Value::Property(Rc::new(property)))
}
