//! From the resolved tree to executable nodes, for one interpreter: names become slots and cells, the common shapes of
//! expressions get nodes of their own.

mod define;
mod expr;
mod generator;
mod guard;
mod percent;
mod stmt;
mod target;
mod watch;

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

use self::guard::BlockBuilder;
use elite_syntax::ast::{self, Constant, DirectiveAnchor, NodeDirective, ScopeId};
use elite_syntax::resolve::{FrameLayout, Resolution, ScopeLayout, Storage};
use elite_syntax::{SourceFile, Span, WorkBudget};

use crate::debug::{Debugger, StatementSite};
use crate::eval::InterpreterState;
use crate::eval::code::{Body, Code, CodeKind, CodeRefs, Params, SourceSymbols};
use crate::eval::coroutine::{LEVEL, RESERVE};
use crate::eval::count::{CoverageCondition, CoverageCounters, CoverageMark};
use crate::eval::expr::enter::EntryPoints;
use crate::eval::node::{EnterTaskNode, EnterTaskNodeThen};
use crate::eval::{BoxExpr, DynStmt};
use crate::value::module::Namespace;
use crate::value::{Bytes, CellVar, Symbol, Value};

/// Work for one node, and for a name in one.
const WORK_PER_NODE: usize = 128;
const WORK_PER_NAME: usize = 256;
/// Nodes of an expression that may be dropped at once.
const ISOLATE_MIN: usize = 2048;

/// Makes the code of a whole module, which means nothing if the work is given up in a pause.
pub fn module(
    core: &Rc<InterpreterState>,
    namespace: &Rc<Namespace>,
    file: &Arc<SourceFile>,
    module: &ast::Module,
    resolution: &Resolution,
    budget: &WorkBudget<'_>,
) -> Rc<Code> {
    Lower::new(core, namespace, file, resolution, budget).lower_module(module)
}

/// Makes the code of a program, with marks where its lines are counted.
pub fn program(
    core: &Rc<InterpreterState>,
    namespace: &Rc<Namespace>,
    file: &Arc<SourceFile>,
    module: &ast::Module,
    resolution: &Resolution,
    budget: &WorkBudget<'_>,
) -> Rc<Code> {
    let mut lower = Lower::new(core, namespace, file, resolution, budget);
    lower.counters.clone_from(&core.counters.borrow());
    lower.debugger.clone_from(&core.debugger.borrow());
    lower.lower_module(module)
}

/// Makes the code of a single expression, as `eval` runs it.
pub fn expression(
    core: &Rc<InterpreterState>,
    namespace: &Rc<Namespace>,
    file: &Arc<SourceFile>,
    expr: &ast::Expr,
    resolution: &Resolution,
    budget: &WorkBudget<'_>,
) -> Rc<Code> {
    let mut lower = Lower::new(core, namespace, file, resolution, budget);
    let body = lower.expr(expr);
    lower.module_code(Body::Expression(body), expr.span)
}

struct Lower<'l> {
    core: &'l Rc<InterpreterState>,
    namespace: &'l Rc<Namespace>,
    file: &'l Arc<SourceFile>,
    resolution: &'l Resolution,
    budget: &'l WorkBudget<'l>,
    /// The scope names are looked up in, and the one that has the frame.
    scope: ScopeId,
    frame_scope: ScopeId,
    /// `__qualname__` of the function or class around, with its separator.
    prefix: String,
    /// Nesting of the node being made, and the deepest of this frame.
    depth: usize,
    deepest: usize,
    /// Nodes made since the last list of nodes that can be dropped bit by bit.
    nodes_since_list: usize,
    /// The directives by when they are passed.
    node_directives: BTreeMap<DirectiveAnchor, Vec<EnterTaskNode>>,
    /// The symbols it has used.
    names: Rc<SourceSymbols>,
    /// What the frame refers to beyond itself.
    refers: RefCell<CodeRefs>,
    /// Where the lines are counted, if they are.
    counters: Option<Rc<CoverageCounters>>,
    /// Who is told of statements, if somebody is.
    debugger: Option<Rc<Debugger>>,
    /// The next statement is the first of its frame.
    is_first: bool,
    /// The statement that is being made, where it is watched.
    loop_site: Option<Rc<StatementSite>>,
}

/// What a frame takes and refers to.
struct FrameInfo {
    /// Native stack.
    stack_bytes: usize,
    refers: CodeRefs,
}

/// A statement with its line.
type NumberedStmt = (u32, Box<dyn DynStmt>);

/// The nodes of a text in the table of the interpreter.
fn passes(
    core: &InterpreterState,
    nodes: &[NodeDirective],
    budget: &WorkBudget<'_>,
) -> BTreeMap<DirectiveAnchor, Vec<EnterTaskNode>> {
    let mut passes: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for mark in nodes {
        budget.charge(2 * WORK_PER_NAME);
        let node = core.nodes.intern(mark.number, &mark.label);
        let after = mark.after;
        passes
            .entry(mark.place)
            .or_default()
            .push(EnterTaskNode { node, after });
    }
    passes
}

