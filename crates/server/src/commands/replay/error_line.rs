//! The report of an error in one line: `Type: message`, the place, and the node of the pendant's task.
//!
//! Owns how the reports of `elite_lang::render_script_error` and `render_human` are read back from a recording.
//! Messages of another form are told by their first line.

use messages::{Language, Text, text};

/// Begins the call stack of a report.
const TRACEBACK: &str = "Traceback (most recent call last):";
/// Begins the line that names the node.
const NODE: &str = "  in node ";
/// Begins the line with advice.
const HELP: &str = "  help: ";
/// Begins the place of a finding in a text that does not compile.
const ARROW: &str = "--> ";

/// What happened and where. The place is read from the English form, in which reports are always written alike.
pub(super) fn in_one_line(message: &Text, language: Language) -> String {
    let told: Vec<&str> = message.in_language(language).lines().collect();
    let lines: Vec<&str> = message.english().lines().collect();
    let with_place = |what: &str, place: &Text| match place.is_empty() {
        true => what.to_owned(),
        false => text!("{what} ({place})", "{what}（{place}）")
            .in_language(language)
            .to_owned(),
    };
    if let Some((frames, _)) = raised(&lines) {
        let Some((_, what)) = raised(&told).filter(|(_, what)| !what.is_empty()) else {
            return TRACEBACK.to_owned();
        };
        let is_frame = |line: &&&str| {
            !line.starts_with("   ") && !line.starts_with(NODE) && !line.starts_with(HELP)
        };
        let frame = frames
            .iter()
            .rfind(is_frame)
            .map(|line| frame_text(line.trim()));
        let node = frames.iter().rfind(|line| line.starts_with(NODE));
        let node = node.map(|line| node_text(line));
        let places = Text::joined(frame.into_iter().chain(node), "; ", "；");
        return with_place(what, &places);
    }
    match (lines.last(), told.last()) {
        (Some(last), Some(told)) if last.starts_with("SyntaxError: ") => {
            let place = lines
                .iter()
                .find_map(|line| line.trim_start().strip_prefix(ARROW));
            with_place(told, &Text::verbatim(place.unwrap_or_default().to_owned()))
        }
        _ => told.first().copied().unwrap_or_default().to_owned(),
    }
}

/// The lines of the call stack in a report and what was raised, which is empty where the report is cut. An exception
/// that came from another one is reported behind it.
fn raised<'l>(lines: &'l [&'l str]) -> Option<(&'l [&'l str], &'l str)> {
    let begin = lines.iter().rposition(|line| *line == TRACEBACK)? + 1;
    let report = &lines[begin..];
    let end = report.iter().position(|line| !line.starts_with("  "));
    Some((
        &report[..end.unwrap_or(report.len())],
        end.map_or("", |end| report[end]),
    ))
}

/// The place of a level of the call stack, which reports write as `FILE, line LINE, column COLUMN, in FUNCTION`.
fn frame_text(line: &str) -> Text {
    let parts = || {
        let (rest, function) = line.rsplit_once(", in ")?;
        let (rest, column) = rest.rsplit_once(", column ")?;
        let (file, number) = rest.rsplit_once(", line ")?;
        Some((file, number, column, function))
    };
    match parts() {
        Some((file, number, column, function)) => text!(
            "{file}, line {number}, column {column}, in {function}",
            "{function} 中，{file} 第 {number} 行第 {column} 列"
        ),
        None => Text::verbatim(line.to_owned()),
    }
}

/// A node of the pendant's task, which reports write as `in node NODE`.
fn node_text(line: &str) -> Text {
    match line.strip_prefix(NODE) {
        Some(node) => text!("in node {node}", "节点 {node}"),
        None => Text::verbatim(line.to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn english(message: &str) -> Text {
        Text::verbatim(message.to_owned())
    }

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
        assert_eq!(in_one_line(&english(report), Language::English), expected);
        let chained = format!(
            "Traceback (most recent call last):\n  a, line 1, column 2, in f\nKeyError: 1\n\n\
             During handling of the above exception, another exception occurred:\n\n{report}"
        );
        assert_eq!(in_one_line(&english(&chained), Language::English), expected);
        assert_eq!(
            in_one_line(&english(report), Language::Chinese),
            "ZeroDivisionError: division by zero（main 中，weld.script 第 4 行第 7 列；节点 7 接近点）"
        );
        let chinese = report
            .replace("in node 7", "位于节点 7")
            .replace("division by zero", "除以零");
        assert_eq!(
            in_one_line(&Text::new(report.to_owned(), chinese), Language::Chinese),
            "ZeroDivisionError: 除以零（main 中，weld.script 第 4 行第 7 列；节点 7 接近点）"
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
            assert_eq!(in_one_line(&english(message), Language::English), expected);
        }
    }
}
