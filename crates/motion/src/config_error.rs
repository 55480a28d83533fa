//! What can be wrong with a configuration, in sentences for whoever wrote it.

use thiserror::Error;

/// What is wrong with a configuration.
#[derive(Clone, Debug, PartialEq, Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// The cycle is too short or too long.
    #[error("the step time is {given_s} s, allowed are 0.001 to 0.008 s")]
    StepTime {
        /// The step time as it was given, s.
        given_s: f64,
    },
    /// The start position is outside a joint's range.
    #[error(
        "home puts joint {} at {value:.4} rad, allowed is {min:.4} to {max:.4} rad",
        joint + 1
    )]
    Home {
        /// Joint from 0.
        joint: usize,
        /// The position as it was given, rad.
        value: f64,
        /// Lower limit, rad.
        min: f64,
        /// Upper limit, rad.
        max: f64,
    },
    /// The limiter of force mode cannot be made.
    #[error("force mode: {0}")]
    Force(#[from] force::LimiterError),
    /// A number is NaN or infinite.
    #[error("{name} has a component that is not a finite number")]
    NotFinite {
        /// The name of the setting.
        name: &'static str,
    },
    /// A limit is not positive, or wider than what the arm can do.
    #[error("limit {name} of joint {} is {given}, allowed is {least} up to the arm's {own}", joint + 1)]
    JointLimit {
        /// Name of the key.
        name: &'static str,
        /// Joint from 0.
        joint: usize,
        /// The limit as it was given, in rad and s.
        given: f64,
        /// The smallest that motions are made for.
        least: f64,
        /// The arm's own limit.
        own: f64,
    },
    /// A position range is empty or reaches beyond the arm's.
    #[error(
        "the position range of joint {} is {min} to {max} rad; it must not be empty and must lie within the \
         arm's {own_min:.4} to {own_max:.4} rad",
        joint + 1
    )]
    PositionRange {
        /// Joint from 0.
        joint: usize,
        /// Lower end as given, rad.
        min: f64,
        /// Upper end as given, rad.
        max: f64,
        /// The arm's lower end, rad.
        own_min: f64,
        /// The arm's upper end, rad.
        own_max: f64,
    },
    /// A limit of speed or force that is not positive.
    #[error("limit {name} is {given} {unit}, it must be at least {least}")]
    Speed {
        /// Name of the key.
        name: &'static str,
        /// The limit as it was given.
        given: f64,
        /// The smallest that motions are made for.
        least: f64,
        /// The unit of the limit.
        unit: &'static str,
    },
    /// A limit of reduced mode above the one outside of it.
    #[error(
        "limit {name} is {given} {unit}, it must not be more than the {normal} {unit} outside of reduced mode"
    )]
    AboveNormal {
        /// Name of the key.
        name: &'static str,
        /// The limit of reduced mode as it was given.
        given: f64,
        /// The limit outside of reduced mode.
        normal: f64,
        /// The unit of the limit.
        unit: &'static str,
    },
    /// A ring of the border is too small for the promises made about it.
    #[error("the {ring} ring holds {given} entries, at least {needed} are needed")]
    RingTooSmall {
        /// The name of the ring.
        ring: &'static str,
        /// The size of the ring as it was given, entries.
        given: usize,
        /// Size needed.
        needed: usize,
    },
    /// The arm's masses cannot be simulated.
    #[error("the arm cannot be simulated: {what}")]
    Plant {
        /// The reason, in words.
        what: &'static str,
    },
}
