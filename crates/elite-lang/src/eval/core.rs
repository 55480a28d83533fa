//! What all coroutines of one interpreter share.

use std::cell::{Cell, RefCell};
use std::collections::VecDeque;
use std::rc::{Rc, Weak};

use super::code::Code;
use super::coroutine::{StackPool, Stopping, ThreadState};
use super::cycles::Cycles;
use super::types::Types;
use crate::host::{Host, ThreadId};
use crate::limits::{Limits, memory};
use crate::statement::Injected;
use crate::value::module::Namespace;
use crate::value::symbol::Symbols;
use crate::value::{Class, Dict, Module, R, Value};

/// Safepoints between two looks at the memory in use.
const SLICE: u32 = 4096;
/// Containers of one script's data that may be nested in a native operation (comparison, `repr`) at once.
pub const NATIVE_DEPTH_MAX: u32 = 500;

/// The state of one interpreter. The cells describe the script thread that is running.
pub struct Core {
    /// The embedder.
    pub host: Rc<dyn Host>,
    /// Limits of the task.
    pub limits: Limits,
    /// Names.
    pub symbols: Symbols,
    /// Builtin types and exceptions.
    pub types: Types,
    /// Builtin functions, types and natives of the embedder.
    pub builtins: Namespace,
    /// Global variables of the task.
    pub globals: Rc<Namespace>,
    /// Imported modules.
    pub modules: RefCell<Vec<Rc<Module>>>,
    /// The same for scripts to see, as `sys.modules`.
    pub module_table: Rc<Dict>,
    /// Native stacks.
    pub stacks: StackPool,
    /// The characters below 128 as strings.
    pub ascii: Vec<Value>,
    /// The empty string.
    pub empty_str: Value,
    /// The empty tuple.
    pub empty_tuple: Value,
    /// Safepoints left in the present slice.
    pub fuel: Cell<u32>,
    /// Safepoints left for the slices after it.
    pub fuel_left: Cell<u32>,
    /// Work of natives since one gave way.
    pub work: Cell<usize>,
    /// Calls within calls.
    pub depth: Cell<u32>,
    /// Nesting of native operations on data.
    pub native_depth: Cell<u32>,
    /// The line being executed.
    pub line: Cell<u32>,
    /// The running thread.
    pub thread: Cell<u64>,
    /// Whether the running thread is being stopped.
    pub stopping: Cell<Stopping>,
    /// Bytes the values of this interpreter held when it last ran.
    memory_before: Cell<isize>,
    /// The thread-wide count when it was last resumed.
    memory_mark: Cell<isize>,
    /// Classes made by scripts, to break their cycles at the end.
    pub classes: RefCell<Vec<Weak<Class>>>,
    /// Texts being evaluated with variables of their own, innermost last: their code and their namespace.
    pub texts: RefCell<Vec<(Rc<Code>, Rc<Namespace>)>>,
    /// Namespaces of evaluated texts, to break their cycles at the end.
    pub namespaces: RefCell<Vec<Weak<Namespace>>>,
    /// Library modules being loaded, one within another; meanwhile the thread is not interrupted, so that no other one
    /// finds a module half made.
    pub loading: Cell<u32>,
    /// What statements run by natives have defined.
    pub injected: RefCell<Injected>,
    /// Possible parts of reference cycles.
    pub cycles: Cycles,
    /// Calls that the main thread makes as soon as it goes on (handlers of signals).
    interrupts: RefCell<VecDeque<(Value, Vec<Value>)>>,
    next_thread: Cell<u64>,
}

/// The number of the thread that runs the main program.
const MAIN_THREAD: u64 = 1;
/// Most calls that wait for the main thread; further ones are dropped, as signals are.
const INTERRUPTS_MAX: usize = 64;

impl Core {
    /// A core with Python's builtins.
    pub fn new(host: Rc<dyn Host>, limits: Limits) -> Rc<Self> {
        let symbols = Symbols::default();
        let types = Types::new(&symbols);
        let ascii = (0..128u8)
            .map(|byte| Value::str(char::from(byte).to_string()))
            .collect();
        let core = Rc::new(Core {
            host,
            limits,
            types,
            builtins: Namespace::default(),
            globals: Rc::default(),
            modules: RefCell::default(),
            module_table: Rc::new(Dict::new()),
            stacks: StackPool::default(),
            ascii,
            empty_str: Value::str(""),
            empty_tuple: Value::tuple(Vec::new()),
            fuel: Cell::new(0),
            fuel_left: Cell::new(0),
            work: Cell::new(0),
            depth: Cell::new(0),
            native_depth: Cell::new(0),
            line: Cell::new(0),
            thread: Cell::new(0),
            stopping: Cell::default(),
            memory_before: Cell::new(0),
            memory_mark: Cell::new(memory::held()),
            classes: RefCell::default(),
            texts: RefCell::default(),
            namespaces: RefCell::default(),
            loading: Cell::new(0),
            cycles: Cycles::default(),
            injected: RefCell::default(),
            interrupts: RefCell::default(),
            next_thread: Cell::new(0),
            symbols,
        });
        crate::builtins::install(&core);
        core
    }

