//! Precedence, every key, and the sentence for every mistake.

#![allow(clippy::approx_constant, reason = "figures as documented")]

use super::*;
use std::collections::BTreeSet;

use controller::options::{ByteSize, Permission, PlantChoice, RotationLimit, StepMillis};
use recorder::RotationTrigger;

use crate::cli::{Cli, CliCommand};
use clap::Parser;

fn typed(line: &str) -> ServeArgs {
    match Cli::try_parse_from(line.split_whitespace())
        .unwrap()
        .into_command()
    {
        CliCommand::Serve(args) => *args,
        other => panic!("{other:?}"),
    }
}

fn serve(line: &str, toml: &str) -> Result<ServeConfig, ConfigError> {
    let mut args = typed(line);
    merge_file(&mut args, Path::new("e.toml"), toml, None)?;
    ServeConfig::load(args)
}

#[test]
fn defaults_are_those_of_the_contract() {
    let config = serve("eliteserver", "").unwrap();
    assert_eq!(config.robot.model, ModelChoice::BuiltIn("cs66"));
    assert_eq!(config.robot.clock, ClockChoice::Realtime);
    assert_eq!(config.robot.step, StepMillis::DEFAULT);
    assert_eq!(config.robot.plant, PlantChoice::Rigid);
    assert_eq!(config.robot.task_dir, PathBuf::from("tasks"));
    assert_eq!(
        config.robot.record,
        RecordTarget::NewFileIn("recordings".into())
    );
    assert_eq!(
        config.robot.home.0,
        [0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0]
    );
    assert_eq!(config.robot.seed, 0);
    assert_eq!(config.robot.allow, BTreeSet::from([Permission::Net]));
    assert_eq!(config.bind.to_string(), "127.0.0.1");
    assert_eq!(config.ports.primary, PortSetting::Number(30001));
    assert_eq!(config.ports.interpreter, PortSetting::Number(30020));
    assert_eq!(config.ports.rtsi, PortSetting::Number(30004));
    assert_eq!(config.ports.dashboard, PortSetting::Number(29999));
    assert_eq!(config.ports.modbus, PortSetting::Either(502, 5020));
    assert_eq!(config.ports.state, PortSetting::Number(30011));
    assert_eq!(config.ports.query, PortSetting::Number(40011));
    assert_eq!(config.ports.tool_serial, PortSetting::Off);
    assert_eq!(config.ports.http, PortSetting::Number(8080));
    assert!(!config.powered_off && config.control == ControlMode::Remote);

    let run = RunConfig::load(RunArgs {
        file: "x".into(),
        ..RunArgs::default()
    })
    .unwrap();
    assert_eq!(run.robot.clock, ClockChoice::Virtual);
    assert_eq!(run.robot.record, RecordTarget::Off);
}

#[test]
fn the_bag_beside_the_recording_of_a_run_is_off_unless_the_file_asks_for_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("e.toml");
    std::fs::write(&file, "ros2-profile = true").unwrap();
    let with = |config: Option<PathBuf>| {
        let shared = ControllerArgs {
            config,
            ..ControllerArgs::default()
        };
        let args = RunArgs {
            file: "x".into(),
            shared,
            ..RunArgs::default()
        };
        RunConfig::load(args).unwrap().ros2_profile
    };
    assert!(!with(None));
    assert!(with(Some(file)));
}

#[test]
fn a_flag_comes_before_the_file_and_the_file_before_the_default() {
    let config = serve(
        "eliteserver --model cs63 --primary-port off --allow fs --local=false",
        "model = 'cs620'\nstep-ms = 2\nprimary-port = 1\nhttp-port = 'off'\nallow = ['env', 'process']\nlocal = true",
    )
    .unwrap();
    assert_eq!(config.robot.model, ModelChoice::BuiltIn("cs63"));
    assert_eq!(config.robot.step.as_secs(), 0.002);
    assert_eq!(config.ports.primary, PortSetting::Off);
    assert_eq!(config.ports.http, PortSetting::Off);
    // Next to a primary port elsewhere.
    assert_eq!(config.ports.state, PortSetting::Any);
    assert_eq!(config.robot.allow, BTreeSet::from([Permission::Fs]));
    assert_eq!(config.control, ControlMode::Remote);
}

#[test]
fn folders_are_opened_to_programs_by_flag_and_by_key() {
    let folders = |names: &[&str]| names.iter().map(|n| Permission::FsIn(n.into())).collect();
    let by_flag = serve("eliteserver --allow fs=/data --allow fs=./a=b", "").unwrap();
    assert_eq!(by_flag.robot.allow, folders(&["./a=b", "/data"]));
    let by_key = serve("eliteserver", "allow = ['fs=/data']").unwrap();
    assert_eq!(by_key.robot.allow, folders(&["/data"]));
    let error = serve("eliteserver", "allow = ['fs=']").unwrap_err();
    assert!(error.to_string().contains("fs= needs a folder"), "{error}");
}

