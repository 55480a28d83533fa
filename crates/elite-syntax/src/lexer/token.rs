//! The tokens of EliteScript. Owns their kinds and how they are named in messages.

use messages::Text;

use crate::source::Span;

/// A token: its kind and place. The text is `file.slice(span)`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub struct Token {
    pub kind: TokenKind,
    pub span: Span,
}

macro_rules! tokens {
    (
        layout { $($layout:ident => $layout_english:literal $layout_chinese:literal,)* }
        keywords { $($keyword:ident => $keyword_text:literal,)* }
        operators { $($operator:ident => $operator_text:literal,)* }
    ) => {
        /// What a token is.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        #[allow(missing_docs)]
        pub enum TokenKind { $($layout,)* $($keyword,)* $($operator,)* }

        impl TokenKind {
            /// How messages name this kind of token.
            pub fn describe(self) -> Text {
                match self {
                    $(TokenKind::$layout => Text::fixed($layout_english, $layout_chinese),)*
                    $(TokenKind::$keyword => Text::verbatim(concat!("'", $keyword_text, "'")),)*
                    $(TokenKind::$operator => Text::verbatim(concat!("'", $operator_text, "'")),)*
                }
            }

            /// The keyword with this text.
            pub fn keyword(text: &str) -> Option<TokenKind> {
                match text {
                    $($keyword_text => Some(TokenKind::$keyword),)*
                    _ => None,
                }
            }

            /// Whether this is a keyword.
            pub fn is_keyword(self) -> bool {
                matches!(self, $(TokenKind::$keyword)|*)
            }
        }

        /// All operators, longest first within each starting character by construction of `longest_operator`.
        const OPERATORS: &[(&str, TokenKind)] = &[$(($operator_text, TokenKind::$operator),)*];
    };
}

tokens! {
    layout {
        Name => "a name" "名称",
        Int => "a number" "数",
        Float => "a number" "数",
        Imaginary => "a number" "数",
        Str => "a string" "字符串",
        Newline => "the end of the line" "行尾",
        Indent => "an indented line" "缩进的行",
        Dedent => "the end of the block" "块的结尾",
        End => "'end'" "'end'",
        EndOfFile => "the end of the program" "程序的结尾",
        Unknown => "an unknown character" "未知字符",
        // Words of Python's that other programs use as names: they are not names only where what follows says so.
        Async => "'async'" "'async'",
        Await => "'await'" "'await'",
    }
    keywords {
        False => "False", None => "None", True => "True", And => "and", As => "as", Assert => "assert",
        Break => "break", Class => "class", Continue => "continue",
        Def => "def", Del => "del", Elif => "elif", Else => "else", Except => "except", Finally => "finally",
        For => "for", From => "from", Global => "global", If => "if", Import => "import", In => "in", Is => "is",
        Lambda => "lambda", Nonlocal => "nonlocal", Not => "not", Or => "or", Pass => "pass", Raise => "raise",
        Return => "return", Try => "try", While => "while", With => "with", Yield => "yield",
    }
    operators {
        LeftParen => "(", RightParen => ")", LeftBracket => "[", RightBracket => "]",
        LeftBrace => "{", RightBrace => "}",
        Comma => ",", ColonEqual => ":=", Colon => ":", Semicolon => ";", Ellipsis => "...", Dot => ".",
        Arrow => "->", PlusEqual => "+=", Plus => "+", MinusEqual => "-=", Minus => "-",
        DoubleStarEqual => "**=", DoubleStar => "**", StarEqual => "*=", Star => "*",
        DoubleSlashEqual => "//=", DoubleSlash => "//", SlashEqual => "/=", Slash => "/",
        PercentEqual => "%=", Percent => "%", AtEqual => "@=", At => "@",
        AmpersandEqual => "&=", Ampersand => "&", BarEqual => "|=", Bar => "|",
        CaretEqual => "^=", Caret => "^", Tilde => "~",
        LeftShiftEqual => "<<=", LeftShift => "<<", RightShiftEqual => ">>=", RightShift => ">>",
        LessEqual => "<=", Less => "<", GreaterEqual => ">=", Greater => ">",
        EqualEqual => "==", Equal => "=", NotEqual => "!=",
    }
}

/// Operators that begin alike, at most.
const ALIKE_MAX: usize = 5;
/// Where there is no operator.
const NONE: u8 = u8::MAX;
/// By the first byte of operators, their numbers.
const BY_FIRST: [[u8; ALIKE_MAX]; 128] = by_first();

const fn by_first() -> [[u8; ALIKE_MAX]; 128] {
    let mut table = [[NONE; ALIKE_MAX]; 128];
    let mut number = 0;
    while number < OPERATORS.len() {
        let first = OPERATORS[number].0.as_bytes()[0] as usize;
        let mut at = 0;
        while table[first][at] != NONE {
            at += 1;
        }
        table[first][at] = number as u8;
        number += 1;
    }
    table
}

/// The longest operator `rest` starts with, and its length in bytes.
pub fn longest_operator(rest: &str) -> Option<(TokenKind, usize)> {
    let first = *rest.as_bytes().first()?;
    let numbers = BY_FIRST.get(first as usize)?.iter();
    let alike = numbers.filter_map(|number| OPERATORS.get(*number as usize));
    let found = alike
        .filter(|(text, _)| rest.as_bytes().starts_with(text.as_bytes()))
        .max_by_key(|(text, _)| text.len());
    found.map(|(text, kind)| (*kind, text.len()))
}
