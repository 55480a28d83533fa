//! Counting references to values without asking what kind of value it is.
//!
//! Each kind is behind an `Rc` of its own type, but all of them count at the same place. Copies of values and the end
//! of copies are the commonest thing a program does, so they go by that place instead of by a table of kinds.

use std::mem::ManuallyDrop;
use std::rc::Rc;

use super::Value;
use crate::eval::words::PairOf;

/// Any object, seen by somebody who only counts.
pub(crate) type RefCounts = Rc<u64>;

impl Value {
    /// The `Rc` of a value that has one, for counting only.
    #[inline(always)]
    pub(crate) fn ref_counts(&self) -> Option<&RefCounts> {
        if self.is_immediate() {
            return None;
        }
        // SAFETY: a value that is not flat is its tag and an `Rc` in the second word (`Value` has the layout of C, see
        // the reference on enums with `repr`). An `Rc` is a pointer to two counters before the object, for all sized
        // types alike, as its own layout of C has it and as a trial holds against every kind (`trials/counts.rs`).
        // Nobody looks at the object through this reference, and it lives no longer than the value.
        #[allow(unsafe_code)]
        Some(unsafe { &*std::ptr::from_ref(self).cast::<RefCounts>().add(1) })
    }

    /// The kind of the value, as the number of its variant.
    #[inline(always)]
    pub fn kind(&self) -> u64 {
        // SAFETY: an enum with `repr(u64)` begins with its tag, which is always there.
        #[allow(unsafe_code)]
        unsafe {
            *std::ptr::from_ref(self).cast::<u64>()
        }
    }

    /// One more reference to the object, if there is one; the same value for it.
    #[inline(always)]
    pub(super) fn clone_counted(&self) -> Value {
        if let Some(counted) = self.ref_counts() {
            std::mem::forget(counted.clone());
        }
        // SAFETY: flat values are plain words, and for the others the reference has just been counted.
        #[allow(unsafe_code)]
        unsafe {
            std::ptr::read(self)
        }
    }

    /// Drops it: numbers and references that are not the last without a call.
    #[inline(always)]
    pub fn drop_inline(self) {
        if let Some(last) = self.into_last() {
            drop_last(PairOf::pack(last));
        }
    }

    /// Drops it, unless its object goes with it: then it is given back.
    #[inline(always)]
    #[must_use = "the object is dropped only now"]
    pub fn into_last(self) -> Option<Value> {
        let value = ManuallyDrop::new(self);
        if let Some(counted) = value.ref_counts() {
            if Rc::strong_count(counted) == 1 {
                return Some(ManuallyDrop::into_inner(value));
            }
            // SAFETY: the value that owns this reference is not dropped; the object stays, since there are others.
            #[allow(unsafe_code)]
            drop(unsafe { std::ptr::read(counted) });
        }
        None
    }
}

/// Drops a value together with its object.
#[inline(never)]
fn drop_last(value: PairOf<Value>) {
    drop(value.whole());
}
