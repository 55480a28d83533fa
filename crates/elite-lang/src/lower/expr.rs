//! Expressions.

use std::cell::Cell;
use std::rc::Rc;

use elite_syntax::Span;
use elite_syntax::ast::{
    self, Arg, ComprehensionKind, Constant, Conversion, DictItem, ExprKind, FStringPart, UnaryOp,
};
use elite_syntax::resolve::Storage;

use super::{ISOLATE_MIN, Lower, WORK_PER_NODE};
use crate::eval::BoxExpr;
use crate::eval::expr::arguments::{CallArg, CallUnpacked};
use crate::eval::expr::attribute::{Attribute, InlineCache, ModuleMemberCache};
use crate::eval::expr::binary::{Unary, binary};
use crate::eval::expr::boolean::{And, IfElse, Not, Or};
use crate::eval::expr::call::{Call, CallArgs};
use crate::eval::expr::compare::{ComparisonChain, compare};
use crate::eval::expr::comprehension::{
    Clause, Clauses, DictComprehension, GeneratorExpression, ListComprehension, SetComprehension,
};
use crate::eval::expr::display::{
    DictDisplay, DictElement, Element, ListDisplay, PairDisplay, SetDisplay, TripleDisplay,
    TupleDisplay,
};
use crate::eval::expr::fstring::{FString, FStringSegment};
use crate::eval::expr::item::{Item, SliceAccess, SliceExpr};
use crate::eval::expr::keywords::CallKeywords;
use crate::eval::expr::method::{CallMethod, MethodCache, SuperCall};
use crate::eval::expr::names::{
    ClassBodyName, Const, FreeVar, GlobalVar, LocalCell, LocalVar, MappingName, NamedExpr,
};
use crate::eval::expr::operand::Operand;
use crate::eval::expr::whole::IsolatedExpr;
use crate::eval::expr::yields::{Yield, YieldFrom};
use crate::limits::deferred_drop::NodeList;
use crate::value::symbol::known;
use crate::value::{CellVar, Symbol, Value};

/// Levels of the tree that a clause of a comprehension stands for: its walk and its loop share a native frame.
const CLAUSE_LEVELS: usize = 2;

