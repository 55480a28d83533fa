//! How fast one may be, accelerate and brake in a cell of a way.
//!
//! Owns what the limits of one cell mean; which they are is planned (`plan/able.rs`), what neighbours leave of them is
//! in `track`.

/// Limits of a cell; unit of the way over powers of seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntervalLimits {
    /// Largest speed.
    pub speed: f64,
    /// Largest acceleration when speeding up at rest and at that speed; evenly less with the square of the speed in
    /// between.
    pub asked: [f64; 2],
    /// Largest deceleration at rest and at that speed; bends of the way may make it smaller or larger than `asked`.
    pub braking: [f64; 2],
    /// The hardest slowing down that a plan may ask for, at rest and at that speed: every limit is kept, that of the
    /// jerk as well.
    pub planned: [f64; 2],
    /// The hardest slowing down that the joints can do, at rest and at that speed: for stops, whatever the program
    /// asked for.
    pub max_braking: [f64; 2],
    /// Largest jerk.
    pub jerk: f64,
}

/// How much slower a way is gone along than it could be, so that it takes the time that is wanted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Share of the speeds, and its square of the accelerations: the motion is the same, stretched.
    pub share: f64,
    /// The most that the speed may be besides.
    pub speed: f64,
    /// The most that speeding up and slowing down may be besides.
    pub acceleration: f64,
}

impl Pace {
    /// No slowing down: the way is gone along as fast as it can be.
    pub const FULL: Self = Self::stretched(1.0);

    /// The pace of a motion that takes its way at a share of its speed.
    pub const fn stretched(share: f64) -> Self {
        Self {
            share,
            speed: f64::INFINITY,
            acceleration: f64::INFINITY,
        }
    }
}

impl IntervalLimits {
    /// No limits.
    pub const NONE: Self = Self {
        speed: f64::INFINITY,
        asked: [f64::INFINITY; 2],
        braking: [f64::INFINITY; 2],
        planned: [f64::INFINITY; 2],
        max_braking: [f64::INFINITY; 2],
        jerk: f64::INFINITY,
    };

    /// True when all limits are positive and finite.
    pub fn are_usable(&self) -> bool {
        let [a, b] = self.asked;
        let [c, d] = self.braking;
        let [e, f] = self.max_braking;
        let [g, h] = self.planned;
        let all = [self.speed, a, b, c, d, e, f, g, h, self.jerk];
        all.iter().all(|x| x.is_finite() && *x > 0.0)
    }

    /// The limits counted in another unit of the way, of which one has `rate` of the present ones.
    #[must_use]
    pub fn reparametrized(&self, rate: f64) -> Self {
        Self {
            speed: self.speed / rate,
            asked: self.asked.map(|a| a / rate),
            braking: self.braking.map(|a| a / rate),
            planned: self.planned.map(|a| a / rate),
            max_braking: self.max_braking.map(|a| a / rate),
            jerk: self.jerk / rate,
        }
    }

    /// The acceleration left where the square of the speed is `square`.
    pub(super) fn acceleration_at(&self, [rest, fast]: [f64; 2], square: f64) -> f64 {
        rest + (fast - rest) * (square / (self.speed * self.speed)).min(1.0)
    }

    /// What is left of the limits at a pace, where accelerations are reached within `window` seconds.
    pub(super) fn scaled(&self, pace: &Pace, window: f64) -> Self {
        let most = self.jerk * window;
        let square = pace.share * pace.share;
        let asked = most.min(pace.acceleration);
        // At a lower speed bends leave more of what the joints can do.
        let at_share = |[rest, fast]: [f64; 2]| [rest, rest + (fast - rest) * square];
        let stretched = Self {
            speed: self.speed * pace.share,
            asked: self.asked.map(|a| a * square),
            braking: self.braking.map(|a| a * square),
            planned: at_share(self.planned),
            max_braking: at_share(self.max_braking),
            ..*self
        };
        let slowed = stretched.up_to(pace.speed);
        Self {
            asked: slowed.asked.map(|a| a.min(asked)),
            braking: slowed.braking.map(|a| a.min(asked)),
            planned: slowed.planned.map(|a| a.min(most)),
            max_braking: slowed.max_braking.map(|a| a.min(most)),
            ..slowed
        }
    }

    /// The limits where nobody is faster than `speed`.
    pub(super) fn up_to(&self, speed: f64) -> Self {
        if speed >= self.speed {
            return *self;
        }
        let left = |pair: [f64; 2]| [pair[0], self.acceleration_at(pair, speed * speed)];
        Self {
            speed,
            asked: left(self.asked),
            braking: left(self.braking),
            planned: left(self.planned),
            max_braking: left(self.max_braking),
            jerk: self.jerk,
        }
    }

    /// Slows down so many times as hard as asked, as far as that is possible.
    pub(super) fn brake_harder(&mut self, times: f64) {
        for k in 0..2 {
            let most = self.planned[k].max(self.braking[k]);
            self.braking[k] = (times * self.braking[k]).min(most);
        }
    }

    /// The lower of both.
    pub fn restrict_to(&mut self, other: &Self) {
        let other = other.up_to(self.speed);
        *self = self.up_to(other.speed);
        for k in 0..2 {
            self.asked[k] = self.asked[k].min(other.asked[k]);
            self.braking[k] = self.braking[k].min(other.braking[k]);
            self.planned[k] = self.planned[k].min(other.planned[k]);
            self.max_braking[k] = self.max_braking[k].min(other.max_braking[k]);
        }
        self.jerk = self.jerk.min(other.jerk);
    }
}
