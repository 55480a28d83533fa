//! The value of an expression that is typed: shown as Python's prompt shows it, where the controller tells what is printed.

use elite_runtime::builtins::all;
use elite_syntax::ast::{Expr, ExprKind, Stmt, StmtKind};
use elite_syntax::{SourceFile, parser};

/// What the program that holds interpreter mode defines for it.
pub(super) const DEFINITION: &str =
    "\tdef _show(value):\n\t\tif value is not None:\n\t\t\tprint(repr(value))\n\t\tend\n\tend\n";
const BEFORE: &str = "_show(";
const AFTER: &str = ")";

/// The statement that shows the value of an expression; none if the text is none, or has no value.
pub(super) fn with_value(text: &str) -> Option<String> {
    let text = text.trim();
    let parsed = parser::parse(&SourceFile::new("shell", format!("{text}\n")));
    let is_one_line = !text.contains(['\n', ';', '#']);
    match parsed.module.body.as_slice() {
        [
            Stmt {
                kind: StmtKind::Expr(expr),
                ..
            },
        ] if parsed.diagnostics.is_empty() && is_one_line && has_value(expr) => {
            Some(format!("{BEFORE}{text}{AFTER}"))
        }
        _ => None,
    }
}

/// Whether an expression may have a value: most functions of the robot give nothing back.
fn has_value(expr: &Expr) -> bool {
    let ExprKind::Call { function, .. } = &expr.kind else {
        return !matches!(
            expr.kind,
            ExprKind::Yield(_) | ExprKind::YieldFrom(_) | ExprKind::Starred(_)
        );
    };
    let ExprKind::Name(name) = &function.kind else {
        return true;
    };
    let known = all().find(|builtin| *builtin.name == **name);
    known.is_none_or(|builtin| !builtin.returns.starts_with("nothing"))
}

/// What was typed, of a statement that was sent.
pub(super) fn typed(sent: &str) -> Option<&str> {
    sent.strip_prefix(BEFORE)?.strip_suffix(AFTER)
}

/// A reply with what was typed in place of what was sent.
pub(super) fn in_reply(about: &str, text: &str) -> String {
    let text = text.trim();
    about.replace(&format!("{BEFORE}{text}{AFTER}"), text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn expressions_are_shown_and_statements_are_not() {
        for text in ["1 + 2", "x", "get_actual_tcp_pose()[2]", "len(p)", "[1, 2]"] {
            let sent = with_value(text).expect("it has a value");
            assert_eq!(typed(&sent), Some(text));
            assert_eq!(
                in_reply(&format!("reason: {sent}"), text),
                format!("reason: {text}")
            );
        }
        for text in [
            "x = 3",
            "movej([0, 0, 0, 0, 0, 0])",
            "print(1)",
            "sleep(1)",
            "a; b",
            "1 +",
            "print 3",
        ] {
            assert_eq!(with_value(text), None, "{text}");
        }
    }
}
