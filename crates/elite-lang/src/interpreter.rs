//! The interpreter of one task, and its script threads as the embedder drives them.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::ops::Deref;
use std::rc::Rc;

use corosensei::stack::DefaultStack;
use corosensei::{Coroutine, CoroutineResult};
use elite_syntax::{Program, ProgramKind, TaskNode, WorkBudget, with_deep_stack};
use messages::{Text, text};

use crate::builtins::Builtin;
use crate::debug::{DebugHook, Debugger, PausedProgram};
use crate::embedded;
use crate::errors::ScriptError;
use crate::eval::coroutine::{
    RequestSink, Resume, StackKind, StopState, SuspendRequest, ThreadState, limit_of,
};
use crate::eval::count::LineCounts;
use crate::eval::node::{NodeChange, NodeCursor};
use crate::eval::{Evaluator, InterpreterState};
use crate::host::{Host, ThreadId};
use crate::limits::Limits;
use crate::limits::deferred_drop;
use crate::limits::overflow::{Exit, Watch};
use crate::native::{NativeFunction, WaitToken};
use crate::value::{Function, R, Unwind, Value};

/// The interpreter of one task: its globals, its script threads. Stays on the OS thread that made it.
pub struct Interpreter {
    core: Rc<InterpreterState>,
    // Dropped after the core, whose tables go back to the system as well.
    leftovers: Rc<FreeListPurge>,
}

/// The blocks that a task has left in the free lists of its thread. They go back to the system, if that is worth it,
/// when the interpreter and everybody who has asked for this (`Interpreter::free_list_purge`) has dropped it.
#[derive(Default)]
pub struct FreeListPurge {
    are_large: Cell<bool>,
}

impl Drop for FreeListPurge {
    fn drop(&mut self) {
        if self.are_large.get() {
            task_memory::clear_free_lists();
        }
    }
}

/// A program in the account of the task that runs it, wherever it was compiled.
struct AccountedProgram(Option<Program>);

impl AccountedProgram {
    fn new(program: Program) -> Self {
        let guest = AccountedProgram(Some(program));
        if guest.is_foreign() {
            task_memory::add_external(guest.tree_bytes());
        }
        guest
    }

    fn is_foreign(&self) -> bool {
        self.compiled_by() != std::thread::current().id()
    }
}

impl Deref for AccountedProgram {
    type Target = Program;

    fn deref(&self) -> &Program {
        // Taken out only when it is dropped.
        self.0.as_ref().unwrap_or_else(|| unreachable!())
    }
}

impl Drop for AccountedProgram {
    fn drop(&mut self) {
        if self.is_foreign() {
            task_memory::remove_external(self.tree_bytes());
            task_memory::uncounted(|| drop(self.0.take()));
        }
    }
}

impl Interpreter {
    /// An interpreter whose programs find the given natives beside Python's builtins.
    pub fn new(host: Rc<dyn Host>, natives: Vec<NativeFunction>, limits: Limits) -> Self {
        let core = InterpreterState::new(host, limits);
        for native in natives {
            let name = core.symbols.intern(native.name);
            core.builtins.set(name, Builtin::native(&core, native));
        }
        Interpreter {
            core,
            leftovers: Rc::default(),
        }
    }

    /// A script thread that runs the top-level statements of a program in the globals of the task; a program that
    /// consists of one function runs that. Nothing runs before the first `resume`.
    pub fn spawn_program(&self, program: &Program) -> ScriptThread {
        let (core, program) = (self.core.clone(), AccountedProgram::new(program.clone()));
        ScriptThread::new(&self.core, move |ev| {
            let namespace = core.globals.clone();
            ev.check_allocation(program.tree_bytes())?;
            let code = with_deep_stack(|| {
                let (module, resolution) = (program.module(), program.resolution());
                let budget = WorkBudget::with_limit(usize::MAX);
                crate::lower::program(
                    &core,
                    &namespace,
                    program.file(),
                    module,
                    resolution,
                    &budget,
                )
            });
            let function = Function::without_defaults(code, Box::default());
            let result = ev.call_function(&function, &mut [], &[])?;
            let entry = program.entry();
            let entry = entry.and_then(|entry| namespace.get(core.symbols.intern(entry)));
            let result = match entry {
                Some(function) => ev.call(&function, &mut [], &[])?,
                None => result,
            };
            if program.kind() == ProgramKind::Main {
                crate::stdlib::finish_main(ev)?;
            }
            Ok(result)
        })
    }

