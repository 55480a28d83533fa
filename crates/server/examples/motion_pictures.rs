//! The pictures of `docs/motion.md`: what the arm is told, cycle by cycle, in three situations.
//!
//! `cargo run -p server --example motion_pictures [FOLDER]` writes them into `docs/motion` or FOLDER. The controller is
//! driven directly, cycle by cycle with the ideal plant, so the curves are the targets and the same on every machine.

#![allow(
    clippy::unwrap_used,
    reason = "a picture that cannot be made says where"
)]
#![allow(clippy::approx_constant, reason = "joint angles as people type them")]

use std::path::{Path, PathBuf};

use kinematics::{JointPositions, Pose, RobotModel, RpyPose};
use motion::{ControlLoop, CycleConfig, CycleTiming, MotionLimits, PlantKind};
use motion_api::{
    CommandKind, Event, MotionCommand, Origin, Outcome, RingCapacities, RobotState, ScriptEndpoint,
    motion_channel,
};
use server::plot::{Circle, Curve, CurveStyle, Figure, Marks, PlotPanel};

fn main() {
    let folder = std::env::args().nth(1).map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/motion"),
        PathBuf::from,
    );
    std::fs::create_dir_all(&folder).unwrap();
    for (name, figure) in [
        ("movej", movej()),
        ("blend", blend()),
        ("singularity", singularity()),
    ] {
        figure.save(&folder.join(format!("{name}.png"))).unwrap();
    }
}

/// An arm, and all it was told so far.
struct Stage {
    cycle: ControlLoop,
    script: ScriptEndpoint,
    states: Vec<RobotState>,
    limits: MotionLimits,
    /// Cycles in which commands ended.
    ended: Vec<u64>,
}

impl Stage {
    fn new(home: [f64; 6], step_time: f64) -> Self {
        let config = CycleConfig {
            plant: PlantKind::Ideal,
            home: JointPositions(home),
            step_time,
            ..CycleConfig::new(RobotModel::built_in("cs66").unwrap())
        };
        let (motion, script) = motion_channel(RingCapacities::default(), &config.first_state());
        Self {
            limits: config.resolve().unwrap(),
            states: vec![config.first_state()],
            cycle: ControlLoop::new(config, motion).unwrap(),
            script,
            ended: Vec::new(),
        }
    }

    /// One command after the other, each when the one before has ended, and then until the arm stands.
    fn perform(&mut self, kinds: &[CommandKind]) {
        for kind in kinds {
            self.script.commands.send(Origin::default(), *kind).unwrap();
            let before = self.ended.len();
            while self.ended.len() == before {
                self.tick();
            }
        }
        while !self.cycle.is_standing() {
            self.tick();
        }
    }

    fn tick(&mut self) {
        self.cycle.tick(CycleTiming::default());
        while let Some(event) = self.script.events.next_event() {
            match event {
                Event::Ended {
                    outcome: Outcome::Done,
                    cycle,
                    ..
                } => self.ended.push(cycle),
                Event::Ended { outcome, .. } => panic!("{outcome:?}"),
                Event::Warned { warning, .. } => println!("{warning}"),
                Event::Stopped { reason, .. } => panic!("{reason}"),
                Event::ReadyForNext { .. } | Event::Due { .. } => {}
            }
        }
        self.states.push(self.script.snapshot.read());
    }

    /// A value of every state over time.
    fn over_time(&self, value: impl Fn(&RobotState) -> f64) -> Vec<(f64, f64)> {
        self.states.iter().map(|s| (s.time, value(s))).collect()
    }

    fn joints(
        &self,
        title: &str,
        unit: &str,
        value: impl Fn(&RobotState, usize) -> f64,
    ) -> PlotPanel {
        (0..6).fold(PlotPanel::over_time(title, unit), |panel, joint| {
            let points = self.over_time(|s| value(s, joint));
            panel.curve(Curve::new(format!("J{}", joint + 1), points))
        })
    }

    fn tcp_speed(&self) -> PlotPanel {
        let speed = |s: &RobotState| {
            s.target_tcp_speed[..3]
                .iter()
                .map(|v| v * v)
                .sum::<f64>()
                .sqrt()
        };
        PlotPanel::over_time("TCP speed", "m/s").curve(Curve::new("TCP", self.over_time(speed)))
    }

