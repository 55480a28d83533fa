//! What a pattern is made into: a flat program of operations that refer to each other by their distance, so that a part
//! of it can be moved while the rest is still being read.
//!
//! The parser writes it, `attempt` and `walk` run it. A repeated group is [`Op::RepeatBegin`], the group,
//! [`Op::RerunTimeline`]; what has to match by itself (look-around, `(?>`) ends with [`Op::CleanupLimit`].

use elite_syntax::surrogate::{char_of, code_of};

use super::letters::{CaseFolding, CharClasses, decoded, key};
use crate::eval::Evaluator;
use crate::value::R;

/// No place in a text.
pub(super) const NOWHERE: usize = usize::MAX;
/// Work for one operation, and for a byte that nothing begins with.
pub(super) const VISIT: usize = 16;
const SKIPPED: usize = 2;
/// Bytes that are skipped between two looks at the clock of `Evaluator::charge`.
const SKIPPED_MAX: usize = 1 << 14;

/// One operation.
#[derive(Clone, Copy, Debug)]
pub(super) enum Op {
    /// A character by its code.
    Char(u32),
    /// A character by what it is when case does not matter.
    Fold(u32, CaseFolding),
    /// A character of set number so and so.
    Set(u32),
    Any,
    NotNewline,
    Assert(Assert),
    /// Goes on here, and so much further on if that fails.
    Split(i32),
    Jump(i32),
    /// The place is the begin or the end of a group.
    Save(u32),
    /// The text that a group has found.
    Reference(u32, CaseFolding),
    /// The character that follows, as often as [`Repeat`] says.
    RepeatSingle(u32),
    /// A repeated group begins; `RerunTimeline` is beyond it.
    RepeatBegin(u32),
    /// A repeated group has ended once more.
    RepeatEnd(u32),
    /// What follows up to `CleanupLimit` is looked for from here, and so is what it does.
    Look(u32),
    /// What follows up to `CleanupLimit` matches in its first way or not at all.
    Atomic,
    Cut,
    /// Goes on here if the group has found something, else so much further on.
    If(u32, i32),
    Match,
}

/// What must be true of a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Assert {
    Start,
    StartOfLine,
    End,
    EndOfLine,
    /// The end, or the line feed before it.
    LastLine,
    Border(CaseFolding),
    NoBorder(CaseFolding),
}

/// How often something is repeated.
#[derive(Clone, Copy, Debug)]
pub(super) struct Repeat {
    pub(super) least: u32,
    /// `u32::MAX` is without end.
    pub(super) most: u32,
    pub(super) greedy: bool,
    /// Operations of the repeated group, without `RepeatBegin` and `RerunTimeline`.
    pub(super) length: u32,
}

/// A look around.
#[derive(Clone, Copy, Debug)]
pub(super) struct LookAround {
    /// Characters that it goes back first.
    pub(super) back: usize,
    pub(super) negated: bool,
    /// Operations up to `CleanupLimit`, without it.
    pub(super) length: u32,
}

/// A program.
#[derive(Default)]
pub(super) struct RegexProgram {
    pub(super) ops: Vec<Op>,
    pub(super) letters: CharClasses,
    pub(super) repeats: Vec<Repeat>,
    pub(super) looks: Vec<LookAround>,
    /// Places that groups begin and end at, the whole included, and the group that has ended last.
    pub(super) slots: usize,
    /// The bytes that a match can begin with; None if it may be empty.
    first: Option<Box<[bool; 256]>>,
}

/// The text that is searched, up to where it counts as ended.
#[derive(Clone, Copy)]
pub(super) enum Haystack<'t> {
    Text(&'t str),
    Bytes(&'t [u8]),
}

impl<'t> Haystack<'t> {
    pub(super) fn data(self) -> &'t [u8] {
        match self {
            Haystack::Text(text) => text.as_bytes(),
            Haystack::Bytes(data) => data,
        }
    }

    pub(super) fn len(self) -> usize {
        self.data().len()
    }

    /// The character at a place and where it ends.
    #[inline]
    pub(super) fn char_at(self, place: usize) -> Option<(u32, usize)> {
        let first = *self.data().get(place)?;
        match self {
            Haystack::Text(text) if first >= 0x80 => {
                let c = text.get(place..)?.chars().next()?;
                Some((code_of(c), place + c.len_utf8()))
            }
            _ => Some((u32::from(first), place + 1)),
        }
    }

    /// The character before a place and where it begins.
    #[inline]
    pub(super) fn char_before(self, place: usize) -> Option<(u32, usize)> {
        let last = *self.data().get(place.checked_sub(1)?)?;
        match self {
            Haystack::Text(text) if last >= 0x80 => {
                let c = text.get(..place)?.chars().next_back()?;
                Some((code_of(c), place - c.len_utf8()))
            }
            _ => Some((u32::from(last), place - 1)),
        }
    }
}

