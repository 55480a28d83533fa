//! The world as viewers draw it, from its messages, and how often a recording gets it.

use std::sync::Arc;

use kinematics::{Pose, RobotModel};
use recorder::{RecorderHandle, SceneBody};
use world::WorldDescription;

use super::CellWorld;
use super::picture::WorldPicture;
use super::scene_bodies::SceneBodies;
use super::topic::{self, WorldChanges, WorldMessage};
use crate::cell::Cell;

/// Time between two scenes of a recording while something moves, s.
const SCENE_PERIOD: f64 = 0.1;

/// The world as viewers draw it.
#[derive(Clone, Debug)]
pub struct WorldScene {
    picture: WorldPicture,
    bodies: SceneBodies,
}

impl WorldScene {
    /// For the world of a cell; `None` for a cell without one.
    pub fn of_cell(cell: &Cell, model: &RobotModel) -> Option<Self> {
        let description = cell.drawn_world(model)?;
        Some(Self::new(&description, &cell.part_colors()))
    }

    pub(super) fn new(description: &WorldDescription, colors: &[Option<String>]) -> Self {
        Self {
            picture: WorldPicture::new(description),
            bodies: SceneBodies::new(description, colors),
        }
    }

    /// The scene after a message; the flange is where it was in the message's cycle.
    pub fn apply(&mut self, message: &WorldMessage, base_from_flange: &Pose) {
        self.picture.apply(message, base_from_flange);
    }

    /// What is there.
    pub const fn picture(&self) -> &WorldPicture {
        &self.picture
    }

    /// What is there, as solids.
    pub fn bodies(&self) -> Arc<[SceneBody]> {
        self.bodies.of(&self.picture)
    }
}

/// Says what viewers draw of a world, when it is otherwise than at the last call.
pub type SceneWatch = Box<dyn FnMut() -> Option<Arc<[SceneBody]>> + Send>;

impl CellWorld {
    /// Somebody who looks at the world from time to time and draws it.
    pub fn watch_scene(&self) -> SceneWatch {
        let world = self.clone();
        let mut changes = WorldChanges::new(self.description());
        let mut scene = WorldScene::new(self.description(), &self.0.colors);
        Box::new(move || {
            let (message, base_from_flange) = {
                let world = world.lock();
                let state = world.state();
                (changes.next(state.cycle, state)?, *world.base_from_flange())
            };
            scene.apply(&message, &base_from_flange);
            Some(scene.bodies())
        })
    }
}

/// The world in a recording: its messages, and the scene that viewers draw.
pub(super) struct WorldRecording {
    handle: RecorderHandle,
    scene: WorldScene,
    /// Time of the scene that was given last, s.
    drawn_at: f64,
    /// Something has moved since.
    is_stale: bool,
}

impl WorldRecording {
    pub(super) fn new(handle: RecorderHandle, scene: WorldScene) -> Self {
        Self {
            handle,
            scene,
            drawn_at: f64::NEG_INFINITY,
            is_stale: false,
        }
    }

    pub(super) fn apply(&mut self, message: &WorldMessage, base_from_flange: &Pose, period: f64) {
        topic::write(&self.handle, message, period);
        self.scene.apply(message, base_from_flange);
        self.is_stale = true;
    }

    /// Gives viewers the scene, if it is another and the last one is old enough.
    pub(super) fn draw_if_due(&mut self, time: f64) {
        if self.is_stale && time - self.drawn_at >= SCENE_PERIOD - 1e-9 {
            self.drawn_at = time;
            self.is_stale = false;
            self.handle.scene_bodies(time, self.scene.bodies());
        }
    }
}
