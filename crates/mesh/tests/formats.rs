//! The same meshes in all formats.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use mesh::{Mesh, Solid, read};
use nalgebra::{Rotation3, Vector3};
use proptest::prelude::*;

use crate::shapes::{Shelf, block};

pub fn stl_text(mesh: &Mesh) -> Vec<u8> {
    let mut text = String::from("solid two words\n");
    for corners in mesh.triangles() {
        text += " facet normal 0 0 NaN\n  outer loop\n";
        for corner in corners.map(|corner| mesh.points()[corner as usize]) {
            text += &format!("   vertex {:e} {} {}\n", corner.x, corner.y, corner.z);
        }
        text += "  endloop\n endfacet\n";
    }
    (text + "endsolid two words\n").into_bytes()
}

#[expect(
    clippy::cast_possible_truncation,
    reason = "the format has single precision"
)]
fn singles(point: &Vector3<f64>) -> Vec<u8> {
    point
        .iter()
        .flat_map(|&x| (x as f32).to_le_bytes())
        .collect()
}

pub fn stl_binary(mesh: &Mesh) -> Vec<u8> {
    // A header that begins like a text, as some programs write it.
    let mut bytes = b"solid but binary".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(u32::try_from(mesh.triangles().len()).unwrap().to_le_bytes());
    for corners in mesh.triangles() {
        bytes.extend([0; 12]);
        for corner in corners {
            bytes.extend(singles(&mesh.points()[*corner as usize]));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

pub fn obj(mesh: &Mesh) -> Vec<u8> {
    let mut text = String::from("# a comment\nmtllib a.mtl\no thing\n");
    for point in mesh.points() {
        text += &format!("v {} {} {}\n", point.x, point.y, point.z);
    }
    text += "vn 0 0 1\nvt 0 0\ns off\nusemtl red\n";
    let count = mesh.points().len();
    for (number, [a, b, c]) in mesh.triangles().iter().enumerate() {
        let back = |corner: u32| i64::from(corner) - i64::try_from(count).unwrap();
        text += &match number % 3 {
            0 => format!("f {} {} {}\r\n", a + 1, b + 1, c + 1),
            1 => format!("f {}/1/1 {}//1 \\\n {}/1\n", a + 1, b + 1, c + 1),
            _ => format!("f {} {} {} # last\n", back(*a), back(*b), back(*c)),
        };
    }
    text.into_bytes()
}

/// The bytes of positions and indices.
fn binary(mesh: &Mesh) -> (Vec<u8>, usize) {
    let mut bytes: Vec<u8> = mesh.points().iter().flat_map(singles).collect();
    let positions = bytes.len();
    bytes.extend(
        mesh.triangles()
            .iter()
            .flatten()
            .flat_map(|corner| corner.to_le_bytes()),
    );
    (bytes, positions)
}

pub fn gltf(mesh: &Mesh, uri: Option<&str>, node: &str) -> String {
    let (bytes, positions) = binary(mesh);
    let uri = uri.map_or_else(String::new, |uri| format!(r#""uri": "{uri}", "#));
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
"nodes": [{{"children": [1], "extras": {{"any": [1]}}}}, {node}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "NORMAL": 9}}, "indices": 1, "material": 3}}]}}],
"accessors": [{{"bufferView": 0, "componentType": 5126, "count": {}, "type": "VEC3"}},
{{"bufferView": 1, "componentType": 5125, "count": {}, "type": "SCALAR"}}],
"bufferViews": [{{"buffer": 0, "byteLength": {positions}}},
{{"buffer": 0, "byteOffset": {positions}, "byteLength": {}}}],
"buffers": [{{{uri}"byteLength": {}}}]}}"#,
        mesh.points().len(),
        3 * mesh.triangles().len(),
        bytes.len() - positions,
        bytes.len(),
    )
}

pub fn embedded(mesh: &Mesh, node: &str) -> Vec<u8> {
    let uri = format!(
        "data:application/octet-stream;base64,{}",
        STANDARD.encode(binary(mesh).0)
    );
    gltf(mesh, Some(&uri), node).into_bytes()
}

