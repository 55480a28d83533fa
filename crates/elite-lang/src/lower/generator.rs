//! Bodies of generators: as steps where that is possible, otherwise as trees that run on a stack of their own.

use elite_syntax::ast::{self, DirectiveAnchor, ExprKind, Stmt, StmtKind, visit};
use elite_syntax::{Span, WorkBudget};

use super::Lower;
use crate::eval::code::Body;
use crate::eval::expr::operand::Operand;
use crate::eval::steps::{GeneratorStep, StepIndex};
use crate::eval::stmt::target::Target;
use crate::eval::{BoxExpr, DynStmt};
use crate::value::Value;

/// A place that is filled in when it is known.
const LATER: StepIndex = StepIndex::MAX;

/// What `break` and `continue` in the innermost loop lead to: the steps that do not know yet.
#[derive(Default)]
struct LoopPatches {
    breaks: Vec<usize>,
    continues: Vec<usize>,
}

/// The steps made so far.
#[derive(Default)]
struct StepBuilder {
    steps: Vec<GeneratorStep>,
    loops: Vec<LoopPatches>,
}

impl StepBuilder {
    fn next_index(&self) -> StepIndex {
        self.steps.len() as StepIndex
    }

    /// Adds a step; returns its index, to fill its place in later.
    fn add(&mut self, step: GeneratorStep) -> usize {
        self.steps.push(step);
        self.steps.len() - 1
    }

    /// The place that the steps lead to which go on elsewhere: the next step to be added.
    fn patch_here(&mut self, steps: &[usize]) {
        let here = self.next_index();
        for index in steps {
            match &mut self.steps[*index] {
                GeneratorStep::Jump(place)
                | GeneratorStep::JumpUnless {
                    otherwise: place, ..
                }
                | GeneratorStep::Next { end: place, .. } => *place = here,
                _ => {}
            }
        }
    }

    /// The innermost loop is done: its `continue`s lead to `turn`, its `break`s here.
    fn end_loop(&mut self, turn: StepIndex) {
        let here = self.next_index();
        let Some(ended) = self.loops.pop() else {
            return;
        };
        for (indices, place) in [(ended.continues, turn), (ended.breaks, here)] {
            for index in indices {
                match &mut self.steps[index] {
                    GeneratorStep::Run { on_continue, .. } if place == turn => *on_continue = place,
                    GeneratorStep::Run { on_break, .. } => *on_break = place,
                    GeneratorStep::Jump(to) => *to = place,
                    _ => {}
                }
            }
        }
    }
}

