//! What is recorded is what is read.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use crate::support;

use messages::text;
use motion_api::{Record, RobotState};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use recorder::{CycleMessage, FileEnd, IoValue, LogLevel, Recording, RecordingEntry, Setup, Topic};
use support::*;

fn states(recording: &Recording) -> Vec<RobotState> {
    let cycles = recording.cycles().unwrap();
    cycles.map(|c| c.unwrap().to_state().unwrap()).collect()
}

#[test]
fn any_state_comes_back_bit_for_bit() {
    let mut runner = TestRunner::deterministic();
    let sequence: Vec<RobotState> = (1..=300)
        .map(|cycle| any::state(cycle).new_tree(&mut runner).unwrap().current())
        .collect();
    let bytes = record(sequence.iter().copied().map(Record::Cycle));
    let recording = Recording::from_bytes(bytes, "test").unwrap();
    let back = states(&recording);
    assert_eq!(back.len(), sequence.len());
    for (recorded, read) in sequence.iter().zip(&back) {
        assert_eq!(recorded, read);
        let (a, b) = (recorded.actual_torque.0, read.actual_torque.0);
        assert_eq!(a.map(f64::to_bits), b.map(f64::to_bits));
    }
}

#[test]
fn the_setup_comes_back() {
    let mut runner = TestRunner::deterministic();
    for cycle in 1..20 {
        let state = any::state(cycle).new_tree(&mut runner).unwrap().current();
        let setup = Setup {
            model: "my arm.urdf".to_owned(),
            urdf: Some("<robot/>".to_owned()),
            cell: Some("[tool]\nshape = \"sphere\"\n".to_owned()),
            home: state.target_q,
            tcp: state.tcp_offset,
            payload: state.payload,
            step_time: 0.001,
            seed: state.digital_in,
            plant: "rigid".to_owned(),
            clock: "realtime".to_owned(),
            powered_off: true,
            epoch_ns: 1_767_225_600_000_000_000,
            ..Setup::default()
        };
        let out = Shared::default();
        let config = recorder::RecorderConfig {
            setup: setup.clone(),
            ..config()
        };
        let (motion, _script, recorder, _handle) = start(out.clone(), config);
        drop(motion);
        recorder.finish().unwrap();
        let recording = Recording::from_bytes(out.bytes(), "test").unwrap();
        assert_eq!(recording.setup(), Some(&setup));
    }
}

