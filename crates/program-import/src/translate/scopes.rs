//! Where names live: a name without a qualifier is the global or the variable of an outer function where there is one,
//! and a local variable otherwise.

use std::collections::{BTreeMap, BTreeSet};

use crate::urscript::ast::{
    Expr, ExprKind, Function, FunctionKind, Scope, Stmt, StmtKind, walk_expr,
};

/// Number of a scope; 0 is the program.
pub type ScopeId = usize;

/// A variable: the scope that owns it, and its name.
pub type Symbol = (ScopeId, String);

/// A function, or the program.
#[derive(Clone, Debug, Default)]
pub struct FunctionScope {
    /// The scope around it.
    parent: ScopeId,
    /// Line of its `def`.
    line: u32,
    /// Parameters.
    pub params: Vec<String>,
    /// Variables of its own, with the line of the first assignment.
    locals: BTreeMap<String, u32>,
    /// Variables of outer scopes that it assigns.
    pub outer: BTreeMap<String, ScopeId>,
    /// Names that are read in it or in a function inside it.
    reads: BTreeSet<String>,
}

/// All scopes of a text.
#[derive(Clone, Debug)]
pub struct Scopes {
    scopes: Vec<FunctionScope>,
    /// Scope by the address of the function's node.
    of_node: BTreeMap<usize, ScopeId>,
    /// Scope by name.
    by_name: BTreeMap<String, ScopeId>,
    /// Names declared `global` anywhere.
    globals: BTreeSet<String>,
}

/// How a scope uses a name.
#[derive(Default)]
struct Uses<'t> {
    /// First assignment: line, and whether the name was read before.
    free: BTreeMap<&'t str, (u32, bool)>,
    local: BTreeMap<&'t str, u32>,
    reads: BTreeSet<&'t str>,
}

impl Scopes {
    /// The scopes of the statements of a program.
    pub fn of(body: &[Stmt]) -> Self {
        let mut scopes = Self {
            scopes: Vec::new(),
            of_node: BTreeMap::new(),
            by_name: BTreeMap::new(),
            globals: BTreeSet::new(),
        };
        scopes.note_globals(body);
        let program = FunctionScope {
            line: u32::MAX,
            ..FunctionScope::default()
        };
        scopes.add(program, body);
        scopes
    }

    fn note_globals(&mut self, body: &[Stmt]) {
        for stmt in body {
            if let StmtKind::Assign {
                scope: Scope::Global,
                target,
                ..
            } = &stmt.kind
                && let ExprKind::Name(name) = &target.kind
            {
                self.globals.insert(name.clone());
            }
            if let StmtKind::Function(function) = &stmt.kind {
                self.note_globals(&function.body);
            }
            stmt.blocks()
                .into_iter()
                .for_each(|block| self.note_globals(block));
        }
    }

    fn add(&mut self, scope: FunctionScope, body: &[Stmt]) -> ScopeId {
        let id = self.scopes.len();
        let is_program = id == 0;
        let mut uses = Uses::default();
        let mut functions = Vec::new();
        collect(body, &mut uses, &mut functions);
        self.scopes.push(scope);
        for param in self.scopes[id].params.clone() {
            self.scopes[id].locals.insert(param, 0);
        }
        for (name, line) in uses.local {
            self.scopes[id]
                .locals
                .entry(name.to_owned())
                .or_insert(line);
        }
        for (name, (line, is_read_before)) in uses.free {
            if self.scopes[id].locals.contains_key(name) {
                continue;
            }
            let outer = match is_program {
                true => None,
                false => self.owner_outside(id, name, is_read_before),
            };
            match outer {
                Some(owner) => {
                    self.scopes[id].outer.insert(name.to_owned(), owner);
                }
                None => {
                    self.scopes[id].locals.insert(name.to_owned(), line);
                }
            }
        }
        let reads = uses.reads.into_iter().map(str::to_owned);
        self.scopes[id].reads.extend(reads);
        for (function, line) in functions {
            let inner = FunctionScope {
                parent: id,
                line,
                params: function
                    .params
                    .iter()
                    .map(|(name, _)| name.clone())
                    .collect(),
                ..FunctionScope::default()
            };
            let inner = self.add(inner, &function.body);
            self.of_node
                .insert(std::ptr::from_ref(function).addr(), inner);
            self.by_name.insert(function.name.clone(), inner);
            let reads = self.scopes[inner].reads.clone();
            self.scopes[id].reads.extend(reads);
        }
        id
    }

