//! Names and warnings of a program that is read again while it is written: what can be told of a part of its top level
//! is worked out once, what depends on all parts is put together anew.
//!
//! The findings are those of `resolve` and `lint`, in their order and with their limits.

use std::collections::{BTreeSet, HashMap, HashSet};
use std::ops::Range;

use super::KnownNames;
use super::collect::{Binding, Scopes, collect_part};
use super::names::{SUGGESTIONS_MAX, binds_around, is_predefined, similar, undefined_name};
use super::storage::unbound_nonlocals;
use super::unused::{READS_BY_NAME, numbered_scopes, owner, unused_in, unused_name};
use crate::ast::Stmt;
use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::DiagnosticList;
use crate::lint::CallDiagnostics;
use crate::source::{SourceFile, Span};
use crate::work_budget::WorkBudget;

/// What is known of some statements of the top level without the others. Places count from `start`.
#[derive(Debug)]
pub(crate) struct UnitAnalysis {
    start: u32,
    star_import: bool,
    /// The statements read variables by names that are only known at run time (`eval` and the like).
    reads_by_text: bool,
    /// What is wrong with declarations, and names that no function binds for its `nonlocal`.
    errors: Vec<Diagnostic>,
    unbound: Vec<Diagnostic>,
    /// The names of the top level, in the order in which they are first met.
    names: Vec<TopLevelName>,
    /// Names that functions in the part declare global and bind.
    globals: Vec<Box<str>>,
    /// Uses of names that are neither given nor bound in the part: by the top level, and by scopes within it.
    uses: Vec<NameUse>,
    inner_uses: Vec<NameUse>,
    /// The names of the top level that are used.
    used: Vec<Box<str>>,
    /// Findings about names of inner scopes that are not used.
    unused: Vec<Diagnostic>,
    flow: Vec<Diagnostic>,
    calls: CallDiagnostics,
    /// The embedder's names that it binds somewhere.
    bound_natives: Vec<Box<str>>,
}

#[derive(Debug)]
struct TopLevelName {
    name: Box<str>,
    is_bound: bool,
    is_global: bool,
    binding: Option<(Span, Binding)>,
}

#[derive(Debug)]
struct NameUse {
    name: Box<str>,
    span: Span,
    /// The place of the use's scope in the table of the part.
    scope: usize,
}

impl UnitAnalysis {
    /// Looks at statements of the top level, in which are the scopes `own`.
    pub(crate) fn analyze(
        body: &[Stmt],
        own: Range<u32>,
        start: u32,
        file: &SourceFile,
        known: &KnownNames,
    ) -> Self {
        let budget = WorkBudget::with_limit(usize::MAX);
        let mut scopes = collect_part(body, own, &budget);
        let errors = std::mem::take(&mut scopes.diagnostics);
        let mut unbound = DiagnosticList::default();
        unbound_nonlocals(&scopes, &mut unbound);
        let (mut flow, mut calls) = Default::default();
        crate::lint::lint_part(body, file, known, &mut flow, &mut calls);
        let mut part = UnitAnalysis {
            start,
            star_import: scopes.star_import,
            reads_by_text: false,
            errors: errors.into_vec(),
            unbound: unbound.into_vec(),
            names: Vec::new(),
            globals: Vec::new(),
            uses: Vec::new(),
            inner_uses: Vec::new(),
            used: Vec::new(),
            unused: Vec::new(),
            flow: flow.into_vec(),
            calls,
            bound_natives: scopes.bound_natives(known).map(Into::into).collect(),
        };
        part.take_names(&scopes, known);
        part.take_unused(&scopes);
        part
    }

