//! `itertools`: iterators that share what they have read: `tee` and `groupby`.
//!
//! What is shared lies in lists of the language, so that references are counted and cycles are found.

use std::cell::Cell;
use std::rc::Rc;

use super::{IterState, lazy, note};
use crate::eval::Evaluator;
use crate::stdlib::define::{MethodDef, ModuleBuilder};
use crate::value::iter::NativeIter;
use crate::value::{Iter, List, R, Value};

pub(super) const CLASSES: &[MethodDef] = &[
    ("groupby", "iterable key?", groupby),
    ("_tee", "iterable /", |ev, args| {
        let source = ev.iter(&args[0])?;
        branch(ev, source, Value::list(Vec::new()), 0)
    }),
];

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    module.iterator_class("_grouper", None);
    module.functions(&[("tee", "iterable n? /", tee)]);
    let class = crate::stdlib::define::native_class(module.ev, "itertools._tee")?;
    module.method(&class, "__copy__", "", |ev, args| {
        let (source, block, at) = parts(&args[0]);
        branch(ev, source, block, at)
    });
    Ok(())
}

/// Values of one block of a `tee`; behind them stands the next block, once somebody has come so far.
const BLOCK: usize = 57;

/// A branch of a `tee`: the source, the block that it stands in, and where.
fn branch(ev: &Evaluator<'_>, source: Value, block: Value, at: usize) -> R {
    let held = vec![source, block, Value::Int(at as i64)];
    lazy(ev, "itertools._tee", held, (), |ev, own| {
        loop {
            let (Value::List(block), Value::Int(at)) = (own.get(1), own.get(2)) else {
                return Ok(None);
            };
            let at = at as usize;
            if at == BLOCK {
                let next = block.get(BLOCK).unwrap_or_else(|| {
                    let next = Value::list(Vec::with_capacity(BLOCK + 1));
                    block.push(next.clone());
                    next
                });
                own.set(1, next);
                own.set(2, Value::Int(0));
                continue;
            }
            if let Some(value) = block.get(at) {
                own.set(2, Value::Int(at as i64 + 1));
                return Ok(Some(value));
            }
            let Some(value) = own.step(ev, 0)? else {
                return Ok(None);
            };
            // Another branch may have read while the source was stepped.
            if block.len() == at {
                note(ev, &block);
                block.push(value);
                ev.check_memory()?;
            }
        }
    })
}

/// What a branch holds.
fn parts(value: &Value) -> (Value, Value, usize) {
    let mut held = Vec::new();
    if let Value::Iter(iter) = value
        && let Iter::Native(NativeIter { steps, .. }) = &**iter
    {
        steps.visit(&mut |value| held.push(value.clone()));
    }
    let at = held.pop().and_then(|at| at.as_i64()).unwrap_or(0);
    let block = held.pop().unwrap_or_default();
    (held.pop().unwrap_or_default(), block, at as usize)
}

fn tee(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let count = match args[1].if_given() {
        Some(n) => ev.index(n)?,
        None => 2,
    };
    let Ok(count) = usize::try_from(count) else {
        return Err(ev.value_error("n must be >= 0"));
    };
    ev.check_allocation(count.saturating_mul(8 * size_of::<Value>()))?;
    let iterator = ev.iter(&args[0])?;
    let (mut source, mut block, mut at) = (iterator.clone(), Value::list(Vec::new()), 0);
    // A branch of another `tee` is the first of the new ones, and the others share what it has read.
    let shared = &*ev.core.types.name_of(&iterator) == "itertools._tee";
    if shared {
        (source, block, at) = parts(&iterator);
    }
    let mut branches = Vec::with_capacity(count);
    if shared && count > 0 {
        branches.push(iterator);
    }
    while branches.len() < count {
        branches.push(branch(ev, source.clone(), block.clone(), at)?);
    }
    Ok(Value::tuple(branches))
}

/// Places in the list `groupby` shares with its groups.
const SOURCE: usize = 0;
const KEY: usize = 1;
const TARGET: usize = 2;
const CURRENT_KEY: usize = 3;
const CURRENT: usize = 4;

fn set_item(list: &Rc<List>, index: usize, value: Value) {
    drop(list.replace(index, value));
}

/// Reads the next value and its key; whether there is one.
fn advance(ev: &Evaluator<'_>, shared: &Rc<List>) -> R<bool> {
    let at = |index| shared.get(index).unwrap_or_default();
    let source = at(SOURCE);
    if source.is_unbound() {
        return Ok(false);
    }
    let Some(value) = ev.next(&source)? else {
        return Ok(false);
    };
    let key = match at(KEY) {
        Value::None => value.clone(),
        function => ev.call1(&function, value.clone())?,
    };
    set_item(shared, CURRENT, value);
    set_item(shared, CURRENT_KEY, key);
    Ok(true)
}

/// Groups neighbours with equal keys, step for step like CPython's itertoolsmodule.c.
fn groupby(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let key = args[1].if_given().cloned().unwrap_or(Value::None);
    let none = Value::default;
    let shared = Value::list(vec![ev.iter(&args[0])?, key, none(), none(), none()]);
    if let Value::List(shared) = &shared {
        note(ev, shared);
    }
    let group = Rc::new(Cell::new(0u64));
    lazy(ev, "itertools.groupby", vec![shared], group, |ev, own| {
        let Value::List(shared) = own.get(0) else {
            return Ok(None);
        };
        own.state.set(own.state.get() + 1);
        loop {
            let at = |index| shared.get(index).unwrap_or_default();
            let (current, target) = (at(CURRENT_KEY), at(TARGET));
            if !current.is_unbound() && (target.is_unbound() || !ev.equal(&target, &current)?) {
                break;
            }
            if !advance(ev, &shared)? {
                return Ok(None);
            }
            ev.safepoint()?;
        }
        let key = shared.get(CURRENT_KEY).unwrap_or_default();
        set_item(&shared, TARGET, key.clone());
        let state = (own.state.clone(), own.state.get());
        let held = vec![Value::List(shared), key.clone()];
        let members = lazy(ev, "itertools._grouper", held, state, grouper_next)?;
        Ok(Some(Value::tuple(vec![key, members])))
    })
}

fn grouper_next(ev: &Evaluator<'_>, own: &IterState<(Rc<Cell<u64>>, u64)>) -> R<Option<Value>> {
    let Value::List(shared) = own.get(0) else {
        return Ok(None);
    };
    let (current, number) = &own.state;
    if current.get() != *number {
        return Ok(None);
    }
    let at = |index| shared.get(index).unwrap_or_default();
    if at(CURRENT).is_unbound() && !advance(ev, &shared)? {
        return Ok(None);
    }
    if !ev.equal(&own.get(1), &at(CURRENT_KEY))? {
        return Ok(None);
    }
    let value = at(CURRENT);
    set_item(&shared, CURRENT, Value::Unbound);
    set_item(&shared, CURRENT_KEY, Value::Unbound);
    Ok(Some(value))
}
