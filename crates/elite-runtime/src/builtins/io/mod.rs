//! Manual chapter 5: inputs and outputs.
//!
//! Setters send one change each, applied at the beginning of the next cycle; getters read the image of the latest cycle
//! with the changes on the way applied, so that a program sees what it has set.

mod calls;

use elite_lang::Value;
use motion_api::DigitalBank;

use calls::{
    digital_in, digital_out, get_tool_digital, image, set_action, set_digital_out,
    set_gp_boolean_input_action, set_input_actions_to_default, set_runstate,
    set_runstate_gp_boolean_output, set_runstate_standard_analog_output,
    set_runstate_tool_analog_output, set_standard_analog_input_domain, set_standard_analog_out,
    set_standard_analog_output_domain, set_standard_digital_out, set_tool_analog_input_domain,
    set_tool_analog_io_work_mode, set_tool_analog_output_domain, set_tool_digital,
    set_tool_digital_io_config, set_tool_voltage, standard_analog_in, standard_analog_out,
};

use super::declare::{Builtin, Category::Io, Parameter, ParameterType, Range};

const fn index(name: &'static str, last: i64) -> Parameter {
    Parameter::required(name, ParameterType::Integer(0, last), "number of the point")
}

const STANDARD: Parameter = index("n", 15);
const CONFIGURABLE: Parameter = index("n", 7);
const TOOL: Parameter = index("n", 3);
const ANALOG: Parameter = index("n", 1);
const STANDARD_PORT: Parameter = index("port", 15);
const STANDARD_OR_NONE: Parameter = Parameter::required(
    "n",
    ParameterType::Integer(-1, 15),
    "number of the point; -1: none, nothing is done",
);
const CONFIGURABLE_PORT: Parameter = index("port", 7);
const TOOL_PORT: Parameter = index("port", 3);
const REGISTER_PORT: Parameter = index("port", 127);
const ANALOG_PORT: Parameter = index("port", 1);
const PIN: Parameter = index("index", 3);
const LEVEL: Parameter = Parameter::required("b", ParameterType::Boolean, "level");
const RATIO: Parameter = Parameter::required(
    "f",
    ParameterType::Number(Range::Any),
    "part of the range of the output; beyond 0 to 1 it is set to the nearer end",
);
const DOMAIN: Parameter = Parameter::required(
    "domain",
    ParameterType::Integer(0, 1),
    "0 current, 4 to 20 mA; 1 voltage, 0 to 10 V",
);
const WORK_MODE: Parameter = Parameter::required(
    "domain",
    ParameterType::Integer(0, 3),
    "0 USART, 1 analog input, 2 analog output, 3 both",
);
const PIN_MODE: Parameter = Parameter::required(
    "mode",
    ParameterType::Integer(0, 2),
    "0 push/pull, 1 sourcing (PNP), 2 sinking (NPN)",
);
const ENABLE: Parameter = Parameter::required("enable", ParameterType::Boolean, "the pin is used");
const IS_OUT: Parameter =
    Parameter::required("is_out", ParameterType::Boolean, "True output, False input");
