//! Convex pieces: how many, how near, and that nothing is lost.

use mesh::{ConvexPieces, Solid, convex_pieces};
use nalgebra::Vector3;
use proptest::prelude::*;

use crate::shapes::{Shelf, bin, block, both, bracket, extruded, fork, mesh, solid, torus, turned};

/// How far a point is from the nearest piece.
fn beside(pieces: &ConvexPieces, point: &Vector3<f64>) -> f64 {
    let distances = pieces
        .pieces()
        .iter()
        .map(|piece| piece.body.distance(&(point - piece.middle)).0);
    distances.fold(f64::INFINITY, f64::min)
}

/// Whether a point is in a solid: the solid angle of its surface seen from the point, by Van Oosterom and Strackee.
fn encloses(solid: &Solid, point: &Vector3<f64>) -> bool {
    let mut angle = 0.0;
    for corners in solid.mesh().triangles() {
        let [a, b, c] = corners.map(|corner| solid.mesh().points()[corner as usize] - point);
        let (la, lb, lc) = (a.norm(), b.norm(), c.norm());
        let upper = a.dot(&b.cross(&c));
        let lower = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
        angle += 2.0 * kinematics::elementary::atan2(upper, lower);
    }
    angle > std::f64::consts::TAU
}

/// Points of the box around the mesh, spread evenly.
fn spread(solid: &Solid, count: u32) -> impl Iterator<Item = Vector3<f64>> {
    let points = solid.mesh().points();
    let low = points.iter().fold(points[0], |low, point| low.inf(point));
    let high = points.iter().fold(points[0], |high, point| high.sup(point));
    (1..=count).map(move |number| {
        // A lattice of three irrational steps.
        let steps = Vector3::new(
            0.819_172_513_396_164,
            0.671_043_606_703_789,
            0.549_700_477_901_97,
        );
        let share = steps.map(|step| (step * f64::from(number)).fract());
        low + (high - low).component_mul(&share)
    })
}

/// Pieces, after it is certain that they are where the solid is, both ways.
fn checked(solid: &Solid, most: usize) -> ConvexPieces {
    let pieces = convex_pieces(solid, most);
    let allowed = pieces.deviation() + 1e-9;
    assert!(
        (1..=most).contains(&pieces.pieces().len()),
        "{}",
        pieces.pieces().len()
    );
    for point in solid.mesh().points() {
        assert!(beside(&pieces, point) <= allowed, "a corner at {point:?}");
    }
    for point in spread(solid, 2000) {
        let distance = beside(&pieces, &point);
        if encloses(solid, &point) {
            assert!(
                distance <= allowed,
                "{distance} m beside the pieces at {point:?}"
            );
        } else if distance <= 0.0 {
            let away = nearest(solid, &point);
            assert!(
                away <= allowed,
                "{away} m beside the solid at {point:?}, {}",
                pieces.deviation()
            );
        }
    }
    pieces
}

/// How far a point is from the surface, slowly and in another way than the crate does it.
fn nearest(solid: &Solid, point: &Vector3<f64>) -> f64 {
    let distance = |corners: &[u32; 3]| {
        let [a, b, c] = corners.map(|corner| solid.mesh().points()[corner as usize]);
        // Ericson, Real-Time Collision Detection, 5.1.5.
        let (ab, ac, ap) = (b - a, c - a, point - a);
        let (d1, d2) = (ab.dot(&ap), ac.dot(&ap));
        let (bp, cp) = (point - b, point - c);
        let (d3, d4) = (ab.dot(&bp), ac.dot(&bp));
        let (d5, d6) = (ab.dot(&cp), ac.dot(&cp));
        let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
        let closest = if d1 <= 0.0 && d2 <= 0.0 {
            a
        } else if d3 >= 0.0 && d4 <= d3 {
            b
        } else if d6 >= 0.0 && d5 <= d6 {
            c
        } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
            a + ab * (d1 / (d1 - d3))
        } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
            a + ac * (d2 / (d2 - d6))
        } else if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
            b + (c - b) * ((d4 - d3) / (d4 - d3 + d5 - d6))
        } else {
            a + ab * (vb / (va + vb + vc)) + ac * (vc / (va + vb + vc))
        };
        (point - closest).norm()
    };
    solid
        .mesh()
        .triangles()
        .iter()
        .map(distance)
        .fold(f64::INFINITY, f64::min)
}

