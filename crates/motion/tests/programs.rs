//! Random programs, and a checker that goes over every recorded cycle of them.
//!
//! A program is a mixture of movej, movel and movec with blend radii and durations, servoj, speedj and speedl, while the
//! slider moves and the motion is paused. Whatever it asks: no cycle is over a limit, the arm is on its path or within a
//! blend radius, it ends where it was told to, and a movej takes no longer than an independent planner needs.
//!
//! `ELITE_PROGRAMS=500` runs that many on every model; `ELITE_MOVEJ_CSV=file` writes the durations of the movej for
//! `tests/peers/ruckig_durations.py`.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot go on should say where"
)]
#![allow(
    clippy::approx_constant,
    reason = "joint angles and speeds as people type them"
)]

mod common;

use std::fmt::Write as _;

use common::{Bench, MODELS, ideal};
use kinematics::{JointPositions, JointSpeeds, Pose, RobotModel, RpyPose};
use motion_api::{CommandId, CommandKind, MotionMode, Outcome, Warning};
use nalgebra::{Rotation3, Vector3};

/// Most that the arm may be beside its path, rad and m.
const BESIDE: f64 = 1e-6;
/// Most that it may miss an end by, rad and m.
const MISSED: f64 = 1e-9;

/// Numbers that look random and are the same in every run (SplitMix64).
struct Dice(u64);

impl Dice {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn one_in(&mut self, n: u64) -> bool {
        self.next().is_multiple_of(n)
    }

    fn six(&mut self, most: f64) -> [f64; 6] {
        core::array::from_fn(|_| self.within(-most, most))
    }
}

/// One leg of a chain of blended motions, as it was asked for.
struct Leg {
    geometry: Geometry,
    /// Blend radius at its end, m.
    radius: f64,
    end: JointPositions,
    id: CommandId,
    /// The slider moved, or there was a pause.
    is_disturbed: bool,
}

enum Geometry {
    Joints(JointPositions, JointPositions),
    Line(Pose, Pose),
    Arc {
        centre: Vector3<f64>,
        normal: Vector3<f64>,
        radius: f64,
    },
}

impl Geometry {
    /// How far the arm is beside it: rad in joint space; m or rad, whichever is more, otherwise.
    fn beside(&self, q: &JointPositions, tcp: &Pose) -> f64 {
        match self {
            Self::Joints(from, to) => {
                let way: [f64; 6] = core::array::from_fn(|k| to[k] - from[k]);
                let length: f64 = way.iter().map(|x| x * x).sum();
                let along: f64 = (0..6).map(|k| (q[k] - from[k]) * way[k]).sum();
                let share = if length > 0.0 { along / length } else { 0.0 }.clamp(0.0, 1.0);
                (0..6).fold(0.0_f64, |most, k| {
                    most.max((q[k] - from[k] - share * way[k]).abs())
                })
            }
            Self::Line(from, to) => {
                let way = to.translation - from.translation;
                let turn = (to.rotation * from.rotation.inverse()).scaled_axis();
                let turned = (tcp.rotation * from.rotation.inverse()).scaled_axis();
                let share = if way.norm() > 1e-3 {
                    (tcp.translation - from.translation).dot(&way) / way.norm_squared()
                } else {
                    turned.dot(&turn) / turn.norm_squared()
                }
                .clamp(0.0, 1.0);
                let off = (tcp.translation - from.translation - way * share).norm();
                let there = Rotation3::new(turn * share) * from.rotation;
                off.max(apart(&tcp.rotation, &there))
            }
            Self::Arc {
                centre,
                normal,
                radius,
            } => {
                let from = tcp.translation - centre;
                let height = from.dot(normal);
                height
                    .abs()
                    .max(((from - normal * height).norm() - radius).abs())
            }
        }
    }
}

/// The angle between two rotations that are nearly the same; `angle` itself is good for 1e-8 only.
fn apart(one: &Rotation3<f64>, other: &Rotation3<f64>) -> f64 {
    (one.matrix() - other.matrix()).norm() / core::f64::consts::SQRT_2
}

