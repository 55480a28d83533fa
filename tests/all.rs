//! Tests of the whole program, most of them through its binary, in one binary: a file each.
//!
//! Some talk to a server in real time and look at how long it takes. Those have the machine to themselves: under
//! nextest by `.config/nextest.toml`, in one process by the lock of `common::alone`.

mod common;

mod api;
mod bad_input;
mod bags;
mod calibration;
mod cell_task;
mod chains;
mod children;
mod closed_doors;
mod contact;
mod contained_faults;
mod debug;
mod dependencies;
mod first_light;
mod fleet;
mod hostile_recordings;
mod identify;
mod import;
mod io_docs;
mod language_server;
mod layers;
mod mcp;
mod micro_lines;
mod mistakes;
mod motion_bad_input;
mod one_program;
mod paths;
mod pendant;
mod process_moves;
mod real_robot;
mod recording;
mod registers;
mod replay;
mod reports;
mod rerun;
mod rtsi_docs;
mod script_tests;
mod sent_texts;
mod served_programs;
mod settings;
mod shutdown;
mod stops;
mod terminal;
mod transcripts;
mod translate;
mod vendor_clients;
mod vendor_ports;
mod wrong_input;
