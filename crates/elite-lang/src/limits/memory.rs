//! The memory account: what the allocations of an OS thread come to, and the alarm when that is more than a task may hold.
//!
//! Owns the global allocator, which hands every request to the system and counts it for the thread that makes it. Linking
//! this crate installs it, so no interpreter runs unlimited. A task counts what its thread has come to hold since its
//! interpreter was made: numbers, small objects, tables, compiled text, whatever a library allocates on its behalf. Small
//! blocks that are freed wait on shelves (`shelves`) for the next request of their size.
//!
//! Two things are said by hand: memory that does not come from the allocator (`hold`, `let_go`), and memory that changes
//! its thread. What is made for another thread, or freed on behalf of one, goes through `outside`: otherwise the account
//! of a task that runs for days would drift.
//!
//! The fuel of the running script thread lies here as well: the alarm withholds it, so the next safepoint looks at the
//! account, however much or little was left, and a loop that only counts fuel costs nothing more.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use super::shelves::{self, Size};

/// Hands requests to the system and counts them.
pub struct CountingAllocator;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

struct Account {
    /// Bytes the allocations of this thread come to; less than nothing if it frees what others have made.
    held: Cell<isize>,
    /// Beyond this the fuel is withheld.
    alarm: Cell<isize>,
    /// Safepoints that may be passed.
    fuel: Cell<u32>,
    /// What was taken from `fuel` by the alarm, until somebody has looked.
    withheld: Cell<Option<u32>>,
}

thread_local! {
    static ACCOUNT: Account = const {
        Account {
            held: Cell::new(0),
            alarm: Cell::new(isize::MAX),
            fuel: Cell::new(0),
            withheld: Cell::new(None),
        }
    };
}

/// From this size on the system maps pages of their own (`settle`): such a block grows without being copied, and what is
/// freed of it is the system's again at once.
const MAPPED: usize = 1 << 20;
const PAGE: usize = 4096;

/// What a request costs: the size the system rounds it up to, its own header included.
#[inline(always)]
fn cost(size: usize, align: usize) -> isize {
    let size = if size >= MAPPED {
        size.saturating_add(16 + PAGE - 1) & !(PAGE - 1)
    } else if size <= 24 {
        32
    } else {
        (size + 8 + 15) & !15
    };
    let padding = if align > 16 { align } else { 0 };
    size.saturating_add(padding) as isize
}

impl Account {
    #[inline(always)]
    fn add(&self, bytes: isize) {
        let held = self.held.get() + bytes;
        self.held.set(held);
        if held > self.alarm.get() {
            self.raise_alarm();
        }
    }

    #[cold]
    #[inline(never)]
    fn raise_alarm(&self) {
        self.alarm.set(isize::MAX);
        if self.withheld.get().is_none() {
            self.withheld.set(Some(self.fuel.replace(0)));
        }
    }
}

#[inline(always)]
fn count(bytes: isize) {
    // Neither initialised nor dropped, so it is there as long as the thread is.
    let _ = ACCOUNT.try_with(|account| account.add(bytes));
}

/// A block of the system, counted.
///
/// # Safety
/// As for `GlobalAlloc::alloc`.
#[cold]
#[inline(never)]
#[allow(unsafe_code)]
unsafe fn alloc_of_system(layout: Layout) -> *mut u8 {
    let whole = Size::of(layout).map_or(layout, Size::layout);
    // SAFETY: the caller's promises; a layout of a shelf is not empty.
    let block = unsafe { System.alloc(whole) };
    if !block.is_null() {
        count(cost(layout.size(), layout.align()));
    }
    block
}

