//! `eliteserver lsp` as editors start it: over pipes, with messages whose shapes are those of the protocol.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test helper fails by panicking"
)]

use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

use serde_json::{Value, json};

const URI: &str = "file:///programs/pick.script";

struct Client {
    child: Child,
    input: ChildStdin,
    output: BufReader<ChildStdout>,
    number: i64,
    noted: Vec<Value>,
}

impl Client {
    fn start(arguments: &[&str], initialize: Value) -> (Self, Value) {
        let mut child = Command::new(env!("CARGO_BIN_EXE_eliteserver"))
            .arg("lsp")
            .args(arguments)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (input, output) = (child.stdin.take().unwrap(), child.stdout.take().unwrap());
        let mut client = Client {
            child,
            input,
            output: BufReader::new(output),
            number: 0,
            noted: Vec::new(),
        };
        let told = client.ask("initialize", initialize);
        client.note("initialized", json!({}));
        (client, told)
    }

    fn send(&mut self, message: &Value) {
        let body = message.to_string();
        write!(self.input, "Content-Length: {}\r\n\r\n{body}", body.len()).unwrap();
        self.input.flush().unwrap();
    }

    fn receive(&mut self) -> Value {
        let mut length = 0;
        loop {
            let mut line = String::new();
            assert!(
                self.output.read_line(&mut line).unwrap() > 0,
                "the server has gone"
            );
            match line.trim_end().split_once(": ") {
                Some(("Content-Length", count)) => length = count.parse().unwrap(),
                Some(_) => {}
                None => break,
            }
        }
        let mut body = vec![0; length];
        self.output.read_exact(&mut body).unwrap();
        let message: Value = serde_json::from_slice(&body).unwrap();
        assert_eq!(message["jsonrpc"], "2.0");
        // A message is an answer with one of the two, or a note.
        match message.get("id") {
            Some(_) => assert!(message.get("result").is_some() != message.get("error").is_some()),
            None => assert!(message["method"].is_string() && message["params"].is_object()),
        }
        message
    }

    fn note(&mut self, method: &str, params: Value) {
        self.send(&json!({ "jsonrpc": "2.0", "method": method, "params": params }));
    }

