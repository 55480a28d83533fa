//! A program that stands still: its calls, their variables, and what can be changed in them.

use std::rc::Rc;

use messages::Localized;

use super::{CallRecord, Debugger, StatementSite};
use crate::eval::InterpreterState;
use crate::host::ThreadId;
use crate::value::{Function, ScriptCell, Value};

/// The thread that stands in a statement.
pub(super) struct TopFrame<'h> {
    pub(super) thread: ThreadId,
    pub(super) depth: u32,
    pub(super) slots: ScriptCell<&'h mut [Value]>,
}

/// A program that stands still, for as long as this is there.
pub struct PausedProgram<'h> {
    pub(super) core: &'h Rc<InterpreterState>,
    pub(super) debugger: &'h Debugger,
    pub(super) top: Option<TopFrame<'h>>,
}

/// A call under way, as people see it.
#[derive(Clone, Debug)]
pub struct StackFrame {
    /// The function, `<module>` for the program itself.
    pub function: Rc<str>,
    /// The statement it stands in.
    pub site: Rc<StatementSite>,
    /// The count of that statement.
    pub statement_number: u64,
    /// The count of the statement of this call before it, 0 if there was none.
    pub previous_number: u64,
    /// The count of its first statement.
    pub first: u64,
    /// Calls within calls.
    pub depth: u32,
}

/// The reason for which a variable was not set.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error, Localized)]
#[non_exhaustive]
pub enum SetVariableError {
    /// There is no variable of this name.
    #[error("there is no variable {0}")]
    #[zh("没有变量 {0}")]
    Unknown(String),
    /// The variable belongs to a call that waits for another one.
    #[error(
        "{0} is a local variable of a call that waits for another one: \
         it can be set once the program is back in that call"
    )]
    #[zh("{0} 是等待另一个调用的调用中的局部变量：程序回到该调用后才能设置")]
    OfCaller(String),
}

impl<'h> PausedProgram<'h> {
    /// A program of which no thread runs.
    pub(crate) fn without_thread(core: &'h Rc<InterpreterState>, debugger: &'h Debugger) -> Self {
        PausedProgram {
            core,
            debugger,
            top: None,
        }
    }

    /// Statements so far.
    pub fn statement_count(&self) -> u64 {
        self.debugger.statement_count.get()
    }

    /// Simulated time, s, as the program sees it.
    pub fn time(&self) -> f64 {
        self.core.host.monotonic()
    }

    /// The number of the latest node of the pendant's task that the running thread has passed.
    pub fn node(&self) -> Option<elite_syntax::TaskNode> {
        self.core.nodes.passed()
    }

    /// The calls of a thread, innermost first.
    pub fn calls(&self, thread: ThreadId) -> Vec<StackFrame> {
        let call = |level: &CallRecord| StackFrame {
            function: level.function.qualname(),
            site: level.site.clone(),
            statement_number: level.tick,
            previous_number: level.before,
            first: level.first,
            depth: level.depth,
        };
        self.with_levels(thread, |levels| levels.iter().rev().map(call).collect())
    }

    /// Runs `look` on the calls of a thread that are still under way.
    fn with_levels<T>(&self, thread: ThreadId, look: impl FnOnce(&[CallRecord]) -> T) -> T {
        let traces = self.debugger.traces.borrow();
        let Some(trace) = traces.iter().find(|trace| trace.thread == thread.0) else {
            return look(&[]);
        };
        let depth = match &self.top {
            Some(top) if top.thread == thread => top.depth,
            _ => trace.depth,
        };
        let count = trace.levels.partition_point(|level| level.depth <= depth);
        look(&trace.levels[..count])
    }

    /// Whether a call is the one that is about to execute a statement, whose variables lie open.
    fn is_top(&self, thread: ThreadId, index: usize) -> bool {
        index == 0 && self.top.as_ref().is_some_and(|top| top.thread == thread)
    }

    /// The function of a call and its variables as they lie in its slots; `index` counts from the innermost call.
    pub(super) fn frame(
        &self,
        thread: ThreadId,
        index: usize,
    ) -> Option<(Rc<Function>, Vec<Value>)> {
        let (function, values) = self.with_levels(thread, |levels| {
            let level = levels.iter().rev().nth(index)?;
            Some((level.function.clone(), level.values.clone()))
        })?;
        match &self.top {
            Some(top) if self.is_top(thread, index) => {
                Some((function, top.slots.borrow().to_vec()))
            }
            _ => Some((function, values)),
        }
    }

