//! Expressions with operators, by binding power.

use messages::{Text, text};

use super::{EXPR_DEPTH_MAX, ParseResult, Parser};
use crate::ast::{BinaryOp, CompareOp, Expr, ExprKind, Lambda, UnaryOp};
use crate::diagnostic::Diagnostic;
use crate::lexer::TokenKind as T;
use crate::source::Span;

/// Binding powers; a higher one binds tighter. Comparisons and `and`/`or`/`not` have their own functions.
const COMPARISON: u8 = 1;
const POWER: u8 = 9;

fn binary(kind: T) -> Option<(BinaryOp, u8)> {
    Some(match kind {
        T::Bar => (BinaryOp::BitOr, 2),
        T::Caret => (BinaryOp::BitXor, 3),
        T::Ampersand => (BinaryOp::BitAnd, 4),
        T::LeftShift => (BinaryOp::Shl, 5),
        T::RightShift => (BinaryOp::Shr, 5),
        T::Plus => (BinaryOp::Add, 6),
        T::Minus => (BinaryOp::Sub, 6),
        T::Star => (BinaryOp::Mul, 7),
        T::Slash => (BinaryOp::Div, 7),
        T::DoubleSlash => (BinaryOp::FloorDiv, 7),
        T::Percent => (BinaryOp::Mod, 7),
        T::At => (BinaryOp::MatMul, 7),
        T::DoubleStar => (BinaryOp::Pow, POWER),
        _ => return None,
    })
}

