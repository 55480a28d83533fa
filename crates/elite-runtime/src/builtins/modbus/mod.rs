//! Manual 6.1: Modbus signals, and the controller's own Modbus map.
//!
//! Signals belong to the controller: they outlive the program that added them. Reading one waits only for its first
//! answer.

mod calls;

use calls::{
    modbus_add_rw_signal, modbus_add_signal, modbus_delete_signal, modbus_get_error,
    modbus_get_signal_status, modbus_get_time_since_signal_invalid, modbus_reset_connection,
    modbus_send_custom_command, modbus_set_output_register, modbus_set_output_signal,
    modbus_set_runstate_dependent_choice, modbus_set_signal_update_frequency,
    modbus_set_signal_watchdog, read_port_bit, read_port_register, write_port_bit,
    write_port_register,
};

use super::declare::{
    Builtin, Category::Modbus, Parameter, ParameterDefault, ParameterType, Range,
};

const IP: Parameter = Parameter::required("IP", ParameterType::Text, "address of the device");
const SLAVE: Parameter = Parameter::required(
    "slave_number",
    ParameterType::Integer(0, 255),
    "unit, normally 255; 248 to 254 mean 255, 0 is a broadcast",
);
const ADDRESS: Parameter = Parameter::required(
    "signal_address",
    ParameterType::Integer(0, 65535),
    "first coil or register",
);
const TYPE: Parameter = Parameter::required(
    "signal_type",
    ParameterType::Integer(0, 3),
    "0 digital input, 1 digital output, 2 register input, 3 register output",
);
const NAME: Parameter =
    Parameter::required("signal_name", ParameterType::Text, "name of the signal");
const SEQUENTIAL: Parameter = Parameter::required(
    "is_sequential",
    ParameterType::Boolean,
    "update signals in the order they were added",
)
.or(ParameterDefault::Boolean(false));
const COUNT: Parameter = Parameter::required(
    "registers_count",
    ParameterType::Integer(1, 123),
    "coils or registers in a row",
)
.or(ParameterDefault::Integer(1));
const PORT: Parameter = Parameter::required(
    "port",
    ParameterType::Integer(1, 65535),
    "TCP port of the device",
)
.or(ParameterDefault::Integer(502));
const READ_ADDRESS: Parameter = Parameter::required(
    "read_address",
    ParameterType::Integer(0, 65535),
    "first register to read",
);
const READ_COUNT: Parameter = Parameter::required(
    "read_register_count",
    ParameterType::Integer(1, 123),
    "registers to read",
);
const WRITE_ADDRESS: Parameter = Parameter::required(
    "write_address",
    ParameterType::Integer(0, 65535),
    "first register to write",
);
const WRITE_COUNT: Parameter = Parameter::required(
    "write_register_count",
    ParameterType::Integer(1, 121),
    "registers to write",
);
const SECONDARY: Parameter = Parameter::required(
    "is_secondary_program",
    ParameterType::Boolean,
    "taken for compatibility; changes nothing",
)
.or(ParameterDefault::Boolean(false));
const FUNCTION: Parameter = Parameter::required(
    "function_code",
    ParameterType::Integer(1, 127),
    "function code",
);
const DATA: Parameter = Parameter::required(
    "data",
    ParameterType::Custom("list[int]"),
    "bytes after the function code, 0 to 255 each, at most 252",
);
const ONESHOT: Parameter = Parameter::required(
    "oneshot",
    ParameterType::Boolean,
    "True sends once; False again and again, 10 times a second, until modbus_reset_connection()",
)
.or(ParameterDefault::Boolean(true));
const REGISTER_VALUE: Parameter = Parameter::required(
    "register_value",
    ParameterType::Custom("int or list[int]"),
    "value or values; their low 16 bits are written",
);
const DIGITAL_VALUE: Parameter = Parameter::required(
    "digital_value",
    ParameterType::Custom("bool or list[bool]"),
    "level or levels",
);
const CHOICE: Parameter = Parameter::required(
    "runstate_choice",
    ParameterType::Integer(0, 3),
    "0 keep; 1 low when not running; 2 high when not running; 3 high while running, low otherwise",
);
const FREQUENCY: Parameter = Parameter::required(
    "update_frequency",
    ParameterType::Integer(0, 250),
    "updates a second; 0 stops",
)
.in_unit("Hz");
const WATCHDOG: Parameter = Parameter::required(
    "timeout",
    ParameterType::Number(Range::Between(0.0, 300.0)),
    "time without a good answer before access raises",
)
.in_unit("s");
const SOURCE: Parameter = Parameter::required(
    "error_source",
    ParameterType::Integer(0, 2),
    "0 both, 1 device, 2 connection",
)
.or(ParameterDefault::Integer(0));
const CONNECTION: Parameter = Parameter::required(
    "connection_id",
    ParameterType::Text,
    "address of the device",
);
const BLOCKING: Parameter = Parameter::required(
    "is_blocking",
    ParameterType::Boolean,
    "wait for the connection, at most 3 s",
)
.or(ParameterDefault::Boolean(true));
const COIL: Parameter = Parameter::required("address", ParameterType::Integer(0, 127), "bit");
const REGISTER: Parameter =
    Parameter::required("address", ParameterType::Integer(0, 65535), "word");
