//! The file that says the server is ready: process id and ports as JSON, there all at once or not at all. And files
//! that others replace in the same way.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;

/// Writes `{"pid":…, "ports":{"primary":30001, …}}` to `path`; a service that is not started has the port `null`. The
/// file is written beside its place and moved there, so that nobody reads half of it.
pub fn write(path: &Path, pid: u32, ports: &[(&str, Option<u16>)]) -> io::Result<()> {
    let ports: serde_json::Map<_, _> = ports
        .iter()
        .map(|(name, port)| ((*name).to_owned(), (*port).into()))
        .collect();
    let text = serde_json::json!({ "pid": pid, "ports": ports }).to_string();
    replace(path, &format!("{text}\n"))
}

/// Writes a file that is there whole or as it was. What is no file, as `/dev/stdout`, is written to.
///
/// # Errors
/// What the operating system says.
pub fn replace(path: &Path, text: &str) -> io::Result<()> {
    if fs::metadata(path).is_ok_and(|found| !found.is_file()) {
        return fs::write(path, text);
    }
    // The process id keeps two processes with one name for the file from writing into the same temporary file.
    let mut beside = path.as_os_str().to_owned();
    beside.push(format!(".{}.tmp", std::process::id()));
    let written = write_all(Path::new(&beside), text).and_then(|()| fs::rename(&beside, path));
    if written.is_err() {
        // What failed is reported; that the rest of it cannot be removed either adds nothing.
        let _ = fs::remove_file(&beside);
    }
    written
}

/// Removes what an earlier server has left, or this one wrote. That nothing is there is fine.
///
/// # Errors
/// What the operating system says.
pub fn remove(path: &Path) -> io::Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => Ok(()),
    }
}

fn write_all(path: &Path, text: &str) -> io::Result<()> {
    let mut file = File::create(path)?;
    file.write_all(text.as_bytes())?;
    file.sync_all()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_replaces_what_was_there_and_leaves_nothing_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ready.json");
        fs::write(&path, "old").unwrap();
        write(&path, 42, &[("primary", Some(30001)), ("rtsi", None)]).unwrap();
        let text = fs::read_to_string(&path).unwrap();
        assert_eq!(
            text,
            "{\"pid\":42,\"ports\":{\"primary\":30001,\"rtsi\":null}}\n"
        );
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_an_earlier_server_left_is_removed_and_nothing_is_no_error() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ready.json");
        fs::write(&path, "old").unwrap();
        remove(&path).unwrap();
        remove(&path).unwrap();
        assert!(remove(folder.path()).is_err());
    }

    #[test]
    fn a_place_that_cannot_be_written_is_an_error_and_stays_clean() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("folder");
        fs::create_dir(&taken).unwrap();
        assert!(write(&taken, 1, &[]).is_err());
        assert!(write(&folder.path().join("missing/ready.json"), 1, &[]).is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
