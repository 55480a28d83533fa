//! The command line in Chinese: help texts, and what is wrong with what was typed.
//!
//! The declaration stays English; its texts are exchanged before it is parsed with. What clap says of wrong
//! arguments is the business of [`super::refusal`].

use std::ffi::OsString;
use std::io::{IsTerminal as _, Write as _};

use clap::builder::StyledStr;
use clap::{Arg, Command, CommandFactory as _, FromArgMatches as _, Parser as _};
use controller::options::ControllerOptions;
use messages::{Language, LocalizedHelp as _};

use super::refusal::refusal;
use super::{
    BuiltinsArgs, CellArgs, CheckArgs, Cli, CliCommand, CompletionsArgs, ControllerArgs,
    DoctorArgs, FindingFormat, FleetArgs, ListFormat, LogArgs, LspArgs, ManArgs, RunArgs,
    RunCommandArgs, ServeArgs, TextLanguage, WaitArgs,
};
use crate::language;

/// Columns of a line of help: what is left beside the names of most options.
const COLUMNS: usize = 66;
/// Punctuation that does not begin a line.
const NOT_FIRST: &str = "，。；：、？！）」》…,.;:)]";
/// Punctuation that does not end one.
const NOT_LAST: &str = "（「《";
/// Headings that clap writes itself, and the words in its usage line.
const HEADINGS: [(&str, &str); 6] = [
    ("Usage:", "用法:"),
    ("Arguments:", "参数:"),
    ("Options:", "选项:"),
    ("Commands:", "命令:"),
    ("[OPTIONS]", "[选项]"),
    ("<COMMAND>", "<命令>"),
];

/// Help texts that are declared beside their options and commands.
const HELP: &[&[(&str, &str)]] = &[
    ControllerOptions::CHINESE,
    super::debug::DebugArgs::CHINESE,
    super::debug::DebugRobotArgs::CHINESE,
    super::identify::IdentifyArgs::CHINESE,
    super::identify::IdentifyTarget::CHINESE,
    super::identify::ExciteArgs::CHINESE,
    super::identify::ExciteTarget::CHINESE,
    super::import::TranslateArgs::CHINESE,
    super::import::ImportArgs::CHINESE,
    super::import::LengthUnit::CHINESE,
    Cli::CHINESE,
    CliCommand::CHINESE,
    LogArgs::CHINESE,
    LspArgs::CHINESE,
    FleetArgs::CHINESE,
    TextLanguage::CHINESE,
    ControllerArgs::CHINESE,
    ServeArgs::CHINESE,
    DoctorArgs::CHINESE,
    CompletionsArgs::CHINESE,
    ManArgs::CHINESE,
    RunCommandArgs::CHINESE,
    RunArgs::CHINESE,
    FindingFormat::CHINESE,
    CheckArgs::CHINESE,
    CellArgs::CHINESE,
    ListFormat::CHINESE,
    BuiltinsArgs::CHINESE,
    WaitArgs::CHINESE,
    super::paths::ClearanceArgs::CHINESE,
    super::paths::PlanArgs::CHINESE,
    super::paths::OptimizeArgs::CHINESE,
    super::paths::PlaceArgs::CHINESE,
    super::replay::ReplayArgs::CHINESE,
    super::replay::ReplayPortArgs::CHINESE,
    super::robot::RemoteRobotArgs::CHINESE,
    super::robot::OutputArgs::CHINESE,
    super::robot::SendArgs::CHINESE,
    super::robot::ShellArgs::CHINESE,
    super::robot::CalibrateArgs::CHINESE,
    super::robot::RecordArgs::CHINESE,
    super::robot::CompareFormat::CHINESE,
    super::robot::CompareArgs::CHINESE,
    super::ros2::Ros2Args::CHINESE,
    super::ros2::RosMiddleware::CHINESE,
    super::test::TestFormat::CHINESE,
    super::test::TestArgs::CHINESE,
];
/// Headings of options, comments of examples, and what clap says of itself.
const OTHER_TEXTS: &[(&str, &str)] = &[
    ("Examples:", "示例："),
    ("Messages", "消息"),
    ("Ports and server", "端口与服务"),
    ("Ports of --serve", "--serve 的端口"),
    ("Robot", "机器人"),
    ("ROS 2", "ROS 2"),
    ("Print help", "显示帮助"),
    (
        "Print help (see a summary with '-h')",
        "显示帮助（摘要用 '-h'）",
    ),
    (
        "Print help (see more with '--help')",
        "显示帮助（详细说明用 '--help'）",
    ),
    (
        "Print this message or the help of the given subcommand(s)",
        "显示此说明或子命令的帮助",
    ),
    ("Print version", "显示版本"),
    ("a recording, backwards as well", "记录，也可反向"),
    (
        "every *.script below the folder",
        "文件夹之内的所有 *.script",
    ),
    ("for an editor", "供编辑器使用"),
    ("on the page, as if live", "在页面上，像实时一样"),
    (
        "the page is at http://127.0.0.1:8080/",
        "页面在 http://127.0.0.1:8080/",
    ),
];

