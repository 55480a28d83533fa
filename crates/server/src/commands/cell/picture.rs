//! A cell drawn from two sides: outlines of everything that has a shape, from above and from the front.

use controller::cell::Cell;
use controller::cell_world::{BodyShape, DetectorKind, GripperKind, Surface, WorldDescription};
use kinematics::{Pose, RpyPose};
use motion::CycleConfig;
use nalgebra::{Rotation3, Vector3};

use crate::plot::{Curve, Figure, PlotPanel};

/// Corners of a circle as it is drawn.
const CIRCLE_CORNERS: usize = 24;
/// How far a cup is drawn behind its rim, m.
const CUP_DEPTH: f64 = 0.015;
/// Half the width of a line of light as it is drawn, m.
const BEAM_HALF: f64 = 0.002;

/// Numbers of colours by kind.
const STANDS: usize = 0;
const MOVES: usize = 1;
const PART: usize = 2;
const SINK: usize = 3;
const DETECTOR: usize = 4;
const ON_FLANGE: usize = 5;

/// A solid of the picture: its name, the colour of its kind, and the corners of its convex pieces, base frame.
struct Solid {
    name: String,
    color: usize,
    pieces: Vec<Vec<[f64; 3]>>,
}

/// The picture of a cell; the arm stands at its default place.
pub(super) fn figure(
    cell: &Cell,
    world: Option<&WorldDescription>,
    config: &CycleConfig,
) -> Figure {
    let flange = config.model.forward(&config.home).base_from_flange;
    let mut solids = solids(cell, world);
    if let Some(world) = world {
        add_detectors(&mut solids, world);
    }
    add_flange(&mut solids, cell, world, &flange);
    let floor = world.and_then(|world| world.settings.floor);
    let from = |title: &str, y: &str, view: fn(&[f64; 3]) -> (f64, f64), floor: Option<f64>| {
        let mut panel = PlotPanel::plane(title, "x in mm", y);
        for solid in &solids {
            let outline = solid.pieces.iter().flat_map(|corners| {
                let corners = corners.iter().map(view);
                let outline = hull(corners.map(|(a, b)| (a * 1e3, b * 1e3)).collect());
                // What is no number ends a line.
                outline.into_iter().chain([(f64::NAN, f64::NAN)])
            });
            panel = panel.curve(Curve::new(&solid.name, outline).color_of(solid.color));
        }
        let frames = config.model.forward(&config.home);
        if let Some(height) = floor {
            let (left, right) = span(&solids, view);
            let ends = [left, right].map(|x| (x * 1e3, height * 1e3));
            panel = panel.curve(Curve::new("floor", ends).color_of(STANDS));
        }
        let mut joints = vec![[0.0; 3]];
        let places = frames.base_from_joint.iter();
        joints.extend(places.map(|frame| <[f64; 3]>::from(frame.translation)));
        joints.push(frames.base_from_flange.translation.into());
        let arm = joints.iter().map(view).map(|(a, b)| (a * 1e3, b * 1e3));
        panel.curve(Curve::new("arm", arm))
    };
    Figure::new("The cell")
        .panel(from("From above", "y in mm", |p| (p[0], p[1]), None))
        .panel(from("From the front", "z in mm", |p| (p[0], p[2]), floor))
        .size(1400, 700)
}

fn solids(cell: &Cell, world: Option<&WorldDescription>) -> Vec<Solid> {
    let mut solids = Vec::new();
    let obstacles = cell.standing_solids();
    for (name, shape, pose) in &obstacles {
        solids.push(Solid {
            name: name.clone(),
            color: STANDS,
            pieces: pieces(shape, pose),
        });
    }
    let Some(world) = world else { return solids };
    let is_still = |name: &str| obstacles.iter().any(|(standing, ..)| standing == name);
    for moved in world
        .obstacles
        .iter()
        .filter(|obstacle| !is_still(&obstacle.name))
    {
        solids.push(Solid {
            name: moved.name.clone(),
            color: MOVES,
            pieces: pieces(&moved.shape, &moved.pose),
        });
    }
    for conveyor in &world.conveyors {
        if let Surface::Turntable { center, radius } = conveyor.surface {
            let disc = BodyShape::Cylinder {
                radius,
                length: 0.01,
            };
            solids.push(Solid {
                name: conveyor.name.clone(),
                color: STANDS,
                pieces: pieces(&disc, &center),
            });
        }
    }
    for part in &world.parts {
        let sources = world
            .sources
            .iter()
            .filter(|source| source.part == part.name);
        let made = sources
            .map(|source| (source.name.clone(), source.pose))
            .collect::<Vec<_>>();
        let places = match made.is_empty() {
            true => copies(part),
            false => made,
        };
        solids.extend(places.into_iter().map(|(name, pose)| Solid {
            name,
            color: PART,
            pieces: pieces(&part.shape, &pose),
        }));
    }
    for sink in &world.sinks {
        solids.push(Solid {
            name: sink.name.clone(),
            color: SINK,
            pieces: pieces(&BodyShape::Box { size: sink.size }, &sink.pose),
        });
    }
    solids
}

/// What looks: beams and lines of sight, regions.
fn add_detectors(solids: &mut Vec<Solid>, world: &WorldDescription) {
    for detector in &world.detectors {
        let line = |from: [f64; 3], until: [f64; 3]| {
            [from, until]
                .iter()
                .flat_map(|end| [-BEAM_HALF, BEAM_HALF].map(|d| end.map(|x| x + d)))
                .collect()
        };
        let pieces = match detector.kind {
            DetectorKind::Beam { from, until } => vec![line(from, until)],
            DetectorKind::Presence { pose, size } => pieces(&BodyShape::Box { size }, &pose),
            DetectorKind::Distance { pose, range } => {
                let end = pose * Pose::from_translation(0.0, 0.0, range);
                vec![line(pose.translation.into(), end.translation.into())]
            }
        };
        solids.push(Solid {
            name: detector.name.clone(),
            color: DETECTOR,
            pieces,
        });
    }
}

