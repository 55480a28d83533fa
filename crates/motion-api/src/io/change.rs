//! Changes of inputs, outputs and their configuration, as commands and recordings carry them.

use super::config::*;
use super::points::*;

/// One change of the image, applied at the beginning of a cycle. Bits and indices beyond the points are ignored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IoChange {
    /// Digital outputs where `mask` is 1. Tool pins that are no enabled outputs stay as they are.
    DigitalOut {
        /// The outputs that change, one bit each.
        mask: u32,
        /// Levels of these outputs, at the bits of `mask`.
        levels: u32,
    },
    /// Digital inputs where `mask` is 1, as if somebody had wired them.
    DigitalIn {
        /// The inputs that change, one bit each.
        mask: u32,
        /// Levels of these inputs, at the bits of `mask`.
        levels: u32,
    },
    /// An analog output.
    AnalogOut {
        /// 0, 1 or 2 (tool).
        port: u8,
        /// Part of the range; clamped to 0 to 1.
        ratio: f64,
    },
    /// An analog input.
    AnalogIn {
        /// 0, 1 or 2 (tool).
        port: u8,
        /// A or V by domain; clamped to what can be measured.
        value: f64,
    },
    /// Domain of an analog output; the ratio stays.
    AnalogOutDomain {
        /// 0, 1 or 2 (tool).
        port: u8,
        /// The new domain.
        domain: AnalogDomain,
    },
    /// Domain of an analog input.
    AnalogInDomain {
        /// 0, 1 or 2 (tool).
        port: u8,
        /// The new domain.
        domain: AnalogDomain,
    },
    /// What the analog pins of the tool are used for, 0 to 3 (manual 5.18).
    ToolAnalogMode(u8),
    /// What the digital pins of the tool are used for, 0 to 3 (from controller output, not from the manual).
    ToolDigitalMode(u8),
    /// How the arm brakes when it passes into reduced mode: 0 hard, 1 soft (from controller output, not from the
    /// manual).
    SafetyHardness(u8),
    /// A pin of the tool.
    ToolPin {
        /// 0 to 3.
        index: u8,
        /// The configuration of the pin.
        pin: ToolPin,
    },
    /// Supply of the tool connector: 0, 12 or 24 V.
    ToolVoltage(u8),
    /// What a digital output does without a program.
    DigitalOutRunState {
        /// 0 to 27.
        bit: u8,
        /// The choice.
        choice: RunStateChoice,
    },
    /// What an analog output does without a program.
    AnalogOutRunState {
        /// 0, 1 or 2 (tool).
        port: u8,
        /// The choice.
        choice: RunStateChoice,
    },
    /// What a boolean output register does without a program.
    BooleanRegisterRunState {
        /// 0 to 127.
        index: u8,
        /// The choice.
        choice: RunStateChoice,
    },
    /// What a digital input sets off.
    DigitalInAction {
        /// 0 to 27.
        bit: u8,
        /// The action.
        action: InputAction,
    },
    /// What a boolean input register sets off.
    BooleanRegisterAction {
        /// 0 to 127.
        index: u8,
        /// The action.
        action: InputAction,
    },
    /// No input sets off anything.
    InputActionsToDefault,
    /// A program runs, or none does (or it is held).
    ProgramRunning(bool),
    /// A boolean output register.
    BooleanRegister {
        /// 0 to 127.
        index: u8,
        /// To what.
        level: bool,
    },
    /// A float output register.
    FloatRegister {
        /// 0 to 47.
        index: u8,
        /// To what.
        value: f64,
    },
    /// An integer output register.
    IntegerRegister {
        /// 0 to 47.
        index: u8,
        /// To what.
        value: i32,
    },
}

impl IoChange {
    /// A digital output.
    pub const fn digital_out(bank: DigitalBank, index: u8, level: bool) -> Self {
        let mask = 1 << bank.bit(index);
        Self::DigitalOut {
            mask,
            levels: if level { mask } else { 0 },
        }
    }

    /// Index and level, where this changes one standard digital output and nothing else.
    pub const fn standard_digital_out(&self) -> Option<(u8, bool)> {
        match *self {
            Self::DigitalOut { mask, levels } if mask.is_power_of_two() && mask <= 0x8000 => {
                Some((mask.trailing_zeros() as u8, levels & mask != 0))
            }
            _ => None,
        }
    }

    /// A digital input.
    pub const fn digital_in(bank: DigitalBank, index: u8, level: bool) -> Self {
        let mask = 1 << bank.bit(index);
        Self::DigitalIn {
            mask,
            levels: if level { mask } else { 0 },
        }
    }

