//! Sorting: stable, by keys, with comparisons that may run script code and fail.

use std::cmp::Ordering;
use std::rc::Rc;

use super::Builtin;
use crate::eval::Evaluator;
use crate::value::instance::Payload;
use crate::value::symbol::known;
use crate::value::{Instance, R, Value};

/// Runs shorter than this are extended by insertion.
const RUN_MIN: usize = 24;

impl Evaluator<'_> {
    /// Puts the items in order, by `key` if given. Equal items keep their order, also in reverse. After an error the
    /// items are as they were.
    pub fn sort(&self, items: &mut Vec<Value>, key: Option<&Value>, reverse: bool) -> R<()> {
        // Keys, ranks and places beside the items.
        self.check_allocation(items.len() * 3 * size_of::<Value>())?;
        let mut keys = Vec::new();
        if let Some(key) = key.filter(|key| !key.is_none()) {
            keys.reserve_exact(items.len());
            for item in &*items {
                keys.push(self.call1(key, item.clone())?);
            }
        }
        let has_keys = !keys.is_empty();
        let by = if has_keys { &keys } else { &*items };
        if !has_keys && by.iter().all(|item| matches!(item, Value::Int(_))) {
            sort_integers(items, reverse);
            return Ok(());
        }
        // Reversed twice, so that equal items keep their order.
        let places = 0..by.len() as u32;
        let order: Vec<u32> = match (Ranked::all(by), reverse) {
            (Some(ranked), _) => in_order(ranked, by, reverse),
            (None, false) => self.merge_sort_by(places.collect(), by)?,
            (None, true) => self.merge_sort_by(places.rev().collect(), by)?,
        };
        let place = |at: &u32| std::mem::take(&mut items[*at as usize]);
        let sorted: Vec<Value> = if reverse {
            order.iter().rev().map(place).collect()
        } else {
            order.iter().map(place).collect()
        };
        *items = sorted;
        Ok(())
    }

    /// The places of the values in their order, by comparisons that may run script code.
    fn merge_sort_by(&self, places: Vec<u32>, by: &[Value]) -> R<Vec<u32>> {
        merge_sort(places, &mut |a, b| {
            let (a, b) = (&by[*a as usize], &by[*b as usize]);
            match quick_order(a, b, 0) {
                Some(order) => Ok(order == Ordering::Less),
                None => {
                    self.safepoint()?;
                    self.less(a, b)
                }
            }
        })
    }

    /// A key function for a comparison function as Python 2 had it (`functools.cmp_to_key`).
    pub fn comparison_key(&self, compare: &Value) -> R {
        let held = vec![compare.clone()];
        let less = Builtin::closure("__lt__", held, |ev, held, args| {
            match (held, &*args.positional) {
                ([compare], [a, b]) => {
                    let order = ev.call(compare, &mut [ev.plain(a), ev.plain(b)], &[])?;
                    ev.less(&order, &Value::Int(0)).map(Value::Bool)
                }
                _ => Err(ev.type_error("__lt__() takes one argument")),
            }
        });
        let class = self.make_class("K", &[], vec![(known::LT, less)])?;
        let held = vec![Value::Class(class)];
        Ok(Builtin::closure("cmp_to_key", held, |ev, held, args| {
            let [Value::Class(class)] = held else {
                return Err(ev.type_error("cmp_to_key() has lost its class"));
            };
            let value = args.positional.first().cloned().unwrap_or(Value::None);
            let payload = Payload::Value(crate::value::Held::new(value));
            Ok(Value::Instance(Instance::new(class.clone(), payload)))
        }))
    }
}

fn sort_integers(items: &mut [Value], reverse: bool) {
    let mut numbers: Vec<i64> = items.iter().map(integer).collect();
    numbers.sort_unstable();
    if reverse {
        numbers.reverse();
    }
    for (item, number) in items.iter_mut().zip(numbers) {
        *item = Value::Int(number);
    }
}

fn integer(value: &Value) -> i64 {
    if let Value::Int(int) = value { *int } else { 0 }
}

/// A value to sort by, with a number that is in the same order as far as it tells them apart.
struct Ranked {
    rank: i64,
    place: u32,
}

impl Ranked {
    /// Ranks of all values, if no comparison of two of them needs script code or fails; and whether the ranks alone
    /// are their order.
    fn all(values: &[Value]) -> Option<(Vec<Ranked>, bool)> {
        let exact = match values.first()? {
            Value::Int(_) if values.iter().all(|value| matches!(value, Value::Int(_))) => true,
            Value::Float(_) if values.iter().all(is_simple_float) => true,
            Value::Str(_) if values.iter().all(|value| matches!(value, Value::Str(_))) => false,
            Value::Tuple(_) if have_same_columns(values.iter()) => false,
            _ => return None,
        };
        let ranks = values.iter().map(rank).zip(0..);
        let ranked = ranks.map(|(rank, place)| Ranked { rank, place });
        Some((ranked.collect(), exact))
    }
}

/// The rank of a value of which `Ranked::all` approves.
fn rank(value: &Value) -> i64 {
    match value {
        Value::Int(int) => *int,
        Value::Float(float) => {
            // Zeros of both signs are equal; the bits of the others are in order once the negative ones are turned.
            let bits = if *float == 0.0 {
                0
            } else {
                float.to_bits() as i64
            };
            bits ^ ((bits >> 63) as u64 >> 1) as i64
        }
        Value::Str(text) => {
            let text = text.as_str().as_bytes();
            let mut first = [0; 8];
            let length = text.len().min(8);
            first[..length].copy_from_slice(&text[..length]);
            (u64::from_be_bytes(first) ^ (1 << 63)) as i64
        }
        Value::Tuple(tuple) => tuple.items().first().map_or(0, rank),
        _ => 0,
    }
}

/// The places of `values` in their order, equal ones as they stand; from the last to the first if `reverse`.
fn in_order(ranked: (Vec<Ranked>, bool), values: &[Value], reverse: bool) -> Vec<u32> {
    let (mut ranked, exact) = ranked;
    let tie = |a: &Ranked, b: &Ranked| {
        let order = a.place.cmp(&b.place);
        if reverse { order.reverse() } else { order }
    };
    if exact {
        ranked.sort_unstable_by(|a, b| a.rank.cmp(&b.rank).then_with(|| tie(a, b)));
    } else {
        ranked.sort_unstable_by(|a, b| {
            let by_value = || {
                let (a, b) = (&values[a.place as usize], &values[b.place as usize]);
                quick_order(a, b, 0).unwrap_or(Ordering::Equal)
            };
            let order = a.rank.cmp(&b.rank).then_with(by_value);
            order.then_with(|| tie(a, b))
        });
    }
    ranked.into_iter().map(|ranked| ranked.place).collect()
}

fn is_simple_float(value: &Value) -> bool {
    matches!(value, Value::Float(float) if !float.is_nan())
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
