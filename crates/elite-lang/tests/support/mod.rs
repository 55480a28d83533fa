//! A deterministic host, and a driver that runs programs to their end.
#![allow(dead_code)] // each test binary uses a part of it

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::sync::Arc;

use elite_lang::{
    Host, Interpreter, Limits, NativeFunction, Resume, ResumeOutcome, ScriptThread, ThreadId,
    render_script_error,
};
use elite_syntax::{KnownNames, SourceFile, compile, render_human};
use messages::Language;

/// Collects output; time stands still unless a test moves it; random numbers are a counter.
#[derive(Default)]
pub struct TestHost {
    pub output: RefCell<String>,
    pub now: Cell<f64>,
    pub woken: RefCell<Vec<ThreadId>>,
    /// Threads the program has started and nobody has run yet.
    pub started: RefCell<Vec<ScriptThread>>,
    counter: Cell<u64>,
}

impl Host for TestHost {
    fn print(&self, _: ThreadId, text: &str) {
        self.output.borrow_mut().push_str(text);
    }

    fn unix_time(&self) -> f64 {
        1_767_225_600.0 + self.now.get()
    }

    fn monotonic(&self) -> f64 {
        self.now.get()
    }

    fn random_u64(&self) -> u64 {
        self.counter.set(self.counter.get() + 1);
        self.counter.get()
    }

    fn start(&self, thread: ScriptThread) -> Result<(), String> {
        self.started.borrow_mut().push(thread);
        Ok(())
    }

    fn wake(&self, thread: ThreadId) {
        self.woken.borrow_mut().push(thread);
    }
}

pub struct Task {
    pub host: Rc<TestHost>,
    pub interpreter: Interpreter,
    known: KnownNames,
}

impl Task {
    pub fn new() -> Self {
        Self::with(Vec::new(), Limits::default())
    }

    pub fn with(natives: Vec<NativeFunction>, limits: Limits) -> Self {
        let host = Rc::new(TestHost::default());
        let known = KnownNames::new(natives.iter().map(|native| native.name));
        let interpreter = Interpreter::new(host.clone(), natives, limits);
        Task {
            host,
            interpreter,
            known,
        }
    }

    pub fn file(text: &str) -> Arc<SourceFile> {
        SourceFile::new("test.script", text)
    }

    /// A thread for a program that must compile.
    pub fn spawn(&self, text: &str) -> ScriptThread {
        let file = Self::file(text);
        match compile(file.clone(), &self.known) {
            Ok(program) => self.interpreter.spawn_program(&program),
            Err(diagnostics) => {
                let shown: Vec<String> = diagnostics
                    .iter()
                    .map(|d| render_human(d, &file, Language::English, false))
                    .collect();
                panic!("does not compile:\n{}", shown.join("\n"))
            }
        }
    }

    /// Runs a program to its end; what it printed, and the report of an uncaught exception after it.
    pub fn run(&self, text: &str) -> String {
        let mut thread = self.spawn(text);
        let end = drive(&mut thread, &self.host);
        let mut output = self.host.output.take();
        if let ResumeOutcome::Failed(error) = end {
            output.push_str(render_script_error(&error).english());
        }
        output
    }
}

/// Runs a thread to its end and with it the threads it starts, in turn, time moving on when all of them wait. An
/// uncaught error in one of those counts as the end of all.
pub fn drive(main: &mut ScriptThread, host: &TestHost) -> ResumeOutcome {
    let mut main_parked = None;
    let mut others: Vec<(ScriptThread, Option<Option<f64>>)> = Vec::new();
    loop {
        let mut ran = false;
        if main_parked.is_none() {
            ran = true;
            match main.resume(Resume::Continue, 10_000) {
                ResumeOutcome::OutOfFuel | ResumeOutcome::Waiting(_) => {}
                ResumeOutcome::Parked { until } => main_parked = Some(until),
                end => return end,
            }
        }
        let mut index = 0;
        while index < others.len() {
            let (thread, parked) = &mut others[index];
            if parked.is_none() {
                ran = true;
                match thread.resume(Resume::Continue, 10_000) {
                    ResumeOutcome::OutOfFuel | ResumeOutcome::Waiting(_) => {}
                    ResumeOutcome::Parked { until } => *parked = Some(until),
                    ResumeOutcome::Done(_) | ResumeOutcome::Stopped => {
                        others.remove(index);
                        continue;
                    }
                    failed => return failed,
                }
            }
            index += 1;
        }
        others.extend(host.started.take().into_iter().map(|thread| (thread, None)));
        for woken in host.woken.take() {
            if main.id() == woken {
                main_parked = None;
            }
            for (thread, parked) in &mut others {
                if thread.id() == woken {
                    *parked = None;
                }
            }
        }
        if ran {
            continue;
        }
        let waits = others
            .iter()
            .map(|(_, parked)| *parked)
            .chain([main_parked]);
        let next = waits.flatten().flatten().fold(f64::INFINITY, f64::min);
        assert!(next.is_finite(), "all threads wait for each other");
        host.now.set(host.now.get().max(next));
        let over =
            |parked: &Option<Option<f64>>| matches!(parked, Some(Some(until)) if *until <= next);
        if over(&main_parked) {
            main_parked = None;
        }
        for (_, parked) in &mut others {
            if over(parked) {
                *parked = None;
            }
        }
    }
}

/// Runs a program alone; its output and error report.
pub fn run(text: &str) -> String {
    Task::new().run(text)
}

/// The last line a program leaves: of its output, or `Type: message`.
pub fn last_line(text: &str) -> String {
    last_but_help(&run(text))
}

/// The last line of an output that is no advice.
pub fn last_but_help(output: &str) -> String {
    let mut lines = output.trim_end().lines();
    let last = lines.rfind(|line| !line.starts_with("help: "));
    last.unwrap_or("").to_owned()
}
