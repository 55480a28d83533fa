//! Functions of URScript and what stands for each of them in EliteScript, as a table.
//!
//! A row has the signature there, the call here, what the call gives, and a note for the report. A signature writes
//! `name:kind=default!`: kinds are `p` (a pose, also given as joint positions), `j` (joint positions, also given as a pose) and `t`
//! (a value that becomes text); a default with `!` differs from the one here, so it is written out. A call is one of
//!
//! - `=`: the same name and arguments,
//! - `=name`: another name, the same arguments,
//! - `name({a}, key={b}, 3)`: `{a}` is an argument or its default, `key={b}` stands only where it is given,
//! - `-`: nothing, a setting that this arm has no use for,
//! - `!`: no counterpart.

use super::kinds::{Kinds, Type};

/// A function of URScript.
#[derive(Clone, Copy, Debug)]
pub struct UrFunction {
    /// Signature there.
    pub signature: &'static str,
    /// Call here.
    pub call: &'static str,
    /// What it gives: `n`umber, `b`ool, te`x`t, `l`ist, `m`atrix, `p`ose, rpc `h`andle, or nothing.
    gives: &'static str,
    /// For the report.
    pub note: &'static str,
}

/// A parameter of a signature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// Its name there.
    pub name: &'static str,
    /// `p`, `j`, `t`, or empty.
    pub kind: &'static str,
    /// Its default there.
    pub default: Option<&'static str>,
    /// Whether the default is written out, because it is another one here.
    pub is_written: bool,
}

impl UrFunction {
    /// Its name there.
    pub fn name(&self) -> &'static str {
        self.signature.split('(').next().unwrap_or_default()
    }

    /// Its parameters there.
    pub fn parameters(&self) -> Vec<Parameter> {
        let list = self.signature.split_once('(').map_or("", |(_, list)| list);
        split_list(list.strip_suffix(')').unwrap_or(list))
            .into_iter()
            .map(|text| {
                let (head, default) = match text.split_once('=') {
                    Some((head, default)) => (head, Some(default)),
                    None => (text, None),
                };
                let (name, kind) = head.split_once(':').unwrap_or((head, ""));
                Parameter {
                    name,
                    kind,
                    default: default.map(|text| text.trim_end_matches('!')),
                    is_written: default.is_some_and(|text| text.ends_with('!')),
                }
            })
            .collect()
    }

    /// What its calls give.
    pub fn result(&self) -> Type {
        match self.gives {
            "n" => Type::of(Kinds::NUMBER),
            "b" => Type::of(Kinds::BOOL),
            "x" => Type::of(Kinds::TEXT),
            "p" => Type::of(Kinds::POSE),
            "h" => Type::of(Kinds::HANDLE),
            "l" => Type::list(Type::of(Kinds::NUMBER)),
            "m" => Type::list(Type::list(Type::of(Kinds::NUMBER))),
            _ => Type::default(),
        }
    }
}

/// The function of this name.
pub fn function(name: &str) -> Option<&'static UrFunction> {
    FUNCTIONS.iter().find(|row| row.name() == name)
}

/// Cuts at commas outside brackets.
pub(super) fn split_list(text: &str) -> Vec<&str> {
    let mut parts = Vec::new();
    let (mut depth, mut begin) = (0_usize, 0);
    for (at, byte) in text.bytes().enumerate() {
        match byte {
            b'(' | b'[' | b'{' => depth += 1,
            b')' | b']' | b'}' => depth = depth.saturating_sub(1),
            b',' if depth == 0 => {
                parts.push(text[begin..at].trim());
                begin = at + 1;
            }
            _ => {}
        }
    }
    parts.push(text[begin..].trim());
    parts.retain(|part| !part.is_empty());
    parts
}

const fn row(
    signature: &'static str,
    call: &'static str,
    gives: &'static str,
    note: &'static str,
) -> UrFunction {
    UrFunction {
        signature,
        call,
        gives,
        note,
    }
}

