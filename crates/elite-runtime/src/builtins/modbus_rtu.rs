//! Manual 8.2: Modbus RTU as master on the serial ports.
//!
//! A read that fails gives an empty list, a write that fails 0 or False, both with a line in the log that says why;
//! arguments outside their range raise. A write gives the number of values that were written (manual 8.2.13 to 8.2.16),
//! at the tool a single value 1 and several True (8.2.5 to 8.2.8).

use std::sync::Arc;

use elite_lang::{Unwind, Value};
use io_bus::modbus::pdu::{Reply, Request, Table};
use messages::{Text, text};

use super::call::Call;
use super::declare::{
    Builtin, Category::ModbusRtu, Parameter, ParameterDefault, ParameterType, Phrase, Range, phrase,
};
use super::serial::{OLD_PORT, Port, check_not_daemon, on_line_thread};

const SLAVE: Parameter = Parameter::required(
    "slave",
    ParameterType::Integer(1, 247),
    phrase("the device", "设备"),
);
const ADDR: Parameter = Parameter::required(
    "addr",
    ParameterType::Integer(0, 65535),
    phrase("first address", "起始地址"),
)
.also(&["address"]);
const ADDRESS: Parameter = Parameter::required(
    "address",
    ParameterType::Integer(0, 65535),
    phrase("first address", "起始地址"),
)
.also(&["addr"]);
const LEN: Parameter = Parameter::required(
    "len",
    ParameterType::Integer(1, 125),
    phrase("how many", "数量"),
)
.also(&["read_count"]);
const OLD_LEN: Parameter = Parameter::required(
    "len",
    ParameterType::Integer(1, 125),
    phrase("how many", "数量"),
);
const READ_COUNT: Parameter = Parameter::required(
    "read_count",
    ParameterType::Integer(1, 125),
    phrase("how many", "数量"),
)
.also(&["len"]);
const PATIENCE: Phrase = phrase("0 or less waits for ever", "不大于 0 时一直等待");
const TIME_OUT_5: Parameter =
    Parameter::required("time_out", ParameterType::Number(Range::Any), PATIENCE)
        .also(&["timeout"])
        .or(ParameterDefault::Number(5.0))
        .in_unit("s");
const TIMEOUT_5: Parameter =
    Parameter::required("timeout", ParameterType::Number(Range::Any), PATIENCE)
        .also(&["time_out"])
        .or(ParameterDefault::Number(5.0))
        .in_unit("s");
