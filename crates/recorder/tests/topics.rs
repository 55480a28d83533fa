//! Every topic carries its schema, and what the schema says is what is in the messages.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use crate::support;

use std::collections::HashMap;
use std::sync::OnceLock;

use kinematics::{JointPositions, Pose, RpyPose};
use motion_api::{Record, RobotState};
use recorder::{CHUNK_BYTES, LogLevel, ObstacleShape, Recording, Topic, TopicTable};
use support::*;

const CYCLES: u64 = 250;

/// One second of motion with something in every topic.
fn file() -> &'static [u8] {
    static FILE: OnceLock<Vec<u8>> = OnceLock::new();
    FILE.get_or_init(|| {
        let out = Shared::default();
        let (mut motion, _script, recorder, handle) = start(out.clone(), config());
        let program = motion_api::ProgramId(1);
        handle.program_started(0.0, program, "a.script", "global x\nx = 1\n");
        handle.variable(0.0, program, "x", "int", "1");
        push(&mut motion, command(1, 1, movej(0.5)));
        for cycle in 1..=CYCLES {
            let mut state = state(cycle);
            state.tcp_offset = RpyPose::from_array([0.0, 0.0, 0.1, 0.0, 0.0, 0.0]);
            let tcp = Pose::from_rpy(&state.tcp_offset);
            state.actual_tcp_pose = model().tcp_pose(&state.actual_q, &tcp).to_rpy();
            state.digital_out = u64::from(cycle > 100);
            push(&mut motion, Record::Cycle(state));
        }
        handle.log(
            CYCLES as f64 * STEP,
            LogLevel::Warning,
            "motion",
            &messages::Text::verbatim("slow here"),
        );
        drop(motion);
        recorder.finish().unwrap();
        out.bytes()
    })
}

/// Rows of a topic, each a map from column to cell.
fn rows(recording: &Recording, topic: Topic) -> Vec<HashMap<String, String>> {
    let table = TopicTable::new(recording, topic.name()).unwrap();
    let columns = table.columns().to_vec();
    let rows = table.rows().unwrap().map(|row| {
        let cells = columns.iter().cloned().zip(row.unwrap());
        cells
            .filter_map(|(name, cell)| Some((name, cell?)))
            .collect()
    });
    rows.collect()
}

fn number(row: &HashMap<String, String>, column: &str) -> f64 {
    let cell = row
        .get(column)
        .unwrap_or_else(|| panic!("no column {column}"));
    cell.parse().unwrap()
}

#[test]
fn the_schema_of_a_cycle_names_every_field_of_the_state() {
    let recording = Recording::from_bytes(file(), "test").unwrap();
    let rows = rows(&recording, Topic::Cycle);
    assert_eq!(rows.len() as u64, CYCLES);
    let row = &rows[99];
    let expected = RobotState {
        cycle: 100,
        ..state(100)
    };
    assert_eq!(row["cycle"], "100");
    assert_eq!(number(row, "time"), expected.time);
    for i in 0..6 {
        assert_eq!(number(row, &format!("target_q_{i}")), expected.target_q[i]);
        assert_eq!(
            number(row, &format!("actual_torque_{i}")),
            expected.actual_torque[i]
        );
        assert_eq!(
            number(row, &format!("tcp_force_{i}")),
            expected.tcp_force[i]
        );
    }
    assert_eq!(row["mode"], "movej");
    assert_eq!((&*row["robot_mode"], &*row["safety_mode"]), ("7", "1"));
    // Everything in the struct is in the schema, under the same name.
    for (field, _) in recorder::CycleMessage::default().fields() {
        assert!(
            row.contains_key(field) || row.contains_key(&format!("{field}_0")),
            "{field}"
        );
    }
}

