//! Files that a cell file names, meshes above all, as attachments of a recording.
//!
//! A part of a recording has all of them before its first chunk, and its metadata names them, so that one that is lost
//! or damaged is noticed. Owns their names, kinds and bounds.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use mcap::McapError;
use mcap::records::{AttachmentHeader, Record, op};
use mcap::write::NoSeek;
use messages::Localized;
use thiserror::Error;

use crate::chunks::CHUNK_BYTES;
use crate::{json_values, records};

/// Largest file, bytes: what the reader of meshes takes.
pub const MAX_FILE_BYTES: usize = 64 << 20;
/// Bytes of all files of a cell together.
pub const MAX_FILES_BYTES: usize = 1 << 30;
/// Files of a cell.
pub const MAX_FILES: usize = 1024;
/// Bytes of the path by which a cell file names a file.
pub const MAX_PATH_BYTES: usize = 1024;
/// Attachments with this beginning of their name are files of the cell.
const FOLDER: &str = "cell/";
/// Largest record of such an attachment: content, path, and room for times, lengths, kind and checksum.
pub(crate) const MAX_RECORD_BYTES: usize = MAX_FILE_BYTES + MAX_PATH_BYTES + 1024;

/// Files by the path as the cell file names them.
pub type CellFiles = BTreeMap<String, Arc<[u8]>>;

/// A reason why files of a cell cannot stand in a recording.
#[derive(Clone, Debug, PartialEq, Eq, Error, Localized)]
#[non_exhaustive]
pub enum CellFileError {
    /// One is too large.
    #[error(
        "the file {path:?} of the cell has {bytes} bytes; a recording takes files of at most {MAX_FILE_BYTES}"
    )]
    #[zh("单元的文件 {path:?} 有 {bytes} 字节；一个记录接受的文件最大为 {MAX_FILE_BYTES} 字节")]
    Size {
        /// The file.
        path: String,
        /// Size of the file.
        bytes: usize,
    },
    /// All of them are too large.
    #[error(
        "the files of the cell have {bytes} bytes together; a recording takes at most {MAX_FILES_BYTES}"
    )]
    #[zh("单元的文件共有 {bytes} 字节；一个记录最多接受 {MAX_FILES_BYTES} 字节")]
    TotalSize {
        /// Size of all files.
        bytes: usize,
    },
    /// There are too many.
    #[error("the cell has {count} files; a recording takes at most {MAX_FILES}")]
    #[zh("单元有 {count} 个文件；一个记录最多接受 {MAX_FILES} 个")]
    Count {
        /// Number of files.
        count: usize,
    },
    /// A path cannot be a name.
    #[error(
        "the path of a file of the cell has {bytes} bytes; a recording takes paths of 1 to {MAX_PATH_BYTES}"
    )]
    #[zh("单元中一个文件的路径有 {bytes} 字节；一个记录接受 1 到 {MAX_PATH_BYTES} 字节的路径")]
    Path {
        /// Length of the path.
        bytes: usize,
    },
}

/// Looks whether a reader takes what would be written.
pub(crate) fn check(files: &CellFiles) -> Result<(), CellFileError> {
    if files.len() > MAX_FILES {
        let count = files.len();
        return Err(CellFileError::Count { count });
    }
    for (path, content) in files {
        if !is_path(path) {
            let bytes = path.len();
            return Err(CellFileError::Path { bytes });
        }
        if content.len() > MAX_FILE_BYTES {
            return Err(CellFileError::Size {
                path: path.clone(),
                bytes: content.len(),
            });
        }
    }
    // At most 1024 times 64 MiB.
    match total_bytes(files) {
        bytes if bytes > MAX_FILES_BYTES => Err(CellFileError::TotalSize { bytes }),
        _ => Ok(()),
    }
}

/// Bytes of all files together.
pub(crate) fn total_bytes(files: &CellFiles) -> usize {
    files
        .values()
        .fold(0, |sum, content| sum.saturating_add(content.len()))
}

/// Writes all files. `time_ns` is their time stamp: the moment from which the recording counts, so that recordings of
/// equal runs are equal.
pub(crate) fn write<W: Write>(
    mcap: &mut mcap::Writer<NoSeek<W>>,
    files: &CellFiles,
    time_ns: u64,
) -> Result<(), McapError> {
    for (path, content) in files {
        let header = AttachmentHeader {
            log_time: time_ns,
            create_time: time_ns,
            name: format!("{FOLDER}{path}"),
            media_type: media_type(path).to_owned(),
        };
        mcap.start_attachment(content.len() as u64, header)?;
        // In pieces, so that a slow disk is seen to take something.
        for piece in content.chunks(CHUNK_BYTES) {
            mcap.put_attachment_bytes(piece)?;
        }
        mcap.finish_attachment()?;
    }
    Ok(())
}

/// Kind of a file by the end of its name.
fn media_type(path: &str) -> &'static str {
    let extension = Path::new(path).extension().and_then(|end| end.to_str());
    match extension.unwrap_or_default().to_ascii_lowercase().as_str() {
        "stl" => "model/stl",
        "obj" => "model/obj",
        "gltf" => "model/gltf+json",
        "glb" => "model/gltf-binary",
        _ => "application/octet-stream",
    }
}

/// The paths as text of the metadata: a list in JSON, which has room for any path.
pub(crate) fn paths_to_text(files: &CellFiles) -> String {
    files
        .keys()
        .map(String::as_str)
        .collect::<serde_json::Value>()
        .to_string()
}

