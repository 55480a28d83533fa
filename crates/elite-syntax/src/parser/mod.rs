//! From tokens to the tree: recursive descent for statements, Pratt parsing for expressions.
//!
//! Always returns a tree and the list of errors: after an error it goes on with the next line, so several slips
//! are reported in one go. Names are not looked up here (`resolve` does), but everything the grammar alone decides
//! is: where `return`, `yield`, `break` may stand, what can be assigned to, how deep things may nest.

mod aside;
mod atom;
mod compound;
mod directive;
mod expr;
mod fstring;
mod literal;
mod params;
mod remains;
mod stmt;
mod strings;
mod target;
mod units;

use messages::{Text, text};

use crate::ast::{DirectiveAnchor, Expr, ExprKind, Ident, Module, ScopeId, Stmt};
use crate::diagnostic::{Diagnostic, Severity};
use crate::diagnostic_list::{DiagnosticList, quoted, sort_and_cap};
use crate::lexer::{Token, TokenKind, Tokens, lex, lex_expression, too_large};
use crate::source::{SourceFile, Span};
use crate::work_budget::WorkBudget;

pub(crate) use units::{ParsedUnits, TextEdit, TopLevelUnit, reparse};

/// Nesting of brackets, blocks and prefix operators that is accepted.
const NESTING_MAX: u32 = 200;
/// Levels of the tree of one expression: chains of operators, calls and attributes add one for each link.
const EXPR_DEPTH_MAX: u16 = 1000;
/// Longest name of a class, in bytes, that private names are made with: each use of one repeats it.
const PRIVATE_CLASS_MAX: usize = 255;

/// Most bytes that tokens and tree of one text may take. What is made of the tree to run it takes about as much again.
pub const TREE_MAX: usize = 256 << 20;
/// Work for what the tree has of one token.
const TOKEN: usize = 160;
/// Tokens between two looks at what the tree takes.
const LOOK_EVERY: usize = 256;

/// What the parser makes of a text.
pub struct ParserOutput {
    /// The tree; where there were errors it has gaps.
    pub module: Module,
    /// Errors and warnings of lexer and parser, in the order of the text.
    pub diagnostics: Vec<Diagnostic>,
    /// Bytes that the tree takes.
    pub bytes: usize,
}

/// Parses a whole program.
pub fn parse(file: &SourceFile) -> ParserOutput {
    parse_within(file, &WorkBudget::with_limit(TREE_MAX))
}

/// Parses a whole program with what its text may take. One that needs more has one error, `too-large`.
pub fn parse_within(file: &SourceFile, budget: &WorkBudget<'_>) -> ParserOutput {
    let mut parser = parse_tokens(file, lex(file, budget), budget);
    let body = parser.statements_until_end();
    parser.finish(body)
}

/// A parser that stands at the first token of a whole program.
fn parse_tokens<'f>(file: &'f SourceFile, lexed: Tokens, budget: &'f WorkBudget<'f>) -> Parser<'f> {
    let mut parser = Parser::new(file, lexed.tokens, lexed.diagnostics, budget);
    parser.cuts = lexed.unclosed_cuts;
    parser.print_is_assigned = parser.assigns_print();
    parser.directives(&lexed.directives);
    parser
}

/// Parses the text of one expression, as `eval` takes it.
pub fn parse_expression(
    file: &SourceFile,
    budget: &WorkBudget<'_>,
) -> (Option<Expr>, ParserOutput) {
    let text = file.text();
    let start = text.len() - text.trim_start_matches([' ', '\t']).len();
    let lexed = lex_expression(
        file,
        Span::new(start, text.trim_end().len().max(start)),
        budget,
    );
    let mut parser = Parser::new(file, lexed.tokens, lexed.diagnostics, budget);
    let expr = parser.whole_expression().ok();
    (expr, parser.finish(Vec::new()))
}

/// Says that an error has been reported and this construct given up.
#[derive(Clone, Copy, Debug)]
struct ErrorReported;

type ParseResult<T> = Result<T, ErrorReported>;

/// What surrounds the statement being parsed.
#[derive(Clone, Copy, Default)]
struct Context {
    in_function: bool,
    in_loop: bool,
}

