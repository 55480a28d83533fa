//! JUnit's XML, as servers that build read it: a suite a file, a case a test.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use super::repeat_command;
use crate::runner::{Status, TestResult};

/// The document.
pub fn document(results: &[TestResult]) -> String {
    let mut files: BTreeMap<String, Vec<&TestResult>> = BTreeMap::new();
    for result in results {
        let path = result.case.file.path.display().to_string();
        files.entry(path).or_default().push(result);
    }
    let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites");
    counts(&mut out, results.iter());
    out.push_str(">\n");
    for (path, mut results) in files {
        results.sort_by_key(|result| result.case.line);
        let _ = write!(out, "  <testsuite name=\"{}\"", escape(&path));
        counts(&mut out, results.iter().copied());
        out.push_str(">\n");
        for result in results {
            case(&mut out, &path, result);
        }
        out.push_str("  </testsuite>\n");
    }
    out.push_str("</testsuites>\n");
    out
}

fn counts<'r>(out: &mut String, results: impl Iterator<Item = &'r TestResult> + Clone) {
    let count = |status| results.clone().filter(|r| r.status == status).count();
    let wall: f64 = results.clone().map(|r| r.wall.as_secs_f64()).sum();
    let (failures, errors) = (count(Status::Failed), count(Status::Error));
    let _ = write!(
        out,
        " tests=\"{}\" failures=\"{failures}\" errors=\"{errors}\" time=\"{wall:.6}\"",
        results.count()
    );
}

fn case(out: &mut String, path: &str, result: &TestResult) {
    let _ = write!(
        out,
        "    <testcase classname=\"{}\" name=\"{}\" file=\"{}\" line=\"{}\" time=\"{:.6}\"",
        escape(path),
        escape(&result.case.name),
        escape(path),
        result.line,
        result.wall.as_secs_f64()
    );
    let element = match result.status {
        Status::Passed => None,
        Status::Failed => Some("failure"),
        Status::Error => Some("error"),
    };
    let Some(element) = element else {
        out.push_str("/>\n");
        return;
    };
    let text = format!("{}\n{}", result.report, repeat_command(result));
    let _ = writeln!(
        out,
        ">\n      <{element} message=\"{}\">{}</{element}>",
        escape(result.message.english()),
        escape(&text)
    );
    if !result.prints.is_empty() {
        let text = escape(&result.prints.join("\n"));
        let _ = writeln!(out, "      <system-out>{text}</system-out>");
    }
    out.push_str("    </testcase>\n");
}

/// Text for an attribute or an element; what XML 1.0 cannot hold becomes a question mark.
fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\n' => out.push_str("&#10;"),
            '\t' => out.push_str("&#9;"),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => out.push('?'),
            c => out.push(c),
        }
    }
    out
}
