//! Meshes in the viewers' topics: triangles seldom, poses as frames, everything that was given.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use crate::support;

use std::sync::Arc;

use foxglove::messages::{FrameTransforms, SceneEntity, SceneUpdate};
use kinematics::{Pose, RpyPose};
use mesh::Mesh;
use motion_api::{Record, RobotState};
use nalgebra::Vector3;
use proptest::prelude::*;
use prost::Message as _;
use recorder::{
    ObstacleShape, RecorderConfig, Recording, SceneBody, SceneFrame, SceneObstacle, ViewerMessages,
};
use support::*;

/// A strip of so many triangles along x.
fn strip(triangles: u32) -> Arc<Mesh> {
    let points = (0..triangles + 2).map(|n| Vector3::new(f64::from(n / 2), f64::from(n % 2), 0.5));
    let triangles = (0..triangles).map(|n| [n, n + 1, n + 2]);
    let mesh = Mesh::new("strip.stl", points.collect(), triangles.collect());
    Arc::new(mesh.unwrap())
}

fn body(id: &str, mesh: &Arc<Mesh>, frame: SceneFrame, x: f64) -> SceneBody {
    SceneBody {
        id: id.into(),
        frame,
        pose: Pose::from_translation(x, 0.0, 0.0),
        shape: ObstacleShape::Mesh(Arc::clone(mesh)),
        color: [0.1, 0.2, 0.3, 0.4],
    }
}

fn viewer(obstacles: Vec<SceneObstacle>) -> ViewerMessages {
    ViewerMessages::new(model(), obstacles, 0)
}

/// What a state makes: scenes and frames.
fn shown(viewer: &mut ViewerMessages, cycle: u64) -> (Vec<SceneUpdate>, Option<FrameTransforms>) {
    let (mut scenes, mut frames) = (Vec::new(), None);
    // The arm stands still, so that nothing else asks for a scene.
    let standing = RobotState {
        cycle,
        time: cycle as f64 * STEP,
        tcp_force: [0.0; 6],
        ..state(1)
    };
    let result: Result<(), std::convert::Infallible> = viewer.state(&standing, |topic, message| {
        match topic {
            recorder::Topic::Scene => {
                assert!(message.len() < 1 << 20, "{} bytes", message.len());
                scenes.push(SceneUpdate::decode(message).unwrap());
            }
            recorder::Topic::Tf => frames = Some(FrameTransforms::decode(message).unwrap()),
            _ => {}
        }
        Ok(())
    });
    result.unwrap();
    (scenes, frames)
}

/// Entities with triangles, in their order.
fn meshes(scenes: &[SceneUpdate]) -> Vec<SceneEntity> {
    let entities = scenes.iter().flat_map(|scene| &scene.entities);
    entities
        .filter(|entity| !entity.triangles.is_empty())
        .cloned()
        .collect()
}

/// Corners of all triangles of these entities.
fn corners(entities: &[SceneEntity]) -> Vec<[[f64; 3]; 3]> {
    let lists = entities.iter().flat_map(|entity| &entity.triangles);
    lists
        .flat_map(|list| {
            list.indices.as_chunks::<3>().0.iter().map(|triangle| {
                triangle.map(|corner| {
                    let point = &list.points[corner as usize];
                    [point.x, point.y, point.z]
                })
            })
        })
        .collect()
}

fn corners_of(mesh: &Mesh) -> Vec<[[f64; 3]; 3]> {
    let triangles = mesh.triangles().iter();
    triangles
        .map(|triangle| triangle.map(|corner| mesh.points()[corner as usize].into()))
        .collect()
}

#[test]
fn a_mesh_that_moves_is_sent_once_and_its_frame_with_every_picture() {
    let mesh = strip(4);
    let mut viewer = viewer(Vec::new());
    let (mut sent, mut places) = (Vec::new(), Vec::new());
    for cycle in 1..=250 {
        let frame = if cycle < 100 {
            SceneFrame::Base
        } else {
            SceneFrame::Flange
        };
        viewer.set_bodies([body("part/box[3]", &mesh, frame, f64::from(cycle))].into());
        let (scenes, frames) = shown(&mut viewer, u64::from(cycle as u32));
        sent.extend(meshes(&scenes));
        if let Some(frames) = frames {
            let found: Vec<_> = frames
                .transforms
                .iter()
                .filter(|t| t.child_frame_id == "part/box[3]")
                .collect();
            let [transform] = found.as_slice() else {
                panic!("{found:?}")
            };
            assert_eq!(transform.translation.unwrap().x, f64::from(cycle));
            places.push(transform.parent_frame_id.clone());
        }
    }
    assert_eq!(sent.len(), 1);
    assert_eq!(
        (sent[0].id.as_str(), sent[0].frame_id.as_str()),
        ("part/box[3]", "part/box[3]")
    );
    assert!(sent[0].frame_locked);
    assert_eq!(corners(&sent), corners_of(&mesh));
    let color = sent[0].triangles[0].color.unwrap();
    assert_eq!([color.r, color.g, color.b, color.a], [0.1, 0.2, 0.3, 0.4]);
    // Pictures come every fourth cycle.
    assert_eq!(places.len(), 63);
    assert_eq!(
        places
            .iter()
            .filter(|parent| *parent == "base_link")
            .count(),
        25
    );
    assert_eq!(
        places.iter().filter(|parent| *parent == "flange").count(),
        38
    );
}