/// The arm with the chain that it is on.
struct Run {
    bench: Bench,
    model: RobotModel,
    /// Legs since the arm stood last.
    legs: Vec<Leg>,
    /// Where the state lies in `bench.states` from which they are checked.
    since: usize,
    tally: Tally,
    csv: String,
}

#[derive(Default)]
struct Tally {
    cycles: usize,
    motions: usize,
    refused: usize,
    beside: f64,
    missed: f64,
    slower: f64,
    blends: usize,
    /// Of those, how many leave their leg later than 0.6 r before the corner.
    late: usize,
}

impl Run {
    fn new(name: &'static str, step: f64) -> Self {
        let mut config = ideal(name);
        config.step_time = step;
        Self {
            model: RobotModel::built_in(name).unwrap(),
            bench: Bench {
                model: name,
                ..Bench::new(config)
            },
            legs: Vec::new(),
            since: 0,
            tally: Tally::default(),
            csv: String::new(),
        }
    }

    fn pose(&self, q: &JointPositions) -> Pose {
        self.model.tcp_pose(q, &Pose::IDENTITY)
    }

    /// Where the next leg begins.
    fn corner(&self) -> JointPositions {
        let now = self.bench.now().target_q;
        self.legs.last().map_or(now, |leg| leg.end)
    }

    /// Sends a motion and goes on until it ends, with the slider and pauses on the way.
    fn move_along(&mut self, dice: &mut Dice, kind: CommandKind) {
        let corner = self.corner();
        let from = self.pose(&corner);
        let begun_at_rest = self.legs.is_empty();
        let begun = self.bench.now().cycle;
        let disturbed = dice.one_in(3);
        let id = self.bench.send(kind);
        let mut cycles = 0u64;
        let outcome = loop {
            if let Some(outcome) = self.bench.outcome(id) {
                break outcome;
            }
            self.bench.tick();
            cycles += 1;
            assert!(cycles < 60_000, "{kind:?} does not end");
            if disturbed && dice.one_in(60) {
                if dice.one_in(3) {
                    self.bench.do_it(CommandKind::Pause);
                    let cycles = dice.within(0.0, 40.0) as usize;
                    self.bench.run(cycles);
                    self.bench.do_it(CommandKind::Resume);
                } else {
                    let fraction = dice.within(0.05, 1.0);
                    self.bench.send(CommandKind::SetSpeedFraction(fraction));
                }
            }
        };
        if disturbed {
            self.bench.send(CommandKind::SetSpeedFraction(1.0));
        }
        self.tally.motions += 1;
        match outcome {
            Outcome::Done => {}
            Outcome::Refused(_) => {
                self.tally.refused += 1;
                self.stand();
                return;
            }
            other => panic!("{kind:?} ended as {other:?}: {:?}", self.bench.stops),
        }
        let (geometry, radius, end) = self.leg_of(&kind, from, corner);
        self.legs.push(Leg {
            geometry,
            radius,
            end,
            id,
            is_disturbed: disturbed,
        });
        if radius == 0.0 {
            let seconds = (self.bench.now().cycle - begun) as f64 * self.bench.cycle.step_time();
            let is_warned = self.bench.warnings.iter().any(|(warned, _)| *warned == id);
            if begun_at_rest && !disturbed && !is_warned {
                self.compare_duration(&kind, &corner, seconds);
            }
            self.stand();
        }
    }

    /// The leg that a motion is, and where it ends.
    fn leg_of(
        &self,
        kind: &CommandKind,
        from: Pose,
        corner: JointPositions,
    ) -> (Geometry, f64, JointPositions) {
        match *kind {
            CommandKind::MoveJ { target, radius, .. } => {
                (Geometry::Joints(corner, target), radius, target)
            }
            CommandKind::MoveL { target, radius, .. } => {
                let to = Pose::from_rpy(&target);
                let geometry = Geometry::Line(from, to);
                (geometry, radius, self.joints_at(&to, corner, from))
            }
            CommandKind::MoveC {
                via,
                target,
                radius,
                ..
            } => {
                let to = Pose::from_rpy(&target);
                let (centre, normal) = circle(
                    from.translation,
                    Vector3::from(via.xyz),
                    Vector3::from(target.xyz),
                );
                let geometry = Geometry::Arc {
                    centre,
                    normal,
                    radius: (from.translation - centre).norm(),
                };
                (geometry, radius, self.joints_at(&to, corner, from))
            }
            _ => unreachable!("only planned motions have legs"),
        }
    }

