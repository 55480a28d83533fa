//! Functions, lambdas, generator expressions and classes: code objects of their own.

use elite_syntax::Span;
use elite_syntax::ast::{self, Constant, ExprKind, Stmt, StmtKind};
use elite_syntax::resolve::{FrameLayout, Storage};

use crate::limits::deferred_drop::NodeList;
use std::rc::Rc;

use super::{FrameInfo, Lower, WORK_PER_NODE};
use crate::eval::BoxExpr;
use crate::eval::code::{Body, Code, CodeKind, Params};
use crate::eval::expr::enter::EntryPoints;
use crate::eval::expr::function::{Annotations, MakeFunction};
use crate::eval::expr::names::LocalVar;
use crate::eval::stmt::define::{DefineClass, DefineFunction};
use crate::value::Value;

/// Work for the name of a parameter.
const PARAMETER: usize = 200;

/// What a code object is made of.
struct CodeSpec<'p> {
    name: &'p str,
    doc: Option<Rc<str>>,
    params: Params,
    layout: &'p FrameLayout,
    body: Body,
    extent: FrameInfo,
    span: Span,
}

impl Lower<'_> {
    fn code(&self, parts: CodeSpec<'_>) -> Rc<Code> {
        let layout = parts.layout;
        let kind = match layout.is_generator {
            true => CodeKind::Generator,
            false => CodeKind::Plain,
        };
        let code = Rc::new(Code {
            entries: EntryPoints::for_code(kind, &parts.params, layout.slot_names.len()),
            name: parts.name.into(),
            qualname: format!("{}{}", self.prefix, parts.name).into(),
            doc: parts.doc,
            file: self.file.clone(),
            span: parts.span,
            params: parts.params,
            slots: layout.slot_names.len(),
            slot_names: self.symbols(layout),
            free_names: layout
                .closure
                .iter()
                .map(|(name, _)| self.symbol(name))
                .collect(),
            cells: layout.cells.clone().into(),
            kind,
            body: parts.body,
            names: self.names.clone(),
            module: Some(Rc::downgrade(self.namespace)),
            stack_bytes: parts.extent.stack_bytes,
            refs: parts.extent.refers,
        });
        self.refers.borrow_mut().codes.push(code.clone());
        code
    }

    fn params(&self, parameters: &ast::Parameters) -> Params {
        let by_name = parameters
            .positional_only
            .iter()
            .chain(&parameters.positional)
            .chain(&parameters.keyword_only);
        let names: Box<[_]> = by_name
            .map(|parameter| {
                self.budget.charge(PARAMETER);
                self.symbol(&parameter.name.name)
            })
            .collect();
        let star = parameters.star.as_ref().map(|_| names.len());
        let double_star = parameters
            .double_star
            .as_ref()
            .map(|_| names.len() + usize::from(star.is_some()));
        Params {
            positional_only: parameters.positional_only.len(),
            positional: parameters.positional_only.len() + parameters.positional.len(),
            names,
            star,
            double_star,
        }
    }

    fn annotations(
        &mut self,
        parameters: &ast::Parameters,
        returns: Option<&ast::Expr>,
    ) -> Option<Box<Annotations>> {
        // In the order of CPython: `*args` and `**kwargs` where they are written.
        let by_place = parameters
            .positional_only
            .iter()
            .chain(&parameters.positional)
            .chain(&parameters.star)
            .chain(&parameters.keyword_only)
            .chain(&parameters.double_star);
        let named = by_place
            .filter_map(|parameter| Some((&*parameter.name.name, parameter.annotation.as_ref()?)));
        let result = returns.map(|returns| ("return", returns));
        let all: Vec<_> = named
            .chain(result)
            .map(|(name, annotation)| {
                let text = self.file.slice(annotation.span);
                let name = self.core.symbols.to_value(self.symbol(name));
                (name, self.expr(annotation), Value::str(text))
            })
            .collect();
        (!all.is_empty()).then(|| Box::new(Annotations(all)))
    }

    fn make_function(
        &mut self,
        parameters: &ast::Parameters,
        code: Rc<Code>,
        layout: &FrameLayout,
    ) -> MakeFunction {
        let positional = parameters
            .positional_only
            .iter()
            .chain(&parameters.positional);
        let defaults: Vec<&ast::Expr> = positional
            .filter_map(|parameter| parameter.default.as_ref())
            .collect();
        let defaults = defaults
            .into_iter()
            .map(|default| self.expr(default))
            .collect();
        let keyword = |parameter: &ast::Parameter| {
            parameter.default.as_ref().map(|default| self.expr(default))
        };
        let keyword_defaults = parameters.keyword_only.iter().map(keyword).collect();
        MakeFunction {
            code,
            defaults,
            keyword_defaults,
            closure: closure(layout),
            annotations: None,
        }
    }

    pub(super) fn define_function(&mut self, def: &ast::FunctionDef, span: Span) -> DefineFunction {
        let decorators = self.decorators(&def.decorators);
        let layout = self.layout(def.scope);
        let prefix = format!("{}{}.<locals>.", self.prefix, def.name.name);
        let (body, extent) = self.frame(def.scope, prefix, |lower| match layout.is_generator {
            true => lower.generator_body(&def.body),
            false => lower.function_body(&def.body),
        });
        let code = self.code(CodeSpec {
            name: &def.name.name,
            doc: docstring(&def.body),
            params: self.params(&def.parameters),
            layout,
            body,
            extent,
            span,
        });
        let mut function = self.make_function(&def.parameters, code, layout);
        function.annotations = self.annotations(&def.parameters, def.returns.as_ref());
        DefineFunction {
            function,
            decorators,
            target: self.name_target(&def.name.name, def.name.span),
        }
    }

    /// A body that is no generator's. A single `return` needs no block, unless somebody looks at single statements.
    fn function_body(&mut self, body: &[Stmt]) -> Body {
        let is_seen =
            self.counters.is_some() || self.debugger.is_some() || !self.node_directives.is_empty();
        let (doc, rest) = match body {
            [doc, rest @ ..] if docstring(body).is_some() => (Some(doc), rest),
            _ => (None, body),
        };
        if let [statement] = rest
            && let StmtKind::Return(Some(value)) = &statement.kind
            && !is_seen
            && !self.charge_and_check(WORK_PER_NODE * (1 + usize::from(doc.is_some())))
        {
            let line = self.line(statement.span);
            return Body::Return(line, self.deeper(|lower| lower.expr(value)));
        }
        Body::Block(self.block(body))
    }

    fn decorators(&mut self, decorators: &[ast::Expr]) -> NodeList<(BoxExpr, Span)> {
        decorators
            .iter()
            .map(|decorator| (self.expr(decorator), decorator.span))
            .collect()
    }

    pub(super) fn lambda(&mut self, lambda: &ast::Lambda, span: Span) -> MakeFunction {
        let layout = self.layout(lambda.scope);
        let prefix = format!("{}<lambda>.<locals>.", self.prefix);
        let (body, extent) = self.frame(lambda.scope, prefix, |lower| lower.expr(&lambda.body));
        let code = self.code(CodeSpec {
            name: "<lambda>",
            doc: None,
            params: self.params(&lambda.parameters),
            layout,
            body: Body::Expression(body),
            extent,
            span,
        });
        self.make_function(&lambda.parameters, code, layout)
    }

    pub(super) fn generator_expression(
        &mut self,
        comprehension: &ast::Comprehension,
        element: &ast::Expr,
        span: Span,
    ) -> MakeFunction {
        let layout = self.layout(comprehension.scope);
        let prefix = format!("{}<genexpr>.", self.prefix);
        let (body, extent) = self.frame(comprehension.scope, prefix, |lower| {
            let first: BoxExpr = Box::new(LocalVar { slot: 0, span });
            lower.generator_expression_body(comprehension, first, element)
        });
        let params = Params {
            names: Box::new([self.symbol(".0")]),
            positional_only: 1,
            positional: 1,
            ..Params::default()
        };
        let code = self.code(CodeSpec {
            name: "<genexpr>",
            doc: None,
            params,
            layout,
            body,
            extent,
            span,
        });
        MakeFunction {
            code,
            defaults: NodeList::default(),
            keyword_defaults: NodeList::default(),
            closure: closure(layout),
            annotations: None,
        }
    }

    pub(super) fn define_class(&mut self, def: &ast::ClassDef, span: Span) -> DefineClass {
        let decorators = self.decorators(&def.decorators);
        let args = self.call_args(&def.args);
        let layout = self.layout(def.scope);
        let prefix = format!("{}{}.", self.prefix, def.name.name);
        let (body, extent) = self.frame(def.scope, prefix, |lower| lower.block(&def.body));
        let code = self.code(CodeSpec {
            name: &def.name.name,
            doc: docstring(&def.body),
            params: Params::default(),
            layout,
            body: Body::Block(body),
            extent,
            span,
        });
        DefineClass {
            code,
            closure: closure(layout),
            args,
            names: layout.class_names as usize,
            class_cell: layout.class_cell,
            decorators,
            target: self.name_target(&def.name.name, def.name.span),
            span: def.name.span,
        }
    }

    /// Reads the first parameter of the function around; None if it has none.
    pub(super) fn first_parameter(&mut self, span: Span) -> Option<BoxExpr> {
        let layout = self.layout(self.frame_scope);
        let name = layout.slot_names.first()?.clone();
        let outer = std::mem::replace(&mut self.scope, self.frame_scope);
        let place = self.place(&name);
        self.scope = outer;
        Some(match place {
            Storage::Cell(slot) => Box::new(crate::eval::expr::names::LocalCell { slot, span }),
            Storage::Local(slot) => Box::new(LocalVar { slot, span }),
            _ => return None,
        })
    }
}

fn closure(layout: &FrameLayout) -> Box<[Storage]> {
    layout
        .closure
        .iter()
        .map(|(_, place)| place.clone())
        .collect()
}

/// The documentation string a body starts with.
fn docstring(body: &[Stmt]) -> Option<Rc<str>> {
    let first = body.first()?;
    let StmtKind::Expr(expr) = &first.kind else {
        return None;
    };
    match &expr.kind {
        ExprKind::Constant(Constant::Str(text)) => Some((&**text).into()),
        _ => None,
    }
}
