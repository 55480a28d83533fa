//! The action server of `FollowJointTrajectory`: the protocol of goals, on the low-level parts of the DDS crate.
//!
//! Whether a goal is taken, how it is getting on and how it ends is the controller's to say; here are numbers of
//! goals, their status, and who waits for their results.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use ros2_client::action::{
    ActionServer, ActionServerQosPolicies, GetResultResponse, GoalId as RosGoalId, GoalInfo,
    GoalStatusEnum, SendGoalResponse,
};
use ros2_client::action_msgs::{
    CancelGoalResponse, CancelGoalResponseEnum, GoalStatus, GoalStatusArray,
};
use ros2_client::builtin_interfaces::Time as RosTime;
use ros2_client::qos::Durability;
use ros2_client::{ActionTypeName, RmwRequestId};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{NodeBuilder, NodeError, service, stream};
use crate::link::{GoalEnd, GoalId, NodeMessage};
use crate::messages::{TrajectoryFeedback, TrajectoryGoal, TrajectoryResult};
use crate::names::FOLLOW_JOINT_TRAJECTORY;

/// A result is kept so long for a client that asks late.
const KEPT_FOR: Duration = Duration::from_secs(180);
/// Most results that are kept.
const KEPT_MAX: usize = 256;
/// Most goals that wait for the controller's word, or are under way.
const ACTIVE_MAX: usize = 64;
/// Most clients that wait for the result of one goal.
const WAITING_MAX: usize = 64;

struct GoalRecord {
    accepted_at: RosTime,
    status: GoalStatusEnum,
    result: TrajectoryResult,
    ended_at: Option<Instant>,
    waiting: Vec<RmwRequestId>,
}

/// The action server.
pub(super) struct TrajectoryAction {
    server: ActionServer<TrajectoryGoal, TrajectoryResult, TrajectoryFeedback>,
    asked: BTreeMap<GoalId, RmwRequestId>,
    goals: BTreeMap<GoalId, GoalRecord>,
}

/// The number of a goal in the type of the DDS crate, whose parts have no constructor: both are 16 bytes.
fn recode<A: Serialize, B: DeserializeOwned>(value: &A) -> Option<B> {
    let bytes = cdr_encoding::to_vec::<A, byteorder::LittleEndian>(value).ok()?;
    let read = cdr_encoding::from_bytes::<B, byteorder::LittleEndian>(&bytes);
    read.ok().map(|(value, _)| value)
}

fn ros_id(id: GoalId) -> RosGoalId {
    recode(&id).unwrap_or(RosGoalId::ZERO)
}

fn own_id(id: &RosGoalId) -> GoalId {
    recode(id).unwrap_or_default()
}

impl TrajectoryAction {
    pub(super) fn new(node: &mut NodeBuilder) -> Result<Self, NodeError> {
        let qos = ActionServerQosPolicies {
            goal_service: service(),
            result_service: service(),
            cancel_service: service(),
            feedback_publisher: stream(10),
            status_publisher: stream(1).durability(Durability::TransientLocal),
        };
        let name = node.name(FOLLOW_JOINT_TRAJECTORY)?;
        let server = node.node.create_action_server(
            node.mapping,
            &name,
            &ActionTypeName::new("control_msgs", "FollowJointTrajectory"),
            qos,
        )?;
        Ok(Self {
            server,
            asked: BTreeMap::new(),
            goals: BTreeMap::new(),
        })
    }

    /// Takes up goals, cancellations and questions for results.
    pub(super) fn poll(&mut self, out: &mut Vec<NodeMessage>) {
        while let Ok(Some((request, asked))) = self.server.receive_goal() {
            let id = own_id(&asked.goal_id);
            let is_new = !self.goals.contains_key(&id) && !self.asked.contains_key(&id);
            let active = self.goals.values().filter(|g| g.ended_at.is_none()).count();
            if is_new && active + self.asked.len() < ACTIVE_MAX {
                self.asked.insert(id, request);
                let goal = asked.goal;
                out.push(NodeMessage::Goal { id, goal });
            } else {
                self.respond(request, false, RosTime::ZERO);
            }
        }
        while let Ok(Some((request, asked))) = self.server.receive_cancel_request() {
            if let Some(info) = recode::<_, GoalInfo>(&asked) {
                let (response, ids) = self.cancel(&info);
                // A client that has gone is told nothing, here and below.
                let _ = self.server.send_cancel_response(request, response);
                if !ids.is_empty() {
                    self.publish_status();
                    out.push(NodeMessage::Cancel { ids });
                }
            }
        }
        while let Ok(Some((request, asked))) = self.server.receive_result_request() {
            match self.goals.get_mut(&own_id(&asked.goal_id)) {
                Some(goal) if goal.ended_at.is_some() => {
                    let (status, result) = (goal.status, goal.result.clone());
                    let _ = self
                        .server
                        .send_result(request, GetResultResponse { status, result });
                }
                Some(goal) if goal.waiting.len() < WAITING_MAX => goal.waiting.push(request),
                _ => {
                    let unknown = GetResultResponse {
                        status: GoalStatusEnum::Unknown,
                        result: TrajectoryResult::default(),
                    };
                    let _ = self.server.send_result(request, unknown);
                }
            }
        }
        self.forget();
    }

