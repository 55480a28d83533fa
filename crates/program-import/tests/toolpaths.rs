//! Toolpaths from G-code, drawings and tables, and the programs that they become.

use kinematics::RpyPose;
use program_import::toolpath::program::{ProgramOptions, tool_rpy, write};
use program_import::toolpath::{Point, StepKind, Toolpath, csv, dxf, gcode};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

const TOLERANCE: f64 = 1.5e-5;

fn kinds(path: &Toolpath) -> Vec<StepKind> {
    path.steps.iter().map(|step| step.kind.clone()).collect()
}

fn remarks(path: &Toolpath) -> Vec<String> {
    path.remarks.iter().map(ToString::to_string).collect()
}

fn options() -> ProgramOptions {
    ProgramOptions {
        frame: RpyPose::from_array([-0.5, -0.2, 0.1, 0.0, 0.0, 0.0]),
        tool_axis: [0.0, 0.0, -1.0],
        speed: None,
        speed_factor: 1.0,
        tolerance: 5e-5,
        on: None,
        off: None,
        lead_in: 0.0,
        lifts: false,
    }
}

/// The statements after the head.
fn body(path: &Toolpath, options: &ProgramOptions) -> String {
    let (text, _) = write(path, "a", options, &mut |_, _| false);
    text.split_once("end\n\n").unwrap().1.to_owned()
}

fn near(a: Point, b: Point) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9)
}

#[test]
fn words_of_gcode_move_and_switch() {
    let text = "\
%
N10 G21 G90 G17 G40 G49 G80 G94 G54 (units)
G0 X10 Y0 Z5 ; over the part
M3 S1000
G1 Z-1 F300
X20.5
G91 G1 X-0.5 Y1
G20 G90 G1 X1
G4 P0.5
M5
M30
G1 X99
";
    let path = gcode::read(text, TOLERANCE).unwrap();
    assert!(path.remarks.is_empty(), "{:?}", remarks(&path));
    let expected = vec![
        StepKind::Rapid([0.01, 0.0, 0.005]),
        StepKind::Switch(true, "M3"),
        StepKind::Speed(0.005),
        StepKind::Line([0.01, 0.0, -0.001]),
        StepKind::Line([0.0205, 0.0, -0.001]),
        StepKind::Line([0.02, 0.001, -0.001]),
        StepKind::Line([0.0254, 0.001, -0.001]),
        StepKind::Dwell(0.5),
        StepKind::Switch(false, "M5"),
    ];
    assert_eq!(kinds(&path), expected);
}

#[test]
fn arcs_stay_arcs_in_every_plane() {
    // A quarter of a circle about 0, 0; half a circle by R; a whole one; the other planes.
    let quarter = gcode::read("G1 X10\nG3 X0 Y10 I-10 J0\n", TOLERANCE).unwrap();
    let StepKind::Arc { via, to } = quarter.steps[1].kind else {
        panic!("{quarter:?}");
    };
    let half = 0.01 * 0.5_f64.sqrt();
    assert!(near(via, [half, half, 0.0]) && near(to, [0.0, 0.01, 0.0]));

    let by_radius = gcode::read("G1 X10\nG2 X0 R5\n", TOLERANCE).unwrap();
    let StepKind::Arc { via, .. } = by_radius.steps[1].kind else {
        panic!("{by_radius:?}");
    };
    // Clockwise from the right to the left goes below.
    assert!(near(via, [0.005, -0.005, 0.0]), "{via:?}");

    let long = gcode::read("G1 X10\nG3 X0 Y10 R-10\n", TOLERANCE).unwrap();
    assert_eq!(
        long.steps.len(),
        3,
        "three quarters of a circle are two arcs"
    );
    let whole = gcode::read("G1 X10\nG2 I-10\n", TOLERANCE).unwrap();
    let StepKind::Arc { via, to } = whole.steps[2].kind else {
        panic!("{whole:?}");
    };
    assert!(near(via, [0.0, 0.01, 0.0]) && near(to, [0.01, 0.0, 0.0]));

    let text = "G18 G1 X10\nG2 X0 Z10 I-10\nG19 G1 Y10 Z0\nG90.1 G3 Y0 Z10 J0 K0\n";
    let upright = gcode::read(text, TOLERANCE).unwrap();
    let StepKind::Arc { via, .. } = upright.steps[1].kind else {
        panic!("{upright:?}");
    };
    let StepKind::Arc { via: other, .. } = upright.steps[3].kind else {
        panic!("{upright:?}");
    };
    assert!(near(other, [0.0, half, half]), "{other:?}");
    // In the plane ZX clockwise is seen from +Y: from +X to +Z.
    assert!(near(via, [half, 0.0, half]), "{via:?}");
}

