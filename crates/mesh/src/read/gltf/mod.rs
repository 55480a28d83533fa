//! glTF 2.0, as text and as GLB: the triangles of the default scene, moved by the nodes that they hang on.
//!
//! Materials, textures, cameras and animations do not say where a surface is at rest and are passed over. Axes stay
//! as they are in the file, where y points up.

mod accessor;
mod buffers;
mod document;

use messages::text;
use nalgebra::{Matrix4, Quaternion, UnitQuaternion, Vector3};

use accessor::Content;
use document::{Document, ELEMENTS_MAX, Node, Primitive};

use super::Soup;
use crate::MAX_TRIANGLES;
use crate::error::{FilePosition, MeshError, excerpt};
use crate::files::MeshFiles;

/// Extensions that a file may require although they are not known here: they change how a surface looks.
const HARMLESS_EXTENSIONS: &[&str] = &[
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "EXT_texture_",
    "KHR_mesh_quantization",
];

pub(super) fn read(
    bytes: &[u8],
    soup: &mut Soup<'_>,
    files: &mut dyn MeshFiles,
) -> Result<(), MeshError> {
    let (text, chunk) = if bytes.starts_with(b"glTF") {
        chunks(bytes, soup)?
    } else {
        (bytes, None)
    };
    let document: Document =
        serde_json::from_slice(text).map_err(|error| no_document(&error, soup))?;
    if !document.asset.version.starts_with("2.") {
        let version = excerpt(document.asset.version.as_bytes());
        return Err(soup.damaged(
            FilePosition::Whole,
            text!(
                "the version of glTF is {version}; allowed is 2.0",
                "glTF 的版本为 {version}；只允许 2.0"
            ),
        ));
    }
    let unknown = |name: &&String| {
        !HARMLESS_EXTENSIONS
            .iter()
            .any(|start| name.starts_with(start))
    };
    if let Some(name) = document.extensions_required.0.iter().find(unknown) {
        let trouble = text!(
            "it requires the extension {}; export it without compression and without extensions of geometry",
            "它需要扩展 {}；请导出为不压缩、不带几何扩展的文件",
            excerpt(name.as_bytes())
        );
        return Err(soup.damaged(FilePosition::Whole, trouble));
    }
    let buffers = buffers::load(&document.buffers.0, chunk, soup, files)?;
    let content = Content {
        document: &document,
        buffers: &buffers,
    };
    let mut drawn = 0;
    for (number, to_scene) in placed_nodes(&document, soup)? {
        let node = &document.nodes.0[number];
        let Some(mesh) = node.mesh else { continue };
        let meshes = &document.meshes.0;
        let place = FilePosition::Element("nodes", number);
        let Some(entry) = meshes.get(mesh) else {
            let trouble = text!(
                "it names meshes[{mesh}]; there are {}",
                "它引用 meshes[{mesh}]；只有 {} 个",
                meshes.len()
            );
            return Err(soup.damaged(place, trouble));
        };
        if node.skin.is_some() {
            return Err(soup.damaged(
                place,
                text!(
                    "it has a skin, whose shape depends on bones; allowed are rigid meshes",
                    "它有蒙皮，形状随骨骼而变；只允许刚性网格"
                ),
            ));
        }
        for primitive in &entry.primitives.0 {
            drawn += 1;
            if drawn > ELEMENTS_MAX {
                let trouble = text!(
                    "more than {ELEMENTS_MAX} primitives are drawn, the most that is allowed",
                    "绘制的图元超过 {ELEMENTS_MAX} 个，即允许的上限"
                );
                return Err(soup.damaged(place, trouble));
            }
            add_primitive(&content, primitive, mesh, &to_scene, soup)?;
        }
    }
    Ok(())
}

