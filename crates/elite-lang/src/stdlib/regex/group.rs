//! Groups of a pattern, and everything else that begins with `(?`.

use std::rc::Rc;

use elite_syntax::lexer::is_name;

use super::parse::{EMPTY, PatternItem, PatternParser, PatternResult, Width, flag};
use super::program::{LookAround, Op};
use crate::eval::coroutine::RESERVE;

/// Nesting of groups.
const GROUP_DEPTH_MAX: usize = 100;

/// What follows `(?`.
enum Extension {
    Group,
    Capture,
    Look {
        behind: bool,
        negated: bool,
    },
    Atomic,
    /// The extension has been read to its end, and has a width.
    Complete(Width),
    Comment,
}

impl PatternParser<'_, '_> {
    pub(super) fn group(&mut self, start: usize) -> PatternResult<PatternItem> {
        self.depth += 1;
        if self.depth > GROUP_DEPTH_MAX {
            return Err(self.error("groups are nested too deeply", Some(start)));
        }
        let flags = self.flags;
        let kind = if self.peek() == Some('?') {
            self.at += 1;
            self.extension(start)?
        } else {
            self.new_group()?;
            Extension::Capture
        };
        if let Extension::Complete(_) | Extension::Comment = kind {
            self.depth -= 1;
            return Ok(match kind {
                Extension::Complete(width) => PatternItem::Repeatable(width),
                _ => PatternItem::Comment,
            });
        }
        let number = self.groups;
        let (before, behind) = (self.program.ops.len(), self.behind);
        match kind {
            Extension::Capture => {
                self.open.push(number);
                self.emit(Op::Save(2 * number as u32))?;
            }
            Extension::Look { behind: true, .. } => {
                self.behind = self.behind.or(Some(self.groups));
            }
            _ => {}
        }
        let ev = self.ev;
        let mut width = ev.with_stack(RESERVE, || self.alternatives())?;
        if self.take() != Some(')') {
            return Err(self.error("missing ), unterminated subpattern", Some(start)));
        }
        match kind {
            Extension::Capture => {
                self.emit(Op::Save(2 * number as u32 + 1))?;
                self.open.pop();
                self.widths[number] = width;
            }
            Extension::Look {
                behind: back,
                negated,
            } => {
                if back && width.0 != width.1 {
                    self.is_loose = true;
                }
                let look = LookAround {
                    back: if back { width.0 as usize } else { 0 },
                    negated,
                    length: self.since(before) as u32,
                };
                let number = self.program.looks.len() as u32;
                self.ev.grow(&mut self.program.looks, 1)?;
                self.program.looks.push(look);
                self.insert(before, Op::Look(number))?;
                self.emit(Op::Cut)?;
                width = EMPTY;
            }
            Extension::Atomic => {
                self.insert(before, Op::Atomic)?;
                self.emit(Op::Cut)?;
            }
            Extension::Group | Extension::Complete(_) | Extension::Comment => {}
        }
        self.behind = behind;
        self.flags = flags;
        self.depth -= 1;
        Ok(PatternItem::Repeatable(width))
    }

    fn new_group(&mut self) -> PatternResult {
        self.groups += 1;
        self.ev.grow(&mut self.widths, 1)?;
        self.widths.push(EMPTY);
        Ok(())
    }

    /// What follows `(?`.
    fn extension(&mut self, start: usize) -> PatternResult<Extension> {
        let Some(c) = self.take() else {
            return Err(self.error("unexpected end of pattern", Some(self.at)));
        };
        let look = |behind, negated| Ok(Extension::Look { behind, negated });
        match c {
            ':' => Ok(Extension::Group),
            '=' => look(false, false),
            '!' => look(false, true),
            '>' => Ok(Extension::Atomic),
            '<' => match self.take() {
                Some('=') => look(true, false),
                Some('!') => look(true, true),
                Some(other) => {
                    Err(self.error(format!("unknown extension ?<{other}"), Some(start + 1)))
                }
                None => Err(self.error("unexpected end of pattern", Some(self.at))),
            },
            '#' => {
                while let Some(c) = self.take() {
                    self.pace()?;
                    if c == ')' {
                        return Ok(Extension::Comment);
                    }
                }
                Err(self.error("missing ), unterminated comment", Some(start)))
            }
            'P' => self.named_group(start),
            '(' => {
                let name = self.until(')')?;
                let index = self.condition(&name, self.at - name.chars().count() - 1)?;
                let width = self.conditional(index, start)?;
                Ok(Extension::Complete(width))
            }
            c if "-aiLmsux".contains(c) => {
                self.at -= 1;
                self.scoped_flags(start)
            }
            other => Err(self.error(format!("unknown extension ?{other}"), Some(start + 1))),
        }
    }

    /// Both branches of `(?(group)yes|no)`.
    fn conditional(&mut self, group: usize, start: usize) -> PatternResult<Width> {
        let test = self.program.ops.len();
        self.emit(Op::If(group as u32, 0))?;
        let mut width = self.sequence()?;
        let mut other = (0, 0);
        let jump = self.program.ops.len();
        let has_other = self.peek() == Some('|');
        if has_other {
            self.at += 1;
            self.emit(Op::Jump(0))?;
        }
        self.program.ops[test] = Op::If(group as u32, self.since(test));
        if has_other {
            other = self.sequence()?;
            self.program.ops[jump] = Op::Jump(self.since(jump));
        }
        if self.peek() == Some('|') {
            let text = "conditional backref with more than two branches";
            return Err(self.error(text, Some(self.at)));
        }
        if self.take() != Some(')') {
            return Err(self.error("missing ), unterminated subpattern", Some(start)));
        }
        width = (width.0.min(other.0), width.1.max(other.1));
        Ok(width)
    }

