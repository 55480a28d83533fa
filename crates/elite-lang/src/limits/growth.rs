//! Growth: whatever a script lets grow asks the memory account first, here.
//!
//! Asking may free circles, so no borrow of a container may be held. Big buffers grow by an eighth instead of doubling,
//! so that a list may fill most of what the task is allowed, and what the system refuses is an exception as well.

use std::collections::VecDeque;
use std::rc::Rc;

use crate::eval::{Evaluator, InterpreterState};
use crate::limits::chunked::{BULK_CHUNK, bulk_work};
use crate::limits::deferred_drop;
use crate::limits::yielding::YIELD_BUDGET;
use crate::value::bytes::BytesRef;
use crate::value::{ByteArray, List, R, ScriptCell, Unwind};

/// What a short text costs with its place in a list, and while the list grows.
const TEXT_ITEM_BYTES: usize = 112;
/// Buffers below this size in bytes double, as `Vec` does by itself.
const DOUBLING_MAX: usize = 1 << 20;

/// A buffer that can be asked to grow.
pub trait GrowableBuffer {
    /// Size of one entry.
    const ENTRY_SIZE: usize;
    /// Entries in it, and room for entries.
    fn len_and_capacity(&self) -> (usize, usize);
    /// Takes room for `more` entries beyond its length; whether there was any to be had.
    fn grow_by(&mut self, more: usize) -> bool;
}

impl<T> GrowableBuffer for Vec<T> {
    const ENTRY_SIZE: usize = size_of::<T>();

    fn len_and_capacity(&self) -> (usize, usize) {
        (self.len(), self.capacity())
    }

    fn grow_by(&mut self, more: usize) -> bool {
        self.try_reserve_exact(more).is_ok()
    }
}

impl<T> GrowableBuffer for VecDeque<T> {
    const ENTRY_SIZE: usize = size_of::<T>();

    fn len_and_capacity(&self) -> (usize, usize) {
        (self.len(), self.capacity())
    }

    fn grow_by(&mut self, more: usize) -> bool {
        self.try_reserve_exact(more).is_ok()
    }
}

impl GrowableBuffer for String {
    const ENTRY_SIZE: usize = 1;

    fn len_and_capacity(&self) -> (usize, usize) {
        (self.len(), self.capacity())
    }

    fn grow_by(&mut self, more: usize) -> bool {
        self.try_reserve_exact(more).is_ok()
    }
}

/// Entries by which a buffer has to grow for `more` of them; None if they fit as it is.
#[inline]
fn growth<B: GrowableBuffer>(buffer: &B, more: usize) -> Option<usize> {
    let (length, room) = buffer.len_and_capacity();
    let needed = length.saturating_add(more);
    if needed <= room {
        return None;
    }
    let spare = match length.saturating_mul(B::ENTRY_SIZE) {
        0..DOUBLING_MAX => length,
        _ => length / 8,
    };
    Some(more.max(spare).max(4))
}

