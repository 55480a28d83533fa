//! Tests of force mode and its limits, in one binary: a file each.

mod contact;
mod limiter;
