//! The value of an expression that is typed: shown as Python's prompt shows it, where the controller tells what is
//! printed.

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
    known.is_none_or(|builtin| !builtin.returns.english().starts_with("nothing"))
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

/// The report of an error as it concerns what was typed: without the calls of the program `own` that holds the mode,
/// and without what was put around a statement.
pub(super) fn in_report(report: &str, own: &str) -> String {
    let own = format!("{own}, line ");
    let mut lines: Vec<String> = Vec::new();
    let mut in_own = false;
    let mut is_shifted = false;
    for line in report.lines() {
        let depth = line.len() - line.trim_start().len();
        let is_place = depth == 2 && line.contains(", line ");
        in_own = match is_place {
            true => line.trim_start().starts_with(&own),
            false => in_own && depth > 2,
        };
        if in_own {
            continue;
        }
        let marks = line.trim();
        if is_shifted && !marks.is_empty() && marks.bytes().all(|byte| byte == b'^') {
            let begin = depth.saturating_sub(BEFORE.len()).max(4);
            lines.push(format!("{}{marks}", " ".repeat(begin)));
            is_shifted = false;
            continue;
        }
        is_shifted = false;
        match typed(line.trim_start()) {
            Some(text) => {
                if let Some(place) = lines.last_mut() {
                    *place = without_shift(place);
                }
                lines.push(format!("{}{text}", " ".repeat(depth)));
                is_shifted = true;
            }
            None => lines.push(line.to_owned()),
        }
    }
    lines.join("\n")
}

/// `statement, line 1, column 7, in <module>` with the column in what was typed.
fn without_shift(place: &str) -> String {
    let moved = place.split_once(", column ").and_then(|(before, after)| {
        let (column, behind) = after.split_once(',')?;
        let column = column.parse::<usize>().ok()?;
        let column = column.saturating_sub(BEFORE.len()).max(1);
        Some(format!("{before}, column {column},{behind}"))
    });
    moved.unwrap_or_else(|| place.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reports_are_about_what_was_typed() {
        let report = "Traceback (most recent call last):\n\
            \u{20} eliteserver_shell, line 7, column 2, in eliteserver_shell\n\
            \u{20}   interpreter_mode(clearQueueOnEnter=False, clearOnEnd=True)\n\
            \u{20}   ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^\n\
            \u{20} statement, line 1, column 11, in <module>\n\
            \u{20}   _show(1 + moveJ([0]))\n\
            \u{20}             ^^^^^\n\
            \u{20} help: did you mean 'movej'\n\
            NameError: name 'moveJ' is not defined";
        let told = "Traceback (most recent call last):\n\
            \u{20} statement, line 1, column 5, in <module>\n\
            \u{20}   1 + moveJ([0])\n\
            \u{20}       ^^^^^\n\
            \u{20} help: did you mean 'movej'\n\
            NameError: name 'moveJ' is not defined";
        assert_eq!(in_report(report, "eliteserver_shell"), told);
        let other = "Traceback (most recent call last):\n  statement, line 1, column 1, in <module>\n    f()\n    ^^^\n\
            ValueError: no";
        assert_eq!(in_report(other, "eliteserver_shell"), other);
        assert_eq!(in_report("", "eliteserver_shell"), "");
    }

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
