//! What is wrong with a mesh, as sentences: the file, the place in it, what was found and what is allowed.

use std::fmt::{self, Display, Formatter};

use messages::{Localized, Text, text};
use thiserror::Error;

use crate::{MAX_COORDINATE_M, MAX_TRIANGLES, MIN_EXTENT_M};

/// A reason for which a file could not be read.
#[derive(Clone, Debug, PartialEq, Error, Localized)]
#[non_exhaustive]
pub enum FileError {
    /// The name leads out of the folder, by itself or through a link.
    #[error(
        "the file is outside of the folder; allowed are files within it, named by a relative path"
    )]
    #[zh("文件在文件夹之外；只允许其中的文件，用相对路径表示")]
    Outside,
    /// A folder, a device, a pipe or a socket.
    #[error("the name leads to no regular file, but for instance to a folder or a device")]
    #[zh("此名称所指不是普通文件，而是文件夹、设备之类")]
    Irregular,
    /// More bytes than are allowed.
    #[error("the file is longer than {most} bytes, the most that is allowed here")]
    #[zh("文件超过 {most} 字节，即此处允许的上限")]
    TooLong {
        /// What was allowed.
        most: u64,
    },
    /// The system's own words, such as that there is no such file.
    #[error("the file cannot be read: {0}")]
    #[zh("无法读取文件：{0}")]
    System(Text),
}

/// A place in a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FilePosition {
    /// A byte, from 0.
    Byte(usize),
    /// A line, from 1.
    Line(usize),
    /// A triangle, in the order of the file, from 0.
    Triangle(usize),
    /// An element of an array of a glTF file, from 0.
    Element(&'static str, usize),
    /// The file as a whole.
    Whole,
}

/// What is wrong at a place of a file.
fn located(file: &str, place: &FilePosition, trouble: &Text) -> Text {
    match place {
        FilePosition::Byte(at) => text!(
            "{file}, byte {at}: {trouble}",
            "{file}，字节 {at}：{trouble}"
        ),
        FilePosition::Line(at) => text!(
            "{file}, line {at}: {trouble}",
            "{file}，第 {at} 行：{trouble}"
        ),
        FilePosition::Triangle(at) => text!(
            "{file}, triangle {at}: {trouble}",
            "{file}，三角形 {at}：{trouble}"
        ),
        FilePosition::Element(array, at) => text!(
            "{file}, {array}[{at}]: {trouble}",
            "{file}，{array}[{at}]：{trouble}"
        ),
        FilePosition::Whole => text!("{file}: {trouble}", "{file}：{trouble}"),
    }
}

