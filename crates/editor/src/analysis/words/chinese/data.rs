//! The second half of the functions, in the order of their names.

/// Names and what the functions do.
pub(super) const SECOND: &[(&str, &str)] = &[
    ("pose_inv", "逆变换。"),
    ("pose_sub", "位置相减；姿态为从 p_from 到 p_to 的旋转。"),
    (
        "pose_trans",
        "把在 p_from 坐标系下给出的位姿变换到 p_from 所在的坐标系。",
    ),
    ("pow", "base 的 exponent 次幂，结果总是浮点数。"),
    ("powerdown", "结束任务并关闭手臂电源；服务器继续运行。"),
    (
        "print",
        "把各值以一个空格连接后写入日志；用 `run` 运行时写到标准输出。",
    ),
    ("r2d", "弧度转角度。"),
    ("random", "伪随机数；序列由选项 --seed 决定。"),
    ("read_input_boolean_register", "布尔输入寄存器的值。"),
    ("read_input_float_register", "浮点输入寄存器的值。"),
    ("read_input_integer_register", "整数输入寄存器的值。"),
    ("read_output_boolean_register", "布尔输出寄存器的值。"),
    ("read_output_float_register", "浮点输出寄存器的值。"),
    ("read_output_integer_register", "整数输出寄存器的值。"),
    ("read_port_bit", "控制器自身 Modbus 表中的一位。"),
    (
        "read_port_register",
        "控制器自身 Modbus 表中的一个字：I/O、状态或共享值。",
    ),
    ("rotvec2rpy", "旋转矢量（轴乘角）转为横滚、俯仰、偏航。"),
    ("rpc_factory", "创建远程调用句柄；首次调用时连接。"),
    ("rpy2rotvec", "横滚、俯仰、偏航转为旋转矢量（轴乘角）。"),
    (
        "rtsi_set_watchdog",
        "监视 RTSI 输入的设置频率；随程序结束。",
    ),
    (
        "serial_config",
        "同 masterboard_serial_config（2.14.5 版的名称）。",
    ),
    (
        "serial_flush",
        "同 masterboard_serial_flush（2.14.5 版的名称）。",
    ),
    (
        "serial_is_open",
        "控制柜串口是否已打开（2.14.5 版的名称）。",
    ),
    (
        "serial_modbus_read_bits",
        "读取控制柜侧 Modbus RTU 设备的线圈（功能码 1）。",
    ),
    (
        "serial_modbus_read_input_bits",
        "读取控制柜侧 Modbus RTU 设备的离散输入（功能码 2）。",
    ),
    (
        "serial_modbus_read_input_registers",
        "读取控制柜侧 Modbus RTU 设备的输入寄存器（功能码 4）。",
    ),
    (
        "serial_modbus_read_registers",
        "读取控制柜侧 Modbus RTU 设备的保持寄存器（功能码 3）。",
    ),
    (
        "serial_modbus_write_bits",
        "写控制柜侧 Modbus RTU 设备的多个线圈（功能码 15）。",
    ),
    (
        "serial_modbus_write_registers",
        "写控制柜侧 Modbus RTU 设备的多个寄存器（功能码 16）。",
    ),
    (
        "serial_modbus_write_single_bit",
        "写控制柜侧 Modbus RTU 设备的一个线圈（功能码 5）。",
    ),
    (
        "serial_modbus_write_single_register",
        "写控制柜侧 Modbus RTU 设备的一个寄存器（功能码 6）。",
    ),
    ("serial_mode", "控制柜串口当前的用途（2.14.5 版的名称）。"),
    (
        "serial_read",
        "同 masterboard_serial_read（2.14.5 版的名称）。",
    ),
    (
        "serial_write",
        "同 masterboard_serial_write（2.14.5 版的名称）。",
    ),
    ("servoj", "让关节跟随一串位置，每次调用给出一个点。"),
    ("set_collision_detect_enabled", "开启或关闭碰撞检测。"),
    (
        "set_configurable_digital_input_action",
        "可配置数字输入为高时触发的动作。",
    ),
    (
        "set_configurable_digital_out",
        "设置可配置数字输出；电平在下一周期生效。",
    ),
    (
        "set_dyn_collision_force_min_ratio",
        "设置碰撞检测的灵敏度；100 最灵敏。",
    ),
    ("set_flag", "设置内部标志；程序结束后保持。"),
    (
        "set_gp_boolean_input_action",
        "布尔输入寄存器为高时触发的动作。",
    ),
    (
        "set_gravity",
        "设置手臂安装后感受到的加速度：方向背离地心。",
    ),
    ("set_input_actions_to_default", "所有输入都不再触发动作。"),
    ("set_payload", "设置法兰上的负载。"),
    (
        "set_runstate_configurable_digital_output_to_value",
        "没有程序运行时可配置数字输出的状态。",
    ),
    (
        "set_runstate_gp_boolean_output_to_value",
        "没有程序运行时布尔输出寄存器的状态。",
    ),
    (
        "set_runstate_standard_analog_output_to_value",
        "没有程序运行时标准模拟输出的状态。",
    ),
    (
        "set_runstate_standard_digital_output_to_value",
        "没有程序运行时标准数字输出的状态。",
    ),
    (
        "set_runstate_tool_analog_output_to_value",
        "没有程序运行时工具模拟输出的状态。",
    ),
    (
        "set_runstate_tool_digital_output_to_value",
        "没有程序运行时工具数字输出的状态。",
    ),
    (
        "set_safety_mode_transition_hardness",
        "进入缩减模式时手臂的制动方式。",
    ),
    (
        "set_standard_analog_input_domain",
        "让标准模拟输入测量电流或电压。",
    ),
    (
        "set_standard_analog_out",
        "设置标准模拟输出；在下一周期生效。",
    ),
    (
        "set_standard_analog_output_domain",
        "把标准模拟输出设为电流或电压。",
    ),
    (
        "set_standard_digital_input_action",
        "标准数字输入为高时触发的动作。",
    ),
    (
        "set_standard_digital_out",
        "设置标准数字输出；电平在下一周期生效。",
    ),
    ("set_tcp", "设置 TCP 相对于工具法兰的位姿。"),
    (
        "set_tool_analog_input_domain",
        "让工具模拟输入测量电流或电压。",
    ),
    ("set_tool_analog_io_work_mode", "工具模拟引脚的用途。"),
    (
        "set_tool_analog_output_domain",
        "把工具模拟输出设为电流或电压。",
    ),
    (
        "set_tool_digital",
        "设置工具数字引脚；引脚被禁用或为输入时以报警结束程序。",
    ),
    (
        "set_tool_digital_input_action",
        "工具数字输入为高时触发的动作。",
    ),
    ("set_tool_digital_io_config", "配置工具数字引脚。"),
    ("set_tool_digital_io_work_mode", "工具数字引脚的用途。"),
    ("set_tool_voltage", "工具接口的供电电压。"),
    ("sin", "正弦。"),
    ("sleep", "等待。"),
    ("socket_close", "关闭连接。"),
    (
        "socket_get_var",
        "向服务器询问整数：发送 GET 名称，2 秒内以“名称 值”应答。",
    ),
    ("socket_is_connected", "连接是否有效。"),
    ("socket_open", "在 2 秒内连接服务器；仍然有效的连接会保留。"),
    (
        "socket_read_ascii_float",
        "读取括号内以逗号或空格分隔的数。",
    ),
    ("socket_read_binary_integer", "读取网络字节序的 32 位整数。"),
    ("socket_read_byte_list", "读取字节。"),
    (
        "socket_read_string",
        "读取前缀与后缀之间的文本；其余留给下次调用。",
    ),
    ("socket_send_byte", "发送一个字节。"),
    ("socket_send_byte_list", "发送字节。"),
    ("socket_send_int", "以网络字节序发送 32 位整数。"),
    ("socket_send_line", "发送文本和换行。"),
    (
        "socket_send_string",
        "发送文本，或按 to_str() 的形式发送其他值。",
    ),
    ("socket_set_var", "发送 SET 名称 值。"),
    ("speedj", "关节加速到给定速度并保持，直到下一条运动指令。"),
    ("speedl", "TCP 加速到给定速度并保持，直到下一条运动指令。"),
    ("sqrt", "平方根。"),
    ("start_thread", "在新的脚本线程中运行函数。"),
    ("stop_conveyor_tracking", "结束跟踪并让工具停下。"),
    (
        "stop_thread",
        "停止脚本线程；其 finally 和 with 块仍会执行。",
    ),
    ("stopj", "让所有关节停下。"),
    ("stopl", "让 TCP 沿其直线停下。"),
    ("str_at", "某一位置的字符。"),
    (
        "str_cat",
        "把两个值作为文本连接；浮点数保留六位小数并去掉末尾的零。",
    ),
    ("str_empty", "文本是否为空。"),
    ("str_find", "一段文本在另一段中的起始位置。"),
    ("str_len", "文本的字节长度。"),
    ("str_sub", "文本的一部分。"),
    ("sync", "让出本控制周期的剩余时间，在下一周期继续。"),
    ("tan", "正切。"),
    ("textmsg", "把两部分连接后写入日志。"),
    ("to_num", "文本表示的数。"),
    ("to_str", "值的文本形式；浮点数保留六位小数并去掉末尾的零。"),
    (
        "tool_modbus_read_bits",
        "读取工具侧 Modbus RTU 设备的线圈（功能码 1）。",
    ),
    (
        "tool_modbus_read_input_bits",
        "读取工具侧 Modbus RTU 设备的离散输入（功能码 2）。",
    ),
    (
        "tool_modbus_read_input_registers",
        "读取工具侧 Modbus RTU 设备的输入寄存器（功能码 4）。",
    ),
    (
        "tool_modbus_read_registers",
        "读取工具侧 Modbus RTU 设备的保持寄存器（功能码 3）。",
    ),
    (
        "tool_modbus_write_bits",
        "写工具侧 Modbus RTU 设备的多个线圈（功能码 15）。",
    ),
    (
        "tool_modbus_write_registers",
        "写工具侧 Modbus RTU 设备的多个寄存器（功能码 16）。",
    ),
    (
        "tool_modbus_write_single_bit",
        "写工具侧 Modbus RTU 设备的一个线圈（功能码 5）。",
    ),
    (
        "tool_modbus_write_single_register",
        "写工具侧 Modbus RTU 设备的一个寄存器（功能码 6）。",
    ),
    ("tool_serial_config", "打开或关闭工具串口。"),
    ("tool_serial_is_open", "工具串口是否已打开。"),
    ("tool_serial_mode", "工具串口当前的用途。"),
    ("tool_serial_read", "从工具串口读取。"),
    ("tool_serial_write", "向工具串口写入。"),
    (
        "track_conveyor_circular",
        "从现在起在手臂运动上叠加转盘的运动。",
    ),
    (
        "track_conveyor_linear",
        "从现在起在手臂运动上叠加传送带的运动。",
    ),
    (
        "wrench_trans",
        "按变换本身变换力旋量：F' = R F，M' = R M + t x F'。",
    ),
    ("write_output_boolean_register", "把真值写入输出寄存器。"),
    ("write_output_float_register", "把数写入输出寄存器。"),
    (
        "write_output_integer_register",
        "把 32 位整数写入输出寄存器。",
    ),
    (
        "write_port_bit",
        "设置控制器自身 Modbus 表中的一位；32 至 59 为输出。",
    ),
    (
        "write_port_register",
        "设置控制器自身 Modbus 表中的一个字：输出、速度滑块或共享值。",
    ),
    (
        "zero_ftsensor",
        "把补偿后力传感器的当前读数作为零点，取代之前的零点。",
    ),
];
