//! A path around what is in the way, as a program that is proven by running it.
//!
//! `path-planning` finds corners and proves the straight lines between them; here they become motions with blends as
//! large as the margin allows, which only the controller itself can tell: every program that comes out was run, and the
//! distance and time in the result are those of that run.

mod goals;
mod program;
mod request;

use std::fmt;
use std::time::Instant;

use elite_runtime::ProgramText;
use kinematics::{JointPositions, Pose};
use messages::{Language, Localized, Text, text};
use path_planning::{CollisionScene, JointPath, ObstaclePlace, PathError, PathRequest};
use thiserror::Error;

use crate::clearance::{
    ClearanceError, ClearanceRun, MeasureOptions, MeasuredEnd, collision_scene, measure_in,
};
use crate::config::ControllerConfig;
use crate::start::StartError;
use goals::Goal;
use program::ProgramOfPath;

pub use request::{DEFAULT_ACCELERATION, DEFAULT_SPEED, PathTarget, PlanOptions};

/// The search keeps this more than the margin, m: what is proven is proven to less, and rounding is not to count.
const RESERVE: f64 = 3e-4;
/// A second path is looked for that keeps this much more, m: in its corners there is room for blends.
const BLEND_ROOM: f64 = 0.015;
/// Of the shorter of its two pieces a blend takes so much, as seen from the TCP.
const BLEND_SHARE: f64 = 0.45;
/// Largest blend, m.
const BLEND_MAX: f64 = 0.25;
/// Blends smaller than this are none, m.
const BLEND_MIN: f64 = 0.001;
/// A blend at a position that the path has to pass takes this much of its pieces, rad, so that it passes near.
const VIA_ZONE: f64 = 0.12;
/// Runs in which blends become smaller.
const BLEND_RUNS: u32 = 10;

/// A path that was driven.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedPath {
    /// Start, corners and goal.
    pub waypoints: Vec<JointPositions>,
    /// The program.
    pub program: String,
    /// The least distance on the driven path, m; `None` where nothing can touch.
    pub distance: Option<f64>,
    /// Sum of the Euclidean distances between the waypoints, rad.
    pub length: f64,
    /// How long it takes to drive, s.
    pub time: f64,
    /// How long it took to plan, time of the machine, s.
    pub planning_time: f64,
    /// What a person should know of it.
    pub warnings: Vec<Text>,
}

/// A reason why there is no path.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum PlanError {
    /// No path, for a reason that lies in the cell.
    #[error("{detail}")]
    NoPath {
        /// The kind of reason.
        reason: NoPathReason,
        /// The sentence.
        detail: Text,
    },
    /// What was asked for makes no sense.
    #[error("{0}")]
    Request(Text),
    /// No controller.
    #[error(transparent)]
    Start(#[from] StartError),
    /// The run met a fault.
    #[error(transparent)]
    Run(#[from] ClearanceError),
}

/// The kinds of reasons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoPathReason {
    /// Something touches at the start.
    StartInCollision,
    /// Something touches at the goal.
    GoalInCollision,
    /// The arm does not reach the goal.
    OutOfReach,
    /// Tries or time were used up, or the controller does not drive what was found.
    NoPath,
}

impl NoPathReason {
    /// The word for it, which machines read.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::StartInCollision => "start_in_collision",
            Self::GoalInCollision => "goal_in_collision",
            Self::OutOfReach => "out_of_reach",
            Self::NoPath => "no_path",
        }
    }
}

impl fmt::Display for NoPathReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

impl Localized for NoPathReason {
    fn fmt_in(&self, language: Language, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(language.pick(
            self.as_str(),
            match self {
                Self::StartInCollision => "起点碰撞",
                Self::GoalInCollision => "终点碰撞",
                Self::OutOfReach => "不可达",
                Self::NoPath => "没有路径",
            },
        ))
    }
}

fn no_path(reason: NoPathReason, detail: Text) -> PlanError {
    PlanError::NoPath { reason, detail }
}

