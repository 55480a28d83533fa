//! Manual 3.1: moves, getters of the arm's state, TCP and payload.

#![allow(
    clippy::approx_constant,
    reason = "the manual's default speed is printed as 1.047197"
)]

use ::kinematics::Payload;
use elite_lang::{ExceptionKind, Unwind, Value};
use motion_api::{CommandKind, MotionCommand, SettingCommand};

use super::call::Call;
use super::declare::{Builtin, Category, Parameter, ParameterDefault, ParameterType, Range};

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "movej",
        section: "3.1.1",
        category: Category::Motion,
        summary: "Moves along a straight line in joint space; all joints start and end together.",
        params: &[
            Parameter {
                name: "q",
                aliases: &[],
                kind: ParameterType::Joints,
                default: ParameterDefault::Required,
                unit: "rad",
                meaning: "target joint positions [Base, Shoulder, Elbow, Wrist1, Wrist2, Wrist3]",
            },
            acceleration("rad/s^2", 1.396263, "acceleration of the leading joint"),
            speed("rad/s", 1.047197, "speed of the leading joint"),
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
        summary: "Moves the TCP along a circular arc through a pose in between.",
        params: &[
            Parameter::new(
                "pose_via",
                ParameterType::Pose,
                "m, rad",
                "TCP pose on the arc; only its position counts",
            ),
            Parameter::new(
                "pose_to",
                ParameterType::Pose,
                "m, rad",
                "target TCP pose in the base frame",
            ),
            acceleration("m/s^2", 1.2, "TCP acceleration"),
            speed("m/s", 0.25, "TCP speed"),
            BLEND_RADIUS,
            Parameter {
                name: "mode",
                aliases: &[],
                kind: ParameterType::Integer(i64::MIN, i64::MAX),
                default: ParameterDefault::Integer(0),
                unit: "",
                meaning: "0: the tool keeps its orientation to the arc; otherwise it turns evenly to that \
                          of the target",
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
        summary: "Moves the TCP along a straight line, turning about one fixed axis.",
        params: &[
            Parameter {
                name: "pose",
                aliases: &["p"],
                kind: ParameterType::Pose,
                default: ParameterDefault::Required,
                unit: "m, rad",
                meaning: "target TCP pose in the base frame",
            },
            acceleration("m/s^2", 1.2, "TCP acceleration"),
            speed("m/s", 0.25, "TCP speed"),
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
        "Measured joint positions.",
        "list[6] float, rad",
        |call| {
            Ok(Value::list_of_f64(
                &call.context().robot().state().actual_q.0,
            ))
        },
    ),
    getter(
        "get_actual_tcp_pose",
        "3.1.7",
        "Measured TCP pose in the base frame.",
        "list[6] float, m and rad",
        |call| Ok(Value::list_of_f64(&call.state().actual_tcp_pose.to_array())),
    ),
    getter(
        "get_target_joint_positions",
        "3.1.12",
        "Commanded joint positions.",
        "list[6] float, rad",
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
        summary: "Says what hangs on the flange.",
        params: &[
            Parameter {
                name: "m",
                aliases: &[],
                kind: ParameterType::Number(Range::NotNegative),
                default: ParameterDefault::Required,
                unit: "kg",
                meaning: "mass, at most the rated payload of the model",
            },
            Parameter {
                name: "CoG",
                aliases: &["cog"],
                kind: ParameterType::Numbers(3),
                default: ParameterDefault::Required,
                unit: "m",
                meaning: "centre of gravity in the flange frame",
            },
            Parameter {
                name: "inertia",
                aliases: &[],
                kind: ParameterType::Numbers(6),
                default: ParameterDefault::Zeros,
                unit: "kg m^2",
                meaning: "[Ixx, Iyy, Izz, Ixy, Ixz, Iyz] about the centre of gravity",
            },
        ],
        returns: "nothing",
        waits: false,
        run: Some(set_payload),
    },
    Builtin {
        name: "set_tcp",
        section: "3.1.20",
        category: Category::Motion,
        summary: "Sets the TCP relative to the tool flange.",
        params: &[Parameter {
            name: "pose",
            aliases: &[],
            kind: ParameterType::Pose,
            default: ParameterDefault::Required,
            unit: "m, rad",
            meaning: "TCP in the flange frame",
        }],
        returns: "nothing",
        waits: false,
        run: Some(set_tcp),
    },
];

const fn acceleration(unit: &'static str, default: f64, meaning: &'static str) -> Parameter {
    Parameter {
        name: "a",
        aliases: &[],
        kind: ParameterType::Number(Range::Positive),
        default: ParameterDefault::Number(default),
        unit,
        meaning,
    }
}

const fn speed(unit: &'static str, default: f64, meaning: &'static str) -> Parameter {
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
    meaning: "duration; 0 plans from a and v, otherwise a and v are ignored",
};

const BLEND_RADIUS: Parameter = Parameter {
    name: "r",
    aliases: &[],
    kind: ParameterType::Number(Range::NotNegative),
    default: ParameterDefault::Number(0.0),
    unit: "m",
    meaning: "blend radius; 0 stops at the target",
};

const RETURNS: &str =
    "nothing; returns when the target is reached or, with r > 0, its blend zone is entered";

const fn getter(
    name: &'static str,
    section: &'static str,
    summary: &'static str,
    returns: &'static str,
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
        let text = format!(
            "set_payload(): m must be 0 to {rated} kg on {}, got {mass}",
            model.name()
        );
        return Err(call.error(ExceptionKind::ValueError, text));
    }
    let (cog, inertia) = (call.numbers(1)?, call.numbers(2)?);
    match Payload::new(mass, cog, inertia) {
        Ok(payload) => call.set(SettingCommand::SetPayload(payload))?,
        Err(error) => {
            return Err(call.error(ExceptionKind::ValueError, format!("set_payload(): {error}")));
        }
    }
    Ok(Value::None)
}
