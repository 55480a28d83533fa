//! Port 30020, interpreter mode: statements in, one reply a statement out.
//!
//! Owns lines, replies and clients. The queue of statements, and what they do, is behind [`InterpreterBackend`].

pub mod codec;
pub mod session;

use std::sync::Arc;

use tokio::net::TcpListener;
use tokio_util::sync::CancellationToken;

use crate::ports::listen::{PortMeter, serve_port};
use crate::ports::peer::PortProtocol;
use codec::{Discard, InterpreterCommand};
pub use session::Statement;

/// What becomes of a statement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StatementReply {
    /// The statement is queued under this number.
    Ack(u64),
    /// The statement is not executed.
    Discard(Discard),
}

/// What this port asks of the runtime.
pub trait InterpreterBackend: Send + Sync + 'static {
    /// Compiles a statement and queues it. Waits while an acknowledged `clear_interpreter()` has not been executed: no
    /// newer statement is acknowledged before (manual 2.1). Statements of one client come one after the other. A
    /// statement that is thrown away later is reported through [`Statement::discard`].
    fn submit(&self, statement: Statement) -> impl Future<Output = StatementReply> + Send;
    /// Carries out a command word at once and gives the number for its reply: a statement's number or a count; for
    /// `skipbuffer` and `abort` the number of the statement executed last.
    fn command(&self, command: InterpreterCommand) -> impl Future<Output = u64> + Send;
}

/// Serves the port until `shutdown`; returns when every client is closed.
pub async fn serve<I: InterpreterBackend>(
    listener: TcpListener,
    interpreter: Arc<I>,
    meter: PortMeter,
    shutdown: CancellationToken,
) {
    serve_port(
        listener,
        PortProtocol::Native,
        meter,
        shutdown,
        |stream, client, shutdown| {
            let interpreter = Arc::clone(&interpreter);
            async move {
                session::serve(stream, client, &*interpreter, shutdown).await;
            }
        },
    )
    .await;
}