impl RegexProgram {
    /// Whether a character is one that a single operation stands for.
    #[inline]
    pub(super) fn takes(&self, op: Op, c: u32) -> bool {
        match op {
            Op::Char(code) => code == c,
            Op::Fold(code, case) => code == key(c, case),
            Op::Set(set) => self.letters.have(set, c),
            Op::Any => true,
            Op::NotNewline => c != u32::from(b'\n'),
            _ => false,
        }
    }

    /// Whether an operation takes a character, or is the end.
    pub(super) fn is_single(&self, at: usize) -> bool {
        matches!(
            self.ops[at],
            Op::Char(_)
                | Op::Fold(..)
                | Op::Set(_)
                | Op::Any
                | Op::NotNewline
                | Op::RepeatSingle(_)
                | Op::Match
        )
    }

    pub(super) fn holds(&self, assert: Assert, hay: Haystack<'_>, place: usize) -> bool {
        let newline = u32::from(b'\n');
        let is_border = |case| {
            let is_word =
                |c: Option<(u32, usize)>| c.is_some_and(|(c, _)| decoded::is_word(c, case));
            is_word(hay.char_before(place)) != is_word(hay.char_at(place))
        };
        match assert {
            Assert::Start => place == 0,
            Assert::StartOfLine => hay.char_before(place).is_none_or(|(c, _)| c == newline),
            Assert::End => place == hay.len(),
            Assert::EndOfLine => hay.char_at(place).is_none_or(|(c, _)| c == newline),
            Assert::LastLine => match hay.char_at(place) {
                None => true,
                Some((c, end)) => c == newline && end == hay.len(),
            },
            // An empty text has neither, as CPython sees it.
            Assert::Border(case) => hay.len() > 0 && is_border(case),
            Assert::NoBorder(case) => hay.len() > 0 && !is_border(case),
        }
    }

    /// Where a match can begin, from a place on.
    pub(super) fn skip(&self, ev: &Evaluator<'_>, hay: Haystack<'_>, from: usize) -> R<usize> {
        let Some(first) = &self.first else {
            return Ok(from);
        };
        let mut at = from;
        for piece in hay.data()[from..].chunks(SKIPPED_MAX) {
            let skipped = piece.iter().position(|byte| first[usize::from(*byte)]);
            at += skipped.unwrap_or(piece.len());
            ev.charge(skipped.unwrap_or(piece.len()) * SKIPPED)?;
            if skipped.is_some() {
                break;
            }
        }
        Ok(at)
    }

    /// Finds out what a match can begin with.
    pub(super) fn note_first(&mut self, ev: &Evaluator<'_>, is_text: bool) -> R<()> {
        let mut first = Box::new([false; 256]);
        let mut seen: Vec<bool> = Vec::new();
        ev.grow(&mut seen, self.ops.len())?;
        seen.resize(self.ops.len(), false);
        let mut open: Vec<usize> = vec![0];
        while let Some(at) = open.pop() {
            ev.charge(VISIT)?;
            if std::mem::replace(&mut seen[at], true) {
                continue;
            }
            ev.grow(&mut open, 2)?;
            match self.ops[at] {
                Op::Match | Op::Reference(..) => return Ok(()),
                Op::Assert(_) | Op::Save(_) | Op::Atomic | Op::Cut => open.push(at + 1),
                Op::Split(other) | Op::If(_, other) => {
                    open.extend([at + 1, offset_from(at, other)]);
                }
                Op::Jump(to) => open.push(offset_from(at, to)),
                // That it is there or not only makes fewer.
                Op::Look(look) => open.push(at + 2 + self.looks[look as usize].length as usize),
                Op::RepeatSingle(repeat) => {
                    if self.repeats[repeat as usize].most > 0 {
                        self.note_single(self.ops[at + 1], is_text, &mut first);
                    }
                    if self.repeats[repeat as usize].least == 0 {
                        open.push(at + 2);
                    }
                }
                Op::RepeatBegin(repeat) => {
                    let repeat = self.repeats[repeat as usize];
                    open.push(at + 1);
                    if repeat.least == 0 {
                        open.push(at + 2 + repeat.length as usize);
                    }
                }
                Op::RepeatEnd(repeat) => {
                    open.push(at - self.repeats[repeat as usize].length as usize);
                    open.push(at + 1);
                }
                single => self.note_single(single, is_text, &mut first),
            }
        }
        self.first = Some(first);
        Ok(())
    }

    fn note_single(&self, op: Op, is_text: bool, first: &mut [bool; 256]) {
        if let (Op::Char(code), true) = (op, is_text) {
            if let Some(c) = char_of(code) {
                first[usize::from(c.encode_utf8(&mut [0; 4]).as_bytes()[0])] = true;
            }
            return;
        }
        for byte in 0..=255u8 {
            first[usize::from(byte)] |=
                (is_text && byte >= 0x80) || self.takes(op, u32::from(byte));
        }
    }
}

/// The operation so far from another one.
#[inline]
pub(super) fn offset_from(at: usize, by: i32) -> usize {
    at.wrapping_add_signed(by as isize)
}
