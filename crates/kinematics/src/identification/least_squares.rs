//! Least squares over any number of measurements, with what they cannot tell.

use messages::Localized;
use nalgebra::{DMatrix, DVector};

/// Below this share of the largest one, an eigenvalue of the scaled normal matrix belongs to a direction that the
/// measurements say nothing about.
const EIGENVALUE_SHARE_MIN: f64 = 1e-9;
/// Stretches of measurements that are kept apart at most; then neighbours are joined.
const STRETCHES_MAX: usize = 512;
/// Measurements beyond the unknowns that are needed: with fewer, what is left over does not bound the errors.
const SPARE_MEASUREMENTS_MIN: usize = 3;
/// Fewer stretches for each unknown say nothing about how measurements hang together.
const STRETCHES_PER_UNKNOWN: usize = 4;

/// Sums of a linear least-squares problem: measurements may be added without end.
///
/// Measurements one after the other have errors that are alike, so that they tell less than as many independent ones.
/// The standard deviations take that from stretches of measurements, where the caller ends some (White, *Asymptotic
/// Theory for Econometricians*, 2001, chapter 6), and errors that all measurements share from the caller.
///
/// What is left over tells the size of the errors, and after few measurements tells it badly: what is known of an
/// unknown is then a Student's t distribution, whose standard deviation is the one given here (JCGM 101:2008, 6.4.9).
/// Twice of it covers the truth in 95 of 100 cases with a few measurements as with many.
#[derive(Clone, Debug)]
pub struct LeastSquares {
    normal: DMatrix<f64>,
    right: DVector<f64>,
    /// What the error that all measurements share adds to `right`.
    shared: DVector<f64>,
    squares: f64,
    count: usize,
    /// Normal matrix and right side of the stretches that have ended, this many ends in each.
    stretches: Vec<(DMatrix<f64>, DVector<f64>)>,
    ends_per_stretch: usize,
    ends: usize,
    /// Sums at the end of the newest stretch.
    ended: (DMatrix<f64>, DVector<f64>),
}

/// What the measurements say.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The unknowns.
    pub values: Vec<f64>,
    /// One standard deviation of what is known of each.
    pub sigmas: Vec<f64>,
    /// Covariance of the unknowns.
    pub covariance: DMatrix<f64>,
    /// Root of the mean square of what is left.
    pub residual_rms: f64,
}

/// A reason why measurements have no least-squares solution.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Localized)]
pub enum FitError {
    /// Fewer measurements than unknowns and some more.
    #[error("{count} measurements for {unknowns} unknowns: {needed} or more are needed")]
    #[zh("{count} 个测量值对 {unknowns} 个未知量：需要 {needed} 个或更多")]
    TooFew {
        /// How many there are.
        count: usize,
        /// How many unknowns.
        unknowns: usize,
        /// How many are enough.
        needed: usize,
    },
    /// Some unknowns, or sums of them, make no difference in any measurement.
    #[error("the measurements do not tell the unknowns {unknowns:?}")]
    #[zh("测量值不能确定未知量 {unknowns:?}")]
    Unobservable {
        /// Numbers of these unknowns, from 0.
        unknowns: Vec<usize>,
    },
}

impl LeastSquares {
    /// For this many unknowns.
    pub fn new(unknowns: usize) -> Self {
        Self {
            normal: DMatrix::zeros(unknowns, unknowns),
            right: DVector::zeros(unknowns),
            shared: DVector::zeros(unknowns),
            squares: 0.0,
            count: 0,
            stretches: Vec::new(),
            ends_per_stretch: 1,
            ends: 0,
            ended: (DMatrix::zeros(unknowns, unknowns), DVector::zeros(unknowns)),
        }
    }

    /// Adds a measurement: `value` = `row` · unknowns.
    pub fn add(&mut self, row: &[f64], value: f64) {
        self.add_with_shared(row, value, 0.0);
    }

    /// Adds a measurement to which an error that all measurements share adds `shared`, where that error is one standard
    /// deviation.
    pub fn add_with_shared(&mut self, row: &[f64], value: f64, shared: f64) {
        for (i, a) in row.iter().enumerate() {
            if *a == 0.0 {
                continue;
            }
            for (j, b) in row.iter().enumerate() {
                self.normal[(i, j)] += a * b;
            }
            self.right[i] += a * value;
            self.shared[i] += a * shared;
        }
        self.squares += value * value;
        self.count += 1;
    }

