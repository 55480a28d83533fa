//! `_string`: how formats and the names of their fields come apart, for `string.Formatter`.

use super::define::ModuleBuilder;
use crate::eval::Evaluator;
use crate::value::{R, Str, Value};
use std::rc::Rc;

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    module.functions(&[
        ("formatter_parser", "format /", |ev, args| {
            let format = text(ev, &args[0])?;
            ev.format_parts(format.as_str())
        }),
        ("formatter_field_name_split", "name /", |ev, args| {
            let name = text(ev, &args[0])?;
            ev.field_path(name.as_str())
        }),
    ]);
    Ok(())
}

fn text(ev: &Evaluator<'_>, value: &Value) -> R<Rc<Str>> {
    match ev.unwrap_builtin(value) {
        Value::Str(text) => Ok(text),
        _ => {
            let name = ev.core.types.name_of(value);
            Err(ev.type_error(format!("expected str, got {name}")))
        }
    }
}
