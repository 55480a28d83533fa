//! Manual chapter 4: force mode and the force sensor.

use elite_lang::{Unwind, Value};
use messages::text;
use motion_api::{OverlayCommand, SensingCommand};

use super::call::Call;
use super::declare::{
    Builtin, Category, Parameter, ParameterDefault, ParameterType, Range, phrase,
};

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "force_mode",
        section: "4.1",
        category: Category::Force,
        summary: phrase(
            "Presses with a wrench along the selected axes, while the others follow the motion \
             that runs.",
            "沿选定的轴以给定力旋量施力，其余轴跟随正在进行的运动。",
        ),
        params: &[
            Parameter::new(
                "reference_frame",
                ParameterType::Pose,
                "m, rad",
                phrase(
                    "the force reference frame in the base frame",
                    "基坐标系下的力参考坐标系",
                ),
            ),
            Parameter::new(
                "selection_vector",
                ParameterType::Numbers(6),
                "",
                phrase(
                    "for x, y, z, rx, ry, rz: 0 follows the motion, any other number is force \
                     controlled",
                    "对应 x、y、z、rx、ry、rz：0 跟随运动，其余数为力控",
                ),
            ),
            Parameter::new(
                "target_wrench",
                ParameterType::Numbers(6),
                "N, Nm",
                phrase(
                    "what the tool applies to the environment, in the force frame",
                    "工具对环境施加的力旋量，在力坐标系下",
                ),
            ),
            Parameter::new(
                "mode",
                ParameterType::Integer(0, 3),
                "",
                phrase(
                    "the force frame: 0 the reference frame, 1 Y to its origin, 2 X along the \
                     motion, 3 the TCP frame",
                    "力坐标系：0 参考坐标系，1 Y 轴指向其原点，2 X 轴沿运动方向，3 TCP 坐标系",
                ),
            ),
            Parameter::new(
                "speed_limits",
                ParameterType::Numbers(6),
                "m/s, rad/s",
                phrase(
                    "largest TCP speeds along the force controlled axes; 0 or more",
                    "力控轴上的最大 TCP 速度；不小于 0",
                ),
            ),
        ],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(force_mode),
    },
    Builtin {
        name: "force_mode_set_gain_scaling",
        section: "4.2",
        category: Category::Force,
        summary: phrase(
            "How fast forces approach their targets; 0.2 after start, kept until the controller \
             ends.",
            "力趋近目标的快慢；启动后为 0.2，保持到控制器结束。",
        ),
        params: &[Parameter::new(
            "scaling",
            ParameterType::Number(Range::Any),
            "",
            phrase(
                "0 to 2, clamped; larger is faster and overshoots more",
                "0 到 2，超出则取边界；越大越快，超调也越大",
            ),
        )
        .also(&["scoring"])],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(force_mode_set_gain_scaling),
    },
    Builtin {
        name: "force_mode_set_damping",
        section: "4.3",
        category: Category::Force,
        summary: phrase(
            "How fast force axes come to rest without a force; 0 after start, kept until the \
             controller ends.",
            "无力时力控轴停下的快慢；启动后为 0，保持到控制器结束。",
        ),
        params: &[Parameter::new(
            "damping",
            ParameterType::Number(Range::Any),
            "",
            phrase(
                "0 to 1, clamped; 0 keeps the speed",
                "0 到 1，超出则取边界；0 保持速度",
            ),
        )],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(force_mode_set_damping),
    },
    Builtin {
        name: "end_force_mode",
        section: "4.7",
        category: Category::Force,
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
        run: Some(end_force_mode),
    },
    Builtin {
        name: "zero_ftsensor",
        section: "4.4",
        category: Category::Force,
        summary: phrase(
            "What the compensated force sensor reads now counts as nothing; replaces the zero \
             before.",
            "把补偿后力传感器的当前读数作为零点，取代之前的零点。",
        ),
        params: &[],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(zero_ftsensor),
    },
    Builtin {
        name: "force",
        section: "4.5",
        category: Category::Force,
        summary: phrase(
            "Size of the force on the TCP: of the first three numbers of get_tcp_force(True).",
            "TCP 受力的大小：get_tcp_force(True) 前三个数的模。",
        ),
        params: &[],
        returns: phrase("float, N", "float，N"),
        waits: false,
        run: Some(force),
    },
    Builtin {
        name: "get_tcp_force",
        section: "4.6",
        category: Category::Force,
        summary: phrase(
            "What the environment applies to the tool, in the TCP frame, moments about the TCP.",
            "环境对工具的作用力，在 TCP 坐标系下，力矩相对于 TCP。",
        ),
        params: &[Parameter::new(
            "enable_compensation",
            ParameterType::Boolean,
            "",
            phrase(
                "True: without weight and inertia of the payload, and zeroed; False: as the \
                 sensor reads",
                "True：去除负载的重力和惯性并清零；False：传感器原始读数",
            ),
        )],
        returns: phrase("list[6] float, N and Nm", "list[6] float，N 和 Nm"),
        waits: false,
        run: Some(get_tcp_force),
    },
    Builtin {
        name: "ft_rtsi_input_enable",
        section: "",
        category: Category::Force,
        summary: phrase(
            "Whether the RTSI input external_force_torque acts on the tool (base axes).",
            "RTSI 输入 external_force_torque 是否作用于工具（基坐标轴）。",
        ),
        params: &[
            Parameter::new(
                "enable",
                ParameterType::Boolean,
                "",
                phrase("True: it does", "True：生效"),
            ),
            Parameter::new(
                "sensor_mass",
                ParameterType::Number(Range::Between(0.0, 1000.0)),
                "kg",
                phrase(
                    "mass of the sensor that is read; its weight is taken off",
                    "所用传感器的质量；其重力会被去除",
                ),
            )
            .or(ParameterDefault::Number(0.0)),
            Parameter::new(
                "sensor_measuring_offset",
                ParameterType::Numbers(3),
                "m",
                phrase(
                    "what its moments are about, from the flange; zero means the TCP",
                    "力矩的参考点，从法兰量起；零表示 TCP",
                ),
            )
            .or(ParameterDefault::Zeros),
            Parameter::new(
                "sensor_cog",
                ParameterType::Numbers(3),
                "m",
                phrase(
                    "its centre of gravity, from the flange",
                    "其重心，从法兰量起",
                ),
            )
            .or(ParameterDefault::Zeros),
        ],
        returns: phrase("nothing", "无返回值"),
        waits: false,
        run: Some(ft_rtsi_input_enable),
    },
];

