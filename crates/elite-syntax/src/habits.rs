//! Words that people bring from other robots and other languages, and what they are called here.

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
pub fn advice(word: &str) -> Option<&'static str> {
    Some(match word {
        "p" => "a pose is a plain list: write [x, y, z, rx, ry, rz] without 'p'",
        "thread" => {
            "a thread is a function that start_thread() begins: write 'def' in place of 'thread'"
        }
        "self" => "'self' is the first parameter of a method: def name(self)",
        "this" => "an object is the first parameter of its methods, called 'self' by custom",
        "pi" | "PI" | "Pi" | "M_PI" | "math_pi" => {
            "write math.pi, and 'import math' at the beginning of the program"
        }
        "moveto" | "move_to" | "moveTo" | "MoveTo" | "goto" | "go_to" => {
            "movej() turns the joints to a place, movel() leads the TCP there along a straight line"
        }
        "numpy" | "np" => "numpy is not there: lists, math and the functions for poses are",
        _ => return None,
    })
}

/// Our name, and words for it.
const USUAL_NAMES: &[(&str, &[&str])] = &[
    ("None", &["null", "NULL", "nil", "undefined", "nullptr"]),
    (
        "print",
        &["printf", "println", "echo", "puts", "writeln", "cout"],
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
        ],
    ),
    (
        "popup",
        &["messagebox", "message_box", "msgbox", "alert", "show_popup"],
    ),
    (
        "sleep",
        &["wait", "delay", "waittime", "wait_time", "waitTime", "Wait"],
    ),
    ("halt", &["exit", "quit", "stop_program", "abort"]),
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
        ],
    ),
    ("movec", &["circ", "CIRC", "move_circ", "move_circular"]),
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
        ],
    ),
    ("get_standard_digital_out", &["get_digital_out", "get_do"]),
    (
        "set_standard_analog_out",
        &["set_analog_out", "set_ao", "analogWrite"],
    ),
    (
        "get_standard_analog_in",
        &["get_analog_in", "get_ai", "analogRead"],
    ),
    ("get_standard_analog_out", &["get_analog_out"]),
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
            "get_flange_pose",
            "CRobT",
        ],
    ),
    ("get_target_tcp_pose", &["get_target_pose"]),
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
        ],
    ),
    (
        "d2r",
        &[
            "deg2rad",
            "deg_to_rad",
            "to_radians",
            "radians",
            "degtorad",
            "d2rad",
        ],
    ),
    (
        "r2d",
        &["rad2deg", "rad_to_deg", "to_degrees", "degrees", "radtodeg"],
    ),
    ("set_tcp", &["set_tool", "set_tool_frame", "set_tcp_pose"]),
    (
        "set_payload",
        &["set_target_payload", "set_load", "set_payload_mass"],
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
    ("zero_ftsensor", &["zero_force", "tare", "ft_zero"]),
    (
        "start_thread",
        &["run_thread", "create_thread", "thread_run", "new_thread"],
    ),
    ("stop_thread", &["kill_thread", "kill", "end_thread"]),
    ("join_thread", &["wait_thread", "thread_join"]),
    (
        "socket_read_string",
        &["socket_read_line", "socket_read", "socket_recv"],
    ),
    (
        "socket_send_string",
        &["socket_write", "socket_send", "socket_write_string"],
    ),
    ("to_str", &["to_string", "tostring", "toString"]),
    (
        "to_num",
        &[
            "to_number",
            "tonumber",
            "atoi",
            "atof",
            "parse_int",
            "str_to_num",
        ],
    ),
    ("len", &["sizeof", "strlen", "count", "array_length"]),
    ("abs", &["fabs"]),
    ("pow", &["power"]),
];
