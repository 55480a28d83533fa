//! Coroutines: how script threads and generators suspend, and the native stacks they run on.
//!
//! A generator that has to wait for something hands the request to the coroutine that resumed it, which hands it on,
//! until the driver of the script thread gets it: the whole thread is suspended.

use std::cell::RefCell;

use corosensei::stack::{DefaultStack, Stack};
use corosensei::{Yielder, on_stack};

use super::Evaluator;
use super::generator::{GeneratorInput, GeneratorOutput};
use super::node::NodeCursor;
use crate::host::{CleanupLimit, ThreadId};
use crate::limits::deferred_drop;
use crate::native::WaitToken;
use crate::value::{R, Unwind};

/// Debug builds use several times the stack of release builds.
const SCALE: usize = if cfg!(debug_assertions) { 6 } else { 1 };
/// Stack of a script thread before it needs segments.
pub const THREAD_STACK: usize = 256 * 1024 * SCALE;
/// Stack of a generator before it needs segments.
pub const GENERATOR_STACK: usize = 64 * 1024 * SCALE;
/// A further segment of stack for deep calls.
const SEGMENT_STACK: usize = 1024 * 1024 * SCALE;
/// What native code may use beyond what the evaluated tree needs: sorting, formatting, dropping, the host's natives.
pub const RESERVE: usize = 32 * 1024 * SCALE;
/// What one level of the tree needs at most.
pub const LEVEL: usize = 512 * SCALE;
/// Stacks kept for reuse, of each size.
const POOL_MAX: usize = 64;

/// What a script thread asks of its driver.
#[derive(Clone, Copy, Debug)]
pub enum SuspendRequest {
    /// The fuel is used up; resume whenever it suits.
    OutOfFuel,
    /// A native waits for something the embedder knows by this token.
    Wait(WaitToken),
    /// Waits for another thread, or until the host's monotonic time has come.
    Park {
        /// Seconds of `Host::monotonic`, if the wait has an end.
        until: Option<f64>,
    },
    /// A native stack has overflowed: it is suspended for ever.
    Overflow,
}

/// How a suspended script thread goes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resume {
    /// Normally.
    Continue,
    /// By unwinding: `finally` blocks and `with` exits run, no handler sees the stop.
    Stop,
}

