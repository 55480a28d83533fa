//! The control cycle: generators, limits, safety and the simulated arm.

pub mod scalar;
