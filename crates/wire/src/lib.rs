//! Packets of the vendor's ports, from both ends: what `server` writes, `robot-client` reads, and the other way round.
//!
//! Pure: bytes and values, no sockets, no clocks, nothing of our robot. Everything is big-endian. Whatever arrives is
//! bounded and checked; a peer's bytes never panic.

// A module of several files is a folder with a mod.rs, here and in the other crates.
#![warn(clippy::self_named_module_files)]

pub mod primary;
pub mod rtsi;
