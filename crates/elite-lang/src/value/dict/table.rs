//! The table of a dictionary: entries in the order of their insertion, and slots that lead to them by hash.
//!
//! Owns how an entry is found, added, deleted and moved, and when there is more or less room. Runs no script code; who
//! holds the table, and for how long, is the dictionary's business.

use std::cell::Cell;

use super::variables::VariableIndex;
use crate::limits::deferred_drop;
use crate::limits::value_vec::DropItem;
use crate::ops::hash::{Equality, quick_equal};
use crate::value::Value;

/// A slot that leads nowhere.
pub(super) const EMPTY: u32 = u32::MAX;
/// Up to this many entries are scanned instead of hashed into a table.
pub(super) const SCAN_MAX: usize = 8;

/// From so many entries on a table that is scanned gets room for two more at a time.
const GROWS_BY_TWO: usize = 4;
/// A table with room for more entries than this gives room back when most of them have been deleted.
const SHRINK_MIN: usize = 1 << 14;

/// A key and its value, with the key's hash.
#[derive(Clone, Default)]
pub struct Entry {
    pub(super) hash: u64,
    /// `Unbound` if the entry has been deleted.
    pub(super) key: Value,
    pub(super) value: Value,
}

#[derive(Default)]
pub(super) struct DictTable {
    pub(super) entries: Vec<Entry>,
    /// Open addressing into `entries`; empty while the entries are few. A power of two, at most 2/3 full.
    pub(super) slots: Vec<u32>,
    pub(super) live: usize,
    /// Changes whenever keys come or go.
    pub(super) generation: u64,
    /// All entries before this one are deleted, as far as is known.
    pub(super) head: Cell<usize>,
    /// All entries from this one on are deleted, as far as is known.
    pub(super) tail: Cell<usize>,
    /// Slots that were taken by entries which moved, beyond one for each entry.
    pub(super) moves: usize,
    /// If code refers to its values: those that it has asked for lie in variables; an unbound one is no entry.
    pub(super) variables: Option<Box<VariableIndex>>,
}

impl DropItem for Entry {
    fn may_run_script(&self) -> bool {
        self.key.may_run_script() || self.value.may_run_script()
    }

    #[inline(always)]
    fn is_immediate(&self) -> bool {
        self.key.is_immediate() && self.value.is_immediate()
    }

    #[inline(always)]
    fn drop_fast(self) {
        self.key.drop_inline();
        self.value.drop_inline();
    }
}

impl Entry {
    /// The value of the entry; None if it is deleted, or a variable that is not bound.
    pub(super) fn read(&self, of_variables: bool) -> Option<Value> {
        match &self.value {
            Value::Cell(variable) if of_variables => {
                Some(variable.value.get()).filter(|value| !value.is_unbound())
            }
            value => (!self.key.is_unbound()).then(|| value.clone()),
        }
    }

    /// Whether there is none.
    pub(super) fn is_absent(&self, of_variables: bool) -> bool {
        match &self.value {
            Value::Cell(variable) if of_variables => variable.value.borrow().is_unbound(),
            _ => self.key.is_unbound(),
        }
    }
}

/// What a search for a key found.
pub enum KeySearch {
    /// The entry's index.
    At(usize),
    /// No such key.
    Nowhere,
    /// The search needs script code to compare: the entries with the same hash, and the generation they belong to.
    Ask(Vec<(usize, Value)>, u64),
}

/// Script code has to say whether two keys are equal.
pub(super) struct NeedsScript;

pub(super) fn mix_hash(hash: u64) -> usize {
    // The tables are indexed by the low bits; Python hashes of numbers need mixing first, of all their bits: those of
    // `i << 45` or of `i / 1024` differ in the upper ones only.
    let product = u128::from(hash) * 0x9E37_79B9_7F4A_7C15;
    ((product as u64 ^ (product >> 64) as u64) >> 32) as usize
}

/// Enters an entry's index in a table of slots with room for it.
pub(super) fn place(slots: &mut [u32], hash: u64, index: u32) {
    let mask = slots.len() - 1;
    let mut at = mix_hash(hash) & mask;
    while slots[at] != EMPTY {
        at = (at + 1) & mask;
    }
    slots[at] = index;
}

/// Slots for so many entries.
pub(super) fn slots_for(entries: usize) -> usize {
    (entries * 3).next_power_of_two()
}

