//! The report of an error in one line: `Type: message`, the place, and the node of the pendant's task.
//!
//! Owns how the reports of `elite_lang::render_script_error` and `render_human` are read back from a recording.
//! Messages of another form are told by their first line.

use std::fmt::Write as _;

use editor::analysis::words::Language;

use crate::language;

/// Begins the call stack of a report.
const TRACEBACK: &str = "Traceback (most recent call last):";
/// Begins the line that names the node.
const NODE: &str = "  in node ";
/// Begins the line with advice.
const HELP: &str = "  help: ";
/// Begins the place of a finding in a text that does not compile.
const ARROW: &str = "--> ";

/// What happened and where.
pub(super) fn in_one_line(message: &str, language: Language) -> String {
    let reported = |english: &str| language::reported_in(language, english).into_owned();
    let lines: Vec<&str> = message.lines().collect();
    // An exception that came from another one is reported behind it.
    if let Some(begin) = lines.iter().rposition(|line| *line == TRACEBACK) {
        let report = &lines[begin + 1..];
        let Some(end) = report.iter().position(|line| !line.starts_with("  ")) else {
            return TRACEBACK.to_owned();
        };
        let is_frame = |line: &&&str| {
            !line.starts_with("   ") && !line.starts_with(NODE) && !line.starts_with(HELP)
        };
        let place = report[..end].iter().rfind(is_frame).map(|line| line.trim());
        let node = report[..end].iter().rfind(|line| line.starts_with(NODE));
        let mut text = reported(report[end]);
        let places = place.into_iter().chain(node.map(|line| line.trim()));
        let places = places.map(|place| language::told_in(language, place).into_owned());
        let places: Vec<String> = places.collect();
        if !places.is_empty() {
            let _ = write!(text, " ({})", places.join("; "));
        }
        return text;
    }
    match lines.last() {
        Some(last) if last.starts_with("SyntaxError: ") => {
            let place = lines
                .iter()
                .find_map(|line| line.trim_start().strip_prefix(ARROW));
            match place {
                Some(place) => format!("{} ({place})", reported(last)),
                None => reported(last),
            }
        }
        _ => reported(lines.first().copied().unwrap_or_default()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_report_is_told_by_what_happened_and_where() {
        let report = "Traceback (most recent call last):
  weld.script, line 9, column 1, in <module>
    main()
    ^^^^^^
  weld.script, line 4, column 7, in main
    a = 1 / 0
        ^^^^^
  in node 7 接近点
  help: divide by something else
ZeroDivisionError: division by zero
";
        let expected = "ZeroDivisionError: division by zero (weld.script, line 4, column 7, in main; in node 7 接近点)";
        assert_eq!(in_one_line(report, Language::English), expected);
        let chained = format!(
            "Traceback (most recent call last):\n  a, line 1, column 2, in f\nKeyError: 1\n\n\
             During handling of the above exception, another exception occurred:\n\n{report}"
        );
        assert_eq!(in_one_line(&chained, Language::English), expected);
        assert_eq!(
            in_one_line(report, Language::Chinese),
            "ZeroDivisionError: division by zero (main 中，weld.script 第 4 行第 7 列; 节点 7 接近点)"
        );
        let refused = "TypeError: movej(): q must be six joint positions in rad, not int (1)";
        assert_eq!(
            in_one_line(refused, Language::Chinese),
            "TypeError: movej(): q 必须是六个关节位置（rad），不能是 int（1）"
        );
    }

    #[test]
    fn other_messages_are_told_by_their_first_line_or_as_findings() {
        for (message, expected) in [
            ("", ""),
            (
                "protective stop: collision\nmore",
                "protective stop: collision",
            ),
            (
                "Traceback (most recent call last):\n  cut",
                "Traceback (most recent call last):",
            ),
            (
                "Traceback (most recent call last):\nValueError: x",
                "ValueError: x",
            ),
            (
                "error[syntax]: expected ':'\n --> pick.script:3:5\n  |\n3 | if x\n  |     ^\n\
                 SyntaxError: expected ':'",
                "SyntaxError: expected ':' (pick.script:3:5)",
            ),
            ("SyntaxError: no place", "SyntaxError: no place"),
        ] {
            assert_eq!(in_one_line(message, Language::English), expected);
        }
    }
}
