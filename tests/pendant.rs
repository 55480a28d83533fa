//! Programs in the shape in which the pendant writes them (`tests/pendant`), through the real binary: `check` finds
//! nothing, they run, and the recording tells node by node where their threads were. Comments at the beginning of a
//! program say what is expected of it; `NAME.toml` beside it is its cell.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "helpers fail by panicking"
)]

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};

use crate::common::{PATIENCE, Recording, Server, eliteserver, read_recording};

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/pendant")
}

/// What the comments of a program say under this word.
fn expected<'t>(text: &'t str, word: &str) -> Vec<&'t str> {
    let lines = text.lines().filter_map(|line| line.strip_prefix("# "));
    let values = lines.filter_map(|line| line.strip_prefix(word)?.strip_prefix(": "));
    values.collect()
}

/// The nodes that a thread was in, one after the other, and whether each has the label of its directive.
fn nodes(recording: &Recording, text: &str, thread: u64) -> Vec<String> {
    let mut nodes: Vec<String> = Vec::new();
    for message in &recording.json["/script"] {
        if message["thread"] != thread {
            continue;
        }
        let line = message["line"].as_u64().unwrap();
        assert!(
            (1..=text.lines().count() as u64).contains(&line),
            "{message}"
        );
        let Some(node) = message["node"].as_u64() else {
            continue;
        };
        let label = message["label"].as_str().unwrap();
        assert!(
            text.contains(&format!("$ LINE: ({node}, \"{label}\"")),
            "{message}"
        );
        let node = node.to_string();
        if nodes.last() != Some(&node) {
            nodes.push(node);
        }
    }
    nodes
}

/// Checks, runs and records a program.
fn follow(name: &str) {
    let script = folder().join(format!("{name}.script"));
    let text = std::fs::read_to_string(&script).unwrap();
    let checked = eliteserver().arg("check").arg(&script).output().unwrap();
    let found = String::from_utf8_lossy(&checked.stdout).into_owned();
    assert_eq!(
        (found.as_str(), checked.status.code()),
        ("", Some(0)),
        "{name}"
    );

    let temporary = tempfile::tempdir().unwrap();
    let recorded = temporary.path().join("run.mcap");
    let mut command = eliteserver();
    command
        .arg("run")
        .arg(&script)
        .arg("--record")
        .arg(&recorded);
    let cell = folder().join(format!("{name}.toml"));
    if cell.exists() {
        command.arg("--cell").arg(cell);
    }
    let ran = command.current_dir(temporary.path()).output().unwrap();
    let (out, err) = (
        String::from_utf8_lossy(&ran.stdout).into_owned(),
        String::from_utf8_lossy(&ran.stderr).into_owned(),
    );
    let error = expected(&text, "error");
    let is_failure = !error.is_empty() || !expected(&text, "status").is_empty();
    let status = i32::from(is_failure);
    assert_eq!(ran.status.code(), Some(status), "{name}: {err}");
    assert_eq!(
        out.lines().collect::<Vec<_>>(),
        expected(&text, "prints"),
        "{name}"
    );
    assert!(
        error.iter().all(|error| err.trim_end().ends_with(error)),
        "{err}"
    );

    for says in expected(&text, "says") {
        assert!(err.lines().any(|line| line.ends_with(says)), "{err}");
    }

    let recording = read_recording(&recorded);
    for (word, thread) in [("nodes", 0), ("thread 1", 1)] {
        let wanted: Vec<&str> = expected(&text, word)
            .into_iter()
            .flat_map(|list| list.split(' '))
            .collect();
        assert_eq!(nodes(&recording, &text, thread), wanted, "{name}, {word}");
    }
    let replay = |option: &[&str]| {
        let output = eliteserver()
            .arg("replay")
            .arg(&recorded)
            .args(option)
            .output()
            .unwrap();
        assert_eq!(output.status.code(), Some(0), "{name}");
        String::from_utf8(output.stdout).unwrap()
    };
    let table = replay(&["--script"]);
    let last = expected(&text, "nodes")
        .into_iter()
        .flat_map(|list| list.split(' '))
        .last()
        .unwrap();
    let end = recording.cycles.last().unwrap().time.to_string();
    let moment = replay(&["--at", &end]);
    let place = moment
        .lines()
        .find(|line| line.starts_with("script: "))
        .unwrap_or_default();
    assert!(
        place.contains(", node ") && place.contains("(thread 0)"),
        "{moment}"
    );
    let of_last = |line: &str| line.split_whitespace().nth(4) == Some(last);
    assert!(table.lines().rev().take(20).any(of_last), "{table}");
    for (error, node) in error.iter().zip(expected(&text, "error node")) {
        assert!(err.contains(&format!("\n  in node {node}\n")), "{err}");
        let summary = replay(&[]);
        let line = summary
            .lines()
            .find(|line| line.contains(error))
            .unwrap_or(&summary);
        let place = format!("{error} (");
        assert!(
            line.contains(&place) && line.contains(&format!("; in node {node})")),
            "{line}"
        );
    }
}

/// A test for each program, and one that none is left out.
macro_rules! programs {
    ($($name:ident),* $(,)?) => {
        $(
            #[test]
            fn $name() {
                follow(stringify!($name));
            }
        )*

        #[test]
        fn every_program_has_a_test() {
            let mut there: Vec<String> = std::fs::read_dir(folder())
                .unwrap()
                .filter_map(|entry| {
                    let name = entry.unwrap().file_name().into_string().unwrap();
                    name.strip_suffix(".script").map(str::to_owned)
                })
                .collect();
            there.sort();
            assert_eq!(there, [$(stringify!($name)),*]);
        }
    };
}

