//! What a person at a terminal sees: the shell's editing, completion and history, the line that follows a program, and
//! the question before a robot elsewhere moves. The terminal is a pseudo terminal.

use std::fs::File;
use std::io::{Read, Write};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use super::command;
use crate::common::{PATIENCE, Server, eliteserver};

/// A command at a terminal.
struct Terminal {
    keys: File,
    shown: Receiver<Vec<u8>>,
    /// Everything shown, and how much of it has been waited for.
    seen: (String, usize),
    child: Child,
}

impl Terminal {
    fn start(mut command: Command) -> Self {
        let pty = nix::pty::openpty(None, None).unwrap();
        let side = || Stdio::from(pty.slave.try_clone().unwrap());
        command.stdin(side()).stdout(side()).stderr(side());
        let child = command.env("TERM", "xterm").spawn().unwrap();
        drop((command, pty.slave));
        let keys = File::from(pty.master);
        let mut screen = keys.try_clone().unwrap();
        let (sender, shown) = channel();
        std::thread::spawn(move || {
            let mut piece = [0; 4096];
            // Ends with an error when nobody has the other side any more.
            while let Ok(count @ 1..) = screen.read(&mut piece) {
                if sender.send(piece[..count].to_vec()).is_err() {
                    return;
                }
            }
        });
        Self {
            keys,
            shown,
            seen: (String::new(), 0),
            child,
        }
    }

    fn types(&mut self, keys: &str) {
        self.keys.write_all(keys.as_bytes()).unwrap();
    }

    /// Waits until `text` is shown, behind what was waited for before.
    fn wait_for(&mut self, text: &str) {
        let begin = Instant::now();
        loop {
            let (all, done) = &mut self.seen;
            if let Some(at) = all[*done..].find(text) {
                *done += at + text.len();
                return;
            }
            assert!(
                begin.elapsed() < PATIENCE,
                "{text:?} in {:?}",
                &all[*done..]
            );
            if let Ok(piece) = self.shown.recv_timeout(Duration::from_millis(100)) {
                // What is waited for is ASCII.
                all.extend(piece.into_iter().map(char::from));
            }
        }
    }

    /// Types, waits for what is shown then, and for the next prompt: keys that come before it are not the editor's.
    fn dialogue(&mut self, dialogue: &[(&str, &str)]) {
        for (keys, shown) in dialogue {
            self.types(keys);
            self.wait_for(shown);
            let is_done = keys.ends_with(['\r', '\x03']);
            if is_done && !shown.ends_with("> ") && !shown.ends_with("... ") {
                self.wait_for("> ");
            }
        }
    }

    fn status(mut self) -> Option<i32> {
        self.child.wait().unwrap().code()
    }
}

#[test]
fn a_shell_edits_completes_remembers_and_begins_anew_after_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let mut shell = command(&server, "shell");
    shell.env("XDG_STATE_HOME", folder.path());
    let mut terminal = Terminal::start(shell);
    terminal.wait_for("interpreter mode of the robot");
    terminal.wait_for("> ");
    terminal.dialogue(&[
        ("x = 1\r", "ack 1\r\n"),
        // The rest of the name comes by itself; Ctrl-U wipes the line.
        ("get_target_tcp_po\t", "get_target_tcp_pose"),
        ("\x15def f(a):\r", "... "),
        ("  x = a\r", "... "),
        ("end\r", "ack 2\r\n"),
        ("y = f(\r", "discarded: Compile error:"),
        ("raise ValueError('boo')\r", "ValueError: boo"),
    ]);
    // The state that shows the end of the program comes a tenth of a second later.
    std::thread::sleep(Duration::from_millis(900));
    terminal.dialogue(&[
        ("x = 2\r", "a new one begins"),
        (":state\r", "program running"),
        // Ctrl-C stops the arm, and throws away an open block.
        ("\x03", "abort: "),
        ("if x:\r", "... "),
        ("\x03", "> "),
        // Two lines back.
        ("\x1b[A\x1b[A\x1b[A\r", "ack "),
        (":log 3\r", "ValueError: boo"),
        (":help\r", ":skip"),
    ]);
    terminal.types(":quit\r");
    // What was discarded counts in a pipe only.
    assert_eq!(terminal.status(), Some(0));
    let history = folder.path().join("eliteserver/shell_history");
    let history = std::fs::read_to_string(history).unwrap();
    assert!(history.contains("def f(a):\n  x = a\nend\n"), "{history}");
}

#[test]
fn a_program_that_is_sent_shows_its_speed_its_line_and_its_node() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(folder.path(), &[]);
    let file = folder.path().join("task.script");
    let text = "$ LINE: (3, \"Approach\")\nmovej([0.5, -1.2, 1.6, -1.9, -1.5, 0.4], a=1, v=0.5)\n\
                $ LINE: (4, \"Back\")\nsleep(1)\n1 / 0\n";
    std::fs::write(&file, text).unwrap();
    let mut send = command(&server, "send");
    send.arg(&file);
    let mut terminal = Terminal::start(send);
    terminal.wait_for("running, ");
    terminal.wait_for(" m/s, line 2, node 3 Approach");
    terminal.wait_for("line 4, node 4 Back");
    terminal.wait_for("ZeroDivisionError: division by zero");
    terminal.wait_for("task.script:5:");
    assert_eq!(terminal.status(), Some(1));
}

#[test]
fn a_person_is_asked_before_a_robot_elsewhere_moves() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("task.script");
    std::fs::write(&file, "pass\n").unwrap();
    // An address of documents (RFC 5737): nobody is there, and nobody is asked.
    for name in ["send", "shell"] {
        let mut asking = eliteserver();
        asking.args([name, "--robot", "192.0.2.7"]);
        if name == "send" {
            asking.arg(&file);
        }
        let mut terminal = Terminal::start(asking);
        terminal.wait_for("the robot at 192.0.2.7:30001? It may move. [y/N]");
        terminal.types("n\n");
        terminal.wait_for("nothing was sent");
        assert_eq!(terminal.status(), Some(2));
    }
}
