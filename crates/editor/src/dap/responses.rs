//! What a session says to its client: responses, events, output, and where the program's text is.

use messages::{Text, text};
use serde_json::{Value as Json, json};

use super::bodies::{OutputEvent, body_of};
use super::session::DapSession;

impl DapSession<'_> {
    pub(super) fn source(&self) -> Result<Json, Text> {
        let launched = self
            .launched
            .as_ref()
            .ok_or(text!("no program was launched", "没有启动程序"))?;
        Ok(json!({"content": launched.program.text}))
    }

    pub(super) fn source_body(&self) -> Json {
        let Some(launched) = &self.launched else {
            return json!({});
        };
        let name = launched.path.file_name().map(|name| name.to_string_lossy());
        match launched.is_on_disk {
            true => json!({"name": name, "path": launched.path}),
            false => match self.wanted_path() {
                Some(path) => json!({"name": name, "path": path}),
                None => json!({"name": launched.program.name, "sourceReference": 1}),
            },
        }
    }

    /// The file that the client knows an attached program by.
    fn wanted_path(&self) -> Option<&std::path::Path> {
        self.attachment.as_ref()?;
        let mut paths = self.wanted_sources.iter().map(|wanted| &*wanted.path);
        paths.find(|path| self.is_program(path))
    }

    /// Whether a file is the text of the program; of a program of another machine only the name of the file tells.
    pub(super) fn is_program(&self, path: &std::path::Path) -> bool {
        self.launched.as_ref().is_some_and(|launched| {
            let is_named_so =
                || path.file_name().is_some() && path.file_name() == launched.path.file_name();
            path == launched.path || self.attachment.is_some() && is_named_so()
        })
    }

    pub(super) fn output(&mut self, category: &str, text: &Text, line: u32) {
        let place = (line > 0).then(|| (self.source_body(), i64::from(line) - 1 + self.first_line));
        let (source, line) = place.unzip();
        let event = OutputEvent {
            category,
            output: text.in_language(self.language),
            source,
            line,
        };
        self.event("output", body_of(&event));
    }

    pub(super) fn respond(&mut self, request: &(i64, String), result: Result<Json, Text>) {
        let (number, command) = request;
        let mut message = json!({
            "type": "response",
            "request_seq": number,
            "command": command,
            "success": result.is_ok(),
        });
        if let Json::Object(fields) = &mut message {
            match result {
                Ok(body) => {
                    fields.insert("body".to_owned(), body);
                }
                Err(text) => {
                    let text = text.in_language(self.language);
                    fields.insert("message".to_owned(), json!(text));
                    let error = json!({"error": {"id": 1, "format": text, "showUser": true}});
                    fields.insert("body".to_owned(), error);
                }
            }
        }
        self.send(message);
    }

    pub(super) fn event(&mut self, name: &str, body: Json) {
        self.send(json!({"type": "event", "event": name, "body": body}));
    }

    pub(super) fn send(&mut self, mut message: Json) {
        self.seq += 1;
        if let Json::Object(fields) = &mut message {
            fields.insert("seq".to_owned(), json!(self.seq));
        }
        // Nobody reads: the session is over.
        if self.out.message(&message).is_err() {
            self.is_done = true;
        }
    }
}
