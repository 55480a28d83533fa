//! Every request is answered, at any time and whatever its arguments are; what cannot be done is refused by name.

use serde_json::{Value as Json, json};

use crate::client::Client;

/// All requests of the protocol, our own, and one that is none.
const REQUESTS: &[&str] = &[
    "initialize",
    "launch",
    "attach",
    "configurationDone",
    "cancel",
    "restart",
    "terminate",
    "breakpointLocations",
    "setBreakpoints",
    "setFunctionBreakpoints",
    "setExceptionBreakpoints",
    "dataBreakpointInfo",
    "setDataBreakpoints",
    "setInstructionBreakpoints",
    "continue",
    "next",
    "stepIn",
    "stepOut",
    "stepBack",
    "reverseContinue",
    "restartFrame",
    "goto",
    "pause",
    "stackTrace",
    "scopes",
    "variables",
    "setVariable",
    "source",
    "threads",
    "terminateThreads",
    "modules",
    "loadedSources",
    "evaluate",
    "setExpression",
    "stepInTargets",
    "gotoTargets",
    "completions",
    "exceptionInfo",
    "readMemory",
    "writeMemory",
    "disassemble",
    "locations",
    "startDebugging",
    "runInTerminal",
    "nextNode",
    "gotoCycle",
    "",
];

