//! Where the cursor stands: the word before it, what is before a dot, the call around it. Reads tokens, not the tree,
//! for the line that is being typed seldom parses.

use elite_syntax::lexer::{Token, TokenKind as T};
use elite_syntax::{SourceFile, Span};

use super::Analysis;
use super::scopes::ScopeId;
use super::types::TypeRef;

/// Tokens that are looked at backwards for the call around the cursor.
const LOOK_BACK_MAX: usize = 4000;
/// Links of a chain of attributes and calls that are followed.
const CHAIN_MAX: u32 = 8;

/// A call that is being written.
pub struct OpenCall {
    /// What is called.
    pub function: TypeRef,
    /// Arguments before the one at the cursor.
    pub position: usize,
    /// The keyword of the argument at the cursor, once it is written.
    pub keyword: Option<String>,
    /// The keywords that have been given.
    pub given: Vec<String>,
}

impl OpenCall {
    /// Arguments by position before the one at the cursor.
    pub fn positional(&self) -> usize {
        let named = self.given.len() - usize::from(self.keyword.is_some());
        self.position.saturating_sub(named)
    }
}

/// What stands before the cursor.
pub struct CursorContext<'a> {
    analysis: &'a Analysis,
    /// The tokens before the cursor, the one at it cut off there.
    tokens: Vec<Token>,
    /// The scope that the cursor is in.
    pub scope: ScopeId,
    /// The part of a name that has been typed.
    pub word: Span,
    /// The string around the cursor, and how much of it is before.
    pub string: Option<Span>,
    /// The cursor is in a comment or a directive.
    pub is_comment: bool,
}

impl<'a> CursorContext<'a> {
    /// Looks at `offset`.
    pub fn at(analysis: &'a Analysis, offset: u32) -> Self {
        let text = analysis.text();
        let offset = text.floor_char_boundary((offset as usize).min(text.len())) as u32;
        let all = analysis.tokens();
        let count = all.partition_point(|token| token.span.start < offset);
        let first = count.saturating_sub(LOOK_BACK_MAX);
        let mut tokens = all[first..count].to_vec();
        tokens.retain(|token| !matches!(token.kind, T::EndOfFile | T::Indent | T::Dedent));
        let line = text[..offset as usize].rfind('\n').map_or(0, |at| at + 1);
        let after_token = tokens.last().map_or(0, |token| token.span.end as usize);
        let gap = text
            .get(after_token.max(line)..offset as usize)
            .unwrap_or("");
        let mut cursor = CursorContext {
            analysis,
            scope: analysis.scope_at(offset),
            word: Span {
                start: offset,
                end: offset,
            },
            string: None,
            is_comment: gap.contains(['#', '$']),
            tokens,
        };
        cursor.cut_at(offset);
        cursor
    }

    fn cut_at(&mut self, offset: u32) {
        let Some(last) = self.tokens.last().copied() else {
            return;
        };
        match last.kind {
            T::Str if offset < last.span.end || self.is_open_string(last, offset) => {
                self.tokens.pop();
                match self.replacement_field(last, offset) {
                    Some(inner) => {
                        self.tokens = inner;
                        self.cut_word(offset);
                    }
                    None => {
                        self.string = Some(Span {
                            start: last.span.start,
                            end: offset,
                        });
                    }
                }
            }
            _ => self.cut_word(offset),
        }
    }

    fn cut_word(&mut self, offset: u32) {
        let Some(last) = self.tokens.last().copied() else {
            return;
        };
        let is_word = last.kind == T::Name || last.kind.is_keyword();
        if is_word && offset <= last.span.end {
            self.word = Span {
                start: last.span.start,
                end: offset,
            };
            self.tokens.pop();
        }
    }

    /// A string that is not closed reaches to the end of its line.
    fn is_open_string(&self, token: Token, offset: u32) -> bool {
        let text = self.analysis.file.slice(token.span);
        let quote = text
            .trim_start_matches(|c: char| c.is_ascii_alphabetic())
            .chars()
            .next();
        let closed = quote.is_some_and(|quote| text.len() > 1 && text.ends_with(quote));
        offset == token.span.end && !closed
    }

    /// The tokens between `{` and the cursor, in an f-string.
    fn replacement_field(&self, token: Token, offset: u32) -> Option<Vec<Token>> {
        let text = self.analysis.text();
        let before = text.get(token.span.start as usize..offset as usize)?;
        let prefix = before.split(['"', '\'']).next()?;
        if !prefix.to_ascii_lowercase().contains('f') {
            return None;
        }
        let open = before.rfind('{')?;
        let inside = &before[open + 1..];
        let doubled = before[..open]
            .chars()
            .rev()
            .take_while(|c| *c == '{')
            .count()
            % 2
            == 1;
        if doubled || inside.contains(['}', ':', '!']) {
            return None;
        }
        let start = token.span.start + open as u32 + 1;
        let piece = SourceFile::new("field", inside);
        let tokens = elite_syntax::lexer::tokens(&piece);
        let shifted = tokens
            .into_iter()
            .filter(|token| token.span.end > token.span.start)
            .map(|token| Token {
                kind: token.kind,
                span: Span {
                    start: token.span.start + start,
                    end: token.span.end + start,
                },
            });
        Some(shifted.collect())
    }

