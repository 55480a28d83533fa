//! From a place to other places: definitions, references, highlights.

use elite_lang::Span;

use super::Analysis;
use super::hover::{attribute_at, touches};
use super::scopes::{AttributeUse, KeywordUse, Role, SymbolId, SymbolKind};
use super::types::{Type, attribute_of};

/// A place where something is named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Where.
    pub span: Span,
    /// It is bound there.
    pub is_bound: bool,
}

/// What a place names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Named {
    /// A name that the program binds.
    Symbol(SymbolId),
    /// An attribute of a class of the program.
    Attribute(usize, Box<str>),
    /// A name that the program does not bind.
    Foreign(Box<str>),
}

/// What is named at `offset`, and where its name stands.
pub fn named(analysis: &Analysis, offset: u32) -> Option<(Named, Span)> {
    let names = &analysis.names;
    if let Some(used) = attribute_at(analysis, offset) {
        let class = owner_of(analysis, used)?;
        return Some((Named::Attribute(class, used.name.clone()), used.span));
    }
    if let Some((occurrence, symbol)) = names.place_at(offset) {
        let written = analysis.file.slice(occurrence.span);
        let named = match symbol {
            Some(symbol) => class_attribute(analysis, symbol).unwrap_or(Named::Symbol(symbol)),
            None => Named::Foreign(written.into()),
        };
        return Some((named, occurrence.span));
    }
    if let Some(used) = names.keyword_uses.iter().find(|k| touches(k.span, offset)) {
        return Some((Named::Symbol(parameter_of(analysis, used)?), used.span));
    }
    // A name in a line that does not parse.
    let token = analysis.token_at(offset)?;
    if token.kind != elite_lang::syntax::TokenKind::Name || after_dot(analysis, token.span) {
        return None;
    }
    let written = analysis.file.slice(token.span);
    let named = match names.lookup(analysis.scope_at(offset), written) {
        Some(symbol) => Named::Symbol(symbol),
        None => Named::Foreign(written.into()),
    };
    Some((named, token.span))
}

fn after_dot(analysis: &Analysis, span: Span) -> bool {
    let before = &analysis.text()[..span.start as usize];
    before.trim_end().ends_with('.')
}

/// A name of a class body is an attribute of the class.
fn class_attribute(analysis: &Analysis, symbol: SymbolId) -> Option<Named> {
    let symbol = &analysis.names.symbols[symbol];
    let classes = &analysis.names.classes;
    let class = classes
        .iter()
        .position(|class| class.scope == symbol.scope)?;
    Some(Named::Attribute(class, symbol.name.clone()))
}

/// The class of the program that has the attribute of a use; the first one that has it, among those it is derived from.
fn owner_of(analysis: &Analysis, used: &AttributeUse) -> Option<usize> {
    let (Type::Instance(class) | Type::Class(class)) = analysis.infer(&used.value) else {
        return None;
    };
    let (owner, _) = attribute_of(&analysis.names, class, &used.name)?;
    Some(owner)
}

/// The parameter that a keyword argument is for.
fn parameter_of(analysis: &Analysis, used: &KeywordUse) -> Option<SymbolId> {
    let names = &analysis.names;
    let function = match analysis.infer(&used.function) {
        Type::Function(function) => function,
        Type::Class(class) => attribute_of(names, class, "__init__")?.1.function?,
        _ => return None,
    };
    let scope = names.functions.get(function)?.scope;
    let symbol = *names.scopes.get(scope)?.symbols.get(&used.name)?;
    (names.symbols[symbol].kind == SymbolKind::Parameter).then_some(symbol)
}

/// Where the thing at `offset` is defined.
pub fn definition(analysis: &Analysis, offset: u32) -> Vec<Span> {
    let names = &analysis.names;
    match named(analysis, offset) {
        Some((Named::Symbol(symbol), _)) => {
            let symbol = &names.symbols[symbol];
            let all = symbol.bindings().map(|o| o.span);
            match symbol.kind {
                // Every definition counts, of variables the first.
                SymbolKind::Function | SymbolKind::Class => all.collect(),
                _ => all.take(1).collect(),
            }
        }
        Some((Named::Attribute(class, name), _)) => {
            let attribute = names.classes[class].attribute(&name);
            let places = attribute.iter().flat_map(|attribute| &attribute.places);
            places.take(1).copied().collect()
        }
        _ => Vec::new(),
    }
}

/// Every place that names what is named at `offset`, in the order of the text.
pub fn references(analysis: &Analysis, offset: u32) -> Vec<Place> {
    match named(analysis, offset) {
        Some((named, _)) => places_of(analysis, &named),
        None => Vec::new(),
    }
}

/// Every place that names something, in the order of the text.
pub fn places_of(analysis: &Analysis, named: &Named) -> Vec<Place> {
    let names = &analysis.names;
    let mut found = Vec::new();
    let mut put = |span: Span, is_bound: bool| {
        found.push(Place { span, is_bound });
    };
    match named {
        Named::Symbol(symbol) => {
            for occurrence in &names.symbols[*symbol].occurrences {
                put(occurrence.span, occurrence.role == Role::Bind);
            }
            if names.symbols[*symbol].kind == SymbolKind::Parameter {
                let name = &names.symbols[*symbol].name;
                let uses = names.keyword_uses.iter().filter(|used| used.name == *name);
                for used in uses.filter(|used| parameter_of(analysis, used) == Some(*symbol)) {
                    put(used.span, false);
                }
            }
        }
        Named::Attribute(class, name) => {
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
        }
        Named::Foreign(name) => {
            for occurrence in names.foreign.get(name).into_iter().flatten() {
                put(occurrence.span, false);
            }
        }
    }
    found.sort_by_key(|place| (place.span.start, !place.is_bound));
    found.dedup_by_key(|place| place.span);
    found
}