impl Lower<'_> {
    /// The body of a generator function.
    pub(super) fn generator_body(&mut self, body: &[Stmt]) -> Body {
        // Watched statements are nodes around others, which steps are not.
        let is_watched = self.debugger.is_some();
        if is_watched
            || !body
                .iter()
                .all(|statement| can_stop(statement, self.budget))
        {
            return Body::Block(self.block(body));
        }
        let mut made = StepBuilder::default();
        self.steps(body, &mut made);
        Body::Steps(made.steps.into())
    }

    /// The body of a generator expression; its first iterable is the parameter.
    pub(super) fn generator_expression_body(
        &mut self,
        comprehension: &ast::Comprehension,
        first: BoxExpr,
        element: &ast::Expr,
    ) -> Body {
        let line = self.line(element.span);
        let mut made = StepBuilder::default();
        let mut turns = Vec::new();
        let mut first = Some(first);
        for clause in &comprehension.clauses {
            let iterable = match first.take() {
                Some(first) => first,
                None => self.expr(&clause.iterable),
            };
            let span = clause.iterable.span;
            made.add(GeneratorStep::BeginFor {
                line,
                iterable,
                span,
            });
            let head = made.next_index();
            let target = self.loop_target(&clause.target);
            let next = made.add(GeneratorStep::Next {
                target,
                span,
                end: LATER,
            });
            let mut skips = Vec::new();
            for condition in &clause.conditions {
                let test = self.expr(condition);
                skips.push(made.add(GeneratorStep::JumpUnless {
                    line,
                    test,
                    otherwise: LATER,
                }));
            }
            turns.push((head, next, skips));
        }
        let value = self.operand(element);
        made.add(GeneratorStep::Yield {
            line,
            value,
            sent: None,
            span: element.span,
        });
        for (head, next, skips) in turns.into_iter().rev() {
            made.patch_here(&skips);
            made.add(GeneratorStep::LoopBack { line, head });
            made.patch_here(&[next]);
        }
        Body::Steps(made.steps.into())
    }

    fn steps(&mut self, body: &[Stmt], made: &mut StepBuilder) {
        self.deeper(|lower| {
            for statement in body {
                let (line, start) = (lower.line(statement.span), statement.span.start);
                lower.pass_steps(DirectiveAnchor::Before(start), line, made);
                if let Some(mark) = lower.mark(statement, line) {
                    Self::run_step(Box::new(mark), line, made);
                }
                lower.step(statement, made);
                lower.pass_steps(DirectiveAnchor::After(start), line, made);
            }
        });
    }

    fn step(&mut self, statement: &Stmt, made: &mut StepBuilder) {
        let line = self.line(statement.span);
        match &statement.kind {
            StmtKind::Return(value) => {
                let value = match value {
                    Some(value) => self.operand(value),
                    None => Operand::Const(Value::None),
                };
                made.add(GeneratorStep::Return { line, value });
            }
            _ if !yields(statement, self.budget) => self.plain_step(statement, line, made),
            StmtKind::Expr(value) => self.yield_step(value, None, line, made),
            StmtKind::Assign { targets, value } => {
                let target = targets.first().map(|target| self.target(target));
                self.yield_step(value, target, line, made);
            }
            StmtKind::If { branches, orelse } => self.if_steps(branches, orelse, made),
            StmtKind::While { test, body, orelse } => {
                let line = self.line(test.span);
                let head = made.next_index();
                let test = self.expr(test);
                let unless = made.add(GeneratorStep::JumpUnless {
                    line,
                    test,
                    otherwise: LATER,
                });
                made.loops.push(LoopPatches::default());
                self.steps(body, made);
                let turn = made.next_index();
                made.add(GeneratorStep::LoopBack { line, head });
                made.patch_here(&[unless]);
                // `break` leaves the `else` block out, which belongs to the loop around already.
                let ended = made.loops.pop();
                self.steps(orelse, made);
                made.loops.extend(ended);
                made.end_loop(turn);
            }
            StmtKind::For {
                target,
                iterable,
                body,
                orelse,
            } => self.for_steps(target, iterable, body, orelse, line, made),
            // `can_stop` lets no other statement with a `yield` through.
            _ => {}
        }
    }

    /// A statement without `yield`.
    fn plain_step(&mut self, statement: &Stmt, line: u32, made: &mut StepBuilder) {
        if let Some(node) = self.statement(statement) {
            Self::run_step(node, line, made);
        }
    }

    /// Directives.
    fn pass_steps(&self, place: DirectiveAnchor, line: u32, made: &mut StepBuilder) {
        let mut lines = Vec::new();
        self.pass(place, line, &mut lines);
        for (line, node) in lines {
            Self::run_step(node, line, made);
        }
    }

    fn run_step(node: Box<dyn DynStmt>, line: u32, made: &mut StepBuilder) {
        let index = made.add(GeneratorStep::Run {
            line,
            statement: node,
            on_break: LATER,
            on_continue: LATER,
        });
        if let Some(innermost) = made.loops.last_mut() {
            innermost.breaks.push(index);
            innermost.continues.push(index);
        }
    }

    /// `sent = yield …`
    fn yield_step(
        &mut self,
        value: &ast::Expr,
        sent: Option<Box<dyn Target>>,
        line: u32,
        made: &mut StepBuilder,
    ) {
        let span: Span = value.span;
        made.add(match &value.kind {
            ExprKind::YieldFrom(iterable) => GeneratorStep::Delegate {
                line,
                iterable: self.expr(iterable),
                sent,
                span,
            },
            ExprKind::Yield(Some(value)) => GeneratorStep::Yield {
                line,
                value: self.operand(value),
                sent,
                span,
            },
            _ => GeneratorStep::Yield {
                line,
                value: Operand::Const(Value::None),
                sent,
                span,
            },
        });
    }

    fn if_steps(
        &mut self,
        branches: &[(ast::Expr, Vec<Stmt>)],
        orelse: &[Stmt],
        made: &mut StepBuilder,
    ) {
        let mut ends = Vec::new();
        for (index, (test, body)) in branches.iter().enumerate() {
            let line = self.line(test.span);
            let test = self.branch_test(test, index == 0);
            let unless = made.add(GeneratorStep::JumpUnless {
                line,
                test,
                otherwise: LATER,
            });
            self.steps(body, made);
            ends.push(made.add(GeneratorStep::Jump(LATER)));
            made.patch_here(&[unless]);
        }
        self.steps(orelse, made);
        made.patch_here(&ends);
    }

    fn for_steps(
        &mut self,
        target: &ast::Expr,
        iterable: &ast::Expr,
        body: &[Stmt],
        orelse: &[Stmt],
        line: u32,
        made: &mut StepBuilder,
    ) {
        let span = iterable.span;
        let iterable = self.expr(iterable);
        made.add(GeneratorStep::BeginFor {
            line,
            iterable,
            span,
        });
        let head = made.next_index();
        let target = self.loop_target(target);
        let next = made.add(GeneratorStep::Next {
            target,
            span,
            end: LATER,
        });
        made.loops.push(LoopPatches::default());
        self.steps(body, made);
        let turn = made.next_index();
        made.add(GeneratorStep::LoopBack { line, head });
        made.patch_here(&[next]);
        let ended = made.loops.pop();
        self.steps(orelse, made);
        let over = made.add(GeneratorStep::Jump(LATER));
        made.loops.extend(ended);
        made.end_loop(turn);
        made.add(GeneratorStep::EndFor);
        made.patch_here(&[over]);
    }
}