/// Where a coroutine hands its requests.
pub enum RequestSink<'y> {
    /// To the driver of the script thread.
    Thread(&'y Yielder<Resume, SuspendRequest>),
    /// To the coroutine that resumed the generator.
    Generator(&'y Yielder<GeneratorInput, GeneratorOutput>),
}

/// Native stacks for reuse: making one costs microseconds, taking one from here nanoseconds.
#[derive(Default)]
pub struct StackPool {
    threads: RefCell<Vec<DefaultStack>>,
    generators: RefCell<Vec<DefaultStack>>,
    segments: RefCell<Vec<DefaultStack>>,
}

/// The kinds of stacks that the pool keeps apart.
#[derive(Clone, Copy, Debug)]
#[allow(missing_docs)]
pub enum StackKind {
    Thread,
    Generator,
    Segment,
}

impl StackPool {
    fn free_stacks(&self, kind: StackKind) -> (&RefCell<Vec<DefaultStack>>, usize) {
        match kind {
            StackKind::Thread => (&self.threads, THREAD_STACK),
            StackKind::Generator => (&self.generators, GENERATOR_STACK),
            StackKind::Segment => (&self.segments, SEGMENT_STACK),
        }
    }

    /// A stack, or None if the system has no more.
    pub fn take(&self, kind: StackKind) -> Option<DefaultStack> {
        let (shelf, size) = self.free_stacks(kind);
        let pooled = shelf.borrow_mut().pop();
        pooled.or_else(|| {
            let stack = DefaultStack::new(size).ok()?;
            task_memory::add_external(StackPool::cost(kind));
            Some(stack)
        })
    }

    /// What a stack of this kind counts for in the memory of its task: all of it, as if every page were touched. Debug
    /// builds count what a release build would use.
    pub fn cost(kind: StackKind) -> usize {
        match kind {
            StackKind::Thread => THREAD_STACK / SCALE,
            StackKind::Generator => GENERATOR_STACK / SCALE,
            StackKind::Segment => SEGMENT_STACK / SCALE,
        }
    }

    /// Takes a stack back.
    pub fn put_back(&self, kind: StackKind, stack: DefaultStack) {
        let mut shelf = self.free_stacks(kind).0.borrow_mut();
        if shelf.len() < POOL_MAX {
            shelf.push(stack);
        } else {
            drop(stack);
            task_memory::remove_external(StackPool::cost(kind));
        }
    }
}

impl StackPool {
    /// Gives the stacks that are not in use back to the system.
    pub fn clear(&self) {
        for kind in [StackKind::Thread, StackKind::Generator, StackKind::Segment] {
            let kept = self.free_stacks(kind).0.take();
            task_memory::remove_external(kept.len() * StackPool::cost(kind));
        }
    }
}

impl Drop for StackPool {
    fn drop(&mut self) {
        self.clear();
    }
}

/// The lowest address of `stack` that calls may reach.
pub fn limit_of(stack: &DefaultStack) -> usize {
    stack.limit().get() + 4096
}

impl Evaluator<'_> {
    /// Suspends the script thread with a request; an error means that it is to stop.
    pub fn suspend(&self, request: SuspendRequest) -> R<()> {
        if self.core.stopping.get() != StopState::No {
            return self.suspend_while_stopping(request);
        }
        crate::value::held::assert_no_borrows();
        let line = self.core.line.get();
        let resume = match &self.outlet {
            RequestSink::Thread(yielder) => yielder.suspend(request),
            RequestSink::Generator(yielder) => {
                match yielder.suspend(GeneratorOutput::Request(request)) {
                    GeneratorInput::Resumed(resume) => resume,
                    // Nobody steps a generator that has an open request.
                    GeneratorInput::Send(_) | GeneratorInput::Throw(_) => Resume::Stop,
                }
            }
        };
        self.core.line.set(line);
        match resume {
            Resume::Continue => self.deliver_interrupts(),
            Resume::Stop => {
                self.core.begin_stop();
                Err(Unwind::Stop)
            }
        }
    }

    /// Makes the calls that others have asked the main thread to make.
    #[inline]
    fn deliver_interrupts(&self) -> R<()> {
        while let Some((function, args)) = self.core.next_interrupt() {
            self.call(&function, &mut { args }, &[])?;
        }
        Ok(())
    }

    /// While a thread is stopping, waits are refused and its fuel is all it gets.
    fn suspend_while_stopping(&self, request: SuspendRequest) -> R<()> {
        let core = &*self.core;
        let cut = match request {
            SuspendRequest::OutOfFuel => CleanupLimit::Time,
            _ => CleanupLimit::Wait,
        };
        if core.stopping.get() == StopState::Unwinding && core.module_load_depth.get() == 0 {
            let thread = ThreadId(core.thread.get());
            core.host.unwinding_is_cut(thread, core.line.get(), cut);
        }
        if cut == CleanupLimit::Time {
            core.stopping.set(StopState::Abandoned);
        }
        Err(Unwind::Stop)
    }

    /// Within a long native operation: other threads have their turn, and the thread may be told to stop.
    pub fn yield_now(&self) -> R<()> {
        if self.core.module_load_depth.get() > 0 || self.core.stopping.get() != StopState::No {
            return Ok(());
        }
        self.suspend(SuspendRequest::OutOfFuel)
    }

    #[cold]
    #[inline(never)]
    pub(super) fn out_of_fuel(&self) -> R<()> {
        let alarmed = self.run_safepoint_duties()?;
        if alarmed || task_memory::fuel() > 0 || self.core.refuel() {
            return Ok(());
        }
        self.suspend(SuspendRequest::OutOfFuel)
    }

    /// What is due from time to time: the look at the memory, last acts, a search for circles. Whether more memory is
    /// held than before, and not the fuel has run out.
    pub(crate) fn run_safepoint_duties(&self) -> R<bool> {
        deferred_drop::run_deferred_drops();
        self.core.update_memory_peak();
        self.sweep_names_if_due()?;
        self.core.pending_finalizers.run_pending(&self.core);
        let alarmed = task_memory::take_alarm();
        // While a module is loaded no search begins: the module must not be seen half loaded, and it makes little.
        if self.core.stopping.get() == StopState::No
            && self.core.module_load_depth.get() == 0
            && !self.core.is_gc_running()
            && self.core.start_gc_if_due()
            && !self.core.run_gc_slice()
        {
            // The driver goes on with the search before it resumes this thread, which then has the fuel it has now.
            self.core.save_fuel();
            self.suspend(SuspendRequest::OutOfFuel)?;
        }
        self.core.arm_memory_alarm();
        self.check_memory()?;
        Ok(alarmed)
    }

    /// Bytes of native stack left before the limit.
    #[inline]
    pub fn stack_left(&self) -> usize {
        let marker = 0u8;
        let here = std::ptr::from_ref(&marker) as usize;
        here.saturating_sub(self.stack_limit.get())
    }

    /// Runs `inner` with at least `bytes` of native stack: here, or on a further segment.
    #[inline]
    pub fn with_stack<T, E: From<Unwind>>(
        &self,
        bytes: usize,
        inner: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        if self.stack_left() >= bytes {
            return inner();
        }
        self.on_segment(bytes, inner)
    }

    /// Runs `inner`, which works on trees that may be deep and may pause meanwhile, on a stack of its own.
    pub fn with_deep_stack<T>(&self, inner: impl FnOnce() -> T) -> T {
        let Some(mut stack) = elite_syntax::deep_stack() else {
            // Without address space left the caller's stack has to do; only unusually deep texts need more.
            return inner();
        };
        let outer = self.stack_limit.replace(limit_of(&stack));
        let result = on_stack(&mut stack, inner);
        self.stack_limit.set(outer);
        result
    }

    #[cold]
    #[inline(never)]
    fn on_segment<T, E: From<Unwind>>(
        &self,
        bytes: usize,
        inner: impl FnOnce() -> Result<T, E>,
    ) -> Result<T, E> {
        let large = (bytes + RESERVE > SEGMENT_STACK).then_some(bytes * 2);
        let stack = match large {
            None => self.core.stacks.take(StackKind::Segment),
            Some(size) => {
                let stack = DefaultStack::new(size).ok();
                task_memory::add_external(stack.as_ref().map_or(0, |_| size / SCALE));
                stack
            }
        };
        let Some(mut stack) = stack else {
            let error = self.memory_error("the system has no memory for a deeper call");
            return Err(error.into());
        };
        let outer = self.stack_limit.replace(limit_of(&stack));
        // What frees memory takes native stack itself, and only here there is enough of it.
        let result = on_stack(&mut stack, || {
            self.check_allocation(0)?;
            inner()
        });
        self.stack_limit.set(outer);
        match large {
            None => self.core.stacks.put_back(StackKind::Segment, stack),
            Some(size) => {
                drop(stack);
                task_memory::remove_external(size / SCALE);
            }
        }
        result
    }
}

/// How far the stop of a thread has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StopState {
    /// The thread is not being stopped.
    #[default]
    No,
    /// `finally` blocks and `with` exits run, with limited fuel.
    Unwinding,
    /// No more script code runs.
    Abandoned,
}

/// State of the running script thread that is kept while it is suspended.
#[derive(Clone, Copy, Debug, Default)]
pub struct ThreadState {
    /// Number of the thread.
    pub thread: u64,
    /// Calls within calls.
    pub depth: u32,
    /// The line being executed.
    pub line: u32,
    /// Turns of loops that the thread has finished.
    pub turns: u64,
    /// Where the thread stands in the pendant's task.
    pub node: NodeCursor,
    /// Whether the thread is being stopped.
    pub stopping: StopState,
    /// Native operations within native operations.
    pub native_depth: u32,
}
