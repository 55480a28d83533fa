//! What public viewers show without set-up: `/joint_states`, `/tf`, `/tcp`, `/scene` and `/log`, encoded.
//!
//! Owns the names of the frames, and when which message is due; the shapes are in [`scene`]. A recording and the live
//! view have the same messages from here. Everything is the arm as it is (`actual_*`), not as it was commanded. Frames
//! form one tree: `base_link`, the six links, `flange`, `tcp`.
//!
//! A scene is always whole but for the triangles of meshes ([`meshes`]): a viewer that seeks into a file shows the
//! latest message alone.

mod meshes;
mod scene;

use std::collections::{BTreeSet, VecDeque};
use std::sync::Arc;

use foxglove::messages as shown;
use foxglove::messages::Timestamp;
use kinematics::{DOF, Pose, RobotModel};
use messages::Text;
use motion_api::RobotState;
use nalgebra::Vector3;

use crate::chunks::CHUNK_BYTES;
use crate::topics::{LogLevel, LogTranslation, Topic};
use meshes::MeshScene;
pub use scene::{ObstacleShape, SceneBody, SceneFrame, SceneObstacle};

/// Name of the base frame.
pub const BASE_FRAME: &str = "base_link";
/// Names of the link frames, as in the URDF files of the CS arms.
pub const LINK_FRAMES: [&str; DOF] = [
    "shoulder_link",
    "upperarm_link",
    "forearm_link",
    "wrist_1_link",
    "wrist_2_link",
    "wrist_3_link",
];
/// Name of the tool flange's frame.
pub const FLANGE_FRAME: &str = "flange";
/// Name of the TCP's frame.
pub const TCP_FRAME: &str = "tcp";

/// Joints, frames and TCP have at least one message in this time, s: the rate of a screen, and above the promised 50
/// Hz.
const VIEW_PERIOD: f64 = 0.016;
/// The scene is drawn again after this time, s, for viewers that seek into the file.
const SCENE_PERIOD: f64 = 10.0;
/// While the trace or the force changes, the scene is drawn again after this time, s.
const MOVING_SCENE_PERIOD: f64 = 0.1;
/// The trace shows where the TCP was in this time, s.
const TRACE_SECS: f64 = 4.0;
/// Points of the trace are at least so far apart, m …
const TRACE_STEP: f64 = 0.001;
/// … and no more than these.
const TRACE_POINTS: usize = 256;
/// Another arrow is drawn when the force has changed by this, N.
const FORCE_STEP: f64 = 0.5;

/// Makes the viewers' messages for one arm, from its states in their order.
#[derive(Clone)]
pub struct ViewerMessages {
    model: RobotModel,
    obstacles: Vec<SceneObstacle>,
    /// What is drawn beside arm and obstacles, or in the place of an obstacle that moves.
    bodies: Arc<[SceneBody]>,
    meshes: MeshScene,
    /// Identifiers of bodies that were drawn and are not there any more.
    gone: BTreeSet<Arc<str>>,
    bodies_changed: bool,
    epoch_ns: u64,
    /// Cycle from which on joints, frames and TCP are due.
    view_due: u64,
    /// Simulated time at which the scene was drawn, s; none yet, or it is to be drawn at once.
    scene_drawn: Option<f64>,
    /// Whether the trace is another than the one drawn.
    trace_changed: bool,
    trace: VecDeque<(f64, Vector3<f64>)>,
    force: Vector3<f64>,
    force_drawn: Vector3<f64>,
    /// The encoded message, reused.
    buffer: Vec<u8>,
}

impl ViewerMessages {
    /// Time stamps are `epoch_ns` plus simulated time, ns.
    pub fn new(model: RobotModel, obstacles: Vec<SceneObstacle>, epoch_ns: u64) -> Self {
        let mut meshes = MeshScene::default();
        meshes.set(&obstacles, &[]);
        Self {
            model,
            obstacles,
            bodies: Arc::from([]),
            meshes,
            gone: BTreeSet::new(),
            bodies_changed: false,
            epoch_ns,
            view_due: 0,
            scene_drawn: None,
            trace_changed: false,
            trace: VecDeque::new(),
            force: Vector3::zeros(),
            force_drawn: Vector3::zeros(),
            buffer: Vec::new(),
        }
    }

    /// Time stamp of a simulated time, ns. NaN and negative times count as the start; `as` saturates.
    pub fn nanos(&self, time: f64) -> u64 {
        self.epoch_ns.saturating_add((time * 1e9).round() as u64)
    }

    /// The scene is drawn with the next state: somebody new looks.
    pub fn request_scene(&mut self) {
        self.scene_drawn = None;
    }

