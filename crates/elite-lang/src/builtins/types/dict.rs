//! `dict` and its views.

use std::rc::Rc;

use super::{class_method, methods, raw_constructor, raw_method, wrong_receiver};
use crate::builtins::Args;
use crate::errors::ExceptionKind;
use crate::eval::{Evaluator, InterpreterState};
use crate::limits::yielding::WORK_PER_VALUE;
use crate::ops::iterate::dict_iter;
use crate::value::dict::ViewKind;
use crate::value::{Dict, DictView, R, Value, ValueVec};

pub(super) fn install(core: &Rc<InterpreterState>) {
    let types = &core.types;
    raw_constructor(&types.dict, |ev, args| {
        let dict = Rc::new(Dict::new());
        fill(ev, &dict, args.positional, args, "dict")?;
        Ok(Value::Dict(dict))
    });
    methods(
        core,
        &types.dict,
        &[
            ("get", "key default? /", |ev, args| {
                let dict = receiver(ev, &args[0])?;
                let default = || args[2].if_given().cloned().unwrap_or(Value::None);
                Ok(ev.dict_get(&dict, &args[1])?.unwrap_or_else(default))
            }),
            ("setdefault", "key default? /", setdefault),
            ("pop", "key default? /", pop),
            ("popitem", "", popitem),
            ("clear", "", |ev, args| {
                receiver(ev, &args[0])?.clear();
                Ok(Value::None)
            }),
            ("copy", "", |ev, args| {
                let dict = receiver(ev, &args[0])?;
                Ok(Value::Dict(Rc::new(ev.dict_copy_method(&args[0], &dict)?)))
            }),
            ("keys", "", |ev, args| view(ev, &args[0], ViewKind::Keys)),
            ("values", "", |ev, args| {
                view(ev, &args[0], ViewKind::Values)
            }),
            ("items", "", |ev, args| view(ev, &args[0], ViewKind::Items)),
            ("__reversed__", "", |ev, args| {
                Ok(Value::Iter(Rc::new(dict_iter(
                    &receiver(ev, &args[0])?,
                    ViewKind::Keys,
                    true,
                ))))
            }),
        ],
    );
    raw_method(core, &types.dict, "update", |ev, args| {
        let Some((first, rest)) = args.positional.split_first_mut() else {
            return Err(ev.type_error("unbound method dict.update() needs an argument"));
        };
        let dict = receiver(ev, first)?;
        let rest = rest.to_vec();
        fill(ev, &dict, &rest, args, "update")?;
        Ok(Value::None)
    });
    raw_method(core, &types.dict, "__init__", |ev, args| {
        let Some((first, rest)) = args.positional.split_first_mut() else {
            return Err(ev.type_error("descriptor '__init__' of 'dict' object needs an argument"));
        };
        let dict = receiver(ev, first)?;
        let rest = rest.to_vec();
        fill(ev, &dict, &rest, args, "dict")?;
        Ok(Value::None)
    });
    class_method(
        core,
        &types.dict,
        "fromkeys",
        "iterable value? /",
        |ev, args| {
            let value = args[2].if_given().cloned().unwrap_or(Value::None);
            if !args[0].is(&Value::Class(ev.core.types.dict.clone())) {
                return derived_from_keys(ev, args, &value);
            }
            let dict = Dict::new();
            // Hashes that are known are not asked for again.
            let hashed: ValueVec<(u64, Value)> = match &args[1] {
                Value::Dict(other) => {
                    let mut hashed = ValueVec::from(ev.try_with_capacity(other.len())?);
                    for (hash, key, _) in ev.collect_entries(other)? {
                        hashed.push((hash, key));
                        ev.charge(WORK_PER_VALUE)?;
                    }
                    hashed
                }
                Value::Set(other) | Value::FrozenSet(other) => ev.elements(other)?,
                other => {
                    let iterator = ev.iter(other)?;
                    while let Some(key) = ev.next_at_safepoint(&iterator)? {
                        ev.dict_set(&dict, key, value.clone())?;
                    }
                    ValueVec::default()
                }
            };
            for (hash, key) in hashed {
                ev.charge(WORK_PER_VALUE)?;
                ev.dict_set_hashed(&dict, hash, key, value.clone())?;
            }
            Ok(Value::Dict(Rc::new(dict)))
        },
    );
    for class in [&types.dict_keys, &types.dict_values, &types.dict_items] {
        methods(
            core,
            class,
            &[("__reversed__", "", |_, args| match &args[0] {
                Value::DictView(view) => {
                    Ok(Value::Iter(Rc::new(dict_iter(&view.dict, view.kind, true))))
                }
                other => Ok(other.clone()),
            })],
        );
    }
    for class in [&types.dict_keys, &types.dict_items] {
        methods(
            core,
            class,
            &[("isdisjoint", "other /", |ev, args| {
                let iterator = ev.iter(&args[1])?;
                while let Some(item) = ev.next_at_safepoint(&iterator)? {
                    if ev.contains(&args[0], &item)? {
                        return Ok(Value::Bool(false));
                    }
                }
                Ok(Value::Bool(true))
            })],
        );
    }
}

