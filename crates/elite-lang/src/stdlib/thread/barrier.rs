//! `Barrier`: lets threads go on together, always so many at once.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use super::line::WaitQueue;
use super::{deadline, is_some_value};
use crate::builtins::BoundFn;
use crate::eval::Evaluator;
use crate::stdlib::define::{MethodDef, ModuleBuilder, instance, with_data};
use crate::value::data::Contents;
use crate::value::{R, ScriptCell, Unwind, Value};

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) {
    let make: BoundFn = |ev, args| {
        let made = instance(ev, "_thread.Barrier", Rc::new(Barrier::default()))?;
        // A subclass is made without arguments; its `__init__` gives them.
        if args[0].if_given().is_some() {
            begin(ev, &made, args)?;
        }
        Ok(made)
    };
    let class = module.class(
        "Barrier",
        Some(("parties? action? timeout?", make)),
        METHODS,
    );
    module.property(&class, "parties", |ev, args| {
        Ok(Value::Int(data(ev, &args[0])?.parties.get()))
    });
    module.property(&class, "n_waiting", |ev, args| {
        let barrier = data(ev, &args[0])?;
        Ok(Value::Int(barrier.round().count.get()))
    });
    module.property(&class, "broken", |ev, args| {
        Ok(Value::Bool(data(ev, &args[0])?.is_broken.get()))
    });
}

#[derive(Default)]
struct Barrier {
    parties: Cell<i64>,
    /// What the last thread of a round does before all go on, and how long they wait unless they say so.
    action: ScriptCell<Value>,
    timeout: ScriptCell<Value>,
    is_broken: Cell<bool>,
    round: RefCell<Rc<BarrierRound>>,
}

/// Threads that go on together.
#[derive(Default)]
struct BarrierRound {
    count: Cell<i64>,
    end: Cell<Option<RoundEnd>>,
    line: WaitQueue,
}

#[derive(Clone, Copy, PartialEq)]
enum RoundEnd {
    Full,
    Broken,
}

impl BarrierRound {
    fn end(&self, ev: &Evaluator<'_>, how: RoundEnd) {
        if self.end.get().is_none() {
            self.end.set(Some(how));
        }
        self.line.wake_some(ev, usize::MAX);
    }
}

impl Barrier {
    fn round(&self) -> Rc<BarrierRound> {
        self.round.borrow().clone()
    }

    /// The round that fills, which makes place for the next one.
    fn take_round(&self) -> Rc<BarrierRound> {
        self.round.take()
    }

    fn break_up(&self, ev: &Evaluator<'_>) {
        self.is_broken.set(true);
        self.take_round().end(ev, RoundEnd::Broken);
    }
}

impl Contents for Barrier {
    fn visit(&self, each: &mut dyn FnMut(&Value)) {
        for held in [&self.action, &self.timeout] {
            if let Some(value) = held.try_borrow() {
                each(&value);
            }
        }
    }

    fn clear(&self, held: &mut Vec<Value>) {
        held.push(self.action.take());
    }

    fn take(&mut self, held: &mut Vec<Value>) {
        held.extend([self.action.take(), self.timeout.take()]);
    }
}

fn data(ev: &Evaluator<'_>, receiver: &Value) -> R<Rc<Barrier>> {
    with_data(ev, receiver, |barrier: &Rc<Barrier>| Ok(barrier.clone()))
}

fn begin(ev: &Evaluator<'_>, receiver: &Value, args: &[Value]) -> R<()> {
    let barrier = data(ev, receiver)?;
    barrier.parties.set(ev.index(&args[0])?);
    ev.core.gc_track(receiver);
    let given = |value: &Value| value.if_given().cloned().unwrap_or(Value::None);
    barrier.action.put(given(&args[1]));
    barrier.timeout.put(given(&args[2]));
    Ok(())
}

/// `threading.BrokenBarrierError`
fn broken_error(ev: &Evaluator<'_>) -> Unwind {
    let made = || {
        let module = ev.import("threading")?;
        let class = ev.attribute(&module, ev.core.symbols.intern("BrokenBarrierError"))?;
        ev.call(&class, &mut [], &[])
    };
    match made() {
        Ok(Value::Instance(error)) => Unwind::Exception(error),
        Ok(_) => ev.type_error("threading.BrokenBarrierError is no exception"),
        Err(raised) => raised,
    }
}

fn wait(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let barrier = data(ev, &args[0])?;
    let timeout = match is_some_value(&args[1]) {
        true => args[1].clone(),
        false => barrier.timeout.get(),
    };
    let until = deadline(ev, &timeout)?;
    if barrier.is_broken.get() {
        return Err(broken_error(ev));
    }
    let round = barrier.round();
    let index = round.count.get();
    round.count.set(index + 1);
    if index + 1 >= barrier.parties.get() {
        // Who comes while the action is done belongs to the next round.
        barrier.take_round();
        let action = barrier.action.get();
        if !action.is_none()
            && let Err(raised) = ev.call(&action, &mut [], &[])
        {
            round.end(ev, RoundEnd::Broken);
            barrier.break_up(ev);
            return Err(raised);
        }
        round.end(ev, RoundEnd::Full);
        return Ok(Value::Int(index));
    }
    let called = match round.line.wait(ev, until, || {}) {
        Ok(called) => called,
        Err(raised) => {
            round.count.set(round.count.get() - 1);
            return Err(raised);
        }
    };
    match round.end.get() {
        Some(RoundEnd::Full) => Ok(Value::Int(index)),
        Some(RoundEnd::Broken) => Err(broken_error(ev)),
        None => {
            debug_assert!(!called, "a thread is called at the end of its round");
            barrier.break_up(ev);
            Err(broken_error(ev))
        }
    }
}

const METHODS: &[MethodDef] = &[
    ("__init__", "parties action? timeout?", |ev, args| {
        begin(ev, &args[0], &args[1..]).map(|()| Value::None)
    }),
    ("wait", "timeout?", wait),
    ("reset", "", |ev, args| {
        let barrier = data(ev, &args[0])?;
        barrier.is_broken.set(false);
        barrier.take_round().end(ev, RoundEnd::Broken);
        Ok(Value::None)
    }),
    ("abort", "", |ev, args| {
        data(ev, &args[0])?.break_up(ev);
        Ok(Value::None)
    }),
];
