//! The part of a glTF document that says where surfaces are, as types for serde.
//!
//! A few bytes of text must not become many of memory, so the arrays have a longest length.

use std::collections::BTreeMap;
use std::fmt::{self, Formatter};
use std::marker::PhantomData;

use serde::de::{Deserialize, Deserializer, Error, SeqAccess, Visitor};

/// The longest array of a document, and the most primitives that are drawn.
pub(super) const ELEMENTS_MAX: usize = 100_000;

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase", expecting = "an object")]
pub(super) struct Document {
    pub asset: Asset,
    #[serde(default)]
    pub extensions_required: Elements<String>,
    pub scene: Option<usize>,
    #[serde(default)]
    pub scenes: Elements<Scene>,
    #[serde(default)]
    pub nodes: Elements<Node>,
    #[serde(default)]
    pub meshes: Elements<MeshEntry>,
    #[serde(default)]
    pub accessors: Elements<Accessor>,
    #[serde(default)]
    pub buffer_views: Elements<BufferView>,
    #[serde(default)]
    pub buffers: Elements<Buffer>,
}

#[derive(serde::Deserialize)]
#[serde(expecting = "an object")]
pub(super) struct Asset {
    pub version: String,
}

#[derive(serde::Deserialize)]
#[serde(expecting = "an object")]
pub(super) struct Scene {
    #[serde(default)]
    pub nodes: Elements<usize>,
}

#[derive(serde::Deserialize)]
#[serde(expecting = "an object")]
pub(super) struct Node {
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    #[serde(default)]
    pub children: Elements<usize>,
    /// Column by column.
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    /// x, y, z, w.
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
}

#[derive(serde::Deserialize)]
#[serde(expecting = "an object")]
pub(super) struct MeshEntry {
    pub primitives: Elements<Primitive>,
}

#[derive(serde::Deserialize)]
#[serde(expecting = "an object")]
pub(super) struct Primitive {
    pub attributes: BTreeMap<String, usize>,
    pub indices: Option<usize>,
    pub mode: Option<u64>,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase", expecting = "an object")]
pub(super) struct Accessor {
    pub buffer_view: Option<usize>,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u64,
    #[serde(default)]
    pub normalized: bool,
    pub count: usize,
    #[serde(rename = "type")]
    pub shape: String,
    pub sparse: Option<Sparse>,
}

#[derive(serde::Deserialize)]
#[serde(expecting = "an object")]
pub(super) struct Sparse {
    pub count: usize,
    pub indices: SparseIndices,
    pub values: SparseValues,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase", expecting = "an object")]
pub(super) struct SparseIndices {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub component_type: u64,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase", expecting = "an object")]
pub(super) struct SparseValues {
    pub buffer_view: usize,
    #[serde(default)]
    pub byte_offset: usize,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase", expecting = "an object")]
pub(super) struct BufferView {
    pub buffer: usize,
    #[serde(default)]
    pub byte_offset: usize,
    pub byte_length: usize,
    pub byte_stride: Option<usize>,
}

#[derive(serde::Deserialize)]
#[serde(rename_all = "camelCase", expecting = "an object")]
pub(super) struct Buffer {
    pub uri: Option<String>,
    pub byte_length: usize,
}

/// An array of a document, of at most [`ELEMENTS_MAX`] elements.
pub(super) struct Elements<T>(pub Vec<T>);

impl<T> Default for Elements<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Elements<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Elementwise<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Elementwise<T> {
            type Value = Elements<T>;

            fn expecting(&self, f: &mut Formatter<'_>) -> fmt::Result {
                write!(f, "an array of at most {ELEMENTS_MAX} elements")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Self::Value, A::Error> {
                let mut elements = Vec::new();
                while let Some(element) = seq.next_element()? {
                    if elements.len() == ELEMENTS_MAX {
                        return Err(A::Error::invalid_length(ELEMENTS_MAX + 1, &self));
                    }
                    elements.push(element);
                }
                Ok(Elements(elements))
            }
        }
        deserializer.deserialize_seq(Elementwise(PhantomData))
    }
}
