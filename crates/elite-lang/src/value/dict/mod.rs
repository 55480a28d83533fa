//! Dictionaries: insertion-ordered hash tables.
//!
//! Keys whose equality needs script code (instances with `__eq__`) cannot be compared here: the table then names the
//! candidates and `ops::dict` asks the script, with no borrow held. Owns what others do with a dictionary; the table
//! itself is in `table`, dictionaries of variables are in `variables`.

mod table;
mod variables;

use std::cell::Cell;
use std::rc::Rc;

use super::{ScriptCell, Value};
use crate::limits::deferred_drop;
use crate::limits::value_vec::DropItem as _;
use table::DictTable;
pub use table::{Entry, KeySearch};

/// A dictionary.
#[derive(Default)]
pub struct Dict {
    table: ScriptCell<DictTable>,
    /// The interpreter knows it as a possible part of a cycle.
    pub noted: Cell<bool>,
    /// A search for cycles has found it in use.
    pub old: Cell<bool>,
}

/// What a look at some places of a table came to: between two that are in use there may be millions that are not.
pub enum ScanResult<T> {
    /// The next entry.
    Found(T),
    /// None so far; where to go on.
    Continue(usize),
    /// There is none.
    End,
}

/// Entries that are worked on at once.
pub const REHASH_CHUNK: usize = 4096;
impl Dict {
    /// An empty dictionary.
    pub fn new() -> Self {
        Dict::default()
    }

    /// An empty dictionary with room for so many keys, if they are few.
    pub fn with_room(keys: usize) -> Self {
        let dict = Dict::default();
        if keys > 0 {
            dict.table.with_mut(|table| table.make_room(keys));
        }
        dict
    }

    /// Number of keys.
    #[inline]
    pub fn len(&self) -> usize {
        let table = self.table.borrow();
        match table.of_variables() {
            true => table.count_bound(),
            false => table.live,
        }
    }

    /// Whether there are no keys.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Searches a key with its hash.
    #[inline]
    pub fn find(&self, hash: u64, key: &Value) -> KeySearch {
        let table = self.table.borrow();
        match table.find(hash, key) {
            KeySearch::At(index)
                if table.of_variables() && table.is_absent(&table.entries[index]) =>
            {
                KeySearch::Nowhere
            }
            found => found,
        }
    }

    /// The value of a key with its hash, if it is there; None if script code has to compare keys.
    #[inline]
    pub fn get_fast(&self, hash: u64, key: &Value) -> Option<Option<Value>> {
        // SAFETY: keys that need no code of a script are compared, and a value is copied; that changes nothing.
        #[allow(unsafe_code)]
        let table = unsafe { self.table.get_unguarded() }?;
        let found = table.find_at_once(hash, key).ok()?;
        Some(found.and_then(|index| match &table.entries[index].value {
            Value::Cell(variable) if table.of_variables() => {
                Some(variable.value.get_or_unbound()).filter(|value| !value.is_unbound())
            }
            value => Some(value.clone()),
        }))
    }

    /// Replaces the value of a key with its hash, or adds both if there is room, unless script code has to compare
    /// keys: the value that was there (`Unbound` if none was), otherwise the new one back.
    #[inline]
    pub fn set_fast(&self, hash: u64, key: &Value, value: Value) -> Result<Value, Value> {
        self.table.with_mut(|table| {
            if table.of_variables() {
                return Err(value);
            }
            match table.find_at_once(hash, key) {
                Ok(Some(index)) => {
                    let entry = &mut table.entries[index];
                    Ok(std::mem::replace(&mut entry.value, value))
                }
                Ok(None) if table.has_room_for(1) => {
                    table.push(hash, key.clone(), value);
                    Ok(Value::Unbound)
                }
                _ => Err(value),
            }
        })
    }

    /// Whether a key with its hash is there, if no script code has to compare keys.
    #[inline]
    pub fn contains_fast(&self, hash: u64, key: &Value) -> Option<bool> {
        // SAFETY: keys that need no code of a script are compared; that changes nothing.
        #[allow(unsafe_code)]
        let table = unsafe { self.table.get_unguarded() }?;
        match table.find_at_once(hash, key).ok()? {
            Some(_) if table.of_variables() => None,
            found => Some(found.is_some()),
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
            Value::Cell(variable) if table.of_variables() => variable.value.get(),
            value => value.clone(),
        }
    }

    /// Replaces the value of the entry at an index from `find`.
    #[inline]
    pub fn set_value_at(&self, index: usize, value: Value) {
        let old = self.table.with_mut(|table| match table.of_variables() {
            true => table.set_variable(index, value),
            false => std::mem::replace(&mut table.entries[index].value, value),
        });
        drop(old);
    }

    /// Adds a key that is known not to be there.
    pub fn append(&self, hash: u64, key: Value, value: Value) {
        self.table.with_mut(|table| table.append(hash, key, value));
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
        match table.has_room_for(more) {
            true => 0,
            false => table.growth_to(table.entries.len() + more),
        }
    }

