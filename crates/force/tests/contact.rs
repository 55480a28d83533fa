//! The law of a force axis against springs: one setting from 1 to 100 N/mm, with the delays of a real loop.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot go on should say where"
)]

use force::{Admittance, AxisKind, AxisReading, Tuning};

const STEP: f64 = 0.004;
/// What the arm can do along the axis, m/s².
const ACCELERATION: f64 = 3.0;

/// A plate of `stiffness` N/m whose surface is `gap` m away; the target is `target` N.
#[derive(Clone, Copy)]
struct Setup {
    stiffness: f64,
    target: f64,
    gap: f64,
    speed_limit: f64,
    /// Cycles between a force and the command that knows it, the cycle of the command not counted.
    delay: usize,
    /// The tool slides at this speed over a surface of `slope`, m/s; from 1 s on.
    slide: f64,
    slope: f64,
    tuning: Tuning,
}

struct Run {
    /// Largest force over the target.
    peak: f64,
    /// From first touch until the force stays within 5 %, s.
    settled: f64,
    /// Largest deviation over the target in the last tenth.
    steady: f64,
    fastest: f64,
    /// Times the contact was lost after 1 s.
    bounces: u32,
}

/// Servo: critically damped at 100 rad/s with the commanded speed fed forward, in steps of 0.5 ms.
fn run(setup: &Setup) -> Run {
    let mut law = Admittance::new(AxisKind::Linear);
    let (mut x, mut v) = (0.0, 0.0);
    let (mut command, mut command_speed) = (0.0_f64, 0.0_f64);
    let mut last_x = 0.0;
    let mut surface = setup.gap;
    let mut forces = vec![0.0_f64; setup.delay + 1];
    let mut log = Vec::new();
    let mut fastest = 0.0_f64;
    for _ in 0..(12.0 / STEP) as usize {
        let time = log.len() as f64 * STEP;
        let slide = (0.3 * (time - 1.0)).clamp(0.0, setup.slide);
        surface += setup.slope * slide * STEP;
        let applied = forces[forces.len() - 1 - setup.delay];
        let aim = law.update(
            &AxisReading {
                applied,
                target: setup.target,
                displacement: x - last_x,
                tangential_displacement: slide * STEP,
                speed: command_speed,
                speed_limit: setup.speed_limit,
                braking: 0.7 * ACCELERATION,
                jerk: 150.0,
            },
            &setup.tuning,
            STEP,
        );
        last_x = x;
        let most = aim.acceleration.min(ACCELERATION) * STEP;
        let next = command_speed + (aim.speed - command_speed).clamp(-most, most);
        for k in 0..8 {
            let h = STEP / 8.0;
            let share = (f64::from(k) + 1.0) / 8.0;
            let wanted_speed = command_speed + (next - command_speed) * share;
            command += wanted_speed * h;
            let a =
                200.0 * (wanted_speed - v) + 1e4 * (command - x) + (next - command_speed) / STEP;
            v += a * h;
            x += v * h;
        }
        command_speed = next;
        fastest = fastest.max(next.abs());
        let force = setup.stiffness * (x - surface).max(0.0);
        forces.push(force);
        log.push(force);
    }
    let touch = log.iter().position(|f| *f > 0.0).unwrap_or(log.len());
    let off = |f: f64| (f / setup.target - 1.0).abs();
    let settled = log
        .iter()
        .rposition(|f| off(*f) > 0.05)
        .map_or(0, |k| k + 1);
    let one_second = touch + (1.0 / STEP) as usize;
    Run {
        peak: log.iter().fold(0.0_f64, |m, f| m.max(*f)) / setup.target,
        settled: (settled as f64 - touch as f64) * STEP,
        steady: log[log.len() * 9 / 10..]
            .iter()
            .fold(0.0_f64, |m, f| m.max(off(*f))),
        fastest,
        bounces: log
            .windows(2)
            .skip(one_second)
            .filter(|w| w[0] > 0.0 && w[1] <= 0.0)
            .count() as u32,
    }
}

fn setup(stiffness: f64, target: f64) -> Setup {
    Setup {
        stiffness,
        target,
        gap: 0.003,
        speed_limit: 0.01,
        delay: 0,
        slide: 0.0,
        slope: 0.0,
        tuning: Tuning::default(),
    }
}

