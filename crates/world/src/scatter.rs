//! Scatter of the world: random numbers that follow from its seed.

use kinematics::elementary;
use kinematics::random::RandomSequence;

/// A sequence of normally and evenly distributed numbers.
#[derive(Clone, Debug)]
pub(crate) struct Scatter(RandomSequence);

impl Scatter {
    /// A sequence of its own for each `stream` of a seed.
    pub(crate) fn new(seed: u64, stream: u64) -> Self {
        Self(RandomSequence::with_stream(seed, stream))
    }

    /// Evenly from 0 (not 0 itself, which has no logarithm) to 1.
    pub(crate) fn unit(&mut self) -> f64 {
        ((self.0.bits() >> 11) + 1) as f64 / (1_u64 << 53) as f64
    }

    /// Normally distributed with a standard deviation of 1 (Box and Muller, 1958).
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * elementary::ln(self.unit())).sqrt();
        radius * elementary::cos(core::f64::consts::TAU * self.unit())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_one_sequence_with_the_deviation_of_one() {
        let numbers = |seed| {
            let mut scatter = Scatter::new(seed, 3);
            (0..10_000).map(|_| scatter.normal()).collect::<Vec<_>>()
        };
        assert_eq!(numbers(7), numbers(7));
        assert_ne!(numbers(7), numbers(8));
        let of = numbers(7);
        let mean = of.iter().sum::<f64>() / 1e4;
        let variance = of.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / 1e4;
        assert!(
            mean.abs() < 0.03 && (variance - 1.0).abs() < 0.05,
            "{mean} {variance}"
        );
    }
}