    fn ask(&mut self, method: &str, params: Value) -> Value {
        self.number += 1;
        let id = self.number;
        self.send(&json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": params }));
        loop {
            let message = self.receive();
            if message["id"] == id {
                return message;
            }
            self.noted.push(message);
        }
    }

    fn findings(&mut self) -> Value {
        loop {
            let known = self
                .noted
                .iter()
                .position(|m| m["method"] == "textDocument/publishDiagnostics");
            let message = match known {
                Some(at) => self.noted.remove(at),
                None => self.receive(),
            };
            if message["method"] == "textDocument/publishDiagnostics" {
                return message["params"].clone();
            }
        }
    }

    fn open(&mut self, text: &str) {
        let document =
            json!({ "uri": URI, "languageId": "elitescript", "version": 1, "text": text });
        self.note("textDocument/didOpen", json!({ "textDocument": document }));
    }

    fn leave(mut self) -> i32 {
        assert_eq!(self.ask("shutdown", Value::Null)["result"], Value::Null);
        self.note("exit", Value::Null);
        self.child.wait().unwrap().code().unwrap()
    }
}

fn plain() -> Value {
    json!({ "processId": std::process::id(), "rootUri": null, "capabilities": {} })
}

#[test]
fn a_session_from_initialize_to_exit() {
    let (mut client, told) = Client::start(&["--stdio"], plain());
    let can = &told["result"]["capabilities"];
    assert_eq!(can["positionEncoding"], "utf-16");
    assert_eq!(
        can["textDocumentSync"],
        json!({ "openClose": true, "change": 2 })
    );
    for ability in [
        "hover",
        "definition",
        "references",
        "documentHighlight",
        "documentSymbol",
        "workspaceSymbol",
        "foldingRange",
        "inlayHint",
        "documentFormatting",
    ] {
        assert_eq!(can[format!("{ability}Provider")], true, "{ability}");
    }
    client.open("def f():\n    movej([0, -90, 0, 0, 0, 0])\nf()\n");
    let found = client.findings();
    assert_eq!(found["uri"], URI);
    assert_eq!(found["diagnostics"][0]["code"], "degrees");
    client.note("textDocument/didChange", json!({
        "textDocument": { "uri": URI, "version": 2 },
        "contentChanges": [{ "range": { "start": { "line": 1, "character": 14 }, "end": { "line": 1,
            "character": 17 } }, "text": "0" }],
    }));
    let found = client.findings();
    assert_eq!(
        (&found["version"], &found["diagnostics"]),
        (&json!(2), &json!([]))
    );
    let place =
        json!({ "textDocument": { "uri": URI }, "position": { "line": 1, "character": 6 } });
    let hover = client.ask("textDocument/hover", place.clone());
    assert!(
        hover["result"]["contents"]["value"]
            .as_str()
            .unwrap()
            .contains("Manual 3.1")
    );
    let completion = client.ask("textDocument/completion", place);
    let items = completion["result"]["items"].as_array().unwrap();
    for item in items {
        assert!(
            item["label"].is_string()
                && item["kind"].is_u64()
                && item["textEdit"]["range"].is_object(),
            "{item}"
        );
    }
    assert!(items.iter().any(|item| item["label"] == "movej"));
    assert_eq!(client.leave(), 0);
}

#[test]
fn texts_are_in_the_language_that_was_asked_for() {
    let place =
        json!({ "textDocument": { "uri": URI }, "position": { "line": 0, "character": 2 } });
    let (mut client, _) = Client::start(&["--language", "zh"], plain());
    client.open("movej()\n");
    assert!(
        client.ask("textDocument/hover", place.clone())["result"]
            .to_string()
            .contains("手册 3.1")
    );
    assert_eq!(client.leave(), 0);
    let mut chinese = plain();
    chinese["locale"] = json!("zh-cn");
    let (mut client, _) = Client::start(&[], chinese);
    client.open("movej()\n");
    assert!(
        client.ask("textDocument/hover", place)["result"]
            .to_string()
            .contains("参数")
    );
    assert_eq!(client.leave(), 0);
}

#[test]
fn the_server_goes_with_its_client() {
    let (client, _) = Client::start(&[], plain());
    let Client {
        mut child,
        input,
        output,
        ..
    } = client;
    drop((input, output));
    assert_eq!(child.wait().unwrap().code(), Some(1));
    // A client that is gone but whose pipe is held open by another.
    let mut gone = Command::new("true").spawn().unwrap();
    let number = gone.id();
    gone.wait().unwrap();
    let mut params = plain();
    params["processId"] = json!(number);
    let (client, _) = Client::start(&[], params);
    let Client {
        mut child,
        input: _held,
        output: _kept,
        ..
    } = client;
    assert_eq!(child.wait().unwrap().code(), Some(1));
}

#[test]
fn symbols_of_files_that_are_not_open_are_found() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(
        folder.path().join("other.script"),
        "def polish():\n    pass\n",
    )
    .unwrap();
    let mut params = plain();
    params["rootUri"] = json!(format!("file://{}", folder.path().display()));
    let (mut client, _) = Client::start(&[], params);
    let found = client.ask("workspace/symbol", json!({ "query": "POLI" }));
    assert_eq!(found["result"][0]["name"], "polish");
    assert!(
        found["result"][0]["location"]["uri"]
            .as_str()
            .unwrap()
            .ends_with("/other.script")
    );
    assert_eq!(client.leave(), 0);
}

