//! `_copy`: what `copy` cannot make by itself, iterators of builtin types.

use std::cell::Cell;
use std::rc::Rc;

use super::define::ModuleBuilder;
use crate::eval::Evaluator;
use crate::value::iter::NativeIter;
use crate::value::{Iter, R, ScriptCell, Value};

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    module.functions(&[("copied_iterator", "iterator each /", |ev, args| {
        copied(ev, &args[0], &args[1])
    })]);
    Ok(())
}

/// An iterator that stands where this one stands, over what `each` makes of what this one goes over; `None` for
/// iterators of the library. Where CPython lists what is left, so does this.
fn copied(ev: &Evaluator<'_>, iterator: &Value, each: &Value) -> R {
    let Value::Iter(iter) = iterator else {
        return Ok(Value::None);
    };
    let of = |value: &Value| ev.call1(each, value.clone());
    let all = |values: &[Value]| values.iter().map(of).collect::<R<Vec<Value>>>();
    let nothing = || ev.iter(&Value::tuple(Vec::new()));
    if let Some(twin) = iter.copy() {
        let twin = Value::Iter(Rc::new(twin));
        return match &**iter {
            Iter::Dict { .. } | Iter::Set { .. } => ev.iter(&of(&ev.drain(&twin)?.into_list())?),
            _ => Ok(twin),
        };
    }
    let made = match &**iter {
        Iter::List { list, index } => {
            let left = list.get();
            let left = left.map_or_else(|| Value::list(Vec::new()), Value::List);
            match of(&left)? {
                Value::List(list) => Iter::List {
                    list: ScriptCell::new(Some(list)),
                    index: index.clone(),
                },
                other => return ev.iter(&other),
            }
        }
        Iter::ListReversed { list, index } => match of(&Value::List(list.clone()))? {
            Value::List(list) => Iter::ListReversed {
                list,
                index: index.clone(),
            },
            other => return ev.iter(&other),
        },
        Iter::Tuple { tuple, index } => match of(&Value::Tuple(tuple.clone()))? {
            Value::Tuple(tuple) => Iter::Tuple {
                tuple,
                index: index.clone(),
            },
            other => return ev.iter(&other),
        },
        Iter::Sequence { done, .. } | Iter::Callable { done, .. } if done.get() => {
            return nothing();
        }
        Iter::Sequence {
            object,
            index,
            reversed,
            ..
        } => Iter::Sequence {
            object: of(object)?,
            index: index.clone(),
            reversed: *reversed,
            done: Cell::new(false),
        },
        Iter::Callable {
            function, sentinel, ..
        } => Iter::Callable {
            function: of(function)?,
            sentinel: of(sentinel)?,
            done: Cell::new(false),
        },
        Iter::Map { function, sources } => Iter::Map {
            function: of(function)?,
            sources: all(sources)?,
        },
        Iter::Filter { function, source } => Iter::Filter {
            function: of(function)?,
            source: of(source)?,
        },
        Iter::Zip { sources, strict } => Iter::Zip {
            sources: all(sources)?,
            strict: *strict,
        },
        Iter::Enumerate { source, count } => Iter::Enumerate {
            source: of(source)?,
            count: ScriptCell::new(count.get()),
        },
        Iter::Native(native) => {
            // The iterator `pairwise` of `itertools` cannot be copied.
            let pairs = *native.class.name() == *"pairwise";
            let steps = match pairs {
                true => None,
                false => native.steps.copy_with(ev, &of)?,
            };
            let Some(steps) = steps else {
                return Ok(Value::None);
            };
            Iter::Native(NativeIter {
                class: native.class.clone(),
                steps,
            })
        }
        Iter::Str { .. }
        | Iter::Bytes { .. }
        | Iter::Range { .. }
        | Iter::Dict { .. }
        | Iter::Set { .. } => return Ok(Value::None),
    };
    Ok(Value::Iter(Rc::new(made)))
}
