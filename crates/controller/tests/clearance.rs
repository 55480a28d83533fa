//! How near the motions of programs come to anything, and paths that keep a margin, both by running programs.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::result_large_err,
    clippy::approx_constant,
    reason = "a test fails by panicking; poses are those that people write"
)]

use std::io::Write;
use std::time::Duration;

use controller::clearance::{
    MeasureOptions, MeasuredEnd, collision_scene, measure, measure_with_path,
};
use controller::optimizer::{OptimizeOptions, optimize};
use controller::planned_path::{NoPathReason, PathTarget, PlanError, PlanOptions, plan_path};

use controller::{ControllerConfig, SteppedController};
use elite_runtime::ProgramText;
use kinematics::{JointPositions, RpyPose};
use tempfile::NamedTempFile;

const POST: &str = r#"
[[obstacle]]
name = "post"
shape = "cylinder"
size = [0.04, 1.0]
pose = [-0.45, 0, 0.5, 0, 0, 0]

[[obstacle]]
name = "table"
shape = "box"
size = [2, 2, 0.1]
pose = [0, 0, -0.06, 0, 0, 0]
"#;

const LEFT: [f64; 6] = [0.8, -1.57, 1.57, -1.57, -1.57, 0.0];
const RIGHT: [f64; 6] = [-0.8, -1.57, 1.57, -1.57, -1.57, 0.0];

fn cell(text: &str) -> (NamedTempFile, ControllerConfig) {
    let mut file = NamedTempFile::new().unwrap();
    file.write_all(text.as_bytes()).unwrap();
    let config = ControllerConfig {
        cell: Some(file.path().to_owned()),
        home: JointPositions(LEFT),
        tcp: RpyPose::from_array([0.0, 0.0, 0.12, 0.0, 0.0, 0.0]),
        ..ControllerConfig::default()
    };
    (file, config)
}

fn program(text: &str) -> ProgramText {
    ProgramText {
        name: "test".to_owned(),
        text: text.to_owned(),
    }
}

fn measured(config: &ControllerConfig, text: &str) -> controller::clearance::ClearanceRun {
    let options = MeasureOptions {
        limit: 60.0,
        ..MeasureOptions::default()
    };
    measure(config, program(text), &options, &mut || true).unwrap()
}

#[test]
fn the_way_of_the_tcp_is_followed_from_where_the_arm_stands() {
    let (_file, config) = cell(POST);
    // A straight line, then a longer tool, which is a jump and no way.
    let text = "movel(pose_add(get_target_tcp_pose(), [0, 0, 0.1, 0, 0, 0]))\n\
                set_tcp([0, 0, 0.3, 0, 0, 0])\nmovej([0.6, -1.57, 1.57, -1.57, -1.57, 0.0])\n";
    let options = MeasureOptions::default();
    let ran = measure_with_path(&config, program(text), &options, &mut || true).unwrap();
    let path = ran.path;
    assert_eq!(ran.run.end, MeasuredEnd::Finished, "{:?}", ran.run);
    assert!(ran.has_obstacles);
    let scene = collision_scene(&config).unwrap();
    let start = scene
        .model()
        .tcp_pose(&config.home, scene.flange_from_tcp())
        .to_rpy()
        .xyz;
    let [first, second] = &path.pieces[..] else {
        panic!("{path:?}");
    };
    let (begin, end) = (first[0], first[first.len() - 1]);
    let off = |a: [f64; 3], b: [f64; 3]| -> f64 {
        let parts = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        parts.fold(0.0, f64::max)
    };
    assert!(off(begin, start) < 1e-3, "{begin:?} {start:?}");
    let above = [start[0], start[1], start[2] + 0.1];
    assert!(off(end, above) < 1e-3, "{end:?} {above:?}");
    assert!(
        first.len() <= 5,
        "a straight line has few points: {first:?}"
    );
    let jump = end[2] - second[0][2];
    assert!((jump - 0.18).abs() < 1e-3, "the tool is longer by {jump} m");
    assert!(path.tolerance < 1e-3);
}