#[test]
fn one_setting_serves_plates_of_1_to_100_newtons_a_millimetre() {
    for delay in [0, 1] {
        for stiffness in [1e3, 1e4, 1e5] {
            for target in [5.0, 20.0, 80.0] {
                // In contact at once, and as fast as a user may allow.
                let hard = Setup {
                    delay,
                    gap: 0.0,
                    speed_limit: 0.25,
                    ..setup(stiffness, target)
                };
                let r = run(&hard);
                println!(
                    "{stiffness} N/m {target} N delay {delay}: peak {:.3} settled {:.3} s steady {:.5} fastest {:.3}",
                    r.peak, r.settled, r.steady, r.fastest
                );
                assert!(r.peak <= 1.15 && r.settled <= 0.5 && r.steady <= 0.01 && r.bounces == 0);
            }
        }
    }
}

#[test]
fn an_approach_at_ten_millimetres_a_second_peaks_below_one_and_a_half_targets() {
    for delay in [0, 1] {
        for stiffness in [1e3, 1e4, 1e5] {
            for target in [5.0, 20.0, 80.0] {
                let r = run(&Setup {
                    delay,
                    ..setup(stiffness, target)
                });
                println!(
                    "{stiffness} N/m {target} N delay {delay}: peak {:.3} settled {:.3} s steady {:.5} fastest {:.4}",
                    r.peak, r.settled, r.steady, r.fastest
                );
                assert!(r.fastest <= 0.01 + 1e-12);
                assert!(r.peak <= 1.5 && r.steady <= 0.01 && r.bounces == 0);
            }
        }
    }
}

#[test]
fn a_tilted_surface_is_followed() {
    for stiffness in [1e3, 1e4, 1e5] {
        for slope in [0.1, -0.2, 0.36] {
            let sliding = Setup {
                slide: 0.05,
                slope,
                gap: 0.0,
                speed_limit: 0.1,
                ..setup(stiffness, 20.0)
            };
            let r = run(&sliding);
            println!(
                "{stiffness} N/m slope {slope}: peak {:.3} steady {:.4}",
                r.peak, r.steady
            );
            assert!(r.steady < 0.02 && r.bounces == 0);
        }
    }
}

/// Pushed with 20 N for half a second and let go: the speed then, and one second later.
fn pushed(damping: f64) -> (f64, f64) {
    let mut law = Admittance::new(AxisKind::Linear);
    let tuning = Tuning {
        damping,
        ..Tuning::default()
    };
    let mut speed = 0.0_f64;
    let mut let_go = 0.0;
    for k in 0..375 {
        let reading = AxisReading {
            applied: if k < 125 { -20.0 } else { 0.0 },
            target: 0.0,
            displacement: speed * STEP,
            tangential_displacement: 0.0,
            speed,
            speed_limit: 0.25,
            braking: 2.0,
            jerk: 150.0,
        };
        let aim = law.update(&reading, &tuning, STEP);
        let most = aim.acceleration.min(ACCELERATION) * STEP;
        speed += (aim.speed - speed).clamp(-most, most);
        if k == 125 {
            let_go = speed;
        }
    }
    (let_go, speed)
}

#[test]
fn a_hand_leads_the_arm_and_the_damping_stops_it() {
    let (led, kept) = pushed(0.0);
    assert!(led > 0.2 && kept == led, "{led} {kept}");
    let (led, stopped) = pushed(1.0);
    assert!(led > 0.005 && stopped < 1e-3, "{led} {stopped}");
}

#[test]
fn without_force_and_contact_the_damping_decides_whether_the_speed_is_kept() {
    let coast = |damping: f64| {
        let mut law = Admittance::new(AxisKind::Linear);
        let tuning = Tuning {
            damping,
            ..Tuning::default()
        };
        let mut speed = 0.1;
        for _ in 0..250 {
            let aim = law.update(
                &AxisReading {
                    applied: 0.0,
                    target: 0.0,
                    displacement: speed * STEP,
                    tangential_displacement: 0.0,
                    speed,
                    speed_limit: 0.25,
                    braking: 2.0,
                    jerk: 150.0,
                },
                &tuning,
                STEP,
            );
            speed += (aim.speed - speed).clamp(-aim.acceleration * STEP, aim.acceleration * STEP);
        }
        speed
    };
    assert_eq!(coast(0.0), 0.1);
    assert!(coast(0.3) < 0.01);
    assert!(coast(1.0) < 1e-3);
}
