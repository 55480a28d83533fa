//! What the server keeps between messages, and the life of a session: `initialize`, texts that come and go, `shutdown`.

use std::collections::{HashSet, VecDeque};
use std::path::PathBuf;
use std::time::Instant;

use ls_types::{
    DidChangeTextDocumentParams, DidCloseTextDocumentParams, DidOpenTextDocumentParams,
    InitializeParams, PositionEncodingKind,
};
use lsp_server::{ErrorCode, Message, Notification, Request, RequestId};
use messages::Localized;
use platform::machine;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::documents::Documents;
use super::frames::LspInput;
use super::positions::Encoding;
use super::{LspSessionEnd, ServerOptions, capabilities, diagnostics, requests};
use crate::analysis::library;
use crate::analysis::words::Language;

/// Requests whose cancellation came before they did, at most.
const CANCELLED_MAX: usize = 1000;

/// A reason why a request gets no answer.
#[derive(Debug)]
pub struct RequestError {
    /// The number of the protocol.
    pub code: ErrorCode,
    /// A sentence.
    pub message: String,
}

impl RequestError {
    /// The request cannot be carried out.
    pub fn failed(error: &impl Localized, language: Language) -> Self {
        RequestError {
            code: ErrorCode::RequestFailed,
            message: error.in_language(language).to_string(),
        }
    }
}

/// A session.
pub struct LanguageServer {
    /// The texts.
    pub documents: Documents,
    /// The language of texts.
    pub language: Language,
    /// The folders that the client works in.
    pub folders: Vec<PathBuf>,
    options: ServerOptions,
    phase: ServerPhase,
    client: Option<u32>,
    outbox: Vec<Value>,
    cancelled: HashSet<RequestId>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum ServerPhase {
    Created,
    Running,
    ShutDown,
    Ended(LspSessionEnd),
}

impl LanguageServer {
    /// A server to which nothing has come yet.
    pub fn new(options: ServerOptions) -> Self {
        LanguageServer {
            documents: Documents::default(),
            language: options.language.unwrap_or_default(),
            folders: Vec::new(),
            client: options.client,
            options,
            phase: ServerPhase::Created,
            outbox: Vec::new(),
            cancelled: HashSet::new(),
        }
    }

    /// What is to be sent.
    pub fn outbox(&mut self) -> Vec<Value> {
        std::mem::take(&mut self.outbox)
    }

    /// How it ended, once it has.
    pub fn end(&self) -> Option<LspSessionEnd> {
        match self.phase {
            ServerPhase::Ended(end) => Some(end),
            _ => None,
        }
    }

    /// Time when findings are to be told next.
    pub fn next_due(&self) -> Option<Instant> {
        self.documents.next_due()
    }

    /// Whether the process of the client does not exist any more.
    pub fn client_is_gone(&self) -> bool {
        self.client.is_some_and(machine::is_process_gone)
    }

    /// Answers requests that the client takes back further behind in the queue.
    pub fn drop_cancelled(&mut self, waiting: &mut VecDeque<LspInput>) {
        for message in waiting.iter() {
            if let LspInput::Message(Message::Notification(notification)) = message
                && notification.method == "$/cancelRequest"
                && let Ok(id) = serde_json::from_value(notification.params["id"].clone())
                && self.cancelled.len() < CANCELLED_MAX
            {
                self.cancelled.insert(id);
            }
        }
        if self.cancelled.is_empty() {
            return;
        }
        waiting.retain(|message| match message {
            LspInput::Message(Message::Request(request))
                if self.cancelled.contains(&request.id) =>
            {
                let message = "the client has cancelled the request";
                let refusal = error(&request.id, ErrorCode::RequestCanceled, message);
                self.outbox.push(refusal);
                false
            }
            LspInput::Message(Message::Notification(n)) => n.method != "$/cancelRequest",
            _ => true,
        });
        self.cancelled.clear();
    }

    /// Takes a message.
    pub fn take(&mut self, message: LspInput) {
        match message {
            LspInput::Broken(sentence) => self.outbox.push(json!({
                "jsonrpc": "2.0",
                "id": null,
                "error": { "code": ErrorCode::ParseError as i32, "message": sentence },
            })),
            LspInput::Message(Message::Request(request)) => self.request(request),
            LspInput::Message(Message::Notification(notification)) => self.notify(notification),
            // Nothing is asked of the client.
            LspInput::Message(Message::Response(_)) => {}
        }
    }

    fn request(&mut self, request: Request) {
        let id = request.id.clone();
        // A fault of ours costs one answer, not the session.
        let answer = supervision::catch(|| self.answer(request));
        self.outbox.push(match answer {
            Ok(Ok(result)) => message([("id", json!(id)), ("result", result)]),
            Ok(Err(refusal)) => error(&id, refusal.code, &refusal.message),
            Err(panicked) => {
                let message = format!("a fault of the language server: {}", panicked.message);
                error(&id, ErrorCode::InternalError, &message)
            }
        });
    }

    fn answer(&mut self, request: Request) -> Result<Value, RequestError> {
        let refuse = |code, message: &str| {
            let message = message.to_owned();
            Err(RequestError { code, message })
        };
        match (self.phase, &*request.method) {
            (ServerPhase::Created, "initialize") => self.initialize(parsed(request.params)?),
            (ServerPhase::Created, _) => refuse(
                ErrorCode::ServerNotInitialized,
                "'initialize' must come first",
            ),
            (_, "initialize") => refuse(ErrorCode::InvalidRequest, "'initialize' has come before"),
            (ServerPhase::Running, "shutdown") => {
                self.phase = ServerPhase::ShutDown;
                Ok(Value::Null)
            }
            (ServerPhase::Running, _) => {
                elite_syntax::with_deep_stack(|| requests::answer(self, request))
            }
            _ => refuse(ErrorCode::InvalidRequest, "the server was shut down"),
        }
    }

