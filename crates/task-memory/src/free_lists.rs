//! Small blocks of memory that wait for the next request of their size: taking one from a free list and putting it back
//! is a few instructions, a request to the system a hundred.
//!
//! Owns one list for each size class, for each thread. A block in a list belongs to nobody: the account counts what
//! comes from the system and subtracts the lists, so that a block costs it nothing on its way in and out. A list is so
//! short that it does not matter, and goes back to the system when its thread ends.

use std::alloc::{GlobalAlloc, Layout};
use std::cell::Cell;
use std::ptr::null_mut;

use platform::memory::{System, rounded_size};

/// Number of small sizes: 16, 32, 48 … bytes.
const SIZES: usize = 16;
/// Bytes in one list at most.
const LIST_BYTES_MAX: usize = 32 << 10;

/// One of the small sizes.
#[derive(Clone, Copy)]
pub(super) struct SizeClass(usize);

impl SizeClass {
    /// The size of a block for this layout; None if it is not small, or aligned more than usual.
    #[inline(always)]
    pub(super) fn of(layout: Layout) -> Option<SizeClass> {
        let index = layout.size().saturating_sub(1) / 16;
        (index < SIZES && layout.align() <= 16).then_some(SizeClass(index))
    }

    #[inline(always)]
    const fn bytes(self) -> usize {
        16 * self.0 + 16
    }

    /// Blocks of this size in a free list at most.
    const fn most(self) -> usize {
        LIST_BYTES_MAX / self.bytes()
    }

    /// What a block costs.
    #[inline(always)]
    pub(super) fn cost(self) -> isize {
        rounded_size(self.bytes()) as isize
    }

    /// The layout of a block on the list.
    #[inline(always)]
    pub(super) fn layout(self) -> Layout {
        // SAFETY: the alignment is a power of two, and the size is far from the largest one.
        #[allow(unsafe_code)]
        unsafe {
            Layout::from_size_align_unchecked(self.bytes(), 16)
        }
    }
}

/// A block in a free list: its first word leads to the next one.
struct FreeBlock {
    next: *mut FreeBlock,
}

/// The blocks of one size.
struct FreeList {
    first: Cell<*mut FreeBlock>,
    /// Blocks that may still be put there.
    spare_blocks: Cell<usize>,
}

struct FreeLists([FreeList; SIZES]);

/// Empty lists.
const fn empty() -> [FreeList; SIZES] {
    let mut lists = [const {
        FreeList {
            first: Cell::new(null_mut()),
            spare_blocks: Cell::new(0),
        }
    }; SIZES];
    let mut index = 0;
    while index < SIZES {
        lists[index].spare_blocks = Cell::new(SizeClass(index).most());
        index += 1;
    }
    lists
}

thread_local! {
    static FREE_LISTS: FreeLists = const { FreeLists(empty()) };
}

/// A block of this size; null if none lies there.
#[inline(always)]
pub(super) fn pop(size: SizeClass) -> *mut u8 {
    let taken = FREE_LISTS.try_with(|lists| {
        let list = &lists.0[size.0];
        let block = list.first.get();
        if !block.is_null() {
            // SAFETY: what lies in a free list is a block of its size that nobody uses, whose first word `put` has
            // written.
            #[allow(unsafe_code)]
            list.first.set(unsafe { (*block).next });
            list.spare_blocks.set(list.spare_blocks.get() + 1);
        }
        block
    });
    taken.unwrap_or(null_mut()).cast()
}

/// Takes a block back.
///
/// # Safety
/// `block` comes from `pop` with the same size, or from the system with the layout of the size, and nobody uses it any
/// more.
#[inline(always)]
#[allow(unsafe_code)]
pub(super) unsafe fn put(block: *mut u8, size: SizeClass) {
    let kept = FREE_LISTS.try_with(|lists| {
        let list = &lists.0[size.0];
        let Some(room) = list.spare_blocks.get().checked_sub(1) else {
            return false;
        };
        let block: *mut FreeBlock = block.cast();
        // SAFETY: the block has at least one word, is aligned for it, and is ours.
        unsafe {
            block.write(FreeBlock {
                next: list.first.get(),
            });
        }
        list.first.set(block);
        list.spare_blocks.set(room);
        true
    });
    if !matches!(kept, Ok(true)) {
        // SAFETY: the caller's promise; it says where such a block comes from.
        unsafe { release_block(block, size) };
    }
}

