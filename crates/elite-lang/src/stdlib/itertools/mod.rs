//! `itertools`: iterators made from iterators.
//!
//! Owns the lazy ones that pass values on; those that choose from pools are in `pools`, the ones with shared buffers in
//! `shared`. Each iterator is a `IterState`: the values it holds, which the search for cycles can see, and its own
//! state.

mod pools;
mod shared;

use std::cell::Cell;
use std::rc::Rc;

use elite_syntax::ast::BinaryOp;

use super::define::{MethodDef, ModuleBuilder, native_class};
use crate::builtins::BoundFn;
use crate::eval::Evaluator;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::int::Int;
use crate::value::iter::{LibraryIterator, NativeIter};
use crate::value::symbol::known;
use crate::value::{Iter, List, R, ScriptCell, Value, ValueVec};

/// What `repr` says of an iterator.
type ReprFn<S> = fn(&Evaluator<'_>, &IterState<S>) -> R<String>;

/// An iterator of this module: values it holds, by number, and its own state, which holds none.
struct IterState<S> {
    held: ScriptCell<Vec<Value>>,
    state: S,
    next: fn(&Evaluator<'_>, &IterState<S>) -> R<Option<Value>>,
    repr: Option<ReprFn<S>>,
}

impl<S> IterState<S> {
    /// Held value number `index`; `Unbound` if it has been given away.
    fn get(&self, index: usize) -> Value {
        self.held.borrow().get(index).cloned().unwrap_or_default()
    }

    fn set(&self, index: usize, value: Value) {
        let old = self.held.with_mut(|held| match held.get_mut(index) {
            Some(place) => std::mem::replace(place, value),
            None => value,
        });
        drop(old);
    }

    /// The next value of the iterator held as number `index`.
    fn step(&self, ev: &Evaluator<'_>, index: usize) -> R<Option<Value>> {
        match self.get(index) {
            Value::Unbound => Ok(None),
            iterator => ev.next(&iterator),
        }
    }
}

impl<S: Clone + 'static> LibraryIterator for IterState<S> {
    fn next(&self, ev: &Evaluator<'_>) -> R<Option<Value>> {
        // Many of these never end by themselves, and builtins run them to their end.
        ev.safepoint()?;
        (self.next)(ev, self)
    }

    fn copy_with(
        &self,
        ev: &Evaluator<'_>,
        each: &dyn Fn(&Value) -> R,
    ) -> R<Option<Box<dyn LibraryIterator>>> {
        let count = self.held.borrow().len();
        let mut held = ValueVec::from(ev.try_with_capacity(count)?);
        // `each` may be a script's function, and others have their turn: what is held is looked at anew each time.
        for index in 0..count {
            held.push(match self.get(index) {
                Value::Unbound => Value::Unbound,
                value => each(&value)?,
            });
            ev.charge(WORK_PER_VALUE)?;
        }
        Ok(Some(Box::new(IterState {
            held: ScriptCell::new(held.into()),
            state: self.state.clone(),
            next: self.next,
            repr: self.repr,
        })))
    }

    fn visit(&self, each: &mut dyn FnMut(&Value)) {
        if let Some(held) = self.held.try_borrow() {
            held.iter().for_each(each);
        }
    }

    fn clear(&self, held: &mut Vec<Value>) {
        let mut own = self.held.take();
        match held.is_empty() {
            // Millions of values are handed over as they are.
            true => *held = own,
            false => held.append(&mut own),
        }
    }

    fn repr(&self, ev: &Evaluator<'_>) -> R<Option<String>> {
        self.repr.map(|repr| repr(ev, self)).transpose()
    }
}

/// An iterator of the class `name` (`itertools.count`).
fn lazy<S: Clone + 'static>(
    ev: &Evaluator<'_>,
    name: &str,
    held: Vec<Value>,
    state: S,
    next: fn(&Evaluator<'_>, &IterState<S>) -> R<Option<Value>>,
) -> R {
    lazy_with_repr(ev, name, held, state, next, None)
}

/// Like `lazy`, with a `repr` of its own.
fn lazy_with_repr<S: Clone + 'static>(
    ev: &Evaluator<'_>,
    name: &str,
    held: Vec<Value>,
    state: S,
    next: fn(&Evaluator<'_>, &IterState<S>) -> R<Option<Value>>,
    repr: Option<ReprFn<S>>,
) -> R {
    let steps = IterState {
        held: ScriptCell::new(held),
        state,
        next,
        repr,
    };
    let class = native_class(ev, name)?;
    Ok(Value::Iter(Rc::new(Iter::Native(NativeIter::new(
        class, steps,
    )))))
}

/// Tells the search for cycles of a list that grows values.
fn note(ev: &Evaluator<'_>, list: &Rc<List>) {
    if !list.gc_tracked.get() {
        ev.core.gc_track_list(list);
    }
}

const CLASSES: &[MethodDef] = &[
    ("accumulate", "iterable func? * initial?", accumulate),
    ("chain", "*iterables", |ev, args| {
        let iterables = ev.iter(&args[0])?;
        chain_from(ev, iterables)
    }),
    ("compress", "data selectors", |ev, args| {
        let held = vec![ev.iter(&args[0])?, ev.iter(&args[1])?];
        lazy(ev, "itertools.compress", held, (), |ev, own| {
            while let Some(value) = own.step(ev, 0)? {
                let Some(chosen) = own.step(ev, 1)? else {
                    break;
                };
                if ev.truth(&chosen)? {
                    return Ok(Some(value));
                }
                ev.safepoint()?;
            }
            Ok(None)
        })
    }),
    ("count", "start? step?", count),
    ("cycle", "iterable /", |ev, args| {
        let held = vec![ev.iter(&args[0])?, Value::list(Vec::new())];
        lazy(ev, "itertools.cycle", held, Cell::new(0), cycle_next)
    }),
    ("dropwhile", "predicate iterable /", |ev, args| {
        let held = vec![args[0].clone(), ev.iter(&args[1])?];
        let dropping = Cell::new(true);
        lazy(ev, "itertools.dropwhile", held, dropping, |ev, own| {
            while let Some(value) = own.step(ev, 1)? {
                if !own.state.get() || !truth_of(ev, &own.get(0), &value)? {
                    own.state.set(false);
                    return Ok(Some(value));
                }
                ev.safepoint()?;
            }
            Ok(None)
        })
    }),
    ("filterfalse", "function iterable /", |ev, args| {
        let held = vec![args[0].clone(), ev.iter(&args[1])?];
        lazy(ev, "itertools.filterfalse", held, (), |ev, own| {
            while let Some(value) = own.step(ev, 1)? {
                if !truth_of(ev, &own.get(0), &value)? {
                    return Ok(Some(value));
                }
                ev.safepoint()?;
            }
            Ok(None)
        })
    }),
    ("islice", "iterable first second? third? /", islice),
    ("pairwise", "iterable /", |ev, args| {
        let held = vec![ev.iter(&args[0])?, Value::Unbound];
        lazy(ev, "itertools.pairwise", held, (), |ev, own| {
            let before = match own.get(1) {
                Value::Unbound => own.step(ev, 0)?,
                value => Some(value),
            };
            let Some(before) = before else {
                return Ok(None);
            };
            own.set(1, before.clone());
            let Some(after) = own.step(ev, 0)? else {
                own.set(0, Value::Unbound);
                return Ok(None);
            };
            own.set(1, after.clone());
            Ok(Some(Value::tuple(vec![before, after])))
        })
    }),
    ("repeat", "object times?", repeat),
    ("starmap", "function iterable /", |ev, args| {
        let held = vec![args[0].clone(), ev.iter(&args[1])?];
        lazy(ev, "itertools.starmap", held, (), |ev, own| {
            let Some(args) = own.step(ev, 1)? else {
                return Ok(None);
            };
            let mut args = ev.collect(&args)?;
            ev.call(&own.get(0), &mut args, &[]).map(Some)
        })
    }),
    ("takewhile", "predicate iterable /", |ev, args| {
        let held = vec![args[0].clone(), ev.iter(&args[1])?];
        lazy(ev, "itertools.takewhile", held, (), |ev, own| {
            let Some(value) = own.step(ev, 1)? else {
                return Ok(None);
            };
            let verdict = ev.call1(&own.get(0), value.clone())?;
            if ev.truth(&verdict)? {
                return Ok(Some(value));
            }
            own.set(1, Value::Unbound);
            Ok(None)
        })
    }),
];

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    for list in [CLASSES, pools::CLASSES, shared::CLASSES] {
        for (name, signature, constructor) in list {
            module.iterator_class(name, Some((signature, *constructor)));
        }
    }
    module.raw_iterator_class("product", pools::product);
    module.raw_iterator_class("zip_longest", pools::zip_longest);
    shared::fill(module)?;
    let from_iterable: BoundFn = |ev, args| {
        let iterables = ev.iter(&args[1])?;
        chain_from(ev, iterables)
    };
    let chain = native_class(module.ev, "itertools.chain")?;
    module.class_method(&chain, "from_iterable", "iterable /", from_iterable);
    let repeat = native_class(module.ev, "itertools.repeat")?;
    module.method(
        &repeat,
        "__length_hint__",
        "",
        |ev, args| match repetitions(&args[0]) {
            Some(left) => Ok(Value::Int(left)),
            None => Err(ev.type_error("len() of unsized object")),
        },
    );
    Ok(())
}

