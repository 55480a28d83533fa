//! `async` and `await` are names: the editor completes, explains, colours and renames them like others, and says where
//! they begin what the language has not.

use serde_json::{Value, json};

use crate::client::{Client, URI};

const PROGRAM: &str = "\
async = 1
def await(seconds, async=2):
    return seconds + async
class Line:
    def __init__(self):
        self.async = async
    def await(self, item): return self.async
line = Line()
print(await(1, async=async))
line.await(line.async)
";

/// The words of a text with the names of what they are.
fn colours(client: &mut Client, text: &str) -> Vec<(String, String)> {
    let told = client.whole("textDocument/semanticTokens/full");
    let data = told["data"].as_array().unwrap();
    let number = |value: &Value| value.as_u64().unwrap() as usize;
    let lines: Vec<&str> = text.split('\n').collect();
    let (mut line, mut column, mut shown) = (0, 0, Vec::new());
    for word in data.chunks(5) {
        column = number(&word[1]) + if number(&word[0]) == 0 { column } else { 0 };
        line += number(&word[0]);
        let kind = editor::analysis::semantic::SemanticTokenKind::NAMES[number(&word[3])];
        let word = &lines[line][column..column + number(&word[2])];
        shown.push((word.to_owned(), kind.to_owned()));
    }
    shown
}

#[test]
fn async_and_await_have_the_colours_of_names() {
    let mut client = Client::of(PROGRAM);
    assert_eq!(client.findings(), []);
    let mut shown = colours(&mut client, PROGRAM);
    shown.retain(|(word, _)| ["async", "await"].contains(&&**word));
    let kinds: Vec<&str> = shown.iter().map(|(_, kind)| &**kind).collect();
    assert_eq!(
        kinds,
        [
            "variable",
            "function",
            "parameter",
            "parameter",
            "property",
            "variable",
            "method",
            "property",
            "function",
            "parameter",
            "variable",
            "method",
            "property"
        ]
    );
}

#[test]
fn async_and_await_are_completed() {
    let text = format!("{PROGRAM}asy\nline.aw\nawait(as\n");
    let mut client = Client::of(&text);
    assert!(client.completions(10, 3).contains(&"async".to_owned()));
    assert!(client.completions(11, 7).contains(&"await".to_owned()));
    let call = client.completions(12, 8);
    assert!(
        call.contains(&"async=".to_owned()) && call.contains(&"async".to_owned()),
        "{call:?}"
    );
}

#[test]
fn a_call_of_await_has_a_signature() {
    let mut client = Client::of(&format!("{PROGRAM}await(1, \nline.await(\n"));
    let mut signature = |line, character| {
        let told = client.at("textDocument/signatureHelp", line, character);
        let label = told["signatures"][0]["label"].as_str().unwrap_or("none");
        (label.to_owned(), told["activeParameter"].as_u64())
    };
    assert_eq!(
        signature(10, 9),
        ("await(seconds, async=2)".to_owned(), Some(1))
    );
    assert_eq!(signature(11, 11).0, "await(item)");
}

#[test]
fn async_and_await_are_explained_found_and_renamed() {
    let mut client = Client::of(PROGRAM);
    assert!(client.hover(8, 7).contains("await(seconds, async=2)"));
    let place = client.at("textDocument/definition", 8, 7);
    assert!(place.to_string().contains("\"line\":1"), "{place}");
    let renamed = client.ask(
        "textDocument/rename",
        json!({"textDocument": {"uri": URI}, "position": {"line": 1, "character": 20}, "newName": "extra"}),
    );
    let edits = renamed.to_string();
    // The parameter, where it is used, and the keyword of the call.
    assert_eq!(edits.matches("extra").count(), 3, "{edits}");
}

#[test]
fn statements_of_coroutines_are_found() {
    for (text, line) in [
        ("async def f(): pass\n", 0),
        ("def f():\n    await sleep(1)\n", 1),
        ("async for x in []: pass\n", 0),
        ("async with a: pass\n", 0),
    ] {
        let mut client = Client::of(text);
        let findings = client.findings();
        assert_eq!(
            findings.first().map(|(_, line)| *line),
            Some(line),
            "{text}: {findings:?}"
        );
    }
}
