//! Manual 3.1.37 to 3.1.40: files of points, and the motion through them. The text format is in `micro_line`.

#![allow(
    clippy::approx_constant,
    reason = "the default speed of movej as the manual prints it"
)]

use std::sync::Arc;

use elite_lang::{ExceptionKind, Unwind, Value};
use kinematics::{JointPositions, Pose, RobotModel};
use messages::text;
use motion_api::{MotionCommand, PointList};

use super::call::Call;
use super::declare::{
    Builtin, Category, Parameter, ParameterDefault, ParameterType, Phrase, phrase,
};
use crate::external::call_external;
use crate::micro_line::{MicroLine, MicroLineError, Space, Units};

/// An arm this near to the first point, rad, stands at it.
const AT_FIRST_POINT: f64 = 1e-6;
/// Acceleration and speed of the way to the first point: a movej's defaults, rad/s² and rad/s.
const APPROACH: (f64, f64) = (1.396263, 1.047197);

/// Longest time between two points, ms.
const INTERVAL_MAX: i64 = 60_000;

/// Most bytes of a file in one recorded answer: with its line ends marked, a piece stays below the bound of an answer
/// ([`ANSWER_BYTES_MAX`](crate::external::ANSWER_BYTES_MAX)).
const PIECE_BYTES: usize = 24 * 1024;

/// The builtins of these sections.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "load_micro_line_file",
        section: "3.1.37",
        category: Category::Motion,
        summary: phrase(
            "Loads a file of points out of the task folder.",
            "从任务目录加载点位文件。",
        ),
        params: &[
            Parameter::new(
                "file_name",
                ParameterType::Text,
                "",
                phrase(
                    "name in the task folder, with or without .txt or .csv; six numbers a line",
                    "任务文件夹中的文件名，可省略 .txt 或 .csv；每行六个数",
                ),
            ),
            Parameter::new(
                "interval_time",
                ParameterType::Integer(1, INTERVAL_MAX),
                "ms",
                phrase("time from point to point", "相邻两点之间的时间"),
            ),
            Parameter {
                name: "pos_type",
                aliases: &[],
                kind: ParameterType::OneOf(&[0, 1]),
                default: ParameterDefault::Integer(0),
                unit: "",
                meaning: phrase(
                    "0: joint positions; 1: TCP poses",
                    "0：关节位置；1：TCP 位姿",
                ),
            },
            Parameter {
                name: "unit_type",
                aliases: &[],
                kind: ParameterType::OneOf(&[0, 1]),
                default: ParameterDefault::Integer(0),
                unit: "",
                meaning: phrase(
                    "0: rad, or m and rad; 1: degrees, or mm and rad",
                    "0：rad，或 m 和 rad；1：度，或 mm 和 rad",
                ),
            },
        ],
        returns: phrase(
            "int, index of the loaded file; the same content and settings keep their index",
            "int，已加载文件的编号；内容和设置相同则编号不变",
        ),
        waits: false,
        run: Some(load_micro_line_file),
    },
    Builtin {
        name: "micro_line_set_pcs",
        section: "3.1.38",
        category: Category::Motion,
        summary: phrase(
            "Sets the frame in which the poses of a loaded file are given.",
            "设置已加载文件中各位姿所在的坐标系。",
        ),
        params: &[
            INDEX,
            Parameter::new(
                "part_coordinate_system",
                ParameterType::Pose,
                "m, rad",
                phrase(
                    "the part's frame in the base frame",
                    "工件坐标系在基坐标系下的位姿",
                ),
            ),
        ],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(micro_line_set_pcs),
    },
    Builtin {
        name: "get_micro_line_values_by_index",
        section: "3.1.39",
        category: Category::Motion,
        summary: phrase(
            "One point of a loaded file, as joint positions or as a TCP pose in the part's frame.",
            "已加载文件中的一个点，以关节位置或工件坐标系下的 TCP 位姿表示。",
        ),
        params: &[
            INDEX,
            Parameter::new(
                "pos_type",
                ParameterType::OneOf(&[0, 1]),
                "",
                phrase(
                    "0: joint positions; 1: TCP pose",
                    "0：关节位置；1：TCP 位姿",
                ),
            ),
            Parameter::new(
                "line_index",
                ParameterType::Integer(i64::MIN, i64::MAX),
                "",
                phrase("number of the point, from 1", "点的序号，从 1 开始"),
            ),
        ],
        returns: phrase(
            "list[6] float, rad, or m and rad",
            "list[6] float，rad，或 m 和 rad",
        ),
        waits: false,
        run: Some(get_micro_line_values_by_index),
    },
    Builtin {
        name: "moveml",
        section: "3.1.40",
        category: Category::Motion,
        summary: phrase(
            "Moves through the points of a loaded file at its times, slower where the joints \
             cannot keep up.",
            "按文件给出的时间经过各点，关节跟不上处放慢。",
        ),
        params: &[
            INDEX,
            line(
                "start_line",
                phrase(
                    "number of the first point; 0 is the first of the file",
                    "起始点的序号；0 为文件的第一点",
                ),
            ),
            line(
                "end_line",
                phrase(
                    "number of the last point; 0 is the last of the file",
                    "结束点的序号；0 为文件的最后一点",
                ),
            ),
        ],
        returns: phrase(
            "nothing; returns when the last point is reached",
            "无返回值；到达最后一点时返回",
        ),
        waits: true,
        run: Some(moveml),
    },
];

