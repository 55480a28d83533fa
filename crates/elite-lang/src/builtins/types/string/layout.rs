//! What lays a `str` out in columns: padding and tabs.

use super::receiver;
use crate::eval::Evaluator;
use crate::limits::chunked::{WORK_PER_BYTE, pieces};
use crate::value::{R, Value};

pub(super) fn pad(ev: &Evaluator<'_>, args: &[Value], align: char) -> R {
    let text = receiver(ev, &args[0])?;
    let width = usize::try_from(ev.index(&args[1])?).unwrap_or(0);
    let fill = match args[2].if_given() {
        None => ' ',
        Some(value) => match ev.unwrap_builtin(value) {
            Value::Str(text) if text.len() == 1 => text.as_str().chars().next().unwrap_or(' '),
            Value::Str(_) => {
                return Err(ev.type_error("The fill character must be exactly one character long"));
            }
            _ => {
                let name = ev.core.types.name_of(value);
                return Err(ev.type_error(format!(
                    "The fill character must be a unicode character, not {name}"
                )));
            }
        },
    };
    let missing = width.saturating_sub(text.len());
    if missing == 0 {
        return Ok(Value::Str(text));
    }
    ev.check_allocation(missing)?;
    let (before, after) = match align {
        '<' => (0, missing),
        '>' => (missing, 0),
        // CPython puts the odd one on the left if the width is odd.
        _ => {
            let left = missing / 2 + (missing & width & 1);
            (left, missing - left)
        }
    };
    let fill = fill.to_string();
    let fill = &*fill;
    let bytes = missing.saturating_mul(fill.len());
    let mut out = String::new();
    ev.grow(&mut out, bytes.saturating_add(text.as_str().len()))?;
    ev.push_repeated(&mut out, fill, before)?;
    ev.push_text(&mut out, text.as_str())?;
    ev.push_repeated(&mut out, fill, after)?;
    ev.new_str(out)
}

pub(super) fn zfill(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let text = receiver(ev, &args[0])?;
    let width = usize::try_from(ev.index(&args[1])?).unwrap_or(0);
    let missing = width.saturating_sub(text.len());
    ev.check_allocation(missing)?;
    let sign = usize::from(text.as_str().starts_with(['+', '-']));
    let (sign, digits) = text.as_str().split_at(sign);
    let mut out = String::new();
    ev.grow(&mut out, missing.saturating_add(text.as_str().len()))?;
    out.push_str(sign);
    ev.push_repeated(&mut out, "0", missing)?;
    ev.push_text(&mut out, digits)?;
    ev.new_str(out)
}

pub(super) fn expandtabs(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let text = receiver(ev, &args[0])?;
    let size = match args[1].if_given() {
        Some(value) => usize::try_from(ev.c_int(value)?).unwrap_or(0),
        None => 8,
    };
    let mut out = String::new();
    let mut column = 0;
    for piece in pieces(text.as_str()) {
        ev.grow(&mut out, piece.len())?;
        for c in piece.chars() {
            match c {
                '\t' if size == 0 => {}
                '\t' => {
                    let blanks = size - column % size;
                    ev.push_repeated(&mut out, " ", blanks)?;
                    column += blanks;
                }
                '\n' | '\r' => {
                    out.push(c);
                    column = 0;
                }
                _ => {
                    out.push(c);
                    column += 1;
                }
            }
        }
        ev.charge(piece.len() * WORK_PER_BYTE)?;
    }
    ev.new_str(out)
}
