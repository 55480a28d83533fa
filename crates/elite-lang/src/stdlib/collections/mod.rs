//! `_collections`: the containers of `collections` that programs use by the thousand.
//!
//! Owns the double-ended queue, the dictionaries with a manner of their own (ordered, with defaults, counting) and
//! tuples with names. The wrappers and the views over several mappings are scripts (`lib/collections.py`).

mod counter;
pub(crate) mod deque;
mod maps;
mod named;

pub(super) use named::missing_arguments;

use std::rc::Rc;

use super::define::ModuleBuilder;
use crate::builtins::{Builtin, BuiltinBody};
use crate::eval::Evaluator;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::instance::InstancePayload;
use crate::value::symbol::known;
use crate::value::{Class, Dict, Instance, R, ScriptCell, Symbol, Value};

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    deque::fill(module)?;
    maps::fill(module)?;
    counter::fill(module)?;
    named::fill(module)
}

/// A dictionary of one of these classes, as its methods see it.
struct DictReceiver<'v> {
    receiver: &'v Value,
    class: Rc<Class>,
    dict: Rc<Dict>,
    /// Values are put in by the builtin dictionary's own `__setitem__`; otherwise by that of a script.
    plain: bool,
}

impl<'v> DictReceiver<'v> {
    fn of(ev: &Evaluator<'_>, receiver: &'v Value) -> R<Self> {
        let (Value::Instance(instance), Value::Dict(dict)) =
            (receiver, ev.unwrap_builtin(receiver))
        else {
            let name = ev.core.types.name_of(receiver);
            return Err(ev.type_error(format!(
                "descriptor requires a 'dict' subclass but received a '{name}'"
            )));
        };
        Ok(DictReceiver {
            receiver,
            class: instance.class.clone(),
            dict,
            plain: is_builtin(&instance.class, known::SETITEM),
        })
    }

    /// `self[key] = to_value`
    fn set(&self, ev: &Evaluator<'_>, key: Value, value: Value) -> R<()> {
        if self.plain {
            if key.can_hold_values() || value.can_hold_values() {
                ev.core.gc_track(self.receiver);
            }
            return ev.dict_set(&self.dict, key, value);
        }
        ev.set_item(self.receiver, &key, value)
    }

    /// What `update` takes: a mapping or pairs.
    fn update(&self, ev: &Evaluator<'_>, source: &Value) -> R<()> {
        ev.core.gc_track(self.receiver);
        if self.plain {
            return ev.dict_update_from(&self.dict, source);
        }
        let taken = Dict::new();
        ev.dict_update_from(&taken, source)?;
        for (_, key, value) in ev.collect_entries(&taken)? {
            ev.charge(2 * WORK_PER_VALUE)?;
            self.set(ev, key, value)?;
        }
        Ok(())
    }

    /// Named values.
    fn update_named(&self, ev: &Evaluator<'_>, keywords: &[(Symbol, Value)]) -> R<()> {
        for (name, value) in keywords {
            self.set(ev, ev.core.symbols.to_value(*name), value.clone())?;
        }
        Ok(())
    }

    /// `type(self).__name__`
    fn name(&self) -> Rc<str> {
        self.class.name()
    }
}

/// Whether instances of the class do `name` as the interpreter does.
fn is_builtin(class: &Class, name: Symbol) -> bool {
    matches!(class.lookup(name), Some(Value::Builtin(_)))
}

/// An instance of `class` around a dictionary.
fn new_instance(class: &Rc<Class>, dict: Dict) -> Value {
    let payload = InstancePayload::Value(ScriptCell::new(Value::Dict(Rc::new(dict))));
    Value::Instance(Instance::new(class.clone(), payload))
}

/// Whether a value is an instance of `class` or of one derived from it.
fn is_a(value: &Value, class: &Class) -> bool {
    matches!(value, Value::Instance(instance) if instance.class.is_subclass_of(class))
}

/// Calls a class of a script or of this module.
fn call_class(ev: &Evaluator<'_>, class: &Rc<Class>, args: &mut [Value]) -> R {
    ev.call(&Value::Class(class.clone()), args, &[])
}

/// A method with values of its own.
fn method_with(
    owner: &'static str,
    name: &'static str,
    held: Vec<Value>,
    body: impl Fn(&Evaluator<'_>, &[Value], &mut crate::builtins::Args<'_>) -> R + Send + 'static,
) -> Value {
    Value::Builtin(Rc::new(Builtin {
        name,
        owner: Some(owner),
        module: None,
        signature: crate::builtins::Signature::default(),
        body: BuiltinBody::Closure {
            held,
            body: Box::new(body),
        },
        stores_args: false,
        fast_path: None,
        sequence_op: None,
        is_slot: false,
    }))
}
