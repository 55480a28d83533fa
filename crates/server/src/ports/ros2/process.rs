//! The process of the node: started, watched, started again.

use std::io;
use std::process::ExitStatus;
use std::sync::Arc;
use std::time::Duration;

use elite_runtime::OwnChild;
use messages::Localized;
use platform::sockets::AsyncLocalStream;
use platform::{processes, sockets};
use ros2::link::LinkError;
use thiserror::Error;
use tokio::process::{Child, Command};
use tokio::time::{Instant, sleep, timeout};
use tokio_util::sync::CancellationToken;

use super::session::serve_link;
use super::{NodePlan, Ros2Backend};

/// The pause before the node is started again: the first one, and the longest that doubling leads to.
const PAUSES: (Duration, Duration) = (Duration::from_millis(200), Duration::from_secs(5));
/// A node that has run for so long is no reason for a longer pause.
const WELL_AFTER: Duration = Duration::from_secs(20);
/// A node that is told to end has so long to say goodbye to its peers.
const END_WITHIN: Duration = Duration::from_secs(2);

/// How a life of the node ended.
#[derive(Debug, Error, Localized)]
pub(super) enum NodeEnd {
    /// The controller ends.
    #[error("the controller ends")]
    #[zh("控制器结束")]
    Asked,
    /// The process has closed the link.
    #[error("its process has ended")]
    #[zh("其进程已结束")]
    Closed,
    /// The link.
    #[error("the link to it does not work: {0}")]
    #[zh("与它的链接不可用：{0}")]
    Io(#[from] io::Error),
    /// What the process says cannot be read.
    #[error("its process says what cannot be understood: {0}")]
    #[zh("其进程所说的无法理解：{0}")]
    Link(#[from] LinkError),
}

/// Keeps a node running until `shutdown`.
pub async fn keep_node<B: Ros2Backend>(
    plan: NodePlan,
    backend: Arc<B>,
    shutdown: CancellationToken,
) {
    let mut pause = PAUSES.0;
    while !shutdown.is_cancelled() {
        let begun = Instant::now();
        match run_node(&plan, &*backend, &shutdown).await {
            Ok(()) => return,
            Err(why) if shutdown.is_cancelled() => {
                tracing::debug!("the ROS 2 node: {why}");
                return;
            }
            Err(why) => {
                if begun.elapsed() > WELL_AFTER {
                    pause = PAUSES.0;
                }
                tracing::warn!(
                    "the ROS 2 node is gone ({why}); it is started again in {:.1} s. The controller is not affected",
                    pause.as_secs_f64()
                );
            }
        }
        if shutdown.run_until_cancelled(sleep(pause)).await.is_none() {
            return;
        }
        pause = (2 * pause).min(PAUSES.1);
    }
}

/// The reason for which a node is gone.
#[derive(Debug, Error, Localized)]
enum GoneReason {
    /// The process of the node was not started.
    #[error("its process cannot be started: {0}")]
    #[zh("无法启动其进程：{0}")]
    Start(io::Error),
    /// The process of the node has ended.
    #[error("{why}; {}", status(ended))]
    Ended {
        /// What was seen of it.
        why: NodeEnd,
        /// How the process ended, where that is known.
        ended: Option<ExitStatus>,
    },
}

fn status(ended: &Option<ExitStatus>) -> String {
    match ended {
        Some(status) => format!("it ended with {status}"),
        None => "it was killed".to_owned(),
    }
}

async fn run_node<B: Ros2Backend>(
    plan: &NodePlan,
    backend: &B,
    shutdown: &CancellationToken,
) -> Result<(), GoneReason> {
    let (mut child, link) = start().map_err(GoneReason::Start)?;
    let _own = child
        .id()
        .and_then(|id| i32::try_from(id).ok())
        .map(OwnChild::new);
    let why = match serve_link(link, plan, backend, shutdown).await {
        Ok(never) => match never {},
        Err(why) => why,
    };
    let ended = timeout(END_WITHIN, child.wait()).await;
    if ended.is_err() {
        // One that has just ended is as good.
        let _ = child.kill().await;
    }
    match why {
        NodeEnd::Asked => Ok(()),
        why => Err(GoneReason::Ended {
            why,
            ended: ended.ok().and_then(Result::ok),
        }),
    }
}

fn start() -> io::Result<(Child, AsyncLocalStream)> {
    let (own, input) = sockets::pair_with_child()?;
    own.set_nonblocking(true)?;
    let own = AsyncLocalStream::from_std(own)?;
    let mut command = Command::new(std::env::current_exe()?);
    command
        .arg("ros2")
        .stdin(input)
        .stdout(std::process::Stdio::null())
        .kill_on_drop(true)
        // ROS in the environment of the controller is for programs.
        .env("ROS_DISTRO", "jazzy");
    // Ctrl-C at the terminal is the controller's to hear.
    processes::set_process_group(command.as_std_mut());
    let child = command.spawn()?;
    Ok((child, own))
}
