//! How long the server lives: until a signal, until a client shuts it down, or until a client reboots it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use tokio_util::sync::CancellationToken;

/// One life of the server. Clones share it.
#[derive(Clone, Debug, Default)]
pub struct Lifetime {
    token: CancellationToken,
    reboots: Arc<AtomicBool>,
}

impl Lifetime {
    /// Cancelled at its end.
    pub const fn token(&self) -> &CancellationToken {
        &self.token
    }

    /// Ends the backend's tasks.
    pub fn shut_down(&self) {
        self.token.cancel();
    }

    /// Ends it; another follows.
    pub fn reboot(&self) {
        self.reboots.store(true, Ordering::Release);
        self.token.cancel();
    }

    /// True when another life follows this one.
    pub fn reboots(&self) -> bool {
        self.reboots.load(Ordering::Acquire)
    }
}
