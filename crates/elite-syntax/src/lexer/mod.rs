//! From text to tokens. Indentation, the optional `end` and the one-line form with semicolons live here
//! (`layout`, `oneline`) and nowhere else: the parser only sees `Indent`, `Dedent`, `End` and `Newline`.

mod directive;
mod layout;
mod names;
mod oneline;
mod token;

pub use directive::Directive;
pub use names::{begins_name, continues_name, is_name};
pub use token::{Token, TokenKind};

use messages::{Text, text};

use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::{DiagnosticList, quoted};
use crate::source::{SourceFile, Span};
use crate::work_budget::WorkBudget;

/// Work for one character, and bytes of long tokens that are looked at at once.
const WORK_PER_CHAR: usize = 8;
const SCAN_CHUNK: usize = 1 << 10;
/// Work for one token.
const TOKEN: usize = 64;

/// The tokens of a file, always ended by `EndOfFile`, and what was wrong with its text.
pub struct Tokens {
    /// The tokens.
    pub tokens: Vec<Token>,
    /// Errors and warnings.
    pub diagnostics: DiagnosticList,
    /// Offsets at which a line was cut short because a bracket in it is never closed.
    pub unclosed_cuts: Vec<u32>,
    /// The directives, in the order of the text.
    pub directives: Vec<Directive>,
}

/// The tokens of a text.
pub fn tokens(file: &SourceFile) -> Vec<Token> {
    lex(file, &WorkBudget::with_limit(crate::parser::TREE_MAX)).tokens
}

/// What is said of a text whose tokens or tree would take more than `budget`.
pub(crate) fn too_large(budget: &WorkBudget<'_>) -> Diagnostic {
    let most = budget.limit() >> 20;
    let message = text!(
        "the text is too large: to read it would take more than {most} MiB",
        "文本过大：读取它需要超过 {most} MiB"
    );
    Diagnostic::error("too-large", Span::default(), message)
}

/// Lexes a whole file. A text whose tokens would take more than `budget` has none, and one error.
pub(crate) fn lex(file: &SourceFile, budget: &WorkBudget<'_>) -> Tokens {
    let mut lexer = Lexer::new(file.text(), 0, file.text().len(), budget);
    lexer.takes_directives = true;
    lexer.run();
    lexer.finish()
}

/// Lexes a single expression that lies at `span` of a file (a replacement field of an f-string): line ends and
/// indentation mean nothing, as between brackets.
pub(crate) fn lex_expression(file: &SourceFile, span: Span, budget: &WorkBudget<'_>) -> Tokens {
    let mut lexer = Lexer::new(file.text(), span.start as usize, span.end as usize, budget);
    lexer.brackets.push((TokenKind::LeftParen, span));
    lexer.run_expression();
    lexer.finish()
}

struct Lexer<'t> {
    text: &'t str,
    at: usize,
    end: usize,
    tokens: Vec<Token>,
    diagnostics: DiagnosticList,
    /// Open brackets, innermost last.
    brackets: Vec<(TokenKind, Span)>,
    cuts: Vec<u32>,
    directives: Vec<Directive>,
    /// How many of them have been settled.
    settled: usize,
    /// A program is read, not an expression.
    takes_directives: bool,
    /// What tokens and tree may take.
    budget: &'t WorkBudget<'t>,
    /// The tokens take more than that; the rest of the text is not looked at.
    is_full: bool,
    layout: layout::IndentState,
}

impl<'t> Lexer<'t> {
    fn new(text: &'t str, start: usize, end: usize, budget: &'t WorkBudget<'t>) -> Self {
        let start = if start == 0 && text.starts_with('\u{feff}') {
            '\u{feff}'.len_utf8()
        } else {
            start
        };
        let (tokens, diagnostics, brackets) = (Vec::new(), DiagnosticList::default(), Vec::new());
        Lexer {
            text,
            at: start,
            end,
            tokens,
            diagnostics,
            brackets,
            cuts: Vec::new(),
            directives: Vec::new(),
            settled: 0,
            takes_directives: false,
            budget,
            is_full: false,
            layout: layout::IndentState::default(),
        }
    }

    fn finish(self) -> Tokens {
        Tokens {
            tokens: self.tokens,
            diagnostics: self.diagnostics,
            unclosed_cuts: self.cuts,
            directives: self.directives,
        }
    }

    fn run(&mut self) {
        loop {
            while self.at < self.end {
                self.start_of_line();
                if self.is_full {
                    return self.give_up();
                }
                while self.at < self.end && !self.layout.at_line_start() {
                    self.token_charged();
                    if self.is_full {
                        return self.give_up();
                    }
                }
                if self.diagnostics.is_full() {
                    // Nothing that could follow would be reported.
                    return self.end_of_text();
                }
            }
            if !self.cut_at_open_bracket() {
                break;
            }
        }
        self.end_of_text();
    }

