//! Manual 3.1.6 and 3.1.25 to 3.1.28: streams of joint positions, speeds of joints and TCP, and their stops.

use ::kinematics::JointSpeeds;
use elite_lang::{Unwind, Value};
use motion_api::{CommandKind, OnlineCommand};

use super::call::Call;
use super::declare::{
    Builtin, Category, Parameter, ParameterDefault, ParameterType, Range, phrase,
};

/// The builtins of these sections.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "servoj",
        section: "3.1.6",
        category: Category::Motion,
        summary: phrase(
            "Leads the joints along a stream of positions, one call a point.",
            "让关节跟随一串位置，每次调用给出一个点。",
        ),
        params: &[
            Parameter::new(
                "q",
                ParameterType::Joints,
                "rad",
                phrase("target joint positions", "目标关节位置"),
            ),
            Parameter::new(
                "t",
                ParameterType::Number(Range::Positive),
                "s",
                phrase(
                    "how long this point leads the arm; the call lasts as long",
                    "该点引导手臂的时长；调用持续同样长的时间",
                ),
            )
            .or(ParameterDefault::Number(0.004)),
            Parameter::new(
                "lookahead_time",
                ParameterType::Number(Range::Any),
                "s",
                phrase(
                    "length of the mean filter, 0.03 to 0.2: longer is smoother and later",
                    "均值滤波的长度，0.03 到 0.2：越长越平滑，也越滞后",
                ),
            )
            .or(ParameterDefault::Number(0.1)),
            Parameter::new(
                "gain",
                ParameterType::Number(Range::Any),
                "",
                phrase(
                    "100 to 2000: higher follows faster",
                    "100 到 2000：越大跟随越快",
                ),
            )
            .or(ParameterDefault::Number(300.0)),
        ],
        returns: phrase("nothing; returns after t", "无返回值；t 之后返回"),
        waits: true,
        run: Some(servoj),
    },
    Builtin {
        name: "speedj",
        section: "3.1.25",
        category: Category::Motion,
        summary: phrase(
            "Accelerates the joints to speeds and keeps them until the next motion command.",
            "关节加速到给定速度并保持，直到下一条运动指令。",
        ),
        params: &[
            Parameter::new(
                "qd",
                ParameterType::Numbers(6),
                "rad/s",
                phrase("joint speeds", "关节速度"),
            ),
            Parameter::new(
                "a",
                ParameterType::Number(Range::Positive),
                "rad/s^2",
                phrase(
                    "acceleration of the joint that changes most",
                    "变化最大的关节的加速度",
                ),
            ),
            DURATION,
        ],
        returns: phrase(
            "nothing; returns after t, without t when the speeds are reached",
            "无返回值；t 之后返回，不给出 t 时达到速度即返回",
        ),
        waits: true,
        run: Some(speedj),
    },
    Builtin {
        name: "stopj",
        section: "3.1.26",
        category: Category::Motion,
        summary: phrase("Brings all joints to rest.", "让所有关节停下。"),
        params: &[Parameter::new(
            "a",
            ParameterType::Number(Range::Positive),
            "rad/s^2",
            phrase("deceleration of the fastest joint", "最快关节的减速度"),
        )],
        returns: phrase(
            "nothing; returns when the arm stands",
            "无返回值；手臂停稳后返回",
        ),
        waits: true,
        run: Some(stopj),
    },
    Builtin {
        name: "speedl",
        section: "3.1.27",
        category: Category::Motion,
        summary: phrase(
            "Accelerates the TCP to a velocity and keeps it until the next motion command.",
            "TCP 加速到给定速度并保持，直到下一条运动指令。",
        ),
        params: &[
            Parameter::new(
                "xd",
                ParameterType::Numbers(6),
                "m/s, rad/s",
                phrase(
                    "TCP velocity in the base frame: linear, then angular",
                    "基坐标系下的 TCP 速度：先线速度，后角速度",
                ),
            ),
            Parameter::new(
                "a",
                ParameterType::Number(Range::Positive),
                "m/s^2",
                phrase("linear acceleration", "线加速度"),
            ),
            DURATION,
            Parameter::new(
                "aRot",
                ParameterType::Number(Range::Positive),
                "rad/s^2",
                phrase(
                    "angular acceleration; default: the number of a; counts only when t is given",
                    "角加速度；默认取 a 的数值；只在给出 t 时起作用",
                ),
            )
            .or(ParameterDefault::Symbolic("a")),
        ],
        returns: phrase(
            "nothing; returns after t, without t when the velocity is reached",
            "无返回值；t 之后返回，不给出 t 时达到速度即返回",
        ),
        waits: true,
        run: Some(speedl),
    },
    Builtin {
        name: "stopl",
        section: "3.1.28",
        category: Category::Motion,
        summary: phrase(
            "Brings the TCP to rest on its line.",
            "让 TCP 沿其直线停下。",
        ),
        params: &[Parameter::new(
            "a",
            ParameterType::Number(Range::Positive),
            "m/s^2",
            phrase("deceleration of the TCP", "TCP 的减速度"),
        )],
        returns: phrase(
            "nothing; returns when the arm stands",
            "无返回值；手臂停稳后返回",
        ),
        waits: true,
        run: Some(stopl),
    },
];

const DURATION: Parameter = Parameter::new(
    "t",
    ParameterType::Number(Range::NotNegative),
    "s",
    phrase(
        "when the call returns; without it when the speed is reached",
        "调用返回的时刻；不给出时达到速度即返回",
    ),
)
.or(ParameterDefault::Symbolic(""));

/// Shortest time a speed command is given, s: one cycle, whatever its length.
const ONE_CYCLE: f64 = 1e-6;

fn servoj(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let kind = CommandKind::Online(OnlineCommand::ServoJ {
        target: call.joints(0)?,
        duration: call.number(1)?,
        lookahead: call.clamped(2, (0.03, 0.2))?,
        gain: call.clamped(3, (100.0, 2000.0))?,
    });
    call.run_command(kind)?;
    Ok(Value::None)
}

fn duration(call: &mut Call<'_, '_>) -> Result<Option<f64>, Unwind> {
    if call.is_symbolic_default(2) {
        return Ok(None);
    }
    call.number(2).map(|t| Some(t.max(ONE_CYCLE)))
}

fn speedj(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let kind = CommandKind::Online(OnlineCommand::SpeedJ {
        speeds: JointSpeeds(call.numbers(0)?),
        acceleration: call.number(1)?,
        duration: duration(call)?,
    });
    call.run_command(kind)?;
    Ok(Value::None)
}

fn speedl(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let acceleration = call.number(1)?;
    let duration = duration(call)?;
    let rotation_acceleration = if call.is_symbolic_default(3) {
        acceleration
    } else {
        // Checked also where it does not count.
        let given = call.number(3)?;
        if duration.is_some() {
            given
        } else {
            acceleration
        }
    };
    let kind = CommandKind::Online(OnlineCommand::SpeedL {
        speed: call.numbers(0)?,
        acceleration,
        rotation_acceleration,
        duration,
    });
    call.run_command(kind)?;
    Ok(Value::None)
}

fn stopj(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let acceleration = call.number(0)?;
    call.run_command(OnlineCommand::StopJ { acceleration })?;
    Ok(Value::None)
}

fn stopl(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let acceleration = call.number(0)?;
    call.run_command(OnlineCommand::StopL { acceleration })?;
    Ok(Value::None)
}
