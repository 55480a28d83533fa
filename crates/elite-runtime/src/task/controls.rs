//! What others ask of a running task: orders that it cannot miss, and secondary programs, of which there may be too
//! many.
//!
//! Orders are not queued: what counts is whether the task has been told to end, and whether it was told last to hold or
//! to go on. So they need no room, and nobody who floods the task with programs or orders can keep a stop out.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use elite_syntax::Program;
use tokio::sync::{Notify, mpsc, oneshot};

/// Secondary programs that may wait for a task; it takes them at the latest after a slice.
const SECONDARIES_WAITING_MAX: usize = 256;

/// What others ask of a running task.
#[derive(Debug)]
pub enum Control {
    /// End the task.
    Stop,
    /// End the task because another main program takes its place; the text says which.
    Replace(Arc<str>),
    /// Hold the task.
    Pause,
    /// Let the task go on.
    Resume,
    /// Run a secondary program beside the main one, and say that it was taken. A task that ends first drops the sender.
    Secondary(Program, oneshot::Sender<()>),
}

/// Makes the two ends for one task.
pub(crate) fn control_channel() -> (ControlSender, ControlReceiver) {
    let orders = Arc::new(PendingControls::default());
    let (sender, secondaries) = mpsc::channel(SECONDARIES_WAITING_MAX);
    let controller = ControlSender {
        orders: Arc::clone(&orders),
        secondaries: sender,
    };
    let controls = ControlReceiver {
        orders,
        secondaries,
    };
    (controller, controls)
}

/// Where others ask.
pub(crate) struct ControlSender {
    orders: Arc<PendingControls>,
    secondaries: mpsc::Sender<(Program, oneshot::Sender<()>)>,
}

/// Where the task hears of its controls.
pub(crate) struct ControlReceiver {
    orders: Arc<PendingControls>,
    secondaries: mpsc::Receiver<(Program, oneshot::Sender<()>)>,
}

/// Orders that the task has not looked at yet.
#[derive(Default)]
struct PendingControls {
    wanted: Mutex<ControlFlags>,
    news: Notify,
}

#[derive(Clone, Default)]
struct ControlFlags {
    stop: bool,
    /// The name of the program that takes the place of the task.
    replaced_by: Option<Arc<str>>,
    /// Hold (true) or go on (false), whichever was said last.
    hold: Option<bool>,
}

impl PendingControls {
    /// Whole at every moment, so a poisoned lock is as good as any.
    fn lock(&self) -> MutexGuard<'_, ControlFlags> {
        self.wanted.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take(&self) -> Option<Control> {
        let mut wanted = self.lock();
        if core::mem::take(&mut wanted.stop) {
            return Some(Control::Stop);
        }
        if let Some(successor) = wanted.replaced_by.take() {
            return Some(Control::Replace(successor));
        }
        wanted.hold.take().map(|hold| match hold {
            true => Control::Pause,
            false => Control::Resume,
        })
    }
}

impl ControlSender {
    /// Ends the task.
    pub fn stop(&self) {
        self.order(|wanted| wanted.stop = true);
    }

    /// Ends the task, whose place `successor` takes.
    pub fn replace(&self, successor: Arc<str>) {
        self.order(|wanted| wanted.replaced_by = Some(successor));
    }

    /// Holds the task.
    pub fn pause(&self) {
        self.order(|wanted| wanted.hold = Some(true));
    }

    /// Lets the task go on.
    pub fn resume(&self) {
        self.order(|wanted| wanted.hold = Some(false));
    }

    fn order(&self, change: impl FnOnce(&mut ControlFlags)) {
        change(&mut self.orders.lock());
        self.orders.news.notify_one();
    }

    /// Hands a secondary program over; the receiver hears whether it was taken. `None` when too many wait.
    pub fn join(&self, program: &Program) -> Option<oneshot::Receiver<()>> {
        let (sender, taken) = oneshot::channel();
        // The compiled text is shared, not copied.
        self.secondaries.try_send((program.clone(), sender)).ok()?;
        Some(taken)
    }
}

impl ControlReceiver {
    /// What is asked, orders first; `None` when nothing is.
    pub fn try_next(&mut self) -> Option<Control> {
        let order = self.orders.take();
        order.or_else(|| {
            let (program, taken) = self.secondaries.try_recv().ok()?;
            Some(Control::Secondary(program, taken))
        })
    }

    /// Waits for the next order; secondary programs go on waiting.
    pub async fn next_order(&self) -> Control {
        loop {
            if let Some(order) = self.orders.take() {
                return order;
            }
            self.orders.news.notified().await;
        }
    }

    /// Waits for what is asked next; `None` when nobody is left to ask. Nothing is lost when this is dropped.
    pub async fn next(&mut self) -> Option<Control> {
        loop {
            if let Some(order) = self.orders.take() {
                return Some(order);
            }
            tokio::select! {
                biased;
                () = self.orders.news.notified() => {}
                secondary = self.secondaries.recv() => {
                    let (program, taken) = secondary?;
                    return Some(Control::Secondary(program, taken));
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn secondary() -> Program {
        let file = elite_syntax::SourceFile::new("s", "sec s():\n x = 1\nend\n");
        elite_syntax::compile(file, &elite_syntax::KnownNames::default()).unwrap()
    }

    #[test]
    fn no_flood_keeps_a_stop_out() {
        let (controller, mut controls) = control_channel();
        let mut joined = 0;
        let program = secondary();
        while controller.join(&program).is_some() {
            joined += 1;
        }
        assert_eq!(joined, SECONDARIES_WAITING_MAX);
        for _ in 0..100_000 {
            controller.pause();
            controller.resume();
        }
        controller.stop();
        controller.replace("another".into());
        assert!(matches!(controls.try_next(), Some(Control::Stop)));
        assert!(matches!(controls.try_next(), Some(Control::Replace(_))));
        assert!(matches!(controls.try_next(), Some(Control::Resume)));
        assert!(matches!(controls.try_next(), Some(Control::Secondary(..))));
    }

    #[tokio::test]
    async fn a_task_that_waits_hears_at_once_and_notices_when_nobody_is_left() {
        let (controller, mut controls) = control_channel();
        controller.pause();
        assert!(matches!(controls.next().await, Some(Control::Pause)));
        let (heard, ()) = tokio::join!(controls.next(), async { controller.stop() });
        assert!(matches!(heard, Some(Control::Stop)));
        let (heard, taken) = tokio::join!(controls.next(), async { controller.join(&secondary()) });
        assert!(matches!(heard, Some(Control::Secondary(..))) && taken.is_some());
        drop(controller);
        assert!(controls.next().await.is_none());
    }
}
