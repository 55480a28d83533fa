//! Walking a tree: the blocks of a statement, the expressions of a statement, the parts of an expression.

use crate::ast::{
    Arg, ComprehensionKind, DictItem, Expr, ExprKind, FStringPart, Parameters, Stmt, StmtKind,
};

/// The blocks within a statement; those of functions and classes too.
pub fn blocks(statement: &Stmt) -> Vec<&[Stmt]> {
    match &statement.kind {
        StmtKind::If { branches, orelse } => {
            let bodies = branches.iter().map(|(_, body)| &body[..]);
            bodies.chain([&orelse[..]]).collect()
        }
        StmtKind::While { body, orelse, .. } | StmtKind::For { body, orelse, .. } => {
            vec![body, orelse]
        }
        StmtKind::With { body, .. } => vec![body],
        StmtKind::Try {
            body,
            handlers,
            orelse,
            finally,
        } => {
            let caught = handlers.iter().map(|handler| &handler.body[..]);
            let first: [&[Stmt]; 1] = [body];
            first
                .into_iter()
                .chain(caught)
                .chain([&orelse[..], &finally[..]])
                .collect()
        }
        StmtKind::Function(def) => vec![&def.body],
        StmtKind::Class(def) => vec![&def.body],
        _ => Vec::new(),
    }
}

/// Calls `visit` with the expressions written in a statement itself, not in its blocks.
pub fn own_expressions<'t>(statement: &'t Stmt, visit: &mut dyn FnMut(&'t Expr)) {
    match &statement.kind {
        StmtKind::Expr(value) => visit(value),
        StmtKind::Print { values, .. } | StmtKind::Delete(values) => values.iter().for_each(visit),
        StmtKind::Assign { targets, value } => {
            targets.iter().for_each(&mut *visit);
            visit(value);
        }
        StmtKind::AugAssign { target, value, .. } => {
            visit(target);
            visit(value);
        }
        StmtKind::AnnAssign { target, value, .. } => {
            visit(target);
            value.iter().for_each(visit);
        }
        StmtKind::Return(value) => value.iter().for_each(visit),
        StmtKind::Raise { exception, cause } => exception.iter().chain(cause).for_each(visit),
        StmtKind::Assert { test, message } => {
            visit(test);
            message.iter().for_each(visit);
        }
        StmtKind::If { branches, .. } => branches.iter().for_each(|(test, _)| visit(test)),
        StmtKind::While { test, .. } => visit(test),
        StmtKind::For {
            target, iterable, ..
        } => {
            visit(target);
            visit(iterable);
        }
        StmtKind::With { items, .. } => items.iter().for_each(|item| {
            visit(&item.context);
            item.target.iter().for_each(&mut *visit);
        }),
        StmtKind::Try { handlers, .. } => handlers
            .iter()
            .filter_map(|handler| handler.exception.as_ref())
            .for_each(visit),
        StmtKind::Function(def) => {
            def.decorators.iter().for_each(&mut *visit);
            defaults(&def.parameters, visit);
        }
        StmtKind::Class(def) => {
            def.decorators.iter().for_each(&mut *visit);
            arguments(&def.args, visit);
        }
        StmtKind::Pass
        | StmtKind::Break
        | StmtKind::Continue
        | StmtKind::Global(_)
        | StmtKind::Nonlocal(_)
        | StmtKind::Import(_)
        | StmtKind::ImportFrom { .. } => {}
    }
}

/// Calls `visit` with the parts of an expression.
pub fn parts<'t>(expr: &'t Expr, visit: &mut dyn FnMut(&'t Expr)) {
    match &expr.kind {
        ExprKind::Constant(_) | ExprKind::Name(_) => {}
        ExprKind::And(items)
        | ExprKind::Or(items)
        | ExprKind::List(items)
        | ExprKind::Tuple(items)
        | ExprKind::Set(items) => items.iter().for_each(visit),
        ExprKind::Binary { left, right, .. } => {
            visit(left);
            visit(right);
        }
        ExprKind::Unary { operand: inner, .. }
        | ExprKind::Attribute { value: inner, .. }
        | ExprKind::Named { value: inner, .. }
        | ExprKind::Starred(inner)
        | ExprKind::YieldFrom(inner) => visit(inner),
        ExprKind::Compare { left, rest } => {
            visit(left);
            rest.iter().for_each(|(_, right)| visit(right));
        }
        ExprKind::Call { function, args } => {
            visit(function);
            arguments(args, visit);
        }
        ExprKind::Subscript { value, index } => {
            visit(value);
            visit(index);
        }
        ExprKind::Slice { lower, upper, step } => {
            let bounds = [lower, upper, step].into_iter().flatten();
            bounds.for_each(|bound| visit(bound));
        }
        ExprKind::Dict(items) => items.iter().for_each(|item| match item {
            DictItem::Pair(key, value) => {
                visit(key);
                visit(value);
            }
            DictItem::Unpack(mapping) => visit(mapping),
        }),
        ExprKind::Comprehension(comprehension) => {
            for clause in &comprehension.clauses {
                visit(&clause.iterable);
                clause.conditions.iter().for_each(&mut *visit);
            }
            match &comprehension.kind {
                ComprehensionKind::List(item)
                | ComprehensionKind::Set(item)
                | ComprehensionKind::Generator(item) => visit(item),
                ComprehensionKind::Dict(key, value) => {
                    visit(key);
                    visit(value);
                }
            }
        }
        ExprKind::Lambda(lambda) => {
            defaults(&lambda.parameters, visit);
            visit(&lambda.body);
        }
        ExprKind::IfElse { test, body, orelse } => {
            visit(test);
            visit(body);
            visit(orelse);
        }
        ExprKind::Yield(value) => value.iter().for_each(|value| visit(value)),
        ExprKind::FString(format) => format_parts(format, visit),
    }
}

fn format_parts<'t>(format: &'t [FStringPart], visit: &mut dyn FnMut(&'t Expr)) {
    for part in format {
        if let FStringPart::Value { value, format, .. } = part {
            visit(value);
            format.iter().for_each(|format| format_parts(format, visit));
        }
    }
}

fn arguments<'t>(args: &'t [Arg], visit: &mut dyn FnMut(&'t Expr)) {
    for arg in args {
        match arg {
            Arg::Positional(value)
            | Arg::Star(value)
            | Arg::Keyword(_, value)
            | Arg::DoubleStar(value) => visit(value),
        }
    }
}

fn defaults<'t>(parameters: &'t Parameters, visit: &mut dyn FnMut(&'t Expr)) {
    let values = parameters
        .iter()
        .filter_map(|parameter| parameter.default.as_ref());
    values.for_each(visit);
}