    /// Moves the entry at an index from `find` to the front.
    pub fn move_to_front(&self, index: usize) {
        self.table.with_mut(|table| table.move_to_front(index));
    }

    /// Deletes the entry at an index from `find`; returns key and value.
    pub fn delete_at(&self, index: usize) -> (Value, Value) {
        self.table.with_mut(|table| {
            let entry = &table.entries[index];
            if let (true, Value::Cell(variable)) = (table.of_variables(), &entry.value) {
                let unbound = table.known_unbound();
                let removed = (entry.key.clone(), variable.take());
                // A variable that no code refers to goes as a whole; it holds nothing any more.
                let goes = Rc::strong_count(variable) == 1;
                table.generation += 1;
                if goes {
                    drop(table.delete(index));
                }
                table.note_unbound(unbound.map(|count| count + usize::from(!goes)));
                return removed;
            }
            table.delete(index)
        })
    }

    /// The first entry at position `from` or later, and the position after it. Positions survive changes of values,
    /// not of keys.
    pub fn next_entry(&self, from: usize) -> ScanResult<(usize, Value, Value)> {
        let table = self.table.borrow();
        let head = table.head.get();
        let begin = from.max(head);
        let end = table.entries.len().min(begin.saturating_add(REHASH_CHUNK));
        let mut is_first = from <= head;
        for at in begin..end {
            let entry = &table.entries[at];
            // A variable that is unbound may be bound again.
            if is_first && !entry.key.is_unbound() {
                table.head.set(at);
                is_first = false;
            }
            if let Some(value) = entry.read(table.of_variables()) {
                return ScanResult::Found((at + 1, entry.key.clone(), value));
            }
        }
        if is_first {
            table.head.set(end.max(head));
        }
        match end < table.entries.len() {
            true => ScanResult::Continue(end),
            false => ScanResult::End,
        }
    }

    /// The last entry before position `from` and its position; `usize::MAX` starts at the end.
    pub fn previous_entry(&self, from: usize) -> ScanResult<(usize, Value, Value)> {
        let table = self.table.borrow();
        let tail = table.tail.get();
        let end = from.min(tail);
        let begin = end.saturating_sub(REHASH_CHUNK);
        let mut is_last = from >= tail;
        for at in (begin..end).rev() {
            let entry = &table.entries[at];
            if is_last && !entry.key.is_unbound() {
                table.tail.set(at + 1);
                is_last = false;
            }
            if let Some(value) = entry.read(table.of_variables()) {
                return ScanResult::Found((at, entry.key.clone(), value));
            }
        }
        if is_last {
            table.tail.set(begin);
        }
        match begin > 0 {
            true => ScanResult::Continue(begin),
            false => ScanResult::End,
        }
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
            let value = entry.read(table.of_variables())?;
            Some((entry.hash, entry.key.clone(), value))
        }));
        (end < table.entries.len()).then_some(end)
    }

    /// Runs `each` on keys and values of up to `count` entries from `from` on, unless they are being changed; whether
    /// there are more.
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
            .filter_map(|entry| entry.read(table.of_variables()))
            .collect()
    }

    /// Removes everything.
    pub fn clear(&self) {
        if self.table.borrow().of_variables() {
            return self.clear_variables();
        }
        let old = self.table.with_mut(|table| {
            let generation = table.generation + 1;
            let empty = DictTable {
                generation,
                ..DictTable::default()
            };
            std::mem::replace(table, empty)
        });
        drop_entries(old.entries);
    }

    /// A shallow copy.
    pub fn copy(&self) -> Dict {
        let table = self.table.borrow();
        let is_of_variables = table.of_variables();
        let read = |entry: &Entry| {
            let value = entry.read(is_of_variables)?;
            let (hash, key) = (entry.hash, entry.key.clone());
            Some(Entry { hash, key, value })
        };
        let mut entries = Vec::with_capacity(table.live);
        entries.extend(table.entries.iter().filter_map(read));
        let copy = Dict::new();
        copy.table.with_mut(|table| {
            table.live = entries.len();
            table.tail.set(entries.len());
            table.entries = entries;
            table.rebuild();
        });
        copy
    }

    /// The value of a string key. For embedders and the library; scripts go through `ops::dict`.
    pub fn get_str(&self, key: &str) -> Option<Value> {
        let key = Value::str(key);
        let Value::Str(text) = &key else { return None };
        match self.find(text.hash(), &key) {
            KeySearch::At(index) => Some(self.value_at(index)),
            KeySearch::Nowhere | KeySearch::Ask(..) => None,
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
            KeySearch::At(index) => self.set_value_at(index, value),
            KeySearch::Nowhere | KeySearch::Ask(..) => self.append(hash, key, value),
        }
    }
}

fn drop_entries(mut entries: Vec<Entry>) {
    deferred_drop::defer_if_large(&mut entries, Entry::may_run_script);
    let cell = Cell::new(entries);
    deferred_drop::drop_with_depth(
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
