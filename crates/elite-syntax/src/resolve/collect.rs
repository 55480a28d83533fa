//! First pass: what each scope binds, uses and declares.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use messages::text;

use super::{KnownNames, WORK_PER_MENTION};
use crate::ast::{
    Arg, ClassDef, Comprehension, ComprehensionKind, DictItem, Expr, ExprKind, FStringPart,
    FunctionDef, Ident, Module, Parameters, ScopeId, Stmt, StmtKind,
};
use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::{DiagnosticList, quoted};
use crate::source::Span;
use crate::work_budget::{WORK_PER_DROP, WorkBudget};

/// Work for one statement or expression, beside the names in it.
const WORK_PER_NODE: usize = 8;

/// What kind of program text a scope is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ScopeKind {
    Module,
    Function,
    Class,
    /// A list, set or dict comprehension: names of its own, but no frame.
    Comprehension,
}

/// A name within one scope.
#[derive(Clone, Debug, Default)]
pub(super) struct NameInfo {
    pub(super) name: Box<str>,
    pub(super) bound: bool,
    pub(super) parameter: bool,
    pub(super) global: Option<Span>,
    pub(super) nonlocal: Option<Span>,
    /// The first place that the name is used or bound at.
    first_seen: Option<Span>,
    /// The name is read somewhere in the scope.
    read: bool,
    annotated: bool,
    /// The first plain assignment or import of the name.
    pub(super) binding: Option<(Span, Binding)>,
}

/// How a name is bound, for those ways that should lead to a use.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Binding {
    /// `name = value`
    Variable,
    /// `import name`
    Import,
}

/// One scope.
#[derive(Clone, Debug)]
pub(super) struct Scope {
    pub(super) kind: ScopeKind,
    pub(super) parent: Option<ScopeId>,
    pub(super) names: Vec<NameInfo>,
    /// Index into `names`.
    index: BTreeMap<Box<str>, usize>,
    pub(super) uses: Vec<(Box<str>, Span)>,
    pub(super) is_generator: bool,
}

impl Scope {
    fn new(kind: ScopeKind, parent: Option<ScopeId>) -> Self {
        let (names, index, uses) = (Vec::new(), BTreeMap::new(), Vec::new());
        Scope {
            kind,
            parent,
            names,
            index,
            uses,
            is_generator: false,
        }
    }

    pub(super) fn name(&self, name: &str) -> Option<&NameInfo> {
        self.index.get(name).map(|at| &self.names[*at])
    }

    fn name_mut(&mut self, name: &str) -> &mut NameInfo {
        let at = match self.index.get(name) {
            Some(at) => *at,
            None => {
                self.index.insert(name.into(), self.names.len());
                self.names.push(NameInfo {
                    name: name.into(),
                    ..NameInfo::default()
                });
                self.names.len() - 1
            }
        };
        &mut self.names[at]
    }
}

/// All scopes of a program, by `ScopeId`.
pub(super) struct Scopes<'p> {
    pub(super) budget: &'p WorkBudget<'p>,
    /// The module, then those from number `first` on.
    pub(super) scopes: Vec<Option<Scope>>,
    first: u32,
    /// There is a `from m import *`: any name may be defined.
    pub(super) star_import: bool,
    pub(super) diagnostics: DiagnosticList,
    current: ScopeId,
    globals: Vec<Box<str>>,
    /// The names in `globals`, to look one up.
    global_set: BTreeSet<Box<str>>,
}

impl Scopes<'_> {
    /// The embedder's names that are bound in any of the scopes.
    pub(super) fn bound_natives<'s>(
        &'s self,
        known: &'s KnownNames,
    ) -> impl Iterator<Item = &'s str> {
        let names = self.scopes.iter().flatten().flat_map(|scope| &scope.names);
        let bound = names.filter(|info| info.bound && known.contains(&info.name));
        bound.map(|info| &*info.name)
    }
}

pub(super) fn collect<'p>(module: &Module, budget: &'p WorkBudget<'p>) -> Scopes<'p> {
    collect_part(&module.body, 1..module.scope_count, budget)
}

