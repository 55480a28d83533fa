//! Manual 3.1: moves, getters of the arm's state, TCP and payload.

#![allow(
    clippy::approx_constant,
    reason = "the manual's default speed is printed as 1.047197"
)]

use ::kinematics::Payload;
use elite_lang::{ExceptionKind, Unwind, Value};
use messages::text;
use motion_api::{CommandKind, MotionCommand, SettingCommand};

use super::call::Call;
use super::declare::{
    Builtin, Category, Parameter, ParameterDefault, ParameterType, Phrase, Range, phrase,
};

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "movej",
        section: "3.1.1",
        category: Category::Motion,
        summary: phrase(
            "Moves along a straight line in joint space; all joints start and end together.",
            "沿关节空间的直线运动；所有关节同时开始、同时结束。",
        ),
        params: &[
            Parameter {
                name: "q",
                aliases: &[],
                kind: ParameterType::Joints,
                default: ParameterDefault::Required,
                unit: "rad",
                meaning: phrase(
                    "target joint positions [Base, Shoulder, Elbow, Wrist1, Wrist2, Wrist3]",
                    "目标关节位置 [基座, 肩部, 肘部, 手腕 1, 手腕 2, 手腕 3]",
                ),
            },
            acceleration(
                "rad/s^2",
                1.396263,
                phrase("acceleration of the leading joint", "主导关节的加速度"),
            ),
            speed(
                "rad/s",
                1.047197,
                phrase("speed of the leading joint", "主导关节的速度"),
            ),
            DURATION,
            BLEND_RADIUS,
        ],
        returns: RETURNS,
        waits: true,
        run: Some(movej),
    },
    Builtin {
        name: "movec",
        section: "3.1.2",
        category: Category::Motion,
        summary: phrase(
            "Moves the TCP along a circular arc through a pose in between.",
            "TCP 经过中间位姿沿圆弧运动。",
        ),
        params: &[
            Parameter::new(
                "pose_via",
                ParameterType::Pose,
                "m, rad",
                phrase(
                    "TCP pose on the arc; only its position counts",
                    "圆弧上的 TCP 位姿；只有位置起作用",
                ),
            ),
            Parameter::new(
                "pose_to",
                ParameterType::Pose,
                "m, rad",
                phrase(
                    "target TCP pose in the base frame",
                    "基坐标系下的目标 TCP 位姿",
                ),
            ),
            acceleration("m/s^2", 1.2, phrase("TCP acceleration", "TCP 加速度")),
            speed("m/s", 0.25, phrase("TCP speed", "TCP 速度")),
            BLEND_RADIUS,
            Parameter {
                name: "mode",
                aliases: &[],
                kind: ParameterType::Integer(i64::MIN, i64::MAX),
                default: ParameterDefault::Integer(0),
                unit: "",
                meaning: phrase(
                    "0: the tool keeps its orientation to the arc; otherwise it turns evenly to \
                     that of the target",
                    "0：工具相对圆弧的姿态不变；其他值：均匀转到目标姿态",
                ),
            },
        ],
        returns: RETURNS,
        waits: true,
        run: Some(movec),
    },
    Builtin {
        name: "movel",
        section: "3.1.3",
        category: Category::Motion,
        summary: phrase(
            "Moves the TCP along a straight line, turning about one fixed axis.",
            "TCP 沿直线运动，姿态绕一根固定轴转动。",
        ),
        params: &[
            Parameter {
                name: "pose",
                aliases: &["p"],
                kind: ParameterType::Pose,
                default: ParameterDefault::Required,
                unit: "m, rad",
                meaning: phrase(
                    "target TCP pose in the base frame",
                    "基坐标系下的目标 TCP 位姿",
                ),
            },
            acceleration("m/s^2", 1.2, phrase("TCP acceleration", "TCP 加速度")),
            speed("m/s", 0.25, phrase("TCP speed", "TCP 速度")),
            DURATION,
            BLEND_RADIUS,
        ],
        returns: RETURNS,
        waits: true,
        run: Some(movel),
    },
    getter(
        "get_actual_joint_positions",
        "3.1.4",
        phrase("Measured joint positions.", "实际关节位置。"),
        phrase("list[6] float, rad", "list[6] float，rad"),
        |call| {
            Ok(Value::list_of_f64(
                &call.context().robot().state().actual_q.0,
            ))
        },
    ),
    getter(
        "get_actual_tcp_pose",
        "3.1.7",
        phrase(
            "Measured TCP pose in the base frame.",
            "基坐标系下的实际 TCP 位姿。",
        ),
        phrase("list[6] float, m and rad", "list[6] float，m 和 rad"),
        |call| Ok(Value::list_of_f64(&call.state().actual_tcp_pose.to_array())),
    ),
    getter(
        "get_target_joint_positions",
        "3.1.12",
        phrase("Commanded joint positions.", "目标关节位置。"),
        phrase("list[6] float, rad", "list[6] float，rad"),
        |call| {
            Ok(Value::list_of_f64(
                &call.context().robot().state().target_q.0,
            ))
        },
    ),
    Builtin {
        name: "set_payload",
        section: "3.1.17",
        category: Category::Motion,
        summary: phrase("Says what hangs on the flange.", "设置法兰上的负载。"),
        params: &[
            Parameter {
                name: "m",
                aliases: &[],
                kind: ParameterType::Number(Range::NotNegative),
                default: ParameterDefault::Required,
                unit: "kg",
                meaning: phrase(
                    "mass, at most the rated payload of the model",
                    "质量，不超过该型号的额定负载",
                ),
            },
            Parameter {
                name: "CoG",
                aliases: &["cog"],
                kind: ParameterType::Numbers(3),
                default: ParameterDefault::Required,
                unit: "m",
                meaning: phrase(
                    "centre of gravity in the flange frame",
                    "法兰坐标系下的重心",
                ),
            },
            Parameter {
                name: "inertia",
                aliases: &[],
                kind: ParameterType::Numbers(6),
                default: ParameterDefault::Zeros,
                unit: "kg m^2",
                meaning: phrase(
                    "[Ixx, Iyy, Izz, Ixy, Ixz, Iyz] about the centre of gravity",
                    "关于重心的 [Ixx, Iyy, Izz, Ixy, Ixz, Iyz]",
                ),
            },
        ],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(set_payload),
    },
    Builtin {
        name: "set_tcp",
        section: "3.1.20",
        category: Category::Motion,
        summary: phrase(
            "Sets the TCP relative to the tool flange.",
            "设置 TCP 相对于工具法兰的位姿。",
        ),
        params: &[Parameter {
            name: "pose",
            aliases: &[],
            kind: ParameterType::Pose,
            default: ParameterDefault::Required,
            unit: "m, rad",
            meaning: phrase("TCP in the flange frame", "法兰坐标系下的 TCP"),
        }],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(set_tcp),
    },
];

