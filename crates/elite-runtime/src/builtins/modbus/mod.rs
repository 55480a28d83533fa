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
    Builtin, Category::Modbus, Parameter, ParameterDefault, ParameterType, Range, phrase,
};

const IP: Parameter = Parameter::required(
    "IP",
    ParameterType::Text,
    phrase("address of the device", "设备地址"),
);
const SLAVE: Parameter = Parameter::required(
    "slave_number",
    ParameterType::Integer(0, 255),
    phrase(
        "unit, normally 255; 248 to 254 mean 255, 0 is a broadcast",
        "单元号，通常为 255；248 到 254 视为 255，0 为广播",
    ),
);
const ADDRESS: Parameter = Parameter::required(
    "signal_address",
    ParameterType::Integer(0, 65535),
    phrase("first coil or register", "第一个线圈或寄存器"),
);
const TYPE: Parameter = Parameter::required(
    "signal_type",
    ParameterType::Integer(0, 3),
    phrase(
        "0 digital input, 1 digital output, 2 register input, 3 register output",
        "0 数字输入，1 数字输出，2 寄存器输入，3 寄存器输出",
    ),
);
const NAME: Parameter = Parameter::required(
    "signal_name",
    ParameterType::Text,
    phrase("name of the signal", "信号名称"),
);
const SEQUENTIAL: Parameter = Parameter::required(
    "is_sequential",
    ParameterType::Boolean,
    phrase(
        "update signals in the order they were added",
        "按添加顺序刷新信号",
    ),
)
.or(ParameterDefault::Boolean(false));
const COUNT: Parameter = Parameter::required(
    "registers_count",
    ParameterType::Integer(1, 123),
    phrase("coils or registers in a row", "连续的线圈或寄存器数"),
)
.or(ParameterDefault::Integer(1));
const PORT: Parameter = Parameter::required(
    "port",
    ParameterType::Integer(1, 65535),
    phrase("TCP port of the device", "设备的 TCP 端口"),
)
.or(ParameterDefault::Integer(502));
const READ_ADDRESS: Parameter = Parameter::required(
    "read_address",
    ParameterType::Integer(0, 65535),
    phrase("first register to read", "要读取的第一个寄存器"),
);
const READ_COUNT: Parameter = Parameter::required(
    "read_register_count",
    ParameterType::Integer(1, 123),
    phrase("registers to read", "要读取的寄存器数"),
);
const WRITE_ADDRESS: Parameter = Parameter::required(
    "write_address",
    ParameterType::Integer(0, 65535),
    phrase("first register to write", "要写入的第一个寄存器"),
);
const WRITE_COUNT: Parameter = Parameter::required(
    "write_register_count",
    ParameterType::Integer(1, 121),
    phrase("registers to write", "要写入的寄存器数"),
);
const SECONDARY: Parameter = Parameter::required(
    "is_secondary_program",
    ParameterType::Boolean,
    phrase(
        "taken for compatibility; changes nothing",
        "为兼容而接受；不起作用",
    ),
)
.or(ParameterDefault::Boolean(false));
const FUNCTION: Parameter = Parameter::required(
    "function_code",
    ParameterType::Integer(1, 127),
    phrase("function code", "功能码"),
);
const DATA: Parameter = Parameter::required(
    "data",
    ParameterType::Custom("list[int]"),
    phrase(
        "bytes after the function code, 0 to 255 each, at most 252",
        "功能码之后的字节，每个 0 到 255，最多 252 个",
    ),
);
const ONESHOT: Parameter = Parameter::required(
    "oneshot",
    ParameterType::Boolean,
    phrase(
        "True sends once; False again and again, 10 times a second, until \
         modbus_reset_connection()",
        "True 只发送一次；False 每秒 10 次重复发送，直到 modbus_reset_connection()",
    ),
)
.or(ParameterDefault::Boolean(true));
const REGISTER_VALUE: Parameter = Parameter::required(
    "register_value",
    ParameterType::Custom("int or list[int]"),
    phrase(
        "value or values; their low 16 bits are written",
        "一个或多个值；写入其低 16 位",
    ),
);
const DIGITAL_VALUE: Parameter = Parameter::required(
    "digital_value",
    ParameterType::Custom("bool or list[bool]"),
    phrase("level or levels", "一个或多个电平"),
);
const CHOICE: Parameter = Parameter::required(
    "runstate_choice",
    ParameterType::Integer(0, 3),
    phrase(
        "0 keep; 1 low when not running; 2 high when not running; 3 high while running, low \
         otherwise",
        "0 保持；1 未运行时为低；2 未运行时为高；3 运行时为高，否则为低",
    ),
);
const FREQUENCY: Parameter = Parameter::required(
    "update_frequency",
    ParameterType::Integer(0, 250),
    phrase("updates a second; 0 stops", "每秒刷新次数；0 为停止"),
)
.in_unit("Hz");
const WATCHDOG: Parameter = Parameter::required(
    "timeout",
    ParameterType::Number(Range::Between(0.0, 300.0)),
    phrase(
        "time without a good answer before access raises",
        "无正确应答多久之后访问抛出异常",
    ),
)
.in_unit("s");
const SOURCE: Parameter = Parameter::required(
    "error_source",
    ParameterType::Integer(0, 2),
    phrase("0 both, 1 device, 2 connection", "0 两者，1 设备，2 连接"),
)
.or(ParameterDefault::Integer(0));
const CONNECTION: Parameter = Parameter::required(
    "connection_id",
    ParameterType::Text,
    phrase("address of the device", "设备地址"),
);
const BLOCKING: Parameter = Parameter::required(
    "is_blocking",
    ParameterType::Boolean,
    phrase(
        "wait for the connection, at most 3 s",
        "等待连接建立，最多 3 s",
    ),
)
.or(ParameterDefault::Boolean(true));
const COIL: Parameter = Parameter::required(
    "address",
    ParameterType::Integer(0, 127),
    phrase("bit", "位"),
);
const REGISTER: Parameter = Parameter::required(
    "address",
    ParameterType::Integer(0, 65535),
    phrase("word", "字"),
);
const SIGNED: Parameter = Parameter::required(
    "is_signed",
    ParameterType::Boolean,
    phrase(
        "True: -32768 to 32767, False: 0 to 65535",
        "True：-32768 到 32767；False：0 到 65535",
    ),
)
.or(ParameterDefault::Boolean(false));
const LEVEL: Parameter =
    Parameter::required("value", ParameterType::Boolean, phrase("level", "电平"));
