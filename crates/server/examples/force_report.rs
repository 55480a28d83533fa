//! How well force mode presses: a table in Markdown and a picture, from recordings.
//!
//! `cargo run -p server --example force_report -- docs/force.png` runs scripts on plates of 1, 10 and 100 N/mm and over
//! a tilted and a faceted surface, records them and reports; ELITESERVER names the binary, otherwise the one beside
//! this example is used. With recordings as further arguments those are reported instead. Each `force_mode` call of a
//! recording in mode 0 or 3 is one row for each force axis with a target:
//!
//! - settled: from the first touch until the force stays within 5 % of its target;
//! - peak: largest force over the target; steady: mean deviation in the last fifth of the time;
//! - rms: of the deviation while the tool slides faster than 10 mm/s, from a second after the first touch;
//! - lost: how often the contact was lost later than a second after the first touch.
#![allow(clippy::print_stdout, reason = "the report is what the program is for")]

use std::error::Error;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use kinematics::{Pose, RobotModel, RpyPose};
use nalgebra::Vector3;
use recorder::{CycleMessage, Recording, RecordingEntry, Topic};
use serde_json::Value;
use server::plot::{Curve, Figure, PlotPanel};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Length of the tool, m: it and not the wrist touches.
const TOOL: f64 = 0.15;
const STIFFNESSES: [f64; 3] = [1e3, 1e4, 1e5];
const TARGETS: [f64; 3] = [5.0, 20.0, 80.0];
/// What sliding is done with.
const SLIDING: (f64, f64) = (20.0, 0.05);

fn main() -> Result<()> {
    let mut arguments = std::env::args().skip(1);
    let picture = PathBuf::from(arguments.next().unwrap_or_else(|| "force.png".into()));
    let given: Vec<String> = arguments.collect();
    println!("| run | target N | approach mm/s | settled s | peak | steady % | rms % | lost |");
    println!("|---|---|---|---|---|---|---|---|");
    let mut panels: Vec<(String, Vec<Span>)> = Vec::new();
    if given.is_empty() {
        for stiffness in STIFFNESSES {
            let mut spans = Vec::new();
            for target in TARGETS {
                let name = format!("{} N/mm", stiffness / 1e3);
                spans.extend(run(&name, &plate(stiffness), &pressing(stiffness, target))?);
            }
            let (approaches, steps) = spans.into_iter().partition(|span| span.limit < 0.1);
            panels.push((
                format!("{} N/mm, approach at 10 mm/s", stiffness / 1e3),
                approaches,
            ));
            panels.push((
                format!("{} N/mm, from a gap of 0.1 mm", stiffness / 1e3),
                steps,
            ));
        }
        for (name, cell) in surfaces() {
            let title = format!("{name}, sliding at 50 mm/s");
            panels.push((title, run(&name, &cell, &sliding())?));
        }
    } else {
        for file in given {
            let spans = report(&file, &Recording::open(&file)?)?;
            panels.push((file, spans));
        }
    }
    draw(panels, &picture)
}

/// Runs a script in a cell and reports its recording.
fn run(name: &str, cell: &str, script: &str) -> Result<Vec<Span>> {
    let folder = std::env::temp_dir().join(format!("force_report_{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let [cell_file, script_file, recording] =
        ["cell.toml", "press.script", "press.mcap"].map(|file| folder.join(file));
    std::fs::write(&cell_file, cell)?;
    std::fs::write(&script_file, script)?;
    let beside = std::env::current_exe()?
        .ancestors()
        .nth(2)
        .map(|folder| folder.join("eliteserver"))
        .ok_or("no folder of binaries")?;
    let binary = std::env::var_os("ELITESERVER").map_or(beside, PathBuf::from);
    let output = Command::new(binary)
        .arg("run")
        .arg(&script_file)
        .args(["--tcp", &format!("0,0,{TOOL},0,0,0")])
        .arg("--cell")
        .arg(&cell_file)
        .arg("--record")
        .arg(&recording)
        .stdout(Stdio::null())
        .output()?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into_owned().into());
    }
    let spans = report(name, &Recording::open(&recording)?)?;
    std::fs::remove_dir_all(&folder)?;
    Ok(spans)
}

fn tcp_at_home() -> Result<Vector3<f64>> {
    let model = RobotModel::built_in("cs66")?;
    let home = recorder::Setup::default().home;
    let tool = Pose::from_translation(0.0, 0.0, TOOL);
    Ok(model.tcp_pose(&home, &tool).translation)
}

fn plate(stiffness: f64) -> String {
    let z = tcp_at_home().map_or(0.0, |tcp| tcp.z) - 0.005;
    format!(
        "[[obstacle]]\nname = \"plate\"\nshape = \"plane\"\npose = [0, 0, {z}, 0, 0, 0]\nstiffness = {stiffness}\n"
    )
}

