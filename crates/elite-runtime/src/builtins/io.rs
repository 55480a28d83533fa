//! Manual chapter 5: digital inputs and outputs.

use elite_lang::{Raised, Value};
use motion_api::CommandKind;

use super::call::Call;
use super::declare::{Builtin, Category, Default, Kind, Parameter};

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "get_standard_digital_out",
        section: "5.6",
        category: Category::Io,
        summary: "Level of a standard digital output.",
        params: &[INDEX],
        returns: "bool",
        waits: false,
        run: Some(get_standard_digital_out),
    },
    Builtin {
        name: "set_standard_digital_out",
        section: "5.13",
        category: Category::Io,
        summary: "Sets a standard digital output; the level is applied in the next cycle.",
        params: &[
            INDEX,
            Parameter {
                name: "b",
                aliases: &[],
                kind: Kind::Boolean,
                default: Default::Required,
                unit: "",
                meaning: "level",
            },
        ],
        returns: "nothing",
        waits: false,
        run: Some(set_standard_digital_out),
    },
];

const INDEX: Parameter = Parameter {
    name: "n",
    aliases: &[],
    kind: Kind::Integer(0, 15),
    default: Default::Required,
    unit: "",
    meaning: "number of the output",
};

fn get_standard_digital_out(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let index = call.integer(0)? as u8;
    Ok(Value::Bool(
        call.context().robot().standard_digital_out(index),
    ))
}

fn set_standard_digital_out(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let index = call.integer(0)? as u8;
    let level = call.boolean(1)?;
    call.send(CommandKind::SetStandardDigitalOut { index, level })?;
    Ok(Value::None)
}
