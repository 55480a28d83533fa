//! Sets and frozen sets.
//!
//! The table is CPython's (Objects/setobject.c, 3.11): same probing, same growth, so that sets of numbers are
//! iterated in the order Python users see. Equality that needs script code is handled as in `dict`.

use std::cell::{Cell, RefCell};

use super::dict::Found;
use super::{Value, trash};
use crate::ops::hash::{Equal, quick_equal};

const SIZE_MIN: usize = 8;
const LINEAR_PROBES: usize = 9;
const PERTURB_SHIFT: u32 = 5;

/// A set. Frozen sets are the same behind another tag.
pub struct Set {
    table: RefCell<Table>,
    /// The interpreter knows it as a possible part of a cycle.
    pub noted: Cell<bool>,
    /// A search for cycles has found it in use.
    pub old: Cell<bool>,
}

#[derive(Clone, Default)]
struct Slot {
    state: SlotState,
    hash: u64,
    key: Value,
}

#[derive(Clone, Copy, Default, PartialEq, Eq)]
enum SlotState {
    #[default]
    Free,
    Used,
    Deleted,
}

#[derive(Clone)]
struct Table {
    slots: Vec<Slot>,
    used: usize,
    /// Used and deleted slots.
    filled: usize,
    generation: u64,
    /// Where the next `pop` begins to look.
    finger: usize,
}

impl Default for Set {
    fn default() -> Self {
        Set {
            table: RefCell::new(Table::with_size(SIZE_MIN)),
            noted: Cell::new(false),
            old: Cell::new(false),
        }
    }
}

impl Table {
    fn with_size(size: usize) -> Self {
        Table {
            slots: vec![Slot::default(); size],
            used: 0,
            filled: 0,
            generation: 0,
            finger: 0,
        }
    }

