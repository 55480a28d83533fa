//! The law of one force axis: which speed is wanted for the force that is missing.
//!
//! In contact v = e / D + s, with e the missing force and D = K / ω: whatever the stiffness K, the force then
//! approaches its target like exp(-ω t). ω comes from the gain; K from [`Stiffness`]; s is the speed at which the
//! surface itself recedes while the tool slides over it. The speed is also one from which the arm can stop at the
//! target with the acceleration it has. Without contact a mass is accelerated by the missing force against the user's
//! damping, up to the user's speed limit (manual 4.1 to 4.3) and no faster than what a touch of the hardest surface
//! leaves room for.
//!
//! Signs: forces here are what the tool applies to the environment, along the axis.

use crate::stiffness::Stiffness;
use kinematics::bounds::within;

/// ω for a gain of 1, rad/s. The default gain of 0.2 makes 25 rad/s: settled to 5 % in 0.12 s. A sampled position loop
/// with some cycles of delay becomes unstable on hard surfaces above 125 rad/s, which the manual says of gains above 1.
const BANDWIDTH: f64 = 125.0;
/// Time over which the speed of the surface is averaged, s.
const SURFACE_TIME: f64 = 0.02;
/// The hardest surface that an approach reckons with, as share of the hardest that is estimated.
const APPROACH_SHARE: f64 = 2.0 / 3.0;
/// Share of the braking that an approach accelerates with: a touch then finds little to turn round.
const APPROACH_ACCELERATION: f64 = 0.3;
/// Cycles before a touch shows in the command.
const DELAY_CYCLES: f64 = 1.0;
/// Slower than this sideways nothing slides, m/s.
const SLIDING: f64 = 1e-3;
/// Time over which the noise of the sensor is looked at, s.
const NOISE_TIME: f64 = 0.2;
/// Number of standard deviations of the sensor's noise that are no touch.
const NOISE_WIDTH: f64 = 4.0;
/// Seconds without touch after which the contact counts as lost.
const LOST_AFTER: f64 = 0.05;

/// Gain that is in force after start (manual 4.2).
pub const DEFAULT_GAIN: f64 = 0.2;
/// Gains that a program may set (manual 4.2).
pub const GAIN_RANGE: (f64, f64) = (0.0, 2.0);
/// Damping that is in force after start (manual 4.3).
pub const DEFAULT_DAMPING: f64 = 0.0;
/// Dampings that a program may set (manual 4.3).
pub const DAMPING_RANGE: (f64, f64) = (0.0, 1.0);

/// Along or about an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisKind {
    /// m, N.
    Linear,
    /// rad, Nm.
    Angular,
}

/// Figures that differ between the two kinds of axes; our choice.
#[derive(Clone, Copy, Debug)]
struct AxisConstants {
    /// Softest and hardest contact that is reckoned with, N/m or Nm/rad.
    stiffness: (f64, f64),
    /// Least uncertainty of the sensor, N or Nm.
    noise: f64,
    /// Below this share of the target, this force and the noise nothing is touched.
    touch_share: f64,
    touch_threshold: f64,
    /// Virtual mass without contact at the default gain, kg or kg m².
    mass: f64,
    /// Damping in contact at the default gain is at least this, N s/m or Nm s/rad: what a hand feels.
    least_damping: f64,
    /// Damping at a user's setting of 1 at the default gain, N s/m or Nm s/rad.
    full_damping: f64,
}

const LINEAR: AxisConstants = AxisConstants {
    stiffness: (500.0, 1.5e5),
    noise: 0.005,
    touch_share: 0.02,
    touch_threshold: 0.3,
    mass: 10.0,
    least_damping: 50.0,
    full_damping: 2000.0,
};

const ANGULAR: AxisConstants = AxisConstants {
    stiffness: (5.0, 1500.0),
    noise: 0.0005,
    touch_share: 0.02,
    touch_threshold: 0.03,
    mass: 0.2,
    least_damping: 1.0,
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
pub struct AxisReading {
    /// What the tool applies now, N or Nm.
    pub applied: f64,
    /// What the tool is to apply, N or Nm.
    pub target: f64,
    /// Way of the arm along the axis since the last cycle, m or rad.
    pub displacement: f64,
    /// Way sideways since the last cycle, m.
    pub tangential_displacement: f64,
    /// Commanded speed now, m/s or rad/s.
    pub speed: f64,
    /// The user's speed limit.
    pub speed_limit: f64,
    /// What the arm can brake with, m/s² or rad/s².
    pub braking: f64,
    /// How fast the arm can change that deceleration, m/s³ or rad/s³.
    pub jerk: f64,
}

/// The speed to go for, and how fast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedTarget {
    /// m/s or rad/s.
    pub speed: f64,
    /// No harder than this, m/s² or rad/s²; the arm's own limits apply as well.
    pub acceleration: f64,
}

/// One force axis from cycle to cycle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Admittance {
    kind: AxisKind,
    stiffness: Stiffness,
    /// Seconds since the last touch.
    time_without_contact: f64,
    x: f64,
    y: f64,
    /// What the tool applied a cycle ago.
    applied: f64,
    /// Variance of the sensor's noise, N² or (Nm)².
    noise_variance: f64,
    /// Speed of the surface along the axis while the tool slides, m/s or rad/s.
    surface_speed: f64,
}

