//! `eliteserver test`: which tests, with which settings, told how.

use std::cmp::Ordering;
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io::Write;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use controller::options::Permission;
use elite_runtime::SandboxRoots;
use messages::{Text, text};
use motion_api::Seconds;
use script_test::report::{github, human, json, junit, lcov};
use script_test::{
    FileScope, GoldenMode, Status, TestCase, TestResult, TestRunOptions, TestSettings,
    WALL_TIMEOUT, discover, run, usual_timeout,
};

use crate::cli::{TestArgs, TestFormat};
use crate::command::{CommandResult, CommandStatus};
use crate::config::robot_for_tests;
use crate::language;

/// The settings of the tests of a folder.
const SETTINGS: &str = "test.toml";

/// Exit status: 0 all passed, 1 some failed, 2 nothing to run.
pub fn test(args: &TestArgs) -> CommandResult {
    let all_passed = try_test(args)?;
    Ok(CommandStatus::of_answer(all_passed))
}

fn try_test(args: &TestArgs) -> Result<bool, Text> {
    let mut cases = discover(&args.paths).map_err(|error| Text::of(&error))?;
    if let Some(text) = &args.select {
        select(&mut cases, text);
    }
    if cases.is_empty() {
        return Err(match &args.select {
            Some(text) => text!(
                "no test has {text:?} in its path or name",
                "没有测试的路径或名称包含 {text:?}"
            ),
            None => text!(
                "there is no test: tests are functions test_… in files test_*.script or *_test.script",
                "没有测试：测试是文件 test_*.script 或 *_test.script 中名为 test_… 的函数"
            ),
        });
    }
    if args.list {
        for case in &cases {
            say(&format!("{}::{}\n", case.file.path.display(), case.name));
        }
        return Ok(true);
    }
    let mut settings = Settings::read(&cases, args.seed)?;
    settings.override_times(args.timeout, args.wall_timeout);
    let cores = thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
    let options = TestRunOptions {
        jobs: args.jobs.unwrap_or(cores),
        seed: args.seed.unwrap_or(0),
        timeout: args.timeout.unwrap_or_else(usual_timeout),
        wall_timeout: args.wall_timeout.unwrap_or(WALL_TIMEOUT),
        goldens: match args.update {
            true => GoldenMode::Update,
            false => GoldenMode::Compare,
        },
        counts_lines: args.coverage.is_some(),
        record_failed: args.record_failed.clone(),
        files: FileScope::default(),
        stop: Arc::default(),
    };
    let language = language::chosen();
    let width = cases.iter().map(|case| case.name.chars().count()).max();
    let (width, started) = (width.unwrap_or(0), Instant::now());
    let mut results: Vec<TestResult> = Vec::new();
    let counts = run(&cases, &options, &|case| settings.of(case), &mut |result| {
        match args.format {
            TestFormat::Json => say(&json::line(&result)),
            TestFormat::Human | TestFormat::Github => say(&human::line(&result, width, language)),
        }
        results.push(result);
    })
    .map_err(|error| text!("the tests cannot be run: {error}", "无法运行测试：{error}"))?;
    results.sort_by(by_place);
    match args.format {
        TestFormat::Json => {}
        TestFormat::Human => say(&human::summary(&results, started.elapsed(), language)),
        TestFormat::Github => {
            results
                .iter()
                .for_each(|result| say(&github::annotation(result)));
            say(&human::summary(&results, started.elapsed(), language));
        }
    }
    if let Some(path) = &args.junit {
        write(path, &junit::document(&results))?;
    }
    if let Some(path) = &args.coverage {
        write(path, &lcov::trace_file(&counts))?;
    }
    Ok(results.iter().all(|result| result.status == Status::Passed))
}

/// Orders results by path and line.
pub(crate) fn by_place(a: &TestResult, b: &TestResult) -> Ordering {
    let key = |result: &TestResult| (result.case.file.path.clone(), result.case.line);
    key(a).cmp(&key(b))
}

/// Keeps the tests whose path and name hold the text; those that are called exactly so alone, if there are any.
pub(crate) fn select(cases: &mut Vec<TestCase>, text: &str) {
    let is_exact = cases.iter().any(|case| case.name == text);
    cases.retain(|case| match is_exact {
        true => case.name == text,
        false => format!("{}::{}", case.file.path.display(), case.name).contains(text),
    });
}

