//! What the client sees: who we are, which tools there are, calls. Each call runs on a thread of its own, a few at
//! once; one that was cancelled is told to stop and answered by nobody.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Weak};
use std::thread;
use std::time::{Duration, Instant};

use base64::Engine as _;
use parking_lot::Mutex;
use rmcp::handler::server::ServerHandler;
use rmcp::model::{
    CallToolRequestParams, CallToolResponse, CallToolResult, ContentBlock, ErrorData,
    Implementation, JsonObject, ListToolsResult, PaginatedRequestParams, ServerCapabilities,
    ServerConfig,
};
use rmcp::service::{RequestContext, RoleServer};
use supervision::{ThreadRole, ThreadSupervisor, catch};
use tokio::sync::{Semaphore, oneshot};

use super::tools::{self, ToolOutput, ToolSpec};
use super::workspace::{CancelFlag, Workspace};

/// Calls at work at once.
const AT_ONCE: usize = 2;
/// Calls that wait for their turn.
const WAITING_MAX: usize = 64;
/// Longest text of an answer, bytes: what an assistant can take in.
const TEXT_BYTES_MAX: usize = 200_000;

const INSTRUCTIONS: &str = "Robot programs for Elite Robots CS arms, in EliteScript: Python 3 with `end` after \
    blocks where the indentation does not say it, `sec` for secondary programs, and the functions of the robot as \
    builtins. Lengths are m, angles rad, forces N, times s; a pose is [x, y, z, Rx, Ry, Rz] in the base frame, \
    joint positions are six angles.\n\
    Look functions up with `builtin` before you use them, `check` what you have written, `run` it on a simulated \
    arm (simulated time, nothing moves), write tests in test_*.script and run them with `test`. A run with `record` \
    leaves a recording: `replay_summary`, `replay_at`, `replay_find` and `replay_plot` tell what the arm did. Files \
    are those beneath the folder the server was started in. No tool reaches a real robot or the network.";

/// The server.
pub(super) struct McpServer {
    workspace: Workspace,
    turns: Arc<Semaphore>,
    waiting: Arc<AtomicUsize>,
    running: CallCanceller,
}

/// All calls, to be stopped at the end.
#[derive(Clone, Default)]
pub(super) struct CallCanceller {
    stops: Arc<Mutex<Vec<Weak<AtomicBool>>>>,
    at_work: Arc<AtomicUsize>,
}

impl CallCanceller {
    /// Stops all and waits until they have noticed, for at most so long.
    pub(super) fn stop_and_wait(&self, most: Duration) {
        for stop in self.stops.lock().iter().filter_map(Weak::upgrade) {
            stop.store(true, Ordering::Relaxed);
        }
        let since = Instant::now();
        while self.at_work.load(Ordering::Acquire) > 0 && since.elapsed() < most {
            thread::sleep(Duration::from_millis(5));
        }
    }
}

impl CallCanceller {
    /// The flag of one more call.
    fn begin(&self) -> CancelFlag {
        let stop = CancelFlag::default();
        let mut stops = self.stops.lock();
        stops.retain(|stop| stop.strong_count() > 0);
        stops.push(Arc::downgrade(&stop));
        stop
    }
}

/// One less when it goes.
struct CountGuard(Arc<AtomicUsize>);

impl CountGuard {
    fn new(count: &Arc<AtomicUsize>) -> Self {
        count.fetch_add(1, Ordering::AcqRel);
        Self(count.clone())
    }
}

impl Drop for CountGuard {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::AcqRel);
    }
}

impl McpServer {
    pub(super) fn new(workspace: Workspace) -> Self {
        Self {
            workspace,
            turns: Arc::new(Semaphore::new(AT_ONCE)),
            waiting: Arc::default(),
            running: CallCanceller::default(),
        }
    }

    pub(super) fn stop_all(&self) -> CallCanceller {
        self.running.clone()
    }

