//! Sets and frozen sets.
//!
//! The table is CPython's (Objects/setobject.c, 3.11): same probing, same growth, so that sets of numbers are
//! iterated in the order Python users see. Equality that needs script code is handled as in `dict`.

use std::cell::Cell;

use super::dict::{KeySearch, REHASH_CHUNK, ScanResult};
use super::{ScriptCell, Value};
use crate::limits::deferred_drop;
use crate::limits::value_vec::DropItem;
use crate::ops::hash::{Equality, quick_equal};

const SIZE_MIN: usize = 8;
const LINEAR_PROBES: usize = 9;
const PERTURB_SHIFT: u32 = 5;
/// A set. Frozen sets are the same behind another tag.
pub struct Set {
    table: ScriptCell<SetTable>,
    /// The interpreter knows it as a possible part of a cycle.
    pub noted: Cell<bool>,
    /// A search for cycles has found it in use.
    pub old: Cell<bool>,
}

/// A place of the table. One without a key is free, or its element has been deleted: then it says so in the place of
/// the hash.
#[derive(Clone, Default)]
struct SetSlot {
    hash: u64,
    key: Value,
}

impl DropItem for SetSlot {
    fn may_run_script(&self) -> bool {
        self.key.may_run_script()
    }

    #[inline(always)]
    fn is_immediate(&self) -> bool {
        self.key.is_immediate()
    }

    #[inline(always)]
    fn drop_fast(self) {
        self.key.drop_inline();
    }
}

/// What stands for the hash where an element has been deleted.
const DELETED: u64 = 1;

impl SetSlot {
    #[inline]
    fn is_used(&self) -> bool {
        !self.key.is_unbound()
    }

    #[inline]
    fn is_free(&self) -> bool {
        self.key.is_unbound() && self.hash != DELETED
    }
}

struct SetTable {
    slots: Vec<SetSlot>,
    used: usize,
    /// Used and deleted slots.
    filled: usize,
    generation: u64,
    /// Where the next `pop` begins to look.
    pop_hint: usize,
}

impl Default for Set {
    fn default() -> Self {
        Set {
            table: ScriptCell::new(SetTable::with_size(SIZE_MIN)),
            noted: Cell::new(false),
            old: Cell::new(false),
        }
    }
}

impl SetTable {
    fn with_size(size: usize) -> Self {
        SetTable {
            slots: vec![SetSlot::default(); size],
            used: 0,
            filled: 0,
            generation: 0,
            pop_hint: 0,
        }
    }

    /// Slots in the order in which CPython probes for `hash`.
    fn probe(&self, hash: u64, mut visit: impl FnMut(usize, &SetSlot) -> bool) {
        let mask = self.slots.len() - 1;
        let mut perturb = hash;
        let mut at = hash as usize & mask;
        loop {
            let probes = if at + LINEAR_PROBES <= mask {
                LINEAR_PROBES
            } else {
                0
            };
            for index in at..=at + probes {
                if visit(index, &self.slots[index]) {
                    return;
                }
            }
            perturb >>= PERTURB_SHIFT;
            at = (at
                .wrapping_mul(5)
                .wrapping_add(1)
                .wrapping_add(perturb as usize))
                & mask;
        }
    }

    #[inline]
    fn find(&self, hash: u64, key: &Value) -> KeySearch {
        // Most often the first slot says it.
        let first = hash as usize & (self.slots.len() - 1);
        match self.slots.get(first) {
            Some(slot) if slot.is_free() => return KeySearch::Nowhere,
            Some(slot) if slot.hash == hash && quick_equal(&slot.key, key) == Equality::Yes => {
                return KeySearch::At(first);
            }
            _ => {}
        }
        self.find_further(hash, key)
    }

    #[inline(never)]
    fn find_further(&self, hash: u64, key: &Value) -> KeySearch {
        let mut found = None;
        // Only what lies on the way of the hash is looked at, whoever has to compare it.
        let mut asked = Vec::new();
        self.probe(hash, |index, slot| match slot.is_used() {
            false => slot.is_free(),
            true if slot.hash == hash => match quick_equal(&slot.key, key) {
                Equality::Yes => {
                    found = Some(index);
                    true
                }
                Equality::No => false,
                Equality::Ask => {
                    asked.push((index, slot.key.clone()));
                    false
                }
            },
            true => false,
        });
        match found {
            Some(index) => KeySearch::At(index),
            None if asked.is_empty() => KeySearch::Nowhere,
            None => KeySearch::Ask(asked, self.generation),
        }
    }

