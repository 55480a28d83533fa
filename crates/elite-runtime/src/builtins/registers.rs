//! Manual 5.37 to 5.45: general purpose registers. A write is seen by the next read, whoever reads.

use elite_lang::{Unwind, Value};
use motion_api::IoChange;

use super::call::Call;
use super::declare::{Builtin, Category::Register, Parameter, ParameterType, Range, phrase};

const BIT: Parameter = Parameter::required(
    "address",
    ParameterType::Integer(0, 127),
    phrase("number of the register", "寄存器编号"),
);
const NUMBER: Parameter = Parameter::required(
    "address",
    ParameterType::Integer(0, 47),
    phrase("number of the register", "寄存器编号"),
);
const LEVEL: Parameter = Parameter::required(
    "value",
    ParameterType::Boolean,
    phrase("what to store", "要存入的值"),
);
const INTEGER: Parameter = Parameter::required(
    "value",
    ParameterType::Integer(i32::MIN as i64, i32::MAX as i64),
    phrase("what to store", "要存入的值"),
);
const FLOAT: Parameter = Parameter::required(
    "value",
    ParameterType::Number(Range::Any),
    phrase("what to store", "要存入的值"),
);

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin::new(
        Register,
        "5.37",
        "read_input_boolean_register",
        &[BIT],
        phrase("bool", "bool"),
        phrase("Value of a boolean input register.", "布尔输入寄存器的值。"),
        |call| {
            let n = call.byte(0)?;
            Ok(Value::Bool(
                call.context().robot().registers().input.boolean(n),
            ))
        },
    ),
    Builtin::new(
        Register,
        "5.38",
        "read_input_float_register",
        &[NUMBER],
        phrase("float", "float"),
        phrase("Value of a float input register.", "浮点输入寄存器的值。"),
        |call| {
            let n = call.byte(0)?;
            Ok(Value::Float(
                call.context().robot().registers().input.float(n),
            ))
        },
    ),
    Builtin::new(
        Register,
        "5.39",
        "read_input_integer_register",
        &[NUMBER],
        phrase("int", "int"),
        phrase(
            "Value of an integer input register.",
            "整数输入寄存器的值。",
        ),
        |call| {
            let n = call.byte(0)?;
            Ok(integer(call.context().robot().registers().input.integer(n)))
        },
    ),
    Builtin::new(
        Register,
        "5.40",
        "read_output_boolean_register",
        &[BIT],
        phrase("bool", "bool"),
        phrase(
            "Value of a boolean output register.",
            "布尔输出寄存器的值。",
        ),
        |call| {
            let n = call.byte(0)?;
            call.await_register_changes()?;
            Ok(Value::Bool(
                call.context().robot().registers().output.boolean(n),
            ))
        },
    ),
    Builtin::new(
        Register,
        "5.41",
        "read_output_float_register",
        &[NUMBER],
        phrase("float", "float"),
        phrase("Value of a float output register.", "浮点输出寄存器的值。"),
        |call| {
            let n = call.byte(0)?;
            call.await_register_changes()?;
            Ok(Value::Float(
                call.context().robot().registers().output.float(n),
            ))
        },
    ),
    Builtin::new(
        Register,
        "5.42",
        "read_output_integer_register",
        &[NUMBER],
        phrase("int", "int"),
        phrase(
            "Value of an integer output register.",
            "整数输出寄存器的值。",
        ),
        |call| {
            let n = call.byte(0)?;
            call.await_register_changes()?;
            Ok(integer(
                call.context().robot().registers().output.integer(n),
            ))
        },
    ),
    Builtin::new(
        Register,
        "5.43",
        "write_output_boolean_register",
        &[BIT, LEVEL],
        phrase("nothing", "无返回值"),
        phrase(
            "Stores a truth value in an output register.",
            "把真值写入输出寄存器。",
        ),
        write_boolean,
    ),
    Builtin::new(
        Register,
        "5.44",
        "write_output_float_register",
        &[NUMBER, FLOAT],
        phrase("nothing", "无返回值"),
        phrase(
            "Stores a number in an output register.",
            "把数写入输出寄存器。",
        ),
        write_float,
    ),
    Builtin::new(
        Register,
        "5.45",
        "write_output_integer_register",
        &[NUMBER, INTEGER],
        phrase("nothing", "无返回值"),
        phrase(
            "Stores a 32-bit integer in an output register.",
            "把 32 位整数写入输出寄存器。",
        ),
        write_integer,
    ),
];

fn integer(value: i32) -> Value {
    Value::Int(value.into())
}

fn write_boolean(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (index, level) = (call.byte(0)?, call.boolean(1)?);
    call.change_register(IoChange::BooleanRegister { index, level })?;
    Ok(Value::None)
}

fn write_float(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (index, value) = (call.byte(0)?, call.number(1)?);
    call.change_register(IoChange::FloatRegister { index, value })?;
    Ok(Value::None)
}

fn write_integer(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let index = call.byte(0)?;
    // The declared range is that of the register.
    let value = i32::try_from(call.integer(1)?).unwrap_or_default();
    call.change_register(IoChange::IntegerRegister { index, value })?;
    Ok(Value::None)
}