#[test]
fn neovim_is_set_up_by_the_lines_of_the_docs() {
    let nvim = Command::new("nvim")
        .arg("--version")
        .stdout(Stdio::null())
        .status();
    if nvim.is_err() {
        // Not on this machine.
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    file("init.lua", lines_of_the_docs("lua"));
    file(
        "pick.script",
        "def pick():\n    movej([0, -90, 0, 0, 0, 0])\npick()\n",
    );
    file(
        "probe.lua",
        r#"
vim.wait(60000, function() return #vim.diagnostic.get(0) > 0 end, 20)
for _, found in ipairs(vim.diagnostic.get(0)) do print("found", found.code) end
local place = { textDocument = { uri = vim.uri_from_bufnr(0) }, position = { line = 1, character = 6 } }
for _, told in pairs(vim.lsp.buf_request_sync(0, "textDocument/hover", place, 60000) or {}) do
  print("told", told.result.contents.value)
end
vim.cmd("qa!")
"#,
    );
    let output = Command::new("nvim")
        .args([
            "--headless",
            "-u",
            "init.lua",
            "pick.script",
            "-c",
            "luafile probe.lua",
        ])
        .current_dir(folder.path())
        .env("PATH", path_with_the_program())
        .env("XDG_STATE_HOME", folder.path())
        .env("XDG_DATA_HOME", folder.path())
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr).into_owned()
        + &String::from_utf8_lossy(&output.stdout);
    assert!(
        told.contains("found degrees") && told.contains("movej(q,"),
        "{told}"
    );
}

/// The lines of docs/editors.md in a block of this language.
fn lines_of_the_docs(language: &str) -> &'static str {
    let docs = include_str!("../docs/editors.md");
    let (_, rest) = docs.split_once(&format!("```{language}\n")).unwrap();
    rest.split_once("```").unwrap().0
}

/// The PATH with the program under test before everything else.
fn path_with_the_program() -> String {
    let binary = std::path::Path::new(env!("CARGO_BIN_EXE_eliteserver"));
    let folder = binary.parent().unwrap().display();
    format!("{folder}:{}", std::env::var("PATH").unwrap())
}

