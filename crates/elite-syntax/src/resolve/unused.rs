//! Variables of functions and imports that nothing reads.

use std::collections::HashSet;

use messages::text;

use super::collect::{Binding, Scope, ScopeKind, Scopes, collect};
use crate::ast::{Module, ScopeId};
use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::{DiagnosticList, quoted};
use crate::source::Span;
use crate::work_budget::WorkBudget;

/// Functions that read variables by names this pass cannot see.
pub(crate) const READS_BY_NAME: &[&str] = &["locals", "vars", "eval", "exec", "globals", "dir"];

/// Warns about variables that are assigned in a function and never read, and about imports that are never used.
pub fn unused_names(module: &Module, found: &mut DiagnosticList) {
    let budget = WorkBudget::with_limit(usize::MAX);
    let scopes = collect(module, &budget);
    let mut used: HashSet<(u32, &str)> = HashSet::new();
    for (index, scope) in numbered_scopes(&scopes) {
        for (name, _) in &scope.uses {
            if READS_BY_NAME.contains(&&**name) {
                return;
            }
            used.insert((owner(&scopes, index, name), name));
        }
    }
    for (index, scope) in numbered_scopes(&scopes) {
        unused_in(scope, index, &used, found);
    }
}

/// Unused names of one scope; `used` are the names that are read, with the number of the scope whose they are.
pub(super) fn unused_in(
    scope: &Scope,
    number: u32,
    used: &HashSet<(u32, &str)>,
    found: &mut DiagnosticList,
) {
    for info in &scope.names {
        let Some((span, binding)) = info.binding else {
            continue;
        };
        let elsewhere = info.global.is_some() || info.nonlocal.is_some() || info.parameter;
        let wanted = match binding {
            Binding::Import => true,
            Binding::Variable => scope.kind == ScopeKind::Function,
        };
        if wanted
            && !elsewhere
            && !info.name.starts_with('_')
            && !used.contains(&(number, &*info.name))
        {
            found.push(unused_name(&info.name, span, binding));
        }
    }
}

/// What is said of a name that is bound and never read.
pub(super) fn unused_name(name: &str, span: Span, binding: Binding) -> Diagnostic {
    let name = quoted(name);
    match binding {
        Binding::Import => {
            let text = text!(
                "'{name}' is imported but never used",
                "导入了 '{name}' 却从未使用"
            );
            Diagnostic::warning("unused-import", span, text)
        }
        Binding::Variable => {
            let text = text!(
                "the variable '{name}' is assigned but never used",
                "变量 '{name}' 被赋值却从未使用"
            );
            Diagnostic::warning("unused-variable", span, text).with_help(text!(
                "remove it, or call it '_{name}' if that is meant",
                "请删除它；若有意如此，可命名为 '_{name}'"
            ))
        }
    }
}

pub(super) fn numbered_scopes<'s>(
    scopes: &'s Scopes<'_>,
) -> impl Iterator<Item = (u32, &'s Scope)> {
    let all = scopes.scopes.iter().enumerate();
    all.filter_map(|(place, scope)| Some((scopes.id_at(place).0, scope.as_ref()?)))
}

/// The scope whose variable `name` is, seen from scope `from`; the module if no function binds it.
pub(super) fn owner(scopes: &Scopes<'_>, from: u32, name: &str) -> u32 {
    let mut at = Some(ScopeId(from));
    while let Some(id) = at {
        let Some(scope) = scopes.get(id) else { break };
        let visible = scope.kind != ScopeKind::Class || id.0 == from;
        if let (Some(info), true) = (scope.name(name), visible) {
            if info.global.is_some() {
                return 0;
            }
            if info.bound && info.nonlocal.is_none() {
                return id.0;
            }
        }
        at = scope.parent;
    }
    0
}
