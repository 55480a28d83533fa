//! Moves a tree that is kept while the text around it changes: every place in it by the same number of bytes, every
//! scope by the same number.

use super::{
    Arg, ClassDef, Comprehension, ComprehensionKind, DictItem, DirectiveAnchor, Expr, ExprKind,
    FStringPart, FunctionDef, Ident, ImportAlias, Parameters, ScopeId, Stmt, StmtKind,
};
use crate::source::Span;

/// How far parts of a tree move. Numbers wrap around: a way back is a large number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Shift {
    bytes: u32,
    scopes: u32,
}

impl Shift {
    /// From one offset and scope to another.
    pub(crate) fn between(old: (u32, u32), new: (u32, u32)) -> Self {
        Shift {
            bytes: new.0.wrapping_sub(old.0),
            scopes: new.1.wrapping_sub(old.1),
        }
    }

    /// An offset at its new place.
    pub(crate) fn offset(self, offset: u32) -> u32 {
        offset.wrapping_add(self.bytes)
    }

    /// A span at its new place.
    pub(crate) fn moved(self, span: Span) -> Span {
        Span {
            start: self.offset(span.start),
            end: self.offset(span.end),
        }
    }

    /// A directive's place.
    pub(crate) fn node_place(self, place: DirectiveAnchor) -> DirectiveAnchor {
        match place {
            DirectiveAnchor::Before(at) => DirectiveAnchor::Before(self.offset(at)),
            DirectiveAnchor::After(at) => DirectiveAnchor::After(self.offset(at)),
            DirectiveAnchor::AtEnd => DirectiveAnchor::AtEnd,
        }
    }

    fn span(self, span: &mut Span) {
        *span = self.moved(*span);
    }

    fn scope(self, scope: &mut ScopeId) {
        scope.0 = scope.0.wrapping_add(self.scopes);
    }

    fn ident(self, ident: &mut Ident) {
        self.span(&mut ident.span);
    }

    /// Moves statements with all that is in them.
    pub(crate) fn statements(self, statements: &mut [Stmt]) {
        if self != Shift::default() {
            statements.iter_mut().for_each(|one| self.statement(one));
        }
    }

    fn block(self, block: &mut [Stmt]) {
        block.iter_mut().for_each(|one| self.statement(one));
    }

    fn statement(self, statement: &mut Stmt) {
        self.span(&mut statement.span);
        match &mut statement.kind {
            StmtKind::Expr(value) => self.expr(value),
            StmtKind::Print { values, .. } | StmtKind::Delete(values) => self.exprs(values),
            StmtKind::Assign { targets, value } => {
                self.exprs(targets);
                self.expr(value);
            }
            StmtKind::AugAssign { target, value, .. } => {
                self.expr(target);
                self.expr(value);
            }
            StmtKind::AnnAssign {
                target,
                annotation,
                value,
            } => {
                self.expr(target);
                self.expr(annotation);
                self.exprs(value);
            }
            StmtKind::Pass | StmtKind::Break | StmtKind::Continue => {}
            StmtKind::Return(value) => self.exprs(value),
            StmtKind::Raise { exception, cause } => {
                self.exprs(exception);
                self.exprs(cause);
            }
            StmtKind::Global(names) | StmtKind::Nonlocal(names) => {
                names.iter_mut().for_each(|name| self.ident(name));
            }
            StmtKind::Assert { test, message } => {
                self.expr(test);
                self.exprs(message);
            }
            StmtKind::Import(names) => self.aliases(names),
            StmtKind::ImportFrom { module, names, .. } => {
                self.ident(module);
                self.aliases(names);
            }
            StmtKind::If { branches, orelse } => {
                for (test, body) in branches {
                    self.expr(test);
                    self.block(body);
                }
                self.block(orelse);
            }
            StmtKind::While { test, body, orelse } => {
                self.expr(test);
                self.block(body);
                self.block(orelse);
            }
            StmtKind::For {
                target,
                iterable,
                body,
                orelse,
            } => {
                self.expr(target);
                self.expr(iterable);
                self.block(body);
                self.block(orelse);
            }
            StmtKind::With { items, body } => {
                for item in items {
                    self.expr(&mut item.context);
                    self.exprs(&mut item.target);
                }
                self.block(body);
            }
            StmtKind::Try {
                body,
                handlers,
                orelse,
                finally,
            } => {
                self.block(body);
                for handler in handlers {
                    self.span(&mut handler.span);
                    self.exprs(&mut handler.exception);
                    handler.name.iter_mut().for_each(|name| self.ident(name));
                    self.block(&mut handler.body);
                }
                self.block(orelse);
                self.block(finally);
            }
            StmtKind::Function(def) => self.function(def),
            StmtKind::Class(def) => self.class(def),
        }
    }