const RUNSTATE: Parameter = Parameter::required(
    "runstate",
    ParameterType::Integer(0, 3),
    "0 keep; 1 low when not running; 2 high when not running; 3 high while running, low otherwise",
);
const ANALOG_RUNSTATE: Parameter = Parameter::required(
    "runstate",
    ParameterType::Integer(0, 3),
    "0 keep; 1 minimum when not running; 2 maximum when not running; 3 maximum while running, minimum otherwise",
);
const ACTION: Parameter = Parameter::required(
    "action",
    ParameterType::Word(&["default", "freedrive"]),
    "what a high level sets off",
);
const VOLTAGE: Parameter = Parameter::required(
    "voltage",
    ParameterType::OneOf(&[0, 12, 24]),
    "supply voltage",
)
.in_unit("V");

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin::new(
        Io,
        "5.1",
        "get_configurable_digital_in",
        &[CONFIGURABLE],
        "bool",
        "Level of a configurable digital input.",
        |call| digital_in(call, DigitalBank::Configurable),
    ),
    Builtin::new(
        Io,
        "5.2",
        "get_configurable_digital_out",
        &[CONFIGURABLE],
        "bool",
        "Level of a configurable digital output.",
        |call| digital_out(call, DigitalBank::Configurable),
    ),
    Builtin::new(
        Io,
        "5.3",
        "get_standard_analog_in",
        &[ANALOG],
        "float, A or V by domain",
        "Value of a standard analog input.",
        standard_analog_in,
    ),
    Builtin::new(
        Io,
        "5.4",
        "get_standard_analog_out",
        &[ANALOG],
        "float, A or V by domain",
        "Value of a standard analog output.",
        standard_analog_out,
    ),
    Builtin::new(
        Io,
        "5.5",
        "get_standard_digital_in",
        &[STANDARD],
        "bool",
        "Level of a standard digital input.",
        |call| digital_in(call, DigitalBank::Standard),
    ),
    Builtin::new(
        Io,
        "5.6",
        "get_standard_digital_out",
        &[STANDARD],
        "bool",
        "Level of a standard digital output.",
        |call| digital_out(call, DigitalBank::Standard),
    ),
    Builtin::new(
        Io,
        "5.7",
        "get_tool_analog_in",
        &[],
        "float, A or V by domain",
        "Value of the analog input of the tool.",
        |call| Ok(Value::Float(image(call).analog_in[2])),
    ),
    Builtin::new(
        Io,
        "5.8",
        "get_tool_analog_out",
        &[],
        "float, A or V by domain",
        "Value of the analog output of the tool.",
        |call| Ok(Value::Float(image(call).analog_out()[2])),
    ),
    Builtin::new(
        Io,
        "5.9",
        "set_standard_analog_output_domain",
        &[ANALOG_PORT, DOMAIN],
        "nothing",
        "Makes a standard analog output a current or a voltage.",
        set_standard_analog_output_domain,
    ),
    Builtin::new(
        Io,
        "5.10",
        "set_configurable_digital_out",
        &[CONFIGURABLE, LEVEL],
        "nothing",
        "Sets a configurable digital output; the level is applied in the next cycle.",
        |call| set_digital_out(call, DigitalBank::Configurable),
    ),
    Builtin::new(
        Io,
        "5.11",
        "set_standard_analog_input_domain",
        &[ANALOG_PORT, DOMAIN],
        "nothing",
        "Makes a standard analog input measure a current or a voltage.",
        set_standard_analog_input_domain,
    ),
    Builtin::new(
        Io,
        "5.12",
        "set_standard_analog_out",
        &[ANALOG, RATIO],
        "nothing",
        "Sets a standard analog output; applied in the next cycle.",
        set_standard_analog_out,
    ),
    Builtin::new(
        Io,
        "5.13",
        "set_standard_digital_out",
        &[STANDARD_OR_NONE, LEVEL],
        "nothing",
        "Sets a standard digital output; the level is applied in the next cycle.",
        set_standard_digital_out,
    ),
    Builtin::new(
        Io,
        "5.14",
        "set_tool_analog_input_domain",
        &[DOMAIN],
        "nothing",
        "Makes the analog input of the tool measure a current or a voltage.",
        set_tool_analog_input_domain,
    ),
    Builtin::new(
        Io,
        "5.15",
        "set_tool_analog_output_domain",
        &[DOMAIN],
        "nothing",
        "Makes the analog output of the tool a current or a voltage.",
        set_tool_analog_output_domain,
    ),
    Builtin::new(
        Io,
        "5.16",
        "set_tool_digital",
        &[TOOL, LEVEL],
        "nothing",
        "Sets a digital pin of the tool; ends the program with an alarm when the pin is disabled or an input.",
        set_tool_digital,
    ),
    Builtin::new(
        Io,
        "5.17",
        "get_tool_digital",
        &[TOOL],
        "bool",
        "Level of a digital pin of the tool.",
        get_tool_digital,
    ),
    Builtin::new(
        Io,
        "5.18",
        "set_tool_analog_io_work_mode",
        &[WORK_MODE],
        "nothing",
        "What the analog pins of the tool are used for.",
        set_tool_analog_io_work_mode,
    ),
    Builtin::new(
        Io,
        "5.19",
        "set_tool_digital_io_config",
        &[PIN, PIN_MODE, ENABLE, IS_OUT],
        "nothing",
        "Configures a digital pin of the tool.",
        set_tool_digital_io_config,
    ),
    Builtin::new(
        Io,
        "5.20",
        "set_runstate_configurable_digital_output_to_value",
        &[CONFIGURABLE_PORT, RUNSTATE],
        "nothing",
        "What a configurable digital output does when no program runs.",
        |call| set_runstate(call, DigitalBank::Configurable),
    ),
    Builtin::new(
        Io,
        "5.21",
        "set_runstate_gp_boolean_output_to_value",
        &[REGISTER_PORT, RUNSTATE],
        "nothing",
        "What a boolean output register does when no program runs.",
        set_runstate_gp_boolean_output,
    ),
    Builtin::new(
        Io,
        "5.22",
        "set_runstate_standard_analog_output_to_value",
        &[ANALOG_PORT, ANALOG_RUNSTATE],
        "nothing",
        "What a standard analog output does when no program runs.",
        set_runstate_standard_analog_output,
    ),
    Builtin::new(
        Io,
        "5.23",
        "set_runstate_tool_analog_output_to_value",
        &[ANALOG_RUNSTATE],
        "nothing",
        "What the analog output of the tool does when no program runs.",
        set_runstate_tool_analog_output,
    ),
    Builtin::new(
        Io,
        "5.24",
        "set_runstate_standard_digital_output_to_value",
        &[STANDARD_PORT, RUNSTATE],
        "nothing",
        "What a standard digital output does when no program runs.",
        |call| set_runstate(call, DigitalBank::Standard),
    ),
    Builtin::new(
        Io,
        "5.25",
        "set_runstate_tool_digital_output_to_value",
        &[TOOL_PORT, RUNSTATE],
        "nothing",
        "What a digital output of the tool does when no program runs.",
        |call| set_runstate(call, DigitalBank::Tool),
    ),
    Builtin::new(
        Io,
        "5.26",
        "set_input_actions_to_default",
        &[],
        "nothing",
        "No input sets off anything any more.",
        set_input_actions_to_default,
    ),
    Builtin::new(
        Io,
        "5.27",
        "set_configurable_digital_input_action",
        &[CONFIGURABLE_PORT, ACTION],
        "nothing",
        "What a high configurable digital input sets off.",
        |call| set_action(call, DigitalBank::Configurable),
    ),
    Builtin::new(
        Io,
        "5.28",
        "set_standard_digital_input_action",
        &[STANDARD_PORT, ACTION],
        "nothing",
        "What a high standard digital input sets off.",
        |call| set_action(call, DigitalBank::Standard),
    ),
    Builtin::new(
        Io,
        "5.29",
        "set_tool_digital_input_action",
        &[TOOL_PORT, ACTION],
        "nothing",
        "What a high digital input of the tool sets off.",
        |call| set_action(call, DigitalBank::Tool),
    ),
    Builtin::new(
        Io,
        "5.30",
        "set_gp_boolean_input_action",
        &[REGISTER_PORT, ACTION],
        "nothing",
        "What a high boolean input register sets off.",
        set_gp_boolean_input_action,
    ),
    Builtin::new(
        Io,
        "5.35",
        "set_tool_voltage",
        &[VOLTAGE],
        "nothing",
        "Supply voltage of the tool connector.",
        set_tool_voltage,
    ),
];
