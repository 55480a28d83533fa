//! `bisect`: places in sorted sequences.
//!
//! What is asked of the sequence and of its items, and in which order, is what CPython asks, so that sequences and keys
//! of scripts see the same calls. Nothing is borrowed while it is asked.

use super::define::ModuleBuilder;
use crate::eval::Evaluator;
use crate::value::class::BuiltinBase;
use crate::value::symbol::known;
use crate::value::{R, Unwind, Value};

/// On which side of equal items.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum BisectSide {
    Left,
    Right,
}

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    let signature = "a x lo? hi? * key?";
    module.functions(&[
        ("bisect_left", signature, |ev, args| {
            find(ev, args, BisectSide::Left)
        }),
        ("bisect_right", signature, |ev, args| {
            find(ev, args, BisectSide::Right)
        }),
        ("insort_left", signature, |ev, args| {
            insert(ev, args, BisectSide::Left)
        }),
        ("insort_right", signature, |ev, args| {
            insert(ev, args, BisectSide::Right)
        }),
    ]);
    module.alias("bisect", "bisect_right");
    module.alias("insort", "insort_right");
    Ok(())
}

fn find(ev: &Evaluator<'_>, args: &mut [Value], side: BisectSide) -> R {
    let bounds = bounds(ev, args)?;
    let place = place(ev, &args[0], &args[1], bounds, key(args), side)?;
    Ok(Value::Int(place))
}

fn insert(ev: &Evaluator<'_>, args: &mut [Value], side: BisectSide) -> R {
    let sought = match key(args) {
        Some(key) => ev.call1(key, args[1].clone())?,
        None => args[1].clone(),
    };
    let bounds = bounds(ev, args)?;
    let place = place(ev, &args[0], &sought, bounds, key(args), side)?;
    if let Value::List(list) = &args[0] {
        if args[1].can_hold_values() {
            ev.core.gc_track(&args[0]);
        }
        ev.list_insert(list, place, args[1].clone())?;
        return Ok(Value::None);
    }
    let insert = ev.attribute(&args[0], ev.core.symbols.intern("insert"))?;
    ev.call(&insert, &mut [Value::Int(place), args[1].clone()], &[])?;
    Ok(Value::None)
}

fn key(args: &[Value]) -> Option<&Value> {
    args[4].if_given().filter(|key| !key.is_none())
}

/// The part of the sequence that is looked at.
fn bounds(ev: &Evaluator<'_>, args: &[Value]) -> R<(i64, i64)> {
    let low = args[2].if_given().map_or(Ok(0), |low| ev.index(low))?;
    let high = match args[3].if_given() {
        Some(high) if high.is_none() => None,
        Some(high) if !ev.has_index(high) => {
            let name = ev.core.types.name_of(high);
            let text = format!("argument should be integer or None, not '{name}'");
            return Err(ev.type_error(text));
        }
        Some(high) => Some(ev.index(high)?),
        None => None,
    };
    if low < 0 {
        return Err(ev.value_error("lo must be non-negative"));
    }
    if let (Value::List(list), None) = (&args[0], high) {
        return Ok((low, list.len() as i64));
    }
    let high = match high {
        Some(high) => high,
        None if let Some(name) = mapping(ev, &args[0]) => return Err(not_a_sequence(ev, &name)),
        None => ev.len(&args[0])? as i64,
    };
    if low < high {
        check_indexing(ev, &args[0])?;
    }
    Ok((low, high))
}

/// The full name of a type of mappings that CPython has in C: these have items by key, but none by place.
fn mapping(ev: &Evaluator<'_>, value: &Value) -> Option<String> {
    let class = ev.core.types.of(value);
    if class.base != BuiltinBase::Dict {
        return None;
    }
    let name = ev.full_name_of(class);
    let is_mapping = ["dict", "collections.OrderedDict", "collections.defaultdict"];
    is_mapping.contains(&name.as_str()).then_some(name)
}

fn not_a_sequence(ev: &Evaluator<'_>, name: &str) -> Unwind {
    ev.type_error(format!("{name} is not a sequence"))
}

fn check_indexing(ev: &Evaluator<'_>, value: &Value) -> R<()> {
    let class = ev.core.types.of(value);
    if class.lookup(known::GETITEM).is_none() {
        let name = class.name();
        return Err(ev.type_error(format!("'{name}' object does not support indexing")));
    }
    mapping(ev, value).map_or(Ok(()), |name| Err(not_a_sequence(ev, &name)))
}

/// Where `sought` belongs between places `low` and `high` of a sorted sequence.
pub(super) fn place(
    ev: &Evaluator<'_>,
    sequence: &Value,
    sought: &Value,
    (mut low, mut high): (i64, i64),
    key: Option<&Value>,
    side: BisectSide,
) -> R<i64> {
    while low < high {
        let middle = low + (high - low) / 2;
        let item = ev.item(sequence, &Value::Int(middle))?;
        let item = match key {
            Some(key) => ev.call1(key, item)?,
            None => item,
        };
        let is_before = match side {
            BisectSide::Left => ev.less(&item, sought)?,
            BisectSide::Right => !ev.less(sought, &item)?,
        };
        match is_before {
            true => low = middle + 1,
            false => high = middle,
        }
        ev.safepoint()?;
    }
    Ok(low)
}
