//! Bulk work of natives on texts and bytes: copied, mapped and looked through in pieces, with a safepoint after each.
//!
//! This is the one way for a native to go through data of any length. What it works on must not be borrowed from
//! anything scripts can change: texts and bytes never change, of a bytearray it takes a `snapshot`. The functions here
//! ask the memory account for what they make.

use std::rc::Rc;

use super::Evaluator;
use super::pace::WORK_MAX;
use crate::value::{R, Str, Value};

/// Work for a byte or a character that is looked at by itself.
pub const EACH: usize = 8;
/// Bytes between two safepoints where each is looked at by itself.
pub const PIECE: usize = WORK_MAX / EACH / 2;
/// Bytes between two safepoints where they are copied, compared or searched many at once.
pub const STRIDE: usize = WORK_MAX;

/// Work for bytes that are copied, compared or searched many at once.
pub const fn many(bytes: usize) -> usize {
    bytes / 4
}

/// The pieces of a text, cut between characters.
pub fn pieces(text: &str) -> impl Iterator<Item = &str> {
    cut(text, PIECE)
}

fn cut(text: &str, size: usize) -> impl Iterator<Item = &str> {
    let mut rest = text;
    std::iter::from_fn(move || {
        let (piece, after) = rest.split_at(rest.floor_char_boundary(size));
        rest = after;
        (!piece.is_empty()).then_some(piece)
    })
}

