//! Words that people bring from other robots and other languages, and what they are called here.

use messages::{Text, text};

/// The name for what `word` is elsewhere, in whatever case and with or without underscores; whether a program has it
/// is up to the caller.
pub(crate) fn usual_name(word: &str) -> Option<&'static str> {
    let is_known = |known: &&str| letters(known).eq(letters(word));
    let row = USUAL_NAMES
        .iter()
        .find(|(_, words)| words.iter().any(is_known));
    row.map(|(name, _)| *name)
}

fn letters(word: &str) -> impl Iterator<Item = char> {
    word.chars()
        .filter(|c| *c != '_')
        .flat_map(char::to_lowercase)
}

/// What to do instead of using `word`, where no other name does the same.
pub fn advice(word: &str) -> Option<Text> {
    Some(match word {
        "p" => text!(
            "a pose is a plain list: write [x, y, z, rx, ry, rz] without 'p'",
            "位姿就是普通列表：写成 [x, y, z, rx, ry, rz]，不带 'p'"
        ),
        "thread" => {
            text!(
                "a thread is a function that start_thread() begins: write 'def' in place of \
                 'thread'",
                "线程是由 start_thread() 启动的函数：把 'thread' 改为 'def'"
            )
        }
        "self" => text!(
            "'self' is the first parameter of a method: def name(self)",
            "'self' 是方法的第一个参数：def name(self)"
        ),
        "this" => text!(
            "an object is the first parameter of its methods, called 'self' by custom",
            "对象是其方法的第一个参数，习惯上叫 'self'"
        ),
        "pi" | "PI" | "Pi" | "M_PI" | "math_pi" => {
            text!(
                "write math.pi, and 'import math' at the beginning of the program",
                "请写 math.pi，并在程序开头写 'import math'"
            )
        }
        "moveto" | "move_to" | "moveTo" | "MoveTo" | "goto" | "go_to" => {
            text!(
                "movej() turns the joints to a place, movel() leads the TCP there along a \
                 straight line",
                "movej() 以关节运动到目标，movel() 使 TCP 沿直线到达目标"
            )
        }
        "numpy" | "np" => text!(
            "numpy is not there: lists, math and the functions for poses are",
            "没有 numpy：可以用列表、math 和位姿函数"
        ),
        "math" => text!(
            "write 'import math' at the beginning of the program",
            "请在程序开头写 'import math'"
        ),
        "time" => text!(
            "write 'import time' at the beginning of the program",
            "请在程序开头写 'import time'"
        ),
        "waituntil" | "wait_until" | "WaitUntil" | "waitfor" | "wait_for" | "WaitDI"
        | "wait_di" | "wait_input" | "wait_digital_in" => {
            text!(
                "write a loop: 'while not get_standard_digital_in(0): sync()'",
                "请写循环：'while not get_standard_digital_in(0): sync()'"
            )
        }
        "raw_input" | "TPReadNum" | "TPReadFK" => {
            text!(
                "a program asks nobody at the robot: popup() shows a message",
                "程序不向机器人旁的人提问：popup() 显示消息"
            )
        }
        _ => return None,
    })
}