    fn aliases(self, aliases: &mut [ImportAlias]) {
        for alias in aliases {
            self.ident(&mut alias.name);
            alias.alias.iter_mut().for_each(|name| self.ident(name));
        }
    }

    fn function(self, def: &mut FunctionDef) {
        self.ident(&mut def.name);
        self.parameters(&mut def.parameters);
        self.exprs(&mut def.returns);
        self.exprs(&mut def.decorators);
        self.block(&mut def.body);
        self.scope(&mut def.scope);
    }

    fn class(self, def: &mut ClassDef) {
        self.ident(&mut def.name);
        self.arguments(&mut def.args);
        self.exprs(&mut def.decorators);
        self.block(&mut def.body);
        self.scope(&mut def.scope);
    }

    fn parameters(self, parameters: &mut Parameters) {
        let groups = [
            &mut parameters.positional_only,
            &mut parameters.positional,
            &mut parameters.keyword_only,
        ];
        let named = groups.into_iter().flatten();
        for parameter in named
            .chain(&mut parameters.star)
            .chain(&mut parameters.double_star)
        {
            self.ident(&mut parameter.name);
            self.exprs(&mut parameter.annotation);
            self.exprs(&mut parameter.default);
        }
    }

    fn arguments(self, args: &mut [Arg]) {
        for arg in args {
            match arg {
                Arg::Positional(value) | Arg::Star(value) | Arg::DoubleStar(value) => {
                    self.expr(value);
                }
                Arg::Keyword(name, value) => {
                    self.ident(name);
                    self.expr(value);
                }
            }
        }
    }

    fn exprs<'e>(self, exprs: impl IntoIterator<Item = &'e mut Expr>) {
        exprs.into_iter().for_each(|expr| self.expr(expr));
    }

    fn expr(self, expr: &mut Expr) {
        self.span(&mut expr.span);
        match &mut expr.kind {
            ExprKind::Constant(_) | ExprKind::Name(_) => {}
            ExprKind::And(items)
            | ExprKind::Or(items)
            | ExprKind::List(items)
            | ExprKind::Tuple(items)
            | ExprKind::Set(items) => self.exprs(items),
            ExprKind::Binary { left, right, .. } => {
                self.expr(left);
                self.expr(right);
            }
            ExprKind::Unary { operand: inner, .. }
            | ExprKind::Starred(inner)
            | ExprKind::YieldFrom(inner) => self.expr(inner),
            ExprKind::Compare { left, rest } => {
                self.expr(left);
                rest.iter_mut().for_each(|(_, right)| self.expr(right));
            }
            ExprKind::Call { function, args } => {
                self.expr(function);
                self.arguments(args);
            }
            ExprKind::Attribute { value, name } => {
                self.expr(value);
                self.ident(name);
            }
            ExprKind::Subscript { value, index } => {
                self.expr(value);
                self.expr(index);
            }
            ExprKind::Slice { lower, upper, step } => {
                let bounds = [lower, upper, step].into_iter().flatten();
                bounds.for_each(|bound| self.expr(bound));
            }
            ExprKind::Dict(items) => items.iter_mut().for_each(|item| match item {
                DictItem::Pair(key, value) => {
                    self.expr(key);
                    self.expr(value);
                }
                DictItem::Unpack(mapping) => self.expr(mapping),
            }),
            ExprKind::Comprehension(comprehension) => self.comprehension(comprehension),
            ExprKind::Lambda(lambda) => {
                self.parameters(&mut lambda.parameters);
                self.expr(&mut lambda.body);
                self.scope(&mut lambda.scope);
            }
            ExprKind::IfElse { test, body, orelse } => {
                self.expr(test);
                self.expr(body);
                self.expr(orelse);
            }
            ExprKind::Named { target, value } => {
                self.ident(target);
                self.expr(value);
            }
            ExprKind::Yield(value) => {
                value.iter_mut().for_each(|value| self.expr(value));
            }
            ExprKind::FString(parts) => self.fstring(parts),
        }
    }

    fn comprehension(self, comprehension: &mut Comprehension) {
        for clause in &mut comprehension.clauses {
            self.expr(&mut clause.target);
            self.expr(&mut clause.iterable);
            self.exprs(&mut clause.conditions);
        }
        match &mut comprehension.kind {
            ComprehensionKind::List(value)
            | ComprehensionKind::Set(value)
            | ComprehensionKind::Generator(value) => self.expr(value),
            ComprehensionKind::Dict(key, value) => {
                self.expr(key);
                self.expr(value);
            }
        }
        self.scope(&mut comprehension.scope);
    }

    fn fstring(self, parts: &mut [FStringPart]) {
        for part in parts {
            if let FStringPart::Value { value, format, .. } = part {
                self.expr(value);
                format.iter_mut().for_each(|format| self.fstring(format));
            }
        }
    }
}
