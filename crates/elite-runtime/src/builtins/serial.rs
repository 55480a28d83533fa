//! Manual 5.31 to 5.34 and 8.1: RS-485 at the tool connector and in the control box.
//!
//! A line that is closed, in the other mode or broken makes reads empty and writes fail by value, with a line in the
//! log; arguments outside their range raise. The functions of the 2.14.5 edition mean the port of the control box.

use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use elite_lang::{Unwind, Value};
use io_bus::Fieldbus;
use io_bus::serial::{SerialLine, SerialMode, SerialSettings};
use messages::{Localized, Text, text};

use super::call::Call;
use super::declare::{
    Builtin, Category::Serial, Parameter, ParameterDefault, ParameterType, Range, phrase,
};

/// Sub code of the alarm "the port belongs to a plug-in" (manual 5.32).
const USED_BY_DAEMON: i32 = 2;
/// Most bytes of one read.
const READ_BYTES_MAX: i64 = 65536;

/// A port of the controller.
#[derive(Clone, Copy)]
pub(super) enum Port {
    /// At the tool connector.
    Tool,
    /// In the control box.
    Masterboard,
}

impl Port {
    /// The serial line of the simulation that belongs to this port.
    pub(super) fn line(self, fieldbus: &Fieldbus) -> &SerialLine {
        match self {
            Self::Tool => &fieldbus.tool_serial,
            Self::Masterboard => &fieldbus.masterboard_serial,
        }
    }
}

const TOOL_BAUD: ParameterType =
    ParameterType::OneOf(&[9600, 19200, 38400, 57600, 115_200, 1_000_000, 2_000_000]);
const BAUD: ParameterType = ParameterType::OneOf(&[
    2400, 4800, 9600, 19200, 38400, 57600, 115_200, 230_400, 460_800, 500_000, 921_600,
]);

const ENABLED: Parameter = Parameter::required(
    "enabled",
    ParameterType::Boolean,
    phrase("open or close the port", "打开或关闭端口"),
);
const TOOL_BAUD_RATE: Parameter =
    Parameter::required("baud_rate", TOOL_BAUD, phrase("baud rate", "波特率")).in_unit("baud");
const PARITY: Parameter = Parameter::required(
    "parity",
    ParameterType::Integer(0, 2),
    phrase("0 none, 1 odd, 2 even", "校验位：0 无，1 奇，2 偶"),
)
.also(&["parity_bit"]);
const STOP_BITS: Parameter = Parameter::required(
    "stop_bits",
    ParameterType::Integer(1, 2),
    phrase("stop bits", "停止位"),
);
const TOOL_SIZE: Parameter = Parameter::required(
    "size",
    ParameterType::OneOf(&[8]),
    phrase("data bits", "数据位"),
)
.or(ParameterDefault::Integer(8))
.in_unit("bit");
const MODBUS_RTU: Parameter = Parameter::required(
    "modbus_rtu",
    ParameterType::Boolean,
    phrase(
        "True: Modbus RTU, False: bytes",
        "True：Modbus RTU；False：字节流",
    ),
)
.or(ParameterDefault::Boolean(false));
const USAGE: Parameter = Parameter::required(
    "usage",
    ParameterType::Integer(0, 1),
    phrase(
        "0 scripts use the port, 1 a plug-in does",
        "0 由脚本使用端口，1 由插件使用",
    ),
)
.or(ParameterDefault::Integer(0));
const ENABLE: Parameter = Parameter::required(
    "enable",
    ParameterType::Boolean,
    phrase("open or close the port", "打开或关闭端口"),
);
const BAUD_OR_DEFAULT: Parameter = Parameter::required("baud", BAUD, phrase("baud rate", "波特率"))
    .or(ParameterDefault::Integer(115_200))
    .in_unit("baud");
const PARITY_OR_DEFAULT: Parameter = PARITY.or(ParameterDefault::Integer(1));
const STOP_BIT_OR_DEFAULT: Parameter = Parameter::required(
    "stop_bit",
    ParameterType::Integer(1, 2),
    phrase("stop bits", "停止位"),
)
.or(ParameterDefault::Integer(1));
const SIZE_OR_DEFAULT: Parameter = Parameter::required(
    "size",
    ParameterType::Integer(7, 8),
    phrase("data bits; 8 for Modbus RTU", "数据位；Modbus RTU 时为 8"),
)
.or(ParameterDefault::Integer(8))
.in_unit("bit");
const OLD_BAUD: Parameter =
    Parameter::required("baud", BAUD, phrase("baud rate", "波特率")).in_unit("baud");
