//! The path that the program in the editor would drive, for whoever looks at it before anything moves.
//!
//! Owns the bounds: one run at a time, on a thread of its own, for some seconds, until nobody waits for it any more.
//! Question and answer are [`pendant::planned_path`]'s.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use messages::{Text, text};
use pendant::planned_path::{PathQuery, planned_path};
use serde_json::Value;
use supervision::{ThreadRole, ThreadSupervisor};
use tokio::sync::oneshot;

use super::search::CancelOnDrop;
use super::{Page, PageBackend};

/// A program is followed for so long of the machine's time.
const WALL_TIME: Duration = Duration::from_secs(8);

/// Runs a program beside the robot; the path as JSON.
///
/// # Errors
/// A sentence.
pub(super) async fn path<C: PageBackend>(page: &Page<C>, asked: PathQuery) -> Result<Value, Text> {
    asked.check().map_err(|error| Text::of(&error))?;
    let Ok(_turn) = page.planning.acquire().await else {
        return Err(text!("the server is ending", "服务器正在结束"));
    };
    // The robot may have moved while others had their turn.
    let settings = page.cockpit.rehearsal()?;
    let wanted = CancelOnDrop(Arc::new(AtomicBool::new(true)));
    let is_wanted = Arc::clone(&wanted.0);
    let (reply, found) = oneshot::channel();
    let running = move || {
        let began = Instant::now();
        let mut keep_going = || is_wanted.load(Ordering::Relaxed) && began.elapsed() < WALL_TIME;
        // Nobody waiting is fine.
        let _ = reply.send(planned_path(&settings, asked, &mut keep_going));
    };
    let started = ThreadSupervisor::default().start(ThreadRole::Service, "planned path", running);
    started.map_err(|error| {
        text!(
            "the operating system gives no thread: {error}",
            "操作系统没有提供线程：{error}"
        )
    })?;
    found
        .await
        .map_err(|_| text!("the run ended without an answer", "运行结束但没有回答"))?
        .map_err(|error| Text::of(&error))
}
