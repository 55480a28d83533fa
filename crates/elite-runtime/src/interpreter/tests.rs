//! Statements of many clients, held ones, and the bound of all together.

use std::time::Duration;

use super::*;

fn statement(text: &str) -> SubmittedStatement {
    SubmittedStatement {
        text: text.to_owned(),
        on_discard: Box::new(|_| {}),
    }
}

fn interpreter() -> InterpreterMode {
    InterpreterMode::new(Arc::default(), Arc::default())
}

fn program() -> Program {
    let known = KnownNames::new(Vec::<String>::new());
    elite_syntax::compile(SourceFile::new("main", "global total\ntotal = 0\n"), &known).unwrap()
}

/// Runs a future of a client on a thread of its own.
fn block_on<T>(future: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_time()
        .build()
        .unwrap();
    runtime.block_on(future)
}

/// Many clients, one task: whatever the interleaving, nothing is lost, nothing is executed twice or out of order, no
/// wake-up is missed, and a clear never has a newer statement acknowledged before it was executed.
#[test]
fn statements_of_many_clients_are_all_answered_while_a_task_executes_and_clears() {
    const CLIENTS: usize = 4;
    const EACH: usize = 250;
    let interpreter = interpreter();
    interpreter.task_starts();
    let executed = std::thread::scope(|scope| {
        for _ in 0..CLIENTS {
            let interpreter = &interpreter;
            scope.spawn(move || {
                let mut last = StatementId::NONE;
                for n in 0..EACH {
                    let text = if n % 40 == 39 {
                        "clear_interpreter()"
                    } else {
                        "total = 1"
                    };
                    let submitted = block_on(interpreter.submit(statement(text)));
                    let SubmitResult::Accepted(id) = submitted else {
                        panic!("{submitted:?}");
                    };
                    assert!(id > last, "statements of one client keep their order");
                    last = id;
                }
            });
        }
        interpreter.task_runs(&program());
        assert!(interpreter.enter(false));
        let mut executed = Vec::new();
        while executed.len() < CLIENTS * EACH {
            match interpreter.next() {
                NextAction::Statement(id, compiled) => {
                    if compiled.mentions("clear_interpreter") {
                        let accepted = interpreter.counters().last_accepted;
                        assert_eq!(accepted, id, "nothing newer is acknowledged yet");
                    }
                    executed.push(id);
                    interpreter.finish();
                }
                NextAction::Nothing => {
                    let woken = async {
                        let news = interpreter.news.notified();
                        tokio::time::timeout(Duration::from_secs(10), news).await
                    };
                    assert!(block_on(woken).is_ok(), "a wake-up was missed");
                }
                NextAction::End => panic!("nobody asked for the end"),
            }
        }
        executed
    });
    let all = CLIENTS * EACH;
    assert!(executed.iter().map(|id| id.0).eq(1..=all as u64));
}

#[test]
fn a_statement_that_is_held_is_answered_when_the_task_ends() {
    let interpreter = interpreter();
    interpreter.task_starts();
    interpreter.task_runs(&program());
    let submit = |text| block_on(interpreter.submit(statement(text)));
    assert_eq!(
        submit("clear_interpreter()"),
        SubmitResult::Accepted(StatementId(1))
    );
    std::thread::scope(|scope| {
        let held = scope.spawn(|| submit("total = 1"));
        std::thread::sleep(Duration::from_millis(20));
        assert!(!held.is_finished());
        interpreter.task_ended();
        assert_eq!(held.join().unwrap(), SubmitResult::NoTask);
    });
    assert_eq!(interpreter.bytes.load(Ordering::Relaxed), 0);
}

#[test]
fn the_text_of_all_statements_together_is_bounded() {
    let total = Arc::default();
    let first = QuotaGuard::take(QUEUED_BYTES_MAX - 10, &total).unwrap();
    assert!(QuotaGuard::take(11, &total).is_none());
    let small = QuotaGuard::take(10, &total).unwrap();
    drop(first);
    assert!(QuotaGuard::take(11, &total).is_some());
    drop(small);
    assert_eq!(
        total.load(Ordering::Relaxed),
        0,
        "everything was given back"
    );
}
