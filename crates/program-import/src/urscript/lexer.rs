//! Characters to tokens. Line ends are no tokens, because URScript needs none: every token says whether it is the first
//! of its line.

use messages::text;

use super::SyntaxError;

/// A token with its place.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token {
    /// Line, from 1.
    pub line: u32,
    /// Whether it is the first of its line.
    pub is_first: bool,
    /// What it is.
    pub kind: TokenKind,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum TokenKind {
    /// A name or a keyword.
    Word(String),
    /// A number as it is written.
    Number(String),
    /// A text without its quotes.
    Text(String),
    /// `p[`
    PoseStart,
    /// An operator or a bracket.
    Symbol(&'static str),
    /// `$ 3 "Waypoint"` without the `$`.
    Label(String),
    /// The end of the text.
    End,
}

/// A comment with its place.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Comment {
    /// Line, from 1.
    pub line: u32,
    /// Whether something stands before it on its line.
    pub is_trailing: bool,
    /// What follows the `#`.
    pub text: String,
}

/// Longer ones first.
const SYMBOLS: [&str; 22] = [
    "==", "!=", "<=", ">=", "+=", "-=", "(", ")", "[", "]", ",", ":", ".", "=", "<", ">", "+", "-",
    "*", "/", "%", ";",
];

pub(super) fn tokens(text: &str) -> Result<(Vec<Token>, Vec<Comment>), SyntaxError> {
    let mut lexer = Lexer {
        rest: text.strip_prefix('\u{feff}').unwrap_or(text),
        line: 1,
        is_first: true,
        tokens: Vec::new(),
        comments: Vec::new(),
    };
    lexer.read()?;
    Ok((lexer.tokens, lexer.comments))
}

struct Lexer<'t> {
    rest: &'t str,
    line: u32,
    is_first: bool,
    tokens: Vec<Token>,
    comments: Vec<Comment>,
}

impl<'t> Lexer<'t> {
    fn read(&mut self) -> Result<(), SyntaxError> {
        while let Some(first) = self.rest.chars().next() {
            match first {
                '\n' => {
                    self.take(1);
                    self.line = self.line.saturating_add(1);
                    self.is_first = true;
                }
                ' ' | '\t' | '\r' | '\u{b}' | '\u{c}' | '\u{a0}' => {
                    self.take(first.len_utf8());
                }
                // A line that goes on.
                '\\' if self.rest[1..]
                    .trim_start_matches([' ', '\t', '\r'])
                    .starts_with('\n') =>
                {
                    let end = self.rest.find('\n').unwrap_or(self.rest.len() - 1);
                    self.take(end + 1);
                    self.line = self.line.saturating_add(1);
                }
                '#' => {
                    let text = self.line_rest();
                    self.comments.push(Comment {
                        line: self.line,
                        is_trailing: !self.is_first,
                        text: text[1..].trim_end().to_owned(),
                    });
                }
                '$' if self.is_first => {
                    let text = self.line_rest();
                    self.push(TokenKind::Label(text[1..].trim().to_owned()));
                }
                '"' | '\'' => self.read_text(first)?,
                '0'..='9' => self.read_number(),
                '.' if self.rest[1..].starts_with(|c: char| c.is_ascii_digit()) => {
                    self.read_number();
                }
                _ if is_word_start(first) => self.read_word(),
                _ => self.read_symbol(first)?,
            }
        }
        self.push(TokenKind::End);
        Ok(())
    }

    /// Cuts off the first bytes.
    fn take(&mut self, bytes: usize) -> &'t str {
        let (head, tail) = self.rest.split_at(bytes);
        self.rest = tail;
        head
    }

    fn line_rest(&mut self) -> &'t str {
        self.take(self.rest.find('\n').unwrap_or(self.rest.len()))
    }

    fn push(&mut self, kind: TokenKind) {
        self.tokens.push(Token {
            line: self.line,
            is_first: std::mem::take(&mut self.is_first),
            kind,
        });
    }

    fn read_text(&mut self, quote: char) -> Result<(), SyntaxError> {
        let body = &self.rest[1..];
        let end = body.find([quote, '\n']).unwrap_or(body.len());
        if !body[end..].starts_with(quote) {
            return Err(SyntaxError::new(
                self.line,
                text!(
                    "the text has no end: its quote is missing",
                    "字符串没有结束：缺少引号"
                ),
            ));
        }
        self.push(TokenKind::Text(body[..end].to_owned()));
        self.take(end + 2);
        Ok(())
    }

    fn read_number(&mut self) {
        let bytes = self.rest.as_bytes();
        let digits = |from: usize| {
            from + bytes[from..]
                .iter()
                .take_while(|b| b.is_ascii_digit())
                .count()
        };
        let mut end;
        if bytes[0] == b'0' && matches!(bytes.get(1), Some(b'x' | b'X')) {
            end = 2 + bytes[2..]
                .iter()
                .take_while(|b| b.is_ascii_hexdigit())
                .count();
        } else {
            end = digits(0);
            if bytes.get(end) == Some(&b'.') {
                end = digits(end + 1);
            }
            if matches!(bytes.get(end), Some(b'e' | b'E')) {
                let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
                let exponent = digits(end + 1 + sign);
                if exponent > end + 1 + sign {
                    end = exponent;
                }
            }
        }
        let text = self.take(end).to_owned();
        self.push(TokenKind::Number(text));
    }

    fn read_word(&mut self) {
        let end = self
            .rest
            .find(|c| !is_word_part(c))
            .unwrap_or(self.rest.len());
        let word = self.take(end);
        if word == "p" && self.rest.starts_with('[') {
            self.take(1);
            self.push(TokenKind::PoseStart);
        } else {
            self.push(TokenKind::Word(word.to_owned()));
        }
    }

    fn read_symbol(&mut self, first: char) -> Result<(), SyntaxError> {
        let symbol = SYMBOLS
            .iter()
            .find(|symbol| self.rest.starts_with(**symbol));
        let Some(symbol) = symbol else {
            let shown = first.escape_default();
            return Err(SyntaxError::new(
                self.line,
                text!(
                    "URScript has no character '{shown}'",
                    "URScript 没有字符 '{shown}'"
                ),
            ));
        };
        self.take(symbol.len());
        self.push(TokenKind::Symbol(symbol));
        Ok(())
    }
}

fn is_word_start(c: char) -> bool {
    c == '_' || c.is_alphabetic()
}

fn is_word_part(c: char) -> bool {
    c == '_' || c.is_alphanumeric()
}
