//! Searches in `bytes` and `bytearray`: where a part is, how often, at the beginning, at the end. They read the bytes where
//! they lie; what runs code of the script (bounds, parts) is asked before.

use memchr::memmem;

use super::bounds::Bounds;
use super::wrong_receiver;
use crate::eval::Evaluator;
use crate::value::int::Int;
use crate::value::{R, Value};

/// Which end of the bytes a search looks at.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Side {
    Left,
    Right,
}

/// `find` and `rfind`; with `required`, `index` and `rindex`.
pub fn find(ev: &Evaluator<'_>, args: &[Value], side: Side, required: bool) -> R {
    let bounds = Bounds::read(ev, &args[2], &args[3])?;
    let part = part(ev, &args[1])?;
    let Some((from, to)) = bounds.within(length(ev, args)?) else {
        return not_found(ev, required);
    };
    let found = within(ev, &args[0], (from, to), |data| match side {
        Side::Left => memmem::find(data, &part),
        Side::Right => memmem::rfind(data, &part),
    })?;
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
    let bounds = Bounds::read(ev, &args[2], &args[3])?;
    let part = part(ev, &args[1])?;
    let Some(range) = bounds.within(length(ev, args)?) else {
        return Ok(Value::Int(0));
    };
    let count = within(ev, &args[0], range, |data| match part.len() {
        0 => data.len() + 1,
        _ => memmem::find_iter(data, &part).count(),
    })?;
    Ok(Value::Int(count as i64))
}

/// `startswith` and `endswith`
pub fn affix(ev: &Evaluator<'_>, args: &[Value], side: Side) -> R {
    let bounds = Bounds::read(ev, &args[2], &args[3])?;
    let parts = match &args[1] {
        Value::Tuple(parts) => parts.items().iter().map(|part| ev.bytes(part)).collect(),
        one => match ev.bytes_like(one) {
            Some(part) => Ok(vec![part]),
            None => {
                let name = if side == Side::Left {
                    "startswith"
                } else {
                    "endswith"
                };
                let given = ev.core.types.name_of(one);
                Err(ev.type_error(format!(
                    "{name} first arg must be bytes or a tuple of bytes, not {given}"
                )))
            }
        },
    };
    let parts: Vec<Vec<u8>> = parts?;
    let Some(range) = bounds.within(length(ev, args)?) else {
        return Ok(Value::Bool(false));
    };
    let found = within(ev, &args[0], range, |data| {
        parts.iter().any(|part| match side {
            Side::Left => data.starts_with(part),
            Side::Right => data.ends_with(part),
        })
    })?;
    Ok(Value::Bool(found))
}

/// What is searched for: bytes, or the number of one.
fn part(ev: &Evaluator<'_>, value: &Value) -> R<Vec<u8>> {
    if Int::of(value).is_some() {
        return Ok(vec![ev.byte(value)?]);
    }
    ev.bytes_like(value).ok_or_else(|| {
        let name = ev.core.types.name_of(value);
        ev.type_error(format!(
            "argument should be integer or bytes-like object, not '{name}'"
        ))
    })
}

fn length(ev: &Evaluator<'_>, args: &[Value]) -> R<usize> {
    within(ev, &args[0], (0, usize::MAX), <[u8]>::len)
}

/// Looks at a part of the receiver's bytes; what runs code of the script has no place in `look`.
fn within<T>(
    ev: &Evaluator<'_>,
    receiver: &Value,
    (from, to): (usize, usize),
    look: impl FnOnce(&[u8]) -> T,
) -> R<T> {
    // A bound of the script's making may have changed the length.
    let cut = |data: &[u8]| look(&data[from.min(data.len())..to.min(data.len())]);
    match ev.plain(receiver) {
        Value::Bytes(bytes) => Ok(cut(bytes.data())),
        Value::ByteArray(bytes) => Ok(cut(&bytes.data.borrow())),
        other => Err(wrong_receiver(ev, "bytes", &other)),
    }
}

impl Evaluator<'_> {
    fn bytes(&self, value: &Value) -> R<Vec<u8>> {
        self.bytes_like(value).ok_or_else(|| {
            let name = self.core.types.name_of(value);
            self.type_error(format!("a bytes-like object is required, not '{name}'"))
        })
    }
}
