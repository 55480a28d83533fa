//! Bulk work of natives on texts and bytes: copied, mapped and looked through in pieces, with a safepoint after each.
//!
//! This is the one way for a native to go through data of any length. What it works on must not be borrowed from
//! anything scripts can change: texts and bytes never change, of a bytearray it takes a `snapshot`. The functions here
//! ask the memory account for what they make.

use std::rc::Rc;

use crate::eval::Evaluator;
use crate::limits::yielding::YIELD_BUDGET;
use crate::value::{R, Str, Value};

/// Work for a byte or a character that is looked at by itself.
pub const WORK_PER_BYTE: usize = 8;
/// Bytes between two safepoints where each is looked at by itself.
pub const CHUNK: usize = YIELD_BUDGET / WORK_PER_BYTE / 2;
/// Bytes between two safepoints where they are copied, compared or searched many at once.
pub const BULK_CHUNK: usize = YIELD_BUDGET;

/// Work for bytes that are copied, compared or searched many at once.
pub const fn bulk_work(bytes: usize) -> usize {
    bytes / 4
}

/// The pieces of a text, cut between characters.
pub fn pieces(text: &str) -> impl Iterator<Item = &str> {
    chunks_of(text, CHUNK)
}

fn chunks_of(text: &str, size: usize) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        let (piece, after) = rest.split_at(rest.floor_char_boundary(size));
        rest = after;
        (!piece.is_empty()).then_some(piece)
    })
}

