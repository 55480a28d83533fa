//! `map`, `filter`, `zip`, `enumerate`, `to_reversed`, and the methods of generators.

use std::cell::Cell;
use std::rc::Rc;

use super::range::long_range_iterator;
use super::{BoundFn, constructor, methods, raw_constructor, wrong_receiver};
use crate::builtins::Args;
use crate::errors::ExceptionKind;
use crate::eval::generator::{Generator, GeneratorInput, StepResult};
use crate::eval::{Evaluator, InterpreterState};
use crate::ops::iterate::dict_iter;
use crate::value::dict::ViewKind;
use crate::value::symbol::known;
use crate::value::{Iter, R, Range, ScriptCell, Unwind, Value};

pub(super) fn install(core: &Rc<InterpreterState>) {
    let types = &core.types;
    raw_constructor(&types.map, map);
    raw_constructor(&types.zip, zip);
    constructor(core, &types.filter, "function iterable /", |ev, args| {
        let source = ev.iter(&args[1])?;
        Ok(Value::Iter(Rc::new(Iter::Filter {
            function: args[0].clone(),
            source,
        })))
    });
    constructor(core, &types.enumerate, "iterable start?", |ev, args| {
        let start = match args[1].if_given() {
            Some(start) => ev.to_int(start)?.into_value(),
            None => Value::Int(0),
        };
        let source = ev.iter(&args[0])?;
        Ok(Value::Iter(Rc::new(Iter::Enumerate {
            source,
            count: ScriptCell::new(start),
        })))
    });
    constructor(core, &types.reversed, "sequence /", reversed);
    for class in [
        &types.iterator,
        &types.list_iterator,
        &types.tuple_iterator,
        &types.str_iterator,
        &types.str_ascii_iterator,
        &types.bytes_iterator,
        &types.bytearray_iterator,
        &types.range_iterator,
        &types.dict_keyiterator,
        &types.dict_valueiterator,
        &types.dict_itemiterator,
        &types.dict_reversekeyiterator,
        &types.dict_reversevalueiterator,
        &types.dict_reverseitemiterator,
        &types.set_iterator,
        &types.list_reverseiterator,
        &types.reversed,
    ] {
        let methods_of_all: &[(&str, &str, BoundFn)] =
            &[("__length_hint__", "", |ev, args| match &args[0] {
                Value::Iter(iter) => length_hint(ev, iter),
                _ => Ok(Value::NotImplemented),
            })];
        methods(core, class, methods_of_all);
    }
    methods(
        core,
        &types.generator,
        &[
            ("send", "value /", |ev, args| {
                let generator = receiver(ev, &args[0])?;
                if !args[1].is_none()
                    && !generator.is_suspended()
                    && !generator.is_finished()
                    && !generator.is_running()
                {
                    return Err(
                        ev.type_error("can't send non-None value to a just-started generator")
                    );
                }
                finish(
                    ev,
                    ev.step_generator(&generator, GeneratorInput::Send(args[1].clone())),
                )
            }),
            ("throw", "type value? traceback? /", throw),
            ("close", "", |ev, args| {
                let generator = receiver(ev, &args[0])?;
                ev.close_generator(&generator).map(|()| Value::None)
            }),
        ],
    );
}

fn receiver(ev: &Evaluator<'_>, value: &Value) -> R<Rc<Generator>> {
    match value {
        Value::Generator(generator) => Ok(generator.clone()),
        other => Err(wrong_receiver(ev, "generator", other)),
    }
}

fn finish(ev: &Evaluator<'_>, step: R<StepResult>) -> R {
    match step {
        Ok(StepResult::Yielded(value)) => Ok(value),
        Ok(StepResult::Returned(value)) => ev.stop_iteration(value),
        Err(raised) => Err(ev.generator_error(raised)),
    }
}

fn throw(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let generator = receiver(ev, &args[0])?;
    let exception = match (&args[1], args[2].if_given()) {
        (Value::Class(_), Some(value)) if !value.is_none() => match value {
            Value::Instance(instance) if instance.exception().is_some() => instance.clone(),
            value => {
                let made = ev.call1(&args[1], value.clone())?;
                ev.to_exception(&made)?
            }
        },
        (value, _) => ev.to_exception(value).map_err(|raised| {
            let name = ev.core.types.name_of(value);
            if ev.is_kind(&raised, ExceptionKind::TypeError) {
                return ev.type_error(format!(
                    "exceptions must be classes or instances deriving from BaseException, not {name}"
                ));
            }
            raised
        })?,
    };
    finish(
        ev,
        ev.step_generator(
            &generator,
            GeneratorInput::Throw(Unwind::Exception(exception)),
        ),
    )
}

fn map(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let Some((function, iterables)) = args.positional.split_first() else {
        return Err(ev.type_error("map() must have at least two arguments."));
    };
    if iterables.is_empty() {
        return Err(ev.type_error("map() must have at least two arguments."));
    }
    let sources: R<Vec<Value>> = iterables.iter().map(|iterable| ev.iter(iterable)).collect();
    Ok(Value::Iter(Rc::new(Iter::Map {
        function: function.clone(),
        sources: sources?,
    })))
}

