//! Where blends begin, over random corners: inside the radius, and at the latest at 0.6 of it, whatever meets whatever.
//!
//! A few corners an arm run here; `ELITE_CASES=1000` runs that many.
#![allow(missing_docs, reason = "a test of its own")]
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;
use crate::way;

use common::draw::{Draw, fold};
use common::{Bench, MODELS, ideal};
use kinematics::rotation::rotvec_from_rotation;
use kinematics::{JointPositions, Pose, RobotModel, RpyPose};
use motion_api::{CommandKind, MotionCommand, Outcome, RobotState, Warning};
use nalgebra::Vector3;
use way::Way;

/// A way that has been left is off by more than this, m and rad.
const OFF: f64 = 1e-8;
/// Where the tool hardly moves, a radian of turning counts as this much way, m.
const ROTATION_LENGTH: f64 = 0.25;
/// At this share of the radius at the latest a blend has begun.
const LATEST: f64 = 0.6;
/// The same where the arm enters its zone at full speed because it does not know what follows.
const LATEST_AT_SPEED: f64 = 0.15;

/// A leg that bears less than this share of its speed passes a nearly singular position.
const SINGULAR: f64 = 0.35;
/// How long the arm is watched after it has entered the zone, and how long until then at most, s.
const SEEN: f64 = 2.0;
const PATIENCE: f64 = 20.0;

/// Two motions that meet at an angle, the first with a radius.
#[derive(Clone, Debug)]
struct Corner {
    model: &'static str,
    step_time: f64,
    start: JointPositions,
    tcp: RpyPose,
    first: CommandKind,
    second: CommandKind,
    radius: f64,
}

impl Corner {
    fn draw(model: &'static str, seed: u64) -> Self {
        let mut draw = Draw::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ fold(model));
        let arm = RobotModel::built_in(model).unwrap();
        let tcp = RpyPose::from_array(std::array::from_fn(|k| match k {
            0..=2 => draw.between(-0.1, 0.1),
            _ => draw.between(-1.0, 1.0),
        }));
        let flange_from_tcp = Pose::from_rpy(&tcp);
        let middle = [0.0, -1.5, 1.7, -1.7, -1.5, 0.0];
        let start = JointPositions(middle.map(|usual| usual + draw.between(-0.8, 0.8)));
        let radius = draw.spread(0.003, 0.1);
        let (a, first) = Self::leg(&mut draw, &arm, &flange_from_tcp, &start, radius);
        let (_, second) = Self::leg(&mut draw, &arm, &flange_from_tcp, &a, 0.0);
        Self {
            model,
            step_time: *draw.pick(&[0.001, 0.002, 0.004, 0.004, 0.008]),
            start,
            tcp,
            first,
            second,
            radius,
        }
    }

    fn leg(
        draw: &mut Draw,
        arm: &RobotModel,
        tcp: &Pose,
        from: &JointPositions,
        radius: f64,
    ) -> (JointPositions, CommandKind) {
        let spread = draw.spread(0.05, 0.8);
        let to = JointPositions(from.0.map(|q| q + draw.between(-spread, spread)));
        let (begin, end) = (arm.tcp_pose(from, tcp), arm.tcp_pose(&to, tcp));
        let kind = match draw.whole(0, 3) {
            0 => CommandKind::Motion(MotionCommand::MoveJ {
                target: to,
                acceleration: draw.spread(0.3, 20.0),
                speed: draw.spread(0.1, 6.0),
                duration: 0.0,
                radius,
            }),
            1 | 2 => CommandKind::Motion(MotionCommand::MoveL {
                target: end.to_rpy(),
                acceleration: draw.spread(0.2, 10.0),
                speed: draw.spread(0.05, 2.0),
                duration: 0.0,
                radius,
            }),
            _ => {
                let chord = end.translation - begin.translation;
                let side = Vector3::from_fn(|_, _| draw.between(-1.0, 1.0)).cross(&chord);
                let height = chord.norm() * draw.between(0.05, 0.6) / side.norm();
                let along = draw.between(0.3, 0.7);
                CommandKind::Motion(MotionCommand::MoveC {
                    via: RpyPose {
                        xyz: (begin.translation + chord * along + side * height).into(),
                        rpy: [0.0; 3],
                    },
                    target: end.to_rpy(),
                    acceleration: draw.spread(0.2, 10.0),
                    speed: draw.spread(0.05, 1.5),
                    radius,
                    fixed: draw.chance(0.4),
                })
            }
        };
        (to, kind)
    }

    fn run(&self, sent: Sent) -> Found {
        let mut bench = Bench::new(motion::CycleConfig {
            step_time: self.step_time,
            home: self.start,
            tcp: self.tcp,
            ..ideal(self.model)
        });
        let tcp = Pose::from_rpy(&self.tcp);
        let arm = RobotModel::built_in(self.model).unwrap();
        let from = arm.tcp_pose(&self.start, &tcp);
        let first = bench.send(self.first);
        let is_awaited = |bench: &Bench| match sent {
            Sent::Early => bench.queued.contains(&first),
            Sent::WhenDue => bench.due.contains(&first),
        };
        while bench.outcome(first).is_none() && !is_awaited(&bench) && bench.now().time < PATIENCE {
            bench.tick();
        }
        let begun = bench.outcome(first);
        if !matches!(begun, None | Some(Outcome::Done)) || bench.cycle.is_standing() {
            return Found::NoBlend;
        }
        let second = bench.send(self.second);
        // Long enough to see where the way is left.
        let begun = bench.now().time;
        while bench.outcome(second).is_none() && bench.now().time < begun + SEEN {
            bench.tick();
        }
        if matches!(bench.outcome(second), Some(Outcome::Refused(_))) {
            return Found::NoBlend;
        }
        assert!(bench.stops.is_empty(), "{self:?} {:?}", bench.stops);
        let mut radius = self.radius;
        for (id, warning) in &bench.warnings {
            match warning {
                Warning::NotBlended => return Found::Stopped,
                Warning::RadiusShortened { planned, .. } if *id == first => radius = *planned,
                _ => {}
            }
        }
        let Some(way) = Way::of(&self.first, &self.start, from) else {
            return Found::NoBlend;
        };
        let corner = way.end(&arm, &tcp);
        let corner_q = way.end_q(&arm, &tcp, &self.start).unwrap();
        // The middle of the way tells how the radius is measured.
        let middle = match &way {
            Way::Joint { from, to } => {
                let half = JointPositions(std::array::from_fn(|j| (from[j] + to[j]) / 2.0));
                arm.tcp_pose(&half, &tcp)
            }
            Way::Tcp { .. } => way.pose(0.5),
        };
        let counts_turning = (middle.translation - corner.translation).norm() < 0.1 * self.radius;
        let distance = |state: &RobotState| {
            let pose = arm.tcp_pose(&state.target_q, &tcp);
            let away = (pose.translation - corner.translation).norm();
            let turned = match &way {
                Way::Joint { .. } => (0..6).fold(0.0, |most: f64, j| {
                    most.max((state.target_q[j] - corner_q[j]).abs())
                }),
                Way::Tcp { .. } => {
                    rotvec_from_rotation(&(corner.rotation * pose.rotation.inverse())).norm()
                }
            };
            if counts_turning {
                away.max(ROTATION_LENGTH * turned)
            } else {
                away
            }
        };
        let mut last = None;
        for state in &bench.states {
            let pose = arm.tcp_pose(&state.target_q, &tcp);
            if way.deviation(&state.target_q, &pose) > OFF {
                break;
            }
            last = Some(distance(state) / radius);
        }
        // A leg through nearly singular positions bears a small part of the speed that was asked for.
        let is_singular = bench.warnings.iter().any(|(_, warning)| {
            matches!(warning, Warning::SpeedLimited { wanted, planned, .. } if *planned < SINGULAR * wanted)
        });
        Found::Left {
            share: last.unwrap(),
            is_singular,
        }
    }
}

