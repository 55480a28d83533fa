//! What the page draws, as JSON: the arm's chain and shapes, what stands around it, safety planes. Pure.
//!
//! The page moves the arm itself: it gets the fixed transforms of the chain once and joint positions with every frame.

use controller::cell::Cell;
use kinematics::{Pose, RobotModel};
use recorder::ObstacleShape;
use serde_json::{Value, json};

use crate::living_cell;

/// The scene of an arm in its cell.
pub fn describe(model: &RobotModel, cell: Option<&Cell>) -> Value {
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
        "obstacles": cell.map_or_else(|| json!([]), obstacles),
        "planes": cell.map_or_else(|| json!([]), planes),
        "names": cell.map_or_else(|| json!({}), names),
        "wires": cell.map_or_else(|| json!([]), wires),
        "safety_inputs": cell.map_or_else(|| json!([]), safety_inputs),
        "world": cell.map_or(Value::Null, |cell| living_cell::describe(model, cell)),
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

fn obstacles(cell: &Cell) -> Value {
    let stiffness = cell.stiffness();
    let drawn = cell.scene_obstacles().into_iter();
    let obstacles = drawn.map(|obstacle| {
        let (shape, size) = match obstacle.shape {
            ObstacleShape::Box(size) => ("box", size.to_vec()),
            ObstacleShape::Cylinder { radius, length } => ("cylinder", vec![radius, length]),
            ObstacleShape::Sphere { radius } => ("sphere", vec![radius]),
            ObstacleShape::Mesh(_) => ("mesh", Vec::new()),
            ObstacleShape::Plane | ObstacleShape::Arrow { .. } => ("plane", Vec::new()),
        };
        json!({
            "name": obstacle.name,
            "shape": shape,
            "size": size,
            "pose": matrix(&Pose::from_rpy(&obstacle.pose)),
            "stiffness": stiffness.iter().find(|(name, _)| *name == obstacle.name).and_then(|(_, k)| *k),
        })
    });
    obstacles.collect()
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
    use std::path::Path;

    #[test]
    fn the_chain_is_that_of_the_model_and_the_cell_is_named() {
        let model = RobotModel::built_in("cs66").unwrap();
        let text = "[[obstacle]]\nname = 'table'\nshape = 'box'\nsize = [1, 1, 0.1]\npose = [0, 0, -0.05, 0, 0, 0]\n\
            stiffness = 2e4\n[[safety_plane]]\nname = 'wall'\npoint = [1, 0, 0]\nnormal = [-1, 0, 0]\n[[wire]]\n\
            from = 'standard_digital_out[1]'\nto = 'standard_digital_in[2]'\n[[safety_input]]\n\
            function = 'safeguard_stop'\npair = 1\n[names]\n'standard_digital_out[1]' = 'vacuum'\n";
        let cell = Cell::from_text(text.to_owned(), Path::new("cell.toml")).unwrap();
        let scene = describe(&model, Some(&cell));
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
        assert_eq!(describe(&model, None)["obstacles"], json!([]));
    }
}
