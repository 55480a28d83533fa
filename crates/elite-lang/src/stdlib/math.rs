//! `math`: the functions of C's mathematics library with Python's errors, and those on integers.

use num_bigint::BigInt;

use super::define::{MethodDef, ModuleBuilder};
use crate::builtins::Args;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::limits::yielding::WORK_PER_VALUE;
use crate::value::int::{Int, from_f64};
use crate::value::symbol::known;
use crate::value::{R, Unwind, Value};

/// A function of one float. What is not finite for a finite argument is an error: a range error if the function grows
/// beyond all floats, otherwise a domain error.
macro_rules! unary {
    ($name:literal, $function:expr) => {
        unary!($name, $function, domain)
    };
    ($name:literal, $function:expr, $error:ident) => {
        ($name, "x /", |ev, args| {
            let x = ev.to_f64(&args[0])?;
            let function: fn(f64) -> f64 = $function;
            let result = function(x);
            if result.is_nan() && !x.is_nan() {
                return Err(domain(ev));
            }
            if result.is_infinite() && x.is_finite() {
                return Err($error(ev));
            }
            Ok(Value::Float(result))
        })
    };
}

/// A question about one float.
macro_rules! question {
    ($name:literal, $method:ident) => {
        ($name, "x /", |ev, args| {
            Ok(Value::Bool(ev.to_f64(&args[0])?.$method()))
        })
    };
}

pub(super) fn fill(module: &ModuleBuilder<'_, '_>) -> R<()> {
    let constants = [
        ("pi", std::f64::consts::PI),
        ("e", std::f64::consts::E),
        ("tau", std::f64::consts::TAU),
        ("inf", f64::INFINITY),
        ("nan", f64::NAN),
    ];
    for (name, value) in constants {
        module.value(name, Value::Float(value));
    }
    module.functions(FLOATS);
    module.functions(INTEGERS);
    module.raw("hypot", |ev, args| {
        refuse_names(ev, "hypot", args)?;
        let sides: Vec<f64> = args
            .positional
            .iter()
            .map(|side| ev.to_f64(side))
            .collect::<R<_>>()?;
        Ok(Value::Float(norm(ev, &sides)?))
    });
    module.raw("gcd", |ev, args| {
        refuse_names(ev, "gcd", args)?;
        let mut result = BigInt::ZERO;
        for arg in args.positional.iter() {
            result = ev.big_gcd(&result, &ev.to_int(arg)?.to_big())?;
        }
        Ok(Value::bigint(result))
    });
    module.raw("lcm", |ev, args| {
        refuse_names(ev, "lcm", args)?;
        let mut result = BigInt::from(1);
        for arg in args.positional.iter() {
            let other = ev.to_int(arg)?.to_big();
            let divisor = ev.big_gcd(&result, &other)?;
            if divisor == BigInt::ZERO {
                return Ok(Value::Int(0));
            }
            ev.check_bits(result.bits() + other.bits())?;
            let (quotient, _) = ev.big_divmod(&result, &divisor)?;
            result = ev.big_product(&quotient, &other)?;
        }
        Ok(Value::bigint(BigInt::from(result.magnitude().clone())))
    });
    Ok(())
}

/// Functions of any number of arguments take none by name.
fn refuse_names(ev: &Evaluator<'_>, name: &str, args: &Args<'_>) -> R<()> {
    match args.keywords.is_empty() {
        true => Ok(()),
        false => Err(ev.type_error(format!("math.{name}() takes no keyword arguments"))),
    }
}

fn domain(ev: &Evaluator<'_>) -> Unwind {
    ev.value_error("math domain error")
}

fn range(ev: &Evaluator<'_>) -> Unwind {
    ev.raise(ExceptionKind::OverflowError, "math range error")
}

