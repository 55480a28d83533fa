//! The commands of the command line, one file each. Every one returns its exit status.

pub mod builtins;
pub mod check;
pub mod run;
pub mod serve;
