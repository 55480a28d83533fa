//! What is never reached, loops that never wait, and modules that are not there.

use messages::text;

use super::{comparisons, imports};
use crate::ast::visit::{blocks, own_expressions, parts};
use crate::ast::{Constant, Expr, ExprKind, Stmt, StmtKind};
use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::DiagnosticList;
use crate::resolve::KnownNames;
use crate::source::{SourceFile, Span};

pub(super) fn check(
    body: &[Stmt],
    file: &SourceFile,
    known: &KnownNames,
    found: &mut DiagnosticList,
) {
    check_block(body, file, known, Guard::default(), found);
}

/// What the program catches around a block.
#[derive(Clone, Copy, Default)]
struct Guard {
    /// That a module is not there.
    may_miss: bool,
    /// Any exception.
    may_fail: bool,
}

fn check_block(
    body: &[Stmt],
    file: &SourceFile,
    known: &KnownNames,
    guard: Guard,
    found: &mut DiagnosticList,
) {
    if found.is_full() {
        return;
    }
    unreachable(body, file, found);
    check_nested(body, file, known, guard, found);
}

/// Checks what is nested in the statements of `body`, but not what is never reached in `body` itself.
pub(super) fn check_each(
    body: &[Stmt],
    file: &SourceFile,
    known: &KnownNames,
    found: &mut DiagnosticList,
) {
    check_nested(body, file, known, Guard::default(), found);
}

fn check_nested(
    body: &[Stmt],
    file: &SourceFile,
    known: &KnownNames,
    guard: Guard,
    found: &mut DiagnosticList,
) {
    let Guard {
        may_miss,
        may_fail: guarded,
    } = guard;
    for statement in body {
        if !may_miss {
            imports::check(statement, found);
        }
        if let StmtKind::While { test, body, .. } = &statement.kind {
            busy_loop(test, body, known, found);
        }
        if !guarded {
            comparisons::check(statement, file, found);
        }
        let catches = imports::catches(statement);
        let handles =
            matches!(&statement.kind, StmtKind::Try { handlers, .. } if !handlers.is_empty());
        for (index, block) in blocks(statement).into_iter().enumerate() {
            // The first block of a `try` is what it guards.
            let caught = Guard {
                may_miss: may_miss || catches && index == 0,
                may_fail: guarded || handles && index == 0,
            };
            check_block(block, file, known, caught, found);
        }
    }
}

/// What is never reached in a block.
pub(crate) fn unreachable(body: &[Stmt], file: &SourceFile, found: &mut DiagnosticList) {
    let Some(last) = body.iter().position(ends) else {
        return;
    };
    let Some(next) = body.get(last + 1) else {
        return;
    };
    // `return; yield` makes a function a generator.
    let is_marker = matches!(
        &next.kind,
        StmtKind::Pass
            | StmtKind::Expr(Expr {
                kind: ExprKind::Yield(_) | ExprKind::YieldFrom(_) | ExprKind::Constant(_),
                ..
            })
    );
    if is_marker {
        return;
    }
    let before = &body[last];
    let reason = match &before.kind {
        StmtKind::Return(_) => text!("after this 'return'", "在这个 'return' 之后"),
        StmtKind::Raise { .. } => text!("after this 'raise'", "在这个 'raise' 之后"),
        StmtKind::Break => text!("after this 'break'", "在这个 'break' 之后"),
        StmtKind::Continue => text!("after this 'continue'", "在这个 'continue' 之后"),
        StmtKind::While { .. } => text!("this loop has no way out", "这个循环无法退出"),
        _ => text!("no way leads past this", "没有路径越过这里"),
    };
    let diagnostic = Diagnostic::warning(
        "unreachable",
        first_line(next.span, file),
        text!("this is never reached", "这里永远不会执行到"),
    );
    found.push(diagnostic.with_label(first_line(before.span, file), reason));
}

/// The part of a span on its first line.
fn first_line(span: Span, file: &SourceFile) -> Span {
    let text = file.slice(span);
    let length = text.find(['\n', '\r']).unwrap_or(text.len());
    Span::new(span.start as usize, span.start as usize + length)
}

/// Whether nothing that follows a statement in its block is ever reached.
fn ends(statement: &Stmt) -> bool {
    let block_ends = |body: &[Stmt]| body.iter().any(ends);
    match &statement.kind {
        StmtKind::Return(_) | StmtKind::Raise { .. } | StmtKind::Break | StmtKind::Continue => true,
        StmtKind::If { branches, orelse } => {
            block_ends(orelse) && branches.iter().all(|(_, body)| block_ends(body))
        }
        StmtKind::While { test, body, .. } => is_true(test) && !leaves(body, LoopExit::Break),
        StmtKind::Try {
            body,
            handlers,
            orelse,
            finally,
        } => {
            let passes = block_ends(body) || block_ends(orelse);
            block_ends(finally)
                || passes && handlers.iter().all(|handler| block_ends(&handler.body))
        }
        _ => false,
    }
}

fn is_true(test: &Expr) -> bool {
    match &test.kind {
        ExprKind::Constant(Constant::Bool(flag)) => *flag,
        ExprKind::Constant(Constant::Int(int)) => *int != 0,
        _ => false,
    }
}

/// Ways out of a loop.
#[derive(Clone, Copy, PartialEq, Eq)]
enum LoopExit {
    /// `break` of this very loop.
    Break,
    /// `break`, `return` or `raise`.
    Any,
}

