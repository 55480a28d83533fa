//! Manual 3.2.5 to 3.2.34 and 4.8: numbers, vectors, poses, wrenches.
//!
//! Owns their declarations and the conversion of script values; the meaning is in `kinematics::script_math`, which the
//! Python wheel calls too. One Rust function a script function, of the same name.

use ::kinematics::script_math::{self as m, DomainError};
use ::kinematics::{RpyPose, Wrench};
use elite_lang::{ExceptionKind, Unwind, Value};
use messages::{Text, text};

use super::call::Call;
use super::declare::{
    Body, Builtin, Category, Parameter, ParameterDefault, ParameterType, Phrase, Range, phrase,
};

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
        phrase("Number of entries of a list.", "列表的元素个数。"),
        &[given(
            "v",
            ParameterType::List,
            "",
            phrase("the list", "列表"),
        )],
        phrase("int", "int"),
        get_list_length,
    ),
    math(
        "length",
        "3.2.8",
        phrase(
            "Number of entries of a list or characters of a string.",
            "列表的元素个数或字符串的字符数。",
        ),
        &[given(
            "v",
            ParameterType::ListOrText,
            "",
            phrase("the list or string", "列表或字符串"),
        )],
        phrase("int", "int"),
        length,
    ),
    math(
        "acos",
        "3.2.9",
        phrase("Arc cosine.", "反余弦。"),
        &[number(
            "f",
            Range::Between(-1.0, 1.0),
            "",
            phrase("cosine", "余弦值"),
        )],
        phrase("float, rad, 0 to pi", "float，rad，0 到 pi"),
        |call| Ok(m::acos(call.number(0)?).or_raise(call)?.into()),
    ),
    math(
        "asin",
        "3.2.10",
        phrase("Arc sine.", "反正弦。"),
        &[number(
            "f",
            Range::Between(-1.0, 1.0),
            "",
            phrase("sine", "正弦值"),
        )],
        phrase("float, rad, -pi/2 to pi/2", "float，rad，-pi/2 到 pi/2"),
        |call| Ok(m::asin(call.number(0)?).or_raise(call)?.into()),
    ),
    math(
        "atan",
        "3.2.11",
        phrase("Arc tangent.", "反正切。"),
        &[number("f", Range::Any, "", phrase("tangent", "正切值"))],
        phrase("float, rad, -pi/2 to pi/2", "float，rad，-pi/2 到 pi/2"),
        |call| Ok(call.number(0)?.atan().into()),
    ),
    math(
        "atan2",
        "3.2.12",
        phrase(
            "Angle whose tangent is x / y, in the quadrant that both signs give.",
            "正切为 x / y 的角，象限由两者的符号决定。",
        ),
        &[
            number("x", Range::Any, "", phrase("numerator", "分子")),
            number("y", Range::Any, "", phrase("denominator", "分母")),
        ],
        phrase("float, rad, -pi to pi", "float，rad，-pi 到 pi"),
        |call| Ok(m::atan2(call.number(0)?, call.number(1)?).into()),
    ),
    math(
        "cos",
        "3.2.13",
        phrase("Cosine.", "余弦。"),
        &[number("f", Range::Any, "rad", phrase("angle", "角度"))],
        phrase("float", "float"),
        |call| Ok(call.number(0)?.cos().into()),
    ),
    math(
        "sin",
        "3.2.14",
        phrase("Sine.", "正弦。"),
        &[number("f", Range::Any, "rad", phrase("angle", "角度"))],
        phrase("float", "float"),
        |call| Ok(call.number(0)?.sin().into()),
    ),
    math(
        "tan",
        "3.2.15",
        phrase("Tangent.", "正切。"),
        &[number("f", Range::Any, "rad", phrase("angle", "角度"))],
        phrase("float", "float"),
        |call| Ok(call.number(0)?.tan().into()),
    ),
    math(
        "d2r",
        "3.2.16",
        phrase("Degrees to radians.", "角度转弧度。"),
        &[number("d", Range::Any, "deg", phrase("angle", "角度"))],
        phrase("float, rad", "float，rad"),
        |call| Ok(m::d2r(call.number(0)?).into()),
    ),
    math(
        "r2d",
        "3.2.17",
        phrase("Radians to degrees.", "弧度转角度。"),
        &[number("r", Range::Any, "rad", phrase("angle", "角度"))],
        phrase("float, deg", "float，度"),
        |call| Ok(m::r2d(call.number(0)?).into()),
    ),
    math(
        "ceil",
        "3.2.18",
        phrase(
            "Smallest integer that is not below f.",
            "不小于 f 的最小整数。",
        ),
        &[number("f", Range::Any, "", phrase("value", "值"))],
        phrase("int", "int"),
        |call| whole(call, f64::ceil),
    ),
    math(
        "floor",
        "3.2.19",
        phrase(
            "Largest integer that is not above f.",
            "不大于 f 的最大整数。",
        ),
        &[number("f", Range::Any, "", phrase("value", "值"))],
        phrase("int", "int"),
        |call| whole(call, f64::floor),
    ),
    math(
        "log",
        "3.2.20",
        phrase(
            "Logarithm of f to base b; the base comes first.",
            "f 以 b 为底的对数；底数在前。",
        ),
        &[
            number(
                "b",
                Range::Positive,
                "",
                phrase("base, not 1", "底数，不能为 1"),
            ),
            number("f", Range::Positive, "", phrase("argument", "自变量")),
        ],
        phrase("float", "float"),
        |call| {
            Ok(m::log(call.number(0)?, call.number(1)?)
                .or_raise(call)?
                .into())
        },
    ),
    math(
        "sqrt",
        "3.2.21",
        phrase("Square root.", "平方根。"),
        &[number("f", Range::NotNegative, "", phrase("value", "值"))],
        phrase("float", "float"),
        |call| Ok(m::sqrt(call.number(0)?).or_raise(call)?.into()),
    ),
    math(
        "pow",
        "3.2.22",
        phrase(
            "Base to the power exponent, always a float.",
            "base 的 exponent 次幂，结果总是浮点数。",
        ),
        &[
            number("base", Range::Any, "", phrase("base", "底数")),
            number("exponent", Range::Any, "", phrase("exponent", "指数")),
        ],
        phrase("float", "float"),
        pow,
    ),
    math(
        "norm",
        "3.2.23",
        phrase(
            "Euclidean length of a list or pose (all numbers alike), absolute value of a number.",
            "列表或位姿的欧氏长度（各数同等对待），或数的绝对值。",
        ),
        &[given(
            "a",
            ParameterType::NumberOrList,
            "",
            phrase("pose, list or number", "位姿、列表或数"),
        )],
        phrase("float", "float"),
        |call| Ok(m::norm(&call.number_list(0)?).into()),
    ),
    math(
        "normalize",
        "3.2.24",
        phrase(
            "A vector divided by its Euclidean length.",
            "向量除以其欧氏长度。",
        ),
        &[given(
            "v",
            ParameterType::NumberList,
            "",
            phrase("vector, not all zero", "向量，不能全为零"),
        )],
        phrase("list[float]", "list[float]"),
        normalize,
    ),
    math(
        "point_dist",
        "3.2.25",
        phrase(
            "Distance of two positions; the rotations do not count.",
            "两个位置之间的距离；不计姿态。",
        ),
        &[
            pose("p_from", phrase("first pose", "第一个位姿")),
            pose("p_to", phrase("second pose", "第二个位姿")),
        ],
        phrase("float, m", "float，m"),
        |call| Ok(m::point_dist(&call.pose(0)?, &call.pose(1)?).into()),
    ),
    math(
        "pose_add",
        "3.2.26",
        phrase(
            "Positions added, rotations chained; unlike pose_trans, p_2's position is not turned.",
            "位置相加，姿态依次相乘；与 pose_trans 不同，p_2 的位置不随之转动。",
        ),
        &[
            pose("p_1", phrase("first pose", "第一个位姿")),
            pose("p_2", phrase("second pose", "第二个位姿")),
        ],
        POSE,
        |call| pose_of_two(call, m::pose_add),
    ),
    math(
        "pose_dist",
        "3.2.27",
        phrase(
            "Euclidean length of the difference of the six numbers, m and rad mixed, angles not \
             wrapped.",
            "六个数之差的欧氏长度，米与弧度混合，角度不归一。",
        ),
        &[
            pose("p_from", phrase("first pose", "第一个位姿")),
            pose("p_to", phrase("second pose", "第二个位姿")),
        ],
        phrase("float", "float"),
        |call| Ok(m::pose_dist(&call.pose(0)?, &call.pose(1)?).into()),
    ),
    math(
        "pose_inv",
        "3.2.28",
        phrase("The inverse transform.", "逆变换。"),
        &[pose("p_from", phrase("pose", "位姿"))],
        POSE,
        |call| Ok(pose_value(&m::pose_inv(&call.pose(0)?))),
    ),
    math(
        "pose_sub",
        "3.2.29",
        phrase(
            "Positions subtracted; rotation from p_from to p_to.",
            "位置相减；姿态为从 p_from 到 p_to 的旋转。",
        ),
        &[
            pose("p_to", phrase("minuend", "被减位姿")),
            pose("p_from", phrase("subtrahend", "减去的位姿")),
        ],
        POSE,
        |call| pose_of_two(call, m::pose_sub),
    ),
    math(
        "pose_trans",
        "3.2.30",
        phrase(
            "A pose given in the frame of p_from, expressed in the frame p_from is given in.",
            "把在 p_from 坐标系下给出的位姿变换到 p_from 所在的坐标系。",
        ),
        &[
            pose("p_from", phrase("frame", "坐标系")),
            pose(
                "p_from_to",
                phrase("pose in that frame", "该坐标系下的位姿"),
            ),
        ],
        POSE,
        |call| pose_of_two(call, m::pose_trans),
    ),
    math(
        "rotvec2rpy",
        "3.2.31",
        phrase(
            "Rotation vector (axis times angle) to roll, pitch, yaw.",
            "旋转矢量（轴乘角）转为横滚、俯仰、偏航。",
        ),
        &[given(
            "rotation_vector",
            ParameterType::Numbers(3),
            "rad",
            phrase("axis times angle", "转轴乘以转角"),
        )],
        phrase("list[3] float, rad", "list[3] float，rad"),
        |call| Ok(Value::list_of_f64(&m::rotvec2rpy(call.numbers(0)?))),
    ),
    math(
        "rpy2rotvec",
        "3.2.32",
        phrase(
            "Roll, pitch, yaw to rotation vector (axis times angle).",
            "横滚、俯仰、偏航转为旋转矢量（轴乘角）。",
        ),
        &[given(
            "rpy_vector",
            ParameterType::Numbers(3),
            "rad",
            phrase("roll, pitch, yaw", "滚转、俯仰、偏航"),
        )],
        phrase("list[3] float, rad", "list[3] float，rad"),
        |call| Ok(Value::list_of_f64(&m::rpy2rotvec(call.numbers(0)?))),
    ),
    math(
        "interpolate_pose",
        "3.2.33",
        phrase(
            "Between two poses: straight line for the position, shortest turn for the rotation.",
            "两位姿之间插值：位置走直线，姿态走最短旋转。",
        ),
        &[
            pose("p_from", phrase("pose at alpha 0", "alpha 为 0 时的位姿")),
            pose("p_to", phrase("pose at alpha 1", "alpha 为 1 时的位姿")),
            number(
                "alpha",
                Range::Any,
                "",
                phrase(
                    "below 0 and above 1 goes on",
                    "小于 0 或大于 1 时沿同一方向外推",
                ),
            ),
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
        phrase(
            "Pseudo random number; the option --seed decides the sequence.",
            "伪随机数；序列由选项 --seed 决定。",
        ),
        &[],
        phrase("float, 0 to 1", "float，0 到 1"),
        random,
    ),
    Builtin {
        category: Category::Force,
        ..math(
            "wrench_trans",
            "4.8",
            phrase(
                "A wrench through the transform as it stands: F' = R F, M' = R M + t x F'.",
                "按变换本身变换力旋量：F' = R F，M' = R M + t x F'。",
            ),
            &[
                pose("T_from_to", phrase("the transform", "变换")),
                given(
                    "w_from",
                    ParameterType::Numbers(6),
                    "N, Nm",
                    phrase(
                        "force, then moment, in the initial frame",
                        "先力后力矩，在初始坐标系下",
                    ),
                ),
            ],
            phrase("list[6] float, N and Nm", "list[6] float，N 和 Nm"),
            wrench_trans,
        )
    },
];

