//! `Lock` and `RLock`: handed directly to the thread that has waited longest.

use std::cell::Cell;
use std::rc::Rc;

use super::line::WaitQueue;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::eval::coroutine::StopState;
use crate::stdlib::define::{MethodDef, ModuleBuilder, instance, with_data};
use crate::value::data::no_values;
use crate::value::{R, Value};

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) {
    let methods: &[MethodDef] = &[
        ("acquire", "blocking? timeout?", acquire),
        ("release", "", |ev, args| {
            with_data(ev, &args[0], |lock: &Rc<Lock>| lock.release(ev, false))?;
            Ok(Value::None)
        }),
        ("locked", "", |ev, args| {
            with_data(ev, &args[0], |lock: &Rc<Lock>| {
                Ok(Value::Bool(lock.owner.get().is_some()))
            })
        }),
        ("__enter__", "", |ev, args| {
            with_data(ev, &args[0], |lock: &Rc<Lock>| lock.acquire(ev, None))?;
            Ok(Value::Bool(true))
        }),
        ("__exit__", "type? value? traceback? /", |ev, args| {
            with_data(ev, &args[0], |lock: &Rc<Lock>| lock.release(ev, true))?;
            Ok(Value::None)
        }),
        ("_is_owned", "", |ev, args| {
            with_data(ev, &args[0], |lock: &Rc<Lock>| {
                Ok(Value::Bool(lock.is_owned(ev)))
            })
        }),
        ("_release_save", "", |ev, args| {
            with_data(ev, &args[0], |lock: &Rc<Lock>| {
                lock.release_all(ev).map(|count| Value::Int(count.into()))
            })
        }),
        ("_acquire_restore", "count /", |ev, args| {
            let count = u32::try_from(ev.index(&args[1])?).unwrap_or(1);
            with_data(ev, &args[0], |lock: &Rc<Lock>| {
                lock.acquire_again(ev, count).map(|()| Value::None)
            })
        }),
    ];
    module.class(
        "lock",
        Some(("", |ev, _| new_lock(ev, "lock", false))),
        methods,
    );
    module.class(
        "RLock",
        Some(("", |ev, _| new_lock(ev, "RLock", true))),
        methods,
    );
}

fn new_lock(ev: &Evaluator<'_>, class: &str, reentrant: bool) -> R {
    let lock = Lock {
        reentrant,
        ..Lock::default()
    };
    instance(ev, &format!("_thread.{class}"), Rc::new(lock))
}

/// A lock of either kind.
#[derive(Default)]
pub(super) struct Lock {
    reentrant: bool,
    owner: Cell<Option<u64>>,
    /// How often the owner holds it.
    count: Cell<u32>,
    line: WaitQueue,
}

no_values!(Lock);

impl Lock {
    fn try_acquire(&self, me: u64) -> bool {
        match self.owner.get() {
            None => self.owner.set(Some(me)),
            Some(owner) if self.reentrant && owner == me => {}
            Some(_) => return false,
        }
        self.count.set(self.count.get() + 1);
        true
    }

    /// Waits until the running thread holds the lock, at most until `deadline`; whether it does.
    pub(super) fn acquire(&self, ev: &Evaluator<'_>, deadline: Option<f64>) -> R<bool> {
        if self.try_acquire(ev.core.thread.get()) {
            return Ok(true);
        }
        // Whoever gives the lock up hands it over; a thread that is being stopped hands it on.
        self.line.wait(ev, deadline, || self.hand_over(ev))
    }

    /// Whether the running thread may say that it has the lock. Like CPython, a plain lock counts as owned by whoever
    /// asks while it is locked.
    pub(super) fn is_owned(&self, ev: &Evaluator<'_>) -> bool {
        let owner = self.owner.get();
        owner.is_some() && (!self.reentrant || owner == Some(ev.core.thread.get()))
    }

    /// Gives the lock up, however often it is held; how often that is.
    pub(super) fn release_all(&self, ev: &Evaluator<'_>) -> R<u32> {
        let count = self.count.get();
        if self.is_owned(ev) {
            self.count.set(1);
        }
        self.release(ev, false)?;
        Ok(count)
    }

    /// Takes it again as often as it was held.
    pub(super) fn acquire_again(&self, ev: &Evaluator<'_>, count: u32) -> R<()> {
        self.acquire(ev, None)?;
        self.count.set(count);
        Ok(())
    }

    /// Gives up one hold. `leaving`: at the end of a `with` block, which a thread that is being stopped also reaches
    /// when the lock was taken from it (`Condition.wait`); then there is nothing to give up.
    fn release(&self, ev: &Evaluator<'_>, leaving: bool) -> R<()> {
        let me = Some(ev.core.thread.get());
        let owner = self.owner.get();
        if leaving && ev.core.stopping.get() != StopState::No && owner != me {
            return Ok(());
        }
        if self.reentrant && owner != me {
            return Err(ev.raise(
                ExceptionKind::RuntimeError,
                "cannot release un-acquired lock",
            ));
        }
        if owner.is_none() {
            return Err(ev.raise(ExceptionKind::RuntimeError, "release unlocked lock"));
        }
        let count = self.count.get() - 1;
        self.count.set(count);
        if count == 0 {
            self.hand_over(ev);
        }
        Ok(())
    }

    /// The next one in the queue gets the lock; without one it is free.
    fn hand_over(&self, ev: &Evaluator<'_>) {
        match self.line.notify_one(ev) {
            Some(thread) => {
                self.owner.set(Some(thread));
                self.count.set(1);
            }
            None => {
                self.owner.set(None);
                self.count.set(0);
            }
        }
    }
}

fn acquire(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let blocking = match args[1].if_given() {
        Some(value) => ev.truth(value)?,
        None => true,
    };
    let timeout = match args[2].if_given() {
        Some(value) => ev.to_f64(value)?,
        None => -1.0,
    };
    if !blocking && timeout != -1.0 {
        return Err(ev.value_error("can't specify a timeout for a non-blocking call"));
    }
    if timeout < 0.0 && timeout != -1.0 {
        return Err(ev.value_error("timeout value must be a non-negative number"));
    }
    with_data(ev, &args[0], |lock: &Rc<Lock>| {
        if !blocking {
            return Ok(Value::Bool(lock.try_acquire(ev.core.thread.get())));
        }
        let deadline = (timeout >= 0.0).then(|| ev.core.host.monotonic() + timeout);
        lock.acquire(ev, deadline).map(Value::Bool)
    })
}