/// Plans a path from the home position of `config`, and drives it.
///
/// # Errors
/// [`PlanError`]
pub fn plan_path(
    config: &ControllerConfig,
    options: &PlanOptions,
    keep_going: &mut dyn FnMut() -> bool,
) -> Result<PlannedPath, PlanError> {
    let began = Instant::now();
    let scene = scene_with_held(config, options)?;
    let planner = PathPlanner {
        config,
        options,
        scene: &scene,
    };
    planner.check_request()?;
    let goals = planner.goals()?;
    let starts: Vec<JointPositions> = goals.iter().map(|goal| goal.before_line).collect();
    let request = PathRequest {
        scene: &scene,
        limits: scene.model().limits(),
        start: config.home,
        via: &options.via,
        goals: &starts,
        margin: options.margin + RESERVE,
        seed: config.seed,
    };
    let mut should_stop = || began.elapsed() > options.time || !keep_going();
    let path =
        path_planning::plan(&request, &mut should_stop).map_err(|error| planner.explain(error))?;
    // Blends need room: with more of it around the corners a longer path may be driven in less time.
    let mut paths = vec![path];
    if paths[0].corners.len() > 2 {
        let roomier = PathRequest {
            margin: request.margin + BLEND_ROOM,
            ..request
        };
        paths.extend(path_planning::plan(&roomier, &mut should_stop).ok());
    }
    let planning_time = began.elapsed().as_secs_f64();
    let mut driven: Vec<PlannedPath> = Vec::new();
    let mut failed = None;
    for path in paths {
        match planner.finish(path, &goals, planning_time, keep_going) {
            Ok(path) => driven.push(path),
            Err(error) => failed = failed.or(Some(error)),
        }
    }
    let quicker = |best: PlannedPath, other: PlannedPath| match other.time < best.time {
        true => other,
        false => best,
    };
    match (driven.into_iter().reduce(quicker), failed) {
        (Some(best), _) => Ok(best),
        (None, Some(error)) => Err(error),
        (None, None) => Err(no_path(
            NoPathReason::NoPath,
            text!("no path was found", "没有找到路径"),
        )),
    }
}

/// The scene of the settings, with what is held on the flange.
fn scene_with_held(
    config: &ControllerConfig,
    options: &PlanOptions,
) -> Result<CollisionScene, PlanError> {
    let mut scene = collision_scene(config)?;
    let Some(name) = &options.held else {
        return Ok(scene);
    };
    let flange = scene.model().flange_pose(&config.home);
    match scene.obstacle(name).map(|id| (id, scene.place(id))) {
        Some((id, Some(ObstaclePlace::Standing(pose)))) => {
            scene.set_place(id, ObstaclePlace::Held(flange.inverse() * pose));
            Ok(scene)
        }
        _ => {
            let names: Vec<&str> = scene.obstacle_names().collect();
            let there = match names.is_empty() {
                true => text!("there is nothing", "其中什么也没有"),
                false => text!("there is {}", "有{}", names.join(", ")),
            };
            Err(PlanError::Request(text!(
                "there is nothing called {name:?} in the cell that could be held; {there}",
                "单元中没有名为 {name:?} 的可夹持物体；{there}"
            )))
        }
    }
}

struct PathPlanner<'a> {
    config: &'a ControllerConfig,
    options: &'a PlanOptions,
    scene: &'a CollisionScene,
}

