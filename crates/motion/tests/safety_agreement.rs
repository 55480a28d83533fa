//! What `is_within_safety_limits` says and what motion then accepts are the same, and an accepted motion whose whole
//! way is allowed is never stopped, however fast it goes and however near to a plane it passes.
//!
//! A few targets an arm run here; `ELITE_CASES=1000` runs that many.
#![allow(missing_docs, reason = "a test of its own")]
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot go on should say where"
)]

use crate::common;
use crate::way;

use common::draw::{Draw, fold};
use common::{Bench, MODELS, ideal};
use kinematics::rotation::rotation_from_rotvec;
use kinematics::safety::{PlaneMode, PlaneSwitches, SafetyPlane, SafetyTool};
use kinematics::{JointPositions, Pose, RobotModel, RpyPose, SafetyBounds};
use motion::CycleConfig;
use motion_api::{CommandKind, MotionCommand, Outcome, Refusal};
use nalgebra::Vector3;
use way::Way;

/// Places of a way that are looked at.
const PLACES: usize = 100;

struct Case {
    config: CycleConfig,
    model: RobotModel,
    tcp: Pose,
    kind: CommandKind,
    expected: bool,
}

#[derive(Debug, Default)]
struct Tally {
    allowed: usize,
    refused: usize,
    /// Allowed at both ends, not in between.
    crossing: usize,
    /// Refused for their way: through a singular position, or past the end of a range.
    impossible: usize,
}

fn shape(draw: &mut Draw) -> Option<SafetyTool> {
    let at = Pose::from_translation(
        draw.between(-0.1, 0.1),
        draw.between(-0.1, 0.1),
        draw.between(0.0, 0.2),
    );
    let mut size = || draw.between(0.01, 0.15);
    let (a, b, c) = (size(), size(), size());
    match draw.whole(0, 3) {
        0 => None,
        1 => Some(SafetyTool::ball(at, a).unwrap()),
        2 => Some(SafetyTool::cuboid(at, [a, b, c]).unwrap()),
        _ => Some(SafetyTool::cylinder(at, a, b).unwrap()),
    }
}

