//! Statements that run in the place of a native that waits, as interpreter mode needs them.
#![allow(clippy::unwrap_used, clippy::expect_used)] // a test

use crate::support;

use std::cell::RefCell;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use elite_lang::{
    Limits, NativeBody, NativeCall, NativeFunction, Param, Resume, ResumeOutcome, ScriptResult,
    Value, WaitToken, render_script_error,
};
use elite_syntax::{KnownNames, SourceFile, Statement, compile_statement};
use support::{Task, drive};

fn statement(text: &str) -> Statement {
    let file = SourceFile::new("statement 7", text);
    compile_statement(file, &KnownNames::default()).unwrap_or_else(|e| panic!("{text}: {e:?}"))
}

fn native(
    name: &'static str,
    call: impl Fn(&mut NativeCall<'_>) -> ScriptResult + Send + 'static,
) -> NativeFunction {
    NativeFunction {
        name,
        params: vec![Param::optional("n")],
        call: NativeBody::new(call),
    }
}

/// A task whose native `statements()` runs the given texts, one list a call, each after a wait; errors are collected.
struct Mode {
    task: Task,
    errors: Arc<Mutex<Vec<String>>>,
}

fn mode(calls: &[&[&str]]) -> Mode {
    let calls = calls
        .iter()
        .map(|texts| texts.iter().map(|text| statement(text)).collect());
    let calls: RefCell<VecDeque<Vec<Statement>>> = RefCell::new(calls.collect());
    let errors = Arc::new(Mutex::new(Vec::new()));
    let seen = errors.clone();
    let run = native("statements", move |call| {
        for statement in calls.borrow_mut().pop_front().unwrap_or_default() {
            call.wait(WaitToken(1))?;
            if let Err(raised) = call.run_statement(&statement) {
                let Some(report) = call.report(&raised) else {
                    return Err(raised);
                };
                seen.lock()
                    .unwrap()
                    .push(render_script_error(&report).to_string());
            }
        }
        Ok(Value::None)
    });
    let clear = native("clear", |call| {
        call.clear_statements();
        Ok(Value::None)
    });
    let wait = native("wait", |call| {
        call.wait(WaitToken(2))?;
        Ok(Value::None)
    });
    Mode {
        task: Task::with(vec![run, clear, wait], Limits::default()),
        errors,
    }
}

/// What a program prints whose calls of `statements()` run these texts; no statement may fail.
fn output(program: &str, calls: &[&[&str]]) -> String {
    let mode = mode(calls);
    let output = mode.task.run(program);
    assert_eq!(*mode.errors.lock().unwrap(), Vec::<String>::new());
    output
}

fn errors(program: &str, calls: &[&[&str]]) -> Vec<String> {
    let mode = mode(calls);
    mode.task.run(program);
    std::mem::take(&mut *mode.errors.lock().unwrap())
}

#[test]
fn statements_read_and_change_locals_of_the_calling_function() {
    let program = "def f(a):\n    b = [1]\n    statements()\n    print(a, b, c)\n    c = 0\nf(1)\n";
    let printed = output(
        program,
        &[&["a += 10", "b.append(a); print(b)", "c = a * 2"]],
    );
    assert_eq!(printed, "[1, 11]\n11 [1, 11] 22\n");
}

#[test]
fn statements_share_the_variables_of_closures() {
    let program = "def outer():\n    n = 1\n    m = 5\n    def get():\n        return n\n    def run():\
                   \n        nonlocal m\n        statements()\n        return m\n    statements()\
                   \n    print(run(), get())\nouter()\n";
    assert_eq!(
        output(program, &[&["n = 2"], &["m += n_of() if False else 1"]]),
        "6 2\n"
    );
}

#[test]
fn statements_change_globals_but_make_none() {
    let program = "total = 1\ndef f():\n    statements()\nf()\nprint(total)\nprint('fresh' in globals())\n\
                   print(fresh)\n";
    let mode = mode(&[&["total = 2", "fresh = total + 1", "print(fresh)"]]);
    let printed = mode.task.run(program);
    assert!(printed.starts_with("3\n2\nFalse\n"), "{printed}");
    assert!(
        printed.ends_with("NameError: name 'fresh' is not defined\n"),
        "{printed}"
    );
}

#[test]
fn global_declarations_of_statements_reach_existing_globals_only() {
    let program = "total = 1\ndef f():\n    total = 'local'\n    statements()\n    print(total)\nf()\nprint(total)\n";
    let add = "def add():\n    global total\n    total += 1\nend";
    assert_eq!(output(program, &[&[add, "add()"]]), "local\n2\n");
    let refused = errors(program, &[&["global fresh; fresh = 1"]]);
    assert_eq!(
        refused,
        [
            "NameError: name 'fresh' is not a global of the program, and a statement cannot define new ones\n"
        ]
    );
}

#[test]
fn functions_of_statements_call_each_other_and_see_the_scope() {
    let program = "def f():\n    x = 1\n    statements()\n    print(x)\nf()\n";
    let texts: &[&str] = &[
        "def a():; return b() + x;end;",
        "def b():\n\treturn 10\nend",
        "print(a())",
        "x = 5",
        "print(a())",
        "def set():\n    nonlocal_x = [x]\n    return nonlocal_x\nend",
        "print(set())",
    ];
    assert_eq!(output(program, &[texts]), "11\n15\n[5]\n5\n");
}

#[test]
fn what_statements_define_lives_until_it_is_cleared() {
    let program =
        "def f():\n    statements()\ndef g():\n    statements()\nf()\ng()\nclear()\ng()\n";
    let printed = output(
        program,
        &[
            &["def hello(): print('hello')", "k = 3"],
            &["hello(); print(k)"],
            &[],
        ],
    );
    assert_eq!(printed, "hello\n3\n");
    let refused = errors(
        program,
        &[&["def hello(): print('hello')"], &[], &["hello()"]],
    );
    assert_eq!(refused.len(), 1);
    assert!(
        refused[0].ends_with("NameError: name 'hello' is not defined\n"),
        "{refused:?}"
    );
}

#[test]
fn statements_find_globals_that_come_up_later() {
    let program =
        "def f():\n    global late\n    statements()\n    late = 4\n    statements()\nf()\n";
    assert_eq!(
        output(program, &[&["def get(): return late"], &["print(get())"]]),
        "4\n"
    );
}

#[test]
fn an_error_names_the_statement_and_does_not_end_the_thread() {
    let program = "def f():\n    x = 0\n    statements()\n    print('went on', x)\nf()\n";
    let mode = mode(&[&["x = 1", "x = 2; x / 0", "x += 1"]]);
    assert_eq!(mode.task.run(program), "went on 3\n");
    assert_eq!(
        std::mem::take(&mut *mode.errors.lock().unwrap()),
        [
            "Traceback (most recent call last):\n  statement 7, line 1, column 8, in <module>\n    x = 2; x / 0\
             \n           ^^^^^\nZeroDivisionError: division by zero\n"
        ]
    );
}

#[test]
fn an_error_that_is_passed_on_can_be_caught_by_the_program() {
    let text = statement("raise ValueError('from outside')");
    let run = native("statements", move |call| {
        call.run_statement(&text)?;
        Ok(Value::None)
    });
    let task = Task::with(vec![run], Limits::default());
    let printed =
        task.run("try:\n    statements()\nexcept ValueError as e:\n    print('caught', e)\n");
    assert_eq!(printed, "caught from outside\n");
}

#[test]
fn statements_wait_run_in_slices_and_are_stopped() {
    let program = "def f():\n    x = 0\n    try:\n        statements()\n    finally:\n        print('x', x)\nf()\n";
    let mode = mode(&[&["wait(); x = 1", "while True: x += 1"]]);
    let mut thread = mode.task.spawn(program);
    for token in [1, 2, 1] {
        let step = thread.resume(Resume::Continue, 1000);
        assert!(
            matches!(step, ResumeOutcome::Waiting(WaitToken(n)) if n == token),
            "{step:?}"
        );
    }
    assert!(matches!(
        thread.resume(Resume::Continue, 1000),
        ResumeOutcome::OutOfFuel
    ));
    assert!(matches!(
        thread.resume(Resume::Stop, 1000),
        ResumeOutcome::Stopped
    ));
    let printed = mode.task.host.output.take();
    let x: i64 = printed.trim_start_matches("x ").trim().parse().unwrap();
    assert!((900..=1001).contains(&x), "{printed}");
}

#[test]
fn statements_at_the_top_level_use_the_globals() {
    let program = "a = 1\nstatements()\nprint(a)\n";
    assert_eq!(
        output(
            program,
            &[&["a = a + 1", "print(locals()['a'], eval('a'))"]]
        ),
        "2 2\n2\n"
    );
}

#[test]
fn eval_in_a_statement_sees_the_locals() {
    let program = "def f():\n    x = 3\n    statements()\nf()\n";
    assert_eq!(
        output(program, &[&["print(eval('x + 1'), sorted(locals()))"]]),
        "4 ['x']\n"
    );
}

#[test]
fn a_method_call_or_stars_reach_the_same_scope() {
    let program = "def f():\n    x = 1\n    args = []\n    statements(*args)\n    print(x)\nf()\n";
    assert_eq!(output(program, &[&["x = 9"]]), "9\n");
}

#[test]
fn an_endless_recursion_in_a_statement_is_an_error_of_the_statement() {
    let program = "def f():\n    statements()\n    print('alive')\nf()\n";
    let mode = mode(&[&["def r(): return r()", "r()"]]);
    assert_eq!(mode.task.run(program), "alive\n");
    let errors = std::mem::take(&mut *mode.errors.lock().unwrap());
    assert!(errors[0].ends_with("RecursionError: maximum recursion depth exceeded\n"));
}

#[test]
fn a_text_that_is_no_statement_is_refused_with_all_its_errors() {
    let refused = |text: &str| {
        let file = SourceFile::new("statement 1", text);
        let found = compile_statement(file, &KnownNames::default());
        found.expect_err(text).len()
    };
    assert_eq!(refused("x = = 1"), 1);
    assert_eq!(refused("return 1"), 1);
    assert_eq!(refused("nonlocal x"), 1);
    assert_eq!(refused("a b\nc d"), 2);
}

#[test]
fn a_statement_tells_what_it_uses() {
    let text = statement("def f():\n    x = start_thread(g, ())\n    return x\nglobal k\n");
    assert!(text.mentions("start_thread") && text.mentions("g") && text.mentions("f"));
    assert!(!text.mentions("x"));
    assert_eq!(text.declared_globals().collect::<Vec<_>>(), ["k"]);
}

#[test]
fn many_statements_leave_nothing_behind() {
    let program = "def f():\n    x = 0\n    statements()\n    clear()\nf()\n";
    let texts: Vec<String> = (0..200)
        .map(|i| format!("def f{i}(a=[0] * 1000): return a, x"))
        .collect();
    let texts: Vec<&str> = texts.iter().map(String::as_str).collect();
    let mode = mode(&[&texts]);
    let before = mode.task.interpreter.memory_used();
    let mut thread = mode.task.spawn(program);
    assert!(matches!(
        drive(&mut thread, &mode.task.host),
        ResumeOutcome::Done(_)
    ));
    drop(thread);
    // Many lists that go at once go bit by bit, with each turn some.
    for _ in 0..100 {
        let mut next = mode.task.spawn("pass\n");
        assert!(matches!(
            drive(&mut next, &mode.task.host),
            ResumeOutcome::Done(_)
        ));
    }
    let held = mode.task.interpreter.memory_used().saturating_sub(before);
    assert!(held < 20_000, "{held} bytes are still held");
}