const POSE: Phrase = phrase("list[6] float, m and rad", "list[6] float，m 和 rad");

const fn math(
    name: &'static str,
    section: &'static str,
    summary: Phrase,
    params: &'static [Parameter],
    returns: Phrase,
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
    meaning: Phrase,
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
    meaning: Phrase,
) -> Parameter {
    given(name, ParameterType::Number(range), unit, meaning)
}

const fn pose(name: &'static str, meaning: Phrase) -> Parameter {
    given(name, ParameterType::Pose, "m, rad", meaning)
}

const BITS: Parameter = given(
    "l",
    ParameterType::Booleans(None),
    "",
    phrase("bits, the lowest first", "各位，最低位在前"),
);

const BITS_OF: Parameter = given(
    "x",
    ParameterType::Integer(i64::MIN, i64::MAX),
    "",
    phrase(
        "signed 32 bit; of a longer number the low 32 bits count",
        "有符号 32 位；更长的数只取低 32 位",
    ),
);

const fn bits_to_integer(name: &'static str) -> Builtin {
    math(
        name,
        "3.2.5",
        phrase(
            "Bits to a number, the first bit lowest; from 32 bits on, the first 32 are a signed \
             number.",
            "由位得到整数，首位为最低位；满 32 位时前 32 位为有符号数。",
        ),
        &[BITS],
        phrase("int", "int"),
        bit_list_to_integer,
    )
}

