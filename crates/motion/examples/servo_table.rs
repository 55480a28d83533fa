//! Delay and overshoot of servoj over gain and look-ahead, as a table in Markdown.
//!
//! `cargo run -p motion --example servo_table`. Setpoints of an ideal CS66 at 4 ms, joint 1 alone:
//! - delay: how far the setpoint is behind a stream of points that moves at 0.5 rad/s, in time;
//! - ramp: how far the setpoint overshoots when that stream stops from one point to the next;
//! - step: how far it overshoots a single point 0.2 rad away, and when it is half way there;
//! - sine of 1 Hz: the delay that fits best, what is off then, and how large it comes out.
#![allow(
    clippy::expect_used,
    reason = "an example that cannot go on should say where"
)]

use kinematics::RobotModel;
use motion::{ControlLoop, CycleConfig, CycleTiming, PlantKind};
use motion_api::{CommandKind, OnlineCommand, Origin, RingCapacities, motion_channel};

const STEP: f64 = 0.004;
const SPEED: f64 = 0.5;
const JUMP: f64 = 0.2;

/// Setpoints of joint 1 relative to the start for a stream of points, one a cycle.
fn stream(gain: f64, lookahead: f64, point: impl Fn(f64) -> f64, seconds: f64) -> Vec<f64> {
    let config = CycleConfig {
        plant: PlantKind::Ideal,
        ..CycleConfig::new(RobotModel::built_in("cs66").expect("a built-in arm"))
    };
    let home = config.home;
    let (motion, mut script) = motion_channel(
        RingCapacities {
            records: None,
            ..RingCapacities::default()
        },
        &config.first_state(),
    );
    let mut cycle = ControlLoop::new(config, motion).expect("a controller");
    (0..(seconds / STEP) as u32)
        .map(|k| {
            let mut target = home;
            target[0] += point(f64::from(k + 1) * STEP);
            let kind = CommandKind::Online(OnlineCommand::ServoJ {
                target,
                duration: STEP,
                lookahead,
                gain,
            });
            script.commands.send(Origin::default(), kind).expect("room");
            cycle.tick(CycleTiming::default());
            while script.events.next_event().is_some() {}
            script.snapshot.read().target_q[0] - home[0]
        })
        .collect()
}

/// A sine of 0.05 rad and 1 Hz: the delay (s) at which the setpoints fit best, what is off then (rms over the
/// amplitude), and their own amplitude over that of the sine.
fn sine(gain: f64, lookahead: f64) -> (f64, f64, f64) {
    const SIZE: f64 = 0.05;
    let wanted = |t: f64| SIZE * (2.0 * t).min(1.0) * (core::f64::consts::TAU * t).sin();
    let setpoints = stream(gain, lookahead, wanted, 4.0);
    let settled = setpoints.iter().enumerate().skip((1.0 / STEP) as usize);
    let off = |delay: f64| {
        let apart = settled
            .clone()
            .map(|(k, q)| q - wanted((k + 1) as f64 * STEP - delay));
        let squares: Vec<f64> = apart.map(|x| x * x).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt() / SIZE
    };
    let delays = (0..300).map(|ms| f64::from(ms) * 1e-3);
    let delay = delays.min_by(|a, b| off(*a).total_cmp(&off(*b)));
    let delay = delay.expect("300 of them");
    let highest = settled.clone().map(|(_, q)| *q).fold(f64::MIN, f64::max);
    (delay, off(delay), highest / SIZE)
}

fn main() {
    println!(
        "| gain | look-ahead | delay | overshoot, ramp | overshoot, step | half way, step | sine: \
         delay | off, rms | size |"
    );
    println!("|---|---|---|---|---|---|---|---|---|");
    for gain in [100.0, 300.0, 600.0, 1000.0, 2000.0] {
        for lookahead in [0.03, 0.06, 0.1, 0.2] {
            let ramp = |t: f64| SPEED * t.min(1.5);
            let setpoints = stream(gain, lookahead, ramp, 4.0);
            let at = (1.4 / STEP) as usize;
            let delay = (at + 1) as f64 * STEP - setpoints[at] / SPEED;
            let highest = |v: &[f64]| v.iter().copied().fold(f64::MIN, f64::max);
            let over_ramp = highest(&setpoints) - SPEED * 1.5;
            let jump = stream(gain, lookahead, |_| JUMP, 4.0);
            let over_step = highest(&jump) - JUMP;
            let half = jump.iter().position(|x| *x >= JUMP / 2.0).unwrap_or(0);
            let (sine_delay, sine_off, sine_size) = sine(gain, lookahead);
            println!(
                "| {gain} | {lookahead} s | {:.0} ms | {:.1} mrad | {:.1} mrad | {:.0} ms | {:.0} ms | \
                 {:.1} % | {:.3} |",
                delay * 1e3,
                over_ramp.max(0.0) * 1e3,
                over_step.max(0.0) * 1e3,
                (half + 1) as f64 * STEP * 1e3,
                sine_delay * 1e3,
                sine_off * 1e2,
                sine_size
            );
        }
    }
}
