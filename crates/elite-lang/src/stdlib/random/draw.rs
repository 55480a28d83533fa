//! Distributions and choices on top of the generator.
//!
//! A seeded program draws the numbers that CPython draws: the same random bits are asked for in the same order and the
//! same formulas are evaluated, which the papers named below define. A subclass may put its own `random` or
//! `getrandbits` in the place of the generator's.

use std::cell::RefCell;
use std::collections::HashSet;
use std::f64::consts::{E, PI, TAU};
use std::rc::Rc;

use elite_syntax::ast::BinaryOp;
use num_bigint::{BigInt, Sign};

use super::MersenneTwister;
use crate::errors::ExceptionKind;
use crate::eval::Evaluator;
use crate::stdlib::bisect::{BisectSide, place};
use crate::stdlib::define::{MethodDef, with_data};
use crate::value::int::Int;
use crate::value::{R, Unwind, Value};

/// The methods of the generator's class.
pub(super) const METHODS: &[MethodDef] = &[
    ("randbytes", "n", |ev, args| {
        let count = ev.index(&args[1])?;
        let bits = Value::Int(count.saturating_mul(8));
        let number = BitSource(&args[0]).bits(ev, bits)?.to_big();
        let mut bytes = number.magnitude().to_bytes_le();
        bytes.resize(usize::try_from(count).unwrap_or(0), 0);
        Ok(Value::bytes(bytes))
    }),
    ("_randbelow", "n /", |ev, args| {
        let most = ev.to_int(&args[1])?.to_big();
        Ok(Value::bigint(BitSource(&args[0]).below_big(ev, &most)?))
    }),
    ("randrange", "start stop? step?", randrange),
    ("randint", "a b", |ev, args| {
        let (low, high) = (
            integer_argument(ev, &args[1])?,
            integer_argument(ev, &args[2])? + 1,
        );
        int_in_range(ev, &args[0], low, high)
    }),
    ("choice", "seq", |ev, args| {
        let length = ev.len(&args[1])? as u64;
        if length == 0 {
            let text = "Cannot choose from an empty sequence";
            return Err(ev.raise(ExceptionKind::IndexError, text));
        }
        let index = BitSource(&args[0]).below(ev, length)?;
        ev.item(&args[1], &Value::Int(index as i64))
    }),
    ("shuffle", "x", |ev, args| {
        let items = &args[1];
        for last in (1..ev.len(items)? as u64).rev() {
            let other = Value::Int(BitSource(&args[0]).below(ev, last + 1)? as i64);
            let last = Value::Int(last as i64);
            let (a, b) = (ev.item(items, &last)?, ev.item(items, &other)?);
            ev.set_item(items, &last, b)?;
            ev.set_item(items, &other, a)?;
            ev.safepoint()?;
        }
        Ok(Value::None)
    }),
    ("sample", "population k * counts?", sample),
    ("choices", "population weights? * cum_weights? k?", choices),
    ("uniform", "a b", |ev, args| {
        let (a, b) = (ev.to_f64(&args[1])?, ev.to_f64(&args[2])?);
        Ok(Value::Float(a + (b - a) * BitSource(&args[0]).float(ev)?))
    }),
    ("triangular", "low? high? mode?", triangular),
    ("normalvariate", "mu? sigma?", |ev, args| {
        let (mu, sigma) = (or(ev, &args[1], 0.0)?, or(ev, &args[2], 1.0)?);
        normal(ev, &args[0], mu, sigma).map(Value::Float)
    }),
    ("gauss", "mu? sigma?", gauss),
    ("lognormvariate", "mu sigma", |ev, args| {
        let (mu, sigma) = (ev.to_f64(&args[1])?, ev.to_f64(&args[2])?);
        let result = normal(ev, &args[0], mu, sigma)?.exp();
        match result.is_infinite() {
            true => Err(ev.raise(ExceptionKind::OverflowError, "math range error")),
            false => Ok(Value::Float(result)),
        }
    }),
    ("expovariate", "lambd", |ev, args| {
        let rate = ev.to_f64(&args[1])?;
        let drawn = -(1.0 - BitSource(&args[0]).float(ev)?).ln();
        checked_div(ev, drawn, rate).map(Value::Float)
    }),
    ("vonmisesvariate", "mu kappa", von_mises),
    ("gammavariate", "alpha beta", |ev, args| {
        let (alpha, beta) = (ev.to_f64(&args[1])?, ev.to_f64(&args[2])?);
        gamma(ev, &args[0], alpha, beta).map(Value::Float)
    }),
    ("betavariate", "alpha beta", |ev, args| {
        let (alpha, beta) = (ev.to_f64(&args[1])?, ev.to_f64(&args[2])?);
        let y = gamma(ev, &args[0], alpha, 1.0)?;
        if y == 0.0 {
            return Ok(Value::Float(0.0));
        }
        Ok(Value::Float(y / (y + gamma(ev, &args[0], beta, 1.0)?)))
    }),
    ("paretovariate", "alpha", |ev, args| {
        let alpha = ev.to_f64(&args[1])?;
        let u = 1.0 - BitSource(&args[0]).float(ev)?;
        Ok(Value::Float(u.powf(checked_div(ev, -1.0, alpha)?)))
    }),
    ("weibullvariate", "alpha beta", |ev, args| {
        let (alpha, beta) = (ev.to_f64(&args[1])?, ev.to_f64(&args[2])?);
        let u = 1.0 - BitSource(&args[0]).float(ev)?;
        Ok(Value::Float(
            alpha * (-u.ln()).powf(checked_div(ev, 1.0, beta)?),
        ))
    }),
];