    /// The joints at the end of a Cartesian leg: the waypoint that is reported while the arm is on the way.
    fn joints_at(&self, to: &Pose, corner: JointPositions, from: Pose) -> JointPositions {
        let mut q = corner;
        let turn = (to.rotation * from.rotation.inverse()).scaled_axis();
        for k in 1..=400 {
            let share = f64::from(k) / 400.0;
            let pose = Pose::new(
                Rotation3::new(turn * share) * from.rotation,
                from.translation + (to.translation - from.translation) * share,
            );
            if let Some(next) = self.model.inverse_following(&pose, &Pose::IDENTITY, &q) {
                q = next;
            }
        }
        q
    }

    /// Comes to rest and checks the chain.
    fn stand(&mut self) {
        for _ in 0..5000 {
            if self.bench.now().motion_mode == MotionMode::Idle {
                break;
            }
            self.bench.tick();
        }
        let last = self.bench.now();
        assert_eq!(last.motion_mode, MotionMode::Idle);
        if let Some(leg) = self.legs.last() {
            let tcp = self.pose(&last.target_q);
            let missed = match &leg.geometry {
                Geometry::Joints(_, to) => (0..6)
                    .map(|k| (last.target_q[k] - to[k]).abs())
                    .fold(0.0, f64::max),
                Geometry::Line(_, to) => (tcp.translation - to.translation)
                    .norm()
                    .max(apart(&tcp.rotation, &to.rotation)),
                Geometry::Arc { .. } => 0.0,
            };
            assert!(
                missed <= MISSED,
                "{}: {missed:e} beside its end",
                self.bench.model
            );
            self.tally.missed = self.tally.missed.max(missed);
        }
        let corners: Vec<(Vector3<f64>, f64)> = self
            .legs
            .iter()
            .map(|leg| (self.pose(&leg.end).translation, leg.radius))
            .collect();
        for state in &self.bench.states[self.since.min(self.bench.states.len())..] {
            if self.legs.is_empty() {
                break;
            }
            let tcp = self.pose(&state.target_q);
            let beside = self
                .legs
                .iter()
                .map(|leg| leg.geometry.beside(&state.target_q, &tcp))
                .fold(f64::INFINITY, f64::min);
            let is_blending = corners
                .iter()
                .any(|(corner, radius)| (tcp.translation - corner).norm() <= radius + MISSED);
            assert!(
                beside <= BESIDE || is_blending,
                "{} cycle {}: {beside:e} beside its path",
                self.bench.model,
                state.cycle
            );
            if !is_blending {
                self.tally.beside = self.tally.beside.max(beside);
            }
        }
        self.look_at_blends();
        self.legs.clear();
        self.since = self.bench.states.len();
    }

    /// Where the arm leaves its leg for the next one, when nothing was said against the radius.
    fn look_at_blends(&mut self) {
        for pair in self.legs.windows(2) {
            let (leg, next) = (&pair[0], &pair[1]);
            let warned = |id| {
                let warnings = self.bench.warnings.iter();
                warnings
                    .filter(move |(warned, _)| *warned == id)
                    .any(|(_, warning)| {
                        matches!(
                            warning,
                            Warning::RadiusShortened { .. } | Warning::NotBlended
                        )
                    })
            };
            let is_disturbed = leg.is_disturbed || next.is_disturbed;
            if warned(leg.id) || warned(next.id) || is_disturbed || leg.radius == 0.0 {
                continue;
            }
            let corner = self.pose(&leg.end).translation;
            let away = |q: &JointPositions| (self.pose(q).translation - corner).norm();
            let states = &self.bench.states[self.since..];
            let is_on = |q: &JointPositions| leg.geometry.beside(q, &self.pose(q)) < MISSED;
            let Some(left) = states.iter().rposition(|s| is_on(&s.target_q)) else {
                continue;
            };
            // A tool that only turns leaves by its turning.
            if away(&states[0].target_q) < leg.radius {
                continue;
            }
            let share = away(&states[left].target_q) / leg.radius;
            self.tally.blends += 1;
            if share < 0.6 {
                self.tally.late += 1;
                println!("a blend begins at {share:.3} of {:.4} m", leg.radius);
            }
        }
    }