/// A plane tilted by 10 degrees, and a valley of planes that touch a circle of 0.4 m every 0.1 rad.
fn surfaces() -> Vec<(String, String)> {
    let tcp = tcp_at_home().unwrap_or_default();
    let plane = format!(
        "[[obstacle]]\nname = \"ramp\"\nshape = \"plane\"\npose = [{}, {}, {}, 0.17453, 0, 0]\nstiffness = 1e4\n",
        tcp.x,
        tcp.y,
        tcp.z - 0.003
    );
    let (radius, turn) = (0.4, 0.1_f64);
    let mut valley = String::new();
    for facet in -4_i32..=4 {
        let angle = turn * f64::from(facet);
        let (y, z) = (radius * angle.sin(), radius * (1.0 - angle.cos()));
        let _ = writeln!(
            valley,
            "[[obstacle]]\nname = \"facet {facet}\"\nshape = \"plane\"\npose = [{}, {}, {}, {angle}, 0, 0]\n\
             stiffness = 1e4",
            tcp.x,
            tcp.y + y,
            tcp.z - 0.003 + z,
        );
    }
    vec![
        ("tilted by 10 degrees, 10 N/mm".into(), plane),
        ("facets of 5.7 degrees, 10 N/mm".into(), valley),
    ]
}

/// An approach at 10 mm/s, then once more from 0.1 mm above with a high speed limit.
fn pressing(stiffness: f64, target: f64) -> String {
    let time = 3.0 + target / stiffness / 0.01;
    format!(
        "def press():
    p = get_actual_tcp_pose()
    force_mode([0,0,0,0,0,0], [0,0,1,0,0,0], [0,0,{},0,0,0], 0, [0,0,0.01,0,0,0])
    sleep({time})
    end_force_mode()
    p[2] = p[2] - 0.0049
    movel(p, a=0.5, v=0.1)
    sleep(0.2)
    force_mode([0,0,0,0,0,0], [0,0,1,0,0,0], [0,0,{},0,0,0], 0, [0,0,0.25,0,0,0])
    sleep(2)
    end_force_mode()
end
",
        -target, -target
    )
}

fn sliding() -> String {
    let (force, speed) = SLIDING;
    format!(
        "def slide():
    p = get_actual_tcp_pose()
    force_mode([0,0,0,0,0,0], [0,0,1,0,0,0], [0,0,{},0,0,0], 0, [0,0,0.1,0,0,0])
    sleep(1.5)
    p[1] = p[1] + 0.1
    movel(p, a=0.3, v={speed})
    p[1] = p[1] - 0.2
    movel(p, a=0.3, v={speed})
    end_force_mode()
end
",
        -force
    )
}

/// One force axis between two calls.
struct Span {
    target: f64,
    limit: f64,
    /// Time s, force along the axis N, speed of the TCP across it m/s, along it m/s.
    samples: Vec<[f64; 4]>,
}

/// The force axes of a recording, each as a row of the table.
fn report(name: &str, recording: &Recording) -> Result<Vec<Span>> {
    let mut done: Vec<Span> = Vec::new();
    let mut open: Vec<(Goal, Span)> = Vec::new();
    let mut goals: Vec<(u64, Vec<Goal>)> = Vec::new();
    for command in recording.commands()? {
        let command = command?;
        match command.name.as_str() {
            "force_mode" => goals.push((command.cycle, Goal::of(&command.arguments))),
            "end_force_mode" => goals.push((command.cycle, Vec::new())),
            _ => {}
        }
    }
    let mut goals = goals.into_iter().peekable();
    for entry in recording.entries(&[Topic::Cycle])? {
        let (_, RecordingEntry::Cycle(cycle)) = entry? else {
            continue;
        };
        while let Some((_, axes)) = goals.next_if(|(at, _)| *at <= cycle.cycle) {
            done.extend(open.drain(..).map(|(_, span)| span));
            open.extend(axes.into_iter().map(|goal| {
                let span = Span {
                    target: goal.target,
                    limit: goal.limit,
                    samples: Vec::new(),
                };
                (goal, span)
            }));
        }
        for (goal, span) in &mut open {
            span.samples.push(goal.sample(&cycle));
        }
    }
    done.extend(open.into_iter().map(|(_, span)| span));
    for span in &done {
        println!("{}", span.row(name));
    }
    Ok(done)
}

/// A force axis with a target.
struct Goal {
    /// Unit vector, in the base or in the TCP frame.
    axis: Vector3<f64>,
    is_tool: bool,
    target: f64,
    limit: f64,
}

