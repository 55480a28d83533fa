//! Programs run with little fuel and memory: whatever they do, the thread can be stopped and everything is given back.
#![no_main]

use std::rc::Rc;

use elite_lang::{
    Host, Interpreter, KnownNames, Limits, Resume, SourceFile, Step, ThreadId, compile, render_script_error,
};
use libfuzzer_sys::fuzz_target;

struct Quiet;

impl Host for Quiet {
    fn print(&self, _: ThreadId, _: &str) {}

    fn unix_time(&self) -> f64 {
        1_767_225_600.0
    }

    fn monotonic(&self) -> f64 {
        0.0
    }

    fn random_u64(&self) -> u64 {
        4
    }

    fn wake(&self, _: ThreadId) {}
}

fuzz_target!(|data: &[u8]| {
    let text = String::from_utf8_lossy(data).into_owned();
    let Ok(program) = compile(SourceFile::new("fuzz.script", text), &KnownNames::default()) else {
        return;
    };
    let limits = Limits {
        memory_bytes: 16 << 20,
        stop_fuel: 200,
        ..Limits::default()
    };
    let interpreter = Interpreter::new(Rc::new(Quiet), Vec::new(), limits);
    let mut thread = interpreter.spawn_program(&program);
    for _ in 0..5 {
        match thread.resume(Resume::Continue, 2_000) {
            Step::OutOfFuel | Step::Parked { .. } | Step::Waiting(_) => {}
            Step::Failed(error) => {
                assert!(!render_script_error(&error).is_empty());
                return;
            }
            Step::Done(_) | Step::Stopped => return,
        }
    }
    let end = thread.resume(Resume::Stop, 0);
    assert!(matches!(end, Step::Stopped), "{end:?}");
});
