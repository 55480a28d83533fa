//! The memory account of a task does not drift: whatever a program calls again and again, it holds the same afterwards.

use crate::common;

use common::{Standing, run};
use elite_runtime::builtins::all;
use elite_runtime::builtins::declare::{Builtin, ParameterDefault, ParameterType, Range};

/// Looks at the account, and calls between two of them: what has died is forgotten every 512 objects, so looks are
/// compared that are at the same place between two such moments.
const LOOKS: usize = 32;
const CALLS: usize = 64;
/// What may be held more or less in the second half of the looks, bytes: about half a machine word a call.
const DRIFT_MAX: isize = 4000;

/// Builtins that are not called here, and why.
const LEFT_OUT: &[(&str, &str)] = &[
    ("halt", "ends the program"),
    ("powerdown", "ends the program"),
    ("interpreter_mode", "waits for a port"),
    ("serial_flush", "the line is not there"),
];

/// An argument that the parameter accepts.
fn argument(name: &str, kind: ParameterType) -> String {
    match kind {
        ParameterType::Joints | ParameterType::Pose | ParameterType::Numbers(6) => {
            "[0.1, -1.2, 1.3, -1.4, -1.5, 0.6]".into()
        }
        ParameterType::Numbers(count) => format!("[0.5] * {count}"),
        ParameterType::NumberList | ParameterType::NumberOrList | ParameterType::List => {
            "[1, 2, 3]".into()
        }
        ParameterType::Booleans(count) => format!("[True] * {}", count.unwrap_or(3)),
        ParameterType::ListOrText => "'1,2,3'".into(),
        ParameterType::Number(Range::Between(low, high)) => format!("{}", (low + high) / 2.0),
        ParameterType::Number(_) => "0.01".into(),
        ParameterType::Integer(low, _) => low.max(0).to_string(),
        ParameterType::OneOf(values) => values.first().map_or("0".into(), i64::to_string),
        ParameterType::Boolean => "False".into(),
        ParameterType::Word(words) => format!("{:?}", words.first().copied().unwrap_or_default()),
        ParameterType::Text if name.contains("address") || name == "ip" => "'127.0.0.1'".into(),
        ParameterType::Text | ParameterType::Printable => {
            "f'text {number} of some length for the heap'".into()
        }
        ParameterType::Frame => "'base'".into(),
        ParameterType::Function => "nothing".into(),
        ParameterType::Arguments => "()".into(),
        ParameterType::ThreadHandle => "0".into(),
        ParameterType::Custom(_) | ParameterType::Variadic => "1".into(),
    }
}

/// A call with required arguments only, and one with all of them.
fn calls(builtin: &Builtin) -> [String; 2] {
    let arguments = |all: bool| {
        let given = builtin.params.iter().filter(|param| {
            all && param.kind != ParameterType::Variadic
                || matches!(param.default, ParameterDefault::Required)
        });
        given
            .map(|param| argument(param.name, param.kind))
            .collect::<Vec<_>>()
            .join(", ")
    };
    [false, true].map(|all| format!("{}({})", builtin.name, arguments(all)))
}

/// How much more a task holds after many calls of `statement`, counted for half of them. What is looked at is the least
/// of each quarter: tables grow, and what has died is forgotten, in steps.
fn drift(statement: &str) -> Result<isize, String> {
    let once = drift_in(statement, LOOKS)?;
    if once.abs() <= DRIFT_MAX {
        return Ok(once);
    }
    // Where tables grow and shrink the looks differ; what drifts does so in proportion to the calls.
    let more = drift_in(statement, 4 * LOOKS)?;
    Ok(if more.abs() < 2 * once.abs() { 0 } else { more })
}

