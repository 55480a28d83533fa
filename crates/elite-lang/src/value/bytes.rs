//! `bytes` and `bytearray`.

use super::Held;

/// Immutable bytes.
pub struct Bytes {
    data: Vec<u8>,
}

impl Bytes {
    /// Takes over `data`.
    pub fn new(data: Vec<u8>) -> Self {
        Bytes { data }
    }

    /// The bytes.
    pub fn data(&self) -> &[u8] {
        &self.data
    }
}

/// Mutable bytes.
#[derive(Default)]
pub struct ByteArray {
    /// The bytes.
    pub data: Held<Vec<u8>>,
}

impl ByteArray {
    /// Takes over `data`.
    pub fn new(data: Vec<u8>) -> Self {
        ByteArray {
            data: Held::new(data),
        }
    }
}