/// Reads a command line. What is wrong with it, and `--help`, end the process as clap does, in this language.
pub fn parse(arguments: Vec<OsString>, language: Language) -> Cli {
    let arguments = language_after_command(arguments);
    if language == Language::English {
        return Cli::parse_from(arguments);
    }
    let mut command = in_chinese();
    let parsed = command
        .try_get_matches_from_mut(arguments)
        .and_then(|matches| {
            Cli::from_arg_matches(&matches).map_err(|error| error.format(&mut command))
        });
    parsed.unwrap_or_else(|error| {
        // Whoever reads may have seen enough; the status still tells.
        let _ = match error.use_stderr() {
            true => std::io::stderr().write_all(with_headings(refusal(&error)).as_bytes()),
            false => {
                let text = match std::io::stdout().is_terminal() {
                    true => error.render().ansi().to_string(),
                    false => error.render().to_string(),
                };
                std::io::stdout().write_all(with_headings(text).as_bytes())
            }
        };
        std::process::exit(error.exit_code())
    })
}

/// The command line with a leading `--language` put behind the command, where each command has it: before the command
/// stand options of `serve`, which no other command takes.
fn language_after_command(mut arguments: Vec<OsString>) -> Vec<OsString> {
    let words = match arguments.get(1).and_then(|first| first.to_str()) {
        Some("--language") => 2,
        Some(first) if first.starts_with("--language=") => 1,
        _ => return arguments,
    };
    let is_command = arguments
        .get(1 + words)
        .is_some_and(|name| Cli::command().find_subcommand(name).is_some());
    if is_command {
        arguments[1..=1 + words].rotate_left(words);
    }
    arguments
}

/// The command line with Chinese texts.
fn in_chinese() -> Command {
    let mut command = Cli::command();
    // The texts about --help and --version come with this.
    command.build();
    exchange(command)
}

fn exchange(mut command: Command) -> Command {
    if let Some(about) = command.get_about().map(chinese) {
        command = command.about(about);
    }
    if let Some(about) = command.get_long_about().map(chinese) {
        command = command.long_about(about);
    }
    if let Some(examples) = command.get_after_help().map(ToString::to_string) {
        command = command.after_help(with_comments(&examples));
    }
    command.mut_args(argument).mut_subcommands(exchange)
}

fn argument(mut arg: Arg) -> Arg {
    let values: Vec<_> = match arg.get_action().takes_values() && !arg.is_hide_possible_values_set()
    {
        true => arg.get_possible_values(),
        false => Vec::new(),
    };
    let defaults: Vec<_> = arg
        .get_default_values()
        .iter()
        .map(|value| value.to_string_lossy())
        .collect();
    let default = match defaults.is_empty() || !arg.get_action().takes_values() {
        true => String::new(),
        false => format!(" [默认：{}]", defaults.join(" ")),
    };
    let names: Vec<&str> = values.iter().map(|value| value.get_name()).collect();
    let described: String = values
        .iter()
        .filter_map(|value| {
            Some(format!(
                "\n- {}：{}",
                value.get_name(),
                chinese(value.get_help()?)
            ))
        })
        .collect();
    let short = arg.get_help().map(chinese);
    let long = arg.get_long_help().map(chinese);
    if let Some(text) = &short {
        let choice = match names.is_empty() {
            true => String::new(),
            false => format!(" [可选值：{}]", names.join("、")),
        };
        arg = arg.help(wrapped(&format!("{text}{default}{choice}")));
    }
    if let Some(text) = long.or_else(|| short.filter(|_| !described.is_empty())) {
        let choice = match described.is_empty() {
            true => String::new(),
            false => format!("\n\n可选值：{described}"),
        };
        arg = arg.long_help(wrapped(&format!("{text}{default}{choice}")));
    }
    if let Some(heading) = arg.get_help_heading().and_then(declared) {
        arg = arg.help_heading(heading);
    }
    arg.hide_possible_values(true).hide_default_value(true)
}

/// The Chinese form of a help text.
fn chinese(english: &StyledStr) -> String {
    wrapped(&help_text(&english.to_string()))
}

fn help_text(english: &str) -> String {
    declared(english).unwrap_or(english).to_owned()
}

fn declared(english: &str) -> Option<&'static str> {
    let mut texts = HELP.iter().copied().flatten().chain(OTHER_TEXTS);
    let (_, chinese) = texts.find(|(text, _)| *text == english)?;
    Some(chinese)
}

/// Examples, and what stands behind them.
fn with_comments(examples: &str) -> String {
    let lines = examples.lines().map(|line| match line.rsplit_once("  ") {
        Some((command, comment)) if !command.trim().is_empty() => {
            format!("{command}  {}", help_text(comment))
        }
        _ => help_text(line),
    });
    lines.collect::<Vec<_>>().join("\n")
}

