//! `eliteserver debug`: the debugger at a terminal; for editors over standard input and output, or over a port for one
//! client after the other.

mod attach;
mod console;
mod option_errors;
mod recording;

use std::io::{self, BufReader};
use std::net::{Ipv4Addr, TcpListener};
use std::path::Path;

use clap::Parser;
use editor::dap::{RunTarget, serve_attaching};
use serde_json::{Map, Value as Json};
use thiserror::Error;

use controller::options::ClockChoice;

use crate::cli::{Cli, CliCommand, DebugArgs};
use crate::command::{CommandResult, CommandStatus};
use crate::commands::check::read_script;
use crate::config::RunConfig;
use crate::logging;

/// Keys of `launch` that are no options of the robot.
const OWN_KEYS: [&str; 6] = [
    "number",
    "program",
    "recording",
    "stopOnEntry",
    "stopAtEnd",
    "set",
];

/// Keys that clients add to `launch` and `attach`, or may.
const CLIENT_KEYS: [&str; 9] = [
    "name",
    "type",
    "request",
    "cwd",
    "internalConsoleOptions",
    "preLaunchTask",
    "postDebugTask",
    "presentation",
    "noDebug",
];

/// Whether a key is a client's own.
fn is_of_client(key: &str) -> bool {
    CLIENT_KEYS.contains(&key) || key.starts_with("__")
}

/// Options that a recording does not hold.
const RECORDING_KEYS: [&str; 4] = ["allow", "cell", "record", "task-dir"];

/// Options that mean nothing here.
const REFUSED_KEYS: [&str; 5] = ["language", "log-dir", "log-format", "no-check", "timeout"];

/// Exit status: 0 the client has left, 2 the port cannot be opened.
///
/// # Errors
/// The operating system gives no thread.
pub fn debug(args: &DebugArgs) -> CommandResult {
    match &args.file {
        Some(file) => console::console(args, &file.to_string_lossy()),
        None => Ok(serve_clients(args)?),
    }
}

/// The reason for which the debugger cannot go on, displayed as one sentence.
#[derive(Debug, Error)]
enum DebugError {
    #[error("cannot open port {port}: {source}")]
    Port { port: u16, source: io::Error },
    #[error("the debugger ends: {0}")]
    System(#[from] io::Error),
}

fn serve_clients(args: &DebugArgs) -> Result<CommandStatus, DebugError> {
    let Some(port) = args.port else {
        let mut output = io::stdout();
        let input = BufReader::new(io::stdin());
        serve_attaching(input, &mut output, &launch, Some(&attach::attach))?;
        return Ok(CommandStatus::Success);
    };
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))
        .map_err(|source| DebugError::Port { port, source })?;
    logging::say(&format!(
        "the debugger listens on {}",
        listener.local_addr()?
    ));
    loop {
        let (client, _) = listener.accept()?;
        // Answers are small and waited for.
        client.set_nodelay(true)?;
        let mut output = client.try_clone()?;
        serve_attaching(
            BufReader::new(client),
            &mut output,
            &launch,
            Some(&attach::attach),
        )?;
    }
}

/// The robot and the program of a `launch`.
fn launch(arguments: &Json) -> Result<RunTarget, String> {
    let Some(fields) = arguments.as_object() else {
        return Err("launch needs program, the path of a script".to_owned());
    };
    if let Some(recording) = fields.get("recording") {
        return launch_recording(fields, recording);
    }
    let program = fields.get("program").and_then(Json::as_str);
    let program = program.ok_or("launch needs program, the path of a script")?;
    if program == "-" {
        return Err("program is the path of a script; standard input is the client's".to_owned());
    }
    let text = read_script(Path::new(program))?;
    let config = options(fields, program)?;
    Ok(RunTarget {
        program: text,
        robot: config.robot,
        presets: config.presets,
        recorded: None,
    })
}

