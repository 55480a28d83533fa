//! Manual chapter 4: force mode and the force sensor.

use elite_lang::{Unwind, Value};
use motion_api::{OverlayCommand, SensingCommand};

use super::call::Call;
use super::declare::{Builtin, Category, Parameter, ParameterDefault, ParameterType, Range};

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "force_mode",
        section: "4.1",
        category: Category::Force,
        summary: "Presses with a wrench along the selected axes, while the others follow the motion that runs.",
        params: &[
            Parameter::new(
                "reference_frame",
                ParameterType::Pose,
                "m, rad",
                "the force reference frame in the base frame",
            ),
            Parameter::new(
                "selection_vector",
                ParameterType::Numbers(6),
                "",
                "for x, y, z, rx, ry, rz: 0 follows the motion, any other number is force controlled",
            ),
            Parameter::new(
                "target_wrench",
                ParameterType::Numbers(6),
                "N, Nm",
                "what the tool applies to the environment, in the force frame",
            ),
            Parameter::new(
                "mode",
                ParameterType::Integer(0, 3),
                "",
                "the force frame: 0 the reference frame, 1 Y to its origin, 2 X along the motion, 3 the TCP frame",
            ),
            Parameter::new(
                "speed_limits",
                ParameterType::Numbers(6),
                "m/s, rad/s",
                "largest TCP speeds along the force controlled axes; 0 or more",
            ),
        ],
        returns: "nothing",
        waits: false,
        run: Some(force_mode),
    },
    Builtin {
        name: "force_mode_set_gain_scaling",
        section: "4.2",
        category: Category::Force,
        summary: "How fast forces approach their targets; 0.2 after start, kept until the controller ends.",
        params: &[Parameter::new(
            "scaling",
            ParameterType::Number(Range::Any),
            "",
            "0 to 2, clamped; larger is faster and overshoots more",
        )
        .also(&["scoring"])],
        returns: "nothing",
        waits: false,
        run: Some(force_mode_set_gain_scaling),
    },
    Builtin {
        name: "force_mode_set_damping",
        section: "4.3",
        category: Category::Force,
        summary: "How fast force axes come to rest without a force; 0 after start, kept until the controller ends.",
        params: &[Parameter::new(
            "damping",
            ParameterType::Number(Range::Any),
            "",
            "0 to 1, clamped; 0 keeps the speed",
        )],
        returns: "nothing",
        waits: false,
        run: Some(force_mode_set_damping),
    },
    Builtin {
        name: "end_force_mode",
        section: "4.7",
        category: Category::Force,
        summary: "Back to position control; the end of the task does it too.",
        params: &[],
        returns: "nothing; the arm comes to rest meanwhile, and the next motion waits for that",
        waits: false,
        run: Some(end_force_mode),
    },
    Builtin {
        name: "zero_ftsensor",
        section: "4.4",
        category: Category::Force,
        summary: "What the compensated force sensor reads now counts as nothing; replaces the zero before.",
        params: &[],
        returns: "nothing",
        waits: false,
        run: Some(zero_ftsensor),
    },
    Builtin {
        name: "force",
        section: "4.5",
        category: Category::Force,
        summary: "Size of the force on the TCP: of the first three numbers of get_tcp_force(True).",
        params: &[],
        returns: "float, N",
        waits: false,
        run: Some(force),
    },
    Builtin {
        name: "get_tcp_force",
        section: "4.6",
        category: Category::Force,
        summary: "What the environment applies to the tool, in the TCP frame, moments about the TCP.",
        params: &[Parameter::new(
            "enable_compensation",
            ParameterType::Boolean,
            "",
            "True: without weight and inertia of the payload, and zeroed; False: as the sensor reads",
        )],
        returns: "list[6] float, N and Nm",
        waits: false,
        run: Some(get_tcp_force),
    },
    Builtin {
        name: "ft_rtsi_input_enable",
        section: "",
        category: Category::Force,
        summary: "Whether the RTSI input external_force_torque acts on the tool (base axes).",
        params: &[
            Parameter::new("enable", ParameterType::Boolean, "", "True: it does"),
            Parameter::new(
                "sensor_mass",
                ParameterType::Number(Range::Between(0.0, 1000.0)),
                "kg",
                "mass of the sensor that is read; its weight is taken off",
            )
            .or(ParameterDefault::Number(0.0)),
            Parameter::new(
                "sensor_measuring_offset",
                ParameterType::Numbers(3),
                "m",
                "what its moments are about, from the flange; zero means the TCP",
            )
            .or(ParameterDefault::Zeros),
            Parameter::new(
                "sensor_cog",
                ParameterType::Numbers(3),
                "m",
                "its centre of gravity, from the flange",
            )
            .or(ParameterDefault::Zeros),
        ],
        returns: "nothing",
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
        let given = format!("{} at [{k}]", speed_limits[k]);
        return Err(call.not_allowed(4, "six numbers of at least 0", given));
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
