//! Methods of `str`.

use std::collections::HashSet;
use std::rc::Rc;

use compact_str::CompactString;

use super::bounds::Bounds;
use super::string::{receiver, text_argument};
use super::{methods, raw_method};
use crate::errors::ExceptionKind;
use crate::eval::bulk::{EACH, STRIDE, many, pieces};
use crate::eval::{Core, Evaluator};
use crate::ops::search::Occurrences;
use crate::ops::unicode;
use crate::value::symbol::Symbol;
use crate::value::{Bytes, R, Str, Value};

pub(super) fn install(core: &Rc<Core>) {
    let class = &core.types.str;
    methods(
        core,
        class,
        &[
            ("upper", "", |ev, args| {
                mapped(ev, args, |text, out| out.push_str(&text.to_uppercase()))
            }),
            ("lower", "", |ev, args| {
                let text = receiver(ev, &args[0])?;
                ev.string(lowered(ev, text.as_str(), 0)?)
            }),
            ("casefold", "", |ev, args| {
                mapped(ev, args, |text, out| out.push_str(&unicode::casefold(text)))
            }),
            ("capitalize", "", capitalize),
            ("title", "", |ev, args| {
                let mut inside = false;
                mapped(ev, args, |text, out| title(text, &mut inside, out))
            }),
            ("swapcase", "", |ev, args| mapped(ev, args, swapcase)),
            ("strip", "chars? /", |ev, args| strip(ev, args, true, true)),
            ("lstrip", "chars? /", |ev, args| {
                strip(ev, args, true, false)
            }),
            ("rstrip", "chars? /", |ev, args| {
                strip(ev, args, false, true)
            }),
            ("split", "sep? maxsplit?", |ev, args| split(ev, args, false)),
            ("rsplit", "sep? maxsplit?", |ev, args| split(ev, args, true)),
            ("splitlines", "keepends?", splitlines),
            ("partition", "sep /", |ev, args| partition(ev, args, false)),
            ("rpartition", "sep /", |ev, args| partition(ev, args, true)),
            ("join", "iterable /", join),
            ("replace", "old new count? /", replace),
            ("find", "sub start? end? /", |ev, args| {
                find(ev, args, false, false)
            }),
            ("rfind", "sub start? end? /", |ev, args| {
                find(ev, args, true, false)
            }),
            ("index", "sub start? end? /", |ev, args| {
                find(ev, args, false, true)
            }),
            ("rindex", "sub start? end? /", |ev, args| {
                find(ev, args, true, true)
            }),
            ("count", "sub start? end? /", count),
            ("startswith", "prefix start? end? /", |ev, args| {
                affix(ev, args, "startswith", begins)
            }),
            ("endswith", "suffix start? end? /", |ev, args| {
                affix(ev, args, "endswith", ends)
            }),
            ("removeprefix", "prefix /", |ev, args| {
                let part = named_text(ev, &args[1], "removeprefix")?;
                let text = receiver(ev, &args[0])?;
                match begins(ev, text.as_str(), part.as_str())? {
                    true => ev.string_of(&text.as_str()[part.as_str().len()..]),
                    false => Ok(Value::Str(text)),
                }
            }),
            ("removesuffix", "suffix /", |ev, args| {
                let part = named_text(ev, &args[1], "removesuffix")?;
                let text = receiver(ev, &args[0])?;
                match ends(ev, text.as_str(), part.as_str())? {
                    true => {
                        let length = text.as_str().len() - part.as_str().len();
                        ev.string_of(&text.as_str()[..length])
                    }
                    false => Ok(Value::Str(text)),
                }
            }),
            ("center", "width fillchar? /", |ev, args| pad(ev, args, '^')),
            ("ljust", "width fillchar? /", |ev, args| pad(ev, args, '<')),
            ("rjust", "width fillchar? /", |ev, args| pad(ev, args, '>')),
            ("zfill", "width /", zfill),
            ("expandtabs", "tabsize?", expandtabs),
            ("encode", "encoding? errors?", |ev, args| {
                let data = ev.encode(&*receiver(ev, &args[0])?, &args[1], &args[2])?;
                Ok(Value::Bytes(Rc::new(Bytes::new(data))))
            }),
            ("isalpha", "", |ev, args| all(ev, args, unicode::is_letter)),
            ("isdigit", "", |ev, args| all(ev, args, unicode::is_digit)),
            ("isdecimal", "", |ev, args| {
                all(ev, args, |c| unicode::decimal(c).is_some())
            }),
            ("isnumeric", "", |ev, args| {
                all(ev, args, unicode::is_numeric)
            }),
            ("isalnum", "", |ev, args| {
                all(ev, args, char::is_alphanumeric)
            }),
            ("isspace", "", |ev, args| all(ev, args, is_space)),
            ("isascii", "", |ev, args| {
                Ok(Value::Bool(receiver(ev, &args[0])?.is_ascii()))
            }),
            ("isprintable", "", |ev, args| {
                let text = receiver(ev, &args[0])?;
                let all = ev.all_chars(text.as_str(), crate::ops::text::is_printable)?;
                Ok(Value::Bool(all))
            }),
            ("isupper", "", |ev, args| {
                cased(ev, args, char::is_uppercase, char::is_lowercase)
            }),
            ("islower", "", |ev, args| {
                cased(ev, args, char::is_lowercase, char::is_uppercase)
            }),
            ("istitle", "", |ev, args| {
                let text = receiver(ev, &args[0])?;
                let mut title = Title::default();
                for piece in pieces(text.as_str()) {
                    if !title.goes_on(piece.chars()) {
                        return Ok(Value::Bool(false));
                    }
                    ev.worked(piece.len() * EACH)?;
                }
                Ok(Value::Bool(title.is_one()))
            }),
            ("isidentifier", "", |ev, args| {
                let text = receiver(ev, &args[0])?;
                let first = text.as_str().chars().next();
                let begins = first.is_some_and(|c| c == '_' || c.is_alphabetic());
                let goes_on = |c: char| c == '_' || c.is_alphanumeric();
                let all = begins && ev.all_chars(text.as_str(), goes_on)?;
                Ok(Value::Bool(all))
            }),
            ("format_map", "mapping /", |ev, args| {
                let text = receiver(ev, &args[0])?;
                let mut keywords: Vec<(Symbol, Value)> = Vec::new();
                let mut names = Vec::new();
                for name in crate::format::field_names(ev, text.as_str()) {
                    let name = name?;
                    let symbol = ev.core.symbols.ask(name);
                    if !keywords.iter().any(|(known, _)| *known == *symbol) {
                        let value = ev.item(&args[1], &Value::str(name))?;
                        keywords.push((*symbol, value));
                        names.push(symbol);
                    }
                }
                let args = crate::builtins::Args {
                    positional: &mut [],
                    keywords: &keywords,
                    caller: None,
                };
                ev.format_fields(text.as_str(), &args)
                    .and_then(|text| ev.string(text))
                    .map_err(|raised| {
                        if ev.is_kind(&raised, ExceptionKind::IndexError) {
                            let text = "Format string contains positional fields";
                            return ev.value_error(text);
                        }
                        raised
                    })
            }),
            ("translate", "table /", translate),
        ],
    );
    raw_method(core, class, "format", |ev, args| {
        let Some((first, rest)) = args.positional.split_first_mut() else {
            return Err(ev.type_error("unbound method str.format() needs an argument"));
        };
        let text = receiver(ev, first)?;
        let args = crate::builtins::Args {
            positional: rest,
            keywords: args.keywords,
            caller: None,
        };
        ev.string(ev.format_fields(text.as_str(), &args)?)
    });
    let maketrans = crate::builtins::Builtin::bound(core, "maketrans", "x y? z? /", maketrans);
    class.set(
        core.symbols.intern("maketrans"),
        Value::StaticMethod(Rc::new(maketrans)),
    );
}

