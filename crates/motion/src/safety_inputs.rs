//! The functions of the safety system that pairs of configurable inputs have.
//!
//! Owns the assignment and the reading of a pair; what a function then does to the arm is the machine's.

use motion_api::DigitalBank;

use crate::machine::SafetyRequests;

/// A pair of configurable inputs: pair n is inputs 2n and 2n + 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InputPair {
    /// 0 to 3.
    pub pair: u8,
    /// True when a low level asks for the function, so that a broken wire does: one low input of the two is enough.
    /// Otherwise one high input is.
    pub is_active_low: bool,
}

impl InputPair {
    /// Number of pairs.
    pub const COUNT: u8 = DigitalBank::Configurable.points() / 2;

    fn is_requested(self, digital_in: u32) -> bool {
        let mask = 0b11 << DigitalBank::Configurable.bit(2 * self.pair);
        if self.is_active_low {
            digital_in & mask != mask
        } else {
            digital_in & mask != 0
        }
    }
}

/// The assignment; functions without a pair never ask for anything.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SafetyInputs {
    /// Emergency stop of the cell.
    pub emergency_stop: Option<InputPair>,
    /// Safeguard stop.
    pub safeguard_stop: Option<InputPair>,
    /// Reset of a safeguard stop, which ends by itself without one.
    pub safeguard_reset: Option<InputPair>,
    /// Reduced limits.
    pub reduced_mode: Option<InputPair>,
}

impl SafetyInputs {
    /// What the inputs ask for, bits as in `RobotState::digital_in`.
    pub(crate) fn requests(&self, digital_in: u32) -> SafetyRequests {
        let asks = |pair: Option<InputPair>| pair.is_some_and(|pair| pair.is_requested(digital_in));
        SafetyRequests {
            emergency_stop: asks(self.emergency_stop),
            safeguard_stop: asks(self.safeguard_stop),
            safeguard_reset: self
                .safeguard_reset
                .map(|pair| pair.is_requested(digital_in)),
            reduced_mode: asks(self.reduced_mode),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_input_of_a_pair_is_enough() {
        let inputs = |is_active_low| SafetyInputs {
            emergency_stop: Some(InputPair {
                pair: 1,
                is_active_low,
            }),
            ..SafetyInputs::default()
        };
        for (levels, low, high) in [
            (0b0000, true, false),
            (0b0100, true, true),
            (0b1000, true, true),
            (0b1100, false, true),
            (0b0011, true, false),
        ] {
            let digital_in = levels << 16;
            assert_eq!(inputs(true).requests(digital_in).emergency_stop, low);
            assert_eq!(inputs(false).requests(digital_in).emergency_stop, high);
        }
        assert_eq!(
            SafetyInputs::default().requests(0),
            SafetyRequests::default()
        );
    }
}
