//! The debugger: the Debug Adapter Protocol over a reader and a writer, and programs that are walked both ways.
//!
//! - `stream`: the frames of the protocol; `session`: requests and runs; `arguments`: what requests have to have;
//!   `responses`: responses, events; `breakpoint_requests` and `breakpoints`: what the program is held for;
//!   `capabilities`.
//! - `run`: one run of the program, on a controller of its own under the virtual clock; `run_channel`: what passes
//!   between the two.
//! - `probe`, `watcher` and `breakpoint_hits`: on the program's thread, decide whether it is held; `inspect`,
//!   `set_variable` and `robot_scope`: what it is asked while it is.
//! - `hub`: where clients attach to a controller that serves; `attached_session`: their sessions; `remote_attach`: the
//!   way there; `attached_suspend`: how its programs are held.
//! - `reverse` and `run_position`: a run is a pure function of text, model, options and seed, so going back is running
//!   again, without a word, to one place before. What the client changed on the way is done again.
//!
//! No thread of this module waits for the client but the one that reads.

mod arguments;
mod attached_session;
mod attached_suspend;
mod bodies;
mod breakpoint_hits;
mod breakpoint_requests;
mod breakpoints;
mod capabilities;
mod hub;
mod inspect;
mod probe;
mod remote_attach;
mod responses;
mod reverse;
mod robot_scope;
mod run;
mod run_channel;
mod run_position;
mod session;
mod set_variable;
pub mod stream;
mod watcher;

use std::io::{BufRead, Write};
use std::sync::mpsc::{SyncSender, sync_channel};

use supervision::{ThreadRole, ThreadSupervisor};

pub use attached_session::{AttachedSession, SessionSender};
pub use hub::{DebugHub, HubDebugger};
pub use remote_attach::{ConnectFn, RemoteSender, RemoteSink};
pub use run::{RecordedProgram, RunTarget};
pub use session::Launch;

use run_channel::SessionEvent;
use session::DapSession;

/// Messages and events that may wait; who sends more is held up.
const WAITING_MAX: usize = 256;

/// Serves one client until it leaves. What it has launched ends with it.
///
/// # Errors
/// The operating system gives no thread.
pub fn serve(
    input: impl BufRead + Send + 'static,
    output: &mut dyn Write,
    launch: &Launch<'_>,
) -> std::io::Result<()> {
    serve_attaching(input, output, launch, None)
}

/// Serves one client, which may also attach to a controller elsewhere, until it leaves. What it has launched ends with
/// it.
///
/// # Errors
/// The operating system gives no thread.
pub fn serve_attaching(
    input: impl BufRead + Send + 'static,
    output: &mut dyn Write,
    launch: &Launch<'_>,
    attach: Option<&ConnectFn<'_>>,
) -> std::io::Result<()> {
    let (sender, notes) = sync_channel(WAITING_MAX);
    let of_client = sender.clone();
    // The thread ends with the input stream; after a session that ends first, it waits for a client that says no more.
    let reading =
        ThreadSupervisor::default().start(ThreadRole::Service, "debug client", move || {
            read_all(input, &of_client);
        })?;
    let mut frames = stream::FramedWriter(output);
    let mut session = DapSession::new(&mut frames, launch, sender);
    session.attach = attach;
    while !session.is_done {
        // The session itself holds a sender, so that this does not fail.
        match notes.recv() {
            Ok(note) => session.handle_event(note),
            Err(_) => break,
        }
    }
    session.leave(&mut || while notes.try_recv().is_ok() {});
    drop(reading);
    Ok(())
}

fn read_all(mut input: impl BufRead, sender: &SyncSender<SessionEvent>) {
    loop {
        let (note, is_last) = match stream::read(&mut input) {
            Ok(Some(message)) => (SessionEvent::Client(message), false),
            Ok(None) => (SessionEvent::Gone(None), true),
            Err(error) => (SessionEvent::Gone(Some(error.to_string())), true),
        };
        if sender.send(note).is_err() || is_last {
            return;
        }
    }
}
