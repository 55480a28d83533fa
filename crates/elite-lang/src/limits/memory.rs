//! The memory account: what the allocations of an OS thread come to, and the alarm when that is more than a task may
//! hold.
//!
//! Owns the global allocator, which hands every request to the system and counts it for the thread that makes it.
//! Linking this crate installs it, so no interpreter runs unlimited. A task counts what its thread has come to hold
//! since its interpreter was made: numbers, small objects, tables, compiled text, whatever a library allocates on its
//! behalf. Small blocks that are freed wait on shelves (`shelves`) for the next request of their size.
//!
//! Two things are said by hand: memory that does not come from the allocator (`add_external`, `remove_external`), and
//! memory that changes its thread. What is made for another thread, or freed on behalf of one, goes through
//! `uncounted`: otherwise the account of a task that runs for days would drift.
//!
//! The fuel of the running script thread lies here as well: the alarm withholds it, so the next safepoint looks at the
//! account, however much or little was left, and a loop that only counts fuel costs nothing more.

use std::alloc::{GlobalAlloc, Layout};
use std::cell::Cell;

use platform::memory::{self as pages, PAGE, System};
use platform::overflow::touch_ahead;

use super::shelves::{self, SizeClass};

/// Hands requests to the system and counts them.
pub struct CountingAllocator;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

struct ThreadAccount {
    /// Bytes that this thread has from the system, those on its shelves included; less than nothing if it frees what
    /// others have made.
    allocated: Cell<isize>,
    /// Beyond this the fuel is withheld.
    alarm: Cell<isize>,
    /// Safepoints that may be passed.
    fuel: Cell<u32>,
    /// What was taken from `fuel` by the alarm, until somebody has looked.
    suspended_fuel: Cell<Option<u32>>,
    /// Big blocks are left to `unmap_deferred`.
    defers_unmap: Cell<bool>,
    /// Pages that are to be given back.
    unmap_queue: Cell<pages::DeferredUnmap>,
}

