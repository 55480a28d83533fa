//! The names of a text, put together from those of its pieces: what a change leaves alone is moved to its new place,
//! what crosses pieces (names of the top level, names that nothing binds) is worked out anew.

use std::collections::HashMap;
use std::ops::Range;
use std::vec::IntoIter;

use elite_syntax::ParsedDocument;
use elite_syntax::Span;

use super::collect::{UnitNames, collect_unit};
use super::scopes::{
    AttributeUse, ClassInfo, FunctionInfo, KeywordUse, NameTables, Occurrence, Role, Scope,
    ScopeId, ScopeKind, Symbol, SymbolId, SymbolKind,
};
use super::types::TypeRef;

/// A place of a name that no scope within its piece binds.
#[derive(Debug)]
pub(super) struct UnresolvedName {
    /// Number of the name among the names of the piece.
    pub(super) name: usize,
    /// Number of this place among the places of the piece.
    pub(super) place: usize,
    /// What it was before it was known what the name is.
    pub(super) role: Role,
    /// What it is bound to.
    pub(super) binds: Option<(SymbolKind, TypeRef)>,
}

/// What of the tables belongs to one piece.
#[derive(Debug)]
struct UnitTables {
    scopes: Range<usize>,
    symbols: Range<usize>,
    functions: Range<usize>,
    classes: Range<usize>,
    attribute_uses: Range<usize>,
    keyword_uses: Range<usize>,
    places: Range<usize>,
    outward: Vec<UnresolvedName>,
    outward_names: Vec<Box<str>>,
    /// Names of the top level that it binds.
    bound: Vec<Box<str>>,
    start: u32,
    /// Bytes of its first line before it: columns in it count from there.
    column: u32,
}

/// The parts that the tables consist of.
#[derive(Debug, Default)]
pub(super) struct UnitIndex(Vec<UnitTables>);

/// How far what belongs to a piece moves. Numbers wrap around.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
struct Relocation {
    bytes: u32,
    scopes: usize,
    symbols: usize,
    functions: usize,
    classes: usize,
}

impl Relocation {
    fn span(self, span: &mut Span) {
        span.start = span.start.wrapping_add(self.bytes);
        span.end = span.end.wrapping_add(self.bytes);
    }

    /// The module keeps its number.
    fn scope(self, scope: &mut ScopeId) {
        if *scope != 0 {
            *scope = scope.wrapping_add(self.scopes);
        }
    }

    fn symbol(self, symbol: &mut SymbolId) {
        *symbol = symbol.wrapping_add(self.symbols);
    }

    fn function(self, function: &mut usize) {
        *function = function.wrapping_add(self.functions);
    }

    fn class(self, class: &mut usize) {
        *class = class.wrapping_add(self.classes);
    }

    fn outward(self, mut outward: Vec<UnresolvedName>) -> Vec<UnresolvedName> {
        for place in &mut outward {
            let shapes = place.binds.iter_mut();
            shapes.for_each(|(_, shape)| self.shape(shape));
        }
        outward
    }

    fn occurrence(self, occurrence: &mut Occurrence) {
        self.span(&mut occurrence.span);
        self.scope(&mut occurrence.scope);
    }

    fn shape(self, shape: &mut TypeRef) {
        match shape {
            TypeRef::Unknown | TypeRef::Value(_) | TypeRef::Module(_) | TypeRef::Member(..) => {}
            TypeRef::Container(_, inner)
            | TypeRef::Call(inner)
            | TypeRef::Attribute(inner, _)
            | TypeRef::Item(inner) => self.shape(inner),
            TypeRef::Name(scope, _) => self.scope(scope),
            TypeRef::Function(function) => self.function(function),
            TypeRef::Class(class) | TypeRef::Instance(class) => self.class(class),
        }
    }

    fn shapes(self, shapes: &mut [TypeRef]) {
        shapes.iter_mut().for_each(|shape| self.shape(shape));
    }
}

/// Something in the tables that can move.
trait Relocate {
    fn moved(&mut self, way: Relocation);
}

impl Relocate for Scope {
    fn moved(&mut self, way: Relocation) {
        self.parent.iter_mut().for_each(|parent| way.scope(parent));
        way.span(&mut self.span);
        self.limit = self.limit.wrapping_add(way.bytes);
        self.symbols
            .values_mut()
            .for_each(|symbol| way.symbol(symbol));
    }
}

impl Relocate for Symbol {
    fn moved(&mut self, way: Relocation) {
        way.scope(&mut self.scope);
        self.occurrences
            .iter_mut()
            .for_each(|place| way.occurrence(place));
        way.shapes(&mut self.values);
    }
}

impl Relocate for FunctionInfo {
    fn moved(&mut self, way: Relocation) {
        way.span(&mut self.name_span);
        way.span(&mut self.span);
        way.scope(&mut self.scope);
        self.class.iter_mut().for_each(|class| way.class(class));
        way.shapes(&mut self.returns);
    }
}

