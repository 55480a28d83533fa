//! `Condition`: a lock, and threads that wait for word about what it guards.

use std::rc::Rc;

use super::line::WaitQueue;
use super::lock::Lock;
use super::{deadline, is_some_value};
use crate::builtins::BoundFn;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::stdlib::define::{MethodDef, ModuleBuilder, instance, native_class, with_data};
use crate::value::data::Contents;
use crate::value::{R, ScriptCell, Value};

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) {
    let make: BoundFn = |ev, args| {
        let made = instance(ev, "_thread.Condition", Condition::default())?;
        begin(ev, &made, &args[0])?;
        Ok(made)
    };
    let class = module.class("Condition", Some(("lock?", make)), METHODS);
    module.property(&class, "_lock", |ev, args| {
        with(ev, args, |condition| Ok(condition.lock.get()))
    });
    module.property(&class, "_waiters", |ev, args| {
        with(ev, args, |condition| {
            let threads = condition.line.threads().into_iter();
            let idents = threads.map(|thread| i64::try_from(thread).unwrap_or(i64::MAX));
            Ok(Value::list(idents.map(Value::Int).collect()))
        })
    });
}

#[derive(Default)]
struct Condition {
    lock: ScriptCell<Value>,
    line: WaitQueue,
}

impl Contents for Condition {
    fn visit(&self, each: &mut dyn FnMut(&Value)) {
        // The lock may be an object of the script.
        if let Some(lock) = self.lock.try_borrow() {
            each(&lock);
        }
    }

    fn clear(&self, held: &mut Vec<Value>) {
        held.push(self.lock.take());
    }

    fn take(&mut self, held: &mut Vec<Value>) {
        self.clear(held);
    }
}

fn begin(ev: &Evaluator<'_>, receiver: &Value, lock: &Value) -> R<()> {
    let lock = match is_some_value(lock) {
        true => lock.clone(),
        false => ev.call(
            &Value::Class(native_class(ev, "_thread.RLock")?),
            &mut [],
            &[],
        )?,
    };
    ev.core.gc_track(receiver);
    with_data(ev, receiver, |condition: &Condition| {
        condition.lock.put(lock);
        Ok(())
    })
}

/// What holds the lock while a thread waits: the count of one of ours, or what an object of the script kept.
enum SavedLock {
    Count(u32),
    State(Value),
    Nothing,
}

/// A lock as a condition needs it. Objects of scripts are asked as CPython asks them.
struct ConditionLock<'a, 'y> {
    ev: &'a Evaluator<'y>,
    lock: Value,
}

impl ConditionLock<'_, '_> {
    /// The lock, if it is one of ours and no script has a word in it.
    fn native<T>(&self, act: impl FnOnce(&Lock) -> R<T>) -> Option<R<T>> {
        let Value::Instance(instance) = &self.lock else {
            return None;
        };
        let lock = instance.object::<Rc<Lock>>()?;
        Some(act(lock))
    }

    fn ask(&self, name: &str, args: &mut [Value]) -> R<Option<Value>> {
        let ev = self.ev;
        match ev.attribute_or_none(&self.lock, ev.core.symbols.intern(name))? {
            Some(method) => ev.call(&method, args, &[]).map(Some),
            None => Ok(None),
        }
    }

    fn must(&self, name: &str, args: &mut [Value]) -> R {
        let ev = self.ev;
        let method = ev.attribute(&self.lock, ev.core.symbols.intern(name))?;
        ev.call(&method, args, &[])
    }

    fn is_owned(&self) -> R<bool> {
        let ev = self.ev;
        if let Some(owned) = self.native(|lock| Ok(lock.is_owned(ev))) {
            return owned;
        }
        if let Some(owned) = self.ask("_is_owned", &mut [])? {
            return ev.truth(&owned);
        }
        let got = self.must("acquire", &mut [Value::Bool(false)])?;
        let was_free = ev.truth(&got)?;
        if was_free {
            self.must("release", &mut [])?;
        }
        Ok(!was_free)
    }

    fn release(&self) -> R<SavedLock> {
        let ev = self.ev;
        if let Some(count) = self.native(|lock| lock.release_all(ev)) {
            return count.map(SavedLock::Count);
        }
        if let Some(state) = self.ask("_release_save", &mut [])? {
            return Ok(SavedLock::State(state));
        }
        self.must("release", &mut []).map(|_| SavedLock::Nothing)
    }

    fn acquire(&self, kept: SavedLock) -> R<()> {
        let ev = self.ev;
        match kept {
            SavedLock::Count(count) => match self.native(|lock| lock.acquire_again(ev, count)) {
                Some(done) => done,
                None => Ok(()),
            },
            SavedLock::State(state) => self.must("_acquire_restore", &mut [state]).map(drop),
            SavedLock::Nothing => self.must("acquire", &mut []).map(drop),
        }
    }
}

