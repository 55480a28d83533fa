//! The language server: bytes on its stream, and texts that are edited at random. The lines of the server for
//! assistants.

use editor::lsp::{LspSession, ServerOptions, serve};
use serde_json::{Value, json};
use server::commands::mcp::lines::{IncomingLine, read};

use super::{Target, as_they_are};
use crate::programs::{Theme, program};
use crate::unstructured::Unstructured;

pub(super) const TARGETS: &[Target] = &[
    Target {
        name: "lsp",
        about: "the stream of the language server: frames, JSON, methods",
        check: |data| {
            let input = std::io::Cursor::new(data.to_vec());
            _ = serve(input, &mut Vec::new(), &ServerOptions::default());
        },
        render_input: as_they_are,
        seeds: || vec![conversation()],
        words: &[
            b"Content-Length: ",
            b"\r\n\r\n",
            b"\"jsonrpc\":\"2.0\"",
            b"\"id\":",
            b"\"method\":",
            b"\"params\":",
            b"null",
            b"4294967295",
            b"\"range\":",
            b"$/cancelRequest",
        ],
        bytes_max: 20_000,
    },
    Target {
        name: "lsp_edits",
        about: "texts that are edited at random answer as those that were opened just now",
        check: edits,
        render_input: as_they_are,
        seeds: || {
            (0..64u8)
                .map(|k| (0..120).map(|n| k.wrapping_mul(31) ^ n).collect())
                .collect()
        },
        words: &[],
        bytes_max: 400,
    },
    Target {
        name: "mcp",
        about: "a line of the server for assistants: JSON, JSON-RPC, methods",
        check: assistant_line,
        render_input: as_they_are,
        seeds: || {
            let arguments =
                json!({ "program": "movej(q)\n", "time": 5.5, "home": [0, 1, 2, 3, 4, 5] });
            let lines = [
                json!({ "jsonrpc": "2.0", "id": 1, "method": "initialize", "params": {
                    "protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": { "name": "a", "version": "1" },
                } }),
                json!({ "jsonrpc": "2.0", "id": "a", "method": "tools/call", "params": { "name": "run",
                    "arguments": arguments } }),
                json!({ "jsonrpc": "2.0", "method": "notifications/cancelled", "params": { "requestId": 1 } }),
                json!({ "jsonrpc": "2.0", "id": 3, "result": {} }),
            ];
            lines
                .iter()
                .map(|line| line.to_string().into_bytes())
                .collect()
        },
        words: &[
            b"\"jsonrpc\":\"2.0\"",
            b"\"id\":",
            b"\"method\":",
            b"\"params\":",
            b"\"_meta\":",
            b"null",
            b"1e999",
            b"tools/list",
            b"notifications/",
            b"\xEF\xBB\xBF",
        ],
        bytes_max: 20_000,
    },
];

/// A line is a message, nothing, or answered with an error that a client can read.
fn assistant_line(data: &[u8]) {
    if let IncomingLine::Wrong(answer) = read(data) {
        let answer = serde_json::to_value(&*answer).unwrap_or_default();
        assert_eq!(answer["jsonrpc"], "2.0", "{answer}");
        assert!(answer["error"]["code"].is_i64(), "{answer}");
        assert!(
            !answer["error"]["message"]
                .as_str()
                .unwrap_or_default()
                .is_empty()
        );
    }
}

const URI: &str = "file:///fuzz.script";

fn framed(message: &Value) -> Vec<u8> {
    let body = message.to_string();
    format!("Content-Length: {}\r\n\r\n{body}", body.len()).into_bytes()
}

fn initialize() -> Value {
    json!({ "jsonrpc": "2.0", "id": 0, "method": "initialize", "params": { "capabilities": {} } })
}

fn opened(text: &str) -> Value {
    let document = json!({ "uri": URI, "languageId": "elitescript", "version": 1, "text": text });
    json!({ "jsonrpc": "2.0", "method": "textDocument/didOpen", "params": { "textDocument": document } })
}

