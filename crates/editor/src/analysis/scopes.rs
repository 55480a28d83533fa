//! The names of a program: its scopes, what each binds, and every place where a name stands.
//!
//! Owns the tables and how names are looked up in them, by Python's rules. What fills them is `collect`, what keeps
//! them while a text is written `incremental`; what values names
//! have is `types`.

use std::collections::{HashMap, HashSet};

use elite_syntax::Span;

use super::incremental::UnitIndex;
use super::types::TypeRef;

/// Number of a scope; the module is 0.
pub type ScopeId = usize;
/// Number of a symbol.
pub type SymbolId = usize;

/// What kind of text a scope is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScopeKind {
    /// The whole program.
    Module,
    /// A function or a lambda.
    Function,
    /// A class body.
    Class,
    /// A comprehension or generator expression.
    Comprehension,
}

/// A scope.
#[derive(Debug)]
pub struct Scope {
    /// What it is.
    pub kind: ScopeKind,
    /// The scope around it.
    pub parent: Option<ScopeId>,
    /// Text of the scope, the header included.
    pub span: Span,
    /// Where the text that could still be added to it ends: the start of what follows.
    pub limit: u32,
    /// The column of its header, in blanks.
    pub column: u32,
    /// The names it binds.
    pub symbols: HashMap<Box<str>, SymbolId>,
    pub(super) globals: HashSet<Box<str>>,
    pub(super) nonlocals: HashSet<Box<str>>,
    /// The text of the scope ends its piece of the program: `limit` is where the next statement of the top level
    /// begins.
    pub(super) is_open: bool,
}

impl Scope {
    /// A scope that binds nothing.
    pub(super) fn new(kind: ScopeKind, parent: Option<ScopeId>, span: Span) -> Self {
        Scope {
            kind,
            parent,
            span,
            limit: span.end,
            column: 0,
            symbols: HashMap::new(),
            globals: HashSet::new(),
            nonlocals: HashSet::new(),
            is_open: false,
        }
    }
}

/// What a symbol is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SymbolKind {
    /// Bound by an assignment, a loop and the like.
    Variable,
    /// A parameter.
    Parameter,
    /// A `def` or `sec`.
    Function,
    /// A `class`.
    Class,
    /// An import.
    Import,
}

/// What happens to a name at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// The name is bound.
    Bind,
    /// The name is used.
    Read,
    /// A `global` or `nonlocal` statement has the name, or `del` removes it.
    Mention,
}

/// A place where a name stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Occurrence {
    /// Place of the name in the text.
    pub span: Span,
    /// What happens to the name there.
    pub role: Role,
    /// The scope it stands in.
    pub scope: ScopeId,
}

/// A name that a program binds.
#[derive(Debug)]
pub struct Symbol {
    /// The name as it is written.
    pub name: Box<str>,
    /// The scope whose name it is.
    pub scope: ScopeId,
    /// What it is.
    pub kind: SymbolKind,
    /// Every place of it, in the order of the text.
    pub occurrences: Vec<Occurrence>,
    /// What it is bound to, as far as the text tells.
    pub values: Vec<TypeRef>,
}

impl Symbol {
    /// A name without places.
    pub(super) fn new(name: &str, scope: ScopeId) -> Self {
        Symbol {
            name: name.into(),
            scope,
            kind: SymbolKind::Variable,
            occurrences: Vec::new(),
            values: Vec::new(),
        }
    }

    /// Notes the next place of it.
    pub(super) fn take(&mut self, place: Occurrence, binds: Option<(SymbolKind, TypeRef)>) {
        if let Some((kind, value)) = binds {
            let is_first = self.bindings().next().is_none();
            if is_first || matches!(kind, SymbolKind::Function | SymbolKind::Class) {
                self.kind = kind;
            }
            self.values.push(value);
        }
        self.occurrences.push(place);
    }

    /// The places where it is bound, first the declaration.
    pub fn bindings(&self) -> impl Iterator<Item = &Occurrence> {
        self.occurrences.iter().filter(|o| o.role == Role::Bind)
    }
}

