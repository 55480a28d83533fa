//! Packets of the vendor's ports, from both ends: what `server` writes, `robot-client` reads, and the other way round.
//!
//! Pure: bytes and values, no sockets, no clocks, nothing of our robot. Everything is big-endian. Whatever arrives is
//! bounded and checked; a peer's bytes never panic.

pub mod primary;
pub mod rtsi;
