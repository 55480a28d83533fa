//! The object `test` as a test sees it: its functions, their arguments, what they answer.
//!
//! Functions that wait let the program beside the test run on, cycle by cycle where the test has something to do in
//! each.

use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::Arc;

use controller::ProgramResult;
use controller::cell::point::IoPointName;
use controller::io_values::{PointChange, PointReading, PointValue};
use elite_lang::{
    ExceptionKind, NativeBody, NativeCall, NativeContext, NativeFunction, Param, Unwind, Value,
};
use elite_runtime::{ProgramText, TestTaskHandle};
use io_bus::SimulatedPeers;
use messages::{Text, text};
use motion_api::{CommandKind, MachineCommand, RobotMode, SafetyMode, Seconds, SensingCommand};
use recorder::{CycleMessage, FieldValue};

use crate::expect;
use crate::simulated_servers::{self, SimulatedServer};
use crate::test_context::{StartError, TestAction, TestContext};
use crate::world_functions;

type NativeResult<T = Value> = Result<T, Unwind>;
type TestFunction = fn(&CallContext, &mut NativeCall<'_>) -> NativeResult;

/// The surroundings of a call of a function of `test`.
pub(crate) struct CallContext {
    pub bench: Arc<TestContext>,
    pub attendance: TestTaskHandle,
    /// The servers that the test plays, by number.
    pub served: RefCell<Vec<SimulatedServer>>,
}

/// Longest time that is waited for or ahead, s: some thirty years.
const TIME_MAX: f64 = 1e9;
/// How long a program that was stopped may take to end, simulated s.
const ENDING_MAX: f64 = 30.0;
/// How long the arm may take to be ready again, simulated s.
const READY_MAX: f64 = 10.0;
/// Largest program, bytes.
const PROGRAM_BYTES_MAX: u64 = 8 << 20;

/// Name, parameters (`?` after those that may be left out) and body of every function.
const FUNCTIONS: &[(&str, &[&str], TestFunction)] = &[
    ("run", &["program", "timeout?"], run),
    ("start", &["program"], start),
    ("wait", &["timeout?"], wait),
    ("stop", &[], stop),
    ("result", &[], result),
    ("messages", &[], messages),
    ("until", &["function", "timeout?"], until),
    ("advance", &["seconds"], advance),
    ("set", &["name", "value", "after?"], set),
    ("get", &["name"], get),
    ("wrench", &["w", "duration", "frame?", "after?"], wrench),
    ("safety", &["state"], safety),
    (
        "socket_server",
        &["port?", "answers?"],
        simulated_servers::socket_server,
    ),
    (
        "rpc_server",
        &["port?", "functions?"],
        simulated_servers::rpc_server,
    ),
    (
        "modbus_device",
        &["port?", "registers?", "coils?"],
        simulated_servers::modbus_device,
    ),
    ("near", &["a", "b", "tolerance?"], expect::is_near),
    ("raises", &["type_name", "function"], expect::raises),
    (
        "path_near",
        &["golden_csv", "tolerance?"],
        expect::path_near,
    ),
    ("never", &["condition"], expect::never),
    ("always", &["condition"], expect::always),
    ("peak", &["name"], expect::peak),
    ("part", &["name"], world_functions::part),
    ("parts", &[], world_functions::parts),
    ("gripper", &["name"], world_functions::gripper),
    ("count", &["sink"], world_functions::count),
    ("place", &["name", "pose"], world_functions::place),
    ("remove", &["name"], world_functions::remove),
    ("add", &["template", "pose"], world_functions::add),
    (
        "fault",
        &["what", "name", "duration?"],
        world_functions::fault,
    ),
    ("clearance", &[], expect::clearance),
];

/// The names of all functions, for `check`.
pub fn function_names() -> impl Iterator<Item = &'static str> {
    FUNCTIONS.iter().map(|(name, _, _)| *name)
}

