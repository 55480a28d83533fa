//! Builtins that neither move, wait nor talk to the outside take no simulated time: two hundred calls of each, in one
//! cycle.
//!
//! The list comes from the declarations: a builtin that is added says here how it is called, or why it is not.

#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

use crate::common;

use std::collections::BTreeSet;

use common::{Standing, run};
use elite_runtime::TaskEnd;
use elite_runtime::builtins;

/// Calls per builtin.
const CALLS: usize = 200;

/// What asks something of the task, or talks to people, lines, other machines and files.
const NOT_CALLED: &str = "pause halt powerdown end_interpreter clear_interpreter start_thread stop_thread popup \
    rtsi_set_watchdog \
    modbus_add_signal modbus_add_rw_signal modbus_delete_signal modbus_get_signal_status modbus_send_custom_command \
    modbus_set_output_register modbus_set_output_signal modbus_set_runstate_dependent_choice \
    modbus_set_signal_update_frequency modbus_set_signal_watchdog modbus_get_error \
    modbus_get_time_since_signal_invalid \
    rpc_factory tool_serial_write masterboard_serial_write serial_write masterboard_serial_flush serial_flush \
    serial_config masterboard_serial_config tool_serial_config \
    socket_send_byte_list socket_send_byte socket_send_int socket_send_line socket_send_string socket_set_var \
    load_micro_line_file micro_line_set_pcs get_micro_line_values_by_index";

