//! One main program at a time: a second one takes the place of the first, over the real ports, under both clocks.
//!
//! What must hold: every program that is sent begins, the one before ends and says who took its place, the arm comes to
//! rest before it moves again, and a hundred times in a row leave nothing behind.

#![allow(clippy::unwrap_used, reason = "a test helper fails by panicking")]

use std::io::{Read, Write};
use std::net::TcpListener;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::common::{Dashboard, PATIENCE, Server, read_recording};

const CLOCKS: [&str; 2] = ["virtual", "realtime"];

/// To and fro for ever.
const TO_AND_FRO: &str = "while True:\n    movej([2.5, -1.5708, 1.5708, -1.5708, -1.5708, 0], v=3, a=6)\n\
                          \x20   movej([-2.5, -1.5708, 1.5708, -1.5708, -1.5708, 0], v=3, a=6)\n  end";

/// A function whose thread waits for a person: meanwhile the virtual clock keeps wall pace.
const ASK: &str = "  def ask():\n    popup('?', blocking=True)\n  end\n  start_thread(ask, ())\n";

/// What the server has logged so far.
fn log(folder: &Path) -> String {
    std::fs::read_to_string(folder.join("stderr.log")).unwrap_or_default()
}

/// Waits until the log has `text`; how long that took.
fn wait_for_log(folder: &Path, text: &str) -> Duration {
    let started = Instant::now();
    while !log(folder).contains(text) {
        assert!(
            started.elapsed() < PATIENCE,
            "{text} is not in\n{}",
            log(folder)
        );
        std::thread::sleep(Duration::from_millis(1));
    }
    started.elapsed()
}

/// How many threads and open files a process has.
fn holds(process: u32) -> (usize, usize) {
    let count = |what: &str| {
        std::fs::read_dir(format!("/proc/{process}/{what}"))
            .unwrap()
            .count()
    };
    (count("task"), count("fd"))
}

