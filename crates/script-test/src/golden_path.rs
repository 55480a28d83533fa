//! The way of the TCP beside one that was kept in a file: read, written, compared.
//!
//! Ways are compared as curves: time does not count, so that a slower run on the same way is as good. The distance of
//! two curves is the discrete Fréchet distance (Eiter and Mannila 1994) of points at even steps along them.

use std::fmt::Write as _;
use std::io;
use std::path::Path;

use kinematics::{Pose, RpyPose};
use messages::{Localized, Text, text};
use thiserror::Error;

use crate::files::FileScope;
use crate::trace::PathSample;

/// Points of a way that are compared.
const POINTS_MAX: usize = 1500;
/// Rows of the table of what differs.
const ROWS: usize = 8;
/// Largest file, bytes.
const FILE_BYTES_MAX: u64 = 64 << 20;
/// The first line of a file.
const HEAD: &str = "time,x,y,z,Rx,Ry,Rz";

/// What is done about ways that were kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GoldenMode {
    /// The way must be as it was.
    Compare,
    /// What is driven now is kept.
    Update,
}

/// A reason why a path cannot be compared, or is not the same.
#[derive(Debug, Error, Localized)]
#[non_exhaustive]
pub(crate) enum GoldenError {
    /// No file.
    #[error("cannot read {path}: {source}; eliteserver test --update writes it from this run")]
    #[zh("无法读取 {path}：{source}；eliteserver test --update 会由本次运行写出它")]
    Unreadable { path: String, source: io::Error },
    /// The file cannot be written.
    #[error("cannot write {path}: {source}")]
    #[zh("无法写入 {path}：{source}")]
    Unwritable { path: String, source: io::Error },
    /// A file of something else.
    #[error("{path} line {line}: {what}")]
    #[zh("{path} 第 {line} 行：{what}")]
    NotAWay {
        path: String,
        line: usize,
        what: Text,
    },
    /// Nothing was driven or kept.
    #[error("{0} has no cycle")]
    #[zh("{0}没有周期")]
    Empty(Text),
    /// The paths differ.
    #[error("{0}")]
    Differs(Text),
}

/// Compares the way with the one in a file, or keeps it there.
pub(crate) fn check(
    places: &[PathSample],
    (files, file): (&FileScope, &Path),
    tolerance: f64,
    goldens: GoldenMode,
) -> Result<(), GoldenError> {
    let path = file.display().to_string();
    if places.is_empty() {
        return Err(GoldenError::Empty(text!("the test", "测试")));
    }
    if goldens == GoldenMode::Update {
        return write(places, files, file)
            .map_err(|source| GoldenError::Unwritable { path, source });
    }
    let kept = read(files, file)?;
    let (own, golden) = (resample(places), resample(&kept));
    let pairs = frechet_coupling(&own, &golden);
    let worst = pairs
        .iter()
        .map(|(i, k)| distance(&own[*i], &golden[*k]))
        .fold(0.0, f64::max);
    match worst <= tolerance {
        true => Ok(()),
        false => Err(GoldenError::Differs(table(
            &own, &golden, &pairs, worst, tolerance, &path,
        ))),
    }
}

fn write(places: &[PathSample], files: &FileScope, file: &Path) -> io::Result<()> {
    let mut text = format!("{HEAD}\n");
    for PathSample { time, pose } in places {
        let _ = write!(text, "{time:.4}");
        for value in pose {
            let _ = write!(text, ",{value:.9}");
        }
        text.push('\n');
    }
    files.write(file, &text)
}

