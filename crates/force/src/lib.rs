//! Force control: from the wrench that is felt and the wrench that is wanted to joint speeds the arm can have.
//!
//! - [`frame`]: where the axes of force control point (manual 4.1, modes 0 to 3).
//! - [`stiffness`]: how hard the environment is, from what position and force say while the tool moves.
//! - [`admittance`]: the speed wanted along one axis; its damping follows the stiffness.
//! - [`limiter`]: the joint speeds nearest to a wanted twist, a quadratic program.
//!
//! Knows no cycle, no commands and no plant: the control cycle of `motion` calls these once a cycle with numbers.

// Results are the same on every machine, and crossed bounds are no panic.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod admittance;
pub mod frame;
pub mod limiter;
pub mod stiffness;

pub use admittance::{Admittance, AxisKind, AxisReading, SpeedTarget, Tuning};
pub use frame::{FrameMode, TaskFrame};
pub use limiter::{LimiterError, SolveMethod, TwistLimiter, TwistProblem, TwistSolution};
pub use stiffness::Stiffness;