const WORD: Parameter = Parameter::required(
    "value",
    ParameterType::Integer(-32768, 65535),
    phrase("value", "值"),
);

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin::new(
        Modbus,
        "6.1.1",
        "modbus_add_signal",
        &[IP, SLAVE, ADDRESS, TYPE, NAME, SEQUENTIAL, COUNT, PORT],
        phrase("nothing", "无返回值"),
        phrase(
            "Adds a signal of a Modbus device, or replaces the one of that name.",
            "添加 Modbus 设备的信号，或替换同名信号。",
        ),
        modbus_add_signal,
    ),
    Builtin::new(
        Modbus,
        "6.1.2",
        "modbus_delete_signal",
        &[NAME],
        phrase("nothing", "无返回值"),
        phrase("Removes a signal.", "删除信号。"),
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
        phrase("nothing", "无返回值"),
        phrase(
            "Adds a signal that reads and writes registers with function 23.",
            "添加用功能码 23 读写寄存器的信号。",
        ),
        modbus_add_rw_signal,
    ),
    Builtin::new(
        Modbus,
        "6.1.4",
        "modbus_get_signal_status",
        &[NAME, SECONDARY],
        phrase(
            "bool for a coil, int for a register, a list for several",
            "线圈为 bool，寄存器为 int，多个时为列表",
        ),
        phrase(
            "Value of a signal; waits for its first answer, at most its watchdog.",
            "信号的值；等待首次应答，最长为其看门狗时间。",
        ),
        modbus_get_signal_status,
    ),
    Builtin::new(
        Modbus,
        "6.1.5",
        "modbus_send_custom_command",
        &[IP, SLAVE, FUNCTION, DATA, ONESHOT, PORT],
        phrase("nothing", "无返回值"),
        phrase(
            "Sends a function with its bytes; the answer is not looked at.",
            "发送功能码及其字节；不查看应答。",
        ),
        modbus_send_custom_command,
    ),
    Builtin::new(
        Modbus,
        "6.1.6",
        "modbus_set_output_register",
        &[NAME, REGISTER_VALUE],
        phrase("nothing", "无返回值"),
        phrase(
            "Sets a register output; from then on it is written, not read.",
            "设置寄存器输出；此后只写不读。",
        ),
        modbus_set_output_register,
    ),
    Builtin::new(
        Modbus,
        "6.1.7",
        "modbus_set_output_signal",
        &[NAME, DIGITAL_VALUE],
        phrase("nothing", "无返回值"),
        phrase(
            "Sets a digital output; from then on it is written, not read.",
            "设置数字输出；此后只写不读。",
        ),
        modbus_set_output_signal,
    ),
    Builtin::new(
        Modbus,
        "6.1.8",
        "modbus_set_runstate_dependent_choice",
        &[NAME, CHOICE],
        phrase("nothing", "无返回值"),
        phrase(
            "What a digital output does when no program runs.",
            "没有程序运行时数字输出的状态。",
        ),
        modbus_set_runstate_dependent_choice,
    ),
    Builtin::new(
        Modbus,
        "6.1.9",
        "modbus_set_signal_update_frequency",
        &[NAME, FREQUENCY],
        phrase("nothing", "无返回值"),
        phrase("How often a signal is updated.", "信号的更新频率。"),
        modbus_set_signal_update_frequency,
    ),
    Builtin::new(
        Modbus,
        "6.1.10",
        "modbus_set_signal_watchdog",
        &[NAME, WATCHDOG],
        phrase("nothing", "无返回值"),
        phrase(
            "How long a signal may be without a good answer before access raises; 5 s at first.",
            "信号多久没有正常应答后访问会报错；初始为 5 秒。",
        ),
        modbus_set_signal_watchdog,
    ),
    Builtin::new(
        Modbus,
        "6.1.11",
        "read_port_bit",
        &[COIL],
        phrase("bool", "bool"),
        phrase(
            "A bit of the controller's own Modbus map.",
            "控制器自身 Modbus 表中的一位。",
        ),
        read_port_bit,
    ),
    Builtin::new(
        Modbus,
        "6.1.12",
        "read_port_register",
        &[REGISTER, SIGNED],
        phrase("int", "int"),
        phrase(
            "A word of the controller's own Modbus map: I/O, state, or what programs and clients \
             share.",
            "控制器自身 Modbus 表中的一个字：I/O、状态或共享值。",
        ),
        read_port_register,
    ),
    Builtin::new(
        Modbus,
        "6.1.13",
        "write_port_bit",
        &[COIL, LEVEL],
        phrase("nothing", "无返回值"),
        phrase(
            "Sets a bit of the controller's own Modbus map; bits 32 to 59 switch outputs.",
            "设置控制器自身 Modbus 表中的一位；32 至 59 为输出。",
        ),
        write_port_bit,
    ),
    Builtin::new(
        Modbus,
        "6.1.14",
        "write_port_register",
        &[REGISTER, WORD],
        phrase("nothing", "无返回值"),
        phrase(
            "Sets a word of the controller's own Modbus map: outputs, the speed slider, or what \
             is shared.",
            "设置控制器自身 Modbus 表中的一个字：输出、速度滑块或共享值。",
        ),
        write_port_register,
    ),
    Builtin::new(
        Modbus,
        "6.1.15",
        "modbus_get_error",
        &[NAME, SOURCE],
        phrase(
            "list[int]: device and connection code, or one of them",
            "list[int]：设备码和连接码，或其中之一",
        ),
        phrase(
            "Error codes of a signal (table 6-2 and errno).",
            "信号的错误码（表 6-2 与 errno）。",
        ),
        modbus_get_error,
    ),
    Builtin::new(
        Modbus,
        "6.1.16",
        "modbus_get_time_since_signal_invalid",
        &[NAME],
        phrase("float, s; 0 for a valid signal", "float，s；信号有效时为 0"),
        phrase("Time since the last good answer.", "距上次正常应答的时间。"),
        modbus_get_time_since_signal_invalid,
    ),
    Builtin::new(
        Modbus,
        "6.1.17",
        "modbus_reset_connection",
        &[CONNECTION, BLOCKING, PORT],
        phrase("nothing", "无返回值"),
        phrase(
            "Closes the connection to a device and opens it again.",
            "断开与设备的连接并重新建立。",
        ),
        modbus_reset_connection,
    )
    .waiting(),
];
