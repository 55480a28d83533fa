//! The points of a moveml: taken a few at a time, kept until the next line begins.
//!
//! Their place is reserved when the controller starts, so that taking them allocates nothing. One script thread at a time
//! gives a line, and only that thread can run it.

use kinematics::Pose;
use motion_api::{Command, MotionMode, Origin, ProgramId, Refusal, ThreadNumber};
use nalgebra::UnitQuaternion;

use crate::constants::{LONGEST, MICRO_POINTS_MAX, MICRO_START, SLOWEST};
use crate::cycle::Cycle;
use crate::intake::{Answer, Ending, bad_value};
use crate::path::{MicroLine, Sample, TcpWay};
use crate::plan::MicroLinePlanner;
use crate::upcoming::Planned;

/// The list.
pub(crate) struct MicroPoints {
    points: Vec<Sample>,
    /// They are poses of the TCP.
    are_poses: bool,
    giver: Option<(ProgramId, ThreadNumber)>,
}

impl MicroPoints {
    /// Empty, with room for all.
    pub(crate) fn new() -> Self {
        Self {
            points: Vec::with_capacity(MICRO_POINTS_MAX),
            are_poses: false,
            giver: None,
        }
    }

    /// The points so far.
    pub(crate) fn points(&self) -> &[Sample] {
        &self.points
    }
}

impl Cycle {
    /// Takes points of a micro line.
    pub(crate) fn micro_points(
        &mut self,
        origin: Origin,
        (begins, are_poses): (bool, bool),
        count: usize,
        points: &[Sample; 4],
    ) -> Answer {
        let list = &mut self.micro_points;
        let given = points.get(..count).filter(|given| !given.is_empty());
        let given = given.ok_or_else(|| bad_value("count", count as f64, "1 to 4"))?;
        if begins {
            list.points.clear();
            list.are_poses = are_poses;
            list.giver = Some((origin.program, origin.thread));
        } else if list.giver != Some((origin.program, origin.thread)) || list.are_poses != are_poses
        {
            return Err(self.other_line());
        }
        for point in given {
            if let Some(value) = point.iter().find(|x| !x.is_finite()) {
                return Err(bad_value("a number of a point", *value, "a finite number"));
            }
            let [.., w, i, j, k] = *point;
            let length = [w, i, j, k].iter().map(|x| x * x).sum::<f64>().sqrt();
            if are_poses && !QUATERNION_LENGTH.contains(&length) {
                return Err(bad_value("the length of a quaternion", length, "0.5 to 2"));
            }
            if list.points.len() >= MICRO_POINTS_MAX {
                let value = (MICRO_POINTS_MAX + 1) as f64;
                return Err(bad_value("the number of points", value, "at most 100000"));
            }
            list.points.push(*point);
        }
        Ok(Ending::Now)
    }

    fn other_line(&self) -> Refusal {
        let value = self.micro_points.points.len() as f64;
        bad_value(
            "the number of points given by this thread",
            value,
            "that of the line: another thread has begun one of its own",
        )
    }

    /// Begins a moveml.
    pub(crate) fn moveml(&mut self, command: &Command, count: u32, interval: f64) -> Answer {
        if !(SLOWEST..=LONGEST).contains(&interval) {
            let needed = "0.000001 to 1000000 s";
            return Err(bad_value("the time between points", interval, needed));
        }
        let giver = Some((command.origin.program, command.origin.thread));
        if self.micro_points.giver != giver
            || self.micro_points.points.len() != usize::try_from(count).unwrap_or(usize::MAX)
        {
            return Err(self.other_line());
        }
        let line = if self.micro_points.are_poses {
            self.line_of_poses(interval)?
        } else {
            self.line_of_joints(interval)?
        };
        self.cells.clear();
        let planner = MicroLinePlanner::new(line, self.micro_points.points(), &self.arm())?;
        self.follow_with(
            (command.id, command.origin),
            MotionMode::MoveMl,
            Planned::Micro(planner),
        );
        Ok(Ending::Later)
    }

    /// The way of the joints through the points, exactly from where the arm is.
    fn line_of_joints(&mut self, interval: f64) -> Result<MicroLine, Refusal> {
        let start = self.next_start();
        if let Some(first) = self.micro_points.points.first_mut() {
            for joint in 0..6 {
                check_start((first[joint] - start[joint]).abs())?;
                first[joint] = start[joint];
            }
        }
        let line = MicroLine::of_joints(&self.micro_points.points, interval);
        let line = line.ok_or_else(|| self.too_few())?;
        // The points between are looked at while the motion is planned, a few a cycle.
        self.check_target(&line.end())?;
        Ok(line)
    }

    /// The way of the TCP through the points, exactly from where it is.
    fn line_of_poses(&mut self, interval: f64) -> Result<MicroLine, Refusal> {
        let start = self.next_start();
        let here = self.model.tcp_pose(&start, &self.flange_from_tcp);
        let line =
            |points: &[Sample]| MicroLine::of_tcp(points, interval, start, self.flange_from_tcp);
        let given = line(&self.micro_points.points).ok_or_else(|| self.too_few())?;
        if let Some(way) = given.tcp_way(&self.micro_points.points) {
            let first = way.pose(0.0);
            check_start((first.translation - here.translation).norm())?;
            check_start(first.rotation.angle_to(&here.rotation))?;
        }
        if let Some(first) = self.micro_points.points.first_mut() {
            *first = sample_of(&here, first);
        }
        Ok(given)
    }

    fn too_few(&self) -> Refusal {
        let value = self.micro_points.points.len() as f64;
        bad_value("the number of points", value, "at least 2")
    }
}

/// Lengths of a quaternion that stands for a rotation; what lies between two points is hardly shorter than they are.
const QUATERNION_LENGTH: core::ops::RangeInclusive<f64> = 0.5..=2.0;

fn check_start(away: f64) -> Result<(), Refusal> {
    if away > MICRO_START {
        let needed = "at most 0.0001 (m, rad)";
        return Err(bad_value("the way to the first point", away, needed));
    }
    Ok(())
}

/// A pose as a point, its quaternion of the length and the sign of `like`'s.
fn sample_of(pose: &Pose, like: &Sample) -> Sample {
    let turn = UnitQuaternion::from_rotation_matrix(&pose.rotation).into_inner();
    let [.., w, i, j, k] = *like;
    let along = w * turn.w + i * turn.i + j * turn.j + k * turn.k;
    let size = [w, i, j, k].iter().map(|x| x * x).sum::<f64>().sqrt();
    let turn = turn * size.copysign(along);
    let at = pose.translation;
    [at.x, at.y, at.z, turn.w, turn.i, turn.j, turn.k]
}
