//! Records onto a disk of 400 kB/s that stands still for 2 s in every 10 s, at 250 Hz in real time, and tells what was
//! lost and what it cost the thread that makes the cycles.
//!
//! `cargo run -p recorder --example slow_disk -- [MINUTES]`

#![allow(clippy::unwrap_used, reason = "a measurement fails by panicking")]

#[path = "../tests/support/mod.rs"]
mod support;

fn main() {
    let minutes: f64 = std::env::args()
        .nth(1)
        .map_or(10.0, |text| text.parse().unwrap());
    let run = support::record_onto_a_slow_disk(minutes * 60.0, 1.0);
    let cost = |share: f64| run.costs[((run.costs.len() - 1) as f64 * share) as usize];
    println!(
        "{} cycles, {} lost, {} stalls, {} bytes",
        run.cycles,
        run.lost,
        run.stalls,
        run.file.len()
    );
    println!(
        "cost a cycle: p50 {:?}, p99 {:?}, largest {:?}",
        cost(0.5),
        cost(0.99),
        cost(1.0)
    );
}