    /// What action_msgs/CancelGoal says: one goal, all of them, or those of before a moment.
    fn cancel(&mut self, info: &GoalInfo) -> (CancelGoalResponse, Vec<GoalId>) {
        let id = own_id(&info.goal_id);
        let (has_id, before) = (id != [0; 16], info.stamp.to_nanos());
        let is_meant = |known: &GoalId, goal: &GoalRecord| match (has_id, before) {
            (true, 0) => *known == id,
            (false, 0) => true,
            (true, _) => *known == id || goal.accepted_at.to_nanos() <= before,
            (false, _) => goal.accepted_at.to_nanos() <= before,
        };
        let mut ids = Vec::new();
        let mut infos = Vec::new();
        for (known, goal) in &mut self.goals {
            let is_active = goal.ended_at.is_none() && goal.status != GoalStatusEnum::Canceling;
            if is_active && is_meant(known, goal) {
                goal.status = GoalStatusEnum::Canceling;
                ids.push(*known);
                infos.push(GoalInfo {
                    goal_id: ros_id(*known),
                    stamp: goal.accepted_at,
                });
            }
        }
        let return_code = match (ids.is_empty(), self.goals.get(&id)) {
            (false, _) => CancelGoalResponseEnum::None,
            (true, None) if has_id => CancelGoalResponseEnum::UnknownGoal,
            (true, Some(goal)) if goal.ended_at.is_some() => CancelGoalResponseEnum::GoalTerminated,
            (true, _) => CancelGoalResponseEnum::Rejected,
        };
        let response = CancelGoalResponse {
            return_code,
            goals_canceling: infos,
        };
        (response, ids)
    }

    fn respond(&self, request: RmwRequestId, accepted: bool, stamp: RosTime) {
        let response = SendGoalResponse { accepted, stamp };
        let _ = self.server.send_goal_response(request, response);
    }

    /// The controller takes a goal, or does not.
    pub(super) fn taken(&mut self, id: GoalId, accepted: bool) {
        let Some(request) = self.asked.remove(&id) else {
            return;
        };
        let accepted_at = RosTime::now();
        if accepted {
            let record = GoalRecord {
                accepted_at,
                status: GoalStatusEnum::Executing,
                result: TrajectoryResult::default(),
                ended_at: None,
                waiting: Vec::new(),
            };
            self.goals.insert(id, record);
            self.publish_status();
        }
        self.respond(request, accepted, accepted_at);
    }

    /// Goals brake because a client asked for it.
    pub(super) fn canceling(&mut self, ids: &[GoalId]) {
        for id in ids {
            if let Some(goal) = self.goals.get_mut(id)
                && goal.ended_at.is_none()
            {
                goal.status = GoalStatusEnum::Canceling;
            }
        }
        self.publish_status();
    }

    pub(super) fn feedback(&self, id: GoalId, feedback: TrajectoryFeedback) {
        let _ = self.server.send_feedback(ros_id(id), feedback);
    }

    /// A goal has ended: whoever waits for its result has it.
    pub(super) fn ended(&mut self, id: GoalId, end: GoalEnd, code: i32, message: String) {
        let Some(goal) = self.goals.get_mut(&id) else {
            return;
        };
        goal.status = match end {
            GoalEnd::Succeeded => GoalStatusEnum::Succeeded,
            GoalEnd::Canceled => GoalStatusEnum::Canceled,
            GoalEnd::Aborted => GoalStatusEnum::Aborted,
        };
        goal.result = TrajectoryResult {
            error_code: code,
            error_string: message,
        };
        goal.ended_at = Some(Instant::now());
        let (status, result) = (goal.status, goal.result.clone());
        let waiting = std::mem::take(&mut goal.waiting);
        // Status before result: a client that has the result finds the goal ended.
        self.publish_status();
        for request in waiting {
            let result = result.clone();
            let _ = self
                .server
                .send_result(request, GetResultResponse { status, result });
        }
    }

    fn publish_status(&self) {
        let status = |(id, goal): (&GoalId, &GoalRecord)| GoalStatus {
            goal_info: GoalInfo {
                goal_id: ros_id(*id),
                stamp: goal.accepted_at,
            },
            status: goal.status,
        };
        let status_list = self.goals.iter().map(status).collect();
        let _ = self
            .server
            .send_goal_statuses(GoalStatusArray { status_list });
    }

    /// Old results, the oldest first where there are too many.
    fn forget(&mut self) {
        self.goals
            .retain(|_, goal| goal.ended_at.is_none_or(|at| at.elapsed() < KEPT_FOR));
        while self.goals.len() > KEPT_MAX + ACTIVE_MAX {
            let ended = self
                .goals
                .iter()
                .filter_map(|(id, g)| Some((g.ended_at?, *id)));
            let Some((_, oldest)) = ended.min() else {
                return;
            };
            self.goals.remove(&oldest);
        }
    }
}
