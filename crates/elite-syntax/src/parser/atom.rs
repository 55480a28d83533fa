//! Atoms and what can follow them: calls, items, attributes, displays and comprehensions.

use std::collections::BTreeSet;

use messages::{Text, text};

use super::{ErrorReported, ParseResult, Parser};
use crate::ast::{
    Arg, Comprehension, ComprehensionClause, ComprehensionKind, Constant, DictItem, Expr, ExprKind,
};
use crate::diagnostic::Diagnostic;
use crate::diagnostic_list::quoted;
use crate::lexer::TokenKind as T;
use crate::source::Span;

/// What arguments belong to.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum ArgContext {
    /// The only one may be a generator expression without brackets of its own.
    OfCall,
    /// The bases of a class, and what its metaclass gets.
    OfClass,
}

/// What the arguments before one say about it.
#[derive(Default)]
struct SeenArgs {
    any: bool,
    /// There is a `**` among them.
    mapping: bool,
    keywords: BTreeSet<Box<str>>,
}

impl SeenArgs {
    fn note(&mut self, arg: &Arg) {
        self.any = true;
        match arg {
            Arg::Keyword(name, _) => {
                self.keywords.insert(name.name.clone());
            }
            Arg::DoubleStar(_) => self.mapping = true,
            Arg::Positional(_) | Arg::Star(_) => {}
        }
    }
}

