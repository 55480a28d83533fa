//! Collision shapes of a URDF link as capsules.
//!
//! Owns the reading: a cylinder stands for the capsule around its axis, a ball that lies inside a capsule of the same
//! link adds nothing. So the portable form of a capsule, a cylinder with a ball at either end, comes back as one.

use super::ModelError;
use super::tree::pose_of;
use crate::collision::Capsule;
use messages::{Text, text};
use nalgebra::Vector3;
use urdf_rs::{Geometry, Link};

/// A ball this little (m) outside a capsule is an end of that capsule, written in rounded numbers.
const SLACK: f64 = 1e-6;

/// The capsules around a link, in its frame. Boxes get the capsule around them; meshes are left out, with a warning.
pub(super) fn capsules(link: &Link, warnings: &mut Vec<Text>) -> Result<Vec<Capsule>, ModelError> {
    let mut found = Vec::new();
    let mut balls = Vec::new();
    for collision in &link.collision {
        let wrong = |reason: Text| ModelError::Collision {
            link: link.name.clone(),
            reason,
        };
        let link_from_shape = pose_of(&collision.origin).ok_or_else(|| {
            wrong(text!(
                "has an origin with a number that is not finite",
                "的原点有不是有限的数"
            ))
        })?;
        let size = |what: &str, value: f64| {
            if value.is_finite() && value > 0.0 {
                Ok(value)
            } else {
                Err(wrong(text!(
                    "has a {what} of {value} m, it must be positive",
                    "的 {what} 为 {value} m，必须为正"
                )))
            }
        };
        let along = |axis: Vector3<f64>, half: f64, radius: f64| {
            Capsule {
                p0: axis * -half,
                p1: axis * half,
                radius,
            }
            .expressed_in(&link_from_shape)
        };
        match &collision.geometry {
            Geometry::Cylinder { radius, length } | Geometry::Capsule { radius, length } => {
                let (radius, length) = (size("radius", *radius)?, size("length", *length)?);
                found.push(along(Vector3::z(), length / 2.0, radius));
            }
            Geometry::Sphere { radius } => {
                balls.push(along(Vector3::z(), 0.0, size("radius", *radius)?));
            }
            Geometry::Box { size: edges } => {
                for edge in edges.0 {
                    size("edge", edge)?;
                }
                // Around the longest edge; the radius reaches the corners of the face across it.
                let longest = Vector3::from(edges.0).imax();
                let mut across = Vector3::from(edges.0);
                across[longest] = 0.0;
                let mut axis = Vector3::zeros();
                axis[longest] = 1.0;
                found.push(along(axis, edges.0[longest] / 2.0, across.norm() / 2.0));
            }
            Geometry::Mesh { filename, .. } => warnings.push(text!(
"link `{}`: the collision mesh {filename} is not used, only cylinders, spheres, capsules and boxes are",
"连杆 `{}`：不使用碰撞网格 {filename}，只使用圆柱、球、胶囊和长方体",
                link.name
            )),
        }
    }
    for ball in balls {
        if !found
            .iter()
            .any(|capsule: &Capsule| capsule.covers(&ball, SLACK))
        {
            found.push(ball);
        }
    }
    Ok(found)
}
