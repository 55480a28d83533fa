//! What every command that may move a robot does first: it says to which address it speaks, asks, and leaves robots in
//! local mode alone. And how it stops one.

use std::io::{self, IsTerminal};
use std::time::Duration;

use messages::{Localized, Text, text};
use robot_client::{PrimaryClient, PrimaryError, RobotAddress, dashboard};
use thiserror::Error;
use tokio::time::timeout;
use wire::primary::Message;

use crate::cli::RemoteRobotArgs;
use crate::language;

/// States come ten times a second: without one for so long there are none.
const STATE_PATIENCE: Duration = Duration::from_secs(1);
/// After Ctrl-C the robot has this long to stop its program.
pub(super) const STOP_PATIENCE: Duration = Duration::from_secs(3);
/// The process ends so long after Ctrl-C, whatever the robot does.
pub(super) const END_PATIENCE: Duration = Duration::from_millis(3600);

/// A reason why nothing is sent to a robot, told in a sentence.
#[derive(Debug, Error, Localized)]
pub(super) enum ConsentError {
    #[error(
        "{0} is in local mode: it takes no programs from outside. Switch it to remote control first"
    )]
    #[zh("{0} 处于本地模式，不接收外部程序。请先切换到远程控制")]
    Local(RobotAddress),
    #[error("nothing was sent")]
    #[zh("没有发送任何内容")]
    Declined,
    #[error("nobody can be asked: {0}")]
    #[zh("无法询问任何人：{0}")]
    Unasked(#[from] io::Error),
}

/// Whoever sits at a terminal is asked before a robot that is not this machine moves; nothing goes to one in local
/// mode. `address` is that of port 30001. `what` is the beginning of the question: `Send it to`.
pub(super) async fn ask_consent(
    args: &RemoteRobotArgs,
    address: &RobotAddress,
    what: &Text,
) -> Result<(), ConsentError> {
    let must_ask = !args.yes && !address.is_this_machine().await && io::stdin().is_terminal();
    if must_ask {
        language::say(&text!(
            "{what} the robot at {address}? It may move. [y/N]",
            "{what}机器人 {address}？它可能会运动。[y/N]"
        ));
        let mut answer = String::new();
        io::stdin().read_line(&mut answer)?;
        if !matches!(answer.trim(), "y" | "Y" | "yes") {
            return Err(ConsentError::Declined);
        }
    }
    match dashboard::is_remote(&address.with_port(args.dashboard_port)).await {
        Some(false) if !serves_clients(address).await => Err(ConsentError::Local(address.clone())),
        Some(_) | None => Ok(()),
    }
}

/// Whether port 30001 shows its states. In local mode it closes every connection; with remote control disabled in the
/// settings (mixed mode) it takes programs, though the dashboard's answer is that of local mode.
async fn serves_clients(address: &RobotAddress) -> bool {
    let looking = async {
        let mut robot = PrimaryClient::connect(address).await?;
        while !matches!(robot.next().await?, Message::State(_)) {}
        Ok::<(), PrimaryError>(())
    };
    matches!(timeout(STATE_PATIENCE, looking).await, Ok(Ok(())))
}

/// Stops the program on the robot; whether it stood in time, and the sentence about it.
pub(super) async fn stop(robot: &mut PrimaryClient) -> Result<Text, PrimaryError> {
    robot.send("stop task\n").await?;
    let standing = async {
        loop {
            if let Message::State(state) = robot.next().await?
                && state.mode.is_some_and(|mode| !mode.is_task_running)
            {
                return Ok::<(), PrimaryError>(());
            }
        }
    };
    match timeout(STOP_PATIENCE, standing).await {
        Ok(stood) => stood.map(|()| text!("the program was stopped", "程序已停止")),
        Err(_) => Ok(text!(
            "the robot still runs its program 3 s after it was told to stop",
            "要求停止 3 s 后机器人仍在运行程序"
        )),
    }
}
