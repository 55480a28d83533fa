//! Files: recordings, cells, configuration, models, points, names of tasks.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use controller::cell::Cell;
use controller::recorded_run::RecordedRun;
use elite_runtime::micro_line::{MicroLine, Space, Units};
use elite_runtime::task_folder::TaskFolder;
use kinematics::{Calibration, RobotModel};
use messages::Language;
use program_import::toolpath;
use recorder::{Recording, Summary, Topic, TopicTable};
use server::cli::{ControllerArgs, ServeArgs};
use server::commands::replay::rerun::rerun;
use server::config::ServeConfig;

use super::cell_worlds::ask_all;
use super::{Target, as_they_are, files_of};
use crate::mcap_file;

pub(super) const TARGETS: &[Target] = &[
    Target {
        name: "recording",
        about: "MCAP: summary, tables and entries of records that are damaged inside their chunk",
        check: |data| read_all(data),
        render_input: mcap_file::wrap_records,
        seeds: mcap_file::seeds,
        words: &[
            b"/cycle",
            b"/external",
            b"protobuf",
            b"jsonschema",
            b"json",
            b"elite.Cycle",
            b"zstd",
            b"lz4",
            b"{\"",
            b"null",
        ],
        bytes_max: 60_000,
    },
    Target {
        name: "rerun",
        about: "MCAP: a recording with a damaged setup or commands is run again",
        check: |data| {
            if let Ok(recording) = Recording::from_bytes(data, "fuzz.mcap") {
                _ = rerun(&recording);
            }
        },
        render_input: mcap_file::wrap_records,
        seeds: mcap_file::seeds,
        words: &[b"1e999", b"-1", b"\"urdf\"", b"MoveJ", b"movel", b"null"],
        bytes_max: 60_000,
    },
    Target {
        name: "urscript",
        about: "programs of Universal Robots; what comes out of them is read again",
        check: |data| {
            let text = String::from_utf8_lossy(data);
            match program_import::translate::translate(&text, "fuzz") {
                Ok(translation) => {
                    let file = elite_syntax::SourceFile::new("fuzz.script", &*translation.text);
                    _ = elite_syntax::check(file, &elite_syntax::KnownNames::default());
                    assert!(!translation.report("fuzz", Language::English).is_empty());
                }
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        },
        render_input: as_they_are,
        seeds: || files_of(&["tests/universal_robots"], ".urscript"),
        words: &[
            b"def ",
            b"thread ",
            b"end\n",
            b"p[",
            b"[",
            b"]",
            b"global ",
            b"local ",
            b"run ",
            b"movej(",
            b"struct(",
            b"xor",
            b"elif ",
            b"\"",
            b"$ ",
            b"#",
            b"0x",
            b"1e999",
            b"enter_critical",
            b".append(",
        ],
        bytes_max: 3000,
    },
    Target {
        name: "toolpath",
        about: "G-code, drawings and tables of points, and the programs that they become",
        check: |data| {
            let text = String::from_utf8_lossy(data);
            let paths = [
                toolpath::gcode::read(&text, 1e-5),
                toolpath::dxf::read(&text, &[], 1e-5),
                toolpath::csv::read(&text, 0.001),
            ];
            for path in paths {
                match path {
                    Ok(path) => {
                        let options = toolpath::program::ProgramOptions {
                            frame: kinematics::RpyPose::default(),
                            tool_axis: [0.0, 0.0, -1.0],
                            speed: None,
                            speed_factor: 1.0,
                            tolerance: 5e-5,
                            on: None,
                            off: None,
                            lead_in: 0.01,
                            lifts: true,
                        };
                        let (text, _) =
                            toolpath::program::write(&path, "fuzz", &options, &mut |_, _| true);
                        let file = elite_syntax::SourceFile::new("fuzz.script", &*text);
                        assert!(elite_syntax::parser::parse(&file).diagnostics.is_empty());
                    }
                    Err(error) => assert!(!error.to_string().is_empty()),
                }
            }
        },
        render_input: as_they_are,
        seeds: || {
            let texts = [
                "G21 G90\nG0 X1 Y2 Z3\nG1 X10 F600\nG2 X20 R5\nG3 X0 I-10 J0 Z2\nM3\nG4 P0.5\nM5\nM30\n",
                "0\nSECTION\n2\nENTITIES\n0\nLINE\n10\n0\n20\n0\n11\n10\n21\n5\n0\nARC\n10\n1\n20\n2\n40\n3\n50\n0\n\
                 51\n90\n0\nENDSEC\n",
                "0\nSECTION\n2\nENTITIES\n0\nSPLINE\n71\n1\n40\n0\n40\n0\n40\n1\n40\n1\n10\n0\n20\n0\n10\n5\n20\n5\n0\n\
                 ENDSEC\n",
                "0\nSECTION\n2\nENTITIES\n0\nLWPOLYLINE\n70\n1\n10\n0\n20\n0\n42\n0.5\n10\n9\n20\n0\n0\nENDSEC\n",
                "x;y;z;rx;ry;rz\n1,5;2;3;0;3,14;0\n2;2;3;0;3,14;0\n",
            ];
            texts.map(|text| text.as_bytes().to_vec()).to_vec()
        },
        words: &[
            b"G2",
            b"G91",
            b"G18",
            b"R-1",
            b"1e9",
            b"-0",
            b"nan",
            b"inf",
            b"10\n",
            b"42\n",
            b"CIRCLE",
            b"ELLIPSE",
            b"POLYLINE",
            b"VERTEX",
            b"SEQEND",
            b"210\n1\n",
            b"230\n-1\n",
            b"\n",
            b";",
            b"(",
        ],
        bytes_max: 3000,
    },
    Target {
        name: "cell",
        about: "cell files, and the first cycles of their worlds",
        check: |data| {
            let text = String::from_utf8_lossy(data).into_owned();
            match Cell::from_text(text, Path::new("fuzz.toml")) {
                Ok(cell) => ask_all(&cell),
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        },
        render_input: as_they_are,
        seeds: || {
            let mut seeds = files_of(&["crates/dev/seeds/cell", "tests", "docs"], ".toml");
            seeds.extend(files_of(&["examples/cells"], "cell.toml"));
            seeds.extend(blocks_of("docs/cell.md", "toml"));
            seeds.extend(blocks_of("docs/IO.md", "toml"));
            seeds
        },
        words: &[
            b"[[obstacle]]\n",
            b"[[wire]]\n",
            b"[[input]]\n",
            b"[[wrench]]\n",
            b"[[conveyor]]\n",
            b"[[safety_plane]]\n",
            b"[[safety_input]]\n",
            b"[[serial]]\n",
            b"[[modbus]]\n",
            b"[limits]\n",
            b"[sensor]\n",
            b"[tool]\n",
            b"[world]\n",
            b"[[part]]\n",
            b"[[gripper]]\n",
            b"[[source]]\n",
            b"[[sink]]\n",
            b"[[detector]]\n",
            b"[[actuator]]\n",
            b"[[fault]]\n",
            b"[[friction]]\n",
            b"[[touch]]\n",
            b"mass = 1e-6\n",
            b"mass = 1e4\n",
            b"density = 1\n",
            b"copies = [5, 5, 8]\n",
            b"pitch = [0, 0, 1]\n",
            b"restitution = 1\n",
            b"friction = 10\n",
            b"shape = \"plane\"\n",
            b"shape = \"cylinder\"\nsize = [0.01, 1]\n",
            b"kind = \"fingers\"\n",
            b"kind = \"rotary\"\n",
            b"every = 0.004\n",
            b"what = \"open\"\n",
            b"duration = 0.004\n",
            b"0.004",
            b"nan",
            b"inf",
            b"-inf",
            b"[",
            b"]",
            b"{",
            b"}",
            b" = ",
            b"\"",
            b"\n",
        ],
        bytes_max: 4000,
    },
    Target {
        name: "config",
        about: "configuration files",
        check: |data| {
            let path = scratch();
            if std::fs::write(&path, data).is_err() {
                return;
            }
            let shared = ControllerArgs {
                config: Some(path),
                ..ControllerArgs::default()
            };
            if let Err(error) = ServeConfig::load(ServeArgs {
                shared,
                ..ServeArgs::default()
            }) {
                assert!(!error.to_string().is_empty());
            }
        },
        render_input: as_they_are,
        seeds: || {
            let lines = [
                "model = \"cs66\"\nclock = \"virtual\"\nstep-ms = 2\nplant = \"ideal\"\n",
                "home = [0, -1.57, 0, -1.57, 0, 0]\npayload = \"1.5,0,0,0.1\"\ntcp = \"0,0,0.1,0,0,0\"\nseed = 7\n",
                "primary-port = 0\nhttp-port = \"off\"\nbind = \"::1\"\nallow = [\"fs\", \"net\"]\n",
                "record = \"a.mcap\"\nrecord-rotate = \"100MB\"\nrecord-budget = \"2GB\"\nlog-format = \"json\"\n",
            ];
            lines.map(|text| text.as_bytes().to_vec()).to_vec()
        },
        words: &[
            b"step-ms", b"step_ms", b"model", b"allow", b"bind", b"[", b"]", b"\"\"\"", b"nan",
            b"99999", b"-1", b"\n",
        ],
        bytes_max: 1000,
    },
    Target {
        name: "urdf",
        about: "URDF models",
        check: |data| match RobotModel::from_urdf(&String::from_utf8_lossy(data)) {
            Ok(model) => {
                let pose = model.flange_pose(&kinematics::JointPositions([0.3; 6]));
                _ = (
                    model.inverse_all(&pose, &kinematics::Pose::IDENTITY),
                    model.dh(),
                );
            }
            Err(error) => assert!(!error.to_string().is_empty()),
        },
        render_input: as_they_are,
        seeds: || files_of(&["robots/cs66", "robots/cs620"], ".urdf"),
        words: &[
            b"<link ",
            b"<joint ",
            b"/>",
            b"xyz=\"0 0 0\"",
            b"rpy=\"nan 0 0\"",
            b"type=\"fixed\"",
            b"1e308",
            b"<parent link=\"",
            b"-",
        ],
        bytes_max: 40_000,
    },
    Target {
        name: "mesh",
        about: "STL, OBJ, glTF and GLB, by the first byte; what is a solid is cut into pieces",
        check: check_mesh,
        render_input: as_they_are,
        seeds: mesh_seeds,
        words: &[
            b"solid\n",
            b"facet normal 0 0 1\nouter loop\n",
            b"vertex 1 0 1e-3\n",
            b"endloop\nendfacet\n",
            b"endsolid\n",
            b"v 1 2 3\n",
            b"f 1 2 3 4\n",
            b"f -1//2 -2 -3\n",
            b"glTF\x02\0\0\0",
            b"JSON",
            b"BIN\0",
            b"\"count\":1000000000",
            b"\"children\":[0]",
            b"\"byteOffset\":18446744073709551615",
            b"\"sparse\":",
            b"\"uri\":\"../x\"",
            b"nan",
            b"1e308",
        ],
        bytes_max: 4000,
    },
    Target {
        name: "calibration",
        about: "calibration files",
        check: |data| {
            let text = String::from_utf8_lossy(data);
            let read = Calibration::from_text(&text, Path::new("arm.toml"));
            match read.and_then(|calibration| Ok((calibration.open()?, calibration))) {
                Ok((model, calibration)) => {
                    let again =
                        Calibration::from_text(&calibration.to_toml(), Path::new("arm.toml"));
                    assert_eq!(again.ok().as_ref(), Some(&calibration));
                    let pose = model.flange_pose(&kinematics::JointPositions([0.3; 6]));
                    for q in &model.inverse_all(&pose, &kinematics::Pose::IDENTITY) {
                        let reached = model.flange_pose(q).translation;
                        assert!((reached - pose.translation).norm() < 1e-9);
                    }
                }
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        },
        render_input: as_they_are,
        seeds: || files_of(&["robots/calibrations"], ".toml"),
        words: &[
            b"model",
            b"[modified_dh]",
            b"theta = [0, 0, 0, 0, 0, 0.01]",
            b"alpha",
            b"1e-3",
            b"-0.0",
            b"nan",
            b"inf",
            b"1e308",
            b"0.05",
        ],
        bytes_max: 2000,
    },
    Target {
        name: "points",
        about: "files of points for micro lines, with as many points as a file may have",
        check: |data| {
            let text = String::from_utf8_lossy(data);
            for (space, units) in [
                (Space::Joint, Units::Si),
                (Space::Cartesian, Units::DegreesOrMillimetres),
            ] {
                match MicroLine::parse(&text, space, units, 0.004) {
                    Ok(line) => assert!(line.count() >= 2 && line.interval() == 0.004),
                    Err(error) => assert!(error.to_string().len() < 300),
                }
            }
        },
        render_input: as_they_are,
        seeds: || vec![b"# points\n0, 1, 2, 3, 4, 5\n0 1 2 3 4 5.5\n\n1e-3,0,0,0,0,0\n".to_vec()],
        words: &[
            b"\n",
            b", ",
            b"\t",
            b"#",
            b"nan",
            b"1e999",
            b"-",
            b"0x1",
            b"\r",
            b"1,2,3,4,5,6\n",
        ],
        bytes_max: 2000,
    },
    Target {
        name: "task_names",
        about: "names of tasks and files that a client gives: never outside of the folder",
        check: |data| {
            let folder = TaskFolder::new("/nowhere/tasks");
            let name = String::from_utf8_lossy(data);
            assert!(
                folder.task(&name).is_err()
                    && folder.points(&name).is_err()
                    && folder.file(&name).is_err()
            );
            let root = TaskFolder::new(fenced());
            let task = root.task(&name).map(|task| task.text);
            for found in [task, root.points(&name), root.file(&name)]
                .into_iter()
                .flatten()
            {
                assert_eq!(found, "inside", "{name:?} leaves the folder");
            }
        },
        render_input: as_they_are,
        seeds: || {
            vec![
                b"a.task".to_vec(),
                b"../outside.task".to_vec(),
                b"sub/b.script".to_vec(),
                b"/etc/passwd".to_vec(),
            ]
        },
        words: &[
            b"..",
            b"/",
            b"\\",
            b"\0",
            b"./",
            b"a",
            b".task",
            b".script",
            b".txt",
            b"%2e",
            b"sub",
            b"outside",
            b"link",
            b"\xe2\x80\xae",
        ],
        bytes_max: 60,
    },
];

/// Reads a recording in every way there is.
fn read_all(data: &[u8]) {
    let recording = match Recording::from_bytes(data, "fuzz.mcap") {
        Ok(recording) => recording,
        Err(error) => {
            assert!(!error.to_string().is_empty());
            return;
        }
    };
    _ = Summary::summarize(&recording, None);
    if let Ok(run) = RecordedRun::read(&recording) {
        _ = (
            run.unrecorded_input(),
            run.programs().count(),
            run.repeat().programs().count(),
        );
    }
    if let Ok(entries) = recording.entries(&Topic::ALL) {
        entries.for_each(|entry| _ = entry);
    }
    for topic in Topic::ALL {
        if let Ok(table) = TopicTable::new(&recording, topic.name())
            && let Ok(rows) = table.rows()
        {
            rows.for_each(|row| _ = row);
        }
    }
}

/// The ending that the first byte of an input for meshes stands for.
fn mesh_name(data: &[u8]) -> &'static str {
    ["m.stl", "m.obj", "m.gltf", "m.glb"][usize::from(data.first().copied().unwrap_or(0)) % 4]
}

/// A mesh without its first byte, and no file beside it.
struct OneMesh<'a>(&'a [u8]);

impl mesh::MeshFiles for OneMesh<'_> {
    fn read(&mut self, path: &str, most: u64) -> Result<Vec<u8>, mesh::FileError> {
        assert!(
            !path.split('/').any(|name| name == ".."),
            "{path:?} leaves the folder"
        );
        if path.starts_with("m.") && self.0.len() as u64 <= most {
            return Ok(self.0.to_vec());
        }
        Err(mesh::FileError::Irregular)
    }
}

