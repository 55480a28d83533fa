//! Registers in a recording: written again as they were.

use motion_api::{IoPoint, Registers};
use recorder::{IoMessage, IoValue};

use crate::cell::point::{IoDirection, IoPointName};

/// A register that has another value from a cycle on. Also those that the cycle itself writes are recorded; writing
/// them again changes nothing.
#[derive(Clone, Debug)]
pub struct RegisterWrite {
    /// The cycle that saw it first.
    pub cycle: u64,
    point: IoPointName,
    value: IoValue,
}

impl RegisterWrite {
    /// `None` for points that the cycles carry themselves.
    pub fn from_message(change: &IoMessage) -> Option<Self> {
        let point: IoPointName = change.name.parse().ok()?;
        let is_register = !matches!(point.io_point(), IoPoint::Digital(_) | IoPoint::Analog(_));
        is_register.then_some(Self {
            cycle: change.cycle,
            point,
            value: change.value,
        })
    }

    /// Writes the value into the register.
    pub fn apply(&self, registers: &Registers) {
        let bank = match self.point.direction {
            IoDirection::In => &registers.input,
            IoDirection::Out => &registers.output,
        };
        match (self.point.io_point(), self.value) {
            (IoPoint::BooleanRegister(n), IoValue::Level(level)) => bank.set_boolean(n, level),
            // Written from an i32.
            (IoPoint::IntegerRegister(n), IoValue::Integer(value)) => {
                bank.set_integer(n, value as i32);
            }
            (IoPoint::FloatRegister(n), IoValue::Number(value)) => bank.set_float(n, value),
            (IoPoint::FloatRegister(n), IoValue::Integer(value)) => {
                bank.set_float(n, value as f64);
            }
            // A recording that somebody else wrote; the comparison will tell.
            _ => {}
        }
    }
}
