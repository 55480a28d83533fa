//! Numbers of a buffer as an accessor describes them. Every claim is held against the bytes that are there.

use messages::text;
use nalgebra::Vector3;

use super::document::{Accessor, Document};
use crate::MAX_TRIANGLES;
use crate::error::{FilePosition, MeshError, excerpt};
use crate::read::Soup;

/// A document with its bytes.
pub(super) struct Content<'a> {
    pub document: &'a Document,
    pub buffers: &'a [Vec<u8>],
}

/// How one number is stored.
#[derive(Clone, Copy)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of_code(code: u64) -> Option<Self> {
        Some(match code {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return None,
        })
    }

    fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number at the start of these bytes, and the one that stands for 1 where numbers are normalized.
    fn value(self, bytes: &[u8]) -> (f64, f64) {
        match (self, bytes) {
            (Self::I8, &[a, ..]) => (f64::from(i8::from_le_bytes([a])), 127.0),
            (Self::U8, &[a, ..]) => (f64::from(a), 255.0),
            (Self::I16, &[a, b, ..]) => (f64::from(i16::from_le_bytes([a, b])), 32767.0),
            (Self::U16, &[a, b, ..]) => (f64::from(u16::from_le_bytes([a, b])), 65535.0),
            (Self::U32, &[a, b, c, d, ..]) => (f64::from(u32::from_le_bytes([a, b, c, d])), 1.0),
            (Self::F32, &[a, b, c, d, ..]) => (f64::from(f32::from_le_bytes([a, b, c, d])), 1.0),
            _ => (f64::NAN, 1.0),
        }
    }

    /// The index at the start of these bytes, where it is a whole number without a sign.
    fn index(self, bytes: &[u8]) -> Option<u32> {
        Some(match (self, bytes) {
            (Self::U8, &[a, ..]) => u32::from(a),
            (Self::U16, &[a, b, ..]) => u32::from(u16::from_le_bytes([a, b])),
            (Self::U32, &[a, b, c, d, ..]) => u32::from_le_bytes([a, b, c, d]),
            _ => return None,
        })
    }
}

/// Elements in a buffer, all of which are there.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl Elements<'_> {
    fn get(&self, number: usize) -> &[u8] {
        &self.bytes[number * self.stride..][..self.size]
    }
}