thread_local! {
    static ACCOUNT: ThreadAccount = const {
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

/// From this size on a block has pages of its own (`pages`): it grows without being copied, and what is freed of it is
/// the system's again at once.
const MMAP_MIN: usize = 1 << 20;

/// Whether a request is met with pages of its own.
#[inline(always)]
fn is_mapped(size: usize, align: usize) -> bool {
    cfg!(target_os = "linux") && size >= MMAP_MIN && align <= PAGE
}

/// What a request costs: the size the system rounds it up to.
#[inline(always)]
fn cost(size: usize, align: usize) -> isize {
    let size = if size >= MMAP_MIN {
        size.saturating_add(PAGE - 1) & !(PAGE - 1)
    } else {
        pages::rounded_size(size)
    };
    let padding = if align > ALIGN { align } else { 0 };
    size.saturating_add(padding) as isize
}

/// How the system aligns what it is asked for without more words.
const ALIGN: usize = 16;

impl ThreadAccount {
    #[inline(always)]
    fn add(&self, bytes: isize) {
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

#[inline(always)]
fn count(bytes: isize) {
    // Neither initialised nor dropped, so it is there as long as the thread is.
    let _ = ACCOUNT.try_with(|account| account.add(bytes));
}

/// A block of the system, or with pages of its own, counted.
///
/// # Safety
/// As for `GlobalAlloc::alloc`.
#[cold]
#[inline(never)]
#[allow(unsafe_code)]
unsafe fn alloc_anew(layout: Layout) -> *mut u8 {
    touch_ahead();
    let block = if is_mapped(layout.size(), layout.align()) {
        pages::map(layout.size())
    } else {
        let whole = SizeClass::of(layout).map_or(layout, SizeClass::layout);
        // SAFETY: the caller's promises; a layout of a shelf is not empty.
        unsafe { System.alloc(whole) }
    };
    if !block.is_null() {
        count(cost(layout.size(), layout.align()));
    }
    block
}

// SAFETY: a block comes from `pages` if its layout is big, else from the system's allocator, for the layout asked for
// or, if that is small, for the larger one of its shelf. Which of these depends on the layout alone: whoever frees or
// enlarges the block finds the same. A block is either in use or on one shelf. Counting touches a cell of the thread
// only, which allocates nothing and cannot unwind.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for CountingAllocator {
    #[inline]
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if let Some(size) = SizeClass::of(layout) {
            let block = shelves::pop(size);
            if !block.is_null() {
                return block;
            }
        }
        // SAFETY: the caller's promises are those that it asks for.
        unsafe { alloc_anew(layout) }
    }

    #[inline]
    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        if SizeClass::of(layout).is_none() {
            touch_ahead();
            let block = if is_mapped(layout.size(), layout.align()) {
                // Fresh pages are zero.
                pages::map(layout.size())
            } else {
                // SAFETY: as in `alloc`.
                unsafe { System.alloc_zeroed(layout) }
            };
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
        if let Some(size) = SizeClass::of(layout) {
            // SAFETY: the block was made for this layout, so for this size, and nobody uses it any more.
            return unsafe { shelves::put(block, size) };
        }
        touch_ahead();
        if is_mapped(layout.size(), layout.align()) {
            // SAFETY: a block of this layout was made by `pages`, and its owner gives it back.
            unsafe { give_back(block, layout.size()) };
        } else {
            // SAFETY: as in `alloc`; the layout is none of a shelf.
            unsafe { System.dealloc(block, layout) };
        }
        count(-cost(layout.size(), layout.align()));
    }

    #[inline]
    unsafe fn realloc(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // SAFETY: the caller says that the size is one a layout can have with this alignment.
        let new = unsafe { Layout::from_size_align_unchecked(size, layout.align()) };
        if SizeClass::of(layout).is_none() && SizeClass::of(new).is_none() {
            touch_ahead();
            let is_mapped =
                is_mapped(layout.size(), layout.align()) || is_mapped(size, layout.align());
            let moved = if is_mapped {
                // SAFETY: as in `alloc`.
                unsafe { self.resize(block, layout, size) }
            } else {
                // SAFETY: as in `alloc`.
                unsafe { System.realloc(block, layout, size) }
            };
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

/// Bytes of pages that are given back at once: the system takes some milliseconds for ten times as many.
const UNMAP_CHUNK: usize = 4 << 20;

/// From now on (or no longer, `false`) big blocks are given back bit by bit, by `unmap_deferred`.
pub(crate) fn set_unmap_deferred(on: bool) {
    let _ = ACCOUNT.try_with(|account| account.defers_unmap.set(on));
}

/// Gives back a block of `pages`, or the most of it later.
///
/// # Safety
/// As `pages::unmap`.
#[allow(unsafe_code)]
unsafe fn give_back(block: *mut u8, size: usize) {
    let later = |account: &ThreadAccount| {
        let is_put_off = size > UNMAP_CHUNK && account.defers_unmap.get();
        if is_put_off {
            // SAFETY: the caller's promise.
            account
                .unmap_queue
                .set(unsafe { account.unmap_queue.get().with(block, size) });
        }
        is_put_off
    };
    if !ACCOUNT.try_with(later).unwrap_or(false) {
        // SAFETY: the caller's promise.
        unsafe { pages::unmap(block, size) };
    }
}

impl CountingAllocator {
    /// `realloc` where the old block or the new one has pages of its own; not counted.
    ///
    /// # Safety
    /// As `GlobalAlloc::realloc`.
    #[cold]
    #[inline(never)]
    #[allow(unsafe_code)]
    unsafe fn resize(&self, block: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        let align = layout.align();
        let was = is_mapped(layout.size(), align);
        if was && is_mapped(size, align) {
            // SAFETY: a block of this layout was made by `pages`, and its owner gives it up for the new one.
            return unsafe { pages::remap(block, layout.size(), size) };
        }
        let moved = if was {
            // SAFETY: the size is not zero, and the caller has promised that it fits the alignment.
            unsafe { System.alloc(Layout::from_size_align_unchecked(size, align)) }
        } else {
            pages::map(size)
        };
        if moved.is_null() {
            return moved;
        }
        // SAFETY: both blocks have that many bytes and are apart; the old one is given back as it was made.
        unsafe {
            std::ptr::copy_nonoverlapping(block, moved, layout.size().min(size));
            if was {
                pages::unmap(block, layout.size());
            } else {
                System.dealloc(block, layout);
            }
        }
        moved
    }
}

/// Bytes the allocations of this thread come to; less than nothing if it frees what others have made.
pub fn live_bytes() -> isize {
    allocated_bytes() - shelves::cost()
}

/// The same with what lies on the shelves of this thread, which changes little; found out at once.
pub(crate) fn allocated_bytes() -> isize {
    ACCOUNT.with(|account| account.allocated.get())
}

/// Counts memory that does not come from the allocator, or that another thread has made for this one.
pub(crate) fn add_external(bytes: usize) {
    count(bytes as isize);
}

/// The end of what was counted with `add_external`, or of memory that another thread will free.
pub(crate) fn remove_external(bytes: usize) {
    count(-(bytes as isize));
}

/// Runs `work` for others: what it allocates and frees is not counted. For messages to other threads, and for whatever
/// else is made here and freed elsewhere, or the other way round.
pub fn uncounted<T>(work: impl FnOnce() -> T) -> T {
    /// Puts the account back, also when `work` unwinds.
    struct RestoreAccount {
        held: isize,
        alarm: isize,
    }
    impl Drop for RestoreAccount {
        fn drop(&mut self) {
            let _ = ACCOUNT.try_with(|account| {
                account.allocated.set(self.held + shelves::cost());
                account.alarm.set(self.alarm);
            });
        }
    }
    let held = live_bytes();
    let back = ACCOUNT.with(|account| RestoreAccount {
        held,
        alarm: account.alarm.replace(isize::MAX),
    });
    let result = work();
    drop(back);
    result
}

/// Runs `work` for others, as `uncounted` does, and brings a copy of its result in.
pub fn clone_uncounted<T: Clone>(work: impl FnOnce() -> T) -> T {
    let theirs = uncounted(work);
    let own = theirs.clone();
    uncounted(|| drop(theirs));
    own
}

/// What work on a text may take on this thread: bytes that it comes to hold, and time until others have their turn.
pub(crate) struct WorkBudget<'p> {
    base: Cell<isize>,
    most: usize,
    /// Units of work (`eval::pace`) since the last pause.
    work: Cell<usize>,
    /// Lets others have their turn, after so much work; false if the work is to be given up.
    pause: Option<&'p dyn Fn(usize) -> bool>,
    given_up: Cell<bool>,
}

/// Work to drop something small, in units of `eval::pace`.
pub(crate) const WORK_PER_DROP: usize = 96;
/// Work after which a pause is asked for.
const PAUSE_AFTER: usize = 1 << 13;

impl<'p> WorkBudget<'p> {
    /// `limit` bytes more than this thread holds now, and no pauses.
    pub(crate) fn with_limit(most: usize) -> Self {
        WorkBudget {
            base: Cell::new(live_bytes()),
            most,
            work: Cell::new(0),
            pause: None,
            given_up: Cell::new(false),
        }
    }

    /// The same with pauses: `pause` is told how much work has been done, and says whether to go on.
    pub(crate) fn with_pauses(most: usize, pause: &'p dyn Fn(usize) -> bool) -> Self {
        WorkBudget {
            pause: Some(pause),
            ..WorkBudget::with_limit(most)
        }
    }

    /// Counts work, and pauses when it is time to. Nothing that scripts can reach may be borrowed.
    #[inline]
    pub(crate) fn charge(&self, units: usize) {
        let work = self.work.get() + units;
        self.work.set(work);
        if work >= PAUSE_AFTER {
            self.yield_to_others();
        }
    }

    /// Drops many parts of something, with pauses.
    pub(crate) fn drop_each<T>(&self, parts: impl IntoIterator<Item = T>) {
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
            let before = live_bytes();
            self.given_up.set(!pause(work));
            // What others have taken meanwhile is not this work's.
            self.base.set(self.base.get() + live_bytes() - before);
        }
    }

    /// Whether a pause has said that this is to end; then only the way out is taken.
    pub(crate) fn is_aborted(&self) -> bool {
        self.given_up.get()
    }

    /// How much it may be.
    pub(crate) fn limit(&self) -> usize {
        self.most
    }

    /// What has come to be held since.
    pub(crate) fn used(&self) -> usize {
        usize::try_from(live_bytes() - self.base.get()).unwrap_or(0)
    }

    /// Whether that is more than it may be, or this is to end anyway.
    pub(crate) fn is_spent(&self) -> bool {
        self.used() > self.most || self.is_aborted()
    }
}

/// Has the fuel withheld once this thread holds more than `bytes`; `isize::MAX` never does. What lies on its shelves
/// now may come to be held without that.
pub(crate) fn set_alarm(bytes: isize) {
    let alarm = bytes.saturating_add(shelves::cost());
    ACCOUNT.with(|account| account.alarm.set(alarm));
}

/// Whether the alarm has gone off since the last call; gives the fuel back.
#[inline]
pub(crate) fn take_alarm() -> bool {
    ACCOUNT.with(|account| {
        let Some(fuel) = account.suspended_fuel.take() else {
            return false;
        };
        account.fuel.set(fuel);
        true
    })
}

/// Takes one unit of the running script thread's fuel; false if there is none to be had.
#[inline(always)]
pub(crate) fn consume_fuel() -> bool {
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
    ACCOUNT.with(|account| account.suspended_fuel.get().unwrap_or(account.fuel.get()))
}

/// Sets the fuel; while the alarm stands it stays withheld.
pub(crate) fn set_fuel(fuel: u32) {
    ACCOUNT.with(|account| match account.suspended_fuel.get() {
        Some(_) => account.suspended_fuel.set(Some(fuel)),
        None => account.fuel.set(fuel),
    });
}

/// Gives back some of what `set_unmap_deferred` has left; whether there is more.
pub(crate) fn unmap_deferred() -> bool {
    let given_back = |account: &ThreadAccount| {
        let left = account.unmap_queue.get().without(UNMAP_CHUNK);
        account.unmap_queue.set(left);
        !left.is_empty()
    };
    ACCOUNT.try_with(given_back).unwrap_or(false)
}

/// Gives back the blocks that wait on the shelves of this thread: a few of them keep whole pages of the system's
/// allocator in use.
pub(crate) fn clear_shelves() {
    shelves::clear();
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test

    use super::*;

    #[test]
    fn every_allocation_of_a_thread_is_counted_until_it_is_freed() {
        let before = live_bytes();
        let mut buffer: Vec<u8> = Vec::with_capacity(1000);
        assert_eq!(live_bytes() - before, 1024);
        buffer.reserve_exact(1 << 20);
        assert!(
            live_bytes() - before >= 1 << 20,
            "{}",
            live_bytes() - before
        );
        let small: Vec<Box<u8>> = (0..100).map(Box::new).collect();
        assert!(live_bytes() - before >= (1 << 20) + 100 * (8 + 16));
        drop((buffer, small));
        assert_eq!(live_bytes() - before, 0);
    }

    #[test]
    fn blocks_keep_their_contents_from_one_way_of_being_kept_to_the_other() {
        let before = live_bytes();
        let mut block: Vec<u32> = (0..1000).collect();
        for words in [
            MMAP_MIN / 4,
            MMAP_MIN,
            4 * MMAP_MIN,
            MMAP_MIN / 2,
            MMAP_MIN / 4 + 1,
            2000,
            1000,
        ] {
            if words > block.capacity() {
                block.reserve_exact(words - block.len());
            } else {
                block.shrink_to(words);
            }
            assert!(block.capacity() >= words);
            assert!(block.iter().copied().eq(0..1000), "{words}");
        }
        drop(block);
        let zeroed = vec![0_u8; 3 * MMAP_MIN + 5];
        assert!(zeroed.iter().all(|byte| *byte == 0));
        drop(zeroed);
        assert_eq!(live_bytes() - before, 0);
    }

    #[test]
    fn big_blocks_go_back_bit_by_bit() {
        let before = live_bytes();
        let blocks = [
            vec![1_u8; 9 << 20],
            vec![2_u8; (5 << 20) + 1],
            vec![3_u8; 1 << 20],
        ];
        set_unmap_deferred(true);
        drop(blocks);
        set_unmap_deferred(false);
        assert_eq!(live_bytes() - before, 0);
        // Two of them, in pieces of at most four megabytes, the last piece of each smaller.
        assert!(
            unmap_deferred()
                && unmap_deferred()
                && unmap_deferred()
                && unmap_deferred()
                && !unmap_deferred()
        );
    }

    #[test]
    fn what_is_done_for_others_leaves_no_trace() {
        let before = live_bytes();
        let made = uncounted(|| vec![1_u8; 5000]);
        assert_eq!(live_bytes(), before);
        uncounted(|| drop(made));
        assert_eq!(live_bytes(), before);
    }

    #[test]
    fn the_alarm_withholds_the_fuel_until_somebody_looks() {
        set_fuel(7);
        set_alarm(live_bytes() + 10_000);
        let small = vec![0_u8; 5_000];
        assert!(consume_fuel() && !take_alarm());
        let big = vec![0_u8; 10_000];
        assert!(!consume_fuel());
        assert_eq!(fuel(), 6);
        set_fuel(9);
        assert!(!consume_fuel(), "new fuel stays withheld too");
        assert!(take_alarm());
        assert_eq!(fuel(), 9);
        assert!(consume_fuel());
        drop((small, big));
        set_alarm(isize::MAX);
    }
}
