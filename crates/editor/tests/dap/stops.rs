//! What a program is held for, and how it is stepped.

use serde_json::json;

use crate::client::Client;

const LOOP: &str = "\
def add(a, b):
    c = a + b
    return c

total = 0
for i in range(6):
    total = add(total, i)
print('total', total)
";

#[test]
fn a_program_is_stepped_into_over_and_out_of_calls() {
    let mut client = Client::launched(LOOP, &[], json!({"stopOnEntry": true}));
    let held = client.held();
    assert_eq!((held.reason.as_str(), held.line), ("entry", 1));
    let mut lines = Vec::new();
    for command in [
        "next", "next", "next", "next", "next", "stepIn", "next", "next", "next", "stepIn",
        "stepOut",
    ] {
        let held = client.go(command);
        lines.push((held.function, held.line));
    }
    let expected = [
        ("<module>", 5),
        ("<module>", 6),
        ("<module>", 7),
        ("<module>", 6),
        ("<module>", 7),
        ("add", 2),
        ("add", 3),
        ("<module>", 6),
        ("<module>", 7),
        ("add", 2),
        ("<module>", 6),
    ];
    assert_eq!(lines, expected.map(|(name, line)| (name.to_owned(), line)));
    assert_eq!(client.try_go("continue"), None);
    assert_eq!(client.event("exited")["exitCode"], 0);
    assert_eq!(client.outputs, ["total 15\n"]);
    client.end();
}

#[test]
fn conditions_hit_counts_and_messages_decide_whether_a_breakpoint_holds() {
    let held_at = |breakpoint: serde_json::Value| {
        let mut client = Client::launched(LOOP, &[breakpoint], json!({}));
        let mut seen = Vec::new();
        while let Some(_held) = client.try_held() {
            seen.push(client.evaluate("a * 100 + b", "watch").unwrap());
            client.ask("continue", json!({"threadId": 1}));
        }
        let outputs = client.outputs.clone();
        client.end();
        (seen, outputs)
    };
    assert_eq!(
        held_at(json!({"line": 2, "condition": "b > 3"})).0,
        ["604", "1005"]
    );
    assert_eq!(held_at(json!({"line": 2, "hitCondition": "3"})).0, ["102"]);
    assert_eq!(
        held_at(json!({"line": 2, "hitCondition": "% 2"})).0,
        ["1", "303", "1005"]
    );
    assert_eq!(
        held_at(json!({"line": 2, "condition": "b % 2", "hitCondition": ">= 2"})).0,
        ["303", "1005"]
    );
    let (seen, outputs) = held_at(json!({"line": 3, "logMessage": "{a} + {b} = {c} {nothing}"}));
    assert!(seen.is_empty());
    assert!(
        outputs[1].starts_with("0 + 1 = 1 <NameError"),
        "{outputs:?}"
    );
    // What cannot be evaluated is said once, and holds.
    let (seen, outputs) = held_at(json!({"line": 2, "condition": "nothing > 1"}));
    assert_eq!(seen.len(), 6);
    let said: Vec<_> = outputs
        .iter()
        .filter(|text| text.contains("NameError"))
        .collect();
    assert_eq!(said.len(), 1, "{outputs:?}");
}

#[test]
fn breakpoints_bind_to_statements_of_one_line_programs() {
    let program = "x = 1; y = 2; z = x + y; print(z)\nif z: a = 1; b = 2\n";
    let places = [
        json!({"line": 1, "column": 15}),
        json!({"line": 2, "column": 14}),
        json!({"line": 9}),
    ];
    let mut client = Client::launched(program, &places, json!({}));
    let held = client.held();
    assert_eq!((held.line, held.column), (1, 15));
    assert_eq!(client.all(&held), ["x=1", "y=2"]);
    let held = client.go("continue");
    assert_eq!((held.line, held.column), (2, 14));
    let bound = client.set_breakpoints(&places);
    assert_eq!(bound[2]["verified"], false);
    client.end();
}

#[test]
fn functions_and_exceptions_hold_the_program() {
    let program = "\
class Gripper:
    def close(self, width):
        return 1 / width

def risky():
    try:
        Gripper().close(0)
    except ZeroDivisionError:
        pass
    {}['a']

try:
    risky()
finally:
    print('finally')
";
    let mut client = Client::launched(program, &[], json!({"stopOnEntry": true}));
    client.held();
    let functions =
        json!({"breakpoints": [{"name": "close"}, {"name": "risky", "hitCondition": "2"}]});
    client.ask("setFunctionBreakpoints", functions);
    let held = client.go("continue");
    assert_eq!(
        (held.reason.as_str(), held.line),
        ("function breakpoint", 3)
    );
    client.ask("setExceptionBreakpoints", json!({"filters": ["caught"]}));
    let held = client.go("continue");
    assert_eq!((held.reason.as_str(), held.line), ("exception", 3));
    assert!(held.text.contains("ZeroDivisionError"), "{}", held.text);
    assert_eq!(client.evaluate("width", "hover").unwrap(), "0");
    let info = client.ask("exceptionInfo", json!({"threadId": 1}));
    assert_eq!(info["exceptionId"], "ZeroDivisionError");
    let held = client.go("continue");
    assert_eq!((held.reason.as_str(), held.line), ("exception", 10));
    let error = client.try_ask("setExceptionBreakpoints", json!({"filters": ["some"]}));
    assert!(error.unwrap_err().contains("some"));
    client.ask("setExceptionBreakpoints", json!({"filters": []}));
    assert_eq!(client.try_go("continue"), None);
    assert_eq!(client.event("exited")["exitCode"], 1);
    client.end();
}

