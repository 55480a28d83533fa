//! The life of a session, and messages that are not as they should be.

use editor::lsp::{LspSession, LspSessionEnd, ServerOptions, serve};
use serde_json::{Value, json};

use crate::client::{Client, URI};

fn code(answer: &Value) -> i64 {
    answer["error"]["code"].as_i64().unwrap_or_default()
}

#[test]
fn nothing_is_answered_before_initialize_and_after_shutdown() {
    let mut session = LspSession::new(&ServerOptions::default());
    let ask = |session: &mut LspSession, method: &str| {
        session.take(json!({ "jsonrpc": "2.0", "id": 1, "method": method, "params": {} }))[0]
            .clone()
    };
    assert_eq!(code(&ask(&mut session, "textDocument/hover")), -32002);
    let mut client = Client::of("x = 1\n");
    assert_eq!(
        code(&client.ask("initialize", json!({ "capabilities": {} }))),
        -32600
    );
    assert_eq!(code(&client.ask("no/such", json!({}))), -32601);
    assert_eq!(
        code(&client.ask("textDocument/hover", json!({ "position": 3 }))),
        -32602
    );
    assert_eq!(client.ask("shutdown", Value::Null)["result"], Value::Null);
    assert_eq!(code(&client.ask("textDocument/hover", json!({}))), -32600);
}

#[test]
fn columns_are_what_was_agreed() {
    let text = "# 𝄞位\n\"𝄞\"; spee = spex\n";
    let utf16 = |client: &mut Client| client.at("textDocument/definition", 1, 6);
    let mut client = Client::of(text);
    assert_eq!(utf16(&mut client)[0]["range"]["start"]["character"], 6);
    let bytes = json!({ "general": { "positionEncodings": ["utf-8", "utf-16"] } });
    let mut client = Client::with(bytes, "en");
    client.open(text);
    assert_eq!(
        client.at("textDocument/definition", 1, 8)[0]["range"]["start"]["character"],
        8
    );
}

#[test]
fn a_text_that_is_closed_has_no_findings_and_no_answers() {
    let mut client = Client::of("x = (\n");
    assert_eq!(client.findings().len(), 1);
    let told = client.note(
        "textDocument/didClose",
        json!({ "textDocument": { "uri": URI } }),
    );
    assert_eq!(told[0]["params"]["diagnostics"], json!([]));
    let params =
        json!({ "textDocument": { "uri": URI }, "position": { "line": 0, "character": 0 } });
    assert_eq!(code(&client.ask("textDocument/hover", params)), -32803);
}

#[test]
fn orders_about_unknown_texts_are_told_to_people() {
    let mut client = Client::of("");
    let change = json!({ "textDocument": { "uri": "file:///other", "version": 2 },
        "contentChanges": [{ "text": "" }] });
    let told = client.note("textDocument/didChange", change);
    assert_eq!(told[0]["method"], "window/logMessage");
}

fn framed(body: &str) -> String {
    format!("Content-Length: {}\r\n\r\n{body}", body.len())
}

fn served(input: String) -> (LspSessionEnd, String) {
    let mut output = Vec::new();
    let input = std::io::Cursor::new(input.into_bytes());
    let end = serve(input, &mut output, &ServerOptions::default()).unwrap();
    (end, String::from_utf8(output).unwrap())
}

#[test]
fn broken_frames_cost_a_message_and_not_the_session() {
    let begin =
        framed(r#"{"jsonrpc":"2.0","id":1,"method":"initialize","params":{"capabilities":{}}}"#);
    let broken = [
        "nonsense\r\n".to_owned(),
        "Content-Length: x\r\n\r\n".to_owned(),
        framed("{"),
        framed("[]"),
        framed("null"),
        framed("\"\u{feff}\""),
        "\r\n\r\n".to_owned(),
        format!("Content-Type: text\r\n{}", framed("7")),
        "a".repeat(20_000) + "\r\n",
    ];
    for broken in broken {
        let end = framed(r#"{"jsonrpc":"2.0","id":2,"method":"shutdown"}"#)
            + &framed(r#"{"jsonrpc":"2.0","method":"exit"}"#);
        let (how, told) = served(format!("{begin}{broken}{end}"));
        assert!(told.contains(r#""id":2"#), "{broken:.40}: {told}");
        assert_eq!(how, LspSessionEnd::Orderly);
    }
    let (how, _) = served(begin + "Content-Length: 100\r\n\r\n{");
    assert_eq!(how, LspSessionEnd::Vanished);
    let (how, told) = served("Content-Length: 99999999999999\r\n\r\n{}".to_owned());
    assert_eq!((how, told.len()), (LspSessionEnd::Vanished, 0));
}

#[test]
fn requests_that_are_taken_back_are_not_carried_out() {
    let mut input =
        framed(r#"{"jsonrpc":"2.0","id":1,"method":"initialize","params":{"capabilities":{}}}"#);
    input +=
        &framed(r#"{"jsonrpc":"2.0","id":"a","method":"workspace/symbol","params":{"query":""}}"#);
    input += &framed(r#"{"jsonrpc":"2.0","method":"$/cancelRequest","params":{"id":"a"}}"#);
    input += &framed(r#"{"jsonrpc":"2.0","id":2,"method":"shutdown"}"#);
    input += &framed(r#"{"jsonrpc":"2.0","method":"exit"}"#);
    let (how, told) = served(input);
    assert_eq!(how, LspSessionEnd::Orderly);
    // Taken back in time or not, it has exactly one answer.
    assert_eq!(told.matches(r#""id":"a""#).count(), 1, "{told}");
}
