//! The table of the methods of `str`, with those of a line or two.

use elite_syntax::lexer::{begins_name, continues_name};

use crate::eval::Evaluator;
use crate::value::R;
use crate::value::function::WrappedFunction;
use std::rc::Rc;

use super::case::{
    TitleCaseCheck, all, capitalize, cased, is_space, mapped, swap_case, to_lower, to_title,
};
use super::join::join;
use super::layout::{expandtabs, pad, zfill};
use super::parts::{partition, split, splitlines, strip};
use super::receiver;
use super::search::{affix, begins, count, ends, find, named_text, replace};
use super::table::{maketrans, translate};
use crate::builtins::types::{methods, raw_method};
use crate::eval::InterpreterState;
use crate::limits::chunked::{WORK_PER_BYTE, pieces};
use crate::ops::unicode;
use crate::value::{Bytes, Value};

pub(super) fn install(core: &Rc<InterpreterState>) {
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
                ev.new_str(to_lower(ev, text.as_str(), 0)?)
            }),
            ("casefold", "", |ev, args| {
                mapped(ev, args, |text, out| out.push_str(&unicode::casefold(text)))
            }),
            ("capitalize", "", capitalize),
            ("title", "", |ev, args| {
                let text = receiver(ev, &args[0])?;
                ev.new_str(to_title(ev, text.as_str())?)
            }),
            ("swapcase", "", |ev, args| {
                let text = receiver(ev, &args[0])?;
                ev.new_str(swap_case(ev, text.as_str())?)
            }),
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
                    true => ev.new_str_from(&text.as_str()[part.as_str().len()..]),
                    false => Ok(Value::Str(text)),
                }
            }),
            ("removesuffix", "suffix /", |ev, args| {
                let part = named_text(ev, &args[1], "removesuffix")?;
                let text = receiver(ev, &args[0])?;
                match ends(ev, text.as_str(), part.as_str())? {
                    true => {
                        let length = text.as_str().len() - part.as_str().len();
                        ev.new_str_from(&text.as_str()[..length])
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
                all(ev, args, unicode::is_alphanumeric)
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
                cased(ev, args, char::is_uppercase, |c| {
                    c.is_lowercase() || unicode::is_title_form(c)
                })
            }),
            ("islower", "", |ev, args| {
                cased(ev, args, char::is_lowercase, |c| {
                    c.is_uppercase() || unicode::is_title_form(c)
                })
            }),
            ("istitle", "", |ev, args| {
                let text = receiver(ev, &args[0])?;
                let mut title = TitleCaseCheck::default();
                for piece in pieces(text.as_str()) {
                    if !title.goes_on(piece.chars()) {
                        return Ok(Value::Bool(false));
                    }
                    ev.charge(piece.len() * WORK_PER_BYTE)?;
                }
                Ok(Value::Bool(title.is_one()))
            }),
            ("isidentifier", "", |ev, args| {
                let text = receiver(ev, &args[0])?;
                let begins = text.as_str().starts_with(begins_name);
                let all = begins && ev.all_chars(text.as_str(), continues_name)?;
                Ok(Value::Bool(all))
            }),
            ("format_map", "mapping /", |ev, args| {
                let text = receiver(ev, &args[0])?;
                match is_literal(ev, text.as_str())? {
                    true => Ok(args[0].clone()),
                    false => ev.format_map(text.as_str(), &args[1]),
                }
            }),
            ("translate", "table /", translate),
        ],
    );
    raw_method(core, class, "format", |ev, args| {
        let Some((first, rest)) = args.positional.split_first_mut() else {
            return Err(ev.type_error("unbound method str.format() needs an argument"));
        };
        let text = receiver(ev, first)?;
        if is_literal(ev, text.as_str())? {
            return Ok(first.clone());
        }
        let args = crate::builtins::Args {
            positional: rest,
            keywords: args.keywords,
            caller: None,
        };
        ev.format_fields(text.as_str(), &args)
    });
    let maketrans = crate::builtins::Builtin::bound(core, "maketrans", "x y? z? /", maketrans);
    class.set(
        core.symbols.intern("maketrans"),
        Value::StaticMethod(WrappedFunction::around(maketrans)),
    );
}

/// Whether a format has nothing to fill in: it is its own result then, also one of a class derived from `str`.
fn is_literal(ev: &Evaluator<'_>, format: &str) -> R<bool> {
    let is_brace = |byte| matches!(byte, b'{' | b'}');
    Ok(!format.is_empty() && ev.position(format.as_bytes(), is_brace)?.is_none())
}
