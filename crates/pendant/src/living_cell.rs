//! The world of the cell as JSON: what there is, once with the scene, and how it is at a moment. Pure.
//!
//! A moment is always whole, so that a page that missed one, or goes to any time of a recording, needs no other.

use std::sync::Arc;

use controller::cell::Cell;
use controller::cell_world::picture::WorldPicture;
use controller::cell_world::topic::WorldChanges;
use controller::cell_world::{CellWorld, DetectorKind, GripperKind, Surface, WorldDescription};
use kinematics::{Pose, RobotModel};
use serde_json::{Value, json};

use crate::meshes::MeshNumbers;
use crate::scene::{ShapeRow, matrix};

/// Numbers of a moment are told to a hundredth of a millimetre, and to a hundred thousandth of a radian.
const STEPS: f64 = 1e5;

/// Shapes, places and names of parts and of what handles them; null for a cell without any.
pub(crate) fn describe(model: &RobotModel, cell: &Cell, meshes: &mut MeshNumbers) -> Value {
    let Some(world) = cell.drawn_world(model) else {
        return Value::Null;
    };
    let colors = cell.part_colors();
    let parts = world.parts.iter().enumerate().map(|(number, part)| {
        let mut row = ShapeRow::of(&part.shape, meshes).json();
        row["name"] = json!(part.name);
        row["color"] = json!(colors.get(number).cloned().flatten());
        row
    });
    // Numbers of meshes are given in this order.
    let parts: Value = parts.collect();
    let grippers = grippers(&world, meshes);
    json!({
        "floor": world.settings.floor,
        "parts": parts,
        "grippers": grippers,
        "conveyors": conveyors(&world),
        "detectors": detectors(&world),
        "sinks": world.sinks.iter().map(|sink| {
            json!({"name": sink.name, "pose": matrix(&sink.pose), "size": sink.size})
        }).collect::<Value>(),
        "actuators": world.actuators.iter().map(|actuator| {
            json!({"name": actuator.name, "moves": actuator.moves})
        }).collect::<Value>(),
    })
}

fn grippers(world: &WorldDescription, meshes: &mut MeshNumbers) -> Value {
    let grippers = world.grippers.iter().map(|gripper| match &gripper.kind {
        GripperKind::Vacuum(vacuum) => json!({
            "name": gripper.name,
            "kind": "vacuum",
            "cups": vacuum.cups,
            "direction": vacuum.direction,
            "radius": vacuum.radius,
        }),
        GripperKind::Fingers(fingers) => {
            // The page mirrors the mesh of the other finger itself.
            let mut row = ShapeRow::of(&fingers.finger.0, meshes).json();
            row["name"] = json!(gripper.name);
            row["kind"] = json!("fingers");
            row["axis"] = json!(fingers.axis);
            row["pose"] = matrix(&fingers.finger.1);
            row
        }
    });
    grippers.collect()
}

fn conveyors(world: &WorldDescription) -> Value {
    let conveyors = world.conveyors.iter().map(|conveyor| {
        let (name, speed) = (&conveyor.name, conveyor.speed);
        match &conveyor.surface {
            Surface::Belt {
                pose,
                size,
                direction,
            } => json!({
                "name": name,
                "kind": "belt",
                "pose": matrix(pose),
                "size": size,
                "direction": direction,
                "speed": speed,
            }),
            Surface::Turntable { center, radius } => json!({
                "name": name,
                "kind": "turntable",
                "pose": matrix(center),
                "radius": radius,
                "speed": speed,
            }),
        }
    });
    conveyors.collect()
}

fn detectors(world: &WorldDescription) -> Value {
    let detectors = world.detectors.iter().map(|detector| {
        let name = &detector.name;
        match &detector.kind {
            DetectorKind::Beam { from, until } => {
                json!({"name": name, "kind": "beam", "from": from, "until": until})
            }
            DetectorKind::Presence { pose, size } => {
                json!({"name": name, "kind": "presence", "pose": matrix(pose), "size": size})
            }
            DetectorKind::Distance { pose, range } => {
                json!({"name": name, "kind": "distance", "pose": matrix(pose), "range": range})
            }
        }
    });
    detectors.collect()
}

