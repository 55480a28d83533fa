//! The account of a thread: bytes that it holds, the alarm, and what is counted by hand.
//!
//! Two things are counted by hand: memory that does not come from the allocator (`add_external`, `remove_external`),
//! and memory that changes its thread. Whatever is made for another thread, or freed on behalf of one, goes through
//! `uncounted`: otherwise the account of a task that runs for days would drift.

use std::cell::Cell;

use platform::memory as pages;

use crate::free_lists;

pub(crate) struct ThreadAccount {
    /// Bytes that this thread has from the system, those in its free lists included; negative if it frees blocks of
    /// other threads.
    pub(crate) allocated: Cell<isize>,
    /// Beyond this the fuel is withheld.
    pub(crate) alarm: Cell<isize>,
    /// Safepoints that may be passed.
    pub(crate) fuel: Cell<u32>,
    /// What was taken from `fuel` by the alarm, until a safepoint has compared.
    pub(crate) suspended_fuel: Cell<Option<u32>>,
    /// Big blocks are given back by `unmap_deferred` only.
    pub(crate) defers_unmap: Cell<bool>,
    /// Pages that are to be given back.
    pub(crate) unmap_queue: Cell<pages::DeferredUnmap>,
}

thread_local! {
    pub(crate) static ACCOUNT: ThreadAccount = const {
        ThreadAccount {
            allocated: Cell::new(0),
            alarm: Cell::new(isize::MAX),
            fuel: Cell::new(0),
            suspended_fuel: Cell::new(None),
            defers_unmap: Cell::new(false),
            unmap_queue: Cell::new(pages::DeferredUnmap::NONE),
        }
    };
}

impl ThreadAccount {
    #[inline(always)]
    pub(crate) fn add(&self, bytes: isize) {
        let taken = self.allocated.get() + bytes;
        self.allocated.set(taken);
        if taken > self.alarm.get() {
            self.raise_alarm();
        }
    }

    #[cold]
    #[inline(never)]
    fn raise_alarm(&self) {
        self.alarm.set(isize::MAX);
        if self.suspended_fuel.get().is_none() {
            self.suspended_fuel.set(Some(self.fuel.replace(0)));
        }
    }
}

/// Counts bytes that this thread takes (or gives back, below zero).
#[inline(always)]
pub(crate) fn count(bytes: isize) {
    // Neither initialised nor dropped, so it is there as long as the thread is.
    let _ = ACCOUNT.try_with(|account| account.add(bytes));
}

/// Bytes of the allocations of this thread; negative if it frees blocks of other threads.
pub fn live_bytes() -> isize {
    allocated_bytes() - free_lists::cost()
}

/// Live bytes together with the free lists of this thread, whose size changes little. One load, so it may be asked
/// often.
#[inline]
pub fn allocated_bytes() -> isize {
    ACCOUNT.with(|account| account.allocated.get())
}

/// Counts memory that does not come from the allocator, or that another thread has made for this one.
pub fn add_external(bytes: usize) {
    count(bytes as isize);
}

/// The end of what was counted with `add_external`, or of memory that another thread will free.
pub fn remove_external(bytes: usize) {
    count(-(bytes as isize));
}

/// Runs `work` without counting what it allocates and frees: for messages to other threads, and for everything else
/// that is made on one thread and freed on another.
pub fn uncounted<T>(work: impl FnOnce() -> T) -> T {
    /// Puts the account back, also when `work` unwinds.
    struct RestoreAccount {
        live: isize,
        alarm: isize,
    }
    impl Drop for RestoreAccount {
        fn drop(&mut self) {
            let _ = ACCOUNT.try_with(|account| {
                account.allocated.set(self.live + free_lists::cost());
                account.alarm.set(self.alarm);
            });
        }
    }
    let live = live_bytes();
    let back = ACCOUNT.with(|account| RestoreAccount {
        live,
        alarm: account.alarm.replace(isize::MAX),
    });
    let result = work();
    drop(back);
    result
}

/// Runs `work` uncounted and returns a counted copy of its result.
pub fn clone_uncounted<T: Clone>(work: impl FnOnce() -> T) -> T {
    let foreign = uncounted(work);
    let own = foreign.clone();
    uncounted(|| drop(foreign));
    own
}

/// Withholds the fuel once this thread holds more than `bytes`; `isize::MAX` never does. Blocks of its free lists do
/// not count as held; taking one of them raises no alarm.
pub fn set_alarm(bytes: isize) {
    let alarm = bytes.saturating_add(free_lists::cost());
    ACCOUNT.with(|account| account.alarm.set(alarm));
}

/// Whether the alarm has gone off since the last call; gives the fuel back.
#[inline]
pub fn take_alarm() -> bool {
    ACCOUNT.with(|account| {
        let Some(fuel) = account.suspended_fuel.take() else {
            return false;
        };
        account.fuel.set(fuel);
        true
    })
}
