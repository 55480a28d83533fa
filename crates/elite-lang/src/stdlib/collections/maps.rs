//! `OrderedDict` and `defaultdict`.

use std::rc::Rc;

use elite_syntax::ast::CompareOp;

use super::{DictReceiver, call_class, is_a, new_instance};
use crate::builtins::Args;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::stdlib::define::{MethodDef, ModuleBuilder, native_class};
use crate::value::{Class, R, Value, ValueVec};

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    let dict = &module.core().types.dict.clone();
    let ordered = module.derived_class("OrderedDict", dict, ORDERED)?;
    for (name, body) in [
        ("__init__", ordered_init as crate::builtins::RawFn),
        ("update", ordered_update),
    ] {
        module.raw_method(&ordered, "OrderedDict", name, body);
    }
    module.class_method(&ordered, "fromkeys", "iterable value?", from_keys);
    let defaulting = module.derived_class("defaultdict", dict, DEFAULTING)?;
    let symbols = &module.core().symbols;
    let slot = symbols.intern("default_factory");
    symbols.mark_used(slot);
    let names = Value::tuple(vec![symbols.to_value(slot)]);
    defaulting.set(symbols.intern("__slots__"), names);
    defaulting.set_slots(&[slot]);
    for class in [&ordered, &defaulting] {
        class.is_c_type.set(true);
    }
    module.raw_method(&defaulting, "defaultdict", "__init__", default_init);
    Ok(())
}

// The ordered dictionary.

const ORDERED: &[MethodDef] = &[
    ("popitem", "last?", |ev, args| {
        let own = DictReceiver::of(ev, &args[0])?;
        let last = args[1].if_given().map_or(Ok(true), |last| ev.truth(last))?;
        let found = match last {
            true => ev.previous_entry(&own.dict, usize::MAX)?.map(|(at, ..)| at),
            // Where the oldest entry is.
            false => ev.next_entry(&own.dict, 0)?.map(|(after, ..)| after - 1),
        };
        let Some(at) = found else {
            let text = vec![Value::str("dictionary is empty")];
            return Err(ev.raise_args(ExceptionKind::KeyError, text));
        };
        let (key, value) = own.dict.delete_at(at);
        Ok(Value::pair(key, value))
    }),
    ("move_to_end", "key last?", |ev, args| {
        let own = DictReceiver::of(ev, &args[0])?;
        let last = args[2].if_given().map_or(Ok(true), |last| ev.truth(last))?;
        let hash = ev.hash(&args[1])?;
        let Some(at) = ev.dict_find_hashed(&own.dict, hash, &args[1])? else {
            return Err(ev.key_error(&args[1]));
        };
        if last {
            let (key, value) = own.dict.delete_at(at);
            ev.dict_set_hashed(&own.dict, hash, key, value)?;
        } else {
            ev.dict_move_to_front(&own.dict, hash, &args[1], at)?;
        }
        Ok(Value::None)
    }),
    ("copy", "", copy_ordered),
    ("__copy__", "", copy_ordered),
    ("__eq__", "other /", |ev, args| {
        Ok(ordered_eq(ev, &args[0], &args[1])?.map_or(Value::NotImplemented, Value::Bool))
    }),
    ("__ne__", "other /", |ev, args| {
        let same = ordered_eq(ev, &args[0], &args[1])?;
        Ok(same.map_or(Value::NotImplemented, |same| Value::Bool(!same)))
    }),
    ("__or__", "other /", |ev, args| {
        let (class, first, second) = (class_of(&args[0]), args[0].clone(), args[1].clone());
        union_as(ev, class, first, second)
    }),
    ("__ror__", "other /", |ev, args| {
        let (class, first, second) = (class_of(&args[0]), args[1].clone(), args[0].clone());
        union_as(ev, class, first, second)
    }),
    ("__ior__", "other /", |ev, args| {
        DictReceiver::of(ev, &args[0])?.update(ev, &args[1])?;
        Ok(args[0].clone())
    }),
    ("__repr__", "", |ev, args| {
        let own = DictReceiver::of(ev, &args[0])?;
        let name = own.name();
        if own.dict.is_empty() {
            return Ok(Value::str(format!("{name}()")));
        }
        let mut items = ValueVec::from(ev.try_with_capacity(own.dict.len())?);
        for (_, key, value) in ev.collect_entries(&own.dict)? {
            items.push(Value::pair(key, value));
            ev.charge(4 * WORK_PER_VALUE)?;
        }
        let items = ev.repr(&items.into_list())?;
        Ok(Value::str(format!("{name}({items})")))
    }),
];