fn force_mode(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let frame = call.pose(0)?;
    // Clients send numbers, some of them other than 0 and 1.
    let selection = call.numbers(1)?.map(|x: f64| x != 0.0);
    let wrench = call.numbers(2)?;
    let mode = call.byte(3)?;
    let speed_limits: [f64; 6] = call.numbers(4)?;
    if let Some(k) = speed_limits.iter().position(|x| *x < 0.0) {
        let given = text!("{} at [{k}]", "第 [{k}] 项 {}", speed_limits[k]);
        return Err(call.not_allowed(
            4,
            &text!("six numbers of at least 0", "六个不小于 0 的数"),
            given,
        ));
    }
    call.set(OverlayCommand::ForceMode {
        frame,
        selection,
        wrench,
        mode,
        speed_limits,
    })?;
    Ok(Value::None)
}

fn force_mode_set_gain_scaling(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let gain = call.clamped(0, (0.0, 2.0))?;
    call.send(SensingCommand::SetForceGain(gain))?;
    Ok(Value::None)
}

fn force_mode_set_damping(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let damping = call.clamped(0, (0.0, 1.0))?;
    call.send(SensingCommand::SetForceDamping(damping))?;
    Ok(Value::None)
}

fn end_force_mode(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    call.set(OverlayCommand::EndForceMode)?;
    Ok(Value::None)
}

fn zero_ftsensor(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    call.set(SensingCommand::ZeroFtSensor)?;
    Ok(Value::None)
}

fn force(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let [x, y, z, ..] = call.state().tcp_force;
    Ok(Value::Float((x * x + y * y + z * z).sqrt()))
}

fn get_tcp_force(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let is_compensated = call.boolean(0)?;
    let state = call.state();
    let wrench = if is_compensated {
        state.tcp_force
    } else {
        state.raw_wrench
    };
    Ok(Value::list_of_f64(&wrench))
}

fn ft_rtsi_input_enable(call: &mut Call<'_, '_>) -> Result<Value, Unwind> {
    let enabled = call.boolean(0)?;
    let mass = call.number(1)?;
    let measuring_offset = call.numbers(2)?;
    let cog = call.numbers(3)?;
    call.set(SensingCommand::FtRtsiInput {
        enabled,
        mass,
        measuring_offset,
        cog,
    })?;
    Ok(Value::None)
}