/// Whether `predicate` (None: the value itself) holds for a value.
fn truth_of(ev: &Evaluator<'_>, predicate: &Value, value: &Value) -> R<bool> {
    let is_bool = |class: &Rc<crate::value::Class>| Rc::ptr_eq(class, &ev.core.types.bool);
    match predicate {
        Value::None => ev.truth(value),
        Value::Class(class) if is_bool(class) => ev.truth(value),
        predicate => {
            let verdict = ev.call1(predicate, value.clone())?;
            ev.truth(&verdict)
        }
    }
}

fn accumulate(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let none = |value: &Value| value.if_given().cloned().unwrap_or(Value::None);
    let held = vec![
        ev.iter(&args[0])?,
        none(&args[1]),
        Value::Unbound,
        none(&args[2]),
    ];
    lazy(ev, "itertools.accumulate", held, (), |ev, own| {
        let initial = own.get(3);
        if !initial.is_none() && !initial.is_unbound() {
            own.set(3, Value::None);
            own.set(2, initial.clone());
            return Ok(Some(initial));
        }
        let Some(value) = own.step(ev, 0)? else {
            return Ok(None);
        };
        let total = match (own.get(2), own.get(1)) {
            (Value::Unbound, _) => value,
            (total, Value::None) => ev.binary(BinaryOp::Add, &total, &value)?,
            (total, function) => ev.call(&function, &mut [total, value], &[])?,
        };
        own.set(2, total.clone());
        Ok(Some(total))
    })
}

