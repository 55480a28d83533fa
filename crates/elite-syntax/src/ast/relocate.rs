//! Moves a tree that is kept while the text around it changes: every place in it by the same number of bytes, every
//! scope by the same number.

use super::visit::{NodePartMut, expression_parts_mut, statement_parts_mut};
use super::{DirectiveAnchor, Stmt};
use crate::source::Span;

/// How far parts of a tree move. Numbers wrap around: a way back is a large number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Shift {
    bytes: u32,
    scopes: u32,
}

impl Shift {
    /// From one offset and scope to another.
    pub(crate) fn between(old: (u32, u32), new: (u32, u32)) -> Self {
        Shift {
            bytes: new.0.wrapping_sub(old.0),
            scopes: new.1.wrapping_sub(old.1),
        }
    }

    /// An offset at its new place.
    pub(crate) fn offset(self, offset: u32) -> u32 {
        offset.wrapping_add(self.bytes)
    }

    /// A span at its new place.
    pub(crate) fn moved(self, span: Span) -> Span {
        Span {
            start: self.offset(span.start),
            end: self.offset(span.end),
        }
    }

    /// A directive's place.
    pub(crate) fn node_place(self, place: DirectiveAnchor) -> DirectiveAnchor {
        match place {
            DirectiveAnchor::Before(at) => DirectiveAnchor::Before(self.offset(at)),
            DirectiveAnchor::After(at) => DirectiveAnchor::After(self.offset(at)),
            DirectiveAnchor::AtEnd => DirectiveAnchor::AtEnd,
        }
    }

    fn span(self, span: &mut Span) {
        *span = self.moved(*span);
    }

    /// Moves statements with all that is in them.
    pub(crate) fn statements(self, statements: &mut [Stmt]) {
        if self != Shift::default() {
            self.block(statements);
        }
    }

    fn block(self, block: &mut [Stmt]) {
        for statement in block {
            statement_parts_mut(statement, &mut |part| self.part(part));
        }
    }

    fn part(self, part: NodePartMut<'_>) {
        match part {
            NodePartMut::Expr(expr)
            | NodePartMut::ClauseTarget(expr)
            | NodePartMut::Annotation(expr) => {
                self.span(&mut expr.span);
                expression_parts_mut(&mut expr.kind, &mut |part| self.part(part));
            }
            NodePartMut::Name(name) => self.span(&mut name.span),
            NodePartMut::Block(block) => self.block(block),
            NodePartMut::Scope(scope) => scope.0 = scope.0.wrapping_add(self.scopes),
            NodePartMut::Span(span) => self.span(span),
        }
    }
}
