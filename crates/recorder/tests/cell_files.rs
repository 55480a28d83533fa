//! Files of a cell in a recording: there and back, in every part, and what is said when one is lost, damaged or large.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use crate::support;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::sync::Arc;

use mcap::records::Metadata;
use motion_api::{Record, RingCapacities, RobotState, motion_channel};
use proptest::prelude::*;
use recorder::files::{MAX_FILE_BYTES, MAX_PATH_BYTES};
use recorder::{
    CellFiles, FileEnd, RecordError, Recorder, RecorderConfig, Recording, Rotation,
    RotationTrigger, Setup,
};
use support::*;

const EPOCH_NS: u64 = 1_767_225_600_000_000_000;

fn files<const N: usize>(files: [(&str, &[u8]); N]) -> CellFiles {
    let files = files.map(|(path, content)| (path.to_owned(), Arc::from(content)));
    files.into()
}

fn two() -> CellFiles {
    files([
        ("meshes/bench.stl", b"solid bench\nendsolid"),
        ("part.glb", &[7; 300_000]),
    ])
}

fn with_files(files: CellFiles) -> RecorderConfig {
    RecorderConfig {
        setup: Setup {
            files,
            epoch_ns: EPOCH_NS,
            ..Setup::default()
        },
        ..config()
    }
}

/// A recording of 200 cycles with these files.
fn recorded(files: CellFiles) -> Vec<u8> {
    let out = Shared::default();
    let (mut motion, _script, recorder, _handle) = start(out.clone(), with_files(files));
    for cycle in 1..=200 {
        push(&mut motion, Record::Cycle(state(cycle)));
    }
    drop(motion);
    recorder.finish().unwrap();
    out.bytes()
}

fn open(bytes: Vec<u8>) -> Recording {
    Recording::from_bytes(bytes, "f.mcap").unwrap()
}

fn read_files(recording: &Recording) -> &CellFiles {
    &recording.setup().unwrap().files
}

/// Number of cycles, and how the file ends.
fn cycles(recording: &Recording) -> (usize, FileEnd) {
    let mut messages = recording.messages().unwrap();
    let cycles = messages.by_ref();
    let count = cycles
        .filter(|message| message.channel.topic == "/cycle")
        .count();
    (count, messages.ending().unwrap().clone())
}

/// Where some bytes begin in a file.
fn place(file: &[u8], bytes: &[u8]) -> usize {
    let mut windows = file.windows(bytes.len());
    windows.position(|window| window == bytes).unwrap()
}

/// Beginning and length of the records of one kind that stand outside of chunks.
fn records(file: &[u8], kind: u8) -> Vec<(usize, usize)> {
    let (mut at, mut found) = (8, Vec::new());
    while let Some(length) = file.get(at + 1..at + 9) {
        let length = 9 + u64::from_le_bytes(length.try_into().unwrap()) as usize;
        if file[at] == kind {
            found.push((at, length));
        }
        at += length;
    }
    found
}

#[test]
fn files_come_back_and_equal_runs_give_equal_recordings() {
    let bytes = recorded(two());
    let recording = open(bytes.clone());
    assert_eq!(read_files(&recording), &two());
    recording.check_files().unwrap();
    assert_eq!(cycles(&recording), (200, FileEnd::Complete));
    assert!(
        bytes == recorded(two()),
        "two recordings of the same input differ"
    );

    // What others see: index, times, kinds.
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let seen: Vec<_> = summary
        .attachment_indexes
        .iter()
        .map(|index| {
            let attachment = mcap::read::attachment(&bytes, index).unwrap();
            assert_eq!(
                (attachment.log_time, attachment.create_time),
                (EPOCH_NS, EPOCH_NS)
            );
            (
                attachment.name,
                attachment.media_type,
                attachment.data.len(),
            )
        })
        .collect();
    assert_eq!(
        seen,
        [
            (
                "cell/meshes/bench.stl".to_owned(),
                "model/stl".to_owned(),
                20
            ),
            (
                "cell/part.glb".to_owned(),
                "model/gltf-binary".to_owned(),
                300_000
            ),
        ]
    );
    assert_eq!(summary.stats.unwrap().attachment_count, 2);
    let first_chunk = summary
        .chunk_indexes
        .iter()
        .map(|chunk| chunk.chunk_start_offset)
        .min();
    assert!(
        summary
            .attachment_indexes
            .iter()
            .all(|index| Some(index.offset) < first_chunk)
    );
}

