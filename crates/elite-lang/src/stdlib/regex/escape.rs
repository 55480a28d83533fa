//! What follows a backslash in a pattern, and classes in brackets.

use super::letters::{Categories, CharClassBuilder};
use super::parse::{PatternItem, PatternParser, PatternResult, Width};
use super::program::{Assert, Op};

const ONE: Width = (1, 1);

impl PatternParser<'_, '_> {
    /// After a backslash outside brackets.
    pub(super) fn escape(&mut self, start: usize) -> PatternResult<PatternItem> {
        let Some(c) = self.take() else {
            return Err(self.error("bad escape (end of pattern)", Some(start)));
        };
        if let Some(categories) = Categories::of(c) {
            let set = self.category(categories)?;
            self.emit(Op::Set(set))?;
            return Ok(PatternItem::Repeatable(ONE));
        }
        let assert = match c {
            'A' => Assert::Start,
            'Z' => Assert::End,
            'b' => Assert::Border(self.class_mode()),
            'B' => Assert::NoBorder(self.class_mode()),
            '1'..='9' => return self.digits(c, start),
            other => {
                let code = self.character(other, start)?;
                self.emit(self.literal(code))?;
                return Ok(PatternItem::Repeatable(ONE));
            }
        };
        self.emit(Op::Assert(assert))?;
        Ok(PatternItem::Assertion)
    }

    /// The set that one category is.
    fn category(&mut self, categories: Categories) -> PatternResult<u32> {
        let of = self.class_mode();
        let known = self
            .categories
            .iter()
            .find(|set| (set.0, set.1) == (categories, of));
        if let Some((_, _, set)) = known {
            return Ok(*set);
        }
        let mut set = CharClassBuilder::new(of, super::letters::CaseFolding::Exact);
        set.categories = categories;
        let set = self.program.letters.keep(self.ev, set)?;
        self.categories.push((categories, of, set));
        Ok(set)
    }

    /// `\1` to `\99`, or an octal number of three digits.
    fn digits(&mut self, first: char, start: usize) -> PatternResult<PatternItem> {
        let mut digits = first.to_string();
        if let Some(second) = self.peek().filter(char::is_ascii_digit) {
            self.at += 1;
            digits.push(second);
            let octal = |c: &char| ('0'..='7').contains(c);
            if let (Some(third), true) =
                (self.peek().filter(octal), digits.chars().all(|c| octal(&c)))
            {
                self.at += 1;
                digits.push(third);
                let code = u32::from_str_radix(&digits, 8).unwrap_or(0);
                if code > 0o377 {
                    let text = format!("octal escape value \\{digits} outside of range 0-0o377");
                    return Err(self.error(text, Some(start)));
                }
                self.emit(self.literal(code))?;
                return Ok(PatternItem::Repeatable(ONE));
            }
        }
        if digits.parse().is_ok_and(|index| self.open.contains(&index)) {
            return Err(self.error("cannot refer to an open group", Some(start)));
        }
        let index = self.reference(&digits, start + 1)?;
        Ok(PatternItem::Repeatable(self.refer(index)?))
    }

    /// The code of an escaped character, in or outside brackets.
    fn character(&mut self, c: char, start: usize) -> PatternResult<u32> {
        let hex = |parser: &mut Self, count: usize| {
            let digits: String = parser.chars[parser.at..]
                .iter()
                .take(count)
                .take_while(|c| c.is_ascii_hexdigit())
                .collect();
            parser.at += digits.len();
            match digits.len() == count {
                true => Ok(u32::from_str_radix(&digits, 16).unwrap_or(0)),
                false => Err(parser.error(format!("incomplete escape \\{c}{digits}"), Some(start))),
            }
        };
        Ok(match c {
            'a' => 7,
            'f' => 12,
            'n' => 10,
            'r' => 13,
            't' => 9,
            'v' => 11,
            'x' => hex(self, 2)?,
            'u' if !self.is_bytes => hex(self, 4)?,
            'U' if !self.is_bytes => {
                let code = hex(self, 8)?;
                if code > 0x10_ffff {
                    return Err(self.error(format!("bad escape \\U{code:08x}"), Some(start)));
                }
                code
            }
            '0' => {
                let mut digits = String::new();
                while digits.len() < 2 && self.peek().is_some_and(|c| ('0'..='7').contains(&c)) {
                    digits.extend(self.take());
                }
                u32::from_str_radix(&digits, 8).unwrap_or(0)
            }
            c if c.is_ascii_alphanumeric() => {
                return Err(self.error(format!("bad escape \\{c}"), Some(start)));
            }
            other => other as u32,
        })
    }

    /// A class after its `[`.
    pub(super) fn class(&mut self, start: usize) -> PatternResult {
        let mut set = CharClassBuilder::new(self.class_mode(), self.folding());
        if self.peek() == Some('^') {
            self.at += 1;
            set.negated = true;
        }
        let mut first = true;
        loop {
            self.pace()?;
            let here = self.at;
            let Some(c) = self.take() else {
                return Err(self.error("unterminated character set", Some(start)));
            };
            if c == ']' && !first {
                break;
            }
            first = false;
            let low = self.member(c, here, start)?;
            let is_range =
                self.peek() == Some('-') && self.chars.get(self.at + 1).is_some_and(|c| *c != ']');
            let bad = |parser: &Self, to: usize| {
                let text: String = parser.chars[here..to.min(parser.chars.len())]
                    .iter()
                    .collect();
                parser.error(format!("bad character range {text}"), Some(here))
            };
            match low {
                ClassMember::Category(_) if is_range => return Err(bad(self, self.at + 2)),
                ClassMember::Category(categories) => set.categories.add(categories),
                ClassMember::Code(low) if is_range => {
                    self.at += 1;
                    let there = self.at;
                    let next = self.take().unwrap_or('-');
                    match self.member(next, there, start)? {
                        ClassMember::Code(high) if high >= low => set.add(self.ev, low, high)?,
                        _ => return Err(bad(self, self.at)),
                    }
                }
                ClassMember::Code(code) => set.add(self.ev, code, code)?,
            }
        }
        let set = self.program.letters.keep(self.ev, set)?;
        self.emit(Op::Set(set))
    }

    /// One member of a class that begins with `c`.
    fn member(&mut self, c: char, here: usize, start: usize) -> PatternResult<ClassMember> {
        if c != '\\' {
            return Ok(ClassMember::Code(elite_syntax::surrogate::code_of(c)));
        }
        let Some(escaped) = self.take() else {
            return Err(self.error("unterminated character set", Some(start)));
        };
        if let Some(categories) = Categories::of(escaped) {
            return Ok(ClassMember::Category(categories));
        }
        match escaped {
            'b' => Ok(ClassMember::Code(8)),
            '1'..='7' => {
                let mut digits = escaped.to_string();
                while digits.len() < 3 && self.peek().is_some_and(|c| ('0'..='7').contains(&c)) {
                    digits.extend(self.take());
                }
                let code = u32::from_str_radix(&digits, 8).unwrap_or(0);
                if code > 0o377 {
                    let text = format!("octal escape value \\{digits} outside of range 0-0o377");
                    return Err(self.error(text, Some(here)));
                }
                Ok(ClassMember::Code(code))
            }
            other => self.character(other, here).map(ClassMember::Code),
        }
    }
}

/// A member of a class.
enum ClassMember {
    Code(u32),
    Category(Categories),
}
