//! The end of a tree: taken apart with pauses, because dropping one of millions of parts takes long.
//!
//! Owns nothing. Every kind of statement and expression is named, without a wildcard, so that a new one cannot be
//! forgotten.

use super::{
    Arg, Comprehension, ComprehensionKind, DictItem, Expr, ExprKind, FStringPart, Ident,
    ImportAlias, Lambda, Module, Parameter, Parameters, Stmt, StmtKind,
};
use crate::work_budget::WorkBudget;

/// Work for one part.
const WORK_PER_NODE: usize = 96;

impl Module {
    /// Drops the tree, with pauses.
    pub fn release(mut self, budget: &WorkBudget<'_>) {
        statements(std::mem::take(&mut self.body), budget);
        budget.drop_each(std::mem::take(&mut self.nodes));
    }
}

fn statements(body: Vec<Stmt>, budget: &WorkBudget<'_>) {
    for statement in body {
        budget.charge(WORK_PER_NODE);
        match statement.kind {
            StmtKind::Expr(value) => expression(value, budget),
            StmtKind::Print {
                values,
                trailing_comma: _,
            } => expressions(values, budget),
            StmtKind::Assign { targets, value } => {
                expressions(targets, budget);
                expression(value, budget);
            }
            StmtKind::AugAssign {
                target,
                op: _,
                value,
            } => expressions([target, value], budget),
            StmtKind::AnnAssign {
                target,
                annotation,
                value,
            } => expressions([target, annotation].into_iter().chain(value), budget),
            StmtKind::Delete(targets) => expressions(targets, budget),
            StmtKind::Pass | StmtKind::Break | StmtKind::Continue => {}
            StmtKind::Return(value) => expressions(value, budget),
            StmtKind::Raise { exception, cause } => {
                expressions(exception.into_iter().chain(cause), budget);
            }
            StmtKind::Global(names) | StmtKind::Nonlocal(names) => idents(names, budget),
            StmtKind::Assert { test, message } => {
                expressions([test].into_iter().chain(message), budget);
            }
            StmtKind::Import(names) => imports(names, budget),
            StmtKind::ImportFrom {
                module,
                names,
                star: _,
            } => {
                drop(module);
                imports(names, budget);
            }
            StmtKind::If { branches, orelse } => {
                for (test, body) in branches {
                    expression(test, budget);
                    statements(body, budget);
                }
                statements(orelse, budget);
            }
            StmtKind::While { test, body, orelse } => {
                expression(test, budget);
                statements(body, budget);
                statements(orelse, budget);
            }
            StmtKind::For {
                target,
                iterable,
                body,
                orelse,
            } => {
                expressions([target, iterable], budget);
                statements(body, budget);
                statements(orelse, budget);
            }
            StmtKind::With { items, body } => {
                for item in items {
                    expressions([item.context].into_iter().chain(item.target), budget);
                }
                statements(body, budget);
            }
            StmtKind::Try {
                body,
                handlers,
                orelse,
                finally,
            } => {
                for handler in handlers {
                    expressions(handler.exception, budget);
                    statements(handler.body, budget);
                }
                for body in [body, orelse, finally] {
                    statements(body, budget);
                }
            }
            StmtKind::Function(def) => {
                parameters(def.parameters, budget);
                expressions(def.decorators.into_iter().chain(def.returns), budget);
                statements(def.body, budget);
            }
            StmtKind::Class(def) => {
                arguments(def.args, budget);
                expressions(def.decorators, budget);
                statements(def.body, budget);
            }
        }
    }
}

fn idents(names: Vec<Ident>, budget: &WorkBudget<'_>) {
    budget.drop_each(names);
}

fn imports(names: Vec<ImportAlias>, budget: &WorkBudget<'_>) {
    budget.drop_each(names);
}

