//! What takes `bytes` and `bytearray` apart: `strip`, `split` and its kin, `partition`, `replace`. They work on the
//! bytes where they lie; what runs code of the script (numbers) is asked before.

use std::rc::Rc;

use super::bytes::{SPACES, bytearray, not_bytes_like, receiver};
use super::bytes_search::SearchEnd;
use crate::eval::Evaluator;
use crate::limits::chunked::{CHUNK, WORK_PER_BYTE};
use crate::ops::search::Occurrences;
use crate::value::bytes::BytesRef;
use crate::value::{Bytes, R, Value, ValueVec};

/// `strip`; with one side, `lstrip` or `rstrip`.
pub(super) fn strip(ev: &Evaluator<'_>, args: &[Value], only: Option<SearchEnd>) -> R {
    let whole = receiver(ev, &args[0])?;
    let given = args[1].if_given().filter(|chars| !chars.is_none());
    let mut is_cut = [false; 256];
    match given {
        None => mark(ev, &mut is_cut, SPACES)?,
        Some(chars) => mark(ev, &mut is_cut, &bytes_argument(ev, chars)?)?,
    }
    let cut = |byte: u8| is_cut[usize::from(byte)];
    let mut part = &whole[..];
    if only != Some(SearchEnd::Right) {
        part = &part[edge(ev, part, SearchEnd::Left, cut)?..];
    }
    if only != Some(SearchEnd::Left) {
        part = &part[..part.len() - edge(ev, part, SearchEnd::Right, cut)?];
    }
    of_receiver(ev, &args[0], &whole, part)
}

fn mark(ev: &Evaluator<'_>, marks: &mut [bool; 256], bytes: &[u8]) -> R<()> {
    for piece in bytes.chunks(CHUNK) {
        piece
            .iter()
            .for_each(|byte| marks[usize::from(*byte)] = true);
        ev.charge(piece.len() * WORK_PER_BYTE)?;
    }
    Ok(())
}

/// How many bytes at one end pass a test.
fn edge(ev: &Evaluator<'_>, data: &[u8], side: SearchEnd, test: impl Fn(u8) -> bool) -> R<usize> {
    let mut passed = 0;
    loop {
        let met = match side {
            SearchEnd::Left => {
                let rest = data[passed..].iter();
                rest.take(CHUNK).take_while(|byte| test(**byte)).count()
            }
            SearchEnd::Right => {
                let rest = data[..data.len() - passed].iter().rev();
                rest.take(CHUNK).take_while(|byte| test(**byte)).count()
            }
        };
        passed += met;
        ev.charge(met * WORK_PER_BYTE)?;
        if met < CHUNK {
            return Ok(passed);
        }
    }
}

/// `split` and `rsplit`
pub(super) fn split(ev: &Evaluator<'_>, args: &[Value], side: SearchEnd) -> R {
    let most = match args[2].if_given() {
        Some(value) => usize::try_from(ev.index(value)?).unwrap_or(usize::MAX),
        None => usize::MAX,
    };
    let separator = match args[1].if_given() {
        None | Some(Value::None) => None,
        Some(separator) => Some(bytes_argument(ev, separator)?),
    };
    let whole = receiver(ev, &args[0])?;
    let mut parts = BytesSplitter::new(ev, &args[0], &whole);
    match separator {
        None => parts.split_at_blanks(most, side)?,
        Some(separator) if separator.is_empty() => return Err(ev.value_error("empty separator")),
        Some(separator) => parts.split_at_separator(&separator, most, side)?,
    }
    if side == SearchEnd::Right {
        ev.reverse(&mut parts.list)?;
    }
    Ok(parts.list.into_list())
}

/// The parts of some bytes, as they are found.
struct BytesSplitter<'p, 'y> {
    ev: &'p Evaluator<'y>,
    receiver: &'p Value,
    whole: &'p BytesRef,
    list: ValueVec,
}

impl<'p, 'y> BytesSplitter<'p, 'y> {
    fn new(ev: &'p Evaluator<'y>, receiver: &'p Value, whole: &'p BytesRef) -> Self {
        let list = ValueVec::default();
        BytesSplitter {
            ev,
            receiver,
            whole,
            list,
        }
    }

    fn push(&mut self, part: &[u8]) -> R<()> {
        self.ev.grow(&mut *self.list, 1)?;
        let part = of_receiver(self.ev, self.receiver, self.whole, part)?;
        self.list.push(part);
        self.ev.charge(WORK_PER_BYTE)?;
        // Asked now and then, so that the parts never go far beyond the memory limit.
        match self.list.len().is_multiple_of(1024) {
            true => self.ev.check_memory(),
            false => Ok(()),
        }
    }

    fn split_at_separator(&mut self, separator: &[u8], most: usize, side: SearchEnd) -> R<()> {
        let (ev, whole) = (self.ev, self.whole);
        let backwards = side == SearchEnd::Right;
        ev.each_between(whole, separator, most, backwards, |part| {
            self.push(&whole[part])
        })
    }