const fn integer_to_bits(name: &'static str) -> Builtin {
    math(
        name,
        "3.2.6",
        phrase(
            "The low 32 bits of a number in two's complement, the lowest first.",
            "整数补码的低 32 位，最低位在前。",
        ),
        &[BITS_OF],
        phrase("list[32] bool", "list[32] bool"),
        integer_to_bit_list,
    )
}

/// A domain error of the library as an exception of the script.
trait OrRaise<T> {
    fn or_raise(self, call: &mut Call<'_, '_>) -> Result<T, Unwind>;
}

impl<T> OrRaise<T> for Result<T, DomainError> {
    fn or_raise(self, call: &mut Call<'_, '_>) -> Result<T, Unwind> {
        self.map_err(|error| call.error(ExceptionKind::ValueError, Text::of(&error)))
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
    let asked = text!(
        "pow(): {base} to the power {exponent}",
        "pow()：{base} 的 {exponent} 次方"
    );
    Err(if base == 0.0 {
        call.error(
            ExceptionKind::ValueError,
            text!(
                "{asked} is not defined: 0 needs an exponent that is not negative",
                "{asked} 没有定义：0 需要非负的指数"
            ),
        )
    } else if power.is_nan() {
        call.error(
            ExceptionKind::ValueError,
            text!(
                "{asked} is not a real number: a negative base needs a whole exponent",
                "{asked} 不是实数：负的底数需要整数指数"
            ),
        )
    } else {
        call.error(
            ExceptionKind::OverflowError,
            text!("{asked} is too large for a float", "{asked} 对浮点数过大"),
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
