//! The variables that clients can write, and what writing them means.
//!
//! The SDK sends its whole recipe each time one value changes, with old masks still set and never-written values 0. So
//! digital and analog outputs are touched only where the mask says so; registers and the external wrench have no mask.

use core::ops::Range;

use super::outputs::split_register;
use crate::ports::description::AnalogDomain;
use wire::rtsi::{RtsiType, RtsiValue};

/// One variable.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum InputVariable {
    /// `speed_slider_mask`
    SpeedSliderMask,
    /// `speed_slider_fraction`
    SpeedSliderFraction,
    /// `standard_digital_output_mask`
    StandardDigitalMask,
    /// `standard_digital_output`
    StandardDigital,
    /// `configurable_digital_output_mask`
    ConfigurableDigitalMask,
    /// `configurable_digital_output`
    ConfigurableDigital,
    /// `tool_digital_output_mask`
    ToolDigitalMask,
    /// `tool_digital_output`
    ToolDigital,
    /// `standard_analog_output_mask`
    StandardAnalogMask,
    /// `standard_analog_output_type`
    StandardAnalogType,
    /// `standard_analog_output_0` and `_1`
    StandardAnalog(u8),
    /// `external_force_torque`
    ExternalForceTorque,
    /// `input_bit_registers0_to_31` and `…32_to_63`, by the first one
    Bits(u8),
    /// `input_bit_register64` to `…127`
    Bit(u8),
    /// `input_int_register0` to `…47`
    Int(u8),
    /// `input_double_register0` to `…47`
    Double(u8),
}

const NAMED: [(&str, InputVariable); 15] = [
    ("speed_slider_mask", InputVariable::SpeedSliderMask),
    ("speed_slider_fraction", InputVariable::SpeedSliderFraction),
    (
        "standard_digital_output_mask",
        InputVariable::StandardDigitalMask,
    ),
    ("standard_digital_output", InputVariable::StandardDigital),
    (
        "configurable_digital_output_mask",
        InputVariable::ConfigurableDigitalMask,
    ),
    (
        "configurable_digital_output",
        InputVariable::ConfigurableDigital,
    ),
    ("tool_digital_output_mask", InputVariable::ToolDigitalMask),
    ("tool_digital_output", InputVariable::ToolDigital),
    (
        "standard_analog_output_mask",
        InputVariable::StandardAnalogMask,
    ),
    (
        "standard_analog_output_type",
        InputVariable::StandardAnalogType,
    ),
    ("standard_analog_output_0", InputVariable::StandardAnalog(0)),
    ("standard_analog_output_1", InputVariable::StandardAnalog(1)),
    ("external_force_torque", InputVariable::ExternalForceTorque),
    ("input_bit_registers0_to_31", InputVariable::Bits(0)),
    ("input_bit_registers32_to_63", InputVariable::Bits(32)),
];