fn parameters(all: Parameters, budget: &WorkBudget<'_>) {
    let by_name = all.positional_only.into_iter().chain(all.positional);
    let by_name = by_name.chain(all.keyword_only);
    for parameter in by_name.chain(all.star).chain(all.double_star) {
        budget.charge(WORK_PER_NODE);
        let Parameter {
            name: _,
            annotation,
            default,
        } = parameter;
        expressions(annotation.into_iter().chain(default), budget);
    }
}

pub(crate) fn arguments(args: Vec<Arg>, budget: &WorkBudget<'_>) {
    for arg in args {
        match arg {
            Arg::Positional(value)
            | Arg::Star(value)
            | Arg::Keyword(_, value)
            | Arg::DoubleStar(value) => expression(value, budget),
        }
    }
}

pub(crate) fn expressions(all: impl IntoIterator<Item = Expr>, budget: &WorkBudget<'_>) {
    all.into_iter().for_each(|expr| expression(expr, budget));
}

pub(crate) fn format_parts(parts: Vec<FStringPart>, budget: &WorkBudget<'_>) {
    for part in parts {
        budget.charge(WORK_PER_NODE);
        if let FStringPart::Value {
            value,
            conversion: _,
            format,
        } = part
        {
            expression(value, budget);
            format
                .into_iter()
                .for_each(|format| format_parts(format, budget));
        }
    }
}

fn comprehension(comprehension: Comprehension, budget: &WorkBudget<'_>) {
    match comprehension.kind {
        ComprehensionKind::List(element)
        | ComprehensionKind::Set(element)
        | ComprehensionKind::Generator(element) => expression(element, budget),
        ComprehensionKind::Dict(key, value) => expressions([key, value], budget),
    }
    for clause in comprehension.clauses {
        expressions([clause.target, clause.iterable], budget);
        expressions(clause.conditions, budget);
    }
}

fn expression(expr: Expr, budget: &WorkBudget<'_>) {
    budget.charge(WORK_PER_NODE);
    match expr.kind {
        ExprKind::Constant(_) | ExprKind::Name(_) => {}
        ExprKind::And(items)
        | ExprKind::Or(items)
        | ExprKind::List(items)
        | ExprKind::Tuple(items)
        | ExprKind::Set(items) => expressions(items, budget),
        ExprKind::Dict(items) => dict_items(items, budget),
        ExprKind::Call { function, args } => {
            expression(*function, budget);
            arguments(args, budget);
        }
        ExprKind::Binary { op: _, left, right } => {
            expression(*left, budget);
            expression(*right, budget);
        }
        ExprKind::Unary { op: _, operand } => expression(*operand, budget),
        ExprKind::Compare { left, rest } => {
            expression(*left, budget);
            expressions(rest.into_iter().map(|(_, right)| right), budget);
        }
        ExprKind::Attribute { value, name: _ }
        | ExprKind::Starred(value)
        | ExprKind::YieldFrom(value)
        | ExprKind::Named { target: _, value } => expression(*value, budget),
        ExprKind::Subscript { value, index } => {
            expression(*value, budget);
            expression(*index, budget);
        }
        ExprKind::Slice { lower, upper, step } => {
            for bound in [lower, upper, step].into_iter().flatten() {
                expression(*bound, budget);
            }
        }
        ExprKind::Comprehension(inner) => comprehension(*inner, budget),
        ExprKind::Lambda(lambda) => {
            let Lambda {
                parameters: all,
                body,
                scope: _,
            } = *lambda;
            parameters(all, budget);
            expression(body, budget);
        }
        ExprKind::IfElse { test, body, orelse } => {
            for part in [test, body, orelse] {
                expression(*part, budget);
            }
        }
        ExprKind::Yield(value) => {
            if let Some(value) = value {
                expression(*value, budget);
            }
        }
        ExprKind::FString(parts) => format_parts(parts, budget),
    }
}

pub(crate) fn dict_items(items: Vec<DictItem>, budget: &WorkBudget<'_>) {
    for item in items {
        match item {
            DictItem::Pair(key, value) => expressions([key, value], budget),
            DictItem::Unpack(mapping) => expression(mapping, budget),
        }
    }
}
