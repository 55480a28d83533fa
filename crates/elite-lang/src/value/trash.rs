//! Taking containers apart without deep recursion: a list in a list in a list … of any depth is dropped with a
//! bounded native stack.

use std::cell::{Cell, RefCell};

use super::Value;

/// Levels that are dropped by plain recursion; deeper ones are put aside and dropped one after the other.
const DEPTH_MAX: u32 = 32;

thread_local! {
    static DEPTH: Cell<u32> = const { Cell::new(0) };
    static DEFERRED: RefCell<Vec<Value>> = const { RefCell::new(Vec::new()) };
}

/// Whether dropping a value may drop others.
#[inline]
fn nests(value: &Value) -> bool {
    !matches!(
        value,
        Value::Unbound
            | Value::None
            | Value::Ellipsis
            | Value::NotImplemented
            | Value::Bool(_)
            | Value::Int(_)
            | Value::Float(_)
            | Value::BigInt(_)
            | Value::Complex(_)
            | Value::Str(_)
            | Value::Bytes(_)
            | Value::ByteArray(_)
    )
}

/// Drops the values a container held. Values that hold no others are left to be dropped where they are.
#[inline]
pub fn dismantle(values: &mut Vec<Value>) {
    if values.iter().any(nests) {
        let values = Cell::new(std::mem::take(values));
        dismantle_with(
            || drop(values.take()),
            |deferred| deferred.append(&mut values.take()),
        );
    }
}

/// The same for values that are part of the object itself.
#[inline]
pub fn dismantle_all(values: &mut [Value]) {
    if values.iter().any(nests) {
        let values = Cell::new(values);
        dismantle_with(
            || {
                values
                    .take()
                    .iter_mut()
                    .for_each(|value| drop(std::mem::take(value)))
            },
            |deferred| deferred.extend(values.take().iter_mut().map(std::mem::take)),
        );
    }
}

/// Drops the single value a container held.
#[inline]
pub fn dismantle_one(value: &mut Value) {
    if nests(value) {
        let value = Cell::new(std::mem::take(value));
        dismantle_with(
            || drop(value.take()),
            |deferred| deferred.push(value.take()),
        );
    }
}

/// Drops the parts of a container: `now` drops them in place, `later` hands them over to be dropped when the native
/// stack is shallow again.
pub fn dismantle_with(now: impl FnOnce(), later: impl FnOnce(&mut Vec<Value>)) {
    let depth = DEPTH.with(Cell::get);
    if depth >= DEPTH_MAX {
        // At the very end of an OS thread the store may be gone already; then recursion is all that is left.
        let _ = DEFERRED.try_with(|deferred| later(&mut deferred.borrow_mut()));
        return;
    }
    DEPTH.with(|cell| cell.set(depth + 1));
    now();
    if depth == 0 {
        while let Some(value) = DEFERRED
            .try_with(|deferred| deferred.borrow_mut().pop())
            .ok()
            .flatten()
        {
            drop(value);
        }
    }
    DEPTH.with(|cell| cell.set(depth));
}