#[test]
fn every_topic_is_there_with_a_schema_and_messages() {
    let bytes = file();
    let summary = mcap::Summary::read(bytes).unwrap().unwrap();
    let recording = Recording::from_bytes(bytes, "test").unwrap();
    for topic in Topic::ALL {
        let mut channels = summary.channels.values();
        let channel = channels.find(|c| c.topic == topic.name()).unwrap();
        assert_eq!(channel.message_encoding, topic.message_encoding());
        let schema = channel.schema.as_ref().unwrap();
        if schema.encoding == "jsonschema" {
            let schema: serde_json::Value = serde_json::from_slice(&schema.data).unwrap();
            assert_eq!(schema["type"], "object", "{}", topic.name());
        }
        assert!(!rows(&recording, topic).is_empty(), "{}", topic.name());
    }
}

#[test]
fn viewers_get_a_picture_fifty_times_a_second() {
    let recording = Recording::from_bytes(file(), "test").unwrap();
    let seconds = CYCLES as f64 * STEP;
    for topic in [Topic::JointStates, Topic::Tf, Topic::Tcp] {
        let count = rows(&recording, topic).len() as f64;
        assert!(
            count / seconds >= 50.0,
            "{}: {count} in {seconds} s",
            topic.name()
        );
    }
}

/// The arm stands in its pose of cycle 1 and is pushed with `force`, N in the TCP frame.
fn standing(cycle: u64, force: [f64; 3]) -> Record {
    let mut standing = RobotState {
        cycle,
        time: cycle as f64 * STEP,
        ..state(1)
    };
    standing.tcp_force[..3].copy_from_slice(&force);
    Record::Cycle(standing)
}

fn scene_times(records: impl IntoIterator<Item = Record>) -> Vec<f64> {
    let recording = Recording::from_bytes(record(records), "test").unwrap();
    let scenes = rows(&recording, Topic::Scene);
    scenes.iter().map(|row| number(row, "log_time")).collect()
}

#[test]
fn an_arm_that_stands_is_drawn_at_the_start_and_every_ten_seconds() {
    // 25 s with a cycle now and then.
    let cycles = (100..=6250).step_by(50);
    let quiet = cycles.map(|cycle| standing(cycle, [0.0, 0.0, 0.9]));
    assert_eq!(scene_times(quiet), [0.0, 10.0, 20.0]);
}

#[test]
fn an_arm_that_moves_or_is_pushed_is_drawn_ten_times_a_second() {
    let moving = scene_times((1..=500).map(|cycle| Record::Cycle(state(cycle))));
    assert!((19..=21).contains(&moving.len()), "{moving:?}");
    // A push begins at 1 s and stays the same.
    let pushed =
        (1..=500).map(|cycle| standing(cycle, [0.0, 0.0, if cycle < 250 { 0.0 } else { 20.0 }]));
    let pushed = scene_times(pushed);
    assert_eq!(pushed.len(), 2, "{pushed:?}");
    assert!((pushed[1] - 1.0).abs() <= 0.02, "{pushed:?}");
}

