//! How long a program keeps the other script threads waiting: `stretches FILE`. The longest work between two
//! safepoints, by the processor's time of the thread, for each line that the program has printed before it; those above
//! a millisecond.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

use elite_lang::{Host, Interpreter, Limits, Resume, ResumeOutcome, ThreadId, render_script_error};
use elite_syntax::{KnownNames, SourceFile, compile};
use nix::time::{ClockId, clock_gettime};

#[derive(Default)]
struct Printed(RefCell<String>);

/// Time of the processor that this thread has had: other work on the machine does not count.
fn now() -> Duration {
    clock_gettime(ClockId::CLOCK_THREAD_CPUTIME_ID).map_or(Duration::ZERO, Duration::from)
}

impl Host for Printed {
    fn print(&self, _: ThreadId, text: &str) {
        self.0.borrow_mut().push_str(text);
    }

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
    let file = std::env::args().nth(1).unwrap_or_default();
    let text = match std::fs::read_to_string(&file) {
        Ok(text) => text,
        Err(error) => return eprintln!("cannot read '{file}': {error}"),
    };
    let Ok(program) = compile(SourceFile::new(&file, text), &KnownNames::default()) else {
        return eprintln!("the program does not compile");
    };
    let limits = Limits {
        memory_bytes: 2 << 30,
        ..Limits::default()
    };
    let printed = Rc::new(Printed::default());
    let interpreter = Interpreter::new(printed.clone(), Vec::new(), limits);
    let mut thread = interpreter.spawn_program(&program);
    let mut label = String::from("(begin)");
    let mut most = Duration::ZERO;
    let tell = |label: &str, most: Duration| {
        if most > Duration::from_millis(1) {
            println!("{most:>12.3?}  after '{label}'");
        }
    };
    loop {
        let before = now();
        let step = thread.resume(Resume::Continue, 1);
        most = most.max(now() - before);
        if let Some(line) = printed.0.take().lines().last() {
            tell(&label, std::mem::take(&mut most));
            label = line.to_owned();
        }
        match step {
            ResumeOutcome::OutOfFuel => {}
            ResumeOutcome::Failed(error) => {
                eprintln!("{}", render_script_error(&error));
                break;
            }
            _ => break,
        }
    }
    tell(&label, most);
}