fn drift_in(statement: &str, looks: usize) -> Result<isize, String> {
    let text = format!(
        "def nothing():\n    pass\n\
         def again(count):\n    number = 0\n    while number < count:\n        number += 1\n        \
         try:\n            {statement}\n        except Exception:\n            pass\n\
         turn = 0\nwhile turn < {looks}:\n    turn += 1\n    again({CALLS})\n    print(turn)\n"
    );
    let ran = run(&Standing::default(), &text);
    if ran.held.len() != looks {
        return Err(format!("{:?}: {} {:?}", ran.end, ran.report, ran.log));
    }
    // What drifts does so in every quarter; a table that grows once does not.
    let least = |part: &[isize]| part.iter().copied().min().unwrap_or(0);
    let quarters: Vec<isize> = ran.held.chunks(looks / 4).map(least).collect();
    let changes: Vec<isize> = quarters.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let grows = changes.iter().all(|change| *change > 0);
    let shrinks = changes.iter().all(|change| *change < 0);
    let smallest = changes.iter().copied().min_by_key(|change| change.abs());
    Ok(if grows || shrinks {
        2 * smallest.unwrap_or(0)
    } else {
        0
    })
}

#[test]
fn what_drifts_is_found() {
    let kept = "nothing.seen = (getattr(nothing, 'seen', None), 'one more')";
    let found = drift(kept);
    assert!(matches!(found, Ok(bytes) if bytes > DRIFT_MAX), "{found:?}");
}

#[test]
fn no_builtin_of_the_robot_lets_the_account_drift() {
    let mut wrong = Vec::new();
    for builtin in all().filter(|builtin| builtin.run.is_some()) {
        if LEFT_OUT.iter().any(|(name, _)| *name == builtin.name) {
            continue;
        }
        let [short, long] = calls(builtin);
        let both = if short == long {
            vec![short]
        } else {
            vec![short, long]
        };
        for call in both {
            match drift(&call) {
                Ok(drift) if drift.abs() <= DRIFT_MAX => {}
                Ok(drift) => wrong.push(format!("{call}: {drift} bytes")),
                Err(why) => wrong.push(format!("{call}: {why}")),
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn no_way_out_of_the_language_lets_the_account_drift() {
    let mut wrong = Vec::new();
    for statement in [
        "pass",
        "global seen; seen = [number] * 50",
        "import time; time.sleep(0.001)",
        "import threading; t = threading.Thread(target=nothing); t.start(); t.join()",
        "import json; json.loads(json.dumps({'a': [number, 'text']}))",
        "import re; re.sub('a+', lambda found: found.group() * 2, 'banana' * 20)",
        "import struct; struct.unpack('<10d', struct.pack('<10d', *range(10)))",
        "import socket; s = socket.socket(); s.settimeout(0.001); s.connect(('127.0.0.1', 9))",
        "exec('x = 1\\ndef f(): return x\\nf()')",
        "getattr(nothing, f'name_{number}', None)",
        "setattr(nothing, 'name', f'value {number}')",
        "raise ValueError(f'a text {number} of some length for the heap')",
        "sorted([3, 1, 2], key=lambda x: -x)",
        "class A: me = number",
        "open('/does/not/exist')",
        "sum(x for x in range(10))",
        "start_thread(nothing, ()); sync()",
        "textmsg(f'number {number} in a text that is rather long for one')",
        "popup(f'number {number} in a text that is rather long for one', 'title')",
        "socket_open('127.0.0.1', 9, f's{number}', 0.01)",
        "modbus_add_signal('127.0.0.1', 1, 1, 1, f'signal{number % 3}', False); \
         modbus_delete_signal(f'signal{number % 3}')",
        "rpc_factory('xmlrpc', 'http://127.0.0.1:9/RPC2').call(number)",
        "write_output_float_register(0, number); read_output_float_register(0)",
        "set_standard_digital_out(0, number % 2 == 0); get_standard_digital_in(0)",
    ] {
        match drift(statement) {
            Ok(drift) if drift.abs() <= DRIFT_MAX => {}
            Ok(drift) => wrong.push(format!("{statement}: {drift} bytes")),
            Err(why) => wrong.push(format!("{statement}: {why}")),
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
