//! Sorting: stable, by keys, with comparisons that may run script code and fail.

use std::cmp::Ordering;
use std::rc::Rc;

use elite_syntax::ast::CompareOp;
use elite_syntax::surrogate::may_have_surrogates;

use super::{Builtin, runs};
use crate::eval::Evaluator;
use crate::limits::chunked::{BULK_CHUNK, bulk_work};
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::instance::InstancePayload;
use crate::value::symbol::known;
use crate::value::{Instance, R, Symbol, Value, ValueVec};

/// Items that are sorted, merged or moved between two safepoints.
const SORT_CHUNK: usize = if cfg!(debug_assertions) { 256 } else { 4096 };
/// Longer texts are compared in pieces.
const COMPARE_INLINE_BYTES_MAX: usize = 256;
/// Longer tuples are compared item by item.
const COLUMNS_MAX: usize = 16;

impl Evaluator<'_> {
    /// Puts the items in order, by `key` if given. Equal items keep their order, also in reverse. After an error of a
    /// key the items are as they were, after one of a comparison where they had come to.
    pub fn sort(&self, items: &mut Vec<Value>, key: Option<&Value>, reverse: bool) -> R<()> {
        // Keys, ranks and places beside the items.
        self.check_allocation(items.len() * 3 * size_of::<Value>())?;
        let mut keys = ValueVec::default();
        if let Some(key) = key.filter(|key| !key.is_none()) {
            keys.reserve_exact(items.len());
            for item in &*items {
                self.safepoint()?;
                keys.push(self.call1(key, item.clone())?);
            }
        }
        let has_keys = !keys.is_empty();
        let by = if has_keys { &keys } else { &*items };
        if !has_keys && self.all_values(by, |item| matches!(item, Value::Int(_)))? {
            return self.sort_integers(items, reverse);
        }
        // Reversed twice, so that equal items keep their order.
        let (order, result) = match self.rank_all(by)? {
            Some(ranked) => (self.in_order(ranked, by, reverse)?, Ok(())),
            None => {
                let mut order: Vec<u32> = (0..by.len() as u32).collect();
                if reverse {
                    order.reverse();
                }
                let result = self.sort_by_comparing(&mut order, by);
                (order, result)
            }
        };
        let mut sorted = ValueVec::from(Vec::with_capacity(order.len()));
        for number in 0..order.len() {
            let at = order[if reverse {
                order.len() - 1 - number
            } else {
                number
            }];
            sorted.push(items[at as usize].clone());
            self.charge(WORK_PER_VALUE)?;
        }
        // The items as they were go bit by bit.
        std::mem::swap(items, &mut sorted);
        result
    }

    fn all_values(&self, values: &[Value], test: impl Fn(&Value) -> bool) -> R<bool> {
        for some in values.chunks(SORT_CHUNK) {
            if !some.iter().all(&test) {
                return Ok(false);
            }
            self.charge(some.len() * WORK_PER_VALUE / 2)?;
        }
        Ok(true)
    }

    fn sort_integers(&self, items: &mut [Value], reverse: bool) -> R<()> {
        let mut numbers: Vec<i64> = Vec::with_capacity(items.len());
        for some in items.chunks(SORT_CHUNK) {
            numbers.extend(some.iter().map(integer));
            self.charge(some.len() * WORK_PER_VALUE / 2)?;
        }
        let numbers = self.merge_sort(numbers, i64::cmp)?;
        for (some, first) in items.chunks_mut(SORT_CHUNK).zip((0..).step_by(SORT_CHUNK)) {
            for (item, number) in some.iter_mut().zip(first..) {
                let number = if reverse {
                    numbers.len() - 1 - number
                } else {
                    number
                };
                *item = Value::Int(numbers[number]);
            }
            self.charge(some.len() * WORK_PER_VALUE / 2)?;
        }
        Ok(())
    }

    /// Sorts what can be compared without running code of the script, in pieces that are merged.
    fn merge_sort<T: Copy>(
        &self,
        mut items: Vec<T>,
        order: impl Fn(&T, &T) -> Ordering,
    ) -> R<Vec<T>> {
        for some in items.chunks_mut(SORT_CHUNK) {
            some.sort_unstable_by(&order);
            self.charge(some.len() * SORT_CHUNK.ilog2() as usize * 2)?;
        }
        let mut width = SORT_CHUNK;
        let mut merged: Vec<T> = Vec::new();
        while width < items.len() {
            merged.clear();
            merged.reserve_exact(items.len());
            for pair in items.chunks(2 * width) {
                let (mut low, mut high) = pair.split_at(width.min(pair.len()));
                let apart = |low: &[T], high: &[T]| match (low.last(), high.first()) {
                    (Some(last), Some(first)) => order(last, first).is_le(),
                    _ => true,
                };
                while !apart(low, high) {
                    for _ in 0..SORT_CHUNK.min(low.len() + high.len()) {
                        let (Some(a), Some(b)) = (low.first(), high.first()) else {
                            break;
                        };
                        if order(b, a).is_lt() {
                            merged.push(*b);
                            high = &high[1..];
                        } else {
                            merged.push(*a);
                            low = &low[1..];
                        }
                    }
                    self.charge(SORT_CHUNK * WORK_PER_VALUE / 2)?;
                }
                for some in low.chunks(SORT_CHUNK).chain(high.chunks(SORT_CHUNK)) {
                    merged.extend_from_slice(some);
                    self.charge(some.len())?;
                }
            }
            std::mem::swap(&mut items, &mut merged);
            width *= 2;
        }
        Ok(items)
    }

    /// Ranks of all values, if no comparison of two of them needs script code, fails or takes long; and whether the
    /// ranks alone are their order.
    fn rank_all(&self, values: &[Value]) -> R<Option<(Vec<RankedItem>, bool)>> {
        let is_short_text = |value: &Value| match value {
            Value::Str(text) if text.as_str().len() <= COMPARE_INLINE_BYTES_MAX => {
                // Surrogates lie elsewhere than where they are in the order.
                text.is_ascii() || !may_have_surrogates(text.as_str())
            }
            _ => false,
        };
        let exact = match values.first() {
            Some(Value::Int(_)) if self.all_values(values, |v| matches!(v, Value::Int(_)))? => true,
            Some(Value::Float(_)) if self.all_values(values, is_simple_float)? => true,
            Some(Value::Str(_)) if self.all_values(values, is_short_text)? => false,
            Some(first @ Value::Tuple(_)) if is_simple_row(first) => {
                if !self.all_values(values, |value| have_same_columns(first, value))? {
                    return Ok(None);
                }
                false
            }
            _ => return Ok(None),
        };
        let mut ranked = Vec::with_capacity(values.len());
        for some in values.chunks(SORT_CHUNK) {
            let places = ranked.len() as u32..;
            let ranks = some.iter().map(rank).zip(places);
            ranked.extend(ranks.map(|(rank, place)| RankedItem { rank, place }));
            self.charge(some.len() * WORK_PER_VALUE)?;
        }
        Ok(Some((ranked, exact)))
    }

    /// The places of `values` in their order, equal ones as they stand; from the last to the first if `reverse`.
    fn in_order(
        &self,
        ranked: (Vec<RankedItem>, bool),
        values: &[Value],
        reverse: bool,
    ) -> R<Vec<u32>> {
        let (ranked, exact) = ranked;
        let tie = |a: &RankedItem, b: &RankedItem| {
            let order = a.place.cmp(&b.place);
            if reverse { order.reverse() } else { order }
        };
        let ranked = if exact {
            self.merge_sort(ranked, |a, b| a.rank.cmp(&b.rank).then_with(|| tie(a, b)))?
        } else {
            self.merge_sort(ranked, |a, b| {
                let by_value = || {
                    let (a, b) = (&values[a.place as usize], &values[b.place as usize]);
                    quick_order(a, b, 0).unwrap_or(Ordering::Equal)
                };
                let order = a.rank.cmp(&b.rank).then_with(by_value);
                order.then_with(|| tie(a, b))
            })?
        };
        let mut places = Vec::with_capacity(ranked.len());
        for some in ranked.chunks(SORT_CHUNK) {
            places.extend(some.iter().map(|ranked| ranked.place));
            self.charge(some.len())?;
        }
        Ok(places)
    }

    /// Puts the places of values in order by comparisons that may run script code.
    fn sort_by_comparing(&self, places: &mut [u32], by: &[Value]) -> R<()> {
        runs::sort(places, |a, b| {
            let (a, b) = (&by[*a as usize], &by[*b as usize]);
            self.charge(2 * WORK_PER_VALUE)?;
            if let (Value::Str(a), Value::Str(b)) = (a, b)
                && !may_have_surrogates(a.as_str())
                && !may_have_surrogates(b.as_str())
            {
                let (a, b) = (a.as_str().as_bytes(), b.as_str().as_bytes());
                self.charge(bulk_work(a.len().min(b.len()).min(BULK_CHUNK)))?;
                return Ok(self.cmp_bytes(a, b)?.is_lt());
            }
            match quick_order(a, b, 0) {
                Some(order) if !matches!(a, Value::Str(_)) => Ok(order == Ordering::Less),
                _ => {
                    self.safepoint()?;
                    self.less(a, b)
                }
            }
        })
    }

    /// A key function for a comparison function as Python 2 had it (`functools.cmp_to_key`).
    pub fn comparison_key(&self, compare: &Value) -> R {
        let mut attrs = vec![(known::HASH, Value::None)];
        for (name, symbol, op) in COMPARISONS {
            let held = vec![compare.clone()];
            let method = Builtin::closure(name, held, move |ev, held, args| {
                let ([compare], [a, b]) = (held, &*args.positional) else {
                    return Err(ev.type_error(format!("{name}() takes one argument")));
                };
                let (Some(a), Some(b)) = (cmp_key_value(ev, a), cmp_key_value(ev, b)) else {
                    return Err(ev.type_error("other argument must be K instance"));
                };
                let order = ev.call(compare, &mut [a, b], &[])?;
                ev.compare(*op, &order, &Value::Int(0))
            });
            attrs.push((*symbol, method));
        }
        let class = self.make_class(KEY, &[], attrs)?;
        class.set(known::MODULE, Value::str("functools"));
        class.is_c_type.set(true);
        let held = vec![Value::Class(class)];
        Ok(Builtin::closure("cmp_to_key", held, |ev, held, args| {
            let ([Value::Class(class)], [value]) = (held, &*args.positional) else {
                return Err(ev.type_error("K() missing required argument 'obj' (pos 1)"));
            };
            let key = Value::Instance(Instance::new(class.clone(), InstancePayload::None));
            ev.set_attribute(&key, ev.core.symbols.intern("obj"), value.clone())?;
            Ok(key)
        }))
    }
}

