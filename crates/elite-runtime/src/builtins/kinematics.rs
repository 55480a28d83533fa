//! Manual 3.2.1 to 3.2.4 and 3.1.35: forward and inverse kinematics, and whether a position is allowed.
//!
//! Owns the declarations and what omitted arguments mean; the mathematics is `kinematics::RobotModel`.

use ::kinematics::safety::CI_PAIRS;
use ::kinematics::{JointPositions, PlaneSwitches, Pose};
use elite_lang::{ExceptionKind, Unwind, Value};
use messages::text;
use motion_api::{RobotState, SafetyMode};

use super::call::Call;
use super::declare::{Builtin, Category, Parameter, ParameterDefault, ParameterType, phrase};

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "get_inverse_kin",
        section: "3.2.1",
        category: Category::Math,
        summary: phrase(
            "Joint positions that reach a TCP pose: the solution nearest to qnear.",
            "到达 TCP 位姿的关节位置：取最接近 qnear 的解。",
        ),
        params: &[TARGET, QNEAR, TCP],
        returns: phrase("list[6] float, rad", "list[6] float，rad"),
        waits: false,
        run: Some(get_inverse_kin),
    },
    Builtin {
        name: "get_inverse_kin_has_solution",
        section: "3.2.2",
        category: Category::Math,
        summary: phrase(
            "Whether get_inverse_kin finds joint positions.",
            "get_inverse_kin 能否找到关节位置。",
        ),
        params: &[TARGET, QNEAR, TCP],
        returns: phrase("bool", "bool"),
        waits: false,
        run: Some(get_inverse_kin_has_solution),
    },
    Builtin {
        name: "get_all_inverse_kin",
        section: "3.2.3",
        category: Category::Math,
        summary: phrase(
            "Every joint position that reaches a TCP pose: by shoulder, then wrist, then elbow.",
            "到达 TCP 位姿的全部关节位置：依次按肩、腕、肘排列。",
        ),
        params: &[TARGET, TCP],
        returns: phrase(
            "list of list[6] float, rad, each in [-pi, pi); empty when the pose is out of reach",
            "list[6] float 的列表，rad，各在 [-pi, pi) 内；位姿不可达时为空",
        ),
        waits: false,
        run: Some(get_all_inverse_kin),
    },
    Builtin {
        name: "get_forward_kin",
        section: "3.2.4",
        category: Category::Math,
        summary: phrase("TCP pose for joint positions.", "关节位置对应的 TCP 位姿。"),
        params: &[
            Parameter {
                name: "q",
                aliases: &[],
                kind: ParameterType::Joints,
                default: ParameterDefault::Symbolic(""),
                unit: "rad",
                meaning: phrase(
                    "joint positions; default: the current ones",
                    "关节位置；默认为当前位置",
                ),
            },
            TCP,
        ],
        returns: phrase("list[6] float, m and rad", "list[6] float，m 和 rad"),
        waits: false,
        run: Some(get_forward_kin),
    },
    Builtin {
        name: "is_within_safety_limits",
        section: "3.1.35",
        category: Category::Motion,
        summary: phrase(
            "Whether a TCP pose, or joint positions given as q, can be reached inside joint \
             ranges and safety planes.",
            "TCP 位姿（或以 q 给出的关节位置）能否在关节范围和安全平面内到达。",
        ),
        params: &[
            Parameter {
                default: ParameterDefault::Symbolic(""),
                meaning: phrase(
                    "TCP pose in the base frame; either this or q",
                    "基坐标系下的 TCP 位姿；与 q 二选一",
                ),
                ..TARGET
            },
            Parameter {
                name: "qNear",
                aliases: &["qnear"],
                ..QNEAR
            },
            Parameter {
                name: "ciPair",
                aliases: &[],
                kind: ParameterType::Booleans(Some(CI_PAIRS)),
                default: ParameterDefault::Symbolic(""),
                unit: "",
                meaning: phrase(
                    "which pairs of configurable inputs (CI0/1, CI2/3, CI4/5, CI6/7) count as set; \
                          default: as they are",
                    "哪些可配置输入对（CI0/1、CI2/3、CI4/5、CI6/7）视为有效；默认为其实际状态",
                ),
            },
            Parameter {
                name: "q",
                aliases: &[],
                meaning: phrase(
                    "joint positions instead of p, by name",
                    "按名称给出，代替 p 的关节位置",
                ),
                ..QNEAR
            },
        ],
        returns: phrase("bool", "bool"),
        waits: false,
        run: Some(is_within_safety_limits),
    },
];

const TARGET: Parameter = Parameter {
    name: "p",
    aliases: &[],
    kind: ParameterType::Pose,
    default: ParameterDefault::Required,
    unit: "m, rad",
    meaning: phrase("TCP pose in the base frame", "基坐标系下的 TCP 位姿"),
};

