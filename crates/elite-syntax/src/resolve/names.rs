//! Undefined names: what is known, what is probably meant.

use std::collections::{BTreeMap, BTreeSet};

use messages::text;

use super::WORK_PER_MENTION;
use super::collect::Scopes;
use crate::ast::ScopeId;
use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::{DiagnosticList, quoted};
use crate::habits::advice as habit_advice;
use crate::lint::{CallHint, CallHook, CallSite};
use crate::source::Span;
use crate::suggestions::nearest;

/// Findings up to which similar names are searched: each search looks at all names.
pub(super) const SUGGESTIONS_MAX: usize = 20;

/// The names an embedder provides to scripts, beside Python's own builtins.
#[derive(Clone, Debug, Default)]
pub struct KnownNames {
    natives: BTreeSet<String>,
    /// Natives that may wait for time or for something to happen.
    waiting: BTreeSet<String>,
    /// What the embedder says about calls.
    hook: Option<CallHook>,
    /// Objects of the embedder, and the names of what they have.
    members: BTreeMap<String, BTreeSet<String>>,
}

impl KnownNames {
    /// The given names are known.
    pub fn new<N: Into<String>>(natives: impl IntoIterator<Item = N>) -> Self {
        KnownNames {
            natives: natives.into_iter().map(Into::into).collect(),
            ..KnownNames::default()
        }
    }

    /// Says which of the names may wait: `check` warns about loops that ask the robot and call none of them.
    pub fn with_waiting<N: Into<String>>(mut self, names: impl IntoIterator<Item = N>) -> Self {
        self.waiting = names.into_iter().map(Into::into).collect();
        self
    }

    /// Lets the embedder look at calls of its functions in `check`.
    pub fn with_call_hook(
        mut self,
        hints: impl Fn(&CallSite<'_>) -> Vec<CallHint> + Send + Sync + 'static,
    ) -> Self {
        self.hook = Some(CallHook::new(hints));
        self
    }

    /// Adds an object of the embedder; `check` finds names that it does not have.
    pub fn with_object<N: Into<String>>(
        mut self,
        object: &str,
        members: impl IntoIterator<Item = N>,
    ) -> Self {
        self.insert(object);
        let members = members.into_iter().map(Into::into).collect();
        self.members.insert(object.to_owned(), members);
        self
    }

    /// What an object of the embedder has.
    pub(crate) fn members(&self, object: &str) -> Option<&BTreeSet<String>> {
        self.members.get(object)
    }

    /// Whether a call of this name may wait.
    pub fn waits(&self, name: &str) -> bool {
        self.waiting.contains(name)
    }

    pub(crate) fn call_hook(&self) -> Option<&CallHook> {
        self.hook.as_ref()
    }

    /// Adds a name.
    pub fn insert(&mut self, name: impl Into<String>) {
        self.natives.insert(name.into());
    }

    /// Whether the embedder provides this name.
    pub fn contains(&self, name: &str) -> bool {
        self.natives.contains(name)
    }
}

/// Warns about every use of a name that nothing defines: no assignment anywhere, no builtin, no native.
pub(super) fn report_undefined(
    scopes: &Scopes<'_>,
    known: &KnownNames,
    diagnostics: &mut DiagnosticList,
) {
    if scopes.star_import {
        return;
    }
    let mut globals: BTreeSet<&str> = BTreeSet::new();
    for scope in scopes.scopes.iter().flatten() {
        scopes.budget.charge(WORK_PER_MENTION / 8);
        let is_module = scope.parent.is_none();
        let global = scope
            .names
            .iter()
            .filter(|info| info.bound && (is_module || info.global.is_some()));
        for info in global {
            scopes.budget.charge(WORK_PER_MENTION);
            if scopes.budget.is_aborted() {
                return;
            }
            globals.insert(&info.name);
        }
    }
    for (index, scope) in scopes.scopes.iter().enumerate() {
        let Some(scope) = scope else { continue };
        for (name, span) in &scope.uses {
            scopes.budget.charge(WORK_PER_MENTION);
            if scopes.budget.is_aborted() {
                return;
            }
            let local = binds_around(scopes, scopes.id_at(index), name);
            if local || globals.contains(&**name) || is_predefined(name, known) {
                continue;
            }
            if diagnostics.is_full() {
                return;
            }
            let locals = scope.names.iter().filter(|info| info.bound);
            let locals = locals.map(|info| &*info.name);
            let near = if diagnostics.len() < SUGGESTIONS_MAX {
                similar(name, &globals, known, locals)
            } else {
                None
            };
            diagnostics.push(undefined_name(name, *span, near));
        }
    }
}

/// Whether a name is there without the program doing anything for it.
pub(super) fn is_predefined(name: &str, known: &KnownNames) -> bool {
    crate::python_names::is_builtin_name(name) || known.contains(name) || name == "__class__"
}

/// The name that was probably meant, of all that could be meant in a scope that binds `locals`.
pub(super) fn similar<'n>(
    name: &str,
    globals: &'n BTreeSet<&'n str>,
    known: &'n KnownNames,
    locals: impl Iterator<Item = &'n str>,
) -> Option<String> {
    let candidates = globals
        .iter()
        .copied()
        .chain(known.natives.iter().map(String::as_str));
    let all = candidates
        .chain(locals)
        .chain(["True", "False", "None"])
        .chain(crate::python_names::builtin_names().map(|name| -> &str { name }));
    nearest(name, all)
}

/// What is said of a name that nothing defines.
pub(super) fn undefined_name(name: &str, span: Span, near: Option<String>) -> Diagnostic {
    let message = text!(
        "the name '{}' is not defined",
        "名称 '{}' 未定义",
        quoted(name)
    );
    let diagnostic = Diagnostic::warning("undefined-name", span, message);
    match near {
        Some(near) => diagnostic
            .with_help(text!("did you mean '{near}'", "是否想写 '{near}'"))
            .with_fix(span, near),
        None => match habit_advice(name) {
            Some(advice) => diagnostic.with_help(advice),
            None => diagnostic,
        },
    }
}

/// Whether the scope or one around it (class bodies of others excepted) binds the name.
pub(super) fn binds_around(scopes: &Scopes, id: ScopeId, name: &str) -> bool {
    let mut at = Some(id);
    while let Some(scope) = at.and_then(|id| scopes.get(id)) {
        if scope.name(name).is_some_and(|info| info.bound) {
            return true;
        }
        at = scope.parent;
    }
    false
}
