//! Tests of controllers without ports, in one binary: a file each.

mod many;
mod stepped;
