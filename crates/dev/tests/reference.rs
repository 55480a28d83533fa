//! The pages of the reference are what `cargo dev reference` makes, and their examples run.

#![allow(clippy::unwrap_used, reason = "tests fail by panicking")]

use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

#[test]
fn the_pages_are_current() {
    for made in dev::reference::make(&root()).unwrap() {
        let found = std::fs::read_to_string(root().join(&made.path)).unwrap_or_default();
        assert!(
            found == made.text,
            "{} is not what the declarations say; run `cargo dev reference`",
            made.path
        );
    }
}

#[test]
fn the_examples_run() {
    let test = std::env::current_exe().unwrap();
    let beside = test.parent().unwrap().with_file_name("eliteserver");
    let binary = std::env::var_os("ELITESERVER").map_or(beside, PathBuf::from);
    assert!(binary.exists(), "{binary:?} is not there: cargo build");
    let output = Command::new(binary)
        .arg("test")
        .arg(root().join("examples/reference"))
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{told}");
    assert!(told.contains("163 passed"), "{told}");
}
