//! `eliteserver replay` on recordings of real cycles.
#![allow(clippy::unwrap_used, reason = "helpers of tests")]

use std::path::{Path, PathBuf};

use crate::common::recorder_config;
use clap::Parser;
use kinematics::{JointPositions, JointSpeeds, RobotModel};
use motion::{ControlLoop, CycleConfig, CycleTiming, LimitOverrides, PlantKind};
use motion_api::{
    CommandKind, MotionCommand, Origin, ProgramId, RingCapacities, ThreadNumber, motion_channel,
};
use recorder::{IoValue, LogLevel, Recorder, Setup};
use server::cli::{Cli, CliCommand};
use server::commands::replay::{ReplayError, answer};

const CYCLES: u64 = 600;
const PROGRAM: ProgramId = ProgramId(1);

/// Records a program of two movements on a controller with defaults and an ideal plant.
fn record(name: &str, setup: Setup) -> PathBuf {
    record_with(name, setup, ideal_config())
}

fn ideal_config() -> CycleConfig {
    CycleConfig {
        plant: PlantKind::Ideal,
        ..CycleConfig::new(RobotModel::built_in("cs66").unwrap())
    }
}

fn record_with(name: &str, setup: Setup, config: CycleConfig) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let model = config.model.clone();
    let (motion_end, mut script) = motion_channel(RingCapacities::default(), &config.first_state());
    let mut cycle = ControlLoop::new(config, motion_end).unwrap();
    let recorder_config = recorder_config(&path, setup, model);
    let records = script.records.take().unwrap();
    let (recorder, handle) = Recorder::start(recorder_config, records).unwrap();
    handle.program_started(0.0, PROGRAM, "dance.script", "movej(a)\nmovej(b)\n");
    let main = ThreadNumber(0);
    for number in 1..=CYCLES {
        let time = script.snapshot.read().time;
        let movement = match number {
            10 => Some((1, [0.4, -1.2, 1.3, -1.6, -1.5, 0.3])),
            320 => Some((2, [0.0, -1.5, 1.5, -1.5, -1.5, 0.0])),
            _ => None,
        };
        if let Some((line, target)) = movement {
            handle.script_line(time, PROGRAM, main, line);
            let origin = Origin {
                program: PROGRAM,
                thread: main,
                line,
            };
            let kind = CommandKind::Motion(MotionCommand::MoveJ {
                target: JointPositions(target),
                acceleration: 1.4,
                speed: 1.05,
                duration: 0.0,
                radius: 0.0,
            });
            script.commands.send(origin, kind).unwrap();
        }
        if number == 400 {
            let message = messages::Text::verbatim("ValueError: no\n  line 2");
            handle.log(time, LogLevel::Error, "dance.script", &message);
            handle.io(time, "output_float_register[3]", IoValue::Number(0.5));
        }
        cycle.tick(CycleTiming::default());
        while script.events.next_event().is_some() {}
    }
    drop(cycle);
    recorder.finish().unwrap();
    path
}

/// Exit status and output of `eliteserver replay PATH OPTIONS`.
fn replay(path: &Path, options: &str) -> Result<(u8, String), ReplayError> {
    let path = path.to_str().unwrap();
    let line = ["eliteserver", "replay", path].into_iter();
    let cli = Cli::try_parse_from(line.chain(options.split_whitespace())).unwrap();
    let CliCommand::Replay(args) = cli.into_command() else {
        panic!("not a replay");
    };
    let mut out = Vec::new();
    let status = answer(&args, &mut out)?.code();
    Ok((status, String::from_utf8(out).unwrap()))
}

#[test]
fn without_a_question_there_is_a_summary() {
    let path = record("summary.mcap", Setup::default());
    let (status, text) = replay(&path, "").unwrap();
    assert_eq!(status, 0);
    let text = text.replace(path.to_str().unwrap(), "FILE");
    let text = text.replace(env!("CARGO_PKG_VERSION"), "VERSION");
    insta::assert_snapshot!(text);
}

#[test]
fn a_recording_that_is_still_being_written_has_a_summary_too() {
    let path = record("cut.mcap", Setup::default());
    let bytes = std::fs::read(&path).unwrap();
    std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let (status, text) = replay(&path, "").unwrap();
    assert_eq!(status, 0);
    assert!(text.contains("missing: 0\n"), "{text}");
    assert!(text.contains("ending: cut"), "{text}");
}

