//! Taking containers apart without deep recursion: a list in a list in a list … of any depth is dropped with a
//! bounded native stack.
//!
//! Owns the one queue that takes what is too deep to be dropped where it lies. Every struct that keeps a value hands its
//! parts to it in `drop` (`hand_over`); `nests` names the kinds, without a wildcard, so that a new kind of value cannot be
//! forgotten. Dropping may run script code (the `finally` blocks of generators), so nothing may be borrowed meanwhile.

use std::cell::{Cell, RefCell};

use super::Value;

/// Levels that are dropped by plain recursion; deeper ones are put aside and dropped one after the other. So few that
/// they fit what a native keeps free of its stack.
const DEPTH_MAX: u32 = 16;

thread_local! {
    static DEPTH: Cell<u32> = const { Cell::new(0) };
    static DEFERRED: RefCell<Vec<Value>> = const { RefCell::new(Vec::new()) };
}

/// Whether dropping a value may drop others. Every kind named here has a `drop` that hands its parts over, directly or
/// through the one struct it consists of.
#[inline]
fn nests(value: &Value) -> bool {
    match value {
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
        | Value::Range(_)
        | Value::LongRange(_) => false,
        Value::List(_)
        | Value::Tuple(_)
        | Value::Dict(_)
        // Consists of a dictionary.
        | Value::DictView(_)
        | Value::Set(_)
        | Value::FrozenSet(_)
        | Value::Slice(_)
        | Value::Function(_)
        | Value::BoundMethod(_)
        | Value::Builtin(_)
        | Value::Class(_)
        | Value::Instance(_)
        // Consists of variables.
        | Value::Module(_)
        | Value::Iter(_)
        | Value::Generator(_)
        | Value::Property(_)
        // What they wrap is never one of them again (`builtins::types::function`).
        | Value::StaticMethod(_)
        | Value::ClassMethod(_)
        | Value::Super(_)
        | Value::Cell(_) => true,
    }
}

/// Drops several single values a struct held, one after the other.
#[inline]
pub fn hand_over<'v>(parts: impl IntoIterator<Item = &'v mut Value>) {
    parts.into_iter().for_each(dismantle_one);
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
    super::held::nothing_is_open();
    let depth = DEPTH.with(Cell::get);
    if depth >= DEPTH_MAX {
        // At the very end of an OS thread the store may be gone already; then recursion is all that is left.
        let _ = DEFERRED.try_with(|deferred| later(&mut deferred.borrow_mut()));
        return;
    }
    let _level = Level::enter(depth);
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
}

/// One level of dropping, left when it goes out of scope.
struct Level(u32);

impl Level {
    #[inline]
    fn enter(depth: u32) -> Self {
        DEPTH.with(|cell| cell.set(depth + 1));
        Level(depth)
    }
}

impl Drop for Level {
    #[inline]
    fn drop(&mut self) {
        DEPTH.with(|cell| cell.set(self.0));
    }
}