impl Evaluator<'_> {
    /// What `map` appends for each piece of a text. The pieces are cut anywhere, so it must not matter to it where.
    pub fn map_text(&self, text: &str, mut map: impl FnMut(&str, &mut String)) -> R<String> {
        let mut out = String::new();
        self.grow(&mut out, text.len())?;
        for piece in pieces(text) {
            self.grow(&mut out, piece.len())?;
            map(piece, &mut out);
            self.charge(piece.len() * WORK_PER_BYTE)?;
        }
        Ok(out)
    }

    /// What `map` appends for each piece of bytes.
    pub fn map_bytes(&self, data: &[u8], mut map: impl FnMut(&[u8], &mut Vec<u8>)) -> R<Vec<u8>> {
        let mut out = Vec::new();
        self.grow(&mut out, data.len())?;
        for piece in data.chunks(CHUNK) {
            self.grow(&mut out, piece.len())?;
            map(piece, &mut out);
            self.charge(piece.len() * WORK_PER_BYTE)?;
        }
        Ok(out)
    }

    /// Whether all characters pass a test.
    pub fn all_chars(&self, text: &str, test: impl Fn(char) -> bool) -> R<bool> {
        for piece in pieces(text) {
            if !piece.chars().all(&test) {
                return Ok(false);
            }
            self.charge(piece.len() * WORK_PER_BYTE)?;
        }
        Ok(true)
    }

    /// Whether all bytes pass a test.
    pub fn all_bytes(&self, data: &[u8], test: impl Fn(&u8) -> bool) -> R<bool> {
        for piece in data.chunks(CHUNK) {
            if !piece.iter().all(&test) {
                return Ok(false);
            }
            self.charge(piece.len() * WORK_PER_BYTE)?;
        }
        Ok(true)
    }

    /// The first byte that passes a test, which is asked of each in turn.
    pub fn position(&self, data: &[u8], mut test: impl FnMut(u8) -> bool) -> R<Option<usize>> {
        for (piece, start) in data.chunks(CHUNK).zip((0..).step_by(CHUNK)) {
            if let Some(at) = piece.iter().position(|byte| test(*byte)) {
                return Ok(Some(start + at));
            }
            self.charge(piece.len() * WORK_PER_BYTE)?;
        }
        Ok(None)
    }

    /// The first `count` characters of a text, or all if it has fewer.
    pub fn char_prefix<'t>(&self, text: &'t str, count: usize) -> R<&'t str> {
        if text.len() <= count {
            return Ok(text);
        }
        let (mut at, mut left) = (0, count);
        for piece in pieces(text) {
            let chars = piece.chars().count();
            if chars > left {
                let end = piece.char_indices().nth(left).map_or(0, |(end, _)| end);
                return Ok(&text[..at + end]);
            }
            (at, left) = (at + piece.len(), left - chars);
            self.charge(piece.len() * WORK_PER_BYTE)?;
        }
        Ok(text)
    }

    /// Bytes at the beginning of a text whose characters all pass a test.
    pub fn prefix_len(&self, text: &str, test: impl Fn(char) -> bool) -> R<usize> {
        let mut length = 0;
        for piece in pieces(text) {
            let kept = piece.trim_start_matches(&test);
            length += piece.len() - kept.len();
            if !kept.is_empty() {
                break;
            }
            self.charge(piece.len() * WORK_PER_BYTE)?;
        }
        Ok(length)
    }

    /// Bytes at the end of a text whose characters all pass a test.
    pub fn suffix_len(&self, text: &str, test: impl Fn(char) -> bool) -> R<usize> {
        let mut rest = text;
        while !rest.is_empty() {
            let piece = &rest[rest.floor_char_boundary(rest.len().saturating_sub(CHUNK))..];
            let kept = piece.trim_end_matches(&test);
            rest = &rest[..rest.len() - piece.len() + kept.len()];
            if !kept.is_empty() {
                break;
            }
            self.charge(piece.len() * WORK_PER_BYTE)?;
        }
        Ok(text.len() - rest.len())
    }

    /// Appends a text to another.
    #[inline]
    pub fn push_text(&self, out: &mut String, text: &str) -> R<()> {
        self.grow(out, text.len())?;
        if text.len() <= BULK_CHUNK {
            out.push_str(text);
            return self.charge(bulk_work(text.len()));
        }
        for piece in chunks_of(text, BULK_CHUNK) {
            out.push_str(piece);
            self.charge(bulk_work(piece.len()))?;
        }
        Ok(())
    }

    /// Appends bytes to others.
    #[inline]
    pub fn push_bytes(&self, out: &mut Vec<u8>, data: &[u8]) -> R<()> {
        self.grow(out, data.len())?;
        if data.len() <= BULK_CHUNK {
            out.extend_from_slice(data);
            return self.charge(bulk_work(data.len()));
        }
        for piece in data.chunks(BULK_CHUNK) {
            out.extend_from_slice(piece);
            self.charge(bulk_work(piece.len()))?;
        }
        Ok(())
    }

    /// A copy of a text.
    #[inline]
    pub fn copy_text(&self, text: &str) -> R<String> {
        let mut out = String::new();
        self.push_text(&mut out, text)?;
        Ok(out)
    }

    /// A copy of bytes.
    pub fn copy_bytes(&self, data: &[u8]) -> R<Vec<u8>> {
        let mut out = Vec::new();
        self.push_bytes(&mut out, data)?;
        Ok(out)
    }

    /// Appends a text `count` times.
    pub fn push_repeated(&self, out: &mut String, text: &str, count: usize) -> R<()> {
        self.grow(out, text.len().saturating_mul(count))?;
        let times = (BULK_CHUNK / text.len().max(1)).clamp(1, count.max(1));
        if count == 0 || times == 1 {
            return (0..count).try_for_each(|_| self.push_text(out, text));
        }
        let unit = text.repeat(times);
        for _ in 0..count / times {
            self.push_text(out, &unit)?;
        }
        self.push_text(out, &unit[..count % times * text.len()])
    }

    /// Bytes `count` times over.
    pub fn repeat_bytes(&self, data: &[u8], count: usize) -> R<Vec<u8>> {
        let mut out = Vec::new();
        self.grow(&mut out, data.len().saturating_mul(count))?;
        let times = (BULK_CHUNK / data.len().max(1)).clamp(1, count.max(1));
        if count == 0 || times == 1 {
            (0..count).try_for_each(|_| self.push_bytes(&mut out, data))?;
            return Ok(out);
        }
        let unit = data.repeat(times);
        for _ in 0..count / times {
            self.push_bytes(&mut out, &unit)?;
        }
        self.push_bytes(&mut out, &unit[..count % times * data.len()])?;
        Ok(out)
    }

    /// A text as a string.
    #[inline]
    pub fn new_str(&self, text: String) -> R {
        if text.len() <= BULK_CHUNK {
            self.charge(bulk_work(text.len()))?;
            return Ok(Value::str(text));
        }
        let chars = self.count_chars(&text)?;
        Ok(Value::Str(Rc::new(Str::with_char_count(text, chars))))
    }

    /// A copy of a part of a text as a string.
    pub fn new_str_from(&self, part: &str) -> R {
        if part.len() <= BULK_CHUNK {
            self.charge(bulk_work(part.len()))?;
            return Ok(Value::str(part));
        }
        self.new_str(self.copy_text(part)?)
    }

    /// Number of characters of a text.
    pub fn count_chars(&self, text: &str) -> R<usize> {
        let mut chars = 0;
        for piece in chunks_of(text, BULK_CHUNK) {
            chars += piece.chars().count();
            self.charge(bulk_work(piece.len()))?;
        }
        Ok(chars)
    }

    /// Learns where the characters of a long text are, before anything asks for one by its number.
    #[inline]
    pub fn index_chars(&self, text: &Str) -> R<()> {
        if text.is_ascii() || text.as_str().len() <= CHUNK {
            return Ok(());
        }
        text.build_char_index(CHUNK, &mut |bytes| self.charge(bytes * WORK_PER_BYTE))
    }

    /// The bytes of a text read as Latin-1.
    pub fn to_latin1(&self, text: &str) -> R<Vec<u8>> {
        let mut out = Vec::new();
        self.grow(&mut out, text.len())?;
        for piece in pieces(text) {
            out.extend(piece.chars().map(|c| c as u32 as u8));
            self.charge(piece.len() * WORK_PER_BYTE)?;
        }
        Ok(out)
    }

    /// The text that bytes are in Latin-1.
    pub fn decode_latin1(&self, data: &[u8]) -> R<String> {
        let mut out = String::new();
        self.grow(&mut out, data.len())?;
        for piece in data.chunks(CHUNK) {
            self.grow(&mut out, piece.len() * 2)?;
            out.extend(piece.iter().map(|byte| char::from(*byte)));
            self.charge(piece.len() * WORK_PER_BYTE)?;
        }
        Ok(out)
    }

    /// The text that bytes are in UTF-8, with marks where they are not.
    pub fn decode_utf8_lossy(&self, data: &[u8]) -> R<String> {
        let mut out = String::new();
        self.grow(&mut out, data.len())?;
        let mut rest = data;
        while !rest.is_empty() {
            // A character that may be cut in two is left for the next piece.
            let mut end = rest.len().min(CHUNK);
            while end < rest.len() && end > CHUNK - 4 && rest[end] & 0xC0 == 0x80 {
                end -= 1;
            }
            let (piece, after) = rest.split_at(end);
            let text = String::from_utf8_lossy(piece);
            self.grow(&mut out, text.len())?;
            out.push_str(&text);
            self.charge(piece.len() * WORK_PER_BYTE)?;
            rest = after;
        }
        Ok(out)
    }

    /// The order of two byte strings; that of texts is the same.
    #[inline]
    pub fn cmp_bytes(&self, a: &[u8], b: &[u8]) -> R<std::cmp::Ordering> {
        if a.len().min(b.len()) <= BULK_CHUNK {
            return Ok(a.cmp(b));
        }
        for (x, y) in a.chunks(BULK_CHUNK).zip(b.chunks(BULK_CHUNK)) {
            let order = x.cmp(y);
            if order.is_ne() {
                // Where one of them ends, the shorter piece is the lesser one, as the whole is.
                return Ok(order);
            }
            self.charge(bulk_work(x.len()))?;
        }
        Ok(a.len().cmp(&b.len()))
    }

    /// Whether two byte strings are equal.
    #[inline]
    pub fn bytes_equal(&self, a: &[u8], b: &[u8]) -> R<bool> {
        if a.len() != b.len() || a.len() <= BULK_CHUNK {
            return Ok(a == b);
        }
        for (a, b) in a.chunks(BULK_CHUNK).zip(b.chunks(BULK_CHUNK)) {
            if a != b {
                return Ok(false);
            }
            self.charge(bulk_work(a.len()))?;
        }
        Ok(true)
    }
}