fn check_mesh(data: &[u8]) {
    let bytes = data.get(1..).unwrap_or_default();
    let found = mesh::read(mesh_name(data), 1.0, &mut OneMesh(bytes));
    match found.and_then(|mesh| mesh::Solid::new(Arc::new(mesh))) {
        Ok(solid) => {
            assert!(solid.volume() > 0.0);
            let pieces = mesh::convex_pieces(&solid, 4);
            assert!((1..=4).contains(&pieces.pieces().len()) && pieces.deviation() >= 0.0);
            for point in solid.mesh().points() {
                let beside =
                    |piece: &mesh::ConvexPiece| piece.body.distance(&(point - piece.middle)).0;
                let nearest = pieces
                    .pieces()
                    .iter()
                    .map(beside)
                    .fold(f64::INFINITY, f64::min);
                assert!(
                    nearest <= pieces.deviation() + 1e-6,
                    "{nearest} m beside the pieces"
                );
            }
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// A bracket with a hollow edge, as text in two formats, and a corner of a box as glTF.
fn mesh_seeds() -> Vec<Vec<u8>> {
    let front = [
        [0.0, 0.0],
        [3.0, 0.0],
        [3.0, 1.0],
        [1.0, 1.0],
        [1.0, 2.0],
        [0.0, 2.0],
    ];
    let mut obj = String::from("\u{1}");
    for y in [0, 1] {
        for [x, z] in front {
            obj += &format!("v {x} {y} {z}\n");
        }
    }
    obj += "f 4 5 6 1\nf 4 1 2 3\nf 10 7 12 11\nf 10 9 8 7\n";
    for one in 1..=6 {
        let next = one % 6 + 1;
        obj += &format!("f {one} {} {} {next}\n", one + 6, next + 6);
    }
    let corners = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"];
    let mut stl = String::from("\0solid a\n");
    for face in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]] {
        let [a, b, c] = face.map(|corner| corners[corner]);
        stl += &format!(
            "facet normal 0 0 0\nouter loop\nvertex {a}\nvertex {b}\nvertex {c}\nendloop\nendfacet\n"
        );
    }
    stl += "endsolid a\n";
    // Four positions and twelve indices of one byte.
    let data = "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAIBAAEDAQIDAAMC";
    let gltf = format!(
        "\u{2}{{\"asset\":{{\"version\":\"2.0\"}},\"nodes\":[{{\"mesh\":0,\"scale\":[1,2,1]}}],\
         \"meshes\":[{{\"primitives\":[{{\"attributes\":\
         {{\"POSITION\":0}},\"indices\":1}}]}}],\
         \"accessors\":[{{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"}},\
         {{\"bufferView\":0,\"byteOffset\":48,\"componentType\":5121,\"count\":12,\"type\":\"SCALAR\"}}],\
         \"bufferViews\":[{{\"buffer\":0,\"byteLength\":60}}],\
         \"buffers\":[{{\"byteLength\":60,\"uri\":\"data:;base64,{data}\"}}]}}"
    );
    [obj, stl, gltf].map(String::into_bytes).to_vec()
}

/// The fenced examples of a page.
fn blocks_of(page: &str, language: &str) -> Vec<Vec<u8>> {
    let path = format!("{}/../../{page}", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let fence = format!("```{language}\n");
    let blocks = text
        .split(&fence)
        .skip(1)
        .filter_map(|rest| rest.split("```").next());
    blocks.map(|block| block.as_bytes().to_vec()).collect()
}

/// A file of this process.
fn scratch() -> PathBuf {
    std::env::temp_dir().join(format!("campaign-config-{}.toml", std::process::id()))
}

/// A folder with files in it and others beside it.
fn fenced() -> PathBuf {
    thread_local! {
        static FOLDER: RefCell<Option<PathBuf>> = const { RefCell::new(None) };
    }
    FOLDER.with_borrow_mut(|folder| {
        folder
            .get_or_insert_with(|| {
                let around = std::env::temp_dir().join("campaign-tasks");
                let inside = around.join("tasks");
                _ = std::fs::create_dir_all(inside.join("sub"));
                for name in ["a.task", "a", "b.script", "sub/b.script", "sub/a.txt"] {
                    _ = std::fs::write(inside.join(name), "inside");
                }
                for name in ["outside.task", "outside", "outside.txt"] {
                    _ = std::fs::write(around.join(name), "outside");
                }
                inside
            })
            .clone()
    })
}
