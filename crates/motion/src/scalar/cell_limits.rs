//! How fast one may be, accelerate and brake in a cell of a way.
//!
//! Owns what the limits of one cell mean; which they are is planned (`plan/able.rs`), what neighbours leave of them is in `track`.

/// Limits of a cell; unit of the way over powers of seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellLimits {
    /// Largest speed.
    pub speed: f64,
    /// Largest acceleration when speeding up at rest and at that speed; evenly less with the square of the speed in between.
    pub asked: [f64; 2],
    /// The same for slowing down, which bends of the way may make easier than speeding up, or harder.
    pub braking: [f64; 2],
    /// The hardest slowing down that a plan may ask for, at rest and at that speed.
    pub planned: [f64; 2],
    /// The hardest slowing down that the joints can do, at rest and at that speed: for stops, whatever the program asked for.
    pub hardest: [f64; 2],
    /// Largest jerk.
    pub jerk: f64,
}

impl CellLimits {
    /// No limits.
    pub const NONE: Self = Self {
        speed: f64::INFINITY,
        asked: [f64::INFINITY; 2],
        braking: [f64::INFINITY; 2],
        planned: [f64::INFINITY; 2],
        hardest: [f64::INFINITY; 2],
        jerk: f64::INFINITY,
    };

    /// True when they are positive and finite.
    pub fn are_usable(&self) -> bool {
        let [a, b] = self.asked;
        let [c, d] = self.braking;
        let [e, f] = self.hardest;
        let [g, h] = self.planned;
        let all = [self.speed, a, b, c, d, e, f, g, h, self.jerk];
        all.iter().all(|x| x.is_finite() && *x > 0.0)
    }

    /// The same way counted in a unit of which one has `rate` of the present ones.
    #[must_use]
    pub fn counted(&self, rate: f64) -> Self {
        Self {
            speed: self.speed / rate,
            asked: self.asked.map(|a| a / rate),
            braking: self.braking.map(|a| a / rate),
            planned: self.planned.map(|a| a / rate),
            hardest: self.hardest.map(|a| a / rate),
            jerk: self.jerk / rate,
        }
    }

    /// The acceleration left where the square of the speed is `square`.
    pub(super) fn left(&self, [rest, fast]: [f64; 2], square: f64) -> f64 {
        rest + (fast - rest) * (square / (self.speed * self.speed)).min(1.0)
    }

    /// What is left of them at a pace, where accelerations are reached within `window` seconds.
    pub(super) fn paced(&self, pace: f64, window: f64) -> Self {
        let most = self.jerk * window;
        // At a lower speed bends leave more of what the joints can do.
        let at_pace = |[rest, fast]: [f64; 2]| {
            [rest, rest + (fast - rest) * pace * pace].map(|a| a.min(most))
        };
        Self {
            speed: self.speed * pace,
            asked: self.asked.map(|a| (a * pace * pace).min(most)),
            braking: self.braking.map(|a| (a * pace * pace).min(most)),
            planned: at_pace(self.planned),
            hardest: at_pace(self.hardest),
            jerk: self.jerk,
        }
    }

    /// The lower of both, each at its own speed.
    pub fn lower(&mut self, other: &Self) {
        self.speed = self.speed.min(other.speed);
        for k in 0..2 {
            self.asked[k] = self.asked[k].min(other.asked[k]);
            self.braking[k] = self.braking[k].min(other.braking[k]);
            self.planned[k] = self.planned[k].min(other.planned[k]);
            self.hardest[k] = self.hardest[k].min(other.hardest[k]);
        }
        self.jerk = self.jerk.min(other.jerk);
    }
}