const TIMEOUT_3: Parameter = TIMEOUT_5.or(ParameterDefault::Number(3.0));
const BIT: Parameter = Parameter::required(
    "data",
    ParameterType::Custom("bool or int, alone or as a list of one"),
    phrase("0 low, otherwise high", "0 为低电平，其余为高电平"),
);
const BITS_TO_WRITE: Parameter = Parameter::required(
    "data",
    ParameterType::Custom("bool, int or list"),
    phrase(
        "levels: 0 low, otherwise high; at most 1968",
        "电平：0 为低，其余为高；最多 1968 个",
    ),
);
const REGISTER: Parameter = Parameter::required(
    "data",
    ParameterType::Custom("int, alone or as a list of one"),
    phrase("0 to 65535", "0 到 65535"),
);
const REGISTERS_TO_WRITE: Parameter = Parameter::required(
    "data",
    ParameterType::Custom("int or list[int]"),
    phrase(
        "0 to 65535 each; at most 123",
        "每个为 0 到 65535；最多 123 个",
    ),
);

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin::new(
        ModbusRtu,
        "8.2.1",
        "tool_modbus_read_bits",
        &[SLAVE, ADDR, LEN, TIME_OUT_5],
        phrase("list[int], empty when it fails", "list[int]，失败时为空"),
        phrase(
            "Reads bits of a Modbus RTU device at the tool (function 1).",
            "读取工具侧 Modbus RTU 设备的线圈（功能码 1）。",
        ),
        |call| read(call, Port::Tool, Table::Coils),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "8.2.2",
        "tool_modbus_read_input_bits",
        &[SLAVE, ADDR, LEN, TIMEOUT_5],
        phrase("list[int], empty when it fails", "list[int]，失败时为空"),
        phrase(
            "Reads inputs of a Modbus RTU device at the tool (function 2).",
            "读取工具侧 Modbus RTU 设备的离散输入（功能码 2）。",
        ),
        |call| read(call, Port::Tool, Table::DiscreteInputs),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "8.2.3",
        "tool_modbus_read_registers",
        &[SLAVE, ADDR, LEN, TIME_OUT_5],
        phrase("list[int], empty when it fails", "list[int]，失败时为空"),
        phrase(
            "Reads registers of a Modbus RTU device at the tool (function 3).",
            "读取工具侧 Modbus RTU 设备的保持寄存器（功能码 3）。",
        ),
        |call| read(call, Port::Tool, Table::HoldingRegisters),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "8.2.4",
        "tool_modbus_read_input_registers",
        &[SLAVE, ADDR, LEN, TIMEOUT_5],
        phrase("list[int], empty when it fails", "list[int]，失败时为空"),
        phrase(
            "Reads input registers of a Modbus RTU device at the tool (function 4).",
            "读取工具侧 Modbus RTU 设备的输入寄存器（功能码 4）。",
        ),
        |call| read(call, Port::Tool, Table::InputRegisters),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "8.2.5",
        "tool_modbus_write_single_bit",
        &[SLAVE, ADDR, BIT, TIMEOUT_5],
        phrase(
            "int, 1 when written, 0 when it fails",
            "int，已写入为 1，失败为 0",
        ),
        phrase(
            "Writes one bit of a Modbus RTU device at the tool (function 5).",
            "写工具侧 Modbus RTU 设备的一个线圈（功能码 5）。",
        ),
        |call| write_coil(call, Port::Tool, WriteResult::Count),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "8.2.6",
        "tool_modbus_write_bits",
        &[SLAVE, ADDR, BITS_TO_WRITE, TIMEOUT_5],
        phrase("bool, True when written", "bool，已写入为 True"),
        phrase(
            "Writes bits of a Modbus RTU device at the tool (function 15).",
            "写工具侧 Modbus RTU 设备的多个线圈（功能码 15）。",
        ),
        |call| write_coils(call, Port::Tool, WriteResult::Bool),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "8.2.7",
        "tool_modbus_write_single_register",
        &[SLAVE, ADDR, REGISTER, TIMEOUT_5],
        phrase(
            "int, 1 when written, 0 when it fails",
            "int，已写入为 1，失败为 0",
        ),
        phrase(
            "Writes one register of a Modbus RTU device at the tool (function 6).",
            "写工具侧 Modbus RTU 设备的一个寄存器（功能码 6）。",
        ),
        |call| write_register(call, Port::Tool, WriteResult::Count),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "8.2.8",
        "tool_modbus_write_registers",
        &[SLAVE, ADDRESS, REGISTERS_TO_WRITE, TIMEOUT_5],
        phrase("bool, True when written", "bool，已写入为 True"),
        phrase(
            "Writes registers of a Modbus RTU device at the tool (function 16).",
            "写工具侧 Modbus RTU 设备的多个寄存器（功能码 16）。",
        ),
        |call| write_registers(call, Port::Tool, WriteResult::Bool),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "8.2.9",
        "masterboard_modbus_rtu_read_bits",
        &[SLAVE, ADDRESS, READ_COUNT, TIMEOUT_3],
        phrase("list[int], empty when it fails", "list[int]，失败时为空"),
        phrase(
            "Reads bits of a Modbus RTU device at the control box (function 1).",
            "读取控制柜侧 Modbus RTU 设备的线圈（功能码 1）。",
        ),
        |call| read(call, Port::Masterboard, Table::Coils),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "8.2.10",
        "masterboard_modbus_rtu_read_input_bits",
        &[SLAVE, ADDRESS, READ_COUNT, TIMEOUT_3],
        phrase("list[int], empty when it fails", "list[int]，失败时为空"),
        phrase(
            "Reads inputs of a Modbus RTU device at the control box (function 2).",
            "读取控制柜侧 Modbus RTU 设备的离散输入（功能码 2）。",
        ),
        |call| read(call, Port::Masterboard, Table::DiscreteInputs),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "8.2.11",
        "masterboard_modbus_rtu_read_registers",
        &[SLAVE, ADDRESS, READ_COUNT, TIMEOUT_3],
        phrase("list[int], empty when it fails", "list[int]，失败时为空"),
        phrase(
            "Reads registers of a Modbus RTU device at the control box (function 3).",
            "读取控制柜侧 Modbus RTU 设备的保持寄存器（功能码 3）。",
        ),
        |call| read(call, Port::Masterboard, Table::HoldingRegisters),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "8.2.12",
        "masterboard_modbus_rtu_read_input_registers",
        &[SLAVE, ADDRESS, READ_COUNT, TIMEOUT_3],
        phrase("list[int], empty when it fails", "list[int]，失败时为空"),
        phrase(
            "Reads input registers of a Modbus RTU device at the control box (function 4).",
            "读取控制柜侧 Modbus RTU 设备的输入寄存器（功能码 4）。",
        ),
        |call| read(call, Port::Masterboard, Table::InputRegisters),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "8.2.13",
        "masterboard_modbus_rtu_write_single_bit",
        &[SLAVE, ADDRESS, BIT, TIMEOUT_3],
        phrase(
            "int, 1 when written, 0 when it fails",
            "int，已写入为 1，失败为 0",
        ),
        phrase(
            "Writes one bit of a Modbus RTU device at the control box (function 5).",
            "写控制柜侧 Modbus RTU 设备的一个线圈（功能码 5）。",
        ),
        |call| write_coil(call, Port::Masterboard, WriteResult::Count),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "8.2.14",
        "masterboard_modbus_rtu_write_bits",
        &[SLAVE, ADDRESS, BITS_TO_WRITE, TIMEOUT_3],
        phrase(
            "int, how many were written, 0 when it fails",
            "int，写入的数量，失败时为 0",
        ),
        phrase(
            "Writes bits of a Modbus RTU device at the control box (function 15).",
            "写控制柜侧 Modbus RTU 设备的多个线圈（功能码 15）。",
        ),
        |call| write_coils(call, Port::Masterboard, WriteResult::Count),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "8.2.15",
        "masterboard_modbus_rtu_write_single_register",
        &[SLAVE, ADDRESS, REGISTER, TIMEOUT_3],
        phrase(
            "int, 1 when written, 0 when it fails",
            "int，已写入为 1，失败为 0",
        ),
        phrase(
            "Writes one register of a Modbus RTU device at the control box (function 6).",
            "写控制柜侧 Modbus RTU 设备的一个寄存器（功能码 6）。",
        ),
        |call| write_register(call, Port::Masterboard, WriteResult::Count),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "8.2.16",
        "masterboard_modbus_rtu_write_registers",
        &[SLAVE, ADDRESS, REGISTERS_TO_WRITE, TIMEOUT_3],
        phrase(
            "int, how many were written, 0 when it fails",
            "int，写入的数量，失败时为 0",
        ),
        phrase(
            "Writes registers of a Modbus RTU device at the control box (function 16).",
            "写控制柜侧 Modbus RTU 设备的多个寄存器（功能码 16）。",
        ),
        |call| write_registers(call, Port::Masterboard, WriteResult::Count),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "2.14.5",
        "serial_modbus_read_bits",
        &[SLAVE, ADDRESS, OLD_LEN, TIMEOUT_5, OLD_PORT],
        phrase("list[int], empty when it fails", "list[int]，失败时为空"),
        phrase(
            "Reads bits of a Modbus RTU device at the control box (function 1).",
            "读取控制柜侧 Modbus RTU 设备的线圈（功能码 1）。",
        ),
        |call| read(call, Port::Masterboard, Table::Coils),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "2.14.5",
        "serial_modbus_read_input_bits",
        &[SLAVE, ADDRESS, OLD_LEN, TIMEOUT_5, OLD_PORT],
        phrase("list[int], empty when it fails", "list[int]，失败时为空"),
        phrase(
            "Reads inputs of a Modbus RTU device at the control box (function 2).",
            "读取控制柜侧 Modbus RTU 设备的离散输入（功能码 2）。",
        ),
        |call| read(call, Port::Masterboard, Table::DiscreteInputs),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "2.14.5",
        "serial_modbus_read_registers",
        &[SLAVE, ADDRESS, OLD_LEN, TIMEOUT_5, OLD_PORT],
        phrase("list[int], empty when it fails", "list[int]，失败时为空"),
        phrase(
            "Reads registers of a Modbus RTU device at the control box (function 3).",
            "读取控制柜侧 Modbus RTU 设备的保持寄存器（功能码 3）。",
        ),
        |call| read(call, Port::Masterboard, Table::HoldingRegisters),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "2.14.5",
        "serial_modbus_read_input_registers",
        &[SLAVE, ADDRESS, OLD_LEN, TIMEOUT_5, OLD_PORT],
        phrase("list[int], empty when it fails", "list[int]，失败时为空"),
        phrase(
            "Reads input registers of a Modbus RTU device at the control box (function 4).",
            "读取控制柜侧 Modbus RTU 设备的输入寄存器（功能码 4）。",
        ),
        |call| read(call, Port::Masterboard, Table::InputRegisters),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "2.14.5",
        "serial_modbus_write_single_bit",
        &[SLAVE, ADDRESS, BIT, TIMEOUT_5, OLD_PORT],
        phrase(
            "int, 1 when written, 0 when it fails",
            "int，已写入为 1，失败为 0",
        ),
        phrase(
            "Writes one bit of a Modbus RTU device at the control box (function 5).",
            "写控制柜侧 Modbus RTU 设备的一个线圈（功能码 5）。",
        ),
        |call| write_coil(call, Port::Masterboard, WriteResult::Count),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "2.14.5",
        "serial_modbus_write_bits",
        &[SLAVE, ADDRESS, BITS_TO_WRITE, TIMEOUT_5, OLD_PORT],
        phrase(
            "int, how many were written, 0 when it fails",
            "int，写入的数量，失败时为 0",
        ),
        phrase(
            "Writes bits of a Modbus RTU device at the control box (function 15).",
            "写控制柜侧 Modbus RTU 设备的多个线圈（功能码 15）。",
        ),
        |call| write_coils(call, Port::Masterboard, WriteResult::Count),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "2.14.5",
        "serial_modbus_write_single_register",
        &[SLAVE, ADDRESS, REGISTER, TIMEOUT_5, OLD_PORT],
        phrase(
            "int, 1 when written, 0 when it fails",
            "int，已写入为 1，失败为 0",
        ),
        phrase(
            "Writes one register of a Modbus RTU device at the control box (function 6).",
            "写控制柜侧 Modbus RTU 设备的一个寄存器（功能码 6）。",
        ),
        |call| write_register(call, Port::Masterboard, WriteResult::Count),
    )
    .waiting(),
    Builtin::new(
        ModbusRtu,
        "2.14.5",
        "serial_modbus_write_registers",
        &[SLAVE, ADDRESS, REGISTERS_TO_WRITE, TIMEOUT_5, OLD_PORT],
        phrase(
            "int, how many were written, 0 when it fails",
            "int，写入的数量，失败时为 0",
        ),
        phrase(
            "Writes registers of a Modbus RTU device at the control box (function 16).",
            "写控制柜侧 Modbus RTU 设备的多个寄存器（功能码 16）。",
        ),
        |call| write_registers(call, Port::Masterboard, WriteResult::Count),
    )
    .waiting(),
];

