//! `_re`: regular expressions as Python has them.
//!
//! `parse` makes a program of a pattern, `attempt` runs it as CPython would, and `walk` takes over where that would
//! step back for long. All of them let others have their turn. Here are the classes that scripts see.

mod attempt;
mod back;
mod escape;
mod found;
mod group;
mod letters;
mod methods;
mod parse;
mod program;
mod walk;

use std::cell::{Cell, OnceCell};
use std::ops::Deref;
use std::rc::Rc;

use super::define::{ModuleBuilder, instance};
use crate::eval::Evaluator;
use crate::value::bytes::BytesRef;
use crate::value::{Class, Dict, R, Unwind, Value};

use attempt::MatchRequest;
use back::Scratch;
use found::{MATCH, with_match};
use methods::{PATTERN, with_pattern};
use parse::{ParsedPattern, PatternError, parse};
use program::{Haystack, NOWHERE};

/// Longest pattern, in bytes.
const PATTERN_MAX: usize = 1 << 20;
/// Work for one group of a pattern that is handed out.
const GROUP: usize = 256;

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    module.functions(&[("_compile", "pattern flags error /", compile)]);
    let pattern = module.class("Pattern", None, PATTERN);
    module.property(&pattern, "pattern", |ev, args| {
        with_pattern(ev, args, |p| Ok(p.source.clone()))
    });
    module.property(&pattern, "flags", |ev, args| {
        with_pattern(ev, args, |p| Ok(Value::Int(i64::from(p.parsed.flags))))
    });
    module.property(&pattern, "groups", |ev, args| {
        with_pattern(ev, args, |p| Ok(Value::Int(p.parsed.groups as i64)))
    });
    module.property(&pattern, "groupindex", |ev, args| {
        with_pattern(ev, args, |p| {
            let dict = Dict::new();
            for (name, index) in &p.parsed.names {
                ev.charge(GROUP)?;
                dict.set_str(name, Value::Int(*index as i64));
            }
            Ok(Value::Dict(Rc::new(dict)))
        })
    });
    let found = module.class("Match", None, MATCH);
    module.property(&found, "string", |ev, args| {
        with_match(ev, args, |m| Ok(m.text.value()))
    });
    module.property(&found, "re", |ev, args| {
        with_match(ev, args, |m| Ok(m.pattern.clone()))
    });
    module.property(&found, "pos", |ev, args| {
        with_match(ev, args, |m| Ok(m.text.index(m.range.0)))
    });
    module.property(&found, "endpos", |ev, args| {
        with_match(ev, args, |m| Ok(m.text.index(m.range.1)))
    });
    module.property(&found, "regs", |ev, args| {
        with_match(ev, args, |m| {
            let outside = Value::Int(-1);
            let mut all = Vec::new();
            ev.grow(&mut all, m.spans.len())?;
            for span in m.spans.iter() {
                ev.charge(GROUP)?;
                all.push(Value::tuple(match span {
                    Some((start, end)) => vec![m.text.index(*start), m.text.index(*end)],
                    None => vec![outside.clone(), outside.clone()],
                }));
            }
            Ok(Value::tuple(all))
        })
    });
    module.property(&found, "lastindex", |ev, args| {
        with_match(ev, args, |m| {
            Ok(m.spans
                .last
                .map_or(Value::None, |index| Value::Int(index as i64)))
        })
    });
    module.property(&found, "lastgroup", |ev, args| {
        with_match(ev, args, |m| {
            let last = m.spans.last;
            let name = m
                .compiled
                .parsed
                .names
                .iter()
                .find(|(_, index)| Some(*index) == last);
            Ok(name.map_or(Value::None, |(name, _)| Value::str(&**name)))
        })
    });
    for class in [&pattern, &found] {
        class.set(crate::value::symbol::known::MODULE, Value::str("re"));
    }
    Ok(())
}

// The source is a plain text.
crate::value::data::no_values!(Pattern);

