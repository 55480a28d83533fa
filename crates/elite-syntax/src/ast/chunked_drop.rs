//! The end of a tree: dropped in portions with pauses, because a tree of millions of nodes takes long.
//!
//! A node gives up its parts first and is emptied then, so that dropping the list around it costs next to nothing.

use super::visit::{
    NodePartMut, argument_parts_mut, dict_item_parts_mut, expression_parts_mut, format_parts_mut,
    statement_parts_mut,
};
use super::{Arg, Constant, DictItem, Expr, ExprKind, FStringPart, Module, Stmt, StmtKind};
use crate::work_budget::WorkBudget;

/// Work for one node.
const WORK_PER_NODE: usize = 96;

impl Module {
    /// Drops the tree, with pauses.
    pub fn release(mut self, budget: &WorkBudget<'_>) {
        block(&mut std::mem::take(&mut self.body), budget);
        budget.drop_each(std::mem::take(&mut self.nodes));
    }
}

fn block(body: &mut [Stmt], budget: &WorkBudget<'_>) {
    for statement in body {
        budget.charge(WORK_PER_NODE);
        statement_parts_mut(statement, &mut |part| drop_part(part, budget));
        statement.kind = StmtKind::Pass;
    }
}

fn drop_part(part: NodePartMut<'_>, budget: &WorkBudget<'_>) {
    match part {
        NodePartMut::Expr(expr)
        | NodePartMut::ClauseTarget(expr)
        | NodePartMut::Annotation(expr) => {
            expression(expr, budget);
        }
        NodePartMut::Name(name) => {
            budget.charge(WORK_PER_NODE);
            drop(std::mem::take(&mut name.name));
        }
        NodePartMut::Block(body) => block(body, budget),
        NodePartMut::Scope(_) | NodePartMut::Span(_) => {}
    }
}

fn expression(expr: &mut Expr, budget: &WorkBudget<'_>) {
    budget.charge(WORK_PER_NODE);
    expression_parts_mut(&mut expr.kind, &mut |part| drop_part(part, budget));
    expr.kind = ExprKind::Constant(Constant::None);
}

pub(crate) fn arguments(mut args: Vec<Arg>, budget: &WorkBudget<'_>) {
    argument_parts_mut(&mut args, &mut |part| drop_part(part, budget));
}

pub(crate) fn expressions(all: impl IntoIterator<Item = Expr>, budget: &WorkBudget<'_>) {
    for mut expr in all {
        expression(&mut expr, budget);
    }
}

pub(crate) fn format_parts(mut parts: Vec<FStringPart>, budget: &WorkBudget<'_>) {
    format_parts_mut(&mut parts, &mut |part| drop_part(part, budget));
    budget.drop_each(parts);
}

pub(crate) fn dict_items(mut items: Vec<DictItem>, budget: &WorkBudget<'_>) {
    dict_item_parts_mut(&mut items, &mut |part| drop_part(part, budget));
}