#[test]
fn threads_generators_and_cleaning_up_are_stepped_through() {
    let program = "\
def numbers():
    try:
        yield 1
        yield 2
    finally:
        note('done')

def note(text):
    print(text)

def beside():
    for i in range(3):
        sleep(0.1)

t = start_thread(beside, ())
for n in numbers():
    note(n)
join_thread(t)
";
    let mut client = Client::launched(program, &[json!({"line": 16})], json!({}));
    client.held();
    let mut lines = Vec::new();
    while let Some(held) = client.try_go("stepIn") {
        lines.push(held.line);
    }
    // The header is met again once the next item is there.
    assert_eq!(lines, [2, 3, 17, 9, 4, 16, 17, 9, 6, 9, 18]);
    client.end();
}

#[test]
fn a_program_that_computes_or_moves_is_paused() {
    let program = "movej([1, -1.57, 1.57, -1.57, -1.57, 0], a=0.5, v=0.2)\nwhile True: pass\n";
    let mut client = Client::launched(program, &[], json!({"stopOnEntry": true}));
    client.held();
    client.ask("gotoCycle", json!({"cycle": 100}));
    let held = client.held();
    assert_eq!((held.line, held.cycle), (1, 100));
    let arm = client.scope(&held, "Arm");
    let motion = arm[0]["value"].as_str().unwrap().to_owned();
    assert!(motion.contains("% of the way"), "{motion}");
    client.ask("continue", json!({"threadId": 1}));
    client.ask("pause", json!({"threadId": 1}));
    let held = client.held();
    assert_eq!(held.reason, "pause");
    client.ask("continue", json!({"threadId": 1}));
    let refused = client.try_ask("stackTrace", json!({"threadId": 1}));
    assert!(refused.unwrap_err().contains("running"));
    client.end();
}

#[test]
fn steps_lead_from_node_to_node_of_the_pendants_task() {
    let program = "$ LINE: (1, \"Start\")\na = 1\nb = 2\n$ LINE: (2, \"Approach\")\nc = 3\nd = 4\n\
        $ LINE: (3, \"Weld\")\ne = 5\n";
    let mut client = Client::launched(program, &[], json!({"stopOnEntry": true}));
    client.held();
    assert_eq!(client.go("nextNode").line, 5);
    assert_eq!(client.go("nextNode").line, 8);
    client.end();
}

#[test]
fn the_header_of_a_loop_holds_in_every_round() {
    let program = "total = 0\nfor a, b in [(1, 2), (3, 4), (5, 6)]:\n    total += a * b\nfor x in []:\n    pass\n\
        print(total)\n";
    let mut client = Client::launched(
        program,
        &[json!({"line": 2}), json!({"line": 4})],
        json!({}),
    );
    let mut lines = Vec::new();
    while let Some(held) = client.try_held() {
        lines.push(held.line);
        client.ask("continue", json!({"threadId": 1}));
    }
    assert_eq!(lines, [2, 2, 2, 4]);
    assert_eq!(client.outputs, ["44\n"]);
    client.end();
}

#[test]
fn a_program_that_is_terminated_cleans_up_and_tells_its_end() {
    let program = "\
def work():
    try:
        print('begun')
        n = 0
        while True: n += 1
    finally:
        print('cleaned up')
work()
print('never')
";
    // Held, and running.
    for breakpoint in [Some(json!({"line": 4})), None] {
        let held: Vec<_> = breakpoint.into_iter().collect();
        let mut client = Client::launched(program, &held, json!({}));
        match held.is_empty() {
            true => drop(client.event("output")),
            false => drop(client.held()),
        }
        client.ask("terminate", json!({}));
        let ended = client.event("exited");
        assert!(ended["exitCode"].is_i64(), "{ended}");
        client.event("terminated");
        assert!(
            client.outputs.iter().any(|text| text == "cleaned up\n"),
            "{:?}",
            client.outputs
        );
        assert!(!client.outputs.iter().any(|text| text == "never\n"));
        client.end();
    }
}
