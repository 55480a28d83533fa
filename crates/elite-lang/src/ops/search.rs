//! Finding bytes in bytes, and so text in text, in pieces with a safepoint after each. Single bytes are by far the
//! commonest separators.
//!
//! Most parts are found by `memchr`'s algorithms, window by window; for very long parts, whose tables alone would take
//! milliseconds, there is a search of our own that needs none (Crochemore and Perrin 1991, two-way string matching).

use std::ops::Range;

use memchr::{memchr, memmem, memrchr};

use crate::eval::Evaluator;
use crate::eval::bulk::{BULK_CHUNK, bulk_work};
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
    Long,
}

impl<'d> Occurrences<'d> {
    /// The places of `part`, which is not empty, from the beginning on.
    pub fn new(data: &'d [u8], part: &'d [u8]) -> Self {
        let finder = match part {
            [byte] => Finder::Byte(*byte),
            part if part.len() > BULK_CHUNK => Finder::Long,
            part => Finder::Forward(Box::new(memmem::Finder::new(part))),
        };
        Self::with(data, part, finder)
    }

    /// The places of `part`, which is not empty, from the end on.
    pub fn from_end(data: &'d [u8], part: &'d [u8]) -> Self {
        let finder = match part {
            [byte] => Finder::Byte(*byte),
            part if part.len() > BULK_CHUNK => Finder::Long,
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
            let end = self.to.min(begin.saturating_add(BULK_CHUNK + length - 1));
            let window = &self.data[begin..end];
            let found = match &self.finder {
                Finder::Byte(byte) => memchr(*byte, window),
                Finder::Forward(finder) => finder.find(window),
                Finder::Long | Finder::Backward(_) => {
                    let found = find_long(ev, self.part, &self.data[begin..self.to], false)?;
                    self.from = found.map_or(self.to, |at| begin + at + length);
                    return Ok(found.map(|at| begin + at));
                }
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
            let begin = self.from.max(end.saturating_sub(BULK_CHUNK + length - 1));
            let window = &self.data[begin..end];
            let found = match &self.finder {
                Finder::Byte(byte) => memrchr(*byte, window),
                Finder::Backward(finder) => finder.rfind(window),
                Finder::Long | Finder::Forward(_) => {
                    let found = find_long(ev, self.part, &self.data[self.from..end], true)?;
                    self.to = found.map_or(self.from, |at| self.from + at);
                    return Ok(found.map(|at| self.from + at));
                }
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

/// Counts the steps of a search.
struct StepCounter<'s, 'y> {
    ev: &'s Evaluator<'y>,
    steps: usize,
}

impl StepCounter<'_, '_> {
    #[inline]
    fn step(&mut self) -> R<()> {
        self.steps += 1;
        if self.steps.is_multiple_of(1024) {
            self.ev.charge(1024 * 2)?;
        }
        Ok(())
    }
}

/// The first or the last occurrence of a long part.
fn find_long(ev: &Evaluator<'_>, part: &[u8], data: &[u8], last: bool) -> R<Option<usize>> {
    let steps = StepCounter { ev, steps: 0 };
    let (m, n) = (part.len(), data.len());
    if last {
        let found = two_way(steps, (m, |i| part[m - 1 - i]), (n, |i| data[n - 1 - i]))?;
        return Ok(found.map(|at| n - at - m));
    }
    two_way(steps, (m, |i| part[i]), (n, |i| data[i]))
}

/// Where the greatest suffix of the part begins, in the order of bytes or the opposite one, and its period.
fn greatest_suffix(
    steps: &mut StepCounter<'_, '_>,
    length: usize,
    part: &impl Fn(usize) -> u8,
    opposite: bool,
) -> R<(usize, usize)> {
    let (mut suffix, mut at, mut ahead, mut period) = (0, 1, 0, 1);
    while at + ahead < length {
        steps.step()?;
        let (new, old) = (part(at + ahead), part(suffix + ahead));
        if new == old {
            ahead += 1;
            if ahead == period {
                at += period;
                ahead = 0;
            }
        } else if (new < old) != opposite {
            at += ahead + 1;
            ahead = 0;
            period = at - suffix;
        } else {
            suffix = at;
            at += 1;
            ahead = 0;
            period = 1;
        }
    }
    Ok((suffix, period))
}

fn two_way(
    mut steps: StepCounter<'_, '_>,
    (m, part): (usize, impl Fn(usize) -> u8),
    (n, data): (usize, impl Fn(usize) -> u8),
) -> R<Option<usize>> {
    if m > n {
        return Ok(None);
    }
    let one = greatest_suffix(&mut steps, m, &part, false)?;
    let other = greatest_suffix(&mut steps, m, &part, true)?;
    let (cut, period) = if one.0 > other.0 { one } else { other };
    let mut repeats = period + cut <= m;
    let mut index = 0;
    while repeats && index < cut {
        steps.step()?;
        repeats = part(index) == part(index + period);
        index += 1;
    }
    let period = if repeats {
        period
    } else {
        cut.max(m - cut) + 1
    };
    // How much of the part is known to fit already.
    let (mut at, mut known) = (0, 0);
    while at <= n - m {
        let mut right = cut.max(known);
        while right < m && part(right) == data(at + right) {
            steps.step()?;
            right += 1;
        }
        steps.step()?;
        if right < m {
            at += right - cut + 1;
            known = 0;
            continue;
        }
        let mut left = cut;
        while left > known && part(left - 1) == data(at + left - 1) {
            steps.step()?;
            left -= 1;
        }
        if left <= known {
            return Ok(Some(at));
        }
        at += period;
        known = if repeats { m - period } else { 0 };
    }
    Ok(None)
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
                    assert_eq!(find_long(ev, bytes, data, false)?, text.find(part));
                    assert_eq!(find_long(ev, bytes, data, true)?, text.rfind(part));
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

    #[test]
    fn long_parts_are_found_in_texts_of_few_letters() {
        evaluate(|ev| {
            // All texts of two letters up to some length, so that every kind of period occurs.
            let texts = |longest: u32| {
                (1..=longest).flat_map(|length| {
                    (0..1u32 << length).map(move |bits| {
                        (0..length).map(|i| b'a' + (bits >> i & 1) as u8).collect()
                    })
                })
            };
            let datas: Vec<Vec<u8>> = texts(9).step_by(3).collect();
            for part in texts(6) {
                let part: Vec<u8> = part;
                for data in &datas {
                    let found = data.windows(part.len()).position(|window| window == part);
                    assert_eq!(
                        find_long(ev, &part, data, false)?,
                        found,
                        "{part:?} {data:?}"
                    );
                    let found = data.windows(part.len()).rposition(|window| window == part);
                    assert_eq!(
                        find_long(ev, &part, data, true)?,
                        found,
                        "{part:?} {data:?}"
                    );
                }
            }
            Ok(())
        });
    }
}
