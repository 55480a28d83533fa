//! What `eliteserver check` says about calls that look like the usual slips: degrees where radians are meant,
//! millimetres where metres are meant, a pose where joints are meant and the other way round.
//!
//! Reads the declarations, so a new builtin that takes joints or a pose is covered without a word here.

use elite_lang::{CallHint, CallSite, KnownNames, Literal};

use super::all;
use super::declare::{Builtin, Kind, Parameter};

/// Builtins whose result is a pose.
const POSES: &[&str] = &[
    "get_actual_tcp_pose",
    "get_target_tcp_pose",
    "get_forward_kin",
    "pose_trans",
    "pose_inv",
    "pose_add",
    "pose_sub",
    "interpolate_pose",
    "get_tcp_offset",
];
/// Builtins whose result is a list of six joint positions.
const JOINTS: &[&str] = &[
    "get_actual_joint_positions",
    "get_target_joint_positions",
    "get_inverse_kin",
];
/// No joint turns further, and no rotation is given by more, rad.
const ANGLE_MAX_RAD: f64 = std::f64::consts::TAU;
/// No arm reaches further, m.
const REACH_MAX_M: f64 = 10.0;

/// The names of all builtins, with what `check` needs to know of them.
pub fn known_names() -> KnownNames {
    KnownNames::new(all().map(|builtin| builtin.name))
        .with_waiting(all().filter(|b| b.waits).map(|b| b.name))
        .with_call_hook(hints)
}

fn hints(site: &CallSite<'_>) -> Vec<CallHint> {
    let Some(builtin) = all().find(|builtin| builtin.name == site.function) else {
        return Vec::new();
    };
    let args = site.args.iter().enumerate();
    args.filter_map(|(index, arg)| {
        let parameter = parameter(builtin, index, arg.name)?;
        let (code, message, help) = match parameter.kind {
            Kind::Joints => about_joints(builtin, parameter, &arg.value)?,
            Kind::Pose => about_pose(builtin, parameter, &arg.value)?,
            _ => return None,
        };
        Some(CallHint {
            argument: index,
            code,
            message,
            help: Some(help.to_owned()),
        })
    })
    .collect()
}

fn parameter(builtin: &Builtin, index: usize, name: Option<&str>) -> Option<&'static Parameter> {
    match name {
        None => builtin.params.get(index),
        Some(name) => builtin
            .params
            .iter()
            .find(|parameter| parameter.name == name || parameter.aliases.contains(&name)),
    }
}

type Words = (&'static str, String, &'static str);

fn about_joints(builtin: &Builtin, parameter: &Parameter, value: &Literal<'_>) -> Option<Words> {
    let what = format!("'{}' of {}()", parameter.name, builtin.name);
    match value {
        Literal::CallOf(name) if POSES.contains(name) => Some((
            "pose-for-joints",
            format!("{what} takes joint positions, {name}() returns a pose"),
            "move to a pose with movel(), or turn it into joint positions with get_inverse_kin()",
        )),
        Literal::List(items) => degrees(&what, &numbers(items)?),
        _ => None,
    }
}

fn about_pose(builtin: &Builtin, parameter: &Parameter, value: &Literal<'_>) -> Option<Words> {
    let what = format!("'{}' of {}()", parameter.name, builtin.name);
    match value {
        Literal::CallOf(name) if JOINTS.contains(name) => Some((
            "joints-for-pose",
            format!("{what} takes a pose, {name}() returns joint positions"),
            "turn joint positions into a pose with get_forward_kin()",
        )),
        Literal::List(items) => {
            let numbers = numbers(items)?;
            let (position, rotation) = numbers.split_at(numbers.len().min(3));
            match position.iter().find(|x| x.abs() > REACH_MAX_M) {
                Some(x) => Some((
                    "millimetres",
                    format!("{what} has a position of {x}: positions are in metres"),
                    "divide millimetres by 1000",
                )),
                None => degrees(&what, rotation),
            }
        }
        _ => None,
    }
}

fn degrees(what: &str, angles: &[f64]) -> Option<Words> {
    let angle = angles.iter().find(|angle| angle.abs() > ANGLE_MAX_RAD)?;
    Some((
        "degrees",
        format!(
            "{what} has an angle of {angle}: angles are in radians, and {ANGLE_MAX_RAD:.4} is a full turn"
        ),
        "turn degrees into radians with d2r()",
    ))
}

fn numbers(items: &[Literal<'_>]) -> Option<Vec<f64>> {
    let number = |item: &Literal<'_>| match item {
        Literal::Number(number) => Some(*number),
        _ => None,
    };
    items.iter().map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use elite_lang::{SourceFile, check};

    fn codes(text: &str) -> Vec<&'static str> {
        let found = check(SourceFile::new("test.script", text), &known_names());
        found.iter().map(|finding| finding.code).collect()
    }

    #[test]
    fn the_usual_slips_are_pointed_out() {
        assert_eq!(codes("movej([0, -90, 90, -90, -90, 0])"), ["degrees"]);
        assert_eq!(
            codes("movej(v=1, q=(0, -90, 90, -90, -90, 0))"),
            ["degrees"]
        );
        assert_eq!(codes("movel([400, 0, 300, 3.14, 0, 0])"), ["millimetres"]);
        assert_eq!(codes("movel([0.4, 0, 0.3, 180, 0, 0])"), ["degrees"]);
        assert_eq!(codes("movej(get_actual_tcp_pose())"), ["pose-for-joints"]);
        assert_eq!(
            codes("movel(get_actual_joint_positions())"),
            ["joints-for-pose"]
        );
        assert_eq!(
            codes("while get_actual_tcp_pose()[2] > 0.1: pass"),
            ["busy-loop"]
        );
    }

    #[test]
    fn what_is_right_passes() {
        for text in [
            "movej([0, -1.57, 1.57, -1.57, -1.57, 0], a=1.2)",
            "movel([0.4, 0, 0.3, 3.14, 0, 0])",
            "q = [0, 90]\nmovej(q)",
            "movej(get_inverse_kin([0.4, 0, 0.3, 3.14, 0, 0]))",
            "movel(pose_trans(get_actual_tcp_pose(), [0, 0, 0.1, 0, 0, 0]))",
            "while get_actual_tcp_pose()[2] > 0.1: sync()",
        ] {
            assert_eq!(codes(text), [""; 0], "{text}");
        }
    }
}
