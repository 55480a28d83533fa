//! Finding bytes in bytes, and so text in text, in pieces with a safepoint after each. Single bytes are by far the
//! commonest separators.
//!
//! `memchr` searches window by window. A window has room for at least one more occurrence, however long the part is, so
//! that a search takes time in proportion to the data.

use std::ops::Range;

use memchr::{memchr, memmem, memrchr};

use crate::eval::Evaluator;
use crate::limits::chunked::{BULK_CHUNK, bulk_work};
use crate::value::R;

/// Work for an occurrence, beside that for the bytes on the way to it.
const FOUND: usize = 16;

/// The occurrences of a part, from the beginning on or from the end, none within another.
pub struct Occurrences<'d> {
    data: &'d [u8],
    part: &'d [u8],
    finder: Finder<'d>,
    /// What is still to be searched.
    from: usize,
    to: usize,
}

enum Finder<'d> {
    Byte(u8),
    Forward(Box<memmem::Finder<'d>>),
    Backward(Box<memmem::FinderRev<'d>>),
}

impl<'d> Occurrences<'d> {
    /// The places of `part`, which is not empty, from the beginning on.
    pub fn new(data: &'d [u8], part: &'d [u8]) -> Self {
        let finder = match part {
            [byte] => Finder::Byte(*byte),
            part => Finder::Forward(Box::new(memmem::Finder::new(part))),
        };
        Self::with(data, part, finder)
    }

    /// The places of `part`, which is not empty, from the end on.
    pub fn from_end(data: &'d [u8], part: &'d [u8]) -> Self {
        let finder = match part {
            [byte] => Finder::Byte(*byte),
            part => Finder::Backward(Box::new(memmem::FinderRev::new(part))),
        };
        Self::with(data, part, finder)
    }

    fn with(data: &'d [u8], part: &'d [u8], finder: Finder<'d>) -> Self {
        Occurrences {
            data,
            part,
            finder,
            from: 0,
            to: data.len(),
        }
    }

    /// Where the next one begins.
    pub fn next(&mut self, ev: &Evaluator<'_>) -> R<Option<usize>> {
        let length = self.part.len();
        while self.to - self.from >= length {
            let begin = self.from;
            let end = self
                .to
                .min(begin.saturating_add(BULK_CHUNK.max(length) + length - 1));
            let window = &self.data[begin..end];
            let found = match &self.finder {
                Finder::Byte(byte) => memchr(*byte, window),
                Finder::Forward(finder) => finder.find(window),
                Finder::Backward(_) => memmem::find(window, self.part),
            };
            if let Some(at) = found {
                self.from = begin + at + length;
                ev.charge(FOUND + bulk_work(at))?;
                return Ok(Some(begin + at));
            }
            self.from = end - (length - 1);
            ev.charge(bulk_work(window.len()))?;
        }
        Ok(None)
    }

    /// Where the next one from the end begins.
    pub fn next_back(&mut self, ev: &Evaluator<'_>) -> R<Option<usize>> {
        let length = self.part.len();
        while self.to - self.from >= length {
            let end = self.to;
            let begin = self
                .from
                .max(end.saturating_sub(BULK_CHUNK.max(length) + length - 1));
            let window = &self.data[begin..end];
            let found = match &self.finder {
                Finder::Byte(byte) => memrchr(*byte, window),
                Finder::Backward(finder) => finder.rfind(window),
                Finder::Forward(_) => memmem::rfind(window, self.part),
            };
            if let Some(at) = found {
                self.to = begin + at;
                ev.charge(FOUND + bulk_work(window.len() - at))?;
                return Ok(Some(begin + at));
            }
            self.to = begin + (length - 1);
            ev.charge(bulk_work(window.len()))?;
        }
        Ok(None)
    }

    /// How many are left.
    pub fn count(mut self, ev: &Evaluator<'_>) -> R<usize> {
        let mut count = 0;
        while self.next(ev)?.is_some() {
            count += 1;
        }
        Ok(count)
    }
}

impl Evaluator<'_> {
    /// Where `part` occurs first.
    #[inline]
    pub fn find_bytes(&self, data: &[u8], part: &[u8]) -> R<Option<usize>> {
        match part {
            [] => Ok(Some(0)),
            [byte] if data.len() <= BULK_CHUNK => Ok(memchr(*byte, data)),
            part if data.len() <= BULK_CHUNK => Ok(memmem::find(data, part)),
            part => Occurrences::new(data, part).next(self),
        }
    }

    /// Hands out what lies between the first `most` occurrences of `separator`, which is not empty, and the rest; with
    /// `backwards` between the last ones, from the end on.
    pub fn each_between(
        &self,
        data: &[u8],
        separator: &[u8],
        most: usize,
        backwards: bool,
        mut each: impl FnMut(Range<usize>) -> R<()>,
    ) -> R<()> {
        let mut rest = 0..data.len();
        if backwards {
            let mut found = Occurrences::from_end(data, separator);
            for _ in 0..most {
                let Some(at) = found.next_back(self)? else {
                    break;
                };
                each(at + separator.len()..rest.end)?;
                rest.end = at;
            }
        } else {
            let mut found = Occurrences::new(data, separator);
            for _ in 0..most {
                let Some(at) = found.next(self)? else {
                    break;
                };
                each(rest.start..at)?;
                rest.start = at + separator.len();
            }
        }
        each(rest)
    }

    /// Where `part` occurs last.
    #[inline]
    pub fn rfind_bytes(&self, data: &[u8], part: &[u8]) -> R<Option<usize>> {
        match part {
            [] => Ok(Some(data.len())),
            [byte] if data.len() <= BULK_CHUNK => Ok(memrchr(*byte, data)),
            part if data.len() <= BULK_CHUNK => Ok(memmem::rfind(data, part)),
            part => Occurrences::from_end(data, part).next_back(self),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test

    use super::*;
    use crate::trials::evaluate;

    #[test]
    fn parts_are_found_as_the_standard_library_does() {
        evaluate(|ev| {
            let texts = [
                "",
                ",",
                "a,b,,c",
                "ä→ö→ü",
                "aaaa",
                "no separator",
                ",,",
                "abaabaabab",
            ];
            for text in texts {
                for part in [",", "→", "aa", "b,", "x", "ö", "abaab", "aab"] {
                    let (data, bytes) = (text.as_bytes(), part.as_bytes());
                    assert_eq!(ev.find_bytes(data, bytes)?, text.find(part));
                    assert_eq!(ev.rfind_bytes(data, bytes)?, text.rfind(part));
                    let mut all = Vec::new();
                    let mut found = Occurrences::new(data, bytes);
                    while let Some(at) = found.next(ev)? {
                        all.push(at);
                    }
                    let expected: Vec<usize> = text.match_indices(part).map(|at| at.0).collect();
                    assert_eq!(all, expected, "{text:?} {part:?}");
                }
            }
            Ok(())
        });
    }

    /// Windows, and parts longer than one: the borders between them must not matter.
    #[test]
    fn parts_are_found_across_windows() {
        evaluate(|ev| {
            for length in [1, 2, 7, BULK_CHUNK, BULK_CHUNK + 5] {
                let part: Vec<u8> = (0..length).map(|i| b'a' + (i % 7 == 3) as u8).collect();
                for at in [
                    0,
                    1,
                    BULK_CHUNK - 3,
                    BULK_CHUNK,
                    BULK_CHUNK + 9,
                    2 * BULK_CHUNK - 1,
                ] {
                    let mut data = vec![b'.'; at];
                    data.extend(&part);
                    data.resize(3 * BULK_CHUNK + 77, b'.');
                    assert_eq!(ev.find_bytes(&data, &part)?, Some(at), "{length} at {at}");
                    assert_eq!(ev.rfind_bytes(&data, &part)?, Some(at), "{length} at {at}");
                    assert_eq!(Occurrences::new(&data, &part).count(ev)?, 1);
                    let other = [&part[..], b"!"].concat();
                    assert_eq!(ev.find_bytes(&data, &other)?, None);
                    assert_eq!(ev.rfind_bytes(&data, &other)?, None);
                }
            }
            Ok(())
        });
    }
}
