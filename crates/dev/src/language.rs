//! What must hold for any program text: it is checked to an end, every finding can be shown, and what runs can be
//! stopped, stays within its memory and gives everything back.

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::time::Duration;

use elite_lang::{
    Host, Interpreter, Limits, Resume, ResumeOutcome, ScriptThread, ThreadId, render_script_error,
};
use elite_syntax::{KnownNames, SourceFile, check, compile, render_human};
use messages::Language;
use nix::time::{ClockId, clock_gettime};

/// Threads a program may have at once.
const THREADS_MAX: usize = 16;

/// Safepoints between two looks at the clock.
const FUEL: u32 = 1000;

/// Bytes of a program's output that are kept.
const OUTPUT_MAX: usize = 1 << 16;
/// Turns a program gets.
const TURNS: usize = 60;

/// A host without surroundings: time passes only when every thread waits.
#[derive(Default)]
struct IsolatedHost {
    output: RefCell<String>,
    now: Cell<f64>,
    numbers: Cell<u64>,
    started: RefCell<Vec<ScriptThread>>,
    threads: Cell<usize>,
}

impl Host for IsolatedHost {
    fn print(&self, _: ThreadId, text: &str) {
        let mut output = self.output.borrow_mut();
        let room = OUTPUT_MAX.saturating_sub(output.len());
        output.push_str(&text[..text.floor_char_boundary(room)]);
    }

    fn unix_time(&self) -> f64 {
        1_767_225_600.0 + self.now.get()
    }

    fn monotonic(&self) -> f64 {
        self.now.get()
    }

    fn random_u64(&self) -> u64 {
        self.numbers.set(self.numbers.get() + 1);
        self.numbers.get()
    }

    fn start(&self, thread: ScriptThread) -> Result<(), String> {
        if self.threads.get() >= THREADS_MAX {
            return Err("too many threads".to_owned());
        }
        self.threads.set(self.threads.get() + 1);
        self.started.borrow_mut().push(thread);
        Ok(())
    }

    fn wake(&self, _: ThreadId) {}
}

/// What a program printed, which must compile and run to its end.
pub(crate) fn output_of(text: &str) -> String {
    let Ok(program) = compile(
        SourceFile::new("names.script", text),
        &KnownNames::default(),
    ) else {
        return String::new();
    };
    let host = Rc::new(IsolatedHost::default());
    let interpreter = Interpreter::new(host.clone(), Vec::new(), Limits::default());
    let mut thread = interpreter.spawn_program(&program);
    while let ResumeOutcome::OutOfFuel = thread.resume(Resume::Continue, 100_000) {}
    host.output.take()
}

/// Checks any text and shows what was found.
pub fn check_diagnostics(text: String) {
    let file = SourceFile::new("fuzz.script", text);
    let known = KnownNames::new(["movej", "get_actual_joint_positions"]);
    let found = check(file.clone(), &known);
    for finding in found.iter().take(20) {
        let fields = finding.fields(&file);
        assert!(
            fields.line >= 1 && fields.line <= file.line_count() + 1,
            "{fields:?}"
        );
        assert!(!render_human(finding, &file, Language::English, false).is_empty());
    }
}

/// Checking the same text twice finds the same.
pub fn check_determinism(text: String) {
    let file = SourceFile::new("fuzz.script", text);
    let first = check(file.clone(), &KnownNames::default());
    let second = check(file, &KnownNames::default());
    assert_eq!(first, second);
}

/// How a program ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrialOutcome {
    /// The program does not compile.
    Refused,
    /// The program came to its end.
    Done,
    /// An exception ended the program.
    Failed,
    /// The program was still running at the end of its time, and was stopped.
    Stopped,
}

/// Processor time of this thread.
fn thread_cpu_time() -> Duration {
    clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID)
        .map(Duration::from)
        .unwrap_or_default()
}

/// Memory of a task here, and what it and its own machinery may really take: the contract says a quarter more, and a
/// thread's stacks, the library's modules and the tree of the text count from zero.
const MEMORY: usize = 16 << 20;
const MEMORY_HELD_MAX: isize = (MEMORY + MEMORY / 4 + (4 << 20)) as isize;