/// A string argument, named in the error for anything else.
fn named_text(ev: &Evaluator<'_>, value: &Value, method: &str) -> R<Rc<Str>> {
    text_argument(ev, value).map_err(|_| {
        let name = ev.core.types.name_of(value);
        ev.type_error(format!("{method}() argument must be str, not {name}"))
    })
}

/// A text mapped piece by piece; where the pieces are cut must not matter.
fn mapped(ev: &Evaluator<'_>, args: &[Value], map: impl FnMut(&str, &mut String)) -> R {
    let text = receiver(ev, &args[0])?;
    ev.string(ev.mapped_text(text.as_str(), map)?)
}

fn capitalize(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let text = receiver(ev, &args[0])?;
    let text = text.as_str();
    let Some(first) = text.chars().next() else {
        return Ok(ev.core.empty_str.clone());
    };
    let mut out = String::new();
    unicode::push_title(first, &mut out);
    ev.push_text(&mut out, &lowered(ev, text, first.len_utf8())?)?;
    ev.string(out)
}

/// The lower case of a text from a byte on. A capital sigma at the end of a word has a small form of its own.
fn lowered(ev: &Evaluator<'_>, text: &str, from: usize) -> R<String> {
    let mut at = from;
    let lower = |piece: &str, out: &mut String| {
        let mut rest = piece;
        while let Some(sigma) = rest.find('Σ') {
            out.push_str(&rest[..sigma].to_lowercase());
            let after = sigma + 'Σ'.len_utf8();
            let place = at + (piece.len() - rest.len()) + sigma;
            let ends = unicode::ends_word(&text[..place], &text[place + 'Σ'.len_utf8()..]);
            out.push(if ends { 'ς' } else { 'σ' });
            rest = &rest[after..];
        }
        out.push_str(&rest.to_lowercase());
        at += piece.len();
    };
    ev.mapped_text(&text[from..], lower)
}

