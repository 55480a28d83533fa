//! Taking containers apart without deep recursion: a list in a list in a list … of any depth is dropped with a
//! bounded native stack.
//!
//! Owns the one queue that takes what is too deep to be dropped where it lies. Every struct that keeps a value hands
//! its parts to it in `drop` (`drop_each`); `owns_values` names the kinds, without a wildcard, so that a new kind of
//! value cannot be forgotten. Dropping may run script code (the `finally` blocks of generators), so nothing may be
//! borrowed meanwhile.

use std::cell::{Cell, RefCell};

use elite_syntax::work_on_tree;

use crate::limits::value_vec::DropItem;
use crate::value::Value;

/// Levels that are dropped by plain recursion; deeper ones are put aside and dropped one after the other. So few that
/// they fit what a native keeps free of its stack.
const DROP_DEPTH_MAX: u32 = 16;

/// In the place of a depth: nothing is taken apart any more.
const LEFT: u32 = u32::MAX;

/// What containers of this thread hold is left where it is from now on, for ever: it may be half changed.
pub fn leave_all() {
    DEPTH.with(|depth| depth.set(LEFT));
    let _ = QUEUE.try_with(|queue| {
        queue
            .try_borrow_mut()
            .map(|mut queue| std::mem::forget(std::mem::take(&mut *queue)))
    });
    let _ = TOO_DEEP.try_with(|deferred| {
        deferred
            .try_borrow_mut()
            .map(|mut deferred| std::mem::forget(std::mem::take(&mut *deferred)))
    });
}

thread_local! {
    static DEPTH: Cell<u32> = const { Cell::new(0) };
    static TOO_DEEP: RefCell<Vec<Value>> = const { RefCell::new(Vec::new()) };
}

/// Whether dropping a value may drop others. Every kind named here has a `drop` that hands its parts over, directly or
/// through the one struct it consists of.
#[inline]
fn owns_values(value: &Value) -> bool {
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
        | Value::StaticMethod(_)
        | Value::ClassMethod(_)
        | Value::Super(_)
        | Value::Cell(_)
        // Consists of variables, and of constants.
        | Value::Code(_) => true,
    }
}

/// With so many parts it does not matter any more whether they tell: they are left to be dropped.
const DEFER_ALWAYS_MIN: usize = 32 << 10;
/// From so many parts on a container is dropped in portions.
const DEFER_MIN: usize = 16 << 10;
/// Containers with fewer parts are dropped where they are, always.
const DEFER_NEVER_BELOW: usize = 64;
/// Parts that are dropped at once.
const PORTION: usize = if cfg!(debug_assertions) {
    4 << 10
} else {
    16 << 10
};
/// Bytes that they give back at once: parts may be classes, or texts.
const PORTION_BYTES: isize = if cfg!(debug_assertions) {
    256 << 10
} else {
    1 << 20
};

thread_local! {
    static DEFERRING: Cell<bool> = const { Cell::new(false) };
    static QUEUE: RefCell<Vec<Box<dyn DeferredDrop>>> = const { RefCell::new(Vec::new()) };
    /// Parts that have been dropped since the last portion was begun: a few thousand containers of a few thousand parts
    /// each are millions, none of which is in a big one.
    static DROPPED_ITEMS: Cell<usize> = const { Cell::new(0) };
}

/// Counts parts that are dropped; how many there are since the last portion was begun.
fn count_dropped(parts: usize) -> usize {
    let done = DROPPED_ITEMS.try_with(|done| {
        done.set(done.get().saturating_add(parts));
        done.get()
    });
    done.unwrap_or(0)
}

/// Parts of a container that is gone.
trait DeferredDrop {
    /// Drops some of them and counts them; whether there are more.
    fn drop_some(&mut self) -> bool;
}

/// Bytes that were taken up by parts that are gone, and go back at once.
const SHRINK_MIN_BYTES: usize = 4 << 20;

struct DeferredItems<T>(Vec<T>);