#[cold]
#[inline(never)]
#[allow(unsafe_code)]
unsafe fn release_block(block: *mut u8, size: SizeClass) {
    platform::overflow::touch_ahead();
    crate::account::remove_external(size.cost() as usize);
    // SAFETY: the caller's promise.
    unsafe { System.dealloc(block, size.layout()) };
}

/// What the blocks in the free lists of this thread cost.
pub(super) fn cost() -> isize {
    let cost = |lists: &FreeLists| {
        let each = lists.0.iter().zip(0..).map(|(list, index)| {
            let blocks = SizeClass(index).most() - list.spare_blocks.get();
            blocks as isize * SizeClass(index).cost()
        });
        each.sum()
    };
    FREE_LISTS.try_with(cost).unwrap_or(0)
}

/// Gives what lies in the free lists of this thread back to the system.
pub(super) fn clear() {
    let _ = FREE_LISTS.try_with(FreeLists::clear);
}

impl FreeLists {
    fn clear(&self) {
        for (list, index) in self.0.iter().zip(0..) {
            let mut block = list.first.replace(null_mut());
            list.spare_blocks.set(SizeClass(index).most());
            while !block.is_null() {
                // SAFETY: as in `pop`; the list no longer has any of these blocks.
                #[allow(unsafe_code)]
                unsafe {
                    let next = (*block).next;
                    release_block(block.cast(), SizeClass(index));
                    block = next;
                }
            }
        }
    }
}

impl Drop for FreeLists {
    fn drop(&mut self) {
        self.clear();
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)] // a test

    use super::*;

    #[test]
    fn every_small_layout_fits_its_size_and_no_block_is_given_twice() {
        for bytes in 1..=16 * SIZES {
            let layout = Layout::from_size_align(bytes, 16).unwrap();
            let size = SizeClass::of(layout).unwrap();
            assert!(
                size.bytes() >= bytes && size.bytes() < bytes + 16,
                "{bytes}"
            );
            assert_eq!(size.cost(), rounded_size(bytes) as isize);
        }
        assert!(SizeClass::of(Layout::from_size_align(16 * SIZES + 1, 8).unwrap()).is_none());
        assert!(SizeClass::of(Layout::from_size_align(32, 32).unwrap()).is_none());
        let mut blocks: Vec<Box<[u8; 40]>> = (0..5000).map(|_| Box::new([7; 40])).collect();
        let mut places: Vec<usize> = blocks.iter().map(|b| b.as_ptr() as usize).collect();
        places.sort_unstable();
        places.dedup();
        assert_eq!(places.len(), 5000);
        blocks.truncate(10);
        let again: Vec<Box<[u8; 40]>> = (0..5000).map(|_| Box::new([9; 40])).collect();
        assert!(blocks.iter().all(|block| **block == [7; 40]));
        assert!(again.iter().all(|block| **block == [9; 40]));
    }

    #[test]
    fn blocks_grow_and_shrink_between_small_and_large_with_what_is_in_them() {
        let mut data: Vec<u8> = Vec::new();
        for round in 0..2000_usize {
            data.push(round as u8);
            if round % 97 == 0 {
                data.shrink_to_fit();
            }
        }
        assert!(
            data.iter()
                .zip(0..2000_usize)
                .all(|(byte, round)| *byte == round as u8)
        );
        while data.len() > 3 {
            data.truncate(data.len() / 2);
            data.shrink_to_fit();
        }
        assert_eq!(data, [0, 1, 2]);
    }

    #[test]
    fn a_block_may_be_freed_by_another_thread_and_after_its_own_has_ended() {
        let made = std::thread::spawn(|| (0..1000).map(|n| Box::new([n; 4])).collect::<Vec<_>>());
        let made: Vec<Box<[i32; 4]>> = made.join().unwrap();
        assert!(made.iter().zip(0..).all(|(block, n)| **block == [n; 4]));
        drop(made);
        clear();
        assert_eq!(vec![1_u64; 3], [1, 1, 1]);
    }
}
