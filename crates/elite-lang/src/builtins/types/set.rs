//! `set` and `frozenset`.

use std::rc::Rc;

use elite_syntax::ast::CompareOp;

use super::{constructor, methods, wrong_receiver};
use crate::eval::{Evaluator, InterpreterState};
use crate::value::{Class, R, Set, Value};

pub(super) fn install(core: &Rc<InterpreterState>) {
    let types = &core.types;
    constructor(core, &types.set, "iterable? /", |ev, args| {
        let set = Rc::new(Set::new());
        if let Some(iterable) = args[0].if_given() {
            ev.set_extend(&set, iterable)?;
        }
        Ok(Value::Set(set))
    });
    constructor(
        core,
        &types.frozenset,
        "iterable? /",
        |ev, args| match args[0].if_given() {
            Some(frozen @ Value::FrozenSet(_)) => Ok(frozen.clone()),
            iterable => {
                let set = Rc::new(Set::new());
                if let Some(iterable) = iterable {
                    ev.set_extend(&set, iterable)?;
                }
                Ok(Value::FrozenSet(set))
            }
        },
    );
    install_queries(core, &types.set);
    install_queries(core, &types.frozenset);
    methods(
        core,
        &types.set,
        &[
            ("__init__", "iterable? /", |ev, args| {
                let set = receiver(ev, &args[0])?;
                set.clear();
                if let Some(iterable) = args[1].if_given() {
                    ev.set_extend(&set, iterable)?;
                }
                Ok(Value::None)
            }),
            ("add", "element /", |ev, args| {
                let set = receiver(ev, &args[0])?;
                ev.set_add(&set, std::mem::take(&mut args[1]))
                    .map(|()| Value::None)
            }),
            ("discard", "element /", |ev, args| {
                let set = receiver(ev, &args[0])?;
                ev.set_remove(&set, &args[1]).map(|_| Value::None)
            }),
            ("remove", "element /", |ev, args| {
                let set = receiver(ev, &args[0])?;
                if ev.set_remove(&set, &args[1])? {
                    Ok(Value::None)
                } else {
                    Err(ev.key_error(&args[1]))
                }
            }),
            ("pop", "", |ev, args| {
                let set = receiver(ev, &args[0])?;
                ev.set_pop(&set)?.ok_or_else(|| {
                    let text = Value::str("pop from an empty set");
                    ev.raise_args(crate::errors::ExceptionKind::KeyError, vec![text])
                })
            }),
            ("clear", "", |ev, args| {
                receiver(ev, &args[0])?.clear();
                Ok(Value::None)
            }),
            ("update", "*others", |ev, args| {
                let set = receiver(ev, &args[0])?;
                for other in others(&args[1]) {
                    ev.set_extend(&set, &other)?;
                }
                Ok(Value::None)
            }),
            ("intersection_update", "*others", |ev, args| {
                let result = intersection(ev, args)?;
                receiver(ev, &args[0])?.replace(result);
                Ok(Value::None)
            }),
            ("difference_update", "*others", |ev, args| {
                let set = receiver(ev, &args[0])?;
                for other in others(&args[1]) {
                    match ev.unwrap_builtin(&other) {
                        Value::Set(other) | Value::FrozenSet(other) => {
                            ev.set_subtract(&set, &other)?;
                        }
                        _ => {
                            let iterator = ev.iter(&other)?;
                            while let Some(item) = ev.next_at_safepoint(&iterator)? {
                                ev.set_remove(&set, &item)?;
                            }
                        }
                    }
                }
                Ok(Value::None)
            }),
            ("symmetric_difference_update", "other /", |ev, args| {
                let set = receiver(ev, &args[0])?;
                ev.set_toggle(&set, &*as_set(ev, &args[1])?)?;
                Ok(Value::None)
            }),
        ],
    );
}

