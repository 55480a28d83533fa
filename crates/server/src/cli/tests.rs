//! Command lines, and the options they are read as.

use super::*;
use crate::options::PortSetting;
use clap::CommandFactory;
use controller::options::{ModelChoice, Permission};

fn parse(line: &str) -> Result<CliCommand, clap::Error> {
    Cli::try_parse_from(line.split_whitespace()).map(Cli::into_command)
}

fn serve_args(line: &str) -> ServeArgs {
    match parse(line).unwrap() {
        CliCommand::Serve(args) => *args,
        other => panic!("{line}: {other:?}"),
    }
}

#[test]
fn the_declaration_is_consistent() {
    Cli::command().debug_assert();
}

/// An option after flattened ones takes over their heading.
#[test]
fn options_stand_under_the_heading_of_their_subject() {
    let mut command = Cli::command();
    command.build();
    let mut seen = 0;
    for inner in command.get_subcommands() {
        for option in inner.get_arguments() {
            let (name, heading) = (option.get_id().as_str(), option.get_help_heading());
            let is_of_messages = matches!(name, "log_format" | "language");
            assert_eq!(
                heading == Some("Messages"),
                is_of_messages,
                "{} {name}: {heading:?}",
                inner.get_name()
            );
            if matches!(inner.get_name(), "serve" | "doctor") {
                let is_of_server =
                    name.ends_with("_port") || matches!(name, "bind" | "control" | "local");
                assert!(
                    !is_of_server || heading == Some("Ports and server"),
                    "{name}: {heading:?}"
                );
                assert!(
                    !name.starts_with("ros") || heading == Some("ROS 2"),
                    "{name}"
                );
                seen += usize::from(is_of_server);
            }
        }
    }
    assert!(seen > 20, "{seen}");
}

#[test]
fn a_replay_has_ports_only_when_it_serves() {
    for option in [
        "--bind ::1",
        "--primary-port 0",
        "--rtsi-port off",
        "--http-port 1",
        "--foxglove-port 8765",
        "--ready-file a",
    ] {
        let error = parse(&format!("eliteserver replay a.mcap {option}")).unwrap_err();
        assert!(error.to_string().contains("--serve"), "{option}: {error}");
        parse(&format!("eliteserver replay a.mcap --serve {option}")).unwrap();
    }
    let two = "eliteserver replay a.mcap --serve --rtsi-port 0 --http-port -1";
    assert!(parse(two).unwrap_err().to_string().contains("-1"));
    parse("eliteserver replay a.mcap --serve --rtsi-port 0 --http-port off").unwrap();
}

#[test]
fn no_command_means_serve_with_the_same_options() {
    for line in [
        "eliteserver --model cs63 --primary-port 0 --powered-off",
        "eliteserver serve --model cs63 --primary-port 0 --powered-off",
    ] {
        let args = serve_args(line);
        assert_eq!(
            args.shared.options.model,
            Some(ModelChoice::BuiltIn("cs63"))
        );
        assert_eq!(args.primary_port, Some(PortSetting::Any));
        assert_eq!(args.powered_off, Some(true));
        assert_eq!(args.local, None);
    }
}

#[test]
fn options_take_negative_numbers_both_ways() {
    let expected = [-0.3, -1.57, 1.57, -1.57, -1.57, 0.0];
    for line in [
        "eliteserver run x.script --home -0.3,-1.57,1.57,-1.57,-1.57,0",
        "eliteserver run --home=-0.3,-1.57,1.57,-1.57,-1.57,0 x.script",
    ] {
        let CliCommand::Run(args) = parse(line).unwrap() else {
            panic!("{line}")
        };
        assert_eq!(
            args.run.shared.options.home.unwrap().0.0,
            expected,
            "{line}"
        );
        assert_eq!(args.run.file, PathBuf::from("x.script"));
    }
    let args = serve_args("eliteserver --tcp -0.1,0,0,0,0,-3 --payload 1,-0.1,0,0");
    assert_eq!(args.shared.options.tcp.unwrap().0.xyz[0], -0.1);
    assert_eq!(args.shared.options.payload.unwrap().0.cog[0], -0.1);
}

#[test]
fn a_script_can_come_from_stdin() {
    let CliCommand::Run(args) = parse("eliteserver run -").unwrap() else {
        panic!()
    };
    assert_eq!(args.run.file, PathBuf::from("-"));
}

#[test]
fn allow_is_repeatable() {
    let args = serve_args("eliteserver --allow fs --allow net");
    assert_eq!(
        args.shared.options.allow,
        Some(vec![Permission::Fs, Permission::Net])
    );
}

#[test]
fn a_bad_value_names_option_value_and_what_is_allowed_and_exits_with_2() {
    for (line, words) in [
        ("eliteserver --step-ms 9", ["--step-ms", "'9'", "1 to 8"]),
        ("eliteserver --step-ms -1", ["--step-ms", "'-1'", "1 to 8"]),
        ("eliteserver --rtsi-port on", ["--rtsi-port", "'on'", "off"]),
        (
            "eliteserver run x --allow all",
            [
                "--allow",
                "'all'",
                "fs, fs=DIR, process, env, net and net=played",
            ],
        ),
        (
            "eliteserver --home --tcp",
            ["--home", "'--tcp'", "six joint positions"],
        ),
        (
            "eliteserver wait --timeout -1",
            ["--timeout", "'-1'", "0 to 86400"],
        ),
    ] {
        let error = parse(line).unwrap_err();
        assert_eq!(error.exit_code(), 2, "{line}");
        let text = error.to_string();
        for word in words {
            assert!(text.contains(word), "{line}: {text} lacks {word}");
        }
    }
}

#[test]
fn check_needs_a_file_and_replay_takes_one_question() {
    assert!(parse("eliteserver check").is_err());
    assert!(parse("eliteserver check a b --format json").is_ok());
    assert!(parse("eliteserver replay x.mcap --rerun --csv /cycle").is_err());
    assert!(parse("eliteserver replay x.mcap --serve --rate 2").is_ok());
    assert!(parse("eliteserver replay x.mcap --rate 2").is_err());
}
