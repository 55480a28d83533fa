//! The system's memory: the allocator, how it behaves, and pages that are got from the system directly.
//!
//! Owns the unsafe calls. Which blocks get pages of their own, what they cost and what is counted for whom is the
//! business of whoever allocates (`elite-lang`). Systems without these calls keep the allocator of the C library and
//! get no pages.

/// What blocks are asked of: the allocator of the C library.
#[cfg(not(target_os = "linux"))]
pub use std::alloc::System;

/// What blocks are asked of. Blocks of one size share pages, so that freeing is cheap and never has to be made up for:
/// the allocator of glibc joins what has been freed, and looks through all of it to give memory back, milliseconds at a
/// moment nobody can choose. That of musl takes nearly twice as long for programs that make and drop many objects.
#[cfg(target_os = "linux")]
#[allow(non_upper_case_globals, reason = "in place of the unit struct of std")]
pub const System: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Bytes of a page.
pub const PAGE: usize = 4096;

pub use imp::{DeferredUnmap, map, remap, unmap};

/// What the allocator rounds a request up to, for accounts: it has blocks of every multiple of 16 bytes up to 128, and
/// four sizes from one power of two to the next. With another allocator than mimalloc this is an estimate.
#[inline(always)]
pub const fn rounded_size(size: usize) -> usize {
    let step = match size {
        0..=128 => 16,
        _ => 1 << ((size - 1).ilog2() - 2),
    };
    (size + step - 1) & !(step - 1)
}

/// How the allocator behaves. Set before the first block is asked for, which is before `main`.
#[cfg(target_os = "linux")]
mod allocator_options {
    use std::ffi::c_long;

    use libmimalloc_sys::{mi_option_set, mi_option_t};

    // The numbers of the options are those of the header mimalloc.h (version 3), which the crate leaves out.
    /// Whether an arena, a reserve of addresses, is writable at once: who locks the process's memory would then fill
    /// it.
    const ARENA_EAGER_COMMIT: mi_option_t = 4;
    /// How long freed pages are kept, in milliseconds. What has come together until then goes back to the system in one
    /// piece, tens of milliseconds for some hundred megabytes; a page at a time takes no longer in all.
    const PURGE_DELAY: mi_option_t = 15;
    /// Addresses that are taken at first, in KiB. More follow, but who limits the address space (`ulimit -v`) means
    /// what is in use.
    const ARENA_RESERVE: mi_option_t = 23;

    pub(super) const SET: [(mi_option_t, c_long); 3] = [
        (ARENA_EAGER_COMMIT, 0),
        (PURGE_DELAY, 0),
        (ARENA_RESERVE, 64 << 10),
    ];

    extern "C" fn set() {
        for (option, value) in SET {
            // SAFETY: the call writes a number into a table that needs no preparation; no other thread is there yet.
            #[allow(unsafe_code)]
            unsafe {
                mi_option_set(option, value);
            }
        }
    }

    #[allow(unsafe_code)]
    #[used]
    // SAFETY: the section holds functions like this one, which are called when the program or library has been loaded.
    #[unsafe(link_section = ".init_array")]
    static EARLY: extern "C" fn() = set;
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
    pub struct DeferredUnmap(*mut Block);

    struct Block {
        next: DeferredUnmap,
        size: usize,
    }

    impl DeferredUnmap {
        /// None at all.
        pub const NONE: Self = DeferredUnmap(std::ptr::null_mut());

        /// With one more.
        ///
        /// # Safety
        /// As `unmap`.
        #[allow(unsafe_code)]
        pub unsafe fn with(self, block: *mut u8, size: usize) -> Self {
            let block: *mut Block = block.cast();
            // SAFETY: the block is at the start of a page, bigger than that, and nobody else's any more.
            unsafe { block.write(Block { next: self, size }) };
            DeferredUnmap(block)
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
    pub struct DeferredUnmap;

    impl DeferredUnmap {
        pub const NONE: Self = DeferredUnmap;

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

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn the_allocator_behaves_as_it_has_been_told_to() {
        for (option, value) in allocator_options::SET {
            // SAFETY: the call reads a number from a table.
            #[allow(unsafe_code)]
            let found = unsafe { libmimalloc_sys::mi_option_get(option) };
            assert_eq!(found, value, "option {option}");
        }
    }

    #[test]
    fn requests_are_rounded_to_what_the_allocator_has() {
        let far = (1..200).map(|number| number * 997);
        // A block of one word has its own size, which is not worth a case in the rule.
        for size in (9..3000).chain(far) {
            // SAFETY: the call is arithmetic.
            #[allow(unsafe_code)]
            let found = unsafe { libmimalloc_sys::mi_good_size(size) };
            assert_eq!(rounded_size(size), found, "{size} bytes");
        }
    }
}
