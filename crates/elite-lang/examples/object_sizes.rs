//! Bytes that objects take, ours beside CPython's: a list of many of one kind, by the memory account here and by
//! `tracemalloc` there, divided by their number, so with the place in the list. For docs/BENCHMARKS.md; needs `python3`
//! on the path.

use std::process::{Command, ExitCode};
use std::rc::Rc;

use elite_lang::{Host, Interpreter, Limits, Resume, ResumeOutcome, ThreadId};
use elite_syntax::{KnownNames, SourceFile, compile};

/// Objects of each kind.
const COUNT: usize = 2000;

/// What is measured, and the expression that makes number `i`.
const KINDS: &[(&str, &str)] = &[
    ("int", "i + 1000000"),
    ("float", "i * 0.5"),
    ("str of 9 characters", "'part %04d' % i"),
    ("str of 100 characters", "'part %095d' % i"),
    ("tuple of 2 ints", "(i + 1000, i + 2000)"),
    ("list of 10 ints", "[j + i * 10 + 1000 for j in range(10)]"),
    (
        "list of 100 ints",
        "[j + i * 100 + 1000 for j in range(100)]",
    ),
    ("list of 10 times the same", "[None] * 10"),
    (
        "dict of 5, str to int",
        "{'a': i + 1000, 'b': i + 2000, 'c': i + 3000, 'd': i + 4000, 'e': i + 5000}",
    ),
    (
        "dict of 100, int to float",
        "{j + i + 1000: j * 0.5 + i for j in range(100)}",
    ),
    (
        "set of 100 ints",
        "{j + i * 100 + 1000 for j in range(100)}",
    ),
    ("instance of 4 attributes", "P(i)"),
];

const CLASS: &str = "class P:\n    def __init__(self, i):\n        self.a = i + 1000\n        self.b = i * 0.5\
                     \n        self.c = i + 2000\n        self.d = i * 0.25\n";

struct Silent;

impl Host for Silent {
    fn print(&self, _: ThreadId, _: &str) {}
    fn unix_time(&self) -> f64 {
        0.0
    }
    fn monotonic(&self) -> f64 {
        0.0
    }
    fn random_u64(&self) -> u64 {
        0
    }
    fn wake(&self, _: ThreadId) {}
}

fn program(expression: &str) -> String {
    format!(
        "{CLASS}P(0)\ndef fill(keep):\n    for i in range({COUNT}):\n        keep[i] = {expression}\n\
         keep = [None] * {COUNT}\n"
    )
}

/// Bytes an object takes here; None if the program fails.
fn ours(expression: &str) -> Option<f64> {
    let text = format!("{}fill(keep)\n", program(expression));
    let bare = held_by(&program(expression))?;
    let full = held_by(&text)?;
    Some((full - bare) as f64 / COUNT as f64 + 16.0)
}

/// Bytes that an interpreter holds when a program has ended.
fn held_by(text: &str) -> Option<isize> {
    let before = task_memory::live_bytes();
    let program = compile(SourceFile::new("sizes", text), &KnownNames::default()).ok()?;
    let interpreter = Interpreter::new(Rc::new(Silent), Vec::new(), Limits::default());
    let mut thread = interpreter.spawn_program(&program);
    loop {
        match thread.resume(Resume::Continue, 1_000_000) {
            ResumeOutcome::Done(_) => return Some(task_memory::live_bytes() - before),
            ResumeOutcome::Failed(_) | ResumeOutcome::Stopped => return None,
            ResumeOutcome::OutOfFuel | ResumeOutcome::Parked { .. } | ResumeOutcome::Waiting(_) => {
            }
        }
    }
}

/// Bytes an object takes in CPython; None if there is none.
fn theirs(expression: &str) -> Option<f64> {
    let text = format!(
        "import tracemalloc\n{}tracemalloc.start()\nbefore = tracemalloc.get_traced_memory()[0]\nfill(keep)\n\
         print((tracemalloc.get_traced_memory()[0] - before) / {COUNT} + 8)\n",
        program(expression)
    );
    let output = Command::new("python3").args(["-c", &text]).output().ok()?;
    String::from_utf8(output.stdout).ok()?.trim().parse().ok()
}

fn main() -> ExitCode {
    println!(
        "{:<28} {:>8} {:>8} {:>7}",
        "bytes", "ours", "CPython", "ratio"
    );
    let mut worst: f64 = 0.0;
    for (name, expression) in KINDS {
        let Some(ours) = ours(expression) else {
            eprintln!("{name}: the program fails");
            return ExitCode::from(1);
        };
        match theirs(expression) {
            Some(theirs) => {
                worst = worst.max(ours / theirs);
                println!(
                    "{name:<28} {ours:>8.1} {theirs:>8.1} {:>7.2}",
                    ours / theirs
                );
            }
            None => println!("{name:<28} {ours:>8.1} {:>8} {:>7}", "-", "-"),
        }
    }
    println!("worst {worst:.2}");
    ExitCode::SUCCESS
}
