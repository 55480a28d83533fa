//! What comes in on the http port: whole connections, through the gate and the pages to the answers.

use std::cell::Cell;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use motion_api::{RegisterImages, RobotState};
use server::ports::description::TaskStatus;
use server::ports::http::io::IoChanges;
use server::ports::http::metrics::Figures;
use server::ports::http::{HttpBackend, HttpService, SetInputsError};
use tokio_util::sync::CancellationToken;

use super::conversation::{answered, callers, may_be_for_us};

/// A controller that stands, and counts how often somebody sets its inputs.
#[derive(Default)]
struct StubController(AtomicU64);

impl HttpBackend for StubController {
    fn state(&self) -> RobotState {
        let mut state = RobotState::at_start(Default::default(), 0.004);
        state.cycle = self.0.load(Ordering::Relaxed);
        state
    }
    fn task_status(&self) -> TaskStatus {
        TaskStatus::Paused
    }
    fn panel(&self) -> serde_json::Value {
        serde_json::json!({"task": "paused"})
    }
    fn figures(&self) -> Figures {
        Figures::default()
    }
    fn registers(&self) -> RegisterImages {
        RegisterImages::default()
    }
    fn set_inputs(&self, _: &IoChanges) -> Result<(), SetInputsError> {
        self.0.fetch_add(1, Ordering::Relaxed);
        Ok(())
    }
}

thread_local! {
    static PORT: (Arc<StubController>, HttpService) = {
        let source = Arc::new(StubController::default());
        (Arc::clone(&source), HttpService::of(source, Vec::new()))
    };
    static SET_BEFORE: Cell<u64> = const { Cell::new(0) };
}

pub(super) fn judge(data: &[u8]) {
    PORT.with(|(source, pages)| {
        let (callers, shutdown) = (callers(), CancellationToken::new());
        let answer = answered(data, |peer| pages.serve(peer, &callers, &shutdown));
        let answer = String::from_utf8_lossy(&answer);
        let has = |status: &str| {
            let lines = [format!("HTTP/1.1 {status}"), format!("HTTP/1.0 {status}")];
            lines.iter().any(|line| answer.contains(line))
        };
        assert!(
            answer.is_empty() || answer.starts_with("HTTP/1."),
            "{answer:?}"
        );
        assert!(!has("500"), "{answer:?}");
        assert!(may_be_for_us(data) || !has("200"), "{answer:?}");
        let set = source.0.load(Ordering::Relaxed);
        if set != SET_BEFORE.replace(set) {
            let text = String::from_utf8_lossy(data).to_ascii_lowercase();
            assert!(text.contains("application/json") && may_be_for_us(data));
        }
    });
}
