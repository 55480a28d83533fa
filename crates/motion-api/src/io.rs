//! Inputs and outputs as one small image: levels, analog values, how the points are configured, and what changes them.
//!
//! The motion thread owns the image, samples and applies it once a cycle; everybody else sends an [`IoChange`] or reads
//! the image of the latest cycle. Registers are not here: they change at once and live in [`Registers`](crate::Registers).

/// Digital points in one word: bits 0-15 standard, 16-23 configurable, 24-27 tool (protocol 30004, section 6).
pub const DIGITAL_POINTS: u8 = 28;
/// All bits of digital points.
pub const DIGITAL_MASK: u32 = (1 << DIGITAL_POINTS) - 1;
/// Analog points in each direction: standard 0, standard 1, tool.
pub const ANALOG_POINTS: usize = 3;
/// Index of the tool among the analog points.
pub const TOOL_ANALOG: u8 = 2;

/// A group of digital points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DigitalBank {
    /// 16 of the control box.
    Standard,
    /// 8 of the control box.
    Configurable,
    /// 4 at the tool; each is an input or an output.
    Tool,
}

impl DigitalBank {
    /// Its first bit in the word.
    pub const fn first_bit(self) -> u8 {
        match self {
            Self::Standard => 0,
            Self::Configurable => 16,
            Self::Tool => 24,
        }
    }

    /// How many points it has.
    pub const fn points(self) -> u8 {
        match self {
            Self::Standard => 16,
            Self::Configurable => 8,
            Self::Tool => 4,
        }
    }

    /// The bit of point `index`.
    pub const fn bit(self, index: u8) -> u8 {
        self.first_bit() + index
    }
}

/// Whether an analog point carries a current or a voltage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AnalogDomain {
    /// 4 to 20 mA; values in A.
    Current = 0,
    /// 0 to 10 V; values in V. The default is our choice.
    #[default]
    Voltage = 1,
}

impl AnalogDomain {
    /// The domain with the manual's number, 0 or 1.
    pub const fn from_number(number: u8) -> Self {
        if number == 0 {
            Self::Current
        } else {
            Self::Voltage
        }
    }

    /// The value of an output at `ratio` (0 to 1) of its range, A or V.
    pub const fn value(self, ratio: f64) -> f64 {
        match self {
            Self::Current => 0.004 + 0.016 * ratio,
            Self::Voltage => 10.0 * ratio,
        }
    }

    /// The part of the range, 0 to 1, that gives `value`.
    pub const fn ratio(self, value: f64) -> f64 {
        match self {
            Self::Current => ((value - 0.004) / 0.016).clamp(0.0, 1.0),
            Self::Voltage => (value / 10.0).clamp(0.0, 1.0),
        }
    }

    /// Largest value an input can measure, A or V.
    pub const fn measurable_max(self) -> f64 {
        match self {
            Self::Current => 0.020,
            Self::Voltage => 10.0,
        }
    }
}

/// How a tool pin drives or reads its line (manual 5.19).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ToolPin {
    /// 0 push/pull, 1 sourcing (PNP), 2 sinking (NPN).
    pub mode: u8,
    /// A disabled pin neither drives nor reads.
    pub enabled: bool,
    /// True: output, false: input.
    pub is_output: bool,
}

/// How points are configured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IoConfig {
    /// Domains of the analog inputs.
    pub analog_in: [AnalogDomain; ANALOG_POINTS],
    /// Domains of the analog outputs.
    pub analog_out: [AnalogDomain; ANALOG_POINTS],
    /// The pins of the tool.
    pub tool_pins: [ToolPin; 4],
    /// 0 USART, 1 analog input, 2 analog output, 3 both (manual 5.18).
    pub tool_analog_mode: u8,
    /// Supply of the tool connector: 0, 12 or 24 V.
    pub tool_voltage: u8,
}

impl Default for IoConfig {
    /// Pins 0 and 1 outputs, 2 and 3 inputs, all enabled and sourcing: the fixed layout of the ES series (manual 5.19).
    fn default() -> Self {
        let pin = |is_output| ToolPin {
            mode: 1,
            enabled: true,
            is_output,
        };
        Self {
            analog_in: [AnalogDomain::default(); ANALOG_POINTS],
            analog_out: [AnalogDomain::default(); ANALOG_POINTS],
            tool_pins: [pin(true), pin(true), pin(false), pin(false)],
            tool_analog_mode: 0,
            tool_voltage: 0,
        }
    }
}

