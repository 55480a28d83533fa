//! For programs: one JSON object a test and line.

use serde_json::json;

use super::repeat_command;
use crate::runner::TestResult;

/// The line of a test.
pub fn line(result: &TestResult) -> String {
    let object = json!({
        "name": result.case.name,
        "file": result.case.file.path.display().to_string(),
        "line": result.line,
        "outcome": result.status.as_str(),
        "message": result.message,
        "time": result.time,
        "seed": result.seed,
        "command": repeat_command(result),
    });
    format!("{object}\n")
}