#[test]
fn a_helix_is_lines_within_the_tolerance() {
    let path = gcode::read("G1 X10\nG3 X-10 Z2 I-10\n", TOLERANCE).unwrap();
    assert!(path.steps.len() > 10);
    for pair in path.steps[1..].windows(2) {
        let (StepKind::Line(a), StepKind::Line(b)) = (&pair[0].kind, &pair[1].kind) else {
            panic!("{pair:?}");
        };
        let middle = [f64::midpoint(a[0], b[0]), f64::midpoint(a[1], b[1])];
        assert!(0.01 - middle[0].hypot(middle[1]) <= TOLERANCE);
    }
}

#[test]
fn what_gcode_does_not_say_is_named_with_its_line() {
    let text =
        "G1 X1\nM6 T2\nG1 X[#1+2]\nO100 sub\nG43 H1\nG2 X5 Y0 I1 J0\nG2 X9 R1\nG1 X2 A30\nG1 F0\n";
    let path = gcode::read(text, TOLERANCE).unwrap();
    assert_eq!(
        remarks(&path),
        [
            "line 2: M6 is not understood",
            "line 2: T2 is not understood",
            "line 3: 'G1 X[#1+2]' is not understood",
            "line 4: 'O100 sub' is not understood",
            "line 5: G43 is not understood",
            "line 5: H1 is not understood",
            "line 6: the arc begins 1 mm from its centre and ends 3 mm from it",
            "line 7: an arc of radius 1 mm cannot reach a point 4 mm away",
            "line 8: A30 is not understood",
            "line 9: a feed of 0: allowed is more than 0",
        ]
    );
    let errors: Vec<u32> = path
        .remarks
        .iter()
        .filter(|r| r.is_error)
        .map(|r| r.line)
        .collect();
    assert_eq!(errors, [6, 7, 9]);
    assert!(gcode::read("(nothing)\nM3\n", TOLERANCE).is_err());
}

/// A drawing of these entities; each a list of group codes and values.
fn drawing(unit: u32, entities: &[&[(i32, &str)]]) -> String {
    let mut text = format!(
        "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n{unit}\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n"
    );
    for (code, value) in entities.iter().copied().flatten() {
        text.push_str(&format!("{code}\n{value}\n"));
    }
    text + "0\nENDSEC\n0\nEOF\n"
}

#[test]
fn a_drawing_is_driven_contour_by_contour() {
    let text = drawing(
        4,
        &[
            &[
                (0, "LINE"),
                (8, "cut"),
                (10, "0"),
                (20, "0"),
                (11, "10"),
                (21, "0"),
            ],
            // Begins where it should end: turned round.
            &[
                (0, "ARC"),
                (8, "cut"),
                (10, "10"),
                (20, "5"),
                (40, "5"),
                (50, "270"),
                (51, "90"),
            ],
            &[(0, "CIRCLE"), (8, "other"), (10, "0"), (20, "0"), (40, "2")],
            &[
                (0, "LWPOLYLINE"),
                (8, "cut"),
                (90, "2"),
                (70, "1"),
                (10, "30"),
                (20, "0"),
                (42, "1"),
                (10, "40"),
                (20, "0"),
            ],
            &[(0, "TEXT"), (8, "cut"), (1, "hello")],
        ],
    );
    let path = dxf::read(&text, &["CUT".to_owned()], TOLERANCE).unwrap();
    let kinds = kinds(&path);
    assert_eq!(kinds[0], StepKind::Rapid([0.0, 0.0, 0.0]));
    assert_eq!(kinds[1], StepKind::Switch(true, ""));
    assert_eq!(kinds[2], StepKind::Line([0.01, 0.0, 0.0]));
    let StepKind::Arc { via, to } = kinds[3] else {
        panic!("{kinds:?}");
    };
    assert!(near(via, [0.015, 0.005, 0.0]) && near(to, [0.01, 0.01, 0.0]));
    assert_eq!(kinds[4], StepKind::Switch(false, ""));
    assert_eq!(kinds[5], StepKind::Rapid([0.03, 0.0, 0.0]));
    // A bulge of 1 is half a circle to the right of its way, counter-clockwise.
    let StepKind::Arc { via, .. } = kinds[7] else {
        panic!("{kinds:?}");
    };
    assert!(near(via, [0.035, -0.005, 0.0]), "{via:?}");
    assert_eq!(kinds[8], StepKind::Line([0.03, 0.0, 0.0]));
    assert_eq!(kinds.len(), 10);
    assert_eq!(
        remarks(&path),
        ["line 69: TEXT is not understood: left out"]
    );
}

