//! Generators: what hands values to whoever steps it. Most are a place in a list of steps (`steps`), the others are
//! coroutines.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use corosensei::stack::DefaultStack;
use corosensei::{Coroutine, CoroutineResult};

use super::coroutine::{RequestSink, Resume, StackKind, StopState, SuspendRequest, limit_of};
use super::steps::{GeneratorFrame, GeneratorStep};
use super::{Evaluator, Frame, InterpreterState};
use crate::errors::ExceptionKind;
use crate::limits::deferred_drop;
use crate::value::held::assert_no_borrows;
use crate::value::symbol::known;
use crate::value::{Function, R, ScriptCell, Unwind, Value};

/// What a generator is resumed with.
pub enum GeneratorInput {
    /// The value of the `yield` it stands at; ignored by the first step.
    Send(Value),
    /// Unwind at the `yield` it stands at.
    Throw(Unwind),
    /// How the request it made for its script thread ended.
    Resumed(Resume),
}

/// What a generator suspends with.
pub enum GeneratorOutput {
    /// The next value, and what is to be seen of the generator until it goes on.
    Yield(Value, SuspendedFrame),
    /// A request for the script thread.
    Request(SuspendRequest),
}

/// What is to be seen of a suspended generator that has a stack of its own.
#[derive(Default)]
pub struct SuspendedFrame {
    /// A second reference to each variable, for the search for cycles.
    slots: Vec<Value>,
    /// A second reference to what `yield from` delegates to; `Unbound` if to nothing.
    delegate: Value,
    line: u32,
}

type GeneratorCoroutine = Coroutine<GeneratorInput, GeneratorOutput, R, DefaultStack>;

/// A generator object.
pub struct Generator {
    /// The function it was made from.
    pub function: Rc<Function>,
    core: Rc<InterpreterState>,
    state: ScriptCell<GeneratorState>,
    /// Where it stands, if it has no stack of its own; taken out while it runs.
    standing: ScriptCell<Option<Box<GeneratorFrame>>>,
    /// While it is suspended with a stack of its own.
    suspended_frame: ScriptCell<SuspendedFrame>,
    /// `__name__` and `__qualname__`, if a script has changed them.
    names: ScriptCell<Option<Box<[Option<Value>; 2]>>>,
    /// A search for cycles has found it in use.
    pub old: Cell<bool>,
}

enum GeneratorState {
    /// Not started: its slots, parameters bound.
    Fresh(InitialSlots),
    /// At the place in `standing`, or running from there.
    Standing,
    Suspended(GeneratorCoroutine),
    Running,
    Finished,
}

/// The slots of a generator that has not started. An argument may be a generator that has not started, and so on.
struct InitialSlots(Vec<Value>);

impl Drop for InitialSlots {
    fn drop(&mut self) {
        deferred_drop::drop_values(&mut self.0);
    }
}

/// What a step of a generator gave.
pub enum StepResult {
    /// The next value.
    Yielded(Value),
    /// The generator returned this value.
    Returned(Value),
}

impl Generator {
    /// A generator of `function` that starts with these slots.
    pub fn new(core: Rc<InterpreterState>, function: Rc<Function>, slots: Vec<Value>) -> Self {
        let (state, standing) = match function.code.body.steps() {
            Some(_) => (
                GeneratorState::Standing,
                Some(Box::new(GeneratorFrame::new(slots))),
            ),
            None => (GeneratorState::Fresh(InitialSlots(slots)), None),
        };
        Generator {
            function,
            core,
            state: ScriptCell::new(state),
            standing: ScriptCell::new(standing),
            suspended_frame: ScriptCell::default(),
            names: ScriptCell::default(),
            old: Cell::new(false),
        }
    }

    /// Runs `each` on what it refers to: its function and its variables. What lies on its native stack beyond the
    /// variables cannot be seen.
    pub fn visit(&self, each: &mut dyn FnMut(&Value)) {
        each(&Value::Function(self.function.clone()));
        if let Some(state) = self.state.try_borrow()
            && let GeneratorState::Fresh(slots) = &*state
        {
            slots.0.iter().for_each(&mut *each);
        }
        if self.has_stack() {
            // The native stack of a generator refers to its function as well.
            each(&Value::Function(self.function.clone()));
        }
        if let Some(standing) = self.standing.try_borrow()
            && let Some(standing) = &*standing
        {
            standing.visit(each);
        }
        if let Some(seen) = self.suspended_frame.try_borrow() {
            // Each is referred to by its variable and by this list.
            seen.slots.iter().for_each(|value| {
                each(value);
                each(value);
            });
            each(&seen.delegate);
        }
    }

