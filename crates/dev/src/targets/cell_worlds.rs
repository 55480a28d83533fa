//! The world of a cell file that was read: it begins, moves for some cycles with an arm and outputs that change, and
//! stays finite.

use std::sync::OnceLock;

use controller::cell::Cell;
use controller::cell_world::topic::WorldChanges;
use controller::cell_world::{World, WorldStart, check_world};
use kinematics::{JointPositions, RobotModel};
use motion_api::{PointLevels, WorldInput};
use supervision::ThreadSupervisor;

/// Cycles that a world is moved for.
const CYCLES: u64 = 8;
/// Joint positions of the arm in the first cycle, rad.
const HOME: [f64; 6] = [0.0, -1.57, 1.57, -1.57, -1.57, 0.0];

/// Asks a cell file for all that the controller asks it for.
pub(super) fn ask_all(cell: &Cell) {
    _ = (cell.io(), cell.safety_inputs(), cell.belts(), cell.loads());
    _ = (cell.surroundings(), cell.limits(), cell.scene_obstacles());
    _ = cell.fieldbus(&ThreadSupervisor::default(), None, None);
    _ = (cell.connections(), cell.point_names().count());
    live(cell);
}

/// Moves the world of a cell: every output is on in every other cycle, and a copy made half-way goes on as the original
/// does.
fn live(cell: &Cell) {
    let Some(model) = model() else { return };
    let start = WorldStart {
        model,
        step_time: 0.004,
        gravity: [0.0, 0.0, -9.81].into(),
        seed: 1,
    };
    let description = match check_world(cell, &start) {
        Ok(Some(description)) => description,
        Ok(None) => return,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return;
        }
    };
    let Ok(mut world) = World::new(&description) else {
        return;
    };
    let mut changes = WorldChanges::new(&description);
    let mut copy = world.clone();
    for cycle in 1..=CYCLES {
        if cycle == CYCLES / 2 {
            copy = world.clone();
        }
        let input = input(model, cycle);
        world.step(&input);
        assert!(is_finite(&world), "a part or an input is not finite");
        if let Some(message) = changes.next(cycle, world.state()) {
            _ = serde_json::to_vec(&message).map(|text| assert!(!text.is_empty()));
        }
        if cycle >= CYCLES / 2 {
            copy.step(&input);
        }
    }
    assert!(copy.state() == world.state(), "a copy goes another way");
}

fn model() -> Option<&'static RobotModel> {
    static MODEL: OnceLock<Option<RobotModel>> = OnceLock::new();
    MODEL
        .get_or_init(|| RobotModel::built_in("cs66").ok())
        .as_ref()
}

/// The arm turns its base by 10 mrad a cycle.
fn input(model: &RobotModel, cycle: u64) -> WorldInput {
    let mut q = HOME;
    q[0] += 0.01 * cycle as f64;
    let frames = model.forward(&JointPositions(q));
    let on = cycle % 2 == 1;
    WorldInput {
        cycle,
        seen: cycle - 1,
        base_from_joint: frames.base_from_joint,
        base_from_flange: frames.base_from_flange,
        outputs: PointLevels {
            digital: if on { u32::MAX } else { 0 },
            booleans: if on { [u64::MAX; 2] } else { [0; 2] },
            analog: [0.5; 3],
        },
        ..WorldInput::default()
    }
}

fn is_finite(world: &World) -> bool {
    let parts = world.state().parts.iter().all(|part| {
        let pose = &part.pose;
        pose.translation.iter().all(|x| x.is_finite())
            && pose.rotation.matrix().iter().all(|x| x.is_finite())
            && part.velocity.linear.iter().all(|x| x.is_finite())
    });
    let output = world.output();
    parts
        && output.inputs.analog.iter().all(|x| x.is_finite())
        && output.tool_wrench.force.iter().all(|x| x.is_finite())
        && output.held_body.mass.is_finite()
}
