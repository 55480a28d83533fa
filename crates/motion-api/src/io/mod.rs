//! Inputs and outputs as one small image: levels, analog values, how the points are configured, and what changes them.
//!
//! The motion thread owns the image, samples and applies it once a cycle; everybody else sends an [`IoChange`] or reads
//! the image of the latest cycle. Registers are not here: they change at once and live in
//! [`Registers`](crate::Registers).
//!
//! - `points`: which points there are, and what their numbers mean.
//! - `config`: how points are set up.
//! - `change`: what can be asked of them.
//! - `image`: their levels, and how a change is applied.

mod change;
mod config;
mod image;
mod points;

pub use change::IoChange;
pub use config::{InputAction, IoConfig, RunStateChoice, ToolPin};
pub use image::IoImage;
pub use points::{
    ANALOG_POINTS, AnalogDomain, DIGITAL_MASK, DIGITAL_POINTS, DigitalBank, IoPoint, TOOL_ANALOG,
};