#[test]
fn every_key_is_read() {
    let text = r#"
        model = "./a.urdf"
        calibration = "arm.toml"
        cell = "cell.toml"
        clock = "virtual"
        ros2_profile = true
        step_ms = 8
        cycle-phase-us = 250
        plant = "ideal"
        task-dir = "/t"
        record = "out.mcap"
        record-rotate = "90min"
        record-budget = "20GB"
        tcp = [0, 0, 0.1, 0, 0, -1.5]
        payload = [2.5, 0, 0, 0.08]
        home = "-1,0,0,0,0,1"
        seed = 7
        allow = ["fs", "net"]
        log-dir = "logs"
        log-format = "json"
        language = "zh"
        bind = "0.0.0.0"
        primary-port = 0
        interpreter-port = "off"
        rtsi-port = "off"
        dashboard-port = "off"
        modbus-port = 502
        http-port = 80
        foxglove-port = "off"
        state-port = "off"
        query-port = 4001
        tool-serial-port = 54321
        control = "local"
        trust-host = ["cell-4.example", "192.0.2.7"]
        ready-file = "ready.json"
        powered-off = true
        attachable = true
        local = true

        [ros2]
        domain = 7
        namespace = "cell/left"
        tf_prefix = "left_"
        rate = 125
        peers = ["192.0.2.7", "192.0.2.8"]
        rmw = "cyclonedds"
        time-factor = 10
    "#;
    let (_folder, path) = calibration_of("./a.urdf");
    let written = text.replace("arm.toml", &path);
    let config = serve("eliteserver", &written).unwrap();
    let calibration = config.robot.calibration.unwrap();
    assert_eq!(calibration.modified_dh().d[5], 0.095);
    assert_eq!(config.robot.model, ModelChoice::Urdf("./a.urdf".into()));
    assert_eq!(config.robot.cell, Some("cell.toml".into()));
    assert_eq!(config.robot.clock, ClockChoice::Virtual);
    assert_eq!(config.robot.step.as_secs(), 0.008);
    assert_eq!(config.robot.plant, PlantChoice::Ideal);
    assert_eq!(config.robot.record, RecordTarget::File("out.mcap".into()));
    let rotate = config.robot.record_rotate;
    assert_eq!(rotate, Some(RotationLimit(RotationTrigger::Secs(5400.0))));
    let budget = config.robot.record_budget;
    assert_eq!(budget, Some(ByteSize(20_000_000_000)));
    assert_eq!(config.robot.tcp.to_array(), [0.0, 0.0, 0.1, 0.0, 0.0, -1.5]);
    assert_eq!(config.robot.payload.mass, 2.5);
    assert_eq!(config.robot.payload.cog.as_slice(), [0.0, 0.0, 0.08]);
    assert_eq!(config.robot.home.0[0], -1.0);
    assert_eq!(config.robot.seed, 7);
    assert_eq!(config.robot.allow.len(), 2);
    assert_eq!(config.log.dir, Some("logs".into()));
    assert_eq!(config.log.format, LogFormat::Json);
    assert_eq!(config.log.language, Some(TextLanguage::Zh));
    assert_eq!(config.bind.to_string(), "0.0.0.0");
    assert_eq!(config.ports.primary, PortSetting::Any);
    assert_eq!(config.ports.interpreter, PortSetting::Off);
    assert_eq!(config.ports.modbus, PortSetting::Number(502));
    assert_eq!(config.ports.state, PortSetting::Off);
    assert_eq!(config.ports.query, PortSetting::Number(4001));
    assert_eq!(config.ports.tool_serial, PortSetting::Number(54321));
    assert_eq!(config.trusted_hosts, ["cell-4.example", "192.0.2.7"]);
    assert_eq!(config.ready_file, Some("ready.json".into()));
    assert!(config.powered_off && config.attachable && config.control == ControlMode::Local);
    let ros2 = config.ros2.unwrap();
    assert_eq!((ros2.domain, ros2.rate), (7, Some(125.0)));
    assert_eq!((&*ros2.namespace, &*ros2.prefix), ("/cell/left", "left_"));
    assert!(matches!(ros2.network, RosNetwork::Peers(peers) if peers.len() == 2));
    assert_eq!(ros2.middleware, crate::cli::RosMiddleware::Cyclonedds);
    assert_eq!(ros2.time_factor, Some(10.0));
    for key in file::keys() {
        assert!(
            text.replace('_', "-").contains(&key),
            "{key} is not in this test"
        );
    }
}

/// A calibration file for a model; it is there as long as the folder.
fn calibration_of(model: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("arm.toml");
    let table = "[modified_dh]
        a = [0, 0, -0.427, -0.3905, 0, 0]
        d = [0.1625, 0, 0, 0.1475, 0.0965, 0.095]
        alpha = [0, 1.5708, 0, 0, 1.5708, -1.5708]";
    std::fs::write(&path, format!("model = '{model}'\n{table}")).unwrap();
    let path = path.to_str().unwrap().to_owned();
    (folder, path)
}