/// `chain` over the iterables an iterator gives.
fn chain_from(ev: &Evaluator<'_>, iterables: Value) -> R {
    let held = vec![iterables, Value::Unbound];
    lazy(ev, "itertools.chain", held, (), |ev, own| {
        loop {
            if let Some(value) = own.step(ev, 1)? {
                return Ok(Some(value));
            }
            own.set(1, Value::Unbound);
            match own.step(ev, 0) {
                Ok(Some(iterable)) => own.set(1, ev.iter(&iterable)?),
                end => {
                    own.set(0, Value::Unbound);
                    return end;
                }
            }
            ev.safepoint()?;
        }
    })
}

fn count(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let start = args[0].if_given().cloned().unwrap_or(Value::Int(0));
    let step = args[1].if_given().cloned().unwrap_or(Value::Int(1));
    for value in [&start, &step] {
        let is_number = match value {
            Value::Float(_) | Value::Complex(_) => true,
            Value::Instance(instance) => {
                instance
                    .builtin_value()
                    .is_some_and(|value| rank_of_number(&value))
                    || [known::INT, known::FLOAT, known::INDEX]
                        .iter()
                        .any(|name| instance.class.lookup(*name).is_some())
            }
            value => Int::of(value).is_some(),
        };
        if !is_number {
            return Err(ev.type_error("a number is required"));
        }
    }
    let next = |ev: &Evaluator<'_>, own: &IterState<()>| {
        let (now, step) = (own.get(0), own.get(1));
        if now.is_unbound() {
            return Ok(None);
        }
        let following = match (&now, &step) {
            (Value::Int(now), Value::Int(step)) => now.checked_add(*step).map(Value::Int),
            _ => None,
        };
        let following = match following {
            Some(following) => following,
            None => ev.binary(BinaryOp::Add, &now, &step)?,
        };
        own.set(0, following);
        Ok(Some(now))
    };
    let repr = |ev: &Evaluator<'_>, own: &IterState<()>| {
        let (now, step) = (ev.repr(&own.get(0))?, own.get(1));
        Ok(match step {
            Value::Int(1) => format!("count({now})"),
            step => format!("count({now}, {})", ev.repr(&step)?),
        })
    };
    lazy_with_repr(
        ev,
        "itertools.count",
        vec![start, step],
        (),
        next,
        Some(repr),
    )
}