const FLOATS: &[MethodDef] = &[
    unary!("acos", f64::acos),
    unary!("acosh", libm::acosh),
    unary!("asin", f64::asin),
    unary!("asinh", libm::asinh),
    unary!("atan", f64::atan),
    unary!("atanh", libm::atanh),
    unary!("cbrt", f64::cbrt),
    unary!("cos", f64::cos),
    unary!("cosh", f64::cosh, range),
    unary!("degrees", |x| x * (180.0 / std::f64::consts::PI), range),
    unary!("erf", libm::erf),
    unary!("erfc", libm::erfc),
    unary!("exp", f64::exp, range),
    unary!("exp2", f64::exp2, range),
    unary!("expm1", f64::exp_m1, range),
    unary!("fabs", f64::abs),
    unary!("log1p", f64::ln_1p),
    unary!("radians", |x| x * (std::f64::consts::PI / 180.0)),
    unary!("sin", f64::sin),
    unary!("sinh", f64::sinh, range),
    unary!("sqrt", f64::sqrt),
    unary!("tan", f64::tan),
    unary!("tanh", f64::tanh),
    question!("isfinite", is_finite),
    question!("isinf", is_infinite),
    question!("isnan", is_nan),
    ("gamma", "x /", |ev, args| {
        let x = ev.to_f64(&args[0])?;
        if x == f64::NEG_INFINITY || (x <= 0.0 && x.fract() == 0.0) {
            return Err(domain(ev));
        }
        let whole = x.fract() == 0.0 && (1.0..=23.0).contains(&x);
        // Factorials up to 22 are floats exactly.
        let result = if whole {
            (1..x as u64).map(|n| n as f64).product()
        } else {
            libm::tgamma(x)
        };
        if result.is_infinite() && x.is_finite() {
            Err(range(ev))
        } else {
            Ok(Value::Float(result))
        }
    }),
    ("lgamma", "x /", |ev, args| {
        let x = ev.to_f64(&args[0])?;
        if x.is_finite() && x <= 0.0 && x.fract() == 0.0 {
            return Err(domain(ev));
        }
        let result = if x.is_infinite() {
            f64::INFINITY
        } else {
            libm::lgamma(x)
        };
        if result.is_infinite() && x.is_finite() {
            Err(range(ev))
        } else {
            Ok(Value::Float(result))
        }
    }),
    ("atan2", "y x /", |ev, args| binary(ev, args, f64::atan2)),
    ("copysign", "x y /", |ev, args| {
        binary(ev, args, f64::copysign)
    }),
    ("nextafter", "x y /", |ev, args| {
        binary(ev, args, next_after)
    }),
    ("ulp", "x /", |ev, args| {
        let x = ev.to_f64(&args[0])?.abs();
        let ulp = if x.is_nan() || x.is_infinite() {
            x
        } else if x == f64::MAX {
            x - x.next_down()
        } else {
            x.next_up() - x
        };
        Ok(Value::Float(ulp))
    }),
    ("fmod", "x y /", |ev, args| {
        let (x, y) = (ev.to_f64(&args[0])?, ev.to_f64(&args[1])?);
        if y.is_infinite() && x.is_finite() {
            return Ok(Value::Float(x));
        }
        let result = x % y;
        if result.is_nan() && !x.is_nan() && !y.is_nan() {
            Err(domain(ev))
        } else {
            Ok(Value::Float(result))
        }
    }),
    ("remainder", "x y /", |ev, args| {
        let (x, y) = (ev.to_f64(&args[0])?, ev.to_f64(&args[1])?);
        if (x.is_infinite() && !y.is_nan()) || (y == 0.0 && !x.is_nan()) {
            return Err(domain(ev));
        }
        Ok(Value::Float(libm::remainder(x, y)))
    }),
    ("pow", "x y /", |ev, args| {
        let (x, y) = (ev.to_f64(&args[0])?, ev.to_f64(&args[1])?);
        let result = x.powf(y);
        if x.is_finite() && y.is_finite() {
            if result.is_nan() || (result.is_infinite() && x == 0.0) {
                return Err(domain(ev));
            }
            if result.is_infinite() {
                return Err(range(ev));
            }
        }
        Ok(Value::Float(result))
    }),
    ("log", "x base? /", |ev, args| {
        let x = log(ev, &args[0], f64::ln, std::f64::consts::LN_2)?;
        let Some(base) = args[1].if_given() else {
            return Ok(Value::Float(x));
        };
        let base = log(ev, base, f64::ln, std::f64::consts::LN_2)?;
        if base == 0.0 {
            return Err(ev.raise(ExceptionKind::ZeroDivisionError, "float division by zero"));
        }
        Ok(Value::Float(x / base))
    }),
    ("log2", "x /", |ev, args| {
        log(ev, &args[0], f64::log2, 1.0).map(Value::Float)
    }),
    ("log10", "x /", |ev, args| {
        log(ev, &args[0], f64::log10, std::f64::consts::LOG10_2).map(Value::Float)
    }),
    ("modf", "x /", |ev, args| {
        let x = ev.to_f64(&args[0])?;
        let fraction = if x.is_infinite() {
            0.0f64.copysign(x)
        } else {
            x.fract().copysign(x)
        };
        Ok(Value::tuple(vec![
            Value::Float(fraction),
            Value::Float(x.trunc()),
        ]))
    }),
    ("frexp", "x /", |ev, args| {
        let (mantissa, exponent) = libm::frexp(ev.to_f64(&args[0])?);
        Ok(Value::tuple(vec![
            Value::Float(mantissa),
            Value::Int(i64::from(exponent)),
        ]))
    }),
    ("ldexp", "x i /", |ev, args| {
        let x = ev.to_f64(&args[0])?;
        if !matches!(
            ev.unwrap_builtin(&args[1]),
            Value::Int(_) | Value::Bool(_) | Value::BigInt(_)
        ) {
            return Err(ev.type_error("Expected an int as second argument to ldexp."));
        }
        let exponent = ev.clamped_index(&args[1])?.clamp(-100_000, 100_000);
        let result = libm::ldexp(x, exponent as i32);
        if result.is_infinite() && x.is_finite() {
            Err(range(ev))
        } else {
            Ok(Value::Float(result))
        }
    }),
    ("fsum", "seq /", |ev, args| {
        exact_sum(ev, &ev.drain(&ev.iter(&args[0])?)?)
    }),
    ("dist", "p q /", |ev, args| {
        let (p, q) = (ev.collect(&args[0])?, ev.collect(&args[1])?);
        if p.len() != q.len() {
            return Err(ev.value_error("both points must have the same number of dimensions"));
        }
        let differences = p.iter().zip(&q).map(|(p, q)| {
            ev.charge(WORK_PER_VALUE)?;
            Ok(ev.to_f64(p)? - ev.to_f64(q)?)
        });
        Ok(Value::Float(norm(
            ev,
            &differences.collect::<R<Vec<f64>>>()?,
        )?))
    }),
    ("isclose", "a b * rel_tol? abs_tol?", |ev, args| {
        let (a, b) = (ev.to_f64(&args[0])?, ev.to_f64(&args[1])?);
        let relative = args[2]
            .if_given()
            .map_or(Ok(1e-9), |value| ev.to_f64(value))?;
        let absolute = args[3]
            .if_given()
            .map_or(Ok(0.0), |value| ev.to_f64(value))?;
        if relative < 0.0 || absolute < 0.0 {
            return Err(ev.value_error("tolerances must be non-negative"));
        }
        if a == b {
            return Ok(Value::Bool(true));
        }
        if a.is_infinite() || b.is_infinite() {
            return Ok(Value::Bool(false));
        }
        let difference = (b - a).abs();
        let close = difference <= (relative * b).abs() || difference <= (relative * a).abs();
        Ok(Value::Bool(close || difference <= absolute))
    }),
    ("floor", "x /", |ev, args| {
        rounded(ev, &args[0], "__floor__", f64::floor)
    }),
    ("ceil", "x /", |ev, args| {
        rounded(ev, &args[0], "__ceil__", f64::ceil)
    }),
    ("trunc", "x /", |ev, args| match &args[0] {
        Value::Float(_) => rounded(ev, &args[0], "__trunc__", f64::trunc),
        value => match (Int::of(value), ev.special(value, known::TRUNC, &mut [])?) {
            (Some(int), _) => Ok(int.into_value()),
            (None, Some(result)) => Ok(result),
            (None, None) => {
                let name = ev.core.types.name_of(value);
                Err(ev.type_error(format!("type {name} doesn't define __trunc__ method")))
            }
        },
    }),
];

