//! Searches in `bytes` and `bytearray`: where a part is, how often, at the beginning, at the end. They read the bytes
//! where they lie; what runs code of the script (bounds, parts) is asked before.

use std::rc::Rc;

use super::bounds::SearchBounds;
use super::wrong_receiver;
use crate::eval::Evaluator;
use crate::limits::chunked::WORK_PER_BYTE;
use crate::ops::search::Occurrences;
use crate::value::bytes::BytesRef;
use crate::value::{R, Value};

/// The end of the bytes at which a search begins.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum SearchEnd {
    Left,
    Right,
}

/// `find` and `rfind`; with `required`, `index` and `rindex`.
pub fn find(ev: &Evaluator<'_>, args: &[Value], side: SearchEnd, required: bool) -> R {
    let bounds = SearchBounds::read(ev, &args[2], &args[3])?;
    let part = part(ev, &args[1])?;
    let data = receiver_bytes(ev, &args[0])?;
    let Some((from, to)) = bounds.resolve(data.len()) else {
        return not_found(ev, required);
    };
    let data = &data[from.min(data.len())..to];
    let found = match side {
        SearchEnd::Left => ev.find_bytes(data, &part)?,
        SearchEnd::Right => ev.rfind_bytes(data, &part)?,
    };
    match found {
        Some(at) => Ok(Value::Int((from + at) as i64)),
        None => not_found(ev, required),
    }
}

fn not_found(ev: &Evaluator<'_>, required: bool) -> R {
    if required {
        return Err(ev.value_error("subsection not found"));
    }
    Ok(Value::Int(-1))
}

/// `count`
pub fn count(ev: &Evaluator<'_>, args: &[Value]) -> R {
    let bounds = SearchBounds::read(ev, &args[2], &args[3])?;
    let part = part(ev, &args[1])?;
    let data = receiver_bytes(ev, &args[0])?;
    let Some((from, to)) = bounds.resolve(data.len()) else {
        return Ok(Value::Int(0));
    };
    let data = &data[from.min(data.len())..to];
    let count = match part.len() {
        0 => data.len() + 1,
        _ => Occurrences::new(data, &part).count(ev)?,
    };
    Ok(Value::Int(count as i64))
}

/// `startswith` and `endswith`
pub fn affix(ev: &Evaluator<'_>, args: &[Value], side: SearchEnd) -> R {
    let bounds = SearchBounds::read(ev, &args[2], &args[3])?;
    let parts = match &ev.unwrap_builtin(&args[1]) {
        Value::Tuple(parts) => parts.items().iter().map(|part| ev.bytes(part)).collect(),
        _ => match ev.bytes_like(&args[1]) {
            Some(part) => Ok(vec![part]),
            None => {
                let name = if side == SearchEnd::Left {
                    "startswith"
                } else {
                    "endswith"
                };
                let given = ev.core.types.name_of(&args[1]);
                Err(ev.type_error(format!(
                    "{name} first arg must be bytes or a tuple of bytes, not {given}"
                )))
            }
        },
    };
    let parts: Vec<BytesRef> = parts?;
    let data = receiver_bytes(ev, &args[0])?;
    let Some((from, to)) = bounds.resolve(data.len()) else {
        return Ok(Value::Bool(false));
    };
    let data = &data[from.min(data.len())..to];
    for part in parts {
        ev.charge(WORK_PER_BYTE)?;
        let Some(rest) = data.len().checked_sub(part.len()) else {
            continue;
        };
        let place = match side {
            SearchEnd::Left => &data[..part.len()],
            SearchEnd::Right => &data[rest..],
        };
        if ev.bytes_equal(place, &part)? {
            return Ok(Value::Bool(true));
        }
    }
    Ok(Value::Bool(false))
}

/// What is searched for: bytes, or the number of one.
fn part(ev: &Evaluator<'_>, value: &Value) -> R<BytesRef> {
    if ev.bytes_like(value).is_none() && ev.has_index(value) {
        return Ok(BytesRef::Snapshot(Rc::new(vec![ev.byte(value)?].into())));
    }
    ev.bytes_like(value).ok_or_else(|| {
        let name = ev.core.types.name_of(value);
        ev.type_error(format!(
            "argument should be integer or bytes-like object, not '{name}'"
        ))
    })
}

/// The receiver's bytes, which are looked at when what runs code of the script (bounds, parts) has been asked.
fn receiver_bytes(ev: &Evaluator<'_>, receiver: &Value) -> R<BytesRef> {
    let found = ev.bytes_like(receiver);
    found.ok_or_else(|| wrong_receiver(ev, "bytes", &ev.unwrap_builtin(receiver)))
}

impl Evaluator<'_> {
    fn bytes(&self, value: &Value) -> R<BytesRef> {
        self.bytes_like(value).ok_or_else(|| {
            let name = self.core.types.name_of(value);
            self.type_error(format!("a bytes-like object is required, not '{name}'"))
        })
    }
}
