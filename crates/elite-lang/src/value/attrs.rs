//! Attributes by symbol, in the order they were first set. Deleting leaves a hole, so that indices stay valid until
//! something new is inserted.

use super::by_symbol::SymbolMap;
use super::{Symbol, Value};

/// With more holes than this, and than entries, they are closed.
const HOLES_MAX: usize = 16;
/// Up to this many keys a scan is faster than a table.
const SCAN_MAX: usize = 8;

/// A map from symbols to values with stable indices.
#[derive(Default)]
pub struct AttrMap {
    keys: Vec<Symbol>,
    values: Vec<Value>,
    index: SymbolMap<u32>,
    holes: usize,
}

impl AttrMap {
    /// Index of `key`, also if its value has been deleted.
    pub fn index_of(&self, key: Symbol) -> Option<usize> {
        if self.keys.len() <= SCAN_MAX {
            return self.keys.iter().position(|other| *other == key);
        }
        self.index.get(&key).map(|index| *index as usize)
    }

    /// The value of `key`.
    pub fn get(&self, key: Symbol) -> Option<&Value> {
        self.index_of(key)
            .map(|index| &self.values[index])
            .filter(|value| !value.is_unbound())
    }

    /// The value at an index from `index_of`; `Unbound` if deleted.
    #[inline]
    pub fn at(&self, index: usize) -> Option<&Value> {
        self.values.get(index)
    }

    /// Sets `key`; returns the value before, `Unbound` if there was none.
    pub fn insert(&mut self, key: Symbol, value: Value) -> Value {
        if let Some(index) = self.index_of(key) {
            let old = std::mem::replace(&mut self.values[index], value);
            self.holes = self.holes.saturating_sub(usize::from(old.is_unbound()));
            return old;
        }
        if self.holes > HOLES_MAX && self.holes > self.keys.len() / 2 {
            self.close_holes();
        }
        let index = self.keys.len();
        if index == SCAN_MAX {
            self.index = self
                .keys
                .iter()
                .enumerate()
                .map(|(index, key)| (*key, index as u32))
                .collect();
        }
        if index >= SCAN_MAX {
            self.index.insert(key, index as u32);
        }
        self.keys.push(key);
        self.values.push(value);
        Value::Unbound
    }

    /// Deletes `key`; returns the value it had.
    pub fn remove(&mut self, key: Symbol) -> Option<Value> {
        let index = self.index_of(key)?;
        let value = std::mem::take(&mut self.values[index]);
        if value.is_unbound() {
            return None;
        }
        self.holes += 1;
        Some(value)
    }

    fn close_holes(&mut self) {
        let keys = std::mem::take(&mut self.keys);
        let values = std::mem::take(&mut self.values);
        self.index = SymbolMap::default();
        self.holes = 0;
        for (key, value) in keys.into_iter().zip(values) {
            if !value.is_unbound() {
                self.insert(key, value);
            }
        }
    }

    /// Keys and values, holes left out.
    pub fn iter(&self) -> impl Iterator<Item = (Symbol, &Value)> {
        self.keys
            .iter()
            .copied()
            .zip(&self.values)
            .filter(|(_, value)| !value.is_unbound())
    }

    /// Appends what is at up to `count` indices from `from` on, holes left out; whether there are more.
    pub fn entries_chunk(&self, from: usize, count: usize, out: &mut Vec<(Symbol, Value)>) -> bool {
        let end = self.keys.len().min(from.saturating_add(count));
        for at in from..end {
            if !self.values[at].is_unbound() {
                out.push((self.keys[at], self.values[at].clone()));
            }
        }
        end < self.keys.len()
    }

    /// The names, also of holes.
    pub fn names(&self) -> &[Symbol] {
        &self.keys
    }

    /// Number of indices in use, holes included.
    pub fn index_count(&self) -> usize {
        self.keys.len()
    }

    /// Drops all values and keys.
    pub fn take_values(&mut self) -> Vec<Value> {
        self.keys.clear();
        self.index = SymbolMap::default();
        self.holes = 0;
        std::mem::take(&mut self.values)
    }
}
