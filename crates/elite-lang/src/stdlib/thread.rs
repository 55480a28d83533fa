//! `_thread`: locks that park script threads, and starting threads. `threading` and `queue` are scripts on top of it.
//!
//! A lock is handed directly to the thread that has waited longest, so the order of threads is that of their asking,
//! and a run under a virtual clock is the same every time. A thread that is stopped while it waits gives up its place.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;

use super::define::{Builder, with_data};
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::eval::coroutine::{Request, Stopping};
use crate::host::ThreadId;
use crate::interpreter::ScriptThread;
use crate::value::{R, Value};

pub(super) fn fill(module: &Builder<'_, '_>) -> R<()> {
    module.functions(&[
        ("get_ident", "", |ev, _| Ok(Value::Int(ident(ev)))),
        ("start_new_thread", "function args kwargs? /", start),
        ("sleep", "seconds /", |ev, args| {
            let seconds = ev.to_f64(&args[0])?;
            sleep(ev, seconds)
        }),
    ]);
    let methods: &[super::define::Entry] = &[
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
            with_data(ev, &args[0], |lock: &Rc<Lock>| {
                lock.clone().acquire(ev, None)
            })?;
            Ok(Value::Bool(true))
        }),
        ("__exit__", "type? value? traceback? /", |ev, args| {
            with_data(ev, &args[0], |lock: &Rc<Lock>| lock.release(ev, true))?;
            Ok(Value::None)
        }),
        ("_is_owned", "", |ev, args| {
            with_data(ev, &args[0], |lock: &Rc<Lock>| {
                let owner = lock.owner.get();
                // Like CPython, a plain lock counts as owned by whoever asks while it is locked.
                let me = !lock.reentrant || owner == Some(ev.core.thread.get());
                Ok(Value::Bool(owner.is_some() && me))
            })
        }),
        ("_release_save", "", |ev, args| {
            with_data(ev, &args[0], |lock: &Rc<Lock>| {
                let count = lock.count.replace(1);
                lock.release(ev, false)?;
                Ok(Value::Int(i64::from(count)))
            })
        }),
        ("_acquire_restore", "count /", |ev, args| {
            let count = ev.index(&args[1])?;
            with_data(ev, &args[0], |lock: &Rc<Lock>| {
                lock.clone().acquire(ev, None)?;
                lock.count.set(u32::try_from(count).unwrap_or(1));
                Ok(Value::None)
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
    Ok(())
}

fn new_lock(ev: &Evaluator<'_>, class: &str, reentrant: bool) -> R {
    let lock = Lock {
        reentrant,
        ..Lock::default()
    };
    super::define::instance(ev, &format!("_thread.{class}"), Rc::new(lock))
}

/// A number for the running thread, as `threading.get_ident` gives it.
fn ident(ev: &Evaluator<'_>) -> i64 {
    i64::try_from(ev.core.thread.get()).unwrap_or(i64::MAX)
}

fn start(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    if !args[0].is_callable() {
        return Err(ev.type_error("first arg must be callable"));
    }
    let function = args[0].clone();
    let positional = ev.collect(&args[1])?;
    let keywords = match args[2].given() {
        None => crate::value::Dict::new(),
        Some(value) => {
            let dict = crate::value::Dict::new();
            ev.update_from_mapping(&dict, value)?;
            dict
        }
    };
    let thread = ScriptThread::new(&ev.core, move |ev| {
        let named = keywords.entries().into_iter();
        let (names, values): (Vec<_>, Vec<_>) = named
            .filter_map(|(_, key, value)| match key {
                Value::Str(name) => Some((ev.core.symbols.ask(name.as_str()), value)),
                _ => None,
            })
            .unzip();
        let symbols = names.iter().map(|name| **name);
        let keywords: Vec<_> = symbols.zip(values).collect();
        ev.call(&function, &mut { positional }, &keywords)
    });
    let id = thread.id();
    match ev.core.host.start(thread) {
        Ok(()) => Ok(Value::Int(i64::try_from(id.0).unwrap_or(i64::MAX))),
        Err(reason) => Err(ev.raise(
            ExceptionKind::RuntimeError,
            format!("can't start new thread: {reason}"),
        )),
    }
}

/// Waits for simulated or real time to pass.
pub(super) fn sleep(ev: &Evaluator<'_>, seconds: f64) -> R {
    if seconds.is_nan() {
        return Err(ev.value_error("Invalid value NaN (not a number)"));
    }
    if seconds < 0.0 {
        return Err(ev.value_error("sleep length must be non-negative"));
    }
    let until = ev.core.host.monotonic() + seconds;
    loop {
        park(ev, Some(until))?;
        if ev.core.host.monotonic() >= until {
            return Ok(Value::None);
        }
    }
}

/// Raises unless the host lets the running thread wait.
pub(super) fn check_may_wait(ev: &Evaluator<'_>) -> R<()> {
    match ev.core.host.may_wait() {
        Ok(()) => Ok(()),
        Err(reason) => Err(ev.raise(ExceptionKind::RuntimeError, reason)),
    }
}

/// Suspends the running thread until it is woken or the host's time has come; it may also return early.
pub(super) fn park(ev: &Evaluator<'_>, until: Option<f64>) -> R<()> {
    check_may_wait(ev)?;
    ev.suspend(Request::Park { until })
}

/// A lock of either kind.
#[derive(Default)]
struct Lock {
    reentrant: bool,
    owner: Cell<Option<u64>>,
    /// How often the owner holds it.
    count: Cell<u32>,
    waiters: RefCell<VecDeque<Waiter>>,
}

struct Waiter {
    thread: u64,
    /// Set when the lock has been handed over.
    granted: Rc<Cell<bool>>,
}

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
    fn acquire(self: Rc<Self>, ev: &Evaluator<'_>, deadline: Option<f64>) -> R<bool> {
        let me = ev.core.thread.get();
        if self.try_acquire(me) {
            return Ok(true);
        }
        let granted = Rc::new(Cell::new(false));
        self.waiters.borrow_mut().push_back(Waiter {
            thread: me,
            granted: granted.clone(),
        });
        loop {
            let waited = park(ev, deadline);
            if let Err(raised) = waited {
                if granted.get() {
                    self.hand_over(ev);
                } else {
                    self.forget(&granted);
                }
                return Err(raised);
            }
            if granted.get() {
                return Ok(true);
            }
            if deadline.is_some_and(|deadline| ev.core.host.monotonic() >= deadline) {
                self.forget(&granted);
                return Ok(false);
            }
        }
    }

    fn forget(&self, granted: &Rc<Cell<bool>>) {
        self.waiters
            .borrow_mut()
            .retain(|waiter| !Rc::ptr_eq(&waiter.granted, granted));
    }

    /// Gives up one hold. `leaving`: at the end of a `with` block, which a thread that is being stopped also reaches
    /// when the lock was taken from it (`Condition.wait`); then there is nothing to give up.
    fn release(&self, ev: &Evaluator<'_>, leaving: bool) -> R<()> {
        let me = Some(ev.core.thread.get());
        let owner = self.owner.get();
        if leaving && ev.core.stopping.get() != Stopping::No && owner != me {
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
        let next = self.waiters.borrow_mut().pop_front();
        match next {
            Some(waiter) => {
                self.owner.set(Some(waiter.thread));
                self.count.set(1);
                waiter.granted.set(true);
                ev.core.host.wake(ThreadId(waiter.thread));
            }
            None => {
                self.owner.set(None);
                self.count.set(0);
            }
        }
    }
}

fn acquire(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let blocking = match args[1].given() {
        Some(value) => ev.truth(value)?,
        None => true,
    };
    let timeout = match args[2].given() {
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
        lock.clone().acquire(ev, deadline).map(Value::Bool)
    })
}
