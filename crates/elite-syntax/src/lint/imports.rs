//! Imports of modules that are not there. Programs find the modules of this interpreter and no others, neither files
//! beside them nor packages of the machine.

use messages::{Text, text};

use crate::ast::{Expr, ExprKind, Ident, Stmt, StmtKind};
use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::{DiagnosticList, quoted};
use crate::python_names::{is_bundled_module, module_names};
use crate::suggestions::nearest;

/// What a statement imports that is not there.
pub(super) fn check(statement: &Stmt, found: &mut DiagnosticList) {
    match &statement.kind {
        StmtKind::Import(names) => {
            for alias in names {
                // With another name in front of its uses the module can be put right in one place.
                module(&alias.name, alias.alias.is_some(), found);
            }
        }
        StmtKind::ImportFrom { module: name, .. } if name.name.starts_with('.') => {
            let text = text!(
                "a relative import finds nothing: a program is no part of a package",
                "相对导入找不到任何模块：程序不属于任何包"
            );
            let finding = Diagnostic::warning("missing-module", name.span, text);
            found.push(finding.with_help(importable()));
        }
        StmtKind::ImportFrom { module: name, .. } => module(name, true, found),
        _ => {}
    }
}

/// Whether a statement goes on where a module is not there.
pub(super) fn catches(statement: &Stmt) -> bool {
    let StmtKind::Try { handlers, .. } = &statement.kind else {
        return false;
    };
    let mut caught = handlers.iter().map(|handler| handler.exception.as_ref());
    caught.any(|exception| exception.is_none_or(catches_missing))
}

fn catches_missing(exception: &Expr) -> bool {
    match &exception.kind {
        ExprKind::Name(name) => matches!(
            &**name,
            "ImportError" | "ModuleNotFoundError" | "Exception" | "BaseException"
        ),
        ExprKind::Tuple(all) => all.iter().any(catches_missing),
        _ => false,
    }
}

fn module(name: &Ident, can_be_replaced: bool, found: &mut DiagnosticList) {
    // The finding is about the first part of a dotted name that is missing.
    let ends = name.name.match_indices('.').map(|(at, _)| at);
    let mut parts = ends.chain([name.name.len()]).map(|end| &name.name[..end]);
    let Some(missing) = parts.find(|part| !is_bundled_module(part)) else {
        return;
    };
    if found.is_full() {
        return;
    }
    let text = text!("there is no module '{}'", "没有模块 '{}'", quoted(missing));
    let finding = Diagnostic::warning("missing-module", name.span, text);
    found.push(match nearest(&name.name, module_names()) {
        Some(near) if can_be_replaced => finding
            .with_help(text!("did you mean '{near}'", "是否想写 '{near}'"))
            .with_fix(name.span, near),
        Some(near) => finding.with_help(text!("did you mean '{near}'", "是否想写 '{near}'")),
        None => finding.with_help(importable()),
    });
}

fn importable() -> Text {
    let names: Vec<&str> = module_names().collect();
    text!(
        "programs can import {}",
        "程序可以导入 {}",
        names.join(", ")
    )
}