/// What a write gives.
#[derive(Clone, Copy)]
enum WriteResult {
    /// How many values were written.
    Count,
    /// Whether values were written.
    Bool,
}

/// One request; `None` when it failed, which has been logged.
fn ask(call: &mut Call<'_, '_>, port: Port, request: Request) -> Result<Option<Reply>, Unwind> {
    let (slave, patience) = (call.byte(0)?, call.patience(3)?);
    if matches!(call.given(4), Some(value) if !matches!(value, Value::Unbound)) {
        call.word(4)?;
    }
    check_not_daemon(call, port)?;
    let fieldbus = Arc::clone(call.context().fieldbus());
    let theirs = task_memory::uncounted(|| request.clone());
    let done = on_line_thread(call, async move {
        port.line(&fieldbus).request(slave, theirs, patience).await
    })?;
    match done {
        Ok(reply) => Ok(Some(reply)),
        Err(error) => {
            call.warn(&error);
            Ok(None)
        }
    }
}

/// An address; its range is 16 bits.
fn address(call: &mut Call<'_, '_>) -> Result<u16, Unwind> {
    Ok(u16::try_from(call.integer(1)?).unwrap_or_default())
}

fn read(call: &mut Call<'_, '_>, port: Port, table: Table) -> Result<Value, Unwind> {
    let request = Request::Read {
        table,
        address: address(call)?,
        count: call.byte(2)?.into(),
    };
    let values = match ask(call, port, request)? {
        Some(Reply::Values(values)) => values,
        _ => Vec::new(),
    };
    Ok(Value::list(
        values
            .into_iter()
            .map(|word| Value::Int(word.into()))
            .collect(),
    ))
}

