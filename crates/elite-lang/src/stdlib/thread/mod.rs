//! `_thread`: starting script threads, and what they wait for each other with: locks, conditions, events, semaphores,
//! barriers. `threading` and `queue` are scripts on top of it.
//!
//! A wait parks the script thread: it is a safepoint that a stop ends, and its time is that of the host's clock. Who
//! has waited longest has its turn first, so a run under a virtual clock is the same every time. A thread that is
//! stopped while it waits gives up its place.

mod barrier;
mod condition;
mod event;
mod line;
mod lock;
mod semaphore;

use super::define::ModuleBuilder;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::eval::coroutine::SuspendRequest;
use crate::interpreter::ScriptThread;
use crate::value::{R, Value};

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    module.functions(&[
        ("get_ident", "", |ev, _| Ok(Value::Int(ident(ev)))),
        ("start_new_thread", "function args kwargs? /", start),
        ("sleep", "seconds /", |ev, args| {
            let seconds = ev.to_f64(&args[0])?;
            sleep(ev, seconds)
        }),
    ]);
    lock::fill(module);
    condition::fill(module);
    event::fill(module);
    semaphore::fill(module);
    barrier::fill(module);
    Ok(())
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
    let keywords_given = match args[2].if_given() {
        None => crate::value::Dict::new(),
        Some(value) => {
            let dict = crate::value::Dict::new();
            ev.update_from_mapping(&dict, value)?;
            dict
        }
    };
    let thread = ScriptThread::new(&ev.core, move |ev| {
        let (mut names, mut keywords) = (Vec::new(), Vec::new());
        for (_, key, value) in keywords_given.entries() {
            if let Value::Str(name) = key {
                let name = ev.temp_symbol(name.as_str())?;
                keywords.push((*name, value));
                names.push(name);
            }
        }
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
    ev.suspend(SuspendRequest::Park { until })
}

/// When a wait of `timeout` seconds from now is over; None for one without end.
fn deadline(ev: &Evaluator<'_>, timeout: &Value) -> R<Option<f64>> {
    match timeout.if_given() {
        None | Some(Value::None) => Ok(None),
        Some(seconds) => {
            let seconds = ev.to_f64(seconds)?;
            if seconds.is_nan() {
                return Err(ev.value_error("Invalid value NaN (not a number)"));
            }
            Ok(Some(ev.core.host.monotonic() + seconds.max(0.0)))
        }
    }
}

/// Whether a number is given where None and nothing mean that there is none.
fn is_some_value(value: &Value) -> bool {
    value.if_given().is_some_and(|value| !value.is_none())
}
