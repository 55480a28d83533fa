//! Cells whose shapes are meshes: felt, held, measured and refused as the solids that they are.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::result_large_err,
    reason = "a test fails by panicking"
)]

use std::fmt::Write as _;
use std::fs;
use std::sync::Arc;
use std::time::Duration;

use controller::cell::Cell;
use controller::clearance::collision_scene;
use controller::options::{PlantChoice, RecordTarget};
use controller::{ControllerConfig, NullObserver, SteppedController, WallTimeout};
use elite_runtime::ProgramText;
use kinematics::{JointPositions, Pose, RobotModel};
use motion_api::{RobotState, Seconds};
use recorder::{Recording, Setup};
use tempfile::TempDir;

const BRACKET_MM: &str = "bracket.stl";

/// A prism over a polygon whose first corner sees all others, as OBJ; the corners counterclockwise.
fn prism(corners: &[[f64; 2]], low: f64, high: f64) -> String {
    let count = corners.len();
    let mut text = String::new();
    for z in [low, high] {
        for [x, y] in corners {
            writeln!(text, "v {x} {y} {z}").unwrap();
        }
    }
    for k in 1..count - 1 {
        writeln!(text, "f 1 {} {}", k + 2, k + 1).unwrap();
        writeln!(text, "f {} {} {}", count + 1, count + k + 1, count + k + 2).unwrap();
    }
    for k in 0..count {
        let next = (k + 1) % count;
        writeln!(
            text,
            "f {} {} {} {}",
            k + 1,
            next + 1,
            count + next + 1,
            count + k + 1
        )
        .unwrap();
    }
    text
}

/// A box from one corner to the opposite one, as OBJ.
fn block(low: [f64; 3], high: [f64; 3]) -> String {
    let [[x0, y0, z0], [x1, y1, z1]] = [low, high];
    prism(&[[x0, y0], [x1, y0], [x1, y1], [x0, y1]], z0, z1)
}

/// An L of two bars of 40 mm, 200 mm long, 100 mm high, as text STL in mm.
fn bracket() -> String {
    let obj = prism(
        &[
            [40.0, 40.0],
            [40.0, 200.0],
            [0.0, 200.0],
            [0.0, 0.0],
            [200.0, 0.0],
            [200.0, 40.0],
        ],
        0.0,
        100.0,
    );
    let mut points: Vec<&str> = Vec::new();
    let mut text = String::from("solid bracket\n");
    for line in obj.lines() {
        match line.split_once(' ').unwrap() {
            ("v", point) => points.push(point),
            (_, face) => {
                let corners: Vec<usize> = face.split(' ').map(|k| k.parse().unwrap()).collect();
                for k in 1..corners.len() - 1 {
                    let [a, b, c] = [0, k, k + 1].map(|k| points[corners[k] - 1]);
                    write!(
                        text,
                        "facet normal 0 0 0\nouter loop\nvertex {a}\nvertex {b}\nvertex {c}\nendloop\nendfacet\n"
                    )
                    .unwrap();
                }
            }
        }
    }
    text + "endsolid bracket\n"
}

/// A folder with a cell file and the files that it names.
struct Folder(TempDir);

impl Folder {
    fn new(cell: &str, files: &[(&str, String)]) -> Self {
        let folder = TempDir::new().unwrap();
        fs::write(folder.path().join("cell.toml"), cell).unwrap();
        for (name, content) in files {
            fs::write(folder.path().join(name), content).unwrap();
        }
        Self(folder)
    }

    fn config(&self, plant: PlantChoice) -> ControllerConfig {
        ControllerConfig {
            cell: Some(self.0.path().join("cell.toml")),
            plant,
            ..ControllerConfig::default()
        }
    }

    fn open(&self, plant: PlantChoice) -> Bench {
        let config = self.config(plant);
        Bench(SteppedController::open(&config, Arc::new(NullObserver)).unwrap())
    }
}

struct Bench(SteppedController);

impl Bench {
    /// Runs a program, and says with what error it ended.
    fn run_to_end(&self, program: &str) -> (RobotState, Option<String>) {
        let text = ProgramText {
            name: "cell.script".to_owned(),
            text: program.to_owned(),
        };
        let mut patience = WallTimeout {
            wall: Duration::from_secs(120),
            keep_going: &mut || true,
        };
        let time = Seconds::new(60.0).unwrap();
        let result = self.0.run_program(text, time, &mut patience).unwrap();
        (self.0.state(), result.error.map(|error| error.to_string()))
    }

