//! The builtins that bind scripts to the robot, one file a manual chapter, each declared as data (`declare`).
//!
//! Owns argument checking and what each function does. A builtin that waits sends a command and suspends its script
//! thread until the command has ended; getters read the latest snapshot and never wait.

mod call;
mod conveyor;
pub mod declare;
mod force;
mod hints;
mod interpreter;
mod io;
mod kinematics;
mod math;
mod micro_line;
mod modbus;
mod modbus_rtu;
mod motion;
mod path_offset;
mod pendant;
mod registers;
pub mod rpc;
mod serial;
mod servo;
mod socket;
mod state;
mod system;
mod text;
mod thread;

use std::rc::Rc;

use elite_lang::{NativeBody, NativeContext, NativeFunction, Param, ParamKind};
use supervision::injection;

pub use hints::{TOOL_LENGTH_MAX, known_names, known_names_for};

use crate::task::TaskContext;
use call::Call;
use declare::{Builtin, Category, ParameterDefault, ParameterType};

/// All builtins, by chapter.
pub fn all() -> impl Iterator<Item = &'static Builtin> {
    [
        motion::BUILTINS,
        micro_line::BUILTINS,
        servo::BUILTINS,
        state::BUILTINS,
        conveyor::BUILTINS,
        path_offset::BUILTINS,
        kinematics::BUILTINS,
        force::BUILTINS,
        math::BUILTINS,
        io::BUILTINS,
        registers::BUILTINS,
        modbus::BUILTINS,
        socket::BUILTINS,
        rpc::BUILTINS,
        serial::BUILTINS,
        modbus_rtu::BUILTINS,
        interpreter::BUILTINS,
        thread::BUILTINS,
        system::BUILTINS,
        text::BUILTINS,
        pendant::BUILTINS,
    ]
    .into_iter()
    .flatten()
}

/// The global names of all builtins.
pub fn names() -> impl Iterator<Item = &'static str> {
    // Some are listed with the module they are in.
    all().map(|builtin| builtin.name.split('.').next().unwrap_or_default())
}

/// What tasks keep of a script lies in tables that are emptied when the task ends.
impl NativeContext for TaskContext {}

/// The builtins as functions of one task.
pub(crate) fn natives(context: &Rc<TaskContext>) -> Vec<NativeFunction> {
    all()
        .filter_map(|builtin| {
            let run = builtin.run?;
            Some(NativeFunction {
                name: builtin.name,
                params: builtin.params.iter().map(param).collect(),
                call: NativeBody::with(Rc::clone(context), move |context, native| {
                    injection::point("builtin");
                    hints::warn_swapped_target(builtin, context, native);
                    let called = Call::new(builtin, context, native);
                    let result = called.and_then(|mut call| {
                        if needs_motion_sync(builtin, &call) {
                            call.wait_for_queued_motions(may_hurry(builtin))?;
                        }
                        match is_external_call(builtin) {
                            true => call.run_external(run),
                            false => run(&mut call),
                        }
                    });
                    if builtin.waits && builtin.category == Category::Motion {
                        native.on_motion_end(result.is_err());
                    }
                    result.map_err(|raised| hints::explain(builtin, native, raised))
                }),
            })
        })
        .collect()
}

/// Whether a call has to wait for the motions that the program has sent ahead: it reads or changes what they do, or
/// what the world is when they do it. Computing with given numbers does not, and further motions follow.
fn needs_motion_sync(builtin: &Builtin, call: &Call<'_, '_>) -> bool {
    match builtin.name {
        "movej" | "movel" | "movec" | "movep" => false,
        // Without joint positions they take those of the arm.
        "get_inverse_kin" | "get_inverse_kin_has_solution" => call.given(1).is_none(),
        "get_forward_kin" => call.given(0).is_none(),
        // What they show is seen when the arm enters the blend zone: see `Call::show_effect`.
        "textmsg" | "set_flag" => false,
        // What they change changes then, too: see `Call::change`.
        name if changes_points(builtin.category, name) => false,
        _ => !matches!(builtin.category, Category::Math | Category::Text),
    }
}