impl IoConfig {
    /// Everything in one number, for the snapshot and the recording.
    pub fn to_bits(self) -> u64 {
        let mut bits = 0;
        for (k, domain) in self
            .analog_in
            .into_iter()
            .chain(self.analog_out)
            .enumerate()
        {
            bits |= (domain as u64) << k;
        }
        for (k, pin) in self.tool_pins.into_iter().enumerate() {
            let pin = u64::from(pin.mode & 3)
                | u64::from(pin.enabled) << 2
                | u64::from(pin.is_output) << 3;
            bits |= pin << (8 + 4 * k);
        }
        bits | u64::from(self.tool_analog_mode & 3) << 24 | u64::from(self.tool_voltage) << 32
    }

    /// The inverse of [`to_bits`](Self::to_bits).
    pub fn from_bits(bits: u64) -> Self {
        let domain = |k: usize| AnalogDomain::from_number((bits >> k & 1) as u8);
        let pin = |k: usize| {
            let pin = bits >> (8 + 4 * k);
            ToolPin {
                mode: (pin & 3) as u8,
                enabled: pin & 4 != 0,
                is_output: pin & 8 != 0,
            }
        };
        Self {
            analog_in: [domain(0), domain(1), domain(2)],
            analog_out: [domain(3), domain(4), domain(5)],
            tool_pins: [pin(0), pin(1), pin(2), pin(3)],
            tool_analog_mode: (bits >> 24 & 3) as u8,
            tool_voltage: (bits >> 32 & 0xFF) as u8,
        }
    }

    /// Bits of the digital outputs that can be driven: all of the box, and the tool pins that are enabled outputs.
    pub fn drivable(&self) -> u32 {
        self.tool_mask(|pin| pin.is_output) | 0x00FF_FFFF
    }

    /// Bits of the digital inputs that can be read: all of the box, and the tool pins that are enabled inputs.
    pub fn readable(&self) -> u32 {
        self.tool_mask(|pin| !pin.is_output) | 0x00FF_FFFF
    }

    fn tool_mask(&self, wanted: impl Fn(&ToolPin) -> bool) -> u32 {
        let pins = self.tool_pins.iter().enumerate();
        pins.filter(|(_, pin)| pin.enabled && wanted(pin))
            .fold(0, |mask, (k, _)| mask | 1 << (24 + k))
    }
}

/// What an output does when no program runs (manual 5.20 to 5.25). A held program counts as not running.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RunStateChoice {
    /// It keeps what programs and clients set.
    #[default]
    Keep = 0,
    /// Low, or the minimum, whenever no program runs.
    LowWhenNotRunning = 1,
    /// High, or the maximum, whenever no program runs.
    HighWhenNotRunning = 2,
    /// High, or the maximum, while a program runs, otherwise low.
    FollowsRunning = 3,
}

impl RunStateChoice {
    /// The choice with the manual's number; [`Keep`](Self::Keep) beyond 3.
    pub const fn from_number(number: u8) -> Self {
        match number {
            1 => Self::LowWhenNotRunning,
            2 => Self::HighWhenNotRunning,
            3 => Self::FollowsRunning,
            _ => Self::Keep,
        }
    }

    /// The level it forces, `None` when it leaves the output alone.
    pub const fn level(self, program_running: bool) -> Option<bool> {
        match (self, program_running) {
            (Self::Keep, _) | (Self::LowWhenNotRunning | Self::HighWhenNotRunning, true) => None,
            (Self::LowWhenNotRunning, false) => Some(false),
            (Self::HighWhenNotRunning, false) => Some(true),
            (Self::FollowsRunning, running) => Some(running),
        }
    }
}

/// What a high input sets off (manual 5.27 to 5.30).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InputAction {
    /// Nothing.
    #[default]
    Default = 0,
    /// The arm can be led by hand.
    Freedrive = 1,
}

