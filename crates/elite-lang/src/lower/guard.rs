//! Blocks and what protects statements in them: the statements of a `try` stand among those of the block around it.

use elite_syntax::ast::{self, Stmt, StmtKind};

use super::{Lower, NumberedStmt};
use crate::eval::DynStmt;
use crate::eval::code::Block;
use crate::eval::stmt::handle::{ExceptClause, Finally, ProtectedRange};
use crate::eval::stmt::handle_star::TryStar;
use crate::limits::deferred_drop::NodeList;

/// What a block is made of.
#[derive(Default)]
pub(super) struct BlockBuilder {
    /// The statements of the block.
    pub statements: Vec<NumberedStmt>,
    /// What protects some of them, by where that ends, inner ones first.
    pub guards: Vec<ProtectedRange>,
}

impl From<BlockBuilder> for Block {
    fn from(lines: BlockBuilder) -> Self {
        Block::new(lines.statements, lines.guards)
    }
}

impl Lower<'_> {
    /// A block of these statements.
    pub(super) fn block(&mut self, body: &[Stmt]) -> Block {
        let mut lines = BlockBuilder::default();
        self.deeper(|lower| lower.add_lines(body, &mut lines));
        lines.into()
    }

    /// Adds a `try` to the block around it, if nobody watches that as one statement and it has neither `except*` nor
    /// `finally`. Whether it has been added.
    pub(super) fn add_inline_try(&mut self, statement: &Stmt, lines: &mut BlockBuilder) -> bool {
        match &statement.kind {
            StmtKind::Try {
                body,
                handlers,
                orelse,
                finally,
            } if self.debugger.is_none() && finally.is_empty() && !has_star(handlers) => {
                self.add_protected_range(body, handlers, orelse, lines);
                true
            }
            _ => false,
        }
    }

    fn add_protected_range(
        &mut self,
        body: &[Stmt],
        handlers: &[ast::Handler],
        orelse: &[Stmt],
        lines: &mut BlockBuilder,
    ) {
        self.deeper(|lower| {
            let start = lines.statements.len();
            lower.add_lines(body, lines);
            let body = start..lines.statements.len();
            let (guard, after) = (lines.guards.len(), body.end);
            lines.guards.push(ProtectedRange {
                body,
                after,
                handlers: lower.handlers(handlers),
            });
            lower.add_lines(orelse, lines);
            lines.guards[guard].after = lines.statements.len();
        });
    }

    /// A `try` as a statement of its own.
    pub(super) fn try_statement(
        &mut self,
        line: u32,
        body: &[Stmt],
        handlers: &[ast::Handler],
        orelse: &[Stmt],
        finally: &[Stmt],
    ) -> Box<dyn DynStmt> {
        let protected = if handlers.is_empty() {
            self.block(body)
        } else if has_star(handlers) {
            let node = Box::new(TryStar {
                body: self.block(body),
                handlers: self.handlers(handlers),
                orelse: self.block(orelse),
            });
            Block::new(vec![(line, node)], Vec::new())
        } else {
            let mut lines = BlockBuilder::default();
            self.add_protected_range(body, handlers, orelse, &mut lines);
            lines.into()
        };
        if finally.is_empty() {
            return Box::new(protected);
        }
        self.deeper(|lower| {
            Box::new(Finally {
                body: protected,
                finally: lower.block(finally),
            })
        })
    }

    fn handlers(&mut self, handlers: &[ast::Handler]) -> NodeList<ExceptClause> {
        let handlers = handlers.iter().map(|handler| self.handler(handler));
        handlers.collect()
    }

    fn handler(&mut self, handler: &ast::Handler) -> ExceptClause {
        ExceptClause {
            span: handler
                .exception
                .as_ref()
                .map_or(handler.span, |exception| exception.span),
            exception: handler
                .exception
                .as_ref()
                .map(|exception| self.expr(exception)),
            name: handler
                .name
                .as_ref()
                .map(|name| self.name_target(&name.name, name.span)),
            body: self.block(&handler.body),
        }
    }
}

/// Whether the clauses are `except*`.
fn has_star(handlers: &[ast::Handler]) -> bool {
    handlers.iter().any(|handler| handler.star)
}