impl Case {
    /// `None` where the arm would begin behind a plane.
    fn draw(name: &str, seed: u64) -> Option<Self> {
        let mut draw = Draw::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ fold(name));
        let mut config = ideal(name);
        let middle = [0.0, -1.5, 1.7, -1.7, -1.5, 0.0];
        config.home = JointPositions(middle.map(|usual| usual + draw.between(-0.6, 0.6)));
        config.step_time = *draw.pick(&[0.002, 0.004, 0.008]);
        config.tcp = RpyPose::from_array(std::array::from_fn(|k| match k {
            0..=2 => draw.between(-0.1, 0.15),
            _ => draw.between(-1.0, 1.0),
        }));
        let home = config.home;
        if draw.chance(0.5) {
            let own = *config.model.limits();
            let mut near =
                |sign: f64| JointPositions(home.0.map(|q| q + sign * draw.spread(0.005, 3.0)));
            let (low, high) = (near(-1.0), near(1.0));
            let low = JointPositions(std::array::from_fn(|j| low[j].max(own.position_min[j])));
            let high = JointPositions(std::array::from_fn(|j| high[j].min(own.position_max[j])));
            config.limits.joint_position_min = Some(low);
            config.limits.joint_position_max = Some(high);
        }
        let model = config.limited_model().unwrap();
        let tcp = Pose::from_rpy(&config.tcp);
        let start = model.tcp_pose(&home, &tcp);
        let tool = shape(&mut draw);
        let mut bounds = SafetyBounds::default()
            .with_tool(tool)
            .with_restricted_elbow(draw.chance(0.4));
        // Along a plane at a tenth of a millimetre, where leaving the path is crossing it.
        let mut along = None;
        if draw.chance(0.3) {
            let normal = Vector3::from_fn(|_, _| draw.between(-1.0, 1.0)).normalize();
            let reach = draw.spread(1e-6, 1e-3);
            let point = start.translation - normal * reach;
            let plane = SafetyPlane::new(point.into(), normal.into(), PlaneMode::Normal, None);
            bounds = bounds.with_tool(None).with_plane(plane.unwrap()).unwrap();
            along = Some(normal);
        }
        for _ in 0..draw.whole(0, 3) {
            let normal = Vector3::from_fn(|_, _| draw.between(-1.0, 1.0)).normalize();
            let reach = draw.spread(0.001, 0.3);
            let point = start.translation - normal * reach;
            let plane = SafetyPlane::new(point.into(), normal.into(), PlaneMode::Normal, None);
            bounds = bounds.with_plane(plane.unwrap()).unwrap();
        }
        config.safety = bounds.clone();
        let switches = PlaneSwitches::default();
        if bounds
            .violation_at(&model, &home, &tcp, &switches)
            .is_some()
        {
            return None;
        }
        let (acceleration, speed) = (draw.spread(0.3, 20.0), draw.spread(0.05, 4.0));
        let (kind, expected) = if draw.chance(0.5) {
            let spread = draw.spread(0.005, 0.3);
            let target = JointPositions(home.0.map(|q| q + draw.between(-spread, spread)));
            let kind = CommandKind::Motion(MotionCommand::MoveJ {
                target,
                acceleration,
                speed,
                duration: 0.0,
                radius: 0.0,
            });
            (kind, bounds.violation_at(&model, &target, &tcp, &switches))
        } else {
            let spread = draw.spread(0.002, 0.25);
            let mut vector = |most: f64| Vector3::from_fn(|_, _| draw.between(-most, most));
            let (mut by, turn) = (vector(spread), vector(2.0 * spread));
            if let Some(normal) = along {
                by -= normal * by.dot(&normal);
            }
            let target = Pose::new(
                rotation_from_rotvec(turn) * start.rotation,
                start.translation + by,
            );
            let kind = CommandKind::Motion(MotionCommand::MoveL {
                target: target.to_rpy(),
                acceleration,
                speed,
                duration: 0.0,
                radius: 0.0,
            });
            let violation = bounds.violation_at_pose(&model, &target, &tcp, &home, &switches);
            (kind, violation)
        };
        Some(Self {
            config,
            model,
            tcp,
            kind,
            expected: expected.is_none(),
        })
    }

    /// Whether every place of the way is allowed.
    fn is_way_allowed(&self) -> bool {
        let home = self.config.home;
        let way = Way::of(&self.kind, &home, self.model.tcp_pose(&home, &self.tcp)).unwrap();
        let mut q = home;
        (1..=PLACES).all(|place| {
            let share = place as f64 / PLACES as f64;
            q = match &way {
                Way::Joint { from, to } => {
                    JointPositions(std::array::from_fn(|j| from[j] + (to[j] - from[j]) * share))
                }
                Way::Tcp { .. } => {
                    let pose = way.pose(share);
                    let Some(q) = self.model.inverse_nearest(&pose, &self.tcp, &q) else {
                        return false;
                    };
                    q
                }
            };
            let switches = PlaneSwitches::default();
            let bounds = &self.config.safety;
            bounds
                .violation_at(&self.model, &q, &self.tcp, &switches)
                .is_none()
        })
    }

    fn run(&self, tally: &mut Tally) -> Result<(), String> {
        let mut bench = Bench::new(self.config.clone());
        let outcome = bench.do_it(self.kind);
        let refused = matches!(outcome, Outcome::Refused(_));
        if !self.expected {
            tally.refused += 1;
            return if refused {
                Ok(())
            } else {
                Err(format!("not within the limits, but {outcome:?}"))
            };
        }
        let is_way_allowed = self.is_way_allowed();
        match outcome {
            Outcome::Done => tally.allowed += 1,
            // What lies in between is not asked.
            Outcome::Refused(Refusal::Path { .. }) => tally.impossible += 1,
            Outcome::ProtectiveStop(_) if !is_way_allowed => tally.crossing += 1,
            _ => return Err(format!("within the limits, but {outcome:?}")),
        }
        bench.run(300);
        let switches = PlaneSwitches::default();
        for state in &bench.states {
            let bounds = &self.config.safety;
            let violation = bounds.violation_at(&self.model, &state.target_q, &self.tcp, &switches);
            if let Some(violation) = violation {
                return Err(format!("in cycle {}: {violation}", state.cycle));
            }
        }
        Ok(())
    }
}

