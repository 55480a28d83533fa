//! What the operating system is asked for beyond what std offers on every system: waking on time, priority, memory,
//! files held beneath folders, processes and their descendants, signals, what the machine says of itself.
//!
//! Owns every call that only Linux, or only POSIX, has; no other crate of the product knows which system it runs on.
//! What a system does not have is either done in the next best way, where only timing or memory suffers, or refused in
//! a sentence that says so, where safety would (docs/platforms.md has the table). Knows nothing of robots, programs or
//! ports.

pub mod beneath;
pub mod clock;
pub mod files;
pub mod machine;
pub mod memory;
pub mod overflow;
pub mod priority;
pub mod processes;
mod said;
pub mod signals;
pub mod sockets;

pub use said::error_text;

/// Refuses what this system cannot do.
#[cfg(not(target_os = "linux"))]
fn needs_linux(what: &str) -> std::io::Error {
    let text = format!("{what} needs Linux, and this is {}", std::env::consts::OS);
    std::io::Error::new(std::io::ErrorKind::Unsupported, text)
}
