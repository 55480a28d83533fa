//! The usual slips: degrees where radians are meant, millimetres where metres are meant, a pose where joints are meant
//! and the other way round. `eliteserver check` finds them in the text; at run time an error of a call that looks like
//! one carries the advice, and a move to the wrong kind of place is warned of.
//!
//! Reads the declarations, so a new builtin that takes joints or a pose is covered without a word here.

mod limits;
mod signature_check;

use std::rc::Rc;
use std::sync::LazyLock;

use elite_lang::{NativeCall, Unwind};
use elite_syntax::{ArgumentLiteral, CallHint, CallSite, KnownNames};
use kinematics::RobotModel;
use messages::{Text, text};

use self::limits::ArmLimits;
pub use self::limits::TOOL_LENGTH_MAX;
use super::declare::{Builtin, Category, Parameter, ParameterType};
use super::{all, names};
use crate::message::{Message, Severity};
use crate::task::TaskContext;

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

const POSE_FOR_JOINTS: Text = text!(
    "move to a pose with movel(), or turn it into joint positions with get_inverse_kin()",
    "用 movel() 移动到位姿，或用 get_inverse_kin() 换算为关节位置"
);
const JOINTS_FOR_POSE: Text = text!(
    "turn joint positions into a pose with get_forward_kin()",
    "用 get_forward_kin() 把关节位置换算为位姿"
);

fn natives() -> KnownNames {
    // Names of later editions are not there when a program runs; `check` says more of them than that.
    let later = LATER.iter().map(|(name, _, _)| *name);
    KnownNames::new(names().chain(later)).with_waiting(all().filter(|b| b.waits).map(|b| b.name))
}

/// The names of all builtins, with what `check` needs to know of them. What no arm can do is wrong.
pub fn known_names() -> KnownNames {
    static ANY: LazyLock<ArmLimits> = LazyLock::new(ArmLimits::of_any_arm);
    natives().with_call_hook(|site| hints(site, &ANY))
}

/// Names and checks of [`known_names`], for programs of one arm: what this arm cannot do is wrong. `tool` is how far
/// the TCP is from the flange at most, m.
pub fn known_names_for(model: RobotModel, tool: f64) -> KnownNames {
    let limits = ArmLimits::of(model, tool);
    natives().with_call_hook(move |site| hints(site, &limits))
}

fn hints(site: &CallSite<'_>, arm: &ArmLimits) -> Vec<CallHint> {
    let Some(builtin) = all().find(|builtin| builtin.name == site.function) else {
        return of_later_edition(site.function).into_iter().collect();
    };
    // What the language itself provides is listed here and not bound by its declaration.
    let misfits = match builtin.run {
        Some(_) => signature_check::signature_errors(builtin, site),
        None => Vec::new(),
    };
    let args = site.args.iter().enumerate();
    let slips = args.filter_map(|(index, arg)| {
        let parameter = parameter(builtin, index, arg.name)?;
        let slip = match parameter.kind {
            ParameterType::Joints => about_joints(builtin, parameter, &arg.value),
            ParameterType::Pose => about_pose(builtin, parameter, &arg.value),
            _ => None,
        };
        let (code, message, help) =
            slip.or_else(|| arm.violation(builtin, parameter, &arg.value))?;
        Some(CallHint {
            argument: Some(index),
            code,
            message,
            help: Some(help),
        })
    });
    misfits.into_iter().chain(slips).collect()
}

/// Functions that later editions of the vendor's software have and this controller has not: name, edition, what is
/// missing here.
const LATER: &[(&str, &str, Text)] = &[(
    "set_tool_second_power_on",
    "2.16",
    text!(
        "it switches a second supply at the tool of the large arms, which is not simulated; \
         leave the call out, or define a function of this name",
        "它用于接通大型机械臂工具端的第二路电源，这里不作仿真；请去掉该调用，或自行定义同名函数"
    ),
)];

