//! Random numbers, the same bits on every machine: a seed gives one sequence everywhere.
//!
//! For noise and for searches that a recording has to repeat, not for secrets.

/// A sequence of random numbers: SplitMix64 (Steele, Lea, Flood, OOPSLA 2014). Every seed is good.
#[derive(Clone, Copy, Debug)]
pub struct RandomSequence {
    state: u64,
}

impl RandomSequence {
    /// The sequence of a seed.
    pub const fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    /// A sequence of its own for each `stream` of a seed.
    pub fn with_stream(seed: u64, stream: u64) -> Self {
        let mut sequence = Self::new(seed ^ stream.wrapping_mul(0xa076_1d64_78bd_642f));
        sequence.bits();
        sequence
    }

    /// The next 64 random bits.
    #[inline]
    pub fn bits(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.state;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    /// The next number, evenly from 0 to 1, 1 not included.
    #[inline]
    pub fn unit(&mut self) -> f64 {
        (self.bits() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// The next number, evenly between two numbers, `high` not included.
    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sequence_is_the_published_one() {
        // First outputs for the seed 1234567 (Rosetta Code, "Pseudo-random numbers/Splitmix64").
        let mut sequence = RandomSequence::new(1_234_567);
        let expected = [
            6_457_827_717_110_365_317,
            3_203_168_211_198_807_973,
            9_817_491_932_198_370_423,
            4_593_380_528_125_082_431,
            16_408_922_859_458_223_821,
        ];
        assert_eq!([(); 5].map(|()| sequence.bits()), expected);
    }

    #[test]
    fn streams_of_a_seed_differ_and_numbers_stay_within_their_bounds() {
        let first = |stream| RandomSequence::with_stream(7, stream).bits();
        assert_eq!(first(1), first(1));
        assert_ne!(first(1), first(2));
        let mut sequence = RandomSequence::with_stream(7, 1);
        assert!((0..10_000).all(|_| (-2.0..3.0).contains(&sequence.between(-2.0, 3.0))));
    }
}
