//! Tests of the syntax as editors and interpreters see it, in one binary: a file each.

mod agreement;
mod reparse;