    fn run(&self, program: &str) -> RobotState {
        let (state, error) = self.run_to_end(program);
        assert_eq!(error, None);
        state
    }

    fn pose(&self, part: &str) -> Pose {
        let world = self.0.controller().world().unwrap().lock();
        world.part(part).unwrap().unwrap().pose
    }
}

fn close(a: &[f64], b: &[f64], tolerance: f64, what: &str) {
    let size = b.iter().fold(1e-3_f64, |most, x| most.max(x.abs()));
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() <= tolerance * size, "{what}: {a} and {b}");
    }
}

const SOFT: &str = "stiffness = 2e4\ndamping = 200\nfriction = 0.2";

fn bracket_as_mesh() -> Folder {
    let cell = format!(
        "[[obstacle]]\nname = 'bracket'\nshape = 'mesh'\nfile = '{BRACKET_MM}'\nscale = 0.001\n\
         pose = [-0.55, -0.2, 0.1, 0, 0, 0]\n{SOFT}\n"
    );
    Folder::new(&cell, &[(BRACKET_MM, bracket())])
}

/// The two bars, the second one without what the first one has.
fn bracket_as_boxes() -> Folder {
    let bar = |name: &str, size: &str, pose: &str| {
        format!(
            "[[obstacle]]\nname = '{name}'\nshape = 'box'\nsize = {size}\npose = {pose}\n{SOFT}\n"
        )
    };
    let cell = bar("long", "[0.2, 0.04, 0.1]", "[-0.45, -0.18, 0.15, 0, 0, 0]")
        + &bar(
            "short",
            "[0.04, 0.16, 0.1]",
            "[-0.53, -0.08, 0.15, 0, 0, 0]",
        );
    Folder::new(&cell, &[])
}

#[test]
fn a_bracket_is_two_pieces_and_has_its_volume() {
    let folder = bracket_as_mesh();
    let cell = Cell::load(&folder.0.path().join("cell.toml")).unwrap();
    let facts = cell.mesh_facts();
    assert_eq!(facts.len(), 1);
    assert_eq!((facts[0].pieces, facts[0].triangles), (2, 20));
    assert!(
        (facts[0].volume / 1.44e-3 - 1.0).abs() < 1e-6,
        "{:?}",
        facts[0]
    );
    assert!(facts[0].deviation < 2e-6, "{:?}", facts[0]);
    assert_eq!(
        facts[0].text().to_string(),
        "obstacle \"bracket\": bracket.stl has 20 triangles and 1440.0000 cm³, its convex pieces (2) keep within \
         0.000 mm"
    );
}

#[test]
fn a_mesh_is_felt_as_the_boxes_that_it_consists_of() {
    // Onto the middle of each bar, and onto the place where they meet.
    for at in ["-0.40, -0.18", "-0.53, -0.05", "-0.531, -0.161"] {
        let press = format!(
            "set_tcp([0, 0, 0.1, 0, 0, 0])\ndown = [3.141592653589793, 0, 0]\n\
             movel([{at}, 0.25] + down, a=1, v=0.3)\nmovel([{at}, 0.199] + down, a=0.3, v=0.02)\nsleep(0.5)\n"
        );
        for plant in [PlantChoice::Ideal, PlantChoice::Rigid] {
            let mesh = bracket_as_mesh().open(plant).run(&press);
            let boxes = bracket_as_boxes().open(plant).run(&press);
            close(&mesh.tcp_force, &boxes.tcp_force, 1e-4, at);
            close(&mesh.actual_q.0, &boxes.actual_q.0, 1e-7, at);
            assert!(
                (mesh.tcp_force[2] + 20.0).abs() < 1.0,
                "{:?}",
                mesh.tcp_force
            );
        }
    }
}

#[test]
fn distances_from_a_mesh_are_those_from_its_boxes() {
    let scene = |folder: &Folder| collision_scene(&folder.config(PlantChoice::Ideal)).unwrap();
    let (mesh, boxes) = (scene(&bracket_as_mesh()), scene(&bracket_as_boxes()));
    for k in 0..200 {
        let turn = f64::from(k) / 200.0;
        let q = JointPositions([
            2.0 * turn - 1.0,
            -1.4 - 0.6 * turn,
            1.9 - turn,
            -1.6,
            -1.5 + turn,
            0.3,
        ]);
        let (a, b) = (mesh.nearest(&q).unwrap(), boxes.nearest(&q).unwrap());
        assert!((a.distance - b.distance).abs() < 1e-5, "{k}: {a:?} {b:?}");
    }
}