impl<'l> Lower<'l> {
    fn new(
        core: &'l Rc<InterpreterState>,
        namespace: &'l Rc<Namespace>,
        file: &'l Arc<SourceFile>,
        resolution: &'l Resolution,
        budget: &'l WorkBudget<'l>,
    ) -> Self {
        Lower {
            core,
            namespace,
            file,
            resolution,
            budget,
            scope: ScopeId(0),
            frame_scope: ScopeId(0),
            prefix: String::new(),
            depth: 0,
            deepest: 0,
            nodes_since_list: 0,
            node_directives: BTreeMap::new(),
            names: core.names_of_text(),
            refers: RefCell::default(),
            counters: None,
            debugger: None,
            is_first: true,
            loop_site: None,
        }
    }

    fn lower_module(mut self, module: &ast::Module) -> Rc<Code> {
        self.node_directives = passes(self.core, &module.nodes, self.budget);
        let body = self.deeper(|lower| {
            let mut lines = BlockBuilder::default();
            lower.add_lines(&module.body, &mut lines);
            let line = lines.statements.last().map_or(1, |(line, _)| *line);
            lower.pass(DirectiveAnchor::AtEnd, line, &mut lines.statements);
            lines.into()
        });
        self.budget
            .drop_each(std::mem::take(&mut self.node_directives));
        self.module_code(Body::Block(body), module.span)
    }

    /// Counts work; whether all of it is given up, so that whatever is returned will do.
    fn charge_and_check(&self, work: usize) -> bool {
        self.budget.charge(work);
        self.budget.is_aborted()
    }