#[test]
fn a_motion_through_a_post_is_told_and_stops_nobody() {
    let (_file, config) = cell(POST);
    let text =
        "movej([0.8, -1.4, 1.4, -1.57, -1.57, 0.0])\nmovej([-0.8, -1.4, 1.4, -1.57, -1.57, 0.0])\n";
    let run = measured(&config, text);
    assert_eq!(run.end, MeasuredEnd::Finished, "{run:?}");
    let [first, second] = &run.rows[..] else {
        panic!("{:?}", run.rows);
    };
    assert!(first.distance() > 0.0 && first.line == 1 && first.kind == "movej");
    let least = second.least.as_ref().unwrap();
    assert!(
        least.distance < -0.02 && least.b == "post" && second.line == 2,
        "{second:?}"
    );
    assert_eq!(run.nearest(), Some(second));
    // A fine sampling of the straight line of the joints finds the same.
    let scene = collision_scene(&config).unwrap();
    let sampled = (0..=4000)
        .map(|k| {
            JointPositions([
                0.8 - 1.6 * f64::from(k) / 4000.0,
                -1.4,
                1.4,
                -1.57,
                -1.57,
                0.0,
            ])
        })
        .filter_map(|q| scene.nearest(&q))
        .map(|nearest| nearest.distance)
        .fold(f64::INFINITY, f64::min);
    assert!(
        (least.distance - sampled).abs() < 2e-4,
        "{} {sampled}",
        least.distance
    );
    assert!(least.time > 0.0 && least.time < run.result.time);
    let most = scene.model().limits().position_max;
    let swept = [0.8, 1.4, 1.4, 1.57, 1.57, 0.0];
    let margins = (0..6).map(|joint| most[joint] - swept[joint]);
    let margin = margins.fold(f64::INFINITY, f64::min);
    assert!(
        (second.joint_margin - margin).abs() < 1e-6,
        "{}",
        second.joint_margin
    );
    assert!(
        second.singularity > 0.01 && second.singularity < 1.0,
        "{}",
        second.singularity
    );
}

#[test]
fn blends_are_measured_with_the_motion_that_they_lead_into() {
    let text = "movej([0.3, -1.57, 1.57, -1.57, -1.57, 0.0], r=0.1)\nmovej([0.3, -1.2, 1.57, -1.57, -1.57, 0.0])\n";
    let (_file, config) = cell(POST);
    let options = MeasureOptions {
        has_history: true,
        ..MeasureOptions::default()
    };
    let run = measure(&config, program(text), &options, &mut || true).unwrap();
    let [first, second] = &run.rows[..] else {
        panic!("{:?}", run.rows);
    };
    assert_eq!((first.line, second.line), (1, 2));
    let least = run.history.iter().map(|(_, distance)| *distance);
    let least = least.fold(f64::INFINITY, f64::min);
    assert!(run.distance() <= least + 1e-4, "{} {least}", run.distance());
    assert!(run.distance() >= least - 5e-3, "{} {least}", run.distance());
}

#[test]
fn streams_are_one_row_a_line() {
    let (_file, config) = cell(POST);
    let text = "i = 0\nwhile i < 50:\n    servoj([0.8 - i * 0.002, -1.57, 1.57, -1.57, -1.57, 0.0], t=0.004)\n\
                \x20   i = i + 1\n    sync()\nend\nstopj(2)\n";
    let run = measured(&config, text);
    assert_eq!(run.end, MeasuredEnd::Finished, "{:?}", run.end);
    let lines: Vec<u32> = run.rows.iter().map(|row| row.line).collect();
    assert_eq!(
        lines.iter().filter(|line| **line == 3).count(),
        1,
        "{:?}",
        run.rows
    );
}

