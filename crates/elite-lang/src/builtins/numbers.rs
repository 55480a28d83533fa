//! Builtin functions on numbers and characters.

use std::rc::Rc;

use elite_syntax::ast::BinaryOp;
use elite_syntax::surrogate::{char_of, code_of};

use super::Builtin;
use crate::errors::ExceptionKind;
use crate::eval::{Evaluator, InterpreterState};
use crate::format::{float, prefixed};
use crate::value::int::Int;
use crate::value::symbol::known;
use crate::value::{R, Value};

/// Puts them in place.
pub fn install(core: &Rc<InterpreterState>) {
    let bound: &[(&'static str, &str, super::BoundFn)] = &[
        ("abs", "x /", abs),
        ("bin", "number /", |ev, args| {
            ev.new_str(prefixed(&ev.to_int(&args[0])?, 'b', "0b", ev)?)
        }),
        ("chr", "i /", chr),
        ("divmod", "x y /", divmod),
        ("hex", "number /", |ev, args| {
            ev.new_str(prefixed(&ev.to_int(&args[0])?, 'x', "0x", ev)?)
        }),
        ("oct", "number /", |ev, args| {
            ev.new_str(prefixed(&ev.to_int(&args[0])?, 'o', "0o", ev)?)
        }),
        ("ord", "c /", ord),
        ("pow", "base exp mod?", pow),
        ("round", "number ndigits?", round),
    ];
    for (name, signature, body) in bound {
        core.builtins.set(
            core.symbols.intern(name),
            Builtin::bound(core, name, signature, *body),
        );
    }
}

fn abs(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let value = &args[0];
    Ok(match value {
        Value::Float(float) => Value::Float(float.abs()),
        Value::Complex(complex) => Value::Float(complex.0.hypot(complex.1)),
        Value::Bool(flag) => Value::Int(i64::from(*flag)),
        Value::Int(int) if *int >= 0 => value.clone(),
        Value::BigInt(big) if big.sign() == num_bigint::Sign::Plus => value.clone(),
        Value::Int(_) | Value::BigInt(_) => ev.number_negate(value).unwrap_or_default(),
        _ => match ev.special(value, known::ABS, &mut [])? {
            Some(result) => result,
            None => {
                let name = ev.core.types.name_of(value);
                return Err(ev.type_error(format!("bad operand type for abs(): '{name}'")));
            }
        },
    })
}

fn chr(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let code = ev.c_int(&args[0])?;
    let c = u32::try_from(code).ok().filter(|code| *code < 0x11_0000);
    let Some(code) = c else {
        return Err(ev.value_error("chr() arg not in range(0x110000)"));
    };
    match char_of(code) {
        Some(c) => Ok(ev.core.char_value(c)),
        None => Err(ev.value_error(format!(
            "chr({code:#x}): the private characters U+10E000 to U+10E7FF are used for surrogates here"
        ))),
    }
}

fn ord(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let length = match ev.unwrap_builtin(&args[0]) {
        Value::Str(text) if text.len() == 1 => {
            let c = text.as_str().chars().next().unwrap_or('\0');
            return Ok(Value::Int(i64::from(code_of(c))));
        }
        Value::Str(text) => text.len(),
        other => match ev.bytes_like(&other) {
            Some(data) if data.len() == 1 => return Ok(Value::Int(i64::from(data[0]))),
            Some(data) => data.len(),
            None => {
                let name = ev.core.types.name_of(&args[0]);
                return Err(ev.type_error(format!(
                    "ord() expected string of length 1, but {name} found"
                )));
            }
        },
    };
    Err(ev.type_error(format!(
        "ord() expected a character, but string of length {length} found"
    )))
}

fn divmod(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let (a, b) = (&args[0], &args[1]);
    if let Some((quotient, remainder)) = ev.number_divmod(a, b)? {
        return Ok(Value::pair(quotient, remainder));
    }
    if let Some(result) = ev.binary_by_methods(known::DIVMOD, known::RDIVMOD, a, b)? {
        return Ok(result);
    }
    let (a, b) = (ev.core.types.name_of(a), ev.core.types.name_of(b));
    Err(ev.type_error(format!(
        "unsupported operand type(s) for divmod(): '{a}' and '{b}'"
    )))
}

pub fn pow(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let modulus = match args[2].if_given() {
        None | Some(Value::None) => return ev.binary(BinaryOp::Pow, &args[0], &args[1]),
        Some(modulus) => modulus,
    };
    let kinds = [&args[0], &args[1], modulus].map(|arg| PowerKind::of(ev, arg));
    let [first, second, third] = kinds;
    // Each kind that is among the arguments is asked once, in their order.
    let asked = [
        Some(first),
        Some(second).filter(|kind| *kind != first),
        Some(third).filter(|kind| *kind != first && *kind != second),
    ];
    for kind in asked.into_iter().flatten() {
        match kind {
            PowerKind::Int => {
                let ints =
                    [&args[0], &args[1], modulus].map(|arg| Int::of(&ev.unwrap_builtin(arg)));
                if let [Some(base), Some(exponent), Some(modulus)] = ints {
                    return power_modulo(ev, &base, &exponent, &modulus);
                }
            }
            PowerKind::Float => {
                let text = "pow() 3rd argument not allowed unless all arguments are integers";
                return Err(ev.type_error(text));
            }
            PowerKind::Complex
                if args[..2]
                    .iter()
                    .all(|arg| is_number(&ev.unwrap_builtin(arg))) =>
            {
                return Err(ev.value_error("complex modulo"));
            }
            PowerKind::Own if first == PowerKind::Own => {
                let class = ev.core.types.of(&args[0]).clone();
                if let Some(method) = class.lookup(known::POW) {
                    let (base, mut rest) = (args[0].clone(), args[1..].to_vec());
                    let result = ev.call_method_value(&method, &base, &mut rest)?;
                    if !matches!(result, Value::NotImplemented) {
                        return Ok(result);
                    }
                }
            }
            PowerKind::Complex | PowerKind::Own | PowerKind::None => {}
        }
    }
    let names: Vec<String> = args
        .iter()
        .map(|arg| format!("'{}'", ev.core.types.name_of(arg)))
        .collect();
    Err(ev.type_error(format!(
        "unsupported operand type(s) for ** or pow(): {}",
        names.join(", ")
    )))
}

/// Who says how an object is raised to a power: the builtin type that its class has this from, or a script.
#[derive(Clone, Copy, PartialEq, Eq)]
enum PowerKind {
    Int,
    Float,
    Complex,
    Own,
    None,
}

impl PowerKind {
    fn of(ev: &Evaluator<'_>, arg: &Value) -> Self {
        if let Value::Instance(instance) = arg {
            let is_own = |name| {
                let method = instance.class.lookup(name);
                method.is_some_and(|method| !matches!(method, Value::Builtin(_)))
            };
            if is_own(known::POW) || is_own(known::RPOW) {
                return PowerKind::Own;
            }
        }
        match ev.unwrap_builtin(arg) {
            Value::Float(_) => PowerKind::Float,
            Value::Complex(_) => PowerKind::Complex,
            plain if Int::of(&plain).is_some() => PowerKind::Int,
            _ => PowerKind::None,
        }
    }
}

fn is_number(plain: &Value) -> bool {
    matches!(plain, Value::Float(_) | Value::Complex(_)) || Int::of(plain).is_some()
}

fn power_modulo(ev: &Evaluator<'_>, base: &Int, exponent: &Int, modulus: &Int) -> R {
    if modulus.is_zero() {
        return Err(ev.value_error("pow() 3rd argument cannot be 0"));
    }
    let (mut base, mut exponent, modulus) = (base.to_big(), exponent.to_big(), modulus.to_big());
    if exponent.sign() == num_bigint::Sign::Minus {
        base = ev
            .big_inverse(&base, &modulus)?
            .ok_or_else(|| ev.value_error("base is not invertible for the given modulus"))?;
        exponent = -exponent;
    }
    Ok(Value::bigint(
        ev.big_power_modulo(&base, &exponent, &modulus)?,
    ))
}

fn round(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let digits = args[1].if_given().filter(|digits| !digits.is_none());
    match (&args[0], digits) {
        (Value::Float(float), None) => {
            if float.is_nan() {
                return Err(ev.value_error("cannot convert float NaN to integer"));
            }
            if float.is_infinite() {
                return Err(ev.raise(
                    ExceptionKind::OverflowError,
                    "cannot convert float infinity to integer",
                ));
            }
            Ok(crate::value::int::from_f64(float.round_ties_even()))
        }
        (Value::Float(float), Some(digits)) => {
            let rounded = float::round(*float, ev.clamped_index(digits)?);
            if rounded.is_infinite() && float.is_finite() {
                let text = "rounded value too large to represent";
                return Err(ev.raise(ExceptionKind::OverflowError, text));
            }
            Ok(Value::Float(rounded))
        }
        (value @ (Value::Int(_) | Value::BigInt(_) | Value::Bool(_)), digits) => {
            let int = Int::of(value).unwrap_or(Int::Small(0));
            match digits {
                None => Ok(int.into_value()),
                Some(digits) => round_int(ev, int, ev.clamped_index(digits)?),
            }
        }
        (value, digits) => {
            let mut given: Vec<Value> = digits.cloned().into_iter().collect();
            match ev.special(value, known::ROUND, &mut given)? {
                Some(result) => Ok(result),
                None => {
                    let name = ev.core.types.name_of(value);
                    Err(ev.type_error(format!("type {name} doesn't define __round__ method")))
                }
            }
        }
    }
}

/// Rounds an integer to tens, hundreds, …; halves go to even.
fn round_int(ev: &Evaluator<'_>, int: Int, digits: i64) -> R {
    if digits >= 0 {
        return Ok(int.into_value());
    }
    // An integer has fewer decimal digits than bits.
    if digits.unsigned_abs() > int.bits() {
        return Ok(Value::Int(0));
    }
    // A power of ten with one digit more than the integer is more than twice as big (0.302 > log10 2).
    if digits.unsigned_abs() > int.bits() * 302 / 1000 + 2 {
        return Ok(Value::Int(0));
    }
    let unit = ev.big_power(&num_bigint::BigInt::from(10), digits.unsigned_abs())?;
    let (quotient, remainder) = ev.big_divmod(&int.to_big(), &unit)?;
    let twice: num_bigint::BigInt = remainder * 2;
    let up = twice > unit || (twice == unit && quotient.bit(0));
    ev.check_bits(int.bits() + 4)?;
    Ok(Value::bigint(
        ev.big_product(&(quotient + u8::from(up)), &unit)?,
    ))
}
