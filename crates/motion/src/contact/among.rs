//! A ball among obstacles that stand side by side: a surface made of several boxes carries it across their joints.
//!
//! Taken one by one, a box would push a ball that is deep in it out through the nearest face, also where the next box
//! begins; the next box would stop it at its side; and above a joint both would push. So a way out that ends deeper in
//! another obstacle gives way to the next best one, edges and sides count only for what is left when the ball has left
//! the neighbour, and where the sides of two obstacles have given way, their faces push once.

use nalgebra::Vector3;

use super::entry::{
    DEPTH_TOLERANCE, EntryFaces, ExitDirection, Probe, SAME_SURFACE_COSINE, leads_into_another,
};
use super::nearest::ContactPoint;
use super::{ArmPart, Obstacle};

/// Where the ball of the tool, its center and radius given, touches the obstacle `number` of `obstacles`, or nearly.
pub(super) fn ball(
    (center, radius): (Vector3<f64>, f64),
    number: usize,
    obstacles: &[Obstacle],
    margin: f64,
    entries: &mut EntryFaces,
) -> Option<ContactPoint> {
    let ball = ToolBall {
        probe: Probe {
            part: ArmPart::Tool,
            center,
            radius,
        },
        obstacles,
        entries,
    };
    let solid = &obstacles[number].solid;
    let way = ball.exit_direction(number);
    if radius - way.distance <= -margin {
        return None;
    }
    let depth = ball.depth_beside_neighbors(number, &way);
    let probe = ball.probe;
    if way.distance < 0.0 {
        entries.remember(&probe, number, solid, &way);
    }
    depth.map(|depth| ContactPoint {
        point: center - way.normal * radius,
        normal: way.normal,
        depth,
    })
}

struct ToolBall<'a> {
    probe: Probe,
    obstacles: &'a [Obstacle],
    entries: &'a EntryFaces,
}

