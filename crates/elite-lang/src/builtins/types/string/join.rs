//! `str.join`: few short texts at once, anything else piece by piece.

use std::rc::Rc;

use compact_str::CompactString;

use super::receiver;
use crate::eval::Evaluator;
use crate::limits::chunked::{BULK_CHUNK, WORK_PER_BYTE};
use crate::value::{R, Str, Value};

/// Texts and the separators between them that are joined without a safepoint.
const JOINED_MAX: usize = 4096;

/// A few texts with a separator between them; None if they are many or long, or if there is anything else among the
/// items.
fn join_few(ev: &Evaluator<'_>, items: &[Value], separator: &Str) -> R<Option<Value>> {
    if items.len() > JOINED_MAX {
        return Ok(None);
    }
    let gaps = items.len().saturating_sub(1);
    let mut bytes = separator.as_str().len().saturating_mul(gaps);
    let mut chars = separator.len().saturating_mul(gaps);
    for item in items {
        let Value::Str(text) = item else {
            return Ok(None);
        };
        bytes = bytes.saturating_add(text.as_str().len());
        chars = chars.saturating_add(text.len());
    }
    if bytes > BULK_CHUNK {
        return Ok(None);
    }
    ev.check_allocation(bytes)?;
    let mut out = CompactString::with_capacity(bytes);
    for (index, item) in items.iter().enumerate() {
        if index > 0 {
            out.push_str(separator.as_str());
        }
        if let Value::Str(text) = item {
            out.push_str(text.as_str());
        }
    }
    Ok(Some(Value::Str(Rc::new(Str::with_char_count(out, chars)))))
}

pub(super) fn join(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let separator = receiver(ev, &args[0])?;
    let joined = match &args[1] {
        Value::List(list) => join_few(ev, &list.borrow(), &separator)?,
        Value::Tuple(tuple) => join_few(ev, tuple.items(), &separator)?,
        _ => None,
    };
    if let Some(joined) = joined {
        return Ok(joined);
    }
    let collected = match &args[1] {
        sequence @ (Value::List(_) | Value::Tuple(_)) => sequence.clone(),
        iterable => {
            let message = || "can only join an iterable".to_owned();
            let iterator = ev.iter_or(iterable, message)?;
            ev.collect_rest(&iterator)?.into_tuple()
        }
    };
    join_many(ev, &collected, &separator)
}

/// The texts of a list or tuple with a separator between them.
fn join_many(ev: &Evaluator<'_>, sequence: &Value, separator: &Str) -> R {
    let text_at = |index: usize| -> R<Option<Rc<Str>>> {
        ev.charge(WORK_PER_BYTE)?;
        let item = match sequence {
            Value::List(list) => list.get(index),
            Value::Tuple(tuple) => tuple.items().get(index).cloned(),
            _ => None,
        };
        let Some(item) = item else { return Ok(None) };
        match ev.unwrap_builtin(&item) {
            Value::Str(text) => Ok(Some(text)),
            _ => {
                let name = ev.core.types.name_of(&item);
                let text = format!("sequence item {index}: expected str instance, {name} found");
                Err(ev.type_error(text))
            }
        }
    };
    // First how much there is, so that the text is made where it stays.
    let (mut bytes, mut count) = (0usize, 0usize);
    while let Some(text) = text_at(count)? {
        bytes = bytes.saturating_add(text.as_str().len());
        count += 1;
    }
    let gaps = separator
        .as_str()
        .len()
        .saturating_mul(count.saturating_sub(1));
    let mut out = String::new();
    ev.grow(&mut out, bytes.saturating_add(gaps))?;
    let (mut chars, mut index) = (0, 0);
    // A list may have been changed by another thread meanwhile; what it holds now counts.
    while let Some(text) = text_at(index)? {
        if index > 0 {
            ev.push_text(&mut out, separator.as_str())?;
            chars += separator.len();
        }
        ev.push_text(&mut out, text.as_str())?;
        chars += text.len();
        index += 1;
    }
    Ok(Value::Str(Rc::new(Str::with_char_count(out, chars))))
}
