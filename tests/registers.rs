//! Registers in a recording: every change is told, and those that act on the arm act again when it is run again.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::path::Path;

use crate::common::recorder_config;
use clap::Parser;
use controller::cell::Cell;
use controller::start_configuration::cycle_config;
use motion::{ControlLoop, CycleTiming};
use motion_api::io::{InputAction, IoChange};
use motion_api::{
    CommandKind, Origin, Registers, RingCapacities, ScriptEndpoint, SettingCommand, motion_channel,
};
use recorder::{IoMessage, IoValue, Recorder, Recording, RecordingEntry, Setup, Topic};
use server::cli::{Cli, CliCommand};
use server::commands::replay::answer;

/// A register that leads to an input, and a hand that pushes.
const CELL: &str = r#"
[[wire]]
from = "output_float_register[2]"
to = "standard_analog_in[0]"

[[wire]]
from = "output_boolean_register[5]"
to = "configurable_digital_in[2]"
delay = 0.02

[[wrench]]
at = 0.2
duration = 1.0
wrench = [0, 25, 0, 0, 0, 0]
"#;

/// Records 300 cycles; `act` is called before each with its number.
fn record(name: &str, mut act: impl FnMut(u64, &ScriptEndpoint)) -> Recording {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let setup = Setup {
        cell: Some(CELL.to_owned()),
        ..Setup::default()
    };
    let cell = Cell::from_text(CELL.to_owned(), Path::new("cell.toml")).unwrap();
    let model = kinematics::RobotModel::built_in(&setup.model).unwrap();
    let config = cycle_config(&setup, model.clone(), Some(&cell)).unwrap();
    let (motion_end, mut script) = motion_channel(RingCapacities::default(), &config.first_state());
    let mut cycle = ControlLoop::new(config, motion_end).unwrap();
    let recorder_config = recorder_config(&path, setup, model);
    let records = script.records.take().unwrap();
    let (recorder, _handle) = Recorder::start(recorder_config, records).unwrap();
    for number in 1..=300 {
        act(number, &script);
        cycle.tick(CycleTiming::default());
        while script.events.next_event().is_some() {}
    }
    drop(cycle);
    recorder.finish().unwrap();
    Recording::open(&path).unwrap()
}

/// What somebody outside writes while the arm is recorded: no command, so only the registers tell of it.
fn outside(number: u64, registers: &Registers) {
    match number {
        30 => registers.output.set_float(2, 1.0 / 3.0),
        40 => registers.output.set_boolean(5, true),
        60 => registers.input.set_boolean(100, true),
        70 => registers.input.set_integer(47, i32::MIN),
        80 => registers.input.set_float(0, f64::NAN),
        _ => {}
    }
}

fn act(number: u64, script: &ScriptEndpoint) {
    if number == 10 {
        let (index, action) = (100, InputAction::Freedrive);
        let change = IoChange::BooleanRegisterAction { index, action };
        let kind = CommandKind::Setting(SettingCommand::SetIo(change));
        script.commands.send(Origin::default(), kind).unwrap();
    }
    outside(number, &script.registers);
}

#[test]
fn every_change_of_a_register_is_in_the_recording_at_its_cycle() {
    let recording = record("register_changes.mcap", act);
    let changes: Vec<IoMessage> = recording
        .entries(&[Topic::Io])
        .unwrap()
        .map(|entry| match entry.unwrap().1 {
            RecordingEntry::Io(change) => change,
            other => panic!("{other:?}"),
        })
        .collect();
    let told = |name: &str| {
        let of_name = changes.iter().filter(|change| change.name == name);
        of_name.map(|c| (c.cycle, c.value)).collect::<Vec<_>>()
    };
    let third = IoValue::Number(1.0 / 3.0);
    assert_eq!(told("output_float_register[2]"), [(30, third)]);
    assert_eq!(told("standard_analog_in[0]"), [(30, third)]);
    let high = IoValue::Level(true);
    assert_eq!(told("output_boolean_register[5]"), [(40, high)]);
    assert_eq!(told("configurable_digital_in[2]"), [(45, high)]);
    assert_eq!(told("input_boolean_register[100]"), [(60, high)]);
    let lowest = IoValue::Integer(i32::MIN.into());
    assert_eq!(told("input_integer_register[47]"), [(70, lowest)]);
    assert!(matches!(
        told("input_float_register[0]")[..],
        [(80, IoValue::Number(x))] if x.is_nan()
    ));
    assert_eq!(changes.len(), 7);
}

#[test]
fn registers_that_move_the_arm_move_it_again() {
    let led = record("register_rerun.mcap", act);
    let line = ["eliteserver", "replay", led.name(), "--rerun"];
    let CliCommand::Replay(args) = Cli::try_parse_from(line).unwrap().into_command() else {
        panic!("not a replay");
    };
    let mut out = Vec::new();
    let status = answer(&args, &mut out).unwrap().code();
    let text = String::from_utf8(out).unwrap();
    assert_eq!(
        (status, text.lines().next()),
        (0, Some("identical: 300 cycles"))
    );
    // The hand moves the arm only where the register asks for freedrive.
    let held = record("register_held.mcap", |number, script| {
        if number == 10 {
            act(number, script);
        }
    });
    let last = |recording: &Recording| {
        let cycles = recording.entries(&[Topic::Cycle]).unwrap();
        match cycles.last().unwrap().unwrap().1 {
            RecordingEntry::Cycle(cycle) => cycle.actual_q,
            other => panic!("{other:?}"),
        }
    };
    let (led, held) = (last(&led), last(&held));
    assert!(
        (0..6).any(|j| (led[j] - held[j]).abs() > 0.01),
        "{led:?} {held:?}"
    );
}
