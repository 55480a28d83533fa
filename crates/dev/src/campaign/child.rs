//! Inside the child: case after case, the number of each in a file before it begins, so that whoever finds the child
//! dead or silent knows where it was.

use std::cell::RefCell;
use std::fs::File;
use std::io;
use std::os::unix::fs::FileExt as _;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::path::Path;
use std::time::{Duration, Instant};

use nix::sys::resource::{Resource, setrlimit};

use crate::targets::Target;

/// Address space of a child. A program is limited to 16 MiB; the rest is stacks and what is mapped anyway.
const ADDRESS_SPACE: u64 = 3 << 30;

/// A selection of cases for a child to run.
pub struct Case<'a> {
    /// Target that the cases are for.
    pub target: &'static Target,
    /// Seed of the campaign.
    pub seed: u64,
    /// Number of the first case.
    pub from: u64,
    /// Most cases.
    pub count: u64,
    /// Longest time of the whole run.
    pub time: Duration,
    /// File that the number of the current case is written to.
    pub progress: &'a Path,
}

thread_local! {
    static PLACE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Limits what this process may take, so that an input that eats the machine is a death like any other.
pub fn limit_resources() {
    // One that cannot be limited still tells what it finds.
    let _ = setrlimit(Resource::RLIMIT_AS, ADDRESS_SPACE, ADDRESS_SPACE);
    let _ = setrlimit(Resource::RLIMIT_CORE, 0, 0);
}

/// Runs cases; a line for each that breaks a promise, and one at the end with how many there were.
///
/// # Errors
/// If the file of the progress cannot be written.
pub fn run_cases(case: &Case<'_>) -> io::Result<()> {
    limit_resources();
    set_hook(Box::new(|info| {
        let place = info
            .location()
            .map(|at| format!("{}:{}", at.file(), at.line()));
        let text = info.payload_as_str().unwrap_or("a panic without a text");
        let text: String = text
            .chars()
            .take(300)
            .map(|c| if c.is_control() { ' ' } else { c })
            .collect();
        PLACE.with_borrow_mut(|found| *found = format!("{}: {text}", place.unwrap_or_default()));
    }));
    let progress = File::options()
        .write(true)
        .create(true)
        .truncate(false)
        .open(case.progress)?;
    let seeds = (case.target.seeds)();
    // A generator asks the language for its names before the first program; that is not the time of any case.
    let _ = case.target.input(&seeds, case.seed, case.from);
    let begin = Instant::now();
    let mut number = case.from;
    while number - case.from < case.count && begin.elapsed() < case.time {
        progress.write_all_at(&number.to_le_bytes(), 0)?;
        let input = case.target.input(&seeds, case.seed, number);
        if catch_unwind(AssertUnwindSafe(|| (case.target.check)(&input))).is_err() {
            let place = PLACE.take();
            say(&format!("found {number} {place}"))?;
        }
        number += 1;
    }
    say(&format!("done {number}"))
}

fn say(line: &str) -> io::Result<()> {
    use io::Write as _;
    let mut out = io::stdout().lock();
    writeln!(out, "{line}")?;
    out.flush()
}
