//! `_re`: regular expressions of Python on fancy-regex.
//!
//! `translate` turns Python's syntax into that of the crate and finds the errors Python reports. Patterns without
//! look-around and back-references run in linear time; the others backtrack within a bound ([`BACKTRACK_MAX`]), beyond
//! which `RuntimeError` is raised instead of running on. Differences: look-behind, `\d` and the like follow Unicode as
//! regex-syntax has it; a group in a repetition that was not entered in its last round keeps its earlier text.

mod found;
mod paced;
mod translate;

use std::cell::OnceCell;
use std::rc::Rc;

use fancy_regex::{BytesMode, Captures, Input, Regex, RegexBuilder, RegexInput};

use super::define::{Builder, Entry, instance, with_data};
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::value::bytes::Data;
use crate::value::iter::NativeIter;
use crate::value::{Bytes, Iter, R, Raised, Value};

use found::{MATCH, make_match, with_match};
use paced::{Machine, Search};
use translate::{Translated, flag, translate};

/// Steps back that one search may take.
const BACKTRACK_MAX: usize = 500_000;
/// Bytes of a compiled expression.
const SIZE_MAX: usize = 4 << 20;

pub(super) fn fill(module: &Builder<'_, '_>) -> R<()> {
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
            let names = p.parsed.names.iter();
            Ok(Value::dict_of(names.map(|(name, index)| {
                (name.clone(), Value::Int(*index as i64))
            })))
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
            let span = |span: &Option<(usize, usize)>| match span {
                Some((start, end)) => vec![m.text.index(*start), m.text.index(*end)],
                None => vec![outside.clone(), outside.clone()],
            };
            Ok(Value::tuple(
                m.spans.iter().map(|s| Value::tuple(span(s))).collect(),
            ))
        })
    });
    module.property(&found, "lastindex", |ev, args| {
        with_match(ev, args, |m| {
            Ok(m.last_index()
                .map_or(Value::None, |index| Value::Int(index as i64)))
        })
    });
    module.property(&found, "lastgroup", |ev, args| {
        with_match(ev, args, |m| {
            let last = m.last_index();
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

/// A compiled pattern.
struct Pattern {
    source: Value,
    parsed: Translated,
    is_bytes: bool,
    search: Engine,
    /// The same, but matching no empty text.
    not_empty: OnceCell<Option<Engine>>,
    /// The same, up to the end of the text.
    full: OnceCell<Option<Engine>>,
}

/// What searches for one form of a pattern.
struct Engine {
    regex: Regex,
    pattern: String,
    groups: usize,
    is_bytes: bool,
    not_empty: bool,
    /// For long texts.
    machine: OnceCell<Option<Machine>>,
}

/// Bytes of a text that are searched at once.
const AT_ONCE: usize = if cfg!(debug_assertions) {
    1 << 10
} else {
    1 << 15
};
/// Work to try an expression at one place.
const ATTEMPT: usize = 512;

impl Engine {
    /// For `pattern`, which is that of `parsed` or made of it.
    fn new(
        parsed: &Translated,
        pattern: &str,
        is_bytes: bool,
        not_empty: bool,
    ) -> Result<Engine, String> {
        Ok(Engine {
            regex: build(pattern, is_bytes, not_empty)?,
            pattern: pattern.to_owned(),
            groups: parsed.groups,
            is_bytes,
            not_empty,
            machine: OnceCell::new(),
        })
    }

    fn machine(&self) -> Option<&Machine> {
        let make = || Machine::new(&self.pattern, self.groups, self.is_bytes);
        self.machine.get_or_init(make).as_ref()
    }

    /// The groups of the first match in a range of a text, or of the one that begins where that does. A text that would take
    /// long is searched with safepoints.
    fn run(
        &self,
        ev: &Evaluator<'_>,
        text: &Text,
        (start, end): (usize, usize),
        anchored: bool,
    ) -> R<Option<Spans>> {
        ev.safepoint()?;
        if end - start <= AT_ONCE {
            return self.at_once(ev, text, (start, end), anchored);
        }
        if let Some(machine) = self.machine() {
            let search = Search {
                text: &text.data()[..end],
                start,
                anchored,
                not_empty: self.not_empty,
            };
            return machine.find(ev, search);
        }
        let mut at = start;
        while !anchored && at < end {
            if let Some(found) = self.at_once(ev, text, (at, end), true)? {
                return Ok(Some(found));
            }
            ev.worked(ATTEMPT)?;
            at = text.after(at);
        }
        self.at_once(ev, text, (at, end), true)
    }

    /// The same in one piece.
    fn at_once(
        &self,
        ev: &Evaluator<'_>,
        text: &Text,
        (start, end): (usize, usize),
        anchored: bool,
    ) -> R<Option<Spans>> {
        // Python lets the text end at `endpos`, but begin where it begins.
        let found = match text {
            Text::Str(text, _) => {
                let input = RegexInput::new(&text.as_str()[..end])
                    .from_pos(start)
                    .anchored(anchored);
                let found = self.regex.captures_input(input);
                found.map(|found| found.map(|found| spans(&found, self.groups)))
            }
            Text::Bytes(data, _) => {
                let input = RegexInput::new(&data[..end])
                    .from_pos(start)
                    .anchored(anchored);
                let found = self.regex.captures_input(input);
                found.map(|found| found.map(|found| spans(&found, self.groups)))
            }
        };
        let Ok(found) = found else {
            let text = format!(
                "the regular expression takes more than {BACKTRACK_MAX} steps back on this text"
            );
            return Err(ev.raise(ExceptionKind::RuntimeError, text));
        };
        let whole = |found: &Spans| found.first().copied().flatten();
        Ok(found.filter(|found| {
            whole(found).is_some_and(|(from, to)| {
                (!anchored || from == start) && !(self.not_empty && from == to)
            })
        }))
    }
}

fn build(pattern: &str, is_bytes: bool, not_empty: bool) -> Result<Regex, String> {
    let mut builder = RegexBuilder::new(pattern);
    builder
        .backtrack_limit(BACKTRACK_MAX)
        .delegate_size_limit(SIZE_MAX)
        .delegate_dfa_size_limit(SIZE_MAX)
        .find_not_empty(not_empty);
    if is_bytes {
        builder.bytes_mode(BytesMode::Ascii);
    }
    builder.build().map_err(|error| error.to_string())
}

fn compile(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let source = ev.plain(&args[0]);
    let (text, is_bytes) = match &source {
        Value::Str(text) => (text.as_str().to_owned(), false),
        other => match ev.bytes_like(other) {
            // Byte by byte, as the characters of the same numbers.
            Some(data) => (data.iter().map(|byte| char::from(*byte)).collect(), true),
            None => return Err(ev.type_error("first argument must be string or compiled pattern")),
        },
    };
    let flags = ev.clamped_index(&args[1])?.clamp(0, i64::from(u32::MAX)) as u32;
    if text.len() > 1 << 20 {
        return Err(ev.value_error("the regular expression is longer than 1 MiB"));
    }
    let parsed = match translate(&text, flags, is_bytes) {
        Ok(parsed) => parsed,
        Err(error) => {
            return Err(pattern_error(
                ev,
                &args[2],
                &source,
                &error.message,
                error.position,
            ));
        }
    };
    let search = match Engine::new(&parsed, &parsed.pattern, is_bytes, false) {
        Ok(search) => search,
        Err(message) => {
            let message = if message
                .to_lowercase()
                .replace('-', "")
                .contains("lookbehind")
            {
                "look-behind requires fixed-width pattern".to_owned()
            } else {
                format!("not supported: {message}")
            };
            return Err(pattern_error(ev, &args[2], &source, &message, None));
        }
    };
    let pattern = Pattern {
        source,
        parsed,
        is_bytes,
        search,
        not_empty: OnceCell::new(),
        full: OnceCell::new(),
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
) -> Raised {
    let position = position.map_or(Value::None, |position| Value::Int(position as i64));
    match ev.call(
        class,
        &mut [Value::str(message), source.clone(), position],
        &[],
    ) {
        Ok(Value::Instance(exception)) => Raised::Exception(exception),
        Ok(_) => ev.value_error(message),
        Err(raised) => raised,
    }
}

/// The text that is searched.
#[derive(Clone)]
enum Text {
    Str(Rc<crate::value::Str>, Value),
    Bytes(Data, Value),
}

impl Text {
    fn of(ev: &Evaluator<'_>, pattern: &Pattern, value: &Value) -> R<Text> {
        match (ev.plain(value), pattern.is_bytes) {
            (Value::Str(text), false) => {
                ev.mark(&text)?;
                Ok(Text::Str(text, value.clone()))
            }
            (Value::Str(_), true) => {
                Err(ev.type_error("cannot use a bytes pattern on a string-like object"))
            }
            (other, is_bytes) => match ev.bytes_like(&other) {
                Some(data) if is_bytes => Ok(Text::Bytes(data, value.clone())),
                Some(_) => Err(ev.type_error("cannot use a string pattern on a bytes-like object")),
                None => {
                    let name = ev.core.types.name_of(&other);
                    Err(ev.type_error(format!(
                        "expected string or bytes-like object, got '{name}'"
                    )))
                }
            },
        }
    }

    fn value(&self) -> Value {
        match self {
            Text::Str(_, value) | Text::Bytes(_, value) => value.clone(),
        }
    }

    fn len(&self) -> usize {
        match self {
            Text::Str(text, _) => text.as_str().len(),
            Text::Bytes(data, _) => data.len(),
        }
    }

    fn data(&self) -> &[u8] {
        match self {
            Text::Str(text, _) => text.as_str().as_bytes(),
            Text::Bytes(data, _) => data,
        }
    }

    /// The byte offset of a position that the program gives.
    fn offset(&self, index: i64) -> usize {
        let index = usize::try_from(index).unwrap_or(0);
        match self {
            Text::Str(text, _) => text.byte_offset(index.min(text.len())),
            Text::Bytes(data, _) => index.min(data.len()),
        }
    }

    /// The position of a byte offset, as programs count.
    fn index(&self, offset: usize) -> Value {
        Value::Int(match self {
            Text::Str(text, _) => text.char_index(offset) as i64,
            Text::Bytes(..) => offset as i64,
        })
    }

    fn slice(&self, ev: &Evaluator<'_>, (start, end): (usize, usize)) -> R {
        match self {
            Text::Str(text, _) => ev.string_of(&text.as_str()[start..end]),
            Text::Bytes(data, _) => ev.copied_bytes(&data[start..end]).map(Value::bytes),
        }
    }

    /// The end of the character at an offset.
    fn after(&self, offset: usize) -> usize {
        match self {
            Text::Str(text, _) => {
                let c = text.as_str()[offset..].chars().next();
                offset + c.map_or(1, char::len_utf8)
            }
            Text::Bytes(..) => offset + 1,
        }
    }
}

type Spans = Vec<Option<(usize, usize)>>;

/// How a pattern is to match.
#[derive(Clone, Copy, PartialEq)]
enum Mode {
    Search,
    Match,
    Full,
}

fn spans<'t, S: Input<Match<'t>: Span> + ?Sized + 't>(
    captures: &Captures<'t, S>,
    groups: usize,
) -> Spans {
    (0..=groups)
        .map(|group| captures.get(group).map(|found| found.span()))
        .collect()
}

/// Matches of both kinds of text.
trait Span {
    fn span(&self) -> (usize, usize);
}

impl Span for fancy_regex::Match<'_> {
    fn span(&self) -> (usize, usize) {
        (self.start(), self.end())
    }
}

impl Span for fancy_regex::MatchBytes<'_> {
    fn span(&self) -> (usize, usize) {
        (self.start(), self.end())
    }
}

impl Pattern {
    /// The groups of the next match in `range`, the whole first.
    fn find(
        &self,
        ev: &Evaluator<'_>,
        text: &Text,
        range: (usize, usize),
        mode: Mode,
        advance: bool,
    ) -> R<Option<Spans>> {
        if range.0 > range.1 {
            return Ok(None);
        }
        if advance {
            // Right here only something that is not empty; further on anything.
            let not_empty = self.not_empty.get_or_init(|| {
                Engine::new(&self.parsed, &self.parsed.pattern, self.is_bytes, true).ok()
            });
            if let Some(engine) = not_empty
                && let Some(found) = engine.run(ev, text, range, true)?
            {
                return Ok(Some(found));
            }
            if mode != Mode::Search || range.0 >= range.1 {
                return Ok(None);
            }
            return self.find(ev, text, (text.after(range.0), range.1), mode, false);
        }
        match mode {
            Mode::Search => self.search.run(ev, text, range, false),
            Mode::Match => self.search.run(ev, text, range, true),
            Mode::Full => {
                let full = self.full.get_or_init(|| {
                    let pattern = format!("(?:{})\\z", self.parsed.pattern);
                    Engine::new(&self.parsed, &pattern, self.is_bytes, false).ok()
                });
                match full {
                    Some(engine) => engine.run(ev, text, range, true),
                    None => Ok(None),
                }
            }
        }
    }
}

/// Goes through all matches in a text.
struct Scanner {
    pattern: Rc<Pattern>,
    text: Text,
    at: usize,
    end: usize,
    /// The last match was empty: the next one here must not be.
    advance: bool,
}

impl Scanner {
    fn next(&mut self, ev: &Evaluator<'_>) -> R<Option<Spans>> {
        let found = self.pattern.find(
            ev,
            &self.text,
            (self.at, self.end),
            Mode::Search,
            self.advance,
        )?;
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

fn with_pattern(ev: &Evaluator<'_>, args: &[Value], act: impl FnOnce(&Rc<Pattern>) -> R) -> R {
    with_data(ev, &args[0], |pattern: &Rc<Pattern>| act(pattern))
}

fn range(ev: &Evaluator<'_>, text: &Text, pos: &Value, endpos: &Value) -> R<(usize, usize)> {
    let start = pos.given().map_or(Ok(0), |pos| ev.clamped_index(pos))?;
    let end = match endpos.given() {
        Some(end) => text.offset(ev.clamped_index(end)?),
        None => text.len(),
    };
    Ok((text.offset(start), end))
}

fn one(ev: &Evaluator<'_>, args: &[Value], mode: Mode) -> R {
    with_pattern(ev, args, |pattern| {
        let text = Text::of(ev, pattern, &args[1])?;
        let range = range(ev, &text, &args[2], &args[3])?;
        match pattern.find(ev, &text, range, mode, false)? {
            Some(spans) => make_match(ev, &args[0], pattern, &text, range, spans),
            None => Ok(Value::None),
        }
    })
}

fn scanner(
    ev: &Evaluator<'_>,
    pattern: &Rc<Pattern>,
    text: &Value,
    pos: &Value,
    endpos: &Value,
) -> R<Scanner> {
    let text = Text::of(ev, pattern, text)?;
    let (at, end) = range(ev, &text, pos, endpos)?;
    Ok(Scanner {
        pattern: pattern.clone(),
        text,
        at,
        end,
        advance: false,
    })
}

const PATTERN: &[Entry] = &[
    ("search", "string pos? endpos?", |ev, args| {
        one(ev, args, Mode::Search)
    }),
    ("match", "string pos? endpos?", |ev, args| {
        one(ev, args, Mode::Match)
    }),
    ("fullmatch", "string pos? endpos?", |ev, args| {
        one(ev, args, Mode::Full)
    }),
    ("findall", "string pos? endpos?", |ev, args| {
        with_pattern(ev, args, |pattern| {
            let mut scanner = scanner(ev, pattern, &args[1], &args[2], &args[3])?;
            let empty = scanner.text.slice(ev, (0, 0))?;
            let mut found = Vec::new();
            while let Some(spans) = scanner.next(ev)? {
                let text = |span: &Option<(usize, usize)>| match span {
                    Some(span) => scanner.text.slice(ev, *span),
                    None => Ok(empty.clone()),
                };
                found.push(match spans.len() {
                    1 => text(&spans[0])?,
                    2 => text(&spans[1])?,
                    _ => Value::tuple(spans[1..].iter().map(text).collect::<R<_>>()?),
                });
                ev.grow(&mut found, 1)?;
                ev.check_memory()?;
            }
            Ok(Value::list(found))
        })
    }),
    ("finditer", "string pos? endpos?", |ev, args| {
        with_pattern(ev, args, |pattern| {
            let scanner = scanner(ev, pattern, &args[1], &args[2], &args[3])?;
            let range = (scanner.at, scanner.end);
            let (receiver, scanner) = (args[0].clone(), std::cell::RefCell::new(scanner));
            let next = move |ev: &Evaluator<'_>| {
                // A search may let another thread run; that one must not step the same iterator.
                let Ok(mut stepped) = scanner.try_borrow_mut() else {
                    return Err(ev.value_error("iterator already executing"));
                };
                let found = stepped.next(ev)?;
                drop(stepped);
                let scanner = scanner.borrow();
                let make = |spans| {
                    make_match(ev, &receiver, &scanner.pattern, &scanner.text, range, spans)
                };
                found.map(make).transpose()
            };
            let class = ev.core.types.callable_iterator.clone();
            Ok(Value::Iter(Rc::new(Iter::Native(NativeIter::new(
                class, next,
            )))))
        })
    }),
    ("split", "string maxsplit?", |ev, args| {
        let most = args[2]
            .given()
            .map_or(Ok(0), |most| ev.clamped_index(most))?;
        with_pattern(ev, args, |pattern| {
            let mut scanner = scanner(ev, pattern, &args[1], &Value::Unbound, &Value::Unbound)?;
            let (mut parts, mut from, mut count) = (Vec::new(), 0, 0);
            while most == 0 || count < most {
                let Some(spans) = scanner.next(ev)? else {
                    break;
                };
                let (start, end) = spans[0].unwrap_or_default();
                ev.grow(&mut parts, spans.len())?;
                parts.push(scanner.text.slice(ev, (from, start))?);
                for span in &spans[1..] {
                    parts.push(match span {
                        Some(span) => scanner.text.slice(ev, *span)?,
                        None => Value::None,
                    });
                }
                ev.check_memory()?;
                from = end;
                count += 1;
            }
            parts.push(scanner.text.slice(ev, (from, scanner.text.len()))?);
            Ok(Value::list(parts))
        })
    }),
    // `repl` is a function, or a list of texts and group numbers made from a template.
    ("_subn", "repl string count", |ev, args| {
        let most = ev.clamped_index(&args[3])?;
        with_pattern(ev, args, |pattern| substitute(ev, pattern, args, most))
    }),
    ("sub", "repl string count?", |ev, args| {
        let pair = with_template(ev, args)?;
        ev.item(&pair, &Value::Int(0))
    }),
    ("subn", "repl string count?", with_template),
    ("__repr__", "", |ev, args| {
        with_pattern(ev, args, |pattern| {
            let source: String = ev.repr(&pattern.source)?.chars().take(200).collect();
            let own = pattern.parsed.flags & !if pattern.is_bytes { 0 } else { flag::UNICODE };
            let names = [
                (flag::IGNORECASE, "re.IGNORECASE"),
                (flag::LOCALE, "re.LOCALE"),
                (flag::MULTILINE, "re.MULTILINE"),
                (flag::DOTALL, "re.DOTALL"),
                (flag::VERBOSE, "re.VERBOSE"),
                (flag::ASCII, "re.ASCII"),
            ];
            let set: Vec<&str> = names
                .iter()
                .filter(|(bit, _)| own & bit != 0)
                .map(|(_, name)| *name)
                .collect();
            let flags = if set.is_empty() {
                String::new()
            } else {
                format!(", {}", set.join("|"))
            };
            Ok(Value::str(format!("re.compile({source}{flags})")))
        })
    }),
    ("__eq__", "other /", |ev, args| {
        let same = args[0].is(&args[1])
            || with_data(ev, &args[0], |a: &Rc<Pattern>| {
                let other = with_data(ev, &args[1], |b: &Rc<Pattern>| Ok(b.clone()));
                Ok(other.is_ok_and(|b| {
                    a.parsed.flags == b.parsed.flags
                        && ev.equal(&a.source, &b.source).unwrap_or(false)
                }))
            })?;
        Ok(Value::Bool(same))
    }),
    ("__hash__", "", |ev, args| {
        with_pattern(ev, args, |pattern| {
            ev.hash(&pattern.source).map(|hash| Value::Int(hash as i64))
        })
    }),
    ("__copy__", "", |_, args| Ok(args[0].clone())),
    ("__deepcopy__", "memo /", |_, args| Ok(args[0].clone())),
];

/// `subn` as the script module has it, which understands templates.
fn with_template(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let module = ev.import("re")?;
    let subn = ev.attribute(&module, ev.core.symbols.intern("_subn"))?;
    let count = args[3].given().cloned().unwrap_or(Value::Int(0));
    ev.call(
        &subn,
        &mut [args[0].clone(), args[1].clone(), args[2].clone(), count],
        &[],
    )
}

fn substitute(ev: &Evaluator<'_>, pattern: &Rc<Pattern>, args: &[Value], most: i64) -> R {
    let mut scanner = scanner(ev, pattern, &args[2], &Value::Unbound, &Value::Unbound)?;
    let template = args[1].as_items();
    let mut out: Vec<u8> = Vec::new();
    let push = |out: &mut Vec<u8>, value: &Value| match ev.plain(value) {
        Value::Str(text) if !pattern.is_bytes => ev.push_bytes(out, text.as_str().as_bytes()),
        other => match ev.bytes_like(&other) {
            Some(data) if pattern.is_bytes => ev.push_bytes(out, &data),
            _ => {
                let name = ev.core.types.name_of(&other);
                let wanted = if pattern.is_bytes {
                    "a bytes-like object"
                } else {
                    "str instance"
                };
                Err(ev.type_error(format!("sequence item 1: expected {wanted}, {name} found")))
            }
        },
    };
    let copy = |out: &mut Vec<u8>, text: &Text, (start, end): (usize, usize)| match text {
        Text::Str(text, _) => ev.push_bytes(out, &text.as_str().as_bytes()[start..end]),
        Text::Bytes(data, _) => ev.push_bytes(out, &data[start..end]),
    };
    let (mut from, mut count) = (0, 0);
    while most <= 0 || count < most {
        let Some(spans) = scanner.next(ev)? else {
            break;
        };
        let (start, end) = spans[0].unwrap_or_default();
        copy(&mut out, &scanner.text, (from, start))?;
        from = end;
        count += 1;
        match &template {
            Some(parts) => {
                for part in parts {
                    match part {
                        Value::Int(group) => {
                            if let Some(span) = spans.get(*group as usize).copied().flatten() {
                                copy(&mut out, &scanner.text, span)?;
                            }
                        }
                        text => push(&mut out, text)?,
                    }
                }
            }
            None => {
                let range = (0, scanner.text.len());
                let found = make_match(ev, &args[0], pattern, &scanner.text, range, spans)?;
                let text = ev.call1(&args[1], found)?;
                if !text.is_none() {
                    push(&mut out, &text)?;
                }
            }
        }
        ev.check_allocation(out.len())?;
    }
    copy(&mut out, &scanner.text, (from, scanner.text.len()))?;
    let result = if pattern.is_bytes {
        Value::Bytes(Rc::new(Bytes::new(out)))
    } else {
        // Made of whole strings only.
        let text = String::from_utf8(out);
        ev.string(
            text.unwrap_or_else(|wrong| String::from_utf8_lossy(wrong.as_bytes()).into_owned()),
        )?
    };
    Ok(Value::tuple(vec![result, Value::Int(count)]))
}