const SIGNED: Parameter = Parameter::required(
    "is_signed",
    ParameterType::Boolean,
    "True: -32768 to 32767, False: 0 to 65535",
)
.or(ParameterDefault::Boolean(false));
const LEVEL: Parameter = Parameter::required("value", ParameterType::Boolean, "level");
const WORD: Parameter =
    Parameter::required("value", ParameterType::Integer(-32768, 65535), "value");

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin::new(
        Modbus,
        "6.1.1",
        "modbus_add_signal",
        &[IP, SLAVE, ADDRESS, TYPE, NAME, SEQUENTIAL, COUNT, PORT],
        "nothing",
        "Adds a signal of a Modbus device, or replaces the one of that name.",
        modbus_add_signal,
    ),
    Builtin::new(
        Modbus,
        "6.1.2",
        "modbus_delete_signal",
        &[NAME],
        "nothing",
        "Removes a signal.",
        modbus_delete_signal,
    ),
    Builtin::new(
        Modbus,
        "6.1.3",
        "modbus_add_rw_signal",
        &[
            IP,
            SLAVE,
            READ_ADDRESS,
            READ_COUNT,
            WRITE_ADDRESS,
            WRITE_COUNT,
            NAME,
            SEQUENTIAL,
            PORT,
        ],
        "nothing",
        "Adds a signal that reads and writes registers with function 23.",
        modbus_add_rw_signal,
    ),
    Builtin::new(
        Modbus,
        "6.1.4",
        "modbus_get_signal_status",
        &[NAME, SECONDARY],
        "bool for a coil, int for a register, a list for several",
        "Value of a signal; waits for its first answer, at most its watchdog.",
        modbus_get_signal_status,
    ),
    Builtin::new(
        Modbus,
        "6.1.5",
        "modbus_send_custom_command",
        &[IP, SLAVE, FUNCTION, DATA, ONESHOT, PORT],
        "nothing",
        "Sends a function with its bytes; the answer is not looked at.",
        modbus_send_custom_command,
    ),
    Builtin::new(
        Modbus,
        "6.1.6",
        "modbus_set_output_register",
        &[NAME, REGISTER_VALUE],
        "nothing",
        "Sets a register output; from then on it is written, not read.",
        modbus_set_output_register,
    ),
    Builtin::new(
        Modbus,
        "6.1.7",
        "modbus_set_output_signal",
        &[NAME, DIGITAL_VALUE],
        "nothing",
        "Sets a digital output; from then on it is written, not read.",
        modbus_set_output_signal,
    ),
    Builtin::new(
        Modbus,
        "6.1.8",
        "modbus_set_runstate_dependent_choice",
        &[NAME, CHOICE],
        "nothing",
        "What a digital output does when no program runs.",
        modbus_set_runstate_dependent_choice,
    ),
    Builtin::new(
        Modbus,
        "6.1.9",
        "modbus_set_signal_update_frequency",
        &[NAME, FREQUENCY],
        "nothing",
        "How often a signal is updated.",
        modbus_set_signal_update_frequency,
    ),
    Builtin::new(
        Modbus,
        "6.1.10",
        "modbus_set_signal_watchdog",
        &[NAME, WATCHDOG],
        "nothing",
        "How long a signal may be without a good answer before access raises; 5 s at first.",
        modbus_set_signal_watchdog,
    ),
    Builtin::new(
        Modbus,
        "6.1.11",
        "read_port_bit",
        &[COIL],
        "bool",
        "A bit of the controller's own Modbus map.",
        read_port_bit,
    ),
    Builtin::new(
        Modbus,
        "6.1.12",
        "read_port_register",
        &[REGISTER, SIGNED],
        "int",
        "A word of the controller's own Modbus map: I/O, state, or what programs and clients share.",
        read_port_register,
    ),
    Builtin::new(
        Modbus,
        "6.1.13",
        "write_port_bit",
        &[COIL, LEVEL],
        "nothing",
        "Sets a bit of the controller's own Modbus map; bits 32 to 59 switch outputs.",
        write_port_bit,
    ),
    Builtin::new(
        Modbus,
        "6.1.14",
        "write_port_register",
        &[REGISTER, WORD],
        "nothing",
        "Sets a word of the controller's own Modbus map: outputs, the speed slider, or what is shared.",
        write_port_register,
    ),
    Builtin::new(
        Modbus,
        "6.1.15",
        "modbus_get_error",
        &[NAME, SOURCE],
        "list[int]: device and connection code, or one of them",
        "Error codes of a signal (table 6-2 and errno).",
        modbus_get_error,
    ),
    Builtin::new(
        Modbus,
        "6.1.16",
        "modbus_get_time_since_signal_invalid",
        &[NAME],
        "float, s; 0 for a valid signal",
        "Time since the last good answer.",
        modbus_get_time_since_signal_invalid,
    ),
    Builtin::new(
        Modbus,
        "6.1.17",
        "modbus_reset_connection",
        &[CONNECTION, BLOCKING, PORT],
        "nothing",
        "Closes the connection to a device and opens it again.",
        modbus_reset_connection,
    )
    .waiting(),
];
