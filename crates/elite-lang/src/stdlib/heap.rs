//! `_heapq`: heaps in lists, whose smallest item is item 0 and whose item i is at most items 2 i + 1 and 2 i + 2.
//!
//! The items that are compared, their order, and the list as it is meanwhile are CPython's, so that items
//! of scripts see the same. Where all comparisons are of numbers, short texts and tuples of them, nobody can look
//! meanwhile, and an item is moved to its place at once.

use std::rc::Rc;

use elite_syntax::ast::CompareOp;
use elite_syntax::surrogate::may_have_surrogates;

use super::define::ModuleBuilder;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::ops::compare::fast;
use crate::ops::hash::{Equality, quick_equal};
use crate::value::{List, R, Value};

/// Work to find the place of one item in a heap of any size.
const PLACE: usize = 64 * WORK_PER_VALUE;
/// Levels of the largest heap.
const LEVELS: usize = 64;
/// Longest text that is compared at once, in bytes, and longest tuple.
const TEXT: usize = 256;
const TUPLE: usize = 8;

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    module.functions(&[
        ("heappush", "heap item /", |ev, args| {
            let list = heap(ev, &args[0], "heappush() argument 1")?;
            ev.charge(PLACE)?;
            let item = std::mem::take(&mut args[1]);
            push(ev, &args[0], &list, item)
        }),
        ("heappop", "heap /", |ev, args| {
            let list = heap(ev, &args[0], "heappop() argument")?;
            ev.charge(PLACE)?;
            pop(ev, &list)
        }),
        ("heapreplace", "heap item /", |ev, args| {
            let list = heap(ev, &args[0], "heapreplace() argument 1")?;
            ev.charge(PLACE)?;
            let item = std::mem::take(&mut args[1]);
            replace(ev, &args[0], &list, item)
        }),
        ("heappushpop", "heap item /", |ev, args| {
            let list = heap(ev, &args[0], "heappushpop() argument 1")?;
            ev.charge(PLACE)?;
            let item = std::mem::take(&mut args[1]);
            let Some(first) = list.get(0) else {
                return Ok(item);
            };
            match ev.less(&first, &item)? {
                true => replace(ev, &args[0], &list, item),
                false => Ok(item),
            }
        }),
        ("heapify", "heap /", |ev, args| {
            let list = heap(ev, &args[0], "heapify() argument")?;
            let length = list.len();
            for place in (0..length / 2).rev() {
                ev.charge(PLACE)?;
                if list.len() != length {
                    return Err(size_changed_error(ev));
                }
                sink(ev, &list, place)?;
            }
            Ok(Value::None)
        }),
    ]);
    Ok(())
}

/// The list that an argument is, or extends.
fn heap(ev: &Evaluator<'_>, value: &Value, what: &str) -> R<Rc<List>> {
    match ev.unwrap_builtin(value) {
        Value::List(list) => Ok(list),
        _ => {
            let name = ev.core.types.name_of(value);
            Err(ev.type_error(format!("{what} must be list, not {name}")))
        }
    }
}

fn size_changed_error(ev: &Evaluator<'_>) -> crate::value::Unwind {
    let text = "list changed size during iteration";
    ev.raise(ExceptionKind::RuntimeError, text)
}

fn push(ev: &Evaluator<'_>, heap: &Value, list: &Rc<List>, item: Value) -> R {
    if item.can_hold_values() {
        ev.core.gc_track(heap);
    }
    ev.grow_list(list, 1)?;
    list.push(item);
    rise(ev, list, 0, list.len() - 1)?;
    Ok(Value::None)
}

fn pop(ev: &Evaluator<'_>, list: &Rc<List>) -> R {
    let taken = list.change(|items| {
        let last = items.pop()?;
        Some(match items.first_mut() {
            Some(first) => (std::mem::replace(first, last), true),
            None => (last, false),
        })
    });
    let Some((first, more)) = taken else {
        return Err(ev.raise(ExceptionKind::IndexError, "index out of range"));
    };
    if more {
        sink(ev, list, 0)?;
    }
    Ok(first)
}

fn replace(ev: &Evaluator<'_>, heap: &Value, list: &Rc<List>, item: Value) -> R {
    if item.can_hold_values() {
        ev.core.gc_track(heap);
    }
    match list.replace(0, item) {
        Ok(first) => {
            sink(ev, list, 0)?;
            Ok(first)
        }
        Err(_) => Err(ev.raise(ExceptionKind::IndexError, "index out of range")),
    }
}

/// Moves an item towards the front, up to `start`, until its parent is not greater.
fn rise(ev: &Evaluator<'_>, list: &List, start: usize, mut place: usize) -> R<()> {
    if list.change(|items| rise_at_once(items, start, place)) {
        return Ok(());
    }
    while place > start {
        let parent = (place - 1) / 2;
        if !is_less(ev, list, place, parent)? {
            break;
        }
        list.change(|items| items.swap(place, parent));
        place = parent;
    }
    Ok(())
}

