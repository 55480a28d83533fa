//! Whatever programs say and however fast: the recorder's memory stays within bounds, what is dropped is counted, and
//! nobody waits for ever.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use crate::support;

use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::time::Duration;

use motion_api::{ProgramId, Record, ThreadNumber};
use recorder::lengths::{MESSAGE_BYTES, NAME_BYTES, PROGRAM_TEXT_BYTES, VALUE_BYTES};
use recorder::{IoValue, LogLevel, Recording, RecordingEntry, Summary, Topic};
use support::*;

/// What may wait in all.
const WAITING_BYTES: u64 = 32 << 20;

/// A disk that stands still while it is told to.
#[derive(Clone, Default)]
struct Standing {
    out: Shared,
    stands: Arc<AtomicBool>,
}

impl Write for Standing {
    fn write(&mut self, data: &[u8]) -> io::Result<usize> {
        while self.stands.load(Ordering::Acquire) {
            std::thread::sleep(Duration::from_millis(1));
        }
        self.out.write(data)
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// Text that zstd makes nothing of.
fn noise(bytes: usize) -> String {
    let mut state = 1_u64;
    let letter = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        char::from(b' ' + (state >> 33) as u8 % 94)
    };
    std::iter::repeat_with(letter).take(bytes).collect()
}

fn entries(file: Vec<u8>, topic: Topic) -> Vec<RecordingEntry> {
    let recording = Recording::from_bytes(file, "test").unwrap();
    let entries = recording.entries(&[topic]).unwrap();
    entries.map(|entry| entry.unwrap().1).collect()
}

#[test]
fn a_disk_that_stands_still_does_not_fill_the_memory_and_what_is_dropped_is_counted() {
    let disk = Standing::default();
    let config = recorder::RecorderConfig {
        notes_wait: false,
        patience: std::time::Duration::from_secs(60),
        ..config()
    };
    let (mut motion, _script, recorder, handle) = start(disk.clone(), config);
    let meter = recorder.meter();
    disk.stands.store(true, Ordering::Release);
    let (text, line) = (noise(PROGRAM_TEXT_BYTES), noise(100));
    for round in 0..200_u32 {
        let (program, time) = (ProgramId(round + 1), f64::from(round) * STEP);
        handle.program_started(time, program, "flood", &text);
        for _ in 0..100 {
            handle.log(
                time,
                LogLevel::Info,
                "flood",
                &messages::Text::verbatim(line.clone()),
            );
            handle.variable(time, program, "x", "str", &line);
            handle.io(time, "output_boolean_register[7]", IoValue::Level(true));
            handle.script_line(time, program, ThreadNumber(0), round + 1);
        }
        push(&mut motion, Record::Cycle(state(u64::from(round) + 1)));
        assert!(meter.bytes_waiting() <= WAITING_BYTES);
    }
    let dropped = meter.notes_dropped();
    assert!(dropped > 100, "{dropped}");
    disk.stands.store(false, Ordering::Release);
    drop(motion);
    recorder.finish().unwrap();
    assert_eq!(meter.bytes_waiting(), 0);
    let recording = Recording::from_bytes(disk.out.bytes(), "test").unwrap();
    let summary = Summary::summarize(&recording, None).unwrap();
    assert_eq!(
        (summary.cycles, summary.missing, summary.notes_missing),
        (200, 0, dropped)
    );
}

#[test]
fn who_may_wait_loses_nothing_and_is_not_held_up_for_ever_while_time_stands_still() {
    let out = Shared::default();
    let (mut motion, _script, recorder, handle) = start(out.clone(), config());
    push(&mut motion, Record::Cycle(state(1)));
    // No cycle comes while the program runs: nothing but the bound makes the notes leave.
    let (sent, told) = mpsc::channel();
    let line = noise(20_000);
    std::thread::spawn(move || {
        for _ in 0..10_000 {
            handle.log(
                STEP,
                LogLevel::Info,
                "loop",
                &messages::Text::verbatim(line.clone()),
            );
        }
        sent.send(handle.notes_dropped()).unwrap();
    });
    assert_eq!(told.recv_timeout(Duration::from_secs(100)), Ok(0));
    let meter = recorder.meter();
    assert!(meter.bytes_waiting() <= WAITING_BYTES);
    push(&mut motion, Record::Cycle(state(2)));
    drop(motion);
    recorder.finish().unwrap();
    assert_eq!(entries(out.bytes(), Topic::Log).len(), 10_000);
}

#[test]
fn nobody_waits_for_a_disk_that_is_full() {
    let (mut motion, _script, recorder, handle) = start(SmallDisk { room: 100_000 }, config());
    push(&mut motion, Record::Cycle(state(1)));
    let (sent, told) = mpsc::channel();
    let line = noise(20_000);
    std::thread::spawn(move || {
        for _ in 0..10_000 {
            handle.log(
                STEP,
                LogLevel::Info,
                "loop",
                &messages::Text::verbatim(line.clone()),
            );
        }
        sent.send(()).unwrap();
    });
    assert_eq!(told.recv_timeout(Duration::from_secs(60)), Ok(()));
    assert!(recorder.has_failed());
    drop(motion);
    assert!(recorder.finish().is_err());
}

#[test]
fn texts_that_are_too_long_are_cut_with_a_mark() {
    let out = Shared::default();
    let (mut motion, _script, recorder, handle) = start(out.clone(), config());
    let long = "ß".repeat(PROGRAM_TEXT_BYTES);
    let program = ProgramId(1);
    handle.program_started(0.0, program, &long, &long);
    handle.log(
        0.0,
        LogLevel::Error,
        &long,
        &messages::Text::verbatim(long.clone()),
    );
    handle.variable(0.0, program, &long, &long, &long);
    handle.io(0.0, &long, IoValue::Level(true));
    push(&mut motion, Record::Cycle(state(1)));
    let meter = recorder.meter();
    drop(motion);
    recorder.finish().unwrap();
    assert_eq!(meter.texts_cut(), 8);
    let all = entries(out.bytes(), Topic::Script)
        .into_iter()
        .chain(entries(out.bytes(), Topic::Log))
        .chain(entries(out.bytes(), Topic::Variables))
        .chain(entries(out.bytes(), Topic::Io));
    let mut texts: Vec<(String, usize)> = Vec::new();
    for entry in all {
        match entry {
            RecordingEntry::Script(script) => {
                texts.push((script.program, NAME_BYTES));
                texts.push((script.text.unwrap(), PROGRAM_TEXT_BYTES));
            }
            RecordingEntry::Log(log) => {
                texts.push((log.source, NAME_BYTES));
                texts.push((log.message.to_string(), MESSAGE_BYTES));
            }
            RecordingEntry::Variable(variable) => {
                assert!(variable.program.ends_with("bytes in all]"));
                texts.push((variable.name, NAME_BYTES));
                texts.push((variable.type_name, NAME_BYTES));
                texts.push((variable.value, VALUE_BYTES));
            }
            RecordingEntry::Io(io) => texts.push((io.name, NAME_BYTES)),
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(texts.len(), 8);
    for (text, most) in texts {
        assert!(
            text.len() <= most && text.len() > most - 8,
            "{}",
            text.len()
        );
        let mark = format!(" … [cut, {} bytes in all]", long.len());
        assert!(text.ends_with(&mark), "{}", &text[text.len() - 50..]);
    }
}

#[test]
fn a_large_program_is_recorded_whole_and_a_flood_of_them_does_not_fill_the_disk() {
    let out = Shared::default();
    let (mut motion, _script, recorder, handle) = start(out.clone(), config());
    let text = noise(PROGRAM_TEXT_BYTES);
    const PROGRAMS: u32 = 40;
    for number in 1..=PROGRAMS {
        // A tenth of a second each, as fast as a port can take them.
        let time = f64::from(number) * 0.1;
        handle.program_started(time, ProgramId(number), "large", &text);
        push(&mut motion, Record::Cycle(state(u64::from(number) * 25)));
    }
    drop(motion);
    recorder.finish().unwrap();
    let lengths: Vec<usize> = entries(out.bytes(), Topic::Script)
        .into_iter()
        .map(|entry| match entry {
            RecordingEntry::Script(script) => script.text.unwrap().len(),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(lengths.len(), PROGRAMS as usize);
    assert_eq!(lengths[0], PROGRAM_TEXT_BYTES);
    let whole = lengths.iter().filter(|&&n| n == PROGRAM_TEXT_BYTES).count();
    assert_eq!(whole, 8, "{lengths:?}");
    assert!(
        lengths
            .iter()
            .all(|&n| n == PROGRAM_TEXT_BYTES || n <= 4096)
    );
}
