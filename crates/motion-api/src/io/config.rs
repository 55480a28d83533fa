//! How points are configured: domains of analog ones, pins of the tool, outputs that tell whether a program runs,
//! inputs that do something.

use super::points::*;

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
    /// What the digital pins are used for, 0 to 3: kept for the tool, changes nothing here (from controller output, not
    /// from the manual).
    pub tool_digital_mode: u8,
    /// Supply of the tool connector: 0, 12 or 24 V.
    pub tool_voltage: u8,
    /// How the arm brakes when it passes into reduced mode: 0 hard, 1 soft (from controller output, not from the
    /// manual).
    pub safety_hardness: u8,
    /// An input or a boolean register has the action "freedrive" (manual 5.27 to 5.30).
    pub freedrive_by_input: bool,
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
            tool_digital_mode: 0,
            tool_voltage: 0,
            safety_hardness: 0,
            freedrive_by_input: false,
        }
    }
}

impl IoConfig {
    /// Everything in one number, for the snapshot and the recording.
    pub fn to_bits(self) -> u64 {
        let mut bits = 0;
        for k in 0..3 {
            bits |= (self.analog_in[k] as u64) << k;
            bits |= (self.analog_out[k] as u64) << (k + 3);
        }
        for (k, pin) in self.tool_pins.iter().enumerate() {
            let pin = u64::from(pin.mode & 3)
                | u64::from(pin.enabled) << 2
                | u64::from(pin.is_output) << 3;
            bits |= pin << (8 + 4 * k);
        }
        bits | u64::from(self.tool_analog_mode & 3) << 24
            | u64::from(self.freedrive_by_input) << 26
            | u64::from(self.tool_digital_mode & 3) << 27
            | u64::from(self.safety_hardness & 1) << 29
            | u64::from(self.tool_voltage) << 32
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
            tool_digital_mode: (bits >> 27 & 3) as u8,
            tool_voltage: (bits >> 32 & 0xFF) as u8,
            safety_hardness: (bits >> 29 & 1) as u8,
            freedrive_by_input: bits >> 26 & 1 != 0,
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
    /// The output keeps what programs and clients set.
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

    /// The level that the choice forces, `None` when it leaves the output alone.
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
