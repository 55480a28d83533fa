//! Methods of bytes that are those of `str` on the same bytes read as Latin-1.

use std::rc::Rc;

use super::bytes::{SPACES, like, receiver};
use crate::eval::Evaluator;
use crate::eval::bulk::{EACH, PIECE};
use crate::value::{Bytes, R, Value, Values};

/// Bytes as text of the same codes; anything else as it is, strings refused.
fn to_text(ev: &Evaluator<'_>, value: &Value) -> R {
    match value {
        Value::Str(_) => Err(ev.type_error("a bytes-like object is required, not 'str'")),
        Value::Tuple(tuple) => {
            let items: R<Vec<Value>> = tuple.items().iter().map(|item| to_text(ev, item)).collect();
            items.map(Value::tuple)
        }
        other => Ok(match ev.bytes_like(other) {
            Some(data) => ev.string(ev.of_latin1(&data)?)?,
            None => other.clone(),
        }),
    }
}

fn from_text(ev: &Evaluator<'_>, receiver: &Value, value: Value) -> R {
    let each = |items: &[Value]| -> R<Values> {
        let mut out: Values = ev.room_for(items.len())?.into();
        for item in items {
            ev.worked(EACH)?;
            out.push(from_text(ev, receiver, item.clone())?);
        }
        Ok(out)
    };
    Ok(match &value {
        Value::Str(text) => like(ev, receiver, ev.to_latin1(text.as_str())?),
        Value::List(_) => each(&ev.collect(&value)?)?.into_list(),
        Value::Tuple(tuple) => each(tuple.items())?.into_tuple(),
        _ => value,
    })
}

/// The method of `str` with this name, on bytes read as Latin-1.
pub(super) fn by_text(ev: &Evaluator<'_>, args: &mut [Value], name: &str) -> R {
    settle(ev, args, name)?;
    check_fill(ev, args, name)?;
    let method = ev
        .core
        .types
        .str
        .lookup(ev.core.symbols.intern(name))
        .unwrap_or_default();
    let bytes_at: &[usize] = match name {
        "partition" | "rpartition" | "removeprefix" | "removesuffix" => &[1],
        "split" | "rsplit" | "strip" | "lstrip" | "rstrip" => &[1],
        "replace" => &[1, 2],
        _ => &[],
    };
    for arg in bytes_at.iter().filter_map(|place| args.get(*place)) {
        let may_be_none = name.ends_with("split") || name.ends_with("strip");
        let is_left_out = arg.is_unbound() || arg.is_none() && may_be_none;
        if !is_left_out && ev.bytes_like(arg).is_none() {
            let found = ev.core.types.name_of(arg);
            let text = format!("a bytes-like object is required, not '{found}'");
            return Err(ev.type_error(text));
        }
    }
    if let ("replace", Some(count)) = (name, args.get(3).and_then(Value::given)) {
        args[3] = Value::Int(ev.index(count)?);
    }
    let given = args.iter().take_while(|arg| !arg.is_unbound());
    let texts: R<Vec<Value>> = given.map(|arg| to_text(ev, arg)).collect();
    let result = ev.call(&method, &mut texts?, &[])?;
    from_text(ev, &args[0], result)
}

/// Asks the arguments that are numbers, each once and before the bytes are looked at.
fn settle(ev: &Evaluator<'_>, args: &mut [Value], name: &str) -> R<()> {
    let place = match name {
        "center" | "ljust" | "rjust" | "zfill" | "expandtabs" => 1,
        "split" | "rsplit" => 2,
        _ => return Ok(()),
    };
    if let Some(arg) = args.get_mut(place)
        && !arg.is_unbound()
    {
        *arg = Value::Int(match name {
            "expandtabs" => i64::from(ev.c_int(arg)?),
            _ => ev.index(arg)?,
        });
    }
    Ok(())
}

/// Refuses what is no single byte to fill up with.
fn check_fill(ev: &Evaluator<'_>, args: &[Value], name: &str) -> R<()> {
    let ("center" | "ljust" | "rjust", Some(fill)) = (name, args.get(2).and_then(Value::given))
    else {
        return Ok(());
    };
    match ev.bytes_like(fill) {
        Some(data) if data.len() == 1 => Ok(()),
        _ => {
            let given = ev.core.types.name_of_argument(fill);
            Err(ev.type_error(format!(
                "{name}() argument 2 must be a byte string of length 1, not {given}"
            )))
        }
    }
}

/// `strip` and its two halves.
pub(super) fn strip(ev: &Evaluator<'_>, args: &mut [Value], name: &str) -> R {
    if args[1].is_unbound() || args[1].is_none() {
        args[1] = Value::Bytes(Rc::new(Bytes::new(SPACES.as_bytes().to_vec())));
    }
    by_text(ev, args, name)
}

/// `split` and `rsplit`.
pub(super) fn split(ev: &Evaluator<'_>, args: &mut [Value], name: &str) -> R {
    settle(ev, args, name)?;
    if !args[1].is_unbound() && !args[1].is_none() {
        return by_text(ev, args, name);
    }
    // Latin-1 has two more blanks than ASCII; they are no blanks here.
    let data = receiver(ev, &args[0])?;
    let hidden = ev.mapped_bytes(&data, |piece, out| {
        out.extend(piece.iter().map(|byte| match byte {
            0x85 | 0xa0 | 0x1c..=0x1f => b'x',
            byte => *byte,
        }));
    })?;
    args[1] = Value::None;
    let mut on_hidden: Vec<Value> = vec![Value::Bytes(Rc::new(Bytes::new(hidden)))];
    on_hidden.extend(args[1..].iter().cloned());
    let parts = by_text(ev, &mut on_hidden, name)?;
    let mut parts = ev.collect(&parts)?;
    // The part at the far end is all that was left there, blanks before or behind it and all: it is met last.
    let backwards = name == "rsplit";
    if backwards {
        parts.reverse();
    }
    let mut rest = &data[..];
    for part in parts.iter_mut() {
        let length = ev.bytes_like(part).map_or(0, |part| part.len());
        rest = without_blanks(ev, rest, backwards)?;
        let own;
        (rest, own) = match backwards {
            false => (&rest[length..], &rest[..length]),
            true => rest.split_at(rest.len() - length),
        };
        *part = like(ev, &args[0], ev.copied_bytes(own)?);
        ev.worked(EACH)?;
    }
    if backwards {
        parts.reverse();
    }
    Ok(parts.into_list())
}

/// The data without the blanks it begins with, or ends with.
fn without_blanks<'d>(ev: &Evaluator<'_>, data: &'d [u8], at_end: bool) -> R<&'d [u8]> {
    let is_blank = |byte: &u8| SPACES.as_bytes().contains(byte);
    let mut rest = data;
    loop {
        let piece = match at_end {
            false => &rest[..rest.len().min(PIECE)],
            true => &rest[rest.len() - rest.len().min(PIECE)..],
        };
        let blanks = match at_end {
            false => piece.iter().take_while(|byte| is_blank(byte)).count(),
            true => piece.iter().rev().take_while(|byte| is_blank(byte)).count(),
        };
        ev.worked(blanks * EACH)?;
        rest = match at_end {
            false => &rest[blanks..],
            true => &rest[..rest.len() - blanks],
        };
        if blanks < PIECE {
            return Ok(rest);
        }
    }
}
