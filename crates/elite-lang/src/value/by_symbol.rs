//! Tables by symbol. One of hundreds of thousands of names takes many milliseconds to grow, in which nobody else has a
//! turn; so a table of many names is many small ones, each of which grows by itself.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use super::Symbol;

/// Most names of a table that is not divided.
const SINGLE_MAX: usize = 4096;
/// Tables that a bigger one is divided into.
const SHARDS: usize = 64;

type MapShard<V> = HashMap<Symbol, V, BuildHasherDefault<SymbolHasher>>;

/// Spreads symbols over a table: they are numbers that the interpreter gives out itself, so nobody can choose them to
/// collide.
#[derive(Default)]
struct SymbolHasher(u64);

impl Hasher for SymbolHasher {
    fn write(&mut self, bytes: &[u8]) {
        bytes
            .iter()
            .for_each(|byte| self.write_u32(u32::from(*byte)));
    }

    #[inline]
    fn write_u32(&mut self, number: u32) {
        self.0 = (self.0 ^ u64::from(number)).wrapping_mul(SPREAD);
    }

    #[inline]
    fn finish(&self) -> u64 {
        self.0
    }
}

const SPREAD: u64 = 0x9E37_79B9_7F4A_7C15;

/// A table by symbol.
pub struct SymbolMap<V> {
    /// All names, while there are few.
    single: MapShard<V>,
    /// The names by parts, once there are many.
    shards: Option<Box<[MapShard<V>]>>,
    length: usize,
}

impl<V> Default for SymbolMap<V> {
    fn default() -> Self {
        SymbolMap {
            single: MapShard::default(),
            shards: None,
            length: 0,
        }
    }
}

/// The number of the part that a name is in. The parts themselves go by the lowest and the highest bits of the same
/// product.
fn part_of(name: Symbol) -> usize {
    (u64::from(name.0).wrapping_mul(SPREAD) >> 40) as usize % SHARDS
}

impl<V> SymbolMap<V> {
    #[inline]
    fn part(&self, name: Symbol) -> &MapShard<V> {
        match &self.shards {
            None => &self.single,
            Some(parts) => &parts[part_of(name)],
        }
    }

    fn part_mut(&mut self, name: Symbol) -> &mut MapShard<V> {
        match &mut self.shards {
            None => &mut self.single,
            Some(parts) => &mut parts[part_of(name)],
        }
    }

    /// Number of names.
    pub fn len(&self) -> usize {
        self.length
    }

    /// What a name leads to.
    #[inline]
    pub fn get(&self, name: Symbol) -> Option<&V> {
        self.part(name).get(&name)
    }

    /// Whether there is the name.
    pub fn contains(&self, name: Symbol) -> bool {
        self.part(name).contains_key(&name)
    }

    /// Makes a name lead to a value; what it led to before.
    pub fn insert(&mut self, name: Symbol, value: V) -> Option<V> {
        if self.length == SINGLE_MAX && self.shards.is_none() {
            let mut parts: Box<[MapShard<V>]> = (0..SHARDS).map(|_| MapShard::default()).collect();
            for (name, value) in std::mem::take(&mut self.single) {
                parts[part_of(name)].insert(name, value);
            }
            self.shards = Some(parts);
        }
        let old = self.part_mut(name).insert(name, value);
        self.length += usize::from(old.is_none());
        old
    }

    /// Takes a name out.
    pub fn remove(&mut self, name: Symbol) -> Option<V> {
        let old = self.part_mut(name).remove(&name)?;
        self.length -= 1;
        Some(old)
    }

    /// What the names lead to, in no order.
    pub fn values(&self) -> impl Iterator<Item = &V> {
        let parts = self.shards.iter().flat_map(|parts| parts.iter());
        self.single.values().chain(parts.flat_map(MapShard::values))
    }

    /// What the names lead to, in no order; the table is used up.
    pub fn into_values(self) -> impl Iterator<Item = V> {
        let parts = self.shards.into_iter().flatten();
        self.single
            .into_values()
            .chain(parts.flat_map(MapShard::into_values))
    }

    /// Gives room back that more than twice as many names would need.
    pub fn shrink(&mut self) {
        self.single.shrink_to(self.single.len() * 2);
        for part in self.shards.iter_mut().flat_map(|parts| parts.iter_mut()) {
            part.shrink_to(part.len() * 2);
        }
    }
}

impl<V> FromIterator<(Symbol, V)> for SymbolMap<V> {
    fn from_iter<I: IntoIterator<Item = (Symbol, V)>>(entries: I) -> Self {
        let mut map = SymbolMap::default();
        for (name, value) in entries {
            map.insert(name, value);
        }
        map
    }
}

/// A set of symbols.
#[derive(Default)]
pub struct SymbolSet(SymbolMap<()>);

impl SymbolSet {
    /// Whether a name is in it.
    pub fn contains(&self, name: Symbol) -> bool {
        self.0.contains(name)
    }
}

impl Extend<Symbol> for SymbolSet {
    fn extend<I: IntoIterator<Item = Symbol>>(&mut self, names: I) {
        for name in names {
            self.0.insert(name, ());
        }
    }
}

impl FromIterator<Symbol> for SymbolSet {
    fn from_iter<I: IntoIterator<Item = Symbol>>(names: I) -> Self {
        let mut set = SymbolSet::default();
        set.extend(names);
        set
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_names_are_found_replaced_and_taken_out() {
        let mut map = SymbolMap::default();
        for number in 0..20_000 {
            assert_eq!(map.insert(Symbol(number), number), None);
        }
        assert_eq!(map.insert(Symbol(7), 8), Some(7));
        assert_eq!(map.len(), 20_000);
        for number in (0..20_000).step_by(2) {
            assert_eq!(map.remove(Symbol(number)), Some(number));
        }
        map.shrink();
        assert_eq!(map.len(), 10_000);
        assert_eq!(map.get(Symbol(7)), Some(&8));
        assert!(!map.contains(Symbol(8)));
        assert_eq!(map.values().count(), 10_000);
        let parts = map.shards.as_ref().map_or(&[][..], |parts| parts);
        assert!(parts.iter().all(|part| part.len() < 10_000 / SHARDS * 2));
        assert_eq!(map.into_values().count(), 10_000);
    }
}
