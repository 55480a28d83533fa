//! The campaign: every target in a child process of its own, watched from outside, and a table at the end.

mod child;
mod shrink;
mod supervisor;

pub use child::{Case, limit_resources, run_cases};
pub use shrink::minimize;
pub use supervisor::{Defect, TargetReport, run_target};