/// The paths that a text of the metadata lists; `None` when it is no such list.
pub(crate) fn paths_of_text(text: &str) -> Option<BTreeSet<String>> {
    // A list of very many is not read at all.
    json_values::check_value_count(1 + MAX_FILES, text.as_bytes()).ok()?;
    let paths: BTreeSet<String> = serde_json::from_str(text).ok()?;
    (paths.len() <= MAX_FILES && paths.iter().all(|path| is_path(path))).then_some(paths)
}

fn is_path(path: &str) -> bool {
    (1..=MAX_PATH_BYTES).contains(&path.len())
}

/// Files of a cell as a reader meets them. Room is taken for what is there, within the bounds.
#[derive(Default)]
pub(crate) struct CellFileCollector {
    files: CellFiles,
    bytes: usize,
}

impl CellFileCollector {
    /// Takes the content of an attachment. One that is damaged, beyond a bound, or no file of a cell is left out: what
    /// the metadata names and is not here is missed in the end.
    pub(crate) fn take(&mut self, record: &[u8]) {
        let Ok(Record::Attachment {
            header,
            data,
            crc: _,
        }) = records::parse(op::ATTACHMENT, record)
        else {
            return;
        };
        let Some(path) = header.name.strip_prefix(FOLDER) else {
            return;
        };
        let bytes = self.bytes.saturating_add(data.len());
        let is_within_bounds = is_path(path)
            && data.len() <= MAX_FILE_BYTES
            && bytes <= MAX_FILES_BYTES
            && self.files.len() < MAX_FILES;
        if is_within_bounds && !self.files.contains_key(path) {
            self.bytes = bytes;
            self.files.insert(path.to_owned(), Arc::from(&*data));
        }
    }

    /// The files of these paths, and the paths without a file.
    pub(crate) fn into_files(mut self, paths: BTreeSet<String>) -> (CellFiles, Vec<String>) {
        let (mut files, mut missing) = (CellFiles::new(), Vec::new());
        for path in paths {
            match self.files.remove_entry(&path) {
                Some((path, content)) => {
                    files.insert(path, content);
                }
                None => missing.push(path),
            }
        }
        (files, missing)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn files(sizes: impl IntoIterator<Item = (String, usize)>) -> CellFiles {
        // One block of zeros stands for all, so that a test of large files needs no memory for each.
        let sizes: Vec<_> = sizes.into_iter().collect();
        let mut blocks: BTreeMap<usize, Arc<[u8]>> = BTreeMap::new();
        let named = sizes.into_iter().map(|(path, size)| {
            let block = blocks.entry(size).or_insert_with(|| vec![0; size].into());
            (path, Arc::clone(block))
        });
        named.collect()
    }

    #[test]
    fn what_is_beyond_a_bound_is_refused_with_a_sentence_that_names_it() {
        let refused = |files: CellFiles| check(&files).unwrap_err().to_string();
        assert_eq!(
            refused(files([("big.stl".to_owned(), MAX_FILE_BYTES + 1)])),
            "the file \"big.stl\" of the cell has 67108865 bytes; a recording takes files of at most 67108864"
        );
        assert_eq!(
            refused(files((0..17).map(|n| (format!("{n}.stl"), MAX_FILE_BYTES)))),
            "the files of the cell have 1140850688 bytes together; a recording takes at most 1073741824"
        );
        assert_eq!(
            refused(files((0..1025).map(|n| (format!("{n}.stl"), 1)))),
            "the cell has 1025 files; a recording takes at most 1024"
        );
        assert_eq!(
            refused(files([(String::new(), 1)])),
            "the path of a file of the cell has 0 bytes; a recording takes paths of 1 to 1024"
        );
        let within = (0..16).map(|n| (format!("{n}.stl"), MAX_FILE_BYTES));
        assert_eq!(check(&files(within)), Ok(()));
        assert_eq!(check(&files([("a".repeat(1024), 0)])), Ok(()));
        assert!(check(&files([("a".repeat(1025), 0)])).is_err());
    }

    #[test]
    fn paths_come_back_whatever_they_are() {
        let paths = [
            "a,b.stl",
            "\"quoted\".obj",
            "机.glb",
            "../up\\down\n.stl",
            "/abs",
        ];
        let files = files(paths.map(|path| (path.to_owned(), 1)));
        let back = paths_of_text(&paths_to_text(&files)).unwrap();
        assert!(back.iter().eq(files.keys()));
        for wrong in ["", "3", "{}", "[3]", "[\"\"]", "[\"a\""] {
            assert_eq!(paths_of_text(wrong), None, "{wrong}");
        }
        let many: Vec<String> = (0..=MAX_FILES).map(|n| n.to_string()).collect();
        assert_eq!(paths_of_text(&serde_json::to_string(&many).unwrap()), None);
    }

    #[test]
    fn kinds_follow_the_end_of_the_name() {
        for (path, kind) in [
            ("a/b.STL", "model/stl"),
            ("b.obj", "model/obj"),
            ("b.gltf", "model/gltf+json"),
            ("b.glb", "model/gltf-binary"),
            ("b.bin", "application/octet-stream"),
            ("stl", "application/octet-stream"),
        ] {
            assert_eq!(media_type(path), kind, "{path}");
        }
    }
}
