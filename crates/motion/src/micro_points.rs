//! The points of a moveml: taken over as a handle when its command leaves the ring, kept until the next line begins.
//!
//! Lists are never changed and never freed here (see `motion_api::record_points`): where the arm stands takes the place
//! of the first point in the line, not in the list.

use std::sync::Arc;

use kinematics::{JointPositions, Pose};
use motion_api::{
    Command, CommandId, CommandKind, MotionCommand, MotionMode, OnlineCommand, PointList,
    PointListHandoff, Refusal, phrase,
};
use nalgebra::UnitQuaternion;
use rtrb::Consumer;

use crate::constants::{MAX_DURATION, MICRO_START, MIN_REQUESTED_RATE, TRAJECTORY_START};
use crate::cycle::{ControlLoop, Generator};
use crate::intake::{CommandResult, Completion, bad_value};
use crate::modes::trajectory::TrajectoryMode;
use crate::modes::{CallCompletion, OnlineMode, states};
use crate::path::{MicroLine, PointValues, TcpPath};
use crate::plan::MicroLinePlanner;
use crate::upcoming::PlanState;

/// The lists.
pub(crate) struct MicroPoints {
    incoming: Consumer<PointListHandoff>,
    /// Lists of commands that left the ring: of the one that waits for the arm to come to rest, and of the latest.
    arrived: [Option<PointListHandoff>; 2],
    /// The list of the line under way, or of the last one.
    current: Option<Arc<PointList>>,
}

impl MicroPoints {
    /// None yet.
    pub(crate) fn new(incoming: Consumer<PointListHandoff>) -> Self {
        Self {
            incoming,
            arrived: [None, None],
            current: None,
        }
    }

    /// The points of the line under way.
    pub(crate) fn points(&self) -> &[PointValues] {
        self.current.as_ref().map_or(&[], |list| list.samples())
    }

    /// The points that were handed over with a command, which is not the one that `waits`.
    fn receive(&mut self, id: CommandId, waits: CommandId) -> Option<&PointListHandoff> {
        let mut found = None;
        while let Ok(handed) = self.incoming.pop() {
            let is_it = handed.id == id;
            found = Some(handed).filter(|_| is_it);
            if is_it {
                break;
            }
        }
        let is_waiting =
            |slot: &Option<PointListHandoff>| slot.as_ref().is_some_and(|s| s.id == waits);
        let place = self.arrived.iter_mut().find(|slot| !is_waiting(slot))?;
        *place = found;
        place.as_ref()
    }

    /// The points of a command that begins: as many as it says, at a time between them that can be kept.
    fn take(
        &mut self,
        id: CommandId,
        count: u32,
        interval: f64,
    ) -> Result<Arc<PointList>, Refusal> {
        let slot = self.arrived.iter_mut();
        let mut slot = slot.filter_map(|slot| slot.take_if(|handed| handed.id == id));
        let list = slot.next().map(|handed| handed.points);
        if !(MIN_REQUESTED_RATE..=MAX_DURATION).contains(&interval) {
            return Err(bad_value(
                phrase!("the time between points", "点之间的时间"),
                interval,
                phrase!("0.000001 to 1000000 s", "0.000001 到 1000000 s"),
            ));
        }
        list.filter(|list| list.count() == count).ok_or_else(|| {
            bad_value(
                phrase!("the number of points", "点的数目"),
                f64::from(count),
                phrase!(
                    "that of the points handed over with it",
                    "随之交付的点的数目"
                ),
            )
        })
    }
}

impl ControlLoop {
    /// Takes over the points of a command that has left the ring.
    pub(crate) fn take_points(&mut self, command: &Command) {
        if !matches!(
            command.kind,
            CommandKind::Motion(MotionCommand::MoveMl { .. })
                | CommandKind::Online(OnlineCommand::FollowPoints { .. })
        ) {
            return;
        }
        let waits = self.deferred.map_or(CommandId::NONE, |waits| waits.id);
        if let Some(handed) = self.micro_points.receive(command.id, waits) {
            self.out.record_points(handed);
        }
    }

    /// Begins a moveml.
    pub(crate) fn moveml(&mut self, command: &Command, count: u32, interval: f64) -> CommandResult {
        let list = self.micro_points.take(command.id, count, interval)?;
        let line = if list.are_poses() {
            self.line_of_poses(list.samples(), interval)?
        } else {
            self.line_of_joints(list.samples(), interval)?
        };
        self.pending_limits.clear();
        let planner = MicroLinePlanner::new(line, list.samples(), &self.arm())?;
        self.micro_points.current = Some(list);
        self.enqueue_motion(
            (command.id, command.origin),
            MotionMode::MoveMl,
            PlanState::MicroLine(planner),
        );
        Ok(Completion::Deferred)
    }

