//! Manual 3.1.6 and 3.1.25 to 3.1.28: streams of joint positions, speeds of joints and TCP, and their stops.

use ::kinematics::JointSpeeds;
use elite_lang::{Unwind, Value};
use motion_api::{CommandKind, OnlineCommand};

use super::call::Call;
use super::declare::{Builtin, Category, Parameter, ParameterDefault, ParameterType, Range};

/// The builtins of these sections.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "servoj",
        section: "3.1.6",
        category: Category::Motion,
        summary: "Leads the joints along a stream of positions, one call a point.",
        params: &[
            Parameter::new("q", ParameterType::Joints, "rad", "target joint positions"),
            Parameter::new(
                "t",
                ParameterType::Number(Range::Positive),
                "s",
                "how long this point leads the arm; the call lasts as long",
            )
            .or(ParameterDefault::Number(0.004)),
            Parameter::new(
                "lookahead_time",
                ParameterType::Number(Range::Any),
                "s",
                "length of the mean filter, 0.03 to 0.2: longer is smoother and later",
            )
            .or(ParameterDefault::Number(0.1)),
            Parameter::new(
                "gain",
                ParameterType::Number(Range::Any),
                "",
                "100 to 2000: higher follows faster",
            )
            .or(ParameterDefault::Number(300.0)),
        ],
        returns: "nothing; returns after t",
        waits: true,
        run: Some(servoj),
    },
    Builtin {
        name: "speedj",
        section: "3.1.25",
        category: Category::Motion,
        summary: "Accelerates the joints to speeds and keeps them until the next motion command.",
        params: &[
            Parameter::new("qd", ParameterType::Numbers(6), "rad/s", "joint speeds"),
            Parameter::new(
                "a",
                ParameterType::Number(Range::Positive),
                "rad/s^2",
                "acceleration of the joint that changes most",
            ),
            DURATION,
        ],
        returns: "nothing; returns after t, without t when the speeds are reached",
        waits: true,
        run: Some(speedj),
    },
    Builtin {
        name: "stopj",
        section: "3.1.26",
        category: Category::Motion,
        summary: "Brings all joints to rest.",
        params: &[Parameter::new(
            "a",
            ParameterType::Number(Range::Positive),
            "rad/s^2",
            "deceleration of the fastest joint",
        )],
        returns: "nothing; returns when the arm stands",
        waits: true,
        run: Some(stopj),
    },
    Builtin {
        name: "speedl",
        section: "3.1.27",
        category: Category::Motion,
        summary: "Accelerates the TCP to a velocity and keeps it until the next motion command.",
        params: &[
            Parameter::new(
                "xd",
                ParameterType::Numbers(6),
                "m/s, rad/s",
                "TCP velocity in the base frame: linear, then angular",
            ),
            Parameter::new(
                "a",
                ParameterType::Number(Range::Positive),
                "m/s^2",
                "linear acceleration",
            ),
            DURATION,
            Parameter::new(
                "aRot",
                ParameterType::Number(Range::Positive),
                "rad/s^2",
                "angular acceleration; default: the number of a; counts only when t is given",
            )
            .or(ParameterDefault::Symbolic("a")),
        ],
        returns: "nothing; returns after t, without t when the velocity is reached",
        waits: true,
        run: Some(speedl),
    },
    Builtin {
        name: "stopl",
        section: "3.1.28",
        category: Category::Motion,
        summary: "Brings the TCP to rest on its line.",
        params: &[Parameter::new(
            "a",
            ParameterType::Number(Range::Positive),
            "m/s^2",
            "deceleration of the TCP",
        )],
        returns: "nothing; returns when the arm stands",
        waits: true,
        run: Some(stopl),
    },
];

const DURATION: Parameter = Parameter::new(
    "t",
    ParameterType::Number(Range::NotNegative),
    "s",
    "when the call returns; without it when the speed is reached",
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