#[test]
fn the_state_at_a_time_is_that_of_the_cycle_that_had_ended() {
    let path = record("at.mcap", Setup::default());
    let (status, text) = replay(&path, "--at 0.5").unwrap();
    assert_eq!(status, 0);
    for line in [
        "cycle: 125\n",
        "time: 0.500000 s\n",
        "script: dance.script line 1 (thread 0)\n",
        "command: 1 movej (dance.script line 1)\n",
        "mode: movej\n",
        "robot_mode: RUNNING\n",
        "safety_mode: NORMAL\n",
    ] {
        assert!(text.contains(line), "{line} is not in\n{text}");
    }
    let (_, before) = replay(&path, "--at 0.4999").unwrap();
    assert!(before.starts_with("cycle: 124\n"), "{before}");
    let (_, start) = replay(&path, "--at 0").unwrap();
    assert!(start.starts_with("cycle: 1\n"), "{start}");
    let (_, end) = replay(&path, "--at 2.4").unwrap();
    assert!(end.starts_with("cycle: 600\n"), "{end}");
    let error = replay(&path, "--at 2.5").unwrap_err().to_string();
    assert_eq!(
        error,
        "there is no state at 2.5 s: the recording covers 0.004 s to 2.400 s"
    );
}

#[test]
fn every_topic_is_a_table_with_one_header_line() {
    let path = record("csv.mcap", Setup::default());
    for (topic, column, rows) in [
        ("/cycle", "target_q_5", 600),
        ("/joint_states", "joints_0.name", 150),
        ("/tf", "transforms_7.child_frame_id", 150),
        ("/tcp", "pose.position.x", 150),
        // At the start, and while the arm moves ten times a second.
        ("/scene", "entities_2.cylinders_0.size.z", 23),
        ("/log", "message", 1),
        ("/script", "program", 3),
        ("/command", "arguments.target_5", 2),
        ("/io", "value", 1),
    ] {
        let (status, text) = replay(&path, &format!("--csv {topic}")).unwrap();
        assert_eq!(status, 0);
        let header = text.lines().next().unwrap();
        let has_column = header.split(',').any(|name| name == column);
        assert!(has_column, "{topic}: {header}");
        assert_eq!(records(&text), rows + 1, "{topic}");
    }
    let (_, log) = replay(&path, "--csv log").unwrap();
    assert!(log.contains("\"ValueError: no\n  line 2\""), "{log}");
    let error = replay(&path, "--csv /ghost").unwrap_err().to_string();
    assert!(error.starts_with("there is no topic /ghost in the recording; it has /command"));
}

/// Lines of a CSV text, but for those that end within quotes.
fn records(text: &str) -> usize {
    let mut quoted = false;
    let ends = text.chars().filter(|&c| {
        quoted ^= c == '"';
        c == '\n' && !quoted
    });
    ends.count()
}

#[test]
fn the_picture_is_a_png_of_the_promised_size() {
    let path = record("plot.mcap", Setup::default());
    let picture = path.with_extension("png");
    let (status, _) = replay(&path, &format!("--plot {}", picture.display())).unwrap();
    assert_eq!(status, 0);
    let picture = tiny_skia::Pixmap::load_png(&picture).unwrap();
    assert_eq!((picture.width(), picture.height()), (1600, 1500));
    // The blue of the first joint's curves is there.
    let is_blue =
        |p: &&tiny_skia::PremultipliedColorU8| (p.red(), p.green(), p.blue()) == (34, 0, 255);
    let blue = picture.pixels().iter().filter(is_blue).count();
    assert!(blue > 1000, "{blue} pixels of the first joint's curves");
}

#[test]
fn a_picture_that_cannot_be_written_is_an_error() {
    let path = record("noplot.mcap", Setup::default());
    let error = replay(&path, "--plot /proc/nowhere.png").unwrap_err();
    let text = error.to_string();
    assert!(
        text.starts_with("cannot write the picture /proc/nowhere.png"),
        "{text}"
    );
}

#[test]
fn the_same_commands_give_the_same_cycles() {
    let path = record("rerun.mcap", Setup::default());
    let (status, text) = replay(&path, "--rerun").unwrap();
    assert_eq!(
        (status, text.lines().next()),
        (0, Some("identical: 600 cycles"))
    );
}

#[test]
fn rigid_bodies_come_out_the_same_too() {
    let setup = Setup {
        plant: "rigid".to_owned(),
        ..Setup::default()
    };
    let config = CycleConfig::new(RobotModel::built_in("cs66").unwrap());
    let path = record_with("rigid.mcap", setup, config);
    let (status, text) = replay(&path, "--rerun").unwrap();
    assert_eq!(
        (status, text.lines().next()),
        (0, Some("identical: 600 cycles"))
    );
}

#[test]
fn the_limits_of_the_cell_hold_when_it_is_run_again() {
    let slow = [0.2; 6];
    let with_limits = Setup {
        cell: Some(format!("[limits]\njoint_speed = {slow:?}\n")),
        ..Setup::default()
    };
    let mut config = ideal_config();
    config.limits.joint_speed = Some(JointSpeeds(slow));
    let path = record_with("limits.mcap", with_limits, config.clone());
    let (status, text) = replay(&path, "--rerun").unwrap();
    assert_eq!(
        (status, text.lines().next()),
        (0, Some("identical: 600 cycles"))
    );
    // The same cycles, but the recording says nothing of limits: the rerun is faster.
    let path = record_with("nolimits.mcap", Setup::default(), config);
    assert_eq!(replay(&path, "--rerun").unwrap().0, 1);
}

