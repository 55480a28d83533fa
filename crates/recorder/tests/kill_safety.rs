//! What is left after the writer was killed, the disk filled up, or the bytes went bad.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use crate::support;

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use motion_api::Record;
use proptest::prelude::*;
use recorder::{FileEnd, RecordError, Recorder, RecorderConfig, Recording, Topic, TopicTable};
use support::*;

const CYCLES: u64 = 1000;

fn whole() -> &'static [u8] {
    static FILE: OnceLock<Vec<u8>> = OnceLock::new();
    FILE.get_or_init(|| record((1..=CYCLES).map(|cycle| Record::Cycle(state(cycle)))))
}

/// Cycles read from the bytes, and how they end; the numbers are checked to be 1, 2, 3 ...
fn read(bytes: &[u8]) -> Option<(u64, FileEnd)> {
    let recording = Recording::from_bytes(bytes, "test").ok()?;
    let mut entries = recording.entries(&[Topic::Cycle]).ok()?;
    let mut count = 0;
    for entry in &mut entries {
        let (_, recorder::RecordingEntry::Cycle(cycle)) = entry.unwrap() else {
            panic!("only cycles were asked for");
        };
        count += 1;
        assert_eq!(*cycle, recorder::CycleMessage::from(&state(count)));
    }
    Some((count, entries.ending()?.clone()))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_cut_file_has_every_cycle_up_to_the_cut_less_a_quarter_second(share in 0.0..1.0_f64) {
        let file = whole();
        let length = (share * file.len() as f64) as usize;
        match read(&file[..length]) {
            // Not even the first chunk with the topics.
            None => prop_assert!(length < 8000, "nothing read of {length} bytes"),
            Some((count, ending)) => {
                // Bytes are spread evenly over the cycles but for the beginning and the index at the end.
                let expected = share * CYCLES as f64;
                prop_assert!(count as f64 >= expected - 150.0, "{count} of {expected} cycles");
                prop_assert!(count == CYCLES || ending == FileEnd::Truncated, "{ending:?}");
            }
        }
    }

    #[test]
    fn a_flipped_byte_never_changes_a_cycle(place in 0.0..1.0_f64, bit in 0_u32..8) {
        let mut file = whole().to_vec();
        let index = (place * file.len() as f64) as usize;
        file[index] ^= 1_u8 << bit;
        // `read` compares every cycle with what was recorded.
        read(&file);
    }

    #[test]
    fn any_bytes_are_read_to_an_end(bytes in proptest::collection::vec(any::<u8>(), 0..600), keep in 0..4000_usize) {
        // Random bytes after a beginning that is right, so that all record types are met.
        let mut file = whole()[..keep].to_vec();
        file.extend_from_slice(&bytes);
        if let Ok(recording) = Recording::from_bytes(file, "test") {
            let _ = recorder::Summary::summarize(&recording, None);
            for topic in Topic::ALL {
                if let Ok(table) = TopicTable::new(&recording, topic.name()) {
                    table.rows().unwrap().for_each(drop);
                }
            }
        }
        let _ = Recording::from_bytes(bytes, "test");
    }
}

#[test]
fn the_whole_file_ends_properly() {
    assert_eq!(read(whole()), Some((CYCLES, FileEnd::Complete)));
}

#[test]
fn what_is_not_a_recording_is_refused_with_a_reason() {
    let text = |bytes: &[u8]| {
        Recording::from_bytes(bytes, "f.mcap")
            .unwrap_err()
            .to_string()
    };
    assert!(
        text(b"").contains("f.mcap is not an MCAP file"),
        "{}",
        text(b"")
    );
    assert!(text(b"time,q\n0,1\n").contains("is not an MCAP file"));
    let beginning = text(&whole()[..200]);
    assert!(beginning.contains("no topic /cycle"), "{beginning}");
    let missing = Recording::open("/nowhere/at/all.mcap").unwrap_err();
    assert!(
        missing
            .to_string()
            .contains("cannot read /nowhere/at/all.mcap")
    );
}

#[test]
fn half_a_second_after_the_last_cycle_everything_is_in_the_file() {
    let out = Shared::default();
    let (mut motion, _script, recorder, handle) = start(out.clone(), config());
    for cycle in 1..=10 {
        push(&mut motion, Record::Cycle(state(cycle)));
    }
    handle.log(
        10.0 * STEP,
        recorder::LogLevel::Info,
        "test",
        &messages::Text::verbatim("standing"),
    );
    let begin = Instant::now();
    let everything = || {
        let recording = Recording::from_bytes(out.bytes(), "test").unwrap();
        recording
            .entries(&[Topic::Cycle, Topic::Log])
            .unwrap()
            .count()
            == 11
    };
    while !everything() {
        assert!(
            begin.elapsed() < Duration::from_secs(20),
            "still not written"
        );
        std::thread::sleep(Duration::from_millis(10));
    }
    recorder.finish().unwrap();
}

#[test]
fn an_output_without_room_is_an_error_at_the_start() {
    let (_motion, mut script) = motion_api::motion_channel(Default::default(), &state(0));
    let device = std::fs::OpenOptions::new()
        .write(true)
        .open("/dev/full")
        .unwrap();
    let result = Recorder::start_on(device, config(), script.records.take().unwrap());
    let Err(error) = result else {
        panic!("/dev/full has no room")
    };
    assert!(matches!(error, RecordError::Write { .. }));
    assert!(
        error.to_string().contains("No space left on device"),
        "{error}"
    );
}

#[test]
fn a_file_that_cannot_be_made_is_an_error_at_the_start() {
    let (_motion, mut script) = motion_api::motion_channel(Default::default(), &state(0));
    let config = RecorderConfig {
        path: "/proc/nowhere/out.mcap".into(),
        ..config()
    };
    let Err(error) = Recorder::start(config, script.records.take().unwrap()) else {
        panic!("/proc takes no directories");
    };
    let text = error.to_string();
    assert!(
        text.contains("cannot create the recording /proc/nowhere/out.mcap"),
        "{text}"
    );
}

#[test]
fn a_disk_that_fills_up_is_reported_once_and_everything_goes_on() {
    let alarms = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&alarms);
    let config = RecorderConfig {
        on_failure: Box::new(move |error| {
            assert!(
                error
                    .to_string()
                    .contains("cannot write the recording test.mcap")
            );
            counted.fetch_add(1, Ordering::Relaxed);
        }),
        ..config()
    };
    let (mut motion, _script, recorder, handle) = start(SmallDisk { room: 60_000 }, config);
    // Far more than ring and channel hold: this ends only if both go on being emptied.
    for cycle in 1..=20_000 {
        push(&mut motion, Record::Cycle(state(cycle)));
        handle.log(
            cycle as f64 * STEP,
            recorder::LogLevel::Info,
            "test",
            &messages::Text::verbatim("still here"),
        );
    }
    drop(motion);
    while !recorder.has_failed() {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(alarms.load(Ordering::Relaxed), 1);
    assert!(matches!(recorder.finish(), Err(RecordError::Write { .. })));
}
