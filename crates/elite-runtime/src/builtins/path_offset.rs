//! Process moves and offsets of the path, as programs of the vendor's pendant use them; the manual does not describe
//! them.

use elite_lang::{ExceptionKind, Unwind, Value};
use messages::text;
use motion_api::{CommandKind, MotionCommand, OffsetAxes, OverlayCommand};

use super::call::Call;
use super::declare::{
    Builtin, Category, FROM_OUTPUT, Parameter, ParameterDefault, ParameterType, Range, phrase,
};

/// The builtins of this kind.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "movep",
        section: FROM_OUTPUT,
        category: Category::Motion,
        summary: phrase(
            "Moves the TCP along a straight line, and through blends at the same speed.",
            "TCP 沿直线运动，并以相同速度通过过渡段。",
        ),
        params: &[
            Parameter::new(
                "pose",
                ParameterType::Pose,
                "m, rad",
                phrase(
                    "target TCP pose in the base frame",
                    "基坐标系下的目标 TCP 位姿",
                ),
            ),
            Parameter::new(
                "a",
                ParameterType::Number(Range::Positive),
                "m/s^2",
                phrase("TCP acceleration", "TCP 加速度"),
            )
            .or(ParameterDefault::Number(1.2)),
            Parameter::new(
                "v",
                ParameterType::Number(Range::Positive),
                "m/s",
                phrase("TCP speed", "TCP 速度"),
            )
            .or(ParameterDefault::Number(0.25)),
            Parameter::new(
                "r",
                ParameterType::Number(Range::NotNegative),
                "m",
                phrase(
                    "the blend is the arc that touches both lines at this distance from the \
                     target; 0 stops there",
                    "交融段是在距目标点该距离处与两条直线相切的圆弧；0 表示在目标点停下",
                ),
            )
            .or(ParameterDefault::Number(0.0)),
        ],
        returns: phrase(
            "nothing; returns when the target is reached or, with r > 0, its blend zone is entered",
            "无返回值；到达目标点时返回，r > 0 时进入交融区即返回",
        ),
        waits: true,
        run: Some(movep),
    },
    Builtin {
        name: "path_offset_enable",
        section: FROM_OUTPUT,
        category: Category::Motion,
        summary: phrase(
            "Offsets of the path count from now on, one set before as well.",
            "从现在起路径偏移生效，包括之前设置的偏移。",
        ),
        params: &[],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(path_offset_enable),
    },
    Builtin {
        name: "path_offset_disable",
        section: FROM_OUTPUT,
        category: Category::Motion,
        summary: phrase(
            "Ends offsets of the path: the joints brake, the next motion starts where the arm \
             stands.",
            "结束路径偏移：关节制动，下一运动从手臂停处开始。",
        ),
        params: &[Parameter::new(
            "a",
            ParameterType::Number(Range::Positive),
            "rad/s^2",
            phrase("deceleration of the fastest joint", "最快关节的减速度"),
        )
        .or(ParameterDefault::Number(20.0))],
        returns: phrase(
            "nothing; returns when the arm stands",
            "无返回值；手臂停稳后返回",
        ),
        waits: true,
        run: Some(path_offset_disable),
    },
    Builtin {
        name: "path_offset_set",
        section: FROM_OUTPUT,
        category: Category::Motion,
        summary: phrase(
            "Lays an offset over the TCP's path; it is moved to within the limits of the arm.",
            "在 TCP 路径上叠加偏移；在手臂限制内逐渐移到该偏移。",
        ),
        params: &[
            Parameter::new(
                "offset",
                ParameterType::Pose,
                "m, rad",
                phrase(
                    "translation and rotation from the path",
                    "相对路径的平移和旋转",
                ),
            ),
            AXES,
        ],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(path_offset_set),
    },
    Builtin {
        name: "path_offset_get",
        section: FROM_OUTPUT,
        category: Category::Motion,
        summary: phrase("The offset that is in force.", "当前生效的偏移。"),
        params: &[AXES],
        returns: phrase("list[6] float, m and rad", "list[6] float，m 和 rad"),
        waits: false,
        run: Some(path_offset_get),
    },
    Builtin {
        name: "path_offset_set_alpha_filter",
        section: FROM_OUTPUT,
        category: Category::Motion,
        summary: phrase("Sets the filter of new offsets.", "设置新偏移的滤波。"),
        params: &[Parameter::new(
            "alpha",
            ParameterType::Number(Range::Between(0.0, 1.0)),
            "",
            phrase(
                "share of a new offset that is taken over in each cycle; 1, as at the start of a \
                 program, does not filter",
                "每个周期接受新偏移的比例；1（程序开始时的值）表示不滤波",
            ),
        )],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(path_offset_set_alpha_filter),
    },
    Builtin {
        name: "path_offset_set_max_offset",
        section: FROM_OUTPUT,
        category: Category::Motion,
        summary: phrase(
            "Sets how large offsets may be; beyond that is a protective stop.",
            "设置偏移的上限；超出时保护性停止。",
        ),
        params: &[
            Parameter::new(
                "translation",
                ParameterType::Number(Range::NotNegative),
                "m",
                phrase(
                    "largest translation, 0.1 at the start of a program",
                    "最大平移，程序开始时为 0.1",
                ),
            ),
            Parameter::new(
                "rotation",
                ParameterType::Number(Range::NotNegative),
                "rad",
                phrase(
                    "largest rotation, 0.5 at the start of a program",
                    "最大旋转，程序开始时为 0.5",
                ),
            ),
        ],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(path_offset_set_max_offset),
    },
    Builtin {
        name: "get_target_tcp_pose_along_path",
        section: FROM_OUTPUT,
        category: Category::Motion,
        summary: phrase(
            "The TCP pose that the planned path asks for now, without offsets.",
            "规划路径当前要求的 TCP 位姿，不含偏移。",
        ),
        params: &[],
        returns: phrase("list[6] float, m and rad", "list[6] float，m 和 rad"),
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
    phrase(
        "axes of the offset: 1 base, 2 TCP, 3 motion (X along the path, Y = X × the tool's Z, Z \
         = X × Y)",
        "偏移所用的轴：1 基座，2 TCP，3 运动（X 沿路径，Y = X × 工具的 Z，Z = X × Y）",
    ),
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
        let text = text!(
            "path_offset_set(): offset must have components of at most {FARTHEST}, got {far}",
            "path_offset_set()：offset 的分量不能超过 {FARTHEST}，给出的是 {far}"
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
