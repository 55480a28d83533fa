//! What of an arm follows from measurements: mass properties and friction are linear in torques and wrenches, so that
//! they are found by least squares.
//!
//! Owns the regressors of rigid bodies, a solver that says what the measurements cannot tell, and fits of frames. Knows
//! no recording. Symbols as in Khalil and Dombre, *Modeling, Identification and Control of Robots*, 2002, chapter 12.

mod least_squares;
mod regressor;
mod tool;

pub use least_squares::{FitError, LeastSquares, Solution};
pub use regressor::{BODY_PARAMETERS, BodyMotion, body_regressor, torque_regressor};
pub use tool::{ToolFit, ToolFitError, fit_tool};