/// The dictionary behind a receiver.
pub(super) fn receiver(ev: &Evaluator<'_>, value: &Value) -> R<Rc<Dict>> {
    match value {
        Value::Dict(dict) => Ok(dict.clone()),
        other => match ev.unwrap_builtin(other) {
            Value::Dict(dict) => Ok(dict),
            other => Err(wrong_receiver(ev, "dict", &other)),
        },
    }
}

/// What `dict(…)` and `update` take: a mapping or pairs, then keywords.
fn fill(
    ev: &Evaluator<'_>,
    dict: &Dict,
    positional: &[Value],
    args: &Args<'_>,
    function: &str,
) -> R<()> {
    if positional.len() > 1 {
        return Err(ev.type_error(format!(
            "{function} expected at most 1 argument, got {}",
            positional.len()
        )));
    }
    if let Some(source) = positional.first() {
        ev.dict_update_from(dict, source)?;
    }
    for (name, value) in args.keywords {
        let name = ev.core.symbols.to_value(*name);
        ev.check_name(name.as_str().unwrap_or_default())?;
        ev.charge(2 * WORK_PER_VALUE)?;
        ev.dict_set(dict, name, value.clone())?;
    }
    Ok(())
}

fn view(ev: &Evaluator<'_>, value: &Value, kind: ViewKind) -> R {
    let dict = receiver(ev, value)?;
    Ok(Value::DictView(Rc::new(DictView { kind, dict })))
}

fn setdefault(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let dict = receiver(ev, &args[0])?;
    let hash = ev.hash(&args[1])?;
    if let Some(index) = ev.dict_find_hashed(&dict, hash, &args[1])? {
        return Ok(dict.value_at(index));
    }
    let value = args[2].if_given().cloned().unwrap_or(Value::None);
    ev.dict_set_hashed(&dict, hash, args[1].clone(), value.clone())?;
    Ok(value)
}

fn pop(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let dict = receiver(ev, &args[0])?;
    // An empty one is not asked, so that a key without a hash is missing from it.
    let found = match dict.is_empty() {
        true => None,
        false => ev.dict_remove(&dict, &args[1])?,
    };
    match (found, args[2].if_given()) {
        (Some(value), _) => Ok(value),
        (None, Some(default)) => Ok(default.clone()),
        (None, None) => Err(ev.key_error(&args[1])),
    }
}

fn popitem(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let dict = receiver(ev, &args[0])?;
    let Some((index, ..)) = ev.previous_entry(&dict, usize::MAX)? else {
        return Err(ev.raise_args(
            ExceptionKind::KeyError,
            vec![Value::str("popitem(): dictionary is empty")],
        ));
    };
    let (key, value) = dict.delete_at(index);
    Ok(Value::pair(key, value))
}

/// `fromkeys` of a class derived from `dict`: the class makes the object, and that takes the items one by one.
fn derived_from_keys(ev: &Evaluator<'_>, args: &[Value], value: &Value) -> R {
    let made = ev.call(&args[0], &mut [], &[])?;
    let iterator = ev.iter(&args[1])?;
    while let Some(key) = ev.next_at_safepoint(&iterator)? {
        ev.set_item(&made, &key, value.clone())?;
    }
    Ok(made)
}
