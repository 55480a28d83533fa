//! The ROS 2 node, seen from the controller: its process, and what goes over the link to it.
//!
//! The process is started, limited and watched here; it comes back after whatever ends it. Every order of the node is
//! carried out here with the means of the dashboard, so its answers are the dashboard's. Nothing here waits for the
//! node: what it does not take in time is left out.

mod goals;
mod orders;
mod outbox;
mod process;
mod session;
mod simulated_time;

use std::sync::Arc;

use elite_runtime::Robot;
use motion_api::CommandKind;
use ros2::link::NodeSetup;
use tokio::sync::broadcast;

use crate::ports::dashboard::DashboardBackend;
use crate::ports::sample::Sample;

pub use process::keep_node;

/// What the node asks of the controller beyond the dashboard.
pub trait Ros2Backend: DashboardBackend {
    /// Every cycle's sample from now on, in order. A receiver that falls behind loses the oldest.
    fn samples(&self) -> broadcast::Receiver<Arc<Sample>>;
    /// The robot.
    fn robot(&self) -> &Robot;
    /// Gives the robot a command; returns when a cycle has taken it.
    fn command(&self, command: CommandKind) -> impl Future<Output = ()> + Send;
}

/// How a node is run.
#[derive(Clone, Debug)]
pub struct NodePlan {
    /// What the node is to be.
    pub setup: NodeSetup,
    /// Messages a second; without it one a cycle.
    pub rate: Option<f64>,
    /// What is added to the time of a cycle, ns.
    pub epoch: i64,
    /// Simulated seconds a second; without it as many as the node keeps up with.
    pub time_factor: Option<f64>,
}
