//! Keeps the client that writes each input variable: one at a time.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use parking_lot::Mutex;
use tokio::sync::Notify;
use tokio::time::{Instant, timeout_at};

use super::inputs::InputVariable;
use crate::ports::ClientId;

/// A variable in use is waited for so long: the SDK closes its connection and opens the next in the same microsecond,
/// and the old one is cleaned up a moment later. Well under the second that clients wait for a reply.
const PATIENCE: Duration = Duration::from_millis(300);

/// The owners of all input variables of the port. Cloning gives another handle to the same list.
#[derive(Clone, Debug, Default)]
pub struct Owners {
    shared: Arc<OwnerTable>,
}

#[derive(Debug, Default)]
struct OwnerTable {
    owner: Mutex<BTreeMap<InputVariable, ClientId>>,
    released: Notify,
}

/// What one client owns; given back when dropped.
#[derive(Debug)]
pub struct Claims {
    owners: Owners,
    client: ClientId,
}

impl Owners {
    /// The claims of a client, none at first.
    pub fn claims(&self, client: ClientId) -> Claims {
        Claims {
            owners: self.clone(),
            client,
        }
    }
}

impl Claims {
    /// Claims all of `inputs` or none. Gives those that another client holds on to.
    pub async fn claim(&self, inputs: &[InputVariable]) -> Vec<InputVariable> {
        let deadline = Instant::now() + PATIENCE;
        loop {
            // Registered before the look, so that a release in between is not missed.
            let released = self.owners.shared.released.notified();
            let taken = self.try_claim(inputs);
            if taken.is_empty() || timeout_at(deadline, released).await.is_err() {
                return taken;
            }
        }
    }

    fn try_claim(&self, inputs: &[InputVariable]) -> Vec<InputVariable> {
        let mut owner = self.owners.shared.owner.lock();
        let others = |input: &&InputVariable| owner.get(input).is_some_and(|o| *o != self.client);
        let taken: Vec<InputVariable> = inputs.iter().filter(others).copied().collect();
        if taken.is_empty() {
            owner.extend(inputs.iter().map(|input| (*input, self.client)));
        }
        taken
    }
}

impl Drop for Claims {
    fn drop(&mut self) {
        self.owners
            .shared
            .owner
            .lock()
            .retain(|_, owner| *owner != self.client);
        self.owners.shared.released.notify_waiters();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn a_variable_has_one_owner_until_that_client_is_gone() {
        let owners = Owners::default();
        let (first, second) = (owners.claims(ClientId(1)), owners.claims(ClientId(2)));
        assert_eq!(
            first
                .claim(&[InputVariable::Int(0), InputVariable::Int(1)])
                .await,
            []
        );
        assert_eq!(first.claim(&[InputVariable::Int(0)]).await, [], "its own");
        let start = Instant::now();
        assert_eq!(
            second
                .claim(&[InputVariable::Int(1), InputVariable::Int(2)])
                .await,
            [InputVariable::Int(1)]
        );
        assert_eq!(start.elapsed(), PATIENCE);
        assert_eq!(
            first.claim(&[InputVariable::Int(2)]).await,
            [],
            "a failed claim takes nothing"
        );
        drop(first);
        assert_eq!(second.claim(&[InputVariable::Int(1)]).await, []);
    }

    #[tokio::test(start_paused = true)]
    async fn a_client_that_is_just_going_is_waited_for() {
        let owners = Owners::default();
        let (first, second) = (owners.claims(ClientId(1)), owners.claims(ClientId(2)));
        first.claim(&[InputVariable::Int(0)]).await;
        tokio::spawn(async move {
            tokio::time::sleep(Duration::from_millis(50)).await;
            drop(first);
        });
        assert_eq!(second.claim(&[InputVariable::Int(0)]).await, []);
    }
}
