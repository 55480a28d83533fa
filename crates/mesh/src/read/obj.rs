//! OBJ of Wavefront: points and faces. What has no surface (normals, textures, materials, groups) is passed over.

use messages::text;
use nalgebra::Vector3;

use super::Soup;
use crate::error::{FilePosition, MeshError, excerpt};

/// The most corners of one face; they are cut as a fan from the first.
const FACE_CORNERS_MAX: usize = 1000;

pub(super) fn read(bytes: &[u8], soup: &mut Soup<'_>) -> Result<(), MeshError> {
    let mut lines = bytes.split(|&byte| byte == b'\n').enumerate();
    while let Some((index, line)) = lines.next() {
        let place = FilePosition::Line(index + 1);
        let mut line = without_comment(line);
        let mut longer = Vec::new();
        // A backslash continues a line.
        while let Some(start) = line.strip_suffix(b"\\") {
            longer.extend_from_slice(start);
            longer.push(b' ');
            match lines.next() {
                Some((_, next)) => line = without_comment(next),
                None => line = b"",
            }
        }
        if longer.is_empty() {
            read_line(line, &place, soup)?;
        } else {
            longer.extend_from_slice(line);
            read_line(&longer, &place, soup)?;
        }
    }
    Ok(())
}

fn without_comment(line: &[u8]) -> &[u8] {
    let end = line.iter().position(|&byte| byte == b'#');
    line[..end.unwrap_or(line.len())].trim_ascii()
}

fn read_line(line: &[u8], place: &FilePosition, soup: &mut Soup<'_>) -> Result<(), MeshError> {
    let mut words = line
        .split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty());
    match words.next() {
        Some(b"v") => {
            let mut point = Vector3::zeros();
            for value in &mut point {
                let word = words.next().unwrap_or_default();
                *value = number(word).ok_or_else(|| {
                    let trouble = text!(
                        "{} is no finite number; a point v has three",
                        "{} 不是有限的数；点 v 有三个数",
                        excerpt(word)
                    );
                    soup.damaged(place.clone(), trouble)
                })?;
            }
            // A fourth number is a weight of curves, three more are a colour.
            soup.add_point(place, point)?;
            Ok(())
        }
        Some(b"f") => read_face(words, place, soup),
        Some(b"curv" | b"surf") => Err(soup.damaged(
            place.clone(),
            text!(
                "there is a curve or a curved surface; allowed are faces f of straight edges",
                "这里有曲线或曲面；只允许由直边围成的面 f"
            ),
        )),
        Some(b"l" | b"p" | b"vn" | b"vt" | b"vp" | b"g" | b"o" | b"s" | b"usemtl" | b"mtllib")
        | None => Ok(()),
        // The many words of rendering do not change where a surface is, but a text of another kind is no mesh.
        Some(word)
            if word
                .iter()
                .all(|byte| byte.is_ascii_alphanumeric() || *byte == b'_') =>
        {
            Ok(())
        }
        Some(word) => Err(soup.damaged(
            place.clone(),
            text!(
                "{} is no statement of OBJ",
                "{} 不是 OBJ 的语句",
                excerpt(word)
            ),
        )),
    }
}

fn read_face<'a>(
    words: impl Iterator<Item = &'a [u8]>,
    place: &FilePosition,
    soup: &mut Soup<'_>,
) -> Result<(), MeshError> {
    let mut first = None;
    let mut last = None;
    let mut count = 0;
    for word in words {
        let corner = corner(word, place, soup)?;
        count += 1;
        if count > FACE_CORNERS_MAX {
            let trouble = text!(
                "a face has more than {FACE_CORNERS_MAX} corners, the most that is allowed",
                "一个面的顶点超过 {FACE_CORNERS_MAX} 个，即允许的上限"
            );
            return Err(soup.damaged(place.clone(), trouble));
        }
        match (first, last) {
            (Some(first), Some(last)) => soup.add_triangle(place, [first, last, corner])?,
            (None, _) => {
                first = Some(corner);
                continue;
            }
            _ => {}
        }
        last = Some(corner);
    }
    if count < 3 {
        let trouble = text!(
            "a face has {count} corners; allowed are 3 to {FACE_CORNERS_MAX}",
            "一个面有 {count} 个顶点；允许 3 至 {FACE_CORNERS_MAX} 个"
        );
        return Err(soup.damaged(place.clone(), trouble));
    }
    Ok(())
}

/// The index of a corner such as `7`, `7/1`, `7//3`, or `-1` for the last point so far.
fn corner(word: &[u8], place: &FilePosition, soup: &Soup<'_>) -> Result<u32, MeshError> {
    let name = word.split(|&byte| byte == b'/').next().unwrap_or_default();
    let count = soup.points.len();
    let number = std::str::from_utf8(name)
        .ok()
        .and_then(|text| text.parse::<i64>().ok());
    let index = number.and_then(|number| {
        let from_start = usize::try_from(number)
            .ok()
            .and_then(|number| number.checked_sub(1));
        let from_end = usize::try_from(number.unsigned_abs())
            .ok()
            .and_then(|back| count.checked_sub(back));
        let index = if number < 0 { from_end } else { from_start };
        index.filter(|&index| index < count)
    });
    index.and_then(|index| u32::try_from(index).ok()).ok_or_else(|| {
        let trouble = text!(
"a face names point {}; before this line there are {count} points, from 1 or, backwards, from -1",
"一个面引用点 {}；此行之前有 {count} 个点，从 1 起编号，倒数则从 -1 起",
            excerpt(word)
        );
        soup.damaged(place.clone(), trouble)
    })
}

/// A finite number of at most 60 characters.
pub(super) fn number(word: &[u8]) -> Option<f64> {
    if word.len() > 60 {
        return None;
    }
    let value: f64 = std::str::from_utf8(word).ok()?.parse().ok()?;
    value.is_finite().then_some(value)
}
