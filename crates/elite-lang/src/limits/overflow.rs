//! What happens when a native stack of a script overflows all the same: that is a fault of ours, and ends the task, not
//! the process.
//!
//! The thread goes on on a stack of its own (`platform::overflow`) and suspends the script thread for ever: what lies
//! on its stacks stays where it is, half done and never looked at again. Whoever resumed it panics; the interpreter and
//! all it holds are left behind, for what it holds may be half changed. The system's allocator is whole: the stack it
//! needs is touched before it is asked (`memory`).

use std::cell::{Cell, RefCell};
use std::ptr::null;

use corosensei::Yielder;
use corosensei::stack::{DefaultStack, Stack};
use platform::overflow::{Refuge, change_refuge};

use crate::eval::coroutine::{Resume, SuspendRequest};

/// Where a script thread can be suspended from any place in it; null before it has begun.
pub(crate) type Exit = Cell<*const Yielder<Resume, SuspendRequest>>;

/// Enough to suspend a coroutine.
const REFUGE_STACK: usize = 32 << 10;

thread_local! {
    /// The exit of the script thread that runs.
    static EXIT: Cell<*const Exit> = const { Cell::new(null()) };
    static REFUGE: RefCell<Option<DefaultStack>> = const { RefCell::new(None) };
    /// A script thread has left by its exit.
    static IS_LEFT: Cell<bool> = const { Cell::new(false) };
}

/// While this is there, a script thread runs that can be left by its exit.
pub(crate) struct Watch<'e> {
    outer: *const Exit,
    outer_refuge: Option<Refuge>,
    _exit: &'e Exit,
}

impl<'e> Watch<'e> {
    /// Begins to watch.
    pub(crate) fn begin(exit: &'e Exit) -> Self {
        let refuge = REFUGE.with_borrow_mut(|refuge| {
            if refuge.is_none() && !IS_LEFT.get() {
                *refuge = DefaultStack::new(REFUGE_STACK).ok();
            }
            refuge.as_ref().map(|stack| Refuge {
                stack: stack.base().get(),
                run: leave,
            })
        });
        Watch {
            outer: EXIT.replace(exit),
            outer_refuge: change_refuge(refuge),
            _exit: exit,
        }
    }

    /// The script thread has left by its exit. The frame that stands on the refuge is part of it, so the refuge stays
    /// for ever.
    pub(crate) fn give_up(mut self) {
        self.outer_refuge = None;
        IS_LEFT.set(true);
        std::mem::forget(REFUGE.take());
    }
}

impl Drop for Watch<'_> {
    fn drop(&mut self) {
        EXIT.set(self.outer);
        change_refuge(self.outer_refuge);
    }
}

/// Leaves the script thread that runs. Runs on the refuge, when a stack of that thread has overflowed.
extern "C" fn leave() -> ! {
    // SAFETY: a refuge is set only while a `Watch` is there, which borrows the exit; the yielder in it lies at the root
    // of the coroutine that runs, from before the first line of script code on.
    #[allow(unsafe_code)]
    unsafe {
        if let Some(yielder) = EXIT.get().as_ref().and_then(|exit| exit.get().as_ref()) {
            yielder.suspend(SuspendRequest::Overflow);
        }
    }
    // Nobody resumes the coroutine after that.
    std::process::abort()
}