/// One change of the image, applied at the beginning of a cycle. Bits and indices beyond the points are ignored.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IoChange {
    /// Digital outputs where `mask` is 1. Tool pins that are no enabled outputs stay as they are.
    DigitalOut {
        /// Which.
        mask: u32,
        /// To what.
        levels: u32,
    },
    /// Digital inputs where `mask` is 1, as if somebody had wired them.
    DigitalIn {
        /// Which.
        mask: u32,
        /// To what.
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
    /// A pin of the tool.
    ToolPin {
        /// 0 to 3.
        index: u8,
        /// Its configuration.
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

    /// A digital input.
    pub const fn digital_in(bank: DigitalBank, index: u8, level: bool) -> Self {
        let mask = 1 << bank.bit(index);
        Self::DigitalIn {
            mask,
            levels: if level { mask } else { 0 },
        }
    }

    /// Its name and up to four numbers, for the recording.
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
            _ => return None,
        })
    }
}

/// Levels, values and configuration of all points.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct IoImage {
    /// Digital inputs by bit.
    pub digital_in: u32,
    /// Digital outputs by bit.
    pub digital_out: u32,
    /// Analog inputs, A or V by domain.
    pub analog_in: [f64; ANALOG_POINTS],
    /// Analog outputs, 0 to 1 of their range.
    pub analog_out_ratio: [f64; ANALOG_POINTS],
    /// How the points are configured.
    pub config: IoConfig,
}

impl IoImage {
    /// Applies what concerns levels, values and configuration; run-state choices and input actions are the cycle's.
    pub fn apply(&mut self, change: &IoChange) {
        match *change {
            IoChange::DigitalOut { mask, levels } => {
                let mask = mask & self.config.drivable();
                self.digital_out = self.digital_out & !mask | levels & mask;
            }
            IoChange::DigitalIn { mask, levels } => {
                let mask = mask & self.config.readable();
                self.digital_in = self.digital_in & !mask | levels & mask;
            }
            IoChange::AnalogOut { port, ratio } => {
                if let Some(out) = self.analog_out_ratio.get_mut(usize::from(port)) {
                    *out = not_nan(ratio).clamp(0.0, 1.0);
                }
            }
            IoChange::AnalogIn { port, value } => {
                let port = usize::from(port);
                if let (Some(input), Some(domain)) = (
                    self.analog_in.get_mut(port),
                    self.config.analog_in.get(port),
                ) {
                    *input = not_nan(value).clamp(0.0, domain.measurable_max());
                }
            }
            IoChange::AnalogOutDomain { port, domain } => {
                if let Some(of_port) = self.config.analog_out.get_mut(usize::from(port)) {
                    *of_port = domain;
                }
            }
            IoChange::AnalogInDomain { port, domain } => {
                let port = usize::from(port);
                if let (Some(of_port), Some(input)) = (
                    self.config.analog_in.get_mut(port),
                    self.analog_in.get_mut(port),
                ) {
                    *of_port = domain;
                    *input = input.min(domain.measurable_max());
                }
            }
            IoChange::ToolAnalogMode(mode) => self.config.tool_analog_mode = mode & 3,
            IoChange::ToolPin { index, pin } => {
                if let Some(of_index) = self.config.tool_pins.get_mut(usize::from(index)) {
                    *of_index = pin;
                    self.digital_out &= self.config.drivable();
                    self.digital_in &= self.config.readable();
                }
            }
            IoChange::ToolVoltage(volts) => self.config.tool_voltage = volts,
            IoChange::DigitalOutRunState { .. }
            | IoChange::AnalogOutRunState { .. }
            | IoChange::BooleanRegisterRunState { .. }
            | IoChange::DigitalInAction { .. }
            | IoChange::BooleanRegisterAction { .. }
            | IoChange::InputActionsToDefault
            | IoChange::ProgramRunning(_) => {}
        }
    }

    /// The analog outputs, A or V by domain.
    pub fn analog_out(&self) -> [f64; ANALOG_POINTS] {
        std::array::from_fn(|k| self.config.analog_out[k].value(self.analog_out_ratio[k]))
    }

    /// Level of a pin of the tool: the output's or the input's, whichever it is; low beyond the last pin.
    pub fn tool_digital(&self, index: u8) -> bool {
        let Some(pin) = self.config.tool_pins.get(usize::from(index)) else {
            return false;
        };
        let word = if pin.is_output {
            self.digital_out
        } else {
            self.digital_in
        };
        word >> DigitalBank::Tool.bit(index) & 1 == 1
    }
}