    /// The scope outside that a name without a qualifier stands for. Variables that an outer scope gets only after the
    /// function count where the function reads them first.
    fn owner_outside(&self, id: ScopeId, name: &str, is_read_before: bool) -> Option<ScopeId> {
        let mut scope = id;
        while scope != 0 {
            let line = self.scopes[scope].line;
            scope = self.scopes[scope].parent;
            if let Some(first) = self.scopes[scope].locals.get(name)
                && (*first < line || is_read_before)
            {
                return Some(scope);
            }
        }
        self.globals.contains(name).then_some(0)
    }

    /// A scope.
    pub fn scope(&self, id: ScopeId) -> &FunctionScope {
        &self.scopes[id]
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.scopes.len()
    }

    /// The scope of a function's node.
    pub fn of_function(&self, function: &Function) -> ScopeId {
        let address = std::ptr::from_ref(function).addr();
        self.of_node.get(&address).copied().unwrap_or_default()
    }

    /// The scope of the function of this name.
    pub fn named(&self, name: &str) -> Option<ScopeId> {
        self.by_name.get(name).copied()
    }

    /// The variable that a name stands for in a scope; `None` where nothing is assigned to it anywhere.
    pub fn symbol(&self, mut id: ScopeId, name: &str) -> Option<Symbol> {
        loop {
            let scope = &self.scopes[id];
            if let Some(owner) = scope.outer.get(name) {
                return Some((*owner, name.to_owned()));
            }
            if scope.locals.contains_key(name) {
                return Some((id, name.to_owned()));
            }
            if id == 0 {
                return self.globals.contains(name).then(|| (0, name.to_owned()));
            }
            id = scope.parent;
        }
    }

    /// Whether a variable is of its function alone and is never read.
    pub fn is_unused_local(&self, id: ScopeId, name: &str) -> bool {
        let scope = &self.scopes[id];
        id != 0
            && scope.locals.contains_key(name)
            && !scope.params.iter().any(|param| param == name)
            && !scope.reads.contains(name)
    }
}

fn collect<'t>(body: &'t [Stmt], uses: &mut Uses<'t>, functions: &mut Vec<(&'t Function, u32)>) {
    for stmt in body {
        if let StmtKind::Function(function) = &stmt.kind {
            functions.push((function, stmt.line));
        }
        let target = match &stmt.kind {
            StmtKind::Assign {
                scope,
                target,
                value,
            } => {
                value.iter().for_each(|value| note_reads(value, uses));
                match &target.kind {
                    ExprKind::Name(name) => Some((*scope, name)),
                    _ => {
                        note_reads(target, uses);
                        None
                    }
                }
            }
            _ => {
                stmt.expressions()
                    .into_iter()
                    .for_each(|expr| note_reads(expr, uses));
                None
            }
        };
        if let Some((scope, name)) = target {
            let is_read_before = uses.reads.contains(name.as_str());
            match scope {
                Scope::Local => {
                    uses.local.entry(name).or_insert(stmt.line);
                }
                Scope::Free | Scope::Global => {
                    uses.free.entry(name).or_insert((stmt.line, is_read_before));
                }
            }
        }
        stmt.blocks()
            .into_iter()
            .for_each(|block| collect(block, uses, functions));
    }
}

fn note_reads<'t>(expr: &'t Expr, uses: &mut Uses<'t>) {
    walk_expr(expr, &mut |expr| {
        if let ExprKind::Name(name) = &expr.kind {
            uses.reads.insert(name);
        }
    });
}

/// The statements of the program, and whether they stood in one `def`.
pub fn program_body(body: &[Stmt]) -> (&[Stmt], Option<&Function>) {
    let mut statements = body
        .iter()
        .filter(|stmt| !matches!(stmt.kind, StmtKind::Label(_)));
    if let (Some(only), None) = (statements.next(), statements.next())
        && let StmtKind::Function(function) = &only.kind
        && function.kind == FunctionKind::Def
        && function.params.iter().all(|(_, default)| default.is_some())
    {
        return (&function.body, Some(function));
    }
    (body, None)
}
