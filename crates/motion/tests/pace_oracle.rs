//! How near to time-optimal lines past singular positions are: compared with the fastest motion that the speeds and
//! accelerations of the joints allow on the same line, by forward and backward integration on a fine grid (Bobrow,
//! Dubowsky and Gibson 1985), no faster than what takes up a joint's jerk at even speed. Other than that it has no
//! limit of jerk, and the torques are not asked, so it cannot be reached.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;

use common::draw::{Draw, fold};
use common::{Bench, MODELS, ideal};
use kinematics::{JointPositions, Pose, RobotModel};
use motion::CycleConfig;
use motion_api::{MotionCommand, Outcome};
use nalgebra::Vector3;

/// Places of the grid.
const PLACES: usize = 4000;
/// Time in which an acceleration is reached: what every change of it costs us, and the oracle not.
const RISE: f64 = 0.03;

/// A line of the TCP without turning.
struct Line {
    model: RobotModel,
    start: JointPositions,
    from: Pose,
    to: Pose,
}

impl Line {
    /// Sideways through a place where the wrist is `beside` rad from straight; `None` where the arm cannot follow.
    fn past_the_wrist(name: &str, draw: &mut Draw) -> Option<Self> {
        let model = RobotModel::built_in(name).unwrap();
        let beside = draw.spread(0.02, 0.4);
        let middle = JointPositions([
            draw.between(-1.0, 1.0),
            draw.between(-1.6, -1.0),
            draw.between(1.4, 2.0),
            draw.between(-2.2, -1.5),
            beside,
            draw.between(-1.0, 1.0),
        ]);
        let at = model.tcp_pose(&middle, &Pose::IDENTITY);
        let along = Vector3::from_fn(|_, _| draw.between(-1.0, 1.0)).normalize();
        let half = draw.between(0.05, 0.15);
        let pose = |way: f64| Pose::new(at.rotation, at.translation + along * way);
        let mut start = middle;
        for step in 1..=400 {
            let place = pose(-half * f64::from(step) / 400.0);
            start = model.inverse_continuous(&place, &Pose::IDENTITY, &start)?;
        }
        Some(Self {
            from: pose(-half),
            to: pose(half),
            model,
            start,
        })
    }

    fn length(&self) -> f64 {
        (self.to.translation - self.from.translation).norm()
    }

    /// q' and q'' at every place of the grid; `None` where the arm cannot follow.
    fn derivatives(&self) -> Option<Vec<([f64; 6], [f64; 6])>> {
        let way = self.to.translation - self.from.translation;
        let step = self.length() / PLACES as f64;
        let mut q = self.start;
        let mut places = Vec::new();
        for place in 0..=PLACES {
            let share = place as f64 / PLACES as f64;
            let pose = Pose::new(self.from.rotation, self.from.translation + way * share);
            q = self.model.inverse_continuous(&pose, &Pose::IDENTITY, &q)?;
            places.push(q);
        }
        let at = |place: usize, joint: usize| places[place.min(PLACES)][joint];
        Some(
            (0..=PLACES)
                .map(|place| {
                    let k = place.clamp(1, PLACES - 1);
                    let first =
                        std::array::from_fn(|j| (at(k + 1, j) - at(k - 1, j)) / (2.0 * step));
                    let second = std::array::from_fn(|j| {
                        (at(k + 1, j) - 2.0 * at(k, j) + at(k - 1, j)) / (step * step)
                    });
                    (first, second)
                })
                .collect(),
        )
    }
}

