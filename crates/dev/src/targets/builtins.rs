//! The robot's builtins, called with whatever a program may hand them, on a whole controller with a simulated arm.
//!
//! Programs are made from the declarations of the builtins, so what is declared tomorrow is tried tomorrow. A promise
//! is broken when a fault of the controller is told, a position is not a number, an error has no text, a stop does not
//! end the program, or the next program does not run.

use std::path::PathBuf;
use std::time::Duration;

use controller::options::{ControllerOptions, PlantChoice};
use elite_runtime::builtins::all;
use elite_runtime::builtins::declare::{
    Builtin, ParameterDefault as Omitted, ParameterType, Range,
};
use elite_runtime::message::Message;
use elite_runtime::{ProgramText, TaskEnd};
use server::cli::{ControllerArgs, RunArgs};
use server::config::RunConfig;
use server::controller_host::ControllerHost;
use server::event_broadcast::PrintTarget;

use super::Target;
use crate::unstructured::Unstructured;

pub(super) const TARGETS: &[Target] = &[Target {
    name: "builtins",
    about: "calls of every builtin of the robot with fitting and hostile arguments, on a whole controller",
    check: judge,
    render_input: |data| program(data).into_bytes(),
    seeds: Vec::new,
    words: &[],
    bytes_max: 600,
}];

/// A program may go on so long before it is stopped: some wait for something that never comes.
const PATIENCE: Duration = Duration::from_millis(300);
/// A stop ends it within this, on a machine that has other work.
const STOP_MAX: Duration = Duration::from_secs(10);

/// What nobody expects as an argument.
const HOSTILE: &[&str] = &[
    "None",
    "-1",
    "0",
    "True",
    "1.5",
    "2**31",
    "2**63",
    "-2**63 - 1",
    "10**400",
    "1e308",
    "-1e308",
    "5e-324",
    "1e-9",
    "float('nan')",
    "float('inf')",
    "-float('inf')",
    "''",
    "'a'",
    "'x' * 100000",
    "'\\0'",
    "'\\x7f'",
    "'../../etc/passwd'",
    "b''",
    "b'\\xff' * 1000",
    "[]",
    "[1]",
    "[0] * 6",
    "[0] * 5 + [float('nan')]",
    "[1e300] * 6",
    "[5e-324] * 6",
    "[None] * 6",
    "['a'] * 6",
    "[[0] * 6]",
    "[[0.01 * i] * 6 for i in range(300)]",
    "[0] * 100000",
    "()",
    "{}",
    "{'a': 1}",
    "set()",
    "object()",
    "Odd()",
    "[Odd()] * 6",
    "odd",
    "lambda *a: 1",
    "iter([0] * 6)",
    "range(6)",
    "range(10**9)",
    "round_and_round",
    "1j",
    "Odd",
    "movej",
];

/// What programs begin with: an object whose every special method acts on the robot or fails, and where calls are made.
const BEGIN: &str = "
round_and_round = []
round_and_round.append(round_and_round)
turns = 0
def turn():
    global turns
    turns += 1
    if turns % 3 == 0: raise ValueError('turned')
    if turns % 3 == 1: sleep(0.01)
    return turns
class Odd:
    def __float__(self): return turn() * 0.1
    def __index__(self): return turn()
    def __int__(self): return turn()
    def __len__(self): return turn() % 7
    def __iter__(self): return iter([turn()] * 6)
    def __getitem__(self, key): return turn()
    def __str__(self): return str(turn())
    def __bool__(self): return turn() % 2 == 0
    def __eq__(self, other): return turn() % 2 == 0
    def __hash__(self): return turn()
    def __call__(self, *values): return turn()
odd = Odd()
def attempt(call):
    try: call()
    except RecursionError: pass
    except Exception as error:
        if not str(error).strip(): broken.append(type(error).__name__)
broken = []
";

fn program(data: &[u8]) -> String {
    let mut material = Unstructured::new(data);
    let builtins: Vec<&Builtin> = all().filter(|builtin| builtin.run.is_some()).collect();
    let mut text = String::from(BEGIN);
    for _ in 0..40 {
        if material.is_used_up() {
            break;
        }
        let builtin = builtins[material.below(builtins.len())];
        let call = call(builtin, &mut material);
        text.push_str(&match material.below(12) {
            11 => format!("start_thread(attempt, (lambda: {call},))\n"),
            10 => format!("attempt(lambda: {call}); sleep(0.05)\n"),
            _ => format!("attempt(lambda: {call})\n"),
        });
    }
    text.push_str("assert not broken, broken\n");
    text
}

fn call(builtin: &Builtin, material: &mut Unstructured<'_>) -> String {
    let mut given: Vec<String> = Vec::new();
    // Most calls have one argument that does not fit; some have none, some have many.
    let hostile = material.below(6);
    for param in builtin.params {
        let may_stay_away = !matches!(param.default, Omitted::Required);
        if (may_stay_away && material.one_in(3)) || material.one_in(40) {
            break;
        }
        let value = match material.below(6) < hostile {
            true => material.pick(HOSTILE).to_owned(),
            false => fitting(param.kind, material),
        };
        given.push(
            match material.one_in(8) || given.iter().any(|given| is_keyword(given)) {
                true => format!("{}={value}", param.name),
                false => value,
            },
        );
    }
    if material.one_in(30) && !given.iter().any(|given| is_keyword(given)) {
        given.push(material.pick(HOSTILE).to_owned());
    }
    format!("{}({})", builtin.name, given.join(", "))
}