fn ordered_init(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    take_in(ev, args, |count| {
        format!("expected at most 1 arguments, got {count}")
    })
}

fn ordered_update(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    take_in(ev, args, |count| {
        format!("update() takes at most 1 positional argument ({count} given)")
    })
}

fn take_in(ev: &Evaluator<'_>, args: &mut Args<'_>, refusal: fn(usize) -> String) -> R {
    let Some((receiver, rest)) = args.positional.split_first() else {
        return Err(ev.type_error("a method of 'OrderedDict' needs an argument"));
    };
    let own = DictReceiver::of(ev, receiver)?;
    if rest.len() > 1 {
        return Err(ev.type_error(refusal(rest.len())));
    }
    if let Some(source) = rest.first() {
        own.update(ev, source)?;
    }
    own.update_named(ev, args.keywords)?;
    Ok(Value::None)
}

fn from_keys(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let filled = ev.call(&args[0], &mut [], &[])?;
    let value = args[2].if_given().cloned().unwrap_or(Value::None);
    let keys = ev.iter(&args[1])?;
    while let Some(key) = ev.next_at_safepoint(&keys)? {
        ev.set_item(&filled, &key, value.clone())?;
    }
    Ok(filled)
}

/// A new one of the same class, made without arguments and filled entry by entry.
fn copy_ordered(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let own = DictReceiver::of(ev, &args[0])?;
    let copy = call_class(ev, &own.class, &mut [])?;
    if let Ok(copied) = DictReceiver::of(ev, &copy) {
        copied.update(ev, &Value::Dict(own.dict))?;
        return Ok(copy);
    }
    for (_, key, value) in ev.collect_entries(&own.dict)? {
        ev.safepoint()?;
        ev.set_item(&copy, &key, value)?;
    }
    Ok(copy)
}

/// Whether two dictionaries are equal, between two ordered ones also in their order; None if one is no dictionary.
fn ordered_eq(ev: &Evaluator<'_>, receiver: &Value, other: &Value) -> R<Option<bool>> {
    let own = DictReceiver::of(ev, receiver)?;
    let Value::Dict(others) = ev.unwrap_builtin(other) else {
        return Ok(None);
    };
    let (one, two) = (Value::Dict(own.dict.clone()), Value::Dict(others.clone()));
    if !ev.compare_truth(CompareOp::Eq, &one, &two)? {
        return Ok(Some(false));
    }
    if !is_a(other, &*native_class(ev, "_collections.OrderedDict")?) {
        return Ok(Some(true));
    }
    let (one, two) = (ev.collect_entries(&own.dict)?, ev.collect_entries(&others)?);
    for ((_, one, _), (_, two, _)) in one.iter().zip(&two) {
        ev.charge(WORK_PER_VALUE)?;
        if !ev.equal(one, two)? {
            return Ok(Some(false));
        }
    }
    Ok(Some(true))
}

fn class_of(receiver: &Value) -> Option<Rc<Class>> {
    match receiver {
        Value::Instance(instance) => Some(instance.class.clone()),
        _ => None,
    }
}

/// `first | second` as a `class`.
fn union_as(ev: &Evaluator<'_>, class: Option<Rc<Class>>, first: Value, second: Value) -> R {
    let are_dicts = [&first, &second]
        .iter()
        .all(|value| matches!(ev.unwrap_builtin(value), Value::Dict(_)));
    let (Some(class), true) = (class, are_dicts) else {
        return Ok(Value::NotImplemented);
    };
    let joined = call_class(ev, &class, &mut [first])?;
    DictReceiver::of(ev, &joined)?.update(ev, &second)?;
    Ok(joined)
}