/// What random bits come from: a generator, or what a subclass has made of it.
struct BitSource<'v>(&'v Value);

impl BitSource<'_> {
    /// The method of this name, if it is not the generator's own.
    fn own_method(&self, ev: &Evaluator<'_>, name: &str) -> Option<Value> {
        let Value::Instance(instance) = self.0 else {
            return None;
        };
        let method = instance.class.lookup(ev.core.symbols.intern(name))?;
        (!matches!(method, Value::Builtin(_))).then_some(method)
    }

    fn twister<O>(&self, ev: &Evaluator<'_>, act: impl FnOnce(&mut MersenneTwister) -> O) -> R<O> {
        with_data(ev, self.0, |twister: &Rc<RefCell<MersenneTwister>>| {
            Ok(act(&mut twister.borrow_mut()))
        })
    }

    /// A float from 0 up to 1.
    fn float(&self, ev: &Evaluator<'_>) -> R<f64> {
        match self.own_method(ev, "random") {
            None => self.twister(ev, MersenneTwister::float),
            Some(method) => {
                let drawn = ev.call_method_value(&method, self.0, &mut [])?;
                ev.to_f64(&drawn)
            }
        }
    }

    /// An integer of so many random bits.
    fn bits(&self, ev: &Evaluator<'_>, count: Value) -> R<Int> {
        let drawn = match self.own_method(ev, "getrandbits") {
            None => super::bits(ev, &mut [self.0.clone(), count])?,
            Some(method) => ev.call_method_value(&method, self.0, &mut [count])?,
        };
        ev.to_int(&drawn)
    }

    /// An integer from 0 up to `most`, each as likely as the others.
    fn below(&self, ev: &Evaluator<'_>, most: u64) -> R<u64> {
        if self.own_method(ev, "getrandbits").is_some() {
            let drawn = self.below_big(ev, &BigInt::from(most))?;
            return Ok(u64::try_from(drawn).unwrap_or(0));
        }
        let count = u64::BITS - most.leading_zeros();
        loop {
            let drawn = self.twister(ev, |twister| match count {
                0 => 0,
                1..=32 => u64::from(twister.word() >> (32 - count)),
                _ => {
                    let low = u64::from(twister.word());
                    low | u64::from(twister.word() >> (64 - count)) << 32
                }
            })?;
            if drawn < most || most == 0 {
                return Ok(drawn);
            }
            ev.safepoint()?;
        }
    }

    fn below_big(&self, ev: &Evaluator<'_>, most: &BigInt) -> R<BigInt> {
        loop {
            let drawn = self.bits(ev, Value::Int(most.bits() as i64))?.to_big();
            if drawn < *most || most.sign() != Sign::Plus {
                return Ok(drawn);
            }
            ev.safepoint()?;
        }
    }
}

fn or(ev: &Evaluator<'_>, value: &Value, default: f64) -> R<f64> {
    value
        .if_given()
        .map_or(Ok(default), |value| ev.to_f64(value))
}

fn checked_div(ev: &Evaluator<'_>, a: f64, b: f64) -> R<f64> {
    match b == 0.0 {
        true => Err(ev.raise(ExceptionKind::ZeroDivisionError, "float division by zero")),
        false => Ok(a / b),
    }
}

/// An integer, or a float that is one.
fn integer_argument(ev: &Evaluator<'_>, value: &Value) -> R<BigInt> {
    match value {
        Value::Float(float) if float.fract() == 0.0 => Ok(ev.to_int(&ev.int_of(value)?)?.to_big()),
        Value::Float(_) => Err(ev.value_error("non-integer arg 1 for randrange()")),
        value => Ok(ev.to_int(value)?.to_big()),
    }
}