/// Until a process holds no more than `most`.
fn wait_until_it_holds(process: u32, most: (usize, usize)) {
    let started = Instant::now();
    while holds(process).0 > most.0 || holds(process).1 > most.1 {
        assert!(
            started.elapsed() < PATIENCE,
            "{:?}, at first {most:?}",
            holds(process)
        );
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn a_hundred_programs_in_a_row_take_one_anothers_place() {
    for clock in CLOCKS {
        let folder = tempfile::tempdir().unwrap();
        let tasks = folder.path().join("tasks");
        std::fs::create_dir(&tasks).unwrap();
        let task = format!("def task():\n  textmsg('task begins')\n  {TO_AND_FRO}\nend\n");
        std::fs::write(tasks.join("a.task"), task).unwrap();
        let options = ["--clock", clock, "--record", "off", "--task-dir", "tasks"];
        let server = Server::start(folder.path(), &options);
        let mut dashboard = Dashboard::connect(&server);
        let mut primary = server.primary();
        assert!(dashboard.ask("task -p a.task").contains("a.task"));
        let mut before = (0, 0);
        for n in 0..100 {
            if n % 4 == 3 {
                // The dashboard's reply comes when the program runs.
                assert_eq!(dashboard.ask("play"), "Starting task");
            } else {
                // What blocks differs: a motion, a wait, a popup, a thread that computes.
                let wait = match n % 3 {
                    0 => TO_AND_FRO,
                    1 => "sleep(1e9)",
                    _ => "start_thread(spin, ())\n  popup('?', blocking=True)",
                };
                primary.send(&format!(
                    "def p{n}():\n  def spin():\n    while True:\n      pass\n    end\n  end\n  textmsg('run {n}.')\n\
                     \x20 {wait}\n  textmsg('not reached')\nend\n"
                ));
                // Every third is followed at once: it begins all the same.
                if n % 3 != 2 {
                    wait_for_log(folder.path(), &format!("run {n}."));
                }
            }
            if n == 3 {
                before = holds(server.process());
            }
        }
        wait_for_log(folder.path(), "run 98.");
        assert_eq!(dashboard.ask("stop"), "Stopping task");
        primary.wait_for("stopped", |state| !state.task_running);
        let log = log(folder.path());
        for n in (0..100).filter(|n| n % 4 != 3) {
            assert_eq!(log.matches(&format!("run {n}.")).count(), 1, "{n}\n{log}");
        }
        assert_eq!(log.matches("task begins").count(), 25, "{log}");
        assert_eq!(log.matches("takes its place").count(), 99, "{log}");
        assert_eq!(
            log.matches("\"a.task\" from the dashboard takes its place")
                .count(),
            25
        );
        assert!(
            log.contains("from 127.0.0.1:") && !log.contains("not reached"),
            "{log}"
        );
        // The last one, and the thread of its task, may take a moment to go.
        wait_until_it_holds(server.process(), before);
    }
}

#[test]
fn the_next_program_begins_while_the_arm_brakes_and_moves_once_it_has_come_to_rest() {
    for clock in CLOCKS {
        let folder = tempfile::tempdir().unwrap();
        let options = ["--clock", clock, "--record", "out.mcap", "--plant", "ideal"];
        let server = Server::start(folder.path(), &options);
        let mut primary = server.primary();
        let first = format!("def first():\n{ASK}  {TO_AND_FRO}\nend\n");
        // Every way to begin a motion waits for rest; what does not move does not wait.
        let motions = [
            "movej([0, -1.5708, 1.5708, -1.5708, -1.5708, 0], v=1)",
            "speedj([0, 0.2, 0, 0, 0, 0], 1, 0.2)",
            "servoj([q[0], q[1] + 0.0005, q[2], q[3], q[4], q[5]], t=0.02)",
            "freedrive_mode()\n  sync()\n  end_freedrive_mode()",
        ];
        for (n, motion) in motions.iter().enumerate() {
            primary.send(&first);
            primary.wait_for("moving", |s| s.target_q[0] > 0.3 && s.target_q[0] < 1.5);
            primary.send(&format!(
                "def second():\n  set_standard_digital_out({n}, True)\n  q = get_target_joint_positions()\n  {motion}\n\
                 \x20 textmsg('second {n} ends')\nend\n"
            ));
            wait_for_log(folder.path(), &format!("second {n} ends"));
            primary.send(
                "def home():\n  movej([0, -1.5708, 1.5708, -1.5708, -1.5708, 0])\n  textmsg('home')\nend\n",
            );
            primary.wait_for("home", |s| !s.task_running && s.target_q[0].abs() < 1e-6);
        }
        drop(primary);
        server.terminate();
        let recording = read_recording(&folder.path().join("out.mcap"));
        let cycles = &recording.cycles;
        for n in 0..motions.len() {
            let is_set = |c: &recorder::cycle::CycleMessage| c.digital_out >> n & 1 == 1;
            let at = cycles.iter().position(is_set).unwrap();
            let speed = |k: usize| {
                cycles[k]
                    .target_qd
                    .iter()
                    .fold(0.0, |most: f64, x| most.max(x.abs()))
            };
            assert!(
                speed(at) > 0.5,
                "motion {n}: it begins while the arm brakes: {}",
                speed(at)
            );
            // It brakes all the way: once its acceleration has turned round, the speed never grows before it is zero.
            let rest = (at..cycles.len()).find(|k| speed(*k) == 0.0).unwrap();
            for k in at..rest {
                let slows = speed(k + 1) <= speed(k) + 1e-9;
                assert!(slows || k < at + 20, "motion {n}, cycle {k} after {at}");
            }
            let braking = &cycles[at..rest];
            let is_still = braking.iter().all(|c| c.target_qd[1].abs() < 1e-9);
            assert!(is_still, "motion {n} began early");
        }
    }
}

#[test]
fn finally_blocks_run_within_their_bounds_and_a_wait_ends_them() {
    for clock in CLOCKS {
        let folder = tempfile::tempdir().unwrap();
        let server = Server::start(folder.path(), &["--clock", clock, "--record", "off"]);
        let mut primary = server.primary();
        let cases = [
            (
                "x = sum([k for k in range(1000)])\n    textmsg('cleaned up', n)",
                true,
            ),
            ("sleep(1000)\n    textmsg('cleaned up', n)", false),
            (
                "while True:\n      n = n\n    end\n    textmsg('cleaned up', n)",
                false,
            ),
            (
                "while True:\n      set_tcp([0, 0, 0.1, 0, 0, 0])\n    end\n    textmsg('cleaned up', n)",
                false,
            ),
            (
                "while True:\n      textmsg('again')\n    end\n    textmsg('cleaned up', n)",
                false,
            ),
            (
                "socket_open('192.0.2.1', 9, 's')\n    textmsg('cleaned up', n)",
                false,
            ),
        ];
        for (n, (clean_up, is_done)) in cases.iter().enumerate() {
            primary.send(&format!(
                "def first():\n  n = {n}\n  try:\n    textmsg('first {n} begins')\n    sleep(1e9)\n  finally:\n\
                 \x20   {clean_up}\n  end\nend\n"
            ));
            wait_for_log(folder.path(), &format!("first {n} begins"));
            primary.send(&format!(
                "def second():\n  textmsg('second {n} begins')\nend\n"
            ));
            let took = wait_for_log(folder.path(), &format!("second {n} begins"));
            // 0.6 s; the machine that tests this does much else.
            assert!(took < Duration::from_secs(2), "{clean_up}: {took:?}");
            primary.wait_for("stopped", |state| !state.task_running);
            let done = log(folder.path()).contains(&format!("cleaned up{n}"))
                || log(folder.path()).contains(&format!("cleaned up {n}"));
            assert_eq!(done, *is_done, "{clean_up}\n{}", log(folder.path()));
        }
    }
}

#[test]
fn held_programs_make_way_and_what_does_not_compile_or_is_secondary_does_not_ask_for_it() {
    for clock in CLOCKS {
        let folder = tempfile::tempdir().unwrap();
        let server = Server::start(folder.path(), &["--clock", clock, "--record", "off"]);
        let mut primary = server.primary();
        primary.send(&format!(
            "def first():\n  global n\n  n = 1\n{ASK}  textmsg('first begins')\n  {TO_AND_FRO}\nend\n"
        ));
        wait_for_log(folder.path(), "first begins");
        primary.send("def broken():\n  movej([\nend\nif True:\n");
        primary.send("sec beside():\n  textmsg('beside', n)\nend\n");
        assert!(primary.script_error().2.contains("SyntaxError"));
        assert!(primary.script_error().2.contains("SyntaxError"));
        wait_for_log(folder.path(), "beside");
        primary.wait_for("running", |state| state.task_running);
        primary.send("pause task\n");
        primary.wait_for("paused", |state| state.task_paused);
        primary.send(
            "def second():\n  textmsg('second begins')\n  q = get_target_joint_positions()\n\
                      \x20 q[1] = q[1] + 0.1\n  movej(q, v=1)\n  textmsg('second ends')\nend\n",
        );
        wait_for_log(folder.path(), "second ends");
        primary.wait_for("stopped", |state| !state.task_running);
        // A lone secondary program is let finish: it has something to set up.
        primary.send("sec alone():\n  for k in range(20000):\n    k = k\n  end\n  textmsg('alone ends')\nend\n\
                      def third():\n  textmsg('third begins')\nend\n");
        wait_for_log(folder.path(), "third begins");
        let log = log(folder.path());
        assert!(log.find("alone ends") < log.find("third begins"), "{log}");
        assert_eq!(log.matches("takes its place").count(), 1, "{log}");
    }
}

/// The SDK sends its script again when the first has not connected within half a second: the second takes over, with
/// connections of its own.
#[test]
fn a_control_script_that_is_sent_twice_closes_the_sockets_of_the_first() {
    for clock in CLOCKS {
        let folder = tempfile::tempdir().unwrap();
        let options = ["--clock", clock, "--record", "off", "--allow", "net"];
        let server = Server::start(folder.path(), &options);
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let script = format!(
            "def control():\n  socket_open('127.0.0.1', {port}, 'reverse')\n  while True:\n\
             \x20   n = socket_read_binary_integer(1, 'reverse', 0)\n    if n[0] == 0:\n      break\n    end\n\
             \x20   socket_send_int(n[1] + 1, 'reverse')\n  end\nend\n"
        );
        let mut primary = server.primary();
        primary.send(&script);
        let (mut first, _) = listener.accept().unwrap();
        std::thread::sleep(Duration::from_millis(500));
        primary.send(&script);
        let (mut second, _) = listener.accept().unwrap();
        first.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut rest = Vec::new();
        // Closed or reset: either says that the script is gone.
        let _ = first.read_to_end(&mut rest);
        assert!(rest.is_empty());
        second.set_read_timeout(Some(PATIENCE)).unwrap();
        second.write_all(&41_i32.to_be_bytes()).unwrap();
        let mut answer = [0; 4];
        second.read_exact(&mut answer).unwrap();
        assert_eq!(i32::from_be_bytes(answer), 42);
        assert!(log(folder.path()).contains("program \"control\" from 127.0.0.1:"));
    }
}
