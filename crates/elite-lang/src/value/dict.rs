//! Dictionaries: insertion-ordered hash tables.
//!
//! Keys whose equality needs script code (instances with `__eq__`) cannot be compared here: the table then names the
//! candidates and `ops::dict` asks the script, with no borrow held.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use super::{Value, trash};
use crate::ops::hash::{Equal, quick_equal};

const EMPTY: u32 = u32::MAX;
/// Up to this many entries are scanned instead of hashed into a table.
const SCAN_MAX: usize = 8;

/// A dictionary.
#[derive(Default)]
pub struct Dict {
    table: RefCell<Table>,
    /// The interpreter knows it as a possible part of a cycle.
    pub noted: Cell<bool>,
    /// A search for cycles has found it in use.
    pub old: Cell<bool>,
}

/// A key and its value, with the key's hash.
#[derive(Clone)]
pub struct Entry {
    hash: u64,
    /// `Unbound` if the entry has been deleted.
    key: Value,
    value: Value,
}

#[derive(Default)]
struct Table {
    entries: Vec<Entry>,
    /// Open addressing into `entries`; empty while the entries are few. A power of two, at most 2/3 full.
    slots: Vec<u32>,
    live: usize,
    /// Changes whenever keys come or go.
    generation: u64,
    /// All entries before this one are deleted, as far as is known.
    head: Cell<usize>,
    /// All entries from this one on are deleted, as far as is known.
    tail: Cell<usize>,
}

/// What a search for a key found.
pub enum Found {
    /// The entry's index.
    At(usize),
    /// No such key.
    Nowhere,
    /// The search needs script code to compare: the entries with the same hash, and the generation they belong to.
    Ask(Vec<(usize, Value)>, u64),
}

fn spread(hash: u64) -> usize {
    // The tables are indexed by the low bits; Python hashes of integers need mixing first.
    (hash.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 32) as usize
}

impl Table {
    fn find(&self, hash: u64, key: &Value) -> Found {
        let mut ask = false;
        if self.slots.is_empty() {
            for (index, entry) in self.entries.iter().enumerate() {
                if entry.hash == hash {
                    match quick_equal(&entry.key, key) {
                        Equal::Yes => return Found::At(index),
                        Equal::No => {}
                        Equal::Ask => ask = true,
                    }
                }
            }
        } else {
            let mask = self.slots.len() - 1;
            let mut at = spread(hash) & mask;
            while self.slots[at] != EMPTY {
                let index = self.slots[at] as usize;
                let entry = &self.entries[index];
                if entry.hash == hash {
                    match quick_equal(&entry.key, key) {
                        Equal::Yes => return Found::At(index),
                        Equal::No => {}
                        Equal::Ask => ask = true,
                    }
                }
                at = (at + 1) & mask;
            }
        }
        if !ask {
            return Found::Nowhere;
        }
        let same_hash = self
            .entries
            .iter()
            .enumerate()
            .filter(|(_, e)| e.hash == hash && !e.key.is_unbound());
        Found::Ask(
            same_hash
                .map(|(index, entry)| (index, entry.key.clone()))
                .collect(),
            self.generation,
        )
    }

