//! The motions of a program as calls in its text: where their numbers stand, and texts with other numbers.

use std::collections::BTreeMap;

use elite_syntax::ast::visit::{NodePart, statement_parts};
use elite_syntax::ast::{Arg, Constant, Expr, ExprKind, Stmt, StmtKind};
use elite_syntax::parser::parse;
use elite_syntax::{SourceFile, Span};

/// A number of a call.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum CallNumber {
    /// The call leaves the argument out.
    Absent,
    /// The call gives a literal.
    Literal {
        /// The place in the text.
        span: Span,
        /// The number.
        value: f64,
    },
    /// A name or a computation: what the programmer decides elsewhere.
    Computed,
}

/// The kinds of motion that calls make.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum MotionKind {
    /// The joints go straight: speeds in rad/s.
    Joints,
    /// The TCP goes along a line or an arc: speeds in m/s.
    Line,
}

/// A motion of a program.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MotionCall {
    /// Line of the call, from 1.
    pub(super) line: u32,
    pub(super) kind: MotionKind,
    pub(super) acceleration: CallNumber,
    pub(super) speed: CallNumber,
    pub(super) radius: CallNumber,
    /// Where a further argument goes.
    pub(super) end_of_arguments: usize,
    /// The whole statement.
    pub(super) statement: Span,
    /// The statement before it and the one behind it in its block are motions, too.
    pub(super) follows_motion: bool,
    pub(super) precedes_motion: bool,
}

/// What a call is to have instead of what it has.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct CallChange {
    pub(super) acceleration: Option<f64>,
    pub(super) speed: Option<f64>,
    pub(super) radius: Option<f64>,
    /// The call goes.
    pub(super) is_dropped: bool,
}

/// A motion, and where its numbers are among the positional arguments of a call.
struct MotionSignature {
    name: &'static str,
    kind: MotionKind,
    acceleration: usize,
    speed: usize,
    duration: Option<usize>,
    radius: usize,
}

const fn signature(
    name: &'static str,
    kind: MotionKind,
    acceleration: usize,
    duration: Option<usize>,
    radius: usize,
) -> MotionSignature {
    MotionSignature {
        name,
        kind,
        acceleration,
        speed: acceleration + 1,
        duration,
        radius,
    }
}

static MOTIONS: [MotionSignature; 4] = [
    signature("movej", MotionKind::Joints, 1, Some(3), 4),
    signature("movel", MotionKind::Line, 1, Some(3), 4),
    signature("movep", MotionKind::Line, 1, None, 3),
    signature("movec", MotionKind::Line, 2, None, 4),
];

/// The motions of a program that have no duration, in the order of the text.
pub(super) fn motion_calls(text: &str) -> Vec<MotionCall> {
    let file = SourceFile::new("program", text);
    let parsed = parse(&file);
    let mut calls = Vec::new();
    block(&parsed.module.body, &file, &mut calls);
    calls.sort_by_key(|call| call.statement.start);
    calls
}

fn block(statements: &[Stmt], file: &SourceFile, calls: &mut Vec<MotionCall>) {
    for (number, statement) in statements.iter().enumerate() {
        if let Some(mut call) = call_of(statement, file) {
            let is_motion = |at: Option<usize>| {
                let other = at.and_then(|at| statements.get(at));
                other.is_some_and(|other| motion_of(other).is_some())
            };
            call.follows_motion = is_motion(number.checked_sub(1));
            call.precedes_motion = is_motion(Some(number + 1));
            calls.push(call);
        }
        statement_parts(statement, &mut |part| {
            if let NodePart::Block(inner) = part {
                block(inner, file, calls);
            }
        });
    }
}

/// The motion that a statement is, with the arguments of its call.
fn motion_of(statement: &Stmt) -> Option<(&'static MotionSignature, &Expr, &[Arg])> {
    let StmtKind::Expr(value) = &statement.kind else {
        return None;
    };
    let ExprKind::Call { function, args } = &value.kind else {
        return None;
    };
    let ExprKind::Name(name) = &function.kind else {
        return None;
    };
    let signature = MOTIONS.iter().find(|motion| *motion.name == **name)?;
    Some((signature, value, args))
}

