//! Walks the tree of a piece of a program and notes its scopes, names and what they are bound to.
//!
//! Two steps: the walk notes what happens to names in which scope; then, when it is known what each scope binds, every
//! place of a name gets its symbol. Names that no scope within the piece binds are left to `incremental`.

use std::collections::{HashMap, HashSet};

use elite_syntax::Span;
use elite_syntax::ast::visit::blocks;
use elite_syntax::ast::{
    Arg, ClassDef, Comprehension, ComprehensionKind, DictItem, Expr, ExprKind, FStringPart,
    FunctionDef, Ident, ImportAlias, Parameters, Stmt, StmtKind,
};

use super::incremental::UnresolvedName;
use super::scopes::{
    AttributeInfo, AttributeUse, ClassInfo, FunctionInfo, KeywordUse, Occurrence, ParameterInfo,
    Role, Scope, ScopeId, ScopeKind, Symbol, SymbolId, SymbolKind,
};
use super::type_ref::{docstring, type_ref_of};
use super::types::TypeRef;

/// Longest text of a default or annotation that is shown, in bytes.
const WRITTEN_MAX: usize = 60;

/// Something that happens to a name.
struct NameEvent {
    name: Box<str>,
    occurrence: Occurrence,
    binds: Option<(SymbolKind, TypeRef)>,
}

/// The names in some statements of the top level. Numbers count from 0; scope 0 is the module, of which nothing else is
/// known.
#[derive(Default)]
pub(super) struct UnitNames {
    pub(super) scopes: Vec<Scope>,
    /// Symbols of the scopes within the piece.
    pub(super) symbols: Vec<Symbol>,
    pub(super) functions: Vec<FunctionInfo>,
    pub(super) classes: Vec<ClassInfo>,
    pub(super) attribute_uses: Vec<AttributeUse>,
    pub(super) keyword_uses: Vec<KeywordUse>,
    /// Every place of a name, in the order of the text.
    pub(super) places: Vec<(Occurrence, Option<SymbolId>)>,
    /// The places of names that no scope within the piece binds.
    pub(super) outward: Vec<UnresolvedName>,
    pub(super) outward_names: Vec<Box<str>>,
    /// Names of the module that it binds.
    pub(super) bound: Vec<Box<str>>,
}

/// Where the text behind the last statement of a piece ends is not known in it.
const OPEN: u32 = u32::MAX;

/// Notes the names of some statements of the top level.
pub(super) fn collect_unit(body: &[Stmt], text: &str) -> UnitNames {
    let mut collector = NameCollector {
        text,
        names: UnitNames::default(),
        events: Vec::new(),
        scope: 0,
        bound: Vec::new(),
    };
    collector.open(ScopeKind::Module, None, Span::default(), 0);
    collector.block(body, OPEN);
    collector.finish()
}

struct NameCollector<'t> {
    text: &'t str,
    names: UnitNames,
    events: Vec<NameEvent>,
    scope: ScopeId,
    /// The names that each scope binds.
    bound: Vec<HashSet<Box<str>>>,
}

