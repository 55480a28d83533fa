//! Manual 3.1: what the arm does and carries, gravity, freedrive and collision detection.

use ::kinematics::Pose;
use elite_lang::{Unwind, Value};
use motion_api::{OnlineCommand, RobotState, SensingCommand, SettingCommand};

use super::call::Call;
use super::declare::{Builtin, Category, Parameter, ParameterDefault, ParameterType, phrase};

/// A builtin without parameters that reads the latest state.
macro_rules! getter {
    ($name:literal, $section:literal, $summary:expr, $returns:expr, $read:expr $(,)?) => {
        Builtin {
            name: $name,
            section: $section,
            category: Category::Motion,
            summary: $summary,
            params: &[],
            returns: $returns,
            waits: false,
            run: Some(|call| {
                let read: fn(&RobotState) -> Value = $read;
                Ok(read(&call.state()))
            }),
        }
    };
}

/// The builtins of these sections; the getters that moves are usually seen with are in `motion`.
pub const BUILTINS: &[Builtin] = &[
    getter!(
        "get_actual_joint_speeds",
        "3.1.5",
        phrase("Measured joint speeds.", "实际关节速度。"),
        phrase("list[6] float, rad/s", "list[6] float，rad/s"),
        |state| { Value::list_of_f64(&state.actual_qd.0) }
    ),
    getter!(
        "get_actual_tcp_speed",
        "3.1.8",
        phrase(
            "Measured TCP velocity in the base frame: linear, then angular.",
            "基坐标系下的实际 TCP 速度：先线速度，后角速度。"
        ),
        phrase(
            "list[6] float, m/s and rad/s",
            "list[6] float，m/s 和 rad/s"
        ),
        |state| { Value::list_of_f64(&state.actual_tcp_speed) }
    ),
    getter!(
        "get_controller_temperature",
        "3.1.9",
        phrase("Temperature of the control box.", "控制柜温度。"),
        phrase("float, °C", "float，°C"),
        |state| { Value::Float(state.controller_temperature) }
    ),
    getter!(
        "get_joint_temperatures",
        "3.1.10",
        phrase("Temperatures of the joints.", "各关节温度。"),
        phrase("list[6] float, °C", "list[6] float，°C"),
        |state| { Value::list_of_f64(&state.joint_temperatures) }
    ),
    getter!(
        "get_joint_torques",
        "3.1.11",
        phrase(
            "Joint torques less what the arm needs for its own motion: about 0 while nothing \
             touches it.",
            "关节力矩减去手臂自身运动所需的部分：无接触时约为 0。"
        ),
        phrase("list[6] float, Nm", "list[6] float，Nm"),
        |state| Value::list_of_f64(&state.external_torque.0.map(|torque| -torque)),
    ),
    getter!(
        "get_target_joint_speeds",
        "3.1.13",
        phrase("Commanded joint speeds.", "目标关节速度。"),
        phrase("list[6] float, rad/s", "list[6] float，rad/s"),
        |state| { Value::list_of_f64(&state.target_qd.0) }
    ),
    getter!(
        "get_target_tcp_pose",
        "3.1.14",
        phrase(
            "Commanded TCP pose in the base frame.",
            "基坐标系下的目标 TCP 位姿。"
        ),
        phrase("list[6] float, m and rad", "list[6] float，m 和 rad"),
        |state| { Value::list_of_f64(&state.target_tcp_pose.to_array()) }
    ),
    getter!(
        "get_target_tcp_speed",
        "3.1.15",
        phrase(
            "Commanded TCP velocity in the base frame: linear, then angular.",
            "基坐标系下的目标 TCP 速度：先线速度，后角速度。"
        ),
        phrase(
            "list[6] float, m/s and rad/s",
            "list[6] float，m/s 和 rad/s"
        ),
        |state| { Value::list_of_f64(&state.target_tcp_speed) }
    ),
    Builtin {
        name: "set_gravity",
        section: "3.1.16",
        category: Category::Motion,
        summary: phrase(
            "Sets the acceleration that the mounted arm feels: away from the centre of the earth.",
            "设置手臂安装后感受到的加速度：方向背离地心。",
        ),
        params: &[Parameter::new(
            "d",
            ParameterType::Numbers(3),
            "m/s^2",
            phrase(
                "in the base frame; [0, 0, 9.82] for an upright arm",
                "基坐标系下的值；正装手臂为 [0, 0, 9.82]",
            ),
        )],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(set_gravity),
    },
    getter!(
        "get_target_payload_cog",
        "3.1.18",
        phrase(
            "Centre of gravity of the active payload in the flange frame.",
            "当前负载在法兰坐标系下的重心。"
        ),
        phrase("list[3] float, m", "list[3] float，m"),
        |state| Value::list_of_f64(state.payload.cog.as_slice()),
    ),
    getter!(
        "get_target_payload_mass",
        "3.1.19",
        phrase("Mass of the active payload.", "当前负载的质量。"),
        phrase("float, kg", "float，kg"),
        |state| Value::Float(state.payload.mass),
    ),
    getter!(
        "get_target_waypoint",
        "3.1.34",
        phrase(
            "TCP pose that the motion under way leads to; the commanded pose without one.",
            "当前运动要到达的 TCP 位姿；没有运动时为目标位姿。"
        ),
        phrase("list[6] float, m and rad", "list[6] float，m 和 rad"),
        |state| Value::list_of_f64(&state.target_waypoint.to_array()),
    ),
    getter!(
        "get_tcp_offset",
        "3.1.36",
        phrase(
            "Active TCP relative to the flange.",
            "当前 TCP 相对于法兰的位姿。"
        ),
        phrase("list[6] float, m and rad", "list[6] float，m 和 rad"),
        |state| Value::list_of_f64(&state.tcp_offset.to_array()),
    ),
    Builtin {
        name: "get_actual_tool_flange_pose",
        section: "3.1.33",
        category: Category::Motion,
        summary: phrase(
            "Measured pose of the tool flange in the base frame.",
            "基坐标系下的实际工具法兰位姿。",
        ),
        params: &[],
        returns: phrase("list[6] float, m and rad", "list[6] float，m 和 rad"),
        waits: false,
        run: Some(get_actual_tool_flange_pose),
    },
    Builtin {
        name: "freedrive_mode",
        section: "3.1.41",
        category: Category::Motion,
        summary: phrase(
            "Lets the arm be led by hand along and about the free axes.",
            "允许用手沿自由轴拖动手臂。",
        ),
        params: &[
            Parameter::new(
                "freeAxes",
                ParameterType::Booleans(Some(6)),
                "",
                phrase(
                    "1 for every one of x, y, z, rx, ry, rz that may move",
                    "x、y、z、rx、ry、rz 中允许移动的各项为 1",
                ),
            )
            .or(ParameterDefault::Ones),
            Parameter::new(
                "frame",
                ParameterType::Frame,
                "m, rad",
                phrase(
                    "whose axes: a pose relative to the base, \"base\" or \"tool\"",
                    "采用哪个坐标系的轴：相对基座的位姿、\"base\" 或 \"tool\"",
                ),
            )
            .or(ParameterDefault::Zeros),
        ],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(freedrive_mode),
    },
    Builtin {
        name: "end_freedrive_mode",
        section: "3.1.42",
        category: Category::Motion,
        summary: phrase(
            "Back to position control; the end of the task does it too.",
            "回到位置控制；任务结束时也会自动退出。",
        ),
        params: &[],
        returns: phrase(
            "nothing; the arm comes to rest meanwhile, and the next motion waits for that",
            "无返回值；手臂随后停稳，下一个运动会等待",
        ),
        waits: false,
        run: Some(end_freedrive_mode),
    },
    Builtin {
        name: "set_collision_detect_enabled",
        section: "3.1.43",
        category: Category::Motion,
        summary: phrase(
            "Switches collision detection on or off.",
            "开启或关闭碰撞检测。",
        ),
        params: &[Parameter::new(
            "enabled",
            ParameterType::Boolean,
            "",
            phrase("True switches it on", "True 为开启"),
        )],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(set_collision_detect_enabled),
    },
    getter!(
        "is_collision_detect_enabled",
        "3.1.44",
        phrase("Whether collision detection is on.", "碰撞检测是否开启。"),
        phrase("bool", "bool"),
        |state| Value::Bool(state.collision_detection),
    ),
    getter!(
        "get_dyn_collision_force_min_ratio",
        "3.1.45",
        phrase("Sensitivity of collision detection.", "碰撞检测的灵敏度。"),
        phrase("int, %", "int，%"),
        |state| Value::Int(state.collision_sensitivity as i64),
    ),
    Builtin {
        name: "set_dyn_collision_force_min_ratio",
        section: "3.1.46",
        category: Category::Motion,
        summary: phrase(
            "Sets the sensitivity of collision detection; 100 is the most sensitive.",
            "设置碰撞检测的灵敏度；100 最灵敏。",
        ),
        params: &[Parameter::new(
            "ratio",
            ParameterType::Integer(10, 100),
            "%",
            phrase("sensitivity", "灵敏度"),
        )],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(set_dyn_collision_force_min_ratio),
    },
];