/// A spline through points, mm, with tangents at its ends.
fn fitted(points: &[[f64; 3]], tangents: &[(i32, [f64; 3])]) -> String {
    let points = points.iter().map(|point| (11, *point));
    let groups: Vec<(i32, String)> = points
        .chain(tangents.iter().copied())
        .flat_map(|(code, [x, y, z])| [(code, x), (code + 10, y), (code + 20, z)])
        .map(|(code, number)| (code, number.to_string()))
        .collect();
    let groups = groups.iter().map(|(code, text)| (*code, text.as_str()));
    let head = [(0, "SPLINE"), (70, "8"), (71, "3")];
    drawing(4, &[&head.into_iter().chain(groups).collect::<Vec<_>>()])
}

/// The points that a drawing is driven through, mm.
fn driven_mm(text: &str) -> Vec<Point> {
    let path = dxf::read(text, &[], TOLERANCE).unwrap();
    assert_eq!(remarks(&path), [""; 0]);
    let points = path.steps.iter().filter_map(|step| match step.kind {
        StepKind::Line(p) | StepKind::Rapid(p) => Some(p.map(|x| x * 1e3)),
        _ => None,
    });
    points.collect()
}

#[test]
fn a_spline_through_points_is_the_one_of_ezdxf() {
    // `fit_points_to_cad_cv(points, tangents)` of ezdxf 1.4.5: nine points of the curve, and the length of its
    // flattening to 0.0005 mm.
    let open = [
        [0.0, 0.0, 0.0],
        [20.0, 30.0, 0.0],
        [50.0, 10.0, 0.0],
        [60.0, -20.0, 0.0],
        [100.0, 0.0, 0.0],
        [110.0, 40.0, 0.0],
    ];
    let space = [
        [0.0, 0.0, 0.0],
        [10.0, 10.0, 5.0],
        [30.0, 0.0, 20.0],
        [35.0, -15.0, 0.0],
    ];
    let cases = [
        (
            fitted(&open, &[]),
            197.5483,
            [
                [0.0, 0.0, 0.0],
                [11.4536, 24.0585, 0.0],
                [30.1317, 28.9349, 0.0],
                [49.4898, 11.0448, 0.0],
                [56.4897, -14.1677, 0.0],
                [71.5572, -20.7637, 0.0],
                [95.0989, -5.6095, 0.0],
                [107.8739, 16.6327, 0.0],
                [110.0, 40.0, 0.0],
            ],
        ),
        (
            fitted(&open[..5], &[(12, [1.0, 0.0, 0.0]), (13, [0.0, 2.0, 0.0])]),
            160.0046,
            [
                [0.0, 0.0, 0.0],
                [11.7249, 13.3645, 0.0],
                [20.7249, 30.4778, 0.0],
                [37.2728, 26.2935, 0.0],
                [50.9534, 7.5538, 0.0],
                [55.2459, -12.5538, 0.0],
                [66.6835, -21.7681, 0.0],
                [88.1535, -15.7452, 0.0],
                [100.0, 0.0, 0.0],
            ],
        ),
        (
            fitted(&space, &[]),
            70.5742,
            [
                [0.0, 0.0, 0.0],
                [5.375, 6.723, 2.1702],
                [11.4204, 10.3977, 6.1006],
                [18.2627, 9.4307, 12.1578],
                [24.88, 5.2974, 17.7694],
                [30.1051, -0.1378, 19.9905],
                [33.1306, -5.3759, 16.7766],
                [34.4834, -10.2732, 9.4232],
                [35.0, -15.0, 0.0],
            ],
        ),
        (
            fitted(
                &[[0.0; 3], [40.0, 30.0, 0.0]],
                &[(12, [0.0, 1.0, 0.0]), (13, [1.0, 0.0, 0.0])],
            ),
            54.3759,
            [
                [0.0, 0.0, 0.0],
                [1.0352, 6.0742, 0.0],
                [3.9063, 11.7188, 0.0],
                [8.2617, 16.8164, 0.0],
                [13.75, 21.25, 0.0],
                [20.0195, 24.9023, 0.0],
                [26.7188, 27.6562, 0.0],
                [33.4961, 29.3945, 0.0],
                [40.0, 30.0, 0.0],
            ],
        ),
    ];
    for (text, length, truth) in cases {
        let driven = driven_mm(&text);
        for point in truth {
            let distances = driven
                .windows(2)
                .map(|pair| distance_to_line(point, pair[0], pair[1]));
            let nearest = distances.fold(f64::INFINITY, f64::min);
            assert!(nearest < 0.05, "{point:?}: {nearest} mm");
        }
        let own: f64 = driven
            .windows(2)
            .map(|pair| distance(pair[0], pair[1]))
            .sum();
        assert!((own - length).abs() < 0.05, "{own} {length}");
        assert!(
            distance(driven[0], truth[0]) < 1e-9
                && distance(driven[driven.len() - 1], truth[8]) < 1e-9
        );
    }
    // A tangent at one end, points that come twice, a straight line.
    let one = driven_mm(&fitted(
        &[[0.0; 3], [0.0; 3], [40.0, 30.0, 0.0]],
        &[(12, [0.0, 1.0, 0.0])],
    ));
    assert!(one.len() > 4 && one[1][0] < 0.3 * one[1][1], "{one:?}");
    let straight = driven_mm(&fitted(&[[0.0; 3], [40.0, 30.0, 0.0]], &[]));
    assert!(
        straight
            .iter()
            .all(|p| (p[0] * 3.0 - p[1] * 4.0).abs() < 1e-9)
    );
    // Less than two points are none.
    for points in [&[][..], &[[1.0; 3]], &[[1.0; 3], [1.0; 3]]] {
        let path = dxf::read(&fitted(points, &[]), &[], TOLERANCE).unwrap();
        assert_eq!(
            remarks(&path),
            ["line 15: a spline has neither control points nor two fit points that differ"]
        );
        assert!(path.remarks[0].is_error);
    }
}

