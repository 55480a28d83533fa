//! What can be told of a statement that does not parse, so that one half-typed line spoils nothing else: the block
//! below it stays in the tree, a `def` or `class` is still one, an assignment still binds its name. Programs with
//! errors are never run; editors read them all the time.

use super::Parser;
use crate::ast::{
    ClassDef, Constant, Expr, ExprKind, FunctionDef, Ident, Parameter, Parameters, Stmt, StmtKind,
};
use crate::lexer::TokenKind as T;
use crate::source::Span;

impl Parser<'_> {
    /// Adds to `body` what is left of the statement that began with token `first`; `below` was in its block.
    pub(super) fn recover_statement(
        &mut self,
        first: usize,
        below: Vec<Stmt>,
        body: &mut Vec<Stmt>,
    ) {
        let head = self.tokens.get(first).map(|token| token.kind);
        let named = self.ident_at(first + 1);
        let kind = match (head, named) {
            (Some(T::Def), Some(name)) => self.function_remains(name, first, below),
            (Some(T::Name), Some(name)) if self.text(self.tokens[first]) == "sec" => {
                self.function_remains(name, first, below)
            }
            (Some(T::Class), Some(name)) => StmtKind::Class(Box::new(ClassDef {
                name,
                args: Vec::new(),
                decorators: Vec::new(),
                body: below,
                scope: self.new_scope(),
            })),
            _ => {
                body.extend(self.assignment_remains(first));
                body.extend(below);
                return;
            }
        };
        let span = self.span_from(self.tokens[first].span);
        body.push(Stmt { kind, span });
    }

    fn ident_at(&self, at: usize) -> Option<Ident> {
        let token = *self.tokens.get(at)?;
        (token.kind == T::Name).then(|| Ident {
            name: self.text(token).into(),
            span: token.span,
        })
    }

    /// A function whose header is broken: its parameters are the names that stand where parameters stand.
    fn function_remains(&mut self, name: Ident, first: usize, body: Vec<Stmt>) -> StmtKind {
        let mut parameters = Parameters::default();
        let mut at = first + 3;
        let mut depth = 1u32;
        while let Some(token) = self.tokens.get(at) {
            match token.kind {
                T::LeftParen | T::LeftBracket | T::LeftBrace => depth += 1,
                T::RightParen | T::RightBracket | T::RightBrace => {
                    depth = depth.saturating_sub(1);
                }
                T::Newline | T::Colon | T::EndOfFile => break,
                _ => {}
            }
            let before = self.tokens[at - 1].kind;
            let is_place = matches!(before, T::LeftParen | T::Comma | T::Star | T::DoubleStar);
            if let (1, true, Some(name)) = (depth, is_place, self.ident_at(at)) {
                parameters.positional.push(Parameter {
                    name,
                    annotation: None,
                    default: None,
                });
            }
            at += 1;
        }
        StmtKind::Function(Box::new(FunctionDef {
            name,
            parameters,
            returns: None,
            decorators: Vec::new(),
            body,
            secondary: false,
            scope: self.new_scope(),
        }))
    }

    /// `name = …` still binds the name.
    fn assignment_remains(&self, first: usize) -> Option<Stmt> {
        let name = self.ident_at(first)?;
        let equal = self.tokens.get(first + 1)?;
        if equal.kind != T::Equal {
            return None;
        }
        let (start, end) = (name.span, equal.span);
        let gap = Expr::new(
            ExprKind::Constant(Constant::Ellipsis),
            Span {
                start: end.end,
                end: end.end,
            },
        );
        let target = Expr::new(ExprKind::Name(name.name), start);
        Some(Stmt {
            kind: StmtKind::Assign {
                targets: vec![target],
                value: gap,
            },
            span: start.to(end),
        })
    }
}
