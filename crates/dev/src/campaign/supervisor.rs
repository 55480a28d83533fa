//! Outside the child: starts it, sees it panic, die or fall silent, starts the next one behind the case that did it.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, BufRead as _, BufReader, Read as _};
use std::os::unix::process::ExitStatusExt as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// A case that takes longer has hung. Machines that run tests are busy, so this is long.
const SILENCE_MAX: Duration = Duration::from_secs(if cfg!(debug_assertions) { 60 } else { 30 });

/// Deaths after which a target is given up: each costs the start of a process.
const CRASHES_MAX: usize = 500;

/// What one defect looks like from outside, and where it was seen.
#[derive(Clone, Debug)]
pub struct Defect {
    /// Number of times that the defect was found.
    pub times: u64,
    /// The number of the first case.
    pub number: u64,
}

/// What became of one target.
#[derive(Clone, Debug)]
pub struct TargetReport {
    /// The target.
    pub name: String,
    /// Cases that ran.
    pub cases: u64,
    /// Time that the cases ran.
    pub time: Duration,
    /// Defects by what they look like.
    pub found: BTreeMap<String, Defect>,
}

/// Runs cases of one target for this long.
///
/// # Errors
/// If a child cannot be started.
pub fn run_target(
    name: &str,
    seed: u64,
    from: u64,
    count: u64,
    time: Duration,
) -> io::Result<TargetReport> {
    let mut report = TargetReport {
        name: name.to_owned(),
        cases: 0,
        time: Duration::ZERO,
        found: BTreeMap::new(),
    };
    let progress = std::env::temp_dir().join(format!("campaign-{}-{name}", std::process::id()));
    let begin = Instant::now();
    let (mut next, mut deaths) = (from, 0);
    while next - from < count && begin.elapsed() < time && deaths < CRASHES_MAX {
        fs::write(&progress, next.to_le_bytes())?;
        let left = time.saturating_sub(begin.elapsed());
        let mut child = spawn_child(name, seed, next, count - (next - from), left, &progress)?;
        let death = followed(&mut child, &progress, &mut report)?;
        let at = number_in(&progress).max(next);
        match death {
            None => next = at + 1,
            Some(death) => {
                deaths += 1;
                note(&mut report, &death, at);
                next = at + 1;
            }
        }
    }
    let _ = fs::remove_file(&progress);
    report.cases = next - from;
    report.time = begin.elapsed();
    Ok(report)
}

fn spawn_child(
    name: &str,
    seed: u64,
    from: u64,
    count: u64,
    time: Duration,
    progress: &Path,
) -> io::Result<Child> {
    let program: PathBuf = std::env::current_exe()?;
    let mut command = Command::new(program);
    command.args([
        "cases",
        name,
        "--seed",
        &seed.to_string(),
        "--from",
        &from.to_string(),
        "--count",
        &count.to_string(),
    ]);
    command
        .args(["--seconds", &time.as_secs_f64().to_string(), "--progress"])
        .arg(progress);
    command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    // The place of a panic is enough; walking the stack of each would take most of the time.
    command.env("RUST_BACKTRACE", "0");
    command.spawn()
}

#[allow(
    clippy::disallowed_methods,
    reason = "no threads of the controller: they end with the child they read from, and are joined"
)]
/// Waits for the end of a child; how it died, if it did.
fn followed(
    child: &mut Child,
    progress: &Path,
    report: &mut TargetReport,
) -> io::Result<Option<String>> {
    let (lines, heard) = mpsc::channel();
    let output = child.stdout.take().map(BufReader::new);
    let reading = std::thread::spawn(move || {
        for line in output
            .into_iter()
            .flat_map(BufReader::lines)
            .map_while(Result::ok)
        {
            if lines.send(line).is_err() {
                break;
            }
        }
    });
    let errors = child.stderr.take();
    let complaints = std::thread::spawn(move || {
        let mut text = Vec::new();
        if let Some(errors) = errors {
            let _ = errors.take(1 << 20).read_to_end(&mut text);
        }
        String::from_utf8_lossy(&text).into_owned()
    });
    let (mut last, mut since) = (number_in(progress), Instant::now());
    let mut has_hung = false;
    loop {
        match heard.recv_timeout(Duration::from_millis(200)) {
            Ok(line) => {
                if let Some((number, place)) = line
                    .strip_prefix("found ")
                    .and_then(|rest| rest.split_once(' '))
                {
                    note(report, place, number.parse().unwrap_or(0));
                }
                continue;
            }
            Err(mpsc::RecvTimeoutError::Disconnected) => break,
            Err(mpsc::RecvTimeoutError::Timeout) => {}
        }
        let now = number_in(progress);
        if now != last {
            (last, since) = (now, Instant::now());
        } else if since.elapsed() > SILENCE_MAX {
            has_hung = true;
            child.kill()?;
        }
    }
    let status = child.wait()?;
    let _ = reading.join();
    let said = complaints.join().unwrap_or_default();
    Ok(match status.signal() {
        _ if has_hung => Some("HANG: no end".to_owned()),
        Some(signal) => {
            let line = said
                .lines()
                .rev()
                .find(|line| line.contains("memory allocation") || line.contains("overflow"));
            let words = line.map_or(String::new(), |line| {
                line.chars().filter(|c| !c.is_ascii_digit()).collect()
            });
            Some(format!("DEATH: signal {signal} {words}"))
        }
        None if status.success() => None,
        None => Some(format!(
            "DEATH: status {:?} {}",
            status.code(),
            said.lines().last().unwrap_or("")
        )),
    })
}

fn number_in(progress: &Path) -> u64 {
    let bytes = fs::read(progress).unwrap_or_default();
    bytes.try_into().map_or(0, u64::from_le_bytes)
}

fn note(report: &mut TargetReport, what: &str, number: u64) {
    // Values in a message differ from case to case; the place does not.
    let kind = match what.split_once(": ") {
        Some((place, text)) if !place.is_empty() => {
            let text: String = text
                .chars()
                .filter(|c| !c.is_ascii_digit())
                .take(100)
                .collect();
            format!("{place}: {text}")
        }
        _ => what.to_owned(),
    };
    let found = report
        .found
        .entry(kind)
        .or_insert(Defect { times: 0, number });
    found.times += 1;
}
