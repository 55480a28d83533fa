//! The topics that go out.

use ros2_client::qos::{Durability, QosProfile, WhenFull};
use ros2_client::{Publisher, WriteResult};

use super::{NodeBuilder, NodeError, stream};
use crate::link::NodeSetup;
use crate::messages::{
    Bool, Clock, Float64, IoState, JointState, PoseStamped, RosRobotMode, RosSafetyMode, Text,
    TfMessage, Time, ToolData, WrenchStamped,
};
use crate::names::topic;
use crate::sample::{NodeSample, fixed_frames};

/// What comes on change only is repeated after so many nanoseconds, for those who came since.
const REPEAT_AFTER: i64 = 1_000_000_000;

/// Every publisher, with what was published last where only changes are.
pub(super) struct Publishers {
    prefix: String,
    joint_states: Publisher<JointState>,
    tf: Publisher<TfMessage>,
    wrench: Publisher<WrenchStamped>,
    tcp_pose: Publisher<PoseStamped>,
    speed_scaling: Publisher<Float64>,
    io_states: Publisher<IoState>,
    tool_data: Publisher<ToolData>,
    robot_mode: Publisher<RosRobotMode>,
    safety_mode: Publisher<RosSafetyMode>,
    task_running: Publisher<Bool>,
    clock: Option<Publisher<Clock>>,
    /// Modes and task of the last time they were published, with that time.
    modes: Option<(i64, [i8; 2], bool)>,
    /// Writers of what was published once, which late subscribers read.
    _latched: (Publisher<Text>, Publisher<TfMessage>),
}

const fn latched(depth: usize) -> QosProfile {
    stream(depth).durability(Durability::TransientLocal)
}

impl Publishers {
    pub(super) fn new(node: &mut NodeBuilder, setup: &NodeSetup) -> Result<Self, NodeError> {
        let description = node.publisher::<Text>(topic::ROBOT_DESCRIPTION, latched(1))?;
        let tf_static = node.publisher::<TfMessage>(topic::TF_STATIC, latched(1))?;
        let text = Text {
            data: setup.urdf.clone(),
        };
        let fixed = fixed_frames(&setup.prefix, &setup.flange_in_wrist, Time::default());
        let published = |result: Result<(), String>| result.map_err(NodeError::Dds);
        published(description.publish(text).map_err(|e| e.to_string()))?;
        published(tf_static.publish(fixed).map_err(|e| e.to_string()))?;
        Ok(Self {
            prefix: setup.prefix.clone(),
            joint_states: node.publisher(topic::JOINT_STATES, stream(10))?,
            tf: node.publisher(topic::TF, stream(100))?,
            wrench: node.publisher(topic::WRENCH, stream(10))?,
            tcp_pose: node.publisher(topic::TCP_POSE, stream(10))?,
            speed_scaling: node.publisher(topic::SPEED_SCALING, stream(10))?,
            io_states: node.publisher(topic::IO_STATES, stream(10))?,
            tool_data: node.publisher(topic::TOOL_DATA, stream(10))?,
            robot_mode: node.publisher(topic::ROBOT_MODE, latched(1))?,
            safety_mode: node.publisher(topic::SAFETY_MODE, latched(1))?,
            task_running: node.publisher(topic::TASK_RUNNING, latched(1))?,
            clock: match setup.simulated_time {
                // Time waits a little for those who follow it.
                true => Some(node.publisher(
                    topic::CLOCK,
                    stream(100).reliability_reliable(WhenFull::DEFAULT),
                )?),
                false => None,
            },
            modes: None,
            _latched: (description, tf_static),
        })
    }

    /// Publishes a cycle. What a subscriber does not take in time is lost for it and for nobody else.
    pub(super) fn publish(&mut self, sample: &NodeSample) {
        let prefix = &self.prefix;
        // Time first: whoever waits for a moment finds its data right behind it.
        if let Some(clock) = &self.clock {
            sent(clock.publish(sample.clock()));
        }
        sent(self.joint_states.publish(sample.joint_state(prefix)));
        sent(self.tf.publish(sample.moving_frames(prefix)));
        sent(self.wrench.publish(sample.wrench_stamped(prefix)));
        sent(self.tcp_pose.publish(sample.tcp_pose(prefix)));
        sent(self.speed_scaling.publish(sample.speed_scaling()));
        sent(self.io_states.publish(sample.io_state()));
        sent(self.tool_data.publish(sample.tool_data()));
        self.publish_modes(sample);
    }

    fn publish_modes(&mut self, sample: &NodeSample) {
        let modes = [sample.robot_mode, sample.safety_mode];
        let running = sample.task_running;
        let is_due = self.modes.is_none_or(|(at, before, ran)| {
            before != modes || ran != running || sample.stamp - at >= REPEAT_AFTER
        });
        if is_due {
            self.modes = Some((sample.stamp, modes, running));
            sent(self.robot_mode.publish(sample.robot_mode()));
            sent(self.safety_mode.publish(sample.safety_mode()));
            sent(self.task_running.publish(sample.task_running()));
        }
    }
}

/// A full window is a subscriber that does not read; the next message is for all again.
fn sent<M>(result: WriteResult<(), M>) {
    drop(result);
}