/// What serde says, with its line as the place.
fn no_document(error: &serde_json::Error, soup: &Soup<'_>) -> MeshError {
    let (line, column) = (error.line(), error.column());
    let text = error.to_string();
    let place = format!(" at line {line} column {column}");
    let said = text.strip_suffix(&place).unwrap_or(&text);
    let trouble = text!(
        "it is no glTF (column {column}): {said}",
        "不是 glTF（第 {column} 列）：{said}"
    );
    soup.damaged(FilePosition::Line(line), trouble)
}

/// The text and the binary chunk of a GLB.
fn chunks<'a>(bytes: &'a [u8], soup: &Soup<'_>) -> Result<(&'a [u8], Option<&'a [u8]>), MeshError> {
    let word = |at: usize| {
        let four = bytes.get(at..at + 4).and_then(|four| four.try_into().ok());
        four.map(u32::from_le_bytes)
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        let trouble = text!(
            "a GLB has a head of 12 bytes; there are {}",
            "GLB 的文件头为 12 字节；这里只有 {} 字节",
            bytes.len()
        );
        return Err(soup.damaged(FilePosition::Byte(0), trouble));
    };
    if version != 2 {
        return Err(soup.damaged(
            FilePosition::Byte(4),
            text!(
                "the version of GLB is {version}; allowed is 2",
                "GLB 的版本为 {version}；只允许 2"
            ),
        ));
    }
    if usize::try_from(length) != Ok(bytes.len()) {
        let trouble = text!(
            "{length} bytes are announced; the file has {}",
            "声明有 {length} 字节；文件有 {} 字节",
            bytes.len()
        );
        return Err(soup.damaged(FilePosition::Byte(8), trouble));
    }
    let mut at = 12;
    let mut text = None;
    let mut binary = None;
    while at < bytes.len() {
        let body = word(at)
            .and_then(|size| usize::try_from(size).ok())
            .and_then(|size| bytes.get(at + 8..)?.get(..size));
        let (Some(body), Some(kind)) = (body, word(at + 4)) else {
            return Err(soup.damaged(
                FilePosition::Byte(at),
                text!(
                    "a chunk is longer than the file",
                    "有一个数据块超出文件末尾"
                ),
            ));
        };
        match &kind.to_le_bytes() {
            b"JSON" if text.is_none() => text = Some(body),
            b"BIN\0" if binary.is_none() => binary = Some(body),
            // Chunks of other kinds belong to extensions.
            _ => {}
        }
        at += 8 + body.len();
    }
    match text {
        Some(text) => Ok((text, binary)),
        None => Err(soup.damaged(
            FilePosition::Byte(12),
            text!("there is no chunk JSON", "没有 JSON 数据块"),
        )),
    }
}

/// The nodes of the default scene, each with the matrix from its mesh to the scene, in the order of the file's tree.
fn placed_nodes(
    document: &Document,
    soup: &Soup<'_>,
) -> Result<Vec<(usize, Matrix4<f64>)>, MeshError> {
    let nodes = &document.nodes.0;
    let scenes = &document.scenes.0;
    let roots = match scenes.get(document.scene.unwrap_or(0)) {
        Some(scene) => scene.nodes.0.clone(),
        None if document.scene.is_none() => orphans(nodes),
        None => {
            let trouble = text!(
                "it is the default scene; there are {} scenes",
                "它是默认场景；但只有 {} 个场景",
                scenes.len()
            );
            return Err(soup.damaged(
                FilePosition::Element("scenes", document.scene.unwrap_or(0)),
                trouble,
            ));
        }
    };
    let mut met = vec![false; nodes.len()];
    let mut waiting: Vec<(usize, Matrix4<f64>)> = roots
        .iter()
        .rev()
        .map(|&root| (root, Matrix4::identity()))
        .collect();
    let mut placed = Vec::new();
    while let Some((number, to_scene)) = waiting.pop() {
        let place = FilePosition::Element("nodes", number);
        let Some(node) = nodes.get(number) else {
            let trouble = text!(
                "it is named, but there are {} nodes",
                "它被引用，但只有 {} 个节点",
                nodes.len()
            );
            return Err(soup.damaged(place, trouble));
        };
        if std::mem::replace(&mut met[number], true) {
            let trouble = text!(
                "it is reached twice; a node hangs on one other, and never on itself",
                "它被到达两次；一个节点只能挂在另一个节点下，且不能挂在自己下面"
            );
            return Err(soup.damaged(place, trouble));
        }
        let to_scene = to_scene * matrix(node);
        if to_scene.iter().any(|x| !x.is_finite()) {
            return Err(soup.damaged(
                place,
                text!("its matrix is no finite one", "它的矩阵含有非有限的数"),
            ));
        }
        waiting.extend(node.children.0.iter().rev().map(|&child| (child, to_scene)));
        placed.push((number, to_scene));
    }
    Ok(placed)
}

