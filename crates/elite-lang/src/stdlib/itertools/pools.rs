//! `itertools`: what chooses from pools of values that are known in full, and `zip_longest`.

use std::cell::{Cell, RefCell};

use super::{Steps, lazy};
use crate::builtins::Args;
use crate::eval::Evaluator;
use crate::stdlib::define::Entry;
use crate::value::{R, Value, Values};

pub(super) const CLASSES: &[Entry] = &[
    ("combinations", "iterable r", |ev, args| {
        let (pool, r) = pool(ev, args)?;
        let start = (r <= pool.len()).then(|| (0..r).collect());
        choose(ev, "itertools.combinations", pool, start, |indices, n| {
            let r = indices.len();
            let place = (0..r).rev().find(|i| indices[*i] != i + n - r)?;
            indices[place] += 1;
            for j in place + 1..r {
                indices[j] = indices[j - 1] + 1;
            }
            Some(())
        })
    }),
    ("combinations_with_replacement", "iterable r", |ev, args| {
        let (pool, r) = pool(ev, args)?;
        let start = (r == 0 || !pool.is_empty()).then(|| vec![0; r]);
        let name = "itertools.combinations_with_replacement";
        choose(ev, name, pool, start, |indices, n| {
            let place = (0..indices.len()).rev().find(|i| indices[*i] != n - 1)?;
            let value = indices[place] + 1;
            indices[place..].fill(value);
            Some(())
        })
    }),
    ("permutations", "iterable r?", |ev, args| {
        let pool = ev.collect(&args[0])?;
        let r = match args[1].given() {
            None | Some(Value::None) => pool.len(),
            Some(r) => {
                if crate::value::int::Int::of(r).is_none() {
                    return Err(ev.type_error("Expected int as r"));
                }
                let r = usize::try_from(ev.index(r)?);
                r.map_err(|_| ev.value_error("r must be non-negative"))?
            }
        };
        let n = pool.len();
        let start = (r <= n).then(|| ((0..n).collect(), (n - r + 1..=n).rev().collect()));
        let state = RefCell::new(Permutation { r, start });
        lazy(
            ev,
            "itertools.permutations",
            vec![pool.into_tuple()],
            state,
            permute,
        )
    }),
];

/// The pool and the number of values to choose.
fn pool(ev: &Evaluator<'_>, args: &[Value]) -> R<(Values, usize)> {
    let pool = ev.collect(&args[0])?;
    match usize::try_from(ev.index(&args[1])?) {
        Ok(r) => Ok((pool, r)),
        Err(_) => Err(ev.value_error("r must be non-negative")),
    }
}

/// Indices of the choice that comes next, and how to get from one to the one after it.
struct Choice {
    /// None at the end.
    indices: RefCell<Option<Vec<usize>>>,
    advance: fn(&mut [usize], usize) -> Option<()>,
}

fn choose(
    ev: &Evaluator<'_>,
    name: &str,
    pool: Values,
    start: Option<Vec<usize>>,
    advance: fn(&mut [usize], usize) -> Option<()>,
) -> R {
    let indices = RefCell::new(start);
    let choice = Choice { indices, advance };
    lazy(ev, name, vec![pool.into_tuple()], choice, |_, own| {
        let Value::Tuple(pool) = own.get(0) else {
            return Ok(None);
        };
        let pool = pool.items();
        let mut state = own.state.indices.borrow_mut();
        let Some(indices) = &mut *state else {
            return Ok(None);
        };
        let chosen = indices.iter().map(|index| pool[*index].clone()).collect();
        if (own.state.advance)(indices, pool.len()).is_none() {
            *state = None;
        }
        Ok(Some(Value::tuple(chosen)))
    })
}

struct Permutation {
    r: usize,
    /// Indices and cycles as CPython's documentation has them; None at the end.
    start: Option<(Vec<usize>, Vec<usize>)>,
}

