//! Names of the original that mean something else in EliteScript get an underscore.

use super::functions::{FUNCTIONS, split_list};
use super::helpers::HELPERS;

/// Keywords of Python that are names in URScript, and names that translated programs use.
const RESERVED: &[&str] = &[
    "as",
    "assert",
    "async",
    "await",
    "class",
    "del",
    "except",
    "finally",
    "for",
    "from",
    "import",
    "in",
    "is",
    "lambda",
    "nonlocal",
    "None",
    "print",
    "raise",
    "try",
    "with",
    "yield",
    "list",
    "dict",
    "int",
    "len",
    "str",
    "range",
    "sum",
    "zip",
    "max",
    "abs",
    "float",
    "isinstance",
    "getattr",
    "setattr",
    "elicopy",
    "threading",
    "NotImplementedError",
    "ValueError",
    "start_thread",
    "stop_thread",
    "join_thread",
    "halt",
    "pause",
    "tool_output_modes",
    "rpc_pose",
    "get_joint_temperatures",
    "get_controller_temperature",
    "get_target_payload_mass",
    "set_tool_digital",
    "get_tool_digital",
    "set_tool_digital_io_config",
    "tool_serial_config",
    "rtsi_set_watchdog",
    "ft_rtsi_input_enable",
    "set_standard_analog_output_domain",
];

/// Whether a name of the original has another meaning here.
pub fn is_reserved(name: &str) -> bool {
    RESERVED.contains(&name)
        || HELPERS.iter().any(|helper| helper.name == name)
        // A function of the original that is replaced may be defined by the program itself.
        || FUNCTIONS.iter().any(|row| row.name() == name)
        || FUNCTIONS.iter().any(|row| calls(row.call, name))
}

/// Whether the call of a row is one of this function.
fn calls(call: &str, name: &str) -> bool {
    let head = call
        .trim_start_matches('=')
        .split('(')
        .next()
        .unwrap_or_default();
    head == name && !split_list(call).is_empty()
}

/// The name in EliteScript.
pub fn renamed(name: &str) -> String {
    match is_reserved(name) {
        true => format!("{name}_"),
        false => name.to_owned(),
    }
}
