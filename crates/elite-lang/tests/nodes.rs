//! `$ LINE` directives: where they may stand, when a thread passes them, and what is said of bad ones.

use messages::Language;

use crate::support;

use elite_lang::{
    Limits, NativeBody, NativeFunction, NodeChange, Param, Resume, ResumeOutcome, ScriptThread,
    Value, WaitToken,
};
use elite_syntax::{KnownNames, Severity, check, compile};
use support::{Task, drive};

/// `move(ok)`: a motion that waits and ends, or fails; then what was to be shown after it is.
fn motion() -> NativeFunction {
    NativeFunction {
        name: "move",
        params: vec![Param::required("ok")],
        call: NativeBody::new(|call| {
            call.wait(WaitToken(1))?;
            let fails = call.arg(0).and_then(Value::as_i64) == Some(0);
            call.on_motion_end(fails);
            if fails {
                return Err(call.raise(elite_lang::ExceptionKind::RuntimeError, "too far"));
            }
            Ok(Value::None)
        }),
    }
}

fn task() -> Task {
    Task::with(vec![motion()], Limits::default())
}

/// Nodes as `number label@line`, and where the thread stood at each of its waits.
fn follow(text: &str) -> Vec<String> {
    let task = task();
    let mut thread = task.spawn(text);
    let mut seen = Vec::new();
    loop {
        let step = thread.resume(Resume::Continue, 10_000);
        seen.extend(thread.take_node_changes().iter().map(told));
        match step {
            ResumeOutcome::Waiting(_) => {
                let node = thread.current_node().map_or(0, |node| node.number);
                seen.push(format!("waits in {node}, line {}", thread.current_line()));
            }
            ResumeOutcome::Done(_) => return seen,
            other => panic!("{other:?}"),
        }
    }
}

fn told(passage: &NodeChange) -> String {
    let NodeChange { node, line } = passage;
    format!("{} {}@{line}", node.number, node.label)
}

