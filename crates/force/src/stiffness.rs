//! How hard the environment is: the slope of the force over the way, estimated while the tool presses.
//!
//! Linear regression F = c + K x + b y over an exponential window, where x is the way along the force axis and y the
//! way sideways: on a tilted surface the force stays although x moves, and b explains that instead of K. The estimate
//! is held inside the confidence interval of K and moves no further than that interval demands: data without motion say
//! nothing and change nothing, and what is not known yet counts as hard, which is the safe side for a controller. While
//! the tool slides a surface is taken for softer only if the way explains the force: an edge, or a turn of the motion,
//! bends the surface in the window, and a force that is kept well over that would look like no stiffness at all.

use kinematics::bounds::within;
use kinematics::elementary::exp;
/// Length of the window, s.
const WINDOW: f64 = 0.06;
/// Sliding counts for this many windows.
const SLIDING_WINDOWS: f64 = 4.0;
/// Share of the variance of the force that the way must explain while the tool slides.
const MIN_R_SQUARED: f64 = 0.95;
/// Half width of the confidence interval in standard deviations.
const CONFIDENCE: f64 = 2.0;

/// The estimate for one axis: N/m or Nm/rad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffness {
    range: (f64, f64),
    /// Standard deviation that a force has at least, N or Nm.
    noise: f64,
    /// Ways sideways below have no say, m.
    sideways_min: f64,
    /// Seconds until the window holds no sliding any more.
    sliding: f64,
    last_y: f64,
    estimate: f64,
    count: f64,
    /// Means of x, y and F in the window.
    mean: [f64; 3],
    /// Sums of products of the deviations: xx, xy, xF, yy, yF, FF.
    sums: [f64; 6],
}

impl Stiffness {
    /// Nothing known yet: as hard as `range` allows. `noise` is the least uncertainty of a force.
    pub const fn new(range: (f64, f64), noise: f64) -> Self {
        Self {
            range,
            noise,
            sideways_min: 1e-8,
            sliding: 0.0,
            last_y: 0.0,
            estimate: range.1,
            count: 0.0,
            mean: [0.0; 3],
            sums: [0.0; 6],
        }
    }

    /// What counts as the stiffness now; rather too hard than too soft.
    pub const fn estimate(&self) -> f64 {
        self.estimate
    }

    /// Forgets the data but not the estimate: the tool touches again.
    pub const fn restart(&mut self) {
        self.count = 0.0;
        self.sums = [0.0; 6];
    }

    /// Takes a sample: the way `x` along the axis, the way `y` sideways, and the `force` applied along the axis.
    pub fn observe(&mut self, x: f64, y: f64, force: f64, step: f64) {
        let sample = [x, y, force];
        self.sliding = if y == self.last_y {
            (self.sliding - step).max(0.0)
        } else {
            SLIDING_WINDOWS * WINDOW
        };
        self.last_y = y;
        let keep = exp(-step / WINDOW);
        let before = keep * self.count;
        self.count = before + 1.0;
        let deviation: [f64; 3] = core::array::from_fn(|k| sample[k] - self.mean[k]);
        if before == 0.0 {
            self.mean = sample;
            return;
        }
        let share = before / self.count;
        let pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
        for (sum, (a, b)) in self.sums.iter_mut().zip(pairs) {
            *sum = keep * *sum + share * deviation[a] * deviation[b];
        }
        for (mean, d) in self.mean.iter_mut().zip(deviation) {
            *mean += d / self.count;
        }
        if self.count > 2.5 {
            self.update();
        }
    }

