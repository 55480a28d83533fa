//! Inputs, outputs and registers that have another value than one cycle before, and the names of the points.

use motion_api::registers::{BOOLEAN_REGISTERS, FLOAT_REGISTERS, INTEGER_REGISTERS};
use motion_api::{RegisterImage, RegisterImages, RobotState};

use crate::topics::{IoMessage, IoValue};

/// The changes from `before` to `now`; the first state is compared with everything low and zero.
pub(crate) fn between(before: Option<&RobotState>, now: &RobotState) -> Vec<IoMessage> {
    let (digital_in, digital_out) = before.map_or((0, 0), |s| (s.digital_in, s.digital_out));
    let (analog_in, analog_out) =
        before.map_or(([0.0; 3], [0.0; 3]), |s| (s.analog_in, s.analog_out));
    let mut changes = Vec::new();
    for (direction, old, new) in [
        ("in", digital_in, now.digital_in),
        ("out", digital_out, now.digital_out),
    ] {
        let mut changed = old ^ new;
        while changed != 0 {
            let bit = changed.trailing_zeros();
            changed &= changed - 1;
            changes.push(IoMessage {
                cycle: now.cycle,
                name: digital_name(direction, bit),
                value: IoValue::Level(new >> bit & 1 == 1),
            });
        }
    }
    for (direction, old, new) in [
        ("in", analog_in, now.analog_in),
        ("out", analog_out, now.analog_out),
    ] {
        for (index, (old, new)) in old.into_iter().zip(new).enumerate() {
            if old.to_bits() != new.to_bits() {
                changes.push(IoMessage {
                    cycle: now.cycle,
                    name: analog_name(direction, index),
                    value: IoValue::Number(new),
                });
            }
        }
    }
    changes
}

/// The registers that `cycle` found changed.
pub(crate) fn of_registers(
    cycle: u64,
    before: &RegisterImages,
    now: &RegisterImages,
) -> Vec<IoMessage> {
    let mut changes = Vec::new();
    let sides = [
        ("input", &before.input, &now.input),
        ("output", &before.output, &now.output),
    ];
    for (side, old, new) in sides {
        let mut compare = |kind: &str, count: u8, value: fn(&RegisterImage, u8) -> IoValue| {
            for n in 0..count {
                if !is_same(value(old, n), value(new, n)) {
                    let name = format!("{side}_{kind}_register[{n}]");
                    let value = value(new, n);
                    changes.push(IoMessage { cycle, name, value });
                }
            }
        };
        compare("boolean", BOOLEAN_REGISTERS, |image, n| {
            IoValue::Level(image.boolean(n))
        });
        compare("integer", INTEGER_REGISTERS, |image, n| {
            IoValue::Integer(image.integer(n).into())
        });
        compare("float", FLOAT_REGISTERS, |image, n| {
            IoValue::Number(image.float(n))
        });
    }
    changes
}

/// Bit for bit: NaN is the same as itself, and -0 is not 0.
fn is_same(a: IoValue, b: IoValue) -> bool {
    match (a, b) {
        (IoValue::Number(a), IoValue::Number(b)) => a.to_bits() == b.to_bits(),
        (a, b) => a == b,
    }
}

/// Name of a bit of the digital masks: 0-15 standard, 16-23 configurable, 24-27 tool.
fn digital_name(direction: &str, bit: u32) -> String {
    match bit {
        0..16 => format!("standard_digital_{direction}[{bit}]"),
        16..24 => format!("configurable_digital_{direction}[{}]", bit - 16),
        _ => format!("tool_digital_{direction}[{}]", bit - 24),
    }
}

fn analog_name(direction: &str, index: usize) -> String {
    match index {
        0 | 1 => format!("standard_analog_{direction}[{index}]"),
        _ => format!("tool_analog_{direction}"),
    }
}
