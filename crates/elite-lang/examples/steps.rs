//! How long the driver of a script thread waits at most: the slowest step of a program that makes ever more cyclic
//! objects, and a stop in the midst of it. `steps 1000000` makes a million.

use std::rc::Rc;
use std::time::Duration;

use elite_lang::{Host, Interpreter, Limits, Resume, ResumeOutcome, ThreadId};
use elite_syntax::{KnownNames, SourceFile, compile};
use nix::time::{ClockId, clock_gettime};

struct Silent;

/// Time of the processor that this thread has had: other work on the machine does not count.
fn now() -> Duration {
    clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID).map_or(Duration::ZERO, Duration::from)
}

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

fn main() {
    let objects: usize = std::env::args()
        .nth(1)
        .and_then(|count| count.parse().ok())
        .unwrap_or(100_000);
    let text = format!(
        "class Node:\n    pass\nkept = []\ni = 0\nwhile True:\n    a = Node(); a.me = a; i += 1\n    if i < {objects}: \
         kept.append(a)\n"
    );
    let Ok(program) = compile(SourceFile::new("steps", text), &KnownNames::default()) else {
        return eprintln!("the program does not compile");
    };
    let limits = Limits {
        memory_bytes: 4 << 30,
        ..Limits::default()
    };
    let interpreter = Interpreter::new(Rc::new(Silent), Vec::new(), limits);
    let mut thread = interpreter.spawn_program(&program);
    let mut steps: Vec<Duration> = Vec::new();
    let begin = now();
    // Until every object has been there for some searches.
    while interpreter
        .global("i")
        .and_then(|i| i.as_i64())
        .unwrap_or(0)
        < 3 * objects as i64
    {
        let step = now();
        if !matches!(
            thread.resume(Resume::Continue, 1_000),
            ResumeOutcome::OutOfFuel
        ) {
            return eprintln!("the program has ended");
        }
        steps.push(now() - step);
    }
    let all = now() - begin;
    let stop = now();
    let ended = matches!(thread.resume(Resume::Stop, 0), ResumeOutcome::Stopped);
    let stop = now() - stop;
    steps.sort();
    let at = |part: usize| {
        steps
            .get(steps.len() * part / 1000)
            .copied()
            .unwrap_or_default()
    };
    println!(
        "{objects} objects kept, {} steps in {all:?}: half of them within {:?}, 99.9 % within {:?}, slowest {:?}; \
         stop {stop:?} ({})",
        steps.len(),
        at(500),
        at(999),
        steps.last().copied().unwrap_or_default(),
        if ended { "stopped" } else { "did not stop" },
    );
}
