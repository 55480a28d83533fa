//! Native stack for work on trees that may be deep: parsing, resolving, lowering. The caller's own stack may be small.

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