#[test]
fn the_scene_shows_obstacles_the_way_of_the_tcp_and_the_force_on_it() {
    let obstacle = |name: &str, shape| recorder::SceneObstacle {
        name: name.to_owned(),
        shape,
        pose: kinematics::RpyPose::from_array([0.5, 0.1, 0.2, 0.0, 0.0, 0.0]),
    };
    let out = Shared::default();
    let config = recorder::RecorderConfig {
        obstacles: vec![
            obstacle("bench", ObstacleShape::Box([1.0, 0.6, 0.4])),
            obstacle(
                "post",
                ObstacleShape::Cylinder {
                    radius: 0.05,
                    length: 0.8,
                },
            ),
            obstacle("ball", ObstacleShape::Sphere { radius: 0.1 }),
            obstacle("floor", ObstacleShape::Plane),
        ],
        ..config()
    };
    let (mut motion, _script, recorder, _handle) = start(out.clone(), config);
    for cycle in 1..=300 {
        push(&mut motion, Record::Cycle(state(cycle)));
    }
    recorder.finish().unwrap();
    let recording = Recording::from_bytes(out.bytes(), "test").unwrap();
    let scenes = rows(&recording, Topic::Scene);
    let last = scenes.last().unwrap();
    // Eight entities are the arm and its TCP.
    let cell = |name: &str| number(last, name);
    assert_eq!(last["entities_8.id"], "obstacle/bench");
    assert_eq!(cell("entities_8.cubes_0.size.y"), 0.6);
    assert_eq!(cell("entities_8.cubes_0.pose.position.x"), 0.5);
    assert_eq!(cell("entities_9.cylinders_0.size.x"), 0.1);
    assert_eq!(cell("entities_9.cylinders_0.size.z"), 0.8);
    assert_eq!(cell("entities_10.spheres_0.size.z"), 0.2);
    // The upper face of the plate is the plane.
    let middle = cell("entities_11.cubes_0.pose.position.z");
    assert!((middle + cell("entities_11.cubes_0.size.z") / 2.0 - 0.2).abs() < 1e-12);

    assert_eq!(last["entities_12.id"], "tcp_trace");
    assert_eq!(last["entities_12.frame_id"], "base_link");
    let point = |scene: &HashMap<String, String>, i: usize| {
        [0, 1, 2].map(|k| {
            number(
                scene,
                &format!("entities_12.lines_0.points_{i}.{}", ["x", "y", "z"][k]),
            )
        })
    };
    let at_start = state(1).actual_tcp_pose.to_array();
    let first = point(last, 0);
    for axis in 0..3 {
        assert!((first[axis] - at_start[axis]).abs() < 1e-12);
    }
    assert!(
        scenes[0]
            .get("entities_12.lines_0.points_0.x")
            .is_none_or(|x| x.is_empty())
    );

    // The arrow has the direction of the force; at the last scene the state was `pushing`.
    assert_eq!(last["entities_13.frame_id"], "tcp");
    let pushing = (1..=300)
        .map(state)
        .filter(|state| state.time <= number(last, "log_time") + 1e-9)
        .rfind(|state| (state.cycle - 1).is_multiple_of(4))
        .unwrap();
    let force = nalgebra::Vector3::from_column_slice(&pushing.tcp_force[..3]);
    let turn = |name: &str| cell(&format!("entities_13.arrows_0.pose.orientation.{name}"));
    let turn = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(
        turn("w"),
        turn("x"),
        turn("y"),
        turn("z"),
    ));
    let shown = turn * nalgebra::Vector3::x();
    assert!((shown - force.normalize()).norm() < 1e-9, "{shown} {force}");
    let length =
        cell("entities_13.arrows_0.shaft_length") + cell("entities_13.arrows_0.head_length");
    assert!((length - 0.004 * force.norm()).abs() < 1e-12);
}

