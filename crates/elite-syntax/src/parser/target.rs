//! What can be assigned to, deleted, or bound by `for` and `with`.

use messages::{Text, text};

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
                    return self.fail(
                        target.span,
                        text!("only one target may be starred", "只能有一个带星号的目标"),
                    );
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
                let message = text!(
                    "a starred target must be in a list or tuple; add a comma: '*name,'",
                    "带星号的目标必须在列表或元组中；请加逗号：'*name,'"
                );
                self.report(Diagnostic::error("syntax", target.span, message));
                Ok(())
            }
            _ => {
                let what = describe(target);
                self.fail(
                    target.span,
                    text!("cannot assign to {what}", "不能给{what}赋值"),
                )
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
                    text!(
                        "{what} cannot be changed by an augmented assignment",
                        "{what}不能用增量赋值修改"
                    ),
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
                self.fail(target.span, text!("cannot delete {what}", "不能删除{what}"))
            }
        }
    }

    /// A star is fine inside a tuple, but not alone.
    pub(super) fn check_no_star(&mut self, expr: &Expr) -> ParseResult<()> {
        match expr.kind {
            ExprKind::Starred(_) => {
                let message = text!(
                    "cannot use a starred expression here",
                    "这里不能使用带星号的表达式"
                );
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
pub(super) fn describe(expr: &Expr) -> Text {
    match &expr.kind {
        ExprKind::Constant(crate::ast::Constant::None) => Text::verbatim("None"),
        ExprKind::Constant(crate::ast::Constant::Bool(true)) => Text::verbatim("True"),
        ExprKind::Constant(crate::ast::Constant::Bool(false)) => Text::verbatim("False"),
        ExprKind::Constant(crate::ast::Constant::Ellipsis) => Text::verbatim("ellipsis"),
        ExprKind::Constant(_) => text!("a literal", "字面量"),
        ExprKind::Name(_) => text!("a name", "名称"),
        ExprKind::Call { .. } => text!("a function call", "函数调用"),
        ExprKind::Compare { .. } => text!("a comparison", "比较"),
        ExprKind::Binary { .. } | ExprKind::Unary { .. } | ExprKind::And(_) | ExprKind::Or(_) => {
            text!("an expression", "表达式")
        }
        ExprKind::Lambda(_) => text!("a lambda", "lambda 表达式"),
        ExprKind::IfElse { .. } => text!("a conditional expression", "条件表达式"),
        ExprKind::Set(_) => text!("a set display", "集合"),
        ExprKind::Dict(_) => text!("a dict literal", "字典"),
        ExprKind::Comprehension(_) => text!("a comprehension", "推导式"),
        ExprKind::FString(_) => text!("an f-string", "f-string"),
        ExprKind::Named { .. } => text!("a named expression", "命名表达式"),
        ExprKind::Yield(_) | ExprKind::YieldFrom(_) => text!("a yield expression", "yield 表达式"),
        ExprKind::Tuple(_) => text!("a tuple", "元组"),
        ExprKind::List(_) => text!("a list", "列表"),
        ExprKind::Starred(_) => text!("a starred expression", "带星号的表达式"),
        ExprKind::Attribute { .. } => text!("an attribute", "属性"),
        ExprKind::Subscript { .. } => text!("an item", "元素"),
        ExprKind::Slice { .. } => text!("a slice", "切片"),
    }
}
