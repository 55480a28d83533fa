//! Manual 6.1: Modbus signals, and the controller's own coils and registers.
//!
//! Signals belong to the controller: they outlive the program that added them. Reading one waits only for its first answer.

use std::sync::Arc;
use std::time::Duration;

use elite_lang::{ExceptionKind, Raised, Value};
use io_bus::modbus::pdu::Request;
use io_bus::modbus::{DeviceAddress, ModbusError, SignalKind, SignalSpec};
use motion_api::RunStateChoice;

use super::call::Call;
use super::declare::{Builtin, Category::Modbus, Default, Kind, Parameter, Range};

const IP: Parameter = Parameter::required("IP", Kind::Text, "address of the device");
const SLAVE: Parameter = Parameter::required(
    "slave_number",
    Kind::Integer(0, 255),
    "unit, normally 255; 248 to 254 mean 255, 0 is a broadcast",
);
const ADDRESS: Parameter = Parameter::required(
    "signal_address",
    Kind::Integer(0, 65535),
    "first coil or register",
);
const TYPE: Parameter = Parameter::required(
    "signal_type",
    Kind::Integer(0, 3),
    "0 digital input, 1 digital output, 2 register input, 3 register output",
);
const NAME: Parameter = Parameter::required("signal_name", Kind::Text, "name of the signal");
const SEQUENTIAL: Parameter = Parameter::required(
    "is_sequential",
    Kind::Boolean,
    "update signals in the order they were added",
)
.or(Default::Boolean(false));
const COUNT: Parameter = Parameter::required(
    "registers_count",
    Kind::Integer(1, 123),
    "coils or registers in a row",
)
.or(Default::Integer(1));
const PORT: Parameter =
    Parameter::required("port", Kind::Integer(1, 65535), "TCP port of the device")
        .or(Default::Integer(502));
const READ_ADDRESS: Parameter = Parameter::required(
    "read_address",
    Kind::Integer(0, 65535),
    "first register to read",
);
const READ_COUNT: Parameter = Parameter::required(
    "read_register_count",
    Kind::Integer(1, 123),
    "registers to read",
);
const WRITE_ADDRESS: Parameter = Parameter::required(
    "write_address",
    Kind::Integer(0, 65535),
    "first register to write",
);
const WRITE_COUNT: Parameter = Parameter::required(
    "write_register_count",
    Kind::Integer(1, 121),
    "registers to write",
);
const SECONDARY: Parameter = Parameter::required(
    "is_secondary_program",
    Kind::Boolean,
    "taken for compatibility; changes nothing",
)
.or(Default::Boolean(false));
const FUNCTION: Parameter =
    Parameter::required("function_code", Kind::Integer(1, 127), "function code");
const DATA: Parameter = Parameter::required(
    "data",
    Kind::Checked("list[int]"),
    "bytes after the function code, 0 to 255 each, at most 252",
);
const ONESHOT: Parameter = Parameter::required(
    "oneshot",
    Kind::Boolean,
    "True sends once; False again and again, 10 times a second, until modbus_reset_connection()",
)
.or(Default::Boolean(true));
const REGISTER_VALUE: Parameter = Parameter::required(
    "register_value",
    Kind::Checked("int or list[int]"),
    "value or values; their low 16 bits are written",
);
const DIGITAL_VALUE: Parameter = Parameter::required(
    "digital_value",
    Kind::Checked("bool or list[bool]"),
    "level or levels",
);
const CHOICE: Parameter = Parameter::required(
    "runstate_choice",
    Kind::Integer(0, 3),
    "0 keep; 1 low when not running; 2 high when not running; 3 high while running, low otherwise",
);
const FREQUENCY: Parameter = Parameter::required(
    "update_frequency",
    Kind::Integer(0, 250),
    "updates a second; 0 stops",
)
.in_unit("Hz");
const WATCHDOG: Parameter = Parameter::required(
    "timeout",
    Kind::Number(Range::Between(0.0, 300.0)),
    "time without a good answer before access raises",
)
.in_unit("s");
const SOURCE: Parameter = Parameter::required(
    "error_source",
    Kind::Integer(0, 2),
    "0 both, 1 device, 2 connection",
)
.or(Default::Integer(0));
const CONNECTION: Parameter =
    Parameter::required("connection_id", Kind::Text, "address of the device");
const BLOCKING: Parameter = Parameter::required(
    "is_blocking",
    Kind::Boolean,
    "wait for the connection, at most 3 s",
)
.or(Default::Boolean(true));
const COIL: Parameter = Parameter::required("address", Kind::Integer(0, 127), "coil");
const REGISTER: Parameter =
    Parameter::required("address", Kind::Integer(0, 255), "holding register");