fn set_gravity(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    // The manual gives what the arm feels, the dynamics want free fall: the opposite.
    let felt: [f64; 3] = call.numbers(0)?;
    call.set(SettingCommand::SetGravity(felt.map(|x| 0.0 - x)))?;
    Ok(Value::None)
}

fn get_actual_tool_flange_pose(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let robot = call.context().robot();
    let q = robot.state().actual_q;
    let pose = robot.model().tcp_pose(&q, &Pose::IDENTITY);
    Ok(Value::list_of_f64(&pose.to_rpy().to_array()))
}

fn freedrive_mode(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let mut free_axes = [true; 6];
    if call.given(0).is_some() {
        for (free, given) in free_axes.iter_mut().zip(call.booleans(0)?) {
            *free = given;
        }
    }
    let frame = call.frame(1)?;
    call.set(OnlineCommand::Freedrive { free_axes, frame })?;
    Ok(Value::None)
}

fn end_freedrive_mode(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    call.set(OnlineCommand::EndFreedrive)?;
    Ok(Value::None)
}

fn set_collision_detect_enabled(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let enabled = call.boolean(0)?;
    call.set(SensingCommand::SetCollisionDetection(enabled))?;
    Ok(Value::None)
}

fn set_dyn_collision_force_min_ratio(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let ratio = call.integer(0)? as u8;
    call.set(SensingCommand::SetCollisionSensitivity(ratio))?;
    Ok(Value::None)
}
