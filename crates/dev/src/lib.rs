//! Hostile inputs for everything that reads bytes from outside, and what must hold for each.
//!
//! The targets are functions of bytes that panic when a promise is broken. The same functions run in the campaign
//! (`cargo dev campaign`), in ordinary tests with fixed seeds, and under libFuzzer (`fuzz/`).

pub mod campaign;
pub mod language;
pub mod library_programs;
#[cfg(feature = "ports")]
pub mod mcap_file;
pub mod mutation;
#[cfg(feature = "names")]
pub mod names;
pub mod programs;
#[cfg(feature = "ports")]
pub mod reference;
pub mod targets;
pub mod unstructured;
