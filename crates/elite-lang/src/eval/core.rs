//! What all coroutines of one interpreter share.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::Rc;

use super::code::{Code, SourceSymbols};
use super::coroutine::{StackPool, StopState, ThreadState};
use super::count::CoverageCounters;
use super::expr::attribute::LookupCache;
use super::generator::PendingFinalizers;
use super::node::TaskNodes;
use super::types::Types;
use crate::debug::Debugger;
use crate::host::{Host, ThreadId};
use crate::interpreter_mode::InjectedNames;
use crate::limits::Limits;
use crate::limits::gc::CycleCollector;
use crate::ops::repr::ReprStack;
use crate::stdlib::ModuleState;
use crate::value::module::Namespace;
use crate::value::symbol::Symbols;
use crate::value::weak::WeakList;
use crate::value::{CellVar, Dict, Function, Instance, Module, R, ScriptCell, Value};

/// Safepoints between two looks at the memory in use.
pub const FUEL_SLICE: u32 = 4096;
/// From this size on a task has held so much that what it has left in the free lists is given back when it ends.
const LARGE: usize = 1 << 20;
/// How much a task has to let go of before its free lists are cleared.
const PURGE_AFTER_DROP: usize = 4 << 20;
/// A task that holds no more keeps what it frees: it will want it again.
const PURGE_MIN: usize = 64 << 20;
/// Containers of one script's data that may be nested in a native operation (comparison, `repr`) at once.
pub const NATIVE_DEPTH_MAX: u32 = 500;

/// The state of one interpreter. The cells describe the script thread that is running.
pub struct InterpreterState {
    /// The embedder.
    pub host: Rc<dyn Host>,
    /// Limits of the task.
    pub limits: Limits,
    /// Names.
    pub symbols: Rc<Symbols>,
    /// What is known about attributes that are asked for by a text.
    pub lookup_cache: LookupCache,
    /// Builtin types and exceptions.
    pub types: Types,
    /// Builtin functions, types and natives of the embedder.
    pub builtins: Rc<Namespace>,
    /// `__name__` of the builtins, which texts find in dictionaries without one.
    pub name_of_builtins: Rc<CellVar>,
    /// How many classes have been registered with abstract ones.
    pub abc_registrations: Cell<usize>,
    /// Global variables of the task.
    pub globals: Rc<Namespace>,
    /// Imported modules.
    pub modules: RefCell<Vec<Rc<Module>>>,
    /// Imported modules as scripts see them in `sys.modules`.
    pub module_table: Rc<Dict>,
    /// Native stacks.
    pub stacks: StackPool,
    /// The characters below 128 as strings.
    pub ascii: Vec<Value>,
    /// The empty string.
    pub empty_str: Value,
    /// The empty tuple.
    pub empty_tuple: Value,
    /// Safepoints left for the slices after the present one.
    pub fuel_after_slice: Cell<u32>,
    saved_fuel: Cell<Option<u32>>,
    /// Work of natives since one gave way.
    pub work_since_yield: Cell<usize>,
    /// Calls within calls.
    pub depth: Cell<u32>,
    /// The exception whose handler steps the generator that runs.
    pub outer_handled_exception: ScriptCell<Option<Rc<Instance>>>,
    /// Nesting of native operations on data.
    pub native_depth: Cell<u32>,
    /// The containers whose texts are being made.
    pub repr_stack: ReprStack,
    /// The line being executed.
    pub line: Cell<u32>,
    /// Turns of loops that the running thread has finished.
    pub turns: Cell<u64>,
    /// The node of the pendant's task that is being executed.
    pub nodes: TaskNodes,
    /// The running thread.
    pub thread: Cell<u64>,
    /// Whether the running thread is being stopped.
    pub stopping: Cell<StopState>,
    /// A native stack has overflowed: what is here may be half changed, and stays as it is.
    pub is_left: Cell<bool>,
    /// What the OS thread held when the interpreter was made.
    memory_base: isize,
    /// The most the task has been seen to hold since freed memory was given back to the system.
    memory_peak: Cell<usize>,
    memory_was_large: Cell<bool>,
    /// Bytes beyond the limit that a task which has been refused memory may use, until it holds less.
    memory_reserve: Cell<usize>,
    /// Texts being evaluated with variables of their own, innermost last: their code and their namespace.
    pub eval_stack: RefCell<Vec<(Rc<Code>, Rc<Namespace>)>>,
    /// Namespaces of evaluated texts, to break their cycles at the end.
    pub namespaces: WeakList<Namespace>,
    /// Names in code, text by text, and functions that have attributes: what a sweep of names looks at.
    pub text_names: WeakList<SourceSymbols>,
    pub functions_with_attrs: WeakList<Function>,
    /// A sweep of names is under way.
    pub sweeping: Cell<bool>,
    /// Classes being made, whose names nothing is called by yet: none are given up meanwhile.
    pub sweep_pauses: Cell<u32>,
    /// Library modules being loaded, one within another; meanwhile the thread is not interrupted, so that no other one
    /// finds a module half made.
    pub module_load_depth: Cell<u32>,
    /// What statements run by natives have defined.
    pub injected: RefCell<InjectedNames>,
    /// Executions of the lines of programs, where they are counted.
    pub counters: RefCell<Option<Rc<CoverageCounters>>>,
    /// Who watches statements, where somebody does.
    pub(crate) debugger: RefCell<Option<Rc<Debugger>>>,
    /// What generators that were given up still have to do.
    pub pending_finalizers: PendingFinalizers,
    /// What modules of the library keep.
    pub module_state: ModuleState,
    /// Possible parts of reference cycles.
    pub cycles: CycleCollector,
    /// Calls that the main thread makes as soon as it goes on (handlers of signals).
    interrupts: RefCell<VecDeque<(Value, Vec<Value>)>>,
    next_thread: Cell<u64>,
}