/// The nodes that hang on no other one.
fn orphans(nodes: &[Node]) -> Vec<usize> {
    let mut is_child = vec![false; nodes.len()];
    for &child in nodes.iter().flat_map(|node| &node.children.0) {
        if let Some(mark) = is_child.get_mut(child) {
            *mark = true;
        }
    }
    (0..nodes.len())
        .filter(|&number| !is_child[number])
        .collect()
}

/// From the node to the one that it hangs on.
fn matrix(node: &Node) -> Matrix4<f64> {
    if let Some(columns) = node.matrix {
        return Matrix4::from_column_slice(&columns);
    }
    let [x, y, z, w] = node.rotation.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    let scale = Vector3::from(node.scale.unwrap_or([1.0; 3]));
    Matrix4::new_translation(&Vector3::from(node.translation.unwrap_or_default()))
        * rotation.to_homogeneous()
        * Matrix4::new_nonuniform_scaling(&scale)
}

fn add_primitive(
    content: &Content<'_>,
    primitive: &Primitive,
    mesh: usize,
    to_scene: &Matrix4<f64>,
    soup: &mut Soup<'_>,
) -> Result<(), MeshError> {
    let place = FilePosition::Element("meshes", mesh);
    let mode = primitive.mode.unwrap_or(4);
    if mode != 4 {
        let trouble = text!(
            "the mode of a primitive is {mode}; allowed is 4, triangles",
            "有一个图元的 mode 为 {mode}；只允许 4，即三角形"
        );
        return Err(soup.damaged(place, trouble));
    }
    let Some(&positions) = primitive.attributes.get("POSITION") else {
        return Err(soup.damaged(
            place,
            text!("a primitive has no POSITION", "有一个图元没有 POSITION"),
        ));
    };
    let points = content.positions(positions, soup)?;
    let corners = match primitive.indices {
        Some(indices) => content.indices(indices, points.len(), soup)?,
        // At most three points for each triangle that is allowed, so the numbers fit.
        None => (0..).take(points.len()).collect(),
    };
    if corners.len() % 3 != 0 {
        let trouble = text!(
            "a primitive has {} corners, which are no whole triangles",
            "有一个图元有 {} 个顶点，凑不成完整的三角形",
            corners.len()
        );
        return Err(soup.damaged(place, trouble));
    }
    if soup.triangles.len() + corners.len() / 3 > MAX_TRIANGLES {
        return Err(MeshError::TooManyTriangles {
            file: soup.file.to_owned(),
            place,
        });
    }
    let linear = to_scene.fixed_view::<3, 3>(0, 0).into_owned();
    let shift = to_scene.fixed_view::<3, 1>(0, 3).into_owned();
    // A mirror turns the order of corners around.
    let mirrored = linear.determinant() < 0.0;
    let mut numbers = Vec::with_capacity(points.len());
    for point in points {
        numbers.push(soup.add_point(&place, linear * point + shift)?);
    }
    for corners in corners.chunks_exact(3) {
        let [a, b, c] = [corners[0], corners[1], corners[2]].map(|corner| numbers[corner as usize]);
        soup.add_triangle(&place, if mirrored { [a, c, b] } else { [a, b, c] })?;
    }
    Ok(())
}
