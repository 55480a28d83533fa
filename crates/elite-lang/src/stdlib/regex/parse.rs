//! Python's syntax of regular expressions, made into a [`RegexProgram`].
//!
//! Operations are written as the text is read; what a quantifier or a bar stands behind is moved a little to make room
//! in front of it. Groups keep their numbers; names are kept here. Groups are in
//! `group`, escapes and classes in `escape`.

use std::collections::BTreeMap;
use std::rc::Rc;

use elite_syntax::surrogate::code_of;

use super::letters::{CaseFolding, Categories, key};
use super::program::{Assert, Op, RegexProgram, Repeat};
use crate::eval::Evaluator;
use crate::limits::chunked::{bulk_work, pieces};
use crate::value::Unwind;

/// Python's flags.
pub(super) mod flag {
    pub const IGNORECASE: u32 = 2;
    pub const LOCALE: u32 = 4;
    pub const MULTILINE: u32 = 8;
    pub const DOTALL: u32 = 16;
    pub const UNICODE: u32 = 32;
    pub const VERBOSE: u32 = 64;
    pub const ASCII: u32 = 256;
}

/// Largest number of repetitions.
const REPEAT_MAX: u64 = 100_000;
/// A repetition without end.
const FOREVER: u32 = u32::MAX;
/// Work for one character of a pattern.
const CHARACTER: usize = 64;

/// A pattern that is right.
pub(super) struct ParsedPattern {
    pub program: RegexProgram,
    /// Capturing groups, the whole not counted.
    pub groups: usize,
    /// Names of groups in the order of their numbers.
    pub names: Vec<(Rc<str>, usize)>,
    /// The numbers of the groups by their names.
    pub by_name: BTreeMap<Rc<str>, usize>,
    pub flags: u32,
}

/// The reason for which there is no program.
pub(super) enum PatternError {
    /// What is wrong with the pattern, and at which character.
    Wrong {
        message: String,
        position: Option<usize>,
    },
    /// The thread has been stopped, or there is no memory.
    Unwind(Unwind),
}

impl From<Unwind> for PatternError {
    fn from(raised: Unwind) -> Self {
        PatternError::Unwind(raised)
    }
}

pub(super) type PatternResult<T = ()> = Result<T, PatternError>;

/// The fewest and the most characters that something matches.
pub(super) type Width = (u64, u64);
const ONE: Width = (1, 1);
pub(super) const EMPTY: Width = (0, 0);

pub(super) fn parse(
    ev: &Evaluator<'_>,
    text: &str,
    flags: u32,
    is_bytes: bool,
) -> PatternResult<ParsedPattern> {
    let mut chars = Vec::new();
    ev.grow(&mut chars, text.len())?;
    for piece in pieces(text) {
        chars.extend(piece.chars());
        ev.charge(piece.len() * 4)?;
    }
    let mut parser = PatternParser {
        ev,
        chars,
        at: 0,
        read: 0,
        program: RegexProgram::default(),
        categories: Vec::new(),
        groups: 0,
        widths: vec![EMPTY],
        open: Vec::new(),
        names: Vec::new(),
        by_name: BTreeMap::new(),
        flags,
        is_bytes,
        depth: 0,
        behind: None,
        wanted: None,
        is_loose: false,
    };
    parser.global_flags()?;
    parser.check_flags()?;
    if !is_bytes && parser.flags & flag::ASCII == 0 {
        parser.flags |= flag::UNICODE;
    }
    parser.alternatives()?;
    if parser.at < parser.chars.len() {
        return Err(parser.error("unbalanced parenthesis", Some(parser.at)));
    }
    // All that is wrong only when everything else is right.
    if let Some((group, position)) = parser.wanted.filter(|(group, _)| *group > parser.groups) {
        return Err(parser.error(format!("invalid group reference {group}"), Some(position)));
    }
    if parser.is_loose {
        return Err(parser.error("look-behind requires fixed-width pattern", None));
    }
    parser.emit(Op::Match)?;
    parser.program.slots = 2 * (parser.groups + 1) + 1;
    parser.program.note_first(ev, !is_bytes)?;
    Ok(ParsedPattern {
        program: parser.program,
        groups: parser.groups,
        names: parser.names,
        by_name: parser.by_name,
        flags: parser.flags,
    })
}