fn empty_range(ev: &Evaluator<'_>, range: Option<(&BigInt, &BigInt)>) -> Unwind {
    ev.value_error(match range {
        Some((start, stop)) => {
            format!(
                "empty range for randrange() ({start}, {stop}, {})",
                stop - start
            )
        }
        None => "empty range for randrange()".to_owned(),
    })
}

/// An integer from `start` up to `stop`.
fn int_in_range(ev: &Evaluator<'_>, this: &Value, start: BigInt, stop: BigInt) -> R {
    let width = &stop - &start;
    if width.sign() != Sign::Plus {
        return Err(empty_range(ev, Some((&start, &stop))));
    }
    let drawn = match u64::try_from(&width) {
        Ok(width) => BigInt::from(BitSource(this).below(ev, width)?),
        Err(_) => BitSource(this).below_big(ev, &width)?,
    };
    Ok(Value::bigint(start + drawn))
}

fn randrange(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let start = integer_argument(ev, &args[1])?;
    let step = args[3]
        .if_given()
        .map_or(Ok(BigInt::from(1)), |step| integer_argument(ev, step))?;
    let Some(stop) = args[2].if_given().filter(|stop| !stop.is_none()) else {
        if step != BigInt::from(1) {
            return Err(ev.type_error("Missing a non-None stop argument"));
        }
        if start.sign() != Sign::Plus {
            return Err(empty_range(ev, None));
        }
        return int_in_range(ev, &args[0], BigInt::ZERO, start);
    };
    let stop = integer_argument(ev, stop)?;
    if step == BigInt::from(1) {
        return int_in_range(ev, &args[0], start, stop);
    }
    let width = &stop - &start;
    // The number of steps that begin within the range.
    let steps = match step.sign() {
        Sign::Plus => rounded_up(&width, &step),
        Sign::Minus => rounded_up(&-width, &-&step),
        Sign::NoSign => return Err(ev.value_error("zero step for randrange()")),
    };
    if steps.sign() != Sign::Plus {
        return Err(empty_range(ev, None));
    }
    let drawn = int_in_range(ev, &args[0], BigInt::ZERO, steps)?;
    Ok(Value::bigint(start + step * ev.to_int(&drawn)?.to_big()))
}

/// `a / b` rounded up, for a positive `b`.
fn rounded_up(a: &BigInt, b: &BigInt) -> BigInt {
    let quotient = a / b;
    match a.sign() == Sign::Plus && &quotient * b != *a {
        true => quotient + 1,
        false => quotient,
    }
}

fn sample(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let (this, population) = (&args[0], &args[1]);
    let has_no_order = matches!(
        ev.unwrap_builtin(population),
        Value::Set(_) | Value::FrozenSet(_) | Value::Dict(_)
    );
    let get_item = crate::value::symbol::known::GETITEM;
    if has_no_order || ev.attribute_or_none(population, get_item)?.is_none() {
        let text = "Population must be a sequence.  For dicts or sets, use sorted(d).";
        return Err(ev.type_error(text));
    }
    let length = ev.len(population)? as u64;
    if let Some(counts) = args[3].if_given().filter(|counts| !counts.is_none()) {
        return sample_of_counts(ev, args, length, counts);
    }
    let wanted = u64::try_from(ev.index(&args[2])?)
        .ok()
        .filter(|wanted| *wanted <= length);
    let Some(wanted) = wanted else {
        return Err(ev.value_error("Sample larger than population or is negative"));
    };
    let mut chosen = ev.try_with_capacity(wanted as usize)?;
    // A table of chosen places takes less than a copy of the population when few are chosen.
    let table = match wanted {
        0..=5 => 21.0,
        _ => 21.0 + 4f64.powf((((wanted * 3) as f64).ln() / 4f64.ln()).ceil()),
    };
    if length as f64 <= table {
        let mut pool = ev.collect(population)?;
        for done in 0..wanted {
            let at = BitSource(this).below(ev, length - done)? as usize;
            let last = (length - done - 1) as usize;
            if at >= pool.len() || last >= pool.len() {
                let text = "list index out of range";
                return Err(ev.raise(ExceptionKind::IndexError, text));
            }
            let moved = pool[last].clone();
            chosen.push(std::mem::replace(&mut pool[at], moved));
            ev.safepoint()?;
        }
        return Ok(Value::list(chosen));
    }
    let mut taken = HashSet::new();
    for _ in 0..wanted {
        let at = loop {
            let at = BitSource(this).below(ev, length)?;
            if taken.insert(at) {
                break at;
            }
        };
        chosen.push(ev.item(population, &Value::Int(at as i64))?);
        ev.safepoint()?;
    }
    Ok(Value::list(chosen))
}