    /// Whether it is suspended with a native stack, so that ending it runs its `finally` blocks.
    pub fn has_stack(&self) -> bool {
        matches!(
            self.state.try_borrow().as_deref(),
            Some(GeneratorState::Suspended(_))
        )
    }

    /// Ends it, unless it is executing: what it holds is let go, `finally` blocks run as when it is dropped.
    pub fn end(&self) {
        if !self.is_running() {
            self.unwind();
            self.finish();
        }
    }

    /// Whether the generator has ended.
    pub fn is_finished(&self) -> bool {
        matches!(&*self.state.borrow(), GeneratorState::Finished)
    }

    /// Whether the generator is executing right now.
    pub fn is_running(&self) -> bool {
        match &*self.state.borrow() {
            GeneratorState::Running => true,
            GeneratorState::Standing => self.standing.borrow().is_none(),
            GeneratorState::Fresh(_) | GeneratorState::Suspended(_) | GeneratorState::Finished => {
                false
            }
        }
    }

    /// Whether the generator stands at a `yield`.
    pub fn is_suspended(&self) -> bool {
        match &*self.state.borrow() {
            GeneratorState::Suspended(_) => true,
            GeneratorState::Standing => {
                let standing = self.standing.borrow();
                standing
                    .as_ref()
                    .is_some_and(|standing| standing.is_at_yield())
            }
            GeneratorState::Fresh(_) | GeneratorState::Running | GeneratorState::Finished => false,
        }
    }

    /// `__name__`, of the function unless a script has changed it.
    pub fn name(&self) -> Value {
        let own = self
            .names
            .borrow()
            .as_ref()
            .and_then(|names| names[0].clone());
        own.unwrap_or_else(|| match &*self.function.attrs.borrow() {
            Some(attrs) if attrs.get(known::NAME).is_some() => {
                attrs.get(known::NAME).cloned().unwrap_or_default()
            }
            _ => Value::str(&*self.function.code.name),
        })
    }

    /// `__qualname__`, of the function unless a script has changed it.
    pub fn qualname(&self) -> Value {
        let own = self
            .names
            .borrow()
            .as_ref()
            .and_then(|names| names[1].clone());
        own.unwrap_or_else(|| Value::str(&*self.function.qualname()))
    }

    /// Changes `__name__` or `__qualname__`.
    pub fn rename(&self, name: Option<Value>, qualname: Option<Value>) {
        let mut names = match self.names.take() {
            Some(names) => *names,
            None => [None, None],
        };
        names[0] = name.or(names[0].take());
        names[1] = qualname.or(names[1].take());
        self.names.put(Some(Box::new(names)));
    }

    /// The values of its slots, as far as they are to be seen: not while it runs.
    pub fn variables(&self) -> Vec<Value> {
        if let GeneratorState::Fresh(slots) = &*self.state.borrow() {
            return slots.0.clone();
        }
        match &*self.standing.borrow() {
            Some(standing) => standing.slots().to_vec(),
            None => self.suspended_frame.borrow().slots.clone(),
        }
    }

    /// What it delegates to by `yield from`, or None.
    pub fn delegate(&self) -> Value {
        if self.is_running() || self.is_finished() {
            return Value::None;
        }
        let delegate = match &*self.standing.borrow() {
            Some(standing) => self
                .function
                .code
                .body
                .steps()
                .and_then(|steps| standing.delegate(steps)),
            None => Some(self.suspended_frame.borrow().delegate.clone()),
        };
        delegate
            .filter(|value| !value.is_unbound())
            .unwrap_or(Value::None)
    }

    /// The line it stands in; 0 if it has not started.
    pub fn line(&self) -> u32 {
        match &*self.standing.borrow() {
            Some(standing) => {
                let steps = self.function.code.body.steps();
                steps.map_or(0, |steps| standing.line(steps))
            }
            None => self.suspended_frame.borrow().line,
        }
    }

    fn start(&self, slots: InitialSlots) -> Option<GeneratorCoroutine> {
        let stack = self.core.stacks.take(StackKind::Generator)?;
        let (core, function) = (self.core.clone(), self.function.clone());
        let limit = limit_of(&stack);
        Some(Coroutine::with_stack(stack, move |yielder, input| {
            if let GeneratorInput::Throw(raised) = input {
                return Err(raised);
            }
            let ev = Evaluator::new(core, RequestSink::Generator(yielder), limit);
            // The stack itself counts. What frees memory takes native stack, and here there is enough of it.
            ev.check_allocation(0)?;
            let mut slots = slots;
            let code = function.code.clone();
            ev.with_stack(code.stack_bytes, || {
                let mut frame = Frame {
                    slots: &mut slots.0,
                    function: &function,
                };
                code.body.run(&ev, &mut frame)
            })
        }))
    }

