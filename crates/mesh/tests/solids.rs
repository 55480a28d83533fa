//! What is a solid, and its volume, centre and inertia beside closed forms.

use std::sync::Arc;

use mesh::{MeshError, Solid};
use nalgebra::{Matrix3, Rotation3, Vector3};
use proptest::prelude::*;

use crate::shapes::{ball, block, both, mesh, solid, turned};

/// The inertia of a box of density 1 about its centre.
fn box_inertia(size: Vector3<f64>) -> Matrix3<f64> {
    let squares = size.component_mul(&size);
    let about = Vector3::new(
        squares.y + squares.z,
        squares.x + squares.z,
        squares.x + squares.y,
    );
    Matrix3::from_diagonal(&(about * (size.x * size.y * size.z / 12.0)))
}

proptest! {
    #[test]
    fn boxes_anywhere_have_the_numbers_of_the_book(
        size in proptest::array::uniform3(0.01_f64..2.0),
        place in proptest::array::uniform3(-50.0_f64..50.0),
        angles in proptest::array::uniform3(-3.0_f64..3.0),
        inside_out: bool,
    ) {
        let turn = Rotation3::from_euler_angles(angles[0], angles[1], angles[2]);
        let size = Vector3::from(size);
        let place = Vector3::from(place);
        let flat = block((-size / 2.0).into(), (size / 2.0).into());
        let points = flat.points().iter().map(|point| (turn * point + place).into()).collect();
        let moved = mesh(points, flat.triangles().to_vec());
        let solid = solid(if inside_out { turned(&moved) } else { moved });
        let volume = size.x * size.y * size.z;
        prop_assert!((solid.volume() / volume - 1.0).abs() < 1e-9);
        prop_assert!((solid.centre() - place).norm() < 1e-9);
        let expected = turn * box_inertia(size) * turn.inverse();
        prop_assert!((solid.inertia() - expected).norm() < 1e-8 * expected.norm());
    }
}

#[test]
fn a_ball_has_the_numbers_of_the_book() {
    let solid = solid(ball(0.5, 100));
    let volume = 4.0 / 3.0 * std::f64::consts::PI * 0.125;
    assert!((solid.volume() / volume - 1.0).abs() < 1e-3);
    assert!(solid.centre().norm() < 1e-12);
    let expected = Matrix3::identity() * (0.4 * volume * 0.25);
    assert!((solid.inertia() - expected).norm() < 2e-3 * expected.norm());
    // The points on the edges of the six grids became one each.
    assert_eq!(solid.mesh().points().len(), 6 * 100 * 100 + 2);
}

#[test]
fn a_tetrahedron_has_the_numbers_of_the_book() {
    let corners = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let solid = solid(mesh(
        corners,
        vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]],
    ));
    assert!((solid.volume() - 1.0 / 6.0).abs() < 1e-15);
    assert!((solid.centre() - Vector3::repeat(0.25)).norm() < 1e-15);
    // About the centre: 3/80 V and 1/80 V times a² of the three squares and products.
    let second =
        Matrix3::from_fn(|row, column| if row == column { 3.0 } else { -1.0 } / 80.0 / 6.0);
    let expected = Matrix3::identity() * second.trace() - second;
    assert!((solid.inertia() - expected).norm() < 1e-15);
}

/// The sentence about a mesh that is no solid.
fn trouble(mesh: mesh::Mesh) -> String {
    Solid::new(Arc::new(mesh)).unwrap_err().to_string()
}