impl DictTable {
    /// Whether code may refer to its values.
    #[inline(always)]
    pub(super) fn of_variables(&self) -> bool {
        self.variables.is_some()
    }

    pub(super) fn find(&self, hash: u64, key: &Value) -> KeySearch {
        match self.find_at_once(hash, key) {
            Ok(Some(index)) => KeySearch::At(index),
            Ok(None) => KeySearch::Nowhere,
            Err(NeedsScript) => self.find_slow(hash, key),
        }
    }

    /// The entry of a key, unless script code has to compare some.
    #[inline]
    pub(super) fn find_at_once(
        &self,
        hash: u64,
        key: &Value,
    ) -> Result<Option<usize>, NeedsScript> {
        let is_at = |index: usize| match self.entries.get(index) {
            Some(entry) if entry.hash == hash => quick_equal(&entry.key, key),
            _ => Equality::No,
        };
        if self.slots.is_empty() {
            for index in 0..self.entries.len() {
                match is_at(index) {
                    Equality::Yes => return Ok(Some(index)),
                    Equality::No => {}
                    Equality::Ask => return Err(NeedsScript),
                }
            }
            return Ok(None);
        }
        let mask = self.slots.len() - 1;
        let mut at = mix_hash(hash) & mask;
        while self.slots[at] != EMPTY {
            let index = self.slots[at] as usize;
            match is_at(index) {
                Equality::Yes => return Ok(Some(index)),
                Equality::No => at = (at + 1) & mask,
                Equality::Ask => return Err(NeedsScript),
            }
        }
        Ok(None)
    }

    #[cold]
    #[inline(never)]
    fn find_slow(&self, hash: u64, key: &Value) -> KeySearch {
        // Only what lies on the way of the hash is looked at, whoever has to compare it.
        let mut asked = Vec::new();
        let mut look = |index: usize| {
            let entry = &self.entries[index];
            if entry.hash != hash {
                return false;
            }
            match quick_equal(&entry.key, key) {
                Equality::Yes => return true,
                Equality::No => {}
                Equality::Ask if self.is_absent(entry) => {}
                Equality::Ask => asked.push((index, entry.key.clone())),
            }
            false
        };
        if self.slots.is_empty() {
            if let Some(index) = (0..self.entries.len()).find(|index| look(*index)) {
                return KeySearch::At(index);
            }
        } else {
            let mask = self.slots.len() - 1;
            let mut at = mix_hash(hash) & mask;
            while self.slots[at] != EMPTY {
                let index = self.slots[at] as usize;
                if look(index) {
                    return KeySearch::At(index);
                }
                at = (at + 1) & mask;
            }
        }
        match asked.is_empty() {
            true => KeySearch::Nowhere,
            false => KeySearch::Ask(asked, self.generation),
        }
    }

    /// Whether an entry has been deleted.
    #[inline]
    pub(super) fn is_absent(&self, entry: &Entry) -> bool {
        entry.is_absent(self.of_variables())
    }

    /// Whether `more` entries fit as it is.
    #[inline]
    pub(super) fn has_room_for(&self, more: usize) -> bool {
        let needed = self.entries.len() + more;
        let is_placed = needed <= SCAN_MAX || needed * 3 <= self.slots.len() * 2;
        is_placed && needed <= self.entries.capacity()
    }

    /// Room for so many entries in a table that has none, if they are few.
    pub(super) fn make_room(&mut self, entries: usize) {
        self.entries.reserve_exact(entries.min(SCAN_MAX));
    }

    pub(super) fn append(&mut self, hash: u64, key: Value, value: Value) {
        match self.of_variables() {
            true => self.append_variable(hash, key, value),
            false => self.push(hash, key, value),
        }
    }

    pub(super) fn push(&mut self, hash: u64, key: Value, value: Value) {
        let index = self.entries.len();
        if index == self.entries.capacity() && self.live < index / 2 {
            self.compact();
        }
        if index == self.entries.capacity() && (GROWS_BY_TWO..SCAN_MAX).contains(&index) {
            // Most dictionaries are small and stay so: no room for eight where five are wanted.
            self.entries.reserve_exact(2);
        }
        self.entries.push(Entry { hash, key, value });
        self.tail.set(self.entries.len());
        self.live += 1;
        self.generation += 1;
        if self.slots.is_empty() {
            if self.entries.len() > SCAN_MAX {
                self.rebuild();
            }
        } else if self.entries.len() * 3 > self.slots.len() * 2 {
            self.compact();
        } else {
            let index = self.entries.len() - 1;
            self.place(hash, index as u32);
        }
    }

