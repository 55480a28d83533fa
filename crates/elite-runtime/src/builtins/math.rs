//! Manual 3.2.5 to 3.2.34 and 4.8: numbers, vectors, poses, wrenches.
//!
//! Owns their declarations and the conversion of script values; the meaning is in `kinematics::script_math`, which the
//! Python wheel calls too. One Rust function a script function, of the same name.

use ::kinematics::script_math::{self as m, DomainError};
use ::kinematics::{RpyPose, Wrench};
use elite_lang::{ExceptionKind, Unwind, Value};

use super::call::Call;
use super::declare::{Body, Builtin, Category, Parameter, ParameterDefault, ParameterType, Range};

type MathResult = Result<Value, Unwind>;

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    bits_to_integer("bit_list_to_integer"),
    // The name in the vendor's editor extension.
    bits_to_integer("binary_list_to_integer"),
    // The names of the editions 2.12.1 to 2.13.0.
    bits_to_integer("byte_list_to_integer"),
    integer_to_bits("integer_to_byte_list"),
    integer_to_bits("integer_to_bit_list"),
    integer_to_bits("integer_to_binary_list"),
    math(
        "get_list_length",
        "3.2.7",
        "Number of entries of a list.",
        &[given("v", ParameterType::List, "", "the list")],
        "int",
        get_list_length,
    ),
    math(
        "length",
        "3.2.8",
        "Number of entries of a list or characters of a string.",
        &[given(
            "v",
            ParameterType::ListOrText,
            "",
            "the list or string",
        )],
        "int",
        length,
    ),
    math(
        "acos",
        "3.2.9",
        "Arc cosine.",
        &[number("f", Range::Between(-1.0, 1.0), "", "cosine")],
        "float, rad, 0 to pi",
        |call| Ok(m::acos(call.number(0)?).or_raise(call)?.into()),
    ),
    math(
        "asin",
        "3.2.10",
        "Arc sine.",
        &[number("f", Range::Between(-1.0, 1.0), "", "sine")],
        "float, rad, -pi/2 to pi/2",
        |call| Ok(m::asin(call.number(0)?).or_raise(call)?.into()),
    ),
    math(
        "atan",
        "3.2.11",
        "Arc tangent.",
        &[number("f", Range::Any, "", "tangent")],
        "float, rad, -pi/2 to pi/2",
        |call| Ok(call.number(0)?.atan().into()),
    ),
    math(
        "atan2",
        "3.2.12",
        "Angle whose tangent is x / y, in the quadrant that both signs give.",
        &[
            number("x", Range::Any, "", "numerator"),
            number("y", Range::Any, "", "denominator"),
        ],
        "float, rad, -pi to pi",
        |call| Ok(m::atan2(call.number(0)?, call.number(1)?).into()),
    ),
    math(
        "cos",
        "3.2.13",
        "Cosine.",
        &[number("f", Range::Any, "rad", "angle")],
        "float",
        |call| Ok(call.number(0)?.cos().into()),
    ),
    math(
        "sin",
        "3.2.14",
        "Sine.",
        &[number("f", Range::Any, "rad", "angle")],
        "float",
        |call| Ok(call.number(0)?.sin().into()),
    ),
    math(
        "tan",
        "3.2.15",
        "Tangent.",
        &[number("f", Range::Any, "rad", "angle")],
        "float",
        |call| Ok(call.number(0)?.tan().into()),
    ),
    math(
        "d2r",
        "3.2.16",
        "Degrees to radians.",
        &[number("d", Range::Any, "deg", "angle")],
        "float, rad",
        |call| Ok(m::d2r(call.number(0)?).into()),
    ),
    math(
        "r2d",
        "3.2.17",
        "Radians to degrees.",
        &[number("r", Range::Any, "rad", "angle")],
        "float, deg",
        |call| Ok(m::r2d(call.number(0)?).into()),
    ),
    math(
        "ceil",
        "3.2.18",
        "Smallest integer that is not below f.",
        &[number("f", Range::Any, "", "value")],
        "int",
        |call| whole(call, f64::ceil),
    ),
    math(
        "floor",
        "3.2.19",
        "Largest integer that is not above f.",
        &[number("f", Range::Any, "", "value")],
        "int",
        |call| whole(call, f64::floor),
    ),
    math(
        "log",
        "3.2.20",
        "Logarithm of f to base b; the base comes first.",
        &[
            number("b", Range::Positive, "", "base, not 1"),
            number("f", Range::Positive, "", "argument"),
        ],
        "float",
        |call| {
            Ok(m::log(call.number(0)?, call.number(1)?)
                .or_raise(call)?
                .into())
        },
    ),
    math(
        "sqrt",
        "3.2.21",
        "Square root.",
        &[number("f", Range::NotNegative, "", "value")],
        "float",
        |call| Ok(m::sqrt(call.number(0)?).or_raise(call)?.into()),
    ),
    math(
        "pow",
        "3.2.22",
        "Base to the power exponent, always a float.",
        &[
            number("base", Range::Any, "", "base"),
            number("exponent", Range::Any, "", "exponent"),
        ],
        "float",
        pow,
    ),
    math(
        "norm",
        "3.2.23",
        "Euclidean length of a list or pose (all numbers alike), absolute value of a number.",
        &[given(
            "a",
            ParameterType::NumberOrList,
            "",
            "pose, list or number",
        )],
        "float",
        |call| Ok(m::norm(&call.number_list(0)?).into()),
    ),
    math(
        "normalize",
        "3.2.24",
        "A vector divided by its Euclidean length.",
        &[given(
            "v",
            ParameterType::NumberList,
            "",
            "vector, not all zero",
        )],
        "list[float]",
        normalize,
    ),
    math(
        "point_dist",
        "3.2.25",
        "Distance of two positions; the rotations do not count.",
        &[pose("p_from", "first pose"), pose("p_to", "second pose")],
        "float, m",
        |call| Ok(m::point_dist(&call.pose(0)?, &call.pose(1)?).into()),
    ),
    math(
        "pose_add",
        "3.2.26",
        "Positions added, rotations chained; unlike pose_trans, p_2's position is not turned.",
        &[pose("p_1", "first pose"), pose("p_2", "second pose")],
        POSE,
        |call| pose_of_two(call, m::pose_add),
    ),
    math(
        "pose_dist",
        "3.2.27",
        "Euclidean length of the difference of the six numbers, m and rad mixed, angles not wrapped.",
        &[pose("p_from", "first pose"), pose("p_to", "second pose")],
        "float",
        |call| Ok(m::pose_dist(&call.pose(0)?, &call.pose(1)?).into()),
    ),
    math(
        "pose_inv",
        "3.2.28",
        "The inverse transform.",
        &[pose("p_from", "pose")],
        POSE,
        |call| Ok(pose_value(&m::pose_inv(&call.pose(0)?))),
    ),
    math(
        "pose_sub",
        "3.2.29",
        "Positions subtracted; rotation from p_from to p_to.",
        &[pose("p_to", "minuend"), pose("p_from", "subtrahend")],
        POSE,
        |call| pose_of_two(call, m::pose_sub),
    ),
    math(
        "pose_trans",
        "3.2.30",
        "A pose given in the frame of p_from, expressed in the frame p_from is given in.",
        &[
            pose("p_from", "frame"),
            pose("p_from_to", "pose in that frame"),
        ],
        POSE,
        |call| pose_of_two(call, m::pose_trans),
    ),
    math(
        "rotvec2rpy",
        "3.2.31",
        "Rotation vector (axis times angle) to roll, pitch, yaw.",
        &[given(
            "rotation_vector",
            ParameterType::Numbers(3),
            "rad",
            "axis times angle",
        )],
        "list[3] float, rad",
        |call| Ok(Value::list_of_f64(&m::rotvec2rpy(call.numbers(0)?))),
    ),
    math(
        "rpy2rotvec",
        "3.2.32",
        "Roll, pitch, yaw to rotation vector (axis times angle).",
        &[given(
            "rpy_vector",
            ParameterType::Numbers(3),
            "rad",
            "roll, pitch, yaw",
        )],
        "list[3] float, rad",
        |call| Ok(Value::list_of_f64(&m::rpy2rotvec(call.numbers(0)?))),
    ),
    math(
        "interpolate_pose",
        "3.2.33",
        "Between two poses: straight line for the position, shortest turn for the rotation.",
        &[
            pose("p_from", "pose at alpha 0"),
            pose("p_to", "pose at alpha 1"),
            number("alpha", Range::Any, "", "below 0 and above 1 goes on"),
        ],
        POSE,
        |call| {
            let (from, to) = (call.pose(0)?, call.pose(1)?);
            let between = m::interpolate_pose(&from, &to, call.number(2)?);
            Ok(pose_value(&between))
        },
    ),
    math(
        "random",
        "3.2.34",
        "Pseudo random number; the option --seed decides the sequence.",
        &[],
        "float, 0 to 1",
        random,
    ),
    Builtin {
        category: Category::Force,
        ..math(
            "wrench_trans",
            "4.8",
            "A wrench through the transform as it stands: F' = R F, M' = R M + t x F'.",
            &[
                pose("T_from_to", "the transform"),
                given(
                    "w_from",
                    ParameterType::Numbers(6),
                    "N, Nm",
                    "force, then moment, in the initial frame",
                ),
            ],
            "list[6] float, N and Nm",
            wrench_trans,
        )
    },
];