// SAFETY: a block comes from the system's allocator, for the layout asked for or, if that is small, for the larger one of
// its shelf, which depends on the layout alone: whoever frees or enlarges the block finds the same. A block is either in use
// or on one shelf. Counting touches a cell of the thread only, which allocates nothing and cannot unwind.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for CountingAllocator {
    #[inline]
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if let Some(size) = Size::of(layout) {
            let block = shelves::take(size);
            if !block.is_null() {
                count(size.cost());
                return block;
            }
        }
        // SAFETY: the caller's promises are those that it asks for.
        unsafe { alloc_of_system(layout) }
    }

    #[inline]
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if Size::of(layout).is_none() {
            // SAFETY: as in `alloc`.
            let block = unsafe { System.alloc_zeroed(layout) };
            if !block.is_null() {
                count(cost(layout.size(), layout.align()));
            }
            return block;
        }
        // SAFETY: as in `alloc`; a block that was made has at least as many bytes.
        unsafe {
            let block = self.alloc(layout);
            if !block.is_null() {
                block.write_bytes(0, layout.size());
            }
            block
        }
    }

    #[inline]
    unsafe fn dealloc(&self, block: *mut u8, layout: Layout) {
        if let Some(size) = Size::of(layout) {
            count(-size.cost());
            // SAFETY: the block was made for this layout, so for this size, and nobody uses it any more.
            return unsafe { shelves::put(block, size) };
        }
        // SAFETY: as in `alloc`; the layout is none of a shelf.
        unsafe { System.dealloc(block, layout) };
        count(-cost(layout.size(), layout.align()));
    }

    #[inline]
    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller says that the size is one a layout can have with this alignment.
        let new = unsafe { Layout::from_size_align_unchecked(size, layout.align()) };
        if Size::of(layout).is_none() && Size::of(new).is_none() {
            // SAFETY: as in `alloc`.
            let moved = unsafe { System.realloc(block, layout, size) };
            if !moved.is_null() {
                count(cost(size, layout.align()) - cost(layout.size(), layout.align()));
            }
            return moved;
        }
        // SAFETY: the caller's promises; the new block is another one with at least `size` bytes.
        unsafe {
            let moved = self.alloc(new);
            if !moved.is_null() {
                moved.copy_from_nonoverlapping(block, layout.size().min(size));
                self.dealloc(block, layout);
            }
            moved
        }
    }
}

/// Bytes the allocations of this thread come to.
pub fn held() -> isize {
    ACCOUNT.with(|account| account.held.get())
}

/// Counts memory that does not come from the allocator, or that another thread has made for this one.
pub(crate) fn hold(bytes: usize) {
    count(bytes as isize);
}

/// The end of what was counted with `hold`, or of memory that another thread will free.
pub(crate) fn let_go(bytes: usize) {
    count(-(bytes as isize));
}

/// Runs `work` for others: what it allocates and frees is not counted. For messages to other threads, and for whatever
/// else is made here and freed elsewhere, or the other way round.
pub fn outside<T>(work: impl FnOnce() -> T) -> T {
    /// Puts the account back, also when `work` unwinds.
    struct Back {
        held: isize,
        alarm: isize,
    }
    impl Drop for Back {
        fn drop(&mut self) {
            let _ = ACCOUNT.try_with(|account| {
                account.held.set(self.held);
                account.alarm.set(self.alarm);
            });
        }
    }
    let back = ACCOUNT.with(|account| Back {
        held: account.held.get(),
        alarm: account.alarm.replace(isize::MAX),
    });
    let result = work();
    drop(back);
    result
}

/// Runs `work` for others, as `outside` does, and brings a copy of its result in.
pub fn copied<T: Clone>(work: impl FnOnce() -> T) -> T {
    let theirs = outside(work);
    let own = theirs.clone();
    outside(|| drop(theirs));
    own
}

/// What work on a text may take on this thread: bytes that it comes to hold, and time until others have their turn.
pub(crate) struct Budget<'p> {
    base: Cell<isize>,
    most: usize,
    /// Units of work (`eval::pace`) since the last pause.
    work: Cell<usize>,
    /// Lets others have their turn, after so much work; false if the work is to be given up.
    pause: Option<&'p dyn Fn(usize) -> bool>,
    given_up: Cell<bool>,
}

/// Work after which a pause is asked for.
const PAUSE_AFTER: usize = 1 << 13;

impl<'p> Budget<'p> {
    /// `most` bytes more than this thread holds now, and no pauses.
    pub(crate) fn of(most: usize) -> Self {
        Budget {
            base: Cell::new(held()),
            most,
            work: Cell::new(0),
            pause: None,
            given_up: Cell::new(false),
        }
    }

    /// The same with pauses: `pause` is told how much work has been done, and says whether to go on.
    pub(crate) fn with_pauses(most: usize, pause: &'p dyn Fn(usize) -> bool) -> Self {
        Budget {
            pause: Some(pause),
            ..Budget::of(most)
        }
    }

    /// Counts work, and pauses when it is time to. Nothing that scripts can reach may be borrowed.
    #[inline]
    pub(crate) fn worked(&self, units: usize) {
        let work = self.work.get() + units;
        self.work.set(work);
        if work >= PAUSE_AFTER {
            self.rest();
        }
    }

    #[cold]
    fn rest(&self) {
        let work = self.work.take();
        if let Some(pause) = self.pause
            && !self.given_up.get()
        {
            let before = held();
            self.given_up.set(!pause(work));
            // What others have taken meanwhile is not this work's.
            self.base.set(self.base.get() + held() - before);
        }
    }