fn title(text: &str, inside: &mut bool, out: &mut String) {
    for c in text.chars() {
        if *inside {
            out.extend(c.to_lowercase())
        } else {
            unicode::push_title(c, out)
        }
        *inside = unicode::is_cased(c);
    }
}

/// What has been seen of a text that may be one in title case.
#[derive(Default)]
pub(super) struct Title {
    inside: bool,
    any: bool,
}

impl Title {
    /// Whether it still may be one with these characters.
    pub(super) fn goes_on(&mut self, mut chars: impl Iterator<Item = char>) -> bool {
        chars.all(|c| {
            if c.is_uppercase() || unicode::is_title_form(c) {
                if self.inside {
                    return false;
                }
                (self.inside, self.any) = (true, true);
            } else if c.is_lowercase() {
                if !self.inside {
                    return false;
                }
                self.any = true;
            } else {
                self.inside = false;
            }
            true
        })
    }

    /// Whether what has been seen is one.
    pub(super) fn is_one(&self) -> bool {
        self.any
    }
}

fn swapcase(text: &str, out: &mut String) {
    for c in text.chars() {
        if c.is_uppercase() {
            out.extend(c.to_lowercase())
        } else if c.is_lowercase() {
            out.extend(c.to_uppercase())
        } else {
            out.push(c);
        }
    }
}

fn begins(ev: &Evaluator<'_>, text: &str, part: &str) -> R<bool> {
    match text.as_bytes().get(..part.len()) {
        Some(text) => ev.equal_bytes(text, part.as_bytes()),
        None => Ok(false),
    }
}

fn ends(ev: &Evaluator<'_>, text: &str, part: &str) -> R<bool> {
    match text.len().checked_sub(part.len()) {
        Some(from) => ev.equal_bytes(&text.as_bytes()[from..], part.as_bytes()),
        None => Ok(false),
    }
}

/// White space as Python's `str.isspace` has it: Unicode's, and the separators 0x1c to 0x1f.
pub(super) fn is_space(c: char) -> bool {
    c.is_whitespace() || matches!(c, '\x1c'..='\x1f')
}

