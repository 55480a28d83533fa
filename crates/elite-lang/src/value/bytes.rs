//! `bytes` and `bytearray`.

use std::cell::RefCell;

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
    /// The bytes.
    pub data: RefCell<Vec<u8>>,
}
