//! `str.maketrans` and `str.translate`.

use std::rc::Rc;

use elite_syntax::surrogate::{char_of, code_of};

use super::receiver;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::limits::chunked::WORK_PER_BYTE;
use crate::value::int::Int;
use crate::value::{R, Unwind, Value};

pub(super) fn maketrans(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    // Texts of derived classes are what they extend, but dictionaries are not.
    for arg in args.iter_mut() {
        if let text @ Value::Str(_) = ev.unwrap_builtin(arg) {
            *arg = text;
        }
    }
    if let Some(removed) = args[2].if_given()
        && !matches!(removed, Value::Str(_))
        && matches!(args[1], Value::Str(_))
    {
        return Err(not_text(ev, 3, removed));
    }
    let table = crate::value::Dict::new();
    let code = |c: char| Value::Int(i64::from(code_of(c)));
    match (&args[0], args[1].if_given()) {
        (Value::Dict(dict), None) => {
            for (_, key, value) in ev.collect_entries(dict)? {
                ev.charge(WORK_PER_BYTE)?;
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
                ev.charge(WORK_PER_BYTE)?;
                ev.dict_set(&table, code(from), code(to))?;
            }
            if let Some(Value::Str(removed)) = args[2].if_given() {
                for c in removed.as_str().chars() {
                    ev.charge(WORK_PER_BYTE)?;
                    ev.dict_set(&table, code(c), Value::None)?;
                }
            }
        }
        (_, Some(to)) if !matches!(to, Value::Str(_)) => return Err(not_text(ev, 2, to)),
        (_, Some(_)) => {
            let text = "first maketrans argument must be a string if there is a second argument";
            return Err(ev.type_error(text));
        }
        _ => {
            return Err(
                ev.type_error("if you give only one argument to maketrans it must be a dict")
            );
        }
    }
    Ok(Value::Dict(Rc::new(table)))
}

#[cold]
fn not_text(ev: &Evaluator<'_>, place: usize, value: &Value) -> Unwind {
    let name = ev.core.types.name_of_argument(value);
    ev.type_error(format!(
        "maketrans() argument {place} must be str, not {name}"
    ))
}

pub(super) fn translate(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let text = receiver(ev, &args[0])?;
    let mut out = String::new();
    ev.grow(&mut out, text.as_str().len())?;
    for c in text.as_str().chars() {
        ev.charge(16 * WORK_PER_BYTE)?;
        let found = match ev.item(&args[1], &Value::Int(i64::from(code_of(c)))) {
            Ok(found) => found,
            Err(raised) if ev.is_kind(&raised, ExceptionKind::LookupError) => {
                // An exception was made and is dropped.
                ev.charge(256 * WORK_PER_BYTE)?;
                out.push(c);
                continue;
            }
            Err(raised) => return Err(raised),
        };
        match ev.unwrap_builtin(&found) {
            Value::None => {}
            Value::Str(text) => ev.push_text(&mut out, text.as_str())?,
            found => match Int::of(&found) {
                Some(Int::Small(code))
                    if let Some(c) = u32::try_from(code).ok().and_then(char_of) =>
                {
                    out.push(c)
                }
                Some(_) => {
                    return Err(ev.value_error("character mapping must be in range(0x110000)"));
                }
                None => {
                    return Err(ev.type_error("character mapping must return integer, None or str"));
                }
            },
        }
    }
    ev.new_str(out)
}
