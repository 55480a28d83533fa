//! What shows only when the whole program is seen: calls of its own functions that cannot work, and variables with one
//! value that is wrong for where they are used.
//!
//! A name counts only if exactly one place of the program binds it, in whatever scope: it means one thing then.

use std::collections::HashMap;

use messages::{Text, text};

use super::calls::{call_site_with, is_meant_to_fail};
use crate::ast::visit::{NodePart, blocks, expression_parts, own_expressions};
use crate::ast::{Arg, Expr, ExprKind, FunctionDef, Module, Parameter, Stmt, StmtKind};
use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::{DiagnosticList, quoted};
use crate::resolve::{KnownNames, READS_BY_NAME};

/// Parameters that a signature in a message lists.
const PARAMETERS_MAX: usize = 12;

/// Looks at the calls of a program.
pub(crate) fn check(module: &Module, known: &KnownNames, found: &mut DiagnosticList) {
    let mut names = ProgramNames::default();
    names.block(&module.body, true, known);
    if names.is_dynamic {
        return;
    }
    for call in &names.calls {
        if found.is_full() {
            return;
        }
        let ExprKind::Call { function, args } = &call.kind else {
            continue;
        };
        let ExprKind::Name(name) = &function.kind else {
            continue;
        };
        match names.functions.get(&**name) {
            Some(def) if names.count(name) == 1 => own_call(call, def, args, found),
            _ if names.count(name) == 0 && known.contains(name) => {
                names.native_call(call, known, found);
            }
            _ => {}
        }
    }
}

/// What a program does with names.
#[derive(Default)]
struct ProgramNames<'t> {
    /// How many places bind or change the name.
    bindings: HashMap<&'t str, usize>,
    /// Functions of the top level.
    functions: HashMap<&'t str, &'t FunctionDef>,
    /// What a name is set to.
    values: HashMap<&'t str, &'t Expr>,
    calls: Vec<&'t Expr>,
    /// The program binds names that cannot be seen.
    is_dynamic: bool,
    /// Blocks around whose exceptions are caught, and functions without a name, which are mostly there to fail.
    guards: u32,
}

impl<'t> ProgramNames<'t> {
    fn count(&self, name: &str) -> usize {
        self.bindings.get(name).copied().unwrap_or(0)
    }

    fn bind(&mut self, name: &'t str) {
        *self.bindings.entry(name).or_default() += 1;
    }

    /// Names that an assignment to `target` binds or changes.
    fn bind_target(&mut self, target: &'t Expr) {
        match &target.kind {
            ExprKind::Name(name) => self.bind(name),
            ExprKind::Tuple(items) | ExprKind::List(items) => {
                items.iter().for_each(|item| self.bind_target(item));
            }
            ExprKind::Starred(inner) => self.bind_target(inner),
            ExprKind::Subscript { value, .. } | ExprKind::Attribute { value, .. } => {
                self.bind_target(value);
            }
            _ => {}
        }
    }

    fn block(&mut self, body: &'t [Stmt], is_top: bool, known: &KnownNames) {
        for statement in body {
            self.statement(statement, is_top);
            own_expressions(statement, &mut |expr| self.expression(expr, known));
            let handles =
                matches!(&statement.kind, StmtKind::Try { handlers, .. } if !handlers.is_empty());
            for (index, block) in blocks(statement).into_iter().enumerate() {
                // The first block of a `try` is what it guards: what fails there is caught.
                let is_guarded = handles && index == 0;
                self.guards += u32::from(is_guarded);
                self.block(block, false, known);
                self.guards -= u32::from(is_guarded);
            }
        }
    }

    fn statement(&mut self, statement: &'t Stmt, is_top: bool) {
        match &statement.kind {
            StmtKind::Assign { targets, value } => {
                targets.iter().for_each(|target| self.bind_target(target));
                if let [
                    Expr {
                        kind: ExprKind::Name(name),
                        ..
                    },
                ] = targets.as_slice()
                {
                    self.values.insert(name, value);
                }
            }
            StmtKind::AnnAssign { target, value, .. } => {
                self.bind_target(target);
                if let (ExprKind::Name(name), Some(value)) = (&target.kind, value) {
                    self.values.insert(name, value);
                }
            }
            StmtKind::AugAssign { target, .. } | StmtKind::For { target, .. } => {
                self.bind_target(target);
            }
            StmtKind::Delete(targets) => targets.iter().for_each(|target| self.bind_target(target)),
            StmtKind::With { items, .. } => {
                let targets = items.iter().filter_map(|item| item.target.as_ref());
                targets.for_each(|target| self.bind_target(target));
            }
            StmtKind::Import(names) => names.iter().for_each(|alias| {
                let name = alias.alias.as_ref().unwrap_or(&alias.name);
                self.bind(name.name.split('.').next().unwrap_or_default());
            }),
            StmtKind::ImportFrom { names, star, .. } => {
                self.is_dynamic |= star;
                names.iter().for_each(|alias| {
                    self.bind(&alias.alias.as_ref().unwrap_or(&alias.name).name);
                });
            }
            StmtKind::Try { handlers, .. } => {
                let names = handlers.iter().filter_map(|handler| handler.name.as_ref());
                names.for_each(|name| self.bind(&name.name));
            }
            StmtKind::Function(def) => {
                self.bind(&def.name.name);
                def.parameters
                    .iter()
                    .for_each(|parameter| self.bind(&parameter.name.name));
                if is_top && def.decorators.is_empty() {
                    self.functions.insert(&def.name.name, def);
                }
            }
            StmtKind::Class(def) => self.bind(&def.name.name),
            _ => {}
        }
    }

