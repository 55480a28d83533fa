//! What the functions of manual 6.1 do.

use std::sync::Arc;
use std::time::Duration;

use elite_lang::{ExceptionKind, Raised, Value, memory};
use io_bus::modbus::pdu::Request;
use io_bus::modbus::{DeviceAddress, ModbusError, SignalKind, SignalSpec};
use motion_api::RunStateChoice;

use super::super::call::Call;

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
    call.check_played(&host, port)?;
    // Signals of a device that no test plays are updated on a thread of their own, by the time of the machine.
    call.context().has_stand_in(&host, port);
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

pub(super) fn modbus_add_signal(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
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
    let added = memory::copied(|| call.context().fieldbus().modbus.add(&name, spec.clone()));
    check(call, "modbus_add_signal", added)?;
    Ok(Value::None)
}

pub(super) fn modbus_add_rw_signal(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
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
    let added = memory::copied(|| call.context().fieldbus().modbus.add(&name, spec.clone()));
    check(call, "modbus_add_rw_signal", added)?;
    Ok(Value::None)
}

pub(super) fn modbus_delete_signal(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let name = call.text(0)?;
    let deleted = memory::copied(|| call.context().fieldbus().modbus.delete(&name));
    check(call, "modbus_delete_signal", deleted)?;
    Ok(Value::None)
}

pub(super) fn modbus_get_signal_status(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
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

pub(super) fn modbus_send_custom_command(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
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

pub(super) fn modbus_set_output_register(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
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

pub(super) fn modbus_set_output_signal(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let name = call.text(0)?;
    let levels: Option<Vec<bool>> = one_or_more(call, 1).iter().map(Value::as_bool).collect();
    let Some(levels) = levels else {
        return Err(call.not_this_type(1, "True, False or a list of them"));
    };
    let set = memory::copied(|| call.context().fieldbus().modbus.set_coils(&name, &levels));
    check(call, "modbus_set_output_signal", set)?;
    Ok(Value::None)
}

pub(super) fn modbus_set_runstate_dependent_choice(
    call: &mut Call<'_, '_>,
) -> Result<Value, Raised> {
    let (name, choice) = (call.text(0)?, RunStateChoice::from_number(call.byte(1)?));
    let set = call
        .context()
        .fieldbus()
        .modbus
        .set_run_state(&name, choice);
    check(call, "modbus_set_runstate_dependent_choice", set)?;
    Ok(Value::None)
}

pub(super) fn modbus_set_signal_update_frequency(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let (name, hertz) = (call.text(0)?, call.byte(1)?);
    let set = call
        .context()
        .fieldbus()
        .modbus
        .set_frequency(&name, hertz.into());
    check(call, "modbus_set_signal_update_frequency", set)?;
    Ok(Value::None)
}

pub(super) fn modbus_set_signal_watchdog(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let (name, time) = (call.text(0)?, call.number(1)?);
    let time = Duration::from_secs_f64(time);
    let set = memory::copied(|| call.context().fieldbus().modbus.set_watchdog(&name, time));
    check(call, "modbus_set_signal_watchdog", set)?;
    Ok(Value::None)
}

pub(super) fn modbus_get_error(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let (name, source) = (call.text(0)?, call.byte(1)?);
    let codes = call.context().fieldbus().modbus.error_codes(&name);
    let [device, connection] = check(call, "modbus_get_error", codes)?.map(i64::from);
    Ok(match source {
        0 => Value::list_of_i64(&[device, connection]),
        1 => Value::list_of_i64(&[device]),
        _ => Value::list_of_i64(&[connection]),
    })
}

pub(super) fn modbus_get_time_since_signal_invalid(
    call: &mut Call<'_, '_>,
) -> Result<Value, Raised> {
    let name = call.text(0)?;
    let time = call.context().fieldbus().modbus.time_since_invalid(&name);
    let time = check(call, "modbus_get_time_since_signal_invalid", time)?;
    Ok(Value::Float(time.as_secs_f64()))
}

pub(super) fn modbus_reset_connection(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
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

pub(super) fn read_port_bit(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let address = call.integer(0)?;
    let level = call.context().fieldbus().port_image.read_bit(address);
    Ok(Value::Bool(port(call, level)?))
}

pub(super) fn read_port_register(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let (address, signed) = (call.integer(0)?, call.boolean(1)?);
    let word = call.context().fieldbus().port_image.read_register(address);
    let word = port(call, word)?;
    Ok(Value::Int(if signed {
        word.cast_signed().into()
    } else {
        word.into()
    }))
}

pub(super) fn write_port_bit(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let (address, level) = (call.integer(0)?, call.boolean(1)?);
    let written = call
        .context()
        .fieldbus()
        .port_image
        .write_bit(address, level);
    port(call, written)?;
    Ok(Value::None)
}

pub(super) fn write_port_register(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let (address, value) = (call.integer(0)?, call.integer(1)?);
    let written = call
        .context()
        .fieldbus()
        .port_image
        .write_register(address, value);
    port(call, written)?;
    Ok(Value::None)
}