#[test]
fn a_cell_without_files_leaves_the_recording_as_it_was() {
    let bytes = recorded(CellFiles::new());
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    assert!(summary.attachment_indexes.is_empty());
    let metadata = mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).unwrap();
    assert!(!metadata.metadata.contains_key("files"));
    let recording = open(bytes);
    assert!(read_files(&recording).is_empty());
    recording.check_files().unwrap();
}

#[test]
fn a_lost_or_damaged_file_is_named_and_the_cycles_are_read() {
    let whole = recorded(two());
    let attachments = records(&whole, 9);
    assert_eq!(attachments.len(), 2);
    let lacks = |bytes: Vec<u8>, path: &str| {
        let recording = open(bytes);
        assert_eq!(
            recording.check_files().unwrap_err().to_string(),
            format!("f.mcap: the recording lacks the file \"{path}\" of its cell")
        );
        assert_eq!(cycles(&recording).0, 200);
        let mut expected = two();
        expected.remove(path);
        assert_eq!(read_files(&recording), &expected);
    };
    // Content, name, time and checksum: all of them are covered.
    let (at, length) = attachments[0];
    for byte in [
        place(&whole, b"solid bench"),
        place(&whole, b"cell/meshes") + 2,
        at + 12,
        at + length - 1,
    ] {
        let mut damaged = whole.clone();
        damaged[byte] ^= 1;
        lacks(damaged, "meshes/bench.stl");
    }
    // Lengths that lead out of the record: of name, kind and content.
    let name = place(&whole, b"cell/meshes");
    for length in [name - 4, name + 21, name + 34] {
        for wrong in [[0xff; 4], [0, 0, 0, 0x7f], [0, 0, 0, 0]] {
            let mut damaged = whole.clone();
            damaged[length..length + 4].copy_from_slice(&wrong);
            lacks(damaged, "meshes/bench.stl");
        }
    }
    for (lost, path) in [(0, "meshes/bench.stl"), (1, "part.glb")] {
        let (at, length) = attachments[lost];
        let without = [&whole[..at], &whole[at + length..]].concat();
        lacks(without, path);
    }
}

/// A recording as another program may have written it, with these attachments.
fn foreign(list: Option<&str>, attachments: &[(&str, &[u8])]) -> Result<Recording, String> {
    let mut mcap = mcap::Writer::new(Cursor::new(Vec::new())).unwrap();
    for (name, data) in attachments {
        mcap.attach(&mcap::Attachment {
            log_time: 3,
            create_time: 4,
            name: (*name).to_owned(),
            media_type: String::new(),
            data: Cow::Borrowed(data),
        })
        .unwrap();
    }
    let mut metadata: BTreeMap<String, String> =
        [("format", "1"), ("model", "cs66"), ("step_time", "0.004")]
            .map(|(key, value)| (key.to_owned(), value.to_owned()))
            .into();
    if let Some(list) = list {
        metadata.insert("files".to_owned(), list.to_owned());
    }
    let name = "eliteserver".to_owned();
    mcap.write_metadata(&Metadata { name, metadata }).unwrap();
    mcap.add_channel(0, "/cycle", "protobuf", &BTreeMap::new())
        .unwrap();
    mcap.finish().unwrap();
    let bytes = mcap.into_inner().into_inner();
    Recording::from_bytes(bytes, "f.mcap").map_err(|error| error.to_string())
}

#[test]
fn what_the_metadata_does_not_name_is_none_of_the_cell() {
    let all: [(&str, &[u8]); 4] = [
        ("cell/a.stl", b"first"),
        ("cell/a.stl", b"second"),
        ("a.stl", b"foreign"),
        ("cell/b.stl", b"not named"),
    ];
    // Attachments may stand before the metadata.
    let recording = foreign(Some("[\"a.stl\"]"), &all).unwrap();
    assert_eq!(read_files(&recording), &files([("a.stl", b"first")]));
    recording.check_files().unwrap();
    let recording = foreign(None, &all).unwrap();
    assert!(read_files(&recording).is_empty());
    recording.check_files().unwrap();
    assert_eq!(
        foreign(Some("a.stl"), &all).unwrap_err(),
        "f.mcap: the start configuration has files = \"a.stl\", which does not fit"
    );
    let long = foreign(Some(&"[".repeat(100_000)), &all).unwrap_err();
    assert!(
        long.len() < 400 && long.contains("100000 bytes in all"),
        "{long}"
    );
}