/// One end of the part of a file that is run.
const fn line(name: &'static str, meaning: Phrase) -> Parameter {
    Parameter {
        name,
        aliases: &[],
        kind: ParameterType::Integer(0, i64::MAX),
        default: ParameterDefault::Integer(0),
        unit: "",
        meaning,
    }
}

const INDEX: Parameter = Parameter::new(
    "micro_line_index",
    ParameterType::Integer(i64::MIN, i64::MAX),
    "",
    phrase(
        "index from load_micro_line_file",
        "load_micro_line_file 返回的编号",
    ),
);

fn space(number: i64) -> Space {
    if number == 1 {
        Space::Cartesian
    } else {
        Space::Joint
    }
}

fn load_micro_line_file(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let name = call.text(0)?;
    let interval = call.integer(1)? as f64 / 1000.0;
    let space = space(call.integer(2)?);
    let units = if call.integer(3)? == 1 {
        Units::DegreesOrMillimetres
    } else {
        Units::Si
    };
    let text = text_of(call, &name)?;
    let line = MicroLine::parse(&text, space, units, interval)
        .map_err(|error| in_file(call, &name, &error))?;
    let added = call.context().micro_lines().borrow_mut().add(line);
    match added {
        Ok(index) => Ok(Value::Int(index as i64)),
        Err(error) => Err(in_file(call, &name, &error)),
    }
}

/// The text of a file, in pieces that are noted one by one: where a run is repeated, the recording has it.
fn text_of(call: &mut Call<'_, '_>, name: &str) -> Result<String, Unwind> {
    let (context, mut file) = (call.shared_context(), None);
    let mut text = String::new();
    loop {
        let key = [Value::str(name), Value::Int(text.len() as i64)];
        let function = call.name();
        let piece = call_external(&context, call.native(), function, &key, |native| {
            let whole = match file.take() {
                Some(whole) => whole,
                None => context.task_folder().points(name).map_err(|error| {
                    native.raise(
                        ExceptionKind::ValueError,
                        text!("{function}(): {error}", "{function}()：{error}"),
                    )
                })?,
            };
            let rest = whole.get(text.len()..).unwrap_or_default();
            let piece = Value::str(&rest[..rest.floor_char_boundary(PIECE_BYTES)]);
            file = Some(whole);
            Ok(piece)
        })?;
        let piece = piece.as_str().unwrap_or_default();
        text.push_str(piece);
        // A character has at most four bytes.
        if piece.len() + 4 <= PIECE_BYTES {
            return Ok(text);
        }
    }
}

fn micro_line_set_pcs(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let index = call.integer(0)?;
    let part = call.pose(1)?;
    let is_known = match call.context().micro_lines().borrow_mut().get_mut(index) {
        Some(line) => {
            line.set_part(&part);
            true
        }
        None => false,
    };
    if is_known {
        Ok(Value::None)
    } else {
        Err(unknown(call, index))
    }
}