#[test]
fn what_is_no_solid_is_refused_with_the_place() {
    let cube = block([0.0; 3], [1.0; 3]);
    let points: Vec<[f64; 3]> = cube.points().iter().map(|&point| point.into()).collect();
    let with = |triangles: &[[u32; 3]]| mesh(points.clone(), triangles.to_vec());
    let open = with(&cube.triangles()[..11]);
    assert_eq!(
        trouble(open),
        "shape, triangle 0: the surface is open: the edge from (0, 0, 1) to (0, 1, 1) m belongs to one triangle only; \
         in a solid every edge belongs to two"
    );
    let mut one_turned = cube.triangles().to_vec();
    one_turned[5].swap(1, 2);
    assert!(
        trouble(with(&one_turned)).contains("and 5 is inside out: both run along the edge"),
        "{}",
        trouble(with(&one_turned))
    );
    let fin = [cube.triangles(), &[[0, 1, 7], [7, 1, 0]]].concat();
    assert!(
        trouble(with(&fin)).contains("belongs to 4 triangles"),
        "{}",
        trouble(with(&fin))
    );
    let sheet = mesh(points[..3].to_vec(), vec![[0, 1, 2], [0, 2, 1]]);
    assert_eq!(
        trouble(sheet),
        "shape: the extent along z is 0e0 m; allowed is 0.0001 m and more"
    );
    let pair = both(&cube, &turned(&block([0.0, 0.0, 1.5], [1.0, 1.0, 2.5])));
    assert!(trouble(pair).contains("encloses no volume"));
    let line = mesh(points[..2].to_vec(), vec![[0, 1, 1]]);
    assert_eq!(
        trouble(line),
        "shape: the file has no triangle with an area"
    );
    let far = block([0.0; 3], [50.0, 50.0, 100.1]);
    assert!(trouble(far).ends_with(
        "allowed are coordinates within 100 m (a file in millimetres needs a scale of 0.001)"
    ));
    let small = block([0.0; 3], [1.0, 1.0, 9e-5]);
    assert!(trouble(small).contains("the extent along z is 9e-5 m"));
}

#[test]
fn doubled_points_and_empty_triangles_do_no_harm() {
    let cube = block([0.0; 3], [1.0; 3]);
    let loose = cube
        .triangles()
        .iter()
        .flatten()
        .map(|&corner| cube.points()[corner as usize].into());
    let mut points: Vec<[f64; 3]> = loose.collect();
    let mut triangles: Vec<[u32; 3]> = (0..12)
        .map(|number| [3 * number, 3 * number + 1, 3 * number + 2])
        .collect();
    points.push([-0.0, 0.0, -0.0]);
    triangles.push([0, 36, 1]);
    let solid = solid(mesh(points, triangles));
    assert_eq!(solid.mesh().points().len(), 8);
    assert_eq!(solid.mesh().triangles().len(), 12);
    assert!((solid.volume() - 1.0).abs() < 1e-15);
}

#[test]
fn points_of_no_triangle_are_no_part_of_a_solid() {
    let cube = block([0.0; 3], [1.0; 3]);
    let own = cube.points().iter().map(|&point| point.into());
    // More of them than parts that are told apart, and than pieces that are allowed.
    let loose = (0..1500).map(|number| [5.0 + f64::from(number) * 1e-3, 7.0, 9.0]);
    let points: Vec<[f64; 3]> = loose.chain(own).collect();
    let moved = |corners: &[u32; 3]| corners.map(|corner| corner + 1500);
    let triangles = cube.triangles().iter().map(moved).collect();
    let solid = solid(mesh(points, triangles));
    assert_eq!(solid.mesh().points(), cube.points());
    assert_eq!(solid.mesh().triangles(), cube.triangles());
    let pieces = mesh::convex_pieces(&solid, 16);
    assert_eq!(pieces.pieces().len(), 1);
    assert!(pieces.deviation() < 1e-8, "{}", pieces.deviation());
}

#[test]
fn a_mesh_checks_its_indices_and_numbers() {
    let error = mesh::Mesh::new("a", vec![Vector3::zeros()], vec![[0, 0, 1]]).unwrap_err();
    assert_eq!(
        error.to_string(),
        "a, triangle 0: it names point 1; there are 1 points"
    );
    let error = mesh::Mesh::new("a", vec![Vector3::repeat(f64::NAN)], vec![[0, 0, 0]]).unwrap_err();
    assert!(matches!(error, MeshError::Damaged { .. }));
}
