//! `str`: its constructor, and how its methods get at the text; the methods are in the files beside this one, by theme.

mod case;
mod join;
mod layout;
mod methods;
mod parts;
mod search;
mod table;

pub use case::TitleCaseCheck;

use std::rc::Rc;

use super::{constructor, wrong_receiver};
use crate::eval::{Evaluator, InterpreterState};
use crate::value::{R, Str, Value};

pub(super) fn install(core: &Rc<InterpreterState>) {
    constructor(
        core,
        &core.types.str,
        "object? encoding? errors?",
        |ev, args| {
            let decodes = args[1].if_given().is_some() || args[2].if_given().is_some();
            if decodes {
                ev.check_codec_arguments("str", &args[1], &args[2])?;
            }
            let Some(value) = args[0].if_given() else {
                return Ok(ev.core.empty_str.clone());
            };
            if !decodes {
                return ev.str_value(value);
            }
            match ev.bytes_like(value) {
                Some(data) => ev.decode(&data, &args[1], &args[2]),
                None => {
                    let name = ev.core.types.name_of(value);
                    Err(
                        ev.type_error(if let Value::Str(_) = ev.unwrap_builtin(value) {
                            "decoding str is not supported".to_owned()
                        } else {
                            format!("decoding to str: need a bytes-like object, {name} found")
                        }),
                    )
                }
            }
        },
    );
    methods::install(core);
}

/// The string behind a receiver or argument.
pub(super) fn receiver(ev: &Evaluator<'_>, value: &Value) -> R<Rc<Str>> {
    match value {
        Value::Str(text) => Ok(text.clone()),
        other => match ev.unwrap_builtin(other) {
            Value::Str(text) => Ok(text),
            other => Err(wrong_receiver(ev, "str", &other)),
        },
    }
}

/// A string argument of a method.
pub(super) fn text_argument(ev: &Evaluator<'_>, value: &Value) -> R<Rc<Str>> {
    match ev.unwrap_builtin(value) {
        Value::Str(text) => Ok(text),
        _ => {
            let name = ev.core.types.name_of(value);
            Err(ev.type_error(format!("must be str, not {name}")))
        }
    }
}