    /// Whether a pause has said that this is to end; then only the way out is taken.
    pub(crate) fn is_given_up(&self) -> bool {
        self.given_up.get()
    }

    /// How much it may be.
    pub(crate) fn most(&self) -> usize {
        self.most
    }

    /// What has come to be held since.
    pub(crate) fn used(&self) -> usize {
        usize::try_from(held() - self.base.get()).unwrap_or(0)
    }

    /// Whether that is more than it may be, or this is to end anyway.
    pub(crate) fn is_spent(&self) -> bool {
        self.used() > self.most || self.is_given_up()
    }
}

/// Has the fuel withheld once this thread holds more than `bytes`; `isize::MAX` never does.
pub(crate) fn set_alarm(bytes: isize) {
    ACCOUNT.with(|account| account.alarm.set(bytes));
}

/// Whether the alarm has gone off since the last call; gives the fuel back.
#[inline]
pub(crate) fn take_alarm() -> bool {
    ACCOUNT.with(|account| {
        let Some(fuel) = account.withheld.take() else {
            return false;
        };
        account.fuel.set(fuel);
        true
    })
}

/// Takes one unit of the running script thread's fuel; false if there is none to be had.
#[inline(always)]
pub(crate) fn burn() -> bool {
    ACCOUNT.with(|account| {
        let fuel = account.fuel.get();
        if fuel == 0 {
            return false;
        }
        account.fuel.set(fuel - 1);
        true
    })
}

/// Fuel that is left, withheld or not.
pub(crate) fn fuel() -> u32 {
    ACCOUNT.with(|account| account.withheld.get().unwrap_or(account.fuel.get()))
}

/// Sets the fuel; while the alarm stands it stays withheld.
pub(crate) fn set_fuel(fuel: u32) {
    ACCOUNT.with(|account| match account.withheld.get() {
        Some(_) => account.withheld.set(Some(fuel)),
        None => account.fuel.set(fuel),
    });
}

/// Tells the system's allocator once and for all from which size on it maps pages of their own. By itself it would raise that
/// to 32 MiB as soon as one such block is freed; then a growing text is copied, and twice its size stays resident.
pub(crate) fn settle() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        static ONCE: std::sync::Once = std::sync::Once::new();
        ONCE.call_once(|| {
            // SAFETY: the calls take numbers only and may be made at any time, from any thread.
            #[allow(unsafe_code)]
            unsafe {
                libc::mallopt(libc::M_MMAP_THRESHOLD, MAPPED as libc::c_int);
                libc::mallopt(libc::M_TRIM_THRESHOLD, 2 * MAPPED as libc::c_int);
            }
        });
    }
}

/// Gives memory that was freed back to the system. Takes some milliseconds for every hundred megabytes.
pub(crate) fn trim() {
    shelves::clear();
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    // SAFETY: the call takes no pointers and may be made at any time, from any thread.
    #[allow(unsafe_code)]
    unsafe {
        libc::malloc_trim(0);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test

    use super::*;

    #[test]
    fn every_allocation_of_a_thread_is_counted_until_it_is_freed() {
        let before = held();
        let mut buffer: Vec<u8> = Vec::with_capacity(1000);
        assert_eq!(held() - before, 1008);
        buffer.reserve_exact(1 << 20);
        assert!(held() - before >= 1 << 20, "{}", held() - before);
        let small: Vec<Box<u8>> = (0..100).map(Box::new).collect();
        assert!(held() - before >= (1 << 20) + 3200);
        drop((buffer, small));
        assert_eq!(held() - before, 0);
    }

    #[test]
    fn what_is_done_for_others_leaves_no_trace() {
        let before = held();
        let made = outside(|| vec![1_u8; 5000]);
        assert_eq!(held(), before);
        outside(|| drop(made));
        assert_eq!(held(), before);
    }

    #[test]
    fn the_alarm_withholds_the_fuel_until_somebody_looks() {
        set_fuel(7);
        set_alarm(held() + 10_000);
        let small = vec![0_u8; 5_000];
        assert!(burn() && !take_alarm());
        let big = vec![0_u8; 10_000];
        assert!(!burn());
        assert_eq!(fuel(), 6);
        set_fuel(9);
        assert!(!burn(), "new fuel stays withheld too");
        assert!(take_alarm());
        assert_eq!(fuel(), 9);
        assert!(burn());
        drop((small, big));
        set_alarm(isize::MAX);
    }
}