struct Parser<'f> {
    file: &'f SourceFile,
    tokens: Vec<Token>,
    at: usize,
    /// What the lexer found; where it found something the parser keeps silent.
    lexer_diagnostics: DiagnosticList,
    diagnostics: DiagnosticList,
    /// How often something was found wrong, told or not.
    report_count: usize,
    nesting: u32,
    scope_count: u32,
    context: Context,
    /// Names of the classes around, for private names.
    classes: Vec<Box<str>>,
    /// Where the lexer cut a line short because a bracket was never closed: what fails there has been reported.
    cuts: Vec<u32>,
    /// What the end of the tokens is called.
    end: Text,
    /// The script assigns `print`, so `print x` is not rewritten.
    print_is_assigned: bool,
    /// The directives; `claimed` of them have their place.
    marks: Vec<directive::ParsedDirective>,
    claimed: usize,
    /// Blocks around the statement being parsed.
    depth: u32,
    /// What tokens and tree may take; spent, the parser is at the end of the text.
    budget: &'f WorkBudget<'f>,
    is_too_large: bool,
    /// What is no part of the tree after all.
    aside: Vec<aside::AbandonedNodes>,
}

impl<'f> Parser<'f> {
    fn new(
        file: &'f SourceFile,
        tokens: Vec<Token>,
        lexed: DiagnosticList,
        budget: &'f WorkBudget<'f>,
    ) -> Self {
        let context = Context::default();
        let classes = Vec::new();
        Parser {
            file,
            tokens,
            at: 0,
            lexer_diagnostics: lexed,
            diagnostics: DiagnosticList::default(),
            report_count: 0,
            nesting: 0,
            scope_count: 1,
            context,
            classes,
            cuts: Vec::new(),
            print_is_assigned: false,
            marks: Vec::new(),
            claimed: 0,
            depth: 0,
            budget,
            is_too_large: false,
            aside: Vec::new(),
            end: TokenKind::EndOfFile.describe(),
        }
    }

    fn finish(self, mut body: Vec<Stmt>) -> ParserOutput {
        let mut diagnostics = self.lexer_diagnostics.into_vec();
        diagnostics.extend(self.diagnostics.into_vec());
        let span = Span::new(0, self.file.text().len());
        drop(self.tokens);
        for parts in self.aside {
            parts.release(self.budget);
        }
        let mut nodes: Vec<_> = self.marks.into_iter().map(|mark| mark.node).collect();
        if self.is_too_large {
            (body, nodes) = (Vec::new(), Vec::new());
            diagnostics = vec![too_large(self.budget)];
        }
        ParserOutput {
            module: Module {
                body,
                span,
                scope_count: self.scope_count,
                nodes,
            },
            bytes: self.budget.used(),
            diagnostics: sort_and_cap(diagnostics),
        }
    }

    fn statements_until_end(&mut self) -> Vec<Stmt> {
        let mut body = Vec::new();
        while self.kind() != TokenKind::EndOfFile {
            self.statement_or_recover(&mut body);
        }
        self.anchor_directives(u32::MAX, DirectiveAnchor::AtEnd);
        body
    }

    fn whole_expression(&mut self) -> ParseResult<Expr> {
        let expr = self.expression_list()?;
        if let ExprKind::Starred(_) = expr.kind {
            return self.fail(
                expr.span,
                text!(
                    "a starred expression cannot stand here",
                    "这里不能使用带星号的表达式"
                ),
            );
        }
        if self.kind() != TokenKind::EndOfFile {
            let failed = self.unexpected::<()>(text!("the end of the expression", "表达式的结尾"));
            return self.keep_or_abandon(expr, failed).map(|(expr, ())| expr);
        }
        Ok(expr)
    }

    fn token(&self) -> Token {
        self.tokens[self.at.min(self.tokens.len() - 1)]
    }

    fn kind(&self) -> TokenKind {
        self.token().kind
    }

    /// Kind of the token `ahead` places after the current one.
    fn kind_ahead(&self, ahead: usize) -> TokenKind {
        self.tokens
            .get(self.at + ahead)
            .map_or(TokenKind::EndOfFile, |token| token.kind)
    }