    /// A movej against an independent planner of the leading joint.
    fn compare_duration(&mut self, kind: &CommandKind, from: &JointPositions, seconds: f64) {
        let CommandKind::MoveJ {
            target,
            acceleration,
            speed,
            duration,
            ..
        } = *kind
        else {
            return;
        };
        if duration > 0.0 {
            return;
        }
        let way = (0..6)
            .map(|k| (target[k] - from[k]).abs())
            .fold(0.0, f64::max);
        let jerk = acceleration / motion::constants::ACCELERATION_RISE;
        let step = self.bench.cycle.step_time();
        writeln!(
            self.csv,
            "{way:.17},{speed:.17},{acceleration:.17},{jerk:.17},{step},{seconds:.6}"
        )
        .unwrap();
        let optimal = optimal_duration(way, speed, acceleration, jerk);
        let over = seconds - optimal;
        assert!(
            over <= 0.001 * optimal + step + 1e-9,
            "{seconds} s instead of {optimal} s for {way} rad at {speed}, {acceleration}"
        );
        self.tally.slower = self.tally.slower.max(over / step);
    }
}

/// Duration of the time-optimal motion by rsruckig, s.
fn optimal_duration(way: f64, speed: f64, acceleration: f64, jerk: f64) -> f64 {
    use rsruckig::prelude::*;
    let mut input = InputParameter::<1>::new(None);
    input.max_velocity[0] = speed;
    input.max_acceleration[0] = acceleration;
    input.max_jerk[0] = jerk;
    input.target_position[0] = way;
    let mut planner = Ruckig::<1, ThrowErrorHandler>::new(None, 0.001);
    let mut trajectory = Trajectory::new(None);
    planner.calculate(&input, &mut trajectory).unwrap();
    trajectory.get_duration()
}

/// Centre and normal of the circle through three points.
fn circle(a: Vector3<f64>, b: Vector3<f64>, c: Vector3<f64>) -> (Vector3<f64>, Vector3<f64>) {
    let (u, v) = (b - a, c - a);
    let normal = u.cross(&v);
    let centre = (u.norm_squared() * v.cross(&normal) - v.norm_squared() * u.cross(&normal))
        / (2.0 * normal.norm_squared());
    (a + centre, normal.normalize())
}

/// A few statements of a program.
fn statement(run: &mut Run, dice: &mut Dice) {
    let corner = run.corner();
    let radius = if dice.one_in(2) {
        dice.within(0.002, 0.08)
    } else {
        0.0
    };
    let duration = if dice.one_in(8) {
        dice.within(0.05, 3.0)
    } else {
        0.0
    };
    match dice.next() % 10 {
        0..=3 => {
            let by = dice.six(0.9);
            let home = run.bench.states[0].target_q;
            let target = JointPositions(core::array::from_fn(|k| {
                if dice.one_in(4) {
                    corner[k]
                } else {
                    home[k] + by[k]
                }
            }));
            let kind = CommandKind::MoveJ {
                target,
                acceleration: dice.within(0.3, 8.0),
                speed: dice.within(0.1, 2.5),
                duration,
                radius,
            };
            run.move_along(dice, kind);
        }
        4..=6 => {
            let target = near(run, dice, &corner, 0.3, 0.8);
            let kind = CommandKind::MoveL {
                target,
                acceleration: dice.within(0.1, 5.0),
                speed: dice.within(0.02, 1.5),
                duration,
                radius,
            };
            run.move_along(dice, kind);
        }
        7 => {
            let via = near(run, dice, &corner, 0.15, 0.0);
            let target = near(run, dice, &corner, 0.2, 0.4);
            let kind = CommandKind::MoveC {
                via,
                target,
                acceleration: dice.within(0.1, 3.0),
                speed: dice.within(0.02, 0.6),
                radius,
                fixed: dice.one_in(2),
            };
            // Where an arc ends that carries its tool along is not written in the command.
            if dice.one_in(2) {
                run.stand();
            }
            run.arc_alone(dice, kind);
        }
        _ => {
            run.stand();
            stream(run, dice);
        }
    }
}

