//! What the text ports have to know about script text: where strings are, where a block ends.
//!
//! Pure and incremental; not a parser. Everything else about the language is decided by whoever compiles the text.

/// Follows strings and comments through script text, byte by byte, over any number of lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StringTracker {
    place: LexState,
    /// The byte before was a backslash inside a string.
    escaped: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum LexState {
    #[default]
    Code,
    Comment,
    /// One or two quotes have been seen; a string, an empty string or a triple quote.
    Opening(u8, u8),
    /// Within a string that ends with its line.
    Single(u8),
    /// In a triple-quoted string, with so many closing quotes seen.
    Triple(u8, u8),
}

impl StringTracker {
    /// Takes the next byte. Every byte of UTF-8 beyond ASCII is an ordinary one.
    pub fn feed(&mut self, byte: u8) {
        use LexState::{Code, Comment, Opening, Single, Triple};
        let escaped = core::mem::take(&mut self.escaped);
        self.place = match self.place {
            Code => Self::in_code(byte),
            Comment if byte == b'\n' => Code,
            Comment => Comment,
            Opening(quote, 1) if byte == quote => Opening(quote, 2),
            Opening(quote, _) if byte == quote => Triple(quote, 0),
            Opening(quote, 1) => return self.in_single(quote, byte, false),
            Opening(..) => Self::in_code(byte),
            Single(quote) => return self.in_single(quote, byte, escaped),
            Triple(quote, closing) => match byte {
                _ if escaped => Triple(quote, 0),
                b'\\' => {
                    self.escaped = true;
                    Triple(quote, 0)
                }
                byte if byte != quote => Triple(quote, 0),
                _ if closing == 2 => Code,
                _ => Triple(quote, closing + 1),
            },
        };
    }

    const fn in_code(byte: u8) -> LexState {
        match byte {
            b'"' | b'\'' => LexState::Opening(byte, 1),
            b'#' => LexState::Comment,
            _ => LexState::Code,
        }
    }

    fn in_single(&mut self, quote: u8, byte: u8, escaped: bool) {
        self.place = match byte {
            _ if escaped => LexState::Single(quote), // also a newline: the string goes on in the next line
            b'\\' => {
                self.escaped = true;
                LexState::Single(quote)
            }
            b'\n' => LexState::Code,
            byte if byte == quote => LexState::Code,
            _ => LexState::Single(quote),
        };
    }

    /// True where a word would be part of the program: not in a string, not in a comment.
    pub const fn in_code_now(&self) -> bool {
        matches!(self.place, LexState::Code | LexState::Opening(_, 2))
    }

    /// True in a string; at the start of a line that means the string began in an earlier one.
    pub const fn in_string(&self) -> bool {
        matches!(
            self.place,
            LexState::Opening(_, 1) | LexState::Single(_) | LexState::Triple(..)
        )
    }
}

/// True for a line that holds only `end`, without indentation; blanks, a `;` and a comment may follow.
pub fn is_end_line(line: &[u8]) -> bool {
    let Some(rest) = line.strip_prefix(b"end") else {
        return false;
    };
    let rest = rest.trim_ascii_start();
    let rest = rest.strip_prefix(b";").unwrap_or(rest).trim_ascii_start();
    rest.is_empty() || rest[0] == b'#'
}

/// The code of one line, comment removed, cut at every `;` outside strings and brackets.
pub fn statements_of_line(line: &str) -> Vec<&str> {
    let mut strings = StringTracker::default();
    let mut depth = 0_u32;
    let mut parts = Vec::new();
    let mut start = 0;
    for (at, byte) in line.bytes().enumerate() {
        let was_code = strings.in_code_now();
        strings.feed(byte);
        if !was_code {
            continue;
        }
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            b';' if depth == 0 => {
                parts.push(&line[start..at]);
                start = at + 1;
            }
            b'#' => {
                parts.push(&line[start..at]);
                return parts;
            }
            _ => {}
        }
    }
    parts.push(&line[start..]);
    parts
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Every byte of `text` that is program: `_` stands for the rest.
    fn code_of(text: &str) -> String {
        let mut strings = StringTracker::default();
        let code = text.bytes().map(|byte| {
            let was_code = strings.in_code_now();
            strings.feed(byte);
            let keep = (was_code && strings.in_code_now()) || byte == b'\n';
            if keep { char::from(byte) } else { '_' }
        });
        code.collect()
    }

    #[test]
    fn strings_and_comments_are_told_from_code() {
        for (text, code) in [
            (r#"a="x;y";b"#, "a=_____;b"),
            (r#"a="";b"#, "a=__;b"),
            (r"a='\'';b", "a=____;b"),
            (r#"a=r'\';b"#, "a=r_____"),
            ("a # 'b'\nc", "a _____\nc"),
            ("a='open\nb", "a=_____\nb"),
            ("a='on\\\nb'\nc", "a=____\n__\nc"),
            ("a='''x\n''y'''\nb", "a=____\n______\nb"),
            (r#"a="""\"""" ;b"#, "a=________;b"),
            (r#"a="""'''""";b"#, "a=_________;b"),
            ("f('''a''' + \"b\")", "f(_______ + ___)"),
        ] {
            let code_seen = code_of(text).replace(' ', "");
            assert_eq!(code_seen, code.replace(' ', ""), "{text}");
        }
    }

    #[test]
    fn end_lines_are_alone_and_not_indented() {
        for line in [
            "end",
            "end  ",
            "end # of it",
            "end;",
            "end ; # x",
            "end\t",
            "end#",
        ] {
            assert!(is_end_line(line.as_bytes()), "{line}");
        }
        for line in [
            " end", "\tend", "ends", "end=5", "end()", "endd", "end x", "en", "", "end;;", "# end",
        ] {
            assert!(!is_end_line(line.as_bytes()), "{line}");
        }
    }

    #[test]
    fn statements_are_cut_outside_strings_brackets_and_comments() {
        assert_eq!(
            statements_of_line("def f():; a(';'); b([1;2]);end; # x;y"),
            ["def f():", " a(';')", " b([1;2])", "end", " "]
        );
        assert_eq!(statements_of_line("a"), ["a"]);
        assert_eq!(statements_of_line("a;"), ["a", ""]);
        assert_eq!(statements_of_line(")];a"), [")]", "a"]);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]
        #[test]
        fn any_line_is_cut_without_losing_code(line in "[a-z;#'\"\\\\()\\[\\] é]{0,40}") {
            let parts = statements_of_line(&line);
            prop_assert!(line.starts_with(&parts.join(";")));
        }
    }
}
