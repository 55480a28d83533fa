//! What looks for one `str` in another: `find` and its kin, `count`, prefixes and suffixes, `replace`.

use std::rc::Rc;

use super::{receiver, text_argument};
use crate::builtins::types::bounds::SearchBounds;
use crate::eval::Evaluator;
use crate::limits::chunked::WORK_PER_BYTE;
use crate::ops::search::Occurrences;
use crate::value::{R, Str, Value};

/// A string argument, named in the error for anything else.
pub(super) fn named_text(ev: &Evaluator<'_>, value: &Value, method: &str) -> R<Rc<Str>> {
    text_argument(ev, value).map_err(|_| {
        let name = ev.core.types.name_of_argument(value);
        ev.type_error(format!("{method}() argument must be str, not {name}"))
    })
}

pub(super) fn begins(ev: &Evaluator<'_>, text: &str, part: &str) -> R<bool> {
    match text.as_bytes().get(..part.len()) {
        Some(text) => ev.bytes_equal(text, part.as_bytes()),
        None => Ok(false),
    }
}

pub(super) fn ends(ev: &Evaluator<'_>, text: &str, part: &str) -> R<bool> {
    match text.len().checked_sub(part.len()) {
        Some(from) => ev.bytes_equal(&text.as_bytes()[from..], part.as_bytes()),
        None => Ok(false),
    }
}

pub(super) fn replace(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let text = receiver(ev, &args[0])?;
    let argument = |index: usize| -> R<Rc<Str>> {
        match ev.unwrap_builtin(&args[index]) {
            Value::Str(text) => Ok(text),
            _ => {
                let name = ev.core.types.name_of_argument(&args[index]);
                Err(ev.type_error(format!(
                    "replace() argument {index} must be str, not {name}"
                )))
            }
        }
    };
    let (old, new) = (argument(1)?, argument(2)?);
    let count = match args[3].if_given() {
        Some(value) => usize::try_from(ev.index(value)?).unwrap_or(usize::MAX),
        None => usize::MAX,
    };
    let (text, old, new) = (text.as_str(), old.as_str(), new.as_str());
    let mut out = String::new();
    let mut from = 0;
    if old.is_empty() {
        // Before each character, and at the end.
        let mut left = count;
        for c in text.chars() {
            if left == 0 {
                break;
            }
            left -= 1;
            ev.push_text(&mut out, new)?;
            ev.push_text(&mut out, &text[from..from + c.len_utf8()])?;
            from += c.len_utf8();
            ev.charge(WORK_PER_BYTE)?;
        }
        let rest = &text[from..];
        if left > 0 && rest.is_empty() {
            ev.push_text(&mut out, new)?;
        }
        ev.push_text(&mut out, rest)?;
        return ev.new_str(out);
    }
    if count == 0 {
        return ev.new_str_from(text);
    }
    let mut found = Occurrences::new(text.as_bytes(), old.as_bytes());
    let mut left = count;
    while left > 0
        && let Some(at) = found.next(ev)?
    {
        ev.push_text(&mut out, &text[from..at])?;
        ev.push_text(&mut out, new)?;
        from = at + old.len();
        left -= 1;
    }
    ev.push_text(&mut out, &text[from..])?;
    ev.new_str(out)
}

/// The part of a string between bounds, and the index it starts at; None if they cross.
fn bounded_part<'t>(
    ev: &Evaluator<'_>,
    text: &'t Str,
    bounds: &SearchBounds,
) -> R<Option<(usize, &'t str)>> {
    ev.index_chars(text)?;
    let places = bounds.resolve(text.len());
    Ok(places.map(|(from, to)| (from, text.slice(from, to))))
}

pub(super) fn find(ev: &Evaluator<'_>, args: &[Value], from_right: bool, required: bool) -> R {
    let (text, bounds) = (
        receiver(ev, &args[0])?,
        SearchBounds::read(ev, &args[2], &args[3])?,
    );
    let part = text_argument(ev, &args[1])?;
    let found = match bounded_part(ev, &text, &bounds)? {
        Some((start, slice)) => {
            let (slice, part) = (slice.as_bytes(), part.as_str().as_bytes());
            let at = match from_right {
                true => ev.rfind_bytes(slice, part)?,
                false => ev.find_bytes(slice, part)?,
            };
            at.map(|at| text.char_index(text.byte_offset(start) + at))
        }
        None => None,
    };
    match found {
        Some(index) => Ok(Value::Int(index as i64)),
        None if required => Err(ev.value_error("substring not found")),
        None => Ok(Value::Int(-1)),
    }
}

pub(super) fn count(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let (text, bounds) = (
        receiver(ev, &args[0])?,
        SearchBounds::read(ev, &args[2], &args[3])?,
    );
    let part = text_argument(ev, &args[1])?;
    let count = match bounded_part(ev, &text, &bounds)? {
        None => 0,
        Some((_, slice)) if part.is_empty() => ev.count_chars(slice)? + 1,
        Some((_, slice)) => {
            Occurrences::new(slice.as_bytes(), part.as_str().as_bytes()).count(ev)?
        }
    };
    Ok(Value::Int(count as i64))
}

type AffixTestFn = for<'y> fn(&Evaluator<'y>, &str, &str) -> R<bool>;

pub(super) fn affix(ev: &Evaluator<'_>, args: &[Value], method: &str, test: AffixTestFn) -> R {
    if let [
        Value::Str(text),
        Value::Str(part),
        Value::Unbound,
        Value::Unbound,
    ] = args
    {
        return test(ev, text.as_str(), part.as_str()).map(Value::Bool);
    }
    let text = receiver(ev, &args[0])?;
    let bounds = SearchBounds::read(ev, &args[2], &args[3])?;
    let slice = bounded_part(ev, &text, &bounds)?.map(|(_, slice)| slice);
    let parts = ev.unwrap_builtin(&args[1]);
    let is_several = matches!(parts, Value::Tuple(_));
    let check = |part: &Value| -> R<bool> {
        match ev.unwrap_builtin(part) {
            Value::Str(part) => match slice {
                Some(slice) => test(ev, slice, part.as_str()),
                None => Ok(false),
            },
            _ => {
                let name = ev.core.types.name_of(part);
                Err(ev.type_error(if is_several {
                    format!("tuple for {method} must only contain str, not {name}")
                } else {
                    format!("{method} first arg must be str or a tuple of str, not {name}")
                }))
            }
        }
    };
    match &parts {
        Value::Tuple(parts) => {
            for part in parts.items() {
                ev.charge(WORK_PER_BYTE)?;
                if check(part)? {
                    return Ok(Value::Bool(true));
                }
            }
            Ok(Value::Bool(false))
        }
        _ => check(&args[1]).map(Value::Bool),
    }
}
