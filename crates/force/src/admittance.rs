//! The law of one force axis: which speed is wanted for the force that is missing.
//!
//! In contact v = e / D, with e the missing force and D = K / ω: whatever the stiffness K, the force then approaches its
//! target like exp(-ω t). ω comes from the gain; K from [`Stiffness`]; the speed is also one from which the arm can
//! stop at the target with the acceleration it has. Without contact a mass is accelerated by the missing force against
//! the user's damping, up to the user's speed limit (manual 4.1 to 4.3).
//!
//! Signs: forces here are what the tool applies to the environment, along the axis.

use crate::stiffness::Stiffness;

/// ω for a gain of 1, rad/s. The default gain of 0.2 makes 20 rad/s: settled to 5 % in 0.15 s. A sampled position
/// loop with some cycles of delay becomes unstable on hard surfaces near 100 rad/s, which the manual says of gains above 1.
const BANDWIDTH: f64 = 100.0;
/// Seconds without touch after which the contact counts as lost.
const LOST_AFTER: f64 = 0.05;

/// Gain that is in force after start (manual 4.2) and its range.
pub const DEFAULT_GAIN: f64 = 0.2;
/// See [`DEFAULT_GAIN`].
pub const GAIN_RANGE: (f64, f64) = (0.0, 2.0);
/// Damping that is in force after start (manual 4.3) and its range.
pub const DEFAULT_DAMPING: f64 = 0.0;
/// See [`DEFAULT_DAMPING`].
pub const DAMPING_RANGE: (f64, f64) = (0.0, 1.0);

/// Along or about an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// m, N.
    Linear,
    /// rad, Nm.
    Angular,
}

/// Figures that differ between the two kinds of axes; our choice.
#[derive(Clone, Copy, Debug)]
struct Figures {
    /// Softest and hardest contact that is reckoned with, N/m or Nm/rad.
    stiffness: (f64, f64),
    /// Least uncertainty of the sensor, N or Nm.
    noise: f64,
    /// Below this share of the target, and this force, nothing is touched.
    touch_share: f64,
    touch: f64,
    /// Virtual mass without contact at the default gain, kg or kg m².
    mass: f64,
    /// Damping in contact at the default gain is at least this, N s/m or Nm s/rad: what a hand feels.
    least_damping: f64,
    /// Without contact the missing force leads at most to the speed e over this, N s/m or Nm s/rad.
    approach: f64,
    /// Damping at a user's setting of 1 at the default gain, N s/m or Nm s/rad.
    full_damping: f64,
}

const LINEAR: Figures = Figures {
    stiffness: (500.0, 1.5e5),
    noise: 0.02,
    touch_share: 0.05,
    touch: 1.0,
    mass: 10.0,
    least_damping: 50.0,
    approach: 1000.0,
    full_damping: 2000.0,
};

const ANGULAR: Figures = Figures {
    stiffness: (5.0, 1500.0),
    noise: 0.002,
    touch_share: 0.05,
    touch: 0.1,
    mass: 0.2,
    least_damping: 1.0,
    approach: 10.0,
    full_damping: 20.0,
};

/// What the user sets for all axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tuning {
    /// 0 to 2.
    pub gain: f64,
    /// 0 to 1.
    pub damping: f64,
}

impl Default for Tuning {
    fn default() -> Self {
        Self {
            gain: DEFAULT_GAIN,
            damping: DEFAULT_DAMPING,
        }
    }
}

/// What is known of the axis in one cycle. Ways and speeds are the TCP's along (about) the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// What the tool applies now, N or Nm.
    pub applied: f64,
    /// What it is to apply.
    pub target: f64,
    /// Way of the arm along the axis since the last cycle, m or rad.
    pub way: f64,
    /// Way sideways since the last cycle, m.
    pub sideways: f64,
    /// Commanded speed now, m/s or rad/s.
    pub speed: f64,
    /// The user's speed limit.
    pub speed_limit: f64,
    /// What the arm can brake with, m/s² or rad/s².
    pub braking: f64,
}

/// The speed to go for, and how fast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// m/s or rad/s.
    pub speed: f64,
    /// No harder than this, m/s² or rad/s²; the arm's own limits apply as well.
    pub acceleration: f64,
}