impl<T: DropItem> DeferredDrop for DeferredItems<T> {
    fn drop_some(&mut self) -> bool {
        let taken = task_memory::allocated_bytes();
        let mut others = 0_usize;
        loop {
            // Parts that hold no others are dropped together.
            let among = self.0.len().saturating_sub(DEFER_NEVER_BELOW);
            let last = self.0[among..].iter().rev();
            let plain = last.take_while(|part| part.is_immediate()).count();
            let first = self.0.len() - plain;
            self.0.drain(first..).for_each(DropItem::drop_fast);
            if count_dropped(plain) >= PORTION {
                break;
            }
            if plain > 0 {
                continue;
            }
            let Some(part) = self.0.pop() else {
                break;
            };
            // A container of many has counted its parts itself.
            part.drop_fast();
            if count_dropped(1) >= PORTION {
                break;
            }
            others += 1;
            if others.is_multiple_of(DEFER_NEVER_BELOW)
                && taken - task_memory::allocated_bytes() >= PORTION_BYTES
            {
                count_dropped(PORTION);
                break;
            }
        }
        let left = self.0.len();
        // Room goes back bit by bit, too: the system takes many milliseconds for hundreds of megabytes at once.
        if (self.0.capacity() - left) * size_of::<T>() > SHRINK_MIN_BYTES {
            self.0.shrink_to(left);
        }
        !self.0.is_empty()
    }
}

/// From now on (or no longer, `false`) the parts of big containers are dropped bit by bit, by `run_deferred_drops`. A
/// container of millions of values takes many milliseconds otherwise, in which nobody else has a turn.
pub fn set_deferring(on: bool) -> bool {
    task_memory::set_unmap_deferred(on);
    DEFERRING.with(|deferring| deferring.replace(on))
}

/// Leaves the parts of a container to be dropped bit by bit, if they are many, or many have been dropped just now, and
/// nobody could tell the difference: `may_run_script` says which of them may end a generator, whose `finally` block
/// must run at once (with very many parts it has to wait, too).
pub fn defer_if_large<T: DropItem>(parts: &mut Vec<T>, may_run_script: impl Fn(&T) -> bool) {
    if !DEFERRING.with(Cell::get) {
        return;
    }
    let done = count_dropped(parts.len());
    if parts.len() >= DEFER_NEVER_BELOW
        && (parts.len() >= DEFER_MIN || done > PORTION)
        && (done >= DEFER_ALWAYS_MIN || !parts.iter().any(may_run_script))
    {
        enqueue(DeferredItems(std::mem::take(parts)));
    }
}

impl<T> DeferredDrop for std::vec::IntoIter<T> {
    fn drop_some(&mut self) -> bool {
        count_dropped(PORTION);
        self.take(PORTION).for_each(drop);
        self.len() > 0
    }
}

/// Leaves the parts that a native has not taken to be dropped bit by bit, if there are many.
pub fn defer_rest_if_large<T: 'static>(
    rest: std::vec::IntoIter<T>,
    may_run_script: impl Fn(&T) -> bool,
) {
    let parts = rest.as_slice();
    let are_left = parts.len() >= DEFER_MIN
        && DEFERRING.with(Cell::get)
        && (parts.len() >= DEFER_ALWAYS_MIN || !parts.iter().any(may_run_script));
    if are_left {
        enqueue(rest);
    }
}

fn enqueue(rest: impl DeferredDrop + 'static) {
    // At the very end of an OS thread the store may be gone already; then they are dropped here.
    let _ = QUEUE.try_with(|queue| queue.borrow_mut().push(Box::new(rest)));
}

/// Nodes of code, many of which are dropped bit by bit. They hold constants only, so nobody can tell the difference.
pub struct NodeList<T: 'static>(Box<[T]>);

/// Bytes of nodes that are dropped at once. Each node may have others below it, in lists of their own, so that their
/// number says nothing; their bytes say how many blocks are given back.
const NODES: isize = if cfg!(debug_assertions) {
    16 << 10
} else {
    256 << 10
};

thread_local! {
    /// What nodes have given back since the last portion.
    static FREED_NODE_BYTES: Cell<isize> = const { Cell::new(0) };
}

