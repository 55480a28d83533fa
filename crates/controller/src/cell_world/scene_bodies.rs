//! The picture of the world as solids in colours, as public viewers draw it.

use std::sync::Arc;

use kinematics::Pose;
use nalgebra::{Rotation3, Unit, UnitQuaternion, Vector3};
use recorder::{ObstacleShape, SceneBody, SceneFrame};
use world::description::{
    ConveyorDescription, DetectorKind, Gripper, GripperKind, Surface, Vacuum, WorldDescription,
};

use super::picture::WorldPicture;
use super::topic::GripperRow;
use crate::cell::shape::drawn_shape;

type Color = [f64; 4];

/// A part whose table gives no colour.
const PART: Color = [0.50, 0.65, 0.82, 1.0];
const BELT: Color = [0.24, 0.27, 0.31, 1.0];
const ARROW: Color = [0.92, 0.92, 0.92, 0.9];
const ARROW_STILL: Color = [0.55, 0.55, 0.55, 0.5];
const CUP: Color = [0.20, 0.22, 0.25, 1.0];
const CUP_SEALED: Color = [0.15, 0.70, 0.45, 1.0];
const FINGER: Color = [0.35, 0.38, 0.42, 1.0];
const MOVED: Color = [0.55, 0.60, 0.68, 0.9];
const DARK_BEAM: Color = [0.55, 0.15, 0.15, 0.5];
const LIT_BEAM: Color = [1.0, 0.15, 0.10, 1.0];
const SINK: Color = [0.35, 0.55, 0.85, 0.12];

/// Radius of a line of light, m.
const BEAM_RADIUS: f64 = 0.002;
/// Depth of a cup behind its rim, m.
const CUP_DEPTH: f64 = 0.015;
/// Thickness of a turntable, m.
const TURNTABLE_HEIGHT: f64 = 0.05;

/// What does not change from one picture to the next.
#[derive(Clone, Debug)]
pub(super) struct SceneBodies {
    description: WorldDescription,
    colors: Vec<Color>,
    /// The two fingers of each gripper that has some. Viewers know a mesh by its identity, so it is made once.
    fingers: Vec<Option<[ObstacleShape; 2]>>,
}

impl SceneBodies {
    /// For the world of a description; `colors` are those of its tables of parts, `#rrggbb`.
    pub(super) fn new(description: &WorldDescription, colors: &[Option<String>]) -> Self {
        let color = |number: usize| {
            let text = colors.get(number).and_then(Option::as_deref);
            text.and_then(color_of).unwrap_or(PART)
        };
        let grippers = description.grippers.iter();
        let fingers = grippers.map(|gripper| match &gripper.kind {
            GripperKind::Fingers(fingers) => {
                Some(fingers.shapes().map(|shape| drawn_shape(&shape)))
            }
            GripperKind::Vacuum(_) => None,
        });
        Self {
            fingers: fingers.collect(),
            colors: (0..description.parts.len()).map(color).collect(),
            description: description.clone(),
        }
    }

