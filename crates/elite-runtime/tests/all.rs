//! Tests of tasks and builtins as programs see them, in one binary: a file each.

mod common;

mod ahead_of_arm;
mod descriptions;
mod external_control;
mod field_errors;
mod folders;
mod manual_examples;
mod math_builtins;
mod memory_account;
mod modules;
mod motion_builtins;
mod pendant_names;
mod places;
mod slips;
mod surroundings;
mod text_growth;
mod zero_time;
