//! The system's memory: how the allocator of the C library behaves, and pages that are got from the system directly.
//!
//! Owns the unsafe calls. Which blocks get pages of their own, what they cost and when freed memory goes back is the business of
//! whoever allocates (`elite-lang`). Systems without these calls keep the allocator as it is and get no pages.

/// What blocks are asked of: the allocator of the C library, or a quicker one where that is slow.
#[cfg(not(target_env = "musl"))]
pub use std::alloc::System;

/// What blocks are asked of: the allocator of musl takes nearly twice as long for programs that make and drop many objects.
#[cfg(target_env = "musl")]
#[allow(non_upper_case_globals, reason = "in place of the unit struct of std")]
pub const System: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Bytes of a page.
pub const PAGE: usize = 4096;

pub use imp::{Left, map, remap, unmap};

/// Tells the allocator once and for all to join freed blocks with their neighbours at once, to give nothing back to the system
/// before it is told to (`trim`), and to take blocks from `mapped` bytes on from the system directly. By itself it keeps small ones
/// aside and joins all of them when some big one is freed, and gives back whatever is free at the end of its heap then:
/// milliseconds, at a moment nobody can choose.
pub fn settle(mapped: usize) {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        static ONCE: std::sync::Once = std::sync::Once::new();
        let mapped = libc::c_int::try_from(mapped).unwrap_or(libc::c_int::MAX);
        ONCE.call_once(|| {
            // SAFETY: the calls take numbers only and may be made at any time, from any thread.
            #[allow(unsafe_code)]
            unsafe {
                libc::mallopt(libc::M_MMAP_THRESHOLD, mapped);
                libc::mallopt(libc::M_MXFAST, 0);
                libc::mallopt(libc::M_TRIM_THRESHOLD, libc::c_int::MAX);
            }
        });
    }
    #[cfg(not(all(target_os = "linux", target_env = "gnu")))]
    let _ = mapped;
}

/// Has the allocator sort what has been freed since the last call. It leaves that to the next request that is not quite small
/// otherwise, which then takes milliseconds for tens of thousands of blocks.
pub fn sort_freed() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        // More than what is kept aside for each thread, less than what makes it look further.
        const SIZE: usize = 4 << 10;
        // SAFETY: a block of the system is given back as it was made; the call takes null, too.
        #[allow(unsafe_code)]
        unsafe {
            let block = libc::malloc(SIZE);
            libc::free(std::hint::black_box(block));
        }
    }
}

/// Gives memory that was freed back to the system. Takes some milliseconds for every hundred megabytes. `mapped` as `settle` had it.
pub fn trim(mapped: usize) {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        // So much that the allocator looks, when it is freed, at what is free at the end of the heap of this thread.
        const LOOKED_AT: usize = 128 << 10;
        let mapped = libc::c_int::try_from(mapped).unwrap_or(libc::c_int::MAX);
        // SAFETY: a block of the system is given back as it was made; the other calls take numbers only and may be made at
        // any time, from any thread.
        #[allow(unsafe_code)]
        unsafe {
            libc::mallopt(libc::M_TRIM_THRESHOLD, mapped);
            let block = libc::malloc(LOOKED_AT);
            libc::free(std::hint::black_box(block));
            libc::malloc_trim(0);
            libc::mallopt(libc::M_TRIM_THRESHOLD, libc::c_int::MAX);
        }
    }
    #[cfg(not(all(target_os = "linux", target_env = "gnu")))]
    let _ = mapped;
}

#[cfg(target_os = "linux")]
mod imp {
    use super::PAGE;

    /// Fresh pages, all zero; null if there are none to be had.
    pub fn map(size: usize) -> *mut u8 {
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
    pub unsafe fn remap(block: *mut u8, size: usize, wanted: usize) -> *mut u8 {
        // SAFETY: the caller's promise.
        checked(unsafe { libc::mremap(block.cast(), size, wanted, libc::MREMAP_MAYMOVE) })
    }

    /// Gives a block back.
    ///
    /// # Safety
    /// `block` is of this module with `size` bytes, and nobody uses it any more.
    #[allow(unsafe_code)]
    pub unsafe fn unmap(block: *mut u8, size: usize) {
        // SAFETY: the caller's promise.
        unsafe { libc::munmap(block.cast(), size) };
    }

    /// Blocks that are given back bit by bit. Each has the next one, and its own size, written into its first bytes.
    #[derive(Clone, Copy)]
    pub struct Left(*mut Block);

    struct Block {
        next: Left,
        size: usize,
    }

    impl Left {
        /// None at all.
        pub const NONE: Self = Left(std::ptr::null_mut());

        /// With one more.
        ///
        /// # Safety
        /// As `unmap`.
        #[allow(unsafe_code)]
        pub unsafe fn with(self, block: *mut u8, size: usize) -> Self {
            let block: *mut Block = block.cast();
            // SAFETY: the block is at the start of a page, bigger than that, and nobody else's any more.
            unsafe { block.write(Block { next: self, size }) };
            Left(block)
        }

        /// Without up to `bytes` of them, a whole number of pages.
        #[allow(unsafe_code)]
        pub fn without(self, bytes: usize) -> Self {
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

        /// Whether there are none left.
        pub fn is_empty(self) -> bool {
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
#[allow(
    unsafe_code,
    missing_docs,
    clippy::missing_safety_doc,
    reason = "as above, and there are none"
)]
mod imp {
    pub fn map(_: usize) -> *mut u8 {
        std::ptr::null_mut()
    }

    pub unsafe fn remap(_: *mut u8, _: usize, _: usize) -> *mut u8 {
        std::ptr::null_mut()
    }

    pub unsafe fn unmap(_: *mut u8, _: usize) {}

    #[derive(Clone, Copy)]
    pub struct Left;

    impl Left {
        pub const NONE: Self = Left;

        pub unsafe fn with(self, _: *mut u8, _: usize) -> Self {
            self
        }

        pub fn without(self, _: usize) -> Self {
            self
        }

        pub fn is_empty(self) -> bool {
            true
        }
    }
}
