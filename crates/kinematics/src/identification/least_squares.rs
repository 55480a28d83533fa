//! Least squares over any number of measurements, with what they cannot tell.

use nalgebra::{DMatrix, DVector};

/// Below this share of the largest one, an eigenvalue of the scaled normal matrix belongs to a direction that the measurements
/// say nothing about.
const EIGENVALUE_SHARE_MIN: f64 = 1e-9;

/// Sums of a linear least-squares problem: measurements may be added without end.
#[derive(Clone, Debug)]
pub struct LeastSquares {
    normal: DMatrix<f64>,
    right: DVector<f64>,
    squares: f64,
    count: usize,
}

/// What the measurements say.
#[derive(Clone, Debug)]
pub struct Solution {
    /// The unknowns.
    pub values: Vec<f64>,
    /// One standard deviation of each.
    pub sigmas: Vec<f64>,
    /// Covariance of the unknowns.
    pub covariance: DMatrix<f64>,
    /// Root of the mean square of what is left.
    pub residual_rms: f64,
}

/// Why there is no solution.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FitError {
    /// Fewer measurements than unknowns.
    #[error("{count} measurements for {unknowns} unknowns")]
    TooFew {
        /// How many there are.
        count: usize,
        /// How many unknowns.
        unknowns: usize,
    },
    /// Some unknowns, or sums of them, make no difference in any measurement.
    #[error("the measurements do not tell the unknowns {unknowns:?}")]
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
            squares: 0.0,
            count: 0,
        }
    }

    /// Adds a measurement: `value` = `row` · unknowns.
    pub fn add(&mut self, row: &[f64], value: f64) {
        for (i, a) in row.iter().enumerate() {
            if *a == 0.0 {
                continue;
            }
            for (j, b) in row.iter().enumerate() {
                self.normal[(i, j)] += a * b;
            }
            self.right[i] += a * value;
        }
        self.squares += value * value;
        self.count += 1;
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
        if self.count <= unknowns {
            return Err(FitError::TooFew {
                count: self.count,
                unknowns,
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
        let variance = left / (self.count - unknowns) as f64;
        let covariance = inverse * variance;
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