    fn insert_clean(&mut self, hash: u64, key: Value) {
        let first = hash as usize & (self.slots.len() - 1);
        if let Some(slot) = self.slots.get_mut(first)
            && slot.is_free()
        {
            *slot = SetSlot { hash, key };
            self.used += 1;
            self.filled += 1;
            return;
        }
        let mut free = None;
        self.probe(hash, |index, slot| {
            if slot.is_free() {
                free = Some(index);
            }
            slot.is_free()
        });
        if let Some(index) = free {
            self.slots[index] = SetSlot { hash, key };
            self.used += 1;
            self.filled += 1;
        }
    }

    fn append(&mut self, hash: u64, key: Value) {
        self.insert_clean(hash, key);
        self.generation += 1;
        if self.filled * 5 >= (self.slots.len() - 1) * 3 {
            let wanted = if self.used > 50_000 {
                self.used * 2
            } else {
                self.used * 4
            };
            self.resize(wanted);
        }
    }

    fn delete(&mut self, index: usize) -> Value {
        let slot = &mut self.slots[index];
        slot.hash = DELETED;
        let key = std::mem::take(&mut slot.key);
        self.used -= 1;
        self.generation += 1;
        key
    }

    /// Whether `more` elements make it grow.
    fn is_full_with(&self, more: usize) -> bool {
        (self.filled + more) * 5 >= (self.slots.len() - 1) * 3
    }

    fn resize(&mut self, wanted: usize) {
        let old = std::mem::replace(self, SetTable::with_size(size_above(wanted)));
        self.generation = old.generation;
        self.pop_hint = old.pop_hint;
        for slot in old.slots {
            if slot.is_used() {
                self.insert_clean(slot.hash, slot.key);
            }
        }
    }
}

/// The smallest power of two above `wanted`, as CPython's `set_table_resize`.
fn size_above(wanted: usize) -> usize {
    let mut size = SIZE_MIN;
    while size <= wanted {
        size *= 2;
    }
    size
}

impl Set {
    /// An empty set.
    pub fn new() -> Self {
        Set::default()
    }