    pub(super) fn place(&mut self, hash: u64, index: u32) {
        place(&mut self.slots, hash, index);
    }

    #[cold]
    pub(super) fn growth_to(&self, needed: usize) -> usize {
        let mut bytes = 0;
        if needed > self.entries.capacity() {
            let entries = needed.max(self.entries.capacity().saturating_mul(2));
            bytes += (entries - self.entries.capacity()).saturating_mul(size_of::<Entry>());
        }
        if needed > SCAN_MAX && needed.saturating_mul(3) > self.slots.len().saturating_mul(2) {
            let slots = needed.saturating_mul(4);
            bytes = bytes.saturating_add(slots.saturating_mul(size_of::<u32>()));
        }
        bytes
    }

    /// Throws deleted entries away and builds the slots anew.
    pub(super) fn compact(&mut self) {
        self.remove_deleted();
        if self.entries.capacity() > SHRINK_MIN.max(4 * self.entries.len()) {
            self.entries.shrink_to(2 * self.entries.len());
            self.slots = Vec::new();
        }
        self.rebuild();
    }

    /// Whether so many entries have been deleted that the others are better moved together.
    pub(super) fn is_sparse(&self) -> bool {
        self.live < self.entries.len() / 4
    }

    /// Throws deleted entries away.
    pub(super) fn remove_deleted(&mut self) {
        if self.live < self.entries.len() {
            self.entries.retain(|entry| !entry.key.is_unbound());
        }
        self.head.set(0);
        self.tail.set(self.entries.len());
    }

    pub(super) fn rebuild(&mut self) {
        self.slots.clear();
        if self.entries.len() <= SCAN_MAX {
            return;
        }
        let size = slots_for(self.entries.len());
        self.slots.resize(size, EMPTY);
        self.moves = 0;
        for (entry, index) in self.entries.iter().zip(0..) {
            if !entry.key.is_unbound() {
                place(&mut self.slots, entry.hash, index);
            }
        }
    }

    /// Moves the entry at an index to the front. Room there is made for as many entries as there are, so that doing
    /// this again and again takes no longer than adding keys does.
    pub(super) fn move_to_front(&mut self, mut index: usize) {
        let head = self.head.get();
        let first = self.entries[head..]
            .iter()
            .position(|e| !e.key.is_unbound());
        let mut first = head + first.unwrap_or(0);
        if index == first {
            return;
        }
        if first == 0 {
            let room = self.live.max(SCAN_MAX);
            // There is as much room at the end, or the next key that is added throws the room at the front away again.
            let mut entries = Vec::with_capacity(2 * room + self.live);
            entries.resize(room, Entry::default());
            for (at, entry) in std::mem::take(&mut self.entries).into_iter().enumerate() {
                if at == index {
                    index = entries.len();
                }
                if !entry.key.is_unbound() {
                    entries.push(entry);
                }
            }
            (self.entries, first) = (entries, room);
            self.tail.set(self.entries.len());
            self.rebuild();
        }
        let entry = std::mem::take(&mut self.entries[index]);
        let hash = entry.hash;
        first -= 1;
        self.entries[first] = entry;
        self.head.set(first);
        self.generation += 1;
        self.moves += 1;
        if self.moves > self.slots.len() / 8 {
            self.rebuild();
        } else {
            self.place(hash, first as u32);
        }
    }

    pub(super) fn delete(&mut self, index: usize) -> (Value, Value) {
        let entry = &mut self.entries[index];
        let removed = (
            std::mem::take(&mut entry.key),
            std::mem::take(&mut entry.value),
        );
        self.live -= 1;
        self.generation += 1;
        if self.live == 0 {
            // The entries hold nothing any more.
            deferred_drop::defer_if_large(&mut self.entries, |_| false);
            self.entries.clear();
            self.slots.clear();
            self.remove_deleted();
        } else if self.slots.is_empty() {
            self.remove_deleted();
        } else if self.is_sparse() {
            self.compact();
        }
        removed
    }
}
