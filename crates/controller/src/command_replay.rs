//! Recorded commands and changes of registers, given again: each command before the cycle that took it, each change
//! before the cycle that saw it.

use std::sync::Arc;

use messages::Localized;
use motion_api::points::{POINTS_MAX, PointValues};
use motion_api::{
    Command, CommandKind, CommandSender, MotionCommand, OnlineCommand, PointList, Refusal,
};
use recorder::{ArgumentError, CommandMessage};
use thiserror::Error;

/// A reason why a recorded command cannot be given again.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub enum CommandReplayError {
    /// The command is not one of this version.
    #[error("command {id} cannot be given again: {source}")]
    #[zh("命令 {id} 不能再次发出：{source}")]
    Command {
        /// Number of the command.
        id: u64,
        /// What is wrong with its arguments.
        source: ArgumentError,
    },
    /// The points of a moveml are not in the recording, or none that can be.
    #[error("command {id}, a moveml, cannot be given again: {refusal}")]
    #[zh("命令 {id}（moveml）不能再次发出：{refusal}")]
    Points {
        /// Number of the command.
        id: u64,
        /// What is wrong with the points.
        refusal: Refusal,
    },
    /// A command is missing in the recording.
    #[error("command {expected} is missing in the recording, command {found} comes in its place")]
    #[zh("记录中缺少命令 {expected}，其位置上是命令 {found}")]
    Missing {
        /// The number that should come.
        expected: u64,
        /// The number that came.
        found: u64,
    },
    /// The commands of a cycle do not fit into the ring.
    #[error("more commands than the ring holds were taken in cycle {cycle}")]
    #[zh("周期 {cycle} 取走的命令多于环形缓冲区的容量")]
    TooMany {
        /// The cycle.
        cycle: u64,
    },
}

/// Gives recorded commands, in their order.
#[derive(Default)]
pub struct CommandReplayer {
    /// Points of the moveml that comes next, and whether they are poses.
    points: (bool, Vec<PointValues>),
}

impl CommandReplayer {
    /// Gives a command; `None` for points, which wait for the command that goes along them.
    ///
    /// # Errors
    /// [`CommandReplayError`]
    pub fn give(
        &mut self,
        port: &CommandSender,
        message: &CommandMessage,
    ) -> Result<Option<Command>, CommandReplayError> {
        let wrong = |source| CommandReplayError::Command {
            id: message.id,
            source,
        };
        if let Some((are_poses, points)) = message.to_points().map_err(wrong)? {
            self.points.0 = are_poses;
            // One more than a list may have is refused with it.
            let room = (POINTS_MAX + 1).saturating_sub(self.points.1.len());
            self.points.1.extend(points.into_iter().take(room));
            return Ok(None);
        }
        let command = message.to_command().map_err(wrong)?;
        let sent = match command.kind {
            CommandKind::Motion(MotionCommand::MoveMl { interval, .. })
            | CommandKind::Online(OnlineCommand::FollowPoints { interval, .. }) => {
                let (are_poses, points) = std::mem::take(&mut self.points);
                let id = message.id;
                let list = PointList::new(points, are_poses)
                    .map_err(|refusal| CommandReplayError::Points { id, refusal })?;
                let list = Arc::new(list);
                match command.kind {
                    CommandKind::Online(OnlineCommand::FollowPoints { .. }) => {
                        port.send_trajectory(command.origin, &list, interval, |_, _| ())
                    }
                    _ => port.send_points(command.origin, &list, interval, |_, _| ()),
                }
            }
            kind => port.send(command.origin, kind),
        };
        let cycle = message.cycle;
        let id = sent.map_err(|_| CommandReplayError::TooMany { cycle })?;
        if id == command.id {
            return Ok(Some(command));
        }
        Err(CommandReplayError::Missing {
            expected: id.0,
            found: message.id,
        })
    }
}