    /// The way of the joints through the points, exactly from where the arm is.
    fn line_of_joints(&self, points: &[PointValues], interval: f64) -> Result<MicroLine, Refusal> {
        let start = self.next_start();
        let line = MicroLine::through_joint_positions(points, interval).ok_or_else(too_few)?;
        for joint in 0..6 {
            check_start((line.start()[joint] - start[joint]).abs())?;
        }
        let [.., unused] = line.first();
        let [a, b, c, d, e, f] = start.0;
        let line = line.beginning_at([a, b, c, d, e, f, unused], start);
        // The points between are looked at while the motion is planned, a few a cycle.
        self.check_target(&line.end())?;
        Ok(line)
    }

    /// The way of the TCP through the points, exactly from where it is.
    fn line_of_poses(&self, points: &[PointValues], interval: f64) -> Result<MicroLine, Refusal> {
        let start = self.next_start();
        let tool = *self.tool.flange_from_tcp();
        let here = self.model.tcp_pose(&start, &tool);
        let line =
            MicroLine::through_tcp_poses(points, interval, start, tool).ok_or_else(too_few)?;
        if let Some(way) = line.tcp_path(points) {
            let first = way.pose(0.0);
            check_start((first.translation - here.translation).norm())?;
            check_start(first.rotation.angle_to(&here.rotation))?;
        }
        Ok(line.beginning_at(sample_of(&here, &line.first()), start))
    }
}

impl ControlLoop {
    /// Begins to follow joint positions in time.
    pub(crate) fn follow_points(
        &mut self,
        command: &Command,
        count: u32,
        interval: f64,
    ) -> CommandResult {
        let list = self.micro_points.take(command.id, count, interval)?;
        if list.are_poses() {
            return Err(bad_value(
                phrase!("the kind of points", "点的类型"),
                1.0,
                phrase!("joint positions", "关节位置"),
            ));
        }
        let start = TrajectoryMode::start(list.samples());
        let away = (0..6).fold(0.0_f64, |most, joint| {
            most.max((start[joint] - self.target.q[joint]).abs())
        });
        if away > TRAJECTORY_START {
            let needed = phrase!("at most 0.1 rad", "不超过 0.1 rad");
            return Err(bad_value(
                phrase!("the way to the first point", "到第一个点的路程"),
                away,
                needed,
            ));
        }
        // The points between are the sender's to look at; the joints never leave their range whatever is asked.
        self.check_target(&end_of(list.samples()))?;
        let arm = self.online_arm();
        let before = match &self.generator {
            Generator::Online(online) => online.trajectory(),
            _ => None,
        };
        let now = states(&self.target);
        let mode = TrajectoryMode::new(list.samples(), interval, &now, &arm, before);
        self.micro_points.current = Some(list);
        let kind = OnlineMode::Trajectory(mode);
        self.begin_online(command, MotionMode::ServoJ, CallCompletion::OnGoal, kind);
        Ok(Completion::Deferred)
    }
}

fn end_of(samples: &[PointValues]) -> JointPositions {
    let [a, b, c, d, e, f, _] = samples.last().copied().unwrap_or_default();
    JointPositions([a, b, c, d, e, f])
}

fn too_few() -> Refusal {
    bad_value(
        phrase!("the number of points", "点的数目"),
        0.0,
        phrase!("at least 2", "至少 2"),
    )
}

fn check_start(away: f64) -> Result<(), Refusal> {
    if away > MICRO_START {
        let needed = phrase!("at most 0.0001 (m, rad)", "不超过 0.0001（m、rad）");
        return Err(bad_value(
            phrase!("the way to the first point", "到第一个点的路程"),
            away,
            needed,
        ));
    }
    Ok(())
}

/// A pose as a point, its quaternion of the length and the sign of `like`'s.
fn sample_of(pose: &Pose, like: &PointValues) -> PointValues {
    let turn = UnitQuaternion::from_rotation_matrix(&pose.rotation).into_inner();
    let [.., w, i, j, k] = *like;
    let along = w * turn.w + i * turn.i + j * turn.j + k * turn.k;
    let size = [w, i, j, k].iter().map(|x| x * x).sum::<f64>().sqrt();
    let turn = turn * size.copysign(along);
    let at = pose.translation;
    [at.x, at.y, at.z, turn.w, turn.i, turn.j, turn.k]
}
