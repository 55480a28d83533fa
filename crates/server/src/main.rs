//! The `eliteserver` binary: reads the command line and hands over to the command.

use std::process::ExitCode;

use clap::Parser;
use server::cli::{Cli, Command, LogArgs};
use server::commands;
use server::config::{RunConfig, ServeConfig};
use server::options::LogFormat;
use server::{logging, replay, wait};

fn main() -> ExitCode {
    // This process starts no others but those that programs ask for.
    elite_runtime::all_children_are_tasks();
    let command = Cli::parse().into_command();
    match execute(command) {
        Ok(status) => status,
        Err(sentence) => {
            eprintln!("eliteserver: {sentence}");
            ExitCode::from(2)
        }
    }
}

/// The exit status, or a sentence that says why there is none better than 2.
fn execute(command: Command) -> Result<ExitCode, String> {
    let plain = |log: &LogArgs| start_log(log.log_format.unwrap_or_default());
    match command {
        Command::Serve(args) => {
            let config = ServeConfig::load(*args).map_err(|e| e.to_string())?;
            start_log(config.robot.log_format)?;
            commands::serve::serve(&config)
                .map(ExitCode::from)
                .map_err(|e| e.to_string())
        }
        Command::Run(args) => {
            let config = RunConfig::load(*args).map_err(|e| e.to_string())?;
            start_log(config.robot.log_format)?;
            commands::run::run(&config)
                .map(ExitCode::from)
                .map_err(|e| e.to_string())
        }
        Command::Check(args) => {
            plain(&args.log)?;
            Ok(ExitCode::from(commands::check::check(&args)))
        }
        Command::Replay(args) => {
            plain(&args.log)?;
            Ok(ExitCode::from(replay::run(&args)))
        }
        Command::Builtins(args) => {
            plain(&args.log)?;
            print!("{}", commands::builtins::list(args.format));
            Ok(ExitCode::SUCCESS)
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
