//! Names that programs of the pendant use and the vendor's manual does not describe (from controller output, not from
//! the manual). What moves the arm among them is with the motions.

use ::kinematics::script_math;
use elite_lang::{ExceptionKind, Unwind, Value};
use messages::Text;
use motion_api::IoChange;

use super::call::Call;
use super::declare::{Builtin, Category, FROM_OUTPUT, Parameter, ParameterType, Phrase, phrase};

/// The builtins.
pub const BUILTINS: &[Builtin] = &[
    Builtin::new(
        Category::Other,
        FROM_OUTPUT,
        "set_safety_mode_transition_hardness",
        &[Parameter::required(
            "type",
            ParameterType::Integer(0, 1),
            phrase("0 hard, 1 soft", "0 硬，1 软"),
        )],
        phrase("nothing", "无返回值"),
        phrase(
            "How the arm brakes when it passes into reduced mode.",
            "进入缩减模式时手臂的制动方式。",
        ),
        |call| {
            let kind = call.byte(0)?;
            set(call, IoChange::SafetyHardness(kind))
        },
    ),
    Builtin::new(
        Category::Io,
        FROM_OUTPUT,
        "set_tool_digital_io_work_mode",
        &[Parameter::required(
            "mode",
            ParameterType::Integer(0, 3),
            phrase("kept with the tool's configuration", "随工具配置保存"),
        )],
        phrase("nothing", "无返回值"),
        phrase(
            "What the digital pins of the tool are used for.",
            "工具数字引脚的用途。",
        ),
        |call| {
            let mode = call.byte(0)?;
            set(call, IoChange::ToolDigitalMode(mode))
        },
    ),
    Builtin::new(
        Category::Math,
        FROM_OUTPUT,
        "cal_rpy_frame",
        &[
            Parameter::new(
                "origin",
                ParameterType::Numbers(3),
                "m",
                phrase("where the frame lies", "坐标系的原点"),
            ),
            Parameter::required(
                "x_direction",
                ParameterType::Numbers(3),
                phrase("direction of its X axis", "X 轴的方向"),
            ),
            Parameter::required(
                "y_direction",
                ParameterType::Numbers(3),
                phrase(
                    "its Y axis is on this side of X, at a right angle to it",
                    "Y 轴位于 X 轴的这一侧并与之垂直",
                ),
            ),
        ],
        phrase("list[6] float, m and rad", "list[6] float，m 和 rad"),
        phrase(
            "A frame as a pose, from an origin and two directions.",
            "由原点和两个方向得到坐标系位姿。",
        ),
        cal_rpy_frame,
    ),
    copying(
        "elicopy.copy",
        phrase(
            "A copy of a value, as copy.copy of Python; there without import.",
            "值的浅拷贝，同 Python 的 copy.copy；无需导入。",
        ),
    ),
    copying(
        "elicopy.deepcopy",
        phrase(
            "A copy of a value and of all it holds, as copy.deepcopy of Python; there without \
             import.",
            "值及其内容的深拷贝，同 Python 的 copy.deepcopy；无需导入。",
        ),
    ),
];

const COPIED: &[Parameter] = &[Parameter::required(
    "x",
    ParameterType::Custom("any"),
    phrase("what is copied", "要拷贝的对象"),
)];

/// Functions of the language, named here for the listing.
const fn copying(name: &'static str, summary: Phrase) -> Builtin {
    Builtin {
        name,
        section: FROM_OUTPUT,
        category: Category::Other,
        summary,
        params: COPIED,
        returns: phrase("the copy", "拷贝"),
        waits: false,
        run: None,
    }
}

fn set(call: &mut Call<'_, '_>, change: IoChange) -> Result<Value, Unwind> {
    call.change(change)?;
    Ok(Value::None)
}

fn cal_rpy_frame(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (origin, x, y) = (call.numbers(0)?, call.numbers(1)?, call.numbers(2)?);
    match script_math::cal_rpy_frame(origin, x, y) {
        Ok(frame) => Ok(Value::list_of_f64(&frame.to_array())),
        Err(error) => Err(call.error(ExceptionKind::ValueError, Text::of(&error))),
    }
}