/// How many targets an arm; `ELITE_CASES` asks for more.
fn cases() -> u64 {
    let asked = std::env::var("ELITE_CASES");
    asked.ok().and_then(|n| n.parse().ok()).unwrap_or(60)
}

#[test]
fn what_is_within_the_safety_limits_is_accepted_and_never_stopped() {
    let mut tally = Tally::default();
    let mut wrong = Vec::new();
    for model in MODELS {
        for seed in 0..cases() {
            let Some(case) = Case::draw(model, seed) else {
                continue;
            };
            if let Err(text) = case.run(&mut tally) {
                wrong.push(format!("{model} {seed}: {text} {:?}", case.kind));
            }
        }
    }
    println!("{tally:?}");
    assert!(
        wrong.is_empty(),
        "{} wrong:\n{}",
        wrong.len(),
        wrong.join("\n")
    );
    assert!(tally.allowed > 50 && tally.refused > 50, "{tally:?}");
    assert!(5 * tally.impossible < tally.allowed, "{tally:?}");
}

#[test]
fn an_arc_that_bulges_through_a_plane_stops_on_it_before_the_plane() {
    for model in MODELS {
        for bulge in [1e-4, 2e-3, 0.02] {
            let mut config = ideal(model);
            let home = config.home;
            let start = config.model.tcp_pose(&home, &Pose::IDENTITY);
            let radius = 0.1;
            // Turned about z at the centre of the arc: at right angles to its start it is farthest out.
            let at = |angle: f64| {
                let (sine, cosine) = angle.sin_cos();
                let by = Vector3::new(radius * sine, 0.0, radius * (cosine - 1.0));
                Pose::new(start.rotation, start.translation + by).to_rpy()
            };
            let highest = start.translation.z - bulge;
            let plane = SafetyPlane::new(
                [0.0, 0.0, highest],
                [0.0, 0.0, -1.0],
                PlaneMode::Normal,
                None,
            );
            config.safety = SafetyBounds::default().with_plane(plane.unwrap()).unwrap();
            let mut bench = Bench::new(config);
            // From behind the plane back before it is allowed.
            let begin = CommandKind::Motion(MotionCommand::MoveL {
                target: at(-1.2),
                acceleration: 1.2,
                speed: 0.25,
                duration: 0.0,
                radius: 0.0,
            });
            assert_eq!(bench.do_it(begin), Outcome::Done, "{model} {bulge}");
            let first = bench.states.len();
            let outcome = bench.do_it(MotionCommand::MoveC {
                via: at(-0.8),
                target: at(1.2),
                acceleration: 10.0,
                speed: 1.0,
                radius: 0.0,
                fixed: false,
            });
            assert!(
                matches!(outcome, Outcome::ProtectiveStop(_)),
                "{model} {bulge}: {outcome:?}"
            );
            bench.run(300);
            bench.check_limits();
            assert!(bench.cycle.is_standing() && bench.stops.len() == 1);
            let centre = start.translation.z - radius;
            for state in &bench.states[first..] {
                let [x, _, z] = state.target_tcp_pose.xyz;
                assert!(z <= highest, "{model} {bulge}: {z} over {highest}");
                // On the arc unless the joints could brake faster beside it.
                let off = (x - start.translation.x).hypot(z - centre) - radius;
                assert!(off.abs() < 0.01, "{model} {bulge}: {off}");
            }
        }
    }
}
