//! The world of a cell at work: moved after every control cycle, seen and changed by tests, page and programs of others
//! between two cycles.
//!
//! Owns the meeting of three: the control cycle (rings, never waited for), the world (behind a lock of this side), and
//! the recording (a message for each cycle in which a part moved). Under the virtual clock the world moves on the
//! thread of the cycle, under the real one on a thread of its own ([`crate::clock`]).

pub mod facts;
pub(crate) mod gripper_bus;
pub mod orders;
pub mod part_names;
pub mod picture;
mod scene;
mod scene_bodies;
pub mod topic;

use std::collections::VecDeque;
use std::sync::Arc;

use motion::{ControlLoop, WorldSetup};
use motion_api::{LateCycles, WorldEndpoint, WorldInput, WorldOutput, world_channel};
use nalgebra::Vector3;
use parking_lot::{Mutex, MutexGuard};
use recorder::RecorderHandle;
pub use world::description::{BodyShape, DetectorKind, GripperKind, PartDescription, Surface};
pub use world::{FingerState, OrderError, World, WorldDescription, WorldError, WorldState};

use crate::cell::Cell;
use crate::cell::world::WorldSettings;
use facts::WorldFacts;
use kinematics::{Pose, RobotModel};
pub use orders::{WorldInputs, WorldOrder, WorldOrderError};
use scene::WorldRecording;
pub use scene::{SceneWatch, WorldScene};
use topic::{WorldChanges, WorldMessage};

/// The world around a controller's arm, shared by all who look at it.
#[derive(Clone)]
pub struct CellWorld(Arc<Shared>);

struct Shared {
    description: WorldDescription,
    /// Colours of the tables of parts.
    colors: Vec<Option<String>>,
    world: Mutex<World>,
    /// What is new from cycle to cycle. Locked only by who has locked the world.
    changes: Mutex<WorldChanges>,
    late: LateCycles,
    followers: Mutex<Vec<WorldFollower>>,
    /// Orders that are not in the recording yet, with the cycle after which they came.
    told: Mutex<Vec<(u64, WorldOrder)>>,
}

/// Is told what is new in the world after a cycle.
pub type WorldFollower = Box<dyn FnMut(&WorldMessage) + Send>;

impl CellWorld {
    /// The world, to look at or to change between two cycles. The world does not move meanwhile, so nobody keeps it for
    /// long.
    pub fn lock(&self) -> MutexGuard<'_, World> {
        self.0.world.lock()
    }

    /// What the cell file says.
    pub fn description(&self) -> &WorldDescription {
        &self.0.description
    }

    /// Carries an order out between two cycles; the name of the part that was added.
    ///
    /// # Errors
    /// What is wrong with the order, in a sentence.
    pub fn order(&self, order: WorldOrder) -> Result<Option<String>, WorldOrderError> {
        let mut world = self.lock();
        let added = order.carry_out(&mut world)?;
        self.0.told.lock().push((world.state().cycle, order));
        Ok(added)
    }

    /// Tells `follower` of everything from now on, first of all that there is. Called on the thread that moves the
    /// world.
    pub fn follow(&self, mut follower: WorldFollower) {
        let world = self.lock();
        follower(&self.whole_state(&world));
        self.0.changes.lock().catch_up(world.state());
        self.0.followers.lock().push(follower);
    }

    /// What conditions and tests may ask, as of now.
    pub fn facts(&self) -> WorldFacts {
        let mut facts = WorldFacts::new(&self.0.description);
        facts.apply(&self.whole_state(&self.lock()));
        facts
    }

    fn whole_state(&self, world: &World) -> WorldMessage {
        let state = world.state();
        // The first message of all has everything.
        let whole = WorldChanges::new(&self.0.description).next(state.cycle, state);
        whole.unwrap_or_default()
    }

    /// For how many cycles the world came late; none under the virtual clock.
    pub fn late_cycles(&self) -> u64 {
        self.0.late.count()
    }
}

