//! Names that programs of the pendant use and the vendor's manual does not describe (from controller output, not from
//! the manual). What moves the arm among them is with the motions.

use ::kinematics::script_math;
use elite_lang::{ExceptionKind, Unwind, Value};
use motion_api::IoChange;

use super::call::Call;
use super::declare::{Builtin, Category, FROM_OUTPUT, Parameter, ParameterType};

/// The builtins.
pub const BUILTINS: &[Builtin] = &[
    Builtin::new(
        Category::Other,
        FROM_OUTPUT,
        "set_safety_mode_transition_hardness",
        &[Parameter::required(
            "type",
            ParameterType::Integer(0, 1),
            "0 hard, 1 soft",
        )],
        "nothing",
        "How the arm brakes when it passes into reduced mode.",
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
            "kept with the tool's configuration",
        )],
        "nothing",
        "What the digital pins of the tool are used for.",
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
                "where the frame lies",
            ),
            Parameter::required(
                "x_direction",
                ParameterType::Numbers(3),
                "direction of its X axis",
            ),
            Parameter::required(
                "y_direction",
                ParameterType::Numbers(3),
                "its Y axis is on this side of X, at a right angle to it",
            ),
        ],
        "list[6] float, m and rad",
        "A frame as a pose, from an origin and two directions.",
        cal_rpy_frame,
    ),
    copying(
        "elicopy.copy",
        "A copy of a value, as copy.copy of Python; there without import.",
    ),
    copying(
        "elicopy.deepcopy",
        "A copy of a value and of all it holds, as copy.deepcopy of Python; there without import.",
    ),
];

const COPIED: &[Parameter] = &[Parameter::required(
    "x",
    ParameterType::Custom("any"),
    "what is copied",
)];

/// Functions of the language, named here for the listing.
const fn copying(name: &'static str, summary: &'static str) -> Builtin {
    Builtin {
        name,
        section: FROM_OUTPUT,
        category: Category::Other,
        summary,
        params: COPIED,
        returns: "the copy",
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
        Err(error) => Err(call.error(ExceptionKind::ValueError, error.to_string())),
    }
}