#[test]
fn the_model_of_a_calibration_counts_and_another_is_refused() {
    let (_folder, path) = calibration_of("cs63");
    let line = format!("eliteserver --calibration {path}");
    let config = serve(&line, "").unwrap();
    assert_eq!(config.robot.model, ModelChoice::BuiltIn("cs63"));
    assert!(serve(&format!("{line} --model CS63"), "").is_ok());
    let by_flag = serve(&format!("{line} --model cs66"), "").unwrap_err();
    let by_key = serve(&line, "model = 'cs66'").unwrap_err();
    for error in [by_flag, by_key] {
        let error = error.to_string();
        assert!(
            error.ends_with(
                "is for the model cs63, but the model cs66 is asked for; leave the model out, or give cs63"
            ),
            "{error}"
        );
    }
    let (_folder, path) = calibration_of("cs99");
    let error = serve(&format!("eliteserver --calibration {path}"), "").unwrap_err();
    let error = error.to_string();
    assert!(
        error.contains("arm.toml: `model` is \"cs99\"; allowed are cs63"),
        "{error}"
    );
    let error = serve("eliteserver --calibration /nowhere.toml", "").unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("cannot read the calibration file /nowhere.toml")
    );
}

#[test]
fn every_key_is_an_option() {
    let mut args = ServeArgs::default();
    for key in file::keys().iter().filter(|key| *key != "ros2") {
        assert!(args.slot(key).is_some(), "{key}");
    }
}

#[test]
fn each_mistake_has_one_sentence_with_key_value_and_what_is_allowed() {
    let sentence = |toml: &str| serve("eliteserver", toml).unwrap_err().to_string();
    insta::assert_snapshot!(
        [
            "modell = 'cs66'",
            "[robot]\nmodel = 'cs66'",
            "model = 'cs99'",
            "step-ms = 9",
            "step-ms = 2.5",
            "trust-host = 'http://a:80'",
            "step-ms = 4\nstep_ms = 4",
            "home = [0, 0, 0]",
            "home = ['a', 0, 0, 0, 0, 0]",
            "allow = ['all']",
            "seed = -1",
            "powered-off = 'yes'",
            "ros2-profile = 1",
            "bind = 'localhost'",
            "http-port = 30001",
            "foxglove-port = 8080",
            "model = \nx",
        ]
        .map(sentence)
        .join("\n")
    );
}

#[test]
fn a_mistake_in_the_file_is_reported_even_where_a_flag_was_typed() {
    assert!(serve("eliteserver --step-ms 2", "step-ms = 9").is_err());
}

#[test]
fn an_unreadable_file_is_named() {
    let error = ServeConfig::load(typed("eliteserver --config /nonexistent/e.toml")).unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("cannot read the configuration file /nonexistent/e.toml: "),
        "{error}"
    );
}

#[test]
fn an_empty_list_of_permissions_allows_nothing() {
    assert_eq!(
        serve("eliteserver", "allow = []").unwrap().robot.allow,
        BTreeSet::new()
    );
}

#[test]
fn control_is_named_in_one_way() {
    let control = |line: &str| serve(line, "").map(|config| config.control);
    assert_eq!(
        control("eliteserver --control mixed").unwrap(),
        ControlMode::Mixed
    );
    assert_eq!(
        control("eliteserver --control local --local").unwrap(),
        ControlMode::Local
    );
    assert_eq!(control("eliteserver --local").unwrap(), ControlMode::Local);
    let error = control("eliteserver --control mixed --local").unwrap_err();
    assert_eq!(
        error.to_string(),
        "--local and --control mixed contradict each other: leave one of them out"
    );
    let error = serve("eliteserver", "control = 'none'")
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("allowed are remote, local and mixed"),
        "{error}"
    );
}

#[test]
fn the_node_is_off_unless_asked_for_and_its_details_need_it() {
    let ros2 = |line: &str, toml: &str| serve(line, toml).map(|config| config.ros2);
    assert_eq!(ros2("eliteserver", "").unwrap(), None);
    assert_eq!(ros2("eliteserver", "ros2 = false").unwrap(), None);
    let off = "[ros2]\nenabled = false\nrate = 100";
    assert_eq!(ros2("eliteserver", off).unwrap(), None);
    for (line, toml) in [
        ("eliteserver --ros2 --ros-domain 3", ""),
        ("eliteserver --ros-domain 3", "ros2 = true"),
        ("eliteserver", "[ros2]\ndomain = 3"),
        ("eliteserver --ros2 --ros-domain 3", off),
    ] {
        let config = ros2(line, toml).unwrap().unwrap();
        assert_eq!((config.domain, &*config.namespace), (3, "/"));
        assert!(config.is_loopback_only());
    }
    let error = ros2("eliteserver --ros-rate 10", "").unwrap_err();
    assert!(error.to_string().contains("--ros-rate"), "{error}");
    for toml in [
        "[ros2]\ndomain = 233",
        "[ros2]\nrate = 0",
        "[ros2]\nnamespace = '1a'",
        "[ros2]\npeers = []",
        "[ros2]\nspeed = 1",
        "ros2 = 'maybe'",
    ] {
        let error = ros2("eliteserver", toml).unwrap_err().to_string();
        assert!(error.contains("ros"), "{error}");
    }
}