/// A compiled pattern.
struct Pattern {
    source: Value,
    parsed: ParsedPattern,
    is_bytes: bool,
    scratch: Cell<Option<Box<Scratch>>>,
    /// `_re.Match`, once something has been found.
    match_class: OnceCell<Rc<Class>>,
}

fn compile(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let source = ev.unwrap_builtin(&args[0]);
    let too_long = || Err(ev.value_error("the regular expression is longer than 1 MiB"));
    let (text, is_bytes) = match &source {
        Value::Str(text) if text.as_str().len() > PATTERN_MAX => return too_long(),
        Value::Str(text) => {
            let mut copy = String::new();
            ev.push_text(&mut copy, text.as_str())?;
            (copy, false)
        }
        other => match ev.bytes_like(other) {
            Some(data) if data.len() > PATTERN_MAX => return too_long(),
            // Byte by byte, as the characters of the same numbers.
            Some(data) => (ev.decode_latin1(&data)?, true),
            None => return Err(ev.type_error("first argument must be string or compiled pattern")),
        },
    };
    let flags = ev.clamped_index(&args[1])?.clamp(0, i64::from(u32::MAX)) as u32;
    let parsed = match parse(ev, &text, flags, is_bytes) {
        Ok(parsed) => parsed,
        Err(PatternError::Unwind(raised)) => return Err(raised),
        Err(PatternError::Wrong { message, position }) => {
            return Err(pattern_error(ev, &args[2], &source, &message, position));
        }
    };
    let pattern = Pattern {
        source,
        parsed,
        is_bytes,
        scratch: Cell::default(),
        match_class: OnceCell::new(),
    };
    instance(ev, "_re.Pattern", Rc::new(pattern))
}

#[cold]
fn pattern_error(
    ev: &Evaluator<'_>,
    class: &Value,
    source: &Value,
    message: &str,
    position: Option<usize>,
) -> Unwind {
    let position = position.map_or(Value::None, |position| Value::Int(position as i64));
    match ev.call(
        class,
        &mut [Value::str(message), source.clone(), position],
        &[],
    ) {
        Ok(Value::Instance(exception)) => Unwind::Exception(exception),
        Ok(_) => ev.value_error(message),
        Err(raised) => raised,
    }
}

/// The text that is searched.
#[derive(Clone)]
enum Subject {
    Str(Rc<crate::value::Str>, Value),
    Bytes(BytesRef, Value),
}

impl Subject {
    /// Runs `each` on the value that the text is of.
    fn visit(&self, each: &mut dyn FnMut(&Value)) {
        let (Subject::Str(_, value) | Subject::Bytes(_, value)) = self;
        each(value);
    }

    /// The value that the text is of, which is gone then.
    fn take(&mut self) -> Value {
        let (Subject::Str(_, value) | Subject::Bytes(_, value)) = self;
        std::mem::take(value)
    }

    fn of(ev: &Evaluator<'_>, pattern: &Pattern, value: &Value) -> R<Subject> {
        match (ev.unwrap_builtin(value), pattern.is_bytes) {
            (Value::Str(text), false) => {
                ev.index_chars(&text)?;
                Ok(Subject::Str(text, value.clone()))
            }
            (Value::Str(_), true) => {
                Err(ev.type_error("cannot use a bytes pattern on a string-like object"))
            }
            (_, is_bytes) => match ev.bytes_like(value) {
                Some(data) if is_bytes => Ok(Subject::Bytes(data, value.clone())),
                Some(_) => Err(ev.type_error("cannot use a string pattern on a bytes-like object")),
                None => {
                    let name = ev.core.types.name_of(value);
                    Err(ev.type_error(format!(
                        "expected string or bytes-like object, got '{name}'"
                    )))
                }
            },
        }
    }

    fn value(&self) -> Value {
        match self {
            Subject::Str(_, value) | Subject::Bytes(_, value) => value.clone(),
        }
    }

    fn len(&self) -> usize {
        match self {
            Subject::Str(text, _) => text.as_str().len(),
            Subject::Bytes(data, _) => data.len(),
        }
    }

