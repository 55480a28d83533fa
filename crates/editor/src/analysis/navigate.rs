//! From a place to other places: definitions, references, highlights.

use elite_syntax::Span;

use super::Analysis;
use super::hover::{attribute_at, touches};
use super::scopes::{AttributeUse, KeywordUse, Role, SymbolId, SymbolKind};
use super::types::{Type, TypeRef, attribute_of};

/// A place where something is named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Reference {
    /// Place of the name in the text.
    pub span: Span,
    /// The name is bound at this place.
    pub is_bound: bool,
}

/// What a place names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NamedEntity {
    /// A name that the program binds.
    Symbol(SymbolId),
    /// An attribute of a class of the program.
    Attribute(usize, Box<str>),
    /// A name that the program does not bind.
    Foreign(Box<str>),
}

/// What is named at `offset`, and where its name stands.
pub fn entity_at(analysis: &Analysis, offset: u32) -> Option<(NamedEntity, Span)> {
    let names = &analysis.names;
    if let Some(used) = attribute_at(analysis, offset) {
        let class = owner_of(analysis, used)?;
        return Some((NamedEntity::Attribute(class, used.name.clone()), used.span));
    }
    if let Some((occurrence, symbol)) = names.occurrence_at(offset) {
        let written = analysis.file.slice(occurrence.span);
        let named = match symbol {
            Some(symbol) => {
                class_attribute(analysis, symbol).unwrap_or(NamedEntity::Symbol(symbol))
            }
            None => NamedEntity::Foreign(written.into()),
        };
        return Some((named, occurrence.span));
    }
    let mut keywords = names.keyword_uses.iter();
    if let Some(used) = keywords.find(|k| &*k.name != "**" && touches(k.span, offset)) {
        let KeywordOwner::Known(named) = keyword_of(analysis, used) else {
            return None;
        };
        return Some((named, used.span));
    }
    // A name in a line that does not parse.
    let token = analysis.token_at(offset)?;
    if token.kind != elite_syntax::lexer::TokenKind::Name || after_dot(analysis, token.span) {
        return None;
    }
    let written = analysis.file.slice(token.span);
    let named = match names.lookup(analysis.scope_at(offset), written) {
        Some(symbol) => NamedEntity::Symbol(symbol),
        None => NamedEntity::Foreign(written.into()),
    };
    Some((named, token.span))
}

fn after_dot(analysis: &Analysis, span: Span) -> bool {
    let before = &analysis.text()[..span.start as usize];
    before.trim_end().ends_with('.')
}

/// A name of a class body is an attribute of the class.
fn class_attribute(analysis: &Analysis, symbol: SymbolId) -> Option<NamedEntity> {
    let symbol = &analysis.names.symbols[symbol];
    let classes = &analysis.names.classes;
    let class = classes
        .iter()
        .position(|class| class.scope == symbol.scope)?;
    Some(NamedEntity::Attribute(class, symbol.name.clone()))
}

/// The class of the program that has the attribute of a use; the first one that has it, among those it is derived from.
fn owner_of(analysis: &Analysis, used: &AttributeUse) -> Option<usize> {
    let (Type::Instance(class) | Type::Class(class)) = analysis.infer(&used.value) else {
        return None;
    };
    let (owner, _) = attribute_of(&analysis.names, class, &used.name)?;
    Some(owner)
}

/// What a keyword argument is for.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum KeywordOwner {
    /// A parameter of the program, or an attribute of a class that makes its own parameters of them, as data classes
    /// do.
    Known(NamedEntity),
    /// Something that is not the program's, or nothing.
    Foreign,
    /// Nobody can tell.
    Unknown,
}

/// What a keyword argument is for.
pub(super) fn keyword_of(analysis: &Analysis, used: &KeywordUse) -> KeywordOwner {
    let names = &analysis.names;
    let instance = |shape: &TypeRef| match analysis.infer(shape) {
        Type::Instance(class) => field_of(analysis, class, &used.name),
        Type::Unknown => KeywordOwner::Unknown,
        _ => KeywordOwner::Foreign,
    };
    if let TypeRef::Attribute(value, method) = &used.function
        && &**method == "_replace"
        && let Type::Instance(class) = analysis.infer(value)
        && attribute_of(names, class, method).is_none()
    {
        return field_of(analysis, class, &used.name);
    }
    match (analysis.infer(&used.function), &used.first) {
        (Type::Member(module, name), Some(first)) => match (&*module, &*name) {
            ("functools", "partial" | "partialmethod") => {
                keyword_of_call(analysis, &analysis.infer(first), &used.name)
            }
            ("dataclasses" | "copy", "replace") => instance(first),
            _ => KeywordOwner::Foreign,
        },
        (function, _) => keyword_of_call(analysis, &function, &used.name),
    }
}

