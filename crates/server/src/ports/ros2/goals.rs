//! Goals of `FollowJointTrajectory` and trajectories of the topic: taken or refused, followed, ended.
//!
//! Owns which goal moves the arm. The arm follows the positions in its own cycle; here it is seen how that goes on, one
//! sample after the other.

use std::sync::Arc;

use elite_runtime::Robot;
use io_bus::ControlMode;
use kinematics::JointPositions;
use messages::text;
use motion_api::{
    CommandId, MachineCommand, MotionMode, Origin, Outcome, PointList, RobotMode, RobotState,
    SafetyMode, StopReason,
};
use ros2::link::{ControllerMessage, GoalEnd, GoalId};
use ros2::messages::{
    Duration, Header, JointTrajectory, JointTrajectoryPoint, Time, TrajectoryFeedback,
    TrajectoryGoal,
};
use ros2::names::JOINTS;
use ros2::trajectory::{
    ArmStart, Tolerances, TrajectoryError, TrajectoryLimits, Violation, check, code, sample,
};

use super::Ros2Backend;

/// Feedback comes so often, s: the driver's rate.
const FEEDBACK_INTERVAL: f64 = 0.05;
/// The arm has so long to come near enough to its goal where the goal does not say, s.
const GOAL_TIME_DEFAULT: f64 = 10.0;

/// What was told a goal that ended in another way than by its own.
const CANCELED: &str = "canceled";
const REPLACED: &str = "replaced by a new trajectory";

/// A trajectory that the arm follows.
struct RunningGoal {
    /// None: of the topic.
    id: Option<GoalId>,
    command: CommandId,
    goal: [f64; 6],
    tolerances: Tolerances,
    /// Time since the beginning, s.
    time: f64,
    next_feedback: f64,
    /// The reason for which the arm was told to stop, with how the goal ends then.
    stopping: Option<(GoalEnd, i32, String)>,
    /// The arm is at the end of the trajectory, for so long, s.
    arrived: Option<f64>,
    is_paused: bool,
}

/// The goal that moves the arm, if there is one.
pub(super) struct Goals {
    prefix: String,
    epoch: i64,
    running: Option<RunningGoal>,
}

impl Goals {
    pub(super) const fn new(prefix: String, epoch: i64) -> Self {
        Self {
            prefix,
            epoch,
            running: None,
        }
    }

    /// A new goal: taken, or refused, or taken and ended at once with a code and a text.
    pub(super) fn goal<B: Ros2Backend>(
        &mut self,
        id: GoalId,
        goal: &TrajectoryGoal,
        backend: &B,
        out: &mut Vec<ControllerMessage>,
    ) {
        if let Err(message) = self.may_move(backend) {
            out.push(ControllerMessage::GoalTaken {
                id,
                accepted: false,
                message,
            });
            return;
        }
        out.push(ControllerMessage::GoalTaken {
            id,
            accepted: true,
            message: String::new(),
        });
        let begun = self.begin(Some(id), goal, backend, out);
        if let Err((code, message)) = begun {
            out.push(ControllerMessage::GoalEnded {
                id,
                end: GoalEnd::Aborted,
                code,
                message,
            });
        }
    }

    /// A trajectory of the topic; what is wrong with it goes to the log.
    pub(super) fn trajectory<B: Ros2Backend>(
        &mut self,
        trajectory: JointTrajectory,
        backend: &B,
        out: &mut Vec<ControllerMessage>,
    ) {
        let may_move = self.may_move(backend);
        // A trajectory without points stops the one under way, as in ros2_control.
        if trajectory.points.is_empty() && self.running.is_some() {
            return self.stop_running(
                backend.robot(),
                (GoalEnd::Canceled, code::SUCCESSFUL, CANCELED),
            );
        }
        let goal = TrajectoryGoal {
            trajectory,
            ..TrajectoryGoal::default()
        };
        let begun = may_move
            .map_err(|text| (code::INVALID_GOAL, text))
            .and_then(|()| self.begin(None, &goal, backend, out));
        if let Err((_, text)) = begun {
            out.push(ControllerMessage::Log {
                level: 30,
                text: format!("the trajectory of the topic is not followed: {text}"),
            });
        }
    }