/// Collects the scopes of some statements of the top level, whose own scopes have the numbers `own`.
pub(super) fn collect_part<'p>(
    body: &[Stmt],
    own: Range<u32>,
    budget: &'p WorkBudget<'p>,
) -> Scopes<'p> {
    let mut scopes = Scopes {
        budget,
        first: own.start,
        // Each takes a place of some size.
        scopes: (own.start..=own.end.max(own.start))
            .map(|_| {
                budget.charge(WORK_PER_DROP);
                None
            })
            .collect(),
        star_import: false,
        diagnostics: DiagnosticList::default(),
        current: ScopeId(0),
        globals: Vec::new(),
        global_set: BTreeSet::new(),
    };
    scopes.open(ScopeId(0), ScopeKind::Module, None);
    scopes.block(body);
    scopes
}

impl Scopes<'_> {
    /// Drops the tables, with pauses.
    pub(super) fn release(self) {
        let budget = self.budget;
        for scope in self.scopes.into_iter().flatten() {
            budget.charge(WORK_PER_DROP);
            let texts = scope.uses.into_iter().map(|(name, _)| name);
            let texts = texts.chain(scope.names.into_iter().map(|info| info.name));
            budget.drop_each(texts.chain(scope.index.into_keys()));
        }
        budget.drop_each(self.globals);
        budget.drop_each(self.global_set);
    }

    pub(super) fn get(&self, id: ScopeId) -> Option<&Scope> {
        self.scopes.get(self.table_index(id))?.as_ref()
    }

    /// Where a scope stands in the table.
    fn table_index(&self, id: ScopeId) -> usize {
        match id.0 {
            0 => 0,
            other => (other + 1 - self.first) as usize,
        }
    }

    /// The scope at a place of the table.
    pub(super) fn id_at(&self, place: usize) -> ScopeId {
        match place {
            0 => ScopeId(0),
            other => ScopeId(other as u32 + self.first - 1),
        }
    }

    pub(super) fn declared_globals(&mut self) -> Vec<Box<str>> {
        std::mem::take(&mut self.globals)
    }

    /// Names the top level binds without declaring them global.
    pub(super) fn module_bindings(&self) -> Vec<Box<str>> {
        let names = self.get(ScopeId(0)).map_or(&[][..], |scope| &scope.names);
        let own = names
            .iter()
            .filter(|info| info.bound && info.global.is_none());
        let name = |info: &NameInfo| {
            self.budget.charge(WORK_PER_MENTION / 4);
            info.name.clone()
        };
        own.map(name).collect()
    }

    fn open(&mut self, id: ScopeId, kind: ScopeKind, parent: Option<ScopeId>) {
        let at = self.table_index(id);
        self.scopes[at] = Some(Scope::new(kind, parent));
    }

    /// Runs `inner` in the new scope `id`.
    fn in_scope(&mut self, id: ScopeId, kind: ScopeKind, inner: impl FnOnce(&mut Self)) {
        self.budget.charge(WORK_PER_MENTION);
        let outer = self.current;
        self.open(id, kind, Some(outer));
        self.current = id;
        inner(self);
        self.current = outer;
    }

    fn scope(&mut self) -> &mut Scope {
        // `current` is only ever set to a scope that `open` has made; the module is a safe stand-in.
        let index = self.table_index(self.current);
        self.scopes[index].get_or_insert_with(|| Scope::new(ScopeKind::Module, None))
    }

    fn use_name(&mut self, name: &str, span: Span) {
        self.scope().name_mut(name).read = true;
        self.mention(name, span);
    }

    /// A use that does not count as reading the name before its declaration: `x += 1` is an assignment.
    fn mention(&mut self, name: &str, span: Span) {
        self.budget.charge(WORK_PER_MENTION);
        let scope = self.scope();
        scope.name_mut(name).first_seen.get_or_insert(span);
        scope.uses.push((name.into(), span));
    }

    fn bind(&mut self, name: &str, span: Span) {
        self.budget.charge(WORK_PER_MENTION);
        let info = self.scope().name_mut(name);
        info.bound = true;
        info.first_seen.get_or_insert(span);
    }

    /// A name may be declared after its import, as in CPython.
    fn bind_import(&mut self, name: &str) {
        self.budget.charge(WORK_PER_MENTION);
        self.scope().name_mut(name).bound = true;
    }

    fn note(&mut self, name: &str, span: Span, binding: Binding) {
        self.budget.charge(WORK_PER_MENTION / 2);
        let info = self.scope().name_mut(name);
        info.binding.get_or_insert((span, binding));
    }

    fn note_variable(&mut self, target: &Expr) {
        if let ExprKind::Name(name) = &target.kind {
            self.note(name, target.span, Binding::Variable);
        }
    }

    fn bind_parameter(&mut self, ident: &Ident) {
        self.bind(&ident.name, ident.span);
        self.scope().name_mut(&ident.name).parameter = true;
    }

    fn block(&mut self, body: &[Stmt]) {
        for statement in body {
            if self.budget.is_aborted() {
                return;
            }
            self.budget.charge(WORK_PER_NODE);
            self.statement(statement);
        }
    }

    fn statement(&mut self, statement: &Stmt) {
        match &statement.kind {
            StmtKind::Expr(value) => self.expr(value),
            StmtKind::Print { values, .. } => self.exprs(values),
            StmtKind::Assign { targets, value } => {
                self.expr(value);
                self.targets(targets);
                for target in targets {
                    self.note_variable(target);
                }
            }
            StmtKind::AugAssign { target, value, .. } => {
                match &target.kind {
                    ExprKind::Name(name) => self.mention(name, target.span),
                    _ => self.expr(target),
                }
                self.expr(value);
                self.target(target);
            }
            StmtKind::AnnAssign {
                target,
                annotation,
                value,
            } => {
                if let ExprKind::Name(name) = &target.kind {
                    self.annotate(name, target.span);
                }
                value.iter().for_each(|value| self.expr(value));
                self.target(target);
                // Classes keep the annotations of their names.
                if self.scope().kind == ScopeKind::Class && matches!(target.kind, ExprKind::Name(_))
                {
                    self.bind("__annotations__", target.span);
                    self.expr(annotation);
                }
                if value.is_some() {
                    self.note_variable(target);
                }
            }
            StmtKind::Delete(targets) => self.targets(targets),
            StmtKind::Pass | StmtKind::Break | StmtKind::Continue => {}
            StmtKind::Return(value) => value.iter().for_each(|value| self.expr(value)),
            StmtKind::Raise { exception, cause } => {
                exception.iter().chain(cause).for_each(|e| self.expr(e))
            }
            StmtKind::Global(names) => names.iter().for_each(|name| self.declare_global(name)),
            StmtKind::Nonlocal(names) => names.iter().for_each(|name| self.declare_nonlocal(name)),
            StmtKind::Assert { test, message } => {
                self.expr(test);
                message.iter().for_each(|message| self.expr(message));
            }
            StmtKind::Import(names) => {
                for alias in names {
                    let first = alias.name.name.split('.').next().unwrap_or("");
                    let bound = alias.alias.as_ref().map_or(first, |alias| &alias.name);
                    self.bind_import(bound);
                    self.note(bound, alias.name.span, Binding::Import);
                }
            }
            StmtKind::ImportFrom { names, star, .. } => {
                self.star_import |= star;
                if *star && self.current != ScopeId(0) {
                    // Names that are only known at run time have no place in a function.
                    let message = text!(
                        "import * only allowed at module level",
                        "import * 只能用在模块顶层"
                    );
                    let found = Diagnostic::error("syntax", statement.span, message);
                    self.diagnostics.push(found);
                }
                for alias in names {
                    let bound = alias.alias.as_ref().unwrap_or(&alias.name);
                    self.bind_import(&bound.name);
                    self.note(&bound.name, bound.span, Binding::Import);
                }
            }
            StmtKind::Function(def) => self.function(def),
            StmtKind::Class(def) => self.class(def),
            _ => self.compound(statement),
        }
    }

    fn compound(&mut self, statement: &Stmt) {
        match &statement.kind {
            StmtKind::If { branches, orelse } => {
                for (test, body) in branches {
                    self.expr(test);
                    self.block(body);
                }
                self.block(orelse);
            }
            StmtKind::While { test, body, orelse } => {
                self.expr(test);
                self.block(body);
                self.block(orelse);
            }
            StmtKind::For {
                target,
                iterable,
                body,
                orelse,
            } => {
                self.expr(iterable);
                self.target(target);
                self.block(body);
                self.block(orelse);
            }
            StmtKind::With { items, body } => {
                for item in items {
                    self.expr(&item.context);
                    item.target.iter().for_each(|target| self.target(target));
                }
                self.block(body);
            }
            StmtKind::Try {
                body,
                handlers,
                orelse,
                finally,
            } => {
                self.block(body);
                for handler in handlers {
                    handler
                        .exception
                        .iter()
                        .for_each(|exception| self.expr(exception));
                    handler
                        .name
                        .iter()
                        .for_each(|name| self.bind(&name.name, name.span));
                    self.block(&handler.body);
                }
                self.block(orelse);
                self.block(finally);
            }
            _ => {}
        }
    }

    fn declare_global(&mut self, ident: &Ident) {
        self.budget.charge(WORK_PER_MENTION);
        if self.global_set.insert(ident.name.clone()) {
            self.globals.push(ident.name.clone());
        }
        let in_module = self.current == ScopeId(0);
        self.declare(ident, "global", in_module, |info, span| {
            info.global = Some(span)
        });
    }

    fn declare_nonlocal(&mut self, ident: &Ident) {
        if self.current == ScopeId(0) {
            let message = text!(
                "nonlocal declaration not allowed at module level",
                "模块顶层不能有 nonlocal 声明"
            );
            self.diagnostics
                .push(Diagnostic::error("syntax", ident.span, message));
            return;
        }
        self.declare(ident, "nonlocal", false, |info, span| {
            info.nonlocal = Some(span)
        });
    }

    fn declare(
        &mut self,
        ident: &Ident,
        word: &str,
        lenient: bool,
        set: impl FnOnce(&mut NameInfo, Span),
    ) {
        self.budget.charge(WORK_PER_MENTION);
        let info = self.scope().name_mut(&ident.name);
        let name = quoted(&ident.name);
        let is_first = info.global.is_none() && info.nonlocal.is_none();
        // The words are CPython's.
        let trouble = if info.parameter {
            Some(text!(
                "name '{name}' is parameter and {word}",
                "名称 '{name}' 既是参数又声明为 {word}"
            ))
        } else if info.first_seen.is_none() || !is_first || lenient {
            None
        } else if info.read {
            Some(text!(
                "name '{name}' is used prior to {word} declaration",
                "名称 '{name}' 在 {word} 声明之前被使用"
            ))
        } else if info.annotated {
            Some(text!(
                "annotated name '{name}' can't be {word}",
                "带注解的名称 '{name}' 不能是 {word}"
            ))
        } else {
            Some(text!(
                "name '{name}' is assigned to before {word} declaration",
                "名称 '{name}' 在 {word} 声明之前被赋值"
            ))
        };
        let first_seen = info.first_seen;
        set(info, ident.span);
        if info.global.is_some() && info.nonlocal.is_some() {
            let message = text!(
                "name '{name}' is nonlocal and global",
                "名称 '{name}' 同时声明为 nonlocal 和 global"
            );
            self.diagnostics
                .push(Diagnostic::error("syntax", ident.span, message));
        } else if let Some(message) = trouble {
            let diagnostic = Diagnostic::error("syntax", ident.span, message);
            let first = first_seen.unwrap_or(ident.span);
            self.diagnostics
                .push(diagnostic.with_label(first, text!("first used here", "首次在此使用")));
        }
    }

    /// `name: annotation`, which a declared name cannot have but at the top level.
    fn annotate(&mut self, name: &str, span: Span) {
        let in_module = self.current == ScopeId(0);
        let info = self.scope().name_mut(name);
        info.annotated = true;
        let word = match (info.global.is_some(), info.nonlocal.is_some()) {
            (true, _) => "global",
            (_, true) => "nonlocal",
            _ => return,
        };
        if !in_module {
            let message = text!(
                "annotated name '{}' can't be {word}",
                "带注解的名称 '{}' 不能是 {word}",
                quoted(name)
            );
            self.diagnostics
                .push(Diagnostic::error("syntax", span, message));
        }
    }

    fn parameters_outside(&mut self, parameters: &Parameters) {
        for parameter in parameters.iter() {
            parameter
                .default
                .iter()
                .for_each(|default| self.expr(default));
        }
    }

    fn function(&mut self, def: &FunctionDef) {
        self.exprs(&def.decorators);
        self.parameters_outside(&def.parameters);
        let annotations = def.parameters.iter().filter_map(|p| p.annotation.as_ref());
        annotations
            .chain(&def.returns)
            .for_each(|annotation| self.annotation(annotation));
        self.bind(&def.name.name, def.name.span);
        self.in_scope(def.scope, ScopeKind::Function, |scopes| {
            def.parameters
                .iter()
                .for_each(|parameter| scopes.bind_parameter(&parameter.name));
            scopes.block(&def.body);
        });
    }

    /// An annotation of a function; it is evaluated where the function is defined.
    fn annotation(&mut self, annotation: &Expr) {
        self.expr(annotation);
    }

    fn class(&mut self, def: &ClassDef) {
        self.exprs(&def.decorators);
        self.args(&def.args);
        self.bind(&def.name.name, def.name.span);
        self.in_scope(def.scope, ScopeKind::Class, |scopes| {
            scopes.block(&def.body)
        });
    }

    fn targets(&mut self, targets: &[Expr]) {
        targets.iter().for_each(|target| self.target(target));
    }

    /// Names that are bound by assigning to `target`; parts that are evaluated count as uses.
    fn target(&mut self, target: &Expr) {
        match &target.kind {
            ExprKind::Name(name) => self.bind(name, target.span),
            ExprKind::Tuple(items) | ExprKind::List(items) => self.targets(items),
            ExprKind::Starred(inner) => self.target(inner),
            _ => self.expr(target),
        }
    }

    fn exprs(&mut self, exprs: &[Expr]) {
        exprs.iter().for_each(|expr| self.expr(expr));
    }

    fn args(&mut self, args: &[Arg]) {
        for arg in args {
            match arg {
                Arg::Positional(value)
                | Arg::Star(value)
                | Arg::Keyword(_, value)
                | Arg::DoubleStar(value) => {
                    self.expr(value);
                }
            }
        }
    }

    fn expr(&mut self, expr: &Expr) {
        self.budget.charge(WORK_PER_NODE);
        match &expr.kind {
            ExprKind::Constant(_) => {}
            ExprKind::Name(name) => self.use_name(name, expr.span),
            ExprKind::And(items) | ExprKind::Or(items) => self.exprs(items),
            ExprKind::List(items) | ExprKind::Tuple(items) | ExprKind::Set(items) => {
                self.exprs(items)
            }
            ExprKind::Binary { left, right, .. } => {
                self.expr(left);
                self.expr(right);
            }
            ExprKind::Unary { operand, .. } => self.expr(operand),
            ExprKind::Compare { left, rest } => {
                self.expr(left);
                rest.iter().for_each(|(_, right)| self.expr(right));
            }
            ExprKind::Call { function, args } => {
                self.expr(function);
                self.implicit_class_use(function);
                self.args(args);
            }
            ExprKind::Attribute { value, .. } | ExprKind::Starred(value) => self.expr(value),
            ExprKind::Subscript { value, index } => {
                self.expr(value);
                self.expr(index);
            }
            ExprKind::Slice { lower, upper, step } => {
                [lower, upper, step]
                    .into_iter()
                    .flatten()
                    .for_each(|bound| self.expr(bound));
            }
            ExprKind::Dict(items) => items.iter().for_each(|item| match item {
                DictItem::Pair(key, value) => {
                    self.expr(key);
                    self.expr(value);
                }
                DictItem::Unpack(mapping) => self.expr(mapping),
            }),
            ExprKind::Comprehension(comprehension) => self.comprehension(comprehension, expr.span),
            ExprKind::Lambda(lambda) => {
                self.parameters_outside(&lambda.parameters);
                self.in_scope(lambda.scope, ScopeKind::Function, |scopes| {
                    lambda
                        .parameters
                        .iter()
                        .for_each(|parameter| scopes.bind_parameter(&parameter.name));
                    scopes.expr(&lambda.body);
                });
            }
            ExprKind::IfElse { test, body, orelse } => {
                self.expr(test);
                self.expr(body);
                self.expr(orelse);
            }
            ExprKind::Named { target, value } => {
                self.expr(value);
                self.bind_named(target);
            }
            ExprKind::Yield(value) => {
                self.mark_generator(expr.span);
                value.iter().for_each(|value| self.expr(value));
            }
            ExprKind::YieldFrom(value) => {
                self.mark_generator(expr.span);
                self.expr(value);
            }
            ExprKind::FString(parts) => self.fstring(parts),
        }
    }

    /// `super()` without arguments needs the class it is written in; so do functions within the method.
    fn implicit_class_use(&mut self, function: &Expr) {
        if matches!(&function.kind, ExprKind::Name(name) if &**name == "super") {
            self.scope().name_mut("__class__");
        }
    }

    fn mark_generator(&mut self, span: Span) {
        match self.scope().kind {
            ScopeKind::Function => self.scope().is_generator = true,
            ScopeKind::Comprehension => {
                let message = text!("'yield' inside a comprehension", "推导式中不能有 'yield'");
                self.diagnostics
                    .push(Diagnostic::error("syntax", span, message));
            }
            // Outside functions the parser has reported it.
            ScopeKind::Module | ScopeKind::Class => {}
        }
    }

    /// `:=` in a comprehension binds in the scope around it (PEP 572).
    fn bind_named(&mut self, target: &Ident) {
        let inner = self.current;
        while self.scope().kind == ScopeKind::Comprehension || self.is_generator_expression() {
            let own = self
                .scope()
                .name(&target.name)
                .is_some_and(|info| info.bound);
            if own {
                let message = text!(
                    "':=' cannot rebind the iteration variable '{}'",
                    "':=' 不能重新绑定迭代变量 '{}'",
                    quoted(&target.name)
                );
                self.diagnostics
                    .push(Diagnostic::error("syntax", target.span, message));
                break;
            }
            match self.scope().parent {
                Some(parent) => self.current = parent,
                None => break,
            }
        }
        if inner != self.current && self.scope().kind == ScopeKind::Class {
            let message = text!(
                "':=' within a comprehension cannot be used in a class body",
                "类体中的推导式不能使用 ':='"
            );
            self.diagnostics
                .push(Diagnostic::error("syntax", target.span, message));
        }
        let outer = self.current;
        self.bind(&target.name, target.span);
        // Inner scopes see the outer name; in a function it may be a cell.
        self.current = inner;
        if inner != outer {
            self.scope()
                .name_mut(&target.name)
                .first_seen
                .get_or_insert(target.span);
        }
    }

    fn is_generator_expression(&mut self) -> bool {
        let scope = self.scope();
        scope.is_generator && scope.name(".0").is_some()
    }

    fn fstring(&mut self, parts: &[FStringPart]) {
        for part in parts {
            if let FStringPart::Value { value, format, .. } = part {
                self.expr(value);
                format.iter().for_each(|format| self.fstring(format));
            }
        }
    }

    fn comprehension(&mut self, comprehension: &Comprehension, span: Span) {
        let Some((first, rest)) = comprehension.clauses.split_first() else {
            return;
        };
        self.expr(&first.iterable);
        let generator = matches!(comprehension.kind, ComprehensionKind::Generator(_));
        let kind = if generator {
            ScopeKind::Function
        } else {
            ScopeKind::Comprehension
        };
        self.in_scope(comprehension.scope, kind, |scopes| {
            if generator {
                // The iterator of the first clause is the only parameter, as in CPython.
                scopes.bind(".0", span);
                scopes.scope().name_mut(".0").parameter = true;
                scopes.scope().is_generator = true;
            }
            scopes.target(&first.target);
            scopes.exprs(&first.conditions);
            for clause in rest {
                scopes.expr(&clause.iterable);
                scopes.target(&clause.target);
                scopes.exprs(&clause.conditions);
            }
            match &comprehension.kind {
                ComprehensionKind::List(e)
                | ComprehensionKind::Set(e)
                | ComprehensionKind::Generator(e) => {
                    scopes.expr(e);
                }
                ComprehensionKind::Dict(key, value) => {
                    scopes.expr(key);
                    scopes.expr(value);
                }
            }
        });
    }
}