/// Drops nodes, last ones first, while the portion lasts.
fn drop_nodes<T>(nodes: &mut Vec<T>) {
    let mut taken = task_memory::allocated_bytes();
    let mut given_back = FREED_NODE_BYTES.with(Cell::get);
    while given_back < NODES
        && let Some(node) = nodes.pop()
    {
        drop(node);
        let now = task_memory::allocated_bytes();
        given_back += NODE + (taken - now).max(0);
        taken = now;
        // Nodes below this one have noted a part of that.
        FREED_NODE_BYTES.with(|cell| cell.set(given_back));
    }
}

/// What a node counts that gives nothing back.
const NODE: isize = 16;

struct DeferredNodes<T>(Vec<T>);

impl<T> DeferredDrop for DeferredNodes<T> {
    fn drop_some(&mut self) -> bool {
        // The stack here may be any, also a shallow one.
        work_on_tree(|| drop_nodes(&mut self.0));
        !self.0.is_empty()
    }
}

/// Drops nodes, or leaves those that are too many to be dropped bit by bit.
pub fn drop_or_defer_nodes<T: 'static>(nodes: &mut Vec<T>) {
    if nodes.is_empty() || !DEFERRING.with(Cell::get) {
        return;
    }
    drop_nodes(nodes);
    if !nodes.is_empty() {
        enqueue(DeferredNodes(std::mem::take(nodes)));
    }
}

impl<T: 'static> FromIterator<T> for NodeList<T> {
    fn from_iter<I: IntoIterator<Item = T>>(nodes: I) -> Self {
        NodeList(nodes.into_iter().collect())
    }
}

impl<T: 'static> From<Vec<T>> for NodeList<T> {
    fn from(nodes: Vec<T>) -> Self {
        NodeList(nodes.into())
    }
}

impl<T: 'static> Default for NodeList<T> {
    fn default() -> Self {
        NodeList(Box::default())
    }
}

impl<T: 'static> std::ops::Deref for NodeList<T> {
    type Target = [T];

    #[inline(always)]
    fn deref(&self) -> &[T] {
        &self.0
    }
}

impl<'n, T: 'static> IntoIterator for &'n NodeList<T> {
    type Item = &'n T;
    type IntoIter = std::slice::Iter<'n, T>;

    #[inline(always)]
    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl<T: 'static> Drop for NodeList<T> {
    #[inline]
    fn drop(&mut self) {
        if !self.0.is_empty() {
            drop_or_defer_nodes(&mut std::mem::take(&mut self.0).into_vec());
        }
    }
}

/// Whether dropping a value, or what a container holds directly, may run code of the script. What is deeper in a
/// container of many containers may have to wait.
pub fn may_run_script(value: &Value) -> bool {
    owns_values(value)
        && !matches!(
            value,
            Value::List(_)
                | Value::Tuple(_)
                | Value::Dict(_)
                | Value::Set(_)
                | Value::FrozenSet(_)
                | Value::Slice(_)
        )
}

/// Drops some of what has been left; whether there is more.
pub fn run_deferred_drops() -> bool {
    let more = drop_portion();
    // Both are to be done.
    task_memory::unmap_deferred() | more
}

fn drop_portion() -> bool {
    let _ = FREED_NODE_BYTES.try_with(|given_back| given_back.set(0));
    let _ = DROPPED_DEEP.try_with(|dropped| dropped.set(0));
    let _ = DROPPED_ITEMS.try_with(|done| done.set(0));
    loop {
        let taken = QUEUE.try_with(|queue| queue.borrow_mut().pop());
        let Ok(Some(mut rest)) = taken else {
            return false;
        };
        if rest.drop_some() {
            QUEUE.with(|queue| queue.borrow_mut().push(rest));
        }
        if FREED_NODE_BYTES.with(Cell::get) >= NODES || count_dropped(1) >= PORTION {
            return QUEUE.with(|queue| !queue.borrow().is_empty());
        }
    }
}

/// Drops several single values a struct held, one after the other.
#[inline]
pub fn drop_each<'v>(parts: impl IntoIterator<Item = &'v mut Value>) {
    parts.into_iter().for_each(drop_value);
}