    /// The text of the word before the cursor.
    pub fn typed(&self) -> &'a str {
        self.analysis.file.slice(self.word)
    }

    fn text(&self, token: Token) -> &'a str {
        self.analysis.file.slice(token.span)
    }

    /// What stands before the word, newest last.
    pub fn before(&self) -> &[Token] {
        &self.tokens
    }

    /// What the word would be an attribute of.
    pub fn receiver(&self) -> Option<TypeRef> {
        let last = self.tokens.last()?;
        if last.kind != T::Dot {
            return None;
        }
        Some(self.operand_before(self.tokens.len() - 1, CHAIN_MAX).0)
    }

    /// The operand that ends before token `end`, and the token it begins with.
    fn operand_before(&self, end: usize, links: u32) -> (TypeRef, usize) {
        let Some(at) = end.checked_sub(1) else {
            return (TypeRef::Unknown, end);
        };
        let Some(links) = links.checked_sub(1) else {
            return (TypeRef::Unknown, at);
        };
        let token = self.tokens[at];
        let begins_before =
            |kind: T| matches!(kind, T::Name | T::RightParen | T::RightBracket | T::Str);
        let before = |at: usize| at.checked_sub(1).map(|at| self.tokens[at].kind);
        match token.kind {
            T::Name => match before(at) {
                Some(T::Dot) => {
                    let (value, start) = self.operand_before(at - 1, links);
                    let name = self.text(token).into();
                    (TypeRef::Attribute(Box::new(value), name), start)
                }
                _ => (TypeRef::Name(self.scope, self.text(token).into()), at),
            },
            T::Str => match self.text(token).to_ascii_lowercase().starts_with(['b']) {
                true => (TypeRef::Value("bytes"), at),
                false => (TypeRef::Value("str"), at),
            },
            T::Int => (TypeRef::Value("int"), at),
            T::Float => (TypeRef::Value("float"), at),
            T::RightBrace => (TypeRef::Value("dict"), self.opening(at)),
            T::RightParen => {
                let open = self.opening(at);
                if before(open).is_some_and(begins_before) {
                    let (function, start) = self.operand_before(open, links);
                    return (TypeRef::Call(Box::new(function)), start);
                }
                // One operand in parentheses is that operand.
                let (inner, start) = self.operand_before(at, links);
                match start == open + 1 {
                    true => (inner, open),
                    false => (TypeRef::Unknown, open),
                }
            }
            T::RightBracket => {
                let open = self.opening(at);
                if before(open).is_some_and(begins_before) {
                    let (value, start) = self.operand_before(open, links);
                    return (TypeRef::Item(Box::new(value)), start);
                }
                (TypeRef::Value("list"), open)
            }
            _ => (TypeRef::Unknown, at),
        }
    }

    /// The bracket that the one at `at` closes.
    fn opening(&self, at: usize) -> usize {
        let mut depth = 0u32;
        for (index, token) in self.tokens[..=at].iter().enumerate().rev() {
            match token.kind {
                T::RightParen | T::RightBracket | T::RightBrace => depth += 1,
                T::LeftParen | T::LeftBracket | T::LeftBrace => {
                    depth = depth.saturating_sub(1);
                    if depth == 0 {
                        return index;
                    }
                }
                _ => {}
            }
        }
        0
    }

    /// The innermost call around the cursor.
    pub fn call(&self) -> Option<OpenCall> {
        let mut depth = 0u32;
        let mut position = 0;
        let mut given = Vec::new();
        let mut keyword = None;
        for (index, token) in self.tokens.iter().enumerate().rev() {
            match token.kind {
                T::RightParen | T::RightBracket | T::RightBrace => depth += 1,
                T::LeftParen if depth == 0 => {
                    let before = index.checked_sub(1).map(|at| self.tokens[at].kind);
                    let defines = index >= 2
                        && (matches!(self.tokens[index - 2].kind, T::Def | T::Class)
                            || self.text(self.tokens[index - 2]) == "sec");
                    if defines || !matches!(before, Some(T::Name | T::RightParen | T::RightBracket))
                    {
                        // Parentheses around an expression, perhaps within a call.
                        position = 0;
                        given.clear();
                        keyword = None;
                        if defines {
                            return None;
                        }
                        continue;
                    }
                    let (function, _) = self.operand_before(index, CHAIN_MAX);
                    return Some(OpenCall {
                        function,
                        position,
                        keyword,
                        given,
                    });
                }
                T::LeftBracket | T::LeftBrace if depth == 0 => {
                    position = 0;
                    given.clear();
                    keyword = None;
                }
                T::LeftParen | T::LeftBracket | T::LeftBrace => depth -= 1,
                T::Comma if depth == 0 => position += 1,
                T::Equal if depth == 0 => {
                    let name = index.checked_sub(1).map(|at| self.tokens[at]);
                    if let Some(name) = name.filter(|name| name.kind == T::Name) {
                        let name = self.text(name).to_owned();
                        if position == 0 {
                            keyword = Some(name.clone());
                        }
                        given.push(name);
                    }
                }
                // A call over several lines that is not closed yet: the line before goes on.
                T::Newline if index > 0 && goes_on_after(self.tokens[index - 1].kind) => {}
                T::Newline => return None,
                _ => {}
            }
        }
        None
    }
}

/// Whether a line that ends with this is not at its end.
fn goes_on_after(kind: T) -> bool {
    matches!(
        kind,
        T::Comma | T::LeftParen | T::LeftBracket | T::LeftBrace | T::Equal
    )
}