fn binary(ev: &Evaluator<'_>, args: &[Value], function: fn(f64, f64) -> f64) -> R {
    Ok(Value::Float(function(
        ev.to_f64(&args[0])?,
        ev.to_f64(&args[1])?,
    )))
}

fn next_after(x: f64, y: f64) -> f64 {
    if x.is_nan() || y.is_nan() {
        f64::NAN
    } else if x == y {
        y
    } else if y > x {
        x.next_up()
    } else {
        x.next_down()
    }
}

/// A logarithm of any positive number; `of_two` is that of 2, for integers beyond the floats.
fn log(ev: &Evaluator<'_>, value: &Value, function: fn(f64) -> f64, of_two: f64) -> R<f64> {
    if let Value::BigInt(big) = value {
        if Int::Big(big.clone()).is_negative() {
            return Err(domain(ev));
        }
        // Like CPython: an integer that fits a float is taken at once, of others the mantissa in [0.5, 1) and the
        // exponent apart.
        let whole = Int::Big(big.clone()).to_f64();
        if whole.is_finite() {
            return Ok(function(whole));
        }
        let bits = big.bits();
        let top: BigInt = &**big >> bits.saturating_sub(1000);
        let mantissa = libm::ldexp(Int::Big(top.into()).to_f64(), -1000);
        return Ok(function(mantissa) + bits as f64 * of_two);
    }
    let x = ev.to_f64(value)?;
    if x <= 0.0 {
        return Err(domain(ev));
    }
    Ok(function(x))
}

