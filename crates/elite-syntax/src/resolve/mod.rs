//! From names to places, before anything runs: which names are locals, which are shared with inner functions
//! (cells), which are globals.
//!
//! Follows Python's rules: a name bound in a function is local unless declared otherwise; class bodies are skipped
//! when an inner function looks outwards; comprehensions have their own names. List, set and dict comprehensions run
//! in the frame of the function around them, so their names are slots there; generator expressions have a frame.

mod collect;
mod names;
mod parts;
mod storage;
mod unused;

use std::collections::{BTreeMap, BTreeSet};

use crate::ast::Module;
use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::DiagnosticList;
use crate::work_budget::{WORK_PER_DROP, WorkBudget};

pub use names::KnownNames;
pub(crate) use parts::{PlacedUnit, UnitAnalysis, merge_units};
pub(crate) use unused::READS_BY_NAME;
pub use unused::unused_names;

/// The embedder's names that a program binds somewhere; none where `import *` may bind any.
pub(crate) fn bound_natives(
    module: &Module,
    known: &KnownNames,
    budget: &WorkBudget<'_>,
) -> Option<BTreeSet<Box<str>>> {
    let scopes = collect::collect(module, budget);
    (!scopes.star_import).then(|| scopes.bound_natives(known).map(Into::into).collect())
}

/// Where a name lives, seen from one scope.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Storage {
    /// A slot of the frame.
    Local(u32),
    /// A slot of the frame that holds a cell, because inner functions share the variable.
    Cell(u32),
    /// A cell of an outer function, by its index in the closure.
    Free(u32),
    /// A global or a builtin.
    Global,
    /// A name bound in a class body: the slot, or the global while the slot is unbound.
    Class(u32),
}

/// What is needed to run the code of one frame: a function, a class body, a generator expression or the module.
#[derive(Clone, Debug, Default)]
pub struct FrameLayout {
    /// Name of each slot; parameters first, in the order of `Parameters::iter`.
    pub slot_names: Vec<Box<str>>,
    /// Slots that are made cells when the frame is entered.
    pub cells: Vec<u32>,
    /// Where the enclosing frame finds each cell of this frame's closure.
    pub closure: Vec<(Box<str>, Storage)>,
    /// The body contains `yield`.
    pub is_generator: bool,
    /// Class bodies: the slot with the cell for `__class__`, if a method needs it.
    pub class_cell: Option<u32>,
    /// Class bodies: how many of the leading slots are names of the class.
    pub class_names: u32,
}

/// The places of all names of one scope.
#[derive(Clone, Debug, Default)]
pub struct ScopeLayout {
    /// Place of each name used or bound in the scope.
    pub names: BTreeMap<Box<str>, Storage>,
    /// Only for scopes with a frame of their own.
    pub frame: Option<FrameLayout>,
    /// Inlined comprehensions: cells that are made anew each time the comprehension runs.
    pub fresh_cells: Vec<u32>,
    /// Inlined comprehensions: all slots of its names, cleared when it ends.
    pub slots: Vec<u32>,
}

impl FrameLayout {
    /// A frame of nothing.
    pub const NONE: Self = FrameLayout {
        slot_names: Vec::new(),
        cells: Vec::new(),
        closure: Vec::new(),
        is_generator: false,
        class_cell: None,
        class_names: 0,
    };
}

impl ScopeLayout {
    /// A scope without names.
    pub const NONE: Self = ScopeLayout {
        names: BTreeMap::new(),
        frame: None,
        fresh_cells: Vec::new(),
        slots: Vec::new(),
    };
}

/// The result for a whole program.
#[derive(Debug)]
pub struct Resolution {
    /// By `ScopeId`; None for scopes the parser gave up.
    pub scopes: Vec<Option<ScopeLayout>>,
    /// Names declared `global` anywhere, in the order of the text, once each: the variable monitor shows them.
    pub declared_globals: Vec<Box<str>>,
    /// Names the top level binds.
    pub bindings: Vec<Box<str>>,
    /// The first scope errors, and undefined names as warnings.
    pub diagnostics: Vec<Diagnostic>,
}

impl Resolution {
    /// Drops the tables, with pauses.
    pub fn release(self, budget: &WorkBudget<'_>) {
        for scope in self.scopes.into_iter().flatten() {
            budget.charge(WORK_PER_DROP);
            budget.drop_each(scope.names);
            if let Some(frame) = scope.frame {
                budget.drop_each(frame.slot_names);
                budget.drop_each(frame.closure);
            }
        }
        budget.drop_each(self.declared_globals);
        budget.drop_each(self.bindings);
    }
}

/// Work for one mention of a name.
const WORK_PER_MENTION: usize = 600;

/// Resolves all names of a program. `known` are the names the embedder provides beside Python's builtins.
pub fn resolve(module: &Module, known: &KnownNames) -> Resolution {
    resolve_within(module, known, &WorkBudget::with_limit(usize::MAX))
}

/// Resolves all names of a program with pauses. The result means nothing if the work was given up in one.
pub fn resolve_within(module: &Module, known: &KnownNames, budget: &WorkBudget<'_>) -> Resolution {
    let mut scopes = collect::collect(module, budget);
    let mut diagnostics: DiagnosticList = std::mem::take(&mut scopes.diagnostics);
    let declared_globals = scopes.declared_globals();
    let bindings = scopes.module_bindings();
    let places = storage::assign(&mut scopes, &mut diagnostics);
    names::report_undefined(&scopes, known, &mut diagnostics);
    scopes.release();
    Resolution {
        scopes: places,
        declared_globals,
        bindings,
        diagnostics: diagnostics.into_vec(),
    }
}
