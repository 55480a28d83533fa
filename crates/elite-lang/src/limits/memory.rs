//! Approximate accounting of the memory that values take.
//!
//! Containers report the bytes of their buffers here, per OS thread; while a script thread runs, its interpreter
//! attributes the difference to its task. Small fixed parts of objects are left out.

use std::cell::Cell;

thread_local! {
    static HELD: Cell<isize> = const { Cell::new(0) };
}

/// Notes that `bytes` more are held.
#[inline]
pub fn track(bytes: usize) {
    let _ = HELD.try_with(|held| held.set(held.get() + bytes as isize));
}

/// Notes that `bytes` are no longer held.
#[inline]
pub fn release(bytes: usize) {
    let _ = HELD.try_with(|held| held.set(held.get() - bytes as isize));
}

/// Notes that a buffer went from `before` to `after` bytes.
#[inline]
pub fn retrack(before: usize, after: usize) {
    let _ = HELD.try_with(|held| held.set(held.get() + after as isize - before as isize));
}

/// Bytes held by the values of this OS thread.
pub fn held() -> isize {
    HELD.with(Cell::get)
}