const SIGNED: Parameter = Parameter::required(
    "is_signed",
    Kind::Boolean,
    "True: -32768 to 32767, False: 0 to 65535",
)
.or(Default::Boolean(false));
const LEVEL: Parameter = Parameter::required("value", Kind::Boolean, "level");
const WORD: Parameter = Parameter::required("value", Kind::Integer(-32768, 65535), "value");

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin::new(
        Modbus,
        "6.1.1",
        "modbus_add_signal",
        &[IP, SLAVE, ADDRESS, TYPE, NAME, SEQUENTIAL, COUNT, PORT],
        "nothing",
        "Adds a signal of a Modbus device, or replaces the one of that name.",
        modbus_add_signal,
    ),
    Builtin::new(
        Modbus,
        "6.1.2",
        "modbus_delete_signal",
        &[NAME],
        "nothing",
        "Removes a signal.",
        modbus_delete_signal,
    ),
    Builtin::new(
        Modbus,
        "6.1.3",
        "modbus_add_rw_signal",
        &[
            IP,
            SLAVE,
            READ_ADDRESS,
            READ_COUNT,
            WRITE_ADDRESS,
            WRITE_COUNT,
            NAME,
            SEQUENTIAL,
            PORT,
        ],
        "nothing",
        "Adds a signal that reads and writes registers with function 23.",
        modbus_add_rw_signal,
    ),
    Builtin::new(
        Modbus,
        "6.1.4",
        "modbus_get_signal_status",
        &[NAME, SECONDARY],
        "bool for a coil, int for a register, a list for several",
        "Value of a signal; waits for its first answer, at most its watchdog.",
        modbus_get_signal_status,
    ),
    Builtin::new(
        Modbus,
        "6.1.5",
        "modbus_send_custom_command",
        &[IP, SLAVE, FUNCTION, DATA, ONESHOT, PORT],
        "nothing",
        "Sends a function with its bytes; the answer is not looked at.",
        modbus_send_custom_command,
    ),
    Builtin::new(
        Modbus,
        "6.1.6",
        "modbus_set_output_register",
        &[NAME, REGISTER_VALUE],
        "nothing",
        "Sets a register output; from then on it is written, not read.",
        modbus_set_output_register,
    ),
    Builtin::new(
        Modbus,
        "6.1.7",
        "modbus_set_output_signal",
        &[NAME, DIGITAL_VALUE],
        "nothing",
        "Sets a digital output; from then on it is written, not read.",
        modbus_set_output_signal,
    ),
    Builtin::new(
        Modbus,
        "6.1.8",
        "modbus_set_runstate_dependent_choice",
        &[NAME, CHOICE],
        "nothing",
        "What a digital output does when no program runs.",
        modbus_set_runstate_dependent_choice,
    ),
    Builtin::new(
        Modbus,
        "6.1.9",
        "modbus_set_signal_update_frequency",
        &[NAME, FREQUENCY],
        "nothing",
        "How often a signal is updated.",
        modbus_set_signal_update_frequency,
    ),
    Builtin::new(
        Modbus,
        "6.1.10",
        "modbus_set_signal_watchdog",
        &[NAME, WATCHDOG],
        "nothing",
        "How long a signal may be without a good answer before access raises; 5 s at first.",
        modbus_set_signal_watchdog,
    ),
    Builtin::new(
        Modbus,
        "6.1.11",
        "read_port_bit",
        &[COIL],
        "bool",
        "A coil of the controller's own Modbus server.",
        read_port_bit,
    ),
    Builtin::new(
        Modbus,
        "6.1.12",
        "read_port_register",
        &[REGISTER, SIGNED],
        "int",
        "A register of the controller's own Modbus server.",
        read_port_register,
    ),
    Builtin::new(
        Modbus,
        "6.1.13",
        "write_port_bit",
        &[COIL, LEVEL],
        "nothing",
        "Sets a coil of the controller's own Modbus server.",
        write_port_bit,
    ),
    Builtin::new(
        Modbus,
        "6.1.14",
        "write_port_register",
        &[REGISTER, WORD],
        "nothing",
        "Sets a register of the controller's own Modbus server.",
        write_port_register,
    ),
    Builtin::new(
        Modbus,
        "6.1.15",
        "modbus_get_error",
        &[NAME, SOURCE],
        "list[int]: device and connection code, or one of them",
        "Error codes of a signal (table 6-2 and errno).",
        modbus_get_error,
    ),
    Builtin::new(
        Modbus,
        "6.1.16",
        "modbus_get_time_since_signal_invalid",
        &[NAME],
        "float, s; 0 for a valid signal",
        "Time since the last good answer.",
        modbus_get_time_since_signal_invalid,
    ),
    Builtin::new(
        Modbus,
        "6.1.17",
        "modbus_reset_connection",
        &[CONNECTION, BLOCKING, PORT],
        "nothing",
        "Closes the connection to a device and opens it again.",
        modbus_reset_connection,
    )
    .waiting(),
];

