//! Manual chapter 4: the force sensor.

use elite_lang::{Raised, Value};
use motion_api::CommandKind;

use super::call::Call;
use super::declare::{Builtin, Category, Default, Kind, Parameter, Range};

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
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
            Kind::Boolean,
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
            Parameter::new("enable", Kind::Boolean, "", "True: it does"),
            Parameter::new(
                "sensor_mass",
                Kind::Number(Range::Between(0.0, 1000.0)),
                "kg",
                "mass of the sensor that is read; its weight is taken off",
            )
            .or(Default::Number(0.0)),
            Parameter::new(
                "sensor_measuring_offset",
                Kind::Numbers(3),
                "m",
                "what its moments are about, from the flange; zero means the TCP",
            )
            .or(Default::Zeros),
            Parameter::new(
                "sensor_cog",
                Kind::Numbers(3),
                "m",
                "its centre of gravity, from the flange",
            )
            .or(Default::Zeros),
        ],
        returns: "nothing",
        waits: false,
        run: Some(ft_rtsi_input_enable),
    },
];

fn zero_ftsensor(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    call.perform(CommandKind::ZeroFtSensor)?;
    Ok(Value::None)
}

fn force(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let [x, y, z, ..] = call.context().robot().state().tcp_force;
    Ok(Value::Float((x * x + y * y + z * z).sqrt()))
}

fn get_tcp_force(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let is_compensated = call.boolean(0)?;
    let state = call.context().robot().state();
    let wrench = if is_compensated {
        state.tcp_force
    } else {
        state.raw_wrench
    };
    Ok(Value::list_of_f64(&wrench))
}

fn ft_rtsi_input_enable(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let enabled = call.boolean(0)?;
    let mass = call.number(1)?;
    let measuring_offset = call.numbers(2)?;
    let cog = call.numbers(3)?;
    call.perform(CommandKind::FtRtsiInput {
        enabled,
        mass,
        measuring_offset,
        cog,
    })?;
    Ok(Value::None)
}