/// The table, by chapter of the manual of URScript.
pub const FUNCTIONS: &[UrFunction] = &[
    // motion
    row("movej(q:j, a=1.4!, v=1.05!, t=0, r=0)", "=", "", ""),
    row("movel(pose:p, a=1.2, v=0.25, t=0, r=0)", "=", "", ""),
    row("movep(pose:p, a=1.2, v=0.25, r=0)", "=", "", ""),
    row(
        "movec(pose_via:p, pose_to:p, a=1.2, v=0.25, r=0, mode=0)",
        "movec({pose_via}, {pose_to}, a={a}, v={v}, r={r}, mode=arc_mode({mode}))",
        "",
        "modes of orientation have the other numbers: 1 turns evenly, 0 keeps to the arc",
    ),
    row(
        "servoc(pose:p, a=1.2, v=0.25, r=0)",
        "movep({pose}, a={a}, v={v}, r={r})",
        "",
        "movep moves like it, at one speed through blends",
    ),
    row(
        "servoj(q:j, a=0, v=0, t=0.002, lookahead_time=0.1, gain=300)",
        "servoj({q}, t={t}, lookahead_time={lookahead_time}, gain={gain})",
        "",
        "a and v have no effect there either",
    ),
    row("speedj(qd, a=1.4!, t=0)", "=", "", ""),
    row("speedl(xd, a=1.2!, t=0, aRot=a)", "=", "", ""),
    row("stopj(a)", "=", "", ""),
    row(
        "stopl(a, aRot=a)",
        "stopl({a})",
        "",
        "the turning brakes together with the line",
    ),
    row(
        "optimovej(q:j, a=0.3, v=0.3, r=0)",
        "!",
        "",
        "speeds as shares of what the arm can do",
    ),
    row(
        "optimovel(pose:p, a=0.3, v=0.3, r=0)",
        "!",
        "",
        "speeds as shares of what the arm can do",
    ),
    row(
        "direct_torque(torque, friction_comp=True, viscous_scale=None, coulomb_scale=None)",
        "!",
        "",
        "the torques of the joints cannot be commanded",
    ),
    row(
        "freedrive_mode(freeAxes=[1,1,1,1,1,1], feature:p=p[0,0,0,0,0,0])",
        "freedrive_mode(freeAxes={freeAxes}, frame={feature})",
        "",
        "feature is called frame",
    ),
    row(
        "freedrive_mode_no_incorrect_payload_check()",
        "freedrive_mode()",
        "",
        "",
    ),
    row("end_freedrive_mode()", "=", "", ""),
    row("teach_mode()", "freedrive_mode()", "", ""),
    row("end_teach_mode()", "end_freedrive_mode()", "", ""),
    row(
        "get_freedrive_status()",
        "!",
        "n",
        "nothing tells how near a joint is to its limit",
    ),
    row(
        "force_mode(task_frame:p, selection_vector, wrench, type, limits)",
        "force_mode({task_frame}, {selection_vector}, {wrench}, force_type({type}), {limits})",
        "",
        "types have other numbers",
    ),
    row("end_force_mode()", "=", "", ""),
    row("force_mode_set_damping(damping)", "=", "", ""),
    row("force_mode_set_gain_scaling(scaling)", "=", "", ""),
    row("zero_ftsensor()", "=", "", ""),
    row(
        "ft_rtde_input_enable(enable, sensor_mass=0.0, sensor_measuring_offset=[0.0,0.0,0.0], sensor_cog=[0.0,0.0,0.0])",
        "=ft_rtsi_input_enable",
        "",
        "",
    ),
    row(
        "enable_external_ft_sensor(enable, sensor_mass=0.0, sensor_measuring_offset=[0.0,0.0,0.0], sensor_cog=[0.0,0.0,0.0])",
        "=ft_rtsi_input_enable",
        "",
        "",
    ),
    row(
        "screw_driving(f, v_limit)",
        "!",
        "",
        "follow the screw with force_mode",
    ),
    row("end_screw_driving()", "!", "", ""),
    row(
        "tool_contact(direction)",
        "!",
        "n",
        "compare get_tcp_force with a limit instead",
    ),
    row("tool_contact_examples()", "!", "", ""),
    row(
        "get_actual_joint_positions_history(steps=0)",
        "!",
        "l",
        "past positions are not kept for programs",
    ),
    row(
        "track_conveyor_linear(direction:p, ticks_per_meter, encoder_index=0)",
        "=",
        "",
        "",
    ),
    row(
        "track_conveyor_circular(center:p, ticks_per_revolution, rotate_tool=False, encoder_index=0)",
        "=",
        "",
        "",
    ),
    row(
        "stop_conveyor_tracking(a=20)",
        "stop_conveyor_tracking()",
        "",
        "the arm brakes by its own law",
    ),
    row(
        "conveyor_pulse_decode(type, A, B=0)",
        "encoder_enable_pulse_decode(0, {type}, 16, conveyor_input({type}))",
        "",
        "the fast inputs are 16 and 17",
    ),
    row(
        "encoder_enable_pulse_decode(encoder_index, decoder_type, A, B=0)",
        "encoder_enable_pulse_decode({encoder_index}, {decoder_type}, 16, conveyor_input({decoder_type}))",
        "",
        "the fast inputs are 16 and 17",
    ),
    row(
        "encoder_enable_set_tick_count(encoder_index, range_id)",
        "=",
        "",
        "",
    ),
    row("encoder_get_tick_count(encoder_index)", "=", "n", ""),
    row("encoder_set_tick_count(encoder_index, count)", "=", "", ""),
    row(
        "encoder_unwind_delta_tick_count(encoder_index, delta_tick_count)",
        "=",
        "n",
        "",
    ),
    row(
        "get_conveyor_tick_count()",
        "encoder_get_tick_count(0)",
        "n",
        "",
    ),
    row(
        "set_conveyor_tick_count(tick_count, absolute_encoder_resolution=0)",
        "encoder_set_tick_count(0, {tick_count})",
        "",
        "",
    ),
    row("tick_count_delta(tick_count)", "!", "n", ""),
    row("path_offset_enable()", "=", "", ""),
    row("path_offset_disable(a=20)", "=", "", ""),
    row("path_offset_get(type)", "=", "p", ""),
    row("path_offset_set(offset:p, type)", "=", "", ""),
    row("path_offset_set_alpha_filter(alpha)", "=", "", ""),
    row(
        "path_offset_set_max_offset(transLimit, rotLimit)",
        "path_offset_set_max_offset({transLimit}, {rotLimit})",
        "",
        "",
    ),
    row(
        "position_deviation_warning(enabled, threshold=0.8)",
        "-",
        "",
        "there is no such warning",
    ),
    row(
        "reset_revolution_counter(qNear=[0,0,0,0,0,0])",
        "!",
        "",
        "joints have no counter of turns to be set",
    ),
    row(
        "set_pos(q)",
        "!",
        "",
        "a simulated arm cannot be put somewhere",
    ),
    // the state of the arm
    row("get_actual_joint_positions()", "=", "l", ""),
    row("get_actual_joint_speeds()", "=", "l", ""),
    row(
        "get_joint_positions()",
        "=get_actual_joint_positions",
        "l",
        "",
    ),
    row("get_joint_speeds()", "=get_actual_joint_speeds", "l", ""),
    row("get_tcp_pose()", "=get_actual_tcp_pose", "p", ""),
    row("get_tcp_speed()", "=get_actual_tcp_speed", "l", ""),
    row("get_actual_tcp_pose()", "=", "p", ""),
    row("get_actual_tcp_speed()", "=", "l", ""),
    row("get_actual_tool_flange_pose()", "=", "p", ""),
    row("get_target_joint_positions()", "=", "l", ""),
    row("get_target_joint_speeds()", "=", "l", ""),
    row(
        "get_target_joint_accelerations()",
        "!",
        "l",
        "accelerations are not read",
    ),
    row("get_target_tcp_pose()", "=", "p", ""),
    row("get_target_tcp_speed()", "=", "l", ""),
    row("get_target_waypoint()", "=", "p", ""),
    row("get_joint_torques()", "=", "l", ""),
    row(
        "get_joint_temp(j)",
        "get_joint_temperatures()[{j}]",
        "n",
        "",
    ),
    row(
        "get_controller_temp()",
        "get_controller_temperature()",
        "n",
        "",
    ),
    row(
        "get_tcp_force()",
        "tcp_force_in_base()",
        "l",
        "in axes of the base, as there",
    ),
    row(
        "get_tcp_force_in_tcp_frame()",
        "get_tcp_force(True)",
        "l",
        "",
    ),
    row("force()", "=", "n", ""),
    row("get_tcp_offset()", "=", "p", ""),
    row("get_target_payload()", "get_target_payload_mass()", "n", ""),
    row("get_target_payload_cog()", "=", "l", ""),
    row(
        "get_target_payload_inertia()",
        "!",
        "l",
        "the inertia that was set is not read back",
    ),
    row(
        "get_tool_accelerometer_reading()",
        "!",
        "l",
        "the flange has no accelerometer",
    ),
    row(
        "get_tool_current()",
        "!",
        "n",
        "the current of the tool is not measured",
    ),
    row("is_steady()", "is_steady()", "b", ""),
    row(
        "is_within_safety_limits(pose:p, qnear=None)",
        "is_within_safety_limits({pose}, qNear={qnear})",
        "b",
        "",
    ),
    row(
        "get_forward_kin(q:j=[], tcp:p=p[0,0,0,0,0,0])",
        "=",
        "p",
        "",
    ),
    row(
        "get_inverse_kin(x:p, qnear=[], maxPositionError=1e-10, maxOrientationError=1e-10, tcp:p=p[0,0,0,0,0,0])",
        "get_inverse_kin({x}, qnear={qnear}, tcp={tcp})",
        "l",
        "",
    ),
    row(
        "get_inverse_kin_has_solution(pose:p, qnear=[], maxPositionError=1e-10, maxOrientationError=1e-10, tcp:p=p[0,0,0,0,0,0])",
        "get_inverse_kin_has_solution({pose}, qnear={qnear}, tcp={tcp})",
        "b",
        "",
    ),
    row("get_steptime()", "=", "n", ""),
    // settings
    row(
        "set_tcp(pose:p, tcp_name=\"\")",
        "set_tcp({pose})",
        "",
        "TCPs have no names",
    ),
    row("set_gravity(d)", "=", "", ""),
    row(
        "set_payload(m, cog=None, inertia=None)",
        "set_payload({m}, {cog|get_target_payload_cog()}, inertia={inertia})",
        "",
        "",
    ),
    row(
        "set_payload_mass(m)",
        "set_payload({m}, get_target_payload_cog())",
        "",
        "",
    ),
    row(
        "set_payload_cog(CoG, transition_time=0)",
        "set_payload(get_target_payload_mass(), {CoG})",
        "",
        "the change is at once",
    ),
    row(
        "set_target_payload(m, cog=None, inertia=None, transition_time=0)",
        "set_payload({m}, {cog|get_target_payload_cog()}, inertia={inertia})",
        "",
        "the change is at once",
    ),
    row("set_safety_mode_transition_hardness(type)", "=", "", ""),
    row("set_baselight_off()", "-", "", "there is no such light"),
    row(
        "set_watchdog(variable, frequency=10, action=\"pause\")",
        "rtsi_set_watchdog({variable}, {frequency}, {action})",
        "",
        "",
    ),
    row(
        "rtde_set_watchdog(variable_name, min_frequency, action=\"pause\")",
        "rtsi_set_watchdog({variable_name}, {min_frequency}, {action})",
        "",
        "",
    ),
    row("powerdown()", "=", "", ""),
    row(
        "protective_stop()",
        "!",
        "",
        "a program cannot raise a protective stop",
    ),
    row(
        "unlock_protective_stop()",
        "!",
        "",
        "it is unlocked from the page or the dashboard",
    ),
    // programs
    row("sleep(t)", "=", "", ""),
    row("sync()", "=", "", ""),
    row("textmsg(s1:t, s2:t=\"\")", "=", "", ""),
    row(
        "popup(s:t, title:t=\"Popup\", warning=False, error=False, blocking=False)",
        "=",
        "",
        "",
    ),
    row(
        "interpreter_mode(clearQueueOnEnter=True, clearOnEnd=True)",
        "=",
        "",
        "",
    ),
    row("end_interpreter()", "=", "", ""),
    row("clear_interpreter()", "=", "", ""),
    row("get_flag(n)", "=", "b", ""),
    row("set_flag(n, b)", "=", "", ""),
    row(
        "time(mode=0)",
        "!",
        "",
        "controller_timestamp() gives seconds",
    ),
    row(
        "request_boolean_from_primary_client(message)",
        "!",
        "b",
        "nobody is asked; popup shows a message",
    ),
    row(
        "request_float_from_primary_client(message)",
        "!",
        "n",
        "nobody is asked; popup shows a message",
    ),
    row(
        "request_integer_from_primary_client(message)",
        "!",
        "n",
        "nobody is asked; popup shows a message",
    ),
    row(
        "request_string_from_primary_client(message)",
        "!",
        "x",
        "nobody is asked; popup shows a message",
    ),
    // mathematics
    row("acos(f)", "=", "n", ""),
    row("asin(f)", "=", "n", ""),
    row("atan(f)", "=", "n", ""),
    row("atan2(x, y)", "=", "n", ""),
    row("cos(f)", "=", "n", ""),
    row("sin(f)", "=", "n", ""),
    row("tan(f)", "=", "n", ""),
    row("d2r(d)", "=", "n", ""),
    row("r2d(r)", "=", "n", ""),
    row("ceil(f)", "=", "n", ""),
    row("floor(f)", "=", "n", ""),
    row("log(b, f)", "=", "n", ""),
    row("sqrt(f)", "=", "n", ""),
    row("pow(base, exponent)", "=", "n", ""),
    row("norm(a)", "=", "n", ""),
    row("normalize(v)", "=", "l", ""),
    row("random()", "=", "n", ""),
    row("abs(f)", "=", "n", ""),
    row("length(v)", "=", "n", ""),
    row("get_list_length(v)", "=", "n", ""),
    row("size(v)", "size_of({v})", "", ""),
    row("transpose(m)", "transposed({m})", "m", ""),
    row(
        "make_list(length, initial_value=0, capacity=None)",
        "new_list({length}, {initial_value})",
        "l",
        "lists grow without a capacity",
    ),
    row("integer_to_binary_list(x)", "=", "l", ""),
    row("binary_list_to_integer(l)", "=", "n", ""),
    row("point_dist(p_from:p, p_to:p)", "=", "n", ""),
    row("pose_add(p_1:p, p_2:p)", "=", "p", ""),
    row(
        "pose_dist(p_from:p, p_to:p)",
        "turned_distance({p_from}, {p_to})",
        "n",
        "",
    ),
    row("pose_inv(p_from:p)", "=", "p", ""),
    row("pose_sub(p_to:p, p_from:p)", "=", "p", ""),
    row("pose_trans(p_from:p, p_from_to:p)", "=", "p", ""),
    row("interpolate_pose(p_from:p, p_to:p, alpha)", "=", "p", ""),
    row("rotvec2rpy(rotation_vector)", "=", "l", ""),
    row("rpy2rotvec(rpy_vector)", "=", "l", ""),
    row("wrench_trans(T_from_to:p, w_from)", "=", "l", ""),
    // texts
    row("str_at(src, index)", "=", "x", ""),
    row("str_cat(op1:t, op2:t)", "=", "x", ""),
    row("str_empty(str)", "=", "b", ""),
    row("str_find(src, target, start_from=0)", "=", "n", ""),
    row("str_len(str)", "=", "n", ""),
    row("str_sub(src, index, len=None)", "=", "x", ""),
    row("to_num(str)", "=", "n", ""),
    row("to_str(val:t)", "=", "x", ""),
    // inputs and outputs
    row("get_standard_digital_in(n)", "=", "b", ""),
    row("get_standard_digital_out(n)", "=", "b", ""),
    row("set_standard_digital_out(n, b)", "=", "", ""),
    row("get_configurable_digital_in(n)", "=", "b", ""),
    row("get_configurable_digital_out(n)", "=", "b", ""),
    row("set_configurable_digital_out(n, b)", "=", "", ""),
    row("get_digital_in(n)", "digital_in({n})", "b", ""),
    row("get_digital_out(n)", "digital_out({n})", "b", ""),
    row(
        "set_digital_out(n, b)",
        "switch_digital_out({n}, {b})",
        "",
        "",
    ),
    row(
        "get_tool_digital_in(n)",
        "tool_digital_in({n})",
        "b",
        "the pins of the tool are inputs or outputs",
    ),
    row(
        "get_tool_digital_out(n)",
        "get_tool_digital({n})",
        "b",
        "the pins of the tool are inputs or outputs",
    ),
    row(
        "set_tool_digital_out(n, b)",
        "switch_tool_digital_out({n}, {b})",
        "",
        "the pins of the tool are inputs or outputs",
    ),
    row("get_standard_analog_in(n)", "=", "n", ""),
    row("get_standard_analog_out(n)", "=", "n", ""),
    row("set_standard_analog_out(n, f)", "=", "", ""),
    row("get_analog_in(n)", "analog_in({n})", "n", ""),
    row("get_analog_out(n)", "get_standard_analog_out({n})", "n", ""),
    row(
        "set_analog_out(n, f)",
        "set_standard_analog_out({n}, {f})",
        "",
        "",
    ),
    row(
        "get_tool_analog_in(n)",
        "tool_analog_in({n})",
        "n",
        "the tool has one analog input",
    ),
    row(
        "set_standard_analog_input_domain(port, domain)",
        "=",
        "",
        "",
    ),
    row(
        "set_analog_inputrange(port, range)",
        "-",
        "",
        "a range of an older control box",
    ),
    row(
        "set_analog_outputdomain(port, domain)",
        "set_standard_analog_output_domain({port}, {domain})",
        "",
        "",
    ),
    row(
        "set_tool_analog_input_domain(port, domain)",
        "tool_input_domain({port}, {domain})",
        "",
        "the tool has one analog input",
    ),
    row("set_tool_voltage(voltage)", "=", "", ""),
    row(
        "set_tool_output_mode(mode)",
        "-",
        "",
        "pins of the tool are configured one by one",
    ),
    row(
        "set_tool_digital_output_mode(n, mode)",
        "configure_tool_pin({n}, {mode})",
        "",
        "",
    ),
    row("set_tool_digital_input_action(port, action)", "=", "", ""),
    row(
        "set_tool_communication(enabled, baud_rate, parity, stop_bits, rx_idle_chars=1.5, tx_idle_chars=3.5)",
        "tool_serial_config({enabled}, {baud_rate}, {parity}, {stop_bits})",
        "",
        "the pauses between bytes cannot be set",
    ),
    row("set_input_actions_to_default()", "=", "", ""),
    row(
        "set_standard_digital_input_action(port, action)",
        "=",
        "",
        "",
    ),
    row(
        "set_configurable_digital_input_action(port, action)",
        "=",
        "",
        "",
    ),
    row("set_gp_boolean_input_action(port, action)", "=", "", ""),
    row(
        "set_runstate_standard_digital_output_to_value(outputId, state)",
        "set_runstate_standard_digital_output_to_value({outputId}, {state})",
        "",
        "",
    ),
    row(
        "set_runstate_configurable_digital_output_to_value(outputId, state)",
        "set_runstate_configurable_digital_output_to_value({outputId}, {state})",
        "",
        "",
    ),
    row(
        "set_runstate_tool_digital_output_to_value(outputId, state)",
        "set_runstate_tool_digital_output_to_value({outputId}, {state})",
        "",
        "",
    ),
    row(
        "set_runstate_standard_analog_output_to_value(outputId, state)",
        "set_runstate_standard_analog_output_to_value({outputId}, {state})",
        "",
        "",
    ),
    row(
        "set_runstate_gp_boolean_output_to_value(outputId, state)",
        "set_runstate_gp_boolean_output_to_value({outputId}, {state})",
        "",
        "",
    ),
    row(
        "get_euromap_input(port_number)",
        "!",
        "b",
        "there is no Euromap 67 board",
    ),
    row(
        "get_euromap_output(port_number)",
        "!",
        "b",
        "there is no Euromap 67 board",
    ),
    row(
        "set_euromap_output(port_number, signal_value)",
        "!",
        "",
        "there is no Euromap 67 board",
    ),
    row(
        "set_euromap_runstate_dependent_choice(port_number, runstate_choice)",
        "!",
        "",
        "there is no Euromap 67 board",
    ),
    // registers
    row("read_input_boolean_register(address)", "=", "b", ""),
    row("read_input_float_register(address)", "=", "n", ""),
    row("read_input_integer_register(address)", "=", "n", ""),
    row("read_output_boolean_register(address)", "=", "b", ""),
    row("read_output_float_register(address)", "=", "n", ""),
    row("read_output_integer_register(address)", "=", "n", ""),
    row("write_output_boolean_register(address, value)", "=", "", ""),
    row("write_output_float_register(address, value)", "=", "", ""),
    row("write_output_integer_register(address, value)", "=", "", ""),
    row("read_port_bit(address)", "=", "b", ""),
    row("read_port_register(address)", "=", "n", ""),
    row("write_port_bit(address, value)", "=", "", ""),
    row("write_port_register(address, value)", "=", "", ""),
    // Modbus
    row(
        "modbus_add_signal(IP, slave_number, signal_address, signal_type, signal_name, sequential_mode=False, register_count=1)",
        "modbus_add_signal({IP}, {slave_number}, {signal_address}, {signal_type}, {signal_name}, is_sequential={sequential_mode}, registers_count={register_count})",
        "",
        "sequential_mode is called is_sequential",
    ),
    row(
        "modbus_add_rw_signal(IP, slave_number, read_address, read_register_count, write_address, write_register_count, signal_name, sequential_mode=False)",
        "modbus_add_rw_signal({IP}, {slave_number}, {read_address}, {read_register_count}, {write_address}, {write_register_count}, {signal_name}, is_sequential={sequential_mode})",
        "",
        "sequential_mode is called is_sequential",
    ),
    row("modbus_delete_signal(signal_name)", "=", "", ""),
    row(
        "modbus_get_signal_status(signal_name, is_secondary_program=False)",
        "=",
        "",
        "",
    ),
    row(
        "modbus_get_error(signal_name)",
        "modbus_error({signal_name})",
        "n",
        "one number: the error of the device or, without one, of the connection",
    ),
    row(
        "modbus_get_time_since_signal_invalid(signal_name)",
        "=",
        "n",
        "",
    ),
    row(
        "modbus_reset_connection(IP)",
        "modbus_reset_connection({IP})",
        "",
        "",
    ),
    row(
        "modbus_send_custom_command(IP, slave_number, function_code, data)",
        "=",
        "",
        "",
    ),
    row(
        "modbus_set_output_register(signal_name, register_value, is_secondary_program=False)",
        "modbus_set_output_register({signal_name}, {register_value})",
        "",
        "",
    ),
    row(
        "modbus_set_output_signal(signal_name, digital_value, is_secondary_program=False)",
        "modbus_set_output_signal({signal_name}, {digital_value})",
        "",
        "",
    ),
    row(
        "modbus_set_runstate_dependent_choice(signal_name, runstate_choice)",
        "=",
        "",
        "",
    ),
    row(
        "modbus_set_signal_update_frequency(signal_name, update_frequency)",
        "=",
        "",
        "",
    ),
    row(
        "modbus_set_signal_watchdog(signal_name, new_timeout_in_sec)",
        "modbus_set_signal_watchdog({signal_name}, {new_timeout_in_sec})",
        "",
        "",
    ),
    // sockets and remote calls
    row(
        "socket_open(address, port, socket_name=\"socket_0\")",
        "=",
        "b",
        "",
    ),
    row("socket_close(socket_name=\"socket_0\")", "=", "", ""),
    row(
        "socket_get_var(name, socket_name=\"socket_0\")",
        "socket_get_var({name}, socket_name={socket_name})",
        "n",
        "",
    ),
    row(
        "socket_set_var(name, value, socket_name=\"socket_0\")",
        "=",
        "",
        "",
    ),
    row(
        "socket_read_ascii_float(number, socket_name=\"socket_0\", timeout=2)",
        "=",
        "l",
        "",
    ),
    row(
        "socket_read_binary_integer(number, socket_name=\"socket_0\", timeout=2)",
        "=",
        "l",
        "",
    ),
    row(
        "socket_read_byte_list(number, socket_name=\"socket_0\", timeout=2)",
        "=",
        "l",
        "",
    ),
    row(
        "socket_read_line(socket_name=\"socket_0\", timeout=2)",
        "socket_read_string({socket_name}, \"\", \"\\n\", {timeout})",
        "x",
        "",
    ),
    row(
        "socket_read_string(socket_name=\"socket_0\", prefix=\"\", suffix=\"\", interpret_escape=False, timeout=2)",
        "socket_read_string({socket_name}, {prefix}, {suffix}, timeout={timeout})",
        "x",
        "",
    ),
    row(
        "socket_send_byte(value, socket_name=\"socket_0\")",
        "=",
        "b",
        "",
    ),
    row(
        "socket_send_byte_list(value, socket_name=\"socket_0\")",
        "=",
        "n",
        "",
    ),
    row(
        "socket_send_int(value, socket_name=\"socket_0\")",
        "=",
        "b",
        "",
    ),
    row(
        "socket_send_line(str:t, socket_name=\"socket_0\")",
        "socket_send_line({str}, socket_name={socket_name})",
        "b",
        "the second argument is the line end",
    ),
    row(
        "socket_send_string(str:t, socket_name=\"socket_0\")",
        "=",
        "b",
        "",
    ),
    row("rpc_factory(type, url)", "=", "h", ""),
];