#[test]
fn the_largest_file_is_recorded_and_read_and_a_larger_one_is_refused() {
    let path = "a".repeat(MAX_PATH_BYTES);
    let largest: Arc<[u8]> = vec![1; MAX_FILE_BYTES].into();
    let recording = open(recorded([(path.clone(), Arc::clone(&largest))].into()));
    assert!(read_files(&recording)[&path] == largest);

    let too_large: CellFiles = [("big.stl".to_owned(), vec![0; MAX_FILE_BYTES + 1].into())].into();
    let folder = tempfile::tempdir().unwrap();
    let kept = folder.path().join("run.mcap");
    std::fs::write(&kept, "an earlier run").unwrap();
    let (_motion, mut script) = motion_channel(RingCapacities::default(), &state(0));
    let config = RecorderConfig {
        path: kept.clone(),
        ..with_files(too_large)
    };
    let Err(error) = Recorder::start(config, script.records.take().unwrap()) else {
        panic!("a reader would not take it");
    };
    assert!(matches!(error, RecordError::Files(_)));
    assert_eq!(
        error.to_string(),
        "cannot record: the file \"big.stl\" of the cell has 67108865 bytes; a recording takes files of at most \
         67108864"
    );
    assert_eq!(std::fs::read(&kept).unwrap(), b"an earlier run");
    // Written by somebody else it is not believed.
    let name = format!("cell/{}", "a".repeat(8000));
    let refused = foreign(None, &[(&name, &largest)]).unwrap_err();
    assert!(
        refused.contains("is damaged: a record has 67116"),
        "{refused}"
    );
}

#[test]
fn every_part_has_the_files_and_they_count() {
    let folder = tempfile::tempdir().unwrap();
    let rotation = Rotation {
        // The files alone have more.
        end: Some(RotationTrigger::Bytes(200_000)),
        budget: Some(2_000_000),
        earlier: Vec::new(),
    };
    let config = RecorderConfig {
        path: folder.path().join("run.mcap"),
        rotation,
        ..with_files(two())
    };
    let first = RobotState::at_start(kinematics::JointPositions::ZERO, STEP);
    let (mut motion, mut script) = motion_channel(RingCapacities::default(), &first);
    let (recorder, _handle) = Recorder::start(config, script.records.take().unwrap()).unwrap();
    for cycle in 1..=6000 {
        push(&mut motion, Record::Cycle(state(cycle)));
    }
    drop(motion);
    recorder.finish().unwrap();
    let parts: Vec<_> = std::fs::read_dir(folder.path())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    // 6000 cycles have about 4.8 MB; a part ends with 600 kB, of which half are files, or a thousand cycles later.
    assert!((2..=4).contains(&parts.len()), "{parts:?}");
    let mut newest = 0;
    for part in &parts {
        let recording = Recording::open(part).unwrap();
        assert_eq!(read_files(&recording), &two(), "{}", part.display());
        newest = newest.max(recording.setup().unwrap().part);
    }
    assert!((5..=12).contains(&newest), "{newest} parts");
    let size: u64 = parts
        .iter()
        .map(|part| part.metadata().unwrap().len())
        .sum();
    assert!(size < 2_700_000, "{size} bytes in {parts:?}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_files_come_back(
        files in proptest::collection::btree_map("\\PC{1,40}", proptest::collection::vec(any::<u8>(), 0..2000), 0..8),
    ) {
        let files: CellFiles = files.into_iter().map(|(path, content)| (path, content.into())).collect();
        let out = Shared::default();
        let (motion, _script, recorder, _handle) = start(out.clone(), with_files(files.clone()));
        drop(motion);
        recorder.finish().unwrap();
        let recording = open(out.bytes());
        prop_assert_eq!(read_files(&recording), &files);
        prop_assert!(recording.check_files().is_ok());
    }

    #[test]
    fn a_cut_or_changed_file_is_read_to_an_end_and_never_has_other_content(
        place in 0.0..1.0_f64,
        bit in 0_u32..8,
        cut in any::<bool>(),
    ) {
        let mut bytes = recorded(files([("a.stl", &[3; 4000]), ("b.obj", &[4; 4000])]));
        let index = (place * bytes.len() as f64) as usize;
        match cut {
            true => bytes.truncate(index),
            false => bytes[index] ^= 1_u8 << bit,
        }
        if let Ok(recording) = Recording::from_bytes(bytes, "f.mcap")
            && let Some(setup) = recording.setup()
        {
            for (path, content) in &setup.files {
                let expected = if path == "a.stl" { [3; 4000] } else { [4; 4000] };
                prop_assert_eq!(&**content, &expected[..], "{}", path);
            }
            cycles(&recording);
        }
    }
}