#[test]
fn nodes_are_passed_in_the_order_of_the_program() {
    let text = "def job():
  $ LINE: (2, \"机器人主任务\")
  global n
  n = 0
  while n < 2:
    $ LINE: (3, 'MoveJ')
    move(1)
    # a comment between
    $ LINE: (4, \"a\\u63a5\" 'b', \"before\")   # and one behind
    n = n + 1
  end
  $ LINE: (9,\"last\",)
end
";
    let once = ["3 MoveJ@7", "waits in 3, line 7", "4 a接b@10"];
    let mut expected = vec!["2 机器人主任务@3"];
    expected.extend(once.iter().chain(&once));
    expected.push("9 last@5");
    assert_eq!(follow(text), expected);
}

#[test]
fn a_node_with_after_is_shown_when_the_motion_has_ended() {
    let text = "$ LINE: (1, 'start')
$ LINE: (5, '初始点', 'after')
x = 1
move(1)
$ LINE: (6, 'next', 'after')
try:
  move(0)
except RuntimeError:
  pass
move(1)
$ LINE: (7, 'wait')
move(1)
";
    assert_eq!(
        follow(text),
        [
            "1 start@3",
            "waits in 1, line 4",
            "5 初始点@4",
            "waits in 5, line 7",
            // What was to be shown after a motion that failed is not shown after the next one.
            "waits in 5, line 10",
            "7 wait@12",
            "waits in 7, line 12",
        ]
    );
}

#[test]
fn a_directive_before_a_clause_belongs_to_the_clause() {
    let program = |value: i32| {
        format!(
            "x = {value}
if x == 1:
    $ LINE: (2, 'one')
    y = 1
$ LINE: (3, 'two?')
elif x == 2:
    y = 2
    $ LINE: (4, 'else')
else:
    y = 3
    $ LINE: (5, 'tail')
    # nothing else
$ LINE: (6, 'after if')
try:
    1 / (x - 1)
  $ LINE: (7, 'caught')
except ZeroDivisionError:
    pass
$ LINE: (8, 'finally')
finally:
    z = 1
"
        )
    };
    let nodes = |value| -> Vec<String> {
        let told = follow(&program(value));
        told.iter()
            .map(|node| node.split(' ').next().unwrap_or_default().to_owned())
            .collect()
    };
    assert_eq!(nodes(1), ["2", "6", "7", "8"]);
    assert_eq!(nodes(2), ["3", "6", "8"]);
    assert_eq!(nodes(3), ["3", "4", "5", "6", "8"]);
}

#[test]
fn directives_stand_in_functions_classes_generators_and_between_brackets() {
    let text = "def sub(a):
    $ LINE: (10, 'sub')
    move(1)
    return a
class Part:
    $ LINE: (11, 'class')
    size = 1
    def grow(self):
        $ LINE: (12, 'method')
        self.size += 1
        return self.size
def each(n):
    $ LINE: (13, 'generator')
    for i in range(n):
        if i == 1:
            yield 0
        $ LINE: (14, 'elif')
        elif i == 2:
            $ LINE: (15, 'two')
            yield 2
        $ LINE: (16, 'turn')
    $ LINE: (17, 'end of it')
p = Part()
total = sum([sub(1),
             $ LINE: (99, 'between brackets')
             p.grow()])
$ LINE: (18, 'go')
total = total + sum(each(3))
for i in range(2):
    pass
    $ LINE: (19, 'only in a body of pass')
";
    assert_eq!(
        follow(text),
        [
            "11 class@7",
            "10 sub@3",
            "waits in 10, line 3",
            "12 method@10",
            "99 between brackets@28",
            "18 go@28",
            "13 generator@14",
            "14 elif@18",
            "16 turn@15",
            "14 elif@18",
            "15 two@20",
            "16 turn@15",
            "17 end of it@14",
            "19 only in a body of pass@30",
        ]
        .map(str::to_owned)
    );
}

/// The report of the error that ends a program.
fn report(text: &str) -> String {
    task().run(text)
}

#[test]
fn an_error_names_the_node_that_its_thread_passed_last() {
    let text = "$ LINE: (6, 'before')\nx = 1\n$ LINE: (7, '接近点', 'after')\ny = x / 0\n";
    let shown = report(text);
    assert!(
        shown.ends_with("\n  in node 7 接近点\nZeroDivisionError: division by zero\n"),
        "{shown}"
    );
    let unlabelled = report("$ LINE: (3, '')\nraise ValueError('no')\n");
    assert!(
        unlabelled.ends_with("  in node 3\nValueError: no\n"),
        "{unlabelled}"
    );
    let odd = report("$ LINE: (3, 'a\\nValueError: b')\nraise ValueError('no')\n");
    assert!(odd.contains("  in node 3 a\\nValueError: b\n"), "{odd}");
    let none = report("raise ValueError('no')\n$ LINE: (3, 'never')\n");
    assert!(!none.contains("node"), "{none}");
    let help = report("def f():\n  $ LINE: (4, 'n')\n  f(1)\nf()\n");
    assert!(help.contains("  in node 4 n\n  help: "), "{help}");
    assert!(
        help.trim_end()
            .lines()
            .last()
            .unwrap_or_default()
            .starts_with("TypeError: "),
        "{help}"
    );
}

#[test]
fn every_thread_has_a_node_of_its_own_and_begins_where_it_was_started() {
    let task = task();
    let mut main = task.spawn(
        "import threading
def work():
  move(1)
  $ LINE: (20, 'worker')
  move(1)
$ LINE: (2, 'main')
threading.Thread(target=work).start()
$ LINE: (3, 'go on')
move(1)
move(1)
",
    );
    let number = |thread: &ScriptThread| thread.current_node().map_or(0, |node| node.number);
    // Reading the text of the module takes several turns.
    let mut step = main.resume(Resume::Continue, 1000);
    while let ResumeOutcome::OutOfFuel = step {
        step = main.resume(Resume::Continue, 1000);
    }
    assert!(matches!(step, ResumeOutcome::Waiting(_)));
    let mut worker = task
        .host
        .started
        .borrow_mut()
        .pop()
        .unwrap_or_else(|| panic!("no thread"));
    assert_eq!(main.take_node_changes().len(), 2);
    assert!(matches!(
        worker.resume(Resume::Continue, 1000),
        ResumeOutcome::Waiting(_)
    ));
    assert_eq!((number(&main), number(&worker)), (3, 2));
    assert!(matches!(
        worker.resume(Resume::Continue, 1000),
        ResumeOutcome::Waiting(_)
    ));
    assert!(matches!(
        main.resume(Resume::Continue, 1000),
        ResumeOutcome::Waiting(_)
    ));
    assert_eq!((number(&main), number(&worker)), (3, 20));
}

#[test]
fn a_thread_ends_in_its_last_line() {
    for (text, last) in [
        ("a = 1\nb = 2\n", 2),
        ("def job():\n  a = 1\n  b = 2\nend\n", 3),
        (
            "def f():\n  return 1\ndef job():\n  f()\n  return 2\njob()\n",
            6,
        ),
    ] {
        let task = task();
        let mut thread = task.spawn(text);
        assert!(matches!(
            drive(&mut thread, &task.host),
            ResumeOutcome::Done(_)
        ));
        assert_eq!(thread.current_line(), last, "{text}");
    }
}

#[test]
fn of_very_many_nodes_the_first_and_the_last_are_kept() {
    let task = task();
    let mut thread = task.spawn(
        "i = 0\nwhile i < 1000:\n  $ LINE: (1, 'a')\n  i += 1\n  $ LINE: (2, 'b')\n  i += 1\n\
         $ LINE: (3, 'c')\nmove(1)\n",
    );
    assert!(matches!(
        thread.resume(Resume::Continue, 100_000),
        ResumeOutcome::Waiting(_)
    ));
    let passed = thread.take_node_changes();
    let numbers: Vec<u32> = passed.iter().map(|passage| passage.node.number).collect();
    assert_eq!((numbers.len(), numbers[0], numbers[63]), (64, 1, 3));
    assert!(thread.take_node_changes().is_empty());
}

#[test]
fn long_labels_are_cut() {
    let label = "接".repeat(300);
    let told = follow(&format!("$ LINE: (1, '{label}')\nx = 1\n"));
    assert_eq!(told, [format!("1 {}…@2", "接".repeat(200))]);
}

#[test]
fn a_directive_is_no_statement() {
    let findings = |text: &str| {
        let file = Task::file(text);
        let found = check(file.clone(), &KnownNames::new(["move"]));
        found
            .iter()
            .filter(|finding| finding.severity == Severity::Error)
            .map(|finding| {
                let place = file.position(finding.span.start);
                format!("{}:{} {}", place.line, place.column, finding.message)
            })
            .collect::<Vec<_>>()
    };
    assert_eq!(
        findings("if 1:\n  $ LINE: (1, 'a')\nmove(1)\n"),
        ["3:1 expected an indented block after the 'if' condition"]
    );
    // A docstring and the only function of a program stay what they are.
    let file = Task::file(
        "$ LINE: (1, 'a')\ndef job():\n  $ LINE: (2, 'b')\n  'text'\n  move(1)\nend\n$ LINE: (3, 'c')\n",
    );
    let program =
        compile(file, &KnownNames::new(["move"])).unwrap_or_else(|found| panic!("{found:?}"));
    assert_eq!(program.name(), "job");
}

#[test]
fn bad_directives_are_errors_with_their_place() {
    let cases = [
        (
            "$",
            "1:1-1:2 a line that begins with '$' is a directive, and this one has no name",
        ),
        ("$ lines: (1, 'a')", "1:1-1:8 there is no directive 'lines'"),
        ("$ LINE (1, 'a')", "1:8-1:9 expected ':' after '$ LINE'"),
        ("$ LINE: 1, 'a'", "1:9-1:10 expected '(' after '$ LINE:'"),
        ("$ LINE:", "1:8-1:8 expected '(' after '$ LINE:'"),
        ("$ LINE: (1)", "1:9-1:12 '$ LINE' takes a number and a text"),
        (
            "$ LINE: (1, 'a', 'before', 2)",
            "1:9-1:30 '$ LINE' takes a number and a text",
        ),
        (
            "$ LINE: (0, 'a')",
            "1:10-1:11 the node of '$ LINE' must be a whole number from 1 to 4294967295, not 0",
        ),
        (
            "$ LINE: (-3, 'a')",
            "1:10-1:12 the node of '$ LINE' must be a whole number from 1 to 4294967295, not -3",
        ),
        (
            "$ LINE: (99999999999999999999, 'a')",
            "1:10-1:30 the node of '$ LINE' must be a whole number from 1 to 4294967295, not 99999999999999999999",
        ),
        (
            "$ LINE: (1.0, 'a')",
            "1:10-1:13 the node of '$ LINE' must be a whole number from 1 to 4294967295, not 1.0",
        ),
        (
            "$ LINE: (1, name)",
            "1:13-1:17 the name in '$ LINE' must be a string literal, not name",
        ),
        (
            "$ LINE: (1, b'a')",
            "1:13-1:17 the name in '$ LINE' must be a string literal, not b'a'",
        ),
        (
            "$ LINE: (1, f'{1}')",
            "1:13-1:19 the name in '$ LINE' must be a string literal, not f'{1}'",
        ),
        (
            "$ LINE: (1, 'a', 'while')",
            "1:18-1:25 the third part of '$ LINE' must be \"before\" or \"after\", not 'while'",
        ),
        (
            "$ LINE: (1, 'a'",
            "1:16-1:16 expected ')', found the end of the line",
        ),
        ("$ LINE: (1, 'a)", "1:13-1:14 this string is never closed"),
        (
            "$ LINE: (1, 'a'); x = 2",
            "1:17-1:18 expected the end of the expression, found ';'",
        ),
        (
            "x = 1  $ LINE: (1, 'a')",
            "1:8-1:9 the character '$' (U+0024) has no meaning here",
        ),
    ];
    for (text, expected) in cases {
        let file = Task::file(&format!("{text}\ny = 1\n"));
        let found = compile(file.clone(), &KnownNames::new([""; 0]))
            .err()
            .unwrap_or_default();
        let first = found.first().unwrap_or_else(|| panic!("{text} compiles"));
        let (start, end) = (
            file.position(first.span.start),
            file.position(first.span.end),
        );
        let shown = format!(
            "{}:{}-{}:{} {}",
            start.line, start.column, end.line, end.column, first.message
        );
        assert_eq!(shown, expected, "{text}");
        let is_here = |span: elite_syntax::Span| file.position(span.start).line == 1;
        assert!(
            found.iter().all(|finding| is_here(finding.span)),
            "{text}: {found:?}"
        );
    }
}

#[test]
fn findings_name_the_node_they_are_in() {
    let known = KnownNames::new(["movej"]);
    let nodes = |text: &str| -> Vec<String> {
        let file = Task::file(text);
        let shown = |finding: &elite_syntax::Diagnostic| {
            let node = finding.node.as_ref().map(ToString::to_string);
            let picture = elite_syntax::render_human(finding, &file, Language::English, false);
            match &node {
                Some(node) => assert!(picture.contains(&format!("note: in {node}")), "{picture}"),
                None => assert!(!picture.contains("note: in "), "{picture}"),
            }
            format!("{}: {}", finding.code, node.unwrap_or_default())
        };
        elite_syntax::check(file.clone(), &known)
            .iter()
            .map(shown)
            .collect()
    };
    assert_eq!(
        nodes(
            "z =\n$ LINE: (3, '接近点')\nx = = 1\n$ LINE: (4, 'b\\n', 'after')\ny = )\n$ LINE: (0, 'c')\nw = (\n"
        ),
        [
            "syntax: ",
            "syntax: node 3 接近点",
            "syntax: node 4 b\\n",
            "directive: ",
            "syntax: node 4 b\\n"
        ],
        "errors of the grammar"
    );
    assert_eq!(
        nodes(
            "$ LINE: (1, 'a')\ndef f():\n    global x\n    $ LINE: (2, '')\n    nonlocal y\n    return 1\n\
             $ LINE: (3, 'c')\nf()\n"
        ),
        ["syntax: node 2"],
        "errors of the scopes"
    );
    assert_eq!(
        nodes("$ LINE: (1, 'a')\nmovej(p)\n$ LINE: (2, 'b')\nmovey(1)\n"),
        ["undefined-name: node 1 a", "undefined-name: node 2 b"],
        "warnings"
    );
}