    async fn call(
        &self,
        tool: &'static ToolSpec,
        arguments: JsonObject,
        context: &RequestContext<RoleServer>,
    ) -> CallToolResult {
        let waits = CountGuard::new(&self.waiting);
        if self.waiting.load(Ordering::Acquire) > WAITING_MAX {
            return refused(format!(
                "{WAITING_MAX} calls wait already; send this one again when they are answered"
            ));
        }
        let turn = tokio::select! {
            turn = self.turns.clone().acquire_owned() => turn,
            () = context.ct.cancelled() => return refused("the call was cancelled".to_owned()),
        };
        drop(waits);
        // Cancelled by the client, or by the end of the session.
        let stop = self.running.begin();
        let (sender, mut receiver) = oneshot::channel();
        let (workspace, stopped) = (self.workspace.clone(), stop.clone());
        let at_work = CountGuard::new(&self.running.at_work);
        let work = move || {
            let answer = catch(|| (tool.call)(&workspace, arguments, &stopped));
            let answer = answer.unwrap_or_else(|panicked| {
                Err(format!("a fault of the server: {}", panicked.message))
            });
            // Whoever cancelled the call does not hear it.
            let _ = sender.send(answer);
            drop((turn, at_work));
        };
        if let Err(error) = ThreadSupervisor::default().start(
            ThreadRole::Service,
            format!("mcp-{}", tool.name),
            work,
        ) {
            return refused(format!("the system gives no thread: {error}"));
        }
        let answer = tokio::select! {
            answer = &mut receiver => answer,
            () = context.ct.cancelled() => {
                stop.store(true, Ordering::Relaxed);
                receiver.await
            }
        };
        match answer {
            Ok(Ok(answer)) => told(answer),
            Ok(Err(sentence)) => refused(sentence),
            Err(_) => refused("a fault of the server: the call ended without an answer".to_owned()),
        }
    }
}

fn told(answer: ToolOutput) -> CallToolResult {
    let mut content = vec![ContentBlock::text(bounded(answer.text))];
    if let Some(png) = answer.png {
        let data = base64::prelude::BASE64_STANDARD.encode(png);
        content.push(ContentBlock::image(data, "image/png"));
    }
    let mut result = CallToolResult::success(content);
    result.structured_content = answer.structured;
    result
}

fn refused(sentence: String) -> CallToolResult {
    CallToolResult::error(vec![ContentBlock::text(bounded(sentence))])
}

/// The beginning and the end of a text that is too long.
pub(super) fn bounded(text: String) -> String {
    shortened(text, TEXT_BYTES_MAX)
}

/// At most about so many bytes of a text: its beginning and its end, and between them how much is left out.
pub(super) fn shortened(text: String, most: usize) -> String {
    if text.len() <= most {
        return text;
    }
    let head = text.floor_char_boundary(most / 2);
    let tail = text.ceil_char_boundary(text.len() - most / 2);
    format!(
        "{}\n[… {} bytes left out …]\n{}",
        &text[..head],
        tail - head,
        &text[tail..]
    )
}

impl ServerHandler for McpServer {
    fn get_info(&self) -> ServerConfig {
        let us = Implementation::new("eliteserver", env!("CARGO_PKG_VERSION"));
        ServerConfig::new(ServerCapabilities::builder().enable_tools().build())
            .with_server_info(us)
            .with_instructions(INSTRUCTIONS)
    }

    async fn list_tools(
        &self,
        _: Option<PaginatedRequestParams>,
        _: RequestContext<RoleServer>,
    ) -> Result<ListToolsResult, ErrorData> {
        Ok(ListToolsResult::with_all_items(
            tools::all().iter().map(ToolSpec::declared).collect(),
        ))
    }

    async fn call_tool(
        &self,
        request: CallToolRequestParams,
        context: RequestContext<RoleServer>,
    ) -> Result<CallToolResponse, ErrorData> {
        let Some(tool) = tools::all().iter().find(|tool| tool.name == request.name) else {
            let names: Vec<&str> = tools::all().iter().map(|tool| tool.name).collect();
            let name: String = request.name.chars().take(80).collect();
            let text = format!("there is no tool {name:?}; there are {}", names.join(", "));
            return Err(ErrorData::invalid_params(text, None));
        };
        let arguments = request.arguments.unwrap_or_default();
        Ok(self.call(tool, arguments, &context).await.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_texts_keep_both_ends() {
        assert_eq!(shortened("é".repeat(10), 20), "é".repeat(10));
        let short = shortened(format!("begin{}end", "é".repeat(1000)), 101);
        assert!(
            short.starts_with("begin") && short.ends_with("end"),
            "{short}"
        );
        assert!(short.len() < 160 && short.contains("left out"), "{short}");
    }
}
