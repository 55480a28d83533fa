//! Results as two words, which the processor hands over in registers.
//!
//! A result of an expression or a statement is two words, but the compiler returns an enum of that size through memory:
//! it is written by who makes it and read again by who asked. Nodes are called through here instead, so that between
//! two nodes a result stays in registers.

use std::marker::PhantomData;
use std::mem::{ManuallyDrop, MaybeUninit, transmute_copy};

use super::Flow;
use crate::value::{R, Unwind, Value};

/// What is handed over as two words: a type of that size.
///
/// # Safety
/// The type has the size and the alignment of two words.
#[allow(unsafe_code)]
pub unsafe trait RegisterPair: Sized {}

const _: () = assert!(size_of::<R>() == size_of::<PairOf<R>>());
const _: () = assert!(align_of::<R>() == align_of::<PairOf<R>>());
const _: () = assert!(size_of::<Value>() == size_of::<PairOf<Value>>());
const _: () = assert!(align_of::<Value>() == align_of::<PairOf<Value>>());
const _: () = assert!(size_of::<Option<Value>>() == size_of::<PairOf<Value>>());
const _: () = assert!(align_of::<Option<Value>>() == align_of::<PairOf<Value>>());
const _: () = assert!(size_of::<Flow>() == size_of::<PairOf<Flow>>());
const _: () = assert!(align_of::<Flow>() == align_of::<PairOf<Flow>>());

// SAFETY: asserted above.
#[allow(unsafe_code)]
unsafe impl RegisterPair for Value {}

// SAFETY: asserted above.
#[allow(unsafe_code)]
unsafe impl RegisterPair for Option<Value> {}

// SAFETY: asserted above.
#[allow(unsafe_code)]
unsafe impl RegisterPair for R {}

// SAFETY: asserted above.
#[allow(unsafe_code)]
unsafe impl RegisterPair for Flow {}

/// A `T` on its way from one node to another.
#[must_use = "what is in it is never dropped otherwise"]
#[repr(C)]
pub struct PairOf<T> {
    first: MaybeUninit<u64>,
    /// A pointer, so that the compiler knows that an object may be behind it.
    second: MaybeUninit<*const ()>,
    of: PhantomData<T>,
}

impl<T: RegisterPair> PairOf<T> {
    /// Packs it.
    #[inline(always)]
    pub fn pack(whole: T) -> Self {
        let whole = ManuallyDrop::new(whole);
        // SAFETY: the sizes are the same, and words that may be uninitialised take any bytes; the original is not
        // dropped.
        #[allow(unsafe_code)]
        unsafe {
            transmute_copy(&whole)
        }
    }

    /// Unpacks it.
    #[inline(always)]
    pub fn whole(self) -> T {
        // SAFETY: the words are those of a `T`, from `pack`, and there is nobody else who has them.
        #[allow(unsafe_code)]
        unsafe {
            transmute_copy(&self)
        }
    }
}

/// The end of a statement whose last step drops `old`. Nothing is left to be done after the drop of an object, so that
/// the statement needs no stack for it.
#[inline(always)]
pub fn next_dropping(old: Value) -> Flow {
    match old.into_last() {
        None => Flow::Next,
        Some(last) => next_after(PairOf::pack(last)).whole(),
    }
}

#[inline(never)]
fn next_after(last: PairOf<Value>) -> PairOf<Flow> {
    drop(last.whole());
    PairOf::pack(Flow::Next)
}

/// A truth, or why there is none: two words in registers as it is.
pub enum Truth {
    /// The condition does not hold.
    No,
    /// The condition holds.
    Yes,
    /// Finding out failed.
    Unwind(Unwind),
}

impl From<R<bool>> for Truth {
    #[inline(always)]
    fn from(result: R<bool>) -> Self {
        match result {
            Ok(false) => Truth::No,
            Ok(true) => Truth::Yes,
            Err(raised) => Truth::Unwind(raised),
        }
    }
}

impl From<Truth> for R<bool> {
    #[inline(always)]
    fn from(truth: Truth) -> Self {
        match truth {
            Truth::No => Ok(false),
            Truth::Yes => Ok(true),
            Truth::Unwind(raised) => Err(raised),
        }
    }
}
