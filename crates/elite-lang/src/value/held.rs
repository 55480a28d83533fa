//! The cell for everything scripts can reach and change.
//!
//! What it keeps can be looked at and changed only while no script code runs, and dropping a value may run script code
//! (the `finally` blocks of a generator). So no borrow can be taken to change it: `with_mut` runs a function that gives
//! back what has left, and the caller drops that afterwards. Builds with debug assertions count the open looks and
//! changes of the OS thread, and `assert_no_borrows` stops the test in which script code begins, or a container is
//! dropped, meanwhile.

use std::cell::{Ref, RefCell};
use std::ops::Deref;

use super::Value;

/// A cell that is never in use while script code runs.
#[derive(Default)]
pub struct ScriptCell<T>(RefCell<T>);

/// A look at what a `ScriptCell` keeps.
pub struct ScriptRef<'h, T: ?Sized> {
    value: Ref<'h, T>,
    _open: BorrowToken,
}

impl<T> ScriptCell<T> {
    /// A cell that keeps `value`.
    pub const fn new(value: T) -> Self {
        ScriptCell(RefCell::new(value))
    }

    /// A look at what it keeps; no script code may run before it is over.
    #[inline(always)]
    pub fn borrow(&self) -> ScriptRef<'_, T> {
        ScriptRef {
            value: self.0.borrow(),
            _open: BorrowToken::begin(),
        }
    }

    /// What it keeps, without keeping count of the look; None if it is being changed.
    ///
    /// # Safety
    /// Until the reference is used for the last time nobody changes what the cell keeps: no script code runs, no value
    /// is dropped, and `with_mut`, `replace`, `put` and `take` are not called.
    #[inline(always)]
    #[allow(unsafe_code)]
    pub(crate) unsafe fn get_unguarded(&self) -> Option<&T> {
        // SAFETY: the caller's promise.
        unsafe { self.0.try_borrow_unguarded() }.ok()
    }

    /// A look at what the cell keeps; None while that is being changed. No script code may run before it is over.
    #[inline]
    pub fn try_borrow(&self) -> Option<ScriptRef<'_, T>> {
        Some(ScriptRef {
            value: self.0.try_borrow().ok()?,
            _open: BorrowToken::begin(),
        })
    }

    /// Changes what the cell keeps. `change` runs no script code, drops no values and gives back those that leave.
    #[inline(always)]
    pub fn with_mut<O>(&self, change: impl FnOnce(&mut T) -> O) -> O {
        let mut value = self.0.borrow_mut();
        let _open = BorrowToken::begin();
        change(&mut value)
    }

    /// Changes what the cell keeps with a value that `change` takes; the value comes back if `change` gives it back,
    /// and while the content is being looked at or changed. Nothing here can panic, so that the value stays where it
    /// is: in registers, if `change` leaves it there.
    #[inline(always)]
    pub fn try_with_mut<V, O>(
        &self,
        value: V,
        change: impl FnOnce(&mut T, V) -> Result<O, V>,
    ) -> Result<O, V> {
        match self.0.try_borrow_mut() {
            Ok(mut kept) => {
                let _open = BorrowToken::begin();
                change(&mut kept, value)
            }
            Err(_) => Err(value),
        }
    }

    /// Puts a value in the place of the one before, which is given back.
    #[inline(always)]
    #[must_use = "what was kept is dropped only now"]
    pub fn replace(&self, value: T) -> T {
        self.0.replace(value)
    }

    /// Puts a value in the place of the one before, which is dropped when it has left.
    #[inline(always)]
    pub fn put(&self, value: T) {
        drop(self.0.replace(value));
    }

    /// What the cell keeps, for its only owner.
    #[inline(always)]
    pub fn get_mut(&mut self) -> &mut T {
        self.0.get_mut()
    }
}

impl<T: Clone> ScriptCell<T> {
    /// A copy of what it keeps.
    #[inline(always)]
    pub fn get(&self) -> T {
        self.0.borrow().clone()
    }
}

impl ScriptCell<Value> {
    /// A copy of the value, without keeping count of the look; `Unbound` if it is being changed.
    #[inline(always)]
    pub fn get_or_unbound(&self) -> Value {
        // SAFETY: copying a value counts one reference more and does nothing else.
        #[allow(unsafe_code)]
        unsafe { self.get_unguarded() }.cloned().unwrap_or_default()
    }
}

impl<T: Default> ScriptCell<T> {
    /// Takes out what it keeps.
    #[inline(always)]
    #[must_use = "what was kept is dropped only now"]
    pub fn take(&self) -> T {
        self.0.take()
    }
}

impl<T: ?Sized> Deref for ScriptRef<'_, T> {
    type Target = T;

    #[inline(always)]
    fn deref(&self) -> &T {
        &self.value
    }
}

impl<'h, T: ?Sized> ScriptRef<'h, T> {
    /// A look at a part.
    pub fn map<U: ?Sized>(look: Self, part: impl FnOnce(&T) -> &U) -> ScriptRef<'h, U> {
        ScriptRef {
            value: Ref::map(look.value, part),
            _open: look._open,
        }
    }
}

/// An open look or change.
struct BorrowToken;

#[cfg(debug_assertions)]
mod count {
    use std::cell::Cell;

    thread_local! {
        static OPEN: Cell<u32> = const { Cell::new(0) };
    }

    impl super::BorrowToken {
        pub(super) fn begin() -> Self {
            let _ = OPEN.try_with(|open| open.set(open.get() + 1));
            super::BorrowToken
        }
    }

    impl Drop for super::BorrowToken {
        fn drop(&mut self) {
            let _ = OPEN.try_with(|open| open.set(open.get() - 1));
        }
    }

    pub(super) fn open() -> u32 {
        OPEN.try_with(Cell::get).unwrap_or(0)
    }
}

#[cfg(not(debug_assertions))]
impl BorrowToken {
    #[inline(always)]
    fn begin() -> Self {
        BorrowToken
    }
}

/// Script code may run from here on: in builds with debug assertions a panic if anything is open.
#[inline(always)]
pub fn assert_no_borrows() {
    #[cfg(debug_assertions)]
    assert!(
        count::open() == 0 || std::thread::panicking(),
        "script code may run while a value is being looked at or changed"
    );
}
