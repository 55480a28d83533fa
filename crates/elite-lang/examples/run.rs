//! Runs a script file without a robot: what `print` writes goes to stdout. For trying the language and timing it.

use std::process::ExitCode;
use std::rc::Rc;
use std::time::Instant;

use elite_lang::{Host, Interpreter, Limits, Resume, ResumeOutcome, ThreadId, render_script_error};
use elite_syntax::{KnownNames, SourceFile, compile, render_human};
use messages::Language;

struct Console {
    start: Instant,
}

impl Host for Console {
    fn print(&self, _: ThreadId, text: &str) {
        use std::io::Write as _;
        let _ = std::io::stdout().lock().write_all(text.as_bytes());
    }

    fn unix_time(&self) -> f64 {
        1_767_225_600.0 + self.monotonic()
    }

    fn monotonic(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    fn random_u64(&self) -> u64 {
        0x5eed
    }

    fn wake(&self, _: ThreadId) {}
}

fn main() -> ExitCode {
    let Some(path) = std::env::args().nth(1) else {
        eprintln!("usage: run FILE");
        return ExitCode::from(2);
    };
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) => {
            eprintln!("{path}: {error}");
            return ExitCode::from(2);
        }
    };
    let file = SourceFile::new(path, text);
    let program = match compile(file.clone(), &KnownNames::default()) {
        Ok(program) => program,
        Err(diagnostics) => {
            for diagnostic in diagnostics {
                eprintln!(
                    "{}",
                    render_human(&diagnostic, &file, Language::English, false)
                );
            }
            return ExitCode::from(2);
        }
    };
    let host = Rc::new(Console {
        start: Instant::now(),
    });
    let interpreter = Interpreter::new(host, Vec::new(), Limits::default());
    let mut thread = interpreter.spawn_program(&program);
    loop {
        match thread.resume(Resume::Continue, 1_000_000) {
            ResumeOutcome::OutOfFuel | ResumeOutcome::Parked { .. } | ResumeOutcome::Waiting(_) => {
            }
            ResumeOutcome::Done(_) | ResumeOutcome::Stopped => return ExitCode::SUCCESS,
            ResumeOutcome::Failed(error) => {
                eprint!("{}", render_script_error(&error));
                return ExitCode::from(1);
            }
        }
    }
}