pub(super) struct PatternParser<'p, 'y> {
    pub(super) ev: &'p Evaluator<'y>,
    pub(super) chars: Vec<char>,
    pub(super) at: usize,
    /// Characters looked at since the last safepoint.
    read: usize,
    pub(super) program: RegexProgram,
    /// The sets of single categories, by those and by what they mean.
    pub(super) categories: Vec<(Categories, CaseFolding, u32)>,
    pub(super) groups: usize,
    /// Widths of the groups that have ended, by number.
    pub(super) widths: Vec<Width>,
    /// Numbers of the groups around.
    pub(super) open: Vec<usize>,
    pub(super) names: Vec<(Rc<str>, usize)>,
    pub(super) by_name: BTreeMap<Rc<str>, usize>,
    pub(super) flags: u32,
    pub(super) is_bytes: bool,
    pub(super) depth: usize,
    /// Groups there were when the outermost look-behind began.
    pub(super) behind: Option<usize>,
    /// The first condition on a group that there was not yet, and where.
    pub(super) wanted: Option<(usize, usize)>,
    /// A look-behind does not know how far to go back.
    pub(super) is_loose: bool,
}

/// What a quantifier may stand behind.
pub(super) enum PatternItem {
    /// An item that can be repeated, and its width.
    Repeatable(Width),
    /// An item that cannot be repeated.
    Assertion,
    /// A comment, which counts as if it were not there.
    Comment,
}

impl PatternParser<'_, '_> {
    pub(super) fn error(
        &self,
        message: impl Into<String>,
        position: Option<usize>,
    ) -> PatternError {
        PatternError::Wrong {
            message: message.into(),
            position,
        }
    }

    pub(super) fn peek(&self) -> Option<char> {
        self.chars.get(self.at).copied()
    }

    pub(super) fn take(&mut self) -> Option<char> {
        let c = self.peek()?;
        self.at += 1;
        Some(c)
    }

    /// Lets others have their turn; once for every character.
    #[inline]
    pub(super) fn pace(&mut self) -> PatternResult {
        self.read += 1;
        if self.read < 64 {
            return Ok(());
        }
        self.read = 0;
        Ok(self.ev.charge(64 * CHARACTER)?)
    }

    pub(super) fn emit(&mut self, op: Op) -> PatternResult {
        self.ev.grow(&mut self.program.ops, 1)?;
        self.program.ops.push(op);
        Ok(())
    }

    /// Puts an operation in front of what has been written from `at` on.
    pub(super) fn insert(&mut self, at: usize, op: Op) -> PatternResult {
        self.ev.grow(&mut self.program.ops, 1)?;
        self.program.ops.insert(at, op);
        let moved = self.program.ops.len() - at;
        Ok(self.ev.charge(bulk_work(moved * size_of::<Op>()))?)
    }

    /// How many operations have been written since there were `from`.
    pub(super) fn since(&self, from: usize) -> i32 {
        // A pattern has at most 2^20 characters, and each is a few operations.
        (self.program.ops.len() - from) as i32
    }

    fn starts_with(&self, text: &str) -> bool {
        text.chars()
            .enumerate()
            .all(|(i, c)| self.chars.get(self.at + i) == Some(&c))
    }

    pub(super) fn has(&self, flag: u32) -> bool {
        self.flags & flag != 0
    }

    /// What classes like `\w` mean here.
    pub(super) fn class_mode(&self) -> CaseFolding {
        match self.is_bytes || self.has(flag::ASCII) {
            true => CaseFolding::Ascii,
            false => CaseFolding::Unicode,
        }
    }

    /// The folding by which characters count as equal here.
    pub(super) fn folding(&self) -> CaseFolding {
        match self.has(flag::IGNORECASE) {
            true => self.class_mode(),
            false => CaseFolding::Exact,
        }
    }

    fn check_flags(&self) -> PatternResult {
        let known = flag::IGNORECASE
            | flag::LOCALE
            | flag::MULTILINE
            | flag::DOTALL
            | flag::UNICODE
            | flag::VERBOSE
            | flag::ASCII;
        if self.flags & !known != 0 {
            return Err(self.error("these flags are not supported", None));
        }
        let message = match self.is_bytes {
            true if self.has(flag::UNICODE) => "cannot use UNICODE flag with a bytes pattern",
            false if self.has(flag::LOCALE) => "cannot use LOCALE flag with a str pattern",
            _ if self.has(flag::ASCII) && self.has(flag::UNICODE) => {
                "ASCII and UNICODE flags are incompatible"
            }
            _ => return Ok(()),
        };
        Err(self.error(message, None))
    }

