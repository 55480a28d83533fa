//! What work on a text may take: bytes that it comes to hold, and time until other script threads run.

use std::cell::Cell;

/// What work on a text may take on this thread: bytes that it comes to hold, and time until others have their turn.
pub struct WorkBudget<'p> {
    base: Cell<isize>,
    most: usize,
    /// Units of work (work) since the last pause.
    work: Cell<usize>,
    /// Lets others have their turn, after so much work; false if the work is to be given up.
    pause: Option<&'p dyn Fn(usize) -> bool>,
    given_up: Cell<bool>,
}

/// Work to drop something small, in units of work.
pub const WORK_PER_DROP: usize = 96;
/// Work after which a pause is asked for.
const PAUSE_AFTER: usize = 1 << 13;

impl<'p> WorkBudget<'p> {
    /// `limit` bytes more than this thread holds now, and no pauses.
    pub fn with_limit(most: usize) -> Self {
        WorkBudget {
            base: Cell::new(task_memory::live_bytes()),
            most,
            work: Cell::new(0),
            pause: None,
            given_up: Cell::new(false),
        }
    }

    /// `most` bytes more than this thread holds now, with pauses: `pause` is told how much work has been done, and says
    /// whether to go on.
    pub fn with_pauses(most: usize, pause: &'p dyn Fn(usize) -> bool) -> Self {
        WorkBudget {
            pause: Some(pause),
            ..WorkBudget::with_limit(most)
        }
    }

    /// Counts work, and pauses when it is time to. Nothing that scripts can reach may be borrowed.
    #[inline]
    pub fn charge(&self, units: usize) {
        let work = self.work.get() + units;
        self.work.set(work);
        if work >= PAUSE_AFTER {
            self.yield_to_others();
        }
    }

    /// Drops many parts of something, with pauses.
    pub fn drop_each<T>(&self, parts: impl IntoIterator<Item = T>) {
        for part in parts {
            self.charge(WORK_PER_DROP);
            drop(part);
        }
    }

    #[cold]
    fn yield_to_others(&self) {
        let work = self.work.take();
        if let Some(pause) = self.pause
            && !self.given_up.get()
        {
            let before = task_memory::live_bytes();
            self.given_up.set(!pause(work));
            // What others have taken meanwhile is not this work's.
            self.base
                .set(self.base.get() + task_memory::live_bytes() - before);
        }
    }

    /// Whether a pause has said that this is to end; then only the way out is taken.
    pub fn is_aborted(&self) -> bool {
        self.given_up.get()
    }

    /// How much it may be.
    pub fn limit(&self) -> usize {
        self.most
    }

    /// What has come to be held since.
    pub fn used(&self) -> usize {
        usize::try_from(task_memory::live_bytes() - self.base.get()).unwrap_or(0)
    }

    /// Whether that is more than it may be, or this is to end anyway.
    pub fn is_spent(&self) -> bool {
        self.used() > self.most || self.is_aborted()
    }
}