/// The shortest time over a line from rest to rest, s.
fn oracle(line: &Line, config: &CycleConfig, speed: f64, acceleration: f64) -> Option<f64> {
    let limits = config.resolve().unwrap();
    let derivatives = line.derivatives()?;
    let step = line.length() / PLACES as f64;
    // Accelerations of s at a place and a speed; none where the speed is too much.
    let range = |place: usize, v: f64| {
        let (first, second) = &derivatives[place];
        (0..6).try_fold((-acceleration, acceleration), |(low, high), joint| {
            let bend = second[joint] * v * v;
            let most = limits.acceleration[joint];
            let rate = first[joint].abs().max(1e-9);
            let sign = first[joint].signum();
            let centre = -bend * sign / rate;
            let (low, high) = (
                low.max(centre - most / rate),
                high.min(centre + most / rate),
            );
            (low <= high).then_some((low, high))
        })
    };
    let fastest: Vec<f64> = (0..=PLACES)
        .map(|place| {
            let k = place.clamp(8, PLACES - 8);
            let own = (0..6).fold(speed, |v, joint| {
                let (after, before) = (derivatives[k + 8].1[joint], derivatives[k - 8].1[joint]);
                let third = (after - before).abs() / (16.0 * step);
                v.min(limits.speed[joint] / derivatives[place].0[joint].abs())
                    .min((limits.jerk[joint] / third).cbrt())
            });
            let (mut good, mut bad) = (0.0, own);
            if range(place, own).is_some() {
                return own;
            }
            for _ in 0..50 {
                let middle = 0.5 * (good + bad);
                if range(place, middle).is_some() {
                    good = middle;
                } else {
                    bad = middle;
                }
            }
            good
        })
        .collect();
    let mut v = fastest;
    v[0] = 0.0;
    v[PLACES] = 0.0;
    for place in (0..PLACES).rev() {
        let low = range(place + 1, v[place + 1]).map_or(0.0, |r| r.0.min(0.0));
        v[place] = v[place].min((v[place + 1].powi(2) - 2.0 * low * step).sqrt());
    }
    for place in 0..PLACES {
        let high = range(place, v[place]).map_or(0.0, |r| r.1.max(0.0));
        v[place + 1] = v[place + 1].min((v[place].powi(2) + 2.0 * high * step).sqrt());
    }
    Some(
        v.windows(2)
            .map(|pair| 2.0 * step / (pair[0] + pair[1]))
            .sum(),
    )
}

#[test]
fn lines_past_singular_positions_take_little_longer_than_the_joints_make_them() {
    let mut ratios = Vec::new();
    for name in MODELS {
        let mut draw = Draw::new(fold(name));
        for _ in 0..cases() {
            let Some(line) = Line::past_the_wrist(name, &mut draw) else {
                continue;
            };
            let (speed, acceleration) = (draw.spread(0.1, 1.0), draw.spread(0.5, 5.0));
            let config = CycleConfig {
                home: line.start,
                ..ideal(name)
            };
            if config.resolve().is_err() {
                continue;
            }
            let Some(shortest) = oracle(&line, &config, speed, acceleration) else {
                continue;
            };
            let mut bench = Bench::new(config);
            let outcome = bench.do_it(MotionCommand::MoveL {
                target: line.to.to_rpy(),
                acceleration,
                speed,
                duration: 0.0,
                radius: 0.0,
            });
            if outcome != Outcome::Done {
                continue;
            }
            bench.check_limits();
            let took = bench
                .states
                .iter()
                .filter(|s| s.target_qd.max_abs() > 0.0)
                .count() as f64
                * 0.004;
            // Slowed only where a joint cannot keep up: the others are plain lines.
            let is_slowed = !bench.warnings.is_empty();
            if is_slowed {
                ratios.push(((took - RISE) / shortest, shortest, name));
            }
        }
    }
    ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
    let at = |share: usize| ratios[ratios.len() * share / 100].0;
    println!(
        "{} lines: {:.2} {:.2} {:.2} {:.3} times the oracle's time (least, median, 90 of 100, most)",
        ratios.len(),
        ratios[0].0,
        at(50),
        at(90),
        ratios[ratios.len() - 1].0
    );
    assert!(ratios.len() > 20 && ratios[0].0 > 0.98, "{ratios:?}");
    let most = ratios[ratios.len() - 1].0;
    assert!(at(50) < 1.15 && at(90) < 1.3, "{ratios:?}");
    assert!(most < 1.6, "{ratios:?}");
}

/// How many lines an arm; `ELITE_CASES` asks for more.
fn cases() -> u64 {
    let asked = std::env::var("ELITE_CASES");
    asked.ok().and_then(|n| n.parse().ok()).unwrap_or(8)
}
