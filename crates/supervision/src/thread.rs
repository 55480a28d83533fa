//! A thread whose end can be waited for, with what it gave back or the fault that ended it.

use std::io;
use std::sync::Arc;
use std::thread::{Builder, Thread};
use std::time::Duration;

use parking_lot::Mutex;

use crate::contained::catch;
use crate::{EndSignal, Fault, ThreadRole, ThreadSupervisor};

/// A running thread. Dropping the handle lets the thread go on.
pub struct ThreadHandle<T> {
    thread: Thread,
    ended: EndSignal,
    result: Arc<Mutex<Option<Result<T, Fault>>>>,
}

pub(crate) fn start<T: Send + 'static>(
    faults: ThreadSupervisor,
    kind: ThreadRole,
    name: String,
    body: impl FnOnce() -> T + Send + 'static,
) -> io::Result<ThreadHandle<T>> {
    let ended = EndSignal::default();
    let result = Arc::new(Mutex::new(None));
    let (ends, gives) = (SignalOnDrop(ended.clone()), result.clone());
    let called = name.clone();
    #[allow(
        clippy::disallowed_methods,
        reason = "the one place where threads start"
    )]
    let joined = Builder::new().name(name).spawn(move || {
        // Dropped last: whoever waits finds the result.
        let _ends = ends;
        let given = catch(body).map_err(|panicked| Fault::new(kind, called, panicked));
        let fault = given.as_ref().err().cloned();
        *gives.lock() = Some(given);
        if let Some(fault) = fault {
            faults.tell(&fault);
        }
    })?;
    Ok(ThreadHandle {
        thread: joined.thread().clone(),
        ended,
        result,
    })
}

struct SignalOnDrop(EndSignal);

impl Drop for SignalOnDrop {
    fn drop(&mut self) {
        self.0.set();
    }
}

impl<T> ThreadHandle<T> {
    /// The thread, for instance to unpark it.
    pub fn thread(&self) -> &Thread {
        &self.thread
    }

    /// Becomes true when the thread is gone, however it ended.
    pub fn end_signal(&self) -> &EndSignal {
        &self.ended
    }

    /// Waits for the end.
    ///
    /// # Errors
    /// The fault by which the thread ended.
    pub fn join(self) -> Result<T, Fault> {
        self.ended.wait();
        self.take_result()
    }

    /// Waits for the end, at most so long; gives the handle back when the thread still runs.
    ///
    /// # Errors
    /// In the result: the fault by which the thread ended.
    pub fn join_within(self, patience: Duration) -> Result<Result<T, Fault>, Self> {
        if self.ended.wait_for(patience) {
            Ok(self.take_result())
        } else {
            Err(self)
        }
    }

    fn take_result(&self) -> Result<T, Fault> {
        let given = self.result.lock().take();
        // The result is put down before the end is told, and only the handle, which is used up, takes it.
        given.unwrap_or_else(|| unreachable!("a thread that has ended has left its result"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc;

    #[test]
    fn whoever_waits_gets_the_result_or_the_fault() {
        let faults = ThreadSupervisor::default();
        let seven = faults.start(ThreadRole::Task, "seven", || 7).unwrap();
        assert_eq!(seven.join(), Ok(7));
        let fault = faults
            .start(ThreadRole::Task, "unlucky", || -> u32 {
                panic!("no {}", 7)
            })
            .unwrap()
            .join()
            .unwrap_err();
        assert_eq!(
            (fault.name.as_str(), fault.message.as_str()),
            ("unlucky", "no 7")
        );
        assert_eq!(faults.counts()[0], (ThreadRole::Task, 1));
    }

    #[test]
    fn a_wait_with_a_bound_ends_and_can_be_gone_on_with() {
        let (go, wait) = mpsc::channel::<()>();
        let thread = ThreadSupervisor::default()
            .start(ThreadRole::Service, "waits", move || wait.recv().is_err())
            .unwrap();
        let Err(thread) = thread.join_within(Duration::from_millis(5)) else {
            panic!("it waits for us");
        };
        drop(go);
        assert_eq!(thread.join(), Ok(true));
    }

    #[test]
    fn a_panic_payload_of_any_kind_and_a_panic_in_a_destructor_are_caught() {
        struct Unlucky;
        impl Drop for Unlucky {
            fn drop(&mut self) {
                panic!("on the way out");
            }
        }
        let faults = ThreadSupervisor::default();
        let odd = faults.start(ThreadRole::Task, "odd", || std::panic::panic_any(7));
        assert_eq!(
            odd.unwrap().join().unwrap_err().message,
            "a panic without words"
        );
        let drops = faults.start(ThreadRole::Task, "drops", || drop(Unlucky));
        assert_eq!(drops.unwrap().join().unwrap_err().message, "on the way out");
    }
}