impl Run {
    /// An arc on its own: the tool of a fixed one ends where the arc takes it.
    fn arc_alone(&mut self, dice: &mut Dice, mut kind: CommandKind) {
        self.stand();
        if let CommandKind::MoveC { radius, .. } = &mut kind {
            *radius = 0.0;
        }
        self.move_along(dice, kind);
    }
}

/// A pose beside that of the joints.
fn near(run: &Run, dice: &mut Dice, q: &JointPositions, way: f64, turn: f64) -> RpyPose {
    let pose = run.pose(q);
    let [x, y, z, a, b, c] = dice.six(1.0);
    let turned = Rotation3::new(Vector3::new(a, b, c) * turn) * pose.rotation;
    Pose::new(turned, pose.translation + Vector3::new(x, y, z) * way).to_rpy()
}

/// A stream of an online mode until the arm stands again.
fn stream(run: &mut Run, dice: &mut Dice) {
    let bench = &mut run.bench;
    for _ in 0..3 {
        match dice.next() % 3 {
            0 => {
                let mut goal = bench.now().target_q;
                let by = dice.six(0.004);
                for _ in 0..60 {
                    (0..6).for_each(|k| goal[k] += by[k]);
                    let step = bench.cycle.step_time();
                    bench.do_it(CommandKind::ServoJ {
                        target: goal,
                        duration: step,
                        lookahead: dice.within(0.03, 0.2),
                        gain: dice.within(100.0, 2000.0),
                    });
                }
            }
            1 => {
                bench.do_it(CommandKind::SpeedJ {
                    speeds: JointSpeeds(dice.six(1.0)),
                    acceleration: dice.within(0.2, 10.0),
                    duration: Some(dice.within(0.05, 0.5)),
                });
            }
            _ => {
                let acceleration = dice.within(0.2, 5.0);
                bench.do_it(CommandKind::SpeedL {
                    speed: dice.six(0.3),
                    acceleration,
                    rotation_acceleration: acceleration,
                    duration: Some(dice.within(0.05, 0.5)),
                });
            }
        }
    }
    bench.do_it(CommandKind::StopJ { acceleration: 4.0 });
    run.since = run.bench.states.len();
}

fn programs() -> u64 {
    let asked = std::env::var("ELITE_PROGRAMS");
    asked.ok().and_then(|n| n.parse().ok()).unwrap_or(6)
}

#[test]
fn random_programs_keep_every_limit_and_their_paths_in_every_cycle() {
    let mut csv = String::new();
    for (number, name) in MODELS.into_iter().enumerate() {
        let mut all = Tally::default();
        for seed in 0..programs() {
            let mut dice = Dice(seed << 8 | number as u64);
            let step = [0.002, 0.004, 0.004, 0.008][(dice.next() % 4) as usize];
            let mut run = Run::new(name, step);
            for _ in 0..dice.within(3.0, 9.0) as usize {
                statement(&mut run, &mut dice);
            }
            run.stand();
            let bench = &run.bench;
            assert!(bench.stops.is_empty(), "{name} {seed}: {:?}", bench.stops);
            bench.check_limits();
            for (_, warning) in &bench.warnings {
                if let Warning::RadiusShortened { wanted, planned } = warning {
                    assert!(planned < wanted, "{planned} {wanted}");
                }
            }
            csv.push_str(&run.csv);
            let one = run.tally;
            all.cycles += bench.states.len();
            all.motions += one.motions;
            all.refused += one.refused;
            all.beside = all.beside.max(one.beside);
            all.missed = all.missed.max(one.missed);
            all.slower = all.slower.max(one.slower);
            all.blends += one.blends;
            all.late += one.late;
        }
        println!(
            "{name}: {} programs, {} motions ({} refused), {} cycles, beside the path {:.1e}, beside the end {:.1e}, {:.3} cycles slower than optimal, {} blends, {} of them late",
            programs(),
            all.motions,
            all.refused,
            all.cycles,
            all.beside,
            all.missed,
            all.slower,
            all.blends,
            all.late
        );
    }
    if let Ok(path) = std::env::var("ELITE_MOVEJ_CSV") {
        std::fs::write(path, csv).unwrap();
    }
}