fn rank_of_number(value: &Value) -> bool {
    Int::of(value).is_some() || matches!(value, Value::Float(_) | Value::Complex(_))
}

fn cycle_next(ev: &Evaluator<'_>, own: &IterState<Cell<usize>>) -> R<Option<Value>> {
    let Value::List(saved) = own.get(1) else {
        return Ok(None);
    };
    if let Some(value) = own.step(ev, 0)? {
        note(ev, &saved);
        saved.push(value.clone());
        ev.check_memory()?;
        return Ok(Some(value));
    }
    own.set(0, Value::Unbound);
    let at = own.state.get();
    own.state.set(if at + 1 < saved.len() { at + 1 } else { 0 });
    Ok(saved.get(at))
}

/// How often a `repeat` still gives its object; None if for ever.
fn repetitions(value: &Value) -> Option<i64> {
    let Value::Iter(iter) = value else {
        return None;
    };
    let Iter::Native(native) = &**iter else {
        return None;
    };
    let mut left = None;
    native.steps.visit(&mut |value| {
        if let Value::Int(count) = value {
            left = Some(*count);
        }
    });
    left.filter(|left| *left >= 0)
}

fn repeat(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    // The count is held last, -1 for no end.
    let left = match args[1].if_given() {
        Some(times) => ev.index(times)?.max(0),
        None => -1,
    };
    let held = vec![args[0].clone(), Value::Int(left)];
    let next = |_: &Evaluator<'_>, own: &IterState<()>| {
        let Value::Int(left) = own.get(1) else {
            return Ok(None);
        };
        if left == 0 {
            return Ok(None);
        }
        if left > 0 {
            own.set(1, Value::Int(left - 1));
        }
        Ok(Some(own.get(0)))
    };
    let repr = |ev: &Evaluator<'_>, own: &IterState<()>| {
        let object = ev.repr(&own.get(0))?;
        Ok(match own.get(1) {
            Value::Int(left) if left >= 0 => format!("repeat({object}, {left})"),
            _ => format!("repeat({object})"),
        })
    };
    lazy_with_repr(ev, "itertools.repeat", held, (), next, Some(repr))
}

/// What an `islice` has taken and takes next.
#[derive(Clone)]
struct SliceCursor {
    taken: Cell<i64>,
    next: Cell<i64>,
    /// `i64::MAX` for no end.
    stop: i64,
    step: i64,
}

fn islice(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    const INDICES: &str = "Indices for islice() must be None or an integer: 0 <= x <= sys.maxsize.";
    const STOP: &str =
        "Stop argument for islice() must be None or an integer: 0 <= x <= sys.maxsize.";
    const STEP: &str = "Step for islice() must be a positive integer or None.";
    let bound = |value: &Value, default: i64, least: i64, text: &str| match value {
        Value::Unbound | Value::None => Ok(default),
        value => match ev.index(value) {
            Ok(index) if index >= least => Ok(index),
            _ => Err(ev.value_error(text)),
        },
    };
    let alone = args[2].is_unbound();
    // What is no number of C stands for -1 in CPython, which is refused before smaller ones are.
    let (start, stop) = if alone {
        (0, bound(&args[1], i64::MAX, i64::MIN, STOP)?)
    } else {
        let stop = bound(&args[2], i64::MAX, i64::MIN, STOP)?;
        (bound(&args[1], 0, i64::MIN, INDICES)?, stop)
    };
    if stop == -1 {
        return Err(ev.value_error(STOP));
    }
    if start < 0 || stop < 0 {
        return Err(ev.value_error(INDICES));
    }
    let step = bound(&args[3], 1, 1, STEP)?;
    let window = SliceCursor {
        taken: Cell::new(0),
        next: Cell::new(start),
        stop,
        step,
    };
    let held = vec![ev.iter(&args[0])?];
    lazy(ev, "itertools.islice", held, window, |ev, own| {
        let window = &own.state;
        let end = || {
            own.set(0, Value::Unbound);
            Ok(None)
        };
        while window.taken.get() < window.next.get() {
            if own.step(ev, 0)?.is_none() {
                return end();
            }
            window.taken.set(window.taken.get() + 1);
            ev.safepoint()?;
        }
        if window.taken.get() >= window.stop {
            return end();
        }
        let Some(value) = own.step(ev, 0)? else {
            return end();
        };
        window.taken.set(window.taken.get() + 1);
        let next = window.next.get().saturating_add(window.step);
        window.next.set(next.min(window.stop));
        Ok(Some(value))
    })
}