/// A part whose frame is in its corner, a bar with a plate: its centre of mass is elsewhere.
const PART: &str = r#"
[world]
floor = -0.5
[[obstacle]]
name = "table"
shape = "box"
size = [0.6, 0.6, 0.05]
pose = [-0.45, 0.0, 0.125, 0, 0, 0]
[[part]]
name = "block"
shape = "mesh"
file = "block.obj"
mass = 0.4
pose = [-0.48, -0.25, 0.1501, 0, 0, 0]
[[gripper]]
name = "cup"
kind = "vacuum"
cups = [[0, 0, 0.1]]
radius = 0.01
pressure = 80000
on = "standard_digital_out[0]"
"#;

const LIFT: &str = "
set_tcp([0, 0, 0.1, 0, 0, 0])
down = [3.141592653589793, 0, 0]
movel([-0.46, -0.23, 0.25] + down, a=1, v=0.5)
movel([-0.46, -0.23, 0.2] + down, a=0.5, v=0.1)
set_standard_digital_out(0, True)
sleep(0.5)
movel([-0.46, -0.1, 0.4] + down, a=1, v=0.5)
sleep(2)
";

#[test]
fn a_held_mesh_acts_as_the_payload_that_it_is() {
    let held = Folder::new(PART, &[("block.obj", block([0.0; 3], [0.06, 0.08, 0.05]))]);
    let held = held.open(PlantChoice::Rigid);
    let standing = held.run(LIFT);
    let flange = RobotModel::built_in("cs66")
        .unwrap()
        .forward(&standing.actual_q)
        .base_from_flange;
    let flange_from_part = flange.inverse() * held.pose("block");
    let own = held
        .0
        .controller()
        .world()
        .unwrap()
        .lock()
        .part_mass(0)
        .unwrap();
    // Of a uniform box about its centre.
    close(own.com.as_slice(), &[0.03, 0.04, 0.025], 1e-9, "centre");
    let [xx, yy, zz] = [0.06_f64, 0.08, 0.05].map(|edge| edge * edge * 0.4 / 12.0);
    let diagonal = own.inertia.diagonal();
    close(
        diagonal.as_slice(),
        &[yy + zz, xx + zz, xx + yy],
        1e-6,
        "inertia",
    );
    let body = own.expressed_in(&flange_from_part);
    let (i, [x, y, z]) = (body.inertia, <[f64; 3]>::from(body.com));
    let cell = format!(
        "[payload]\nmass = 0.4\ncog = [{x}, {y}, {z}]\ninertia = [{}, {}, {}, {}, {}, {}]\n",
        i.m11, i.m22, i.m33, i.m12, i.m13, i.m23
    );
    let configured = Folder::new(&cell, &[]).open(PlantChoice::Rigid);
    configured.run(LIFT);
    let swing = "q = get_actual_joint_positions()\nq[0] = q[0] + 0.3\nmovej(q, a=1, v=1)\nsleep(2)";
    for (held, configured) in [
        (standing, configured.0.state()),
        (held.run(swing), configured.run(swing)),
    ] {
        close(&held.tcp_force, &configured.tcp_force, 1e-6, "force");
        close(
            &held.actual_torque.0,
            &configured.actual_torque.0,
            1e-6,
            "torque",
        );
    }
}

#[test]
fn a_mesh_falls_and_lies_as_its_box_does() {
    let drop = "sleep(2)\n";
    let mesh = PART.replace("0.1501, 0, 0, 0]", "0.17, 0, 0, 0]");
    let boxes = mesh
        .replace(
            "shape = \"mesh\"\nfile = \"block.obj\"",
            "shape = \"box\"\nsize = [0.06, 0.08, 0.05]",
        )
        .replace("[-0.48, -0.25, 0.17,", "[-0.45, -0.21, 0.195,");
    let mesh = Folder::new(&mesh, &[("block.obj", block([0.0; 3], [0.06, 0.08, 0.05]))]);
    let (mesh, boxes) = (
        mesh.open(PlantChoice::Ideal),
        Folder::new(&boxes, &[]).open(PlantChoice::Ideal),
    );
    mesh.run(drop);
    boxes.run(drop);
    let corner = mesh
        .pose("block")
        .transform_point([0.03, 0.04, 0.025].into());
    let middle = boxes.pose("block").translation;
    // A box that falls flat creeps by tenths of a millimetre, as a mesh does.
    assert!((corner - middle).norm() < 5e-4, "{corner} {middle}");
    assert!((middle.z - 0.175).abs() < 5e-4, "{middle}");
}