#[test]
fn what_cannot_be_measured_to_its_end_is_said_with_the_line() {
    let (_file, config) = cell(POST);
    let run = measured(
        &config,
        "x = 1\nwhile True:\n    movej([0.7, -1.57, 1.57, -1.57, -1.57, 0.0])\n\
         \x20   movej([0.8, -1.57, 1.57, -1.57, -1.57, 0.0])\nend\n",
    );
    assert!(
        matches!(run.end, MeasuredEnd::TimedOut { line: 3..=4, .. }),
        "{:?}",
        run.end
    );
    assert!(run.rows.len() > 10);
    let options = MeasureOptions::default();
    let waits = "while not get_standard_digital_in(0):\n    sync()\nend\n";
    let run = measure(&config, program(waits), &options, &mut || true).unwrap();
    assert!(
        matches!(run.end, MeasuredEnd::Waits { line: 1..=2 }),
        "{:?}",
        run.end
    );
    let run = measured(&config, "movej([0.7, -1.57])\n");
    assert!(
        matches!(run.end, MeasuredEnd::Failed { line: 1, .. }),
        "{:?}",
        run.end
    );
    let run = measured(&config, "movej([0.7, -1.57\n");
    assert!(
        matches!(run.end, MeasuredEnd::NotCompiled { .. }),
        "{:?}",
        run.end
    );
}

#[test]
fn pairs_that_may_touch_do_not_count() {
    let text = "movej([-0.8, -1.57, 1.57, -1.57, -1.57, 0.0])\n";
    let (_file, config) = cell(POST);
    assert!(measured(&config, text).distance() < 0.0);
    let touching = format!("{POST}\n[[touch]]\na = \"*\"\nb = \"po*t\"\n");
    let (_file, config) = cell(&touching);
    assert!(measured(&config, text).distance() > 0.0);
    let wrong = format!("{POST}\n[[touch]]\na = \"tool\"\nb = \"posts\"\n");
    let (_file, config) = cell(&wrong);
    let error = SteppedController::open(&config, std::sync::Arc::new(controller::NullObserver));
    let error = error.map(drop).unwrap_err().to_string();
    assert!(
        error.contains("touch 1") && error.contains("posts"),
        "{error}"
    );
}

/// A request that no clock ends, however busy the machine is.
fn to(target: PathTarget) -> PlanOptions {
    PlanOptions {
        time: Duration::from_secs(600),
        ..PlanOptions::to(target)
    }
}

fn planned(
    config: &ControllerConfig,
    options: &PlanOptions,
) -> Result<controller::planned_path::PlannedPath, PlanError> {
    plan_path(config, options, &mut || true)
}

#[test]
fn a_planned_path_is_driven_with_its_margin() {
    let (_file, config) = cell(POST);
    for (seed, margin) in [(0, 0.01), (1, 0.03), (2, 0.0)] {
        let config = ControllerConfig {
            seed,
            ..config.clone()
        };
        let options = PlanOptions {
            margin,
            ..to(PathTarget::Joints(JointPositions(RIGHT)))
        };
        let path = planned(&config, &options).unwrap();
        assert_eq!(path.waypoints[0].0, LEFT);
        assert_eq!(path.waypoints[path.waypoints.len() - 1].0, RIGHT);
        assert!(path.waypoints.len() > 2, "{path:?}");
        let length = path_planning::length(&path.waypoints);
        assert!((path.length - length).abs() < 1e-12);
        // Run by somebody else it is the same.
        let run = measured(&config, &path.program);
        assert_eq!(run.end, MeasuredEnd::Finished, "{}", path.program);
        assert!(
            run.distance() >= margin,
            "{} {margin}\n{}",
            run.distance(),
            path.program
        );
        assert_eq!(Some(run.distance()), path.distance);
        assert_eq!(run.result.time, path.time);
        assert!(path.program.contains(", r=0."), "{}", path.program);
        let again = planned(&config, &options).unwrap();
        assert_eq!(again.program, path.program);
    }
}

