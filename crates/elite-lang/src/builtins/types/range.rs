//! `range` and `slice`.

use std::cell::RefCell;
use std::rc::Rc;

use num_bigint::{BigInt, Sign};

use super::{constructor, methods, wrong_receiver};
use crate::eval::{Evaluator, InterpreterState};
use crate::value::int::Int;
use crate::value::iter::{LibraryIterator, NativeIter};
use crate::value::{Iter, LongRange, R, Range, Slice, Value};

pub(super) fn install(core: &Rc<InterpreterState>) {
    let types = &core.types;
    constructor(core, &types.range, "start stop? step? /", range);
    constructor(core, &types.slice, "start stop? step? /", slice);
    methods(
        core,
        &types.range,
        &[("count", "value /", count), ("index", "value /", index)],
    );
    methods(core, &types.slice, &[("indices", "length /", indices)]);
}

fn range(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let first = ev.to_int(&args[0])?;
    let (start, stop) = match args[1].if_given() {
        Some(stop) => (first, ev.to_int(stop)?),
        None => (Int::Small(0), first),
    };
    let step = match args[2].if_given() {
        Some(step) => ev.to_int(step)?,
        None => Int::Small(1),
    };
    if step.is_zero() {
        return Err(ev.value_error("range() arg 3 must not be zero"));
    }
    if let (Int::Small(start), Int::Small(stop), Int::Small(step)) = (&start, &stop, &step) {
        let (start, stop, step) = (*start, *stop, *step);
        if let Some(range) = Range::new(start, stop, step) {
            return Ok(Value::Range(Rc::new(range)));
        }
    }
    Ok(Value::range(start.to_big(), stop.to_big(), step.to_big()))
}

/// Counts through a range whose numbers may leave 64 bits.
#[derive(Clone)]
struct LongRangeIterator {
    next: RefCell<BigInt>,
    step: BigInt,
    left: RefCell<BigInt>,
}

impl LibraryIterator for LongRangeIterator {
    fn visit(&self, _: &mut dyn FnMut(&Value)) {}

    fn clear(&self, _: &mut Vec<Value>) {}

    fn copy_with(
        &self,
        _: &Evaluator<'_>,
        _: &dyn Fn(&Value) -> R,
    ) -> R<Option<Box<dyn LibraryIterator>>> {
        Ok(Some(Box::new(self.clone())))
    }

    fn next(&self, _: &Evaluator<'_>) -> R<Option<Value>> {
        let mut left = self.left.borrow_mut();
        if *left == BigInt::ZERO {
            return Ok(None);
        }
        *left -= 1;
        let mut next = self.next.borrow_mut();
        let following = &*next + &self.step;
        Ok(Some(Value::bigint(std::mem::replace(
            &mut *next, following,
        ))))
    }
}

/// An iterator over a range whose numbers may leave 64 bits.
pub fn long_range_iterator(ev: &Evaluator<'_>, range: &LongRange) -> Iter {
    Iter::Native(NativeIter::new(
        ev.core.types.longrange_iterator.clone(),
        LongRangeIterator {
            next: RefCell::new(range.start.clone()),
            step: range.step.clone(),
            left: RefCell::new(range.len().clone()),
        },
    ))
}

fn position(range: &Value, int: &Int) -> Option<BigInt> {
    match (range, int) {
        (Value::Range(range), Int::Small(value)) => range.position(*value).map(BigInt::from),
        (Value::LongRange(range), value) => range.position(&value.to_big()),
        _ => None,
    }
}

fn count(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    if let Some(int) = Int::of(&args[1]) {
        return Ok(Value::Int(i64::from(position(&args[0], &int).is_some())));
    }
    let (items, mut count) = (ev.iter(&args[0])?, 0);
    while let Some(item) = ev.next_at_safepoint(&items)? {
        count += i64::from(ev.equal(&item, &args[1])?);
    }
    Ok(Value::Int(count))
}

fn index(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    if let Some(int) = Int::of(&args[1]) {
        return match position(&args[0], &int) {
            Some(position) => Ok(Value::bigint(position)),
            None => Err(ev.value_error(format!("{} is not in range", ev.repr(&args[1])?))),
        };
    }
    let (items, mut index) = (ev.iter(&args[0])?, 0);
    while let Some(item) = ev.next_at_safepoint(&items)? {
        if ev.equal(&item, &args[1])? {
            return Ok(Value::Int(index));
        }
        index += 1;
    }
    Err(ev.value_error("sequence.index(x): x not in sequence"))
}

fn slice(_: &Evaluator<'_>, args: &mut [Value]) -> R {
    let given = |value: &Value| value.if_given().cloned().unwrap_or(Value::None);
    let slice = match args[1].if_given() {
        Some(stop) => Slice {
            start: args[0].clone(),
            stop: stop.clone(),
            step: given(&args[2]),
        },
        None => Slice {
            start: Value::None,
            stop: args[0].clone(),
            step: Value::None,
        },
    };
    Ok(Value::Slice(Rc::new(slice)))
}

fn indices(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let Value::Slice(slice) = &args[0] else {
        return Err(wrong_receiver(ev, "slice", &args[0]));
    };
    let length = ev.to_int(&args[1])?;
    if length.is_negative() {
        return Err(ev.value_error("length should not be negative"));
    }
    let length = length.to_big();
    let part = |value: &Value| -> R<Option<BigInt>> {
        match value {
            Value::None => Ok(None),
            value if ev.has_index(value) => ev.to_int(value).map(|int| Some(int.to_big())),
            _ => {
                let text = "slice indices must be integers or None or have an __index__ method";
                Err(ev.type_error(text))
            }
        }
    };
    let step = part(&slice.step)?.unwrap_or_else(|| BigInt::from(1));
    let is_back = match step.sign() {
        Sign::NoSign => return Err(ev.value_error("slice step cannot be zero")),
        sign => sign == Sign::Minus,
    };
    let (lowest, highest) = match is_back {
        true => (BigInt::from(-1), &length - 1),
        false => (BigInt::from(0), length.clone()),
    };
    let place = |given: Option<BigInt>, default: &BigInt| match given {
        None => default.clone(),
        Some(index) if index.sign() == Sign::Minus => (index + &length).max(lowest.clone()),
        Some(index) => index.min(highest.clone()),
    };
    let (first, last) = match is_back {
        true => (&highest, &lowest),
        false => (&lowest, &highest),
    };
    let start = place(part(&slice.start)?, first);
    let stop = place(part(&slice.stop)?, last);
    Ok(Value::tuple(
        [start, stop, step].map(Value::bigint).to_vec(),
    ))
}