/// What hangs on the flange: the tool, cups, open fingers.
fn add_flange(
    solids: &mut Vec<Solid>,
    cell: &Cell,
    world: Option<&WorldDescription>,
    flange: &Pose,
) {
    let mut add = |name: &str, shape: &BodyShape, pose: Pose| {
        solids.push(Solid {
            name: name.to_owned(),
            color: ON_FLANGE,
            pieces: pieces(shape, &(*flange * pose)),
        });
    };
    if let Some((tool, pose)) = cell.tool_solid() {
        add("tool", &tool, pose);
    }
    for gripper in world.iter().flat_map(|world| &world.grippers) {
        match &gripper.kind {
            GripperKind::Vacuum(vacuum) => {
                let direction = Vector3::from(vacuum.direction).normalize();
                // Any turn of z to the direction will do: a cup is round.
                let turn =
                    Rotation3::rotation_between(&Vector3::z(), &direction).unwrap_or_else(|| {
                        Rotation3::from_axis_angle(&Vector3::x_axis(), core::f64::consts::PI)
                    });
                let cup = BodyShape::Cylinder {
                    radius: vacuum.radius,
                    length: CUP_DEPTH,
                };
                for rim in &vacuum.cups {
                    let middle = Vector3::from(*rim) - direction * (CUP_DEPTH / 2.0);
                    add(&gripper.name, &cup, Pose::new(turn, middle));
                }
            }
            GripperKind::Fingers(fingers) => {
                let poses = fingers.poses(fingers.stroke).into_iter();
                for (shape, pose) in fingers.shapes().iter().zip(poses) {
                    add(&gripper.name, shape, pose);
                }
            }
        }
    }
}

/// From the leftmost to the rightmost corner of all solids, and of the arm's foot, m.
fn span(solids: &[Solid], view: fn(&[f64; 3]) -> (f64, f64)) -> (f64, f64) {
    let across = solids
        .iter()
        .flat_map(|solid| solid.pieces.iter().flatten())
        .map(|corner| view(corner).0);
    across.fold((0.0, 0.0), |(least, most), x| (x.min(least), x.max(most)))
}

fn copies(part: &controller::cell_world::PartDescription) -> Vec<(String, Pose)> {
    let Some(copies) = part.copies else {
        return vec![(part.name.clone(), part.pose)];
    };
    let [nx, ny, nz] = copies.count;
    let mut places = Vec::new();
    for (z, y, x) in
        (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (z, y, x))))
    {
        let shift = [x, y, z].map(|n| n as f64);
        let shift: [f64; 3] = core::array::from_fn(|k| shift[k] * copies.pitch[k]);
        let shift = Pose::from_rpy(&RpyPose::from_array([
            shift[0], shift[1], shift[2], 0.0, 0.0, 0.0,
        ]));
        places.push((part.name.clone(), part.pose * shift));
    }
    places
}

/// The corners of the convex pieces of a shape; a plane has none.
fn pieces(shape: &BodyShape, pose: &Pose) -> Vec<Vec<[f64; 3]>> {
    let circle = |radius: f64, z: f64| {
        (0..CIRCLE_CORNERS).map(move |k| {
            let angle = core::f64::consts::TAU * k as f64 / CIRCLE_CORNERS as f64;
            [radius * angle.cos(), radius * angle.sin(), z]
        })
    };
    let local: Vec<Vec<[f64; 3]>> = match *shape {
        BodyShape::Box { size } => {
            let corner = |k: usize| {
                let side = |axis: usize| if k >> axis & 1 == 0 { -0.5 } else { 0.5 };
                [side(0) * size[0], side(1) * size[1], side(2) * size[2]]
            };
            vec![(0..8).map(corner).collect()]
        }
        BodyShape::Cylinder { radius, length } => {
            let ends = [-length / 2.0, length / 2.0].map(|z| circle(radius, z));
            vec![ends.into_iter().flatten().collect()]
        }
        BodyShape::Sphere { radius } => {
            let rings = (0..7).flat_map(|k| {
                let z = radius * (f64::from(k) / 3.0 - 1.0);
                circle((radius * radius - z * z).max(0.0).sqrt(), z)
            });
            vec![rings.collect()]
        }
        BodyShape::Mesh(ref mesh) => {
            let pieces = mesh.pieces().iter().map(|piece| {
                let points = piece.body.points().iter();
                points.map(|point| (piece.middle + point).into()).collect()
            });
            pieces.collect()
        }
        BodyShape::Plane => Vec::new(),
    };
    let placed = |corner: [f64; 3]| pose.transform_point(corner.into()).into();
    let pieces = local.into_iter();
    pieces
        .map(|corners| corners.into_iter().map(placed).collect())
        .collect()
}

/// The convex outline of points in a plane, closed (Andrew's monotone chain).
fn hull(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let turns_left = |o: (f64, f64), a: (f64, f64), b: (f64, f64)| {
        (a.0 - o.0) * (b.1 - o.1) - (a.1 - o.1) * (b.0 - o.0) > 0.0
    };
    let chain = |points: &mut dyn Iterator<Item = (f64, f64)>| {
        let mut chain: Vec<(f64, f64)> = Vec::new();
        for point in points {
            while chain.len() >= 2
                && !turns_left(chain[chain.len() - 2], chain[chain.len() - 1], point)
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain
    };
    let mut outline = chain(&mut points.iter().copied());
    outline.extend(chain(&mut points.iter().rev().copied()));
    outline
}
