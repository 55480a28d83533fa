//! Manual 3.2: forward and inverse kinematics.

use ::kinematics::Pose;
use elite_lang::{ExceptionKind, Raised, Value};

use super::call::Call;
use super::declare::{Builtin, Category, Default, Kind, Parameter};

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "get_inverse_kin",
        section: "3.2.1",
        category: Category::Math,
        summary: "Joint positions that reach a TCP pose: the solution nearest to qnear.",
        params: &[
            Parameter {
                name: "p",
                aliases: &[],
                kind: Kind::Pose,
                default: Default::Required,
                unit: "m, rad",
                meaning: "TCP pose in the base frame",
            },
            Parameter {
                name: "qnear",
                aliases: &["qNear"],
                kind: Kind::Joints,
                default: Default::Symbolic(""),
                unit: "rad",
                meaning: "the solution closest to this is returned; default: the current joint positions",
            },
            TCP,
        ],
        returns: "list[6] float, rad",
        waits: false,
        run: Some(get_inverse_kin),
    },
    Builtin {
        name: "get_forward_kin",
        section: "3.2.4",
        category: Category::Math,
        summary: "TCP pose for joint positions.",
        params: &[
            Parameter {
                name: "q",
                aliases: &[],
                kind: Kind::Joints,
                default: Default::Symbolic(""),
                unit: "rad",
                meaning: "joint positions; default: the current ones",
            },
            TCP,
        ],
        returns: "list[6] float, m and rad",
        waits: false,
        run: Some(get_forward_kin),
    },
];

const TCP: Parameter = Parameter {
    name: "tcp",
    aliases: &[],
    kind: Kind::Pose,
    default: Default::Symbolic("active tcp"),
    unit: "m, rad",
    meaning: "TCP in the flange frame; default: the active one",
};

fn get_forward_kin(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let state = call.context().robot().state();
    let q = call.joints_or_default(0)?.unwrap_or(state.actual_q);
    let flange_from_tcp = Pose::from_rpy(&call.pose_or_default(1)?.unwrap_or(state.tcp_offset));
    let base_from_tcp = call
        .context()
        .robot()
        .model()
        .tcp_pose(&q, &flange_from_tcp);
    Ok(Value::list_of_f64(&base_from_tcp.to_rpy().to_array()))
}

fn get_inverse_kin(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let state = call.context().robot().state();
    let target = call.pose(0)?;
    let near = call.joints_or_default(1)?.unwrap_or(state.actual_q);
    let flange_from_tcp = Pose::from_rpy(&call.pose_or_default(2)?.unwrap_or(state.tcp_offset));
    let model = call.context().robot().model();
    match model.inverse_nearest(&Pose::from_rpy(&target), &flange_from_tcp, &near) {
        Some(q) => Ok(Value::list_of_f64(&q.0)),
        None => {
            let text = format!(
                "get_inverse_kin(): no joint positions of {} reach p = {:?} with this TCP",
                model.name(),
                target.to_array()
            );
            Err(call.error(ExceptionKind::RuntimeError, text))
        }
    }
}
