//! Tables by symbol.

use std::collections::{HashMap, HashSet};
use std::hash::{BuildHasherDefault, Hasher};

use super::Symbol;

/// A table by symbol.
pub type SymbolMap<V> = HashMap<Symbol, V, BuildHasherDefault<SymbolHasher>>;
/// A set of symbols.
pub type SymbolSet = HashSet<Symbol, BuildHasherDefault<SymbolHasher>>;

/// Spreads symbols over a table: they are numbers that the interpreter gives out itself, so nobody can choose them to
/// collide.
#[derive(Default)]
pub struct SymbolHasher(u64);

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