/// A parameter of a function.
#[derive(Clone, Debug)]
pub struct ParameterInfo {
    /// Name of the parameter.
    pub name: Box<str>,
    /// How it is written: with star, annotation and default.
    pub source_text: Box<str>,
    /// `*args`, `**kwargs`.
    pub is_rest: bool,
    /// The parameter cannot be given by position.
    pub is_keyword_only: bool,
    /// The parameter cannot be given by name.
    pub is_positional_only: bool,
    /// The parameter has no default.
    pub is_required: bool,
}

/// A function of the program.
#[derive(Debug)]
pub struct FunctionInfo {
    /// Name of the function.
    pub name: Box<str>,
    /// Place of the name in the text.
    pub name_span: Span,
    /// The whole definition.
    pub span: Span,
    /// Scope of the function's body.
    pub scope: ScopeId,
    /// The class it is a method of.
    pub class: Option<usize>,
    /// The function takes no instance: `@staticmethod`.
    pub is_static: bool,
    /// The function is read like a value: `@property`.
    pub is_property: bool,
    /// The function is headed by `sec`.
    pub is_secondary: bool,
    /// Parameters in the order of the text.
    pub parameters: Vec<ParameterInfo>,
    /// What it returns.
    pub returns: Vec<TypeRef>,
    /// Docstring of the function.
    pub doc: Option<Box<str>>,
}

impl FunctionInfo {
    /// The parameters that callers give: without the instance of a method.
    pub fn called_with(&self) -> &[ParameterInfo] {
        match self.class.is_some() && !self.is_static {
            true => self.parameters.get(1..).unwrap_or(&[]),
            false => &self.parameters,
        }
    }

    /// `name(a, b=1)` as callers see it.
    pub fn signature(&self) -> String {
        let written: Vec<&str> = self.called_with().iter().map(|p| &*p.source_text).collect();
        format!("{}({})", self.name, written.join(", "))
    }
}

/// An attribute of a class or of its instances.
#[derive(Debug)]
pub struct AttributeInfo {
    /// Name of the attribute.
    pub name: Box<str>,
    /// Places where the attribute is bound, in the order of the text.
    pub places: Vec<Span>,
    /// What it is bound to.
    pub values: Vec<TypeRef>,
    /// The function, if it is a method.
    pub function: Option<usize>,
}

/// A class of the program.
#[derive(Debug)]
pub struct ClassInfo {
    /// Name of the class.
    pub name: Box<str>,
    /// Place of the name in the text.
    pub name_span: Span,
    /// The whole definition.
    pub span: Span,
    /// Scope of the class's body.
    pub scope: ScopeId,
    /// The classes it is derived from.
    pub bases: Vec<TypeRef>,
    /// What it and its instances have, in the order of the text.
    pub attributes: Vec<AttributeInfo>,
    /// Docstring of the class.
    pub doc: Option<Box<str>>,
}

impl ClassInfo {
    /// The attribute of this name that the class itself has, not a base.
    pub fn attribute(&self, name: &str) -> Option<&AttributeInfo> {
        self.attributes.iter().find(|a| &*a.name == name)
    }
}

/// `value.name` in the text.
#[derive(Debug)]
pub struct AttributeUse {
    /// What the attribute is of.
    pub value: TypeRef,
    /// The attribute.
    pub name: Box<str>,
    /// Place of the attribute's name in the text.
    pub span: Span,
    /// Whether it is assigned to.
    pub is_bound: bool,
}

/// `name=` in a call.
#[derive(Debug)]
pub struct KeywordUse {
    /// What is called.
    pub function: TypeRef,
    /// The first argument of the call by position: what `partial` calls later, what `replace` copies.
    pub first: Option<TypeRef>,
    /// The keyword, or `**` for names that a mapping brings.
    pub name: Box<str>,
    /// Place of the keyword in the text.
    pub span: Span,
}

