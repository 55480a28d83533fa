//! A panic of the recorder's thread ends the recording with an alarm and nothing else.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "tests fail by panicking"
)]

use crate::support;

use std::sync::mpsc::channel;
use std::time::Duration;

use motion_api::{Record, RingCapacities, RobotState, motion_channel};
use recorder::{LogLevel, RecordError, Recorder};
use supervision::injection;

#[test]
fn a_panic_raises_the_alarm_and_nobody_waits_for_the_recorder() {
    let first = RobotState::at_start(kinematics::JointPositions::ZERO, 0.004);
    let sizes = RingCapacities {
        records: Some(64),
        ..RingCapacities::default()
    };
    let (mut motion, mut script) = motion_channel(sizes, &first);
    let (told, alarms) = channel();
    let mut config = support::config();
    config.notes_wait = true;
    config.on_failure = Box::new(move |error: &RecordError| told.send(error.to_string()).unwrap());
    let records = script.records.take().unwrap();
    let (recorder, handle) = Recorder::start_on(std::io::sink(), config, records).unwrap();
    injection::order("recorder panic");
    let alarm = alarms.recv_timeout(Duration::from_secs(10)).unwrap();
    assert!(alarm.contains("on demand in recorder"), "{alarm}");
    // The script's notes and the cycle's records would fill every queue many times over.
    for note in 0..20_000 {
        handle.log(
            0.0,
            LogLevel::Info,
            "program",
            &messages::Text::verbatim(note.to_string()),
        );
    }
    let records = motion.records.as_mut().unwrap();
    assert!(records.is_abandoned());
    let _ = records.push(Record::Cycle(first));
    assert!(recorder.has_failed());
    let closer = recorder.closer().unwrap();
    assert!(!closer.wait_closed(Duration::ZERO));
    assert!(matches!(recorder.finish(), Err(RecordError::Fault(_))));
    assert!(alarms.try_recv().is_err(), "once");
}