#[test]
fn fingers_of_meshes_close_on_a_part_as_boxes_do() {
    let cell = r#"
[world]
floor = -0.5
[[obstacle]]
name = "table"
shape = "box"
size = [0.6, 0.6, 0.05]
pose = [-0.45, 0.0, 0.125, 0, 0, 0]
[[part]]
name = "block"
shape = "box"
size = [0.04, 0.03, 0.05]
mass = 0.2
pose = [-0.45, -0.2, 0.175, 0, 0, 0]
[[gripper]]
name = "hand"
kind = "fingers"
stroke = 0.08
finger = { FINGER, pose = [0, 0.005, 0.1, 0, 0, 0] }
force = 40
speed = 0.1
close = "standard_digital_out[0]"
gripping = "standard_digital_in[0]"
"#;
    let program = "
set_tcp([0, 0, 0.12, 0, 0, 0])
down = [3.141592653589793, 0, 0]
movel([-0.45, -0.2, 0.3] + down, a=1, v=0.5)
movel([-0.45, -0.2, 0.18] + down, a=0.5, v=0.1)
set_standard_digital_out(0, True)
sleep(1)
movel([-0.45, -0.1, 0.4] + down, a=1, v=0.5)
sleep(1)
";
    let run = |finger: &str, files: &[(&str, String)]| {
        let bench = Folder::new(&cell.replace("FINGER", finger), files).open(PlantChoice::Ideal);
        let state = bench.run(program);
        assert_eq!(state.digital_in & 1, 1, "{finger}");
        (bench.pose("block"), state)
    };
    // The mesh is not symmetrical: a step of 3 mm in its lower half faces outwards.
    let stepped = prism(
        &[
            [-0.01, -0.005],
            [0.01, -0.005],
            [0.01, 0.005],
            [0.0, 0.008],
            [-0.01, 0.005],
        ],
        -0.02,
        0.02,
    );
    let (as_box, _) = run("size = [0.02, 0.01, 0.04]", &[]);
    let (as_mesh, _) = run(
        "shape = 'mesh', file = 'finger.obj'",
        &[("finger.obj", stepped)],
    );
    assert!((as_box.translation - as_mesh.translation).norm() < 1e-4);
    assert!(as_box.translation.z > 0.3, "{as_box:?}");
}

#[test]
fn a_tool_of_a_mesh_stays_on_the_allowed_side_of_a_plane() {
    let plane = "[[safety_plane]]\nname = 'floor'\npoint = [0, 0, 0.2]\nnormal = [0, 0, 1]\n";
    let tool = |shape: &str| format!("[tool]\n{shape}\npose = [0, 0, 0.05, 0, 0.3, 0]\n{plane}");
    // The second one goes down until the tool is at the plane, which the flange never reaches.
    let above = "down = [3.141592653589793, 0, 0]\nmovel([-0.45, -0.2, 0.4] + down, a=1, v=0.3)\n";
    let beyond = format!("{above}movel([-0.45, -0.2, 0.25] + down, a=1, v=0.3)\n");
    let down = format!("{above}speedl([0, 0, -0.1, 0, 0, 0], 0.5, 4)\n");
    let heights = [
        Folder::new(&tool("shape = 'box'\nsize = [0.04, 0.06, 0.1]"), &[]),
        Folder::new(
            &tool("shape = 'mesh'\nfile = 'tool.obj'"),
            &[("tool.obj", block([-0.02, -0.03, -0.05], [0.02, 0.03, 0.05]))],
        ),
    ]
    .map(|folder| {
        let (_, refused) = folder.open(PlantChoice::Ideal).run_to_end(&beyond);
        let (state, _) = folder.open(PlantChoice::Ideal).run_to_end(&down);
        (refused.unwrap(), state.actual_tcp_pose.xyz[2])
    });
    let [(box_refused, box_height), (mesh_refused, mesh_height)] = heights;
    assert!(box_refused.contains("behind safety plane"), "{box_refused}");
    assert_eq!(box_refused, mesh_refused);
    assert!(
        (box_height - mesh_height).abs() < 1e-6,
        "{box_height} {mesh_height}"
    );
    assert!((0.29..0.32).contains(&box_height), "{box_height}");
}

