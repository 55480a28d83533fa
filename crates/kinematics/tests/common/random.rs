//! The same random numbers on every run.

/// SplitMix64 (Steele, Lea, Flood 2014).
pub struct Random(pub u64);

impl Random {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 * (-53_f64).exp2()
    }

    pub fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// A distance from a singularity, even in its logarithm, to either side.
    pub fn near(&mut self) -> f64 {
        let distance = 10_f64.powf(self.between(-6.0, -2.0));
        if self.unit() < 0.5 {
            distance
        } else {
            -distance
        }
    }
}