    /// Whether goals may move the arm now.
    fn may_move<B: Ros2Backend>(&self, backend: &B) -> Result<(), String> {
        if backend.control() == ControlMode::Local {
            return Err("the robot is in local control".to_owned());
        }
        let state = backend.robot().state();
        if state.robot_mode != RobotMode::Running
            || !matches!(state.safety_mode, SafetyMode::Normal | SafetyMode::Reduced)
        {
            return Err(format!(
                "the robot mode is {} and the safety mode {}; \
                 the arm moves only when they are RUNNING and NORMAL or REDUCED",
                state.robot_mode, state.safety_mode
            ));
        }
        let is_ours = self.running.as_ref().is_some_and(|running| {
            state.command_id == running.command || state.motion_mode == MotionMode::Idle
        });
        if !is_ours && !matches!(state.motion_mode, MotionMode::Idle) && self.running.is_none() {
            return Err(format!(
                "something else moves the arm ({})",
                state.motion_mode
            ));
        }
        Ok(())
    }

    fn begin<B: Ros2Backend>(
        &mut self,
        id: Option<GoalId>,
        goal: &TrajectoryGoal,
        backend: &B,
        out: &mut Vec<ControllerMessage>,
    ) -> Result<(), (i32, String)> {
        let told = |error: TrajectoryError| (error.code(), error.to_string());
        let (robot, description) = (backend.robot(), backend.description());
        let state = robot.state();
        let limits = TrajectoryLimits {
            positions: description.position_limits,
            speeds: description.speed_limits,
        };
        if !goal.multi_dof_trajectory.points.is_empty() {
            let what = text!(
                "a trajectory of joints with several degrees of freedom",
                "多自由度关节的轨迹"
            );
            return Err(told(TrajectoryError::Unsupported { what }));
        }
        let mut checked = check(&goal.trajectory, &self.prefix, &limits).map_err(told)?;
        let tolerances = Tolerances::of(goal, &self.prefix).map_err(told)?;
        let stamp = goal.trajectory.header.stamp.to_nanos();
        if stamp != 0 {
            let now = self.epoch + (state.time * 1e9).round() as i64;
            let late = (now - stamp) as f64 * 1e-9;
            checked = checked.begun_before(late, state.target_q.0).map_err(told)?;
        }
        // The command is taken a cycle later; what is between then is made good by the arm.
        let step = state.step_time;
        let start = ArmStart {
            position: std::array::from_fn(|joint| {
                state.target_q[joint] + step * state.target_qd[joint]
            }),
            speed: state.target_qd.0,
            accelerations: description.acceleration_limits,
        };
        let sampled = sample(&checked, &start, &limits, step).map_err(told)?;
        let points: Vec<JointPositions> = sampled
            .positions
            .iter()
            .map(|q| JointPositions(*q))
            .collect();
        let end = points.last().map_or(state.target_q.0, |last| last.0);
        let list = PointList::from_joint_positions(&points)
            .map_err(|refusal| (code::INVALID_GOAL, refusal.to_string()))?;
        let command = robot
            .request_trajectory(Origin::default(), &Arc::new(list), sampled.interval)
            .map_err(|full| (code::INVALID_GOAL, full.to_string()))?;
        let before = self.running.replace(RunningGoal {
            id,
            command,
            goal: end,
            tolerances,
            time: 0.0,
            next_feedback: 0.0,
            stopping: None,
            arrived: None,
            is_paused: false,
        });
        if let Some(before) = before {
            // Nobody asks any more how that command ends.
            robot.forget(before.command);
            let (end, code, message) = before.stopping.clone().unwrap_or((
                GoalEnd::Canceled,
                code::INVALID_GOAL,
                REPLACED.to_owned(),
            ));
            before.tell_end(end, code, message, out);
        }
        Ok(())
    }

