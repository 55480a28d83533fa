//! The controller as a node of ROS 2.
//!
//! - [`messages`]: the types, their definitions, and CDR.
//! - [`names`]: topics, services, joints and frames, as the vendor's driver and description have them.
//! - [`sample`]: one cycle, and the messages that are made of it; recordings use it as well.
//! - [`trajectory`]: what is asked of a trajectory, and the positions that it asks for at every moment.
//! - [`link`]: what the controller and the process of the node tell each other.
//! - `node` (feature `node`): the process of the node with its DDS stack.
//!
//! A DDS stack takes datagrams from anybody, so it runs in a process of its own that may be exhausted or killed
//! without a cycle being missed. Everything that decides is on the controller's side of the link. Knows samples and
//! orders, no script value and no port.
//!
//! ```
//! use kinematics::{JointPositions, RobotModel};
//! use motion_api::RobotState;
//! use ros2::messages::Message;
//! use ros2::sample::NodeSample;
//!
//! let arm = RobotModel::built_in("cs66")?;
//! let state = RobotState::at_start(JointPositions([0.0, -1.57, 0.0, -1.57, 0.0, 0.0]), 0.004);
//! let message = NodeSample::of(&state, &arm, false, 4_000_000).joint_state("");
//! assert_eq!(message.name[0], "shoulder_pan_joint");
//! assert_eq!(message.to_cdr()?[..4], [0, 1, 0, 0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

pub mod link;
pub mod messages;
pub mod names;
pub mod sample;
pub mod trajectory;

#[cfg(feature = "node")]
pub mod node;
