//! `eliteserver import` as people type it, and how near the arm comes to the path of a file.

#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

use std::path::Path;
use std::process::Output;

use crate::common::eliteserver;

/// In the frame of the file, mm: corners of all kinds, arcs in both directions, tangents and none.
const PART: &str = "\
G21 G90 G17
G0 X0 Y0 Z20
G1 Z0 F1200
X60
G3 X80 Y20 J20
G1 Y60
X70 Y61
X60 Y60.5
X0 Y58.5
G2 X-20 Y40 R19
G1 X-10 Y20
G3 X-10 Y10 I0 J-5
G1 X0 Y0
G0 Z20
M30
";
const FRAME: &str = "-0.55,-0.15,0.2,0.1,-0.05,0.4";

/// What the path consists of, mm.
enum Piece {
    Line([f64; 2], [f64; 2]),
    /// Centre, radius, and a point that lies on the side of the arc.
    Arc([f64; 2], f64),
}

fn pieces() -> Vec<Piece> {
    let lines = [
        ([0.0, 0.0], [60.0, 0.0]),
        ([80.0, 20.0], [80.0, 60.0]),
        ([80.0, 60.0], [70.0, 61.0]),
        ([70.0, 61.0], [60.0, 60.5]),
        ([60.0, 60.5], [0.0, 58.5]),
        ([-20.0, 40.0], [-10.0, 20.0]),
        ([-10.0, 10.0], [0.0, 0.0]),
    ];
    let mut pieces: Vec<Piece> = lines.into_iter().map(|(a, b)| Piece::Line(a, b)).collect();
    pieces.push(Piece::Arc([60.0, 20.0], 20.0));
    pieces.push(Piece::Arc([-10.0, 15.0], 5.0));
    // The centre of the arc by R: clockwise, less than half a turn, to the right of the chord.
    let (from, to, radius) = ([0.0_f64, 58.5_f64], [-20.0_f64, 40.0_f64], 19.0_f64);
    let chord = [to[0] - from[0], to[1] - from[1]];
    let length = chord[0].hypot(chord[1]);
    let height = (radius * radius - length * length / 4.0).sqrt();
    let centre = [
        from[0] + chord[0] / 2.0 + height * chord[1] / length,
        from[1] + chord[1] / 2.0 - height * chord[0] / length,
    ];
    pieces.push(Piece::Arc(centre, radius));
    pieces
}

/// Distance of a point from the path, mm.
fn distance([x, y, z]: [f64; 3]) -> f64 {
    let pieces = pieces();
    let across = pieces.iter().map(|piece| match piece {
        Piece::Line(a, b) => {
            let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
            let part = ((x - a[0]) * dx + (y - a[1]) * dy) / (dx * dx + dy * dy);
            let part = part.clamp(0.0, 1.0);
            (x - a[0] - part * dx).hypot(y - a[1] - part * dy)
        }
        Piece::Arc(centre, radius) => ((x - centre[0]).hypot(y - centre[1]) - radius).abs(),
    });
    let flat = across.fold(f64::INFINITY, f64::min).hypot(z);
    // The plunge.
    match (-0.1..=20.1).contains(&z) {
        true => flat.min(x.hypot(y)),
        false => flat,
    }
}

