//! The builtins that bind scripts to the robot, one file a manual chapter, each declared as data (`declare`).
//!
//! Owns argument checking and what each function does. A builtin that waits sends a command and suspends its script
//! thread until the command has ended; getters read the latest snapshot and never wait.

mod call;
mod conveyor;
pub mod declare;
mod hints;
mod interpreter;
mod io;
mod kinematics;
mod math;
mod modbus;
mod modbus_rtu;
mod motion;
mod registers;
mod rpc;
mod serial;
mod servo;
mod socket;
mod state;
mod system;
mod text;
mod thread;

use std::rc::Rc;

use elite_lang::{NativeFunction, Param, ParamKind};

pub use hints::known_names;

use crate::task::TaskContext;
use call::Call;
use declare::{Builtin, Default, Kind};

/// All builtins, by chapter.
pub fn all() -> impl Iterator<Item = &'static Builtin> {
    [
        motion::BUILTINS,
        servo::BUILTINS,
        state::BUILTINS,
        conveyor::BUILTINS,
        kinematics::BUILTINS,
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
    ]
    .into_iter()
    .flatten()
}

/// The builtins as functions of one task.
pub(crate) fn natives(context: &Rc<TaskContext>) -> Vec<NativeFunction> {
    all()
        .filter_map(|builtin| {
            let run = builtin.run?;
            let context = Rc::clone(context);
            Some(NativeFunction {
                name: builtin.name,
                params: builtin.params.iter().map(param).collect(),
                call: Rc::new(move |native| run(&mut Call::new(builtin, &context, native)?)),
            })
        })
        .collect()
}

fn param(parameter: &declare::Parameter) -> Param {
    Param {
        name: parameter.name,
        aliases: parameter.aliases,
        kind: match (parameter.kind, parameter.default) {
            (Kind::Rest, _) => ParamKind::VarArgs,
            (_, Default::Required) => ParamKind::Required,
            _ => ParamKind::Optional,
        },
    }
}