fn of_later_edition(name: &str) -> Option<CallHint> {
    let (name, edition, help) = LATER.iter().find(|(known, _, _)| *known == name)?;
    Some(CallHint {
        argument: None,
        code: "later-edition",
        message: text!(
            "{name}() came with edition {edition} of the vendor's software; this controller \
             follows edition 2.15",
            "{name}() 从厂家软件 {edition} 版开始提供；本控制器遵循 2.15 版"
        ),
        help: Some(help.clone()),
    })
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

type HintText = (&'static str, Text, Text);

fn about_joints(
    builtin: &Builtin,
    parameter: &Parameter,
    value: &ArgumentLiteral<'_>,
) -> Option<HintText> {
    let what = text!(
        "'{}' of {}()",
        "{1}() 的 '{0}'",
        parameter.name,
        builtin.name
    );
    match value {
        ArgumentLiteral::CallOf(name) if POSES.contains(name) => Some((
            "pose-for-joints",
            text!(
                "{what} takes joint positions, {name}() returns a pose",
                "{what}需要关节位置，{name}() 返回的是位姿"
            ),
            POSE_FOR_JOINTS,
        )),
        ArgumentLiteral::List(items) => degrees(&what, &numbers_or_zero(items)),
        _ => None,
    }
}

fn about_pose(
    builtin: &Builtin,
    parameter: &Parameter,
    value: &ArgumentLiteral<'_>,
) -> Option<HintText> {
    let what = text!(
        "'{}' of {}()",
        "{1}() 的 '{0}'",
        parameter.name,
        builtin.name
    );
    match value {
        ArgumentLiteral::CallOf(name) if JOINTS.contains(name) => Some((
            "joints-for-pose",
            text!(
                "{what} takes a pose, {name}() returns joint positions",
                "{what}需要位姿，{name}() 返回的是关节位置"
            ),
            JOINTS_FOR_POSE,
        )),
        ArgumentLiteral::List(items) => {
            let numbers = numbers_or_zero(items);
            let (position, rotation) = numbers.split_at(numbers.len().min(3));
            millimetres(&what, position).or_else(|| degrees(&what, rotation))
        }
        _ => None,
    }
}

fn millimetres(what: &Text, position: &[f64]) -> Option<HintText> {
    let x = position.iter().find(|x| x.abs() > REACH_MAX_M)?;
    Some((
        "millimetres",
        text!(
            "{what} has a position of {x}: positions are in metres",
            "{what}的位置为 {x}：位置以米为单位"
        ),
        text!("divide millimetres by 1000", "请把毫米除以 1000"),
    ))
}

fn degrees(what: &Text, angles: &[f64]) -> Option<HintText> {
    let angle = angles.iter().find(|angle| angle.abs() > ANGLE_MAX_RAD)?;
    Some((
        "degrees",
        text!(
            "{what} has an angle of {angle}: angles are in radians, and {ANGLE_MAX_RAD:.4} is a \
             full turn",
            "{what}的角度为 {angle}：角度以弧度为单位，{ANGLE_MAX_RAD:.4} 为一整圈"
        ),
        text!(
            "turn degrees into radians with d2r()",
            "请用 d2r() 把度换算为弧度"
        ),
    ))
}

/// The arguments of a call that are six numbers where joints or a pose are meant.
fn six_numbers(builtin: &Builtin, native: &NativeCall<'_>) -> Vec<(&'static Parameter, [f64; 6])> {
    let params = builtin.params.iter().enumerate();
    let places =
        params.filter(|(_, p)| matches!(p.kind, ParameterType::Joints | ParameterType::Pose));
    let six = |(index, parameter): (usize, &'static Parameter)| {
        let items = native.arg(index)?.as_items()?;
        let numbers: Option<Vec<f64>> = items.iter().map(elite_lang::Value::as_f64).collect();
        Some((parameter, numbers?.try_into().ok()?))
    };
    places.filter_map(six).collect()
}

/// The error of a call, with advice if its arguments look like a slip.
pub(super) fn explain(
    builtin: &'static Builtin,
    native: &NativeCall<'_>,
    raised: Unwind,
) -> Unwind {
    let slip = six_numbers(builtin, native)
        .into_iter()
        .find_map(|(parameter, numbers)| {
            let what = text!(
                "'{}' of {}()",
                "{1}() 的 '{0}'",
                parameter.name,
                builtin.name
            );
            match parameter.kind {
                ParameterType::Joints => degrees(&what, &numbers),
                _ => millimetres(&what, &numbers[..3]).or_else(|| degrees(&what, &numbers[3..])),
            }
        });
    match slip {
        Some((_, message, help)) => {
            native.with_help(raised, text!("{message}; {help}", "{message}；{help}"))
        }
        None => raised,
    }
}

/// Warns, once a task and function, of a move whose joint positions are the arm's pose, or the other way round.
pub(super) fn warn_swapped_target(
    builtin: &'static Builtin,
    context: &Rc<TaskContext>,
    native: &NativeCall<'_>,
) {
    if builtin.category != Category::Motion || !builtin.name.starts_with("move") {
        return;
    }
    let state = context.robot().foreseen().state;
    for (parameter, numbers) in six_numbers(builtin, native) {
        let (given, wanted, help) = match parameter.kind {
            ParameterType::Joints
                if [state.actual_tcp_pose, state.target_tcp_pose]
                    .iter()
                    .any(|pose| pose.to_array() == numbers) =>
            {
                (
                    text!("the TCP pose", "TCP 位姿"),
                    text!("joint positions", "关节位置"),
                    POSE_FOR_JOINTS,
                )
            }
            ParameterType::Pose
                if [state.actual_q, state.target_q]
                    .iter()
                    .any(|q| q.0 == numbers) =>
            {
                (
                    text!("the joint positions of the arm", "手臂的关节位置"),
                    text!("a pose", "位姿"),
                    JOINTS_FOR_POSE,
                )
            }
            _ => continue,
        };
        if context.is_first_warning(&format!("{} {}", builtin.name, parameter.name)) {
            let (name, place) = (builtin.name, parameter.name);
            let text = text!(
                "{name}(): '{place}' takes {wanted}, but is {given}; {help}",
                "{name}()：'{place}' 需要{wanted}，却是{given}；{help}"
            );
            let origin = context.origin(native.line());
            let message = Message::log(Severity::Warning, origin, text);
            context.observer().message(&message);
        }
    }
}

fn number(item: &ArgumentLiteral<'_>) -> Option<f64> {
    match item {
        ArgumentLiteral::Integer(number) => Some(*number as f64),
        ArgumentLiteral::Number(number) => Some(*number),
        _ => None,
    }
}

fn numbers(items: &[ArgumentLiteral<'_>]) -> Option<Vec<f64>> {
    items.iter().map(number).collect()
}

/// The numbers of a list with 0, which is never too much, for what is known at run time only.
fn numbers_or_zero(items: &[ArgumentLiteral<'_>]) -> Vec<f64> {
    items
        .iter()
        .map(|item| number(item).unwrap_or(0.0))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use elite_syntax::{SourceFile, check};
    use messages::Language;

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
        assert_eq!(codes("movej([d2r(10), -90, 90, -90, -90, 0])"), ["degrees"]);
        assert_eq!(
            codes("h = 0.3\nmovel([400, 0, h, 3.14, 0, 0])"),
            ["millimetres"]
        );
        assert_eq!(codes("movej([d2r(10), d2r(-90), 1, 0, 0, 0])"), [""; 0]);
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
    fn variables_of_one_value_are_looked_into() {
        assert_eq!(codes("q = [0, 90, 0, 0, 0, 0]\nmovej(q)"), ["degrees"]);
        assert_eq!(
            codes("here = get_actual_tcp_pose()\nmovej(here)"),
            ["pose-for-joints"]
        );
        assert_eq!(
            codes("home = get_actual_joint_positions()\ndef go():\n  movel(home)\nend\ngo()"),
            ["joints-for-pose"]
        );
        for text in [
            "q = [0, 90, 0, 0, 0, 0]\nq = [0, 0, 0, 0, 0, 0]\nmovej(q)",
            "q = [0, 90, 0, 0, 0, 0]\nq[1] = 0\nmovej(q)",
            "q = [0, 90, 0, 0, 0, 0]\nq.clear()\nmovej(q)",
            "q = [0, 90, 0, 0, 0, 0]\ndef go(q):\n  movej(q)\nend\ngo(get_actual_joint_positions())",
        ] {
            assert_eq!(codes(text), [""; 0], "{text}");
        }
    }

    #[test]
    fn own_functions_are_called_as_they_are_defined() {
        let head = "def pick(pose, height, speed=0.25):\n  movel(pose, v=speed * height)\nend\n";
        for (call, code) in [
            ("pick([0.4, 0, 0.3, 3.14, 0, 0])", "missing-argument"),
            ("pick(1, 2, 3, 4)", "argument-count"),
            ("pick(1, 2, sped=3)", "unknown-argument"),
        ] {
            assert_eq!(codes(&format!("{head}{call}\n")), [code], "{call}");
        }
        for call in [
            "pick(1, 2)",
            "pick(pose=1, height=2)",
            "a = (1, 2)\npick(*a)",
            "pick = print\npick(1)",
        ] {
            assert_eq!(codes(&format!("{head}{call}\n")), [""; 0], "{call}");
        }
        let found = check(
            SourceFile::new("a.script", format!("{head}pick(1)\n")),
            &known_names(),
        );
        assert_eq!(found[0].message, "pick() needs 'height'");
        let help = text!(
            "call it as pick(pose, height, speed)",
            "调用写作 pick(pose, height, speed)"
        );
        assert_eq!(found[0].help, Some(help));
    }

    fn said(text: &str) -> Vec<String> {
        let found = check(SourceFile::new("test.script", text), &known_names());
        let messages = found.iter().map(|finding| finding.message.to_string());
        messages.collect()
    }

    #[test]
    fn what_the_declaration_refuses_is_found_in_the_text() {
        for (text, message) in [
            (
                "movej([0,0,0,0,0,0], speed=1)",
                "movej() has no parameter 'speed'",
            ),
            ("sleep()", "sleep() needs 't'"),
            ("sync(1)", "sync() takes at most 0 arguments, got 1"),
            ("sleep(1, t=2)", "sleep(): 't' is given twice"),
            (
                "set_payload(-1, [0, 0, 0])",
                "set_payload(): m must be a number >= 0, got -1",
            ),
            (
                "movej([0,0,0,0,0,0], v=-0.5)",
                "movej(): v must be a number > 0, got -0.5",
            ),
            (
                "movej([0, 1.5, 0, 0, 0])",
                "movej(): q must be six joint positions in rad, got 5 numbers",
            ),
            (
                "set_standard_digital_out(16, True)",
                "set_standard_digital_out(): n must be -1 to 15, got 16",
            ),
            (
                "rpc_factory('soap', '127.0.0.1:1')",
                "rpc_factory(): type must be \"xmlrpc\", got \"soap\"",
            ),
        ] {
            assert_eq!(said(text), [message], "{text}");
        }
        let wrong_name = check(
            SourceFile::new("test.script", "sleep(seconds=1)"),
            &known_names(),
        );
        assert_eq!(wrong_name.len(), 1, "{wrong_name:?}");
        let message = text!(
            "sleep() has no parameter 'seconds'",
            "sleep() 没有参数 'seconds'"
        );
        let help = text!("its parameters are t", "它的参数有 t");
        assert_eq!(wrong_name[0].message, message);
        assert_eq!(wrong_name[0].help, Some(help));
    }

    #[test]
    fn a_function_of_a_later_edition_is_told_as_such() {
        let text = "set_tool_second_power_on(True)\n";
        let found = check(SourceFile::new("test.script", text), &known_names());
        let later = found.iter().find(|finding| finding.code == "later-edition");
        let later = later.expect("it is found");
        assert!(
            later.message.english().contains("edition 2.16"),
            "{later:?}"
        );
        assert!(later.help.is_some());
        let chinese = later.message.in_language(Language::Chinese);
        assert!(chinese.contains("2.16 版"), "{chinese}");
        let own = format!("def set_tool_second_power_on(on):\n  pass\nend\n{text}");
        assert_eq!(said(&own), [""; 0]);
    }

    #[test]
    fn names_that_the_program_binds_are_not_the_robots() {
        for text in [
            "def sleep(): pass\nsleep()\n",
            "def f(sync):\n  sync(1)\nf(print)\n",
            "from math import *\nsleep()\n",
            "for sync in [print]:\n  sync(1)\n",
            "a = (1,)\nsleep(*a)\nb = {'t': 1}\nsleep(**b)\n",
        ] {
            assert_eq!(said(text), [""; 0], "{text}");
        }
    }

    #[test]
    fn what_is_right_passes() {
        for text in [
            "movej([0, -1.57, 1.57, -1.57, -1.57, 0], a=1.2)",
            "movel([0.4, 0, 0.3, 3.14, 0, 0])",
            "movej(get_inverse_kin([0.4, 0, 0.3, 3.14, 0, 0]))",
            "movel(pose_trans(get_actual_tcp_pose(), [0, 0, 0.1, 0, 0, 0]))",
            "while get_actual_tcp_pose()[2] > 0.1: sync()",
        ] {
            assert_eq!(codes(text), [""; 0], "{text}");
        }
    }
}
