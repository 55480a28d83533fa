//! The pictures of docs/motion: `cargo run -p server --example motion_pictures [FOLDER]`.
//!
//! Each runs commands on a control cycle with the ideal plant and draws what was recorded.

use std::error::Error;
use std::path::{Path, PathBuf};

use kinematics::{JointPositions, Pose, RobotModel, RpyPose};
use motion::{Cycle, CycleConfig, PlantKind, Timing};
use motion_api::{BorderSizes, CommandKind, Event, Origin, Outcome, RobotState, ScriptEnd, border};
use nalgebra::Vector3;
use server::plot::{Circle, Curve, CurveStyle, Figure, Marks, Panel};

type Drawn<T> = Result<T, Box<dyn Error>>;

fn main() -> Drawn<()> {
    let folder = std::env::args().nth(1);
    let folder = folder.map_or_else(|| PathBuf::from("docs/motion"), PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    movej(&folder.join("movej.png"))?;
    blend(&folder.join("blend.png"))?;
    singular(&folder.join("singularity.png"))?;
    Ok(())
}

/// A controller whose states are kept.
struct Run {
    cycle: Cycle,
    script: ScriptEnd,
    states: Vec<RobotState>,
}

impl Run {
    fn new(home: JointPositions) -> Drawn<Self> {
        let config = CycleConfig {
            plant: PlantKind::Ideal,
            home,
            ..CycleConfig::new(RobotModel::built_in("cs66")?)
        };
        let first = config.first_state();
        let (motion, script) = border(BorderSizes::default(), &first);
        Ok(Self {
            cycle: Cycle::new(config, motion)?,
            script,
            states: vec![first],
        })
    }

    /// Sends a command and runs until it has ended.
    fn run(&mut self, kind: CommandKind) -> Drawn<()> {
        let sent = self.script.commands.send(Origin::default(), kind)?;
        loop {
            self.cycle.tick(Timing::default());
            self.states.push(self.script.snapshot.read());
            while let Some(event) = self.script.events.next_event() {
                if let Event::Ended { id, outcome, .. } = event
                    && id == sent
                {
                    return match outcome {
                        Outcome::Done => Ok(()),
                        other => Err(format!("{kind:?} ended as {other:?}").into()),
                    };
                }
            }
        }
    }

    fn over_time(&self, value: impl Fn(&RobotState) -> f64) -> Vec<(f64, f64)> {
        self.states.iter().map(|s| (s.time, value(s))).collect()
    }
}

fn home() -> JointPositions {
    JointPositions([0.0, -1.57, 1.57, -1.57, -1.57, 0.0])
}

fn tcp_speed(state: &RobotState) -> f64 {
    Vector3::from_row_slice(&state.target_tcp_speed[..3]).norm()
}

/// Speed, acceleration and jerk of a movej.
fn movej(file: &Path) -> Drawn<()> {
    let mut run = Run::new(home())?;
    run.run(CommandKind::MoveJ {
        target: JointPositions([1.2, -1.2, 1.9, -1.9, -1.37, 0.5]),
        acceleration: 1.396_263,
        speed: 1.047_197,
        duration: 0.0,
        radius: 0.0,
    })?;
    let step = run.cycle.step_time();
    let jerk = |joint: usize| -> Vec<(f64, f64)> {
        let pairs = run.states.windows(2);
        let change = |pair: &[RobotState]| pair[1].target_qdd[joint] - pair[0].target_qdd[joint];
        pairs
            .map(|pair| (pair[1].time, change(pair) / step))
            .collect()
    };
    let panel = |title: &str, unit: &str, value: &dyn Fn(usize) -> Vec<(f64, f64)>| {
        (0..6).fold(Panel::over_time(title, unit), |panel, joint| {
            panel.curve(Curve::new(format!("J{}", joint + 1), value(joint)))
        })
    };
    let speeds = panel("Joint speeds", "rad/s", &|joint| {
        run.over_time(|s| s.target_qd[joint])
    });
    let accelerations = panel("Joint accelerations", "rad/s²", &|joint| {
        run.over_time(|s| s.target_qdd[joint])
    });
    Figure::new("movej")
        .note("cs66, default speed and acceleration")
        .panel(speeds.level("v", 1.047_197))
        .panel(accelerations.level("a", 1.396_263))
        .panel(panel("Joint jerks", "rad/s³", &jerk))
        .save(file)?;
    Ok(())
}

/// Four lines with blend radii, seen from above.
fn blend(file: &Path) -> Drawn<()> {
    let mut run = Run::new(home())?;
    let start = run.states[0].target_tcp_pose;
    let corners = [
        (0.0, 0.25, 0.05),
        (-0.2, 0.25, 0.08),
        (-0.2, 0.05, 0.03),
        (-0.05, 0.05, 0.0),
    ];
    let mut marks = Marks::dashed("returns");
    for (x, y, radius) in corners {
        run.run(CommandKind::MoveL {
            target: moved(&start, [x, y, 0.0]),
            acceleration: 1.2,
            speed: 0.25,
            duration: 0.0,
            radius,
        })?;
        let time = run.states.last().map_or(0.0, |s| s.time);
        marks.push(time, "movel");
    }
    let mm = |s: &RobotState| {
        (
            1000.0 * s.target_tcp_pose.xyz[0],
            1000.0 * s.target_tcp_pose.xyz[1],
        )
    };
    let at = |x: f64, y: f64| (1000.0 * (start.xyz[0] + x), 1000.0 * (start.xyz[1] + y));
    let asked = [(0.0, 0.0)]
        .into_iter()
        .chain(corners.map(|(x, y, _)| (x, y)));
    let plane = Panel::plane("TCP from above", "x in mm", "y in mm")
        .curve(Curve::new("TCP", run.states.iter().map(mm)))
        .curve(Curve::new("as asked", asked.map(|(x, y)| at(x, y))).style(CurveStyle::Dashed));
    let plane =
        corners
            .iter()
            .filter(|corner| corner.2 > 0.0)
            .fold(plane, |plane, (x, y, radius)| {
                plane.circle(Circle {
                    center: at(*x, *y),
                    radius: 1000.0 * radius,
                    name: format!("r = {:.0} mm", 1000.0 * radius),
                })
            });
    let speeds = run.over_time(|s| 1000.0 * tcp_speed(s));
    let accelerations = (0..6).fold(
        Panel::over_time("Joint accelerations", "rad/s²"),
        |panel, joint| {
            panel.curve(Curve::new(
                format!("J{}", joint + 1),
                run.over_time(|s| s.target_qdd[joint]),
            ))
        },
    );
    Figure::new("Blends between lines")
        .note("cs66, v = 250 mm/s")
        .panel(
            Panel::over_time("TCP speed", "mm/s")
                .curve(Curve::new("TCP", speeds))
                .level("v", 250.0),
        )
        .panel(accelerations)
        .panel(plane)
        .marks(marks)
        .save(file)?;
    Ok(())
}

fn moved(pose: &RpyPose, by: [f64; 3]) -> RpyPose {
    let mut pose = *pose;
    (0..3).for_each(|k| pose.xyz[k] += by[k]);
    pose
}

/// A line that passes a singular position of the wrist at 0.03 rad.
fn singular(file: &Path) -> Drawn<()> {
    const BESIDE: f64 = 0.03;
    const HALF: f64 = 0.2;
    let model = RobotModel::built_in("cs66")?;
    let straight = JointPositions([0.3, -1.3, 1.7, -1.9, 0.0, 0.2]);
    let singular = model.tcp_pose(&straight, &Pose::IDENTITY);
    let radial = Vector3::new(0.3_f64.cos(), 0.3_f64.sin(), 0.0);
    let tilt = nalgebra::Rotation3::new(radial * BESIDE);
    let along = Vector3::z().cross(&radial);
    let at = |way: f64| {
        let position = singular.translation + along * way;
        Pose::new(tilt * singular.rotation, position)
    };
    let mut start = JointPositions([0.3, -1.3, 1.7, -1.9, BESIDE, 0.2]);
    for step in 0..=200 {
        let pose = at(-HALF * f64::from(step) / 200.0);
        start = model
            .inverse_nearest(&pose, &Pose::IDENTITY, &start)
            .ok_or("the beginning of the line is out of reach")?;
    }
    let mut run = Run::new(start)?;
    run.run(CommandKind::MoveL {
        target: at(HALF).to_rpy(),
        acceleration: 1.2,
        speed: 0.5,
        duration: 0.0,
        radius: 0.0,
    })?;
    let joints = |title: &str, unit: &str, value: fn(&RobotState, usize) -> f64| {
        (0..6).fold(Panel::over_time(title, unit), |panel, joint| {
            let name = format!("J{}", joint + 1);
            panel.curve(Curve::new(name, run.over_time(|s| value(s, joint))))
        })
    };
    let limits = model.limits();
    Figure::new("A line past a singular position of the wrist")
        .note("cs66, v = 500 mm/s asked for, 0.03 rad beside")
        .panel(
            Panel::over_time("TCP speed", "mm/s")
                .curve(Curve::new("TCP", run.over_time(|s| 1000.0 * tcp_speed(s)))),
        )
        .panel(
            joints("Joint speeds", "rad/s", |s, joint| s.target_qd[joint])
                .level("limit", limits.speed[3]),
        )
        .panel(joints("Joint accelerations", "rad/s²", |s, joint| {
            s.target_qdd[joint]
        }))
        .save(file)?;
    Ok(())
}