const fn acceleration(unit: &'static str, default: f64, meaning: Phrase) -> Parameter {
    Parameter {
        name: "a",
        aliases: &[],
        kind: ParameterType::Number(Range::Positive),
        default: ParameterDefault::Number(default),
        unit,
        meaning,
    }
}

const fn speed(unit: &'static str, default: f64, meaning: Phrase) -> Parameter {
    Parameter {
        name: "v",
        aliases: &[],
        kind: ParameterType::Number(Range::Positive),
        default: ParameterDefault::Number(default),
        unit,
        meaning,
    }
}

const DURATION: Parameter = Parameter {
    name: "t",
    aliases: &[],
    kind: ParameterType::Number(Range::NotNegative),
    default: ParameterDefault::Number(0.0),
    unit: "s",
    meaning: phrase(
        "duration; 0 plans from a and v, otherwise a and v are ignored",
        "运动时间；0 表示按 a 和 v 规划，否则忽略 a 和 v",
    ),
};

const BLEND_RADIUS: Parameter = Parameter {
    name: "r",
    aliases: &[],
    kind: ParameterType::Number(Range::NotNegative),
    default: ParameterDefault::Number(0.0),
    unit: "m",
    meaning: phrase(
        "blend radius; 0 stops at the target",
        "交融半径；0 表示在目标点停下",
    ),
};

const RETURNS: Phrase = phrase(
    "nothing; returns when the target is reached or, with r > 0, its blend zone is entered",
    "无返回值；到达目标点时返回，r > 0 时进入交融区即返回",
);

const fn getter(
    name: &'static str,
    section: &'static str,
    summary: Phrase,
    returns: Phrase,
    run: fn(&mut Call<'_, '_>) -> Result<Value, Unwind>,
) -> Builtin {
    Builtin {
        name,
        section,
        category: Category::Motion,
        summary,
        params: &[],
        returns,
        waits: false,
        run: Some(run),
    }
}

fn movej(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let kind = CommandKind::Motion(MotionCommand::MoveJ {
        target: call.joints(0)?,
        acceleration: call.number(1)?,
        speed: call.number(2)?,
        duration: call.number(3)?,
        radius: call.number(4)?,
    });
    call.run_command(kind)?;
    Ok(Value::None)
}

fn movel(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let kind = CommandKind::Motion(MotionCommand::MoveL {
        target: call.pose(0)?,
        acceleration: call.number(1)?,
        speed: call.number(2)?,
        duration: call.number(3)?,
        radius: call.number(4)?,
    });
    call.run_command(kind)?;
    Ok(Value::None)
}

fn movec(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let kind = CommandKind::Motion(MotionCommand::MoveC {
        via: call.pose(0)?,
        target: call.pose(1)?,
        acceleration: call.number(2)?,
        speed: call.number(3)?,
        radius: call.number(4)?,
        fixed: call.integer(5)? == 0,
    });
    call.run_command(kind)?;
    Ok(Value::None)
}

fn set_tcp(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let pose = call.pose(0)?;
    call.set(SettingCommand::SetTcp(pose))?;
    Ok(Value::None)
}

fn set_payload(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let mass = call.number(0)?;
    let model = call.context().robot().model();
    if let Some(rated) = model.rated_payload_kg()
        && mass > rated
    {
        let text = text!(
            "set_payload(): m must be 0 to {rated} kg on {}, got {mass}",
            "set_payload()：{} 上 m 必须为 0 到 {rated} kg，给出的是 {mass}",
            model.name()
        );
        return Err(call.error(ExceptionKind::ValueError, text));
    }
    let (cog, inertia) = (call.numbers(1)?, call.numbers(2)?);
    match Payload::new(mass, cog, inertia) {
        Ok(payload) => call.set(SettingCommand::SetPayload(payload))?,
        Err(error) => {
            return Err(call.error(
                ExceptionKind::ValueError,
                text!("set_payload(): {error}", "set_payload()：{error}"),
            ));
        }
    }
    Ok(Value::None)
}
