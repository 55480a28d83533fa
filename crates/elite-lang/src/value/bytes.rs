//! `bytes` and `bytearray`.

use std::cell::Cell;

use super::Held;
use crate::limits::memory;

/// Immutable bytes.
pub struct Bytes {
    data: Vec<u8>,
}

impl Bytes {
    /// Takes over `data`.
    pub fn new(data: Vec<u8>) -> Self {
        memory::track(data.capacity());
        Bytes { data }
    }

    /// The bytes.
    pub fn data(&self) -> &[u8] {
        &self.data
    }
}

impl Drop for Bytes {
    fn drop(&mut self) {
        memory::release(self.data.capacity());
    }
}

/// Mutable bytes.
#[derive(Default)]
pub struct ByteArray {
    /// The bytes. After growing them, call `account`.
    pub data: Held<Vec<u8>>,
    /// Bytes that are accounted for.
    tracked: Cell<usize>,
}

impl ByteArray {
    /// Takes over `data`.
    pub fn new(data: Vec<u8>) -> Self {
        memory::track(data.capacity());
        ByteArray {
            tracked: Cell::new(data.capacity()),
            data: Held::new(data),
        }
    }

    /// Brings the accounting up to date with the capacity.
    pub fn account(&self) {
        let bytes = self.data.borrow().capacity();
        let before = self.tracked.replace(bytes);
        memory::retrack(before, bytes);
    }
}

impl Drop for ByteArray {
    fn drop(&mut self) {
        memory::release(self.tracked.get());
    }
}
