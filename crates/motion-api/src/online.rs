//! Words of the online modes that cross the border: frames of freedrive, ranges and pulse decoding of encoders, axes of
//! path offsets.

use kinematics::RpyPose;

/// Whose axes freedrive frees or locks (manual 3.1.41). Rotations are about axes through the TCP.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FreedriveFrame {
    /// The base's.
    Base,
    /// The TCP's, which moves along.
    Tool,
    /// The axes of a pose in the base frame.
    Pose(RpyPose),
}

/// Range of an encoder's counter (manual 3.1.21).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum EncoderRange {
    /// -2147483648 to 2147483647.
    #[default]
    Signed32,
    /// 0 to 255.
    Unsigned8,
    /// 0 to 65535.
    Unsigned16,
    /// 0 to 16777215.
    Unsigned24,
    /// 0 to 4294967295.
    Unsigned32,
}

impl EncoderRange {
    /// From the manual's `range_id`.
    pub const fn from_number(number: u64) -> Option<Self> {
        Some(match number {
            0 => Self::Signed32,
            1 => Self::Unsigned8,
            2 => Self::Unsigned16,
            3 => Self::Unsigned24,
            4 => Self::Unsigned32,
            _ => return None,
        })
    }

    /// The manual's `range_id`.
    pub const fn number(self) -> u64 {
        self as u64
    }

    /// Smallest and largest count.
    pub const fn bounds(self) -> (f64, f64) {
        match self {
            Self::Signed32 => (-2_147_483_648.0, 2_147_483_647.0),
            Self::Unsigned8 => (0.0, 255.0),
            Self::Unsigned16 => (0.0, 65_535.0),
            Self::Unsigned24 => (0.0, 16_777_215.0),
            Self::Unsigned32 => (0.0, 4_294_967_295.0),
        }
    }

    /// How many counts there are.
    pub const fn span(self) -> f64 {
        let (min, max) = self.bounds();
        max - min + 1.0
    }

    /// A difference of two counts without the counter's wrap (manual 3.1.24): within half a span of zero.
    ///
    /// ```
    /// # use motion_api::EncoderRange;
    /// assert_eq!(EncoderRange::Unsigned16.unwrap_delta(-64666.0), 870.0);
    /// assert_eq!(EncoderRange::Unsigned16.unwrap_delta(870.0), 870.0);
    /// ```
    pub fn unwrap_delta(self, delta: f64) -> f64 {
        let span = self.span();
        if delta.abs() <= span / 2.0 {
            return delta;
        }
        delta - span * (delta / span).round()
    }

    /// A count carried on past the end of the range.
    pub fn wrap_count(self, count: f64) -> f64 {
        let (min, _) = self.bounds();
        min + (count - min).rem_euclid(self.span())
    }
}

/// The edges of an incremental encoder that count (manual 3.1.32).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PulseDecoding {
    /// Every edge of two channels; which leads gives the direction.
    Quadrature,
    /// Both edges of one channel.
    BothEdges,
    /// Rising edges.
    Rising,
    /// Falling edges.
    Falling,
}

impl PulseDecoding {
    /// From the manual's `decoder_type`.
    pub const fn from_number(number: u64) -> Option<Self> {
        Some(match number {
            1 => Self::Quadrature,
            2 => Self::BothEdges,
            3 => Self::Rising,
            4 => Self::Falling,
            _ => return None,
        })
    }

    /// The manual's `decoder_type`.
    pub const fn number(self) -> u64 {
        self as u64 + 1
    }
}

/// Whose axes an offset of the path has (from controller output, not from the manual).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OffsetAxes {
    /// The base's.
    #[default]
    Base,
    /// The TCP's on the path without offsets.
    Tool,
    /// X along the path's tangent, Y = X × the tool's Z, Z = X × Y: Universal Robots' rule.
    Motion,
}

impl OffsetAxes {
    /// From the number of `path_offset_set`.
    pub const fn from_number(number: u64) -> Option<Self> {
        Some(match number {
            1 => Self::Base,
            2 => Self::Tool,
            3 => Self::Motion,
            _ => return None,
        })
    }

    /// The number of `path_offset_set`.
    pub const fn number(self) -> u64 {
        self as u64 + 1
    }
}
