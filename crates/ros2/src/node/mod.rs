//! The process of the node: what DDS brings in goes to the controller, what the controller says goes out.
//!
//! One loop on one thread: frames of the link, then every service, the action and the topic that comes in, whichever
//! has something. Decides nothing about the robot. The DDS stack has threads of its own; whatever it does to this
//! process, the controller only sees a link that ends.

mod action;
mod parameters;
mod publishers;
mod reader;
mod services;

use std::io::{self, Read, Write};
use std::net::IpAddr;

use messages::Localized;
use ros2_client::dds::rustdds::DomainParticipantBuilder;
use ros2_client::qos::{History, WhenFull};
use ros2_client::{
    Context, CreateError, MessageTypeName, Name, Node, NodeCreateError, NodeName, NodeOptions,
    QosProfile, ServiceMapping, Subscription,
};
use thiserror::Error;

use crate::link::{self, ControllerMessage, LinkError, NodeMessage, NodeSetup, VERSION};
use crate::messages::JointTrajectory;
use crate::names::{self, topic};
use action::TrajectoryAction;
use parameters::ParameterServices;
use publishers::Publishers;
use reader::FrameReader;
use services::Services;

/// Samples that are published although newer ones are there; older ones of a longer queue are left out.
const SAMPLES_BEHIND_MAX: usize = 16;

/// The reason for which the node ended.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum NodeError {
    /// The link does not work.
    #[error("the link to the controller: {0}")]
    #[zh("与控制器的链接：{0}")]
    Io(#[from] io::Error),
    /// The controller says what cannot be read.
    #[error("the link to the controller: {0}")]
    #[zh("与控制器的链接：{0}")]
    Link(#[from] LinkError),
    /// The controller does not begin with what the node is to be.
    #[error("the controller does not say what the node is to be")]
    #[zh("控制器没有说明节点的设置")]
    NoSetup,
    /// DDS does not start.
    #[error("the DDS stack: {0}")]
    #[zh("DDS 协议栈：{0}")]
    Dds(String),
    /// An address is none.
    #[error("{given:?} is no address of an interface")]
    #[zh("{given:?} 不是网络接口的地址")]
    Address {
        /// The address as given.
        given: String,
    },
    /// Sockets cannot be kept on this machine.
    #[error("the sockets cannot be held to the loopback interface: {0}")]
    #[zh("无法把套接字限制在回环接口：{0}")]
    Loopback(io::Error),
}

impl From<CreateError> for NodeError {
    fn from(error: CreateError) -> Self {
        Self::Dds(error.to_string())
    }
}

impl From<NodeCreateError> for NodeError {
    fn from(error: NodeCreateError) -> Self {
        Self::Dds(error.to_string())
    }
}

/// What the system does for the process of the node.
pub struct NodeHost {
    /// Limits the memory of this process, bytes.
    pub limit_memory: fn(u64) -> io::Result<()>,
    /// Holds every UDP socket of this process to the loopback interface.
    pub hold_to_loopback: fn() -> io::Result<()>,
}

/// Runs a node until the controller ends the link. A read of `link` must come back at least every 5 ms, with
/// [`WouldBlock`](io::ErrorKind::WouldBlock) or [`TimedOut`](io::ErrorKind::TimedOut) when nothing came.
///
/// # Errors
/// [`NodeError`]
pub fn run(link: impl Read + Write, host: &NodeHost) -> Result<(), NodeError> {
    let mut frames = FrameReader::new(link);
    let setup = loop {
        match frames.next::<ControllerMessage>()? {
            Some(ControllerMessage::Setup(setup)) => break setup,
            Some(_) => return Err(NodeError::NoSetup),
            None if frames.is_closed() => return Ok(()),
            None => {}
        }
    };
    if setup.version != VERSION {
        let theirs = setup.version;
        return Err(LinkError::Version { theirs }.into());
    }
    (host.limit_memory)(setup.memory_max)?;
    let mut running = RunningNode::start(&setup, host)?;
    frames.send(&NodeMessage::Ready { version: VERSION })?;
    running.serve(&mut frames)
}

/// QoS of the driver's topics: reliable, the newest kept. Nobody is waited for.
const fn stream(depth: usize) -> QosProfile {
    QosProfile::publisher_default()
        .reliability_reliable(WhenFull::Fail)
        .history(History::KeepLast { depth })
}

/// QoS of services.
const fn service() -> QosProfile {
    stream(16)
}

/// Creates what belongs to the node, with names below its namespace unless they begin with a slash.
struct NodeBuilder {
    node: Node,
    /// With a slash before each part and none behind; empty for the root.
    namespace: String,
    mapping: ServiceMapping,
}

impl NodeBuilder {
    /// The whole name: the crate joins a relative one to the root namespace with two slashes.
    fn name(&self, path: &str) -> Result<Name, NodeError> {
        let whole = match path.starts_with('/') {
            true => path.to_owned(),
            false => format!("{}/{path}", self.namespace),
        };
        Name::parse(&whole).map_err(|error| NodeError::Dds(format!("{whole}: {error:?}")))
    }

    fn publisher<M: crate::messages::Message>(
        &mut self,
        path: &str,
        qos: QosProfile,
    ) -> Result<ros2_client::Publisher<M>, NodeError> {
        let kind = MessageTypeName::new(M::PACKAGE, M::NAME);
        let topic = self.node.create_topic(&self.name(path)?, kind, &qos)?;
        Ok(self.node.create_publisher(&topic, Some(qos))?)
    }

    fn subscription<M: crate::messages::Message + 'static>(
        &mut self,
        path: &str,
        qos: QosProfile,
    ) -> Result<Subscription<M>, NodeError> {
        let kind = MessageTypeName::new(M::PACKAGE, M::NAME);
        let topic = self.node.create_topic(&self.name(path)?, kind, &qos)?;
        Ok(self.node.create_subscription(&topic, Some(qos))?)
    }
}