fn call_of(statement: &Stmt, file: &SourceFile) -> Option<MotionCall> {
    let (signature, value, args) = motion_of(statement)?;
    let unpacks = |arg: &Arg| matches!(arg, Arg::Star(_) | Arg::DoubleStar(_));
    if args.iter().any(unpacks) {
        return None;
    }
    let find = |position: Option<usize>, name: &str| {
        args.iter().enumerate().find_map(|(at, arg)| match arg {
            Arg::Positional(value) if Some(at) == position => Some(value),
            Arg::Keyword(keyword, value) if &*keyword.name == name => Some(value),
            _ => None,
        })
    };
    if find(signature.duration, "t").is_some() {
        return None;
    }
    let number = |position, name| match find(Some(position), name) {
        None => CallNumber::Absent,
        Some(expr) => match &expr.kind {
            ExprKind::Constant(Constant::Float(value)) => CallNumber::Literal {
                span: expr.span,
                value: *value,
            },
            ExprKind::Constant(Constant::Int(value)) => CallNumber::Literal {
                span: expr.span,
                value: *value as f64,
            },
            _ => CallNumber::Computed,
        },
    };
    let end = value.span.range().end;
    let text = file.text();
    Some(MotionCall {
        line: file.line_of(statement.span.start),
        kind: signature.kind,
        acceleration: number(signature.acceleration, "a"),
        speed: number(signature.speed, "v"),
        radius: number(signature.radius, "r"),
        end_of_arguments: text.get(..end)?.rfind(')')?,
        statement: statement.span,
        follows_motion: false,
        precedes_motion: false,
    })
}

impl CallNumber {
    /// The number, or what it is where it is not given; `None` where the program computes it.
    pub(super) const fn value(&self, default: f64) -> Option<f64> {
        match self {
            Self::Absent => Some(default),
            Self::Literal { value, .. } => Some(*value),
            Self::Computed => None,
        }
    }
}

/// The text with these changes. Dropped calls leave `pass` in their line, so that lines keep their numbers.
pub(super) fn changed_text(
    text: &str,
    calls: &[MotionCall],
    changes: &BTreeMap<usize, CallChange>,
) -> String {
    let mut edits: Vec<(core::ops::Range<usize>, String)> = Vec::new();
    for (&number, change) in changes {
        let Some(call) = calls.get(number) else {
            continue;
        };
        if change.is_dropped {
            let lines = text[call.statement.range()].matches('\n').count();
            edits.push((
                call.statement.range(),
                format!("pass{}", "\n".repeat(lines)),
            ));
            continue;
        }
        let mut further = String::new();
        for (name, has, wanted) in [
            ("a", call.acceleration, change.acceleration),
            ("v", call.speed, change.speed),
            ("r", call.radius, change.radius),
        ] {
            match (has, wanted) {
                (CallNumber::Literal { span, .. }, Some(value)) => {
                    edits.push((span.range(), value.to_string()));
                }
                (CallNumber::Absent, Some(value)) => {
                    further.push_str(&format!(", {name}={value}"));
                }
                _ => {}
            }
        }
        if !further.is_empty() {
            edits.push((call.end_of_arguments..call.end_of_arguments, further));
        }
    }
    edits.sort_by_key(|(range, _)| range.start);
    let mut changed = text.to_owned();
    for (range, new) in edits.into_iter().rev() {
        changed.replace_range(range, &new);
    }
    changed
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "def f():\n    movej([0,0,0,0,0,0], 1.4, v=1)\n    movel(p, r=rad)\n    movej(q, t=2)\n\
                        \x20   set_flag(1, True)\n    movep(\n        p,\n        a=0.5)\nend\n";

    #[test]
    fn motions_are_found_with_their_numbers() {
        let calls = motion_calls(TEXT);
        let lines: Vec<u32> = calls.iter().map(|call| call.line).collect();
        assert_eq!(lines, [2, 3, 6]);
        assert_eq!(calls[0].acceleration.value(0.0), Some(1.4));
        assert_eq!(calls[0].speed.value(0.0), Some(1.0));
        assert_eq!(calls[0].radius, CallNumber::Absent);
        assert_eq!(calls[1].radius, CallNumber::Computed);
        assert!(calls[0].precedes_motion && !calls[0].follows_motion);
        assert!(calls[1].precedes_motion && calls[1].follows_motion);
        assert!(!calls[2].precedes_motion && !calls[2].follows_motion);
    }

    #[test]
    fn a_change_touches_only_its_numbers() {
        let calls = motion_calls(TEXT);
        let faster = CallChange {
            speed: Some(3.0),
            radius: Some(0.05),
            ..CallChange::default()
        };
        let dropped = CallChange {
            is_dropped: true,
            ..CallChange::default()
        };
        let changes = BTreeMap::from([(0, faster), (1, faster), (2, dropped)]);
        let changed = changed_text(TEXT, &calls, &changes);
        let expected = "def f():\n    movej([0,0,0,0,0,0], 1.4, v=3, r=0.05)\n    movel(p, r=rad, v=3)\n\
                        \x20   movej(q, t=2)\n    set_flag(1, True)\n    pass\n\n\nend\n";
        assert_eq!(changed, expected);
    }
}
