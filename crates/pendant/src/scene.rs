//! What the page draws, as JSON: the arm's chain and shapes, what stands around it, safety planes. Pure.
//!
//! The page moves the arm itself: it gets the fixed transforms of the chain once and joint positions with every frame.

use std::sync::Arc;

use controller::cell::Cell;
use controller::cell_world::BodyShape;
use kinematics::{Pose, RobotModel};
use recorder::ObstacleShape;
use serde_json::{Value, json};

use crate::living_cell;
use crate::meshes::{MeshNumbers, SceneMeshes};

/// What the page draws.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PageScene {
    /// Everything but the meshes, which it names by number.
    pub description: Value,
    /// The meshes.
    pub meshes: SceneMeshes,
}

/// The scene of an arm in its cell.
pub fn describe(model: &RobotModel, cell: Option<&Cell>) -> PageScene {
    let mut meshes = MeshNumbers::default();
    let obstacles = cell.map_or_else(|| json!([]), |cell| obstacles(cell, &mut meshes));
    let tool = cell.map_or(Value::Null, |cell| tool(cell, &mut meshes));
    let world = cell.map_or(Value::Null, |cell| {
        living_cell::describe(model, cell, &mut meshes)
    });
    let mut description = describe_arm(model);
    description["obstacles"] = obstacles;
    description["tool"] = tool;
    description["planes"] = cell.map_or_else(|| json!([]), planes);
    description["names"] = cell.map_or_else(|| json!({}), names);
    description["wires"] = cell.map_or_else(|| json!([]), wires);
    description["safety_inputs"] = cell.map_or_else(|| json!([]), safety_inputs);
    description["world"] = world;
    PageScene {
        description,
        meshes: meshes.encoded(),
    }
}

fn describe_arm(model: &RobotModel) -> Value {
    let chain = model.chain();
    let links = (0..=6).map(|link| {
        let capsules = model.collision().capsules(link).iter();
        let capsules = capsules.map(|capsule| {
            let (a, b) = (capsule.p0, capsule.p1);
            json!({"from": [a.x, a.y, a.z], "to": [b.x, b.y, b.z], "radius": capsule.radius})
        });
        capsules.collect::<Value>()
    });
    let limits = model.limits();
    json!({
        "model": model.name(),
        "joints": chain.parent_from_joint.iter().map(matrix).collect::<Value>(),
        "flange": matrix(&chain.joint6_from_flange),
        "links": links.collect::<Value>(),
        "position_min": limits.position_min.0,
        "position_max": limits.position_max.0,
        "speed_max": limits.speed.0,
        "torque_max": limits.effort.0,
    })
}

/// What people call inputs and outputs.
fn names(cell: &Cell) -> Value {
    let names = cell.point_names();
    let names = names.map(|(point, name)| (point.to_string(), Value::from(name)));
    Value::Object(names.collect())
}

fn wires(cell: &Cell) -> Value {
    let wires = cell.wires();
    let wires = wires.map(|(from, to)| json!({"from": from.to_string(), "to": to.to_string()}));
    wires.collect()
}

fn safety_inputs(cell: &Cell) -> Value {
    let inputs = cell.safety_input_pairs().map(|(points, function)| {
        json!({"points": points.map(|point| point.to_string()), "function": function})
    });
    inputs.collect()
}

/// Twelve numbers: three rows of rotation and translation.
pub(crate) fn matrix(pose: &Pose) -> Value {
    let (r, t) = (&pose.rotation, &pose.translation);
    let rows = (0..3).flat_map(|row| [r[(row, 0)], r[(row, 1)], r[(row, 2)], t[row]]);
    rows.collect()
}

/// The keys of a shape in a row of the scene.
pub(crate) struct ShapeRow {
    shape: &'static str,
    size: Vec<f64>,
    mesh: Option<usize>,
}

