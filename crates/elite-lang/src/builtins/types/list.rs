//! `list` and `tuple`.

use std::rc::Rc;

use super::{clamp_start, constructor, methods, wrong_receiver};
use crate::errors::ExceptionKind;
use crate::eval::pace::VALUE;
use crate::eval::{Core, Evaluator};
use crate::value::{Iter, List, R, Value};

pub(super) fn install(core: &Rc<Core>) {
    let types = &core.types;
    constructor(core, &types.list, "iterable? /", |ev, args| {
        match args[0].given() {
            None => Ok(Value::list(Vec::new())),
            Some(iterable) => ev.collect(iterable).map(Value::list),
        }
    });
    constructor(core, &types.tuple, "iterable? /", |ev, args| {
        match args[0].given() {
            None => Ok(Value::tuple(Vec::new())),
            Some(tuple @ Value::Tuple(_)) => Ok(tuple.clone()),
            Some(iterable) => ev.collect(iterable).map(Value::tuple),
        }
    });
    methods(
        core,
        &types.list,
        &[
            ("append", "object /", append),
            ("extend", "iterable /", extend),
            ("insert", "index object /", insert),
            ("pop", "index? /", pop),
            ("remove", "value /", remove),
            ("clear", "", clear),
            ("copy", "", |ev, args| {
                let mut items = Vec::new();
                ev.copy_list(&*receiver(ev, &args[0])?, &mut items)?;
                Ok(Value::list(items))
            }),
            ("count", "value /", |ev, args| count(ev, &args[0], &args[1])),
            ("index", "value start? stop? /", index),
            ("reverse", "", reverse),
            ("sort", "function? / * key? reverse?", sort),
            ("__init__", "iterable? /", init),
            ("__reversed__", "", |ev, args| {
                let list = receiver(ev, &args[0])?;
                let index = std::cell::Cell::new(list.len());
                Ok(Value::Iter(Rc::new(Iter::ListReversed { list, index })))
            }),
        ],
    );
    methods(
        core,
        &types.tuple,
        &[
            ("count", "value /", |ev, args| count(ev, &args[0], &args[1])),
            ("index", "value start? stop? /", index),
        ],
    );
}

/// The list behind a receiver.
fn receiver(ev: &Evaluator<'_>, value: &Value) -> R<Rc<List>> {
    match value {
        Value::List(list) => Ok(list.clone()),
        other => match ev.plain(other) {
            Value::List(list) => Ok(list),
            other => Err(wrong_receiver(ev, "list", &other)),
        },
    }
}

fn init(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let list = receiver(ev, &args[0])?;
    let items = match args[1].given() {
        Some(iterable) => ev.collect(iterable)?,
        None => Vec::new(),
    };
    let old = std::mem::replace(&mut *list.borrow_mut(), items);
    drop(old);
    list.account();
    Ok(Value::None)
}

/// A list that is given a value which can hold others may become part of a cycle.
#[inline]
fn note(ev: &Evaluator<'_>, list: &Rc<crate::value::List>, item: &Value) {
    if !list.noted.get() && item.holds_values() {
        ev.core.note_list(list);
    }
}

fn append(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let item = std::mem::take(&mut args[1]);
    match &args[0] {
        Value::List(list) => {
            note(ev, list, &item);
            list.push(item);
        }
        other => {
            let list = receiver(ev, other)?;
            note(ev, &list, &item);
            list.push(item);
        }
    }
    Ok(Value::None)
}

fn extend(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let list = receiver(ev, &args[0])?;
    let items = ev.collect(&args[1])?;
    ev.check_allocation((list.len() + items.len()) * size_of::<Value>())?;
    if let Some(holder) = items.iter().find(|item| item.holds_values()) {
        note(ev, &list, holder);
    }
    list.borrow_mut().extend(items);
    list.account();
    Ok(Value::None)
}

fn insert(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let list = receiver(ev, &args[0])?;
    let length = list.len();
    let index = ev.clamped_index(&args[1])?;
    let index = if index < 0 {
        index.saturating_add(length as i64).max(0)
    } else {
        index
    };
    let index = usize::try_from(index).unwrap_or(usize::MAX).min(length);
    note(ev, &list, &args[2]);
    list.borrow_mut()
        .insert(index, std::mem::take(&mut args[2]));
    list.account();
    Ok(Value::None)
}