    fn take_names(&mut self, scopes: &Scopes<'_>, known: &KnownNames) {
        for (place, scope) in scopes.scopes.iter().enumerate() {
            let Some(scope) = scope else { continue };
            for info in &scope.names {
                if place == 0 {
                    self.names.push(TopLevelName {
                        name: info.name.clone(),
                        is_bound: info.bound,
                        is_global: info.global.is_some(),
                        binding: info.binding,
                    });
                } else if info.bound && info.global.is_some() {
                    self.globals.push(info.name.clone());
                }
            }
            for (name, span) in &scope.uses {
                if is_predefined(name, known) || binds_around(scopes, scopes.id_at(place), name) {
                    continue;
                }
                let uses = match place {
                    0 => &mut self.uses,
                    _ => &mut self.inner_uses,
                };
                uses.push(NameUse {
                    name: name.clone(),
                    span: *span,
                    scope: place,
                });
            }
        }
    }

    fn take_unused(&mut self, scopes: &Scopes<'_>) {
        let mut used: HashSet<(u32, &str)> = HashSet::new();
        for (number, scope) in numbered_scopes(scopes) {
            for (name, _) in &scope.uses {
                self.reads_by_text |= READS_BY_NAME.contains(&&**name);
                let owner = owner(scopes, number, name);
                if used.insert((owner, name)) && owner == 0 {
                    self.used.push(name.clone());
                }
            }
        }
        let mut found = DiagnosticList::default();
        for (number, scope) in numbered_scopes(scopes).filter(|(number, _)| *number != 0) {
            unused_in(scope, number, &used, &mut found);
        }
        self.unused = found.into_vec();
    }
}

/// A part where it stands now.
pub(crate) struct PlacedUnit<'p> {
    pub(crate) part: &'p UnitAnalysis,
    pub(crate) start: u32,
    /// The statements of the part, and the numbers of their scopes.
    pub(crate) body: &'p [Stmt],
    pub(crate) scopes: Range<u32>,
}

impl PlacedUnit<'_> {
    fn span(&self, span: Span) -> Span {
        let way = self.start.wrapping_sub(self.part.start);
        Span {
            start: span.start.wrapping_add(way),
            end: span.end.wrapping_add(way),
        }
    }

    fn relocated(&self, finding: &Diagnostic) -> Diagnostic {
        let mut finding = finding.clone();
        finding.span = self.span(finding.span);
        for label in &mut finding.labels {
            label.span = self.span(label.span);
        }
        if let Some(fix) = &mut finding.fix {
            fix.span = self.span(fix.span);
        }
        finding
    }

    /// The names that a scope of it binds.
    fn locals(&self, scope: usize) -> Vec<Box<str>> {
        let budget = WorkBudget::with_limit(usize::MAX);
        let scopes = collect_part(self.body, self.scopes.clone(), &budget);
        let names = scopes.scopes.get(scope).and_then(Option::as_ref);
        let bound = names.iter().flat_map(|scope| &scope.names);
        let bound = bound.filter(|info| info.bound);
        bound.map(|info| info.name.clone()).collect()
    }
}

/// What `resolve` and `lint` find in a program: of the first its errors, or its warnings if there are none; of the
/// second all but what is never reached at the top level.
pub(crate) struct MergedDiagnostics {
    pub(crate) resolved: DiagnosticList,
    pub(crate) unused: DiagnosticList,
    pub(crate) flow: DiagnosticList,
    pub(crate) calls: DiagnosticList,
}

