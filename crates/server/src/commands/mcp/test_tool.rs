//! The tool `test`: tests of programs, found and run as `eliteserver test` does.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::thread;
use std::time::{Duration, Instant};

use messages::Language;
use motion_api::Seconds;
use rmcp::schemars::JsonSchema;
use script_test::report::human;
use script_test::{FileScope, GoldenMode, Status, TestResult, TestRunOptions, discover_in, run};
use serde::Deserialize;
use serde_json::{Value as Json, json};

use super::server::shortened;
use super::tools::{ToolOutput, within};
use super::workspace::{CancelFlag, Workspace};
use crate::commands::test::{Settings, by_place, select};

/// Simulated time of a test, s: unless it is said, and at most.
const TIMEOUT: f64 = 60.0;
const TIMEOUT_MAX: f64 = 3600.0;
/// Time of the machine without simulated time passing.
const WALL_TIMEOUT: Duration = Duration::from_secs(10);
/// Paths of a call, and tests.
const PATHS_MAX: usize = 100;
const TESTS_MAX: usize = 2000;
/// Tests that are told one by one in the structured answer, and bytes of a report there.
const TOLD_MAX: usize = 500;
const REPORT_BYTES_MAX: usize = 8000;

/// Arguments of `test`.
#[derive(Debug, Default, Deserialize, JsonSchema)]
#[schemars(crate = "rmcp::schemars")]
#[serde(deny_unknown_fields)]
pub(super) struct TestArguments {
    /// Files and folders with tests (default the folder of the server)
    #[serde(default)]
    paths: Vec<String>,
    /// Only tests with this text in path or name; the exact name of a test selects it alone
    #[serde(default)]
    select: Option<String>,
    /// Simulated time after which a test has failed, s: up to 3600 (default 60)
    #[serde(default)]
    timeout: Option<f64>,
    /// Seed of everything random, and of the order of tests (default 0)
    #[serde(default)]
    seed: Option<u64>,
    /// Keep the ways of test.path_near anew instead of comparing with them (default false)
    #[serde(default)]
    update: bool,
    /// Folder for recordings of failed tests, for the replay tools
    #[serde(default)]
    record_failed: Option<String>,
}

pub(super) fn test(
    workspace: &Workspace,
    arguments: TestArguments,
    stop: &CancelFlag,
) -> Result<ToolOutput, String> {
    let timeout = within("timeout", arguments.timeout, TIMEOUT, 0.001, TIMEOUT_MAX)?;
    if arguments.paths.len() > PATHS_MAX {
        let count = arguments.paths.len();
        return Err(format!(
            "paths has {count} entries, at most {PATHS_MAX} are taken"
        ));
    }
    let mut paths: Vec<PathBuf> = Vec::new();
    for given in &arguments.paths {
        paths.push(workspace.path("paths", given)?);
    }
    if paths.is_empty() {
        paths.push(".".into());
    }
    let files = FileScope::beneath(workspace.folders().clone());
    let mut cases = discover_in(&paths, &files).map_err(|error| error.to_string())?;
    if let Some(text) = &arguments.select {
        select(&mut cases, text);
    }
    match cases.len() {
        0 => {
            return Err("there is no test: tests are functions test_… in files test_*.script or *_test.script, \
                        with select in their path or name"
                .to_owned());
        }
        1..=TESTS_MAX => {}
        count => {
            return Err(format!(
                "there are {count} tests, at most {TESTS_MAX} are run at once; name files, or select some"
            ));
        }
    }
    let mut settings = Settings::beneath(
        &cases,
        arguments.seed,
        workspace.folders(),
        workspace.root(),
    )
    .map_err(|refusal| refusal.to_string())?;
    settings.override_times(Seconds::new(timeout), Some(WALL_TIMEOUT));
    let record_failed = arguments.record_failed.as_deref();
    let options = TestRunOptions {
        jobs: thread::available_parallelism().unwrap_or(NonZeroUsize::MIN),
        seed: arguments.seed.unwrap_or(0),
        timeout: Seconds::new(timeout).unwrap_or_default(),
        wall_timeout: WALL_TIMEOUT,
        goldens: match arguments.update {
            true => GoldenMode::Update,
            false => GoldenMode::Compare,
        },
        counts_lines: false,
        record_failed: record_failed
            .map(|given| workspace.path("record_failed", given))
            .transpose()?,
        files,
        stop: stop.clone(),
    };
    let started = Instant::now();
    let mut results: Vec<TestResult> = Vec::new();
    run(&cases, &options, &|case| settings.of(case), &mut |result| {
        results.push(result)
    })
    .map_err(|error| format!("the tests cannot be run: {error}"))?;
    results.sort_by(by_place);
    let width = results
        .iter()
        .map(|result| result.case.name.chars().count())
        .max();
    let mut text = String::new();
    for result in &results {
        let width = width.unwrap_or(0);
        text.push_str(&human::line(result, width, Language::English));
    }
    let sum = human::summary(&results, started.elapsed(), Language::English);
    text.push_str(&sum);
    let passed = results
        .iter()
        .filter(|result| result.status == Status::Passed)
        .count();
    let told: Vec<Json> = results.iter().take(TOLD_MAX).map(row).collect();
    Ok(ToolOutput {
        text,
        structured: Some(json!({
            "passed": passed,
            "failed": results.len() - passed,
            "tests": told,
        })),
        png: None,
    })
}

fn row(result: &TestResult) -> Json {
    json!({
        "file": result.case.file.path.display().to_string(),
        "name": result.case.name,
        "status": result.status.as_str(),
        "line": result.line,
        "time": result.time,
        "message": shortened(result.message.to_string(), REPORT_BYTES_MAX),
        "report": shortened(result.report.to_string(), REPORT_BYTES_MAX),
        "prints": shortened(result.prints.join("\n"), REPORT_BYTES_MAX),
        "recording": result.recording.as_ref().map(|path| path.display().to_string()),
    })
}
