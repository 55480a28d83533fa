//! What the functions of manual 6.1 do.

use std::sync::Arc;
use std::time::Duration;

use elite_lang::{ExceptionKind, Unwind, Value};
use io_bus::modbus::pdu::Request;
use io_bus::modbus::{DeviceAddress, ModbusError, SignalKind, SignalSpec};
use io_bus::modbus_server::map::{Map, meaning_of_coil, meaning_of_word};
use io_bus::modbus_server::tables::{ModbusException, Space, Tables};
use messages::{Text, text};
use motion_api::RunStateChoice;

use super::super::call::Call;
use crate::port_map::ProgramMap;
use crate::task::Wait;

/// The exception for what the client refuses: a wrong argument or a state.
fn check<T>(
    call: &mut Call<'_, '_>,
    function: &str,
    result: Result<T, ModbusError>,
) -> Result<T, Unwind> {
    result.map_err(|error| {
        let kind = match error {
            ModbusError::Length { .. } | ModbusError::BroadcastRead => ExceptionKind::ValueError,
            _ => ExceptionKind::RuntimeError,
        };
        call.error(
            kind,
            text!("{function}(): {error}", "{function}()：{error}"),
        )
    })
}

fn word(call: &mut Call<'_, '_>, index: usize) -> Result<u16, Unwind> {
    // The declared ranges lie within 16 bits.
    Ok(u16::try_from(call.integer(index)?).unwrap_or_default())
}

fn device(call: &mut Call<'_, '_>, host: usize, port: usize) -> Result<DeviceAddress, Unwind> {
    let (host, port) = (call.text(host)?, word(call, port)?);
    call.check_net()?;
    call.check_simulated(&host, port)?;
    // Signals of a device that no test plays are updated on a thread of their own, by the time of the machine.
    call.context().has_stand_in(&host, port);
    Ok(DeviceAddress { host, port })
}

fn slave(call: &mut Call<'_, '_>, index: usize) -> Result<u8, Unwind> {
    Ok(match call.byte(index)? {
        248..=255 => 255,
        slave => slave,
    })
}

fn last_address(call: &mut Call<'_, '_>, at: usize, first: u16, count: u16) -> Result<(), Unwind> {
    if u32::from(first) + u32::from(count) <= 65536 {
        return Ok(());
    }
    let allowed = text!(
        "at most {} for {count} values",
        "不超过 {}（{count} 个值）",
        65536 - u32::from(count)
    );
    Err(call.not_allowed(at, &allowed, first))
}

pub(super) fn modbus_add_signal(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
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
    let added =
        task_memory::clone_uncounted(|| call.context().fieldbus().modbus.add(&name, spec.clone()));
    check(call, "modbus_add_signal", added)?;
    Ok(Value::None)
}

pub(super) fn modbus_add_rw_signal(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
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
    let added =
        task_memory::clone_uncounted(|| call.context().fieldbus().modbus.add(&name, spec.clone()));
    check(call, "modbus_add_rw_signal", added)?;
    Ok(Value::None)
}

pub(super) fn modbus_delete_signal(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let name = call.text(0)?;
    let deleted = task_memory::clone_uncounted(|| call.context().fieldbus().modbus.delete(&name));
    check(call, "modbus_delete_signal", deleted)?;
    Ok(Value::None)
}