    fn run_expression(&mut self) {
        self.layout.inside_expression();
        while self.at < self.end {
            self.token_charged();
            if self.is_full {
                return self.give_up();
            }
        }
        self.push(TokenKind::EndOfFile, self.end, self.end);
    }

    /// A text with too many tokens has none, so that nothing more is made of it.
    fn give_up(&mut self) {
        self.diagnostics.truncate(0);
        self.diagnostics.push(too_large(self.budget));
        self.tokens = Vec::new();
        self.directives = Vec::new();
        self.push(TokenKind::EndOfFile, self.end, self.end);
    }

    fn rest(&self) -> &'t str {
        &self.text[self.at..self.end]
    }

    fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    fn push(&mut self, kind: TokenKind, start: usize, end: usize) {
        if self.tokens.len() == self.tokens.capacity() {
            // Room is doubled.
            let more = self.tokens.len() * size_of::<Token>();
            self.is_full |= self.budget.used() + more > self.budget.limit();
        }
        self.tokens.push(Token {
            kind,
            span: Span::new(start, end),
        });
    }

    fn error(&mut self, code: &'static str, start: usize, end: usize, message: Text) {
        self.diagnostics
            .push(Diagnostic::error(code, Span::new(start, end), message));
    }

    /// Reads the next token and counts it as work, so that other threads have their turn from time to time.
    fn token_charged(&mut self) {
        self.token();
        self.budget.charge(TOKEN);
        self.is_full |= self.budget.is_aborted();
    }

    /// Bytes at the beginning of a text whose characters all pass a test.
    fn leading(&self, text: &str, test: impl Fn(char) -> bool) -> usize {
        let mut rest = text;
        while !rest.is_empty() {
            let (piece, after) = rest.split_at(rest.floor_char_boundary(SCAN_CHUNK));
            let kept = piece.trim_start_matches(&test);
            if !kept.is_empty() {
                return text.len() - after.len() - kept.len();
            }
            self.budget.charge(piece.len() * WORK_PER_CHAR);
            rest = after;
        }
        text.len()
    }

    /// One token, or the blanks, comment or line end before it.
    fn token(&mut self) {
        let start = self.at;
        let Some(c) = self.peek() else { return };
        match c {
            ' ' | '\t' | '\u{c}' => self.at += 1,
            '#' => self.skip_comment(),
            '$' if self.has_own_line() => self.directive(self.layout.depth()),
            '\n' | '\r' => self.line_end(),
            '\\' => self.continuation(),
            '"' | '\'' => self.string(start),
            ';' if self.layout.in_one_line_form() && self.brackets.is_empty() => self.part_end(),
            _ if c.is_ascii_digit() => self.number(),
            '.' if self.rest()[1..].starts_with(|next: char| next.is_ascii_digit()) => {
                self.number()
            }
            _ if names::begins_name(c) => self.word(),
            _ => self.operator(c),
        }
    }

    fn skip_comment(&mut self) {
        self.at += self.leading(self.rest(), |c| !matches!(c, '\n' | '\r'));
    }

    /// A backslash joins the next line to this one; anywhere else it is an error.
    fn continuation(&mut self) {
        let after = &self.rest()[1..];
        let joined = ["\r\n", "\n", "\r"]
            .into_iter()
            .find(|end| after.starts_with(end));
        match joined {
            Some(line_end) if after.len() == line_end.len() => {
                let message = text!(
                    "the text ends after this line continuation '\\'",
                    "文本在这个续行符 '\\' 之后结束"
                );
                self.error("syntax", self.at, self.at + 1, message);
                self.at += 1 + line_end.len();
            }
            Some(line_end) => self.at += 1 + line_end.len(),
            None => {
                self.error(
                    "syntax",
                    self.at,
                    self.at + 1,
                    text!(
                        "unexpected character after line continuation '\\'",
                        "续行符 '\\' 之后有意外的字符"
                    ),
                );
                self.at += 1;
            }
        }
    }

    fn word(&mut self) {
        let start = self.at;
        let rest = self.rest();
        let length = self.leading(rest, names::continues_name);
        let word = &rest[..length];
        let is_prefix = length <= 2
            && matches!(
                &*word.to_ascii_lowercase(),
                "r" | "b" | "u" | "f" | "rb" | "br" | "rf" | "fr"
            );
        if is_prefix && rest[length..].starts_with(['"', '\'']) {
            self.at += length;
            return self.string(start);
        }
        self.at += length;
        let kind = match word {
            "async" if self.goes_on_with(|word, _| matches!(word, "def" | "for" | "with")) => {
                TokenKind::Async
            }
            "await" if self.goes_on_with(is_operand) => TokenKind::Await,
            _ => TokenKind::keyword(word).unwrap_or(TokenKind::Name),
        };
        self.push(kind, start, self.at);
    }

    /// Looks at the next word on the line and the character that it begins with, or at the character alone.
    fn goes_on_with(&self, is_so: impl Fn(&str, char) -> bool) -> bool {
        let rest = self.rest().trim_start_matches([' ', '\t']);
        let length = rest
            .find(|c| !names::continues_name(c))
            .unwrap_or(rest.len());
        rest.chars()
            .next()
            .is_some_and(|next| is_so(&rest[..length], next))
    }

    /// A string literal whose prefix starts at `start` and whose quote is at `self.at`.
    fn string(&mut self, start: usize) {
        let rest = self.rest();
        let quote = &rest[..1];
        let triple = rest.starts_with(if quote == "\"" { "\"\"\"" } else { "'''" });
        let delimiter = if triple { &rest[..3] } else { quote };
        let mut at = delimiter.len();
        loop {
            self.budget.charge(WORK_PER_CHAR);
            let Some(c) = rest[at..].chars().next() else {
                let kind = if triple {
                    text!("triple-quoted string", "三引号字符串")
                } else {
                    text!("string", "字符串")
                };
                self.at = self.end;
                self.push(TokenKind::Str, start, self.end);
                let opening = start + delimiter.len();
                return self.error(
                    "syntax",
                    start,
                    opening,
                    text!("this {kind} is never closed", "这个{kind}没有结束"),
                );
            };
            if rest[at..].starts_with(delimiter) {
                break;
            }
            if !triple && (c == '\n' || c == '\r') {
                self.at += at;
                self.push(TokenKind::Str, start, self.at);
                return self.error(
                    "syntax",
                    start,
                    self.at,
                    text!(
                        "this string is not closed before the line ends",
                        "这个字符串在行尾之前没有结束"
                    ),
                );
            }
            at += c.len_utf8();
            if c == '\\' {
                let escaped = &rest[at..];
                let line_end = if escaped.starts_with("\r\n") { 2 } else { 0 };
                at += line_end.max(escaped.chars().next().map_or(0, char::len_utf8));
            }
        }
        self.at += at + delimiter.len();
        self.push(TokenKind::Str, start, self.at);
    }

    fn number(&mut self) {
        let start = self.at;
        let rest = self.rest();
        let radix = match rest.get(..2) {
            Some("0x" | "0X") => Some(16),
            Some("0o" | "0O") => Some(8),
            Some("0b" | "0B") => Some(2),
            _ => None,
        };
        let kind = if let Some(radix) = radix {
            // Digits that are none of this radix belong to the number, which then is none, unless they are a keyword.
            let all = digits(&rest[2..], |c| c.is_ascii_alphanumeric());
            let own = digits(&rest[2..], |c| c.is_digit(radix));
            let is_keyword = TokenKind::keyword(&rest[2 + own..2 + all]).is_some();
            self.at += 2 + if own > 0 && is_keyword { own } else { all };
            TokenKind::Int
        } else {
            let (length, kind) = decimal(rest);
            self.at += length;
            kind
        };
        let glued = self
            .rest()
            .find(|c| !names::continues_name(c))
            .unwrap_or(self.rest().len());
        let word = &self.rest()[..glued];
        // `1if x else y` is legal Python; any other letter after a number is a slip.
        if glued > 0 && TokenKind::keyword(word).is_none() {
            self.at += glued;
            let text = quoted(&self.text[start..self.at]);
            self.error(
                "syntax",
                start,
                self.at,
                text!(
                    "'{text}' is neither a number nor a name",
                    "'{text}' 既不是数也不是名称"
                ),
            );
        }
        self.push(kind, start, self.at);
    }

    fn operator(&mut self, c: char) {
        let start = self.at;
        let Some((kind, length)) = token::longest_operator(self.rest()) else {
            self.at += c.len_utf8();
            self.push(TokenKind::Unknown, start, self.at);
            return self.unknown_character(start, c);
        };
        self.at += length;
        match kind {
            TokenKind::LeftParen | TokenKind::LeftBracket | TokenKind::LeftBrace => {
                self.brackets.push((kind, Span::new(start, self.at)));
            }
            TokenKind::RightParen | TokenKind::RightBracket | TokenKind::RightBrace => {
                self.close(kind, start)
            }
            _ => {}
        }
        self.push(kind, start, self.at);
    }

    fn unknown_character(&mut self, start: usize, c: char) {
        let code = c as u32;
        let message = match invisible(c) {
            Some(name) => text!(
                "{name} (U+{code:04X}) has no meaning here",
                "{name}（U+{code:04X}）在这里没有意义"
            ),
            None => text!(
                "the character {c:?} (U+{code:04X}) has no meaning here",
                "字符 {c:?}（U+{code:04X}）在此没有意义"
            ),
        };
        let ascii = match c {
            '（' => "(",
            '）' => ")",
            '，' => ",",
            '：' => ":",
            '；' => ";",
            '“' | '”' => "\"",
            '‘' | '’' => "'",
            '【' => "[",
            '】' => "]",
            '＝' => "=",
            '－' | '–' | '−' => "-",
            '＋' => "+",
            _ => "",
        };
        let mut diagnostic = Diagnostic::error("syntax", Span::new(start, self.at), message);
        if !ascii.is_empty() {
            diagnostic = diagnostic
                .with_help(text!("did you mean {ascii}", "是否想写 {ascii}"))
                .with_fix(Span::new(start, self.at), ascii);
        } else if c.is_whitespace() {
            diagnostic = diagnostic
                .with_help(text!(
                    "it looks like a blank: write a blank in its place",
                    "它看起来像空格：请换成普通空格"
                ))
                .with_fix(Span::new(start, self.at), " ");
        } else if invisible(c).is_some() {
            diagnostic = diagnostic
                .with_help(text!("nobody can see it: delete it", "它不可见：请删除"))
                .with_fix(Span::new(start, self.at), "");
        } else if c == '!' {
            diagnostic = diagnostic
                .with_help(text!("write 'not'", "请写 'not'"))
                .with_fix(Span::new(start, self.at), "not ");
        } else if c == '°' {
            diagnostic = diagnostic.with_help(text!(
                "angles are in radians: write d2r(90) in place of 90°",
                "角度以弧度为单位：请用 d2r(90) 代替 90°"
            ));
        } else if c == '$' {
            diagnostic = diagnostic.with_help(text!(
                "a directive needs a line of its own",
                "指令需要单独一行"
            ));
        }
        self.diagnostics.push(diagnostic);
    }

    /// A closing bracket must match the innermost open one.
    fn close(&mut self, kind: TokenKind, start: usize) {
        let span = Span::new(start, self.at);
        let Some((open, open_span)) = self.brackets.pop() else {
            return self.error(
                "syntax",
                start,
                self.at,
                text!("{} closes nothing", "{}没有对应的左括号", kind.describe()),
            );
        };
        let matching = match open {
            TokenKind::LeftParen => TokenKind::RightParen,
            TokenKind::LeftBracket => TokenKind::RightBracket,
            _ => TokenKind::RightBrace,
        };
        if matching != kind {
            let message = text!(
                "{} does not match {}",
                "{}与{}不匹配",
                kind.describe(),
                open.describe()
            );
            self.diagnostics.push(
                Diagnostic::error("syntax", span, message)
                    .with_label(open_span, text!("opened here", "在此打开")),
            );
        }
    }
}