fn install_queries(core: &Rc<InterpreterState>, class: &Class) {
    methods(
        core,
        class,
        &[
            ("copy", "", |ev, args| {
                let set = receiver(ev, &args[0])?;
                let copy = ev.copy_set(&set)?;
                Ok(like(&args[0], copy))
            }),
            ("union", "*others", |ev, args| {
                let set = receiver(ev, &args[0])?;
                let result = ev.copy_set(&set)?;
                for other in others(&args[1]) {
                    ev.set_extend(&result, &other)?;
                }
                Ok(like(&args[0], result))
            }),
            ("intersection", "*others", |ev, args| {
                Ok(like(&args[0], intersection(ev, args)?))
            }),
            ("difference", "*others", |ev, args| {
                combine(ev, args, Evaluator::set_difference)
            }),
            ("symmetric_difference", "other /", |ev, args| {
                let set = receiver(ev, &args[0])?;
                let result = ev.set_symmetric_difference(&set, &*as_set(ev, &args[1])?)?;
                Ok(like(&args[0], result))
            }),
            ("issubset", "other /", |ev, args| {
                let (set, other) = (receiver(ev, &args[0])?, as_set(ev, &args[1])?);
                ev.compare_sets(CompareOp::Le, &set, &other)
                    .map(Value::Bool)
            }),
            ("issuperset", "other /", |ev, args| {
                let (set, other) = (receiver(ev, &args[0])?, as_set(ev, &args[1])?);
                ev.compare_sets(CompareOp::Ge, &set, &other)
                    .map(Value::Bool)
            }),
            ("isdisjoint", "other /", |ev, args| {
                let set = receiver(ev, &args[0])?;
                let iterator = ev.iter(&args[1])?;
                while let Some(item) = ev.next_at_safepoint(&iterator)? {
                    if ev.set_contains(&set, &item)? {
                        return Ok(Value::Bool(false));
                    }
                }
                Ok(Value::Bool(true))
            }),
        ],
    );
}

/// The set behind a receiver.
fn receiver(ev: &Evaluator<'_>, value: &Value) -> R<Rc<Set>> {
    match ev.unwrap_builtin(value) {
        Value::Set(set) | Value::FrozenSet(set) => Ok(set),
        other => Err(wrong_receiver(ev, "set", &other)),
    }
}

/// Any iterable as a set.
fn as_set(ev: &Evaluator<'_>, value: &Value) -> R<Rc<Set>> {
    match ev.unwrap_builtin(value) {
        Value::Set(set) | Value::FrozenSet(set) => Ok(set),
        _ => {
            let set = Rc::new(Set::new());
            ev.set_extend(&set, value)?;
            Ok(set)
        }
    }
}

/// A result of the same type as the receiver.
fn like(receiver: &Value, set: Set) -> Value {
    let frozen = match receiver {
        Value::FrozenSet(_) => true,
        Value::Instance(instance) => matches!(instance.builtin_value(), Some(Value::FrozenSet(_))),
        _ => false,
    };
    if frozen {
        Value::FrozenSet(Rc::new(set))
    } else {
        Value::Set(Rc::new(set))
    }
}

fn others(rest: &Value) -> Vec<Value> {
    if let Value::Tuple(tuple) = rest {
        tuple.items().to_vec()
    } else {
        Vec::new()
    }
}

/// What is in all of them; what is no set is walked through item by item.
fn intersection(ev: &Evaluator<'_>, args: &[Value]) -> R<Set> {
    let mut result = receiver(ev, &args[0])?;
    let others = others(&args[1]);
    if others.is_empty() {
        return ev.copy_set(&result);
    }
    for other in others {
        result = Rc::new(match ev.unwrap_builtin(&other) {
            Value::Set(other) | Value::FrozenSet(other) => ev.set_intersection(&result, &other)?,
            _ => {
                let common = Set::new();
                let iterator = ev.iter(&other)?;
                while let Some(item) = ev.next_at_safepoint(&iterator)? {
                    let hash = ev.hash(&item)?;
                    if ev.set_find(&result, hash, &item)?.is_some() {
                        ev.set_add_hashed(&common, hash, item)?;
                    }
                }
                common
            }
        });
    }
    ev.copy_set(&result)
}

type SetOpFn<'y> = fn(&Evaluator<'y>, &Set, &Set) -> R<Set>;

fn fold_sets<'y>(ev: &Evaluator<'y>, args: &[Value], combine: SetOpFn<'y>) -> R<Set> {
    let mut result = ev.copy_set(&*receiver(ev, &args[0])?)?;
    for other in others(&args[1]) {
        result = combine(ev, &result, &*as_set(ev, &other)?)?;
    }
    Ok(result)
}

fn combine<'y>(ev: &Evaluator<'y>, args: &[Value], operation: SetOpFn<'y>) -> R {
    Ok(like(&args[0], fold_sets(ev, args, operation)?))
}
