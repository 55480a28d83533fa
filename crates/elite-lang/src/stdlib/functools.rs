//! `_functools`: what of `functools` is used most often, one call after another. The rest is a script.

use super::define::ModuleBuilder;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::value::{R, Value};

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    module.functions(&[
        ("reduce", "function iterable initial? /", reduce),
        ("cmp_to_key", "mycmp", |ev, args| {
            ev.comparison_key(&args[0])
        }),
    ]);
    Ok(())
}

fn reduce(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let items = ev.iter(&args[1]).map_err(|raised| {
        match ev.is_kind(&raised, ExceptionKind::TypeError) {
            true => ev.type_error("reduce() arg 2 must support iteration"),
            false => raised,
        }
    })?;
    let first = match args[2].if_given() {
        Some(initial) => Some(initial.clone()),
        None => ev.next_at_safepoint(&items)?,
    };
    let Some(mut result) = first else {
        return Err(ev.type_error("reduce() of empty iterable with no initial value"));
    };
    while let Some(item) = ev.next_at_safepoint(&items)? {
        result = ev.call(&args[0], &mut [result, item], &[])?;
    }
    Ok(result)
}