/// The name of the class of the keys.
const KEY: &str = "KeyWrapper";

const COMPARISONS: &[(&str, Symbol, CompareOp)] = &[
    ("__lt__", known::LT, CompareOp::Lt),
    ("__le__", known::LE, CompareOp::Le),
    ("__gt__", known::GT, CompareOp::Gt),
    ("__ge__", known::GE, CompareOp::Ge),
    ("__eq__", known::EQ, CompareOp::Eq),
];

/// What a key of `cmp_to_key` stands for.
fn cmp_key_value(ev: &Evaluator<'_>, key: &Value) -> Option<Value> {
    match key {
        Value::Instance(instance) if *instance.class.name() == *KEY => {
            let symbols = &ev.core.symbols;
            instance.get(symbols.intern("obj"), symbols)
        }
        _ => None,
    }
}

fn integer(value: &Value) -> i64 {
    if let Value::Int(int) = value { *int } else { 0 }
}

/// A value to sort by, with a number that is in the same order as far as it tells them apart.
#[derive(Clone, Copy)]
struct RankedItem {
    rank: i64,
    place: u32,
}

/// The rank of a value of which `rank_all` approves.
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

fn is_simple_float(value: &Value) -> bool {
    matches!(value, Value::Float(float) if !float.is_nan())
}

