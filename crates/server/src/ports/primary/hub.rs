//! What every client of the primary port hears: the latest state, and each exception once.
//!
//! Owns the two channels between the controller and the sessions. A slow session misses states and, in the end, the
//! oldest exceptions; it never holds up anybody else.

use std::sync::Arc;
use std::time::Duration;

use tokio::sync::{broadcast, watch};
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;

use super::PrimaryBackend;
use super::state_message::encode_state;
use crate::ports::ClientId;
use crate::ports::description::RobotDescription;
use crate::ports::sample::Sample;
use wire::primary::exception::encode_exception;
use wire::primary::{Exception, ExceptionSource};

/// Between two beats, when simulated time keeps wall pace.
const STATE_PERIOD: Duration = Duration::from_millis(100);

/// Exceptions that wait for a session that is behind; one more pushes the oldest out.
const EXCEPTIONS_WAITING_MAX: usize = 256;

/// One message as bytes, shared by all sessions.
pub type MessageBytes = Arc<[u8]>;

/// The sending side. Cloning gives another handle to the same hub.
#[derive(Clone, Debug)]
pub struct StateHub {
    state: watch::Sender<Option<TimedMessage>>,
    exceptions: broadcast::Sender<AddressedMessage>,
}

/// A state, and when it was, s.
#[derive(Clone, Debug)]
pub(super) struct TimedMessage {
    pub(super) time: f64,
    pub(super) message: MessageBytes,
}

/// A message for every client, or for one.
#[derive(Clone, Debug)]
pub(super) struct AddressedMessage {
    pub(super) to: Option<ClientId>,
    pub(super) message: MessageBytes,
}

/// The receiving side of one session.
#[derive(Debug)]
pub struct Subscription {
    pub(super) state: watch::Receiver<Option<TimedMessage>>,
    pub(super) exceptions: broadcast::Receiver<AddressedMessage>,
    /// Sent before anything else. The state that is published next may be of an earlier cycle; it is left out then.
    pub(super) first: Option<TimedMessage>,
}

impl TimedMessage {
    fn of(sample: &Sample, robot: &RobotDescription) -> Self {
        Self {
            time: sample.state.time,
            message: encode_state(sample, robot).into(),
        }
    }
}

impl Default for StateHub {
    fn default() -> Self {
        Self {
            state: watch::Sender::new(None),
            exceptions: broadcast::Sender::new(EXCEPTIONS_WAITING_MAX),
        }
    }
}

impl StateHub {
    /// What a new client hears from now on. Once states are published it gets one at once, as the controller is now:
    /// the latest beat may be older than what the client has heard on another port.
    pub fn subscribe(&self, backend: &impl PrimaryBackend) -> Subscription {
        let (mut state, exceptions) = (self.state.subscribe(), self.exceptions.subscribe());
        let is_published = state.borrow_and_update().is_some();
        let first = is_published.then(|| {
            let mut sample = backend.sample();
            sample.peripherals.tool_serial = backend.tool_serial();
            TimedMessage::of(&sample, backend.description())
        });
        Subscription {
            state,
            exceptions,
            first,
        }
    }

    /// Tells every client; with nobody connected nobody hears it. `unix_millis` is when it happened.
    pub fn announce(&self, unix_millis: u64, source: ExceptionSource, exception: &Exception) {
        self.tell(None, unix_millis, source, exception);
    }

    /// Tells one client of the primary port, if it is still connected.
    pub fn announce_to(
        &self,
        client: ClientId,
        unix_millis: u64,
        source: ExceptionSource,
        exception: &Exception,
    ) {
        self.tell(Some(client), unix_millis, source, exception);
    }

    fn tell(
        &self,
        to: Option<ClientId>,
        unix_millis: u64,
        source: ExceptionSource,
        exception: &Exception,
    ) {
        let message = encode_exception(unix_millis, source, exception).into();
        // An error only says that no client is connected.
        let _ = self.exceptions.send(AddressedMessage { to, message });
    }

    /// Replaces the state that clients are sent.
    pub fn publish_state(&self, sample: &Sample, robot: &RobotDescription) {
        self.state
            .send_replace(Some(TimedMessage::of(sample, robot)));
    }

    /// Publishes a state in every beat until `shutdown`; without a beat for a while, the state as it is. (A virtual
    /// clock may stand still, or run ahead of the wall: then clients get the latest state, at most twice as often.)
    pub async fn publish_states(&self, backend: &impl PrimaryBackend, shutdown: CancellationToken) {
        let mut beats = backend.beats();
        beats.mark_changed(); // the first state goes out at once
        loop {
            let next = timeout(STATE_PERIOD * 2, beats.changed());
            let sample = match shutdown.run_until_cancelled(next).await {
                Some(Ok(Ok(()))) => beats.borrow_and_update().clone(),
                Some(Err(_elapsed)) => None,
                // Whoever gives the beat is gone, and the controller with it.
                Some(Ok(Err(_))) | None => return,
            };
            let mut sample = sample.unwrap_or_else(|| Arc::new(backend.sample()));
            Arc::make_mut(&mut sample).peripherals.tool_serial = backend.tool_serial();
            self.publish_state(&sample, backend.description());
            let rest = tokio::time::sleep(STATE_PERIOD / 2);
            if shutdown.run_until_cancelled(rest).await.is_none() {
                return;
            }
        }
    }
}
