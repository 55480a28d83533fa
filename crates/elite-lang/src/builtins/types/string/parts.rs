//! What takes a `str` apart: `strip`, `split` and its kin, `partition`.

use std::collections::HashSet;
use std::rc::Rc;

use super::case::is_space;
use super::{receiver, text_argument};
use crate::eval::Evaluator;
use crate::limits::chunked::{BULK_CHUNK, WORK_PER_BYTE, bulk_work, pieces};
use crate::value::{R, Str, Value, ValueVec};

pub(super) fn strip(ev: &Evaluator<'_>, args: &[Value], left: bool, right: bool) -> R {
    let text = receiver(ev, &args[0])?;
    let chars: Option<CharSet> = match args[1].if_given() {
        None | Some(Value::None) => None,
        Some(value) => match ev.unwrap_builtin(value) {
            Value::Str(text) => Some(CharSet::of(ev, text.as_str())?),
            _ => {
                let method = match (left, right) {
                    (true, true) => "strip",
                    (true, false) => "lstrip",
                    _ => "rstrip",
                };
                return Err(ev.type_error(format!("{method} arg must be None or str")));
            }
        },
    };
    let cut = |c: char| {
        chars
            .as_ref()
            .map_or_else(|| is_space(c), |chars| chars.contains(c))
    };
    let mut part = text.as_str();
    if left {
        part = &part[ev.prefix_len(part, cut)?..];
    }
    if right {
        part = &part[..part.len() - ev.suffix_len(part, cut)?];
    }
    if part.len() == text.as_str().len() {
        return Ok(Value::Str(text.clone()));
    }
    ev.new_str_from(part)
}

/// Characters that are asked for again and again.
enum CharSet {
    Few(Vec<char>),
    Many(HashSet<char>),
}

impl CharSet {
    fn of(ev: &Evaluator<'_>, text: &str) -> R<Self> {
        if text.len() <= 16 {
            return Ok(CharSet::Few(text.chars().collect()));
        }
        let mut chars = HashSet::new();
        for piece in pieces(text) {
            chars.extend(piece.chars());
            ev.charge(piece.len() * WORK_PER_BYTE)?;
        }
        Ok(CharSet::Many(chars))
    }

    fn contains(&self, c: char) -> bool {
        match self {
            CharSet::Few(chars) => chars.contains(&c),
            CharSet::Many(chars) => chars.contains(&c),
        }
    }
}

pub(super) fn split(ev: &Evaluator<'_>, args: &[Value], from_right: bool) -> R {
    let text = receiver(ev, &args[0])?;
    let most = match args[2].if_given() {
        Some(value) => usize::try_from(ev.index(value)?).unwrap_or(usize::MAX),
        None => usize::MAX,
    };
    let separator = match args[1].if_given() {
        None | Some(Value::None) => None,
        Some(separator) => Some(text_argument(ev, separator).map_err(|_| {
            let name = ev.core.types.name_of(separator);
            ev.type_error(format!("must be str or None, not {name}"))
        })?),
    };
    let mut parts = TextSplitter::new(ev, &text);
    match separator {
        None => parts.split_at_spaces(most, from_right)?,
        Some(separator) if separator.is_empty() => return Err(ev.value_error("empty separator")),
        Some(separator) => parts.split_at_separator(separator.as_str(), most, from_right)?,
    }
    if from_right {
        ev.reverse(&mut parts.list)?;
    }
    Ok(parts.list.into_list())
}

/// The parts of a text, as they are found.
struct TextSplitter<'p, 'y> {
    ev: &'p Evaluator<'y>,
    whole: &'p Str,
    list: ValueVec,
}

impl<'p, 'y> TextSplitter<'p, 'y> {
    fn new(ev: &'p Evaluator<'y>, whole: &'p Str) -> Self {
        let list = ValueVec::default();
        TextSplitter { ev, whole, list }
    }

    fn push(&mut self, part: &str) -> R<()> {
        self.ev.grow(&mut *self.list, 1)?;
        self.list.push(part_of(self.ev, self.whole, part)?);
        // Asked now and then, so that the parts never go far beyond the memory limit.
        match self.list.len().is_multiple_of(1024) {
            true => self.ev.check_memory(),
            false => Ok(()),
        }
    }

