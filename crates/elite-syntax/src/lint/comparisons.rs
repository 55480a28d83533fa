//! Comparisons whose answer nobody takes: mostly an assignment with one `=` too many.

use messages::text;

use crate::ast::{CompareOp, Expr, ExprKind, Stmt, StmtKind};
use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::DiagnosticList;
use crate::source::{SourceFile, Span};

/// A statement that compares and does nothing else.
pub(super) fn check(statement: &Stmt, file: &SourceFile, found: &mut DiagnosticList) {
    let StmtKind::Expr(Expr {
        kind: ExprKind::Compare { left, rest },
        span,
        ..
    }) = &statement.kind
    else {
        return;
    };
    // Nobody writes a chain for an assignment.
    if found.is_full() || rest.len() > 1 {
        return;
    }
    let text = text!(
        "this compares and does nothing with the answer",
        "这里做了比较，却没有使用结果"
    );
    let finding = Diagnostic::warning("unused-comparison", *span, text);
    let is_target = matches!(
        left.kind,
        ExprKind::Name(_) | ExprKind::Attribute { .. } | ExprKind::Subscript { .. }
    );
    found.push(match rest.as_slice() {
        [(CompareOp::Eq, right)] if is_target => {
            let finding = finding.with_help(text!(
                "'=' assigns, '==' compares",
                "'=' 用于赋值，'==' 用于比较"
            ));
            let between = Span::new(left.span.end as usize, right.span.start as usize);
            match file.slice(between).find("==") {
                Some(at) => {
                    let start = between.start as usize + at;
                    finding.with_fix(Span::new(start, start + 2), "=")
                }
                None => finding,
            }
        }
        _ => finding.with_help(text!(
            "to stop the program where it does not hold, write 'assert' before it",
            "如果要在条件不成立时停止程序，请在前面写 'assert'"
        )),
    });
}