    /// Ends a stretch: the measurements before and after it have errors of their own.
    pub fn end_stretch(&mut self) {
        self.ends += 1;
        if !self.ends.is_multiple_of(self.ends_per_stretch) {
            return;
        }
        let (normal, right) = (&self.normal - &self.ended.0, &self.right - &self.ended.1);
        self.stretches.push((normal, right));
        self.ended = (self.normal.clone(), self.right.clone());
        if self.stretches.len() >= STRETCHES_MAX {
            self.ends_per_stretch *= 2;
            let pairs = self.stretches.chunks(2);
            let joined = pairs.map(|pair| {
                let sum = |(normal, right): &(DMatrix<f64>, DVector<f64>),
                           other: Option<&(_, _)>| match other {
                    Some((more, add)) => (normal + more, right + add),
                    None => (normal.clone(), right.clone()),
                };
                sum(&pair[0], pair.get(1))
            });
            self.stretches = joined.collect();
        }
    }

    /// How much larger the standard deviation of each unknown is than if all errors were independent, at least 1.
    fn stretch_factors(
        &self,
        inverse: &DMatrix<f64>,
        values: &DVector<f64>,
        covariance: &DMatrix<f64>,
    ) -> DVector<f64> {
        let unknowns = values.len();
        let count = self.stretches.len();
        if count < STRETCHES_PER_UNKNOWN * unknowns {
            return DVector::from_element(unknowns, 1.0);
        }
        let mut middle = DMatrix::zeros(unknowns, unknowns);
        for (normal, right) in &self.stretches {
            let left = right - normal * values;
            middle.ger(1.0, &left, &left, 1.0);
        }
        let robust = inverse * middle * inverse;
        let free = count as f64 / (count - unknowns) as f64;
        DVector::from_fn(unknowns, |i, _| {
            let share = free * robust[(i, i)] / covariance[(i, i)];
            if share > 1.0 { share.sqrt() } else { 1.0 }
        })
    }

    /// Number of measurements.
    pub const fn count(&self) -> usize {
        self.count
    }