impl PathPlanner<'_> {
    /// Joint positions that were typed are within the ranges of the joints.
    fn check_request(&self) -> Result<(), PlanError> {
        let limits = self.scene.model().limits();
        let target = match &self.options.target {
            PathTarget::Joints(q) => Some((text!("the target", "终点"), *q)),
            PathTarget::Pose(_) => None,
        };
        let named = [(text!("the start", "起点"), self.config.home)]
            .into_iter()
            .chain(target);
        let via = self
            .options
            .via
            .iter()
            .map(|q| (text!("a via position", "中间位置"), *q));
        for (name, q) in named.chain(via) {
            if let Some((joint, value)) = limits.position_violation(&q) {
                return Err(PlanError::Request(text!(
                    "{name} has joint {} at {value} rad, allowed is {:.4} to {:.4} rad",
                    "{name}的关节 {} 为 {value} rad，允许 {:.4} 到 {:.4} rad",
                    joint + 1,
                    limits.position_min[joint],
                    limits.position_max[joint]
                )));
            }
        }
        Ok(())
    }

    /// Where the path may end.
    fn goals(&self) -> Result<Vec<Goal>, PlanError> {
        let model = self.scene.model();
        let tcp = Pose::from_rpy(&self.config.tcp);
        let targets = match &self.options.target {
            PathTarget::Joints(q) => vec![*q],
            PathTarget::Pose(pose) => {
                let pose = Pose::from_rpy(pose);
                let near = self.options.via.last().unwrap_or(&self.config.home);
                let all = goals::joint_positions_of(model, &pose, &tcp, near);
                if all.is_empty() {
                    let detail = match model.inverse_all(&pose, &tcp).is_empty() {
                        true => text!(
                            "no joint positions bring the TCP to {}: it is out of the arm's reach; with another base \
                             pose or a longer tool (--tcp) it may not be",
                            "没有关节位置能使 TCP 到达 {}：超出机械臂的到达范围；换一个基座位姿或更长的工具（--tcp）也许可以",
                            self.options.target
                        ),
                        false => text!(
                            "every way to bring the TCP to {} needs a joint beyond its range",
                            "使 TCP 到达 {} 的每种方式都会有关节超出范围",
                            self.options.target
                        ),
                    };
                    return Err(no_path(NoPathReason::OutOfReach, detail));
                }
                all
            }
        };
        if self.options.approach <= 0.0 {
            let goal = |q| Goal {
                target: q,
                before_line: q,
            };
            return Ok(targets.into_iter().map(goal).collect());
        }
        let (mut found, mut touching) = (Vec::new(), None);
        for target in targets {
            let length = self.options.approach;
            let Some(places) = goals::before_line(model, &tcp, &target, length) else {
                continue;
            };
            match goals::touches_on_line(self.scene, &places) {
                Some(names) => touching = touching.or(Some(names)),
                None => found.push(Goal {
                    target,
                    before_line: places[places.len() - 1],
                }),
            }
        }
        if !found.is_empty() {
            return Ok(found);
        }
        let millimetres = self.options.approach * 1e3;
        Err(match touching {
            Some((a, b)) => no_path(
                NoPathReason::GoalInCollision,
                text!(
                    "{a} touches {b} on the last {millimetres:.0} mm, on every line to the target",
                    "在通往终点的每条直线上，{a}在最后 {millimetres:.0} mm 与{b}相碰"
                ),
            ),
            None => no_path(
                NoPathReason::OutOfReach,
                text!(
                    "the arm cannot follow the last {millimetres:.0} mm to the target on a line; --approach is \
                     shorter or 0",
                    "机械臂无法沿直线走完到终点的最后 {millimetres:.0} mm；请缩短 --approach 或设为 0"
                ),
            ),
        })
    }

    /// Drives a path that was found.
    fn finish(
        &self,
        path: JointPath,
        goals: &[Goal],
        planning_time: f64,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> Result<PlannedPath, PlanError> {
        let end = path.corners.last().copied().unwrap_or(self.config.home);
        let mut waypoints = path.corners.clone();
        let goal = goals.iter().find(|goal| goal.before_line == end);
        if let Some(goal) = goal.filter(|_| self.options.approach > 0.0) {
            waypoints.push(goal.target);
        }
        let mut warnings = Vec::new();
        let mut least_allowed = self.options.margin;
        for (pair, left) in &path.lowered {
            if *left >= self.options.margin {
                continue;
            }
            let (a, b) = self.scene.texts(*pair);
            least_allowed = least_allowed.min(*left - RESERVE);
            warnings.push(text!(
"{a} and {b} are only {:.1} mm apart at an end of the path; there the margin of {:.1} mm is not kept",
"{a}与{b}在路径一端只相距 {:.1} mm；那里不能保持 {:.1} mm 的间隙",
                left * 1e3,
                self.options.margin * 1e3
            ));
        }
        let mut radii = self.first_radii(&waypoints, &path.via);
        let (program, run) = self.drive(&waypoints, &mut radii, least_allowed, keep_going)?;
        let distance = run.distance();
        Ok(PlannedPath {
            length: path_planning::length(&waypoints),
            waypoints,
            program,
            distance: distance.is_finite().then_some(distance),
            time: run.result.time,
            planning_time,
            warnings,
        })
    }

    /// The search's reasons in sentences.
    fn explain(&self, error: PathError) -> PlanError {
        let named = |pair| {
            let (a, b) = self.scene.texts(pair);
            text!("{a} touches {b}", "{a}与{b}相碰")
        };
        match error {
            PathError::StartInCollision { pair } => no_path(
                NoPathReason::StartInCollision,
                text!(
                    "{} at the start; what may touch is named by [[touch]] in the cell file",
                    "{}，在起点；允许接触的物体在单元文件的 [[touch]] 中给出",
                    named(pair)
                ),
            ),
            PathError::GoalInCollision { pairs } => {
                let mut names: Vec<Text> = pairs.into_iter().map(named).collect();
                names.sort();
                names.dedup();
                no_path(
                    NoPathReason::GoalInCollision,
                    text!(
                        "{} at the goal; what may touch is named by [[touch]] in the cell file",
                        "{}，在终点；允许接触的物体在单元文件的 [[touch]] 中给出",
                        Text::joined(names, ", ", "、")
                    ),
                )
            }
            PathError::ViaInCollision { number, pair } => no_path(
                NoPathReason::NoPath,
                text!(
                    "{} at via position {number}",
                    "{}，在中间位置 {number}",
                    named(pair)
                ),
            ),
            PathError::NotFound {
                tries,
                out_of_time,
                in_the_way,
            } => {
                let mut names = Vec::new();
                for pair in in_the_way {
                    let (a, b) = self.scene.texts(pair);
                    let name = text!("{a} and {b}", "{a}与{b}");
                    if names.len() < 3 && !names.contains(&name) {
                        names.push(name);
                    }
                }
                let ended = match out_of_time {
                    true => text!(
                        "after {} s and {tries} tries",
                        "{} s、{tries} 次尝试后",
                        self.options.time.as_secs_f64()
                    ),
                    false => text!("in {tries} tries", "{tries} 次尝试中"),
                };
                let advice = match out_of_time {
                    true => text!("; --time gives it longer", "；--time 可给更长时间"),
                    false => text!(
                        "; a position in --via or a smaller --margin may help",
                        "；在 --via 中给出一个位置或减小 --margin 也许有用"
                    ),
                };
                no_path(
                    NoPathReason::NoPath,
                    text!(
                        "no path was found {ended}; most often in the way were {}{advice}",
                        "{ended}没有找到路径；最常挡路的是{}{advice}",
                        Text::joined(names, "; ", "；")
                    ),
                )
            }
            other => PlanError::Request(Text::of(&other)),
        }
    }

    /// Blend radii as large as the pieces of the path allow, for every waypoint.
    fn first_radii(&self, waypoints: &[JointPositions], via: &[usize]) -> Vec<f64> {
        let tcp = Pose::from_rpy(&self.config.tcp);
        let model = self.scene.model();
        let place = |q: &JointPositions| model.tcp_pose(q, &tcp).translation;
        let mut radii = vec![0.0; waypoints.len()];
        for number in 1..waypoints.len().saturating_sub(1) {
            let ends = [number - 1, number + 1];
            let pieces = ends.map(|end| {
                let way = (place(&waypoints[end]) - place(&waypoints[number])).norm();
                let turn = waypoints[end].distance_squared(&waypoints[number]).sqrt();
                match via.contains(&number) && turn > 0.0 {
                    true => (way * VIA_ZONE / turn).min(way * BLEND_SHARE),
                    false => way * BLEND_SHARE,
                }
            });
            radii[number] = rounded(pieces[0].min(pieces[1]).min(BLEND_MAX));
        }
        radii
    }

    /// Drives the path, with smaller blends where they come too near to something.
    fn drive(
        &self,
        waypoints: &[JointPositions],
        radii: &mut [f64],
        least_allowed: f64,
        keep_going: &mut dyn FnMut() -> bool,
    ) -> Result<(String, ClearanceRun), PlanError> {
        let line_to = (self.options.approach > 0.0).then(|| match &self.options.target {
            PathTarget::Pose(pose) => pose.to_array(),
            PathTarget::Joints(q) => {
                let tcp = Pose::from_rpy(&self.config.tcp);
                self.scene.model().tcp_pose(q, &tcp).to_rpy().to_array()
            }
        });
        for attempt in 0..=BLEND_RUNS {
            if attempt == BLEND_RUNS {
                radii.fill(0.0);
            }
            let program = ProgramOfPath {
                corners: waypoints,
                radii,
                line_to,
                speed: self.options.speed,
                acceleration: self.options.acceleration,
                tcp: self.config.tcp.to_array(),
            };
            let text = program.text();
            let source = ProgramText {
                name: "the planned path".to_owned(),
                text: text.clone(),
            };
            let scene = self.scene.clone();
            let run = measure_in(
                scene,
                self.config,
                source,
                &MeasureOptions::default(),
                keep_going,
            )?;
            if run.end != MeasuredEnd::Finished {
                return Err(no_path(
                    NoPathReason::NoPath,
                    text!(
                        "a path was found, but the controller does not drive it: {}",
                        "找到了路径，但控制器不执行它：{}",
                        run.end
                    ),
                ));
            }
            let lines: Vec<u32> = (0..waypoints.len())
                .map(|corner| program.line_of_corner(corner))
                .collect();
            let near: Vec<usize> = (1..waypoints.len())
                .filter(|corner| {
                    let rows = run.rows.iter().filter(|row| row.line == lines[*corner]);
                    rows.map(|row| row.distance()).fold(f64::INFINITY, f64::min) < least_allowed
                })
                .collect();
            if near.is_empty() {
                return Ok((text, run));
            }
            // The blend into a motion is at the corner before it; the piece itself is proven.
            let mut is_smaller = false;
            for corner in near {
                for blend in [corner - 1, corner] {
                    if radii[blend] > 0.0 {
                        radii[blend] = rounded(radii[blend] * 0.6);
                        is_smaller = true;
                    }
                }
            }
            if !is_smaller {
                let nearest = run.nearest().and_then(|row| row.least.clone());
                let nearest = nearest.map_or(Text::verbatim(""), |least| {
                    text!(
                        ": {} comes within {:.1} mm of {}",
                        "：{0}与{2}相距不到 {1:.1} mm",
                        least.a,
                        least.distance * 1e3,
                        least.b
                    )
                });
                return Err(no_path(
                    NoPathReason::NoPath,
                    text!(
                        "a path was found, but driven it does not keep the margin{nearest}; a smaller --margin \
                         may help",
                        "找到了路径，但执行时不能保持间隙{nearest}；减小 --margin 也许有用"
                    ),
                ));
            }
        }
        Err(no_path(
            NoPathReason::NoPath,
            text!(
                "a path was found, but driven it does not keep the margin",
                "找到了路径，但执行时不能保持间隙"
            ),
        ))
    }
}

/// A radius in whole tenths of a millimetre, 0 for a small one.
fn rounded(radius: f64) -> f64 {
    match radius < BLEND_MIN {
        true => 0.0,
        false => (radius * 1e4).floor() / 1e4,
    }
}