/// A reason for which a file is no mesh, or a mesh is no solid.
#[derive(Clone, Debug, PartialEq, Error, Localized)]
#[non_exhaustive]
pub enum MeshError {
    /// The file, or a buffer beside a glTF file, could not be read.
    #[error("{file}: {source}")]
    File {
        /// Name of the file.
        file: String,
        /// Reason for which it could not be read.
        source: FileError,
    },
    /// No format has this ending.
    #[error(
        "{file}: the name ends in no known format of meshes; allowed are .stl, .obj, .gltf and .glb"
    )]
    #[zh("{file}：名称的后缀不是已知的网格格式；允许 .stl、.obj、.gltf 和 .glb")]
    Format {
        /// Name of the file.
        file: String,
    },
    /// A scale that is no length.
    #[error("{file}: the scale is {scale}; allowed is a finite number above 0")]
    #[zh("{file}：scale 为 {scale}；允许大于 0 的有限的数")]
    Scale {
        /// Name of the file.
        file: String,
        /// The scale that was given.
        scale: f64,
    },
    /// What is there is not what the format says.
    #[error("{}", located(.file, .place, .trouble))]
    Damaged {
        /// Name of the file.
        file: String,
        /// Position in the file.
        place: FilePosition,
        /// What was found, and what is allowed.
        trouble: Text,
    },
    /// Too large to be handled.
    #[error("{}", located(
        .file,
        .place,
        &text!(
            "the file has more than {MAX_TRIANGLES} triangles, the most that is allowed",
            "文件中的三角形超过 {MAX_TRIANGLES} 个，即允许的上限"
        )
    ))]
    TooManyTriangles {
        /// Name of the file.
        file: String,
        /// Where it became too many.
        place: FilePosition,
    },
    /// Nothing to see.
    #[error("{file}: the file has no triangle with an area")]
    #[zh("{file}：文件中没有面积不为零的三角形")]
    Empty {
        /// Name of the file.
        file: String,
    },
    /// A hole in the surface.
    #[error(
        "{file}, triangle {triangle}: the surface is open: the edge from {from} to {to} m belongs to one triangle \
         only; in a solid every edge belongs to two"
    )]
    #[zh(
        "{file}，三角形 {triangle}：表面不封闭：从 {from} 到 {to} m 的边只属于一个三角形；实体的每条边属于两个三角形"
    )]
    Open {
        /// Name of the file.
        file: String,
        /// The triangle at the hole, from 0.
        triangle: usize,
        /// Where the edge begins.
        from: Spot,
        /// Where the edge ends.
        to: Spot,
    },
    /// An edge of three or more triangles.
    #[error(
        "{file}, triangle {triangle}: the edge from {from} to {to} m belongs to {count} triangles; in a solid every \
         edge belongs to two"
    )]
    #[zh(
        "{file}，三角形 {triangle}：从 {from} 到 {to} m 的边属于 {count} 个三角形；实体的每条边属于两个三角形"
    )]
    Branched {
        /// Name of the file.
        file: String,
        /// One of the triangles, from 0.
        triangle: usize,
        /// Where the edge begins.
        from: Spot,
        /// Where the edge ends.
        to: Spot,
        /// How many triangles have this edge.
        count: usize,
    },
    /// Neighbours that turn opposite sides outward.
    #[error(
        "{file}: one of triangles {triangle} and {other} is inside out: both run along the edge from {from} to {to} m \
         in the same direction; corners must be counterclockwise seen from outside"
    )]
    #[zh(
        "{file}：三角形 {triangle} 和 {other} 中有一个里外颠倒：两者沿从 {from} 到 {to} m 的边方向相同；从外面看，顶点必须按逆时针排列"
    )]
    Turned {
        /// Name of the file.
        file: String,
        /// One of the triangles, from 0.
        triangle: usize,
        /// A further triangle with the edge, from 0.
        other: usize,
        /// Where the edge begins.
        from: Spot,
        /// Where the edge ends.
        to: Spot,
    },
    /// No space within the surface.
    #[error(
        "{file}: the surface encloses no volume: {volume:e} m³ in a box of {x:e} by {y:e} by {z:e} m"
    )]
    #[zh("{file}：表面没有围出体积：在 {x:e} × {y:e} × {z:e} m 的范围内为 {volume:e} m³")]
    NoVolume {
        /// Name of the file.
        file: String,
        /// What is enclosed, in m³.
        volume: f64,
        /// The extent along x, in m.
        x: f64,
        /// The extent along y, in m.
        y: f64,
        /// The extent along z, in m.
        z: f64,
    },
    /// Too far from the origin.
    #[error(
        "{file}, triangle {triangle}: a corner is at {spot} m; allowed are coordinates within {MAX_COORDINATE_M} m (a \
         file in millimetres needs a scale of 0.001)"
    )]
    #[zh(
        "{file}，三角形 {triangle}：有一个顶点位于 {spot} m；坐标允许在 {MAX_COORDINATE_M} m 以内（以毫米为单位的文件需要 0.001 的 scale）"
    )]
    TooFar {
        /// Name of the file.
        file: String,
        /// Number of the triangle, from 0.
        triangle: usize,
        /// Where the corner is.
        spot: Spot,
    },
    /// Too small, or flat.
    #[error(
        "{file}: the extent along {axis} is {extent:e} m; allowed is {MIN_EXTENT_M} m and more"
    )]
    #[zh("{file}：沿 {axis} 的尺寸为 {extent:e} m；允许 {MIN_EXTENT_M} m 及以上")]
    TooSmall {
        /// Name of the file.
        file: String,
        /// The axis: x, y or z.
        axis: char,
        /// How long it is, in m.
        extent: f64,
    },
}

/// A point in sentences, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot(pub [f64; 3]);

impl Display for Spot {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.0;
        write!(f, "({x}, {y}, {z})")
    }
}

/// The beginning of what a file says, safe to be shown.
pub(crate) fn excerpt(bytes: &[u8]) -> String {
    let start = &bytes[..bytes.len().min(40)];
    let text: String = String::from_utf8_lossy(start).chars().take(32).collect();
    let more = if bytes.len() > 32 { "…" } else { "" };
    format!("{:?}", format!("{text}{more}"))
}