/// The side of the world that moves it.
pub struct WorldRunner {
    world: CellWorld,
    endpoint: WorldEndpoint,
    recording: Option<WorldRecording>,
    /// A recorded run that is repeated, and results that the next cycle must not have yet.
    repeat: Option<(WorldInputs, VecDeque<WorldOutput>)>,
}

impl WorldRunner {
    /// Moves the world by all cycles that wait.
    pub fn run_waiting(&mut self) {
        while let Some(input) = self.endpoint.next_cycle() {
            if self.repeats_a_miss(input.cycle) {
                continue;
            }
            self.record_orders(input.cycle);
            let mut world = self.world.lock();
            let missed = input.cycle.saturating_sub(world.state().cycle + 1);
            if let Some((inputs, _)) = &mut self.repeat {
                while let Some(order) = inputs.next_order(input.cycle) {
                    // Carried out when it was recorded, so it is now.
                    let _ = order.carry_out(&mut world);
                }
            }
            let output = *world.step(&input);
            // Most runs have nobody who wants to know, and finding what is new takes a tenth of their world.
            let is_followed = self.is_followed();
            let mut changes = self.world.0.changes.lock();
            let change = match is_followed {
                true => changes.next(input.cycle, world.state()),
                false => {
                    changes.skip();
                    None
                }
            };
            drop(changes);
            drop(world);
            self.answer(&input, output);
            if !is_followed {
                continue;
            }
            let is_late = input.seen + 1 < input.cycle;
            if change.is_some() || is_late || missed > 0 {
                let mut message = change.unwrap_or_default();
                message.cycle = input.cycle;
                message.seen = is_late.then_some(input.seen);
                message.missed = missed;
                self.tell(&message, &input.base_from_flange);
            }
            self.draw(input.cycle);
        }
    }

    /// Moves the world by the cycles that still wait when the last cycle has ended, and records how many it missed.
    pub fn finish(&mut self) {
        self.run_waiting();
        let newest = self.endpoint.newest_cycle();
        self.record_orders(newest);
        let missed = newest.saturating_sub(self.world.lock().state().cycle);
        if missed > 0 {
            let message = WorldMessage {
                cycle: newest + 1,
                missed,
                ..WorldMessage::default()
            };
            self.tell(&message, &Pose::IDENTITY);
        }
    }

    /// Whether the recorded run that is repeated had no time for this cycle. The cycle after the last such one has what
    /// it had then.
    fn repeats_a_miss(&mut self, cycle: u64) -> bool {
        let is_missed = |(inputs, _): &mut (WorldInputs, _)| inputs.is_missed(cycle);
        let is_missed = self.repeat.as_mut().is_some_and(is_missed);
        if is_missed {
            self.answer_due(cycle + 1);
        }
        is_missed
    }

    /// Whether anybody is told what is new. Asked while the world is locked, as followers come while it is.
    fn is_followed(&self) -> bool {
        self.recording.is_some() || !self.world.0.followers.lock().is_empty()
    }

    /// Gives a result to the next cycle, or as late as it was when the run was recorded.
    fn answer(&mut self, input: &WorldInput, output: WorldOutput) {
        let Some((_, waiting)) = &mut self.repeat else {
            self.endpoint.answer(&output);
            return;
        };
        waiting.push_back(output);
        self.answer_due(input.cycle + 1);
    }

    /// Gives a cycle of a repeated run the results that it had.
    fn answer_due(&mut self, cycle: u64) {
        let Some((inputs, waiting)) = &mut self.repeat else {
            return;
        };
        if inputs.is_missed(cycle) {
            return;
        }
        let newest = inputs.newest_for(cycle);
        while let Some(due) = waiting.pop_front_if(|output| output.cycle <= newest) {
            self.endpoint.answer(&due);
        }
    }

    /// Writes what the world was told before this cycle.
    fn record_orders(&mut self, cycle: u64) {
        let told = core::mem::take(&mut *self.world.0.told.lock());
        for (after, order) in told {
            let message = WorldMessage {
                cycle: after.min(cycle),
                orders: vec![order],
                ..WorldMessage::default()
            };
            // No part moves with it, so it does not matter where the flange is.
            self.tell(&message, &Pose::IDENTITY);
        }
    }