fn zip(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let strict = match args.keyword(known::STRICT) {
        Some(value) => ev.truth(value)?,
        None => false,
    };
    if let Some((name, _)) = args
        .keywords
        .iter()
        .find(|(name, _)| *name != known::STRICT)
    {
        let name = ev.core.symbols.name(*name);
        return Err(ev.type_error(format!("'{name}' is an invalid keyword argument for zip()")));
    }
    let sources: R<Vec<Value>> = args
        .positional
        .iter()
        .map(|iterable| ev.iter(iterable))
        .collect();
    let sources = sources?;
    Ok(Value::Iter(Rc::new(Iter::Zip { sources, strict })))
}

/// `to_reversed(value)`
pub(super) fn reversed(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let value = &args[0];
    let iter = match value {
        Value::List(list) => Iter::ListReversed {
            list: list.clone(),
            index: Cell::new(list.len()),
        },
        Value::Range(range) => {
            let length = range.len();
            let last = if length == 0 {
                range.start
            } else {
                range.at(length - 1)
            };
            let backwards = Range {
                start: last,
                stop: range.start,
                step: range.step.wrapping_neg(),
            };
            Iter::Range {
                next: Cell::new(backwards.start),
                step: backwards.step,
                left: Cell::new(length),
            }
        }
        Value::LongRange(range) => long_range_iterator(ev, &range.to_reversed()),
        Value::Dict(dict) => dict_iter(dict, ViewKind::Keys, true),
        Value::DictView(view) => dict_iter(&view.dict, view.kind, true),
        Value::Str(_) | Value::Tuple(_) | Value::Bytes(_) | Value::ByteArray(_) => {
            backwards(ev, value)?
        }
        Value::Instance(instance) => {
            if let Some(Value::None) = instance.class.lookup(known::REVERSED) {
                return Err(not_reversible(ev, value));
            }
            if let Some(result) = ev.special(value, known::REVERSED, &mut [])? {
                return Ok(result);
            }
            // A sequence is what has `__getitem__` by a script, or a builtin one and a length; what has none says so
            // itself.
            match instance.class.lookup(known::GETITEM) {
                None => return Err(not_reversible(ev, value)),
                Some(Value::Builtin(_)) if instance.class.lookup(known::LEN).is_none() => {
                    return Err(not_reversible(ev, value));
                }
                Some(_) => backwards(ev, value)?,
            }
        }
        Value::Class(class) if class.meta_method(known::REVERSED).is_some() => {
            return match ev.special(value, known::REVERSED, &mut [])? {
                Some(result) => Ok(result),
                None => Err(not_reversible(ev, value)),
            };
        }
        other => return Err(not_reversible(ev, other)),
    };
    Ok(Value::Iter(Rc::new(iter)))
}

/// How many items an iterator still has, as far as it knows.
fn length_hint(ev: &Evaluator<'_>, iter: &Iter) -> R {
    let count = match iter {
        Iter::List { list, index } => {
            let length = list.borrow().as_ref().map_or(0, |list| list.len());
            length.saturating_sub(index.get())
        }
        Iter::Tuple { tuple, index } => tuple.items().len().saturating_sub(index.get()),
        Iter::Str { text, offset } => {
            ev.count_chars(text.as_str().get(offset.get()..).unwrap_or_default())?
        }
        Iter::Bytes { bytes, index } => bytes.data().len().saturating_sub(index.get()),
        Iter::Range { left, .. } => usize::try_from(left.get()).unwrap_or(usize::MAX),
        Iter::ListReversed { list, index } => match index.get() {
            index if index <= list.len() => index,
            _ => 0,
        },
        Iter::Dict { dict, length, .. } if dict.len() == length.get() => count(ev, iter)?,
        Iter::Set { set, length, .. } if set.len() == length.get() => count(ev, iter)?,
        Iter::Sequence { done, .. } if done.get() => 0,
        Iter::Sequence {
            object,
            index,
            reversed,
            ..
        } => {
            if ev.core.types.of(object).lookup(known::LEN).is_none() {
                return Ok(Value::NotImplemented);
            }
            let length = ev.len(object)?;
            match (usize::try_from(index.get()), reversed) {
                (Ok(index), true) if index < length => index + 1,
                (Ok(index), false) => length.saturating_sub(index),
                _ => 0,
            }
        }
        _ => 0,
    };
    Ok(Value::Int(i64::try_from(count).unwrap_or(i64::MAX)))
}

/// How many items an iterator of a dictionary or set would still give.
fn count(ev: &Evaluator<'_>, iter: &Iter) -> R<usize> {
    let Some(twin) = iter.copy() else {
        return Ok(0);
    };
    let iterator = Value::Iter(Rc::new(twin));
    let mut count = 0;
    while ev.next_at_safepoint(&iterator)?.is_some() {
        count += 1;
    }
    Ok(count)
}

fn backwards(ev: &Evaluator<'_>, value: &Value) -> R<Iter> {
    let last = ev.len(value)? as i64 - 1;
    Ok(Iter::Sequence {
        object: value.clone(),
        index: Cell::new(last),
        reversed: true,
        done: Cell::new(false),
    })
}

fn not_reversible(ev: &Evaluator<'_>, value: &Value) -> Unwind {
    ev.type_error(format!(
        "'{}' object is not reversible",
        ev.core.types.name_of(value)
    ))
}