    /// A script thread that calls a function, as `start_thread` does.
    ///
    /// # Errors
    /// If `function` cannot be called at all.
    pub fn spawn_call(
        &self,
        function: Value,
        args: Vec<Value>,
    ) -> Result<ScriptThread, Box<ScriptError>> {
        let callable = match &function {
            Value::Function(_) | Value::Builtin(_) | Value::BoundMethod(_) | Value::Class(_) => {
                true
            }
            other => self
                .core
                .types
                .of(other)
                .lookup(crate::value::symbol::known::CALL)
                .is_some(),
        };
        if !callable {
            let name = self.core.types.name_of(&function);
            return Err(Box::new(ScriptError {
                exception: "TypeError".to_owned(),
                message: Text::verbatim(format!("'{name}' object is not callable")),
                traceback: Vec::new(),
                node: None,
                help: None,
                previous: None,
            }));
        }
        Ok(ScriptThread::new(&self.core, move |ev| {
            ev.call(&function, &mut { args }, &[])
        }))
    }

    /// From now on `watcher` hears of every statement of the programs that are spawned after this.
    pub fn debug(&self, watcher: Rc<dyn DebugHook>) {
        *self.core.debugger.borrow_mut() = Some(Rc::new(Debugger::new(watcher)));
    }

    /// Runs `look` on the program while no script thread runs; None where nobody watches it.
    pub fn halted<T>(&self, look: impl FnOnce(&PausedProgram<'_>) -> T) -> Option<T> {
        let debugger = self.core.debugger.borrow().clone()?;
        Some(look(&PausedProgram::without_thread(&self.core, &debugger)))
    }

    /// From now on the executions of the lines of programs are counted, of those that are spawned after this.
    pub fn count_lines(&self) {
        *self.core.counters.borrow_mut() = Some(Rc::default());
    }

    /// What was counted, by the names of the texts.
    pub fn line_counts(&self) -> BTreeMap<String, LineCounts> {
        let counters = self.core.counters.borrow();
        counters
            .as_ref()
            .map(|counters| counters.totals())
            .unwrap_or_default()
    }

    /// An object that programs find beside the builtins, with methods of the embedder. `name` is its own and its
    /// class's.
    pub fn provide_object(&self, name: &str, methods: Vec<NativeFunction>) {
        let object = embedded::object(&self.core, name, methods, Vec::new());
        self.core
            .builtins
            .set(self.core.symbols.intern(name), object);
    }

    /// The value of a global variable.
    pub fn global(&self, name: &str) -> Option<Value> {
        self.core.globals.get(self.core.symbols.find(name)?)
    }

    /// Sets a global variable.
    pub fn set_global(&self, name: &str, value: Value) {
        self.core.globals.set(self.core.symbols.intern(name), value);
    }

    /// The names of all global variables that are bound, in the order they first appeared.
    pub fn global_names(&self) -> Vec<String> {
        let entries = self.core.globals.entries();
        entries
            .into_iter()
            .map(|(name, _)| self.core.symbols.name(name).to_string())
            .collect()
    }

    /// Bytes the task holds: what its OS thread has come to hold since the interpreter was made.
    pub fn memory_used(&self) -> usize {
        self.core.memory_used()
    }

    /// Whether a search for cycles is under way: the thread that was resumed last has not had its turn yet.
    pub fn is_gc_running(&self) -> bool {
        self.core.is_gc_running()
    }

    /// What is left of the task in the system's allocator. Who drops this last, on the thread that ran the task, gives
    /// it back: after others have been told that the task has ended, for it takes its time.
    pub fn free_list_purge(&self) -> Rc<FreeListPurge> {
        self.leftovers.clone()
    }

    /// What all script threads share. For the interpreter's own library.
    pub fn core(&self) -> &Rc<InterpreterState> {
        &self.core
    }
}

impl Drop for Interpreter {
    fn drop(&mut self) {
        if self.core.is_left.get() {
            return;
        }
        self.core.update_memory_peak();
        while deferred_drop::run_deferred_drops() {}
        self.core.break_all_cycles();
        let are_large = self.core.memory_was_large();
        self.leftovers.are_large.set(are_large);
    }
}

/// What a call of `ScriptThread::resume` came to.
#[derive(Debug)]
pub enum ResumeOutcome {
    /// The fuel is used up; resume again whenever it suits.
    OutOfFuel,
    /// A native waits; resume when what the token stands for has happened.
    Waiting(WaitToken),
    /// The thread waits for another one (lock, queue, condition) or for time to pass: resume when `Host::wake` is
    /// called for it, or when `Host::monotonic` has reached `until`.
    Parked {
        /// Seconds of `Host::monotonic`; None if only another thread can end the wait.
        until: Option<f64>,
    },
    /// The thread ended with this result.
    Done(Value),
    /// An exception ended the thread.
    Failed(Box<ScriptError>),
    /// The thread was stopped.
    Stopped,
}

enum ThreadEnd {
    Done(Value),
    Failed(Box<ScriptError>),
    Stopped,
}

type ThreadCoroutine = Coroutine<Resume, SuspendRequest, ThreadEnd, DefaultStack>;

/// A script thread. Runs only while `resume` runs.
pub struct ScriptThread {
    core: Rc<InterpreterState>,
    id: ThreadId,
    state: ThreadState,
    coroutine: Option<ThreadCoroutine>,
    exit: Rc<Exit>,
    /// The fuel it had when it was suspended for a search.
    fuel_kept: Option<u32>,
    /// What to report when it has no coroutine any more.
    ended: Option<ResumeOutcome>,
}

impl ScriptThread {
    pub(crate) fn new(
        core: &Rc<InterpreterState>,
        body: impl FnOnce(&Evaluator<'_>) -> R + 'static,
    ) -> Self {
        let number = core.new_thread();
        let exit = Rc::new(Exit::new(std::ptr::null()));
        let (coroutine, ended) = match core.stacks.take(StackKind::Thread) {
            Some(stack) => (Some(start(core.clone(), stack, exit.clone(), body)), None),
            None => (None, Some(ResumeOutcome::Failed(Box::new(no_stack())))),
        };
        let state = ThreadState {
            thread: number,
            // The node is that of the thread that starts this one, if one runs.
            node: core.nodes.state().for_new_thread(),
            ..ThreadState::default()
        };
        ScriptThread {
            core: core.clone(),
            id: ThreadId(number),
            state,
            coroutine,
            exit,
            fuel_kept: None,
            ended,
        }
    }

    /// The number of the thread, unique in the interpreter.
    pub fn id(&self) -> ThreadId {
        self.id
    }

    /// The line that the thread is at, from 1; 0 before it has started.
    pub fn current_line(&self) -> u32 {
        self.state.line
    }

    /// How many turns of loops the thread has finished: whether it came round to its line again.
    pub fn finished_turns(&self) -> u64 {
        self.state.turns
    }

    /// The node of the pendant's task that it is in, as its `$ LINE` directives tell; None before the first one.
    pub fn current_node(&self) -> Option<TaskNode> {
        self.core.nodes.shown_node(self.state.node)
    }

    /// The nodes that the thread that was resumed last came to meanwhile, in order; of very many, the first and the
    /// last.
    pub fn take_node_changes(&self) -> Vec<NodeChange> {
        self.core.nodes.take_node_changes()
    }

    /// Begins at the node where the thread that starts it stood; to be called before it is resumed.
    pub fn start_at_node(&mut self, node: NodeCursor) {
        self.state.node = node;
    }

    /// Whether the thread has ended.
    pub fn is_ended(&self) -> bool {
        self.coroutine.is_none()
    }

    /// Runs it until it waits, ends, or has passed `fuel` safepoints (back-edges of loops and calls). With
    /// `Resume::CancelFlag` it unwinds: `finally` blocks and `with` exits run, with the fuel of `Limits::stop_fuel` in
    /// total; a second stop unwinds without running more code.
    ///
    /// # Panics
    /// When a native stack has overflowed, which is a fault of ours. The interpreter and its threads are to be dropped
    /// then; they leave everything as it is, and no interpreter is made on this OS thread any more.
    pub fn resume(&mut self, resume: Resume, fuel: u32) -> ResumeOutcome {
        let Some(mut coroutine) = self.coroutine.take() else {
            return self.ended.take().unwrap_or(ResumeOutcome::Stopped);
        };
        if resume == Resume::Stop && !coroutine.started() {
            return ResumeOutcome::Stopped;
        }
        let core = self.core.clone();
        if core.is_gc_running() {
            if resume == Resume::Stop {
                core.abandon_gc();
            } else if !core.run_gc_slice() {
                // No script code runs before the search for cycles is over.
                self.coroutine = Some(coroutine);
                return ResumeOutcome::OutOfFuel;
            }
        }
        let outer = core.switch_to(self.state);
        core.set_fuel(self.fuel_kept.take().unwrap_or(fuel));
        core.arm_memory_alarm();
        let outer_puts_off = deferred_drop::set_deferring(true);
        deferred_drop::run_deferred_drops();
        let watch = Watch::begin(&self.exit);
        let result = coroutine.resume(resume);
        if let CoroutineResult::Yield(SuspendRequest::Overflow) = result {
            watch.give_up();
            std::mem::forget(coroutine);
            self.overflowed();
        }
        drop(watch);
        deferred_drop::set_deferring(outer_puts_off);
        self.state = core.switch_to(outer);
        let debugger = core.debugger.borrow().clone();
        if let Some(debugger) = debugger {
            match &result {
                CoroutineResult::Yield(_) => debugger.on_suspend(self.id.0, self.state.depth),
                CoroutineResult::Return(_) => debugger.on_thread_end(self.id.0),
            }
        }
        core.disarm_memory_alarm();
        self.fuel_kept = core.take_saved_fuel();
        match result {
            CoroutineResult::Yield(request) => {
                self.coroutine = Some(coroutine);
                match request {
                    SuspendRequest::OutOfFuel => ResumeOutcome::OutOfFuel,
                    SuspendRequest::Wait(token) => ResumeOutcome::Waiting(token),
                    SuspendRequest::Park { until } => ResumeOutcome::Parked { until },
                    // Dealt with above.
                    SuspendRequest::Overflow => ResumeOutcome::Stopped,
                }
            }
            CoroutineResult::Return(end) => {
                core.stacks
                    .put_back(StackKind::Thread, coroutine.into_stack());
                match end {
                    ThreadEnd::Done(value) => ResumeOutcome::Done(value),
                    ThreadEnd::Failed(error) => ResumeOutcome::Failed(error),
                    ThreadEnd::Stopped => ResumeOutcome::Stopped,
                }
            }
        }
    }
}

impl ScriptThread {
    #[cold]
    fn overflowed(&mut self) -> ! {
        self.core.leave();
        self.state.line = self.core.line.get();
        let (line, thread) = (self.state.line, self.id.0);
        panic!("a native stack of script thread {thread} has overflowed, at line {line}");
    }
}

impl Drop for ScriptThread {
    /// A thread that is given up unwinds like a stopped one, but without running more code.
    fn drop(&mut self) {
        if self.core.is_left.get() {
            return std::mem::forget(self.coroutine.take());
        }
        self.state.stopping = StopState::Abandoned;
        while self.coroutine.is_some() {
            self.resume(Resume::Stop, 0);
        }
    }
}

fn start(
    core: Rc<InterpreterState>,
    stack: DefaultStack,
    exit: Rc<Exit>,
    body: impl FnOnce(&Evaluator<'_>) -> R + 'static,
) -> ThreadCoroutine {
    let limit = limit_of(&stack);
    Coroutine::with_stack(stack, move |yielder, _| {
        exit.set(yielder);
        let ev = Evaluator::new(core, RequestSink::Thread(yielder), limit);
        match body(&ev) {
            Ok(value) => ThreadEnd::Done(value),
            Err(Unwind::Stop) => ThreadEnd::Stopped,
            Err(Unwind::Exception(exception)) => ev.end_of(&exception),
        }
    })
}

impl Evaluator<'_> {
    /// What an exception that nobody handled makes of its thread. `SystemExit` without an error code is a normal end.
    fn end_of(&self, exception: &Rc<crate::value::Instance>) -> ThreadEnd {
        let exit = self
            .core
            .types
            .exception(crate::errors::ExceptionKind::SystemExit);
        if exception.class.is_subclass_of(exit) {
            let code = self.attribute(
                &Value::Instance(exception.clone()),
                crate::value::symbol::known::CODE,
            );
            if matches!(code, Ok(Value::None | Value::Int(0) | Value::Bool(false))) {
                return ThreadEnd::Done(Value::None);
            }
        }
        ThreadEnd::Failed(Box::new(self.report(exception)))
    }
}

fn no_stack() -> ScriptError {
    let message = text!(
        "the system has no memory for another script thread",
        "系统没有内存可用于另一个脚本线程"
    );
    ScriptError {
        exception: "MemoryError".to_owned(),
        message,
        traceback: Vec::new(),
        node: None,
        help: None,
        previous: None,
    }
}
