//! Methods of `str`.

use std::rc::Rc;

use compact_str::CompactString;

use super::string::{receiver, text_argument};
use super::{clamp_start, methods, raw_method};
use crate::errors::ExceptionKind;
use crate::eval::{Core, Evaluator};
use crate::ops::{search, unicode};
use crate::value::symbol::Symbol;
use crate::value::{Bytes, R, Str, Value};

pub(super) fn install(core: &Rc<Core>) {
    let class = &core.types.str;
    methods(
        core,
        class,
        &[
            ("upper", "", |ev, args| {
                mapped(ev, args, |text| text.to_uppercase())
            }),
            ("lower", "", |ev, args| {
                mapped(ev, args, |text| text.to_lowercase())
            }),
            ("casefold", "", |ev, args| {
                mapped(ev, args, unicode::casefold)
            }),
            ("capitalize", "", |ev, args| mapped(ev, args, capitalize)),
            ("title", "", |ev, args| mapped(ev, args, title)),
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
                affix(ev, args, "startswith", |text, part| text.starts_with(part))
            }),
            ("endswith", "suffix start? end? /", |ev, args| {
                affix(ev, args, "endswith", |text, part| text.ends_with(part))
            }),
            ("removeprefix", "prefix /", |ev, args| {
                let part = named_text(ev, &args[1], "removeprefix")?;
                mapped(ev, args, |text| {
                    text.strip_prefix(part.as_str()).unwrap_or(text).to_owned()
                })
            }),
            ("removesuffix", "suffix /", |ev, args| {
                let part = named_text(ev, &args[1], "removesuffix")?;
                mapped(ev, args, |text| {
                    text.strip_suffix(part.as_str()).unwrap_or(text).to_owned()
                })
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
                Ok(Value::Bool(
                    receiver(ev, &args[0])?
                        .as_str()
                        .chars()
                        .all(crate::ops::text::is_printable),
                ))
            }),
            ("isupper", "", |ev, args| {
                cased(ev, args, char::is_uppercase, char::is_lowercase)
            }),
            ("islower", "", |ev, args| {
                cased(ev, args, char::is_lowercase, char::is_uppercase)
            }),
            ("istitle", "", |ev, args| {
                Ok(Value::Bool(is_title(receiver(ev, &args[0])?.as_str())))
            }),
            ("isidentifier", "", |ev, args| {
                let text = receiver(ev, &args[0])?;
                let mut chars = text.as_str().chars();
                let first = chars.next().is_some_and(|c| c == '_' || c.is_alphabetic());
                Ok(Value::Bool(
                    first && chars.all(|c| c == '_' || c.is_alphanumeric()),
                ))
            }),
            ("format_map", "mapping /", |ev, args| {
                let text = receiver(ev, &args[0])?;
                let mut keywords: Vec<(Symbol, Value)> = Vec::new();
                for name in crate::format::field_names(text.as_str()) {
                    let symbol = ev.core.symbols.intern(name);
                    if !keywords.iter().any(|(known, _)| *known == symbol) {
                        let value = ev.item(&args[1], &Value::str(name))?;
                        keywords.push((symbol, value));
                    }
                }
                let args = crate::builtins::Args {
                    positional: &mut [],
                    keywords: &keywords,
                    caller: None,
                };
                ev.format_fields(text.as_str(), &args)
                    .map(Value::str)
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
        ev.format_fields(text.as_str(), &args).map(Value::str)
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

fn mapped(ev: &Evaluator<'_>, args: &[Value], map: impl FnOnce(&str) -> String) -> R {
    Ok(Value::str(map(receiver(ev, &args[0])?.as_str())))
}

fn capitalize(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map_or_else(String::new, |first| {
        let mut out = String::with_capacity(text.len());
        unicode::push_title(first, &mut out);
        out + &chars.as_str().to_lowercase()
    })
}

fn title(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut inside = false;
    for c in text.chars() {
        if inside {
            out.extend(c.to_lowercase())
        } else {
            unicode::push_title(c, &mut out)
        }
        inside = unicode::is_cased(c);
    }
    out
}

pub(super) fn is_title(text: &str) -> bool {
    let (mut inside, mut any) = (false, false);
    for c in text.chars() {
        if c.is_uppercase() || unicode::is_title_form(c) {
            if inside {
                return false;
            }
            (inside, any) = (true, true);
        } else if c.is_lowercase() {
            if !inside {
                return false;
            }
            any = true;
        } else {
            inside = false;
        }
    }
    any
}

fn swapcase(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_uppercase() {
            out.extend(c.to_lowercase())
        } else if c.is_lowercase() {
            out.extend(c.to_uppercase())
        } else {
            out.push(c);
        }
    }
    out
}

/// White space as Python's `str.isspace` has it: Unicode's, and the separators 0x1c to 0x1f.
pub(super) fn is_space(c: char) -> bool {
    c.is_whitespace() || matches!(c, '\x1c'..='\x1f')
}

fn strip(ev: &Evaluator<'_>, args: &[Value], left: bool, right: bool) -> R {
    let text = receiver(ev, &args[0])?;
    let chars: Option<Vec<char>> = match args[1].given() {
        None | Some(Value::None) => None,
        Some(value) => match ev.plain(value) {
            Value::Str(text) => Some(text.as_str().chars().collect()),
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
            .map_or_else(|| is_space(c), |chars| chars.contains(&c))
    };
    let mut part = text.as_str();
    if left {
        part = part.trim_start_matches(cut);
    }
    if right {
        part = part.trim_end_matches(cut);
    }
    if part.len() == text.as_str().len() {
        return Ok(Value::Str(text.clone()));
    }
    Ok(Value::str(part))
}

fn split(ev: &Evaluator<'_>, args: &[Value], from_right: bool) -> R {
    let text = receiver(ev, &args[0])?;
    let most = match args[2].given() {
        Some(value) => usize::try_from(ev.clamped_index(value)?).unwrap_or(usize::MAX),
        None => usize::MAX,
    };
    let whole = &*text;
    let text = whole.as_str();
    ev.ask_for_pieces(text.len(), || match args[1].given() {
        Some(Value::Str(separator)) if !separator.is_empty() => {
            text.matches(separator.as_str()).count().min(most) + 1
        }
        _ => text.split(is_space).count().min(most) + 1,
    })?;
    let parts: Vec<&str> = match args[1].given() {
        None | Some(Value::None) => split_spaces(text, most, from_right),
        Some(separator) => {
            let separator = text_argument(ev, separator).map_err(|_| {
                let name = ev.core.types.name_of(separator);
                ev.type_error(format!("must be str or None, not {name}"))
            })?;
            let separator = separator.as_str();
            if separator.is_empty() {
                return Err(ev.value_error("empty separator"));
            }
            if from_right {
                let most = most.saturating_add(1);
                let mut parts: Vec<&str> = text.rsplitn(most, separator).collect();
                parts.reverse();
                return Ok(Value::list(parts.into_iter().map(Value::str).collect()));
            }
            let mut parts = Vec::new();
            search::split(text, separator, most, |part| {
                parts.push(part_of(whole, part))
            });
            return Ok(Value::list(parts));
        }
    };
    let parts = parts.into_iter().map(|part| part_of(whole, part));
    Ok(Value::list(parts.collect()))
}

/// A part of a text as a string of its own.
#[inline]
fn part_of(whole: &Str, part: &str) -> Value {
    if whole.is_ascii() {
        return Value::Str(Rc::new(Str::counted(part, part.len())));
    }
    Value::str(part)
}

/// Splits at runs of white space, at most `most` times; the rest keeps its inner white space.
fn split_spaces(text: &str, most: usize, from_right: bool) -> Vec<&str> {
    let mut parts = Vec::new();
    let mut rest = if from_right {
        text.trim_end_matches(is_space)
    } else {
        text.trim_start_matches(is_space)
    };
    while !rest.is_empty() {
        if parts.len() == most {
            parts.push(rest);
            break;
        }
        if from_right {
            let at = rest.rfind(is_space).map_or(0, |at| {
                at + rest[at..].chars().next().map_or(1, char::len_utf8)
            });
            parts.push(&rest[at..]);
            rest = rest[..at].trim_end_matches(is_space);
        } else {
            let at = rest.find(is_space).unwrap_or(rest.len());
            parts.push(&rest[..at]);
            rest = rest[at..].trim_start_matches(is_space);
        }
    }
    if from_right {
        parts.reverse();
    }
    parts
}

fn splitlines(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let keep = args[1].given().map_or(Ok(0), |value| ev.index(value))? != 0;
    let text = receiver(ev, &args[0])?;
    let text = text.as_str();
    let is_end = |c: char| {
        matches!(
            c,
            '\n' | '\r' | '\x0b' | '\x0c' | '\x1c'..='\x1e' | '\u{85}' | '\u{2028}' | '\u{2029}'
        )
    };
    ev.ask_for_pieces(text.len(), || text.matches(is_end).count() + 1)?;
    let mut lines = Vec::new();
    let mut rest = text;
    while !rest.is_empty() {
        let (line, end) = match rest.find(is_end) {
            None => (rest.len(), rest.len()),
            Some(at) if rest[at..].starts_with("\r\n") => (at, at + 2),
            Some(at) => (at, at + rest[at..].chars().next().map_or(1, char::len_utf8)),
        };
        lines.push(Value::str(if keep { &rest[..end] } else { &rest[..line] }));
        rest = &rest[end..];
    }
    Ok(Value::list(lines))
}

fn partition(ev: &Evaluator<'_>, args: &[Value], from_right: bool) -> R {
    let (whole, separator) = (receiver(ev, &args[0])?, text_argument(ev, &args[1])?);
    if separator.is_empty() {
        return Err(ev.value_error("empty separator"));
    }
    let text = whole.as_str();
    let found = if from_right {
        search::rfind(text, separator.as_str())
    } else {
        search::find(text, separator.as_str())
    };
    let empty = || ev.core.empty_str.clone();
    let all = || Value::Str(whole.clone());
    Ok(Value::triple(match (found, from_right) {
        (Some(at), _) => [
            part_of(&whole, &text[..at]),
            Value::Str(separator.clone()),
            part_of(&whole, &text[at + separator.as_str().len()..]),
        ],
        (None, false) => [all(), empty(), empty()],
        (None, true) => [empty(), empty(), all()],
    }))
}

/// Texts with a separator between them; None if there is anything else among the items.
fn join_texts(ev: &Evaluator<'_>, items: &[Value], separator: &Str) -> R<Option<Value>> {
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
        Value::List(list) => join_texts(ev, &list.borrow(), &separator)?,
        Value::Tuple(tuple) => join_texts(ev, tuple.items(), &separator)?,
        _ => None,
    };
    if let Some(joined) = joined {
        return Ok(joined);
    }
    let items = ev.collect(&args[1]).map_err(|raised| {
        if ev.is_kind(&raised, ExceptionKind::TypeError)
            && !matches!(args[1], Value::Instance(_) | Value::Generator(_))
        {
            return ev.type_error("can only join an iterable");
        }
        raised
    })?;
    let mut out = String::new();
    let mut chars = 0;
    for (index, item) in items.iter().enumerate() {
        if index > 0 {
            out.push_str(separator.as_str());
            chars += separator.len();
        }
        match item {
            Value::Str(text) => {
                out.push_str(text.as_str());
                chars += text.len();
            }
            other => match ev.plain(other) {
                Value::Str(text) => {
                    out.push_str(text.as_str());
                    chars += text.len();
                }
                other => {
                    let name = ev.core.types.name_of(&other);
                    let text =
                        format!("sequence item {index}: expected str instance, {name} found");
                    return Err(ev.type_error(text));
                }
            },
        }
        if index % 1024 == 1023 {
            ev.check_allocation(2 * out.len())?;
        }
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
    if new.len() > old.len() {
        let most = if old.is_empty() {
            text.len() + 1
        } else {
            text.as_str().matches(old.as_str()).count()
        };
        let growth = new
            .as_str()
            .len()
            .saturating_sub(old.as_str().len())
            .saturating_mul(most.min(count));
        ev.check_allocation(text.as_str().len().saturating_add(growth))?;
    }
    Ok(Value::str(text.as_str().replacen(
        old.as_str(),
        new.as_str(),
        count,
    )))
}

/// The part of a string between optional bounds, and the index it starts at; None if they cross.
fn within<'t>(
    ev: &Evaluator<'_>,
    text: &'t Str,
    start: &Value,
    end: &Value,
) -> R<Option<(usize, &'t str)>> {
    for bound in [start, end] {
        ev.check_slice_index(bound)?;
    }
    let from = clamp_start(ev, start, usize::MAX, 0)?;
    let from = match start.given() {
        Some(value) if !value.is_none() && ev.clamped_index(value)? < 0 => {
            clamp_start(ev, start, text.len(), 0)?
        }
        _ => from,
    };
    let to = clamp_start(ev, end, text.len(), text.len())?;
    if from > text.len() || from > to {
        return Ok(None);
    }
    Ok(Some((from, text.slice(from, to))))
}

fn find(ev: &Evaluator<'_>, args: &[Value], from_right: bool, required: bool) -> R {
    let (text, part) = (receiver(ev, &args[0])?, text_argument(ev, &args[1])?);
    let found = within(ev, &text, &args[2], &args[3])?.and_then(|(start, slice)| {
        let at = if from_right {
            search::rfind(slice, part.as_str())
        } else {
            search::find(slice, part.as_str())
        }?;
        let offset = text.byte_offset(start) + at;
        Some(text.char_index(offset))
    });
    match found {
        Some(index) => Ok(Value::Int(index as i64)),
        None if required => Err(ev.value_error("substring not found")),
        None => Ok(Value::Int(-1)),
    }
}

fn count(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let (text, part) = (receiver(ev, &args[0])?, text_argument(ev, &args[1])?);
    let count = within(ev, &text, &args[2], &args[3])?.map_or(0, |(_, slice)| {
        if part.is_empty() {
            slice.chars().count() + 1
        } else {
            slice.matches(part.as_str()).count()
        }
    });
    Ok(Value::Int(count as i64))
}

fn affix(ev: &Evaluator<'_>, args: &[Value], method: &str, test: impl Fn(&str, &str) -> bool) -> R {
    if let [
        Value::Str(text),
        Value::Str(part),
        Value::Unbound,
        Value::Unbound,
    ] = args
    {
        return Ok(Value::Bool(test(text.as_str(), part.as_str())));
    }
    let text = receiver(ev, &args[0])?;
    let slice = within(ev, &text, &args[2], &args[3])?.map(|(_, slice)| slice);
    let check = |part: &Value| -> R<bool> {
        match ev.plain(part) {
            Value::Str(part) => Ok(slice.is_some_and(|slice| test(slice, part.as_str()))),
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
    let fill = |count: usize| std::iter::repeat_n(fill, count);
    Ok(Value::str(
        fill(before)
            .chain(text.as_str().chars())
            .chain(fill(after))
            .collect::<String>(),
    ))
}

fn zfill(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let text = receiver(ev, &args[0])?;
    let width = usize::try_from(ev.clamped_index(&args[1])?).unwrap_or(0);
    let missing = width.saturating_sub(text.len());
    ev.check_allocation(missing)?;
    let sign = usize::from(text.as_str().starts_with(['+', '-']));
    let (sign, digits) = text.as_str().split_at(sign);
    Ok(Value::str(format!("{sign}{}{digits}", "0".repeat(missing))))
}

fn expandtabs(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let text = receiver(ev, &args[0])?;
    let size = match args[1].given() {
        Some(value) => usize::try_from(ev.clamped_index(value)?).unwrap_or(0),
        None => 8,
    };
    ev.check_allocation(text.as_str().matches('\t').count().saturating_mul(size))?;
    let mut out = String::with_capacity(text.as_str().len());
    let mut column = 0;
    for c in text.as_str().chars() {
        match c {
            '\t' if size == 0 => {}
            '\t' => {
                let blanks = size - column % size;
                out.extend(std::iter::repeat_n(' ', blanks));
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
    Ok(Value::str(out))
}

fn all(ev: &Evaluator<'_>, args: &[Value], test: impl Fn(char) -> bool) -> R {
    let text = receiver(ev, &args[0])?;
    Ok(Value::Bool(
        !text.is_empty() && text.as_str().chars().all(test),
    ))
}

/// `isupper` and `islower`: at least one wanted letter and none of the other case.
fn cased(
    ev: &Evaluator<'_>,
    args: &[Value],
    wanted: fn(char) -> bool,
    other: fn(char) -> bool,
) -> R {
    let text = receiver(ev, &args[0])?;
    let any = text.as_str().chars().any(wanted);
    Ok(Value::Bool(any && !text.as_str().chars().any(other)))
}

fn maketrans(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let table = crate::value::Dict::new();
    let code = |c: char| Value::Int(i64::from(c as u32));
    match (&args[0], args[1].given()) {
        (Value::Dict(dict), None) => {
            for (_, key, value) in dict.entries() {
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
                ev.dict_set(&table, code(from), code(to))?;
            }
            if let Some(Value::Str(removed)) = args[2].given() {
                for c in removed.as_str().chars() {
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
    let mut out = String::with_capacity(text.as_str().len());
    for c in text.as_str().chars() {
        let found = match ev.item(&args[1], &Value::Int(i64::from(c as u32))) {
            Ok(found) => found,
            Err(raised) if ev.is_kind(&raised, ExceptionKind::LookupError) => {
                out.push(c);
                continue;
            }
            Err(raised) => return Err(raised),
        };
        match found {
            Value::None => {}
            Value::Str(text) => out.push_str(text.as_str()),
            Value::Int(code) => match u32::try_from(code).ok().and_then(char::from_u32) {
                Some(c) => out.push(c),
                None => return Err(ev.value_error("character mapping must be in range(0x110000)")),
            },
            _ => return Err(ev.type_error("character mapping must return integer, None or str")),
        }
        ev.check_allocation(out.len())?;
    }
    Ok(Value::str(out))
}
