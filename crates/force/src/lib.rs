//! Force control: what turns a wanted TCP twist into joint speeds the arm can have.
//!
//! For now one piece: [`TwistLimiter`], the quadratic program behind every mode in which the TCP's velocity is wanted
//! rather than a path (force mode, freedrive, speed control in Cartesian space). No mode of the control cycle uses it
//! yet; the admittance law and the task frames that feed it do not exist.

mod limiter;

pub use limiter::{Limited, LimiterError, SpeedLimits, TwistLimiter};
