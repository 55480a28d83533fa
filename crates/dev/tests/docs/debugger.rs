//! Sessions of the debugger as pages show them: `→` is sent, `←` comes back.
//!
//! An answer in a page shows some fields; the debugger's has at least these. Events are waited for, answers to requests
//! belong to the newest request.

use std::io::{BufReader, Write};
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use editor::dap::stream::{self, DapInput};
use serde_json::{Value as Json, json};

/// Holds the session; programs are in the folder, whatever folder the page names before them.
pub fn session(text: &str, folder: &Path, place: &str) {
    let mut child = Command::new(crate::markdown::eliteserver())
        .arg("debug")
        .current_dir(folder)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let (heard, from) = channel();
    let mut output = BufReader::new(child.stdout.take().unwrap());
    let reader = std::thread::spawn(move || {
        while let Ok(Some(DapInput::Message(message))) = stream::read(&mut output) {
            if heard.send(message).is_err() {
                break;
            }
        }
    });
    let mut client = Client {
        to: child.stdin.take().unwrap(),
        from,
        waiting: Vec::new(),
        sent: 0,
    };
    for line in text.lines() {
        let (sign, rest) = line.split_once(' ').unwrap_or((line, ""));
        let mut shown: Json =
            serde_json::from_str(rest).unwrap_or_else(|error| panic!("{place}: {line}: {error}"));
        settle(&mut shown, folder);
        match sign {
            "→" => client.send(&shown),
            "←" => client.expect(&shown, &format!("{place}: {line}")),
            _ => panic!("{place}: {line}"),
        }
    }
    client.send(&json!({"command": "disconnect"}));
    drop(client);
    reader.join().unwrap();
    assert!(
        child.wait().unwrap().success(),
        "{place}: how the debugger ended"
    );
}

/// Paths of pages (`/tmp/sum.script`) lie in the folder of the walk.
fn settle(shown: &mut Json, folder: &Path) {
    match shown {
        Json::String(text) => {
            if let Some(name) = text.strip_prefix("/tmp/") {
                *text = folder.join(name).to_str().unwrap().to_owned();
            }
        }
        Json::Array(items) => items.iter_mut().for_each(|item| settle(item, folder)),
        Json::Object(fields) => fields.values_mut().for_each(|item| settle(item, folder)),
        _ => {}
    }
}

struct Client<W> {
    to: W,
    from: Receiver<Json>,
    /// Events that nobody has asked for yet.
    waiting: Vec<Json>,
    sent: i64,
}

impl<W: Write> Client<W> {
    fn send(&mut self, shown: &Json) {
        self.sent += 1;
        let mut message = shown.clone();
        message["seq"] = self.sent.into();
        message["type"] = "request".into();
        stream::write(&mut self.to, &message).unwrap();
    }

    fn expect(&mut self, shown: &Json, place: &str) {
        let is_event = shown.get("event").is_some();
        loop {
            if is_event && let Some(at) = self.waiting.iter().position(|event| holds(event, shown))
            {
                self.waiting.drain(..=at);
                return;
            }
            let Ok(message) = self.from.recv_timeout(Duration::from_secs(60)) else {
                panic!("{place}: nothing comes any more; heard: {:?}", self.waiting);
            };
            if message["type"] == "event" {
                self.waiting.push(message);
            } else if message["success"] != true {
                panic!("{place}: {message}");
            } else if !is_event && message["request_seq"] == self.sent {
                assert!(
                    holds(&message["body"], shown),
                    "{place}: it said {}",
                    message["body"]
                );
                return;
            }
        }
    }
}

/// Whether everything that is shown is there.
fn holds(whole: &Json, shown: &Json) -> bool {
    match (whole, shown) {
        (Json::Object(whole), Json::Object(shown)) => shown
            .iter()
            .all(|(name, value)| whole.get(name).is_some_and(|found| holds(found, value))),
        (Json::Array(whole), Json::Array(shown)) => {
            whole.len() == shown.len() && whole.iter().zip(shown).all(|(a, b)| holds(a, b))
        }
        _ => whole == shown,
    }
}