#[test]
fn emacs_is_set_up_by_the_lines_of_the_docs() {
    // Before 29 eglot is a package, which an editor that is started with a window finds by itself.
    let emacs = || {
        let mut command = Command::new("emacs");
        command.args(["--batch", "-f", "package-activate-all"]);
        command
    };
    let asked = emacs().args(["--eval", "(require 'eglot)"]).output();
    if !asked.is_ok_and(|told| told.status.success()) {
        // Not on this machine.
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    file("init.el", lines_of_the_docs("elisp"));
    file(
        "pick.script",
        "def pick():\n    movej([0, -90, 0, 0, 0, 0])\npick()\n",
    );
    file(
        "probe.el",
        r#"
(find-file "pick.script")
;; What the editor does by itself after each command.
(run-hooks 'post-command-hook)
(let ((waited 0))
  (while (and (< waited 600) (not (and (eglot-managed-p) (flymake-diagnostics))))
    (accept-process-output nil 0.1)
    (when (eglot-managed-p) (flymake-start))
    (setq waited (1+ waited))))
(dolist (found (flymake-diagnostics)) (message "found %s" (flymake-diagnostic-text found)))
(let ((told (jsonrpc-request (eglot-current-server) :textDocument/hover
              (list :textDocument (eglot--TextDocumentIdentifier) :position '(:line 1 :character 6)))))
  (message "told %s" (plist-get (plist-get told :contents) :value)))
(eglot-shutdown (eglot-current-server))
"#,
    );
    let output = emacs()
        .args(["-l", "init.el", "-l", "probe.el"])
        .current_dir(folder.path())
        .env("PATH", path_with_the_program())
        .env("HOME", folder.path())
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(
        told.contains("found ") && told.contains("radians") && told.contains("movej(q,"),
        "{told}"
    );
}

#[test]
fn the_lines_for_helix_have_the_keys_of_its_manual() {
    // docs.helix-editor.com/languages.html
    const LANGUAGE: [&str; 22] = [
        "name",
        "language-id",
        "scope",
        "injection-regex",
        "file-types",
        "shebangs",
        "roots",
        "auto-format",
        "diagnostic-severity",
        "comment-tokens",
        "block-comment-tokens",
        "indent",
        "language-servers",
        "grammar",
        "formatter",
        "soft-wrap",
        "text-width",
        "rulers",
        "path-completion",
        "workspace-lsp-roots",
        "persistent-diagnostic-sources",
        "debugger",
    ];
    const SERVER: [&str; 6] = [
        "command",
        "args",
        "config",
        "timeout",
        "environment",
        "required-root-patterns",
    ];
    let table: toml::Table = lines_of_the_docs("toml").parse().unwrap();
    let known =
        |table: &toml::Table, keys: &[&str]| table.keys().all(|key| keys.contains(&key.as_str()));
    assert!(known(&table, &["language-server", "language"]));
    let servers = table["language-server"].as_table().unwrap();
    let server = servers["eliteserver"].as_table().unwrap();
    assert!(known(server, &SERVER));
    let command = server["command"].as_str().unwrap();
    let arguments = server["args"].as_array().unwrap();
    assert_eq!(
        (command, arguments[0].as_str()),
        ("eliteserver", Some("lsp"))
    );
    for language in table["language"].as_array().unwrap() {
        let language = language.as_table().unwrap();
        assert!(known(language, &LANGUAGE), "{language}");
        assert!(known(
            language["indent"].as_table().unwrap(),
            &["tab-width", "unit"]
        ));
        for name in language["language-servers"].as_array().unwrap() {
            assert!(servers.contains_key(name.as_str().unwrap()));
        }
    }
}

#[test]
fn the_lines_for_zed_are_settings_that_it_documents() {
    // zed.dev/docs/configuring-languages
    let settings: Value = serde_json::from_str(lines_of_the_docs("json")).unwrap();
    let keys: Vec<&String> = settings.as_object().unwrap().keys().collect();
    assert_eq!(keys, ["file_types", "languages", "lsp"]);
    let languages = settings["languages"].as_object().unwrap();
    for (language, endings) in settings["file_types"].as_object().unwrap() {
        assert_eq!(endings, &json!(["script"]));
        let servers = languages[language]["language_servers"].as_array().unwrap();
        for server in servers {
            let binary = &settings["lsp"][server.as_str().unwrap()]["binary"];
            assert_eq!(
                binary,
                &json!({ "path": "eliteserver", "arguments": ["lsp"] })
            );
        }
    }
}

/// What a command says about a program, on both of its streams.
fn said(command: &[&str], variables: &[(&str, &str)], program: &str) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("pick.script");
    std::fs::write(&path, program).unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_eliteserver"))
        .args(command)
        .arg(&path)
        .env_remove("LC_ALL")
        .env_remove("LC_MESSAGES")
        .env_remove("LANG")
        .envs(variables.iter().copied())
        .output()
        .unwrap();
    let mut said = String::from_utf8(output.stdout).unwrap();
    said.push_str(&String::from_utf8(output.stderr).unwrap());
    said
}

#[test]
fn findings_and_errors_are_in_chinese_where_that_is_wanted() {
    let broken = "if x\n    pass\n";
    let chinese = "应为'if' 条件之后的 ':'，却是行尾";
    let english = "expected ':' after the 'if' condition, found the end of the line";
    let says = |command: &[&str], variables: &[(&str, &str)], text: &str| {
        let told = said(command, variables, broken);
        assert!(told.contains(text), "{command:?} {variables:?}: {told}");
    };
    says(&["check"], &[], english);
    says(&["check", "--language", "zh"], &[], chinese);
    // What programs read is the same in every language.
    says(
        &["check", "--format", "json", "--language", "zh"],
        &[],
        english,
    );
    says(&["check"], &[("LANG", "zh_CN.UTF-8")], chinese);
    says(
        &["check"],
        &[("LANG", "zh_CN.UTF-8"), ("LC_ALL", "C")],
        english,
    );
    says(
        &["check", "--language", "en"],
        &[("LANG", "zh_CN.UTF-8")],
        english,
    );
    says(&["run", "--language", "zh"], &[], chinese);
    let told = said(&["run", "--language", "zh"], &[], "movej(1)\n");
    // The type stays, and so does the picture.
    assert!(
        told.contains("TypeError: movej()：q 必须是六个关节位置（rad），不能是 int（1）"),
        "{told}"
    );
    let own = said(&["run", "--language", "zh"], &[], "print([1][2])\n");
    assert!(own.contains("IndexError: list index out of range"), "{own}");
}
