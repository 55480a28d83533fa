//! Text. Owns the string object: UTF-8 with the number of characters and the hash kept beside it; short texts lie in the
//! object itself.

use std::cell::Cell;

use compact_str::CompactString;

/// An immutable string.
pub struct Str {
    text: CompactString,
    /// Characters; equal to the number of bytes exactly when the text is ASCII.
    chars: usize,
    /// 0: not computed yet.
    hash: Cell<u64>,
}

impl Str {
    /// Takes over `text`.
    pub fn new(text: impl Into<CompactString>) -> Self {
        let text = text.into();
        let chars = if text.is_ascii() {
            text.len()
        } else {
            text.chars().count()
        };
        Self::counted(text, chars)
    }

    /// Takes over `text` with its number of characters, which the caller knows.
    pub fn counted(text: impl Into<CompactString>, chars: usize) -> Self {
        let text = text.into();
        debug_assert_eq!(chars, text.chars().count());
        Str {
            text,
            chars,
            hash: Cell::new(0),
        }
    }

    /// The text.
    #[inline]
    pub fn as_str(&self) -> &str {
        &self.text
    }

    /// Number of characters, Python's `len`.
    #[inline]
    pub fn len(&self) -> usize {
        self.chars
    }

    /// Whether there are no characters.
    pub fn is_empty(&self) -> bool {
        self.text.is_empty()
    }

    /// Whether every character is one byte, so that indices are byte offsets.
    #[inline]
    pub fn is_ascii(&self) -> bool {
        self.chars == self.text.len()
    }

    /// Byte offset of character `index`; the end for indices at or past the length.
    pub fn byte_offset(&self, index: usize) -> usize {
        if self.is_ascii() {
            return index.min(self.text.len());
        }
        self.text
            .char_indices()
            .nth(index)
            .map_or(self.text.len(), |(offset, _)| offset)
    }

    /// Number of characters before byte `offset`.
    pub fn char_index(&self, offset: usize) -> usize {
        if self.is_ascii() {
            offset
        } else {
            self.text[..offset].chars().count()
        }
    }

    /// The characters from `start` up to `end` (in characters, both within the length).
    pub fn slice(&self, start: usize, end: usize) -> &str {
        if start >= end {
            return "";
        }
        let from = self.byte_offset(start);
        if self.is_ascii() {
            return &self.text[from..end.min(self.text.len())];
        }
        let rest = &self.text[from..];
        let length = rest
            .char_indices()
            .nth(end - start)
            .map_or(rest.len(), |(offset, _)| offset);
        &rest[..length]
    }

    /// The hash; never 0.
    #[inline]
    pub fn hash(&self) -> u64 {
        let known = self.hash.get();
        if known != 0 {
            return known;
        }
        let hash = hash_bytes(self.text.as_bytes()).max(1);
        self.hash.set(hash);
        hash
    }

    /// Appends in place; the caller holds the only reference.
    pub fn push_str(&mut self, more: &Str) {
        self.text.push_str(&more.text);
        self.chars += more.chars;
        self.hash.set(0);
    }
}

/// Hash of a byte string: eight bytes at a time, multiply and fold.
pub fn hash_bytes(bytes: &[u8]) -> u64 {
    const K: u64 = 0x9E37_79B9_7F4A_7C15;
    let mut hash = K ^ bytes.len() as u64;
    let mut fold = |word: u64| {
        let product = u128::from(hash ^ word) * u128::from(K);
        hash = (product as u64) ^ ((product >> 64) as u64);
    };
    let mut chunks = bytes.chunks_exact(8);
    for chunk in &mut chunks {
        let mut word = [0; 8];
        word.copy_from_slice(chunk);
        fold(u64::from_le_bytes(word));
    }
    let rest = chunks.remainder();
    if !rest.is_empty() {
        let mut word = [0; 8];
        word[..rest.len()].copy_from_slice(rest);
        fold(u64::from_le_bytes(word));
    }
    hash
}
