//! Recordings in several files: nothing lost between them, each readable alone, old ones removed.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use crate::support;

use std::path::PathBuf;

use motion_api::{ProgramId, Record, RingCapacities, RobotState, ThreadNumber, motion_channel};
use recorder::{
    Recorder, RecorderConfig, Recording, RecordingEntry, Rotation, RotationTrigger, Topic,
};
use support::*;

/// Records so many cycles of one program into a folder of its own; the files by part.
fn in_parts(rotation: Rotation, cycles: u64) -> (tempfile::TempDir, Vec<PathBuf>) {
    let folder = tempfile::tempdir().unwrap();
    let config = RecorderConfig {
        path: folder.path().join("run.mcap"),
        rotation,
        ..config()
    };
    let first = RobotState::at_start(kinematics::JointPositions::ZERO, STEP);
    let (mut motion, mut script) = motion_channel(RingCapacities::default(), &first);
    let (recorder, handle) = Recorder::start(config, script.records.take().unwrap()).unwrap();
    handle.program_started(0.0, ProgramId(1), "long.script", "movej(a)\nmovej(b)\n");
    handle.script_line(0.0, ProgramId(1), ThreadNumber(0), 2);
    for cycle in 1..=cycles {
        push(&mut motion, Record::Cycle(state(cycle)));
    }
    drop(motion);
    assert_eq!(recorder.finish().unwrap().cycles, cycles);
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.sort_by_key(part);
    (folder, files)
}

fn part(path: &PathBuf) -> u32 {
    Recording::open(path).unwrap().setup().unwrap().part
}

fn cycles(path: &PathBuf) -> Vec<u64> {
    let recording = Recording::open(path).unwrap();
    let cycles = recording.cycles().unwrap();
    cycles.map(|cycle| cycle.unwrap().cycle).collect()
}

#[test]
fn the_parts_together_hold_every_cycle_once() {
    for end in [RotationTrigger::Secs(2.0), RotationTrigger::Bytes(500_000)] {
        let rotation = Rotation {
            end: Some(end),
            ..Rotation::default()
        };
        let (_folder, files) = in_parts(rotation, 5000);
        assert!(files.len() >= 3, "{end:?}: {files:?}");
        let numbers: Vec<u32> = files.iter().map(part).collect();
        assert_eq!(numbers, (1..=files.len() as u32).collect::<Vec<_>>());
        let all: Vec<u64> = files.iter().flat_map(cycles).collect();
        assert_eq!(all, (1..=5000).collect::<Vec<u64>>(), "{end:?}");
    }
}

#[test]
fn every_part_tells_the_program_and_the_line_again() {
    let rotation = Rotation {
        end: Some(RotationTrigger::Secs(1.0)),
        ..Rotation::default()
    };
    let (_folder, files) = in_parts(rotation, 4000);
    for file in &files {
        let recording = Recording::open(file).unwrap();
        let mut told = Vec::new();
        for entry in recording.entries(&[Topic::Script]).unwrap() {
            if let RecordingEntry::Script(script) = entry.unwrap().1 {
                told.push((script.text.is_some(), script.line));
            }
        }
        assert_eq!(told, [(true, None), (false, Some(2))], "{}", file.display());
    }
}

#[test]
fn the_oldest_files_make_room_and_the_newest_stay() {
    let earlier_folder = tempfile::tempdir().unwrap();
    let earlier = earlier_folder.path().join("2026-01-01T00-00-00-1.mcap");
    std::fs::write(&earlier, vec![0; 100_000]).unwrap();
    let rotation = Rotation {
        end: Some(RotationTrigger::Bytes(400_000)),
        budget: Some(1_000_000),
        earlier: vec![earlier.clone()],
    };
    let (_folder, files) = in_parts(rotation, 8000);
    assert!(!earlier.exists(), "the oldest goes first");
    let size: u64 = files.iter().map(|f| f.metadata().unwrap().len()).sum();
    assert!(size < 1_200_000, "{size} bytes in {files:?}");
    assert!(part(&files[0]) > 1, "{files:?}");
    let last = files.iter().flat_map(cycles).last();
    assert_eq!(last, Some(8000));
}