impl NameCollector<'_> {
    fn open(
        &mut self,
        kind: ScopeKind,
        parent: Option<ScopeId>,
        span: Span,
        limit: u32,
    ) -> ScopeId {
        let line = self.text[..span.start as usize]
            .rfind('\n')
            .map_or(0, |at| at + 1);
        self.names.scopes.push(Scope {
            limit: limit.max(span.end),
            column: span.start - line as u32,
            is_open: limit == OPEN,
            ..Scope::new(kind, parent, span)
        });
        self.bound.push(HashSet::new());
        self.names.scopes.len() - 1
    }

    fn in_scope(
        &mut self,
        kind: ScopeKind,
        span: Span,
        limit: u32,
        inner: impl FnOnce(&mut Self, ScopeId),
    ) -> ScopeId {
        let outer = self.scope;
        let id = self.open(kind, Some(outer), span, limit);
        self.scope = id;
        inner(self, id);
        self.scope = outer;
        id
    }

    /// Of a name in parentheses, which belong to the expression, the name alone.
    fn without_parentheses(&self, name: &str, span: Span) -> Span {
        let Some(mut rest) = self.text.get(span.start as usize..span.end as usize) else {
            return span;
        };
        if !rest.starts_with('(') {
            return span;
        }
        loop {
            let inner = rest.trim_start_matches(|c: char| c == '(' || c.is_whitespace());
            rest = match inner.strip_prefix('#') {
                Some(comment) => &comment[comment.find('\n').unwrap_or(comment.len())..],
                None => inner,
            };
            if !rest.starts_with(['#', '(', ' ', '\n', '\t', '\r']) {
                break;
            }
        }
        if !rest.starts_with(name) {
            return span;
        }
        let start = span.end - rest.len() as u32;
        Span {
            start,
            end: start + name.len() as u32,
        }
    }

    fn event(&mut self, name: &str, span: Span, role: Role, binds: Option<(SymbolKind, TypeRef)>) {
        if span.end <= span.start {
            return;
        }
        self.events.push(NameEvent {
            name: name.into(),
            occurrence: Occurrence {
                span: self.without_parentheses(name, span),
                role,
                scope: self.scope,
            },
            binds,
        });
    }

    fn bind(&mut self, ident: &Ident, kind: SymbolKind, value: TypeRef) {
        self.bind_at(&ident.name, ident.span, kind, value);
    }

    fn bind_at(&mut self, name: &str, span: Span, kind: SymbolKind, value: TypeRef) {
        self.bound[self.scope].insert(name.into());
        self.event(name, span, Role::Bind, Some((kind, value)));
    }

    fn shape(&self, expr: &Expr) -> TypeRef {
        type_ref_of(expr, self.scope)
    }

    /// `limit` is where the text that follows the block begins.
    fn block(&mut self, body: &[Stmt], limit: u32) {
        for (index, statement) in body.iter().enumerate() {
            let next = body.get(index + 1).map_or(limit, |next| next.span.start);
            self.statement(statement, next);
        }
    }

    fn statement(&mut self, statement: &Stmt, limit: u32) {
        match &statement.kind {
            StmtKind::Expr(value) => self.expr(value),
            StmtKind::Print { values, .. } => self.exprs(values),
            StmtKind::Assign { targets, value } => {
                self.expr(value);
                let shape = self.shape(value);
                for target in targets {
                    self.target(target, Some(value), &shape);
                }
            }
            StmtKind::AugAssign { target, value, .. } => {
                self.expr(value);
                if let ExprKind::Name(name) = &target.kind {
                    let shape = TypeRef::Unknown;
                    self.bind_at(name, target.span, SymbolKind::Variable, shape);
                } else {
                    self.target(target, None, &TypeRef::Unknown);
                }
            }
            StmtKind::AnnAssign {
                target,
                annotation,
                value,
            } => {
                self.expr(annotation);
                value.iter().for_each(|value| self.expr(value));
                let declared = TypeRef::Call(Box::new(self.shape(annotation)));
                self.target(target, None, &declared);
            }
            StmtKind::Delete(targets) => {
                for target in targets {
                    match &target.kind {
                        ExprKind::Name(name) => {
                            self.bound[self.scope].insert(name.clone());
                            self.event(name, target.span, Role::Mention, None);
                        }
                        _ => self.expr(target),
                    }
                }
            }
            StmtKind::Return(value) => {
                if let Some(value) = value {
                    self.expr(value);
                    let shape = self.shape(value);
                    let scope = self.scope;
                    let mut functions = self.names.functions.iter_mut().rev();
                    if let Some(function) = functions.find(|f| f.scope == scope) {
                        function.returns.push(shape);
                    }
                }
            }
            StmtKind::Raise { exception, cause } => {
                exception.iter().chain(cause).for_each(|e| self.expr(e));
            }
            StmtKind::Assert { test, message } => {
                self.expr(test);
                message.iter().for_each(|message| self.expr(message));
            }
            StmtKind::Global(idents) => {
                for ident in idents {
                    self.names.scopes[self.scope]
                        .globals
                        .insert(ident.name.clone());
                    self.bound[0].insert(ident.name.clone());
                    self.event(&ident.name, ident.span, Role::Mention, None);
                }
            }
            StmtKind::Nonlocal(idents) => {
                for ident in idents {
                    self.names.scopes[self.scope]
                        .nonlocals
                        .insert(ident.name.clone());
                    self.event(&ident.name, ident.span, Role::Mention, None);
                }
            }
            StmtKind::Import(aliases) => aliases.iter().for_each(|alias| self.import(alias)),
            StmtKind::ImportFrom { module, names, .. } => {
                for alias in names {
                    let bound = alias.alias.as_ref().unwrap_or(&alias.name);
                    let shape = TypeRef::Member(module.name.clone(), alias.name.name.clone());
                    self.bind(bound, SymbolKind::Import, shape);
                }
            }
            StmtKind::Function(def) => self.function(def, statement.span, limit),
            StmtKind::Class(def) => self.class(def, statement.span, limit),
            _ => self.compound(statement, limit),
        }
    }

    fn import(&mut self, alias: &ImportAlias) {
        let whole = &alias.name.name;
        match &alias.alias {
            Some(bound) => self.bind(bound, SymbolKind::Import, TypeRef::Module(whole.clone())),
            None => {
                // `import os.path` binds `os`.
                let first = whole.split('.').next().unwrap_or(whole);
                let span = Span {
                    start: alias.name.span.start,
                    end: alias.name.span.start + first.len() as u32,
                };
                self.bind_at(
                    first,
                    span,
                    SymbolKind::Import,
                    TypeRef::Module(first.into()),
                );
            }
        }
    }

    fn compound(&mut self, statement: &Stmt, limit: u32) {
        match &statement.kind {
            StmtKind::If { branches, .. } => branches.iter().for_each(|(test, _)| self.expr(test)),
            StmtKind::While { test, .. } => self.expr(test),
            StmtKind::For {
                target, iterable, ..
            } => {
                self.expr(iterable);
                let item = TypeRef::Item(Box::new(self.shape(iterable)));
                self.target(target, None, &item);
            }
            StmtKind::With { items, .. } => {
                for item in items {
                    self.expr(&item.context);
                    let shape = self.shape(&item.context);
                    if let Some(target) = &item.target {
                        self.target(target, None, &shape);
                    }
                }
            }
            StmtKind::Try { handlers, .. } => {
                for handler in handlers {
                    handler.exception.iter().for_each(|e| self.expr(e));
                    if let Some(name) = &handler.name {
                        let class = handler.exception.as_ref().map(|e| self.shape(e));
                        let shape = TypeRef::Call(Box::new(class.unwrap_or(TypeRef::Unknown)));
                        self.bind(name, SymbolKind::Variable, shape);
                    }
                }
            }
            _ => {}
        }
        let bodies = blocks(statement);
        for (index, body) in bodies.iter().enumerate() {
            let after = bodies[index + 1..].iter().find_map(|body| body.first());
            let next = after.map_or(limit, |next| next.span.start);
            self.block(body, next);
        }
    }

    fn parameters(&mut self, parameters: &Parameters) -> Vec<ParameterInfo> {
        let mut found = Vec::new();
        let groups = [
            (&parameters.positional_only[..], "", true, false),
            (&parameters.positional[..], "", false, false),
            (parameters.star.as_slice(), "*", false, false),
            (&parameters.keyword_only[..], "", false, true),
            (parameters.double_star.as_slice(), "**", false, false),
        ];
        for (group, star, is_positional_only, is_keyword_only) in groups {
            for parameter in group {
                let mut written = format!("{star}{}", parameter.name.name);
                if let Some(annotation) = &parameter.annotation {
                    written.push_str(": ");
                    written.push_str(&self.written(annotation.span));
                }
                if let Some(default) = &parameter.default {
                    written.push('=');
                    written.push_str(&self.written(default.span));
                }
                found.push(ParameterInfo {
                    name: parameter.name.name.clone(),
                    source_text: written.into(),
                    is_rest: !star.is_empty(),
                    is_keyword_only,
                    is_positional_only,
                    is_required: parameter.default.is_none() && star.is_empty(),
                });
            }
        }
        found
    }

    /// A piece of the text for people: on one line, not too long.
    fn written(&self, span: Span) -> String {
        let text = self.text.get(span.range()).unwrap_or("");
        match text.len() > WRITTEN_MAX || text.contains('\n') {
            true => "…".to_owned(),
            false => text.to_owned(),
        }
    }

    fn function(&mut self, def: &FunctionDef, span: Span, limit: u32) {
        self.exprs(&def.decorators);
        let parameters = def.parameters.iter();
        for parameter in parameters {
            let parts = parameter.default.iter().chain(&parameter.annotation);
            parts.for_each(|part| self.expr(part));
        }
        def.returns.iter().for_each(|returns| self.expr(returns));
        let decorated = |word: &str| {
            def.decorators
                .iter()
                .any(|d| matches!(&d.kind, ExprKind::Name(name) if &**name == word))
        };
        let class = self.class_here();
        let index = self.names.functions.len();
        let info = FunctionInfo {
            name: def.name.name.clone(),
            name_span: def.name.span,
            span,
            scope: self.names.scopes.len(),
            class,
            is_static: decorated("staticmethod"),
            is_property: decorated("property"),
            is_secondary: def.secondary,
            parameters: self.parameters(&def.parameters),
            returns: Vec::new(),
            doc: docstring(&def.body),
        };
        self.names.functions.push(info);
        self.bind(&def.name, SymbolKind::Function, TypeRef::Function(index));
        if let Some(class) = class {
            self.attribute_of(class, &def.name, TypeRef::Function(index), Some(index));
        }
        let is_class_method = decorated("classmethod");
        let is_static = decorated("staticmethod");
        self.in_scope(ScopeKind::Function, span, limit, |inner, scope| {
            for (position, parameter) in def.parameters.iter().enumerate() {
                let shape = match (class, position) {
                    (Some(class), 0) if is_class_method => TypeRef::Class(class),
                    (Some(class), 0) if !is_static => TypeRef::Instance(class),
                    _ => match (&parameter.annotation, &parameter.default) {
                        (Some(annotation), _) => {
                            let outer = inner.names.scopes[scope].parent.unwrap_or(0);
                            TypeRef::Call(Box::new(type_ref_of(annotation, outer)))
                        }
                        (None, Some(default)) => type_ref_of(default, scope),
                        _ => TypeRef::Unknown,
                    },
                };
                inner.bind(&parameter.name, SymbolKind::Parameter, shape);
            }
            if let Some(returns) = &def.returns {
                let shape = TypeRef::Call(Box::new(type_ref_of(returns, scope)));
                inner.names.functions[index].returns.push(shape);
            }
            inner.block(&def.body, limit);
        });
    }

    /// The class whose body is being read.
    fn class_here(&self) -> Option<usize> {
        let is_class = self.names.scopes[self.scope].kind == ScopeKind::Class;
        let classes = &self.names.classes;
        let found = classes.iter().rposition(|class| class.scope == self.scope);
        found.filter(|_| is_class)
    }

    fn attribute_of(
        &mut self,
        class: usize,
        name: &Ident,
        value: TypeRef,
        function: Option<usize>,
    ) {
        let attributes = &mut self.names.classes[class].attributes;
        match attributes.iter_mut().find(|known| known.name == name.name) {
            Some(known) => {
                known.places.push(name.span);
                known.values.push(value);
                known.function = known.function.or(function);
            }
            None => attributes.push(AttributeInfo {
                name: name.name.clone(),
                places: vec![name.span],
                values: vec![value],
                function,
            }),
        }
    }

    fn class(&mut self, def: &ClassDef, span: Span, limit: u32) {
        self.exprs(&def.decorators);
        self.arguments(&def.args, None);
        let bases = def.args.iter().filter_map(|arg| match arg {
            Arg::Positional(base) => Some(self.shape(base)),
            _ => None,
        });
        let info = ClassInfo {
            name: def.name.name.clone(),
            name_span: def.name.span,
            span,
            scope: self.names.scopes.len(),
            bases: bases.collect(),
            attributes: Vec::new(),
            doc: docstring(&def.body),
        };
        let index = self.names.classes.len();
        self.names.classes.push(info);
        self.bind(&def.name, SymbolKind::Class, TypeRef::Class(index));
        self.in_scope(ScopeKind::Class, span, limit, |inner, _| {
            inner.block(&def.body, limit);
        });
    }

    /// Assigning to `target`; `value` is what is assigned where it can be taken apart.
    fn target(&mut self, target: &Expr, value: Option<&Expr>, shape: &TypeRef) {
        match &target.kind {
            ExprKind::Name(name) => {
                self.bind_at(name, target.span, SymbolKind::Variable, shape.clone());
                if let Some(class) = self.class_here() {
                    let ident = Ident {
                        name: name.clone(),
                        span: self.without_parentheses(name, target.span),
                    };
                    self.attribute_of(class, &ident, shape.clone(), None);
                }
            }
            ExprKind::Tuple(items) | ExprKind::List(items) => {
                let values = match value.map(|value| &value.kind) {
                    Some(ExprKind::Tuple(v) | ExprKind::List(v)) if v.len() == items.len() => {
                        Some(v)
                    }
                    _ => None,
                };
                for (index, item) in items.iter().enumerate() {
                    let value = values.map(|values| &values[index]);
                    let part = match value {
                        Some(value) => self.shape(value),
                        None => TypeRef::Item(Box::new(shape.clone())),
                    };
                    self.target(item, value, &part);
                }
            }
            ExprKind::Starred(inner) => self.target(inner, None, &TypeRef::Value("list")),
            ExprKind::Attribute { value: of, name } => {
                self.expr(of);
                self.attribute_use(of, name, true);
                if let TypeRef::Name(scope, receiver) = self.shape(of)
                    && let Some(class) = self.instance_class(scope, &receiver)
                {
                    self.attribute_of(class, name, shape.clone(), None);
                }
            }
            _ => self.expr(target),
        }
    }

    /// The class whose instance a method knows by this name: its first parameter.
    fn instance_class(&self, scope: ScopeId, receiver: &str) -> Option<usize> {
        let function = self.names.functions.iter().rfind(|f| f.scope == scope)?;
        let first = function.parameters.first()?;
        (&*first.name == receiver && !function.is_static)
            .then_some(function.class)
            .flatten()
    }

    fn attribute_use(&mut self, value: &Expr, name: &Ident, is_bound: bool) {
        let value = self.shape(value);
        self.names.attribute_uses.push(AttributeUse {
            value,
            name: name.name.clone(),
            span: name.span,
            is_bound,
        });
    }

    fn exprs(&mut self, exprs: &[Expr]) {
        exprs.iter().for_each(|expr| self.expr(expr));
    }

    fn arguments(&mut self, args: &[Arg], function: Option<&Expr>) {
        let first = args.iter().find_map(|arg| match arg {
            Arg::Positional(value) => Some(self.shape(value)),
            _ => None,
        });
        for arg in args {
            let (name, span, value) = match arg {
                Arg::Positional(value) | Arg::Star(value) => {
                    self.expr(value);
                    continue;
                }
                Arg::DoubleStar(value) => ("**", value.span, value),
                Arg::Keyword(name, value) => (&*name.name, name.span, value),
            };
            if let Some(function) = function {
                let function = self.shape(function);
                self.names.keyword_uses.push(KeywordUse {
                    function,
                    first: first.clone(),
                    name: name.into(),
                    span,
                });
            }
            self.expr(value);
        }
    }

    fn expr(&mut self, expr: &Expr) {
        match &expr.kind {
            ExprKind::Name(name) => self.event(name, expr.span, Role::Read, None),
            ExprKind::Attribute { value, name } => {
                self.expr(value);
                self.attribute_use(value, name, false);
            }
            ExprKind::Call { function, args } => {
                self.expr(function);
                self.arguments(args, Some(function));
            }
            ExprKind::Named { target, value } => {
                self.expr(value);
                let shape = self.shape(value);
                let inner = self.scope;
                while self.names.scopes[self.scope].kind == ScopeKind::Comprehension {
                    self.scope = self.names.scopes[self.scope].parent.unwrap_or(0);
                }
                self.bind(target, SymbolKind::Variable, shape);
                self.scope = inner;
            }
            ExprKind::Lambda(lambda) => {
                let parameters = lambda.parameters.iter();
                parameters
                    .filter_map(|p| p.default.as_ref())
                    .for_each(|default| self.expr(default));
                self.in_scope(ScopeKind::Function, expr.span, 0, |inner, _| {
                    for parameter in lambda.parameters.iter() {
                        inner.bind(&parameter.name, SymbolKind::Parameter, TypeRef::Unknown);
                    }
                    inner.expr(&lambda.body);
                });
            }
            ExprKind::Comprehension(comprehension) => self.comprehension(comprehension, expr.span),
            ExprKind::FString(format) => self.fstring(format),
            ExprKind::Dict(items) => items.iter().for_each(|item| match item {
                DictItem::Pair(key, value) => {
                    self.expr(key);
                    self.expr(value);
                }
                DictItem::Unpack(mapping) => self.expr(mapping),
            }),
            _ => elite_syntax::ast::visit::parts(expr, &mut |part| self.expr(part)),
        }
    }

    fn fstring(&mut self, format: &[FStringPart]) {
        for part in format {
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
        let item = TypeRef::Item(Box::new(self.shape(&first.iterable)));
        self.in_scope(ScopeKind::Comprehension, span, 0, |inner, _| {
            inner.target(&first.target, None, &item);
            inner.exprs(&first.conditions);
            for clause in rest {
                inner.expr(&clause.iterable);
                let item = TypeRef::Item(Box::new(inner.shape(&clause.iterable)));
                inner.target(&clause.target, None, &item);
                inner.exprs(&clause.conditions);
            }
            match &comprehension.kind {
                ComprehensionKind::List(value)
                | ComprehensionKind::Set(value)
                | ComprehensionKind::Generator(value) => inner.expr(value),
                ComprehensionKind::Dict(key, value) => {
                    inner.expr(key);
                    inner.expr(value);
                }
            }
        });
    }

    /// Gives every place of a name its symbol, if that is one of a scope within the piece.
    fn finish(mut self) -> UnitNames {
        let mut events = std::mem::take(&mut self.events);
        events.sort_by_key(|event| event.occurrence.span.start);
        let mut numbers: HashMap<Box<str>, usize> = HashMap::new();
        for event in events {
            let occurrence = event.occurrence;
            let place = self.names.places.len();
            let symbol = match self.home(&event.name, occurrence.scope) {
                Some(home) => {
                    let symbol = self.symbol(&event.name, home);
                    self.names.symbols[symbol].take(occurrence, event.binds);
                    Some(symbol)
                }
                None => {
                    let known = numbers.get(&event.name).copied();
                    let name = known.unwrap_or_else(|| {
                        let number = self.names.outward_names.len();
                        self.names.outward_names.push(event.name.clone());
                        numbers.insert(event.name, number);
                        number
                    });
                    self.names.outward.push(UnresolvedName {
                        name,
                        place,
                        role: occurrence.role,
                        binds: event.binds,
                    });
                    None
                }
            };
            self.names.places.push((occurrence, symbol));
        }
        self.names.bound = std::mem::take(&mut self.bound[0]).into_iter().collect();
        self.names.bound.sort_unstable();
        self.names
    }

    /// The symbol of a name in the scope that binds it.
    fn symbol(&mut self, name: &str, home: ScopeId) -> SymbolId {
        if let Some(known) = self.names.scopes[home].symbols.get(name) {
            return *known;
        }
        let id = self.names.symbols.len();
        self.names.symbols.push(Symbol::new(name, home));
        self.names.scopes[home].symbols.insert(name.into(), id);
        id
    }

    /// The scope within the piece whose name it is.
    fn home(&self, name: &str, scope: ScopeId) -> Option<ScopeId> {
        let mut at = Some(scope).filter(|scope| *scope != 0);
        while let Some(id) = at {
            let here = &self.names.scopes[id];
            if here.globals.contains(name) {
                return None;
            }
            let visible = here.kind != ScopeKind::Class || id == scope;
            if visible && !here.nonlocals.contains(name) && self.bound[id].contains(name) {
                return Some(id);
            }
            at = here.parent.filter(|parent| *parent != 0);
        }
        None
    }
}