    fn update(&mut self) {
        let [xx, xy, xf, yy, yf, ff] = self.sums;
        // The part that the way sideways explains is taken out first.
        let ridge = self.count * self.sideways_min * self.sideways_min;
        let (xx, xf, ff) = (
            xx - xy * xy / (yy + ridge),
            xf - xy * yf / (yy + ridge),
            ff - yf * yf / (yy + ridge),
        );
        // A nanometre is no motion.
        if xx < self.count * 1e-18 {
            return;
        }
        let slope = xf / xx;
        let residual = (ff - slope * xf).max(0.0) / self.count + self.noise * self.noise;
        let wide = CONFIDENCE * (residual / xx).sqrt();
        // Falling force on the way in: the environment itself moves.
        if !(slope + wide > 0.0 && wide.is_finite()) {
            return;
        }
        let is_explained = slope * xf >= MIN_R_SQUARED * ff;
        let softest = if self.sliding > 0.0 && !is_explained {
            self.estimate
        } else {
            slope + wide
        };
        let estimate = self.estimate.min(softest).max(slope - wide);
        self.estimate = within(estimate, self.range.0, self.range.1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: f64 = 0.004;

    fn fresh() -> Stiffness {
        Stiffness::new((500.0, 1.5e5), 0.02)
    }

    #[test]
    fn a_spring_is_found_and_never_taken_for_much_softer() {
        for k in [1e3, 1e4, 1e5] {
            let mut stiffness = fresh();
            for i in 0..60 {
                let x = 2.0 / k * (1.0 - (-f64::from(i) * 0.05).exp());
                stiffness.observe(x, 0.0, k * x, STEP);
                assert!(stiffness.estimate() > 0.95 * k);
            }
            assert!(
                (stiffness.estimate() / k - 1.0).abs() < 0.1,
                "{k}: {}",
                stiffness.estimate()
            );
        }
    }

    #[test]
    fn without_motion_the_estimate_stays_whatever_the_noise() {
        let mut stiffness = fresh();
        for i in 0..50 {
            let x = f64::from(i) * 1e-5;
            stiffness.observe(x, 0.0, 1e4 * x, STEP);
        }
        let found = stiffness.estimate();
        let mut seed = 1_u32;
        for _ in 0..5000 {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = f64::from(seed >> 8) / f64::from(1 << 24) - 0.5;
            stiffness.observe(49e-5 + 1e-9 * noise, 0.0, 4.9 + noise, STEP);
        }
        assert!((stiffness.estimate() / found - 1.0).abs() < 0.05);
    }

    #[test]
    fn a_tilted_surface_is_not_taken_for_a_soft_one() {
        let mut stiffness = fresh();
        for i in 0..50 {
            let x = f64::from(i) * 1e-5;
            stiffness.observe(x, 0.0, 1e4 * x, STEP);
        }
        let found = stiffness.estimate();
        // Sliding: x follows the slope, the force only trembles.
        for i in 0..500 {
            let y = f64::from(i) * 2e-4;
            let tremble = 1e-6 * (f64::from(i) * 0.3).sin();
            stiffness.observe(5e-4 + 0.3 * y + tremble, y, 5.0 + 1e4 * tremble, STEP);
            assert!(
                stiffness.estimate() > 0.9 * found,
                "{i}: {}",
                stiffness.estimate()
            );
        }
    }

    #[test]
    fn an_edge_and_a_turn_are_not_taken_for_softness() {
        for turn in [-1.0, 0.3] {
            let mut stiffness = fresh();
            for i in 0..50 {
                let x = f64::from(i) * 1e-5;
                stiffness.observe(x, 0.0, 1e4 * x, STEP);
            }
            let found = stiffness.estimate();
            // The slope changes after a second; the force only trembles.
            for i in 0..500 {
                let y = f64::from(i) * 2e-4;
                let after = (f64::from(i) - 250.0).max(0.0) * 2e-4;
                let tremble = 1e-6 * (f64::from(i) * 0.3).sin();
                let surface = 5e-4 + 0.2 * y + (0.2 * turn - 0.2) * after;
                stiffness.observe(surface + tremble, y, 5.0 + 1e4 * tremble, STEP);
                assert!(
                    stiffness.estimate() > 0.8 * found,
                    "{i}: {}",
                    stiffness.estimate()
                );
            }
        }
    }

    #[test]
    fn a_harder_spring_is_noticed() {
        let mut stiffness = fresh();
        for i in 0..100 {
            let x = f64::from(i) * 1e-5;
            stiffness.observe(x, 0.0, 1e3 * x, STEP);
        }
        assert!(stiffness.estimate() < 5e3);
        for i in 0..200 {
            let x = 1e-3 + 5e-6 * (f64::from(i) * 0.2).sin();
            stiffness.observe(x, 0.0, 1.0 + 1e5 * (x - 1e-3), STEP);
        }
        assert!(stiffness.estimate() > 5e4, "{}", stiffness.estimate());
    }
}