const OLD_PARITY: Parameter = Parameter::required(
    "parity_bit",
    ParameterType::Integer(0, 2),
    phrase("0 none, 1 odd, 2 even", "校验位：0 无，1 奇，2 偶"),
)
.also(&["parity"]);
const OLD_STOP_BIT: Parameter = Parameter::required(
    "stop_bit",
    ParameterType::Integer(1, 2),
    phrase("stop bits", "停止位"),
);
const OLD_SIZE: Parameter = Parameter::required(
    "size",
    ParameterType::Integer(7, 8),
    phrase("data bits; 8 for Modbus RTU", "数据位；Modbus RTU 时为 8"),
)
.in_unit("bit");
const OLD_MODBUS_RTU: Parameter = Parameter::required(
    "modbus_rtu",
    ParameterType::Boolean,
    phrase(
        "True: Modbus RTU, False: bytes",
        "True：Modbus RTU；False：字节流",
    ),
);
const READ_COUNT: Parameter = Parameter::required(
    "read_count",
    ParameterType::Integer(0, READ_BYTES_MAX),
    phrase("bytes to read", "要读取的字节数"),
);
const LEN: Parameter = Parameter::required(
    "len",
    ParameterType::Integer(0, READ_BYTES_MAX),
    phrase("bytes to read", "要读取的字节数"),
);
const IS_NUMBER: Parameter = Parameter::required(
    "is_number",
    ParameterType::Boolean,
    phrase(
        "True: a list of integers, False: bytes",
        "True：返回整数列表；False：返回 bytes",
    ),
);
const IS_NUMBER_OR_DEFAULT: Parameter = IS_NUMBER.or(ParameterDefault::Boolean(true));
const TIME_OUT: Parameter = Parameter::required(
    "time_out",
    ParameterType::Number(Range::Any),
    phrase("0 or less waits for ever", "不大于 0 时一直等待"),
)
.also(&["timeout"])
.in_unit("s");
const OLD_TIME_OUT: Parameter = TIME_OUT.or(ParameterDefault::Number(0.1));
const TIMEOUT_OR_DEFAULT: Parameter = Parameter::required(
    "timeout",
    ParameterType::Number(Range::Any),
    phrase("0 or less waits for ever", "不大于 0 时一直等待"),
)
.also(&["time_out"])
.or(ParameterDefault::Number(0.1))
.in_unit("s");
const DATA_KIND: ParameterType = ParameterType::Custom("str, int, list[int], bytes or bytearray");
const WRITE_DATA: Parameter = Parameter::required(
    "write_data",
    DATA_KIND,
    phrase(
        "what to send; the low 8 bits of integers",
        "要发送的内容；整数只取低 8 位",
    ),
);
const DATA: Parameter = Parameter::required(
    "data",
    DATA_KIND,
    phrase(
        "what to send; the low 8 bits of integers",
        "要发送的内容；整数只取低 8 位",
    ),
);
/// The device of the 2.14.5 edition; every name the editions use is the port of the control box.
pub(super) const OLD_PORT: Parameter = Parameter::required(
    "port",
    ParameterType::Word(&["_dev_ttymxc0", "/dev/ttymxc0", "/dev/ttyS2"]),
    phrase("the port of the control box", "控制柜的端口"),
)
.or(ParameterDefault::Text("_dev_ttymxc0"));

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin::new(
        Serial,
        "5.31",
        "tool_serial_is_open",
        &[],
        phrase("bool", "bool"),
        phrase(
            "Whether the serial port of the tool is open.",
            "工具串口是否已打开。",
        ),
        |call| is_open(call, Port::Tool),
    ),
    Builtin::new(
        Serial,
        "5.32",
        "tool_serial_config",
        &[
            ENABLED,
            TOOL_BAUD_RATE,
            PARITY,
            STOP_BITS,
            TOOL_SIZE,
            MODBUS_RTU,
            USAGE,
        ],
        phrase(
            "bool, True when the port is open",
            "bool，端口已打开为 True",
        ),
        phrase(
            "Opens or closes the serial port of the tool.",
            "打开或关闭工具串口。",
        ),
        |call| config(call, Port::Tool),
    ),
    Builtin::new(
        Serial,
        "5.33",
        "tool_serial_read",
        &[READ_COUNT, IS_NUMBER, TIME_OUT],
        phrase(
            "list[int] or bytes: what came in time",
            "list[int] 或 bytes：限时内收到的内容",
        ),
        phrase(
            "Reads from the serial port of the tool.",
            "从工具串口读取。",
        ),
        |call| read(call, Port::Tool),
    )
    .waiting(),
    Builtin::new(
        Serial,
        "5.34",
        "tool_serial_write",
        &[WRITE_DATA],
        phrase(
            "int, bytes sent; 0 or less is a failure",
            "int，已发送的字节数；不大于 0 为失败",
        ),
        phrase("Writes to the serial port of the tool.", "向工具串口写入。"),
        |call| {
            let sent = write(call, Port::Tool)?;
            Ok(Value::Int(sent as i64))
        },
    ),
    Builtin::new(
        Serial,
        "8.1.1",
        "tool_serial_mode",
        &[],
        phrase(
            "str: MODBUS-RTU, RS485 or CLOSE",
            "str：MODBUS-RTU、RS485 或 CLOSE",
        ),
        phrase(
            "What the serial port of the tool is used for.",
            "工具串口当前的用途。",
        ),
        |call| mode_name(call, Port::Tool),
    ),
    Builtin::new(
        Serial,
        "8.1.2",
        "masterboard_serial_config",
        &[
            ENABLE,
            BAUD_OR_DEFAULT,
            PARITY_OR_DEFAULT,
            STOP_BIT_OR_DEFAULT,
            SIZE_OR_DEFAULT,
            MODBUS_RTU,
        ],
        phrase("bool, True when configured", "bool，配置成功为 True"),
        phrase(
            "Opens or closes the serial port of the control box.",
            "打开或关闭控制柜串口。",
        ),
        |call| config(call, Port::Masterboard),
    ),
    Builtin::new(
        Serial,
        "8.1.3",
        "masterboard_serial_read",
        &[READ_COUNT, IS_NUMBER_OR_DEFAULT, TIMEOUT_OR_DEFAULT],
        phrase(
            "list[int] or bytes: what came in time",
            "list[int] 或 bytes：限时内收到的内容",
        ),
        phrase(
            "Reads from the serial port of the control box.",
            "从控制柜串口读取。",
        ),
        |call| read(call, Port::Masterboard),
    )
    .waiting(),
    Builtin::new(
        Serial,
        "8.1.4",
        "masterboard_serial_write",
        &[DATA],
        phrase("bool, True when sent", "bool，已发送为 True"),
        phrase(
            "Writes to the serial port of the control box.",
            "向控制柜串口写入。",
        ),
        write_masterboard,
    ),
    Builtin::new(
        Serial,
        "8.1.5",
        "masterboard_serial_mode",
        &[],
        phrase(
            "int: 0 closed, 1 RS-485, 2 Modbus RTU",
            "int：0 关闭，1 RS-485，2 Modbus RTU",
        ),
        phrase(
            "What the serial port of the control box is used for.",
            "控制柜串口当前的用途。",
        ),
        |call| {
            Ok(Value::Int(
                match Port::Masterboard.line(call.context().fieldbus()).mode() {
                    SerialMode::Closed => 0,
                    SerialMode::Raw => 1,
                    SerialMode::Rtu => 2,
                },
            ))
        },
    ),
    Builtin::new(
        Serial,
        "8.1.6",
        "masterboard_serial_flush",
        &[],
        phrase("nothing", "无返回值"),
        phrase(
            "Drops what the port of the control box has received and nobody has read.",
            "丢弃控制柜串口已收到而未读取的内容。",
        ),
        flush,
    ),
    Builtin::new(
        Serial,
        "2.14.5",
        "serial_config",
        &[
            ENABLE,
            OLD_BAUD,
            OLD_PARITY,
            OLD_STOP_BIT,
            OLD_SIZE,
            OLD_MODBUS_RTU,
            OLD_PORT,
        ],
        phrase("bool, True when configured", "bool，配置成功为 True"),
        phrase(
            "As masterboard_serial_config, in the edition 2.14.5.",
            "同 masterboard_serial_config（2.14.5 版的名称）。",
        ),
        |call| {
            call.word(6)?;
            config(call, Port::Masterboard)
        },
    ),
    Builtin::new(
        Serial,
        "2.14.5",
        "serial_read",
        &[LEN, IS_NUMBER_OR_DEFAULT, OLD_TIME_OUT, OLD_PORT],
        phrase(
            "list[int] or bytes: what came in time",
            "list[int] 或 bytes：限时内收到的内容",
        ),
        phrase(
            "As masterboard_serial_read, in the edition 2.14.5.",
            "同 masterboard_serial_read（2.14.5 版的名称）。",
        ),
        |call| {
            call.word(3)?;
            read(call, Port::Masterboard)
        },
    )
    .waiting(),
    Builtin::new(
        Serial,
        "2.14.5",
        "serial_write",
        &[DATA, OLD_PORT],
        phrase("bool, True when sent", "bool，已发送为 True"),
        phrase(
            "As masterboard_serial_write, in the edition 2.14.5.",
            "同 masterboard_serial_write（2.14.5 版的名称）。",
        ),
        |call| {
            call.word(1)?;
            write_masterboard(call)
        },
    ),
    Builtin::new(
        Serial,
        "2.14.5",
        "serial_is_open",
        &[OLD_PORT],
        phrase("bool", "bool"),
        phrase(
            "Whether the serial port of the control box is open, in the edition 2.14.5.",
            "控制柜串口是否已打开（2.14.5 版的名称）。",
        ),
        |call| {
            call.word(0)?;
            is_open(call, Port::Masterboard)
        },
    ),
    Builtin::new(
        Serial,
        "2.14.5",
        "serial_mode",
        &[OLD_PORT],
        phrase(
            "str: MODBUS-RTU, RS485 or CLOSE",
            "str：MODBUS-RTU、RS485 或 CLOSE",
        ),
        phrase(
            "What the serial port of the control box is used for, in the edition 2.14.5.",
            "控制柜串口当前的用途（2.14.5 版的名称）。",
        ),
        |call| {
            call.word(0)?;
            mode_name(call, Port::Masterboard)
        },
    ),
    Builtin::new(
        Serial,
        "2.14.5",
        "serial_flush",
        &[OLD_PORT],
        phrase("nothing", "无返回值"),
        phrase(
            "As masterboard_serial_flush, in the edition 2.14.5.",
            "同 masterboard_serial_flush（2.14.5 版的名称）。",
        ),
        |call| {
            call.word(0)?;
            flush(call)
        },
    ),
];