fn volume_of(pieces: &ConvexPieces) -> f64 {
    let of_piece = |piece: &mesh::ConvexPiece| {
        let mut sum = 0.0;
        for face in piece.body.faces() {
            let corners: Vec<_> = piece.body.corners(face).collect();
            for pair in corners[1..].windows(2) {
                sum += corners[0].dot(&pair[0].cross(&pair[1])) / 6.0;
            }
        }
        sum
    };
    pieces.pieces().iter().map(of_piece).sum()
}

#[test]
fn a_convex_mesh_is_one_piece() {
    let pieces = checked(&solid(block([0.1, -0.2, 0.3], [0.4, 0.5, 0.7])), 16);
    assert_eq!(pieces.pieces().len(), 1);
    assert!(pieces.deviation() < 1e-7, "{}", pieces.deviation());
    assert_eq!(pieces.pieces()[0].body.faces().len(), 6);
    assert_eq!(pieces.pieces()[0].body.points().len(), 8);
}

#[test]
fn a_bin_is_five_pieces_a_bracket_two_and_a_fork_three() {
    for (shape, count) in [(bin([0.4, 0.3, 0.2], 0.01), 5), (bracket(), 2), (fork(), 3)] {
        let solid = solid(shape);
        let pieces = checked(&solid, 16);
        assert_eq!(pieces.pieces().len(), count);
        assert!(pieces.deviation() < 1e-6, "{}", pieces.deviation());
        // No piece is in another one, so the volumes add up.
        assert!((volume_of(&pieces) / solid.volume() - 1.0).abs() < 1e-6);
        assert!(
            pieces
                .pieces()
                .iter()
                .all(|piece| piece.body.faces().len() == 6)
        );
    }
}

#[test]
fn turned_shapes_of_single_precision_are_cut_as_well() {
    let turn = nalgebra::Rotation3::from_euler_angles(0.3, -0.7, 1.1);
    for (shape, count) in [(bin([0.4, 0.3, 0.2], 0.01), 5), (bracket(), 2), (fork(), 3)] {
        #[expect(clippy::cast_possible_truncation, reason = "files have these numbers")]
        let rounded = |point: &Vector3<f64>| (turn * point).map(|x| f64::from(x as f32)).into();
        let points = shape.points().iter().map(rounded).collect();
        let pieces = checked(&solid(mesh(points, shape.triangles().to_vec())), 16);
        assert_eq!(pieces.pieces().len(), count);
        assert!(pieces.deviation() < 5e-5, "{}", pieces.deviation());
    }
}

#[test]
fn one_piece_of_a_bin_reaches_as_far_as_its_middle_is_from_the_walls() {
    let pieces = checked(&solid(bin([0.4, 0.3, 0.2], 0.01)), 1);
    // In the opening, 0.14 m from two walls.
    assert!(
        (0.14..0.143).contains(&pieces.deviation()),
        "{}",
        pieces.deviation()
    );
}

#[test]
fn a_round_column_is_one_piece_of_as_many_corners_as_a_body_may_have() {
    let outline: Vec<[f64; 2]> = (0..200)
        .map(|step| {
            let (sin, cos) =
                kinematics::elementary::sin_cos(f64::from(step) / 200.0 * std::f64::consts::TAU);
            [0.1 * cos, 0.1 * sin]
        })
        .collect();
    let front: Vec<[u32; 3]> = (1..199).map(|corner| [0, corner, corner + 1]).collect();
    let pieces = checked(&solid(extruded(&outline, &front, 0.3)), 16);
    assert_eq!(pieces.pieces().len(), 1);
    assert!(pieces.pieces()[0].body.points().len() <= 128);
    assert!(pieces.deviation() < 1e-3, "{}", pieces.deviation());
}

#[test]
fn a_ring_of_sixteen_pieces_is_near() {
    let solid = solid(torus(0.1, 0.03, 64, 32));
    let pieces = checked(&solid, 16);
    assert_eq!(pieces.pieces().len(), 16);
    assert!(pieces.deviation() < 0.006, "{}", pieces.deviation());
    let again = convex_pieces(&solid, 16);
    assert_eq!(again, pieces);
}