impl Goal {
    fn of(arguments: &serde_json::Map<String, Value>) -> Vec<Self> {
        let numbers = |name: &str| -> Vec<f64> {
            let list = arguments.get(name).and_then(Value::as_array);
            let number = |x: &Value| {
                x.as_f64()
                    .or_else(|| x.as_bool().map(|b| f64::from(u8::from(b))))
            };
            list.map(|list| list.iter().filter_map(number).collect())
                .unwrap_or_default()
        };
        let mode = arguments.get("mode").and_then(Value::as_u64);
        let (frame, selection) = (numbers("frame"), numbers("selection"));
        let (wrench, limits) = (numbers("wrench"), numbers("speed_limits"));
        let (Some(0 | 3), Ok(frame)) = (mode, <[f64; 6]>::try_from(frame)) else {
            return Vec::new();
        };
        let rotation = Pose::from_rpy(&RpyPose::from_array(frame)).rotation;
        (0..3)
            .filter(|k| {
                selection.get(*k) == Some(&1.0) && wrench.get(*k).is_some_and(|f| *f != 0.0)
            })
            .map(|k| {
                let own = Vector3::ith(k, wrench[k].signum());
                Self {
                    axis: if mode == Some(3) { own } else { rotation * own },
                    is_tool: mode == Some(3),
                    target: wrench[k].abs(),
                    limit: limits.get(k).copied().unwrap_or(0.0),
                }
            })
            .collect()
    }

    fn sample(&self, cycle: &CycleMessage) -> [f64; 4] {
        let vector = |v: &[f64]| Vector3::new(v[0], v[1], v[2]);
        let pose: [f64; 6] = core::array::from_fn(|k| cycle.actual_tcp_pose[k]);
        let base_from_tcp = Pose::from_rpy(&RpyPose::from_array(pose));
        let axis = if self.is_tool {
            base_from_tcp.rotate(self.axis)
        } else {
            self.axis
        };
        let felt = base_from_tcp.rotate(vector(&cycle.tcp_force));
        let speed = vector(&cycle.actual_tcp_speed);
        let along = speed.dot(&axis);
        [
            cycle.time,
            -felt.dot(&axis),
            (speed - axis * along).norm(),
            along,
        ]
    }
}

impl Span {
    /// When the tool first touched, s.
    fn touch(&self) -> Option<f64> {
        let place = self.samples.iter().position(|s| s[1] > 0.01)?;
        Some(self.samples[place][0])
    }

    fn row(&self, name: &str) -> String {
        let Some(touch) = self.touch() else {
            return format!("| {name} | {} | no contact | | | | | |", self.target);
        };
        let off = |s: &[f64; 4]| s[1] / self.target - 1.0;
        let before = self.samples.iter().take_while(|s| s[0] < touch);
        let approach = before.fold(0.0_f64, |most, s| most.max(s[3]));
        let settled = self
            .samples
            .iter()
            .rfind(|s| off(s).abs() > 0.05)
            .map_or(0.0, |s| (s[0] - touch).max(0.0));
        let peak = self.samples.iter().fold(0.0_f64, |most, s| most.max(s[1])) / self.target;
        let late = &self.samples[self.samples.len() * 4 / 5..];
        let steady = late.iter().map(off).sum::<f64>() / late.len() as f64;
        let slides: Vec<f64> = self
            .samples
            .iter()
            .filter(|s| s[0] > touch + 1.0 && s[2] > 0.01)
            .map(off)
            .collect();
        let rms = (slides.iter().map(|x| x * x).sum::<f64>() / slides.len() as f64).sqrt();
        let lost = self
            .samples
            .windows(2)
            .filter(|w| w[0][0] > touch + 1.0 && w[0][1] > 0.01 && w[1][1] <= 0.01)
            .count();
        let rms = if slides.is_empty() {
            "-".to_owned()
        } else {
            format!("{:.1}", 100.0 * rms)
        };
        format!(
            "| {name} | {} | {:.1} | {settled:.3} | {peak:.3} | {:.2} | {rms} | {lost} |",
            self.target,
            1e3 * approach,
            100.0 * steady,
        )
    }
}

fn draw(panels: Vec<(String, Vec<Span>)>, picture: &Path) -> Result<()> {
    let figure =
        Figure::new("Force mode with one setting: force over its target from the first touch");
    let figure = panels.into_iter().fold(figure, |figure, (title, spans)| {
        let panel = PlotPanel::over_time(title, "of the target").level("target", 1.0);
        figure.panel(spans.iter().fold(panel, |panel, span| {
            let touch = span.touch().unwrap_or(0.0);
            let points = span
                .samples
                .iter()
                .filter(|s| (-0.1..4.0).contains(&(s[0] - touch)))
                .map(|s| (s[0] - touch, s[1] / span.target));
            panel.curve(Curve::new(format!("{} N", span.target), points))
        }))
    });
    figure.save(picture)?;
    Ok(())
}
