//! What was recorded runs again, cycle for cycle: every program of `tests/moves` with its cell, the examples, and every
//! program of `tests/scripts` that moves the arm.
//!
//! `ELITE_RERUN=realtime` runs all of them under the real clock too; without it one is.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test fails by panicking"
)]

use std::path::{Path, PathBuf};

use controller::cell_world::topic;
use recorder::Recording;

use crate::common::{alone, eliteserver};

/// Functions that move the arm; a call of one of them makes a program one that moves.
const MOVING: [&str; 9] = [
    "movej(",
    "movel(",
    "movec(",
    "moveml(",
    "servoj(",
    "speedj(",
    "speedl(",
    "freedrive_mode(",
    "force_mode(",
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Every script in a folder and below, sorted.
fn scripts(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "script") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

fn moves(path: &Path) -> bool {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines().map(str::trim_start);
    lines.any(|line| MOVING.iter().any(|call| line.starts_with(call)))
}

/// Records a program with the cell beside it and runs the recording again; how many cycles it has.
fn rerun(script: &Path, clock: &str) -> u64 {
    rerun_with_faults(script, clock, "").0
}

/// Records a program with the cell beside it while faults are ordered, and runs the recording again; how many cycles it
/// has, and its bytes.
fn rerun_with_faults(script: &Path, clock: &str, faults: &str) -> (u64, Vec<u8>) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("faults"), faults).unwrap();
    let file = folder.path().join("run.mcap");
    let cell = match script.with_extension("toml") {
        own if own.exists() => own,
        _ => script.with_file_name("cell.toml"),
    };
    let mut run = eliteserver();
    run.arg("run")
        .arg(script)
        .args(["--clock", clock, "--record"]);
    run.arg(&file).current_dir(&folder);
    run.env(
        supervision::injection::VARIABLE,
        folder.path().join("faults"),
    );
    if cell.exists() {
        run.arg("--cell").arg(cell);
    }
    // Some programs end by a stop of the robot: what was recorded of it must run again all the same.
    let ran = run.output().unwrap();
    assert_ne!(ran.status.code(), Some(2), "{ran:?}");
    let output = eliteserver()
        .arg("replay")
        .arg(&file)
        .arg("--rerun")
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let mut lines = text.lines();
    let cycles = lines
        .next()
        .and_then(|line| line.strip_prefix("identical: "));
    let cycles = cycles.and_then(|rest| rest.strip_suffix(" cycles"));
    let programs = lines
        .next()
        .is_some_and(|line| line.starts_with("identical: 1 programs, "));
    let Some(cycles) = cycles.filter(|_| programs) else {
        panic!("{} ({clock}): {text}{:?}", script.display(), output.stderr);
    };
    (cycles.parse().unwrap(), std::fs::read(&file).unwrap())
}

#[test]
fn every_program_that_moves_runs_again_from_its_recording() {
    let mut programs = scripts(&root().join("tests/moves"));
    assert!(programs.len() >= 7, "{programs:?}");
    // Those of examples/testing and examples/errors wait for machines that only their tests play; those of
    // examples/reference, and files whose names begin with `test_`, are tests; examples/cells have a test of their own.
    let others =
        ["testing", "errors", "reference", "cells"].map(|name| root().join("examples").join(name));
    programs.extend(
        scripts(&root().join("examples"))
            .into_iter()
            .filter(|path| !others.iter().any(|other| path.starts_with(other)))
            .filter(|path| {
                !path
                    .file_name()
                    .is_some_and(|name| name.to_string_lossy().starts_with("test_"))
            }),
    );
    programs.extend(
        scripts(&root().join("tests/scripts"))
            .into_iter()
            .filter(|path| moves(path)),
    );
    for program in &programs {
        let cycles = rerun(program, "virtual");
        assert!(cycles > 100, "{} has {cycles} cycles", program.display());
    }
}

#[test]
fn a_cell_that_lives_runs_again() {
    let cycles = rerun(&root().join("examples/cells/belt/pick.script"), "virtual");
    assert!(cycles > 5000, "{cycles}");
}

#[test]
fn a_run_under_the_real_clock_runs_again_too() {
    let all = std::env::var("ELITE_RERUN").is_ok_and(|which| which == "realtime");
    let programs = scripts(&root().join("tests/moves"));
    let chosen = programs
        .iter()
        .filter(|path| all || path.ends_with("inputs.script"));
    for program in chosen {
        rerun(program, "realtime");
    }
}

/// The thread of the world sleeps for 1.5 s again and again: cycles have results that are old, then more cycles wait
/// than the border holds, and the program ends while the world is behind.
#[test]
fn a_world_that_was_late_is_late_again() {
    let _machine = alone();
    let folder = tempfile::tempdir().unwrap();
    let cell = root().join("examples/cells/belt/cell.toml");
    std::fs::copy(cell, folder.path().join("cell.toml")).unwrap();
    let script = folder.path().join("discs.script");
    let text = "for way in range(3):\n movej([0.4, -1.5, 1.5, -1.5, -1.5, 0], a=3, v=2)\n\
                \x20movej([0, -1.5, 1.5, -1.5, -1.5, 0], a=3, v=2)\n sleep(0.3)\nend\nsleep(0.6)\n";
    std::fs::write(&script, text).unwrap();
    let (cycles, recording) = rerun_with_faults(&script, "realtime", &"world stall\n".repeat(8));
    assert!(cycles > 700, "{cycles}");
    let recording = Recording::from_bytes(recording, "late").unwrap();
    let messages: Vec<_> = topic::messages(&recording)
        .unwrap()
        .map(Result::unwrap)
        .collect();
    let late = messages.iter().filter(|message| message.seen.is_some());
    assert!(late.count() > 500);
    let missed: Vec<_> = messages
        .iter()
        .map(|message| message.missed)
        .filter(|missed| *missed > 0)
        .collect();
    assert!(missed.iter().sum::<u64>() > 100, "{missed:?}");
}