// The dictionary that makes what is missing.

const DEFAULTING: &[MethodDef] = &[
    ("__missing__", "key /", |ev, args| {
        let own = DictReceiver::of(ev, &args[0])?;
        let factory = factory(ev, &args[0]);
        if factory.is_none() {
            return Err(ev.key_error(&args[1]));
        }
        let value = ev.call(&factory, &mut [], &[])?;
        own.set(ev, args[1].clone(), value.clone())?;
        Ok(value)
    }),
    ("copy", "", copy_defaulting),
    ("__copy__", "", copy_defaulting),
    ("__or__", "other /", |ev, args| {
        let Value::Dict(_) = ev.unwrap_builtin(&args[1]) else {
            return Ok(Value::NotImplemented);
        };
        let other = args[1].clone();
        let copy = copy_defaulting(ev, args)?;
        DictReceiver::of(ev, &copy)?.update(ev, &other)?;
        Ok(copy)
    }),
    ("__ror__", "other /", |ev, args| {
        let own = DictReceiver::of(ev, &args[0])?;
        let Value::Dict(other) = ev.unwrap_builtin(&args[1]) else {
            return Ok(Value::NotImplemented);
        };
        let joined = ev.copy_dict(&other)?;
        ev.dict_update(&joined, &own.dict)?;
        call_class(
            ev,
            &own.class,
            &mut [factory(ev, &args[0]), Value::Dict(Rc::new(joined))],
        )
    }),
    ("__repr__", "", |ev, args| {
        let own = DictReceiver::of(ev, &args[0])?;
        let factory = ev.repr(&factory(ev, &args[0]))?;
        let items = ev.repr(&Value::Dict(own.dict.clone()))?;
        Ok(Value::str(format!("{}({factory}, {items})", own.name())))
    }),
];

/// What makes a missing value.
fn factory(ev: &Evaluator<'_>, receiver: &Value) -> Value {
    let name = ev.core.symbols.intern("default_factory");
    match receiver {
        Value::Instance(instance) => instance.get(name, &ev.core.symbols),
        _ => None,
    }
    .unwrap_or(Value::None)
}

fn default_init(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let [receiver, rest @ ..] = &*args.positional else {
        return Err(ev.type_error("a method of 'defaultdict' needs an argument"));
    };
    let own = DictReceiver::of(ev, receiver)?;
    let (factory, rest) = match rest {
        [] => (Value::None, rest),
        [factory, rest @ ..] => (factory.clone(), rest),
    };
    if !factory.is_none() && !factory.is_callable() {
        return Err(ev.type_error("first argument must be callable or None"));
    }
    if rest.len() > 1 {
        let count = rest.len();
        return Err(ev.type_error(format!("dict expected at most 1 argument, got {count}")));
    }
    if let Value::Instance(instance) = receiver {
        ev.core.gc_track(receiver);
        let name = ev.core.symbols.intern("default_factory");
        instance.set(name, factory, &ev.core.symbols);
    }
    if let Some(source) = rest.first() {
        ev.core.gc_track(receiver);
        ev.dict_update_from(&own.dict, source)?;
    }
    for (name, value) in args.keywords {
        ev.core.gc_track(receiver);
        ev.dict_set(&own.dict, ev.core.symbols.to_value(*name), value.clone())?;
    }
    Ok(Value::None)
}

fn copy_defaulting(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let own = DictReceiver::of(ev, &args[0])?;
    let factory = factory(ev, &args[0]);
    let class = native_class(ev, "_collections.defaultdict")?;
    if Rc::ptr_eq(&class, &own.class) {
        let copy = new_instance(&class, ev.copy_dict(&own.dict)?);
        if let Value::Instance(instance) = &copy {
            ev.core.gc_track(&copy);
            let name = ev.core.symbols.intern("default_factory");
            instance.set(name, factory, &ev.core.symbols);
        }
        return Ok(copy);
    }
    call_class(ev, &own.class, &mut [factory, args[0].clone()])
}