    /// Joint jerks, rad/s³: differences of the accelerations of two cycles.
    fn jerk(&self) -> PlotPanel {
        let step = self.cycle.step_time();
        (0..6).fold(
            PlotPanel::over_time("Joint jerks", "rad/s³"),
            |panel, joint| {
                let points = self.states.windows(2).map(|pair| {
                    let change = pair[1].target_qdd[joint] - pair[0].target_qdd[joint];
                    (pair[1].time, change / step)
                });
                panel.curve(Curve::new(format!("J{}", joint + 1), points))
            },
        )
    }

    /// The TCP as seen from above, mm.
    fn way_from_above(&self) -> Vec<(f64, f64)> {
        let xy = |s: &RobotState| place(&s.target_tcp_pose);
        self.states.iter().map(xy).collect()
    }

    /// The TCP as seen from above, mm, every tenth of a second.
    fn tenths(&self) -> Curve {
        let every = (0.1 / self.cycle.step_time()).round() as usize;
        let points = self.way_from_above().into_iter().step_by(every);
        Curve::new("every 0.1 s", points).style(CurveStyle::Dots)
    }

    fn time_of(&self, cycle: u64) -> f64 {
        cycle as f64 * self.cycle.step_time()
    }
}

/// x and y in mm.
fn place(pose: &RpyPose) -> (f64, f64) {
    (pose.xyz[0] * 1e3, pose.xyz[1] * 1e3)
}

fn line(target: RpyPose, speed: f64, radius: f64) -> CommandKind {
    CommandKind::Motion(MotionCommand::MoveL {
        target,
        acceleration: 1.2,
        speed,
        duration: 0.0,
        radius,
    })
}

/// The default speed and acceleration of movej (manual 3.1.1).
const SPEED: f64 = 1.047_197;
const ACCELERATION: f64 = 1.396_263;

fn movej() -> Figure {
    let mut stage = Stage::new([0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0], 0.002);
    stage.perform(&[CommandKind::Motion(MotionCommand::MoveJ {
        target: JointPositions([1.6, -1.1, 1.9, -2.1, -1.2, 0.7]),
        acceleration: ACCELERATION,
        speed: SPEED,
        duration: 0.0,
        radius: 0.0,
    })]);
    let limits = [-1.0, 1.0];
    let with_levels = |panel: PlotPanel, most: f64| {
        limits.iter().fold(panel, |panel, sign| {
            panel.level(if *sign > 0.0 { "asked" } else { "" }, sign * most)
        })
    };
    Figure::new("movej: the leading joint at the asked speed and acceleration, all joints together")
        .note("CS66, movej(q) with default a and v, 2 ms")
        .panel(stage.joints("Joint positions", "rad", |s, j| s.target_q[j]))
        .panel(
            stage
                .joints("Joint speeds", "rad/s", |s, j| s.target_qd[j])
                .level("v asked", SPEED),
        )
        .panel(with_levels(
            stage.joints("Joint accelerations", "rad/s²", |s, j| s.target_qdd[j]),
            ACCELERATION,
        ))
        .panel(stage.jerk())
}