pub fn glb(mesh: &Mesh) -> Vec<u8> {
    let mut text = gltf(mesh, None, r#"{"mesh": 0}"#).into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let (data, _) = binary(mesh);
    let size = |bytes: usize| u32::try_from(bytes).unwrap().to_le_bytes();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend(size(12 + 8 + text.len() + 8 + data.len()));
    bytes.extend(size(text.len()));
    bytes.extend(b"JSON");
    bytes.extend(text);
    bytes.extend(size(data.len()));
    bytes.extend(b"BIN\0");
    bytes.extend(data);
    bytes
}

/// Boxes whose corners are exact in single precision.
fn any_block() -> impl Strategy<Value = Mesh> {
    let value = || proptest::array::uniform3(-4000_i16..4000);
    let size = proptest::array::uniform3(1_i16..4000);
    (value(), size).prop_map(|(low, size)| {
        let low = low.map(|x| f64::from(x) / 256.0);
        let high = [0, 1, 2].map(|axis| low[axis] + f64::from(size[axis]) / 256.0);
        block(low, high)
    })
}

/// The surface with common points, whose order is that of the file.
fn corners(mesh: &Mesh) -> Vec<Vector3<f64>> {
    mesh.triangles()
        .iter()
        .flatten()
        .map(|&corner| mesh.points()[corner as usize])
        .collect()
}

proptest! {
    #[test]
    fn every_format_gives_the_same_triangles(block in any_block()) {
        let files: [(&str, Vec<u8>); 5] = [
            ("a/text.STL", stl_text(&block)),
            ("binary.stl", stl_binary(&block)),
            ("a.obj", obj(&block)),
            ("embedded.gltf", embedded(&block, r#"{"mesh": 0}"#)),
            ("chunk.Glb", glb(&block)),
        ];
        for (name, bytes) in files {
            let found = read(name, 1.0, &mut Shelf::of(name, bytes)).unwrap();
            prop_assert_eq!(corners(&found), corners(&block), "{}", name);
            prop_assert!(Solid::new(std::sync::Arc::new(found)).is_ok());
        }
    }

    #[test]
    fn a_scale_is_the_length_of_a_unit(block in any_block(), scale in 1e-3_f64..10.0) {
        let found = read("a.stl", scale, &mut Shelf::of("a.stl", stl_binary(&block))).unwrap();
        for (one, other) in corners(&found).iter().zip(corners(&block)) {
            prop_assert!((one - other * scale).norm() < 1e-12);
        }
    }
}

#[test]
fn buffers_beside_the_file_are_found_in_its_folder() {
    let block = block([0.0; 3], [1.0; 3]);
    let mut shelf = Shelf::of(
        "parts/a.gltf",
        gltf(&block, Some("data%20of/a.bin"), r#"{"mesh": 0}"#),
    );
    shelf
        .0
        .insert("parts/data of/a.bin".to_owned(), binary(&block).0);
    let found = read("parts/a.gltf", 1.0, &mut shelf).unwrap();
    assert_eq!(corners(&found), corners(&block));
}

#[test]
fn nodes_move_turn_stretch_and_mirror() {
    let block = block([0.0; 3], [1.0; 3]);
    // A quarter turn about z, then a shift; first a mirror and a stretch.
    let node = r#"{"mesh": 0, "translation": [1, 2, 3], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476],
        "scale": [-2, 1, 1]}"#;
    let found = read(
        "a.gltf",
        1.0,
        &mut Shelf::of("a.gltf", embedded(&block, node)),
    )
    .unwrap();
    let turn = Rotation3::from_euler_angles(0.0, 0.0, std::f64::consts::FRAC_PI_2);
    for (found, point) in found.points().iter().zip(block.points()) {
        let expected =
            turn * Vector3::new(-2.0 * point.x, point.y, point.z) + Vector3::new(1.0, 2.0, 3.0);
        assert!((found - expected).norm() < 1e-12);
    }
    // A mirror turns the order of corners, so that the triangles still look outward.
    let volume = |mesh: &Mesh| -> f64 {
        let each = mesh.triangles().iter().map(|corners| {
            let [a, b, c] = corners.map(|corner| mesh.points()[corner as usize]);
            a.dot(&b.cross(&c)) / 6.0
        });
        each.sum()
    };
    assert!((volume(&found) - 2.0).abs() < 1e-12);
    let matrix = r#"{"mesh": 0, "matrix": [2,0,0,0, 0,1,0,0, 0,0,1,0, 5,6,7,1]}"#;
    let found = read(
        "a.gltf",
        1.0,
        &mut Shelf::of("a.gltf", embedded(&block, matrix)),
    )
    .unwrap();
    assert!((found.points()[1] - Vector3::new(7.0, 6.0, 7.0)).norm() < 1e-12);
}

#[test]
fn polygons_become_fans() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -1 0.5 0\nf 1 2 3 4 5\n";
    let found = read("a.obj", 1.0, &mut Shelf::of("a.obj", text)).unwrap();
    assert_eq!(found.triangles(), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
}

#[test]
fn a_sparse_accessor_changes_single_positions() {
    let block = block([0.0; 3], [1.0; 3]);
    let (mut bytes, positions) = binary(&block);
    let end = bytes.len();
    bytes.extend([7, 0, 0, 0]);
    bytes.extend(singles(&Vector3::new(2.0, 3.0, 4.0)));
    let uri = format!("data:;base64,{}", STANDARD.encode(&bytes));
    let text = gltf(&block, Some(&uri), r#"{"mesh": 0}"#)
        .replace(r#""type": "VEC3""#, r#""type": "VEC3", "sparse": {"count": 1,
            "indices": {"bufferView": 2, "componentType": 5121}, "values": {"bufferView": 2, "byteOffset": 4}}"#)
        .replace(&format!(r#""byteOffset": {positions}, "byteLength": {}}}"#, end - positions),
            &format!(r#""byteOffset": {positions}, "byteLength": {}}},
                {{"buffer": 0, "byteOffset": {end}, "byteLength": 16}}"#, end - positions))
        .replace(&format!(r#""byteLength": {end}}}]}}"#), &format!(r#""byteLength": {}}}]}}"#, bytes.len()));
    let found = read("a.gltf", 1.0, &mut Shelf::of("a.gltf", text)).unwrap();
    assert_eq!(found.points()[7], Vector3::new(2.0, 3.0, 4.0));
    assert_eq!(found.points()[6], block.points()[6]);
}
