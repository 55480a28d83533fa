//! Rounded numbers as samples of a smooth path.
//!
//! A file tells each coordinate to so many decimals; at even, short times the rounding alone asks for accelerations
//! that no joint has. What is meant is taken to be the smoothest series that rounds to the numbers: least sum of
//! squares of its third differences, every value hardly farther from the file's than the rounding. Penalised least
//! squares whose weights grow where a value is too far off (Eilers, "A perfect smoother", *Analytical Chemistry* 75,
//! 2003, for the penalty on differences). So a series that was smooth before it was rounded comes out at least as
//! smooth as it was. First and last value stay as they are.

/// Weight of the deviations to begin with: swings of some forty samples and more are followed.
const LIGHTEST: f64 = 1e-6;
/// Most attempts at finding the weights.
const ATTEMPTS: usize = 40;
/// Factor by which an attempt raises the weight of a value that is too far off: at least, and at most.
const GROWTH: (f64, f64) = (1.1, 1000.0);
/// Deviation, in units of the rounding, at which a value counts as near: no further attempt is made when all are.
const NEAR: f64 = 1.1;
/// Largest deviation of a value in units of the rounding; more is cut off. Weights that brought the last such values
/// nearer would make corners of them.
const FARTHEST: f64 = 1.5;
/// Weight of a value that stays.
const FIXED: f64 = 1e12;
/// Third differences of a value and its neighbours.
const THIRD: [f64; 4] = [-1.0, 3.0, -3.0, 1.0];

/// The smoothest series that is [about](NEAR) within `rounding` of `given`, value by value.
pub(super) fn smoothed(given: &[f64], rounding: f64) -> Vec<f64> {
    let mut values = given.to_vec();
    let pull = pull(given);
    let count = given.len();
    if count < THIRD.len() || rounding <= 0.0 || pull.iter().all(|x| *x == 0.0) {
        return values;
    }
    let mut weights = vec![LIGHTEST; count];
    (weights[0], weights[count - 1]) = (FIXED, FIXED);
    let mut band = Band::new(count);
    let mut change = Vec::new();
    for _ in 0..ATTEMPTS {
        band.factor(&weights);
        change.clone_from(&pull);
        band.solve(&mut change);
        let mut is_near = true;
        for (weight, change) in weights.iter_mut().zip(&change) {
            let off = change.abs() / rounding;
            if off > 1.0 {
                *weight *= (GROWTH.0 * off).min(GROWTH.1);
                is_near &= off <= NEAR;
            }
        }
        if is_near {
            break;
        }
    }
    let farthest = FARTHEST * rounding;
    for (value, change) in values.iter_mut().zip(&change) {
        *value += change.max(-farthest).min(farthest);
    }
    values
}

/// What draws each value towards a smooth series: the third differences of the third differences.
fn pull(given: &[f64]) -> Vec<f64> {
    let mut pull = vec![0.0; given.len()];
    for (row, four) in given.windows(THIRD.len()).enumerate() {
        let third: f64 = four.iter().zip(THIRD).map(|(x, c)| x * c).sum();
        for (place, c) in pull[row..].iter_mut().zip(THIRD) {
            *place -= c * third;
        }
    }
    pull
}

/// The matrix of the normal equations, three places wide to either side of its diagonal, as L D Lᵀ.
struct Band {
    below: Vec<[f64; 3]>,
    diagonal: Vec<f64>,
}

impl Band {
    fn new(count: usize) -> Self {
        Self {
            below: vec![[0.0; 3]; count],
            diagonal: vec![0.0; count],
        }
    }

    /// An entry of the penalty's matrix, `back` places left of the diagonal.
    fn penalty(&self, row: usize, back: usize) -> f64 {
        let last = self.diagonal.len() - THIRD.len();
        let first = row.saturating_sub(THIRD.len() - 1);
        (first..=(row - back).min(last))
            .map(|from| THIRD[row - from] * THIRD[row - back - from])
            .sum()
    }

    fn factor(&mut self, weights: &[f64]) {
        for (row, weight) in weights.iter().enumerate() {
            let most = row.min(3);
            let mut left = self.penalty(row, 0) + weight;
            for back in (1..=most).rev() {
                let mut entry = self.penalty(row, back);
                for further in back + 1..=most {
                    entry -= self.below[row][further - 1]
                        * self.diagonal[row - further]
                        * self.below[row - back][further - back - 1];
                }
                let entry = entry / self.diagonal[row - back];
                self.below[row][back - 1] = entry;
                left -= entry * entry * self.diagonal[row - back];
            }
            self.diagonal[row] = left;
        }
    }

    fn solve(&self, values: &mut [f64]) {
        for row in 0..values.len() {
            for back in 1..=row.min(3) {
                values[row] -= self.below[row][back - 1] * values[row - back];
            }
        }
        for (value, diagonal) in values.iter_mut().zip(&self.diagonal) {
            *value /= diagonal;
        }
        for row in (0..values.len()).rev() {
            for back in 1..=row.min(3) {
                values[row - back] -= self.below[row][back - 1] * values[row];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The largest third difference.
    fn roughness(values: &[f64]) -> f64 {
        let third = |four: &[f64]| four.iter().zip(THIRD).map(|(x, c)| x * c).sum::<f64>();
        values
            .windows(4)
            .map(third)
            .fold(0.0, |m, x| m.max(x.abs()))
    }

    fn off(a: &[f64], b: &[f64]) -> f64 {
        a.iter().zip(b).fold(0.0, |m, (a, b)| m.max((a - b).abs()))
    }

    #[test]
    fn a_rounded_swing_becomes_as_smooth_as_it_was() {
        for decimals in 3..=6 {
            for (turns, count) in [(1.0, 500), (3.0, 500), (0.4, 90), (5.0, 1500)] {
                let unit = 10.0_f64.powi(-decimals);
                let exact: Vec<f64> = (0..count)
                    .map(|k| {
                        let angle = std::f64::consts::TAU * turns * f64::from(k) / f64::from(count);
                        0.3 * (1.0 - angle.cos())
                    })
                    .collect();
                let rounded: Vec<f64> = exact.iter().map(|x| (x / unit).round() * unit).collect();
                let found = smoothed(&rounded, 0.5 * unit);
                assert!(off(&found, &rounded) <= FARTHEST * 0.5 * unit * (1.0 + 1e-9));
                assert!(off(&found, &exact) <= unit, "{decimals} {turns}");
                // As rough as it was but for what is left of a rounding that is as large as the swing is long.
                let left = roughness(&exact) + 0.004 * roughness(&rounded);
                assert!(
                    roughness(&found) < 1.3 * left,
                    "{decimals} {turns}: {}",
                    roughness(&found) / left
                );
            }
        }
    }

    #[test]
    fn corners_stay_within_the_rounding_and_ends_where_they_are() {
        let corner: Vec<f64> = (0..200)
            .map(|k| {
                if k < 100 {
                    0.0123
                } else {
                    0.0123 + 0.01 * f64::from(k - 100)
                }
            })
            .collect();
        let found = smoothed(&corner, 5e-5);
        assert!(off(&found, &corner) <= FARTHEST * 5e-5 * (1.0 + 1e-9));
        assert!((found[0] - corner[0]).abs() < 1e-12);
        assert!((found[199] - corner[199]).abs() < 1e-12);
        for few in [&[][..], &[1.0], &[1.0, 2.0, 5.0], &[1.0, 1.0, 1.0, 1.0]] {
            assert_eq!(smoothed(few, 0.1), few);
        }
    }
}
