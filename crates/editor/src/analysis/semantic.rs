//! Every word of a text with what it is, for colours.

use elite_syntax::Span;
use elite_syntax::lexer::TokenKind as T;

use super::Analysis;
use super::scopes::{Role, ScopeKind, SymbolKind};
use super::types::{Type, TypeRef};

/// What a piece of text is. The order is that of the numbers which clients are told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs, reason = "the names say it")]
pub enum SemanticTokenKind {
    Keyword,
    Comment,
    String,
    Number,
    Operator,
    Variable,
    Parameter,
    Function,
    Method,
    Class,
    Property,
    Namespace,
    Macro,
}

impl SemanticTokenKind {
    /// The protocol's names, in the order of the numbers.
    pub const NAMES: [&'static str; 13] = [
        "keyword",
        "comment",
        "string",
        "number",
        "operator",
        "variable",
        "parameter",
        "function",
        "method",
        "class",
        "property",
        "namespace",
        "macro",
    ];
}

/// A piece of text on one line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SemanticToken {
    /// Place of the token in the text.
    pub span: Span,
    /// What it is.
    pub kind: SemanticTokenKind,
    /// The name is bound here.
    pub is_declared: bool,
    /// The robot or Python provides it.
    pub is_builtin: bool,
}

/// The words of a text that touch `within`, in its order, none over another.
pub fn semantic_tokens(analysis: &Analysis, within: Span) -> Vec<SemanticToken> {
    let mut found: Vec<SemanticToken> = Vec::new();
    let touches = |span: Span| span.start <= within.end && within.start <= span.end;
    names(analysis, within, &mut found);
    let named: Vec<Span> = sorted(&mut found);
    for token in analysis.tokens().iter().filter(|token| touches(token.span)) {
        let kind = match token.kind {
            T::End => SemanticTokenKind::Keyword,
            T::Str => {
                pieces(
                    analysis,
                    token.span,
                    &named,
                    SemanticTokenKind::String,
                    &mut found,
                );
                continue;
            }
            T::Int | T::Float | T::Imaginary => SemanticTokenKind::Number,
            T::Newline | T::Indent | T::Dedent | T::EndOfFile | T::Unknown => continue,
            T::Name if analysis.file.slice(token.span) == "sec" && !has(&named, token.span) => {
                SemanticTokenKind::Keyword
            }
            T::Name if has(&named, token.span) => continue,
            // In a line that does not parse.
            T::Name => SemanticTokenKind::Variable,
            kind if kind.is_keyword() => SemanticTokenKind::Keyword,
            T::LeftParen
            | T::RightParen
            | T::LeftBracket
            | T::RightBracket
            | T::LeftBrace
            | T::RightBrace
            | T::Comma
            | T::Colon
            | T::Dot
            | T::Semicolon => continue,
            _ => SemanticTokenKind::Operator,
        };
        found.push(plain(token.span, kind));
    }
    for comment in analysis
        .comments()
        .into_iter()
        .filter(|span| touches(*span))
    {
        let is_directive = analysis.file.slice(comment).starts_with('$');
        let kind = if is_directive {
            SemanticTokenKind::Macro
        } else {
            SemanticTokenKind::Comment
        };
        found.push(plain(comment, kind));
    }
    found.sort_by_key(|word| word.span.start);
    // Nothing lies over anything else, whatever the text was.
    let mut end = 0;
    found.retain(|word| {
        let free = word.span.start >= end && word.span.end > word.span.start;
        end = if free { word.span.end } else { end };
        free
    });
    found
}

fn plain(span: Span, kind: SemanticTokenKind) -> SemanticToken {
    SemanticToken {
        span,
        kind,
        is_declared: false,
        is_builtin: false,
    }
}

fn sorted(found: &mut [SemanticToken]) -> Vec<Span> {
    found.sort_by_key(|word| word.span.start);
    found.iter().map(|word| word.span).collect()
}