#[test]
fn triangles_come_again_with_another_colour_on_request_and_after_ten_seconds() {
    let mesh = strip(4);
    let mut viewer = viewer(Vec::new());
    let mut part = body("part/box", &mesh, SceneFrame::Base, 0.0);
    viewer.set_bodies([part.clone()].into());
    let mut times = Vec::new();
    for cycle in 1..=3600 {
        if cycle == 500 {
            part.color[0] = 1.0;
            viewer.set_bodies([part.clone()].into());
        }
        if cycle == 1000 {
            viewer.request_scene();
        }
        let (scenes, _) = shown(&mut viewer, cycle);
        times.extend(meshes(&scenes).iter().map(|_| cycle));
    }
    // With the first picture after each: at the start, at the change, upon the request, and 10 s later.
    assert_eq!(times, [1, 501, 1001, 3501]);
}

#[test]
fn a_mesh_that_goes_or_shrinks_takes_its_pieces_along() {
    let (large, small) = (strip(20_000), strip(2));
    let mut viewer = viewer(Vec::new());
    let deleted = |viewer: &mut ViewerMessages, cycles: std::ops::Range<u64>| {
        let scenes: Vec<SceneUpdate> = cycles.flat_map(|cycle| shown(viewer, cycle).0).collect();
        let ids = scenes
            .iter()
            .flat_map(|scene| &scene.deletions)
            .map(|one| one.id.clone());
        (ids.collect::<Vec<_>>(), meshes(&scenes).len())
    };
    viewer.set_bodies([body("part/a", &large, SceneFrame::Base, 0.0)].into());
    let (gone, _) = deleted(&mut viewer, 1..100);
    assert!(gone.is_empty(), "{gone:?}");
    viewer.set_bodies([body("part/a", &small, SceneFrame::Base, 0.0)].into());
    let (gone, sent) = deleted(&mut viewer, 100..200);
    assert_eq!(gone, ["part/a/piece 2", "part/a/piece 3"]);
    assert_eq!(sent, 1);
    viewer.set_bodies([].into());
    assert_eq!(
        deleted(&mut viewer, 200..300),
        (vec!["part/a".to_owned()], 0)
    );
}

#[test]
fn a_large_mesh_comes_in_pieces_one_a_picture() {
    let mesh = strip(20_000);
    let mut viewer = viewer(Vec::new());
    let _ = shown(&mut viewer, 1);
    viewer.set_bodies([body("part/a", &mesh, SceneFrame::Base, 0.0)].into());
    let mut sent = Vec::new();
    for cycle in 2..=60 {
        let pieces = meshes(&shown(&mut viewer, cycle).0);
        assert!(pieces.len() <= 1);
        sent.extend(pieces);
    }
    let ids: Vec<&str> = sent.iter().map(|entity| entity.id.as_str()).collect();
    assert_eq!(ids, ["part/a", "part/a/piece 2", "part/a/piece 3"]);
    assert!(sent.iter().all(|entity| entity.frame_id == "part/a"));
    assert_eq!(corners(&sent), corners_of(&mesh));
    // Corners that triangles share are sent once in a piece.
    assert_eq!(sent[0].triangles[0].points.len(), 8194);
}

#[test]
fn many_triangles_are_repeated_less_often() {
    let mut viewer = viewer(Vec::new());
    viewer.set_bodies([body("part/a", &strip(100_000), SceneFrame::Base, 0.0)].into());
    let mut begun = Vec::new();
    for cycle in (1..=13_000).step_by(4) {
        let pieces = meshes(&shown(&mut viewer, cycle).0);
        begun.extend(
            pieces
                .iter()
                .filter(|piece| piece.id == "part/a")
                .map(|_| cycle / 250),
        );
    }
    // Twice as many as are repeated in 10 s: every 20 s.
    begun.dedup();
    assert_eq!(begun, [0, 20, 40]);
}