/// Whether a value is a tuple of a few integers, short texts and numbers that are not NaN.
fn is_simple_row(value: &Value) -> bool {
    let is_simple = |item: &Value| match item {
        Value::Int(_) => true,
        Value::Str(text) => text.as_str().len() <= COMPARE_INLINE_BYTES_MAX,
        Value::Float(float) => !float.is_nan(),
        _ => false,
    };
    match value {
        Value::Tuple(tuple) => {
            tuple.items().len() <= COLUMNS_MAX && tuple.items().iter().all(is_simple)
        }
        _ => false,
    }
}

/// Whether two such tuples have items of the same kinds at each place: then `quick_order` has an answer for any two of
/// them, and the answers fit together.
fn have_same_columns(first: &Value, other: &Value) -> bool {
    match (first, other) {
        (Value::Tuple(first), Value::Tuple(tuple)) => {
            let mut pairs = first.items().iter().zip(tuple.items());
            is_simple_row(other)
                && first.items().len() == tuple.items().len()
                && pairs.all(|(a, b)| std::mem::discriminant(a) == std::mem::discriminant(b))
        }
        _ => false,
    }
}

/// The order of two builtin values that needs no script code; None if it does, or if there is none.
fn quick_order(a: &Value, b: &Value, depth: u32) -> Option<Ordering> {
    match (a, b) {
        (Value::Int(a), Value::Int(b)) => Some(a.cmp(b)),
        (Value::Float(a), Value::Float(b)) => a.partial_cmp(b),
        (Value::Str(a), Value::Str(b)) => {
            let (a, b) = (a.as_str(), b.as_str());
            (a.len().min(b.len()) <= BULK_CHUNK / COLUMNS_MAX).then(|| a.cmp(b))
        }
        (Value::Tuple(a), Value::Tuple(b)) if depth < 2 => {
            if Rc::ptr_eq(a, b) {
                return Some(Ordering::Equal);
            }
            if a.items().len().min(b.items().len()) > COLUMNS_MAX {
                return None;
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