/// All names of a program.
#[derive(Debug, Default)]
pub struct NameTables {
    /// The scopes; the first is the module.
    pub scopes: Vec<Scope>,
    /// The names that they bind, those of the module last.
    pub symbols: Vec<Symbol>,
    /// The functions, in the order of the text.
    pub functions: Vec<FunctionInfo>,
    /// The classes, in the order of the text.
    pub classes: Vec<ClassInfo>,
    /// Attributes in the text.
    pub attribute_uses: Vec<AttributeUse>,
    /// Keyword arguments in the text.
    pub keyword_uses: Vec<KeywordUse>,
    /// Names that the program does not bind: builtins, and those that nothing defines.
    pub foreign: HashMap<Box<str>, Vec<Occurrence>>,
    /// Every place of a name with its symbol (none: foreign), in the order of the text.
    pub(super) places: Vec<(Occurrence, Option<SymbolId>)>,
    /// The piece of the text that each entry of these tables belongs to.
    pub(super) parts: UnitIndex,
}

impl NameTables {
    /// The symbol that `name` means in `scope`.
    pub fn lookup(&self, scope: ScopeId, name: &str) -> Option<SymbolId> {
        let mut at = Some(scope);
        let mut skip_own = false;
        while let Some(id) = at {
            let here = self.scopes.get(id)?;
            if !skip_own && here.globals.contains(name) {
                return self.scopes.first()?.symbols.get(name).copied();
            }
            let outward = here.nonlocals.contains(name);
            let visible = here.kind != ScopeKind::Class || id == scope;
            if !outward
                && visible
                && let Some(symbol) = here.symbols.get(name)
            {
                return Some(*symbol);
            }
            skip_own = true;
            at = here.parent;
        }
        None
    }

    /// The place of a name at `offset`, its end included, and the symbol.
    pub fn occurrence_at(&self, offset: u32) -> Option<(Occurrence, Option<SymbolId>)> {
        let after = self.places.partition_point(|(o, _)| o.span.start <= offset);
        let candidates = self.places[..after].iter().rev().take(4);
        let mut hits = candidates.filter(|(o, _)| offset <= o.span.end);
        hits.next().copied()
    }

    /// Every place of a name, in the order of the text.
    pub fn places(&self) -> &[(Occurrence, Option<SymbolId>)] {
        &self.places
    }

    /// The innermost scope at `offset`. Behind the text of a block, `column` decides whether a line still belongs to
    /// it.
    pub fn scope_at(&self, offset: u32, column: u32) -> ScopeId {
        let inside = |scope: &Scope| {
            let within = scope.span.start <= offset && offset <= scope.span.end;
            let behind = scope.span.end < offset && offset <= scope.limit;
            let is_block = matches!(scope.kind, ScopeKind::Function | ScopeKind::Class);
            within && (offset < scope.span.end || !is_block || column > scope.column)
                || behind && is_block && column > scope.column
        };
        let found = self.scopes.iter().enumerate().rev();
        // Inner scopes come after those around them.
        let mut found = found.filter(|(_, scope)| inside(scope));
        found.next().map_or(0, |(id, _)| id)
    }

    /// The symbols that can be named in `scope`, inner ones first; shadowed ones are left out.
    pub fn visible(&self, scope: ScopeId) -> Vec<SymbolId> {
        let mut seen = HashSet::new();
        let mut found = Vec::new();
        let mut at = Some(scope);
        while let Some(id) = at {
            let Some(here) = self.scopes.get(id) else {
                break;
            };
            if here.kind != ScopeKind::Class || id == scope {
                let mut own: Vec<SymbolId> = here.symbols.values().copied().collect();
                own.sort_unstable();
                found.extend(
                    own.into_iter()
                        .filter(|s| seen.insert(&*self.symbols[*s].name)),
                );
            }
            at = here.parent;
        }
        found
    }

    /// The function whose own scope this is.
    pub fn function_of(&self, scope: ScopeId) -> Option<usize> {
        self.functions.iter().position(|f| f.scope == scope)
    }

    /// The class in whose methods, or body, `scope` lies.
    pub fn class_around(&self, scope: ScopeId) -> Option<usize> {
        let mut at = Some(scope);
        while let Some(id) = at {
            let here = self.scopes.get(id)?;
            if here.kind == ScopeKind::Class {
                return self.classes.iter().position(|class| class.scope == id);
            }
            at = here.parent;
        }
        None
    }
}