fn pop(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let list = receiver(ev, &args[0])?;
    let error = |text: &str| Err(ev.raise(ExceptionKind::IndexError, text));
    let Some(index) = args[1].given() else {
        let last = list.borrow_mut().pop();
        return last.map_or_else(|| error("pop from empty list"), Ok);
    };
    let index = ev.index(index)?;
    let mut items = list.borrow_mut();
    if items.is_empty() {
        return error("pop from empty list");
    }
    let place = if index < 0 {
        index + items.len() as i64
    } else {
        index
    };
    match usize::try_from(place)
        .ok()
        .filter(|place| *place < items.len())
    {
        Some(place) => Ok(items.remove(place)),
        None => error("pop index out of range"),
    }
}

fn remove(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let list = receiver(ev, &args[0])?;
    let mut index = 0;
    while let Some(item) = list.get(index) {
        ev.worked(VALUE)?;
        if ev.equal(&item, &args[1])? {
            let mut items = list.borrow_mut();
            // The comparison may have changed the list.
            let removed = (index < items.len()).then(|| items.remove(index));
            drop(items);
            drop(removed);
            return Ok(Value::None);
        }
        index += 1;
    }
    Err(ev.value_error("list.remove(x): x not in list"))
}

fn clear(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let list = receiver(ev, &args[0])?;
    let old = std::mem::take(&mut *list.borrow_mut());
    list.account();
    drop(old);
    Ok(Value::None)
}

/// Items of a list or tuple, one by one.
fn item_at(ev: &Evaluator<'_>, value: &Value, index: usize) -> R<Option<Value>> {
    Ok(match ev.plain(value) {
        Value::List(list) => list.get(index),
        Value::Tuple(tuple) => tuple.items().get(index).cloned(),
        _ => None,
    })
}

fn count(ev: &Evaluator<'_>, sequence: &Value, value: &Value) -> R {
    let (mut index, mut count) = (0, 0);
    while let Some(item) = item_at(ev, sequence, index)? {
        ev.worked(VALUE)?;
        count += i64::from(ev.equal(&item, value)?);
        index += 1;
    }
    Ok(Value::Int(count))
}

fn index(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let plain = ev.plain(&args[0]);
    let length = ev.len(&plain)?;
    let bound = |value: &Value, default: usize| match value {
        Value::Unbound => Ok(default),
        value if ev.has_index(value) => clamp_start(ev, value, length, default),
        _ => {
            let text = "slice indices must be integers or have an __index__ method";
            Err(ev.type_error(text))
        }
    };
    let (start, stop) = (bound(&args[2], 0)?, bound(&args[3], length)?);
    for index in start..stop {
        let Some(item) = item_at(ev, &plain, index)? else {
            break;
        };
        if ev.equal(&item, &args[1])? {
            return Ok(Value::Int(index as i64));
        }
    }
    let text = match plain {
        Value::List(_) => format!("{} is not in list", ev.repr(&args[1])?),
        _ => "tuple.index(x): x not in tuple".to_owned(),
    };
    Err(ev.value_error(text))
}

fn reverse(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    receiver(ev, &args[0])?.borrow_mut().reverse();
    Ok(Value::None)
}

/// `list.sort(key=…, reverse=…)`. The manual (1.2.1) also has `sort(func)`: with one parameter a key, with two a
/// comparison as in Python 2.
fn sort(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let list = receiver(ev, &args[0])?;
    let reverse = match args[3].given() {
        Some(value) => ev.truth(value)?,
        None => false,
    };
    let mut key = args[2].given().cloned();
    if let Some(function) = args[1].given().filter(|function| !function.is_none()) {
        let compares =
            matches!(function, Value::Function(function) if function.code.params.positional == 2);
        key = Some(if compares {
            ev.comparison_key(function)?
        } else {
            function.clone()
        });
    }
    // The list is empty while it is sorted, so that key functions see no half-sorted state.
    let mut items = std::mem::take(&mut *list.borrow_mut());
    let result = ev.sort(&mut items, key.as_ref(), reverse);
    let changed = !list.is_empty();
    let meanwhile = std::mem::replace(&mut *list.borrow_mut(), items);
    list.account();
    drop(meanwhile);
    result?;
    match changed {
        true => Err(ev.value_error("list modified during sort")),
        false => Ok(Value::None),
    }
}