fn has(named: &[Span], span: Span) -> bool {
    named
        .binary_search_by_key(&span.start, |known| known.start)
        .is_ok()
}

fn names(analysis: &Analysis, within: Span, found: &mut Vec<SemanticToken>) {
    let names = &analysis.names;
    let touches = |span: Span| span.start <= within.end && within.start <= span.end;
    for (occurrence, symbol) in names.places().iter().filter(|(o, _)| touches(o.span)) {
        let (kind, is_builtin) = match symbol {
            Some(symbol) => {
                let symbol = &names.symbols[*symbol];
                let of_class = names.scopes[symbol.scope].kind == ScopeKind::Class;
                let kind = match symbol.kind {
                    SymbolKind::Variable if of_class => SemanticTokenKind::Property,
                    SymbolKind::Variable => SemanticTokenKind::Variable,
                    SymbolKind::Parameter => SemanticTokenKind::Parameter,
                    SymbolKind::Function if of_class => SemanticTokenKind::Method,
                    SymbolKind::Function => SemanticTokenKind::Function,
                    SymbolKind::Class => SemanticTokenKind::Class,
                    SymbolKind::Import => SemanticTokenKind::Namespace,
                };
                (kind, false)
            }
            None => {
                let name = analysis.file.slice(occurrence.span);
                let shape = TypeRef::Name(occurrence.scope, name.into());
                match analysis.infer(&shape) {
                    Type::Robot(_) => (SemanticTokenKind::Function, true),
                    Type::Python(_) => {
                        let is_class = matches!(super::library::PYTHON.get(name), Some(m)
                            if m.kind == elite_lang::library::MemberKind::Class);
                        let kind = if is_class {
                            SemanticTokenKind::Class
                        } else {
                            SemanticTokenKind::Function
                        };
                        (kind, true)
                    }
                    Type::Test => (SemanticTokenKind::Variable, true),
                    _ => (SemanticTokenKind::Variable, false),
                }
            }
        };
        found.push(SemanticToken {
            span: occurrence.span,
            kind,
            is_declared: occurrence.role == Role::Bind,
            is_builtin,
        });
    }
    for used in names
        .attribute_uses
        .iter()
        .filter(|used| touches(used.span))
    {
        let shape = TypeRef::Attribute(Box::new(used.value.clone()), used.name.clone());
        let (kind, is_builtin) = match analysis.infer(&shape) {
            Type::Function(_) => (SemanticTokenKind::Method, false),
            Type::Method(..) | Type::TestFunction(_) => (SemanticTokenKind::Method, true),
            Type::Member(..) => (SemanticTokenKind::Function, true),
            Type::Module(_) => (SemanticTokenKind::Namespace, true),
            _ => (SemanticTokenKind::Property, false),
        };
        found.push(SemanticToken {
            span: used.span,
            kind,
            is_declared: used.is_bound,
            is_builtin,
        });
    }
    for used in names
        .keyword_uses
        .iter()
        .filter(|used| &*used.name != "**" && touches(used.span))
    {
        found.push(plain(used.span, SemanticTokenKind::Parameter));
    }
}

/// A text of several lines, line by line, without the names in it.
fn pieces(
    analysis: &Analysis,
    span: Span,
    named: &[Span],
    kind: SemanticTokenKind,
    found: &mut Vec<SemanticToken>,
) {
    let from = named.partition_point(|name| name.start < span.start);
    let inside = named[from..].iter().take_while(|name| name.end <= span.end);
    let mut at = span.start;
    let mut put = |start: u32, end: u32| {
        let text = analysis.file.slice(Span { start, end });
        let mut line_start = start;
        for line in text.split_inclusive(['\n', '\r']) {
            let shown = line.trim_end_matches(['\n', '\r']).len() as u32;
            found.push(plain(
                Span {
                    start: line_start,
                    end: line_start + shown,
                },
                kind,
            ));
            line_start += line.len() as u32;
        }
    };
    for name in inside {
        put(at, name.start);
        at = name.end;
    }
    put(at, span.end);
}
