//! Finds the moments of two runs that belong together: first by the first motion, then by the best fit.

use super::track::{RunTrace, TraceCursor};

/// Least distance of a joint from where it began that counts as motion, rad: well above the noise of a standing arm's
/// sensors.
const MOTION_THRESHOLD: f64 = 0.002;
/// The best shift is searched for this far around the shift of the first motions, s.
const REACH: f64 = 0.5;
/// Steps of the first search, s.
const STEP: f64 = 0.004;
/// Samples that a shift is judged by at most.
const MAX_COST_SAMPLES: usize = 3000;
/// Steps of the last search; each makes the interval 0.618 of what it was.
const REFINEMENTS: usize = 30;

/// How two runs lie over each other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Alignment {
    /// What is at `t` in the first run is at `t + shift` in the second, s.
    pub shift: f64,
    /// When the first run begins to move, s in its own time.
    pub first_motion: Option<f64>,
    /// Time of the first motion in the second run, s.
    pub second_motion: Option<f64>,
}

/// Lays two runs over each other. Where one of them never moves, their beginnings are.
pub fn align(first: &RunTrace, second: &RunTrace) -> Alignment {
    let (first_motion, second_motion) = (motion_of(first), motion_of(second));
    let begin = |track: &RunTrace| track.samples().next().map_or(0.0, |sample| sample.time);
    let (Some(a), Some(b)) = (first_motion, second_motion) else {
        return Alignment {
            shift: begin(second) - begin(first),
            first_motion,
            second_motion,
        };
    };
    let judge = ShiftCost::new(first, second, a);
    let around = b - a;
    let steps = (REACH / STEP).round() as i32;
    let candidates = (-steps..=steps).map(|k| around + f64::from(k) * STEP);
    let mut best = (f64::INFINITY, around);
    for shift in candidates {
        let cost = judge.cost(shift);
        // Of equal ones that nearest to the first motions counts.
        if cost < best.0 || (cost == best.0 && (shift - around).abs() < (best.1 - around).abs()) {
            best = (cost, shift);
        }
    }
    let shift = match best.0.is_finite() {
        true => judge.refined(best.1),
        false => around,
    };
    Alignment {
        shift,
        first_motion,
        second_motion,
    }
}

/// When a joint leaves where it was when the run began.
fn motion_of(track: &RunTrace) -> Option<f64> {
    let start = track
        .samples()
        .find(|sample| sample.q.iter().all(|q| q.is_finite()))?;
    let moved = |q: &[f64; 6]| (0..6).any(|i| (q[i] - start.q[i]).abs() > MOTION_THRESHOLD);
    let sample = track.samples().find(|sample| moved(&sample.q))?;
    Some(sample.time)
}

/// Says how well a shift fits.
struct ShiftCost<'t> {
    /// Samples of the first run, from shortly before its first motion.
    samples: Vec<(f64, [f64; 6])>,
    second: &'t RunTrace,
}

impl<'t> ShiftCost<'t> {
    fn new(first: &RunTrace, second: &'t RunTrace, motion: f64) -> Self {
        let known = first
            .samples()
            .filter(|sample| sample.time >= motion - REACH);
        let known: Vec<_> = known
            .filter(|sample| sample.q.iter().all(|q| q.is_finite()))
            .collect();
        let every = known.len().div_ceil(MAX_COST_SAMPLES).max(1);
        let samples = known
            .iter()
            .step_by(every)
            .map(|sample| (sample.time, sample.q));
        Self {
            samples: samples.collect(),
            second,
        }
    }

    /// Mean square of the joints' differences, rad²; infinite where the runs have less than a tenth of the samples in
    /// common.
    fn cost(&self, shift: f64) -> f64 {
        let mut place = TraceCursor::default();
        let (mut sum, mut count) = (0.0, 0_usize);
        for (time, q) in &self.samples {
            let Some(other) = self.second.at(time + shift, &mut place) else {
                continue;
            };
            let square: f64 = (0..6).map(|i| (other.q[i] - q[i]).powi(2)).sum();
            if square.is_finite() {
                sum += square;
                count += 1;
            }
        }
        // Runs of different lengths still have their beginnings in common.
        let enough = count > 0 && 10 * count >= self.samples.len();
        if enough {
            sum / count as f64
        } else {
            f64::INFINITY
        }
    }

    /// The best shift within a step of this one, by the golden section.
    fn refined(&self, shift: f64) -> f64 {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let (mut low, mut high) = (shift - STEP, shift + STEP);
        let (mut a, mut b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
        let (mut cost_a, mut cost_b) = (self.cost(a), self.cost(b));
        for _ in 0..REFINEMENTS {
            if cost_a <= cost_b {
                (high, b, cost_b) = (b, a, cost_a);
                a = high - GOLDEN * (high - low);
                cost_a = self.cost(a);
            } else {
                (low, a, cost_a) = (a, b, cost_b);
                b = low + GOLDEN * (high - low);
                cost_b = self.cost(b);
            }
        }
        let middle = f64::midpoint(low, high);
        if self.cost(middle) < self.cost(shift) {
            middle
        } else {
            shift
        }
    }
}