/// What the handler of a `MemoryError` may use beyond a limit.
fn reserve_of(limit: usize) -> usize {
    (limit / 64).min(1 << 20)
}

/// The number of the thread that runs the main program.
const MAIN_THREAD: u64 = 1;
/// Most calls that wait for the main thread; further ones are dropped, as signals are.
const INTERRUPTS_MAX: usize = 64;

impl InterpreterState {
    /// A core with Python's builtins.
    pub fn new(host: Rc<dyn Host>, limits: Limits) -> Rc<Self> {
        let memory_base = task_memory::live_bytes();
        let symbols = Rc::new(Symbols::default());
        let types = Types::new(&symbols);
        let ascii = (0..128u8)
            .map(|byte| Value::str(char::from(byte).to_string()))
            .collect();
        let core = Rc::new(InterpreterState {
            host,
            limits,
            types,
            builtins: Rc::default(),
            abc_registrations: Cell::new(0),
            name_of_builtins: CellVar::new(Value::str("builtins")),
            globals: Rc::default(),
            modules: RefCell::default(),
            module_table: Rc::new(Dict::new()),
            stacks: StackPool::default(),
            ascii,
            empty_str: Value::str(""),
            empty_tuple: Value::tuple(Vec::new()),
            fuel_after_slice: Cell::new(0),
            saved_fuel: Cell::new(None),
            work_since_yield: Cell::new(0),
            depth: Cell::new(0),
            outer_handled_exception: ScriptCell::default(),
            native_depth: Cell::new(0),
            repr_stack: ReprStack::default(),
            line: Cell::new(0),
            turns: Cell::new(0),
            nodes: TaskNodes::default(),
            thread: Cell::new(0),
            stopping: Cell::default(),
            is_left: Cell::new(false),
            memory_base,
            memory_peak: Cell::new(0),
            memory_reserve: Cell::new(0),
            memory_was_large: Cell::new(false),
            eval_stack: RefCell::default(),
            namespaces: WeakList::default(),
            text_names: WeakList::default(),
            functions_with_attrs: WeakList::default(),
            sweeping: Cell::new(false),
            sweep_pauses: Cell::new(0),
            module_load_depth: Cell::new(0),
            pending_finalizers: PendingFinalizers::default(),
            module_state: ModuleState::default(),
            cycles: CycleCollector::default(),
            injected: RefCell::default(),
            counters: RefCell::default(),
            debugger: RefCell::default(),
            interrupts: RefCell::default(),
            next_thread: Cell::new(0),
            symbols,
            lookup_cache: LookupCache::default(),
        });
        crate::builtins::install(&core);
        core
    }

    /// A number for a new script thread.
    pub fn new_thread(&self) -> u64 {
        self.next_thread.set(self.next_thread.get() + 1);
        self.next_thread.get()
    }

    /// The number of the newest script thread.
    pub fn newest_thread(&self) -> u64 {
        self.next_thread.get()
    }

    /// Gives the numbers of threads that were nobody's but a debugger's back, so that they leave no trace.
    pub fn reset_thread_counter(&self, number: u64) {
        self.next_thread.set(number);
    }

    /// Safepoints that the running thread may still pass in its slice.
    pub fn remaining_fuel(&self) -> u32 {
        task_memory::fuel().saturating_add(self.fuel_after_slice.get())
    }

    /// Whether the main program's thread is running.
    pub fn is_main_thread(&self) -> bool {
        self.thread.get() == MAIN_THREAD
    }