/// Distance of a point from a line between two points.
fn distance_to_line(point: Point, from: Point, to: Point) -> f64 {
    let along = |k: f64| [0, 1, 2].map(|axis| from[axis] + k * (to[axis] - from[axis]));
    let length = distance(from, to);
    let dot: f64 = (0..3)
        .map(|axis| (point[axis] - from[axis]) * (to[axis] - from[axis]))
        .sum();
    distance(point, along((dot / (length * length)).clamp(0.0, 1.0)))
}

fn distance(a: Point, b: Point) -> f64 {
    (0..3)
        .map(|axis| (a[axis] - b[axis]).powi(2))
        .sum::<f64>()
        .sqrt()
}

#[test]
fn units_mirrors_and_splines_of_drawings() {
    let inch = drawing(
        1,
        &[&[(0, "LINE"), (10, "0"), (20, "0"), (11, "1"), (21, "0")]],
    );
    let path = dxf::read(&inch, &[], TOLERANCE).unwrap();
    assert_eq!(path.steps[2].kind, StepKind::Line([0.0254, 0.0, 0.0]));

    let mirrored = drawing(
        4,
        &[&[
            (0, "ARC"),
            (10, "10"),
            (20, "0"),
            (40, "5"),
            (50, "0"),
            (51, "90"),
            (230, "-1"),
        ]],
    );
    let path = dxf::read(&mirrored, &[], TOLERANCE).unwrap();
    assert!(matches!(path.steps[0].kind, StepKind::Rapid(p) if near(p, [-0.015, 0.0, 0.0])));

    // A quarter of a circle as a rational spline of degree 2.
    let weight = "0.7071067811865476";
    let spline = drawing(
        6,
        &[&[
            (0, "SPLINE"),
            (70, "8"),
            (71, "2"),
            (40, "0"),
            (40, "0"),
            (40, "0"),
            (40, "1"),
            (40, "1"),
            (40, "1"),
            (41, "1"),
            (41, weight),
            (41, "1"),
            (10, "0.1"),
            (20, "0"),
            (10, "0.1"),
            (20, "0.1"),
            (10, "0"),
            (20, "0.1"),
        ]],
    );
    let path = dxf::read(&spline, &[], TOLERANCE).unwrap();
    let points: Vec<Point> = path
        .steps
        .iter()
        .filter_map(|step| match step.kind {
            StepKind::Line(p) | StepKind::Rapid(p) => Some(p),
            _ => None,
        })
        .collect();
    assert!(points.len() > 8);
    for pair in points.windows(2) {
        assert!((pair[0][0].hypot(pair[0][1]) - 0.1).abs() < 1e-12);
        let middle = [
            f64::midpoint(pair[0][0], pair[1][0]),
            f64::midpoint(pair[0][1], pair[1][1]),
        ];
        assert!(0.1 - middle[0].hypot(middle[1]) < 1.05 * TOLERANCE);
    }
    let broken = drawing(
        4,
        &[&[(0, "SPLINE"), (71, "3"), (40, "0"), (10, "1"), (20, "2")]],
    );
    let path = dxf::read(&broken, &[], TOLERANCE).unwrap();
    assert!(
        path.remarks[0].is_error
            && path.remarks[0]
                .text
                .english()
                .contains("has 5 knots, and this one 1")
    );
}