    fn text(&self, token: Token) -> &'f str {
        self.file.slice(token.span)
    }

    /// Takes the current token.
    fn bump(&mut self) -> Token {
        let token = self.token();
        if self.at + 1 < self.tokens.len() {
            self.at += 1;
        }
        self.budget.charge(TOKEN);
        if self.at.is_multiple_of(LOOK_EVERY) && self.budget.is_spent() {
            // At the end of the text every construct ends.
            self.is_too_large = true;
            self.at = self.tokens.len() - 1;
        }
        token
    }

    /// Takes the current token if it is of this kind.
    fn eat(&mut self, kind: TokenKind) -> Option<Token> {
        (self.kind() == kind).then(|| self.bump())
    }

    fn expect(&mut self, kind: TokenKind) -> ParseResult<Token> {
        match self.eat(kind) {
            Some(token) => Ok(token),
            None => self.unexpected_instead_of(Some(kind), kind.describe()),
        }
    }

    /// The span from `start` to the last token taken.
    fn span_from(&self, start: Span) -> Span {
        let last = self
            .at
            .checked_sub(1)
            .and_then(|i| self.tokens.get(i))
            .map_or(start, |token| token.span);
        Span {
            start: start.start,
            end: last.end.max(start.end),
        }
    }

    fn report(&mut self, diagnostic: Diagnostic) -> ErrorReported {
        self.report_count += 1;
        // What the lexer reported at this very place is not reported again in other words.
        let span = diagnostic.span;
        let at_cut = self.cuts.contains(&span.start);
        let known = at_cut
            || self
                .lexer_diagnostics
                .iter()
                .chain(self.diagnostics.iter())
                .any(|other| {
                    let overlaps = other.span.start <= span.end && span.start <= other.span.end;
                    other.severity == Severity::Error && overlaps
                });
        if !known {
            self.diagnostics.push(diagnostic);
        }
        ErrorReported
    }

    fn fail<T>(&mut self, span: Span, message: Text) -> ParseResult<T> {
        Err(self.report(Diagnostic::error("syntax", span, message)))
    }

    /// Reports that `expected` should stand here.
    fn unexpected<T>(&mut self, expected: Text) -> ParseResult<T> {
        self.unexpected_instead_of(None, expected)
    }

    /// Reports that `expected` should stand here, where that begins with a token of a certain kind.
    fn unexpected_instead_of<T>(
        &mut self,
        kind: Option<TokenKind>,
        expected: Text,
    ) -> ParseResult<T> {
        let token = self.token();
        let found = match token.kind {
            TokenKind::Name => Text::verbatim(format!("'{}'", quoted(self.text(token)))),
            TokenKind::Int | TokenKind::Float | TokenKind::Imaginary => {
                text!("the number {}", "数 {}", quoted(self.text(token)))
            }
            TokenKind::EndOfFile => self.end.clone(),
            kind => kind.describe(),
        };
        let mut diagnostic = Diagnostic::error(
            "syntax",
            token.span,
            text!(
                "expected {expected}, found {found}",
                "应为{expected}，却是{found}"
            ),
        );
        if self.begins_loop_of_c() {
            diagnostic = diagnostic.with_help(text!(
                "write 'for i in range(3):'",
                "请写 'for i in range(3):'"
            ));
        } else if token.kind == TokenKind::Equal && kind == Some(TokenKind::In) {
            diagnostic = diagnostic.with_help(text!(
                "write 'for i in range(first, last + 1):'",
                "请写 'for i in range(first, last + 1):'"
            ));
        } else if token.kind == TokenKind::Equal {
            diagnostic = diagnostic
                .with_help(text!(
                    "'=' assigns; use '==' to compare",
                    "'=' 用于赋值；比较请用 '=='"
                ))
                .with_fix(token.span, "==");
        } else if kind == Some(TokenKind::Colon) && self.begins_block_elsewhere() {
            diagnostic = diagnostic
                .with_help(text!(
                    "a block begins with ':' and ends with 'end'",
                    "块以 ':' 开始，以 'end' 结束"
                ))
                .with_fix(token.span, ":");
        } else if let Some((help, word)) = self.foreign_operator() {
            diagnostic = diagnostic.with_help(help);
            if let (Some(word), Some(before)) = (word, self.at.checked_sub(1)) {
                diagnostic = diagnostic.with_fix(self.tokens[before].span.to(token.span), word);
            }
        } else if token.kind.is_keyword() && kind == Some(TokenKind::Name) {
            diagnostic = diagnostic.with_help(text!(
                "'{}' is a keyword and cannot be a name",
                "'{}' 是关键字，不能用作名称",
                self.text(token)
            ));
        }
        Err(self.report(diagnostic))
    }

    /// Whether a word or sign stands here that begins a block in other languages.
    fn begins_block_elsewhere(&self) -> bool {
        let token = self.token();
        token.kind == TokenKind::LeftBrace
            || (token.kind == TokenKind::Name
                && matches!(self.text(token), "then" | "do" | "begin"))
    }

    /// Whether the text up to here is that of a loop of C: `for (i =`, `for (int i`.
    fn begins_loop_of_c(&self) -> bool {
        let before = self.tokens[..self.at].iter().rev().map(|token| token.kind);
        let before = before.skip_while(|kind| *kind == TokenKind::Name).take(2);
        let begins_loop = before.eq([TokenKind::LeftParen, TokenKind::For]);
        begins_loop && matches!(self.kind(), TokenKind::Equal | TokenKind::Name)
    }

    /// Advice where an operator of another language stands, and the word that takes its place and that of the token
    /// before it.
    fn foreign_operator(&self) -> Option<(Text, Option<&'static str>)> {
        if self.kind() == TokenKind::DoubleSlash {
            return Some((text!("a comment begins with '#'", "注释以 '#' 开头"), None));
        }
        let before = self.at.checked_sub(1).map(|at| self.tokens[at].kind)?;
        let word = match (before, self.kind()) {
            (TokenKind::Else, TokenKind::If) => "elif",
            (TokenKind::Ampersand, TokenKind::Ampersand) => "and",
            (TokenKind::Bar, TokenKind::Bar) => "or",
            (TokenKind::Plus, TokenKind::Newline) if self.at >= 2 => {
                let is_increment = self.tokens[self.at - 2].kind == TokenKind::Plus;
                return is_increment.then(|| (text!("write 'x += 1'", "请写 'x += 1'"), None));
            }
            _ => return None,
        };
        Some((text!("write '{word}'", "请写 '{word}'"), Some(word)))
    }

    fn not_supported<T>(&mut self, span: Span, what: Text) -> ParseResult<T> {
        Err(self.report(Diagnostic::error(
            "not-supported",
            span,
            text!("{what} is not supported", "不支持{what}"),
        )))
    }

    /// Runs `inner` one level deeper, or reports that the text nests too deeply.
    fn nested<T>(&mut self, inner: impl FnOnce(&mut Self) -> ParseResult<T>) -> ParseResult<T> {
        if self.nesting == NESTING_MAX {
            let span = self.token().span;
            return self.fail(
                span,
                text!(
                    "this nests deeper than {NESTING_MAX} levels",
                    "嵌套超过 {NESTING_MAX} 层"
                ),
            );
        }
        self.nesting += 1;
        let result = inner(self);
        self.nesting -= 1;
        result
    }

    fn new_scope(&mut self) -> ScopeId {
        self.scope_count += 1;
        ScopeId(self.scope_count - 1)
    }

    fn ident(&mut self) -> ParseResult<Ident> {
        let token = self.expect(TokenKind::Name)?;
        Ok(Ident {
            name: self.mangle(token)?,
            span: token.span,
        })
    }

    /// Private names `__x` inside a class are kept apart from those of other classes (Python, "Private name mangling").
    fn mangle(&mut self, token: Token) -> ParseResult<Box<str>> {
        let name = self.text(token);
        let private = name.starts_with("__") && !name.ends_with("__");
        match self.classes.last() {
            Some(class) if private && class.len() > PRIVATE_CLASS_MAX => {
                let text = text!(
                    "private names need a class whose name has at most {PRIVATE_CLASS_MAX} bytes",
                    "使用私有名称的类，其名称最多 {PRIVATE_CLASS_MAX} 字节"
                );
                self.fail(token.span, text)
            }
            Some(class) if private => {
                Ok(format!("_{}{name}", class.trim_start_matches('_')).into())
            }
            _ => Ok(name.into()),
        }
    }

    fn name_expr(&mut self) -> ParseResult<Expr> {
        let ident = self.ident()?;
        Ok(Expr::new(ExprKind::Name(ident.name), ident.span))
    }
}