    /// Everything there is, in the order of names.
    pub(super) fn of(&self, picture: &WorldPicture) -> Arc<[SceneBody]> {
        let mut bodies = Vec::with_capacity(picture.parts.len() + 16);
        for (name, part) in &picture.parts {
            let Some(table) = self.description.parts.get(part.template) else {
                continue;
            };
            bodies.push(SceneBody {
                id: format!("part/{name}").into(),
                frame: match part.held_by {
                    Some(_) => SceneFrame::Flange,
                    None => SceneFrame::Base,
                },
                pose: part.pose,
                shape: drawn_shape(&table.shape),
                color: self.colors.get(part.template).copied().unwrap_or(PART),
            });
        }
        for obstacle in &self.description.obstacles {
            if let Some(pose) = picture.obstacles.get(&obstacle.name) {
                // Its identifier is that of the obstacle at rest, which it takes the place of.
                let id = format!("obstacle/{}", obstacle.name);
                bodies.push(body(id, *pose, drawn_shape(&obstacle.shape), MOVED));
            }
        }
        for (number, conveyor) in self.description.conveyors.iter().enumerate() {
            let speed = picture.conveyors.get(number).copied().unwrap_or_default();
            add_conveyor(&mut bodies, conveyor, speed);
        }
        for (number, detector) in self.description.detectors.iter().enumerate() {
            let sees = picture.detectors.get(number).copied().unwrap_or_default();
            let color = if sees { LIT_BEAM } else { DARK_BEAM };
            let id = format!("detector/{}", detector.name);
            bodies.push(match detector.kind {
                DetectorKind::Beam { from, until } => beam(id, from.into(), until.into(), color),
                DetectorKind::Presence { pose, size } => {
                    let [r, g, b, _] = color;
                    body(id, pose, ObstacleShape::Box(size), [r, g, b, 0.15])
                }
                DetectorKind::Distance { pose, range } => {
                    let end = pose * Pose::from_translation(0.0, 0.0, range);
                    beam(id, pose.translation, end.translation, color)
                }
            });
        }
        for sink in &self.description.sinks {
            let id = format!("sink/{}", sink.name);
            bodies.push(body(id, sink.pose, ObstacleShape::Box(sink.size), SINK));
        }
        let grippers = self.description.grippers.iter().zip(&self.fingers);
        for ((gripper, fingers), row) in grippers.zip(&picture.grippers) {
            add_gripper(&mut bodies, gripper, fingers.as_ref(), row);
        }
        bodies.into()
    }
}

fn body(id: String, pose: Pose, shape: ObstacleShape, color: Color) -> SceneBody {
    SceneBody {
        id: id.into(),
        frame: SceneFrame::Base,
        pose,
        shape,
        color,
    }
}

/// A thin cylinder from one point to another.
fn beam(id: String, from: Vector3<f64>, until: Vector3<f64>, color: Color) -> SceneBody {
    let way = until - from;
    let pose = Pose::new(turn_of_z_to(way), (from + until) / 2.0);
    let shape = ObstacleShape::Cylinder {
        radius: BEAM_RADIUS,
        length: way.norm(),
    };
    body(id, pose, shape, color)
}

fn add_conveyor(bodies: &mut Vec<SceneBody>, conveyor: &ConveyorDescription, speed: f64) {
    let id = format!("conveyor/{}", conveyor.name);
    let (pose, shape, arrow) = match conveyor.surface {
        Surface::Belt {
            pose,
            size,
            direction,
        } => {
            let direction = Vector3::from(direction).normalize();
            let up = pose.rotate(Vector3::z()) * (size[2] / 2.0 + BEAM_RADIUS);
            let half = direction * (0.3 * size[0].max(size[1]));
            let middle = pose.translation + up;
            let arrow = (middle - half, middle + half);
            (pose, ObstacleShape::Box(size), arrow)
        }
        Surface::Turntable { center, radius } => {
            let below = center * Pose::from_translation(0.0, 0.0, -TURNTABLE_HEIGHT / 2.0);
            let at = |x: f64, y: f64| center.transform_point(Vector3::new(x, y, BEAM_RADIUS));
            let arrow = (
                at(0.7 * radius, -0.3 * radius),
                at(0.7 * radius, 0.3 * radius),
            );
            let shape = ObstacleShape::Cylinder {
                radius,
                length: TURNTABLE_HEIGHT,
            };
            (below, shape, arrow)
        }
    };
    bodies.push(body(id.clone(), pose, shape, BELT));
    let (tail, tip) = match speed < 0.0 || (speed == 0.0 && conveyor.speed < 0.0) {
        true => (arrow.1, arrow.0),
        false => arrow,
    };
    let way = tip - tail;
    bodies.push(body(
        format!("{id}/direction"),
        Pose::new(turn_of_z_to(way), tail),
        ObstacleShape::Arrow { length: way.norm() },
        if speed == 0.0 { ARROW_STILL } else { ARROW },
    ));
}

