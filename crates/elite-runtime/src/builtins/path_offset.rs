//! Process moves and offsets of the path, as programs of the vendor's pendant use them; the manual does not describe
//! them.

use elite_lang::{ExceptionKind, Unwind, Value};
use motion_api::{CommandKind, MotionCommand, OffsetAxes, OverlayCommand};

use super::call::Call;
use super::declare::{
    Builtin, Category, FROM_OUTPUT, Parameter, ParameterDefault, ParameterType, Range,
};

/// The builtins of this kind.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "movep",
        section: FROM_OUTPUT,
        category: Category::Motion,
        summary: "Moves the TCP along a straight line, and through blends at the same speed.",
        params: &[
            Parameter::new(
                "pose",
                ParameterType::Pose,
                "m, rad",
                "target TCP pose in the base frame",
            ),
            Parameter::new(
                "a",
                ParameterType::Number(Range::Positive),
                "m/s^2",
                "TCP acceleration",
            )
            .or(ParameterDefault::Number(1.2)),
            Parameter::new("v", ParameterType::Number(Range::Positive), "m/s", "TCP speed")
                .or(ParameterDefault::Number(0.25)),
            Parameter::new(
                "r",
                ParameterType::Number(Range::NotNegative),
                "m",
                "the blend is the arc that touches both lines at this distance from the target; 0 stops there",
            )
            .or(ParameterDefault::Number(0.0)),
        ],
        returns: "nothing; returns when the target is reached or, with r > 0, its blend zone is entered",
        waits: true,
        run: Some(movep),
    },
    Builtin {
        name: "path_offset_enable",
        section: FROM_OUTPUT,
        category: Category::Motion,
        summary: "Offsets of the path count from now on, one set before as well.",
        params: &[],
        returns: "nothing",
        waits: false,
        run: Some(path_offset_enable),
    },
    Builtin {
        name: "path_offset_disable",
        section: FROM_OUTPUT,
        category: Category::Motion,
        summary: "Ends offsets of the path: the joints brake, the next motion starts where the arm stands.",
        params: &[Parameter::new(
            "a",
            ParameterType::Number(Range::Positive),
            "rad/s^2",
            "deceleration of the fastest joint",
        )
        .or(ParameterDefault::Number(20.0))],
        returns: "nothing; returns when the arm stands",
        waits: true,
        run: Some(path_offset_disable),
    },
    Builtin {
        name: "path_offset_set",
        section: FROM_OUTPUT,
        category: Category::Motion,
        summary: "Lays an offset over the TCP's path; it is moved to within the limits of the arm.",
        params: &[
            Parameter::new(
                "offset",
                ParameterType::Pose,
                "m, rad",
                "translation and rotation from the path",
            ),
            AXES,
        ],
        returns: "nothing",
        waits: false,
        run: Some(path_offset_set),
    },
    Builtin {
        name: "path_offset_get",
        section: FROM_OUTPUT,
        category: Category::Motion,
        summary: "The offset that is in force.",
        params: &[AXES],
        returns: "list[6] float, m and rad",
        waits: false,
        run: Some(path_offset_get),
    },
    Builtin {
        name: "path_offset_set_alpha_filter",
        section: FROM_OUTPUT,
        category: Category::Motion,
        summary: "Sets the filter of new offsets.",
        params: &[Parameter::new(
            "alpha",
            ParameterType::Number(Range::Between(0.0, 1.0)),
            "",
            "share of a new offset that is taken over in each cycle; 1, as at the start of a program, does not filter",
        )],
        returns: "nothing",
        waits: false,
        run: Some(path_offset_set_alpha_filter),
    },
    Builtin {
        name: "path_offset_set_max_offset",
        section: FROM_OUTPUT,
        category: Category::Motion,
        summary: "Sets how large offsets may be; beyond that is a protective stop.",
        params: &[
            Parameter::new(
                "translation",
                ParameterType::Number(Range::NotNegative),
                "m",
                "largest translation, 0.1 at the start of a program",
            ),
            Parameter::new(
                "rotation",
                ParameterType::Number(Range::NotNegative),
                "rad",
                "largest rotation, 0.5 at the start of a program",
            ),
        ],
        returns: "nothing",
        waits: false,
        run: Some(path_offset_set_max_offset),
    },
    Builtin {
        name: "get_target_tcp_pose_along_path",
        section: FROM_OUTPUT,
        category: Category::Motion,
        summary: "The TCP pose that the planned path asks for now, without offsets.",
        params: &[],
        returns: "list[6] float, m and rad",
        waits: false,
        run: Some(|call| {
            let pose = call.context().robot().state().path_pose;
            Ok(Value::list_of_f64(&pose.to_array()))
        }),
    },
];

const AXES: Parameter = Parameter::new(
    "type",
    ParameterType::OneOf(&[1, 2, 3]),
    "",
    "axes of the offset: 1 base, 2 TCP, 3 motion (X along the path, Y = X × the tool's Z, Z = X × Y)",
);

fn movep(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let kind = CommandKind::Motion(MotionCommand::MoveP {
        target: call.pose(0)?,
        acceleration: call.number(1)?,
        speed: call.number(2)?,
        radius: call.number(3)?,
    });
    call.run_command(kind)?;
    Ok(Value::None)
}

fn path_offset_enable(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    call.set(OverlayCommand::PathOffsetEnable)?;
    Ok(Value::None)
}

fn path_offset_disable(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let acceleration = call.number(0)?;
    call.run_command(OverlayCommand::PathOffsetDisable { acceleration })?;
    Ok(Value::None)
}

fn axes(call: &mut Call<'_, '_>, index: usize) -> Result<OffsetAxes, Unwind> {
    // Declared as 1, 2 or 3.
    Ok(OffsetAxes::from_number(call.integer(index)? as u64).unwrap_or_default())
}

fn path_offset_set(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let offset = call.pose(0)?;
    let axes = axes(call, 1)?;
    if let Some(far) = offset.to_array().into_iter().find(|x| x.abs() > FARTHEST) {
        let text = format!(
            "path_offset_set(): offset must have components of at most {FARTHEST}, got {far}"
        );
        return Err(call.error(ExceptionKind::ValueError, text));
    }
    call.send(OverlayCommand::PathOffsetSet { offset, axes })?;
    Ok(Value::None)
}

/// Offsets beyond are a mistake of units, m and rad.
const FARTHEST: f64 = 10.0;

fn path_offset_get(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let axes = axes(call, 0)?;
    let offsets = call.context().robot().state().path_offsets;
    Ok(Value::list_of_f64(&offsets[axes as usize]))
}

fn path_offset_set_alpha_filter(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let share = call.number(0)?;
    call.send(OverlayCommand::PathOffsetFilter(share))?;
    Ok(Value::None)
}

fn path_offset_set_max_offset(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let kind = CommandKind::Overlay(OverlayCommand::PathOffsetMax {
        translation: call.number(0)?,
        rotation: call.number(1)?,
    });
    call.send(kind)?;
    Ok(Value::None)
}