fn write(
    call: &mut Call<'_, '_>,
    port: Port,
    request: Request,
    count: usize,
    result: WriteResult,
) -> Result<Value, Unwind> {
    let written = ask(call, port, request)?.is_some();
    Ok(match result {
        // At most 1968, and the device confirms all of them or none.
        WriteResult::Count if written => Value::Int(count as i64),
        WriteResult::Count => Value::Int(0),
        WriteResult::Bool => Value::Bool(written),
    })
}

/// The values to write, 1 to `most` of them, alone or as a list, each converted by `convert`; `what` says what it
/// takes.
fn data<T>(
    call: &mut Call<'_, '_>,
    most: usize,
    what: &Text,
    convert: impl Fn(&Value) -> Option<T>,
) -> Result<Vec<T>, Unwind> {
    let value = call.required(2);
    let Some(items) = value.as_items() else {
        return match convert(&value) {
            Some(converted) => Ok(vec![converted]),
            None => Err(match value.as_i64() {
                Some(number) => call.not_allowed(2, what, number),
                None => call.not_this_type(2, what),
            }),
        };
    };
    if items.is_empty() || items.len() > most {
        let allowed = match most {
            1 => text!("one value", "一个值"),
            _ => text!("1 to {most} values", "1 到 {most} 个值"),
        };
        return Err(call.not_allowed(2, &allowed, items.len()));
    }
    let mut converted = Vec::with_capacity(items.len());
    for (k, item) in items.iter().enumerate() {
        let Some(item) = convert(item) else {
            return Err(call.item_not_allowed(2, k, what, item));
        };
        converted.push(item);
    }
    Ok(converted)
}

