//! The points: banks of digital ones, analog ones with their ranges.

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
    /// The bit of the bank's first point in the word of all inputs or outputs.
    pub const fn first_bit(self) -> u8 {
        match self {
            Self::Standard => 0,
            Self::Configurable => 16,
            Self::Tool => 24,
        }
    }

    /// The number of points in the bank.
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
