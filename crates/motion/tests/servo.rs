//! What servoj makes of a stream: how late, how large, how smooth. Limits in random mixtures of modes: online.rs.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

mod common;

use common::{Bench, ideal};
use motion_api::CommandKind;

const STEP: f64 = 0.004;
const SIZE: f64 = 0.1;

/// A sine of 1 Hz that begins without a jump of speed.
fn sine(t: f64) -> f64 {
    SIZE * (2.0 * t).min(1.0) * (core::f64::consts::TAU * t).sin()
}

/// Setpoints of joint 1 for the sine, relative to the start, at gain 300 and 0.1 s; points with `is_late` come with the next.
fn setpoints(is_late: impl Fn(usize) -> bool) -> (Vec<f64>, Bench) {
    let mut bench = Bench::new(ideal("cs66"));
    let home = bench.now().target_q;
    let mut seen = Vec::new();
    for k in 0..1000 {
        if !is_late(k) {
            let mut target = home;
            target[0] += sine((k + 1) as f64 * STEP);
            bench.send(CommandKind::ServoJ {
                target,
                duration: STEP,
                lookahead: 0.1,
                gain: 300.0,
            });
        }
        seen.push(bench.tick().target_q[0] - home[0]);
    }
    (seen, bench)
}

/// What is off at the delay that fits best, rms over the amplitude, after the first second; and that delay, s.
fn fit(seen: &[f64]) -> (f64, f64) {
    let off = |delay: f64| {
        let apart = (250..1000).map(|k| seen[k] - sine((k + 1) as f64 * STEP - delay));
        (apart.map(|x| x * x).sum::<f64>() / 750.0).sqrt() / SIZE
    };
    (0..200)
        .map(|ms| f64::from(ms) * 1e-3)
        .map(|delay| (off(delay), delay))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .unwrap()
}

#[test]
fn a_slow_sine_comes_out_as_it_went_in_half_the_look_ahead_late() {
    let (seen, bench) = setpoints(|_| false);
    let (off, delay) = fit(&seen);
    assert!(off < 0.01, "{off}");
    assert!((delay - 0.05).abs() < 0.004, "{delay}");
    let highest = seen[250..].iter().copied().fold(f64::MIN, f64::max);
    assert!((highest / SIZE - 1.0).abs() < 0.02, "{highest}");
    bench.check_limits();
}

#[test]
fn points_that_come_late_change_little() {
    let (seen, bench) = setpoints(|k| k % 7 == 3);
    let (off, delay) = fit(&seen);
    assert!(off < 0.015, "{off}");
    assert!((delay - 0.05).abs() < 0.006, "{delay}");
    bench.check_limits();
    // Without the ripple that each late point would make if its acceleration were taken at its word.
    let worst = bench.states[260..]
        .iter()
        .map(|state| {
            let t = state.cycle as f64 * STEP - delay;
            let wanted =
                -SIZE * core::f64::consts::TAU.powi(2) * (core::f64::consts::TAU * t).sin();
            (state.target_qdd[0] - wanted).abs()
        })
        .fold(0.0, f64::max);
    assert!(worst < 2.5, "{worst} rad/s² off");
}
