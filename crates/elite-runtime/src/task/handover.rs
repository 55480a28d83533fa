//! How the arm goes from a program that was replaced to the one that replaces it.
//!
//! The new program begins at once, while the arm may still brake; its first motion waits for the stop with which the
//! old one ended. Owns that stop's place among the commands whose outcome is kept.

use std::sync::Arc;

use motion_api::CommandId;

use crate::robot::Robot;

/// The stop that brings the arm to rest between two programs.
pub(crate) struct HandoverStop {
    robot: Arc<Robot>,
    stop: CommandId,
}

impl HandoverStop {
    /// `stop` was requested of `robot`: it ends when the arm stands.
    pub fn new(robot: Arc<Robot>, stop: CommandId) -> Self {
        Self { robot, stop }
    }

    /// The stop.
    pub fn stop(&self) -> CommandId {
        self.stop
    }
}

impl Drop for HandoverStop {
    fn drop(&mut self) {
        self.robot.forget(self.stop);
    }
}
