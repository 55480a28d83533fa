//! Fills a task's memory with one kind of object after the other, each in a task of its own, and prints what the system
//! says of the process: the most it held and what it holds afterwards. For docs/BENCHMARKS.md; give the limit in MiB.

#[path = "../tests/support/shapes.rs"]
mod shapes;

use std::process::ExitCode;
use std::rc::Rc;
use std::time::Instant;

use elite_lang::{Host, Interpreter, Limits, Resume, ResumeOutcome, ThreadId};
use elite_syntax::{KnownNames, SourceFile, compile};
use shapes::{SHAPES, forget_peak, of_process, program};

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

/// How a program ended that may hold `limit` bytes.
fn run(text: String, limit: usize) -> String {
    let Ok(program) = compile(SourceFile::new("fill", text), &KnownNames::default()) else {
        return "does not compile".into();
    };
    let limits = Limits {
        memory_bytes: limit,
        ..Limits::default()
    };
    let interpreter = Interpreter::new(Rc::new(Silent), Vec::new(), limits);
    let mut thread = interpreter.spawn_program(&program);
    loop {
        match thread.resume(Resume::Continue, 100_000) {
            ResumeOutcome::OutOfFuel => {}
            ResumeOutcome::Done(_) => return "ended".into(),
            other => return format!("{other:?}"),
        }
    }
}

fn main() -> ExitCode {
    let limit = std::env::args().nth(1).and_then(|text| text.parse().ok());
    let Some(limit) = limit.map(|mebibytes: usize| mebibytes << 20) else {
        eprintln!("usage: fill MEBIBYTES");
        return ExitCode::from(2);
    };
    let base = of_process("VmRSS");
    println!(
        "{:<32} {:>9} {:>9} {:>8}",
        "filled with", "most MiB", "then MiB", "seconds"
    );
    let mut most = 0;
    for (name, statement) in SHAPES {
        forget_peak();
        let begin = Instant::now();
        let text = program(statement);
        let how = std::thread::spawn(move || run(text, limit)).join();
        let (peak, after) = (of_process("VmHWM"), of_process("VmRSS"));
        most = most.max(peak);
        let note = match how {
            Ok(how) if how == "ended" => String::new(),
            other => format!("  {other:?}"),
        };
        println!(
            "{name:<32} {:>9} {:>9} {:>8.1}{note}",
            peak >> 20,
            after >> 20,
            begin.elapsed().as_secs_f64()
        );
    }
    println!(
        "at most {} MiB, {} MiB before the first",
        most >> 20,
        base >> 20
    );
    ExitCode::from(u8::from(most > base + limit + limit / 4))
}