    fn places(&self, scope: ScopeId) -> &'l ScopeLayout {
        static NONE: ScopeLayout = ScopeLayout::NONE;
        let places = self.resolution.scopes.get(scope.0 as usize);
        places.and_then(Option::as_ref).unwrap_or(&NONE)
    }

    fn layout(&self, scope: ScopeId) -> &'l FrameLayout {
        static NONE: FrameLayout = FrameLayout::NONE;
        self.places(scope).frame.as_ref().unwrap_or(&NONE)
    }

    fn place(&self, name: &str) -> Storage {
        self.budget.charge(WORK_PER_NAME);
        self.places(self.scope)
            .names
            .get(name)
            .cloned()
            .unwrap_or(Storage::Global)
    }

    fn symbol(&self, name: &str) -> Symbol {
        self.budget.charge(WORK_PER_NAME);
        let symbol = self.core.symbols.intern_used(name);
        self.names.note(symbol);
        symbol
    }

    /// The slot with the mapping that a name is looked up in first, at the top level of a text that has one; `binds`
    /// says that the name is bound.
    fn mapping(&self, name: &str, binds: bool) -> Option<u32> {
        if !self.namespace.is_by_mapping() || self.scope != ScopeId(0) {
            return None;
        }
        let is_bound = || {
            self.resolution
                .bindings
                .iter()
                .any(|other| **other == *name)
        };
        let mut declared = self.resolution.declared_globals.iter();
        let is_global = (binds || declared.any(|other| **other == *name)) && !is_bound();
        let layout = self.places(ScopeId(0)).frame.as_ref();
        let slots = layout.map_or(0, |layout| layout.slot_names.len());
        (!is_global).then_some(slots as u32)
    }

    /// The variable of a name of the namespace.
    fn variable(&self, name: Symbol) -> Rc<CellVar> {
        let cell = self.namespace.cell(name);
        if self.namespace.is_of_text() && self.namespace.has_name(name) {
            self.refers.borrow().cells.borrow_mut().push(cell.clone());
        }
        cell
    }

    fn line(&self, span: Span) -> u32 {
        self.file.line_of(span.start)
    }

    /// Runs `inner` for the contents of a frame, and returns with its result what the frame takes.
    fn frame<T>(
        &mut self,
        scope: ScopeId,
        prefix: String,
        inner: impl FnOnce(&mut Self) -> T,
    ) -> (T, FrameInfo) {
        let outer_refers = self.refers.take();
        let outer_scope = std::mem::replace(&mut self.scope, scope);
        let outer_frame = std::mem::replace(&mut self.frame_scope, scope);
        let outer_prefix = std::mem::replace(&mut self.prefix, prefix);
        let outer_first = std::mem::replace(&mut self.is_first, true);
        let outer_depth = (
            std::mem::take(&mut self.depth),
            std::mem::take(&mut self.deepest),
        );
        let result = inner(self);
        let extent = FrameInfo {
            stack_bytes: stack_bytes(self.deepest),
            refers: self.refers.replace(outer_refers),
        };
        (self.depth, self.deepest) = outer_depth;
        self.is_first = outer_first;
        self.scope = outer_scope;
        self.frame_scope = outer_frame;
        self.prefix = outer_prefix;
        (result, extent)
    }

    /// Runs `inner` one level deeper in the tree.
    fn deeper<T>(&mut self, inner: impl FnOnce(&mut Self) -> T) -> T {
        self.depth += 1;
        self.deepest = self.deepest.max(self.depth);
        let result = inner(self);
        self.depth -= 1;
        result
    }

    fn module_code(&self, body: Body, span: Span) -> Rc<Code> {
        let layout = self.layout(ScopeId(0));
        Rc::new(Code {
            name: "<module>".into(),
            qualname: "<module>".into(),
            doc: None,
            file: self.file.clone(),
            span,
            params: Params::default(),
            slots: layout.slot_names.len() + usize::from(self.namespace.is_by_mapping()),
            slot_names: self.symbols(layout),
            free_names: Box::default(),
            cells: layout.cells.clone().into(),
            kind: CodeKind::Plain,
            entries: EntryPoints::for_code(CodeKind::Plain, &Params::default(), usize::MAX),
            body,
            names: self.names.clone(),
            module: Some(Rc::downgrade(self.namespace)),
            stack_bytes: stack_bytes(self.deepest),
            refs: self.refers.take(),
        })
    }

    fn symbols(&self, layout: &FrameLayout) -> Box<[Symbol]> {
        layout
            .slot_names
            .iter()
            .map(|name| self.symbol(name))
            .collect()
    }

    /// Adds the statements of a block that do something, and the directives between them.
    fn add_lines(&mut self, body: &[ast::Stmt], lines: &mut BlockBuilder) {
        for statement in body {
            if self.charge_and_check(WORK_PER_NODE) {
                break;
            }
            let (line, start) = (self.line(statement.span), statement.span.start);
            self.pass(DirectiveAnchor::Before(start), line, &mut lines.statements);
            if let Some(mark) = self.mark(statement, line) {
                lines.statements.push((line, Box::new(mark)));
            }
            if !self.add_inline_try(statement, lines)
                && let Some(node) = self.debug_statement(statement)
            {
                lines.statements.push((line, node));
            }
            self.pass(DirectiveAnchor::After(start), line, &mut lines.statements);
        }
    }

    /// The mark of a statement whose executions are counted; declarations are not executed.
    fn mark(&self, statement: &ast::Stmt, line: u32) -> Option<CoverageMark> {
        let counters = self.counters.as_ref()?;
        match &statement.kind {
            ast::StmtKind::Global(_) | ast::StmtKind::Nonlocal(_) => None,
            ast::StmtKind::Expr(expr) if matches!(expr.kind, ast::ExprKind::Constant(_)) => None,
            _ => Some(counters.mark(self.file.name(), line)),
        }
    }

    /// Adds the directives that are passed at `place`, as if they stood in `line`.
    fn pass(&self, place: DirectiveAnchor, line: u32, lines: &mut Vec<NumberedStmt>) {
        for pass in self.node_directives.get(&place).into_iter().flatten() {
            lines.push((line, Box::new(*pass)));
        }
    }

    /// The condition of a branch of an `if`.
    fn branch_test(&mut self, test: &ast::Expr, is_first: bool) -> BoxExpr {
        let then = match is_first {
            true => self.expr(test),
            false => self.watched_test(test, None),
        };
        let counters = self.counters.as_ref();
        let then = match counters {
            None => then,
            Some(counters) => Box::new(CoverageCondition {
                mark: counters.mark(self.file.name(), self.line(test.span)),
                then,
            }),
        };
        match self
            .node_directives
            .get(&DirectiveAnchor::Before(test.span.start))
        {
            None => then,
            Some(passes) => Box::new(EnterTaskNodeThen {
                passes: passes.clone().into(),
                then,
            }),
        }
    }

    fn constant(&self, constant: &Constant) -> Value {
        match constant {
            Constant::None => Value::None,
            Constant::Bool(flag) => Value::Bool(*flag),
            Constant::Ellipsis => Value::Ellipsis,
            Constant::Int(int) => Value::Int(*int),
            Constant::BigInt(big) => Value::bigint(big.clone()),
            Constant::Float(float) => Value::Float(*float),
            Constant::Imaginary(imaginary) => Value::complex(0.0, *imaginary),
            // Short strings that look like names are shared, as in CPython.
            Constant::Str(text) if is_name(text) => self.core.symbols.to_value(self.symbol(text)),
            Constant::Str(text) => Value::str(&**text),
            Constant::Bytes(bytes) => Value::Bytes(Rc::new(Bytes::new(bytes.to_vec()))),
        }
    }
}

fn is_name(text: &str) -> bool {
    text.len() <= 32
        && text
            .bytes()
            .all(|byte| byte == b'_' || byte.is_ascii_alphanumeric())
}

fn stack_bytes(levels: usize) -> usize {
    RESERVE + (levels + 2) * LEVEL
}