fn is_open(call: &mut Call<'_, '_>, port: Port) -> Result<Value, Unwind> {
    Ok(Value::Bool(
        port.line(call.context().fieldbus()).mode() != SerialMode::Closed,
    ))
}

fn mode_name(call: &mut Call<'_, '_>, port: Port) -> Result<Value, Unwind> {
    Ok(Value::str(
        match port.line(call.context().fieldbus()).mode() {
            SerialMode::Closed => "CLOSE",
            SerialMode::Raw => "RS485",
            SerialMode::Rtu => "MODBUS-RTU",
        },
    ))
}

/// Ends the program with an alarm when the port belongs to a plug-in.
pub(super) fn check_not_daemon(call: &mut Call<'_, '_>, port: Port) -> Result<(), Unwind> {
    match port.line(call.context().fieldbus()).settings() {
        Some(settings) if settings.is_daemon_owned => Err(call.alarm(
            USED_BY_DAEMON,
            &text!(
                "the serial port is in Daemon use (usage 1), scripts cannot access it",
                "串口由 Daemon 使用（usage 1），脚本不能访问"
            ),
        )),
        _ => Ok(()),
    }
}

/// What a line does for a program is done on the thread of the line: what passes between the two is not in the account
/// of the task, which gets copies of results and of what is said of errors.
pub(super) fn on_line_thread<T: Clone + 'static, E: Localized>(
    call: &mut Call<'_, '_>,
    work: impl Future<Output = Result<T, E>> + 'static,
) -> Result<Result<T, Text>, Unwind> {
    let work = async move { work.await.map_err(|error| Text::of(&error)) };
    let theirs = call.wait_for_future(UnmeteredFuture(Box::pin(work)))?;
    // Copies of a text share its words.
    let own = match &theirs {
        Ok(result) => Ok(result.clone()),
        Err(said) => Err(Text::of(said)),
    };
    task_memory::uncounted(|| drop(theirs));
    Ok(own)
}