pub(super) fn modbus_get_signal_status(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let name = call.text(0)?;
    call.boolean(1)?;
    let fieldbus = Arc::clone(call.context().fieldbus());
    let status = call.wait_for_future(async move { fieldbus.modbus.status(&name).await })?;
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

pub(super) fn modbus_send_custom_command(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let device = device(call, 0, 5)?;
    let (slave, function) = (call.byte(1)?, call.byte(2)?);
    let repeats = !call.boolean(4)?;
    let Some(items) = call.required(3).as_items() else {
        return Err(call.not_this_type(
            3,
            &text!("a list of bytes (0 to 255)", "字节（0 到 255）的列表"),
        ));
    };
    let bytes = items.iter().map(|item| u8::try_from(item.as_i64()?).ok());
    let data = match bytes.collect::<Option<Vec<u8>>>() {
        Some(data) if data.len() <= 252 => data,
        _ => {
            let shown = call.native().repr(&Value::list(items))?;
            return Err(call.not_allowed(
                3,
                &text!(
                    "at most 252 integers from 0 to 255",
                    "不超过 252 个 0 到 255 的整数"
                ),
                shown,
            ));
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

pub(super) fn modbus_set_output_register(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let name = call.text(0)?;
    let values = one_or_more(call, 1);
    // The low 16 bits, as the manual says.
    let words: Option<Vec<u16>> = values
        .iter()
        .map(|value| Some(value.as_i64()? as u16))
        .collect();
    let Some(words) = words else {
        return Err(call.not_this_type(
            1,
            &text!("an integer or a list of integers", "整数或整数的列表"),
        ));
    };
    let set = call
        .context()
        .fieldbus()
        .modbus
        .set_registers(&name, &words);
    check(call, "modbus_set_output_register", set)?;
    Ok(Value::None)
}

pub(super) fn modbus_set_output_signal(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let name = call.text(0)?;
    let levels: Option<Vec<bool>> = one_or_more(call, 1).iter().map(Value::as_bool).collect();
    let Some(levels) = levels else {
        return Err(call.not_this_type(
            1,
            &text!("True, False or a list of them", "True、False 或它们的列表"),
        ));
    };
    let set =
        task_memory::clone_uncounted(|| call.context().fieldbus().modbus.set_coils(&name, &levels));
    check(call, "modbus_set_output_signal", set)?;
    Ok(Value::None)
}

pub(super) fn modbus_set_runstate_dependent_choice(
    call: &mut Call<'_, '_>,
) -> Result<Value, Unwind> {
    let (name, choice) = (call.text(0)?, RunStateChoice::from_number(call.byte(1)?));
    let set = call
        .context()
        .fieldbus()
        .modbus
        .set_run_state(&name, choice);
    check(call, "modbus_set_runstate_dependent_choice", set)?;
    Ok(Value::None)
}

pub(super) fn modbus_set_signal_update_frequency(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (name, hertz) = (call.text(0)?, call.byte(1)?);
    let set = call
        .context()
        .fieldbus()
        .modbus
        .set_frequency(&name, hertz.into());
    check(call, "modbus_set_signal_update_frequency", set)?;
    Ok(Value::None)
}

pub(super) fn modbus_set_signal_watchdog(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (name, time) = (call.text(0)?, call.number(1)?);
    let time = Duration::from_secs_f64(time);
    let set =
        task_memory::clone_uncounted(|| call.context().fieldbus().modbus.set_watchdog(&name, time));
    check(call, "modbus_set_signal_watchdog", set)?;
    Ok(Value::None)
}

pub(super) fn modbus_get_error(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
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
) -> Result<Value, Unwind> {
    let name = call.text(0)?;
    let time = call.context().fieldbus().modbus.time_since_invalid(&name);
    let time = check(call, "modbus_get_time_since_signal_invalid", time)?;
    Ok(Value::Float(time.as_secs_f64()))
}

pub(super) fn modbus_reset_connection(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (device, wait) = (device(call, 0, 2)?, call.boolean(1)?);
    let fieldbus = Arc::clone(call.context().fieldbus());
    let reset = call.wait_for_future(async move { fieldbus.modbus.reset(&device, wait).await })?;
    check(call, "modbus_reset_connection", reset)?;
    Ok(Value::None)
}

/// The robot behind its own Modbus map.
fn map<'a>(call: &'a Call<'_, '_>) -> Map<ProgramMap<'a>> {
    Map(ProgramMap {
        view: call.context().robot(),
        image: &call.context().fieldbus().port_image,
        origin: call.origin(),
    })
}

/// The declared ranges are those of addresses.
fn address(call: &mut Call<'_, '_>) -> Result<u16, Unwind> {
    Ok(u16::try_from(call.integer(0)?).unwrap_or(u16::MAX))
}

/// Does what a client of the map could do; where the robot takes no command just now, in one of the next cycles.
fn on_map<T>(
    call: &mut Call<'_, '_>,
    act: impl Fn(&Map<ProgramMap<'_>>) -> Result<T, ModbusException>,
) -> Result<Result<T, ModbusException>, Unwind> {
    loop {
        let done = act(&map(call));
        match done {
            Err(ModbusException::DeviceBusy) => {
                let next = call.context().robot().moment().cycle + 1;
                call.wait(Wait::Cycle(next))?;
            }
            done => return Ok(done),
        }
    }
}

fn no_word(call: &mut Call<'_, '_>, address: u16) -> Unwind {
    let text = text!(
        "there is no word {address} in the controller's Modbus map",
        "控制器的 Modbus 表中没有字 {address}"
    );
    call.error(ExceptionKind::ValueError, text)
}

pub(super) fn read_port_bit(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let address = address(call)?;
    let levels = map(call).read_bits(Space::Outputs, address, 1);
    // The declared range is within the map.
    Ok(Value::Bool(levels.is_ok_and(|levels| levels == [true])))
}

pub(super) fn read_port_register(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (address, signed) = (address(call)?, call.boolean(1)?);
    let words = map(call).read_words(Space::Outputs, address, 1);
    let Ok(&[word]) = words.as_deref() else {
        return Err(no_word(call, address));
    };
    Ok(Value::Int(if signed {
        word.cast_signed().into()
    } else {
        word.into()
    }))
}

/// The manual's own example writes a bit that the map has as an input, so what cannot be written is told without ending
/// the program.
pub(super) fn write_port_bit(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (address, level) = (address(call)?, call.boolean(1)?);
    let written = on_map(call, |map| map.write_bits(address, &[level]))?;
    if written.is_err()
        && call
            .context()
            .is_first_warning(&format!("write_port_bit {address}"))
    {
        let what = meaning_of_coil(address).map_or_else(
            || text!("it has no known meaning", "含义未知"),
            Text::verbatim,
        );
        call.warn(&text!(
            "bit {address} cannot be switched ({what}); it stays as it is",
            "第 {address} 位不能切换（{what}），保持不变"
        ));
    }
    Ok(Value::None)
}

pub(super) fn write_port_register(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (address, value) = (address(call)?, call.integer(1)?);
    // The declared range is that of signed and unsigned words together.
    let word = value as u16;
    let text = match on_map(call, |map| map.write_words(address, &[word]))? {
        Ok(()) => return Ok(Value::None),
        Err(ModbusException::IllegalValue) => {
            let what = meaning_of_word(address).unwrap_or_default();
            text!(
                "{value} is not allowed for word {address} ({what})",
                "字 {address} 不允许取值 {value}（{what}）"
            )
        }
        Err(_) => match meaning_of_word(address) {
            Some(what) => text!(
                "word {address} cannot be set to {value}: {what}",
                "字 {address} 不能设为 {value}：{what}"
            ),
            None => return Err(no_word(call, address)),
        },
    };
    Err(call.error(ExceptionKind::ValueError, text))
}
