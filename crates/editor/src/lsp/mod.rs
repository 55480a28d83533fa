//! The language server: LSP 3.17 over a reader and a writer.
//!
//! Owns the loop, the documents and the translation to and from the protocol's types. What there is to say about a text
//! is in [`crate::analysis`]. One thread reads, one answers in the order of the questions; typing that goes on puts
//! findings off.

mod capabilities;
mod diagnostics;
mod documents;
mod frames;
mod navigation;
mod positions;
mod presentation;
mod requests;
mod server;
mod workspace;

use std::io::{BufReader, Read, Write};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::{Duration, Instant};

use messages::Localized;
use supervision::{ThreadRole, ThreadSupervisor};

use crate::analysis::words::Language;
use frames::LspInput;
use server::LanguageServer;

/// Messages that wait to be looked at.
const WAITING_MAX: usize = 64;
/// The client is looked after so often.
const LOOK_AFTER: Duration = Duration::from_secs(3);

/// How the server is started.
#[derive(Clone, Debug, Default)]
pub struct ServerOptions {
    /// The language of texts; without it the client's locale decides.
    pub language: Option<Language>,
    /// The process of the client, if it is known before `initialize` names it.
    pub client: Option<u32>,
    /// Ends with the process of the client.
    pub follow_client: bool,
}

/// A reason why the server could not go on.
#[derive(Debug, thiserror::Error, Localized)]
pub enum LspError {
    /// The client takes no answers.
    #[error("cannot write to the client: {0}")]
    #[zh("无法写给客户端：{0}")]
    Output(std::io::Error),
    /// There is no thread for its messages.
    #[error("cannot start a thread: {0}")]
    #[zh("无法启动线程：{0}")]
    Thread(std::io::Error),
}

/// How a session ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LspSessionEnd {
    /// The client said `shutdown`, then `exit`.
    Orderly,
    /// The client went without a word.
    Vanished,
}

/// A session without streams: messages in, messages out. For pages that speak the protocol over a stream of their own,
/// and for trials.
pub struct LspSession(LanguageServer);

impl LspSession {
    /// A session to which nothing has come yet.
    pub fn new(options: &ServerOptions) -> Self {
        LspSession(LanguageServer::new(options.clone()))
    }

    /// Takes a message and gives back what is to be sent.
    pub fn take(&mut self, message: serde_json::Value) -> Vec<serde_json::Value> {
        self.0.take(match serde_json::from_value(message) {
            Ok(message) => LspInput::Message(message),
            Err(error) => LspInput::Broken(format!("the message is no JSON-RPC: {error}")),
        });
        self.0.outbox()
    }

    /// The findings that wait for typing to pause, now.
    pub fn flush_diagnostics(&mut self) -> Vec<serde_json::Value> {
        while let Some(due) = self.0.next_due() {
            self.0.tell_due(due);
        }
        self.0.outbox()
    }
}

/// Serves one client until it ends.
///
/// # Errors
/// The client takes no answers.
pub fn serve(
    input: impl Read + Send + 'static,
    output: &mut impl Write,
    options: &ServerOptions,
) -> Result<LspSessionEnd, LspError> {
    let (sender, incoming) = sync_channel(WAITING_MAX);
    let faults = ThreadSupervisor::default();
    let reader = move || {
        let mut input = BufReader::new(input);
        // At the end of the stream, or of this server, the sender goes and the loop hears of it.
        while let Ok(Some(message)) = frames::read(&mut input) {
            if sender.send(message).is_err() {
                return;
            }
        }
    };
    faults
        .start(ThreadRole::Service, "lsp input", reader)
        .map_err(LspError::Thread)?;
    session(&incoming, output, options)
}

fn session(
    incoming: &Receiver<LspInput>,
    output: &mut impl Write,
    options: &ServerOptions,
) -> Result<LspSessionEnd, LspError> {
    let mut server = LanguageServer::new(options.clone());
    let mut waiting = std::collections::VecDeque::new();
    loop {
        // What the client has taken back meanwhile need not be answered.
        waiting.extend(incoming.try_iter().take(WAITING_MAX));
        server.drop_cancelled(&mut waiting);
        let next = match waiting.pop_front() {
            Some(next) => Some(next),
            None => {
                let now = Instant::now();
                let patience = server.next_due().map_or(LOOK_AFTER, |due| {
                    due.saturating_duration_since(now).min(LOOK_AFTER)
                });
                match incoming.recv_timeout(patience) {
                    Ok(next) => Some(next),
                    Err(RecvTimeoutError::Timeout) => None,
                    Err(RecvTimeoutError::Disconnected) => return Ok(LspSessionEnd::Vanished),
                }
            }
        };
        match next {
            Some(message) => server.take(message),
            None if options.follow_client && server.client_is_gone() => {
                return Ok(LspSessionEnd::Vanished);
            }
            None => {}
        }
        if waiting.is_empty() {
            server.tell_due(Instant::now());
        }
        for message in server.outbox() {
            match crate::framing::write(output, &message) {
                Ok(()) => {}
                Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => {
                    return Ok(LspSessionEnd::Vanished);
                }
                Err(error) => return Err(LspError::Output(error)),
            }
        }
        if let Some(end) = server.end() {
            return Ok(end);
        }
    }
}
