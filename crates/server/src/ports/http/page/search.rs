//! When a condition held in the recording that a page shows: what people jump to.
//!
//! Owns the form of the question and of the answer, and that only one search goes on at a time, on a thread of its own,
//! until nobody waits for it any more. How a recording is looked through is [`controller::search`].

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use controller::condition::ConditionError;
use controller::search::{MatchInterval, search};
use messages::{Localized, Text, text};
use recorder::{ReadError, Recording};
use serde::Deserialize;
use serde_json::{Value, json};
use supervision::{ThreadRole, ThreadSupervisor};
use thiserror::Error;
use tokio::sync::oneshot;

use super::{Page, PageBackend};

/// Longest text of a condition, bytes.
const CONDITION_BYTES_MAX: usize = 4 << 10;
/// Stretches of time in one answer.
const STRETCHES_MAX: usize = 1000;

/// What is asked.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SearchRequest {
    /// A condition as `replay --find` takes it.
    condition: String,
}

/// A reason why a search has no answer.
#[derive(Debug, Error, Localized)]
enum SearchError {
    #[error(transparent)]
    Read(#[from] ReadError),
    #[error(transparent)]
    Condition(#[from] ConditionError),
}

/// Looks the recording through; the answer as JSON.
///
/// # Errors
/// A sentence.
pub(super) async fn find<C: PageBackend>(
    page: &Page<C>,
    asked: SearchRequest,
) -> Result<Value, Text> {
    let condition = asked.condition;
    if condition.len() > CONDITION_BYTES_MAX {
        return Err(text!(
            "the condition has {} bytes, {CONDITION_BYTES_MAX} are allowed",
            "条件有 {} 字节，最多允许 {CONDITION_BYTES_MAX} 字节",
            condition.len()
        ));
    }
    let Ok(_turn) = page.searching.acquire().await else {
        return Err(text!("the server is ending", "服务器正在结束"));
    };
    let recording = page.cockpit.recording()?;
    let wanted = CancelOnDrop(Arc::new(AtomicBool::new(true)));
    let is_wanted = Arc::clone(&wanted.0);
    let (reply, found) = oneshot::channel();
    let looking = move || {
        let found = look(&recording, &condition, || is_wanted.load(Ordering::Relaxed));
        // Nobody waiting is fine.
        let _ = reply.send(found);
    };
    let started = ThreadSupervisor::default().start(ThreadRole::Service, "search", looking);
    started.map_err(|error| {
        text!(
            "the operating system gives no thread: {error}",
            "操作系统没有提供线程：{error}"
        )
    })?;
    found
        .await
        .map_err(|_| text!("the search ended without an answer", "查找结束但没有回答"))?
        .map_err(|error| Text::of(&error))
}

/// Somebody waits for the answer, until this is dropped.
pub(super) struct CancelOnDrop(pub(super) Arc<AtomicBool>);

impl Drop for CancelOnDrop {
    fn drop(&mut self) {
        self.0.store(false, Ordering::Relaxed);
    }
}

fn look(
    recording: &Recording,
    condition: &str,
    wanted: impl Fn() -> bool,
) -> Result<Value, SearchError> {
    let mut rows = Vec::new();
    let tally = search::<SearchError>(recording, ("condition", condition), wanted, |stretch| {
        rows.push(row(stretch));
        Ok(rows.len() < STRETCHES_MAX)
    })?;
    Ok(json!({
        "complete": rows.len() < STRETCHES_MAX,
        "cycles": tally.cycles,
        "found": tally.found,
        "stretches": rows,
    }))
}

fn row(stretch: &MatchInterval) -> Value {
    json!({
        "from": stretch.first.time,
        "to": stretch.last,
        "cycles": stretch.cycles,
        "program": stretch.doing.program,
        "line": stretch.doing.line,
        "command": stretch.doing.command,
    })
}
