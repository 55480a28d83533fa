//! What bounds memory, pauses, depth and time of the programs of a task.
//!
//! # The promises
//!
//! | promise | held by the test |
//! |---|---|
//! | A task's memory limit counts all that it holds; resident memory stays below the limit and a quarter. | `memory` |
//! | A builtin reaches a safepoint within 5 ms on up to 100,000 items or 1 MB, in proportion beyond. | `pace::` |
//! | No chain of values overflows a native stack: not when it is shown, compared or dropped. | `trials::chains` |
//! | A text of N bytes compiles in O(N log N); no builtin grows faster than CPython's. | `compile_time::`, `growth::` |
//!
//! # Safepoints
//!
//! Back-edges of loops and calls take one unit of *fuel* ([`task_memory::consume_fuel`]). Without fuel a thread does
//! the safepoint duties, in this order: it compares the memory account with the limit, drops a portion of what was
//! deferred, runs finalizers, sweeps symbols if their number has doubled, does a slice of a collector run, and then
//! suspends, so that other script threads run and a stop is seen.
//!
//! # Work of builtins (`yielding`, `chunked`)
//!
//! A builtin counts its work in units of about a nanosecond ([`Evaluator::charge`](crate::eval::Evaluator::charge)).
//! When `YIELD_BUDGET` is used up, other threads run. Nothing may be borrowed across a charge. Long texts and bytes are
//! worked on in chunks (`chunked`), with a charge after each. Work is counted and never measured: a run is the same
//! every time.
//!
//! # Memory (`growth`, `task_memory`)
//!
//! The allocator counts for each thread. The alarm at the limit withholds all fuel, so the next safepoint compares. A
//! builtin asks before it grows a buffer (`growth`), because the allocator cannot refuse. The handler of a
//! `MemoryError` has a reserve of its own.
//!
//! # Dropping (`deferred_drop`, `value_vec`)
//!
//! Values within values are dropped by recursion down to a depth of sixteen, deeper ones by a queue. A container of
//! very many values hands them over when it is dropped, and a portion of them goes at each safepoint.
//! [`ValueVec`](value_vec::ValueVec) is a `Vec` that does so. Code and trees of a text that a program has made are
//! dropped in portions as well: a text may have a megabyte, whose tree takes more than 5 ms to drop at once.
//!
//! # Cycles (`gc`)
//!
//! A trial-deletion collector with two generations finds objects that only refer to each other. A run is done in slices
//! at safepoints. It knows what natives hold because their data reports it (`Contents` in `value::data`).
//!
//! # Symbols (`symbol_sweep`)
//!
//! Names of attributes and variables are numbers. Those that no code, class or namespace uses any more are found by a
//! sweep, so that a program that makes up names for days does not grow.
//!
//! # A new builtin
//!
//! A builtin asks before it grows, charges for each chunk, holds no borrow across a charge, and keeps many values in a
//! `ValueVec`:
//!
//! ```text
//! fn doubled(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
//!     let items = ev.collect(&args[0])?;
//!     let mut out = ValueVec::from(ev.try_with_capacity(items.len())?);
//!     for item in items {
//!         ev.charge(WORK_PER_VALUE)?;
//!         out.push(ev.binary(BinaryOp::Add, &item, &item)?);
//!     }
//!     Ok(Value::list(out.into()))
//! }
//! ```
//!
//! # Numbers
//!
//! | constant | optimised | why |
//! |---|---|---|
//! | `yielding::YIELD_BUDGET` | 262,144 units | some 0.3 ms, ten times as long on memory that is not at hand |
//! | `chunked::BULK_CHUNK` | 256 KiB | bytes that are searched or copied between two charges |
//! | `deferred_drop::DROP_DEPTH_MAX` | 16 levels | fits the native stack that a builtin keeps free |
//! | `deferred_drop::DEFER_MIN` | 16,384 values | from this size on a container is dropped in portions |
//! | `Limits::stop_fuel` | 100,000 safepoints | for `finally` and `with` blocks of a thread that is stopped |

pub(crate) mod chunked;
pub(crate) mod deferred_drop;
pub(crate) mod gc;
pub(crate) mod growth;
pub(crate) mod overflow;
pub(crate) mod symbol_sweep;
pub(crate) mod value_vec;
pub(crate) mod yielding;

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