    /// Solves for the unknowns.
    ///
    /// # Errors
    /// The measurements do not tell some of them.
    pub fn solve(&self) -> Result<Solution, FitError> {
        let unknowns = self.right.len();
        let needed = unknowns + SPARE_MEASUREMENTS_MIN;
        if self.count < needed {
            return Err(FitError::TooFew {
                count: self.count,
                unknowns,
                needed,
            });
        }
        // Unknowns of different size are made alike.
        let scale = DVector::from_fn(unknowns, |i, _| {
            let size = self.normal[(i, i)].sqrt();
            if size > 0.0 { 1.0 / size } else { 0.0 }
        });
        let silent: Vec<usize> = (0..unknowns).filter(|i| scale[*i] == 0.0).collect();
        if !silent.is_empty() {
            return Err(FitError::Unobservable { unknowns: silent });
        }
        let scaled = DMatrix::from_fn(unknowns, unknowns, |i, j| {
            scale[i] * self.normal[(i, j)] * scale[j]
        });
        let eigen = scaled.symmetric_eigen();
        let largest = eigen.eigenvalues.max();
        let mut unseen: Vec<usize> = Vec::new();
        for (index, value) in eigen.eigenvalues.iter().enumerate() {
            if *value < EIGENVALUE_SHARE_MIN * largest {
                let direction = eigen.eigenvectors.column(index);
                unseen.extend((0..unknowns).filter(|i| direction[*i].abs() > 0.1));
            }
        }
        if !unseen.is_empty() {
            unseen.sort_unstable();
            unseen.dedup();
            return Err(FitError::Unobservable { unknowns: unseen });
        }
        let inverse = {
            let values = DMatrix::from_diagonal(&eigen.eigenvalues.map(|value| 1.0 / value));
            let inverse = &eigen.eigenvectors * values * eigen.eigenvectors.transpose();
            DMatrix::from_fn(unknowns, unknowns, |i, j| {
                scale[i] * inverse[(i, j)] * scale[j]
            })
        };
        let values = &inverse * &self.right;
        let left = (self.squares - values.dot(&self.right)).max(0.0);
        // The variance of a Student's t distribution: left / freedom, times freedom / (freedom - 2).
        let variance = left / (self.count - unknowns - 2) as f64;
        let mut covariance = &inverse * variance;
        let factors = self.stretch_factors(&inverse, &values, &covariance);
        let shift = &inverse * &self.shared;
        for i in 0..unknowns {
            for j in 0..unknowns {
                covariance[(i, j)] *= factors[i] * factors[j];
                covariance[(i, j)] += shift[i] * shift[j];
            }
        }
        Ok(Solution {
            sigmas: (0..unknowns)
                .map(|i| covariance[(i, i)].max(0.0).sqrt())
                .collect(),
            values: values.iter().copied().collect(),
            residual_rms: (left / self.count as f64).sqrt(),
            covariance,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_found_with_its_uncertainty() {
        let mut sums = LeastSquares::new(2);
        for k in 0..100 {
            let x = f64::from(k) / 10.0;
            let noise = if k % 2 == 0 { 0.1 } else { -0.1 };
            sums.add(&[1.0, x], 3.0 + 0.5 * x + noise);
        }
        let found = sums.solve().unwrap();
        assert!((found.values[0] - 3.0).abs() < 0.02 && (found.values[1] - 0.5).abs() < 0.005);
        assert!((found.residual_rms - 0.1).abs() < 1e-3);
        // 0.1 / sqrt(sum of squared distances from the mean)
        assert!(
            (found.sigmas[1] - 0.1 / 833.25_f64.sqrt()).abs() < 1e-4,
            "{:?}",
            found.sigmas
        );
    }

    #[test]
    fn too_few_measurements_are_told_with_how_many_are_enough() {
        let mut sums = LeastSquares::new(2);
        for k in 0..4 {
            sums.add(&[1.0, f64::from(k)], 3.0);
        }
        let error = sums.solve().unwrap_err();
        assert_eq!(
            error.to_string(),
            "4 measurements for 2 unknowns: 5 or more are needed"
        );
        sums.add(&[1.0, 4.0], 3.0);
        assert!(sums.solve().is_ok());
    }

    #[test]
    fn errors_that_hang_together_tell_less() {
        // The same error for a hundred measurements, 40 times: the sigma of the mean is 0.1 / sqrt(40).
        let mut sums = LeastSquares::new(1);
        for k in 0..4000 {
            let error = if (k / 100) % 2 == 0 { 0.1 } else { -0.1 };
            sums.add(&[1.0], 3.0 + error);
            if k % 100 == 99 {
                sums.end_stretch();
            }
        }
        let sigma = sums.solve().unwrap().sigmas[0];
        let expected = 0.1 / 40_f64.sqrt();
        assert!((sigma / expected - 1.0).abs() < 0.05, "{sigma} {expected}");

        // So many stretches that neighbours are joined.
        let mut sums = LeastSquares::new(1);
        for k in 0_u64..4000 {
            let bits = k.wrapping_mul(0x9e37_79b9_7f4a_7c15);
            let error = if bits >> 63 == 0 { 0.1 } else { -0.1 };
            (0..10).for_each(|_| sums.add(&[1.0], 3.0 + error));
            sums.end_stretch();
        }
        assert!(sums.stretches.len() < STRETCHES_MAX);
        assert!(sums.solve().unwrap().sigmas[0] > 0.0);
    }

    #[test]
    fn an_error_that_all_measurements_share_does_not_average_out() {
        let mut sums = LeastSquares::new(1);
        for k in 0..10_000 {
            let noise = if k % 2 == 0 { 0.1 } else { -0.1 };
            sums.add_with_shared(&[2.0], 6.0 + noise, 0.04);
        }
        let sigma = sums.solve().unwrap().sigmas[0];
        assert!((sigma - 0.02).abs() < 1e-4, "{sigma}");
    }

    #[test]
    fn what_is_not_told_is_named() {
        let mut sums = LeastSquares::new(3);
        for k in 0..10 {
            let x = f64::from(k);
            sums.add(&[x, 0.0, 1.0], x);
        }
        assert_eq!(
            sums.solve().unwrap_err(),
            FitError::Unobservable { unknowns: vec![1] }
        );
        let mut sums = LeastSquares::new(3);
        for k in 0..10 {
            let x = f64::from(k);
            sums.add(&[x, 2.0 * x, 1.0], x);
        }
        assert_eq!(
            sums.solve().unwrap_err(),
            FitError::Unobservable {
                unknowns: vec![0, 1]
            }
        );
    }
}