#[test]
fn bodies_take_the_place_of_obstacles_move_with_the_flange_and_go() {
    let out = Shared::default();
    let config = recorder::RecorderConfig {
        obstacles: vec![recorder::SceneObstacle {
            name: "door".to_owned(),
            shape: ObstacleShape::Box([0.4, 0.01, 0.3]),
            pose: kinematics::RpyPose::from_array([0.0; 6]),
        }],
        ..config()
    };
    let body = |id: &str, frame, x: f64, shape| recorder::SceneBody {
        id: id.into(),
        frame,
        pose: kinematics::Pose::from_translation(x, 0.0, 0.0),
        shape,
        color: [0.1, 0.2, 0.3, 0.4],
    };
    let base = recorder::SceneFrame::Base;
    let door = body(
        "obstacle/door",
        base,
        0.7,
        ObstacleShape::Box([0.4, 0.01, 0.3]),
    );
    let arrow = body(
        "belt/direction",
        base,
        0.1,
        ObstacleShape::Arrow { length: 0.5 },
    );
    let held = body(
        "part/box",
        recorder::SceneFrame::Flange,
        0.2,
        ObstacleShape::Sphere { radius: 0.1 },
    );
    let (mut motion, _script, recorder, handle) = start(out.clone(), config);
    handle.scene_bodies(0.0, [door.clone(), held, arrow].into());
    for cycle in 1..=200 {
        if cycle == 100 {
            handle.scene_bodies(state(cycle).time, [door.clone()].into());
        }
        push(&mut motion, Record::Cycle(state(cycle)));
    }
    recorder.finish().unwrap();
    let recording = Recording::from_bytes(out.bytes(), "test").unwrap();
    let scenes = rows(&recording, Topic::Scene);
    // Each drawing with the entities of it that are no part of the arm.
    let entity = |scene: &HashMap<String, String>, id: &str| {
        (0..20).find(|n| {
            scene
                .get(&format!("entities_{n}.id"))
                .is_some_and(|found| found == id)
        })
    };
    let first = scenes
        .iter()
        .find(|scene| entity(scene, "part/box").is_some());
    let first = first.expect("a scene with the part");
    let door = entity(first, "obstacle/door").unwrap();
    assert_eq!(
        number(first, &format!("entities_{door}.cubes_0.pose.position.x")),
        0.7
    );
    let doors = (0..20).filter(|n| {
        let id = first.get(&format!("entities_{n}.id"));
        id.is_some_and(|id| id == "obstacle/door")
    });
    assert_eq!(doors.count(), 1);
    let part = entity(first, "part/box").unwrap();
    assert_eq!(first[&format!("entities_{part}.frame_id")], "flange");
    assert_eq!(
        number(first, &format!("entities_{part}.spheres_0.color.b")),
        0.3
    );
    // An arrow of the viewers lies along x: along z it is turned by -90° about y.
    let arrow = entity(first, "belt/direction").unwrap();
    let turn = |name: &str| {
        number(
            first,
            &format!("entities_{arrow}.arrows_0.pose.orientation.{name}"),
        )
    };
    assert!((turn("y") + 0.5_f64.sqrt()).abs() < 1e-9 && (turn("w") - 0.5_f64.sqrt()).abs() < 1e-9);

    let last = scenes.last().unwrap();
    assert!(entity(last, "part/box").is_none() && entity(last, "obstacle/door").is_some());
    let deleted: Vec<&String> = scenes
        .iter()
        .flat_map(|scene| (0..4).filter_map(|n| scene.get(&format!("deletions_{n}.id"))))
        .filter(|id| !id.is_empty())
        .collect();
    assert_eq!(deleted, ["belt/direction", "part/box"]);
}

#[test]
fn the_frames_lead_from_the_base_to_the_tcp() {
    let recording = Recording::from_bytes(file(), "test").unwrap();
    let frames = rows(&recording, Topic::Tf);
    let (frames, tcp) = (frames.last().unwrap(), rows(&recording, Topic::Tcp));
    let tcp = tcp.last().unwrap();
    let mut pose = Pose::IDENTITY;
    let mut parent = "base_link".to_owned();
    for i in 0..8 {
        let cell = |name: &str| number(frames, &format!("transforms_{i}.{name}"));
        assert_eq!(frames[&format!("transforms_{i}.parent_frame_id")], parent);
        parent = frames[&format!("transforms_{i}.child_frame_id")].clone();
        let quaternion = nalgebra::Quaternion::new(
            cell("rotation.w"),
            cell("rotation.x"),
            cell("rotation.y"),
            cell("rotation.z"),
        );
        let rotation = nalgebra::UnitQuaternion::from_quaternion(quaternion);
        let translation = nalgebra::Vector3::new(
            cell("translation.x"),
            cell("translation.y"),
            cell("translation.z"),
        );
        pose = pose * Pose::new(rotation.to_rotation_matrix(), translation);
    }
    assert_eq!(parent, "tcp");
    for (axis, value) in ["x", "y", "z"].into_iter().zip(pose.translation.iter()) {
        let shown = number(tcp, &format!("pose.position.{axis}"));
        assert!((shown - value).abs() < 1e-9, "{axis}: {shown} and {value}");
    }
}