/// Work to look at a statement or an expression.
const LOOK: usize = 32;

/// Whether a statement can be taken apart into steps: no `yield` in it, or only where a step can stop.
fn can_stop(statement: &Stmt, budget: &WorkBudget<'_>) -> bool {
    let has_yield = |expr: &ast::Expr| has_yield(expr, budget);
    let can_stop = |statement: &Stmt| can_stop(statement, budget);
    if !yields(statement, budget) {
        return true;
    }
    let stops = |value: &ast::Expr| match &value.kind {
        ExprKind::Yield(Some(inner)) | ExprKind::YieldFrom(inner) => !has_yield(inner),
        ExprKind::Yield(None) => true,
        _ => false,
    };
    match &statement.kind {
        StmtKind::Expr(value) => stops(value),
        StmtKind::Assign { targets, value } => match &targets[..] {
            [target] => stops(value) && !has_yield(target),
            _ => false,
        },
        StmtKind::If { branches, orelse } => {
            let mut tests = branches.iter().map(|(test, _)| test);
            let bodies = branches.iter().flat_map(|(_, body)| body);
            !tests.any(has_yield) && bodies.chain(orelse).all(can_stop)
        }
        StmtKind::While { test, body, orelse } => {
            !has_yield(test) && body.iter().chain(orelse).all(can_stop)
        }
        StmtKind::For {
            target,
            iterable,
            body,
            orelse,
        } => {
            let heads = !has_yield(target) && !has_yield(iterable);
            heads && body.iter().chain(orelse).all(can_stop)
        }
        _ => false,
    }
}

/// Whether there is a `yield` of the function itself in a statement.
fn yields(statement: &Stmt, budget: &WorkBudget<'_>) -> bool {
    budget.charge(LOOK);
    let mut found = false;
    visit::own_expressions(statement, &mut |expr| {
        found = found || has_yield(expr, budget)
    });
    let own = match &statement.kind {
        StmtKind::Function(_) | StmtKind::Class(_) => Vec::new(),
        _ => visit::blocks(statement),
    };
    found
        || own
            .into_iter()
            .flatten()
            .any(|statement| yields(statement, budget))
}

/// Whether there is a `yield` in an expression; those of lambdas in it count too.
fn has_yield(expr: &ast::Expr, budget: &WorkBudget<'_>) -> bool {
    budget.charge(LOOK);
    let mut found = matches!(expr.kind, ExprKind::Yield(_) | ExprKind::YieldFrom(_));
    visit::parts(expr, &mut |part| found = found || has_yield(part, budget));
    found
}
