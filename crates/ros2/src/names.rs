//! Names of nodes, topics, services, joints and frames: those of the vendor's driver 1.0.3 and its description.

use messages::{Localized, Text, text};
use thiserror::Error;

/// The name of the node.
pub const NODE: &str = "elite_controller";

/// The joints, base first, as the vendor's description names them.
pub const JOINTS: [&str; 6] = [
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
];

/// Frames of the links that the joints move, base first.
pub const LINKS: [&str; 6] = [
    "shoulder_link",
    "upperarm_link",
    "forearm_link",
    "wrist_1_link",
    "wrist_2_link",
    "wrist_3_link",
];

/// The frame that the first joint turns in.
pub const BASE_INERTIA: &str = "base_link_inertia";
/// The root of the description.
pub const BASE_LINK: &str = "base_link";
/// The frame of the controller's base coordinates.
pub const BASE: &str = "base";
/// The frame of the active TCP, as the controller reports it.
pub const TCP: &str = "tool0_controller";
/// The frame of the flange as a tool of no length.
pub const TOOL: &str = "tool0";

/// Topics, below the namespace.
pub mod topic {
    /// Positions, speeds and torques of the joints.
    pub const JOINT_STATES: &str = "joint_states";
    /// The arm's description.
    pub const ROBOT_DESCRIPTION: &str = "robot_description";
    /// The wrench on the tool.
    pub const WRENCH: &str = "force_torque_sensor_broadcaster/wrench";
    /// The pose of the TCP.
    pub const TCP_POSE: &str = "tcp_pose_broadcaster/pose";
    /// The speed scaling, per cent.
    pub const SPEED_SCALING: &str = "speed_scaling_state_broadcaster/speed_scaling";
    /// Inputs and outputs.
    pub const IO_STATES: &str = "io_and_status_controller/io_states";
    /// The connector of the tool.
    pub const TOOL_DATA: &str = "io_and_status_controller/tool_data";
    /// The mode of the arm.
    pub const ROBOT_MODE: &str = "io_and_status_controller/robot_mode";
    /// The mode of the safety system.
    pub const SAFETY_MODE: &str = "io_and_status_controller/safety_mode";
    /// Whether a task runs.
    pub const TASK_RUNNING: &str = "io_and_status_controller/robot_task_running";
    /// A trajectory without an action.
    pub const JOINT_TRAJECTORY: &str = "scaled_joint_trajectory_controller/joint_trajectory";
    /// Frames that move; no namespace.
    pub const TF: &str = "/tf";
    /// Frames that do not move; no namespace.
    pub const TF_STATIC: &str = "/tf_static";
    /// Simulated time; no namespace.
    pub const CLOCK: &str = "/clock";
}

/// The action, below the namespace.
pub const FOLLOW_JOINT_TRAJECTORY: &str =
    "scaled_joint_trajectory_controller/follow_joint_trajectory";
/// Services of the dashboard are below this.
pub const DASHBOARD: &str = "dashboard_client";
/// Services of inputs, outputs and settings are below this.
pub const IO_AND_STATUS: &str = "io_and_status_controller";

/// The reason for which a name cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
#[error(
    "{given:?} is no {what} of ROS 2: letters, digits and single underscores, not a digit first{more}"
)]
#[zh("{given:?} 不是 ROS 2 的{what}：只能有字母、数字和单个下划线，不以数字开头{more}")]
pub struct NameError {
    what: Text,
    given: String,
    more: Text,
}

/// Longest namespace and prefix.
const NAME_LENGTH_MAX: usize = 128;

/// A namespace as ROS writes it, with a slash before each part: `/cell1/left`; the empty text and `/` are the root.
///
/// # Errors
/// The text is none.
pub fn namespace(given: &str) -> Result<String, NameError> {
    let parts = given.trim_matches('/');
    if parts.is_empty() {
        return Ok("/".to_owned());
    }
    match parts.len() <= NAME_LENGTH_MAX && parts.split('/').all(is_token) {
        true => Ok(format!("/{parts}")),
        false => Err(NameError {
            what: text!("namespace", "命名空间"),
            given: given.chars().take(NAME_LENGTH_MAX).collect(),
            more: text!(", parts joined by /", "，各部分以 / 连接"),
        }),
    }
}

/// A prefix of joints and frames, as `left_`.
///
/// # Errors
/// The text is none.
pub fn prefix(given: &str) -> Result<String, NameError> {
    let is_word = |text: &str| text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    let begins = |text: &str| !text.starts_with(|c: char| c.is_ascii_digit());
    match given.len() <= NAME_LENGTH_MAX && is_word(given) && begins(given) {
        true => Ok(given.to_owned()),
        false => Err(NameError {
            what: text!("prefix of frames", "坐标系前缀"),
            given: given.chars().take(NAME_LENGTH_MAX).collect(),
            more: Text::verbatim(""),
        }),
    }
}

fn is_token(text: &str) -> bool {
    !text.is_empty()
        && !text.starts_with(|c: char| c.is_ascii_digit())
        && !text.contains("__")
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn namespaces_are_written_with_slashes_and_wrong_ones_are_named() {
        for (given, expected) in [
            ("", "/"),
            ("/", "/"),
            ("cell", "/cell"),
            ("/cell_1/left/", "/cell_1/left"),
        ] {
            assert_eq!(namespace(given).unwrap(), expected);
        }
        for given in ["1cell", "a//b", "a__b", "a-b", "zelle ü", &"a".repeat(200)] {
            let error = namespace(given).unwrap_err().to_string();
            assert!(error.contains("namespace of ROS 2"), "{error}");
        }
        assert_eq!(prefix("left_").unwrap(), "left_");
        assert!(prefix("1_").is_err());
        assert!(prefix("a/b").is_err());
    }
}