fn blend() -> Figure {
    let mut stage = Stage::new([0.3, -1.4, 1.7, -1.8, -1.5, 0.2], 0.004);
    let start = stage.states[0].target_tcp_pose;
    let at = |x: f64, y: f64| {
        let mut pose = start;
        pose.xyz[0] += x;
        pose.xyz[1] += y;
        pose
    };
    let (one, two, via, three, four) = (
        at(0.0, 0.22),
        at(-0.16, 0.22),
        at(-0.22, 0.14),
        at(-0.16, 0.06),
        at(-0.02, -0.02),
    );
    let radii = [0.06, 0.04, 0.05];
    stage.perform(&[
        line(one, 0.25, radii[0]),
        line(two, 0.25, radii[1]),
        CommandKind::Motion(MotionCommand::MoveC {
            via,
            target: three,
            acceleration: 1.2,
            speed: 0.25,
            radius: radii[2],
            fixed: false,
        }),
        line(four, 0.15, 0.0),
    ]);
    let corners = [one, two, three];
    let zones = corners.iter().zip(radii).fold(
        PlotPanel::plane("The TCP from above", "x in mm", "y in mm")
            .curve(Curve::new("TCP", stage.way_from_above())),
        |panel, (corner, radius)| {
            panel.circle(Circle {
                center: place(corner),
                radius: radius * 1e3,
                name: format!("r = {:.0} mm", radius * 1e3),
            })
        },
    );
    let points = [start, one, two, via, three, four];
    let plan = arc_points(&two, &via, &three);
    let asked = [place(&start), place(&one), place(&two)]
        .into_iter()
        .chain(plan)
        .chain([place(&three), place(&four)]);
    let zones = zones
        .curve(
            Curve::new("legs", asked)
                .style(CurveStyle::Dashed)
                .color_of(6),
        )
        .curve(Curve::new("points", points.iter().map(place)).style(CurveStyle::Dots));
    let entered = stage.ended[..3]
        .iter()
        .fold(Marks::dashed("in zone"), |marks, cycle| {
            marks.at(stage.time_of(*cycle), "next command")
        });
    Figure::new("Blends: inside the radius, without a stop, no faster than the neighbours")
        .note("CS66, movel, movel, movec, movel, 4 ms")
        .panel(
            stage
                .tcp_speed()
                .level("v of the first three", 0.25)
                .level("v of the last", 0.15),
        )
        .panel(stage.joints("Joint speeds", "rad/s", |s, j| s.target_qd[j]))
        .panel(stage.joints("Joint accelerations", "rad/s²", |s, j| s.target_qdd[j]))
        .panel(zones)
        .marks(entered)
}

/// Places on the arc from `start` through `via` to `end`, from above.
fn arc_points(start: &RpyPose, via: &RpyPose, end: &RpyPose) -> Vec<(f64, f64)> {
    let ((ax, ay), (bx, by), (cx, cy)) = (place(start), place(via), place(end));
    let d = 2.0 * (ax * (by - cy) + bx * (cy - ay) + cx * (ay - by));
    let (a, b, c) = (ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy);
    let x = (a * (by - cy) + b * (cy - ay) + c * (ay - by)) / d;
    let y = (a * (cx - bx) + b * (ax - cx) + c * (bx - ax)) / d;
    let radius = (ax - x).hypot(ay - y);
    let from = (ay - y).atan2(ax - x);
    // Counter-clockwise when the three turn left.
    let turn = core::f64::consts::TAU;
    let angle = ((cy - y).atan2(cx - x) - from).rem_euclid(turn);
    let angle = if d > 0.0 { angle } else { angle - turn };
    (0..=60)
        .map(|i| from + angle * f64::from(i) / 60.0)
        .map(|at| (x + radius * at.cos(), y + radius * at.sin()))
        .collect()
}

fn singularity() -> Figure {
    let model = RobotModel::built_in("cs66").unwrap();
    let down = RpyPose::from_array([0.16, 0.35, 0.3, core::f64::consts::PI, 0.0, 0.0]);
    let near = JointPositions([1.0, -1.9, 2.2, -1.87, -1.5708, 0.0]);
    let home = model
        .inverse_nearest(&Pose::from_rpy(&down), &Pose::IDENTITY, &near)
        .unwrap();
    let mut stage = Stage::new(home.0, 0.004);
    let mut target = stage.states[0].target_tcp_pose;
    target.xyz[1] -= 0.7;
    let wanted = 0.5;
    stage.perform(&[line(target, wanted, 0.0)]);
    let speeds = stage
        .joints("Joint speeds", "rad/s", |s, j| s.target_qd[j])
        .level("limit of J1", stage.limits.speed[0])
        .level("", -stage.limits.speed[0]);
    let accelerations = stage
        .joints("Joint accelerations", "rad/s²", |s, j| s.target_qdd[j])
        .level("limit", stage.limits.acceleration[0])
        .level("", -stage.limits.acceleration[0]);
    let path = PlotPanel::plane("The TCP from above", "x in mm", "y in mm")
        .curve(Curve::new("TCP", stage.way_from_above()))
        .curve(stage.tenths())
        .circle(Circle {
            center: (0.0, 0.0),
            radius: 8.0,
            name: "axis of the base".to_owned(),
        });
    Figure::new("A line past the axis of the base: it slows down and is kept")
        .note("CS66, movel with v = 0.5 m/s, 4 ms")
        .panel(stage.tcp_speed().level("asked", wanted))
        .panel(speeds)
        .panel(accelerations)
        .panel(path)
}
