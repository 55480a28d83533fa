//! `eliteserver place`: where the base should stand.

use std::io::Write;
use std::path::Path;

use controller::clearance::collision_scene;
use kinematics::text_file::read_text_file;
use kinematics::{Pose, RpyPose};
use messages::{Text, text};
use path_planning::placement::{PlacementRequest, place as best_place};
use serde_json::json;

use crate::cli::{FindingFormat, PlaceArgs, RunArgs};
use crate::command::{CommandError, CommandResult, CommandStatus};
use crate::commands::clearance::refuse_ignored;
use crate::config::RunConfig;
use crate::language;
use crate::shutdown::Shutdown;

/// Most points of a file.
const POINTS_MAX: usize = 1000;
/// Largest number of a point, m or rad.
const NUMBER_MAX: f64 = 1000.0;

/// Exit status: 0 found, 1 no place fits, 2 wrong arguments.
///
/// # Errors
/// What is wrong with the arguments.
pub fn place(args: &PlaceArgs, config: &RunConfig) -> CommandResult {
    let run = RunArgs {
        shared: args.shared.clone(),
        ..RunArgs::default()
    };
    refuse_ignored(&run, "place")?;
    let shutdown = Shutdown::start(CommandStatus::NotDone)?;
    let points = read_points(&args.points).map_err(CommandError::sentence)?;
    let scene = collision_scene(&config.robot)?;
    let request = PlacementRequest {
        area: args.area.unwrap_or_else(|| area_around(&points, &scene)),
        points,
        margin: args.margin,
        has_yaw: args.yaw,
        scene,
    };
    let found = best_place(&request, &mut || shutdown.token().is_cancelled());
    let text = match (&found, args.format) {
        (Ok(found), FindingFormat::Human) => format!(
            "x = {:.4} m, y = {:.4} m, yaw = {:.4} rad\n",
            found.base.x, found.base.y, found.base.yaw
        ),
        (Ok(found), FindingFormat::Json) => {
            let distance = found.distance.is_finite().then_some(found.distance);
            let answer = json!({
                "x": found.base.x,
                "y": found.base.y,
                "yaw": found.base.yaw,
                "joint_margin": found.joint_margin,
                "distance": distance,
                "time": found.time,
            });
            format!("{answer}\n")
        }
        (Err(failing), FindingFormat::Json) => {
            let points: Vec<usize> = failing.iter().map(|number| number + 1).collect();
            format!("{}\n", json!({"ok": false, "points": points}))
        }
        (Err(_), FindingFormat::Human) => String::new(),
    };
    // Whoever reads may have seen enough; the status still tells.
    let _ = std::io::stdout().lock().write_all(text.as_bytes());
    match (&found, args.format) {
        (Ok(found), FindingFormat::Human) => {
            let (count, margin, time) = (request.points.len(), found.joint_margin, found.time);
            language::say(&match found.distance.is_finite() {
                true => text!(
                    "all {count} points are reached at least {:.1} mm from everything, {margin:.3} rad from the ends \
                     of the joints' ranges, in {time:.3} s from first to last",
                    "全部 {count} 个点都可到达，与所有物体至少相距 {:.1} mm，距关节范围的边界 {margin:.3} rad，从第一点到最后一点 {time:.3} s",
                    found.distance * 1e3
                ),
                false => text!(
                    "all {count} points are reached {margin:.3} rad from the ends of the joints' ranges, in {time:.3} \
                     s from first to last",
                    "全部 {count} 个点都可到达，距关节范围的边界 {margin:.3} rad，从第一点到最后一点 {time:.3} s"
                ),
            });
        }
        (Err(failing), FindingFormat::Human) => {
            let points: Vec<String> = failing
                .iter()
                .map(|number| (number + 1).to_string())
                .collect();
            language::complain(&text!(
                "no base pose in the area reaches all points with {:.1} mm to spare; from the best one these are not \
                 reached: {}",
                "区域内没有基座位姿能以 {:.1} mm 的间隙到达所有点；最好的位姿到达不了的点：{}",
                args.margin * 1e3,
                points.join(", ")
            ));
        }
        _ => {}
    }
    Ok(CommandStatus::of_answer(found.is_ok()))
}

/// The area in which the arm reaches any of the points, in the plane: x and y, least and greatest, m.
fn area_around(points: &[Pose], scene: &path_planning::CollisionScene) -> [f64; 4] {
    let chain = scene.model().chain();
    let links = chain.parent_from_joint.iter().skip(1);
    let reach: f64 = links.map(|pose| pose.translation.norm()).sum::<f64>()
        + chain.joint6_from_flange.translation.norm()
        + scene.flange_from_tcp().translation.norm();
    let side = |axis: usize| {
        let values = points.iter().map(|point| point.translation[axis]);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        })
    };
    let (x, y) = (side(0), side(1));
    [x.0 - reach, x.1 + reach, y.0 - reach, y.1 + reach]
}

/// Six numbers a line, separated by commas or blanks; `#` begins a comment.
fn read_points(path: &Path) -> Result<Vec<Pose>, Text> {
    let name = path.display();
    let text = read_text_file(path).map_err(|error| {
        text!(
            "cannot read the points {name}: {error}",
            "无法读取点文件 {name}：{error}"
        )
    })?;
    let mut points = Vec::new();
    for (line, number) in text.lines().zip(1..) {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        let words = line
            .split([',', ' ', '\t', ';'])
            .filter(|word| !word.is_empty());
        let numbers: Option<Vec<f64>> = words
            .map(|word| {
                word.parse()
                    .ok()
                    .filter(|number: &f64| number.abs() <= NUMBER_MAX)
            })
            .collect();
        let numbers = numbers.and_then(|numbers| <[f64; 6]>::try_from(numbers).ok());
        let numbers = numbers.ok_or_else(|| {
            text!(
"{name} line {number}: six numbers up to 1000 are needed, x y z Rx Ry Rz in m and rad",
"{name} 第 {number} 行：需要六个不超过 1000 的数，x y z Rx Ry Rz，单位 m 和 rad")
        })?;
        points.push(Pose::from_rpy(&RpyPose::from_array(numbers)));
        if points.len() > POINTS_MAX {
            return Err(text!(
                "{name} has more than {POINTS_MAX} points",
                "{name} 的点超过 {POINTS_MAX} 个"
            ));
        }
    }
    match points.is_empty() {
        true => Err(text!(
            "{name} has no points: six numbers a line are needed, x y z Rx Ry Rz",
            "{name} 中没有点：每行需要六个数，x y z Rx Ry Rz"
        )),
        false => Ok(points),
    }
}