const POSE: &str = "list[6] float, m and rad";

const fn math(
    name: &'static str,
    section: &'static str,
    summary: &'static str,
    params: &'static [Parameter],
    returns: &'static str,
    run: Body,
) -> Builtin {
    Builtin {
        name,
        section,
        category: Category::Math,
        summary,
        params,
        returns,
        waits: false,
        run: Some(run),
    }
}

/// A parameter that must be given.
const fn given(
    name: &'static str,
    kind: ParameterType,
    unit: &'static str,
    meaning: &'static str,
) -> Parameter {
    Parameter {
        name,
        aliases: &[],
        kind,
        default: ParameterDefault::Required,
        unit,
        meaning,
    }
}

const fn number(
    name: &'static str,
    range: Range,
    unit: &'static str,
    meaning: &'static str,
) -> Parameter {
    given(name, ParameterType::Number(range), unit, meaning)
}

const fn pose(name: &'static str, meaning: &'static str) -> Parameter {
    given(name, ParameterType::Pose, "m, rad", meaning)
}

const BITS: Parameter = given(
    "l",
    ParameterType::Booleans(None),
    "",
    "bits, the lowest first",
);

const BITS_OF: Parameter = given(
    "x",
    ParameterType::Integer(i64::MIN, i64::MAX),
    "",
    "signed 32 bit; of a longer number the low 32 bits count",
);