/// Every function with its parameters, `?` after those that may be left out, for editors.
pub fn function_parameters() -> impl Iterator<Item = (&'static str, &'static [&'static str])> {
    FUNCTIONS
        .iter()
        .map(|(name, parameters, _)| (*name, *parameters))
}

/// What it holds of the script are the functions that answer for machines; the circle ends with the task.
impl NativeContext for CallContext {}

/// The functions for one test.
pub(crate) fn functions(
    bench: &Arc<TestContext>,
    attendance: &TestTaskHandle,
) -> Vec<NativeFunction> {
    let site = Rc::new(CallContext {
        bench: bench.clone(),
        attendance: attendance.clone(),
        served: RefCell::default(),
    });
    // The task keeps this as long as it keeps the site.
    let own = Rc::downgrade(&site);
    attendance.set_wait_hook(Rc::new(move |call| {
        let Some(site) = own.upgrade().filter(|site| site.bench.peers.needs_test()) else {
            return Ok(false);
        };
        simulated_servers::answer(&site, call)?;
        Ok(true)
    }));
    let functions = FUNCTIONS.iter().map(|(name, parameters, body)| {
        let parameter = |text: &&'static str| match text.strip_suffix('?') {
            Some(name) => Param::optional(name),
            None => Param::required(text),
        };
        let body = *body;
        NativeFunction {
            name,
            params: parameters.iter().map(parameter).collect(),
            call: NativeBody::with(site.clone(), move |site, call| body(site, call)),
        }
    });
    functions.collect()
}

/// An exception with a text of ours. Programs see the English form.
pub(crate) fn raise(call: &NativeCall<'_>, kind: ExceptionKind, text: &Text) -> Unwind {
    call.raise(kind, text.clone())
}

pub(crate) fn argument_error(call: &NativeCall<'_>, text: &Text) -> Unwind {
    raise(call, ExceptionKind::ValueError, text)
}

/// A finite number within bounds; `default` where it is left out.
pub(crate) fn number(
    call: &NativeCall<'_>,
    index: usize,
    name: &str,
    (least, most): (f64, f64),
    default: Option<f64>,
) -> NativeResult<f64> {
    let given = match (call.arg(index), default) {
        (None, Some(default)) => return Ok(default),
        (given, _) => given.cloned().unwrap_or_default(),
    };
    let number = given.as_f64().filter(|_| !matches!(given, Value::Bool(_)));
    match number.filter(|x| (least..=most).contains(x)) {
        Some(number) => Ok(number),
        None => {
            let shown = call.repr(&given)?;
            Err(argument_error(
                call,
                &text!(
                    "{name} is {shown}; allowed are numbers from {least} to {most}",
                    "{name} 为 {shown}；允许 {least} 到 {most} 的数"
                ),
            ))
        }
    }
}

fn seconds(
    call: &NativeCall<'_>,
    index: usize,
    name: &str,
    default: Option<f64>,
) -> NativeResult<Seconds> {
    let time = number(call, index, name, (0.0, TIME_MAX), default)?;
    // Within its bounds it is finite and not negative.
    Ok(Seconds::new(time).unwrap_or_default())
}

pub(crate) fn text(call: &NativeCall<'_>, index: usize, name: &str) -> NativeResult<String> {
    let given = call.arg(index).cloned().unwrap_or_default();
    match given.as_str() {
        Some(text) => Ok(text.to_owned()),
        None => {
            let text = text!(
                "{name} must be a text, not {}",
                "{name} 应为字符串，不能是 {}",
                given.type_name()
            );
            Err(raise(call, ExceptionKind::TypeError, &text))
        }
    }
}

pub(crate) fn failed(call: &NativeCall<'_>, text: &Text) -> Unwind {
    raise(call, ExceptionKind::AssertionError, text)
}

/// The program that `run` and `start` are given: a file that is there, or the text itself.
fn program(site: &CallContext, call: &NativeCall<'_>) -> NativeResult<ProgramText> {
    let given = text(call, 0, "program")?;
    let looks_like_a_file = !given.contains(['\n', ';', '(', '='])
        && (given.ends_with(".script") || given.ends_with(".task") || given.ends_with(".py"));
    if !looks_like_a_file {
        return Ok(ProgramText {
            name: "program".to_owned(),
            text: given,
        });
    }
    let path = site.bench.folder.join(&given);
    let read = site.bench.files.text(&path, PROGRAM_BYTES_MAX);
    match read.map_err(|why| match why {
        Ok(bytes) => text!(
            "it has {bytes} bytes, at most {PROGRAM_BYTES_MAX} are read",
            "有 {bytes} 字节，最多读取 {PROGRAM_BYTES_MAX} 字节"
        ),
        Err(error) => Text::of(&error),
    }) {
        Ok(text) => Ok(ProgramText {
            name: normalized_path(&path).display().to_string(),
            text,
        }),
        Err(why) => {
            let text = text!(
                "cannot read the program {}: {why}",
                "无法读取程序 {}：{why}",
                path.display()
            );
            Err(raise(call, ExceptionKind::FileNotFoundError, &text))
        }
    }
}