/// Drops the values a container held. Values that hold no others are left to be dropped where they are.
#[inline]
pub fn drop_values(values: &mut Vec<Value>) {
    if values.len() >= DEFER_NEVER_BELOW {
        defer_if_large(values, may_run_script);
    }
    if values.iter().any(owns_values) {
        let values = Cell::new(std::mem::take(values));
        drop_with_depth(
            || drop_all(values.take()),
            |deferred| deferred.append(&mut values.take()),
        );
    } else if values.len() >= DEFER_NEVER_BELOW {
        // Most of many are numbers, or have others who refer to them.
        values.drain(..).for_each(Value::drop_inline);
    }
}

/// Drops values, and leaves the rest of them once they have come to many with all they hold. So what lay side by side
/// goes side by side, and the system gets it back in few pieces.
fn drop_all(mut values: Vec<Value>) {
    if values.len() < DEFER_NEVER_BELOW
        || !DEFERRING.with(Cell::get)
        || values.iter().any(may_run_script)
    {
        return;
    }
    while let Some(value) = values.pop() {
        drop(value);
        if count_dropped(0) >= PORTION && !values.is_empty() {
            return enqueue(DeferredItems(values));
        }
    }
}

/// Drops values that are part of an object itself. Values that hold no others are left to be dropped where they are.
#[inline]
pub fn drop_slice(values: &mut [Value]) {
    if values.iter().any(owns_values) {
        let values = Cell::new(values);
        drop_with_depth(
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
pub fn drop_value(value: &mut Value) {
    if owns_values(value) {
        let value = Cell::new(std::mem::take(value));
        drop_with_depth(
            || drop(value.take()),
            |deferred| deferred.push(value.take()),
        );
    }
}

/// Drops the parts of a container: `now` drops them in place, `later` hands them over to be dropped when the native
/// stack is shallow again.
pub fn drop_with_depth(now: impl FnOnce(), later: impl FnOnce(&mut Vec<Value>)) {
    crate::value::held::assert_no_borrows();
    let depth = DEPTH.with(Cell::get);
    if depth >= DROP_DEPTH_MAX {
        if depth == LEFT {
            let mut left = Vec::new();
            later(&mut left);
            return std::mem::forget(left);
        }
        // At the very end of an OS thread the store may be gone already; then recursion is all that is left.
        let _ = TOO_DEEP.try_with(|deferred| later(&mut deferred.borrow_mut()));
        return;
    }
    let _level = DropDepthGuard::enter(depth);
    now();
    if depth == 0 {
        drop_deferred();
    }
}

thread_local! {
    /// Values that were too deep and have been dropped since the last portion.
    static DROPPED_DEEP: Cell<usize> = const { Cell::new(0) };
}

/// Drops what was too deep. A chain may have millions of links, each of which hands over the next one: what does not
/// fit into a portion is left to be dropped bit by bit.
fn drop_deferred() {
    loop {
        let is_enough = DEFERRING.with(Cell::get) && DROPPED_DEEP.with(Cell::get) >= PORTION;
        if is_enough {
            let rest = TOO_DEEP.try_with(|deferred| std::mem::take(&mut *deferred.borrow_mut()));
            if let Ok(rest) = rest
                && !rest.is_empty()
            {
                enqueue(DeferredItems(rest));
            }
            return;
        }
        let Ok(Some(value)) = TOO_DEEP.try_with(|deferred| deferred.borrow_mut().pop()) else {
            return;
        };
        // Each takes as many others with it, as deep as they may be dropped.
        let _ =
            DROPPED_DEEP.try_with(|dropped| dropped.set(dropped.get() + DROP_DEPTH_MAX as usize));
        count_dropped(DROP_DEPTH_MAX as usize);
        drop(value);
    }
}

/// One level of dropping, left when it goes out of scope.
struct DropDepthGuard(u32);

impl DropDepthGuard {
    #[inline]
    fn enter(depth: u32) -> Self {
        DEPTH.with(|cell| cell.set(depth + 1));
        DropDepthGuard(depth)
    }
}

impl Drop for DropDepthGuard {
    #[inline]
    fn drop(&mut self) {
        DEPTH.with(|cell| cell.set(self.0));
    }
}