fn with(ev: &Evaluator<'_>, args: &[Value], act: impl FnOnce(&Condition) -> R) -> R {
    with_data(ev, &args[0], act)
}

fn guard<'a, 'y>(ev: &'a Evaluator<'y>, receiver: &Value) -> R<ConditionLock<'a, 'y>> {
    let lock = with_data(ev, receiver, |condition: &Condition| {
        Ok(condition.lock.get())
    })?;
    Ok(ConditionLock { ev, lock })
}

fn check_owned(guard: &ConditionLock<'_, '_>, act: &str) -> R<()> {
    if guard.is_owned()? {
        return Ok(());
    }
    let text = format!("cannot {act} on un-acquired lock");
    Err(guard.ev.raise(ExceptionKind::RuntimeError, text))
}

/// Gives the lock up, waits for word, and takes the lock again.
fn wait(ev: &Evaluator<'_>, receiver: &Value, until: Option<f64>) -> R<bool> {
    let guard = guard(ev, receiver)?;
    check_owned(&guard, "wait")?;
    let kept = guard.release()?;
    let told = with_data(ev, receiver, |condition: &Condition| {
        // Word that reached a thread which is stopped is for the next one.
        condition.line.wait(ev, until, || {
            condition.line.notify_one(ev);
        })
    });
    // A thread that is stopped leaves blocks which give the lock up: it takes it if it can.
    let again = guard.acquire(kept);
    let told = told?;
    again.map(|()| told)
}

fn notify(ev: &Evaluator<'_>, receiver: &Value, count: i64) -> R {
    check_owned(&guard(ev, receiver)?, "notify")?;
    with_data(ev, receiver, |condition: &Condition| {
        let count = usize::try_from(count).unwrap_or(0);
        condition.line.wake_some(ev, count);
        Ok(Value::None)
    })
}

const METHODS: &[MethodDef] = &[
    ("__init__", "lock?", |ev, args| {
        begin(ev, &args[0], &args[1]).map(|()| Value::None)
    }),
    ("acquire", "blocking? timeout?", |ev, args| {
        let mut given: Vec<Value> = args[1..]
            .iter()
            .filter_map(|arg| arg.if_given().cloned())
            .collect();
        let guard = guard(ev, &args[0])?;
        if args[1].is_unbound() && !args[2].is_unbound() {
            given.insert(0, Value::Bool(true));
        }
        guard.must("acquire", &mut given)
    }),
    ("release", "", |ev, args| {
        guard(ev, &args[0])?.must("release", &mut [])
    }),
    ("__enter__", "", |ev, args| {
        guard(ev, &args[0])?.must("__enter__", &mut [])
    }),
    ("__exit__", "type value traceback /", |ev, args| {
        let guard = guard(ev, &args[0])?;
        guard.must("__exit__", &mut args[1..])
    }),
    ("_is_owned", "", |ev, args| {
        guard(ev, &args[0])?.is_owned().map(Value::Bool)
    }),
    ("wait", "timeout?", |ev, args| {
        let until = deadline(ev, &args[1])?;
        wait(ev, &args[0], until).map(Value::Bool)
    }),
    ("wait_for", "predicate timeout?", |ev, args| {
        let until = deadline(ev, &args[2])?;
        // By the `wait` of its class, which may be one of a script.
        let wait = ev.attribute(&args[0], ev.core.symbols.intern("wait"))?;
        loop {
            let result = ev.call(&args[1], &mut [], &[])?;
            let left = until.map(|end| end - ev.core.host.monotonic());
            if ev.truth(&result)? || left.is_some_and(|left| left <= 0.0) {
                return Ok(result);
            }
            let timeout = left.map_or(Value::None, Value::Float);
            ev.call(&wait, &mut [timeout], &[])?;
        }
    }),
    ("notify", "n?", |ev, args| {
        let count = args[1].if_given().map_or(Ok(1), |n| ev.index(n))?;
        notify(ev, &args[0], count)
    }),
    ("notify_all", "", |ev, args| notify(ev, &args[0], i64::MAX)),
    ("notifyAll", "", |ev, args| notify(ev, &args[0], i64::MAX)),
    ("__repr__", "", |ev, args| {
        let lock = ev.str(&guard(ev, &args[0])?.lock)?;
        with(ev, args, |condition| {
            let waiting = condition.line.len();
            Ok(Value::str(format!("<Condition({lock}, {waiting})>")))
        })
    }),
];