fn keyword_of_call(analysis: &Analysis, function: &Type, name: &str) -> KeywordOwner {
    let names = &analysis.names;
    match function {
        Type::Unknown => KeywordOwner::Unknown,
        Type::Function(function) => parameter_of(analysis, *function, name),
        Type::Class(class) => {
            let makes = |method| attribute_of(names, *class, method);
            match makes("__init__").or_else(|| makes("__new__")) {
                Some((_, method)) => match method.function {
                    Some(function) => parameter_of(analysis, function, name),
                    None => KeywordOwner::Unknown,
                },
                None => field_of(analysis, *class, name),
            }
        }
        Type::Instance(class) => match attribute_of(names, *class, "__call__") {
            Some((_, method)) if let Some(function) = method.function => {
                parameter_of(analysis, function, name)
            }
            _ => KeywordOwner::Unknown,
        },
        _ => KeywordOwner::Foreign,
    }
}

/// The parameter of this name; a function that takes all names may hand it on to anybody.
fn parameter_of(analysis: &Analysis, function: usize, name: &str) -> KeywordOwner {
    let names = &analysis.names;
    let Some(info) = names.functions.get(function) else {
        return KeywordOwner::Unknown;
    };
    let own = names.scopes.get(info.scope);
    let symbol = own.and_then(|scope| scope.symbols.get(name)).copied();
    match symbol.filter(|symbol| names.symbols[*symbol].kind == SymbolKind::Parameter) {
        Some(symbol) => KeywordOwner::Known(NamedEntity::Symbol(symbol)),
        None if info
            .parameters
            .iter()
            .any(|p| p.source_text.starts_with("**")) =>
        {
            KeywordOwner::Unknown
        }
        None => KeywordOwner::Foreign,
    }
}

/// The attribute of this name that a class without `__init__` takes by name.
fn field_of(analysis: &Analysis, class: usize, name: &str) -> KeywordOwner {
    match attribute_of(&analysis.names, class, name) {
        Some((owner, _)) => KeywordOwner::Known(NamedEntity::Attribute(owner, name.into())),
        None => KeywordOwner::Unknown,
    }
}

/// Places where the thing at `offset` is defined.
pub fn definition(analysis: &Analysis, offset: u32) -> Vec<Span> {
    let names = &analysis.names;
    match entity_at(analysis, offset) {
        Some((NamedEntity::Symbol(symbol), _)) => {
            let symbol = &names.symbols[symbol];
            let all = symbol.bindings().map(|o| o.span);
            match symbol.kind {
                // Every definition counts, of variables the first.
                SymbolKind::Function | SymbolKind::Class => all.collect(),
                _ => all.take(1).collect(),
            }
        }
        Some((NamedEntity::Attribute(class, name), _)) => {
            let attribute = names.classes[class].attribute(&name);
            let places = attribute.iter().flat_map(|attribute| &attribute.places);
            places.take(1).copied().collect()
        }
        _ => Vec::new(),
    }
}

/// Every place that names what is named at `offset`, in the order of the text.
pub fn references(analysis: &Analysis, offset: u32) -> Vec<Reference> {
    match entity_at(analysis, offset) {
        Some((named, _)) => references_of(analysis, &named),
        None => Vec::new(),
    }
}

/// Every place that names something, in the order of the text.
pub fn references_of(analysis: &Analysis, named: &NamedEntity) -> Vec<Reference> {
    let names = &analysis.names;
    let mut found = Vec::new();
    let mut put = |span: Span, is_bound: bool| {
        found.push(Reference { span, is_bound });
    };
    match named {
        NamedEntity::Symbol(symbol) => {
            for occurrence in &names.symbols[*symbol].occurrences {
                put(occurrence.span, occurrence.role == Role::Bind);
            }
            if names.symbols[*symbol].kind == SymbolKind::Parameter {
                for used in keywords_of(analysis, named, &names.symbols[*symbol].name) {
                    put(used.span, false);
                }
            }
        }
        NamedEntity::Attribute(class, name) => {
            let info = &names.classes[*class];
            if let Some(symbol) = names.scopes[info.scope].symbols.get(name) {
                for occurrence in &names.symbols[*symbol].occurrences {
                    put(occurrence.span, occurrence.role == Role::Bind);
                }
            }
            let uses = names
                .attribute_uses
                .iter()
                .filter(|used| used.name == *name);
            for used in uses.filter(|used| owner_of(analysis, used) == Some(*class)) {
                put(used.span, used.is_bound);
            }
            for used in keywords_of(analysis, named, name) {
                put(used.span, false);
            }
        }
        NamedEntity::Foreign(name) => {
            for occurrence in names.foreign.get(name).into_iter().flatten() {
                put(occurrence.span, false);
            }
        }
    }
    found.sort_by_key(|place| (place.span.start, !place.is_bound));
    found.dedup_by_key(|place| place.span);
    found
}

/// The keyword arguments that name something.
fn keywords_of<'a>(
    analysis: &'a Analysis,
    named: &NamedEntity,
    name: &str,
) -> impl Iterator<Item = &'a KeywordUse> {
    let uses = analysis.names.keyword_uses.iter();
    uses.filter(move |used| {
        &*used.name == name
            && matches!(keyword_of(analysis, used), KeywordOwner::Known(of) if of == *named)
    })
}