/// 0 for a number that is none.
const fn not_nan(x: f64) -> f64 {
    if x.is_nan() { 0.0 } else { x }
}

/// One point of a wire or of a timed input. The direction follows from where it stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IoPoint {
    /// A bit of the digital word.
    Digital(u8),
    /// An analog point: 0, 1 or 2 (tool).
    Analog(u8),
    /// A boolean register.
    BooleanRegister(u8),
    /// An integer register.
    IntegerRegister(u8),
    /// A float register.
    FloatRegister(u8),
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn changes() -> impl Strategy<Value = IoChange> {
        let names = [
            "digital_out",
            "digital_in",
            "analog_out",
            "analog_in",
            "analog_out_domain",
            "analog_in_domain",
            "tool_analog_mode",
            "tool_pin",
            "tool_voltage",
            "digital_out_run_state",
            "analog_out_run_state",
            "boolean_register_run_state",
            "digital_in_action",
            "boolean_register_action",
            "input_actions_to_default",
            "program_running",
        ];
        (0..names.len(), 0..3_u8, any::<u32>(), 0..4_u8, 0..2_u8).prop_map(
            move |(n, a, b, c, d)| {
                let name = names[n];
                let (a, b) = match name {
                    "digital_out" | "digital_in" => (b, b.rotate_left(7)),
                    "tool_pin" => (a.into(), b & 1),
                    _ => (u32::from(a), b & 1),
                };
                IoChange::from_parts(name, [a.into(), b.into(), c.into(), d.into()]).unwrap()
            },
        )
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 128, failure_persistence: None, ..ProptestConfig::default() })]
        #[test]
        fn a_change_comes_back_from_its_parts(change in changes()) {
            let (name, numbers) = change.to_parts();
            prop_assert_eq!(IoChange::from_parts(name, numbers), Some(change));
        }

        #[test]
        fn no_sequence_of_changes_leaves_the_ranges(list in proptest::collection::vec(changes(), 0..40)) {
            let mut image = IoImage::default();
            for change in &list {
                image.apply(change);
                prop_assert_eq!(image.digital_out & !image.config.drivable(), 0);
                prop_assert_eq!(image.digital_in & !image.config.readable(), 0);
                for k in 0..ANALOG_POINTS {
                    prop_assert!((0.0..=1.0).contains(&image.analog_out_ratio[k]));
                    prop_assert!((0.0..=image.config.analog_in[k].measurable_max()).contains(&image.analog_in[k]));
                }
                prop_assert_eq!(IoConfig::from_bits(image.config.to_bits()), image.config);
            }
        }
    }

    #[test]
    fn analog_outputs_are_a_part_of_their_domain() {
        let mut image = IoImage::default();
        image.apply(&IoChange::AnalogOut {
            port: 0,
            ratio: 0.5,
        });
        assert_eq!(image.analog_out()[0], 5.0);
        let domain = AnalogDomain::Current;
        image.apply(&IoChange::AnalogOutDomain { port: 0, domain });
        assert!((image.analog_out()[0] - 0.012).abs() < 1e-15);
        for wrong in [f64::NAN, -1.0, f64::NEG_INFINITY] {
            image.apply(&IoChange::AnalogOut {
                port: 0,
                ratio: wrong,
            });
            assert_eq!(image.analog_out()[0], 0.004);
        }
        image.apply(&IoChange::AnalogOut {
            port: 0,
            ratio: 7.0,
        });
        assert_eq!(image.analog_out()[0], 0.020);
    }

    #[test]
    fn a_tool_pin_is_either_input_or_output() {
        let mut image = IoImage::default();
        let high = |index| IoChange::digital_out(DigitalBank::Tool, index, true);
        image.apply(&high(1));
        image.apply(&high(2));
        assert!(image.tool_digital(1) && !image.tool_digital(2));
        image.apply(&IoChange::digital_in(DigitalBank::Tool, 2, true));
        assert!(image.tool_digital(2));
        let pin = ToolPin {
            is_output: false,
            ..image.config.tool_pins[1]
        };
        image.apply(&IoChange::ToolPin { index: 1, pin });
        assert!(!image.tool_digital(1) && image.digital_out == 0);
    }
}