impl Relocate for ClassInfo {
    fn moved(&mut self, way: Relocation) {
        way.span(&mut self.name_span);
        way.span(&mut self.span);
        way.scope(&mut self.scope);
        way.shapes(&mut self.bases);
        for attribute in &mut self.attributes {
            attribute.places.iter_mut().for_each(|span| way.span(span));
            way.shapes(&mut attribute.values);
            attribute
                .function
                .iter_mut()
                .for_each(|function| way.function(function));
        }
    }
}

impl Relocate for AttributeUse {
    fn moved(&mut self, way: Relocation) {
        way.shape(&mut self.value);
        way.span(&mut self.span);
    }
}

impl Relocate for KeywordUse {
    fn moved(&mut self, way: Relocation) {
        way.shape(&mut self.function);
        self.first.iter_mut().for_each(|first| way.shape(first));
        way.span(&mut self.span);
    }
}

impl Relocate for (Occurrence, Option<SymbolId>) {
    fn moved(&mut self, way: Relocation) {
        way.occurrence(&mut self.0);
        self.1.iter_mut().for_each(|symbol| way.symbol(symbol));
    }
}

/// A table that is taken apart from its front.
struct TableDrain<T> {
    rest: IntoIter<T>,
    taken: usize,
}

impl<T: Relocate> TableDrain<T> {
    fn of(table: Vec<T>) -> Self {
        let rest = table.into_iter();
        TableDrain { rest, taken: 0 }
    }

    /// Moves the entries of `range` to the end of `table`; those before them are dropped.
    fn give(&mut self, range: Range<usize>, table: &mut Vec<T>, way: Relocation) {
        if let Some(last) = (range.start - self.taken).checked_sub(1) {
            self.rest.nth(last);
        }
        self.taken = range.end;
        let first = table.len();
        table.extend(self.rest.by_ref().take(range.len()));
        if way != Relocation::default() {
            table[first..].iter_mut().for_each(|entry| entry.moved(way));
        }
    }
}

/// The tables of the names before a change.
struct PreviousTables {
    scopes: TableDrain<Scope>,
    symbols: TableDrain<Symbol>,
    functions: TableDrain<FunctionInfo>,
    classes: TableDrain<ClassInfo>,
    attribute_uses: TableDrain<AttributeUse>,
    keyword_uses: TableDrain<KeywordUse>,
    places: TableDrain<(Occurrence, Option<SymbolId>)>,
    parts: Vec<Option<UnitTables>>,
}

impl PreviousTables {
    fn of(names: NameTables) -> Self {
        PreviousTables {
            scopes: TableDrain::of(names.scopes),
            symbols: TableDrain::of(names.symbols),
            functions: TableDrain::of(names.functions),
            classes: TableDrain::of(names.classes),
            attribute_uses: TableDrain::of(names.attribute_uses),
            keyword_uses: TableDrain::of(names.keyword_uses),
            places: TableDrain::of(names.places),
            parts: names.parts.0.into_iter().map(Some).collect(),
        }
    }
}

/// The names of a text; `before` are those of the reading before.
pub(super) fn names(reading: &ParsedDocument, before: Option<NameTables>) -> NameTables {
    let mut old = before.map(PreviousTables::of);
    let text = reading.file().text();
    let mut names = NameTables::default();
    names
        .scopes
        .push(Scope::new(ScopeKind::Module, None, reading.module().span));
    let body = &reading.module().body;
    for piece in reading.pieces() {
        let line = text[..piece.start as usize]
            .rfind('\n')
            .map_or(0, |at| at + 1);
        let column = piece.start - line as u32;
        let kept = old.as_mut().zip(piece.origin).and_then(|(old, origin)| {
            let part = old.parts.get_mut(origin)?;
            // Where a line does not begin with the piece, columns in it depend on what is before it.
            let part = part.take_if(|part| part.column == column)?;
            Some((old, part))
        });
        let part = match kept {
            Some((old, part)) => names.keep(old, part, piece.start),
            None => {
                let found = collect_unit(&body[piece.statements.clone()], text);
                names.add(found, piece.start, column)
            }
        };
        let follows = body.get(piece.statements.end);
        let limit = follows.map_or(text.len() as u32, |next| next.span.start);
        for scope in &mut names.scopes[part.scopes.clone()] {
            if scope.is_open {
                scope.limit = limit.max(scope.span.end);
            }
        }
        names.parts.0.push(part);
    }
    names.join();
    names
}

impl NameTables {
    /// The next free numbers of all tables.
    fn next_ids(&self) -> UnitTables {
        let at = |table: usize| table..table;
        UnitTables {
            scopes: at(self.scopes.len()),
            symbols: at(self.symbols.len()),
            functions: at(self.functions.len()),
            classes: at(self.classes.len()),
            attribute_uses: at(self.attribute_uses.len()),
            keyword_uses: at(self.keyword_uses.len()),
            places: at(self.places.len()),
            outward: Vec::new(),
            outward_names: Vec::new(),
            bound: Vec::new(),
            start: 0,
            column: 0,
        }
    }

