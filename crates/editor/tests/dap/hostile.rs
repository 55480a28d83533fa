//! Clients that do not keep to the protocol, or go away.

use serde_json::json;

use crate::client::Client;

#[test]
fn what_is_no_message_is_told_or_ends_the_session() {
    let mut client = Client::new("x = 1\n");
    client.send_bytes(b"Content-Length: 4\r\n\r\n{}}}");
    assert!(
        client.event("output")["output"]
            .as_str()
            .unwrap()
            .contains("JSON")
    );
    client.send_bytes(b"Content-Length: 2\r\n\r\n[]");
    client.send_bytes(b"Content-Length: 18\r\n\r\n{\"type\":\"request\"}");
    let refused = client.wait(|m| m["type"] == "response");
    assert_eq!(refused["success"], false);
    client.ask("initialize", json!({}));
    for command in [
        "dance",
        "stackTrace",
        "next",
        "stepBack",
        "reverseContinue",
        "gotoCycle",
        "attach",
        "source",
    ] {
        let error = client.try_ask(command, json!({"threadId": 1}));
        assert!(!error.unwrap_err().is_empty(), "{command}");
    }
    let error = client.try_ask(
        "setBreakpoints",
        json!({"source": {}, "breakpoints": [{"line": -3}]}),
    );
    assert!(error.unwrap_err().contains("breakpoints"));
    let error = client.try_ask("launch", json!({"program": "/nowhere.script"}));
    assert!(error.is_err());
    client.send_bytes(b"Content-Length: 99999999999999\r\n\r\n");
    client.vanish();
    let mut client = Client::new("x = 1\n");
    client.send_bytes(&[b'z'; 100_000]);
    client.vanish();
}

#[test]
fn questions_about_what_is_not_there_get_sentences() {
    let mut client = Client::launched("x = [1]\ny = 2\n", &[], json!({"stopOnEntry": true}));
    client.held();
    for (command, arguments) in [
        ("variables", json!({"variablesReference": 77})),
        ("scopes", json!({"frameId": 99})),
        ("variables", json!({"variablesReference": "x"})),
        ("evaluate", json!({"expression": ""})),
        ("evaluate", json!({"expression": "(", "context": "repl"})),
        (
            "evaluate",
            json!({"expression": "while True: pass", "context": "repl"}),
        ),
        ("gotoCycle", json!({})),
        ("exceptionInfo", json!({"threadId": 1})),
        ("launch", json!({"program": "again"})),
        ("stackTrace", json!({"threadId": 12})),
    ] {
        let error = client.try_ask(command, arguments.clone());
        assert!(error.is_err(), "{command} {arguments}");
    }
    client.end();
}

#[test]
fn the_program_ends_with_its_client() {
    for lines in [&[json!({"line": 2})][..], &[]] {
        let mut client = Client::launched("while True:\n    sleep(0.1)\n", lines, json!({}));
        if !lines.is_empty() {
            client.held();
        }
        client.vanish();
    }
    let mut client = Client::launched("while True: print(1)\n", &[], json!({}));
    client.event("output");
    client.vanish();
    let mut client = Client::launched("x = 1 +\n", &[], json!({}));
    assert_eq!(client.try_held(), None);
    assert_eq!(client.event("exited")["exitCode"], 2);
    client.end();
}
