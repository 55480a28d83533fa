//! A recording on the pendant page: everything can be looked at, at any time, and nothing ordered.

use std::path::Path;
use std::sync::Arc;

use controller::{ControllerConfig, LogLine};
use elite_runtime::CompilePool;
use elite_runtime::message::Message;
use elite_runtime::task_folder::TaskFolder;
use kinematics::{JointPositions, Pose, RpyPose};
use messages::{Text, text};
use motion_api::{CommandId, CommandKind, Outcome};
use parking_lot::Mutex;
use pendant::{History, PageOrder, SceneMeshes};
use recorder::Recording;
use serde_json::{Value, json};
use tokio::sync::broadcast;

use super::playback::{Playback, READ_ONLY};
use crate::ports::http::HttpBackend as _;
use crate::ports::http::page::{PageBackend, ShownProgram};

impl PageBackend for Playback {
    fn read_only(&self) -> Option<Text> {
        Some(READ_ONLY.clone())
    }

    fn scene(&self) -> Value {
        self.shown().scene.description.clone()
    }

    fn meshes(&self) -> &SceneMeshes {
        &self.shown().scene.meshes
    }

    fn about(&self) -> Value {
        json!({
            "version": env!("CARGO_PKG_VERSION"),
            "robot": self.robot_name(),
            "step_time": self.state().step_time,
            "replay": self.name(),
        })
    }

    fn place(&self) -> (u32, u32) {
        self.place_now()
    }

    fn program_number(&self) -> u32 {
        self.program_now()
    }

    fn program(&self, number: u32) -> Option<ShownProgram> {
        let programs = self.shown().programs.lock();
        let mut programs = programs.iter();
        programs.find(|program| program.number == number).cloned()
    }

    fn subscribe_messages(
        &self,
    ) -> (
        broadcast::Receiver<LogLine>,
        Option<broadcast::Receiver<Message>>,
    ) {
        (self.log_lines(), None)
    }

    async fn order(&self, _: PageOrder) -> Result<Value, Text> {
        Err(READ_ONLY.clone())
    }

    fn begin_hold(&self, _: CommandKind) -> Result<CommandId, Text> {
        Err(READ_ONLY.clone())
    }

    /// Nothing is held.
    fn end_hold(&self, _: CommandKind) {}

    fn outcome(&self, _: CommandId) -> Option<Outcome> {
        None
    }

    /// Nobody has asked for anything.
    fn forget(&self, _: CommandId) {}

    fn reach(&self, pose: [f64; 6]) -> Result<[f64; 6], Text> {
        if pose.iter().any(|x| !x.is_finite()) {
            return Err(text!(
                "a pose has six finite numbers",
                "位姿需要六个有限的数"
            ));
        }
        let state = self.state();
        let base_from_tcp = Pose::from_rpy(&RpyPose::from_array(pose));
        let flange_from_tcp = Pose::from_rpy(&state.tcp_offset);
        let near: &JointPositions = &state.actual_q;
        let found = self
            .model()
            .inverse_nearest(&base_from_tcp, &flange_from_tcp, near);
        found
            .map(|joints| joints.0)
            .ok_or_else(|| text!("the pose is out of reach", "位姿不可达"))
    }

    fn check_joint_target(&self, joints: [f64; 6]) -> Result<[f64; 6], Text> {
        match self.model().limits().contains(&JointPositions(joints)) {
            true => Ok(joints),
            false => Err(text!("a joint would leave its range", "关节将超出其范围")),
        }
    }

    fn tasks(&self) -> Option<(&TaskFolder, &Path)> {
        None
    }

    fn recording(&self) -> Result<Recording, Text> {
        let none = text!("no recording is shown", "没有显示记录");
        self.shown().recording.clone().ok_or(none)
    }

    fn rehearsal(&self) -> Result<ControllerConfig, Text> {
        Err(READ_ONLY.clone())
    }

    fn compile_pool(&self) -> &CompilePool {
        &self.pool
    }

    fn recorded(&self) -> Option<Arc<Mutex<History>>> {
        Some(self.shown().history.clone())
    }
}