#[test]
fn another_payload_shows_as_the_first_cycle_that_differs() {
    let mut setup = Setup::default();
    // The controller was in fact started without it.
    setup.payload.mass = 1.5;
    let path = record("differs.mcap", setup);
    let (status, text) = replay(&path, "--rerun").unwrap();
    assert_eq!(status, 1);
    assert!(text.starts_with("first difference at cycle 1: "), "{text}");
    assert!(text.contains("payload[0] 0 and 1.5 (by 1.5e0)"), "{text}");
}

#[test]
fn what_cannot_be_answered_is_said_by_name() {
    let plant = Setup {
        plant: "soft".to_owned(),
        ..Setup::default()
    };
    let path = record("plant.mcap", plant);
    let error = replay(&path, "--rerun").unwrap_err().to_string();
    assert!(error.contains("no plant \"soft\""), "{error}");
    let cell = Setup {
        cell: Some("[limits]\njoint_sped = 1\n".to_owned()),
        ..Setup::default()
    };
    let path = record("cell.mcap", cell);
    let error = replay(&path, "--rerun").unwrap_err().to_string();
    assert!(error.contains("joint_sped"), "{error}");
    let error = replay(Path::new("/nowhere.mcap"), "").unwrap_err();
    assert!(
        error.to_string().contains("cannot read /nowhere.mcap"),
        "{error}"
    );
}

#[test]
fn find_says_when_where_and_in_which_line() {
    let path = record("find.mcap", Setup::default());
    let find = |condition: &str| {
        let args = [
            "eliteserver",
            "replay",
            path.to_str().unwrap(),
            "--find",
            condition,
        ];
        let CliCommand::Replay(args) = Cli::try_parse_from(args).unwrap().into_command() else {
            panic!("not a replay");
        };
        let mut out = Vec::new();
        answer(&args, &mut out).map(|_| String::from_utf8(out).unwrap())
    };
    insta::assert_snapshot!(find("mode == movej and abs(actual_qd[0]) > 0.4").unwrap());
    assert_eq!(
        find("safety_mode != normal").unwrap(),
        "found: 0 times, 0 of 600 cycles\n"
    );
    let error = find("safty_mode != normal").unwrap_err().to_string();
    assert!(error.contains("safety_mode"), "{error}");
}

#[test]
fn script_shows_the_program_with_its_times() {
    let path = record("script.mcap", Setup::default());
    insta::assert_snapshot!(replay(&path, "--script").unwrap().1);
}

#[test]
fn script_counts_the_rounds_of_loops_over_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let program = "\
def p():
    for k in range(5):
        sleep(0.1)
    end
    k = 0
    while k < 4: k = k + 1; sleep(0.052)
    for k in range(50):
        sync()
    end
    sleep(0.1); sleep(0.1)
    for k in range(3): movej([0.02 * k, -1.57, 1.57, -1.57, -1.57, 0])
    sleep(0.1)
end
";
    std::fs::write(folder.path().join("rounds.script"), program).unwrap();
    let run = crate::common::eliteserver()
        .args(["run", "rounds.script", "--record", "rounds.mcap"])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert!(run.status.success(), "{run:?}");
    let table = replay(&folder.path().join("rounds.mcap"), "--script")
        .unwrap()
        .1;
    let times = |number: &str| {
        let row = table
            .lines()
            .find(|row| row[40..].trim_start().starts_with(number));
        row.and_then(|row| row[21..29].trim().parse::<u32>().ok())
    };
    let found = ["3 ", "6 ", "8 ", "10 ", "11 ", "12 "].map(times);
    assert_eq!(found, [5, 4, 50, 1, 3, 1].map(Some), "{table}");
}

#[test]
fn diff_finds_the_first_and_the_largest_difference_of_two_runs() {
    let one = record("one.mcap", Setup::default());
    let same = record("same.mcap", Setup::default());
    let slow = CycleConfig {
        limits: LimitOverrides {
            joint_speed: Some(JointSpeeds([0.5; 6])),
            ..LimitOverrides::default()
        },
        ..ideal_config()
    };
    let other = record_with("other.mcap", Setup::default(), slow);
    let diff = |a: &Path, b: &Path| replay(a, &format!("--diff {}", b.display())).unwrap();
    assert_eq!(
        diff(&one, &same),
        (0, "identical: 600 cycles".to_owned() + "\n")
    );
    let (status, text) = diff(&one, &other);
    assert_eq!(status, 1);
    assert!(
        text.starts_with("first difference at cycle 99 (0.396 s): target_q[0]"),
        "{text}"
    );
    assert!(text.contains("\n  target_q: up to "), "{text}");
    let bytes = std::fs::read(&one).unwrap();
    let cut = one.with_file_name("diff_cut.mcap");
    std::fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let (status, text) = diff(&one, &cut);
    assert_eq!(status, 1);
    assert!(text.starts_with("only in "), "{text}");
}
