//! Characters of patterns: sets of them, categories like `\w`, and what counts as the same when case does not matter.

use std::collections::BTreeMap;

use crate::eval::Evaluator;
use crate::ops::unicode;
use crate::value::R;

/// Work to put one character into a set.
const MEMBER: usize = 64;
/// Characters of a range that are folded one by one.
const FOLDED_MAX: u32 = 4096;

/// The characters that count as letters, digits and space, and as equal but for their case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CaseFolding {
    /// Everything is what it is.
    Exact,
    Ascii,
    Unicode,
}

/// What is the same for all characters that differ in case only.
#[inline]
pub(super) fn key(c: u32, case: CaseFolding) -> u32 {
    match case {
        CaseFolding::Exact => c,
        _ if c < 0x80 => u32::from((c as u8).to_ascii_lowercase()),
        CaseFolding::Ascii => c,
        CaseFolding::Unicode => lower(upper(c)),
    }
}

fn lower(c: u32) -> u32 {
    // The one whose small letter is a letter and a mark.
    if c == 0x130 {
        return u32::from(b'i');
    }
    char::from_u32(c).map_or(c, |c| single_char(c, c.to_lowercase()))
}

fn upper(c: u32) -> u32 {
    char::from_u32(c).map_or(c, |c| single_char(c, c.to_uppercase()))
}

/// Another form of a character, if that is one character as well.
fn single_char(c: char, mut form: impl Iterator<Item = char>) -> u32 {
    match (form.next(), form.next()) {
        (Some(form), None) => form as u32,
        _ => c as u32,
    }
}

/// Categories, by the code of a character.
pub(super) mod decoded {
    use super::{CaseFolding, unicode};

    pub(in super::super) fn is_word(c: u32, case: CaseFolding) -> bool {
        match char::from_u32(c) {
            Some(c) if c.is_ascii() || case != CaseFolding::Unicode => {
                c == '_' || c.is_ascii_alphanumeric()
            }
            Some(c) => unicode::is_letter(c) || unicode::is_numeric(c),
            None => false,
        }
    }

    pub(super) fn is_digit(c: u32, case: CaseFolding) -> bool {
        match char::from_u32(c) {
            Some(c) if case == CaseFolding::Unicode => unicode::decimal(c).is_some(),
            Some(c) => c.is_ascii_digit(),
            None => false,
        }
    }

    pub(super) fn is_blank(c: u32, case: CaseFolding) -> bool {
        match char::from_u32(c) {
            Some(c) if case == CaseFolding::Unicode => {
                c.is_whitespace() || matches!(c, '\u{1c}'..='\u{1f}')
            }
            Some(c) => matches!(c, ' ' | '\t'..='\r'),
            None => false,
        }
    }
}

/// The categories that `\d`, `\D` and so on stand for, as a set of bits.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Categories(u8);

impl Categories {
    /// By the letter after the backslash.
    pub(super) fn of(letter: char) -> Option<Categories> {
        let place = "dDsSwW".find(letter)?;
        Some(Categories(1 << place))
    }

    pub(super) fn add(&mut self, other: Categories) {
        self.0 |= other.0;
    }

    fn have(self, c: u32, case: CaseFolding) -> bool {
        let tests = [decoded::is_digit, decoded::is_blank, decoded::is_word];
        self.0 != 0
            && tests.iter().enumerate().any(|(place, test)| {
                let [yes, no] = [0, 1].map(|not| self.0 >> (2 * place + not) & 1 != 0);
                (yes || no) && if test(c, case) { yes } else { no }
            })
    }
}

/// The sets of a pattern. What lies beyond a byte is in one list for all of them.
#[derive(Default)]
pub(super) struct CharClasses {
    sets: Vec<CharClass>,
    ranges: Vec<(u32, u32)>,
}