/// Whether a builtin changes outputs, output registers or how points are configured, and does nothing else.
fn changes_points(category: Category, name: &str) -> bool {
    match category {
        Category::Io => name.starts_with("set_"),
        Category::Register => name.starts_with("write_"),
        _ => false,
    }
}

/// Whether a call that has to wait for motions does so only until the next one is due, although the last may not have
/// come to its blend: it reads, writes or waits, and changes nothing about how the arm moves.
fn may_hurry(builtin: &Builtin) -> bool {
    match builtin.category {
        Category::Io
        | Category::Register
        | Category::Modbus
        | Category::Socket
        | Category::Rpc
        | Category::Serial
        | Category::ModbusRtu => true,
        _ => {
            let names = ["controller_timestamp", "sync", "sleep"];
            names.contains(&builtin.name)
                || ["get_", "is_"]
                    .iter()
                    .any(|begin| builtin.name.starts_with(begin))
        }
    }
}

/// Whether the answer comes from elsewhere: from machines, people, and whoever else writes what it reads.
fn is_external_call(builtin: &Builtin) -> bool {
    match builtin.category {
        // What a program writes there follows from itself.
        Category::Modbus => !builtin.name.starts_with("write_port_"),
        Category::Socket | Category::Serial | Category::ModbusRtu => true,
        Category::Register => builtin.name.starts_with("read_"),
        // Where tasks lie is up to the machine.
        _ => matches!(builtin.name, "popup" | "get_task_path"),
    }
}

fn param(parameter: &declare::Parameter) -> Param {
    Param {
        name: parameter.name,
        aliases: parameter.aliases,
        kind: match (parameter.kind, parameter.default) {
            (ParameterType::Variadic, _) => ParamKind::VarArgs,
            (_, ParameterDefault::Required) => ParamKind::Required,
            _ => ParamKind::Optional,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What the manual prints for chapters 2 and 9 and `sync` of chapter 1, blanks around `=` left out. `str_sub` is
    /// printed without the default that its text describes.
    const MANUAL: &[(&str, &str)] = &[
        ("1.2.5", "sync()"),
        (
            "2.3",
            "interpreter_mode(clearQueueOnEnter=True, clearOnEnd=True)",
        ),
        ("2.4", "end_interpreter()"),
        ("2.5", "clear_interpreter()"),
        ("9.1.1", "start_thread(function, args=(), detach_mode=True)"),
        ("9.1.2", "join_thread(thread_id)"),
        ("9.1.3", "stop_thread(thread_id)"),
        ("9.2.1", "pause()"),
        ("9.2.2", "halt()"),
        ("9.3.1", "textmsg(s1, s2='')"),
        (
            "9.3.2",
            "popup(s, title='Popup', warning=False, error=False, blocking=False)",
        ),
        ("9.4.1", "str_at(src, index)"),
        ("9.4.2", "str_cat(object1, object2)"),
        ("9.4.3", "str_empty(str)"),
        ("9.4.4", "str_find(src, target, start_from=0)"),
        ("9.4.5", "str_len(str)"),
        ("9.4.6", "str_sub(src, index, len=None)"),
        ("9.4.7", "to_num(str)"),
        ("9.4.8", "to_str(val)"),
        ("9.5.1", "sleep(t)"),
        ("9.5.2", "set_flag(n, b)"),
        ("9.5.3", "get_flag(n)"),
        ("9.5.4", "get_steptime()"),
        ("9.5.5", "controller_timestamp()"),
        ("9.5.6", "rtsi_set_watchdog(variable, frequency, action)"),
        ("9.5.7", "powerdown()"),
    ];

    #[test]
    fn every_function_of_chapters_2_and_9_is_there_as_the_manual_writes_it() {
        for (section, signature) in MANUAL {
            let name = signature.split('(').next().unwrap();
            let builtin = all()
                .find(|builtin| builtin.name == name)
                .unwrap_or_else(|| panic!("{name} is missing"));
            assert_eq!(builtin.section, *section, "{name}");
            assert_eq!(builtin.signature(), *signature);
        }
    }

    #[test]
    fn every_function_has_one_declaration() {
        let mut names: Vec<&str> = all().map(|builtin| builtin.name).collect();
        let count = names.len();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), count);
    }
}
