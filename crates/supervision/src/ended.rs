//! A flag that is raised once, and can be waited for by threads and by futures of any runtime.

use std::sync::Arc;
use std::task::{Context, Poll, Waker};
use std::time::{Duration, Instant};

use parking_lot::{Condvar, Mutex, MutexGuard};

use crate::faults::EndSignalFuture;

/// Whether something has ended. Clones tell the same.
#[derive(Clone, Default)]
pub struct EndSignal {
    shared: Arc<SignalCore>,
}

#[derive(Default)]
struct SignalCore {
    state: Mutex<SignalState>,
    raised: Condvar,
}

#[derive(Default)]
struct SignalState {
    is_ended: bool,
    wakers: Vec<Waker>,
}

impl EndSignal {
    fn state(&self) -> MutexGuard<'_, SignalState> {
        self.shared.state.lock()
    }

    pub(crate) fn set(&self) {
        let wakers = {
            let mut state = self.state();
            state.is_ended = true;
            std::mem::take(&mut state.wakers)
        };
        self.shared.raised.notify_all();
        for waker in wakers {
            waker.wake();
        }
    }

    /// True from the end on.
    pub fn is_ended(&self) -> bool {
        self.state().is_ended
    }

    /// Waits for the end.
    pub fn wait(&self) {
        let mut state = self.state();
        while !state.is_ended {
            self.shared.raised.wait(&mut state);
        }
    }

    /// Waits for the end, at most so long; whether it has come.
    pub fn wait_for(&self, patience: Duration) -> bool {
        let deadline = Instant::now() + patience;
        let mut state = self.state();
        while !state.is_ended {
            let left = deadline.saturating_duration_since(Instant::now());
            if left.is_zero() {
                return false;
            }
            self.shared.raised.wait_for(&mut state, left);
        }
        true
    }

    /// Waits for the end in a future, whatever runtime drives it.
    pub fn wait_async(&self) -> impl Future<Output = ()> + Send + use<> {
        EndSignalFuture(self.clone())
    }

    pub(crate) fn poll_ended(&self, context: &Context<'_>) -> Poll<()> {
        let mut state = self.state();
        if state.is_ended {
            return Poll::Ready(());
        }
        if !state.wakers.iter().any(|w| w.will_wake(context.waker())) {
            state.wakers.push(context.waker().clone());
        }
        Poll::Pending
    }
}
