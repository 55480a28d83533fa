//! Setting an input from outside: what a value has to be, and what it does. Pure.
//!
//! Names are those of the cell file ([`Point`]). Outputs are the robot's own.

use core::fmt;

use motion_api::{IoChange, IoConfig, IoPoint, RegisterBank};
use thiserror::Error;

use crate::cell::point::{Direction, Point};

/// A value as somebody gave it.
#[derive(Clone, Debug, PartialEq)]
pub enum InputValue {
    /// True or false.
    Level(bool),
    /// A whole number.
    Whole(i64),
    /// Any other number.
    Number(f64),
    /// Anything else, as it is to be shown.
    Other(String),
}

impl fmt::Display for InputValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Level(level) => write!(f, "{level}"),
            Self::Whole(number) => write!(f, "{number}"),
            Self::Number(number) => write!(f, "{number}"),
            Self::Other(text) => f.write_str(text),
        }
    }
}

/// What setting an input does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InputChange {
    /// A digital or an analog input, at the beginning of a cycle.
    Point(IoChange),
    /// A register, which has its value at once.
    Register(RegisterValue),
}

/// A value for an input register.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RegisterValue {
    /// `input_boolean_register`
    Boolean(u8, bool),
    /// `input_integer_register`
    Integer(u8, i32),
    /// `input_float_register`
    Float(u8, f64),
}

impl RegisterValue {
    /// Writes it.
    pub fn write(self, bank: &RegisterBank) {
        match self {
            Self::Boolean(n, level) => bank.set_boolean(n, level),
            Self::Integer(n, value) => bank.set_integer(n, value),
            Self::Float(n, value) => bank.set_float(n, value),
        }
    }
}

/// Why an input was not set: one sentence that names the point, what was given and what is allowed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum InputError {
    /// No such point.
    #[error("{0}")]
    NoPoint(String),
    /// An output.
    #[error("{0} is an output; only inputs can be set from outside")]
    Output(Point),
    /// A pin of the tool that reads nothing.
    #[error("{0} reads nothing: the pin is disabled or an output")]
    NotReadable(Point),
    /// The value does not fit.
    #[error("{point} is {given}; it must be {allowed}")]
    Value {
        /// Which point.
        point: Point,
        /// As given.
        given: String,
        /// What is allowed.
        allowed: String,
    },
}

impl InputChange {
    /// Setting the input called `name`. `config` tells domains and pins.
    ///
    /// # Errors
    /// [`InputError`]
    pub fn new(name: &str, value: &InputValue, config: &IoConfig) -> Result<Self, InputError> {
        let point: Point = name.parse().map_err(InputError::NoPoint)?;
        if point.direction == Direction::Out {
            return Err(InputError::Output(point));
        }
        let wrong = |allowed: String| InputError::Value {
            point,
            given: value.to_string(),
            allowed,
        };
        let level = || match value {
            InputValue::Level(level) => Ok(*level),
            _ => Err(wrong("true or false".to_owned())),
        };
        let number = || match value {
            InputValue::Whole(number) => Some(*number as f64),
            InputValue::Number(number) => Some(*number),
            _ => None,
        };
        Ok(match point.io_point() {
            IoPoint::Digital(bit) => {
                if config.readable() >> bit & 1 == 0 {
                    return Err(InputError::NotReadable(point));
                }
                let (mask, levels) = (1 << bit, u32::from(level()?) << bit);
                Self::Point(IoChange::DigitalIn { mask, levels })
            }
            IoPoint::Analog(port) => {
                // Three ports, three domains.
                let domain = config.analog_in[usize::from(port)];
                let most = domain.measurable_max();
                let unit = if most > 1.0 { "V" } else { "A" };
                let value = number().filter(|x| (0.0..=most).contains(x));
                let allowed = || wrong(format!("a number from 0 to {most} {unit}"));
                let value = value.ok_or_else(allowed)?;
                Self::Point(IoChange::AnalogIn { port, value })
            }
            IoPoint::BooleanRegister(n) => Self::Register(RegisterValue::Boolean(n, level()?)),
            IoPoint::IntegerRegister(n) => {
                let whole = match value {
                    InputValue::Whole(number) => i32::try_from(*number).ok(),
                    _ => None,
                };
                let allowed = || wrong(format!("a whole number from {} to {}", i32::MIN, i32::MAX));
                Self::Register(RegisterValue::Integer(n, whole.ok_or_else(allowed)?))
            }
            IoPoint::FloatRegister(n) => {
                let value = number().filter(|x| x.is_finite());
                let value = value.ok_or_else(|| wrong("a number".to_owned()))?;
                Self::Register(RegisterValue::Float(n, value))
            }
        })
    }
}
