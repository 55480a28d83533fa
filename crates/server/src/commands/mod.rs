//! The commands of the command line, one file each. Every one returns a [`CommandResult`](crate::command::CommandResult).

pub mod builtins;
pub mod calibrate;
pub mod cell;
pub mod check;
pub mod clearance;
pub mod compare;
pub mod completions;
pub mod debug;
pub mod doctor;
pub mod fleet;
mod line_input;
pub mod lsp;
pub mod man;
pub mod mcp;
pub mod plan;
mod program_output;
pub mod record;
pub mod replay;
mod robot_consent;
pub mod run;
pub mod send;
pub mod serve;
pub mod shell;
pub mod test;
pub mod wait;