/// Puts the parts of a program together.
pub(crate) fn merge_units(parts: &[PlacedUnit<'_>], known: &KnownNames) -> MergedDiagnostics {
    let mut found = MergedDiagnostics {
        resolved: DiagnosticList::default(),
        unused: DiagnosticList::default(),
        flow: DiagnosticList::default(),
        calls: DiagnosticList::default(),
    };
    for placed in parts {
        push_all(placed, &placed.part.errors, &mut found.resolved);
    }
    for placed in parts {
        push_all(placed, &placed.part.unbound, &mut found.resolved);
    }
    if found.resolved.len() > 0 {
        return found;
    }
    undefined_names(parts, known, &mut found.resolved);
    if !parts.iter().any(|placed| placed.part.reads_by_text) {
        unused_imports(parts, &mut found.unused);
        for placed in parts {
            push_all(placed, &placed.part.unused, &mut found.unused);
        }
    }
    for placed in parts {
        push_all(placed, &placed.part.flow, &mut found.flow);
    }
    if !parts.iter().any(|placed| placed.part.star_import) {
        let bound = parts.iter().flat_map(|placed| &placed.part.bound_natives);
        let bound: HashSet<&str> = bound.map(|name| &**name).collect();
        for placed in parts {
            let calls = placed.part.calls.retained(|name| bound.contains(name));
            push_all(placed, calls, &mut found.calls);
        }
    }
    found
}

fn push_all<'d>(
    placed: &PlacedUnit<'_>,
    own: impl IntoIterator<Item = &'d Diagnostic>,
    found: &mut DiagnosticList,
) {
    for finding in own {
        if found.is_full() {
            return;
        }
        found.push(placed.relocated(finding));
    }
}

fn undefined_names(parts: &[PlacedUnit<'_>], known: &KnownNames, found: &mut DiagnosticList) {
    if parts.iter().any(|placed| placed.part.star_import) {
        return;
    }
    let mut globals: HashSet<&str> = HashSet::new();
    for placed in parts {
        let top = placed.part.names.iter().filter(|name| name.is_bound);
        globals.extend(top.map(|name| &*name.name));
        globals.extend(placed.part.globals.iter().map(|name| &**name));
    }
    let top = parts
        .iter()
        .flat_map(|placed| uses_of(placed, &placed.part.uses));
    let inner = parts
        .iter()
        .flat_map(|placed| uses_of(placed, &placed.part.inner_uses));
    let unknown = top
        .chain(inner)
        .filter(|(_, used)| !globals.contains(&*used.name));
    let mut in_order: Option<BTreeSet<&str>> = None;
    for (placed, used) in unknown {
        if found.is_full() {
            return;
        }
        let near = if found.len() < SUGGESTIONS_MAX {
            let globals = in_order.get_or_insert_with(|| globals.iter().copied().collect());
            let locals = match used.scope {
                // Variables of the top level are all among the globals.
                0 => Vec::new(),
                scope => placed.locals(scope),
            };
            similar(
                &used.name,
                globals,
                known,
                locals.iter().map(|name| &**name),
            )
        } else {
            None
        };
        found.push(undefined_name(&used.name, placed.span(used.span), near));
    }
}

fn uses_of<'p>(
    placed: &'p PlacedUnit<'p>,
    uses: &'p [NameUse],
) -> impl Iterator<Item = (&'p PlacedUnit<'p>, &'p NameUse)> {
    uses.iter().map(move |used| (placed, used))
}

/// Imports of the top level that nothing uses.
fn unused_imports(parts: &[PlacedUnit<'_>], found: &mut DiagnosticList) {
    let is_import = |name: &&TopLevelName| matches!(name.binding, Some((_, Binding::Import)));
    let mut imports = parts.iter().flat_map(|placed| &placed.part.names);
    if !imports.any(|name| is_import(&name)) {
        return;
    }
    let used = parts.iter().flat_map(|placed| &placed.part.used);
    let used: HashSet<&str> = used.map(|name| &**name).collect();
    // What the whole program says about each name, in the order in which names are first met.
    let mut merged = Vec::new();
    let mut index: HashMap<&str, usize> = HashMap::new();
    for placed in parts {
        for top in &placed.part.names {
            let at = *index.entry(&top.name).or_insert_with(|| {
                merged.push((&*top.name, false, None));
                merged.len() - 1
            });
            let (_, is_global, binding) = &mut merged[at];
            *is_global |= top.is_global;
            let own = top.binding.map(|(span, how)| (placed.span(span), how));
            *binding = binding.or(own);
        }
    }
    for (name, is_global, binding) in merged {
        if let Some((span, Binding::Import)) = binding
            && !is_global
            && !name.starts_with('_')
            && !used.contains(name)
        {
            found.push(unused_name(name, span, Binding::Import));
        }
    }
}