#[test]
fn a_pose_is_reached_by_any_of_its_joint_positions_and_along_the_tool() {
    let (_file, config) = cell(POST);
    let scene = collision_scene(&config).unwrap();
    let pose = scene
        .model()
        .tcp_pose(&JointPositions(RIGHT), scene.flange_from_tcp());
    let options = PlanOptions {
        approach: 0.05,
        ..to(PathTarget::Pose(pose.to_rpy()))
    };
    let path = planned(&config, &options).unwrap();
    let end = path.waypoints[path.waypoints.len() - 1];
    let reached = scene.model().tcp_pose(&end, scene.flange_from_tcp());
    assert!((reached.translation - pose.translation).norm() < 1e-9);
    assert!(path.program.contains("movel(["), "{}", path.program);
    let before = path.waypoints[path.waypoints.len() - 2];
    let before = scene.model().tcp_pose(&before, scene.flange_from_tcp());
    let way = pose.translation - before.translation;
    assert!((way.norm() - 0.05).abs() < 1e-6, "{way}");
}

#[test]
fn no_path_has_its_reason() {
    let (_file, config) = cell(POST);
    let reason = |config: &ControllerConfig, options: &PlanOptions| match planned(config, options) {
        Err(PlanError::NoPath { reason, detail }) => (reason, detail),
        other => panic!("{other:?}"),
    };
    let inside = JointPositions([0.0, -1.57, 1.57, -1.57, -1.57, 0.0]);
    let (word, detail) = reason(&config, &to(PathTarget::Joints(inside)));
    assert_eq!(word, NoPathReason::GoalInCollision);
    assert!(
        detail.english().contains("post") && detail.english().contains("[[touch]]"),
        "{detail}"
    );
    let at_post = ControllerConfig {
        home: inside,
        ..config.clone()
    };
    let to_right = to(PathTarget::Joints(JointPositions(RIGHT)));
    assert_eq!(
        reason(&at_post, &to_right).0,
        NoPathReason::StartInCollision
    );
    let far = RpyPose::from_array([2.0, 0.0, 0.3, 3.14, 0.0, 0.0]);
    let (word, detail) = reason(&config, &to(PathTarget::Pose(far)));
    assert_eq!(word, NoPathReason::OutOfReach);
    assert!(detail.english().contains("p[2,0,0.3,3.14,0,0]"), "{detail}");
    let hurried = PlanOptions {
        time: Duration::ZERO,
        ..to_right.clone()
    };
    let (word, detail) = reason(&config, &hurried);
    assert_eq!(word, NoPathReason::NoPath);
    assert!(detail.english().contains("--time"), "{detail}");
    let beyond = to(PathTarget::Joints(JointPositions([
        7.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    ])));
    let error = planned(&config, &beyond).unwrap_err();
    assert!(matches!(error, PlanError::Request(_)), "{error}");
    let held = PlanOptions {
        held: Some("box".to_owned()),
        ..to_right
    };
    let error = planned(&config, &held).unwrap_err().to_string();
    assert!(
        error.contains("\"box\"") && error.contains("post, table"),
        "{error}"
    );
}

#[test]
fn parts_count_where_they_are_and_held_ones_move_with_the_arm() {
    let text = r#"
[world]
floor = -0.05

[[part]]
name = "box"
shape = "box"
size = [0.1, 0.1, 0.1]
mass = 0.5
pose = [-0.45, 0, 0, 0, 0, 0]

[[obstacle]]
name = "shelf"
shape = "box"
size = [0.2, 0.2, 0.02]
pose = [-0.45, 0, 0.25, 0, 0, 0]
"#;
    let (_file, config) = cell(text);
    let scene = collision_scene(&config).unwrap();
    let names: Vec<&str> = scene.obstacle_names().collect();
    assert_eq!(names, ["shelf", "floor", "box"]);
    let text =
        "movej([0.0, -1.2, 1.9, -2.2, -1.57, 0.0])\nmovej([0.8, -1.57, 1.57, -1.57, -1.57, 0.0])\n";
    let run = measured(&config, text);
    assert_eq!(run.end, MeasuredEnd::Finished);
    assert!(run.distance() < 0.05, "{:?}", run.nearest());
}

