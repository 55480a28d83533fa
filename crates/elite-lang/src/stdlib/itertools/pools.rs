//! `itertools`: what chooses from pools of values that are known in full, and `zip_longest`.

use std::cell::{Cell, RefCell};
use std::ops::Range;
use std::rc::Rc;

use super::{IterState, lazy};
use crate::builtins::Args;
use crate::eval::Evaluator;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::stdlib::define::MethodDef;
use crate::value::{R, Value, ValueVec};

pub(super) const CLASSES: &[MethodDef] = &[
    ("combinations", "iterable r", |ev, args| {
        let (pool, r) = pool(ev, args)?;
        let start = match r <= pool.len() {
            true => Some(collect_numbers(ev, 0..r)?),
            false => None,
        };
        choose(
            ev,
            "itertools.combinations",
            pool,
            start,
            |ev, places, n| {
                let r = places.len();
                let Some(last) = last_of(ev, r, |at| places[at] != at + n - r)? else {
                    return Ok(false);
                };
                let value = places[last] + 1;
                change(ev, places, last..r, |at| value + at - last)?;
                Ok(true)
            },
        )
    }),
    ("combinations_with_replacement", "iterable r", |ev, args| {
        let (pool, r) = pool(ev, args)?;
        let start = match r == 0 || !pool.is_empty() {
            true => Some(collect_numbers(ev, (0..r).map(|_| 0))?),
            false => None,
        };
        let name = "itertools.combinations_with_replacement";
        choose(ev, name, pool, start, |ev, places, n| {
            let r = places.len();
            let Some(last) = last_of(ev, r, |at| places[at] != n - 1)? else {
                return Ok(false);
            };
            let value = places[last] + 1;
            change(ev, places, last..r, |_| value)?;
            Ok(true)
        })
    }),
    ("permutations", "iterable r?", |ev, args| {
        let pool = ev.collect(&args[0])?;
        let r = match args[1].if_given() {
            None | Some(Value::None) => pool.len(),
            Some(r) => {
                if crate::value::int::Int::of(&ev.unwrap_builtin(r)).is_none() {
                    return Err(ev.type_error("Expected int as r"));
                }
                let r = usize::try_from(ev.index(r)?);
                r.map_err(|_| ev.value_error("r must be non-negative"))?
            }
        };
        let n = pool.len();
        // The places, and behind them what is left of each cycle, as the documentation of CPython has them.
        let start = match r <= n {
            true => Some(collect_numbers(
                ev,
                (0..n + r).map(|at| if at < n { at } else { 2 * n - at }),
            )?),
            false => None,
        };
        let state = (r, PoolCursor::new(start));
        let held = vec![pool.into_tuple()];
        lazy(ev, "itertools.permutations", held, state, permute)
    }),
];

/// The pool and the number of values to choose.
fn pool(ev: &Evaluator<'_>, args: &[Value]) -> R<(ValueVec, usize)> {
    let r = ev.index(&args[1])?;
    let pool = ev.collect(&args[0])?;
    match usize::try_from(r) {
        Ok(r) => Ok((pool, r)),
        Err(_) => Err(ev.value_error("r must be non-negative")),
    }
}

/// Places that are gone through at once.
const INLINE_PLACES_MAX: usize = 4096;

/// Numbers, made with pauses.
fn collect_numbers(
    ev: &Evaluator<'_>,
    mut all: impl ExactSizeIterator<Item = usize>,
) -> R<Vec<usize>> {
    let mut list = ev.try_with_capacity(all.len())?;
    while all.len() > 0 {
        list.extend(all.by_ref().take(INLINE_PLACES_MAX));
        ev.charge(INLINE_PLACES_MAX.min(list.len()))?;
    }
    Ok(list)
}

/// The last number below `end` that passes a test.
fn last_of(ev: &Evaluator<'_>, end: usize, test: impl Fn(usize) -> bool) -> R<Option<usize>> {
    let mut end = end;
    while end > 0 {
        let begin = end.saturating_sub(INLINE_PLACES_MAX);
        if let Some(found) = (begin..end).rev().find(|at| test(*at)) {
            return Ok(Some(found));
        }
        ev.charge(end - begin)?;
        end = begin;
    }
    Ok(None)
}

/// Sets some of the places.
fn change(
    ev: &Evaluator<'_>,
    places: &mut [usize],
    range: Range<usize>,
    to: impl Fn(usize) -> usize,
) -> R<()> {
    for at in range.clone().step_by(INLINE_PLACES_MAX) {
        let some = at..range.end.min(at + INLINE_PLACES_MAX);
        for at in some.clone() {
            places[at] = to(at);
        }
        ev.charge(some.len())?;
    }
    Ok(())
}

/// Where an iterator over choices stands.
#[derive(Clone)]
struct PoolCursor(RefCell<PoolState>);

#[derive(Clone)]
enum PoolState {
    /// The places in the pools that come next; a copy of the iterator shares them until one of the two goes on.
    At(Rc<Vec<usize>>),
    /// The places are taken out while the iterator goes on: others may have their turn meanwhile.
    Working,
    Over,
}

impl PoolCursor {
    fn new(start: Option<Vec<usize>>) -> PoolCursor {
        PoolCursor(RefCell::new(
            start.map_or(PoolState::Over, |places| PoolState::At(Rc::new(places))),
        ))
    }

