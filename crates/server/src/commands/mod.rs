//! The commands of the command line, one file each. Every one returns its exit status.

pub mod builtins;
pub mod calibrate;
pub mod check;
pub mod compare;
pub mod debug;
pub mod doctor;
pub mod fleet;
pub mod lsp;
pub mod mcp;
pub mod record;
mod robot_consent;
pub mod run;
pub mod send;
pub mod serve;
pub mod shell;
pub mod shell_files;
pub mod test;