fn rounded(ev: &Evaluator<'_>, value: &Value, method: &str, function: fn(f64) -> f64) -> R {
    if let Some(int) = Int::of(value) {
        return Ok(int.into_value());
    }
    if let Value::Instance(_) = value
        && let Some(result) = ev.special(value, ev.core.symbols.intern(method), &mut [])?
    {
        return Ok(result);
    }
    let x = ev.to_f64(value)?;
    if x.is_nan() {
        return Err(ev.value_error("cannot convert float NaN to integer"));
    }
    if x.is_infinite() {
        let text = "cannot convert float infinity to integer";
        return Err(ev.raise(ExceptionKind::OverflowError, text));
    }
    Ok(from_f64(function(x)))
}

/// The length of a vector, without overflow in between.
fn norm(ev: &Evaluator<'_>, sides: &[f64]) -> R<f64> {
    if sides.iter().any(|side| side.is_infinite()) {
        return Ok(f64::INFINITY);
    }
    let largest = sides
        .iter()
        .fold(0.0f64, |largest, side| largest.max(side.abs()));
    if sides.iter().any(|side| side.is_nan()) {
        return Ok(f64::NAN);
    }
    if largest == 0.0 {
        return Ok(0.0);
    }
    // Scaling by a power of two is exact; the squares are summed without rounding errors.
    let (_, exponent) = libm::frexp(largest);
    let mut partials = Vec::new();
    for side in sides {
        ev.charge(2 * WORK_PER_VALUE)?;
        let scaled = libm::ldexp(*side, -exponent);
        let square = scaled * scaled;
        add_exactly(&mut partials, square);
        add_exactly(&mut partials, rest_of_square(scaled, square));
    }
    let root = partials.iter().rev().sum::<f64>().sqrt();
    // What is left of the sum says how far the root is from its own: one step of Newton's.
    let square = root * root;
    add_exactly(&mut partials, -square);
    add_exactly(&mut partials, -rest_of_square(root, square));
    let rest = partials.iter().rev().sum::<f64>();
    Ok(libm::ldexp(root + rest / (2.0 * root), exponent))
}

/// What rounding has taken from the square of `x`, which is neither huge nor tiny (Dekker, "A floating-point technique
/// for extending the available precision", 1971).
fn rest_of_square(x: f64, square: f64) -> f64 {
    let spread = 134_217_729.0 * x;
    let high = spread - (spread - x);
    let low = x - high;
    ((high * high - square) + 2.0 * high * low) + low * low
}