    fn expression(&mut self, expr: &'t Expr, known: &KnownNames) {
        if is_meant_to_fail(expr, known) {
            return;
        }
        match &expr.kind {
            ExprKind::Named { target, .. } => self.bind(&target.name),
            ExprKind::Lambda(lambda) => {
                let parameters = lambda.parameters.iter();
                parameters.for_each(|parameter| self.bind(&parameter.name.name));
            }
            ExprKind::Call { function, .. } => match &function.kind {
                ExprKind::Name(name) => {
                    self.is_dynamic |= READS_BY_NAME.contains(&&**name);
                    if self.guards == 0 {
                        self.calls.push(expr);
                    }
                }
                // A method may change its object.
                ExprKind::Attribute { value, .. } => self.bind_target(value),
                _ => {}
            },
            _ => {}
        }
        let is_lambda = matches!(expr.kind, ExprKind::Lambda(_));
        self.guards += u32::from(is_lambda);
        expression_parts(&expr.kind, &mut |part| match part {
            NodePart::ClauseTarget(target) => self.bind_target(target),
            NodePart::Expr(part) => self.expression(part, known),
            _ => {}
        });
        self.guards -= u32::from(is_lambda);
    }

    /// A call of the embedder's function with variables that have one value.
    fn native_call(&self, call: &'t Expr, known: &KnownNames, found: &mut DiagnosticList) {
        let Some(hook) = known.call_hook() else {
            return;
        };
        let value_of = |name: &str| match self.count(name) {
            1 => self.values.get(name).copied(),
            _ => None,
        };
        let ExprKind::Call { args, .. } = &call.kind else {
            return;
        };
        let variable = |index: usize| {
            let (Arg::Positional(value) | Arg::Keyword(_, value)) = args.get(index)? else {
                return None;
            };
            match &value.kind {
                ExprKind::Name(name) => value_of(name),
                _ => None,
            }
        };
        if !(0..args.len()).any(|index| variable(index).is_some()) {
            return;
        }
        let Some(site) = call_site_with(call, &value_of) else {
            return;
        };
        for hint in hook.hints(&site) {
            // What is about other arguments has been said where the call alone was looked at.
            let Some(index) = hint.argument else { continue };
            let (Some(value), Some(arg)) = (variable(index), site.args.get(index)) else {
                continue;
            };
            let mut finding = Diagnostic::warning(hint.code, arg.span, hint.message)
                .with_label(value.span, text!("this is its value", "它的值在这里"));
            finding.help = hint.help;
            found.push(finding);
        }
    }
}

/// A call of a function of the program.
fn own_call(call: &Expr, def: &FunctionDef, args: &[Arg], found: &mut DiagnosticList) {
    let parameters = &def.parameters;
    let name = quoted(&def.name.name);
    let by_place: Vec<&Parameter> = parameters
        .positional_only
        .iter()
        .chain(&parameters.positional)
        .collect();
    let is_positional = |arg: &&Arg| matches!(arg, Arg::Positional(_));
    let count = args.iter().filter(is_positional).count();
    let is_open = args
        .iter()
        .any(|arg| matches!(arg, Arg::Star(_) | Arg::DoubleStar(_)));
    let keywords = || {
        args.iter().filter_map(|arg| match arg {
            Arg::Keyword(name, value) => Some((name, value)),
            _ => None,
        })
    };
    let mut put = |code: &'static str, span, text: Text| {
        let shown: Vec<&str> = parameters
            .iter()
            .take(PARAMETERS_MAX)
            .map(|parameter| &*parameter.name.name)
            .collect();
        let dots = if parameters.iter().count() > PARAMETERS_MAX {
            ", …"
        } else {
            ""
        };
        let finding = Diagnostic::warning(code, span, text)
            .with_label(def.name.span, text!("it is defined here", "在这里定义"));
        found.push(finding.with_help(text!(
            "call it as {name}({}{dots})",
            "调用写作 {name}({}{dots})",
            shown.join(", ")
        )));
    };
    if count > by_place.len() && parameters.star.is_none() {
        let most = by_place.len();
        let text = text!(
            "{name}() takes at most {most} arguments, got {count}",
            "{name}() 最多接受 {most} 个参数，给出了 {count} 个"
        );
        return put("argument-count", call.span, text);
    }
    let keyword_names = || parameters.positional.iter().chain(&parameters.keyword_only);
    for (word, _) in keywords() {
        let is_known = keyword_names().any(|parameter| parameter.name.name == word.name);
        if !is_known && parameters.double_star.is_none() {
            let text = text!(
                "{name}() has no parameter '{}'",
                "{name}() 没有参数 '{}'",
                quoted(&word.name)
            );
            return put("unknown-argument", word.span, text);
        }
    }
    if is_open {
        return;
    }
    let is_given =
        |parameter: &Parameter| keywords().any(|(word, _)| word.name == parameter.name.name);
    let rest = by_place
        .into_iter()
        .skip(count)
        .chain(&parameters.keyword_only);
    let missing = rest
        .filter(|parameter| parameter.default.is_none())
        .find(|parameter| !is_given(parameter));
    if let Some(missing) = missing {
        let text = text!(
            "{name}() needs '{}'",
            "{name}() 需要 '{}'",
            quoted(&missing.name.name)
        );
        put("missing-argument", call.span, text);
    }
}