    /// Whether the slots of a generator that has not started are given up, so that it is over.
    fn finish_fresh(&self) -> bool {
        let fresh = match &*self.state.borrow() {
            GeneratorState::Fresh(_) => true,
            GeneratorState::Standing => {
                let standing = self.standing.borrow();
                standing
                    .as_ref()
                    .is_some_and(|standing| !standing.is_at_yield())
            }
            GeneratorState::Suspended(_) | GeneratorState::Running | GeneratorState::Finished => {
                false
            }
        };
        if fresh {
            self.finish();
        }
        fresh
    }

    /// Ends the generator and drops what it holds, which may run script code.
    fn finish(&self) {
        let state = self.state.replace(GeneratorState::Finished);
        let standing = self.standing.take();
        drop((state, standing));
    }
}

impl Evaluator<'_> {
    /// Steps a generator to its next `yield` or its end.
    pub fn step_generator(&self, generator: &Generator, input: GeneratorInput) -> R<StepResult> {
        assert_no_borrows();
        if let GeneratorInput::Throw(raised) = &input
            && generator.finish_fresh()
        {
            return Err(raised.clone());
        }
        if let Some(steps) = generator.function.code.body.steps() {
            return self.step_frame(generator, steps, input);
        }
        let state = generator.state.replace(GeneratorState::Running);
        let mut coroutine = match state {
            GeneratorState::Suspended(coroutine) => coroutine,
            GeneratorState::Fresh(slots) => match generator.start(slots) {
                Some(coroutine) => coroutine,
                None => {
                    generator.state.put(GeneratorState::Finished);
                    return Err(self.memory_error("the system has no memory for another generator"));
                }
            },
            GeneratorState::Running => {
                return Err(self.raise(ExceptionKind::ValueError, "generator already executing"));
            }
            GeneratorState::Finished | GeneratorState::Standing => {
                generator.state.put(GeneratorState::Finished);
                return step_finished(input);
            }
        };
        let core = &self.core;
        let (depth, line) = (core.depth.get(), core.line.get());
        if depth >= core.limits.call_depth {
            generator.state.put(GeneratorState::Suspended(coroutine));
            return Err(self.recursion_error());
        }
        core.depth.set(depth + 1);
        drop(generator.suspended_frame.take());
        let mut input = input;
        let (handled, outside) = (
            self.handled_exception(),
            core.outer_handled_exception.take(),
        );
        let result = loop {
            core.outer_handled_exception.put(handled.clone());
            match coroutine.resume(input) {
                CoroutineResult::Yield(GeneratorOutput::Yield(value, seen)) => {
                    generator.suspended_frame.put(seen);
                    generator.state.put(GeneratorState::Suspended(coroutine));
                    break Ok(StepResult::Yielded(value));
                }
                CoroutineResult::Yield(GeneratorOutput::Request(request)) => {
                    let resume = match self.suspend(request) {
                        Ok(()) => Resume::Continue,
                        Err(_) => Resume::Stop,
                    };
                    input = GeneratorInput::Resumed(resume);
                }
                CoroutineResult::Return(result) => {
                    generator.state.put(GeneratorState::Finished);
                    core.stacks
                        .put_back(StackKind::Generator, coroutine.into_stack());
                    break result.map(StepResult::Returned);
                }
            }
        };
        core.outer_handled_exception.put(outside);
        core.depth.set(depth);
        core.line.set(line);
        result
    }

    /// Steps a generator without a stack of its own to its next `yield` or its end.
    fn step_frame(
        &self,
        generator: &Generator,
        steps: &[GeneratorStep],
        input: GeneratorInput,
    ) -> R<StepResult> {
        let core = &*self.core;
        let (depth, line) = (core.depth.get(), core.line.get());
        if generator.is_finished() {
            return step_finished(input);
        }
        if depth >= core.limits.call_depth && !generator.is_running() {
            return Err(self.recursion_error());
        }
        // Taken out, so that nothing is borrowed while it runs.
        let Some(mut standing) = generator.standing.take() else {
            return Err(self.raise(ExceptionKind::ValueError, "generator already executing"));
        };
        core.depth.set(depth + 1);
        let result = self.with_stack(generator.function.code.stack_bytes, || {
            self.resume_steps(steps, &mut standing, &generator.function, input)
        });
        generator.standing.put(Some(standing));
        if !matches!(result, Ok(StepResult::Yielded(_))) {
            generator.finish();
        }
        core.depth.set(depth);
        core.line.set(line);
        result
    }

    /// `yield`: hands a value to whoever steps this generator; the value sent back is the result. `slots` are the
    /// variables of the generator.
    pub fn yield_value(&self, slots: &[Value], value: Value, delegate: Option<&Value>) -> R {
        let RequestSink::Generator(yielder) = &self.outlet else {
            // The parser lets `yield` stand in functions only, and those with one run as generators.
            return Err(self.raise(ExceptionKind::SystemError, "yield outside a generator"));
        };
        let seen = SuspendedFrame {
            slots: slots.to_vec(),
            delegate: delegate.cloned().unwrap_or_default(),
            line: self.core.line.get(),
        };
        match yielder.suspend(GeneratorOutput::Yield(value, seen)) {
            GeneratorInput::Send(value) => Ok(value),
            GeneratorInput::Throw(raised) => Err(raised),
            GeneratorInput::Resumed(_) => Err(Unwind::Stop),
        }
    }
}