/// What may stay when everything is dropped: tables that are made once in a process.
const LEFT_MAX: isize = 2 << 20;

/// Runs a program with little fuel and its threads in turn, and stops what still runs.
///
/// # Panics
/// If something that must hold does not.
pub fn check_execution(text: String) -> TrialOutcome {
    let before = task_memory::live_bytes();
    let outcome = run(text, before);
    let left = task_memory::live_bytes() - before;
    assert!(left < LEFT_MAX, "LEAK: {left} bytes are held after the end");
    outcome
}

fn run(text: String, before: isize) -> TrialOutcome {
    let file = SourceFile::new("fuzz.script", text);
    let Ok(program) = compile(file, &KnownNames::default()) else {
        return TrialOutcome::Refused;
    };
    let limits = Limits {
        memory_bytes: MEMORY,
        stop_fuel: 200,
        ..Limits::default()
    };
    let host = Rc::new(IsolatedHost::default());
    let interpreter = Interpreter::new(host.clone(), Vec::new(), limits);
    let mut threads = vec![interpreter.spawn_program(&program)];
    let mut outcome = TrialOutcome::Stopped;
    let begin = thread_cpu_time();
    for _ in 0..TURNS {
        let mut waiting = 0;
        let mut index = 0;
        while index < threads.len() {
            let step = timed(|| threads[index].resume(Resume::Continue, FUEL));
            match step {
                ResumeOutcome::OutOfFuel => index += 1,
                ResumeOutcome::Parked { .. } | ResumeOutcome::Waiting(_) => {
                    waiting += 1;
                    index += 1;
                }
                ended => {
                    if let ResumeOutcome::Failed(error) = &ended {
                        let report = timed(|| render_script_error(error));
                        assert!(
                            !report.english().contains("AssertionError: BROKEN"),
                            "{report}"
                        );
                    }
                    if index == 0 {
                        outcome = match ended {
                            ResumeOutcome::Failed(_) => TrialOutcome::Failed,
                            _ => TrialOutcome::Done,
                        };
                    }
                    drop(threads.remove(index));
                    host.threads.set(threads.len());
                    if index == 0 {
                        // The main program has ended: the rest is stopped below.
                        return stopped(threads, &host, outcome);
                    }
                }
            }
        }
        let held = task_memory::live_bytes() - before;
        assert!(held < MEMORY_HELD_MAX, "MEMORY: {held} bytes are held");
        threads.extend(host.started.take());
        if waiting == threads.len() {
            host.now.set(host.now.get() + 0.01);
        }
        // A program that is busy for long is not looked at for longer.
        if thread_cpu_time().saturating_sub(begin) > Duration::from_millis(100) {
            break;
        }
    }
    stopped(threads, &host, outcome)
}

/// Stops threads: each is gone after one more call.
fn stopped(
    mut threads: Vec<ScriptThread>,
    host: &IsolatedHost,
    outcome: TrialOutcome,
) -> TrialOutcome {
    threads.extend(host.started.take());
    for mut thread in threads {
        let end = timed(|| thread.resume(Resume::Stop, 0));
        let ended = matches!(
            end,
            ResumeOutcome::Stopped | ResumeOutcome::Done(_) | ResumeOutcome::Failed(_)
        );
        assert!(ended && thread.is_ended(), "a stopped thread says {end:?}");
    }
    outcome
}

/// Longest time between two safepoints, many times over: what is found here is not a machine that is busy.
const STRETCH_MAX: Duration = Duration::from_millis(if cfg!(debug_assertions) {
    20_000
} else {
    3_000
});

/// Calls something that must not take long.
fn timed<T>(call: impl FnOnce() -> T) -> T {
    let begin = thread_cpu_time();
    let result = call();
    let took = thread_cpu_time().saturating_sub(begin);
    assert!(
        took < STRETCH_MAX,
        "SLOW: {} ms of processor time without a pause",
        took.as_millis()
    );
    result
}
