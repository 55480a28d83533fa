//! Manual 9.3 to 9.5 and 1.2: messages and time.

use elite_lang::{Raised, Value};
use motion_api::Seconds;

use super::call::Call;
use super::declare::{Builtin, Category, Default, Kind, Parameter, Range};
use crate::message::{Message, Severity};
use crate::task::Wait;

/// The builtins of this chapter.
pub const BUILTINS: &[Builtin] = &[
    Builtin {
        name: "print",
        section: "1.2.2",
        category: Category::Other,
        summary: "Writes the values, joined by one blank, to the log; to standard output under `run`.",
        params: &[Parameter {
            name: "values",
            aliases: &[],
            kind: Kind::Rest,
            default: Default::EmptyTuple,
            unit: "",
            meaning: "what to write; Python's keywords sep and end work too",
        }],
        returns: "nothing",
        waits: false,
        run: None,
    },
    Builtin {
        name: "sync",
        section: "1.2.5",
        category: Category::System,
        summary: "Gives up the rest of the control cycle and goes on in the next one.",
        params: &[],
        returns: "nothing",
        waits: true,
        run: Some(sync),
    },
    Builtin {
        name: "textmsg",
        section: "9.3.1",
        category: Category::System,
        summary: "Writes both parts, joined, to the log.",
        params: &[
            Parameter {
                name: "s1",
                aliases: &[],
                kind: Kind::Printable,
                default: Default::Required,
                unit: "",
                meaning: "first part",
            },
            Parameter {
                name: "s2",
                aliases: &[],
                kind: Kind::Printable,
                default: Default::EmptyText,
                unit: "",
                meaning: "second part",
            },
        ],
        returns: "nothing",
        waits: false,
        run: Some(textmsg),
    },
    Builtin {
        name: "sleep",
        section: "9.5.1",
        category: Category::System,
        summary: "Waits.",
        params: &[Parameter {
            name: "t",
            aliases: &[],
            kind: Kind::Number(Range::Any),
            default: Default::Required,
            unit: "s",
            meaning: "how long; 0 or less returns at once",
        }],
        returns: "nothing",
        waits: true,
        run: Some(sleep),
    },
    Builtin {
        name: "get_steptime",
        section: "9.5.4",
        category: Category::System,
        summary: "Length of one control cycle.",
        params: &[],
        returns: "float, s",
        waits: false,
        run: Some(get_steptime),
    },
];

fn sync(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let cycle = call.context().robot().state().cycle;
    call.wait(Wait::Cycle(cycle + 1))?;
    Ok(Value::None)
}

fn sleep(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let Some(time) = Seconds::new(call.number(0)?) else {
        return Ok(Value::None);
    };
    let state = call.context().robot().state();
    let step = Seconds::new(state.step_time).unwrap_or_default();
    let cycles = time.cycles(step);
    if cycles > 0 {
        call.wait(Wait::Cycle(state.cycle.saturating_add(cycles)))?;
    }
    Ok(Value::None)
}

fn get_steptime(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    Ok(Value::Float(call.context().robot().state().step_time))
}

fn textmsg(call: &mut Call<'_, '_>) -> Result<Value, Raised> {
    let mut text = String::new();
    for index in 0..2 {
        if let Some(value) = call.given(index).cloned() {
            text.push_str(&call.native().str(&value)?);
        }
    }
    let origin = call.origin();
    call.context()
        .observer()
        .message(&Message::log(Severity::Info, origin, text));
    Ok(Value::None)
}