impl ToolBall<'_> {
    /// The way out of an obstacle that the ball came into, or the nearest one, if it leads into no other obstacle; the
    /// nearest if all do.
    fn exit_direction(&self, number: usize) -> ExitDirection {
        let (probe, obstacles) = (&self.probe, self.obstacles);
        if let Some(way) = self.entries.way_out(probe, number, obstacles) {
            return way;
        }
        let solid = &obstacles[number].solid;
        let nearest = solid.distance(probe.center);
        let way = |(distance, normal): (f64, Vector3<f64>)| ExitDirection {
            distance,
            normal,
            is_detour: distance < nearest.0 - DEPTH_TOLERANCE,
        };
        if nearest.0 >= 0.0 {
            return way(nearest);
        }
        let exits = solid.exits(probe.center);
        let free = exits.into_iter().flatten().map(way);
        free.filter(|way| !leads_into_another(probe, number, obstacles, way))
            .max_by(|a, b| a.distance.total_cmp(&b.distance))
            .unwrap_or_else(|| way(nearest))
    }

    /// How deep the ball is in an obstacle whose way out is given, for what its neighbours leave of it; `None` when
    /// they leave nothing.
    fn depth_beside_neighbors(&self, number: usize, way: &ExitDirection) -> Option<f64> {
        let solid = &self.obstacles[number].solid;
        let Probe { center, radius, .. } = self.probe;
        let mut depth = radius - way.distance;
        let is_inside = way.distance < 0.0;
        let is_at_an_edge = !is_inside && solid.is_nearest_at_an_edge(center);
        for (other, neighbour) in self.obstacles.iter().enumerate() {
            if other == number
                || !neighbour.solid.may_be_near(center, radius)
                || neighbour.solid.distance(center).0 >= radius
            {
                continue;
            }
            let its = self.exit_direction(other);
            // Of two that are alike the deeper counts, then the earlier.
            let comes_first = (its.distance, other) < (way.distance, number);
            let is_alike = its.normal.dot(&way.normal) > SAME_SURFACE_COSINE;
            if is_inside {
                if way.is_detour && its.is_detour && is_alike && comes_first {
                    return None;
                }
            } else if comes_first && (is_at_an_edge || !is_alike) {
                let left = center + its.normal * (radius - its.distance);
                let remaining = radius - solid.distance(left).0;
                if remaining <= 0.0 && depth > remaining {
                    return None;
                }
                depth = depth.min(remaining);
            }
        }
        Some(depth)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{PlacedShape, Shape};
    use super::*;
    use kinematics::{Pose, RpyPose};

    const RADIUS: f64 = 0.001;

    fn block(x: f64, z: f64, tilt: f64) -> Obstacle {
        Obstacle {
            name: String::new(),
            solid: PlacedShape {
                pose: Pose::from_rpy(&RpyPose::from_array([x, 0.0, z, 0.0, tilt, 0.0])),
                shape: Shape::Box {
                    half: [0.015, 0.1, 0.02],
                },
            },
            body: None,
            stiffness: Some(10_000.0),
            damping: 0.0,
            friction: 0.0,
        }
    }

    /// The sum of depth times normal: the force for a stiffness of 1.
    fn push(obstacles: &[Obstacle], x: f64, z: f64) -> Vector3<f64> {
        let mut sum = Vector3::zeros();
        let center = Vector3::new(x, 0.0, z);
        let mut entries = EntryFaces::new();
        for number in 0..obstacles.len() {
            let place = ball((center, RADIUS), number, obstacles, 0.006, &mut entries);
            sum += place.map_or(Vector3::zeros(), |p| p.normal * p.depth.max(0.0));
        }
        sum
    }

    #[test]
    fn joints_of_a_floor_are_not_felt() {
        // Tops at z = 0, the joint at x = 0.
        let floor = [block(-0.015, -0.02, 0.0), block(0.015, -0.02, 0.0)];
        for depth in [0.0005, 0.0015, 0.003, 0.008] {
            for step in -50..=50_i32 {
                let x = f64::from(step) * 1e-4 + 1e-7;
                let push = push(&floor, x, RADIUS - depth);
                assert!(
                    (push - Vector3::z() * depth).norm() < 0.02 * depth + 1e-9,
                    "{depth} {x} {push}"
                );
            }
        }
    }

    #[test]
    fn facets_of_an_arch_push_along_their_normals() {
        let tilt = 0.06_f64;
        // Two facets that meet in an edge at the origin, the bodies below overlapping.
        let facet = |side: f64| {
            let (sin, cos) = (side * tilt).sin_cos();
            let (along, below) = (side * 0.015, -0.02);
            block(
                along * cos + below * sin,
                below * cos - along * sin,
                side * tilt,
            )
        };
        let arch = [facet(-1.0), facet(1.0)];
        for depth in [0.0015, 0.003] {
            for step in -80..=80_i32 {
                let x = f64::from(step) * 1e-4 + 1e-7;
                let top = -x.abs() * tilt.tan();
                let push = push(&arch, x, top + RADIUS - depth);
                let slope = (push.x / push.z).abs();
                assert!(slope < tilt.tan() + 0.01, "{depth} {x} {push}");
                assert!((push.z - depth).abs() < 0.05 * depth, "{depth} {x} {push}");
            }
        }
    }

    #[test]
    fn a_wall_on_a_floor_still_stops() {
        let floor = block(0.0, -0.02, 0.0);
        let mut wall = block(0.02, 0.0, 0.0);
        // It reaches from below the floor's top to above it.
        wall.solid.shape = Shape::Box {
            half: [0.01, 0.1, 0.05],
        };
        // The ball has sunk 2 mm into the floor and 0.5 mm into the wall at x = 0.01.
        let push = push(&[floor, wall], 0.01 - RADIUS + 0.0005, RADIUS - 0.002);
        assert!(
            (push - Vector3::new(-0.0005, 0.0, 0.002)).norm() < 1e-9,
            "{push}"
        );
    }

    #[test]
    fn a_free_edge_pushes_sideways() {
        let push = push(&[block(0.0, -0.02, 0.0)], 0.0149, -0.005);
        assert!(push.x > 0.0 && push.z.abs() < 1e-12, "{push}");
    }
}