fn sample_of_counts(ev: &Evaluator<'_>, args: &[Value], length: u64, counts: &Value) -> R {
    let ends = sums(ev, counts)?;
    if ends.len() as u64 != length {
        return Err(ev.value_error("The number of counts does not match the population"));
    }
    let total = ends.last().cloned().unwrap_or(Value::Int(0));
    let Some(number) = Int::of(&total) else {
        return Err(ev.type_error("Counts must be integers"));
    };
    if number.to_big().sign() != Sign::Plus {
        return Err(ev.value_error("Total of counts must be greater than zero"));
    }
    let places = Value::range(BigInt::ZERO, number.to_big(), BigInt::from(1));
    let mut inner = [args[0].clone(), places, args[2].clone(), Value::Unbound];
    let drawn = sample(ev, &mut inner)?;
    let (ends, bounds) = (Value::list(ends), (0, length as i64 - 1));
    let mut chosen = Vec::new();
    for number in ev.collect(&drawn)? {
        let at = place(ev, &ends, &number, bounds, None, BisectSide::Right)?;
        chosen.push(ev.item(&args[1], &Value::Int(at))?);
    }
    Ok(Value::list(chosen))
}

/// The sums of the first one, two, three … numbers.
fn sums(ev: &Evaluator<'_>, numbers: &Value) -> R<Vec<Value>> {
    let mut sums: Vec<Value> = Vec::new();
    for number in ev.collect(numbers)? {
        let sum = match sums.last() {
            Some(before) => ev.binary(BinaryOp::Add, before, &number)?,
            None => number,
        };
        sums.push(sum);
        ev.safepoint()?;
    }
    Ok(sums)
}

fn choices(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let (this, population) = (&args[0], &args[1]);
    let given = |value: &Value| value.if_given().filter(|value| !value.is_none()).cloned();
    let (weights, ends) = (given(&args[2]), given(&args[3]));
    let wanted = args[4].if_given().map_or(Ok(1), |k| ev.index(k))?;
    let length = ev.len(population)?;
    let ends = match (weights, ends) {
        (Some(_), Some(_)) => {
            return Err(ev.type_error("Cannot specify both weights and cumulative weights"));
        }
        (Some(weights), None) => {
            if Int::of(&weights).is_some() {
                let shown = ev.repr(&weights)?;
                return Err(ev.type_error(format!(
                    "The number of choices must be a keyword argument: k={shown}"
                )));
            }
            Some(Value::list(sums(ev, &weights)?))
        }
        (None, ends) => ends,
    };
    let mut chosen = Vec::new();
    let Some(ends) = ends else {
        for _ in 0..wanted {
            let at = (BitSource(this).float(ev)? * length as f64).floor();
            chosen.push(ev.item(population, &Value::Int(at as i64))?);
            ev.safepoint()?;
        }
        return Ok(Value::list(chosen));
    };
    if ev.len(&ends)? != length {
        return Err(ev.value_error("The number of weights does not match the population"));
    }
    let total = ev.to_f64(&ev.item(&ends, &Value::Int(-1))?)?;
    if total <= 0.0 {
        return Err(ev.value_error("Total of weights must be greater than zero"));
    }
    if !total.is_finite() {
        return Err(ev.value_error("Total of weights must be finite"));
    }
    for _ in 0..wanted {
        let drawn = Value::Float(BitSource(this).float(ev)? * total);
        let at = place(
            ev,
            &ends,
            &drawn,
            (0, length as i64 - 1),
            None,
            BisectSide::Right,
        )?;
        chosen.push(ev.item(population, &Value::Int(at))?);
    }
    Ok(Value::list(chosen))
}

fn triangular(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let (mut low, mut high) = (or(ev, &args[1], 0.0)?, or(ev, &args[2], 1.0)?);
    let mut u = BitSource(&args[0]).float(ev)?;
    let mut share = match args[3].if_given().filter(|mode| !mode.is_none()) {
        None => 0.5,
        Some(_) if low == high => {
            return Ok(args[1].if_given().cloned().unwrap_or(Value::Float(0.0)));
        }
        Some(mode) => (ev.to_f64(mode)? - low) / (high - low),
    };
    if u > share {
        (u, share) = (1.0 - u, 1.0 - share);
        (low, high) = (high, low);
    }
    Ok(Value::Float(low + (high - low) * (u * share).sqrt()))
}