fn read(files: &FileScope, file: &Path) -> Result<Vec<PathSample>, GoldenError> {
    let path = file.display().to_string();
    let text = match files.text(file, FILE_BYTES_MAX) {
        Ok(text) => text,
        Err(Ok(bytes)) => {
            let what = text!(
                "the file has {bytes} bytes, at most {FILE_BYTES_MAX} are read",
                "文件有 {bytes} 字节，最多读取 {FILE_BYTES_MAX} 字节"
            );
            let line = 1;
            return Err(GoldenError::NotAWay { path, line, what });
        }
        Err(Err(source)) => return Err(GoldenError::Unreadable { path, source }),
    };
    let wrong = |line: usize, what: Text| GoldenError::NotAWay {
        path: path.clone(),
        line: line + 1,
        what,
    };
    let mut places = Vec::new();
    for (index, line) in text.lines().enumerate() {
        if index == 0 {
            if line.trim() != HEAD {
                return Err(wrong(
                    0,
                    text!("the first line must be {HEAD}", "第一行应为 {HEAD}"),
                ));
            }
            continue;
        }
        let numbers = line.split(',').map(|text| text.trim().parse::<f64>().ok());
        let numbers: Option<Vec<f64>> = numbers.map(|x| x.filter(|x| x.is_finite())).collect();
        let Some(&[time, x, y, z, rx, ry, rz]) = numbers.as_deref() else {
            return Err(wrong(
                index,
                text!("seven numbers are needed", "需要七个数"),
            ));
        };
        let pose = [x, y, z, rx, ry, rz];
        places.push(PathSample { time, pose });
    }
    match places.is_empty() {
        true => Err(GoldenError::Empty(Text::verbatim(path))),
        false => Ok(places),
    }
}

/// How far two poses are apart: the larger of the distance, m, and the angle, rad.
fn distance(a: &PathSample, b: &PathSample) -> f64 {
    let (from, to) = (pose(a), pose(b));
    let moved = (from.translation - to.translation).norm();
    moved.max((from.rotation.inverse() * to.rotation).angle())
}

fn pose(place: &PathSample) -> Pose {
    Pose::from_rpy(&RpyPose::from_array(place.pose))
}

/// Points at even steps along the way, the first and the last among them; standing still makes none.
fn resample(places: &[PathSample]) -> Vec<PathSample> {
    let steps = places.windows(2).map(|pair| distance(&pair[0], &pair[1]));
    let steps: Vec<f64> = steps.collect();
    let length: f64 = steps.iter().sum();
    let spacing = (length / (POINTS_MAX - 2) as f64).max(1e-5);
    let mut points: Vec<PathSample> = places.first().copied().into_iter().collect();
    let mut since = 0.0;
    for (step, place) in steps.iter().zip(places.iter().skip(1)) {
        since += step;
        if since >= spacing && points.len() < POINTS_MAX - 1 {
            points.push(*place);
            since = 0.0;
        }
    }
    points.extend(places.last());
    points
}

/// The best coupling of two rows of points: pairs that go on in one or both, whose largest distance is the smallest.
fn frechet_coupling(own: &[PathSample], golden: &[PathSample]) -> Vec<(usize, usize)> {
    let (rows, columns) = (own.len(), golden.len());
    let mut reach = vec![f64::INFINITY; rows * columns];
    let at = |i: usize, k: usize| i * columns + k;
    for i in 0..rows {
        for k in 0..columns {
            let before = match (i, k) {
                (0, 0) => 0.0,
                (0, _) => reach[at(0, k - 1)],
                (_, 0) => reach[at(i - 1, 0)],
                _ => reach[at(i - 1, k - 1)]
                    .min(reach[at(i - 1, k)])
                    .min(reach[at(i, k - 1)]),
            };
            reach[at(i, k)] = distance(&own[i], &golden[k]).max(before);
        }
    }
    let (mut i, mut k) = (rows - 1, columns - 1);
    let mut pairs = vec![(i, k)];
    while (i, k) != (0, 0) {
        let mut best = (f64::INFINITY, i, k);
        for (di, dk) in [(1, 1), (1, 0), (0, 1)] {
            if i >= di && k >= dk && reach[at(i - di, k - dk)] < best.0 {
                best = (reach[at(i - di, k - dk)], i - di, k - dk);
            }
        }
        (i, k) = (best.1, best.2);
        pairs.push((i, k));
    }
    pairs.reverse();
    pairs
}

