//! Executable code of one function, class body, generator or module.

use std::cell::{Cell, RefCell};
use std::collections::{BTreeMap, HashMap};
use std::rc::{Rc, Weak};
use std::sync::Arc;

use elite_syntax::{SourceFile, Span, drop_tree};

use super::coroutine::LEVEL;
use super::expr::enter::EntryPoints;
use super::steps::GeneratorStep;
use super::stmt::handle::ProtectedRange;
use super::words::PairOf;
use super::{BoxExpr, DynStmt, Evaluator, Flow, Frame, StmtNode};
use crate::limits::deferred_drop::{self, NodeList};
use crate::value::by_symbol::SymbolSet;
use crate::value::module::Namespace;
use crate::value::{CellVar, Dict, R, ScriptCell, Symbol, Unwind, Value};

/// How calling a function with this code goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CodeKind {
    /// Runs to its end.
    Plain,
    /// Makes a generator.
    Generator,
}

/// The symbols in the code of one text. They stay while any of that code does.
#[derive(Default)]
pub struct SourceSymbols {
    all: RefCell<Vec<Symbol>>,
}

impl SourceSymbols {
    /// Notes one.
    pub fn note(&self, name: Symbol) {
        self.all.borrow_mut().push(name);
    }

    /// Adds up to `count` of them to a set, from number `from` on; whether there are more.
    pub fn add_some_to(&self, set: &mut SymbolSet, from: usize, count: usize) -> bool {
        let all = self.all.borrow();
        set.extend(all.iter().skip(from).take(count).copied());
        all.len() > from + count
    }
}

/// What the body of code in an evaluated text refers to: variables of the text, which may hold functions with that very
/// code. Each is referred to once by the body and once here.
#[derive(Default)]
pub struct CodeRefs {
    /// Variables of a namespace that is the text's own; empty for all other code.
    pub cells: RefCell<Vec<Rc<CellVar>>>,
    /// Code within this one.
    pub codes: Vec<Rc<Code>>,
    /// The list is known to be right.
    is_exact: Cell<bool>,
    /// The dictionary that the text had its global variables from: what it evaluates later sees them there.
    globals_dict: ScriptCell<Option<Rc<Dict>>>,
}

impl CodeRefs {
    /// Whether the search for cycles learns anything here.
    pub fn is_traced(&self) -> bool {
        self.is_exact.get() || self.globals_dict.borrow().is_some()
    }

    /// Runs `each` on the references there are, those of the body included.
    pub fn visit(&self, each: &mut dyn FnMut(&Value)) {
        if let Some(home) = self.home() {
            each(&Value::Dict(home));
        }
        if !self.is_exact.get() {
            return;
        }
        for cell in &*self.cells.borrow() {
            let cell = Value::Cell(cell.clone());
            each(&cell);
            each(&cell);
        }
        for code in &self.codes {
            let code = Value::Code(code.clone());
            each(&code);
            each(&code);
        }
    }

    /// Compares the list with what a new text really refers to; `own` are the variables of its new namespace. If parts
    /// of the body were made in vain, the list is no good, and the search for cycles leaves such variables alone.
    /// `before` are the references there were to each of them already, `is_shown` says that new ones are in a
    /// dictionary, too. `charge` is called for each piece of work.
    pub fn check(
        &self,
        own: Vec<Rc<CellVar>>,
        before: &HashMap<*const CellVar, usize>,
        is_shown: bool,
        worked: &mut dyn FnMut() -> R<()>,
    ) -> R<()> {
        let mut listed = BTreeMap::new();
        self.each_cell(&mut |cell| {
            *listed.entry(Rc::as_ptr(cell)).or_insert(0) += 1;
            worked()
        })?;
        // The namespace has one reference, `own` another one.
        let mut is_right = true;
        for cell in &own {
            worked()?;
            let entries = listed.get(&Rc::as_ptr(cell)).copied().unwrap_or(0);
            let others = before
                .get(&Rc::as_ptr(cell))
                .copied()
                .unwrap_or(usize::from(is_shown));
            is_right &= Rc::strong_count(cell) == others + 2 + 2 * entries;
        }
        match is_right && self.codes_are_right(worked)? {
            true => self.trust(worked),
            false => self.forget(worked),
        }
    }