struct CharClass {
    /// The answer for all characters below 256.
    low: [u64; 4],
    /// Where the set has its ranges in the list of all sets: first index, and the index behind the last.
    from: u32,
    to: u32,
    categories: Categories,
    /// What categories mean.
    of: CaseFolding,
    /// The folding by which characters count as equal.
    same: CaseFolding,
    negated: bool,
}

/// A set while it is read.
pub(super) struct CharClassBuilder {
    pub(super) negated: bool,
    pub(super) categories: Categories,
    /// What categories mean.
    pub(super) of: CaseFolding,
    /// The folding by which characters count as equal.
    pub(super) same: CaseFolding,
    /// Ranges by their first characters; none touches another.
    ranges: BTreeMap<u32, u32>,
}

impl CharClassBuilder {
    pub(super) fn new(of: CaseFolding, same: CaseFolding) -> CharClassBuilder {
        CharClassBuilder {
            negated: false,
            categories: Categories::default(),
            of,
            same,
            ranges: BTreeMap::new(),
        }
    }

    /// The characters from `low` to `high`.
    pub(super) fn add(&mut self, ev: &Evaluator<'_>, low: u32, high: u32) -> R<()> {
        self.put(low, high);
        if self.same != CaseFolding::Exact && high - low < FOLDED_MAX {
            for c in low..=high {
                let folded = key(c, self.same);
                self.put(folded, folded);
                ev.charge(MEMBER)?;
            }
        }
        ev.check_allocation(size_of::<(u32, u32)>())?;
        ev.charge(MEMBER)
    }

    fn put(&mut self, low: u32, high: u32) {
        let (mut low, mut high) = (low, high);
        // Ranges that begin before the end of the new one and do not end before its begin become a part of it.
        while let Some((from, to)) = self.ranges.range(..=high.saturating_add(1)).next_back() {
            if to.saturating_add(1) < low {
                break;
            }
            let from = *from;
            (low, high) = (low.min(from), high.max(*to));
            self.ranges.remove(&from);
        }
        self.ranges.insert(low, high);
    }
}

impl CharClasses {
    /// Keeps a set; its number.
    pub(super) fn keep(&mut self, ev: &Evaluator<'_>, new: CharClassBuilder) -> R<u32> {
        let from = self.ranges.len();
        ev.grow(&mut self.ranges, new.ranges.len())?;
        for range in new.ranges {
            self.ranges.push(range);
            ev.charge(MEMBER)?;
        }
        let mut set = CharClass {
            low: [0; 4],
            from: from as u32,
            to: self.ranges.len() as u32,
            categories: new.categories,
            of: new.of,
            same: new.same,
            negated: new.negated,
        };
        for c in 0..256u32 {
            if self.finds(&set, c) {
                set.low[(c / 64) as usize] |= 1 << (c % 64);
            }
        }
        ev.charge(256 * MEMBER / 4)?;
        ev.grow(&mut self.sets, 1)?;
        self.sets.push(set);
        Ok(self.sets.len() as u32 - 1)
    }

    /// Whether a set has a character.
    #[inline]
    pub(super) fn have(&self, set: u32, c: u32) -> bool {
        let set = &self.sets[set as usize];
        match c {
            0..256 => set.low[(c / 64) as usize] >> (c % 64) & 1 != 0,
            _ => self.finds(set, c),
        }
    }

    fn finds(&self, set: &CharClass, c: u32) -> bool {
        let one = |c: u32| {
            let ranges = &self.ranges[set.from as usize..set.to as usize];
            let after = ranges.partition_point(|(low, _)| *low <= c);
            (after > 0 && c <= ranges[after - 1].1) || set.categories.have(c, set.of)
        };
        let other_case = || match set.same {
            CaseFolding::Exact => false,
            same => {
                let folded = key(c, same);
                let capital = match same {
                    CaseFolding::Unicode => upper(folded),
                    _ => folded - if (97..123).contains(&folded) { 32 } else { 0 },
                };
                one(folded) || one(capital)
            }
        };
        (one(c) || other_case()) != set.negated
    }
}
