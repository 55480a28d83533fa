//! Whether an arm reaches the points of a toolpath, and where it may pass through joint space.

use kinematics::{JointPositions, Pose, RobotModel};
use messages::text;

use super::program::{ProgramOptions, base_pose, end_pose};
use super::{Point, Remark, StepKind, Toolpath, distance, dot, unit};

/// Points of a rapid move that are looked at.
const SAMPLES: u32 = 50;

/// Shorter rapid moves go straight, m.
const DISTANCE_MIN_M: f64 = 0.05;

/// An arm with its tool, on its way along a toolpath.
pub struct Reach<'m> {
    /// The arm.
    pub model: &'m RobotModel,
    /// The TCP in the flange frame.
    pub flange_from_tcp: Pose,
    /// Joint positions before the first move.
    pub home: JointPositions,
}

impl Reach<'_> {
    /// Remarks about points that the arm does not reach, one a line of the file.
    pub fn remarks(&self, path: &Toolpath, options: &ProgramOptions) -> Vec<Remark> {
        let mut remarks: Vec<Remark> = Vec::new();
        let mut near = self.home;
        for step in &path.steps {
            let Some(pose) = end_pose(options, &step.kind) else {
                continue;
            };
            let via = match step.kind {
                StepKind::Arc { via, .. } => Some(base_pose(options, via)),
                _ => None,
            };
            for pose in via.into_iter().chain([pose]) {
                match self
                    .model
                    .inverse_nearest(&pose, &self.flange_from_tcp, &near)
                {
                    Some(found) => near = found,
                    None if remarks.last().is_some_and(|last| last.line == step.line) => {}
                    None => {
                        let [x, y, z] = pose.translation.into();
                        let text = text!(
                            "the arm does not reach {x:.4}, {y:.4}, {z:.4} m (base frame)",
                            "机械臂到不了 {x:.4}、{y:.4}、{z:.4} m（基座坐标系）"
                        );
                        remarks.push(Remark {
                            line: step.line,
                            is_error: true,
                            text,
                        });
                    }
                }
            }
        }
        remarks
    }

    /// Whether the TCP stays above `top`, the height of the work, when the joints go straight from one point to the
    /// other.
    pub fn is_free(&self, options: &ProgramOptions, top: f64, from: Point, to: Point) -> bool {
        let height = |point: Point| height(options, point);
        if height(from).min(height(to)) <= top || distance(from, to) < DISTANCE_MIN_M {
            return false;
        }
        let joints = |point: Point, near: &JointPositions| {
            self.model
                .inverse_nearest(&base_pose(options, point), &self.flange_from_tcp, near)
        };
        let Some(begin) = joints(from, &self.home) else {
            return false;
        };
        let Some(end) = joints(to, &begin) else {
            return false;
        };
        let frame = Pose::from_rpy(&options.frame).inverse();
        (1..SAMPLES).all(|index| {
            let part = f64::from(index) / f64::from(SAMPLES);
            let mut between = begin;
            for (joint, end) in between.0.iter_mut().zip(end.0) {
                *joint += part * (end - *joint);
            }
            let tcp = frame * self.model.tcp_pose(&between, &self.flange_from_tcp);
            height(tcp.translation.into()) > top
        })
    }
}

/// Height of a point against the tool's axis, m.
fn height(options: &ProgramOptions, point: Point) -> f64 {
    -dot(point, unit(options.tool_axis).unwrap_or([0.0, 0.0, -1.0]))
}

/// The highest point that is driven at work, m: nothing to work on is taken to lie above it.
pub fn work_top(path: &Toolpath, options: &ProgramOptions) -> f64 {
    let works = path.steps.iter().filter_map(|step| match step.kind {
        StepKind::Line(to) | StepKind::Pose(to, _) | StepKind::Arc { to, .. } => {
            Some(height(options, to))
        }
        _ => None,
    });
    works.fold(f64::NEG_INFINITY, f64::max)
}