/// Name without the number, numbers, variable of a number.
type InputGroup = (&'static str, Range<u8>, fn(u8) -> InputVariable);

/// Registers have one variable each; the first 64 boolean ones come in words.
const NUMBERED: [InputGroup; 3] = [
    ("input_bit_register", 64..128, InputVariable::Bit),
    ("input_int_register", 0..48, InputVariable::Int),
    ("input_double_register", 0..48, InputVariable::Double),
];

impl InputVariable {
    /// The variable of this name.
    pub fn by_name(name: &str) -> Option<Self> {
        if let Some((_, input)) = NAMED.iter().find(|(known, _)| *known == name) {
            return Some(*input);
        }
        let (group, number) = split_register(name)?;
        let mut groups = NUMBERED.iter();
        let (.., variable) =
            groups.find(|(g, numbers, _)| *g == group && numbers.contains(&number))?;
        Some(variable(number))
    }

    /// Every variable that stands alone, with its name.
    pub fn named() -> impl Iterator<Item = (&'static str, Self)> {
        NAMED.into_iter()
    }

    /// Every group of registers: the name without its number, the numbers, and the first variable.
    pub fn numbered() -> impl Iterator<Item = (&'static str, Range<u8>, Self)> {
        NUMBERED
            .iter()
            .map(|(group, numbers, variable)| (*group, numbers.clone(), variable(numbers.start)))
    }

    /// Name of the variable.
    pub fn name(self) -> String {
        match self {
            Self::Bit(n) => format!("input_bit_register{n}"),
            Self::Int(n) => format!("input_int_register{n}"),
            Self::Double(n) => format!("input_double_register{n}"),
            named => {
                let found = NAMED.iter().find(|(_, input)| *input == named);
                found.map_or_else(String::new, |(name, _)| (*name).to_owned())
            }
        }
    }

    /// Type of the variable.
    pub const fn kind(self) -> RtsiType {
        match self {
            Self::SpeedSliderMask | Self::Bits(_) => RtsiType::U32,
            Self::StandardDigitalMask | Self::StandardDigital => RtsiType::U16,
            Self::ConfigurableDigitalMask
            | Self::ConfigurableDigital
            | Self::ToolDigitalMask
            | Self::ToolDigital
            | Self::StandardAnalogMask
            | Self::StandardAnalogType => RtsiType::U8,
            Self::SpeedSliderFraction | Self::StandardAnalog(_) | Self::Double(_) => RtsiType::F64,
            Self::ExternalForceTorque => RtsiType::Vector6,
            Self::Bit(_) => RtsiType::Bool,
            Self::Int(_) => RtsiType::I32,
        }
    }
}

/// What a client changes, to take effect in the next cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// The speed slider, 0 to 1.
    SpeedFraction(f64),
    /// Standard digital outputs where `mask` is 1.
    StandardDigitalOut {
        /// Bit mask of the outputs to set.
        mask: u16,
        /// Bit mask of their new levels.
        levels: u16,
    },
    /// Configurable digital outputs where `mask` is 1.
    ConfigurableDigitalOut {
        /// Bit mask of the outputs to set.
        mask: u8,
        /// Bit mask of their new levels.
        levels: u8,
    },
    /// Tool digital outputs where `mask` is 1; 4 of them.
    ToolDigitalOut {
        /// Bit mask of the outputs to set.
        mask: u8,
        /// Bit mask of their new levels.
        levels: u8,
    },
    /// A standard analog output.
    StandardAnalogOut {
        /// 0 or 1.
        index: u8,
        /// Current or voltage.
        domain: AnalogDomain,
        /// 0 to 1 of 0 to 10 V or 4 to 20 mA.
        ratio: f64,
    },
    /// A wrench on the tool in the base frame, N and Nm.
    ExternalForceTorque([f64; 6]),
    /// 32 boolean input registers from `first` on.
    InputBits {
        /// 0 or 32.
        first: u8,
        /// Register `first + n` is bit n.
        levels: u32,
    },
    /// One boolean input register.
    InputBit {
        /// 64 to 127.
        index: u8,
        /// New level.
        level: bool,
    },
    /// One integer input register.
    InputInt {
        /// 0 to 47.
        index: u8,
        /// The number.
        value: i32,
    },
    /// One float input register.
    InputDouble {
        /// 0 to 47.
        index: u8,
        /// The number.
        value: f64,
    },
}

/// What one connection has written to variables that only count together.
#[derive(Clone, Copy, Debug, Default)]
pub struct InputLatch {
    slider: (u32, f64),
    standard: (u16, u16),
    configurable: (u8, u8),
    tool: (u8, u8),
    analog_mask: u8,
    analog_type: u8,
    analog: [f64; 2],
}

impl InputLatch {
    /// Takes the values of one package and gives the changes they make, in a fixed order. Numbers that are none (NaN,
    /// infinities) change neither the slider nor an output nor the wrench.
    pub fn take(&mut self, package: &[(InputVariable, RtsiValue)]) -> Vec<Change> {
        let mut changes = Vec::new();
        for (input, value) in package {
            self.store(*input, *value, &mut changes);
        }
        let has =
            |inputs: &[InputVariable]| package.iter().any(|(input, _)| inputs.contains(input));
        if has(&[
            InputVariable::SpeedSliderMask,
            InputVariable::SpeedSliderFraction,
        ]) && self.slider.0 == 1
            && self.slider.1.is_finite()
        {
            changes.push(Change::SpeedFraction(self.slider.1.clamp(0.0, 1.0)));
        }
        if has(&[
            InputVariable::StandardDigitalMask,
            InputVariable::StandardDigital,
        ]) && self.standard.0 != 0
        {
            let (mask, levels) = self.standard;
            changes.push(Change::StandardDigitalOut { mask, levels });
        }
        if has(&[
            InputVariable::ConfigurableDigitalMask,
            InputVariable::ConfigurableDigital,
        ]) && self.configurable.0 != 0
        {
            let (mask, levels) = self.configurable;
            changes.push(Change::ConfigurableDigitalOut { mask, levels });
        }
        if has(&[InputVariable::ToolDigitalMask, InputVariable::ToolDigital])
            && self.tool.0 & 0xF != 0
        {
            let (mask, levels) = (self.tool.0 & 0xF, self.tool.1 & 0xF);
            changes.push(Change::ToolDigitalOut { mask, levels });
        }
        let analog = [
            InputVariable::StandardAnalogMask,
            InputVariable::StandardAnalogType,
            InputVariable::StandardAnalog(0),
            InputVariable::StandardAnalog(1),
        ];
        if has(&analog) {
            self.analog_changes(&mut changes);
        }
        changes
    }