    /// Number of elements.
    pub fn len(&self) -> usize {
        self.table.borrow().used
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Searches an element with its hash.
    pub fn find(&self, hash: u64, key: &Value) -> KeySearch {
        self.table.borrow().find(hash, key)
    }

    /// Changes whenever elements come or go.
    pub fn generation(&self) -> u64 {
        self.table.borrow().generation
    }

    /// Whether the slot at an index from `find` has this very element, also if others have come or gone meanwhile.
    pub fn is_key_at(&self, index: usize, key: &Value) -> bool {
        let table = self.table.borrow();
        table
            .slots
            .get(index)
            .is_some_and(|slot| slot.is_used() && slot.key.is(key))
    }

    /// Adds an element that is known not to be there.
    pub fn append(&self, hash: u64, key: Value) {
        self.table.with_mut(|table| table.append(hash, key));
    }

    /// Bytes of its table.
    pub fn bytes(&self) -> usize {
        self.table.borrow().slots.capacity() * size_of::<SetSlot>()
    }

    /// Bytes its table grows by for `more` new elements; 0 if they fit as it is.
    #[inline]
    pub fn growth(&self, more: usize) -> usize {
        let table = self.table.borrow();
        if (table.filled + more) * 5 < (table.slots.len() - 1) * 3 {
            return 0;
        }
        let wanted = (table.used + more).saturating_mul(if table.used > 50_000 { 2 } else { 4 });
        let slots = wanted.saturating_mul(2).min(1 << 50);
        slots.saturating_mul(size_of::<SetSlot>())
    }

    /// Removes the element at an index from `find`.
    pub fn delete_at(&self, index: usize) -> Value {
        self.table.with_mut(|table| table.delete(index))
    }

    /// Takes an element out: the next one behind that of the last call.
    pub fn pop(&self) -> ScanResult<Value> {
        self.table.with_mut(|table| {
            if table.used == 0 {
                return ScanResult::End;
            }
            let mask = table.slots.len() - 1;
            for _ in 0..REHASH_CHUNK {
                let at = table.pop_hint & mask;
                table.pop_hint = at + 1;
                if table.slots[at].is_used() {
                    return ScanResult::Found(table.delete(at));
                }
            }
            ScanResult::Continue(table.pop_hint)
        })
    }

    /// The first element at position `from` or later, with the position after it and its hash.
    pub fn next_element(&self, from: usize) -> ScanResult<(usize, u64, Value)> {
        let table = self.table.borrow();
        let end = table.slots.len().min(from.saturating_add(REHASH_CHUNK));
        let some = table.slots.get(from..end).unwrap_or_default();
        match some.iter().position(SetSlot::is_used) {
            Some(offset) => {
                let (at, slot) = (from + offset, &some[offset]);
                ScanResult::Found((at + 1, slot.hash, slot.key.clone()))
            }
            None if end < table.slots.len() => ScanResult::Continue(end),
            None => ScanResult::End,
        }
    }

    /// Makes room for the elements of another set, as CPython does before it merges one in (`set_merge`).
    pub fn reserve(&self, more: usize) {
        self.table.with_mut(|table| {
            if table.is_full_with(more) {
                table.resize((table.used + more) * 2);
            }
        });
    }

    /// Takes over the elements of `other`.
    pub fn replace(&self, other: Set) {
        let table = other.table.replace(SetTable::with_size(SIZE_MIN));
        let generation = self.generation() + 1;
        let old = self.table.replace(SetTable {
            generation,
            ..table
        });
        drop(old);
    }

    /// Runs `each` on the elements in up to `count` slots of the table from `from` on, unless they are being changed;
    /// whether there are more.
    pub fn visit(&self, from: usize, count: usize, each: &mut dyn FnMut(&Value)) -> bool {
        let Some(table) = self.table.try_borrow() else {
            return false;
        };
        for slot in table.slots.iter().skip(from).take(count) {
            if slot.is_used() {
                each(&slot.key);
            }
        }
        table.slots.len() > from + count
    }

    /// All elements with their hashes, in table order. For sets that are small or nobody else's.
    pub fn elements(&self) -> Vec<(u64, Value)> {
        let mut elements = Vec::new();
        self.elements_from(0, usize::MAX, &mut elements);
        elements
    }

    /// Appends what is in up to `count` places of the table from `from` on; the place after them, None at the end.
    pub fn elements_from(
        &self,
        from: usize,
        count: usize,
        out: &mut Vec<(u64, Value)>,
    ) -> Option<usize> {
        let table = self.table.borrow();
        let end = from.saturating_add(count).min(table.slots.len());
        let used = table.slots.get(from..end)?.iter();
        let used = used.filter(|slot| slot.is_used());
        out.extend(used.map(|slot| (slot.hash, slot.key.clone())));
        (end < table.slots.len()).then_some(end)
    }

    /// Removes everything.
    pub fn clear(&self) {
        let old = self.table.with_mut(|table| {
            let generation = table.generation + 1;
            let empty = SetTable {
                generation,
                ..SetTable::with_size(SIZE_MIN)
            };
            std::mem::replace(table, empty)
        });
        let mut slots = old.slots;
        deferred_drop::defer_if_large(&mut slots, SetSlot::may_run_script);
        drop(slots);
    }

    /// A copy, in the order in which CPython would have it: elements are inserted into a fresh table.
    pub fn copy(&self) -> Set {
        let used = self.len();
        let size = if used * 5 >= (SIZE_MIN - 1) * 3 {
            size_above(used * 2)
        } else {
            SIZE_MIN
        };
        let table = self.table.borrow();
        let mut new = SetTable::with_size(size);
        if size == table.slots.len() && table.filled == table.used {
            new.slots.clone_from(&table.slots);
            (new.used, new.filled) = (table.used, table.filled);
        } else {
            for slot in table.slots.iter().filter(|slot| slot.is_used()) {
                new.insert_clean(slot.hash, slot.key.clone());
            }
        }
        let copy = Set::new();
        copy.table.put(new);
        copy
    }
}

impl Drop for Set {
    fn drop(&mut self) {
        let mut slots = std::mem::take(&mut self.table.get_mut().slots);
        deferred_drop::defer_if_large(&mut slots, SetSlot::may_run_script);
        let cell = Cell::new(slots);
        deferred_drop::drop_with_depth(
            || drop(cell.take()),
            |deferred| deferred.extend(cell.take().into_iter().map(|slot| slot.key)),
        );
    }
}