/// Adds `x` to a sum kept as non-overlapping parts (Shewchuk, "Adaptive Precision Floating-Point Arithmetic", 1997).
fn add_exactly(partials: &mut Vec<f64>, x: f64) {
    let mut x = x;
    let mut kept = 0;
    for i in 0..partials.len() {
        let mut y = partials[i];
        if x.abs() < y.abs() {
            std::mem::swap(&mut x, &mut y);
        }
        let high = x + y;
        let low = y - (high - x);
        if low != 0.0 {
            partials[kept] = low;
            kept += 1;
        }
        x = high;
    }
    partials.truncate(kept);
    partials.push(x);
}

fn exact_sum(ev: &Evaluator<'_>, items: &[Value]) -> R {
    let mut partials: Vec<f64> = Vec::new();
    let (mut special, mut infinities) = (0.0, 0.0);
    for item in items {
        ev.charge(2 * WORK_PER_VALUE)?;
        let x = ev.to_f64(item)?;
        if !x.is_finite() {
            special += x;
            if x.is_infinite() {
                infinities += x;
            }
            continue;
        }
        add_exactly(&mut partials, x);
        if partials.last().is_some_and(|last| !last.is_finite()) {
            let text = "intermediate overflow in fsum";
            return Err(ev.raise(ExceptionKind::OverflowError, text));
        }
    }
    if special != 0.0 || special.is_nan() {
        if infinities.is_nan() {
            return Err(ev.value_error("-inf + inf in fsum"));
        }
        return Ok(Value::Float(special));
    }
    // From the largest part down; what is cut off decides ties.
    let mut parts = partials.iter().rev().copied();
    let Some(mut sum) = parts.next() else {
        return Ok(Value::Float(0.0));
    };
    let mut low = 0.0;
    for part in parts.by_ref() {
        let high = sum + part;
        low = part - (high - sum);
        sum = high;
        if low != 0.0 {
            break;
        }
    }
    if let Some(next) = parts.next()
        && ((low < 0.0 && next < 0.0) || (low > 0.0 && next > 0.0))
    {
        let twice = low * 2.0;
        let high = sum + twice;
        if twice == high - sum {
            sum = high;
        }
    }
    Ok(Value::Float(sum))
}

/// Largest argument of `factorial` and the like: the result has about 70 kB then.
const FACTORIAL_MAX: i64 = 50_000;

const INTEGERS: &[MethodDef] = &[
    ("factorial", "x /", |ev, args| factorial(ev, &args[0])),
    ("comb", "n k /", |ev, args| {
        if let Some((n, k)) = chosen_from_many(ev, args)? {
            let rest = &n - &k;
            let (choices, k) = falling(ev, &n, if rest < k { &rest } else { &k })?;
            let orders = product(ev, 2, k)?;
            return Ok(Value::bigint(ev.big_divmod(&choices, &orders)?.0));
        }
        let (n, k) = combination_arguments(ev, args)?;
        let k = k.min(n - k);
        if k <= 0 {
            return Ok(Value::Int(i64::from(k == 0)));
        }
        check_choice(ev, n, k)?;
        let (choices, orders) = (product(ev, n - k + 1, n)?, product(ev, 2, k)?);
        Ok(Value::bigint(ev.big_divmod(&choices, &orders)?.0))
    }),
    ("perm", "n k? /", |ev, args| {
        if args[1].is_unbound() || args[1].is_none() {
            return factorial(ev, &args[0]);
        }
        if let Some((n, k)) = chosen_from_many(ev, args)? {
            return Ok(Value::bigint(falling(ev, &n, &k)?.0));
        }
        let (n, k) = combination_arguments(ev, args)?;
        if k > n || k == 0 {
            return Ok(Value::Int(i64::from(k == 0)));
        }
        check_choice(ev, n, k)?;
        Ok(Value::bigint(product(ev, n - k + 1, n)?))
    }),
    ("isqrt", "n /", |ev, args| {
        let n = ev.to_int(&args[0])?;
        if n.is_negative() {
            return Err(ev.value_error("isqrt() argument must be nonnegative"));
        }
        Ok(Value::bigint(ev.big_root(&n.to_big())?))
    }),
    ("prod", "iterable / * start?", |ev, args| {
        let mut result = args[1].if_given().cloned().unwrap_or(Value::Int(1));
        for item in ev.drain(&ev.iter(&args[0])?)? {
            ev.charge(WORK_PER_VALUE)?;
            result = ev.binary(elite_syntax::ast::BinaryOp::Mul, &result, &item)?;
        }
        Ok(result)
    }),
];

