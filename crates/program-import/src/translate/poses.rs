//! Poses with numbers in them: rotation vectors become roll, pitch and yaw while the text is translated.

use kinematics::rotation::{rotation_from_rotvec, rpy_from_rotation};

use crate::urscript::ast::{BinaryOperator, Expr, ExprKind, UnaryOperator};

/// Below this an angle is what rounding left, rad.
const ANGLE_ROUNDING_RAD: f64 = 1e-12;

/// The number that an expression of numbers stands for.
pub fn constant(expr: &Expr) -> Option<f64> {
    let value = match &expr.kind {
        ExprKind::Number(text) => match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"))
        {
            Some(digits) => i64::from_str_radix(digits, 16).ok()? as f64,
            None => text.parse().ok()?,
        },
        ExprKind::Paren(inner) | ExprKind::Unary(UnaryOperator::Plus, inner) => constant(inner)?,
        ExprKind::Unary(UnaryOperator::Minus, inner) => -constant(inner)?,
        ExprKind::Binary(operator, left, right) => {
            let (left, right) = (constant(left)?, constant(right)?);
            match operator {
                BinaryOperator::Add => left + right,
                BinaryOperator::Subtract => left - right,
                BinaryOperator::Multiply => left * right,
                BinaryOperator::Divide => left / right,
                _ => return None,
            }
        }
        ExprKind::Call { callee, args } => match (&callee.kind, &args[..]) {
            (ExprKind::Name(name), [arg]) if name == "d2r" && arg.name.is_none() => {
                constant(&arg.value)?.to_radians()
            }
            _ => return None,
        },
        _ => return None,
    };
    value.is_finite().then_some(value)
}

/// Roll, pitch and yaw of a rotation vector.
pub fn rpy(rotation_vector: [f64; 3]) -> [f64; 3] {
    rpy_from_rotation(&rotation_from_rotvec(rotation_vector.into())).map(|angle| {
        if angle.abs() < ANGLE_ROUNDING_RAD {
            0.0
        } else {
            angle
        }
    })
}

/// Whether the three numbers mean the same rotation either way.
pub fn is_rpy_as_well(rotation_vector: [f64; 3]) -> bool {
    use core::f64::consts::{FRAC_PI_2, PI};
    match rotation_vector.map(|x| x == 0.0) {
        [true, true, true] => true,
        [false, true, true] => rotation_vector[0].abs() <= PI,
        [true, false, true] => rotation_vector[1].abs() <= FRAC_PI_2,
        [true, true, false] => rotation_vector[2].abs() <= PI,
        _ => false,
    }
}

/// A number as it is written in programs.
pub fn number(value: f64) -> String {
    match value == 0.0 {
        true => "0".to_owned(),
        false => format!("{value:?}"),
    }
}
