//! The log file of a robot: what its process says on standard error, bounded.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use tokio::io::{AsyncRead, AsyncReadExt};

/// The file begins anew at this size, bytes; the one before is kept beside it.
const BYTES_MAX: u64 = 16 << 20;
/// Read at once.
const CHUNK: usize = 16 << 10;

/// Copies what comes into a file until its end. What cannot be written is lost: a full disk is no reason to hold a
/// robot up.
pub(super) async fn copy_lines(mut said: impl AsyncRead + Unpin, path: PathBuf) {
    let mut file = open(&path);
    let mut chunk = vec![0; CHUNK];
    loop {
        let count = match said.read(&mut chunk).await {
            Ok(0) | Err(_) => return,
            Ok(count) => count,
        };
        let is_written = match &mut file {
            Ok((log, length)) => {
                *length += count as u64;
                log.write_all(&chunk[..count]).is_ok() && *length < BYTES_MAX
            }
            Err(_) => false,
        };
        if !is_written {
            if matches!(&file, Ok((_, length)) if *length >= BYTES_MAX) {
                // Where it cannot be moved it goes on growing, as far as there is room.
                let _ = fs::rename(&path, before(&path));
            }
            file = open(&path);
        }
    }
}

fn open(path: &Path) -> io::Result<(File, u64)> {
    let file = OpenOptions::new().create(true).append(true).open(path)?;
    let length = file.metadata()?.len();
    Ok((file, length))
}

/// The file that was written before.
fn before(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".1");
    name.into()
}

/// The end of a log file, at most so many bytes, from the beginning of a line.
pub(super) fn end_of(path: &Path, most: u64) -> io::Result<String> {
    let mut file = File::open(path)?;
    let length = file.metadata()?.len();
    let from = length.saturating_sub(most);
    file.seek(SeekFrom::Start(from))?;
    let mut text = Vec::new();
    file.take(most).read_to_end(&mut text)?;
    let text = String::from_utf8_lossy(&text).into_owned();
    Ok(match (from, text.split_once('\n')) {
        (1.., Some((_, whole))) => whole.to_owned(),
        _ => text,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn the_file_is_bounded_and_its_end_is_read_in_lines() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("robot.log");
        let line = format!("{}\n", "x".repeat(99));
        let text = line.repeat(usize::try_from(BYTES_MAX).unwrap() / 100 + 1000);
        copy_lines(text.as_bytes(), path.clone()).await;
        copy_lines(b"last line\n".as_slice(), path.clone()).await;
        let lengths = [&path, &before(&path)].map(|path| std::fs::metadata(path).unwrap().len());
        assert!(
            lengths[0] < 200_000 && lengths[1] <= BYTES_MAX + CHUNK as u64,
            "{lengths:?}"
        );
        let end = end_of(&path, 150).unwrap();
        assert_eq!(end, format!("{line}last line\n"));
        assert!(end_of(&folder.path().join("none"), 10).is_err());
    }
}
