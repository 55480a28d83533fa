//! Whether recordings can be written: room, speed, and how long the disk keeps a writer waiting.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use controller::ControllerConfig;
use controller::options::RecordTarget;
use messages::text;
use platform::machine;

use super::HealthCheck;

/// What is written to try the disk: so many pieces of so many bytes.
const PIECES: usize = 32;
const PIECE_BYTES: usize = 1 << 20;
/// What a recording takes while the arm moves, bytes a cycle (docs/BENCHMARKS.md).
const CYCLE_BYTES: f64 = 800.0;
/// The disk should do so many times what a recording takes: others write to it, too.
const MARGIN: f64 = 10.0;
/// A recording of so many hours should have room.
const HOURS: f64 = 24.0;

/// Looks where recordings would go.
pub(super) fn look(robot: &ControllerConfig) -> Vec<HealthCheck> {
    let folder = match &robot.record {
        RecordTarget::Off => {
            return vec![HealthCheck::good(
                text!("recording", "记录"),
                text!("off", "关闭"),
            )];
        }
        RecordTarget::NewFileIn(folder) => folder.clone(),
        RecordTarget::File(file) => match file.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder.to_owned(),
            _ => PathBuf::from("."),
        },
    };
    let there = nearest_that_is_there(&folder);
    let need = CYCLE_BYTES / robot.step.as_secs();
    match tried(&there) {
        Ok(speed) => vec![judged_speed(&folder, speed, need), room(&there, need)],
        Err(error) => vec![HealthCheck::bad(
            text!("recording", "记录"),
            text!(
                "nothing can be written into {}: {error}",
                "无法写入 {}：{error}",
                there.display()
            ),
            text!(
                "choose another place with --record, or --record off",
                "用 --record 选择其他位置，或用 --record off"
            ),
        )],
    }
}

/// The folder itself, or what it would be made in.
fn nearest_that_is_there(folder: &Path) -> PathBuf {
    let mut there = folder;
    while !there.exists() {
        match there.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => there = parent,
            _ => return PathBuf::from("."),
        }
    }
    there.to_owned()
}

/// Bytes a second, and the longest wait for one piece.
struct Speed {
    bytes_per_second: f64,
    longest: Duration,
}

/// Writes a file that nobody else has and removes it.
fn tried(folder: &Path) -> io::Result<Speed> {
    let path = folder.join(format!(".eliteserver-doctor-{}", std::process::id()));
    let file = OpenOptions::new()
        .write(true)
        .create_new(true)
        .open(&path)?;
    let written = write(file);
    let removed = fs::remove_file(&path);
    written.and_then(|speed| removed.map(|()| speed))
}

fn write(mut file: File) -> io::Result<Speed> {
    // Not all the same, so that a file system that packs what it stores has work to do.
    let mut state = 1_u32;
    let piece: Vec<u8> = (0..PIECE_BYTES)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        })
        .collect();
    let began = Instant::now();
    let mut longest = Duration::ZERO;
    for _ in 0..PIECES {
        let before = Instant::now();
        file.write_all(&piece)?;
        file.sync_data()?;
        longest = longest.max(before.elapsed());
    }
    let bytes = (PIECES * PIECE_BYTES) as f64;
    Ok(Speed {
        bytes_per_second: bytes / began.elapsed().as_secs_f64().max(1e-9),
        longest,
    })
}

fn judged_speed(folder: &Path, speed: Speed, need: f64) -> HealthCheck {
    let found = text!(
        "{} takes {:.0} MB a second, one of them within {:.0} ms; a recording needs {:.2}",
        "{} 每秒写入 {:.0} MB，每 MB 最多用时 {:.0} ms；记录每秒需要 {:.2} MB",
        folder.display(),
        speed.bytes_per_second / 1e6,
        speed.longest.as_secs_f64() * 1e3,
        need / 1e6,
    );
    match speed.bytes_per_second < MARGIN * need {
        true => HealthCheck::poor(
            text!("disk", "磁盘"),
            found,
            text!(
                "record onto another disk (--record): what it does not take in time is left out, and counted",
                "记录到其他磁盘（--record）：磁盘来不及写入的部分会被略去并计数"
            ),
        ),
        false => HealthCheck::good(text!("disk", "磁盘"), found),
    }
}

fn room(folder: &Path, need: f64) -> HealthCheck {
    let free = match machine::free_bytes(folder) {
        Ok(free) => free as f64,
        Err(error) => {
            let found = text!(
                "{} does not tell its room: {error}",
                "无法得知 {} 的可用空间：{error}",
                folder.display()
            );
            return HealthCheck::good(text!("room", "空间"), found);
        }
    };
    let hours = free / (need * 3600.0);
    let found = text!(
        "{:.1} GB, {hours:.0} hours of a moving arm",
        "{:.1} GB，可记录机械臂运动 {hours:.0} 小时",
        free / 1e9
    );
    match hours < HOURS {
        true => HealthCheck::poor(
            text!("room", "空间"),
            found,
            text!(
                "make room, or bound what recordings take with --record-budget and --record-rotate",
                "腾出空间，或用 --record-budget 和 --record-rotate 限制记录的大小"
            ),
        ),
        false => HealthCheck::good(text!("room", "空间"), found),
    }
}

#[cfg(test)]
mod tests {
    use super::super::CheckResult;
    use super::*;

    #[test]
    fn what_is_tried_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let deep = folder.path().join("not/yet/there");
        assert_eq!(nearest_that_is_there(&deep), folder.path());
        assert!(tried(folder.path()).unwrap().bytes_per_second > 0.0);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
        assert!(tried(&deep).is_err());
    }

    #[test]
    fn slow_disks_are_told() {
        let speed = |bytes_per_second| Speed {
            bytes_per_second,
            longest: Duration::from_millis(3),
        };
        let (slow, quick) = (speed(1e6), speed(1e9));
        let folder = Path::new("recordings");
        assert_eq!(judged_speed(folder, slow, 2e5).grade, CheckResult::Poor);
        assert_eq!(judged_speed(folder, quick, 2e5).grade, CheckResult::Good);
    }
}
