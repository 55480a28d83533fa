//! A recording in parts: when the next file begins, what it is called, which old ones have to go.
//!
//! Every part is a whole recording with schemas, set-up and the arm. Knows files and their sizes, nothing of their
//! content.

use std::collections::VecDeque;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

/// When the next part begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RotationTrigger {
    /// The file has this many bytes; twice as many as the files of the cell have, where that is more.
    Bytes(u64),
    /// This much simulated time has passed, s.
    Secs(f64),
}

/// How a recording is kept in bounds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rotation {
    /// When the next part begins; `None`: never.
    pub end: Option<RotationTrigger>,
    /// Bytes that the files together may have; the oldest are removed. The part being written always stays.
    pub budget: Option<u64>,
    /// Finished recordings of earlier runs that count and may be removed, oldest first.
    pub earlier: Vec<PathBuf>,
}

/// The files of a recording.
#[derive(Debug)]
pub(crate) struct RecordingParts {
    rotation: Rotation,
    first: PathBuf,
    /// Number of the part being written, from 1.
    number: u32,
    /// Finished files with their sizes, oldest first.
    finished: VecDeque<(PathBuf, u64)>,
    /// Simulated time at which the part began, s.
    since: f64,
    /// Bytes that every part repeats: files of the cell.
    repeated: u64,
    /// How many times as long as wanted this part may become.
    size_multiplier: u32,
}

impl RecordingParts {
    /// `repeated` is what every part begins with, bytes.
    pub(crate) fn new(first: PathBuf, rotation: Rotation, repeated: u64) -> Self {
        let finished = rotation.earlier.iter();
        let finished = finished
            .filter(|path| **path != first)
            .filter_map(|path| Some((path.clone(), fs::metadata(path).ok()?.len())))
            .collect();
        Self {
            rotation,
            first,
            number: 1,
            finished,
            since: 0.0,
            repeated,
            size_multiplier: 1,
        }
    }

    /// Whether the part being written, with this many bytes at this simulated time, is long enough.
    pub(crate) fn is_due(&self, bytes: u64, time: f64) -> bool {
        match self.rotation.end {
            Some(RotationTrigger::Bytes(limit)) => {
                // Half of a part at least is new: where files alone reach the limit, every look would begin a part.
                let limit = limit.max(self.repeated.saturating_mul(2));
                bytes >= limit.saturating_mul(u64::from(self.size_multiplier))
            }
            Some(RotationTrigger::Secs(limit)) => {
                time - self.since >= limit * f64::from(self.size_multiplier)
            }
            None => false,
        }
    }

    /// Makes the file of the next part.
    pub(crate) fn create_next(&self) -> io::Result<(File, u32)> {
        let number = self.number + 1;
        Ok((File::create(part_path(&self.first, number))?, number))
    }

    /// The next part cannot begin: this one goes on and may become twice as long before it is tried again.
    pub(crate) fn postpone(&mut self) {
        self.size_multiplier = self.size_multiplier.saturating_mul(2);
    }

    /// The part before is complete with `bytes`, the next one has begun at `time`.
    pub(crate) fn finish_part(&mut self, bytes: u64, time: f64) {
        self.finished.push_back((self.path(), bytes));
        self.number += 1;
        self.since = time;
        self.size_multiplier = 1;
    }

    /// The file being written.
    pub(crate) fn path(&self) -> PathBuf {
        part_path(&self.first, self.number)
    }

    /// Removes the oldest files until the finished ones and the `current` bytes are within the budget. Returns what
    /// could not be removed, for the log.
    pub(crate) fn enforce_budget(&mut self, current: u64) -> Vec<(PathBuf, io::Error)> {
        let mut failed = Vec::new();
        let Some(budget) = self.rotation.budget else {
            return failed;
        };
        let mut total = current + self.finished.iter().map(|(_, bytes)| bytes).sum::<u64>();
        while total > budget
            && let Some((path, bytes)) = self.finished.pop_front()
        {
            total -= bytes;
            match fs::remove_file(&path) {
                Ok(()) => {}
                // Somebody was faster, which is as good.
                Err(error) if error.kind() == io::ErrorKind::NotFound => {}
                Err(error) => failed.push((path, error)),
            }
        }
        failed
    }
}

/// `run.mcap`, `run-0002.mcap`, `run-0003.mcap`: sorted by name they are sorted by age.
fn part_path(first: &Path, number: u32) -> PathBuf {
    if number == 1 {
        return first.to_owned();
    }
    let mut name = first.file_stem().unwrap_or_default().to_owned();
    name.push(format!("-{number:04}"));
    if let Some(extension) = first.extension() {
        name.push(".");
        name.push(extension);
    }
    first.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_of_a_part_is_new_where_files_alone_reach_the_limit() {
        let parts = |repeated| {
            let end = Some(RotationTrigger::Bytes(1000));
            let rotation = Rotation {
                end,
                ..Rotation::default()
            };
            RecordingParts::new("run.mcap".into(), rotation, repeated)
        };
        for (repeated, due) in [(0, 1000), (500, 1000), (501, 1002), (5000, 10_000)] {
            let mut parts = parts(repeated);
            assert!(
                !parts.is_due(due - 1, 0.0) && parts.is_due(due, 0.0),
                "{repeated}"
            );
            parts.postpone();
            assert!(!parts.is_due(2 * due - 1, 0.0) && parts.is_due(2 * due, 0.0));
        }
        assert!(!parts(u64::MAX).is_due(u64::MAX - 1, 0.0));
    }

    #[test]
    fn parts_are_numbered_behind_the_name() {
        for (first, second) in [
            ("a/run.mcap", "a/run-0002.mcap"),
            ("run", "run-0002"),
            ("/x/2026-01-01T00.5.mcap", "/x/2026-01-01T00.5-0002.mcap"),
        ] {
            assert_eq!(part_path(Path::new(first), 2), Path::new(second));
            assert_eq!(part_path(Path::new(first), 1), Path::new(first));
        }
    }
}
