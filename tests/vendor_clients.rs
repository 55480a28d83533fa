//! The clients that stand in for the vendor's SDK, its ROS 2 driver and dashboard users, against the real server.
//!
//! They are written in Python from the protocol pages, see `tests/clients`; this starts them with the binary under
//! test.

use std::path::Path;
use std::process::Command;

use crate::common::alone;

fn run(tests: &str) {
    let runner = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/clients/run.py");
    let output = Command::new("python3")
        .arg(runner)
        .arg(tests)
        .env("ELITESERVER", env!("CARGO_BIN_EXE_eliteserver"))
        .output()
        .unwrap_or_else(|error| panic!("these tests need python3 on the path: {error}"));
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
}

#[test]
fn rtsi_clients_get_and_set_every_variable() {
    let _machine = alone();
    run("test_rtsi");
}

#[test]
fn rtsi_conversations_go_as_clients_hold_them() {
    let _machine = alone();
    run("test_rtsi_sessions");
}

#[test]
fn dashboard_users_power_the_arm_and_play_tasks() {
    let _machine = alone();
    run("test_dashboard");
}

#[test]
fn what_dashboard_users_mistype_has_one_reply_and_no_effect() {
    let _machine = alone();
    run("test_dashboard_input");
}

#[test]
fn external_control_leads_the_arm_through_its_sockets() {
    let _machine = alone();
    run("test_external_control");
}

#[test]
fn external_control_survives_kills_broken_messages_and_stops() {
    let _machine = alone();
    run("test_external_faults");
}

#[test]
fn primary_clients_see_live_states_and_send_programs() {
    let _machine = alone();
    run("test_primary");
}

#[test]
fn every_port_tells_the_same_in_every_state() {
    let _machine = alone();
    run("test_states");
}

#[test]
fn points_streamed_to_the_interpreter_lead_the_arm() {
    let _machine = alone();
    run("test_interpreter");
}

#[test]
fn inputs_are_set_through_the_http_port() {
    let _machine = alone();
    run("test_http");
}