    /// The next choice, which `next` makes of the places; it says as well whether there is another one after it.
    fn go_on(
        &self,
        ev: &Evaluator<'_>,
        next: impl FnOnce(&mut Vec<usize>) -> R<(Option<Value>, bool)>,
    ) -> R<Option<Value>> {
        let places = match self.0.replace(PoolState::Working) {
            PoolState::At(places) => places,
            PoolState::Working => return Err(ev.value_error("iterator already executing")),
            PoolState::Over => {
                self.0.replace(PoolState::Over);
                return Ok(None);
            }
        };
        let gone_on = make_unique(ev, places).and_then(|mut places| {
            let (choice, more) = next(&mut places)?;
            Ok((choice, more.then(|| Rc::new(places))))
        });
        let (choice, state) = match gone_on {
            Ok((choice, Some(places))) => (Ok(choice), PoolState::At(places)),
            Ok((choice, None)) => (Ok(choice), PoolState::Over),
            Err(raised) => (Err(raised), PoolState::Over),
        };
        self.0.replace(state);
        choice
    }
}

fn make_unique(ev: &Evaluator<'_>, places: Rc<Vec<usize>>) -> R<Vec<usize>> {
    Rc::try_unwrap(places).or_else(|shared| collect_numbers(ev, shared.iter().copied()))
}

/// The values of a pool at some places.
fn pick(ev: &Evaluator<'_>, pool: &[Value], places: &[usize]) -> R {
    let mut values = ValueVec::from(ev.try_with_capacity(places.len())?);
    for some in places.chunks(INLINE_PLACES_MAX) {
        values.extend(some.iter().map(|place| pool[*place].clone()));
        ev.charge(some.len() * WORK_PER_VALUE)?;
    }
    Ok(values.into_tuple())
}

/// How to get from some places to those after them, in a pool of so many values; whether there are any.
type AdvanceFn = fn(&Evaluator<'_>, &mut [usize], usize) -> R<bool>;

fn choose(
    ev: &Evaluator<'_>,
    name: &str,
    pool: ValueVec,
    start: Option<Vec<usize>>,
    advance: AdvanceFn,
) -> R {
    let state = (advance, PoolCursor::new(start));
    lazy(ev, name, vec![pool.into_tuple()], state, |ev, own| {
        let Value::Tuple(pool) = own.get(0) else {
            return Ok(None);
        };
        let (advance, stand) = &own.state;
        stand.go_on(ev, |places| {
            let choice = pick(ev, pool.items(), places)?;
            Ok((Some(choice), advance(ev, places, pool.items().len())?))
        })
    })
}

fn permute(ev: &Evaluator<'_>, own: &IterState<(usize, PoolCursor)>) -> R<Option<Value>> {
    let Value::Tuple(pool) = own.get(0) else {
        return Ok(None);
    };
    let (r, stand) = &own.state;
    let n = pool.items().len();
    stand.go_on(ev, |both| {
        let (places, cycles) = both.split_at_mut(n);
        let choice = pick(ev, pool.items(), &places[..*r])?;
        for i in (0..*r).rev() {
            cycles[i] -= 1;
            if cycles[i] != 0 {
                places.swap(i, n - cycles[i]);
                return Ok((Some(choice), true));
            }
            to_the_end(ev, &mut places[i..])?;
            cycles[i] = n - i;
        }
        Ok((Some(choice), false))
    })
}

/// Puts the first of the places behind the others.
fn to_the_end(ev: &Evaluator<'_>, places: &mut [usize]) -> R<()> {
    for from in (0..places.len()).step_by(INLINE_PLACES_MAX) {
        // One more, which stays the first of the next ones.
        let some = from..places.len().min(from + INLINE_PLACES_MAX + 1);
        ev.charge(some.len())?;
        places[some].rotate_left(1);
    }
    Ok(())
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
    let mut pools = ValueVec::from(ev.try_with_capacity(args.positional.len())?);
    for iterable in &*args.positional {
        pools.push(ev.collect(iterable)?.into_tuple());
        ev.charge(WORK_PER_VALUE * WORK_PER_VALUE)?;
    }
    let count = pools.len().saturating_mul(repeat);
    let mut held = ValueVec::from(ev.try_with_capacity(count)?);
    for _ in 0..if pools.is_empty() { 0 } else { repeat } {
        ev.copy_values(&pools, &mut held)?;
    }
    let start = collect_numbers(ev, (0..held.len()).map(|_| 0))?;
    let state = PoolCursor::new(Some(start));
    lazy(ev, "itertools.product", held.into(), state, |ev, own| {
        own.state.go_on(ev, |places| {
            let mut choice = ValueVec::from(ev.try_with_capacity(places.len())?);
            for from in (0..places.len()).step_by(INLINE_PLACES_MAX) {
                let some = from..places.len().min(from + INLINE_PLACES_MAX);
                for at in some.clone() {
                    match own.item(at, places[at]) {
                        Some(value) => choice.push(value),
                        // An empty pool: there is nothing to choose.
                        None => return Ok((None, false)),
                    }
                }
                ev.charge(some.len() * WORK_PER_VALUE)?;
            }
            let mut at = places.len();
            while at > 0 {
                at -= 1;
                places[at] += 1;
                if places[at] < own.length(at) {
                    return Ok((Some(choice.into_tuple()), true));
                }
                places[at] = 0;
                ev.charge(WORK_PER_VALUE)?;
            }
            Ok((Some(choice.into_tuple()), false))
        })
    })
}

impl IterState<PoolCursor> {
    /// The value at a place of the pool held as number `index`.
    fn item(&self, index: usize, place: usize) -> Option<Value> {
        match self.held.borrow().get(index)? {
            Value::Tuple(pool) => pool.items().get(place).cloned(),
            _ => None,
        }
    }

    /// The length of that pool.
    fn length(&self, index: usize) -> usize {
        match self.held.borrow().get(index) {
            Some(Value::Tuple(pool)) => pool.items().len(),
            _ => 0,
        }
    }
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