#[test]
fn the_arm_is_drawn_in_the_frames_that_are_sent() {
    let recording = Recording::from_bytes(file(), "test").unwrap();
    let scene = &rows(&recording, Topic::Scene)[0];
    let frames = &rows(&recording, Topic::Tf)[0];
    for i in 0..8 {
        let frame = &scene[&format!("entities_{i}.frame_id")];
        let sent = (0..8).any(|k| {
            frames[&format!("transforms_{k}.parent_frame_id")] == *frame
                || frames[&format!("transforms_{k}.child_frame_id")] == *frame
        });
        assert!(sent, "nothing tells where {frame} is");
        assert!(number(scene, &format!("entities_{i}.spheres_0.size.x")) > 0.0);
    }
    // The first capsule of the upper arm as a cylinder: as long and as wide, its axis from end to end.
    let capsule = model().collision().capsules(2)[0];
    let cell = |name: &str| number(scene, &format!("entities_2.cylinders_0.{name}"));
    let axis = capsule.p1 - capsule.p0;
    assert!((cell("size.z") - axis.norm()).abs() < 1e-12);
    assert!((cell("size.x") - 2.0 * capsule.radius).abs() < 1e-12);
    let turn = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(
        cell("pose.orientation.w"),
        cell("pose.orientation.x"),
        cell("pose.orientation.y"),
        cell("pose.orientation.z"),
    ));
    let drawn = turn * nalgebra::Vector3::z() * axis.norm();
    assert!((drawn - axis).norm() < 1e-9, "{drawn} and {axis}");
}

#[test]
fn chunks_are_small_compressed_and_short() {
    let bytes = file();
    let summary = mcap::Summary::read(bytes).unwrap().unwrap();
    assert!(summary.chunk_indexes.len() >= 4);
    for chunk in &summary.chunk_indexes {
        assert_eq!(chunk.compression, "zstd");
        assert!(chunk.uncompressed_size <= CHUNK_BYTES as u64, "{chunk:?}");
        assert!(
            chunk.message_end_time - chunk.message_start_time <= 250_000_000,
            "{chunk:?}"
        );
    }
    // Small chunks compress less, and a loaded machine makes more of them.
    let per_cycle = bytes.len() as f64 / CYCLES as f64;
    let allowed = 800.0 + 30.0 * summary.chunk_indexes.len() as f64;
    assert!(per_cycle < allowed, "{per_cycle} bytes a cycle");
}

#[test]
fn a_topic_that_is_not_there_is_an_error_that_names_those_there_are() {
    let recording = Recording::from_bytes(file(), "test").unwrap();
    let Err(error) = TopicTable::new(&recording, "/cycles") else {
        panic!("there is no /cycles")
    };
    assert_eq!(
        error.to_string(),
        "there is no topic /cycles in the recording; it has /command, /cycle, /io, /joint_states, /log, /scene, \
         /script, /tcp, /tf, /variables"
    );
}

#[test]
fn an_empty_topic_is_an_empty_table() {
    let recording = Recording::from_bytes(record([Record::Cycle(state(1))]), "test").unwrap();
    let table = TopicTable::new(&recording, "log").unwrap();
    assert_eq!(table.columns(), ["log_time"]);
    assert_eq!(table.rows().unwrap().count(), 0);
}

#[test]
fn joints_at_a_limit_are_counted_once_a_visit() {
    let limits = *model().limits();
    let at = |cycle, speed: f64| {
        let mut state = RobotState {
            time: cycle as f64 * STEP,
            cycle,
            ..RobotState::at_start(JointPositions::ZERO, STEP)
        };
        state.target_qd[2] = speed * limits.speed[2];
        Record::Cycle(state)
    };
    let bytes = record([at(1, 0.5), at(2, 1.0), at(3, -1.0), at(4, 0.2), at(5, 1.0)]);
    let recording = Recording::from_bytes(bytes, "test").unwrap();
    let summary = recorder::Summary::summarize(&recording, Some(&limits)).unwrap();
    let places: Vec<_> = summary.limits.iter().map(|l| (l.joint, l.time)).collect();
    assert_eq!(places, [(2, 0.008), (2, 0.02)]);
}
