//! Python's syntax of regular expressions to that of fancy-regex.
//!
//! Everything is written out: flags become scoped groups, classes become lists of code points, so that nothing depends
//! on how the crate would read an unusual character. Groups keep their numbers; names are kept here.

use std::fmt::Write as _;

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

/// Nesting of groups.
const DEPTH_MAX: usize = 100;
/// Largest number of repetitions.
const REPEAT_MAX: u64 = 100_000;

/// A translated pattern.
pub(super) struct Translated {
    pub pattern: String,
    /// Capturing groups, the whole not counted.
    pub groups: usize,
    pub names: Vec<(String, usize)>,
    pub flags: u32,
}

/// What is wrong, and at which character.
pub(super) struct PatternError {
    pub message: String,
    pub position: Option<usize>,
}

type Parsed<T = ()> = Result<T, PatternError>;

pub(super) fn translate(text: &str, flags: u32, is_bytes: bool) -> Parsed<Translated> {
    let mut translator = Translator {
        chars: text.chars().collect(),
        at: 0,
        out: String::new(),
        groups: 0,
        open: Vec::new(),
        names: Vec::new(),
        flags,
        is_bytes,
        depth: 0,
    };
    translator.global_flags()?;
    let known = flag::IGNORECASE
        | flag::LOCALE
        | flag::MULTILINE
        | flag::DOTALL
        | flag::UNICODE
        | flag::VERBOSE
        | flag::ASCII;
    if translator.flags & !known != 0 {
        return Err(translator.error("these flags are not supported", None));
    }
    if is_bytes && translator.flags & flag::UNICODE != 0 {
        return Err(PatternError {
            message: "cannot use UNICODE flag with a bytes pattern".to_owned(),
            position: None,
        });
    }
    if !is_bytes && translator.flags & flag::LOCALE != 0 {
        return Err(PatternError {
            message: "cannot use LOCALE flag with a str pattern".to_owned(),
            position: None,
        });
    }
    if translator.flags & flag::ASCII != 0 && translator.flags & flag::UNICODE != 0 {
        return Err(PatternError {
            message: "ASCII and UNICODE flags are incompatible".to_owned(),
            position: None,
        });
    }
    if !is_bytes && translator.flags & flag::ASCII == 0 {
        translator.flags |= flag::UNICODE;
    }
    let ignore_case = translator.flags & flag::IGNORECASE != 0;
    if ignore_case {
        translator.out.push_str("(?i:");
    }
    translator.alternatives()?;
    if translator.at < translator.chars.len() {
        return Err(translator.error("unbalanced parenthesis", Some(translator.at)));
    }
    if ignore_case {
        translator.out.push(')');
    }
    Ok(Translated {
        pattern: translator.out,
        groups: translator.groups,
        names: translator.names,
        flags: translator.flags,
    })
}

struct Translator {
    chars: Vec<char>,
    at: usize,
    out: String,
    groups: usize,
    /// Numbers of the groups around.
    open: Vec<usize>,
    names: Vec<(String, usize)>,
    flags: u32,
    is_bytes: bool,
    depth: usize,
}

impl Translator {
    fn error(&self, message: impl Into<String>, position: Option<usize>) -> PatternError {
        PatternError {
            message: message.into(),
            position,
        }
    }

    fn peek(&self) -> Option<char> {
        self.chars.get(self.at).copied()
    }

    fn take(&mut self) -> Option<char> {
        let c = self.peek()?;
        self.at += 1;
        Some(c)
    }

    fn starts_with(&self, text: &str) -> bool {
        text.chars()
            .enumerate()
            .all(|(i, c)| self.chars.get(self.at + i) == Some(&c))
    }

    fn has(&self, flag: u32) -> bool {
        self.flags & flag != 0
    }

    /// `(?ims)` at the very beginning.
    fn global_flags(&mut self) -> Parsed {
        while self.starts_with("(?") {
            let letters: String = self.chars[self.at + 2..]
                .iter()
                .take_while(|c| c.is_ascii_alphabetic())
                .collect();
            let end = self.at + 2 + letters.len();
            if letters.is_empty()
                || !letters.chars().all(|letter| "aiLmsux".contains(letter))
                || self.chars.get(end) != Some(&')')
            {
                return Ok(());
            }
            for letter in letters.chars() {
                self.flags |= self.flag_of(letter)?;
            }
            self.at = end + 1;
        }
        Ok(())
    }