#[test]
fn a_recording_holds_the_meshes_that_its_run_needs() {
    let folder = bracket_as_mesh();
    let path = folder.0.path().join("run.mcap");
    let config = ControllerConfig {
        record: RecordTarget::File(path.clone()),
        ..folder.config(PlantChoice::Rigid)
    };
    let bench = Bench(SteppedController::open(&config, Arc::new(NullObserver)).unwrap());
    bench.run("sleep(0.1)\n");
    bench.0.shut_down().unwrap();
    fs::remove_file(folder.0.path().join(BRACKET_MM)).unwrap();
    fs::remove_file(folder.0.path().join("cell.toml")).unwrap();
    let recording = Recording::open(&path).unwrap();
    let setup = recording.setup().unwrap();
    assert_eq!(&setup.files[BRACKET_MM][..], bracket().as_bytes());
    let cell = Cell::of_recording(setup).unwrap().unwrap();
    assert_eq!(cell.mesh_facts()[0].pieces, 2);
    // Without the file there is no such cell.
    let lost = Setup {
        files: Default::default(),
        ..setup.clone()
    };
    let error = Cell::of_recording(&lost).unwrap_err().to_string();
    assert_eq!(
        error,
        "the recorded cell file: obstacle \"bracket\": bracket.stl: the file cannot be read: the recording does not \
         hold it"
    );
}

#[test]
fn each_mistake_with_a_mesh_has_one_sentence() {
    let obstacle = |keys: &str| {
        format!("[[obstacle]]\nname = 'bench'\nshape = 'mesh'\n{keys}\npose = [0, 0, 0, 0, 0, 0]\n")
    };
    let open_surface = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n".to_owned();
    let flat = block([0.0; 3], [1.0, 1.0, 0.0]);
    let files = [
        ("good.obj", block([0.0; 3], [0.1; 3])),
        ("open.obj", open_surface),
        ("flat.obj", flat),
        ("empty.stl", String::new()),
        ("nan.obj", "v nan 0 0\nf 1 1 1\n".to_owned()),
        ("far.obj", block([0.0; 3], [1000.0; 3])),
        ("image.png", String::from("no mesh")),
    ];
    let cells = [
        obstacle(""),
        obstacle("file = ''"),
        obstacle("file = 'good.obj'\nsize = [1, 1, 1]"),
        obstacle("file = 'good.obj'\nscale = 0"),
        obstacle("file = 'good.obj'\nscale = -1"),
        obstacle("file = 'good.obj'\npieces = 0"),
        obstacle("file = 'good.obj'\npieces = 257"),
        obstacle("file = 'good.obj'\npieces = -1"),
        obstacle("file = 'none.obj'"),
        obstacle("file = '../good.obj'"),
        obstacle("file = '/etc/passwd.obj'"),
        obstacle("file = 'image.png'"),
        obstacle("file = 'open.obj'"),
        obstacle("file = 'flat.obj'"),
        obstacle("file = 'empty.stl'"),
        obstacle("file = 'nan.obj'"),
        obstacle("file = 'far.obj'"),
        "[[obstacle]]\nname = 'bench'\nshape = 'box'\nsize = [1, 1, 1]\nfile = 'good.obj'\n\
         pose = [0, 0, 0, 0, 0, 0]\n"
            .to_owned(),
        "[tool]\nshape = 'mesh'\nfile = 'open.obj'\npose = [0, 0, 0, 0, 0, 0]\n".to_owned(),
        "[[part]]\nname = 'p'\nshape = 'mesh'\nfile = 'open.obj'\nmass = 1\n".to_owned(),
        "[[part]]\nname = 'p'\nshape = 'mesh'\nmass = 1\n".to_owned(),
        "[[part]]\nname = 'p'\nshape = 'plane'\nmass = 1\n".to_owned(),
        "[[gripper]]\nname = 'g'\nkind = 'fingers'\nstroke = 0.1\nforce = 1\nspeed = 0.1\n\
         close = 'tool_digital_out[0]'\n\
         finger = { shape = 'mesh', file = 'none.obj', pose = [0, 0, 0, 0, 0, 0] }\n"
            .to_owned(),
    ];
    let sentences = cells.map(|cell| {
        let folder = Folder::new(&cell, &files);
        let path = folder.0.path().join("cell.toml");
        let error = Cell::load(&path).unwrap_err().to_string();
        error.replace(&path.display().to_string(), "cell.toml")
    });
    insta::assert_snapshot!(sentences.join("\n"));
}