#[test]
fn an_obstacle_of_triangles_stands_in_the_base_until_a_body_takes_its_place() {
    let mesh = strip(4);
    let obstacle = SceneObstacle {
        name: "bench".to_owned(),
        shape: ObstacleShape::Mesh(Arc::clone(&mesh)),
        pose: RpyPose::from_array([0.5, 0.1, 0.2, 0.0, 0.0, 0.0]),
    };
    let mut viewer = viewer(vec![obstacle.clone()]);
    let sent = |viewer: &mut ViewerMessages, cycles: std::ops::Range<u64>| {
        let scenes: Vec<SceneUpdate> = cycles.flat_map(|cycle| shown(viewer, cycle).0).collect();
        assert!(scenes.iter().all(|scene| scene.deletions.is_empty()));
        meshes(&scenes)
    };
    let standing = sent(&mut viewer, 1..50);
    assert_eq!(standing.last().unwrap().frame_id, "base_link");
    let position = standing[0].triangles[0].pose.unwrap().position.unwrap();
    assert_eq!([position.x, position.y, position.z], [0.5, 0.1, 0.2]);
    viewer.set_bodies([body("obstacle/bench", &mesh, SceneFrame::Base, 0.7)].into());
    let moved = sent(&mut viewer, 50..100);
    assert_eq!(moved.len(), 1);
    assert_eq!(
        (moved[0].id.as_str(), moved[0].frame_id.as_str()),
        ("obstacle/bench", "obstacle/bench")
    );
    viewer.set_bodies([].into());
    assert_eq!(sent(&mut viewer, 100..150)[0].frame_id, "base_link");
}

#[test]
fn every_part_of_a_recording_begins_with_all_triangles() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = strip(20_000);
    let config = RecorderConfig {
        path: folder.path().join("run.mcap"),
        obstacles: vec![SceneObstacle {
            name: "bench".to_owned(),
            shape: ObstacleShape::Mesh(Arc::clone(&mesh)),
            pose: RpyPose::from_array([0.0; 6]),
        }],
        rotation: recorder::Rotation {
            end: Some(recorder::RotationTrigger::Secs(2.0)),
            ..recorder::Rotation::default()
        },
        ..config()
    };
    let first = RobotState::at_start(kinematics::JointPositions::ZERO, STEP);
    let (mut motion, mut script) =
        motion_api::motion_channel(motion_api::RingCapacities::default(), &first);
    let (recorder, handle) =
        recorder::Recorder::start(config, script.records.take().unwrap()).unwrap();
    handle.scene_bodies(
        0.0,
        [body("part/a", &strip(3), SceneFrame::Base, 0.0)].into(),
    );
    for cycle in 1..=3000 {
        push(&mut motion, Record::Cycle(state(cycle)));
    }
    drop(motion);
    recorder.finish().unwrap();
    let mut parts = 0;
    for file in std::fs::read_dir(folder.path()).unwrap() {
        let recording = Recording::open(file.unwrap().path()).unwrap();
        let messages = recording.messages().unwrap();
        let scenes: Vec<SceneUpdate> = messages
            .take_while(|message| message.channel.topic != "/cycle")
            .filter(|message| message.channel.topic == "/scene")
            .map(|message| SceneUpdate::decode(&*message.data).unwrap())
            .collect();
        let bench: Vec<SceneEntity> = meshes(&scenes)
            .into_iter()
            .filter(|e| e.id.starts_with("obstacle/bench"))
            .collect();
        assert_eq!(corners(&bench), corners_of(&mesh));
        let part = meshes(&scenes).iter().any(|entity| entity.id == "part/a");
        assert_eq!(
            part,
            recording.setup().unwrap().part > 1,
            "bodies are known from the first cycle on"
        );
        parts += 1;
    }
    assert!(parts >= 3, "{parts} parts");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 40, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn any_triangles_arrive_in_their_order(
        points in proptest::collection::vec(proptest::array::uniform3(-10.0..10.0_f64), 1..60),
        picks in proptest::collection::vec(proptest::array::uniform3(any::<proptest::sample::Index>()), 1..200),
        copies in 1..120_usize,
    ) {
        let count = points.len();
        let triangles: Vec<[u32; 3]> =
            picks.iter().map(|triangle| triangle.map(|pick| pick.index(count) as u32)).collect();
        let mesh = Mesh::new("any.stl", points.into_iter().map(Vector3::from).collect(), triangles.repeat(copies));
        let mesh = Arc::new(mesh.unwrap());
        let mut viewer = viewer(Vec::new());
        viewer.set_bodies([body("part/a", &mesh, SceneFrame::Base, 0.0)].into());
        let mut scenes = Vec::new();
        let result: Result<(), std::convert::Infallible> = viewer.scene(0.0, |_, message| {
            scenes.push(SceneUpdate::decode(message).unwrap());
            Ok(())
        });
        result.unwrap();
        prop_assert_eq!(corners(&meshes(&scenes)), corners_of(&mesh));
        prop_assert_eq!(scenes.len(), 1 + mesh.triangles().len().div_ceil(8192));
    }
}