/// A call of each of the others; `n` is its number.
const CALLED: &str = "
print()
textmsg('')
serial_is_open()
serial_mode()
masterboard_serial_mode()
tool_serial_is_open()
tool_serial_mode()
get_actual_joint_positions()
get_actual_joint_speeds()
get_actual_tcp_pose()
get_actual_tcp_speed()
get_controller_temperature()
get_joint_temperatures()
get_joint_torques()
get_target_joint_positions()
get_target_joint_speeds()
get_target_tcp_pose()
get_target_tcp_speed()
get_target_payload_cog()
get_target_payload_mass()
get_target_waypoint()
get_tcp_offset()
get_actual_tool_flange_pose()
is_collision_detect_enabled()
get_dyn_collision_force_min_ratio()
set_gravity([0, 0, 9 + n / 1000])
set_payload(n / 1000, [0, 0, n / 1000])
set_tcp([0, 0, n / 1000, 0, 0, 0])
encoder_enable_set_tick_count(0, 2)
encoder_set_tick_count(0, n)
encoder_get_tick_count(0)
encoder_unwind_delta_tick_count(0, 5.0)
encoder_enable_pulse_decode(1, 1, 16, 17)
track_conveyor_linear([1, 0, 0, 0, 0, 0], 1000)
track_conveyor_circular([1, 0, 0, 0, 0, 0], 1000)
freedrive_mode()
end_freedrive_mode()
set_collision_detect_enabled(n % 2 == 0)
set_dyn_collision_force_min_ratio(10 + n % 90)
is_within_safety_limits([0.3, 0.1, 0.4, 3.1, 0, 0])
get_inverse_kin([0.3, 0.1, 0.4, 3.1, 0, 0])
get_inverse_kin_has_solution([0.3, 0.1, 0.4, 3.1, 0, 0])
get_all_inverse_kin([0.3, 0.1, 0.4, 3.1, 0, 0])
get_forward_kin()
binary_list_to_integer([1, 0])
byte_list_to_integer([1, 0])
bit_list_to_integer([1, 0])
integer_to_binary_list(n)
integer_to_byte_list(n)
integer_to_bit_list(n)
get_list_length([1])
length([1])
acos(0.5)
asin(0.5)
atan(0.5)
atan2(1, 2)
cos(n)
sin(n)
tan(n)
d2r(n)
r2d(n)
ceil(0.5)
floor(0.5)
log(2, 8)
sqrt(n)
pow(2, 3)
norm([1, 2])
normalize([1, 2])
point_dist([0] * 6, [1] * 6)
pose_add([0] * 6, [1] * 6)
pose_dist([0] * 6, [1] * 6)
pose_inv([1] * 6)
pose_sub([0] * 6, [1] * 6)
pose_trans([0] * 6, [1] * 6)
rotvec2rpy([0.1, 0.2, 0.3])
rpy2rotvec([0.1, 0.2, 0.3])
interpolate_pose([0] * 6, [1] * 6, 0.5)
random()
force_mode([0] * 6, [0, 0, 1, 0, 0, 0], [0, 0, n, 0, 0, 0], 0, [0.1] * 6)
end_force_mode()
force_mode_set_gain_scaling(n / 200)
force_mode_set_damping(n / 200)
zero_ftsensor()
force()
get_tcp_force(True)
wrench_trans([0] * 6, [1] * 6)
ft_rtsi_input_enable(n % 2 == 0)
get_configurable_digital_in(0)
get_configurable_digital_out(0)
get_standard_analog_in(0)
get_standard_analog_out(0)
get_standard_digital_in(0)
get_standard_digital_out(0)
get_tool_analog_in()
get_tool_analog_out()
set_standard_analog_output_domain(0, n % 2)
set_configurable_digital_out(0, n % 2 == 0)
set_standard_analog_input_domain(0, n % 2)
set_standard_analog_out(0, n / 200)
set_standard_digital_out(0, n % 2 == 0)
set_tool_analog_input_domain(n % 2)
set_tool_analog_output_domain(n % 2)
set_tool_digital_io_config(0, 0, True, True)
set_tool_digital(0, n % 2 == 0)
get_tool_digital(0)
set_tool_analog_io_work_mode(0)
set_runstate_configurable_digital_output_to_value(0, 0)
set_runstate_gp_boolean_output_to_value(0, 0)
set_runstate_standard_analog_output_to_value(0, 0)
set_runstate_tool_analog_output_to_value(0)
set_runstate_standard_digital_output_to_value(0, 0)
set_runstate_tool_digital_output_to_value(0, 0)
set_input_actions_to_default()
set_configurable_digital_input_action(0, 'default')
set_standard_digital_input_action(0, 'default')
set_tool_digital_input_action(0, 'default')
set_gp_boolean_input_action(0, 'default')
set_tool_voltage(0)
get_task_path()
read_input_boolean_register(0)
read_input_float_register(0)
read_input_integer_register(0)
read_output_boolean_register(0)
read_output_float_register(0)
read_output_integer_register(0)
write_output_boolean_register(0, n % 2 == 0)
write_output_float_register(0, n)
write_output_integer_register(0, n)
read_port_bit(0)
read_port_register(256)
write_port_bit(33, n % 2 == 0)
write_port_register(256, n)
socket_close()
socket_is_connected()
str_at('abc', 1)
str_cat('a', n)
str_empty('')
str_find('abc', 'c')
str_len('abc')
str_sub('abc', 1)
to_num('1')
to_str(n)
set_flag(0, n % 2 == 0)
get_flag(0)
get_steptime()
controller_timestamp()
get_target_tcp_pose_along_path()
path_offset_enable()
path_offset_set([0, 0, n / 1000, 0, 0, 0], 1)
path_offset_get(1)
path_offset_set_alpha_filter(0.5)
path_offset_set_max_offset(0.1, 0.5)
set_safety_mode_transition_hardness(1)
set_tool_digital_io_work_mode(0)
cal_rpy_frame([0, 0, 0], [1, 0, 0], [0, 1, 0])
elicopy.copy([n])
elicopy.deepcopy([n])
";

fn name_of(call: &str) -> &str {
    call.split('(').next().unwrap_or_default()
}

/// What has to be said before a call, and after it, so that it can be made again.
fn around(name: &str) -> (&'static str, &'static str) {
    match name {
        "encoder_set_tick_count" => ("encoder_enable_set_tick_count(0, 2)", ""),
        "set_tool_digital" => ("set_tool_digital_io_config(0, 0, True, True)", ""),
        _ => ("", ""),
    }
}

