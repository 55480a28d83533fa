//! Inputs, outputs and registers by the names of the cell file: what one reads now, and what setting one does.
//!
//! Owns which values a point takes, and the sentence where one does not fit. Pure: who carries a change out, and who
//! may ask for which, is its callers' business.

use core::fmt;

use messages::{Localized, Text, text};
use motion_api::{IoChange, IoConfig, IoImage, IoPoint, RegisterBank, Registers};
use thiserror::Error;

use crate::cell::point::{IoDirection, IoPointName};

/// What a point reads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointReading {
    /// Level of a digital point or a boolean register.
    Level(bool),
    /// Value of an integer register.
    Whole(i32),
    /// Of an analog point, in its unit, or a float register.
    Number(f64),
}

impl PointReading {
    /// The value as the next read of a program would see it.
    pub fn new(point: IoPointName, io: &IoImage, registers: &Registers) -> Self {
        let is_input = point.direction == IoDirection::In;
        let bank = match is_input {
            true => &registers.input,
            false => &registers.output,
        };
        match point.io_point() {
            IoPoint::Digital(bit) => {
                let levels = match is_input {
                    true => io.digital_in,
                    false => io.digital_out,
                };
                Self::Level(levels >> bit & 1 == 1)
            }
            IoPoint::Analog(port) => {
                let values = match is_input {
                    true => io.analog_in,
                    false => io.analog_out(),
                };
                // Three ports, three values.
                Self::Number(values[usize::from(port)])
            }
            IoPoint::BooleanRegister(n) => Self::Level(bank.boolean(n)),
            IoPoint::IntegerRegister(n) => Self::Whole(bank.integer(n)),
            IoPoint::FloatRegister(n) => Self::Number(bank.float(n)),
        }
    }
}

/// A value as somebody gave it.
#[derive(Clone, Debug, PartialEq)]
pub enum PointValue {
    /// True or false.
    Level(bool),
    /// A whole number.
    Whole(i64),
    /// Any other number.
    Number(f64),
    /// Anything else, as it is to be shown.
    Other(String),
}

impl PointValue {
    const fn number(&self) -> Option<f64> {
        match self {
            Self::Whole(number) => Some(*number as f64),
            Self::Number(number) => Some(*number),
            Self::Level(_) | Self::Other(_) => None,
        }
    }
}

impl fmt::Display for PointValue {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Level(level) => write!(f, "{level}"),
            Self::Whole(number) => write!(f, "{number}"),
            Self::Number(number) => write!(f, "{number}"),
            Self::Other(text) => f.write_str(text),
        }
    }
}

/// What setting a point does.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointChange {
    /// A digital or an analog point, at the beginning of a cycle.
    Io(IoChange),
    /// A register, which has its value at once.
    Register(IoDirection, RegisterValue),
}

/// A value for a register.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RegisterValue {
    /// `…_boolean_register`
    Boolean(u8, bool),
    /// `…_integer_register`
    Integer(u8, i32),
    /// `…_float_register`
    Float(u8, f64),
}

impl RegisterValue {
    /// Writes the value into the register.
    pub fn write(self, direction: IoDirection, registers: &Registers) {
        let bank: &RegisterBank = match direction {
            IoDirection::In => &registers.input,
            IoDirection::Out => &registers.output,
        };
        match self {
            Self::Boolean(n, level) => bank.set_boolean(n, level),
            Self::Integer(n, value) => bank.set_integer(n, value),
            Self::Float(n, value) => bank.set_float(n, value),
        }
    }
}

/// A reason why a point was not set: one sentence that names it, what was given and what is allowed.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
pub enum PointError {
    /// No such point.
    #[error("{0}")]
    NoPoint(Text),
    /// An output.
    #[error("{0} is an output; only inputs can be set from outside")]
    #[zh("{0} 是输出；从外部只能设置输入")]
    Output(IoPointName),
    /// An input.
    #[error("{0} is an input; only outputs can be set here")]
    #[zh("{0} 是输入；这里只能设置输出")]
    Input(IoPointName),
    /// An input pin of the tool that reads nothing.
    #[error("{0} reads nothing: the pin is disabled or an output")]
    #[zh("{0} 读不到值：该引脚已停用或为输出")]
    NotReadable(IoPointName),
    /// An output pin of the tool that drives nothing.
    #[error("{0} drives nothing: the pin is disabled or an input")]
    #[zh("{0} 不起作用：该引脚已停用或为输入")]
    NotDrivable(IoPointName),
    /// The value does not fit.
    #[error("{point} is {given}; it must be {allowed}")]
    #[zh("{point} 为 {given}；应为{allowed}")]
    Value {
        /// The point.
        point: IoPointName,
        /// The value as it was given.
        given: String,
        /// What is allowed.
        allowed: Text,
    },
}

impl PointChange {
    /// Setting the input called `name` from outside. `config` tells domains and pins.
    ///
    /// # Errors
    /// [`PointError`]
    pub fn of_input(name: &str, value: &PointValue, config: &IoConfig) -> Result<Self, PointError> {
        let point: IoPointName = name.parse().map_err(PointError::NoPoint)?;
        match point.direction {
            IoDirection::In => Self::new(point, value, config),
            IoDirection::Out => Err(PointError::Output(point)),
        }
    }

    /// Setting the output called `name` by hand. `config` tells domains and pins.
    ///
    /// # Errors
    /// [`PointError`]
    pub fn of_output(
        name: &str,
        value: &PointValue,
        config: &IoConfig,
    ) -> Result<Self, PointError> {
        let point: IoPointName = name.parse().map_err(PointError::NoPoint)?;
        match point.direction {
            IoDirection::Out => Self::new(point, value, config),
            IoDirection::In => Err(PointError::Input(point)),
        }
    }