/// The path without `.` in it.
pub(crate) fn normalized_path(path: &Path) -> PathBuf {
    path.components()
        .filter(|part| !matches!(part, std::path::Component::CurDir))
        .collect()
}

fn begin(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult<()> {
    let program = program(site, call)?;
    let Err(error) = site.bench.start(program) else {
        return Ok(());
    };
    let kind = match error {
        StartError::NotCompiled { .. } => {
            // A test that goes on may start another program at once.
            let patience = Seconds::new(ENDING_MAX).unwrap_or_default();
            wait_for_end(site, call, patience)?;
            site.bench.close(None);
            ExceptionKind::SyntaxError
        }
        StartError::Refused(_) => ExceptionKind::RuntimeError,
    };
    Err(raise(call, kind, &Text::of(&error)))
}

fn start(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    begin(site, call)?;
    Ok(Value::None)
}

fn run(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let timeout = seconds(call, 1, "timeout", Some(60.0))?;
    begin(site, call)?;
    let result = match wait_for_end(site, call, timeout)? {
        true => site.bench.close(None),
        false => {
            let text = text!(
                "TimeoutError: the program had not ended after {} s",
                "TimeoutError: 程序在 {} s 后没有结束",
                timeout.get()
            );
            end(site, call, Some(text))?
        }
    };
    shown_result(call, result)
}

/// Waits until no program runs, for at most so long.
fn wait_for_end(
    site: &CallContext,
    call: &mut NativeCall<'_>,
    timeout: Seconds,
) -> NativeResult<bool> {
    let bench = &site.bench;
    let deadline = bench.cycle_after(timeout);
    while bench.program_is_running() && bench.turns.cycles() < deadline {
        advance_test(site, call, deadline)?;
    }
    // What came last is noted down before anybody looks.
    bench.peers.serve();
    simulated_servers::answer(site, call)?;
    Ok(!bench.program_is_running())
}

/// Lets time pass until `cycle`, or for a cycle where the test has something to do in each.
fn advance_test(site: &CallContext, call: &mut NativeCall<'_>, cycle: u64) -> NativeResult<()> {
    simulated_servers::answer(site, call)?;
    if let Some(refused) = site.bench.refused() {
        return Err(raise(call, ExceptionKind::RuntimeError, refused));
    }
    match site.bench.peers.needs_test() {
        true => {
            let next = site.bench.turns.cycles() + 1;
            site.attendance.wait_until_cycle(call, next)
        }
        false => site.attendance.wait_until_cycle_or_program_end(call, cycle),
    }
}

/// Ends the program that runs.
fn end(
    site: &CallContext,
    call: &mut NativeCall<'_>,
    given_up: Option<Text>,
) -> NativeResult<Option<ProgramResult>> {
    site.bench.programs.stop();
    let patience = Seconds::new(ENDING_MAX).unwrap_or_default();
    if !wait_for_end(site, call, patience)? {
        let text = text!(
            "the program was stopped and had not ended after {ENDING_MAX} s",
            "程序被停止，{ENDING_MAX} s 后仍未结束"
        );
        return Err(raise(call, ExceptionKind::RuntimeError, &text));
    }
    Ok(site.bench.close(given_up))
}

fn wait(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let timeout = seconds(call, 0, "timeout", Some(60.0))?;
    let ended = wait_for_end(site, call, timeout)?;
    if ended {
        site.bench.close(None);
    }
    Ok(Value::Bool(ended))
}

fn stop(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let result = match site.bench.program_is_running() {
        true => end(site, call, None)?,
        false => site.bench.close(None),
    };
    shown_result(call, result)
}

fn result(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let result = match site.bench.program_is_running() {
        true => None,
        false => site.bench.close(None),
    };
    shown_result(call, result)
}

fn messages(site: &CallContext, _: &mut NativeCall<'_>) -> NativeResult {
    let texts = site.bench.said.messages();
    let texts = texts.iter().map(|text| Value::str(text.as_str()));
    Ok(Value::list(texts.collect()))
}

/// The object that tells how a program ended; None when there is nothing to tell.
fn shown_result(call: &NativeCall<'_>, result: Option<ProgramResult>) -> NativeResult {
    let Some(result) = result else {
        return Ok(Value::None);
    };
    let prints = result.prints.iter().map(|line| Value::str(line.as_str()));
    let error = result
        .error
        .as_ref()
        .map_or(Value::None, |error| Value::str(error.english()));
    let line = result
        .line
        .map_or(Value::None, |line| Value::Int(line.into()));
    Ok(call.object(
        "result",
        Vec::new(),
        vec![
            ("outcome", Value::str(result.outcome.as_str())),
            ("error", error),
            ("line", line),
            ("time", Value::Float(result.time)),
            ("prints", Value::list(prints.collect())),
        ],
    ))
}

fn until(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let function = call.arg(0).cloned().unwrap_or_default();
    if !function.is_callable() {
        let text = text!(
            "function must be callable, not {}",
            "function 必须可调用，不能是 {}",
            function.type_name()
        );
        return Err(raise(call, ExceptionKind::TypeError, &text));
    }
    let timeout = seconds(call, 1, "timeout", Some(60.0))?;
    let deadline = site.bench.cycle_after(timeout);
    loop {
        let holds = call.call_value(&function, &[])?;
        if call.truth(&holds)? {
            return Ok(Value::Bool(true));
        }
        let now = site.bench.turns.cycles();
        if now >= deadline {
            return Ok(Value::Bool(false));
        }
        simulated_servers::answer(site, call)?;
        site.attendance.wait_until_cycle(call, now + 1)?;
    }
}

fn advance(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let time = seconds(call, 0, "seconds", None)?;
    let until = site.bench.cycle_after(time);
    while site.bench.turns.cycles() < until {
        simulated_servers::answer(site, call)?;
        let next = match site.bench.peers.needs_test() {
            true => site.bench.turns.cycles() + 1,
            false => until,
        };
        site.attendance.wait_until_cycle(call, next)?;
    }
    simulated_servers::answer(site, call)?;
    Ok(Value::None)
}

/// Does something now, or after a while.
fn act(site: &CallContext, call: &NativeCall<'_>, after: Seconds, act: TestAction) -> NativeResult {
    let done = match after.get() {
        0.0 => site.bench.act(act),
        _ => site.bench.schedule(site.bench.cycle_after(after), act),
    };
    match done {
        Ok(()) => Ok(Value::None),
        Err(sentence) => Err(raise(call, ExceptionKind::RuntimeError, &sentence)),
    }
}

fn set(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let name = text(call, 0, "name")?;
    let given = call.arg(1).cloned().unwrap_or_default();
    let value = match given {
        Value::Bool(level) => PointValue::Level(level),
        Value::Int(whole) => PointValue::Whole(whole),
        Value::Float(number) => PointValue::Number(number),
        _ => PointValue::Other(call.repr(&given)?),
    };
    let after = seconds(call, 2, "after", Some(0.0))?;
    let config = site.bench.robot.state().io_config;
    let change = PointChange::of_input(&name, &value, &config);
    let change = change.map_err(|error| argument_error(call, &Text::of(&error)))?;
    act(site, call, after, TestAction::Set(change))
}

fn get(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let name = text(call, 0, "name")?;
    let robot = &site.bench.robot;
    let point: IoPointName = match name.parse() {
        Ok(point) => point,
        Err(sentence) => {
            let cycle = CycleMessage::from(&robot.state());
            let fields = cycle.fields();
            let field = fields.iter().find(|(field, _)| *field == name);
            return match field.map(|(_, value)| *value) {
                Some(FieldValue::Unsigned(x)) => {
                    Ok(Value::Int(i64::try_from(x).unwrap_or(i64::MAX)))
                }
                Some(FieldValue::Number(x)) => Ok(Value::Float(x)),
                Some(FieldValue::Numbers(values)) => Ok(Value::list_of_f64(values)),
                Some(FieldValue::Text(text)) => Ok(Value::str(text)),
                None => Err(argument_error(
                    call,
                    &text!(
                        "{sentence}; columns of replay --csv /cycle can be read as well",
                        "{sentence}；也可以读取 replay --csv /cycle 的列"
                    ),
                )),
            };
        }
    };
    Ok(
        match PointReading::new(point, &robot.io(), robot.registers()) {
            PointReading::Level(level) => Value::Bool(level),
            PointReading::Whole(value) => Value::Int(value.into()),
            PointReading::Number(value) => Value::Float(value),
        },
    )
}

fn wrench(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let given = call.arg(0).cloned().unwrap_or_default();
    let numbers = given.as_items().and_then(|items| {
        let numbers = items
            .iter()
            .map(Value::as_f64)
            .collect::<Option<Vec<f64>>>()?;
        <[f64; 6]>::try_from(numbers).ok()
    });
    let Some(wrench) = numbers else {
        let shown = call.repr(&given)?;
        let text = text!(
            "w is {shown}; six numbers are needed: force in N, moment in Nm",
            "w 为 {shown}；需要六个数：力（N）、力矩（Nm）"
        );
        return Err(argument_error(call, &text));
    };
    let duration = seconds(call, 1, "duration", None)?;
    let in_tool_axes = match call.arg(2) {
        None => false,
        Some(_) => match text(call, 2, "frame")?.as_str() {
            "base" => false,
            "tool" => true,
            other => {
                let text = text!(
                    "frame is {other:?}; allowed are \"base\" and \"tool\"",
                    "frame 为 {other:?}；允许 \"base\" 和 \"tool\""
                );
                return Err(argument_error(call, &text));
            }
        },
    };
    let after = seconds(call, 3, "after", Some(0.0))?;
    let push = CommandKind::Sensing(SensingCommand::Push {
        wrench,
        in_tool_axes,
        duration: duration.get(),
        replaces: false,
    });
    if let Err(refusal) = push.validate() {
        return Err(argument_error(call, &Text::of(&refusal)));
    }
    act(site, call, after, TestAction::Command(push))
}

fn safety(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let wanted = text(call, 0, "state")?;
    let kind = match wanted.as_str() {
        "normal" => return make_ready(site, call),
        "protective_stop" => CommandKind::Machine(MachineCommand::ProtectiveStop),
        "emergency_stop" => CommandKind::Machine(MachineCommand::EmergencyStop { pressed: true }),
        other => {
            let text = text!(
                "state is {other:?}; allowed are \"normal\", \"protective_stop\" and \"emergency_stop\"",
                "state 为 {other:?}；允许 \"normal\"、\"protective_stop\" 和 \"emergency_stop\""
            );
            return Err(argument_error(call, &text));
        }
    };
    act(site, call, Seconds::default(), TestAction::Command(kind))?;
    // One cycle passes before the call returns: then the next question of the test sees the effect.
    let next = site.bench.turns.cycles() + 1;
    site.attendance.wait_until_cycle(call, next)?;
    Ok(Value::None)
}

/// What a person does after a stop: releases the button, unlocks, powers on, releases the brakes.
fn make_ready(site: &CallContext, call: &mut NativeCall<'_>) -> NativeResult {
    let robot = site.bench.robot.clone();
    let step = robot.state().step_time;
    let deadline = site.bench.turns.cycles() + (READY_MAX / step) as u64;
    let released = CommandKind::Machine(MachineCommand::EmergencyStop { pressed: false });
    act(
        site,
        call,
        Seconds::default(),
        TestAction::Command(released),
    )?;
    loop {
        let state = robot.state();
        let is_safe = matches!(state.safety_mode, SafetyMode::Normal | SafetyMode::Reduced);
        let next = match (is_safe, state.robot_mode) {
            (true, RobotMode::Running) => return Ok(Value::None),
            (false, _) => Some(CommandKind::Machine(MachineCommand::UnlockProtectiveStop)),
            (true, RobotMode::PowerOff) => Some(CommandKind::Machine(MachineCommand::PowerOn)),
            (true, RobotMode::Idle) => Some(CommandKind::Machine(MachineCommand::ReleaseBrakes)),
            (true, _) => None,
        };
        if site.bench.turns.cycles() >= deadline {
            let text = text!(
                "the arm is not ready after {READY_MAX} s: its robot mode is {}, its safety mode {}",
                "{READY_MAX} s 后机械臂仍未就绪：机器人模式为 {}，安全模式为 {}",
                state.robot_mode,
                state.safety_mode
            );
            return Err(raise(call, ExceptionKind::RuntimeError, &text));
        }
        if let Some(command) = next {
            act(site, call, Seconds::default(), TestAction::Command(command))?;
        }
        // Commands take a cycle or two; asked for again meanwhile they would only be refused.
        let wait = site.bench.turns.cycles() + 4;
        site.attendance.wait_until_cycle(call, wait)?;
    }
}
