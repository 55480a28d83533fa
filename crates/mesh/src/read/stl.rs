//! STL, as text and as records of 50 bytes. Normals are not read: the order of the corners says what is outside.

use messages::{Text, text};
use nalgebra::Vector3;

use super::Soup;
use crate::MAX_TRIANGLES;
use crate::error::{FilePosition, MeshError, excerpt};

/// A header of 80 bytes and the number of triangles.
const HEAD_BYTES: usize = 84;
/// Normal, three corners, and two bytes that mean nothing.
const RECORD_BYTES: usize = 50;

/// Reads either form. Headers of binary files may begin with `solid` too, so the length decides first.
pub(super) fn read(bytes: &[u8], soup: &mut Soup<'_>) -> Result<(), MeshError> {
    let claimed = claimed_triangles(bytes);
    let records = bytes.len().saturating_sub(HEAD_BYTES);
    let whole = claimed.is_some_and(|count| count.checked_mul(RECORD_BYTES) == Some(records));
    if !whole && is_text(bytes) {
        return read_text(bytes, soup);
    }
    let Some(claimed) = claimed else {
        let trouble = text!(
            "the file has {} bytes; STL is either text that begins with solid, or has at least {HEAD_BYTES} bytes",
            "文件有 {} 字节；STL 要么是以 solid 开头的文本，要么至少有 {HEAD_BYTES} 字节",
            bytes.len()
        );
        return Err(soup.damaged(FilePosition::Whole, trouble));
    };
    if claimed > MAX_TRIANGLES {
        return Err(MeshError::TooManyTriangles {
            file: soup.file.to_owned(),
            place: FilePosition::Byte(HEAD_BYTES - 4),
        });
    }
    if !whole {
        let trouble = text!(
            "{claimed} triangles are announced, which are {} bytes; {records} bytes follow",
            "声明有 {claimed} 个三角形，即 {} 字节；其后有 {records} 字节",
            claimed * RECORD_BYTES
        );
        return Err(soup.damaged(FilePosition::Byte(HEAD_BYTES - 4), trouble));
    }
    for (number, record) in bytes[HEAD_BYTES..].chunks_exact(RECORD_BYTES).enumerate() {
        let place = FilePosition::Byte(HEAD_BYTES + number * RECORD_BYTES);
        let mut corners = [0; 3];
        for (corner, values) in corners.iter_mut().zip(record[12..48].chunks_exact(12)) {
            let point = Vector3::from_fn(|row, _| float_at(values, row * 4));
            *corner = soup.add_point(&place, point)?;
        }
        soup.add_triangle(&place, corners)?;
    }
    Ok(())
}

/// How many triangles a binary file says that it has.
fn claimed_triangles(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(HEAD_BYTES - 4..HEAD_BYTES)?;
    let count = u32::from_le_bytes(count.try_into().ok()?);
    usize::try_from(count).ok()
}

/// The number of four bytes; 0 where there are none.
fn float_at(bytes: &[u8], at: usize) -> f64 {
    let four = bytes.get(at..at + 4).and_then(|four| four.try_into().ok());
    f64::from(f32::from_le_bytes(four.unwrap_or_default()))
}

fn is_text(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    let named = start
        .get(..5)
        .is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    named && !bytes[..bytes.len().min(512)].contains(&0)
}

/// Words with their lines.
struct Words<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> Words<'a> {
    /// The next word; empty at the end.
    fn next(&mut self) -> &'a [u8] {
        while let Some((&byte, rest)) = self.rest.split_first() {
            if !byte.is_ascii_whitespace() {
                break;
            }
            self.line += usize::from(byte == b'\n');
            self.rest = rest;
        }
        let end = self.rest.iter().position(u8::is_ascii_whitespace);
        let (word, rest) = self.rest.split_at(end.unwrap_or(self.rest.len()));
        self.rest = rest;
        word
    }

    fn skip_line(&mut self) {
        let end = self.rest.iter().position(|&byte| byte == b'\n');
        self.rest = &self.rest[end.unwrap_or(self.rest.len())..];
    }
}

fn read_text(bytes: &[u8], soup: &mut Soup<'_>) -> Result<(), MeshError> {
    let mut words = Words {
        rest: bytes,
        line: 1,
    };
    // A file may have several solids, one after the other.
    loop {
        let word = words.next();
        if word.is_empty() {
            return Ok(());
        }
        check(soup, &words, word, "solid")?;
        words.skip_line();
        read_facets(&mut words, soup)?;
        words.skip_line();
    }
}

fn read_facets(words: &mut Words<'_>, soup: &mut Soup<'_>) -> Result<(), MeshError> {
    loop {
        let word = words.next();
        if word.eq_ignore_ascii_case(b"endsolid") {
            return Ok(());
        }
        check(soup, words, word, "facet")?;
        expect(soup, words, "normal")?;
        for _ in 0..3 {
            // Some programs write `nan` as the normal of a narrow triangle; nothing is made of it.
            _ = words.next();
        }
        expect(soup, words, "outer")?;
        expect(soup, words, "loop")?;
        let mut corners = [0; 3];
        for corner in &mut corners {
            expect(soup, words, "vertex")?;
            let mut point = Vector3::zeros();
            for value in &mut point {
                let word = words.next();
                *value = super::obj::number(word).ok_or_else(|| {
                    let trouble = text!(
                        "{} is no finite number; a vertex has three",
                        "{} 不是有限的数；vertex 有三个数",
                        excerpt(word)
                    );
                    soup.damaged(FilePosition::Line(words.line), trouble)
                })?;
            }
            *corner = soup.add_point(&FilePosition::Line(words.line), point)?;
        }
        expect(soup, words, "endloop")?;
        expect(soup, words, "endfacet")?;
        soup.add_triangle(&FilePosition::Line(words.line), corners)?;
    }
}

fn expect(soup: &Soup<'_>, words: &mut Words<'_>, wanted: &str) -> Result<(), MeshError> {
    let word = words.next();
    check(soup, words, word, wanted)
}

/// An error unless this word is the one that must stand here.
fn check(soup: &Soup<'_>, words: &Words<'_>, word: &[u8], wanted: &str) -> Result<(), MeshError> {
    if word.eq_ignore_ascii_case(wanted.as_bytes()) {
        return Ok(());
    }
    let found = if word.is_empty() {
        text!("the end of the file", "文件末尾")
    } else {
        Text::verbatim(excerpt(word))
    };
    Err(soup.damaged(
        FilePosition::Line(words.line),
        text!(
            "found {found} where {wanted} is needed",
            "此处应为 {wanted}，却是{found}"
        ),
    ))
}