#[test]
fn damaged_drawings_are_refused_with_their_line() {
    for (text, sentence) in [
        (
            "hello\nworld\n",
            "line 1: 'hello' is no group code of a DXF file",
        ),
        (
            "AutoCAD Binary DXF\r\n\x1a\0",
            "line 1: this is a binary DXF file: save it as text",
        ),
        (
            "0\nSECTION\n2\nENTITIES\n0\nLINE\n10\nfar\n0\nENDSEC\n",
            "line 7: 'far' is no number",
        ),
        (
            "0\nSECTION\n2\nENTITIES\n0\nPOLYLINE\n0\nVERTEX\n",
            "line 5: a POLYLINE has no SEQEND",
        ),
        (
            "0\nEOF\n",
            "there is no line, polyline, arc, circle, ellipse or spline",
        ),
    ] {
        assert_eq!(
            dxf::read(text, &[], TOLERANCE).unwrap_err().to_string(),
            sentence
        );
    }
}

#[test]
fn tables_have_heads_units_and_both_commas() {
    let path = csv::read("X (mm), Y, Z\n1,2,3\n4,5,6\n", 0.001).unwrap();
    assert_eq!(path.steps[1].kind, StepKind::Line([0.004, 0.005, 0.006]));
    assert_eq!(path.steps[1].line, 3);
    let path = csv::read("z;y;x\n1,5;2;3\n", 1.0).unwrap();
    assert_eq!(path.steps[0].kind, StepKind::Line([3.0, 2.0, 1.5]));
    let path = csv::read("1,2,3,0,3.1,0\n", 0.001).unwrap();
    assert_eq!(
        path.steps[0].kind,
        StepKind::Pose([0.001, 0.002, 0.003], [0.0, 3.1, 0.0])
    );
    for (text, sentence) in [
        (
            "1,2\n",
            "line 1: 2 columns: a point has x, y, z and perhaps rx, ry, rz",
        ),
        ("1,2,3\n1,2,x\n", "line 2: 'x' is no number"),
        ("1,2,nan\n", "line 1: 'nan' is no number"),
        (
            "a,b\n1,2\n",
            "line 1: the head names no columns x, y, z and perhaps rx, ry, rz",
        ),
        ("", "there is no point in it"),
    ] {
        assert_eq!(csv::read(text, 1.0).unwrap_err().to_string(), sentence);
    }
}