/// A future whose steps allocate and free for others.
struct UnmeteredFuture<F>(Pin<Box<F>>);

impl<F: Future> Future for UnmeteredFuture<F> {
    type Output = F::Output;

    fn poll(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<F::Output> {
        task_memory::uncounted(|| self.0.as_mut().poll(context))
    }
}

fn config(call: &mut Call<'_, '_>, port: Port) -> Result<Value, Unwind> {
    let enable = call.boolean(0)?;
    let modbus_rtu = call.boolean(5)?;
    let settings = SerialSettings {
        // The lists of rates lie within 32 bits.
        baud_rate: u32::try_from(call.integer(1)?).unwrap_or_default(),
        parity: call.byte(2)?,
        stop_bits: call.byte(3)?,
        data_bits: match call.byte(4)? {
            _ if modbus_rtu => 8,
            bits => bits,
        },
        modbus_rtu,
        is_daemon_owned: matches!(port, Port::Tool) && call.byte(6)? == 1,
    };
    let fieldbus = Arc::clone(call.context().fieldbus());
    let wanted = enable.then_some(settings);
    let done = on_line_thread(
        call,
        async move { port.line(&fieldbus).configure(wanted).await },
    )?;
    if let Err(error) = &done {
        call.warn(&error);
    }
    Ok(Value::Bool(match port {
        // The open state of the port; for the other whether it was configured.
        Port::Tool => enable && done.is_ok(),
        Port::Masterboard => done.is_ok(),
    }))
}

fn read(call: &mut Call<'_, '_>, port: Port) -> Result<Value, Unwind> {
    let count = usize::try_from(call.integer(0)?).unwrap_or_default();
    let (as_numbers, patience) = (call.boolean(1)?, call.patience(2)?);
    check_not_daemon(call, port)?;
    let fieldbus = Arc::clone(call.context().fieldbus());
    let received = on_line_thread(call, async move {
        port.line(&fieldbus).read(count, patience).await
    })?;
    let bytes = received.unwrap_or_else(|error| {
        call.warn(&error);
        Vec::new()
    });
    Ok(if as_numbers {
        Value::list(
            bytes
                .into_iter()
                .map(|byte| Value::Int(byte.into()))
                .collect(),
        )
    } else {
        Value::bytes(bytes)
    })
}

fn write(call: &mut Call<'_, '_>, port: Port) -> Result<usize, Unwind> {
    let value = call.required(0);
    // The low 8 bits, as the manual says.
    let low = |value: &Value| value.as_i64().map(|number| number as u8);
    let bytes = match (value.as_str(), value.as_bytes(), value.as_items()) {
        (Some(text), ..) => Some(text.as_bytes().to_vec()),
        (_, Some(bytes), _) => Some(bytes),
        (.., Some(items)) => items.iter().map(low).collect(),
        _ => low(&value).map(|byte| vec![byte]),
    };
    let Some(bytes) = bytes else {
        return Err(call.not_this_type(
            0,
            &text!(
                "a text, an integer, a list of integers, bytes or a bytearray",
                "文本、整数、整数的列表、bytes 或 bytearray"
            ),
        ));
    };
    check_not_daemon(call, port)?;
    let fieldbus = Arc::clone(call.context().fieldbus());
    let theirs = task_memory::uncounted(|| bytes.clone());
    let sent = on_line_thread(
        call,
        async move { port.line(&fieldbus).write(theirs).await },
    )?;
    Ok(sent.unwrap_or_else(|error| {
        call.warn(&error);
        0
    }))
}

fn write_masterboard(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let sent = write(call, Port::Masterboard)?;
    Ok(Value::Bool(sent > 0))
}

fn flush(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let fieldbus = Arc::clone(call.context().fieldbus());
    let done = on_line_thread(call, async move {
        // Everything written has left already: writes wait for that.
        let flush = fieldbus.masterboard_serial.flush();
        match tokio::time::timeout(FLUSH_TIME, flush).await {
            Ok(done) => done.map_err(|error| Text::of(&error)),
            Err(_elapsed) => Err(text!(
                "another thread is reading from the port",
                "另一个线程正在读取该串口"
            )),
        }
    })?;
    if let Err(error) = done {
        call.warn(&error);
    }
    Ok(Value::None)
}

/// How long a flush waits for a read of another thread.
const FLUSH_TIME: Duration = Duration::from_secs(1);
