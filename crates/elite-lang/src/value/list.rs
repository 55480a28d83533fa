//! Lists and tuples.

use std::cell::Cell;

use super::held::ScriptRef;
use super::{ScriptCell, Value};
use crate::limits::deferred_drop;
use crate::ops::item::place_of;

/// A list. Nothing may hold a borrow of the items while it runs script code.
#[derive(Default)]
pub struct List {
    items: ScriptCell<Vec<Value>>,
    /// Counts changes, for who makes a new content beside the old one.
    changes: Cell<u32>,
    /// The interpreter knows it as a possible part of a cycle.
    pub gc_tracked: Cell<bool>,
    /// A search for cycles has found it in use.
    pub gc_old: Cell<bool>,
}

impl List {
    /// A list of these items.
    pub fn new(items: Vec<Value>) -> Self {
        List {
            items: ScriptCell::new(items),
            changes: Cell::new(0),
            gc_tracked: Cell::new(false),
            gc_old: Cell::new(false),
        }
    }

    /// Runs `each` on up to `count` items from `from` on, unless they are being changed; whether there are more.
    pub fn visit(&self, from: usize, count: usize, each: &mut dyn FnMut(&Value)) -> bool {
        let Some(items) = self.items.try_borrow() else {
            return false;
        };
        items.iter().skip(from).take(count).for_each(each);
        items.len() > from + count
    }

    /// The items, to read.
    #[inline]
    pub fn borrow(&self) -> ScriptRef<'_, Vec<Value>> {
        self.items.borrow()
    }

    /// Changes the items; gives back what `change` has taken out, to be dropped now that the list is free again.
    #[inline(always)]
    pub fn change<O>(&self, change: impl FnOnce(&mut Vec<Value>) -> O) -> O {
        self.count_change();
        self.items.with_mut(change)
    }

    #[inline(always)]
    fn count_change(&self) {
        self.changes.set(self.changes.get().wrapping_add(1));
    }

    /// Puts other items in the place of all there were, which are given back.
    #[must_use = "the old items are dropped only now"]
    pub fn replace_all(&self, items: Vec<Value>) -> Vec<Value> {
        self.count_change();
        self.items.replace(items)
    }

    /// Puts an item in the place of number `index`: the one that was there, or, if there is none, the new one back.
    #[inline(always)]
    pub fn replace(&self, index: usize, value: Value) -> Result<Value, Value> {
        self.count_change();
        self.items.with_mut(|items| match items.get_mut(index) {
            Some(place) => Ok(std::mem::replace(place, value)),
            None => Err(value),
        })
    }

    /// Puts an item in the place that an index means, which counts from the end if it is negative: the one that was
    /// there, or, if there is none, the new one back.
    #[inline(always)]
    pub fn replace_at(&self, index: i64, value: Value) -> Result<Value, Value> {
        self.count_change();
        self.items.with_mut(|items| {
            match place_of(index, items.len()).and_then(|place| items.get_mut(place)) {
                Some(place) => Ok(std::mem::replace(place, value)),
                None => Err(value),
            }
        })
    }

    /// The items, without keeping count of the look.
    ///
    /// # Safety
    /// The caller promises what `ScriptCell::get_unguarded` asks.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub(crate) unsafe fn glimpse(&self) -> &[Value] {
        // SAFETY: the caller's promise.
        unsafe { self.items.get_unguarded() }.map_or(&[], Vec::as_slice)
    }

    /// Number of items.
    #[inline]
    pub fn len(&self) -> usize {
        // SAFETY: only the length is read.
        #[allow(unsafe_code)]
        unsafe { self.glimpse() }.len()
    }

    /// Whether there are no items.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Item `index`.
    #[inline]
    pub fn get(&self, index: usize) -> Option<Value> {
        // SAFETY: an item is copied, which counts a reference and does nothing else.
        #[allow(unsafe_code)]
        unsafe { self.glimpse() }.get(index).cloned()
    }

    /// The item that an index means, which counts from the end if it is negative.
    #[inline(always)]
    pub fn at(&self, index: i64) -> Option<Value> {
        // SAFETY: an item is copied, which counts a reference and does nothing else.
        #[allow(unsafe_code)]
        let items = unsafe { self.glimpse() };
        items.get(place_of(index, items.len())?).cloned()
    }

    /// Appends an item if there is room for it; whether there was.
    #[inline(always)]
    pub fn push_within(&self, value: Value) -> bool {
        self.count_change();
        let left = self
            .items
            .with_mut(|items| match items.len() < items.capacity() {
                true => {
                    items.push(value);
                    None
                }
                false => Some(value),
            });
        left.is_none()
    }

    /// Appends an item.
    #[inline]
    pub fn push(&self, value: Value) {
        self.count_change();
        self.items.with_mut(|items| items.push(value));
    }
}

impl Drop for List {
    fn drop(&mut self) {
        deferred_drop::drop_values(self.items.get_mut());
    }
}

/// A tuple. Two or three items, the commonest numbers, are kept in the object itself.
pub struct Tuple {
    items: TupleItems,
    /// A search for cycles has found it in use.
    pub old: Cell<bool>,
    /// 0: not known, or not the same for ever because items have hashes of the script's making.
    hash: Cell<u64>,
}

enum TupleItems {
    Two([Value; 2]),
    Three([Value; 3]),
    Many(Vec<Value>),
}

impl Tuple {
    /// The item that an index means, which counts from the end if it is negative.
    #[inline(always)]
    pub fn at(&self, index: i64) -> Option<Value> {
        let items = self.items();
        items.get(place_of(index, items.len())?).cloned()
    }

    /// A tuple of these items.
    pub fn new(items: Vec<Value>) -> Self {
        Tuple::of(TupleItems::Many(items))
    }

    /// A tuple of two items.
    #[inline]
    pub fn of_two(items: [Value; 2]) -> Self {
        Tuple::of(TupleItems::Two(items))
    }

    /// A tuple of three items.
    #[inline]
    pub fn of_three(items: [Value; 3]) -> Self {
        Tuple::of(TupleItems::Three(items))
    }

    #[inline]
    fn of(items: TupleItems) -> Self {
        Tuple {
            items,
            old: Cell::new(false),
            hash: Cell::new(0),
        }
    }

    /// The hash, if it has been noted.
    pub fn known_hash(&self) -> Option<u64> {
        Some(self.hash.get()).filter(|hash| *hash != 0)
    }

    /// Notes the hash, which no code of the script has a part in.
    pub fn note_hash(&self, hash: u64) {
        self.hash.set(hash);
    }

    /// The items.
    #[inline]
    pub fn items(&self) -> &[Value] {
        match &self.items {
            TupleItems::Two(items) => items,
            TupleItems::Three(items) => items,
            TupleItems::Many(items) => items,
        }
    }
}

impl Drop for Tuple {
    fn drop(&mut self) {
        match &mut self.items {
            TupleItems::Two(items) => deferred_drop::drop_slice(items),
            TupleItems::Three(items) => deferred_drop::drop_slice(items),
            TupleItems::Many(items) => deferred_drop::drop_values(items),
        }
    }
}
