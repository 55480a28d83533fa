//! `_codecs`: the inner part of `codecs`.

use super::define::ModuleBuilder;
use crate::value::{Dict, R, Value};

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    module.value("handlers", Value::Dict(std::rc::Rc::new(Dict::new())));
    module.functions(&[
        ("name", "encoding /", |ev, args| {
            ev.codec_name(&args[0]).map(Value::str)
        }),
        ("decode", "data encoding errors is_end /", |ev, args| {
            let Some(data) = ev.bytes_like(&ev.unwrap_builtin(&args[0])) else {
                let found = ev.core.types.name_of(&args[0]);
                return Err(
                    ev.type_error(format!("a bytes-like object is required, not '{found}'"))
                );
            };
            let is_end = ev.truth(&args[3])?;
            let decoded = ev.decode_begun(&data, &args[1], &args[2], is_end)?;
            let length = Value::Int(decoded.length as i64);
            Ok(Value::pair(ev.new_str(decoded.text)?, length))
        }),
    ]);
    Ok(())
}