    /// A number for a new script thread.
    pub fn new_thread(&self) -> u64 {
        self.next_thread.set(self.next_thread.get() + 1);
        self.next_thread.get()
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
        let slice = fuel.min(SLICE);
        self.fuel.set(slice);
        self.fuel_left.set(fuel - slice);
    }

    /// Takes the fuel of a slice away.
    pub fn spend_fuel(&self) {
        let spent = SLICE - self.fuel.get().min(SLICE);
        let left = self.fuel_left.get();
        self.fuel.set(0);
        self.fuel_left.set(left.saturating_sub(spent));
    }

    /// Takes the next slice of fuel; false if all is used up.
    pub fn refuel(&self) -> bool {
        let left = self.fuel_left.get();
        if left > 0 {
            self.set_fuel(left);
        }
        if left == 0 && self.loading.get() > 0 {
            self.set_fuel(SLICE);
            return true;
        }
        left > 0
    }

    /// Makes `state` that of the running thread; returns the one before.
    pub fn switch_to(&self, state: ThreadState) -> ThreadState {
        ThreadState {
            thread: self.thread.replace(state.thread),
            depth: self.depth.replace(state.depth),
            line: self.line.replace(state.line),
            stopping: self.stopping.replace(state.stopping),
        }
    }

    /// The running thread is to stop.
    pub fn begin_stop(&self) {
        if self.stopping.get() == Stopping::No {
            self.stopping.set(Stopping::Unwinding);
            self.set_fuel(self.limits.stop_fuel);
        }
    }

    /// Starts counting what this interpreter allocates.
    pub fn memory_resume(&self) {
        self.memory_mark.set(memory::held());
    }

    /// Stops counting.
    pub fn memory_pause(&self) {
        self.memory_before.set(self.memory_now());
        self.memory_mark.set(memory::held());
    }

    fn memory_now(&self) -> isize {
        self.memory_before.get() + memory::held() - self.memory_mark.get()
    }

    /// Bytes its values hold, approximately.
    pub fn memory_used(&self) -> usize {
        self.memory_now().max(0) as usize
    }

    /// Whether `more` bytes fit the limit.
    pub fn memory_allows(&self, more: usize) -> bool {
        self.memory_used().saturating_add(more) <= self.limits.memory_bytes
    }

    /// A namespace that is taken apart when the interpreter ends.
    pub fn new_namespace(&self, parent: Option<Rc<Namespace>>) -> Rc<Namespace> {
        let namespace = Rc::new(parent.map_or_else(Namespace::default, Namespace::in_front_of));
        let mut all = self.namespaces.borrow_mut();
        if all.len() >= 64 && all.len().is_power_of_two() {
            all.retain(|namespace| namespace.strong_count() > 0);
        }
        all.push(Rc::downgrade(&namespace));
        namespace
    }

    /// A string of one character.
    pub fn char_value(&self, c: char) -> Value {
        match self.ascii.get(c as usize) {
            Some(value) => value.clone(),
            None => Value::str(&*c.encode_utf8(&mut [0; 4])),
        }
    }

    /// Breaks the cycles through globals, modules and classes.
    pub fn dismantle(&self) {
        self.globals.dismantle();
        self.interrupts.take();
        self.break_cycles();
        let injected = self.injected.take();
        injected.dismantle();
        let namespaces = std::mem::take(&mut *self.namespaces.borrow_mut());
        for namespace in namespaces.iter().filter_map(Weak::upgrade) {
            namespace.dismantle();
        }
        let modules = std::mem::take(&mut *self.modules.borrow_mut());
        self.module_table.clear();
        for module in modules {
            module.namespace.dismantle();
        }
        let classes = std::mem::take(&mut *self.classes.borrow_mut());
        for class in classes.iter().filter_map(Weak::upgrade) {
            class.dismantle();
        }
        self.builtins.dismantle();
        self.types.dismantle();
    }
}

impl super::Evaluator<'_> {
    /// Raises `MemoryError` if the task holds more than it may.
    pub fn check_memory(&self) -> R<()> {
        if self.core.memory_allows(0) {
            return Ok(());
        }
        self.core.collect();
        match self.core.memory_allows(0) {
            true => Ok(()),
            false => Err(self.memory_limit_error()),
        }
    }

    /// Raises `MemoryError` if `bytes` more would be too much.
    #[inline]
    pub fn check_allocation(&self, bytes: usize) -> R<()> {
        if bytes < 1 << 16 || self.core.memory_allows(bytes) {
            Ok(())
        } else {
            Err(self.memory_limit_error())
        }
    }

    #[cold]
    fn memory_limit_error(&self) -> crate::value::Raised {
        let limit = self.core.limits.memory_bytes >> 20;
        self.memory_error(format!(
            "the task would hold more than its {limit} MiB of memory"
        ))
    }

    /// Runs a native operation that recurses over data (comparison, `repr`), within the depth and the stack there is.
    pub fn recurse<T>(&self, inner: impl FnOnce() -> R<T>) -> R<T> {
        let depth = self.core.native_depth.get();
        if depth + self.core.depth.get() >= self.core.limits.call_depth.max(NATIVE_DEPTH_MAX) {
            return Err(self.recursion_error());
        }
        self.core.native_depth.set(depth + 1);
        let result = self.with_stack(super::coroutine::RESERVE, inner);
        self.core.native_depth.set(depth);
        result
    }
}