const fn bits_to_integer(name: &'static str) -> Builtin {
    math(
        name,
        "3.2.5",
        "Bits to a number, the first bit lowest; from 32 bits on, the first 32 are a signed number.",
        &[BITS],
        "int",
        bit_list_to_integer,
    )
}

const fn integer_to_bits(name: &'static str) -> Builtin {
    math(
        name,
        "3.2.6",
        "The low 32 bits of a number in two's complement, the lowest first.",
        &[BITS_OF],
        "list[32] bool",
        integer_to_bit_list,
    )
}

/// A domain error of the library as an exception of the script.
trait OrRaise<T> {
    fn or_raise(self, call: &mut Call<'_, '_>) -> Result<T, Unwind>;
}

impl<T> OrRaise<T> for Result<T, DomainError> {
    fn or_raise(self, call: &mut Call<'_, '_>) -> Result<T, Unwind> {
        self.map_err(|error| call.error(ExceptionKind::ValueError, error.to_string()))
    }
}

fn pose_value(pose: &RpyPose) -> Value {
    Value::list_of_f64(&pose.to_array())
}

fn pose_of_two(call: &mut Call<'_, '_>, f: fn(&RpyPose, &RpyPose) -> RpyPose) -> MathResult {
    Ok(pose_value(&f(&call.pose(0)?, &call.pose(1)?)))
}

fn bit_list_to_integer(call: &mut Call<'_, '_>) -> MathResult {
    Ok(Value::Int(m::bit_list_to_integer(&call.booleans(0)?)))
}

fn integer_to_bit_list(call: &mut Call<'_, '_>) -> MathResult {
    let bits = m::integer_to_bit_list(call.integer(0)?);
    Ok(Value::list(bits.map(Value::Bool).to_vec()))
}

fn get_list_length(call: &mut Call<'_, '_>) -> MathResult {
    Ok(Value::Int(call.list(0)?.len() as i64))
}

fn length(call: &mut Call<'_, '_>) -> MathResult {
    if let Some(text) = call.given(0).and_then(Value::as_str) {
        return Ok(Value::Int(text.chars().count() as i64));
    }
    get_list_length(call)
}

fn whole(call: &mut Call<'_, '_>, round: fn(f64) -> f64) -> MathResult {
    let rounded = round(call.number(0)?);
    // The argument is finite, so the rounded number is.
    Ok(Value::whole_part(rounded).unwrap_or(Value::None))
}

fn pow(call: &mut Call<'_, '_>) -> MathResult {
    let (base, exponent) = (call.number(0)?, call.number(1)?);
    let power = base.powf(exponent);
    if power.is_finite() {
        return Ok(power.into());
    }
    let asked = format!("pow(): {base} to the power {exponent}");
    Err(if base == 0.0 {
        call.error(
            ExceptionKind::ValueError,
            format!("{asked} is not defined: 0 needs an exponent that is not negative"),
        )
    } else if power.is_nan() {
        call.error(
            ExceptionKind::ValueError,
            format!("{asked} is not a real number: a negative base needs a whole exponent"),
        )
    } else {
        call.error(
            ExceptionKind::OverflowError,
            format!("{asked} is too large for a float"),
        )
    })
}

fn normalize(call: &mut Call<'_, '_>) -> MathResult {
    let mut v = call.number_list(0)?;
    m::normalize(&mut v).or_raise(call)?;
    Ok(Value::list_of_f64(&v))
}

fn random(call: &mut Call<'_, '_>) -> MathResult {
    // The upper 53 bits: every float of this spacing in [0, 1) is equally likely.
    let bits = call.native().random_u64() >> 11;
    Ok((bits as f64 * (-53_f64).exp2()).into())
}

fn wrench_trans(call: &mut Call<'_, '_>) -> MathResult {
    let transform = call.pose(0)?;
    let wrench = Wrench::from_array(call.numbers(1)?);
    let moved = m::wrench_trans(&transform, &wrench);
    Ok(Value::list_of_f64(&moved.to_array()))
}
