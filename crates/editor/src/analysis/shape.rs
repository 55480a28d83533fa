//! What an expression says about its value, noted while the tree is walked.

use elite_lang::syntax::{
    BinaryOp, ComprehensionKind, Constant, Expr, ExprKind, Stmt, StmtKind, UnaryOp,
};

use super::scopes::ScopeId;
use super::types::{SHAPE_DEPTH_MAX, Shape};

/// The shape of an expression that stands in `scope`.
pub(super) fn shape_of(expr: &Expr, scope: ScopeId) -> Shape {
    within(expr, scope, SHAPE_DEPTH_MAX)
}

/// The text at the beginning of a body that says what it is for.
pub(super) fn docstring(body: &[Stmt]) -> Option<Box<str>> {
    match &body.first()?.kind {
        StmtKind::Expr(Expr {
            kind: ExprKind::Constant(Constant::Str(text)),
            ..
        }) => Some(text.clone()),
        _ => None,
    }
}

fn within(expr: &Expr, scope: ScopeId, depth: u32) -> Shape {
    let Some(depth) = depth.checked_sub(1) else {
        return Shape::Unknown;
    };
    let part = |expr: &Expr| within(expr, scope, depth);
    let of = |name, items: &[Expr]| match items.first() {
        Some(first) => Shape::Of(name, Box::new(part(first))),
        None => Shape::Value(name),
    };
    match &expr.kind {
        ExprKind::Constant(constant) => match constant {
            // What is not there does not tell what else there may be.
            Constant::None | Constant::Ellipsis => Shape::Unknown,
            Constant::Bool(_) => Shape::Value("bool"),
            Constant::Int(_) | Constant::BigInt(_) => Shape::Value("int"),
            Constant::Float(_) => Shape::Value("float"),
            Constant::Imaginary(_) => Shape::Value("complex"),
            Constant::Str(_) => Shape::Value("str"),
            Constant::Bytes(_) => Shape::Value("bytes"),
        },
        ExprKind::FString(_) => Shape::Value("str"),
        ExprKind::Name(name) => Shape::Name(scope, name.clone()),
        ExprKind::Call { function, .. } => Shape::Call(Box::new(part(function))),
        ExprKind::Attribute { value, name } => {
            Shape::Attribute(Box::new(part(value)), name.name.clone())
        }
        ExprKind::Subscript { value, index } => match &index.kind {
            ExprKind::Slice { .. } => part(value),
            _ => Shape::Item(Box::new(part(value))),
        },
        ExprKind::List(items) => of("list", items),
        ExprKind::Tuple(items) => of("tuple", items),
        ExprKind::Set(items) => of("set", items),
        ExprKind::Dict(_) => Shape::Value("dict"),
        ExprKind::Comprehension(comprehension) => match &comprehension.kind {
            ComprehensionKind::List(_) => Shape::Value("list"),
            ComprehensionKind::Set(_) => Shape::Value("set"),
            ComprehensionKind::Dict(..) => Shape::Value("dict"),
            ComprehensionKind::Generator(_) => Shape::Unknown,
        },
        ExprKind::Compare { .. }
        | ExprKind::Unary {
            op: UnaryOp::Not, ..
        } => Shape::Value("bool"),
        ExprKind::Unary { operand, .. } => part(operand),
        ExprKind::Binary { op, left, right } => binary(*op, part(left), part(right)),
        ExprKind::IfElse { body, orelse, .. } => match part(body) {
            Shape::Unknown => part(orelse),
            known => known,
        },
        ExprKind::And(items) | ExprKind::Or(items) => items.last().map_or(Shape::Unknown, part),
        ExprKind::Named { value, .. } => part(value),
        _ => Shape::Unknown,
    }
}

fn binary(op: BinaryOp, left: Shape, right: Shape) -> Shape {
    match (op, &left, &right) {
        (BinaryOp::Mod, Shape::Value("str"), _) => left,
        (BinaryOp::Div, Shape::Value("int"), Shape::Value("int")) => Shape::Value("float"),
        (_, Shape::Value("int"), Shape::Value("float")) => right,
        (_, Shape::Value(_) | Shape::Of(..), _) => left,
        (BinaryOp::Mul, _, Shape::Of(..) | Shape::Value("str")) => right,
        (_, _, Shape::Value("float")) => right,
        _ => Shape::Unknown,
    }
}