impl Evaluator<'_> {
    /// What `map` appends for each piece of a text. The pieces are cut anywhere, so it must not matter to it where.
    pub fn mapped_text(&self, text: &str, mut map: impl FnMut(&str, &mut String)) -> R<String> {
        let mut out = String::new();
        self.grow(&mut out, text.len())?;
        for piece in pieces(text) {
            self.grow(&mut out, piece.len())?;
            map(piece, &mut out);
            self.worked(piece.len() * EACH)?;
        }
        Ok(out)
    }

    /// What `map` appends for each piece of bytes.
    pub fn mapped_bytes(
        &self,
        data: &[u8],
        mut map: impl FnMut(&[u8], &mut Vec<u8>),
    ) -> R<Vec<u8>> {
        let mut out = Vec::new();
        self.grow(&mut out, data.len())?;
        for piece in data.chunks(PIECE) {
            self.grow(&mut out, piece.len())?;
            map(piece, &mut out);
            self.worked(piece.len() * EACH)?;
        }
        Ok(out)
    }

    /// Whether all characters pass a test.
    pub fn all_chars(&self, text: &str, test: impl Fn(char) -> bool) -> R<bool> {
        for piece in pieces(text) {
            if !piece.chars().all(&test) {
                return Ok(false);
            }
            self.worked(piece.len() * EACH)?;
        }
        Ok(true)
    }

    /// Whether all bytes pass a test.
    pub fn all_bytes(&self, data: &[u8], test: impl Fn(&u8) -> bool) -> R<bool> {
        for piece in data.chunks(PIECE) {
            if !piece.iter().all(&test) {
                return Ok(false);
            }
            self.worked(piece.len() * EACH)?;
        }
        Ok(true)
    }

    /// The first byte that passes a test, which is asked of each in turn.
    pub fn position(&self, data: &[u8], mut test: impl FnMut(u8) -> bool) -> R<Option<usize>> {
        for (piece, start) in data.chunks(PIECE).zip((0..).step_by(PIECE)) {
            if let Some(at) = piece.iter().position(|byte| test(*byte)) {
                return Ok(Some(start + at));
            }
            self.worked(piece.len() * EACH)?;
        }
        Ok(None)
    }

    /// The first `count` characters of a text, or all if it has fewer.
    pub fn first_chars<'t>(&self, text: &'t str, count: usize) -> R<&'t str> {
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
            self.worked(piece.len() * EACH)?;
        }
        Ok(text)
    }

    /// Bytes at the beginning of a text whose characters all pass a test.
    pub fn leading(&self, text: &str, test: impl Fn(char) -> bool) -> R<usize> {
        let mut length = 0;
        for piece in pieces(text) {
            let kept = piece.trim_start_matches(&test);
            length += piece.len() - kept.len();
            if !kept.is_empty() {
                break;
            }
            self.worked(piece.len() * EACH)?;
        }
        Ok(length)
    }

    /// Bytes at the end of a text whose characters all pass a test.
    pub fn trailing(&self, text: &str, test: impl Fn(char) -> bool) -> R<usize> {
        let mut rest = text;
        while !rest.is_empty() {
            let piece = &rest[rest.floor_char_boundary(rest.len().saturating_sub(PIECE))..];
            let kept = piece.trim_end_matches(&test);
            rest = &rest[..rest.len() - piece.len() + kept.len()];
            if !kept.is_empty() {
                break;
            }
            self.worked(piece.len() * EACH)?;
        }
        Ok(text.len() - rest.len())
    }

    /// Appends a text to another.
    #[inline]
    pub fn push_text(&self, out: &mut String, text: &str) -> R<()> {
        self.grow(out, text.len())?;
        if text.len() <= STRIDE {
            out.push_str(text);
            return self.worked(many(text.len()));
        }
        for piece in cut(text, STRIDE) {
            out.push_str(piece);
            self.worked(many(piece.len()))?;
        }
        Ok(())
    }

    /// Appends bytes to others.
    #[inline]
    pub fn push_bytes(&self, out: &mut Vec<u8>, data: &[u8]) -> R<()> {
        self.grow(out, data.len())?;
        if data.len() <= STRIDE {
            out.extend_from_slice(data);
            return self.worked(many(data.len()));
        }
        for piece in data.chunks(STRIDE) {
            out.extend_from_slice(piece);
            self.worked(many(piece.len()))?;
        }
        Ok(())
    }

    /// A copy of a text.
    #[inline]
    pub fn copied_text(&self, text: &str) -> R<String> {
        let mut out = String::new();
        self.push_text(&mut out, text)?;
        Ok(out)
    }

    /// A copy of bytes.
    pub fn copied_bytes(&self, data: &[u8]) -> R<Vec<u8>> {
        let mut out = Vec::new();
        self.push_bytes(&mut out, data)?;
        Ok(out)
    }

    /// Appends a text `count` times.
    pub fn push_repeated(&self, out: &mut String, text: &str, count: usize) -> R<()> {
        self.grow(out, text.len().saturating_mul(count))?;
        let times = (STRIDE / text.len().max(1)).clamp(1, count.max(1));
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
    pub fn repeated_bytes(&self, data: &[u8], count: usize) -> R<Vec<u8>> {
        let mut out = Vec::new();
        self.grow(&mut out, data.len().saturating_mul(count))?;
        let times = (STRIDE / data.len().max(1)).clamp(1, count.max(1));
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
    pub fn string(&self, text: String) -> R {
        if text.len() <= STRIDE {
            self.worked(many(text.len()))?;
            return Ok(Value::str(text));
        }
        let chars = self.count_chars(&text)?;
        Ok(Value::Str(Rc::new(Str::counted(text, chars))))
    }

    /// A copy of a part of a text as a string.
    pub fn string_of(&self, part: &str) -> R {
        if part.len() <= STRIDE {
            self.worked(many(part.len()))?;
            return Ok(Value::str(part));
        }
        self.string(self.copied_text(part)?)
    }

    /// Number of characters of a text.
    pub fn count_chars(&self, text: &str) -> R<usize> {
        let mut chars = 0;
        for piece in cut(text, STRIDE) {
            chars += piece.chars().count();
            self.worked(many(piece.len()))?;
        }
        Ok(chars)
    }

    /// Learns where the characters of a long text are, before anything asks for one by its number.
    #[inline]
    pub fn mark(&self, text: &Str) -> R<()> {
        if text.is_ascii() || text.as_str().len() <= PIECE {
            return Ok(());
        }
        text.mark(PIECE, &mut |bytes| self.worked(bytes * EACH))
    }

    /// The bytes of a text read as Latin-1.
    pub fn to_latin1(&self, text: &str) -> R<Vec<u8>> {
        let mut out = Vec::new();
        self.grow(&mut out, text.len())?;
        for piece in pieces(text) {
            out.extend(piece.chars().map(|c| c as u32 as u8));
            self.worked(piece.len() * EACH)?;
        }
        Ok(out)
    }

    /// The text that bytes are in Latin-1.
    pub fn of_latin1(&self, data: &[u8]) -> R<String> {
        let mut out = String::new();
        self.grow(&mut out, data.len())?;
        for piece in data.chunks(PIECE) {
            self.grow(&mut out, piece.len() * 2)?;
            out.extend(piece.iter().map(|byte| char::from(*byte)));
            self.worked(piece.len() * EACH)?;
        }
        Ok(out)
    }

    /// The text that bytes are in UTF-8, with marks where they are not.
    pub fn lossy_text(&self, data: &[u8]) -> R<String> {
        let mut out = String::new();
        self.grow(&mut out, data.len())?;
        let mut rest = data;
        while !rest.is_empty() {
            // A character that may be cut in two is left for the next piece.
            let mut end = rest.len().min(PIECE);
            while end < rest.len() && end > PIECE - 4 && rest[end] & 0xC0 == 0x80 {
                end -= 1;
            }
            let (piece, after) = rest.split_at(end);
            let text = String::from_utf8_lossy(piece);
            self.grow(&mut out, text.len())?;
            out.push_str(&text);
            self.worked(piece.len() * EACH)?;
            rest = after;
        }
        Ok(out)
    }

    /// The order of two byte strings; that of texts is the same.
    #[inline]
    pub fn order_of_bytes(&self, a: &[u8], b: &[u8]) -> R<std::cmp::Ordering> {
        if a.len().min(b.len()) <= STRIDE {
            return Ok(a.cmp(b));
        }
        for (x, y) in a.chunks(STRIDE).zip(b.chunks(STRIDE)) {
            let order = x.cmp(y);
            if order.is_ne() {
                // Where one of them ends, the shorter piece is the lesser one, as the whole is.
                return Ok(order);
            }
            self.worked(many(x.len()))?;
        }
        Ok(a.len().cmp(&b.len()))
    }

    /// Whether two byte strings are equal.
    #[inline]
    pub fn equal_bytes(&self, a: &[u8], b: &[u8]) -> R<bool> {
        if a.len() != b.len() || a.len() <= STRIDE {
            return Ok(a == b);
        }
        for (a, b) in a.chunks(STRIDE).zip(b.chunks(STRIDE)) {
            if a != b {
                return Ok(false);
            }
            self.worked(many(a.len()))?;
        }
        Ok(true)
    }
}
