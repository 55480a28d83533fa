//! Recordings of earlier versions, which knew less, and of later ones, which say so.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use crate::support;

use std::collections::BTreeMap;
use std::io::Cursor;

use mcap::records::{MessageHeader, Metadata};
use motion_api::Record;
use prost::Message as _;
use prost_types::FileDescriptorSet;
use recorder::{CycleMessage, Recording, RecordingEntry, Topic, difference, difference_ignoring};
use support::*;

/// A recording as a version wrote it whose cycles had the fields up to number 31 only.
fn early(setup: &[(&str, &str)]) -> Vec<u8> {
    let mut schema = FileDescriptorSet::decode(&*CycleMessage::descriptor_set()).unwrap();
    let message = &mut schema.file[0].message_type[0];
    message.field.retain(|field| field.number() < 32);
    let mut mcap = mcap::Writer::new(Cursor::new(Vec::new())).unwrap();
    let metadata = setup
        .iter()
        .map(|(k, v)| ((*k).to_owned(), (*v).to_owned()));
    mcap.write_metadata(&Metadata {
        name: "eliteserver".to_owned(),
        metadata: metadata.collect(),
    })
    .unwrap();
    let schema = mcap
        .add_schema("elite.Cycle", "protobuf", &schema.encode_to_vec())
        .unwrap();
    let none = BTreeMap::new();
    let cycles = mcap
        .add_channel(schema, "/cycle", "protobuf", &none)
        .unwrap();
    let script = mcap.add_channel(0, "/script", "json", &none).unwrap();
    let command = mcap.add_channel(0, "/command", "json", &none).unwrap();
    let mut write = |channel_id, log_time, data: &[u8]| {
        let header = MessageHeader {
            channel_id,
            sequence: 0,
            log_time,
            publish_time: log_time,
        };
        mcap.write_to_known_channel(&header, data).unwrap();
    };
    write(script, 0, br#"{"program": "a.script", "text": "sync()"}"#);
    write(
        command,
        0,
        br#"{"id": 1, "cycle": 1, "name": "pause", "arguments": {}, "program": "a.script", "line": 3}"#,
    );
    for number in 1..=10 {
        let known = CycleMessage {
            elbow_position: Vec::new(),
            raw_wrench: Vec::new(),
            ..early_cycle(number)
        };
        write(cycles, number * 4_000_000, &known.encode_to_vec());
    }
    mcap.finish().unwrap();
    mcap.into_inner().into_inner()
}

/// A cycle without anything beyond number 31.
fn early_cycle(number: u64) -> CycleMessage {
    let all = CycleMessage::from(&state(number));
    CycleMessage {
        cycle: all.cycle,
        time: all.time,
        target_q: all.target_q,
        target_qd: all.target_qd,
        target_qdd: all.target_qdd,
        actual_q: all.actual_q,
        actual_qd: all.actual_qd,
        target_torque: all.target_torque,
        actual_torque: all.actual_torque,
        target_tcp_pose: all.target_tcp_pose,
        actual_tcp_pose: all.actual_tcp_pose,
        target_tcp_speed: all.target_tcp_speed,
        actual_tcp_speed: all.actual_tcp_speed,
        tcp_force: all.tcp_force,
        mode: all.mode,
        robot_mode: all.robot_mode,
        safety_mode: all.safety_mode,
        analog_in: all.analog_in,
        analog_out: all.analog_out,
        ..CycleMessage::default()
    }
}

const EARLY_SETUP: [(&str, &str); 3] = [("format", "1"), ("model", "cs66"), ("step_time", "0.004")];

#[test]
fn a_recording_of_an_earlier_version_is_read_with_what_it_has() {
    let recording = Recording::from_bytes(early(&EARLY_SETUP), "early").unwrap();
    let setup = recording.setup().unwrap();
    assert_eq!(
        (setup.version.as_str(), setup.part, setup.epoch_ns),
        ("unknown", 1, 0)
    );
    let missing = recording.missing_fields();
    assert!(
        missing.contains(&"payload") && missing.contains(&"step_time"),
        "{missing:?}"
    );
    assert!(!missing.contains(&"target_q"), "{missing:?}");

    let mut count = 0;
    for entry in recording.entries(&Topic::ALL).unwrap() {
        match entry.unwrap().1 {
            RecordingEntry::Cycle(cycle) => {
                count += 1;
                let state = cycle.to_state().unwrap();
                assert_eq!(state.target_q, support::state(count).target_q);
                assert_eq!(state.tcp_offset.to_array(), [0.0; 6]);
                // Today's version of the same cycle differs only in what was not recorded then.
                let today = CycleMessage::from(&support::state(count));
                assert!(difference(&cycle, &today).is_some());
                let found = difference_ignoring(&cycle, &today, missing);
                let allowed = ["speed_scaling", "command_id", "digital_in", "digital_out"];
                let others = found.iter().flat_map(|d| &d.fields);
                let others: Vec<_> = others.filter(|f| !allowed.contains(&f.name)).collect();
                assert!(others.is_empty(), "{others:?}");
            }
            RecordingEntry::Command(command) => {
                assert_eq!((command.line, command.program_id), (3, 0))
            }
            RecordingEntry::Script(script) => assert_eq!(script.program, "a.script"),
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(count, 10);
    assert_eq!(
        recorder::Summary::summarize(&recording, None)
            .unwrap()
            .cycles,
        10
    );
}

#[test]
fn a_recording_of_this_version_lacks_nothing() {
    let recording = Recording::from_bytes(record([Record::Cycle(state(1))]), "new").unwrap();
    assert!(recording.missing_fields().is_empty());
}

#[test]
fn what_cannot_be_read_is_refused_with_a_sentence() {
    let refused = |setup: &[(&str, &str)]| {
        Recording::from_bytes(early(setup), "f.mcap")
            .unwrap_err()
            .to_string()
    };
    assert_eq!(
        refused(&[("format", "2")]),
        "f.mcap: the recording has format 2, this version reads up to 1"
    );
    assert_eq!(
        refused(&[("format", "1"), ("step_time", "0.004")]),
        "f.mcap: the start configuration has model = \"\", which does not fit"
    );
}