    /// The name of the change and up to four numbers, for the recording.
    pub fn to_parts(&self) -> (&'static str, [f64; 4]) {
        let two = |a: f64, b: f64| [a, b, 0.0, 0.0];
        match *self {
            Self::DigitalOut { mask, levels } => ("digital_out", two(mask.into(), levels.into())),
            Self::DigitalIn { mask, levels } => ("digital_in", two(mask.into(), levels.into())),
            Self::AnalogOut { port, ratio } => ("analog_out", two(port.into(), ratio)),
            Self::AnalogIn { port, value } => ("analog_in", two(port.into(), value)),
            Self::AnalogOutDomain { port, domain } => {
                ("analog_out_domain", two(port.into(), domain as u8 as f64))
            }
            Self::AnalogInDomain { port, domain } => {
                ("analog_in_domain", two(port.into(), domain as u8 as f64))
            }
            Self::ToolAnalogMode(mode) => ("tool_analog_mode", two(mode.into(), 0.0)),
            Self::ToolDigitalMode(mode) => ("tool_digital_mode", two(mode.into(), 0.0)),
            Self::SafetyHardness(kind) => ("safety_hardness", two(kind.into(), 0.0)),
            Self::ToolPin { index, pin } => {
                let flags = [index, pin.mode, pin.enabled.into(), pin.is_output.into()];
                ("tool_pin", flags.map(f64::from))
            }
            Self::ToolVoltage(volts) => ("tool_voltage", two(volts.into(), 0.0)),
            Self::DigitalOutRunState { bit, choice } => (
                "digital_out_run_state",
                two(bit.into(), choice as u8 as f64),
            ),
            Self::AnalogOutRunState { port, choice } => (
                "analog_out_run_state",
                two(port.into(), choice as u8 as f64),
            ),
            Self::BooleanRegisterRunState { index, choice } => (
                "boolean_register_run_state",
                two(index.into(), choice as u8 as f64),
            ),
            Self::DigitalInAction { bit, action } => {
                ("digital_in_action", two(bit.into(), action as u8 as f64))
            }
            Self::BooleanRegisterAction { index, action } => (
                "boolean_register_action",
                two(index.into(), action as u8 as f64),
            ),
            Self::InputActionsToDefault => ("input_actions_to_default", [0.0; 4]),
            Self::ProgramRunning(running) => {
                ("program_running", two(f64::from(u8::from(running)), 0.0))
            }
            Self::BooleanRegister { index, level } => (
                "boolean_register",
                two(index.into(), f64::from(u8::from(level))),
            ),
            Self::FloatRegister { index, value } => ("float_register", two(index.into(), value)),
            Self::IntegerRegister { index, value } => {
                ("integer_register", two(index.into(), value.into()))
            }
        }
    }

    /// The inverse of [`to_parts`](Self::to_parts); `None` for a name that is none. Numbers saturate.
    pub fn from_parts(name: &str, numbers: [f64; 4]) -> Option<Self> {
        let [a, b, c, d] = numbers;
        let (index, mask, levels) = (a as u8, a as u32, b as u32);
        let domain = AnalogDomain::from_number(b as u8);
        let choice = RunStateChoice::from_number(b as u8);
        let action = if b == 0.0 {
            InputAction::Default
        } else {
            InputAction::Freedrive
        };
        Some(match name {
            "digital_out" => Self::DigitalOut { mask, levels },
            "digital_in" => Self::DigitalIn { mask, levels },
            "analog_out" => Self::AnalogOut {
                port: index,
                ratio: b,
            },
            "analog_in" => Self::AnalogIn {
                port: index,
                value: b,
            },
            "analog_out_domain" => Self::AnalogOutDomain {
                port: index,
                domain,
            },
            "analog_in_domain" => Self::AnalogInDomain {
                port: index,
                domain,
            },
            "tool_analog_mode" => Self::ToolAnalogMode(index),
            "tool_digital_mode" => Self::ToolDigitalMode(index),
            "safety_hardness" => Self::SafetyHardness(index),
            "tool_pin" => Self::ToolPin {
                index,
                pin: ToolPin {
                    mode: b as u8,
                    enabled: c != 0.0,
                    is_output: d != 0.0,
                },
            },
            "tool_voltage" => Self::ToolVoltage(index),
            "digital_out_run_state" => Self::DigitalOutRunState { bit: index, choice },
            "analog_out_run_state" => Self::AnalogOutRunState {
                port: index,
                choice,
            },
            "boolean_register_run_state" => Self::BooleanRegisterRunState { index, choice },
            "digital_in_action" => Self::DigitalInAction { bit: index, action },
            "boolean_register_action" => Self::BooleanRegisterAction { index, action },
            "input_actions_to_default" => Self::InputActionsToDefault,
            "program_running" => Self::ProgramRunning(a != 0.0),
            "boolean_register" => Self::BooleanRegister {
                index,
                level: b != 0.0,
            },
            "float_register" => Self::FloatRegister { index, value: b },
            "integer_register" => Self::IntegerRegister {
                index,
                value: b as i32,
            },
            _ => return None,
        })
    }
}