fn strip(ev: &Evaluator<'_>, args: &[Value], left: bool, right: bool) -> R {
    let text = receiver(ev, &args[0])?;
    let chars: Option<CharSet> = match args[1].given() {
        None | Some(Value::None) => None,
        Some(value) => match ev.plain(value) {
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
        part = &part[ev.leading(part, cut)?..];
    }
    if right {
        part = &part[..part.len() - ev.trailing(part, cut)?];
    }
    if part.len() == text.as_str().len() {
        return Ok(Value::Str(text.clone()));
    }
    ev.string_of(part)
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
            ev.worked(piece.len() * EACH)?;
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

fn split(ev: &Evaluator<'_>, args: &[Value], from_right: bool) -> R {
    let text = receiver(ev, &args[0])?;
    let most = match args[2].given() {
        Some(value) => usize::try_from(ev.clamped_index(value)?).unwrap_or(usize::MAX),
        None => usize::MAX,
    };
    let separator = match args[1].given() {
        None | Some(Value::None) => None,
        Some(separator) => Some(text_argument(ev, separator).map_err(|_| {
            let name = ev.core.types.name_of(separator);
            ev.type_error(format!("must be str or None, not {name}"))
        })?),
    };
    let mut parts = Parts::new(ev, &text);
    match separator {
        None => parts.between_spaces(most, from_right)?,
        Some(separator) if separator.is_empty() => return Err(ev.value_error("empty separator")),
        Some(separator) if from_right => parts.back_between(separator.as_str(), most)?,
        Some(separator) => parts.between(separator.as_str(), most)?,
    }
    if from_right {
        parts.list.reverse();
    }
    Ok(Value::list(parts.list))
}

/// The parts of a text, as they are found.
struct Parts<'p, 'y> {
    ev: &'p Evaluator<'y>,
    whole: &'p Str,
    list: Vec<Value>,
}

impl<'p, 'y> Parts<'p, 'y> {
    fn new(ev: &'p Evaluator<'y>, whole: &'p Str) -> Self {
        let list = Vec::new();
        Parts { ev, whole, list }
    }

    fn push(&mut self, part: &str) -> R<()> {
        self.ev.grow(&mut self.list, 1)?;
        self.list.push(part_of(self.ev, self.whole, part)?);
        // So that what a text is taken apart into never goes far beyond the limit.
        match self.list.len().is_multiple_of(1024) {
            true => self.ev.check_memory(),
            false => Ok(()),
        }
    }

    fn between(&mut self, separator: &str, most: usize) -> R<()> {
        let text = self.whole.as_str();
        let mut found = Occurrences::new(text.as_bytes(), separator.as_bytes());
        let mut start = 0;
        while self.list.len() < most
            && let Some(at) = found.next(self.ev)?
        {
            self.push(&text[start..at])?;
            start = at + separator.len();
        }
        self.push(&text[start..])
    }

    fn back_between(&mut self, separator: &str, most: usize) -> R<()> {
        let text = self.whole.as_str();
        let mut found = Occurrences::from_end(text.as_bytes(), separator.as_bytes());
        let mut end = text.len();
        while self.list.len() < most
            && let Some(at) = found.next_back(self.ev)?
        {
            self.push(&text[at + separator.len()..end])?;
            end = at;
        }
        self.push(&text[..end])
    }

    /// Splits at runs of white space, at most `most` times; the rest keeps its inner white space.
    fn between_spaces(&mut self, most: usize, from_right: bool) -> R<()> {
        let (ev, text) = (self.ev, self.whole.as_str());
        let is_word = |c: char| !is_space(c);
        let mut rest = match from_right {
            true => &text[..text.len() - ev.trailing(text, is_space)?],
            false => &text[ev.leading(text, is_space)?..],
        };
        while !rest.is_empty() {
            if self.list.len() == most {
                return self.push(rest);
            }
            ev.worked(EACH)?;
            if from_right {
                let at = rest.len() - ev.trailing(rest, is_word)?;
                self.push(&rest[at..])?;
                rest = &rest[..at - ev.trailing(&rest[..at], is_space)?];
            } else {
                let at = ev.leading(rest, is_word)?;
                self.push(&rest[..at])?;
                rest = &rest[at + ev.leading(&rest[at..], is_space)?..];
            }
        }
        Ok(())
    }
}

/// A part of a text as a string of its own.
#[inline]
fn part_of(ev: &Evaluator<'_>, whole: &Str, part: &str) -> R {
    if whole.is_ascii() && part.len() <= STRIDE {
        ev.worked(many(part.len()))?;
        return Ok(Value::Str(Rc::new(Str::counted(part, part.len()))));
    }
    ev.string_of(part)
}

fn splitlines(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let keep = args[1].given().map_or(Ok(0), |value| ev.index(value))? != 0;
    let whole = receiver(ev, &args[0])?;
    let text = whole.as_str();
    let is_end = |c: char| {
        matches!(
            c,
            '\n' | '\r' | '\x0b' | '\x0c' | '\x1c'..='\x1e' | '\u{85}' | '\u{2028}' | '\u{2029}'
        )
    };
    let mut lines = Parts::new(ev, &whole);
    let mut rest = text;
    while !rest.is_empty() {
        let line = ev.leading(rest, |c| !is_end(c))?;
        let end = match &rest[line..] {
            "" => line,
            rest if rest.starts_with("\r\n") => line + 2,
            rest => line + rest.chars().next().map_or(1, char::len_utf8),
        };
        lines.push(if keep { &rest[..end] } else { &rest[..line] })?;
        ev.worked(EACH)?;
        rest = &rest[end..];
    }
    Ok(Value::list(lines.list))
}

fn partition(ev: &Evaluator<'_>, args: &[Value], from_right: bool) -> R {
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
    let all = || Value::Str(whole.clone());
    Ok(Value::triple(match (found, from_right) {
        (Some(at), _) => [
            part_of(ev, &whole, &text[..at])?,
            Value::Str(separator.clone()),
            part_of(ev, &whole, &text[at + separator.as_str().len()..])?,
        ],
        (None, false) => [all(), empty(), empty()],
        (None, true) => [empty(), empty(), all()],
    }))
}

/// Texts and the separators between them that are joined without a safepoint.
const JOINED_MAX: usize = 4096;

/// A few texts with a separator between them; None if they are many or long, or if there is anything else among the items.
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
    if bytes > STRIDE {
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
    Ok(Some(Value::Str(Rc::new(Str::counted(out, chars)))))
}

fn join(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
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
        iterable => Value::tuple(ev.collect(iterable).map_err(|raised| {
            if ev.is_kind(&raised, ExceptionKind::TypeError)
                && !matches!(iterable, Value::Instance(_) | Value::Generator(_))
            {
                return ev.type_error("can only join an iterable");
            }
            raised
        })?),
    };
    join_many(ev, &collected, &separator)
}

/// The texts of a list or tuple with a separator between them.
fn join_many(ev: &Evaluator<'_>, sequence: &Value, separator: &Str) -> R {
    let text_at = |index: usize| -> R<Option<Rc<Str>>> {
        ev.worked(EACH)?;
        let item = match sequence {
            Value::List(list) => list.get(index),
            Value::Tuple(tuple) => tuple.items().get(index).cloned(),
            _ => None,
        };
        let Some(item) = item else { return Ok(None) };
        match ev.plain(&item) {
            Value::Str(text) => Ok(Some(text)),
            other => {
                let name = ev.core.types.name_of(&other);
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
    Ok(Value::Str(Rc::new(Str::counted(out, chars))))
}

fn replace(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let text = receiver(ev, &args[0])?;
    let argument = |index: usize| -> R<Rc<Str>> {
        match ev.plain(&args[index]) {
            Value::Str(text) => Ok(text),
            other => {
                let name = ev.core.types.name_of(&other);
                Err(ev.type_error(format!(
                    "replace() argument {index} must be str, not {name}"
                )))
            }
        }
    };
    let (old, new) = (argument(1)?, argument(2)?);
    let count = match args[3].given() {
        Some(value) => usize::try_from(ev.clamped_index(value)?).unwrap_or(usize::MAX),
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
            ev.worked(EACH)?;
        }
        let rest = &text[from..];
        if left > 0 && rest.is_empty() {
            ev.push_text(&mut out, new)?;
        }
        ev.push_text(&mut out, rest)?;
        return ev.string(out);
    }
    if count == 0 {
        return ev.string_of(text);
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
    ev.string(out)
}

/// The part of a string between optional bounds, and the index it starts at; None if they cross.
fn within<'t>(
    ev: &Evaluator<'_>,
    text: &'t Str,
    start: &Value,
    end: &Value,
) -> R<Option<(usize, &'t str)>> {
    let bounds = Bounds::read(ev, start, end)?;
    ev.mark(text)?;
    let places = bounds.within(text.len());
    Ok(places.map(|(from, to)| (from, text.slice(from, to))))
}

fn find(ev: &Evaluator<'_>, args: &[Value], from_right: bool, required: bool) -> R {
    let (text, part) = (receiver(ev, &args[0])?, text_argument(ev, &args[1])?);
    let found = match within(ev, &text, &args[2], &args[3])? {
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

fn count(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let (text, part) = (receiver(ev, &args[0])?, text_argument(ev, &args[1])?);
    let count = match within(ev, &text, &args[2], &args[3])? {
        None => 0,
        Some((_, slice)) if part.is_empty() => ev.count_chars(slice)? + 1,
        Some((_, slice)) => {
            Occurrences::new(slice.as_bytes(), part.as_str().as_bytes()).count(ev)?
        }
    };
    Ok(Value::Int(count as i64))
}

type Affix = for<'y> fn(&Evaluator<'y>, &str, &str) -> R<bool>;

fn affix(ev: &Evaluator<'_>, args: &[Value], method: &str, test: Affix) -> R {
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
    let slice = within(ev, &text, &args[2], &args[3])?.map(|(_, slice)| slice);
    let check = |part: &Value| -> R<bool> {
        match ev.plain(part) {
            Value::Str(part) => match slice {
                Some(slice) => test(ev, slice, part.as_str()),
                None => Ok(false),
            },
            other => {
                let name = ev.core.types.name_of(&other);
                Err(ev.type_error(if matches!(args[1], Value::Tuple(_)) {
                    format!("tuple for {method} must only contain str, not {name}")
                } else {
                    format!("{method} first arg must be str or a tuple of str, not {name}")
                }))
            }
        }
    };
    match &args[1] {
        Value::Tuple(parts) => {
            for part in parts.items() {
                ev.worked(EACH)?;
                if check(part)? {
                    return Ok(Value::Bool(true));
                }
            }
            Ok(Value::Bool(false))
        }
        part => check(part).map(Value::Bool),
    }
}

fn pad(ev: &Evaluator<'_>, args: &[Value], align: char) -> R {
    let text = receiver(ev, &args[0])?;
    let width = usize::try_from(ev.clamped_index(&args[1])?).unwrap_or(0);
    let fill = match args[2].given() {
        None => ' ',
        Some(value) => match (ev.plain(value), ()) {
            (Value::Str(text), ()) if text.len() == 1 => {
                text.as_str().chars().next().unwrap_or(' ')
            }
            (Value::Str(_), ()) => {
                return Err(ev.type_error("The fill character must be exactly one character long"));
            }
            (other, ()) => {
                let name = ev.core.types.name_of(&other);
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
    ev.string(out)
}

fn zfill(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let text = receiver(ev, &args[0])?;
    let width = usize::try_from(ev.clamped_index(&args[1])?).unwrap_or(0);
    let missing = width.saturating_sub(text.len());
    ev.check_allocation(missing)?;
    let sign = usize::from(text.as_str().starts_with(['+', '-']));
    let (sign, digits) = text.as_str().split_at(sign);
    let mut out = String::new();
    ev.grow(&mut out, missing.saturating_add(text.as_str().len()))?;
    out.push_str(sign);
    ev.push_repeated(&mut out, "0", missing)?;
    ev.push_text(&mut out, digits)?;
    ev.string(out)
}

fn expandtabs(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let text = receiver(ev, &args[0])?;
    let size = match args[1].given() {
        Some(value) => usize::try_from(ev.clamped_index(value)?).unwrap_or(0),
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
        ev.worked(piece.len() * EACH)?;
    }
    ev.string(out)
}

fn all(ev: &Evaluator<'_>, args: &[Value], test: impl Fn(char) -> bool) -> R {
    let text = receiver(ev, &args[0])?;
    let all = !text.is_empty() && ev.all_chars(text.as_str(), test)?;
    Ok(Value::Bool(all))
}

/// `isupper` and `islower`: at least one wanted letter and none of the other case.
fn cased(
    ev: &Evaluator<'_>,
    args: &[Value],
    wanted: fn(char) -> bool,
    other: fn(char) -> bool,
) -> R {
    let text = receiver(ev, &args[0])?;
    let none = |test: fn(char) -> bool| ev.all_chars(text.as_str(), |c| !test(c));
    Ok(Value::Bool(!none(wanted)? && none(other)?))
}

fn maketrans(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let table = crate::value::Dict::new();
    let code = |c: char| Value::Int(i64::from(c as u32));
    match (&args[0], args[1].given()) {
        (Value::Dict(dict), None) => {
            for (_, key, value) in ev.entries(dict)? {
                ev.worked(EACH)?;
                let key = match &key {
                    Value::Str(text) if text.len() == 1 => {
                        code(text.as_str().chars().next().unwrap_or('\0'))
                    }
                    Value::Int(_) => key,
                    other if !matches!(other, Value::Str(_)) => {
                        let text = "keys in translate table must be strings or integers";
                        return Err(ev.type_error(text));
                    }
                    _ => {
                        return Err(
                            ev.value_error("string keys in translate table must be of length 1")
                        );
                    }
                };
                ev.dict_set(&table, key, value)?;
            }
        }
        (Value::Str(from), Some(Value::Str(to))) => {
            if from.len() != to.len() {
                return Err(
                    ev.value_error("the first two maketrans arguments must have equal length")
                );
            }
            for (from, to) in from.as_str().chars().zip(to.as_str().chars()) {
                ev.worked(EACH)?;
                ev.dict_set(&table, code(from), code(to))?;
            }
            if let Some(Value::Str(removed)) = args[2].given() {
                for c in removed.as_str().chars() {
                    ev.worked(EACH)?;
                    ev.dict_set(&table, code(c), Value::None)?;
                }
            }
        }
        _ => {
            return Err(
                ev.type_error("if you give only one argument to maketrans it must be a dict")
            );
        }
    }
    Ok(Value::Dict(Rc::new(table)))
}

fn translate(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let text = receiver(ev, &args[0])?;
    let mut out = String::new();
    ev.grow(&mut out, text.as_str().len())?;
    for c in text.as_str().chars() {
        ev.worked(16 * EACH)?;
        let found = match ev.item(&args[1], &Value::Int(i64::from(c as u32))) {
            Ok(found) => found,
            Err(raised) if ev.is_kind(&raised, ExceptionKind::LookupError) => {
                // An exception was made and is dropped.
                ev.worked(256 * EACH)?;
                out.push(c);
                continue;
            }
            Err(raised) => return Err(raised),
        };
        match found {
            Value::None => {}
            Value::Str(text) => ev.push_text(&mut out, text.as_str())?,
            Value::Int(code) => match u32::try_from(code).ok().and_then(char::from_u32) {
                Some(c) => out.push(c),
                None => return Err(ev.value_error("character mapping must be in range(0x110000)")),
            },
            _ => return Err(ev.type_error("character mapping must return integer, None or str")),
        }
    }
    ev.string(out)
}
