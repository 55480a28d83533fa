//! A client for tests: sends messages to a session and picks the answers.

use editor::lsp::{LspSession, ServerOptions};
use serde_json::{Value, json};

/// The address of the text that tests open.
pub const URI: &str = "file:///programs/pick.script";

/// A client with one text open.
pub struct Client {
    pub session: LspSession,
    pub uri: String,
    number: i64,
}

impl Client {
    /// A client that has said `initialize` with these capabilities.
    pub fn with(capabilities: Value, locale: &str) -> Self {
        let mut client = Client {
            session: LspSession::new(&ServerOptions::default()),
            uri: URI.to_owned(),
            number: 0,
        };
        let params = json!({ "processId": null, "rootUri": null, "capabilities": capabilities, "locale": locale });
        let told = client.ask("initialize", params);
        assert_eq!(told["result"]["serverInfo"]["name"], "eliteserver");
        client.note("initialized", json!({}));
        client
    }

    /// A client that has opened `text`.
    pub fn of(text: &str) -> Self {
        let mut client = Self::with(json!({}), "en");
        client.open(text);
        client
    }

    pub fn open(&mut self, text: &str) {
        let document =
            json!({ "uri": self.uri, "languageId": "elitescript", "version": 1, "text": text });
        self.note("textDocument/didOpen", json!({ "textDocument": document }));
    }

    pub fn note(&mut self, method: &str, params: Value) -> Vec<Value> {
        self.session
            .take(json!({ "jsonrpc": "2.0", "method": method, "params": params }))
    }

    /// The whole answer to a request.
    pub fn ask(&mut self, method: &str, params: Value) -> Value {
        self.number += 1;
        let id = self.number;
        let request = json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": params });
        let answers = self.session.take(request);
        let mut own = answers.into_iter().filter(|answer| answer["id"] == id);
        own.next()
            .unwrap_or_else(|| panic!("{method} has no answer"))
    }

    /// The result of a request about a place.
    pub fn at(&mut self, method: &str, line: u32, character: u32) -> Value {
        let params = json!({ "textDocument": { "uri": self.uri }, "position": { "line": line,
            "character": character } });
        self.ask(method, params)["result"].take()
    }

    /// What a hover tells, or `nothing`.
    pub fn hover(&mut self, line: u32, character: u32) -> String {
        let told = self.at("textDocument/hover", line, character);
        let text = told["contents"]["value"].as_str();
        text.unwrap_or("nothing").to_owned()
    }

    /// The result of a request about the whole text.
    pub fn whole(&mut self, method: &str) -> Value {
        let everything = json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 100_000, "character": 0 } });
        let params = json!({
            "textDocument": { "uri": self.uri },
            "range": everything,
            "context": { "diagnostics": [] },
            "options": { "tabSize": 4, "insertSpaces": true },
        });
        self.ask(method, params)["result"].take()
    }

    /// Codes and first lines of the findings.
    pub fn findings(&mut self) -> Vec<(String, u64)> {
        let told = self.session.flush_diagnostics();
        let last = told
            .iter()
            .rfind(|m| m["method"] == "textDocument/publishDiagnostics");
        let all = last.map_or(Value::Null, |m| m["params"]["diagnostics"].clone());
        let all = all.as_array().cloned().unwrap_or_default();
        all.iter()
            .map(|d| {
                let code = d["code"].as_str().unwrap_or_default().to_owned();
                (
                    code,
                    d["range"]["start"]["line"].as_u64().unwrap_or_default(),
                )
            })
            .collect()
    }

    /// The labels of the completions at a place.
    pub fn completions(&mut self, line: u32, character: u32) -> Vec<String> {
        let found = self.at("textDocument/completion", line, character);
        let items = found["items"].as_array().cloned().unwrap_or_default();
        let labels = items.iter().filter_map(|item| item["label"].as_str());
        labels.map(str::to_owned).collect()
    }
}