/// Moves an item to the bottom along the smaller ones below it, then up again to its place: that takes fewer
/// comparisons than to stop on the way.
fn sink(ev: &Evaluator<'_>, list: &List, start: usize) -> R<()> {
    if list.change(|items| sink_at_once(items, start)) {
        return Ok(());
    }
    let (end, mut place) = (list.len(), start);
    while place < end / 2 {
        let mut child = 2 * place + 1;
        if child + 1 < end && !is_less(ev, list, child, child + 1)? {
            child += 1;
        }
        list.change(|items| items.swap(place, child));
        place = child;
    }
    rise(ev, list, start, place)
}

/// Whether item `a` is less than item `b`. Afterwards the list is as long as before.
fn is_less(ev: &Evaluator<'_>, list: &List, a: usize, b: usize) -> R<bool> {
    let length = list.len();
    let (Some(first), Some(second)) = (list.get(a), list.get(b)) else {
        return Err(size_changed_error(ev));
    };
    let less = ev.less(&first, &second)?;
    match list.len() == length {
        true => Ok(less),
        false => Err(size_changed_error(ev)),
    }
}

/// Whether `a` is less than `b`, if that takes no code of a script, is no error and is soon said.
fn quick_less(a: &Value, b: &Value) -> Option<bool> {
    match (a, b) {
        (Value::Tuple(a), Value::Tuple(b)) => {
            let (a, b) = (a.items(), b.items());
            if a.len().max(b.len()) > TUPLE {
                return None;
            }
            for (a, b) in a.iter().zip(b) {
                let (Value::Int(_) | Value::Float(_) | Value::Str(_)) = a else {
                    return None;
                };
                match quick_equal(a, b) {
                    Equality::Yes => {}
                    Equality::No => return quick_item_less(a, b),
                    Equality::Ask => return None,
                }
            }
            Some(a.len() < b.len())
        }
        _ => quick_item_less(a, b),
    }
}

#[inline(always)]
fn quick_item_less(a: &Value, b: &Value) -> Option<bool> {
    if let (Value::Str(a), Value::Str(b)) = (a, b) {
        let (a, b) = (a.as_str(), b.as_str());
        let is_short = a.len() <= TEXT && b.len() <= TEXT;
        return (is_short && !may_have_surrogates(a) && !may_have_surrogates(b)).then(|| a < b);
    }
    fast(CompareOp::Lt, a, b)
}

/// `rise` at once; false, and nothing is changed, if a comparison takes more than that.
fn rise_at_once(items: &mut [Value], start: usize, place: usize) -> bool {
    let Some(item) = items.get(place) else {
        return true;
    };
    let mut to = place;
    while to > start {
        match quick_less(item, &items[(to - 1) / 2]) {
            Some(true) => to = (to - 1) / 2,
            Some(false) => break,
            None => return false,
        }
    }
    let mut from = place;
    while from > to {
        let parent = (from - 1) / 2;
        items.swap(from, parent);
        from = parent;
    }
    true
}

/// `sink` at once; false, and nothing is changed, if a comparison takes more than that.
fn sink_at_once(items: &mut [Value], start: usize) -> bool {
    let mut path = [0; LEVELS];
    let (mut depth, mut place) = (0, start);
    while place < items.len() / 2 && depth < LEVELS {
        let mut child = 2 * place + 1;
        if child + 1 < items.len() {
            match quick_less(&items[child], &items[child + 1]) {
                Some(true) => {}
                Some(false) => child += 1,
                None => return false,
            }
        }
        path[depth] = child;
        (depth, place) = (depth + 1, child);
    }
    // Up again to the first one on the way that is not greater.
    while depth > 0 {
        match quick_less(&items[start], &items[path[depth - 1]]) {
            Some(true) => depth -= 1,
            Some(false) => break,
            None => return false,
        }
    }
    let mut from = start;
    for to in &path[..depth] {
        items.swap(from, *to);
        from = *to;
    }
    true
}

/// `heappush` where there is room and everything is compared at once.
pub fn push_at_once(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    let [Value::List(list), item] = args else {
        return None;
    };
    if item.can_hold_values() && !list.gc_tracked.get() || !list.push_within((*item).clone()) {
        return None;
    }
    let undone = list.change(|items| {
        let last = items.len() - 1;
        match rise_at_once(items, 0, last) {
            true => None,
            false => items.pop(),
        }
    });
    undone.is_none().then_some(Value::None)
}

/// `heappop` where everything is compared at once.
pub fn pop_at_once(_: &Evaluator<'_>, args: &[&Value]) -> Option<Value> {
    let [Value::List(list)] = args else {
        return None;
    };
    list.change(|items| {
        let last = items.pop()?;
        if items.is_empty() {
            return Some(last);
        }
        let first = std::mem::replace(&mut items[0], last);
        if sink_at_once(items, 0) {
            return Some(first);
        }
        let last = std::mem::replace(&mut items[0], first);
        // There is room: the item was the last one.
        items.push(last);
        None
    })
}