#[test]
fn two_hundred_calls_of_each_take_no_simulated_time() {
    let mut missing: BTreeSet<&str> = builtins::all()
        .filter(|builtin| !builtin.waits)
        .map(|builtin| builtin.name)
        .collect();
    for name in NOT_CALLED.split_whitespace() {
        assert!(missing.remove(name), "{name} is no such builtin");
    }
    for call in CALLED.lines().filter(|line| !line.is_empty()) {
        let name = name_of(call);
        assert!(missing.remove(name), "{name} is no such builtin");
        let (before, after) = around(name);
        // A conveyor is tracked once; to stop tracking waits.
        let calls = if name.starts_with("track") { 1 } else { CALLS };
        let text = format!(
            "def main():\n  import time\n  {before}\n  sync()\n  begin = time.time()\n  n = 0\n  while n < {calls}:\
             \n    {call}\n    {after}\n    n = n + 1\n  end\n  textmsg('took', time.time() - begin)\nend\n"
        );
        let ran = run(&Standing::default(), &text);
        assert_eq!(
            (&ran.end, ran.error.as_str()),
            (&TaskEnd::Finished, ""),
            "{call}"
        );
        let took = ran.log.last().unwrap();
        assert!(
            ["took0", "took 0", "took0.0", "took 0.0"].contains(&took.as_str()),
            "{call}: {took}"
        );
    }
    assert!(missing.is_empty(), "how are these called? {missing:?}");
}

#[test]
fn what_the_cycle_would_refuse_raises_at_the_call_in_the_view_of_the_caller() {
    for (text, error) in [
        (
            "encoder_set_tick_count(0, 5)",
            "ValueError: encoder_set_tick_count(): the tick count is 5; \
             it must be set after encoder_enable_set_tick_count() for this encoder",
        ),
        (
            "encoder_enable_set_tick_count(0, 1)\n  encoder_set_tick_count(0, 256)",
            "ValueError: encoder_set_tick_count(): the tick count is 256; it must be 0 to 255",
        ),
        (
            "encoder_enable_set_tick_count(0, 1)\n  encoder_enable_pulse_decode(0, 1, 16, 17)\
             \n  encoder_set_tick_count(0, 5)",
            "ValueError: encoder_set_tick_count(): the tick count is 5; \
             it must be set after encoder_enable_set_tick_count() for this encoder",
        ),
        (
            "set_tcp([0, 0, 10.5, 0, 0, 0])",
            "ValueError: set_tcp(): a coordinate of the TCP is 10.5; it must be at most 10 m",
        ),
        (
            "set_gravity([0, 0, 31])",
            "ValueError: set_gravity(): a component of gravity is -31; it must be at most 30 m/s²",
        ),
        (
            "track_conveyor_linear([1, 0, 0, 0, 0, 0], 1000)\n  track_conveyor_linear([1, 0, 0, 0, 0, 0], 1000)",
            "RuntimeError: track_conveyor_linear(): a conveyor is tracked already; \
             end that first with stop_conveyor_tracking()",
        ),
        (
            "track_conveyor_linear([1, 0, 0, 0, 0, 0], 1000)\n  force_mode([0] * 6, [0] * 6, [0] * 6, 0, [0] * 6)",
            "RuntimeError: force_mode(): a conveyor is tracked already; end that first with stop_conveyor_tracking()",
        ),
        (
            "force_mode([0] * 6, [0] * 6, [0] * 6, 0, [0] * 6)\n  freedrive_mode()",
            "RuntimeError: freedrive_mode(): force mode is on; end it first with end_force_mode()",
        ),
        (
            "freedrive_mode()\n  force_mode([0] * 6, [0] * 6, [0] * 6, 0, [0] * 6)",
            "RuntimeError: force_mode(): another motion (command 0) is still running; \
             only one motion at a time can move the arm",
        ),
        // Back in order: none of these is an error.
        (
            "freedrive_mode()\n  end_freedrive_mode()\n  force_mode([0] * 6, [0] * 6, [0] * 6, 0, [0] * 6)\
             \n  end_force_mode()\n  freedrive_mode()\n  end_freedrive_mode()",
            "",
        ),
        (
            "track_conveyor_linear([1, 0, 0, 0, 0, 0], 1000)\n  stop_conveyor_tracking()\
             \n  track_conveyor_linear([1, 0, 0, 0, 0, 0], 1000)",
            "",
        ),
    ] {
        let ran = run(
            &Standing::default(),
            &format!("def main():\n  {text}\nend\n"),
        );
        assert_eq!(ran.error, error, "{text}");
    }
}