    fn split_at_separator(&mut self, separator: &str, most: usize, from_right: bool) -> R<()> {
        let (ev, text) = (self.ev, self.whole.as_str());
        let (data, separator) = (text.as_bytes(), separator.as_bytes());
        ev.each_between(data, separator, most, from_right, |part| {
            self.push(&text[part])
        })
    }

    /// Splits at runs of white space, at most `most` times; the rest keeps its inner white space.
    fn split_at_spaces(&mut self, most: usize, from_right: bool) -> R<()> {
        let (ev, text) = (self.ev, self.whole.as_str());
        let is_word = |c: char| !is_space(c);
        let mut rest = match from_right {
            true => &text[..text.len() - ev.suffix_len(text, is_space)?],
            false => &text[ev.prefix_len(text, is_space)?..],
        };
        while !rest.is_empty() {
            if self.list.len() == most {
                return self.push(rest);
            }
            ev.charge(WORK_PER_BYTE)?;
            if from_right {
                let at = rest.len() - ev.suffix_len(rest, is_word)?;
                self.push(&rest[at..])?;
                rest = &rest[..at - ev.suffix_len(&rest[..at], is_space)?];
            } else {
                let at = ev.prefix_len(rest, is_word)?;
                self.push(&rest[..at])?;
                rest = &rest[at + ev.prefix_len(&rest[at..], is_space)?..];
            }
        }
        Ok(())
    }
}

/// A part of a text as a string of its own.
#[inline]
fn part_of(ev: &Evaluator<'_>, whole: &Str, part: &str) -> R {
    if whole.is_ascii() && part.len() <= BULK_CHUNK {
        ev.charge(bulk_work(part.len()))?;
        if let [byte] = part.as_bytes() {
            return Ok(ev.core.char_value(char::from(*byte)));
        }
        return Ok(Value::Str(Rc::new(Str::with_char_count(part, part.len()))));
    }
    ev.new_str_from(part)
}

pub(super) fn splitlines(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let keep = args[1].if_given().map_or(Ok(0), |value| ev.c_int(value))? != 0;
    let whole = receiver(ev, &args[0])?;
    let text = whole.as_str();
    let is_end = |c: char| {
        matches!(
            c,
            '\n' | '\r' | '\x0b' | '\x0c' | '\x1c'..='\x1e' | '\u{85}' | '\u{2028}' | '\u{2029}'
        )
    };
    let mut lines = TextSplitter::new(ev, &whole);
    let mut rest = text;
    while !rest.is_empty() {
        let line = ev.prefix_len(rest, |c| !is_end(c))?;
        let end = match &rest[line..] {
            "" => line,
            rest if rest.starts_with("\r\n") => line + 2,
            rest => line + rest.chars().next().map_or(1, char::len_utf8),
        };
        lines.push(if keep { &rest[..end] } else { &rest[..line] })?;
        ev.charge(WORK_PER_BYTE)?;
        rest = &rest[end..];
    }
    Ok(lines.list.into_list())
}

pub(super) fn partition(ev: &Evaluator<'_>, args: &[Value], from_right: bool) -> R {
    let (whole, separator) = (receiver(ev, &args[0])?, text_argument(ev, &args[1])?);
    if separator.is_empty() {
        return Err(ev.value_error("empty separator"));
    }
    let text = whole.as_str();
    let found = if from_right {
        ev.rfind_bytes(text.as_bytes(), separator.as_str().as_bytes())?
    } else {
        ev.find_bytes(text.as_bytes(), separator.as_str().as_bytes())?
    };
    let empty = || ev.core.empty_str.clone();
    // What stays whole is what was given, of whichever class.
    let all = || args[0].clone();
    Ok(Value::triple(match (found, from_right) {
        (Some(at), _) => [
            part_of(ev, &whole, &text[..at])?,
            args[1].clone(),
            part_of(ev, &whole, &text[at + separator.as_str().len()..])?,
        ],
        (None, false) => [all(), empty(), empty()],
        (None, true) => [empty(), empty(), all()],
    }))
}
