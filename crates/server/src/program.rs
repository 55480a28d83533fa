//! The whole program as a function: reads a command line, hands over to the command, gives back the exit status.
//!
//! Called by the binary and by the console command of the Python wheel, so that both are one program.

use std::ffi::OsString;
use std::io::{ErrorKind, Write};
use std::time::Duration;

use messages::text;
use supervision::{Fault, ThreadRole, catch};

use crate::cli::{CliCommand, RunArgs, parse};
use crate::command::{CommandError, CommandResult, CommandStatus};
use crate::config::{LogConfig, RunConfig, ServeConfig};
use crate::{commands, language, logging};

/// Standard error has this long to be read to its end.
const STDERR_FLUSH_TIMEOUT: Duration = Duration::from_secs(1);

/// Runs the program with these arguments, the name of the program first. What is wrong with them, and `--help`, end the
/// process as clap does. It is the only thing its process does: it listens for signals and takes the children.
pub fn run_program(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    supervision::install_panic_hook();
    supervision::injection::begin();
    // This process starts no others but those that programs ask for.
    elite_runtime::claim_all_children();
    let arguments: Vec<OsString> = arguments.into_iter().collect();
    let language = language::of_arguments(&arguments);
    let command = parse(arguments, language).into_command();
    let status = match catch(|| execute(command)) {
        Ok(Ok(status)) => status,
        Ok(Err(error)) => {
            // Where the configuration cannot be read no language is chosen yet.
            language::choose_this(language);
            logging::say(&format!("eliteserver: {}", language::shown(&error)));
            error.status()
        }
        // A fault outside every thread that contains its own.
        Err(panicked) => {
            let fault = Fault::new(ThreadRole::Service, "the command", panicked);
            logging::say(&format!("eliteserver: {fault}"));
            CommandStatus::Fault
        }
    };
    logging::flush_within(STDERR_FLUSH_TIMEOUT);
    status.code()
}

/// Writes the answer of a command. Whoever reads it may have seen enough: `eliteserver builtins | head`.
fn answer(text: &[u8]) -> CommandResult {
    let mut out = std::io::stdout().lock();
    match out.write_all(text).and_then(|()| out.flush()) {
        Ok(()) => Ok(CommandStatus::Success),
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(CommandStatus::Success),
        Err(error) => Err(CommandError::sentence(text!(
            "cannot write the answer: {error}",
            "无法写出回答：{error}"
        ))),
    }
}

fn execute(command: CliCommand) -> CommandResult {
    if let Some(log) = command.log_args() {
        language::choose(log.language);
        logging::init(log.log_format.unwrap_or_default())?;
    }
    match command {
        CliCommand::Serve(args) => {
            let config = ServeConfig::load(*args)?;
            begin_log(&config.log)?;
            commands::serve::serve(&config)
        }
        CliCommand::Run(args) => {
            let mut config = RunConfig::load(args.run)?;
            if let Some(given) = args.ros2_profile {
                config.ros2_profile = given;
            }
            begin_log(&config.log)?;
            commands::run::run(&config, args.timeout, !args.no_check)
        }
        CliCommand::Doctor(args) => {
            let config = ServeConfig::load(args.serve)?;
            begin_log(&config.log)?;
            let (report, status) = commands::doctor::doctor(&config, args.format);
            answer(report.as_bytes()).map(|written| written.max(status))
        }
        CliCommand::Clearance(args) => {
            let config = RunConfig::load(args.run.clone())?;
            begin_log(&config.log)?;
            commands::clearance::clearance(&args, &config)
        }
        CliCommand::Plan(args) => {
            let robot = RunArgs {
                shared: args.shared.clone(),
                ..RunArgs::default()
            };
            let config = RunConfig::load(robot)?;
            begin_log(&config.log)?;
            commands::plan::plan(&args, &config)
        }
        CliCommand::Optimize(args) => {
            let config = RunConfig::load(args.run.clone())?;
            begin_log(&config.log)?;
            commands::optimize::optimize(&args, &config)
        }
        CliCommand::Place(args) => {
            let robot = RunArgs {
                shared: args.shared.clone(),
                ..RunArgs::default()
            };
            let config = RunConfig::load(robot)?;
            begin_log(&config.log)?;
            commands::place::place(&args, &config)
        }
        CliCommand::Check(args) => commands::check::check(&args),
        CliCommand::Test(args) => commands::test::test(&args),
        CliCommand::Debug(args) => commands::debug::debug(&args),
        CliCommand::Replay(args) => commands::replay::replay(&args),
        CliCommand::Builtins(args) => {
            let (text, status) = commands::builtins::builtins(&args);
            answer(text.as_bytes()).map(|written| written.max(status))
        }
        CliCommand::Send(args) => commands::send::send(&args),
        CliCommand::Shell(args) => commands::shell::shell(&args),
        CliCommand::Calibrate(args) => commands::calibrate::calibrate(&args),
        CliCommand::Record(args) => commands::record::record(&args),
        CliCommand::Compare(args) => commands::compare::compare(&args),
        CliCommand::Identify(args) => commands::identify::identify(&args),
        CliCommand::Excite(args) => {
            let robot = RunArgs {
                shared: args.shared.clone(),
                ..RunArgs::default()
            };
            let config = RunConfig::load(robot)?;
            begin_log(&config.log)?;
            commands::excite::excite(&args, &config)
        }
        CliCommand::Import(args) => commands::import::import(&args),
        CliCommand::Translate(args) => commands::translate::translate(&args),
        CliCommand::Lsp(args) => commands::lsp::lsp(&args),
        CliCommand::Mcp(args) => commands::mcp::mcp(&args),
        CliCommand::Fleet(args) => commands::fleet::fleet(&args),
        CliCommand::Completions(args) => answer(&commands::completions::script(args.shell)),
        CliCommand::Man(args) => commands::man::man(&args),
        CliCommand::Cell(args) => commands::cell::run(&args),
        CliCommand::Ros2 => commands::ros2::run_node(),
        CliCommand::Wait(args) => commands::wait::run(&args),
    }
}

/// The language and the log of a command whose settings may stand in a configuration file.
fn begin_log(log: &LogConfig) -> Result<(), CommandError> {
    language::choose(log.language);
    Ok(logging::init(log.format)?)
}
