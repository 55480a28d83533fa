//! Where recordings go, what they are called, and which of earlier runs may make room.

use std::path::{Path, PathBuf};

use recorder::Rotation;

use crate::config::ControllerConfig;
use crate::options::RecordTarget;

/// How the names of recordings begin, with a 0 for every digit.
const OWN_NAME_TIME: &str = "0000-00-00T00-00-00";

/// Where the recording goes; a new file is named after the time of day, so that recordings sort by age.
pub(crate) fn path(target: &RecordTarget) -> Option<PathBuf> {
    match target {
        RecordTarget::Off => None,
        RecordTarget::File(path) => Some(path.clone()),
        RecordTarget::NewFileIn(folder) => {
            let name = chrono::Utc::now().format("%Y-%m-%dT%H-%M-%S");
            // Two servers started within a second must not write into one file.
            Some(folder.join(format!("{name}-{}.mcap", std::process::id())))
        }
    }
}

/// How the recording is kept in bounds. In the folder for recordings, files of earlier runs count too.
pub(crate) fn rotation(config: &ControllerConfig) -> Rotation {
    let earlier = match (&config.record, config.record_budget) {
        (RecordTarget::NewFileIn(folder), Some(_)) => recordings_in(folder),
        _ => Vec::new(),
    };
    Rotation {
        end: config.record_rotate.map(|rotate| rotate.0),
        budget: config.record_budget.map(|budget| budget.0),
        earlier,
    }
}

/// What earlier servers have left in a folder, oldest first. Only names that a server gives count: what somebody put
/// there by hand is never removed.
fn recordings_in(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else {
        return Vec::new();
    };
    let mut found: Vec<PathBuf> = entries
        .flatten()
        .map(|entry| entry.path())
        .filter(|path| is_own_name(path))
        .collect();
    found.sort();
    found
}

/// `2026-01-31T08-15-00-4711.mcap`, with or without the number of a part.
fn is_own_name(path: &Path) -> bool {
    let name = path.file_name().and_then(|name| name.to_str());
    let Some(stem) = name.and_then(|name| name.strip_suffix(".mcap")) else {
        return false;
    };
    let Some((time, number)) = stem.split_at_checked(OWN_NAME_TIME.len()) else {
        return false;
    };
    let like_a_time = time
        .bytes()
        .zip(OWN_NAME_TIME.bytes())
        .all(|(c, like)| match like {
            b'0' => c.is_ascii_digit(),
            other => c == other,
        });
    like_a_time
        && number.starts_with('-')
        && number.bytes().all(|c| c == b'-' || c.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_names_that_a_server_gives_are_its_own() {
        for (name, own) in [
            ("2026-01-31T08-15-00-4711.mcap", true),
            ("2026-01-31T08-15-00-4711-0002.mcap", true),
            ("2026-01-31T08-15-00.mcap", false),
            ("2026-01-31T08-15-00-keep.mcap", false),
            ("2026-01-31 08-15-00-1.mcap", false),
            ("the one with the crash.mcap", false),
            ("2026-01-31T08-15-00-4711.txt", false),
        ] {
            assert_eq!(is_own_name(Path::new(name)), own, "{name}");
        }
    }
}