fn permute(_: &Evaluator<'_>, own: &Steps<RefCell<Permutation>>) -> R<Option<Value>> {
    let Value::Tuple(pool) = own.get(0) else {
        return Ok(None);
    };
    let mut state = own.state.borrow_mut();
    let r = state.r;
    let Some((indices, cycles)) = &mut state.start else {
        return Ok(None);
    };
    let chosen = indices[..r]
        .iter()
        .map(|index| pool.items()[*index].clone());
    let chosen = Value::tuple(chosen.collect());
    let n = indices.len();
    let mut more = false;
    for i in (0..r).rev() {
        cycles[i] -= 1;
        if cycles[i] == 0 {
            indices[i..].rotate_left(1);
            cycles[i] = n - i;
        } else {
            indices.swap(i, n - cycles[i]);
            more = true;
            break;
        }
    }
    if !more {
        state.start = None;
    }
    Ok(Some(chosen))
}

pub(super) fn product(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let mut repeat = 1;
    for (name, value) in args.keywords {
        let name = ev.core.symbols.name(*name);
        if &*name != "repeat" {
            let text = format!("'{name}' is an invalid keyword argument for product()");
            return Err(ev.type_error(text));
        }
        repeat = match usize::try_from(ev.index(value)?) {
            Ok(repeat) => repeat,
            Err(_) => return Err(ev.value_error("repeat argument cannot be negative")),
        };
    }
    let pools: R<Vec<Value>> = args
        .positional
        .iter()
        .map(|iterable| ev.collect(iterable).map(Values::into_tuple))
        .collect();
    let pools = pools?;
    let count = pools.len().saturating_mul(repeat);
    ev.check_allocation(count.saturating_mul(2 * size_of::<Value>()))?;
    let mut held = Vec::with_capacity(count);
    for _ in 0..if pools.is_empty() { 0 } else { repeat } {
        held.extend_from_slice(&pools);
    }
    let state = RefCell::new(Some(vec![0usize; held.len()]));
    lazy(ev, "itertools.product", held, state, |_, own| {
        let mut state = own.state.borrow_mut();
        let Some(indices) = &mut *state else {
            return Ok(None);
        };
        let held = own.held.get();
        let mut chosen = Vec::with_capacity(indices.len());
        for (pool, index) in held.iter().zip(&*indices) {
            match pool {
                Value::Tuple(pool) if *index < pool.items().len() => {
                    chosen.push(pool.items()[*index].clone());
                }
                // An empty pool: there is nothing to choose.
                _ => {
                    *state = None;
                    return Ok(None);
                }
            }
        }
        let mut more = false;
        for (pool, index) in held.iter().zip(indices.iter_mut()).rev() {
            let length = match pool {
                Value::Tuple(pool) => pool.items().len(),
                _ => 0,
            };
            *index += 1;
            if *index < length {
                more = true;
                break;
            }
            *index = 0;
        }
        if !more {
            *state = None;
        }
        Ok(Some(Value::tuple(chosen)))
    })
}

/// Holds its iterators, `Unbound` for those that have ended, and the filling value last.
pub(super) fn zip_longest(ev: &Evaluator<'_>, args: &mut Args<'_>) -> R {
    let mut fill = Value::None;
    for (name, value) in args.keywords {
        if &*ev.core.symbols.name(*name) != "fillvalue" {
            return Err(ev.type_error("zip_longest() got an unexpected keyword argument"));
        }
        fill = value.clone();
    }
    let held: R<Vec<Value>> = args
        .positional
        .iter()
        .map(|iterable| ev.iter(iterable))
        .collect();
    let mut held = held?;
    let left = Cell::new(held.len());
    held.push(fill);
    lazy(ev, "itertools.zip_longest", held, left, |ev, own| {
        let width = own.held.borrow().len().saturating_sub(1);
        if own.state.get() == 0 {
            return Ok(None);
        }
        let fill = own.get(width);
        let mut row = Vec::with_capacity(width);
        for place in 0..width {
            if own.get(place).is_unbound() {
                row.push(fill.clone());
                continue;
            }
            match own.step(ev, place) {
                Ok(Some(value)) => row.push(value),
                Ok(None) => {
                    own.state.set(own.state.get().saturating_sub(1));
                    if own.state.get() == 0 {
                        return Ok(None);
                    }
                    own.set(place, Value::Unbound);
                    row.push(fill.clone());
                }
                Err(raised) => {
                    own.state.set(0);
                    return Err(raised);
                }
            }
        }
        Ok(Some(Value::tuple(row)))
    })
}