    fn close(&self, part: &mut UnitTables) {
        part.scopes.end = self.scopes.len();
        part.symbols.end = self.symbols.len();
        part.functions.end = self.functions.len();
        part.classes.end = self.classes.len();
        part.attribute_uses.end = self.attribute_uses.len();
        part.keyword_uses.end = self.keyword_uses.len();
        part.places.end = self.places.len();
    }

    fn keep(&mut self, old: &mut PreviousTables, part: UnitTables, start: u32) -> UnitTables {
        let mut now = self.next_ids();
        let way = Relocation {
            bytes: start.wrapping_sub(part.start),
            scopes: now.scopes.start.wrapping_sub(part.scopes.start),
            symbols: now.symbols.start.wrapping_sub(part.symbols.start),
            functions: now.functions.start.wrapping_sub(part.functions.start),
            classes: now.classes.start.wrapping_sub(part.classes.start),
        };
        old.scopes.give(part.scopes, &mut self.scopes, way);
        old.symbols.give(part.symbols, &mut self.symbols, way);
        old.functions.give(part.functions, &mut self.functions, way);
        old.classes.give(part.classes, &mut self.classes, way);
        old.attribute_uses
            .give(part.attribute_uses, &mut self.attribute_uses, way);
        old.keyword_uses
            .give(part.keyword_uses, &mut self.keyword_uses, way);
        old.places.give(part.places, &mut self.places, way);
        self.close(&mut now);
        UnitTables {
            outward: way.outward(part.outward),
            outward_names: part.outward_names,
            bound: part.bound,
            start,
            column: part.column,
            ..now
        }
    }

    fn add(&mut self, found: UnitNames, start: u32, column: u32) -> UnitTables {
        let mut now = self.next_ids();
        // Numbers in a piece count from 0, those of its scopes from 1: the module's is 0.
        let way = Relocation {
            bytes: 0,
            scopes: now.scopes.start - 1,
            symbols: now.symbols.start,
            functions: now.functions.start,
            classes: now.classes.start,
        };
        fn add<T: Relocate>(found: Vec<T>, table: &mut Vec<T>, way: Relocation) {
            let first = table.len();
            table.extend(found);
            table[first..].iter_mut().for_each(|entry| entry.moved(way));
        }
        let mut scopes = found.scopes;
        scopes.remove(0);
        add(scopes, &mut self.scopes, way);
        add(found.symbols, &mut self.symbols, way);
        add(found.functions, &mut self.functions, way);
        add(found.classes, &mut self.classes, way);
        add(found.attribute_uses, &mut self.attribute_uses, way);
        add(found.keyword_uses, &mut self.keyword_uses, way);
        add(found.places, &mut self.places, way);
        self.close(&mut now);
        UnitTables {
            outward: way.outward(found.outward),
            outward_names: found.outward_names,
            bound: found.bound,
            start,
            column,
            ..now
        }
    }

    /// What crosses pieces: names of the top level get their symbols, the others are foreign.
    fn join(&mut self) {
        let parts = std::mem::take(&mut self.parts);
        let mut symbols: HashMap<&str, Option<SymbolId>> = HashMap::new();
        let bound = parts.0.iter().flat_map(|part| &part.bound);
        symbols.extend(bound.map(|name| (&**name, None)));
        let mut foreign: HashMap<&str, Vec<Occurrence>> = HashMap::new();
        let mut meant: Vec<Option<SymbolId>> = Vec::new();
        for part in &parts.0 {
            meant.clear();
            meant.resize(part.outward_names.len(), None);
            for place in &part.outward {
                let name = &*part.outward_names[place.name];
                let (occurrence, symbol) = &mut self.places[part.places.start + place.place];
                occurrence.role = place.role;
                let known = &mut meant[place.name];
                if known.is_none()
                    && let Some(entry) = symbols.get_mut(name)
                {
                    *known = Some(*entry.get_or_insert_with(|| {
                        self.symbols.push(Symbol::new(name, 0));
                        self.symbols.len() - 1
                    }));
                }
                *symbol = *known;
                match *known {
                    Some(known) => {
                        self.symbols[known].take(*occurrence, place.binds.clone());
                    }
                    None => {
                        occurrence.role = Role::Read;
                        foreign.entry(name).or_default().push(*occurrence);
                    }
                }
            }
        }
        let own = symbols.into_iter();
        let own = own.filter_map(|(name, symbol)| Some((name.into(), symbol?)));
        self.scopes[0].symbols = own.collect();
        let foreign = foreign.into_iter();
        self.foreign = foreign
            .map(|(name, places)| (name.into(), places))
            .collect();
        self.parts = parts;
    }
}
