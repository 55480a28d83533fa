//! Everything a program can reach beyond itself.

use crate::interpreter::ScriptThread;

/// Number of a script thread within its interpreter; the first is 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ThreadId(pub u64);

/// What the embedder provides: output, time, randomness. The evaluator itself reads no clock and opens no file, so a
/// program under a deterministic host is deterministic.
pub trait Host {
    /// `print` was called; `text` ends as the call says, normally with a newline.
    fn print(&self, thread: ThreadId, text: &str);

    /// Seconds since 1970-01-01T00:00:00Z, for `time.time()` and `datetime`.
    fn unix_time(&self) -> f64;

    /// Seconds of a clock that never goes back, for `time.monotonic()`, `sleep` and timeouts.
    fn monotonic(&self) -> f64;

    /// Random bits, for seeding `random`.
    fn random_u64(&self) -> u64;

    /// Takes over a thread that the program has started (`threading.Thread.start`): resume it soon, and go on until it
    /// has ended.
    ///
    /// # Errors
    /// Why no more threads can be started.
    fn start(&self, thread: ScriptThread) -> Result<(), String>;

    /// Whether the running thread may sleep and wait for other threads.
    ///
    /// # Errors
    /// Why it may not.
    fn may_wait(&self) -> Result<(), String> {
        Ok(())
    }

    /// A thread that is parked (`Step::Parked`) has become ready: resume it soon.
    fn wake(&self, thread: ThreadId);
}