fn with_headings(help: String) -> String {
    HEADINGS.iter().fold(help, |help, (english, chinese)| {
        help.replace(english, chinese)
    })
}

/// Lines that are no longer than [`COLUMNS`]: Chinese has no blanks at which clap could break.
fn wrapped(text: &str) -> String {
    let mut lines = String::new();
    for (number, line) in text.split('\n').enumerate() {
        if number > 0 {
            lines.push('\n');
        }
        let mut column = 0;
        let mut rest = line;
        while let Some(word) = first_word(rest) {
            let columns = language::columns_of(word.trim_end());
            if column > 0 && column + columns > COLUMNS {
                lines.truncate(lines.trim_end_matches(' ').len());
                lines.push('\n');
                column = 0;
            }
            lines.push_str(word);
            column += language::columns_of(word);
            rest = &rest[word.len()..];
        }
    }
    lines
}

/// What stays together at the beginning of a line: letters up to a blank or to a Chinese one, with the punctuation
/// behind them.
fn first_word(line: &str) -> Option<&str> {
    let mut letters = line.char_indices();
    let (_, first) = letters.next()?;
    let mut last = first;
    // The word at the beginning of a bracket, up to its colon.
    let mut is_mark = first == '[';
    for (at, letter) in letters {
        let is_apart = last == ' ' || language::is_wide(last) || language::is_wide(letter);
        let stays =
            is_mark || letter == ' ' || NOT_FIRST.contains(letter) || NOT_LAST.contains(last);
        if is_apart && !stays {
            return Some(&line[..at]);
        }
        is_mark = letter == '[' || is_mark && !"：] ".contains(letter);
        last = letter;
    }
    Some(line)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    /// Every help text of the command line, as it is declared.
    fn texts(command: &Command, found: &mut BTreeSet<String>) {
        let mut add = |text: Option<&StyledStr>| found.extend(text.map(ToString::to_string));
        add(command.get_about());
        add(command.get_long_about());
        for arg in command.get_arguments() {
            add(arg.get_help());
            add(arg.get_long_help());
            for value in arg.get_possible_values() {
                add(value.get_help());
            }
        }
        for arg in command.get_arguments() {
            found.extend(arg.get_help_heading().map(ToOwned::to_owned));
        }
        let examples = command.get_after_help().map(ToString::to_string);
        for line in examples.iter().flat_map(|text| text.lines()) {
            match line.trim_start().rsplit_once("  ") {
                Some((_, comment)) => found.insert(comment.to_owned()),
                None if line.starts_with(' ') => false,
                None => found.insert(line.to_owned()),
            };
        }
        for inner in command.get_subcommands() {
            texts(inner, found);
        }
    }

    #[test]
    fn every_help_text_is_there_in_chinese() {
        let mut command = Cli::command();
        command.build();
        let mut declared = BTreeSet::new();
        texts(&command, &mut declared);
        let known = HELP.iter().copied().flatten().chain(OTHER_TEXTS);
        let known: BTreeSet<&str> = known.map(|(english, _)| *english).collect();
        let missing: Vec<&String> = declared
            .iter()
            .filter(|text| !known.contains(&***text))
            .collect();
        assert!(missing.is_empty(), "{missing:#?}");
        let dead: Vec<&&str> = known
            .iter()
            .filter(|text| !declared.contains(**text))
            .collect();
        assert!(dead.is_empty(), "no command says so any more: {dead:#?}");
    }

    #[test]
    fn lines_break_between_chinese_letters_and_not_before_punctuation() {
        let text = "机械臂".repeat(11) + "，然后停止";
        let lines: Vec<String> = wrapped(&text).lines().map(ToOwned::to_owned).collect();
        assert_eq!(lines.len(), 2);
        assert!(lines[1].starts_with("臂，"), "{lines:?}");
        assert_eq!(wrapped("--set speed=0.25"), "--set speed=0.25");
        let marked = "机".repeat(30) + " [默认：serve 为 realtime]";
        assert!(wrapped(&marked).ends_with("\n[默认：serve 为 realtime]"));
    }

    #[test]
    fn a_language_before_the_command_is_the_command_s() {
        for (given, wanted) in [
            ("--language zh test .", "test --language zh ."),
            ("--language=zh check a b", "check --language=zh a b"),
            ("--language zh", "--language zh"),
            ("--language zh --port 1", "--language zh --port 1"),
            ("--language test check", "check --language test"),
            ("check --language zh", "check --language zh"),
            ("", ""),
        ] {
            let words = |line: &str| -> Vec<OsString> {
                let words = line.split_whitespace().map(OsString::from);
                std::iter::once("eliteserver".into()).chain(words).collect()
            };
            assert_eq!(language_after_command(words(given)), words(wanted));
        }
    }
}
