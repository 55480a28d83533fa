//! Files that are no meshes: each is refused in a sentence with the file and the place.

use mesh::{FileError, Folder, MeshError, MeshFiles, read};
use proptest::prelude::*;

use crate::formats::{embedded, glb, gltf, obj, stl_binary, stl_text};
use crate::shapes::{Shelf, block};

fn refusal(name: &str, bytes: impl Into<Vec<u8>>) -> String {
    read(name, 1.0, &mut Shelf::of(name, bytes))
        .unwrap_err()
        .to_string()
}

#[test]
fn names_and_scales_that_are_none() {
    assert_eq!(
        refusal("a.step", ""),
        "a.step: the name ends in no known format of meshes; allowed are .stl, .obj, .gltf and .glb"
    );
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let error = read("a.stl", scale, &mut Shelf::default()).unwrap_err();
        assert!(
            error
                .to_string()
                .ends_with("allowed is a finite number above 0")
        );
    }
    let error = read("b.stl", 1.0, &mut Shelf::default())
        .unwrap_err()
        .to_string();
    assert_eq!(error, "b.stl: the file cannot be read: there is no b.stl");
}

#[test]
fn stl_that_is_damaged() {
    let cube = block([0.0; 3], [1.0; 3]);
    let whole = stl_binary(&cube);
    let mut cut = whole.clone();
    cut[0] = b'S' + 1;
    cut.pop();
    assert_eq!(
        refusal("a.stl", cut.clone()),
        "a.stl, byte 80: 12 triangles are announced, which are 600 bytes; 599 bytes follow"
    );
    cut[80..84].copy_from_slice(&1_000_000_000_u32.to_le_bytes());
    assert_eq!(
        refusal("a.stl", cut),
        "a.stl, byte 80: the file has more than 2000000 triangles, the most that is allowed"
    );
    let mut not_a_number = whole;
    not_a_number[84 + 50 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
    assert!(refusal("a.stl", not_a_number).starts_with("a.stl, byte 134: a point is at (NaN, "));
    assert!(refusal("a.stl", "").contains("the file has 0 bytes"));
    let text = String::from_utf8(stl_text(&cube)).unwrap();
    assert_eq!(
        refusal("a.stl", text.replacen("vertex", "vertex inf", 1)),
        "a.stl, line 4: \"inf\" is no finite number; a vertex has three"
    );
    let half = &text[..text.len() / 2];
    assert!(refusal("a.stl", half).starts_with("a.stl, line "));
    assert_eq!(
        refusal("a.stl", "solid a\nfacet normal 0 0 1"),
        "a.stl, line 2: found the end of the file where outer is needed"
    );
    assert!(
        refusal("a.stl", text.replace("endsolid", ""))
            .starts_with("a.stl, line 86: found \"two\" where facet is needed")
    );
    assert_eq!(
        refusal("a.stl", "solid a\nendsolid a\n"),
        "a.stl: the file has no triangle with an area"
    );
}

#[test]
fn obj_that_is_damaged() {
    let points = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (line, sentence) in [
        (
            "v 1 2",
            "a.obj, line 4: \"\" is no finite number; a point v has three",
        ),
        (
            "v 1 2 nan",
            "a.obj, line 4: \"nan\" is no finite number; a point v has three",
        ),
        (
            "f 1 2",
            "a.obj, line 4: a face has 2 corners; allowed are 3 to 1000",
        ),
        (
            "f 1 2 4",
            "a.obj, line 4: a face names point \"4\"; before this line there are 3 points, from 1 or, backwards, \
             from -1",
        ),
        (
            "f 1 2 0",
            "a.obj, line 4: a face names point \"0\"; before this line there are 3 points, from 1 or, backwards, \
             from -1",
        ),
        (
            "f 1 2 -9223372036854775808",
            "a.obj, line 4: a face names point \"-9223372036854775808\"; before this line there are 3 points, \
             from 1 or, backwards, from -1",
        ),
        (
            "surf 0 1",
            "a.obj, line 4: there is a curve or a curved surface; allowed are faces f of straight edges",
        ),
        (
            "\u{1}\u{2}",
            "a.obj, line 4: \"\\u{1}\\u{2}\" is no statement of OBJ",
        ),
        ("", "a.obj: the file has no triangle with an area"),
    ] {
        assert_eq!(refusal("a.obj", format!("{points}{line}")), sentence);
    }
    let long = format!("{points}f{}", " 1".repeat(1001));
    assert!(refusal("a.obj", long).contains("more than 1000 corners"));
}

#[test]
fn gltf_that_is_damaged() {
    let cube = block([0.0; 3], [1.0; 3]);
    let text = String::from_utf8(embedded(&cube, r#"{"mesh": 0}"#)).unwrap();
    let changed = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        refusal("a.gltf", text.replace(from, to))
    };
    assert!(
        changed("\"2.0\"", "\"1.0\"").contains("the version of glTF is \"1.0\"; allowed is 2.0")
    );
    assert!(
        changed(r#""count": 8"#, r#""count": 1000000000"#)
            .starts_with("a.gltf, accessors[0]: its count is")
    );
    let beyond = changed(r#""count": 8"#, r#""count": 9"#);
    assert_eq!(
        beyond,
        "a.gltf, accessors[0]: 9 elements of 12 bytes, 12 apart, from byte 0 are beyond the 96 bytes of bufferViews[0]"
    );
    assert!(
        changed(
            r#""byteLength": 96"#,
            r#""byteLength": 18446744073709551615"#
        )
        .contains("bufferViews[0]")
    );
    assert!(
        changed(
            r#""byteOffset": 96"#,
            r#""byteOffset": 18446744073709551615"#
        )
        .contains("bufferViews[1]")
    );
    assert!(
        changed(
            r#""byteLength": 96"#,
            r#""byteStride": 4, "byteLength": 96"#
        )
        .contains("byteStride is 4")
    );
    assert!(changed(r#""count": 36"#, r#""count": 35"#).contains("no whole triangles"));
    assert!(changed("5126", "5130").contains("componentType is 5130"));
    assert!(changed("VEC3", "VEC2").contains("its type is \"VEC2\"; here it must be VEC3"));
    assert!(changed("\"POSITION\"", "\"COLOR_0\"").contains("no POSITION"));
    assert!(
        changed(r#""material": 3"#, r#""mode": 5"#)
            .contains("the mode of a primitive is 5; allowed is 4")
    );
    assert!(
        changed(r#"{"mesh": 0}"#, r#"{"mesh": 0, "children": [0]}"#)
            .contains("nodes[0]: it is reached twice")
    );
    assert!(
        changed(r#"{"mesh": 0}"#, r#"{"mesh": 0, "children": [1]}"#)
            .contains("nodes[1]: it is reached twice")
    );
    assert!(
        changed(r#"{"mesh": 0}"#, r#"{"mesh": 7}"#)
            .contains("nodes[1]: it names meshes[7]; there are 1")
    );
    assert!(changed(r#"{"mesh": 0}"#, r#"{"mesh": 0, "skin": 0}"#).contains("skin"));
    assert!(
        changed(r#"{"mesh": 0}"#, r#"{"mesh": 0, "rotation": [0,0,0,0]}"#)
            .contains("no finite one")
    );
    assert!(changed(r#""scene": 0"#, r#""scene": 4"#).contains("scenes[4]"));
    assert!(
        changed(
            r#""scene": 0"#,
            r#""extensionsRequired": ["KHR_draco_mesh_compression"]"#
        )
        .contains("draco")
    );
    assert!(changed("base64,", "base64,!").contains("buffers[0]: its data are no base64"));
    assert!(
        changed(";base64,", ";base32,").contains("its data are \"data:application/octet-stream")
    );
    assert!(refusal("a.gltf", "[".repeat(100_000)).contains("it is no glTF"));
    assert_eq!(
        changed(r#""asset": {"version": "2.0"}"#, r#""asset": 3"#),
        "a.gltf, line 1: it is no glTF (column 11): invalid type: integer `3`, expected an object"
    );
    let many = format!(
        r#"{{"asset": {{"version": "2.0"}}, "nodes": [{}{{}}]}}"#,
        "{},".repeat(100_000)
    );
    assert!(refusal("a.gltf", many).contains("an array of at most 100000 elements"));
    let mut binary = glb(&cube);
    binary.pop();
    assert!(refusal("a.glb", binary.clone()).starts_with("a.glb, byte 8: "));
    let length = u32::try_from(binary.len()).unwrap();
    binary[8..12].copy_from_slice(&length.to_le_bytes());
    assert!(refusal("a.glb", binary.clone()).ends_with("a chunk is longer than the file"));
    binary[4] = 1;
    assert!(refusal("a.glb", binary).contains("the version of GLB is 1; allowed is 2"));
    assert!(refusal("a.glb", "glTF").contains("a GLB has a head of 12 bytes; there are 4"));
}

#[test]
fn uris_never_leave_the_folder_of_the_file() {
    let cube = block([0.0; 3], [1.0; 3]);
    for uri in [
        "../x",
        "a/../../x",
        "%2e%2e/x",
        "/etc/passwd",
        "%2Fetc/passwd",
        "http://there/x",
        "file:///etc/passwd",
        "a\\\\x",
        "c:x",
        "",
        "%zz",
        "a%",
        "x%00",
    ] {
        let text = gltf(&cube, Some(uri), r#"{"mesh": 0}"#);
        let sentence = refusal("meshes/a.gltf", text);
        assert!(
            sentence.starts_with("meshes/a.gltf, buffers[0]: its uri is "),
            "{uri}: {sentence}"
        );
    }
}

#[test]
fn a_folder_gives_what_is_in_it_and_nothing_else() {
    let around = tempfile::tempdir().unwrap();
    let root = around.path().join("cell");
    std::fs::create_dir_all(root.join("meshes")).unwrap();
    std::fs::write(around.path().join("secret.bin"), "secret").unwrap();
    std::fs::write(root.join("a.bin"), "inside").unwrap();
    std::fs::write(root.join("meshes/b.bin"), "deeper").unwrap();
    let mut folder = Folder::new(&root);
    assert_eq!(folder.read("a.bin", 6).unwrap(), b"inside");
    assert_eq!(
        folder.read("./meshes/../meshes//b.bin", 64).unwrap(),
        b"deeper"
    );
    assert_eq!(folder.read("a.bin", 5), Err(FileError::TooLong { most: 5 }));
    assert_eq!(folder.read("meshes", 5), Err(FileError::Irregular));
    assert_eq!(folder.read("", 5), Err(FileError::Irregular));
    assert!(matches!(
        folder.read("none.bin", 5),
        Err(FileError::System(_))
    ));
    for path in [
        "../secret.bin",
        "meshes/../../secret.bin",
        "/etc/passwd",
        "..",
        "meshes\\b.bin",
        "c:x",
    ] {
        assert_eq!(folder.read(path, 64), Err(FileError::Outside), "{path}");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::symlink;
        symlink(around.path().join("secret.bin"), root.join("link.bin")).unwrap();
        symlink(around.path(), root.join("up")).unwrap();
        symlink("../a.bin", root.join("meshes/beside.bin")).unwrap();
        symlink("meshes/b.bin", root.join("down.bin")).unwrap();
        symlink("/dev/zero", root.join("endless.stl")).unwrap();
        assert_eq!(folder.read("link.bin", 64), Err(FileError::Outside));
        assert_eq!(folder.read("up/secret.bin", 64), Err(FileError::Outside));
        // Within the folder of the cell, but not of the file beside it.
        assert_eq!(
            folder.read("meshes/beside.bin", 64),
            Err(FileError::Outside)
        );
        assert_eq!(folder.read("down.bin", 64).unwrap(), b"deeper");
        assert_eq!(folder.read("endless.stl", 64), Err(FileError::Outside));
        let mut devices = Folder::new("/dev");
        assert_eq!(devices.read("zero", 64), Err(FileError::Irregular));
    }
}

#[test]
fn the_buffers_of_a_file_are_bounded_together() {
    struct Endless;
    impl MeshFiles for Endless {
        fn read(&mut self, path: &str, most: u64) -> Result<Vec<u8>, FileError> {
            if path == "a.gltf" {
                let buffer = r#"{"uri": "b.bin", "byteLength": 40000000}"#;
                let text = format!(
                    r#"{{"asset": {{"version": "2.0"}}, "buffers": [{buffer}, {buffer}]}}"#
                );
                return Ok(text.into_bytes());
            }
            if most < 40_000_000 {
                Err(FileError::TooLong { most })
            } else {
                Ok(vec![0; 40_000_000])
            }
        }
    }
    let error = read("a.gltf", 1.0, &mut Endless).unwrap_err();
    assert!(
        matches!(
            error,
            MeshError::File {
                source: FileError::TooLong { most: 27_108_864 },
                ..
            }
        ),
        "{error}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Right files with wrong bytes, cut anywhere.
    #[test]
    fn damaged_bytes_never_panic(
        format in 0_usize..5,
        changes in proptest::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..8),
        end in any::<prop::sample::Index>(),
        whole: bool,
    ) {
        let cube = block([0.0; 3], [1.0; 3]);
        let (name, mut bytes) = match format {
            0 => ("a.stl", stl_text(&cube)),
            1 => ("a.stl", stl_binary(&cube)),
            2 => ("a.obj", obj(&cube)),
            3 => ("a.gltf", embedded(&cube, r#"{"mesh": 0, "scale": [1, 2, 3]}"#)),
            _ => ("a.glb", glb(&cube)),
        };
        for (place, byte) in changes {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        if !whole {
            bytes.truncate(end.index(bytes.len()));
        }
        check(name, bytes);
    }

    #[test]
    fn random_bytes_never_panic(bytes in proptest::collection::vec(any::<u8>(), 0..300), ending in 0_usize..4) {
        let mut bytes = bytes;
        if ending == 3 {
            bytes.splice(0..0, *b"glTF\x02\0\0\0");
        }
        check(["a.stl", "a.obj", "a.gltf", "a.glb"][ending], bytes);
    }
}

/// Whatever it is, it becomes a solid with pieces or a sentence with the name of the file.
fn check(name: &str, bytes: Vec<u8>) {
    let found = read(name, 1.0, &mut Shelf::of(name, bytes));
    match found.and_then(|mesh| mesh::Solid::new(std::sync::Arc::new(mesh))) {
        Ok(solid) => {
            let pieces = mesh::convex_pieces(&solid, 3);
            assert!((1..=3).contains(&pieces.pieces().len()) && pieces.deviation() >= 0.0);
        }
        Err(error) => {
            let sentence = error.to_string();
            assert!(
                sentence.starts_with("a.") && sentence.len() < 500,
                "{sentence}"
            );
        }
    }
}
