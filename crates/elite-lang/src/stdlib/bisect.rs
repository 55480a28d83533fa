//! `bisect`: places in sorted sequences.
//!
//! What is asked of the sequence and of its items, and in which order, is what CPython asks, so that sequences and keys of
//! scripts see the same calls. Nothing is borrowed while it is asked.

use super::define::Builder;
use crate::eval::Evaluator;
use crate::value::{R, Value};

/// On which side of equal items.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Left,
    Right,
}

pub(super) fn fill(module: &Builder<'_, '_>) -> R<()> {
    let signature = "a x lo? hi? * key?";
    module.functions(&[
        ("bisect_left", signature, |ev, args| {
            find(ev, args, Side::Left)
        }),
        ("bisect_right", signature, |ev, args| {
            find(ev, args, Side::Right)
        }),
        ("insort_left", signature, |ev, args| {
            insert(ev, args, Side::Left)
        }),
        ("insort_right", signature, |ev, args| {
            insert(ev, args, Side::Right)
        }),
    ]);
    module.alias("bisect", "bisect_right");
    module.alias("insort", "insort_right");
    Ok(())
}

fn find(ev: &Evaluator<'_>, args: &mut [Value], side: Side) -> R {
    let bounds = bounds(ev, args)?;
    let place = place(ev, &args[0], &args[1], bounds, key(args), side)?;
    Ok(Value::Int(place))
}

fn insert(ev: &Evaluator<'_>, args: &mut [Value], side: Side) -> R {
    let sought = match key(args) {
        Some(key) => ev.call1(key, args[1].clone())?,
        None => args[1].clone(),
    };
    let bounds = bounds(ev, args)?;
    let place = place(ev, &args[0], &sought, bounds, key(args), side)?;
    if let Value::List(list) = &args[0] {
        if args[1].holds_values() {
            ev.core.note(&args[0]);
        }
        ev.list_insert(list, place, args[1].clone())?;
        return Ok(Value::None);
    }
    let insert = ev.attribute(&args[0], ev.core.symbols.intern("insert"))?;
    ev.call(&insert, &mut [Value::Int(place), args[1].clone()], &[])?;
    Ok(Value::None)
}

fn key(args: &[Value]) -> Option<&Value> {
    args[4].given().filter(|key| !key.is_none())
}

/// The part of the sequence that is looked at.
fn bounds(ev: &Evaluator<'_>, args: &[Value]) -> R<(i64, i64)> {
    let low = args[2].given().map_or(Ok(0), |low| ev.index(low))?;
    let high = match args[3].given() {
        Some(high) if !high.is_none() => Some(ev.index(high)?),
        _ => None,
    };
    if low < 0 {
        return Err(ev.value_error("lo must be non-negative"));
    }
    match high {
        Some(high) => Ok((low, high)),
        None if matches!(args[0], Value::Dict(_)) => Err(ev.type_error("dict is not a sequence")),
        None => Ok((low, ev.len(&args[0])? as i64)),
    }
}

/// Where `sought` belongs between places `low` and `high` of a sorted sequence.
pub(super) fn place(
    ev: &Evaluator<'_>,
    sequence: &Value,
    sought: &Value,
    (mut low, mut high): (i64, i64),
    key: Option<&Value>,
    side: Side,
) -> R<i64> {
    while low < high {
        let middle = low + (high - low) / 2;
        let item = ev.item(sequence, &Value::Int(middle))?;
        let item = match key {
            Some(key) => ev.call1(key, item)?,
            None => item,
        };
        let is_before = match side {
            Side::Left => ev.less(&item, sought)?,
            Side::Right => !ev.less(sought, &item)?,
        };
        match is_before {
            true => low = middle + 1,
            false => high = middle,
        }
        ev.safepoint()?;
    }
    Ok(low)
}
