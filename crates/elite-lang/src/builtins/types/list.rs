//! `list` and `tuple`.

use std::rc::Rc;

use super::{constructor, insertion_place, methods, wrong_receiver};
use crate::errors::ExceptionKind;
use crate::eval::{Evaluator, InterpreterState};
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::{Iter, List, R, Value, ValueVec};

pub(super) fn install(core: &Rc<InterpreterState>) {
    let types = &core.types;
    constructor(core, &types.list, "iterable? /", |ev, args| {
        match args[0].if_given() {
            None => Ok(Value::list(Vec::new())),
            Some(iterable) => ev.collect(iterable).map(ValueVec::into_list),
        }
    });
    constructor(core, &types.tuple, "iterable? /", |ev, args| {
        match args[0].if_given() {
            None => Ok(Value::tuple(Vec::new())),
            Some(tuple @ Value::Tuple(_)) => Ok(tuple.clone()),
            Some(iterable) => ev.collect(iterable).map(ValueVec::into_tuple),
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
                let list = receiver(ev, &args[0])?;
                ev.collect(&Value::List(list)).map(ValueVec::into_list)
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
        other => match ev.unwrap_builtin(other) {
            Value::List(list) => Ok(list),
            other => Err(wrong_receiver(ev, "list", &other)),
        },
    }
}

fn init(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let list = receiver(ev, &args[0])?;
    drop(ValueVec::from(list.replace_all(Vec::new())));
    if let Some(iterable) = args[1].if_given() {
        ev.list_extend(&list, iterable)?;
    }
    Ok(Value::None)
}

fn append(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let item = std::mem::take(&mut args[1]);
    match &args[0] {
        Value::List(list) => {
            ev.grow_list(list, 1)?;
            list.push(item);
        }
        other => {
            let list = receiver(ev, other)?;
            ev.grow_list(&list, 1)?;
            list.push(item);
        }
    }
    Ok(Value::None)
}

fn extend(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let list = receiver(ev, &args[0])?;
    ev.list_extend(&list, &args[1])?;
    Ok(Value::None)
}

impl Evaluator<'_> {
    /// `list.extend(iterable)`. What script code gives item by item is appended item by item, as it sees.
    pub fn list_extend(&self, list: &Rc<List>, iterable: &Value) -> R<()> {
        // Itself, behind an instance of a subclass, gives what it holds now.
        let is_itself = |value: &Value| {
            matches!(self.unwrap_builtin(value), Value::List(other) if Rc::ptr_eq(&other,
            list))
        };
        let runs_code = matches!(
            iterable,
            Value::Instance(_) | Value::Generator(_) | Value::Iter(_) | Value::Class(_)
        );
        if runs_code && !is_itself(iterable) {
            let iterator = self.iter(iterable)?;
            // CPython asks how much room to make; the answer means nothing here.
            self.ask_length(iterable)?;
            while let Some(item) = self.next_at_safepoint(&iterator)? {
                self.grow_list(list, 1)?;
                list.push(item);
            }
            return Ok(());
        }
        let items = match is_itself(iterable) {
            true => self.collect(&Value::List(list.clone()))?,
            false => self.collect(iterable)?,
        };
        if list.is_empty() {
            drop(ValueVec::from(list.replace_all(items.into())));
            return Ok(());
        }
        self.grow_list(list, items.len())?;
        list.change(|old| old.extend(items));
        Ok(())
    }

    /// Puts an item before number `index`, which may count from the end or lie outside.
    pub fn list_insert(&self, list: &List, index: i64, item: Value) -> R<()> {
        self.grow_list(list, 1)?;
        list.change(|items| items.insert(super::insertion_place(index, items.len()), item));
        Ok(())
    }

    /// Takes out item number `index`, which may count from the end; None if there is none.
    pub fn list_remove(&self, list: &List, index: i64) -> Option<Value> {
        list.change(|items| Some(items.remove(self.place(index, items.len())?)))
    }
}

fn insert(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let list = receiver(ev, &args[0])?;
    let index = ev.index(&args[1])?;
    let item = std::mem::take(&mut args[2]);
    ev.list_insert(&list, index, item)?;
    Ok(Value::None)
}

fn pop(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let list = receiver(ev, &args[0])?;
    let error = |text: &str| Err(ev.raise(ExceptionKind::IndexError, text));
    let Some(index) = args[1].if_given() else {
        let last = list.change(Vec::pop);
        return last.map_or_else(|| error("pop from empty list"), Ok);
    };
    let index = ev.index(index)?;
    match ev.list_remove(&list, index) {
        Some(item) => Ok(item),
        None if list.is_empty() => error("pop from empty list"),
        None => error("pop index out of range"),
    }
}

fn remove(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let list = receiver(ev, &args[0])?;
    let mut index = 0;
    while let Some(item) = list.get(index) {
        ev.charge(WORK_PER_VALUE)?;
        if ev.equal(&item, &args[1])? {
            // The comparison may have changed the list.
            drop(ev.list_remove(&list, index as i64));
            return Ok(Value::None);
        }
        index += 1;
    }
    Err(ev.value_error("list.remove(x): x not in list"))
}

fn clear(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let list = receiver(ev, &args[0])?;
    drop(ValueVec::from(list.replace_all(Vec::new())));
    Ok(Value::None)
}

/// Items of a list or tuple, one by one.
fn item_at(ev: &Evaluator<'_>, value: &Value, index: usize) -> R<Option<Value>> {
    Ok(match ev.unwrap_builtin(value) {
        Value::List(list) => list.get(index),
        Value::Tuple(tuple) => tuple.items().get(index).cloned(),
        _ => None,
    })
}

fn count(ev: &Evaluator<'_>, sequence: &Value, value: &Value) -> R {
    let (mut index, mut count) = (0, 0);
    while let Some(item) = item_at(ev, sequence, index)? {
        ev.charge(WORK_PER_VALUE)?;
        count += i64::from(ev.equal(&item, value)?);
        index += 1;
    }
    Ok(Value::Int(count))
}

fn index(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let plain = ev.unwrap_builtin(&args[0]);
    let bound = |value: &Value, default: i64| match value {
        Value::Unbound => Ok(default),
        value if ev.has_index(value) => ev.clamped_index(value),
        _ => {
            let text = "slice indices must be integers or have an __index__ method";
            Err(ev.type_error(text))
        }
    };
    let (start, stop) = (bound(&args[2], 0)?, bound(&args[3], i64::MAX)?);
    let length = ev.len(&plain)?;
    // The end is where the sequence ends by then, which comparing may change.
    let end = match stop < 0 {
        true => insertion_place(stop, length),
        false => usize::try_from(stop).unwrap_or(usize::MAX),
    };
    for index in insertion_place(start, length)..end {
        let Some(item) = item_at(ev, &plain, index)? else {
            break;
        };
        ev.charge(WORK_PER_VALUE)?;
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
    let list = receiver(ev, &args[0])?;
    list.change(|items| items.reverse());
    Ok(Value::None)
}

/// `list.sort(key=…, reverse=…)`. The manual (1.2.1) also has `sort(func)`: with one parameter a key, with two a
/// comparison as in Python 2.
fn sort(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let list = receiver(ev, &args[0])?;
    let reverse = match args[3].if_given() {
        Some(value) => ev.c_int(value)? != 0,
        None => false,
    };
    let mut key = args[2].if_given().cloned();
    if let Some(function) = args[1].if_given().filter(|function| !function.is_none()) {
        let compares =
            matches!(function, Value::Function(function) if function.code.params.positional == 2);
        key = Some(if compares {
            ev.comparison_key(function)?
        } else {
            function.clone()
        });
    }
    // The list is empty while it is sorted, so that key functions see no half-sorted state.
    let mut items = list.change(std::mem::take);
    let result = ev.sort(&mut items, key.as_ref(), reverse);
    let changed = !list.is_empty();
    drop(ValueVec::from(list.replace_all(items)));
    result?;
    match changed {
        true => Err(ev.value_error("list modified during sort")),
        false => Ok(Value::None),
    }
}