/// Length of the run of characters that `accept` takes, single underscores between them included.
fn digits(text: &str, accept: impl Fn(char) -> bool) -> usize {
    let mut length = 0;
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        let separator = c == '_' && chars.peek().is_some_and(|next| accept(*next));
        if !accept(c) && !separator {
            break;
        }
        length += c.len_utf8();
    }
    length
}

/// Length and kind of the decimal number that `text` starts with.
fn decimal(text: &str) -> (usize, TokenKind) {
    let digit = |c: char| c.is_ascii_digit();
    let mut length = digits(text, digit);
    let mut kind = TokenKind::Int;
    if text[length..].starts_with('.') {
        kind = TokenKind::Float;
        length += 1;
        if text[length..].starts_with(digit) {
            length += digits(&text[length..], digit);
        }
    }
    if let Some(after) = text[length..].strip_prefix(['e', 'E']) {
        let sign = usize::from(after.starts_with(['+', '-']));
        if after[sign..].starts_with(digit) {
            kind = TokenKind::Float;
            length += 1 + sign + digits(&after[sign..], digit);
        }
    }
    if text[length..].starts_with(['j', 'J']) {
        return (length + 1, TokenKind::Imaginary);
    }
    (length, kind)
}

/// Whether a name or a literal begins here, so that the word before it is no name by itself.
fn is_operand(word: &str, next: char) -> bool {
    let is_name = names::begins_name(next)
        && matches!(
            TokenKind::keyword(word),
            None | Some(TokenKind::None | TokenKind::True | TokenKind::False | TokenKind::Lambda)
        );
    is_name || next.is_ascii_digit() || matches!(next, '"' | '\'')
}

/// The name of a character that shows as a blank or not at all.
fn invisible(c: char) -> Option<Text> {
    Some(match c {
        '\u{a0}' | '\u{202f}' => text!("a no-break space", "不间断空格"),
        '\u{3000}' => text!("a wide space", "全角空格"),
        '\u{2000}'..='\u{200a}' => text!("a space of a special width", "特殊宽度的空格"),
        '\u{200b}'..='\u{200d}' | '\u{2060}' | '\u{feff}' => {
            text!("a character of no width", "零宽字符")
        }
        _ => return None,
    })
}