impl Parser<'_> {
    /// An atom with the calls, subscripts and attributes after it.
    pub(super) fn postfix(&mut self) -> ParseResult<Expr> {
        let start = self.token().span;
        let mut expr = self.atom()?;
        loop {
            let kind = match self.kind() {
                T::LeftParen => {
                    self.bump();
                    let args = self.arguments(ArgContext::OfCall);
                    let (function, args) = self.keep_or_abandon(expr, args)?;
                    ExprKind::Call {
                        function: Box::new(function),
                        args,
                    }
                }
                T::LeftBracket => {
                    self.bump();
                    let index = self.subscript_index();
                    let (value, index) = self.keep_or_abandon(expr, index)?;
                    let closed = self.expect(T::RightBracket);
                    let (index, _) = self.keep_or_abandon(index, closed)?;
                    ExprKind::Subscript {
                        value: Box::new(value),
                        index: Box::new(index),
                    }
                }
                T::Dot => {
                    self.bump();
                    let name = self.ident()?;
                    ExprKind::Attribute {
                        value: Box::new(expr),
                        name,
                    }
                }
                _ => return Ok(expr),
            };
            expr = self.check_depth(Expr::new(kind, self.span_from(start)))?;
        }
    }

    fn atom(&mut self) -> ParseResult<Expr> {
        let token = self.token();
        let kind = match token.kind {
            T::Name => return self.name_expr(),
            T::Int | T::Float | T::Imaginary => self.number()?,
            T::Str => return self.strings(),
            T::None => self.constant(Constant::None),
            T::True => self.constant(Constant::Bool(true)),
            T::False => self.constant(Constant::Bool(false)),
            T::Ellipsis => self.constant(Constant::Ellipsis),
            T::LeftParen => return self.parenthesised(),
            T::LeftBracket => return self.list_display(),
            T::LeftBrace => return self.brace_display(),
            _ => return self.unexpected(text!("an expression", "表达式")),
        };
        Ok(Expr::new(kind, token.span))
    }

    fn constant(&mut self, constant: Constant) -> ExprKind {
        self.bump();
        ExprKind::Constant(constant)
    }

    fn parenthesised(&mut self) -> ParseResult<Expr> {
        let start = self.bump().span;
        if self.eat(T::RightParen).is_some() {
            return Ok(Expr::new(
                ExprKind::Tuple(Vec::new()),
                self.span_from(start),
            ));
        }
        if self.kind() == T::Yield {
            let inner = self.yield_expression()?;
            self.expect(T::RightParen)?;
            return Ok(Expr::new(inner.kind, self.span_from(start)));
        }
        let first = self.star_or_named()?;
        if matches!(self.kind(), T::For | T::Async) {
            let comprehension = self.comprehension(ComprehensionKind::Generator(first))?;
            self.expect(T::RightParen)?;
            return Ok(Expr::new(comprehension, self.span_from(start)));
        }
        if self.kind() != T::Comma {
            self.check_no_star(&first)?;
            let closed = self.expect(T::RightParen);
            let (first, _) = self.keep_or_abandon(first, closed)?;
            let span = self.span_from(start);
            return Ok(Expr { span, ..first });
        }
        let items = self.more_items(first, T::RightParen)?;
        Ok(Expr::new(ExprKind::Tuple(items), self.span_from(start)))
    }

    fn list_display(&mut self) -> ParseResult<Expr> {
        let start = self.bump().span;
        if self.eat(T::RightBracket).is_some() {
            return Ok(Expr::new(ExprKind::List(Vec::new()), self.span_from(start)));
        }
        let first = self.star_or_named()?;
        if matches!(self.kind(), T::For | T::Async) {
            let kind = self.comprehension(ComprehensionKind::List(first))?;
            self.expect(T::RightBracket)?;
            return Ok(Expr::new(kind, self.span_from(start)));
        }
        let items = self.more_items(first, T::RightBracket)?;
        Ok(Expr::new(ExprKind::List(items), self.span_from(start)))
    }

    /// The items after the first one, and the closing bracket.
    fn more_items(&mut self, first: Expr, closer: T) -> ParseResult<Vec<Expr>> {
        let mut items = vec![first];
        while self.eat(T::Comma).is_some() {
            if self.kind() == closer {
                break;
            }
            let item = self.star_or_named();
            items = self.push_or_abandon(items, item)?;
        }
        let closed = self.close(closer);
        self.keep_or_abandon(items, closed).map(|(items, ())| items)
    }

    fn close(&mut self, closer: T) -> ParseResult<()> {
        if self.eat(closer).is_some() {
            return Ok(());
        }
        if self.starts_expression() {
            return self.unexpected(text!("',' or {}", "',' 或{}", closer.describe()));
        }
        self.unexpected(closer.describe())
    }

    fn brace_display(&mut self) -> ParseResult<Expr> {
        let start = self.bump().span;
        if self.eat(T::RightBrace).is_some() {
            return Ok(Expr::new(ExprKind::Dict(Vec::new()), self.span_from(start)));
        }
        let kind = if self.kind() == T::DoubleStar {
            self.dict_items(Vec::new())?
        } else {
            let in_brackets = self.kind() == T::LeftParen;
            let first = self.star_or_named()?;
            if self.kind() == T::Colon
                && !in_brackets
                && let ExprKind::Starred(_) | ExprKind::Named { .. } = first.kind
            {
                return self.unexpected(text!("',' or '}}'", "',' 或 '}}'"));
            }
            if self.eat(T::Colon).is_some() {
                let value = self.expression()?;
                if matches!(self.kind(), T::For | T::Async) {
                    let kind = self.comprehension(ComprehensionKind::Dict(first, value))?;
                    self.expect(T::RightBrace)?;
                    kind
                } else {
                    self.dict_items(vec![DictItem::Pair(first, value)])?
                }
            } else if matches!(self.kind(), T::For | T::Async) {
                let kind = self.comprehension(ComprehensionKind::Set(first))?;
                self.expect(T::RightBrace)?;
                kind
            } else {
                ExprKind::Set(self.more_items(first, T::RightBrace)?)
            }
        };
        Ok(Expr::new(kind, self.span_from(start)))
    }

    /// Further items of a dict display and its closing brace.
    fn dict_items(&mut self, mut items: Vec<DictItem>) -> ParseResult<ExprKind> {
        if !items.is_empty() && self.eat(T::Comma).is_none() {
            let closed = self.close(T::RightBrace);
            let (items, ()) = self.keep_or_abandon(items, closed)?;
            return Ok(ExprKind::Dict(items));
        }
        while self.kind() != T::RightBrace {
            let item = self.dict_item();
            items = self.push_or_abandon(items, item)?;
            if self.eat(T::Comma).is_none() {
                break;
            }
        }
        let closed = self.close(T::RightBrace);
        let (items, ()) = self.keep_or_abandon(items, closed)?;
        Ok(ExprKind::Dict(items))
    }

    fn dict_item(&mut self) -> ParseResult<DictItem> {
        if self.eat(T::DoubleStar).is_some() {
            let mapping = self.nested(|parser| parser.binary(2))?;
            return Ok(DictItem::Unpack(mapping));
        }
        let key = self.expression()?;
        if self.eat(T::Colon).is_none() {
            let failed = self.unexpected_instead_of::<()>(
                Some(T::Colon),
                text!("':' after the dict key", "字典键之后的 ':'"),
            );
            self.keep_or_abandon(key, failed)?;
            return Err(ErrorReported);
        }
        let value = self.expression();
        let (key, value) = self.keep_or_abandon(key, value)?;
        Ok(DictItem::Pair(key, value))
    }

    /// The `for` clauses after the element of a comprehension.
    pub(super) fn comprehension(&mut self, kind: ComprehensionKind) -> ParseResult<ExprKind> {
        let element = match &kind {
            ComprehensionKind::List(e)
            | ComprehensionKind::Set(e)
            | ComprehensionKind::Generator(e) => Some(e),
            ComprehensionKind::Dict(..) => None,
        };
        if let Some(Expr {
            kind: ExprKind::Starred(_),
            span,
            ..
        }) = element
        {
            let span = *span;
            return self.fail(
                span,
                text!(
                    "a comprehension cannot unpack with '*'",
                    "推导式不能用 '*' 解包"
                ),
            );
        }
        let scope = self.new_scope();
        let mut clauses = Vec::new();
        loop {
            if self.kind() == T::Async {
                let span = self.token().span;
                return self.not_supported(span, Text::verbatim("'async'"));
            }
            if self.eat(T::For).is_none() {
                break;
            }
            let target = self.target_list()?;
            self.expect(T::In)?;
            let iterable = self.nested(Self::disjunction)?;
            let mut conditions = Vec::new();
            while self.eat(T::If).is_some() {
                conditions.push(self.condition_without_else()?);
            }
            clauses.push(ComprehensionClause {
                target,
                iterable,
                conditions,
            });
        }
        Ok(ExprKind::Comprehension(Box::new(Comprehension {
            kind,
            clauses,
            scope,
        })))
    }

    /// The condition of a comprehension: no conditional expression, but a name may be bound.
    fn condition_without_else(&mut self) -> ParseResult<Expr> {
        if self.kind() == T::Name && self.kind_ahead(1) == T::ColonEqual {
            return self.named_expression();
        }
        self.nested(Self::disjunction)
    }

    /// The item of a target list: like an expression, but `in` ends it.
    pub(super) fn target_item(&mut self) -> ParseResult<Expr> {
        let start = self.token().span;
        if self.eat(T::Star).is_some() {
            let inner = self.nested(Self::postfix)?;
            return Ok(Expr::new(
                ExprKind::Starred(Box::new(inner)),
                self.span_from(start),
            ));
        }
        self.nested(|parser| parser.binary(2))
    }

    /// Arguments up to and including the closing parenthesis; the opening one is taken already.
    pub(super) fn arguments(&mut self, brackets: ArgContext) -> ParseResult<Vec<Arg>> {
        let mut args: Vec<Arg> = Vec::new();
        let mut earlier = SeenArgs::default();
        while self.kind() != T::RightParen {
            let arg = self.argument(&earlier, brackets);
            args = self.push_or_abandon(args, arg)?;
            if let Some(arg) = args.last() {
                earlier.note(arg);
            }
            if self.eat(T::Comma).is_none() {
                break;
            }
        }
        let closed = self.close(T::RightParen);
        self.keep_or_abandon(args, closed).map(|(args, ())| args)
    }

    fn argument(&mut self, earlier: &SeenArgs, brackets: ArgContext) -> ParseResult<Arg> {
        let start = self.token().span;
        if self.eat(T::Star).is_some() {
            let value = self.expression()?;
            if earlier.mapping {
                let message = text!(
                    "'*' unpacking follows '**' unpacking",
                    "'*' 解包不能在 '**' 解包之后"
                );
                self.report(Diagnostic::error("syntax", self.span_from(start), message));
            }
            return Ok(Arg::Star(value));
        }
        if self.eat(T::DoubleStar).is_some() {
            return Ok(Arg::DoubleStar(self.expression()?));
        }
        if self.kind() == T::Name && self.kind_ahead(1) == T::Equal {
            let name = self.ident()?;
            self.bump();
            let value = self.expression()?;
            if earlier.keywords.contains(&name.name) {
                return self.fail(
                    name.span,
                    text!(
                        "keyword argument '{}' is given twice",
                        "关键字参数 '{}' 重复",
                        quoted(&name.name)
                    ),
                );
            }
            return Ok(Arg::Keyword(name, value));
        }
        let value = self.named_expression()?;
        if brackets == ArgContext::OfCall && matches!(self.kind(), T::For | T::Async) {
            return self.bare_generator(value, !earlier.any, start);
        }
        self.check_argument_order(earlier, value.span)?;
        if self.kind() == T::Equal {
            let span = self.token().span;
            let message = text!(
                "only a name can stand before '=' in a call",
                "调用中 '=' 之前只能是名称"
            );
            let diagnostic = Diagnostic::error("syntax", span, message)
                .with_help(text!("use '==' to compare", "比较请用 '=='"));
            return Err(self.report(diagnostic));
        }
        Ok(Arg::Positional(value))
    }

    /// `f(x for x in y)`: a generator expression without its own parentheses, only as the sole argument.
    fn bare_generator(&mut self, element: Expr, first: bool, start: Span) -> ParseResult<Arg> {
        let kind = self.comprehension(ComprehensionKind::Generator(element))?;
        let span = self.span_from(start);
        if !first || self.kind() == T::Comma {
            return self.fail(
                span,
                text!(
                    "a generator expression needs parentheses unless it is the only argument",
                    "生成器表达式不是唯一的参数时需要括号"
                ),
            );
        }
        Ok(Arg::Positional(Expr::new(kind, span)))
    }

    fn check_argument_order(&mut self, earlier: &SeenArgs, span: Span) -> ParseResult<()> {
        if earlier.mapping {
            return self.fail(
                span,
                text!(
                    "a positional argument follows '**' unpacking",
                    "位置参数不能在 '**' 解包之后"
                ),
            );
        }
        if !earlier.keywords.is_empty() {
            return self.fail(
                span,
                text!(
                    "a positional argument follows a keyword argument",
                    "位置参数不能在关键字参数之后"
                ),
            );
        }
        Ok(())
    }

    /// What stands between `[` and `]` after a value: an index, a slice, or a tuple of them.
    fn subscript_index(&mut self) -> ParseResult<Expr> {
        let start = self.token().span;
        let first = self.slice_item()?;
        if self.kind() != T::Comma {
            return match first.kind {
                ExprKind::Starred(_) => Ok(Expr::new(
                    ExprKind::Tuple(vec![first]),
                    self.span_from(start),
                )),
                _ => Ok(first),
            };
        }
        let mut items = vec![first];
        while self.eat(T::Comma).is_some() && self.kind() != T::RightBracket {
            let item = self.slice_item();
            items = self.push_or_abandon(items, item)?;
        }
        Ok(Expr::new(ExprKind::Tuple(items), self.span_from(start)))
    }

    fn slice_item(&mut self) -> ParseResult<Expr> {
        let start = self.token().span;
        if self.eat(T::Star).is_some() {
            let inner = Box::new(self.expression()?);
            return Ok(Expr::new(ExprKind::Starred(inner), self.span_from(start)));
        }
        let binds_name = self.kind() == T::Name && self.kind_ahead(1) == T::ColonEqual;
        let lower = match self.kind() {
            T::Colon => None,
            _ => Some(self.named_expression()?),
        };
        if self.kind() != T::Colon || binds_name {
            // `lower` is only missing before a colon.
            return lower.map_or_else(|| self.unexpected(text!("an index", "下标")), Ok);
        }
        self.bump();
        let upper = self.slice_bound()?;
        let step = if self.eat(T::Colon).is_some() {
            self.slice_bound()?
        } else {
            None
        };
        let kind = ExprKind::Slice {
            lower: lower.map(Box::new),
            upper,
            step,
        };
        Ok(Expr::new(kind, self.span_from(start)))
    }

    fn slice_bound(&mut self) -> ParseResult<Option<Box<Expr>>> {
        if matches!(self.kind(), T::Colon | T::Comma | T::RightBracket) {
            return Ok(None);
        }
        Ok(Some(Box::new(self.expression()?)))
    }
}
