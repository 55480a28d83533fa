//! `Event`: a flag that threads wait for.

use std::cell::Cell;

use super::deadline;
use super::line::WaitQueue;
use crate::builtins::BoundFn;
use crate::eval::Evaluator;
use crate::stdlib::define::{MethodDef, ModuleBuilder, instance, with_data};
use crate::value::data::no_values;
use crate::value::{R, Value};

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) {
    let make: BoundFn = |ev, _| instance(ev, "_thread.Event", Event::default());
    module.class("Event", Some(("", make)), METHODS);
}

#[derive(Default)]
struct Event {
    is_set: Cell<bool>,
    line: WaitQueue,
}

no_values!(Event);

const METHODS: &[MethodDef] = &[
    ("is_set", "", |ev, args| {
        with(ev, args, |event| Ok(Value::Bool(event.is_set.get())))
    }),
    ("set", "", |ev, args| {
        with(ev, args, |event| {
            event.is_set.set(true);
            event.line.wake_some(ev, usize::MAX);
            Ok(Value::None)
        })
    }),
    ("clear", "", |ev, args| {
        with(ev, args, |event| {
            event.is_set.set(false);
            Ok(Value::None)
        })
    }),
    ("wait", "timeout?", |ev, args| {
        let until = deadline(ev, &args[1])?;
        with(ev, args, |event| {
            // Who is called has seen the flag, though it may be down again.
            let seen = event.is_set.get() || event.line.wait(ev, until, || {})?;
            Ok(Value::Bool(seen || event.is_set.get()))
        })
    }),
];

fn with(ev: &Evaluator<'_>, args: &[Value], act: impl FnOnce(&Event) -> R) -> R {
    with_data(ev, &args[0], act)
}