    fn store(&mut self, input: InputVariable, value: RtsiValue, changes: &mut Vec<Change>) {
        match (input, value) {
            (InputVariable::SpeedSliderMask, RtsiValue::U32(x)) => self.slider.0 = x,
            (InputVariable::SpeedSliderFraction, RtsiValue::F64(x)) => self.slider.1 = x,
            (InputVariable::StandardDigitalMask, RtsiValue::U16(x)) => self.standard.0 = x,
            (InputVariable::StandardDigital, RtsiValue::U16(x)) => self.standard.1 = x,
            (InputVariable::ConfigurableDigitalMask, RtsiValue::U8(x)) => self.configurable.0 = x,
            (InputVariable::ConfigurableDigital, RtsiValue::U8(x)) => self.configurable.1 = x,
            (InputVariable::ToolDigitalMask, RtsiValue::U8(x)) => self.tool.0 = x,
            (InputVariable::ToolDigital, RtsiValue::U8(x)) => self.tool.1 = x,
            (InputVariable::StandardAnalogMask, RtsiValue::U8(x)) => self.analog_mask = x,
            (InputVariable::StandardAnalogType, RtsiValue::U8(x)) => self.analog_type = x,
            (InputVariable::StandardAnalog(index), RtsiValue::F64(x)) => {
                self.analog[usize::from(index & 1)] = x;
            }
            (InputVariable::ExternalForceTorque, RtsiValue::Vector6(wrench))
                if wrench.iter().all(|x| x.is_finite()) =>
            {
                changes.push(Change::ExternalForceTorque(wrench));
            }
            (InputVariable::Bits(first), RtsiValue::U32(levels)) => {
                changes.push(Change::InputBits { first, levels });
            }
            (InputVariable::Bit(index), RtsiValue::Bool(level)) => {
                changes.push(Change::InputBit { index, level });
            }
            (InputVariable::Int(index), RtsiValue::I32(value)) => {
                changes.push(Change::InputInt { index, value });
            }
            (InputVariable::Double(index), RtsiValue::F64(value)) => {
                changes.push(Change::InputDouble { index, value });
            }
            // A wrench that is none. Other pairs do not occur: a value is read with the type of its variable.
            _ => {}
        }
    }

