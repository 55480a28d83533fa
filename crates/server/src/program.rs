//! The whole program as a function: reads a command line, hands over to the command, gives back the exit status.
//!
//! Called by the binary and by the console command of the Python wheel, so that both are one program.

use std::ffi::OsString;
use std::io::{ErrorKind, Write};
use std::time::Duration;

use clap::Parser;
use supervision::{Fault, ThreadRole, catch};

use crate::cli::{Cli, CliCommand, LogArgs};
use crate::config::{RunConfig, ServeConfig};
use crate::options::LogFormat;
use crate::shutdown::FAULT_EXIT;
use crate::{commands, language, logging, replay, wait};

/// Standard error has this long to be read to its end.
const STDERR_FLUSH_TIMEOUT: Duration = Duration::from_secs(1);

/// Runs the program with these arguments, the name of the program first. What is wrong with them, and `--help`, end the
/// process as clap does. It is the only thing its process does: it listens for signals and takes the children.
pub fn run_program(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    supervision::install_panic_hook();
    supervision::injection::begin();
    // This process starts no others but those that programs ask for.
    elite_runtime::claim_all_children();
    let command = Cli::parse_from(arguments).into_command();
    let status = match catch(|| execute(command)) {
        Ok(Ok(status)) => status,
        Ok(Err(sentence)) => {
            logging::say(&format!("eliteserver: {sentence}"));
            2
        }
        // A fault outside every thread that contains its own.
        Err(panicked) => {
            let fault = Fault::new(ThreadRole::Service, "the command", panicked);
            logging::say(&format!("eliteserver: {fault}"));
            FAULT_EXIT
        }
    };
    logging::flush_within(STDERR_FLUSH_TIMEOUT);
    status
}

/// Writes the answer of a command. Whoever reads it may have seen enough: `eliteserver builtins | head`.
fn answer(text: &[u8]) -> Result<u8, String> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text).and_then(|()| out.flush()) {
        Ok(()) => Ok(0),
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(0),
        Err(error) => Err(format!("cannot write the answer: {error}")),
    }
}

/// The exit status, or a sentence that says why there is none better than 2.
fn execute(command: CliCommand) -> Result<u8, String> {
    let plain = |log: &LogArgs| {
        language::choose(log.language);
        start_log(log.log_format.unwrap_or_default())
    };
    match command {
        CliCommand::Serve(args) => {
            let config = ServeConfig::load(*args).map_err(|e| e.to_string())?;
            language::choose(config.log.language);
            start_log(config.log.format)?;
            commands::serve::serve(&config).map_err(|e| e.to_string())
        }
        CliCommand::Run(args) => {
            let config = RunConfig::load(*args).map_err(|e| e.to_string())?;
            language::choose(config.log.language);
            start_log(config.log.format)?;
            commands::run::run(&config).map_err(|e| e.to_string())
        }
        CliCommand::Check(args) => {
            plain(&args.log)?;
            Ok(commands::check::check(&args))
        }
        CliCommand::Test(args) => {
            plain(&args.log)?;
            Ok(commands::test::test(&args))
        }
        CliCommand::Debug(args) => {
            plain(&args.log)?;
            commands::debug::debug(&args).map_err(|error| format!("the debugger ends: {error}"))
        }
        CliCommand::Replay(args) => {
            plain(&args.log)?;
            Ok(replay::run(&args))
        }
        CliCommand::Builtins(args) => {
            plain(&args.log)?;
            answer(commands::builtins::list(args.format).as_bytes())
        }
        CliCommand::Send(args) => {
            plain(&args.robot.log)?;
            Ok(commands::send::send(&args))
        }
        CliCommand::Shell(args) => {
            plain(&args.robot.log)?;
            Ok(commands::shell::shell(&args))
        }
        CliCommand::Calibrate(args) => {
            plain(&args.robot.log)?;
            Ok(commands::calibrate::calibrate(&args))
        }
        CliCommand::Record(args) => {
            plain(&args.robot.log)?;
            Ok(commands::record::record(&args))
        }
        CliCommand::Compare(args) => {
            plain(&args.log)?;
            Ok(commands::compare::compare(&args))
        }
        CliCommand::Lsp(args) => {
            plain(&args.log)?;
            commands::lsp::lsp(&args)
        }
        CliCommand::Mcp(args) => {
            plain(&args.log)?;
            commands::mcp::mcp(&args)
        }
        CliCommand::Fleet(args) => {
            plain(&args.log)?;
            commands::fleet::fleet(&args).map_err(|error| error.to_string())
        }
        CliCommand::Doctor(args) => {
            let config = ServeConfig::load(args.serve).map_err(|e| e.to_string())?;
            language::choose(config.log.language);
            start_log(config.log.format)?;
            let (report, status) = commands::doctor::doctor(&config, args.format);
            answer(report.as_bytes()).map(|told| told.max(status))
        }
        CliCommand::Completions(args) => answer(&commands::shell_files::completions(args.shell)),
        CliCommand::Man(args) => {
            let folder = args.folder.display();
            let written = commands::shell_files::manual(&args.folder);
            written.map_err(|error| format!("cannot write the pages into {folder}: {error}"))?;
            Ok(0)
        }
        CliCommand::Wait(args) => {
            plain(&args.log)?;
            Ok(wait::command(&args))
        }
    }
}

fn start_log(format: LogFormat) -> Result<(), String> {
    logging::init(format).map_err(|error| error.to_string())
}
