//! What every client of the primary port hears: the latest state, and each exception once.
//!
//! Owns the two channels between the controller and the sessions. A slow session misses states and, in the end, the
//! oldest exceptions; it never holds up anybody else.

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::{broadcast, watch};
use tokio::time::{MissedTickBehavior, interval};
use tokio_util::sync::CancellationToken;

use super::Backend;
use super::codec::{Exception, Source, encode_exception};
use super::state_message::{StateInputs, encode_state};

/// A state message goes out this often (SDK user guide: 10 Hz).
pub const STATE_PERIOD: Duration = Duration::from_millis(100);

/// Exceptions that wait for a session that is behind; one more pushes the oldest out.
const EXCEPTIONS_WAITING_MAX: usize = 256;

/// One message as bytes, shared by all sessions.
pub type Message = Arc<[u8]>;

/// The sending side. Cloning gives another handle to the same hub.
#[derive(Clone, Debug)]
pub struct Hub {
    state: watch::Sender<Option<Message>>,
    exceptions: broadcast::Sender<Message>,
}

/// The receiving side of one session.
#[derive(Debug)]
pub struct Subscription {
    pub(super) state: watch::Receiver<Option<Message>>,
    pub(super) exceptions: broadcast::Receiver<Message>,
}

impl Default for Hub {
    fn default() -> Self {
        Self {
            state: watch::Sender::new(None),
            exceptions: broadcast::Sender::new(EXCEPTIONS_WAITING_MAX),
        }
    }
}

impl Hub {
    /// What a new client hears from now on.
    pub fn subscribe(&self) -> Subscription {
        let mut state = self.state.subscribe();
        state.mark_changed(); // a new client gets the latest state at once
        Subscription {
            state,
            exceptions: self.exceptions.subscribe(),
        }
    }

    /// Tells every client; with nobody connected nobody hears it. `unix_millis` is when it happened.
    pub fn announce(&self, unix_millis: u64, source: Source, exception: &Exception) {
        let message = encode_exception(unix_millis, source, exception);
        // An error only says that no client is connected.
        let _ = self.exceptions.send(message.into());
    }

    /// Replaces the state that clients are sent.
    pub fn publish_state(&self, inputs: &StateInputs<'_>) {
        self.state.send_replace(Some(encode_state(inputs).into()));
    }

    /// Publishes the robot's state ten times a second until `shutdown`.
    pub async fn publish_states(&self, backend: &impl Backend, shutdown: CancellationToken) {
        let mut ticks = interval(STATE_PERIOD);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        while let Some(_tick) = shutdown.run_until_cancelled(ticks.tick()).await {
            self.publish_state(&StateInputs {
                state: &backend.state(),
                task: backend.task_status(),
                robot: backend.description(),
                peripherals: &backend.peripherals(),
            });
        }
    }
}