    /// The byte offset of a position that the program gives.
    fn offset(&self, index: i64) -> usize {
        let index = usize::try_from(index).unwrap_or(0);
        match self {
            Subject::Str(text, _) => text.byte_offset(index.min(text.len())),
            Subject::Bytes(data, _) => index.min(data.len()),
        }
    }

    /// The position of a byte offset, as programs count.
    fn index(&self, offset: usize) -> Value {
        Value::Int(match self {
            Subject::Str(text, _) => text.char_index(offset) as i64,
            Subject::Bytes(..) => offset as i64,
        })
    }

    fn slice(&self, ev: &Evaluator<'_>, (start, end): (usize, usize)) -> R {
        match self {
            Subject::Str(text, _) => ev.new_str_from(&text.as_str()[start..end]),
            Subject::Bytes(data, _) => ev.copy_bytes(&data[start..end]).map(Value::bytes),
        }
    }
}

/// The groups of a match, the whole first.
struct Spans {
    groups: Vec<Option<(usize, usize)>>,
    /// The group that ended last.
    last: Option<usize>,
}

impl Spans {
    /// From the slots of a program.
    fn of(ev: &Evaluator<'_>, slots: &[usize]) -> R<Spans> {
        let mut groups = Vec::new();
        ev.grow(&mut groups, slots.len() / 2)?;
        groups.extend(slots.chunks_exact(2).map(|pair| match pair {
            [start, end] if *start != NOWHERE && *end != NOWHERE => Some((*start, *end)),
            _ => None,
        }));
        let last = slots.last().copied();
        Ok(Spans {
            groups,
            last: last.filter(|group| *group != NOWHERE),
        })
    }
}

impl Deref for Spans {
    type Target = [Option<(usize, usize)>];

    fn deref(&self) -> &Self::Target {
        &self.groups
    }
}

/// How a pattern is to match.
#[derive(Clone, Copy, PartialEq)]
enum Mode {
    Search,
    Match,
    Full,
}

/// Where to search in a text, and how.
#[derive(Clone, Copy)]
struct MatchRange {
    start: usize,
    end: usize,
    mode: Mode,
    /// An empty match at the start is none.
    advance: bool,
}

impl Pattern {
    /// The groups of the next match in a range, the whole first.
    fn find(&self, ev: &Evaluator<'_>, text: &Subject, range: MatchRange) -> R<Option<Spans>> {
        let MatchRange { start, end, .. } = range;
        if start > end {
            return Ok(None);
        }
        // Python lets the text end at `endpos`, but begin where it begins.
        let search = MatchRequest {
            hay: match text {
                Subject::Str(text, _) => Haystack::Text(&text.as_str()[..end]),
                Subject::Bytes(data, _) => Haystack::Bytes(&data[..end]),
            },
            start,
            anchored: range.mode != Mode::Search,
            full: range.mode == Mode::Full,
            not_empty: range.advance,
        };
        // Another thread may search for the same pattern meanwhile.
        let mut scratch = self.scratch.take().unwrap_or_default();
        let found = attempt::find(ev, &self.parsed.program, search, &mut scratch);
        self.scratch.set(Some(scratch));
        found
    }
}

/// Goes through all matches in a text.
struct Scanner {
    pattern: Rc<Pattern>,
    text: Subject,
    at: usize,
    end: usize,
    /// The last match was empty: the next one here must not be.
    advance: bool,
}

impl Scanner {
    fn next(&mut self, ev: &Evaluator<'_>) -> R<Option<Spans>> {
        let range = MatchRange {
            start: self.at,
            end: self.end,
            mode: Mode::Search,
            advance: self.advance,
        };
        let found = self.pattern.find(ev, &self.text, range)?;
        match found
            .as_ref()
            .and_then(|found| found.first().copied().flatten())
        {
            Some((start, end)) => {
                self.at = end;
                self.advance = start == end;
            }
            None => self.at = self.end + 1,
        }
        Ok(found)
    }
}