    /// Has the main thread call `function` as soon as it goes on, and ends its wait for that.
    pub fn interrupt_main(&self, function: Value, args: Vec<Value>) {
        let mut interrupts = self.interrupts.borrow_mut();
        if interrupts.len() < INTERRUPTS_MAX {
            interrupts.push_back((function, args));
        }
        self.host.wake(ThreadId(MAIN_THREAD));
    }

    /// The next call that the running thread has to make, if it is the main thread.
    #[inline]
    pub fn next_interrupt(&self) -> Option<(Value, Vec<Value>)> {
        if !self.is_main_thread() {
            return None;
        }
        self.interrupts.borrow_mut().pop_front()
    }

    /// Gives the running thread fuel.
    pub fn set_fuel(&self, fuel: u32) {
        let slice = fuel.min(FUEL_SLICE);
        task_memory::set_fuel(slice);
        self.fuel_after_slice.set(fuel - slice);
    }

    /// Takes away as much fuel as a slice has.
    pub fn deduct_fuel_slice(&self) {
        let fuel = task_memory::fuel();
        let left = self.fuel_after_slice.get();
        task_memory::set_fuel(fuel.saturating_sub(FUEL_SLICE));
        self.fuel_after_slice
            .set(left.saturating_sub(FUEL_SLICE.saturating_sub(fuel)));
    }

    /// Takes the next slice of fuel; false if all is used up.
    pub fn refuel(&self) -> bool {
        if self.stopping.get() != StopState::No && !self.host.unwinding_goes_on() {
            self.fuel_after_slice.set(0);
        }
        let left = self.fuel_after_slice.get();
        if left > 0 {
            self.set_fuel(left);
        }
        if left == 0 && self.module_load_depth.get() > 0 {
            self.set_fuel(FUEL_SLICE);
            return true;
        }
        left > 0
    }

    /// The thread is suspended for a search: what fuel it has is kept for when it goes on, so that whose turn it is
    /// never depends on how much memory is held.
    pub fn save_fuel(&self) {
        let left = task_memory::fuel().saturating_add(self.fuel_after_slice.get());
        self.saved_fuel.set(Some(left));
    }

    /// What fuel a thread has kept that was suspended for a search.
    pub fn take_saved_fuel(&self) -> Option<u32> {
        self.saved_fuel.take()
    }

    /// A loop, whose line this is, has finished a turn.
    #[inline]
    pub fn finish_turn(&self, line: u32) {
        self.line.set(line);
        self.turns.set(self.turns.get().wrapping_add(1));
    }

    /// Makes `state` that of the running thread; returns the one before.
    pub fn switch_to(&self, state: ThreadState) -> ThreadState {
        ThreadState {
            thread: self.thread.replace(state.thread),
            depth: self.depth.replace(state.depth),
            line: self.line.replace(state.line),
            turns: self.turns.replace(state.turns),
            node: self.nodes.switch_to(state.node),
            stopping: self.stopping.replace(state.stopping),
            native_depth: self.native_depth.replace(state.native_depth),
        }
    }

    /// The running thread is to stop.
    pub fn begin_stop(&self) {
        if self.stopping.get() == StopState::No {
            self.stopping.set(StopState::Unwinding);
            self.set_fuel(self.limits.stop_fuel);
        }
    }

    /// Watches the memory from now on: the safepoint after a search for cycles is due, or after the limit is crossed,
    /// looks at it. While more is held than that, so does the one after each further part of the limit.
    pub fn arm_memory_alarm(&self) {
        let (used, limit) = (self.memory_used(), self.memory_limit());
        let due = self.gc_threshold_bytes();
        let next = match used {
            used if used < due => due.min(limit),
            used if used < limit => limit.min(used.saturating_add(limit / 32)),
            used => used.saturating_add(limit / 32),
        };
        let next = isize::try_from(next).unwrap_or(isize::MAX);
        task_memory::set_alarm(self.memory_base.saturating_add(next));
    }

    /// Looks at how much is held. Pages whose blocks have all been freed are the system's again at once, but for those
    /// that blocks in the free lists are part of.
    pub fn update_memory_peak(&self) {
        let (used, peak) = (self.memory_used(), self.memory_peak.get());
        if used > LARGE {
            self.memory_was_large.set(true);
        }
        let limit = self.limits.memory_bytes;
        if used.saturating_add(reserve_of(limit)) < limit {
            self.memory_reserve.set(0);
        }
        let is_much = peak > PURGE_MIN.min(limit / 2);
        if is_much && peak.saturating_sub(used) > PURGE_AFTER_DROP.min(limit / 8) {
            task_memory::clear_free_lists();
            self.memory_peak.set(used);
        } else if used > peak {
            self.memory_peak.set(used);
        }
    }

    /// The task has asked for more than it may hold.
    pub fn note_memory_refusal(&self) {
        self.memory_was_large.set(true);
    }

