//! `staticmethod`, `classmethod`, `super`, and what scripts derive from them.
//!
//! An object of a class derived from one of them extends what `__init__` has made (`InstancePayload::Value`).

use std::rc::Rc;

use super::function::{got_nothing, names_nothing};
use super::{constructor, methods, raw_method, wrong_receiver};
use crate::builtins::Args;
use crate::errors::ExceptionKind;
use crate::eval::{Evaluator, InterpreterState};
use crate::value::function::{Super, WrappedFunction};
use crate::value::instance::InstancePayload;
use crate::value::symbol::known;
use crate::value::{Dict, R, Symbol, Value};

/// What `functools.wraps` takes over, too.
const TAKEN_OVER: &[Symbol] = &[
    known::MODULE,
    known::NAME,
    known::QUALNAME,
    known::DOC,
    known::ANNOTATIONS,
];

pub(super) fn install(core: &Rc<InterpreterState>) {
    let types = &core.types;
    constructor(core, &types.staticmethod, "function /", |_, args| {
        Ok(Value::StaticMethod(WrappedFunction::around(
            args[0].clone(),
        )))
    });
    constructor(core, &types.classmethod, "function /", |_, args| {
        Ok(Value::ClassMethod(WrappedFunction::around(args[0].clone())))
    });
    raw_method(core, &types.staticmethod, "__init__", |ev, args| {
        wrap(ev, args, "staticmethod", Value::StaticMethod)
    });
    raw_method(core, &types.classmethod, "__init__", |ev, args| {
        wrap(ev, args, "classmethod", Value::ClassMethod)
    });
    raw_method(core, &types.staticmethod, "__call__", |ev, args| {
        let (keywords, mut caller) = (args.keywords, args.caller.take());
        match args.positional.split_first_mut() {
            Some((method, rest)) => match ev.unwrap_builtin(method) {
                Value::StaticMethod(function) => {
                    ev.call_from(&function, rest, keywords, caller.as_mut())
                }
                other => Err(wrong_receiver(ev, "staticmethod", &other)),
            },
            None => Err(ev.type_error("__call__() needs an argument")),
        }
    });
    methods(
        core,
        &types.staticmethod,
        &[("__get__", "instance owner? /", |ev, args| {
            match ev.unwrap_builtin(&args[0]) {
                Value::StaticMethod(_) if is_asked_for_nothing(args) => Err(got_nothing(ev)),
                Value::StaticMethod(function) => Ok(Value::clone(&function)),
                other => Err(wrong_receiver(ev, "staticmethod", &other)),
            }
        })],
    );
    methods(
        core,
        &types.classmethod,
        &[("__get__", "instance owner? /", |ev, args| {
            match ev.unwrap_builtin(&args[0]) {
                Value::ClassMethod(_) if is_asked_for_nothing(args) => Err(got_nothing(ev)),
                Value::ClassMethod(function) => {
                    let receiver = match names_nothing(&args[2]) {
                        true => Value::Class(ev.core.types.of(&args[1]).clone()),
                        false => args[2].clone(),
                    };
                    ev.bind_to_class(&function, &receiver)
                }
                other => Err(wrong_receiver(ev, "classmethod", &other)),
            }
        })],
    );
    install_super(core);
}

fn is_asked_for_nothing(args: &[Value]) -> bool {
    args[1].is_none() && names_nothing(&args[2])
}

/// `__init__` of what wraps a function: an object of a derived class wraps it from now on, and takes over how it is
/// called.
fn wrap(
    ev: &Evaluator<'_>,
    args: &mut Args<'_>,
    class: &str,
    wrapped: fn(Rc<WrappedFunction>) -> Value,
) -> R {
    if !args.keywords.is_empty() {
        return Err(ev.type_error(format!("{class}() takes no keyword arguments")));
    }
    let [receiver, function] = &*args.positional else {
        let given = args.positional.len().saturating_sub(1);
        return Err(ev.type_error(format!("{class} expected 1 argument, got {given}")));
    };
    let Value::Instance(instance) = receiver else {
        return Ok(Value::None);
    };
    let InstancePayload::Value(held) = &instance.payload else {
        return Err(wrong_receiver(ev, class, receiver));
    };
    ev.core.note_instance(instance);
    held.put(wrapped(WrappedFunction::around(function.clone())));
    for name in TAKEN_OVER {
        if let Some(value) = ev.attribute_or_none(function, *name)? {
            instance.set(*name, value, &ev.core.symbols);
        }
    }
    Ok(Value::None)
}