    /// What is drawn beside arm and obstacles is this from now on. A body with the identifier of an obstacle takes its
    /// place.
    pub fn set_bodies(&mut self, bodies: Arc<[SceneBody]>) {
        self.gone.extend(self.meshes.ids());
        self.gone
            .extend(self.bodies.iter().map(|body| body.id.clone()));
        self.meshes.set(&self.obstacles, &bodies);
        for id in self.meshes.ids() {
            self.gone.remove(&id);
        }
        for body in bodies.iter() {
            self.gone.remove(&body.id);
        }
        self.bodies = bodies;
        self.bodies_changed = true;
    }

    /// Gives the messages that are due at a state to `put`: the topic and the encoded message.
    ///
    /// # Errors
    /// The first one of `put`.
    pub fn state<E>(
        &mut self,
        state: &RobotState,
        mut put: impl FnMut(Topic, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let is_view_due = state.cycle >= self.view_due;
        if is_view_due {
            let cycles = (VIEW_PERIOD / state.step_time + 1e-9).floor().max(1.0);
            self.view_due = state.cycle.saturating_add(cycles as u64);
            self.follow(state);
            let at = self.timestamp(state.time);
            let joints = self.joint_states(state, at);
            put(Topic::JointStates, encode(&mut self.buffer, &joints))?;
            let frames = self.frames(state, at);
            put(Topic::Tf, encode(&mut self.buffer, &frames))?;
            let tcp = tcp(state, at);
            put(Topic::Tcp, encode(&mut self.buffer, &tcp))?;
        }
        if self.scene_is_due(state.time) {
            match self.scene_drawn {
                // All of it is asked for.
                None => self.meshes.repeat(state.time),
                Some(_) => self.meshes.repeat_if_due(state.time),
            }
            self.scene_without_meshes(state.time, &mut put)?;
        }
        if is_view_due {
            self.mesh_piece(self.timestamp(state.time), &mut put)?;
        }
        Ok(())
    }

    /// Gives the whole scene to `put`, message by message.
    ///
    /// # Errors
    /// The first one of `put`.
    pub fn scene<E>(
        &mut self,
        time: f64,
        mut put: impl FnMut(Topic, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        self.scene_without_meshes(time, &mut put)?;
        self.meshes.repeat(time);
        let at = self.timestamp(time);
        while self.mesh_piece(at, &mut put)? {}
        Ok(())
    }

    /// Gives the next piece of a mesh to `put`, if one is due.
    fn mesh_piece<E>(
        &mut self,
        at: Timestamp,
        put: &mut impl FnMut(Topic, &[u8]) -> Result<(), E>,
    ) -> Result<bool, E> {
        let Some(piece) = self.meshes.next(at) else {
            return Ok(false);
        };
        let update = shown::SceneUpdate {
            deletions: Vec::new(),
            entities: vec![piece],
        };
        put(Topic::Scene, encode(&mut self.buffer, &update))?;
        // What a large message needs is not kept.
        self.buffer.clear();
        self.buffer.shrink_to(CHUNK_BYTES);
        Ok(true)
    }

    fn scene_without_meshes<E>(
        &mut self,
        time: f64,
        put: &mut impl FnMut(Topic, &[u8]) -> Result<(), E>,
    ) -> Result<(), E> {
        let at = self.timestamp(time);
        let mut entities = scene::arm(&self.model, at);
        let is_moved = |id: &str| self.bodies.iter().any(|body| &*body.id == id);
        let obstacles = self.obstacles.iter();
        let obstacles = obstacles.filter(|one| !one.shape.is_mesh());
        let obstacles = obstacles.map(|one| scene::obstacle(one, at));
        entities.extend(obstacles.filter(|drawn| !is_moved(&drawn.id)));
        let bodies = self.bodies.iter().filter(|one| !one.shape.is_mesh());
        entities.extend(bodies.map(|one| scene::body(one, at)));
        entities.push(scene::trace(self.trace.iter().map(|(_, point)| *point), at));
        entities.push(scene::force(self.force, at));
        self.scene_drawn = Some(time);
        self.trace_changed = false;
        self.bodies_changed = false;
        self.force_drawn = self.force;
        let update = shown::SceneUpdate {
            deletions: std::mem::take(&mut self.gone)
                .into_iter()
                .map(|id| scene::deletion(&id, at))
                .collect(),
            entities,
        };
        put(Topic::Scene, encode(&mut self.buffer, &update))
    }

    /// A message for people, encoded for `/log`.
    pub fn log(&mut self, time: f64, level: LogLevel, source: &str, message: &Text) -> &[u8] {
        let log = shown::Log {
            timestamp: Some(self.timestamp(time)),
            level: level.number(),
            message: message.english().to_owned(),
            name: source.to_owned(),
            ..shown::Log::default()
        };
        encode(&mut self.buffer, &log);
        let chinese = message.other_chinese().map(str::to_owned);
        // Fields behind those of the vendor's message; who does not know them passes over them.
        prost::Message::encode_raw(&LogTranslation { chinese }, &mut self.buffer);
        &self.buffer
    }

    fn scene_is_due(&self, time: f64) -> bool {
        let Some(drawn) = self.scene_drawn else {
            return true;
        };
        let force_changed = (self.force - self.force_drawn).norm() >= FORCE_STEP;
        let period = if self.trace_changed || self.bodies_changed || force_changed {
            MOVING_SCENE_PERIOD
        } else {
            SCENE_PERIOD
        };
        // Time runs backwards when a replay begins again.
        time - drawn >= period - 1e-9 || time < drawn
    }

    /// Notes where the TCP is and what pushes it.
    fn follow(&mut self, state: &RobotState) {
        let [x, y, z, ..] = state.actual_tcp_pose.to_array();
        let here = Vector3::new(x, y, z);
        let moved = |(_, latest): &(f64, Vector3<f64>)| (here - latest).norm() >= TRACE_STEP;
        if self.trace.back().is_none_or(moved) {
            self.trace.push_back((state.time, here));
            // One point is no line.
            self.trace_changed |= self.trace.len() > 1;
        }
        let old = |(since, _): &(f64, Vector3<f64>)| state.time - since > TRACE_SECS;
        // The latest point stays: the line goes on from there.
        while self.trace.len() > TRACE_POINTS
            || (self.trace.len() > 1 && self.trace.front().is_some_and(old))
        {
            self.trace.pop_front();
            self.trace_changed = true;
        }
        let force = Vector3::from_column_slice(&state.tcp_force[..3]);
        self.force = if force.norm() >= scene::FORCE_MIN {
            force
        } else {
            Vector3::zeros()
        };
    }

    fn timestamp(&self, time: f64) -> Timestamp {
        let ns = self.nanos(time);
        let secs = u32::try_from(ns / 1_000_000_000).unwrap_or(u32::MAX);
        Timestamp::new(secs, (ns % 1_000_000_000) as u32)
    }

    fn joint_states(&self, state: &RobotState, at: Timestamp) -> shown::JointStates {
        let names = self.model.joint_names().iter();
        let joints = names.enumerate().map(|(joint, name)| shown::JointState {
            name: name.clone(),
            position: Some(state.actual_q[joint]),
            velocity: Some(state.actual_qd[joint]),
            acceleration: None,
            effort: Some(state.actual_torque[joint]),
        });
        shown::JointStates {
            timestamp: Some(at),
            joints: joints.collect(),
        }
    }

    fn frames(&self, state: &RobotState, at: Timestamp) -> shown::FrameTransforms {
        let frames = self.model.forward(&state.actual_q);
        let mut transforms = Vec::with_capacity(DOF + 2);
        let mut add = |parent: &str, child: &str, parent_from_child: &Pose| {
            transforms.push(shown::FrameTransform {
                timestamp: Some(at),
                parent_frame_id: parent.to_owned(),
                child_frame_id: child.to_owned(),
                translation: Some(scene::vector(parent_from_child.translation)),
                rotation: Some(scene::quaternion(&scene::rotation(parent_from_child))),
            });
        };
        let mut parent = (BASE_FRAME, Pose::IDENTITY);
        for (name, base_from_link) in LINK_FRAMES.into_iter().zip(frames.base_from_joint) {
            add(parent.0, name, &(parent.1.inverse() * base_from_link));
            parent = (name, base_from_link);
        }
        add(
            parent.0,
            FLANGE_FRAME,
            &self.model.chain().joint6_from_flange,
        );
        add(FLANGE_FRAME, TCP_FRAME, &Pose::from_rpy(&state.tcp_offset));
        for body in self.bodies.iter().filter(|body| body.shape.is_mesh()) {
            add(body.frame.name(), &body.id, &body.pose);
        }
        shown::FrameTransforms { transforms }
    }
}

fn tcp(state: &RobotState, at: Timestamp) -> shown::PoseInFrame {
    shown::PoseInFrame {
        timestamp: Some(at),
        frame_id: BASE_FRAME.to_owned(),
        pose: Some(scene::pose(&Pose::from_rpy(&state.actual_tcp_pose))),
    }
}

fn encode<'a>(buffer: &'a mut Vec<u8>, message: &impl prost::Message) -> &'a [u8] {
    buffer.clear();
    message.encode_raw(buffer);
    buffer
}