impl ShapeRow {
    /// A plane has no size, a mesh only a number.
    fn new(shape: &'static str, size: impl Into<Vec<f64>>) -> Self {
        Self {
            shape,
            size: size.into(),
            mesh: None,
        }
    }

    fn of_mesh(mesh: &Arc<mesh::Mesh>, meshes: &mut MeshNumbers) -> Self {
        Self {
            mesh: Some(meshes.of(mesh)),
            ..Self::new("mesh", [])
        }
    }

    /// The shape of a body.
    pub(crate) fn of(shape: &BodyShape, meshes: &mut MeshNumbers) -> Self {
        match *shape {
            BodyShape::Box { size } => Self::new("box", size),
            BodyShape::Cylinder { radius, length } => Self::new("cylinder", [radius, length]),
            BodyShape::Sphere { radius } => Self::new("sphere", [radius]),
            BodyShape::Plane => Self::new("plane", []),
            BodyShape::Mesh(ref body) => Self::of_mesh(body.solid().mesh(), meshes),
        }
    }

    /// The shape of an obstacle.
    fn of_obstacle(shape: &ObstacleShape, meshes: &mut MeshNumbers) -> Self {
        match *shape {
            ObstacleShape::Box(size) => Self::new("box", size),
            ObstacleShape::Cylinder { radius, length } => Self::new("cylinder", [radius, length]),
            ObstacleShape::Sphere { radius } => Self::new("sphere", [radius]),
            ObstacleShape::Mesh(ref mesh) => Self::of_mesh(mesh, meshes),
            ObstacleShape::Plane | ObstacleShape::Arrow { .. } => Self::new("plane", []),
        }
    }

    /// `shape`, `size` and, for a mesh, its number.
    pub(crate) fn json(self) -> Value {
        let mut row = json!({"shape": self.shape, "size": self.size});
        if let Some(number) = self.mesh {
            row["mesh"] = number.into();
        }
        row
    }
}

fn obstacles(cell: &Cell, meshes: &mut MeshNumbers) -> Value {
    let stiffness = cell.stiffness();
    let drawn = cell.scene_obstacles().into_iter();
    let obstacles = drawn.map(|obstacle| {
        let stiffness = stiffness.iter().find(|(name, _)| *name == obstacle.name);
        let mut row = ShapeRow::of_obstacle(&obstacle.shape, meshes).json();
        row["pose"] = matrix(&Pose::from_rpy(&obstacle.pose));
        row["stiffness"] = json!(stiffness.and_then(|(_, stiffness)| *stiffness));
        row["name"] = obstacle.name.into();
        row
    });
    obstacles.collect()
}

/// The shape on the flange, with its pose in the flange frame; null without one.
fn tool(cell: &Cell, meshes: &mut MeshNumbers) -> Value {
    cell.tool_solid().map_or(Value::Null, |(shape, pose)| {
        let mut row = ShapeRow::of(&shape, meshes).json();
        row["pose"] = matrix(&pose);
        row
    })
}

