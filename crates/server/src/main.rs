//! The `eliteserver` binary.
fn main() {}
