//! Values of secondary programs that somebody waits for, by the name of the program.

use std::collections::BTreeMap;

use tokio::sync::oneshot;

/// What a program is worth, as text; or why it is worth nothing.
pub type Answer = Result<String, String>;

/// Where answers go. Bounded by those who wait: each takes its own away.
#[derive(Debug, Default)]
pub(crate) struct Answers(BTreeMap<String, oneshot::Sender<Answer>>);

impl Answers {
    /// Somebody waits for the program of this name.
    pub fn expect(&mut self, name: &str) -> oneshot::Receiver<Answer> {
        let (sender, receiver) = oneshot::channel();
        self.0.insert(name.to_owned(), sender);
        receiver
    }

    /// Where the answer of a program goes, if somebody waits for it.
    pub fn take(&mut self, name: &str) -> Option<oneshot::Sender<Answer>> {
        match self.0.is_empty() {
            true => None,
            false => self.0.remove(name),
        }
    }
}