/// What stepping a generator gives that is over.
fn step_finished(input: GeneratorInput) -> R<StepResult> {
    match input {
        GeneratorInput::Throw(raised) => Err(raised),
        GeneratorInput::Send(_) | GeneratorInput::Resumed(_) => {
            Ok(StepResult::Returned(Value::None))
        }
    }
}

impl Generator {
    /// A generator that is given up unwinds as a stopped thread does: its `finally` blocks run, bounded; it cannot
    /// wait.
    fn unwind(&self) {
        if !self.has_stack() {
            return;
        }
        if let GeneratorState::Suspended(coroutine) = self.state.replace(GeneratorState::Finished) {
            drop(self.suspended_frame.take());
            self.core.pending_finalizers.unwind(&self.core, coroutine);
        }
    }
}

/// What generators that were given up still have to do. Usually that is done at once; while memory is being freed on
/// behalf of a native that has its containers in its hands, no script code may run, so it waits for the next safepoint.
#[derive(Default)]
pub struct PendingFinalizers {
    held_back: Cell<bool>,
    waiting: RefCell<Vec<GeneratorCoroutine>>,
}

impl PendingFinalizers {
    /// From now on they wait (or, `false`, are done at once); what it was before.
    pub fn set_suspended(&self, on: bool) -> bool {
        self.held_back.replace(on)
    }

    /// Does what has waited.
    pub fn run_pending(&self, core: &InterpreterState) {
        while let Some(coroutine) = self.next() {
            self.unwind(core, coroutine);
        }
    }

    fn next(&self) -> Option<GeneratorCoroutine> {
        match self.held_back.get() {
            true => None,
            false => self.waiting.borrow_mut().pop(),
        }
    }

    fn unwind(&self, core: &InterpreterState, mut coroutine: GeneratorCoroutine) {
        if self.held_back.get() {
            return self.waiting.borrow_mut().push(coroutine);
        }
        assert_no_borrows();
        let saved = (
            task_memory::fuel(),
            core.stopping.get(),
            core.line.get(),
            core.depth.get(),
            core.native_depth.get(),
        );
        let depth = saved.3 + saved.4;
        core.stopping.set(match saved.1 {
            // A `finally` block may give up a generator with a `finally` block, and so on without end.
            _ if depth >= core.limits.call_depth => StopState::Abandoned,
            StopState::No => {
                task_memory::set_fuel(core.limits.drop_fuel);
                StopState::Unwinding
            }
            // One within another shares its fuel, so that all of them together are bounded.
            stopping => stopping,
        });
        core.depth.set(saved.3 + 1);
        let mut input = GeneratorInput::Throw(Unwind::Stop);
        loop {
            match coroutine.resume(input) {
                CoroutineResult::Return(_) => break,
                // A `yield` in a `finally` block: nobody takes the value, no more code runs.
                CoroutineResult::Yield(_) => core.stopping.set(StopState::Abandoned),
            }
            input = GeneratorInput::Throw(Unwind::Stop);
        }
        core.stacks
            .put_back(StackKind::Generator, coroutine.into_stack());
        // What a generator within a stopping thread has used is used; all else goes on as if nothing had happened.
        if saved.1 == StopState::No {
            task_memory::set_fuel(saved.0);
        }
        core.stopping.set(saved.1);
        core.line.set(saved.2);
        core.depth.set(saved.3);
        core.native_depth.set(saved.4);
    }
}

impl Drop for Generator {
    fn drop(&mut self) {
        if self.core.is_left.get() {
            // What lies on its stack stays as it is.
            return std::mem::forget(self.state.replace(GeneratorState::Finished));
        }
        self.unwind();
    }
}