impl Parser<'_> {
    /// Expressions separated by commas make a tuple; stars and `yield` are allowed.
    pub(super) fn expression_list(&mut self) -> ParseResult<Expr> {
        if self.kind() == T::Yield {
            return self.yield_expression();
        }
        self.star_list()
    }

    /// `a`, `a, b`, `*a, b`: expressions without `:=` and `yield`, which need brackets around them in a list.
    pub(super) fn star_list(&mut self) -> ParseResult<Expr> {
        let start = self.token().span;
        let first = self.star_or_expression()?;
        if self.kind() != T::Comma {
            return Ok(first);
        }
        let mut items = vec![first];
        while self.eat(T::Comma).is_some() && self.starts_expression() {
            let item = self.star_or_expression();
            items = self.push_or_abandon(items, item)?;
        }
        Ok(Expr::new(ExprKind::Tuple(items), self.span_from(start)))
    }

    fn star_or_expression(&mut self) -> ParseResult<Expr> {
        let expr = if self.kind() == T::Star {
            self.star_or_named()?
        } else {
            self.expression()?
        };
        if self.kind() == T::ColonEqual {
            let span = self.token().span;
            let message = text!(
                "':=' needs parentheses around it here; a statement assigns with '='",
                "这里的 ':=' 需要括号；语句中赋值用 '='"
            );
            return self.fail(span, message);
        }
        Ok(expr)
    }

    /// Whether the current token can start an expression or a starred one.
    pub(super) fn starts_expression(&self) -> bool {
        matches!(
            self.kind(),
            T::Name
                | T::Int
                | T::Float
                | T::Imaginary
                | T::Str
                | T::None
                | T::True
                | T::False
                | T::Not
                | T::Lambda
                | T::LeftParen
                | T::LeftBracket
                | T::LeftBrace
                | T::Minus
                | T::Plus
                | T::Tilde
                | T::Ellipsis
                | T::Star
                | T::Yield
                | T::Await
        )
    }

    /// `*expr`, or an expression that may bind a name.
    pub(super) fn star_or_named(&mut self) -> ParseResult<Expr> {
        let start = self.token().span;
        if self.eat(T::Star).is_some() {
            let inner = self.nested(|parser| parser.binary(COMPARISON + 1))?;
            return Ok(Expr::new(
                ExprKind::Starred(Box::new(inner)),
                self.span_from(start),
            ));
        }
        self.named_expression()
    }

    /// `name := value`, or an expression.
    pub(super) fn named_expression(&mut self) -> ParseResult<Expr> {
        let start = self.token().span;
        if self.kind() == T::Name && self.kind_ahead(1) == T::ColonEqual {
            let target = self.ident()?;
            self.bump();
            let value = Box::new(self.expression()?);
            return Ok(Expr::new(
                ExprKind::Named { target, value },
                self.span_from(start),
            ));
        }
        self.expression()
    }

    /// A conditional expression, a lambda, or anything below.
    pub(super) fn expression(&mut self) -> ParseResult<Expr> {
        let expr = self.nested(|parser| {
            let start = parser.token().span;
            if parser.kind() == T::Lambda {
                return parser.lambda();
            }
            let body = parser.disjunction()?;
            if parser.kind() != T::If {
                return Ok(body);
            }
            parser.bump();
            let test = Box::new(parser.disjunction()?);
            if parser.eat(T::Else).is_none() {
                return parser.unexpected(text!(
                    "'else' of the conditional expression",
                    "条件表达式的 'else'"
                ));
            }
            let orelse = Box::new(parser.expression()?);
            let kind = ExprKind::IfElse {
                test,
                body: Box::new(body),
                orelse,
            };
            Ok(Expr::new(kind, parser.span_from(start)))
        })?;
        self.check_depth(expr)
    }

    fn lambda(&mut self) -> ParseResult<Expr> {
        let start = self.bump().span;
        let scope = self.new_scope();
        let parameters = self.parameters(T::Colon)?;
        self.expect(T::Colon)?;
        let was_in_function = std::mem::replace(&mut self.context.in_function, true);
        let body = self.expression();
        self.context.in_function = was_in_function;
        let kind = ExprKind::Lambda(Box::new(Lambda {
            parameters,
            body: body?,
            scope,
        }));
        Ok(Expr::new(kind, self.span_from(start)))
    }

    pub(super) fn yield_expression(&mut self) -> ParseResult<Expr> {
        let start = self.bump().span;
        if !self.context.in_function {
            let error = Diagnostic::error(
                "syntax",
                start,
                text!("'yield' outside a function", "'yield' 不在函数内"),
            );
            self.report(error);
        }
        let kind = if self.eat(T::From).is_some() {
            ExprKind::YieldFrom(Box::new(self.expression()?))
        } else if self.starts_expression() {
            ExprKind::Yield(Some(Box::new(self.star_list()?)))
        } else {
            ExprKind::Yield(None)
        };
        Ok(Expr::new(kind, self.span_from(start)))
    }

    /// `a or b or c`
    pub(super) fn disjunction(&mut self) -> ParseResult<Expr> {
        let start = self.token().span;
        let first = self.conjunction()?;
        if self.kind() != T::Or {
            return Ok(first);
        }
        let mut operands = vec![first];
        while self.eat(T::Or).is_some() {
            let operand = self.conjunction();
            operands = self.push_or_abandon(operands, operand)?;
        }
        Ok(Expr::new(ExprKind::Or(operands), self.span_from(start)))
    }

    fn conjunction(&mut self) -> ParseResult<Expr> {
        let start = self.token().span;
        let first = self.negation()?;
        if self.kind() != T::And {
            return Ok(first);
        }
        let mut operands = vec![first];
        while self.eat(T::And).is_some() {
            let operand = self.negation();
            operands = self.push_or_abandon(operands, operand)?;
        }
        Ok(Expr::new(ExprKind::And(operands), self.span_from(start)))
    }

    fn negation(&mut self) -> ParseResult<Expr> {
        let start = self.token().span;
        if self.eat(T::Not).is_none() {
            return self.comparison();
        }
        let operand = Box::new(self.nested(Self::negation)?);
        Ok(Expr::new(
            ExprKind::Unary {
                op: UnaryOp::Not,
                operand,
            },
            self.span_from(start),
        ))
    }

    /// `a < b <= c`: a chain is one node.
    fn comparison(&mut self) -> ParseResult<Expr> {
        let start = self.token().span;
        let left = self.binary(COMPARISON + 1)?;
        let mut rest = Vec::new();
        while let Some(op) = self.comparison_operator() {
            rest.push((op, self.binary(COMPARISON + 1)?));
        }
        if rest.is_empty() {
            return Ok(left);
        }
        Ok(Expr::new(
            ExprKind::Compare {
                left: Box::new(left),
                rest,
            },
            self.span_from(start),
        ))
    }

    fn comparison_operator(&mut self) -> Option<CompareOp> {
        let op = match self.kind() {
            T::EqualEqual => CompareOp::Eq,
            T::NotEqual => CompareOp::Ne,
            T::Less => CompareOp::Lt,
            T::LessEqual => CompareOp::Le,
            T::Greater => CompareOp::Gt,
            T::GreaterEqual => CompareOp::Ge,
            T::In => CompareOp::In,
            T::Not if self.kind_ahead(1) == T::In => {
                self.bump();
                CompareOp::NotIn
            }
            T::Is if self.kind_ahead(1) == T::Not => {
                self.bump();
                CompareOp::IsNot
            }
            T::Is => CompareOp::Is,
            _ => return None,
        };
        self.bump();
        Some(op)
    }

    /// Binary operators that bind at least as tightly as `power`.
    pub(super) fn binary(&mut self, power: u8) -> ParseResult<Expr> {
        let start = self.token().span;
        let mut left = self.unary()?;
        while let Some((op, op_power)) = binary(self.kind()) {
            if op_power < power {
                break;
            }
            self.bump();
            // `**` groups to the right and its right operand may have a sign.
            let right = if op == BinaryOp::Pow {
                self.nested(Self::unary)
            } else {
                self.binary(op_power + 1)
            };
            let (complete, right) = self.keep_or_abandon(left, right)?;
            let kind = ExprKind::Binary {
                op,
                left: Box::new(complete),
                right: Box::new(right),
            };
            left = self.check_depth(Expr::new(kind, self.span_from(start)))?;
        }
        Ok(left)
    }

    /// Refuses an expression whose tree has become too deep.
    pub(super) fn check_depth(&mut self, expr: Expr) -> ParseResult<Expr> {
        if expr.depth > EXPR_DEPTH_MAX {
            let text = text!(
                "this expression is deeper than {EXPR_DEPTH_MAX} levels",
                "这个表达式超过 {EXPR_DEPTH_MAX} 层"
            );
            // Only where it starts: the whole of it may be megabytes.
            let end = expr.span.start;
            let failed = self.fail::<()>(Span { end, ..expr.span }, text);
            return self.keep_or_abandon(expr, failed).map(|(expr, ())| expr);
        }
        Ok(expr)
    }

    fn unary(&mut self) -> ParseResult<Expr> {
        let start = self.token().span;
        let op = match self.kind() {
            T::Minus => UnaryOp::Neg,
            T::Plus => UnaryOp::Pos,
            T::Tilde => UnaryOp::Invert,
            T::Await => return self.not_supported(start, Text::verbatim("'await'")),
            _ => return self.power(),
        };
        self.bump();
        let operand = Box::new(self.nested(Self::unary)?);
        Ok(Expr::new(
            ExprKind::Unary { op, operand },
            self.span_from(start),
        ))
    }

    /// `**` binds tighter than a sign on its left: `-2 ** 2` is -4.
    fn power(&mut self) -> ParseResult<Expr> {
        let start = self.token().span;
        let base = self.postfix()?;
        if self.eat(T::DoubleStar).is_none() {
            return Ok(base);
        }
        let exponent = self.nested(Self::unary)?;
        let kind = ExprKind::Binary {
            op: BinaryOp::Pow,
            left: Box::new(base),
            right: Box::new(exponent),
        };
        Ok(Expr::new(kind, self.span_from(start)))
    }
}