    /// Runs `each` on this and on what all code within refers to, however deep it lies.
    fn walk(&self, each: &mut dyn FnMut(&CodeRefs) -> R<()>) -> R<()> {
        let mut left = vec![self];
        while let Some(refers) = left.pop() {
            each(refers)?;
            left.extend(refers.codes.iter().map(|code| &code.refs));
        }
        Ok(())
    }

    fn codes_are_right(&self, worked: &mut dyn FnMut() -> R<()>) -> R<bool> {
        let mut are_right = true;
        self.walk(&mut |refers| {
            for code in &refers.codes {
                worked()?;
                are_right &= Rc::strong_count(code) == 2;
            }
            Ok(())
        })?;
        Ok(are_right)
    }

    fn trust(&self, worked: &mut dyn FnMut() -> R<()>) -> R<()> {
        self.walk(&mut |refers| {
            refers.is_exact.set(true);
            worked()
        })
    }

    fn each_cell(&self, each: &mut dyn FnMut(&Rc<CellVar>) -> R<()>) -> R<()> {
        self.walk(&mut |refers| refers.cells.borrow().iter().try_for_each(&mut *each))
    }

    /// Empties the list, that of all code within included.
    pub fn forget(&self, worked: &mut dyn FnMut() -> R<()>) -> R<()> {
        self.walk(&mut |refers| {
            refers.is_exact.set(false);
            refers.cells.take();
            worked()
        })
    }

    /// The dictionary that the text had its global variables from.
    pub fn home(&self) -> Option<Rc<Dict>> {
        self.globals_dict.get()
    }

    /// Notes it, for all code within, too.
    pub fn set_home(&self, home: &Rc<Dict>, worked: &mut dyn FnMut() -> R<()>) -> R<()> {
        self.walk(&mut |refers| {
            refers.globals_dict.put(Some(home.clone()));
            worked()
        })
    }
}

impl Drop for CodeRefs {
    fn drop(&mut self) {
        deferred_drop::drop_or_defer_nodes(&mut self.codes);
    }
}

/// The code of one frame.
pub struct Code {
    /// `__name__`.
    pub name: Rc<str>,
    /// `__qualname__`, which messages use.
    pub qualname: Rc<str>,
    /// Documentation string.
    pub doc: Option<Rc<str>>,
    /// The text it was made from.
    pub file: Arc<SourceFile>,
    /// Where in the text.
    pub span: Span,
    /// The parameters of the code.
    pub params: Params,
    /// Number of slots.
    pub slots: usize,
    /// Name of each slot.
    pub slot_names: Box<[Symbol]>,
    /// Name of each cell of the closure.
    pub free_names: Box<[Symbol]>,
    /// Slots that become cells on entry.
    pub cells: Box<[u32]>,
    /// Plain function or generator.
    pub kind: CodeKind,
    /// What runs.
    pub body: Body,
    /// How calls enter it, and natives with values.
    pub entries: EntryPoints,
    /// What the body refers to beyond itself.
    pub refs: CodeRefs,
    /// The names in it and in the rest of the text.
    pub names: Rc<SourceSymbols>,
    /// The global variables it refers to.
    pub module: Option<Weak<Namespace>>,
    /// Native stack that evaluating the body may take between two checks.
    pub stack_bytes: usize,
}

/// Native stack of evaluation from which on a body is too deep to be dropped where it lies.
const DEEP: usize = 24 * LEVEL;

thread_local! {
    /// Code within code is being dropped.
    static DROPS: Cell<bool> = const { Cell::new(false) };
    /// What such code had within it, and is still to be dropped.
    static WITHIN: RefCell<Vec<Vec<Rc<Code>>>> = const { RefCell::new(Vec::new()) };
}

