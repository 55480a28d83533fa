//! What servoj makes of a stream: how late, how large, how smooth, and that it never makes it larger. Limits in random
//! mixtures of modes: online.rs.
//!
//! `ELITE_CASES=N` runs that many random streams, `ELITE_FIRST` is the first seed.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::draw::Draw;
use common::{Bench, MODELS, ideal};
use kinematics::JointPositions;
use motion::CycleConfig;
use motion_api::{OnlineCommand, Outcome, RobotState};

const STEP: f64 = 0.004;
const SIZE: f64 = 0.1;

/// A sine of 1 Hz that begins without a jump of speed.
fn sine(t: f64) -> f64 {
    SIZE * (2.0 * t).min(1.0) * (core::f64::consts::TAU * t).sin()
}

/// Setpoints of joint 1 for the sine, relative to the start, at gain 300 and 0.1 s; points with `is_late` come with the
/// next.
fn setpoints(is_late: impl Fn(usize) -> bool) -> (Vec<f64>, Bench) {
    let mut bench = Bench::new(ideal("cs66"));
    let home = bench.now().target_q;
    let mut seen = Vec::new();
    for k in 0..1000 {
        if !is_late(k) {
            let mut target = home;
            target[0] += sine((k + 1) as f64 * STEP);
            bench.send(OnlineCommand::ServoJ {
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

/// Where one joint is sent, cycle by cycle, about 0.
#[derive(Clone, Copy, Debug)]
enum Wander {
    /// Anywhere in the band, anew in each cycle.
    Noise,
    /// From end to end of the band, so many cycles each.
    Square(usize),
    /// Anywhere in the band, for up to so many cycles each.
    Steps(usize),
    /// A swing of a frequency, Hz.
    Sine(f64),
    /// There and back at even speed, rad/s.
    Ramps(f64),
    /// To a neighbouring place in each cycle, at most so far, rad.
    Walk(f64),
    /// Now and then far away.
    Wild,
}

impl Wander {
    fn draw(draw: &mut Draw) -> Self {
        match draw.whole(0, 6) {
            0 => Self::Noise,
            1 => Self::Square(draw.whole(1, 120)),
            2 => Self::Steps(draw.whole(1, 150)),
            3 => Self::Sine(draw.spread(0.2, 30.0)),
            4 => Self::Ramps(draw.spread(0.05, 5.0)),
            5 => Self::Walk(draw.spread(1e-4, 0.1)),
            _ => Self::Wild,
        }
    }

    /// The next place in a band of `size` to either side.
    fn next(self, draw: &mut Draw, (k, step, size): (usize, f64, f64), before: f64) -> f64 {
        let time = k as f64 * step;
        match self {
            Self::Noise => draw.between(-size, size),
            Self::Square(cycles) => size * if k / cycles % 2 == 0 { 1.0 } else { -1.0 },
            Self::Steps(cycles) if draw.chance(1.0 / cycles as f64) => draw.between(-size, size),
            Self::Steps(_) => before,
            Self::Sine(frequency) => size * (core::f64::consts::TAU * frequency * time).sin(),
            Self::Ramps(speed) => {
                let way = speed * time / size;
                size * (1.0 - ((way - 1.0).rem_euclid(4.0) - 2.0).abs())
            }
            Self::Walk(most) => (before + draw.between(-most, most)).max(-size).min(size),
            Self::Wild if draw.chance(0.02) => draw.between(-1.2, 1.2),
            Self::Wild => draw.between(-size, size),
        }
    }
}

/// What a stream did to the joints.
struct Streamed {
    bench: Bench,
    home: JointPositions,
    /// The targets about home, and from which state on each counts.
    targets: Vec<(usize, [f64; 6])>,
    told: String,
}

/// A random stream: targets of six joints, late and lost points, gains, look-aheads and times that change; then targets
/// that stand for four seconds.
fn random_stream(seed: u64) -> Streamed {
    let mut draw = Draw::new(seed);
    let step = *draw.pick(&[0.001, 0.002, 0.004, 0.008]);
    let mut bench = Bench::new(CycleConfig {
        step_time: step,
        ..ideal(MODELS[draw.whole(0, 5)])
    });
    let home = bench.now().target_q;
    let wanders: [Wander; 6] = core::array::from_fn(|_| Wander::draw(&mut draw));
    let sizes: [f64; 6] = core::array::from_fn(|_| draw.spread(0.01, 0.5));
    let mut own = (draw.between(0.03, 0.2), draw.spread(100.0, 2000.0));
    let duration = step * *draw.pick(&[1.0, 1.0, 1.0, 0.5, 2.0, 7.3]);
    let lost = *draw.pick(&[0.0, 0.0, 0.1, 0.5]);
    let changes = *draw.pick(&[0.0, 0.0, 0.01]);
    let told =
        format!("{seed}: {wanders:?} {sizes:?} {own:?} t {duration} lost {lost} step {step}");
    let mut targets = Vec::new();
    let mut now = [0.0; 6];
    let cycles = (2.4 / step) as usize;
    let mut k = 0;
    while k < cycles {
        for joint in 0..6 {
            let place = (k, step, sizes[joint]);
            now[joint] = wanders[joint].next(&mut draw, place, now[joint]);
        }
        if draw.chance(changes) {
            own = (draw.between(0.03, 0.2), draw.spread(100.0, 2000.0));
        }
        if !draw.chance(lost) {
            servo_to(&mut bench, &home, &now, (duration, own));
            targets.push((bench.states.len(), now));
        }
        // Now and then nothing comes for a while.
        let wait = if draw.chance(0.002) {
            draw.whole(1, 100)
        } else {
            1
        };
        bench.run(wait);
        k += wait;
    }
    for _ in 0..(4.0 / step) as usize {
        servo_to(&mut bench, &home, &now, (duration, own));
        bench.tick();
    }
    targets.push((bench.states.len(), now));
    Streamed {
        bench,
        home,
        targets,
        told,
    }
}

fn servo_to(
    bench: &mut Bench,
    home: &JointPositions,
    to: &[f64; 6],
    (duration, (lookahead, gain)): (f64, (f64, f64)),
) {
    bench.send(OnlineCommand::ServoJ {
        target: JointPositions(core::array::from_fn(|joint| home[joint] + to[joint])),
        duration,
        lookahead,
        gain,
    });
}

/// How far a joint goes beyond the hull of its targets so far, and the most that braking explains: from the speed with
/// which it left the hull.
fn excess(streamed: &Streamed, joint: usize) -> Vec<(f64, f64)> {
    let bench = &streamed.bench;
    let step = bench.cycle.step_time();
    let (acceleration, jerk) = (bench.limits.acceleration[joint], bench.limits.jerk[joint]);
    // The acceleration turns round first; what the joint does in the cycle in which it leaves counts too.
    let braking = |speed: f64| {
        let speed = speed + acceleration * step;
        let turning = 2.0 * acceleration / jerk + step;
        speed * turning
            + acceleration * turning * turning / 2.0
            + (speed + acceleration * turning).powi(2) / (2.0 * acceleration)
    };
    let place = |state: &RobotState| state.target_q[joint] - streamed.home[joint];
    let mut beyond = Vec::new();
    for sign in [1.0, -1.0] {
        let (mut edge, mut next, mut speed) = (0.0_f64, 0, 0.0_f64);
        for (k, state) in bench.states.iter().enumerate() {
            while next < streamed.targets.len() && streamed.targets[next].0 <= k {
                edge = edge.max(sign * streamed.targets[next].1[joint]);
                next += 1;
            }
            let out = sign * place(state) - edge;
            if out <= 0.0 {
                speed = (sign * state.target_qd[joint]).max(0.0);
            } else {
                beyond.push((out, braking(speed)));
            }
        }
    }
    beyond
}

#[test]
fn whatever_the_targets_do_the_arm_stays_with_them_and_stands_when_they_stand() {
    let number = |name: &str| std::env::var(name).ok()?.parse::<u64>().ok();
    let first = number("ELITE_FIRST").unwrap_or(0);
    let (mut most_share, mut faults) = (0.0_f64, Vec::new());
    for seed in first..first + number("ELITE_CASES").unwrap_or(24) {
        let streamed = random_stream(seed);
        let bench = &streamed.bench;
        assert!(
            bench.stops.is_empty(),
            "{}: {:?}",
            streamed.told,
            bench.stops
        );
        let refused = |outcome: &Outcome| matches!(outcome, Outcome::Refused(_));
        assert!(!bench.ended.iter().any(|(_, outcome, _)| refused(outcome)));
        for joint in 0..6 {
            for (out, braking) in excess(&streamed, joint) {
                most_share = most_share.max(out / braking);
                if out > braking {
                    faults.push(format!(
                        "{} joint {joint}: {out} of {braking}",
                        streamed.told
                    ));
                    break;
                }
            }
            let end = streamed.targets.last().unwrap().1[joint] + streamed.home[joint];
            let state = bench.now();
            if (state.target_q[joint] - end).abs() > 1e-12 || state.target_qd[joint] != 0.0 {
                let away = state.target_q[joint] - end;
                faults.push(format!(
                    "{} joint {joint} is {away} from its target",
                    streamed.told
                ));
            }
        }
        faults.extend(bench.limit_faults().into_iter().take(2));
    }
    println!("at most {most_share} of what braking explains");
    assert!(
        faults.is_empty(),
        "{} faults: {:#?}",
        faults.len(),
        &faults[..faults.len().min(6)]
    );
}

#[test]
fn targets_that_lead_nowhere_are_not_followed_out_of_their_band() {
    for (seed, gain, lookahead) in [
        (1, 300.0, 0.1),
        (2, 100.0, 0.03),
        (3, 2000.0, 0.2),
        (4, 2000.0, 0.03),
    ] {
        let mut draw = Draw::new(seed);
        let mut bench = Bench::new(ideal("cs66"));
        let home = bench.now().target_q;
        let mut most = 0.0_f64;
        for _ in 0..1200 {
            let to = core::array::from_fn(|_| draw.between(-0.3, 0.3));
            servo_to(&mut bench, &home, &to, (STEP, (lookahead, gain)));
            let state = bench.tick();
            most = (0..6).fold(most, |m, j| m.max((state.target_q[j] - home[j]).abs()));
        }
        // White noise has a mean that hardly moves.
        let allowed = if lookahead > 0.05 { 0.12 } else { 0.3 };
        println!("{gain} {lookahead}: {most}");
        assert!(most < allowed, "{gain} {lookahead}: {most}");
        bench.check_limits();
    }
}
