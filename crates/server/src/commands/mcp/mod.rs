//! `eliteserver mcp`: the Model Context Protocol on standard input and output, for assistants that write robot
//! programs.
//!
//! Owns what is wired together here: the folder, the lines, the tools, and the end. The protocol is the SDK's (`rmcp`).
//! No tool reaches a robot or the network, and no file but those beneath the folder that the process was started in.

mod builtins;
pub mod lines;
mod paths;
mod programs;
mod recordings;
mod server;
mod test_tool;
mod tools;
mod workspace;

use std::path::Path;
use std::time::Duration;

use messages::text;
use rmcp::service::{QuitReason, ServerInitializeError, serve_server};

use crate::cli::McpArgs;
use crate::command::{CommandResult, CommandStatus};

use lines::Lines;
use server::McpServer;
use workspace::Workspace;

/// Calls that are given up when the client has gone have so long to notice.
const LEAVING: Duration = Duration::from_secs(2);

/// Exit status: 0 the client has left, 1 it left before it had said `initialize`.
///
/// # Errors
/// The folder cannot be opened, the operating system gives no thread, or the client breaks the protocol.
pub fn mcp(_: &McpArgs) -> CommandResult {
    let workspace = Workspace::open(Path::new("."))?;
    let lines = Lines::of_standard_streams()?;
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()?;
    let server = McpServer::new(workspace);
    let stop_all = server.stop_all();
    let ended = runtime.block_on(async {
        let running = match serve_server(server, lines).await {
            Ok(running) => running,
            Err(ServerInitializeError::ConnectionClosed(_)) => return Ok(CommandStatus::Negative),
            Err(ServerInitializeError::ExpectedInitializeRequest(_)) => {
                let text = text!(
                    "the first request of a client must be initialize",
                    "客户端的第一个请求必须是 initialize"
                );
                return Err(text.into());
            }
            Err(error) => {
                let text = text!(
                    "the session with the client cannot begin: {error}",
                    "与客户端的会话无法开始：{error}"
                );
                return Err(text.into());
            }
        };
        match running.waiting().await {
            Ok(QuitReason::JoinError(error)) | Err(error) => {
                let text = text!(
                    "the session with the client has failed: {error}",
                    "与客户端的会话失败：{error}"
                );
                Err(text.into())
            }
            Ok(_) => Ok(CommandStatus::Success),
        }
    });
    stop_all.stop_and_wait(LEAVING);
    // A thread that still reads from the client is not waited for.
    runtime.shutdown_background();
    ended
}