    /// Whether a call is the program itself, whose variables are the globals.
    pub(super) fn is_module(function: &Function) -> bool {
        &*function.code.name == "<module>"
    }

    /// The local variables of a call, by name, innermost call first.
    pub fn locals(&self, thread: ThreadId, index: usize) -> Vec<(String, Value)> {
        let Some((function, mut slots)) = self.frame(thread, index) else {
            return Vec::new();
        };
        if Self::is_module(&function) {
            return self.globals();
        }
        self.variables(&function, &mut slots)
            .into_iter()
            .map(|(name, value)| (self.core.symbols.name(name).to_string(), value))
            .collect()
    }

    pub(super) fn variables(
        &self,
        function: &Rc<Function>,
        slots: &mut [Value],
    ) -> Vec<(crate::value::Symbol, Value)> {
        let code = &function.code;
        let own = code.slot_names.iter().copied().zip(slots.iter().cloned());
        let free = code.free_names.iter().copied().zip(&function.closure);
        let free = free.map(|(name, cell)| (name, cell.value.borrow().clone()));
        let opened = |(name, value): (_, Value)| match value {
            Value::Cell(cell) => (name, cell.value.borrow().clone()),
            other => (name, other),
        };
        own.map(opened)
            .chain(free)
            .filter(|(_, value)| !value.is_unbound())
            .collect()
    }

    /// The global variables of the program.
    pub fn globals(&self) -> Vec<(String, Value)> {
        let entries = self.core.globals.entries().into_iter();
        let named = entries.map(|(name, value)| (self.core.symbols.name(name).to_string(), value));
        let is_own = |name: &str| !(name.starts_with("__") && name.ends_with("__"));
        named.filter(|(name, _)| is_own(name)).collect()
    }

    /// Whether the local variables of a call are the globals.
    pub fn has_globals_only(&self, thread: ThreadId, index: usize) -> bool {
        self.with_levels(thread, |levels| {
            let level = levels.iter().rev().nth(index);
            level.is_none_or(|level| Self::is_module(&level.function))
        })
    }

    /// Sets a global variable.
    ///
    /// # Errors
    /// There is none of this name.
    pub fn set_global(&self, name: &str, value: Value) -> Result<(), SetVariableError> {
        let core = self.core;
        let symbol = core.symbols.find(name);
        let known = symbol.filter(|symbol| core.globals.get(*symbol).is_some());
        let symbol = known.ok_or_else(|| SetVariableError::Unknown(name.to_owned()))?;
        core.globals.set(symbol, value);
        Ok(())
    }

    /// Sets a variable of a call.
    ///
    /// # Errors
    /// [`SetVariableError`]
    pub fn set_local(
        &self,
        thread: ThreadId,
        index: usize,
        name: &str,
        value: Value,
    ) -> Result<(), SetVariableError> {
        let unknown = || SetVariableError::Unknown(name.to_owned());
        let (function, slots) = self.frame(thread, index).ok_or_else(unknown)?;
        if Self::is_module(&function) {
            return self.set_global(name, value);
        }
        let symbol = self.core.symbols.find(name).ok_or_else(unknown)?;
        let code = &function.code;
        if let Some(place) = code.free_names.iter().position(|free| *free == symbol) {
            let cell = function.closure.get(place).ok_or_else(unknown)?;
            drop(cell.replace(value));
            return Ok(());
        }
        let slot = code.slot_names.iter().position(|own| *own == symbol);
        let slot = slot.ok_or_else(unknown)?;
        if let Some(Value::Cell(cell)) = slots.get(slot) {
            drop(cell.replace(value));
            return Ok(());
        }
        match &self.top {
            Some(top) if self.is_top(thread, index) => {
                let left = top.slots.with_mut(|own| match own.get_mut(slot) {
                    Some(place) => Ok(std::mem::replace(place, value)),
                    None => Err(value),
                });
                drop(slots);
                left.map(drop).map_err(|_| unknown())
            }
            _ => Err(SetVariableError::OfCaller(name.to_owned())),
        }
    }
}