/// Our name, and words for it.
const USUAL_NAMES: &[(&str, &[&str])] = &[
    ("None", &["null", "NULL", "nil", "undefined", "nullptr"]),
    (
        "print",
        &[
            "printf",
            "println",
            "print_msg",
            "print_line",
            "echo",
            "puts",
            "writeln",
            "write_line",
            "cout",
            "fprintf",
            "disp",
        ],
    ),
    (
        "textmsg",
        &[
            "textmessage",
            "text_message",
            "message",
            "log_message",
            "logmsg",
            "show_message",
            "TPWrite",
            "ErrWrite",
            "MsgNotify",
        ],
    ),
    (
        "popup",
        &[
            "messagebox",
            "message_box",
            "msgbox",
            "UIMsgBox",
            "MsgDialog",
            "alert",
            "show_popup",
        ],
    ),
    (
        "sleep",
        &[
            "wait",
            "delay",
            "waittime",
            "wait_time",
            "waitTime",
            "Wait",
            "wait_sec",
            "usleep",
            "msleep",
            "dwell",
            "pause_for",
        ],
    ),
    (
        "halt",
        &[
            "exit",
            "quit",
            "stop_program",
            "end_program",
            "exit_program",
            "abort",
            "terminate",
        ],
    ),
    ("powerdown", &["power_off", "poweroff", "shutdown"]),
    (
        "controller_timestamp",
        &[
            "clock",
            "get_time",
            "get_timestamp",
            "get_clock",
            "ClkRead",
            "get_system_time",
            "system_time",
            "timestamp",
            "millis",
            "now",
            "timer",
            "get_timer",
        ],
    ),
    (
        "get_steptime",
        &["get_cycle_time", "cycle_time", "get_control_period"],
    ),
    ("sync", &["wait_cycle", "next_cycle", "yield_cycle"]),
    (
        "random",
        &[
            "rand",
            "rnd",
            "randf",
            "rand_float",
            "random_number",
            "get_random",
        ],
    ),
    (
        "movej",
        &[
            "ptp",
            "PTP",
            "move_ptp",
            "moveptp",
            "move_joint",
            "move_joints",
            "movejoint",
            "MoveAbsJ",
            "SPTP",
            "movea",
        ],
    ),
    (
        "movel",
        &[
            "lin",
            "LIN",
            "move_lin",
            "movelin",
            "move_linear",
            "move_line",
            "SLIN",
        ],
    ),
    (
        "movec",
        &["circ", "CIRC", "SCIRC", "move_circ", "move_circular"],
    ),
    ("movep", &["move_process", "move_path"]),
    ("servoj", &["servo", "servo_joint"]),
    (
        "set_standard_digital_out",
        &[
            "set_digital_out",
            "set_digital_output",
            "set_do",
            "set_dout",
            "setDO",
            "SetDO",
            "set_output",
            "digital_out",
            "digitalWrite",
            "set_standard_digital_output",
        ],
    ),
    (
        "get_standard_digital_in",
        &[
            "get_digital_in",
            "get_digital_input",
            "read_digital_in",
            "get_di",
            "get_input",
            "digital_in",
            "digitalRead",
            "get_standard_digital_input",
            "TestDI",
            "DInput",
        ],
    ),
    ("get_standard_digital_out", &["get_digital_out", "get_do"]),
    (
        "set_standard_analog_out",
        &[
            "set_analog_out",
            "set_analog_output",
            "set_ao",
            "analogWrite",
        ],
    ),
    (
        "get_standard_analog_in",
        &[
            "get_analog_in",
            "get_analog_input",
            "get_ai",
            "analogRead",
            "AInput",
        ],
    ),
    ("get_standard_analog_out", &["get_analog_out"]),
    (
        "set_configurable_digital_out",
        &[
            "set_configurable_out",
            "set_configurable_output",
            "set_config_digital_out",
        ],
    ),
    (
        "get_configurable_digital_in",
        &[
            "get_configurable_in",
            "get_configurable_input",
            "get_config_digital_in",
        ],
    ),
    (
        "read_input_boolean_register",
        &["read_input_bit_register", "read_input_bool_register"],
    ),
    (
        "read_output_boolean_register",
        &["read_output_bit_register", "read_output_bool_register"],
    ),
    (
        "write_output_boolean_register",
        &["write_output_bit_register", "write_output_bool_register"],
    ),
    ("read_input_integer_register", &["read_input_int_register"]),
    (
        "read_output_integer_register",
        &["read_output_int_register"],
    ),
    (
        "write_output_integer_register",
        &["write_output_int_register"],
    ),
    ("rtsi_set_watchdog", &["rtde_set_watchdog"]),
    ("set_tool_voltage", &["tool_voltage", "set_tool_power"]),
    (
        "set_tool_digital",
        &["set_tool_digital_out", "set_tool_output", "set_tool_do"],
    ),
    (
        "get_tool_digital",
        &["get_tool_digital_in", "get_tool_input", "get_tool_di"],
    ),
    (
        "get_actual_joint_positions",
        &[
            "get_joint_positions",
            "get_joint_position",
            "get_joint_angles",
            "get_joints",
            "get_actual_q",
            "getjointpos",
            "get_current_joints",
            "get_joint_pose",
            "CJointT",
        ],
    ),
    (
        "get_actual_joint_speeds",
        &["get_joint_speeds", "get_joint_velocities"],
    ),
    (
        "get_actual_tcp_pose",
        &[
            "get_tcp_pose",
            "get_pose",
            "get_tool_pose",
            "get_actual_pose",
            "get_current_pose",
            "get_tcp_position",
            "get_cartesian_pose",
            "CRobT",
            "CPos",
        ],
    ),
    (
        "get_actual_tool_flange_pose",
        &[
            "get_flange_pose",
            "get_actual_flange_pose",
            "get_tool_flange_pose",
        ],
    ),
    ("get_target_tcp_pose", &["get_target_pose"]),
    (
        "get_tcp_offset",
        &["get_tcp", "get_tool_offset", "get_tool_frame"],
    ),
    ("get_joint_torques", &["get_torques", "get_actual_torques"]),
    (
        "get_joint_temperatures",
        &["get_joint_temp", "get_joint_temps", "get_joint_temperature"],
    ),
    (
        "get_controller_temperature",
        &["get_controller_temp", "get_temperature"],
    ),
    (
        "get_actual_tcp_speed",
        &["get_tcp_speed", "get_tcp_velocity"],
    ),
    (
        "get_tcp_force",
        &["get_force", "get_wrench", "get_tcp_wrench", "get_ft"],
    ),
    (
        "get_inverse_kin",
        &[
            "inverse_kinematics",
            "inverse_kin",
            "get_ik",
            "ik",
            "get_inverse_kinematics",
            "inverse_kinematic",
            "CalcJointT",
        ],
    ),
    (
        "get_forward_kin",
        &[
            "forward_kinematics",
            "forward_kin",
            "get_fk",
            "fk",
            "get_forward_kinematics",
            "forward_kinematic",
            "CalcRobT",
        ],
    ),
    (
        "pose_trans",
        &[
            "pose_transform",
            "pose_mul",
            "pose_mult",
            "pose_multiply",
            "transform_pose",
            "RelTool",
        ],
    ),
    ("pose_add", &["pose_sum", "add_pose", "Offs", "offset_pose"]),
    (
        "pose_sub",
        &["pose_subtract", "pose_diff", "pose_difference", "sub_pose"],
    ),
    (
        "pose_inv",
        &["pose_inverse", "inverse_pose", "invert_pose", "inv_pose"],
    ),
    ("pose_dist", &["pose_distance"]),
    ("point_dist", &["point_distance", "distance_between"]),
    (
        "interpolate_pose",
        &["pose_interpolate", "pose_lerp", "lerp_pose"],
    ),
    ("wrench_trans", &["wrench_transform", "transform_wrench"]),
    ("rpy2rotvec", &["rpy_to_rotvec", "rpy_to_rotation_vector"]),
    ("rotvec2rpy", &["rotvec_to_rpy", "rotation_vector_to_rpy"]),
    (
        "d2r",
        &[
            "deg2rad",
            "deg_to_rad",
            "to_radians",
            "radians",
            "degtorad",
            "d2rad",
            "torad",
            "rad",
        ],
    ),
    (
        "r2d",
        &[
            "rad2deg",
            "rad_to_deg",
            "to_degrees",
            "degrees",
            "radtodeg",
            "todeg",
            "deg",
        ],
    ),
    ("set_tcp", &["set_tool", "set_tool_frame", "set_tcp_pose"]),
    (
        "set_payload",
        &[
            "set_target_payload",
            "set_load",
            "set_payload_mass",
            "GripLoad",
        ],
    ),
    (
        "get_target_payload_mass",
        &["get_payload", "get_target_payload", "get_payload_mass"],
    ),
    ("get_target_payload_cog", &["get_payload_cog", "get_cog"]),
    (
        "set_collision_detect_enabled",
        &[
            "set_collision_detection",
            "enable_collision_detection",
            "set_collision_detect",
        ],
    ),
    (
        "freedrive_mode",
        &["teach_mode", "freedrive", "start_freedrive", "hand_guiding"],
    ),
    (
        "end_freedrive_mode",
        &["end_teach_mode", "stop_freedrive", "freedrive_off"],
    ),
    (
        "end_force_mode",
        &["force_mode_end", "stop_force_mode", "force_mode_off"],
    ),
    (
        "zero_ftsensor",
        &[
            "zero_ft",
            "zero_force",
            "zero_force_sensor",
            "tare",
            "tare_ft",
            "tare_force",
            "ft_zero",
            "reset_ft",
            "bias_ft",
        ],
    ),
    (
        "start_thread",
        &["run_thread", "create_thread", "thread_run", "new_thread"],
    ),
    ("stop_thread", &["kill_thread", "kill", "end_thread"]),
    ("join_thread", &["wait_thread", "thread_join", "join"]),
    (
        "encoder_get_tick_count",
        &["get_conveyor_tick_count", "get_tick_count"],
    ),
    ("encoder_set_tick_count", &["set_conveyor_tick_count"]),
    ("encoder_enable_pulse_decode", &["conveyor_pulse_decode"]),
    (
        "socket_open",
        &["socket_connect", "socket_create", "open_socket"],
    ),
    ("socket_close", &["socket_disconnect", "close_socket"]),
    (
        "socket_read_string",
        &[
            "socket_read_line",
            "socket_read",
            "socket_recv",
            "socket_receive",
        ],
    ),
    (
        "socket_send_string",
        &["socket_write", "socket_send", "socket_write_string"],
    ),
    (
        "str_cat",
        &["concat", "str_concat", "string_concat", "str_join"],
    ),
    (
        "str_find",
        &["find_str", "string_find", "index_of", "str_index", "instr"],
    ),
    (
        "str_sub",
        &["substring", "substr", "str_substr", "StrPart", "sub_string"],
    ),
    ("str_at", &["char_at", "str_char"]),
    ("str_empty", &["is_empty", "str_is_empty"]),
    (
        "to_str",
        &[
            "to_string",
            "tostring",
            "toString",
            "int_to_str",
            "num_to_str",
            "float_to_str",
            "ValToStr",
        ],
    ),
    (
        "to_num",
        &[
            "to_number",
            "tonumber",
            "atoi",
            "atof",
            "parse_int",
            "parse_float",
            "str_to_num",
            "str_to_int",
            "str_to_float",
            "StrToVal",
        ],
    ),
    ("len", &["sizeof", "strlen", "count", "array_length"]),
    ("abs", &["fabs", "absolute"]),
    ("pow", &["power"]),
    ("sqrt", &["square_root", "sqroot"]),
    ("ceil", &["ceiling"]),
    ("log", &["ln"]),
    ("asin", &["arcsin"]),
    ("acos", &["arccos"]),
    ("atan", &["arctan"]),
    ("atan2", &["arctan2"]),
    (
        "norm",
        &["magnitude", "vector_length", "vec_norm", "vector_norm"],
    ),
    ("normalize", &["unit_vector"]),
];
