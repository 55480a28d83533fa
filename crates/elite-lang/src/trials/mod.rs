//! Trials by hostile programs, generated from the enum of values and the tables of builtin types: what can hold a value
//! is nested very deep (`chains`), what can be changed is changed by the script code that runs meanwhile (`mutation`).
//! A new kind of value does not compile here until it has a trial; a new method has its trials the day it is added.
//! Beside them stands what holds of the text of the source: `shape` and `likeness`.
#![allow(clippy::unwrap_used)] // tests: a broken program should stop them

mod branching;
mod chains;
mod circles;
mod counts;
mod holding;
mod likeness;
mod long_chains;
mod mutation;
mod shape;
mod threads;

use std::cell::{Cell, RefCell};
use std::process::{Command, Stdio};
use std::rc::Rc;

use elite_syntax::{KnownNames, SourceFile, compile, render_human};
use messages::Language;

use crate::{
    Host, Interpreter, Limits, Resume, ResumeOutcome, ScriptThread, ThreadId, render_script_error,
};

/// Collects what is printed; time moves on when all threads wait.
#[derive(Default)]
struct TestHost {
    output: RefCell<String>,
    now: Cell<f64>,
    started: RefCell<Vec<ScriptThread>>,
    woken: RefCell<Vec<ThreadId>>,
}

impl Host for TestHost {
    fn print(&self, _: ThreadId, text: &str) {
        self.output.borrow_mut().push_str(text);
    }
    fn unix_time(&self) -> f64 {
        self.now.get()
    }
    fn monotonic(&self) -> f64 {
        self.now.get()
    }
    fn random_u64(&self) -> u64 {
        7
    }
    fn start(&self, thread: ScriptThread) -> Result<(), String> {
        self.started.borrow_mut().push(thread);
        Ok(())
    }
    fn wake(&self, thread: ThreadId) {
        self.woken.borrow_mut().push(thread);
    }
}

/// A task that may hold a gibibyte, so that no trial ends for want of memory.
fn task() -> (Rc<TestHost>, Interpreter) {
    task_with(Limits {
        memory_bytes: 1 << 30,
        ..Limits::default()
    })
}

fn task_with(limits: Limits) -> (Rc<TestHost>, Interpreter) {
    let stage = Rc::new(TestHost::default());
    let interpreter = Interpreter::new(stage.clone(), Vec::new(), limits);
    (stage, interpreter)
}

/// Runs `act` with the evaluator of a program's thread, whose turn ends where `act` gives way.
pub fn evaluate(act: impl Fn(&crate::eval::Evaluator<'_>) -> crate::value::R<()> + Send + 'static) {
    let stage = Rc::new(TestHost::default());
    let native = crate::NativeFunction {
        name: "act",
        params: Vec::new(),
        call: crate::NativeBody::new(move |call| {
            act(call.evaluator()).map(|()| crate::Value::None)
        }),
    };
    let known = KnownNames::new(["act"]);
    let interpreter = Interpreter::new(stage.clone(), vec![native], Limits::default());
    let main = match compile(SourceFile::new("trial", "act()"), &known) {
        Ok(program) => interpreter.spawn_program(&program),
        Err(_) => panic!("a call compiles"),
    };
    assert_eq!(drive(&stage, main), "");
}

/// What a program prints, and the report of an uncaught exception after it. The task is gone when this returns.
fn run(text: &str) -> String {
    let (stage, interpreter) = task();
    let main = begin(&interpreter, text);
    let report = drive(&stage, main);
    drop(interpreter);
    stage.output.take() + &report
}

fn begin(interpreter: &Interpreter, text: &str) -> ScriptThread {
    let file = SourceFile::new("trial", text);
    match compile(file.clone(), &KnownNames::default()) {
        Ok(program) => interpreter.spawn_program(&program),
        Err(found) => panic!(
            "{}",
            render_human(&found[0], &file, Language::English, false)
        ),
    }
}

/// Runs threads in turn to the end of the first one; the report if one of them failed.
fn drive(stage: &TestHost, main: ScriptThread) -> String {
    let mut threads = vec![(main, None)];
    loop {
        let mut ran = false;
        let mut index = 0;
        while index < threads.len() {
            let (thread, parked) = &mut threads[index];
            index += 1;
            if parked.is_some() {
                continue;
            }
            ran = true;
            match thread.resume(Resume::Continue, 10_000) {
                ResumeOutcome::OutOfFuel | ResumeOutcome::Waiting(_) => {}
                ResumeOutcome::Parked { until } => *parked = Some(until),
                ResumeOutcome::Failed(error) => return render_script_error(&error).to_string(),
                ResumeOutcome::Done(_) | ResumeOutcome::Stopped if index == 1 => {
                    return String::new();
                }
                ResumeOutcome::Done(_) | ResumeOutcome::Stopped => {
                    index -= 1;
                    threads.remove(index);
                }
            }
        }
        threads.extend(
            stage
                .started
                .take()
                .into_iter()
                .map(|thread| (thread, None)),
        );
        let woken = stage.woken.take();
        for (thread, parked) in &mut threads {
            if woken.contains(&thread.id()) {
                *parked = None;
            }
        }
        if ran {
            continue;
        }
        let next = threads
            .iter()
            .filter_map(|(_, parked)| parked.flatten())
            .fold(f64::INFINITY, f64::min);
        assert!(next.is_finite(), "all threads wait for each other");
        stage.now.set(next);
        for (_, parked) in &mut threads {
            if parked.flatten().is_some_and(|until| until <= next) {
                *parked = None;
            }
        }
    }
}

/// What CPython prints for the same text; None where there is none of this language's version.
fn cpython(text: &str) -> Option<String> {
    use std::io::Write as _;
    let version = "import sys; sys.exit(sys.version_info[:2] != (3, 11))";
    let is_right = Command::new("python3").args(["-c", version]).status();
    if !is_right.is_ok_and(|status| status.success()) {
        return None;
    }
    let mut python = Command::new("python3")
        .arg("-")
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::inherit())
        .env("PYTHONHASHSEED", "0")
        .spawn()
        .unwrap();
    python
        .stdin
        .take()
        .unwrap()
        .write_all(text.as_bytes())
        .unwrap();
    Some(String::from_utf8_lossy(&python.wait_with_output().unwrap().stdout).into_owned())
}
