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

use super::declare::{Builtin, Category::Io, Parameter, ParameterType, Range, phrase};

const fn index(name: &'static str, last: i64) -> Parameter {
    Parameter::required(
        name,
        ParameterType::Integer(0, last),
        phrase("number of the point", "点位编号"),
    )
}

const STANDARD: Parameter = index("n", 15);
const CONFIGURABLE: Parameter = index("n", 7);
const TOOL: Parameter = index("n", 3);
const ANALOG: Parameter = index("n", 1);
const STANDARD_PORT: Parameter = index("port", 15);
const STANDARD_OR_NONE: Parameter = Parameter::required(
    "n",
    ParameterType::Integer(-1, 15),
    phrase(
        "number of the point; -1: none, nothing is done",
        "点位编号；-1 表示没有，不做任何事",
    ),
);
const CONFIGURABLE_PORT: Parameter = index("port", 7);
const TOOL_PORT: Parameter = index("port", 3);
const REGISTER_PORT: Parameter = index("port", 127);
const ANALOG_PORT: Parameter = index("port", 1);
const PIN: Parameter = index("index", 3);
const LEVEL: Parameter = Parameter::required("b", ParameterType::Boolean, phrase("level", "电平"));
const RATIO: Parameter = Parameter::required(
    "f",
    ParameterType::Number(Range::Any),
    phrase(
        "part of the range of the output; beyond 0 to 1 it is set to the nearer end",
        "占输出量程的比例；超出 0 到 1 时取较近的一端",
    ),
);
const DOMAIN: Parameter = Parameter::required(
    "domain",
    ParameterType::Integer(0, 1),
    phrase(
        "0 current, 4 to 20 mA; 1 voltage, 0 to 10 V",
        "0 电流，4 到 20 mA；1 电压，0 到 10 V",
    ),
);
const WORK_MODE: Parameter = Parameter::required(
    "domain",
    ParameterType::Integer(0, 3),
    phrase(
        "0 USART, 1 analog input, 2 analog output, 3 both",
        "0 串口，1 模拟输入，2 模拟输出，3 两者",
    ),
);
const PIN_MODE: Parameter = Parameter::required(
    "mode",
    ParameterType::Integer(0, 2),
    phrase(
        "0 push/pull, 1 sourcing (PNP), 2 sinking (NPN)",
        "0 推挽，1 源型（PNP），2 漏型（NPN）",
    ),
);
const ENABLE: Parameter = Parameter::required(
    "enable",
    ParameterType::Boolean,
    phrase("the pin is used", "使用该引脚"),
);
const IS_OUT: Parameter = Parameter::required(
    "is_out",
    ParameterType::Boolean,
    phrase("True output, False input", "True 为输出，False 为输入"),
);
const RUNSTATE: Parameter = Parameter::required(
    "runstate",
    ParameterType::Integer(0, 3),
    phrase(
        "0 keep; 1 low when not running; 2 high when not running; 3 high while running, low \
         otherwise",
        "0 保持；1 未运行时为低；2 未运行时为高；3 运行时为高，否则为低",
    ),
);
const ANALOG_RUNSTATE: Parameter = Parameter::required(
    "runstate",
    ParameterType::Integer(0, 3),
    phrase(
        "0 keep; 1 minimum when not running; 2 maximum when not running; 3 maximum while \
         running, minimum otherwise",
        "0 保持；1 未运行时最小；2 未运行时最大；3 运行时最大，否则最小",
    ),
);
const ACTION: Parameter = Parameter::required(
    "action",
    ParameterType::Word(&["default", "freedrive"]),
    phrase("what a high level sets off", "高电平触发的动作"),
);
const VOLTAGE: Parameter = Parameter::required(
    "voltage",
    ParameterType::OneOf(&[0, 12, 24]),
    phrase("supply voltage", "供电电压"),
)
.in_unit("V");

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin::new(
        Io,
        "5.1",
        "get_configurable_digital_in",
        &[CONFIGURABLE],
        phrase("bool", "bool"),
        phrase(
            "Level of a configurable digital input.",
            "可配置数字输入的电平。",
        ),
        |call| digital_in(call, DigitalBank::Configurable),
    ),
    Builtin::new(
        Io,
        "5.2",
        "get_configurable_digital_out",
        &[CONFIGURABLE],
        phrase("bool", "bool"),
        phrase(
            "Level of a configurable digital output.",
            "可配置数字输出的电平。",
        ),
        |call| digital_out(call, DigitalBank::Configurable),
    ),
    Builtin::new(
        Io,
        "5.3",
        "get_standard_analog_in",
        &[ANALOG],
        phrase("float, A or V by domain", "float，按类型为 A 或 V"),
        phrase("Value of a standard analog input.", "标准模拟输入的值。"),
        standard_analog_in,
    ),
    Builtin::new(
        Io,
        "5.4",
        "get_standard_analog_out",
        &[ANALOG],
        phrase("float, A or V by domain", "float，按类型为 A 或 V"),
        phrase("Value of a standard analog output.", "标准模拟输出的值。"),
        standard_analog_out,
    ),
    Builtin::new(
        Io,
        "5.5",
        "get_standard_digital_in",
        &[STANDARD],
        phrase("bool", "bool"),
        phrase("Level of a standard digital input.", "标准数字输入的电平。"),
        |call| digital_in(call, DigitalBank::Standard),
    ),
    Builtin::new(
        Io,
        "5.6",
        "get_standard_digital_out",
        &[STANDARD],
        phrase("bool", "bool"),
        phrase(
            "Level of a standard digital output.",
            "标准数字输出的电平。",
        ),
        |call| digital_out(call, DigitalBank::Standard),
    ),
    Builtin::new(
        Io,
        "5.7",
        "get_tool_analog_in",
        &[],
        phrase("float, A or V by domain", "float，按类型为 A 或 V"),
        phrase(
            "Value of the analog input of the tool.",
            "工具模拟输入的值。",
        ),
        |call| Ok(Value::Float(image(call).analog_in[2])),
    ),
    Builtin::new(
        Io,
        "5.8",
        "get_tool_analog_out",
        &[],
        phrase("float, A or V by domain", "float，按类型为 A 或 V"),
        phrase(
            "Value of the analog output of the tool.",
            "工具模拟输出的值。",
        ),
        |call| Ok(Value::Float(image(call).analog_out()[2])),
    ),
    Builtin::new(
        Io,
        "5.9",
        "set_standard_analog_output_domain",
        &[ANALOG_PORT, DOMAIN],
        phrase("nothing", "无返回值"),
        phrase(
            "Makes a standard analog output a current or a voltage.",
            "把标准模拟输出设为电流或电压。",
        ),
        set_standard_analog_output_domain,
    ),
    Builtin::new(
        Io,
        "5.10",
        "set_configurable_digital_out",
        &[CONFIGURABLE, LEVEL],
        phrase("nothing", "无返回值"),
        phrase(
            "Sets a configurable digital output; the level is applied in the next cycle.",
            "设置可配置数字输出；电平在下一周期生效。",
        ),
        |call| set_digital_out(call, DigitalBank::Configurable),
    ),
    Builtin::new(
        Io,
        "5.11",
        "set_standard_analog_input_domain",
        &[ANALOG_PORT, DOMAIN],
        phrase("nothing", "无返回值"),
        phrase(
            "Makes a standard analog input measure a current or a voltage.",
            "让标准模拟输入测量电流或电压。",
        ),
        set_standard_analog_input_domain,
    ),
    Builtin::new(
        Io,
        "5.12",
        "set_standard_analog_out",
        &[ANALOG, RATIO],
        phrase("nothing", "无返回值"),
        phrase(
            "Sets a standard analog output; applied in the next cycle.",
            "设置标准模拟输出；在下一周期生效。",
        ),
        set_standard_analog_out,
    ),
    Builtin::new(
        Io,
        "5.13",
        "set_standard_digital_out",
        &[STANDARD_OR_NONE, LEVEL],
        phrase("nothing", "无返回值"),
        phrase(
            "Sets a standard digital output; the level is applied in the next cycle.",
            "设置标准数字输出；电平在下一周期生效。",
        ),
        set_standard_digital_out,
    ),
    Builtin::new(
        Io,
        "5.14",
        "set_tool_analog_input_domain",
        &[DOMAIN],
        phrase("nothing", "无返回值"),
        phrase(
            "Makes the analog input of the tool measure a current or a voltage.",
            "让工具模拟输入测量电流或电压。",
        ),
        set_tool_analog_input_domain,
    ),
    Builtin::new(
        Io,
        "5.15",
        "set_tool_analog_output_domain",
        &[DOMAIN],
        phrase("nothing", "无返回值"),
        phrase(
            "Makes the analog output of the tool a current or a voltage.",
            "把工具模拟输出设为电流或电压。",
        ),
        set_tool_analog_output_domain,
    ),
    Builtin::new(
        Io,
        "5.16",
        "set_tool_digital",
        &[TOOL, LEVEL],
        phrase("nothing", "无返回值"),
        phrase(
            "Sets a digital pin of the tool; ends the program with an alarm when the pin is \
             disabled or an input.",
            "设置工具数字引脚；引脚被禁用或为输入时以报警结束程序。",
        ),
        set_tool_digital,
    ),
    Builtin::new(
        Io,
        "5.17",
        "get_tool_digital",
        &[TOOL],
        phrase("bool", "bool"),
        phrase(
            "Level of a digital pin of the tool.",
            "工具数字引脚的电平。",
        ),
        get_tool_digital,
    ),
    Builtin::new(
        Io,
        "5.18",
        "set_tool_analog_io_work_mode",
        &[WORK_MODE],
        phrase("nothing", "无返回值"),
        phrase(
            "What the analog pins of the tool are used for.",
            "工具模拟引脚的用途。",
        ),
        set_tool_analog_io_work_mode,
    ),
    Builtin::new(
        Io,
        "5.19",
        "set_tool_digital_io_config",
        &[PIN, PIN_MODE, ENABLE, IS_OUT],
        phrase("nothing", "无返回值"),
        phrase(
            "Configures a digital pin of the tool.",
            "配置工具数字引脚。",
        ),
        set_tool_digital_io_config,
    ),
    Builtin::new(
        Io,
        "5.20",
        "set_runstate_configurable_digital_output_to_value",
        &[CONFIGURABLE_PORT, RUNSTATE],
        phrase("nothing", "无返回值"),
        phrase(
            "What a configurable digital output does when no program runs.",
            "没有程序运行时可配置数字输出的状态。",
        ),
        |call| set_runstate(call, DigitalBank::Configurable),
    ),
    Builtin::new(
        Io,
        "5.21",
        "set_runstate_gp_boolean_output_to_value",
        &[REGISTER_PORT, RUNSTATE],
        phrase("nothing", "无返回值"),
        phrase(
            "What a boolean output register does when no program runs.",
            "没有程序运行时布尔输出寄存器的状态。",
        ),
        set_runstate_gp_boolean_output,
    ),
    Builtin::new(
        Io,
        "5.22",
        "set_runstate_standard_analog_output_to_value",
        &[ANALOG_PORT, ANALOG_RUNSTATE],
        phrase("nothing", "无返回值"),
        phrase(
            "What a standard analog output does when no program runs.",
            "没有程序运行时标准模拟输出的状态。",
        ),
        set_runstate_standard_analog_output,
    ),
    Builtin::new(
        Io,
        "5.23",
        "set_runstate_tool_analog_output_to_value",
        &[ANALOG_RUNSTATE],
        phrase("nothing", "无返回值"),
        phrase(
            "What the analog output of the tool does when no program runs.",
            "没有程序运行时工具模拟输出的状态。",
        ),
        set_runstate_tool_analog_output,
    ),
    Builtin::new(
        Io,
        "5.24",
        "set_runstate_standard_digital_output_to_value",
        &[STANDARD_PORT, RUNSTATE],
        phrase("nothing", "无返回值"),
        phrase(
            "What a standard digital output does when no program runs.",
            "没有程序运行时标准数字输出的状态。",
        ),
        |call| set_runstate(call, DigitalBank::Standard),
    ),
    Builtin::new(
        Io,
        "5.25",
        "set_runstate_tool_digital_output_to_value",
        &[TOOL_PORT, RUNSTATE],
        phrase("nothing", "无返回值"),
        phrase(
            "What a digital output of the tool does when no program runs.",
            "没有程序运行时工具数字输出的状态。",
        ),
        |call| set_runstate(call, DigitalBank::Tool),
    ),
    Builtin::new(
        Io,
        "5.26",
        "set_input_actions_to_default",
        &[],
        phrase("nothing", "无返回值"),
        phrase(
            "No input sets off anything any more.",
            "所有输入都不再触发动作。",
        ),
        set_input_actions_to_default,
    ),
    Builtin::new(
        Io,
        "5.27",
        "set_configurable_digital_input_action",
        &[CONFIGURABLE_PORT, ACTION],
        phrase("nothing", "无返回值"),
        phrase(
            "What a high configurable digital input sets off.",
            "可配置数字输入为高时触发的动作。",
        ),
        |call| set_action(call, DigitalBank::Configurable),
    ),
    Builtin::new(
        Io,
        "5.28",
        "set_standard_digital_input_action",
        &[STANDARD_PORT, ACTION],
        phrase("nothing", "无返回值"),
        phrase(
            "What a high standard digital input sets off.",
            "标准数字输入为高时触发的动作。",
        ),
        |call| set_action(call, DigitalBank::Standard),
    ),
    Builtin::new(
        Io,
        "5.29",
        "set_tool_digital_input_action",
        &[TOOL_PORT, ACTION],
        phrase("nothing", "无返回值"),
        phrase(
            "What a high digital input of the tool sets off.",
            "工具数字输入为高时触发的动作。",
        ),
        |call| set_action(call, DigitalBank::Tool),
    ),
    Builtin::new(
        Io,
        "5.30",
        "set_gp_boolean_input_action",
        &[REGISTER_PORT, ACTION],
        phrase("nothing", "无返回值"),
        phrase(
            "What a high boolean input register sets off.",
            "布尔输入寄存器为高时触发的动作。",
        ),
        set_gp_boolean_input_action,
    ),
    Builtin::new(
        Io,
        "5.35",
        "set_tool_voltage",
        &[VOLTAGE],
        phrase("nothing", "无返回值"),
        phrase(
            "Supply voltage of the tool connector.",
            "工具接口的供电电压。",
        ),
        set_tool_voltage,
    ),
];