/// A moment of the world, as JSON.
pub fn moment(picture: &WorldPicture) -> Value {
    let pose = |pose: &Pose| pose.to_rpy().to_array().map(rounded);
    let parts = picture.parts.iter().map(|(name, part)| {
        let mut row = json!({"name": name, "pose": pose(&part.pose)});
        if let Some(gripper) = part.held_by {
            row["held_by"] = gripper.into();
        }
        row
    });
    let obstacles = picture.obstacles.iter();
    let obstacles = obstacles.map(|(name, at)| json!({"name": name, "pose": pose(at)}));
    let grippers = picture
        .grippers
        .iter()
        .enumerate()
        .map(|(number, gripper)| {
            json!({
                "sealed": gripper.sealed,
                "width": rounded(gripper.width),
                "holding": picture.held_by(number),
            })
        });
    let speeds = picture.conveyors.iter().copied().map(rounded);
    json!({
        "parts": parts.collect::<Value>(),
        "obstacles": obstacles.collect::<Value>(),
        "grippers": grippers.collect::<Value>(),
        "conveyors": speeds.collect::<Value>(),
        "detectors": picture.detectors,
        "counts": picture.counts,
    })
}

fn rounded(number: f64) -> f64 {
    let rounded = (number * STEPS).round() / STEPS;
    // No page shows a negative zero.
    rounded + 0.0
}

/// Looks at the world of a running controller from time to time.
#[derive(Debug)]
pub struct WorldWatch {
    changes: WorldChanges,
    picture: WorldPicture,
    text: Arc<str>,
}

impl WorldWatch {
    /// Nothing was seen yet.
    pub fn new(world: &CellWorld) -> Self {
        Self {
            changes: WorldChanges::new(world.description()),
            picture: WorldPicture::new(world.description()),
            text: Arc::from("null"),
        }
    }