struct RunningNode {
    simulated_time: bool,
    publishers: Publishers,
    services: Services,
    parameters: ParameterServices,
    action: TrajectoryAction,
    trajectories: Subscription<JointTrajectory>,
    builder: NodeBuilder,
}

impl RunningNode {
    fn start(setup: &NodeSetup, host: &NodeHost) -> Result<Self, NodeError> {
        let mut builder = DomainParticipantBuilder::new(setup.domain)
            // What a datagram of some stranger may make the system hold for this process.
            .socket_receive_buffer_size(1 << 20)
            .socket_send_buffer_size(1 << 20)
            .same_host_loopback(true);
        if !setup.networks.is_empty() {
            let address = |given: &String| {
                given.parse::<IpAddr>().map_err(|_| NodeError::Address {
                    given: given.clone(),
                })
            };
            let networks: Result<Vec<IpAddr>, NodeError> =
                setup.networks.iter().map(address).collect();
            builder = builder.with_only_networks(networks?);
        }
        let participant = builder
            .build()
            .map_err(|error| NodeError::Dds(error.to_string()))?;
        if setup.loopback_only {
            (host.hold_to_loopback)().map_err(NodeError::Loopback)?;
        }
        let context = Context::from_domain_participant(participant)?;
        let name = NodeName::new(&setup.namespace, names::NODE)
            .map_err(|error| NodeError::Dds(format!("{}: {error:?}", setup.namespace)))?;
        let options = NodeOptions::new().start_parameter_services(false);
        let mut builder = NodeBuilder {
            node: context.new_node(name, options)?,
            namespace: setup.namespace.trim_end_matches('/').to_owned(),
            mapping: match setup.cyclone {
                true => ServiceMapping::Cyclone,
                false => ServiceMapping::Enhanced,
            },
        };
        let running = Self {
            simulated_time: setup.simulated_time,
            publishers: Publishers::new(&mut builder, setup)?,
            services: Services::new(&mut builder)?,
            parameters: ParameterServices::new(&mut builder, setup)?,
            action: TrajectoryAction::new(&mut builder)?,
            trajectories: builder.subscription(topic::JOINT_TRAJECTORY, stream(1))?,
            builder,
        };
        if setup.loopback_only {
            // Whatever DDS has opened since.
            (host.hold_to_loopback)().map_err(NodeError::Loopback)?;
        }
        Ok(running)
    }