fn planes(cell: &Cell) -> Value {
    let planes = cell.planes().into_iter().map(|(name, point, normal, mode)| {
        json!({"name": name, "point": point, "normal": normal, "mode": mode})
    });
    planes.collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::meshes::tests::cell_with_corner;
    use std::path::Path;

    #[test]
    fn the_chain_is_that_of_the_model_and_the_cell_is_named() {
        let model = RobotModel::built_in("cs66").unwrap();
        let text = "[[obstacle]]\nname = 'table'\nshape = 'box'\nsize = [1, 1, 0.1]\npose = [0, 0, -0.05, 0, 0, 0]\n\
            stiffness = 2e4\n[[safety_plane]]\nname = 'wall'\npoint = [1, 0, 0]\nnormal = [-1, 0, 0]\n[[wire]]\n\
            from = 'standard_digital_out[1]'\nto = 'standard_digital_in[2]'\n[[safety_input]]\n\
            function = 'safeguard_stop'\npair = 1\n[names]\n'standard_digital_out[1]' = 'vacuum'\n";
        let cell = Cell::from_text(text.to_owned(), Path::new("cell.toml")).unwrap();
        let scene = describe(&model, Some(&cell)).description;
        assert_eq!(scene["joints"].as_array().unwrap().len(), 6);
        assert_eq!(scene["links"].as_array().unwrap().len(), 7);
        assert_eq!(scene["joints"][0].as_array().unwrap().len(), 12);
        assert_eq!(scene["obstacles"][0]["name"], "table");
        assert_eq!(scene["obstacles"][0]["stiffness"], 2e4);
        assert_eq!(scene["planes"][0]["mode"], "normal");
        assert_eq!(scene["names"], json!({"standard_digital_out[1]": "vacuum"}));
        let wire = json!({"from": "standard_digital_out[1]", "to": "standard_digital_in[2]"});
        assert_eq!(scene["wires"], json!([wire]));
        let pair = ["configurable_digital_in[2]", "configurable_digital_in[3]"];
        let safeguard = json!({"points": pair, "function": "safeguard_stop"});
        assert_eq!(scene["safety_inputs"], json!([safeguard]));
        assert_eq!(scene["world"], Value::Null);
        assert_eq!(scene["tool"], Value::Null);
        assert_eq!(scene["obstacles"][0].get("mesh"), None);
        let empty = describe(&model, None);
        assert_eq!(empty.description["obstacles"], json!([]));
        assert_eq!(empty.meshes.count(), 0);
    }

    #[test]
    fn obstacles_and_tool_name_their_meshes_by_number() {
        let mesh = "shape = 'mesh'\nfile = 'corner.obj'\n";
        let pose = "pose = [1, 0, 0, 0, 0, 0]\n";
        let text = format!(
            "[[obstacle]]\nname = 'left'\n{mesh}{pose}stiffness = 2e4\n\
             [[obstacle]]\nname = 'right'\n{mesh}{pose}\
             [tool]\n{mesh}scale = 0.001\npose = [0, 0, 0.25, 0, 0, 0]\n\
             [[part]]\nname = 'part'\n{mesh}mass = 1\n{pose}"
        );
        let cell = cell_with_corner(&text);
        let model = RobotModel::built_in("cs66").unwrap();
        let PageScene {
            description,
            meshes,
        } = describe(&model, Some(&cell));
        let left = json!({
            "name": "left", "shape": "mesh", "size": [], "mesh": 0, "stiffness": 2e4,
            "pose": [1.0, 0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        });
        assert_eq!(description["obstacles"][0], left);
        assert_eq!(description["obstacles"][1]["mesh"], 0);
        let tool = json!({
            "shape": "mesh", "size": [], "mesh": 1,
            "pose": [1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.25],
        });
        assert_eq!(description["tool"], tool);
        assert_eq!(description["world"]["parts"][0]["mesh"], 0);
        assert_eq!(meshes.count(), 2);
        let x_of_second_point = |number: usize| {
            let bytes = &meshes.get(number).unwrap().bytes;
            f32::from_le_bytes(bytes[20..24].try_into().unwrap())
        };
        assert_eq!((x_of_second_point(0), x_of_second_point(1)), (1.0, 0.001));
    }

    #[test]
    fn a_tool_of_any_shape_is_drawn() {
        let text = "[tool]\nshape = 'cylinder'\nsize = [0.03, 0.1]\npose = [0, 0, 0.05, 0, 0, 0]\n";
        let cell = Cell::from_text(text.to_owned(), Path::new("cell.toml")).unwrap();
        let model = RobotModel::built_in("cs66").unwrap();
        let tool = &describe(&model, Some(&cell)).description["tool"];
        assert_eq!(
            (&tool["shape"], &tool["size"], &tool["pose"][11]),
            (&json!("cylinder"), &json!([0.03, 0.1]), &json!(0.05))
        );
    }
}