/// A table of a few rows that shows where the paths differ.
fn table(
    own: &[PathSample],
    golden: &[PathSample],
    pairs: &[(usize, usize)],
    worst: f64,
    tolerance: f64,
    path: &str,
) -> Text {
    let apart = |(i, k): &(usize, usize)| distance(&own[*i], &golden[*k]);
    let beyond: Vec<&(usize, usize)> = pairs.iter().filter(|p| apart(p) > tolerance).collect();
    let mut rows = String::new();
    let every = beyond.len().div_ceil(ROWS).max(1);
    for pair in beyond.iter().step_by(every) {
        let (driven, kept) = (&own[pair.0], &golden[pair.1]);
        let xyz = |place: &PathSample| {
            let [x, y, z, ..] = place.pose;
            format!("{x:8.4} {y:8.4} {z:8.4}")
        };
        let _ = write!(
            rows,
            "\n  {:8.3}   {}  {}  {:.6}",
            driven.time,
            xyz(driven),
            xyz(kept),
            apart(pair)
        );
    }
    text!(
        "the way of the TCP is up to {worst:.6} away from {path} \
         (m, or rad of its orientation), allowed are {tolerance}\n\
         \x20   time s   driven x, y, z m            kept x, y, z m              apart{rows}",
        "TCP 的路径与 {path} 最多相差 {worst:.6}（m，姿态为 rad），允许 {tolerance}\n\
         \x20   时间 s   实际 x, y, z m              保存 x, y, z m              相差{rows}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(y: f64, cycles: usize) -> Vec<PathSample> {
        let place = |n: usize| PathSample {
            time: n as f64 * 0.004,
            pose: [0.2 * n as f64 / cycles as f64, y, 0.3, 3.1, 0.0, 0.0],
        };
        (0..=cycles).map(place).collect()
    }

    #[test]
    fn a_slower_run_on_the_same_way_is_the_same_and_another_way_is_told_by_rows() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("ways/line.csv");
        check(
            &line(0.1, 200),
            (&FileScope::default(), &file),
            1e-3,
            GoldenMode::Update,
        )
        .unwrap();
        check(
            &line(0.1, 200),
            (&FileScope::default(), &file),
            1e-6,
            GoldenMode::Compare,
        )
        .unwrap();
        let mut slower = line(0.1, 555);
        slower.extend(vec![*slower.last().unwrap(); 100]);
        check(
            &slower,
            (&FileScope::default(), &file),
            1e-3,
            GoldenMode::Compare,
        )
        .unwrap();
        let error = check(
            &line(0.105, 200),
            (&FileScope::default(), &file),
            1e-3,
            GoldenMode::Compare,
        )
        .unwrap_err();
        let text = error.to_string();
        assert!(text.contains("up to 0.005000 away"), "{text}");
        assert!(text.lines().count() <= 3 + ROWS, "{text}");
        // There and back again is another way than not at all.
        let mut there_and_back = line(0.1, 200);
        there_and_back.extend(line(0.1, 200).into_iter().rev());
        assert!(
            check(
                &there_and_back,
                (&FileScope::default(), &file),
                1e-3,
                GoldenMode::Compare
            )
            .is_err()
        );
    }

    #[test]
    fn what_is_no_way_is_said_with_the_line() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("way.csv");
        let places = line(0.0, 3);
        for (text, said) in [
            ("", "has no cycle"),
            ("time,x\n", "line 1: the first line must be"),
            ("time,x,y,z,Rx,Ry,Rz\n1,2,3\n", "line 2: seven numbers"),
            (
                "time,x,y,z,Rx,Ry,Rz\n0,0,0,0,0,0,nan\n",
                "line 2: seven numbers",
            ),
        ] {
            std::fs::write(&file, text).unwrap();
            let error = check(
                &places,
                (&FileScope::default(), &file),
                1e-3,
                GoldenMode::Compare,
            )
            .unwrap_err();
            assert!(error.to_string().contains(said), "{text:?}: {error}");
        }
        let missing = folder.path().join("missing.csv");
        let error = check(
            &places,
            (&FileScope::default(), &missing),
            1e-3,
            GoldenMode::Compare,
        )
        .unwrap_err();
        assert!(error.to_string().contains("--update"), "{error}");
    }
}
