//! What can be assigned to, deleted, or bound by `for` and `with`.

use super::{ParseResult, Parser};
use crate::ast::{Expr, ExprKind};
use crate::diagnostic::Diagnostic;
use crate::source::Span;

impl Parser<'_> {
    /// A target of an assignment, `for` or `with`: names, attributes, items, and lists or tuples of them.
    pub(super) fn check_target(&mut self, target: &Expr) -> ParseResult<()> {
        match &target.kind {
            ExprKind::Name(_) | ExprKind::Attribute { .. } | ExprKind::Subscript { .. } => Ok(()),
            ExprKind::Tuple(items) | ExprKind::List(items) => {
                let stars = items
                    .iter()
                    .filter(|item| matches!(item.kind, ExprKind::Starred(_)))
                    .count();
                if stars > 1 {
                    return self.fail(target.span, "only one target may be starred");
                }
                for item in items {
                    match &item.kind {
                        ExprKind::Starred(inner) => self.check_target(inner)?,
                        _ => self.check_target(item)?,
                    }
                }
                Ok(())
            }
            ExprKind::Starred(_) => {
                let message = "a starred target must be in a list or tuple; add a comma: '*name,'";
                self.report(Diagnostic::error("syntax", target.span, message));
                Ok(())
            }
            _ => {
                let what = describe(target);
                self.fail(target.span, format!("cannot assign to {what}"))
            }
        }
    }

    pub(super) fn check_augmented_target(&mut self, target: &Expr) -> ParseResult<()> {
        match &target.kind {
            ExprKind::Name(_) | ExprKind::Attribute { .. } | ExprKind::Subscript { .. } => Ok(()),
            _ => {
                let what = describe(target);
                self.fail(
                    target.span,
                    format!("{what} cannot be changed by an augmented assignment"),
                )
            }
        }
    }

    pub(super) fn check_delete_target(&mut self, target: &Expr) -> ParseResult<()> {
        match &target.kind {
            ExprKind::Name(_) | ExprKind::Attribute { .. } | ExprKind::Subscript { .. } => Ok(()),
            ExprKind::Tuple(items) | ExprKind::List(items) => {
                for item in items {
                    self.check_delete_target(item)?;
                }
                Ok(())
            }
            _ => {
                let what = describe(target);
                self.fail(target.span, format!("cannot delete {what}"))
            }
        }
    }

    /// A star is fine inside a tuple, but not alone.
    pub(super) fn check_no_star(&mut self, expr: &Expr) -> ParseResult<()> {
        match expr.kind {
            ExprKind::Starred(_) => {
                let message = "cannot use a starred expression here";
                self.report(Diagnostic::error("syntax", expr.span, message));
                Ok(())
            }
            _ => Ok(()),
        }
    }

    pub(super) fn is_parenthesised(&self, span: Span) -> bool {
        self.file.slice(span).starts_with('(')
    }
}

/// What an expression is, in words.
pub(super) fn describe(expr: &Expr) -> &'static str {
    match &expr.kind {
        ExprKind::Constant(crate::ast::Constant::None) => "None",
        ExprKind::Constant(crate::ast::Constant::Bool(true)) => "True",
        ExprKind::Constant(crate::ast::Constant::Bool(false)) => "False",
        ExprKind::Constant(crate::ast::Constant::Ellipsis) => "ellipsis",
        ExprKind::Constant(_) => "a literal",
        ExprKind::Name(_) => "a name",
        ExprKind::Call { .. } => "a function call",
        ExprKind::Compare { .. } => "a comparison",
        ExprKind::Binary { .. } | ExprKind::Unary { .. } | ExprKind::And(_) | ExprKind::Or(_) => {
            "an expression"
        }
        ExprKind::Lambda(_) => "a lambda",
        ExprKind::IfElse { .. } => "a conditional expression",
        ExprKind::Set(_) => "a set display",
        ExprKind::Dict(_) => "a dict literal",
        ExprKind::Comprehension(_) => "a comprehension",
        ExprKind::FString(_) => "an f-string",
        ExprKind::Named { .. } => "a named expression",
        ExprKind::Yield(_) | ExprKind::YieldFrom(_) => "a yield expression",
        ExprKind::Tuple(_) => "a tuple",
        ExprKind::List(_) => "a list",
        ExprKind::Starred(_) => "a starred expression",
        ExprKind::Attribute { .. } => "an attribute",
        ExprKind::Subscript { .. } => "an item",
        ExprKind::Slice { .. } => "a slice",
    }
}
