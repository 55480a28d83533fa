//! Dictionaries: insertion-ordered hash tables.
//!
//! Keys whose equality needs script code (instances with `__eq__`) cannot be compared here: the table then names the
//! candidates and `ops::dict` asks the script, with no borrow held.

use std::cell::Cell;
use std::rc::Rc;

use super::{CellVar, Held, Value, trash};
use crate::ops::hash::{Equal, quick_equal};

const EMPTY: u32 = u32::MAX;
/// Up to this many entries are scanned instead of hashed into a table.
const SCAN_MAX: usize = 8;

/// A dictionary.
#[derive(Default)]
pub struct Dict {
    table: Held<Table>,
    /// The interpreter knows it as a possible part of a cycle.
    pub noted: Cell<bool>,
    /// A search for cycles has found it in use.
    pub old: Cell<bool>,
}

/// A key and its value, with the key's hash.
#[derive(Clone, Default)]
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
    /// Slots that were taken by entries which moved, beyond one for each entry.
    moves: usize,
    /// The values lie in variables that code refers to (`Dict::hold_variables`); an unbound one is no entry.
    of_variables: bool,
}

impl Entry {
    /// Its value, and whether there is one.
    fn read(&self, of_variables: bool) -> Option<Value> {
        match &self.value {
            Value::Cell(variable) if of_variables => {
                Some(variable.value.get()).filter(|value| !value.is_unbound())
            }
            value => (!self.key.is_unbound()).then(|| value.clone()),
        }
    }
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

/// Enters an entry's index in a table of slots with room for it.
fn place(slots: &mut [u32], hash: u64, index: u32) {
    let mask = slots.len() - 1;
    let mut at = spread(hash) & mask;
    while slots[at] != EMPTY {
        at = (at + 1) & mask;
    }
    slots[at] = index;
}

/// Slots for so many entries.
fn slots_for(entries: usize) -> usize {
    (entries * 3).next_power_of_two()
}

/// What is called between pieces of work on a table, with the number of entries done; others may change the table then.
pub type Between<'b, E> = &'b mut dyn FnMut(usize) -> Result<(), E>;
/// Entries that are worked on at once.
pub const SOME: usize = 4096;
/// Times a piece of work starts over because the table has been changed meanwhile; after that it is done at once.
const RETRIES_MAX: usize = 3;

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
            .filter(|(_, e)| e.hash == hash && !self.is_absent(e));
        Found::Ask(
            same_hash
                .map(|(index, entry)| (index, entry.key.clone()))
                .collect(),
            self.generation,
        )
    }

    /// Whether an entry has been deleted.
    #[inline]
    fn is_absent(&self, entry: &Entry) -> bool {
        match self.of_variables {
            true => entry.read(true).is_none(),
            false => entry.key.is_unbound(),
        }
    }

    /// Adds a key of a dictionary of variables; the variable is the one that code refers to already, if there is one.
    #[cold]
    #[inline(never)]
    fn append_variable(&mut self, hash: u64, key: Value, value: Value) {
        let known = match self.find(hash, &key) {
            Found::At(index) => self.delete(index).1,
            Found::Nowhere | Found::Ask(..) => Value::Unbound,
        };
        let variable = match known {
            Value::Cell(variable) => variable,
            _ => Rc::default(),
        };
        // It was unbound.
        variable.value.put(value);
        self.push(hash, key, Value::Cell(variable));
    }

    fn append(&mut self, hash: u64, key: Value, value: Value) {
        match self.of_variables {
            true => self.append_variable(hash, key, value),
            false => self.push(hash, key, value),
        }
    }

    fn push(&mut self, hash: u64, key: Value, value: Value) {
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
        place(&mut self.slots, hash, index);
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
        let size = slots_for(self.entries.len());
        self.slots.resize(size, EMPTY);
        self.moves = 0;
        for (entry, index) in self.entries.iter().zip(0..) {
            if !entry.key.is_unbound() {
                place(&mut self.slots, entry.hash, index);
            }
        }
    }

    /// Moves the entry at an index to the front. Room there is made for as many entries as there are, so that doing this again
    /// and again takes no longer than adding keys does.
    fn move_to_front(&mut self, mut index: usize) {
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
            let mut entries = Vec::with_capacity(room + self.live);
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
        let table = self.table.borrow();
        match table.of_variables {
            true => count_bound(&table),
            false => table.live,
        }
    }

    /// Whether there are no keys.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Searches a key with its hash.
    #[inline]
    pub fn find(&self, hash: u64, key: &Value) -> Found {
        let table = self.table.borrow();
        match table.find(hash, key) {
            Found::At(index) if table.of_variables && table.is_absent(&table.entries[index]) => {
                Found::Nowhere
            }
            found => found,
        }
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
        let table = self.table.borrow();
        match &table.entries[index].value {
            Value::Cell(variable) if table.of_variables => variable.value.get(),
            value => value.clone(),
        }
    }

    /// Replaces the value of the entry at an index from `find`.
    #[inline]
    pub fn set_value_at(&self, index: usize, value: Value) {
        let old = self
            .table
            .change(|table| match &table.entries[index].value {
                Value::Cell(variable) if table.of_variables => variable.value.replace(value),
                _ => std::mem::replace(&mut table.entries[index].value, value),
            });
        drop(old);
    }

    /// Adds a key that is known not to be there.
    pub fn append(&self, hash: u64, key: Value, value: Value) {
        self.table.change(|table| table.append(hash, key, value));
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

    /// Moves the entry at an index from `find` to the front.
    pub fn move_to_front(&self, index: usize) {
        self.table.change(|table| table.move_to_front(index));
    }

    /// Deletes the entry at an index from `find`; returns key and value.
    pub fn delete_at(&self, index: usize) -> (Value, Value) {
        self.table.change(|table| {
            let entry = &table.entries[index];
            if let (true, Value::Cell(variable)) = (table.of_variables, &entry.value) {
                let removed = (entry.key.clone(), variable.value.take());
                table.generation += 1;
                // One that no code refers to goes as a whole; it holds nothing any more.
                if Rc::strong_count(variable) == 1 {
                    drop(table.delete(index));
                }
                return removed;
            }
            table.delete(index)
        })
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
            if let Some(value) = entry.read(table.of_variables) {
                // A variable before it may be bound again.
                if from <= head && !table.of_variables {
                    table.head.set(at - 1);
                }
                return Some((at, entry.key.clone(), value));
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
            .rposition(|entry| !table.is_absent(entry))?;
        if end == tail && !table.of_variables {
            table.tail.set(at + 1);
        }
        let entry = &table.entries[at];
        Some((at, entry.key.clone(), entry.read(table.of_variables)?))
    }

    /// All keys with their hashes and values, in order. For dictionaries that are small or nobody else's.
    pub fn entries(&self) -> Vec<(u64, Value, Value)> {
        let mut entries = Vec::new();
        self.entries_from(0, usize::MAX, &mut entries);
        entries
    }

    /// Appends what is in up to `count` places from `from` on; the place after them, None at the end.
    pub fn entries_from(
        &self,
        from: usize,
        count: usize,
        out: &mut Vec<(u64, Value, Value)>,
    ) -> Option<usize> {
        let table = self.table.borrow();
        let end = from.saturating_add(count).min(table.entries.len());
        let live = table.entries.get(from..end)?.iter();
        out.extend(live.filter_map(|entry| {
            let value = entry.read(table.of_variables)?;
            Some((entry.hash, entry.key.clone(), value))
        }));
        (end < table.entries.len()).then_some(end)
    }

    /// Runs `each` on keys and values of up to `count` entries from `from` on, unless they are being changed; whether there
    /// are more.
    pub fn visit(&self, from: usize, count: usize, each: &mut dyn FnMut(&Value)) -> bool {
        let Some(table) = self.table.try_borrow() else {
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
            .filter(|entry| !table.is_absent(entry))
            .map(|entry| entry.key.clone())
            .collect()
    }

    /// All values, in order of their keys.
    pub fn values(&self) -> Vec<Value> {
        let table = self.table.borrow();
        table
            .entries
            .iter()
            .filter_map(|entry| entry.read(table.of_variables))
            .collect()
    }

    /// Removes everything.
    pub fn clear(&self) {
        let bound = self.variables();
        if !bound.is_empty() {
            // Code still refers to them.
            self.table.change(|table| table.generation += 1);
            bound
                .into_iter()
                .for_each(|variable| drop(variable.value.take()));
            return;
        }
        let old = self.table.change(|table| {
            let generation = table.generation + 1;
            let empty = Table {
                generation,
                ..Table::default()
            };
            std::mem::replace(table, empty)
        });
        drop_entries(old.entries);
    }

    /// A shallow copy.
    pub fn copy<E>(&self, between: Between<'_, E>) -> Result<Dict, E> {
        let mut tries = 0;
        loop {
            let generation = self.generation();
            let mut entries = Vec::with_capacity(self.len());
            let mut at = 0;
            let whole = loop {
                let end = {
                    let table = self.table.borrow();
                    let end = table.entries.len().min(at + SOME);
                    let some = table.entries.get(at..end).unwrap_or_default();
                    entries.extend(some.iter().filter_map(|entry| {
                        let value = entry.read(table.of_variables)?;
                        let (hash, key) = (entry.hash, entry.key.clone());
                        Some(Entry { hash, key, value })
                    }));
                    end
                };
                if end <= at {
                    break true;
                }
                at = end;
                if tries < RETRIES_MAX {
                    between(SOME)?;
                    if self.generation() != generation {
                        break false;
                    }
                }
            };
            if whole {
                let slots = match entries.len() {
                    0..=SCAN_MAX => Vec::new(),
                    length => new_slots(slots_for(length), &entries, length, between)?,
                };
                let copy = Dict::new();
                copy.table.change(|table| {
                    table.live = entries.len();
                    table.tail.set(entries.len());
                    table.entries = entries;
                    table.slots = slots;
                });
                return Ok(copy);
            }
            tries += 1;
            drop_entries(entries);
        }
    }

    /// Whether the next new key makes a big table grow, which is better done in pieces (`enlarge`).
    #[inline]
    pub fn grows_far(&self) -> bool {
        let table = self.table.borrow();
        let length = table.entries.len();
        length > 4 * SOME && (length + 1) * 3 > table.slots.len() * 2
    }

    /// Makes the table greater before a new key does.
    pub fn enlarge<E>(&self, between: Between<'_, E>) -> Result<(), E> {
        for _ in 0..RETRIES_MAX {
            let generation = self.generation();
            let (length, live) = {
                let table = self.table.borrow();
                (table.entries.len(), table.live)
            };
            if live < length / 2 {
                // So many are deleted that the table rather shrinks.
                return Ok(());
            }
            let mut slots = empty_slots(slots_for(length + 1), between)?;
            let mut at = 0;
            while at < length && self.generation() == generation {
                let end = length.min(at + SOME);
                {
                    let table = self.table.borrow();
                    for (entry, index) in table.entries[at..end].iter().zip(at as u32..) {
                        if !entry.key.is_unbound() {
                            place(&mut slots, entry.hash, index);
                        }
                    }
                }
                at = end;
                between(SOME)?;
            }
            if self.generation() == generation {
                drop(self.table.change(|table| {
                    table.moves = 0;
                    std::mem::replace(&mut table.slots, slots)
                }));
                return Ok(());
            }
        }
        Ok(())
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

impl Dict {
    /// Moves its values into variables, for code to refer to: it is the namespace of a text from now on. What such a
    /// dictionary has, and what the variables hold, is the same then; one that is unbound is not in it.
    pub fn hold_variables(&self) {
        self.table.change(|table| {
            if table.of_variables {
                return;
            }
            for entry in table.entries.iter_mut().filter(|e| !e.key.is_unbound()) {
                let value = std::mem::take(&mut entry.value);
                entry.value = Value::Cell(CellVar::new(value));
            }
            table.of_variables = true;
        });
    }

    /// The variable of a name in a dictionary that holds variables; made, unbound, if there is none.
    pub fn variable(&self, name: &Value) -> Rc<CellVar> {
        let Value::Str(text) = name else {
            return Rc::default();
        };
        let hash = text.hash();
        self.table.change(|table| {
            if let Found::At(index) = table.find(hash, name)
                && let Value::Cell(variable) = &table.entries[index].value
            {
                return variable.clone();
            }
            let variable: Rc<CellVar> = Rc::default();
            table.push(hash, name.clone(), Value::Cell(variable.clone()));
            variable
        })
    }

    /// Enters a variable that code refers to, in the place of one of the same name.
    pub fn enter_variable(&self, name: &Value, variable: Rc<CellVar>) {
        let Value::Str(text) = name else { return };
        let hash = text.hash();
        let old = self.table.change(|table| match table.find(hash, name) {
            Found::At(index) => {
                std::mem::replace(&mut table.entries[index].value, Value::Cell(variable))
            }
            Found::Nowhere | Found::Ask(..) => {
                table.push(hash, name.clone(), Value::Cell(variable));
                Value::Unbound
            }
        });
        drop(old);
    }

    /// All variables of a dictionary that holds them, bound or not.
    pub fn variables(&self) -> Vec<Rc<CellVar>> {
        let table = self.table.borrow();
        let entries = table.entries.iter().filter(|_| table.of_variables);
        let variable = |entry: &Entry| match &entry.value {
            Value::Cell(variable) => Some(variable.clone()),
            _ => None,
        };
        entries.filter_map(variable).collect()
    }

    /// Forgets the variables that are unbound and that nobody else refers to.
    pub fn forget_unused_variables(&self) {
        let gone = self.table.change(|table| {
            let is_unused = |entry: &Entry| match &entry.value {
                Value::Cell(variable) => {
                    Rc::strong_count(variable) == 1 && variable.value.borrow().is_unbound()
                }
                _ => false,
            };
            let unused: Vec<usize> = (0..table.entries.len())
                .filter(|index| table.of_variables && is_unused(&table.entries[*index]))
                .collect();
            let gone: Vec<_> = unused
                .iter()
                .map(|index| {
                    let entry = &mut table.entries[*index];
                    table.live -= 1;
                    (
                        std::mem::take(&mut entry.key),
                        std::mem::take(&mut entry.value),
                    )
                })
                .collect();
            if !gone.is_empty() {
                table.generation += 1;
                table.compact();
            }
            gone
        });
        drop(gone);
    }
}

/// The entries of a table of variables that are bound.
#[cold]
fn count_bound(table: &Table) -> usize {
    let bound = table.entries.iter().filter(|entry| !table.is_absent(entry));
    bound.count()
}

fn empty_slots<E>(size: usize, between: Between<'_, E>) -> Result<Vec<u32>, E> {
    let mut slots = Vec::with_capacity(size);
    while slots.len() < size {
        slots.resize(size.min(slots.len() + 16 * SOME), EMPTY);
        between(SOME)?;
    }
    Ok(slots)
}

/// Slots in which the first `length` entries are entered.
fn new_slots<E>(
    size: usize,
    entries: &[Entry],
    length: usize,
    between: Between<'_, E>,
) -> Result<Vec<u32>, E> {
    let mut slots = empty_slots(size, between)?;
    for (some, first) in entries[..length].chunks(SOME).zip((0..).step_by(SOME)) {
        for (entry, index) in some.iter().zip(first..) {
            place(&mut slots, entry.hash, index);
        }
        between(SOME)?;
    }
    Ok(slots)
}

fn drop_entries(mut entries: Vec<Entry>) {
    trash::leave(&mut entries, |entry| {
        trash::tells(&entry.key) || trash::tells(&entry.value)
    });
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