    /// Slots in the order in which CPython probes for `hash`.
    fn probe(&self, hash: u64, mut visit: impl FnMut(usize, &Slot) -> bool) {
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

    fn find(&self, hash: u64, key: &Value) -> Found {
        let mut found = Found::Nowhere;
        let mut ask = false;
        self.probe(hash, |index, slot| match slot.state {
            SlotState::Free => true,
            SlotState::Used if slot.hash == hash => match quick_equal(&slot.key, key) {
                Equal::Yes => {
                    found = Found::At(index);
                    true
                }
                Equal::No => false,
                Equal::Ask => {
                    ask = true;
                    false
                }
            },
            _ => false,
        });
        if !ask || matches!(found, Found::At(_)) {
            return found;
        }
        let used = self.slots.iter().enumerate();
        let same = used.filter(|(_, slot)| slot.state == SlotState::Used && slot.hash == hash);
        Found::Ask(
            same.map(|(index, slot)| (index, slot.key.clone()))
                .collect(),
            self.generation,
        )
    }

    fn insert_clean(&mut self, hash: u64, key: Value) {
        let mut free = None;
        self.probe(hash, |index, slot| {
            let is_free = slot.state == SlotState::Free;
            if is_free {
                free = Some(index);
            }
            is_free
        });
        if let Some(index) = free {
            self.slots[index] = Slot {
                state: SlotState::Used,
                hash,
                key,
            };
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

    /// The smallest power of two above `wanted`, as CPython's `set_table_resize`.
    fn resize(&mut self, wanted: usize) {
        let mut size = SIZE_MIN;
        while size <= wanted {
            size *= 2;
        }
        let old = std::mem::replace(self, Table::with_size(size));
        self.generation = old.generation;
        self.finger = old.finger;
        for slot in old.slots {
            if slot.state == SlotState::Used {
                self.insert_clean(slot.hash, slot.key);
            }
        }
    }
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
    pub fn find(&self, hash: u64, key: &Value) -> Found {
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
            .is_some_and(|slot| slot.state == SlotState::Used && slot.key.is(key))
    }

    /// Adds an element that is known not to be there.
    pub fn append(&self, hash: u64, key: Value) {
        self.table.borrow_mut().append(hash, key);
    }

    /// Bytes of its table.
    pub fn bytes(&self) -> usize {
        self.table.borrow().slots.capacity() * size_of::<Slot>()
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
        slots.saturating_mul(size_of::<Slot>())
    }

    /// Removes the element at an index from `find`.
    pub fn delete_at(&self, index: usize) -> Value {
        let mut table = self.table.borrow_mut();
        let slot = &mut table.slots[index];
        slot.state = SlotState::Deleted;
        let key = std::mem::take(&mut slot.key);
        table.used -= 1;
        table.generation += 1;
        key
    }

    /// Takes an element out: the next one behind that of the last call.
    pub fn pop(&self) -> Option<Value> {
        let mut table = self.table.borrow_mut();
        if table.used == 0 {
            return None;
        }
        let mask = table.slots.len() - 1;
        let mut at = table.finger & mask;
        while table.slots[at].state != SlotState::Used {
            at = (at + 1) & mask;
        }
        table.finger = at + 1;
        drop(table);
        Some(self.delete_at(at))
    }

    /// The first element at position `from` or later, with the position after it and its hash.
    pub fn next_element(&self, from: usize) -> Option<(usize, u64, Value)> {
        let table = self.table.borrow();
        let offset = table
            .slots
            .get(from..)?
            .iter()
            .position(|slot| slot.state == SlotState::Used)?;
        let slot = &table.slots[from + offset];
        Some((from + offset + 1, slot.hash, slot.key.clone()))
    }

    /// Makes room for the elements of another set, as CPython does before it merges one in (`set_merge`).
    pub fn reserve(&self, more: usize) {
        let mut table = self.table.borrow_mut();
        if (table.filled + more) * 5 >= (table.slots.len() - 1) * 3 {
            let wanted = (table.used + more) * 2;
            table.resize(wanted);
        }
    }

    /// Takes over the elements of `other`.
    pub fn replace(&self, other: Set) {
        let table = other.table.replace(Table::with_size(SIZE_MIN));
        let generation = self.generation() + 1;
        let old = self.table.replace(Table {
            generation,
            ..table
        });
        drop(old);
    }

    /// Runs `each` on the elements in up to `count` slots of the table from `from` on, unless they are being changed;
    /// whether there are more.
    pub fn visit(&self, from: usize, count: usize, each: &mut dyn FnMut(&Value)) -> bool {
        let Ok(table) = self.table.try_borrow() else {
            return false;
        };
        for slot in table.slots.iter().skip(from).take(count) {
            if slot.state == SlotState::Used {
                each(&slot.key);
            }
        }
        table.slots.len() > from + count
    }

    /// All elements with their hashes, in table order.
    pub fn elements(&self) -> Vec<(u64, Value)> {
        let table = self.table.borrow();
        let used = table
            .slots
            .iter()
            .filter(|slot| slot.state == SlotState::Used);
        used.map(|slot| (slot.hash, slot.key.clone())).collect()
    }

    /// Removes everything.
    pub fn clear(&self) {
        let old = {
            let mut table = self.table.borrow_mut();
            let generation = table.generation + 1;
            std::mem::replace(
                &mut *table,
                Table {
                    generation,
                    ..Table::with_size(SIZE_MIN)
                },
            )
        };
        drop(old);
    }

    /// A copy, in the order in which CPython would have it: elements are inserted into a fresh table.
    pub fn copy(&self) -> Set {
        let copy = Set::new();
        {
            let table = self.table.borrow();
            let mut new = copy.table.borrow_mut();
            if (new.filled + table.used) * 5 >= (new.slots.len() - 1) * 3 {
                new.resize(table.used * 2);
            }
            let same_size = new.slots.len() == table.slots.len() && table.filled == table.used;
            if same_size {
                *new = table.clone();
            } else {
                let used = table
                    .slots
                    .iter()
                    .filter(|slot| slot.state == SlotState::Used);
                used.for_each(|slot| new.insert_clean(slot.hash, slot.key.clone()));
            }
        }
        copy
    }
}

impl Drop for Set {
    fn drop(&mut self) {
        let slots = std::mem::take(&mut self.table.get_mut().slots);
        let cell = Cell::new(slots);
        trash::dismantle_with(
            || drop(cell.take()),
            |deferred| deferred.extend(cell.take().into_iter().map(|slot| slot.key)),
        );
    }
}
