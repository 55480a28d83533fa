//! Polytopes for tests of contact: what a mesh gives, in the size of the simple shapes.

use std::sync::Arc;

use core::f64::consts::TAU;

use kinematics::polytope::Polytope;
use nalgebra::Vector3;

use super::Shape;

/// A box as a polytope.
pub(super) fn block(half: [f64; 3]) -> Shape {
    Shape::Polytope(Arc::new(Polytope::cuboid(half).unwrap()))
}

/// A cylinder of 16 facets as a polytope.
pub(super) fn faceted_cylinder(radius: f64, half_length: f64) -> Shape {
    const FACETS: u32 = 16;
    let corner = |k: u32, z: f64| {
        let (sin, cos) = (TAU * f64::from(k) / f64::from(FACETS)).sin_cos();
        Vector3::new(radius * cos, radius * sin, z)
    };
    let ring = |z: f64| (0..FACETS).map(move |k| corner(k, z));
    let points = ring(-half_length).chain(ring(half_length)).collect();
    let mut loops: Vec<Vec<u32>> = (0..FACETS)
        .map(|k| {
            let next = (k + 1) % FACETS;
            vec![k, next, next + FACETS, k + FACETS]
        })
        .collect();
    loops.push((0..FACETS).rev().collect());
    loops.push((FACETS..2 * FACETS).collect());
    Shape::Polytope(Arc::new(Polytope::new(points, &loops).unwrap()))
}