/// By the ratio of two uniform variates (Kinderman and Monahan 1977).
fn normal(ev: &Evaluator<'_>, this: &Value, mu: f64, sigma: f64) -> R<f64> {
    let width = 4.0 * (-0.5f64).exp() / 2f64.sqrt();
    loop {
        let a = BitSource(this).float(ev)?;
        let b = 1.0 - BitSource(this).float(ev)?;
        let z = width * (a - 0.5) / b;
        if z * z / 4.0 <= -b.ln() {
            return Ok(mu + z * sigma);
        }
        ev.safepoint()?;
    }
}

/// Two at a time, one of which is kept (Box and Muller 1958).
fn gauss(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let (mu, sigma) = (or(ev, &args[1], 0.0)?, or(ev, &args[2], 1.0)?);
    let drawn = BitSource(&args[0]);
    let kept = drawn.twister(ev, |twister| twister.kept.take())?;
    let z = match kept {
        Some(z) => z,
        None => {
            let angle = drawn.float(ev)? * TAU;
            let radius = (-2.0 * (1.0 - drawn.float(ev)?).ln()).sqrt();
            drawn.twister(ev, |twister| twister.kept = Some(angle.sin() * radius))?;
            angle.cos() * radius
        }
    };
    Ok(Value::Float(mu + z * sigma))
}

/// Best and Fisher 1979.
fn von_mises(ev: &Evaluator<'_>, args: &mut [Value]) -> R {
    let (mu, kappa) = (ev.to_f64(&args[1])?, ev.to_f64(&args[2])?);
    let drawn = BitSource(&args[0]);
    if kappa <= 1e-6 {
        return Ok(Value::Float(TAU * drawn.float(ev)?));
    }
    let s = 0.5 / kappa;
    let r = s + (1.0 + s * s).sqrt();
    let z = loop {
        let z = (PI * drawn.float(ev)?).cos();
        let d = z / (r + z);
        let u = drawn.float(ev)?;
        if u < 1.0 - d * d || u <= (1.0 - d) * d.exp() {
            break z;
        }
        ev.safepoint()?;
    };
    let q = 1.0 / r;
    let turn = ((q + z) / (1.0 + q * z)).acos();
    let angle = match drawn.float(ev)? > 0.5 {
        true => mu + turn,
        false => mu - turn,
    };
    ev.binary(BinaryOp::Mod, &Value::Float(angle), &Value::Float(TAU))
}

fn gamma(ev: &Evaluator<'_>, this: &Value, alpha: f64, beta: f64) -> R<f64> {
    if alpha <= 0.0 || beta <= 0.0 {
        return Err(ev.value_error("gammavariate: alpha and beta must be > 0.0"));
    }
    let drawn = BitSource(this);
    if alpha > 1.0 {
        return gamma_above_one(ev, &drawn, alpha).map(|x| x * beta);
    }
    if alpha == 1.0 {
        return Ok(-(1.0 - drawn.float(ev)?).ln() * beta);
    }
    // Ahrens and Dieter 1974, algorithm GS.
    let b = (E + alpha) / E;
    loop {
        let p = b * drawn.float(ev)?;
        let x = match p <= 1.0 {
            true => p.powf(1.0 / alpha),
            false => -((b - p) / alpha).ln(),
        };
        let u = drawn.float(ev)?;
        let limit = match p > 1.0 {
            true => x.powf(alpha - 1.0),
            false => (-x).exp(),
        };
        if u <= limit {
            return Ok(x * beta);
        }
        ev.safepoint()?;
    }
}

/// Cheng 1977.
fn gamma_above_one(ev: &Evaluator<'_>, drawn: &BitSource<'_>, alpha: f64) -> R<f64> {
    let a = (2.0 * alpha - 1.0).sqrt();
    let b = alpha - 4f64.ln();
    let c = alpha + a;
    loop {
        ev.safepoint()?;
        let u = drawn.float(ev)?;
        if !(1e-7 < u && u < 0.999_999_9) {
            continue;
        }
        let w = 1.0 - drawn.float(ev)?;
        let v = (u / (1.0 - u)).ln() / a;
        let x = alpha * v.exp();
        let z = u * u * w;
        let r = b + c * v - x;
        if r + (1.0 + 4.5f64.ln()) - 4.5 * z >= 0.0 || r >= z.ln() {
            return Ok(x);
        }
    }
}
