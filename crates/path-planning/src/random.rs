//! Random numbers of the search: a seed gives the same ones on every machine.

/// A sequence of random numbers (SplitMix64, Steele and others, 2014).
#[derive(Clone, Debug)]
pub(crate) struct RandomSequence {
    state: u64,
}

impl RandomSequence {
    /// A sequence of its own for each `stream` of a seed.
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        let mut sequence = Self {
            state: seed ^ stream.wrapping_mul(0xa076_1d64_78bd_642f),
        };
        sequence.bits();
        sequence
    }

    fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.state;
        x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ x >> 31
    }

    /// Evenly from 0 to 1, 1 not included.
    pub(crate) fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Evenly between two numbers.
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}