const QNEAR: Parameter = Parameter {
    name: "qnear",
    aliases: &["qNear"],
    kind: ParameterType::Joints,
    default: ParameterDefault::Symbolic(""),
    unit: "rad",
    meaning: phrase(
        "the solution closest to this is taken; default: the current joint positions",
        "取最接近它的解；默认为当前关节位置",
    ),
};

const TCP: Parameter = Parameter {
    name: "tcp",
    aliases: &[],
    kind: ParameterType::Pose,
    default: ParameterDefault::Symbolic("active tcp"),
    unit: "m, rad",
    meaning: phrase(
        "TCP in the flange frame; default: the active one",
        "法兰坐标系下的 TCP；默认为当前生效的 TCP",
    ),
};

fn get_forward_kin(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let state = call.state();
    let q = call.joints_or_default(0)?.unwrap_or(state.actual_q);
    let flange_from_tcp = Pose::from_rpy(&call.pose_or_default(1)?.unwrap_or(state.tcp_offset));
    let base_from_tcp = call
        .context()
        .robot()
        .model()
        .tcp_pose(&q, &flange_from_tcp);
    Ok(Value::list_of_f64(&base_from_tcp.to_rpy().to_array()))
}

/// The solution nearest to the second argument, for the pose and tool in the first and third.
fn nearest(call: &mut Call<'_, '_>) -> Result<Option<JointPositions>, Unwind> {
    let state = call.state();
    let target = Pose::from_rpy(&call.pose(0)?);
    let near = call.joints_or_default(1)?.unwrap_or(state.actual_q);
    let flange_from_tcp = Pose::from_rpy(&call.pose_or_default(2)?.unwrap_or(state.tcp_offset));
    let model = call.context().robot().model();
    Ok(model.inverse_nearest(&target, &flange_from_tcp, &near))
}

fn get_inverse_kin(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    match nearest(call)? {
        Some(q) => Ok(Value::list_of_f64(&q.0)),
        None => {
            let text = text!(
                "get_inverse_kin(): no joint positions of {} reach p = {:?} with this TCP",
                "get_inverse_kin()：{} 没有关节位置能以此 TCP 到达 p = {:?}",
                call.context().robot().model().name(),
                call.pose(0)?.to_array()
            );
            Err(call.error(ExceptionKind::RuntimeError, text))
        }
    }
}

fn get_inverse_kin_has_solution(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    Ok(Value::Bool(nearest(call)?.is_some()))
}

fn get_all_inverse_kin(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let state = call.state();
    let target = Pose::from_rpy(&call.pose(0)?);
    let flange_from_tcp = Pose::from_rpy(&call.pose_or_default(1)?.unwrap_or(state.tcp_offset));
    let model = call.context().robot().model();
    let found = model.inverse_all(&target, &flange_from_tcp);
    let rows = found.iter().map(|q| Value::list_of_f64(&q.0));
    Ok(Value::list(rows.collect()))
}

/// The safety planes that count in this state: those of its mode, and those whose pair of inputs is high.
fn plane_switches(state: &RobotState) -> PlaneSwitches {
    /// Bit of the first configurable input in `digital_in`.
    const CI0: usize = 16;
    PlaneSwitches {
        reduced: state.safety_mode == SafetyMode::Reduced,
        ci_pairs: std::array::from_fn(|pair| state.digital_in >> (CI0 + 2 * pair) & 0b11 == 0b11),
    }
}

fn is_within_safety_limits(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let (no_pose, no_joints) = (call.is_symbolic_default(0), call.is_symbolic_default(3));
    if no_pose == no_joints {
        let what = if no_pose { "neither is" } else { "both are" };
        let text = text!(
            "is_within_safety_limits(): either p or q must be given, {what}",
            "is_within_safety_limits()：必须给出 p 或 q，{what}"
        );
        return Err(call.error(ExceptionKind::ValueError, text));
    }
    let robot = call.context().robot();
    let state = call.state();
    let mut switches = plane_switches(&state);
    if !call.is_symbolic_default(2) {
        for (slot, set) in switches.ci_pairs.iter_mut().zip(call.booleans(2)?) {
            *slot = set;
        }
    }
    let near = call.joints_or_default(1)?.unwrap_or(state.actual_q);
    let tcp = Pose::from_rpy(&state.tcp_offset);
    let (bounds, model) = (robot.safety_bounds(), robot.model());
    let q = if no_pose {
        Some(call.joints(3)?)
    } else {
        model.inverse_nearest(&Pose::from_rpy(&call.pose(0)?), &tcp, &near)
    };
    // The checks of joint ranges, planes and links are those that a motion's target has to pass.
    let is_allowed = q.is_some_and(|q| {
        let violation = bounds.violation_at(model, &q, &tcp, &switches);
        violation.is_none() && bounds.link_violation(model, &q, &state.target_q).is_none()
    });
    Ok(Value::Bool(is_allowed))
}
