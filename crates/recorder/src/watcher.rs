//! Gives the recording up when its output hangs: a disk or a reader that neither takes anything nor reports an error.
//!
//! Runs on a thread of its own, because the recorder's is the one that hangs. As long as nobody waits and nothing is
//! lost, an output may take its time.

use std::io;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use motion_api::RecordBackpressure;
use supervision::{EndSignal, ThreadRole, ThreadSupervisor};

use crate::handle::RecorderState;
use crate::notes::AnnotationQueue;
use crate::recorder::{RecordError, SharedReport, report_once};

/// Time between two looks. Patience is counted in looks, so that a process that was held for a while is not taken for
/// an output that hangs.
const LOOK: Duration = Duration::from_millis(50);

/// What is looked at, and who is told.
pub(crate) struct OutputWatchdog {
    pub shared: Arc<RecorderState>,
    pub notes: Arc<AnnotationQueue>,
    pub flow: Arc<RecordBackpressure>,
    pub ended: EndSignal,
    pub report: SharedReport,
    pub path: PathBuf,
}

impl OutputWatchdog {
    /// Watches until the recorder's thread has ended or is given up.
    pub fn start(self, patience: Duration) -> io::Result<()> {
        let looks = patience.as_millis() / LOOK.as_millis();
        ThreadSupervisor::default()
            .start(ThreadRole::Service, "recorder-watch", move || {
                self.watch(looks)
            })
            .map(drop)
    }

    fn watch(&self, looks: u128) {
        let mut before = u64::MAX;
        let mut without_a_step = 0;
        while !self.ended.wait_for(LOOK) {
            let steps = self.shared.progress_count.load(Ordering::Relaxed);
            let is_waited_for = self.flow.is_full() || self.notes.has_blocked_senders();
            without_a_step = match is_waited_for && steps == before {
                true => without_a_step + 1,
                false => 0,
            };
            before = steps;
            if without_a_step > looks {
                return self.give_up();
            }
        }
    }

    /// Whoever waits goes on; the thread, should it come back, closes the file where the recording ends.
    fn give_up(&self) {
        self.shared.is_abandoned.store(true, Ordering::Release);
        self.shared.failed.store(true, Ordering::Release);
        self.flow.abandon();
        self.notes.close();
        let path = self.path.clone();
        report_once(&self.report, &RecordError::OutputStalled { path });
    }
}
