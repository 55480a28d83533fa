//! What editors talk to: a language server ([`lsp`]) and a debugger whose runs can be walked both ways ([`dap`]).
//!
//! Owns the loops of both protocols, the analysis on top of `elite-lang`'s trees, and the repeated runs behind a step
//! back. Knows no port and no command line; both speak over a reader and a writer that they are given.

// No thread starts but through `supervision`; nothing waits for, or panics at, whoever reads our output.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub mod analysis;
pub mod dap;
mod framing;
pub mod lsp;
