//! Statements that run in the place of a native that waits: interpreter mode (manual chapter 2).
//!
//! A statement is compiled without knowing where it will run, so that a port can answer at once, and run by the native
//! as if it stood in the text at the native's call. It reads and changes the local variables of the calling function,
//! the variables that function shares with others, and existing globals. It cannot make globals: a name that is
//! neither local nor global nor builtin becomes a variable of the statements themselves, which lives until
//! [`NativeCall::clear_statements`] (manual 2.1: new globals cannot be defined, existing ones can be used and changed;
//! injected functions go with `clear_interpreter`). A name that a statement declares `global` means the global
//! throughout that statement.
//!
//! Local variables that no inner function of the program shares lie in slots, where functions of a statement cannot
//! reach them. While statements run they are mirrored in cells, one for each variable and function text, and written
//! back after every statement.

use std::collections::HashMap;
use std::rc::Rc;

use elite_syntax::{Statement, WorkBudget, with_deep_stack};
use messages::text;

use crate::errors::{ExceptionKind, ScriptError};
use crate::eval::code::Code;
use crate::eval::{Evaluator, Frame, InterpreterState};
use crate::native::NativeCall;
use crate::value::module::Namespace;
use crate::value::{CellVar, R, Symbol, Unwind, Value};

/// What statements have defined, kept by the interpreter until it is cleared.
#[derive(Default)]
pub struct InjectedNames {
    /// Variables and functions of the statements themselves.
    names: Rc<Namespace>,
    /// Mirrors of local variables, by the function text they belong to.
    mirrors: Vec<LocalMirrors>,
}

/// The cells that stand for local variables of one function text.
type LocalMirrors = (Rc<Code>, HashMap<Symbol, Rc<CellVar>>);

impl InjectedNames {
    /// Gives everything up.
    pub fn dismantle(&self) {
        self.names.dismantle();
        let cells = self.mirrors.iter().flat_map(|(_, cells)| cells.values());
        for cell in cells {
            drop(cell.take());
        }
    }

    fn mirror(&mut self, code: &Rc<Code>, name: Symbol) -> Rc<CellVar> {
        let index = match self.mirrors.iter().position(|(of, _)| Rc::ptr_eq(of, code)) {
            Some(index) => index,
            None => {
                self.mirrors.push((code.clone(), HashMap::new()));
                self.mirrors.len() - 1
            }
        };
        self.mirrors[index].1.entry(name).or_default().clone()
    }
}

impl NativeCall<'_> {
    /// Runs a statement in the scope of the function that called this native. Natives that the statement calls may
    /// wait, and a stop of the thread comes through as `Unwind::CancelFlag`, which has to be passed on. Any other error
    /// is the embedder's to pass on or to report with [`NativeCall::report`]; the thread can run further statements.
    ///
    /// # Errors
    /// What the statement raises; `NameError` if it declares a name `global` that is not a global of the program.
    pub fn run_statement(&mut self, statement: &Statement) -> R<()> {
        let ev = self.ev;
        let scope = StatementScope::open(ev, statement, self.caller.as_ref())?;
        let code = with_deep_stack(|| {
            let (module, resolution) = (statement.module(), statement.resolution());
            crate::lower::module(
                &ev.core,
                &scope.namespace,
                statement.file(),
                module,
                resolution,
                &WorkBudget::with_limit(usize::MAX),
            )
        });
        let result = ev.run_text(&code, &scope.namespace, None);
        if let Some(frame) = &mut self.caller {
            scope.write_back(frame);
        }
        result.map(drop)
    }

    /// Forgets all functions and variables that statements have defined.
    pub fn clear_statements(&self) {
        let fresh = InjectedNames {
            names: self.ev.core.new_namespace(None),
            mirrors: Vec::new(),
        };
        let old = self.ev.core.injected.replace(fresh);
        old.dismantle();
    }

    /// The report of an exception, as for one that ends a thread; None for the stop of the thread.
    pub fn report(&self, raised: &Unwind) -> Option<ScriptError> {
        match raised {
            Unwind::Exception(exception) => Some(self.ev.report(exception)),
            Unwind::Stop => None,
        }
    }
}

/// The variables one statement can reach.
struct StatementScope {
    namespace: Rc<Namespace>,
    /// Slots of the calling function that are mirrored in cells while the statement runs.
    mirrored: Vec<(usize, Rc<CellVar>)>,
}

impl StatementScope {
    fn open(
        ev: &Evaluator<'_>,
        statement: &Statement,
        frame: Option<&Frame<'_>>,
    ) -> R<StatementScope> {
        let core = &ev.core;
        let namespace = core.new_namespace(Some(core.globals.clone()));
        for name in statement.declared_globals() {
            let symbol = core.symbols.intern_used(name);
            if !core.globals.has_name(symbol) {
                let text = text!(
                    "name '{name}' is not a global of the program, and a statement cannot define new ones",
                    "名称 '{name}' 不是程序的全局变量，语句不能定义新的全局变量"
                );
                return Err(ev.raise(ExceptionKind::NameError, text));
            }
            namespace.bind_cell(symbol, core.globals.cell(symbol));
        }
        let mut scope = StatementScope {
            namespace,
            mirrored: Vec::new(),
        };
        let frame = frame.filter(|frame| !ev.is_module(frame));
        if let Some(frame) = frame {
            scope.add_locals(core, frame);
        }
        for name in statement.outer_names() {
            let symbol = core.symbols.intern_used(name);
            if !scope.namespace.has_name(symbol) && !is_global(core, symbol) {
                let cell = core.injected.borrow().names.cell(symbol);
                scope.namespace.bind_cell(symbol, cell);
            }
        }
        if frame.is_none() {
            // The locals of the top level are the globals: `locals()` and `eval` look for them here.
            for (name, _) in core.globals.entries() {
                if !scope.namespace.has_name(name) {
                    scope.namespace.bind_cell(name, core.globals.cell(name));
                }
            }
        }
        Ok(scope)
    }

    fn add_locals(&mut self, core: &InterpreterState, frame: &Frame<'_>) {
        let code = &frame.function.code;
        for (slot, name) in code.slot_names.iter().enumerate() {
            // Names of comprehensions come after the function's own and may repeat them.
            if self.namespace.has_name(*name) {
                continue;
            }
            let cell = match &frame.slots[slot] {
                Value::Cell(cell) => cell.clone(),
                value => {
                    let cell = core.injected.borrow_mut().mirror(code, *name);
                    drop(cell.replace(value.clone()));
                    self.mirrored.push((slot, cell.clone()));
                    cell
                }
            };
            self.namespace.bind_cell(*name, cell);
        }
        for (name, cell) in code.free_names.iter().zip(&frame.function.closure) {
            if !self.namespace.has_name(*name) {
                self.namespace.bind_cell(*name, cell.clone());
            }
        }
    }

    fn write_back(&self, frame: &mut Frame<'_>) {
        for (slot, cell) in &self.mirrored {
            let value = cell.value.borrow().clone();
            drop(std::mem::replace(&mut frame.slots[*slot], value));
        }
    }
}

/// Whether a name means a global or builtin for statements: nothing they have defined hides it.
fn is_global(core: &InterpreterState, name: Symbol) -> bool {
    core.injected.borrow().names.get(name).is_none() && core.globals.get(name).is_some()
}
