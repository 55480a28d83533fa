//! Blocks of memory with pages of their own. The system's allocator makes such ones, too, but takes a big block from what was
//! freed before if it can, and copies it when it grows: tens of megabytes at once.
//!
//! Owns how pages are got, made more and given back, at once or bit by bit. Which blocks are so big, and what they cost, is the
//! account's business (`memory`). Only Linux has them; elsewhere nobody asks.

/// Bytes of a page.
pub(super) const PAGE: usize = 4096;

pub(super) use imp::{Left, map, remap, unmap};

#[cfg(target_os = "linux")]
mod imp {
    use super::PAGE;

    /// Fresh pages, all zero; null if there are none to be had.
    pub(in crate::limits) fn map(size: usize) -> *mut u8 {
        let access = libc::PROT_READ | libc::PROT_WRITE;
        let kind = libc::MAP_PRIVATE | libc::MAP_ANONYMOUS;
        // SAFETY: a new mapping without an address or a file touches nothing that is there.
        #[allow(unsafe_code)]
        let block = unsafe { libc::mmap(std::ptr::null_mut(), size, access, kind, -1, 0) };
        checked(block)
    }

    /// Another size, with the contents.
    ///
    /// # Safety
    /// `block` is of this module with `size` bytes; if the answer is not null, it is gone.
    #[allow(unsafe_code)]
    pub(in crate::limits) unsafe fn remap(block: *mut u8, size: usize, wanted: usize) -> *mut u8 {
        // SAFETY: the caller's promise.
        checked(unsafe { libc::mremap(block.cast(), size, wanted, libc::MREMAP_MAYMOVE) })
    }

    /// Gives a block back.
    ///
    /// # Safety
    /// `block` is of this module with `size` bytes, and nobody uses it any more.
    #[allow(unsafe_code)]
    pub(in crate::limits) unsafe fn unmap(block: *mut u8, size: usize) {
        // SAFETY: the caller's promise.
        unsafe { libc::munmap(block.cast(), size) };
    }

    /// Blocks that are given back bit by bit. Each has the next one, and its own size, written into its first bytes.
    #[derive(Clone, Copy)]
    pub(in crate::limits) struct Left(*mut Block);

    struct Block {
        next: Left,
        size: usize,
    }

    impl Left {
        pub(in crate::limits) const NONE: Self = Left(std::ptr::null_mut());

        /// With one more.
        ///
        /// # Safety
        /// As `unmap`.
        #[allow(unsafe_code)]
        pub(in crate::limits) unsafe fn with(self, block: *mut u8, size: usize) -> Self {
            let block: *mut Block = block.cast();
            // SAFETY: the block is at the start of a page, bigger than that, and nobody else's any more.
            unsafe { block.write(Block { next: self, size }) };
            Left(block)
        }

        /// Without up to `bytes` of them, a whole number of pages.
        #[allow(unsafe_code)]
        pub(in crate::limits) fn without(self, bytes: usize) -> Self {
            if self.0.is_null() {
                return self;
            }
            // SAFETY: `with` has written it, and only this list has it.
            let Block { next, size } = unsafe { self.0.read() };
            if size <= bytes {
                // SAFETY: as above.
                unsafe { unmap(self.0.cast(), size) };
                return next;
            }
            // From its end, so that its beginning stays what it is; the end is that of its last page.
            let end = size.next_multiple_of(PAGE);
            let size = end - bytes;
            // SAFETY: as above; these pages are the last ones of the block, which then ends before them.
            unsafe {
                unmap(self.0.cast::<u8>().add(size), bytes);
                self.0.write(Block { next, size });
            }
            self
        }

        pub(in crate::limits) fn is_empty(self) -> bool {
            self.0.is_null()
        }
    }

    fn checked(block: *mut libc::c_void) -> *mut u8 {
        match block {
            libc::MAP_FAILED => std::ptr::null_mut(),
            block => block.cast(),
        }
    }
}

#[cfg(not(target_os = "linux"))]
#[allow(unsafe_code, clippy::missing_safety_doc)]
mod imp {
    pub(in crate::limits) fn map(_: usize) -> *mut u8 {
        std::ptr::null_mut()
    }

    pub(in crate::limits) unsafe fn remap(_: *mut u8, _: usize, _: usize) -> *mut u8 {
        std::ptr::null_mut()
    }

    pub(in crate::limits) unsafe fn unmap(_: *mut u8, _: usize) {}

    #[derive(Clone, Copy)]
    pub(in crate::limits) struct Left;

    impl Left {
        pub(in crate::limits) const NONE: Self = Left;

        pub(in crate::limits) unsafe fn with(self, _: *mut u8, _: usize) -> Self {
            self
        }

        pub(in crate::limits) fn without(self, _: usize) -> Self {
            self
        }

        pub(in crate::limits) fn is_empty(self) -> bool {
            true
        }
    }
}