    fn append(&mut self, hash: u64, key: Value, value: Value) {
        let index = self.entries.len();
        if index == self.entries.capacity() && self.live < index / 2 {
            self.compact();
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

    fn place(&mut self, hash: u64, index: u32) {
        let mask = self.slots.len() - 1;
        let mut at = spread(hash) & mask;
        while self.slots[at] != EMPTY {
            at = (at + 1) & mask;
        }
        self.slots[at] = index;
    }

    #[cold]
    fn growth_to(&self, needed: usize) -> usize {
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
    fn compact(&mut self) {
        self.squeeze();
        self.rebuild();
    }

    /// Throws deleted entries away.
    fn squeeze(&mut self) {
        if self.live < self.entries.len() {
            self.entries.retain(|entry| !entry.key.is_unbound());
        }
        self.head.set(0);
        self.tail.set(self.entries.len());
    }

    fn rebuild(&mut self) {
        self.slots.clear();
        if self.entries.len() <= SCAN_MAX {
            return;
        }
        let size = (self.entries.len() * 3).next_power_of_two();
        self.slots.resize(size, EMPTY);
        for index in 0..self.entries.len() {
            // Deleted entries keep their slot: searches for others pass over them.
            self.place(self.entries[index].hash, index as u32);
        }
    }

    fn delete(&mut self, index: usize) -> (Value, Value) {
        let entry = &mut self.entries[index];
        let removed = (
            std::mem::take(&mut entry.key),
            std::mem::take(&mut entry.value),
        );
        self.live -= 1;
        self.generation += 1;
        if self.live == 0 {
            self.entries.clear();
            self.slots.clear();
            self.squeeze();
        } else if self.slots.is_empty() {
            self.squeeze();
        } else if index + 1 == self.entries.len() && self.live < self.entries.len() / 4 {
            self.compact();
        }
        removed
    }
}

impl Dict {
    /// An empty dictionary.
    pub fn new() -> Self {
        Dict::default()
    }

    /// Number of keys.
    #[inline]
    pub fn len(&self) -> usize {
        self.table.borrow().live
    }

    /// Whether there are no keys.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Searches a key with its hash.
    #[inline]
    pub fn find(&self, hash: u64, key: &Value) -> Found {
        self.table.borrow().find(hash, key)
    }

    /// Changes whenever keys come or go; values may change without.
    pub fn generation(&self) -> u64 {
        self.table.borrow().generation
    }

    /// Whether the entry at an index from `find` has this very key, also if others have come or gone meanwhile.
    pub fn is_key_at(&self, index: usize, key: &Value) -> bool {
        let table = self.table.borrow();
        table
            .entries
            .get(index)
            .is_some_and(|entry| entry.key.is(key))
    }

    /// The value of the entry at an index from `find`.
    #[inline]
    pub fn value_at(&self, index: usize) -> Value {
        self.table.borrow().entries[index].value.clone()
    }

    /// Replaces the value of the entry at an index from `find`.
    #[inline]
    pub fn set_value_at(&self, index: usize, value: Value) {
        let old = std::mem::replace(&mut self.table.borrow_mut().entries[index].value, value);
        drop(old);
    }

    /// Adds a key that is known not to be there.
    pub fn append(&self, hash: u64, key: Value, value: Value) {
        self.table.borrow_mut().append(hash, key, value);
    }

    /// Bytes of its table.
    pub fn bytes(&self) -> usize {
        let table = self.table.borrow();
        table.entries.capacity() * size_of::<Entry>() + table.slots.capacity() * size_of::<u32>()
    }

    /// Bytes its table grows by for `more` new keys; 0 if they fit as it is.
    #[inline]
    pub fn growth(&self, more: usize) -> usize {
        let table = self.table.borrow();
        let needed = table.entries.len() + more;
        let scanned = needed <= SCAN_MAX || needed * 3 <= table.slots.len() * 2;
        if scanned && needed <= table.entries.capacity() {
            return 0;
        }
        table.growth_to(needed)
    }

    /// Deletes the entry at an index from `find`; returns key and value.
    pub fn delete_at(&self, index: usize) -> (Value, Value) {
        self.table.borrow_mut().delete(index)
    }

    /// The first entry at position `from` or later, and the position after it. Positions survive changes of values,
    /// not of keys.
    pub fn next_entry(&self, from: usize) -> Option<(usize, Value, Value)> {
        let table = self.table.borrow();
        let head = table.head.get();
        let mut at = from.max(head);
        loop {
            let entry = table.entries.get(at)?;
            at += 1;
            if !entry.key.is_unbound() {
                if from <= head {
                    table.head.set(at - 1);
                }
                return Some((at, entry.key.clone(), entry.value.clone()));
            }
        }
    }

    /// The last entry before position `from` and its position; `usize::MAX` starts at the end.
    pub fn previous_entry(&self, from: usize) -> Option<(usize, Value, Value)> {
        let table = self.table.borrow();
        let tail = table.tail.get();
        let end = from.min(tail);
        let at = table.entries[..end]
            .iter()
            .rposition(|entry| !entry.key.is_unbound())?;
        if end == tail {
            table.tail.set(at + 1);
        }
        let entry = &table.entries[at];
        Some((at, entry.key.clone(), entry.value.clone()))
    }

    /// All keys with their hashes and values, in order.
    pub fn entries(&self) -> Vec<(u64, Value, Value)> {
        let table = self.table.borrow();
        let live = table.entries.iter().filter(|entry| !entry.key.is_unbound());
        live.map(|entry| (entry.hash, entry.key.clone(), entry.value.clone()))
            .collect()
    }

    /// Runs `each` on keys and values of up to `count` entries from `from` on, unless they are being changed; whether there
    /// are more.
    pub fn visit(&self, from: usize, count: usize, each: &mut dyn FnMut(&Value)) -> bool {
        let Ok(table) = self.table.try_borrow() else {
            return false;
        };
        for entry in table.entries.iter().skip(from).take(count) {
            each(&entry.key);
            each(&entry.value);
        }
        table.entries.len() > from + count
    }

    /// All keys, in order.
    pub fn keys(&self) -> Vec<Value> {
        let table = self.table.borrow();
        table
            .entries
            .iter()
            .filter(|entry| !entry.key.is_unbound())
            .map(|entry| entry.key.clone())
            .collect()
    }

    /// All values, in order of their keys.
    pub fn values(&self) -> Vec<Value> {
        let table = self.table.borrow();
        table
            .entries
            .iter()
            .filter(|entry| !entry.key.is_unbound())
            .map(|entry| entry.value.clone())
            .collect()
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
                    ..Table::default()
                },
            )
        };
        drop_entries(old.entries);
    }

