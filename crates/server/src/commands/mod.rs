//! The commands of the command line, one file each. Every one returns a
//! [`CommandResult`](crate::command::CommandResult).

pub mod builtins;
pub mod calibrate;
pub mod cell;
pub mod check;
pub mod clearance;
pub mod compare;
pub mod completions;
pub mod debug;
pub mod doctor;
pub mod excite;
pub mod fleet;
pub mod identify;
pub mod import;
mod line_input;
pub mod lsp;
pub mod man;
pub mod mcp;
pub mod optimize;
pub mod place;
pub mod plan;
mod program_output;
pub mod record;
pub mod replay;
mod robot_consent;
pub mod ros2;
pub mod run;
pub mod send;
pub mod serve;
mod serve_error;
pub mod shell;
pub mod test;
pub mod translate;
pub mod wait;
