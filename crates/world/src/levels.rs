//! Levels of the points that connect the world with the controller.
//!
//! A point is named by [`motion_api::IoPoint`]; whether an input or an output is meant follows from the field it stands in. The world
//! reads and writes digital points, boolean registers and analog points: integer and float registers are refused by the check.

use motion_api::IoPoint;

/// Levels of all points of one direction. Copied across the border to the motion thread, so of fixed size.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Levels {
    /// Digital points by bit (`motion_api::DigitalBank::bit`).
    pub digital: u32,
    /// Boolean registers, 64 a word.
    pub booleans: [u64; 2],
    /// Analog points as a part of their largest value, 0 to 1: standard 0, standard 1, tool.
    pub analog: [f64; 3],
}

impl Levels {
    /// Level of a digital point or boolean register; an analog point is true above half of its range.
    pub fn level(&self, point: IoPoint) -> bool {
        match point {
            IoPoint::Digital(bit) => bit < 32 && self.digital >> bit & 1 == 1,
            IoPoint::BooleanRegister(index) => {
                index < 128 && self.booleans[usize::from(index / 64)] >> (index % 64) & 1 == 1
            }
            _ => self.ratio(point) > 0.5,
        }
    }

    /// Value of an analog point as a part of its largest value; 1 or 0 for the others.
    pub fn ratio(&self, point: IoPoint) -> f64 {
        match point {
            IoPoint::Analog(port) => self.analog.get(usize::from(port)).copied().unwrap_or(0.0),
            IoPoint::Digital(_) | IoPoint::BooleanRegister(_) => {
                f64::from(u8::from(self.level(point)))
            }
            IoPoint::IntegerRegister(_) | IoPoint::FloatRegister(_) => 0.0,
        }
    }

    /// Sets a digital point or a boolean register; an analog point goes to the end of its range.
    pub fn set_level(&mut self, point: IoPoint, level: bool) {
        match point {
            IoPoint::Digital(bit) if bit < 32 => {
                self.digital = self.digital & !(1 << bit) | u32::from(level) << bit;
            }
            IoPoint::BooleanRegister(index) if index < 128 => {
                let word = &mut self.booleans[usize::from(index / 64)];
                *word = *word & !(1 << (index % 64)) | u64::from(level) << (index % 64);
            }
            _ => self.set_ratio(point, f64::from(u8::from(level))),
        }
    }

    /// Sets an analog point, clamped to 0 to 1; other points are left alone.
    pub fn set_ratio(&mut self, point: IoPoint, ratio: f64) {
        if let IoPoint::Analog(port) = point
            && let Some(value) = self.analog.get_mut(usize::from(port))
        {
            *value = kinematics::bounds::within(ratio, 0.0, 1.0);
        }
    }
}

/// A set of points of one direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PointSet {
    /// Digital points by bit.
    pub digital: u32,
    /// Boolean registers, 64 a word.
    pub booleans: [u64; 2],
    /// Analog points by bit.
    pub analog: u8,
}

impl PointSet {
    /// Adds a point; false when it was in the set before.
    pub fn insert(&mut self, point: IoPoint) -> bool {
        let is_new = !self.contains(point);
        match point {
            IoPoint::Digital(bit) if bit < 32 => self.digital |= 1 << bit,
            IoPoint::BooleanRegister(index) if index < 128 => {
                self.booleans[usize::from(index / 64)] |= 1 << (index % 64);
            }
            IoPoint::Analog(port) if port < 8 => self.analog |= 1 << port,
            _ => {}
        }
        is_new
    }

    /// Whether a point is in the set.
    pub fn contains(&self, point: IoPoint) -> bool {
        match point {
            IoPoint::Digital(bit) => bit < 32 && self.digital >> bit & 1 == 1,
            IoPoint::BooleanRegister(index) => {
                index < 128 && self.booleans[usize::from(index / 64)] >> (index % 64) & 1 == 1
            }
            IoPoint::Analog(port) => port < 8 && self.analog >> port & 1 == 1,
            IoPoint::IntegerRegister(_) | IoPoint::FloatRegister(_) => false,
        }
    }
}
