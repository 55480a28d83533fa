//! What can be wrong with a configuration, in sentences for whoever wrote it.

use messages::{Localized, Text};
use thiserror::Error;

/// What is wrong with a configuration.
#[derive(Clone, Debug, PartialEq, Error, Localized)]
#[non_exhaustive]
pub enum ConfigError {
    /// The cycle is too short or too long.
    #[error("the step time is {given_s} s, allowed are 0.001 to 0.008 s")]
    #[zh("步长为 {given_s} s，允许 0.001 到 0.008 s")]
    StepTime {
        /// The step time as it was given, s.
        given_s: f64,
    },
    /// The start position is outside a joint's range.
    #[error(
        "home puts joint {} at {value:.4} rad, allowed is {min:.4} to {max:.4} rad",
        joint + 1
    )]
    #[zh("home 使关节 {} 位于 {value:.4} rad，允许 {min:.4} 到 {max:.4} rad", joint + 1)]
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
    #[zh("力控模式：{0}")]
    Force(#[from] force::LimiterError),
    /// A number is NaN or infinite.
    #[error("{name} has a component that is not a finite number")]
    #[zh("{name} 有分量不是有限的数")]
    NotFinite {
        /// The name of the setting.
        name: &'static str,
    },
    /// A limit is not positive, or wider than what the arm can do.
    #[error("limit {name} of joint {} is {given}, allowed is {least} up to the arm's {own}", joint + 1)]
    #[zh("关节 {} 的限值 {name} 为 {given}，允许 {least} 到机械臂的 {own}", joint + 1)]
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
    #[zh("关节 {} 的位置范围为 {min} 到 {max} rad；不能为空，且必须在机械臂的 {own_min:.4} 到 {own_max:.4} rad 之内", joint + 1)]
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
    #[zh("限值 {name} 为 {given} {unit}，至少应为 {least}")]
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
    #[zh("限值 {name} 为 {given} {unit}，不能超过缩减模式之外的 {normal} {unit}")]
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
    #[zh("{ring} 缓冲区有 {given} 项，至少需要 {needed} 项")]
    RingTooSmall {
        /// The name of the ring.
        ring: Text,
        /// The size of the ring as it was given, entries.
        given: usize,
        /// Size needed.
        needed: usize,
    },
    /// The arm's masses cannot be simulated.
    #[error("the arm cannot be simulated: {what}")]
    #[zh("无法仿真机械臂：{what}")]
    Plant {
        /// The reason, in words.
        what: Text,
    },
}