    fn until(&mut self, end: char) -> PatternResult<String> {
        let from = self.at;
        let mut name = String::new();
        loop {
            self.pace()?;
            self.ev.grow(&mut name, 4)?;
            match self.take() {
                Some(c) if c == end => break,
                Some(c) => name.push(c),
                None if name.is_empty() => return Err(self.error("missing group name", Some(from))),
                None => {
                    let what = match end {
                        ')' => "missing ), unterminated name",
                        _ => "missing >, unterminated name",
                    };
                    return Err(self.error(what, Some(from)));
                }
            }
        }
        if name.is_empty() {
            return Err(self.error("missing group name", Some(from)));
        }
        Ok(name)
    }

    fn named_group(&mut self, start: usize) -> PatternResult<Extension> {
        match self.take() {
            Some('<') => {
                let from = self.at;
                let name = self.until('>')?;
                if !is_name(&name) {
                    return Err(
                        self.error(format!("bad character in group name '{name}'"), Some(from))
                    );
                }
                self.new_group()?;
                if let Some(index) = self.by_name.get(name.as_str()) {
                    let text = format!(
                        "redefinition of group name '{name}' as group {}; was group {index}",
                        self.groups
                    );
                    return Err(self.error(text, Some(from)));
                }
                let name: Rc<str> = name.into();
                self.ev.grow(&mut self.names, 1)?;
                self.names.push((name.clone(), self.groups));
                self.by_name.insert(name, self.groups);
                Ok(Extension::Capture)
            }
            Some('=') => {
                let from = self.at;
                let name = self.until(')')?;
                let index = self.reference(&name, from)?;
                let width = self.refer(index)?;
                Ok(Extension::Complete(width))
            }
            Some(other) => Err(self.error(format!("unknown extension ?P{other}"), Some(start + 1))),
            None => Err(self.error("unexpected end of pattern", Some(self.at))),
        }
    }

    /// The number of a group that is referred to.
    pub(super) fn reference(&self, name: &str, position: usize) -> PatternResult<usize> {
        let index = self.named_or_numbered(name, position)?;
        if index > self.groups {
            return Err(self.error(format!("invalid group reference {index}"), Some(position)));
        }
        if self.open.contains(&index) {
            return Err(self.error("cannot refer to an open group", Some(position)));
        }
        self.check_behind(index)?;
        Ok(index)
    }

    /// The number of a group that is a condition; it may begin later.
    fn condition(&mut self, name: &str, position: usize) -> PatternResult<usize> {
        let index = self.named_or_numbered(name, position)?;
        if index > self.groups {
            self.wanted = self.wanted.or(Some((index, position)));
        }
        self.check_behind(index)?;
        Ok(index)
    }

    fn named_or_numbered(&self, name: &str, position: usize) -> PatternResult<usize> {
        match (name.parse::<usize>(), self.by_name.get(name)) {
            (Ok(0), _) => Err(self.error("bad group number", Some(position))),
            // Operations count in 32 bits.
            (Ok(number), _) if number < 1 << 30 => Ok(number),
            (Ok(number), _) => {
                Err(self.error(format!("invalid group reference {number}"), Some(position)))
            }
            (Err(_), Some(index)) => Ok(*index),
            (Err(_), None) => {
                Err(self.error(format!("unknown group name '{name}'"), Some(position)))
            }
        }
    }

    /// A look-behind knows only the groups before it.
    fn check_behind(&self, group: usize) -> PatternResult {
        let Some(groups) = self.behind else {
            return Ok(());
        };
        if self.open.contains(&group) {
            return Err(self.error("cannot refer to an open group", Some(self.at)));
        }
        if group > groups {
            let text = "cannot refer to group defined in the same lookbehind subpattern";
            return Err(self.error(text, Some(self.at)));
        }
        Ok(())
    }

    /// Writes what finds the text of a group again; its width.
    pub(super) fn refer(&mut self, group: usize) -> PatternResult<Width> {
        self.emit(Op::Reference(group as u32, self.folding()))?;
        Ok(self.widths[group])
    }

    fn scoped_flags(&mut self, start: usize) -> PatternResult<Extension> {
        let (mut on, mut off, mut minus) = (0, 0, false);
        loop {
            self.pace()?;
            match self.take() {
                Some('-') if !minus => minus = true,
                Some(':') => break,
                Some(')') => {
                    let text = "global flags not at the start of the expression";
                    return Err(self.error(text, Some(start)));
                }
                Some(letter) if letter.is_ascii_alphabetic() => {
                    self.at -= 1;
                    let bit = self
                        .flag_of(letter)
                        .map_err(|_| self.error("unknown flag", Some(self.at)))?;
                    self.at += 1;
                    match minus {
                        true => off |= bit,
                        false => on |= bit,
                    }
                }
                Some(_) => return Err(self.error("missing -, : or )", Some(self.at - 1))),
                None => return Err(self.error("missing -, : or )", Some(self.at))),
            }
        }
        if on & flag::ASCII != 0 {
            self.flags &= !flag::UNICODE;
        }
        if on & flag::UNICODE != 0 {
            self.flags &= !flag::ASCII;
        }
        self.flags = (self.flags | on) & !off;
        Ok(Extension::Group)
    }
}