fn get_micro_line_values_by_index(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (index, wanted) = (call.integer(0)?, space(call.integer(1)?));
    let number = call.integer(2)?;
    // What is no number of a point is beyond the last one.
    let place = usize::try_from(number).unwrap_or(0);
    let (count, values) = with_micro_line(call, index, |line, model, flange_from_tcp, start| {
        let values = line.values(place, wanted, model, flange_from_tcp, start);
        (line.count(), values)
    })?;
    match values {
        Ok(Some(values)) => Ok(Value::list_of_f64(&values)),
        Ok(None) => Err(call.not_allowed(2, &text!("1 to {count}", "1 到 {count}"), number)),
        Err(error) => {
            let text = text!(
                "get_micro_line_values_by_index(): {error}",
                "get_micro_line_values_by_index()：{error}"
            );
            Err(call.error(ExceptionKind::RuntimeError, text))
        }
    }
}

/// Runs through the points. An arm that stands elsewhere goes to the first one with a movej at its default speed.
fn moveml(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let index = call.integer(0)?;
    let (first, last) = (call.integer(1)?, call.integer(2)?);
    let (count, interval) =
        with_micro_line(call, index, |line, _, _, _| (line.count(), line.interval()))?;
    let place = |number: i64, default: usize| match usize::try_from(number) {
        Ok(0) => Some(default),
        Ok(number) if number <= count => Some(number),
        _ => None,
    };
    let Some(begin) = place(first, 1) else {
        return Err(call.not_allowed(1, &text!("0 to {count}", "0 到 {count}"), first));
    };
    let Some(end) = place(last, count).filter(|end| *end > begin) else {
        let allowed = text!(
            "0 or {} to {count}, after start_line",
            "0 或 {} 到 {count}，在 start_line 之后",
            begin + 1
        );
        return Err(call.not_allowed(2, &allowed, last));
    };
    let (points, space, start) =
        with_micro_line(call, index, |line, model, flange_from_tcp, start| {
            let first = line.reach((begin, end), model, flange_from_tcp, start);
            // The list is for the motion thread, and is freed where the next is handed over.
            let samples = task_memory::uncounted(|| line.samples((begin, end)));
            (samples, line.space(), first)
        })?;
    let start = match start {
        Ok(start) => start,
        Err(error) => {
            task_memory::uncounted(|| drop(points));
            let text = text!("moveml(): {error}", "moveml()：{error}");
            return Err(call.error(ExceptionKind::RuntimeError, text));
        }
    };
    let here = call.context().robot().state().target_q;
    if (0..6).any(|joint| (start[joint] - here[joint]).abs() > AT_FIRST_POINT) {
        call.run_command(MotionCommand::MoveJ {
            target: start,
            acceleration: APPROACH.0,
            speed: APPROACH.1,
            duration: 0.0,
            radius: 0.0,
        })?;
    }
    let points =
        task_memory::uncounted(|| PointList::new(points, space == Space::Cartesian).map(Arc::new));
    let points = points.map_err(|refusal| call.refusal_error(&refusal))?;
    let done = call.run_points(&points, interval);
    task_memory::uncounted(|| drop(points));
    done?;
    Ok(Value::None)
}

/// What `look` finds in the file of an index, with the arm as it is now.
fn with_micro_line<T>(
    call: &mut Call<'_, '_>,
    index: i64,
    look: impl FnOnce(&MicroLine, &RobotModel, &Pose, &JointPositions) -> T,
) -> Result<T, Unwind> {
    let context = call.context();
    let state = call.state();
    let flange_from_tcp = Pose::from_rpy(&state.tcp_offset);
    let found = context.micro_lines().borrow().get(index).map(|line| {
        let model = context.robot().model();
        look(line, model, &flange_from_tcp, &state.target_q)
    });
    found.ok_or_else(|| unknown(call, index))
}

fn unknown(call: &mut Call<'_, '_>, index: i64) -> Unwind {
    let loaded = match call.context().micro_lines().borrow().count() {
        0 => text!(
            "the index of a loaded file, and none is loaded",
            "已载入文件的序号，而没有载入文件"
        ),
        1 => text!("0, the only file loaded", "0，唯一载入的文件"),
        count => text!(
            "0 to {}, the files loaded",
            "0 到 {}，已载入的文件",
            count - 1
        ),
    };
    call.not_allowed(0, &loaded, index)
}

fn in_file(call: &mut Call<'_, '_>, name: &str, error: &MicroLineError) -> Unwind {
    let text = text!(
        "load_micro_line_file(): {name}: {error}",
        "load_micro_line_file()：{name}：{error}"
    );
    call.error(ExceptionKind::ValueError, text)
}
