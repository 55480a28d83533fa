//! The `eliteserver` binary: reads the command line and hands over to the command.

// No thread starts but through `supervision`; nothing waits for, or panics at, whoever reads our output.
#![cfg_attr(
    not(test),
    warn(clippy::disallowed_methods, clippy::print_stdout, clippy::print_stderr)
)]

use std::io::{ErrorKind, Write};
use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;
use server::cli::{Cli, Command, LogArgs};
use server::commands;
use server::config::{RunConfig, ServeConfig};
use server::options::LogFormat;
use server::shutdown::FAULT_EXIT;
use server::{logging, replay, wait};
use supervision::{Fault, Kind, catch};

/// Standard error has this long to be read to its end.
const LAST_LINES: Duration = Duration::from_secs(1);

fn main() -> ExitCode {
    supervision::install_panic_hook();
    supervision::injection::begin();
    // This process starts no others but those that programs ask for.
    elite_runtime::all_children_are_tasks();
    let command = Cli::parse().into_command();
    let status = match catch(|| execute(command)) {
        Ok(Ok(status)) => status,
        Ok(Err(sentence)) => {
            logging::say(&format!("eliteserver: {sentence}"));
            ExitCode::from(2)
        }
        // A fault outside every thread that contains its own.
        Err(panicked) => {
            let fault = Fault::new(Kind::Service, "the command", panicked);
            logging::say(&format!("eliteserver: {fault}"));
            ExitCode::from(FAULT_EXIT)
        }
    };
    logging::flush_within(LAST_LINES);
    status
}

/// Writes the answer of a command. Whoever reads it may have seen enough: `eliteserver builtins | head`.
fn answer(text: &str) -> Result<ExitCode, String> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Ok(()) => Ok(ExitCode::SUCCESS),
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(ExitCode::SUCCESS),
        Err(error) => Err(format!("cannot write the answer: {error}")),
    }
}

/// The exit status, or a sentence that says why there is none better than 2.
fn execute(command: Command) -> Result<ExitCode, String> {
    let plain = |log: &LogArgs| start_log(log.log_format.unwrap_or_default());
    match command {
        Command::Serve(args) => {
            let config = ServeConfig::load(*args).map_err(|e| e.to_string())?;
            start_log(config.log.format)?;
            commands::serve::serve(&config)
                .map(ExitCode::from)
                .map_err(|e| e.to_string())
        }
        Command::Run(args) => {
            let config = RunConfig::load(*args).map_err(|e| e.to_string())?;
            start_log(config.log.format)?;
            commands::run::run(&config)
                .map(ExitCode::from)
                .map_err(|e| e.to_string())
        }
        Command::Check(args) => {
            plain(&args.log)?;
            Ok(ExitCode::from(commands::check::check(&args)))
        }
        Command::Test(args) => {
            plain(&args.log)?;
            Ok(commands::test::test(&args))
        }
        Command::Replay(args) => {
            plain(&args.log)?;
            Ok(ExitCode::from(replay::run(&args)))
        }
        Command::Builtins(args) => {
            plain(&args.log)?;
            answer(&commands::builtins::list(args.format))
        }
        Command::Send(args) => {
            plain(&args.robot.log)?;
            Ok(commands::send::send(&args))
        }
        Command::Shell(args) => {
            plain(&args.robot.log)?;
            Ok(commands::shell::shell(&args))
        }
        Command::Calibrate(args) => {
            plain(&args.robot.log)?;
            Ok(commands::calibrate::calibrate(&args))
        }
        Command::Record(args) => {
            plain(&args.robot.log)?;
            Ok(commands::record::record(&args))
        }
        Command::Compare(args) => {
            plain(&args.log)?;
            Ok(commands::compare::compare(&args))
        }
        Command::Wait(args) => {
            plain(&args.log)?;
            Ok(wait::command(&args))
        }
    }
}

fn start_log(format: LogFormat) -> Result<(), String> {
    logging::init(format).map_err(|error| error.to_string())
}
