//! Runs several tests at once, in an order that follows from the seed.

use std::collections::BTreeMap;
use std::io;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, mpsc};
use std::time::Duration;

use controller::ControllerConfig;
use elite_runtime::LineCountsByText;
use messages::{Text, text};
use motion_api::Seconds;
use supervision::{ThreadRole, ThreadSupervisor, catch};

use crate::discover::TestCase;
use crate::files::FileScope;
use crate::golden_path::GoldenMode;
use crate::runner::{self, Status, TestPlan, TestResult};

/// How tests are run.
#[derive(Clone, Debug)]
pub struct TestRunOptions {
    /// Number of tests that run at once.
    pub jobs: NonZeroUsize,
    /// Seed that the order of the tests follows from.
    pub seed: u64,
    /// Simulated time of a test.
    pub timeout: Seconds,
    /// Time of the machine without simulated time passing, after which a test is given up.
    pub wall_timeout: Duration,
    /// Compare with what was kept, or keep anew.
    pub goldens: GoldenMode,
    /// Count executed lines of the programs under test.
    pub counts_lines: bool,
    /// Folder for the recordings of failed tests.
    pub record_failed: Option<PathBuf>,
    /// What tests may consist of.
    pub files: FileScope,
    /// Set by whoever does not wait for the results any more: no further test is begun, those that run are given up.
    pub stop: Arc<AtomicBool>,
}

/// What one test is run with.
#[derive(Clone, Debug)]
pub struct TestSettings {
    /// The robot.
    pub robot: ControllerConfig,
    /// Simulated time of the test, in place of that of all.
    pub timeout: Option<Seconds>,
    /// Time of the machine without simulated time passing, in place of that of all.
    pub wall_timeout: Option<Duration>,
}

impl From<ControllerConfig> for TestSettings {
    /// With the times of all.
    fn from(robot: ControllerConfig) -> Self {
        Self {
            robot,
            timeout: None,
            wall_timeout: None,
        }
    }
}

/// Runs tests; `tell` hears of each when it has ended. `settings` says what each is run with; a sentence where there is
/// no such setting. The executed lines, if they are counted.
///
/// # Errors
/// The operating system gave no thread or no folder.
pub fn run(
    cases: &[TestCase],
    options: &TestRunOptions,
    settings: &dyn Fn(&TestCase) -> Result<TestSettings, Text>,
    tell: &mut dyn FnMut(TestResult),
) -> io::Result<LineCountsByText> {
    if let Some(folder) = &options.record_failed {
        options.files.make_folder(folder)?;
    }
    let counts = options.counts_lines.then(Arc::<Mutex<_>>::default);
    let mut planned = Vec::new();
    let mut taken = BTreeMap::new();
    for case in cases {
        let plan = settings(case).map(|settings| TestPlan {
            config: settings.robot,
            files: options.files.clone(),
            goldens: options.goldens,
            stop: options.stop.clone(),
            timeout: settings.timeout.unwrap_or(options.timeout),
            wall_timeout: settings.wall_timeout.unwrap_or(options.wall_timeout),
            counts: counts.clone(),
            recording: options
                .record_failed
                .as_deref()
                .map(|folder| recording_path(folder, case, &mut taken)),
        });
        planned.push((case.clone(), plan));
    }
    shuffle(&mut planned, options.seed);
    let planned: Arc<[_]> = planned.into();
    let next = Arc::new(AtomicUsize::new(0));
    let (results, inbox) = mpsc::channel();
    let jobs = options.jobs.get().min(planned.len().max(1));
    let faults = ThreadSupervisor::default();
    let mut workers = Vec::new();
    for number in 0..jobs {
        let (planned, next, results) = (planned.clone(), next.clone(), results.clone());
        let stop = options.stop.clone();
        let work = move || {
            while let Some((case, plan)) = planned.get(next.fetch_add(1, Ordering::Relaxed)) {
                if stop.load(Ordering::Relaxed) {
                    return;
                }
                let result = match plan {
                    Ok(plan) => run_isolated(case, plan),
                    Err(sentence) => not_run(case, sentence.clone()),
                };
                if results.send(result).is_err() {
                    return;
                }
            }
        };
        workers.push(faults.start(ThreadRole::Service, format!("tests-{number}"), work)?);
    }
    drop(results);
    for result in inbox {
        tell(result);
    }
    for worker in workers {
        // A fault of ours was told as the error of its test.
        let _ = worker.join();
    }
    let counts = counts.map(|counts| {
        let mut counts = counts
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        std::mem::take(&mut *counts)
    });
    Ok(counts.unwrap_or_default())
}

/// A fault of ours is the error of the test, and not the end of the others.
fn run_isolated(case: &TestCase, plan: &TestPlan) -> TestResult {
    catch(|| runner::run(case, plan)).unwrap_or_else(|panicked| {
        let what = text!(
            "a fault of the controller: {}",
            "控制器的缺陷：{}",
            panicked.message
        );
        not_run(case, what)
    })
}

fn not_run(case: &TestCase, sentence: Text) -> TestResult {
    TestResult {
        case: case.clone(),
        status: Status::Error,
        report: sentence.clone(),
        message: sentence,
        line: case.line,
        time: 0.0,
        wall: Duration::ZERO,
        seed: 0,
        timeout: None,
        wall_timeout: None,
        prints: Vec::new(),
        recording: None,
    }
}

/// A file for the recording of a test, named after it.
fn recording_path(folder: &Path, case: &TestCase, taken: &mut BTreeMap<String, usize>) -> PathBuf {
    let stem = case.file.path.file_stem().unwrap_or_default();
    let name = format!("{}-{}", stem.to_string_lossy(), case.name);
    let count = taken.entry(name.clone()).or_insert(0);
    *count += 1;
    // Files of the same name in several folders.
    match *count {
        1 => folder.join(format!("{name}.mcap")),
        number => folder.join(format!("{name}-{number}.mcap")),
    }
}

/// Fisher and Yates, with the numbers of SplitMix64.
fn shuffle<T>(items: &mut [T], seed: u64) {
    let mut state = seed;
    for last in (1..items.len()).rev() {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let drawn = (z ^ (z >> 31)) % (last as u64 + 1);
        items.swap(last, drawn as usize);
    }
}