/// When the second motion is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sent {
    /// When it may be, as a program does that only computes between the two.
    Early,
    /// When it is due, or the zone is entered: there are statements between the two.
    WhenDue,
}

/// What became of a corner.
#[derive(Clone, Copy, Debug)]
enum Found {
    /// A motion was refused, or the first had no zone.
    NoBlend,
    /// The arm stopped at the waypoint, and said so.
    Stopped,
    /// At which share of the radius the arm was last on the first way.
    Left { share: f64, is_singular: bool },
}

/// How many corners an arm; `ELITE_CASES` asks for more.
fn cases() -> u64 {
    let asked = std::env::var("ELITE_CASES");
    asked.ok().and_then(|n| n.parse().ok()).unwrap_or(24)
}

/// How many blends there are, and which begin late.
#[derive(Debug, Default)]
struct Tally {
    blends: usize,
    stopped: Vec<(&'static str, u64)>,
    late: Vec<(&'static str, u64, f64)>,
    late_beside_singular: usize,
}

fn tally(sent: Sent, latest: f64) -> Tally {
    let mut tally = Tally::default();
    for model in MODELS {
        for seed in 0..cases() {
            match Corner::draw(model, seed).run(sent) {
                Found::NoBlend => {}
                Found::Stopped => tally.stopped.push((model, seed)),
                Found::Left { share, is_singular } => {
                    tally.blends += 1;
                    if share < latest && is_singular {
                        tally.late_beside_singular += 1;
                    } else if share < latest {
                        tally.late.push((model, seed, share));
                    }
                }
            }
        }
    }
    println!("{sent:?} {tally:?}");
    tally
}

#[test]
fn every_blend_begins_at_the_latest_at_six_tenths_of_its_radius() {
    let found = tally(Sent::Early, LATEST);
    assert!(found.late.is_empty(), "{:?}", found.late);
    // Where a leg crawls the arm may have to slow down first, or stop.
    assert!(100 * (found.late_beside_singular + found.stopped.len()) <= 3 * found.blends);
}

#[test]
fn motions_that_are_sent_when_they_are_due_blend_all_the_same() {
    let found = tally(Sent::WhenDue, LATEST_AT_SPEED);
    assert!(found.late.is_empty(), "{:?}", found.late);
    assert!(100 * (found.late_beside_singular + found.stopped.len()) <= 5 * found.blends);
}