/// The exception for what the client refuses: a wrong argument or a state.
fn check<T>(
    call: &mut Call<'_, '_>,
    function: &str,
    result: Result<T, ModbusError>,
) -> Result<T, Raised> {
    result.map_err(|error| {
        let kind = match error {
            ModbusError::Length { .. } | ModbusError::BroadcastRead => ExceptionKind::ValueError,
            _ => ExceptionKind::RuntimeError,
        };
        call.error(kind, format!("{function}(): {error}"))
    })
}

fn word(call: &mut Call<'_, '_>, index: usize) -> Result<u16, Raised> {
    // The declared ranges lie within 16 bits.
    Ok(u16::try_from(call.integer(index)?).unwrap_or_default())
}

fn device(call: &mut Call<'_, '_>, host: usize, port: usize) -> Result<DeviceAddress, Raised> {
    let (host, port) = (call.text(host)?, word(call, port)?);
    call.check_net()?;
    Ok(DeviceAddress { host, port })
}

fn slave(call: &mut Call<'_, '_>, index: usize) -> Result<u8, Raised> {
    Ok(match call.byte(index)? {
        248..=255 => 255,
        slave => slave,
    })
}

fn last_address(call: &mut Call<'_, '_>, at: usize, first: u16, count: u16) -> Result<(), Raised> {
    if u32::from(first) + u32::from(count) <= 65536 {
        return Ok(());
    }
    let allowed = format!("at most {} for {count} values", 65536 - u32::from(count));
    Err(call.not_allowed(at, &allowed, first))
}

fn modbus_add_signal(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let spec = SignalSpec {
        device: device(call, 0, 7)?,
        slave: slave(call, 1)?,
        address: word(call, 2)?,
        count: word(call, 6)?,
        kind: match call.byte(3)? {
            0 => SignalKind::DigitalInput,
            1 => SignalKind::DigitalOutput,
            2 => SignalKind::RegisterInput,
            _ => SignalKind::RegisterOutput,
        },
        is_sequential: call.boolean(5)?,
    };
    last_address(call, 2, spec.address, spec.count)?;
    let name = call.text(4)?;
    let added = call.context().fieldbus().modbus.add(&name, spec);
    check(call, "modbus_add_signal", added)?;
    Ok(Value::None)
}

fn modbus_add_rw_signal(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let (write_address, write_count) = (word(call, 4)?, word(call, 5)?);
    let spec = SignalSpec {
        device: device(call, 0, 8)?,
        slave: slave(call, 1)?,
        address: word(call, 2)?,
        count: word(call, 3)?,
        kind: SignalKind::ReadWrite {
            write_address,
            write_count,
        },
        is_sequential: call.boolean(7)?,
    };
    last_address(call, 2, spec.address, spec.count)?;
    last_address(call, 4, write_address, write_count)?;
    let name = call.text(6)?;
    let added = call.context().fieldbus().modbus.add(&name, spec);
    check(call, "modbus_add_rw_signal", added)?;
    Ok(Value::None)
}

fn modbus_delete_signal(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let name = call.text(0)?;
    let deleted = call.context().fieldbus().modbus.delete(&name);
    check(call, "modbus_delete_signal", deleted)?;
    Ok(Value::None)
}

fn modbus_get_signal_status(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let name = call.text(0)?;
    call.boolean(1)?;
    let fieldbus = Arc::clone(call.context().fieldbus());
    let status = call.outside(async move { fieldbus.modbus.status(&name).await })?;
    let (values, is_bits) = check(call, "modbus_get_signal_status", status)?;
    let value = |word: &u16| match is_bits {
        true => Value::Bool(*word != 0),
        false => Value::Int((*word).into()),
    };
    Ok(match values.as_slice() {
        [single] => value(single),
        several => Value::list(several.iter().map(value).collect()),
    })
}

fn modbus_send_custom_command(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let device = device(call, 0, 5)?;
    let (slave, function) = (call.byte(1)?, call.byte(2)?);
    let repeats = !call.boolean(4)?;
    let Some(items) = call.required(3).as_items() else {
        return Err(call.not_this_type(3, "a list of bytes (0 to 255)"));
    };
    let bytes = items.iter().map(|item| u8::try_from(item.as_i64()?).ok());
    let data = match bytes.collect::<Option<Vec<u8>>>() {
        Some(data) if data.len() <= 252 => data,
        _ => {
            let shown = call.native().repr(&Value::list(items))?;
            return Err(call.not_allowed(3, "at most 252 integers from 0 to 255", shown));
        }
    };
    let request = Request::Custom(function, data);
    let sent = call
        .context()
        .fieldbus()
        .modbus
        .send_custom(device, slave, request, repeats);
    check(call, "modbus_send_custom_command", sent)?;
    Ok(Value::None)
}

