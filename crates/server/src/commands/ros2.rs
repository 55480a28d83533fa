//! `eliteserver ros2`: the process of the ROS 2 node, which `serve --ros2` starts with a socket as its standard input.

use messages::Text;

use crate::command::CommandResult;

/// What a build without the node says.
pub(crate) const WITHOUT_NODE: Text = Text::fixed(
    "this eliteserver was built without the ROS 2 node; build it with the feature ros2: \
     cargo build --release -p server --features ros2",
    "这个 eliteserver 构建时不含 ROS 2 节点；请带 ros2 特性构建：cargo build --release -p server --features ros2",
);

/// Runs the node until the controller ends it.
///
/// # Errors
/// Standard input is no socket of a controller, or the node does not work.
#[cfg(feature = "ros2")]
pub fn run_node() -> CommandResult {
    use crate::command::{CommandError, CommandStatus};
    use messages::text;
    use ros2::node::{NodeHost, run};
    use std::time::Duration;

    /// A read of the link waits no longer: that often the node looks what DDS has brought.
    const LOOK_EVERY: Duration = Duration::from_millis(4);

    let link = platform::sockets::end_of_child(LOOK_EVERY).map_err(|error| {
        CommandError::from(text!(
            "ros2 is started by 'eliteserver serve --ros2', with a socket as its standard input ({error})",
            "ros2 由 'eliteserver serve --ros2' 启动，标准输入为套接字（{error}）"
        ))
    })?;
    let host = NodeHost {
        limit_memory: platform::processes::limit_memory,
        hold_to_loopback: platform::sockets::hold_udp_to_loopback,
    };
    run(link, &host)?;
    Ok(CommandStatus::Success)
}

/// Refuses: the node is not in this program.
///
/// # Errors
/// Always.
#[cfg(not(feature = "ros2"))]
pub fn run_node() -> CommandResult {
    Err(WITHOUT_NODE.into())
}