impl Drop for Code {
    /// Code in code in code is taken apart one after the other, and what is deep in itself on a deep stack.
    fn drop(&mut self) {
        // The body refers to them as well, and does not end them.
        let codes = std::mem::take(&mut self.refs.codes);
        let body = std::mem::replace(&mut self.body, Body::Steps(NodeList::default()));
        match self.stack_bytes > DEEP {
            true => drop_tree(body),
            false => drop(body),
        }
        if !codes.is_empty() {
            drop_within(codes);
        }
    }
}

fn drop_within(mut codes: Vec<Rc<Code>>) {
    /// Takes the mark away, also when a drop unwinds.
    struct CodeDropGuard;
    impl Drop for CodeDropGuard {
        fn drop(&mut self) {
            let _ = DROPS.try_with(|drops| drops.set(false));
        }
    }
    if DROPS.try_with(|drops| drops.replace(true)) == Ok(true) {
        return WITHIN.with(|within| within.borrow_mut().push(codes));
    }
    let _outermost = CodeDropGuard;
    loop {
        deferred_drop::drop_or_defer_nodes(&mut codes);
        drop(codes);
        match WITHIN.try_with(|within| within.borrow_mut().pop()) {
            Ok(Some(next)) => codes = next,
            _ => return,
        }
    }
}

/// The parameters of a function. They take the first slots: positional ones, keyword-only ones, `*`, `**`.
#[derive(Clone, Debug, Default)]
pub struct Params {
    /// Names of positional and keyword-only parameters.
    pub names: Box<[Symbol]>,
    /// How many of them cannot be given by name.
    pub positional_only: usize,
    /// How many can be given by position.
    pub positional: usize,
    /// The slot of `*args`.
    pub star: Option<usize>,
    /// The slot of `**kwargs`.
    pub double_star: Option<usize>,
}

impl Params {
    /// Only positional parameters: calls by position need no binding.
    #[inline]
    pub fn is_simple(&self) -> bool {
        self.names.len() == self.positional && self.star.is_none() && self.double_star.is_none()
    }

    /// Positional parameters and `*args`.
    pub fn is_starred(&self) -> bool {
        self.names.len() == self.positional && self.star.is_some() && self.double_star.is_none()
    }

    /// The slot of the parameter that can be given by this name.
    #[inline]
    pub fn by_name(&self, name: Symbol) -> Option<usize> {
        let by_name = &self.names[self.positional_only..];
        let index = by_name.iter().position(|param| *param == name)?;
        Some(self.positional_only + index)
    }
}

/// What a frame runs.
pub enum Body {
    /// Statements.
    Block(Block),
    /// A single expression (lambdas).
    Expression(BoxExpr),
    /// A single `return` of an expression, with its line.
    Return(u32, BoxExpr),
    /// The steps of a generator.
    Steps(NodeList<GeneratorStep>),
}

impl Body {
    /// Runs it to its end.
    #[inline]
    pub fn run(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> R {
        match self {
            Body::Block(block) => match block.exec(ev, f) {
                Flow::Return(value) => Ok(value),
                Flow::Raise(raised) => Err(raised),
                // The parser lets no `break` or `continue` out of a loop.
                Flow::Next | Flow::Break | Flow::Continue => Ok(Value::None),
            },
            Body::Expression(expr) => expr.eval(ev, f),
            Body::Return(line, expr) => {
                ev.core.line.set(*line);
                expr.eval(ev, f)
            }
            // Only generators have steps; they stand at them and never run to the end at once.
            Body::Steps(_) => Ok(Value::None),
        }
    }

    /// The steps of a generator that has no stack of its own.
    #[inline]
    pub fn steps(&self) -> Option<&[GeneratorStep]> {
        match self {
            Body::Steps(steps) => Some(steps),
            Body::Block(_) | Body::Expression(_) | Body::Return(..) => None,
        }
    }
}

/// Statements of a block from which on each counts as work: there may be no loop and no call among them, so no
/// safepoint.
const LONG: usize = 256;
/// What one of them counts.
const STATEMENT: usize = 128;

/// Statements one after the other, with their lines. Those of a `try` stand among the others, its clauses beside them:
/// to enter and to leave it takes nothing.
#[derive(Default)]
pub struct Block {
    statements: NodeList<LineStmt>,
    /// By the end of what they protect, inner ones before those around them.
    guards: NodeList<ProtectedRange>,
}

/// A statement and its line.
pub struct LineStmt {
    number: u32,
    statement: Box<dyn DynStmt>,
}

impl LineStmt {
    /// Executes it.
    #[inline(always)]
    pub fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        ev.core.line.set(self.number);
        self.statement.exec(ev, f)
    }
}