#[test]
fn rows_are_driven_without_stops() {
    let path = gcode::read(
        "G0 X0 Y0 Z0\nG1 X10 F600\nX20 Y0.5\nG3 X20 Y10.5 J5\nG1 X0\nM3\nG0 Z10\n",
        TOLERANCE,
    )
    .unwrap();
    insta::assert_snapshot!(body(&path, &options()), @r"
    movej(get_inverse_kin(at(0, 0, 0)))
    movep(at(0.01, 0, 0), v=0.01, r=0.00240187)
    movep(at(0.02, 0.0005, 0), v=0.01, r=0.00054772)
    movec(at(0.025, 0.0055, 0), at(0.02, 0.0105, 0), v=0.01, r=0.00054772, mode=1)
    movep(at(0, 0.0105, 0), v=0.01)
    # line 6: M3 does nothing without --on
    movel(at(0, 0.0105, 0.01), v=0.25)
    ");
}

#[test]
fn drawings_are_lifted_between_contours() {
    let text = drawing(
        4,
        &[
            &[(0, "LINE"), (10, "0"), (20, "0"), (11, "10"), (21, "0")],
            &[(0, "LINE"), (10, "0"), (20, "20"), (11, "10"), (21, "20")],
        ],
    );
    let path = dxf::read(&text, &[], TOLERANCE).unwrap();
    let options = ProgramOptions {
        on: Some("set_standard_digital_out(0, True)".to_owned()),
        off: Some("set_standard_digital_out(0, False)".to_owned()),
        lead_in: 0.03,
        lifts: true,
        ..options()
    };
    insta::assert_snapshot!(body(&path, &options), @r"
    movej(get_inverse_kin(at(0, 0, 0.03)))
    movel(at(0, 0, 0), v=0.05)
    set_standard_digital_out(0, True)
    movel(at(0.01, 0, 0), v=0.05)
    set_standard_digital_out(0, False)
    movel(at(0.01, 0, 0.03), v=0.25)
    movel(at(0, 0.02, 0.03), v=0.25)
    movel(at(0, 0.02, 0), v=0.05)
    set_standard_digital_out(0, True)
    movel(at(0.01, 0.02, 0), v=0.05)
    set_standard_digital_out(0, False)
    movel(at(0.01, 0.02, 0.03), v=0.25)
    ");
}

#[test]
fn the_tool_points_along_its_axis() {
    for axis in [
        [0.0, 0.0, -1.0],
        [0.0, 0.0, 1.0],
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.3, -0.5, -2.0],
    ] {
        let rpy = tool_rpy(axis);
        let z = kinematics::rotation::rotation_from_rpy(rpy) * nalgebra::Vector3::z();
        let wanted = nalgebra::Vector3::from(axis).normalize();
        assert!((z - wanted).norm() < 1e-12, "{axis:?}");
    }
    assert!((tool_rpy([0.0, 0.0, -1.0])[0].abs() - core::f64::consts::PI).abs() < 1e-12);
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: RngSeed::Fixed(7), cases: 1000, ..ProptestConfig::default() })]

    #[test]
    fn any_words_are_read_or_refused(
        words in prop::collection::vec(("[GMXYZIJKRFSPTNA(/%;#]", -1.0e6..1.0e6_f64), 0..40),
        breaks in 1_usize..6,
    ) {
        let mut text = String::new();
        for (index, (letter, value)) in words.iter().enumerate() {
            let value = if letter == "G" { (value.abs() % 95.0).round() } else { *value };
            text.push_str(&format!("{letter}{value}"));
            text.push(if index % breaks == 0 { '\n' } else { ' ' });
        }
        if let Ok(path) = gcode::read(&text, TOLERANCE) {
            let (program, _) = write(&path, "a", &options(), &mut |_, _| true);
            let file = elite_syntax::SourceFile::new("a.script", &*program);
            prop_assert!(elite_syntax::parser::parse(&file).diagnostics.is_empty(), "{}", program);
        }
    }

    #[test]
    fn any_groups_are_read_or_refused(
        groups in prop::collection::vec(
            (
                prop::sample::select(vec![
                    0, 8, 10, 20, 30, 11, 21, 31, 12, 22, 13, 40, 41, 42, 50, 51, 70, 71, 230,
                ]),
                prop::sample::select(vec![
                    "LINE", "ARC", "CIRCLE", "LWPOLYLINE", "SPLINE", "ELLIPSE", "POLYLINE", "VERTEX", "SEQEND", "1",
                    "-2.5", "1e300", "0", "3", "nan", "8",
                ]),
            ),
            0..60,
        ),
    ) {
        let text = drawing(4, &[&groups]);
        if let Ok(path) = dxf::read(&text, &[], TOLERANCE) {
            let (program, _) = write(&path, "a", &options(), &mut |_, _| true);
            let file = elite_syntax::SourceFile::new("a.script", &*program);
            prop_assert!(elite_syntax::parser::parse(&file).diagnostics.is_empty(), "{}", program);
        }
    }
}