programs!(
    choose,
    conveyor_pick,
    fails,
    frames,
    gripper_plugin,
    machine_tending,
    palletise,
    polish,
    screws,
    stopped,
    vision,
    waits,
    waypoints,
    weld_corners,
    weld_weave,
);

const XML: &str =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<EliTask name=\"weld.1\"><MainTask/></EliTask>\n";
const SENT: &str = "def weld():
  $ LINE: (2, \"主任务\")
  $ LINE: (3, \"等待\")
  while True:
    sleep(0.01)
  end
end
";

#[test]
fn a_task_of_the_pendant_is_the_program_beside_its_xml() {
    let temporary = tempfile::tempdir().unwrap();
    let tasks = temporary.path().join("tasks");
    std::fs::create_dir(&tasks).unwrap();
    std::fs::write(tasks.join("weld.1.task"), XML).unwrap();
    std::fs::write(tasks.join("weld.1.task.script"), SENT).unwrap();
    std::fs::write(tasks.join("alone.task"), XML).unwrap();
    let server = Server::start(temporary.path(), &[]);
    let stream = TcpStream::connect(("127.0.0.1", server.ports["dashboard"])).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    let mut lines = BufReader::new(stream.try_clone().unwrap());
    let mut reply = || {
        let mut line = String::new();
        lines.read_line(&mut line).unwrap();
        line.trim_end().to_owned()
    };
    let hello = [(); 4].map(|()| reply());
    assert!(hello[0].contains("ashboard"), "{hello:?}");
    let mut ask = |order: &str| {
        (&stream)
            .write_all(format!("{order}\n").as_bytes())
            .unwrap();
        reply()
    };
    let refused = ask("task -p alone.task");
    assert!(
        refused.contains("alone.task.script") && refused.contains("not beside it"),
        "{refused}"
    );
    let loaded = ask("task -p weld.1.task");
    assert!(loaded.contains("weld.1.task"), "{loaded}");
    ask("play");
    let panel = || -> serde_json::Value { serde_json::from_str(&server.page("/panel").1).unwrap() };
    let started = std::time::Instant::now();
    while panel()["node"] != 3 {
        assert!(started.elapsed() < PATIENCE, "{}", panel());
        std::thread::sleep(std::time::Duration::from_millis(10));
    }
    let shown = panel();
    assert_eq!(
        (&shown["label"], &shown["line"]),
        (&"等待".into(), &5.into())
    );
    ask("stop");
    assert_eq!(server.terminate().code(), Some(0));
}

#[test]
fn clients_of_the_primary_port_are_told_the_node_of_an_error() {
    let temporary = tempfile::tempdir().unwrap();
    let server = Server::start(temporary.path(), &["--clock", "virtual"]);
    let mut primary = server.primary();
    let program = "$ LINE: (1, \"根\")\ndef t():\n  $ LINE: (2, \"主任务\")\n  sync()\n  $ LINE: (7, \"接近点\", \"after\")\n\
                   \x20 movej([9, 9])\nend\n";
    primary.send(program);
    let (line, _, report) = primary.script_error();
    // The text of the program begins with its header.
    assert_eq!(line, 5, "{report}");
    assert!(report.contains("\n  in node 7 接近点\n"), "{report}");
    primary.send("def t():\n  $ LINE: (\"a\", 2)\n  sync()\nend\n");
    let (line, column, report) = primary.script_error();
    assert_eq!((line, column), (2, 12), "{report}");
    assert!(report.contains("must be a whole number from 1"), "{report}");
    assert_eq!(server.terminate().code(), Some(0));
}

#[test]
fn run_and_check_take_a_task_of_the_pendant() {
    let temporary = tempfile::tempdir().unwrap();
    let task = temporary.path().join("a.b.task");
    std::fs::write(&task, XML).unwrap();
    let run = |command: &str| {
        let output = eliteserver().arg(command).arg(&task).output().unwrap();
        let text = [output.stdout, output.stderr].concat();
        (
            output.status.code(),
            String::from_utf8_lossy(&text).into_owned(),
        )
    };
    for command in ["run", "check"] {
        let (status, said) = run(command);
        assert_eq!(status, Some(2), "{said}");
        assert!(
            said.contains("a.b.task.script, the program that it sends, is not beside it"),
            "{said}"
        );
    }
    let script = temporary.path().join("a.b.task.script");
    std::fs::write(
        &script,
        "def a():\n  $ LINE: (2, \"打印\")\n  print(\"ran\")\n  x = 1 / 0\nend\n",
    )
    .unwrap();
    let (status, said) = run("run");
    assert_eq!(status, Some(1), "{said}");
    assert!(
        said.starts_with("ran\n") && said.contains("a.b.task.script, line 4, column 7"),
        "{said}"
    );
    assert!(
        said.contains("\n  in node 2 打印\nZeroDivisionError: division by zero\n"),
        "{said}"
    );
    std::fs::write(
        &script,
        "def a():\n  $ LINE: (0, \"打印\")\n  print(1)\nend\n",
    )
    .unwrap();
    let (status, said) = run("check");
    assert_eq!(status, Some(1), "{said}");
    assert!(said.contains("a.b.task.script:2:12"), "{said}");
}