    /// Goals are to be canceled: the arm brakes on its way.
    pub(super) fn cancel(&mut self, ids: &[GoalId], robot: &Robot) {
        let is_meant = |running: &RunningGoal| running.id.is_some_and(|id| ids.contains(&id));
        if self.running.as_ref().is_some_and(is_meant) {
            self.stop_running(robot, (GoalEnd::Canceled, code::SUCCESSFUL, CANCELED));
        }
    }

    fn stop_running(&mut self, robot: &Robot, (end, code, why): (GoalEnd, i32, &str)) {
        if let Some(running) = &mut self.running
            && running.stopping.is_none()
        {
            running.stopping = Some((end, code, why.to_owned()));
            let only = running.command;
            if let Err(full) = robot.send(Origin::default(), MachineCommand::Stop { only }) {
                tracing::warn!("a goal of ROS 2 is not stopped: {full}");
                running.stopping = None;
            }
        }
    }

    /// Nobody follows the goal any more: the arm brakes on its way.
    pub(super) fn abandon(&mut self, robot: &Robot) {
        self.stop_running(
            robot,
            (GoalEnd::Aborted, code::INVALID_GOAL, "the node is gone"),
        );
        if let Some(running) = self.running.take() {
            robot.forget(running.command);
        }
    }

    /// A goal moves the arm, or is held.
    pub(super) const fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// Notes whether the goal is held; false when it was before.
    pub(super) fn set_paused(&mut self, paused: bool) -> bool {
        match &mut self.running {
            Some(running) => std::mem::replace(&mut running.is_paused, paused) != paused,
            None => false,
        }
    }

    /// Ends the goal, as `stop` of the dashboard does a task.
    pub(super) fn stop(&mut self, robot: &Robot) {
        self.stop_running(
            robot,
            (
                GoalEnd::Aborted,
                code::INVALID_GOAL,
                "stopped by dashboard_client/stop",
            ),
        );
    }

    /// A cycle has passed.
    pub(super) fn cycle(
        &mut self,
        state: &RobotState,
        robot: &Robot,
        out: &mut Vec<ControllerMessage>,
    ) {
        let Some(running) = &mut self.running else {
            return;
        };
        running.time += state.step_time;
        let actual = &state.actual_q.0;
        if let Some(since) = &mut running.arrived {
            *since += state.step_time;
            let away = difference(&running.goal, actual);
            let violation = running.tolerances.goal_violation(&away, &state.actual_qd.0);
            let patience = running.tolerances.time.unwrap_or(GOAL_TIME_DEFAULT);
            let end = match violation {
                None => Some((GoalEnd::Succeeded, code::SUCCESSFUL, String::new())),
                Some(violation) if *since > patience => Some((
                    GoalEnd::Aborted,
                    code::GOAL_TOLERANCE_VIOLATED,
                    sentence(&violation, "its goal"),
                )),
                Some(_) => None,
            };
            if let Some((end, code, message)) = end
                && let Some(running) = self.running.take()
            {
                running.tell_end(end, code, message, out);
            }
            return;
        }
        if let Some(outcome) = robot.take_outcome(running.command) {
            return self.command_ended(&outcome, robot, out);
        }
        let away = difference(&state.target_q.0, actual);
        if running.time >= running.next_feedback {
            running.next_feedback = running.time + FEEDBACK_INTERVAL;
            if let Some(id) = running.id {
                let feedback = feedback(state, running.time, (&self.prefix, self.epoch));
                out.push(ControllerMessage::Feedback { id, feedback });
            }
        }
        let stop = if state.safety_mode == SafetyMode::SafeguardStop {
            Some((
                code::PATH_TOLERANCE_VIOLATED,
                "a safeguard stop holds the arm".to_owned(),
            ))
        } else {
            let violation = running.tolerances.path_violation(&away);
            violation.map(|violation| {
                (
                    code::PATH_TOLERANCE_VIOLATED,
                    sentence(&violation, "its way"),
                )
            })
        };
        if let Some((code, why)) = stop {
            self.stop_running(robot, (GoalEnd::Aborted, code, &why));
        }
    }