    /// The moment now, as JSON text; the same `Arc` as long as nothing changes.
    pub fn look(&mut self, world: &CellWorld) -> Arc<str> {
        let (message, flange) = {
            let world = world.lock();
            let state = world.state();
            (
                self.changes.next(state.cycle, state),
                *world.base_from_flange(),
            )
        };
        if let Some(message) = message {
            self.picture.apply(&message, &flange);
            let text = moment(&self.picture).to_string();
            if *text != *self.text {
                self.text = text.into();
            }
        }
        self.text.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::meshes::tests::cell_with_corner;
    use controller::cell_world::topic::{GripperRow, PartRow, WorldMessage};
    use std::path::Path;

    const CELL: &str = "
[world]
floor = -0.5
[[part]]
name = 'box'
shape = 'box'
size = [0.1, 0.2, 0.3]
mass = 1
pose = [0.5, 0, 0.15, 0, 0, 0]
color = '#b07d48'
[[part]]
name = 'ball'
shape = 'sphere'
size = [0.05]
mass = 1
pose = [0.5, 0.5, 0.15, 0, 0, 0]
[[gripper]]
name = 'cups'
kind = 'vacuum'
cups = [[0, 0, 0.1]]
radius = 0.01
on = 'standard_digital_out[0]'
[[detector]]
name = 'eye'
kind = 'beam'
from = [0, 0, 0.1]
until = [0, 0.4, 0.1]
to = 'standard_digital_in[1]'
[[conveyor]]
name = 'table'
center = [1, 1, 0, 0, 0, 0]
radius = 0.4
speed = 0.5
[[sink]]
name = 'out'
pose = [1, 1, 1, 0, 0, 0]
size = [0.2, 0.2, 0.2]
";

    fn cell() -> (RobotModel, Cell) {
        let cell = Cell::from_text(CELL.to_owned(), Path::new("cell.toml")).unwrap();
        (RobotModel::built_in("cs66").unwrap(), cell)
    }

    #[test]
    fn the_scene_has_the_shapes_of_everything() {
        let (model, cell) = cell();
        let world = describe(&model, &cell, &mut MeshNumbers::default());
        assert_eq!(world["floor"], -0.5);
        let parts = &world["parts"];
        assert_eq!(parts[0]["color"], "#b07d48");
        assert_eq!(parts[0]["size"], json!([0.1, 0.2, 0.3]));
        assert_eq!(
            (&parts[1]["shape"], &parts[1]["color"]),
            (&json!("sphere"), &Value::Null)
        );
        assert_eq!(world["grippers"][0]["cups"], json!([[0.0, 0.0, 0.1]]));
        assert_eq!(world["conveyors"][0]["kind"], "turntable");
        assert_eq!(world["detectors"][0]["until"], json!([0.0, 0.4, 0.1]));
        assert_eq!(world["sinks"][0]["name"], "out");
    }

    #[test]
    fn parts_and_fingers_of_one_mesh_share_its_number() {
        let mesh = "shape = 'mesh'\nfile = 'corner.obj'\n";
        let text = format!(
            "[[part]]\nname = 'corner'\n{mesh}mass = 1\npose = [1, 0, 0, 0, 0, 0]\ncolor = '#336699'\n\
             [[part]]\nname = 'small'\n{mesh}scale = 0.1\nmass = 1\npose = [2, 0, 0, 0, 0, 0]\n\
             [[part]]\nname = 'ball'\nshape = 'sphere'\nsize = [0.05]\nmass = 1\npose = [3, 0, 0, 0, 0, 0]\n\
             [[gripper]]\nname = 'hand'\nkind = 'fingers'\nstroke = 0.1\naxis = [0, 1, 0]\nforce = 50\nspeed = 0.1\n\
             close = 'standard_digital_out[0]'\n\
             [gripper.finger]\n{mesh}scale = 0.1\npose = [0, 0, 0.1, 0, 0, 0]\n"
        );
        let cell = cell_with_corner(&text);
        let model = RobotModel::built_in("cs66").unwrap();
        let mut meshes = MeshNumbers::default();
        let world = describe(&model, &cell, &mut meshes);
        let part = json!({
            "name": "corner", "shape": "mesh", "size": [], "mesh": 0, "color": "#336699"
        });
        assert_eq!(world["parts"][0], part);
        assert_eq!(world["parts"][1]["mesh"], 1);
        assert_eq!(world["parts"][2].get("mesh"), None);
        let hand = &world["grippers"][0];
        assert_eq!(
            (&hand["kind"], &hand["shape"], &hand["mesh"]),
            (&json!("fingers"), &json!("mesh"), &json!(1))
        );
        assert_eq!(hand["pose"][11], 0.1);
        assert_eq!(meshes.encoded().count(), 2);
    }

    #[test]
    fn a_moment_tells_where_everything_is_and_who_holds_it() {
        let (model, cell) = cell();
        let mut picture = WorldPicture::new(&cell.drawn_world(&model).unwrap());
        let part = |name: &str, z: f64, held_by: Option<&str>| PartRow {
            name: name.to_owned(),
            pose: [0.5, -1e-9, z, 0.0, 0.0, 0.0],
            speed: 0.0,
            on_floor: false,
            held_by: held_by.map(str::to_owned),
        };
        picture.apply(
            &WorldMessage {
                parts: vec![
                    part("box", 0.123_456_7, None),
                    part("ball", 0.5, Some("cups")),
                ],
                grippers: vec![GripperRow {
                    name: "cups".to_owned(),
                    sealed: vec![true],
                    width: 0.0,
                }],
                detectors: vec![true],
                counts: vec![4],
                conveyors: vec![0.5],
                ..WorldMessage::default()
            },
            &Pose::from_translation(0.5, 0.0, 0.6),
        );
        let moment = moment(&picture);
        let ball = json!({"name": "ball", "pose": [0.0, 0.0, -0.1, 0.0, 0.0, 0.0], "held_by": 0});
        let lying = json!({"name": "box", "pose": [0.5, 0.0, 0.12346, 0.0, 0.0, 0.0]});
        assert_eq!(moment["parts"], json!([ball, lying]));
        let cups = json!({"sealed": [true], "width": 0.0, "holding": "ball"});
        assert_eq!(moment["grippers"], json!([cups]));
        assert_eq!(moment["detectors"], json!([true]));
        assert_eq!(
            (&moment["counts"], &moment["conveyors"]),
            (&json!([4]), &json!([0.5]))
        );
    }
}