impl Block {
    /// A block of these statements, each with its line, and of what protects some of them, by where that ends, inner
    /// ones first.
    pub fn new(statements: Vec<(u32, Box<dyn DynStmt>)>, guards: Vec<ProtectedRange>) -> Self {
        let lines = statements
            .into_iter()
            .map(|(number, statement)| LineStmt { number, statement });
        Block {
            statements: lines.collect(),
            guards: guards.into(),
        }
    }

    /// Whether there is nothing in it.
    pub fn is_empty(&self) -> bool {
        self.statements.is_empty()
    }

    /// Executes the statements up to one that leaves the block.
    #[inline]
    pub fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        if self.statements.len() > LONG {
            return self.exec_from(0, ev, f);
        }
        let mut lines = self.statements.iter();
        while let Some(line) = lines.next() {
            match line.exec(ev, f) {
                Flow::Next => {}
                flow if self.guards.is_empty() => return flow,
                flow => {
                    let at = self.statements.len() - lines.len() - 1;
                    return self.exec_after(at, PairOf::pack(flow), ev, f).whole();
                }
            }
        }
        Flow::Next
    }

    /// What follows the end of statement `at`, which is not to go on with the next one.
    #[inline(never)]
    fn exec_after(
        &self,
        at: usize,
        flow: PairOf<Flow>,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
    ) -> PairOf<Flow> {
        PairOf::pack(match self.handle(at, flow.whole(), ev, f) {
            Ok(next) => self.exec_from(next, ev, f),
            Err(flow) => flow,
        })
    }

    #[inline(never)]
    fn exec_from(&self, mut at: usize, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        let is_long = self.statements.len() > LONG;
        while let Some(line) = self.statements.get(at) {
            let worked = match is_long {
                true => ev.charge(STATEMENT),
                false => Ok(()),
            };
            let flow = match worked {
                Ok(()) => line.exec(ev, f),
                Err(raised) => Flow::Raise(raised),
            };
            at = match flow {
                Flow::Next => at + 1,
                flow => match self.handle(at, flow, ev, f) {
                    Ok(next) => next,
                    Err(flow) => return flow,
                },
            };
        }
        Flow::Next
    }

    /// Where the block goes on if what statement `at` raised is handled in it; else how the block ends.
    fn handle(
        &self,
        at: usize,
        mut flow: Flow,
        ev: &Evaluator<'_>,
        f: &mut Frame<'_>,
    ) -> Result<usize, Flow> {
        let first = self.guards.partition_point(|guard| guard.body.end <= at);
        for guard in &self.guards[first..] {
            if !guard.body.contains(&at) {
                continue;
            }
            let Flow::Raise(Unwind::Exception(exception)) = flow else {
                break;
            };
            flow = match guard.handle(exception, ev, f) {
                Flow::Next => return Ok(guard.after),
                other => other,
            };
        }
        Err(flow)
    }
}

/// A block as a statement.
impl StmtNode for Block {
    #[inline(always)]
    fn exec(&self, ev: &Evaluator<'_>, f: &mut Frame<'_>) -> Flow {
        Block::exec(self, ev, f)
    }
}