    fn command_ended(
        &mut self,
        outcome: &Outcome,
        robot: &Robot,
        out: &mut Vec<ControllerMessage>,
    ) {
        let Some(running) = &mut self.running else {
            return;
        };
        let stopped = running.stopping.take();
        let (end, code, message) = match outcome {
            Outcome::Done if stopped.is_none() => {
                running.arrived = Some(0.0);
                return;
            }
            Outcome::Done => (GoalEnd::Succeeded, code::SUCCESSFUL, String::new()),
            Outcome::Refused(refusal) => (
                GoalEnd::Aborted,
                code::INVALID_GOAL,
                robot.sentence(refusal).to_string(),
            ),
            Outcome::ProtectiveStop(reason @ StopReason::EmergencyStop) => (
                GoalEnd::Aborted,
                code::PATH_TOLERANCE_VIOLATED,
                robot.sentence(reason).to_string(),
            ),
            Outcome::ProtectiveStop(reason) => (
                GoalEnd::Aborted,
                code::PATH_TOLERANCE_VIOLATED,
                format!("protective stop: {}", robot.sentence(reason)),
            ),
            Outcome::Aborted => stopped.unwrap_or_else(|| {
                // The state of the cycle that ended the command is there before its end is told.
                let (code, message) = reason_of_stop(&robot.state());
                (GoalEnd::Aborted, code, message)
            }),
        };
        if let Some(running) = self.running.take() {
            running.tell_end(end, code, message, out);
        }
    }
}

impl RunningGoal {
    fn tell_end(&self, end: GoalEnd, code: i32, message: String, out: &mut Vec<ControllerMessage>) {
        if let Some(id) = self.id {
            out.push(ControllerMessage::GoalEnded {
                id,
                end,
                code,
                message,
            });
        }
    }
}

/// The code and the text for a goal whose command the controller has ended, by the state it is in since.
fn reason_of_stop(state: &RobotState) -> (i32, String) {
    let (robot_mode, safety_mode) = (state.robot_mode, state.safety_mode);
    if robot_mode == RobotMode::Running && safety_mode.allows_motion() {
        return (
            code::INVALID_GOAL,
            "something else stopped the arm".to_owned(),
        );
    }
    (
        code::PATH_TOLERANCE_VIOLATED,
        format!("the robot mode is {robot_mode} and the safety mode {safety_mode}"),
    )
}

fn difference(wanted: &[f64; 6], actual: &[f64; 6]) -> [f64; 6] {
    std::array::from_fn(|joint| wanted[joint] - actual[joint])
}

fn sentence(violation: &Violation, from: &str) -> String {
    let Violation {
        joint,
        away,
        allowed,
    } = violation;
    format!("{joint} is {away:.4} away from {from}, {allowed:.4} is allowed")
}

fn feedback(state: &RobotState, time: f64, (prefix, epoch): (&str, i64)) -> TrajectoryFeedback {
    let point =
        |positions: [f64; 6], velocities: [f64; 6], accelerations: Vec<f64>| JointTrajectoryPoint {
            positions: positions.into(),
            velocities: velocities.into(),
            accelerations,
            effort: Vec::new(),
            time_from_start: Duration::from_secs(time),
        };
    let (wanted, actual) = (&state.target_q.0, &state.actual_q.0);
    let (wanted_speed, speed) = (&state.target_qd.0, &state.actual_qd.0);
    TrajectoryFeedback {
        header: Header {
            stamp: Time::from_nanos(epoch + (state.time * 1e9).round() as i64),
            frame_id: String::new(),
        },
        joint_names: JOINTS.map(|name| format!("{prefix}{name}")).into(),
        desired: point(*wanted, *wanted_speed, state.target_qdd.0.into()),
        actual: point(*actual, *speed, Vec::new()),
        error: point(
            difference(wanted, actual),
            difference(wanted_speed, speed),
            Vec::new(),
        ),
        ..TrajectoryFeedback::default()
    }
}