fn run(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = eliteserver();
    command
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

fn done(folder: &Path, arguments: &[&str]) -> String {
    let output = run(folder, arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {said}");
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn the_arm_stays_within_the_tolerance_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("part.ngc"), PART).unwrap();
    done(
        folder,
        &[
            "import",
            "part.ngc",
            "--frame",
            FRAME,
            "--check",
            "--strict",
            "-o",
            "part.script",
        ],
    );
    let program = std::fs::read_to_string(folder.join("part.script")).unwrap();
    assert_eq!(program.matches("\nmovec(").count(), 3, "{program}");
    assert_eq!(program.matches("\nmovep(").count(), 8, "{program}");
    done(folder, &["check", "part.script"]);
    done(folder, &["run", "part.script", "--record", "part.mcap"]);
    let table = done(folder, &["replay", "part.mcap", "--csv", "/cycle"]);
    let mut lines = table.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let columns: Vec<usize> = (0..3)
        .map(|axis| {
            names
                .iter()
                .position(|name| *name == format!("actual_tcp_pose_{axis}"))
                .unwrap()
        })
        .collect();
    let numbers: Vec<f64> = FRAME.split(',').map(|x| x.parse().unwrap()).collect();
    let frame = kinematics::RpyPose::from_array(numbers.try_into().unwrap());
    let frame_from_base = kinematics::Pose::from_rpy(&frame).inverse();
    let points: Vec<[f64; 3]> = lines
        .map(|line| {
            let cells: Vec<&str> = line.split(',').collect();
            let base: [f64; 3] = core::array::from_fn(|axis| cells[columns[axis]].parse().unwrap());
            let point = frame_from_base.transform_point(base.into()) * 1e3;
            point.into()
        })
        .collect();
    // From where the plunge begins.
    let begin = points
        .iter()
        .position(|point| point[0].hypot(point[1]).hypot(point[2] - 20.0) < 1e-3)
        .unwrap();
    let furthest = points[begin..]
        .iter()
        .map(|point| distance(*point))
        .fold(0.0, f64::max);
    assert!(furthest < 0.05, "{furthest} mm");
    assert!(furthest > 1e-4, "the corners are rounded: {furthest} mm");
}

#[test]
fn what_is_not_understood_is_named_and_strict_refuses() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("a.nc"), "G21\nM6 T1\nG1 X10 F600\nM3\nG1 X20\n").unwrap();
    let output = run(folder, &["import", "a.nc"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{said}");
    for sentence in [
        "a.nc: line 2: M6 is not understood",
        "a.nc: line 2: T1 is not understood",
        "a.nc: line 4: M3 does nothing without --on",
    ] {
        assert!(said.contains(sentence), "{said}");
    }
    let program = String::from_utf8(output.stdout).unwrap();
    assert!(
        program.contains("# line 2: M6 is not understood\n"),
        "{program}"
    );
    assert_eq!(
        run(folder, &["import", "a.nc", "--strict"]).status.code(),
        Some(1)
    );

    std::fs::write(folder.join("b.nc"), "G1 X10\nG2 X30 R5\n").unwrap();
    let output = run(folder, &["import", "b.nc"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&output.stderr).contains("line 2: an arc of radius 5 mm"));

    std::fs::write(folder.join("far.csv"), "x,y,z\n-400,0,300\n5000,0,0\n").unwrap();
    assert_eq!(run(folder, &["import", "far.csv"]).status.code(), Some(0));
    let output = run(folder, &["import", "far.csv", "--check"]);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("line 3: the arm does not reach 5.0000"),
        "{said}"
    );
}

#[test]
fn wrong_files_and_options_are_refused_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    std::fs::write(folder.join("a.txt"), "G1 X1\n").unwrap();
    std::fs::write(folder.join("empty.nc"), "").unwrap();
    std::fs::write(folder.join("a.dxf"), "nonsense\nmore\n").unwrap();
    std::fs::write(folder.join("a.nc"), "G1 X1\n").unwrap();
    for (arguments, sentence) in [
        (&["a.txt"][..], "allowed are files that end with"),
        (&["empty.nc"][..], "there is no move (G0 to G3) in it"),
        (&["a.dxf"][..], "line 1: 'nonsense' is no group code"),
        (&["none.nc"][..], "cannot read none.nc"),
        (
            &["a.nc", "--tool-axis", "0,0,0"][..],
            "three numbers that are not all 0",
        ),
        (
            &["a.nc", "--tolerance", "0"][..],
            "allowed are numbers above 0",
        ),
        (
            &["a.nc", "--frame", "1,2"][..],
            "x, y, z in m, up to 10, and Rx, Ry, Rz in rad",
        ),
    ] {
        let output = run(folder, &[&["import"], arguments].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {said}");
        assert!(said.contains(sentence), "{arguments:?}: {said}");
    }
}