    /// A shallow copy.
    pub fn copy(&self) -> Dict {
        let copy = Dict::new();
        {
            let table = self.table.borrow();
            let live = table.entries.iter().filter(|entry| !entry.key.is_unbound());
            let mut new = copy.table.borrow_mut();
            new.entries = live.cloned().collect();
            new.live = new.entries.len();
            new.squeeze();
            new.rebuild();
        }
        copy
    }

    /// The value of a string key. For embedders and the library; scripts go through `ops::dict`.
    pub fn get_str(&self, key: &str) -> Option<Value> {
        let key = Value::str(key);
        let Value::Str(text) = &key else { return None };
        match self.find(text.hash(), &key) {
            Found::At(index) => Some(self.value_at(index)),
            Found::Nowhere | Found::Ask(..) => None,
        }
    }

    /// Sets a string key.
    pub fn set_str(&self, key: &str, value: Value) {
        self.set_interned(Value::str(key), value);
    }

    /// Sets a key that is a string object.
    pub fn set_interned(&self, key: Value, value: Value) {
        let Value::Str(text) = &key else { return };
        let hash = text.hash();
        match self.find(hash, &key) {
            Found::At(index) => self.set_value_at(index, value),
            Found::Nowhere | Found::Ask(..) => self.append(hash, key, value),
        }
    }
}

fn drop_entries(entries: Vec<Entry>) {
    let cell = Cell::new(entries);
    trash::dismantle_with(
        || drop(cell.take()),
        |deferred| {
            deferred.extend(
                cell.take()
                    .into_iter()
                    .flat_map(|entry| [entry.key, entry.value]),
            )
        },
    );
}

impl Drop for Dict {
    fn drop(&mut self) {
        let entries = std::mem::take(&mut self.table.get_mut().entries);
        if !entries.is_empty() {
            drop_entries(entries);
        }
    }
}

/// What `keys()`, `values()` and `items()` return.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum ViewKind {
    Keys,
    Values,
    Items,
}

/// A live view of a dictionary.
#[allow(missing_docs)]
pub struct DictView {
    pub kind: ViewKind,
    pub dict: Rc<Dict>,
}
