//! Names of inputs and outputs in the cell file: `standard_digital_out[3]`, `input_float_register[12]`.

use core::fmt;
use core::str::FromStr;

use messages::{Text, text};
use motion_api::io::TOOL_ANALOG;
use motion_api::{DigitalBank, IoPoint};
use serde::Deserialize;

/// Whether the robot reads or writes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum IoDirection {
    /// The robot reads it.
    In,
    /// The robot writes it.
    Out,
}

/// A group of inputs or outputs that are numbered together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum IoGroup {
    /// 16 of the control box.
    StandardDigital,
    /// 8 of the control box.
    ConfigurableDigital,
    /// 4 of the tool.
    ToolDigital,
    /// 2 of the control box.
    StandardAnalog,
    /// 1 of the tool; has no number.
    ToolAnalog,
    /// 128 registers with levels.
    BooleanRegister,
    /// 48 registers with whole numbers.
    IntegerRegister,
    /// 48 registers with floating-point numbers.
    FloatRegister,
}

/// One input or output.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(try_from = "String")]
pub struct IoPointName {
    /// Group of the point.
    pub group: IoGroup,
    /// Read or written by the robot.
    pub direction: IoDirection,
    /// Number in the group, from 0.
    pub index: u8,
}

impl IoPointName {
    /// Every input and output there is.
    pub fn all() -> impl Iterator<Item = Self> {
        let points = |group: IoGroup| (0..group.points()).map(move |index| (group, index));
        let directions = [IoDirection::In, IoDirection::Out];
        directions.into_iter().flat_map(move |direction| {
            IoGroup::ALL
                .into_iter()
                .flat_map(points)
                .map(move |(group, index)| Self {
                    group,
                    direction,
                    index,
                })
        })
    }

    /// The point as the cycle knows it.
    pub const fn io_point(self) -> IoPoint {
        let index = self.index;
        match self.group {
            IoGroup::StandardDigital => IoPoint::Digital(DigitalBank::Standard.bit(index)),
            IoGroup::ConfigurableDigital => IoPoint::Digital(DigitalBank::Configurable.bit(index)),
            IoGroup::ToolDigital => IoPoint::Digital(DigitalBank::Tool.bit(index)),
            IoGroup::StandardAnalog => IoPoint::Analog(index),
            IoGroup::ToolAnalog => IoPoint::Analog(TOOL_ANALOG),
            IoGroup::BooleanRegister => IoPoint::BooleanRegister(index),
            IoGroup::IntegerRegister => IoPoint::IntegerRegister(index),
            IoGroup::FloatRegister => IoPoint::FloatRegister(index),
        }
    }
}

impl IoGroup {
    const ALL: [Self; 8] = [
        Self::StandardDigital,
        Self::ConfigurableDigital,
        Self::ToolDigital,
        Self::StandardAnalog,
        Self::ToolAnalog,
        Self::BooleanRegister,
        Self::IntegerRegister,
        Self::FloatRegister,
    ];

    /// How many points the group has in each direction (rtsi-30004: registers; manual chapter 5: the rest).
    pub const fn points(self) -> u8 {
        match self {
            Self::StandardDigital => 16,
            Self::ConfigurableDigital => 8,
            Self::ToolDigital => 4,
            Self::StandardAnalog => 2,
            Self::ToolAnalog => 1,
            Self::BooleanRegister => 128,
            Self::IntegerRegister | Self::FloatRegister => 48,
        }
    }

    /// True for levels, false for numbers.
    pub const fn is_digital(self) -> bool {
        matches!(
            self,
            Self::StandardDigital
                | Self::ConfigurableDigital
                | Self::ToolDigital
                | Self::BooleanRegister
        )
    }

