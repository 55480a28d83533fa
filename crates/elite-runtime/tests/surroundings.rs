//! What programs reach beyond the robot once they are allowed to: files, processes, the environment, signals.
//!
//! The programs in `tests/surroundings` run under CPython in one empty folder and here in another one; both must print
//! the same.

#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot set itself up should stop"
)]

use crate::common;

use std::path::PathBuf;
use std::process::Command;
use std::time::{Duration, Instant};

use common::{Ran, Standing, run, run_while};
use elite_runtime::{FileAccess, NetworkAccess, Permissions, TaskEnd, TaskState};

/// An empty folder of one test.
fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("elite-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

fn allowed(text: &str) -> Ran {
    run(&permitted(), text)
}

/// An arm whose programs may do everything.
fn permitted() -> Standing {
    let permissions = Permissions {
        files: FileAccess::Everything,
        processes: true,
        environment: true,
        network: NetworkAccess::Everything,
    };
    Standing {
        permissions,
        ..Standing::default()
    }
}

/// Whether a process runs; one that nobody has waited for stays in the table as a zombie.
fn runs(process: u32) -> bool {
    std::fs::read_to_string(format!("/proc/{process}/stat"))
        .is_ok_and(|stat| !stat.contains(") Z "))
}

/// Runs a program in an empty folder, here and under CPython.
fn same_as_python(name: &str, text: &str) {
    let (ours, theirs) = (
        folder(&format!("{name}-ours")),
        folder(&format!("{name}-theirs")),
    );
    let script = theirs.with_extension("py");
    std::fs::write(&script, text).unwrap();
    let python = Command::new("python3")
        .args(["-W", "ignore"])
        .arg(&script)
        .current_dir(&theirs)
        .output()
        .unwrap();
    let expected = String::from_utf8(python.stdout).unwrap();
    let complaint = String::from_utf8_lossy(&python.stderr).into_owned();
    assert!(python.status.success(), "{name} under CPython: {complaint}");
    let ran = allowed(&format!(
        "import os\nos.chdir({:?})\n{text}",
        ours.to_str().unwrap()
    ));
    let _ = std::fs::remove_dir_all(&ours);
    let _ = std::fs::remove_dir_all(&theirs);
    let _ = std::fs::remove_file(&script);
    let lines = expected.lines().zip(ran.printed.lines()).enumerate();
    let differing = lines.filter(|(_, (theirs, ours))| theirs != ours);
    let shown = differing.map(|(n, (theirs, ours))| format!("{}: {theirs}\n   {ours}\n", n + 1));
    assert_eq!(shown.collect::<String>(), "", "{name}: lines that differ");
    assert_eq!(
        (ran.error.as_str(), ran.end),
        ("", TaskEnd::Finished),
        "{name}: {}",
        ran.printed
    );
    assert_eq!(expected, ran.printed, "{name}");
}

#[test]
fn text_files_behave_as_in_python() {
    same_as_python("text", include_str!("surroundings/text_files.py"));
}

#[test]
fn binary_files_behave_as_in_python() {
    same_as_python("binary", include_str!("surroundings/binary_files.py"));
}

#[test]
fn folders_and_paths_behave_as_in_python() {
    same_as_python("folders", include_str!("surroundings/folders.py"));
}

#[test]
fn processes_behave_as_in_python() {
    same_as_python("processes", include_str!("surroundings/processes.py"));
}

#[test]
fn signals_to_itself_behave_as_in_python() {
    same_as_python("signals", include_str!("surroundings/signals.py"));
}

#[test]
fn without_permission_calls_are_refused_when_they_are_made() {
    let text = "
import os, subprocess, signal, io
def refused(what):
    try:
        what()
        print('not refused')
    except PermissionError as e:
        print(e)
refused(lambda: open('x'))
refused(lambda: open('/rbctrl/EliRobot_share/program/points.txt'))
refused(lambda: os.listdir('.'))
refused(lambda: os.path.exists('/etc/passwd'))
refused(lambda: os.getcwd())
refused(lambda: os.getpid())
refused(lambda: os.environ['HOME'])
refused(lambda: os.environ.update(a='b'))
refused(lambda: subprocess.run(['true']))
refused(lambda: os.system('true'))
refused(lambda: signal.signal(signal.SIGINT, print))
refused(lambda: signal.alarm(1))
print(io.StringIO('kept').read(), signal.SIGTERM + 0, os.path.join('a', 'b'))
";
    let ran = run(&Standing::default(), text);
    let refusals = ran
        .printed
        .matches("start the controller with --allow")
        .count();
    assert_eq!((refusals, ran.error.as_str()), (12, ""), "{}", ran.printed);
    let of_files = "scripts may not use files; start the controller with --allow fs\n";
    assert!(
        ran.printed.starts_with(&of_files.repeat(2)),
        "{}",
        ran.printed
    );
    assert!(ran.printed.ends_with("kept 15 a/b\n"), "{}", ran.printed);
}

#[test]
fn a_process_that_outlives_its_program_is_killed_with_all_it_started() {
    let text = "import subprocess
p = subprocess.Popen('sleep 300 & echo $!; sleep 300', shell=True, stdout=subprocess.PIPE)
print(int(p.stdout.readline()))
";
    let ran = allowed(text);
    assert_eq!((ran.end, ran.error.as_str()), (TaskEnd::Finished, ""));
    let child: u32 = ran.printed.trim().parse().unwrap();
    let deadline = Instant::now() + Duration::from_secs(5);
    while runs(child) {
        assert!(Instant::now() < deadline, "process {child} lives on");
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn other_threads_go_on_while_one_waits_for_a_process() {
    let text = "
import subprocess, threading, time
ticks = []
def tick():
    while True:
        time.sleep(0.01)
        ticks.append(1)
threading.Thread(target=tick, daemon=True).start()
print(subprocess.run(['sleep', '0.3']).returncode, len(ticks) >= 10)
t = start_thread(lambda: subprocess.run(['sleep', '100']), ())
time.sleep(0.1)
begin = time.monotonic()
stop_thread(t)
join_thread(t)
print(time.monotonic() - begin < 0.1)
";
    let ran = allowed(text);
    assert_eq!(
        (ran.printed.as_str(), ran.error.as_str()),
        ("0 True\nTrue\n", "")
    );
}

/// Ways of a program to wait for a process that takes a minute; each prints the process's number first.
const WAITS: [&str; 3] = [
    "p = subprocess.Popen(['sleep', '60']); print(p.pid, 'waits'); p.wait()",
    "p = subprocess.Popen(['sleep', '60'], stdout=subprocess.PIPE); print(p.pid, 'waits'); p.stdout.read()",
    "p = subprocess.Popen(['sleep', '60'], stdin=subprocess.PIPE, stdout=subprocess.PIPE); print(p.pid, 'waits'); \
     p.communicate(b'x')",
];

#[test]
fn a_stop_reaches_a_program_that_waits_for_a_process() {
    for wait in WAITS {
        let text = format!(
            "import subprocess\ntry:\n    {wait}\nexcept BaseException: print('caught')\nfinally: print('cleaned')\n\
             print('after')\n"
        );
        let mut took = Duration::ZERO;
        let ran = run_while(&permitted(), &text, async |supervisor, printed| {
            printed.wait_for("waits").await;
            tokio::time::sleep(Duration::from_millis(30)).await;
            let begin = Instant::now();
            supervisor.stop();
            supervisor.ended().await;
            took = begin.elapsed();
        });
        assert_eq!(
            (ran.end, ran.error.as_str()),
            (TaskEnd::Stopped, ""),
            "{wait}"
        );
        assert!(took < Duration::from_millis(100), "{wait}: {took:?}");
        let (process, rest) = ran.printed.split_once(' ').unwrap();
        assert_eq!(rest, "waits\ncleaned\n", "{wait}");
        // The group is killed with the task; the system may take a moment.
        let deadline = Instant::now() + Duration::from_secs(5);
        while runs(process.parse().unwrap()) {
            assert!(
                Instant::now() < deadline,
                "{wait}: process {process} lives on"
            );
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

#[test]
fn a_stop_reaches_subprocess_run() {
    let text =
        "import subprocess\nprint('waits')\nsubprocess.run(['sleep', '60'])\nprint('after')\n";
    let mut took = Duration::ZERO;
    let ran = run_while(&permitted(), text, async |supervisor, printed| {
        printed.wait_for("waits").await;
        tokio::time::sleep(Duration::from_millis(50)).await;
        let begin = Instant::now();
        supervisor.stop();
        supervisor.ended().await;
        took = begin.elapsed();
    });
    assert_eq!(
        (ran.end, ran.printed.as_str()),
        (TaskEnd::Stopped, "waits\n")
    );
    assert!(took < Duration::from_millis(100), "{took:?}");
}

#[test]
fn a_pause_holds_a_program_that_waits_for_a_process() {
    let text =
        "import subprocess\nprint('waits')\nsubprocess.run(['sleep', '0.2'])\nprint('after')\n";
    let mut took = Duration::ZERO;
    let mut held = String::new();
    let ran = run_while(&permitted(), text, async |supervisor, printed| {
        printed.wait_for("waits").await;
        tokio::time::sleep(Duration::from_millis(30)).await;
        let begin = Instant::now();
        supervisor.pause();
        let mut status = supervisor.watch();
        let _ = status
            .wait_for(|status| status.state == TaskState::Paused)
            .await;
        took = begin.elapsed();
        // The process ends meanwhile; the program does not go on before it is let.
        tokio::time::sleep(Duration::from_millis(300)).await;
        held = printed.text();
        supervisor.resume();
    });
    assert!(took < Duration::from_millis(100), "{took:?}");
    assert_eq!(held, "waits\n");
    assert_eq!(
        (ran.end, ran.printed.as_str()),
        (TaskEnd::Finished, "waits\nafter\n")
    );
}

#[test]
fn no_more_is_read_than_the_task_may_hold() {
    let text = "
try:
    open('/dev/zero', 'rb').read(1 << 40)
except MemoryError as e:
    print(e)
print(len(open('/dev/zero', 'rb').read(10)))
";
    let ran = allowed(text);
    let expected = "the task would hold more than its 512 MiB of memory\n10\n";
    assert_eq!((ran.printed.as_str(), ran.error.as_str()), (expected, ""));
}

#[test]
fn what_waits_for_others_cannot_be_opened() {
    let folder = folder("fifo");
    let fifo = folder.join("fifo");
    nix::unistd::mkfifo(&fifo, nix::sys::stat::Mode::S_IRWXU).unwrap();
    let text = format!(
        "try: open({:?})\nexcept OSError as e: print(e)\n",
        fifo.to_str().unwrap()
    );
    let ran = allowed(&text);
    assert_eq!(
        ran.printed,
        "only regular files and character devices can be opened by scripts\n"
    );
    std::fs::remove_dir_all(&folder).unwrap();
}
