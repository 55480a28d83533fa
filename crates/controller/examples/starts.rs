//! How long a controller takes to start, to run a program that does nothing, and to end: figures for
//! docs/BENCHMARKS.md.

#![allow(clippy::unwrap_used, reason = "a measurement fails by panicking")]

use std::sync::Arc;
use std::time::{Duration, Instant};

use controller::{ControllerConfig, PreparedController, StartOptions};
use elite_runtime::ProgramText;
use elite_runtime::message::Observer;

/// Controllers of the figure.
const ROUNDS: usize = 300;

struct Nobody;

impl Observer for Nobody {}

fn main() {
    let mut times = [const { Vec::new() }; 3];
    let begin = Instant::now();
    for _ in 0..ROUNDS {
        let started = Instant::now();
        let prepared =
            PreparedController::new(&ControllerConfig::default(), StartOptions::for_single_run())
                .unwrap();
        let controller = prepared.start(Arc::new(Nobody)).unwrap();
        times[0].push(started.elapsed());
        let ran = Instant::now();
        let program = ProgramText {
            name: "nothing.script".to_owned(),
            text: "pass".to_owned(),
        };
        controller
            .run_to_end(program, "a measurement", std::future::pending())
            .unwrap();
        times[1].push(ran.elapsed());
        let ended = Instant::now();
        controller.shut_down();
        times[2].push(ended.elapsed());
    }
    let all = begin.elapsed();
    println!("| | p50 ms | p99 ms |\n|---|---|---|");
    for (name, mut times) in ["start", "a program of `pass`", "end"]
        .into_iter()
        .zip(times)
    {
        times.sort();
        let ms = |time: Duration| time.as_secs_f64() * 1e3;
        let (p50, p99) = (times[ROUNDS / 2], times[ROUNDS * 99 / 100]);
        println!("| {name} | {:.2} | {:.2} |", ms(p50), ms(p99));
    }
    println!(
        "{:.0} controllers a second",
        ROUNDS as f64 / all.as_secs_f64()
    );
}
