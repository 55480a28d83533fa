//! For GitHub's pages: an annotation at the line of each failure
//! (docs.github.com, "Workflow commands for GitHub Actions": `::error file=…,line=…,title=…::message`).

use super::repeat_command;
use crate::runner::{Status, TestResult};

/// The annotation of a test; nothing for one that passed.
pub fn annotation(result: &TestResult) -> String {
    if result.status == Status::Passed {
        return String::new();
    }
    let message = format!("{}\n{}", result.message, repeat_command(result));
    format!(
        "::error file={},line={},title={}::{}\n",
        property(&result.case.file.path.display().to_string()),
        result.line,
        property(&result.case.name),
        data(&message)
    )
}

fn data(text: &str) -> String {
    let text = text.replace('%', "%25");
    text.replace('\r', "%0D").replace('\n', "%0A")
}

fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}
