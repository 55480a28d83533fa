//! The table of the methods of `str`, with those of a line or two.

use std::rc::Rc;

use super::case::{Title, all, capitalize, cased, is_space, lowered, mapped, swapcase, title};
use super::join::join;
use super::layout::{expandtabs, pad, zfill};
use super::parts::{partition, split, splitlines, strip};
use super::receiver;
use super::search::{affix, begins, count, ends, find, named_text, replace};
use super::table::{maketrans, translate};
use crate::builtins::types::{methods, raw_method};
use crate::errors::ExceptionKind;
use crate::eval::Core;
use crate::eval::bulk::{EACH, pieces};
use crate::ops::unicode;
use crate::value::symbol::Symbol;
use crate::value::{Bytes, Value};

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
                    let symbol = ev.ask_name(name)?;
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