    /// `(?ims)` at the very beginning.
    fn global_flags(&mut self) -> PatternResult {
        while self.starts_with("(?") {
            let letters = &self.chars[self.at + 2..];
            let is_flag = |letter: &char| "aiLmsux".contains(*letter);
            let count = letters.iter().take_while(|c| is_flag(c)).count();
            let end = self.at + 2 + count;
            if count == 0 || self.chars.get(end) != Some(&')') {
                return Ok(());
            }
            for at in self.at + 2..end {
                self.flags |= self.flag_of(self.chars[at])?;
                self.pace()?;
            }
            self.at = end + 1;
        }
        Ok(())
    }

    pub(super) fn flag_of(&self, letter: char) -> PatternResult<u32> {
        Ok(match letter {
            'i' => flag::IGNORECASE,
            'L' => flag::LOCALE,
            'm' => flag::MULTILINE,
            's' => flag::DOTALL,
            'x' => flag::VERBOSE,
            'u' => flag::UNICODE,
            'a' => flag::ASCII,
            _ => return Err(self.error("unknown flag", Some(self.at + 2))),
        })
    }

    /// Branches up to a closing parenthesis or the end.
    pub(super) fn alternatives(&mut self) -> PatternResult<Width> {
        let mut jumps = Vec::new();
        let mut width: Option<Width> = None;
        loop {
            let start = self.program.ops.len();
            let (least, most) = self.sequence()?;
            let before = width.unwrap_or((least, most));
            width = Some((before.0.min(least), before.1.max(most)));
            if self.peek() != Some('|') {
                break;
            }
            self.at += 1;
            self.insert(start, Op::Split(self.since(start) + 2))?;
            self.ev.grow(&mut jumps, 1)?;
            jumps.push(self.program.ops.len());
            self.emit(Op::Jump(0))?;
        }
        for at in jumps {
            self.program.ops[at] = Op::Jump(self.since(at));
            self.pace()?;
        }
        Ok(width.unwrap_or(EMPTY))
    }

    pub(super) fn sequence(&mut self) -> PatternResult<Width> {
        // The item that a quantifier would repeat: where its operations begin, its width. None if there is none.
        let mut item: Option<(usize, Width)> = None;
        let mut repeated = false;
        let mut whole = EMPTY;
        let plus = |a: Width, b: Width| (a.0.saturating_add(b.0), a.1.saturating_add(b.1));
        while let Some(c) = self.peek() {
            self.pace()?;
            let start = self.at;
            if self.has(flag::VERBOSE) {
                if c.is_whitespace() {
                    self.at += 1;
                    continue;
                }
                if c == '#' {
                    while self.take().is_some_and(|c| c != '\n') {
                        self.pace()?;
                    }
                    continue;
                }
            }
            let bounds = match c {
                '|' | ')' => break,
                '*' => Some((0, FOREVER)),
                '+' => Some((1, FOREVER)),
                '?' => Some((0, 1)),
                '{' => self.bounds()?,
                _ => None,
            };
            if let Some(bounds) = bounds {
                if c != '{' {
                    self.at += 1;
                }
                let Some((from, width)) = item else {
                    return Err(self.error("nothing to repeat", Some(start)));
                };
                if repeated {
                    return Err(self.error("multiple repeat", Some(start)));
                }
                self.repeat(from, bounds)?;
                let times = |width: u64, count: u32| match count {
                    FOREVER if width > 0 => u64::MAX,
                    count => width.saturating_mul(u64::from(count)),
                };
                item = Some((from, (times(width.0, bounds.0), times(width.1, bounds.1))));
                repeated = true;
                continue;
            }
            let before = self.program.ops.len();
            self.at = start + 1;
            let next = match self.item(c, start)? {
                PatternItem::Repeatable(width) => Some((before, width)),
                PatternItem::Assertion => None,
                PatternItem::Comment => continue,
            };
            if let Some((_, width)) = std::mem::replace(&mut item, next) {
                whole = plus(whole, width);
            }
            repeated = false;
        }
        Ok(item.map_or(whole, |(_, width)| plus(whole, width)))
    }