    fn analog_changes(&self, changes: &mut Vec<Change>) {
        for index in 0..2 {
            let ratio = self.analog[usize::from(index)];
            if self.analog_mask >> index & 1 == 1 && ratio.is_finite() {
                let domain = match self.analog_type >> index & 1 {
                    0 => AnalogDomain::Current,
                    _ => AnalogDomain::Voltage,
                };
                let ratio = ratio.clamp(0.0, 1.0);
                changes.push(Change::StandardAnalogOut {
                    index,
                    domain,
                    ratio,
                });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_has_the_type_of_the_page_and_is_read_back() {
        for (name, kind) in [
            ("speed_slider_mask", "UINT32"),
            ("speed_slider_fraction", "DOUBLE"),
            ("standard_digital_output_mask", "UINT16"),
            ("standard_digital_output", "UINT16"),
            ("configurable_digital_output_mask", "UINT8"),
            ("configurable_digital_output", "UINT8"),
            ("tool_digital_output_mask", "UINT8"),
            ("tool_digital_output", "UINT8"),
            ("standard_analog_output_mask", "UINT8"),
            ("standard_analog_output_type", "UINT8"),
            ("standard_analog_output_0", "DOUBLE"),
            ("standard_analog_output_1", "DOUBLE"),
            ("external_force_torque", "VECTOR6D"),
            ("input_bit_registers0_to_31", "UINT32"),
            ("input_bit_registers32_to_63", "UINT32"),
            ("input_bit_register64", "BOOL"),
            ("input_bit_register127", "BOOL"),
            ("input_int_register0", "INT32"),
            ("input_double_register47", "DOUBLE"),
        ] {
            let input = InputVariable::by_name(name).unwrap_or_else(|| panic!("{name}"));
            assert_eq!(input.kind().name(), kind, "{name}");
            assert_eq!(input.name(), name);
        }
        for name in [
            "output_int_register0",
            "input_int_register48",
            "timestamp",
            "standard_analog_output_2",
        ] {
            assert!(InputVariable::by_name(name).is_none(), "{name}");
        }
    }

    #[test]
    fn outputs_are_touched_only_where_the_mask_says_so() {
        let mut written = InputLatch::default();
        let zero = [
            (InputVariable::StandardDigitalMask, RtsiValue::U16(0)),
            (InputVariable::StandardDigital, RtsiValue::U16(0xFFFF)),
            (InputVariable::SpeedSliderMask, RtsiValue::U32(0)),
            (InputVariable::SpeedSliderFraction, RtsiValue::F64(0.3)),
            (InputVariable::StandardAnalogMask, RtsiValue::U8(0)),
            (InputVariable::StandardAnalog(0), RtsiValue::F64(1.0)),
        ];
        assert_eq!(written.take(&zero), []);
        let set = [
            (InputVariable::StandardDigitalMask, RtsiValue::U16(2)),
            (InputVariable::ToolDigitalMask, RtsiValue::U8(0xF1)),
            (InputVariable::ToolDigital, RtsiValue::U8(0xFF)),
            (InputVariable::SpeedSliderMask, RtsiValue::U32(1)),
            (InputVariable::StandardAnalogMask, RtsiValue::U8(3)),
            (InputVariable::StandardAnalogType, RtsiValue::U8(2)),
            (InputVariable::StandardAnalog(1), RtsiValue::F64(7.0)),
        ];
        assert_eq!(
            written.take(&set),
            [
                Change::SpeedFraction(0.3),
                Change::StandardDigitalOut {
                    mask: 2,
                    levels: 0xFFFF
                },
                Change::ToolDigitalOut {
                    mask: 1,
                    levels: 15
                },
                Change::StandardAnalogOut {
                    index: 0,
                    domain: AnalogDomain::Current,
                    ratio: 1.0
                },
                Change::StandardAnalogOut {
                    index: 1,
                    domain: AnalogDomain::Voltage,
                    ratio: 1.0
                },
            ]
        );
    }

    #[test]
    fn registers_have_no_mask_and_nan_moves_nothing() {
        let mut written = InputLatch::default();
        let package = [
            (InputVariable::Bits(32), RtsiValue::U32(5)),
            (InputVariable::Bit(64), RtsiValue::Bool(true)),
            (InputVariable::Int(3), RtsiValue::I32(-1)),
            (InputVariable::Double(4), RtsiValue::F64(0.5)),
            (
                InputVariable::ExternalForceTorque,
                RtsiValue::Vector6([0.0, 0.0, f64::NAN, 0.0, 0.0, 0.0]),
            ),
            (InputVariable::SpeedSliderMask, RtsiValue::U32(1)),
            (InputVariable::SpeedSliderFraction, RtsiValue::F64(f64::NAN)),
        ];
        assert_eq!(
            written.take(&package),
            [
                Change::InputBits {
                    first: 32,
                    levels: 5
                },
                Change::InputBit {
                    index: 64,
                    level: true
                },
                Change::InputInt {
                    index: 3,
                    value: -1
                },
                Change::InputDouble {
                    index: 4,
                    value: 0.5
                },
            ]
        );
        let wrench = [(
            InputVariable::ExternalForceTorque,
            RtsiValue::Vector6([1.0; 6]),
        )];
        assert_eq!(
            written.take(&wrench),
            [Change::ExternalForceTorque([1.0; 6])]
        );
    }
}
