//! What is drawn: the arm from its capsules, the obstacles, what lives in the cell, the way of the TCP, the force on
//! it. Pure shapes.

use std::sync::Arc;

use foxglove::messages as shown;
use foxglove::messages::Timestamp;
use foxglove::messages::line_primitive::Type as LineType;
use foxglove::messages::scene_entity_deletion::Type as DeletionType;
use kinematics::{Capsule, Pose, RobotModel, RpyPose};
use mesh::Mesh;
use nalgebra::{Unit, UnitQuaternion, Vector3};

use super::{BASE_FRAME, FLANGE_FRAME, LINK_FRAMES, TCP_FRAME};

/// Diameter of the ball that marks the TCP, m.
const TCP_BALL: f64 = 0.012;
/// A plane is drawn as a plate of this side and thickness, m.
const PLATE: (f64, f64) = (3.0, 0.004);
/// Length of the arrow of a force, m/N, and its greatest length, m.
const METERS_PER_NEWTON: f64 = 0.004;
const ARROW_MAX: f64 = 0.6;
/// Smaller forces have no arrow, N.
pub(super) const FORCE_MIN: f64 = 1.0;

const LIGHT: shown::Color = color(0.88, 0.89, 0.91, 1.0);
const DARK: shown::Color = color(0.36, 0.42, 0.50, 1.0);
const ACCENT: shown::Color = color(0.90, 0.35, 0.10, 1.0);
const TRACE: shown::Color = color(0.10, 0.50, 0.85, 1.0);
const FORCE: shown::Color = color(0.85, 0.10, 0.15, 1.0);
/// Red, green, blue and opacity of obstacles.
pub(super) const OBSTACLE_COLOR: [f64; 4] = [0.62, 0.56, 0.42, 0.85];
const PLANE: shown::Color = color(0.55, 0.60, 0.55, 0.35);

pub(super) const fn color_of([r, g, b, a]: [f64; 4]) -> shown::Color {
    color(r, g, b, a)
}

const fn color(r: f64, g: f64, b: f64, a: f64) -> shown::Color {
    shown::Color { r, g, b, a }
}

/// A thing of the cell that the arm can hit, in the base frame.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneObstacle {
    /// Name of the obstacle in the cell file.
    pub name: String,
    /// Shape of the obstacle.
    pub shape: ObstacleShape,
    /// Pose of the shape's middle; of a plane, of a point on it.
    pub pose: RpyPose,
}

/// A solid of a cell that lives: it moves, comes and goes, or shows something by its colour.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneBody {
    /// What viewers call it, `part/box[3]` for instance; no two of a scene have the same. The frame of a mesh has this
    /// name, too.
    pub id: Arc<str>,
    /// The frame that its pose is in.
    pub frame: SceneFrame,
    /// Pose of the shape's middle; of an arrow, of its tail.
    pub pose: Pose,
    /// Shape of the body.
    pub shape: ObstacleShape,
    /// Red, green, blue and opacity, 0 to 1.
    pub color: [f64; 4],
}

/// What a [`SceneBody`] moves with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneFrame {
    /// Nothing.
    Base,
    /// The tool flange.
    Flange,
}

/// Shape of an obstacle or a body, m.
#[derive(Clone, Debug, PartialEq)]
pub enum ObstacleShape {
    /// Lengths along x, y and z.
    Box([f64; 3]),
    /// Along z.
    Cylinder {
        /// Radius, m.
        radius: f64,
        /// Length along z, m.
        length: f64,
    },
    /// A ball.
    Sphere {
        /// Radius, m.
        radius: f64,
    },
    /// Everything below the x-y plane; z points out of it. Drawn as a plate of 3 m.
    Plane,
    /// An arrow along z: a direction, and no solid.
    Arrow {
        /// Length, m.
        length: f64,
    },
    /// Triangles about the origin of the pose.
    Mesh(Arc<Mesh>),
}

impl ObstacleShape {
    pub(super) fn is_mesh(&self) -> bool {
        matches!(self, Self::Mesh(_))
    }
}

impl SceneFrame {
    /// What viewers call the frame.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Base => BASE_FRAME,
            Self::Flange => FLANGE_FRAME,
        }
    }
}