    /// A task that has just been told that it holds too much may use a little more, to say so and to let go: otherwise
    /// whoever handles the exception would meet the next one. A few times over, then there is nothing left.
    pub fn grant_memory_reserve(&self) {
        let limit = self.limits.memory_bytes;
        let beyond = self.memory_used().saturating_sub(limit);
        let reserve = beyond.saturating_add(reserve_of(limit)).min(limit / 8);
        self.memory_reserve.set(reserve);
        self.arm_memory_alarm();
    }

    /// Bytes the task may hold now.
    pub fn memory_limit(&self) -> usize {
        let limit = self.limits.memory_bytes;
        limit.saturating_add(self.memory_reserve.get())
    }

    /// Whether the task has held so much that what it leaves is worth giving back.
    pub fn memory_was_large(&self) -> bool {
        self.memory_was_large.get()
    }

    /// No longer watches it.
    pub fn disarm_memory_alarm(&self) {
        task_memory::set_alarm(isize::MAX);
        task_memory::take_alarm();
    }

    /// Bytes the task holds: what its OS thread has come to hold since the interpreter was made.
    #[inline]
    pub fn memory_used(&self) -> usize {
        (task_memory::live_bytes() - self.memory_base).max(0) as usize
    }

    /// Bytes the task holds, with what lies ready for the next small requests.
    #[inline]
    pub fn memory_with_free_lists(&self) -> usize {
        (task_memory::allocated_bytes() - self.memory_base).max(0) as usize
    }

    /// Bytes that may still be held.
    pub fn memory_left(&self) -> usize {
        self.memory_limit().saturating_sub(self.memory_used())
    }

    /// A namespace that is taken apart when the interpreter ends.
    pub fn new_namespace(&self, parent: Option<Rc<Namespace>>) -> Rc<Namespace> {
        let namespace = Rc::new(parent.map_or_else(Namespace::default, Namespace::child_of));
        self.namespaces.push(&namespace);
        namespace
    }

    /// A string of one character.
    pub fn char_value(&self, c: char) -> Value {
        match self.ascii.get(c as usize) {
            Some(value) => value.clone(),
            None => Value::str(&*c.encode_utf8(&mut [0; 4])),
        }
    }

    /// Leaves everything as it is, for ever.
    pub fn leave(self: &Rc<Self>) {
        self.is_left.set(true);
        crate::limits::deferred_drop::leave_all();
        std::mem::forget(self.clone());
    }

    /// Breaks the cycles through globals, modules and classes.
    pub fn break_all_cycles(&self) {
        let debugger = self.debugger.take();
        if let Some(debugger) = debugger {
            debugger.dismantle();
        }
        self.globals.dismantle();
        self.interrupts.take();
        self.break_cycles();
        self.pending_finalizers.run_pending(self);
        let injected = self.injected.take();
        injected.dismantle();
        for namespace in self.namespaces.take() {
            namespace.dismantle();
        }
        let modules = std::mem::take(&mut *self.modules.borrow_mut());
        self.module_table.clear();
        for module in modules {
            module.namespace.dismantle();
        }
        self.builtins.dismantle();
        self.types.dismantle();
    }
}

/// Work to look at a value that holds others.
const LEVEL: usize = 4 * crate::limits::yielding::WORK_PER_VALUE;

impl super::Evaluator<'_> {
    /// Runs a native operation that may come back to itself through a script's data (comparison, `repr`, looking for a
    /// class in tuples), within the depth and the stack there is, and counts its work: what holds something twice holds
    /// millions of it thirty levels deep. Every such operation goes through here; nothing may be borrowed.
    #[inline]
    pub fn with_native_depth<T>(&self, inner: impl FnOnce() -> R<T>) -> R<T> {
        self.charge(LEVEL)?;
        self.deeper(inner)
    }

    /// Recursion into a call of anything but a function, or into a step of an iterator, without counting work: who
    /// calls or steps again and again has safepoints of its own.
    #[inline]
    pub fn deeper<T>(&self, inner: impl FnOnce() -> R<T>) -> R<T> {
        let core = &*self.core;
        let depth = core.native_depth.get();
        if depth + core.depth.get() >= core.limits.call_depth.max(NATIVE_DEPTH_MAX) {
            return Err(self.recursion_error());
        }
        core.native_depth.set(depth + 1);
        let _level = NativeDepthGuard(&core.native_depth);
        self.with_stack(super::coroutine::RESERVE, inner)
    }
}

/// One level of native nesting of the running thread, left when it goes out of scope. It counts down by one instead of
/// restoring what was there: between threads the count goes with `ThreadState`.
struct NativeDepthGuard<'c>(&'c Cell<u32>);

impl Drop for NativeDepthGuard<'_> {
    #[inline]
    fn drop(&mut self) {
        self.0.set(self.0.get().saturating_sub(1));
    }
}
