//! Sorting: stable, by keys, with comparisons that may run script code and fail.

use std::cmp::Ordering;
use std::rc::Rc;

use super::Builtin;
use crate::eval::Evaluator;
use crate::value::instance::Payload;
use crate::value::symbol::known;
use crate::value::{Instance, R, Str, Value};

/// Runs shorter than this are extended by insertion.
const RUN_MIN: usize = 24;

impl Evaluator<'_> {
    /// The items in order, by `key` if given. Equal items keep their order, also in reverse.
    pub fn sort(&self, items: Vec<Value>, key: Option<&Value>, reverse: bool) -> R<Vec<Value>> {
        let key = key.filter(|key| !key.is_none());
        let mut items = items;
        if reverse {
            items.reverse();
        }
        let mut sorted = match key {
            None => self.sort_plain(items)?,
            Some(key) => {
                let mut pairs = Vec::with_capacity(items.len());
                for item in items {
                    pairs.push((self.call1(key, item.clone())?, item));
                }
                let pairs = self.sort_by(pairs, |pair| &pair.0)?;
                pairs.into_iter().map(|(_, item)| item).collect()
            }
        };
        if reverse {
            sorted.reverse();
        }
        Ok(sorted)
    }

    /// A key function for a comparison function as Python 2 had it (`functools.cmp_to_key`).
    pub fn comparison_key(&self, compare: &Value) -> R {
        let compare = compare.clone();
        let less = Builtin::closure("__lt__", move |ev, args| match &*args.positional {
            [a, b] => {
                let order = ev.call(&compare, &mut [ev.plain(a), ev.plain(b)], &[])?;
                ev.less(&order, &Value::Int(0)).map(Value::Bool)
            }
            _ => Err(ev.type_error("__lt__() takes one argument")),
        });
        let class = self.make_class("K", &[], vec![(known::LT, less)])?;
        Ok(Builtin::closure("cmp_to_key", move |_, args| {
            let value = args.positional.first().cloned().unwrap_or(Value::None);
            let payload = Payload::Value(std::cell::RefCell::new(value));
            Ok(Value::Instance(Instance::new(class.clone(), payload)))
        }))
    }

    fn sort_plain(&self, items: Vec<Value>) -> R<Vec<Value>> {
        if let Some(mut numbers) = all_of(&items, |item| {
            if let Value::Int(int) = item {
                Some(*int)
            } else {
                None
            }
        }) {
            numbers.sort_unstable();
            return Ok(numbers.into_iter().map(Value::Int).collect());
        }
        self.sort_by(items, |item| item)
    }

    /// Sorts by the value `by` gives.
    fn sort_by<T>(&self, items: Vec<T>, by: impl Fn(&T) -> &Value) -> R<Vec<T>> {
        let mut items = items;
        if items.iter().all(|item| matches!(by(item), Value::Int(_))) {
            items.sort_by_key(|item| {
                if let Value::Int(int) = by(item) {
                    *int
                } else {
                    0
                }
            });
            return Ok(items);
        }
        if items
            .iter()
            .all(|item| matches!(by(item), Value::Float(float) if !float.is_nan()))
        {
            // Without NaN this is the order of numbers; zeros of both signs must count as equal.
            items.sort_by(|a, b| {
                float_of(by(a))
                    .partial_cmp(&float_of(by(b)))
                    .unwrap_or(Ordering::Equal)
            });
            return Ok(items);
        }
        if items.iter().all(|item| matches!(by(item), Value::Str(_))) {
            items.sort_by(|a, b| text_of(by(a)).cmp(text_of(by(b))));
            return Ok(items);
        }
        if have_same_columns(items.iter().map(&by)) {
            items.sort_by(|a, b| quick_order(by(a), by(b), 0).unwrap_or(Ordering::Equal));
            return Ok(items);
        }
        merge_sort(items, &mut |a, b| {
            let (a, b) = (by(a), by(b));
            match quick_order(a, b, 0) {
                Some(order) => Ok(order == Ordering::Less),
                None => {
                    self.safepoint()?;
                    self.less(a, b)
                }
            }
        })
    }
}