impl Evaluator<'_> {
    /// The attributes of a static or class method, with what it has taken over.
    pub fn wrapped_dict(&self, wrapped: &WrappedFunction) -> R<Rc<Dict>> {
        if let Some(Value::Dict(dict)) = wrapped.attrs.get() {
            return Ok(dict);
        }
        let dict = Rc::new(Dict::new());
        for name in TAKEN_OVER {
            if let Some(value) =
                self.with_native_depth(|| self.attribute_or_none(wrapped, *name))?
            {
                dict.set_interned(self.core.symbols.to_value(*name), value);
            }
        }
        // A function that was asked may have made one.
        if let Some(Value::Dict(dict)) = wrapped.attrs.get() {
            return Ok(dict);
        }
        self.core.gc_track(&Value::Dict(dict.clone()));
        wrapped.attrs.put(Some(Value::Dict(dict.clone())));
        Ok(dict)
    }
}

fn install_super(core: &Rc<InterpreterState>) {
    let class = &core.types.super_;
    constructor(core, class, "type? object_or_type? /", |ev, args| {
        new_super(ev, args)
    });
    raw_method(core, class, "__init__", |ev, args| {
        if !args.keywords.is_empty() {
            return Err(ev.type_error("super() takes no keyword arguments"));
        }
        let Some((receiver, rest)) = args.positional.split_first() else {
            return Err(ev.type_error("descriptor '__init__' of 'super' object needs an argument"));
        };
        if rest.len() > 2 {
            let given = rest.len();
            let text = format!("super() takes at most 2 arguments ({given} given)");
            return Err(ev.type_error(text));
        }
        let Value::Instance(instance) = receiver else {
            return Ok(Value::None);
        };
        let given = |at: usize| rest.get(at).cloned().unwrap_or_default();
        let sup = new_super(ev, &[given(0), given(1)])?;
        if let InstancePayload::Value(held) = &instance.payload {
            ev.core.note_instance(instance);
            held.put(sup);
        }
        Ok(Value::None)
    });
    methods(
        core,
        class,
        &[
            ("__getattribute__", "name /", |ev, args| {
                let Value::Str(text) = &args[1] else {
                    let found = ev.core.types.name_of(&args[1]);
                    let text = format!("attribute name must be string, not '{found}'");
                    return Err(ev.type_error(text));
                };
                let name = ev.temp_symbol(text.as_str())?;
                let found = match &args[0] {
                    Value::Instance(instance) => {
                        let behind = match receiver(ev, &args[0])? {
                            sup if *name != known::CLASS => ev.super_attribute(&sup, *name)?,
                            _ => None,
                        };
                        match behind {
                            None => ev.plain_instance_attribute(&args[0], instance, *name)?,
                            found => found,
                        }
                    }
                    other => ev.find_attribute(other, *name)?,
                };
                found.ok_or_else(|| ev.attribute_error(&args[0], *name))
            }),
            ("__get__", "instance owner? /", |ev, args| {
                let sup = receiver(ev, &args[0])?;
                if args[1].is_none() || !sup.receiver.is_unbound() {
                    return Ok(args[0].clone());
                }
                let class = Value::Class(sup.class.clone());
                match &args[0] {
                    Value::Instance(own) => {
                        let own = Value::Class(own.class.clone());
                        ev.call(&own, &mut [class, args[1].clone()], &[])
                    }
                    _ => ev.make_super(&class, &args[1]),
                }
            }),
        ],
    );
}

/// A `super` of the arguments `type`, `object_or_type`.
fn new_super(ev: &Evaluator<'_>, args: &[Value]) -> R {
    match args[0].if_given() {
        Some(class) => {
            // None as the receiver counts as not given: nothing is looked up yet.
            let receiver = match &args[1] {
                Value::None => &Value::Unbound,
                other => other,
            };
            ev.make_super(class, receiver)
        }
        None => Err(ev.raise(ExceptionKind::RuntimeError, "super(): no arguments")),
    }
}

fn receiver(ev: &Evaluator<'_>, value: &Value) -> R<Rc<Super>> {
    match ev.unwrap_builtin(value) {
        Value::Super(sup) => Ok(sup),
        other => Err(wrong_receiver(ev, "super", &other)),
    }
}