fn add_gripper(
    bodies: &mut Vec<SceneBody>,
    gripper: &Gripper,
    finger_shapes: Option<&[ObstacleShape; 2]>,
    row: &GripperRow,
) {
    let mut add = |number: usize, what: &str, pose: Pose, shape: ObstacleShape, color: Color| {
        bodies.push(SceneBody {
            id: format!("gripper/{}/{what} {}", gripper.name, number + 1).into(),
            frame: SceneFrame::Flange,
            pose,
            shape,
            color,
        });
    };
    match &gripper.kind {
        GripperKind::Vacuum(Vacuum {
            cups,
            direction,
            radius,
            ..
        }) => {
            let direction = Vector3::from(*direction).normalize();
            for (number, rim) in cups.iter().enumerate() {
                let middle = Vector3::from(*rim) - direction * (CUP_DEPTH / 2.0);
                let shape = ObstacleShape::Cylinder {
                    radius: *radius,
                    length: CUP_DEPTH,
                };
                let is_sealed = row.sealed.get(number).copied().unwrap_or_default();
                let color = if is_sealed { CUP_SEALED } else { CUP };
                add(
                    number,
                    "cup",
                    Pose::new(turn_of_z_to(direction), middle),
                    shape,
                    color,
                );
            }
        }
        GripperKind::Fingers(fingers) => {
            let poses = fingers.poses(row.width).into_iter();
            for (number, (pose, shape)) in
                poses.zip(finger_shapes.into_iter().flatten()).enumerate()
            {
                add(number, "finger", pose, shape.clone(), FINGER);
            }
        }
    }
}

/// The rotation that turns z into a direction; half a turn about x where it is opposite.
fn turn_of_z_to(direction: Vector3<f64>) -> Rotation3<f64> {
    let Some(direction) = Unit::try_new(direction, 1e-12) else {
        return Rotation3::identity();
    };
    let turn = UnitQuaternion::rotation_between_axis(&Vector3::z_axis(), &direction);
    let turn = turn.unwrap_or_else(|| {
        UnitQuaternion::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI)
    });
    turn.to_rotation_matrix()
}