/// One value or a list of them.
fn one_or_more(call: &mut Call<'_, '_>, index: usize) -> Vec<Value> {
    let value = call.required(index);
    value.as_items().unwrap_or_else(|| vec![value])
}

fn modbus_set_output_register(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let name = call.text(0)?;
    let values = one_or_more(call, 1);
    // The low 16 bits, as the manual says.
    let words: Option<Vec<u16>> = values
        .iter()
        .map(|value| Some(value.as_i64()? as u16))
        .collect();
    let Some(words) = words else {
        return Err(call.not_this_type(1, "an integer or a list of integers"));
    };
    let set = call
        .context()
        .fieldbus()
        .modbus
        .set_registers(&name, &words);
    check(call, "modbus_set_output_register", set)?;
    Ok(Value::None)
}

fn modbus_set_output_signal(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let name = call.text(0)?;
    let levels: Option<Vec<bool>> = one_or_more(call, 1).iter().map(Value::as_bool).collect();
    let Some(levels) = levels else {
        return Err(call.not_this_type(1, "True, False or a list of them"));
    };
    let set = call.context().fieldbus().modbus.set_coils(&name, &levels);
    check(call, "modbus_set_output_signal", set)?;
    Ok(Value::None)
}

fn modbus_set_runstate_dependent_choice(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let (name, choice) = (call.text(0)?, RunStateChoice::from_number(call.byte(1)?));
    let set = call
        .context()
        .fieldbus()
        .modbus
        .set_run_state(&name, choice);
    check(call, "modbus_set_runstate_dependent_choice", set)?;
    Ok(Value::None)
}

fn modbus_set_signal_update_frequency(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let (name, hertz) = (call.text(0)?, call.byte(1)?);
    let set = call
        .context()
        .fieldbus()
        .modbus
        .set_frequency(&name, hertz.into());
    check(call, "modbus_set_signal_update_frequency", set)?;
    Ok(Value::None)
}

fn modbus_set_signal_watchdog(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let (name, time) = (call.text(0)?, call.number(1)?);
    let time = Duration::from_secs_f64(time);
    let set = call.context().fieldbus().modbus.set_watchdog(&name, time);
    check(call, "modbus_set_signal_watchdog", set)?;
    Ok(Value::None)
}

fn modbus_get_error(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let (name, source) = (call.text(0)?, call.byte(1)?);
    let codes = call.context().fieldbus().modbus.error_codes(&name);
    let [device, connection] = check(call, "modbus_get_error", codes)?.map(i64::from);
    Ok(match source {
        0 => Value::list_of_i64(&[device, connection]),
        1 => Value::list_of_i64(&[device]),
        _ => Value::list_of_i64(&[connection]),
    })
}

fn modbus_get_time_since_signal_invalid(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let name = call.text(0)?;
    let time = call.context().fieldbus().modbus.time_since_invalid(&name);
    let time = check(call, "modbus_get_time_since_signal_invalid", time)?;
    Ok(Value::Float(time.as_secs_f64()))
}

fn modbus_reset_connection(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let (device, wait) = (device(call, 0, 2)?, call.boolean(1)?);
    let fieldbus = Arc::clone(call.context().fieldbus());
    let reset = call.outside(async move { fieldbus.modbus.reset(&device, wait).await })?;
    check(call, "modbus_reset_connection", reset)?;
    Ok(Value::None)
}

/// The declared ranges are those of the image, so its errors do not happen; they are passed on all the same.
fn port<T>(call: &mut Call<'_, '_>, result: Result<T, io_bus::PortError>) -> Result<T, Raised> {
    result.map_err(|error| call.error(ExceptionKind::ValueError, error.to_string()))
}

fn read_port_bit(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let address = call.integer(0)?;
    let level = call.context().fieldbus().port_image.read_bit(address);
    Ok(Value::Bool(port(call, level)?))
}

fn read_port_register(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let (address, signed) = (call.integer(0)?, call.boolean(1)?);
    let word = call.context().fieldbus().port_image.read_register(address);
    let word = port(call, word)?;
    Ok(Value::Int(if signed {
        word.cast_signed().into()
    } else {
        word.into()
    }))
}

fn write_port_bit(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let (address, level) = (call.integer(0)?, call.boolean(1)?);
    let written = call
        .context()
        .fieldbus()
        .port_image
        .write_bit(address, level);
    port(call, written)?;
    Ok(Value::None)
}

fn write_port_register(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let (address, value) = (call.integer(0)?, call.integer(1)?);
    let written = call
        .context()
        .fieldbus()
        .port_image
        .write_register(address, value);
    port(call, written)?;
    Ok(Value::None)
}
