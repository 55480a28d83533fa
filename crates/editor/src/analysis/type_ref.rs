//! What an expression says about its value, noted while the tree is walked.

use elite_syntax::ast::{
    BinaryOp, ComprehensionKind, Constant, Expr, ExprKind, Stmt, StmtKind, UnaryOp,
};

use super::scopes::ScopeId;
use super::types::{SHAPE_DEPTH_MAX, TypeRef};

/// The shape of an expression that stands in `scope`.
pub(super) fn type_ref_of(expr: &Expr, scope: ScopeId) -> TypeRef {
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

fn within(expr: &Expr, scope: ScopeId, depth: u32) -> TypeRef {
    let Some(depth) = depth.checked_sub(1) else {
        return TypeRef::Unknown;
    };
    let part = |expr: &Expr| within(expr, scope, depth);
    let of = |name, items: &[Expr]| match items.first() {
        Some(first) => TypeRef::Container(name, Box::new(part(first))),
        None => TypeRef::Value(name),
    };
    match &expr.kind {
        ExprKind::Constant(constant) => match constant {
            // What is not there does not tell what else there may be.
            Constant::None | Constant::Ellipsis => TypeRef::Unknown,
            Constant::Bool(_) => TypeRef::Value("bool"),
            Constant::Int(_) | Constant::BigInt(_) => TypeRef::Value("int"),
            Constant::Float(_) => TypeRef::Value("float"),
            Constant::Imaginary(_) => TypeRef::Value("complex"),
            Constant::Str(_) => TypeRef::Value("str"),
            Constant::Bytes(_) => TypeRef::Value("bytes"),
        },
        ExprKind::FString(_) => TypeRef::Value("str"),
        ExprKind::Name(name) => TypeRef::Name(scope, name.clone()),
        ExprKind::Call { function, .. } => TypeRef::Call(Box::new(part(function))),
        ExprKind::Attribute { value, name } => {
            TypeRef::Attribute(Box::new(part(value)), name.name.clone())
        }
        ExprKind::Subscript { value, index } => match &index.kind {
            ExprKind::Slice { .. } => part(value),
            _ => TypeRef::Item(Box::new(part(value))),
        },
        ExprKind::List(items) => of("list", items),
        ExprKind::Tuple(items) => of("tuple", items),
        ExprKind::Set(items) => of("set", items),
        ExprKind::Dict(_) => TypeRef::Value("dict"),
        ExprKind::Comprehension(comprehension) => match &comprehension.kind {
            ComprehensionKind::List(_) => TypeRef::Value("list"),
            ComprehensionKind::Set(_) => TypeRef::Value("set"),
            ComprehensionKind::Dict(..) => TypeRef::Value("dict"),
            ComprehensionKind::Generator(_) => TypeRef::Unknown,
        },
        ExprKind::Compare { .. }
        | ExprKind::Unary {
            op: UnaryOp::Not, ..
        } => TypeRef::Value("bool"),
        ExprKind::Unary { operand, .. } => part(operand),
        ExprKind::Binary { op, left, right } => binary(*op, part(left), part(right)),
        ExprKind::IfElse { body, orelse, .. } => match part(body) {
            TypeRef::Unknown => part(orelse),
            known => known,
        },
        ExprKind::And(items) | ExprKind::Or(items) => items.last().map_or(TypeRef::Unknown, part),
        ExprKind::Named { value, .. } => part(value),
        _ => TypeRef::Unknown,
    }
}

fn binary(op: BinaryOp, left: TypeRef, right: TypeRef) -> TypeRef {
    match (op, &left, &right) {
        (BinaryOp::Mod, TypeRef::Value("str"), _) => left,
        (BinaryOp::Div, TypeRef::Value("int"), TypeRef::Value("int")) => TypeRef::Value("float"),
        (_, TypeRef::Value("int"), TypeRef::Value("float")) => right,
        (_, TypeRef::Value(_) | TypeRef::Container(..), _) => left,
        (BinaryOp::Mul, _, TypeRef::Container(..) | TypeRef::Value("str")) => right,
        (_, _, TypeRef::Value("float")) => right,
        _ => TypeRef::Unknown,
    }
}
