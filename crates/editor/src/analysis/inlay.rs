//! Units of arguments that are given by position, shown behind them.

use elite_runtime::builtins::declare::Builtin;
use elite_syntax::Span;
use elite_syntax::ast::visit::{blocks, own_expressions, parts};
use elite_syntax::ast::{Arg, Expr, ExprKind, Stmt};

use super::words::{Language, LanguageWords as _};
use super::{Analysis, describe, library};

/// A unit behind an argument.
#[derive(Debug)]
pub struct InlayHint {
    /// The byte behind the argument.
    pub at: u32,
    /// The unit.
    pub unit: String,
    /// Name and meaning of the parameter, in Markdown.
    pub text: String,
}

/// The units in a part of a text.
pub fn hints(analysis: &Analysis, within: Span, language: Language) -> Vec<InlayHint> {
    let mut found = Vec::new();
    let mut hints = Hints {
        analysis,
        within,
        language,
        found: &mut found,
    };
    hints.block(&analysis.module().body);
    found.sort_by_key(|hint| hint.at);
    found
}

struct Hints<'a> {
    analysis: &'a Analysis,
    within: Span,
    language: Language,
    found: &'a mut Vec<InlayHint>,
}

impl Hints<'_> {
    fn block(&mut self, body: &[Stmt]) {
        for statement in body {
            let span = statement.span;
            if span.end < self.within.start || self.within.end < span.start {
                continue;
            }
            own_expressions(statement, &mut |expr| self.expr(expr));
            for inner in blocks(statement) {
                self.block(inner);
            }
        }
    }

    fn expr(&mut self, expr: &Expr) {
        if let ExprKind::Call { function, args } = &expr.kind
            && let ExprKind::Name(name) = &function.kind
            && let Some(builtin) = library::robot(name)
            && self.is_builtin(function)
        {
            self.call(builtin, args);
        }
        parts(expr, &mut |part| self.expr(part));
    }

    fn is_builtin(&self, function: &Expr) -> bool {
        let place = self.analysis.names.occurrence_at(function.span.start);
        matches!(place, Some((_, None)))
    }

    fn call(&mut self, builtin: &Builtin, args: &[Arg]) {
        for (argument, parameter) in args.iter().zip(builtin.params) {
            let Arg::Positional(value) = argument else {
                return;
            };
            if parameter.unit.is_empty() {
                continue;
            }
            let said = describe::of_parameter(parameter, self.language);
            self.found.push(InlayHint {
                at: value.span.end,
                unit: self.language.unit(parameter.unit),
                text: format!("`{}` {said}", parameter.name),
            });
        }
    }
}
