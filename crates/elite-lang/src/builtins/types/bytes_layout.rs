//! What lays `bytes` and `bytearray` out in columns: padding and tabs.

use super::bytes::{like, receiver};
use super::bytes_parts::of_receiver;
use crate::eval::Evaluator;
use crate::limits::chunked::{CHUNK, WORK_PER_BYTE};
use crate::value::{R, Value};

/// Where the bytes stand in their column.
#[derive(Clone, Copy)]
pub(super) enum BytesAlignment {
    Left,
    Right,
    Centre,
}

/// `ljust`, `rjust` and `center`
pub(super) fn pad(ev: &Evaluator<'_>, args: &[Value], name: &str, stands: BytesAlignment) -> R {
    let width = usize::try_from(ev.index(&args[1])?).unwrap_or(0);
    let fill = match args[2].if_given() {
        None => b' ',
        Some(fill) => match ev.bytes_like(fill).as_deref() {
            Some([fill]) => *fill,
            _ => {
                let given = ev.core.types.name_of_argument(fill);
                return Err(ev.type_error(format!(
                    "{name}() argument 2 must be a byte string of length 1, not {given}"
                )));
            }
        },
    };
    let data = receiver(ev, &args[0])?;
    let missing = width.saturating_sub(data.len());
    let before = match stands {
        BytesAlignment::Left => 0,
        BytesAlignment::Right => missing,
        // CPython puts the odd one on the left if the width is odd.
        BytesAlignment::Centre => missing / 2 + (missing & width & 1),
    };
    padded(ev, &args[0], &data, (0, before, missing - before), fill)
}

/// `zfill`
pub(super) fn zfill(ev: &Evaluator<'_>, args: &[Value]) -> R {
    let width = usize::try_from(ev.index(&args[1])?).unwrap_or(0);
    let data = receiver(ev, &args[0])?;
    let missing = width.saturating_sub(data.len());
    let sign = usize::from(data.starts_with(b"+") || data.starts_with(b"-"));
    padded(ev, &args[0], &data, (sign, missing, 0), b'0')
}

/// The first `head` bytes, `before` times the fill, the others, and `after` times the fill.
fn padded(
    ev: &Evaluator<'_>,
    whole: &Value,
    data: &[u8],
    (head, before, after): (usize, usize, usize),
    fill: u8,
) -> R {
    if before + after == 0 {
        return of_receiver(ev, whole, data, data);
    }
    ev.check_allocation(before + after)?;
    let (head, rest) = data.split_at(head);
    let mut out = Vec::new();
    ev.grow(&mut out, data.len().saturating_add(before + after))?;
    ev.push_bytes(&mut out, head)?;
    ev.push_bytes(&mut out, &ev.repeat_bytes(&[fill], before)?)?;
    ev.push_bytes(&mut out, rest)?;
    ev.push_bytes(&mut out, &ev.repeat_bytes(&[fill], after)?)?;
    Ok(like(ev, whole, out))
}

/// `expandtabs`
pub(super) fn expandtabs(ev: &Evaluator<'_>, args: &[Value]) -> R {
    let size = match args[1].if_given() {
        Some(value) => usize::try_from(ev.c_int(value)?).unwrap_or(0),
        None => 8,
    };
    let data = receiver(ev, &args[0])?;
    let mut out = Vec::new();
    let mut column = 0;
    for piece in data.chunks(CHUNK) {
        ev.grow(&mut out, piece.len())?;
        for byte in piece {
            match byte {
                b'\t' if size == 0 => {}
                b'\t' => {
                    let blanks = size - column % size;
                    ev.push_bytes(&mut out, &ev.repeat_bytes(b" ", blanks)?)?;
                    column += blanks;
                }
                b'\n' | b'\r' => {
                    out.push(*byte);
                    column = 0;
                }
                _ => {
                    out.push(*byte);
                    column += 1;
                }
            }
        }
        ev.charge(piece.len() * WORK_PER_BYTE)?;
    }
    Ok(like(ev, &args[0], out))
}
