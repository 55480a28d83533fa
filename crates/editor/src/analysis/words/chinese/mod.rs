//! What the functions of the robot do, in Chinese. A test holds the names against the declarations.

mod data;
mod phrases;

/// One sentence about a function.
pub(super) fn summary(name: &str) -> Option<&'static str> {
    let in_order = |table: &[(&str, &'static str)]| {
        let at = table.binary_search_by_key(&name, |(known, _)| known).ok()?;
        Some(table[at].1)
    };
    in_order(FIRST).or_else(|| in_order(data::SECOND))
}

/// What a parameter means, or what comes back.
pub(super) fn phrase(english: &str) -> Option<&'static str> {
    let table = phrases::PHRASES;
    let at = table
        .binary_search_by_key(&english, |(known, _)| known)
        .ok()?;
    Some(table[at].1)
}

/// The first half, in the order of the names.
const FIRST: &[(&str, &str)] = &[
    ("acos", "反余弦。"),
    ("asin", "反正弦。"),
    ("atan", "反正切。"),
    ("atan2", "正切为 x / y 的角，象限由两者的符号决定。"),
    (
        "binary_list_to_integer",
        "由位得到整数，首位为最低位；满 32 位时前 32 位为有符号数。",
    ),
    (
        "bit_list_to_integer",
        "由位得到整数，首位为最低位；满 32 位时前 32 位为有符号数。",
    ),
    (
        "byte_list_to_integer",
        "由位得到整数，首位为最低位；满 32 位时前 32 位为有符号数。",
    ),
    ("cal_rpy_frame", "由原点和两个方向得到坐标系位姿。"),
    ("ceil", "不小于 f 的最小整数。"),
    ("clear_interpreter", "删除注入的函数。"),
    (
        "controller_timestamp",
        "控制器时钟；虚拟时钟下为自 2026-01-01T00:00:00Z 起的仿真时间。",
    ),
    ("cos", "余弦。"),
    ("d2r", "角度转弧度。"),
    (
        "elicopy.copy",
        "值的浅拷贝，同 Python 的 copy.copy；无需导入。",
    ),
    (
        "elicopy.deepcopy",
        "值及其内容的深拷贝，同 Python 的 copy.deepcopy；无需导入。",
    ),
    (
        "encoder_enable_pulse_decode",
        "对接在高速输入上的增量编码器的脉冲计数。",
    ),
    (
        "encoder_enable_set_tick_count",
        "启用由程序给定计数的编码器。",
    ),
    ("encoder_get_tick_count", "传送带编码器的计数。"),
    (
        "encoder_set_tick_count",
        "给出编码器的计数，须先调用 encoder_enable_set_tick_count()。",
    ),
    (
        "encoder_unwind_delta_tick_count",
        "两次计数之差，消除计数器回绕的影响。",
    ),
    ("end_force_mode", "回到位置控制；任务结束时也会自动退出。"),
    (
        "end_freedrive_mode",
        "回到位置控制；任务结束时也会自动退出。",
    ),
    ("end_interpreter", "正在执行的语句结束后退出解释器模式。"),
    ("floor", "不大于 f 的最大整数。"),
    (
        "force",
        "TCP 受力的大小：get_tcp_force(True) 前三个数的模。",
    ),
    (
        "force_mode",
        "沿选定的轴以给定力旋量施力，其余轴跟随正在进行的运动。",
    ),
    (
        "force_mode_set_damping",
        "无力时力控轴停下的快慢；启动后为 0，保持到控制器结束。",
    ),
    (
        "force_mode_set_gain_scaling",
        "力趋近目标的快慢；启动后为 0.2，保持到控制器结束。",
    ),
    ("freedrive_mode", "允许用手沿自由轴拖动手臂。"),
    (
        "ft_rtsi_input_enable",
        "RTSI 输入 external_force_torque 是否作用于工具（基坐标轴）。",
    ),
    ("get_actual_joint_positions", "实际关节位置。"),
    ("get_actual_joint_speeds", "实际关节速度。"),
    ("get_actual_tcp_pose", "基坐标系下的实际 TCP 位姿。"),
    (
        "get_actual_tcp_speed",
        "基坐标系下的实际 TCP 速度：先线速度，后角速度。",
    ),
    (
        "get_actual_tool_flange_pose",
        "基坐标系下的实际工具法兰位姿。",
    ),
    (
        "get_all_inverse_kin",
        "到达 TCP 位姿的全部关节位置：依次按肩、腕、肘排列。",
    ),
    ("get_configurable_digital_in", "可配置数字输入的电平。"),
    ("get_configurable_digital_out", "可配置数字输出的电平。"),
    ("get_controller_temperature", "控制柜温度。"),
    ("get_dyn_collision_force_min_ratio", "碰撞检测的灵敏度。"),
    ("get_flag", "内部标志的状态。"),
    ("get_forward_kin", "关节位置对应的 TCP 位姿。"),
    (
        "get_inverse_kin",
        "到达 TCP 位姿的关节位置：取最接近 qnear 的解。",
    ),
    (
        "get_inverse_kin_has_solution",
        "get_inverse_kin 能否找到关节位置。",
    ),
    ("get_joint_temperatures", "各关节温度。"),
    (
        "get_joint_torques",
        "关节力矩减去手臂自身运动所需的部分：无接触时约为 0。",
    ),
    ("get_list_length", "列表的元素个数。"),
    (
        "get_micro_line_values_by_index",
        "已加载文件中的一个点，以关节位置或工件坐标系下的 TCP 位姿表示。",
    ),
    ("get_standard_analog_in", "标准模拟输入的值。"),
    ("get_standard_analog_out", "标准模拟输出的值。"),
    ("get_standard_digital_in", "标准数字输入的电平。"),
    ("get_standard_digital_out", "标准数字输出的电平。"),
    ("get_steptime", "一个控制周期的长度。"),
    ("get_target_joint_positions", "目标关节位置。"),
    ("get_target_joint_speeds", "目标关节速度。"),
    ("get_target_payload_cog", "当前负载在法兰坐标系下的重心。"),
    ("get_target_payload_mass", "当前负载的质量。"),
    ("get_target_tcp_pose", "基坐标系下的目标 TCP 位姿。"),
    (
        "get_target_tcp_pose_along_path",
        "规划路径当前要求的 TCP 位姿，不含偏移。",
    ),
    (
        "get_target_tcp_speed",
        "基坐标系下的目标 TCP 速度：先线速度，后角速度。",
    ),
    (
        "get_target_waypoint",
        "当前运动要到达的 TCP 位姿；没有运动时为目标位姿。",
    ),
    ("get_task_path", "存放任务的目录。"),
    (
        "get_tcp_force",
        "环境对工具的作用力，在 TCP 坐标系下，力矩相对于 TCP。",
    ),
    ("get_tcp_offset", "当前 TCP 相对于法兰的位姿。"),
    ("get_tool_analog_in", "工具模拟输入的值。"),
    ("get_tool_analog_out", "工具模拟输出的值。"),
    ("get_tool_digital", "工具数字引脚的电平。"),
    ("halt", "结束整个任务，视为成功。"),
    ("integer_to_binary_list", "整数补码的低 32 位，最低位在前。"),
    ("integer_to_bit_list", "整数补码的低 32 位，最低位在前。"),
    ("integer_to_byte_list", "整数补码的低 32 位，最低位在前。"),
    (
        "interpolate_pose",
        "两位姿之间插值：位置走直线，姿态走最短旋转。",
    ),
    (
        "interpreter_mode",
        "在调用者的作用域中执行来自端口 30020 的语句，直到 end_interpreter()。只能在主线程中调用。",
    ),
    ("is_collision_detect_enabled", "碰撞检测是否开启。"),
    (
        "is_within_safety_limits",
        "TCP 位姿（或以 q 给出的关节位置）能否在关节范围和安全平面内到达。",
    ),
    ("join_thread", "等待脚本线程结束。"),
    ("length", "列表的元素个数或字符串的字符数。"),
    ("load_micro_line_file", "从任务目录加载点位文件。"),
    ("log", "f 以 b 为底的对数；底数在前。"),
    (
        "masterboard_modbus_rtu_read_bits",
        "读取控制柜侧 Modbus RTU 设备的线圈（功能码 1）。",
    ),
    (
        "masterboard_modbus_rtu_read_input_bits",
        "读取控制柜侧 Modbus RTU 设备的离散输入（功能码 2）。",
    ),
    (
        "masterboard_modbus_rtu_read_input_registers",
        "读取控制柜侧 Modbus RTU 设备的输入寄存器（功能码 4）。",
    ),
    (
        "masterboard_modbus_rtu_read_registers",
        "读取控制柜侧 Modbus RTU 设备的保持寄存器（功能码 3）。",
    ),
    (
        "masterboard_modbus_rtu_write_bits",
        "写控制柜侧 Modbus RTU 设备的多个线圈（功能码 15）。",
    ),
    (
        "masterboard_modbus_rtu_write_registers",
        "写控制柜侧 Modbus RTU 设备的多个寄存器（功能码 16）。",
    ),
    (
        "masterboard_modbus_rtu_write_single_bit",
        "写控制柜侧 Modbus RTU 设备的一个线圈（功能码 5）。",
    ),
    (
        "masterboard_modbus_rtu_write_single_register",
        "写控制柜侧 Modbus RTU 设备的一个寄存器（功能码 6）。",
    ),
    ("masterboard_serial_config", "打开或关闭控制柜串口。"),
    (
        "masterboard_serial_flush",
        "丢弃控制柜串口已收到而未读取的内容。",
    ),
    ("masterboard_serial_mode", "控制柜串口当前的用途。"),
    ("masterboard_serial_read", "从控制柜串口读取。"),
    ("masterboard_serial_write", "向控制柜串口写入。"),
    ("micro_line_set_pcs", "设置已加载文件中各位姿所在的坐标系。"),
    ("modbus_add_rw_signal", "添加用功能码 23 读写寄存器的信号。"),
    (
        "modbus_add_signal",
        "添加 Modbus 设备的信号，或替换同名信号。",
    ),
    ("modbus_delete_signal", "删除信号。"),
    ("modbus_get_error", "信号的错误码（表 6-2 与 errno）。"),
    (
        "modbus_get_signal_status",
        "信号的值；等待首次应答，最长为其看门狗时间。",
    ),
    (
        "modbus_get_time_since_signal_invalid",
        "距上次正常应答的时间。",
    ),
    ("modbus_reset_connection", "断开与设备的连接并重新建立。"),
    (
        "modbus_send_custom_command",
        "发送功能码及其字节；不查看应答。",
    ),
    (
        "modbus_set_output_register",
        "设置寄存器输出；此后只写不读。",
    ),
    ("modbus_set_output_signal", "设置数字输出；此后只写不读。"),
    (
        "modbus_set_runstate_dependent_choice",
        "没有程序运行时数字输出的状态。",
    ),
    ("modbus_set_signal_update_frequency", "信号的更新频率。"),
    (
        "modbus_set_signal_watchdog",
        "信号多久没有正常应答后访问会报错；初始为 5 秒。",
    ),
    ("movec", "TCP 经过中间位姿沿圆弧运动。"),
    (
        "movej",
        "沿关节空间的直线运动；所有关节同时开始、同时结束。",
    ),
    ("movel", "TCP 沿直线运动，姿态绕一根固定轴转动。"),
    ("moveml", "按文件给出的时间经过各点，关节跟不上处放慢。"),
    ("movep", "TCP 沿直线运动，并以相同速度通过过渡段。"),
    (
        "norm",
        "列表或位姿的欧氏长度（各数同等对待），或数的绝对值。",
    ),
    ("normalize", "向量除以其欧氏长度。"),
    (
        "path_offset_disable",
        "结束路径偏移：关节制动，下一运动从手臂停处开始。",
    ),
    (
        "path_offset_enable",
        "从现在起路径偏移生效，包括之前设置的偏移。",
    ),
    ("path_offset_get", "当前生效的偏移。"),
    (
        "path_offset_set",
        "在 TCP 路径上叠加偏移；在手臂限制内逐渐移到该偏移。",
    ),
    ("path_offset_set_alpha_filter", "设置新偏移的滤波。"),
    (
        "path_offset_set_max_offset",
        "设置偏移的上限；超出时保护性停止。",
    ),
    ("pause", "暂停整个任务直到外部恢复；手臂在路径上减速。"),
    ("point_dist", "两个位置之间的距离；不计姿态。"),
    (
        "popup",
        "显示弹窗；blocking=True 时线程等待其关闭，次级程序中除外。",
    ),
    (
        "pose_add",
        "位置相加，姿态依次相乘；与 pose_trans 不同，p_2 的位置不随之转动。",
    ),
    (
        "pose_dist",
        "六个数之差的欧氏长度，米与弧度混合，角度不归一。",
    ),
];