impl Evaluator<'_> {
    /// Makes room for `more` entries in a buffer of the caller's own.
    #[inline]
    pub fn grow<B: GrowableBuffer>(&self, buffer: &mut B, more: usize) -> R<()> {
        match growth(buffer, more) {
            None => Ok(()),
            Some(by) => self.grow_by(buffer, more, by),
        }
    }

    #[cold]
    #[inline(never)]
    fn grow_by<B: GrowableBuffer>(&self, buffer: &mut B, more: usize, by: usize) -> R<()> {
        let by = self.capped_growth::<B>(more, by)?;
        match buffer.grow_by(by) {
            true => Ok(()),
            false => Err(self.refused_by_system()),
        }
    }

    /// `by` if the account has that much, otherwise `more`; an exception if that is too much, too.
    fn capped_growth<B: GrowableBuffer>(&self, more: usize, by: usize) -> R<usize> {
        if self.core.fits_memory(by.saturating_mul(B::ENTRY_SIZE)) {
            return Ok(by);
        }
        self.check_allocation(more.saturating_mul(B::ENTRY_SIZE))?;
        Ok(more)
    }

    /// Makes room for `more` entries in a buffer that scripts can reach: asked for first, then taken.
    pub fn grow_held<B: GrowableBuffer>(&self, held: &ScriptCell<B>, more: usize) -> R<()> {
        let by = growth(&*held.borrow(), more);
        let Some(by) = by else { return Ok(()) };
        let by = self.capped_growth::<B>(more, by)?;
        match held.with_mut(|buffer| buffer.grow_by(by)) {
            true => Ok(()),
            false => Err(self.refused_by_system()),
        }
    }

    /// Makes room for `more` items in a list.
    #[inline]
    pub fn grow_list(&self, list: &List, more: usize) -> R<()> {
        let by = growth(&*list.borrow(), more);
        match by {
            None => Ok(()),
            Some(by) => self.grow_list_by(list, more, by),
        }
    }

    #[cold]
    #[inline(never)]
    fn grow_list_by(&self, list: &List, more: usize, by: usize) -> R<()> {
        let by = self.capped_growth::<Vec<crate::value::Value>>(more, by)?;
        let done = list.change(|items| items.grow_by(by));
        match done {
            true => Ok(()),
            false => Err(self.refused_by_system()),
        }
    }

    /// Makes room for `more` bytes in a bytearray.
    #[inline]
    pub fn grow_bytes(&self, bytes: &ByteArray, more: usize) -> R<()> {
        if bytes.is_shared() {
            self.unshare(bytes)?;
        }
        let by = growth(&*bytes.borrow_whole(), more);
        let Some(by) = by else { return Ok(()) };
        let by = self.capped_growth::<Vec<u8>>(more, by)?;
        match bytes.append(|data| data.grow_by(by)) {
            true => Ok(()),
            false => Err(self.refused_by_system()),
        }
    }

    /// Copies bytes that a native goes through, before they are changed.
    #[cold]
    fn unshare(&self, bytes: &ByteArray) -> R<()> {
        let before = bytes.snapshot();
        let copy = self.copy_bytes(&before)?;
        bytes.replace_if_unchanged(&before, copy);
        Ok(())
    }

    /// Appends to a bytearray.
    pub fn extend_bytes(&self, bytes: &ByteArray, more: BytesRef) -> R<()> {
        if more.len() <= BULK_CHUNK && !bytes.is_shared() {
            self.grow_bytes(bytes, more.len())?;
            bytes.append(|data| data.extend_from_slice(&more));
            return self.charge(bulk_work(more.len()));
        }
        // A bytearray may be appended to itself, so both halves are copied from one snapshot.
        let before = bytes.snapshot();
        let mut data = Vec::new();
        let spare = {
            let whole = bytes.borrow_whole();
            whole.capacity() - whole.len()
        };
        if spare < more.len()
            || matches!(&more, BytesRef::Snapshot(own) if Rc::ptr_eq(own, &before))
        {
            self.grow(&mut data, before.len() + more.len())?;
            self.push_bytes(&mut data, &before)?;
            self.push_bytes(&mut data, &more)?;
            bytes.put(data);
            return Ok(());
        }
        drop(before);
        for piece in more.chunks(BULK_CHUNK) {
            self.grow_bytes(bytes, piece.len())?;
            bytes.append(|data| data.extend_from_slice(piece));
            self.charge(bulk_work(piece.len()))?;
        }
        Ok(())
    }

    /// Asks for `pieces` values of their own that a text or the like of `bytes` bytes is taken apart into. `pieces`
    /// counts them; it is only asked if there is no room for as many as there could be at most.
    pub fn check_split_allocation(&self, bytes: usize, pieces: impl FnOnce() -> usize) -> R<()> {
        let cost = |pieces: usize| pieces.saturating_mul(TEXT_ITEM_BYTES).saturating_add(bytes);
        if self.core.fits_memory(cost(bytes.saturating_add(1))) {
            return Ok(());
        }
        self.check_allocation(cost(pieces()))
    }

    /// A buffer with room for `entries`.
    pub fn try_with_capacity<T>(&self, entries: usize) -> R<Vec<T>> {
        self.check_allocation(entries.saturating_mul(size_of::<T>()))?;
        let mut buffer = Vec::new();
        match buffer.try_reserve_exact(entries) {
            Ok(()) => Ok(buffer),
            Err(_) => Err(self.refused_by_system()),
        }
    }

    /// Raises `MemoryError` if the task holds more than it may.
    pub fn check_memory(&self) -> R<()> {
        self.check_allocation(0)
    }

    /// Raises `MemoryError` if `bytes` more would be too much.
    #[inline]
    pub fn check_allocation(&self, bytes: usize) -> R<()> {
        if self.core.fits_memory(bytes) {
            return Ok(());
        }
        self.reclaim_for(bytes)
    }

    /// Raises `MemoryError` if `bytes` more would be too much. Values that wait to be dropped go first, bit by bit, so
    /// that other threads may have their turn.
    pub fn check_after_deferred_drops(&self, bytes: usize) -> R<()> {
        while !self.core.fits_memory(bytes) && deferred_drop::run_deferred_drops() {
            self.charge(YIELD_BUDGET)?;
        }
        self.check_allocation(bytes)
    }

    /// Frees the circles that nothing refers to any more; `MemoryError` if `bytes` more are still too much then.
    #[cold]
    #[inline(never)]
    fn reclaim_for(&self, bytes: usize) -> R<()> {
        self.core.note_memory_refusal();
        while !self.core.fits_memory(bytes) && deferred_drop::run_deferred_drops() {}
        if self.core.fits_memory(bytes) {
            return Ok(());
        }
        if bytes <= self.core.limits.memory_bytes {
            // The caller may be a native in the midst of its work.
            let outer = self.core.pending_finalizers.set_suspended(true);
            self.core.gc_until_fits(bytes);
            self.core.pending_finalizers.set_suspended(outer);
            self.core.stacks.clear();
        }
        self.core.arm_memory_alarm();
        match self.core.fits_memory(bytes) {
            true => Ok(()),
            false => {
                self.core.grant_memory_reserve();
                Err(self.memory_limit_error())
            }
        }
    }

    #[cold]
    fn memory_limit_error(&self) -> Unwind {
        let limit = self.core.limits.memory_bytes >> 20;
        self.memory_error(format!(
            "the task would hold more than its {limit} MiB of memory"
        ))
    }

    #[cold]
    fn refused_by_system(&self) -> Unwind {
        self.memory_error("the system has no memory left for this")
    }
}

impl InterpreterState {
    /// Whether `more` bytes fit the limit.
    #[inline]
    pub fn fits_memory(&self, more: usize) -> bool {
        let fits = |used: usize| used.saturating_add(more) <= self.memory_limit();
        // The first is a little more, and found out at once.
        fits(self.memory_with_free_lists()) || fits(self.memory_used())
    }
}