/// One force axis from cycle to cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Admittance {
    kind: Kind,
    stiffness: Stiffness,
    /// Seconds since the last touch.
    untouched: f64,
    x: f64,
    y: f64,
}

impl Admittance {
    /// An axis that touches nothing yet.
    pub const fn new(kind: Kind) -> Self {
        let figures = figures(kind);
        Self {
            kind,
            stiffness: Stiffness::new(figures.stiffness, figures.noise),
            untouched: LOST_AFTER,
            x: 0.0,
            y: 0.0,
        }
    }

    /// The stiffness it reckons with, N/m or Nm/rad; `None` without contact.
    pub fn contact_stiffness(&self) -> Option<f64> {
        self.is_touching().then(|| self.stiffness.estimate())
    }

    fn is_touching(&self) -> bool {
        self.untouched < LOST_AFTER
    }

    /// The speed to go for in the next cycle of `step` seconds.
    pub fn aim(&mut self, reading: &Reading, tuning: &Tuning, step: f64) -> Aim {
        let figures = figures(self.kind);
        self.look(reading, &figures, step);
        let missing = reading.target - reading.applied;
        let limit = reading.speed_limit;
        // Gain 0 asks for nothing.
        if tuning.gain <= 0.0 || limit <= 0.0 {
            return Aim {
                speed: 0.0,
                acceleration: f64::INFINITY,
            };
        }
        let softer = DEFAULT_GAIN / tuning.gain;
        if self.is_touching() {
            let bandwidth = BANDWIDTH * tuning.gain;
            let user = tuning.damping * figures.full_damping * softer;
            let damping = (self.stiffness.estimate() / bandwidth)
                .max(figures.least_damping * softer)
                .max(user);
            let speed = stoppable(missing / (damping * bandwidth), bandwidth, reading.braking);
            return Aim {
                speed: speed.clamp(-limit, limit),
                acceleration: f64::INFINITY,
            };
        }
        let damping = tuning.damping * figures.full_damping * softer;
        let mass = figures.mass * softer;
        let acceleration = (missing - damping * reading.speed).abs() / mass;
        let most = (missing.abs() / (figures.approach * softer).max(damping)).min(limit);
        // Faster already and nothing that damps: the speed is kept.
        let speed = if damping == 0.0 && reading.speed * missing >= 0.0 {
            let kept = reading.speed.abs().min(limit);
            most.max(kept).copysign(if missing == 0.0 {
                reading.speed
            } else {
                missing
            })
        } else {
            most.copysign(missing)
        };
        Aim {
            speed,
            // What the limit takes away is not the user's to slow down.
            acceleration: if reading.speed.abs() > limit {
                f64::INFINITY
            } else {
                acceleration
            },
        }
    }

    /// Contact or not, and how hard.
    fn look(&mut self, reading: &Reading, figures: &Figures, step: f64) {
        self.x += reading.way;
        // Pressing moves the arm a little sideways too; only sliding counts, on surfaces up to 45 degrees.
        if reading.sideways > reading.way.abs() {
            self.y += reading.sideways;
        }
        let touch = figures
            .touch
            .max(figures.touch_share * reading.target.abs());
        if reading.applied.abs() > touch {
            if !self.is_touching() {
                *self = Self {
                    untouched: 0.0,
                    ..Self::new(self.kind)
                };
            }
            self.untouched = 0.0;
            self.stiffness
                .observe(self.x, self.y, reading.applied, step);
        } else {
            self.untouched = (self.untouched + step).min(LOST_AFTER);
            self.stiffness.restart();
        }
    }
}

/// The speed over the way left: ω x near the target, farther away what `braking` can still take off.
fn stoppable(way: f64, bandwidth: f64, braking: f64) -> f64 {
    let linear = braking / (bandwidth * bandwidth);
    if way.abs() <= linear {
        bandwidth * way
    } else {
        (2.0 * braking * (way.abs() - linear / 2.0))
            .sqrt()
            .copysign(way)
    }
}

const fn figures(kind: Kind) -> Figures {
    match kind {
        Kind::Linear => LINEAR,
        Kind::Angular => ANGULAR,
    }
}