/// The arm, one entity a link, each fixed to its frame so that `/tf` moves it; and the TCP as a ball.
pub(super) fn arm(model: &RobotModel, at: Timestamp) -> Vec<shown::SceneEntity> {
    let names = [BASE_FRAME].into_iter().chain(LINK_FRAMES);
    let mut entities: Vec<_> = names
        .enumerate()
        .map(|(link, name)| {
            let color = if link % 2 == 0 { LIGHT } else { DARK };
            let mut drawn = entity(name, name, at);
            for capsule in model.collision().capsules(link) {
                draw_capsule(capsule, color, &mut drawn);
            }
            drawn
        })
        .collect();
    let mut tcp = entity(TCP_FRAME, TCP_FRAME, at);
    tcp.spheres.push(ball(Vector3::zeros(), TCP_BALL, ACCENT));
    entities.push(tcp);
    entities
}

/// What viewers call an obstacle.
pub(super) fn obstacle_id(obstacle: &SceneObstacle) -> String {
    format!("obstacle/{}", obstacle.name)
}

/// An obstacle as an entity of its own, named `obstacle/NAME`.
pub(super) fn obstacle(obstacle: &SceneObstacle, at: Timestamp) -> shown::SceneEntity {
    let mut drawn = entity(BASE_FRAME, &obstacle_id(obstacle), at);
    let color = match obstacle.shape {
        ObstacleShape::Plane => PLANE,
        _ => color_of(OBSTACLE_COLOR),
    };
    draw_shape(
        &obstacle.shape,
        &Pose::from_rpy(&obstacle.pose),
        color,
        &mut drawn,
    );
    drawn
}

/// A body as an entity of its own.
pub(super) fn body(body: &SceneBody, at: Timestamp) -> shown::SceneEntity {
    let mut drawn = entity(body.frame.name(), &body.id, at);
    draw_shape(&body.shape, &body.pose, color_of(body.color), &mut drawn);
    drawn
}

/// An entity that is drawn no more.
pub(super) fn deletion(id: &str, at: Timestamp) -> shown::SceneEntityDeletion {
    shown::SceneEntityDeletion {
        timestamp: Some(at),
        r#type: DeletionType::MatchingId.into(),
        id: id.to_owned(),
    }
}

fn draw_shape(
    shape: &ObstacleShape,
    frame_from_shape: &Pose,
    color: shown::Color,
    drawn: &mut shown::SceneEntity,
) {
    match *shape {
        ObstacleShape::Box(size) => drawn.cubes.push(cube(frame_from_shape, size, color)),
        ObstacleShape::Cylinder { radius, length } => {
            drawn.cylinders.push(shown::CylinderPrimitive {
                pose: Some(pose(frame_from_shape)),
                size: Some(vector(Vector3::new(2.0 * radius, 2.0 * radius, length))),
                bottom_scale: 1.0,
                top_scale: 1.0,
                color: Some(color),
            });
        }
        ObstacleShape::Sphere { radius } => {
            drawn
                .spheres
                .push(ball(frame_from_shape.translation, 2.0 * radius, color));
        }
        ObstacleShape::Plane => {
            let (side, thickness) = PLATE;
            // The upper face of the plate is the plane.
            let middle = *frame_from_shape * Pose::from_translation(0.0, 0.0, -thickness / 2.0);
            drawn
                .cubes
                .push(cube(&middle, [side, side, thickness], color));
        }
        ObstacleShape::Arrow { length } => {
            // An arrow of the viewers points along x.
            let along = turn_to(&Vector3::x_axis(), &Vector3::z_axis(), &Vector3::y_axis());
            let turned =
                *frame_from_shape * Pose::new(along.to_rotation_matrix(), Vector3::zeros());
            let head = (0.3 * length).min(0.04);
            drawn.arrows.push(shown::ArrowPrimitive {
                pose: Some(pose(&turned)),
                shaft_length: length - head,
                shaft_diameter: 0.012,
                head_length: head,
                head_diameter: 0.028,
                color: Some(color),
            });
        }
        // Triangles have entities of their own, see `meshes`.
        ObstacleShape::Mesh(_) => {}
    }
}

/// The way of the TCP as a line in the base frame.
pub(super) fn trace(
    points: impl Iterator<Item = Vector3<f64>>,
    at: Timestamp,
) -> shown::SceneEntity {
    let mut drawn = entity(BASE_FRAME, "tcp_trace", at);
    let points: Vec<_> = points
        .map(|p| shown::Point3 {
            x: p.x,
            y: p.y,
            z: p.z,
        })
        .collect();
    if points.len() > 1 {
        drawn.lines.push(shown::LinePrimitive {
            r#type: LineType::LineStrip.into(),
            pose: Some(pose(&Pose::IDENTITY)),
            // Pixels, so that it is seen from far away.
            thickness: 2.5,
            scale_invariant: true,
            points,
            color: Some(TRACE),
            colors: Vec::new(),
            indices: Vec::new(),
        });
    }
    drawn
}