/// What can be asked of a place in a text.
fn questions(line: usize, character: usize) -> Vec<Value> {
    let methods = [
        "hover",
        "completion",
        "signatureHelp",
        "definition",
        "references",
        "documentHighlight",
        "prepareRename",
        "rename",
        "documentSymbol",
        "foldingRange",
        "semanticTokens/full",
        "semanticTokens/range",
        "inlayHint",
        "codeAction",
        "formatting",
    ];
    let ask = |(id, method): (usize, &str)| {
        let end = json!({ "line": line + 3, "character": character });
        let place = json!({ "line": line, "character": character });
        let params = json!({
            "textDocument": { "uri": URI },
            "position": place,
            "range": { "start": place, "end": end },
            "context": { "diagnostics": [], "includeDeclaration": true },
            "options": { "tabSize": 4, "insertSpaces": true },
            "newName": "other",
        });
        json!({ "jsonrpc": "2.0", "id": id + 1, "method": format!("textDocument/{method}"), "params": params })
    };
    methods.into_iter().enumerate().map(ask).collect()
}

/// A whole session that is right.
fn conversation() -> Vec<u8> {
    let mut messages = vec![initialize(), opened("def f(a):\n    movej(a, 1)\nf(1)\n")];
    messages.push(json!({ "jsonrpc": "2.0", "method": "textDocument/didChange", "params": {
        "textDocument": { "uri": URI, "version": 2 },
        "contentChanges": [{ "range": { "start": { "line": 1, "character": 4 }, "end": { "line": 1, "character": 9 } },
            "text": "movel" }],
    } }));
    messages.extend(questions(1, 6));
    messages.push(json!({ "jsonrpc": "2.0", "id": 99, "method": "shutdown" }));
    messages.push(json!({ "jsonrpc": "2.0", "method": "exit" }));
    messages.iter().flat_map(framed).collect()
}

const WRITTEN: &[&str] = &[
    "",
    "x",
    ".",
    "(",
    ")",
    "\n",
    "    ",
    "def g(",
    "\"",
    "\"\"\"",
    ":",
    "movej(",
    "class C:\n",
    "end",
    ";",
    "\r\n",
    "𝄞",
    "#",
    "$ ",
    "=",
    "f\"{",
    "}",
    "[",
    "]",
    ", ",
    "import ",
    "\\",
    "\t",
    "sec s():\n",
    "lambda ",
    "end\n",
    "global x\n",
];

fn edits(data: &[u8]) {
    let mut material = Unstructured::new(data);
    let themes = [Theme::Containers, Theme::Chains, Theme::Growth];
    let theme = themes[material.below(themes.len())];
    let first = program(theme, &data[..data.len() / 2]);
    let mut session = LspSession::new(&ServerOptions::default());
    session.take(initialize());
    session.take(opened(&first));
    let mut lines: Vec<Vec<char>> = first
        .split('\n')
        .map(|line| line.chars().collect())
        .collect();
    let mut version = 1;
    while !material.is_used_up() {
        // Places that exist, so that the text can be followed here without the server's own arithmetic.
        let line = material.below(lines.len().min(256));
        let column = material.below(lines[line].len().min(255) + 1);
        let gone = material.below(4).min(lines[line].len() - column);
        let written = material.pick(WRITTEN);
        let units = |chars: &[char]| chars.iter().map(|c| c.len_utf16()).sum::<usize>();
        let (start, end) = (
            units(&lines[line][..column]),
            units(&lines[line][..column + gone]),
        );
        version += 1;
        session.take(json!({ "jsonrpc": "2.0", "method": "textDocument/didChange", "params": {
            "textDocument": { "uri": URI, "version": version },
            "contentChanges": [{
                "range": { "start": { "line": line, "character": start }, "end": { "line": line, "character": end } },
                "text": written,
            }],
        } }));
        // Typing pauses now and then, and the text is read again with what it was.
        if material.below(2) == 0 {
            session.flush_diagnostics();
        }
        let after: String = lines[line][column + gone..].iter().collect();
        let before: String = lines[line][..column].iter().collect();
        let changed = format!("{before}{written}{after}");
        let changed: Vec<Vec<char>> = changed
            .split('\n')
            .map(|line| line.chars().collect())
            .collect();
        lines.splice(line..=line, changed);
        // A carriage return of its own would end a line there and not here.
        if lines
            .iter()
            .any(|line| line.iter().rev().skip(1).any(|c| *c == '\r'))
        {
            return;
        }
    }
    let text: Vec<String> = lines.iter().map(|line| line.iter().collect()).collect();
    let mut fresh = LspSession::new(&ServerOptions::default());
    fresh.take(initialize());
    fresh.take(opened(&text.join("\n")));
    for question in questions(material.below(8), material.below(20)) {
        let (one, other) = (session.take(question.clone()), fresh.take(question));
        assert_eq!(one, other);
        assert!(
            one.iter().all(|told| told["error"]["code"] != -32603),
            "{one:?}"
        );
    }
}
