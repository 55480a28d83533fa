//! Tests of recordings as their readers see them, in one binary: a file each.

mod support;

mod cell_files;
mod earlier_versions;
mod faults;
mod floods;
mod kill_safety;
mod meshes;
mod rotation;
mod round_trip;
mod slow_disk;
mod topics;