fn is_keyword(argument: &str) -> bool {
    argument
        .split_once('=')
        .is_some_and(|(name, _)| name.chars().all(|c| c.is_alphanumeric() || c == '_'))
}

/// An argument that the parameter accepts.
fn fitting(kind: ParameterType, material: &mut Unstructured<'_>) -> String {
    let small = f64::from(material.byte()) / 256.0;
    match kind {
        ParameterType::Joints => format!("[{small}, -1.3, 1.4, -1.6, -1.5, {small}]"),
        ParameterType::Pose => format!("[-0.4, -0.2, 0.3 + {small} / 5, 3.1, 0.1, {small}]"),
        ParameterType::Numbers(count) => format!("[{small}] * {count}"),
        ParameterType::NumberList | ParameterType::NumberOrList | ParameterType::List => {
            format!("[1, 2, {small}]")
        }
        ParameterType::Booleans(count) => format!(
            "[{}] * {}",
            ["True", "False"][material.below(2)],
            count.unwrap_or(3)
        ),
        ParameterType::ListOrText => "'1,2,3'".to_owned(),
        ParameterType::Number(Range::Between(low, high)) => {
            (low + (high - low) * small).to_string()
        }
        ParameterType::Number(_) => (small + 0.001).to_string(),
        ParameterType::Integer(low, high) => [
            low,
            high,
            low.saturating_add(1).min(high),
            0.clamp(low, high),
        ][material.below(4)]
        .to_string(),
        ParameterType::OneOf(values) => values
            .get(material.below(values.len()))
            .copied()
            .unwrap_or(0)
            .to_string(),
        ParameterType::Boolean => ["True", "False"][material.below(2)].to_owned(),
        ParameterType::Word(words) => format!(
            "{:?}",
            words
                .get(material.below(words.len()))
                .copied()
                .unwrap_or_default()
        ),
        ParameterType::Text | ParameterType::Printable => material
            .pick(&[
                "'127.0.0.1'",
                "'name'",
                "'1,2,3'",
                "'位置'",
                "'<a href=\"\">'",
            ])
            .to_owned(),
        ParameterType::Frame => material
            .pick(&["'base'", "'tool'", "[0, 0, 0, 0, 0, 0.5]"])
            .to_owned(),
        ParameterType::Function => material.pick(&["turn", "odd", "lambda: None"]).to_owned(),
        ParameterType::Arguments => "()".to_owned(),
        ParameterType::ThreadHandle => ["0", "1", "99"][material.below(3)].to_owned(),
        ParameterType::Custom(_) | ParameterType::Variadic => material.pick(HOSTILE).to_owned(),
    }
}

#[allow(
    clippy::expect_used,
    reason = "a judge tells what it finds by panicking"
)]
fn judge(data: &[u8]) {
    let shared = ControllerArgs {
        options: ControllerOptions {
            plant: Some(PlantChoice::Ideal),
            ..ControllerOptions::default()
        },
        ..ControllerArgs::default()
    };
    let file = PathBuf::from("case.script");
    let config = RunConfig::load(RunArgs {
        file,
        shared,
        set: Vec::new(),
    })
    .expect("the defaults are right");
    let host = ControllerHost::start(
        &config.robot,
        None,
        PrintTarget::Log,
        false,
        editor::dap::DebugHub::default(),
    )
    .expect("it starts");
    let controller = host.controller();
    let mut messages = host.announcer().subscribe();
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .expect("a runtime");
    runtime.block_on(async {
        let text = String::from_utf8_lossy(data).into_owned();
        let supervisor = controller.supervisor();
        let program = ProgramText {
            name: "case.script".to_owned(),
            text,
        };
        supervisor
            .submit(program, "the campaign")
            .await
            .expect("nothing else runs");
        let end = match tokio::time::timeout(PATIENCE, supervisor.ended()).await {
            Ok(end) => end,
            Err(_) => {
                supervisor.stop();
                let stopped = tokio::time::timeout(STOP_MAX, supervisor.ended());
                stopped.await.expect("a stop ends the program")
            }
        };
        while let Ok(message) = messages.try_recv() {
            if let Message::ScriptError { summary, .. } = message {
                let ours = ["InternalError", "AssertionError", "SystemError"];
                assert!(
                    !ours.iter().any(|name| summary.english().starts_with(name)),
                    "{summary}"
                );
            }
        }
        assert_ne!(
            end,
            Some(TaskEnd::NotCompiled),
            "a call that does not compile"
        );
    });
    for (kind, count) in controller.faults().counts() {
        assert_eq!(
            count,
            0,
            "a fault of {kind:?}: {:?}",
            controller.faults().fatal()
        );
    }
    let state = controller.robot().state();
    assert!(
        state.actual_q.iter().all(|q| q.is_finite()),
        "{:?}",
        state.actual_q
    );
    host.shut_down();
}
