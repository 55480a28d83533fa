//! Text. Owns the string object: UTF-8, short texts in the object itself. The hash is kept beside it, and behind it
//! what is needed where characters are not bytes: their number and their places.

use std::cell::{Cell, OnceCell};

use compact_str::CompactString;

/// An immutable string.
pub struct Str {
    text: StrRepr,
    /// 0: not computed yet.
    hash: Cell<u64>,
}

// The size of 32 bytes makes 48 with the counts of `Rc`.
const _: () = assert!(size_of::<Str>() == 32);

enum StrRepr {
    /// Every character is a byte.
    Ascii(CompactString),
    /// Some characters are several bytes.
    Wide(Box<WideText>),
}

struct WideText {
    text: CompactString,
    chars: usize,
    /// Where characters lie, once somebody asks for one far into the text.
    marks: OnceCell<Box<CharIndex>>,
}

impl StrRepr {
    fn new(text: CompactString, chars: usize) -> Self {
        match chars == text.len() {
            true => StrRepr::Ascii(text),
            false => StrRepr::Wide(Box::new(WideText {
                text,
                chars,
                marks: OnceCell::new(),
            })),
        }
    }
}

/// Longest text that is copied into a block of its own size if that in which it was made is too large.
const FITTED: usize = 4096;

/// Whether a short text has room that it will not need.
#[inline(always)]
fn is_loose(text: &CompactString) -> bool {
    text.is_heap_allocated() && {
        let length = text.len();
        length <= FITTED && text.capacity() - length > 8 + length / 8
    }
}

/// Characters between two of which the place is known.
const MARK_STEP: usize = 64;

/// Byte offsets of every `MARK_STEP`th character, from the first on.
#[derive(Default)]
struct CharIndex {
    offsets: Vec<usize>,
}

impl CharIndex {
    /// Goes on to the end of `text`, which goes on from what was marked.
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
        Self::with_char_count(text, chars)
    }

    /// Takes over `text` with its number of characters, which the caller knows.
    #[inline(always)]
    pub fn with_char_count(text: impl Into<CompactString>, chars: usize) -> Self {
        let text = text.into();
        debug_assert_eq!(chars, text.chars().count());
        if chars != text.len() || is_loose(&text) {
            return Self::fitted(text, chars);
        }
        Str {
            text: StrRepr::Ascii(text),
            hash: Cell::new(0),
        }
    }

    /// Takes over any text with its number of characters, without room that it does not need.
    #[inline(never)]
    fn fitted(mut text: CompactString, chars: usize) -> Self {
        if is_loose(&text) {
            text.shrink_to_fit();
        }
        Str {
            text: StrRepr::new(text, chars),
            hash: Cell::new(0),
        }
    }

    /// The text.
    #[inline]
    pub fn as_str(&self) -> &str {
        match &self.text {
            StrRepr::Ascii(text) => text,
            StrRepr::Wide(wide) => &wide.text,
        }
    }

    /// Number of characters, Python's `len`.
    #[inline]
    pub fn len(&self) -> usize {
        match &self.text {
            StrRepr::Ascii(text) => text.len(),
            StrRepr::Wide(wide) => wide.chars,
        }
    }

    /// Whether there are no characters.
    pub fn is_empty(&self) -> bool {
        self.as_str().is_empty()
    }

    /// Whether every character is one byte, so that indices are byte offsets.
    #[inline]
    pub fn is_ascii(&self) -> bool {
        matches!(self.text, StrRepr::Ascii(_))
    }

    /// Byte offset of character `index`; the end for indices at or past the length.
    pub fn byte_offset(&self, index: usize) -> usize {
        match &self.text {
            StrRepr::Ascii(text) => index.min(text.len()),
            StrRepr::Wide(wide) => wide.byte_offset(index),
        }
    }

    /// Marks where characters are, unless that is known; `between` is called with the bytes of each piece of the text.
    pub fn build_char_index<E>(
        &self,
        piece: usize,
        between: &mut dyn FnMut(usize) -> Result<(), E>,
    ) -> Result<(), E> {
        match &self.text {
            StrRepr::Ascii(_) => Ok(()),
            StrRepr::Wide(wide) => wide.mark(piece, between),
        }
    }

    /// The hash if it is known already.
    pub fn known_hash(&self) -> Option<u64> {
        Some(self.hash.get()).filter(|hash| *hash != 0)
    }

    /// Notes the hash of a text that is not empty, which the caller has computed as `ByteHasher` does.
    pub fn note_hash(&self, hash: u64) {
        self.hash.set(hash.max(1));
    }

    /// Character number `index`.
    pub fn char_at(&self, index: usize) -> Option<char> {
        self.as_str()[self.byte_offset(index)..].chars().next()
    }

    /// Number of characters before byte `offset`.
    pub fn char_index(&self, offset: usize) -> usize {
        match &self.text {
            StrRepr::Ascii(_) => offset,
            StrRepr::Wide(wide) => wide.char_index(offset),
        }
    }

    /// The characters from `start` up to `end` (in characters, both within the length).
    pub fn slice(&self, start: usize, end: usize) -> &str {
        if start >= end {
            return "";
        }
        &self.as_str()[self.byte_offset(start)..self.byte_offset(end)]
    }

    /// The hash; 0 for the empty text only, as in CPython.
    #[inline]
    pub fn hash(&self) -> u64 {
        let known = self.hash.get();
        if known != 0 || self.is_empty() {
            return known;
        }
        let hash = hash_bytes(self.as_str().as_bytes()).max(1);
        self.hash.set(hash);
        hash
    }

    /// Appends in place; the caller holds the only reference.
    pub fn push_str(&mut self, more: &Str) {
        self.hash.set(0);
        match &mut self.text {
            StrRepr::Ascii(text) if more.is_ascii() => text.push_str(more.as_str()),
            StrRepr::Ascii(text) => {
                let mut text = std::mem::take(text);
                let chars = text.len() + more.len();
                text.push_str(more.as_str());
                self.text = StrRepr::new(text, chars);
            }
            StrRepr::Wide(wide) => wide.push_str(more),
        }
    }
}