#[test]
fn a_hollow_is_seen_from_within() {
    // A box with a closed room in it: the middle of the room is 0.1 m from its walls.
    let room = both(
        &block([0.0; 3], [0.4; 3]),
        &turned(&block([0.1; 3], [0.3; 3])),
    );
    let solid = solid(room);
    let one = checked(&solid, 1);
    assert!(
        (0.1..0.102).contains(&one.deviation()),
        "{}",
        one.deviation()
    );
    let many = checked(&solid, 16);
    assert_eq!(many.pieces().len(), 6);
    assert!(many.deviation() < 1e-6, "{}", many.deviation());
}

#[test]
fn a_cross_keeps_the_corners_where_three_cuts_meet() {
    // Eight arms would not show it: the corner of three cuts is within the solid, on no edge of the surface.
    let table = both(
        &both(
            &block([0.0; 3], [0.1, 0.1, 0.1]),
            &block([0.2, 0.0, 0.0], [0.3, 0.1, 0.1]),
        ),
        &block([0.0, 0.2, 0.0], [0.1, 0.3, 0.1]),
    );
    let solid = solid(table);
    assert_eq!(checked(&solid, 16).pieces().len(), 3);
    assert_eq!(checked(&solid, 2).pieces().len(), 2);
    assert_eq!(checked(&solid, 1).pieces().len(), 1);
}

#[test]
fn pieces_beyond_the_bounds_are_the_nearest_allowed() {
    let solid = solid(fork());
    assert_eq!(convex_pieces(&solid, 0), convex_pieces(&solid, 1));
    assert_eq!(
        convex_pieces(&solid, usize::MAX),
        convex_pieces(&solid, 256)
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Columns of random heights on a plate, as one closed surface: hollows on all sides.
    #[test]
    fn nothing_of_random_terrain_is_lost(heights in proptest::collection::vec(1_u8..5, 9), most in 1_usize..20) {
        let terrain = terrain(&heights, 3);
        // Columns that touch along one edge alone have an edge of four triangles there, which is no solid.
        let Ok(solid) = Solid::new(std::sync::Arc::new(terrain)) else {
            return Err(TestCaseError::reject("columns touch at an edge"));
        };
        checked(&solid, most);
    }
}

/// Columns on a square grid. Neighbours share their walls, so the surface is closed.
fn terrain(heights: &[u8], side: usize) -> mesh::Mesh {
    let filled = |x: i32, y: i32, z: i32| {
        let (Ok(column), Ok(row)) = (usize::try_from(x), usize::try_from(y)) else {
            return false;
        };
        column < side && row < side && z >= 0 && z < i32::from(heights[row * side + column])
    };
    let mut points = Vec::new();
    let mut triangles = Vec::new();
    let last = i32::try_from(side).unwrap();
    for (x, y, z) in
        (0..last).flat_map(|x| (0..last).flat_map(move |y| (0..5).map(move |z| (x, y, z))))
    {
        if !filled(x, y, z) {
            continue;
        }
        let cube = block([0.0; 3], [1.0; 3]);
        for pair in cube.triangles().chunks(2) {
            let corners: Vec<Vector3<f64>> = pair
                .iter()
                .flatten()
                .map(|&corner| cube.points()[corner as usize])
                .collect();
            let normal = (corners[1] - corners[0]).cross(&(corners[2] - corners[0]));
            let step = |axis: usize| i32::from(normal[axis] > 0.5) - i32::from(normal[axis] < -0.5);
            if filled(x + step(0), y + step(1), z + step(2)) {
                continue;
            }
            for triangle in corners.chunks(3) {
                let first = u32::try_from(points.len()).unwrap();
                for corner in triangle {
                    let at = corner + Vector3::new(f64::from(x), f64::from(y), f64::from(z));
                    points.push([at.x * 0.1, at.y * 0.1, at.z * 0.05]);
                }
                triangles.push([first, first + 1, first + 2]);
            }
        }
    }
    mesh(points, triangles)
}

/// Cut often, its parts have points nearly in a line, whose triangles have no direction but for rounding: a corner that
/// is exactly inside seemed to be above one of them for ever.
#[test]
fn narrow_triangles_of_a_hull_end() {
    let text = include_bytes!("turned_tube.obj").to_vec();
    let mesh = ::mesh::read("tube.obj", 1.0, &mut Shelf::of("tube.obj", text)).unwrap();
    let solid = Solid::new(std::sync::Arc::new(mesh)).unwrap();
    let pieces = convex_pieces(&solid, 8);
    assert_eq!(pieces.pieces().len(), 8);
    assert!(pieces.deviation() < 0.026, "{}", pieces.deviation());
}
