//! A disk that is slow and stands still now and then loses nothing and costs the motion thread nothing.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use crate::support;

use std::time::Duration;

use recorder::Recording;
use support::*;

#[test]
fn nothing_is_lost_on_a_slow_disk() {
    // Half a minute in three seconds; examples/slow_disk.rs runs ten minutes in their own time.
    let run = record_onto_a_slow_disk(30.0, 10.0);
    assert_eq!(run.lost, 0);
    assert!(run.stalls >= 2, "{} stalls", run.stalls);
    let recording = Recording::from_bytes(run.file, "slow").unwrap();
    let numbers = recording
        .cycles()
        .unwrap()
        .map(|cycle| cycle.unwrap().cycle);
    assert!(numbers.eq(1..=run.cycles));
    // Whoever makes the cycles never waits for the disk: a wait would be as long as a stall.
    let median = run.costs[run.costs.len() / 2];
    assert!(median < Duration::from_micros(20), "{median:?}");
}