    /// The name without its number.
    const fn name(self, direction: IoDirection) -> &'static str {
        match (self, direction) {
            (Self::StandardDigital, IoDirection::In) => "standard_digital_in",
            (Self::StandardDigital, IoDirection::Out) => "standard_digital_out",
            (Self::ConfigurableDigital, IoDirection::In) => "configurable_digital_in",
            (Self::ConfigurableDigital, IoDirection::Out) => "configurable_digital_out",
            (Self::ToolDigital, IoDirection::In) => "tool_digital_in",
            (Self::ToolDigital, IoDirection::Out) => "tool_digital_out",
            (Self::StandardAnalog, IoDirection::In) => "standard_analog_in",
            (Self::StandardAnalog, IoDirection::Out) => "standard_analog_out",
            (Self::ToolAnalog, IoDirection::In) => "tool_analog_in",
            (Self::ToolAnalog, IoDirection::Out) => "tool_analog_out",
            (Self::BooleanRegister, IoDirection::In) => "input_boolean_register",
            (Self::BooleanRegister, IoDirection::Out) => "output_boolean_register",
            (Self::IntegerRegister, IoDirection::In) => "input_integer_register",
            (Self::IntegerRegister, IoDirection::Out) => "output_integer_register",
            (Self::FloatRegister, IoDirection::In) => "input_float_register",
            (Self::FloatRegister, IoDirection::Out) => "output_float_register",
        }
    }
}

impl fmt::Display for IoPointName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.group.name(self.direction))?;
        match self.group {
            IoGroup::ToolAnalog => Ok(()),
            _ => write!(f, "[{}]", self.index),
        }
    }
}

impl FromStr for IoPointName {
    type Err = Text;

    fn from_str(text: &str) -> Result<Self, Text> {
        let (name, index) = match text.split_once('[') {
            Some((name, rest)) => (name, Some(rest)),
            None => (text, None),
        };
        let found = IoGroup::ALL
            .into_iter()
            .flat_map(|group| [(group, IoDirection::In), (group, IoDirection::Out)])
            .find(|(group, direction)| group.name(*direction) == name);
        let Some((group, direction)) = found else {
            return Err(text!(
                "`{text}` is no input or output; names are like standard_digital_in[0], configurable_digital_out[7], \
                 tool_digital_in[0], standard_analog_out[1], tool_analog_in, input_float_register[0]",
                "`{text}` 不是输入或输出；名称如 standard_digital_in[0]、configurable_digital_out[7]、tool_digital_in[0]、\
                 standard_analog_out[1]、tool_analog_in、input_float_register[0]"
            ));
        };
        if group == IoGroup::ToolAnalog && index.is_none() {
            return Ok(Self {
                group,
                direction,
                index: 0,
            });
        }
        let number = index
            .and_then(|rest| rest.strip_suffix(']'))
            .and_then(|digits| digits.parse().ok());
        match number {
            Some(index) if group != IoGroup::ToolAnalog && index < group.points() => Ok(Self {
                group,
                direction,
                index,
            }),
            _ if group == IoGroup::ToolAnalog => Err(text!(
                "`{text}` has no number: it is `{name}`",
                "`{text}` 没有序号：应为 `{name}`"
            )),
            _ => Err(text!(
                "`{text}` needs a number from 0 to {}, as in {name}[0]",
                "`{text}` 需要 0 到 {} 的序号，如 {name}[0]",
                group.points() - 1
            )),
        }
    }
}

impl TryFrom<String> for IoPointName {
    type Error = Text;

    fn try_from(text: String) -> Result<Self, Text> {
        text.parse()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_is_read_back() {
        for group in IoGroup::ALL {
            for direction in [IoDirection::In, IoDirection::Out] {
                for index in 0..group.points() {
                    let point = IoPointName {
                        group,
                        direction,
                        index,
                    };
                    assert_eq!(point.to_string().parse(), Ok(point));
                }
            }
        }
    }

    #[test]
    fn what_does_not_exist_is_named() {
        for (text, words) in [
            ("standard_digital_in[16]", "from 0 to 15"),
            ("configurable_digital_out[8]", "from 0 to 7"),
            ("tool_digital_in", "from 0 to 3"),
            ("standard_analog_in[-1]", "from 0 to 1"),
            ("input_float_register[48]", "from 0 to 47"),
            ("output_boolean_register[1", "from 0 to 127"),
            ("tool_analog_in[0]", "has no number"),
            ("digital_in[0]", "is no input or output"),
            ("", "is no input or output"),
        ] {
            let error = text.parse::<IoPointName>().unwrap_err();
            assert!(
                error.english().contains(words) && error.english().contains(text),
                "{error}"
            );
        }
    }
}