/// `#rrggbb` as red, green, blue and full opacity.
fn color_of(text: &str) -> Option<Color> {
    let digits = text.strip_prefix('#')?;
    let number = u32::from_str_radix(digits, 16).ok()?;
    let part = |shift: u32| f64::from((number >> shift) & 0xff) / 255.0;
    Some([part(16), part(8), part(0), 1.0])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cell::Cell;
    use crate::cell_world::topic::{ObstacleRow, PartRow, WorldMessage};
    use kinematics::RobotModel;
    use std::path::Path;

    const CELL: &str = "
[[obstacle]]
name = 'door'
shape = 'box'
size = [0.4, 0.01, 0.3]
pose = [-0.05, 0.17, 0.25, 0, 0, 0]
[[actuator]]
name = 'drive'
kind = 'linear'
axis = [-1, 0, 0]
stroke = 0.4
moves = ['door']
extend = 'standard_digital_out[1]'
[[part]]
name = 'box'
shape = 'box'
size = [0.1, 0.1, 0.1]
mass = 1
pose = [0.5, 0, 0.05, 0, 0, 0]
color = '#ff8000'
copies = [2, 1, 1]
pitch = [0.2, 0, 0]
[[conveyor]]
name = 'belt'
pose = [-0.45, -0.55, 0.05, 0, 0, 0]
size = [0.14, 0.72, 0.10]
direction = [0, 1, 0]
speed = 0.2
run = 'standard_digital_out[2]'
[[detector]]
name = 'eye'
kind = 'beam'
from = [0, 0, 0.1]
until = [0, 0.4, 0.1]
to = 'standard_digital_in[1]'
[[gripper]]
name = 'cups'
kind = 'vacuum'
cups = [[0, 0, 0.1], [0.05, 0, 0.1]]
radius = 0.01
on = 'standard_digital_out[0]'
[[sink]]
name = 'out'
pose = [1, 1, 1, 0, 0, 0]
size = [0.2, 0.2, 0.2]
";

    fn bodies(message: &WorldMessage, flange: &Pose) -> (WorldPicture, Arc<[SceneBody]>) {
        let cell = Cell::from_text(CELL.to_owned(), Path::new("cell.toml")).unwrap();
        let model = RobotModel::built_in("cs66").unwrap();
        let description = cell.drawn_world(&model).unwrap();
        let mut picture = WorldPicture::new(&description);
        picture.apply(message, flange);
        let bodies = SceneBodies::new(&description, &cell.part_colors()).of(&picture);
        (picture, bodies)
    }

    fn named<'a>(bodies: &'a [SceneBody], id: &str) -> &'a SceneBody {
        let found = bodies.iter().find(|body| &*body.id == id);
        found.unwrap_or_else(|| panic!("no {id}"))
    }

    #[test]
    fn everything_of_the_cell_is_drawn_where_and_as_the_messages_say() {
        let flange = Pose::from_translation(0.4, 0.0, 0.5);
        let part = |name: &str, pose, held_by: Option<&str>| PartRow {
            name: name.to_owned(),
            pose,
            speed: 0.0,
            on_floor: false,
            held_by: held_by.map(str::to_owned),
        };
        let message = WorldMessage {
            cycle: 7,
            parts: vec![
                part("box[0]", [0.5, 0.0, 0.05, 0.0, 0.0, 0.0], None),
                part("box[1]", [0.4, 0.0, 0.35, 0.0, 0.0, 0.0], Some("cups")),
                part("of another file", [0.0; 6], None),
            ],
            obstacles: vec![ObstacleRow {
                name: "door".to_owned(),
                pose: [-0.45, 0.17, 0.25, 0.0, 0.0, 0.0],
            }],
            counts: vec![3],
            detectors: vec![true],
            grippers: vec![GripperRow {
                name: "cups".to_owned(),
                sealed: vec![true, false],
                width: 0.0,
            }],
            conveyors: vec![0.2],
            ..WorldMessage::default()
        };
        let (picture, bodies) = bodies(&message, &flange);
        assert_eq!(picture.held_by(0), Some("box[1]"));
        assert_eq!(picture.counts, [3]);
        let lying = named(&bodies, "part/box[0]");
        assert_eq!(
            (lying.frame, lying.color),
            (SceneFrame::Base, [1.0, 128.0 / 255.0, 0.0, 1.0])
        );
        let held = named(&bodies, "part/box[1]");
        assert_eq!(held.frame, SceneFrame::Flange);
        assert!((held.pose.translation.z + 0.15).abs() < 1e-12);
        assert_eq!(named(&bodies, "obstacle/door").pose.translation.x, -0.45);
        assert_eq!(named(&bodies, "detector/eye").color, LIT_BEAM);
        assert_eq!(named(&bodies, "gripper/cups/cup 1").color, CUP_SEALED);
        assert_eq!(named(&bodies, "gripper/cups/cup 2").color, CUP);
        let arrow = named(&bodies, "conveyor/belt/direction");
        assert_eq!(arrow.color, ARROW);
        let tip = arrow.pose.rotate(Vector3::z());
        assert!((tip - Vector3::y()).norm() < 1e-12, "{tip}");
        assert_eq!(
            bodies
                .iter()
                .filter(|body| body.id.starts_with("part/"))
                .count(),
            2
        );
        assert!(bodies.iter().any(|body| &*body.id == "sink/out"));
    }

    #[test]
    fn a_part_that_is_removed_is_drawn_no_more_and_short_lists_change_nothing() {
        let message = WorldMessage {
            detectors: vec![true, true],
            counts: vec![1, 2, 3],
            removed: vec!["box[0]".to_owned()],
            ..WorldMessage::default()
        };
        let (picture, bodies) = bodies(&message, &Pose::IDENTITY);
        assert_eq!((picture.detectors, picture.counts), (vec![false], vec![0]));
        assert!(!bodies.iter().any(|body| body.id.starts_with("part/")));
        assert_eq!(named(&bodies, "conveyor/belt/direction").color, ARROW_STILL);
    }

    #[test]
    fn fingers_stand_as_far_apart_as_their_opening_says() {
        let fingers = world::description::Fingers {
            stroke: 0.06,
            axis: [0.0, 2.0, 0.0],
            finger: (
                world::description::BodyShape::Box {
                    size: [0.02, 0.01, 0.03],
                },
                Pose::from_translation(0.0, 0.005, 0.125),
            ),
            force: 40.0,
            speed: 0.1,
            friction: 0.5,
            control: world::description::FingerControl::Orders,
            opened: None,
            closed: None,
            gripping: None,
        };
        let [near, far] = fingers.poses(0.04);
        let gap = near.translation.y - far.translation.y;
        // The inner faces: half a finger on each side.
        assert!((gap - 0.01 - 0.04).abs() < 1e-12, "{gap}");
    }
}