    fn serve<L: Read + Write>(&mut self, frames: &mut FrameReader<L>) -> Result<(), NodeError> {
        let mut samples = Vec::new();
        loop {
            // The first look waits for a frame, the next ones take what is there.
            while let Some(frame) = frames.next::<ControllerMessage>()? {
                match frame {
                    ControllerMessage::Sample(sample) => samples.push(sample),
                    ControllerMessage::Answer {
                        request,
                        success,
                        message,
                    } => self.services.answer(request, success, message),
                    ControllerMessage::GoalTaken {
                        id,
                        accepted,
                        message,
                    } => {
                        if !accepted {
                            self.log(30, &format!("a goal is rejected: {message}"));
                        }
                        self.action.taken(id, accepted);
                    }
                    ControllerMessage::Canceling { ids } => self.action.canceling(&ids),
                    ControllerMessage::Feedback { id, feedback } => {
                        self.action.feedback(id, feedback)
                    }
                    ControllerMessage::GoalEnded {
                        id,
                        end,
                        code,
                        message,
                    } => self.action.ended(id, end, code, message),
                    ControllerMessage::Log { level, text } => self.log(level, &text),
                    ControllerMessage::End => return Ok(()),
                    ControllerMessage::Setup(_) => return Err(NodeError::NoSetup),
                }
                if !frames.has_buffered() {
                    break;
                }
            }
            if frames.is_closed() {
                return Ok(());
            }
            let mut out = Vec::new();
            if self.simulated_time && !samples.is_empty() {
                // The controller may be no further ahead than what is published.
                let samples = samples.len() as u32;
                out.push(NodeMessage::Shown { samples });
            }
            let skipped = samples.len().saturating_sub(SAMPLES_BEHIND_MAX);
            for sample in samples.drain(..).skip(skipped) {
                self.publishers.publish(&sample);
            }
            self.services.poll(&mut out);
            self.parameters.poll();
            self.action.poll(&mut out);
            while let Ok(Some((trajectory, _))) = self.trajectories.take() {
                out.push(NodeMessage::Trajectory(trajectory));
            }
            for message in out {
                match link::frame(&message) {
                    Ok(bytes) => frames.write(&bytes)?,
                    // Longer than any trajectory that would be taken.
                    Err(LinkError::TooLong { bytes }) => self.refuse_long(&message, bytes),
                    Err(error) => return Err(error.into()),
                }
            }
        }
    }

    /// Refuses what is too long for the link in the place of the controller.
    fn refuse_long(&mut self, message: &NodeMessage, bytes: usize) {
        let text = format!(
            "a message of {bytes} bytes is longer than the {} that are taken",
            link::FRAME_MAX
        );
        self.log(30, &text);
        if let NodeMessage::Goal { id, .. } = message {
            self.action.taken(*id, true);
            self.action.ended(*id, link::GoalEnd::Aborted, -1, text);
        }
    }

    fn log(&self, level: u8, text: &str) {
        use ros2_client::log::LogLevel;
        use ros2_client::rosout::RosoutRaw as _;
        let level = match level {
            ..=20 => LogLevel::Info,
            21..=30 => LogLevel::Warn,
            _ => LogLevel::Error,
        };
        let now = self.builder.node.time_now_not_simulated().into();
        let handle = self.builder.node.logging_handle();
        handle.rosout_raw(now, level, names::NODE, text, "", "", 0);
    }
}