    fn flag_of(&self, letter: char) -> Parsed<u32> {
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
    fn alternatives(&mut self) -> Parsed {
        loop {
            self.sequence()?;
            if self.peek() != Some('|') {
                return Ok(());
            }
            self.at += 1;
            self.out.push('|');
        }
    }

    fn sequence(&mut self) -> Parsed {
        // Where the item that a quantifier would repeat begins in the output; None if there is none.
        let mut item: Option<usize> = None;
        let mut repeated = false;
        while let Some(c) = self.peek() {
            let start = self.at;
            if self.has(flag::VERBOSE) {
                if c.is_whitespace() {
                    self.at += 1;
                    continue;
                }
                if c == '#' {
                    while self.take().is_some_and(|c| c != '\n') {}
                    continue;
                }
            }
            match c {
                '|' | ')' => return Ok(()),
                '*' | '+' | '?' => {
                    self.at += 1;
                    let text = c.to_string();
                    self.repeat(&text, item, repeated, start)?;
                    (item, repeated) = (item, true);
                    continue;
                }
                '{' => {
                    if let Some(text) = self.bounds()? {
                        self.repeat(&text, item, repeated, start)?;
                        repeated = true;
                        continue;
                    }
                    item = Some(self.out.len());
                    self.at = start + 1;
                    self.literal('{');
                }
                _ => {
                    let before = self.out.len();
                    self.at += 1;
                    let can_repeat = self.item(c, start)?;
                    item = can_repeat.then_some(before);
                }
            }
            repeated = false;
        }
        Ok(())
    }

    /// `{m,n}` after its `{`; None if it is a brace like any other.
    fn bounds(&mut self) -> Parsed<Option<String>> {
        let start = self.at;
        self.at += 1;
        let mut number = || {
            let digits: String = self.chars[self.at..]
                .iter()
                .take_while(|c| c.is_ascii_digit())
                .collect();
            self.at += digits.len();
            digits
        };
        let low = number();
        let mut high = low.clone();
        if self.peek() == Some(',') {
            self.at += 1;
            let digits: String = self.chars[self.at..]
                .iter()
                .take_while(|c| c.is_ascii_digit())
                .collect();
            self.at += digits.len();
            high = digits;
        } else if low.is_empty() {
            return Ok(None);
        }
        if self.peek() != Some('}') {
            return Ok(None);
        }
        self.at += 1;
        let value = |digits: &str| digits.parse::<u64>().unwrap_or(u64::MAX);
        let least = if low.is_empty() { 0 } else { value(&low) };
        if least > REPEAT_MAX || (!high.is_empty() && value(&high) > REPEAT_MAX) {
            return Err(self.error(
                format!("more than {REPEAT_MAX} repetitions are not supported"),
                Some(start),
            ));
        }
        if high.is_empty() {
            return Ok(Some(format!("{{{least},}}")));
        }
        if value(&high) < least {
            return Err(self.error("min repeat greater than max repeat", Some(start + 1)));
        }
        Ok(Some(format!("{{{least},{}}}", value(&high))))
    }

    fn repeat(
        &mut self,
        text: &str,
        item: Option<usize>,
        repeated: bool,
        position: usize,
    ) -> Parsed {
        let Some(item) = item else {
            return Err(self.error("nothing to repeat", Some(position)));
        };
        if repeated {
            return Err(self.error("multiple repeat", Some(position)));
        }
        // One item, whatever it was written out as.
        self.out.insert_str(item, "(?:");
        self.out.push(')');
        self.out.push_str(text);
        match self.peek() {
            Some('?') => {
                self.at += 1;
                self.out.push('?');
            }
            Some('+') => {
                self.at += 1;
                self.out.insert_str(item, "(?>");
                self.out.push(')');
            }
            _ => {}
        }
        Ok(())
    }

    /// One item that begins with `c`; whether it can be repeated.
    fn item(&mut self, c: char, start: usize) -> Parsed<bool> {
        match c {
            '.' => self.out.push_str(if self.has(flag::DOTALL) {
                "(?s:.)"
            } else {
                "[^\\n]"
            }),
            '^' => {
                self.out.push_str(if self.has(flag::MULTILINE) {
                    "(?m:^)"
                } else {
                    "\\A"
                });
                return Ok(false);
            }
            '$' => {
                self.out.push_str(if self.has(flag::MULTILINE) {
                    "(?m:$)"
                } else {
                    "(?=\\n?\\z)"
                });
                return Ok(false);
            }
            '(' => return self.group(start),
            '[' => self.class(start)?,
            '\\' => return self.escape(start),
            other => self.literal(other),
        }
        Ok(true)
    }

    fn literal(&mut self, c: char) {
        if c.is_ascii_alphanumeric() || c == '_' || c == ' ' {
            self.out.push(c);
        } else {
            self.code_point(c as u32);
        }
    }

    fn code_point(&mut self, code: u32) {
        // Writing to a string cannot fail.
        let _ = write!(self.out, "\\x{{{code:x}}}");
    }

    fn group(&mut self, start: usize) -> Parsed<bool> {
        self.depth += 1;
        if self.depth > DEPTH_MAX {
            return Err(self.error("groups are nested too deeply", Some(start)));
        }
        let flags = self.flags;
        let mut repeatable = true;
        let mut number = None;
        let opening = if self.starts_with("?") {
            self.at += 1;
            match self.extension(start)? {
                Extension::Open(text, captures, is_assertion) => {
                    repeatable = !is_assertion;
                    if captures {
                        number = Some(self.groups);
                    }
                    text
                }
                Extension::Complete(can_repeat) => {
                    self.depth -= 1;
                    return Ok(can_repeat);
                }
            }
        } else {
            self.groups += 1;
            number = Some(self.groups);
            "(".to_owned()
        };
        self.out.push_str(&opening);
        self.open.extend(number);
        self.alternatives()?;
        if self.take() != Some(')') {
            return Err(self.error("missing ), unterminated subpattern", Some(start)));
        }
        if number.is_some() {
            self.open.pop();
        }
        self.out.push(')');
        self.flags = flags;
        self.depth -= 1;
        Ok(repeatable)
    }

    /// What follows `(?`.
    fn extension(&mut self, start: usize) -> Parsed<Extension> {
        let Some(c) = self.take() else {
            return Err(self.error("unexpected end of pattern", Some(self.at)));
        };
        let open =
            |text: &str, is_assertion| Ok(Extension::Open(text.to_owned(), false, is_assertion));
        match c {
            ':' => open("(?:", false),
            '=' => open("(?=", true),
            '!' => open("(?!", true),
            '>' => open("(?>", false),
            '<' => match self.take() {
                Some('=') => open("(?<=", true),
                Some('!') => open("(?<!", true),
                Some(other) => {
                    Err(self.error(format!("unknown extension ?<{other}"), Some(start + 1)))
                }
                None => Err(self.error("unexpected end of pattern", Some(self.at))),
            },
            '#' => {
                while let Some(c) = self.take() {
                    if c == ')' {
                        return Ok(Extension::Complete(false));
                    }
                }
                Err(self.error("missing ), unterminated comment", Some(start)))
            }
            'P' => self.named(start),
            '(' => {
                let name = self.until(')', start)?;
                let index = self.reference(&name, self.at - name.chars().count() - 1)?;
                self.out.push_str(&format!("(?({index})"));
                self.alternatives()?;
                if self.take() != Some(')') {
                    return Err(self.error("missing ), unterminated subpattern", Some(start)));
                }
                self.out.push(')');
                Ok(Extension::Complete(true))
            }
            c if "-aiLmsux".contains(c) => {
                self.at -= 1;
                self.scoped_flags(start)
            }
            other => Err(self.error(format!("unknown extension ?{other}"), Some(start + 1))),
        }
    }

    fn until(&mut self, end: char, start: usize) -> Parsed<String> {
        let from = self.at;
        let mut name = String::new();
        loop {
            match self.take() {
                Some(c) if c == end => break,
                Some(c) => name.push(c),
                None if name.is_empty() => return Err(self.error("missing group name", Some(from))),
                None => {
                    let what = if end == ')' {
                        "missing ), unterminated name"
                    } else {
                        "missing >, unterminated name"
                    };
                    return Err(self.error(what, Some(from)));
                }
            }
        }
        let _ = start;
        if name.is_empty() {
            return Err(self.error("missing group name", Some(from)));
        }
        Ok(name)
    }

    fn named(&mut self, start: usize) -> Parsed<Extension> {
        match self.take() {
            Some('<') => {
                let from = self.at;
                let name = self.until('>', start)?;
                let mut chars = name.chars();
                let valid = chars.next().is_some_and(|c| c == '_' || c.is_alphabetic())
                    && chars.all(|c| c == '_' || c.is_alphanumeric());
                if !valid {
                    return Err(
                        self.error(format!("bad character in group name '{name}'"), Some(from))
                    );
                }
                self.groups += 1;
                if let Some((_, index)) = self.names.iter().find(|(known, _)| *known == name) {
                    let text = format!(
                        "redefinition of group name '{name}' as group {}; was group {index}",
                        self.groups
                    );
                    return Err(self.error(text, Some(from)));
                }
                self.names.push((name, self.groups));
                Ok(Extension::Open("(".to_owned(), true, false))
            }
            Some('=') => {
                let from = self.at;
                let name = self.until(')', start)?;
                let index = self.reference(&name, from)?;
                self.out.push_str(&format!("(?:\\{index})"));
                Ok(Extension::Complete(true))
            }
            Some(other) => Err(self.error(format!("unknown extension ?P{other}"), Some(start + 1))),
            None => Err(self.error("unexpected end of pattern", Some(self.at))),
        }
    }

    /// The number of a group that is referred to.
    fn reference(&self, name: &str, position: usize) -> Parsed<usize> {
        let index = match name.parse::<usize>() {
            Ok(0) => return Err(self.error("bad group number", Some(position))),
            Ok(number) if number <= self.groups => number,
            Ok(number) => {
                return Err(self.error(format!("invalid group reference {number}"), Some(position)));
            }
            Err(_) => match self.names.iter().find(|(known, _)| known == name) {
                Some((_, index)) => *index,
                None => {
                    return Err(self.error(format!("unknown group name '{name}'"), Some(position)));
                }
            },
        };
        if self.open.contains(&index) {
            return Err(self.error("cannot refer to an open group", Some(position)));
        }
        Ok(index)
    }

    fn scoped_flags(&mut self, start: usize) -> Parsed<Extension> {
        let (mut on, mut off, mut minus) = (0, 0, false);
        loop {
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
                    if minus {
                        off |= bit;
                    } else {
                        on |= bit;
                    }
                }
                Some(_) => return Err(self.error("missing -, : or )", Some(self.at - 1))),
                None => return Err(self.error("missing -, : or )", Some(self.at))),
            }
        }
        if on & flag::ASCII != 0 {
            self.flags &= !flag::UNICODE;
        }
        self.flags = (self.flags | on) & !off;
        let opening = match (on & flag::IGNORECASE != 0, off & flag::IGNORECASE != 0) {
            (true, _) => "(?i:",
            (_, true) => "(?-i:",
            _ => "(?:",
        };
        Ok(Extension::Open(opening.to_owned(), false, false))
    }

    /// Whether classes like `\w` mean ASCII only.
    fn is_ascii(&self) -> bool {
        self.is_bytes || self.has(flag::ASCII)
    }

    /// `\d` and the like inside brackets.
    fn category(&self, letter: char) -> Option<&'static str> {
        Some(match (letter, self.is_ascii()) {
            ('d', true) => "0-9",
            ('D', true) => "[^0-9]",
            ('s', true) => "\\x{20}\\x{9}-\\x{d}",
            ('S', true) => "[^\\x{20}\\x{9}-\\x{d}]",
            ('w', true) => "a-zA-Z0-9_",
            ('W', true) => "[^a-zA-Z0-9_]",
            ('d', false) => "\\d",
            ('D', false) => "\\D",
            ('s', false) => "\\s\\x{1c}-\\x{1f}",
            ('S', false) => "[^\\s\\x{1c}-\\x{1f}]",
            ('w', false) => "\\p{L}\\p{N}_",
            ('W', false) => "[^\\p{L}\\p{N}_]",
            _ => return None,
        })
    }

    /// After a backslash outside brackets; whether it can be repeated.
    fn escape(&mut self, start: usize) -> Parsed<bool> {
        let Some(c) = self.take() else {
            return Err(self.error("bad escape (end of pattern)", Some(start)));
        };
        if let Some(class) = self.category(c) {
            let text = format!("[{class}]");
            self.out.push_str(&text);
            return Ok(true);
        }
        let ascii_word = "[a-zA-Z0-9_]";
        match c {
            'A' => self.out.push_str("\\A"),
            'Z' => self.out.push_str("\\z"),
            'b' if self.is_ascii() => {
                let text = format!(
                    "(?:(?<={ascii_word})(?!{ascii_word})|(?<!{ascii_word})(?={ascii_word}))"
                );
                self.out.push_str(&text);
            }
            'B' if self.is_ascii() => {
                let text = format!(
                    "(?:(?<={ascii_word})(?={ascii_word})|(?<!{ascii_word})(?!{ascii_word}))"
                );
                self.out.push_str(&text);
            }
            'b' => self.out.push_str("\\b"),
            'B' => self.out.push_str("\\B"),
            '1'..='9' => return self.number(c, start),
            other => {
                let code = self.character(other, start)?;
                self.code_point(code);
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// `\1` to `\99`, or an octal number of three digits.
    fn number(&mut self, first: char, start: usize) -> Parsed<bool> {
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
                self.code_point(code);
                return Ok(true);
            }
        }
        if digits.parse().is_ok_and(|index| self.open.contains(&index)) {
            return Err(self.error("cannot refer to an open group", Some(start)));
        }
        let index = self.reference(&digits, start + 1)?;
        self.out.push_str(&format!("(?:\\{index})"));
        Ok(true)
    }

    /// The code of an escaped character, in or outside brackets.
    fn character(&mut self, c: char, start: usize) -> Parsed<u32> {
        let hex = |translator: &mut Self, count: usize| {
            let digits: String = translator.chars[translator.at..]
                .iter()
                .take(count)
                .take_while(|c| c.is_ascii_hexdigit())
                .collect();
            translator.at += digits.len();
            if digits.len() == count {
                Ok(u32::from_str_radix(&digits, 16).unwrap_or(0))
            } else {
                Err(translator.error(format!("incomplete escape \\{c}{digits}"), Some(start)))
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
                if char::from_u32(code).is_none() {
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
    fn class(&mut self, start: usize) -> Parsed {
        let mut out = String::from("[");
        if self.peek() == Some('^') {
            self.at += 1;
            out.push('^');
        }
        let mut first = true;
        loop {
            let here = self.at;
            let Some(c) = self.take() else {
                return Err(self.error("unterminated character set", Some(start)));
            };
            if c == ']' && !first {
                break;
            }
            first = false;
            let Some(low) = self.member(c, here, &mut out, start)? else {
                if self.peek() == Some('-')
                    && !matches!(self.chars.get(self.at + 1), Some(']') | None)
                {
                    let text: String = self.chars[here..(self.at + 2).min(self.chars.len())]
                        .iter()
                        .collect();
                    return Err(self.error(format!("bad character range {text}"), Some(here)));
                }
                continue;
            };
            let mut high = low;
            if self.peek() == Some('-') && self.chars.get(self.at + 1).is_some_and(|c| *c != ']') {
                self.at += 1;
                let there = self.at;
                let next = self.take().unwrap_or('-');
                match self.member(next, there, &mut String::new(), start)? {
                    Some(code) if code >= low => high = code,
                    _ => {
                        let text: String = self.chars[here..self.at].iter().collect();
                        return Err(self.error(format!("bad character range {text}"), Some(here)));
                    }
                }
            }
            let _ = write!(out, "\\x{{{low:x}}}");
            if high > low {
                let _ = write!(out, "-\\x{{{high:x}}}");
            }
        }
        out.push(']');
        self.out.push_str(&out);
        Ok(())
    }

    /// One member of a class: its code, or None if it was a category, which goes to `out`.
    fn member(
        &mut self,
        c: char,
        here: usize,
        out: &mut String,
        start: usize,
    ) -> Parsed<Option<u32>> {
        if c != '\\' {
            return Ok(Some(c as u32));
        }
        let Some(escaped) = self.take() else {
            return Err(self.error("unterminated character set", Some(start)));
        };
        if let Some(class) = self.category(escaped) {
            out.push_str(class);
            return Ok(None);
        }
        match escaped {
            'b' => Ok(Some(8)),
            '1'..='7' => {
                let mut digits = escaped.to_string();
                while digits.len() < 3 && self.peek().is_some_and(|c| ('0'..='7').contains(&c)) {
                    digits.extend(self.take());
                }
                Ok(Some(u32::from_str_radix(&digits, 8).unwrap_or(0)))
            }
            other => self.character(other, here).map(Some),
        }
    }
}

/// What follows `(?`.
enum Extension {
    /// The opening of a group, whether it captures, whether it is an assertion.
    Open(String, bool, bool),
    /// It has been read to its end; whether it can be repeated.
    Complete(bool),
}