#[test]
fn what_is_held_keeps_the_margin_too() {
    let (_file, config) = cell(POST);
    let scene = collision_scene(&config).unwrap();
    let left = JointPositions(LEFT);
    let tip = scene
        .model()
        .tcp_pose(&left, scene.flange_from_tcp())
        .translation;
    let part = format!(
        "{POST}\n[[obstacle]]\nname = \"box\"\nshape = \"box\"\nsize = [0.2, 0.2, 0.06]\n\
         pose = [{}, {}, {}, 0, 0, 0]\n",
        tip.x,
        tip.y,
        tip.z - 0.035
    );
    let (_file, config) = cell(&part);
    let options = PlanOptions {
        held: Some("box".to_owned()),
        ..to(PathTarget::Joints(JointPositions(RIGHT)))
    };
    let path = planned(&config, &options).unwrap();
    assert!(path.distance.unwrap() >= 0.01, "{path:?}");
    // The same path with the box on the flange, measured without the controller.
    let mut scene = collision_scene(&config).unwrap();
    let id = scene.obstacle("box").unwrap();
    let Some(path_planning::ObstaclePlace::Standing(pose)) = scene.place(id) else {
        panic!("{:?}", scene.place(id));
    };
    let on_flange = scene.model().flange_pose(&left).inverse() * pose;
    scene.set_place(id, path_planning::ObstaclePlace::Held(on_flange));
    let mut tracker = path_planning::ClearanceTracker::default();
    let mut least = f64::INFINITY;
    for q in &path.waypoints {
        if let Some(found) = tracker.advance(&scene, q, least) {
            least = found.nearest.distance;
        }
    }
    assert!(least >= 0.01, "{least}");
}

/// A box that the cup holds when it is carried gently, and loses where the arm pulls it up hard.
const HEAVY_BOX: &str = r#"
[world]
floor = 0.0

[[part]]
name = "box"
shape = "box"
size = [0.05, 0.05, 0.05]
mass = 2.2
pose = [-0.55, -0.25, 0.0252, 0, 0, 0]

[[gripper]]
name = "cup"
kind = "vacuum"
cups = [[0, 0, 0.12]]
radius = 0.012
on = "standard_digital_out[0]"
switch = "standard_digital_in[0]"
build_up = 0.03

[[touch]]
a = "tool"
b = "box"
"#;

#[test]
fn a_faster_program_does_not_lose_what_it_carries() {
    let (_file, config) = cell(HEAVY_BOX);
    let config = ControllerConfig {
        home: JointPositions([0.0, -1.57, 1.57, -1.57, -1.57, 0.0]),
        ..config
    };
    let down = "3.14159265, 0, 0";
    let text = format!(
        "movel([-0.55, -0.25, 0.15, {down}], a=1.2, v=0.25)
movel([-0.55, -0.25, 0.05, {down}], a=1.2, v=0.1)
set_standard_digital_out(0, True)
sleep(0.3)
movel([-0.55, -0.25, 0.20, {down}], a=1.0, v=0.25)
movel([-0.55, 0.25, 0.20, {down}], a=1.0, v=0.25)
movel([-0.55, 0.25, 0.051, {down}], a=0.5, v=0.1)
set_standard_digital_out(0, False)
sleep(0.3)
"
    );
    let before = measured(&config, &text);
    assert_eq!(before.end, MeasuredEnd::Finished, "{before:?}");
    let [taken, put] = &before.grips[..] else {
        panic!("{:?}", before.grips);
    };
    assert_eq!(taken.held_by.as_deref(), Some("cup"));
    assert!(
        put.held_by.is_none() && (put.place[1] - 0.25).abs() < 2e-3,
        "{put:?}"
    );

    let options = OptimizeOptions {
        margin: 0.005,
        keep: Vec::new(),
        presets: Vec::new(),
        limit: 60.0,
    };
    let faster = optimize(&config, &program(&text), &options, &mut || true).unwrap();
    assert!(faster.after < 0.9 * faster.before, "{faster:?}");
    let after = measured(&config, &faster.text);
    let put = after.grips.last().unwrap();
    assert_eq!(after.grips.len(), 2, "{faster:?} {:?}", after.grips);
    assert!(
        put.held_by.is_none() && (put.place[1] - 0.25).abs() < 2e-3,
        "{faster:?} {put:?}"
    );
}
