//! Text. Owns the string object: UTF-8 with the number of characters and the hash kept beside it; short texts lie in the
//! object itself.

use std::cell::{Cell, OnceCell};

use compact_str::CompactString;

/// An immutable string.
pub struct Str {
    text: CompactString,
    /// Characters; equal to the number of bytes exactly when the text is ASCII.
    chars: usize,
    /// 0: not computed yet.
    hash: Cell<u64>,
    /// Where characters lie, once somebody asks for one far into a text that is not ASCII.
    marks: OnceCell<Box<Marks>>,
}

/// Characters between two of which the place is known.
const MARK_STEP: usize = 64;

/// Byte offsets of every `MARK_STEP`th character, from the first on.
#[derive(Default)]
struct Marks {
    offsets: Vec<usize>,
}

impl Marks {
    /// Goes on to the end of `text`.
    fn extend(&mut self, text: &str) {
        let (mut skip, start) = match self.offsets.last() {
            Some(last) => (MARK_STEP, *last),
            None => (0, 0),
        };
        for (offset, _) in text[start..].char_indices() {
            if skip == 0 {
                self.offsets.push(start + offset);
                skip = MARK_STEP;
            }
            skip -= 1;
        }
    }
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
            marks: OnceCell::new(),
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
        if index >= self.chars {
            return self.text.len();
        }
        let (start, left) = match self.marks() {
            Some(marks) => (marks.offsets[index / MARK_STEP], index % MARK_STEP),
            None => (0, index),
        };
        let rest = self.text[start..].char_indices().nth(left);
        rest.map_or(self.text.len(), |(offset, _)| start + offset)
    }

    /// None for a short text, which is read from its beginning.
    fn marks(&self) -> Option<&Marks> {
        (self.chars > MARK_STEP).then(|| {
            let marks = self.marks.get_or_init(|| {
                let mut marks = Marks::default();
                marks.extend(&self.text);
                Box::new(marks)
            });
            &**marks
        })
    }

    /// Character number `index`.
    pub fn char_at(&self, index: usize) -> Option<char> {
        self.text[self.byte_offset(index)..].chars().next()
    }

    /// Number of characters before byte `offset`.
    pub fn char_index(&self, offset: usize) -> usize {
        if self.is_ascii() {
            offset
        } else {
            let (from, before) = match self.marks() {
                Some(marks) => {
                    let after = marks.offsets.partition_point(|mark| *mark <= offset);
                    let mark = after.saturating_sub(1);
                    (marks.offsets[mark], mark * MARK_STEP)
                }
                None => (0, 0),
            };
            before + self.text[from..offset].chars().count()
        }
    }

    /// The characters from `start` up to `end` (in characters, both within the length).
    pub fn slice(&self, start: usize, end: usize) -> &str {
        if start >= end {
            return "";
        }
        &self.text[self.byte_offset(start)..self.byte_offset(end)]
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
        if let Some(marks) = self.marks.get_mut() {
            marks.extend(&self.text);
        }
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