    /// Repeats what the world of a recorded run was told, when it was.
    pub fn repeat(&mut self, inputs: WorldInputs) {
        self.repeat = Some((inputs, VecDeque::new()));
    }

    fn tell(&mut self, message: &WorldMessage, base_from_flange: &Pose) {
        let shared = &self.world.0;
        if let Some(recording) = &mut self.recording {
            recording.apply(
                message,
                base_from_flange,
                shared.description.settings.period,
            );
        }
        for follower in shared.followers.lock().iter_mut() {
            follower(message);
        }
    }

    /// Writes what moves to a recording; the state before the first cycle is written at once.
    pub fn record_to(&mut self, handle: RecorderHandle) {
        let shared = &self.world.0;
        let scene = WorldScene::new(&shared.description, &shared.colors);
        self.recording = Some(WorldRecording::new(handle, scene));
        let whole = {
            let world = self.world.lock();
            shared.changes.lock().catch_up(world.state());
            self.world.whole_state(&world)
        };
        self.tell(&whole, &Pose::IDENTITY);
        self.draw(0);
    }

    fn draw(&mut self, cycle: u64) {
        let period = self.world.0.description.settings.period;
        if let Some(recording) = &mut self.recording {
            recording.draw_if_due(cycle as f64 * period);
        }
    }

    /// The world that is moved.
    pub const fn world(&self) -> &CellWorld {
        &self.world
    }
}

/// What the start of a controller says about its world.
#[derive(Clone, Copy, Debug)]
pub struct WorldStart<'a> {
    /// The arm.
    pub model: &'a RobotModel,
    /// Length of a control cycle, s.
    pub step_time: f64,
    /// Free-fall acceleration at the arm, base frame, m/s².
    pub gravity: Vector3<f64>,
    /// Seed of all scatter.
    pub seed: u64,
}

impl WorldStart<'_> {
    const fn settings(&self) -> WorldSettings<'_> {
        WorldSettings {
            model: self.model,
            step_time: self.step_time,
            gravity: self.gravity,
            seed: self.seed,
        }
    }
}

/// The description of the world of a cell, whose start is possible; `None` for a cell without one.
///
/// # Errors
/// Parts that overlap at the start.
pub fn check_world(
    cell: &Cell,
    start: &WorldStart<'_>,
) -> Result<Option<WorldDescription>, Box<WorldError>> {
    let Some(description) = cell.world(&start.settings()) else {
        return Ok(None);
    };
    World::new(&description)?;
    Ok(Some(description))
}

/// Puts the world of a cell around a control loop; nothing happens to a cell without one.
///
/// # Errors
/// A world that cannot be: parts that overlap at the start.
pub fn surround(
    cycle: ControlLoop,
    cell: Option<&Cell>,
    start: &WorldStart<'_>,
) -> Result<(ControlLoop, Option<WorldRunner>), Box<WorldError>> {
    let settings = start.settings();
    let Some((cell, description)) = cell.and_then(|cell| Some((cell, cell.world(&settings)?)))
    else {
        return Ok((cycle, None));
    };
    let world = World::new(&description)?;
    let (port, endpoint) = world_channel();
    let setup = WorldSetup {
        driven_inputs: world.driven_inputs(),
        ticks_per_unit: cell.world_encoders(),
    };
    let mut changes = WorldChanges::new(&description);
    // Everything is new before the first cycle; who follows is told so then.
    let _ = changes.next(0, world.state());
    let runner = WorldRunner {
        world: CellWorld(Arc::new(Shared {
            description,
            world: Mutex::new(world),
            changes: Mutex::new(changes),
            colors: cell.part_colors(),
            late: endpoint.late_cycles(),
            followers: Mutex::default(),
            told: Mutex::default(),
        })),
        endpoint,
        recording: None,
        repeat: None,
    };
    Ok((cycle.with_world(port, setup), Some(runner)))
}
