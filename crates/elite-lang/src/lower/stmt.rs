//! Statements.

use std::rc::Rc;

use elite_syntax::Span;
use elite_syntax::ast::{self, ExprKind, Stmt, StmtKind};
use elite_syntax::resolve::Storage;

use super::Lower;
use super::expr::keeps_locals;
use crate::eval::code::Block;
use crate::eval::expr::attribute::InlineCache;
use crate::eval::stmt::assert::{Assert, AssertComparison};
use crate::eval::stmt::assign::{
    Assign, AssignItems, AssignTargets, AugAttribute, AugItem, AugName, assign_attribute,
    assign_item, assign_last_first, assign_local, assign_pair, augmented_local,
};
use crate::eval::stmt::class_body::AnnotatedAssign;
use crate::eval::stmt::control::{BareReturn, Break, Continue, If, return_value};
use crate::eval::stmt::import::{Import, ImportFrom, ImportStar};
use crate::eval::stmt::loops::{For, LoopBody, While};
use crate::eval::stmt::simple::{Delete, ExprStatement, Print, Raise};
use crate::eval::stmt::with::With;
use crate::eval::{BoxExpr, DynStmt};
use crate::value::Value;

type BoxStmt = Box<dyn DynStmt>;

impl Lower<'_> {
    /// The node of a statement; None for those that do nothing.
    pub(super) fn statement(&mut self, statement: &Stmt) -> Option<BoxStmt> {
        let span = statement.span;
        Some(match &statement.kind {
            StmtKind::Expr(expr) if matches!(expr.kind, ExprKind::Constant(_)) => return None,
            StmtKind::Expr(expr) => Box::new(ExprStatement(self.expr(expr))),
            StmtKind::Print {
                values,
                trailing_comma,
            } => {
                let end = if *trailing_comma { " " } else { "\n" };
                Box::new(Print {
                    values: self.exprs(values),
                    end,
                    span,
                })
            }
            StmtKind::Assign { targets, value } => self.assign(targets, value),
            StmtKind::AugAssign { target, op, value } => {
                self.augmented_assign(target, *op, value, span)
            }
            StmtKind::AnnAssign {
                target,
                annotation,
                value,
            } => {
                let assigned = value
                    .as_ref()
                    .map(|value| self.assign(std::slice::from_ref(target), value));
                return self.annotate(target, annotation, assigned);
            }
            StmtKind::Delete(targets) => Box::new(Delete(self.targets(targets))),
            StmtKind::Pass | StmtKind::Global(_) | StmtKind::Nonlocal(_) => return None,
            StmtKind::Break => Box::new(Break),
            StmtKind::Continue => Box::new(Continue),
            StmtKind::Return(None) => Box::new(BareReturn),
            StmtKind::Return(Some(value)) => return_value(self.operand(value)),
            StmtKind::Raise { exception, cause } => {
                let exception = exception.as_ref().map(|expr| self.expr(expr));
                let cause = cause.as_ref().map(|expr| self.expr(expr));
                Box::new(Raise {
                    exception,
                    cause,
                    span,
                })
            }
            StmtKind::Assert { test, message } => {
                let message = message.as_ref().map(|message| self.expr(message));
                let span = test.span;
                match &test.kind {
                    ExprKind::Compare { left, rest } if rest.len() == 1 => {
                        let (op, right) = &rest[0];
                        Box::new(AssertComparison {
                            left: self.expr(left),
                            op: *op,
                            right: self.expr(right),
                            message,
                            span,
                        })
                    }
                    _ => Box::new(Assert {
                        test: self.expr(test),
                        message,
                        span,
                    }),
                }
            }
            StmtKind::Import(names) => self.import(names, span),
            StmtKind::ImportFrom {
                module,
                names,
                star,
            } => self.import_from(module, names, *star, span),
            StmtKind::Function(def) => Box::new(self.define_function(def, span)),
            StmtKind::Class(def) => Box::new(self.define_class(def, span)),
            _ => self.compound(statement),
        })
    }

    fn compound(&mut self, statement: &Stmt) -> BoxStmt {
        match &statement.kind {
            StmtKind::If { branches, orelse } => {
                let branch = |(index, (test, body)): (usize, &(ast::Expr, Vec<Stmt>))| {
                    (
                        self.line(test.span),
                        self.branch_test(test, index == 0),
                        self.block(body),
                    )
                };
                let branches = branches.iter().enumerate().map(branch).collect();
                Box::new(If {
                    branches,
                    orelse: self.block(orelse),
                })
            }
            StmtKind::While { test, body, orelse } => Box::new(While {
                test: self.loop_test(test),
                turns: LoopBody {
                    line: self.line(test.span),
                    body: self.block(body),
                    orelse: self.block(orelse),
                },
            }),
            StmtKind::For {
                target,
                iterable,
                body,
                orelse,
            } => Box::new(For {
                iterable: self.expr(iterable),
                span: iterable.span,
                target: self.watched_target(target),
                turns: LoopBody {
                    line: self.line(statement.span),
                    body: self.block(body),
                    orelse: self.block(orelse),
                },
            }),
            StmtKind::With { items, body } => self.with(items, body, statement.span),
            StmtKind::Try {
                body,
                handlers,
                orelse,
                finally,
            } => self.try_statement(self.line(statement.span), body, handlers, orelse, finally),
            // All others are handled by `statement`.
            _ => Box::new(crate::eval::stmt::control::Pass),
        }
    }

    /// Keeps the annotation of a name of a class; those of other names have no effect.
    fn annotate(
        &mut self,
        target: &ast::Expr,
        annotation: &ast::Expr,
        assign: Option<BoxStmt>,
    ) -> Option<BoxStmt> {
        let ExprKind::Name(name) = &target.kind else {
            return assign;
        };
        let Storage::Class(annotations) = self.place("__annotations__") else {
            return assign;
        };
        Some(Box::new(AnnotatedAssign {
            assign,
            annotations,
            name: self.core.symbols.to_value(self.symbol(name)),
            annotation: self.expr(annotation),
            text: Value::str(self.file.slice(annotation.span)),
        }))
    }

    /// An assignment of one value to each target, none of which is starred.
    fn assign_each(&mut self, names: &[ast::Expr], values: &[ast::Expr]) -> BoxStmt {
        // In CPython the values of two or three local names lie on the stack, with the last one on top; constants are a
        // tuple.
        let last_first = !values.iter().all(is_constant) && self.are_distinct_locals(names);
        if let ([first, second], [x, y]) = (names, values) {
            let values = (self.operand(x), self.operand(y));
            if last_first && let Some(slots) = self.local_slots(names) {
                return assign_last_first(slots, values);
            }
            let targets = [self.destination(first), self.destination(second)];
            return assign_pair(targets, values);
        }
        Box::new(AssignTargets {
            values: values.iter().map(|value| self.operand(value)).collect(),
            targets: names.iter().map(|name| self.destination(name)).collect(),
            last_first,
        })
    }

    /// Whether these are two or three different local names in one line.
    fn are_distinct_locals(&mut self, names: &[ast::Expr]) -> bool {
        let mut lines = names.iter().map(|name| self.line(name.span));
        let first = lines.next();
        if !lines.all(|line| Some(line) == first) {
            return false;
        }
        match (self.local_slots(names), self.local_slots(names)) {
            (Some([a, b]), None) => a != b,
            (None, Some([a, b, c])) => a != b && a != c && b != c,
            _ => false,
        }
    }

    fn assign(&mut self, targets: &[ast::Expr], value: &ast::Expr) -> BoxStmt {
        if let [target] = targets {
            if let ExprKind::Tuple(names) | ExprKind::List(names) = &target.kind
                && let ExprKind::Tuple(values) = &value.kind
                && names.len() == values.len()
                && (2..=8).contains(&names.len())
                && names
                    .iter()
                    .chain(values)
                    .all(|expr| !matches!(expr.kind, ExprKind::Starred(_)))
            {
                return self.assign_each(names, values);
            }
            if let ExprKind::Tuple(names) | ExprKind::List(names) = &target.kind {
                macro_rules! unpacked {
                    ($($count:literal),*) => {
                        $(if let Some(slots) = self.local_slots::<$count>(names) {
                            let value = self.operand(value);
                            let targets = self.unpack(names, target.span);
                            return Box::new(AssignItems { slots, value, targets });
                        })*
                    };
                }
                unpacked!(2, 3, 4);
            }
            if let ExprKind::Attribute { .. } = &target.kind {
                let value = self.operand(value);
                return assign_attribute(self.attribute_target(target), value);
            }
            if let ExprKind::Subscript { .. } = &target.kind {
                let value = self.operand(value);
                return assign_item(self.item_target(target), value);
            }
            if let ExprKind::Name(name) = &target.kind
                && let Storage::Local(slot) = self.place(name)
            {
                return assign_local(slot, self.operand(value));
            }
        }
        let value = self.operand(value);
        Box::new(Assign {
            targets: self.targets(targets),
            value,
        })
    }

    fn augmented_assign(
        &mut self,
        target: &ast::Expr,
        op: ast::BinaryOp,
        value: &ast::Expr,
        span: Span,
    ) -> BoxStmt {
        match &target.kind {
            ExprKind::Name(name) => {
                if let Storage::Local(slot) = self.place(name) {
                    let value = self.operand(value);
                    return augmented_local(op, slot, value, target.span, span);
                }
                let (read, value) = (self.operand(target), self.operand(value));
                Box::new(AugName {
                    read,
                    target: self.target(target),
                    op,
                    value,
                    span,
                })
            }
            ExprKind::Subscript {
                value: container,
                index,
            } => {
                let keeps = keeps_locals(index) && keeps_locals(value);
                let (container, index) = (self.operand(container), self.operand(index));
                Box::new(AugItem {
                    container,
                    index,
                    keeps,
                    op,
                    value: self.operand(value),
                    item_span: target.span,
                    span,
                })
            }
            _ => {
                let target = self.attribute_target(target);
                Box::new(AugAttribute {
                    target,
                    cache: InlineCache::default(),
                    op,
                    preserves_locals: keeps_locals(value),
                    value: self.operand(value),
                    span,
                })
            }
        }
    }

    /// Several items of a `with` are nested statements.
    fn with(&mut self, items: &[ast::WithItem], body: &[Stmt], span: Span) -> BoxStmt {
        self.deeper(|lower| match items {
            [] => Box::new(crate::eval::stmt::control::Pass) as BoxStmt,
            [item, rest @ ..] => {
                let context: BoxExpr = lower.expr(&item.context);
                let target = item.target.as_ref().map(|target| lower.target(target));
                let body = if rest.is_empty() {
                    lower.block(body)
                } else {
                    let line = lower.line(span);
                    Block::new(vec![(line, lower.with(rest, body, span))], Vec::new())
                };
                Box::new(With {
                    context,
                    target,
                    body,
                    span: item.context.span,
                })
            }
        })
    }

    fn import(&mut self, names: &[ast::ImportAlias], span: Span) -> BoxStmt {
        let node = |alias: &ast::ImportAlias| {
            let name = &alias.name.name;
            let first = name.split('.').next().unwrap_or("");
            let bound = alias.alias.as_ref().map_or(first, |alias| &alias.name);
            let target = self.name_target(bound, alias.name.span);
            let aliased = alias.alias.is_some();
            Box::new(Import {
                module: name.clone(),
                aliased,
                target,
                span: alias.name.span,
            }) as BoxStmt
        };
        let mut nodes: Vec<BoxStmt> = names.iter().map(node).collect();
        if nodes.len() == 1
            && let Some(node) = nodes.pop()
        {
            return node;
        }
        let line = self.line(span);
        let lines = nodes.into_iter().map(|node| (line, node)).collect();
        Box::new(Block::new(lines, Vec::new()))
    }

    fn import_from(
        &mut self,
        module: &ast::Ident,
        names: &[ast::ImportAlias],
        star: bool,
        span: Span,
    ) -> BoxStmt {
        let module_name = module.name.clone();
        if star {
            let (namespace, module) = (self.namespace.clone(), module_name);
            return Box::new(ImportStar {
                module,
                global: Rc::new(move |name| namespace.cell(name)),
                span,
            });
        }
        let name = |alias: &ast::ImportAlias| {
            let bound = alias.alias.as_ref().unwrap_or(&alias.name);
            (
                self.symbol(&alias.name.name),
                self.name_target(&bound.name, bound.span),
                alias.name.span,
            )
        };
        Box::new(ImportFrom {
            module: module_name,
            names: names.iter().map(name).collect(),
            span: module.span,
        })
    }
}

/// Whether this is a constant, or a tuple of constants.
fn is_constant(expr: &ast::Expr) -> bool {
    match &expr.kind {
        ExprKind::Constant(_) => true,
        ExprKind::Tuple(items) => items.iter().all(is_constant),
        ExprKind::Unary { operand, .. } => matches!(operand.kind, ExprKind::Constant(_)),
        _ => false,
    }
}