fn integer_argument(ev: &Evaluator<'_>, value: &Value) -> R<i64> {
    if let Value::Float(_) = value {
        return Err(ev.type_error("'float' object cannot be interpreted as an integer"));
    }
    ev.clamped_index(value)
}

fn factorial(ev: &Evaluator<'_>, value: &Value) -> R {
    let n = integer_argument(ev, value)?;
    if n < 0 {
        return Err(ev.value_error("factorial() not defined for negative values"));
    }
    if n > FACTORIAL_MAX {
        // What does not fit is an error in CPython, too.
        let most = if n == i64::MAX { n } else { FACTORIAL_MAX };
        let text = format!("factorial() argument should not exceed {most}");
        return Err(ev.raise(ExceptionKind::OverflowError, text));
    }
    Ok(Value::bigint(product(ev, 2, n)?))
}

fn combination_arguments(ev: &Evaluator<'_>, args: &[Value]) -> R<(i64, i64)> {
    let (n, k) = (
        integer_argument(ev, &args[0])?,
        integer_argument(ev, &args[1])?,
    );
    if n < 0 {
        return Err(ev.value_error("n must be a non-negative integer"));
    }
    if k < 0 {
        return Err(ev.value_error("k must be a non-negative integer"));
    }
    Ok((n, k))
}

/// The arguments of `comb` and `perm` where `n` does not fit 64 bits; None where it does, or where nothing can be
/// chosen.
fn chosen_from_many(ev: &Evaluator<'_>, args: &[Value]) -> R<Option<(BigInt, BigInt)>> {
    combination_arguments(ev, args)?;
    let (n, k) = (ev.to_int(&args[0])?, ev.to_int(&args[1])?);
    let is_many = matches!(n, Int::Big(_));
    let (n, k) = (n.to_big(), k.to_big());
    Ok((is_many && k <= n).then_some((n, k)))
}

/// `n * (n - 1) * …`, `k` factors of them, and `k` as a small number.
fn falling(ev: &Evaluator<'_>, n: &BigInt, k: &BigInt) -> R<(BigInt, i64)> {
    let count = i64::try_from(k).unwrap_or(i64::MAX);
    if count > FACTORIAL_MAX {
        let text = format!("k must not exceed {FACTORIAL_MAX}");
        return Err(ev.raise(ExceptionKind::OverflowError, text));
    }
    ev.check_bits(n.bits().saturating_mul(count as u64))?;
    let mut result = BigInt::from(1);
    for i in 0..count {
        result = ev.big_product(&result, &(n - i))?;
    }
    Ok((result, count))
}

fn check_choice(ev: &Evaluator<'_>, n: i64, k: i64) -> R<()> {
    if k > FACTORIAL_MAX {
        let text = format!("k must not exceed {FACTORIAL_MAX}");
        return Err(ev.raise(ExceptionKind::OverflowError, text));
    }
    ev.check_bits(u64::from(64 - n.leading_zeros()) * k as u64)
}

/// `from * (from + 1) * … * to`, halved again and again so that the factors stay of like size.
fn product(ev: &Evaluator<'_>, from: i64, to: i64) -> R<BigInt> {
    if to < from {
        return Ok(BigInt::from(1));
    }
    if to - from < 8 {
        ev.charge(64 * WORK_PER_VALUE)?;
        return Ok((from..=to).map(BigInt::from).product());
    }
    let middle = from + (to - from) / 2;
    let (low, high) = (product(ev, from, middle)?, product(ev, middle + 1, to)?);
    ev.big_product(&low, &high)
}
