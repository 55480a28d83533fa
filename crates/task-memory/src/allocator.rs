//! The global allocator: hands requests to the system and counts them for the thread that makes them.
//!
//! Small blocks that are freed go to free lists (`free_lists`); blocks of a megabyte and more have pages of their own.

use std::alloc::{GlobalAlloc, Layout};

use platform::memory::{self as pages, PAGE, System};
use platform::overflow::touch_ahead;

use crate::account::{ACCOUNT, ThreadAccount, count};
use crate::free_lists::{self, SizeClass};

/// Hands requests to the system and counts them.
pub struct CountingAllocator;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

/// From this size on a block has pages of its own (`pages`): it grows without being copied, and freed
/// pages go back to the system at once.
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
        // SAFETY: the caller's promises; a layout of a size class is not empty.
        unsafe { System.alloc(whole) }
    };
    if !block.is_null() {
        count(cost(layout.size(), layout.align()));
    }
    block
}

// SAFETY: a block comes from `pages` if its layout is big, else from the system's allocator, for the layout asked for
// or, if that is small, for the larger one of its size class. Which of these depends on the layout alone: whoever frees
// or enlarges the block finds the same. A block is either in use or in one free list. Counting touches a cell of the
// thread only, which allocates nothing and cannot unwind.
#[allow(unsafe_code)]
unsafe impl GlobalAlloc for CountingAllocator {
    #[inline]
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        if let Some(size) = SizeClass::of(layout) {
            let block = free_lists::pop(size);
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
            return unsafe { free_lists::put(block, size) };
        }
        touch_ahead();
        if is_mapped(layout.size(), layout.align()) {
            // SAFETY: a block of this layout was made by `pages`, and its owner gives it back.
            unsafe { give_back(block, layout.size()) };
        } else {
            // SAFETY: as in `alloc`; the layout has no size class.
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

/// Whether freed big blocks are given back in portions, by `unmap_deferred`.
pub fn set_unmap_deferred(on: bool) {
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

/// Gives back one portion of the deferred pages; whether there are more.
pub fn unmap_deferred() -> bool {
    let given_back = |account: &ThreadAccount| {
        let left = account.unmap_queue.get().without(UNMAP_CHUNK);
        account.unmap_queue.set(left);
        !left.is_empty()
    };
    ACCOUNT.try_with(given_back).unwrap_or(false)
}

/// Gives back the blocks in the free lists of this thread: a few of them keep whole pages of the system's
/// allocator in use.
pub fn clear_free_lists() {
    free_lists::clear();
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test

    use super::*;
    use crate::{consume_fuel, fuel, live_bytes, set_alarm, set_fuel, take_alarm, uncounted};

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
