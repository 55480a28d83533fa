//! The one walk of the tree: what a statement or an expression consists of.
//!
//! Every kind of statement and expression is named here and nowhere else without a wildcard, so that a new kind cannot
//! be forgotten. Whoever relocates a tree, drops it, measures it or looks for something walks it through this file.

use crate::ast::{
    Arg, ComprehensionKind, DictItem, Expr, ExprKind, FStringPart, Ident, Parameters, ScopeId,
    Stmt, StmtKind,
};
use crate::source::Span;

/// A part of a statement or an expression.
pub enum NodePart<'t> {
    /// An expression, target of an assignment included.
    Expr(&'t Expr),
    /// The target of a clause of a comprehension.
    ClauseTarget(&'t Expr),
    /// An annotation of a variable, a parameter or a result.
    Annotation(&'t Expr),
    /// A name that is no expression.
    Name(&'t Ident),
    /// A block of a statement.
    Block(&'t [Stmt]),
    /// The number of the scope that the node opens.
    Scope(&'t ScopeId),
    /// Where the node, or a clause of it, is written.
    Span(&'t Span),
}

/// A part of a statement or an expression, to be changed.
pub(crate) enum NodePartMut<'t> {
    Expr(&'t mut Expr),
    ClauseTarget(&'t mut Expr),
    Annotation(&'t mut Expr),
    Name(&'t mut Ident),
    Block(&'t mut Vec<Stmt>),
    Scope(&'t mut ScopeId),
    Span(&'t mut Span),
}

/// The walk, once for reading and once for changing a tree (`mut`).
macro_rules! walk {
    (
        $visibility:vis, $part:ident, $statement:ident, $expression:ident, $arguments:ident, $items:ident,
        $format:ident,
        $parameters:ident, $($mutable:tt)?
    ) => {
        /// Calls `visit` with the parts of a statement.
        $visibility fn $statement<'t>(
            statement: &'t $($mutable)? Stmt,
            visit: &mut impl FnMut($part<'t>),
        ) {
            visit($part::Span(&$($mutable)? statement.span));
            match &$($mutable)? statement.kind {
                StmtKind::Expr(value) => visit($part::Expr(value)),
                StmtKind::Print { values, .. } | StmtKind::Delete(values) => {
                    values.into_iter().for_each(|value| visit($part::Expr(value)));
                }
                StmtKind::Assign { targets, value } => {
                    targets.into_iter().for_each(|target| visit($part::Expr(target)));
                    visit($part::Expr(value));
                }
                StmtKind::AugAssign { target, value, .. } => {
                    visit($part::Expr(target));
                    visit($part::Expr(value));
                }
                StmtKind::AnnAssign { target, annotation, value } => {
                    visit($part::Expr(target));
                    visit($part::Annotation(annotation));
                    value.into_iter().for_each(|value| visit($part::Expr(value)));
                }
                StmtKind::Return(value) => value.into_iter().for_each(|value| visit($part::Expr(value))),
                StmtKind::Raise { exception, cause } => {
                    exception.into_iter().chain(cause).for_each(|value| visit($part::Expr(value)));
                }
                StmtKind::Assert { test, message } => {
                    visit($part::Expr(test));
                    message.into_iter().for_each(|message| visit($part::Expr(message)));
                }
                StmtKind::Global(names) | StmtKind::Nonlocal(names) => {
                    names.into_iter().for_each(|name| visit($part::Name(name)));
                }
                StmtKind::Import(names) => {
                    for alias in names {
                        visit($part::Name(&$($mutable)? alias.name));
                        (&$($mutable)? alias.alias).into_iter().for_each(|name| visit($part::Name(name)));
                    }
                }
                StmtKind::ImportFrom { module, names, .. } => {
                    visit($part::Name(module));
                    for alias in names {
                        visit($part::Name(&$($mutable)? alias.name));
                        (&$($mutable)? alias.alias).into_iter().for_each(|name| visit($part::Name(name)));
                    }
                }
                StmtKind::If { branches, orelse } => {
                    for (test, body) in branches {
                        visit($part::Expr(test));
                        visit($part::Block(body));
                    }
                    visit($part::Block(orelse));
                }
                StmtKind::While { test, body, orelse } => {
                    visit($part::Expr(test));
                    visit($part::Block(body));
                    visit($part::Block(orelse));
                }
                StmtKind::For { target, iterable, body, orelse } => {
                    visit($part::Expr(target));
                    visit($part::Expr(iterable));
                    visit($part::Block(body));
                    visit($part::Block(orelse));
                }
                StmtKind::With { items, body } => {
                    for item in items {
                        visit($part::Expr(&$($mutable)? item.context));
                        (&$($mutable)? item.target).into_iter().for_each(|target| visit($part::Expr(target)));
                    }
                    visit($part::Block(body));
                }
                StmtKind::Try { body, handlers, orelse, finally } => {
                    visit($part::Block(body));
                    for handler in handlers {
                        visit($part::Span(&$($mutable)? handler.span));
                        (&$($mutable)? handler.exception)
                            .into_iter()
                            .for_each(|exception| visit($part::Expr(exception)));
                        (&$($mutable)? handler.name).into_iter().for_each(|name| visit($part::Name(name)));
                        visit($part::Block(&$($mutable)? handler.body));
                    }
                    visit($part::Block(orelse));
                    visit($part::Block(finally));
                }
                StmtKind::Function(def) => {
                    let def = &$($mutable)? **def;
                    visit($part::Name(&$($mutable)? def.name));
                    (&$($mutable)? def.decorators).into_iter().for_each(|value| visit($part::Expr(value)));
                    $parameters(&$($mutable)? def.parameters, visit);
                    (&$($mutable)? def.returns).into_iter().for_each(|value| visit($part::Annotation(value)));
                    visit($part::Block(&$($mutable)? def.body));
                    visit($part::Scope(&$($mutable)? def.scope));
                }
                StmtKind::Class(def) => {
                    let def = &$($mutable)? **def;
                    visit($part::Name(&$($mutable)? def.name));
                    (&$($mutable)? def.decorators).into_iter().for_each(|value| visit($part::Expr(value)));
                    $arguments(&$($mutable)? def.args, visit);
                    visit($part::Block(&$($mutable)? def.body));
                    visit($part::Scope(&$($mutable)? def.scope));
                }
                StmtKind::Pass | StmtKind::Break | StmtKind::Continue => {}
            }
        }

        /// Calls `visit` with the parts of an expression.
        $visibility fn $expression<'t>(
            kind: &'t $($mutable)? ExprKind,
            visit: &mut impl FnMut($part<'t>),
        ) {
            match kind {
                ExprKind::Constant(_) | ExprKind::Name(_) => {}
                ExprKind::And(items)
                | ExprKind::Or(items)
                | ExprKind::List(items)
                | ExprKind::Tuple(items)
                | ExprKind::Set(items) => items.into_iter().for_each(|item| visit($part::Expr(item))),
                ExprKind::Binary { left, right, .. } => {
                    visit($part::Expr(left));
                    visit($part::Expr(right));
                }
                ExprKind::Unary { operand: inner, .. }
                | ExprKind::Starred(inner)
                | ExprKind::YieldFrom(inner) => visit($part::Expr(inner)),
                ExprKind::Attribute { value, name } => {
                    visit($part::Expr(value));
                    visit($part::Name(name));
                }
                ExprKind::Named { target, value } => {
                    visit($part::Name(target));
                    visit($part::Expr(value));
                }
                ExprKind::Compare { left, rest } => {
                    visit($part::Expr(left));
                    rest.into_iter().for_each(|(_, right)| visit($part::Expr(right)));
                }
                ExprKind::Call { function, args } => {
                    visit($part::Expr(function));
                    $arguments(args, visit);
                }
                ExprKind::Subscript { value, index } => {
                    visit($part::Expr(value));
                    visit($part::Expr(index));
                }
                ExprKind::Slice { lower, upper, step } => {
                    let bounds = [lower, upper, step].into_iter().flatten();
                    bounds.for_each(|bound| visit($part::Expr(bound)));
                }
                ExprKind::Dict(items) => $items(items, visit),
                ExprKind::Comprehension(comprehension) => {
                    let comprehension = &$($mutable)? **comprehension;
                    for clause in &$($mutable)? comprehension.clauses {
                        visit($part::ClauseTarget(&$($mutable)? clause.target));
                        visit($part::Expr(&$($mutable)? clause.iterable));
                        (&$($mutable)? clause.conditions)
                            .into_iter()
                            .for_each(|condition| visit($part::Expr(condition)));
                    }
                    match &$($mutable)? comprehension.kind {
                        ComprehensionKind::List(item)
                        | ComprehensionKind::Set(item)
                        | ComprehensionKind::Generator(item) => visit($part::Expr(item)),
                        ComprehensionKind::Dict(key, value) => {
                            visit($part::Expr(key));
                            visit($part::Expr(value));
                        }
                    }
                    visit($part::Scope(&$($mutable)? comprehension.scope));
                }
                ExprKind::Lambda(lambda) => {
                    let lambda = &$($mutable)? **lambda;
                    $parameters(&$($mutable)? lambda.parameters, visit);
                    visit($part::Expr(&$($mutable)? lambda.body));
                    visit($part::Scope(&$($mutable)? lambda.scope));
                }
                ExprKind::IfElse { test, body, orelse } => {
                    visit($part::Expr(test));
                    visit($part::Expr(body));
                    visit($part::Expr(orelse));
                }
                ExprKind::Yield(value) => value.into_iter().for_each(|value| visit($part::Expr(value))),
                ExprKind::FString(format) => $format(format, visit),
            }
        }

        /// Calls `visit` with the parts of arguments.
        $visibility fn $arguments<'t>(
            args: &'t $($mutable)? [Arg],
            visit: &mut impl FnMut($part<'t>),
        ) {
            for arg in args {
                match arg {
                    Arg::Positional(value) | Arg::Star(value) | Arg::DoubleStar(value) => {
                        visit($part::Expr(value));
                    }
                    Arg::Keyword(name, value) => {
                        visit($part::Name(name));
                        visit($part::Expr(value));
                    }
                }
            }
        }

        /// Calls `visit` with the parts of the items of a dictionary display.
        $visibility fn $items<'t>(
            items: &'t $($mutable)? [DictItem],
            visit: &mut impl FnMut($part<'t>),
        ) {
            for item in items {
                match item {
                    DictItem::Pair(key, value) => {
                        visit($part::Expr(key));
                        visit($part::Expr(value));
                    }
                    DictItem::Unpack(mapping) => visit($part::Expr(mapping)),
                }
            }
        }

        /// Calls `visit` with the parts of an f-string, those of nested formats included.
        $visibility fn $format<'t>(
            format: &'t $($mutable)? [FStringPart],
            visit: &mut impl FnMut($part<'t>),
        ) {
            for part in format {
                if let FStringPart::Value { value, format, .. } = part {
                    visit($part::Expr(value));
                    if let Some(format) = format {
                        $format(format, visit);
                    }
                }
            }
        }

        fn $parameters<'t>(
            parameters: &'t $($mutable)? Parameters,
            visit: &mut impl FnMut($part<'t>),
        ) {
            let by_position = (&$($mutable)? parameters.positional_only)
                .into_iter()
                .chain(&$($mutable)? parameters.positional)
                .chain(&$($mutable)? parameters.keyword_only);
            for parameter in by_position
                .chain(&$($mutable)? parameters.star)
                .chain(&$($mutable)? parameters.double_star)
            {
                visit($part::Name(&$($mutable)? parameter.name));
                (&$($mutable)? parameter.annotation)
                    .into_iter()
                    .for_each(|value| visit($part::Annotation(value)));
                (&$($mutable)? parameter.default)
                    .into_iter()
                    .for_each(|value| visit($part::Expr(value)));
            }
        }
    };
}

walk!(
    pub,
    NodePart,
    statement_parts,
    expression_parts,
    argument_parts,
    dict_item_parts,
    format_parts,
    parameter_parts,
);
walk!(
    pub(crate), NodePartMut, statement_parts_mut, expression_parts_mut, argument_parts_mut, dict_item_parts_mut,
    format_parts_mut, parameter_parts_mut, mut
);

/// The blocks within a statement; those of functions and classes too.
pub fn blocks(statement: &Stmt) -> Vec<&[Stmt]> {
    let mut blocks = Vec::new();
    statement_parts(statement, &mut |part| {
        if let NodePart::Block(block) = part {
            blocks.push(block);
        }
    });
    blocks
}

/// Calls `visit` with the expressions written in a statement itself, not in its blocks; annotations are left out.
pub fn own_expressions<'t>(statement: &'t Stmt, visit: &mut dyn FnMut(&'t Expr)) {
    statement_parts(statement, &mut |part| {
        if let NodePart::Expr(expr) = part {
            visit(expr);
        }
    });
}

/// Calls `visit` with the expressions that an expression consists of; targets of comprehensions are left out.
pub fn parts<'t>(expr: &'t Expr, visit: &mut dyn FnMut(&'t Expr)) {
    expression_parts(&expr.kind, &mut |part| {
        if let NodePart::Expr(expr) = part {
            visit(expr);
        }
    });
}
