//! `bytes` and `bytearray`.

use std::rc::Rc;

use super::constructor;
use crate::eval::{Core, Evaluator};
use crate::value::{ByteArray, Bytes, R, Value};

pub(super) fn install(core: &Rc<Core>) {
    let types = &core.types;
    constructor(
        core,
        &types.bytes,
        "source? encoding? errors?",
        |ev, args| data(ev, args, "bytes").map(|data| Value::Bytes(Rc::new(Bytes::new(data)))),
    );
    constructor(
        core,
        &types.bytearray,
        "source? encoding? errors?",
        |ev, args| {
            data(ev, args, "bytearray")
                .map(|data| Value::ByteArray(Rc::new(ByteArray { data: data.into() })))
        },
    );
}

fn data(ev: &Evaluator<'_>, args: &[Value], type_name: &str) -> R<Vec<u8>> {
    let Some(source) = args[0].given() else {
        return Ok(Vec::new());
    };
    match ev.plain(source) {
        Value::Str(text) => {
            if args[1].is_unbound() {
                return Err(ev.type_error("string argument without an encoding"));
            }
            Ok(text.as_str().as_bytes().to_vec())
        }
        Value::Int(count) => {
            let count = usize::try_from(count).map_err(|_| ev.value_error("negative count"))?;
            ev.check_allocation(count)?;
            Ok(vec![0; count])
        }
        other => match ev.bytes_like(&other) {
            Some(data) => Ok(data),
            None => ev.collect_bytes(source).map_err(|raised| {
                let wrong = ev.is_kind(&raised, crate::errors::ExceptionKind::TypeError);
                if wrong && ev.iter(source).is_err() {
                    let name = ev.core.types.name_of(source);
                    return ev.type_error(format!("cannot convert '{name}' object to {type_name}"));
                }
                raised
            }),
        },
    }
}