/// The robot and the program of a recording.
fn launch_recording(fields: &Map<String, Json>, recording: &Json) -> Result<RunTarget, String> {
    let path = recording.as_str();
    let path = path.ok_or("recording is the path of a recording")?;
    if fields.contains_key("program") {
        return Err("give either program or recording: a recording has its own program".to_owned());
    }
    let is_free = |key: &&String| {
        let key = key.as_str();
        OWN_KEYS.contains(&key) || is_of_client(key) || RECORDING_KEYS.contains(&key)
    };
    if let Some(key) = fields.keys().find(|key| !is_free(key)) {
        return Err(format!(
            "{key} is in the recording; beside it there may be {}",
            RECORDING_KEYS.join(", ")
        ));
    }
    let number = match fields.get("number") {
        None => None,
        Some(given) => Some(given.as_u64().filter(|n| *n > 0).ok_or_else(|| {
            format!("number is {given}; it says which program of the recording, from 1")
        })?),
    };
    let config = options(fields, "-")?;
    // Who says what programs may reach, or what else is different, wants the program to run anew.
    let is_anew =
        fields.contains_key("set") || RECORDING_KEYS.iter().any(|key| fields.contains_key(*key));
    if !is_anew && let Some(found) = recording::repeated(Path::new(path), number, &config.robot)? {
        return Ok(found);
    }
    if number.is_some_and(|number| number > 1) {
        return Err(
            "only the first program of a recording can be run anew: leave number out".to_owned(),
        );
    }
    let (program, robot) = recording::open(Path::new(path), &config.robot)?;
    Ok(RunTarget {
        program,
        robot,
        presets: config.presets,
        recorded: None,
    })
}

/// The options of `run` among the arguments.
fn options(fields: &Map<String, Json>, program: &str) -> Result<RunConfig, String> {
    let mut line = vec!["eliteserver".to_owned(), "run".to_owned()];
    for (key, value) in fields {
        if OWN_KEYS.contains(&key.as_str()) || is_of_client(key) {
            continue;
        }
        if REFUSED_KEYS.contains(&key.as_str()) {
            return Err(format!("{key} means nothing to the debugger"));
        }
        add_option(&mut line, key, value)?;
    }
    presets(&mut line, fields.get("set"))?;
    line.push("--".to_owned());
    line.push(program.to_owned());
    let config = configured(line)?;
    if config.robot.clock == ClockChoice::Realtime {
        return Err(
            "the debugger runs programs under the virtual clock only; leave clock out".to_owned(),
        );
    }
    Ok(config)
}

fn configured(line: Vec<String>) -> Result<RunConfig, String> {
    let cli = Cli::try_parse_from(line).map_err(|error| option_errors::of_request(&error))?;
    match cli.into_command() {
        CliCommand::Run(args) => RunConfig::load(args.run).map_err(|error| error.to_string()),
        _ => Err("these are no options of run".to_owned()),
    }
}

/// `"home": [0, -1.57, …]` is as good as `"home": "0,-1.57,…"`; a list of texts is an option given several times.
fn add_option(line: &mut Vec<String>, key: &str, value: &Json) -> Result<(), String> {
    let is_name = !key.is_empty() && key.chars().all(|c| c.is_ascii_lowercase() || c == '-');
    if !is_name {
        return Err(format!(
            "launch knows no key {key:?}; there are program, stopOnEntry, stopAtEnd, set and the options of run"
        ));
    }
    match value {
        Json::Array(items) if items.iter().all(Json::is_number) => {
            let numbers: Vec<String> = items.iter().map(ToString::to_string).collect();
            line.push(format!("--{key}={}", numbers.join(",")));
        }
        Json::Array(items) => {
            for item in items {
                line.push(format!("--{key}={}", plain(item)));
            }
        }
        Json::Null => {}
        other => line.push(format!("--{key}={}", plain(other))),
    }
    Ok(())
}

/// `"set": {"speed": 0.25}` or `"set": ["speed=0.25"]`.
fn presets(line: &mut Vec<String>, set: Option<&Json>) -> Result<(), String> {
    match set {
        None | Some(Json::Null) => {}
        Some(Json::Object(values)) => {
            for (name, value) in values {
                line.push(format!("--set={name}={}", literal(value)));
            }
        }
        Some(Json::Array(items)) => {
            line.extend(items.iter().map(|item| format!("--set={}", plain(item))));
        }
        Some(other) => {
            return Err(format!(
                "set is {other}; an object of names and values is needed"
            ));
        }
    }
    Ok(())
}

/// A value as programs write it.
pub(crate) fn literal(value: &Json) -> String {
    match value {
        Json::Bool(true) => "True".to_owned(),
        Json::Bool(false) => "False".to_owned(),
        Json::Null => "None".to_owned(),
        Json::Array(items) => {
            let items: Vec<String> = items.iter().map(literal).collect();
            format!("[{}]", items.join(", "))
        }
        Json::Object(entries) => {
            let entries = entries
                .iter()
                .map(|(key, value)| format!("{}: {}", Json::from(key.as_str()), literal(value)));
            format!("{{{}}}", entries.collect::<Vec<_>>().join(", "))
        }
        other => other.to_string(),
    }
}

fn plain(value: &Json) -> String {
    match value {
        Json::String(text) => text.clone(),
        other => other.to_string(),
    }
}