    fn initialize(&mut self, params: InitializeParams) -> Result<Value, RequestError> {
        let general = params.capabilities.general.as_ref();
        let encodings = general.and_then(|general| general.position_encodings.as_ref());
        let takes_bytes = encodings.is_some_and(|all| all.contains(&PositionEncodingKind::UTF8));
        if takes_bytes {
            self.documents.encoding = Encoding::Utf8;
        }
        if self.options.language.is_none() {
            self.language = Language::of_locale(params.locale.as_deref().unwrap_or("en"));
        }
        let folders = params.workspace_folders.iter().flatten().map(|f| &f.uri);
        let mut folders: Vec<PathBuf> = folders
            .filter_map(|uri| Some(uri.to_file_path()?.into_owned()))
            .collect();
        #[allow(deprecated, reason = "clients that know no folders send it")]
        if let (true, Some(root)) = (folders.is_empty(), &params.root_uri) {
            folders.extend(root.to_file_path().map(|path| path.into_owned()));
        }
        self.folders = folders;
        self.client = params.process_id.or(self.client);
        self.phase = ServerPhase::Running;
        Ok(capabilities::answer(takes_bytes))
    }

    fn notify(&mut self, notification: Notification) {
        if notification.method == "exit" {
            let orderly = self.phase == ServerPhase::ShutDown;
            self.phase = ServerPhase::Ended(if orderly {
                LspSessionEnd::Orderly
            } else {
                LspSessionEnd::Vanished
            });
            return;
        }
        if self.phase != ServerPhase::Running {
            return;
        }
        if let Err(sentence) = self.noted(notification) {
            // Nobody waits for an answer, so people are told.
            self.tell(
                "window/logMessage",
                json!({ "type": 2, "message": sentence }),
            );
        }
    }

    fn noted(&mut self, notification: Notification) -> Result<(), String> {
        let params = notification.params;
        let wrong = |refusal: RequestError| refusal.message;
        match &*notification.method {
            // Asked now, so that nobody waits for it later.
            "initialized" => library::prepare(),
            "textDocument/didOpen" => {
                let params: DidOpenTextDocumentParams = parsed(params).map_err(wrong)?;
                let text = params.text_document;
                let opened = self.documents.open(text.uri, text.version, text.text);
                opened.map_err(|error| error.to_string())?;
            }
            "textDocument/didChange" => {
                let params: DidChangeTextDocumentParams = parsed(params).map_err(wrong)?;
                let (uri, version) = (&params.text_document.uri, params.text_document.version);
                let changed = self.documents.change(uri, version, &params.content_changes);
                changed.map_err(|error| error.to_string())?;
            }
            "textDocument/didClose" => {
                let params: DidCloseTextDocumentParams = parsed(params).map_err(wrong)?;
                let uri = params.text_document.uri;
                if self.documents.close(&uri) {
                    let nothing = json!({ "uri": uri, "diagnostics": [] });
                    self.tell("textDocument/publishDiagnostics", nothing);
                }
            }
            "workspace/didChangeWorkspaceFolders" => {
                let event: ls_types::DidChangeWorkspaceFoldersParams =
                    parsed(params).map_err(wrong)?;
                let path = |f: &ls_types::WorkspaceFolder| Some(f.uri.to_file_path()?.into_owned());
                let gone: Vec<PathBuf> = event.event.removed.iter().filter_map(path).collect();
                self.folders.retain(|folder| !gone.contains(folder));
                self.folders
                    .extend(event.event.added.iter().filter_map(path));
            }
            // What nobody asked for means nothing here.
            _ => {}
        }
        Ok(())
    }

    fn tell(&mut self, method: &str, params: Value) {
        self.outbox
            .push(message([("method", method.into()), ("params", params)]));
    }

    /// Tells the findings of a text whose turn it is.
    pub fn tell_due(&mut self, now: Instant) {
        let (encoding, language) = (self.documents.encoding, self.language);
        let Some(document) = self.documents.take_due(now) else {
            return;
        };
        // A text that makes us fail has no findings, and the session goes on.
        let told = supervision::catch(|| diagnostics::of(document, encoding, language));
        if let Ok(params) = told {
            self.tell("textDocument/publishDiagnostics", params);
        }
    }
}

/// A message of these members, which are moved into it: long answers are made once.
fn message<const N: usize>(members: [(&str, Value); N]) -> Value {
    let version = [("jsonrpc", "2.0".into())].into_iter();
    let members = version.chain(members);
    Value::Object(
        members
            .map(|(name, value)| (name.to_owned(), value))
            .collect(),
    )
}

/// The parameters of a message.
pub fn parsed<T: DeserializeOwned>(params: Value) -> Result<T, RequestError> {
    serde_json::from_value(params).map_err(|error| RequestError {
        code: ErrorCode::InvalidParams,
        message: format!("the parameters are not as they should be: {error}"),
    })
}

fn error(id: &RequestId, code: ErrorCode, message: &str) -> Value {
    json!({
        "jsonrpc": "2.0",
        "id": id,
        "error": { "code": code as i32, "message": message },
    })
}