/// The force of the environment on the tool as an arrow from the TCP; without one when it is small.
pub(super) fn force(force_in_tcp: Vector3<f64>, at: Timestamp) -> shown::SceneEntity {
    let mut drawn = entity(TCP_FRAME, "tcp_force", at);
    let newtons = force_in_tcp.norm();
    // False for NaN too.
    if newtons >= FORCE_MIN {
        let length = (newtons * METERS_PER_NEWTON).min(ARROW_MAX);
        let head = (0.3 * length).min(0.04);
        drawn.arrows.push(shown::ArrowPrimitive {
            pose: Some(shown::Pose {
                position: Some(vector(Vector3::zeros())),
                orientation: Some(quaternion(&turn_to(
                    &Vector3::x_axis(),
                    &Unit::new_normalize(force_in_tcp),
                    &Vector3::z_axis(),
                ))),
            }),
            shaft_length: length - head,
            shaft_diameter: 0.012,
            head_length: head,
            head_diameter: 0.028,
            color: Some(FORCE),
        });
    }
    drawn
}

/// An empty entity that moves with a frame and stays until it is replaced (no lifetime).
pub(super) fn entity(frame: &str, id: &str, at: Timestamp) -> shown::SceneEntity {
    shown::SceneEntity {
        timestamp: Some(at),
        frame_id: frame.to_owned(),
        id: id.to_owned(),
        frame_locked: true,
        ..shown::SceneEntity::default()
    }
}

/// A capsule is a cylinder with a ball at each end.
fn draw_capsule(capsule: &Capsule, color: shown::Color, entity: &mut shown::SceneEntity) {
    let diameter = 2.0 * capsule.radius;
    let axis = capsule.p1 - capsule.p0;
    entity.spheres.push(ball(capsule.p0, diameter, color));
    let Some(direction) = Unit::try_new(axis, 1e-9) else {
        return;
    };
    entity.spheres.push(ball(capsule.p1, diameter, color));
    let turn = turn_to(&Vector3::z_axis(), &direction, &Vector3::x_axis());
    entity.cylinders.push(shown::CylinderPrimitive {
        pose: Some(shown::Pose {
            position: Some(vector((capsule.p0 + capsule.p1) / 2.0)),
            orientation: Some(quaternion(&turn)),
        }),
        size: Some(vector(Vector3::new(diameter, diameter, axis.norm()))),
        bottom_scale: 1.0,
        top_scale: 1.0,
        color: Some(color),
    });
}

/// The shortest turn from one direction to another; half a turn about `across` where they are opposite and the shortest
/// one is not unique.
fn turn_to(
    from: &Unit<Vector3<f64>>,
    to: &Unit<Vector3<f64>>,
    across: &Unit<Vector3<f64>>,
) -> UnitQuaternion<f64> {
    UnitQuaternion::rotation_between_axis(from, to)
        .unwrap_or_else(|| UnitQuaternion::from_axis_angle(across, std::f64::consts::PI))
}

fn ball(center: Vector3<f64>, diameter: f64, color: shown::Color) -> shown::SpherePrimitive {
    shown::SpherePrimitive {
        pose: Some(pose(&Pose::from_translation(center.x, center.y, center.z))),
        size: Some(vector(Vector3::repeat(diameter))),
        color: Some(color),
    }
}

fn cube(middle: &Pose, size: [f64; 3], color: shown::Color) -> shown::CubePrimitive {
    shown::CubePrimitive {
        pose: Some(pose(middle)),
        size: Some(vector(size.into())),
        color: Some(color),
    }
}

pub(super) fn rotation(pose: &Pose) -> UnitQuaternion<f64> {
    UnitQuaternion::from_rotation_matrix(&pose.rotation)
}

pub(super) fn pose(pose: &Pose) -> shown::Pose {
    shown::Pose {
        position: Some(vector(pose.translation)),
        orientation: Some(quaternion(&rotation(pose))),
    }
}

pub(super) fn vector(v: Vector3<f64>) -> shown::Vector3 {
    shown::Vector3 {
        x: v.x,
        y: v.y,
        z: v.z,
    }
}

pub(super) fn quaternion(q: &UnitQuaternion<f64>) -> shown::Quaternion {
    shown::Quaternion {
        x: q.i,
        y: q.j,
        z: q.k,
        w: q.w,
    }
}