/// What has to be there, and what it may not be.
const NEEDED: &[(&str, &str, &str)] = &[
    ("breakpointLocations", "source", r#""source.script""#),
    ("breakpointLocations", "line", r#""1""#),
    ("setBreakpoints", "source", "1"),
    ("setFunctionBreakpoints", "breakpoints", "{}"),
    ("setExceptionBreakpoints", "filters", r#""caught""#),
    ("dataBreakpointInfo", "name", "7"),
    ("setDataBreakpoints", "breakpoints", "true"),
    ("continue", "threadId", r#""1""#),
    ("next", "threadId", "-1"),
    ("stepIn", "threadId", "1.5"),
    ("stepOut", "threadId", "[]"),
    ("stepBack", "threadId", "{}"),
    ("reverseContinue", "threadId", "true"),
    ("pause", "threadId", r#""""#),
    ("restartFrame", "frameId", "99999999999"),
    ("stackTrace", "threadId", "1e400"),
    ("scopes", "frameId", r#""top""#),
    ("variables", "variablesReference", "-3"),
    ("setVariable", "variablesReference", "[1]"),
    ("setVariable", "name", "1"),
    ("setVariable", "value", "1"),
    ("source", "sourceReference", r#""1""#),
    ("evaluate", "expression", "1"),
    ("setExpression", "expression", "[]"),
    ("setExpression", "value", "false"),
    ("exceptionInfo", "threadId", r#""x""#),
    ("gotoCycle", "cycle", "-1"),
];

/// Arguments that are right where the program is held, but for the numbers.
fn right(command: &str) -> Json {
    match command {
        "breakpointLocations" => json!({"source": {}, "line": 1}),
        "setBreakpoints" => json!({"source": {}, "breakpoints": []}),
        "setFunctionBreakpoints" | "setDataBreakpoints" => json!({"breakpoints": []}),
        "setExceptionBreakpoints" => json!({"filters": []}),
        "dataBreakpointInfo" => json!({"name": "time > 1"}),
        "restartFrame" | "scopes" => json!({"frameId": 1}),
        "variables" => json!({"variablesReference": 1}),
        "setVariable" => json!({"variablesReference": 1, "name": "x", "value": "1"}),
        "source" => json!({"sourceReference": 1}),
        "evaluate" => json!({"expression": "x"}),
        "setExpression" => json!({"expression": "x", "value": "1"}),
        "gotoCycle" => json!({"cycle": 1}),
        _ => json!({"threadId": 1}),
    }
}

#[test]
fn every_request_is_answered_whatever_its_arguments_are() {
    let odd = [
        "null",
        "true",
        "-1",
        "1.5",
        "18446744073709551615",
        r#""x""#,
        "[]",
        "[[]]",
        "[{}]",
        "{}",
        r#"{"path": []}"#,
    ];
    let odd: Vec<Json> = odd
        .iter()
        .map(|text| serde_json::from_str(text).unwrap())
        .collect();
    let keys = [
        "source",
        "breakpoints",
        "filters",
        "threadId",
        "frameId",
        "variablesReference",
        "expression",
        "name",
        "value",
        "line",
        "cycle",
        "context",
        "start",
        "count",
        "levels",
        "drive",
        "arguments",
        "stopOnEntry",
        "linesStartAt1",
    ];
    for stage in ["before initialize", "before launch", "held", "over"] {
        let start = || match stage {
            "before initialize" => Client::new("x = 1\ny = 2\n"),
            "before launch" => {
                let mut client = Client::new("x = 1\ny = 2\n");
                client.ask("initialize", json!({}));
                client
            }
            _ => {
                let mut client = Client::launched(
                    "x = 1\ny = 2\n",
                    &[],
                    json!({"stopOnEntry": stage == "held"}),
                );
                match stage {
                    "held" => drop(client.held()),
                    _ => assert_eq!(client.try_held(), None),
                }
                client
            }
        };
        for command in REQUESTS {
            let mut client = start();
            for value in &odd {
                // Whatever it says, it says something.
                let _ = client.try_ask(command, value.clone());
            }
            let mut sent = Vec::new();
            for key in keys {
                for value in &odd {
                    let mut arguments = right(command);
                    arguments[key] = value.clone();
                    sent.push(client.send(command, arguments));
                }
            }
            for number in sent {
                let _ = client.response(number);
            }
            client.end();
        }
    }
}

#[test]
fn what_is_missing_or_of_another_kind_is_named() {
    let mut client = Client::launched("x = 1\ny = 2\n", &[], json!({"stopOnEntry": true}));
    client.held();
    for (command, key, wrong) in NEEDED {
        let mut arguments = right(command);
        arguments.as_object_mut().unwrap().remove(*key);
        let error = client.try_ask(command, arguments.clone()).unwrap_err();
        let said = format!("{command}: {key} is missing; it is ");
        assert!(error.starts_with(&said), "{error}");
        // What is no JSON is no argument either.
        arguments[*key] = serde_json::from_str(wrong).unwrap_or(json!("none"));
        let error = client.try_ask(command, arguments).unwrap_err();
        let said = format!("{command}: {key} is ");
        assert!(
            error.starts_with(&said) && error.contains("; allowed is "),
            "{error}"
        );
    }
    for (command, arguments, said) in [
        ("evaluate", json!([]), "evaluate: arguments is a list"),
        (
            "setBreakpoints",
            json!({"source": {"path": client.path}, "breakpoints": [{"line": 1}, {"line": "2"}]}),
            "setBreakpoints: breakpoints[1].line is \"2\"",
        ),
        (
            "setDataBreakpoints",
            json!({"breakpoints": [{"condition": "time > 1"}]}),
            "setDataBreakpoints: breakpoints[0].dataId is missing",
        ),
        (
            "completions",
            json!({"text": "x"}),
            "the request \"completions\" is not known here",
        ),
    ] {
        let error = client.try_ask(command, arguments).unwrap_err();
        assert!(error.starts_with(said), "{error}");
    }
    client.end();
}

#[test]
fn what_comes_too_early_or_too_late_is_refused() {
    let mut client = Client::new("x = 1\n");
    for command in REQUESTS {
        if !matches!(*command, "initialize" | "") {
            let error = client.try_ask(command, right(command)).unwrap_err();
            assert!(error.contains("before initialize"), "{command}: {error}");
        }
    }
    client.ask("initialize", json!({}));
    for command in [
        "continue",
        "next",
        "stepBack",
        "reverseContinue",
        "restartFrame",
        "stackTrace",
        "scopes",
        "variables",
        "evaluate",
        "setVariable",
        "setExpression",
        "exceptionInfo",
        "source",
        "breakpointLocations",
        "restart",
        "terminate",
        "gotoCycle",
        "nextNode",
    ] {
        let error = client.try_ask(command, right(command)).unwrap_err();
        assert_eq!(error, "no program was launched", "{command}");
    }
    assert_eq!(client.ask("loadedSources", json!({}))["sources"], json!([]));
    let error = client.try_ask("launch", json!({"program": client.path, "stopOnEntry": 1}));
    assert!(error.unwrap_err().starts_with("launch: stopOnEntry is 1;"));
    // A launch that waits for configurationDone is answered when the session ends before.
    let launch = client.send("launch", json!({"program": client.path}));
    client.ask("disconnect", json!({}));
    assert!(
        client
            .response(launch)
            .unwrap_err()
            .contains("configurationDone")
    );
    client.vanish();
}

#[test]
fn numbers_of_nothing_are_refused_by_name() {
    let program = "def work():\n    sleep(9)\nstart_thread(work, ())\nsleep(0.1)\nx = [1]\n";
    let mut client = Client::launched(program, &[json!({"line": 5})], json!({}));
    client.held();
    let threads = client.ask("threads", json!({}));
    assert_eq!(threads["threads"].as_array().unwrap().len(), 2);
    for (command, key) in [
        ("continue", "threadId"),
        ("next", "threadId"),
        ("stepIn", "threadId"),
        ("stepOut", "threadId"),
        ("nextNode", "threadId"),
        ("stepBack", "threadId"),
        ("reverseContinue", "threadId"),
        ("stackTrace", "threadId"),
        ("exceptionInfo", "threadId"),
        ("scopes", "frameId"),
        ("restartFrame", "frameId"),
        ("evaluate", "frameId"),
        ("setExpression", "frameId"),
        ("variables", "variablesReference"),
        ("setVariable", "variablesReference"),
    ] {
        for id in [0_u32, 77, u32::MAX] {
            let mut arguments = right(command);
            arguments[key] = json!(id);
            let error = client.try_ask(command, arguments).unwrap_err();
            assert!(
                error.contains(&format!("{key} {id}: there ")),
                "{command}: {error}"
            );
        }
    }
    // Nothing of it has let the program go on.
    assert_eq!(
        client
            .evaluate("x", "watch")
            .unwrap_err()
            .contains("NameError"),
        true
    );
    client.end();
}

#[test]
fn questions_that_a_run_leaves_open_are_answered_when_it_ends() {
    let mut client = Client::launched("x = 1\ny = 2\n", &[], json!({"stopOnEntry": true}));
    client.held();
    let waits = client.send(
        "evaluate",
        json!({"expression": "sleep(1e6)", "context": "repl"}),
    );
    client.ask("restart", json!({}));
    let error = client.response(waits).unwrap_err();
    assert!(error.contains("before it had answered"), "{error}");
    client.held();
    client.end();
}

#[test]
fn texts_that_cannot_be_understood_are_refused_and_change_nothing() {
    let lines = [
        json!({"line": 2, "condition": "x >"}),
        json!({"line": 2, "logMessage": "at {x +}"}),
        json!({"line": 2, "hitCondition": "often"}),
        json!({"line": 3}),
    ];
    let mut client = Client::launched("x = 1\ny = 2\nz = 3\n", &[], json!({"stopOnEntry": true}));
    client.held();
    let bound = client.set_breakpoints(&lines);
    for (place, said) in bound.iter().zip(["\"x >\"", "\"x +\"", "\"often\""]) {
        let message = place["message"].as_str().unwrap_or_default();
        assert!(
            place["verified"] == false && message.contains(said),
            "{place}"
        );
        assert!(message.contains("allowed "), "{place}");
    }
    let data = json!({"breakpoints": [{"dataId": "actual_q > 1"}, {"dataId": "time > 0.5", "condition": "tim > 1"}]});
    let data = client.ask("setDataBreakpoints", data);
    for place in data["breakpoints"].as_array().unwrap() {
        assert!(
            place["verified"] == false && place["message"].is_string(),
            "{place}"
        );
    }
    let function = json!({"breakpoints": [{"name": " "}]});
    let function = client.ask("setFunctionBreakpoints", function);
    assert_eq!(function["breakpoints"][0]["verified"], false);
    let held = client.go("continue");
    assert_eq!(held.line, 3);
    for context in ["watch", "hover", "variables", "clipboard"] {
        for text in ["x = 5", "x +", "", "del x"] {
            let error = client.evaluate(text, context).unwrap_err();
            assert!(error.contains("allowed is one expression"), "{error}");
        }
    }
    assert_eq!(client.evaluate("x", "watch").unwrap(), "1");
    let error = client.try_ask("setExpression", json!({"expression": "x", "value": "1 +"}));
    assert!(
        error
            .unwrap_err()
            .starts_with("setExpression: value is \"1 +\", which cannot be read")
    );
    client.end();
}
