//! `Semaphore` and `BoundedSemaphore`: so many may go on at once.

use std::cell::Cell;

use super::line::WaitQueue;
use super::{deadline, is_some_value};
use crate::builtins::BoundFn;
use crate::eval::Evaluator;
use crate::stdlib::define::{MethodDef, ModuleBuilder, instance, with_data};
use crate::value::data::no_values;
use crate::value::{R, Value};

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) {
    let make: BoundFn = |ev, args| {
        let made = instance(ev, "_thread.Semaphore", Semaphore::default())?;
        begin(ev, &made, &args[0])?;
        Ok(made)
    };
    let class = module.class("Semaphore", Some(("value?", make)), METHODS);
    module.property(&class, "_value", |ev, args| {
        with(ev, args, |semaphore| Ok(Value::Int(semaphore.left.get())))
    });
    let make: BoundFn = |ev, args| {
        let made = instance(ev, "_thread.BoundedSemaphore", Semaphore::new_bounded())?;
        begin(ev, &made, &args[0])?;
        Ok(made)
    };
    let class = module.class("BoundedSemaphore", Some(("value?", make)), METHODS);
    module.property(&class, "_value", |ev, args| {
        with(ev, args, |semaphore| Ok(Value::Int(semaphore.left.get())))
    });
}

#[derive(Default)]
struct Semaphore {
    left: Cell<i64>,
    is_bounded: bool,
    /// What `left` never exceeds, if it is bounded.
    most: Cell<i64>,
    line: WaitQueue,
}

no_values!(Semaphore);

impl Semaphore {
    fn new_bounded() -> Self {
        Semaphore {
            is_bounded: true,
            ..Semaphore::default()
        }
    }

    fn try_acquire(&self) -> bool {
        let is_free = self.left.get() > 0;
        if is_free {
            self.left.set(self.left.get() - 1);
        }
        is_free
    }
}

fn begin(ev: &Evaluator<'_>, receiver: &Value, value: &Value) -> R<()> {
    let value = value.if_given().map_or(Ok(1), |value| ev.index(value))?;
    if value < 0 {
        return Err(ev.value_error("semaphore initial value must be >= 0"));
    }
    with_data(ev, receiver, |semaphore: &Semaphore| {
        semaphore.left.set(value);
        semaphore.most.set(value);
        Ok(())
    })
}

const METHODS: &[MethodDef] = &[
    ("__init__", "value?", |ev, args| {
        begin(ev, &args[0], &args[1]).map(|()| Value::None)
    }),
    ("acquire", "blocking? timeout?", acquire),
    ("__enter__", "blocking? timeout?", acquire),
    ("release", "n?", |ev, args| {
        let count = args[1].if_given().map_or(Ok(1), |n| ev.index(n))?;
        release(ev, args, count)
    }),
    ("__exit__", "type value traceback /", |ev, args| {
        // The class may release in a way of its own.
        let release = ev.attribute(&args[0], ev.core.symbols.intern("release"))?;
        ev.call(&release, &mut [], &[])?;
        Ok(Value::None)
    }),
];

fn with(ev: &Evaluator<'_>, args: &[Value], act: impl FnOnce(&Semaphore) -> R) -> R {
    with_data(ev, &args[0], act)
}

fn acquire(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let may_wait = args[1].if_given().map_or(Ok(true), |flag| ev.truth(flag))?;
    if !may_wait && is_some_value(&args[2]) {
        return Err(ev.value_error("can't specify timeout for non-blocking acquire"));
    }
    let until = deadline(ev, &args[2])?;
    with(ev, args, |semaphore| {
        while !semaphore.try_acquire() {
            let pass_on = || {
                semaphore.line.notify_one(ev);
            };
            if !may_wait || !semaphore.line.wait(ev, until, pass_on)? {
                return Ok(Value::Bool(false));
            }
        }
        Ok(Value::Bool(true))
    })
}

fn release(ev: &Evaluator<'_>, args: &[Value], count: i64) -> R {
    if count < 1 {
        return Err(ev.value_error("n must be one or more"));
    }
    with(ev, args, |semaphore| {
        let left = semaphore.left.get().saturating_add(count);
        if semaphore.is_bounded && left > semaphore.most.get() {
            return Err(ev.value_error("Semaphore released too many times"));
        }
        semaphore.left.set(left);
        let count = usize::try_from(count).unwrap_or(usize::MAX);
        semaphore.line.wake_some(ev, count);
        Ok(Value::None)
    })
}
