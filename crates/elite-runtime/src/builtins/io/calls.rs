//! What the functions of manual chapter 5 do.

use elite_lang::{Unwind, Value};
use messages::text;
use motion_api::io::TOOL_ANALOG;
use motion_api::{
    AnalogDomain, DigitalBank, InputAction, IoChange, IoImage, RunStateChoice, ToolPin,
};

use super::super::call::Call;

/// Sub code of the alarm "wrong I/O type".
const WRONG_IO_TYPE: i32 = 1;

pub(super) fn image(call: &Call<'_, '_>) -> IoImage {
    call.context().robot().io()
}

fn change(call: &mut Call<'_, '_>, change: IoChange) -> Result<Value, Unwind> {
    call.change(change)?;
    Ok(Value::None)
}

pub(super) fn digital_in(call: &mut Call<'_, '_>, bank: DigitalBank) -> Result<Value, Unwind> {
    let bit = bank.bit(call.byte(0)?);
    Ok(Value::Bool(image(call).digital_in >> bit & 1 == 1))
}

pub(super) fn digital_out(call: &mut Call<'_, '_>, bank: DigitalBank) -> Result<Value, Unwind> {
    let bit = bank.bit(call.byte(0)?);
    Ok(Value::Bool(image(call).digital_out >> bit & 1 == 1))
}

pub(super) fn set_digital_out(call: &mut Call<'_, '_>, bank: DigitalBank) -> Result<Value, Unwind> {
    let index = call.byte(0)?;
    let level = call.boolean(1)?;
    change(call, IoChange::digital_out(bank, index, level))
}

pub(super) fn set_standard_digital_out(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    // Programs of the pendant give -1 for no output (from controller output, not from the manual).
    if call.integer(0)? == -1 {
        return call.boolean(1).map(|_level| Value::None);
    }
    set_digital_out(call, DigitalBank::Standard)
}

pub(super) fn standard_analog_in(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let port = usize::from(call.byte(0)?);
    Ok(Value::Float(image(call).analog_in[port]))
}

pub(super) fn standard_analog_out(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let port = usize::from(call.byte(0)?);
    Ok(Value::Float(image(call).analog_out()[port]))
}

pub(super) fn set_standard_analog_out(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (port, ratio) = (call.byte(0)?, call.number(1)?.clamp(0.0, 1.0));
    change(call, IoChange::AnalogOut { port, ratio })
}

fn domain(call: &mut Call<'_, '_>, index: usize) -> Result<AnalogDomain, Unwind> {
    Ok(AnalogDomain::from_number(call.byte(index)?))
}

pub(super) fn set_standard_analog_output_domain(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (port, domain) = (call.byte(0)?, domain(call, 1)?);
    change(call, IoChange::AnalogOutDomain { port, domain })
}

pub(super) fn set_standard_analog_input_domain(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (port, domain) = (call.byte(0)?, domain(call, 1)?);
    change(call, IoChange::AnalogInDomain { port, domain })
}

pub(super) fn set_tool_analog_input_domain(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (port, domain) = (TOOL_ANALOG, domain(call, 0)?);
    change(call, IoChange::AnalogInDomain { port, domain })
}

pub(super) fn set_tool_analog_output_domain(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (port, domain) = (TOOL_ANALOG, domain(call, 0)?);
    change(call, IoChange::AnalogOutDomain { port, domain })
}

pub(super) fn set_tool_digital(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (index, level) = (call.byte(0)?, call.boolean(1)?);
    let pin = image(call).config.tool_pins[usize::from(index)];
    let trouble = match pin {
        ToolPin { enabled: false, .. } => text!("disabled", "停用的"),
        ToolPin {
            is_output: false, ..
        } => text!("an input", "输入"),
        _ => return change(call, IoChange::digital_out(DigitalBank::Tool, index, level)),
    };
    let text = text!(
        "wrong I/O type: tool pin {index} is {trouble}, it must be an enabled output",
        "I/O 类型错误：工具引脚 {index} 是{trouble}，必须是启用的输出"
    );
    Err(call.alarm(WRONG_IO_TYPE, &text))
}

pub(super) fn get_tool_digital(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let index = call.byte(0)?;
    Ok(Value::Bool(image(call).tool_digital(index)))
}

pub(super) fn set_tool_analog_io_work_mode(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let mode = call.byte(0)?;
    change(call, IoChange::ToolAnalogMode(mode))
}

pub(super) fn set_tool_digital_io_config(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (index, mode) = (call.byte(0)?, call.byte(1)?);
    let pin = ToolPin {
        mode,
        enabled: call.boolean(2)?,
        is_output: call.boolean(3)?,
    };
    change(call, IoChange::ToolPin { index, pin })
}

fn choice(call: &mut Call<'_, '_>, index: usize) -> Result<RunStateChoice, Unwind> {
    Ok(RunStateChoice::from_number(call.byte(index)?))
}

pub(super) fn set_runstate(call: &mut Call<'_, '_>, bank: DigitalBank) -> Result<Value, Unwind> {
    let (bit, choice) = (bank.bit(call.byte(0)?), choice(call, 1)?);
    change(call, IoChange::DigitalOutRunState { bit, choice })
}

pub(super) fn set_runstate_gp_boolean_output(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (index, choice) = (call.byte(0)?, choice(call, 1)?);
    change(call, IoChange::BooleanRegisterRunState { index, choice })
}

pub(super) fn set_runstate_standard_analog_output(
    call: &mut Call<'_, '_>,
) -> Result<Value, Unwind> {
    let (port, choice) = (call.byte(0)?, choice(call, 1)?);
    change(call, IoChange::AnalogOutRunState { port, choice })
}

pub(super) fn set_runstate_tool_analog_output(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (port, choice) = (TOOL_ANALOG, choice(call, 0)?);
    change(call, IoChange::AnalogOutRunState { port, choice })
}

pub(super) fn set_input_actions_to_default(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    change(call, IoChange::InputActionsToDefault)
}

fn action(call: &mut Call<'_, '_>, index: usize) -> Result<InputAction, Unwind> {
    Ok(match call.word(index)? {
        0 => InputAction::Default,
        _ => InputAction::Freedrive,
    })
}

pub(super) fn set_action(call: &mut Call<'_, '_>, bank: DigitalBank) -> Result<Value, Unwind> {
    let (bit, action) = (bank.bit(call.byte(0)?), action(call, 1)?);
    change(call, IoChange::DigitalInAction { bit, action })
}

pub(super) fn set_gp_boolean_input_action(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (index, action) = (call.byte(0)?, action(call, 1)?);
    change(call, IoChange::BooleanRegisterAction { index, action })
}

pub(super) fn set_tool_voltage(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let volts = call.byte(0)?;
    change(call, IoChange::ToolVoltage(volts))
}