/// Whether a loop with this body can be left.
fn leaves(body: &[Stmt], how: LoopExit) -> bool {
    body.iter().any(|statement| match &statement.kind {
        StmtKind::Break => true,
        StmtKind::Return(_) | StmtKind::Raise { .. } | StmtKind::Assert { .. } => {
            how == LoopExit::Any
        }
        StmtKind::Function(_) | StmtKind::Class(_) => false,
        StmtKind::While { body, orelse, .. } | StmtKind::For { body, orelse, .. } => {
            // A `break` in there leaves that loop only.
            leaves(orelse, how) || how == LoopExit::Any && returns(body)
        }
        _ => blocks(statement)
            .into_iter()
            .any(|block| leaves(block, how)),
    })
}

fn returns(body: &[Stmt]) -> bool {
    body.iter().any(|statement| match &statement.kind {
        StmtKind::Return(_) | StmtKind::Raise { .. } => true,
        StmtKind::Function(_) | StmtKind::Class(_) => false,
        _ => blocks(statement).into_iter().any(returns),
    })
}

/// A loop that asks the robot again and again, or goes on for ever, and waits nowhere (manual 1.2.5).
fn busy_loop(test: &Expr, body: &[Stmt], known: &KnownNames, found: &mut DiagnosticList) {
    let mut calls = LoopCalls::default();
    calls.expression(test, known);
    calls.block(body, known);
    let endless = is_true(test) && !leaves(body, LoopExit::Any);
    let message = if calls.may_wait {
        if !endless || !Ways::through(body, known).turn() {
            return;
        }
        text!(
            "there is a way through this endless loop that does not wait: while it is taken, \
         the loop keeps the controller busy",
            "这个无限循环中有一条不等待的路径：走这条路径时会使控制器一直繁忙"
        )
    } else if calls.asks {
        text!(
            "this loop asks again and again without waiting in between: it keeps the controller \
             busy",
            "这个循环不断查询而不等待：会使控制器一直繁忙"
        )
    } else if endless {
        text!(
            "this loop never ends and never waits: it keeps the controller busy",
            "这个循环既不结束也不等待：会使控制器一直繁忙"
        )
    } else {
        return;
    };
    let diagnostic = Diagnostic::warning("busy-loop", test.span, message);
    found.push(diagnostic.with_help(text!(
        "call sleep() or sync() in it",
        "请在其中调用 sleep() 或 sync()"
    )));
}

/// Where the ways lead that nothing on them waits on, from the beginning of a block.
#[derive(Clone, Copy, Default)]
struct Ways {
    /// To the end of the block.
    pass: bool,
    /// To a `continue` of the loop.
    go_on: bool,
}

impl Ways {
    fn through(body: &[Stmt], known: &KnownNames) -> Self {
        let mut ways = Ways {
            pass: true,
            go_on: false,
        };
        for statement in body {
            let step = Ways::of(statement, known);
            ways.go_on |= step.go_on;
            if !step.pass {
                ways.pass = false;
                break;
            }
        }
        ways
    }

    fn of(statement: &Stmt, known: &KnownNames) -> Self {
        let mut calls = LoopCalls::default();
        let branches = match &statement.kind {
            StmtKind::If { branches, orelse } => {
                own_expressions(statement, &mut |expr| calls.expression(expr, known));
                let bodies = branches.iter().map(|(_, body)| &body[..]);
                bodies.chain([&orelse[..]])
            }
            StmtKind::Continue => {
                return Ways {
                    pass: false,
                    go_on: true,
                };
            }
            StmtKind::Break | StmtKind::Return(_) | StmtKind::Raise { .. } => {
                return Ways::default();
            }
            // How often other loops turn and where a guarded block breaks off is not foreseen: one wait anywhere in
            // them will do.
            _ => {
                calls.block(std::slice::from_ref(statement), known);
                return Ways {
                    pass: !calls.may_wait && !ends(statement),
                    go_on: false,
                };
            }
        };
        if calls.may_wait {
            return Ways::default();
        }
        branches.fold(Ways::default(), |all, body| {
            let ways = Ways::through(body, known);
            Ways {
                pass: all.pass || ways.pass,
                go_on: all.go_on || ways.go_on,
            }
        })
    }

    /// Whether one of them leads to the next turn.
    fn turn(self) -> bool {
        self.pass || self.go_on
    }
}

/// What the calls in a loop do.
#[derive(Default)]
struct LoopCalls {
    /// One of the calls waits, or may: what methods and functions of scripts do is not looked into.
    may_wait: bool,
    /// One of the calls is to a function of the embedder that returns at once.
    asks: bool,
}

impl LoopCalls {
    fn block(&mut self, body: &[Stmt], known: &KnownNames) {
        for statement in body {
            if let StmtKind::Function(_) | StmtKind::Class(_) = statement.kind {
                continue;
            }
            // Iterators and context managers may wait in their methods.
            if let StmtKind::With { .. } = statement.kind {
                self.may_wait = true;
            }
            own_expressions(statement, &mut |expr| self.expression(expr, known));
            for block in blocks(statement) {
                self.block(block, known);
            }
        }
    }

    fn expression(&mut self, expr: &Expr, known: &KnownNames) {
        match &expr.kind {
            ExprKind::Yield(_) | ExprKind::YieldFrom(_) => self.may_wait = true,
            ExprKind::Lambda(_) => return,
            ExprKind::Call { function, .. } => match &function.kind {
                ExprKind::Name(name) if known.contains(name) => {
                    self.may_wait |= known.waits(name);
                    self.asks = true;
                }
                ExprKind::Name(name) if crate::python_names::is_builtin_name(name) => {}
                _ => self.may_wait = true,
            },
            _ => {}
        }
        parts(expr, &mut |part| self.expression(part, known));
    }
}