impl Content<'_> {
    /// Positions: three numbers each.
    pub(super) fn positions(
        &self,
        number: usize,
        soup: &Soup<'_>,
    ) -> Result<Vec<Vector3<f64>>, MeshError> {
        let place = FilePosition::Element("accessors", number);
        let accessor = self.accessor(number, "VEC3", soup)?;
        let component = component(accessor.component_type, &place, soup)?;
        let read = |bytes: &[u8]| {
            Vector3::from_fn(|row, _| {
                let (value, one) = component.value(&bytes[row * component.bytes()..]);
                if accessor.normalized {
                    (value / one).max(-1.0)
                } else {
                    value
                }
            })
        };
        let size = 3 * component.bytes();
        let mut points = match accessor.buffer_view {
            Some(view) => {
                let elements = self.elements(
                    view,
                    accessor.byte_offset,
                    size,
                    accessor.count,
                    &place,
                    soup,
                )?;
                (0..elements.count)
                    .map(|index| read(elements.get(index)))
                    .collect()
            }
            None => vec![Vector3::zeros(); accessor.count],
        };
        if let Some(sparse) = &accessor.sparse {
            let code = component_of_indices(sparse.indices.component_type, &place, soup)?;
            let (view, offset) = (sparse.indices.buffer_view, sparse.indices.byte_offset);
            let indices = self.elements(view, offset, code.bytes(), sparse.count, &place, soup)?;
            let (view, offset) = (sparse.values.buffer_view, sparse.values.byte_offset);
            let values = self.elements(view, offset, size, sparse.count, &place, soup)?;
            for entry in 0..sparse.count {
                let index = code
                    .index(indices.get(entry))
                    .and_then(|index| usize::try_from(index).ok());
                let Some(point) = index.and_then(|index| points.get_mut(index)) else {
                    let trouble = text!(
                        "its sparse entry {entry} changes element {}; there are {}",
                        "它的 sparse 条目 {entry} 改动元素 {}；只有 {} 个元素",
                        index.unwrap_or_default(),
                        accessor.count
                    );
                    return Err(soup.damaged(place, trouble));
                };
                *point = read(values.get(entry));
            }
        }
        Ok(points)
    }

    /// Indices of corners, each below `points`.
    pub(super) fn indices(
        &self,
        number: usize,
        points: usize,
        soup: &Soup<'_>,
    ) -> Result<Vec<u32>, MeshError> {
        let place = FilePosition::Element("accessors", number);
        let accessor = self.accessor(number, "SCALAR", soup)?;
        let component = component_of_indices(accessor.component_type, &place, soup)?;
        let (Some(view), None) = (accessor.buffer_view, &accessor.sparse) else {
            let trouble = text!(
                "indices of triangles must have a bufferView and nothing sparse",
                "三角形的索引必须有 bufferView，且不得有 sparse"
            );
            return Err(soup.damaged(place, trouble));
        };
        let elements = self.elements(
            view,
            accessor.byte_offset,
            component.bytes(),
            accessor.count,
            &place,
            soup,
        )?;
        let mut indices = Vec::with_capacity(elements.count);
        for entry in 0..elements.count {
            match component.index(elements.get(entry)) {
                Some(index) if usize::try_from(index).is_ok_and(|index| index < points) => {
                    indices.push(index)
                }
                index => {
                    let index = index.unwrap_or_default();
                    let trouble = text!(
                        "its element {entry} names point {index}; there are {points}",
                        "它的元素 {entry} 引用点 {index}；只有 {points} 个点"
                    );
                    return Err(soup.damaged(place, trouble));
                }
            }
        }
        Ok(indices)
    }

    /// The accessor of this number, when its elements are what they must be.
    fn accessor(
        &self,
        number: usize,
        shape: &str,
        soup: &Soup<'_>,
    ) -> Result<&Accessor, MeshError> {
        let all = &self.document.accessors.0;
        let place = FilePosition::Element("accessors", number);
        let accessor = all.get(number).ok_or_else(|| {
            soup.damaged(
                place.clone(),
                text!(
                    "it is named, but there are {} accessors",
                    "它被引用，但只有 {} 个 accessor",
                    all.len()
                ),
            )
        })?;
        if accessor.shape != shape {
            let trouble = text!(
                "its type is {}; here it must be {shape}",
                "它的 type 为 {}；这里必须是 {shape}",
                excerpt(accessor.shape.as_bytes())
            );
            return Err(soup.damaged(place, trouble));
        }
        if accessor.count > 3 * MAX_TRIANGLES {
            let trouble = text!(
                "its count is {}; allowed are at most {}",
                "它的 count 为 {}；最多允许 {}",
                accessor.count,
                3 * MAX_TRIANGLES
            );
            return Err(soup.damaged(place, trouble));
        }
        Ok(accessor)
    }

    /// The bytes of `count` elements of `size` bytes, after it is certain that they are there.
    fn elements(
        &self,
        view: usize,
        offset: usize,
        size: usize,
        count: usize,
        place: &FilePosition,
        soup: &Soup<'_>,
    ) -> Result<Elements<'_>, MeshError> {
        let views = &self.document.buffer_views.0;
        let entry = views.get(view).ok_or_else(|| {
            let trouble = text!(
                "it names bufferViews[{view}]; there are {}",
                "它引用 bufferViews[{view}]；只有 {} 个",
                views.len()
            );
            soup.damaged(place.clone(), trouble)
        })?;
        let view_place = FilePosition::Element("bufferViews", view);
        let buffer = self.buffers.get(entry.buffer).ok_or_else(|| {
            let trouble = text!(
                "it names buffers[{}]; there are {}",
                "它引用 buffers[{}]；只有 {} 个",
                entry.buffer,
                self.buffers.len()
            );
            soup.damaged(view_place.clone(), trouble)
        })?;
        let end = entry.byte_offset.checked_add(entry.byte_length);
        let bytes = end
            .and_then(|end| buffer.get(entry.byte_offset..end))
            .ok_or_else(|| {
                let trouble = text!(
                    "{} bytes from byte {} are announced; buffers[{}] has {}",
                    "声明从字节 {1} 起有 {0} 字节；buffers[{2}] 有 {3} 字节",
                    entry.byte_length,
                    entry.byte_offset,
                    entry.buffer,
                    buffer.len()
                );
                soup.damaged(view_place.clone(), trouble)
            })?;
        let stride = entry.byte_stride.unwrap_or(size);
        if stride < size || stride > 252 {
            let trouble = text!(
                "its byteStride is {stride}; allowed here are {size} to 252",
                "它的 byteStride 为 {stride}；这里允许 {size} 至 252"
            );
            return Err(soup.damaged(view_place, trouble));
        }
        let needed = match count {
            0 => Some(0),
            _ => (count - 1)
                .checked_mul(stride)
                .and_then(|before| before.checked_add(size)),
        };
        let there = bytes.get(offset..).unwrap_or_default();
        if needed.is_none_or(|needed| needed > there.len()) {
            let trouble = text!(
                "{count} elements of {size} bytes, {stride} apart, from byte {offset} are beyond the {} bytes of \
                 bufferViews[{view}]",
                "{count} 个元素，每个 {size} 字节，间隔 {stride} 字节，从字节 {offset} 起，超出 bufferViews[{view}] 的 {} 字节",
                bytes.len()
            );
            return Err(soup.damaged(place.clone(), trouble));
        }
        Ok(Elements {
            bytes: there,
            stride,
            size,
            count,
        })
    }
}

fn component(code: u64, place: &FilePosition, soup: &Soup<'_>) -> Result<Component, MeshError> {
    Component::of_code(code).ok_or_else(|| {
        let trouble = text!(
            "its componentType is {code}; allowed are 5120 to 5123, 5125 and 5126",
            "它的 componentType 为 {code}；允许 5120 至 5123、5125 和 5126"
        );
        soup.damaged(place.clone(), trouble)
    })
}

fn component_of_indices(
    code: u64,
    place: &FilePosition,
    soup: &Soup<'_>,
) -> Result<Component, MeshError> {
    match Component::of_code(code) {
        Some(component @ (Component::U8 | Component::U16 | Component::U32)) => Ok(component),
        _ => {
            let trouble = text!(
                "its componentType is {code}; allowed for indices are 5121, 5123 and 5125",
                "它的 componentType 为 {code}；索引允许 5121、5123 和 5125"
            );
            Err(soup.damaged(place.clone(), trouble))
        }
    }
}