impl Admittance {
    /// An axis that touches nothing yet.
    pub const fn new(kind: AxisKind) -> Self {
        let figures = axis_constants(kind);
        Self {
            kind,
            stiffness: Stiffness::new(figures.stiffness, figures.noise),
            time_without_contact: LOST_AFTER,
            x: 0.0,
            y: 0.0,
            applied: 0.0,
            noise_variance: 0.0,
            surface_speed: 0.0,
        }
    }

    fn is_touching(&self) -> bool {
        self.time_without_contact < LOST_AFTER
    }

    /// The speed to go for in the next cycle of `step` seconds.
    pub fn update(&mut self, reading: &AxisReading, tuning: &Tuning, step: f64) -> SpeedTarget {
        let figures = axis_constants(self.kind);
        self.update_contact(reading, &figures, step);
        let missing = reading.target - reading.applied;
        let limit = reading.speed_limit;
        // Gain 0 asks for nothing.
        if tuning.gain <= 0.0 || limit <= 0.0 {
            return SpeedTarget {
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
            let way = missing / (damping * bandwidth);
            let speed = braking_speed(way, bandwidth, reading.braking);
            return SpeedTarget {
                speed: within(speed + self.surface_speed, -limit, limit),
                acceleration: f64::INFINITY,
            };
        }
        let damping = tuning.damping * figures.full_damping * softer;
        let mass = figures.mass * softer;
        let acceleration = ((missing - damping * reading.speed).abs() / mass)
            .min(APPROACH_ACCELERATION * reading.braking);
        // A touch may press in as far as the target does on the hardest surface.
        let room = missing.abs() / (APPROACH_SHARE * figures.stiffness.1 * softer);
        let approach = approach_speed(room, reading.braking, reading.jerk, DELAY_CYCLES * step);
        let damped = if damping > 0.0 {
            missing.abs() / damping
        } else {
            f64::INFINITY
        };
        let most = approach.min(damped).min(limit);
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
        SpeedTarget {
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
    fn update_contact(&mut self, reading: &AxisReading, figures: &AxisConstants, step: f64) {
        self.x += reading.displacement;
        // Pressing moves the arm a little sideways too; only sliding counts, on surfaces up to 45 degrees.
        let is_sliding = self.is_touching()
            && reading.tangential_displacement > reading.displacement.abs()
            && reading.tangential_displacement > SLIDING * step;
        let surface = if is_sliding {
            self.y += reading.tangential_displacement;
            (reading.displacement - (reading.applied - self.applied) / self.stiffness.estimate())
                / step
        } else {
            0.0
        };
        self.surface_speed += (surface - self.surface_speed) * step / (SURFACE_TIME + step);
        // Small forces that follow each other are as good as none: they show the noise.
        let quiet = (NOISE_WIDTH * figures.touch_threshold).max(0.1 * reading.target.abs());
        if reading.applied.abs().max(self.applied.abs()) < quiet {
            let change = reading.applied - self.applied;
            self.noise_variance +=
                (change * change / 2.0 - self.noise_variance) * step / (NOISE_TIME + step);
        }
        self.applied = reading.applied;
        let touch = figures
            .touch_threshold
            .max(figures.touch_share * reading.target.abs())
            .max(NOISE_WIDTH * self.noise_variance.sqrt());
        if reading.applied.abs() > touch {
            if !self.is_touching() {
                *self = Self {
                    time_without_contact: 0.0,
                    applied: reading.applied,
                    noise_variance: self.noise_variance,
                    ..Self::new(self.kind)
                };
            }
            self.time_without_contact = 0.0;
            self.stiffness
                .observe(self.x, self.y, reading.applied, step);
        } else {
            // A hand that lets go is no bounce: the arm coasts at once. What gave way like nothing was a hand.
            let was_led = reading.target == 0.0 && self.stiffness.estimate() <= figures.stiffness.0;
            self.time_without_contact = if was_led {
                LOST_AFTER
            } else {
                (self.time_without_contact + step).min(LOST_AFTER)
            };
            self.stiffness.restart();
        }
    }
}

/// The speed over the way left: ω x near the target, farther away what `braking` can still take off.
fn braking_speed(way: f64, bandwidth: f64, braking: f64) -> f64 {
    let linear = braking / (bandwidth * bandwidth);
    if way.abs() <= linear {
        bandwidth * way
    } else {
        (2.0 * braking * (way.abs() - linear / 2.0))
            .sqrt()
            .copysign(way)
    }
}

/// The speed from which the way to rest, begun `delay` seconds late, is at most `room`.
fn approach_speed(room: f64, braking: f64, jerk: f64, delay: f64) -> f64 {
    let way = |v: f64| {
        // Without and with a time of constant deceleration.
        let own = if v * jerk < braking * braking {
            v * (v / jerk).sqrt()
        } else {
            v * (v / braking + braking / jerk) / 2.0
        };
        own + v * delay
    };
    let (mut good, mut bad) = (0.0, room / delay);
    for _ in 0..30 {
        let middle = 0.5 * (good + bad);
        if way(middle) <= room {
            good = middle;
        } else {
            bad = middle;
        }
    }
    good
}

const fn axis_constants(kind: AxisKind) -> AxisConstants {
    match kind {
        AxisKind::Linear => LINEAR,
        AxisKind::Angular => ANGULAR,
    }
}
