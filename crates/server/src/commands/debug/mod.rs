//! `eliteserver debug`: the debugger at a terminal; for editors over standard input and output, or over a port for one
//! client after the other.

mod attach;
mod console;
mod launch;
mod recording;

use std::io::{self, BufReader};
use std::net::{Ipv4Addr, TcpListener};

use editor::dap::{RunTarget, serve_attaching};
use messages::{Localized, Text, text};
use serde_json::Value as Json;
use thiserror::Error;

use self::launch::LaunchRequest;
use crate::cli::DebugArgs;
use crate::command::{CommandError, CommandResult, CommandStatus};
use crate::language;

/// Exit status: 0 the client has left, 2 the port cannot be opened.
///
/// # Errors
/// The operating system gives no thread.
pub fn debug(args: &DebugArgs) -> CommandResult {
    match &args.file {
        Some(file) => console::console(args, &file.to_string_lossy()),
        None => match args.robot.first_given() {
            Some(option) => Err(CommandError::sentence(text!(
                "--{option} needs FILE, the program that is debugged here; an editor says it in its launch request",
                "--{option} 需要 FILE，即在这里调试的程序；编辑器在其 launch 请求中给出"
            ))),
            None => Ok(serve_clients(args)?),
        },
    }
}

/// The reason for which the debugger cannot go on, displayed as one sentence.
#[derive(Debug, Error, Localized)]
enum DebugError {
    #[error("cannot open port {port}: {source}")]
    #[zh("无法打开端口 {port}：{source}")]
    Port { port: u16, source: io::Error },
    #[error("the debugger ends: {0}")]
    #[zh("调试器结束：{0}")]
    System(#[from] io::Error),
}

fn serve_clients(args: &DebugArgs) -> Result<CommandStatus, DebugError> {
    let Some(port) = args.port else {
        let mut output = io::stdout();
        let input = BufReader::new(io::stdin());
        serve_attaching(input, &mut output, &launch_target, Some(&attach::attach))?;
        return Ok(CommandStatus::Success);
    };
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))
        .map_err(|source| DebugError::Port { port, source })?;
    language::say(&text!(
        "the debugger listens on {}",
        "调试器监听 {}",
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
            &launch_target,
            Some(&attach::attach),
        )?;
    }
}

/// The robot and the program of an editor's `launch`.
fn launch_target(arguments: &Json) -> Result<RunTarget, Text> {
    LaunchRequest::from_json(arguments)?.target()
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