#[test]
fn commands_notes_and_io_changes_stand_between_the_cycles_they_belong_to() {
    let out = Shared::default();
    let (mut motion, _script, recorder, handle) = start(out.clone(), config());
    handle.program_started(0.0, motion_api::ProgramId(1), "weld.script", "movej(p)\n");
    push(&mut motion, command(1, 1, movej(0.25)));
    let mut first = state(1);
    first.digital_out = 0b1001;
    first.analog_in[2] = 4.5;
    push(&mut motion, Record::Cycle(first));
    for line in [2, 3, 7] {
        handle.script_line(
            STEP,
            motion_api::ProgramId(1),
            motion_api::ThreadNumber(0),
            line,
        );
    }
    handle.log(
        STEP,
        LogLevel::Error,
        "script",
        &text!("something failed", "出了错"),
    );
    handle.io(STEP, "output_integer_register[2]", IoValue::Integer(-3));
    handle.variable(STEP, motion_api::ProgramId(1), "total", "int", "7");
    push(
        &mut motion,
        Record::Cycle(RobotState {
            digital_out: 0b1000,
            ..state(2)
        }),
    );
    // The same line again is another round of a loop.
    handle.script_line(
        2.0 * STEP,
        motion_api::ProgramId(1),
        motion_api::ThreadNumber(0),
        7,
    );
    push(&mut motion, Record::Cycle(state(3)));
    drop(motion);
    let totals = recorder.finish().unwrap();
    assert_eq!((totals.cycles, totals.missing, totals.commands), (3, 0, 1));

    let recording = Recording::from_bytes(out.bytes(), "test").unwrap();
    let mut entries = recording.entries(&Topic::ALL).unwrap();
    let seen: Vec<String> = (&mut entries)
        .map(|entry| {
            let (time, entry) = entry.unwrap();
            let what = match entry {
                RecordingEntry::Cycle(cycle) => format!("cycle {}", cycle.cycle),
                RecordingEntry::Command(c) => {
                    assert_eq!(c.to_command().unwrap().kind, movej(0.25));
                    format!("{} {} {}:{}", c.id, c.name, c.program, c.line)
                }
                RecordingEntry::Script(s) => format!("{} {:?} {:?}", s.program, s.text, s.line),
                RecordingEntry::Log(l) => {
                    let chinese = l.message.other_chinese();
                    format!("{:?} {} {} {chinese:?}", l.level, l.source, l.message)
                }
                RecordingEntry::Variable(v) => {
                    format!("{}.{} {} {}", v.program, v.name, v.type_name, v.value)
                }
                RecordingEntry::Io(io) => format!("{} {} {:?}", io.cycle, io.name, io.value),
            };
            format!("{time:.3} {what}")
        })
        .collect();
    assert_eq!(
        seen,
        [
            "0.000 weld.script Some(\"movej(p)\\n\") None",
            "0.000 1 movej weld.script:7",
            "0.004 cycle 1",
            "0.004 1 standard_digital_out[0] Level(true)",
            "0.004 1 standard_digital_out[3] Level(true)",
            "0.004 1 tool_analog_in Number(4.5)",
            "0.004 Error script something failed Some(\"出了错\")",
            "0.004 1 output_integer_register[2] Integer(-3)",
            "0.004 weld.script.total int 7",
            "0.004 weld.script None Some(7)",
            "0.008 cycle 2",
            "0.008 2 standard_digital_out[0] Level(false)",
            "0.008 2 tool_analog_in Number(0.0)",
            "0.012 cycle 3",
            "0.012 3 standard_digital_out[3] Level(false)",
            // The same line again: another round.
            "0.012 weld.script None Some(7)",
        ]
    );
    assert_eq!(entries.ending(), Some(&FileEnd::Complete));
}

#[test]
fn the_same_input_gives_the_same_file() {
    let run = || {
        let out = Shared::default();
        let (mut motion, _script, recorder, handle) = start(out.clone(), config());
        for cycle in 1..=500 {
            handle.log(
                (cycle - 1) as f64 * STEP,
                LogLevel::Info,
                "test",
                &text!("before {cycle}", "{cycle} 之前"),
            );
            if cycle % 100 == 1 {
                push(
                    &mut motion,
                    command(cycle / 100 + 1, cycle, movej(cycle as f64)),
                );
            }
            push(&mut motion, Record::Cycle(state(cycle)));
        }
        drop(motion);
        recorder.finish().unwrap();
        out.bytes()
    };
    assert!(run() == run(), "two recordings of the same input differ");
}

#[test]
fn missing_cycles_are_counted_and_said() {
    let cycles = [1, 2, 5, 6].map(|cycle| Record::Cycle(state(cycle)));
    let bytes = record(cycles);
    let recording = Recording::from_bytes(bytes, "test").unwrap();
    let logs = recording.entries(&[Topic::Log]).unwrap();
    let logs: Vec<_> = logs.map(|entry| entry.unwrap().1).collect();
    let [RecordingEntry::Log(log)] = logs.as_slice() else {
        panic!("one message expected, found {logs:?}");
    };
    assert_eq!(
        log.message,
        "2 cycles are missing before cycle 5: the recording did not keep up"
    );
    let summary = recorder::Summary::summarize(&recording, None).unwrap();
    assert_eq!((summary.cycles, summary.missing), (4, 2));
}

#[test]
fn a_cycle_of_another_shape_is_refused_by_name() {
    let mut cycle = CycleMessage::from(&state(4));
    cycle.actual_q.pop();
    let error = cycle.to_state().unwrap_err();
    assert_eq!(
        error.to_string(),
        "cycle 4: actual_q has 5 elements, it needs 6"
    );
    let mut cycle = CycleMessage::from(&state(4));
    cycle.mode = "moveq".to_owned();
    let error = cycle.to_state().unwrap_err();
    assert!(
        error.to_string().contains("\"moveq\" is not known"),
        "{error}"
    );
}