    /// Splits at runs of blanks, at most `most` times; the rest keeps its inner blanks, and those at its far end.
    fn split_at_blanks(&mut self, most: usize, side: SearchEnd) -> R<()> {
        let (ev, whole) = (self.ev, self.whole);
        let is_blank = |byte: u8| SPACES.contains(&byte);
        // What is cut off on one side, and what is left of it on the other.
        let cut = |rest: &'p [u8], length: usize| match side {
            SearchEnd::Left => rest.split_at(length),
            SearchEnd::Right => {
                let (rest, own) = rest.split_at(rest.len() - length);
                (own, rest)
            }
        };
        let mut rest = &whole[..];
        loop {
            (_, rest) = cut(rest, edge(ev, rest, side, is_blank)?);
            if rest.is_empty() {
                return Ok(());
            }
            if self.list.len() == most {
                return self.push(rest);
            }
            let word;
            (word, rest) = cut(rest, edge(ev, rest, side, |byte| !is_blank(byte))?);
            self.push(word)?;
        }
    }
}

/// `partition` and `rpartition`
pub(super) fn partition(ev: &Evaluator<'_>, args: &[Value], side: SearchEnd) -> R {
    let separator = bytes_argument(ev, &args[1])?;
    let whole = receiver(ev, &args[0])?;
    if separator.is_empty() {
        return Err(ev.value_error("empty separator"));
    }
    let is_mutable = matches!(ev.unwrap_builtin(&args[0]), Value::ByteArray(_));
    let part = |part: &[u8]| -> R { Ok(made(is_mutable, ev.copy_bytes(part)?)) };
    let found = match side {
        SearchEnd::Left => ev.find_bytes(&whole, &separator)?,
        SearchEnd::Right => ev.rfind_bytes(&whole, &separator)?,
    };
    Ok(Value::triple(match found {
        Some(at) => [
            part(&whole[..at])?,
            // The very object, if nobody can change it through the result.
            match is_mutable {
                true => part(&separator)?,
                false => args[1].clone(),
            },
            part(&whole[at + separator.len()..])?,
        ],
        None => {
            let all = match is_mutable {
                true => part(&whole)?,
                false => args[0].clone(),
            };
            match side {
                SearchEnd::Left => [all, part(b"")?, part(b"")?],
                SearchEnd::Right => [part(b"")?, part(b"")?, all],
            }
        }
    }))
}

/// `removeprefix` and `removesuffix`
pub(super) fn without_affix(ev: &Evaluator<'_>, args: &[Value], side: SearchEnd) -> R {
    let affix = bytes_argument(ev, &args[1])?;
    let whole = receiver(ev, &args[0])?;
    let rest = whole.len().checked_sub(affix.len());
    let part = match (rest, side) {
        (Some(_), SearchEnd::Left) if ev.bytes_equal(&whole[..affix.len()], &affix)? => {
            &whole[affix.len()..]
        }
        (Some(rest), SearchEnd::Right) if ev.bytes_equal(&whole[rest..], &affix)? => &whole[..rest],
        _ => &whole[..],
    };
    of_receiver(ev, &args[0], &whole, part)
}

/// `replace`
pub(super) fn replace(ev: &Evaluator<'_>, args: &[Value]) -> R {
    let (old, new) = (bytes_argument(ev, &args[1])?, bytes_argument(ev, &args[2])?);
    let most = match args[3].if_given() {
        Some(value) => usize::try_from(ev.index(value)?).unwrap_or(usize::MAX),
        None => usize::MAX,
    };
    let whole = receiver(ev, &args[0])?;
    let mut out = Vec::new();
    let mut from = 0;
    if old.is_empty() {
        // Before each byte, and at the end.
        while from < whole.len().min(most) {
            ev.push_bytes(&mut out, &new)?;
            ev.push_bytes(&mut out, &whole[from..=from])?;
            ev.charge(WORK_PER_BYTE)?;
            from += 1;
        }
        if from == whole.len() && from < most {
            ev.push_bytes(&mut out, &new)?;
        }
    } else {
        let mut found = Occurrences::new(&whole, &old);
        let mut left = most;
        while left > 0
            && let Some(at) = found.next(ev)?
        {
            ev.push_bytes(&mut out, &whole[from..at])?;
            ev.push_bytes(&mut out, &new)?;
            from = at + old.len();
            left -= 1;
        }
        if from == 0 {
            return of_receiver(ev, &args[0], &whole, &whole);
        }
    }
    ev.push_bytes(&mut out, &whole[from..])?;
    Ok(made(
        matches!(ev.unwrap_builtin(&args[0]), Value::ByteArray(_)),
        out,
    ))
}

/// The bytes of an argument.
fn bytes_argument(ev: &Evaluator<'_>, value: &Value) -> R<BytesRef> {
    ev.bytes_like(value)
        .ok_or_else(|| not_bytes_like(ev, value))
}

/// A part of a receiver, of its type: `bytes` themselves if that is all of them.
pub(super) fn of_receiver(ev: &Evaluator<'_>, receiver: &Value, whole: &[u8], part: &[u8]) -> R {
    if let Value::Bytes(_) = receiver
        && part.len() == whole.len()
    {
        return Ok(receiver.clone());
    }
    let is_mutable = matches!(ev.unwrap_builtin(receiver), Value::ByteArray(_));
    Ok(made(is_mutable, ev.copy_bytes(part)?))
}

fn made(is_mutable: bool, data: Vec<u8>) -> Value {
    match is_mutable {
        true => bytearray(data),
        false => Value::Bytes(Rc::new(Bytes::new(data))),
    }
}