    /// Digits of a number; None if there are none.
    fn number(&mut self) -> PatternResult<Option<u64>> {
        let mut number: Option<u64> = None;
        while let Some(digit) = self.peek().and_then(|c| c.to_digit(10)) {
            let tens = number.unwrap_or(0).saturating_mul(10);
            number = Some(tens.saturating_add(u64::from(digit)));
            self.at += 1;
            self.pace()?;
        }
        Ok(number)
    }

    /// `{m,n}` from its `{` on; None if that is a brace like any other.
    fn bounds(&mut self) -> PatternResult<Option<(u32, u32)>> {
        let start = self.at;
        self.at += 1;
        let least = self.number()?;
        let mut most = least;
        if self.peek() == Some(',') {
            self.at += 1;
            most = self.number()?;
        } else if least.is_none() {
            return Ok(None);
        }
        if self.peek() != Some('}') {
            return Ok(None);
        }
        self.at += 1;
        let least = least.unwrap_or(0);
        if least > REPEAT_MAX || most.is_some_and(|most| most > REPEAT_MAX) {
            return Err(self.error(
                format!("more than {REPEAT_MAX} repetitions are not supported"),
                Some(start),
            ));
        }
        if most.is_some_and(|most| most < least) {
            return Err(self.error("min repeat greater than max repeat", Some(start + 1)));
        }
        Ok(Some((
            least as u32,
            most.map_or(FOREVER, |most| most as u32),
        )))
    }

    /// Makes what has been written from `item` on repeat; the quantifier has been read, but not what says how.
    fn repeat(&mut self, item: usize, (least, most): (u32, u32)) -> PatternResult {
        let (greedy, atomic) = match self.peek() {
            Some('?') => (false, false),
            Some('+') => (true, true),
            _ => (true, false),
        };
        if !greedy || atomic {
            self.at += 1;
        }
        let length = self.since(item);
        let single = matches!(
            self.program.ops[item..],
            [Op::Char(_) | Op::Fold(..) | Op::Set(_) | Op::Any | Op::NotNewline]
        );
        if !single && (least, most) == (0, 1) {
            if !greedy {
                self.insert(item, Op::Jump(length + 1))?;
            }
            self.insert(item, Op::Split(if greedy { length + 1 } else { 2 }))?;
        } else {
            let number = self.program.repeats.len() as u32;
            self.ev.grow(&mut self.program.repeats, 1)?;
            self.program.repeats.push(Repeat {
                least,
                most,
                greedy,
                length: length as u32,
            });
            if single {
                self.insert(item, Op::RepeatSingle(number))?;
            } else {
                self.insert(item, Op::RepeatBegin(number))?;
                self.emit(Op::RepeatEnd(number))?;
            }
        }
        if atomic {
            self.insert(item, Op::Atomic)?;
            self.emit(Op::Cut)?;
        }
        Ok(())
    }

    /// One item that begins with `c`.
    fn item(&mut self, c: char, start: usize) -> PatternResult<PatternItem> {
        let multiline = self.has(flag::MULTILINE);
        let op = match c {
            '.' if self.has(flag::DOTALL) => Op::Any,
            '.' => Op::NotNewline,
            '^' if multiline => Op::Assert(Assert::StartOfLine),
            '^' => Op::Assert(Assert::Start),
            '$' if multiline => Op::Assert(Assert::EndOfLine),
            '$' => Op::Assert(Assert::LastLine),
            '(' => return self.group(start),
            '[' => {
                self.class(start)?;
                return Ok(PatternItem::Repeatable(ONE));
            }
            '\\' => return self.escape(start),
            other => self.literal(code_of(other)),
        };
        self.emit(op)?;
        Ok(match op {
            Op::Assert(_) => PatternItem::Assertion,
            _ => PatternItem::Repeatable(ONE),
        })
    }

    pub(super) fn literal(&self, code: u32) -> Op {
        let same = self.folding();
        let folded = key(code, same);
        let cased = folded != code
            || char::from_u32(code)
                .is_some_and(|c| c.is_alphabetic() && same != CaseFolding::Exact);
        match cased {
            true => Op::Fold(folded, same),
            false => Op::Char(code),
        }
    }
}
