//! The `eliteserver` binary: reads the command line and hands over to the command.

use std::process::ExitCode;

use clap::Parser;
use server::cli::{Cli, Command, LogArgs};
use server::commands;
use server::config::{RunConfig, ServeConfig};
use server::{logging, replay, wait};

fn main() -> ExitCode {
    let command = Cli::parse().into_command();
    match execute(command) {
        Ok(status) => ExitCode::from(status),
        Err(sentence) => {
            eprintln!("eliteserver: {sentence}");
            ExitCode::from(2)
        }
    }
}

/// The exit status, or a sentence that says why there is none better than 2.
fn execute(command: Command) -> Result<u8, String> {
    let plain = |log: &LogArgs| logging::start(log.log_format.unwrap_or_default());
    match command {
        Command::Serve(args) => {
            let config = ServeConfig::load(*args).map_err(|e| e.to_string())?;
            logging::start(config.robot.log_format);
            commands::serve::serve(&config).map_err(|e| e.to_string())
        }
        Command::Run(args) => {
            let config = RunConfig::load(*args).map_err(|e| e.to_string())?;
            logging::start(config.robot.log_format);
            commands::run::run(&config).map_err(|e| e.to_string())
        }
        Command::Check(args) => {
            plain(&args.log);
            Ok(commands::check::check(&args))
        }
        Command::Replay(args) => {
            plain(&args.log);
            Ok(replay::run(&args))
        }
        Command::Builtins(args) => {
            plain(&args.log);
            print!("{}", commands::builtins::list(args.format));
            Ok(0)
        }
        Command::Wait(args) => {
            plain(&args.log);
            Ok(wait::run(&args))
        }
    }
}