/// What the tests of each folder are run with.
pub(crate) struct Settings(BTreeMap<PathBuf, TestSettings>);

impl Settings {
    fn read(cases: &[TestCase], seed: Option<u64>) -> Result<Self, Text> {
        Self::read_within(cases, seed, None)
    }

    /// The settings of tests that reach nothing but what is beneath a folder: `net` is what a test plays, `fs` that
    /// folder.
    ///
    /// # Errors
    /// A sentence: settings that are wrong, or that grant more.
    pub(crate) fn beneath(
        cases: &[TestCase],
        seed: Option<u64>,
        folders: &SandboxRoots,
        root: &Path,
    ) -> Result<Self, Text> {
        let mut all = Self::read_within(cases, seed, Some(folders))?;
        for (folder, settings) in &mut all.0 {
            let config = &mut settings.robot;
            let granted = std::mem::take(&mut config.allow);
            for permission in granted {
                let reduced = match permission {
                    Permission::Net | Permission::NetPlayed => Permission::NetPlayed,
                    Permission::Fs => Permission::FsIn(root.to_owned()),
                    Permission::FsIn(path) if path == root || path == Path::new(".") => {
                        Permission::FsIn(root.to_owned())
                    }
                    Permission::FsIn(_) | Permission::Process | Permission::Env => {
                        return Err(text!(
                            "the settings of the tests in {} allow more than there is here: of files fs, which is \
                             the folder that eliteserver mcp was started in, of machines those that a test plays",
                            "{} 中测试的设置允许的超出此处所有：文件只有 fs，即启动 eliteserver mcp 的文件夹，\
                             机器只有测试所扮演的",
                            folder.display()
                        ));
                    }
                };
                config.allow.insert(reduced);
            }
            // Other parts of a recording would have names of their own.
            (config.record_rotate, config.record_budget) = (None, None);
        }
        Ok(all)
    }

    fn read_within(
        cases: &[TestCase],
        seed: Option<u64>,
        within: Option<&SandboxRoots>,
    ) -> Result<Self, Text> {
        let mut known = BTreeMap::new();
        for case in cases {
            let folder = folder_of(case);
            if let Entry::Vacant(place) = known.entry(folder) {
                let file = settings_file(place.key(), &case.root);
                let config = robot_for_tests(file.as_deref(), seed, within);
                place.insert(config.map_err(|error| Text::of(&error))?);
            }
        }
        Ok(Self(known))
    }

    /// What was typed comes before what stands in a file.
    pub(crate) fn override_times(
        &mut self,
        timeout: Option<Seconds>,
        wall_timeout: Option<Duration>,
    ) {
        for settings in self.0.values_mut() {
            settings.timeout = timeout.or(settings.timeout);
            settings.wall_timeout = wall_timeout.or(settings.wall_timeout);
        }
    }

    pub(crate) fn of(&self, case: &TestCase) -> Result<TestSettings, Text> {
        let folder = folder_of(case);
        let config = self.0.get(&folder).cloned();
        config.ok_or_else(|| text!("{} has no settings", "{} 没有设置", folder.display()))
    }
}

fn folder_of(case: &TestCase) -> PathBuf {
    let folder = case.file.path.parent().unwrap_or(Path::new(""));
    folder.to_owned()
}

/// `test.toml` in the folder, or in the nearest one above it up to `root`.
fn settings_file(folder: &Path, root: &Path) -> Option<PathBuf> {
    let mut at = Some(folder);
    while let Some(folder) = at {
        let file = folder.join(SETTINGS);
        if file.is_file() {
            return Some(file);
        }
        if folder == root {
            return None;
        }
        at = folder.parent();
    }
    None
}

/// Whoever reads may have seen enough.
fn say(text: &str) {
    let mut out = std::io::stdout().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

fn write(path: &Path, text: &str) -> Result<(), Text> {
    std::fs::write(path, text).map_err(|error| {
        text!(
            "cannot write {}: {error}",
            "无法写入 {}：{error}",
            path.display()
        )
    })
}
