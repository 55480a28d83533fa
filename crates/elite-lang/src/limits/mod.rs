//! What one task may use: memory, call depth, digits of integers.

pub(crate) mod overflow;

/// Limits of one interpreter.
#[derive(Clone, Debug)]
pub struct Limits {
    /// Bytes of values a task may hold, counted approximately; beyond it `MemoryError` is raised.
    pub memory_bytes: usize,
    /// Calls within calls; one more raises `RecursionError`.
    pub call_depth: u32,
    /// Digits of an integer that is read from or written as decimal text.
    pub int_digits: usize,
    /// Bits of the result of an integer operation.
    pub int_bits: u64,
    /// Safepoints (back-edges and calls) a stopped thread may still pass in its `finally` and `with` blocks.
    pub stop_fuel: u32,
    /// Fuel of the `finally` and `with` blocks of a generator that is dropped: they run while all other threads wait.
    pub drop_fuel: u32,
}

impl Default for Limits {
    fn default() -> Self {
        Limits {
            memory_bytes: 512 << 20,
            call_depth: 1000,
            int_digits: 4300,
            int_bits: 1 << 22,
            stop_fuel: 100_000,
            drop_fuel: 100_000,
        }
    }
}
