//! The bytes of a glTF file: embedded as base64, in the second chunk of a GLB, or in files beside it.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use messages::text;

use super::document::Buffer;
use crate::MAX_FILE_BYTES;
use crate::error::{FilePosition, MeshError, excerpt};
use crate::files::MeshFiles;
use crate::read::Soup;

/// The bytes of all buffers, together at most [`MAX_FILE_BYTES`].
pub(super) fn load(
    entries: &[Buffer],
    chunk: Option<&[u8]>,
    soup: &Soup<'_>,
    files: &mut dyn MeshFiles,
) -> Result<Vec<Vec<u8>>, MeshError> {
    let mut left = MAX_FILE_BYTES;
    let mut loaded = Vec::new();
    for (number, entry) in entries.iter().enumerate() {
        let place = FilePosition::Element("buffers", number);
        let mut bytes = match (&entry.uri, chunk) {
            (Some(uri), _) => by_uri(uri, left, &place, soup, files)?,
            (None, Some(chunk)) if number == 0 => chunk.to_vec(),
            (None, _) => {
                let trouble = text!(
                    "it has no uri; only the first buffer of a GLB file with a binary chunk may be without",
                    "它没有 uri；只有带二进制数据块的 GLB 文件的第一个缓冲区可以没有"
                );
                return Err(soup.damaged(place, trouble));
            }
        };
        if bytes.len() < entry.byte_length {
            let trouble = text!(
                "{} bytes are announced, there are {}",
                "声明有 {} 字节，实际有 {} 字节",
                entry.byte_length,
                bytes.len()
            );
            return Err(soup.damaged(place, trouble));
        }
        bytes.truncate(entry.byte_length);
        left = left.saturating_sub(bytes.len() as u64);
        loaded.push(bytes);
    }
    Ok(loaded)
}

fn by_uri(
    uri: &str,
    most: u64,
    place: &FilePosition,
    soup: &Soup<'_>,
    files: &mut dyn MeshFiles,
) -> Result<Vec<u8>, MeshError> {
    if let Some(data) = uri.strip_prefix("data:") {
        let Some((_, text)) = data.split_once(";base64,") else {
            let trouble = text!(
                "its data are {}; allowed are data:…;base64,… and names of files beside this one",
                "它的数据为 {}；允许 data:…;base64,… 以及旁边文件的名称",
                excerpt(uri.as_bytes())
            );
            return Err(soup.damaged(place.clone(), trouble));
        };
        let bytes = STANDARD.decode(text).map_err(|error| {
            soup.damaged(
                place.clone(),
                text!(
                    "its data are no base64: {error}",
                    "它的数据不是 base64：{error}"
                ),
            )
        })?;
        if bytes.len() as u64 > most {
            let trouble = text!(
                "the buffers are longer than {MAX_FILE_BYTES} bytes together, the most that is allowed",
                "各缓冲区合计超过 {MAX_FILE_BYTES} 字节，即允许的上限"
            );
            return Err(soup.damaged(place.clone(), trouble));
        }
        return Ok(bytes);
    }
    let outside = || {
        let trouble = text!(
            "its uri is {}; allowed are names of files in the folder of this one, without .., and data:…;base64,…",
            "它的 uri 为 {}；允许此文件所在文件夹中文件的名称（不含 ..），以及 data:…;base64,…",
            excerpt(uri.as_bytes())
        );
        soup.damaged(place.clone(), trouble)
    };
    let name = decode_percents(uri).ok_or_else(outside)?;
    let leaves = name.starts_with('/')
        || name.contains(['\\', ':', '\0'])
        || name.split('/').any(|part| part == "..");
    if leaves || name.is_empty() || name.len() > 1000 {
        return Err(outside());
    }
    let path = match soup.file.rsplit_once('/') {
        Some((folder, _)) => format!("{folder}/{name}"),
        None => name,
    };
    files
        .read(&path, most)
        .map_err(|source| MeshError::File { file: path, source })
}

/// A name whose bytes may be written as `%20`.
fn decode_percents(uri: &str) -> Option<String> {
    let mut bytes = Vec::new();
    let mut rest = uri.as_bytes();
    while let Some((&byte, after)) = rest.split_first() {
        rest = after;
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let digits = std::str::from_utf8(rest.get(..2)?).ok()?;
        if digits.starts_with('+') {
            return None;
        }
        bytes.push(u8::from_str_radix(digits, 16).ok()?);
        rest = &rest[2..];
    }
    String::from_utf8(bytes).ok()
}