impl Lower<'_> {
    pub(super) fn expr(&mut self, expr: &ast::Expr) -> BoxExpr {
        if self.charge_and_check(WORK_PER_NODE) {
            return Box::new(Const(Value::None));
        }
        let before = self.nodes_since_list;
        let node = self.deeper(|lower| lower.expr_here(expr));
        self.nodes_since_list += 1;
        // A list that was made meanwhile can be dropped bit by bit, what is around it cannot.
        if self.nodes_since_list.saturating_sub(before) < ISOLATE_MIN {
            return node;
        }
        self.nodes_since_list = before;
        self.deepest += 1;
        Box::new(IsolatedExpr([node].into_iter().collect()))
    }

    fn boxed(&mut self, expr: &Option<Box<ast::Expr>>) -> Option<BoxExpr> {
        expr.as_ref().map(|expr| self.expr(expr))
    }

    pub(super) fn exprs(&mut self, exprs: &[ast::Expr]) -> NodeList<BoxExpr> {
        exprs.iter().map(|expr| self.expr(expr)).collect()
    }

    fn expr_here(&mut self, expr: &ast::Expr) -> BoxExpr {
        let span = expr.span;
        match &expr.kind {
            ExprKind::Constant(constant) => Box::new(Const(self.constant(constant))),
            ExprKind::Name(name) => self.name(name, span),
            ExprKind::And(operands) => Box::new(And(self.operands(operands))),
            ExprKind::Or(operands) => Box::new(Or(self.operands(operands))),
            ExprKind::Binary { op, left, right } => {
                if let Some(node) = self.percent_format(*op, left, right, span) {
                    return node;
                }
                let (left, right) = (self.operand(left), self.operand(right));
                binary(*op, left, right, span)
            }
            ExprKind::Unary { op, operand } => self.unary(*op, operand, span),
            ExprKind::Compare { left, rest } => self.comparison(left, rest, span),
            ExprKind::Call { function, args } => self.call(function, args, span),
            ExprKind::Attribute { value, name } => Box::new(self.attribute(value, name, span)),
            ExprKind::Subscript { value, index } => match part_of(index) {
                Some((lower, upper)) => Box::new(self.sliced(value, lower, upper, span)),
                None => Box::new(self.item(value, index, span)),
            },
            ExprKind::Slice { lower, upper, step } => {
                let (lower, upper, step) = (self.boxed(lower), self.boxed(upper), self.boxed(step));
                Box::new(SliceExpr { lower, upper, step })
            }
            ExprKind::List(items) => Box::new(ListDisplay(self.elements(items))),
            ExprKind::Tuple(items) => self.tuple(items),
            ExprKind::Set(items) => {
                let all_constant = items
                    .iter()
                    .all(|item| matches!(item.kind, ExprKind::Constant(_)));
                let copied = items.len() >= 3 && all_constant;
                Box::new(SetDisplay {
                    elements: self.elements(items),
                    copied,
                    span,
                })
            }
            ExprKind::Dict(items) => Box::new(DictDisplay(self.dict_elements(items), span)),
            ExprKind::Comprehension(comprehension) => self.comprehension(comprehension, span),
            ExprKind::Lambda(lambda) => Box::new(self.lambda(lambda, span)),
            ExprKind::IfElse { test, body, orelse } => {
                let test = self.operand(test);
                let (body, orelse) = (self.operand(body), self.operand(orelse));
                Box::new(IfElse { test, body, orelse })
            }
            ExprKind::Named { target, value } => Box::new(NamedExpr {
                target: self.name_target(&target.name, target.span),
                value: self.expr(value),
            }),
            // Stars are handled by what they stand in.
            ExprKind::Starred(inner) => self.expr(inner),
            ExprKind::Yield(value) => Box::new(Yield {
                value: self.boxed(value),
                span,
            }),
            ExprKind::YieldFrom(value) => Box::new(YieldFrom {
                value: self.expr(value),
                span,
            }),
            ExprKind::FString(parts) => Box::new(FString(self.parts(parts))),
        }
    }

    /// A node that reads a name.
    pub(super) fn name(&mut self, name: &str, span: Span) -> BoxExpr {
        if let Some(slot) = self.mapping(name, false) {
            return Box::new(MappingName {
                slot,
                key: Value::str(name),
                global: self.global(name, span),
            });
        }
        match self.place(name) {
            Storage::Local(slot) => Box::new(LocalVar { slot, span }),
            Storage::Cell(slot) => Box::new(LocalCell { slot, span }),
            Storage::Free(index) => Box::new(FreeVar { index, span }),
            Storage::Global => Box::new(self.global(name, span)),
            Storage::Class(slot) => Box::new(ClassBodyName {
                slot,
                global: self.global(name, span),
            }),
        }
    }

    pub(super) fn global(&self, name: &str, span: Span) -> GlobalVar {
        let name = self.symbol(name);
        GlobalVar {
            cell: self.variable(name),
            builtin: self.fallback_cell(name),
            name,
            span,
        }
    }

    /// What a name means while its variable is not bound: the builtin or, in texts with variables of their own, what
    /// the namespace behind has.
    fn fallback_cell(&self, name: Symbol) -> Rc<CellVar> {
        let own = self.namespace.builtins();
        if name == known::NAME && own.is_none() && self.namespace.is_in_dictionary() {
            // In a dictionary without a name the name is that of the builtins; in the program it is the program's.
            return self.core.name_of_builtins.clone();
        }
        let builtins = own.unwrap_or(&self.core.builtins);
        match self.namespace.shadowed_cell(name) {
            Some(cell) if builtins.get(name).is_none() => cell,
            _ => builtins.cell(name),
        }
    }

    /// A part of a node, as what it is.
    pub(super) fn operand(&mut self, expr: &ast::Expr) -> Operand {
        if self.charge_and_check(WORK_PER_NODE / 2) {
            return Operand::Const(Value::None);
        }
        match &expr.kind {
            ExprKind::Constant(constant) => Operand::Const(self.constant(constant)),
            ExprKind::Name(name) => match self.place(name) {
                Storage::Local(slot) => Operand::Local(LocalVar {
                    slot,
                    span: expr.span,
                }),
                Storage::Free(index) => Operand::Free(FreeVar {
                    index,
                    span: expr.span,
                }),
                Storage::Global if self.mapping(name, false).is_some() => {
                    Operand::Expr(self.expr(expr))
                }
                Storage::Global => Operand::Global(self.global(name, expr.span)),
                Storage::Cell(_) | Storage::Class(_) => Operand::Expr(self.expr(expr)),
            },
            ExprKind::Unary {
                op: UnaryOp::Neg,
                operand,
            } => match &operand.kind {
                ExprKind::Constant(Constant::Int(int)) => Operand::Const(Value::Int(-int)),
                ExprKind::Constant(Constant::Float(float)) => Operand::Const(Value::Float(-float)),
                _ => Operand::Expr(self.expr(expr)),
            },
            ExprKind::Attribute { value, name } => {
                let attribute = self.deeper(|lower| lower.attribute(value, name, expr.span));
                Operand::Attribute(Box::new(attribute))
            }
            ExprKind::Subscript { value, index } if part_of(index).is_none() => {
                let item = self.deeper(|lower| lower.item(value, index, expr.span));
                Operand::Item(Box::new(item))
            }
            _ => Operand::Expr(self.expr(expr)),
        }
    }

    fn item(&mut self, value: &ast::Expr, index: &ast::Expr, span: Span) -> Item {
        Item {
            value: self.operand(value),
            index: self.operand(index),
            span,
        }
    }

    fn sliced(
        &mut self,
        value: &ast::Expr,
        lower: Option<&ast::Expr>,
        upper: Option<&ast::Expr>,
        span: Span,
    ) -> SliceAccess {
        let value = self.operand(value);
        let mut bound = |bound: Option<&ast::Expr>| match bound {
            Some(bound) => self.operand(bound),
            None => Operand::Const(Value::None),
        };
        let (lower, upper) = (bound(lower), bound(upper));
        SliceAccess {
            value,
            lower,
            upper,
            span,
        }
    }

    fn attribute(&mut self, value: &ast::Expr, name: &ast::Ident, span: Span) -> Attribute {
        let (value, name) = (self.operand(value), self.symbol(&name.name));
        Attribute {
            value,
            name,
            span,
            cache: InlineCache::default(),
            member: ModuleMemberCache::default(),
        }
    }

    fn operands(&mut self, exprs: &[ast::Expr]) -> NodeList<Operand> {
        exprs.iter().map(|expr| self.operand(expr)).collect()
    }

    fn unary(&mut self, op: UnaryOp, operand: &ast::Expr, span: Span) -> BoxExpr {
        if op == UnaryOp::Not {
            return Box::new(Not(self.operand(operand)));
        }
        match (op, &operand.kind) {
            (UnaryOp::Neg, ExprKind::Constant(Constant::Int(int))) => {
                Box::new(Const(Value::Int(-int)))
            }
            (UnaryOp::Neg, ExprKind::Constant(Constant::Float(float))) => {
                Box::new(Const(Value::Float(-float)))
            }
            _ => Box::new(Unary {
                op,
                operand: self.expr(operand),
                span,
            }),
        }
    }

    fn comparison(
        &mut self,
        left: &ast::Expr,
        rest: &[(ast::CompareOp, ast::Expr)],
        span: Span,
    ) -> BoxExpr {
        if let [(op, right)] = rest {
            let (left, right) = (self.operand(left), self.operand(right));
            return compare(*op, left, right, span);
        }
        let first = self.expr(left);
        let rest = rest
            .iter()
            .map(|(op, right)| (*op, self.expr(right)))
            .collect();
        Box::new(ComparisonChain { first, rest, span })
    }

    fn call(&mut self, function: &ast::Expr, args: &[Arg], span: Span) -> BoxExpr {
        let is_super = matches!(&function.kind, ExprKind::Name(name) if &**name == "super");
        if is_super && args.is_empty() {
            return self.super_call(function, span);
        }
        let mut names = std::collections::BTreeSet::new();
        let unusual = args.iter().any(|arg| match arg {
            Arg::Positional(_) => false,
            // A name given twice is an error that `CallUnpacked` tells of.
            Arg::Keyword(name, _) => !names.insert(&*name.name),
            Arg::Star(_) | Arg::DoubleStar(_) => true,
        });
        if unusual {
            let function = self.expr(function);
            return Box::new(CallUnpacked {
                function,
                args: self.call_args(args),
                span,
            });
        }
        let mut plain: Vec<&ast::Expr> = Vec::new();
        let mut named = Vec::new();
        for arg in args {
            match arg {
                Arg::Keyword(name, expr) => named.push((name, expr)),
                Arg::Positional(expr) | Arg::Star(expr) | Arg::DoubleStar(expr) => plain.push(expr),
            }
        }
        if !named.is_empty() {
            let function = self.expr(function);
            let args = plain.iter().map(|arg| self.operand(arg)).collect();
            let named = named.into_iter();
            let keywords = named.map(|(name, expr)| (self.symbol(&name.name), self.operand(expr)));
            return Box::new(CallKeywords {
                function,
                args,
                keywords: keywords.collect(),
                span,
            });
        }
        let args = |lower: &mut Self| plain.iter().map(|arg| lower.operand(arg)).collect();
        if let ExprKind::Attribute { value, name } = &function.kind {
            let (receiver, name) = (self.operand(value), self.symbol(&name.name));
            let (attribute_span, cache) = (function.span, InlineCache::default());
            return Box::new(CallMethod {
                methods: MethodCache::default(),
                quick: Cell::default(),
                receiver,
                name,
                site: CallArgs::new(args(self), span),
                attribute_span,
                cache,
                member: ModuleMemberCache::default(),
            });
        }
        Box::new(Call {
            function: self.operand(function),
            site: CallArgs::new(args(self), span),
        })
    }

    pub(super) fn call_args(&mut self, args: &[Arg]) -> NodeList<CallArg> {
        let arg = |arg: &Arg| match arg {
            Arg::Positional(expr) => CallArg::Positional(self.expr(expr)),
            Arg::Star(expr) => CallArg::Star(self.expr(expr)),
            Arg::Keyword(name, expr) => CallArg::Keyword(self.symbol(&name.name), self.expr(expr)),
            Arg::DoubleStar(expr) => CallArg::DoubleStar(self.expr(expr)),
        };
        args.iter().map(arg).collect()
    }

    fn super_call(&mut self, function: &ast::Expr, span: Span) -> BoxExpr {
        let in_class = self.place("__class__") != Storage::Global;
        let callee = self.expr(function);
        if !in_class {
            return Box::new(Call {
                function: Operand::Expr(callee),
                site: CallArgs::new(NodeList::default(), span),
            });
        }
        let class = self.name("__class__", span);
        let receiver = self.first_parameter(span);
        Box::new(SuperCall {
            function: callee,
            class,
            receiver,
            span,
        })
    }

    fn elements(&mut self, items: &[ast::Expr]) -> NodeList<Element> {
        let element = |item: &ast::Expr| match &item.kind {
            ExprKind::Starred(inner) => Element::Star(self.expr(inner), item.span),
            _ => Element::One(self.operand(item)),
        };
        items.iter().map(element).collect()
    }

    /// A tuple; one of constants is a constant.
    fn tuple(&mut self, items: &[ast::Expr]) -> BoxExpr {
        if items
            .iter()
            .any(|item| matches!(item.kind, ExprKind::Starred(_)))
        {
            return Box::new(TupleDisplay(self.elements(items)));
        }
        let parts: Vec<Operand> = items.iter().map(|item| self.operand(item)).collect();
        let constants: Option<Vec<Value>> = parts
            .iter()
            .map(|part| match part {
                Operand::Const(value) => Some(value.clone()),
                _ => None,
            })
            .collect();
        if let Some(values) = constants {
            return Box::new(Const(Value::tuple(values)));
        }
        let parts = match <[Operand; 2]>::try_from(parts) {
            Ok(pair) => return Box::new(PairDisplay(pair)),
            Err(parts) => parts,
        };
        match <[Operand; 3]>::try_from(parts) {
            Ok(triple) => Box::new(TripleDisplay(triple)),
            Err(parts) => Box::new(TupleDisplay(parts.into_iter().map(Element::One).collect())),
        }
    }

    fn dict_elements(&mut self, items: &[DictItem]) -> NodeList<DictElement> {
        let element = |item: &DictItem| match item {
            DictItem::Pair(key, value) => DictElement::Pair(self.expr(key), self.expr(value)),
            DictItem::Unpack(mapping) => DictElement::Unpack(self.expr(mapping)),
        };
        items.iter().map(element).collect()
    }

    fn parts(&mut self, parts: &[FStringPart]) -> NodeList<FStringSegment> {
        let part = |part: &FStringPart| match part {
            FStringPart::Text(text) => FStringSegment::Text(text.clone()),
            FStringPart::Value {
                value,
                conversion,
                format,
            } => {
                let span = value.span;
                let (spec, nested) = match format.as_deref() {
                    None | Some([]) => ("".into(), None),
                    Some([FStringPart::Text(text)]) => (text.clone(), None),
                    Some(parts) => ("".into(), Some(self.parts(parts))),
                };
                let conversion: Conversion = *conversion;
                FStringSegment::Field {
                    value: self.expr(value),
                    conversion,
                    spec,
                    nested,
                    span,
                }
            }
        };
        parts.iter().map(part).collect()
    }

    /// The clauses of a comprehension; the first iterable has been made in the scope around already.
    /// The clauses of a comprehension. Each runs within the one before it, and what is collected within the last one:
    /// afterwards the tree is deeper by [`CLAUSE_LEVELS`] for each.
    fn clauses(&mut self, comprehension: &ast::Comprehension, first: BoxExpr) -> NodeList<Clause> {
        let mut first = Some(first);
        let clause = |clause: &ast::ComprehensionClause| {
            self.depth += CLAUSE_LEVELS;
            self.deepest = self.deepest.max(self.depth);
            let iterable = match first.take() {
                Some(iterable) => iterable,
                None => self.expr(&clause.iterable),
            };
            let target = self.loop_target(&clause.target);
            let conditions = self.exprs(&clause.conditions);
            Clause {
                target,
                iterable,
                conditions,
                span: clause.iterable.span,
            }
        };
        comprehension.clauses.iter().map(clause).collect()
    }

    fn comprehension(&mut self, comprehension: &ast::Comprehension, span: Span) -> BoxExpr {
        let Some(first) = comprehension.clauses.first() else {
            return Box::new(Const(Value::None));
        };
        let iterable = self.expr(&first.iterable);
        if let ComprehensionKind::Generator(element) = &comprehension.kind {
            let function = self.generator_expression(comprehension, element, span);
            return Box::new(GeneratorExpression {
                function,
                iterable,
                span: first.iterable.span,
            });
        }
        let places = self.places(comprehension.scope);
        let (slots, fresh_cells) = (
            places.slots.clone().into(),
            places.fresh_cells.clone().into(),
        );
        let outer = std::mem::replace(&mut self.scope, comprehension.scope);
        // Functions within are named as if it were a function, which it is in CPython 3.11.
        let kind = match &comprehension.kind {
            ComprehensionKind::Set(_) => "<setcomp>",
            ComprehensionKind::Dict(..) => "<dictcomp>",
            ComprehensionKind::List(_) | ComprehensionKind::Generator(_) => "<listcomp>",
        };
        let prefix = format!("{}{kind}.", self.prefix);
        let outer_prefix = std::mem::replace(&mut self.prefix, prefix);
        let outer_depth = self.depth;
        let clauses = Clauses {
            clauses: self.clauses(comprehension, iterable),
            slots,
            fresh_cells,
        };
        let node: BoxExpr = match &comprehension.kind {
            ComprehensionKind::List(element) => Box::new(ListComprehension {
                element: self.expr(element),
                clauses,
            }),
            ComprehensionKind::Set(element) => Box::new(SetComprehension {
                element: self.expr(element),
                clauses,
                span,
            }),
            ComprehensionKind::Dict(key, value) => Box::new(DictComprehension {
                key: self.expr(key),
                value: self.expr(value),
                clauses,
                span,
            }),
            ComprehensionKind::Generator(_) => Box::new(Const(Value::None)),
        };
        self.depth = outer_depth;
        self.scope = outer;
        self.prefix = outer_prefix;
        node
    }
}

/// The bounds of a slice without a step.
fn part_of(index: &ast::Expr) -> Option<(Option<&ast::Expr>, Option<&ast::Expr>)> {
    match &index.kind {
        ExprKind::Slice {
            lower,
            upper,
            step: None,
        } => Some((lower.as_deref(), upper.as_deref())),
        _ => None,
    }
}

/// Whether evaluating `expr` certainly leaves the local variables of its own frame as they are.
pub(super) fn keeps_locals(expr: &ast::Expr) -> bool {
    match &expr.kind {
        ExprKind::Constant(_) | ExprKind::Name(_) => true,
        ExprKind::Binary { left, right, .. } => keeps_locals(left) && keeps_locals(right),
        ExprKind::Unary { operand, .. } => keeps_locals(operand),
        ExprKind::Attribute { value, .. } => keeps_locals(value),
        ExprKind::Subscript { value, index } => keeps_locals(value) && keeps_locals(index),
        _ => false,
    }
}
