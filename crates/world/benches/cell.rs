//! What a cell costs.

fn main() {}
