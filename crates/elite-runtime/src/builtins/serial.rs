//! Manual 5.31 to 5.34 and 8.1: RS-485 at the tool connector and in the control box.
//!
//! A line that is closed, in the other mode or broken makes reads empty and writes fail by value, with a line in the
//! log; arguments outside their range raise. The functions of the 2.14.5 edition mean the port of the control box.

use std::fmt::Display;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;

use elite_lang::{Unwind, Value};
use io_bus::Fieldbus;
use io_bus::serial::{SerialLine, SerialMode, SerialSettings};

use super::call::Call;
use super::declare::{
    Builtin, Category::Serial, Parameter, ParameterDefault, ParameterType, Range,
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

const ENABLED: Parameter =
    Parameter::required("enabled", ParameterType::Boolean, "open or close the port");
const TOOL_BAUD_RATE: Parameter =
    Parameter::required("baud_rate", TOOL_BAUD, "baud rate").in_unit("baud");
const PARITY: Parameter = Parameter::required(
    "parity",
    ParameterType::Integer(0, 2),
    "0 none, 1 odd, 2 even",
)
.also(&["parity_bit"]);
const STOP_BITS: Parameter =
    Parameter::required("stop_bits", ParameterType::Integer(1, 2), "stop bits");
const TOOL_SIZE: Parameter = Parameter::required("size", ParameterType::OneOf(&[8]), "data bits")
    .or(ParameterDefault::Integer(8))
    .in_unit("bit");
const MODBUS_RTU: Parameter = Parameter::required(
    "modbus_rtu",
    ParameterType::Boolean,
    "True: Modbus RTU, False: bytes",
)
.or(ParameterDefault::Boolean(false));
const USAGE: Parameter = Parameter::required(
    "usage",
    ParameterType::Integer(0, 1),
    "0 scripts use the port, 1 a plug-in does",
)
.or(ParameterDefault::Integer(0));
const ENABLE: Parameter =
    Parameter::required("enable", ParameterType::Boolean, "open or close the port");
const BAUD_OR_DEFAULT: Parameter = Parameter::required("baud", BAUD, "baud rate")
    .or(ParameterDefault::Integer(115_200))
    .in_unit("baud");
const PARITY_OR_DEFAULT: Parameter = PARITY.or(ParameterDefault::Integer(1));
const STOP_BIT_OR_DEFAULT: Parameter =
    Parameter::required("stop_bit", ParameterType::Integer(1, 2), "stop bits")
        .or(ParameterDefault::Integer(1));
const SIZE_OR_DEFAULT: Parameter = Parameter::required(
    "size",
    ParameterType::Integer(7, 8),
    "data bits; 8 for Modbus RTU",
)
.or(ParameterDefault::Integer(8))
.in_unit("bit");
const OLD_BAUD: Parameter = Parameter::required("baud", BAUD, "baud rate").in_unit("baud");
const OLD_PARITY: Parameter = Parameter::required(
    "parity_bit",
    ParameterType::Integer(0, 2),
    "0 none, 1 odd, 2 even",
)
.also(&["parity"]);
const OLD_STOP_BIT: Parameter =
    Parameter::required("stop_bit", ParameterType::Integer(1, 2), "stop bits");
const OLD_SIZE: Parameter = Parameter::required(
    "size",
    ParameterType::Integer(7, 8),
    "data bits; 8 for Modbus RTU",
)
.in_unit("bit");
const OLD_MODBUS_RTU: Parameter = Parameter::required(
    "modbus_rtu",
    ParameterType::Boolean,
    "True: Modbus RTU, False: bytes",
);
const READ_COUNT: Parameter = Parameter::required(
    "read_count",
    ParameterType::Integer(0, READ_BYTES_MAX),
    "bytes to read",
);
const LEN: Parameter = Parameter::required(
    "len",
    ParameterType::Integer(0, READ_BYTES_MAX),
    "bytes to read",
);
const IS_NUMBER: Parameter = Parameter::required(
    "is_number",
    ParameterType::Boolean,
    "True: a list of integers, False: bytes",
);
const IS_NUMBER_OR_DEFAULT: Parameter = IS_NUMBER.or(ParameterDefault::Boolean(true));
const TIME_OUT: Parameter = Parameter::required(
    "time_out",
    ParameterType::Number(Range::Any),
    "0 or less waits for ever",
)
.also(&["timeout"])
.in_unit("s");
const OLD_TIME_OUT: Parameter = TIME_OUT.or(ParameterDefault::Number(0.1));
const TIMEOUT_OR_DEFAULT: Parameter = Parameter::required(
    "timeout",
    ParameterType::Number(Range::Any),
    "0 or less waits for ever",
)
.also(&["time_out"])
.or(ParameterDefault::Number(0.1))
.in_unit("s");
const DATA_KIND: ParameterType = ParameterType::Custom("str, int, list[int], bytes or bytearray");
const WRITE_DATA: Parameter = Parameter::required(
    "write_data",
    DATA_KIND,
    "what to send; the low 8 bits of integers",
);
const DATA: Parameter = Parameter::required(
    "data",
    DATA_KIND,
    "what to send; the low 8 bits of integers",
);
/// The device of the 2.14.5 edition; every name the editions use is the port of the control box.
pub(super) const OLD_PORT: Parameter = Parameter::required(
    "port",
    ParameterType::Word(&["_dev_ttymxc0", "/dev/ttymxc0", "/dev/ttyS2"]),
    "the port of the control box",
)
.or(ParameterDefault::Text("_dev_ttymxc0"));

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin::new(
        Serial,
        "5.31",
        "tool_serial_is_open",
        &[],
        "bool",
        "Whether the serial port of the tool is open.",
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
        "bool, True when the port is open",
        "Opens or closes the serial port of the tool.",
        |call| config(call, Port::Tool),
    ),
    Builtin::new(
        Serial,
        "5.33",
        "tool_serial_read",
        &[READ_COUNT, IS_NUMBER, TIME_OUT],
        "list[int] or bytes: what came in time",
        "Reads from the serial port of the tool.",
        |call| read(call, Port::Tool),
    )
    .waiting(),
    Builtin::new(
        Serial,
        "5.34",
        "tool_serial_write",
        &[WRITE_DATA],
        "int, bytes sent; 0 or less is a failure",
        "Writes to the serial port of the tool.",
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
        "str: MODBUS-RTU, RS485 or CLOSE",
        "What the serial port of the tool is used for.",
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
        "bool, True when configured",
        "Opens or closes the serial port of the control box.",
        |call| config(call, Port::Masterboard),
    ),
    Builtin::new(
        Serial,
        "8.1.3",
        "masterboard_serial_read",
        &[READ_COUNT, IS_NUMBER_OR_DEFAULT, TIMEOUT_OR_DEFAULT],
        "list[int] or bytes: what came in time",
        "Reads from the serial port of the control box.",
        |call| read(call, Port::Masterboard),
    )
    .waiting(),
    Builtin::new(
        Serial,
        "8.1.4",
        "masterboard_serial_write",
        &[DATA],
        "bool, True when sent",
        "Writes to the serial port of the control box.",
        write_masterboard,
    ),
    Builtin::new(
        Serial,
        "8.1.5",
        "masterboard_serial_mode",
        &[],
        "int: 0 closed, 1 RS-485, 2 Modbus RTU",
        "What the serial port of the control box is used for.",
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
        "nothing",
        "Drops what the port of the control box has received and nobody has read.",
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
        "bool, True when configured",
        "As masterboard_serial_config, in the edition 2.14.5.",
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
        "list[int] or bytes: what came in time",
        "As masterboard_serial_read, in the edition 2.14.5.",
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
        "bool, True when sent",
        "As masterboard_serial_write, in the edition 2.14.5.",
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
        "bool",
        "Whether the serial port of the control box is open, in the edition 2.14.5.",
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
        "str: MODBUS-RTU, RS485 or CLOSE",
        "What the serial port of the control box is used for, in the edition 2.14.5.",
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
        "nothing",
        "As masterboard_serial_flush, in the edition 2.14.5.",
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
            "the serial port is in Daemon use (usage 1), scripts cannot access it",
        )),
        _ => Ok(()),
    }
}

/// What a line does for a program is done on the thread of the line: what passes between the two is not in the account
/// of the task, which gets copies of results and of what is said of errors.
pub(super) fn on_line_thread<T: Clone + 'static, E: Display>(
    call: &mut Call<'_, '_>,
    work: impl Future<Output = Result<T, E>> + 'static,
) -> Result<Result<T, String>, Unwind> {
    let work = async move { work.await.map_err(|error| error.to_string()) };
    let theirs = call.wait_for_future(UnmeteredFuture(Box::pin(work)))?;
    let own = theirs.clone();
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
        call.warn(error);
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
        call.warn(error);
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
            "a text, an integer, a list of integers, bytes or a bytearray",
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
        call.warn(error);
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
            Ok(done) => done.map_err(|error| error.to_string()),
            Err(_elapsed) => Err("another thread is reading from the port".to_owned()),
        }
    })?;
    if let Err(error) = done {
        call.warn(error);
    }
    Ok(Value::None)
}

/// How long a flush waits for a read of another thread.
const FLUSH_TIME: Duration = Duration::from_secs(1);