const LEVELS: Text = text!("True, False or an integer", "True、False 或整数");
const WORDS: Text = text!("an integer from 0 to 65535", "0 到 65535 的整数");

fn level(value: &Value) -> Option<bool> {
    value.as_i64().map(|number| number != 0)
}

fn word(value: &Value) -> Option<u16> {
    value.as_i64().and_then(|number| u16::try_from(number).ok())
}

fn write_coil(call: &mut Call<'_, '_>, port: Port, result: WriteResult) -> Result<Value, Unwind> {
    let levels = data(call, 1, &LEVELS, level)?;
    let request = Request::WriteCoil(address(call)?, levels == [true]);
    write(call, port, request, 1, result)
}

fn write_coils(call: &mut Call<'_, '_>, port: Port, result: WriteResult) -> Result<Value, Unwind> {
    let levels = data(call, 1968, &LEVELS, level)?;
    let count = levels.len();
    let request = Request::WriteCoils(address(call)?, levels);
    write(call, port, request, count, result)
}

fn write_register(
    call: &mut Call<'_, '_>,
    port: Port,
    result: WriteResult,
) -> Result<Value, Unwind> {
    let words = data(call, 1, &WORDS, word)?;
    let request =
        Request::WriteRegister(address(call)?, words.first().copied().unwrap_or_default());
    write(call, port, request, 1, result)
}

fn write_registers(
    call: &mut Call<'_, '_>,
    port: Port,
    result: WriteResult,
) -> Result<Value, Unwind> {
    let words = data(call, 123, &WORDS, word)?;
    let count = words.len();
    let request = Request::WriteRegisters(address(call)?, words);
    write(call, port, request, count, result)
}