/// Whether all are tuples of one length whose items at each place are all integers, all text or all numbers that are
/// not NaN: then `quick_order` has an answer for any two, and the answers fit together.
fn have_same_columns<'v>(mut values: impl Iterator<Item = &'v Value>) -> bool {
    let is_simple = |item: &Value| match item {
        Value::Int(_) | Value::Str(_) => true,
        Value::Float(float) => !float.is_nan(),
        _ => false,
    };
    let Some(Value::Tuple(first)) = values.next() else {
        return false;
    };
    first.items().iter().all(is_simple)
        && values.all(|value| match value {
            Value::Tuple(tuple) => {
                let pairs = tuple.items().iter().zip(first.items());
                tuple.items().len() == first.items().len() && { pairs }.all(|(item, like)| {
                    is_simple(item) && std::mem::discriminant(item) == std::mem::discriminant(like)
                })
            }
            _ => false,
        })
}

fn all_of<T>(items: &[Value], pick: impl Fn(&Value) -> Option<T>) -> Option<Vec<T>> {
    items.iter().map(pick).collect()
}

fn float_of(value: &Value) -> f64 {
    if let Value::Float(float) = value {
        *float
    } else {
        0.0
    }
}

fn text_of(value: &Value) -> &str {
    if let Value::Str(text) = value {
        Str::as_str(text)
    } else {
        ""
    }
}

/// The order of two builtin values that needs no script code; None if it does, or if there is none.
fn quick_order(a: &Value, b: &Value, depth: u32) -> Option<Ordering> {
    match (a, b) {
        (Value::Int(a), Value::Int(b)) => Some(a.cmp(b)),
        (Value::Float(a), Value::Float(b)) => a.partial_cmp(b),
        (Value::Str(a), Value::Str(b)) => Some(a.as_str().cmp(b.as_str())),
        (Value::Tuple(a), Value::Tuple(b)) if depth < 8 => {
            if Rc::ptr_eq(a, b) {
                return Some(Ordering::Equal);
            }
            for (a, b) in a.items().iter().zip(b.items()) {
                match quick_order(a, b, depth + 1)? {
                    Ordering::Equal => {}
                    order => return Some(order),
                }
            }
            Some(a.items().len().cmp(&b.items().len()))
        }
        _ => None,
    }
}

/// A merge sort of natural runs. Unlike the standard library's it accepts comparisons that fail or contradict
/// themselves: it then ends with an error or in some order.
fn merge_sort<T>(items: Vec<T>, less: &mut impl FnMut(&T, &T) -> R<bool>) -> R<Vec<T>> {
    let mut runs: Vec<Vec<T>> = Vec::new();
    let mut rest = items.into_iter().peekable();
    while rest.peek().is_some() {
        let run = next_run(&mut rest, less)?;
        runs.push(run);
    }
    while runs.len() > 1 {
        let mut merged = Vec::with_capacity(runs.len().div_ceil(2));
        let mut pairs = runs.into_iter();
        while let Some(first) = pairs.next() {
            match pairs.next() {
                Some(second) => merged.push(merge(first, second, less)?),
                None => merged.push(first),
            }
        }
        runs = merged;
    }
    Ok(runs.pop().unwrap_or_default())
}

fn next_run<T>(
    rest: &mut std::iter::Peekable<std::vec::IntoIter<T>>,
    less: &mut impl FnMut(&T, &T) -> R<bool>,
) -> R<Vec<T>> {
    let mut run: Vec<T> = rest.next().into_iter().collect();
    let descending = match rest.peek() {
        Some(next) => less(next, &run[0])?,
        None => return Ok(run),
    };
    run.extend(rest.next());
    while let Some(next) = rest.peek() {
        let falls = less(next, &run[run.len() - 1])?;
        if falls != descending {
            break;
        }
        run.extend(rest.next());
    }
    if descending {
        // Strictly falling, so turning it around keeps equal items in order.
        run.reverse();
    }
    while run.len() < RUN_MIN {
        let Some(item) = rest.next() else { break };
        let (mut low, mut high) = (0, run.len());
        while low < high {
            let middle = usize::midpoint(low, high);
            if less(&item, &run[middle])? {
                high = middle;
            } else {
                low = middle + 1;
            }
        }
        run.insert(low, item);
    }
    Ok(run)
}

fn merge<T>(first: Vec<T>, second: Vec<T>, less: &mut impl FnMut(&T, &T) -> R<bool>) -> R<Vec<T>> {
    let mut out = Vec::with_capacity(first.len() + second.len());
    let (mut first, mut second) = (first.into_iter().peekable(), second.into_iter().peekable());
    while let (Some(a), Some(b)) = (first.peek(), second.peek()) {
        if less(b, a)? {
            out.extend(second.next());
        } else {
            out.extend(first.next());
        }
    }
    out.extend(first);
    out.extend(second);
    Ok(out)
}
