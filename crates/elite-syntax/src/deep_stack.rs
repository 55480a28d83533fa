//! Native stack for work on trees that may be deep: parsing, resolving, lowering, and dropping them. The caller's own
//! stack may be small.

use std::cell::Cell;

use corosensei::on_stack;
use corosensei::stack::DefaultStack;

/// Reserved, not taken: the system provides the pages that are touched.
const DEEP_STACK: usize = 64 << 20;

/// A stack that is deep enough for any tree within the limits of the parser.
pub fn deep_stack() -> Option<DefaultStack> {
    DefaultStack::new(DEEP_STACK).ok()
}

/// Runs `work` on a stack that is deep enough for any tree within the limits of the parser.
pub fn with_deep_stack<T>(work: impl FnOnce() -> T) -> T {
    match deep_stack() {
        Some(mut stack) => on_stack(&mut stack, work),
        // Without address space left the caller's stack has to do; only unusually deep texts need more.
        None => work(),
    }
}

thread_local! {
    /// A tree is being dropped on a deep stack of this thread.
    static IS_DEEP: Cell<bool> = const { Cell::new(false) };
}

/// Drops a tree, or parts of one, on a stack that is deep enough. Trees hold constants only: no script code runs, and
/// nothing waits.
pub fn drop_tree<T>(tree: T) {
    work_on_tree(|| drop(tree));
}

/// Work of the same kind that drops a tree by and by.
pub fn work_on_tree<T>(work: impl FnOnce() -> T) -> T {
    /// Takes the mark away, also when a drop unwinds.
    struct DeepStackGuard;
    impl Drop for DeepStackGuard {
        fn drop(&mut self) {
            let _ = IS_DEEP.try_with(|is_deep| is_deep.set(false));
        }
    }
    // At the very end of an OS thread the mark may be gone; its own stack is deep then.
    if IS_DEEP.try_with(|is_deep| is_deep.replace(true)) != Ok(false) {
        return work();
    }
    let _deep = DeepStackGuard;
    with_deep_stack(work)
}