    /// Setting a point: of an input from outside, of an output as a client of a port does. `config` tells domains and
    /// pins.
    ///
    /// # Errors
    /// [`PointError`] but for `NoPoint`, `Output` and `Input`.
    pub fn new(
        point: IoPointName,
        value: &PointValue,
        config: &IoConfig,
    ) -> Result<Self, PointError> {
        let wrong = |allowed: Text| PointError::Value {
            point,
            given: value.to_string(),
            allowed,
        };
        let level = || match value {
            PointValue::Level(level) => Ok(*level),
            _ => Err(wrong(text!("true or false", "true 或 false"))),
        };
        let register = |value| Self::Register(point.direction, value);
        Ok(match (point.io_point(), point.direction) {
            (IoPoint::Digital(bit), IoDirection::In) => {
                if config.readable() >> bit & 1 == 0 {
                    return Err(PointError::NotReadable(point));
                }
                let (mask, levels) = (1 << bit, u32::from(level()?) << bit);
                Self::Io(IoChange::DigitalIn { mask, levels })
            }
            (IoPoint::Digital(bit), IoDirection::Out) => {
                if config.drivable() >> bit & 1 == 0 {
                    return Err(PointError::NotDrivable(point));
                }
                let (mask, levels) = (1 << bit, u32::from(level()?) << bit);
                Self::Io(IoChange::DigitalOut { mask, levels })
            }
            (IoPoint::Analog(port), direction) => {
                // Three ports, three domains.
                let domain = match direction {
                    IoDirection::In => config.analog_in[usize::from(port)],
                    IoDirection::Out => config.analog_out[usize::from(port)],
                };
                let (least, most) = match direction {
                    IoDirection::In => (0.0, domain.measurable_max()),
                    IoDirection::Out => (domain.value(0.0), domain.value(1.0)),
                };
                let unit = if most > 1.0 { "V" } else { "A" };
                let within = value.number().filter(|x| (least..=most).contains(x));
                let allowed = || {
                    wrong(text!(
                        "a number from {least} to {most} {unit}",
                        "{least} 到 {most} {unit} 的数"
                    ))
                };
                let value = within.ok_or_else(allowed)?;
                Self::Io(match direction {
                    IoDirection::In => IoChange::AnalogIn { port, value },
                    IoDirection::Out => IoChange::AnalogOut {
                        port,
                        ratio: domain.ratio(value),
                    },
                })
            }
            (IoPoint::BooleanRegister(n), _) => register(RegisterValue::Boolean(n, level()?)),
            (IoPoint::IntegerRegister(n), _) => {
                let whole = match value {
                    PointValue::Whole(number) => i32::try_from(*number).ok(),
                    _ => None,
                };
                let allowed = || {
                    wrong(text!(
                        "a whole number from {} to {}",
                        "{} 到 {} 的整数",
                        i32::MIN,
                        i32::MAX
                    ))
                };
                register(RegisterValue::Integer(n, whole.ok_or_else(allowed)?))
            }
            (IoPoint::FloatRegister(n), _) => {
                let finite = value.number().filter(|x| x.is_finite());
                let value = finite.ok_or_else(|| wrong(text!("a number", "数")))?;
                register(RegisterValue::Float(n, value))
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion_api::AnalogDomain;

    fn point(name: &str) -> IoPointName {
        name.parse().unwrap()
    }

    /// Outputs have the least of their domain as well as the most: a current loop says "nothing" with 4 mA.
    #[test]
    fn an_output_keeps_to_its_domain() {
        let mut config = IoConfig::default();
        config.analog_out[0] = AnalogDomain::Current;
        let set =
            |name: &str, value| PointChange::new(point(name), &PointValue::Number(value), &config);
        for value in [0.004, 0.012, 0.02] {
            let ratio = AnalogDomain::Current.ratio(value);
            let wanted = PointChange::Io(IoChange::AnalogOut { port: 0, ratio });
            assert_eq!(set("standard_analog_out[0]", value), Ok(wanted));
        }
        for value in [0.0, 0.003_99, 0.020_01, -0.02, f64::NAN, f64::INFINITY] {
            let error = set("standard_analog_out[0]", value)
                .unwrap_err()
                .to_string();
            let given = PointValue::Number(value);
            assert_eq!(
                error,
                format!(
                    "standard_analog_out[0] is {given}; it must be a number from 0.004 to 0.02 A"
                )
            );
        }
        assert_eq!(
            set("standard_analog_out[1]", 10.5).unwrap_err().to_string(),
            "standard_analog_out[1] is 10.5; it must be a number from 0 to 10 V"
        );
    }

    /// From outside only inputs; as a client of a port outputs too; registers on their own side.
    #[test]
    fn a_point_is_set_on_its_side() {
        let config = IoConfig::default();
        let level = PointValue::Level(true);
        let error = PointChange::of_input("standard_digital_out[0]", &level, &config);
        assert_eq!(
            error,
            Err(PointError::Output(point("standard_digital_out[0]")))
        );
        let registers = Registers::default();
        for (name, direction) in [
            ("input_boolean_register[3]", IoDirection::In),
            ("output_boolean_register[3]", IoDirection::Out),
        ] {
            match PointChange::new(point(name), &level, &config).unwrap() {
                PointChange::Register(side, value) => {
                    assert_eq!(side, direction, "{name}");
                    value.write(side, &registers);
                }
                PointChange::Io(change) => panic!("{name}: {change:?}"),
            }
        }
        assert!(registers.input.boolean(3) && registers.output.boolean(3));
        assert!(!registers.input.boolean(4) && !registers.output.boolean(4));
    }
}