impl WideText {
    fn byte_offset(&self, index: usize) -> usize {
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

    fn char_index(&self, offset: usize) -> usize {
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

    /// None for a short text, which is read from its beginning.
    fn marks(&self) -> Option<&CharIndex> {
        (self.chars > MARK_STEP).then(|| {
            let marks = self.marks.get_or_init(|| {
                let mut marks = CharIndex::default();
                marks.extend(&self.text);
                Box::new(marks)
            });
            &**marks
        })
    }

    fn mark<E>(
        &self,
        piece: usize,
        between: &mut dyn FnMut(usize) -> Result<(), E>,
    ) -> Result<(), E> {
        if self.marks.get().is_some() {
            return Ok(());
        }
        let mut marks = CharIndex::default();
        let mut end = 0;
        while end < self.text.len() {
            end = self
                .text
                .ceil_char_boundary((end + piece).min(self.text.len()));
            marks.extend(&self.text[..end]);
            between(piece)?;
        }
        // Another thread may have been as quick.
        let _ = self.marks.set(Box::new(marks));
        Ok(())
    }

    fn push_str(&mut self, more: &Str) {
        self.text.push_str(more.as_str());
        self.chars += more.len();
        if let Some(marks) = self.marks.get_mut() {
            marks.extend(&self.text);
        }
    }
}

/// Hash of a byte string: eight bytes at a time, multiply and fold. That of the empty one is 0.
pub fn hash_bytes(bytes: &[u8]) -> u64 {
    if bytes.is_empty() {
        return 0;
    }
    let mut hashing = ByteHasher::new(bytes.len());
    hashing.add(bytes);
    hashing.finish()
}

/// The hash of a byte string, piece by piece.
pub struct ByteHasher(u64);

impl ByteHasher {
    /// Bytes that go into it at once; every piece but the last has a multiple of them.
    pub const UNIT: usize = 8;
    const K: u64 = 0x9E37_79B9_7F4A_7C15;

    /// For a byte string of this length.
    pub fn new(length: usize) -> Self {
        ByteHasher(Self::K ^ length as u64)
    }

    #[inline(always)]
    fn fold(&mut self, word: u64) {
        let product = u128::from(self.0 ^ word) * u128::from(Self::K);
        self.0 = (product as u64) ^ ((product >> 64) as u64);
    }

    /// Adds the next piece.
    #[inline]
    pub fn add(&mut self, bytes: &[u8]) {
        let mut chunks = bytes.chunks_exact(Self::UNIT);
        for chunk in &mut chunks {
            let mut word = [0; 8];
            word.copy_from_slice(chunk);
            self.fold(u64::from_le_bytes(word));
        }
        let rest = chunks.remainder();
        if !rest.is_empty() {
            let mut word = [0; 8];
            word[..rest.len()].copy_from_slice(rest);
            self.fold(u64::from_le_bytes(word));
        }
    }

    /// The hash.
    pub fn finish(self) -> u64 {
        self.0
    }
}
